//! Time, memory and words that files and settings may cost: a second or two, half a gigabyte, a screen.

use std::fs::{self, File};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use flate2::Compression;
use flate2::write::GzEncoder;
use tempfile::TempDir;

const MOST_TIME: Duration = Duration::from_secs(2);
const MOST_KB: u64 = 500_000;
const MOST_WORDS: usize = 100_000;

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("studies").join(name)
}

/// Highest resident memory of a process in kB so far; 0 where the system does not tell.
fn peak_kb(process: u32) -> u64 {
    let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.split_whitespace().next()?.parse().ok()).unwrap_or(0)
}

/// Processor time of a process so far, in hundredths of a second as Linux tells it; none where the system does not.
fn processor_time(process: u32) -> Duration {
    let stat = fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
    let after = stat.rsplit_once(')').map_or("", |(_, after)| after);
    let ticks: u64 = after.split_whitespace().skip(11).take(2).filter_map(|ticks| ticks.parse::<u64>().ok()).sum();
    Duration::from_millis(10 * ticks)
}

/// Runs the program, which refuses within the bounds; returns what it says.
fn refused(arguments: &[&str], folder: &Path) -> String {
    ended(arguments, folder, 2)
}

/// Runs the program, which ends within the bounds and with this exit code; returns what it says.
fn ended(arguments: &[&str], folder: &Path, code: i32) -> String {
    let log = folder.join("words");
    let mut command = Command::new(env!("CARGO_BIN_EXE_decore"));
    command.args(arguments).current_dir(folder).stdin(Stdio::null()).stdout(Stdio::null());
    let mut child = command.stderr(File::create(&log).expect("log")).spawn().expect("decore runs");
    let shown: Vec<String> = arguments.iter().map(|argument| argument.chars().take(60).collect()).collect();
    let begin = Instant::now();
    let (mut peak, mut time) = (0, Duration::ZERO);
    let status = loop {
        peak = peak_kb(child.id()).max(peak);
        time = processor_time(child.id()).max(time);
        if peak > MOST_KB || time > MOST_TIME || begin.elapsed() > 30 * MOST_TIME {
            child.kill().expect("killed");
            panic!("{shown:?}: {peak} kB, {time:?} of {:?}", begin.elapsed());
        }
        if let Some(status) = child.try_wait().expect("known") {
            break status;
        }
        std::thread::sleep(Duration::from_millis(3));
    };
    let words = fs::read_to_string(&log).expect("words");
    let beginning: String = words.chars().take(2000).collect();
    assert_eq!(status.code(), Some(code), "{shown:?}: {beginning}");
    assert!(words.len() <= MOST_WORDS, "{shown:?}: {} bytes of words: {beginning}", words.len());
    words
}

/// Checks a study of this text.
fn check(text: &str) -> String {
    let scratch = TempDir::new().expect("scratch folder");
    fs::write(scratch.path().join("study.toml"), text).expect("study");
    refused(&["check", "study.toml"], scratch.path())
}

/// Checks the shipped study with settings.
fn check_with(settings: &[&str]) -> String {
    let scratch = TempDir::new().expect("scratch folder");
    let study = shipped("placement.toml");
    let mut arguments = vec!["check", study.to_str().expect("path")];
    arguments.extend(settings.iter().flat_map(|setting| ["--set", setting]));
    refused(&arguments, scratch.path())
}

/// Checks the shipped study with another design of its factors.
fn check_design(keys: &str) -> String {
    let scratch = TempDir::new().expect("scratch folder");
    fs::create_dir(scratch.path().join("hammers")).expect("folder");
    fs::copy(shipped("hammers/default.toml"), scratch.path().join("hammers/default.toml")).expect("hammer");
    let study = fs::read_to_string(shipped("placement.toml")).expect("study");
    let (before, design) = study.split_once("[design]").expect("design");
    let (_, factors) = design.split_once("[design.factor").expect("factors");
    let text = format!("{before}[design]\n{keys}\n[design.factor{factors}");
    fs::write(scratch.path().join("study.toml"), text).expect("study");
    refused(&["check", "study.toml"], scratch.path())
}

/// Checks a machine with this stiffness file.
fn check_matrix(bytes: &[u8]) -> String {
    let scratch = TempDir::new().expect("scratch folder");
    fs::write(scratch.path().join("k.mtx"), bytes).expect("matrix");
    check_files(&scratch.path().join("k.mtx"), &shipped("../src/assets/station/interface_points.csv"))
}

fn check_files(matrix: &Path, points: &Path) -> String {
    let scratch = TempDir::new().expect("scratch folder");
    let (matrix, points) = (matrix.display(), points.display());
    let text = format!(
        "[structure]\nsource = \"matrices\"\nstiffness_file = '{matrix}'\nmass_file = '{matrix}'\npoints_file = '{points}'\n"
    );
    fs::write(scratch.path().join("machine.toml"), text).expect("structure");
    refused(&["structure", "machine.toml"], scratch.path())
}

#[test]
fn malformed_studies_take_the_time_of_their_length() {
    let mut many = vec![
        "a b c\n".repeat(80_000),
        "a = = 1\n".repeat(60_000),
        "[".repeat(480_000),
        "a = ".to_owned() + &"[".repeat(480_000),
        "a.".repeat(240_000) + "b = 1",
        "a = \"\\q".repeat(60_000),
        "[a]\n".repeat(120_000),
        "'\n".repeat(240_000),
        "a = 1 b ".repeat(60_000),
        "a = 99999999999999999999\n".to_owned() + "[x]\nb = 99999999999999999999\n",
        "a = {".repeat(100_000),
        "{a=1,".repeat(90_000),
    ];
    many.push((0..60_000).map(|index| format!("k{index} = 1\n")).collect());
    many.push((0..30_000).map(|index| format!("[k{index}]\nx = 1\n")).collect());
    many.push((0..20_000).map(|index| format!("[hammer.h{index}]\nx = 1\n")).collect());
    many.push((0..20_000).map(|index| format!("[design.factor.f{index}]\npath = \"x{index}\"\n")).collect());
    many.push((0..60_000).map(|index| format!("k{index} = 99999999999999999999\n")).collect());
    for text in many {
        check(&text);
    }
    let large = check(&"# comment\n".repeat(500_000));
    assert!(large.contains("more than 4 MB"), "{large}");
}

#[test]
fn long_names_are_not_compared_and_long_lines_not_echoed() {
    let name = "n".repeat(100_000);
    assert!(check(&format!("{name} = 1\n")).contains("unknown key"));
    assert!(check(&format!("[design]\nkind = \"{name}\"\n")).contains("expected: one of"));
    // The operating system bounds an argument's length.
    check_with(&[&format!("{name}=1")]);
    check_with(&[&format!("hammer.hammer.mount={name}")]);
    check_with(&[&format!("design.factor.pressure.path={name}.{name}")[..120_000]]);
    let line = check(&format!("title = \"{name}\" = 1\n"));
    assert!(line.lines().all(|line| line.chars().count() < 300), "{line}");
}

#[test]
fn matrices_take_memory_only_for_bytes() {
    let header = "%%MatrixMarket matrix coordinate real general\n";
    for order in [300_000_000_u64, 2_000_000_000, u64::MAX] {
        let text = check_matrix(format!("{header}{order} {order} 1\n1 1 1.0\n").as_bytes());
        assert!(text.contains("rows") || text.contains("expected"), "{text}");
    }
    check_matrix(format!("{header}3 3 {}\n1 1 1.0\n", u64::MAX).as_bytes());
    for (byte, found) in [(0_u8, "a byte 0"), (b'\n', "a million empty lines"), (b'1', "a million characters")] {
        let mut packed = GzEncoder::new(Vec::new(), Compression::best());
        let block = vec![byte; 1 << 20];
        packed.write_all(format!("{header}2 2 3\n").as_bytes()).expect("memory");
        for _ in 0..1500 {
            packed.write_all(&block).expect("memory");
        }
        let text = check_matrix(&packed.finish().expect("memory"));
        assert!(text.contains(found), "{text}");
    }
    let mut packed = GzEncoder::new(Vec::new(), Compression::best());
    packed.write_all(format!("{header}9 9 900000000\n").as_bytes()).expect("memory");
    let block = "1 1 0\n".repeat(1 << 18);
    for _ in 0..100 {
        packed.write_all(block.as_bytes()).expect("memory");
    }
    let text = check_matrix(&packed.finish().expect("memory"));
    assert!(text.contains("100 times"), "{text}");
    let text = check_matrix(format!("{header}{}\n", "1 ".repeat(400_000)).as_bytes());
    assert!(text.len() < 5000, "{} bytes", text.len());
}

#[cfg(unix)]
#[test]
fn devices_are_read_to_a_limit() {
    let zero = Path::new("/dev/zero");
    let scratch = TempDir::new().expect("scratch folder");
    for arguments in [["check", "/dev/zero"], ["structure", "/dev/zero"]] {
        assert!(refused(&arguments, scratch.path()).contains("more than 4 MB"));
    }
    assert!(check_with(&["hammer.hammer.file=/dev/zero"]).contains("more than 4 MB"));
    let (good, points) =
        (shipped("../src/assets/station/K.mtx.gz"), shipped("../src/assets/station/interface_points.csv"));
    assert!(check_files(zero, &points).contains("no file /dev/zero"));
    assert!(check_files(&good, zero).contains("no file /dev/zero"));
    assert!(check_design("kind = \"table\"\nfile = \"/dev/zero\"").contains("more than 64 MB"));
}

#[test]
fn work_is_estimated_before_it_starts() {
    let rows = "design.rows=1000000000000";
    for kind in ["sobol", "halton", "random", "latin_hypercube"] {
        let text = check_with(&[&format!("design.kind={kind}"), rows]);
        assert!(text.contains("more than 100000000 rows"), "{text}");
    }
    for (keys, words) in [
        ("kind = \"morris\"\ntrajectories = 4000000000", "more than 100000000 rows"),
        ("kind = \"saltelli\"\nbase_points = 4000000000", "more than 100000000 rows"),
        ("kind = \"box_behnken\"\ncentre_points = 4000000000", "1000000 at most"),
        ("kind = \"central_composite\"\ncentre_points = 4000000000", "1000000 at most"),
        ("kind = \"latin_hypercube\"\nrows = 90000000\ngrown_from = [45000000]", "kept in memory"),
    ] {
        let text = check_design(keys);
        assert!(text.contains(words), "{keys}: {text}");
    }
    let study = shipped("placement.toml");
    let scratch = TempDir::new().expect("scratch folder");
    let scene = ["scene", study.to_str().expect("path"), "--signals", "s.parquet", "--signal-interval-s", "1e-12"];
    assert!(refused(&scene, scratch.path()).contains("GB"));
}

/// The budget ends it, and warnings tell that the duration is odd.
#[test]
fn a_row_without_end_meets_its_budget() {
    let study = shipped("paper_rig.toml");
    let scratch = TempDir::new().expect("scratch folder");
    let settings = ["--set", "duration_s=1e308", "--set", "solver.max_steps=500"];
    let scene = [&["scene", study.to_str().expect("path")], &settings[..]].concat();
    let text = ended(&scene, scratch.path(), 4);
    assert!(text.contains("1e308 s is unusual"), "{text}");
}

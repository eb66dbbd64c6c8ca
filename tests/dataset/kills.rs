//! Commands that run rows, judge them and add more: killed and stopped at random moments, repeated, held to the bytes of one that
//! nothing disturbed.

use std::cell::Cell as Counter;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use decore_dataset::{DatasetReader, TableName, verify};
use decore_quantity::Cell;
use tempfile::TempDir;

use crate::growth::MACHINE;
#[cfg(unix)]
use crate::sweeps::signal;
use crate::sweeps::{contract, decore, errors, expect_code, output, was_killed};

/// Variable that sets how many times each command is interrupted.
const INTERRUPTIONS: &str = "DECORE_INTERRUPTIONS";
/// Interruptions of a command before it is left alone to its end.
const AT_A_TIME: u32 = 3;
/// One interruption in this many is a SIGTERM, the others are SIGKILL.
const TERMINATED: u64 = 4;
/// Exit code of a command that was stopped by a signal.
const STOPPED: i32 = 5;

/// A command that goes on where it was interrupted.
struct Course {
    name: &'static str,
    /// Makes what the command begins with, in this folder.
    prepare: fn(&Path),
    /// The command there.
    command: fn(&Path) -> Command,
    /// Other files than the dataset `out` that it writes.
    beside: &'static [&'static str],
}

/// Numbers that look random, from a linear congruential generator.
struct Random(Counter<u64>);

impl Random {
    fn below(&self, limit: u64) -> u64 {
        self.0.set(self.0.get().wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407));
        (self.0.get() >> 33) % limit
    }
}

/// How often a command was interrupted, and how.
#[derive(Default)]
struct Tally {
    kills: u64,
    stops: u64,
    /// Interruptions that came when the command had ended.
    late: u64,
}

impl Course {
    /// Interrupts the command until it was interrupted often enough, and compares each time that it comes to its end.
    fn hold(&self) {
        let wanted = std::env::var(INTERRUPTIONS).ok().and_then(|text| text.parse().ok()).unwrap_or(4);
        let scratch = TempDir::new().expect("scratch folder");
        let [begin, whole] = ["begin", "whole"].map(|name| scratch.path().join(name));
        fs::create_dir(&begin).expect("folder");
        (self.prepare)(&begin);
        copy(&begin, &whole);
        let begun = Instant::now();
        let undisturbed = output((self.command)(&whole));
        let duration = begun.elapsed();
        let code = undisturbed.status.code().expect("ends by itself");
        assert!(matches!(code, 0 | 4), "{}: {}", self.name, errors(&undisturbed));
        let expected = self.results(&whole);
        assert!(expected != self.results(&begin), "{}: the command changes something", self.name);
        let seed = self.name.bytes().fold(11_u64, |seed, byte| seed.wrapping_mul(31).wrapping_add(u64::from(byte)));
        let (random, mut tally) = (Random(Counter::new(seed)), Tally::default());
        for trial in 0..4 * wanted + 10 {
            if tally.kills + tally.stops >= wanted {
                break;
            }
            let place = scratch.path().join("disturbed");
            let _ = fs::remove_dir_all(&place);
            copy(&begin, &place);
            let told = self.disturb(&place, (&random, duration), &mut tally);
            let ended = output((self.command)(&place));
            let told = format!("{} {trial}:\n{told}{}", self.name, errors(&ended));
            assert_eq!(ended.status.code(), Some(code), "{told}");
            for (name, bytes) in self.results(&place) {
                assert!(expected.get(&name) == Some(&bytes), "{} differs; {told}", name.display());
            }
            self.expect_whole(&place, &told);
        }
        let Tally { kills, stops, late } = tally;
        println!("{}: {kills} kills and {stops} SIGTERMs left no trace; {late} came too late", self.name);
        assert!(kills + stops >= wanted, "{}: only {kills} kills, {stops} stops", self.name);
    }

    /// Interrupts the command a few times; returns what it wrote to standard error.
    fn disturb(&self, place: &Path, (random, duration): (&Random, Duration), tally: &mut Tally) -> String {
        let mut told = String::new();
        for _ in 0..AT_A_TIME {
            let mut command = (self.command)(place);
            let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("starts");
            let moment = duration.mul_f64(1.1 * random.below(1000) as f64 / 1000.0);
            sleep(moment);
            match random.below(TERMINATED) {
                #[cfg(unix)]
                0 => signal("TERM", child.id()),
                _ => child.kill().expect("killed"),
            }
            let ended = child.wait_with_output().expect("ended");
            told += &format!("-- {:.0} ms: {}\n{}", 1e3 * moment.as_secs_f64(), ended.status, errors(&ended));
            match ended.status.code() {
                Some(STOPPED) => tally.stops += 1,
                _ if was_killed(ended.status) || ended.status.code().is_none() => tally.kills += 1,
                _ => {
                    tally.late += 1;
                    break;
                }
            }
        }
        told
    }

    /// The bytes that must not depend on what happened.
    fn results(&self, place: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
        let folder = place.join("out");
        let mut found = if folder.exists() { contract(&folder) } else { BTreeMap::new() };
        found.extend(self.beside.iter().map(|name| (name.into(), fs::read(place.join(name)).expect("file"))));
        found
    }

    /// Nothing was lost on the way, and nothing is left of it.
    fn expect_whole(&self, place: &Path, told: &str) {
        let folder = place.join("out");
        assert_eq!(verify(&folder).expect("verified").faults, Vec::<String>::new(), "{told}");
        let hidden = [".journal", ".growing", ".staging", ".damaged", ".replaced"].map(|name| folder.join(name));
        assert!(!hidden.iter().any(|path| path.exists()), "{told}");
        assert!(!told.contains("lost") && !told.contains("amaged"), "{told}");
        let reader = DatasetReader::open(&folder).expect("dataset");
        let mut untimed = 0;
        let count = |cells: &[Cell<'_>]| untimed += u32::from(cells[0].is_none());
        reader.visit(TableName::Timings, &["wall_time_s"], count).expect("read");
        assert_eq!(untimed, 0, "{told}");
    }
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("folder");
    for entry in fs::read_dir(from).expect("folder").flatten() {
        let (path, target) = (entry.path(), to.join(entry.file_name()));
        if path.is_dir() {
            copy(&path, &target);
        } else {
            fs::copy(&path, &target).expect("copied");
        }
    }
}

/// Two factors that are numbers.
const FACTORS: &str = r#"
[design.factor.position]
path = "hammer.left.rail_position_m"
range = [-0.05, 0.05]
[design.factor.pressure]
path = "hammer.left.supply_bar"
range = [4.0, 6.0]
"#;

/// Writes a study of short rows with this design.
fn study(place: &Path, design: &str) {
    let text = format!("duration_s = 0.02\n{MACHINE}\n[solver]\nfidelity = \"draft\"\n[design]\n{design}\n{FACTORS}");
    fs::write(place.join("study.toml"), text).expect("study");
}

/// `decore VERB study.toml --output out` with further arguments.
fn of_study(place: &Path, verb: &str, arguments: &[&str]) -> Command {
    let mut command = decore();
    command.current_dir(place).args([verb, "study.toml", "--output", "out"]).args(arguments);
    command
}

fn analyse(place: &Path, arguments: &[&str]) -> Command {
    let mut command = decore();
    command.current_dir(place).args(["analyse", "out", "--study", "study.toml", "--output", "total_air_used_nl"]);
    command.args(["--bootstrap", "50", "--json"]).args(arguments);
    command
}

/// Runs the study in `out` with a budget of steps that about half of its rows exceed.
fn run_with_few_steps(place: &Path) {
    expect_code(of_study(place, "run", &[]), 0);
    let mut steps = Vec::new();
    let number = |cell: &Cell<'_>| cell.and_then(|value| value.number()).expect("a number") as u64;
    let reader = DatasetReader::open(&place.join("out")).expect("dataset");
    let names = ["solver_steps", "solver_rejected_steps"];
    reader.visit(TableName::Runs, &names, |cells| steps.push(cells.iter().map(number).sum::<u64>())).expect("read");
    steps.sort_unstable();
    fs::remove_dir_all(place.join("out")).expect("removed");
    let few = format!("solver.max_steps={}", steps[steps.len() / 2]);
    expect_code(of_study(place, "run", &["--set", &few]), 4);
}

const ENOUGH_STEPS: [&str; 2] = ["--set", "solver.max_steps=1000000"];

#[test]
fn a_run() {
    let command = |place: &Path| of_study(place, "run", &["--stub-row-ms", "2", "--threads", "2"]);
    let prepare = |place: &Path| study(place, "kind = 'sobol'\nrows = 300");
    Course { name: "run", prepare, command, beside: &[] }.hold();
}

#[test]
fn a_growth_of_a_study() {
    let prepare = |place: &Path| {
        study(place, "kind = 'sobol'\nrows = 200");
        expect_code(of_study(place, "run", &["--stub-row-ms", "0"]), 0);
        study(place, "kind = 'sobol'\nrows = 500");
    };
    let command = |place: &Path| of_study(place, "run", &["--stub-row-ms", "2", "--threads", "2"]);
    Course { name: "growth of a study", prepare, command, beside: &[] }.hold();
}

#[test]
fn a_repair() {
    let prepare = |place: &Path| {
        study(place, "kind = 'sobol'\nrows = 72");
        run_with_few_steps(place);
    };
    let command = |place: &Path| of_study(place, "run", &[&["--only-failed"], &ENOUGH_STEPS[..]].concat());
    Course { name: "run --only-failed", prepare, command, beside: &[] }.hold();
}

#[test]
fn a_growth_for_an_analysis() {
    let prepare = |place: &Path| {
        study(place, "kind = 'saltelli'\nbase_points = 2");
        expect_code(of_study(place, "run", &[]), 0);
    };
    let command = |place: &Path| analyse(place, &["--grow-until", "0.0001", "--most-rows", "128"]);
    Course { name: "analyse --grow-until", prepare, command, beside: &[] }.hold();
}

#[test]
fn a_repair_and_a_growth_for_an_analysis() {
    let prepare = |place: &Path| {
        study(place, "kind = 'saltelli'\nbase_points = 2");
        run_with_few_steps(place);
    };
    let command = |place: &Path| {
        let arguments = ["--repair", "--grow-until", "0.0001", "--most-rows", "32"];
        analyse(place, &[&arguments[..], &ENOUGH_STEPS].concat())
    };
    Course { name: "analyse --repair --grow-until", prepare, command, beside: &[] }.hold();
}

#[test]
fn a_refinement() {
    let prepare = |place: &Path| {
        study(place, "kind = 'latin_hypercube'\nrows = 8");
        let mut design = decore();
        design.current_dir(place).args(["design", "study.toml", "--output", "rows.csv"]);
        expect_code(design, 0);
        study(place, "kind = 'table'\nfile = 'rows.csv'");
    };
    let command = |place: &Path| {
        let arguments = ["--maximise", "total_air_used_nl", "--batch", "4", "--most-rows", "16", "--json"];
        of_study(place, "refine", &arguments)
    };
    Course { name: "refine", prepare, command, beside: &["rows.csv"] }.hold();
}

#[test]
fn a_merge() {
    const SHARDS: [&str; 3] = ["1/3", "2/3", "3/3"];
    let prepare = |place: &Path| {
        study(place, "kind = 'sobol'\nrows = 2000");
        for shard in SHARDS {
            let mut command = decore();
            command.current_dir(place).args(["run", "study.toml", "--stub-row-ms", "0", "--shard", shard, "--output"]);
            command.arg(shard.replace('/', "-of-"));
            let ended = output(command);
            assert!(matches!(ended.status.code(), Some(0 | 4)), "{}", errors(&ended));
        }
    };
    let command = |place: &Path| {
        let mut command = decore();
        command.current_dir(place).arg("merge").args(SHARDS.map(|shard| shard.replace('/', "-of-")));
        command.args(["--output", "out"]);
        command
    };
    Course { name: "merge", prepare, command, beside: &[] }.hold();
}

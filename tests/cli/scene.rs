//! `decore scene`: the page of a row, a row of a dataset run again.

use std::fs;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::read::ZlibDecoder;
use serde_json::Value as Json;
use tempfile::TempDir;

const QUICK: [&str; 4] = ["--set", "solver.guide=tied", "--set", "duration_s=0.15"];

fn study(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("studies").join(name)
}

/// Runs the program in a folder; returns its output, which must have ended with this code.
fn decore(folder: &Path, arguments: &[&str], code: i32) -> Output {
    let output =
        Command::new(env!("CARGO_BIN_EXE_decore")).args(arguments).current_dir(folder).output().expect("started");
    assert_eq!(output.status.code(), Some(code), "{arguments:?}\n{}", String::from_utf8_lossy(&output.stderr));
    output
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// The text of the page's element with this `id`.
fn block<'a>(page: &'a str, id: &str) -> &'a str {
    let start = page.split_once(&format!("id=\"{id}\">")).expect("element").1;
    start.split_once("</script>").expect("its end").0
}

#[test]
fn a_page_depends_on_study_and_row_alone() {
    let scratch = TempDir::new().expect("scratch folder");
    let title = "title=</script><b>\"Größe\" 锤</b>";
    let rig = study("paper_rig.toml");
    let of = |file: &str, further: &[&str]| {
        let mut arguments = vec!["scene", rig.to_str().expect("path"), "--set", title, "--html", file];
        arguments.extend(QUICK.iter().chain(further));
        decore(scratch.path(), &arguments, 0);
        fs::read_to_string(scratch.path().join(file)).expect("page")
    };
    let page = of("one.html", &[]);
    assert_eq!(page, of("other name.html", &["--plot", "beside.svg"]));
    assert!(!page.contains(scratch.path().to_str().expect("path")), "the page names a folder of this machine");
    assert!(!page.contains("<b>\"Größe") && page.contains("&lt;b&gt;") && page.contains("\\u003cb>"));
    for loads in ["http:", "https:", "src=", "url(", "@import", "fetch(", "XMLHttpRequest", "<link"] {
        assert!(!page.replace("http://www.w3.org/2000/svg", "").contains(loads), "{loads}");
    }
    // All signals but time, four bytes a value, and spectra behind them.
    let meta: Json = serde_json::from_str(block(&page, "meta")).expect("JSON");
    let samples = meta["samples"].as_u64().expect("samples") as usize;
    assert!((7500..=7501).contains(&samples), "0.15 s every 20 us: {samples}");
    let mut data = Vec::new();
    let packed = STANDARD.decode(block(&page, "data")).expect("base64");
    ZlibDecoder::new(packed.as_slice()).read_to_end(&mut data).expect("inflated");
    let signals = meta["signals"].as_array().expect("signals");
    let spectra = meta["spectra"].as_array().expect("spectra");
    let last = spectra.last().expect("a spectrum");
    let end = last["offset"].as_u64().expect("offset") + 4 * last["count"].as_u64().expect("count");
    assert!(data.len() as u64 == end && data.len() > 4 * samples * signals.len());
    // 0.0025 s of the first impact's casting would have lines 400 Hz apart; phases are those of the paper.
    let phases: Vec<&str> = spectra.iter().filter_map(|lines| lines["phase"].as_str()).collect();
    assert_eq!(&phases[..3], ["extension", "first impact", "hammering"], "no periodic blow within 0.15 s");
}

/// The data of the page of a shipped study over a short time.
fn page_data(name: &str, further: &[&str]) -> Json {
    let (scratch, file) = (TempDir::new().expect("scratch folder"), study(name));
    let arguments = ["scene", file.to_str().expect("path"), "--html", "row.html"];
    decore(scratch.path(), &[&arguments, &QUICK[..], further].concat(), 0);
    let page = fs::read_to_string(scratch.path().join("row.html")).expect("page");
    serde_json::from_str(block(&page, "meta")).expect("JSON")
}

/// Places are those of the study: castings with outline, fixtures of each kind, cores; rail, mounts and interface points of the machine.
#[test]
fn a_page_has_the_places_of_its_scene() {
    let meta = page_data("cores.toml", &["--set", "casting.head.measuring_point_m=[0.05, 0.1]"]);
    let casting = &meta["castings"][0];
    let places =
        |of: &Json| of.as_array().expect("places").iter().map(|at| at.as_f64().expect("m")).collect::<Vec<_>>();
    let (centre, x, y) = (places(&casting["centre_m"]), &casting["outline_m"][0], &casting["outline_m"][1]);
    for (axis, (ends, size)) in [(x, 0.20), (y, 0.36)].into_iter().enumerate() {
        let ends = places(ends);
        assert!((ends[1] - ends[0] - size).abs() < 1e-12, "{ends:?}");
        assert!((ends[0] + ends[1] - 2.0 * centre[axis]).abs() < 1e-12, "{ends:?}");
    }
    let fixtures = casting["fixtures"].as_array().expect("fixtures");
    let kinds: Vec<&str> = fixtures.iter().filter_map(|fixture| fixture["kind"].as_str()).collect();
    assert_eq!(kinds, ["pad", "pad", "pad", "pad", "clamp", "clamp"]);
    assert_eq!(places(&casting["measured_m"]), [0.05, 0.1, 0.0]);
    assert_eq!(casting["cores"][0]["name"], "left_end");
    assert_eq!(places(&casting["cores"][0]["at"]), [0.0, -0.15, 0.0]);
    assert_eq!(casting["axes"], serde_json::json!([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]));
    // Hammers stand above the points that they strike, where the factors of the row place them on the rail.
    let mounts = [0, 1].map(|hammer| places(&meta["hammers"][hammer]["mount_m"]));
    let factor = |at: usize| meta["factors"][at][1].as_str().and_then(|text| text.parse::<f64>().ok()).expect("m");
    let apart = factor(0) - factor(1);
    assert!(apart > 0.04 && (mounts[1][1] - mounts[0][1] - apart).abs() < 1e-12, "{mounts:?}, not {apart} m apart");
    for (hammer, mount) in mounts.iter().enumerate() {
        let strike = places(&meta["hammers"][hammer]["strike_m"]);
        assert!((0..2).all(|axis| (centre[axis] + strike[axis] - mount[axis]).abs() < 1e-12), "{strike:?} {mount:?}");
    }
    assert!(meta["rails"][0]["at"].as_array().expect("rail").len() > 1);
    let held = casting["held"].as_array().expect("held");
    let points: Vec<&Json> =
        meta["machine_points"].as_array().expect("points").iter().map(|point| &point["name"]).collect();
    assert!(held.iter().all(|held| points.contains(&&held["point"])), "{points:?}");
    let kinds = |name: &str| page_data(name, &[])["castings"][0]["fixtures"][0]["kind"].clone();
    assert_eq!(kinds("paper_rig.toml"), "spring");
}

/// Displacements of points of rigid castings follow from heave and rotations: the page leaves them out.
#[test]
fn a_page_leaves_out_what_follows() {
    let stored = |further: &[&str]| {
        let meta = page_data("paper_rig.toml", further);
        let signals = meta["signals"].as_array().expect("signals").clone();
        let names = signals.iter().filter_map(|signal| signal["quantity"].as_str().map(str::to_owned));
        names.filter(|name| name.ends_with("casting_displacement_m") || name == "heave_m").collect::<Vec<_>>()
    };
    assert_eq!(stored(&[]), ["heave_m"]);
}

/// The paper's rig over a short time with further arguments, run in a folder.
fn quick_rig(folder: &Path, further: &[&str], code: i32) -> Output {
    let rig = study("paper_rig.toml");
    decore(folder, &[&["scene", rig.to_str().expect("path")], &QUICK[..], further].concat(), code)
}

/// Signals that are written have an interval of their own.
#[test]
fn what_is_drawn_does_not_depend_on_signals_written_beside_it() {
    let scratch = TempDir::new().expect("scratch folder");
    let scene = |further: &[&str], code: i32| quick_rig(scratch.path(), further, code);
    let drawn = |further: &[&str]| {
        scene(&[&["--plot", "row.svg", "--html", "row.html", "--replace"], further].concat(), 0);
        ["row.svg", "row.html"].map(|file| fs::read_to_string(scratch.path().join(file)).expect("drawn"))
    };
    let alone = drawn(&[]);
    let written = |further: &[&str]| {
        let beside = drawn(&[&["--signals", "signals.parquet"], further].concat());
        assert!(alone == beside, "{further:?}");
        fs::metadata(scratch.path().join("signals.parquet")).expect("signals").len()
    };
    let (default, coarse) = (written(&[]), written(&["--signal-interval-s", "1e-3"]));
    assert!(default > 4 * coarse, "{default} and {coarse} bytes");
    // An interval without signals would have no effect.
    let said = text(&scene(&["--plot", "row.svg", "--signal-interval-s", "1e-3"], 2).stderr);
    assert!(said.contains("--signals <FILE>"), "{said}");
}

#[test]
fn a_page_that_cannot_be_written_names_its_own_path() {
    let scratch = TempDir::new().expect("scratch folder");
    let rig = study("paper_rig.toml");
    let mut arguments = vec!["scene", rig.to_str().expect("path"), "--html", "nowhere/page.html"];
    arguments.extend(QUICK);
    let said = text(&decore(scratch.path(), &arguments, 3).stderr);
    assert!(said.contains("nowhere") && !said.contains(".partial"), "{said}");
    arguments[3] = "page.txt";
    let said = text(&decore(scratch.path(), &arguments, 2).stderr);
    assert!(said.contains("a file name that ends in `.html`"), "{said}");
}

#[test]
fn a_stored_row_is_run_again_and_compared() {
    let scratch = TempDir::new().expect("scratch folder");
    let grid = study("pressure_grid.toml");
    let mut arguments = vec!["run", grid.to_str().expect("path"), "--output", "out"];
    arguments.extend(QUICK);
    decore(scratch.path(), &arguments, 0);
    // Its hammer file is beside the study, not beside the dataset: the dataset keeps the text.
    let again = |further: &[&str]| {
        let mut arguments = vec!["scene", "out", "--row", "2"];
        arguments.extend(further);
        decore(scratch.path(), &arguments, 0)
    };
    let html = again(&["--html", "row.html"]);
    let said = text(&html.stdout);
    assert!(said.contains("row 2: done") && said.contains("the same as the stored row: "), "{said}");
    assert!(!text(&html.stderr).contains("not as when"), "{}", text(&html.stderr));
    let mut arguments = vec!["scene", grid.to_str().expect("path"), "--row", "2", "--html", "fresh.html"];
    arguments.extend(QUICK);
    decore(scratch.path(), &arguments, 0);
    let page = |file: &str| fs::read_to_string(scratch.path().join(file)).expect("page");
    assert_eq!(page("row.html"), page("fresh.html"));
    let json: Json = serde_json::from_slice(&again(&["--json"]).stdout).expect("JSON");
    let stored = &json["stored_row"];
    assert!(stored["is_there"] == true && stored["values"].as_u64() > Some(50), "{stored}");
    assert_eq!(stored["differences"].as_array().map(Vec::len), Some(0));
    // With another value it is another row.
    let other = again(&["--set", "duration_s=0.14"]);
    assert!(!text(&other.stdout).contains("stored row"));
    // A hammer file that is set over the study's is read, from where `--files-in` says.
    let lost = text(&decore(scratch.path(), &["scene", "out", "--set", "hammer.hammer.file=mine.toml"], 2).stderr);
    assert!(lost.contains("mine.toml") && lost.contains("hammer file"), "{lost}");
    let none = text(&decore(scratch.path(), &["scene", "out", "--row", "900"], 2).stderr);
    assert!(none.contains("--row is 900"), "{none}");
}

#[test]
fn a_measurement_stands_beside_its_signal() {
    let scratch = TempDir::new().expect("scratch folder");
    let scene = |further: &[&str], code: i32| quick_rig(scratch.path(), further, code);
    // The signals themselves are a measurement that nothing differs from.
    scene(&["--signals", "signals.parquet", "--signal-interval-s", "2e-5"], 0);
    let same = ["--measured", "signals.parquet", "--channel", "hammer_arm_velocity_m_s=hammer_arm_velocity_m_s"];
    let found: Json = serde_json::from_slice(&scene(&[&same[..], &["--json"]].concat(), 0).stdout).expect("JSON");
    let beside = &found["measured"][0];
    let number = |at: &str| beside.pointer(at).and_then(Json::as_f64).expect("number");
    assert!(number("/offset_s").abs() < 1e-9 && number("/correlation") > 1.0 - 1e-9, "{beside}");
    assert!(number("/rms/difference").abs() < 1e-9 && number("/rms/measured") > 1e-3, "{beside}");
    assert_eq!((number("/peak/difference").abs() < 1e-9, number("/frequency_hz/difference")), (true, 0.0));
    // Phase by phase too; 0.15 s have no periodic blow.
    let phases: Vec<&str> =
        beside["phases"].as_array().expect("phases").iter().filter_map(|one| one["phase"].as_str()).collect();
    assert_eq!(phases, ["extension", "first_impact", "hammering"]);
    assert_eq!(
        beside["missing_phases"],
        serde_json::json!([{ "phase": "periodic_blow", "reason": "the row has none" }])
    );
    assert_eq!(beside["phases_of"], "hammer");
    for (index, phase) in phases.iter().enumerate() {
        let at = |pointer: &str| number(&format!("/phases/{index}/{pointer}"));
        assert!(at("rms/difference").abs() < 1e-9 && at("peak/difference").abs() < 1e-9, "{phase}");
        let lines = beside.pointer(&format!("/phases/{index}/density/lines")).and_then(Json::as_array).expect("lines");
        assert!(
            !lines.is_empty() && lines.iter().all(|line| line["difference"].as_f64().is_some_and(|d| d.abs() < 1e-9))
        );
    }
    let root_mean_square = |phase: usize| number(&format!("/phases/{phase}/rms/calculated"));
    assert!(root_mean_square(0) < root_mean_square(1) && root_mean_square(1) < 0.05, "{beside}");
    // In another unit it is another measurement.
    let printed =
        text(&scene(&[&same[..3], &["hammer_arm_velocity_m_s=hammer_arm_velocity_m_s:mm/s"]].concat(), 0).stdout);
    assert!(printed.contains("root mean square") && printed.contains("+99900.0 %"), "{printed}");
    assert!(printed.contains("by phase: hammer hammer") && printed.contains("extension: 0.002"), "{printed}");
    assert!(printed.contains("one periodic blow: missing, the row has none"), "{printed}");
    let page = |file: &str, further: &[&str]| {
        scene(&[&["--html", file], further].concat(), 0);
        let page = fs::read_to_string(scratch.path().join(file)).expect("page");
        serde_json::from_str::<Json>(block(&page, "meta")).expect("JSON")
    };
    let without = page("without.html", &[]);
    assert_eq!(without["measured"], serde_json::json!([]));
    assert!(
        without["spectra"].as_array().expect("spectra").iter().all(|lines| lines["measured"] == serde_json::json!([]))
    );
    let with = page("with.html", &same);
    let of_arm = |lines: &&Json| lines["quantity"] == "arm_velocity_m_s";
    let spectra: Vec<&Json> = with["spectra"].as_array().expect("spectra").iter().filter(of_arm).collect();
    assert_eq!(spectra.len(), 3);
    for lines in spectra {
        let measured = &lines["measured"][0];
        assert_eq!(
            (&measured["column"], &measured["lines"]["count"]),
            (&"hammer_arm_velocity_m_s".into(), &lines["count"])
        );
    }
    let drawn = &with["measured"];
    assert_eq!((&drawn[0]["quantity"], &drawn[0]["pieces"][0]["from_s"]), (&"arm_velocity_m_s".into(), &0.0.into()));
    assert!(drawn[0]["pieces"][0]["count"].as_u64() >= Some(7490), "{drawn}");
    for (channel, message) in [
        ("hammer_arm_velocity=hammer_arm_velocity_m_s", "did you mean `hammer_arm_velocity_m_s`?"),
        ("hammer_arm_velocity_m_s=arm", "has no column `arm`"),
        ("hammer_arm_velocity_m_s=hammer_arm_velocity_m_s:bar", "which bar is no unit of"),
        ("hammer_arm_velocity_m_s=hammer_arm_velocity_m_s:mms", "did you mean `mm/s`?"),
    ] {
        let said = text(&scene(&[&same[..3], &[channel]].concat(), 2).stderr);
        assert!(said.contains(message), "{said}");
    }
    let said = text(&scene(&[&same[..], &["--offset-s", "7"]].concat(), 2).stderr);
    assert!(said.contains("too little in common"), "{said}");
    let said = text(&scene(&[&same[..], &["--signals", "signals.parquet"]].concat(), 2).stderr);
    assert!(said.contains("would overwrite what the command reads"), "{said}");
}

/// A row whose inputs describe no hammer on a casting is done, and says why it is to be doubted; `check` knows it before.
#[test]
fn a_row_to_be_doubted_is_warned_of() {
    let scratch = TempDir::new().expect("scratch folder");
    let rig = study("paper_rig.toml");
    let soft = "hammer.hammer.parameters.chisel.casting_contact.stiffness_n_per_m=1e5";
    let run = |command: &str, further: &[&str]| {
        let mut arguments = vec![command, rig.to_str().expect("path"), "--set", soft];
        arguments.extend(QUICK.iter().chain(further));
        decore(scratch.path(), &arguments, 0)
    };
    let said = text(&run("scene", &[]).stdout);
    let warning = "  warning: a chisel goes deeper into its casting than a quarter of its free travel";
    assert!(said.contains("row 0: done\n") && said.contains(warning), "{said}");
    let json: Json = serde_json::from_slice(&run("scene", &["--json"]).stdout).expect("JSON");
    assert_eq!(json["outcome"]["metrics"]["warnings"], "deep_contact");
    let told = text(&run("check", &[]).stderr);
    assert!(told.contains("warning: ") && told.contains("the contact is too soft"), "{told}");
    let said = text(&run("run", &["--output", "out"]).stdout);
    assert!(said.contains("warnings: deep_contact in 1 row (decore help outputs)"), "{said}");
}

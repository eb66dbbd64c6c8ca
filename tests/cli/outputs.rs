//! What commands are asked to write destroys neither what they read nor what a dataset consists of, and is known to be writable
//! before they work.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::TempDir;

const BAD_INPUT: i32 = 2;
/// What is said of a file that the command reads, and of a place that is a dataset's.
const READ: &str = "would overwrite what the command reads";
const OWN: &str = "keeps its own files";
/// A part of the dataset.
const PART: &str = "sweep/runs/runs-000000000000.parquet";
/// Rows that are made up, at once.
const AT_ONCE: [&str; 2] = ["--stub-row-ms", "0"];

struct Folder {
    scratch: TempDir,
}

impl Folder {
    /// Studies, and the datasets `sweep` and `other`.
    fn new() -> Self {
        let folder = Self { scratch: TempDir::new().expect("scratch folder") };
        let studies = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies");
        fs::create_dir(folder.path("hammers")).expect("made");
        for name in ["paper_rig.toml", "placement.toml", "hammers/default.toml"] {
            let text = fs::read_to_string(studies.join(name)).expect("a study");
            fs::write(folder.path(name), text.replace("rows = 240", "rows = 40")).expect("written");
        }
        for dataset in ["sweep", "other"] {
            folder.ends(&[&["run", "placement.toml", "--output", dataset][..], &AT_ONCE].concat(), &[0, 4]);
        }
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.scratch.path().join(name)
    }

    /// Runs the program, which has to end with one of these codes; all that it says.
    fn ends(&self, arguments: &[&str], codes: &[i32]) -> String {
        let mut command = Command::new(env!("CARGO_BIN_EXE_decore"));
        let output = command.args(arguments).current_dir(self.scratch.path()).output().expect("started");
        let said = String::from_utf8_lossy(&[output.stderr, output.stdout].concat()).into_owned();
        assert!(output.status.code().is_some_and(|code| codes.contains(&code)), "{arguments:?}: {said}");
        said
    }

    /// The command is refused with these words, and every file is as before.
    fn refuses(&self, arguments: &[&str], words: &str) {
        let before = self.files();
        let said = self.ends(arguments, &[BAD_INPUT]);
        assert!(said.contains(words), "{arguments:?}: {said}");
        assert!(before == self.files(), "{arguments:?} wrote or made something");
    }

    /// All files and folders with their contents.
    fn files(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        let (mut found, mut folders) = (BTreeMap::new(), vec![self.scratch.path().to_owned()]);
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(&folder).expect("folder") {
                let path = entry.expect("entry").path();
                found.insert(path.clone(), fs::read(&path).unwrap_or_default());
                folders.extend(path.is_dir().then_some(path));
            }
        }
        found
    }
}

#[test]
fn no_command_writes_where_a_dataset_keeps_its_own() {
    let folder = Folder::new();
    let rig = "paper_rig.toml";
    for (arguments, words) in [
        (&["analyse", "sweep", "--parquet", PART][..], READ),
        (&["analyse", "other", "--parquet", PART], OWN),
        (&["analyse", "sweep", "--parquet", "sweep/blows/indices.parquet"], OWN),
        (&["surrogate", "sweep", "--output", PART], READ),
        (&["surrogate", "sweep", "--output", "other/timings/model.parquet"], OWN),
        (&["predict", "model.parquet", PART, "--output", PART], READ),
        (&["predict", "model.parquet", "rows.csv", "--output", PART], OWN),
        (&["report", "sweep", "--html", "sweep/manifest.json"], READ),
        (&["report", "sweep", "--html", "other/manifest.json"], "a file name that ends in `.html`"),
        (&["report", "sweep", "--html", "sweep/./runs/../runs/page.html"], OWN),
        (&["paper", "--html", "sweep/signals/page.html"], OWN),
        (&["run", "placement.toml", "--output", "new", "--summary", "sweep/manifest.json"], OWN),
        (&["run", "placement.toml", "--output", "new", "--summary", "sweep/timings.json"], OWN),
        // The dataset that is yet to come.
        (&["run", "placement.toml", "--output", "new", "--summary", "new/manifest.json"], OWN),
        (&["run", "placement.toml", "--summary", "out/placement/status.json"], OWN),
        (&["run", "placement.toml", "--output", "sweep/runs/new"], OWN),
        (&["refine", "placement.toml", "--most-rows", "9", "--failures", "--output", "sweep/runs/new"], OWN),
        (&["merge", "sweep", "--output", "other/blows"], OWN),
        (&["structure", rig, "--html", "sweep/runs/page.html"], OWN),
        (&["structure", rig, "--export", "op4", "--to", "sweep/.staging"], OWN),
        (&["scene", rig, "--html", "sweep/runs/page.html"], OWN),
        (&["scene", rig, "--plot", "sweep/.journal/row.svg"], OWN),
        (&["scene", rig, "--signals", PART], OWN),
        (&["scene", "sweep", "--files-in", ".", "--signals", PART], READ),
        (&["check", rig, "--scatter", "sweep/blows/matrix.svg"], OWN),
        (&["design", "placement.toml", "--output", PART], OWN),
        (&["design", "placement.toml", "--output", "sweep/runs/rows.csv"], OWN),
        (&["accuracy", rig, "--output", "sweep/runs"], OWN),
        (&["export", "other", "--features", "sweep/runs/table"], OWN),
        // Slurm takes no paths of Windows at all.
        (
            &["slurm", rig, "--tasks", "2", "--output", "sweep/runs/new"],
            if cfg!(windows) { "without backslashes" } else { OWN },
        ),
        (&["hyperqueue", rig, "--tasks", "2", "--output", "sweep/runs/new"], OWN),
        (&["init", "sweep/runs/study.toml"], OWN),
        (&["man", "--output", "sweep/runs/man"], OWN),
    ] {
        folder.refuses(arguments, words);
    }
}

/// Beside what is the dataset's own other files may lie.
#[test]
fn a_dataset_s_folder_takes_other_files() {
    let folder = Folder::new();
    folder.ends(&["report", "sweep", "--html", "sweep/report.html"], &[0]);
    folder.ends(&["analyse", "sweep", "--bootstrap", "0", "--parquet", "sweep/indices.parquet"], &[0]);
    folder.ends(&["surrogate", "sweep", "--output", "sweep/model.parquet"], &[0]);
    let rows = ["run", "placement.toml", "--output"];
    folder.ends(&[&rows[..], &["sweep", "--summary", "sweep/summary.json"], &AT_ONCE].concat(), &[0, 4]);
    // The folder of the summary is made by the run.
    folder.ends(&[&rows[..], &["a/new", "--summary", "a/summary.json"], &AT_ONCE].concat(), &[0, 4]);
    for file in ["report.html", "indices.parquet", "model.parquet", "predict.py", "summary.json", "../a/summary.json"] {
        assert!(folder.path("sweep").join(file).is_file(), "{file}");
    }
    assert!(folder.ends(&["verify", "sweep"], &[0]).contains("sweep: whole"));
}

#[test]
fn a_study_is_no_place_for_an_output() {
    let folder = Folder::new();
    fs::copy(folder.path("paper_rig.toml"), folder.path("mine.toml")).expect("copied");
    for (arguments, words) in [
        (&["report", "sweep", "--html", "mine.toml"][..], "a file name that ends in `.html`"),
        (&["paper", "--html", "mine.toml"], "a file name that ends in `.html`"),
        (&["structure", "paper_rig.toml", "--html", "mine.toml"], "a file name that ends in `.html`"),
        (&["structure", "mine.toml", "--html", "mine.toml"], READ),
        (&["run", "placement.toml", "--output", "new", "--summary", "mine.toml"], "a file name that ends in `.json`"),
        (&["design", "placement.toml", "--output", "mine.toml"], "a file name that ends in `.parquet` or `.csv`"),
        (&["analyse", "sweep", "--parquet", "mine.toml"], "a file name that ends in `.parquet`"),
        (&["surrogate", "sweep", "--output", "mine.toml"], "a file name that ends in `.parquet`"),
    ] {
        folder.refuses(arguments, words);
    }
}

/// Rows of the study by which an analysis repairs or grows a dataset.
#[test]
fn an_analysis_spares_the_files_of_its_study() {
    let folder = Folder::new();
    folder.ends(&["design", "placement.toml", "--output", "rows.parquet"], &[0]);
    let text = fs::read_to_string(folder.path("placement.toml")).expect("a study");
    let (scene, design) = text.split_once("[design]").expect("a design");
    let (_, factors) = design.split_once("[design.factor.").expect("factors");
    let table = "[design]\nkind = \"table\"\nfile = \"rows.parquet\"\n\n[design.factor.";
    fs::write(folder.path("table.toml"), format!("{scene}{table}{factors}")).expect("written");
    let further = ["--study", "table.toml", "--repair", "--parquet", "rows.parquet", "--replace"];
    folder.refuses(&[&["analyse", "sweep"][..], &further].concat(), READ);
}

/// Files are known by what they are, not by a name.
#[cfg(unix)]
#[test]
fn links_to_inputs_are_seen_through() {
    use std::os::unix::fs::symlink;
    let folder = Folder::new();
    let link = |of: &str, name: &str| fs::hard_link(folder.path(of), folder.path(name)).expect("linked");
    link("sweep/manifest.json", "page.html");
    link(PART, "part.parquet");
    link("placement.toml", "study.json");
    symlink(folder.path("sweep/manifest.json"), folder.path("soft.html")).expect("linked");
    symlink(folder.path("sweep/runs"), folder.path("tables")).expect("linked");
    for (arguments, words) in [
        (&["report", "sweep", "--html", "page.html"][..], READ),
        (&["report", "sweep", "--html", "soft.html"], READ),
        (&["report", "other", "--html", "soft.html"], OWN),
        (&["analyse", "sweep", "--parquet", "part.parquet"], READ),
        (&["surrogate", "sweep", "--output", "part.parquet"], READ),
        (&["analyse", "sweep", "--parquet", "tables/new.parquet"], OWN),
        (&["run", "placement.toml", "--output", "new", "--summary", "study.json"], READ),
    ] {
        folder.refuses(arguments, words);
    }
    // Another name of a file that the command does not read gets another file, and the first one keeps its own.
    link("other/status.json", "summary.json");
    let before = fs::read(folder.path("other/status.json")).expect("read");
    let rows = ["run", "placement.toml", "--output", "sweep", "--summary", "summary.json"];
    folder.ends(&[&rows[..], &AT_ONCE].concat(), &[0, 4]);
    assert!(before == fs::read(folder.path("other/status.json")).expect("read"));
    assert!(before != fs::read(folder.path("summary.json")).expect("read"));
}

#[test]
fn only_decore_s_own_predictor_is_replaced() {
    let folder = Folder::new();
    let surrogate = ["surrogate", "sweep", "--output", "model.parquet"];
    fs::write(folder.path("predict.py"), "print('mine')\n").expect("written");
    folder.refuses(&surrogate, "predict.py is to be written too, and what is there was not written by decore");
    fs::remove_file(folder.path("predict.py")).expect("removed");
    folder.ends(&surrogate, &[0]);
    let surrogate = ["surrogate", "sweep", "--output", "model.parquet", "--replace"];
    let written = fs::read_to_string(folder.path("predict.py")).expect("a script");
    // One of an earlier version differs further down.
    let begin = written.lines().next().expect("a line");
    fs::write(folder.path("predict.py"), format!("{begin}\n\nearlier\n")).expect("written");
    folder.ends(&surrogate, &[0]);
    assert_eq!(fs::read_to_string(folder.path("predict.py")).expect("a script"), written);
    fs::remove_file(folder.path("predict.py")).expect("removed");
    fs::create_dir(folder.path("predict.py")).expect("made");
    folder.refuses(&surrogate, "was not written by decore");
}

/// What cannot be written is told before anything is computed.
#[test]
fn a_place_that_takes_no_file_is_told_first() {
    let folder = Folder::new();
    fs::write(folder.path("file"), "").expect("written");
    for arguments in [
        &["accuracy", "paper_rig.toml", "--output", "file/below"][..],
        &["accuracy", "paper_rig.toml", "--output", "file"],
        &["paper", "--html", "file/page.html"],
        &["scene", "paper_rig.toml", "--html", "file/page.html"],
        &["surrogate", "sweep", "--output", "nowhere/model.parquet"],
        &["run", "placement.toml", "--output", "new", "--summary", "file/summary.json"],
        &["structure", "paper_rig.toml", "--export", "op4", "--to", "file/below"],
    ] {
        let before = folder.files();
        let said = folder.ends(arguments, &[3]);
        assert!(said.contains("failed to write") && said.lines().count() == 1, "{arguments:?}: {said}");
        assert!(before == folder.files(), "{arguments:?}");
    }
}

#[test]
fn an_export_makes_its_folder() {
    let folder = Folder::new();
    folder.ends(&["structure", "paper_rig.toml", "--export", "op4", "--to", "machine/new"], &[0]);
    assert!(folder.path("machine/new/points.csv").is_file());
    let said = folder.ends(&["structure", "paper_rig.toml", "--to", "machine/new"], &[2]);
    assert!(said.contains("--export <FORMAT>"), "{said}");
}

/// Every command with a file as its output: a second run is refused at once and replaces the file on request.
#[test]
fn an_existing_file_is_replaced_on_request_alone() {
    let folder = Folder::new();
    let measured = ["R5.z,R5.z,100,1e-6,0", "R5.z,R5.z,150,2e-6,-1e-6", "R5.z,R5.z,200,1e-6,-2e-6"].join("\n");
    let head = "response,force,frequency_hz,receptance_re,receptance_im\n";
    fs::write(folder.path("frf.csv"), format!("{head}{measured}\n")).expect("written");
    fs::write(folder.path("cores.csv"), "row,core_out_after_s\n0,30\n1,40\n").expect("written");
    folder.ends(&["surrogate", "sweep", "--output", "fitted.parquet"], &[0]);
    folder.ends(&["design", "placement.toml", "--output", "places.csv"], &[0]);
    let rig = "paper_rig.toml";
    for (arguments, file) in [
        (&["init", "study.toml"][..], "study.toml"),
        (&["check", "placement.toml", "--scatter", "matrix.svg"], "matrix.svg"),
        (&["design", "placement.toml", "--output", "rows.csv"], "rows.csv"),
        (&["scene", rig, "--signals", "row.parquet"], "row.parquet"),
        (&["scene", rig, "--plot", "row.svg"], "row.svg"),
        (&["scene", rig, "--html", "row.html"], "row.html"),
        (&["report", "sweep", "--html", "page.html"], "page.html"),
        (&["analyse", "sweep", "--bootstrap", "0", "--parquet", "indices.parquet"], "indices.parquet"),
        (&["surrogate", "sweep", "--output", "model.parquet"], "model.parquet"),
        (&["predict", "fitted.parquet", "places.csv", "--output", "predicted.parquet"], "predicted.parquet"),
        (&["structure", rig, "--html", "machine.html"], "machine.html"),
        (&["structure", rig, "--measured", "frf.csv", "--damping-to", "ratios.csv"], "ratios.csv"),
    ] {
        fs::write(folder.path(file), "mine").expect("written");
        let words = format!("{file} exists and was not changed: choose another name (");
        folder.refuses(arguments, &words);
        assert!(folder.ends(arguments, &[BAD_INPUT]).contains("add `--replace` to replace it"), "{arguments:?}");
        folder.ends(&[arguments, &["--replace"]].concat(), &[0]);
        assert!(fs::read(folder.path(file)).expect("read") != b"mine", "{arguments:?}");
        // A folder under the file's name is never replaced.
        fs::remove_file(folder.path(file)).expect("removed");
        fs::create_dir(folder.path(file)).expect("made");
        folder.refuses(&[arguments, &["--replace"]].concat(), "is a folder: give the name of a file");
        fs::remove_dir(folder.path(file)).expect("removed");
    }
    // The two slow or demanding ones are refused alike.
    for (arguments, file) in [
        (&["paper", "--html", "paper.html"][..], "paper.html"),
        (&["cores", "sweep", "--tests", "cores.csv", "--output", "times.parquet"], "times.parquet"),
    ] {
        fs::write(folder.path(file), "mine").expect("written");
        folder.refuses(arguments, &format!("{file} exists and was not changed"));
        let said = folder.ends(&[arguments, &["--replace", "--no-such-option"]].concat(), &[BAD_INPUT]);
        assert!(said.contains("unexpected argument '--no-such-option'"), "{said}");
    }
    // Standard output takes any number of studies.
    (0..2).for_each(|_| assert!(folder.ends(&["init", "-"], &[0]).contains("[casting.part]")));
}

/// The same command continues a sweep, so the status of an earlier run makes way; other files do not.
#[test]
fn a_status_replaces_a_status_alone() {
    let folder = Folder::new();
    let run = [&["run", "placement.toml", "--output", "sweep", "--summary", "status.json"][..], &AT_ONCE].concat();
    (0..2).for_each(|_| drop(folder.ends(&run, &[0, 4])));
    for other in ["{}", "mine", "{\"state\": \"complete\"}"] {
        fs::write(folder.path("status.json"), other).expect("written");
        folder.refuses(&run, "status.json exists and is not the status of a sweep: choose another name (--summary)");
    }
}

/// Of names that nobody gave nothing is replaced unless that is asked for; other files of the folder are no matter.
#[test]
fn a_folder_s_files_are_replaced_on_request_alone() {
    let folder = Folder::new();
    let export = ["structure", "paper_rig.toml", "--export", "matrix_market", "--to", "to"];
    for (arguments, file) in [
        (&export[..], "M.mtx"),
        (&["man", "--output", "to"], "decore-run.1"),
        (&["export", "sweep", "--features", "to"], "dictionary.csv"),
        (&["accuracy", "paper_rig.toml", "--output", "to"], "accuracy.svg"),
    ] {
        fs::create_dir(folder.path("to")).expect("made");
        fs::write(folder.path("to/notes.txt"), "mine").expect("written");
        fs::write(folder.path("to").join(file), "mine").expect("written");
        folder.refuses(arguments, &format!("{file} exists and was not changed: choose another name ("));
        if arguments[0] != "accuracy" {
            folder.ends(&[arguments, &["--replace"]].concat(), &[0]);
            assert!(fs::read(folder.path("to").join(file)).expect("read") != b"mine", "{file}");
        }
        assert_eq!(fs::read(folder.path("to/notes.txt")).expect("read"), b"mine");
        fs::remove_dir_all(folder.path("to")).expect("removed");
    }
    // What is read is not replaced at all.
    folder.ends(&export, &[0]);
    let keys = ["stiffness_file = \"to/K.mtx\"", "mass_file = \"to/M.mtx\"", "points_file = \"to/points.csv\""];
    let table = format!("[structure]\nsource = \"matrices\"\nunits = \"si\"\n{}\n", keys.join("\n"));
    fs::write(folder.path("machine.toml"), table).expect("written");
    folder.refuses(&["structure", "machine.toml", "--export", "op4", "--to", "to", "--replace"], READ);
}

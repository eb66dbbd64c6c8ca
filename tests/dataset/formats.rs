//! Datasets and journals of every format version from 5 on, as the program of their time wrote them: each goes on, or is refused with
//! words, and stays as it was then.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;
use tempfile::TempDir;

use crate::sweeps::{decore, errors, expect_code, output};
use crate::synthetic::files;

/// Rows of the kept study.
const ROWS: u64 = 6;
/// Parts of a study that must be equal for rows of one dataset.
const IDENTITY: [&str; 7] =
    ["study_hash", "seed", "program_version", "columns_hash", "rows", "rows_per_part", "settings"];

/// The folder of the kept study and its datasets.
fn kept() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/datasets")
}

/// The kept study with made-up rows, into a folder.
fn run(folder: &Path) -> Command {
    let mut command = decore();
    command.arg("run").arg(kept().join("study.toml")).arg("--output").arg(folder).args(["--stub-row-ms", "0"]);
    command
}

/// A copy of a kept dataset.
fn restored(name: &str, scratch: &Path) -> PathBuf {
    let folder = scratch.join(name);
    for (file, bytes) in files(&kept().join(name)) {
        let path = folder.join(file);
        fs::create_dir_all(path.parent().expect("a folder")).expect("folder");
        fs::write(path, bytes).expect("file");
    }
    folder
}

/// All that a run may not change where it is refused.
fn tables(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = files(folder);
    found.retain(|name, _| name != Path::new(".lock"));
    found
}

/// The format version in a manifest, or in the description of a journal.
fn version_of(manifest: &Path) -> Value {
    let text = fs::read_to_string(manifest).expect("manifest");
    serde_json::from_str::<Value>(&text).expect("JSON")["format_version"].clone()
}

/// The study in a manifest, or in the description of a journal.
fn study_of(manifest: &Path) -> Value {
    let text = fs::read_to_string(manifest).expect("manifest");
    serde_json::from_str::<Value>(&text).expect("JSON")["study"].clone()
}

#[test]
fn kept_datasets_go_on_or_are_refused_with_words() {
    let scratch = TempDir::new().expect("scratch folder");
    let fresh = scratch.path().join("fresh");
    expect_code(run(&fresh), 0);
    let now = study_of(&fresh.join("manifest.json"));
    let cases = [
        ("format_5", "manifest.json", 6),
        ("format_6", "manifest.json", 6),
        ("journal_1", "manifest.json", 3),
        ("journal_2", ".journal/study.json", 3),
    ];
    for (name, manifest, rows) in cases {
        let folder = restored(name, scratch.path());
        let then = study_of(&folder.join(manifest));
        let version = version_of(&folder.join(manifest));
        let before = tables(&folder);
        let ended = output(run(&folder));
        let text = errors(&ended);
        if version != version_of(&fresh.join("manifest.json")) {
            let refused = format!("key `format_version` is {version}, expected ");
            assert!(ended.status.code() == Some(2) && text.contains(&refused), "{name}: {text}");
            for verb in ["report", "verify"] {
                let mut command = decore();
                command.arg(verb).arg(&folder);
                let text = errors(&expect_code(command, 2));
                assert!(text.contains(&refused), "{name}: {text}");
            }
            assert_eq!(tables(&folder), before, "{name}");
        } else if IDENTITY.iter().all(|key| then[*key] == now[*key]) {
            assert_eq!(ended.status.code(), Some(0), "{name}: {text}");
            let told = match rows {
                ROWS => "all 6 rows are in".to_owned(),
                some => format!("continuing: {some} of 6 rows"),
            };
            assert!(text.contains(&told), "{name}: {text}");
            let mut verify = decore();
            verify.arg("verify").arg(&folder);
            expect_code(verify, 0);
        } else {
            assert_eq!(ended.status.code(), Some(2), "{name}: {text}");
            assert!(text.contains(&format!("{rows} of 6 rows of a different study")), "{name}: {text}");
            assert_eq!(tables(&folder), before, "{name}");
        }
    }
}

#[test]
fn other_versions_and_nameless_journals_are_refused_and_can_be_replaced() {
    let scratch = TempDir::new().expect("scratch folder");
    let folder = restored("format_5", scratch.path());
    let manifest = folder.join("manifest.json");
    let text = fs::read_to_string(&manifest).expect("manifest");
    // As programs wrote it before manifests had a checksum.
    let body = text
        .split(",\n  \"checksum\"")
        .next()
        .expect("a body")
        .replace("\"format_version\": 5", "\"format_version\": 3");
    fs::write(&manifest, format!("{body}\n}}\n")).expect("written");
    let before = tables(&folder);
    let refused = errors(&expect_code(run(&folder), 2));
    assert!(refused.contains("key `format_version` is 3, expected 6"), "{refused}");
    assert_eq!(tables(&folder), before);

    // A journal that names no study, and nothing else that does.
    let folder = restored("journal_1", scratch.path());
    fs::write(folder.join("manifest.json"), "x\n").expect("written");
    let before = tables(&folder);
    let refused = errors(&expect_code(run(&folder), 2));
    assert!(refused.contains("line 1, column 1") && refused.contains("contains the study"), "{refused}");
    assert_eq!(tables(&folder), before);
    let mut replace = run(&folder);
    replace.arg("--replace");
    expect_code(replace, 0);
}

//! Nothing that was computed is lost without a word: manifests, timings, parts and the journal damaged in every way.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::synthetic::{ROWS, contract, dataset, files, info, outcome, record};
use decore_dataset::{
    DatasetError, DatasetInfo, DatasetReader, DatasetWriter, Existing, RerunSelection, RowSpan, TableName, merge,
    verify,
};
use decore_lab::report::{ReportSettings, summarise};
use decore_quantity::Value;
use tempfile::TempDir;

/// Variable that sets the number of corruptions of the campaign.
const CORRUPTIONS: &str = "DECORE_CORRUPTIONS";

/// What a resumed run found and did.
struct Resumed {
    /// Rows that had to be computed again.
    again: u64,
    damaged: Vec<String>,
    notes: Vec<String>,
}

/// Goes on with the dataset to its end.
fn resume(folder: &Path) -> Result<Resumed, DatasetError> {
    let mut writer = DatasetWriter::create(folder, &info(), Existing::Resume)?;
    let left = writer.rows_left();
    let damaged = writer.damaged().iter().map(ToString::to_string).collect();
    let notes = writer.notes().to_vec();
    for row in left.iter().flat_map(|span| span.first..span.end) {
        writer.write(&record(row, outcome(row)))?;
    }
    assert!(writer.finish()?.complete);
    Ok(Resumed { again: left.iter().map(|span| span.len()).sum(), damaged, notes })
}

/// The wall times of all rows; `None` for nulls.
fn wall_times(folder: &Path) -> Vec<Option<f64>> {
    let reader = DatasetReader::open(folder).expect("opened");
    let mut found = Vec::new();
    reader
        .visit(TableName::Timings, &["row", "wall_time_s"], |cells| {
            assert_eq!(cells[0], Some(Value::Count(found.len() as u64)));
            found.push(cells[1].and_then(|value| value.number()));
        })
        .expect("read");
    found
}

fn flip(bytes: &[u8], at: usize) -> Vec<u8> {
    let mut flipped = bytes.to_vec();
    flipped[at] ^= 0x10;
    flipped
}

#[test]
fn lost_timings_cost_no_row() {
    let (_scratch, folder) = dataset();
    let whole = contract(&folder);
    let times = wall_times(&folder);
    let path = folder.join("timings.json");
    let bytes = fs::read(&path).expect("timings");
    for damage in [None, Some(&bytes[..bytes.len() / 2]), Some(b"garbage"), Some(&flip(&bytes, bytes.len() / 2))] {
        match damage {
            None => fs::remove_file(&path).expect("removed"),
            Some(damage) => fs::write(&path, damage).expect("written"),
        }
        // Readers of other tables go on; what is wrong with the file is among the faults.
        assert_eq!(wall_times(&folder), times);
        let found = verify(&folder).expect("verified");
        assert_eq!(found.faults.len(), 1, "{:?}", found.faults);
        let resumed = resume(&folder).expect("resumed");
        assert_eq!((resumed.again, resumed.damaged.len()), (0, 0), "{:?}", resumed.damaged);
        assert!(resumed.notes[0].contains("timings.json was lost or damaged"), "{:?}", resumed.notes);
        assert_eq!(contract(&folder), whole);
        // The parts still have them.
        assert_eq!(wall_times(&folder), times);
        assert_eq!(fs::read(&path).expect("timings"), bytes);
    }
    // A part that is lost or damaged: nulls, and a line.
    fs::write(folder.join("timings/timings-000000000000.parquet"), "garbage").expect("written");
    fs::remove_file(folder.join("timings/timings-000000000128.parquet")).expect("removed");
    fs::remove_file(&path).expect("removed");
    let reader = DatasetReader::open(&folder).expect("opened");
    let error = reader.visit(TableName::Timings, &["row"], |_| ()).expect_err("refused").to_string();
    assert!(error.contains("timings-000000000000.parquet") && error.contains("64 rows from row 0"), "{error}");
    let resumed = resume(&folder).expect("resumed");
    assert_eq!((resumed.again, resumed.damaged.len()), (0, 0), "{:?}", resumed.damaged);
    assert!(resumed.notes.iter().any(|note| note.contains("wall times of 86 rows are lost")), "{:?}", resumed.notes);
    assert_eq!(contract(&folder), whole);
    let found = wall_times(&folder);
    assert_eq!(found[64..128], times[64..128]);
    assert!(found[..64].iter().chain(&found[128..]).all(Option::is_none));
    assert!(resume(&folder).expect("resumed").notes.is_empty(), "said once");
}

#[test]
fn a_lost_manifest_is_made_anew_from_the_parts() {
    let (_scratch, folder) = dataset();
    let whole = contract(&folder);
    let path = folder.join("manifest.json");
    let bytes = fs::read(&path).expect("manifest");
    let text = String::from_utf8(bytes.clone()).expect("text");
    let edited = [
        text.replace("\"seed\": 18446744073709551615", "\"seed\": 1"),
        text.replace("\"rows_done\": 150", "\"rows_done\": 1e18"),
        text.replace("\"unit\": \"bar\"", "\"unit\": \"Pa\""),
        text.replace("synthetic", "synthetiC"),
        text.replace("\"checksum\"", "\"checksun\""),
        text.replace("\"format_version\": 6", "\"format_version\": 7"),
        text[..text.len() - 100].to_owned(),
        String::new(),
    ];
    for edited in edited {
        assert!(edited != text);
        fs::write(&path, &edited).expect("written");
        let error = DatasetReader::open(&folder).expect_err("refused").to_string();
        assert!(error.contains("manifest.json") && error.contains("rebuild it from the parts"), "{error}");
        let resumed = resume(&folder).expect("resumed");
        assert_eq!((resumed.again, resumed.damaged.len()), (0, 0), "{:?}", resumed.damaged);
        assert!(resumed.notes[0].contains("manifest.json was lost or damaged"), "{:?}", resumed.notes);
        assert_eq!(contract(&folder), whole);
    }
    // Both manifests gone, one part damaged: only its rows are computed again, and the part stays for whoever wants it.
    for name in ["manifest.json", "timings.json"] {
        fs::remove_file(folder.join(name)).expect("removed");
    }
    fs::write(folder.join("blows/blows-000000000064.parquet"), "cut").expect("written");
    let resumed = resume(&folder).expect("resumed");
    assert_eq!(resumed.again, 64, "{:?}", resumed.damaged);
    assert!(resumed.damaged[0].contains("blows-000000000064.parquet"), "{:?}", resumed.damaged);
    assert_eq!(fs::read(folder.join(".damaged/blows-000000000064.parquet")).expect("kept"), b"cut");
    assert!(folder.join(".damaged/runs-000000000064.parquet").exists());
    fs::remove_dir_all(folder.join(".damaged")).expect("removed");
    assert_eq!(contract(&folder), whole);
    // What nothing vouches for is computed again, too.
    fs::remove_file(&path).expect("removed");
    fs::remove_file(folder.join("timings/timings-000000000064.parquet")).expect("removed");
    let resumed = resume(&folder).expect("resumed");
    assert_eq!(resumed.again, 64, "{:?}", resumed.damaged);
    assert!(
        resumed.damaged.iter().any(|line| line.contains("runs-000000000064.parquet: no checksum is left")),
        "{:?}",
        resumed.damaged
    );
    // Without any description there is no dataset to go on with: nothing is touched.
    fs::remove_file(&path).expect("removed");
    fs::remove_dir_all(folder.join("timings")).expect("removed");
    let before = files(&folder);
    let error = resume(&folder).err().expect("refused");
    assert!(matches!(error, DatasetError::Occupied { .. }), "{error}");
    assert_eq!(files(&folder), before);
}

#[test]
fn a_journal_alone_goes_on() {
    let (_scratch, whole) = dataset();
    let scratch = TempDir::new().expect("scratch folder");
    let folder = scratch.path().join("begun");
    let mut writer = DatasetWriter::create(&folder, &info(), Existing::Refuse).expect("created");
    (0..20).for_each(|row| writer.write(&record(row, outcome(row))).expect("taken"));
    drop(writer);
    let begun = files(&folder);
    let damages: [&dyn Fn(); 4] = [
        &|| fs::write(folder.join("manifest.json"), "x\n").expect("written"),
        &|| fs::remove_file(folder.join("manifest.json")).expect("removed"),
        &|| {
            ["manifest.json", "timings.json"].iter().for_each(|name| fs::write(folder.join(name), "").expect("written"))
        },
        &|| {
            let journal = begun.iter().filter(|(name, _)| name.starts_with(".journal"));
            restore(&folder, &journal.map(|(name, bytes)| (name.clone(), bytes.clone())).collect());
        },
    ];
    for damage in damages {
        damage();
        let before = files(&folder);
        let other = DatasetInfo { seed: 1, ..info() };
        let error = DatasetWriter::create(&folder, &other, Existing::Resume).err().expect("refused").to_string();
        assert!(error.contains("20 of 150 rows of a different study") && error.contains("seed"), "{error}");
        assert_eq!(files(&folder), before);
        let resumed = resume(&folder).expect("resumed");
        assert_eq!((resumed.again, resumed.damaged.len()), (ROWS - 20, 0), "{:?}", resumed.notes);
        assert!(resumed.notes[0].contains("rebuilt from the journal with 20 rows"), "{:?}", resumed.notes);
        assert_eq!(contract(&folder), contract(&whole));
        restore(&folder, &begun);
    }
    // Without the description nobody knows what the rows are of.
    fs::remove_file(folder.join(".journal/study.json")).expect("removed");
    fs::write(folder.join("manifest.json"), "x\n").expect("written");
    let before = files(&folder);
    let error = resume(&folder).err().expect("refused");
    assert!(matches!(error, DatasetError::Lost { .. }) && error.is_usage(), "{error}");
    assert!(error.to_string().contains("manifest.json, line 1, column 1"), "{error}");
    fs::remove_file(folder.join("manifest.json")).expect("removed");
    let error = resume(&folder).err().expect("refused");
    assert!(matches!(error, DatasetError::Occupied { .. }), "{error}");
    fs::write(folder.join("manifest.json"), "x\n").expect("written");
    assert_eq!(files(&folder), before);
}

#[test]
fn rows_of_another_study_in_the_journal_are_put_aside() {
    let (_scratch, whole) = dataset();
    let scratch = TempDir::new().expect("scratch folder");
    let [folder, other] = ["own", "other"].map(|name| scratch.path().join(name));
    for (place, seed, rows) in [(&folder, info().seed, 0..20), (&other, 1, 64..70)] {
        let info = DatasetInfo { seed, ..info() };
        let mut writer = DatasetWriter::create(place, &info, Existing::Refuse).expect("created");
        rows.into_iter().for_each(|row| writer.write(&record(row, outcome(row))).expect("taken"));
    }
    let name = ".journal/000000000064.rows";
    fs::copy(other.join(name), folder.join(name)).expect("copied");
    let resumed = resume(&folder).expect("resumed");
    assert_eq!(resumed.again, ROWS - 20);
    assert!(resumed.notes.len() == 1 && resumed.notes[0].contains("rows of another study"), "{:?}", resumed.notes);
    assert!(folder.join(".damaged/000000000064.rows").exists());
    fs::remove_dir_all(folder.join(".damaged")).expect("removed");
    assert_eq!(contract(&folder), contract(&whole));
}

#[test]
fn rows_behind_a_damaged_one_are_found_in_the_journal() {
    let scratch = TempDir::new().expect("scratch folder");
    let mut writer = DatasetWriter::create(scratch.path(), &info(), Existing::Refuse).expect("created");
    (0..60).for_each(|row| writer.write(&record(row, outcome(row))).expect("taken"));
    drop(writer);
    let path = scratch.path().join(".journal/000000000000.rows");
    let bytes = fs::read(&path).expect("journal");
    let written = bytes.iter().rposition(|byte| *byte != 0).expect("rows");
    // The head of the file, the length of the first row, somewhere in the middle.
    for (at, most) in [(3, 0), (41, 1), (written / 2, 1)] {
        fs::write(&path, flip(&bytes, at)).expect("written");
        let writer = DatasetWriter::create(scratch.path(), &info(), Existing::Resume).expect("opened");
        let left = writer.rows_left();
        let lost = left.iter().filter(|span| span.first < 60).map(|span| span.end.min(60) - span.first);
        assert_eq!(lost.sum::<u64>(), most, "byte {at}");
        assert!(writer.notes().iter().any(|note| note.contains("not complete rows")), "{:?}", writer.notes());
    }
}

#[test]
fn a_replaced_dataset_stays_until_the_new_one_is_whole() {
    let (_scratch, folder) = dataset();
    let whole = contract(&folder);
    let replace = |rows: u64| {
        let mut writer = DatasetWriter::create(&folder, &info(), Existing::Replace).expect("replaced");
        assert!(writer.notes()[0].contains(".replaced"), "{:?}", writer.notes());
        (0..rows).for_each(|row| writer.write(&record(row, outcome(row))).expect("taken"));
        writer.finish().expect("finished").complete
    };
    assert!(!replace(70));
    assert_eq!(contract(&folder.join(".replaced/1")), whole);
    assert!(!replace(3));
    assert_eq!(contract(&folder.join(".replaced/1")), whole);
    assert_eq!(DatasetReader::open(&folder.join(".replaced/2")).expect("opened").manifest().rows_done, 70);
    resume(&folder).expect("resumed");
    assert!(!folder.join(".replaced").exists());
    assert_eq!(contract(&folder), whole);
}

#[test]
fn a_merge_goes_on_without_timings() {
    let (_scratch, whole) = dataset();
    let scratch = TempDir::new().expect("scratch folder");
    let shards: Vec<PathBuf> = [(0, 100), (100, ROWS)]
        .map(|(first, end)| {
            let folder = scratch.path().join(first.to_string());
            let mut writer =
                DatasetWriter::open(&folder, &info(), RowSpan { first, end }, Existing::Refuse).expect("created");
            (first..end).for_each(|row| writer.write(&record(row, outcome(row))).expect("taken"));
            writer.finish().expect("finished");
            folder
        })
        .to_vec();
    fs::remove_file(shards[0].join("timings/timings-000000000064.parquet")).expect("removed");
    fs::write(shards[1].join("timings.json"), "garbage").expect("written");
    let merged = merge(&shards, &scratch.path().join("merged"), Existing::Refuse).expect("merged");
    assert!(merged.notes.len() == 1 && merged.notes[0].contains("wall times of 36 rows"), "{:?}", merged.notes);
    assert_eq!(contract(&scratch.path().join("merged")), contract(&whole));
    // Neither shard may lie within the output, nor the output within a shard.
    for output in [shards[0].join("runs"), scratch.path().to_owned(), shards[0].join("merged"), shards[1].join("a/b")] {
        let error = merge(&shards, &output, Existing::Replace).expect_err("refused").to_string();
        assert!(error.contains("folder of its own"), "{error}");
    }
    assert!(!shards[0].join("merged").exists() && !shards[1].join("a").exists());
}

/// A copy of a dataset's files.
fn restore(folder: &Path, files: &BTreeMap<PathBuf, Vec<u8>>) {
    let _ = fs::remove_dir_all(folder);
    for (name, bytes) in files {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("folder");
        fs::write(path, bytes).expect("file");
    }
}

/// Flips a byte, cuts, overwrites or removes a file. Returns what was done, in words.
fn corrupt(path: &Path, bytes: &[u8], random: &mut impl Iterator<Item = u64>) -> String {
    let mut below = |limit: usize| random.next().map_or(0, |number| number as usize % limit.max(1));
    let at = below(bytes.len());
    let damaged = match below(5) {
        0 => {
            fs::remove_file(path).expect("removed");
            return "removed".to_owned();
        }
        1 => bytes[..at].to_vec(),
        2 => [&bytes[..at], b"garbage", &bytes[at..]].concat(),
        3 => vec![0; bytes.len()],
        _ => flip(bytes, at),
    };
    fs::write(path, damaged).expect("written");
    format!("changed from byte {at}")
}

/// Rows that a file holds alone: a row of it may be computed again.
fn rows_of(name: &Path) -> u64 {
    let text = name.to_string_lossy();
    let first: u64 = text.chars().filter(char::is_ascii_digit).collect::<String>().parse().unwrap_or(0);
    let is_of_rows = ["runs", "blows", ".journal"].iter().any(|table| name.starts_with(table));
    if is_of_rows { 64.min(ROWS - first) } else { 0 }
}

#[test]
fn corruptions_of_every_file_are_mended_and_said() {
    let count: usize = std::env::var(CORRUPTIONS).ok().and_then(|text| text.parse().ok()).unwrap_or(60);
    let (_scratch, whole) = dataset();
    let scratch = TempDir::new().expect("scratch folder");
    // A finished dataset, and one that was stopped.
    let stopped = scratch.path().join("stopped");
    let mut writer = DatasetWriter::create(&stopped, &info(), Existing::Refuse).expect("created");
    (0..100).for_each(|row| writer.write(&record(row, outcome(row))).expect("taken"));
    drop(writer);
    let origins = [(files(&whole), 0), (files(&stopped), ROWS - 100)];
    let next =
        |state: &u64| Some(state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407));
    let mut random = std::iter::successors(Some(17), next).skip(1).map(|state| state >> 33);
    let expected = contract(&whole);
    let (mut unchanged, mut again) = (0, 0);
    for number in 0..count {
        let (origin, left) = &origins[number % 2];
        let folder = scratch.path().join("damaged");
        restore(&folder, origin);
        let name = origin.keys().nth((number / 2) % origin.len()).expect("a file");
        let what = corrupt(&folder.join(name), &origin[name], &mut random);
        let what = format!("corruption {number}: {} {what}", name.display());
        if fs::read(folder.join(name)).ok().as_ref() == Some(&origin[name]) {
            unchanged += 1;
            continue;
        }
        let resumed = resume(&folder).unwrap_or_else(|error| panic!("{what}: {error}"));
        let mut found = contract(&folder);
        found.retain(|name, _| !name.starts_with(".damaged"));
        assert!(found == expected, "{what}: other bytes");
        let lost = resumed.again - left;
        assert!(lost <= rows_of(name), "{what}: {lost} rows computed again");
        // Zeros cut from the end of the journal, and whole files of it that are gone, are all that leaves no trace.
        let silent = resumed.damaged.is_empty() && resumed.notes.is_empty();
        assert!(!silent || name.starts_with(".journal"), "{what}: silent");
        again += lost;
    }
    println!(
        "{count} corruptions ({unchanged} without effect): all rows there with the same bytes, {again} rows computed again"
    );
}

#[test]
fn verify_reads_everything_and_strays_are_named() {
    let (_scratch, folder) = dataset();
    // With the separators of all systems.
    let faults = || -> Vec<String> {
        verify(&folder).expect("verified").faults.iter().map(|fault| fault.replace('\\', "/")).collect()
    };
    assert_eq!(faults(), Vec::<String>::new());
    let origin = files(&folder);
    let stray = "runs/runs-000000000000 (1).parquet";
    let cases: [(&str, &dyn Fn(), &str); 5] = [
        (
            "stray",
            &|| _ = fs::copy(folder.join("runs/runs-000000000000.parquet"), folder.join(stray)).expect("copied"),
            stray,
        ),
        ("manifest", &|| fs::write(folder.join("manifest.json"), "{").expect("written"), "manifest.json was lost"),
        ("timings", &|| fs::remove_file(folder.join("timings.json")).expect("removed"), "timings.json was lost"),
        (
            "part",
            &|| fs::write(folder.join("blows/blows-000000000064.parquet"), "cut").expect("cut"),
            "blows-000000000064",
        ),
        (
            "gone",
            &|| fs::remove_file(folder.join("runs/runs-000000000128.parquet")).expect("gone"),
            "runs-000000000128",
        ),
    ];
    for (name, damage, words) in cases {
        damage();
        let found = faults();
        assert!(found.len() == 1 && found[0].contains(words), "{name}: {found:?}");
        restore(&folder, &origin);
    }
    // A resumed run names strays and leaves them, a reader refuses them.
    fs::write(folder.join(stray), "a copy").expect("written");
    let resumed = resume(&folder).expect("resumed");
    assert!(resumed.notes.len() == 1 && resumed.notes[0].contains("(1).parquet"), "{:?}", resumed.notes);
    assert!(faults()[0].contains("move it elsewhere"), "{:?}", faults());
    let reader = DatasetReader::open(&folder).expect("opened");
    assert!(reader.damage_at_a_glance().len() == 1 && folder.join(stray).exists());
    let error = summarise(&reader, &ReportSettings::default()).expect_err("refused").to_string();
    assert!(error.contains("(1).parquet") && error.contains("move it elsewhere"), "{error}");
    let error = reader.batches(TableName::Blows).next().expect("an error").expect_err("refused").to_string();
    assert!(error.contains("(1).parquet"), "{error}");
    // Rows still to come are no fault of the files, but the dataset is not whole.
    let scratch = TempDir::new().expect("scratch folder");
    let mut writer = DatasetWriter::create(scratch.path(), &info(), Existing::Refuse).expect("created");
    (0..100).for_each(|row| writer.write(&record(row, outcome(row))).expect("taken"));
    assert!(matches!(verify(scratch.path()), Err(DatasetError::InUse { .. })));
    drop(writer);
    let found = verify(scratch.path()).expect("verified");
    assert_eq!((found.rows_done, found.rows_in_journal, found.rows), (64, 36, ROWS));
    assert_eq!(found.faults, ["rows 64 to 149 are in no part"]);
}

#[test]
fn verify_has_an_exit_code_and_status_says_what_it_has_not_read() {
    let (_scratch, folder) = dataset();
    let run = |command: &str| {
        let mut process = crate::sweeps::decore();
        let ended = process.arg(command).arg(&folder).output().expect("decore runs");
        (ended.status.code(), String::from_utf8_lossy(&ended.stdout).into_owned())
    };
    let (code, text) = run("verify");
    assert!(code == Some(0) && text.contains("whole") && text.contains("150 of 150 rows in 9 parts"), "{text}");
    assert!(run("status").1.contains("were not read: `decore verify"), "{}", run("status").1);
    // Of the same length: only reading finds it. Of another length: status does, too.
    let path = folder.join("runs/runs-000000000000.parquet");
    let bytes = fs::read(&path).expect("part");
    fs::write(&path, flip(&bytes, bytes.len() / 2)).expect("written");
    let (code, text) = run("verify");
    assert!(code == Some(8) && text.contains("NOT WHOLE") && text.contains("runs-000000000000.parquet"), "{text}");
    fs::write(&path, &bytes[1..]).expect("written");
    let (code, text) = run("status");
    assert!(code == Some(0) && text.contains("DAMAGED") && text.contains("runs-000000000000.parquet"), "{text}");
}

#[test]
fn a_part_cut_off_in_its_replacement_is_no_loss_and_said() {
    let (_scratch, folder) = dataset();
    let whole = contract(&folder);
    let rows = RerunSelection::Rows(vec![RowSpan { first: 0, end: 64 }]);
    let mut writer = DatasetWriter::again(&folder, &info(), RowSpan { first: 0, end: ROWS }, &rows).expect("again");
    (0..63).for_each(|row| writer.write(&record(row, outcome(row))).expect("taken"));
    drop(writer);
    // As after a process that ended between the renames of two files.
    let path = folder.join("runs/runs-000000000000.parquet");
    let bytes = fs::read(&path).expect("part");
    fs::write(&path, flip(&bytes, bytes.len() / 2)).expect("written");
    let found = verify(&folder).expect("verified");
    assert!(
        found.faults.len() == 1 && found.faults[0].contains("the journal has all their rows"),
        "{:?}",
        found.faults
    );
    let resumed = resume(&folder).expect("resumed");
    assert!(resumed.again == 0 && resumed.damaged.is_empty(), "{} rows, {:?}", resumed.again, resumed.damaged);
    assert_eq!(contract(&folder), whole);
}

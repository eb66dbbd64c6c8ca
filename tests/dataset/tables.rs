//! The dataset: what is written can be read, is the same for any number of threads, and nothing half-written is ever in
//! place.

use std::fs;
use std::path::{Path, PathBuf};

use crate::synthetic::{ROWS, contract, dataset, files, info, outcome, record, write};
use decore_dataset::{
    Columns, DatasetError, DatasetInfo, DatasetReader, DatasetWriter, Existing, RowRecord, RowSpan, Source, TableName,
    merge, rows_per_part, verify,
};
use decore_quantity::{Kind, Value};
use tempfile::TempDir;

#[test]
fn one_and_two_threads_give_the_same_bytes() {
    let scratch = TempDir::new().expect("scratch folder");
    let [one, two] = [1, 2].map(|threads| {
        let folder = scratch.path().join(threads.to_string());
        write(&folder, threads);
        files(&folder)
    });
    let names: Vec<&PathBuf> = one.keys().collect();
    assert_eq!(names, two.keys().collect::<Vec<_>>());
    assert_eq!(names.len(), 2 + 3 * 3, "two manifests, three parts of each table: {names:?}");
    for (name, bytes) in &one {
        let depends_on_machine = name.starts_with("timings") || *name == Path::new("timings.json");
        assert_eq!(*bytes == two[name], !depends_on_machine, "{}", name.display());
    }
}

#[test]
fn every_value_comes_back() {
    let (_scratch, folder) = dataset();
    let reader = DatasetReader::open(&folder).expect("opened");
    let columns = Columns::new(&info()).expect("unique");
    let names: Vec<&str> = columns.runs.iter().map(|column| column.description.name.as_str()).collect();
    let mut row = 0;
    let mut texts = 0;
    reader
        .visit(TableName::Runs, &names, |cells| {
            let record = record(row, outcome(row));
            let info = info();
            let source = Source::new(&info, &record);
            for (column, cell) in columns.runs.iter().zip(cells) {
                assert_eq!(*cell, column.cell(&source), "row {row}, {}", column.description.name);
                texts += u64::from(matches!(cell, Some(Value::Text(_))));
            }
            row += 1;
        })
        .expect("read");
    // Status, reason and a factor of every row; of one that is done the percussions of two hammers, the lesser of them, a casting's
    // fastest point, and warnings.
    assert_eq!((row, texts), (ROWS, 3 * ROWS + 5 * 129));
    assert_eq!(verify(&folder).expect("verified").faults, Vec::<String>::new());
}

#[test]
fn blows_name_their_hammer_and_casting() {
    let (_scratch, folder) = dataset();
    let reader = DatasetReader::open(&folder).expect("opened");
    let mut last = Vec::new();
    let mut count = 0;
    let names = ["row", "hammer", "casting", "number", "kind", "work_j"];
    reader
        .visit(TableName::Blows, &names, |cells| {
            count += 1;
            last = cells.iter().flatten().map(|value| value.owned()).collect();
        })
        .expect("read");
    let done = (0..ROWS).filter(|row| row % 7 != 3).count();
    assert_eq!(count, 3 * done);
    // Row 149 is done (149 = 7 * 21 + 2).
    let text = |text: &str| Value::Text(text.to_owned());
    let (row, number, work) = (Value::Count(149), Value::Count(6), Value::Real(149.0));
    assert_eq!(last, [row, text("right-hand"), text("1st"), number, text("periodic"), work]);
}

#[test]
fn columns_are_safe_names_with_unit_and_description() {
    let columns = Columns::new(&info()).expect("unique");
    for table in TableName::ALL {
        for column in columns.describe(table) {
            let safe = |c: char| c.is_ascii_alphanumeric() || c == '_';
            assert!(column.name.chars().all(safe), "{}", column.name);
            assert!(!column.name.starts_with(|c: char| c.is_ascii_digit()), "{}", column.name);
            assert_eq!(column.unit.is_empty(), column.kind.is_text(), "{}", column.name);
            assert!(column.description.len() > 8, "{}", column.name);
        }
    }
    let names: Vec<String> = columns.describe(TableName::Runs).into_iter().map(|column| column.name).collect();
    for name in [
        "factor_hammer_left_supply_bar",
        "factor_n_2nd_mount",
        "left_first_impact_energy_j",
        "right_hand_hit_frequency_hz",
        "casting_1st_peak_velocity_m_s",
    ] {
        assert!(names.iter().any(|other| other == name), "{name} in {names:?}");
    }
}

#[test]
fn every_getter_gives_its_columns_type() {
    let info = info();
    let columns = Columns::new(&info).expect("unique");
    let record = record(1, outcome(1));
    let source = Source::new(&info, &record);
    for column in columns.runs.iter().chain(&columns.timings) {
        let description = &column.description;
        let same = |kind: Kind| kind == description.kind || (kind.is_text() && description.kind.is_text());
        let fits = column.cell(&source).is_none_or(|value| same(value.kind()));
        assert!(fits, "{}", description.name);
    }
}

#[test]
fn aggregates_are_sums_over_the_hammers() {
    let (_scratch, folder) = dataset();
    let reader = DatasetReader::open(&folder).expect("opened");
    let names = [
        "row",
        "hammers_striking",
        "total_first_impact_energy_j",
        "min_first_impact_energy_j",
        "total_periodic_power_w",
        "delivered_work_in_windows_j",
        "total_air_used_nl",
        "hammers_percussing",
        "delivered_work_j",
    ];
    reader
        .visit(TableName::Runs, &names, |cells| {
            let [Some(Value::Count(row)), Some(Value::Count(striking)), numbers @ ..] = cells else {
                return;
            };
            let numbers: Vec<f64> = numbers.iter().filter_map(|cell| cell.and_then(|value| value.number())).collect();
            let energy = 60.0 + (*row as f64).sin();
            let hammers = if row % 5 == 0 { 1 } else { 2 };
            assert_eq!(*striking, hammers);
            let windows = 0.1 * energy + 2.0 + *row as f64;
            let (percussing, work) = (hammers as f64, *row as f64);
            let expected = [hammers as f64 * energy, energy, 2.0 * 12.0 * 20.0, windows, 10.0, percussing, work];
            assert_eq!(numbers.len(), expected.len());
            for (found, expected) in numbers.iter().zip(expected) {
                assert!((found - expected).abs() <= 1e-12 * expected.abs(), "row {row}: {numbers:?}");
            }
            assert_eq!(numbers.len(), expected.len());
        })
        .expect("read");
}

#[test]
fn names_that_give_one_column_are_refused_before_anything_is_written() {
    let scratch = TempDir::new().expect("scratch folder");
    let folder = scratch.path().join("sweep");
    let clash = DatasetInfo { hammers: vec!["a-b".to_owned(), "A.b".to_owned()], ..info() };
    let error = DatasetWriter::create(&folder, &clash, Existing::Refuse).err().expect("refused");
    assert!(matches!(error, DatasetError::DuplicateColumn { .. }), "{error}");
    let text = error.to_string();
    assert!(text.contains("`a-b`") && text.contains("`A.b`") && text.contains("rename"), "{text}");
    assert!(!folder.exists());
}

#[test]
fn an_existing_dataset_is_refused_or_replaced() {
    let (_scratch, folder) = dataset();
    let before = files(&folder);
    let error = DatasetWriter::create(&folder, &info(), Existing::Refuse).err().expect("refused");
    assert!(error.to_string().contains("150 of 150 rows"), "{error}");
    assert_eq!(before, files(&folder));

    fs::write(folder.join("notes.txt"), "mine").expect("written");
    let writer = DatasetWriter::create(&folder, &info(), Existing::Replace).expect("replaced");
    let manifest = writer.finish().expect("finished");
    assert_eq!((manifest.rows_done, manifest.complete), (0, false));
    let mut after: Vec<PathBuf> = files(&folder).into_keys().collect();
    after.retain(|name| !name.starts_with(".replaced"));
    assert_eq!(after, ["manifest.json", "notes.txt", "timings.json"].map(PathBuf::from));
}

#[test]
fn a_folder_of_other_things_is_never_touched() {
    let scratch = TempDir::new().expect("scratch folder");
    fs::create_dir(scratch.path().join("runs")).expect("folder");
    fs::write(scratch.path().join("runs/thesis.txt"), "years of work").expect("written");
    for existing in [Existing::Refuse, Existing::Replace] {
        let error = DatasetWriter::create(scratch.path(), &info(), existing).err().expect("refused");
        assert!(matches!(error, DatasetError::Occupied { .. }), "{error}");
    }
    assert_eq!(files(scratch.path()).len(), 1);
}

#[test]
fn an_interrupted_creation_can_be_repeated() {
    let scratch = TempDir::new().expect("scratch folder");
    fs::create_dir(scratch.path().join("runs")).expect("folder");
    fs::create_dir(scratch.path().join(".staging")).expect("folder");
    fs::write(scratch.path().join(".staging/manifest.json.partial"), "{").expect("written");
    DatasetWriter::create(scratch.path(), &info(), Existing::Refuse).expect("created");
}

#[test]
fn a_writer_that_is_dropped_leaves_whole_parts_only() {
    let scratch = TempDir::new().expect("scratch folder");
    let folder = scratch.path().join("sweep");
    let mut writer = DatasetWriter::create(&folder, &info(), Existing::Refuse).expect("created");
    for row in 0..100 {
        writer.write(&record(row, outcome(row))).expect("taken");
    }
    drop(writer);
    let reader = DatasetReader::open(&folder).expect("opened");
    assert_eq!(reader.manifest().done, [RowSpan { first: 0, end: 64 }]);
    let names: Vec<PathBuf> = files(&folder).into_keys().collect();
    let expected = [
        ".journal/000000000064.rows",
        ".journal/study.json",
        "blows/blows-000000000000.parquet",
        "manifest.json",
        "runs/runs-000000000000.parquet",
        "timings/timings-000000000000.parquet",
        "timings.json",
    ];
    assert_eq!(names, expected.map(PathBuf::from));
    assert!(!folder.join(".staging").exists());
}

#[test]
fn rows_left_out_are_gaps_in_the_manifest() {
    let scratch = TempDir::new().expect("scratch folder");
    let mut writer = DatasetWriter::create(scratch.path(), &info(), Existing::Refuse).expect("created");
    for row in [1, 2, 70, 149] {
        writer.write(&record(row, outcome(row))).expect("taken");
    }
    let manifest = writer.finish().expect("finished");
    let spans: Vec<(u64, u64)> = manifest.done.iter().map(|span| (span.first, span.end)).collect();
    assert_eq!(spans, [(1, 3), (70, 71), (149, 150)]);
    assert_eq!((manifest.rows_done, manifest.complete), (4, false));
    let parts: Vec<u64> = manifest.runs.iter().map(|part| part.first_row).collect();
    assert_eq!(parts, [0, 64, 128], "parts begin at fixed rows");
}

#[test]
fn records_that_do_not_fit_are_refused() {
    let scratch = TempDir::new().expect("scratch folder");
    let mut writer = DatasetWriter::create(scratch.path(), &info(), Existing::Refuse).expect("created");
    let good = || record(5, outcome(5));
    let refusal =
        |writer: &mut DatasetWriter, record: RowRecord| writer.write(&record).expect_err("refused").to_string();

    let mut few_factors = good();
    few_factors.factors.pop();
    assert!(refusal(&mut writer, few_factors).contains("number of factors: found 2, expected 3"));
    let mut wrong_type = good();
    wrong_type.factors[0] = Value::Integer(4);
    assert!(refusal(&mut writer, wrong_type).contains("factor `hammer.left.supply_bar`: found Integer, expected Real"));
    let mut no_casting = good();
    no_casting.outcome.metrics.as_mut().expect("done").blows[0].casting = 1;
    assert!(refusal(&mut writer, no_casting).contains("index of a blow's casting: found 1, expected below 1"));
    let mut hammers = good();
    hammers.outcome.metrics.as_mut().expect("done").hammers.pop();
    assert!(refusal(&mut writer, hammers).contains("number of hammers: found 1, expected 2"));

    writer.write(&good()).expect("taken");
    let text = refusal(&mut writer, good());
    assert!(text.contains("row 5 is unexpected") && text.contains("from 0"), "{text}");
    assert!(refusal(&mut writer, record(150, outcome(150))).contains("not including, 150"));
    assert_eq!(writer.finish().expect("finished").rows_done, 1);
}

#[test]
fn no_rows_per_part_is_an_error() {
    let scratch = TempDir::new().expect("scratch folder");
    let none = DatasetInfo { rows_per_part: 0, ..info() };
    let error = DatasetWriter::create(scratch.path(), &none, Existing::Refuse).err().expect("refused");
    assert!(error.to_string().contains("rows_per_part"), "{error}");
}

#[test]
fn parts_have_a_size_that_depends_on_the_design_only() {
    let sizes = [0, 1, 4_096, 100_000, 1_000_000, u64::MAX].map(rows_per_part);
    assert_eq!(sizes, [64, 64, 64, 2048, 4096, 4096]);
}

#[test]
fn damage_is_named() {
    let (_scratch, folder) = dataset();
    let path = folder.join("runs/runs-000000000064.parquet");
    let bytes = fs::read(&path).expect("part");
    fs::write(&path, &bytes[..bytes.len() / 2]).expect("cut short");
    let missing = folder.join("blows/blows-000000000128.parquet");
    fs::remove_file(&missing).expect("removed");
    let reader = DatasetReader::open(&folder).expect("opened");
    let damage = verify(&folder).expect("verified").faults;
    assert_eq!(damage.len(), 2, "{damage:?}");
    assert!(damage[0].contains("runs-000000000064.parquet") && damage[0].contains("BLAKE3"), "{damage:?}");
    assert!(damage[1].contains("blows-000000000128.parquet"), "{damage:?}");
    let error = reader.visit(TableName::Runs, &["row"], |_| {}).expect_err("cut short");
    assert!(error.to_string().contains("runs-000000000064.parquet"), "{error}");
}

#[test]
fn folders_without_dataset_and_bad_manifests_are_explained() {
    let scratch = TempDir::new().expect("scratch folder");
    let open = || DatasetReader::open(scratch.path()).expect_err("refused");
    assert!(matches!(open(), DatasetError::Missing { .. }));
    fs::write(scratch.path().join("manifest.json"), "{\n  \"format_version\": 99 }").expect("written");
    assert!(open().to_string().contains("`format_version` is 99, expected 6"), "{}", open());
    fs::write(scratch.path().join("manifest.json"), "{\n  \"format_version\": 6,\n").expect("written");
    assert!(open().to_string().contains("manifest.json, line 3"), "{}", open());
}

#[test]
fn an_unknown_column_gets_a_suggestion() {
    let (_scratch, folder) = dataset();
    let reader = DatasetReader::open(&folder).expect("opened");
    let error = reader.visit(TableName::Runs, &["left_hit_frequenzy_hz"], |_| {}).expect_err("unknown");
    assert!(error.to_string().contains("did you mean `left_hit_frequency_hz`?"), "{error}");
}

#[test]
fn what_a_dropped_writer_had_is_continued_with_the_same_bytes() {
    let (_scratch, undisturbed) = dataset();
    let scratch = TempDir::new().expect("scratch folder");
    let folder = scratch.path().join("sweep");
    // Stopped within a part, cleanly, within the next part, not cleanly, and in between.
    for (stop, finish) in [(20, true), (40, false), (64, true), (100, false), (ROWS, true)] {
        let mut writer = DatasetWriter::create(&folder, &info(), Existing::Resume).expect("opened");
        let left = writer.rows_left();
        for row in left.iter().flat_map(|span| span.first..span.end).take_while(|row| *row < stop) {
            writer.write(&record(row, outcome(row))).expect("taken");
        }
        assert_eq!(writer.rows_left().first().map_or(ROWS, |span| span.first), stop);
        if finish {
            assert_eq!(writer.finish().expect("finished").rows_done, stop);
        }
    }
    assert_eq!(contract(&folder), contract(&undisturbed));
}

#[test]
fn rows_in_any_order_give_the_same_bytes() {
    let (_scratch, ordered) = dataset();
    let scratch = TempDir::new().expect("scratch folder");
    let mut writer = DatasetWriter::create(scratch.path(), &info(), Existing::Refuse).expect("created");
    for step in 0..ROWS {
        let row = step * 77 % ROWS;
        writer.write(&record(row, outcome(row))).expect("taken");
    }
    assert!(writer.finish().expect("finished").complete);
    assert_eq!(contract(scratch.path()), contract(&ordered));
}

#[test]
fn damaged_parts_are_taken_away_and_their_rows_asked_for() {
    let (_scratch, folder) = dataset();
    let whole = contract(&folder);
    let cut = folder.join("runs/runs-000000000064.parquet");
    let bytes = fs::read(&cut).expect("part");
    fs::write(&cut, &bytes[..bytes.len() / 2]).expect("cut short");
    let mut writer = DatasetWriter::create(&folder, &info(), Existing::Resume).expect("opened");
    assert!(writer.damaged()[0].to_string().contains("runs-000000000064.parquet"), "{:?}", writer.damaged());
    assert_eq!(writer.rows_left(), [RowSpan { first: 64, end: 128 }]);
    assert!(!cut.exists(), "no reader may trip over it");
    for row in 64..128 {
        writer.write(&record(row, outcome(row))).expect("taken");
    }
    writer.finish().expect("finished");
    fs::remove_dir_all(folder.join(".damaged")).expect("kept aside");
    assert_eq!(contract(&folder), whole);
}

#[test]
fn another_study_is_refused_with_what_changed() {
    let (_scratch, folder) = dataset();
    let before = files(&folder);
    let mut changed = DatasetInfo { study_hash: "1".to_owned(), ..info() };
    changed.study_text = changed.study_text.replace("name = \"synthetic\"", "name = \"other\"");
    let error = DatasetWriter::create(&folder, &changed, Existing::Resume).err().expect("refused");
    assert!(matches!(error, DatasetError::Changed { .. }), "{error}");
    assert!(error.to_string().contains("study.name: \"synthetic\" -> \"other\""), "{error}");
    assert_eq!(files(&folder), before);
    // Comments are no change, and the first text stays.
    let retold = DatasetInfo { study_text: "# more\n".to_owned(), ..info() };
    DatasetWriter::create(&folder, &retold, Existing::Resume).expect("opened").finish().expect("finished");
    assert_eq!(files(&folder), before);
}

/// A program of the same version whose tables have one column more would leave parts of two kinds.
#[test]
fn other_columns_are_refused_before_a_row_runs() {
    let scratch = TempDir::new().expect("scratch folder");
    let mut writer = DatasetWriter::create(scratch.path(), &info(), Existing::Refuse).expect("created");
    writer.write(&record(0, outcome(0))).expect("taken");
    drop(writer);
    let changed = DatasetInfo { columns_hash: "of one more".to_owned(), ..info() };
    let error = DatasetWriter::create(scratch.path(), &changed, Existing::Resume).err().expect("refused");
    assert!(matches!(error, DatasetError::Changed { .. }), "{error}");
    let said = error.to_string();
    assert!(said.contains("contains 1 of 150 rows"), "rows in the journal count: {said}");
    assert!(said.contains("columns of the tables: this program has others"), "{said}");
    // A dataset without a hash of its columns is gone on with.
    let silent = DatasetInfo { columns_hash: String::new(), ..info() };
    DatasetWriter::create(scratch.path(), &silent, Existing::Resume).expect("opened");
}

/// An undamaged dataset with other columns is not damaged.
#[test]
fn other_columns_are_named_where_a_dataset_is_read() {
    let scratch = TempDir::new().expect("scratch folder");
    let other = DatasetInfo { columns_hash: "of one more".to_owned(), ..info() };
    let mut writer = DatasetWriter::create(scratch.path(), &other, Existing::Refuse).expect("created");
    writer.write(&record(0, outcome(0))).expect("taken");
    writer.finish().expect("finished");
    let error = DatasetReader::open(scratch.path()).expect_err("refused");
    assert!(error.is_usage() && error.to_string().contains("the columns of another decore (version 0.1.0)"), "{error}");
}

#[test]
fn a_dataset_has_one_writer_at_a_time() {
    let scratch = TempDir::new().expect("scratch folder");
    let writer = DatasetWriter::create(scratch.path(), &info(), Existing::Resume).expect("opened");
    for existing in [Existing::Resume, Existing::Replace] {
        let error = DatasetWriter::create(scratch.path(), &info(), existing).err().expect("refused");
        assert!(matches!(error, DatasetError::InUse { .. }), "{error}");
        assert!(error.to_string().contains(&std::process::id().to_string()), "{error}");
    }
    drop(writer);
    DatasetWriter::create(scratch.path(), &info(), Existing::Resume).expect("free again");
}

/// The shards of the synthetic dataset with the given bounds.
fn shards(folder: &Path, bounds: &[u64]) -> Vec<PathBuf> {
    let write = |bounds: &[u64]| {
        let folder = folder.join(format!("shard-{}", bounds[0]));
        let range = RowSpan { first: bounds[0], end: bounds[1] };
        let mut writer = DatasetWriter::open(&folder, &info(), range, Existing::Refuse).expect("created");
        for row in range.first..range.end {
            writer.write(&record(row, outcome(row))).expect("taken");
        }
        assert!(writer.finish().expect("finished").complete);
        folder
    };
    bounds.windows(2).map(write).collect()
}

#[test]
fn merged_shards_are_the_whole() {
    let (_scratch, whole) = dataset();
    let scratch = TempDir::new().expect("scratch folder");
    let bounds = [0, 21, 42, 64, 64, 107, 128, ROWS];
    // The empty shard shares its folder's name with the next one.
    let folders = shards(scratch.path(), &[0, 21, 42, 64, 107, 128, ROWS]);
    assert_eq!(folders.len() + 1, bounds.len() - 1);
    let merged = scratch.path().join("merged");
    let reversed: Vec<PathBuf> = folders.iter().rev().cloned().collect();
    assert!(merge(&reversed, &merged, Existing::Refuse).expect("merged").manifest.complete);
    assert_eq!(contract(&merged), contract(&whole));
    // Again: nothing to do.
    merge(&folders, &merged, Existing::Resume).expect("merged");
    assert_eq!(contract(&merged), contract(&whole));
}

/// A merge into one of its own shards would delete it before it is read: refused, by whatever path, with all rows left.
#[test]
fn a_merge_into_one_of_its_shards_is_refused() {
    let scratch = TempDir::new().expect("scratch folder");
    let folders = shards(scratch.path(), &[0, 50, ROWS]);
    let before = contract(&folders[0]);
    let name = folders[0].file_name().expect("a name").to_owned();
    let around = folders[1].join("..").join(name);
    for (output, existing) in
        [(&folders[0], Existing::Replace), (&around, Existing::Replace), (&around, Existing::Resume)]
    {
        let error = merge(&folders, output, existing).expect_err("refused").to_string();
        assert!(error.contains("is the shard") && error.contains("folder of its own"), "{error}");
        assert_eq!(contract(&folders[0]), before);
    }
}

#[test]
fn shards_that_make_no_whole_are_refused() {
    let scratch = TempDir::new().expect("scratch folder");
    let folders = shards(scratch.path(), &[0, 50, 100, ROWS]);
    let refusal = |folders: &[PathBuf]| {
        let output = scratch.path().join("merged");
        let error = merge(folders, &output, Existing::Refuse).expect_err("refused").to_string();
        assert!(!output.exists());
        error
    };
    let [first, second, third] = [0, 1, 2].map(|index| folders[index].clone());
    let text = refusal(&[first.clone(), third.clone()]);
    assert!(text.contains("no shard has rows 50 to 99"), "{text}");
    let text = refusal(&[first.clone(), second.clone()]);
    assert!(text.contains("no shard has rows 100 to 149"), "{text}");
    let text = refusal(&[first.clone(), second.clone(), second.clone(), third.clone()]);
    assert!(text.contains("rows 50 to 99 of") && text.contains("another shard"), "{text}");
    let incomplete = scratch.path().join("incomplete");
    let range = RowSpan { first: 50, end: 100 };
    let mut writer = DatasetWriter::open(&incomplete, &info(), range, Existing::Refuse).expect("created");
    (50..80).for_each(|row| writer.write(&record(row, outcome(row))).expect("taken"));
    writer.finish().expect("finished");
    let text = refusal(&[first.clone(), incomplete, third.clone()]);
    assert!(text.contains("lacks rows 80 to 99"), "{text}");
    let part = second.join("blows/blows-000000000000.parquet");
    fs::write(&part, "cut").expect("damaged");
    let text = refusal(&[first.clone(), second, third.clone()]);
    assert!(text.contains("blows-000000000000.parquet"), "{text}");
    let other = scratch.path().join("other");
    let info = DatasetInfo { study_hash: "1".to_owned(), seed: 3, ..info() };
    DatasetWriter::open(&other, &info, range, Existing::Refuse).expect("created").finish().expect("finished");
    let text = refusal(&[first, other, third]);
    assert!(text.contains("shards of different studies") && text.contains("seed"), "{text}");
}

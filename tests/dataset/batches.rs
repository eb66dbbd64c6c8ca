//! Tables as batches of Arrow: those of a dataset hold what is visited, those of rows in memory what the dataset holds. Datasets stay
//! what they are: another one in their place is not read as them.

use arrow_array::{Array, RecordBatch, RecordBatchReader};
use arrow_schema::ArrowError;
use decore_dataset::{
    Columns, DatasetError, DatasetInfo, DatasetReader, DatasetWriter, Existing, RowRecord, TableName, record_batches,
};
use decore_study::engine::{Engine, RowRunner, SweepSettings};
use std::path::Path;
use tempfile::TempDir;

use crate::synthetic::{ROWS, dataset, info, outcome, record};

fn batches(reader: &DatasetReader, table: TableName) -> Vec<RecordBatch> {
    reader.batches(table).collect::<Result<_, ArrowError>>().expect("read")
}

#[test]
fn a_dataset_s_batches_have_all_rows_and_the_columns_units() {
    let (_scratch, folder) = dataset();
    let reader = DatasetReader::open(&folder).expect("a dataset");
    for table in TableName::ALL {
        let records: u64 = reader.parts(table).iter().map(|part| part.records).sum();
        let rows: usize = batches(&reader, table).iter().map(RecordBatch::num_rows).sum();
        assert!(rows as u64 == records && reader.parts(table).len() > 1, "{table:?}: {rows} of {records}");
        let schema = reader.batches(table).schema();
        for (field, column) in schema.fields().iter().zip(reader.columns(table)) {
            assert_eq!((field.name(), &field.metadata()["unit"]), (&column.name, &column.unit));
        }
        assert_eq!(schema.metadata()["decore.study_hash"], reader.manifest().study.study_hash);
    }
}

#[test]
fn a_damaged_part_ends_the_batches_with_its_name() {
    let (_scratch, folder) = dataset();
    let reader = DatasetReader::open(&folder).expect("a dataset");
    let file = &reader.parts(TableName::Runs)[1].file;
    std::fs::write(folder.join(file), "no table").expect("written");
    let mut batches = reader.batches(TableName::Runs);
    let first_part = reader.parts(TableName::Runs)[0].records as usize;
    assert_eq!(batches.next().expect("a batch").expect("whole").num_rows(), first_part);
    let error = batches.next().expect("an error").expect_err("damaged").to_string();
    assert!(error.contains(file), "{error}");
    assert!(batches.next().is_none());
}

#[test]
fn a_part_that_a_sweep_replaced_is_told_from_a_damaged_one() {
    let scratch = TempDir::new().expect("scratch");
    let folder = scratch.path();
    let write = |rows: std::ops::Range<u64>| {
        let mut writer = DatasetWriter::create(folder, &info(), Existing::Resume).expect("opened");
        rows.for_each(|row| writer.write(&record(row, outcome(row))).expect("taken"));
        writer
    };
    write(0..100).finish().expect("finished");
    let reader = DatasetReader::open(folder).expect("a dataset");
    let rows = |table: TableName| {
        let mut rows = Vec::new();
        reader.visit(table, &["row"], |cells| rows.extend(cells[0].and_then(|row| row.number()))).map(|()| rows)
    };
    let before = TableName::ALL.map(|table| rows(table).expect("read"));
    // Rows that are not yet in a part change nothing for the reader.
    let writer = write(100..120);
    assert_eq!(TableName::ALL.map(|table| rows(table).expect("read")), before);
    // A part that is not the manifest's while a sweep writes may be one that is about to be listed.
    let part = folder.join("runs/runs-000000000064.parquet");
    let bytes = std::fs::read(&part).expect("part");
    std::fs::write(&part, "not listed").expect("written");
    assert!(matches!(rows(TableName::Runs), Err(DatasetError::Replaced { .. })));
    drop(writer);
    let error = rows(TableName::Runs).expect_err("nobody writes");
    assert!(matches!(&error, DatasetError::Damaged { .. }) && error.to_string().contains("decore verify"), "{error}");
    std::fs::write(&part, bytes).expect("restored");
    write(120..ROWS).finish().expect("finished");
    for table in TableName::ALL {
        let error = rows(table).expect_err("replaced");
        assert!(matches!(&error, DatasetError::Replaced { path } if *path == folder), "{table:?}: {error}");
    }
    let mut again = 0;
    let reader = DatasetReader::open(folder).expect("a dataset");
    reader.visit(TableName::Runs, &["row"], |_| again += 1).expect("read");
    assert_eq!(again, ROWS);
    // A row is looked for in its own part.
    std::fs::remove_file(folder.join("runs/runs-000000000000.parquet")).expect("removed");
    let found = |row: u64| reader.visit_block_of(row, (TableName::Runs, &["row"]), |_| ());
    let error = found(63).expect_err("gone").to_string();
    assert!(found(64).is_ok() && error.contains("there is no such file"), "{error}");
}

#[test]
fn a_dataset_that_was_replaced_is_not_read_as_what_it_was() {
    let (_scratch, folder) = dataset();
    let reader = DatasetReader::open(&folder).expect("a dataset");
    let info = DatasetInfo { study_hash: "another".to_owned(), ..info() };
    let mut writer = DatasetWriter::create(&folder, &info, Existing::Replace).expect("replaced");
    // While its rows are not there yet, and when they are.
    let batches = |reader: &DatasetReader| reader.batches(TableName::Runs).find_map(Result::err).map(|e| e.to_string());
    assert!(batches(&reader).is_some_and(|said| said.contains("it was replaced")), "the parts of another are missing");
    (0..ROWS).for_each(|row| writer.write(&record(row, outcome(row))).expect("taken"));
    writer.finish().expect("finished");
    assert!(batches(&reader).is_some_and(|said| said.contains("it was replaced")), "batches are those of another");
    for table in TableName::ALL {
        let error = reader.visit(table, &["row"], |_| panic!("a row of another study")).expect_err("replaced");
        assert!(matches!(&error, DatasetError::Replaced { path } if *path == folder), "{table:?}: {error}");
    }
    let again = DatasetReader::open(&folder).expect("a dataset");
    assert_eq!(
        again.batches(TableName::Runs).map(|batch| batch.expect("read").num_rows()).sum::<usize>(),
        ROWS as usize
    );
}

#[test]
fn a_sweep_makes_no_dataset_inside_another_nor_over_its_study() {
    let studies = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies");
    let scratch = TempDir::new().expect("scratch");
    let folder = scratch.path().join("sweep");
    let runs = folder.join("runs");
    std::fs::create_dir_all(runs.join("hammers")).expect("made");
    for name in ["pressure_grid.toml", "hammers/default.toml"] {
        std::fs::copy(studies.join(name), runs.join(name)).expect("copied");
    }
    let refused = |study: &Path, output: &Path, words: &str| {
        let engine = Engine::load(study, &["duration_s=0.02".to_owned()]).expect("a study");
        let settings = SweepSettings { existing: Existing::Replace, ..SweepSettings::default() };
        let said = engine.run(output, &settings).expect_err("refused").to_string();
        assert!(said.contains(words), "{said}");
    };
    refused(&runs.join("pressure_grid.toml"), &folder, "would overwrite what its rows are computed from");
    assert!(runs.join("pressure_grid.toml").exists());
    let (_scratch, other) = dataset();
    refused(&studies.join("pressure_grid.toml"), &other.join("blows/new"), "keeps its own files");
    assert!(!other.join("blows/new").exists());
}

#[test]
fn rows_in_memory_are_those_that_a_dataset_holds() {
    let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/pressure_grid.toml");
    let engine = Engine::load(&study, &["duration_s=0.12".to_owned()]).expect("a study");
    let scratch = TempDir::new().expect("scratch");
    engine.run(scratch.path(), &SweepSettings::default()).expect("run");
    let records: Vec<RowRecord> = (0..engine.checked().row_count())
        .map(|row| RowRecord {
            row: row as u64,
            factors: engine.checked().row_values(row),
            outcome: engine.outcome(row),
        })
        .collect();
    let info = engine.info();
    let memory = record_batches(&info, &Columns::new(&info).expect("columns"), &records).expect("of one shape");
    let reader = DatasetReader::open(scratch.path()).expect("a dataset");
    for (table, memory) in TableName::ALL.into_iter().zip(memory) {
        let stored = batches(&reader, table);
        assert!(stored.len() == 1 && memory.num_rows() > 0, "{table:?}");
        assert_eq!(stored[0].schema(), memory.schema());
        if table == TableName::Timings {
            continue;
        }
        for (stored, memory) in stored[0].columns().iter().zip(memory.columns()) {
            assert_eq!(stored.to_data(), memory.to_data(), "{table:?}");
        }
    }
    // A row of another shape would lose values.
    let misfit = RowRecord { factors: Vec::new(), ..records[0].clone() };
    assert!(record_batches(&info, &Columns::new(&info).expect("columns"), &[misfit]).is_err());
}

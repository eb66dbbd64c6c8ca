//! Tables as batches of Arrow: those of a dataset hold what is visited, those of rows in memory what the dataset holds.

use arrow_array::{Array, RecordBatch, RecordBatchReader};
use arrow_schema::ArrowError;
use decore::dataset::{Columns, DatasetReader, RowRecord, TableName, record_batches};
use decore::engine::{Engine, Rows, SweepSettings};
use std::path::Path;
use tempfile::TempDir;

use crate::synthetic::dataset;

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

//! A row of a finished dataset, run again: the study that the dataset keeps, and the stored row beside the one just computed.

use std::path::Path;

use schemars::JsonSchema;
use serde::Serialize;

use super::exit::Failure;
use super::text::eprint_line;
use decore_dataset::{Columns, DatasetReader, RowRecord, Source, TableName, differences};
use decore_model::run::RowOutcome;
use decore_quantity::{Cell, Value};
use decore_study::Study;
use decore_study::engine::{Engine, RowRunner};

/// Differences that are named one by one.
const LISTED: usize = 6;

/// A dataset whose rows are run again.
pub(super) struct Stored {
    reader: DatasetReader,
}

/// Comparison of a row that was run again with the stored row.
#[derive(Debug, Default, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "StoredRow")]
pub(super) struct Comparison {
    /// Whether the dataset has the row.
    pub is_there: bool,
    /// Values compared, those of blows included.
    pub values: usize,
    /// Blows of the stored row.
    pub blows: usize,
    /// Differences: column, stored value, new value.
    pub differences: Vec<[String; 3]>,
}

impl Stored {
    /// Reads the manifest of the dataset in `folder`.
    ///
    /// # Errors
    /// The reader's.
    pub fn open(folder: &Path) -> Result<Self, Failure> {
        Ok(Self { reader: DatasetReader::open(folder)? })
    }

    /// The study as the dataset was made, with the hammers that the dataset keeps; the names of other files start in `files`.
    ///
    /// # Errors
    /// Those of [`Study::parse`]: files that the study names and that are not there.
    pub fn study(&self, files: &Path) -> Result<Study, Failure> {
        let made = &self.reader.manifest().study;
        let name = format!("the study of {}", self.reader.folder().display());
        let study = Study::parse_with_hammers(&made.study_text, files, &name, made.hammer_files.clone())
            .and_then(|study| study.with_overrides(&made.overrides));
        study.map_err(|error| {
            let advice = format!(
                "file names of a dataset's study start in {}; `--files-in` names another folder",
                files.display()
            );
            Failure::Argument(format!("{error}\n  {advice}"))
        })
    }

    /// Whether the study has a table `[goal]`, in its text or set over it.
    pub fn asks(&self) -> bool {
        let made = &self.reader.manifest().study;
        let typed = made.study_text.parse::<toml::Table>().is_ok_and(|text| text.contains_key("goal"));
        typed || made.overrides.iter().any(|one| one.starts_with("goal."))
    }

    /// An engine with the settings that the dataset was made with; what is not as it was then is told.
    pub fn settle(&self, engine: Engine) -> Engine {
        let made = &self.reader.manifest().study;
        let engine = engine.with_retries(made.retries());
        for difference in differences(made, &engine.info()) {
            eprint_line(&format_args!("note: not as when the dataset was made: {difference}"));
        }
        engine
    }

    /// Compares `outcome` with the stored row.
    ///
    /// # Errors
    /// The reader's.
    pub fn compare(&self, engine: &Engine, row: usize, outcome: &RowOutcome) -> Result<Comparison, Failure> {
        let made = &self.reader.manifest().study;
        let columns = Columns::new(made)?;
        let (row, factors) = (row as u64, engine.checked().row_values(row));
        let record = RowRecord { row, factors, outcome: outcome.clone() };
        let mut source = Source::new(made, &record);
        let mut found = Comparison::default();
        self.visit(TableName::Runs, row, |cells| {
            found.is_there = true;
            for (column, stored) in columns.runs.iter().zip(cells) {
                found.take(&column.description.name, *stored, column.cell(&source));
            }
        })?;
        let blows = outcome.metrics.as_ref().map_or(&[][..], |metrics| &metrics.blows);
        self.visit(TableName::Blows, row, |cells| {
            source.blow = blows.get(found.blows);
            found.blows += 1;
            if source.blow.is_none() {
                return;
            }
            for (column, stored) in columns.blows.iter().zip(cells) {
                found.take(
                    &format!("blow {}: {}", found.blows, column.description.name),
                    *stored,
                    column.cell(&source),
                );
            }
        })?;
        if found.is_there && found.blows != blows.len() {
            found.differences.push(["blows".to_owned(), found.blows.to_string(), blows.len().to_string()]);
        }
        Ok(found)
    }

    /// Calls `take` with the cells of a row in a table, once for each blow.
    fn visit(&self, table: TableName, row: u64, mut take: impl FnMut(&[Cell<'_>])) -> Result<(), Failure> {
        let names: Vec<&str> = self.reader.columns(table).iter().map(|column| column.name.as_str()).collect();
        let place = names.iter().position(|name| *name == RowRecord::row.name);
        Ok(self.reader.visit_block_of(row, (table, &names), |cells| {
            if place.and_then(|place| cells.get(place)) == Some(&Some(Value::Count(row))) {
                take(cells);
            }
        })?)
    }
}

impl Comparison {
    fn take(&mut self, name: &str, stored: Cell<'_>, now: Cell<'_>) {
        self.values += 1;
        let is_same = match (stored, now) {
            (Some(Value::Real(a)), Some(Value::Real(b))) => a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan()),
            (a, b) => a == b,
        };
        if !is_same {
            let text = |cell: Cell<'_>| cell.map_or_else(|| "none".to_owned(), |value| value.to_string());
            self.differences.push([name.to_owned(), text(stored), text(now)]);
        }
    }

    /// The comparison as text.
    pub fn text(&self) -> String {
        if !self.is_there {
            return "the dataset does not have this row yet: nothing to compare with".to_owned();
        }
        let Self { values, blows, differences, .. } = self;
        if differences.is_empty() {
            return format!("the same as the stored row: {values} values, those of {blows} blows among them");
        }
        let mut text = format!("NOT the stored row: {} of {values} values differ", differences.len());
        for [name, stored, now] in differences.iter().take(LISTED) {
            text += &format!("\n  {name}: {stored} stored, {now} now");
        }
        match differences.len() {
            0..=LISTED => text,
            more => text + &format!("\n  and {} more", more - LISTED),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_differs_is_named() {
        let mut found = Comparison { is_there: true, blows: 2, ..Comparison::default() };
        found.take("row", Some(Value::Count(3)), Some(Value::Count(3)));
        found.take("reason", None, None);
        found.take("energy_j", Some(Value::Real(f64::NAN)), Some(Value::Real(f64::NAN)));
        assert_eq!(found.text(), "the same as the stored row: 3 values, those of 2 blows among them");
        found.take("work_j", Some(Value::Real(1.0)), Some(Value::Real(1.0 + f64::EPSILON)));
        found.take("peak_point", Some(Value::Text("a")), None);
        assert!(
            found
                .text()
                .starts_with("NOT the stored row: 2 of 5 values differ\n  work_j: 1 stored, 1.0000000000000002 now")
        );
        assert!(found.text().ends_with("peak_point: a stored, none now"), "{}", found.text());
        assert!(Comparison::default().text().contains("does not have this row"));
    }
}

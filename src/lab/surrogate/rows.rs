//! Rows of a dataset in the space of the study's factors.

use std::collections::HashMap;

use super::error::SurrogateError;
use super::space::{FactorSpace, places};
use crate::sensitivity::Table;
use decore_dataset::DatasetReader;
use decore_math::random::hash;
use decore_statistics::regression::Points;
use decore_study::DesignOutline;

/// Places of rows that a model takes at most: time grows with their third power.
const MOST_ROWS: usize = 2000;
/// Stream of the numbers that choose among more rows.
const CHOICE: u64 = 0x7375_7272;

/// Rows that a model can be made from.
pub(super) struct FactorRows {
    /// The rows.
    pub table: Table,
    /// The factors, in the study's order.
    pub factors: Vec<FactorSpace>,
    /// The rows' places.
    pub points: Points,
    /// Number of rows of the dataset; the table may have fewer.
    pub rows_there: usize,
    /// Notes for the reader, a sentence each.
    pub notes: Vec<String>,
}

impl FactorRows {
    /// Reads the factors and these outputs of a dataset, and of others with the same factors. Rows of the others are numbered on.
    ///
    /// # Errors
    /// Those of reading, [`SurrogateError::NoFactors`].
    pub fn read(reader: &DatasetReader, others: &[&DatasetReader], outputs: &[String]) -> Result<Self, SurrogateError> {
        let info = &reader.manifest().study;
        let outline = DesignOutline::read(&info.study_text, &info.overrides, &info.study_name)?;
        let mut table = Table::read(reader, &outline, outputs)?;
        let mut offset = info.rows;
        for other in others {
            table.append(Table::read(other, &outline, outputs)?, offset);
            offset += other.manifest().study.rows;
        }
        if table.factors.is_empty() {
            return Err(SurrogateError::NoFactors);
        }
        let rows_there = table.rows.len();
        let mut notes = Vec::new();
        if rows_there > MOST_ROWS {
            let chosen = chosen(&table);
            table.retain(|row| chosen.binary_search(&row).is_ok());
            notes.push(format!(
                "Of {rows_there} rows, {} are used, at {MOST_ROWS} places at most, chosen by chance: the time grows with their third \
                 power.",
                table.rows.len()
            ));
        }
        let factors: Vec<FactorSpace> = (table.factors.iter())
            .filter_map(|column| {
                let outline = outline.factors.iter().find(|factor| factor.name == column.name)?;
                let unit =
                    info.factors.iter().find(|factor| factor.name == column.name).map_or("", |factor| &factor.unit);
                Some(FactorSpace::new(outline, column, unit))
            })
            .collect();
        let rows: Vec<Vec<f64>> =
            (0..table.rows.len()).map(|row| table.factors.iter().map(|factor| factor.values[row]).collect()).collect();
        let named = |source| SurrogateError::Regression { output: "the factors".to_owned(), source };
        let points = places(&factors, &rows).map_err(named)?;
        Ok(Self { table, factors, points, rows_there, notes })
    }
}

/// Indices of rows at up to [`MOST_ROWS`] places chosen by chance, ascending.
fn chosen(table: &Table) -> Vec<u64> {
    let mut places: HashMap<Vec<u64>, Vec<u64>> = HashMap::new();
    for (place, row) in table.rows.iter().enumerate() {
        let at = table.factors.iter().map(|factor| (factor.values[place] + 0.0).to_bits()).collect();
        places.entry(at).or_default().push(*row);
    }
    let mut places: Vec<Vec<u64>> = places.into_values().collect();
    places.sort_by_key(|rows| (hash(CHOICE, 0, rows[0]), rows[0]));
    places.truncate(MOST_ROWS);
    let mut rows = places.concat();
    rows.sort_unstable();
    rows
}

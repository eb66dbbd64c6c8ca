//! The dose of core points over time, from what the table of runs keeps.

use std::collections::BTreeMap;

use super::error::CoresError;
use decore_dataset::{ColumnDescription, ColumnGroup, DatasetReader, RowRecord, TableName};
use decore_model::metrics::{CoreMetrics, HammerMetrics};
use decore_model::run::{RowOutcome, RowStatus};
use decore_quantity::{Cell, Value};
use decore_study::DesignOutline;

/// Settings of the study that define the dose.
const DEFINITION: [&str; 4] =
    ["core_dose_reference_m_s", "core_dose_exponent", "core_dose_threshold_m_s", "core_quality_factor"];

/// Dose of a core point over time: a straight line from the first impact on, through the dose at the end of the run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Course {
    /// Dose at the end of the run.
    pub dose: f64,
    /// End of the run, s.
    pub end_s: f64,
    /// First impact, s.
    pub start_s: f64,
    /// Growth of the dose, 1/s; at least 0.
    pub rate_per_s: f64,
}

/// The courses of all core points in all rows that are done.
pub(super) struct Courses {
    /// Core points: CASTING.NAME.
    pub cores: Vec<String>,
    /// For each row the course of each core point; `None` where it has no dose.
    pub rows: BTreeMap<u64, Vec<Option<Course>>>,
}

impl Course {
    /// Dose at a time; `None` before the first impact, and where the straight line has no dose left.
    pub fn dose_at(&self, time_s: f64) -> Option<f64> {
        let dose = self.dose + self.rate_per_s * (time_s - self.end_s);
        Some(dose).filter(|dose| *dose > 0.0 && time_s >= self.start_s)
    }

    /// Time at which a dose is reached; `None` if it never is.
    pub fn time_s(&self, dose: f64) -> Option<f64> {
        let time_s = self.end_s + (dose - self.dose) / self.rate_per_s;
        time_s.is_finite().then(|| time_s.max(self.start_s))
    }

    /// Without a rate the row has no first impact within the run: its dose does not grow.
    fn new(dose: f64, [end_s, start_s]: [f64; 2], rate_per_s: Option<f64>) -> Option<Self> {
        let rate_per_s = rate_per_s.unwrap_or(0.0);
        (dose.is_finite() && rate_per_s >= 0.0).then_some(Self { dose, end_s, start_s, rate_per_s })
    }
}

impl Courses {
    /// Reads the courses of a dataset.
    ///
    /// # Errors
    /// [`CoresError::NoDoses`], [`CoresError::Definition`]; errors of the dataset.
    pub fn read(reader: &DatasetReader, outline: &DesignOutline) -> Result<Self, CoresError> {
        for key in DEFINITION {
            if let Some(factor) = outline.mover(&["outputs", key]) {
                return Err(CoresError::Definition { factor: factor.name.clone(), key });
            }
        }
        let columns = reader.columns(TableName::Runs);
        let of = |group: ColumnGroup, quantity: &str| {
            let is_it = |column: &&ColumnDescription| column.group == group && column.quantity == quantity;
            columns.iter().filter(is_it).collect::<Vec<_>>()
        };
        let doses = of(ColumnGroup::Core, CoreMetrics::dose_98hz_10khz.name);
        let rates = of(ColumnGroup::Core, CoreMetrics::dose_rate_98hz_10khz_per_s.name);
        let starts = of(ColumnGroup::Hammer, HammerMetrics::first_impact_time_s.name);
        if doses.is_empty() || doses.len() != rates.len() {
            return Err(CoresError::NoDoses);
        }
        let keys = [RowRecord::row.name, RowOutcome::status.name, RowOutcome::time_reached_s.name];
        let further = doses.iter().chain(&rates).chain(&starts).map(|column| column.name.as_str());
        let names: Vec<&str> = keys.into_iter().chain(further).collect();
        let cores = doses.iter().filter_map(|column| column.subject.clone()).collect();
        let mut found = Self { cores, rows: BTreeMap::new() };
        reader.visit(TableName::Runs, &names, |cells| {
            let [Some(Value::Count(row)), Some(Value::Text(status)), Some(Value::Real(end_s)), figures @ ..] = cells
            else {
                return;
            };
            if *status == RowStatus::Done.name() {
                found.rows.insert(*row, courses(figures, doses.len(), *end_s));
            }
        })?;
        if found.rows.values().flatten().all(Option::is_none) {
            return Err(CoresError::NoDoses);
        }
        Ok(found)
    }
}

/// Courses of a row from its doses, their rates, and the first impacts of the hammers.
fn courses(figures: &[Cell<'_>], cores: usize, end_s: f64) -> Vec<Option<Course>> {
    let number = |place: usize| figures.get(place)?.and_then(|cell| cell.number()).filter(|number| number.is_finite());
    let impacts = (2 * cores..figures.len()).filter_map(number);
    let start_s = impacts.reduce(f64::min).unwrap_or(0.0);
    let course = |core: usize| Course::new(number(core)?, [end_s, start_s], number(cores + core));
    (0..cores).map(course).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn doses_grow_along_a_line() {
        let course = Course::new(200.0, [1.0, 0.1], Some(200.0)).unwrap();
        assert_eq!((course.rate_per_s, course.dose_at(3.0), course.time_s(1000.0)), (200.0, Some(600.0), Some(5.0)));
        assert_eq!((course.dose_at(0.05), course.time_s(1.0)), (None, Some(0.1)));
        let still = Course::new(0.0, [1.0, 0.1], None).unwrap();
        assert_eq!((still.dose_at(9.0), still.time_s(1.0)), (None, None));
    }
}

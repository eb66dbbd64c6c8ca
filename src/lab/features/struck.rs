//! Sums over the blows on one casting, in the order of their start.

use std::collections::HashMap;

use super::error::FeaturesError;
use decore_dataset::{DatasetReader, RowRecord, TableName};
use decore_model::metrics::{Blow, BlowKind};
use decore_quantity::Value;

/// Mean, largest and spread of a figure of the blows, without keeping them (Welford, Technometrics 4, 1962).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct RunningMoments {
    count: u64,
    mean: f64,
    squares: f64,
    largest: f64,
}

impl RunningMoments {
    fn add(&mut self, value: f64) {
        self.count += 1;
        let before = value - self.mean;
        self.mean += before / self.count as f64;
        self.squares += before * (value - self.mean);
        self.largest = if self.count == 1 { value } else { self.largest.max(value) };
    }

    pub fn mean(&self) -> Option<f64> {
        (self.count > 0).then_some(self.mean)
    }

    pub fn largest(&self) -> Option<f64> {
        (self.count > 0).then_some(self.largest)
    }

    /// Standard deviation of the sample.
    pub fn spread(&self) -> Option<f64> {
        (self.count > 1).then(|| (self.squares / (self.count - 1) as f64).sqrt())
    }
}

/// Sums over the blows on one casting in one run.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Struck {
    /// Blows that reached the casting.
    pub blows: u64,
    /// Blows that did not.
    pub blank: u64,
    /// Energy of such blows, J.
    pub energy: RunningMoments,
    /// Largest forces, N.
    pub force: RunningMoments,
    /// Work within the windows of all blows, J.
    pub work_j: f64,
    /// Energy of the blows at or over the threshold, J.
    pub dose_j: f64,
    /// Number of such blows.
    pub dose_blows: u64,
    /// Start of the blow in which the work reaches the given value, s.
    pub reached_s: Option<f64>,
}

/// Thresholds for the counts and times.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Thresholds {
    /// Energy from which a blow counts as a dose, J.
    pub dose_j: f64,
    /// Cumulative work whose time is wanted, J.
    pub work_j: Option<f64>,
}

impl Struck {
    fn add(&mut self, blow: &BlowFigures, is_blank: bool, thresholds: Thresholds) {
        let BlowFigures { start_s, energy_j, work_j, force_n } = *blow;
        self.work_j += work_j;
        if self.reached_s.is_none() && thresholds.work_j.is_some_and(|wanted| self.work_j >= wanted) {
            self.reached_s = Some(start_s);
        }
        if is_blank {
            self.blank += 1;
            return;
        }
        self.blows += 1;
        self.energy.add(energy_j);
        self.force.add(force_n);
        if energy_j >= thresholds.dose_j {
            self.dose_j += energy_j;
            self.dose_blows += 1;
        }
    }
}

/// Figures of one blow.
struct BlowFigures {
    start_s: f64,
    energy_j: f64,
    work_j: f64,
    force_n: f64,
}

/// The blows of all runs, by row and casting.
pub(super) struct StruckRows(HashMap<u64, Vec<Struck>>);

impl StruckRows {
    /// Reads the table of blows.
    ///
    /// # Errors
    /// Those of reading.
    pub fn read(reader: &DatasetReader, thresholds: Thresholds) -> Result<Self, FeaturesError> {
        let names = [
            RowRecord::row.name,
            "casting",
            Blow::kind.name,
            Blow::start_time_s.name,
            Blow::energy_j.name,
            Blow::work_j.name,
            Blow::peak_force_n.name,
        ];
        let castings = &reader.manifest().study.castings;
        let mut rows: HashMap<u64, Vec<Struck>> = HashMap::new();
        reader.visit(TableName::Blows, &names, |cells| {
            let [Some(Value::Count(row)), Some(Value::Text(casting)), Some(Value::Text(kind)), figures @ ..] = cells
            else {
                return;
            };
            let number =
                |place: usize| figures.get(place).and_then(|cell| cell.and_then(|value| value.number())).unwrap_or(0.0);
            let blow = BlowFigures { start_s: number(0), energy_j: number(1), work_j: number(2), force_n: number(3) };
            let struck = rows.entry(*row).or_insert_with(|| vec![Struck::default(); castings.len()]);
            let place = castings.iter().position(|name| name == casting);
            if let Some(struck) = place.and_then(|place| struck.get_mut(place)) {
                struck.add(&blow, *kind == BlowKind::Blank.name(), thresholds);
            }
        })?;
        Ok(Self(rows))
    }

    /// The blows on a casting, by its place, in a row; none if the table has none.
    pub fn of(&self, row: u64, casting: usize) -> Struck {
        self.0.get(&row).and_then(|castings| castings.get(casting)).copied().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_moments_and_doses() {
        let mut struck = Struck::default();
        let thresholds = Thresholds { dose_j: 12.0, work_j: Some(9.0) };
        for (start_s, energy_j, is_blank) in
            [(0.1, 70.0, false), (0.2, 10.0, false), (0.3, 99.0, true), (0.4, 13.0, false)]
        {
            let work_j = if is_blank { 0.0 } else { 4.5 };
            struck.add(&BlowFigures { start_s, energy_j, work_j, force_n: 2.0 * energy_j }, is_blank, thresholds);
        }
        assert_eq!((struck.blows, struck.blank, struck.dose_blows, struck.dose_j), (3, 1, 2, 83.0));
        assert_eq!((struck.work_j, struck.reached_s), (13.5, Some(0.2)));
        assert_eq!((struck.energy.mean(), struck.energy.largest()), (Some(31.0), Some(70.0)));
        // Deviations 39, -21, -18 of the mean: (1521 + 441 + 324) / 2.
        let spread = struck.energy.spread().expect("three blows");
        assert!((spread - 1143.0_f64.sqrt()).abs() < 1e-12, "{spread}");
        assert_eq!(struck.force.largest(), Some(140.0));
        assert_eq!(RunningMoments::default().mean(), None);
        assert_eq!(Struck { blows: 1, ..Struck::default() }.energy.spread(), None);
    }
}

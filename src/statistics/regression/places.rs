//! Rows at one place, which count as one in a model.

use super::error::RegressionError;
use super::groups::Groups;
use super::points::Points;

/// Variance of runs at one place, as a share of the variance of the places' values, below which rounding is all that they differ by.
const ROUNDING: f64 = 1e-24;

/// A table with one row per place, for the fit of a model.
///
/// The value of a place is the mean of its runs. Rows with the same coordinates and the same value are one run: a deterministic
/// computation that is repeated shows nothing new. Runs at one place that differ show the noise of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Places {
    first: Vec<usize>,
    points: Points,
    values: Vec<f64>,
    runs: Vec<f64>,
    spread: Spread,
}

/// Differences of runs at one place: evidence of the noise of each run.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Spread {
    /// Sum of squared deviations from the means of their places.
    pub squares: f64,
    /// Degrees of freedom of that sum: runs beyond the first of each place.
    pub freedom: f64,
}

impl Places {
    /// Brings the rows of each place together, the places in the order of their first rows.
    ///
    /// # Errors
    /// [`RegressionError::Size`] for another number of values than of rows; [`RegressionError::NotFinite`].
    pub fn new(points: &Points, values: &[f64]) -> Result<Self, RegressionError> {
        if values.len() != points.rows() {
            let (found, expected) = (values.len(), points.rows());
            return Err(RegressionError::Size { what: "values", found, expected });
        }
        if let Some((row, &value)) = values.iter().enumerate().find(|(_, value)| !value.is_finite()) {
            return Err(RegressionError::NotFinite { row, value });
        }
        let factors: Vec<usize> = (0..points.factors()).collect();
        let together = Groups::equal(points, &factors);
        let first: Vec<usize> = together.members().iter().map(|rows| rows[0]).collect();
        let (mut means, mut runs, mut spread) = (Vec::new(), Vec::new(), Spread::default());
        for rows in together.members() {
            let own = different(points, values, rows);
            let count = own.len() as f64;
            let mean = own.iter().sum::<f64>() / count;
            spread.squares += own.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>();
            spread.freedom += count - 1.0;
            means.push(if own.len() == 1 { own[0] } else { mean });
            runs.push(count);
        }
        let spread = spread.above(ROUNDING, values);
        Ok(Self { points: points.select(&first), first, values: means, runs, spread })
    }

    /// Places that were brought together before: the mean of so many runs at each, and how these differed.
    ///
    /// # Errors
    /// [`RegressionError::Size`] for lists of other lengths.
    pub fn known(points: &Points, (values, runs): (&[f64], &[f64]), spread: Spread) -> Result<Self, RegressionError> {
        for (what, found) in [("values", values.len()), ("numbers of runs", runs.len())] {
            if found != points.rows() {
                return Err(RegressionError::Size { what, found, expected: points.rows() });
            }
        }
        let first = (0..values.len()).collect();
        Ok(Self { first, points: points.clone(), values: values.to_vec(), runs: runs.to_vec(), spread })
    }

    /// These places and others with the same factors, of one run each.
    ///
    /// # Errors
    /// [`RegressionError::Size`] for another number of factors, or of values.
    pub fn with(&self, others: &Points, values: &[f64]) -> Result<Self, RegressionError> {
        let all = [&self.values, values].concat();
        let runs = [&self.runs, &vec![1.0; others.rows()][..]].concat();
        Self::known(&self.points.with(others)?, (&all, &runs), self.spread)
    }

    /// With further evidence of the noise of a run, for instance of runs that are no rows of the table.
    pub fn with_spread(mut self, more: Spread) -> Self {
        let more = more.above(ROUNDING, &self.values);
        self.spread.squares += more.squares;
        self.spread.freedom += more.freedom;
        self
    }

    /// Selects places by number; the evidence of the noise stays the same.
    pub(super) fn select(&self, places: &[usize]) -> Self {
        let pick = |of: &[f64]| places.iter().map(|place| of[*place]).collect();
        Self {
            first: places.iter().map(|place| self.first[*place]).collect(),
            points: self.points.select(places),
            values: pick(&self.values),
            runs: pick(&self.runs),
            spread: self.spread,
        }
    }

    /// The same with the values less their mean, over their standard deviation.
    pub(super) fn unit(&self) -> Self {
        let count = self.values.len() as f64;
        let mean = self.values.iter().sum::<f64>() / count;
        let variance = self.values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count;
        let deviation = variance.sqrt();
        Self {
            values: self.values.iter().map(|value| (value - mean) / deviation).collect(),
            spread: Spread { squares: self.spread.squares / variance, ..self.spread },
            ..self.clone()
        }
    }

    /// First row of each place.
    pub fn first(&self) -> &[usize] {
        &self.first
    }

    /// Coordinates of the places.
    pub fn points(&self) -> &Points {
        &self.points
    }

    /// Mean of the runs at each place.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Different runs at each place.
    pub fn runs(&self) -> &[f64] {
        &self.runs
    }

    /// Differences of runs at one place.
    pub fn spread(&self) -> Spread {
        self.spread
    }
}

impl Spread {
    /// None if the squares are rounding errors compared with the variance of these values.
    fn above(self, share: f64, values: &[f64]) -> Self {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let variance = values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / values.len() as f64;
        if self.squares > share * variance * self.freedom { self } else { Self::default() }
    }
}

/// The values of a place's runs: rows with the same coordinates are one run where their values are all the same.
fn different(points: &Points, values: &[f64], rows: &[usize]) -> Vec<f64> {
    let bits = |row: usize| points.row(row).iter().map(|x| (x + 0.0).to_bits()).collect::<Vec<u64>>();
    let mut sorted = rows.to_vec();
    sorted.sort_by_cached_key(|row| (bits(*row), *row));
    let mut found: Vec<(usize, f64)> = Vec::new();
    for same in sorted.chunk_by(|a, b| bits(*a) == bits(*b)) {
        let repeated = same.iter().all(|row| values[*row] == values[same[0]]);
        let runs = if repeated { &same[..1] } else { same };
        found.extend(runs.iter().map(|row| (*row, values[*row])));
    }
    found.sort_by_key(|(row, _)| *row);
    found.into_iter().map(|(_, value)| value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeats_are_one_run_and_replicates_are_several() {
        let points = Points::new(vec![0.5, 0.25, 0.5, 0.5, 0.25, 0.75], vec![false]).expect("points");
        let places = Places::new(&points, &[1.0, 2.0, 1.0, 1.0, 4.0, 5.0]).expect("places");
        assert_eq!((places.first(), places.values()), (&[0, 1, 5][..], &[1.0, 3.0, 5.0][..]));
        assert_eq!((places.runs(), places.spread()), (&[1.0, 2.0, 1.0][..], Spread { squares: 2.0, freedom: 1.0 }));
    }

    #[test]
    fn a_repeat_beside_a_replicate_changes_nothing() {
        let near = 0.5 + 1e-12;
        let of = |x: &[f64], values: &[f64]| {
            let places = Places::new(&Points::new(x.to_vec(), vec![false]).expect("points"), values).expect("places");
            (places.values().to_vec(), places.runs().to_vec(), places.spread())
        };
        assert_eq!(of(&[0.5, near, 0.9], &[1.0, 2.0, 0.0]), of(&[0.5, near, 0.9, 0.5], &[1.0, 2.0, 0.0, 1.0]));
    }
}

//! Chooses the places that show most about the boundary of failures.

use super::acquisition::{Learned, LimitSide, Limited, Side, learning};
use decore_statistics::regression::{Points, RegressionError, Success};

/// Places among which rows at a boundary are chosen, at most.
const NEAREST: usize = 512;

/// Rows that were run.
#[derive(Debug, Clone, Copy)]
pub struct Tried<'a> {
    /// Places of the rows.
    pub points: &'a Points,
    /// Whether each of them succeeded.
    pub succeeded: &'a [bool],
}

/// Limit that separates rows that succeed from rows that fail: the value of the process of 1 and -1 at which both are equally likely.
/// `None` if the probability is the same everywhere.
fn even(success: &Success) -> Option<Limited<'_>> {
    match success {
        Success::Everywhere(_) => None,
        Success::ByPlace { process, scaling: [slope, offset] } => {
            Some(Limited { process, side: Side::Most, value: -offset / slope })
        }
    }
}

/// On which side of the boundary each place lies: `within` is the probability that a run there succeeds.
///
/// With `m` and `s` the expected value and standard deviation of the process of 1 and -1, noise left out, and `b` the value at which
/// success and failure are as likely, it is `Phi((m - b) / s)`: a place is on the wrong side with the probability `Phi(-U)`,
/// `U = |m - b| / s` (Echard, Gayton and Lemaire, Struct. Saf. 33, 2011). While fewer than four rows are of one kind, it is the share of
/// the rows that succeed, everywhere.
///
/// # Errors
/// [`RegressionError::Size`] for places with other factors.
pub fn sides(success: &Success, places: &Points) -> Result<Vec<LimitSide>, RegressionError> {
    match even(success) {
        Some(limit) => limit.beside(places),
        None => Ok(success
            .predict(places)?
            .into_iter()
            .map(|within| LimitSide { within, unknown: within.min(1.0 - within) })
            .collect()),
    }
}

/// Chooses the candidates, in order, that show most about the boundary, by [`bounding`], or by `filling` while fewer than four rows are of
/// one kind.
///
/// # Errors
/// [`RegressionError::Size`] for candidates with other factors.
pub fn separating(
    success: &Success,
    tried: &Tried<'_>,
    candidates: &Points,
    batch: usize,
) -> Result<Vec<usize>, RegressionError> {
    match even(success) {
        Some(limit) => bounding(&limit, &vec![1.0; candidates.rows()], candidates, batch),
        None => Ok(filling(tried, candidates, batch)),
    }
}

/// Chooses the candidates, in order, that show most about the boundary of a limit: of the `NEAREST` most uncertain places near it, those
/// that [`learning`] chooses. `success`: probability of each that a run there has the output.
///
/// # Errors
/// Those of [`learning`].
pub fn bounding(
    limit: &Limited<'_>,
    success: &[f64],
    candidates: &Points,
    batch: usize,
) -> Result<Vec<usize>, RegressionError> {
    let beside = limit.beside(candidates)?;
    let mut order: Vec<usize> = (0..beside.len()).collect();
    order.sort_by(|a, b| beside[*b].unknown.total_cmp(&beside[*a].unknown));
    order.truncate(NEAREST);
    let success = order.iter().map(|place| success[*place]).collect();
    let learned = Learned { process: limit.process, success, boundary: Some(limit.value) };
    let chosen = learning(&[learned], &candidates.select(&order), batch)?;
    Ok(chosen.into_iter().map(|place| order[place]).collect())
}

/// The candidates, in order, that lie farthest from all rows and those before them (maximin distance: Johnson, Moore and Ylvisaker,
/// J. Stat. Plan. Inference 26, 1990); every second one among those whose nearest row is of the rarer kind, so that a few rows of a
/// kind become more.
fn filling(tried: &Tried<'_>, candidates: &Points, batch: usize) -> Vec<usize> {
    let count = tried.succeeded.iter().filter(|success| **success).count();
    let rarer = 2 * count < tried.succeeded.len();
    let nearest = |place: usize| {
        let far = |row: usize| candidates.squared_distance([candidates.row(place), tried.points.row(row)]);
        let rows = (0..tried.points.rows()).map(|row| (far(row), tried.succeeded[row] == rarer));
        rows.fold((f64::INFINITY, false), |nearest, row| if row.0 < nearest.0 { row } else { nearest })
    };
    let (mut far, rare): (Vec<f64>, Vec<bool>) = (0..candidates.rows()).map(nearest).unzip();
    let mut chosen: Vec<usize> = Vec::new();
    while chosen.len() < batch.min(candidates.rows()) {
        let farthest = |only_rare: bool| {
            let free = (0..far.len()).filter(|place| !chosen.contains(place) && (rare[*place] || !only_rare));
            free.reduce(|best, place| if far[place] > far[best] { place } else { best })
        };
        let Some(next) = farthest(chosen.len().is_multiple_of(2)).or_else(|| farthest(false)) else { break };
        chosen.push(next);
        for (place, far) in far.iter_mut().enumerate() {
            *far = far.min(candidates.squared_distance([candidates.row(place), candidates.row(next)]));
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;
    use decore_statistics::design::{Design, Distribution, Factor, HypercubeKind, Kind, LatinHypercube, Level, Sobol};

    /// Rows fail within this disc: 19.6 % of the square.
    fn succeeds(x: &[f64]) -> bool {
        (x[0] - 0.6).powi(2) + (x[1] - 0.45).powi(2) > 0.0625
    }

    fn points(kind: Kind, seed: u64) -> Points {
        let factor = Factor { distribution: Distribution::Uniform { low: 0.0, high: 1.0 }, levels: None };
        let design = Design::new(kind, vec![factor; 2], seed).expect("a design");
        let value = |level: Level| if let Level::Real(value) = level { value } else { f64::NAN };
        let rows = (0..design.row_count()).flat_map(|row| design.row(row).unwrap_or_default());
        Points::new(rows.map(value).collect(), vec![false; 2]).expect("points")
    }

    fn hypercube(rows: usize, seed: u64) -> Points {
        points(Kind::LatinHypercube(LatinHypercube { rows, kind: HypercubeKind::Maximin, ..Default::default() }), seed)
    }

    fn sobol(rows: usize, seed: u64) -> Points {
        points(Kind::Sobol(Sobol { rows, scramble: true }), seed)
    }

    fn known(points: &Points) -> Vec<bool> {
        (0..points.rows()).map(|row| succeeds(points.row(row))).collect()
    }

    /// Share of the square that a model of these rows takes for the wrong side.
    fn wrong(rows: &Points, places: &Points) -> f64 {
        let success = Success::fit(rows, &known(rows)).expect("a model");
        let likely = success.predict(places).expect("probabilities");
        let wrong = likely.iter().zip(known(places)).filter(|(likely, succeeds)| (**likely > 0.5) != *succeeds);
        wrong.count() as f64 / places.rows() as f64
    }

    #[test]
    fn a_disc_is_found_with_fewer_errors_than_by_a_hypercube_of_as_many_rows() {
        let places = sobol(2048, 99);
        let (mut spread, mut sought) = (Vec::new(), Vec::new());
        for seed in 0..3 {
            let mut rows = hypercube(12, seed);
            while rows.rows() < 60 {
                let succeeded = known(&rows);
                let success = Success::fit(&rows, &succeeded).expect("a model");
                let candidates = sobol(2048, 1000 * seed + rows.rows() as u64);
                let tried = Tried { points: &rows, succeeded: &succeeded };
                let chosen = separating(&success, &tried, &candidates, 4).expect("rows");
                assert!(chosen.len() == 4 && (0..4).all(|place| !chosen[..place].contains(&chosen[place])));
                rows = rows.with(&candidates.select(&chosen)).expect("rows");
            }
            sought.push(wrong(&rows, &places));
            spread.push(wrong(&hypercube(60, seed), &places));
        }
        let mean = |shares: &[f64]| shares.iter().sum::<f64>() / shares.len() as f64;
        eprintln!("misclassified: hypercube {spread:.4?}, sought {sought:.4?}");
        assert!(mean(&sought) < 0.75 * mean(&spread), "{sought:.4?} {spread:.4?}");
    }

    #[test]
    fn few_failures_become_more_and_gaps_are_filled() {
        let rows = Points::new(vec![0.1, 0.1, 0.9, 0.1, 0.1, 0.9, 0.8, 0.8], vec![false; 2]).expect("points");
        let tried = Tried { points: &rows, succeeded: &[true, true, true, false] };
        let candidates = Points::new(vec![0.5, 0.1, 0.7, 0.9, 0.1, 0.5, 0.11, 0.11], vec![false; 2]).expect("points");
        let chosen = separating(&Success::Everywhere(4.0 / 6.0), &tried, &candidates, 3).expect("places");
        // First the only one nearest to the row that failed, then the farthest from all.
        assert_eq!(chosen, [1, 0, 2]);
        let places = sides(&Success::Everywhere(0.9), &candidates).expect("sides");
        assert!(places.iter().all(|at| at.within == 0.9));
    }
}

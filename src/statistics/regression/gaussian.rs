//! Gaussian processes.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::error::RegressionError;
use super::groups::{Groups, LeftOut};
use super::kernel::Kernel;
use super::likelihood::{Hyperparameters, Inverse, LEAST_NOISE, Likelihood, Pairs, Prior, Solved, solve};
use super::minimise::{Minimum, Stop, dot, minimise};
use super::ordered::ordered_solve;
use super::places::Places;
use super::points::Points;
use super::residuals::Residuals;
use decore_math::linalg::{LinalgError, multiply_transposed};
use decore_math::random::hash;

/// Rows at different places that a model takes at least.
pub const LEAST_ROWS: usize = 8;
/// Places on which starts are compared.
const COMPARED_PLACES: usize = 160;
/// Most places on which lengths and noise are searched. With more places, a part of them is enough.
const SEARCHED_PLACES: usize = 640;
/// Starts: the length as a multiple of the usual one, and the noise.
const STARTS: [[f64; 2]; 4] = [[0.4, 1e-6], [0.1, 1e-2], [0.07, 1e-6], [0.8, 1e-6]];
/// When a comparison of starts ends.
const COMPARISON: Stop = Stop { steps: 60, gain: 1e-2 };
/// When the search over all searched places ends.
const SEARCH: Stop = Stop { steps: 60, gain: 1e-3 };
/// Stream of the numbers that choose the places for comparisons and folds.
const CHOICE: u64 = 0x6b72_6967;
/// Folds that are left out, lengths and noise being searched anew without them; of fewer than twice as many groups each is one.
pub const FOLDS: usize = 10;
/// Places up to which lengths and noise may be wrong enough for folds to matter.
const FOLDED_PLACES: usize = 320;
/// Places below which all is searched anew without a fold, the kernel too: lengths of few places hang on each of them.
const FEW_PLACES: usize = 20;
/// When the search without a fold ends.
const WITHOUT_FOLD: Stop = Stop { steps: 20, gain: 1e-2 };

/// A Gaussian process with a constant mean and noise, fitted to a table.
///
/// `y(x) = mean + z(x) + e`, `z` with the variance `variance` and the correlations of a [`Kernel`], `e` independent noise of
/// `noise * variance` at each place (Rasmussen and Williams, *Gaussian Processes for Machine Learning*, 2006). Rows at one place are
/// one value, see [`Places`]; where their runs differ, each run has noise of `spread * variance` besides (stochastic kriging:
/// Ankenman, Nelson and Staum, Oper. Res. 58, 2010). Lengths and noise have the largest posterior density: the restricted
/// likelihood, and priors for the logarithms of the lengths (normal, mean `0.7 + ln(d)/2`, standard deviation 1, of `d` factors) and of
/// the noise (mean 8.8 above that of the least noise, standard deviation 2.5). Of more than 640 places, that many tell them.
#[derive(Debug, Clone)]
pub struct GaussianProcess {
    places: Places,
    kernel: Kernel,
    hyperparameters: Hyperparameters,
    solved: Solved,
    /// `L^-1 1` of the Cholesky factor `L` of the places' correlations.
    ones: Vec<f64>,
    groups: Groups,
    residuals: Residuals,
    /// Noise that no search goes below.
    prior: Prior,
}

/// Information of rows about places: a row for each place and a column for each row of the table.
struct Explained {
    /// Correlations `r`.
    near: DMatrix<f64>,
    /// `L^-1 r`.
    explained: DMatrix<f64>,
}

/// Prediction of a model at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prediction {
    /// Expected value.
    pub mean: f64,
    /// Standard deviation of a new row there, noise included.
    pub std_dev: f64,
}

/// A kernel with its lengths and noise, quantities that follow for the places, and errors of left-out places.
struct Fit {
    kernel: Kernel,
    of: Hyperparameters,
    solved: Solved,
    inverse: Inverse,
    groups: Groups,
    residuals: Residuals,
}

impl Fit {
    fn new(places: &Places, kernel: Kernel, of: Hyperparameters) -> Result<Self, RegressionError> {
        let (solved, inverse) = solve(places, (kernel, &of))?;
        let groups = Groups::new(places.points(), &of.weights);
        let residuals = left_out((places.values(), &groups), (&solved, &inverse))?;
        Ok(Self { kernel, of, solved, inverse, groups, residuals })
    }
}

impl GaussianProcess {
    /// Fits each kernel, and keeps the one under which rows that were left out are the more probable.
    ///
    /// # Errors
    /// [`RegressionError::TooFew`] for rows at fewer than [`LEAST_ROWS`] places; [`RegressionError::Constant`],
    /// [`RegressionError::NotFinite`], [`RegressionError::Size`].
    pub fn fit(points: &Points, values: &[f64]) -> Result<Self, RegressionError> {
        Self::fit_above(&Places::new(points, values)?, LEAST_NOISE)
    }

    /// As [`Self::fit`] of places, with another least noise than [`LEAST_NOISE`], a share of the variance: a lower one follows smooth
    /// outputs to more digits, of few rows; of many, rounding decides.
    ///
    /// # Errors
    /// As [`Self::fit`].
    pub fn fit_above(places: &Places, least_noise: f64) -> Result<Self, RegressionError> {
        check(places.points(), places.values())?;
        Self::fit_kernels(places, Prior::of_outputs(least_noise))
    }

    /// As [`Self::fit`] of places with -1 and 1 for values.
    ///
    /// # Errors
    /// As [`Self::fit`].
    pub(super) fn fit_signs(places: &Places) -> Result<Self, RegressionError> {
        check(places.points(), places.values())?;
        Self::fit_kernels(places, Prior::OF_SIGNS)
    }

    /// The best kernel of any number of places.
    fn fit_kernels(places: &Places, prior: Prior) -> Result<Self, RegressionError> {
        let part = places.points().rows() > SEARCHED_PLACES;
        let searched =
            if part { places.select(&chosen(places.points().rows(), SEARCHED_PLACES)) } else { places.clone() };
        let fit = |kernel: &Kernel| Fit::new(&searched, *kernel, hyperparameters(&searched, (*kernel, prior)));
        let mut found: Vec<Result<Fit, RegressionError>> = Kernel::ALL.par_iter().map(fit).collect();
        // Densities compare where the same places are left out together.
        let groups: Vec<Groups> = found.iter().flatten().map(|fit| fit.groups.clone()).collect();
        if let Some(coarsest) = groups.iter().min_by_key(|groups| groups.len()) {
            for fit in found.iter_mut().flatten().filter(|fit| fit.groups != *coarsest) {
                fit.residuals = left_out((searched.values(), coarsest), (&fit.solved, &fit.inverse))?;
                fit.groups.clone_from(coarsest);
            }
        }
        let mut best: Result<Fit, RegressionError> =
            Err(RegressionError::Linalg(LinalgError::NoConvergence { order: places.values().len() }));
        for fit in found {
            match (&best, fit) {
                (Ok(best), Ok(fit)) if fit.residuals.log_density() <= best.residuals.log_density() => {}
                (Ok(_), Err(_)) => {}
                (_, fit) => best = fit,
            }
        }
        let best = best?;
        let whole = if part { Fit::new(places, best.kernel, best.of)? } else { best };
        Ok(Self { prior, ..Self::of(places, whole) })
    }

    /// Errors of places that are left out with their groups, a tenth of the groups at a time, or one at a time of fewer than 20, with
    /// lengths and noise fitted again without them: of few places, those fitted to all of them are too sure of themselves. `None` for more
    /// than 320 places.
    ///
    /// # Errors
    /// Any error of [`Self::fit`] on the remaining places. A constant rest predicts its constant.
    pub fn folds(&self) -> Result<Option<Residuals>, RegressionError> {
        let values = self.values();
        if values.len() > FOLDED_PLACES {
            return Ok(None);
        }
        let order = self.groups.shuffled(CHOICE);
        let folds = if order.len() < 2 * FOLDS { order.len() } else { FOLDS };
        let fold = |fold: usize| {
            let (out, rest): (Vec<usize>, Vec<usize>) = (0..order.len()).partition(|place| place % folds == fold);
            let [out, rest] = [out, rest]
                .map(|places| places.iter().flat_map(|place| order[*place]).copied().collect::<Vec<usize>>());
            let predicted = self.predict_without((&rest, &out))?;
            Ok(out.into_iter().zip(predicted).collect::<Vec<(usize, f64)>>())
        };
        let found: Result<Vec<_>, RegressionError> = (0..folds).into_par_iter().map(fold).collect();
        let mut errors = vec![0.0; values.len()];
        for (place, mean) in found?.into_iter().flatten() {
            errors[place] = values[place] - mean;
        }
        // Use the standard deviations of this model for intervals: a fit to few places may have hardly any.
        Ok(Some(Residuals::new((values, &self.groups), errors, self.residuals.std_devs().to_vec())))
    }

    /// Predictions at left-out places by a model fitted to the others. A constant rest predicts its constant.
    fn predict_without(&self, (rest, out): (&[usize], &[usize])) -> Result<Vec<f64>, RegressionError> {
        let known = self.places.select(rest);
        if let Some(mean) = constant(known.values()) {
            return Ok(vec![mean; out.len()]);
        }
        let predicted = self.fit_anew(&known)?.predict(&self.places.points().select(out))?;
        Ok(predicted.into_iter().map(|at| at.mean).collect())
    }

    /// A model of other places, searched for from here.
    fn fit_anew(&self, places: &Places) -> Result<Self, RegressionError> {
        if self.values().len() < FEW_PLACES {
            return Self::fit_kernels(places, self.prior);
        }
        let pairs = Pairs::new(places.points());
        let prior = self.prior;
        let unit = places.unit();
        let likelihood = Likelihood { kernel: self.kernel, pairs: &pairs, places: &unit, prior };
        let start = self.hyperparameters.logarithms(prior.least_noise);
        let found = minimise(start, WITHOUT_FOLD, &mut |at| likelihood.sloped(at));
        let factors = places.points().factors();
        let found = found.map(|found| Hyperparameters::from_logarithms(&found.at, factors, prior.least_noise));
        let of = found.unwrap_or_else(|| self.hyperparameters.clone());
        Ok(Self { prior, ..Self::of(places, Fit::new(places, self.kernel, of)?) })
    }

    /// Model for given lengths and noise.
    ///
    /// # Errors
    /// As [`Self::fit`]; [`RegressionError::Parameter`] for a weight or a noise that is negative or not finite;
    /// [`RegressionError::Linalg`] where there is no noise and places are too near to each other.
    pub fn with(places: &Places, (kernel, of): (Kernel, Hyperparameters)) -> Result<Self, RegressionError> {
        check(places.points(), places.values())?;
        if of.weights.len() != places.points().factors() {
            let (found, expected) = (of.weights.len(), places.points().factors());
            return Err(RegressionError::Size { what: "weights", found, expected });
        }
        let expected = "a finite number that is not negative";
        let noises = [("noise", of.noise), ("spread", of.spread)];
        for (name, value) in of.weights.iter().map(|weight| ("weight", *weight)).chain(noises) {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(RegressionError::Parameter { name, value, expected });
            }
        }
        Ok(Self::of(places, Fit::new(places, kernel, of)?))
    }

    fn of(places: &Places, Fit { kernel, of, solved, groups, residuals, .. }: Fit) -> Self {
        let mut ones = DMatrix::from_element(1, places.values().len(), 1.0);
        ordered_solve(&solved.factor, &mut ones);
        let ones = ones.as_slice().to_vec();
        let places = places.clone();
        Self {
            places,
            kernel,
            hyperparameters: of,
            solved,
            ones,
            groups,
            residuals,
            prior: Prior::of_outputs(LEAST_NOISE),
        }
    }

    /// The places that it was fitted to.
    pub fn places(&self) -> &Places {
        &self.places
    }

    fn values(&self) -> &[f64] {
        self.places.values()
    }

    fn points(&self) -> &Points {
        self.places.points()
    }

    /// The kernel.
    pub fn kernel(&self) -> Kernel {
        self.kernel
    }

    /// Lengths and noise.
    pub fn hyperparameters(&self) -> &Hyperparameters {
        &self.hyperparameters
    }

    /// The constant mean.
    pub fn mean(&self) -> f64 {
        self.solved.mean
    }

    /// Variance of the process.
    pub fn variance(&self) -> f64 {
        self.solved.variance
    }

    /// Standard deviation of the noise of a single run, including its place's.
    pub fn noise_std_dev(&self) -> f64 {
        ((self.hyperparameters.noise + self.hyperparameters.spread) * self.solved.variance).sqrt()
    }

    /// Logarithm of the restricted likelihood, without its constant.
    pub fn log_likelihood(&self) -> f64 {
        self.solved.log_likelihood
    }

    /// Weights of the places: `mean + sum_i weight_i k(x, x_i)` is the prediction.
    pub fn row_weights(&self) -> &[f64] {
        &self.solved.alpha
    }

    /// Places that are left out together.
    pub fn groups(&self) -> &Groups {
        &self.groups
    }

    /// Errors of places that were left out with their groups.
    pub fn residuals(&self) -> &Residuals {
        &self.residuals
    }

    /// Predicts places with the same factors.
    ///
    /// # Errors
    /// [`RegressionError::Size`] for another number of factors.
    pub fn predict(&self, places: &Points) -> Result<Vec<Prediction>, RegressionError> {
        self.check_factors(places)?;
        let chunks: Vec<usize> = (0..places.rows()).step_by(CHUNK).collect();
        let predicted: Vec<Vec<Prediction>> = (chunks.par_iter())
            .map(|first| self.predict_chunk(places, *first..(first + CHUNK).min(places.rows())))
            .collect();
        Ok(predicted.concat())
    }

    fn predict_chunk(&self, places: &Points, rows: std::ops::Range<usize>) -> Vec<Prediction> {
        let chunk: Vec<usize> = rows.collect();
        let Explained { near, explained } = self.explained(&places.select(&chunk));
        let (total, solved) = (dot(&self.ones, &self.ones), &self.solved);
        let mut sums = vec![[0.0; 3]; chunk.len()];
        for (own, (alpha, one)) in solved.alpha.iter().zip(&self.ones).enumerate() {
            let (near, explained) = (near.column(own), explained.column(own));
            for ([known, squares, ones], (near, explained)) in sums.iter_mut().zip(near.iter().zip(explained.iter())) {
                *known += near * alpha;
                *squares += explained * explained;
                *ones += explained * one;
            }
        }
        let own = self.hyperparameters.noise + self.hyperparameters.spread;
        let prediction = |[known, squares, ones]: [f64; 3]| {
            let rest = 1.0 - ones;
            let share = (1.0 - squares).max(0.0) + rest * rest / total + own;
            Prediction { mean: solved.mean + known, std_dev: (solved.variance * share).sqrt() }
        };
        sums.into_iter().map(prediction).collect()
    }

    /// Correlations of places with the rows, a row for each place.
    fn explained(&self, places: &Points) -> Explained {
        let near = DMatrix::from_fn(places.rows(), self.points().rows(), |place, own| {
            self.correlation(self.points().row(own), places.row(place))
        });
        let mut explained = near.clone();
        ordered_solve(&self.solved.factor, &mut explained);
        Explained { near, explained }
    }

    /// Covariances of the expected values at places, without noise.
    ///
    /// # Errors
    /// As [`Self::predict`].
    pub fn covariances(&self, places: &Points) -> Result<DMatrix<f64>, RegressionError> {
        self.check_factors(places)?;
        let explained = self.explained(places).explained.transpose();
        let total = dot(&self.ones, &self.ones);
        let rest: Vec<f64> = explained.column_iter().map(|column| 1.0 - dot(column.as_slice(), &self.ones)).collect();
        let products = multiply_transposed(&explained, &explained)?;
        Ok(DMatrix::from_fn(places.rows(), places.rows(), |a, b| {
            let prior = self.correlation(places.row(a), places.row(b));
            self.solved.variance * (prior - products[(a, b)] + rest[a] * rest[b] / total)
        }))
    }

    /// By how much squared errors near places are larger than the process expects: the mean of the rows' squared errors when left out,
    /// each over its variance and weighted with its correlation with the place, and of one row more as expected.
    ///
    /// # Errors
    /// As [`Self::predict`].
    pub fn local_scale(&self, places: &Points) -> Result<Vec<f64>, RegressionError> {
        self.check_factors(places)?;
        let squares = self.residuals.errors().iter().zip(self.residuals.std_devs());
        let squares: Vec<f64> = squares.map(|(error, own)| (error / own) * (error / own)).collect();
        let scale = |place: usize| {
            let near = squares.iter().enumerate().map(|(own, square)| {
                let near = self.correlation(self.points().row(own), places.row(place));
                [near * square, near]
            });
            let [sum, weight] = near.fold([1.0, 1.0], |sums, of| [sums[0] + of[0], sums[1] + of[1]]);
            sum / weight
        };
        Ok((0..places.rows()).map(scale).collect())
    }

    fn check_factors(&self, places: &Points) -> Result<(), RegressionError> {
        if places.nominal() == self.points().nominal() {
            return Ok(());
        }
        let (found, expected) = (places.factors(), self.points().factors());
        Err(RegressionError::Size { what: "factors", found, expected })
    }

    fn correlation(&self, own: &[f64], place: &[f64]) -> f64 {
        let squared = (self.hyperparameters.weights.iter().enumerate())
            .map(|(factor, weight)| weight * self.points().squared(factor, [own[factor], place[factor]]))
            .sum();
        self.kernel.at(squared)
    }
}

/// Errors of places without their groups, at the same lengths and noise.
fn left_out(
    (values, groups): (&[f64], &Groups),
    (solved, inverse): (&Solved, &Inverse),
) -> Result<Residuals, RegressionError> {
    // Without group I the predictions of its values are off by Q_II^-1 a_I, and their covariance there is variance Q_II^-1.
    let own: Vec<f64> = inverse.diagonal().iter().copied().collect();
    let found = LeftOut::new(groups, (&solved.alpha, &own), |a, b| inverse[(a, b)])?;
    let deviations = found.owns.iter().map(|own| (solved.variance / own).sqrt()).collect();
    Ok(Residuals::new((values, groups), found.errors, deviations))
}

/// Places that are predicted together.
const CHUNK: usize = 64;

/// Whether a model can be made of values at points.
///
/// # Errors
/// [`RegressionError::Size`], [`RegressionError::TooFew`], [`RegressionError::NotFinite`], [`RegressionError::Constant`].
pub fn check(points: &Points, values: &[f64]) -> Result<(), RegressionError> {
    let found = values.len();
    if found != points.rows() {
        return Err(RegressionError::Size { what: "values", found, expected: points.rows() });
    }
    if found < LEAST_ROWS {
        return Err(RegressionError::TooFew { found, least: LEAST_ROWS });
    }
    if let Some((row, &value)) = values.iter().enumerate().find(|(_, value)| !value.is_finite()) {
        return Err(RegressionError::NotFinite { row, value });
    }
    constant(values).map_or(Ok(()), |value| Err(RegressionError::Constant { value }))
}

/// The value that all are except for rounding.
fn constant(values: &[f64]) -> Option<f64> {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let rounding = 4.0 * f64::EPSILON * low.abs().max(high.abs());
    (high - low <= rounding).then_some(high)
}

/// Chooses `count` of `all` places, in an order that does not depend on their values.
fn chosen(all: usize, count: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..all).collect();
    order.sort_by_key(|place| hash(CHOICE, 0, *place as u64));
    order.truncate(count);
    order
}

/// Lengths and noise of one kernel, the noise above a least one.
fn hyperparameters(places: &Places, (kernel, prior): (Kernel, Prior)) -> Hyperparameters {
    let (unit, pairs, factors) = (places.unit(), Pairs::new(places.points()), places.points().factors());
    let minimum = search(&Likelihood { kernel, pairs: &pairs, places: &unit, prior });
    let found = minimum.map_or_else(|| prior.start(factors, STARTS[1], unit.spread()), |found| found.at);
    Hyperparameters::from_logarithms(&found, factors, prior.least_noise).rounded()
}

/// Lengths and noise of the largest posterior density: starts are compared on some of the places, the best is followed on all.
fn search(whole: &Likelihood<'_>) -> Option<Minimum> {
    let (places, kernel, prior) = (whole.places, whole.kernel, whole.prior);
    let factors = places.points().factors();
    let starts = STARTS.iter().map(|start| prior.start(factors, *start, places.spread()));
    if places.values().len() <= COMPARED_PLACES {
        let ends = starts.filter_map(|start| minimise(start, SEARCH, &mut |at| whole.sloped(at)));
        return ends.min_by(|a, b| a.value.total_cmp(&b.value));
    }
    let some = places.select(&chosen(places.values().len(), COMPARED_PLACES));
    let pairs = Pairs::new(some.points());
    let part = Likelihood { kernel, pairs: &pairs, places: &some, prior };
    let ends = starts.filter_map(|start| minimise(start, COMPARISON, &mut |at| part.sloped(at)));
    let best = ends.min_by(|a, b| a.value.total_cmp(&b.value))?;
    minimise(best.at, SEARCH, &mut |at| whole.sloped(at))
}

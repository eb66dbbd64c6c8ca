//! Errors of left-out rows.

use super::groups::Groups;
use decore_math::special::student_quantile;

/// Groups below which few of their errors lie beyond the wanted share: what a normal distribution with their mean square leaves counts too.
const FEW_GROUPS: f64 = 40.0;
/// Degrees of freedom that Student's distribution is expanded for at least.
const LEAST_FREEDOM: f64 = 3.0;

/// Error of a model in each row if the row and its group are left out.
#[derive(Debug, Clone, PartialEq)]
pub struct Residuals {
    errors: Vec<f64>,
    std_devs: Vec<f64>,
    /// Weight of each row: 1 for each group.
    counts: Vec<f64>,
    q2: f64,
    /// Mean square of the errors of the mean of the other groups, each group counting 1.
    spread: f64,
}

impl Residuals {
    /// From the errors (value minus prediction) and standard deviations that the model gives itself there.
    pub(super) fn new((values, groups): (&[f64], &Groups), errors: Vec<f64>, std_devs: Vec<f64>) -> Self {
        let (deviations, counts) = (groups.deviations(values), groups.counts());
        let total: f64 = deviations.iter().map(|deviation| deviation.powi(2)).sum();
        let left: f64 = errors.iter().map(|error| error * error).sum();
        let spread = mean_square(&deviations, &counts);
        Self { q2: 1.0 - left / total, errors, std_devs, counts, spread }
    }

    /// Value minus prediction, row by row.
    pub fn errors(&self) -> &[f64] {
        &self.errors
    }

    /// Standard deviation of each error, as the model has it.
    pub fn std_devs(&self) -> &[f64] {
        &self.std_devs
    }

    /// Share of the variance that is predicted: `1 - sum e^2 / sum (y - m)^2`, `m` the mean of the rows of other groups.
    pub fn q2(&self) -> f64 {
        self.q2
    }

    /// Logarithm of the density of the rows, each under the model without it, but for a constant (Rasmussen and Williams, 2006,
    /// equation 5.11).
    pub fn log_density(&self) -> f64 {
        let of = |(error, own): (&f64, &f64)| -0.5 * (error / own) * (error / own) - libm::log(*own);
        self.errors.iter().zip(&self.std_devs).map(of).sum()
    }

    /// Root mean square of the errors.
    pub fn rms(&self) -> f64 {
        (self.errors.iter().map(|error| error * error).sum::<f64>() / self.errors.len() as f64).sqrt()
    }

    /// Returns the reach, in standard deviations on both sides, for which an interval of probability `level` contains this share of the
    /// errors.
    ///
    /// The errors over their standard deviations are ranked, and that of rank `level (n + 1)` of `n` groups is taken, the rows of a group
    /// counting 1 together, between ranks by linear interpolation (conformal prediction with leave-one-out errors, Barber and others,
    /// Ann. Stat. 49, 2021, with the model's own standard deviations). Of few groups, no such rank is there: then the largest, times
    /// what tails like those of a normal distribution add, whose logarithm falls with the square; and of fewer than 40 not less than
    /// Student's quantile times their root mean square. At a usual place no interval reaches farther than one around the mean of all.
    pub fn reach(&self, level: f64) -> f64 {
        let sizes: Vec<f64> = self.errors.iter().zip(&self.std_devs).map(|(error, own)| (error / own).abs()).collect();
        let groups = self.counts.iter().sum::<f64>().round();
        let ranked = self.ranked(&sizes, (level, groups));
        let quantile = student_quantile(0.5 * (1.0 + level), (groups - 1.0).max(LEAST_FREEDOM));
        let least = if groups < FEW_GROUPS { quantile * mean_square(&sizes, &self.counts).sqrt() } else { 0.0 };
        let mut usual = self.std_devs.clone();
        usual.sort_by(f64::total_cmp);
        let most = quantile * self.spread.sqrt() / usual.get(usual.len() / 2).copied().unwrap_or(f64::NAN);
        ranked.max(least).min(most)
    }

    /// The size at the rank that a level asks for.
    fn ranked(&self, sizes: &[f64], (level, groups): (f64, f64)) -> f64 {
        let mut sizes: Vec<(f64, f64)> = sizes.iter().copied().zip(self.counts.iter().copied()).collect();
        sizes.sort_by(|a, b| a.0.total_cmp(&b.0));
        let place = level * (groups + 1.0) - 1.0;
        let mut below: Option<(f64, f64)> = None;
        let mut rank = -1.0;
        for (size, count) in sizes {
            rank += count;
            match below {
                Some((last, known)) if rank > place => return known + (place - last) / (rank - last) * (size - known),
                None if rank > place => return size,
                _ => below = Some((rank, size)),
            }
        }
        let beyond = (libm::log(1.0 - level) / -libm::log(groups + 1.0)).max(1.0).sqrt();
        below.map_or(f64::NAN, |(_, largest)| largest * beyond)
    }
}

/// Mean of the squares, each with its count.
fn mean_square(values: &[f64], counts: &[f64]) -> f64 {
    let sum: f64 = values.iter().zip(counts).map(|(value, count)| count * value * value).sum();
    sum / counts.iter().sum::<f64>()
}

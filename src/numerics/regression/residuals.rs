//! Errors of rows that were left out.

/// The error that a model makes in each row when that row is left out of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Residuals {
    errors: Vec<f64>,
    std_devs: Vec<f64>,
    q2: f64,
}

impl Residuals {
    /// From the errors (value minus prediction) and standard deviations that the model gives itself there.
    pub(super) fn new(values: &[f64], errors: Vec<f64>, std_devs: Vec<f64>) -> Self {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        // Without its row, the mean is off by n / (n - 1) of what it is with it.
        let without = count / (count - 1.0);
        let total: f64 = values.iter().map(|value| (without * (value - mean)).powi(2)).sum();
        let left: f64 = errors.iter().map(|error| error * error).sum();
        Self { q2: 1.0 - left / total, errors, std_devs }
    }

    /// Value minus prediction, row by row.
    pub fn errors(&self) -> &[f64] {
        &self.errors
    }

    /// Standard deviation of each error, as the model has it.
    pub fn std_devs(&self) -> &[f64] {
        &self.std_devs
    }

    /// Share of the variance that is predicted: `1 - sum e^2 / sum (y - m)^2`, `m` the mean of the other rows.
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

    /// How many standard deviations an interval of the probability `level` has to reach on both sides to hold this share of the
    /// errors.
    ///
    /// The errors over their standard deviations are ranked, and that of rank `level (n + 1)` is taken, between ranks by linear
    /// interpolation (conformal prediction with leave-one-out errors, Barber and others, Ann. Stat. 49, 2021, with the model's own
    /// standard deviations). Of few rows, no such rank is there: then the largest.
    pub fn reach(&self, level: f64) -> f64 {
        let mut sizes: Vec<f64> =
            self.errors.iter().zip(&self.std_devs).map(|(error, own)| (error / own).abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let last = sizes.len() - 1;
        let place = (level * (sizes.len() + 1) as f64 - 1.0).clamp(0.0, last as f64);
        let (below, above) = (sizes[place as usize], sizes[(place as usize + 1).min(last)]);
        below + place.fract() * (above - below)
    }
}

//! Laws of doses at failure, fitted to tests of which some ended before the failure.
//!
//! The logarithm of the dose is `mu + sigma e`, e standard normal (log-normal law) or the logarithm of a standard exponential variable
//! (Weibull law). Both densities are log-concave, so with `theta = 1 / sigma` the likelihood is concave in `theta` along every quantile,
//! and profiles have a single peak (Burridge, J. R. Stat. Soc. B 43, 1981).
//!
//! Intervals hold all values whose profile likelihood is at most a bound below the peak. The bound is the one that gives Student's
//! intervals, which are exact, for the mean and a further value of a log-normal law without censored tests (Lawless, Statistical
//! Models and Methods for Lifetime Data, 2003).

use std::f64::consts::{LN_2, PI, SQRT_2, TAU};

use schemars::JsonSchema;
use serde::Serialize;

use decore_math::special::{beta_quantile, normal_quantile};
use decore_quantity::named;

named! {
    /// Law of the dose at failure.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, JsonSchema)]
    pub enum LifetimeLaw {
        /// The logarithm of the dose is normally distributed.
        #[default]
        LogNormal = "lognormal",
        /// The weakest of many links fails.
        Weibull = "weibull",
    }
}

/// One test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tested {
    /// Dose at the failure, or at the end of a test without one; positive.
    pub dose: f64,
    /// Whether it failed.
    pub failed: bool,
}

/// Why no law can be fitted.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum LifetimeError {
    /// Fewer than two failures.
    #[error(
        "{failed} of {tests} tests ended with a failure, expected at least 2: continue the tests until more have failed"
    )]
    Few {
        /// Tests that failed.
        failed: usize,
        /// All tests.
        tests: usize,
    },
    /// All failures at one dose.
    #[error("all failures have the dose {dose}, so their scatter is unknown: add tests, or note the times more finely")]
    Equal {
        /// The dose.
        dose: f64,
    },
    /// A dose that is no positive number.
    #[error("a dose of {dose}, expected a positive number")]
    Dose {
        /// The dose.
        dose: f64,
    },
}

/// A value with its interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Between {
    /// The value of the largest likelihood.
    pub value: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// A law that fits the tests.
#[derive(Debug, Clone, PartialEq)]
pub struct Lifetime {
    law: LifetimeLaw,
    /// Logarithms of the doses, and whether the test failed.
    tests: Vec<(f64, bool)>,
    /// Number of failures.
    failed: usize,
    /// Probability of an interval.
    level: f64,
    /// `mu` and `sigma` of the largest likelihood.
    best: [f64; 2],
}

/// Steps of a golden section: the bracket shrinks to 2e-9 of its length, which moves a peak's value by far less than rounding does.
const SECTIONS: usize = 42;
/// Halvings of the bracket of an interval's end.
const HALVINGS: usize = 40;
/// Largest factor between the scale and the scatter of the doses.
const MOST_SCALE: f64 = 1e6;
/// Largest distance of an end from the middle, in scales.
const MOST_SCALES: f64 = 1e4;

impl Lifetime {
    /// Fits a law to tests by the largest likelihood; intervals have the probability `level`.
    ///
    /// # Errors
    /// [`LifetimeError`].
    pub fn fit(law: LifetimeLaw, tests: &[Tested], level: f64) -> Result<Self, LifetimeError> {
        if let Some(test) = tests.iter().find(|test| !(test.dose > 0.0 && test.dose.is_finite())) {
            return Err(LifetimeError::Dose { dose: test.dose });
        }
        let failures: Vec<f64> = tests.iter().filter(|test| test.failed).map(|test| test.dose).collect();
        if failures.len() < 2 {
            return Err(LifetimeError::Few { failed: failures.len(), tests: tests.len() });
        }
        let dose = failures[0];
        if failures.iter().all(|other| *other == dose) {
            return Err(LifetimeError::Equal { dose });
        }
        let tests = tests.iter().map(|test| (test.dose.ln(), test.failed)).collect();
        let mut fitted = Self { law, tests, failed: failures.len(), level, best: [0.0, 1.0] };
        // Any quantile has the same largest likelihood; the quantile at e = 0 is mu.
        let [low, high] = fitted.bracket();
        let mu = peak([low, high], |mu| fitted.profile(mu, 0.0).1).0;
        fitted.best = [mu, 1.0 / fitted.profile(mu, 0.0).0];
        Ok(fitted)
    }

    /// Scatter `sigma` of the logarithm of the dose.
    pub fn scatter(&self) -> f64 {
        self.best[1]
    }

    /// Largest logarithm of the likelihood of the logarithms of the doses.
    pub fn log_likelihood(&self) -> f64 {
        self.profile(self.best[0], 0.0).1
    }

    /// Dose at which a share of all has failed, with its confidence interval.
    pub fn quantile(&self, share: f64) -> Between {
        let [mu, sigma] = self.best;
        let e = self.law.quantile(share);
        let bound = self.bound(self.failed);
        let least = self.log_likelihood() - bound;
        self.between(mu + sigma * e, |q| self.profile(q, e).1 - least)
    }

    /// Dose at which a further one fails: the median, with the interval that holds it with the probability of the level.
    pub fn next(&self) -> Between {
        let [mu, sigma] = self.best;
        let middle = mu + sigma * self.law.quantile(0.5);
        let [low, high] = self.bracket();
        let (_, largest) = peak([low, high], |dose| self.with(dose));
        let least = largest - self.bound(self.failed + 1);
        self.between(middle, |dose| self.with(dose) - least)
    }

    /// Largest logarithm of the likelihood of all tests and a further failure at a dose, given by its logarithm.
    fn with(&self, dose: f64) -> f64 {
        let mut more = self.clone();
        more.tests.push((dose, true));
        peak(more.bracket(), |mu| more.profile(mu, 0.0).1).1
    }

    /// Distance from the peak of a profile of `count` failures at which intervals end: `count ln(1 + t^2 / f) / 2`, t the quantile of
    /// Student's distribution with f = failures - 1 degrees of freedom, by the beta distribution of `t^2 / (f + t^2)`.
    fn bound(&self, count: usize) -> f64 {
        let freedom = (self.failed - 1) as f64;
        let share = beta_quantile(0.5, 0.5 * freedom, self.level);
        -0.5 * count as f64 * (-share).ln_1p()
    }

    /// Logarithms of doses between which the middle of a law lies.
    fn bracket(&self) -> [f64; 2] {
        let ends = self
            .tests
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], (dose, _)| [low.min(*dose), high.max(*dose)]);
        let reach = 20.0 * self.spread();
        [ends[0] - reach, ends[1] + reach]
    }

    /// Largest difference of logarithms of doses.
    fn spread(&self) -> f64 {
        let doses = || self.tests.iter().map(|(dose, _)| *dose);
        doses().fold(f64::NEG_INFINITY, f64::max) - doses().fold(f64::INFINITY, f64::min)
    }

    /// `theta = 1 / sigma` of the largest likelihood with the quantile `mu + sigma e` at q, and the logarithm of that likelihood.
    fn profile(&self, q: f64, e: f64) -> (f64, f64) {
        let scale = self.tests.iter().map(|(dose, _)| (dose - q).abs()).fold(self.spread(), f64::max);
        let ends = [1.0 / (MOST_SCALE * scale), MOST_SCALE / self.spread()].map(f64::ln);
        let likelihood = |log_theta: f64| {
            let theta = log_theta.exp();
            let of = |(dose, failed): &(f64, bool)| {
                let e = theta * (dose - q) + e;
                if *failed { self.law.log_density(e) + log_theta } else { self.law.log_survival(e) }
            };
            self.tests.iter().map(of).sum::<f64>()
        };
        let (log_theta, largest) = peak(ends, likelihood);
        (log_theta.exp(), largest)
    }

    /// The ends at which a function that is positive in the middle changes its sign, as doses.
    fn between(&self, middle: f64, excess: impl Fn(f64) -> f64) -> Between {
        let end = |side: f64| {
            let mut step = self.best[1].max(1e-9);
            let mut inside = middle;
            while excess(middle + side * step) > 0.0 && step < MOST_SCALES * self.best[1] {
                inside = middle + side * step;
                step *= 2.0;
            }
            let mut outside = middle + side * step;
            for _ in 0..HALVINGS {
                let half = 0.5 * (inside + outside);
                if excess(half) > 0.0 { inside = half } else { outside = half }
            }
            0.5 * (inside + outside)
        };
        Between { value: middle.exp(), low: end(-1.0).exp(), high: end(1.0).exp() }
    }
}

impl LifetimeLaw {
    fn log_density(self, e: f64) -> f64 {
        match self {
            Self::LogNormal => -0.5 * (e * e + TAU.ln()),
            Self::Weibull => e - e.exp(),
        }
    }

    fn log_survival(self, e: f64) -> f64 {
        match self {
            // Where erfc is too small for a number, its asymptotic expansion.
            Self::LogNormal if e > 30.0 => -0.5 * e * e - (e * (2.0 * PI).sqrt()).ln() - 1.0 / (e * e),
            Self::LogNormal => libm::erfc(e / SQRT_2).ln() - LN_2,
            Self::Weibull => -e.exp(),
        }
    }

    /// Value of e below which a share lies.
    fn quantile(self, share: f64) -> f64 {
        match self {
            Self::LogNormal => normal_quantile(share),
            Self::Weibull => (-(-share).ln_1p()).ln(),
        }
    }
}

/// Place and value of the peak of a function with a single peak, by golden sections.
fn peak([mut low, mut high]: [f64; 2], of: impl Fn(f64) -> f64) -> (f64, f64) {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let mut inner = [high - golden * (high - low), low + golden * (high - low)];
    let mut values = inner.map(&of);
    for _ in 0..SECTIONS {
        if values[0] >= values[1] {
            high = inner[1];
            inner = [high - golden * (high - low), inner[0]];
            values = [of(inner[0]), values[0]];
        } else {
            low = inner[0];
            inner = [inner[1], low + golden * (high - low)];
            values = [values[1], of(inner[1])];
        }
    }
    let best = usize::from(values[1] > values[0]);
    (inner[best], values[best])
}

#[cfg(test)]
mod tests {
    use super::*;
    use decore_math::random::uniform;

    fn tests(failed: &[f64], still: &[f64]) -> Vec<Tested> {
        let of = |doses: &[f64], failed| doses.iter().map(|dose| Tested { dose: *dose, failed }).collect::<Vec<_>>();
        [of(failed, true), of(still, false)].concat()
    }

    fn near(found: Between, wanted: [f64; 3]) {
        for (found, wanted) in [found.value, found.low, found.high].into_iter().zip(wanted) {
            assert!((found / wanted - 1.0).abs() < 1e-5, "{found} {wanted}");
        }
    }

    /// Two failures at 1000 and 4000: logarithms 6.9078 and 8.2940, mean 7.6009, standard deviation 0.98026. Student's quantile with one
    /// degree of freedom is 12.7062, so ln D = 7.6009 +- 12.7062 x 0.98026 / sqrt 2, and a further one +- 12.7062 x 0.98026 x sqrt 1.5.
    #[test]
    fn two_failures_by_hand() {
        let law = Lifetime::fit(LifetimeLaw::LogNormal, &tests(&[1000.0, 4000.0], &[]), 0.95).unwrap();
        let (mean, deviation, t) = (2000.0_f64.ln(), 4.0_f64.ln() / 2.0_f64.sqrt(), 12.706_204_736_43);
        let ends = |reach: f64| [2000.0, (mean - reach).exp(), (mean + reach).exp()];
        near(law.quantile(0.5), ends(t * deviation / 2.0_f64.sqrt()));
        near(law.next(), ends(t * deviation * 1.5_f64.sqrt()));
        // Largest likelihood: the deviation with the divisor n.
        assert!((law.scatter() - 4.0_f64.ln() / 2.0).abs() < 1e-6, "{}", law.scatter());
    }

    /// Five failures and three tests that ended before: SciPy 1.16, `stats.CensoredData` and its `fit`, intervals by `minimize` and
    /// `brentq` over `norm`, `gumbel_l` and `t`.
    #[test]
    fn censored_tests_as_scipy() {
        let tests = tests(&[1200.0, 1850.0, 2100.0, 2600.0, 3900.0], &[1500.0, 3000.0, 3000.0]);
        let law = Lifetime::fit(LifetimeLaw::LogNormal, &tests, 0.95).unwrap();
        assert!((law.scatter() - 0.449_956_957).abs() < 1e-6 && (law.log_likelihood() + 4.958_008_839_8).abs() < 1e-9);
        near(law.quantile(0.5), [2_632.663_076, 1_678.450_878, 5_219.013_448]);
        near(law.next(), [2_632.663_076, 632.775_270, 13_059.874_342]);
        let law = Lifetime::fit(LifetimeLaw::Weibull, &tests, 0.95).unwrap();
        assert!((law.scatter() - 0.341_056_622).abs() < 1e-6 && (law.log_likelihood() + 4.995_766_450_8).abs() < 1e-9);
        near(law.quantile(0.5), [2_753.225_097, 1_703.086_803, 4_711.497_789]);
        near(law.next(), [2_753.225_097, 600.218_106, 9_101.529_266]);
    }

    /// Of 400 series of eight tests each, some of which end at the dose 2500: the intervals contain the true median and a further dose in
    /// 95 % of them, or a little more.
    #[test]
    fn intervals_cover() {
        for law in LifetimeLaw::ALL {
            let draw = |series: u64, test: u64| {
                let e = law.quantile(uniform(7, series, test));
                2000.0 * (0.5 * (e - law.quantile(0.5))).exp()
            };
            let (mut median, mut next, mut fitted) = (0, 0, 0);
            for series in 0..400 {
                let test = |test| {
                    let dose = draw(series, test);
                    Tested { dose: dose.min(2500.0), failed: dose < 2500.0 }
                };
                let Ok(law) = Lifetime::fit(law, &(0..8).map(test).collect::<Vec<_>>(), 0.95) else { continue };
                let (of_median, of_next, further) = (law.quantile(0.5), law.next(), draw(series, 8));
                fitted += 1;
                median += usize::from(of_median.low <= 2000.0 && 2000.0 <= of_median.high);
                next += usize::from(of_next.low <= further && further <= of_next.high);
            }
            let shares = [median, next].map(|count| count as f64 / f64::from(fitted));
            assert!(fitted > 380 && shares.iter().all(|share| (0.945..=0.995).contains(share)), "{law:?}: {shares:?}");
        }
    }

    #[test]
    fn tests_that_say_nothing_are_refused() {
        let error = |failed: &[f64], still: &[f64]| {
            Lifetime::fit(LifetimeLaw::Weibull, &tests(failed, still), 0.95).unwrap_err().to_string()
        };
        assert!(error(&[1000.0], &[2000.0]).starts_with("1 of 2 tests ended with a failure"));
        assert!(error(&[1000.0, 1000.0], &[2000.0]).contains("have the dose 1000"));
        assert!(error(&[1000.0, 0.0], &[]).starts_with("a dose of 0"));
    }
}

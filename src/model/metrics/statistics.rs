//! Means of a series and how sure they are.

use decore_math::special::student_quantile;

/// Fewest values whose mean has an error.
pub(super) const LEAST_VALUES: usize = 8;
/// Batches whose means bound the error from below.
const BATCHES: usize = 6;
/// Fewest degrees of freedom that a variance is granted.
const LEAST_FREEDOM: f64 = 2.0;
/// Least share of the variance that a mean over correlated values leaves in the series.
const LEAST_REST: f64 = 0.2;

/// Mean; `None` of nothing.
pub(super) fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Population variance; `None` of nothing.
pub(super) fn variance(values: &[f64]) -> Option<f64> {
    let centre = mean(values)?;
    let squares: Vec<f64> = values.iter().map(|value| (value - centre) * (value - centre)).collect();
    mean(&squares)
}

/// Standard error of the mean of a correlated series, enlarged for few values: mean +- 2 errors is a 95 % interval. `None` for
/// fewer than [`LEAST_VALUES`] values.
///
/// The larger of two estimates, each times Student's quantile for its degrees of freedom over 2. The correlation of near values
/// shows in the first one ([`by_correlation`]), slow changes over the series in the second one ([`by_batches`]).
pub(super) fn error_of_mean(values: &[f64]) -> Option<f64> {
    (values.len() >= LEAST_VALUES).then(|| by_correlation(values).max(by_batches(values)))
}

/// Error from the autocorrelation of the series, with `n / tau - 1` degrees of freedom.
///
/// A mean over a number of blows that is no multiple of their period is off by a part of one blow: the error is at least
/// `sqrt(c_0) / n`. The values' own mean takes a share `tau / n` of their variance, which is given back.
fn by_correlation(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let variance = variance(values).unwrap_or_default();
    let tau = correlation_time(values);
    let of_mean = (variance * tau / n).max(variance / (n * n));
    let tau = tau.max(1.0);
    half_student(n / tau - 1.0) * (of_mean / (1.0 - tau / n).max(LEAST_REST)).sqrt()
}

/// Error from the means of [`BATCHES`] batches of equal length, the first values left out where the number is no multiple.
///
/// Blows that alternate would show in batches of an odd length: means of neighbours take their place. Over `L` of these, white values
/// lose half of one, which is given back.
fn by_batches(values: &[f64]) -> f64 {
    let pairs: Vec<f64> = values.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
    let length = pairs.len() / BATCHES;
    let means: Vec<f64> = pairs[pairs.len() - BATCHES * length..].chunks(length).filter_map(mean).collect();
    let freedom = (BATCHES - 1) as f64;
    let lost = 1.0 - 0.5 / length as f64;
    half_student(freedom) * (variance(&means).unwrap_or_default() / (freedom * lost)).sqrt()
}

/// Sum of the autocorrelation over all lags: the number of values that count as one; 0 for a constant series.
///
/// The initial monotone sequence of Geyer (Statistical Science 7, 1992): `-1 + 2 sum_m (r_2m + r_2m+1)`, summed while the pairs
/// stay positive, each at most as large as the one before. At least 0.
pub(super) fn correlation_time(values: &[f64]) -> f64 {
    let n = values.len();
    let centre = mean(values).unwrap_or_default();
    let covariance = |lag: usize| -> f64 {
        let pairs = values.iter().zip(values.iter().skip(lag));
        pairs.map(|(a, b)| (a - centre) * (b - centre)).sum::<f64>() / n as f64
    };
    let variance = covariance(0);
    if variance <= 0.0 {
        return 0.0;
    }
    let pairs = (0..n / 2).map(|m| covariance(2 * m) + covariance(2 * m + 1)).take_while(|pair| *pair > 0.0);
    let (sum, _) = pairs.fold((0.0, f64::INFINITY), |(sum, least), pair| (sum + pair.min(least), pair.min(least)));
    (2.0 * sum / variance - 1.0).max(0.0)
}

/// Half of Student's quantile 0.975 for some degrees of freedom, at least [`LEAST_FREEDOM`].
fn half_student(freedom: f64) -> f64 {
    0.5 * student_quantile(0.975, freedom.max(LEAST_FREEDOM))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers from -1/2 to 1/2, uniformly distributed.
    fn noise(seed: u64) -> impl Iterator<Item = f64> {
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        std::iter::from_fn(move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            Some((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5)
        })
    }

    /// Values of an autoregressive series of order 1.
    fn correlated(seed: u64, a: f64, n: usize) -> Vec<f64> {
        let next = |x: &mut f64, e: f64| {
            *x = a * *x + e;
            Some(*x)
        };
        noise(seed).scan(0.0, next).skip(50).take(n).collect()
    }

    /// Share of 2000 series whose mean +- 2 errors holds 0.
    fn coverage(n: usize, a: f64) -> f64 {
        let holds = |seed: u64| {
            let series = correlated(seed, a, n);
            mean(&series).unwrap().abs() <= 2.0 * error_of_mean(&series).unwrap()
        };
        (1..=2000).filter(|seed| holds(*seed)).count() as f64 / 2000.0
    }

    /// Two errors hold the true mean in 95 % of series that are white, alternate or are correlated over a few values; of 24 values
    /// of which four count as one still in 90 %, where errors of independent values without Student's quantile hold it in 60 %.
    #[test]
    fn analytic_coverage() {
        for n in [24, 60, 400] {
            for a in [-0.5, 0.0, 0.3, 0.6] {
                let share = coverage(n, a);
                println!("n = {n}, a = {a}: {share}");
                assert!((0.90..=0.99).contains(&share), "n = {n}, a = {a}: {share}");
            }
        }
    }

    /// A trend widens the error to the size of the change; a plain error of independent values would be 5 times smaller.
    #[test]
    fn analytic_trend() {
        let trend: Vec<f64> = (0..60).map(|i| f64::from(i) / 59.0).collect();
        let error = error_of_mean(&trend).unwrap();
        assert!((0.15..0.5).contains(&error), "{error}");
    }

    /// Fewer degrees of freedom than two are taken as two.
    #[test]
    fn freedom_has_a_floor() {
        assert_eq!(half_student(0.5), half_student(2.0));
        assert!(half_student(2.0) > half_student(5.0));
    }

    /// An alternating series has a mean that is sure to half a blow over their number; a constant one is sure; few values have
    /// no error.
    #[test]
    fn analytic_short_series() {
        let alternating: Vec<f64> = (0..21).map(|i| if i % 2 == 0 { 3.0 } else { 1.0 }).collect();
        let error = error_of_mean(&alternating).unwrap();
        assert!((0.99 / 21.0..0.15).contains(&error), "{error}");
        assert_eq!(error_of_mean(&[2.0; 9]), Some(0.0));
        assert_eq!((error_of_mean(&[1.0; 7]), mean(&[]), variance(&[])), (None, None, None));
        assert_eq!((variance(&[1.0, 3.0]), correlation_time(&[])), (Some(1.0), 0.0));
    }
}

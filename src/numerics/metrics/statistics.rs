//! Means of a series and how sure they are.

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

/// Standard error of the mean of a stationary series with its autocorrelation; `None` of fewer than two values, which say
/// nothing about it.
///
/// `sqrt((-c_0 + 2 sum_m (c_2m + c_2m+1)) / n)` with the autocovariances `c_k`, summed as long as the pairs stay positive (the
/// initial positive sequence of Geyer, Statistical Science 7, 1992). A mean over a number of blows that is no multiple of
/// their period is off by a part of one blow: the error is at least `sqrt(c_0) / n`.
pub(super) fn standard_error(values: &[f64]) -> Option<f64> {
    let n = values.len();
    let centre = mean(values).filter(|_| n >= 2)?;
    let covariance = |lag: usize| -> f64 {
        let pairs = values.iter().zip(values.iter().skip(lag));
        pairs.map(|(a, b)| (a - centre) * (b - centre)).sum::<f64>() / n as f64
    };
    let least = covariance(0);
    let pairs = (0..n.div_ceil(2)).map(|m| covariance(2 * m) + covariance(2 * m + 1));
    let sum: f64 = pairs.take_while(|pair| *pair > 0.0).sum();
    let of_mean = (2.0 * sum - least) / n as f64;
    Some(of_mean.max(least / (n * n) as f64).sqrt())
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

    /// Over many series, the mean's own standard deviation is what the estimate says on average: for white noise,
    /// `sigma / sqrt(n)`, and for an autoregressive one, `sigma / (1 - a) / sqrt(n)`, which the plain formula misses.
    #[test]
    fn analytic_standard_errors() {
        let n = 400;
        for a in [0.0, 0.6] {
            let (mut estimates, mut means) = (0.0, 0.0);
            for seed in 1..=200 {
                let mut x = 0.0;
                let series: Vec<f64> = noise(seed)
                    .skip(50)
                    .take(n)
                    .map(|e| {
                        x = a * x + e;
                        x
                    })
                    .collect();
                estimates += standard_error(&series).unwrap() / 200.0;
                means += mean(&series).unwrap().powi(2) / 200.0;
            }
            let expected = (1.0_f64 / 12.0).sqrt() / (1.0 - a) / (n as f64).sqrt();
            assert!((means.sqrt() / expected - 1.0).abs() < 0.15, "a = {a}: {} and {expected}", means.sqrt());
            assert!((estimates / expected - 1.0).abs() < 0.12, "a = {a}: {estimates} and {expected}");
        }
    }

    /// An alternating series has a mean that is sure to half a blow over their number; a constant one is sure; one value
    /// says nothing.
    #[test]
    fn analytic_short_series() {
        let alternating: Vec<f64> = (0..21).map(|i| if i % 2 == 0 { 3.0 } else { 1.0 }).collect();
        let error = standard_error(&alternating).unwrap();
        assert!((0.99 / 21.0..0.06).contains(&error), "{error}");
        assert_eq!(standard_error(&[2.0; 9]), Some(0.0));
        assert_eq!(standard_error(&[1.0, 3.0]), Some(0.5));
        assert_eq!((standard_error(&[1.0]), standard_error(&[]), mean(&[]), variance(&[])), (None, None, None, None));
        assert_eq!(variance(&[1.0, 3.0]), Some(1.0));
    }
}

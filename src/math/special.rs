//! Distribution functions and quantiles that are not elementary.
//!
//! They use only libm's functions and basic operations, so a factor's value has the same bits on every system.

use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2, TAU};

use libm::{erf, erfc, exp, lgamma, log, log1p};

/// Steps of Halley's method, which triples the digits: from four beyond those of a number.
const STEPS: usize = 3;
/// Most terms of a continued fraction; about the root of the larger shape is needed.
const MOST_TERMS: u32 = 100_000;

/// Standard normal distribution function.
pub fn normal_cdf(z: f64) -> f64 {
    0.5 * erfc(-z / SQRT_2)
}

/// Standard normal quantile for a probability in [0, 1]; infinite at its ends.
///
/// A rational approximation (Abramowitz and Stegun 1964, 26.2.23), then Halley's method on the tail's probability, or near the
/// middle on what the tail lacks to a half.
pub fn normal_quantile(probability: f64) -> f64 {
    let tail = probability.min(1.0 - probability);
    if tail <= 0.0 || tail == 0.5 {
        return if tail == 0.5 { 0.0 } else { f64::INFINITY.copysign(probability - 0.5) };
    }
    let t = (-2.0 * log(tail)).sqrt();
    let (above, below) =
        (2.515_517 + t * (0.802_853 + t * 0.010_328), 1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308)));
    let mut z = t - above / below;
    for _ in 0..STEPS {
        let x = z * FRAC_1_SQRT_2;
        let excess = if tail > 0.25 { 0.5 * ((1.0 - 2.0 * tail) - erf(x)) } else { 0.5 * erfc(x) - tail };
        let step = excess * TAU.sqrt() / exp(-0.5 * z * z);
        z += step / (1.0 - 0.5 * z * step);
    }
    z.copysign(probability - 0.5)
}

/// Quantile of Student's distribution for a probability in [0, 1].
///
/// The expansion in powers of `1 / freedom` (Abramowitz and Stegun 1964, 26.7.5): for the quantile 0.975 within 1 % from 2 degrees of
/// freedom on.
pub fn student_quantile(probability: f64, freedom: f64) -> f64 {
    let (v, z) = (freedom.recip(), normal_quantile(probability));
    let square = z * z;
    let terms = [
        1.0,
        (square + 1.0) / 4.0,
        ((5.0 * square + 16.0) * square + 3.0) / 96.0,
        (((3.0 * square + 19.0) * square + 17.0) * square - 15.0) / 384.0,
        ((((79.0 * square + 776.0) * square + 1482.0) * square - 1920.0) * square - 945.0) / 92160.0,
    ];
    z * terms.iter().rev().fold(0.0, |sum, term| sum * v + term)
}

/// Distribution function of the beta distribution in [0, 1], the regularised incomplete beta function `I_x(a, b)`.
///
/// Uses the continued fraction (Digital Library of Mathematical Functions, 8.17.22) with Lentz' method, on the side where it converges
/// fast.
pub fn beta_cdf(a: f64, b: f64, x: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return if x <= 0.0 { 0.0 } else { 1.0 };
    }
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - beta_cdf(b, a, 1.0 - x);
    }
    let away_from_zero = |value: f64| if value.abs() < f64::MIN_POSITIVE { f64::MIN_POSITIVE } else { value };
    let (mut c, mut d) = (1.0, away_from_zero(1.0 - (a + b) * x / (a + 1.0)).recip());
    let mut fraction = d;
    for m in (1..MOST_TERMS).map(f64::from) {
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        for term in [even, odd] {
            d = away_from_zero(1.0 + term * d).recip();
            c = away_from_zero(1.0 + term / c);
            fraction *= c * d;
        }
        if (c * d - 1.0).abs() <= f64::EPSILON {
            break;
        }
    }
    exp(a * log(x) + b * log1p(-x) + lgamma(a + b) - lgamma(a) - lgamma(b)) * fraction / a
}

/// Quantile of the beta distribution in [0, 1], by bisection of the distribution function to the last digit.
pub fn beta_quantile(alpha: f64, beta: f64, probability: f64) -> f64 {
    if probability <= 0.0 || probability >= 1.0 {
        return probability;
    }
    // Bisected over the words of positive floats, whose order is that of the numbers: as sharp near 0 as elsewhere.
    let (mut low, mut high) = (0_u64, 1.0_f64.to_bits());
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if beta_cdf(alpha, beta, f64::from_bits(middle)) < probability {
            low = middle;
        } else {
            high = middle;
        }
    }
    f64::from_bits(high)
}

#[cfg(test)]
mod tests {
    use statrs::function::beta::beta_reg;
    use statrs::function::erf::{erf_inv, erfc_inv};

    use super::*;

    #[test]
    fn student_quantiles_are_those_of_tables() {
        for (freedom, expected) in [(2.0, 4.3027), (4.0, 2.7764), (9.0, 2.2622), (19.0, 2.0930), (200.0, 1.9719)] {
            let found = student_quantile(0.975, freedom);
            assert!((found / expected - 1.0).abs() < if freedom < 4.0 { 1e-2 } else { 1e-3 }, "{freedom}: {found}");
        }
        assert!((student_quantile(0.025, 9.0) + 2.2622).abs() < 1e-3);
    }

    #[test]
    fn normal_quantiles_are_those_of_another_library() {
        for p in (1..1000).map(|i| f64::from(i) / 1000.0).chain((2..300).map(|k| 10.0_f64.powi(-k))) {
            let expected =
                if p > 0.25 && p < 0.75 { SQRT_2 * erf_inv(2.0 * p - 1.0) } else { -SQRT_2 * erfc_inv(2.0 * p) };
            let found = normal_quantile(p);
            assert!((found - expected).abs() <= 4e-15 * expected.abs(), "{p}: {found} and {expected}");
            assert!((normal_cdf(found) / p - 1.0).abs() < 1e-12, "{p}: {found}");
        }
        assert_eq!([0.0, 0.5, 1.0].map(normal_quantile), [f64::NEG_INFINITY, 0.0, f64::INFINITY]);
        assert!(normal_quantile(f64::NAN).is_nan());
        // Of tables: 1.959963984540054235.
        assert!((normal_quantile(0.025) + 1.959_963_984_540_054_2).abs() < 4.5e-16);
    }

    #[test]
    fn beta_functions_are_those_of_another_library() {
        for (a, b) in [(0.5, 3.0), (1.0, 1.0), (2.5, 0.2), (7.0, 40.0), (1000.0, 3.0), (300.0, 500.0), (0.01, 0.02)] {
            for x in (0..=200).map(|i| f64::from(i) / 200.0) {
                let (found, expected) = (beta_cdf(a, b, x), beta_reg(a, b, x));
                assert!((found - expected).abs() < 2e-12, "{a}, {b}, {x}: {found} and {expected}");
            }
        }
        // In closed form: 1 - (1 - x)^n.
        assert!((beta_quantile(1.0, 3.0, 0.488) - 0.2).abs() < 1e-15);
    }
}

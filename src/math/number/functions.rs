//! Exponential function, logarithm, hyperbolic tangent and power by basic operations alone.

use super::definition::{Mask, Number};

/// `ln 2` in two parts, the first with zeros at its end: its multiples by exponents are exact.
const LN_2: [f64; 2] = [0.693_147_180_369_123_8, 1.908_214_929_270_587_7e-10];
/// Largest magnitude of the argument of `exp`. Results beyond it would overflow or vanish for all purposes here.
const LARGEST_EXPONENT: f64 = 700.0;
/// Least number of which a logarithm is taken.
const LEAST: f64 = f64::MIN_POSITIVE;

/// `exp(x)` for `|x|` up to 700, to some units in the last place; the value at the nearer end beyond.
#[inline(always)]
pub fn exp<R: Number>(x: R) -> R {
    /// Adding this constant to a number up to 2^51 rounds it to a whole number.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    // In this order of arguments a NaN remains one.
    let x = R::splat(-LARGEST_EXPONENT).greatest(R::splat(LARGEST_EXPONENT).least(x));
    let k = (x * R::splat(std::f64::consts::LOG2_E) + R::splat(ROUND)) - R::splat(ROUND);
    let r = (x - k * R::splat(LN_2[0])) - k * R::splat(LN_2[1]);
    // The series up to r^13 / 13!, |r| below 0.347: even and odd powers, two short chains instead of a long one.
    let square = r * r;
    let (mut even, mut odd) = (R::splat(1.0 / 479_001_600.0), R::splat(1.0 / 6_227_020_800.0));
    for [even_factorial, odd_factorial] in
        [[3_628_800.0, 39_916_800.0], [40_320.0, 362_880.0], [720.0, 5040.0], [24.0, 120.0], [2.0, 6.0], [1.0, 1.0]]
    {
        even = even * square + R::splat(1.0 / even_factorial);
        odd = odd * square + R::splat(1.0 / odd_factorial);
    }
    let sum = even + r * odd;
    sum * k.power_of_two()
}

/// `ln(x)` of a positive normal number, to some units in the last place; smaller numbers give the value of the smallest normal one.
#[inline(always)]
pub fn ln<R: Number>(x: R) -> R {
    let one = R::splat(1.0);
    let (mantissa, exponent) = x.greatest(R::splat(LEAST)).mantissa_and_exponent();
    // Between sqrt(1/2) and sqrt(2).
    let large = mantissa.greater(R::splat(std::f64::consts::SQRT_2));
    let mantissa = R::select(large, R::splat(0.5) * mantissa, mantissa);
    let exponent = R::select(large, exponent + one, exponent);
    // ln m = 2 artanh((m - 1) / (m + 1)), its argument below 0.172.
    let f = (mantissa - one) / (mantissa + one);
    let square = f * f;
    let mut sum = R::splat(1.0 / 21.0);
    for odd in [19.0, 17.0, 15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0] {
        sum = sum * square + R::splat(1.0 / odd);
    }
    let twice = f + f;
    exponent * R::splat(LN_2[0]) + (twice + (twice * square * sum + exponent * R::splat(LN_2[1])))
}

/// `tanh(x)`, to an absolute 2e-16.
#[inline(always)]
pub fn tanh<R: Number>(x: R) -> R {
    let one = R::splat(1.0);
    let fade = exp(R::splat(-2.0) * x.abs());
    ((one - fade) / (one + fade)).copysign(x)
}

/// `x^n` of a number that is not negative, `n > 0`; 0 below the least normal number.
#[inline(always)]
pub fn power<R: Number>(x: R, n: R) -> R {
    R::select(x.greater_equal(R::splat(LEAST)), exp(n * ln(x)), x * R::splat(0.0))
}

/// `|x|^n` with the sign of `x`, `n > 0`; a root alone where all lanes have 3/2.
#[inline(always)]
pub fn odd_power<R: Number>(x: R, n: R) -> R {
    let (general, root) = (n.less(R::splat(1.5)).or(n.greater(R::splat(1.5))), x * x.abs().sqrt());
    if general.any() { R::select(general, power(x.abs(), n).copysign(x), root) } else { root }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::Four;

    /// Numbers of all sizes from `least` to `greatest`, spread evenly over their logarithm.
    fn spread(least: f64, greatest: f64) -> impl Iterator<Item = f64> {
        let (from, to) = (least.ln(), greatest.ln());
        (0..20_000).map(move |i| (from + (to - from) * f64::from(i) / 20_000.0).exp())
    }

    /// Compares each function with the standard library.
    #[test]
    fn analytic_functions() {
        for x in spread(1e-9, 699.0).flat_map(|x| [x, -x]) {
            assert!((exp(x) / x.exp() - 1.0).abs() < 1e-15, "exp {x}");
            assert!((tanh(x) - x.tanh()).abs() < 3e-16, "tanh {x}");
        }
        for x in spread(1e-300, 1e300) {
            assert!((ln(x) - x.ln()).abs() < 4e-16 * x.ln().abs().max(1.0), "ln {x}");
        }
        for x in spread(1e-12, 10.0) {
            for n in [0.3, 1.0, 1.5, 2.2] {
                assert!((power(x, n) / x.powf(n) - 1.0).abs() < 2e-14, "{x}^{n}");
                assert!((odd_power(-x, n) / -x.powf(n) - 1.0).abs() < 2e-14, "{x}^{n}");
            }
        }
        assert_eq!((exp(0.0), ln(1.0), tanh(0.0), tanh(900.0), tanh(-900.0)), (1.0, 0.0, 0.0, 1.0, -1.0));
        assert_eq!((power(0.0, 2.2), odd_power(0.0, 1.3), odd_power(-4.0, 1.5)), (0.0, 0.0, -8.0));
    }

    type Pair<R> = fn(R, R) -> R;

    /// Every operation and function.
    fn all<R: Number>() -> [Pair<R>; 17] {
        [
            |a, b| a + b,
            |a, b| a - b,
            |a, b| a * b,
            |a, b| a / b,
            |a, _| -a,
            |a, b| a.mul_add(b, -a),
            |a, _| a.sqrt(),
            |a, b| a.abs().copysign(b),
            |a, b| a.least(b),
            |a, b| a.greatest(b),
            |a, b| R::select(a.less_equal(b), b, R::splat(3.0)),
            |a, b| R::select(a.greater_equal(b).and(b.greater(R::splat(0.0))), a, b),
            |a, _| exp(a),
            |a, _| ln(a),
            |a, _| tanh(a),
            |a, b| power(a.abs(), b.abs()),
            |a, b| odd_power(a, b.abs()),
        ]
    }

    fn lanes_equal_numbers_alone<R: Number>() {
        let numbers: Vec<f64> = spread(1e-12, 1e12).step_by(900).flat_map(|x| [x, -x]).collect();
        let special = [0.0, -0.0, 1.5, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e-310];
        let numbers: Vec<f64> = numbers.into_iter().chain(special).collect();
        let at = |i: usize| numbers[i % numbers.len()];
        for (which, (alone, lanes)) in all::<f64>().into_iter().zip(all::<R>()).enumerate() {
            for (i, j) in (0..numbers.len()).flat_map(|i| (0..numbers.len()).map(move |j| (i, j))) {
                let (mut a, mut b) = (R::splat(0.0), R::splat(0.0));
                for lane in 0..R::LANES {
                    a.put(lane, &at(i + lane));
                    b.put(lane, &at(j + 3 * lane));
                }
                let found = lanes(a, b);
                for lane in 0..R::LANES {
                    let (found, expected) = (found.lane(lane), alone(at(i + lane), at(j + 3 * lane)));
                    let same = found.to_bits() == expected.to_bits() || found.is_nan() && expected.is_nan();
                    assert!(same, "operation {which} of {} and {}", at(i + lane), at(j + 3 * lane));
                }
            }
        }
    }

    /// A number in a lane has the same bits as alone, whatever the other lanes contain.
    #[test]
    fn four_equal_numbers_alone() {
        lanes_equal_numbers_alone::<Four>();
        #[cfg(target_arch = "x86_64")]
        {
            if crate::number::Registers::Avx2.are_available() {
                lanes_equal_numbers_alone::<crate::number::FourAvx>();
            }
            if crate::number::Registers::Avx512.are_available() {
                lanes_equal_numbers_alone::<crate::number::EightAvx>();
            }
        }
    }
}

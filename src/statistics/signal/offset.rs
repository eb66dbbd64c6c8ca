//! Delay between two signals, by cross-correlation.

use rustfft::num_complex::Complex;

use super::error::SignalError;
use super::transform::Transform;

/// A shift between two signals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Offset {
    /// Delay in s of the second signal.
    pub time_s: f64,
    /// Correlation coefficient where both overlap at that shift, -1 to 1.
    pub correlation: f64,
}

/// Time shifts at which two signals are most alike.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Offsets {
    /// As they are.
    pub upright: Offset,
    /// With the sign of the second turned.
    pub reversed: Offset,
}

/// The shift of `later` against `first`, both with a sample every `interval_s`: where `c_k = sum_j f_j l_(j + k)` of the signals
/// less their means is largest, between samples the top of the parabola through the three around it. Samples that `later` does not
/// have add nothing. With the sign of `later` turned the shift is where `c_k` is smallest.
///
/// # Errors
/// [`SignalError::Short`] for less than two samples.
pub fn offset(first: &[f64], later: &[Option<f64>], interval_s: f64) -> Result<Offsets, SignalError> {
    let samples = first.len().min(later.len());
    if samples < 2 {
        return Err(SignalError::Short { samples, least: 2, purpose: "find a shift in time" });
    }
    let length = (first.len() + later.len()).next_power_of_two();
    let mean = mean(later.iter().copied().flatten());
    let centred_later: Vec<f64> = later.iter().map(|value| value.map_or(0.0, |value| value - mean)).collect();
    let products = products(&centred(first), &centred_later, length);
    let of = |sign: f64| {
        // Shifts from all of `later` before `first` to all of it after: negative ones stand at the end.
        let shifts = 1 - first.len() as i64..later.len() as i64;
        let at = |shift: i64| sign * products[shift.rem_euclid(length as i64) as usize];
        let shift = shifts.max_by(|a, b| at(*a).total_cmp(&at(*b))).unwrap_or(0);
        let (before, top, after) = (at(shift - 1), at(shift), at(shift + 1));
        let bend = before - 2.0 * top + after;
        let between = if bend < 0.0 { 0.5 * (before - after) / bend } else { 0.0 };
        let (skip_first, skip_later) = ((-shift).max(0) as usize, shift.max(0) as usize);
        let pairs = first[skip_first..].iter().zip(&later[skip_later..]);
        let (first, later): (Vec<f64>, Vec<f64>) = pairs.filter_map(|(first, later)| Some((*first, (*later)?))).unzip();
        Offset { time_s: (shift as f64 + between) * interval_s, correlation: sign * correlation(&first, &later) }
    };
    Ok(Offsets { upright: of(1.0), reversed: of(-1.0) })
}

/// The mean; of no values 0.
fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / f64::max(count, 1.0)
}

/// A signal less its mean.
fn centred(values: &[f64]) -> Vec<f64> {
    let mean = mean(values.iter().copied());
    values.iter().map(|value| value - mean).collect()
}

/// All `sum_j first_j later_(j + k)`, `k` modulo `length`, by transforms: the transform of the conjugate is the conjugate of the inverse.
fn products(first: &[f64], later: &[f64], length: usize) -> Vec<f64> {
    let transform = Transform::of(length);
    let transformed = |values: &[f64]| {
        let mut all: Vec<Complex<f64>> = values.iter().map(Complex::from).collect();
        all.resize(length, Complex::ZERO);
        transform.run(all)
    };
    let (first, later) = (transformed(first), transformed(later));
    let lines = first.iter().zip(later).map(|(first, later)| first * later.conj()).collect();
    transform.run(lines).into_iter().map(|product| product.re).collect()
}

/// Correlation coefficient of two signals of equal length; 0 if one does not vary.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let (a, b) = (centred(a), centred(b));
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let size = (product(&a, &a) * product(&b, &b)).sqrt();
    if size > 0.0 { product(&a, &b) / size } else { 0.0 }
}

/// Instants at equal distances.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// The first, s.
    pub from_s: f64,
    /// From one to the next, s.
    pub interval_s: f64,
    /// Number of samples.
    pub count: usize,
}

/// Part of an interval by which an instant may miss an end by rounding.
const ROUNDING: f64 = 1e-6;

/// Values at the instants of a grid, linear between the samples of a signal whose times ascend; `None` before its first, after
/// its last, and between two that are further apart than `longest_s`. An instant that misses one of both ends by rounding alone has
/// its value.
pub fn resampled(times_s: &[f64], values: &[f64], grid: Grid, longest_s: f64) -> Vec<Option<f64>> {
    let Grid { from_s, interval_s, count } = grid;
    let ends_s = [times_s.first(), times_s.last()].map(|end| end.copied().unwrap_or(0.0));
    let mut k = 0;
    let at = |index: usize| {
        let time_s = from_s + interval_s * index as f64;
        let end_s = ends_s.into_iter().find(|end_s| (time_s - end_s).abs() <= ROUNDING * interval_s);
        let time_s = end_s.unwrap_or(time_s);
        while times_s.get(k + 1).is_some_and(|next| *next < time_s) {
            k += 1;
        }
        let (begin, value) = (*times_s.get(k)?, *values.get(k)?);
        let (Some(end), Some(next)) = (times_s.get(k + 1), values.get(k + 1)) else {
            return (begin == time_s).then_some(value);
        };
        if end - begin > longest_s {
            return if time_s == *end { Some(*next) } else { (time_s == begin).then_some(value) };
        }
        (begin..=*end).contains(&time_s).then(|| value + (next - value) * (time_s - begin) / (end - begin))
    };
    (0..count).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_shifts_are_found() {
        let wave =
            |time: f64| (-(time - 0.3_f64).powi(2) / 2e-4).exp() + 0.4 * (-(time - 0.7_f64).powi(2) / 1e-4).exp();
        let first: Vec<f64> = (0..1000).map(|k| wave(k as f64 * 1e-3)).collect();
        for (shift_s, gain) in [(0.1234, 2.5), (-0.0817, 0.4), (0.0, 1.0)] {
            let later: Vec<f64> = (0..1300).map(|k| 3.0 + gain * wave(k as f64 * 1e-3 - shift_s)).collect();
            // Whole, and without a part of it.
            for gap in [0..0, 480..580] {
                let there = |(k, value): (usize, &f64)| (!gap.contains(&k)).then_some(*value);
                let later: Vec<Option<f64>> = later.iter().enumerate().map(there).collect();
                let turned: Vec<Option<f64>> = later.iter().map(|value| value.map(|value| -value)).collect();
                let found = offset(&first, &later, 1e-3).expect("offset").upright;
                assert_eq!(offset(&first, &turned, 1e-3).expect("offset").reversed, found);
                assert!((found.time_s - shift_s).abs() < 2e-5, "{shift_s}: {found:?}");
                assert!(found.correlation > 0.999, "{found:?}");
            }
        }
        assert!(matches!(offset(&first, &[Some(1.0)], 1e-3), Err(SignalError::Short { samples: 1, .. })));
    }

    #[test]
    fn lines_between_samples_are_straight() {
        let (times, values) = ([0.0, 0.1, 0.4], [1.0, 3.0, 0.0]);
        let within =
            |from_s, longest_s| resampled(&times, &values, Grid { from_s, interval_s: 0.05, count: 1 }, longest_s)[0];
        let at = |from_s| within(from_s, f64::INFINITY);
        assert_eq!((at(-0.01), at(0.0), at(0.41)), (None, Some(1.0), None));
        let grid = Grid { from_s: 0.0, interval_s: 0.1, count: 2 };
        assert_eq!(resampled(&times, &values, grid, f64::INFINITY), [Some(1.0), Some(3.0)]);
        // 7500 * 2e-5 lies beyond 0.15 by rounding.
        let end = Grid { from_s: 0.0, interval_s: 2e-5, count: 7501 };
        assert_eq!(resampled(&[0.0, 0.15], &[1.0, 4.0], end, f64::INFINITY).last(), Some(&Some(4.0)));
        // Its ends belong to the samples, the points between them to none.
        assert_eq!([0.05, 0.1, 0.25, 0.4].map(|at| within(at, 0.2).is_some()), [true, true, false, true]);
        assert!((at(0.05).expect("within") - 2.0).abs() < 1e-15 && (at(0.25).expect("within") - 1.5).abs() < 1e-15);
    }
}

//! Axes: names, ranges and ticks.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

/// Most ticks of an axis.
const TICKS: f64 = 7.0;
/// Decades beyond which only whole ones have ticks.
const FINE_DECADES: f64 = 2.5;
/// Steps between ticks, and ticks within a decade.
const STEPS: [f64; 4] = [1.0, 2.0, 2.5, 5.0];
const WITHIN_DECADE: [f64; 3] = [1.0, 2.0, 5.0];

/// One axis of a chart.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Axis {
    /// Title with the unit: `time (s)`.
    pub label: String,
    /// Whether equal distances are equal ratios; values that are not positive are not drawn then.
    pub logarithmic: bool,
}

/// Range and ticks of an axis, in drawn units: the values or their logarithms.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Scale {
    pub low: f64,
    pub high: f64,
    pub ticks: Vec<f64>,
    /// Digits after the point of a linear axis' labels.
    decimals: usize,
    logarithmic: bool,
}

impl Axis {
    /// An axis whose equal distances are equal differences.
    pub fn linear(label: &str) -> Self {
        Self { label: label.to_owned(), logarithmic: false }
    }

    /// An axis whose equal distances are equal ratios.
    pub fn logarithmic(label: &str) -> Self {
        Self { label: label.to_owned(), logarithmic: true }
    }

    /// Position of a value; not finite if it cannot be drawn.
    pub(super) fn place(&self, value: f64) -> f64 {
        if self.logarithmic { value.log10() } else { value }
    }

    /// The scale that holds all values.
    pub(super) fn scale(&self, values: impl Iterator<Item = f64>) -> Scale {
        let places = values.map(|value| self.place(value)).filter(|place| place.is_finite());
        let (low, high) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
        if self.logarithmic { decades(low, high) } else { linear(low, high) }
    }
}

impl Ranged for Scale {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (first, last): (i32, i32)) -> i32 {
        let share = (value - self.low) / (self.high - self.low);
        (f64::from(first) + share * f64::from(last - first)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() { Vec::new() } else { self.ticks.clone() }
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

impl ValueFormatter<f64> for Scale {
    fn format(tick: &f64) -> String {
        tick.to_string()
    }

    fn format_ext(&self, tick: &f64) -> String {
        if !self.logarithmic {
            return format!("{tick:.*}", self.decimals);
        }
        let value = 10f64.powf(*tick);
        if (1e-3..1e5).contains(&value) {
            let decimals = (-tick.floor()).max(0.0) as usize;
            format!("{value:.decimals$}")
        } else {
            format!("{value:.0e}")
        }
    }
}

fn linear(low: f64, high: f64) -> Scale {
    let span = if high > low { high - low } else { low.abs().max(1.0) };
    let power = 10f64.powf((span / TICKS).log10().floor());
    let wide_enough = |step: &f64| span / step <= TICKS;
    let step = STEPS.iter().map(|step| step * power).find(wide_enough).unwrap_or(10.0 * power);
    let (first, last) = ((low / step + 1e-9).floor(), (high / step - 1e-9).ceil());
    let count = (last - first).max(1.0) as usize;
    let ticks: Vec<f64> = (0..=count).map(|index| (first + index as f64) * step).collect();
    // 2.5 and 0.25 need one digit more than their power of ten.
    let digits = if (step / power).fract() > 0.0 { 1.0 } else { 0.0 } - step.log10().floor();
    Scale {
        low: first * step,
        high: (first + count as f64) * step,
        ticks,
        decimals: digits.max(0.0) as usize,
        logarithmic: false,
    }
}

/// Ticks at 1, 2 and 5 of every decade, or over many decades at whole ones.
fn decades(low: f64, high: f64) -> Scale {
    let whole = high - low > FINE_DECADES;
    let step = ((high - low) / TICKS).ceil().max(1.0) as usize;
    let within: &[f64] = if whole { &WITHIN_DECADE[..1] } else { &WITHIN_DECADE };
    let all = (low.floor() as i32..=high.ceil() as i32).step_by(if whole { step } else { 1 });
    let all: Vec<f64> =
        all.flat_map(|decade| within.iter().map(move |factor| f64::from(decade) + factor.log10())).collect();
    let first = all.iter().rposition(|tick| *tick <= low + 1e-9).unwrap_or(0);
    let last = all.iter().position(|tick| *tick >= high - 1e-9).unwrap_or(all.len() - 1).max(first + 1);
    let ticks: Vec<f64> = all.into_iter().skip(first).take(last + 1 - first).collect();
    let ends = (ticks.first().copied().unwrap_or(low), ticks.last().copied().unwrap_or(high));
    Scale { low: ends.0.min(low), high: ends.1.max(high), ticks, decimals: 0, logarithmic: true }
}

#[cfg(test)]
mod tests {
    use plotters::coord::ranged1d::ValueFormatter;

    use super::Axis;

    fn labels(axis: &Axis, values: &[f64]) -> Vec<String> {
        let scale = axis.scale(values.iter().copied());
        scale.ticks.iter().map(|tick| scale.format_ext(tick)).collect()
    }

    #[test]
    fn ticks_are_round_and_their_labels_short() {
        let linear = Axis::linear("time (s)");
        assert_eq!(labels(&linear, &[0.0, 1.5]), ["0.00", "0.25", "0.50", "0.75", "1.00", "1.25", "1.50"]);
        assert_eq!(labels(&linear, &[-7.5, 3.2]), ["-8", "-6", "-4", "-2", "0", "2", "4"]);
        let ratio = Axis::logarithmic("error");
        assert_eq!(labels(&ratio, &[15.0, 900.0]), ["10", "20", "50", "100", "200", "500", "1000"]);
        assert_eq!(labels(&ratio, &[1e-9, 1e-3]), ["1e-9", "1e-8", "1e-7", "1e-6", "1e-5", "1e-4", "0.001"]);
    }

    #[test]
    fn every_value_lies_within_its_scale() {
        for axis in [Axis::linear(""), Axis::logarithmic("")] {
            for values in [[3.0, 3.0], [1e-12, 1.0], [0.2, 0.3], [1e-30, 1e30]] {
                let scale = axis.scale(values.into_iter());
                assert!(scale.low < scale.high && scale.ticks.len() <= 12, "{values:?}: {scale:?}");
                for value in values {
                    let place = axis.place(value);
                    let rounding = 1e-9 * place.abs().max(1.0);
                    assert!(scale.low <= place + rounding && place - rounding <= scale.high, "{value}: {scale:?}");
                }
            }
        }
    }
}

//! Ranges of numbers, as declarations write them, and their words.

use serde_json::{Map, Value};

use super::Fault;

/// Finite numbers between two ends.
///
/// A declaration writes it `[finite]`, `[> 0]`, `[>= 1]`, `[> 0, <= 0.1]` or, of whole numbers, `[1 ..]` and `[0 ..= 1000]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// Lower end.
    pub low: f64,
    /// Whether the lower end itself is outside.
    pub open: bool,
    /// Upper end, which is inside.
    pub high: f64,
    /// What a value is expected to be, in words.
    pub words: &'static str,
}

impl Range {
    /// Whether a number is finite and in the range.
    pub fn holds(&self, value: f64) -> bool {
        let above = if self.open { value > self.low } else { value >= self.low };
        value.is_finite() && above && value <= self.high
    }

    /// Adds a fault for each number of a value that is not in the range.
    pub fn check(&self, value: &impl Numbers, at: &str, faults: &mut Vec<Fault>) {
        value.visit(&mut |number| {
            if !self.holds(number) {
                let message = format!("is {number}, expected {}", self.words);
                faults.push(Fault { path: at.to_owned(), message });
            }
        });
    }

    /// The ends as keywords of a JSON schema.
    pub(super) fn keywords(&self) -> impl Iterator<Item = (String, Value)> {
        let ends = [(if self.open { "exclusiveMinimum" } else { "minimum" }, self.low), ("maximum", self.high)];
        let written = ends.into_iter().filter(|(_, end)| end.is_finite()).map(|(keyword, end)| {
            // Ends of whole numbers have to be whole numbers.
            let value = if end.fract() == 0.0 { Value::from(end as i64) } else { Value::from(end) };
            (keyword.to_owned(), value)
        });
        written.collect::<Map<String, Value>>().into_iter()
    }
}

/// Values that consist of numbers.
pub trait Numbers {
    /// Shows every number.
    fn visit(&self, see: &mut dyn FnMut(f64));
}

impl Numbers for f64 {
    fn visit(&self, see: &mut dyn FnMut(f64)) {
        see(*self);
    }
}

impl Numbers for usize {
    fn visit(&self, see: &mut dyn FnMut(f64)) {
        see(*self as f64);
    }
}

impl Numbers for u64 {
    fn visit(&self, see: &mut dyn FnMut(f64)) {
        see(*self as f64);
    }
}

impl<T: Numbers, const N: usize> Numbers for [T; N] {
    fn visit(&self, see: &mut dyn FnMut(f64)) {
        self.iter().for_each(|entry| entry.visit(see));
    }
}

impl<T: Numbers> Numbers for Option<T> {
    fn visit(&self, see: &mut dyn FnMut(f64)) {
        self.iter().for_each(|entry| entry.visit(see));
    }
}

/// The [`Range`] of a declaration.
macro_rules! range {
    ([$($range:tt)+]) => { $crate::parameter::range!(parameter_words!([$($range)+]), $($range)+) };
    ($words:expr, finite) => { $crate::parameter::range!($words, f64::NEG_INFINITY, false, f64::INFINITY) };
    ($words:expr, > $low:literal $(, <= $high:literal)?) => {
        $crate::parameter::range!($words, $low as f64, true, $crate::parameter::range!(end $($high)?))
    };
    ($words:expr, >= $low:literal $(, <= $high:literal)?) => {
        $crate::parameter::range!($words, $low as f64, false, $crate::parameter::range!(end $($high)?))
    };
    ($words:expr, $low:literal ..) => { $crate::parameter::range!($words, $low as f64, false, f64::INFINITY) };
    ($words:expr, $low:literal ..= $high:literal) => {
        $crate::parameter::range!($words, $low as f64, false, $high as f64)
    };
    ($words:expr, $low:expr, $open:literal, $high:expr) => {
        $crate::parameter::Range { low: $low, open: $open, high: $high, words: $words }
    };
    (end) => { f64::INFINITY };
    (end $high:literal) => { $high as f64 };
}

pub(crate) use range;

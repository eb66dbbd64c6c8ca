//! Ranges of numbers, as declarations write them, and their words.

use serde_json::Value;

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
    /// A range by its ends, without words.
    pub(crate) const fn between(low: f64, open: bool, high: f64) -> Self {
        Self { low, open, high, words: "" }
    }

    /// Whether a number is finite and in the range.
    pub fn holds(&self, value: f64) -> bool {
        let above = if self.open { value > self.low } else { value >= self.low };
        value.is_finite() && above && value <= self.high
    }

    /// Adds a fault for each number of a value that is not in the range.
    pub fn check(&self, value: &impl Numbers, at: &str, faults: &mut Vec<Fault>) {
        value.visit(&mut |number| {
            if !self.holds(number) {
                let message = format!("is {}, expected {}", short(number), self.words);
                faults.push(Fault { path: at.to_owned(), message });
            }
        });
    }

    /// The ends as keywords of a JSON schema.
    pub(super) fn keywords(&self) -> impl Iterator<Item = (String, Value)> + use<> {
        let ends = [(if self.open { "exclusiveMinimum" } else { "minimum" }, self.low), ("maximum", self.high)];
        ends.into_iter().filter(|(_, end)| end.is_finite()).map(|(keyword, end)| {
            // Ends of whole numbers have to be whole numbers.
            let value = if end.fract() == 0.0 { Value::from(end as i64) } else { Value::from(end) };
            (keyword.to_owned(), value)
        })
    }
}

/// A number as people write it: with an exponent where it would be long.
pub fn short(number: f64) -> String {
    let size = number.abs();
    if number == 0.0 || !number.is_finite() || (1e-4..1e7).contains(&size) {
        format!("{number}")
    } else {
        format!("{number:e}")
    }
}

/// A value outside its range, or not as usual.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    /// Path of the parameter.
    pub path: String,
    /// What it is and what was expected.
    pub message: String,
}

/// Values that consist of numbers.
pub trait Numbers {
    /// Shows every number.
    fn visit(&self, see: &mut dyn FnMut(f64));
}

macro_rules! numbers {
    ($($type:ty),+) => { $(
        impl Numbers for $type {
            fn visit(&self, see: &mut dyn FnMut(f64)) {
                see(*self as f64);
            }
        }
    )+ };
}

numbers!(f64, usize, u64);

impl<T: Numbers, const N: usize> Numbers for [T; N] {
    fn visit(&self, see: &mut dyn FnMut(f64)) {
        self.iter().for_each(|entry| entry.visit(see));
    }
}

impl<T: Numbers> Numbers for Vec<T> {
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
#[rustfmt::skip]
macro_rules! range {
    ($range:tt) => {
        $crate::parameter::Range { words: parameter_words!($range), ..$crate::parameter::range!(ends $range) }
    };
    (ends [finite]) => { $crate::parameter::Range::between(f64::NEG_INFINITY, false, f64::INFINITY) };
    (ends [> $low:literal]) => { $crate::parameter::Range::between($low as f64, true, f64::INFINITY) };
    (ends [>= $low:literal]) => { $crate::parameter::Range::between($low as f64, false, f64::INFINITY) };
    (ends [> $low:literal, <= $high:literal]) => { $crate::parameter::Range::between($low as f64, true, $high as f64) };
    (ends [$low:literal ..]) => { $crate::parameter::Range::between($low as f64, false, f64::INFINITY) };
    (ends [$low:literal ..= $high:literal]) => { $crate::parameter::Range::between($low as f64, false, $high as f64) };
}

pub(crate) use range;

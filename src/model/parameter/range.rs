//! Ranges of numbers in declarations, and their descriptions.

use serde_json::Value;

/// Finite numbers between two ends.
///
/// A declaration writes it `[finite]`, `[> 0]`, `[>= 1]`, `[> 0, <= 0.1]`, `[>= 0, < 1]` or, of whole numbers, `[1 ..]` and
/// `[0 ..= 1000]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// Whether the lower and the upper end themselves are outside.
    pub open: [bool; 2],
    /// Expected values, in words.
    pub words: &'static str,
}

impl Range {
    /// A range by its ends, without words.
    pub(crate) const fn between(low: f64, high: f64, open: [bool; 2]) -> Self {
        Self { low, high, open, words: "" }
    }

    /// Whether a number is finite and in the range.
    pub fn holds(&self, value: f64) -> bool {
        let [above, below] = self.open;
        let above = if above { value > self.low } else { value >= self.low };
        let below = if below { value < self.high } else { value <= self.high };
        value.is_finite() && above && below
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
        let [above, below] = self.open;
        let low = (if above { "exclusiveMinimum" } else { "minimum" }, self.low);
        let high = (if below { "exclusiveMaximum" } else { "maximum" }, self.high);
        [low, high].into_iter().filter(|(_, end)| end.is_finite()).map(|(keyword, end)| {
            // Ends of whole numbers have to be whole numbers.
            let value = if end.fract() == 0.0 { Value::from(end as i64) } else { Value::from(end) };
            (keyword.to_owned(), value)
        })
    }
}

/// A readable number: with an exponent if it would be long.
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
    /// The fault and the expected value.
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
    (ends [finite]) => { $crate::parameter::range!(f64::NEG_INFINITY, f64::INFINITY, false, false) };
    (ends [> $low:literal]) => { $crate::parameter::range!($low, f64::INFINITY, true, false) };
    (ends [>= $low:literal]) => { $crate::parameter::range!($low, f64::INFINITY, false, false) };
    (ends [> $low:literal, <= $high:literal]) => { $crate::parameter::range!($low, $high, true, false) };
    (ends [>= $low:literal, < $high:literal]) => { $crate::parameter::range!($low, $high, false, true) };
    (ends [$low:literal ..]) => { $crate::parameter::range!($low, f64::INFINITY, false, false) };
    (ends [$low:literal ..= $high:literal]) => { $crate::parameter::range!($low, $high, false, false) };
    ($low:expr, $high:expr, $above:literal, $below:literal) => {
        $crate::parameter::Range::between($low as f64, $high as f64, [$above, $below])
    };
}

pub(crate) use range;

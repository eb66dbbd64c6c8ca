//! Detects stiffnesses with few digits.
//!
//! The entries of a stiffness cancel: a machine on soft springs needs the last digits of its stiff elements. With six digits the lowest
//! frequencies are wrong by percents.

use std::collections::BTreeSet;

use sprs::CsMat;

/// Entries that are looked at.
const SAMPLE: usize = 2000;
/// Fewest different values for a conclusion.
const LEAST_VALUES: usize = 30;
/// Largest number of digits for a warning.
const FEW: usize = 8;
/// Fewest digits for a warning: round numbers of a handmade model have fewer.
const LEAST: usize = 4;
/// Least share of the values that has as many digits as any: the last one of nine in ten is not 0, but a model also has round values.
const FULL_SHARE: f64 = 0.2;
/// A conversion of units may have changed the last bits.
const SAME: f64 = 4.0 * f64::EPSILON;

/// Remark on matrices with few digits.
pub(super) fn remark(stiffness: &CsMat<f64>) -> Option<String> {
    let data = stiffness.data();
    let step = data.len().div_ceil(SAMPLE).max(1);
    let sample = data.iter().step_by(step).filter(|value| **value != 0.0);
    let values: BTreeSet<u64> = sample.map(|value| value.abs().to_bits()).collect();
    if values.len() < LEAST_VALUES {
        return None;
    }
    let values: Vec<f64> = values.into_iter().map(f64::from_bits).collect();
    const ADVICE: &str =
        "the lowest frequencies and static stiffnesses may be off by percents; export 15 digits or more";
    // Short decimal fractions are also short in binary.
    let single = |value: &f64| f64::from(*value as f32) == *value;
    let counts: Vec<Option<usize>> = values.iter().map(|value| digits(*value)).collect();
    let most = counts.iter().copied().try_fold(0, |most, count| Some(most.max(count?)));
    let Some(most) = most else {
        return values.iter().all(single).then(|| format!("the stiffness has single precision (7 digits): {ADVICE}"));
    };
    let full = counts.iter().filter(|count| **count == Some(most)).count();
    (most >= LEAST && full as f64 > FULL_SHARE * values.len() as f64)
        .then(|| format!("the entries of the stiffness have {most} significant digits: {ADVICE}"))
}

/// Significant digits of a value, where they are few.
fn digits(value: f64) -> Option<usize> {
    let short = |count: &usize| {
        let text = format!("{value:.*e}", *count - 1);
        text.parse::<f64>().is_ok_and(|short| (short - value).abs() <= SAME * value)
    };
    // A value that is short with some digits is short with more; hardly any value is.
    short(&FEW).then(|| (1..FEW).find(short).unwrap_or(FEW))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(value: impl Fn(f64) -> f64) -> CsMat<f64> {
        let entries = (0..100).map(|row| value(1e7 * (1.0 + libm::sin(f64::from(row))))).collect();
        CsMat::new((100, 100), (0..=100).collect(), (0..100).collect(), entries)
    }

    #[test]
    fn few_digits_are_counted() {
        let rounded = |count: usize| move |value: f64| format!("{value:.*e}", count - 1).parse().expect("a number");
        for count in 4..=8 {
            let found = remark(&matrix(rounded(count))).expect("few");
            assert!(found.starts_with(&format!("the entries of the stiffness have {count} significant")), "{found}");
            let scaled = remark(&matrix(|value| 1e-3 * rounded(count)(value))).expect("few");
            assert_eq!(found, scaled);
        }
        assert_eq!(remark(&matrix(rounded(10))), None);
        assert_eq!(remark(&matrix(|value| value)), None);
        assert!(remark(&matrix(|value| f64::from(value as f32))).expect("few").contains("single precision"));
        // Round numbers are not rounded ones.
        assert_eq!(remark(&matrix(|value| 1e5 * (value * 1e-6).round())), None);
    }
}

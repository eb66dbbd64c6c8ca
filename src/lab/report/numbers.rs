//! Numbers of cells, and numbers as text.

use decore_quantity::{Cell, Value};

/// A finite number.
pub(super) fn number(cell: &Cell<'_>) -> Option<f64> {
    cell.as_ref().and_then(Value::number).filter(|number| number.is_finite())
}

/// A number to four significant digits; with an exponent only where it would be long.
pub(super) fn significant(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    if !(1e-3..1e7).contains(&size) {
        return format!("{value:.3e}");
    }
    // Digits before the point after rounding to four: 9.9999 has two.
    let rounded: f64 = format!("{size:.3e}").parse().unwrap_or(size);
    let decimals = (3 - rounded.log10().floor() as i32).max(0) as usize;
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::significant;

    #[test]
    fn numbers_have_four_digits() {
        let cases = [
            (0.0, "0"),
            (12.3456, "12.35"),
            (9.99996, "10.00"),
            (-0.012_345, "-0.01235"),
            (123_456.0, "123456"),
            (2.5e-5, "2.500e-5"),
            (3.2e8, "3.200e8"),
            (f64::NAN, "NaN"),
        ];
        for (value, text) in cases {
            assert_eq!(significant(value), text);
        }
    }
}

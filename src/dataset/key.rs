//! Key of the values of a row's factors.

use decore_quantity::{Cell, Value};

/// Key of a row's values. Unequal values have equal keys with a probability of 2^-128.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ValuesKey([u64; 2]);

impl ValuesKey {
    /// Returns the key of these values in this order.
    pub fn of(values: &[Cell<'_>]) -> Self {
        let mut hasher = blake3::Hasher::new();
        for value in values {
            // A whole number is equal to the real one of the same size, and both zeros are.
            match value {
                None => hasher.update(b"-"),
                Some(Value::Text(text)) => {
                    hasher.update(b"t").update(&(text.len() as u64).to_le_bytes()).update(text.as_bytes())
                }
                Some(Value::Integer(number)) if (*number as f64) as i128 != i128::from(*number) => {
                    hasher.update(b"i").update(&number.to_le_bytes())
                }
                Some(number) => {
                    let number = number.number().unwrap_or(f64::NAN) + 0.0;
                    hasher.update(b"r").update(&number.to_bits().to_le_bytes())
                }
            };
        }
        let hash = hasher.finalize();
        let word =
            |from: usize| hash.as_bytes()[from..from + 8].iter().fold(0, |word, byte| word << 8 | u64::from(*byte));
        Self([word(0), word(8)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_values_have_equal_keys() {
        let real = |value: f64| ValuesKey::of(&[Some(Value::Real(value))]);
        let whole = |value: i64| ValuesKey::of(&[Some(Value::Integer(value))]);
        assert_eq!([real(0.0), real(3.0)], [real(-0.0), whole(3)]);
        assert_ne!(real(0.1 + 0.2), real(0.3), "to the last bit");
        assert_ne!(whole(i64::MAX), real(i64::MAX as f64), "a number that no real one is");
        assert_ne!(whole(i64::MAX), whole(i64::MAX - 1));
        let texts = |a: &'static str, b: &'static str| ValuesKey::of(&[Some(Value::Text(a)), Some(Value::Text(b))]);
        assert_ne!(texts("ab", "c"), texts("a", "bc"));
        assert_ne!(ValuesKey::of(&[None]), ValuesKey::of(&[Some(Value::Text(""))]));
    }
}

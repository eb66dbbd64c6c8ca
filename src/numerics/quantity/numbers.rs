//! The cells of a column of numbers, as plain vectors.

use super::value::{Cell, Kind, Value};

/// Numbers of a column and which of them are there.
#[derive(Debug, Clone, PartialEq)]
pub struct NumberColumn {
    /// The numbers; zero where there is none.
    pub values: Numbers,
    /// A bit for each number, the lowest of a byte first: whether it is there.
    pub present: Vec<u8>,
    /// How many are not there.
    pub missing: usize,
}

/// Numbers of one kind.
#[derive(Debug, Clone, PartialEq)]
pub enum Numbers {
    /// 64-bit floating point.
    Real(Vec<f64>),
    /// 64-bit unsigned.
    Count(Vec<u64>),
    /// 64-bit signed.
    Integer(Vec<i64>),
}

impl NumberColumn {
    /// An empty column; `None` if the kind is none of numbers.
    pub fn new(kind: Kind) -> Option<Self> {
        let values = match kind {
            Kind::Real => Numbers::Real(Vec::new()),
            Kind::Count => Numbers::Count(Vec::new()),
            Kind::Integer => Numbers::Integer(Vec::new()),
            Kind::Text | Kind::Category => return None,
        };
        Some(Self { values, present: Vec::new(), missing: 0 })
    }

    /// Appends a cell; one of another kind than the column's is none.
    pub fn push(&mut self, cell: Cell<'_>) {
        let (place, is_present) = match (&mut self.values, cell) {
            (Numbers::Real(values), Some(Value::Real(value))) => push(values, Some(value)),
            (Numbers::Count(values), Some(Value::Count(value))) => push(values, Some(value)),
            (Numbers::Integer(values), Some(Value::Integer(value))) => push(values, Some(value)),
            (Numbers::Real(values), _) => push(values, None),
            (Numbers::Count(values), _) => push(values, None),
            (Numbers::Integer(values), _) => push(values, None),
        };
        if place.is_multiple_of(8) {
            self.present.push(0);
        }
        if let Some(byte) = self.present.last_mut() {
            *byte |= u8::from(is_present) << (place % 8);
        }
        self.missing += usize::from(!is_present);
    }
}

/// Where the value is put, and whether there is one.
fn push<T: Default>(values: &mut Vec<T>, value: Option<T>) -> (usize, bool) {
    let is_present = value.is_some();
    values.push(value.unwrap_or_default());
    (values.len() - 1, is_present)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_of_another_kind_are_none() {
        let mut column = NumberColumn::new(Kind::Count).unwrap();
        let cells = [Some(Value::Count(7)), None, Some(Value::Real(1.0)), Some(Value::Text("8"))];
        cells.into_iter().chain([Some(Value::Count(9)); 6]).for_each(|cell| column.push(cell));
        assert_eq!(column.values, Numbers::Count(vec![7, 0, 0, 0, 9, 9, 9, 9, 9, 9]));
        assert_eq!((column.present, column.missing), (vec![0b1111_0001, 0b11], 3));
        assert_eq!(NumberColumn::new(Kind::Category), None);
    }
}

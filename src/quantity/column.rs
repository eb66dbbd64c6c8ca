//! The cells of a column, as plain vectors.

use indexmap::IndexSet;

use super::bytes::take_cell;
use super::value::{Cell, Kind, Value};

/// Cells of a column and which of them are there.
#[derive(Debug, Clone, PartialEq)]
pub struct CellColumn {
    /// The values; zero or empty where there is none.
    pub values: ColumnValues,
    /// A bit for each cell, the lowest of a byte first: whether it is there.
    pub present: Vec<u8>,
    /// Number of cells.
    pub count: usize,
    /// Number of missing values.
    pub missing: usize,
}

/// Values of one kind.
#[derive(Debug, Clone, PartialEq)]
pub enum ColumnValues {
    /// 64-bit floating point.
    Real(Vec<f64>),
    /// 64-bit unsigned.
    Count(Vec<u64>),
    /// 64-bit signed.
    Integer(Vec<i64>),
    /// Texts one behind the other.
    Text {
        /// All of them.
        text: String,
        /// End of each text in it.
        ends: Vec<usize>,
    },
    /// Texts of which there are few.
    Category {
        /// Which of the entries each of them is.
        keys: Vec<i32>,
        /// Different texts, in the order of their first appearance.
        entries: IndexSet<String>,
    },
}

impl CellColumn {
    /// An empty column.
    pub fn new(kind: Kind) -> Self {
        let values = match kind {
            Kind::Real => ColumnValues::Real(Vec::new()),
            Kind::Count => ColumnValues::Count(Vec::new()),
            Kind::Integer => ColumnValues::Integer(Vec::new()),
            Kind::Text => ColumnValues::Text { text: String::new(), ends: Vec::new() },
            Kind::Category => ColumnValues::Category { keys: Vec::new(), entries: IndexSet::new() },
        };
        Self { values, present: Vec::new(), count: 0, missing: 0 }
    }

    /// A column of these cells; one of another kind than the column's is none.
    pub fn of<'a>(kind: Kind, cells: impl IntoIterator<Item = Cell<'a>>) -> Self {
        let mut column = Self::new(kind);
        cells.into_iter().for_each(|cell| column.push(cell));
        column
    }

    /// A column of numbers, all of which are there; NaN stays NaN.
    pub fn reals(values: impl IntoIterator<Item = f64>) -> Self {
        Self::of(Kind::Real, values.into_iter().map(|value| Some(Value::Real(value))))
    }

    /// A column of whole numbers, all of which are there.
    pub fn integers(values: impl IntoIterator<Item = i64>) -> Self {
        Self::of(Kind::Integer, values.into_iter().map(|value| Some(Value::Integer(value))))
    }

    /// A column of free texts, all of which are there.
    pub fn texts<T: AsRef<str>>(values: impl IntoIterator<Item = T>) -> Self {
        let mut column = Self::new(Kind::Text);
        values.into_iter().for_each(|value| column.push(Some(Value::Text(value.as_ref()))));
        column
    }

    /// The kind of the values.
    pub fn kind(&self) -> Kind {
        match self.values {
            ColumnValues::Real(_) => Kind::Real,
            ColumnValues::Count(_) => Kind::Count,
            ColumnValues::Integer(_) => Kind::Integer,
            ColumnValues::Text { .. } => Kind::Text,
            ColumnValues::Category { .. } => Kind::Category,
        }
    }

    /// The cell of a row; none where there is none, and behind the last.
    pub fn cell(&self, row: usize) -> Cell<'_> {
        if self.present.get(row / 8)? >> (row % 8) & 1 == 0 {
            return None;
        }
        Some(match &self.values {
            ColumnValues::Real(values) => Value::Real(*values.get(row)?),
            ColumnValues::Count(values) => Value::Count(*values.get(row)?),
            ColumnValues::Integer(values) => Value::Integer(*values.get(row)?),
            ColumnValues::Text { text, ends } => {
                let start = row.checked_sub(1).map_or(Some(0), |before| ends.get(before).copied())?;
                Value::Text(text.get(start..*ends.get(row)?)?)
            }
            ColumnValues::Category { keys, entries } => Value::Text(entries.get_index(*keys.get(row)? as usize)?),
        })
    }

    /// The cells, row by row.
    pub fn cells(&self) -> impl Iterator<Item = Cell<'_>> {
        (0..self.count).map(|row| self.cell(row))
    }

    /// The cell of a row as a number; `None` where there is none, and for texts.
    pub fn number(&self, row: usize) -> Option<f64> {
        self.cell(row)?.number()
    }

    /// The cell of a row as a text that reads back the same; empty where there is none.
    pub fn text(&self, row: usize) -> String {
        self.cell(row).map_or(String::new(), |value| value.to_string())
    }

    /// Appends a cell; one of another kind than the column's is none.
    #[inline]
    pub fn push(&mut self, cell: Cell<'_>) {
        let is_present = match (&mut self.values, cell) {
            (ColumnValues::Real(values), Some(Value::Real(value))) => push(values, Some(value)),
            (ColumnValues::Count(values), Some(Value::Count(value))) => push(values, Some(value)),
            (ColumnValues::Integer(values), Some(Value::Integer(value))) => push(values, Some(value)),
            (ColumnValues::Text { text, ends }, Some(Value::Text(value))) => {
                text.push_str(value);
                push(ends, Some(text.len()))
            }
            (ColumnValues::Category { keys, entries }, Some(Value::Text(value))) => {
                let key = key(keys.last().copied(), entries, value);
                push(keys, Some(key))
            }
            (ColumnValues::Real(values), _) => push(values, None),
            (ColumnValues::Count(values), _) => push(values, None),
            (ColumnValues::Integer(values), _) => push(values, None),
            (ColumnValues::Text { text, ends }, _) => {
                ends.push(text.len());
                false
            }
            (ColumnValues::Category { keys, .. }, _) => push(keys, None),
        };
        let bit = self.count % 8;
        if bit == 0 {
            self.present.push(0);
        }
        if let Some(byte) = self.present.last_mut() {
            *byte |= u8::from(is_present) << bit;
        }
        self.count += 1;
        self.missing += usize::from(!is_present);
    }
}

/// Appends to each column a cell that is taken off the front of bytes, as [`put_cell`](super::put_cell) appended them; `None` if the
/// bytes do not begin with whole cells.
pub fn take_cells(bytes: &mut &[u8], columns: &mut [CellColumn]) -> Option<()> {
    for column in columns {
        column.push(take_cell(bytes)?);
    }
    Some(())
}

/// Whether there is a value.
fn push<T: Default>(values: &mut Vec<T>, value: Option<T>) -> bool {
    let is_present = value.is_some();
    values.push(value.unwrap_or_default());
    is_present
}

/// The key of a text, which most often is the one before; what is new becomes an entry. The cells of a part are far fewer than there
/// are keys.
fn key(last: Option<i32>, entries: &mut IndexSet<String>, text: &str) -> i32 {
    let is_last = |key: &i32| entries.get_index(*key as usize).is_some_and(|entry| entry == text);
    match last.filter(is_last) {
        Some(key) => key,
        None => {
            let index = entries.get_index_of(text).unwrap_or_else(|| entries.insert_full(text.to_owned()).0);
            index as i32
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::bytes::put_cell;
    use super::*;

    #[test]
    fn cells_of_another_kind_are_none() {
        let mut column = CellColumn::new(Kind::Count);
        let cells = [Some(Value::Count(7)), None, Some(Value::Real(1.0)), Some(Value::Text("8"))];
        cells.into_iter().chain([Some(Value::Count(9)); 6]).for_each(|cell| column.push(cell));
        assert_eq!(column.values, ColumnValues::Count(vec![7, 0, 0, 0, 9, 9, 9, 9, 9, 9]));
        assert_eq!((&column.present, column.count, column.missing), (&vec![0b1111_0001, 0b11], 10, 3));
        assert_eq!(CellColumn::of(column.kind(), column.cells()), column);
        assert_eq!((column.number(0), column.number(1), column.number(10)), (Some(7.0), None, None));
    }

    #[test]
    fn texts_stand_behind_each_other_and_categories_once() {
        let [mut text, mut category] = [Kind::Text, Kind::Category].map(CellColumn::new);
        for cell in ["left", "", "rechts", "left", "left"].map(|text| Some(Value::Text(text))).into_iter().chain([None])
        {
            text.push(cell);
            category.push(cell);
        }
        for column in [&text, &category] {
            assert_eq!(CellColumn::of(column.kind(), column.cells()), *column);
            assert_eq!([0, 1, 2, 5, 6].map(|row| column.text(row)), ["left", "", "rechts", "", ""]);
            assert_eq!((column.cell(1), column.cell(5), column.cell(6)), (Some(Value::Text("")), None, None));
        }
        let ends = vec![4, 4, 10, 14, 18, 18];
        assert_eq!(text.values, ColumnValues::Text { text: "leftrechtsleftleft".to_owned(), ends });
        let entries = ["left", "", "rechts"].map(str::to_owned).into_iter().collect();
        assert_eq!(category.values, ColumnValues::Category { keys: vec![0, 1, 2, 0, 0, 0], entries });
        assert_eq!((text.present, category.present), (vec![0b1_1111], vec![0b1_1111]));
    }

    #[test]
    fn cells_are_taken_off_bytes_row_by_row() {
        let mut bytes = Vec::new();
        let cells = [Some(Value::Real(-0.1)), None, Some(Value::Text("Gußteil"))];
        cells.iter().cycle().take(6).for_each(|cell| put_cell(&mut bytes, *cell));
        let empty = [Kind::Real, Kind::Integer, Kind::Text].map(CellColumn::new);
        let (mut columns, mut rest) = (empty.clone(), bytes.as_slice());
        assert_eq!((take_cells(&mut rest, &mut columns), take_cells(&mut rest, &mut columns)), (Some(()), Some(())));
        assert_eq!((rest.len(), columns[0].count, columns[1].missing), (0, 2, 2));
        assert_eq!(columns[0].values, ColumnValues::Real(vec![-0.1, -0.1]));
        for length in 0..bytes.len() / 2 {
            assert_eq!(take_cells(&mut &bytes[..length], &mut empty.clone()), None, "{length} bytes");
        }
    }
}

//! Matches the rows of two datasets.

use std::cmp::Ordering;
use std::collections::HashMap;

use super::error::ComparisonError;
use super::result::StatusDifference;
use decore_dataset::{ColumnDescription, ColumnGroup, DatasetError, DatasetReader, RowRecord, TableName, ValuesKey};
use decore_model::run::{RowOutcome, RowStatus};
use decore_quantity::Value;

/// The rows of two datasets, in the order of their tables.
pub(super) struct Matching<'r> {
    /// The datasets.
    pub readers: [&'r DatasetReader; 2],
    /// The factors, as named in A's study.
    pub factors: Vec<String>,
    rows: [DatasetRows; 2],
    /// Of each row of A, the place of its match in B.
    partner: Vec<Option<usize>>,
    /// Whether rows of B are the match of one of A.
    taken: Vec<bool>,
    statuses: Texts,
    /// Number of the status of a row that is done.
    done: usize,
}

/// Two rows that match, by their places in the tables.
#[derive(Clone, Copy)]
pub(super) struct MatchedRows {
    /// Place in A.
    pub a: usize,
    /// Place in B.
    pub b: usize,
}

/// The rows of one dataset.
struct DatasetRows {
    index: Vec<u64>,
    status: Vec<usize>,
    keys: Vec<ValuesKey>,
}

/// Texts that occur, by number: there are few of them.
#[derive(Default)]
pub(super) struct Texts {
    numbers: HashMap<String, usize>,
    texts: Vec<String>,
}

impl Texts {
    /// The number of a text.
    pub fn number(&mut self, text: &str) -> usize {
        if let Some(number) = self.numbers.get(text) {
            return *number;
        }
        self.texts.push(text.to_owned());
        self.numbers.insert(text.to_owned(), self.texts.len() - 1);
        self.texts.len() - 1
    }

    /// The text of a number.
    pub fn text(&self, number: usize) -> &str {
        self.texts.get(number).map_or("", String::as_str)
    }
}

impl<'r> Matching<'r> {
    /// Reads the factors of both datasets and matches their rows.
    ///
    /// # Errors
    /// Factors that are not the same; those of reading.
    pub fn of(a: &'r DatasetReader, b: &'r DatasetReader) -> Result<Self, ComparisonError> {
        let columns = same_factors([a, b])?;
        let mut statuses = Texts::default();
        // So that its number is known.
        let done = statuses.number(RowStatus::Done.name());
        let rows = [
            DatasetRows::read(a, columns.iter().map(|[in_a, _]| *in_a), &mut statuses)?,
            DatasetRows::read(b, columns.iter().map(|[_, in_b]| *in_b), &mut statuses)?,
        ];
        let factors = columns.iter().map(|[in_a, _]| in_a.subject.clone().unwrap_or_else(|| in_a.name.clone()));
        let mut matching = Self {
            readers: [a, b],
            factors: factors.collect(),
            partner: vec![None; rows[0].index.len()],
            taken: vec![false; rows[1].index.len()],
            rows,
            statuses,
            done,
        };
        matching.join();
        Ok(matching)
    }

    /// Walks over both in the order of their keys; equal ones belong together in the order of their rows.
    fn join(&mut self) {
        let ordered = |rows: &DatasetRows| {
            let mut order: Vec<usize> = (0..rows.keys.len()).collect();
            // Stable: equal keys stay in the order of the rows.
            order.sort_by_key(|place| rows.keys[*place]);
            order
        };
        let orders = [ordered(&self.rows[0]), ordered(&self.rows[1])];
        let (mut left, mut right) = (orders[0].iter().peekable(), orders[1].iter().peekable());
        while let (Some(&&a), Some(&&b)) = (left.peek(), right.peek()) {
            match self.rows[0].keys[a].cmp(&self.rows[1].keys[b]) {
                Ordering::Less => _ = left.next(),
                Ordering::Greater => _ = right.next(),
                Ordering::Equal => {
                    (self.partner[a], self.taken[b]) = (Some(b), true);
                    left.next();
                    right.next();
                }
            }
        }
        // Not needed any more.
        self.rows.iter_mut().for_each(|rows| rows.keys = Vec::new());
    }

    /// The rows that match.
    pub fn pairs(&self) -> impl Iterator<Item = MatchedRows> {
        self.partner.iter().enumerate().filter_map(|(a, b)| Some(MatchedRows { a, b: (*b)? }))
    }

    /// The match of a row of A, where both are done.
    pub fn done(&self, a: usize) -> Option<MatchedRows> {
        let pair = MatchedRows { a, b: (*self.partner.get(a)?)? };
        let [in_a, in_b] = &self.rows;
        (in_a.status.get(a) == Some(&self.done) && in_b.status.get(pair.b) == Some(&self.done)).then_some(pair)
    }

    /// The indices of two rows in their designs.
    pub fn indices(&self, pair: MatchedRows) -> [u64; 2] {
        [self.rows[0].index[pair.a], self.rows[1].index[pair.b]]
    }

    /// The index of a row in its design, by its place in A (0) or B (1).
    pub fn row_at(&self, side: usize, place: usize) -> Option<u64> {
        self.rows.get(side)?.index.get(place).copied()
    }

    /// Number of rows of each dataset.
    pub fn counts(&self) -> [usize; 2] {
        [self.partner.len(), self.taken.len()]
    }

    /// Rows of A without a match.
    pub fn only_in_a(&self) -> impl Iterator<Item = u64> {
        self.rows[0].index.iter().zip(&self.partner).filter(|(_, partner)| partner.is_none()).map(|(row, _)| *row)
    }

    /// Rows of B without a match.
    pub fn only_in_b(&self) -> impl Iterator<Item = u64> {
        self.rows[1].index.iter().zip(&self.taken).filter(|(_, taken)| !**taken).map(|(row, _)| *row)
    }

    /// Matched rows that ended differently.
    pub fn statuses(&self) -> impl Iterator<Item = StatusDifference> {
        self.pairs().filter_map(|pair| {
            let [a, b] = [self.rows[0].status[pair.a], self.rows[1].status[pair.b]];
            let [row_a, row_b] = self.indices(pair);
            let text = |number: usize| self.statuses.text(number).to_owned();
            (a != b).then(|| StatusDifference { row_a, row_b, status_a: text(a), status_b: text(b) })
        })
    }
}

impl DatasetRows {
    fn read<'c>(
        reader: &DatasetReader,
        factors: impl Iterator<Item = &'c ColumnDescription>,
        statuses: &mut Texts,
    ) -> Result<Self, DatasetError> {
        let always = [RowRecord::row.name, RowOutcome::status.name];
        let names: Vec<&str> = always.into_iter().chain(factors.map(|column| column.name.as_str())).collect();
        let mut rows = Self { index: Vec::new(), status: Vec::new(), keys: Vec::new() };
        reader.visit(TableName::Runs, &names, |cells| {
            if let [Some(Value::Count(row)), Some(Value::Text(status)), factors @ ..] = cells {
                rows.index.push(*row);
                rows.status.push(statuses.number(status));
                rows.keys.push(ValuesKey::of(factors));
            }
        })?;
        Ok(rows)
    }
}

/// The columns of the factors in A and in B.
fn same_factors<'r>([a, b]: [&'r DatasetReader; 2]) -> Result<Vec<[&'r ColumnDescription; 2]>, ComparisonError> {
    let factors = |reader: &'r DatasetReader| {
        reader.columns(TableName::Runs).iter().filter(|column| column.group == ColumnGroup::Factor)
    };
    let find = |reader: &'r DatasetReader, name: &str| factors(reader).find(|column| column.name == name);
    let mut differences = Vec::new();
    let mut found = Vec::new();
    for column in factors(a) {
        match find(b, &column.name) {
            Some(other) if other.unit == column.unit => found.push([column, other]),
            Some(other) => differences.push(format!("{} is in `{}` and in `{}`", column.name, column.unit, other.unit)),
            None => differences.push(format!("{} has {} alone", a.folder().display(), column.name)),
        }
    }
    let only_in_b = factors(b).filter(|column| find(a, &column.name).is_none());
    differences.extend(only_in_b.map(|column| format!("{} has {} alone", b.folder().display(), column.name)));
    if differences.is_empty() { Ok(found) } else { Err(ComparisonError::Factors { differences }) }
}

//! Contents of an OUTPUT4 file, and the selection of its matrices.

use crate::structure::error::StructureError;
use crate::structure::import::triplets::{MOST_ROWS, Storage, Triplets};

/// Matrices that an error lists.
const MOST_LISTED: usize = 40;
const TYPES: [&str; 4] = ["real single", "real double", "complex single", "complex double"];

/// Header of a matrix.
#[derive(Debug, Clone)]
pub(super) struct Header {
    pub name: String,
    pub rows: usize,
    pub columns: usize,
    /// Strings of sparse columns have a header of two numbers.
    pub big: bool,
    form: i64,
    /// 1 real single, 2 real double, 3 complex single, 4 complex double.
    kind: usize,
}

impl Header {
    /// From columns, rows, form and type as the file states them.
    pub fn new([columns, rows, form, kind]: [i64; 4], name: &str) -> Result<Self, String> {
        let kind = match kind {
            1..=4 => kind as usize,
            other => return Err(format!("type {other} of a matrix: expected 1 to 4")),
        };
        let size = |value: u64| usize::try_from(value).ok().filter(|value| *value <= MOST_ROWS);
        let (Some(columns), Some(count)) = (u64::try_from(columns).ok().and_then(size), size(rows.unsigned_abs()))
        else {
            let reason = format!("a matrix of {rows} rows and {columns} columns: expected at most {MOST_ROWS}");
            return Err(reason);
        };
        // Rows of packed string headers have 16 bits.
        let big = rows < 0 || count > 65535;
        Ok(Self { name: name.trim().to_owned(), rows: count, columns, big, form, kind })
    }

    /// Words that a number counts for: 1 in single, 2 in double precision.
    pub fn words(&self) -> usize {
        if self.kind % 2 == 1 { 1 } else { 2 }
    }

    /// Row (from 0) of a value of a column, if it is one.
    pub fn row(&self, first: i64, offset: usize) -> Option<u32> {
        let row = usize::try_from(first.checked_sub(1)?).ok()?.checked_add(offset)?;
        (row < self.rows).then_some(row as u32)
    }

    /// Entries by the form: a square matrix has all, a symmetric one both triangles, in some files one.
    pub fn storage(&self) -> Option<Storage> {
        (self.form == 1).then_some(Storage::Both)
    }

    /// Returns the reason why this cannot be a stiffness, mass or damping matrix.
    fn refusal(&self) -> Option<String> {
        let Self { name, rows, columns, .. } = self;
        match (self.kind, self.form) {
            (3 | 4, _) => Some(format!("{name} is a complex matrix: expected a real one")),
            _ if rows != columns || *rows == 0 => {
                Some(format!("{name} has {rows} rows and {columns} columns: expected a square matrix"))
            }
            (_, 4 | 5) => {
                Some(format!("{name} is a triangular factor (form {}): expected a symmetric matrix", self.form))
            }
            _ => None,
        }
    }

    fn describe(&self) -> String {
        let kind = TYPES.get(self.kind - 1).copied().unwrap_or_default();
        format!("{} ({} x {}, {kind})", self.name, self.rows, self.columns)
    }
}

/// The matrices met so far, and the wanted one.
pub(super) struct Contents<'a> {
    name: &'a str,
    /// Number among several matrices of this name, from 1.
    number: Option<usize>,
    met: Vec<Header>,
    found: Option<(Header, Triplets)>,
    refused: Option<String>,
}

impl<'a> Contents<'a> {
    /// `wanted`: a name, or a name and which of them, `MAA#2`.
    pub fn new(wanted: &'a str) -> Self {
        let numbered = wanted.rsplit_once('#').and_then(|(name, number)| Some((name, number.parse().ok()?)));
        let (name, number) = numbered.map_or((wanted, None), |(name, number): (&str, usize)| (name, Some(number)));
        Self { name, number, met: Vec::new(), found: None, refused: None }
    }

    fn named(&self) -> impl Iterator<Item = &Header> {
        self.met.iter().filter(|header| header.name.eq_ignore_ascii_case(self.name))
    }

    /// Notes a matrix; `true` if its entries are wanted. `place` names where its header stands.
    pub fn meets(&mut self, header: &Header, place: &str) -> bool {
        self.met.push(header.clone());
        let number = self.named().count();
        let wanted = header.name.eq_ignore_ascii_case(self.name) && number == self.number.unwrap_or(1);
        let refusal = header.refusal().filter(|_| wanted);
        let readable = refusal.is_none();
        if let Some(reason) = refusal {
            self.refused = Some(format!("{place}: {reason}"));
        }
        wanted && readable
    }

    /// Takes the entries of the wanted matrix.
    pub fn take(&mut self, header: &Header, entries: Triplets) {
        self.found = Some((header.clone(), entries));
    }

    /// Header and entries of the wanted matrix, after the whole file has been seen.
    pub fn into_matrix(self, file: &str) -> Result<(Header, Triplets), StructureError> {
        let count = self.named().count();
        let name = self.name;
        let reason = match (self.refused.as_ref(), count, self.number) {
            (_, 2.., None) => format!("{count} matrices {name}; name one of them, {name}#1 to {name}#{count}"),
            (Some(reason), ..) => reason.clone(),
            (None, 1.., Some(number)) if self.found.is_none() => {
                format!("no matrix {name}#{number}: there are {count} of that name")
            }
            _ => format!("no matrix {name}"),
        };
        let list = self.list();
        self.found.filter(|_| count == 1 || self.number.is_some()).ok_or_else(|| StructureError::Matrix {
            file: file.to_owned(),
            reason: format!("{reason}; the file holds {list}"),
        })
    }

    fn list(&self) -> String {
        let mut words: Vec<(String, usize)> = Vec::new();
        for text in self.met.iter().map(Header::describe) {
            match words.last_mut() {
                Some((last, times)) if *last == text => *times += 1,
                _ => words.push((text, 1)),
            }
        }
        let rest = words.len().saturating_sub(MOST_LISTED);
        words.truncate(MOST_LISTED);
        let word = |(text, times): (String, usize)| if times == 1 { text } else { format!("{times} times {text}") };
        let mut list: Vec<String> = words.into_iter().map(word).collect();
        if rest > 0 {
            list.push(format!("{rest} more"));
        }
        if list.is_empty() { "no matrix".to_owned() } else { list.join(", ") }
    }
}

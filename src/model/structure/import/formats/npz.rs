//! Sparse matrices of `scipy.sparse.save_npz` (`.npz`): CSR, CSC or COO, packed or not.

use std::collections::BTreeMap;

use crate::structure::error::StructureError;
use crate::structure::import::archive::{Numbers, arrays};
use crate::structure::import::entry::{Format, Given, Imported};
use crate::structure::import::triplets::{MOST_ROWS, Storage, Triplets};

pub(super) const FORMAT: Format = Format { endings: &["npz"], read, forms: &[] };

fn read(given: &Given) -> Result<Imported, StructureError> {
    let Given { file, bytes, listed, .. } = *given;
    let matrix = Sparse { file, arrays: arrays(file, bytes)? };
    let kind = matrix.kind()?;
    let order = matrix.order()?;
    let entries = match kind.as_str() {
        "csr" => matrix.compressed(order, false)?,
        "csc" => matrix.compressed(order, true)?,
        "coo" => matrix.pairs(order)?,
        _ => {
            let reason = format!(
                "a matrix in the form \"{kind}\": expected csr, csc or coo; write it with scipy.sparse.save_npz('K.npz', K.tocsr())"
            );
            return Err(matrix.fault(reason));
        }
    };
    entries.justify(file, order, listed)?;
    entries.assemble(file, order, storage(&entries)).map(Imported::Rows)
}

/// One triangle where all entries off the diagonal lie on one side of it. Of a matrix that was assembled, rounding may leave an entry on one
/// side and none on the other.
fn storage(entries: &Triplets) -> Storage {
    let mut beside = entries.iter().filter(|(row, column, value)| row != column && *value != 0.0);
    let Some((row, column, _)) = beside.next() else { return Storage::Both };
    match beside.all(|(other, next, _)| (other > next) == (row > column)) {
        true => Storage::OneTriangle,
        false => Storage::Both,
    }
}

/// The arrays of a sparse matrix.
struct Sparse<'a> {
    file: &'a str,
    arrays: BTreeMap<String, Numbers>,
}

impl Sparse<'_> {
    fn fault(&self, reason: impl Into<String>) -> StructureError {
        StructureError::Matrix { file: self.file.to_owned(), reason: reason.into() }
    }

    fn array(&self, name: &str) -> Result<&Numbers, StructureError> {
        self.arrays.get(name).ok_or_else(|| {
            let found: Vec<&str> = self.arrays.keys().map(String::as_str).collect();
            self.fault(format!(
                "no array \"{name}\", found {}: expected a sparse matrix of scipy.sparse.save_npz",
                found.join(", ")
            ))
        })
    }

    fn kind(&self) -> Result<String, StructureError> {
        match &self.array("format")? {
            Numbers::Text(text) => Ok(text.clone()),
            _ => Err(self.fault("array \"format\": expected a text as csr")),
        }
    }

    fn whole(&self, name: &str) -> Result<&[i64], StructureError> {
        match &self.array(name)? {
            Numbers::Whole(values) => Ok(values),
            _ => Err(self.fault(format!("array \"{name}\": expected whole numbers"))),
        }
    }

    /// Number of rows, which equals the number of columns.
    fn order(&self) -> Result<usize, StructureError> {
        let shape = self.whole("shape")?;
        let order = match shape {
            [rows, columns] if rows == columns => usize::try_from(*rows).ok(),
            _ => None,
        };
        order
            .filter(|order| (1..=MOST_ROWS).contains(order))
            .ok_or_else(|| self.fault(format!("expected a square matrix, found the shape {shape:?}")))
    }

    fn values(&self) -> Result<Vec<f64>, StructureError> {
        let values = match &self.array("data")? {
            Numbers::Real(values) => values.clone(),
            Numbers::Whole(values) => values.iter().map(|value| *value as f64).collect(),
            Numbers::Text(_) => return Err(self.fault("array \"data\": expected numbers")),
        };
        match values.iter().find(|value| !value.is_finite()) {
            Some(value) => Err(self.fault(format!("an entry is {value}: expected finite numbers"))),
            None => Ok(values),
        }
    }

    /// A row or column as an index.
    fn index(&self, name: &str, value: i64, order: usize) -> Result<u32, StructureError> {
        let index = usize::try_from(value).ok().filter(|index| *index < order);
        index.map(|index| index as u32).ok_or_else(|| {
            self.fault(format!("array \"{name}\": expected indices from 0 to {}, found {value}", order - 1))
        })
    }

    /// Entries of CSR or CSC.
    fn compressed(&self, order: usize, by_columns: bool) -> Result<Triplets, StructureError> {
        let (indices, pointers, values) = (self.whole("indices")?, self.whole("indptr")?, self.values()?);
        let rising = pointers.first() == Some(&0) && pointers.is_sorted();
        if pointers.len() != order + 1 || !rising || pointers.last() != Some(&(indices.len() as i64)) {
            return Err(self.fault(format!(
                "array \"indptr\": expected {} numbers that rise from 0 to {}, the number of indices",
                order + 1,
                indices.len()
            )));
        }
        self.require_as_many(indices.len(), values.len())?;
        let mut out = Triplets::default();
        for (outer, ends) in pointers.windows(2).enumerate() {
            for at in ends[0] as usize..ends[1] as usize {
                let inner = self.index("indices", indices[at], order)?;
                let (row, column) = if by_columns { (inner, outer as u32) } else { (outer as u32, inner) };
                out.push(row, column, values[at]);
            }
        }
        Ok(out)
    }

    /// Entries of COO.
    fn pairs(&self, order: usize) -> Result<Triplets, StructureError> {
        // SciPy 1.13 and later may write `coords` of two rows instead.
        let (rows, columns) = match self.arrays.contains_key("row") {
            true => (self.whole("row")?, self.whole("col")?),
            false => self.whole("coords")?.split_at(self.whole("coords")?.len() / 2),
        };
        let values = self.values()?;
        self.require_as_many(rows.len(), values.len())?;
        self.require_as_many(columns.len(), values.len())?;
        let mut out = Triplets::default();
        for ((row, column), value) in rows.iter().zip(columns).zip(values) {
            out.push(self.index("row", *row, order)?, self.index("col", *column, order)?, value);
        }
        Ok(out)
    }

    fn require_as_many(&self, indices: usize, values: usize) -> Result<(), StructureError> {
        if indices == values {
            return Ok(());
        }
        Err(self.fault(format!("{indices} indices, but {values} values: expected as many")))
    }
}

//! Entries of a symmetric matrix in the order of a file, and the matrix from them.

use sprs::CsMat;

use crate::structure::error::StructureError;

/// Largest difference of `a_ij` and `a_ji` of a general matrix, relative to the largest of `|a_ij|`, `|a_ji|` and
/// `sqrt(|a_ii a_jj|)`. Exporters that write ten or more digits stay well below it.
const ASYMMETRY_TOLERANCE: f64 = 1e-9;

/// Rows are numbered in 32 bits.
pub(super) const MOST_ROWS: usize = u32::MAX as usize - 1;
/// A matrix may have so many rows without regard to its entries, and so many per entry beyond: memory goes with the size of
/// a file, not with a number in it. A lumped mass on three of six directions has one entry for every second row.
const FREE_ROWS: usize = 100_000;
const ROWS_PER_ENTRY: usize = 8;

/// Stored entries of a list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Storage {
    /// One triangle with the diagonal; the other is mirrored.
    OneTriangle,
    /// Both triangles; the mean of mirrored entries is taken.
    Both,
}

/// Row, column (counted from 0) and value of entries.
#[derive(Debug, Clone, Default)]
pub(super) struct Triplets {
    pub rows: Vec<u32>,
    pub columns: Vec<u32>,
    pub values: Vec<f64>,
}

impl Triplets {
    pub fn push(&mut self, row: u32, column: u32, value: f64) {
        self.rows.push(row);
        self.columns.push(column);
        self.values.push(value);
    }

    /// Finds the stored entries of the list: every pair off the diagonal once, or every one twice; explicit zeros do not count. `None` for
    /// a mixture.
    pub fn storage(&self) -> Option<Storage> {
        let mut pairs: Vec<(u32, u32, bool)> = Vec::new();
        for (row, column, _) in self.iter().filter(|(row, column, value)| row != column && *value != 0.0) {
            pairs.push((row.min(column) as u32, row.max(column) as u32, row > column));
        }
        pairs.sort_unstable();
        pairs.dedup();
        let distinct = pairs.chunk_by(|p, q| p.0 == q.0 && p.1 == q.1).count();
        match pairs.len() {
            count if count == distinct => Some(Storage::OneTriangle),
            count if count == 2 * distinct => Some(Storage::Both),
            _ => None,
        }
    }

    /// Whether the entries justify an order that only a number in the file states, or a list of rows does.
    pub fn justify(&self, file: &str, order: usize, listed: Option<usize>) -> Result<(), StructureError> {
        let entries = self.values.len();
        if listed == Some(order) || order <= FREE_ROWS.max(entries.saturating_mul(ROWS_PER_ENTRY)) {
            return Ok(());
        }
        let reason = format!(
            "{order} rows, but only {entries} entries: beyond {FREE_ROWS} rows one entry per {ROWS_PER_ENTRY} rows is the least; is the size wrong? If the other rows really are empty, name a dof_file that lists all of them"
        );
        Err(StructureError::Matrix { file: file.to_owned(), reason })
    }

    /// As [`Triplets::assemble`], with the storage that the entries show.
    pub fn assemble_as_found(&self, file: &str, order: usize) -> Result<CsMat<f64>, StructureError> {
        let storage = self.storage().ok_or_else(|| StructureError::Matrix {
            file: file.to_owned(),
            reason:
                "some pairs of entries (i, j) and (j, i) are given twice, others once: expected one triangle or both"
                    .to_owned(),
        })?;
        self.assemble(file, order, storage)
    }

    /// Row, column and value of every entry.
    pub fn iter(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        let places = self.rows.iter().zip(&self.columns);
        places.zip(&self.values).map(|((row, column), value)| (*row as usize, *column as usize, *value))
    }

    /// The matrix with both triangles. Entries given several times are summed in the order of the file, as finite element
    /// exporters write unassembled contributions.
    pub fn assemble(&self, file: &str, order: usize, storage: Storage) -> Result<CsMat<f64>, StructureError> {
        let mirrored = |row: usize, column: usize| storage == Storage::OneTriangle && row != column;
        let mut pointers = vec![0_usize; order + 1];
        for (row, column, _) in self.iter() {
            pointers[row + 1] += 1;
            pointers[column + 1] += usize::from(mirrored(row, column));
        }
        for row in 0..order {
            pointers[row + 1] += pointers[row];
        }
        let total = pointers[order];
        let (mut indices, mut data) = (vec![0_usize; total], vec![0.0; total]);
        let mut next = pointers.clone();
        let mut put = |row: usize, column: usize, value: f64| {
            indices[next[row]] = column;
            data[next[row]] = value;
            next[row] += 1;
        };
        for (row, column, value) in self.iter() {
            put(row, column, value);
            if mirrored(row, column) {
                put(column, row, value);
            }
        }
        let matrix = compress(file, &pointers, indices, data)?;
        if storage == Storage::OneTriangle { Ok(matrix) } else { symmetrise(file, matrix) }
    }
}

/// Sorts every row and sums repeated entries.
fn compress(
    file: &str,
    pointers: &[usize],
    mut indices: Vec<usize>,
    mut data: Vec<f64>,
) -> Result<CsMat<f64>, StructureError> {
    let order = pointers.len() - 1;
    let mut kept = vec![0];
    let mut write = 0;
    let mut row: Vec<(usize, f64)> = Vec::new();
    for ends in pointers.windows(2) {
        row.clear();
        row.extend(indices[ends[0]..ends[1]].iter().copied().zip(data[ends[0]..ends[1]].iter().copied()));
        row.sort_by_key(|(column, _)| *column);
        let first = write;
        for &(column, value) in &row {
            if write > first && indices[write - 1] == column {
                data[write - 1] += value;
            } else {
                indices[write] = column;
                data[write] = value;
                write += 1;
            }
        }
        kept.push(write);
    }
    indices.truncate(write);
    data.truncate(write);
    CsMat::try_new((order, order), kept, indices, data)
        .map_err(|(.., error)| StructureError::Matrix { file: file.to_owned(), reason: error.to_string() })
}

/// Calls `see(row, column, a_ij, a_ji)` for every pair below or above the diagonal of which one is stored.
fn pairs(matrix: &CsMat<f64>, mut see: impl FnMut(usize, usize, f64, f64)) {
    let (pointers, indices, data) = (matrix.proper_indptr(), matrix.indices(), matrix.data());
    // Rows are visited in order, so the lower entries of a row are met in the order in which they are stored.
    let mut next: Vec<usize> = pointers[..matrix.rows()].to_vec();
    for row in 0..matrix.rows() {
        let end = pointers[row + 1];
        while next[row] < end && indices[next[row]] < row {
            see(indices[next[row]], row, 0.0, data[next[row]]);
            next[row] += 1;
        }
        for at in next[row]..end {
            let column = indices[at];
            if column <= row {
                continue;
            }
            let cursor = &mut next[column];
            while *cursor < pointers[column + 1] && indices[*cursor] < row {
                see(indices[*cursor], column, 0.0, data[*cursor]);
                *cursor += 1;
            }
            let mirrored = if *cursor < pointers[column + 1] && indices[*cursor] == row {
                *cursor += 1;
                data[*cursor - 1]
            } else {
                0.0
            };
            see(row, column, data[at], mirrored);
        }
    }
}

/// Row and column of the first pair that differs by more than the tolerance.
fn asymmetric_pair(matrix: &CsMat<f64>) -> Option<(usize, usize)> {
    let diagonal: Vec<f64> = (0..matrix.rows()).map(|row| matrix.get(row, row).copied().unwrap_or(0.0)).collect();
    let mut found: Option<(usize, usize)> = None;
    pairs(matrix, |row, column, value, mirrored| {
        let scale = value.abs().max(mirrored.abs()).max((diagonal[row] * diagonal[column]).abs().sqrt());
        if (value - mirrored).abs() > ASYMMETRY_TOLERANCE * scale {
            let pair = (row, column);
            found = Some(found.map_or(pair, |other| other.min(pair)));
        }
    });
    found
}

/// The matrix with the mean of mirrored entries, where they are not equal already.
pub(in crate::structure) fn symmetric(file: &str, matrix: CsMat<f64>) -> Result<CsMat<f64>, StructureError> {
    let mut equal = true;
    pairs(&matrix, |_, _, value, mirrored| equal &= value == mirrored);
    // A pair of which one is not stored has to be completed even where the other is 0.
    let stored = matrix.iter().filter(|(_, (row, column))| row < column).count();
    let balanced = matrix.iter().filter(|(_, (row, column))| row > column).count() == stored;
    if equal && balanced { Ok(matrix) } else { symmetrise(file, matrix) }
}

/// The triangle that has all entries off the diagonal, where there are several of them.
fn only_triangle(matrix: &CsMat<f64>) -> Option<&'static str> {
    let count = |lower: bool| {
        let entries =
            matrix.iter().filter(|(value, (row, column))| **value != 0.0 && row != column && (row > column) == lower);
        entries.count()
    };
    match (count(true), count(false)) {
        (2.., 0) => Some("lower"),
        (0, 2..) => Some("upper"),
        _ => None,
    }
}

fn symmetrise(file: &str, matrix: CsMat<f64>) -> Result<CsMat<f64>, StructureError> {
    if let Some((row, column)) = asymmetric_pair(&matrix) {
        let value = |row, column| matrix.get(row, column).copied().unwrap_or(0.0);
        let (i, j) = (row + 1, column + 1);
        if let Some(triangle) = only_triangle(&matrix) {
            let reason = format!(
                "only the {triangle} triangle exists, but the header declares both: write `symmetric` in the header, or \
                 write both"
            );
            return Err(StructureError::Matrix { file: file.to_owned(), reason });
        }
        return Err(StructureError::Matrix {
            file: file.to_owned(),
            reason: format!(
                "the matrix is not symmetric: entry ({i}, {j}) is {:e}, entry ({j}, {i}) is {:e}",
                value(row, column),
                value(column, row)
            ),
        });
    }
    let mut upper = Triplets::default();
    for row in 0..matrix.rows() {
        if let Some(value) = matrix.get(row, row) {
            upper.push(row as u32, row as u32, *value);
        }
    }
    pairs(&matrix, |row, column, value, mirrored| upper.push(row as u32, column as u32, 0.5 * (value + mirrored)));
    upper.assemble(file, matrix.rows(), Storage::OneTriangle)
}

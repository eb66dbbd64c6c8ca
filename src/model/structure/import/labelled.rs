//! Matrices with entries by node and direction instead of row.

use std::collections::{BTreeSet, HashMap};

use sprs::CsMat;

use super::rows::Nodes;
use super::triplets::{Storage, Triplets};
use crate::structure::error::StructureError;
use crate::structure::label::DofLabel;

/// Entries with labels, in the order of a file; a label stands for its place in `labels`.
#[derive(Debug, Clone, Default)]
pub(super) struct LabelledMatrix {
    labels: Vec<DofLabel>,
    known: HashMap<DofLabel, u32>,
    entries: Triplets,
    /// Columns that the file begins, as places in `labels`; none if its format has only entries.
    columns: Vec<u32>,
    /// Stored entries according to the file; none: as the entries show.
    pub storage: Option<Storage>,
    /// Number of columns according to the file, including zero ones.
    pub stated_columns: Option<usize>,
    /// Statements of the file about its nodes.
    pub nodes: Nodes,
}

impl LabelledMatrix {
    fn place(&mut self, label: DofLabel) -> u32 {
        *self.known.entry(label).or_insert_with(|| {
            self.labels.push(label);
            (self.labels.len() - 1) as u32
        })
    }

    /// Adds an entry.
    pub fn push(&mut self, row: DofLabel, column: DofLabel, value: f64) {
        let (row, column) = (self.place(row), self.place(column));
        self.entries.push(row, column, value);
    }

    /// Begins a column.
    pub fn begin_column(&mut self, label: DofLabel) {
        let place = self.place(label);
        self.columns.push(place);
    }

    /// Columns in the order of the file.
    pub fn columns(&self) -> impl DoubleEndedIterator<Item = DofLabel> + '_ {
        self.columns.iter().map(|place| self.labels[*place as usize])
    }

    /// A label that is coupled to another, but has nothing on the diagonal: no mass or stiffness is like that.
    pub fn without_diagonal(&self) -> Option<DofLabel> {
        let entries = || self.entries.iter().filter(|(.., value)| *value != 0.0);
        let mut there = vec![false; self.labels.len()];
        entries().filter(|(row, column, _)| row == column).for_each(|(row, ..)| there[row] = true);
        let place = entries().flat_map(|(row, column, _)| [row, column]).find(|place| !there[*place])?;
        self.labels.get(place).copied()
    }

    /// Labels that appear.
    pub fn labels(&self) -> &[DofLabel] {
        &self.labels
    }

    /// The matrix over all DOFs of a list.
    pub fn over(&self, file: &str, all: &[DofLabel]) -> Result<CsMat<f64>, StructureError> {
        let rows: HashMap<DofLabel, u32> = all.iter().copied().zip(0..).collect();
        let row_of = |place: &u32| -> Result<u32, StructureError> {
            let label = self.labels[*place as usize];
            rows.get(&label).copied().ok_or_else(|| StructureError::Matrix {
                file: file.to_owned(),
                reason: format!("node {} direction {} is not in the list of rows", label.node, label.dof + 1),
            })
        };
        let mut entries = Triplets { values: self.entries.values.clone(), ..Triplets::default() };
        entries.rows = self.entries.rows.iter().map(row_of).collect::<Result<_, _>>()?;
        entries.columns = self.entries.columns.iter().map(row_of).collect::<Result<_, _>>()?;
        match self.storage {
            Some(storage) => entries.assemble(file, all.len(), storage),
            None => entries.assemble_as_found(file, all.len()),
        }
    }
}

/// All labels of several matrices in rising order: by node, then direction.
pub(super) fn all_labels<'a>(matrices: impl IntoIterator<Item = &'a LabelledMatrix>) -> Vec<DofLabel> {
    let labels: BTreeSet<DofLabel> = matrices.into_iter().flat_map(|matrix| matrix.labels().iter().copied()).collect();
    labels.into_iter().collect()
}

//! Detects files that end before their last column.
//!
//! A format may leave out columns of zeros. The number of columns in a header then does not show whether all are present; stiffness and
//! mass together do.

use std::collections::HashSet;

use super::entry::Imported;
use super::labelled::LabelledMatrix;
use crate::structure::error::StructureError;
use crate::structure::label::{DofLabel, SCALAR};

/// Columns that a matrix has and another, whose header states more than it has, lacks from some place on to the end.
struct Lacking {
    first: DofLabel,
    count: usize,
    there: usize,
    stated: usize,
}

/// Doubts about the last columns of the mass matrix.
///
/// # Errors
/// A stiffness that lacks its last columns, where there is mass: nothing that stands is like that.
pub(super) fn doubt(imported: &[Imported], names: &[String]) -> Result<Option<String>, StructureError> {
    let ([Imported::Labels(stiffness), Imported::Labels(mass), ..], [stiffness_file, mass_file, ..]) =
        (imported, names)
    else {
        return Ok(None);
    };
    if let Some(Lacking { first, count, there, stated }) = lacking(stiffness, mass) {
        let reason = format!(
            "the file is truncated: its header states {stated} columns but it has {there}, and from node {} direction \
             {} on {count} with mass have no stiffness; export it again",
            first.node,
            first.dof + 1
        );
        return Err(StructureError::Matrix { file: stiffness_file.clone(), reason });
    }
    Ok(lacking(mass, stiffness).map(|Lacking { first, count, there, stated }| {
        format!(
            "{mass_file}: the header states {stated} columns, {there} are there, and from node {} direction {} on {count} with stiffness have no mass: is the file truncated?",
            first.node,
            first.dof + 1
        )
    }))
}

/// Modal coordinates may well have mass alone.
fn lacking(matrix: &LabelledMatrix, other: &LabelledMatrix) -> Option<Lacking> {
    let known: HashSet<DofLabel> = matrix.columns().collect();
    let there = known.len();
    let stated = matrix.stated_columns.filter(|stated| *stated > there)?;
    let lacks = |label: &DofLabel| label.dof != SCALAR && !known.contains(label);
    let tail: Vec<DofLabel> = other.columns().rev().take_while(lacks).collect();
    let first = *tail.last()?;
    (other.columns().filter(lacks).count() == tail.len()).then_some(Lacking { first, count: tail.len(), there, stated })
}

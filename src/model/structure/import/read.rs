//! Reads a model from its files.

use std::path::Path;

use super::entry::{Given, Imported, MatrixKind};
use super::labelled::all_labels;
use super::lines::read_bytes;
use super::rows::{MatrixRows, Nodes};
use super::source::{MatrixFile, ModelFiles};
use super::{axes, columns, dofs, nodes_file, units};
use crate::structure::error::StructureError;
use crate::structure::label::{DofLabel, regular_labels, repeated};
use crate::structure::matrices::ModelMatrices;
use crate::structure::model::{FeModel, Sources};
use crate::structure::points::InterfacePoints;

impl FeModel {
    /// Reads a finite element model and converts it to SI units.
    ///
    /// # Errors
    /// File, line and reason: not readable, truncated, not of the format, entries out of range; what [`FeModel::new`] finds
    /// wrong with the matrices.
    pub fn read(files: &ModelFiles) -> Result<Self, StructureError> {
        let name = |path: &Path| path.display().to_string();
        let list = match &files.dofs {
            Some(path) => Some((dofs::parse_rows(&name(path), &read_bytes(path)?)?, name(path))),
            None => None,
        };
        let order = list.as_ref().map(|(rows, _)| rows.labels.len());
        let read = |kind, source| read_matrix(files, (kind, source), order);
        let mut imported = vec![read(MatrixKind::Stiffness, &files.stiffness)?, read(MatrixKind::Mass, &files.mass)?];
        let mut names = vec![name(&files.stiffness.path), name(&files.mass.path)];
        if let Some(damping) = &files.damping {
            imported.push(read(MatrixKind::Damping, damping)?);
            names.push(name(&damping.path));
        }
        let doubt = columns::doubt(&imported, &names)?;
        let assumed = list.as_ref().is_some_and(|(rows, _)| rows.assumed);
        let labels = list.as_ref().map(|(rows, _)| rows.labels.clone());
        require_distinct(list.as_ref(), &imported)?;
        let (mut nodes, mut stated_by) = stated_nodes(list, &imported, &names)?;
        let mut matrices = combine(imported, &names, (labels, assumed))?;
        if let (true, Some(dofs)) = (matrices.labels.is_empty(), files.dofs_per_node) {
            matrices.labels = numbered(matrices.mass.rows(), dofs, &names)?;
        }
        if let Some(path) = &files.nodes {
            let stated = nodes_file::parse(&name(path), &read_bytes(path)?, &matrices.labels)?;
            if matrices.labels.is_empty() {
                let reason = "nodes without rows: set dof_file or dofs_per_node, which give the node of every row";
                return Err(StructureError::Matrix { file: name(path), reason: reason.to_owned() });
            }
            if stated_by.is_empty() {
                stated_by = name(path);
            }
            axes::add(&mut nodes, &stated_by, &stated, &name(path))?;
        }
        axes::to_basic(&mut matrices, &nodes.axes, &stated_by)?;
        let [stiffness, mass] = [0, 1].map(|index| names.get(index).cloned().unwrap_or_default());
        let sources = Sources {
            stiffness,
            mass,
            damping: names.get(2).cloned().unwrap_or_default(),
            labels: files.dofs.as_deref().map(name).unwrap_or_default(),
            points: name(&files.points),
        };
        let points = match files.points.as_os_str().is_empty() {
            true => InterfacePoints::default(),
            false => InterfacePoints::read(&files.points)?,
        };
        let model = Self::validated(matrices, points, &sources)?.with_doubts(doubt);
        Ok(units::to_si(model, files.units).with_positions(nodes.positions, files.units.metres()))
    }
}

/// Returns an error if a list of rows contains one twice and the matrices refer to rows by name.
fn require_distinct(list: Option<&(MatrixRows, String)>, imported: &[Imported]) -> Result<(), StructureError> {
    let Some((rows, file)) = list else { return Ok(()) };
    match repeated(&rows.labels) {
        Some(([first, second], label)) if imported.iter().any(|matrix| matches!(matrix, Imported::Labels(_))) => {
            let reason = format!(
                "rows {first} and {second} (counted from 1) both are node {} direction {}, and the entries of the matrices go by node and direction: expected each once",
                label.node,
                label.dof + 1
            );
            Err(StructureError::Matrix { file: file.clone(), reason })
        }
        _ => Ok(()),
    }
}

/// Combines the statements about nodes in the list of rows and the matrices' own files, and names the first file that states any.
fn stated_nodes(
    list: Option<(MatrixRows, String)>,
    imported: &[Imported],
    names: &[String],
) -> Result<(Nodes, String), StructureError> {
    let (mut nodes, mut stated_by) = list.map(|(rows, file)| (rows.nodes, file)).unwrap_or_default();
    for (matrix, name) in imported.iter().zip(names) {
        let Imported::Labels(matrix) = matrix else { continue };
        if stated_by.is_empty() {
            stated_by.clone_from(name);
        }
        axes::add(&mut nodes, &stated_by, &matrix.nodes, name)?;
    }
    Ok((nodes, stated_by))
}

/// Labels of rows that are numbered node by node.
fn numbered(order: usize, dofs: usize, names: &[String]) -> Result<Vec<DofLabel>, StructureError> {
    if dofs == 0 || !order.is_multiple_of(dofs) {
        let file = names.first().cloned().unwrap_or_default();
        let reason = format!("{order} rows are not a whole number of nodes with dofs_per_node = {dofs}");
        return Err(StructureError::Matrix { file, reason });
    }
    Ok(regular_labels(order, dofs))
}

fn read_matrix(
    files: &ModelFiles,
    (kind, source): (MatrixKind, &MatrixFile),
    listed: Option<usize>,
) -> Result<Imported, StructureError> {
    let file = source.path.display().to_string();
    let bytes = read_bytes(&source.path)?;
    (files.format.entry().read)(&Given { file: &file, bytes: &bytes, name: &source.name, kind, listed })
}

/// Stiffness, mass and damping over the same rows.
fn combine(
    imported: Vec<Imported>,
    names: &[String],
    (labels, assumed): (Option<Vec<DofLabel>>, bool),
) -> Result<ModelMatrices, StructureError> {
    let labelled = imported.iter().filter_map(|matrix| match matrix {
        Imported::Labels(matrix) => Some(matrix),
        Imported::Rows(_) => None,
    });
    let found = all_labels(labelled);
    let labels = labels.unwrap_or(found);
    let mut matrices = Vec::new();
    for (matrix, name) in imported.into_iter().zip(names) {
        let matrix = match matrix {
            Imported::Labels(matrix) => matrix.over(name, &labels)?,
            Imported::Rows(matrix) => matrix,
        };
        if !labels.is_empty() && matrix.rows() != labels.len() {
            let hint = if assumed {
                "; SECONCT does not contain the retained directions, so all six were assumed: use the .pch as dof_file, \
                 which has them in EXTRN"
            } else {
                ""
            };
            let reason = format!("{} rows, but the list of rows has {}{hint}", matrix.rows(), labels.len());
            return Err(StructureError::Matrix { file: name.clone(), reason });
        }
        matrices.push(matrix);
    }
    let mut matrices = matrices.into_iter();
    let (Some(stiffness), Some(mass)) = (matrices.next(), matrices.next()) else {
        return Err(StructureError::argument("matrices", "stiffness and mass", "fewer"));
    };
    Ok(ModelMatrices { mass, stiffness, damping: matrices.next(), labels })
}

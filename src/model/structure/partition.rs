//! The model split into interface DOFs b and inner DOFs o.

use nalgebra::DMatrix;
use sprs::CsMat;

use super::error::StructureError;
use super::model::FeModel;
use super::points::{DOF_NAMES, InterfaceDof};

/// Names of interface DOFs and their rows in the interface displacement.
pub(super) type NamedRows = Vec<(InterfaceDof, usize)>;

/// The distinct matrix rows of the interface in order, and which of them each named DOF uses.
///
/// DOFs of two points on the same node share a row.
pub(super) fn interface_rows(
    model: &FeModel,
    interface: &[(String, usize)],
) -> Result<(Vec<usize>, NamedRows), StructureError> {
    let mut place: Vec<Option<usize>> = vec![None; model.order()];
    let (mut rows, mut dofs) = (Vec::new(), Vec::new());
    for (point, dof) in interface {
        // In the coordinates of the reduction every DOF is one row, see `with_means`.
        let Some(&(row, _)) = dof_rows(model, point, *dof)?.first() else { continue };
        let Some(slot) = place.get_mut(row) else { continue };
        let position = *slot.get_or_insert_with(|| {
            rows.push(row);
            rows.len() - 1
        });
        dofs.push((InterfaceDof { point: point.clone(), dof: *dof }, position));
    }
    if rows.is_empty() {
        return Err(StructureError::argument("interface", "at least one interface DOF", "none"));
    }
    Ok((rows, dofs))
}

/// Rows and weights whose sum is a DOF of a point: one unless the point is several nodes.
pub(super) fn dof_rows(model: &FeModel, point: &str, dof: usize) -> Result<Vec<(usize, f64)>, StructureError> {
    let known = model.rows_of(point)?;
    let Some(row) = known.get(dof) else {
        let name = format!("direction of interface point {point}");
        return Err(StructureError::argument(name, "0 to 5 (x, y, z, rx, ry, rz)", dof));
    };
    let named = |wanted: bool| {
        let rows = DOF_NAMES.iter().zip(known).filter(|(_, row)| row.is_some() == wanted);
        rows.map(|(name, _)| *name).collect::<Vec<_>>().join(" ")
    };
    if row.is_none() {
        return Err(StructureError::NoSuchDof {
            point: point.to_owned(),
            dof: DOF_NAMES.get(dof).copied().unwrap_or_default().to_owned(),
            known: named(true),
        });
    }
    let rows = model.nodes_of(point)?.iter().filter_map(|(rows, weight)| Some((rows[dof]?, *weight)));
    let rows: Vec<(usize, f64)> = rows.collect();
    match rows.iter().find(|(row, _)| !model.carries(*row)) {
        Some((row, _)) => Err(StructureError::EmptyDof {
            point: point.to_owned(),
            dof: DOF_NAMES.get(dof).copied().unwrap_or_default().to_owned(),
            row: row + 1,
        }),
        None => Ok(rows),
    }
}

/// Inner rows: all except the interface and rows without mass and stiffness, which programs leave for fixed DOFs. Second: the number of
/// such rows.
pub(super) fn inner_rows(model: &FeModel, interface: &[usize]) -> (Vec<bool>, usize) {
    let mut kept: Vec<bool> = (0..model.order()).map(|row| model.carries(row)).collect();
    let empty = kept.iter().filter(|kept| !**kept).count();
    for &row in interface {
        kept[row] = false;
    }
    (kept, empty)
}

/// Blocks of a symmetric matrix at the interface.
pub(super) struct Blocks {
    /// `A_ob`: inner rows, interface columns.
    pub ob: DMatrix<f64>,
    /// `A_bb`: interface rows and columns.
    pub bb: DMatrix<f64>,
}

/// Blocks of a symmetric matrix, its inner rows in the given order.
pub(super) fn blocks(matrix: &CsMat<f64>, inner: &[u32], interface: &[usize]) -> Blocks {
    // Ok(i): inner DOF i; Err(i): interface DOF i.
    let mut place: Vec<Option<Result<usize, usize>>> = vec![None; matrix.rows()];
    for (position, &row) in inner.iter().enumerate() {
        place[row as usize] = Some(Ok(position));
    }
    for (position, &row) in interface.iter().enumerate() {
        place[row] = Some(Err(position));
    }
    let mut ob = DMatrix::zeros(inner.len(), interface.len());
    let mut bb = DMatrix::zeros(interface.len(), interface.len());
    for (column, &row) in interface.iter().enumerate() {
        for (other, &value) in matrix.outer_view(row).iter().flat_map(|view| view.iter()) {
            match place[other] {
                Some(Ok(position)) => ob[(position, column)] = value,
                Some(Err(position)) => bb[(position, column)] = value,
                None => {}
            }
        }
    }
    Blocks { ob, bb }
}

/// `A X` for a sparse symmetric A with both triangles.
pub(super) fn sparse_times(a: &CsMat<f64>, x: &DMatrix<f64>) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(a.rows(), x.ncols());
    for (source, mut target) in x.column_iter().zip(out.column_iter_mut()) {
        for (value, row) in target.iter_mut().zip(a.outer_iterator()) {
            *value = row.iter().map(|(column, entry)| entry * source[column]).sum();
        }
    }
    out
}

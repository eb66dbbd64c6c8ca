//! Conversion of matrices in mm, t, s to SI units.

use sprs::CsMat;

use crate::structure::model::FeModel;

/// Energies in N mm are 1e-3 J, displacements in mm 1e-3 m, rotations stay: `A_SI = 1e-3 T A T`, T = 1000 for displacements
/// and 1 for rotations, for stiffness, mass and damping alike.
///
/// A row that is not known to be a rotation (by its label or an interface point) is taken as a displacement. That is without
/// effect on all results: it only scales a coordinate that nothing outside refers to.
pub(super) fn from_millimetre_tonne(mut model: FeModel) -> FeModel {
    let mut scale = vec![1e3_f64.sqrt(); model.order()];
    for row in model.rotation_rows() {
        if let Some(value) = scale.get_mut(row) {
            *value = 1e-3_f64.sqrt();
        }
    }
    model.for_each_matrix(|matrix| rescale(matrix, &scale));
    model
}

fn rescale(matrix: &mut CsMat<f64>, scale: &[f64]) {
    for (row, mut view) in matrix.outer_iterator_mut().enumerate() {
        for (column, value) in view.iter_mut() {
            // Products of equal scales are exact powers of ten.
            *value *= match (scale[row], scale[column]) {
                (a, b) if a != b => 1.0,
                (a, _) if a > 1.0 => 1e3,
                _ => 1e-3,
            };
        }
    }
}

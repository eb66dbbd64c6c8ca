//! Conversion of matrices to SI units.

use sprs::CsMat;

use super::source::Units;
use crate::structure::model::FeModel;

/// A unit of length, mass and time in SI.
#[derive(Clone, Copy)]
struct Scale {
    metres: f64,
    kilograms: f64,
    /// Reciprocal of the unit of time, 1/s.
    per_second: f64,
}

impl Units {
    fn scale(self) -> Scale {
        const INCH: f64 = 0.0254;
        const FOOT: f64 = 0.3048;
        const POUND_FORCE: f64 = 4.448_221_615_260_5;
        let (metres, kilograms, per_second) = match self {
            Self::Si => (1.0, 1.0, 1.0),
            Self::MillimetreTonneSecond => (1e-3, 1e3, 1.0),
            Self::MillimetreKilogramSecond => (1e-3, 1.0, 1.0),
            Self::MillimetreKilogramMillisecond => (1e-3, 1.0, 1e3),
            Self::MillimetreGramMillisecond => (1e-3, 1e-3, 1e3),
            Self::MetreTonneSecond => (1.0, 1e3, 1.0),
            Self::CentimetreGramSecond => (1e-2, 1e-3, 1.0),
            Self::InchPoundForceSecond => (INCH, POUND_FORCE / INCH, 1.0),
            Self::FootPoundForceSecond => (FOOT, POUND_FORCE / FOOT, 1.0),
        };
        Scale { metres, kilograms, per_second }
    }

    /// Unit of length in m.
    pub(super) fn metres(self) -> f64 {
        self.scale().metres
    }
}

/// Entries between displacements scale with the unit of mass (of stiffness over time squared, of damping over time), those between a
/// displacement and a rotation also with the unit of length, those between rotations with its square.
///
/// A row that is not known to be a rotation (by its label or an interface point) is taken as a displacement. That is without
/// effect on all results: it only scales a coordinate that nothing outside refers to.
pub(super) fn to_si(mut model: FeModel, units: Units) -> FeModel {
    let Scale { metres, kilograms, per_second } = units.scale();
    if units == Units::Si {
        return model;
    }
    let mut turns = vec![false; model.order()];
    for row in model.rotation_rows() {
        if let Some(value) = turns.get_mut(row) {
            *value = true;
        }
    }
    let rescale = |matrix: &mut CsMat<f64>, factor: f64| {
        let factors = [factor, factor * metres, factor * (metres * metres)];
        for (row, mut view) in matrix.outer_iterator_mut().enumerate() {
            for (column, value) in view.iter_mut() {
                *value *= factors[usize::from(turns[row]) + usize::from(turns[column])];
            }
        }
    };
    let [mass, stiffness, damping] = model.matrices_mut();
    let damped = kilograms * per_second;
    for (matrix, factor) in [(mass, kilograms), (stiffness, damped * per_second), (damping, damped)] {
        if let Some(matrix) = matrix {
            rescale(matrix, factor);
        }
    }
    model
}

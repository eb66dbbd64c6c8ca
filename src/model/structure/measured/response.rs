//! A measured frequency response.

use crate::structure::points::DOF_NAMES;

/// Place and direction of a signal, with its sign.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct MeasuredDof {
    /// Name of an interface point, or number of a node.
    pub place: String,
    /// 0 to 2: x, y, z.
    pub axis: usize,
    /// Whether the positive signal is along the negative axis.
    pub reversed: bool,
}

impl MeasuredDof {
    /// The direction in the machine's coordinates, a unit vector.
    pub fn direction(&self) -> [f64; 3] {
        let mut direction = [0.0; 3];
        if let Some(component) = direction.get_mut(self.axis) {
            *component = if self.reversed { -1.0 } else { 1.0 };
        }
        direction
    }

    /// `12.z`, `R5.-x`.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let (place, direction) = text.rsplit_once('.')?;
        let (reversed, name) = match direction.strip_prefix('-') {
            Some(name) => (true, name),
            None => (false, direction.strip_prefix('+').unwrap_or(direction)),
        };
        let axis = DOF_NAMES[..3].iter().position(|known| known.eq_ignore_ascii_case(name))?;
        (!place.is_empty()).then(|| Self { place: place.to_owned(), axis, reversed })
    }
}

impl std::fmt::Display for MeasuredDof {
    fn fmt(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        let sign = if self.reversed { "-" } else { "" };
        write!(formatter, "{}.{sign}{}", self.place, DOF_NAMES.get(self.axis).copied().unwrap_or_default())
    }
}

/// A measured mobility: velocity at one place per force at another.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredFrf {
    /// Point of the velocity.
    pub response: MeasuredDof,
    /// Point of the force.
    pub force: MeasuredDof,
    /// Frequencies in Hz, positive, rising.
    pub frequency_hz: Vec<f64>,
    /// Real and imaginary part in m/(s N).
    pub mobility: Vec<[f64; 2]>,
}

/// Quantity of motion of a frequency response.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Motion {
    Displacement,
    Velocity,
    Acceleration,
}

impl Motion {
    /// A value per force as velocity per force: times `j omega`, 1 or `1 / (j omega)`.
    pub(super) fn mobility(self, omega: f64, [re, im]: [f64; 2]) -> [f64; 2] {
        match self {
            Self::Displacement => [-omega * im, omega * re],
            Self::Velocity => [re, im],
            Self::Acceleration => [im / omega, -re / omega],
        }
    }
}

//! Coordinates of rigid parts, each with its mass or inertia: bodies of a hammer; heave and rotations of a casting.

/// Coordinates with a mass each.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::system) struct Rigid {
    /// Mass or inertia of each.
    pub mass: Vec<f64>,
}

impl Rigid {
    /// Adds the kinetic energy, J, to a sum.
    pub fn add_energy(&self, sum: f64, velocities: &[f64]) -> f64 {
        self.mass.iter().zip(velocities).fold(sum, |sum, (mass, v)| sum + 0.5 * mass * v * v)
    }
}

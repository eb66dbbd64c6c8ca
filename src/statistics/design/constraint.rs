//! Constraints on the rows of a design.

use super::coordinate::Coordinate;
use super::distribution::Level;
use super::error::DesignError;

/// Counts how many of the constraints, given by index, hold in a row, in their order up to the first that does not. Returns the error of a
/// constraint that cannot be evaluated.
pub type Met<'a> = dyn FnMut(&[Level], &[usize]) -> Result<usize, String> + 'a;

/// Constraints on every row of a design.
pub struct Constraints<'a> {
    /// Per constraint the factors, by index, that it looks at. Others must not matter to it: a search leaves them alone.
    pub factors: Vec<Vec<usize>>,
    /// Counts the constraints that hold.
    pub met: &'a mut Met<'a>,
}

/// [`Met`] of a row's coordinates.
pub(super) type MetThere<'a> = dyn FnMut(&[Coordinate], &[usize]) -> Result<usize, DesignError> + 'a;

/// The same of a row's coordinates.
pub(super) struct Conditions<'a> {
    pub factors: &'a [Vec<usize>],
    pub met: &'a mut MetThere<'a>,
}

impl Conditions<'_> {
    /// The constraints by index.
    pub fn all(&self) -> Vec<usize> {
        (0..self.factors.len()).collect()
    }
}

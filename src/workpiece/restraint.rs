//! Which rotations a casting needs, and whether its fixtures hold it.

use super::{Casting, WorkpieceError};

/// Offsets from the centre of mass below this length in m are rounding, not geometry.
pub const OFFSET_TOLERANCE_M: f64 = 1e-9;

/// Smallest pivot, relative to the largest stiffness, of a casting that counts as held.
const PIVOT_TOLERANCE: f64 = 1e-9;

impl Casting {
    /// Rotations that the casting needs, `[tx, ty]`.
    ///
    /// `tx` (about x) is needed when a strike point, a fixture or the measuring point has an offset in y, `ty` when one
    /// has an offset in x; offsets up to [`OFFSET_TOLERANCE_M`] count as zero. `strike_points`: all points in m, from the
    /// casting's centre of mass, at which hammers strike it.
    pub fn active_rotations(&self, strike_points: &[[f64; 2]]) -> [bool; 2] {
        let offset = |axis: usize| {
            self.fixtures
                .iter()
                .map(|fixture| &fixture.at_m)
                .chain(strike_points)
                .chain(&self.measuring_point_m)
                .any(|point| point[axis].abs() > OFFSET_TOLERANCE_M)
        };
        [offset(1), offset(0)]
    }

    /// Checks that the casting can be simulated with heave and the `active` rotations `[tx, ty]`.
    ///
    /// The stiffness `sum k b b'`, `b = (1, y, -x)` restricted to the active coordinates, must be positive definite:
    /// otherwise the casting could spin (or drift) freely on its fixtures.
    ///
    /// # Errors
    /// [`WorkpieceError::MissingInertia`] if a rotation is active and there is no inertia,
    /// [`WorkpieceError::Unrestrained`] if the fixtures leave a motion free.
    pub fn check_restraint(&self, active: [bool; 2]) -> Result<(), WorkpieceError> {
        if active != [false, false] && self.inertia_kg_m2.is_none() {
            return Err(WorkpieceError::MissingInertia { casting: self.name.clone() });
        }
        match free_motion(&self.stiffness(), [true, active[0], active[1]]) {
            None => Ok(()),
            Some(motion) => Err(WorkpieceError::Unrestrained {
                casting: self.name.clone(),
                motion: ["heave", "rotation tx about x", "rotation ty about y"][motion],
            }),
        }
    }

    /// Stiffness of the fixtures over (heave, tx, ty), rotations scaled by the largest offset so that all entries are N/m.
    fn stiffness(&self) -> [[f64; 3]; 3] {
        let length = self
            .fixtures
            .iter()
            .flat_map(|fixture| fixture.at_m)
            .fold(OFFSET_TOLERANCE_M, |longest, offset| longest.max(offset.abs()));
        let mut matrix = [[0.0; 3]; 3];
        for fixture in &self.fixtures {
            let row = [1.0, fixture.at_m[1] / length, -fixture.at_m[0] / length];
            for (i, line) in matrix.iter_mut().enumerate() {
                for (j, entry) in line.iter_mut().enumerate() {
                    *entry += fixture.stiffness_n_per_m * row[i] * row[j];
                }
            }
        }
        matrix
    }
}

/// First active coordinate whose pivot in a Cholesky elimination is not positive; `None` for a positive definite matrix.
fn free_motion(stiffness: &[[f64; 3]; 3], active: [bool; 3]) -> Option<usize> {
    let mut matrix = *stiffness;
    let largest = (0..3).fold(0.0_f64, |largest, i| largest.max(matrix[i][i]));
    for pivot in (0..3).filter(|&i| active[i]) {
        let value = matrix[pivot][pivot];
        // Written so that a NaN counts as free.
        let held = value > PIVOT_TOLERANCE * largest;
        if !held {
            return Some(pivot);
        }
        let line = matrix[pivot];
        for (i, target) in matrix.iter_mut().enumerate().skip(pivot + 1) {
            let factor = line[i] / value;
            for (entry, above) in target.iter_mut().zip(line) {
                *entry -= factor * above;
            }
        }
    }
    None
}

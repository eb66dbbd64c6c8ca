//! Rotations that a casting needs, and the check that its fixtures hold it.

use super::casting::Casting;

/// Reason why a casting cannot be simulated.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum WorkpieceError {
    /// A rotation is active, but no inertia is given.
    #[error(
        "casting `{casting}` is struck or held off its centre, so it rotates: its inertia is needed \
         (`inertia_kg_m2 = [about x, about y]`)"
    )]
    MissingInertia {
        /// Name of the casting.
        casting: String,
    },
    /// The fixtures leave a motion free.
    #[error(
        "casting `{casting}` could spin freely: its fixtures do not hold its {motion}; \
         add fixtures with an offset from its centre"
    )]
    Unrestrained {
        /// Name of the casting.
        casting: String,
        /// The motion that is free.
        motion: &'static str,
    },
}

/// Offsets from the centre of mass below this length in m are rounding, not geometry.
pub const OFFSET_TOLERANCE_M: f64 = 1e-9;

/// Smallest pivot, relative to the largest entry, of a casting that counts as held.
const PIVOT_TOLERANCE: f64 = 1e-9;

impl Casting {
    /// Rotations that the casting needs, `[tx, ty]`.
    ///
    /// `tx` (about x) is needed when a strike point, a fixture, a core or the measuring point has an offset in y, `ty` when one
    /// has an offset in x; offsets up to [`OFFSET_TOLERANCE_M`] count as zero. `strike_points`: all points in m, from the
    /// casting's centre of mass, at which hammers strike it.
    pub fn active_rotations(&self, strike_points: &[[f64; 2]]) -> [bool; 2] {
        let offset = |axis: usize| {
            self.fixtures
                .iter()
                .map(|fixture| &fixture.at_m)
                .chain(strike_points)
                .chain(&self.measuring_point_m)
                .map(|point| point[axis])
                .chain(self.cores.iter().map(|core| core.at_m[axis]))
                .any(|offset| offset.abs() > OFFSET_TOLERANCE_M)
        };
        [offset(1), offset(0)]
    }

    /// Checks that the casting can be simulated with heave and the `active` rotations `[tx, ty]`.
    ///
    /// The sum of `b b'` over the fixtures, `b = (1, y, -x)` restricted to the active coordinates, must be positive definite:
    /// otherwise the casting could spin (or drift) freely on its fixtures, however stiff they are.
    ///
    /// # Errors
    /// [`WorkpieceError::MissingInertia`] if a rotation is active and there is no inertia,
    /// [`WorkpieceError::Unrestrained`] if the fixtures leave a motion free.
    pub fn check_restraint(&self, active: [bool; 2]) -> Result<(), WorkpieceError> {
        if active != [false, false] && self.inertia_kg_m2.is_none() && self.elastic.is_none() {
            return Err(WorkpieceError::MissingInertia { casting: self.name.clone() });
        }
        match free_motion(&self.hold(), [true, active[0], active[1]]) {
            None => Ok(()),
            Some(motion) => Err(WorkpieceError::Unrestrained {
                casting: self.name.clone(),
                motion: ["heave", "rotation tx about x", "rotation ty about y"][motion],
            }),
        }
    }

    /// Sum of `b b'` over (heave, tx, ty), rotations scaled by the largest offset. Stiffnesses are left out: they do not decide which
    /// motions are held, and a stiffness of 1e25 N/m would hide the others by rounding.
    fn hold(&self) -> [[f64; 3]; 3] {
        let length = self
            .fixtures
            .iter()
            .flat_map(|fixture| fixture.at_m)
            .fold(OFFSET_TOLERANCE_M, |longest, offset| longest.max(offset.abs()));
        let mut matrix = [[0.0; 3]; 3];
        for fixture in self.fixtures.iter().filter(|fixture| fixture.spring()[0] > 0.0) {
            let row = [1.0, fixture.at_m[1] / length, -fixture.at_m[0] / length];
            for (i, line) in matrix.iter_mut().enumerate() {
                for (j, entry) in line.iter_mut().enumerate() {
                    *entry += row[i] * row[j];
                }
            }
        }
        matrix
    }
}

/// First active coordinate whose pivot in a Cholesky elimination is not positive; `None` for a positive definite matrix.
fn free_motion(hold: &[[f64; 3]; 3], active: [bool; 3]) -> Option<usize> {
    let mut matrix = *hold;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workpiece::Fixture;

    fn casting(fixtures: &[[f64; 2]]) -> Casting {
        let fixture = |(i, at): (usize, &[f64; 2])| Fixture {
            name: format!("f{i}"),
            point: format!("T{i}"),
            at_m: *at,
            ..Fixture::default()
        };
        Casting {
            name: "part".into(),
            mass_kg: 1.0,
            inertia_kg_m2: Some([0.01, 0.02]),
            fixtures: fixtures.iter().enumerate().map(fixture).collect(),
            ..Casting::default()
        }
    }

    #[test]
    fn rotations_follow_the_offsets() {
        let centred = casting(&[[0.0, 0.0]]);
        assert_eq!(centred.active_rotations(&[[0.0, 0.0]]), [false, false]);
        assert_eq!(centred.active_rotations(&[[1e-17, 0.0]]), [false, false]);
        assert_eq!(centred.active_rotations(&[[0.0, 0.01]]), [true, false]);
        assert_eq!(centred.active_rotations(&[[0.01, 0.0]]), [false, true]);
        assert_eq!(casting(&[[0.1, 0.1]]).active_rotations(&[]), [true, true]);
        let measured = Casting { measuring_point_m: Some([0.0, 0.05]), ..centred };
        assert_eq!(measured.active_rotations(&[]), [true, false]);
    }

    #[test]
    fn a_single_fixture_holds_heave_only() {
        let single = casting(&[[0.0, 0.0]]);
        assert_eq!(single.check_restraint([false, false]), Ok(()));
        assert!(matches!(
            single.check_restraint([true, false]),
            Err(WorkpieceError::Unrestrained { motion: "rotation tx about x", .. })
        ));
        assert!(matches!(
            single.check_restraint([false, true]),
            Err(WorkpieceError::Unrestrained { motion: "rotation ty about y", .. })
        ));
    }

    #[test]
    fn fixtures_in_a_line_leave_the_rotation_about_it() {
        let line = casting(&[[-0.1, 0.0], [0.1, 0.0]]);
        assert_eq!(line.check_restraint([false, true]), Ok(()));
        assert!(line.check_restraint([true, true]).is_err());
        // Two fixtures on a diagonal hold either rotation alone, never both.
        let diagonal = casting(&[[-0.1, -0.1], [0.1, 0.1]]);
        assert_eq!(diagonal.check_restraint([true, false]), Ok(()));
        assert!(diagonal.check_restraint([true, true]).is_err());
        let square = casting(&[[-0.1, -0.1], [0.1, -0.1], [-0.1, 0.1], [0.1, 0.1]]);
        assert_eq!(square.check_restraint([true, true]), Ok(()));
    }

    #[test]
    fn what_holds_does_not_depend_on_stiffness() {
        let mut square = casting(&[[-0.1, -0.1], [0.1, -0.1], [-0.1, 0.1], [0.1, 0.1]]);
        square.fixtures[0].stiffness_n_per_m = 1e25;
        assert_eq!(square.check_restraint([true, true]), Ok(()));
    }

    #[test]
    fn a_rotating_casting_needs_its_inertia() {
        let square = casting(&[[-0.1, -0.1], [0.1, -0.1], [-0.1, 0.1], [0.1, 0.1]]);
        let light = Casting { inertia_kg_m2: None, ..square };
        assert!(matches!(light.check_restraint([true, false]), Err(WorkpieceError::MissingInertia { .. })));
        assert_eq!(light.check_restraint([false, false]), Ok(()));
    }
}

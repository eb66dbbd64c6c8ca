//! Rotations that a casting needs, and the check that its fixtures hold it.

use super::casting::{Casting, Fixture};

/// Reason why a casting cannot be simulated.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum WorkpieceError {
    /// A rotation is active, but no inertia is given.
    #[error(
        "casting `{casting}` is struck or held off its centre, so it rotates: its inertia is needed ({})",
        if *about_z { "`inertia_z_kg_m2`" } else { "`inertia_kg_m2 = [about x, about y]`" }
    )]
    MissingInertia {
        /// Name of the casting.
        casting: String,
        /// Whether it is its inertia about z.
        about_z: bool,
    },
    /// The fixtures leave a motion free.
    #[error(
        "casting `{casting}` is free to move: its fixtures do not hold its {motion}; add {}",
        if motion.starts_with("rotation") { "fixtures with an offset from its centre" }
        else { "a fixture with `lateral_stiffness_n_per_m`, or one with its `axis` in this direction" }
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

/// Freedoms of a rigid casting: shifts along x, y and z, rotations about them.
pub const FREEDOMS: usize = 6;

/// Names of these.
const NAMES: [&str; FREEDOMS] =
    ["motion along x", "motion along y", "heave", "rotation tx about x", "rotation ty about y", "rotation tz about z"];

/// Motion of a point of a casting along a direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// The point from the centre of mass, m.
    pub at_m: [f64; 3],
    /// Unit vector.
    pub direction: [f64; 3],
}

impl Motion {
    /// Motion per freedom: with the direction d, the point r and an axis e, `-d e` for a shift and `-d (e x r)` for a rotation. The signs
    /// make the shift along z a motion downwards, as vertical strikes count it: then this is `1, y, -x` for heave, tx and ty.
    pub fn per_freedom(&self) -> [f64; FREEDOMS] {
        let ([dx, dy, dz], [x, y, z]) = (self.direction, self.at_m);
        [-dx, -dy, -dz, dy * z - dz * y, dz * x - dx * z, dx * y - dy * x]
    }
}

impl Casting {
    /// Freedoms that the casting needs: those by which one of these points moves in its direction. Offsets up to [`OFFSET_TOLERANCE_M`]
    /// and shares of a direction up to as much count as zero.
    pub fn freedoms(&self, motions: &[Motion]) -> [bool; FREEDOMS] {
        let moved = motions.iter().map(|motion| motion.per_freedom().map(|lever| lever.abs() > OFFSET_TOLERANCE_M));
        moved.fold([false; FREEDOMS], |all, moved| std::array::from_fn(|freedom| all[freedom] || moved[freedom]))
    }

    /// Moments of inertia about x, y, z in kg m2; `None` for an unknown one.
    pub fn moments_kg_m2(&self) -> [Option<f64>; 3] {
        let [x, y] = self.inertia_kg_m2.map_or([None; 2], |moments| moments.map(Some));
        [x, y, self.inertia_z_kg_m2]
    }

    /// Motions along which its fixtures hold it, by stiffness or by friction.
    pub fn holds(&self) -> impl Iterator<Item = Motion> {
        let held = |fixture: &Fixture, axis: usize| match axis {
            0 => fixture.spring()[0] > 0.0,
            _ => fixture.friction > 0.0 || fixture.lateral_spring(axis - 1)[0] > 0.0,
        };
        self.fixtures.iter().flat_map(move |fixture| {
            let axes = fixture.axes();
            let held = fixture.held_axes().filter(move |axis| held(fixture, *axis));
            held.map(move |axis| Motion { at_m: fixture.place_m(), direction: axes[axis] })
        })
    }

    /// Checks that the casting can be simulated with the `active` freedoms.
    ///
    /// The sum of `b b'` over the motions that are held, b the motion per active freedom, must be positive definite: otherwise the
    /// casting could spin (or drift) freely on its fixtures, however stiff they are.
    ///
    /// # Errors
    /// [`WorkpieceError::MissingInertia`] if a rotation is active and its inertia is not given,
    /// [`WorkpieceError::Unrestrained`] if the fixtures leave a motion free.
    pub fn check_restraint(&self, active: [bool; FREEDOMS]) -> Result<(), WorkpieceError> {
        let lacks = |about: usize| active[3 + about] && self.elastic.is_none() && self.moments_kg_m2()[about].is_none();
        if let Some(about) = (0..3).find(|about| lacks(*about)) {
            return Err(WorkpieceError::MissingInertia { casting: self.name.clone(), about_z: about == 2 });
        }
        match free_motion(&self.hold(), active) {
            None => Ok(()),
            Some(motion) => Err(WorkpieceError::Unrestrained { casting: self.name.clone(), motion: NAMES[motion] }),
        }
    }

    /// Sum of `b b'` over all freedoms, rotations scaled by the largest offset. Stiffnesses are left out: they do not decide which
    /// motions are held, and a stiffness of 1e25 N/m would hide the others by rounding.
    fn hold(&self) -> [[f64; FREEDOMS]; FREEDOMS] {
        let offsets = self.holds().flat_map(|motion| motion.at_m);
        let length = offsets.fold(OFFSET_TOLERANCE_M, |longest, offset| longest.max(offset.abs()));
        let mut matrix = [[0.0; FREEDOMS]; FREEDOMS];
        for motion in self.holds() {
            let mut row = motion.per_freedom();
            row[3..].iter_mut().for_each(|lever| *lever /= length);
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
fn free_motion(hold: &[[f64; FREEDOMS]; FREEDOMS], active: [bool; FREEDOMS]) -> Option<usize> {
    let mut matrix = *hold;
    let largest = (0..FREEDOMS).fold(0.0_f64, |largest, i| largest.max(matrix[i][i]));
    for pivot in (0..FREEDOMS).filter(|&i| active[i]) {
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
    use crate::direction::DOWN;

    const FIXED: [bool; 6] = [false, false, true, false, false, false];

    /// Heave and some of the rotations about x and y.
    fn heave([x, y]: [bool; 2]) -> [bool; 6] {
        [false, false, true, x, y, false]
    }

    fn vertical(at: [f64; 2]) -> Motion {
        Motion { at_m: [at[0], at[1], 0.3], direction: DOWN }
    }

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
    fn freedoms_follow_offsets_and_directions() {
        let part = casting(&[[0.0, 0.0]]);
        let needed = |motions: &[Motion]| part.freedoms(motions);
        assert_eq!(needed(&[vertical([0.0, 0.0])]), FIXED);
        assert_eq!(needed(&[vertical([1e-17, 0.0])]), FIXED);
        assert_eq!(needed(&[vertical([0.0, 0.01])]), heave([true, false]));
        assert_eq!(needed(&[vertical([0.01, 0.0])]), heave([false, true]));
        assert_eq!(needed(&[vertical([0.0, 0.0]), vertical([0.1, 0.1])]), heave([true, true]));
        // Along x at a height, it tilts about y; aside, it turns about z.
        let along_x = |at_m| Motion { at_m, direction: [1.0, 0.0, 0.0] };
        assert_eq!(needed(&[along_x([0.2, 0.0, 0.1])]), [true, false, false, false, true, false]);
        assert_eq!(needed(&[along_x([0.2, 0.1, 0.0])]), [true, false, false, false, false, true]);
    }

    /// The motion of a point by a small rotation, against the cross product of the rotation and the point.
    #[test]
    fn motion_per_freedom_is_the_one_of_a_rigid_body() {
        let motion = Motion { at_m: [0.1, -0.2, 0.3], direction: [0.6, 0.0, -0.8] };
        let turned = [[0.0, -0.3, -0.2], [0.3, 0.0, -0.1], [0.2, 0.1, 0.0]];
        let along = |v: [f64; 3]| -crate::direction::dot(v, motion.direction);
        let found = motion.per_freedom();
        for (about, moved) in turned.into_iter().enumerate() {
            assert!((found[3 + about] - along(moved)).abs() < 1e-15, "{about}: {found:?}");
        }
    }

    #[test]
    fn a_single_fixture_holds_heave_only() {
        let single = casting(&[[0.0, 0.0]]);
        assert_eq!(single.check_restraint(heave([false, false])), Ok(()));
        assert!(matches!(
            single.check_restraint(heave([true, false])),
            Err(WorkpieceError::Unrestrained { motion: "rotation tx about x", .. })
        ));
        assert!(matches!(
            single.check_restraint(heave([false, true])),
            Err(WorkpieceError::Unrestrained { motion: "rotation ty about y", .. })
        ));
    }

    #[test]
    fn fixtures_in_a_line_leave_the_rotation_about_it() {
        let line = casting(&[[-0.1, 0.0], [0.1, 0.0]]);
        assert_eq!(line.check_restraint(heave([false, true])), Ok(()));
        assert!(line.check_restraint(heave([true, true])).is_err());
        // Two fixtures on a diagonal hold either rotation alone, never both.
        let diagonal = casting(&[[-0.1, -0.1], [0.1, 0.1]]);
        assert_eq!(diagonal.check_restraint(heave([true, false])), Ok(()));
        assert!(diagonal.check_restraint(heave([true, true])).is_err());
        let square = casting(&[[-0.1, -0.1], [0.1, -0.1], [-0.1, 0.1], [0.1, 0.1]]);
        assert_eq!(square.check_restraint(heave([true, true])), Ok(()));
    }

    #[test]
    fn what_holds_does_not_depend_on_stiffness() {
        let mut square = casting(&[[-0.1, -0.1], [0.1, -0.1], [-0.1, 0.1], [0.1, 0.1]]);
        square.fixtures[0].stiffness_n_per_m = 1e25;
        assert_eq!(square.check_restraint(heave([true, true])), Ok(()));
    }

    #[test]
    fn a_rotating_casting_needs_its_inertia() {
        let square = casting(&[[-0.1, -0.1], [0.1, -0.1], [-0.1, 0.1], [0.1, 0.1]]);
        let light = Casting { inertia_kg_m2: None, ..square };
        assert!(matches!(light.check_restraint(heave([true, false])), Err(WorkpieceError::MissingInertia { .. })));
        assert_eq!(light.check_restraint(heave([false, false])), Ok(()));
    }
}

//! Castings and the fixtures that hold them: plain data, rigid-body kinematics in the plane of the table.

mod restraint;

use crate::parameter::parameters;

pub use restraint::OFFSET_TOLERANCE_M;

/// Why a casting cannot be simulated.
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

parameters! {
    /// Spring and damper between a point of a casting and a node of the structure.
    pub struct Fixture {
        own {
            /// Name as in the study.
            pub name: String,
            /// Interface point of the structure that carries it.
            pub point: String,
        }
        /// Where it holds the casting, x and y from the casting's centre of mass.
        pub at_m: [f64; 2], "m", [finite], "default: above its interface point";
        /// Stiffness `k_T`.
        pub stiffness_n_per_m: f64 = 3e7, "N/m", [> 0], "the paper's rig";
        /// Damping `c_T`.
        pub damping_n_s_per_m: f64 = 4000.0, "N s/m", [>= 0], "the paper's rig";
    }
}

parameters! {
    /// A rigid casting with the fixtures that carry it.
    ///
    /// The point (x, y) moves by `z + y tx - x ty`.
    pub struct Casting {
        own {
            /// Name as in the study.
            pub name: String,
            /// Its fixtures; at least one.
            pub fixtures: Vec<Fixture>,
        }
        /// Mass.
        pub mass_kg: f64, "kg", [> 0], "no default";
        /// Centre of mass in the machine's plane, x and y.
        pub centre_m: [f64; 2], "m", [finite], "default: the mean of its fixtures' points";
        /// Extent in x and y, centred.
        pub size_m: Option<[f64; 2]>, "m", [> 0], "default: unlimited, no hammer can miss it";
        /// Moments of inertia about x (rotation `tx`, driven by offsets in y) and y (rotation `ty`, driven by offsets in x).
        pub inertia_kg_m2: Option<[f64; 2]>, "kg m2", [> 0], "needed only where it can rotate (struck, held or measured off its centre)";
        /// Where its velocity is also reported, x and y from the centre of mass.
        pub measuring_point_m: Option<[f64; 2]>, "m", [finite], "default: at the centre only";
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn casting(fixtures: &[[f64; 2]]) -> Casting {
        let fixture = |(i, at): (usize, &[f64; 2])| Fixture {
            name: format!("f{i}"),
            point: format!("T{i}"),
            at_m: *at,
            stiffness_n_per_m: 3e7,
            damping_n_s_per_m: 4000.0,
        };
        Casting {
            name: "part".into(),
            mass_kg: 1.0,
            inertia_kg_m2: Some([0.01, 0.02]),
            centre_m: [0.0; 2],
            size_m: None,
            measuring_point_m: None,
            fixtures: fixtures.iter().enumerate().map(fixture).collect(),
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
    fn a_rotating_casting_needs_its_inertia() {
        let square = casting(&[[-0.1, -0.1], [0.1, -0.1], [-0.1, 0.1], [0.1, 0.1]]);
        let light = Casting { inertia_kg_m2: None, ..square };
        assert!(matches!(light.check_restraint([true, false]), Err(WorkpieceError::MissingInertia { .. })));
        assert_eq!(light.check_restraint([false, false]), Ok(()));
    }
}

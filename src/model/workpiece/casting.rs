//! Castings and fixtures as data.

use indexmap::IndexMap;
use serde::Serialize;

use super::elastic::CastingStructureEntry;
use super::pad::{Pad, PadMaterial};
use crate::direction::{DOWN, across, unit};
use crate::parameter::parameters;
use crate::structure::{NodesEntry, WeightedNodes};

parameters! {
    /// Spring and damper between a point of a casting and a node of the structure. A one-sided fixture is a pad; a fixture with a force is
    /// a clamp.
    #[derive(Serialize)]
    pub struct Fixture from FixtureEntry with Pad {
        own {
            /// Name as in the study.
            pub name: String,
            /// Interface point of the structure that carries it.
            pub point: String,
            /// Pad from which its stiffness and damping follow, if the study states one.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub pad: Option<Pad>,
            /// Nodes of an elastic casting that it holds; `None`: the area around `at_m`.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub at_nodes: Option<WeightedNodes>,
        }
        typed {
            /// Interface point to which it is fixed.
            pub point: String,
            /// As in [`Pad`].
            #[serde(skip_serializing_if = "Option::is_none")]
            pub material: Option<PadMaterial>,
            /// As in [`Pad`].
            #[serde(skip_serializing_if = "Option::is_none")]
            pub pad_area_m2: Option<f64>,
            /// As in [`Pad`].
            #[serde(skip_serializing_if = "Option::is_none")]
            pub pad_thickness_m: Option<f64>,
            /// Nodes of an elastic casting that it holds, instead of `at_m`, in the forms of `strike_nodes` of a hammer.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub at_nodes: Option<NodesEntry>,
        }
        /// Point where the fixture holds the casting, x and y from the casting's centre of mass.
        pub at_m: [f64; 2], "m", [finite] usual [-10, 10], "default: above its interface point";
        /// Height of that point above the casting's centre of mass. It matters only where fixtures, hammers or gravity act sideways.
        pub height_m: f64, "m", [finite] usual [-10, 10], "default: the height of its interface point";
        /// Direction in world axes (x forward, y lateral, z up) in which it is pressed. A clamp presses along it. Its length does not matter.
        pub axis: [f64; 3] = DOWN, "1", [finite], "vertical, downwards";
        /// Stiffness `k_T`.
        pub stiffness_n_per_m: f64 = 3e7, "N/m", [> 0] usual [1e5, 1e11], "the paper's rig";
        /// Damping `c_T`.
        pub damping_n_s_per_m: f64 = 4000.0, "N s/m", [>= 0] usual [0, 1e6], "the paper's rig";
        /// Stiffness across its axis: along x and y for a vertical one, see `decore help directions`.
        pub lateral_stiffness_n_per_m: [f64; 2] = [0.0, 0.0], "N/m", [>= 0] usual [0, 1e11], "it holds along its axis only";
        /// Damping across its axis.
        pub lateral_damping_n_s_per_m: [f64; 2] = [0.0, 0.0], "N s/m", [>= 0] usual [0, 1e6], "none";
        /// Whether it only pushes, like a pad: `F = max(0, F_0 + k_T d + c_T d')`, d the approach since rest, `F_0` its share of the
        /// casting's weight and of the clamps. The casting lifts off where F reaches 0.
        pub one_sided: bool = false, "", [choice], "false";
        /// Coefficient of friction of a pad in its plane: the casting slides against `mu F tanh(|v| / v_s)`, F the force on the pad.
        pub friction: f64 = 0.0, "1", [>= 0] usual [0, 1], "none: it slides freely";
        /// Speed `v_s` at which friction has reached 76 % of its largest value.
        pub friction_speed_m_s: f64 = 0.01, "m/s", [> 0] usual [1e-4, 0.1], "assumed: below it the casting creeps";
        /// Force of a clamp, which presses the casting onto its one-sided fixtures. Ignores `stiffness_n_per_m` and `damping_n_s_per_m`.
        pub clamp_force_n: f64 = 0.0, "N", [>= 0] usual [0, 1e5], "no clamp";
        /// Stiffness of a clamp with a spring. 0: constant force, as of a cylinder.
        pub clamp_stiffness_n_per_m: f64 = 0.0, "N/m", [>= 0] usual [0, 1e9], "constant force";
    }
}

parameters! {
    /// A point of a casting at a core. Its velocity is an output, and it costs no state.
    #[derive(Serialize)]
    pub struct CorePoint from CorePointEntry {
        own {
            /// Name as in the study.
            pub name: String,
            /// Nodes of an elastic casting that it is; `None`: the area around `at_m`.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub at_nodes: Option<WeightedNodes>,
        }
        typed {
            /// Nodes of an elastic casting, instead of `at_m`, in the forms of `strike_nodes` of a hammer.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub at_nodes: Option<NodesEntry>,
        }
        /// Position x, y and z from the casting's centre of mass. For a rigid casting z does not matter.
        pub at_m: [f64; 3], "m", [finite] usual [-10, 10], "default: at the centre of mass";
    }
}

/// Elastic casting of a scene. Its modes are separate, see [`crate::system::PlacedModes`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Elastic {
    /// Whether the stiffness of the chisel's contact includes the local flexibility of the casting.
    pub contact_includes_casting: bool,
}

parameters! {
    /// A casting with the fixtures that carry it.
    ///
    /// A rigid casting has only the freedoms that its scene needs. If all strikes and fixtures are vertical, its point (x, y) moves by
    /// `z + y tx - x ty`. An elastic casting moves by the modes of its finite element model.
    pub struct Casting from CastingEntry {
        own {
            /// Name as in the study.
            pub name: String,
            /// Fixtures; at least one.
            pub fixtures: Vec<Fixture>,
            /// Core points; their velocity is watched.
            pub cores: Vec<CorePoint>,
            /// Elasticity; `None` for a rigid casting.
            pub elastic: Option<Elastic>,
            /// Nodes of an elastic casting whose velocity is reported too; `None`: the area around its measuring point.
            pub measuring_nodes: Option<WeightedNodes>,
        }
        required {
            /// Mass. For an elastic casting it must be within 1 % of the mass of its matrices.
            pub mass_kg: f64, "kg", [> 0] usual [0.05, 1000], "no default";
        }
        /// Centre of mass in the machine's plane, x and y.
        pub centre_m: [f64; 2], "m", [finite] usual [-20, 20], "default: the mean of its fixtures' points";
        /// Height z of its centre of mass. It matters only where fixtures, hammers or gravity act sideways.
        pub centre_height_m: f64, "m", [finite] usual [-20, 20], "default: the mean of its fixtures' points";
        /// Extent in x and y, centred.
        pub size_m: Option<[f64; 2]>, "m", [> 0] usual [0.01, 10], "default: unlimited, no hammer can miss it";
        /// Moments of inertia about x (rotation `tx`, driven by offsets in y) and y (rotation `ty`, driven by offsets in x).
        pub inertia_kg_m2: Option<[f64; 2]>, "kg m2", [> 0] usual [1e-6, 1e4], "needed only where it can rotate (struck, held or measured off its centre)";
        /// Moment of inertia about z.
        pub inertia_z_kg_m2: Option<f64>, "kg m2", [> 0] usual [1e-6, 1e4], "needed only where it can rotate about z (struck or held sideways)";
        /// Point whose velocity is reported too, x and y from the centre of mass.
        pub measuring_point_m: Option<[f64; 2]>, "m", [finite] usual [-10, 10], "default: at the centre only";
        /// Height of that point above the centre of mass. It matters only for a `measuring_axis` that is not vertical.
        pub measuring_height_m: f64 = 0.0, "m", [finite] usual [-10, 10], "at the height of the centre of mass";
        /// Direction along which its velocities are measured: at the centre of mass, at the measuring point, at core points.
        pub measuring_axis: Option<[f64; 3]>, "1", [finite], "default: the strike axis of the first hammer that strikes it";
        typed_last {
            /// Fixtures by name; at least one.
            pub fixture: IndexMap<String, FixtureEntry>,
            /// Core points by name.
            #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
            pub core: IndexMap<String, CorePointEntry>,
            /// Sand and binder of its cores in your words, e.g. `cold box, 0.8 %`. It changes no row: `decore export` groups rows by it.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub sand_binder: Option<String>,
            /// Nodes of an elastic casting whose velocity is reported too, instead of `measuring_point_m`, in the forms of `strike_nodes`
            /// of a hammer.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub measuring_nodes: Option<NodesEntry>,
            /// Finite element model of an elastic casting. Default: the casting is rigid.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub structure: Option<CastingStructureEntry>,
        }
    }
}

impl Fixture {
    /// Directions in which it can hold: its axis, then two across it.
    pub fn axes(&self) -> [[f64; 3]; 3] {
        let axis = unit(self.axis);
        let [first, second] = across(axis);
        [axis, first, second]
    }

    /// Indices of the [`Self::axes`] in which it holds.
    pub fn held_axes(&self) -> impl Iterator<Item = usize> {
        let lateral = (0..2).filter(|axis| self.friction > 0.0 || self.lateral_spring(*axis) != [0.0, 0.0]);
        let lateral = lateral.map(|axis| 1 + axis);
        std::iter::once(0).chain(lateral)
    }

    /// Stiffness in N/m and damping in N s/m in one of the two directions across its axis.
    pub fn lateral_spring(&self, axis: usize) -> [f64; 2] {
        [self.lateral_stiffness_n_per_m[axis], self.lateral_damping_n_s_per_m[axis]]
    }

    /// Point that it holds, from the casting's centre of mass.
    pub fn place_m(&self) -> [f64; 3] {
        [self.at_m[0], self.at_m[1], self.height_m]
    }

    /// Stiffness in N/m and damping in N s/m with which it acts along its axis.
    pub fn spring(&self) -> [f64; 2] {
        if self.clamp_force_n > 0.0 {
            [self.clamp_stiffness_n_per_m, 0.0]
        } else {
            [self.stiffness_n_per_m, self.damping_n_s_per_m]
        }
    }
}

impl Casting {
    /// Centre of mass in world axes.
    pub fn centre_place_m(&self) -> [f64; 3] {
        [self.centre_m[0], self.centre_m[1], self.centre_height_m]
    }

    /// Measuring point from the centre of mass; the centre itself where none is chosen.
    pub fn measured_place_m(&self) -> [f64; 3] {
        self.measuring_point_m.map_or([0.0; 3], |[x, y]| [x, y, self.measuring_height_m])
    }

    /// Whether some of its fixtures only push.
    pub fn lies(&self) -> bool {
        self.fixtures.iter().any(|fixture| fixture.one_sided)
    }

    /// How far within the casting's extent a line passes, in m: seen from above, the largest distance from the nearest edge, negative if the
    /// line misses the casting; `None` without an extent. The line passes `point_m` (x, y from the centre) along `axis`. If it is vertical,
    /// this is the distance of the point.
    ///
    /// Along the line, at `point_m + t axis`, the distance from an edge is linear in t, so the smallest of the four is largest at a crossing
    /// of two of them.
    pub fn margin_m(&self, point_m: [f64; 2], axis: [f64; 3]) -> Option<f64> {
        let size = self.size_m?;
        let edges = [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)];
        let lines = edges.map(|(x, side)| (0.5 * size[x] - side * point_m[x], -side * axis[x]));
        let margin = |t: f64| lines.iter().map(|(at, slope)| at + slope * t).fold(f64::INFINITY, f64::min);
        let crossings = lines.iter().flat_map(|(a, b)| lines.iter().map(move |(c, d)| (c - a) / (b - d)));
        Some(crossings.filter(|t| t.is_finite()).map(margin).fold(margin(0.0), f64::max))
    }
}

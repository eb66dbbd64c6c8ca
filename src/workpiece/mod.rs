//! Castings and the fixtures that hold them: plain data, rigid-body kinematics in the plane of the table.

/// Inertia of a casting about the two in-plane axes through its centre of mass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inertia {
    /// About x, in kg m2 (rotation `tx`, driven by offsets in y).
    pub x_kg_m2: f64,
    /// About y, in kg m2 (rotation `ty`, driven by offsets in x).
    pub y_kg_m2: f64,
}

/// Spring and damper between a point of a casting and a node of the structure.
#[derive(Debug, Clone, PartialEq)]
pub struct Fixture {
    /// Name as in the study.
    pub name: String,
    /// Interface point of the structure that carries it.
    pub point: String,
    /// Where it holds the casting, x and y from the casting's centre of mass, in m.
    pub at_m: [f64; 2],
    /// Stiffness `k_T` in N/m.
    pub stiffness_n_per_m: f64,
    /// Damping `c_T` in N s/m.
    pub damping_n_s_per_m: f64,
}

/// A rigid casting with the fixtures that carry it.
///
/// The point (x, y) moves by `z + y tx - x ty`.
#[derive(Debug, Clone, PartialEq)]
pub struct Casting {
    /// Name as in the study.
    pub name: String,
    /// Mass in kg.
    pub mass_kg: f64,
    /// Inertias; `None` where no rotation is needed.
    pub inertia: Option<Inertia>,
    /// Position of the centre of mass in the machine's plane, x and y, in m.
    pub centre_m: [f64; 2],
    /// Extent in x and y in m, centred; `None`: unlimited, no hammer can miss it.
    pub size_m: Option<[f64; 2]>,
    /// Where its velocity is also reported, x and y from the centre of mass, in m.
    pub measuring_point_m: Option<[f64; 2]>,
    /// Its fixtures; at least one.
    pub fixtures: Vec<Fixture>,
}

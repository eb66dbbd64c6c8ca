//! Parameters of the housing on its mount, and of the guide between it and the telescope. They have no equations here: a machine adds the
//! housing to its matrices, and a coupled system has the guide's spring among its own.

use crate::parameter::parameters;

parameters! { file
    /// Rigid mass of the hammer housing on its mount point.
    #[derive(Copy)]
    pub struct HousingParameters {
        /// Mass.
        pub mass_kg: f64 = 27.0, "kg", [>= 0] usual [0, 1000], "Fig. 4 of the source";
        /// Moments of inertia about the housing's centre of mass, x, y, z.
        pub inertia_kg_m2: [f64; 3] = [0.55, 0.55, 0.12], "kg m2", [>= 0] usual [0, 100], "assumed";
        /// Centre of mass relative to the mount point, x, y, z.
        pub centre_of_mass_m: [f64; 3] = [0.0, 0.0, -0.2], "m", [finite] usual [-2, 2], "assumed";
    }
}

parameters! { file
    /// Housing guide: a light body on a very stiff spring against the mount (subscript `Gh` in the source).
    #[derive(Copy)]
    pub struct GuideParameters {
        /// Mass `m_Gh`.
        pub mass_kg: f64 = 1.0, "kg", [> 0] usual [0.01, 50], "Table 2";
        /// Mount stiffness `k_Gh`.
        pub stiffness_n_per_m: f64 = 1e10, "N/m", [> 0] usual [1e6, 1e12], "Table 2";
    }
}

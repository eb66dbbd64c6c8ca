//! Parameters of one pneumatic hammer: masses, contacts, telescope, percussion piston, spool valve, bushing.
//!
//! The same structure is the hammer file (TOML) and the data the model reads. Every field has the default of the
//! published hammer or, where the publication is silent, an assumed or calibrated value; the field's text says which.
//! Source of the published values: Mariadass et al., Appl. Mech. 2023, 4, 1206-1226, Table 2 ("Table 2" below).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::contact::ContactParameters;

/// Shorthand for the defaults below.
const fn contact(stiffness_n_per_m: f64, damping_n_s_per_m: f64) -> ContactParameters {
    ContactParameters::kelvin_voigt(stiffness_n_per_m, damping_n_s_per_m)
}

/// All parameters of one hammer.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct HammerParameters {
    /// The rigid housing that the mount carries; it changes the machine's modes.
    pub housing: HousingParameters,
    /// The guide between the housing's mount and the telescope.
    pub guide: GuideParameters,
    /// The telescope: cylinder, return spring, stops, friction, its two chambers.
    pub telescope: TelescopeParameters,
    /// The percussion piston with its two chambers and exhaust ports.
    pub piston: PistonParameters,
    /// The spool valve that feeds the percussion chambers.
    pub valve: ValveParameters,
    /// The chisel and its contacts.
    pub chisel: ChiselParameters,
}

/// Rigid mass of the hammer housing on its mount point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct HousingParameters {
    /// Mass in kg. Default 27 (Fig. 4 of the source).
    pub mass_kg: f64,
    /// Moments of inertia about the housing's centre of mass, x, y, z, in kg m2. Default 0.55, 0.55, 0.12 (assumed).
    pub inertia_kg_m2: [f64; 3],
    /// Centre of mass relative to the mount point, x, y, z, in m. Default 0, 0, -0.2 (assumed).
    pub centre_of_mass_m: [f64; 3],
}

impl Default for HousingParameters {
    fn default() -> Self {
        Self { mass_kg: 27.0, inertia_kg_m2: [0.55, 0.55, 0.12], centre_of_mass_m: [0.0, 0.0, -0.2] }
    }
}

/// Housing guide: a light body on a very stiff spring against the mount (subscript `Gh` in the source).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct GuideParameters {
    /// Mass `m_Gh` in kg. Default 1 (Table 2).
    pub mass_kg: f64,
    /// Mount stiffness `k_Gh` in N/m. Default 1e10 (Table 2).
    pub stiffness_n_per_m: f64,
}

impl Default for GuideParameters {
    fn default() -> Self {
        Self { mass_kg: 1.0, stiffness_n_per_m: 1e10 }
    }
}

/// Telescope between guide and cylinder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TelescopeParameters {
    /// Cylinder mass `m_cb` in kg. Default 6.5 (Table 2).
    pub cylinder_mass_kg: f64,
    /// Bore diameter `D` in m; `A1 = pi D^2 / 4`. Default 0.0564 (calibrated to 70 J).
    pub bore_m: f64,
    /// Annulus area over bore area, `A2 / A1`. Default 0.35 (assumed).
    pub annulus_area_ratio: f64,
    /// Clearance of the top chamber in m: `V10 = clearance A1 + dead volume`. Default 0.01 (assumed).
    pub top_clearance_m: f64,
    /// Dead volume of the top chamber in m3. Default 3e-5 (assumed).
    pub top_dead_volume_m3: f64,
    /// Length of the annulus chamber at rest in m: `V20 = length A2`. Default 0.16 (assumed).
    pub annulus_length_m: f64,
    /// Effective inlet area `A_in1` in m2, discharge coefficient included. Default 3e-5 (assumed).
    pub inlet_area_m2: f64,
    /// Effective vent area `A_v2` of the annulus in m2. Default 6e-5 (assumed).
    pub vent_area_m2: f64,
    /// Top stop `k_u`, `c_u`. Default 1.633e4 N/m, 1.633 N s/m (Table 2; one-sided: assumed).
    pub top_stop: ContactParameters,
    /// End of stroke `k_end`, `c_end`. Default 1e7 N/m, 2000 N s/m (assumed).
    pub end_stop: ContactParameters,
    /// Stroke `L_tel` in m, at which the end stop begins. Default 0.130 (assumed).
    pub stroke_m: f64,
    /// Return spring stiffness `k_l` in N/m. Default 1.633e3 (Table 2).
    pub spring_stiffness_n_per_m: f64,
    /// Return spring damping `c_l` in N s/m. Default 0.1633 (Table 2).
    pub spring_damping_n_s_per_m: f64,
    /// Return spring preload `F0` in N. Default 140 (assumed).
    pub spring_preload_n: f64,
    /// Seal friction `f_s` in N: `f_s tanh(v / v_s) + f_v v + f_d H v`. Default 40 (assumed).
    pub friction_static_n: f64,
    /// Friction velocity `v_s` in m/s. Default 0.01 (assumed).
    pub friction_velocity_m_s: f64,
    /// Viscous friction `f_v` in N s/m. Default 20 (assumed).
    pub friction_viscous_n_s_per_m: f64,
    /// Direction-dependent friction `f_d` in N s/m. Default 10 (assumed).
    pub friction_directional_n_s_per_m: f64,
    /// Share `u1` of `f_d` while retracting (`v <= 0`). Default 1 (assumed).
    pub retracting_share: f64,
    /// Share `u2` of `f_d` while extending (`v > 0`). Default 0.2 (assumed).
    pub extending_share: f64,
}

impl Default for TelescopeParameters {
    fn default() -> Self {
        Self {
            cylinder_mass_kg: 6.5,
            bore_m: 0.0564,
            annulus_area_ratio: 0.35,
            top_clearance_m: 0.01,
            top_dead_volume_m3: 3e-5,
            annulus_length_m: 0.16,
            inlet_area_m2: 3e-5,
            vent_area_m2: 6e-5,
            top_stop: contact(1.633e4, 1.633),
            end_stop: contact(1e7, 2000.0),
            stroke_m: 0.130,
            spring_stiffness_n_per_m: 1.633e3,
            spring_damping_n_s_per_m: 0.1633,
            spring_preload_n: 140.0,
            friction_static_n: 40.0,
            friction_velocity_m_s: 0.01,
            friction_viscous_n_s_per_m: 20.0,
            friction_directional_n_s_per_m: 10.0,
            retracting_share: 1.0,
            extending_share: 0.2,
        }
    }
}

/// Percussion piston and its chambers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PistonParameters {
    /// Mass `m_p` in kg. Default 0.4546 (Table 2).
    pub mass_kg: f64,
    /// Bore diameter in m; `A3 = pi D^2 / 4`. Default 0.029 (calibrated).
    pub bore_m: f64,
    /// Front area over rear area, `A4 / A3`. Default 0.9 (calibrated).
    pub front_area_ratio: f64,
    /// Stroke in m: where the piston meets the chisel's head when the chisel rests at the nose. Default 0.126 (calibrated).
    pub stroke_m: f64,
    /// Length `L_p` of the percussion chamber in m. Default 0.146 (calibrated).
    pub chamber_length_m: f64,
    /// Clearance of the rear chamber in m: `V30 = clearance A3`. Default 0.012 (assumed).
    pub rear_clearance_m: f64,
    /// Clearance of the front chamber in m of rear bore: `V40 = clearance A3`. Default 0.012 (assumed).
    pub front_clearance_m: f64,
    /// Piston position `p_rear` in m at which the rear exhaust port begins to open. Default 0.078 (assumed).
    pub rear_port_m: f64,
    /// Piston position `p_front` in m below which the front exhaust port opens. Default 0.053 (assumed).
    pub front_port_m: f64,
    /// Width `w` of the exhaust ports in m. Default 0.004 (assumed).
    pub port_width_m: f64,
    /// Effective exhaust area `A_xr` of the rear chamber in m2. Default 6e-5 (calibrated).
    pub rear_exhaust_area_m2: f64,
    /// Effective exhaust area `A_xf` of the front chamber in m2. Default 6e-5 (calibrated).
    pub front_exhaust_area_m2: f64,
    /// Viscous friction `f_p` in N s/m. Default 2 (assumed).
    pub friction_viscous_n_s_per_m: f64,
    /// Rear wall of the cylinder `k_p_cb`, `c_p_cb`. Default 2e7 N/m, 2000 N s/m (Table 2).
    pub rear_wall: ContactParameters,
    /// Piston on chisel `k_p_h`, `c_p_h`. Default 5.971e8 N/m, 1500 N s/m (Table 2).
    pub chisel_contact: ContactParameters,
}

impl Default for PistonParameters {
    fn default() -> Self {
        Self {
            mass_kg: 0.4546,
            bore_m: 0.029,
            front_area_ratio: 0.9,
            stroke_m: 0.126,
            chamber_length_m: 0.146,
            rear_clearance_m: 0.012,
            front_clearance_m: 0.012,
            rear_port_m: 0.0780,
            front_port_m: 0.0530,
            port_width_m: 0.004,
            rear_exhaust_area_m2: 6e-5,
            front_exhaust_area_m2: 6e-5,
            friction_viscous_n_s_per_m: 2.0,
            rear_wall: contact(2e7, 2000.0),
            chisel_contact: contact(5.971e8, 1500.0),
        }
    }
}

/// Spool valve: at `s = 0` it feeds the rear chamber, at `s = s_max` the front one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ValveParameters {
    /// Mass `m_sv` in kg. Default 0.074 (Table 2).
    pub mass_kg: f64,
    /// Control area `A_s` in m2. Default 1.5e-4 (assumed).
    pub area_m2: f64,
    /// Travel `s_max` in m. Default 0.004 (assumed).
    pub travel_m: f64,
    /// Share `phi` of the supply over-pressure that drives the spool. Default 0.5 (assumed).
    pub supply_share: f64,
    /// Effective feed area `A_fr` of the rear chamber in m2. Default 8.35e-6 (calibrated).
    pub rear_feed_area_m2: f64,
    /// Effective feed area `A_ff` of the front chamber in m2. Default 2.8e-6 (calibrated).
    pub front_feed_area_m2: f64,
    /// Viscous friction `f_sv` in N s/m. Default 2 (assumed).
    pub friction_viscous_n_s_per_m: f64,
    /// Both spool stops `k_sv_cb`, `c_sv_cb`. Default 1.0121e7 N/m, 1650 N s/m (Table 2).
    pub stop: ContactParameters,
}

impl Default for ValveParameters {
    fn default() -> Self {
        Self {
            mass_kg: 0.074,
            area_m2: 1.5e-4,
            travel_m: 0.004,
            supply_share: 0.5,
            rear_feed_area_m2: 8.35e-6,
            front_feed_area_m2: 2.8e-6,
            friction_viscous_n_s_per_m: 2.0,
            stop: contact(1.0121e7, 1650.0),
        }
    }
}

/// Chisel: bushing, nose, retainer, contact with the casting.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ChiselParameters {
    /// Mass `m_h` in kg. Default 1.8157 (Table 2).
    pub mass_kg: f64,
    /// Free travel `c_ret` between nose and retainer in m. Default 0.012 (assumed).
    pub travel_m: f64,
    /// Bushing friction `f_h` in N s/m. Default 5 (assumed).
    pub friction_viscous_n_s_per_m: f64,
    /// Nose and retainer `k_cb_h`, `c_cb_h`. Default 6.06e8 N/m, 1052 N s/m (Table 2).
    pub cylinder_contact: ContactParameters,
    /// Chisel on casting `k_h_g`, `c_h_g`. Default 2.95e8 N/m, 500 N s/m (Table 2).
    pub casting_contact: ContactParameters,
}

impl Default for ChiselParameters {
    fn default() -> Self {
        Self {
            mass_kg: 1.8157,
            travel_m: 0.012,
            friction_viscous_n_s_per_m: 5.0,
            cylinder_contact: contact(6.06e8, 1052.0),
            casting_contact: contact(2.95e8, 500.0),
        }
    }
}

//! Parameters of one pneumatic hammer: masses, contacts, telescope, percussion piston, spool valve, bushing.
//!
//! The same structure is the hammer file (TOML) and the data the model reads. Every field has the default of the
//! published hammer or, where the publication is silent, an assumed or calibrated value; the field's text says which.
//! Source of the published values: Mariadass et al., Appl. Mech. 2023, 4, 1206-1226, Table 2 ("Table 2" below).

use crate::contact::{ContactParameters, kelvin_voigt};
use crate::parameter::parameters;

parameters! { file
    /// All parameters of one hammer.
    #[derive(Copy)]
    pub struct HammerParameters {
        /// The rigid housing that the mount carries; it changes the machine's modes.
        pub housing: HousingParameters, "", [group], "";
        /// The guide between the housing's mount and the telescope.
        pub guide: GuideParameters, "", [group], "";
        /// The telescope: cylinder, return spring, stops, friction, its two chambers.
        pub telescope: TelescopeParameters, "", [group], "";
        /// The percussion piston with its two chambers and exhaust ports.
        pub piston: PistonParameters, "", [group], "";
        /// The spool valve that feeds the percussion chambers.
        pub valve: ValveParameters, "", [group], "";
        /// The chisel and its contacts.
        pub chisel: ChiselParameters, "", [group], "";
    }
}

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

parameters! { file
    /// Telescope between guide and cylinder.
    #[derive(Copy)]
    pub struct TelescopeParameters {
        /// Cylinder mass `m_cb`.
        pub cylinder_mass_kg: f64 = 6.5, "kg", [> 0] usual [0.1, 100], "Table 2";
        /// Bore diameter `D`; `A1 = pi D^2 / 4`.
        pub bore_m: f64 = 0.0564, "m", [> 0] usual [0.005, 0.3], "calibrated to 70 J";
        /// Annulus area over bore area, `A2 / A1`.
        pub annulus_area_ratio: f64 = 0.35, "1", [> 0] usual [0.05, 1], "assumed";
        /// Clearance of the top chamber: `V10 = clearance A1 + dead volume`.
        pub top_clearance_m: f64 = 0.01, "m", [> 0] usual [1e-4, 0.2], "assumed";
        /// Dead volume of the top chamber.
        pub top_dead_volume_m3: f64 = 3e-5, "m3", [>= 0] usual [0, 0.01], "assumed";
        /// Length of the annulus chamber at rest: `V20 = length A2`.
        pub annulus_length_m: f64 = 0.16, "m", [> 0] usual [0.01, 2], "assumed";
        /// Effective inlet area `A_in1`, discharge coefficient included.
        pub inlet_area_m2: f64 = 3e-5, "m2", [> 0] usual [1e-7, 0.01], "assumed";
        /// Effective vent area `A_v2` of the annulus.
        pub vent_area_m2: f64 = 6e-5, "m2", [> 0] usual [1e-7, 0.01], "assumed";
        /// Top stop `k_u`, `c_u`.
        pub top_stop: ContactParameters = kelvin_voigt(1.633e4, 1.633), "N/m, N s/m", [group], "Table 2; one-sided: assumed";
        /// End of stroke `k_end`, `c_end`.
        pub end_stop: ContactParameters = kelvin_voigt(1e7, 2000.0), "N/m, N s/m", [group], "assumed";
        /// Stroke `L_tel`, at which the end stop begins.
        pub stroke_m: f64 = 0.130, "m", [> 0] usual [0.005, 1], "assumed";
        /// Return spring stiffness `k_l`.
        pub spring_stiffness_n_per_m: f64 = 1.633e3, "N/m", [> 0] usual [10, 1e6], "Table 2";
        /// Return spring damping `c_l`.
        pub spring_damping_n_s_per_m: f64 = 0.1633, "N s/m", [>= 0] usual [0, 1e4], "Table 2";
        /// Return spring preload `F0`.
        pub spring_preload_n: f64 = 140.0, "N", [>= 0] usual [0, 1e4], "assumed";
        /// Seal friction `f_s`: `f_s tanh(v / v_s) + f_v v + f_d H v`.
        pub friction_static_n: f64 = 40.0, "N", [>= 0] usual [0, 1e4], "assumed";
        /// Friction velocity `v_s`.
        pub friction_velocity_m_s: f64 = 0.01, "m/s", [> 0] usual [1e-4, 1], "assumed";
        /// Viscous friction `f_v`.
        pub friction_viscous_n_s_per_m: f64 = 20.0, "N s/m", [>= 0] usual [0, 1e4], "assumed";
        /// Direction-dependent friction `f_d`.
        pub friction_directional_n_s_per_m: f64 = 10.0, "N s/m", [>= 0] usual [0, 1e4], "assumed";
        /// Share `u1` of `f_d` while retracting (`v <= 0`).
        pub retracting_share: f64 = 1.0, "1", [>= 0] usual [0, 10], "assumed";
        /// Share `u2` of `f_d` while extending (`v > 0`).
        pub extending_share: f64 = 0.2, "1", [>= 0] usual [0, 10], "assumed";
    }
}

parameters! { file
    /// Percussion piston and its chambers.
    #[derive(Copy)]
    pub struct PistonParameters {
        /// Mass `m_p`.
        pub mass_kg: f64 = 0.4546, "kg", [> 0] usual [0.01, 20], "Table 2";
        /// Bore diameter; `A3 = pi D^2 / 4`.
        pub bore_m: f64 = 0.029, "m", [> 0] usual [0.005, 0.3], "calibrated";
        /// Front area over rear area, `A4 / A3`.
        pub front_area_ratio: f64 = 0.9, "1", [> 0] usual [0.2, 1.5], "calibrated";
        /// Stroke: where the piston meets the chisel's head when the chisel rests at the nose.
        pub stroke_m: f64 = 0.126, "m", [> 0] usual [0.005, 1], "calibrated";
        /// Length `L_p` of the percussion chamber.
        pub chamber_length_m: f64 = 0.146, "m", [> 0] usual [0.01, 1], "calibrated";
        /// Clearance of the rear chamber: `V30 = clearance A3`.
        pub rear_clearance_m: f64 = 0.012, "m", [> 0] usual [1e-4, 0.2], "assumed";
        /// Clearance of the front chamber, along the rear bore: `V40 = clearance A3`.
        pub front_clearance_m: f64 = 0.012, "m", [> 0] usual [1e-4, 0.2], "assumed";
        /// Piston position `p_rear` at which the rear exhaust port begins to open.
        pub rear_port_m: f64 = 0.0780, "m", [>= 0] usual [0, 1], "assumed";
        /// Piston position `p_front` below which the front exhaust port opens.
        pub front_port_m: f64 = 0.0530, "m", [>= 0] usual [0, 1], "assumed";
        /// Width `w` of the exhaust ports.
        pub port_width_m: f64 = 0.004, "m", [> 0] usual [1e-4, 0.1], "assumed";
        /// Effective exhaust area `A_xr` of the rear chamber.
        pub rear_exhaust_area_m2: f64 = 6e-5, "m2", [> 0] usual [1e-7, 0.01], "calibrated";
        /// Effective exhaust area `A_xf` of the front chamber.
        pub front_exhaust_area_m2: f64 = 6e-5, "m2", [> 0] usual [1e-7, 0.01], "calibrated";
        /// Viscous friction `f_p`.
        pub friction_viscous_n_s_per_m: f64 = 2.0, "N s/m", [>= 0] usual [0, 1000], "assumed";
        /// Rear wall of the cylinder `k_p_cb`, `c_p_cb`.
        pub rear_wall: ContactParameters = kelvin_voigt(2e7, 2000.0), "N/m, N s/m", [group], "Table 2";
        /// Piston on chisel `k_p_h`, `c_p_h`.
        pub chisel_contact: ContactParameters = kelvin_voigt(5.971e8, 1500.0), "N/m, N s/m", [group], "Table 2";
    }
}

parameters! { file
    /// Spool valve: at `s = 0` it feeds the rear chamber, at `s = s_max` the front one.
    #[derive(Copy)]
    pub struct ValveParameters {
        /// Mass `m_sv`.
        pub mass_kg: f64 = 0.074, "kg", [> 0] usual [0.001, 5], "Table 2";
        /// Control area `A_s`.
        pub area_m2: f64 = 1.5e-4, "m2", [> 0] usual [1e-6, 0.01], "assumed";
        /// Travel `s_max`.
        pub travel_m: f64 = 0.004, "m", [> 0] usual [1e-4, 0.1], "assumed";
        /// Share `phi` of the supply over-pressure that drives the spool.
        pub supply_share: f64 = 0.5, "1", [> 0] usual [0.01, 2], "assumed";
        /// Effective feed area `A_fr` of the rear chamber.
        pub rear_feed_area_m2: f64 = 8.35e-6, "m2", [> 0] usual [1e-8, 0.001], "calibrated";
        /// Effective feed area `A_ff` of the front chamber.
        pub front_feed_area_m2: f64 = 2.8e-6, "m2", [> 0] usual [1e-8, 0.001], "calibrated";
        /// Viscous friction `f_sv`.
        pub friction_viscous_n_s_per_m: f64 = 2.0, "N s/m", [>= 0] usual [0, 1000], "assumed";
        /// Both spool stops `k_sv_cb`, `c_sv_cb`.
        pub stop: ContactParameters = kelvin_voigt(1.0121e7, 1650.0), "N/m, N s/m", [group], "Table 2";
    }
}

parameters! { file
    /// Chisel: bushing, nose, retainer, contact with the casting.
    #[derive(Copy)]
    pub struct ChiselParameters {
        /// Mass `m_h`.
        pub mass_kg: f64 = 1.8157, "kg", [> 0] usual [0.05, 50], "Table 2";
        /// Free travel `c_ret` between nose and retainer.
        pub travel_m: f64 = 0.012, "m", [> 0] usual [1e-4, 0.2], "assumed";
        /// Bushing friction `f_h`.
        pub friction_viscous_n_s_per_m: f64 = 5.0, "N s/m", [>= 0] usual [0, 1e4], "assumed";
        /// Nose and retainer `k_cb_h`, `c_cb_h`.
        pub cylinder_contact: ContactParameters = kelvin_voigt(6.06e8, 1052.0), "N/m, N s/m", [group], "Table 2";
        /// Chisel on casting `k_h_g`, `c_h_g`.
        pub casting_contact: ContactParameters = kelvin_voigt(2.95e8, 500.0), "N/m, N s/m", [group], "Table 2";
    }
}

/// Stiffness of a guide's spring over that of the hammer's stiffest contact from which the guide may be tied. The error of the tie
/// falls with the stiffness; on the paper's rig (a ratio of 16) it is 1e-6 of the first impact's energy, 1e-5 of the arm's velocity.
const RIGID_STIFFNESS_RATIO: f64 = 10.0;
/// Frequency of a guide on its spring over that of the fastest contact from which the guide may be tied.
const RIGID_FREQUENCY_RATIO: f64 = 2.0;

impl HammerParameters {
    /// Whether the guide's spring is so stiff, and the guide on it so fast, beside the contacts that the guide moves with its
    /// mount for every purpose: a spring ten times as stiff as the stiffest of them, a frequency `sqrt(k/m)` twice that of the
    /// fastest, `sqrt(k (1/m1 + 1/m2))` with the masses of the bodies that meet.
    pub fn guide_is_rigid(&self) -> bool {
        let (cylinder, piston) = (1.0 / self.telescope.cylinder_mass_kg, 1.0 / self.piston.mass_kg);
        let (spool, chisel) = (1.0 / self.valve.mass_kg, 1.0 / self.chisel.mass_kg);
        let contacts = [
            (&self.piston.rear_wall, piston + cylinder),
            (&self.piston.chisel_contact, piston + chisel),
            (&self.valve.stop, spool + cylinder),
            (&self.chisel.cylinder_contact, chisel + cylinder),
            (&self.chisel.casting_contact, chisel),
            (&self.telescope.end_stop, cylinder),
        ];
        let stiffest = contacts.iter().map(|(contact, _)| contact.stiffness_n_per_m).fold(0.0, f64::max);
        let fastest = contacts.iter().map(|(contact, mass)| contact.stiffness_n_per_m * mass).fold(0.0, f64::max);
        let guide = &self.guide;
        guide.stiffness_n_per_m >= RIGID_STIFFNESS_RATIO * stiffest
            && guide.stiffness_n_per_m / guide.mass_kg >= RIGID_FREQUENCY_RATIO.powi(2) * fastest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The published guide is rigid beside its hammer; a softer or a heavier one, or one beside a stiffer contact, is not.
    #[test]
    fn analytic_rigid_guides() {
        let with = |change: &dyn Fn(&mut HammerParameters)| {
            let mut hammer = HammerParameters::default();
            change(&mut hammer);
            hammer.guide_is_rigid()
        };
        assert!(with(&|_| ()));
        // Ten times 6.06e8 N/m (chisel in its nose).
        assert!(with(&|hammer| hammer.guide.stiffness_n_per_m = 6.57e9));
        assert!(!with(&|hammer| (hammer.guide.stiffness_n_per_m, hammer.guide.mass_kg) = (6.05e9, 0.1)));
        // Four times 5.971e8 N/m (1/0.4546 kg + 1/1.8157 kg) = 6.57e9 1/s2.
        assert!(!with(&|hammer| hammer.guide.stiffness_n_per_m = 6.56e9));
        assert!(with(&|hammer| hammer.guide.mass_kg = 1.52));
        assert!(!with(&|hammer| hammer.guide.mass_kg = 1.53));
        assert!(!with(&|hammer| hammer.chisel.casting_contact.stiffness_n_per_m = 1.01e9));
    }
}

//! The telescope between guide and cylinder: parameters, gas, return spring and friction, equilibrium. `e = x_cb - x_Gh`.

use super::chambers::{ChamberFlows, Chambers, GasConstants, bore_area};
use super::state::{HammerRates, HammerState, body, chamber};
use crate::contact::{ContactParameters, kelvin_voigt};
use crate::parameter::parameters;
use decore_math::number::{Number, per_lane, tanh};

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

impl TelescopeParameters {
    /// Extension `e0` at rest in m under the weight `hanging_n` in N: the root of
    /// `N_u(-e0) = N_end(e0 - L_tel) + F0 + k_l e0 - W`.
    ///
    /// A preload above the weight that hangs on the cylinder holds it against the top stop; a smaller one lets it hang on the
    /// return spring, or rest on the end stop where that lies higher. No stop pulls.
    pub(super) fn rest_extension(&self, hanging_n: f64) -> f64 {
        let (held, stiffness) = (self.spring_preload_n - hanging_n, self.spring_stiffness_n_per_m);
        let stop = |contact: &ContactParameters, force: f64| {
            contact.law(self.cylinder_mass_kg).static_penetration(force, stiffness)
        };
        let hanging = -held / stiffness;
        if held >= 0.0 {
            -stop(&self.top_stop, held)
        } else if hanging <= self.stroke_m {
            hanging
        } else {
            self.stroke_m + stop(&self.end_stop, -held - stiffness * self.stroke_m)
        }
    }

    /// Energy stored in the return spring at extension `extension_m`, in J: `F0 e + k_l e^2 / 2`.
    pub(super) fn return_spring_energy(&self, extension_m: f64) -> f64 {
        (self.spring_preload_n + 0.5 * self.spring_stiffness_n_per_m * extension_m) * extension_m
    }
}

per_lane! {
    /// Constants of one telescope, or of one in each lane.
    pub(super) struct TelescopeConstants<R> {
        /// Areas `A1`, `A2` in m2.
        area_m2: [R; 2],
        /// Volumes `V10`, `V20` in m3.
        volume_m3: [R; 2],
        inlet_area_m2: R,
        vent_area_m2: R,
        spring_preload_n: R,
        spring_stiffness_n_per_m: R,
        friction_static_n: R,
        inverse_friction_velocity_s_per_m: R,
        /// Viscous resistance, including the spring's, retracting and extending.
        resistance_n_s_per_m: [R; 2],
    }
}

impl TelescopeConstants<f64> {
    pub(super) fn new(parameters: &TelescopeParameters) -> Self {
        let p = parameters;
        let top = bore_area(p.bore_m);
        let annulus = p.annulus_area_ratio * top;
        let resistance = |share: f64| {
            p.friction_viscous_n_s_per_m + p.friction_directional_n_s_per_m * share + p.spring_damping_n_s_per_m
        };
        Self {
            area_m2: [top, annulus],
            volume_m3: [p.top_clearance_m * top + p.top_dead_volume_m3, p.annulus_length_m * annulus],
            inlet_area_m2: p.inlet_area_m2,
            vent_area_m2: p.vent_area_m2,
            spring_preload_n: p.spring_preload_n,
            spring_stiffness_n_per_m: p.spring_stiffness_n_per_m,
            friction_static_n: p.friction_static_n,
            inverse_friction_velocity_s_per_m: 1.0 / p.friction_velocity_m_s,
            resistance_n_s_per_m: [resistance(p.retracting_share), resistance(p.extending_share)],
        }
    }
}

/// Extension in m of positions, its rate in m/s of velocities.
#[inline(always)]
fn extension<R: Number>(of: &[R; body::COUNT]) -> R {
    of[body::CYLINDER] - of[body::GUIDE]
}

impl<R: Number> TelescopeConstants<R> {
    /// Adds gas, return spring and friction: they act on the cylinder and react on the guide.
    #[inline(always)]
    pub(super) fn add_forces(&self, state: &HammerState<R>, ambient_pa: R, rates: &mut HammerRates<R>) {
        let (e, rate) = (extension(&state.position), extension(&state.velocity));
        let gas = (state.pressure[chamber::TOP] - ambient_pa) * self.area_m2[0]
            - (state.pressure[chamber::ANNULUS] - ambient_pa) * self.area_m2[1];
        let [retracting, extending] = self.resistance_n_s_per_m;
        let resistance = R::select(rate.less_equal(R::splat(0.0)), retracting, extending);
        let friction = self.friction_static_n * tanh(rate * self.inverse_friction_velocity_s_per_m) + resistance * rate;
        let force = gas - (self.spring_preload_n + self.spring_stiffness_n_per_m * e) - friction;
        rates.push(body::CYLINDER, body::GUIDE, force);
        rates.power_in_w += gas * rate;
        rates.dissipation_w += friction * rate;
    }

    /// Volumes of top and annulus in m3.
    #[inline(always)]
    pub(super) fn volumes(&self, position: &[R; body::COUNT]) -> [R; 2] {
        let e = extension(position);
        [self.volume_m3[0] + self.area_m2[0] * e, self.volume_m3[1] - self.area_m2[1] * e]
    }

    /// Rates of the volumes of top and annulus in m3/s.
    #[inline(always)]
    pub(super) fn volume_rates(&self, velocity: &[R; body::COUNT]) -> [R; 2] {
        let rate = extension(velocity);
        [self.area_m2[0] * rate, -self.area_m2[1] * rate]
    }

    /// Flows of top and annulus.
    #[inline(always)]
    pub(super) fn flows(&self, gas: &GasConstants<R>, chambers: &Chambers<'_, R>) -> [ChamberFlows<R>; 2] {
        let [top, annulus] = [chambers.pressure[chamber::TOP], chambers.pressure[chamber::ANNULUS]];
        let inlet = gas.flow.mass_flow(chambers.supply, top, self.inlet_area_m2);
        let vent = gas.flow.mass_flow(annulus, gas.ambient, self.vent_area_m2);
        [
            ChamberFlows { supply_kg_s: inlet, energy_w: gas.energy(inlet) },
            ChamberFlows { supply_kg_s: R::splat(0.0), energy_w: gas.energy(-vent) },
        ]
    }
}

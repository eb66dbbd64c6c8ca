//! The scene and its parts.

use serde::Serialize;

use super::overrides::ParameterOverrides;
use super::solver::{Guide, NumericalTwin, SolverSettings};
use crate::direction::{DOWN, is_down, unit};
use crate::hammer::{HammerParameters, choked_flow};
use crate::parameter::parameters;
use crate::structure::{NodesEntry, WeightedNodes};
use crate::workpiece::Casting;

parameters! { file
    /// Gas, surroundings and gravity.
    #[derive(Copy)]
    pub struct Environment {
        /// Specific gas constant `R`.
        pub gas_constant_j_per_kg_k: f64 = 287.05, "J/(kg K)", [> 0] usual [50, 5000], "dry air";
        /// Gas temperature `T`.
        pub temperature_k: f64 = 293.15, "K", [> 0] usual [200, 450], "20 degrees Celsius";
        /// Isentropic exponent `kappa`.
        pub isentropic_exponent: f64 = 1.4, "1", [> 1] usual [1.05, 1.7], "air";
        /// Ambient pressure.
        pub ambient_pressure_pa: f64 = 101325.0, "Pa", [> 0] usual [1e4, 3e5], "standard atmosphere";
        /// Gravity.
        pub gravity_m_s2: f64 = 9.80665, "m/s2", [>= 0] usual [0, 30], "standard gravity";
        /// Direction of gravity in world axes: x forward, y lateral, z up. Its length does not matter.
        #[serde(skip_serializing_if = "is_down")]
        pub gravity_axis: [f64; 3] = DOWN, "1", [finite], "downwards";
        /// Exponent `a_in` of inflow.
        pub inflow_exponent: f64 = 1.4, "1", [> 0] usual [0.8, 2], "Richer and Hurmuzlu";
        /// Exponent `a_out` of outflow.
        pub outflow_exponent: f64 = 1.0, "1", [> 0] usual [0.5, 2], "Richer and Hurmuzlu";
        /// Exponent `a` of expansion.
        pub expansion_exponent: f64 = 1.2, "1", [> 0] usual [0.8, 2], "Richer and Hurmuzlu";
    }
}

/// Mount of a hammer: a weighted set of interface points (one, or two neighbours of a rail).
///
/// The same weights carry mass, force and motion, so the receptance stays symmetric.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Mount {
    /// Interface points and their weights; the weights sum to 1.
    pub points: Vec<(String, f64)>,
}

impl Mount {
    /// Position x, y, z in m: the weighted mean of its points. `None` if `position_of` does not know one.
    pub fn position_m(&self, position_of: impl Fn(&str) -> Option<[f64; 3]>) -> Option<[f64; 3]> {
        let mut mean = [0.0; 3];
        for (name, weight) in &self.points {
            for (sum, value) in mean.iter_mut().zip(position_of(name)?) {
                *sum += weight * value;
            }
        }
        Some(mean)
    }
}

impl Environment {
    /// Gravity in m/s2 along a unit vector.
    pub fn gravity_along(&self, direction: [f64; 3]) -> f64 {
        self.gravity_m_s2 * crate::direction::dot(unit(self.gravity_axis), direction)
    }
}

impl HammerUnit {
    /// Unit vector in which it strikes.
    pub fn axis(&self) -> [f64; 3] {
        unit(self.strike_axis)
    }

    /// Key of the study that gives its strike point.
    pub fn strike_key(&self) -> &'static str {
        if self.strike_nodes.is_some() { "strike_nodes" } else { "strike_point_m" }
    }

    /// Strike point from the casting's centre of mass.
    pub fn strike_place_m(&self) -> [f64; 3] {
        [self.strike_point_m[0], self.strike_point_m[1], self.strike_height_m]
    }

    /// Choked flow of `gas` through the larger feed of its valve at supply pressure, in kg/s: it takes no more.
    pub fn largest_air_flow_kg_s(&self, gas: &Environment) -> f64 {
        let valve = &self.parameters.valve;
        let area_m2 = valve.rear_feed_area_m2.max(valve.front_feed_area_m2);
        let energy_j_per_kg = gas.gas_constant_j_per_kg_k * gas.temperature_k;
        choked_flow(gas.isentropic_exponent, energy_j_per_kg, self.supply_pressure_pa, area_m2)
    }
}

parameters! {
    /// The supply of a hammer as a study states it: by its pressure above ambient.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize)]
    pub struct Supply {
        /// Supply pressure above ambient (gauge).
        pub supply_bar: f64 = 5.0, "bar", [>= 0] usual [0.5, 16], "the paper's rig";
    }
}

/// One bar in Pa.
const BAR_PA: f64 = 1e5;

impl Supply {
    /// Absolute pressure in Pa.
    pub fn pressure_pa(self, environment: &Environment) -> f64 {
        environment.ambient_pressure_pa + BAR_PA * self.supply_bar
    }

    /// Supply of a hammer.
    pub fn of(hammer: &HammerUnit, environment: &Environment) -> Self {
        Self { supply_bar: (hammer.supply_pressure_pa - environment.ambient_pressure_pa) / BAR_PA }
    }
}

parameters! {
    /// One hammer.
    #[derive(Serialize)]
    pub struct HammerUnit from HammerEntry with Supply {
        own {
            /// Name as in the study.
            pub name: String,
            /// Parameters, with overrides.
            pub parameters: HammerParameters,
            /// Supply pressure, absolute, in Pa; see [`Supply`].
            pub supply_pressure_pa: f64,
            /// Place on the machine.
            pub mount: Mount,
            /// Index of the casting that it strikes.
            pub casting: usize,
            /// Nodes of an elastic casting that it strikes; `None`: the area around its strike point.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub strike_nodes: Option<WeightedNodes>,
        }
        typed {
            /// Hammer file (TOML), relative to the study. Default: the built-in hammer.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub file: Option<String>,
            /// Interface point that carries the hammer; or give `rail` and `rail_position_m`.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub mount: Option<String>,
            /// Rail that carries the hammer.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub rail: Option<String>,
            /// Position along the rail in m: arc length from the rail's middle, positive towards its last point.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub rail_position_m: Option<f64>,
            /// Casting that the hammer strikes. Default: the only one.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub casting: Option<String>,
            /// As in [`Supply`].
            #[serde(skip_serializing_if = "Option::is_none")]
            pub supply_bar: Option<f64>,
            /// Nodes of an elastic casting that it strikes, instead of `strike_point_m`: `12`, `[12, 13]` or
            /// `{ nodes = [12, 13], weights = [1, 2] }`. Without weights all nodes have the same.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub strike_nodes: Option<NodesEntry>,
        }
        /// Distance of the chisel's tip from the casting at rest.
        pub standoff_m: f64 = 0.085, "m", [>= 0] usual [0, 0.5], "the paper's rig";
        /// Time `t_on` at which the supply is switched on.
        pub start_time_s: f64 = 0.002, "s", [>= 0] usual [0, 60], "the paper's rig";
        /// Times, in ascending order after the start, at which the supply is switched off, on again, off, and so on. While it is off the
        /// supply line is vented: its pressure is the ambient one, and the percussion stops; When it is on again, the hammer starts from
        /// the beginning, with percussion `tau_gate` after the next contact. Empty: on for good.
        pub supply_switch_times_s: Vec<f64> = Vec::new(), "s", [finite] usual [0, 100], "on for good";
        /// Time `tau_gate` from the first chisel-casting contact to the start of the percussion.
        pub gate_delay_s: f64 = 0.020, "s", [>= 0] usual [0, 1], "the paper's rig";
        /// Strike point, x and y from the casting's centre of mass.
        pub strike_point_m: [f64; 2], "m", [finite] usual [-10, 10], "default: below the mount";
        /// Direction in which it strikes, in world axes: x forward, y lateral, z up. Its length does not matter.
        pub strike_axis: [f64; 3] = DOWN, "1", [finite], "vertical, downwards";
        /// Height of the strike point above the casting's centre of mass. It matters only for a `strike_axis` that is not vertical.
        pub strike_height_m: f64, "m", [finite] usual [-10, 10], "default: on the axis of the hammer";
        typed_last {
            /// Values that differ from the hammer file's, in the same layout.
            #[serde(default, skip_serializing_if = "ParameterOverrides::is_empty")]
            pub parameters: ParameterOverrides,
        }
    }
}

parameters! { file
    /// Windows and thresholds of the outputs (defaults: the definitions of the outputs).
    pub struct OutputSettings {
        own {
            /// Signals that a sweep keeps in its table `signals`, by the names that `decore scene --signals` gives them, e.g.
            /// `left_extension_m`. Each value is the mean over `signal_interval_s` around its instant. Default: none.
            #[serde(skip_serializing_if = "Vec::is_empty")]
            pub signals: Vec<String>,
            /// Further interface points of the structure, whose vertical motion is among the signals, e.g. `point_R3_velocity_m_s`.
            /// The reduction keeps them and the selection of modes considers them: a row's other values change by less than the
            /// tolerances of both allow. Default: none.
            #[serde(skip_serializing_if = "Vec::is_empty")]
            pub points: Vec<String>,
            /// Rows whose signals are kept. Default: all rows.
            #[serde(skip_serializing_if = "Vec::is_empty")]
            pub signal_rows: Vec<u64>,
            /// Whether shock spectra and doses are computed at the core points of the castings. Default false.
            #[serde(skip_serializing_if = "std::ops::Not::not")]
            pub core_spectra: bool,
            /// Whether the energy through each fixture is computed. It is read off the steps and costs no state. Default false.
            #[serde(skip_serializing_if = "std::ops::Not::not")]
            pub fixture_energy: bool,
        }
        /// Interval of the signals that are kept, over which they are averaged: a filter without phase whose gain at the frequency f is
        /// |sinc(f interval)|, 0.64 at half the sampling rate.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub signal_interval_s: Option<f64>, "s", [> 0] usual [1e-6, 0.1], "default 0.001";
        /// Direction in world axes in which the motion of the machine's `points` is measured.
        #[serde(skip_serializing_if = "is_down")]
        pub points_axis: [f64; 3] = DOWN, "1", [finite], "vertical, downwards";
        /// Length of a blow's window, from its start.
        pub blow_window_s: f64 = 0.005, "s", [> 0] usual [1e-4, 0.1], "definition";
        /// Least closing speed of piston and chisel that counts as a blow.
        pub blow_closing_speed_m_s: f64 = 0.5, "m/s", [>= 0] usual [0, 10], "definition";
        /// Least time between the starts of two blows.
        pub blow_separation_s: f64 = 0.010, "s", [>= 0] usual [0, 0.5], "definition";
        /// Least time from the end of a chisel-casting contact to the start of the next for which they count as two; 0: each
        /// interval of positive force counts. Shorter gaps are chatter, whose number depends on the tolerance.
        pub contact_separation_s: f64 = 5e-5, "s", [>= 0] usual [0, 0.01], "measured, see `decore help outputs`";
        /// Number of struck blows at the start of each stroke that count as settling.
        pub settling_blows: usize = 5, "1", [0 ..], "definition";
        /// Root mean square of the differences of blow energies, of intervals and of works a period apart, relative to their mean, up
        /// to which a percussion is periodic; of works three times as much, and relative to at least a tenth of the mean energy. Also
        /// the rise over a series above which it counts as a trend.
        pub periodic_agreement: f64 = 0.01, "1", [> 0], "definition";
        /// Longest period in blows that is looked for.
        pub longest_period_blows: usize = 4, "1", [1 ..], "definition";
        /// Share of the earlier rate of blows below which a percussion has stalled in the last third of its time.
        pub stall_rate_share: f64 = 0.5, "1", [> 0, <= 1], "definition";
        /// Quality factor Q of the oscillators of shock spectra; their damping ratio is 1 / (2 Q).
        pub core_quality_factor: f64 = 10.0, "1", [>= 1] usual [5, 50], "custom of shock spectra";
        /// Pseudo-velocity at a core point from which on a blow is counted.
        pub core_threshold_m_s: f64 = 1.3, "m/s", [> 0] usual [0.1, 20], "mild shock by Gaberson's grades";
        /// Pseudo-velocity of which a cycle adds 1 to the dose.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub core_dose_reference_m_s: Option<f64>, "m/s", [> 0] usual [0.1, 20], "default: no dose is computed";
        /// Exponent of a cycle's pseudo-velocity in the dose.
        pub core_dose_exponent: f64 = 5.0, "1", [> 0, <= 50] usual [2, 12], "assumed; a property of the binder";
        /// Pseudo-velocity below which a cycle adds nothing to the dose.
        pub core_dose_threshold_m_s: f64 = 0.1, "m/s", [> 0] usual [0.01, 5], "assumed";
        /// Dose at which a core is out, see `time_to_dose_s`.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub core_wanted_dose: Option<f64>, "1", [> 0], "default: no time is computed";
        /// Pseudo-velocity that breaks a core with a probability of 63 %, see `break_probability`.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub core_strength_m_s: Option<f64>, "m/s", [> 0] usual [0.1, 20], "default: no probability is computed";
        /// Exponent of that law (Weibull's modulus).
        pub core_strength_exponent: f64 = 5.0, "1", [> 0, <= 50] usual [2, 20], "assumed; a property of the binder";
        /// Twins of each row: further runs, each a run of its own with inputs that are the same for every purpose, whose outputs
        /// show by how much a row's scatter. The same for all rows.
        pub twins: usize = 0, "1", [0 ..= 1000], "none unless asked for";
        /// Rows that are run once more with better numerics: a tolerance of a hundredth, housing guides on their springs, and all modes
        /// of the structure. Their columns `..._numerical_error` hold by how much each main output moves. `sample` (or `true`): row 0 of
        /// a design and one row of every further hundred, drawn by the seed; none without a design. `all`: every row. `none` (or
        /// `false`): no row.
        pub numerical_twin: NumericalTwin = NumericalTwin::Sample, "", [choice], "`sample`";
    }
}

parameters! {
    /// All data of one run except the reduced structure.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Scene {
        own {
            /// Index among the study's further machines; `None`: the machine of the table `[structure]`.
            pub machine: Option<usize>,
            /// Gas, surroundings and gravity.
            pub environment: Environment,
            /// The hammers, in the study's order.
            pub hammers: Vec<HammerUnit>,
            /// The castings, in the study's order.
            pub castings: Vec<Casting>,
            /// Accuracy and effort.
            pub solver: SolverSettings,
            /// Windows and thresholds of the outputs.
            pub outputs: OutputSettings,
        }
        /// Simulated time.
        pub duration_s: f64 = 1.5, "s", [> 0] usual [0.001, 100], "the paper's rig";
    }
}

impl Scene {
    /// Whether the hammers' guides are tied to their mounts, when `guide` is requested.
    pub fn ties(&self, guide: Guide) -> bool {
        match guide {
            Guide::Tied => true,
            Guide::Spring => false,
            Guide::Automatic => self.hammers.iter().all(|hammer| hammer.parameters.guide_is_rigid()),
        }
    }
}

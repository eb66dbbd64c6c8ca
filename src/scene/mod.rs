//! A scene: all that one row of a study needs, as plain data in SI units. No files, no matrices, no defaults hidden.

mod validate;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::hammer::HammerParameters;
use crate::workpiece::Casting;

pub use crate::integrate::Method;
pub use validate::{SceneProblem, SceneProblemKind};

/// Gas, surroundings and gravity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Environment {
    /// Specific gas constant `R` in J/(kg K). Default 287.05.
    pub gas_constant_j_per_kg_k: f64,
    /// Gas temperature `T` in K. Default 293.15.
    pub temperature_k: f64,
    /// Isentropic exponent `kappa`. Default 1.4.
    pub isentropic_exponent: f64,
    /// Ambient pressure in Pa. Default 101325.
    pub ambient_pressure_pa: f64,
    /// Gravity in m/s2. Default 9.80665.
    pub gravity_m_s2: f64,
    /// Exponent `a_in` of inflow. Default 1.4 (Richer and Hurmuzlu).
    pub inflow_exponent: f64,
    /// Exponent `a_out` of outflow. Default 1.0 (Richer and Hurmuzlu).
    pub outflow_exponent: f64,
    /// Exponent `a` of expansion. Default 1.2 (Richer and Hurmuzlu).
    pub expansion_exponent: f64,
}

impl Default for Environment {
    fn default() -> Self {
        Self {
            gas_constant_j_per_kg_k: 287.05,
            temperature_k: 293.15,
            isentropic_exponent: 1.4,
            ambient_pressure_pa: 101_325.0,
            gravity_m_s2: 9.80665,
            inflow_exponent: 1.4,
            outflow_exponent: 1.0,
            expansion_exponent: 1.2,
        }
    }
}

/// Where a hammer is mounted: a weighted set of interface points (one, or two neighbours of a rail).
///
/// The same weights carry mass, force and motion, so the receptance stays symmetric.
#[derive(Debug, Clone, PartialEq)]
pub struct Mount {
    /// Interface points and their weights; the weights sum to 1.
    pub points: Vec<(String, f64)>,
}

/// One hammer of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct HammerUnit {
    /// Name as in the study.
    pub name: String,
    /// Its parameters, overrides applied.
    pub parameters: HammerParameters,
    /// Supply pressure, absolute, in Pa.
    pub supply_pressure_pa: f64,
    /// Time `t_on` at which the supply is switched on, in s.
    pub start_time_s: f64,
    /// Times after the start at which the supply is switched off, on again, off, and so on, in s. While it is off the
    /// supply line is vented: its pressure is the ambient one, and the percussion stops; on again, the hammer starts anew,
    /// its percussion `tau_gate` after the next contact. Empty: on for good.
    pub supply_switch_times_s: Vec<f64>,
    /// Time `tau_gate` from the first chisel-casting contact to the start of the percussion, in s.
    pub gate_delay_s: f64,
    /// Distance of the chisel's tip from the casting at rest, in m.
    pub standoff_m: f64,
    /// Its place on the machine.
    pub mount: Mount,
    /// Index of the casting that it strikes.
    pub casting: usize,
    /// Strike point, x and y from the casting's centre of mass, in m.
    pub strike_point_m: [f64; 2],
}

/// How the housing guide is modelled.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Guide {
    /// A body of its own on its stiff spring (the model as published).
    #[default]
    Spring,
    /// Tied rigidly to the mount: its mass moves with the mount's own motion.
    Tied,
}

/// How the structure's modes take part in the integration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ModeTreatment {
    /// Condensed or integrated, whichever costs less in the scene.
    #[default]
    Automatic,
    /// Two states per mode, integrated with all others.
    Integrated,
    /// Propagated exactly, seen by the others through the interface points only: no states per mode.
    Condensed,
}

/// How a run steps through time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stepping {
    /// Method.
    pub method: Method,
    /// Length of a fixed step in s.
    pub step_s: f64,
    /// Whether a method with a fixed step locates contacts and stops; otherwise it notices them at the ends of steps.
    pub located: bool,
}

impl Default for Stepping {
    /// The default method; fixed steps, if chosen, of 1e-5 s with contacts switched at their ends.
    fn default() -> Self {
        Self { method: Method::Tsit5, step_s: 1e-5, located: false }
    }
}

/// Accuracy and effort of one run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolverSettings {
    /// Error tolerance of one step, in units of each state's own scale.
    pub tolerance: f64,
    /// Model of the housing guide.
    pub guide: Guide,
    /// Method and step.
    pub stepping: Stepping,
    /// How modes are integrated.
    pub modes: ModeTreatment,
    /// Steps after which a row ends with status `budget_exhausted`.
    pub max_steps: u64,
    /// Wall time in s after which a row ends with status `budget_exhausted`.
    pub max_wall_time_s: f64,
}

/// Windows and thresholds of the outputs (defaults: the definitions of the outputs).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct OutputSettings {
    /// Length of a blow's window in s. Default 0.005.
    pub blow_window_s: f64,
    /// Least closing speed of piston and chisel that counts as a blow, in m/s. Default 0.5.
    pub blow_closing_speed_m_s: f64,
    /// Least time between the starts of two blows in s. Default 0.010.
    pub blow_separation_s: f64,
    /// Number of struck blows of each stroke taken as settling. Default 5.
    pub settling_blows: usize,
    /// Root mean square of the differences of blow energies, and of intervals, a period apart, relative to their mean, up to
    /// which a percussion is periodic; also the rise over a series above which it counts as a trend. Default 0.01.
    pub periodic_agreement: f64,
    /// Longest period in blows that is looked for. Default 4.
    pub longest_period_blows: usize,
    /// Share of the earlier rate of blows below which a percussion has stalled in the last third of its time. Default 0.5.
    pub stall_rate_share: f64,
    /// Twins of each row: further runs with inputs that are the same for every purpose, whose outputs show by how much a row's
    /// scatter. The same for all rows. Default 0.
    pub twins: usize,
}

impl Default for OutputSettings {
    fn default() -> Self {
        Self {
            blow_window_s: 0.005,
            blow_closing_speed_m_s: 0.5,
            blow_separation_s: 0.010,
            settling_blows: 5,
            periodic_agreement: 0.01,
            longest_period_blows: 4,
            stall_rate_share: 0.5,
            twins: 0,
        }
    }
}

/// All that one run needs besides the reduced structure.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Index of the machine among the study's further ones; `None`: that of its table `[structure]`.
    pub machine: Option<usize>,
    /// Gas, surroundings and gravity.
    pub environment: Environment,
    /// The hammers, in the study's order.
    pub hammers: Vec<HammerUnit>,
    /// The castings, in the study's order.
    pub castings: Vec<Casting>,
    /// Simulated time in s.
    pub duration_s: f64,
    /// Accuracy and effort.
    pub solver: SolverSettings,
    /// Windows and thresholds of the outputs.
    pub outputs: OutputSettings,
}

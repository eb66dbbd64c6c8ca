//! Accuracy and effort of a run: the solver's settings and the fidelity presets behind them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::integrate::Method;
use crate::parameter::{Choice, parameters};
use crate::quantity::named;

named! {
    /// How the housing guide is modelled.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
    pub enum Guide {
        /// Tied if each hammer's guide is rigid beside its contacts (`HammerParameters::guide_is_rigid`), else on springs.
        #[default]
        Automatic = "automatic",
        /// A body of its own on its stiff spring (the model as published).
        Spring = "spring",
        /// Tied rigidly to the mount: its mass moves with the mount's own motion.
        Tied = "tied",
    }
}

impl Choice for Guide {}
impl Choice for Method {}
impl Choice for ModeTreatment {}

named! {
    /// How the structure's modes take part in the integration.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
    pub enum ModeTreatment {
        /// Condensed or integrated, whichever costs less in the scene.
        #[default]
        Automatic = "automatic",
        /// Two states per mode, integrated with all others.
        Integrated = "integrated",
        /// Propagated exactly, seen by the others through the interface points only: no states per mode.
        Condensed = "condensed",
    }
}

named! {
    /// Preset of accuracy: sets `guide`, `tolerance` and how modes are selected. On the paper's rig `draft` keeps energies and frequency
    /// within 1e-4, `standard` within 1e-5, `reference` within 1e-6 of the whole structure's.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
    pub enum Fidelity {
        /// Fast, for a first look.
        Draft = "draft",
        /// For studies.
        #[default]
        Standard = "standard",
        /// For reference figures.
        Reference = "reference",
    }
}

/// What a preset sets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Preset {
    /// Which one.
    pub fidelity: Fidelity,
    /// Tolerance of the integration.
    pub tolerance: f64,
    /// Model of the housing guide.
    pub guide: Guide,
    /// Error of receptances for which modes are selected; see `structure.mode_tolerance`.
    pub mode_tolerance: f64,
    /// Fixed-interface modes of the built-in station from which modes are selected, up to this frequency in Hz. Beside 20 kHz, on
    /// the paper's rig, 6 kHz move the casting's peak velocity by 4e-4, and modes of a placement take a fifth of the time.
    pub station_basis_hz: f64,
}

const DRAFT: Preset = Preset {
    fidelity: Fidelity::Draft,
    tolerance: 1e-4,
    guide: Guide::Automatic,
    mode_tolerance: 1e-2,
    station_basis_hz: 6000.0,
};
/// The preset of a study that names none.
pub const STANDARD: Preset = Preset {
    fidelity: Fidelity::Standard,
    tolerance: 1e-5,
    guide: Guide::Automatic,
    mode_tolerance: 1e-3,
    station_basis_hz: 20_000.0,
};
const REFERENCE: Preset = Preset {
    fidelity: Fidelity::Reference,
    tolerance: 1e-7,
    guide: Guide::Spring,
    mode_tolerance: 1e-4,
    station_basis_hz: 20_000.0,
};

/// All presets; the tests hold them to their promises.
pub const PRESETS: [Preset; 3] = [DRAFT, STANDARD, REFERENCE];

impl Preset {
    /// What a preset sets.
    pub const fn of(fidelity: Fidelity) -> Self {
        match fidelity {
            Fidelity::Draft => DRAFT,
            Fidelity::Standard => STANDARD,
            Fidelity::Reference => REFERENCE,
        }
    }
}

parameters! {
    /// Accuracy and effort of one run.
    #[derive(Copy, Serialize)]
    pub struct SolverSettings from SolverEntry {
        typed {
            /// Preset that the other keys override, those of `[structure]` for modes too, which all rows share. Default `standard`.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub fidelity: Option<Fidelity>,
        }
        /// Error tolerance of one step, relative to each state's scale.
        pub tolerance: f64 = STANDARD.tolerance, "1", [> 0, <= 0.1], "the preset's";
        /// Model of the housing guide.
        pub guide: Guide = STANDARD.guide, "", [choice], "the preset's";
        /// Method of integration.
        pub method: Method = Method::Tsit5, "", [choice], "`tsit5`";
        /// Step of methods with a fixed step.
        pub step_s: f64 = 1e-5, "s", [> 0] usual [1e-8, 1e-3], "for comparison";
        /// Whether methods with a fixed step locate contacts, supplies and gates instead of noticing them at the ends of steps.
        pub located: bool = false, "", [choice], "false";
        /// How modes are integrated: the results are the same to within the tolerance.
        pub modes: ModeTreatment = ModeTreatment::Automatic, "", [choice], "`automatic`; `integrated` at a fixed step";
        /// Steps after which a row is given up, with status `budget_exhausted`.
        pub max_steps: u64 = 20_000_000, "1", [1 ..], "far beyond a sound row";
        /// Wall time after which a row is given up, with status `budget_exhausted`.
        pub max_wall_time_s: f64 = 600.0, "s", [> 0], "far beyond a sound row";
    }
}

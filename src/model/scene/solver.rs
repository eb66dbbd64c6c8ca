//! Accuracy and effort of a run: the solver's settings and the fidelity presets behind them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::hammer::HammerParameters;
use crate::integrate::Method;
use crate::parameter::{Choice, parameters};
use decore_quantity::named;

named! {
    /// Model of the housing guide.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
    pub enum Guide {
        /// Tied if each hammer's guide is rigid compared with its contacts (`HammerParameters::guide_is_rigid`), otherwise on springs.
        #[default]
        Automatic = "automatic",
        /// A separate body on its stiff spring (the published model).
        Spring = "spring",
        /// Tied rigidly to the mount: its mass moves with the mount.
        Tied = "tied",
    }
}

named! {
    /// Rows with a second run with better numerics, to measure their numerical error.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
    pub enum NumericalTwin {
        /// Row 0 of a design and one row of every further hundred, drawn by the seed.
        #[default]
        Sample = "sample",
        /// Every row.
        All = "all",
        /// No row.
        None = "none",
    }
}

impl<'de> Deserialize<'de> for NumericalTwin {
    /// Reads a name, or `true` for `sample` and `false` for `none`.
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Typed {
            Flag(bool),
            Name(String),
        }
        match Typed::deserialize(deserializer)? {
            Typed::Flag(sample) => Ok(if sample { Self::Sample } else { Self::None }),
            Typed::Name(name) => Self::ALL.into_iter().find(|value| value.name() == name).ok_or_else(|| {
                serde::de::Error::custom(format!(
                    "is \"{name}\", expected true, false, \"sample\", \"all\" or \"none\""
                ))
            }),
        }
    }
}

impl JsonSchema for NumericalTwin {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "NumericalTwin".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "description": "Which rows are run a second time with better numerics; true: sample, false: none.",
            "anyOf": [{ "enum": Self::ALL.map(Self::name) }, { "type": "boolean" }],
        })
    }
}

impl Choice for NumericalTwin {}
impl Choice for Guide {}
impl Choice for Method {}
impl Choice for ModeTreatment {}

named! {
    /// Treatment of the structure's modes in the integration.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
    pub enum ModeTreatment {
        /// Condensed or integrated, whichever costs less in the scene.
        #[default]
        Automatic = "automatic",
        /// Two states per mode, integrated with all others.
        Integrated = "integrated",
        /// Propagated exactly, and coupled to the rest only through the interface points: no states per mode.
        Condensed = "condensed",
    }
}

named! {
    /// Preset of accuracy: sets `guide`, `tolerance` and the selection of modes. On the paper's rig `draft` keeps energies and frequency
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

/// Settings of a preset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Preset {
    /// Name of the preset.
    pub fidelity: Fidelity,
    /// Tolerance of the integration; see [`Preset::tolerance_for`].
    pub tolerance: f64,
    /// Model of the housing guide.
    pub guide: Guide,
    /// Error of receptances for which modes are selected; see `structure.mode_tolerance`.
    pub mode_tolerance: f64,
    /// Upper frequency in Hz of the built-in station's fixed-interface modes for the selection. Compared with 20 kHz, on the paper's rig, 6
    /// kHz change the casting's peak velocity by 4e-4, and modes of a placement take a fifth of the time.
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

/// Factor on a preset's tolerance where a chisel keeps bouncing ([`HammerParameters::chisel_chatters`]).
///
/// Bounces of micrometres are small compared with the scale of a position, so the error of a step is a large part of them. Over random
/// scenes with Hunt-Crossley between piston and chisel, the error of the first impact's energy is 2e-4 at the tolerance of `standard`, and
/// 6e-6 at a hundredth of it, with 2.2 times as many steps.
const CHATTER_TIGHTENING: f64 = 0.01;

/// All presets; the tests hold them to their promises.
pub const PRESETS: [Preset; 3] = [DRAFT, STANDARD, REFERENCE];

impl Preset {
    /// Tolerance for these hammers.
    pub fn tolerance_for<'h>(&self, mut hammers: impl Iterator<Item = &'h HammerParameters>) -> f64 {
        let chatters = hammers.any(HammerParameters::chisel_chatters);
        if chatters { self.tolerance * CHATTER_TIGHTENING } else { self.tolerance }
    }

    /// Settings of a preset.
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
        own {
            /// Preset of the other values; its promises apply to the row.
            pub fidelity: Fidelity,
        }
        typed {
            /// Preset. The other keys override it, also the keys of `[structure]` for modes, which all rows share. Default `standard`.
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
        /// Whether methods with a fixed step locate contacts, supplies and gates, instead of switching at the ends of steps.
        pub located: bool = false, "", [choice], "false";
        /// Integration of modes; the results agree within the tolerance.
        pub modes: ModeTreatment = ModeTreatment::Automatic, "", [choice], "`automatic`; `integrated` at a fixed step";
        /// Largest number of steps. A row that needs more ends with status `budget_exhausted`.
        pub max_steps: u64 = 20_000_000, "1", [1 ..], "far beyond a sound row";
        /// Largest wall time. A row that needs more ends with status `budget_exhausted`.
        pub max_wall_time_s: f64 = 600.0, "s", [> 0], "far beyond a sound row";
    }
}

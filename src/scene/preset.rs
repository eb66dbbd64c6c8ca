//! The fidelity presets: what each sets where a study is silent.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Guide;

/// Preset of accuracy: sets `guide`, `tolerance` and how modes are selected. On the paper's rig `draft` keeps energies and frequency
/// within 1e-4, `standard` within 1e-5, `reference` within 1e-6 of the whole structure's.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Fidelity {
    /// Fast, for a first look.
    Draft,
    /// For studies.
    #[default]
    Standard,
    /// For reference figures.
    Reference,
}

/// What a preset sets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Preset {
    /// Its name in a study.
    pub name: &'static str,
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

const DRAFT: Preset =
    Preset { name: "draft", tolerance: 1e-4, guide: Guide::Tied, mode_tolerance: 1e-2, station_basis_hz: 6000.0 };
/// The preset of a study that names none.
pub const STANDARD: Preset = Preset {
    name: "standard",
    tolerance: 1e-5,
    guide: Guide::Spring,
    mode_tolerance: 1e-2,
    station_basis_hz: 20_000.0,
};
const REFERENCE: Preset = Preset {
    name: "reference",
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

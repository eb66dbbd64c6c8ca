//! The fidelity presets: what each sets where the study is silent.

use crate::scene::Guide;
use crate::study::file::Fidelity;

/// What a preset sets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::study) struct Preset {
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

impl Preset {
    /// What a preset sets; `tests/physics/presets.rs` holds all of them to their promises.
    pub const fn of(fidelity: Fidelity) -> Self {
        match fidelity {
            Fidelity::Draft => {
                Self { tolerance: 1e-4, guide: Guide::Tied, mode_tolerance: 1e-2, station_basis_hz: 6000.0 }
            }
            Fidelity::Standard => {
                Self { tolerance: 1e-5, guide: Guide::Spring, mode_tolerance: 1e-2, station_basis_hz: 20_000.0 }
            }
            Fidelity::Reference => {
                Self { tolerance: 1e-7, guide: Guide::Spring, mode_tolerance: 1e-4, station_basis_hz: 20_000.0 }
            }
        }
    }
}

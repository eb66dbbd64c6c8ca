//! Relative errors that the fidelity presets promise, output by output.

use super::outputs::{CastingMetrics, HammerMetrics, RunTotals};
use crate::scene::Fidelity;

/// Part of a run that an output comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Span {
    /// From the start to the end of the first impact's window: the promise holds in every row.
    FirstImpact,
    /// The percussion or the whole run: the promise holds where every hammer's percussion is periodic or strikes nothing.
    Run,
}

/// Relative errors that the presets promise for some outputs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Promise {
    /// Names of the outputs.
    pub outputs: &'static [&'static str],
    /// Part of the run that they come from.
    pub span: Span,
    /// Largest relative error under `draft`.
    pub draft: f64,
    /// Largest relative error under `standard`.
    pub standard: f64,
    /// Largest relative error under `reference`.
    pub reference: f64,
}

/// All promises, which the bench `promises` measures over random scenes.
pub const PROMISES: [Promise; 9] = [
    Promise {
        outputs: &[HammerMetrics::first_impact_time_s.name, HammerMetrics::first_impact_energy_j.name],
        span: Span::FirstImpact,
        draft: 1e-4,
        standard: 1e-5,
        reference: 1e-6,
    },
    Promise {
        outputs: &[HammerMetrics::first_impact_chisel_velocity_m_s.name, HammerMetrics::arm_rms_extension_m_s.name],
        span: Span::FirstImpact,
        draft: 1e-3,
        standard: 2e-4,
        reference: 1e-5,
    },
    Promise {
        outputs: &[
            HammerMetrics::first_impact_work_j.name,
            HammerMetrics::first_impact_impulse_n_s.name,
            HammerMetrics::first_impact_peak_force_n.name,
            HammerMetrics::first_impact_casting_peak_velocity_m_s.name,
            HammerMetrics::first_impact_strike_momentum_n_s.name,
            HammerMetrics::first_impact_strike_energy_j.name,
            HammerMetrics::first_impact_strike_kinetic_energy_j.name,
        ],
        span: Span::FirstImpact,
        draft: 2e-2,
        standard: 2e-3,
        reference: 2e-4,
    },
    Promise {
        outputs: &[HammerMetrics::periodic_energy_mean_j.name, HammerMetrics::hit_frequency_hz.name],
        span: Span::Run,
        draft: 5e-3,
        standard: 1e-3,
        reference: 2e-5,
    },
    Promise {
        outputs: &[
            HammerMetrics::periodic_work_mean_j.name,
            HammerMetrics::periodic_impulse_mean_n_s.name,
            HammerMetrics::periodic_peak_force_mean_n.name,
            HammerMetrics::periodic_casting_peak_velocity_mean_m_s.name,
            HammerMetrics::periodic_strike_momentum_mean_n_s.name,
            HammerMetrics::periodic_strike_energy_mean_j.name,
            HammerMetrics::periodic_strike_kinetic_energy_mean_j.name,
        ],
        span: Span::Run,
        draft: 5e-3,
        standard: 1e-3,
        reference: 1e-4,
    },
    Promise {
        outputs: &[CastingMetrics::peak_velocity_m_s.name, CastingMetrics::peak_point_velocity_m_s.name],
        span: Span::Run,
        draft: 5e-3,
        standard: 1e-3,
        reference: 2e-4,
    },
    Promise {
        // Of a hammer, a casting and the run alike: they have the same names.
        outputs: &[
            RunTotals::delivered_work_j.name,
            RunTotals::delivered_impulse_n_s.name,
            CastingMetrics::fixture_damper_loss_j.name,
        ],
        span: Span::Run,
        draft: 1e-1,
        standard: 5e-3,
        reference: 2e-3,
    },
    Promise {
        // A strike ends where the kinetic energy is largest: that time is less sure than the energy.
        outputs: &[
            RunTotals::strike_energy_j.name,
            HammerMetrics::strike_momentum_n_s.name,
            HammerMetrics::strike_kinetic_energy_j.name,
        ],
        span: Span::Run,
        draft: 1e-1,
        standard: 2e-2,
        reference: 1e-2,
    },
    Promise {
        outputs: &[HammerMetrics::arm_rms_hammering_m_s.name, HammerMetrics::arm_rms_steady_m_s.name],
        span: Span::Run,
        draft: 2e-1,
        standard: 5e-2,
        reference: 1e-2,
    },
];

impl Promise {
    /// The promise for an output; `None` for one that has none.
    pub fn of(output: &str) -> Option<Self> {
        PROMISES.into_iter().find(|promise| promise.outputs.contains(&output))
    }

    /// Largest relative error under a preset.
    pub fn under(&self, fidelity: Fidelity) -> f64 {
        match fidelity {
            Fidelity::Draft => self.draft,
            Fidelity::Standard => self.standard,
            Fidelity::Reference => self.reference,
        }
    }
}

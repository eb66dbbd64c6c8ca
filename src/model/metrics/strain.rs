//! Strain energy of elastic castings.

use schemars::JsonSchema;
use serde::Serialize;

use super::blow::{Blow, BlowKind};
use super::instant::Instant;
use super::peak::{Probe, peak};
use super::statistics::mean;
use crate::integrate::Step;
use crate::scene::{PartId, Scene};
use crate::system::{Coupled, CoupledModel};
use decore_quantity::quantities;

/// Share of the largest energy from which on a maximum within a step is searched.
const NEAR: f64 = 0.5;

quantities! {
    /// Outputs of one elastic casting. Strain energy counts from rest: of the modes that are kept, and of the static flexibility of the
    /// others under the forces of chisels and fixtures.
    #[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
    pub struct ElasticMetrics {
        /// Largest strain energy of the casting in the run, if it is elastic.
        pub peak_strain_energy_j: f64 => "J" [less],
        /// Time of the largest strain energy.
        pub peak_strain_energy_time_s: f64 => "s",
        /// Strain energy of the casting at the end of the first impact's window; of several hammers the largest.
        pub first_impact_strain_energy_j: Option<f64> => "J" [less],
        /// Mean strain energy of the casting at the end of the windows of the periodic blows on it.
        pub periodic_strain_energy_mean_j: Option<f64> => "J" [less],
    }
}

/// Reads the strain energy of one elastic casting.
pub(super) struct StrainGauge {
    part: PartId,
    /// Scratch memory for the forces of elements.
    forces: Vec<f64>,
}

impl StrainGauge {
    /// Of a casting; `None` if it is rigid.
    pub fn new(model: &CoupledModel, scene: &Scene, casting: usize) -> Option<Self> {
        scene.castings[casting].elastic?;
        Some(Self { part: PartId::Casting(casting), forces: vec![0.0; model.elements().matrix().rows()] })
    }

    /// Strain energy at a state, J.
    pub fn energy_j(&mut self, system: &Coupled, Instant { t, y }: Instant<'_>) -> f64 {
        system.strain_energy(self.part, (t, y), &mut self.forces)
    }
}

/// Follows the strain energy of one elastic casting through a run.
pub(super) struct StrainTrack {
    casting: usize,
    gauge: StrainGauge,
    /// All components of the state.
    support: Vec<usize>,
    /// Energy in J at the end of the last step, and whether it fell there.
    end: (f64, bool),
    largest_j: f64,
    time_s: f64,
}

impl StrainTrack {
    /// Of the elastic castings of a scene.
    pub fn all(model: &CoupledModel, scene: &Scene) -> Vec<Self> {
        let new = |casting| {
            let gauge = StrainGauge::new(model, scene, casting)?;
            let support = (0..model.layout().dimension()).collect();
            Some(Self { casting, gauge, support, end: (0.0, false), largest_j: 0.0, time_s: 0.0 })
        };
        (0..scene.castings.len()).filter_map(new).collect()
    }

    /// Follows a step. It is searched for a maximum if it ends higher than any before, comes after such an end, or turns from rising to
    /// falling near the largest.
    pub fn step(&mut self, system: &Coupled, step: &Step<'_>, scratch: &mut [f64]) {
        step.write_end(scratch);
        let end = Instant { t: step.t1(), y: scratch };
        let falls = system.strain_power(self.gauge.part, (end.t, end.y)) < 0.0;
        let end_j = self.gauge.energy_j(system, end);
        let (start_j, fell) = std::mem::replace(&mut self.end, (end_j, falls));
        let near = start_j.max(end_j) >= NEAR * self.largest_j && !fell && falls;
        if end_j > self.largest_j || start_j == self.largest_j && start_j > 0.0 || near {
            let Self { gauge, support, .. } = self;
            let mut energy_j = |t: f64, y: &[f64]| gauge.energy_j(system, Instant { t, y });
            let (found_j, theta) = peak(step, step.theta_end, Probe { support, scratch }, &mut energy_j);
            if found_j > self.largest_j {
                (self.largest_j, self.time_s) = (found_j, step.time(theta));
            }
        }
    }

    /// The outputs at the end of the run.
    pub fn finish(self, blows: &[Blow]) -> ElasticMetrics {
        let of_kind = |kind: BlowKind| {
            let own = blows.iter().filter(move |blow| blow.casting == self.casting && blow.kind == kind);
            own.filter_map(|blow| Some(blow.strain.as_ref()?.casting_strain_energy_j))
        };
        let periodic: Vec<f64> = of_kind(BlowKind::Periodic).collect();
        ElasticMetrics {
            peak_strain_energy_j: self.largest_j,
            peak_strain_energy_time_s: self.time_s,
            first_impact_strain_energy_j: of_kind(BlowKind::FirstImpact).reduce(f64::max),
            periodic_strain_energy_mean_j: mean(&periodic),
        }
    }
}

//! Energy through single fixtures.

use schemars::JsonSchema;
use serde::Serialize;

use crate::integrate::Step;
use crate::scene::Scene;
use crate::system::{Coupled, CoupledModel, FixtureGauge};
use decore_quantity::quantities;

quantities! {
    /// Energy through one fixture. Over the fixtures of a casting the figures sum to its `fixture_damper_loss_j` and `structure_work_j`.
    #[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, JsonSchema)]
    pub struct FixtureMetrics {
        /// Energy lost in the fixture's damper and by its friction in the run.
        pub damper_loss_j: f64 => "J" [less],
        /// Work of the fixture on the machine in the run.
        pub structure_work_j: f64 => "J" [less],
        /// Path in the run over which the casting slid on the fixture; 0 without `friction`.
        pub slip_m: f64 => "m" [less],
    }
}

/// Integrates the powers of the fixtures of a scene, which costs no state.
pub(super) struct FixtureTracks {
    gauge: FixtureGauge,
    metrics: Vec<FixtureMetrics>,
}

impl FixtureTracks {
    /// `None` unless the outputs ask for it.
    pub fn new(model: &CoupledModel, scene: &Scene) -> Option<Self> {
        scene.outputs.fixture_energy.then(|| {
            let fixtures: Vec<_> = scene.fixtures().map(|(fixture, _)| fixture).collect();
            let metrics = vec![FixtureMetrics::default(); fixtures.len()];
            Self { gauge: FixtureGauge::new(model, &fixtures), metrics }
        })
    }

    /// Follows a step, at the places where the method integrates the same powers of whole castings.
    pub fn step(&mut self, system: &Coupled, step: &Step<'_>, scratch: &mut [f64]) {
        for place in 0..step.places() {
            let (t, weight_s) = step.place(place, scratch);
            let powers = self.gauge.read(system, (t, scratch));
            for (metrics, power) in self.metrics.iter_mut().zip(powers) {
                metrics.damper_loss_j += weight_s * power.loss_w;
                metrics.structure_work_j += weight_s * power.structure_w;
                metrics.slip_m += weight_s * power.slip_m_s;
            }
        }
    }

    /// Energies, casting by casting.
    pub fn finish(self) -> Vec<FixtureMetrics> {
        self.metrics
    }
}

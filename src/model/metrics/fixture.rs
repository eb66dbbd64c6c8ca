//! Energy through single fixtures.

use schemars::JsonSchema;
use serde::Serialize;

use crate::integrate::Step;
use crate::scene::Scene;
use crate::system::{Coupled, CoupledModel, FixtureGauge};
use decore_quantity::quantities;

/// Places within a step, from -1 to 1, and weights of Gauss and Legendre: exact for polynomials of degree 7.
const GAUSS: [(f64, f64); 4] = [
    (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
    (-0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
    (0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
    (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
];

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

    /// Follows a step by its dense output.
    pub fn step(&mut self, system: &Coupled, step: &Step<'_>, scratch: &mut [f64]) {
        let half = 0.5 * step.theta_end;
        for (place, weight) in GAUSS {
            let theta = half * (1.0 + place);
            step.state(theta, scratch);
            let duration_s = weight * half * step.h;
            let powers = self.gauge.read(system, (step.time(theta), scratch));
            for (metrics, power) in self.metrics.iter_mut().zip(powers) {
                metrics.damper_loss_j += duration_s * power.loss_w;
                metrics.structure_work_j += duration_s * power.structure_w;
                metrics.slip_m += duration_s * power.slip_m_s;
            }
        }
    }

    /// Energies, casting by casting.
    pub fn finish(self) -> Vec<FixtureMetrics> {
        self.metrics
    }
}

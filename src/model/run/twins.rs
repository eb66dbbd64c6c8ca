//! Twins of a row: the same scene with tiny changes of the inputs, to measure the scatter of its outputs.

use super::row::LEAST_TOLERANCE;
use crate::scene::{Guide, HammerUnit, Method, ModeTreatment, Scene, SolverSettings};

/// Relative change of supply pressures and standoffs from one twin to the next.
pub const PERTURBATION: f64 = 1e-9;
/// Factor on the tolerance of twins: one step tighter, so that errors of the integration show as well.
const TWIN_TIGHTENING: f64 = 0.1;
/// Factor on the tolerance of a numerical twin, so that its own error is small compared with the row's.
const NUMERICAL_TIGHTENING: f64 = 0.01;
/// Factor on the budget of steps of a numerical twin, which takes about ten times as many.
const NUMERICAL_STEPS: u64 = 100;
/// Ratio of a casting's to the chisel's mass above which the percussion of a single hammer is mostly not periodic. With the default hammer
/// (1.8 kg) castings of 3 kg are still periodic, castings of 3.5 kg are not (help page on scatter).
const HEAVY_RATIO: f64 = 1.75;

/// Reason why a scene amplifies perturbations, so that its periodic figures scatter; `None` for other scenes.
pub fn amplifies(scene: &Scene) -> Option<String> {
    for (index, casting) in scene.castings.iter().enumerate() {
        let striking: Vec<&HammerUnit> = scene.hammers.iter().filter(|hammer| hammer.casting == index).collect();
        if striking.len() > 1 {
            return Some(format!("{} hammers strike casting `{}`", striking.len(), casting.name));
        }
        if striking.iter().any(|hammer| casting.mass_kg > HEAVY_RATIO * hammer.parameters.chisel.mass_kg) {
            return Some(format!("casting `{}` is heavy for its hammer ({} kg)", casting.name, casting.mass_kg));
        }
    }
    None
}

/// Twin `number` of a scene, from 0: its inputs [`perturbed`], and a tolerance one step (ten times) tighter.
pub fn twin(scene: &Scene, number: usize) -> Scene {
    let mut moved = perturbed(scene, number);
    moved.solver.tolerance = (moved.solver.tolerance * TWIN_TIGHTENING).max(LEAST_TOLERANCE);
    moved
}

/// Numerical twin of a scene: the same inputs with a hundredth of the tolerance and housing guides on their springs; the default method
/// instead of a fixed step. It runs on all modes of the structure.
pub fn numerical_twin(scene: &Scene) -> Scene {
    let solver = SolverSettings {
        tolerance: (scene.solver.tolerance * NUMERICAL_TIGHTENING).max(LEAST_TOLERANCE),
        guide: Guide::Spring,
        method: Method::Tsit5,
        modes: ModeTreatment::Automatic,
        max_steps: scene.solver.max_steps.saturating_mul(NUMERICAL_STEPS),
        ..scene.solver
    };
    Scene { solver, ..scene.clone() }
}

/// A scene with supply pressures (absolute) and standoffs times `1 + d`, where `d` is +1, -1, +2, -2 and so on, by `number` from
/// 0, times [`PERTURBATION`].
pub fn perturbed(scene: &Scene, number: usize) -> Scene {
    let mut moved = scene.clone();
    let sign = if number.is_multiple_of(2) { 1.0 } else { -1.0 };
    let factor = 1.0 + sign * (number / 2 + 1) as f64 * PERTURBATION;
    for hammer in &mut moved.hammers {
        hammer.supply_pressure_pa *= factor;
        hammer.standoff_m *= factor;
    }
    moved
}

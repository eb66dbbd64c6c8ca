//! The paper's rig, prepared: its scene and the modes of its structure.

use std::path::Path;

use decore_model::metrics::RunMetrics;
use decore_model::scene::Scene;
use decore_model::system::InterfaceModes;
use decore_study::Study;
use decore_study::engine::{Engine, RowScene};

/// What is compared: first-impact energy, periodic energy, hit frequency, casting peak velocity.
pub const FIGURES: [&str; 4] = ["first impact", "periodic", "frequency", "peak velocity"];
/// Largest relative error of each that a fast setting may have.
pub const GOALS: [f64; 4] = [1e-5, 1e-5, 1e-5, 1e-4];

/// A scene and the modes of its structure.
pub struct Rig {
    /// The scene.
    pub scene: Scene,
    /// The modes.
    pub modes: InterfaceModes,
}

/// The rig of `study`, some values of it set.
pub fn prepare(study: &Path, settings: &[&str]) -> Rig {
    of_study(&Study::load(study).expect("the shipped study"), settings)
}

/// The first row of a study, some values of it set.
pub fn of_study(study: &Study, settings: &[&str]) -> Rig {
    let settings: Vec<String> = settings.iter().map(|setting| (*setting).to_owned()).collect();
    let study = study.with_overrides(&settings).expect("values of the study");
    let RowScene { scene, modes } = Engine::new(study).expect("its machine").scene(0).expect("its scene");
    Rig { scene, modes: InterfaceModes::clone(&modes) }
}

/// The values of [`FIGURES`]; NaN where a run does not have one.
pub fn figures(metrics: &RunMetrics) -> [f64; 4] {
    let hammer = &metrics.hammers[0];
    let value = |value: Option<f64>| value.unwrap_or(f64::NAN);
    [
        value(hammer.first_impact_energy_j),
        value(hammer.periodic_energy_mean_j),
        value(hammer.hit_frequency_hz),
        metrics.castings[0].peak_velocity_m_s,
    ]
}

/// Relative errors of figures.
pub fn errors(found: &[f64; 4], exact: &[f64; 4]) -> [f64; 4] {
    std::array::from_fn(|i| (found[i] / exact[i] - 1.0).abs())
}

/// Whether errors are within [`GOALS`].
pub fn meets_goals(errors: &[f64; 4]) -> bool {
    errors.iter().zip(GOALS).all(|(error, goal)| *error <= goal)
}

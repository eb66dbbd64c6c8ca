//! Rows of shipped studies with values set over theirs, as the command line runs them.

use std::path::Path;
use std::sync::Arc;

use decore_model::metrics::RunMetrics;
use decore_model::run::{RowJob, RowOutcome, RowStatus};
use decore_model::scene::Scene;
use decore_model::system::PlacedModes;
use decore_study::engine::{Engine, RowScene};

/// The scene of a row of a shipped study and the machine's modes for it, or why there is none.
pub fn scene(study: &str, row: usize, settings: &[&str]) -> Result<(Scene, Arc<PlacedModes>), String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies").join(study);
    let settings: Vec<String> = settings.iter().map(|setting| (*setting).to_owned()).collect();
    let found = Engine::load(&path, &settings).unwrap().scene(row);
    found.map(|RowScene { scene, modes }| (scene, modes)).map_err(|invalid| invalid.reason)
}

/// The outcome of a row of a shipped study, twins included.
pub fn outcome(study: &str, row: usize, settings: &[&str]) -> RowOutcome {
    let (scene, modes) = scene(study, row, settings).unwrap();
    RowJob::new(scene, modes, 0).run()
}

/// The outputs of the paper's rig with values set over its own.
#[track_caller]
pub fn rig(settings: &[&str]) -> RunMetrics {
    let outcome = outcome("paper_rig.toml", 0, settings);
    assert_eq!((outcome.status, outcome.reason.as_str()), (RowStatus::Done, ""), "{settings:?}");
    outcome.metrics.unwrap()
}

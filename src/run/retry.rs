//! Runs a row that diverged, or whose audit fails, again with a stricter tolerance.

use super::outcome::{RowOutcome, RowStatus};
use super::row::{LEAST_TOLERANCE, run_row_observed};
use super::twins::with_twins;
use crate::integrate::Observer;
use crate::scene::Scene;
use crate::system::{Coupled, CoupledModel, InterfaceModes};

/// Times such a row is run again unless another number is asked for.
pub const DEFAULT_RETRIES: u32 = 1;
/// Factor on the tolerance from one time to the next.
pub const TIGHTENING: f64 = 0.01;

/// As [`crate::run::run_row`]; a row that diverges or fails its audit is run again with [`TIGHTENING`] times the tolerance, at most
/// `retries` times, where the method has one. Then its twins are run, if the scene asks for them.
///
/// The outcome is that of the last time, its wall time that of all. Pure, as a single run is.
pub fn run_row_with_retries(scene: &Scene, modes: &InterfaceModes, retries: u32) -> RowOutcome {
    run_row_with_retries_observed(scene, modes, retries, |_| ()).0
}

/// As [`run_row_with_retries`], with an observer that is made for each time and sees it; that of the last time comes back, unless
/// the scene could not be built.
pub fn run_row_with_retries_observed<O>(
    scene: &Scene,
    modes: &InterfaceModes,
    retries: u32,
    observer: impl Fn(&CoupledModel) -> O,
) -> (RowOutcome, Option<O>)
where
    O: for<'a> Observer<Coupled<'a>>,
{
    let (outcome, seen) = repeat(scene, retries, |scene| run_row_observed(scene, modes, &observer));
    (with_twins(scene, modes, outcome), seen)
}

fn repeat<T>(scene: &Scene, retries: u32, run: impl Fn(&Scene) -> (RowOutcome, T)) -> (RowOutcome, T) {
    let (mut outcome, mut seen) = run(scene);
    let mut stricter = scene.clone();
    let retries = if scene.solver.method.is_fixed() { 0 } else { retries };
    for time in 1..=retries {
        stricter.solver.tolerance *= TIGHTENING;
        let again = matches!(outcome.status, RowStatus::Diverged | RowStatus::AuditFailed);
        if !again || stricter.solver.tolerance < LEAST_TOLERANCE {
            break;
        }
        let wall_time_s = outcome.wall_time_s;
        (outcome, seen) = run(&stricter);
        outcome.wall_time_s += wall_time_s;
        outcome.counters.retries = u64::from(time);
        if outcome.status != RowStatus::Done {
            outcome.reason = format!("{} (also with tolerance {:.0e})", outcome.reason, stricter.solver.tolerance);
        }
    }
    (outcome, seen)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Environment, Method, ModeTreatment, OutputSettings, SolverSettings};

    fn scene() -> Scene {
        Scene {
            machine: None,
            environment: Environment::default(),
            hammers: Vec::new(),
            castings: Vec::new(),
            duration_s: 1.0,
            solver: SolverSettings {
                tolerance: 1e-4,
                modes: ModeTreatment::Integrated,
                max_steps: 10,
                max_wall_time_s: 1.0,
                ..SolverSettings::default()
            },
            outputs: OutputSettings::default(),
        }
    }

    /// Diverges unless the tolerance is below `limit`.
    fn run(scene: &Scene, limit: f64) -> (RowOutcome, ()) {
        let mut outcome = RowOutcome::invalid("shrunk to nothing".to_owned());
        let done = scene.solver.tolerance < limit;
        outcome.status = if done { RowStatus::Done } else { RowStatus::Diverged };
        outcome.wall_time_s = 2.0;
        (outcome, ())
    }

    #[test]
    fn a_row_that_diverges_is_run_with_a_stricter_tolerance() {
        let tries = |limit: f64, retries: u32| {
            let (outcome, ()) = repeat(&scene(), retries, |scene| run(scene, limit));
            (outcome.status, outcome.counters.retries, outcome.wall_time_s)
        };
        assert_eq!(tries(1.0, 3), (RowStatus::Done, 0, 2.0));
        assert_eq!(tries(1e-5, 3), (RowStatus::Done, 1, 4.0));
        assert_eq!(tries(1e-7, 3), (RowStatus::Done, 2, 6.0));
        assert_eq!(tries(1e-7, 1), (RowStatus::Diverged, 1, 4.0));
        assert_eq!(tries(1e-30, 99), (RowStatus::Diverged, 4, 10.0), "the least tolerance ends it");
        assert_eq!(tries(1e-5, 0), (RowStatus::Diverged, 0, 2.0));
        let (outcome, ()) = repeat(&scene(), 1, |scene| run(scene, 0.0));
        assert_eq!(outcome.reason, "shrunk to nothing (also with tolerance 1e-6)");
        // So is one whose audit fails; a method without a tolerance is not.
        let failing = |scene: &Scene| (RowOutcome { status: RowStatus::AuditFailed, ..run(scene, 0.0).0 }, ());
        assert_eq!(repeat(&scene(), 2, failing).0.counters.retries, 2);
        let mut fixed = scene();
        fixed.solver.method = Method::Rk4;
        assert_eq!(repeat(&fixed, 2, failing).0.counters.retries, 0);
        assert_eq!(repeat(&fixed, 2, failing).0.reason, "shrunk to nothing");
    }
}

//! The steps of a row: simulation, retries with a stricter tolerance if it diverges or its audit fails, then its numerical twin and its
//! twins.

use std::sync::Arc;

use super::outcome::{RowOutcome, RowStatus};
use super::row::{LEAST_TOLERANCE, run_row_placed};
use super::twins::{numerical_twin, twin};
use crate::integrate::Observer;
use crate::metrics::RunMetrics;
use crate::scene::Scene;
use crate::system::{Coupled, CoupledModel, PlacedModes};

/// Default number of retries of such a row.
pub const DEFAULT_RETRIES: u32 = 1;
/// Factor on the tolerance from one time to the next.
pub const TIGHTENING: f64 = 0.01;

/// A row in progress: its next simulation and the results of earlier ones. Pure: simulations can run anywhere.
#[derive(Debug, Clone)]
pub struct RowJob {
    scene: Scene,
    modes: Arc<PlacedModes>,
    /// Numerical twin of the row; `None` for a row without one.
    numerical: Option<NumericalModes>,
    retries: u32,
    /// Tolerance of its last time.
    tolerance: f64,
    next: Next,
    outcome: Option<RowOutcome>,
    twins: Vec<RunMetrics>,
}

/// All modes of a row's machine, on which its numerical twin runs; `None` if they could not be computed.
pub type NumericalModes = Option<Arc<PlacedModes>>;

/// Next simulation of a row.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Next {
    /// The row itself, with this tolerance, for this time, from 0.
    Itself(f64, u32),
    /// The numerical twin of the row.
    NumericalTwin,
    /// One of its twins.
    Twin(usize),
    /// None any more.
    Nothing,
}

impl RowJob {
    /// The row of a scene on its machine's modes; one that diverges or fails its audit is run again with [`TIGHTENING`] times the
    /// tolerance, at most `retries` times, where the method has one. Then its twins are run, if the scene asks for them.
    pub fn new(scene: Scene, modes: Arc<PlacedModes>, retries: u32) -> Self {
        let retries = if scene.solver.method.is_fixed() { 0 } else { retries };
        let tolerance = scene.solver.tolerance;
        let next = Next::Itself(tolerance, 0);
        Self { scene, modes, numerical: None, retries, tolerance, next, outcome: None, twins: Vec::new() }
    }

    /// The row with a numerical twin, which runs before the other twins do.
    pub fn with_numerical_twin(self, all_modes: NumericalModes) -> Self {
        Self { numerical: Some(all_modes), ..self }
    }

    /// Modes on which the next simulation runs.
    pub fn modes(&self) -> &Arc<PlacedModes> {
        match (self.next, &self.numerical) {
            (Next::NumericalTwin, Some(Some(all))) => all,
            _ => &self.modes,
        }
    }

    /// The scene to be simulated next; `None` when all is done.
    pub fn scene(&self) -> Option<Scene> {
        match self.next {
            Next::Itself(tolerance, _) => Some(self.scene_to(tolerance)),
            Next::NumericalTwin => Some(numerical_twin(&self.scene_to(self.tolerance))),
            Next::Twin(number) => Some(twin(&self.scene, number)),
            Next::Nothing => None,
        }
    }

    /// The scene with another tolerance.
    fn scene_to(&self, tolerance: f64) -> Scene {
        let mut scene = self.scene.clone();
        scene.solver.tolerance = tolerance;
        scene
    }

    /// Whether the row itself is simulated next, not a twin.
    fn is_itself(&self) -> bool {
        matches!(self.next, Next::Itself(..))
    }

    /// Takes the outcome of the simulation that was next.
    pub fn take(&mut self, mut outcome: RowOutcome) {
        match self.next {
            Next::Itself(tolerance, time) => {
                self.tolerance = tolerance;
                if time > 0 {
                    outcome.counters.retries = u64::from(time);
                    if outcome.status != RowStatus::Done {
                        outcome.reason = format!("{} (also with tolerance {tolerance:.0e})", outcome.reason);
                    }
                }
                outcome.wall_time_s += self.outcome.as_ref().map_or(0.0, |before| before.wall_time_s);
                let stricter = tolerance * TIGHTENING;
                let again = matches!(outcome.status, RowStatus::Diverged | RowStatus::AuditFailed)
                    && time < self.retries
                    && stricter >= LEAST_TOLERANCE;
                if !again && matches!(self.numerical, Some(None)) {
                    let fidelity = self.scene.solver.fidelity;
                    outcome.metrics.iter_mut().for_each(|own| own.take_numerical_twin(None, fidelity));
                }
                let ended = outcome.metrics.is_some();
                self.outcome = Some(outcome);
                self.next = match (again, ended) {
                    (true, _) => Next::Itself(stricter, time + 1),
                    (false, true) if matches!(self.numerical, Some(Some(_))) => Next::NumericalTwin,
                    (false, true) => self.twin_or_nothing(0),
                    (false, false) => Next::Nothing,
                };
            }
            Next::NumericalTwin => {
                let fidelity = self.scene.solver.fidelity;
                if let Some(own) = &mut self.outcome {
                    own.wall_time_s += outcome.wall_time_s;
                    own.numerical_twin_wall_time_s = Some(outcome.wall_time_s);
                    own.metrics.iter_mut().for_each(|own| own.take_numerical_twin(outcome.metrics.as_ref(), fidelity));
                }
                self.next = self.twin_or_nothing(0);
            }
            Next::Twin(number) => {
                self.outcome.iter_mut().for_each(|own| own.wall_time_s += outcome.wall_time_s);
                self.twins.extend(outcome.metrics);
                self.next = self.twin_or_nothing(number + 1);
                if self.next != Next::Nothing {
                    return;
                }
                if let Some(metrics) = self.outcome.as_mut().and_then(|own| own.metrics.as_mut()) {
                    // A twin that did not reach its end is left out and missing in the count.
                    metrics.take_twins(&self.twins);
                }
            }
            Next::Nothing => {}
        }
    }

    /// The twin with this number, or nothing behind the last one.
    fn twin_or_nothing(&self, number: usize) -> Next {
        if number < self.scene.outputs.twins { Next::Twin(number) } else { Next::Nothing }
    }

    /// Outcome after all simulations: the outcome of the last one, with the wall time of all.
    pub fn outcome(self) -> RowOutcome {
        self.outcome.unwrap_or_else(|| RowOutcome::invalid("the row was not simulated".to_owned()))
    }

    /// Runs the rest alone, with a new observer for each simulation. Returns the observer of the row's last simulation, unless the scene
    /// could not be built.
    pub fn run_observed<O>(mut self, observer: impl Fn(&CoupledModel) -> O) -> (RowOutcome, Option<O>)
    where
        O: Observer<Coupled>,
    {
        let mut last = None;
        while let Some(scene) = self.scene() {
            let (outcome, seen) = run_row_placed(&scene, self.modes(), &observer);
            if self.is_itself() {
                last = seen;
            }
            self.take(outcome);
        }
        (self.outcome(), last)
    }

    /// Runs the rest alone.
    pub fn run(self) -> RowOutcome {
        self.run_observed(|_| ()).0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Environment, Guide, Method, ModeTreatment, OutputSettings, SolverSettings};
    use crate::system::InterfaceModes;

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

    /// Runs a scene that diverges unless the tolerance is below `limit`, by an outcome made up.
    fn repeat(scene: &Scene, retries: u32, made_up: impl Fn(&Scene) -> RowOutcome) -> RowOutcome {
        let modes = InterfaceModes { omega_rad_s: Vec::new(), damping_ratio: Vec::new(), shapes: Default::default() };
        let mut job = RowJob::new(scene.clone(), Arc::new(modes.into()), retries);
        while let Some(scene) = job.scene() {
            job.take(made_up(&scene));
        }
        job.outcome()
    }

    fn run(scene: &Scene, limit: f64) -> RowOutcome {
        let mut outcome = RowOutcome::invalid("shrunk to nothing".to_owned());
        let done = scene.solver.tolerance < limit;
        outcome.status = if done { RowStatus::Done } else { RowStatus::Diverged };
        outcome.wall_time_s = 2.0;
        outcome
    }

    /// The numerical twin follows the row's last time, at a hundredth of its tolerance; one that does not reach its end is counted so.
    #[test]
    fn a_numerical_twin_follows_the_last_time() {
        let modes = || -> Arc<PlacedModes> {
            let (omega_rad_s, damping_ratio, shapes) = Default::default();
            Arc::new(InterfaceModes { omega_rad_s, damping_ratio, shapes }.into())
        };
        let all_modes = modes();
        for (twin_ends, expected) in [(true, 1), (false, 0)] {
            let mut job = RowJob::new(scene(), modes(), 1).with_numerical_twin(Some(Arc::clone(&all_modes)));
            let mut run_with = Vec::new();
            while let Some(scene) = job.scene() {
                let is_twin = scene.solver.guide == Guide::Spring;
                assert_eq!(Arc::ptr_eq(job.modes(), &all_modes), is_twin);
                run_with.push(scene.solver.tolerance);
                let mut outcome = run(&scene, 1e-5);
                let ends = outcome.status == RowStatus::Done && (twin_ends || !is_twin);
                outcome.metrics = ends.then(RunMetrics::default);
                job.take(outcome);
            }
            assert_eq!(run_with.len(), 3);
            assert!((run_with[2] / (0.01 * run_with[1]) - 1.0).abs() < 1e-9, "{run_with:?}");
            let outcome = job.outcome();
            let numerical = outcome.metrics.and_then(|metrics| metrics.numerical).expect("a numerical twin");
            assert_eq!((numerical.numerical_twin_done, outcome.numerical_twin_wall_time_s), (expected, Some(2.0)));
            assert_eq!((outcome.status, outcome.wall_time_s), (RowStatus::Done, 6.0));
        }
    }

    #[test]
    fn a_row_that_diverges_is_run_with_a_stricter_tolerance() {
        let tries = |limit: f64, retries: u32| {
            let outcome = repeat(&scene(), retries, |scene| run(scene, limit));
            (outcome.status, outcome.counters.retries, outcome.wall_time_s)
        };
        assert_eq!(tries(1.0, 3), (RowStatus::Done, 0, 2.0));
        assert_eq!(tries(1e-5, 3), (RowStatus::Done, 1, 4.0));
        assert_eq!(tries(1e-7, 3), (RowStatus::Done, 2, 6.0));
        assert_eq!(tries(1e-7, 1), (RowStatus::Diverged, 1, 4.0));
        assert_eq!(tries(1e-30, 99), (RowStatus::Diverged, 4, 10.0), "the least tolerance ends it");
        assert_eq!(tries(1e-5, 0), (RowStatus::Diverged, 0, 2.0));
        let outcome = repeat(&scene(), 1, |scene| run(scene, 0.0));
        assert_eq!(outcome.reason, "shrunk to nothing (also with tolerance 1e-6)");
        // So is one whose audit fails; a method without a tolerance is not.
        let failing = |scene: &Scene| RowOutcome { status: RowStatus::AuditFailed, ..run(scene, 0.0) };
        assert_eq!(repeat(&scene(), 2, failing).counters.retries, 2);
        let mut fixed = scene();
        fixed.solver.method = Method::Rk4;
        assert_eq!(repeat(&fixed, 2, failing).counters.retries, 0);
        assert_eq!(repeat(&fixed, 2, failing).reason, "shrunk to nothing");
    }
}

//! One row: a scene and the structure's modes in, an outcome out. Pure: no files, no clocks in the results.

use std::sync::Arc;
use std::time::Instant;

use super::outcome::{RowOutcome, RowStatus};
use crate::integrate::{End, Observer, Settings, Span, Stopped};
use crate::metrics::{Recorder, RunMetrics, RunTotals};
use crate::scene::{Scene, SolverSettings};
use crate::system::{Coupled, CoupledModel, PlacedModes, SceneModes, build_placed};

/// First step of a run in s; error control corrects it at once.
const FIRST_STEP_S: f64 = 1e-6;
/// Longest step in s: well below the width of any window or the period of the percussion.
const LONGEST_STEP_S: f64 = 1e-3;

/// Least tolerance of a run: below it rounding decides.
pub(super) const LEAST_TOLERANCE: f64 = 1e-12;

/// Residual of energies or of chambers above which the audit of a row fails. At the default tolerance energies close to 1e-5 and
/// chambers to 1e-10; the latter to a few 1e-4 where an annulus at ambient pressure relaxes within a step for a minute.
pub const RESIDUAL_LIMIT: f64 = 1e-3;

/// Longest time in s for which a casting may be off all its fixtures. In free flight it rises by 5 cm in it, and comes down elsewhere.
pub const LONGEST_FLIGHT_S: f64 = 0.2;
/// Distance in m that a casting may have slid on its pads at the end of a run: farther than a pad is wide.
const LONGEST_SLIDE_M: f64 = 0.05;

/// Simulates a scene on the modes of its structure.
///
/// Never fails: a scene that cannot be built gives status `Invalid`, an integration that cannot continue `Diverged` or
/// `BudgetExhausted`, each with the reason and the time reached.
pub fn run_row(scene: &Scene, modes: &impl SceneModes) -> RowOutcome {
    run_row_observed(scene, modes, |_| ()).0
}

/// As [`run_row`], with an observer that is made for the coupled model and sees every step and event too; it comes back
/// unless the scene could not be built.
pub fn run_row_observed<O>(
    scene: &Scene,
    modes: &impl SceneModes,
    observer: impl FnOnce(&CoupledModel) -> O,
) -> (RowOutcome, Option<O>)
where
    O: Observer<Coupled>,
{
    modes.with_placed(|placed| run_row_placed(scene, placed, observer))
}

/// As [`run_row_observed`], on modes that other scenes share.
pub(super) fn run_row_placed<O>(
    scene: &Scene,
    modes: &PlacedModes,
    observer: impl FnOnce(&CoupledModel) -> O,
) -> (RowOutcome, Option<O>)
where
    O: Observer<Coupled>,
{
    let begin = Instant::now();
    let (mut outcome, extra) = match build_placed(scene, modes) {
        Ok(model) => {
            let mut extra = observer(&model);
            (simulate(scene, &model, &mut extra), Some(extra))
        }
        Err(error) => (RowOutcome::invalid(error.to_string()), None),
    };
    outcome.wall_time_s = begin.elapsed().as_secs_f64();
    (outcome, extra)
}

/// Not generic over the observer: otherwise the integration would be compiled for each of them.
fn simulate(scene: &Scene, model: &Arc<CoupledModel>, extra: &mut dyn Observer<Coupled>) -> RowOutcome {
    let mut system = Coupled::new(model);
    let mut observers = (Recorder::new(model, scene), extra);
    let span = Span { y0: model.initial_state(), t_end: scene.duration_s };
    let end = scene.solver.method.integrate(&mut system, &mut observers, &settings(scene), &span);
    outcome(scene, &system, observers.0, end)
}

/// Accuracy and effort of a scene.
pub(super) fn settings(scene: &Scene) -> Settings {
    let SolverSettings { tolerance, step_s, located, max_steps, max_wall_time_s, .. } = scene.solver;
    Settings {
        tolerance,
        first_step_s: FIRST_STEP_S,
        longest_step_s: LONGEST_STEP_S,
        step_s,
        located,
        max_steps,
        max_wall_time_s,
    }
}

/// The outcome of a scene whose integration has ended; its wall time is left at 0.
pub(super) fn outcome(scene: &Scene, system: &Coupled, recorder: Recorder, end: End) -> RowOutcome {
    let End { stopped, t, y, counters } = end;
    let metrics = (stopped == Stopped::AtEnd).then(|| recorder.finish(system, t, &y));
    let (status, reason) = match &metrics {
        Some(metrics) => thrown(metrics, scene).unwrap_or_else(|| audited(&metrics.totals, scene)),
        None => describe(&stopped, scene),
    };
    let layout = system.model().layout();
    RowOutcome {
        status,
        reason,
        time_reached_s: t,
        modes: system.model().modes(),
        states: layout.states(),
        metrics,
        counters,
        wall_time_s: 0.0,
        numerical_twin_wall_time_s: None,
    }
}

/// Status of a run in which a casting left its fixtures.
fn thrown(metrics: &RunMetrics, scene: &Scene) -> Option<(RowStatus, String)> {
    let mut flights = scene.castings.iter().zip(&metrics.flights_s);
    if let Some((casting, flight_s)) = flights.find(|(_, flight_s)| **flight_s > LONGEST_FLIGHT_S) {
        let reason = format!(
            "casting `{}` was thrown off its fixtures for {flight_s:.2} s: press it down with a clamp (`clamp_force_n`), or strike less hard",
            casting.name
        );
        return Some((RowStatus::Invalid, reason));
    }
    let mut slides = scene.castings.iter().zip(&metrics.slides_m);
    let (casting, slide_m) = slides.find(|(_, slide_m)| **slide_m > LONGEST_SLIDE_M)?;
    let reason = format!(
        "casting `{}` slid by {slide_m:.2} m on its pads: press it down with a clamp (`clamp_force_n`), hold it sideways \
         (`lateral_stiffness_n_per_m`), or strike less hard",
        casting.name
    );
    Some((RowStatus::Invalid, reason))
}

/// Status of a run that reached its end, by its audits.
fn audited(totals: &RunTotals, scene: &Scene) -> (RowStatus, String) {
    let fails = |residual: f64| residual.is_nan() || residual.abs() > RESIDUAL_LIMIT;
    let parts = [("energy", totals.energy_residual), ("chamber", totals.chamber_residual)];
    let failed: Vec<String> = (parts.iter().filter(|(_, residual)| fails(*residual)))
        .map(|(audit, residual)| format!("{audit} residual {residual:.1e} beyond {RESIDUAL_LIMIT:.0e}"))
        .collect();
    if failed.is_empty() {
        return (RowStatus::Done, String::new());
    }
    let key = if scene.solver.method.is_fixed() { "step_s" } else { "tolerance" };
    let reason = format!("{}: the outputs are doubtful (a smaller solver.{key} may help)", failed.join(", "));
    (RowStatus::AuditFailed, reason)
}

fn describe(stopped: &Stopped, scene: &Scene) -> (RowStatus, String) {
    let solver = &scene.solver;
    match stopped {
        Stopped::AtEnd => (RowStatus::Done, String::new()),
        Stopped::Diverged(message) => (RowStatus::Diverged, message.clone()),
        Stopped::StepBudget => {
            (RowStatus::BudgetExhausted, format!("more than {} steps (solver.max_steps)", solver.max_steps))
        }
        Stopped::TimeBudget => (
            RowStatus::BudgetExhausted,
            format!("more than {} s of wall time (solver.max_wall_time_s)", solver.max_wall_time_s),
        ),
    }
}

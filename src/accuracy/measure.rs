//! The runs behind a comparison.

use super::outputs::{differences, outputs};
use super::{Accuracy, Measurement, REFERENCE_TOLERANCE, Setting};
use decore_model::metrics::RunMetrics;
use decore_model::run::{RowOutcome, perturbed, run_row};
use decore_model::scene::{Guide, Method, ModeTreatment, Scene, SolverSettings};
use decore_model::system::PlacedModes;

/// Wall time in s of a run that is not repeated: noise hardly matters to it.
const LONG_RUN_S: f64 = 5.0;

/// Number of twins for the scene's sensitivity, unless the scene has more.
const LEAST_TWINS: usize = 2;

/// Scene and settings of a comparison.
pub struct Experiment<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The structure's modes as the study keeps them.
    pub modes: &'a PlacedModes,
    /// The structure's modes with none left out, if more can be had.
    pub all_modes: Option<&'a PlacedModes>,
    /// The settings.
    pub settings: Vec<Setting>,
    /// Runs of each setting, of which the fastest counts. Settings that take longer than 5 s run once.
    pub repeats: usize,
}

/// Reason why a scene has no reference to compare with.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("the {run} did not end: {reason}")]
pub struct AccuracyError {
    /// Name of the run.
    pub run: &'static str,
    /// Reason, as a sentence.
    pub reason: String,
}

/// A run that begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Begun<'a> {
    /// Number of started runs, including this one.
    pub number: usize,
    /// Largest number of runs. A setting that takes long runs once.
    pub of: usize,
    /// Description of the run.
    pub what: &'a str,
}

/// Counts the runs and reports them.
struct Teller<'a> {
    number: usize,
    of: usize,
    tell: &'a mut dyn FnMut(Begun<'_>),
}

impl Teller<'_> {
    fn begin(&mut self, what: &str) {
        self.number += 1;
        (self.tell)(Begun { number: self.number, of: self.of, what });
    }
}

/// Runs everything; `tell` is called when a run begins.
///
/// # Errors
/// [`AccuracyError`] if the reference run, the perturbed one or that with all modes does not reach its end.
pub fn measure(experiment: &Experiment<'_>, tell: &mut dyn FnMut(Begun<'_>)) -> Result<Accuracy, AccuracyError> {
    let exact = |scene: &Scene, modes: &PlacedModes, tolerance: f64| {
        let (guide, modes_as) = (Guide::Spring, ModeTreatment::Automatic);
        let solver = SolverSettings { tolerance, guide, modes: modes_as, method: Method::Tsit5, ..scene.solver };
        run_row(&Scene { solver, ..scene.clone() }, modes)
    };
    let (scene, modes) = (experiment.scene, experiment.modes);
    let twins = scene.outputs.twins.max(LEAST_TWINS);
    // The reference and the run that checks it, then those below.
    let of =
        2 + twins + usize::from(experiment.all_modes.is_some()) + experiment.repeats.max(1) * experiment.settings.len();
    let mut teller = Teller { number: 0, of, tell };
    teller.begin("reference");
    let reference = ended("reference run", exact(scene, modes, REFERENCE_TOLERANCE))?;
    teller.begin("check of the reference");
    let coarser = ended("run that checks the reference", exact(scene, modes, 10.0 * REFERENCE_TOLERANCE))?;
    let mut sensitivity: Vec<f64> = Vec::new();
    for number in 0..twins {
        teller.begin("perturbed input");
        let moved = exact(&perturbed(scene, number), modes, REFERENCE_TOLERANCE);
        let moved = differences(&ended("run with perturbed input", moved)?, &reference);
        sensitivity.resize(moved.len(), f64::NAN);
        sensitivity.iter_mut().zip(moved).for_each(|(largest, moved)| *largest = largest.max(moved));
    }
    let truncation = match experiment.all_modes {
        None => None,
        Some(all) => {
            teller.begin("all modes");
            let full = ended("run with all modes", exact(scene, all, 10.0 * REFERENCE_TOLERANCE))?;
            Some((all.omega_rad_s.len(), differences(&reference, &full)))
        }
    };
    Ok(Accuracy {
        outputs: outputs(),
        measurements: measurements(experiment, &reference, &mut teller),
        reference_error: differences(&coarser, &reference),
        sensitivity,
        truncation,
    })
}

fn ended(run: &'static str, outcome: RowOutcome) -> Result<RunMetrics, AccuracyError> {
    outcome.metrics.ok_or(AccuracyError { run, reason: outcome.reason })
}

/// Runs the settings in turns, so that a machine that slows down slows all of them.
fn measurements(experiment: &Experiment<'_>, reference: &RunMetrics, teller: &mut Teller<'_>) -> Vec<Measurement> {
    let mut measurements: Vec<Measurement> = Vec::with_capacity(experiment.settings.len());
    for turn in 0..experiment.repeats.max(1) {
        for (index, setting) in experiment.settings.iter().enumerate() {
            let long = 1e3 * LONG_RUN_S / experiment.scene.duration_s;
            if measurements.get(index).is_some_and(|known| known.ms_per_simulated_s > long) {
                teller.of -= 1;
                continue;
            }
            teller.begin(&format!("{}, {}", setting.family, setting.grade()));
            let scene = Scene { solver: setting.solver, ..experiment.scene.clone() };
            let outcome = run_row(&scene, experiment.modes);
            let ms_per_simulated_s = 1e3 * outcome.wall_time_s / outcome.time_reached_s;
            match measurements.get_mut(index) {
                Some(known) if turn > 0 => known.ms_per_simulated_s = known.ms_per_simulated_s.min(ms_per_simulated_s),
                _ => measurements.push(measurement(setting, outcome, ms_per_simulated_s, reference)),
            }
        }
    }
    measurements
}

fn measurement(setting: &Setting, outcome: RowOutcome, ms: f64, reference: &RunMetrics) -> Measurement {
    let errors = match &outcome.metrics {
        Some(metrics) => differences(metrics, reference),
        None => vec![f64::INFINITY; outputs().len()],
    };
    Measurement {
        setting: setting.clone(),
        status: outcome.status,
        ms_per_simulated_s: ms,
        modes: outcome.modes,
        states: outcome.states,
        counters: outcome.counters,
        totals: outcome.metrics.map(|metrics| metrics.totals),
        errors,
    }
}

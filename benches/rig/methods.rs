//! Milliseconds per simulated second against error for every method.

use std::fmt::Write as _;

use decore_model::run::{RowOutcome, run_row};
use decore_model::scene::{Guide, Method, ModeTreatment, Scene, SolverSettings};

use crate::scene::{FIGURES, GOALS, Rig, errors, figures, meets_goals};
use crate::timing::{Timed, interleaved};

/// A setting of the solver.
#[derive(Clone)]
pub struct Case {
    /// Settings that differ in tolerance or step only, the coarsest first.
    family: String,
    /// What it is called.
    pub name: String,
    /// It.
    pub solver: SolverSettings,
}

/// A setting's time and errors.
pub struct Measured {
    /// The setting.
    pub case: Case,
    /// CPU ms per simulated second.
    pub ms_per_s: f64,
    /// Relative errors of the figures.
    pub errors: [f64; 4],
    outcome: RowOutcome,
}

/// What all rows are compared with.
pub struct Methods {
    /// One entry per setting.
    pub measured: Vec<Measured>,
    /// Index of the fastest setting within the goals.
    fastest: Option<usize>,
    /// Index of the Runge-Kutta rule at 1 us, guide on its spring.
    baseline: usize,
}

/// Tolerance of the reference.
const REFERENCE_TOLERANCE: f64 = 1e-9;
/// Name of the baseline.
const BASELINE: &str = "rk4, 1 us";

/// The settings: the default method as it is used, with modes integrated, and the methods at a fixed step.
fn cases(scene: &Scene) -> Vec<Case> {
    let adaptive = |name: &str, guide, modes, tolerance| Case {
        family: name.to_owned(),
        name: format!("tsit5, {name}, {tolerance:.0e}"),
        solver: SolverSettings { tolerance, guide, modes, method: Method::Tsit5, ..scene.solver },
    };
    let fixed = |name: &str, (method, step_s, located): (Method, f64, bool), guide| Case {
        family: name.to_owned(),
        name: format!("{name}, {} us", (1e6 * step_s).round()),
        solver: SolverSettings { guide, modes: ModeTreatment::Integrated, method, step_s, located, ..scene.solver },
    };
    let (spring, tied) = (Guide::Spring, Guide::Tied);
    let mut cases = Vec::new();
    for tolerance in [1e-4, 3e-5, 1e-5, 1e-6, 1e-7] {
        cases.push(adaptive("tied", tied, ModeTreatment::Automatic, tolerance));
    }
    for tolerance in [1e-4, 1e-5, 1e-7] {
        cases.push(adaptive("spring", spring, ModeTreatment::Automatic, tolerance));
    }
    cases.push(adaptive("tied, modes integrated", tied, ModeTreatment::Integrated, 1e-5));
    cases.push(adaptive("spring, modes integrated", spring, ModeTreatment::Integrated, 1e-5));
    cases.push(fixed("rk4", (Method::Rk4, 1e-5, false), spring));
    cases.push(fixed("rk4", (Method::Rk4, 5e-6, false), spring));
    cases.push(fixed("rk4", (Method::Rk4, 1e-6, false), spring));
    cases.push(fixed("rk4, tied", (Method::Rk4, 1e-6, false), tied));
    cases.push(fixed("rk4, located", (Method::Rk4, 1e-5, true), spring));
    cases.push(fixed("rk4, located", (Method::Rk4, 5e-6, true), spring));
    cases.push(fixed("rk4, located, tied", (Method::Rk4, 1e-5, true), tied));
    cases.push(fixed("implicit trapezoid", (Method::Trapezoid, 1e-5, false), spring));
    cases
}

/// Runs a setting.
pub fn run(rig: &Rig, solver: SolverSettings) -> RowOutcome {
    run_row(&Scene { solver, ..rig.scene.clone() }, &rig.modes)
}

/// Measures all settings on a rig.
pub fn measure(rig: &Rig, repeats: usize) -> Methods {
    let solver = SolverSettings {
        tolerance: REFERENCE_TOLERANCE,
        guide: Guide::Spring,
        method: Method::Tsit5,
        ..rig.scene.solver
    };
    let exact = figures(run(rig, solver).metrics.as_ref().expect("the reference run"));
    let cases = cases(&rig.scene);
    let timed = interleaved(repeats, &cases, |case| run(rig, case.solver));
    let measured = |(case, timed): (Case, Timed<RowOutcome>)| Measured {
        case,
        ms_per_s: 1e3 * timed.cpu_s / rig.scene.duration_s,
        errors: timed.value.metrics.as_ref().map_or([f64::INFINITY; 4], |metrics| errors(&figures(metrics), &exact)),
        outcome: timed.value,
    };
    let measured: Vec<Measured> = cases.into_iter().zip(timed).map(measured).collect();
    // A setting that meets them by luck, where a stricter one of its family does not, does not count.
    let robust = |i: &usize| {
        let family = &measured[*i].case.family;
        measured[*i..].iter().filter(|other| other.case.family == *family).all(|other| meets_goals(&other.errors))
    };
    let good = (0..measured.len()).filter(robust);
    let fastest = good.min_by(|&a, &b| measured[a].ms_per_s.total_cmp(&measured[b].ms_per_s));
    let baseline = measured.iter().position(|measured| measured.case.name == BASELINE).expect("the baseline");
    Methods { measured, fastest, baseline }
}

impl Methods {
    /// The fastest setting within the goals.
    pub fn best(&self) -> Option<&Measured> {
        self.fastest.map(|index| &self.measured[index])
    }

    /// The table and what it says.
    pub fn text(&self, text: &mut String) {
        let _ = writeln!(
            text,
            "## Methods\n\nErrors are relative to a run on the same modes with the guide on its spring at tolerance {REFERENCE_TOLERANCE:.0e}. \
             `tied`: the housing guide moves with its mount. Modes are\ncondensed unless the row says otherwise, and integrated \
             at a fixed step. `faster`: time of {BASELINE}, over the row's.\n\n| method | modes, states | ms per s | faster | steps | \
             right-hand sides | factorisations | {} | energy residual |\n|---|---|---|---|---|---|---|---|---|---|---|---|",
            FIGURES.join(" | ")
        );
        let baseline = self.measured[self.baseline].ms_per_s;
        for Measured { case, ms_per_s, errors, outcome } in &self.measured {
            let work = &outcome.counters;
            let residual = outcome.metrics.as_ref().map_or(f64::NAN, |metrics| metrics.totals.energy_residual.abs());
            let _ = writeln!(
                text,
                "| {} | {}, {} | {ms_per_s:.1} | {:.2} | {} | {} | {} | {} | {residual:.0e} |",
                case.name,
                outcome.modes,
                outcome.states,
                baseline / ms_per_s,
                work.steps,
                work.rhs_evaluations,
                work.factorisations,
                cells(errors),
            );
        }
        let goals = GOALS.map(|goal| format!("{goal:.0e}")).join(", ");
        let _ = match self.best() {
            Some(best) => {
                let ratio = baseline / best.ms_per_s;
                let verdict = if ratio >= 60.0 { "met" } else { "**missed**" };
                writeln!(
                    text,
                    "\nFastest within the goals ({goals} in the order of the columns) with all stricter settings of its family: **{}**, {:.1} ms per simulated second, \
                     {ratio:.0} times\nthe speed of {BASELINE} (goal 60: {verdict}), {:.1} times the estimated limit of 4 to 5 ms.",
                    best.case.name,
                    best.ms_per_s,
                    best.ms_per_s / 4.5
                )
            }
            None => writeln!(text, "\n**No setting is within the goals ({goals} in the order of the columns).**"),
        };
    }
}

/// Errors as cells of a table.
pub fn cells(errors: &[f64; 4]) -> String {
    errors.map(|error| if error.is_finite() { format!("{error:.0e}") } else { "-".to_owned() }).join(" | ")
}

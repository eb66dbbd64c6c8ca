//! The comparison as text.

use std::fmt::Write as _;

use super::{Accuracy, MAIN_OUTPUTS, PERTURBATION, REFERENCE_TOLERANCE};

/// Headings of [`MAIN_OUTPUTS`].
const HEADINGS: [&str; 4] = ["first impact", "periodic", "frequency", "peak velocity"];

/// The comparison as a table for people, errors relative.
pub fn text(accuracy: &Accuracy) -> String {
    let mut text = format!(
        "Errors are relative to a run with the guide on its spring at tolerance {REFERENCE_TOLERANCE:.0e}; each is the largest over \
         hammers or castings.\nTimes are wall times of the fastest run; compare them with each other only.\n\n"
    );
    let _ = writeln!(
        text,
        "{:<38} {:>9} {:>9} {:>9} {:>10} {:>6}  {}",
        "setting",
        "tolerance",
        "ms per s",
        "steps",
        "rhs",
        "states",
        HEADINGS.map(|heading| format!("{heading:>13}")).join(" ")
    );
    for measurement in &accuracy.measurements {
        let setting = &measurement.setting;
        let _ = writeln!(
            text,
            "{:<38} {:>9.0e} {:>9.1} {:>9} {:>10} {:>6}  {} {}",
            setting.family,
            setting.solver.tolerance,
            measurement.ms_per_simulated_s,
            measurement.counters.steps,
            measurement.counters.rhs_evaluations,
            measurement.states,
            errors(accuracy, &measurement.errors),
            setting.preset.unwrap_or_default()
        );
    }
    let _ = writeln!(
        text,
        "\n{:<87} {}",
        "What no setting can be judged below:",
        HEADINGS.map(|h| format!("{h:>13}")).join(" ")
    );
    let mut line = |what: String, values: &[f64]| {
        let _ = writeln!(text, "{what:<87} {}", errors(accuracy, values));
    };
    line(
        format!("  error of the reference (against tolerance {:.0e})", 10.0 * REFERENCE_TOLERANCE),
        &accuracy.reference_error,
    );
    line(
        format!("  the scene's own sensitivity (pressures and standoffs perturbed by {PERTURBATION:.0e})"),
        &accuracy.sensitivity,
    );
    if let Some((modes, truncation)) = &accuracy.truncation {
        let kept = accuracy.measurements.first().map_or(0, |measurement| measurement.modes);
        line(format!("Not numerical: modes left out ({kept} of {modes} kept)"), truncation);
    }
    text
}

fn errors(accuracy: &Accuracy, values: &[f64]) -> String {
    let value =
        |name: &str| accuracy.outputs.iter().position(|output| output.name == name).and_then(|at| values.get(at));
    let cell = |name: &str| match value(name) {
        Some(error) if error.is_nan() => format!("{:>13}", "-"),
        Some(error) => format!("{error:>13.1e}"),
        None => format!("{:>13}", "-"),
    };
    MAIN_OUTPUTS.map(cell).join(" ")
}

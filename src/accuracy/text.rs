//! The comparison as text.

use std::fmt::Write as _;

use super::outputs::HEADINGS;
use super::{Accuracy, MAIN_OUTPUTS, Measurement, REFERENCE_TOLERANCE};
use decore_model::run::{PERTURBATION, RowStatus};

/// Width of the columns before the errors.
const LEFT: usize = 96;

/// The comparison as a table for people, errors relative.
pub fn text(accuracy: &Accuracy) -> String {
    let kept = accuracy.measurements.first().map_or(0, |measurement| measurement.modes);
    let mut text = format!(
        "Errors are numerical ones: relative to a run of the same scene on the same {kept} modes with the guide on its spring at\n\
         tolerance {REFERENCE_TOLERANCE:.0e}, each the largest over hammers or castings. Times are wall times of the fastest run; \
         compare them with each other\nonly. Factors: factorisations of a matrix.\n\n"
    );
    let _ = writeln!(
        text,
        "{:<38} {:>9} {:>9} {:>9} {:>10} {:>8} {:>6}  {}",
        "setting",
        "tolerance",
        "ms per s",
        "steps",
        "rhs",
        "factors",
        "states",
        headings()
    );
    accuracy.measurements.iter().for_each(|measurement| row(&mut text, accuracy, measurement));
    let _ = writeln!(text, "\n{:<LEFT$} {}", "What no setting can be judged below:", headings());
    let mut line = |what: String, values: &[f64]| {
        let _ = writeln!(text, "{what:<LEFT$} {}", errors(accuracy, values));
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
        line(format!("Not numerical: modes left out ({kept} of {modes} kept), against all {modes}"), truncation);
    }
    text
}

fn headings() -> String {
    HEADINGS.map(|(_, heading)| format!("{heading:>13}")).join(" ")
}

/// Writes a line per setting. For a run that did not end, the status replaces the preset.
fn row(text: &mut String, accuracy: &Accuracy, measurement: &Measurement) {
    let setting = &measurement.setting;
    let remark = match measurement.status {
        RowStatus::Done => setting.preset.unwrap_or_default(),
        RowStatus::AuditFailed => "audit fails",
        RowStatus::BudgetExhausted => "not finished",
        RowStatus::Diverged => "diverged",
        RowStatus::Invalid => "not possible",
    };
    let _ = writeln!(
        text,
        "{:<38} {:>9} {:>9.1} {:>9} {:>10} {:>8} {:>6}  {} {remark}",
        setting.family,
        setting.grade(),
        measurement.ms_per_simulated_s,
        measurement.counters.steps,
        measurement.counters.rhs_evaluations,
        measurement.counters.factorisations,
        measurement.states,
        errors(accuracy, &measurement.errors),
    );
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

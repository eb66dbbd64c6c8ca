//! `decore structure --measured`: compares measured frequency responses with the machine's.

use std::collections::BTreeMap;
use std::path::Path;

use super::exit::{Exit, Failure, write_file};
use super::json::print_result;
use super::text::{plural, print_line};
use decore_model::structure::{
    FeModel, MeasuredMode, MeasuredReport, MeasuredSettings, PointPlace, ReductionSettings, compare_measured,
    read_measured, reduce,
};
use decore_study::StructureSettings;

/// Options of the comparison.
pub(super) struct Asked<'a> {
    pub measured: &'a Path,
    pub damping_to: Option<&'a Path>,
    pub json: bool,
}

/// Compares the responses of a file with the reduced machine's.
pub(super) fn compare_with_measured(
    model: &FeModel,
    reduction: &ReductionSettings,
    settings: &StructureSettings,
    asked: &Asked<'_>,
) -> Result<Exit, Failure> {
    let measured = read_measured(asked.measured)?;
    let structure = reduce(model, reduction)?;
    let settings = MeasuredSettings {
        damping: settings.damping_ratio.clone(),
        cutoff_hz: settings.cutoff_hz,
        points_of_nodes: points_of_nodes(model),
    };
    let report = compare_measured(&structure, &measured, &settings)?;
    if let Some(path) = asked.damping_to {
        write_file(path, report.damping_table())?;
    }
    print_result(asked.json, &report, || readable(&report))?;
    if let Some(path) = asked.damping_to.filter(|_| !asked.json) {
        print_line(&format_args!("\ndamping ratios {} (use it as `damping_ratio_file`)", path.display()))?;
    }
    Ok(Exit::Done)
}

/// The point that stands on each node, by label or by its rows.
fn points_of_nodes(model: &FeModel) -> BTreeMap<String, String> {
    let node = |place: &PointPlace| match place {
        PointPlace::Node { node, .. } => Some(*node),
        PointPlace::Rows { first, .. } => model.labels().get(*first).map(|label| label.node),
        PointPlace::Nodes(_) | PointPlace::None => None,
    };
    let named =
        |point: &decore_model::structure::InterfacePoint| Some((node(&point.place)?.to_string(), point.name.clone()));
    model.points().iter().filter_map(named).collect()
}

fn readable(report: &MeasuredReport) -> String {
    let mut lines = vec![format!(
        "measured       {}, {} compared",
        plural(report.curves.len(), "response"),
        plural(report.modes.len(), "resonance")
    )];
    lines.extend(report.remarks.iter().map(|remark| format!("differs        {remark}")));
    lines.push(format!(
        "\n{:>5} {:>12} {:>12} {:>11} {:>9} {:>9} {:>9}",
        "mode", "machine Hz", "measured Hz", "difference", "damping", "measured", "level dB"
    ));
    lines.extend(report.modes.iter().map(mode_line));
    lines.push("\nlargest difference of the curves, relative to the machine's peak".to_owned());
    for curve in &report.curves {
        lines.push(format!("{:<16} {:<16} {:>9.1e}", curve.response, curve.force, curve.largest_relative_difference));
    }
    lines.join("\n")
}

fn mode_line(mode: &MeasuredMode) -> String {
    let number = |value: Option<f64>, digits: usize| value.map_or("-".to_owned(), |value| format!("{value:.digits$}"));
    let difference = mode.machine_hz.zip(mode.measured_hz).map(|(machine, measured)| measured - machine);
    format!(
        "{:>5} {:>12} {:>12} {:>11} {:>9} {:>9} {:>9}",
        mode.mode.map_or("-".to_owned(), |mode| mode.to_string()),
        number(mode.machine_hz, 4),
        number(mode.measured_hz, 4),
        difference.map_or("-".to_owned(), |difference| format!("{difference:+.4}")),
        number(mode.machine_damping_ratio, 5),
        number(mode.measured_damping_ratio, 5),
        number(mode.level_db, 2)
    )
}

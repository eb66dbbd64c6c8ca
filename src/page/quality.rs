//! Quality report as one self-contained HTML page: tables, and plots as inline SVG.

use std::fmt::Write as _;

use crate::plot::{Axis, COLORS, Chart, Color, Line, Marker, PlotError, Series, document, escape, panels};
use decore_model::structure::{MobilityCurve, ModePair, QualityReport};

const FULL: Color = COLORS[5];
const REDUCED: Color = COLORS[0];

/// Builds the page. `title`: name of the reduced machine.
///
/// # Errors
/// The plotting library's words.
pub fn quality_page(report: &QualityReport, title: &str) -> Result<String, PlotError> {
    let mut page = "<p>The reduced structure beside its full finite element model.</p>\n".to_owned();
    figures(&mut page, report);
    frequencies(&mut page, report)?;
    stiffness(&mut page, report);
    mobility(&mut page, report)?;
    conditions(&mut page, report);
    Ok(document(title, &page))
}

/// Writing to a string cannot fail.
fn put(page: &mut String, text: std::fmt::Arguments) {
    let _ = page.write_fmt(text);
}

fn figures(page: &mut String, report: &QualityReport) {
    let facts = &report.facts;
    let last = report.modes.last().map_or(0.0, |mode| mode.full_hz);
    let mac = report.modes.iter().map(|mode| mode.mac).fold(1.0, f64::min);
    let statics = report.static_stiffness.iter().map(|one| one.relative_error.abs()).fold(0.0, f64::max);
    let items = [
        (facts.order.to_string(), "degrees of freedom"),
        (format!("{} + {}", facts.interface, facts.fixed_interface_hz.len()), "interface DOFs + fixed-interface modes"),
        (format!("{:.1e}", report.largest_frequency_error(f64::INFINITY)), "largest relative error of a frequency"),
        (format!("{mac:.6}"), "lowest MAC"),
        (format!("{statics:.0e}"), "largest error of a static stiffness"),
        (format!("{} below {last:.0} Hz", report.modes.len()), "modes compared"),
    ];
    page.push_str("<div class=\"figures\">");
    for (figure, words) in items {
        put(page, format_args!("<div><div class=\"figure\">{figure}</div><span>{words}</span></div>"));
    }
    page.push_str("</div>\n");
}

fn frequencies(page: &mut String, report: &QualityReport) -> Result<(), PlotError> {
    page.push_str("<h2>Natural frequencies</h2>\n");
    page.push_str(&error_plot(report)?);
    put(page, format_args!("<details><summary>{} modes</summary>\n", report.modes.len()));
    page.push_str("<div class=\"scroll\"><table><tr><th>mode</th><th>full (Hz)</th><th>reduced (Hz)</th><th>relative error</th><th>MAC</th>");
    if report.total_mass_kg.is_some() {
        page.push_str(
            "<th>effective mass x (%)</th><th>y (%)</th><th>z (%)</th><th>reduced x</th><th>y</th><th>z</th>",
        );
    }
    page.push_str("</tr>\n");
    for (index, mode) in report.modes.iter().enumerate() {
        let error = mode.relative_error.map_or("rigid".to_owned(), |error| format!("{error:.2e}"));
        put(
            page,
            format_args!(
                "<tr><td>{}</td><td>{:.4}</td><td>{:.4}</td><td>{error}</td><td>{:.6}</td>",
                index + 1,
                mode.full_hz,
                mode.reduced_hz,
                mode.mac
            ),
        );
        for share in [mode.effective_mass_full, mode.effective_mass_reduced].into_iter().flatten() {
            for value in share {
                put(page, format_args!("<td>{:.2}</td>", 100.0 * value));
            }
        }
        page.push_str("</tr>\n");
    }
    page.push_str("</table></div></details>\n");
    if let Some([x, y, z]) = report.total_mass_kg {
        let sum = |axis: usize| {
            100.0
                * report.modes.iter().filter_map(|mode| mode.effective_mass_full).map(|share| share[axis]).sum::<f64>()
        };
        put(
            page,
            format_args!(
                "<p>Total mass {x:.1}, {y:.1}, {z:.1} kg along x, y, z; the modes shown move {:.1}, {:.1}, {:.1} % of it.</p>\n",
                sum(0),
                sum(1),
                sum(2)
            ),
        );
    } else {
        page.push_str("<p>Effective masses need the directions of the rows (dof_file or dofs_per_node).</p>\n");
    }
    Ok(())
}

/// Curves that are not folded away.
const SHOWN_CURVES: usize = 4;
/// Size of a plot in pixels.
const PLOT: (u32, u32) = (900, 420);

fn error_plot(report: &QualityReport) -> Result<String, PlotError> {
    let error = |mode: &ModePair| Some((mode.full_hz, mode.relative_error?.abs().max(1e-16)));
    let errors = Series {
        name: String::new(),
        color: REDUCED,
        points: report.modes.iter().filter_map(error).collect(),
        line: Line::None,
        marker: Marker::Disc,
    };
    let chart = Chart {
        title: "relative error of the reduced frequencies".to_owned(),
        x: Axis::logarithmic("frequency (Hz)"),
        y: Axis::logarithmic("relative error (1)"),
        series: vec![errors],
    };
    let svg = panels(&[chart], PLOT)?;
    Ok(format!("<div class=\"plot\" style=\"max-width:42rem\">{svg}</div>\n"))
}

fn stiffness(page: &mut String, report: &QualityReport) {
    page.push_str("<h2>Static stiffness of the interface</h2>\n");
    if report.static_stiffness.is_empty() {
        page.push_str("<p>The structure floats: it has no static stiffness.</p>\n");
        return;
    }
    put(page, format_args!("<details><summary>{} directions</summary>\n", report.static_stiffness.len()));
    page.push_str("<div class=\"scroll\"><table><tr><th>DOF</th><th>full (N/m, N m/rad)</th><th>reduced</th><th>relative error</th></tr>\n");
    for one in &report.static_stiffness {
        put(
            page,
            format_args!(
                "<tr><td>{}</td><td>{:.6e}</td><td>{:.6e}</td><td>{:.1e}</td></tr>\n",
                escape(&one.dof),
                one.full,
                one.reduced,
                one.relative_error
            ),
        );
    }
    page.push_str("</table></div></details>\n");
}

fn mobility(page: &mut String, report: &QualityReport) -> Result<(), PlotError> {
    page.push_str(
        "<h2>Mobility</h2>\n<p>Velocity per force. Drive points first, then pairs of points in the same direction.</p>\n<div class=\"curves\">\n",
    );
    let (shown, folded) = report.mobility.split_at(report.mobility.len().min(SHOWN_CURVES));
    for curve in shown {
        page.push_str(&mobility_plot(curve, &report.frequency_hz)?);
    }
    page.push_str("</div>\n");
    if !folded.is_empty() {
        put(
            page,
            format_args!("<details><summary>further curves ({})</summary>\n<div class=\"curves\">\n", folded.len()),
        );
        for curve in folded {
            page.push_str(&mobility_plot(curve, &report.frequency_hz)?);
        }
        page.push_str("</div></details>\n");
    }
    Ok(())
}

fn mobility_plot(curve: &MobilityCurve, hz: &[f64]) -> Result<String, PlotError> {
    let title = if curve.response == curve.force {
        format!("drive point {}", curve.response)
    } else {
        format!("{} under a force at {}", curve.response, curve.force)
    };
    let series = |name: &str, (color, line), values: &[f64]| Series {
        name: name.to_owned(),
        color,
        points: hz.iter().copied().zip(values.iter().copied()).collect(),
        line,
        marker: Marker::None,
    };
    let chart = Chart {
        title: format!("{title}; largest difference {:.1e}", curve.largest_relative_difference),
        x: Axis::logarithmic("frequency (Hz)"),
        y: Axis::logarithmic("mobility (m/(s N))"),
        series: vec![
            series("full model", (FULL, Line::Solid), &curve.full),
            series("reduced", (REDUCED, Line::Dashed), &curve.reduced),
        ],
    };
    Ok(format!("<div class=\"plot\">{}</div>\n", panels(&[chart], PLOT)?))
}

fn conditions(page: &mut String, report: &QualityReport) {
    let number = |value: Option<f64>| value.map_or("none".to_owned(), |value| format!("{value:.1e}"));
    let conditions = &report.conditions;
    page.push_str(
        "<h2>Condition numbers</h2>\n<div class=\"scroll\"><table><tr><th>matrix</th><th>condition</th></tr>\n",
    );
    for (name, value) in [
        ("stiffness of the full model", conditions.full_stiffness),
        ("stiffness of the inner rows", conditions.inner_stiffness),
        ("reduced stiffness", conditions.reduced_stiffness),
        ("reduced mass", conditions.reduced_mass),
    ] {
        put(page, format_args!("<tr><td>{name}</td><td>{}</td></tr>\n", number(value)));
    }
    page.push_str(
        "</table></div>\n<h2>Time and memory</h2>\n<div class=\"scroll\"><table><tr><th>step</th><th>time (s)</th><th>peak memory (MB)</th></tr>\n",
    );
    for step in &report.steps {
        let memory = step.peak_bytes.map_or("unknown".to_owned(), |bytes| format!("{:.0}", bytes as f64 / 1e6));
        put(
            page,
            format_args!("<tr><td>{}</td><td>{:.3}</td><td>{memory}</td></tr>\n", escape(&step.name), step.time_s),
        );
    }
    page.push_str("</table></div>\n");
}

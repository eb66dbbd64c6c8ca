//! The quality report as one HTML page that needs nothing else: tables, and plots as inline SVG.

use std::fmt::Write as _;

use super::quality::{MobilityCurve, QualityReport};

const STYLE: &str = "body{font:14px/1.45 system-ui,sans-serif;color:#1c2430;margin:2rem auto;max-width:64rem;padding:0 1rem}\
h1{font-size:1.5rem;margin-bottom:.2rem}h2{font-size:1.1rem;margin-top:2rem}p{max-width:46rem}\
table{border-collapse:collapse;font-variant-numeric:tabular-nums}th,td{padding:.15rem .7rem;text-align:right;border-bottom:1px solid #e3e7ec}\
th{font-weight:600;background:#f5f7f9}td:first-child,th:first-child{text-align:left}.scroll{overflow-x:auto}\
.curves{display:grid;grid-template-columns:repeat(auto-fill,minmax(30rem,1fr));gap:.5rem}svg{width:100%;height:auto}\
.figure{font-size:1.3rem;font-weight:600}.figures{display:flex;flex-wrap:wrap;gap:2rem}.figures span{display:block;color:#5a6675}";
const FULL: &str = "#c2410c";
const REDUCED: &str = "#0369a1";

/// The page. `title`: what was reduced.
pub fn quality_page(report: &QualityReport, title: &str) -> String {
    let mut page = String::new();
    let title = escape(title);
    put(
        &mut page,
        format_args!(
            "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{title}</title><style>{STYLE}</style></head><body>\n"
        ),
    );
    put(
        &mut page,
        format_args!("<h1>{title}</h1>\n<p>The reduced structure beside its full finite element model.</p>\n"),
    );
    figures(&mut page, report);
    frequencies(&mut page, report);
    stiffness(&mut page, report);
    mobility(&mut page, report);
    conditions(&mut page, report);
    page.push_str("</body></html>\n");
    page
}

/// Writing to a string cannot fail.
fn put(page: &mut String, text: std::fmt::Arguments) {
    let _ = page.write_fmt(text);
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
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

fn frequencies(page: &mut String, report: &QualityReport) {
    page.push_str("<h2>Natural frequencies</h2>\n");
    page.push_str(&error_plot(report));
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
    page.push_str("</table></div>\n");
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
}

/// A frame with two logarithmic axes.
struct Axes {
    x: [f64; 2],
    y: [f64; 2],
}

impl Axes {
    const LEFT: f64 = 70.0;
    const RIGHT: f64 = 630.0;
    const TOP: f64 = 34.0;
    const BOTTOM: f64 = 250.0;

    fn new(xs: impl Iterator<Item = f64>, ys: impl Iterator<Item = f64>) -> Self {
        let range = |values: &mut dyn Iterator<Item = f64>| {
            let logs = values.filter(|value| *value > 0.0 && value.is_finite()).map(f64::log10);
            let (low, high) = logs.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
            if low > high { [0.0, 1.0] } else { [low, high.max(low + 0.1)] }
        };
        let (mut xs, mut ys) = (xs, ys);
        let [low, high] = range(&mut ys);
        Self { x: range(&mut xs), y: [low.floor(), high.ceil().max(low.floor() + 1.0)] }
    }

    fn x(&self, value: f64) -> f64 {
        Self::LEFT + (value.log10() - self.x[0]) / (self.x[1] - self.x[0]) * (Self::RIGHT - Self::LEFT)
    }

    fn y(&self, value: f64) -> f64 {
        let log = value.max(f64::MIN_POSITIVE).log10().max(self.y[0]);
        Self::BOTTOM - (log - self.y[0]) / (self.y[1] - self.y[0]) * (Self::BOTTOM - Self::TOP)
    }

    fn frame(&self, title: &str, x_name: &str) -> String {
        let (left, right, top, bottom) = (Self::LEFT, Self::RIGHT, Self::TOP, Self::BOTTOM);
        let mut svg = format!(
            "<svg viewBox=\"0 0 660 300\" font-family=\"system-ui,sans-serif\" font-size=\"12\" role=\"img\"><text x=\"{left}\" y=\"20\" font-weight=\"600\">{}</text>",
            escape(title)
        );
        let step = ((self.y[1] - self.y[0]) / 6.0).ceil().max(1.0) as usize;
        for decade in (self.y[0] as i32..=self.y[1] as i32).step_by(step) {
            let y = self.y(10_f64.powi(decade));
            put(
                &mut svg,
                format_args!(
                    "<path d=\"M{left} {y:.1}H{right}\" stroke=\"#e3e7ec\"/><text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\" fill=\"#5a6675\">1e{decade}</text>",
                    left - 8.0,
                    y + 4.0
                ),
            );
        }
        for decade in self.x[0].floor() as i32..=self.x[1].ceil() as i32 {
            for factor in [1.0, 2.0, 5.0] {
                let value = factor * 10_f64.powi(decade);
                let x = self.x(value);
                if (left - 0.5..=right + 0.5).contains(&x) {
                    put(
                        &mut svg,
                        format_args!(
                            "<path d=\"M{x:.1} {top}V{bottom}\" stroke=\"#e3e7ec\"/><text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\" fill=\"#5a6675\">{value}</text>",
                            bottom + 18.0
                        ),
                    );
                }
            }
        }
        put(
            &mut svg,
            format_args!(
                "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\" fill=\"#5a6675\">{x_name}</text>",
                (left + right) / 2.0,
                bottom + 38.0
            ),
        );
        svg
    }

    fn line(&self, xs: &[f64], ys: &[f64], style: &str) -> String {
        let points: Vec<String> =
            xs.iter().zip(ys).map(|(x, y)| format!("{:.1},{:.1}", self.x(*x), self.y(*y))).collect();
        format!("<polyline points=\"{}\" fill=\"none\" {style}/>", points.join(" "))
    }
}

fn error_plot(report: &QualityReport) -> String {
    let pairs: Vec<(f64, f64)> =
        report.modes.iter().filter_map(|mode| Some((mode.full_hz, mode.relative_error?.abs().max(1e-16)))).collect();
    let axes = Axes::new(pairs.iter().map(|pair| pair.0), pairs.iter().map(|pair| pair.1));
    let mut svg = axes.frame("relative error of the reduced frequencies", "frequency (Hz)");
    for (hz, error) in pairs {
        put(
            &mut svg,
            format_args!("<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"3.5\" fill=\"{REDUCED}\"/>", axes.x(hz), axes.y(error)),
        );
    }
    svg.push_str("</svg>\n");
    format!("<div style=\"max-width:42rem\">{svg}</div>")
}

fn stiffness(page: &mut String, report: &QualityReport) {
    page.push_str("<h2>Static stiffness of the interface</h2>\n");
    if report.static_stiffness.is_empty() {
        page.push_str("<p>The structure floats: it has no static stiffness.</p>\n");
        return;
    }
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
    page.push_str("</table></div>\n");
}

fn mobility(page: &mut String, report: &QualityReport) {
    put(
        page,
        format_args!(
            "<h2>Mobility</h2>\n<p>Velocity per force in m/(s N): <b style=\"color:{FULL}\">full model</b>, <b style=\"color:{REDUCED}\">reduced structure (dashed)</b>. Drive points first, then pairs of points in the same direction.</p>\n<div class=\"curves\">\n"
        ),
    );
    for curve in &report.mobility {
        page.push_str(&mobility_plot(curve, &report.frequency_hz));
    }
    page.push_str("</div>\n");
}

fn mobility_plot(curve: &MobilityCurve, hz: &[f64]) -> String {
    let axes = Axes::new(hz.iter().copied(), curve.full.iter().chain(&curve.reduced).copied());
    let title = if curve.response == curve.force {
        format!("drive point {}", curve.response)
    } else {
        format!("{} under a force at {}", curve.response, curve.force)
    };
    let title = format!("{title}; largest difference {:.1e}", curve.largest_relative_difference);
    let full = axes.line(hz, &curve.full, &format!("stroke=\"{FULL}\" stroke-width=\"2.5\" opacity=\"0.7\""));
    let reduced =
        axes.line(hz, &curve.reduced, &format!("stroke=\"{REDUCED}\" stroke-width=\"1.4\" stroke-dasharray=\"6 4\""));
    format!("{}{full}{reduced}</svg>\n", axes.frame(&title, "frequency (Hz)"))
}

fn conditions(page: &mut String, report: &QualityReport) {
    let number = |value: Option<f64>| value.map_or("none".to_owned(), |value| format!("{value:.1e}"));
    let conditions = &report.conditions;
    page.push_str("<h2>Condition numbers</h2>\n<table><tr><th>matrix</th><th>condition</th></tr>\n");
    for (name, value) in [
        ("stiffness of the full model", conditions.full_stiffness),
        ("stiffness of the inner rows", conditions.inner_stiffness),
        ("reduced stiffness", conditions.reduced_stiffness),
        ("reduced mass", conditions.reduced_mass),
    ] {
        put(page, format_args!("<tr><td>{name}</td><td>{}</td></tr>\n", number(value)));
    }
    page.push_str(
        "</table>\n<h2>Time and memory</h2>\n<table><tr><th>step</th><th>time (s)</th><th>peak memory (MB)</th></tr>\n",
    );
    for step in &report.steps {
        let memory = step.peak_bytes.map_or("unknown".to_owned(), |bytes| format!("{:.0}", bytes as f64 / 1e6));
        put(
            page,
            format_args!("<tr><td>{}</td><td>{:.3}</td><td>{memory}</td></tr>\n", escape(&step.name), step.time_s),
        );
    }
    page.push_str("</table>\n");
}

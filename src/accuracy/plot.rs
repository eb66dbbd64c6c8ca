//! The comparison as a log-log plot.

use plotters::prelude::*;

use super::{Accuracy, Measurement, Setting};

/// Size in pixels.
const SIZE: (u32, u32) = (900, 600);
/// Colours of the families, told apart with colour-blind eyes too (Okabe and Ito 2008).
const COLORS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(110, 110, 110),
];
/// Outlines of markers, by method, in pixels.
const OUTLINES: [&[(i32, i32)]; 4] = [
    &[(-4, -2), (-2, -4), (2, -4), (4, -2), (4, 2), (2, 4), (-2, 4), (-4, 2)],
    &[(-5, 4), (5, 4), (0, -5)],
    &[(-4, -4), (4, -4), (4, 4), (-4, 4)],
    &[(-5, 0), (0, -5), (5, 0), (0, 5)],
];
/// Least error that is drawn: zero has no logarithm.
const LEAST_ERROR: f64 = 1e-12;

/// Error against time as SVG, a line per family of settings, a marker per method; the floors are dashed.
///
/// # Errors
/// The plotting library's words, if nothing can be drawn (no setting reached its end).
pub fn plot(accuracy: &Accuracy) -> Result<String, String> {
    let mut svg = String::new();
    draw(accuracy, &mut svg).map_err(|error| error.to_string())?;
    Ok(svg)
}

fn point(accuracy: &Accuracy, measurement: &Measurement) -> (f64, f64) {
    (measurement.ms_per_simulated_s, accuracy.worst(&measurement.errors).max(LEAST_ERROR))
}

/// Outline of the marker of a setting's method, in pixels around its point; upside down if events are located.
fn marker(setting: &Setting) -> Vec<(i32, i32)> {
    let stepping = setting.solver.stepping;
    let outline = OUTLINES[stepping.method as usize % OUTLINES.len()].iter();
    outline.map(|&(x, y)| (x, if stepping.located { -y } else { y })).collect()
}

/// What limits all settings: its name and its largest error.
fn floors(accuracy: &Accuracy) -> Vec<(&'static str, f64)> {
    let all = [
        ("sensitivity of the scene", Some(&accuracy.sensitivity)),
        ("modes left out", accuracy.truncation.as_ref().map(|(_, errors)| errors)),
    ];
    let errors = all.into_iter().filter_map(|(name, errors)| Some((name, accuracy.worst(errors?).max(LEAST_ERROR))));
    errors.filter(|(_, error)| error.is_finite()).collect()
}

/// The families, each by its first setting.
fn families(accuracy: &Accuracy) -> Vec<&Setting> {
    let mut families: Vec<&Setting> = Vec::new();
    for Measurement { setting, .. } in &accuracy.measurements {
        if families.iter().all(|known| known.family != setting.family) {
            families.push(setting);
        }
    }
    families
}

fn draw(accuracy: &Accuracy, svg: &mut String) -> Result<(), Box<dyn std::error::Error>> {
    let points = accuracy.measurements.iter().map(|measurement| point(accuracy, measurement));
    let drawn: Vec<(f64, f64)> = points.filter(|(x, y)| x.is_finite() && y.is_finite()).collect();
    let floors = floors(accuracy);
    let x = range(drawn.iter().map(|point| point.0));
    let y = range(drawn.iter().map(|point| point.1).chain(floors.iter().map(|floor| floor.1)));
    let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&root)
        .margin(12)
        .margin_right(36)
        .x_label_area_size(44)
        .y_label_area_size(64)
        .build_cartesian_2d((x.0..x.1).log_scale(), (y.0..y.1).log_scale())?;
    chart
        .configure_mesh()
        .x_desc("ms per simulated second")
        .y_desc("largest relative error of energies, frequency and peak velocity")
        .y_label_formatter(&|error| format!("{error:.0e}"))
        .draw()?;
    for (index, first) in families(accuracy).into_iter().enumerate() {
        let color = COLORS[index % COLORS.len()];
        let of_family = accuracy.measurements.iter().filter(|measurement| measurement.setting.family == first.family);
        let points = of_family.map(|measurement| point(accuracy, measurement));
        let points: Vec<(f64, f64)> = points.filter(|(x, y)| x.is_finite() && y.is_finite()).collect();
        let marker = marker(first);
        let marked = |at| EmptyElement::at(at) + Polygon::new(marker.clone(), color.filled());
        chart.draw_series(points.iter().copied().map(marked))?;
        let key = marker.clone();
        chart.draw_series(LineSeries::new(points, color.stroke_width(2)))?.label(&first.family).legend(move |at| {
            let line = PathElement::new([(0, 0), (20, 0)], color.stroke_width(2));
            let middle = key.iter().map(|(x, y)| (x + 10, *y)).collect::<Vec<_>>();
            EmptyElement::at(at) + line + Polygon::new(middle, color.filled())
        });
    }
    for (index, (name, error)) in floors.into_iter().enumerate() {
        let color = if index == 0 { BLACK } else { RGBColor(150, 80, 0) };
        chart
            .draw_series(DashedLineSeries::new([(x.0, error), (x.1, error)], 6, 4, color.into()))?
            .label(name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], color));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::LowerLeft)
        .background_style(WHITE.mix(0.8))
        .border_style(BLACK)
        .draw()?;
    root.present()?;
    Ok(())
}

/// Whole decades around the values.
fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (least, largest) =
        values.fold((f64::INFINITY, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)));
    if !(least > 0.0 && least <= largest) {
        return (LEAST_ERROR, 1.0);
    }
    (10f64.powf(least.log10().floor()), 10f64.powf((largest.log10() + 1e-9).ceil()))
}

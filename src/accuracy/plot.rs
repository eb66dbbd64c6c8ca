//! The comparison as a log-log plot.

use super::{Accuracy, Measurement, Setting};
use crate::plot::{Axis, BLACK, COLORS, Chart, Color, Line, Marker, PlotError, Series, panels};

/// Size in pixels.
const SIZE: (u32, u32) = (1100, 600);
/// Colours of the floors, which no setting goes below.
const FLOORS: [Color; 2] = [BLACK, (150, 80, 0)];
/// Least error that is drawn: zero has no logarithm.
const LEAST_ERROR: f64 = 1e-12;

/// Error against time as SVG, a line per family of settings, a marker per method; the floors are dashed.
///
/// # Errors
/// The plotting library's words.
pub fn plot(accuracy: &Accuracy) -> Result<String, PlotError> {
    let families = families(accuracy).into_iter().enumerate().map(|(index, first)| {
        let of_family = accuracy.measurements.iter().filter(|measurement| measurement.setting.family == first.family);
        Series {
            name: first.family.clone(),
            color: COLORS[index % COLORS.len()],
            points: of_family.map(|measurement| point(accuracy, measurement)).collect(),
            line: Line::Solid,
            marker: marker(first),
        }
    });
    let mut series: Vec<Series> = families.collect();
    let drawn = series.iter().flat_map(|one| &one.points).filter(|(x, y)| x.is_finite() && y.is_finite());
    let (least, most) = drawn.fold((f64::INFINITY, 0.0_f64), |(low, high), (x, _)| (low.min(*x), high.max(*x)));
    series.extend(floors(accuracy).into_iter().zip(FLOORS).map(|((name, error), color)| Series {
        name: name.to_owned(),
        color,
        points: vec![(least, error), (most, error)],
        line: Line::Dashed,
        marker: Marker::None,
    }));
    let chart = Chart {
        title: String::new(),
        x: Axis::logarithmic("computing time (ms per simulated second)"),
        y: Axis::logarithmic("largest relative error of energies, frequency and peak velocity (1)"),
        series,
    };
    panels(&[chart], SIZE)
}

fn point(accuracy: &Accuracy, measurement: &Measurement) -> (f64, f64) {
    (measurement.ms_per_simulated_s, accuracy.worst(&measurement.errors).max(LEAST_ERROR))
}

/// Markers of the methods, in their order.
const MARKERS: [Marker; 3] = [Marker::Disc, Marker::Up, Marker::Square];

/// The marker of a setting's method; upside down if a fixed step's events are located.
fn marker(setting: &Setting) -> Marker {
    let solver = setting.solver;
    match MARKERS[solver.method as usize % MARKERS.len()] {
        Marker::Up if solver.located => Marker::Down,
        marker => marker,
    }
}

/// Errors that limit all settings: name and largest error.
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

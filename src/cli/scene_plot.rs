//! The picture of a row: motions, casting, work and machine over time.

use crate::plot::{Axis, COLORS, Chart, Color, Line, Marker, PlotError, Series, panels, thinned};
use decore_model::metrics::{Blow, HammerSignals, Signal};

/// Size in pixels: its width, and the height of a panel.
const SIZE: (u32, u32) = (1200, 230);
/// Columns into which curves are thinned, about the pixels of an axis.
const COLUMNS: usize = 900;
/// Curves of each hammer, panel by panel: signal, what the legend says of it.
const PANELS: [Panel; 4] = [
    Panel {
        axis: "position (m)",
        curves: &[(HammerSignals::extension_m.name, "cylinder"), (HammerSignals::piston_m.name, "piston in it")],
    },
    Panel { axis: "casting (m/s)", curves: &[(HammerSignals::casting_velocity_m_s.name, "casting at the strike")] },
    Panel { axis: "work done (J)", curves: &[(HammerSignals::delivered_work_j.name, "work on the casting")] },
    Panel { axis: "machine (m/s)", curves: &[(HammerSignals::arm_velocity_m_s.name, "mount")] },
];
/// The panel that shows blows.
const BLOWS: usize = 1;

/// A panel of the picture: its axis, and each hammer's curves by signal and name.
struct Panel {
    axis: &'static str,
    curves: &'static [(&'static str, &'static str)],
}

/// Data of a row's picture.
pub(super) struct Picture<'a> {
    pub title: String,
    pub hammers: Vec<&'a str>,
    pub signals: &'a [Signal],
    pub blows: &'a [Blow],
}

/// Four panels over time as SVG: cylinder and piston, casting with the blows, work on the casting, the machine at the mount.
pub(super) fn scene_plot(picture: &Picture<'_>) -> Result<String, PlotError> {
    let charts: Vec<Chart> = PANELS.iter().enumerate().map(|(index, panel)| chart(picture, index, panel)).collect();
    panels(&charts, (SIZE.0, SIZE.1 * charts.len() as u32))
}

fn chart(picture: &Picture<'_>, index: usize, panel: &Panel) -> Chart {
    let last = index + 1 == PANELS.len();
    let mut series = Vec::new();
    for (h, hammer) in picture.hammers.iter().enumerate() {
        for (c, (signal, what)) in panel.curves.iter().enumerate() {
            let name = if picture.hammers.len() == 1 { (*what).to_owned() } else { format!("{hammer}: {what}") };
            let line = if c == 0 { Line::Solid } else { Line::Dashed };
            let points = points(picture.signals, &format!("{hammer}_{signal}"));
            // One hammer's curves differ by colour; those of several share their hammer's and differ by their dashes.
            let of = if picture.hammers.len() == 1 { c } else { h };
            series.push(Series { name, color: color(of), points, line, marker: Marker::None });
        }
        if index == BLOWS {
            let of_hammer = picture.blows.iter().filter(|blow| blow.hammer == h);
            let (name, of) = match picture.hammers.len() {
                1 => ("blow, its peak".to_owned(), 3),
                _ => (format!("{hammer}: blow, its peak"), h),
            };
            let points = of_hammer.map(|blow| (blow.start_time_s, blow.casting_peak_velocity_m_s)).collect();
            series.push(Series { name, color: color(of), points, line: Line::None, marker: Marker::Down });
        }
    }
    let time = if last { "time (s)" } else { "" };
    let title = if index == 0 { picture.title.clone() } else { String::new() };
    Chart { title, x: Axis::linear(time), y: Axis::linear(panel.axis), series }
}

fn color(index: usize) -> Color {
    COLORS[index % COLORS.len()]
}

/// A signal over time, thinned; empty if it was not recorded.
fn points(signals: &[Signal], name: &str) -> Vec<(f64, f64)> {
    let (Some(time), Some(signal)) = (signals.first(), signals.iter().find(|signal| signal.name == name)) else {
        return Vec::new();
    };
    let all: Vec<(f64, f64)> = time.values.iter().copied().zip(signal.values.iter().copied()).collect();
    thinned(&all, COLUMNS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_of_one_hammer_share_its_colour_where_there_are_several() {
        let colours = |hammers: Vec<&str>, panel: usize| {
            let picture = Picture { title: String::new(), hammers, signals: &[], blows: &[] };
            let chart = chart(&picture, panel, &PANELS[panel]);
            chart.series.iter().map(|series| (series.name.clone(), series.color)).collect::<Vec<_>>()
        };
        let two = colours(vec!["left", "right"], 0);
        assert_eq!(two[0], ("left: cylinder".to_owned(), COLORS[0]));
        assert_eq!(two[1], ("left: piston in it".to_owned(), COLORS[0]));
        assert!(two[2..].iter().all(|(_, colour)| *colour == COLORS[1]), "{two:?}");
        assert_eq!(colours(vec!["left", "right"], BLOWS)[3], ("right: blow, its peak".to_owned(), COLORS[1]));
        let one = colours(vec!["left"], 0);
        assert_ne!(one[0].1, one[1].1);
    }
}

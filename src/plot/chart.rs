//! Charts: series over two axes, one below the other.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::Color as _;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::axis::{Axis, Scale};
use super::style::{Color, PlotError};

/// Size of letters in pixels.
const LETTERS: u32 = 14;
/// Width of a letter of that size, about.
const LETTER_WIDTH: u32 = 8;
/// Length of a line in the legend.
const SAMPLE: i32 = 26;
/// Length of dashes and of the gaps between them.
const DASHES: (u32, u32) = (7, 5);
/// Space for the labels below and left of a chart.
const LABELS: (u32, u32) = (44, 76);

/// Connection of the points of a series.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Line {
    /// Not at all.
    None,
    /// By a line.
    Solid,
    /// By a dashed line.
    Dashed,
}

/// Marker at the points of a series.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marker {
    /// Nothing.
    None,
    /// A disc.
    Disc,
    /// A triangle, point up.
    Up,
    /// A triangle, point down.
    Down,
    /// A square.
    Square,
}

/// One series of points.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Name in the legend; empty: none.
    pub name: String,
    /// Colour.
    pub color: Color,
    /// The points; those that are not finite are left out.
    pub points: Vec<(f64, f64)>,
    /// Connection of the points.
    pub line: Line,
    /// Marker at the points.
    pub marker: Marker,
}

/// Series over two axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// Title; empty: none.
    pub title: String,
    /// The axis across.
    pub x: Axis,
    /// The axis upwards.
    pub y: Axis,
    /// Series; later ones are drawn above earlier ones.
    pub series: Vec<Series>,
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Coordinates = Cartesian2d<Scale, Scale>;

/// Charts of one width, one below the other, as SVG of `size` pixels.
///
/// # Errors
/// The plotting library's words.
pub fn panels(charts: &[Chart], size: (u32, u32)) -> Result<String, PlotError> {
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        root.fill(&WHITE).map_err(PlotError::of)?;
        // One width for all legends: the charts' axes lie above each other.
        let legend = charts.iter().map(legend_width).max().unwrap_or(0).min(size.0 / 2);
        for (area, chart) in root.split_evenly((charts.len().max(1), 1)).iter().zip(charts) {
            let (left, right) = area.split_horizontally(size.0 - legend);
            draw(chart, &left)?;
            draw_legend(chart, &right)?;
        }
        root.present().map_err(PlotError::of)?;
    }
    Ok(svg)
}

fn rgb((red, green, blue): Color) -> RGBColor {
    RGBColor(red, green, blue)
}

fn legend_width(chart: &Chart) -> u32 {
    let longest = chart.series.iter().map(|series| series.name.chars().count() as u32).max().unwrap_or(0);
    if longest == 0 { 0 } else { SAMPLE as u32 + 24 + LETTER_WIDTH * longest }
}

fn draw(chart: &Chart, area: &Area<'_>) -> Result<(), PlotError> {
    let all = || chart.series.iter().flat_map(|series| &series.points);
    let x = chart.x.scale(all().map(|point| point.0));
    let y = chart.y.scale(all().map(|point| point.1));
    let mut builder = ChartBuilder::on(area);
    builder.margin(10).margin_right(24).x_label_area_size(LABELS.0).y_label_area_size(LABELS.1);
    if !chart.title.is_empty() {
        builder.caption(&chart.title, ("sans-serif", LETTERS + 1));
    }
    let mut drawn = builder.build_cartesian_2d(x, y).map_err(PlotError::of)?;
    drawn
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(RGBColor(227, 231, 236))
        .axis_style(RGBColor(120, 130, 140))
        .label_style(("sans-serif", LETTERS))
        .x_desc(&chart.x.label)
        .y_desc(&chart.y.label)
        .draw()
        .map_err(PlotError::of)?;
    for series in &chart.series {
        draw_series(chart, series, &mut drawn)?;
    }
    Ok(())
}

fn draw_series(
    chart: &Chart,
    series: &Series,
    drawn: &mut ChartContext<'_, SVGBackend<'_>, Coordinates>,
) -> Result<(), PlotError> {
    let color = rgb(series.color);
    let places = series.points.iter().map(|(x, y)| (chart.x.place(*x), chart.y.place(*y)));
    let places: Vec<(f64, f64)> = places.filter(|(x, y)| x.is_finite() && y.is_finite()).collect();
    let line = color.stroke_width(2);
    match series.line {
        Line::None => {}
        Line::Solid => drop(drawn.draw_series(LineSeries::new(places.clone(), line)).map_err(PlotError::of)?),
        Line::Dashed => {
            let dashed = DashedLineSeries::new(places.clone(), DASHES.0, DASHES.1, line);
            drawn.draw_series(dashed).map_err(PlotError::of)?;
        }
    }
    let outline = outline(series.marker);
    if !outline.is_empty() {
        let marked = |at| EmptyElement::at(at) + Polygon::new(outline.clone(), color.filled());
        drawn.draw_series(places.into_iter().map(marked)).map_err(PlotError::of)?;
    }
    Ok(())
}

/// Outline of a marker in pixels around its point.
fn outline(marker: Marker) -> Vec<(i32, i32)> {
    match marker {
        Marker::None => Vec::new(),
        Marker::Disc => vec![(-4, -2), (-2, -4), (2, -4), (4, -2), (4, 2), (2, 4), (-2, 4), (-4, 2)],
        Marker::Up => vec![(-5, 4), (5, 4), (0, -5)],
        Marker::Down => vec![(-5, -4), (5, -4), (0, 5)],
        Marker::Square => vec![(-4, -4), (4, -4), (4, 4), (-4, 4)],
    }
}

/// Draws the names with samples of lines, dashes and markers next to the chart.
fn draw_legend(chart: &Chart, area: &Area<'_>) -> Result<(), PlotError> {
    let style = TextStyle::from(("sans-serif", LETTERS).into_font()).pos(Pos::new(HPos::Left, VPos::Center));
    for (index, series) in chart.series.iter().filter(|series| !series.name.is_empty()).enumerate() {
        let (color, y) = (rgb(series.color), 24 + 22 * index as i32);
        let dashes = match series.line {
            Line::None => vec![],
            Line::Solid => vec![(0, SAMPLE)],
            Line::Dashed => {
                let (dash, gap) = (DASHES.0 as i32, DASHES.1 as i32);
                (0..SAMPLE).step_by((dash + gap) as usize).map(|from| (from, (from + dash).min(SAMPLE))).collect()
            }
        };
        for (from, to) in dashes {
            area.draw(&PathElement::new([(from, y), (to, y)], color.stroke_width(2))).map_err(PlotError::of)?;
        }
        let outline: Vec<(i32, i32)> =
            outline(series.marker).into_iter().map(|(dx, dy)| (dx + SAMPLE / 2, dy + y)).collect();
        if !outline.is_empty() {
            area.draw(&Polygon::new(outline, color.filled())).map_err(PlotError::of)?;
        }
        area.draw(&Text::new(series.name.clone(), (SAMPLE + 8, y), style.clone())).map_err(PlotError::of)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{Axis, Chart, Line, Marker, Series, panels};

    fn chart() -> Chart {
        let series = |name: &str, line, points| Series {
            name: name.to_owned(),
            color: (1, 2, 3),
            points,
            line,
            marker: Marker::Square,
        };
        Chart {
            title: "work <and> more".into(),
            x: Axis::linear("time (s)"),
            y: Axis::logarithmic("error (1)"),
            series: vec![
                series("a & b", Line::Solid, vec![(0.0, 1.0), (1.0, f64::NAN), (2.0, 1e-3)]),
                series("bound", Line::Dashed, vec![(0.0, 0.1), (2.0, 0.1)]),
                series("", Line::None, vec![(1.0, 0.0)]),
            ],
        }
    }

    #[test]
    fn names_are_text_and_points_that_cannot_be_drawn_are_left_out() {
        let svg = panels(&[chart(), chart()], (640, 480)).expect("drawn");
        for text in ["work &lt;and&gt; more", "a &amp; b", "time (s)", "error (1)", "bound"] {
            assert_eq!(svg.matches(text).count(), 2, "{text}: {svg}");
        }
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        // Two points and their sample, two points of the bound and its sample; zero has no logarithm.
        assert_eq!(svg.matches("<polygon").count(), 2 * 6, "{svg}");
    }

    #[test]
    fn a_chart_without_points_is_drawn() {
        let empty = Chart { series: Vec::new(), ..chart() };
        assert!(panels(&[empty], (300, 200)).expect("drawn").ends_with("</svg>\n"));
        assert!(panels(&[], (300, 200)).is_ok());
    }
}

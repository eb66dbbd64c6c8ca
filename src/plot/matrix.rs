//! A scatter matrix: every factor of a design against every other one.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::style::{COLORS, PlotError};

/// Side of one panel in pixels, and the space between panels.
const PANEL: i32 = 120;
const GAP: i32 = 12;
/// Space for names at the edges, and for the title above.
const MARGIN: i32 = 44;
/// Width of a letter of the title, about.
const LETTER_WIDTH: i32 = 8;
/// Space within a panel, so that points at the ends of a range stay inside.
const INSET: f64 = 4.0;
/// Most characters of a domain: as many as a panel is wide.
const LABEL: usize = 24;
/// Bars of a histogram.
const BARS: usize = 12;

/// One factor of the picture.
#[derive(Debug, Clone, PartialEq)]
pub struct MatrixFactor {
    /// Name.
    pub name: String,
    /// Domain in words; cut to the width of a panel.
    pub domain: String,
    /// Position of each row in the range, in [0, 1].
    pub shares: Vec<f64>,
}

/// Every factor against every other one, histograms on the diagonal, below a title, as SVG. All factors must have as many rows.
///
/// # Errors
/// The plotting library's words.
pub fn scatter_matrix(title: &str, factors: &[MatrixFactor]) -> Result<String, PlotError> {
    let side = 2 * MARGIN + factors.len() as i32 * (PANEL + GAP);
    let width = side.max(2 * MARGIN + LETTER_WIDTH * title.chars().count() as i32) as u32;
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (width, side as u32)).into_drawing_area();
        root.fill(&WHITE).map_err(PlotError::of)?;
        let style = TextStyle::from(("sans-serif", 15).into_font()).pos(Pos::new(HPos::Left, VPos::Center));
        root.draw(&Text::new(title.to_owned(), (MARGIN, MARGIN / 2), style)).map_err(PlotError::of)?;
        let start = |index: usize| MARGIN + index as i32 * (PANEL + GAP);
        for (row, vertical) in factors.iter().enumerate() {
            for (column, horizontal) in factors.iter().enumerate() {
                let corner = (start(column), start(row));
                let panel = root.clone().shrink(corner, (PANEL, PANEL));
                let frame = Rectangle::new([(0, 0), (PANEL, PANEL)], RGBColor(150, 150, 150));
                panel.draw(&frame).map_err(PlotError::of)?;
                if row == column { histogram(&panel, vertical)? } else { cloud(&panel, horizontal, vertical)? }
            }
            let middle = start(row) + PANEL / 2;
            label(&root, vertical, LabelPlace { at: (middle, side - MARGIN + 4), turned: false })?;
            label(&root, vertical, LabelPlace { at: (4, middle), turned: true })?;
        }
        root.present().map_err(PlotError::of)?;
    }
    Ok(svg)
}

/// Position of a label: the middle of its upper edge, and whether it reads upwards.
struct LabelPlace {
    at: (i32, i32),
    turned: bool,
}

/// Name and below it the domain.
fn label(root: &DrawingArea<SVGBackend<'_>, Shift>, factor: &MatrixFactor, place: LabelPlace) -> Result<(), PlotError> {
    let long = factor.domain.chars().count() > LABEL;
    let shown: String = factor.domain.chars().take(if long { LABEL - 3 } else { LABEL }).collect();
    let domain = format!("{shown}{}", if long { "..." } else { "" });
    let turn = if place.turned { FontTransform::Rotate270 } else { FontTransform::None };
    for (text, letters, below) in [(factor.name.clone(), 13, 0), (domain, 11, 16)] {
        let font = ("sans-serif", letters).into_font().transform(turn.clone());
        let style = TextStyle::from(font).pos(Pos::new(HPos::Center, VPos::Top));
        let (x, y) = place.at;
        let at = if place.turned { (x + below, y) } else { (x, y + below) };
        root.draw(&Text::new(text, at, style)).map_err(PlotError::of)?;
    }
    Ok(())
}

fn cloud(
    panel: &DrawingArea<SVGBackend<'_>, Shift>,
    horizontal: &MatrixFactor,
    vertical: &MatrixFactor,
) -> Result<(), PlotError> {
    let (red, green, blue) = COLORS[0];
    let place = |share: f64| (INSET + share * (f64::from(PANEL) - 2.0 * INSET)).round() as i32;
    for (x, y) in horizontal.shares.iter().zip(&vertical.shares) {
        let disc = Circle::new((place(*x), place(1.0 - y)), 2, RGBColor(red, green, blue).filled());
        panel.draw(&disc).map_err(PlotError::of)?;
    }
    Ok(())
}

fn histogram(panel: &DrawingArea<SVGBackend<'_>, Shift>, factor: &MatrixFactor) -> Result<(), PlotError> {
    let mut counts = [0_usize; BARS];
    for share in &factor.shares {
        if let Some(count) = counts.get_mut(((share * BARS as f64) as usize).min(BARS - 1)) {
            *count += 1;
        }
    }
    let most = counts.iter().max().copied().unwrap_or(1).max(1) as f64;
    let width = PANEL / BARS as i32;
    for (index, count) in counts.iter().enumerate() {
        let height = (0.9 * f64::from(PANEL) * *count as f64 / most).round() as i32;
        let left = index as i32 * width;
        let bar = Rectangle::new([(left, PANEL - height), (left + width, PANEL)], RGBColor(184, 207, 232).filled());
        panel.draw(&bar).map_err(PlotError::of)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{MatrixFactor, scatter_matrix};

    #[test]
    fn every_row_is_a_disc_in_every_panel_beside_the_diagonal() {
        let factor = |name: &str| MatrixFactor {
            name: name.to_owned(),
            domain: "a domain of more than twenty-four letters".into(),
            shares: vec![0.0, 0.5, 1.0],
        };
        let svg = scatter_matrix("a <study>", &[factor("p < q"), factor("s")]).expect("drawn");
        assert_eq!(svg.matches("<circle").count(), 2 * 3, "{svg}");
        assert!(
            svg.contains("a &lt;study&gt;") && svg.contains("p &lt; q") && svg.contains("a domain of more than..."),
            "{svg}"
        );
    }
}

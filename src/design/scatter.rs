//! A scatter matrix of a design as SVG.

use std::fmt::Write;

/// Side of one panel in pixels.
const PANEL: f64 = 120.0;
/// Space between panels and for the names at the edges.
const GAP: f64 = 12.0;
const MARGIN: f64 = 40.0;
/// Most characters of a domain: as many as a panel is wide.
const LABEL: usize = 26;
/// Bars of a histogram.
const BARS: usize = 12;

/// One factor of the picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Name.
    pub name: String,
    /// What it varies over, in words; cut to the width of a panel.
    pub domain: String,
    /// Where each row lies in the range, in [0, 1].
    pub shares: Vec<f64>,
}

/// Every factor against every other one, histograms on the diagonal. All axes must have as many rows.
pub fn scatter_matrix(title: &str, axes: &[Axis]) -> String {
    let size = 2.0 * MARGIN + axes.len() as f64 * (PANEL + GAP);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {size} {size}\" width=\"{size}\" height=\"{size}\" \
         font-family=\"sans-serif\" font-size=\"11\">\n<title>{}</title>\n<rect width=\"{size}\" height=\"{size}\" \
         fill=\"white\"/>\n",
        escape(title)
    );
    let start = |index: usize| MARGIN + index as f64 * (PANEL + GAP);
    for (row, vertical) in axes.iter().enumerate() {
        for (column, horizontal) in axes.iter().enumerate() {
            let (x, y) = (start(column), start(row));
            // Writing to a string cannot fail.
            let _ = writeln!(
                svg,
                "<g transform=\"translate({x} {y})\"><rect width=\"{PANEL}\" height=\"{PANEL}\" fill=\"none\" \
                 stroke=\"#999\"/>{}</g>",
                if row == column { histogram(vertical) } else { cloud(horizontal, vertical) }
            );
        }
        let middle = start(row) + 0.5 * PANEL;
        let _ = writeln!(svg, "<g transform=\"translate({middle:.1} {:.1})\">{}</g>", size - MARGIN, label(vertical));
        let turned = format!("translate({:.1} {middle:.1}) rotate(-90)", 0.2 * MARGIN);
        let _ = writeln!(svg, "<g transform=\"{turned}\">{}</g>", label(vertical));
    }
    svg.push_str("</svg>\n");
    svg
}

/// Name and below it the domain, around the origin.
fn label(axis: &Axis) -> String {
    let long = axis.domain.chars().count() > LABEL;
    let domain: String = axis.domain.chars().take(if long { LABEL - 3 } else { LABEL }).collect();
    let (name, domain) = (escape(&axis.name), escape(&domain));
    let dots = if long { "..." } else { "" };
    format!(
        "<text y=\"6\" text-anchor=\"middle\">{name}</text><text y=\"19\" text-anchor=\"middle\" font-size=\"9\" \
         fill=\"#666\">{domain}{dots}</text>"
    )
}

fn cloud(horizontal: &Axis, vertical: &Axis) -> String {
    let mut path = String::new();
    // Points at the very ends of a range stay inside their panel.
    let inset = |share: f64| 4.0 + share * (PANEL - 8.0);
    for (x, y) in horizontal.shares.iter().zip(&vertical.shares) {
        let _ = write!(path, "M{:.1} {:.1}h0", inset(*x), inset(1.0 - y));
    }
    format!("<path d=\"{path}\" stroke=\"#1f5fa8\" stroke-width=\"3\" stroke-linecap=\"round\" fill=\"none\"/>")
}

fn histogram(axis: &Axis) -> String {
    let mut counts = [0_usize; BARS];
    for share in &axis.shares {
        if let Some(count) = counts.get_mut(((share * BARS as f64) as usize).min(BARS - 1)) {
            *count += 1;
        }
    }
    let most = counts.iter().max().copied().unwrap_or(1).max(1) as f64;
    let width = PANEL / BARS as f64;
    let mut bars = String::new();
    for (index, count) in counts.iter().enumerate() {
        let height = 0.9 * PANEL * *count as f64 / most;
        let _ = write!(
            bars,
            "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"#b8cfe8\"/>",
            index as f64 * width,
            PANEL - height
        );
    }
    bars
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

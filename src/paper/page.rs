//! The comparison as one self-contained HTML page.

use std::fmt::Write as _;

use super::compared::{Agreement, Evidence, FigureGroup, PaperComparison, PaperFigure, four_digits};
use super::mobility::Mobility;
use super::quoted::{NATURAL_FREQUENCIES, NOT_CALCULATED_HZ};
use super::structure_groups::MOBILITY;
use crate::plot::{Axis, COLORS, Chart, Line, Marker, PlotError, Series, document, escape, panels};

/// Size of a picture in pixels.
const PLOT: (u32, u32) = (900, 420);

/// Builds the page: summary, then each group with its figures, remarks and runs, and the mobilities if the paper has them.
///
/// # Errors
/// The plotting library's words.
pub fn paper_page(comparison: &PaperComparison) -> Result<String, PlotError> {
    let counted = |Agreement { agree, of }: Agreement, of_what: &str| {
        format!("<div><div class=\"figure\">{agree} of {of}</div><span>{of_what}</span></div>")
    };
    let mut page = format!(
        "<p>{}. Its rig: a hammer at the middle of the rail (R5) of the built-in station, 5 bar, 85 mm above the casting, 1.5 s. \
         Figures that agree, by the tolerance of each table; * marks those that do not.</p>\n<div class=\"figures\">{}{}{}</div>\n",
        escape(comparison.citation),
        counted(comparison.calculations, "figures that the paper calculated"),
        counted(comparison.measurements, "figures that it measured"),
        counted(comparison.quoted_differences, "differences of both that it quotes"),
    );
    for group in &comparison.groups {
        section(&mut page, group);
        if group.name == MOBILITY {
            page.push_str(&mobility(&comparison.mobility)?);
        }
        group.evidence.iter().for_each(|table| evidence(&mut page, table));
    }
    Ok(document("The publication beside decore", &page))
}

/// Heading, figures and remarks of a group; writing to a string cannot fail.
fn section(page: &mut String, group: &FigureGroup) {
    let _ = writeln!(page, "<h2>{} ({})</h2>", escape(group.name), escape(group.source));
    if !group.figures.is_empty() {
        let name = |figure: &PaperFigure| format!("{} ({})", figure.name, figure.unit);
        let rows = group.figures.iter().map(|figure| (name(figure), figure.cells().to_vec()));
        let _ = writeln!(page, "<p>Agrees: within {}.</p>", group.tolerance);
        table(page, &group.tolerance.columns(), rows);
    }
    if !group.remarks.is_empty() {
        let remarks: String = group.remarks.iter().map(|remark| format!("<li>{}</li>\n", escape(remark))).collect();
        let _ = writeln!(page, "<ul>\n{remarks}</ul>");
    }
}

fn evidence(page: &mut String, Evidence { name, columns, rows }: &Evidence) {
    let _ = writeln!(page, "<p>{}:</p>", escape(name));
    let cell = |value: &Option<f64>| value.map_or("-".to_owned(), four_digits);
    table(page, columns, rows.iter().map(|row| (row.label.clone(), row.values.iter().map(cell).collect())));
}

/// A table of named rows.
fn table(page: &mut String, columns: &[&str], rows: impl Iterator<Item = (String, Vec<String>)>) {
    let headings: String = columns.iter().map(|column| format!("<th>{}</th>", escape(column))).collect();
    let _ = writeln!(page, "<div class=\"scroll\"><table><tr><th></th>{headings}</tr>");
    for (name, cells) in rows {
        let cells: String = cells.iter().map(|cell| format!("<td>{}</td>", escape(cell.trim_end()))).collect();
        let _ = writeln!(page, "<tr><td>{}</td>{cells}</tr>", escape(&name));
    }
    page.push_str("</table></div>\n");
}

/// Our mobilities, as the paper's Figure 14 has them, with the frequencies at which it measured modes.
fn mobility(mobility: &Mobility) -> Result<String, PlotError> {
    let curves = [
        ("mount, force at the mount", &mobility.mount_m_per_s_n),
        ("table, force at the table", &mobility.table_m_per_s_n),
        ("mount, force at the table", &mobility.cross_m_per_s_n),
    ];
    let least = curves.iter().flat_map(|(_, values)| values.iter()).copied().fold(f64::INFINITY, f64::min);
    let measured = NATURAL_FREQUENCIES.iter().map(|mode| mode.measured_hz).chain(NOT_CALCULATED_HZ);
    let mut series: Vec<Series> = curves
        .iter()
        .zip(COLORS)
        .map(|((name, values), color)| Series {
            name: (*name).to_owned(),
            color,
            points: mobility.frequency_hz.iter().copied().zip(values.iter().copied()).collect(),
            line: Line::Solid,
            marker: Marker::None,
        })
        .collect();
    series.push(Series {
        name: "modes measured".to_owned(),
        color: COLORS[5],
        points: measured.map(|hz| (hz, least)).collect(),
        line: Line::None,
        marker: Marker::Up,
    });
    let chart = Chart {
        title: "velocity along the strike per force; the paper's Figure 14".to_owned(),
        x: Axis::logarithmic("frequency (Hz)"),
        y: Axis::logarithmic("mobility (m/(s N))"),
        series,
    };
    Ok(format!("<div class=\"plot\">{}</div>\n", panels(&[chart], PLOT)?))
}

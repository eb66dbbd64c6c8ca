//! The end of a sweep in a dozen lines: how many rows are done, why others are not, the best rows, the largest numerical error.

use std::collections::BTreeMap;

use comfy_table::{ColumnConstraint, ContentArrangement, Row, Table, TableStyle, Width};

use decore_lab::report::{BestRow, NamedValue, Report};
use decore_model::metrics::{Percussion, Warning};
use decore_quantity::Value;

use super::check_invalid::{split_reason, without_numbers};
use super::text::{fit, plural, shell_word, six_digits};

/// Lines of the summary at most, on a terminal that is wide enough for its table.
const MOST_LINES: usize = 12;
/// Best rows that are shown at most, and at least.
const MOST_BEST: usize = 5;
const LEAST_BEST: usize = 2;
/// Lines of a heading at most.
const HEAD_LINES: usize = 3;
/// Blanks between columns.
const GAP: usize = 2;
/// Columns of the table in a file or a pipe.
const COLUMNS: usize = 80;
/// Significant digits in the table.
const DIGITS: usize = 4;

/// The summary of a sweep for a terminal with so many columns; `None` for a file or a pipe.
pub(super) fn summary(report: &Report, columns: Option<usize>) -> String {
    let mut head = head(report);
    let mut tail = Vec::new();
    if let Some(twins) = &report.numerical_twins {
        let worst = twins.outputs.iter().max_by(|a, b| a.worst.total_cmp(&b.worst));
        tail.extend(worst.map(|worst| {
            let percent = digits(100.0 * worst.worst);
            format!("Numerical error: at most {percent} % (`{}`, row {})", worst.worst_column, worst.worst_row)
        }));
    }
    tail.push(format!("All ranges and distributions: decore report {}", shell_word(&report.folder)));
    if report.best.is_empty() {
        head.push(format!("No row has a `{}` to rank it by.", report.ranking.name));
    } else {
        let end = if report.least_first { ", least first" } else { "" };
        head.push(format!("Best rows by `{}`{end}:", report.ranking.name));
    }
    let width = columns.unwrap_or(COLUMNS);
    // In a file, each fact about the rows has its line.
    let above = columns.map_or_else(|| head.join("\n") + "\n", |columns| fit(&head.join("\n"), columns));
    let below = fit(&tail.join("\n"), width);
    let left = MOST_LINES.saturating_sub(above.lines().count() + below.lines().count());
    format!("{above}{}{below}", best(report, width, left))
}

/// Study, rows by status, and what speaks against them.
fn head(report: &Report) -> Vec<String> {
    let hash: String = report.study_hash.chars().take(12).collect();
    let there: u64 = report.statuses.values().sum();
    let statuses: Vec<String> = report.statuses.iter().map(|(status, count)| format!("{count} {status}")).collect();
    let statuses = if statuses.is_empty() { String::new() } else { format!(" ({})", statuses.join(", ")) };
    let mut lines = vec![
        format!("Study `{}` (hash {hash}, seed {}, decore {})", report.study_name, report.seed, report.program_version),
        format!("Rows: {there} of {}{statuses}, {} blows", report.rows, report.blows),
    ];
    // Reasons that differ in numbers alone are of one kind.
    let mut kinds: BTreeMap<String, (u64, &str)> = BTreeMap::new();
    for (reason, count) in &report.reasons {
        kinds.entry(without_numbers(reason)).or_insert((0, split_reason(reason).0)).0 += count;
    }
    if let Some((count, reason)) = kinds.values().max_by_key(|(count, _)| *count) {
        let others = match kinds.len() - 1 {
            0 => String::new(),
            others => format!("; {}: see column `reason`", plural(others, "other reason")),
        };
        lines.push(format!("  {count} x {reason}{others}"));
    }
    let unsteady = report.percussions.iter().filter(|(kind, _)| *kind != Percussion::Periodic.name());
    let unsteady: Vec<String> = unsteady.map(|(kind, count)| format!("{count} {kind}")).collect();
    if !unsteady.is_empty() {
        lines.push(format!("  percussion not periodic: {} (decore help scatter)", unsteady.join(", ")));
    }
    let doubted =
        Warning::ALL.iter().filter_map(|warning| Some((warning.name(), report.warnings.get(warning.name())?)));
    let doubted: Vec<String> =
        doubted.map(|(name, count)| format!("{name} in {}", plural(*count as usize, "row"))).collect();
    if !doubted.is_empty() {
        lines.push(format!("  warnings: {} (decore help outputs)", doubted.join(", ")));
    }
    lines
}

/// The best rows as a table with their factors and as many outputs as there is room for, in at most `most` lines if that leaves one
/// row.
fn best(report: &Report, columns: usize, most: usize) -> String {
    // Important columns come first. Columns that do not fit are left out.
    let figures = |best: &BestRow| -> Vec<(String, String, String)> {
        let rank = NamedValue {
            name: report.ranking.name.clone(),
            value: Some(Value::Real(best.rank)),
            unit: report.ranking.unit.clone(),
        };
        let row = ("row".to_owned(), String::new(), best.row.to_string());
        let outputs = main_outputs(best);
        let named = std::iter::once(&rank).chain(&best.factors).chain(outputs);
        std::iter::once(row).chain(named.map(|one| (words(&one.name, &one.unit), unit(&one.unit), cell(one)))).collect()
    };
    let rows: Vec<Vec<(String, String, String)>> = report.best.iter().take(MOST_BEST).map(figures).collect();
    let Some(first) = rows.first() else { return String::new() };
    let head = first.iter().map(|(name, unit, _)| format!("{name} {unit}").trim_end().to_owned());
    let head: Vec<String> = head.collect();
    let width = |column: usize| {
        let cells = rows.iter().filter_map(|row| row.get(column)).map(|(.., cell)| cell.chars().count());
        head.get(column).map_or(0, |head| least_width(head)).max(cells.max().unwrap_or_default())
    };
    let widths: Vec<usize> = (0..head.len()).map(width).collect();
    let mut used = 0;
    let shown = widths.iter().enumerate().take_while(|(column, width)| {
        used += *width + GAP;
        used <= columns || *column < 2
    });
    let shown = shown.count();
    let build = |count: usize| {
        let mut table = Table::new();
        table
            .set_content_arrangement(ContentArrangement::Dynamic)
            .set_width(u16::try_from(columns).unwrap_or(u16::MAX));
        table.load_style(TableStyle::new()).set_header(Row::from(head[..shown].to_vec()));
        for row in rows.iter().take(count) {
            table.add_row(Row::from(row.iter().take(shown).map(|(.., cell)| cell.clone()).collect::<Vec<_>>()));
        }
        for (column, width) in table.column_iter_mut().zip(&widths) {
            column.set_padding((0, GAP as u16));
            let width = u16::try_from(*width + GAP).unwrap_or(u16::MAX);
            column.set_constraint(ColumnConstraint::Absolute(Width::Fixed(width)));
        }
        table.trim_fmt() + "\n"
    };
    let fitting = (LEAST_BEST..=rows.len()).rev().map(build).find(|text| text.lines().count() <= most);
    fitting.unwrap_or_else(|| build(LEAST_BEST))
}

/// Least width at which a heading has at most [`HEAD_LINES`] lines.
fn least_width(heading: &str) -> usize {
    let words: Vec<usize> = heading.split(' ').map(|word| word.chars().count()).collect();
    let lines = |width: usize| {
        let mut used = 0;
        let breaks = words.iter().filter(|word| {
            let breaks = used > 0 && used + 1 + **word > width;
            used = if breaks || used == 0 { **word } else { used + 1 + **word };
            breaks
        });
        breaks.count() + 1
    };
    let longest = words.iter().copied().max().unwrap_or_default();
    (longest..=heading.chars().count()).find(|width| lines(*width) <= HEAD_LINES).unwrap_or(longest)
}

/// Outputs of a best row beside its rank: those that limits mostly name come first.
fn main_outputs(best: &BestRow) -> impl Iterator<Item = &NamedValue> {
    let is_limit = |one: &&NamedValue| one.name.contains("velocity");
    let (limits, others): (Vec<&NamedValue>, Vec<&NamedValue>) =
        best.outputs.iter().filter(|one| matches!(one.value, Some(Value::Real(_)))).partition(is_limit);
    limits.into_iter().chain(others)
}

/// A column's name without its unit, as words, so that it can go over several lines.
fn words(name: &str, unit: &str) -> String {
    let ending = format!("_{}", unit.to_lowercase().replace(['/', ' '], "_"));
    name.strip_suffix(ending.as_str()).filter(|name| !name.is_empty()).unwrap_or(name).replace('_', " ")
}

/// A unit in brackets; empty without one.
fn unit(unit: &str) -> String {
    if ["", "1"].contains(&unit) { String::new() } else { format!("({unit})").replace(' ', "\u{a0}") }
}

fn cell(figure: &NamedValue) -> String {
    match &figure.value {
        None => "-".to_owned(),
        Some(Value::Real(number)) => digits(*number),
        Some(other) => other.to_string(),
    }
}

/// A number to four digits.
fn digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.0$e}", DIGITS - 1).parse().unwrap_or(value);
    let text = six_digits(rounded);
    let (mantissa, exponent) =
        text.split_once('e').map_or((text.as_str(), String::new()), |(m, e)| (m, format!("e{e}")));
    match mantissa.contains('.') {
        true => format!("{}{exponent}", mantissa.trim_end_matches('0').trim_end_matches('.')),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_words_and_numbers_four_digits() {
        assert_eq!(words("max_casting_point_velocity_m_s", "m/s"), "max casting point velocity");
        assert_eq!(words("pressure", "bar"), "pressure");
        assert_eq!(words("total_air_used_nl", "NL"), "total air used");
        assert_eq!(["row", "strike energy (J)", "max casting point velocity (m/s)"].map(least_width), [3, 6, 14]);
        assert_eq!([0.12, 66.234_5, 1e8, 0.0].map(digits), ["0.12", "66.23", "1e8", "0"]);
    }
}

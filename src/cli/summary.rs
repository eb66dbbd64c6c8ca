//! The end of a sweep in a dozen lines: how many rows are done, why others are not, the best rows, the largest numerical error.

use std::collections::BTreeMap;

use comfy_table::{ColumnConstraint, ContentArrangement, Row, Table, TableStyle, Width};

use decore_lab::report::{BestRow, NamedValue, Report};
use decore_model::metrics::{Percussion, Warning};
use decore_quantity::Value;

use super::check_invalid::{split_reason, without_numbers};
use super::text::{fit, plural, shell_word, six_digits};

/// Lines of the summary at most.
const MOST_LINES: usize = 12;
/// Best rows that are shown at most.
const MOST_BEST: usize = 5;
/// Rank of the lines that are left out first.
const LAST_RANK: usize = 4;
/// Lines of a heading at most.
const HEAD_LINES: usize = 3;
/// Blanks between columns.
const GAP: usize = 2;
/// Columns of the table in a file or a pipe.
const COLUMNS: usize = 80;
/// Significant digits in the table.
const DIGITS: usize = 4;

/// A line of the summary.
struct Line {
    /// Order in which lines are kept where there is not enough room; 0: always.
    rank: usize,
    text: String,
}

/// The summary of a sweep for a terminal with so many columns, in at most [`MOST_LINES`] lines; `None`: for a file or a pipe, with a line
/// for each fact. `answer`: the answer to the study's goal, empty if there is none.
pub(super) fn summary(report: &Report, answer: &str, columns: Option<usize>) -> String {
    let head = head(report);
    let error = report.numerical_twins.as_ref().and_then(|twins| {
        let worst = twins.outputs.iter().max_by(|a, b| a.worst.total_cmp(&b.worst))?;
        let percent = digits(100.0 * worst.worst);
        let text = format!("Numerical error: at most {percent} % (`{}`, row {})", worst.worst_column, worst.worst_row);
        Some(Line { rank: 3, text })
    });
    let all = format!("All ranges and distributions: decore report {}", shell_word(&report.folder));
    let tail: Vec<Line> = error.into_iter().chain([Line { rank: 0, text: all }]).collect();
    let heading = match (report.best.is_empty(), report.least_first) {
        (true, _) => format!("No row has a `{}` to rank it by.", report.ranking.name),
        (false, true) => format!("Best rows by `{}`, least first:", report.ranking.name),
        (false, false) => format!("Best rows by `{}`:", report.ranking.name),
    };
    match columns {
        Some(columns) => {
            fitted([&head, &tail], &answer.replace('\n', " "), (&heading, &tables(report, columns)), columns)
        }
        None => {
            let above: String = head.iter().map(|line| format!("{}\n", line.text)).collect();
            let below: String = tail.iter().map(|line| fit(&line.text, COLUMNS)).collect();
            let left = MOST_LINES.saturating_sub(above.lines().count() + 1 + below.lines().count());
            let tables = tables(report, COLUMNS);
            let table = tables.iter().rev().find(|table| table.lines().count() <= left);
            let table = table.or_else(|| tables.get(1)).or(tables.first()).map_or("", String::as_str);
            let answer = if answer.is_empty() { String::new() } else { format!("\n{answer}\n") };
            format!("{above}{heading}\n{table}{below}{answer}")
        }
    }
}

/// All lines that are always kept, then as many others and rows of the table as [`MOST_LINES`] leave room for. `tables`: with one row, two
/// rows and so on.
fn fitted([head, tail]: [&[Line]; 2], answer: &str, (heading, tables): (&str, &[String]), columns: usize) -> String {
    let lines = |text: &str| fit(text, columns).lines().count();
    let all = || head.iter().chain(tail);
    let always: usize = all().filter(|line| line.rank == 0).map(|line| lines(&line.text)).sum();
    let mut left = MOST_LINES.saturating_sub(always + lines(answer));
    let mut keep = |count: usize| {
        let fits = count <= left;
        left -= if fits { count } else { 0 };
        fits
    };
    let mut kept = vec![0];
    let rank = |rank: usize| all().find(|line| line.rank == rank).map(|line| lines(&line.text));
    kept.extend(rank(1).filter(|count| keep(*count)).map(|_| 1));
    let height = |table: &String| lines(heading) + table.lines().count();
    let least = tables.first().map(height).filter(|count| keep(*count));
    kept.extend((2..=LAST_RANK).filter(|one| rank(*one).is_some_and(&mut keep)));
    let room = least.map_or(0, |least| least + left);
    let table = tables.iter().rev().find(|table| height(table) <= room).filter(|_| least.is_some());
    let table = table.map_or(String::new(), |table| fit(heading, columns) + table);
    let text = |lines: &[Line]| -> String {
        lines.iter().filter(|line| kept.contains(&line.rank)).map(|line| fit(&line.text, columns)).collect()
    };
    format!("{}{table}{}{}", text(head), text(tail), fit(answer, columns))
}

/// Study, rows by status, and doubts about them.
fn head(report: &Report) -> Vec<Line> {
    let hash: String = report.study_hash.chars().take(12).collect();
    let there: u64 = report.statuses.values().sum();
    let statuses: Vec<String> = report.statuses.iter().map(|(status, count)| format!("{count} {status}")).collect();
    let statuses = if statuses.is_empty() { String::new() } else { format!(" ({})", statuses.join(", ")) };
    let study =
        format!("Study `{}` (hash {hash}, seed {}, decore {})", report.study_name, report.seed, report.program_version);
    let rows = format!("Rows: {there} of {}{statuses}, {} blows", report.rows, report.blows);
    let mut lines = vec![Line { rank: 0, text: study }, Line { rank: 0, text: rows }];
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
        lines.push(Line { rank: 1, text: format!("  {count} x {reason}{others}") });
    }
    let unsteady = report.percussions.iter().filter(|(kind, _)| *kind != Percussion::Periodic.name());
    let unsteady: Vec<String> = unsteady.map(|(kind, count)| format!("{count} {kind}")).collect();
    if !unsteady.is_empty() {
        let text = format!("  percussion not periodic: {} (decore help scatter)", unsteady.join(", "));
        lines.push(Line { rank: LAST_RANK, text });
    }
    let doubted =
        Warning::ALL.iter().filter_map(|warning| Some((warning.name(), report.warnings.get(warning.name())?)));
    let doubted: Vec<String> =
        doubted.map(|(name, count)| format!("{name} in {}", plural(*count as usize, "row"))).collect();
    if !doubted.is_empty() {
        lines.push(Line { rank: 2, text: format!("  warnings: {} (decore help outputs)", doubted.join(", ")) });
    }
    lines
}

/// The best rows as tables with one row, two rows and so on, with their factors and as many outputs as there is room for.
fn tables(report: &Report, columns: usize) -> Vec<String> {
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
    let Some(first) = rows.first() else { return Vec::new() };
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
    (1..=rows.len()).map(build).collect()
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

/// Outputs of a best row besides its rank; typical quantities of limits come first.
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
    fn a_summary_has_at_most_twelve_lines() {
        let line = |rank: usize, words: usize| Line { rank, text: vec!["sentence"; words].join(" ") };
        let head = [line(0, 9), line(0, 8), line(1, 12), line(LAST_RANK, 9), line(2, 9)];
        let tail = [line(3, 8), line(0, 6)];
        let tables: Vec<String> = (1..=5).map(|rows| "head\n".repeat(3) + &"row\n".repeat(rows)).collect();
        for answer in [String::new(), ["answer"; 20].join(" ")] {
            for columns in [40, 60, 80, 120] {
                let text = fitted([&head, &tail], &answer, ("Best rows:", &tables), columns);
                let count = text.lines().count();
                assert!(count <= MOST_LINES, "{count} lines at {columns}:\n{text}");
                assert!(text.lines().all(|line| line.chars().count() <= columns), "{text}");
                assert_eq!(text.matches("answer").count(), answer.matches("answer").count(), "{text}");
                let room = columns >= 80 || (columns == 60 && answer.is_empty());
                assert_eq!(text.contains("row\n"), room, "{columns}:\n{text}");
            }
        }
        let whole = fitted([&head, &tail], "", ("Best rows:", &tables), 120);
        assert_eq!((whole.matches("row\n").count(), whole.matches("sentence").count()), (1, 61), "{whole}");
        // Without notes, five rows.
        let bare = fitted([&head[..2], &tail[1..]], "", ("Best rows:", &tables), 80);
        assert_eq!(bare.matches("row\n").count(), 5, "{bare}");
    }

    #[test]
    fn names_become_words_and_numbers_four_digits() {
        assert_eq!(words("max_casting_point_velocity_m_s", "m/s"), "max casting point velocity");
        assert_eq!(words("pressure", "bar"), "pressure");
        assert_eq!(words("total_air_used_nl", "NL"), "total air used");
        assert_eq!(["row", "strike energy (J)", "max casting point velocity (m/s)"].map(least_width), [3, 6, 14]);
        assert_eq!([0.12, 66.234_5, 1e8, 0.0].map(digits), ["0.12", "66.23", "1e8", "0"]);
    }
}

//! The text of an analysis.

use std::fmt;

use super::result::{Index, IndexName, LeftOut, Method, OutputSensitivity, Sensitivity};

/// Rows that are named per reason.
const NAMED_ROWS: usize = 8;
/// Reasons that are told per output.
const REASONS: usize = 4;
/// Pairs of factors that are told per output, the largest first.
const PAIRS: usize = 10;

impl fmt::Display for Sensitivity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let hash: String = self.study_hash.chars().take(12).collect();
        writeln!(f, "Study `{}` (hash {hash}, decore {})", self.study, self.program_version)?;
        writeln!(f, "{}; {} of {} rows are there", self.method_words(), self.rows_there, self.rows)?;
        let intervals = &self.intervals;
        match intervals.replicates {
            0 => writeln!(f, "No intervals (--bootstrap 0)")?,
            replicates => writeln!(
                f,
                "In brackets: {} % intervals of {replicates} bootstrap replicates, seed {}",
                100.0 * intervals.level,
                intervals.seed
            )?,
        }
        self.notes.iter().try_for_each(|note| writeln!(f, "{note}"))?;
        self.outputs.iter().try_for_each(|output| write!(f, "\n{output}"))
    }
}

impl Sensitivity {
    fn method_words(&self) -> String {
        let factors = self.factors.len();
        match self.method {
            Method::Sobol { estimator, block } => {
                let order = if block > factors + 2 { ", with second order" } else { "" };
                format!("Sobol' indices (estimator {}) of {factors} factors{order}", estimator.name())
            }
            Method::Morris { levels, .. } => {
                format!("Elementary effects (Morris, {levels} levels) of {factors} factors")
            }
        }
    }
}

impl fmt::Display for OutputSensitivity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let unit = if self.unit == "1" { String::new() } else { format!(" ({})", self.unit) };
        writeln!(f, "{}{unit}: {}", self.output, self.description)?;
        self.write_used(f)?;
        if let Some(refused) = &self.refused {
            return writeln!(f, "  {refused}");
        }
        self.write_factors(f)?;
        self.write_pairs(f)
    }
}

impl OutputSensitivity {
    fn write_used(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let used = &self.used;
        let unit = used.unit.plural();
        if used.whole == used.of {
            return writeln!(f, "  from all {} {unit}", used.of);
        }
        writeln!(
            f,
            "  FROM {} OF {} {unit}: {} are incomplete and left out",
            used.whole,
            used.of,
            used.of - used.whole
        )?;
        for LeftOut { reason, count, rows } in used.left_out.iter().take(REASONS) {
            let named: Vec<String> = rows.iter().take(NAMED_ROWS).map(ToString::to_string).collect();
            let more = if *count > named.len() as u64 && !named.is_empty() { ", ..." } else { "" };
            let place = if named.is_empty() { String::new() } else { format!(" ({}{more})", named.join(", ")) };
            let noun = if *count == 1 { "row" } else { "rows" };
            writeln!(f, "    {count} {noun}{place}: {reason}")?;
        }
        match used.left_out.len().checked_sub(REASONS) {
            Some(more) if more > 0 => writeln!(f, "    and {more} other reasons (--json has them)"),
            _ => Ok(()),
        }
    }

    /// A line per factor, the most important first.
    fn write_factors(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let single = || self.indices.iter().filter(|index| index.factors.len() == 1);
        let mut names: Vec<IndexName> = Vec::new();
        let mut factors: Vec<&str> = Vec::new();
        for index in single() {
            if !names.contains(&index.index) {
                names.push(index.index);
            }
            if let Some(factor) = index.factors.first().filter(|name| !factors.contains(&name.as_str())) {
                factors.push(factor);
            }
        }
        let find = |factor: &str, name: IndexName| {
            single().find(|index| index.index == name && index.factors.first().is_some_and(|of| of == factor))
        };
        let rank = if names.contains(&IndexName::St) { IndexName::St } else { IndexName::MuStar };
        let size = |factor: &str| find(factor, rank).and_then(|index| index.value).unwrap_or(f64::NEG_INFINITY);
        factors.sort_by(|a, b| size(b).total_cmp(&size(a)));
        let width = factors.iter().map(|name| name.chars().count()).max().unwrap_or(0).max("factor".len());
        let cells = |factor: &str| names.iter().map(|name| find(factor, *name).map_or(String::new(), words)).collect();
        let lines: Vec<Vec<String>> = factors.iter().map(|factor| cells(factor)).collect();
        let widths: Vec<usize> = names
            .iter()
            .enumerate()
            .map(|(column, name)| {
                let cells = lines.iter().map(|line| line[column].len());
                cells.max().unwrap_or(0).max(name.symbol().len())
            })
            .collect();
        let heads: Vec<String> =
            names.iter().zip(&widths).map(|(name, width)| format!("{:<width$}", name.symbol())).collect();
        writeln!(f, "  {:<width$}  {}", "factor", heads.join("  ").trim_end())?;
        for (factor, line) in factors.iter().zip(&lines) {
            let cells: Vec<String> = line.iter().zip(&widths).map(|(cell, width)| format!("{cell:<width$}")).collect();
            writeln!(f, "  {factor:<width$}  {}", cells.join("  ").trim_end())?;
        }
        Ok(())
    }

    fn write_pairs(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut pairs: Vec<&Index> = self.indices.iter().filter(|index| index.factors.len() == 2).collect();
        if pairs.is_empty() {
            return Ok(());
        }
        let size = |index: &Index| index.value.map_or(f64::NEG_INFINITY, f64::abs);
        pairs.sort_by(|a, b| size(b).total_cmp(&size(a)));
        let title = |index: &Index| index.factors.join(" and ");
        let shown = pairs.iter().take(PAIRS);
        let width = shown.clone().map(|index| title(index).chars().count()).max().unwrap_or(0).max("pair".len());
        writeln!(f, "  {:<width$}  {}", "pair", IndexName::S2.symbol())?;
        shown.map(|index| writeln!(f, "  {:<width$}  {}", title(index), words(index))).collect::<fmt::Result>()?;
        match pairs.len().checked_sub(PAIRS) {
            Some(more) if more > 0 => writeln!(f, "  and {more} smaller ones (--json and --parquet have them)"),
            _ => Ok(()),
        }
    }
}

/// Value and interval: `0.712 [0.651, 0.770]`.
fn words(index: &Index) -> String {
    let number: fn(f64) -> String = match index.index {
        IndexName::S1 | IndexName::St | IndexName::S2 => share,
        IndexName::MuStar | IndexName::Mu | IndexName::Sigma => four_digits,
    };
    let value = index.value.map_or_else(|| "none".to_owned(), number);
    match index.interval {
        None => value,
        Some([low, high]) => format!("{value} [{}, {}]", number(low), number(high)),
    }
}

/// A share to three decimals; that of nothing has no sign.
fn share(value: f64) -> String {
    let text = format!("{value:.3}");
    if text == "-0.000" { "0.000".to_owned() } else { text }
}

/// Four significant digits, with an exponent where it would be long.
fn four_digits(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        return "0".to_owned();
    }
    if !(1e-3..1e6).contains(&size) {
        return format!("{value:.3e}");
    }
    let decimals = (3 - size.log10().floor() as i32).max(0) as usize;
    format!("{value:.decimals$}")
}

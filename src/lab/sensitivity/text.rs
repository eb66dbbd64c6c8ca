//! The text of an analysis.

use std::fmt;

use super::result::{Index, IndexName, LeftOut, Method, OutputSensitivity, Sensitivity};

/// Rows that are named per reason.
const NAMED_ROWS: usize = 8;
/// Number of printed reasons per output.
const REASONS: usize = 4;
/// Indices by which factors are put in order, the first that there is.
const RANKINGS: [IndexName; 4] = [IndexName::St, IndexName::MuStar, IndexName::Shapley, IndexName::CorrelationRatio];
/// Indices that stand side by side.
const TABLES: [&[IndexName]; 4] = [
    &[IndexName::S1, IndexName::St],
    &[IndexName::MuStar, IndexName::Mu, IndexName::Sigma],
    &[IndexName::Shapley, IndexName::Rank, IndexName::CorrelationRatio],
    &[IndexName::Pawn, IndexName::PawnMaximum, IndexName::HsicR2, IndexName::HsicPValue],
];
/// Number of printed pairs of factors per output, the largest first.
const PAIRS: usize = 10;

impl fmt::Display for Sensitivity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let hash: String = self.study_hash.chars().take(12).collect();
        writeln!(f, "Study `{}` (hash {hash}, decore {})", self.study, self.program_version)?;
        writeln!(f, "{}; {} of {} rows are there", self.method_words(), self.rows_there, self.rows)?;
        let intervals = &self.intervals;
        match intervals.replicates {
            0 => writeln!(f, "No intervals (--bootstrap 0)")?,
            replicates => {
                let from = if self.method == Method::Given { "halves of the rows" } else { "bootstrap replicates" };
                let (percent, seed) = (100.0 * intervals.level, intervals.seed);
                writeln!(f, "In brackets: {percent} % intervals from {replicates} {from}, seed {seed}")?;
            }
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
            Method::Given => format!("Indices of any rows, {factors} factors"),
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
        self.notes.iter().try_for_each(|note| writeln!(f, "  {note}"))?;
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

    /// Tables with a line per factor, the most important first.
    fn write_factors(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let of_factors: Vec<&Index> = self.indices.iter().filter(|index| index.factors.len() == 1).collect();
        let mut factors: Vec<&str> = Vec::new();
        for factor in of_factors.iter().filter_map(|index| index.factors.first()) {
            if !factors.contains(&factor.as_str()) {
                factors.push(factor);
            }
        }
        let find = |factor: &str, name: IndexName| {
            let own = |index: &&&Index| index.index == name && index.factors.first().is_some_and(|of| of == factor);
            of_factors.iter().find(own).copied()
        };
        let ranking = RANKINGS.into_iter().find(|name| of_factors.iter().any(|index| index.index == *name));
        let size = |factor: &str| ranking.and_then(|name| find(factor, name)?.value).unwrap_or(f64::NEG_INFINITY);
        factors.sort_by(|a, b| size(b).total_cmp(&size(a)));
        for table in TABLES {
            let names = table.iter().filter(|name| of_factors.iter().any(|index| index.index == **name));
            let columns: Vec<Vec<String>> = names
                .map(|name| {
                    let cells = factors.iter().map(|factor| find(factor, *name).map_or(String::new(), words));
                    [name.symbol().to_owned()].into_iter().chain(cells).collect()
                })
                .collect();
            if !columns.is_empty() {
                let first = ["factor"].into_iter().chain(factors.iter().copied()).map(str::to_owned).collect();
                write_table(f, &[vec![first], columns].concat())?;
            }
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
        let shown = || pairs.iter().take(PAIRS);
        let titles = shown().map(|index| index.factors.join(" and "));
        let column = |head: &str, cells: Vec<String>| [vec![head.to_owned()], cells].concat();
        let titles = column("pair", titles.collect());
        write_table(f, &[titles, column(IndexName::S2.symbol(), shown().map(|index| words(index)).collect())])?;
        match pairs.len().checked_sub(PAIRS) {
            Some(more) if more > 0 => writeln!(f, "  and {more} smaller ones (--json and --parquet have them)"),
            _ => Ok(()),
        }
    }
}

/// Columns side by side, each as wide as its widest cell.
fn write_table(f: &mut fmt::Formatter<'_>, columns: &[Vec<String>]) -> fmt::Result {
    let wide = |column: &Vec<String>| column.iter().map(|cell| cell.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = columns.iter().map(wide).collect();
    for line in 0..columns.first().map_or(0, Vec::len) {
        let cells = columns.iter().zip(&widths).map(|(column, width)| format!("{:<width$}", column[line]));
        writeln!(f, "  {}", cells.collect::<Vec<_>>().join("  ").trim_end())?;
    }
    Ok(())
}

/// Value and interval: `0.712 [0.651, 0.770]`.
fn words(index: &Index) -> String {
    let number: fn(f64) -> String = match index.index {
        IndexName::MuStar | IndexName::Mu | IndexName::Sigma => four_digits,
        IndexName::HsicPValue => probability,
        _ => share,
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

/// A probability: small ones by their power of ten.
fn probability(value: f64) -> String {
    if value < 1e-3 { format!("{value:.0e}") } else { format!("{value:.3}") }
}

/// Four significant digits, with an exponent where it would be long.
pub fn four_digits(value: f64) -> String {
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

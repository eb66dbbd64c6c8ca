//! The report's text.

use std::cmp::Reverse;
use std::fmt;

use super::numbers::significant;
use super::precision::{Precision, WorstPrecision};
use super::summary::{BestRow, NamedValue, Range, Report, WorstResidual};
use decore_model::metrics::{Aggregates, Percussion, Warning};
use decore_quantity::Value;

/// Number of different reasons that are shown.
const REASONS: usize = 5;
/// Columns of the figures of a range, with the gap before them and the blank before their unit.
const RANGE_FIGURES: usize = 35;

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let hash: String = self.study_hash.chars().take(12).collect();
        writeln!(f, "Study `{}` (hash {hash}, seed {}, decore {})", self.study_name, self.seed, self.program_version)?;
        self.write_rows(f)?;
        self.write_best(f)?;
        // A width requested (`{:60}`) is that of the terminal.
        self.write_ranges(f, f.width().unwrap_or(usize::MAX))?;
        self.write_precision(f)?;
        self.write_residual(f)?;
        self.numerical_twins.iter().try_for_each(|twins| write!(f, "\n{twins}"))?;
        writeln!(f, "\nTables")?;
        for table in &self.tables {
            let glob = self.folder.join(table).join("*.parquet");
            writeln!(f, "  {table:<8} {}", glob.display())?;
        }
        Ok(())
    }
}

impl Report {
    fn write_rows(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let there: u64 = self.statuses.values().sum();
        let statuses: Vec<String> = self.statuses.iter().map(|(status, count)| format!("{count} {status}")).collect();
        write!(f, "Rows: {there} of {}", self.rows)?;
        if !statuses.is_empty() {
            write!(f, " ({})", statuses.join(", "))?;
        }
        writeln!(f, ", {} blows", self.blows)?;
        if self.percussions.keys().any(|percussion| percussion != Percussion::Periodic.name()) {
            let kinds: Vec<String> = self.percussions.iter().map(|(kind, count)| format!("{count} {kind}")).collect();
            writeln!(
                f,
                "  percussion (of a row's least sound hammer, column `{}`): {}",
                Aggregates::least_percussion.name,
                kinds.join(", ")
            )?;
        }
        for warning in Warning::ALL {
            if let Some(count) = self.warnings.get(warning.name()) {
                let rows = if *count == 1 { "row" } else { "rows" };
                writeln!(f, "  warning: `{}` in {count} {rows}: {}", warning.name(), warning.advice())?;
            }
        }
        let mut reasons: Vec<(&String, &u64)> = self.reasons.iter().collect();
        reasons.sort_by_key(|(reason, count)| (Reverse(**count), *reason));
        for (reason, count) in reasons.iter().take(REASONS) {
            writeln!(f, "  {count} x {reason}")?;
        }
        if reasons.len() > REASONS {
            writeln!(f, "  and {} other reasons: see column `reason`", reasons.len() - REASONS)?;
        }
        Ok(())
    }

    fn write_best(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.best.is_empty() {
            return writeln!(f, "\nNo row has a `{}` to rank it by.", self.ranking.name);
        }
        let end = if self.least_first { ", least first" } else { "" };
        writeln!(f, "\nBest rows by `{}`{end}: {}", self.ranking.name, self.ranking.description)?;
        for (index, best) in self.best.iter().enumerate() {
            self.write_best_row(f, index + 1, best)?;
        }
        Ok(())
    }

    fn write_best_row(&self, f: &mut fmt::Formatter<'_>, place: usize, best: &BestRow) -> fmt::Result {
        let rank = with_unit(&significant(best.rank), &self.ranking.unit);
        writeln!(f, "  {place}. row {}: {rank}", best.row)?;
        for (title, figures) in [("factors", &best.factors), ("outputs", &best.outputs)] {
            if !figures.is_empty() {
                let figures: Vec<String> = figures.iter().map(figure_text).collect();
                writeln!(f, "     {title}: {}", figures.join(", "))?;
            }
        }
        Ok(())
    }

    /// A line per range; two where they would be longer than a line of the terminal.
    fn write_ranges(&self, f: &mut fmt::Formatter<'_>, columns: usize) -> fmt::Result {
        if self.ranges.is_empty() {
            return Ok(());
        }
        let width = self.ranges.iter().map(|range| range.title.chars().count()).max().unwrap_or(0);
        let units = self.ranges.iter().map(|range| range.unit.chars().count()).max().unwrap_or(0);
        let (width, gap) = if width + units + RANGE_FIGURES <= columns { (width, "  ") } else { (0, "\n  ") };
        writeln!(f, "\n{:<width$}{gap}{:>10} {:>10} {:>10}", "Ranges (rows done)", "least", "mean", "largest")?;
        for Range { title, unit, min, mean, max, .. } in &self.ranges {
            let [min, mean, max] = [*min, *mean, *max].map(significant);
            let line = format!("{title:<width$}{gap}{min:>10} {mean:>10} {max:>10} {unit}");
            writeln!(f, "{}", line.trim_end())?;
        }
        Ok(())
    }

    /// Outputs whose standard errors are above the wanted one, and which duration they need.
    fn write_precision(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let wanted = significant(100.0 * self.wanted_error);
        let noted: Vec<&Precision> = self.precision.iter().filter(|one| one.above + one.without > 0).collect();
        if self.precision.is_empty() {
            return Ok(());
        }
        if noted.is_empty() {
            return writeln!(f, "\nStandard errors: all within {wanted} % of their values");
        }
        writeln!(f, "\nStandard errors above {wanted} % (they fall with the root of `duration_s`)")?;
        for Precision { output, count, without, above, worst } in noted {
            write!(f, "  {output}: {above} of {} values", count + without)?;
            if let Some(WorstPrecision { row, relative_error, duration_s, needed_s }) = worst.filter(|_| *above > 0) {
                let [percent, duration_s, needed_s] = [100.0 * relative_error, duration_s, needed_s].map(significant);
                write!(f, ", at worst {percent} % after {duration_s} s in row {row}: needs {needed_s} s")?;
            }
            if *without > 0 {
                write!(f, "; {without} without an error: too short, or not settled")?;
            }
            writeln!(f)?;
        }
        Ok(())
    }

    fn write_residual(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(WorstResidual { row, energy_residual: residual }) = self.worst_residual else {
            return Ok(());
        };
        writeln!(f, "\nEnergy residual: at worst {} % (row {row})", significant(100.0 * residual))
    }
}

fn figure_text(figure: &NamedValue) -> String {
    let value = match &figure.value {
        None => "none".to_owned(),
        Some(Value::Real(number)) => with_unit(&significant(*number), &figure.unit),
        Some(other) => with_unit(&other.to_string(), &figure.unit),
    };
    format!("{} = {value}", figure.name)
}

fn with_unit(value: &str, unit: &str) -> String {
    match unit {
        "" | "1" => value.to_owned(),
        unit => format!("{value} {unit}"),
    }
}

//! The text of a surrogate.

use std::fmt;

use super::result::{OutputSurrogate, ProcessFigures, Surrogate};
use crate::sensitivity::four_digits;
use decore_statistics::regression::FOLDS;

/// Rows that are named per reason.
const NAMED_ROWS: usize = 8;
/// Number of printed reasons per output.
const REASONS: usize = 4;
/// Share of the scatter up to which noise agrees with it.
const AGREES: f64 = 2.0;

impl fmt::Display for Surrogate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let hash: String = self.study_hash.chars().take(12).collect();
        writeln!(f, "Study `{}` (hash {hash}, decore {})", self.study, self.program_version)?;
        writeln!(
            f,
            "Surrogates over {} factors; {} of {} rows are there",
            self.factors.len(),
            self.rows_there,
            self.rows
        )?;
        self.notes.iter().try_for_each(|note| writeln!(f, "{note}"))?;
        for output in &self.outputs {
            writeln!(f)?;
            self.write_output(output, f)?;
        }
        Ok(())
    }
}

impl Surrogate {
    fn write_output(&self, output: &OutputSurrogate, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let unit = if output.unit == "1" { String::new() } else { format!(" ({})", output.unit) };
        writeln!(f, "{}{unit}: {}", output.output, output.description)?;
        output.write_rows(f)?;
        if let Some(refused) = &output.refused {
            writeln!(f, "  {refused}")?;
        }
        let Some(process) = &output.process else { return Ok(()) };
        let kernel = if process.kernel == "matern_5_2" { "Matern 5/2" } else { "squared exponential" };
        if process.places > 0 && process.places < output.used {
            writeln!(f, "  at {} places: rows with the same factors count as one", process.places)?;
        }
        writeln!(f, "  Gaussian process    {}, kernel {kernel}", q2_words(process, output.used))?;
        if let Some(chaos) = &output.chaos {
            let (degree, terms) = (chaos.degree, chaos.terms);
            writeln!(f, "  polynomial chaos    Q2 {:.4}, degree {degree}, {terms} terms; for comparison", chaos.q2)?;
        } else if let Some(reason) = &output.chaos_refused {
            writeln!(f, "  polynomial chaos    none: {reason}")?;
        }
        let unit = if output.unit == "1" { String::new() } else { format!(" {}", output.unit) };
        writeln!(
            f,
            "  error of a new row  {}{unit} (root mean square of rows left out)",
            four_digits(process.rms_error)
        )?;
        write!(f, "  noise               {}{unit} (standard deviation, fitted)", four_digits(process.noise_std_dev))?;
        match output.twin_scatter {
            None => writeln!(f)?,
            Some(scatter) => {
                let what = match process.noise_std_dev > AGREES * scatter.max(f64::MIN_POSITIVE) {
                    true => "more than runs scatter: more rows help",
                    false => "no surrogate is better than its runs",
                };
                writeln!(f, "; twins scatter by {}{unit} (median): {what}", four_digits(scatter))?;
            }
        }
        let lengths = self.factors.iter().zip(&process.weights);
        let mut lengths: Vec<(&str, f64)> = lengths.map(|(factor, weight)| (factor.name.as_str(), *weight)).collect();
        lengths.sort_by(|a, b| b.1.total_cmp(&a.1));
        let lengths = lengths.iter().map(|(name, weight)| format!("{name} {}", two_digits(1.0 / weight.sqrt())));
        writeln!(f, "  lengths             {} (shares of the range)", lengths.collect::<Vec<_>>().join(", "))?;
        if let Some(success) = &output.success {
            let how = if success.process.is_some() {
                "predicted by place"
            } else {
                "too few rows differ for a model by \
                place"
            };
            writeln!(f, "  success             {:.1} % of the rows have it; {how}", 100.0 * success.share)?;
        }
        Ok(())
    }
}

/// Q2 in words, of a process with this number of rows.
fn q2_words(process: &ProcessFigures, rows: u64) -> String {
    let (q2, groups) = (process.q2, process.groups);
    let places = if process.places == 0 { rows } else { process.places };
    let what = match groups == places || groups == 0 {
        true if places == rows => "rows".to_owned(),
        true => "places".to_owned(),
        false => format!("{groups} groups of rows nearly at one place"),
    };
    match process.q2_folds {
        None => format!("Q2 {q2:.4} ({what} left out one at a time)"),
        Some(folds) => {
            let part = if groups < 2 * FOLDS as u64 { "one at a time" } else { "a tenth" };
            format!("Q2 {q2:.4} ({what} left out one at a time), {folds:.4} ({part}, all fitted anew)")
        }
    }
}

impl OutputSurrogate {
    fn write_rows(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.left_out.is_empty() {
            return writeln!(f, "  from all {} rows", self.used);
        }
        let out: u64 = self.left_out.iter().map(|left_out| left_out.count).sum();
        writeln!(f, "  FROM {} OF {} rows:", self.used, self.used + out)?;
        for left_out in self.left_out.iter().take(REASONS) {
            let named: Vec<String> = left_out.rows.iter().take(NAMED_ROWS).map(ToString::to_string).collect();
            let more = if left_out.count > named.len() as u64 && !named.is_empty() { ", ..." } else { "" };
            let place = if named.is_empty() { String::new() } else { format!(" ({}{more})", named.join(", ")) };
            let noun = if left_out.count == 1 { "row" } else { "rows" };
            writeln!(f, "    {} {noun}{place}: {}", left_out.count, left_out.reason)?;
        }
        match self.left_out.len().checked_sub(REASONS) {
            Some(more) if more > 0 => writeln!(f, "    and {more} other reasons (--json has them)"),
            _ => Ok(()),
        }
    }
}

/// Two significant digits; lengths beyond a thousand ranges are without end.
fn two_digits(value: f64) -> String {
    match value {
        value if value >= 1e3 => "inf".to_owned(),
        value if value >= 10.0 => format!("{value:.0}"),
        value if value >= 1.0 => format!("{value:.1}"),
        value => format!("{value:.2}"),
    }
}

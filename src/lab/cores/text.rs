//! The result in words.

use std::fmt::{Display, Formatter, Result};

use super::result::CoreTests;
use decore_statistics::lifetime::{Between, LifetimeLaw};

impl Display for CoreTests {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let percent = 100.0 * self.level;
        let tests = self.tests.len();
        writeln!(f, "{tests} tests: {} cores out, {} still in at the end", self.out, self.still_in)?;
        let name = match self.law {
            LifetimeLaw::LogNormal => "log-normal",
            LifetimeLaw::Weibull => "Weibull",
        };
        writeln!(f, "\nDose at which a core is out ({name}, {percent} % intervals)")?;
        for one in &self.doses {
            writeln!(f, "  {:3.0} % of the cores  {}", 100.0 * one.share, between(one.dose))?;
        }
        writeln!(f, "  the next core      {}", between(self.next_core))?;
        if let Some(median) = self.doses.iter().find(|one| one.share == 0.5) {
            writeln!(f, "  in the study: outputs.core_wanted_dose = {}", short(median.dose.value))?;
        }
        writeln!(f, "\nTime in s until the slowest core is out")?;
        writeln!(f, "  {:>8}  {:<24}  core_out_after_s", "row", "core")?;
        for row in &self.rows {
            writeln!(f, "  {:>8}  {:<24}  {}", row.row, row.core, between(row.core_out_after_s))?;
        }
        let more = self.rows_done - self.rows_without_time - self.rows.len();
        if more > 0 {
            writeln!(f, "  and {more} more rows (--output writes all)")?;
        }
        if self.rows_without_time > 0 {
            writeln!(f, "  {} rows have a core that never comes out: its dose does not grow", self.rows_without_time)?;
        }
        Ok(())
    }
}

fn between(value: Between) -> String {
    format!("{}  ({} to {})", short(value.value), short(value.low), short(value.high))
}

/// Four significant digits.
fn short(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-3..1e6).contains(&size) {
        let digits = (3 - size.max(1e-3).log10().floor() as i32).max(0) as usize;
        format!("{value:.digits$}")
    } else {
        format!("{value:.3e}")
    }
}

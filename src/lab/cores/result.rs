//! What tests of cores give: plain data, the same in text and JSON.

use schemars::JsonSchema;
use serde::Serialize;

use decore_statistics::lifetime::{Between, LifetimeLaw};

/// Doses at which cores are out, from tests, and when the cores of other rows are out.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct CoreTests {
    /// Law of the dose at which a core is out.
    pub law: LifetimeLaw,
    /// Probability of each interval.
    pub level: f64,
    /// Standard deviation of the logarithm of the dose (log-normal), or the inverse of the shape (Weibull).
    pub scatter: f64,
    /// Doses at which shares of the cores are out, with their confidence intervals.
    pub doses: Vec<DoseAtShare>,
    /// Dose at which the next core is out: the median, and the interval in which it lies.
    pub next_core: Between,
    /// Number of tests whose core was out.
    pub out: usize,
    /// Number of tests whose core stayed in.
    pub still_in: usize,
    /// The tests with their doses, in the order of the table.
    pub tests: Vec<CoreTest>,
    /// Rows of the dataset whose slowest core is out first, in the order of that time.
    pub rows: Vec<RowTimes>,
    /// Rows that are done.
    pub rows_done: usize,
    /// Rows of which a core gets no dose that grows, so it never comes out.
    pub rows_without_time: usize,
    /// What these figures cannot be relied on for.
    pub warnings: Vec<String>,
}

/// Dose at which a share of the cores is out.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct DoseAtShare {
    /// Share of the cores.
    pub share: f64,
    /// The dose with its confidence interval.
    pub dose: Between,
}

/// One test with its dose.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct CoreTest {
    /// Row of the dataset.
    pub row: u64,
    /// Core point: CASTING.NAME.
    pub core: String,
    /// Time after which the core was out, or the length of the test, s.
    pub time_s: f64,
    /// Whether the core was out.
    pub out: bool,
    /// Dose of the core point at that time.
    pub dose: f64,
}

/// When the slowest core of a row is out.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct RowTimes {
    /// The row.
    pub row: u64,
    /// Its slowest core: CASTING.NAME.
    pub core: String,
    /// Time in s after which this core is out: the median, and the interval in which the time of the next core lies.
    pub core_out_after_s: Between,
}

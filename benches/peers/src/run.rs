//! When a run ends, and how it is measured.

use cpu_time::ThreadTime;

/// Longest CPU time of a run in s.
const LONGEST_S: f64 = 40.0;

/// Where a run is to end and how accurate it is to be.
pub struct Goal {
    /// Error of a step in units of the states' scales.
    pub tolerance: f64,
    /// End in s.
    pub end_s: f64,
    /// Begin of the run.
    begin: ThreadTime,
}

impl Goal {
    /// A run that begins now.
    pub fn new(tolerance: f64, end_s: f64) -> Self {
        Self { tolerance, end_s, begin: ThreadTime::now() }
    }

    /// Whether the run has used up its time.
    pub fn out_of_time(&self) -> bool {
        self.begin.elapsed().as_secs_f64() > LONGEST_S
    }
}

/// Why a run did not reach its end.
pub enum Stop {
    /// It took too long; the time reached in s.
    OutOfTime(f64),
    /// The solver gave up.
    Failed(String),
}

//! Time and memory of the steps of a reduction.

use std::time::Instant;

use cpu_time::ThreadTime;

/// One step of a computation.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct StepRecord {
    /// Name of the step.
    pub name: String,
    /// Wall time in s.
    pub time_s: f64,
    /// Processor time of the calling thread in s, if the system reports it; the work runs on that thread.
    pub cpu_s: Option<f64>,
    /// Largest resident memory of the process during the step in bytes, if the system reports it.
    pub peak_bytes: Option<u64>,
}

/// Collects the steps of a computation, or nothing.
#[derive(Debug, Default)]
pub struct Observer {
    records: Option<Vec<StepRecord>>,
}

impl Observer {
    /// One that looks.
    pub fn active() -> Self {
        Self { records: Some(Vec::new()) }
    }

    /// One that does not look, and costs nothing.
    pub fn none() -> Self {
        Self::default()
    }

    /// Whether it looks.
    pub fn is_active(&self) -> bool {
        self.records.is_some()
    }

    /// The steps so far.
    pub fn records(&self) -> &[StepRecord] {
        self.records.as_deref().unwrap_or_default()
    }

    /// Adds the steps of another one, with a prefix to their names, where this one looks.
    pub(super) fn add(&mut self, prefix: &str, steps: &[StepRecord]) {
        let named = steps.iter().map(|step| StepRecord { name: format!("{prefix}{}", step.name), ..step.clone() });
        self.records.iter_mut().for_each(|records| records.extend(named.clone()));
    }

    /// Does a step and records it.
    pub fn step<T>(&mut self, name: &str, work: impl FnOnce() -> T) -> T {
        let Some(records) = &mut self.records else { return work() };
        reset_peak();
        let (begin, cpu) = (Instant::now(), thread_cpu_s());
        let result = work();
        let cpu_s = thread_cpu_s().zip(cpu).map(|(end, begin)| end - begin);
        let time_s = begin.elapsed().as_secs_f64();
        records.push(StepRecord { name: name.to_owned(), time_s, cpu_s, peak_bytes: peak_memory_bytes() });
        result
    }
}

/// Starts a new peak; where the system cannot, the peak is that of the process so far.
fn reset_peak() {
    // The kernel's way to reset VmHWM; without the right to it the old peak stays, which is still an upper bound.
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

/// Largest resident memory of the process in bytes since its start, or since an active [`Observer`] began its last step, if the system
/// reports it.
pub fn peak_memory_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: u64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some(kib * 1024)
}

/// Time of this thread on a processor since its start.
fn thread_cpu_s() -> Option<f64> {
    Some(ThreadTime::try_now().ok()?.as_duration().as_secs_f64())
}

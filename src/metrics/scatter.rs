//! How far the main outputs of a run move under inputs that are the same for every purpose.

use super::outputs::{CastingMetrics, HammerMetrics, RunMetrics, RunTotals, Scatter, ScatterOf};
use crate::quantity::Quantity;

impl Scatter {
    /// The scatter of `run` and its `twins`, all of the same scene.
    pub fn new(run: &RunMetrics, twins: &[RunMetrics]) -> Self {
        let all = || std::iter::once(run).chain(twins);
        let hammer = |h: usize| over(HammerMetrics::QUANTITIES, &|m: &RunMetrics| m.hammers.get(h).cloned(), all());
        let casting = |c: usize| over(CastingMetrics::QUANTITIES, &|m: &RunMetrics| m.castings.get(c).cloned(), all());
        Self {
            twins_done: twins.len() as u64,
            hammers: (0..run.hammers.len()).map(hammer).collect(),
            castings: (0..run.castings.len()).map(casting).collect(),
            totals: over(RunTotals::QUANTITIES, &|m: &RunMetrics| Some(m.totals.clone()), all()),
        }
    }
}

/// Half the range of each main quantity over the runs.
fn over<'r, T>(
    quantities: &[Quantity<T>],
    part: &dyn Fn(&RunMetrics) -> Option<T>,
    runs: impl Iterator<Item = &'r RunMetrics>,
) -> ScatterOf {
    let parts: Vec<Option<T>> = runs.map(part).collect();
    let half_range = |quantity: &Quantity<T>| {
        let value = |part: &Option<T>| (quantity.value)(part.as_ref()?)?.number();
        let values: Option<Vec<f64>> = parts.iter().map(value).collect();
        let values = values.filter(|values| values.len() > 1)?;
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        let largest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Some(0.5 * (largest - least))
    };
    quantities.iter().filter(|quantity| quantity.main).map(|q| (q.name, half_range(q))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(energy: Option<f64>, work: f64) -> RunMetrics {
        RunMetrics {
            hammers: vec![HammerMetrics { periodic_energy_mean_j: energy, ..HammerMetrics::default() }],
            castings: vec![CastingMetrics { peak_velocity_m_s: 3.0, ..CastingMetrics::default() }],
            blows: Vec::new(),
            totals: RunTotals { delivered_work_j: work, ..RunTotals::default() },
            scatter: None,
        }
    }

    /// Half the range, the run itself included; nothing where one of the runs lacks the output, or without twins.
    #[test]
    fn analytic_half_range() {
        let scatter = Scatter::new(&run(Some(12.0), 100.0), &[run(Some(12.5), 90.0), run(Some(11.9), 94.0)]);
        assert_eq!(scatter.twins_done, 2);
        assert!((scatter.hammers[0]["periodic_energy_mean_j"].unwrap() - 0.3).abs() < 1e-12);
        assert_eq!(scatter.totals["delivered_work_j"], Some(5.0));
        assert_eq!(scatter.castings[0]["peak_velocity_m_s"], Some(0.0));
        assert_eq!(scatter.hammers[0]["hit_frequency_hz"], None);
        assert!(!scatter.hammers[0].contains_key("contact_count"));
        let lacking = Scatter::new(&run(Some(12.0), 100.0), &[run(None, 100.0)]);
        assert_eq!(lacking.hammers[0]["periodic_energy_mean_j"], None);
        assert_eq!(Scatter::new(&run(Some(12.0), 1.0), &[]).totals["delivered_work_j"], None);
    }
}

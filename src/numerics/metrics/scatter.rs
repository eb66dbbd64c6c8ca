//! How far the main outputs of a run move under inputs that are the same for every purpose.

use super::outputs::{CastingMetrics, HammerMetrics, RunMetrics, RunTotals, Scatter, ScatterOf};
use super::percussion::Percussion;
use crate::quantity::{Kind, Quantity, Value};

impl RunMetrics {
    /// Takes in the row's `twins`, runs of the same scene: the scatter of the main outputs, and the kind of each hammer's
    /// percussion, which becomes the one that the row and its twins show most often. A kind has edges (blows that repeat to 1 % are
    /// periodic), and a single run next to one falls on either side by chance.
    pub fn take_twins(&mut self, twins: &[Self]) {
        let runs: Vec<&Self> = std::iter::once(&*self).chain(twins).collect();
        let hammer = |h: usize| {
            let shown: Vec<&HammerMetrics> = runs.iter().filter_map(|run| run.hammers.get(h)).collect();
            (scatter(HammerMetrics::QUANTITIES, &shown), Usual::of(&shown))
        };
        let casting = |c: usize| {
            let shown: Vec<&CastingMetrics> = runs.iter().filter_map(|run| run.castings.get(c)).collect();
            scatter(CastingMetrics::QUANTITIES, &shown)
        };
        let (hammers, usual): (Vec<ScatterOf>, Vec<Option<Usual>>) = (0..self.hammers.len()).map(hammer).unzip();
        let castings = (0..self.castings.len()).map(casting).collect();
        let totals: Vec<&RunTotals> = runs.iter().map(|run| &run.totals).collect();
        let totals = scatter(RunTotals::QUANTITIES, &totals);
        self.scatter = Some(Scatter { twins_done: twins.len() as u64, hammers, castings, totals });
        for (hammer, usual) in self.hammers.iter_mut().zip(usual) {
            if let Some(Usual { percussion, period }) = usual {
                (hammer.percussion, hammer.percussion_period) = (percussion, period);
            }
        }
    }
}

/// The percussion that most runs of a hammer show, with that kind's usual period.
struct Usual {
    percussion: Percussion,
    period: Option<u64>,
}

impl Usual {
    fn of(shown: &[&HammerMetrics]) -> Option<Self> {
        let percussion = most_frequent(shown.iter().map(|hammer| hammer.percussion))?;
        let same = shown.iter().filter(|hammer| hammer.percussion == percussion);
        Some(Self { percussion, period: most_frequent(same.map(|hammer| hammer.percussion_period)).flatten() })
    }
}

/// Scatter of each main quantity over the same part of the runs: half the range of a number, of a text the share of the runs
/// that differ from the most frequent one. Nothing with fewer than two runs.
fn scatter<T>(quantities: &[Quantity<T>], parts: &[&T]) -> ScatterOf {
    let values = |quantity: &Quantity<T>| -> Option<Vec<Value<&str>>> {
        let values: Option<Vec<Value<&str>>> = parts.iter().map(|part| (quantity.value)(part)).collect();
        values.filter(|values| values.len() > 1)
    };
    let scatter = |quantity: &Quantity<T>| match quantity.kind {
        Kind::Text | Kind::Category => share_of_others(&values(quantity)?),
        Kind::Real | Kind::Count | Kind::Integer => half_range(&values(quantity)?),
    };
    quantities.iter().filter(|quantity| quantity.main).map(|q| (q.name, scatter(q))).collect()
}

/// Half the range of the numbers; `None` if one is not a number.
fn half_range(values: &[Value<&str>]) -> Option<f64> {
    let values: Vec<f64> = values.iter().map(|value| value.number()).collect::<Option<_>>()?;
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    Some(0.5 * (largest - least))
}

/// Share of the values that are not the most frequent one.
fn share_of_others(values: &[Value<&str>]) -> Option<f64> {
    let usual = most_frequent(values.iter())?;
    let others = values.iter().filter(|value| *value != usual).count();
    Some(others as f64 / values.len() as f64)
}

/// The most frequent value; of equally frequent ones the one that comes first.
fn most_frequent<T: PartialEq>(values: impl Iterator<Item = T> + Clone) -> Option<T> {
    let count = |value: &T| values.clone().filter(|other| other == value).count();
    // `max_by_key` keeps the last of equals.
    let places: Vec<T> = values.clone().collect();
    places.into_iter().rev().max_by_key(count)
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
            numerical: None,
            signals: Vec::new(),
        }
    }

    fn scatter_of(mut run: RunMetrics, twins: &[RunMetrics]) -> Scatter {
        run.take_twins(twins);
        run.scatter.expect("taken in")
    }

    /// Half the range, the run itself included; nothing where one of the runs lacks the output, or without twins.
    #[test]
    fn analytic_half_range() {
        let scatter = scatter_of(run(Some(12.0), 100.0), &[run(Some(12.5), 90.0), run(Some(11.9), 94.0)]);
        assert_eq!(scatter.twins_done, 2);
        assert!((scatter.hammers[0]["periodic_energy_mean_j"].unwrap() - 0.3).abs() < 1e-12);
        assert_eq!(scatter.totals["delivered_work_j"], Some(5.0));
        assert_eq!(scatter.castings[0]["peak_velocity_m_s"], Some(0.0));
        assert_eq!(scatter.hammers[0]["hit_frequency_hz"], None);
        assert!(!scatter.hammers[0].contains_key("contact_count"));
        let lacking = scatter_of(run(Some(12.0), 100.0), &[run(None, 100.0)]);
        assert_eq!(lacking.hammers[0]["periodic_energy_mean_j"], None);
        assert_eq!(scatter_of(run(Some(12.0), 1.0), &[]).totals["delivered_work_j"], None);
    }

    /// The kind of percussion is the one that most show, the row's own among equals, with that kind's usual period; its scatter
    /// is the share of the others.
    #[test]
    fn analytic_kind_of_most() {
        let run = |percussion: Percussion, period: Option<u64>| {
            let mut run = run(None, 0.0);
            (run.hammers[0].percussion, run.hammers[0].percussion_period) = (percussion, period);
            run
        };
        let of = |own: RunMetrics, twins: &[RunMetrics]| {
            let mut own = own;
            own.take_twins(twins);
            let hammer = own.hammers.remove(0);
            (hammer.percussion, hammer.percussion_period, own.scatter.unwrap().hammers[0]["percussion"])
        };
        let (one, two) = (run(Percussion::Periodic, Some(1)), run(Percussion::Periodic, Some(2)));
        let none = run(Percussion::Aperiodic, None);
        let twins = [two.clone(), one.clone(), two.clone()];
        assert_eq!(of(none.clone(), &twins), (Percussion::Periodic, Some(2), Some(0.25)));
        assert_eq!(of(none.clone(), &twins[..1]), (Percussion::Aperiodic, None, Some(0.5)));
        assert_eq!(of(one.clone(), &[none]), (Percussion::Periodic, Some(1), Some(0.5)));
        assert_eq!(of(one, &[]), (Percussion::Periodic, Some(1), None));
    }
}

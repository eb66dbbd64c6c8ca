//! How far the main outputs of a run move under inputs that are the same for every purpose.

use libm::{erf, pow};

use super::outputs::{CastingMetrics, HammerMetrics, RunMetrics, RunTotals, Scatter, ScatterOf};
use super::percussion::Percussion;
use decore_quantity::{Kind, Quantity, Value};

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

/// Runs whose range is the measure of scatter, whatever the number of runs that were done: a row and ten twins.
const MEASURE_RUNS: usize = 11;
/// Standard deviations to both sides over which ranges are integrated, and steps.
const SIDE: f64 = 8.0;
/// See [`SIDE`].
const STEPS: i32 = 800;

/// Scatter of each main quantity over the same part of the runs: of a number half the range, of a text the share of the runs
/// that differ from the most frequent one. Nothing with fewer than two runs.
///
/// The range of a few runs is smaller than that of many. Half the range is scaled by the expected range of [`MEASURE_RUNS`] normal
/// values over that of as many as were run: it estimates the same figure for any number of twins.
fn scatter<T>(quantities: &[Quantity<T>], parts: &[&T]) -> ScatterOf {
    let values = |quantity: &Quantity<T>| -> Option<Vec<Value<&str>>> {
        let values: Option<Vec<Value<&str>>> = parts.iter().map(|part| (quantity.value)(part)).collect();
        values.filter(|values| values.len() > 1)
    };
    let scale = if parts.len() > 1 { expected_range(MEASURE_RUNS) / expected_range(parts.len()) } else { 1.0 };
    let scatter = |quantity: &Quantity<T>| match quantity.kind {
        Kind::Text | Kind::Category => share_of_others(&values(quantity)?),
        Kind::Real | Kind::Count | Kind::Integer => Some(scale * half_range(&values(quantity)?)?),
    };
    quantities.iter().filter(|quantity| quantity.main).map(|q| (q.name, scatter(q))).collect()
}

/// Expected range of `count` independent values of the standard normal distribution, `int 1 - F^n - (1 - F)^n dx`.
fn expected_range(count: usize) -> f64 {
    let at = |step: i32| {
        let below = 0.5 * (1.0 + erf(SIDE * f64::from(step) / f64::from(STEPS) / std::f64::consts::SQRT_2));
        1.0 - pow(below, count as f64) - pow(1.0 - below, count as f64)
    };
    (-STEPS..=STEPS).map(at).sum::<f64>() * SIDE / f64::from(STEPS)
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
            ..RunMetrics::default()
        }
    }

    fn scatter_of(mut run: RunMetrics, twins: &[RunMetrics]) -> Scatter {
        run.take_twins(twins);
        run.scatter.expect("taken in")
    }

    /// Expected ranges of tables of quality control (`d2`).
    #[test]
    fn analytic_expected_range() {
        for (count, range) in [(2, 1.128), (3, 1.693), (5, 2.326), (11, 3.173), (25, 3.931)] {
            assert!((expected_range(count) - range).abs() < 6e-4, "{count}: {}", expected_range(count));
        }
    }

    /// Half the range, the run itself included, scaled to that of eleven runs; nothing where one of the runs lacks the output, or
    /// without twins.
    #[test]
    fn analytic_half_range() {
        let scale = 3.1729 / 1.6926;
        let scatter = scatter_of(run(Some(12.0), 100.0), &[run(Some(12.5), 90.0), run(Some(11.9), 94.0)]);
        assert_eq!(scatter.twins_done, 2);
        assert!((scatter.hammers[0]["periodic_energy_mean_j"].unwrap() / scale - 0.3).abs() < 1e-4);
        assert!((scatter.totals["delivered_work_j"].unwrap() / scale - 5.0).abs() < 1e-3);
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

//! By how much the main outputs of a run move under better numerics: a row against its numerical twin.

use super::outputs::{CastingMetrics, HammerMetrics, NumericalErrors, RunMetrics, RunTotals, ScatterOf};
use super::percussion::Percussion;
use super::promise::{Promise, Span};
use crate::scene::Fidelity;
use decore_quantity::{Kind, Quantity};

impl RunMetrics {
    /// Takes in the row's numerical twin, the same scene with better numerics; `None` if that did not reach its end. The errors are
    /// held to the promises of the row's preset.
    pub fn take_numerical_twin(&mut self, twin: Option<&Self>, fidelity: Fidelity) {
        let Some(twin) = twin else {
            self.numerical = Some(NumericalErrors::default());
            return;
        };
        let regular = [&*self, twin].iter().flat_map(|run| &run.hammers).all(|hammer| is_regular(hammer.percussion));
        let mut judge = Judge { fidelity, regular, beyond: 0, worst: 0.0 };
        let hammers = self.hammers.iter().zip(&twin.hammers);
        let hammers = hammers.map(|(row, twin)| judge.errors(HammerMetrics::QUANTITIES, row, twin)).collect();
        let castings = self.castings.iter().zip(&twin.castings);
        let castings = castings.map(|(row, twin)| judge.errors(CastingMetrics::QUANTITIES, row, twin)).collect();
        let totals = judge.errors(RunTotals::QUANTITIES, &self.totals, &twin.totals);
        self.numerical = Some(NumericalErrors {
            numerical_twin_done: 1,
            numerical_errors_beyond_promise: Some(judge.beyond),
            worst_numerical_error_over_promise: Some(judge.worst),
            hammers,
            castings,
            totals,
        });
    }
}

/// Whether a percussion repeats, or strikes nothing: another one amplifies small differences, or is not settled.
fn is_regular(percussion: Percussion) -> bool {
    matches!(percussion, Percussion::Periodic | Percussion::None | Percussion::Blank)
}

/// Holds errors to the promises of a preset.
struct Judge {
    fidelity: Fidelity,
    /// Whether outputs of the whole run are held to their promise.
    regular: bool,
    /// Number of errors beyond their promise.
    beyond: u64,
    /// Largest error over its promise.
    worst: f64,
}

impl Judge {
    /// Errors of the main quantities of one hammer, one casting or the run.
    fn errors<T>(&mut self, quantities: &[Quantity<T>], row: &T, twin: &T) -> ScatterOf {
        let main = quantities.iter().filter(|quantity| quantity.main);
        main.map(|quantity| (quantity.name, self.error(quantity, row, twin))).collect()
    }

    /// Difference of two numbers; of two texts 1 if they differ. `None` where either run lacks the output.
    fn error<T>(&mut self, quantity: &Quantity<T>, row: &T, twin: &T) -> Option<f64> {
        let (own, other) = ((quantity.value)(row)?, (quantity.value)(twin)?);
        match quantity.kind {
            Kind::Text | Kind::Category => Some(f64::from(u8::from(own != other))),
            Kind::Real | Kind::Count | Kind::Integer => {
                let (own, other) = (own.number()?, other.number()?);
                self.hold(quantity.name, (own - other).abs(), own);
                Some((own - other).abs())
            }
        }
    }

    fn hold(&mut self, output: &str, error: f64, value: f64) {
        let Some(promise) = Promise::of(output).filter(|promise| promise.span == Span::FirstImpact || self.regular)
        else {
            return;
        };
        let allowed = promise.under(self.fidelity) * value.abs();
        let share = if error == 0.0 { 0.0 } else { error / allowed };
        self.beyond += u64::from(share > 1.0);
        self.worst = self.worst.max(share);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(energy: Option<f64>, work: f64, percussion: Percussion) -> RunMetrics {
        RunMetrics {
            hammers: vec![HammerMetrics {
                first_impact_energy_j: energy,
                delivered_work_j: work,
                percussion,
                ..HammerMetrics::default()
            }],
            ..RunMetrics::default()
        }
    }

    fn errors(mut row: RunMetrics, twin: Option<&RunMetrics>) -> NumericalErrors {
        row.take_numerical_twin(twin, Fidelity::Standard);
        row.numerical.expect("taken in")
    }

    /// Outputs of the first impact are held to their promise in every row, those of the run in regular rows.
    #[test]
    fn errors_are_held_to_promises() {
        let [first, work] = [HammerMetrics::first_impact_energy_j.name, HammerMetrics::delivered_work_j.name];
        let [of_first, of_work] = [first, work].map(|name| Promise::of(name).expect("a promise").standard);
        let twin = run(Some(70.0), 100.0, Percussion::Periodic);
        let moved = run(Some(70.0 * (1.0 + 2.0 * of_first)), 100.0 * (1.0 - 3.0 * of_work), Percussion::Periodic);
        let found = errors(moved.clone(), Some(&twin));
        let expected = 140.0 * of_first;
        assert!((found.hammers[0][first].expect("both have it") - expected).abs() < 1e-9 * expected);
        assert_eq!((found.numerical_twin_done, found.numerical_errors_beyond_promise), (1, Some(2)));
        let worst = found.worst_numerical_error_over_promise.expect("a worst one");
        assert!((worst - 3.0).abs() < 0.1, "{worst}");
        let chaotic = run(Some(70.0), 100.0, Percussion::Aperiodic);
        let found = errors(moved, Some(&chaotic));
        assert_eq!(found.numerical_errors_beyond_promise, Some(1));
        assert_eq!(found.hammers[0][HammerMetrics::percussion.name], Some(1.0));
    }

    #[test]
    fn outputs_that_a_run_lacks_have_no_error() {
        let twin = run(None, 100.0, Percussion::None);
        let found = errors(run(Some(70.0), 100.0, Percussion::None), Some(&twin));
        assert_eq!(found.hammers[0][HammerMetrics::first_impact_energy_j.name], None);
        assert_eq!(found.numerical_errors_beyond_promise, Some(0));
        let found = errors(run(Some(70.0), 100.0, Percussion::None), None);
        assert_eq!((found.numerical_twin_done, found.numerical_errors_beyond_promise), (0, None));
    }

    /// An output without promise would never be flagged.
    #[test]
    fn every_main_number_has_a_promise() {
        fn names<T>(quantities: &[Quantity<T>]) -> impl Iterator<Item = &'static str> {
            quantities.iter().filter(|quantity| quantity.main && !quantity.kind.is_text()).map(|quantity| quantity.name)
        }
        let all = names(HammerMetrics::QUANTITIES).chain(names(CastingMetrics::QUANTITIES));
        for name in all.chain(names(RunTotals::QUANTITIES)) {
            assert!(Promise::of(name).is_some(), "{name} has no promise: add it to PROMISES");
        }
    }
}

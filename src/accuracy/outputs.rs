//! Outputs of a run as a flat list of numbers, and their relative differences.

use decore_model::metrics::{CastingMetrics, HammerMetrics, RunMetrics};
use decore_quantity::{Cell, Quantity};

/// The outputs by which settings are compared in texts and plots.
pub const MAIN_OUTPUTS: [&str; 4] = {
    let [a, b, c, d] = HEADINGS;
    [a.0, b.0, c.0, d.0]
};

/// [`MAIN_OUTPUTS`] with the headings of their columns.
pub(super) const HEADINGS: [(&str, &str); 4] = [
    (HammerMetrics::first_impact_energy_j.name, "first impact"),
    (HammerMetrics::periodic_energy_mean_j.name, "periodic"),
    (HammerMetrics::hit_frequency_hz.name, "frequency"),
    (CastingMetrics::peak_velocity_m_s.name, "peak velocity"),
];

/// An output: its error is the largest over the hammers or castings.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Output {
    /// Name as in the tables.
    pub name: &'static str,
    /// Description of the output.
    pub description: String,
}

/// All outputs, in the order of [`differences`].
pub(super) fn outputs() -> Vec<Output> {
    fn of<T>(quantities: &'static [Quantity<T>]) -> impl Iterator<Item = Output> {
        numbers(quantities).map(|quantity| Output { name: quantity.name, description: quantity.description() })
    }
    let castings = of(CastingMetrics::QUANTITIES).filter(|output| !of_hammers(output.name));
    of(HammerMetrics::QUANTITIES).chain(castings).collect()
}

/// Relative difference of each output: the largest over the hammers or castings.
pub(super) fn differences(found: &RunMetrics, reference: &RunMetrics) -> Vec<f64> {
    let mut differences = quantities(HammerMetrics::QUANTITIES, &found.hammers, &reference.hammers);
    let of_castings = quantities(CastingMetrics::QUANTITIES, &found.castings, &reference.castings);
    let names = numbers(CastingMetrics::QUANTITIES).map(|quantity| quantity.name);
    differences
        .extend(of_castings.into_iter().zip(names).filter(|(_, name)| !of_hammers(name)).map(|(found, _)| found));
    differences
}

/// Whether hammers have an output of this name. A casting's output of the same name is the sum over its hammers, which err more.
fn of_hammers(name: &str) -> bool {
    numbers(HammerMetrics::QUANTITIES).any(|quantity| quantity.name == name)
}

/// Relative differences of the [`MAIN_OUTPUTS`].
pub fn main_differences(found: &RunMetrics, reference: &RunMetrics) -> [f64; MAIN_OUTPUTS.len()] {
    let all = differences(found, reference);
    let names = outputs();
    MAIN_OUTPUTS.map(|name| {
        let at = names.iter().position(|output| output.name == name);
        at.and_then(|at| all.get(at)).copied().unwrap_or(f64::NAN)
    })
}

/// The quantities that are numbers.
fn numbers<T>(quantities: &'static [Quantity<T>]) -> impl Iterator<Item = &'static Quantity<T>> {
    quantities.iter().filter(|quantity| !quantity.kind.is_text())
}

fn quantities<T>(quantities: &'static [Quantity<T>], found: &[T], reference: &[T]) -> Vec<f64> {
    let largest = |quantity: &Quantity<T>| {
        let pairs = found.iter().zip(reference).map(|(a, b)| ((quantity.value)(a), (quantity.value)(b)));
        // NaN if neither run has the output: the others decide.
        pairs.map(|(a, b)| difference(a, b)).fold(f64::NAN, f64::max)
    };
    numbers(quantities).map(largest).collect()
}

fn difference(found: Cell<'_>, reference: Cell<'_>) -> f64 {
    match (found.and_then(|value| value.number()), reference.and_then(|value| value.number())) {
        (None, None) => f64::NAN,
        (Some(a), Some(b)) if a == b => 0.0,
        (Some(a), Some(b)) if b != 0.0 => ((a - b) / b).abs(),
        _ => f64::INFINITY,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use decore_model::metrics::RunTotals;

    #[test]
    fn differences_are_relative_and_missing_values_count() {
        let run = |energy: [Option<f64>; 2], contacts: u64| RunMetrics {
            hammers: energy
                .map(|energy| HammerMetrics {
                    first_impact_energy_j: energy,
                    contact_count: contacts,
                    ..HammerMetrics::default()
                })
                .to_vec(),
            castings: vec![CastingMetrics { peak_velocity_m_s: 2.0, ..CastingMetrics::default() }],
            blows: Vec::new(),
            totals: RunTotals::default(),
            ..RunMetrics::default()
        };
        let names = outputs();
        let find = |differences: &[f64], name: &str| {
            let at = names.iter().position(|output| output.name == name).expect("an output");
            differences[at]
        };
        let reference = run([Some(70.0), Some(50.0)], 10);
        let one = differences(&run([Some(70.0), Some(51.0)], 11), &reference);
        assert!((find(&one, "first_impact_energy_j") - 0.02).abs() < 1e-15);
        assert!((find(&one, "contact_count") - 0.1).abs() < 1e-15);
        assert_eq!(find(&one, "peak_velocity_m_s"), 0.0);
        assert!(find(&one, "hit_frequency_hz").is_nan());
        let two = differences(&run([None, Some(50.0)], 10), &reference);
        assert_eq!(find(&two, "first_impact_energy_j"), f64::INFINITY);
        assert!(MAIN_OUTPUTS.iter().all(|name| names.iter().any(|output| output.name == *name)));
    }
}

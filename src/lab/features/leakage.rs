//! Columns that follow from targets by arithmetic. A predictor trained on such a column is trained on the answer.
//!
//! The table's formulas show some of them. A factor with a former result, perhaps in other units, is found from its numbers: a linear
//! function of another column, or a product or ratio of two.

use std::cmp::Ordering;

use super::column::{FeatureColumn, Role};

/// Fewest rows with all values, and fewest different values of a column: a line goes through any two points.
const LEAST: usize = 8;
/// Largest deviation from a rule through rounding, relative to the range of the column.
const ROUNDING: f64 = 1e-9;
/// Rows that a rule is first tried on: most fail there.
const TRIED: usize = 4;

/// A rule by which a column follows from others.
#[derive(Debug, Clone, PartialEq)]
pub struct Derived {
    /// The column.
    pub column: String,
    /// Columns from which it follows.
    pub from: Vec<String>,
    /// Rule in words.
    pub rule: String,
}

/// A product or ratio of a target and another number.
type Rule = fn(f64, f64) -> f64;

/// Numbers of a column by row; NaN if there is none.
struct Numbers<'a> {
    column: &'a FeatureColumn,
    values: Vec<f64>,
    /// Departure from a rule that rounding may leave.
    allowed: f64,
}

/// Finds columns that are a linear function of a target, or a constant times its product or ratio with another column. A pair is reported
/// once: the later of two targets follows from the earlier one. A relation of two targets and a factor is reported for both.
pub fn find(columns: &[FeatureColumn]) -> Vec<Derived> {
    let numbers: Vec<Numbers<'_>> = columns.iter().filter_map(Numbers::of).collect();
    let mut found: Vec<Derived> = Vec::new();
    for (place, own) in numbers.iter().enumerate() {
        // A factor may follow from any target and earlier factors, a target only from earlier columns.
        let is_known = |other: usize| {
            let is_answer = numbers[other].column.role == Role::Target && own.column.role != Role::Target;
            other < place || is_answer
        };
        let known = || (0..numbers.len()).filter(|other| is_known(*other)).map(|other| &numbers[other]);
        let mut targets = known().filter(|other| other.column.role == Role::Target);
        let rule =
            targets.find_map(|target| own.line(target).or_else(|| known().find_map(|other| own.power(target, other))));
        found.extend(rule);
    }
    found
}

impl<'a> Numbers<'a> {
    /// Ignores columns whose numbers are no measurements, and columns with few different values.
    fn of(column: &'a FeatureColumn) -> Option<Self> {
        if !matches!(column.role, Role::Factor | Role::Target) {
            return None;
        }
        let values: Vec<f64> =
            (0..column.values.count).map(|row| column.values.number(row).unwrap_or(f64::NAN)).collect();
        let mut different: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
        different.sort_unstable_by(f64::total_cmp);
        different.dedup();
        let [least, .., most] = different[..] else { return None };
        let allowed = ROUNDING * (most - least) + 4.0 * f64::EPSILON * most.abs().max(least.abs());
        (different.len() >= LEAST).then_some(Self { column, values, allowed })
    }

    fn derived(&self, from: &[&Self], rule: String) -> Derived {
        let mut from: Vec<String> = from.iter().map(|numbers| numbers.column.name.clone()).collect();
        // Of a square.
        from.dedup();
        Derived { column: self.column.name.clone(), from, rule }
    }

    /// The rule `own = a + b target`: the line through the rows with the least and the largest target, if all others are on it.
    fn line(&self, target: &Self) -> Option<Derived> {
        let pairs = || self.values.iter().zip(&target.values).filter(|(own, target)| (**own + **target).is_finite());
        let by_target = |a: &(&f64, &f64), b: &(&f64, &f64)| a.1.partial_cmp(b.1).unwrap_or(Ordering::Equal);
        let ((low, first), (high, last)) = (pairs().min_by(by_target)?, pairs().max_by(by_target)?);
        let slope = (high - low) / (last - first);
        let on_it = |(own, target): (&f64, &f64)| (low + slope * (target - first) - own).abs() <= self.allowed;
        let holds = slope.is_finite() && slope != 0.0 && pairs().count() >= LEAST && pairs().all(on_it);
        let offset = low - slope * first;
        let name = &target.column.name;
        holds.then(|| self.derived(&[target], format!("{offset:.6e} + {slope:.6e} {name}")))
    }

    /// The rules `own = c target other`, `own = c target / other` and `own = c other / target`.
    fn power(&self, target: &Self, other: &Self) -> Option<Derived> {
        let (one, two) = (&target.column.name, &other.column.name);
        let rules: [(Rule, String); 3] = [
            (|target, other| target * other, format!("{one} * {two}")),
            (|target, other| target / other, format!("{one} / {two}")),
            (|target, other| other / target, format!("{two} / {one}")),
        ];
        rules.into_iter().find_map(|(rule, words)| {
            let constant = self.constant(target, other, rule)?;
            Some(self.derived(&[target, other], format!("{constant:.6e} {words}")))
        })
    }

    /// The ratio of the column to a rule of two others, if it is one number.
    fn constant(&self, target: &Self, other: &Self, rule: Rule) -> Option<f64> {
        let rows = self.values.iter().zip(&target.values).zip(&other.values);
        let ratios = || {
            let ratio = |((own, target), other): ((&f64, &f64), &f64)| own / rule(*target, *other);
            // Rows of zeros carry no information.
            rows.clone().map(ratio).filter(|ratio| ratio.is_finite() && *ratio != 0.0)
        };
        let first = ratios().next()?;
        // By as much as the column itself may depart.
        let largest = self.values.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
        let same = |ratio: f64| (ratio / first - 1.0).abs() * largest <= self.allowed;
        (ratios().take(TRIED).all(same) && ratios().count() >= LEAST && ratios().all(same)).then_some(first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use decore_math::random::uniform;
    use decore_quantity::{CellColumn, Kind, Value};

    const ROWS: u64 = 40;

    fn column(name: &str, role: Role, value: impl Fn(u64) -> f64) -> FeatureColumn {
        FeatureColumn {
            name: name.to_owned(),
            unit: "1".to_owned(),
            role,
            description: String::new(),
            formula: String::new(),
            valid: [None, None],
            derived_from: Vec::new(),
            values: CellColumn::of(Kind::Real, (0..ROWS).map(|row| (row % 9 != 4).then(|| Value::Real(value(row))))),
        }
    }

    /// A target, another one and two factors that are independent of them.
    fn table() -> Vec<FeatureColumn> {
        let number = |stream: u64| move |row: u64| 1.0 + uniform(1, stream, row);
        vec![
            column("pressure", Role::Factor, number(0)),
            column("mass", Role::Factor, number(1)),
            column("work", Role::Target, number(2)),
            column("speed", Role::Target, number(3)),
        ]
    }

    fn planted(role: Role, value: impl Fn(&dyn Fn(usize) -> f64) -> f64) -> Vec<Derived> {
        let mut columns = table();
        let values = |place: usize, row: u64| columns[place].values.number(row as usize).unwrap_or(f64::NAN);
        let new = column("planted", role, |row| value(&|place| values(place, row)));
        columns.push(new);
        find(&columns)
    }

    #[test]
    fn independent_columns_are_not_accused() {
        assert_eq!(find(&table()), []);
        // A near function of a target is a good predictor, not a copy. A large added constant hides nothing.
        assert_eq!(planted(Role::Factor, |at| 1e9 + at(2) * (1.0 + 1e-2 * at(0))), []);
        assert_eq!(planted(Role::Factor, |at| at(2) * (1.0 + 1e-6 * at(0))), []);
        // A function of a factor is not the answer; sums of two columns are not looked for.
        assert_eq!(planted(Role::Factor, |at| 2.0 * at(0) + 1.0), []);
    }

    #[test]
    fn planted_functions_of_a_target_are_found() {
        let from = |found: Vec<Derived>| {
            assert!(found.iter().all(|one| one.column == "planted" || one.from.contains(&"planted".to_owned())));
            found.into_iter().find(|one| one.column == "planted").expect("found").from
        };
        for role in [Role::Factor, Role::Target] {
            assert_eq!(from(planted(role, |at| at(2))), ["work"]);
            assert_eq!(from(planted(role, |at| 3.5 - 1e3 * at(3))), ["speed"]);
            assert_eq!(from(planted(role, |at| 7.0 * at(2) * at(0))), ["work", "pressure"]);
            assert_eq!(from(planted(role, |at| at(2) / at(1))), ["work", "mass"]);
            assert_eq!(from(planted(role, |at| 0.1 * at(1) / at(3))), ["speed", "mass"]);
            assert_eq!(from(planted(role, |at| at(2) / at(3))), ["work", "speed"]);
            assert_eq!(from(planted(role, |at| at(3) * at(3))), ["speed"]);
        }
    }

    /// Two levels of a factor lie on a line through any two values.
    #[test]
    fn few_values_prove_nothing() {
        let mut columns = table();
        columns.push(column("level", Role::Factor, |row| (row % 2) as f64));
        columns.push(column("count", Role::Target, |row| (row % 2) as f64));
        assert_eq!(find(&columns), []);
    }
}

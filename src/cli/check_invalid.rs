//! Rows of a study that cannot be simulated: how many for which reason, and where the factors have to stay.

use schemars::JsonSchema;
use serde::Serialize;

use super::text::plural;
use decore_quantity::Value;
use decore_statistics::design::Level;
use decore_study::{CheckedStudy, FactorInfo};

/// Rows of a study that are looked at for scenes.
const LOOKED_AT: usize = 10_000;
/// Steps of a search for the end of a working range: each halves the rest.
const HALVINGS: usize = 30;
/// Failing rows beyond an end that the search starts from, the nearest ones.
const SEARCHED: usize = 8;
/// Kinds of failure that are printed.
const SHOWN: usize = 8;

/// Rows that cannot be simulated, such as a hammer that misses its casting.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Invalid {
    /// Number of rows that were checked, from the first on.
    pub looked_at: usize,
    /// Number of them that cannot be simulated.
    pub count: usize,
    /// First of these rows; null if there is none.
    pub first_row: Option<usize>,
    /// Reason for the first row; empty if there is none.
    pub reason: String,
    /// The same rows by the kind of their reason, the most frequent kind first.
    pub kinds: Vec<InvalidKind>,
}

/// Rows that cannot be simulated for the same kind of reason.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct InvalidKind {
    /// Number of rows.
    pub count: usize,
    /// First row.
    pub first_row: usize,
    /// Reason for the first row.
    pub reason: String,
    /// Ranges of factors in which rows do not fail for this reason; empty if no factor alone decides.
    pub working: Vec<WorkingRange>,
}

/// Range of a factor in which rows can be simulated.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub(super) struct WorkingRange {
    /// Name of the factor.
    pub factor: String,
    /// Unit; null if the study has none.
    pub unit: Option<String>,
    /// Lower end, in this unit; null if no row fails below.
    pub low: Option<f64>,
    /// Upper end, in this unit; null if no row fails above.
    pub high: Option<f64>,
}

impl Invalid {
    /// Looks at the first rows of a study.
    pub fn of(checked: &CheckedStudy) -> Self {
        let looked_at = checked.row_count().min(LOOKED_AT);
        let mut sound: Vec<usize> = Vec::new();
        // Kind, rows, and the reason of the first.
        let mut kinds: Vec<(String, Vec<usize>, String)> = Vec::new();
        for row in 0..looked_at {
            let Err(invalid) = checked.scene(row) else {
                sound.push(row);
                continue;
            };
            let kind = without_numbers(&invalid.reason);
            match kinds.iter_mut().find(|(known, ..)| *known == kind) {
                Some((_, rows, _)) => rows.push(row),
                None => kinds.push((kind, vec![row], invalid.reason)),
            }
        }
        kinds.sort_by_key(|(_, rows, _)| (std::cmp::Reverse(rows.len()), rows.first().copied()));
        let kinds: Vec<InvalidKind> = kinds
            .into_iter()
            .map(|(_, rows, reason)| InvalidKind {
                count: rows.len(),
                first_row: rows.first().copied().unwrap_or_default(),
                reason,
                working: working(checked, &sound, &rows),
            })
            .collect();
        let first = kinds.iter().min_by_key(|kind| kind.first_row);
        Self {
            looked_at,
            count: looked_at - sound.len(),
            first_row: first.map(|kind| kind.first_row),
            reason: first.map(|kind| kind.reason.clone()).unwrap_or_default(),
            kinds,
        }
    }

    /// A warning of several lines; `None` if all rows can be simulated.
    pub fn warning(&self, rows: usize) -> Option<String> {
        if self.count == 0 {
            return None;
        }
        let of = if self.looked_at < rows { format!("the first {}", self.looked_at) } else { rows.to_string() };
        let mut lines = vec![format!("warning: {} of {of} rows cannot be simulated", self.count)];
        for kind in self.kinds.iter().take(SHOWN) {
            let (brief, figures) = split_reason(&kind.reason);
            let working: Vec<String> = kind.working.iter().map(WorkingRange::sentence).collect();
            let working = if working.is_empty() { String::new() } else { format!("; {}", working.join(", ")) };
            lines.push(format!("  {}: {brief}{working}", plural(kind.count, "row")));
            if !figures.is_empty() {
                lines.push(format!("    first: row {}, {figures}", kind.first_row));
            }
        }
        if self.kinds.len() > SHOWN {
            lines.push(format!("  and {} more kinds of reason (`--json` lists all)", self.kinds.len() - SHOWN));
        }
        lines.push(
            "help: change the range of a factor, or add a `constraints` entry to [design]; `decore run` stores such rows with the \
             status `invalid`"
                .to_owned(),
        );
        Some(lines.join("\n"))
    }
}

impl WorkingRange {
    /// `position must stay within +-0.14 m`.
    fn sentence(&self) -> String {
        let unit = self.unit.as_deref().filter(|unit| *unit != "1").map_or(String::new(), |unit| format!(" {unit}"));
        let name = &self.factor;
        match (self.low, self.high) {
            (Some(low), Some(high)) if inward(-low) == inward(high) => {
                format!("{name} must stay within +-{}{unit}", inward(high))
            }
            (Some(low), Some(high)) => format!("{name} must stay within {} and {}{unit}", inward_up(low), inward(high)),
            (Some(low), None) => format!("{name} must be at least {}{unit}", inward_up(low)),
            (None, Some(high)) => format!("{name} must be at most {}{unit}", inward(high)),
            (None, None) => format!("{name} can have any value"),
        }
    }
}

/// A number to three digits, not above it.
fn inward(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let unit = 10_f64.powi(value.abs().log10().floor() as i32 - 2);
    let steps = (value / unit + 1e-6).floor();
    let text = format!("{:.2e}", steps * unit);
    text.parse::<f64>().map_or(text, |value| value.to_string())
}

/// A number to three digits, not below it.
fn inward_up(value: f64) -> String {
    let text = inward(-value);
    match text.strip_prefix('-') {
        Some(positive) => positive.to_owned(),
        None if text == "0" => text,
        None => format!("-{text}"),
    }
}

/// A reason without the path in front and without the figures behind: `hammer ... would miss casting ...`.
pub(super) fn split_reason(reason: &str) -> (&str, &str) {
    let message = match reason.strip_prefix('`').and_then(|rest| rest.split_once("`: ")) {
        Some((_, message)) => message,
        None => reason,
    };
    message.split_once(": ").unwrap_or((message, ""))
}

/// A reason without its numbers: what rows of one kind have in common.
pub(super) fn without_numbers(reason: &str) -> String {
    let mut kind = String::with_capacity(reason.len());
    let mut in_name = false;
    for c in reason.chars() {
        // Digits of names stay.
        if c == '`' {
            in_name = !in_name;
        }
        if in_name || !(c.is_ascii_digit() || "+-.e".contains(c)) {
            kind.push(c);
        }
    }
    kind
}

/// Ranges of single factors that part the failing rows from the sound ones.
fn working(checked: &CheckedStudy, sound: &[usize], failing: &[usize]) -> Vec<WorkingRange> {
    let drawn: Vec<&FactorInfo> = checked.study().factors().iter().filter(|one| one.distribution().is_some()).collect();
    let range = |(index, factor): (usize, &&FactorInfo)| {
        let value = |row: &usize| number(checked.design().row(*row)?.get(index)?, factor);
        let values: Option<Vec<f64>> = sound.iter().map(value).collect();
        let (low, high) = ends(&values?)?;
        let bad: Option<Vec<(f64, usize)>> = failing.iter().map(|row| Some((value(row)?, *row))).collect();
        let (mut below, mut above) = (Vec::new(), Vec::new());
        for (value, row) in bad? {
            match () {
                () if value < low => below.push((value, row)),
                () if value > high => above.push((value, row)),
                () => return None,
            }
        }
        below.sort_by(|a, b| b.0.total_cmp(&a.0));
        above.sort_by(|a, b| a.0.total_cmp(&b.0));
        let end = |from: f64, beyond: &[(f64, usize)]| {
            let found = beyond.iter().take(SEARCHED).filter_map(|one| boundary(checked, (index, factor), from, *one));
            found.min_by(|a, b| (a - from).abs().total_cmp(&(b - from).abs())).unwrap_or(from)
        };
        Some(WorkingRange {
            factor: factor.name.clone(),
            unit: factor.unit.clone(),
            low: (!below.is_empty()).then(|| end(low, &below)),
            high: (!above.is_empty()).then(|| end(high, &above)),
        })
    };
    drawn.iter().enumerate().filter_map(range).collect()
}

/// Value of a level; `None` for a text.
fn number(level: &Level, factor: &FactorInfo) -> Option<f64> {
    match level {
        Level::Real(value) => Some(*value),
        Level::Integer(value) => Some(*value as f64),
        Level::Category(index) => factor.values.get(*index).and_then(Value::number),
    }
}

/// Least and largest of some numbers; `None` without any.
fn ends(values: &[f64]) -> Option<(f64, f64)> {
    let low = values.iter().copied().reduce(f64::min)?;
    Some((low, values.iter().copied().reduce(f64::max)?))
}

/// Last value of a real factor that works on the way from a working value to the one of a failing row, all else as in that row;
/// `None` for other factors, and if the row fails at the working value too.
fn boundary(
    checked: &CheckedStudy,
    (index, factor): (usize, &FactorInfo),
    works: f64,
    (fails, row): (f64, usize),
) -> Option<f64> {
    let levels = checked.design().row(row)?;
    let is_real = factor.values.is_empty() && matches!(levels.get(index), Some(Level::Real(_)));
    let sound = |value: f64| {
        let mut levels = levels.clone();
        *levels.get_mut(index)? = Level::Real(value);
        Some(checked.scene_at(&levels).is_ok())
    };
    if !is_real || !sound(works)? {
        return None;
    }
    let (mut works, mut fails) = (works, fails);
    for _ in 0..HALVINGS {
        let middle = works + 0.5 * (fails - works);
        if sound(middle)? { works = middle } else { fails = middle }
    }
    Some(works)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_rounded_inward() {
        assert_eq!([0.139_99, 0.14, -0.139_99, 2e7, 0.0].map(inward), ["0.139", "0.14", "-0.14", "20000000", "0"]);
        assert_eq!([0.139_99, -0.139_99, 0.0].map(inward_up), ["0.14", "-0.139", "0"]);
        let range = |low, high| WorkingRange { factor: "x".to_owned(), unit: Some("m".to_owned()), low, high };
        assert_eq!(range(Some(-0.14), Some(0.14)).sentence(), "x must stay within +-0.14 m");
        assert_eq!(range(Some(-0.1), Some(0.14)).sentence(), "x must stay within -0.1 and 0.14 m");
        assert_eq!(range(None, Some(0.14)).sentence(), "x must be at most 0.14 m");
    }

    #[test]
    fn reasons_of_a_kind_differ_in_numbers_alone() {
        let reason = |x: f64, name: &str| {
            format!(
                "`hammer.{name}.strike_point_m`: hammer `{name}` would miss casting `p`: it strikes at ({x:.4}, 0.1) m"
            )
        };
        assert_eq!(without_numbers(&reason(-0.15, "h1")), without_numbers(&reason(0.2, "h1")));
        assert_ne!(without_numbers(&reason(0.15, "h1")), without_numbers(&reason(0.15, "h2")));
        assert_eq!(split_reason(&reason(0.1, "h1")).0, "hammer `h1` would miss casting `p`");
    }
}

//! Domain of a factor, as typed: a range, a distribution, values, or an expression.

use super::factor::FactorInfo;
use super::reader::FactorReader;
use crate::expression::Expression;
use crate::file::{DistributionName, Scale};
use decore_quantity::Value;
use decore_quantity::words::nearest;
use decore_statistics::design::Distribution;

/// Whole numbers up to this size are floats of their own: 2^53.
const WHOLE: f64 = 9_007_199_254_740_992.0;

impl FactorReader<'_> {
    /// Reads the expression of a derived factor; `before` are the factors that it may use.
    pub fn derived(&mut self, text: &str, before: &[FactorInfo]) -> Expression {
        let (entry, key) = (self.entry, ["expression"]);
        if entry.range.is_some() || entry.values.is_some() || entry.distribution.is_some() {
            self.problem(&key, "gives the factor's value, so it has no range, values or distribution");
        }
        if entry.role.is_some() {
            let problem =
                self.problem(&["role"], "a factor with an expression has no role: its value follows from others");
            problem.expected = Some("a role on the factors of the expression".to_owned());
        }
        match Expression::parse(text) {
            Ok(expression) => {
                let unknown = |used: &&str| before.iter().all(|info| info.name != *used);
                if let Some(used) = expression.names().into_iter().find(unknown) {
                    let problem = self.problem(&key, format!("there is no factor `{used}` before this one"));
                    problem.nearest = nearest(used, before.iter().map(|info| info.name.as_str()));
                } else if expression.calls_scope() {
                    self.problem(&key, "calls a function that is not known here");
                }
                expression
            }
            Err(error) => {
                self.problem(&key, error.to_string());
                Expression::constant(0.0)
            }
        }
    }

    /// Holds the values to each other: none twice, all numbers or all texts.
    pub fn check_values(&mut self) {
        let values = self.values();
        for (index, value) in values.iter().enumerate() {
            if values.iter().take(index).any(|other| same(other, value)) {
                self.problem(&["values", &index.to_string()], format!("the value {value} is given twice"));
            }
        }
        let texts = values.iter().filter(|value| matches!(value, Value::Text(_))).count();
        if texts > 0 && texts < values.len() {
            self.problem(&["values"], "mixes texts and numbers");
        }
    }

    /// Domain of a drawn factor; a substitute if it has errors.
    pub fn distribution(&mut self) -> Distribution {
        if let Some(distribution) = self.shaped() {
            return distribution;
        }
        let entry = self.entry;
        let categories = Distribution::Categories { count: self.values().len().max(1) };
        match (entry.range, &entry.values) {
            (Some(range), None) => self.uniform(range).unwrap_or(categories),
            (None, Some(values)) => {
                let given = [entry.scale.is_some(), entry.integer.is_some(), entry.levels.is_some()];
                for (key, _) in ["scale", "integer", "levels"].iter().zip(given).filter(|(_, given)| *given) {
                    self.problem(&[key], "belongs to a `range`, not to `values`");
                }
                Distribution::Categories { count: values.len() }
            }
            _ => {
                let expected = "either `range = [LOW, HIGH]` or `values = [...]`";
                let both = entry.range.is_some() && entry.values.is_some();
                let message = if both { "has both a `range` and `values`" } else { "has no range and no values" };
                self.problem(&[], message).expected = Some(expected.into());
                categories
            }
        }
    }

    /// A range without preference for any of its values.
    fn uniform(&mut self, [low, high]: [f64; 2]) -> Option<Distribution> {
        let scale = self.entry.scale.unwrap_or_default();
        if self.entry.integer != Some(true) {
            return Some(match scale {
                Scale::Linear => Distribution::Uniform { low, high },
                Scale::Log => Distribution::LogUniform { low, high },
            });
        }
        let whole = |end: f64| end.fract() == 0.0 && end.abs() <= WHOLE;
        if !(whole(low) && whole(high)) {
            self.problem(&["range"], "the ends of a range of integers must be whole numbers");
            return None;
        }
        let (low, high) = (low as i64, high as i64);
        Some(match scale {
            Scale::Linear => Distribution::Integer { low, high },
            Scale::Log => Distribution::LogInteger { low, high },
        })
    }

    /// A distribution other than uniform; `None` for uniform ones and where it is at fault.
    fn shaped(&mut self) -> Option<Distribution> {
        let entry = self.entry;
        let kind = entry.distribution.unwrap_or_default();
        if !self.has_its_keys(kind) {
            return None;
        }
        let number = |value: Option<f64>| value.unwrap_or(f64::NAN);
        let (mean, std_dev) = (number(entry.mean), number(entry.std_dev));
        match (kind, entry.range) {
            (DistributionName::Normal, None) => Some(Distribution::Normal { mean, std_dev }),
            (DistributionName::Normal, Some([low, high])) => {
                Some(Distribution::TruncatedNormal { mean, std_dev, low, high })
            }
            (DistributionName::Triangular, Some([low, high])) => {
                Some(Distribution::Triangular { low, mode: number(entry.mode), high })
            }
            (DistributionName::Beta, Some([low, high])) => {
                Some(Distribution::Beta { alpha: number(entry.alpha), beta: number(entry.beta), low, high })
            }
            (DistributionName::Empirical, None) => {
                Some(Distribution::empirical(entry.data.clone().unwrap_or_default()))
            }
            (DistributionName::Empirical, Some(_)) => {
                self.problem(&["range"], "the data tell the range");
                None
            }
            (DistributionName::Uniform, _) | (DistributionName::Triangular | DistributionName::Beta, None) => None,
        }
    }

    /// Whether a distribution has the keys that belong to it and no others.
    fn has_its_keys(&mut self, kind: DistributionName) -> bool {
        let (entry, before) = (self.entry, self.problems.len());
        let numbers = [
            ("mean", entry.mean, DistributionName::Normal),
            ("std_dev", entry.std_dev, DistributionName::Normal),
            ("mode", entry.mode, DistributionName::Triangular),
            ("alpha", entry.alpha, DistributionName::Beta),
            ("beta", entry.beta, DistributionName::Beta),
        ];
        for (key, value, owner) in numbers {
            match (owner == kind, value) {
                (true, None) => self.problem(&[key], "missing key").expected = Some("a number".into()),
                (false, Some(_)) => {
                    self.problem(&[key], "does not belong to this distribution");
                }
                _ => {}
            }
        }
        if (kind == DistributionName::Empirical) != entry.data.is_some() {
            let problem = self.problem(&["data"], "belongs to `distribution = \"empirical\"`, which needs it");
            problem.expected = Some("a list of observations".into());
        }
        let plain = kind == DistributionName::Uniform;
        if !plain && (entry.scale.is_some() || entry.integer == Some(true) || entry.values.is_some()) {
            self.problem(&["distribution"], "is for real numbers: it takes no `scale`, `integer` or `values`");
        }
        self.problems.len() == before
    }
}

fn same(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Integer(a), Value::Real(b)) | (Value::Real(b), Value::Integer(a)) => *a as f64 == *b,
        _ => a == b,
    }
}

//! One factor of a study: domain, source of its value, targets.

use crate::document::path;
use crate::expression::{self, Expression, Scope};
use crate::file::FactorRole;
use decore_model::parameter::short;
use decore_quantity::units::Conversion;
use decore_quantity::{Kind, Value};
use decore_statistics::design::{Distribution, Level};

/// One factor of a study: domain and targets.
#[derive(Debug, Clone, PartialEq)]
pub struct FactorInfo {
    /// Name as in the study.
    pub name: String,
    /// Type of its values, hence of its column.
    pub kind: Kind,
    /// Unit, if the study gives one.
    pub unit: Option<String>,
    /// The values that it chooses from; empty for a range.
    pub values: Vec<Value>,
    /// Role of the factor.
    pub role: FactorRole,
    /// Source of the value.
    pub(crate) source: FactorSource,
    /// The parameters that it drives.
    pub(crate) drives: Vec<Driven>,
}

/// Source of a factor's value.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum FactorSource {
    /// A factor of the design.
    Drawn {
        /// Index in that source.
        index: usize,
        /// Domain; categories are indices of the factor's values.
        distribution: Distribution,
    },
    /// An expression of factors before it.
    Derived {
        /// As written.
        text: String,
        /// As read.
        expression: Expression,
    },
}

/// A parameter that a factor drives.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Driven {
    pub path: Vec<String>,
    pub link: Link,
    /// Unit of the parameter, where the factor has another one that is converted.
    pub converted_to: Option<&'static str>,
}

/// Relation of a parameter to its factor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Link {
    pub factor: f64,
    pub offset: f64,
}

impl FactorInfo {
    /// Domain; categories are indices of [`FactorInfo::values`]. `None` for a derived factor.
    pub fn distribution(&self) -> Option<&Distribution> {
        match &self.source {
            FactorSource::Drawn { distribution, .. } => Some(distribution),
            FactorSource::Derived { .. } => None,
        }
    }

    /// The expression that gives a derived factor its value.
    pub fn expression(&self) -> Option<&str> {
        match &self.source {
            FactorSource::Drawn { .. } => None,
            FactorSource::Derived { text, .. } => Some(text),
        }
    }

    /// Paths of the parameters that it drives.
    pub fn paths(&self) -> Vec<String> {
        self.drives.iter().map(|driven| path::join(&driven.path)).collect()
    }

    /// Its ends in the units of the parameters that it drives, a sentence for each parameter whose unit is another one.
    pub fn conversions(&self) -> Vec<String> {
        let unit = self.unit.as_deref().unwrap_or_default();
        let words = |driven: &Driven| {
            let to = driven.converted_to?;
            let path = path::join(&driven.path);
            let converted = |value: f64| short_digits(driven.link.factor * value + driven.link.offset);
            let ends: Vec<f64> = self.extremes().into_iter().filter_map(|level| self.value(level).number()).collect();
            let (low, high) = (ends.iter().copied().reduce(f64::min), ends.iter().copied().reduce(f64::max));
            Some(match (low, high) {
                (Some(low), Some(high)) => format!(
                    "factor `{}`: {} to {} {unit} are converted to {} to {} {to} for `{path}`",
                    self.name,
                    short(low),
                    short(high),
                    converted(low),
                    converted(high)
                ),
                _ => format!("factor `{}`: values in {unit} are converted to {to} for `{path}`", self.name),
            })
        };
        self.drives.iter().filter_map(words).collect()
    }

    /// Domain in words: a range, a distribution, the values or the expression.
    pub fn domain(&self) -> String {
        let span = |low: f64, high: f64| format!("{} to {}", short(low), short(high));
        let about = |mean: f64, std_dev: f64| format!("normal, {} +- {}", short(mean), short(std_dev));
        match self.distribution() {
            None => format!("= {}", self.expression().unwrap_or_default()),
            Some(Distribution::Uniform { low, high }) => span(*low, *high),
            Some(Distribution::LogUniform { low, high }) => format!("{} (logarithmic)", span(*low, *high)),
            Some(Distribution::Normal { mean, std_dev }) => about(*mean, *std_dev),
            Some(Distribution::TruncatedNormal { mean, std_dev, low, high }) => {
                format!("{} ({}, cut)", span(*low, *high), about(*mean, *std_dev))
            }
            Some(Distribution::Triangular { low, mode, high }) => {
                format!("{} (triangular about {})", span(*low, *high), short(*mode))
            }
            Some(Distribution::Beta { alpha, beta, low, high }) => {
                format!("{} (beta {alpha}, {beta})", span(*low, *high))
            }
            Some(Distribution::Empirical { sorted }) => {
                let end = |end: Option<&f64>| end.copied().unwrap_or_default();
                format!("{} ({} observations)", span(end(sorted.first()), end(sorted.last())), sorted.len())
            }
            Some(Distribution::Integer { low, high }) => format!("{low} to {high} (whole numbers)"),
            Some(Distribution::LogInteger { low, high }) => format!("{low} to {high} (whole numbers, logarithmic)"),
            Some(Distribution::Categories { .. }) => {
                self.values.iter().map(ToString::to_string).collect::<Vec<_>>().join(" | ")
            }
        }
    }

    /// The value of a level.
    pub(crate) fn value(&self, level: Level) -> Value {
        match level {
            Level::Real(value) => Value::Real(value),
            Level::Integer(value) => Value::Integer(value),
            Level::Category(index) => match (self.values.get(index), self.kind) {
                (Some(Value::Integer(value)), Kind::Real) => Value::Real(*value as f64),
                (Some(value), _) => value.clone(),
                (None, _) => Value::Text(String::new()),
            },
        }
    }

    /// Levels at the ends of its range, or all its categories: if these are valid, every row is.
    pub(crate) fn extremes(&self) -> Vec<Level> {
        match self.distribution() {
            None => Vec::new(),
            Some(Distribution::Integer { low, high } | Distribution::LogInteger { low, high }) => {
                vec![Level::Integer(*low), Level::Integer(*high)]
            }
            Some(Distribution::Categories { count }) => (0..*count).map(Level::Category).collect(),
            Some(real) => real.range().map_or(Vec::new(), |(low, high)| vec![Level::Real(low), Level::Real(high)]),
        }
    }
}

/// A number to five digits.
fn short_digits(value: f64) -> String {
    short(format!("{value:.4e}").parse().unwrap_or(value))
}

/// A factor's value as TOML.
pub(crate) fn to_toml(value: &Value) -> toml::Value {
    match value {
        Value::Integer(number) => toml::Value::Integer(*number),
        Value::Real(number) => toml::Value::Float(*number),
        Value::Count(number) => toml::Value::Integer(number.cast_signed()),
        Value::Text(text) => toml::Value::String(text.clone()),
    }
}

impl Driven {
    /// Value of the parameter for a value of its factor.
    pub fn value(&self, factor: &Value) -> toml::Value {
        match factor.number() {
            Some(number) if self.link != Link::SAME => toml::Value::Float(self.link.factor * number + self.link.offset),
            _ => to_toml(factor),
        }
    }
}

impl Link {
    /// The same value.
    pub const SAME: Self = Self { factor: 1.0, offset: 0.0 };

    /// Returns this link behind a conversion of the factor's unit.
    pub fn after(self, conversion: Conversion) -> Self {
        let Conversion { factor, offset } = conversion;
        if (factor, offset) == (1.0, 0.0) {
            return self;
        }
        Self { factor: self.factor * factor, offset: self.factor * offset + self.offset }
    }
}

/// Values of the factors so far, as names of an expression.
pub(crate) struct Factors<'a> {
    pub names: &'a [FactorInfo],
    pub values: &'a [Value],
}

impl Factors<'_> {
    pub fn get(&self, name: &str) -> Option<expression::Outcome> {
        let pair = self.names.iter().zip(self.values).find(|(info, _)| info.name == name);
        let text = |value: &Value| expression::Outcome::Text(value.to_string());
        pair.map(|(_, value)| value.number().map_or_else(|| text(value), expression::Outcome::Number))
    }
}

impl Scope for Factors<'_> {
    fn value(&self, name: &str) -> Result<expression::Outcome, String> {
        self.get(name).ok_or_else(|| format!("there is no factor `{name}`"))
    }

    fn call(&self, function: &str, _: &[&str]) -> Result<f64, String> {
        Err(format!("there is no function `{function}`"))
    }
}

/// Type of the values of a factor's domain.
pub(crate) fn kind_of(distribution: &Distribution, values: &[Value]) -> Kind {
    match distribution {
        Distribution::Integer { .. } | Distribution::LogInteger { .. } => Kind::Integer,
        Distribution::Categories { .. } => {
            if values.iter().any(|value| matches!(value, Value::Text(_))) {
                Kind::Text
            } else if values.iter().all(|value| matches!(value, Value::Integer(_))) {
                Kind::Integer
            } else {
                Kind::Real
            }
        }
        _ => Kind::Real,
    }
}

//! Comparison of the paper's figures with ours, as plain data.

use std::fmt;

use schemars::JsonSchema;
use serde::Serialize;

use super::mobility::Mobility;
use super::quoted::CITATION;
use decore_statistics::signal::relative_difference;

/// Comparison of the paper with decore.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PaperComparison {
    /// Publication of the paper.
    pub citation: &'static str,
    /// Number of calculated figures with which ours agree.
    pub calculations: Agreement,
    /// Number of measured figures with which ours agree.
    pub measurements: Agreement,
    /// Number of quoted differences with which ours agree.
    pub quoted_differences: Agreement,
    /// Figures that belong together.
    pub groups: Vec<FigureGroup>,
    /// Our mobilities, for its Figure 14.
    pub mobility: Mobility,
}

/// Number of figures that agree.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Agreement {
    /// Figures that agree by their group's tolerance.
    pub agree: usize,
    /// Figures.
    pub of: usize,
}

/// Group of figures, the explanation of their differences, and runs as evidence.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct FigureGroup {
    /// Name of the group.
    pub name: &'static str,
    /// Table, figure or section of the paper.
    pub source: &'static str,
    /// Tolerance of the figures.
    pub tolerance: Tolerance,
    /// The figures; none if the paper prints curves alone.
    pub figures: Vec<PaperFigure>,
    /// Remarks on agreement, differences and their causes.
    pub remarks: Vec<String>,
    /// Evidence for the remarks: figures of decore alone.
    pub evidence: Vec<Evidence>,
}

/// Tolerance within which one of our figures agrees.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Tolerance {
    /// By a share of the paper's figure.
    Share {
        /// Of its calculation.
        of_calculation: f64,
        /// Of its measurement.
        of_measurement: f64,
    },
    /// By an absolute difference of figures that are in per cent themselves.
    PercentagePoints {
        /// Largest difference.
        most: f64,
    },
}

/// One figure of the paper and ours.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PaperFigure {
    /// Name of the figure.
    pub name: String,
    /// Unit of all its values.
    pub unit: &'static str,
    /// Ours against the paper's calculation; null if it prints none.
    pub calculated: Option<Against>,
    /// Ours against the paper's measurement; null if it prints none.
    pub measured: Option<Against>,
    /// Ours against a difference that the paper quotes between its calculation and its measurement; null if it is none.
    pub quoted: Option<Against>,
    /// Ours.
    pub ours: f64,
}

/// Ours against a value of the paper.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Against {
    /// The paper's value.
    pub paper: f64,
    /// `(ours - paper) / paper`; of figures that are in per cent themselves `ours - paper`.
    pub difference: f64,
    /// Whether ours lies within the group's tolerance.
    pub agrees: bool,
}

/// A table of ours alone.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Evidence {
    /// Subject of the evidence.
    pub name: &'static str,
    /// Headings of the values, with their units.
    pub columns: Vec<&'static str>,
    /// Rows of the evidence.
    pub rows: Vec<EvidenceRow>,
}

/// A row of such a table.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct EvidenceRow {
    /// The change, or the subject of the row.
    pub label: String,
    /// A value for each column; null if there is none.
    pub values: Vec<Option<f64>>,
}

impl PaperComparison {
    pub(super) fn new(groups: Vec<FigureGroup>, mobility: Mobility) -> Self {
        let counted = |of: fn(&PaperFigure) -> Option<Against>| {
            let against = groups.iter().flat_map(|group| &group.figures).filter_map(of);
            against.fold(Agreement { agree: 0, of: 0 }, |sum, one| Agreement {
                agree: sum.agree + usize::from(one.agrees),
                of: sum.of + 1,
            })
        };
        Self {
            citation: CITATION,
            calculations: counted(|figure| figure.calculated),
            measurements: counted(|figure| figure.measured),
            quoted_differences: counted(|figure| figure.quoted),
            groups,
            mobility,
        }
    }
}

/// A figure without its tolerance.
#[derive(Debug, Clone)]
pub(super) struct Printed {
    pub name: String,
    pub unit: &'static str,
    pub calculated: Option<f64>,
    pub measured: Option<f64>,
    pub quoted: Option<f64>,
    pub ours: f64,
}

impl Printed {
    /// A figure that the paper calculated and measured, in this order.
    pub fn both(name: impl Into<String>, unit: &'static str, [calculated, measured]: [f64; 2], ours: f64) -> Self {
        Self { measured: Some(measured), ..Self::calculated(name, unit, calculated, ours) }
    }

    /// One that it calculated alone.
    pub fn calculated(name: impl Into<String>, unit: &'static str, calculated: f64, ours: f64) -> Self {
        Self { name: name.into(), unit, calculated: Some(calculated), measured: None, quoted: None, ours }
    }

    /// A difference of calculation and measurement in %.
    pub fn difference(name: &str, quoted: f64, ours: f64) -> Self {
        Self { name: name.to_owned(), unit: "%", calculated: None, measured: None, quoted: Some(quoted), ours }
    }
}

impl Tolerance {
    /// Applies the tolerance to a figure.
    pub(super) fn judge(self, printed: Printed) -> PaperFigure {
        let Printed { name, unit, calculated, measured, quoted, ours } = printed;
        let (relative, [of_calculation, of_measurement]) = match self {
            Self::Share { of_calculation, of_measurement } => (true, [of_calculation, of_measurement]),
            Self::PercentagePoints { most } => (false, [most; 2]),
        };
        let against = |paper: f64, most: f64| {
            let difference = if relative { relative_difference(ours, paper) } else { ours - paper };
            Against { paper, difference, agrees: difference.abs() <= most }
        };
        PaperFigure {
            calculated: calculated.map(|paper| against(paper, of_calculation)),
            measured: measured.map(|paper| against(paper, of_measurement)),
            quoted: quoted.map(|paper| against(paper, of_calculation)),
            name,
            unit,
            ours,
        }
    }
}

impl fmt::Display for Tolerance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Share { of_calculation, of_measurement } => {
                let [calculation, measurement] = [of_calculation, of_measurement].map(|share| 100.0 * share);
                write!(f, "{calculation} % of the calculation, {measurement} % of the measurement")
            }
            Self::PercentagePoints { most } => write!(f, "{most} percentage points"),
        }
    }
}

impl Tolerance {
    /// Headings of [`PaperFigure::cells`] for figures with this tolerance.
    pub fn columns(self) -> [&'static str; 5] {
        match self {
            Self::Share { .. } => ["calculated", "measured", "ours", "to calc.", "to meas."],
            Self::PercentagePoints { .. } => ["quoted", "", "ours", "points", ""],
        }
    }
}

impl PaperFigure {
    /// Values in words: calculated or quoted by the paper, measured by the paper, ours, the differences of ours to both; `*` marks a
    /// difference beyond the tolerance.
    pub fn cells(&self) -> [String; 5] {
        let none = if self.quoted.is_some() { "" } else { "-" };
        let printed = |against: Option<Against>| against.map_or(none.to_owned(), |one| one.paper.to_string());
        let difference = |against: Option<Against>| {
            against.map_or(String::new(), |one| {
                let star = if one.agrees { ' ' } else { '*' };
                match self.unit {
                    "%" => format!("{:+.1}{star}", one.difference),
                    _ => format!("{:+.1} %{star}", 100.0 * one.difference),
                }
            })
        };
        let first = self.calculated.or(self.quoted);
        let ours = four_digits(self.ours);
        [printed(first), printed(self.measured), ours, difference(first), difference(self.measured)]
    }
}

/// Ours to four digits: more than the paper prints.
pub fn four_digits(value: f64) -> String {
    let decimals = (3 - value.abs().max(1e-9).log10().floor() as i32).clamp(0, 8) as usize;
    format!("{value:.decimals$}")
}

impl Evidence {
    pub(super) fn new(name: &'static str, columns: &[&'static str], rows: Vec<EvidenceRow>) -> Self {
        Self { name, columns: columns.to_vec(), rows }
    }
}

impl EvidenceRow {
    pub(super) fn new(label: impl Into<String>, values: &[Option<f64>]) -> Self {
        Self { label: label.into(), values: values.to_vec() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tolerances_are_held() {
        let share = Tolerance::Share { of_calculation: 0.01, of_measurement: 0.05 };
        let figure = share.judge(Printed::both("x", "Hz", [100.0, 96.0], 101.0));
        let [calculated, measured] = [figure.calculated, figure.measured].map(|against| against.expect("printed"));
        assert!(calculated.agrees && (calculated.difference - 0.01).abs() < 1e-15, "{calculated:?}");
        assert!(!measured.agrees && (measured.difference - 5.0 / 96.0).abs() < 1e-15, "{measured:?}");
        let points = Tolerance::PercentagePoints { most: 5.0 };
        let judged = |ours| points.judge(Printed::difference("x", -6.5, ours)).quoted.expect("printed");
        assert!(judged(-2.0).agrees && !judged(-1.0).agrees);
        assert_eq!(judged(8.0).difference, 14.5);
    }
}

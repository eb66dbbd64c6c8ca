//! Models of the goal and the limits, and their predictions for a decision.

use super::error::BestError;
use super::robust::{Bounded, Predicted, expected, expected_error, held, quantile};
use super::space::{Decision, Space};
use crate::refinement::{Side, places};
use crate::surrogate::{Derived, Model, OutputModel, OutputSurrogate, SurrogateSettings, fit_derived};
use decore_dataset::{DatasetReader, TableName};
use decore_math::special::normal_quantile;
use decore_statistics::regression::{GaussianProcess, Points};
use decore_study::expression::{Expression, Outcome, Scope};
use decore_study::{Goal, Limit};

/// Standard deviations that an interval of 95 % reaches where a model's errors are as large as it expects.
const CALIBRATED: f64 = 1.959_963_984_540_054;

/// A value of the goal or a limit.
pub(super) struct Wanted {
    /// As written.
    pub text: String,
    /// Unit; empty if there is none.
    pub unit: String,
    columns: Vec<String>,
    /// Left side minus right side, where the right side names columns too.
    sides: (Expression, Option<Expression>),
    /// Whether it must be large or small.
    pub side: Side,
    /// The limit; `None` for the goal.
    pub bound: Option<f64>,
}

impl Wanted {
    pub fn of(goal: &Goal) -> Vec<Self> {
        let side = if goal.maximise { Side::Most } else { Side::Least };
        let value = Self {
            text: goal.text.clone(),
            unit: String::new(),
            columns: names(&[&goal.value]),
            sides: (goal.value.clone(), None),
            side,
            bound: None,
        };
        [value].into_iter().chain(goal.limits.iter().map(Self::limit)).collect()
    }

    fn limit(Limit { text, left, at_most, right }: &Limit) -> Self {
        // A number on the left is a limit of the expression on the right.
        let (left, at_most, right) = match left.names().is_empty() {
            true => (right, !at_most, left),
            false => (left, *at_most, right),
        };
        let side = if at_most { Side::Least } else { Side::Most };
        let number = right.names().is_empty().then(|| evaluate(right, &[], &[])).filter(|number| number.is_finite());
        let (name, columns) = match left.single_name().filter(|_| number.is_some()) {
            Some(name) => (name.to_owned(), vec![name.to_owned()]),
            None => (text.clone(), names(&[left, right])),
        };
        let other = number.is_none().then(|| right.clone());
        Self {
            text: name,
            unit: String::new(),
            columns,
            sides: (left.clone(), other),
            side,
            bound: Some(number.unwrap_or(0.0)),
        }
    }

    /// Value of a row from its columns; NaN if it has none.
    pub fn value(&self, values: &[f64]) -> f64 {
        let of = |side: &Expression| evaluate(side, &self.columns, values);
        of(&self.sides.0) - self.sides.1.as_ref().map_or(0.0, of)
    }

    /// Whether a value is within the limit; NaN is not.
    pub fn holds(&self, value: f64) -> bool {
        match (self.side, self.bound) {
            (_, None) => !value.is_nan(),
            (Side::Least, Some(bound)) => value <= bound,
            (Side::Most, Some(bound)) => value >= bound,
        }
    }

    /// Columns that it is computed from.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }
}

fn names(of: &[&Expression]) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for name in of.iter().flat_map(|one| one.names()) {
        if !all.iter().any(|known| known == name) {
            all.push(name.to_owned());
        }
    }
    all
}

struct Row<'a>(&'a [String], &'a [f64]);

impl Scope for Row<'_> {
    fn value(&self, name: &str) -> Result<Outcome, String> {
        let value = self.0.iter().zip(self.1).find(|(known, _)| *known == name).map(|(_, value)| *value);
        value.filter(|value| value.is_finite()).map(Outcome::Number).ok_or_else(|| format!("`{name}` has no value"))
    }

    fn call(&self, function: &str, _: &[&str]) -> Result<f64, String> {
        Err(format!("there is no function `{function}`"))
    }
}

fn evaluate(expression: &Expression, names: &[String], values: &[f64]) -> f64 {
    match expression.evaluate(&Row(names, values)) {
        Ok(Outcome::Number(number)) => number,
        _ => f64::NAN,
    }
}

/// Predictions of the models for a decision.
#[derive(Debug, Clone)]
pub(super) struct Expected {
    pub decision: Decision,
    /// Probability of each node that its row has all values.
    pub success: Vec<f64>,
    /// The goal, then each limit, at each node.
    pub at: Vec<Vec<Predicted>>,
}

impl Expected {
    pub fn goal(&self) -> f64 {
        expected(&self.at[0])
    }

    pub fn goal_error(&self) -> f64 {
        expected_error(&self.at[0])
    }

    /// Share of runs that hold these limits.
    pub fn held(&self, wanted: &[Wanted], bounds: &[f64], caution: f64) -> f64 {
        let limits: Vec<Bounded<'_>> = (wanted.iter().zip(&self.at).skip(1).zip(bounds))
            .map(|((wanted, at), value)| Bounded { at, side: wanted.side, value: *value })
            .collect();
        held(&limits, &self.success, caution)
    }

    /// Largest violation of a limit by the expected values, as a share of the limit; 0 if they are within all limits.
    pub fn lack(&self, wanted: &[Wanted], bounds: &[f64]) -> f64 {
        let of = |((wanted, at), bound): ((&Wanted, &Vec<Predicted>), &f64)| {
            let over = match wanted.side {
                Side::Least => expected(at) - bound,
                Side::Most => bound - expected(at),
            };
            over / bound.abs().max(f64::MIN_POSITIVE)
        };
        wanted.iter().zip(&self.at).skip(1).zip(bounds).map(of).fold(0.0, f64::max)
    }

    /// The value that a share of runs hold, of a limit by its place among all values.
    pub fn quantile(&self, place: usize, side: Side, share: (f64, f64)) -> f64 {
        quantile(&self.at[place], side, share)
    }
}

/// Models of a goal's values.
pub(super) struct Models {
    pub wanted: Vec<Wanted>,
    pub model: Model,
    /// For each value its place among the model's outputs.
    of: Vec<usize>,
    /// Share of runs that must hold the limits.
    pub confidence: f64,
}

impl Models {
    /// Fits the models to the rows of a dataset and of others with the same factors.
    ///
    /// # Errors
    /// [`BestError::NoModel`] for a value that rows do not tell.
    pub fn fit(goal: &Goal, reader: &DatasetReader, others: &[&DatasetReader]) -> Result<Self, BestError> {
        let mut wanted = Wanted::of(goal);
        let unit = |name: &str| reader.column(TableName::Runs, name).ok().map(|column| column.unit.clone());
        for one in &mut wanted {
            one.unit = one.sides.0.unit(&unit).ok().flatten().filter(|unit| unit != "1").unwrap_or_default();
        }
        let mut names: Vec<&str> = Vec::new();
        let of = wanted.iter().map(|one| {
            let known = names.iter().position(|name| *name == one.text);
            known.unwrap_or_else(|| {
                names.push(&one.text);
                names.len() - 1
            })
        });
        let of: Vec<usize> = of.collect();
        let first = |place: usize| of.iter().position(|own| *own == place).map(|own| &wanted[own]);
        let wanted_once: Vec<&Wanted> = (0..names.len()).filter_map(first).collect();
        type Getter<'a> = Box<dyn Fn(&[f64]) -> f64 + Sync + 'a>;
        let values: Vec<Getter<'_>> =
            wanted_once.iter().map(|one| Box::new(|values: &[f64]| one.value(values)) as _).collect();
        let derived: Vec<Derived<'_>> = (wanted_once.iter().zip(&values))
            .map(|(one, value)| Derived {
                name: one.text.clone(),
                unit: one.unit.clone(),
                columns: one.columns.clone(),
                value: value.as_ref(),
            })
            .collect();
        let model = fit_derived(reader, others, (&derived, &SurrogateSettings::default()))?;
        for (figures, of) in model.surrogate.outputs.iter().zip(&model.outputs) {
            if of.process.is_none() && of.constant.is_none() {
                return Err(BestError::NoModel { text: figures.output.clone(), reason: no_model(figures) });
            }
        }
        drop(derived);
        drop(values);
        Ok(Self { of, model, confidence: goal.confidence, wanted })
    }

    /// Limits as the goal states them.
    pub fn bounds(&self) -> Vec<f64> {
        self.wanted.iter().skip(1).filter_map(|one| one.bound).collect()
    }

    /// Standard deviations by which a model is taken to err where limits must hold.
    pub fn caution(&self) -> f64 {
        normal_quantile(self.confidence)
    }

    /// Sign by which large values of the goal are better.
    pub fn sign(&self) -> f64 {
        if self.wanted[0].side == Side::Most { 1.0 } else { -1.0 }
    }

    pub fn output(&self, place: usize) -> (&OutputSurrogate, &OutputModel) {
        (&self.model.surrogate.outputs[self.of[place]], &self.model.outputs[self.of[place]])
    }

    /// Place of a value's model among the outputs.
    pub fn output_place(&self, place: usize) -> usize {
        self.of[place]
    }

    pub fn process(&self, place: usize) -> Option<&GaussianProcess> {
        self.output(place).1.process.as_ref().map(|of| &of.process)
    }

    /// Places of the models at all nodes, one decision after the other.
    pub fn points(&self, space: &Space<'_>, decisions: &[Decision]) -> Result<Points, BestError> {
        let rows: Vec<Vec<String>> = (decisions.iter())
            .flat_map(|decision| space.nodes.iter().map(|node| space.cells(&space.levels(decision, node))))
            .collect();
        Ok(places(space.study, &self.model.surrogate.factors, &rows)?)
    }

    /// Places of decisions with the uncertain factors of the first node.
    pub fn places(&self, space: &Space<'_>, decisions: &[Decision]) -> Result<Points, BestError> {
        let row = |decision: &Decision| space.cells(&space.levels(decision, &space.nodes[0]));
        let rows: Vec<Vec<String>> = decisions.iter().map(row).collect();
        Ok(places(space.study, &self.model.surrogate.factors, &rows)?)
    }

    /// Probability of each place that a row there has all values.
    pub fn success(&self, points: &Points) -> Result<Vec<f64>, BestError> {
        let mut success = vec![1.0; points.rows()];
        for (figures, of) in self.model.surrogate.outputs.iter().zip(&self.model.outputs) {
            let Some(own) = of.success_of(figures) else { continue };
            for (least, own) in success.iter_mut().zip(own.predict(points)?) {
                *least = f64::min(*least, own);
            }
        }
        Ok(success)
    }

    /// Predicts decisions.
    pub fn expected(&self, space: &Space<'_>, decisions: &[Decision]) -> Result<Vec<Expected>, BestError> {
        let points = self.points(space, decisions)?;
        let success = self.success(&points)?;
        let mut outputs: Vec<Vec<Predicted>> = Vec::new();
        for (figures, of) in self.model.surrogate.outputs.iter().zip(&self.model.outputs) {
            outputs.push(match (&of.process, &figures.process) {
                (Some(process), Some(fitted)) => {
                    let scatter = process.process.noise_std_dev();
                    let scale = fitted.reach / CALIBRATED;
                    let predicted = process.process.predict(&points)?.into_iter().map(|at| Predicted {
                        mean: at.mean,
                        model: scale * (at.std_dev * at.std_dev - scatter * scatter).max(0.0).sqrt(),
                        scatter,
                    });
                    predicted.collect()
                }
                _ => vec![Predicted { mean: of.constant.unwrap_or(f64::NAN), model: 0.0, scatter: 0.0 }; points.rows()],
            });
        }
        let nodes = space.nodes.len();
        let expected = |(place, decision): (usize, &Decision)| {
            let own = place * nodes..(place + 1) * nodes;
            Expected {
                decision: decision.clone(),
                success: success[own.clone()].to_vec(),
                at: self.of.iter().map(|of| outputs[*of][own.clone()].to_vec()).collect(),
            }
        };
        Ok(decisions.iter().enumerate().map(expected).collect())
    }
}

/// Returns the reason, in words, why an output has no model.
fn no_model(figures: &OutputSurrogate) -> String {
    let left_out: u64 = figures.left_out.iter().map(|left_out| left_out.count).sum();
    match (figures.used, figures.left_out.first()) {
        (0, Some(first)) => {
            format!(
                "none of {left_out} rows has it ({}); limit another output, or change the outputs of the study",
                first.reason
            )
        }
        (used, Some(first)) => {
            format!("only {used} of {} rows have it ({}); run more rows", used + left_out, first.reason)
        }
        (_, None) => figures.refused.clone().unwrap_or_default(),
    }
}

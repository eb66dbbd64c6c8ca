//! Constraints of a design: conditions on factors, parameters and geometry in every row.

use std::cell::OnceCell;

use super::document::error::{Problem, StudyError};
use super::document::path;
use super::document::tree::TextSpan;
use super::loaded::Study;
use super::plan::design::{Constraint, DesignPlan, design_problem};
use super::plan::factor::{FactorInfo, FactorSource, Factors};
use super::resolve::issue::Issue;
use super::resolve::placement::PointTable;
use crate::expression::{Outcome, Role, Scope, Word};
use decore_model::scene::{HammerUnit, Scene};
use decore_quantity::Value;
use decore_quantity::words::nearest;
use decore_statistics::design::{Constraints, Design, DesignError, Level};

/// The design of a study with its rows chosen by its constraints; `points`: the machine's interface points, for constraints on
/// geometry.
pub(super) fn constrained(study: &Study, points: &PointTable) -> Result<Design, StudyError> {
    let plan = &study.plan;
    if plan.constraints.is_empty() {
        return Ok(plan.design.clone());
    }
    let order = plan.cheapest_first();
    let factors = order.iter().map(|index| plan.looked_at(*index)).collect();
    let mut met = |levels: &[Level], among: &[usize]| {
        let named: Vec<usize> = among.iter().filter_map(|place| order.get(*place)).copied().collect();
        met(study, (levels, points), &named)
    };
    let design = plan.design.constrained(Constraints { factors, met: &mut met });
    design.map_err(|error| StudyError::one(design_problem(&study.typed, &error, &plan.factors)))
}

/// Whether all constraints hold where the drawn factors have these levels.
pub(super) fn meets(study: &Study, points: &PointTable, levels: &[Level]) -> Result<bool, StudyError> {
    let plan = &study.plan;
    let met = met(study, (levels, points), &plan.cheapest_first());
    let met = met.map_err(DesignError::Constraint);
    let met = met.map_err(|error| StudyError::one(design_problem(&study.typed, &error, &plan.factors)))?;
    Ok(met == plan.constraints.len() && plan.values(levels).1.is_none())
}

/// Counts how many of these constraints hold in a row, up to the first that does not.
fn met(study: &Study, (levels, points): (&[Level], &PointTable), among: &[usize]) -> Result<usize, String> {
    let (values, fault) = study.plan.values(levels);
    // A derived factor without a value is not a row.
    if fault.is_some() {
        return Ok(0);
    }
    let row = RowScope { study, values: &values, points, scene: OnceCell::new() };
    let constraints = among.iter().filter_map(|index| study.plan.constraints.get(*index));
    for (met, Constraint { text, expression }) in constraints.enumerate() {
        let value = expression.evaluate(&row);
        if row.misses() {
            return Ok(met);
        }
        match value {
            Ok(Outcome::Truth(true)) => {}
            Ok(Outcome::Truth(false)) => return Ok(met),
            Ok(other) => return Err(format!("`{text}`: expected a comparison, found {other}")),
            Err(message) => return Err(format!("`{text}`: {message}")),
        }
    }
    Ok(among.len())
}

/// Functions of hammers that constraints can call.
const FUNCTIONS: [&str; 8] =
    ["mount_x", "mount_y", "mount_z", "strike_x", "strike_y", "strike_margin", "air_flow", "distance"];

/// Names in constraints that nothing has, each with its own place and the nearest name.
pub(super) fn unknown_names(study: &Study) -> Vec<Problem> {
    let mut problems = Vec::new();
    for (index, Constraint { text, expression }) in study.plan.constraints.iter().enumerate() {
        let at = ["design", "constraints", &index.to_string()].map(str::to_string);
        for word in expression.words() {
            let Some(Unknown { message, nearest }) = unknown(study, word) else { continue };
            let place = study.typed.locate_part(&at, text, &TextSpan { text: &word.text, column: word.column });
            problems.push(Problem::new(place, path::join(&at), message).nearest(nearest));
        }
    }
    problems
}

/// A name that nothing has.
struct Unknown {
    message: String,
    nearest: Option<String>,
}

fn unknown(study: &Study, word: &Word) -> Option<Unknown> {
    let name = word.text.as_str();
    let listed = |known: Vec<&str>, what: &str| {
        let message = format!("there is no {what} `{name}`; there is: {}", known.join(", "));
        (!known.contains(&name)).then(|| Unknown { message, nearest: nearest(name, known) })
    };
    match word.role {
        Role::Text => None,
        Role::Function => listed(FUNCTIONS.to_vec(), "function"),
        Role::Argument => listed(study.hammer_names(), "hammer"),
        Role::Value => {
            let at = path::split(name).unwrap_or_default();
            let factors = || study.factors().iter().map(|factor| factor.name.as_str());
            let driven = || study.factors().iter().flat_map(FactorInfo::paths);
            let given = path::get(&study.scenes.template, &at).is_some() || driven().any(|path| path == name);
            if given || factors().any(|factor| factor == name) {
                return None;
            }
            let (driven, mut leaves) = (driven().collect::<Vec<_>>(), Vec::new());
            path::leaves(&study.scenes.template, &mut Vec::new(), &mut leaves);
            let known = factors().chain(driven.iter().chain(&leaves).map(String::as_str));
            let message = format!("`{name}` is neither a factor nor a value of the study");
            Some(Unknown { message, nearest: nearest(name, known) })
        }
    }
}

impl DesignPlan {
    /// The constraints, those that ask for geometry last: they cost more.
    fn cheapest_first(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.constraints.len()).collect();
        order.sort_by_key(|index| self.constraints[*index].expression.calls_scope());
        order
    }

    /// Drawn factors that a constraint uses; all of them if it uses geometry. A row needs the values of all derived factors, so their
    /// inputs count too.
    fn looked_at(&self, constraint: usize) -> Vec<usize> {
        let expression = &self.constraints[constraint].expression;
        if expression.calls_scope() {
            return (0..self.design.factors().len()).collect();
        }
        let named = expression.names().into_iter().filter_map(|name| {
            let at = path::split(name).unwrap_or_default();
            let factor = self.factors.iter().find(|factor| factor.name == name);
            factor.or_else(|| self.driver(|path| path == at))
        });
        let derived = self.factors.iter().filter(|factor| matches!(factor.source, FactorSource::Derived { .. }));
        let mut used: Vec<usize> = named.chain(derived).flat_map(|factor| self.drawn_for(factor)).collect();
        used.sort_unstable();
        used.dedup();
        used
    }

    /// The drawn factors, by their index in the design, that give a factor its value.
    fn drawn_for(&self, factor: &FactorInfo) -> Vec<usize> {
        match &factor.source {
            FactorSource::Drawn { index, .. } => vec![*index],
            // It names factors before it only.
            FactorSource::Derived { expression, .. } => {
                let names = expression.names();
                let before = self.factors.iter().filter(|other| names.contains(&other.name.as_str()));
                before.flat_map(|other| self.drawn_for(other)).collect()
            }
        }
    }
}

/// Values of a row for an expression.
struct RowScope<'a> {
    study: &'a Study,
    values: &'a [Value],
    points: &'a PointTable,
    /// Worked out when first asked for.
    scene: OnceCell<Result<Scene, Vec<Issue>>>,
}

impl Scope for RowScope<'_> {
    fn value(&self, name: &str) -> Result<Outcome, String> {
        let factors = Factors { names: &self.study.plan.factors, values: self.values };
        if let Some(value) = factors.get(name) {
            return Ok(value);
        }
        let at = path::split(name)?;
        let plan = &self.study.plan;
        if let Some((_, value)) = plan.driven(self.values).into_iter().find(|(path, _)| *path == at) {
            return as_value(&value, name);
        }
        let value = path::get(&self.study.scenes.template, &at);
        let value = value.ok_or_else(|| format!("`{name}` is neither a factor nor a value of the study"))?;
        as_value(value, name)
    }

    fn call(&self, function: &str, arguments: &[&str]) -> Result<f64, String> {
        let hammers = arguments.iter().map(|name| self.hammer(name)).collect::<Result<Vec<&HammerUnit>, String>>()?;
        match (function, hammers.as_slice()) {
            ("mount_x", [hammer]) => Ok(self.mount(hammer)[0]),
            ("mount_y", [hammer]) => Ok(self.mount(hammer)[1]),
            ("mount_z", [hammer]) => Ok(self.mount(hammer)[2]),
            ("distance", [a, b]) => {
                let (a, b) = (self.mount(a), self.mount(b));
                Ok(a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt())
            }
            ("strike_x", [hammer]) => Ok(hammer.strike_point_m[0]),
            ("strike_y", [hammer]) => Ok(hammer.strike_point_m[1]),
            ("strike_margin", [hammer]) => self.margin(hammer),
            ("air_flow", [hammer]) => Ok(hammer.largest_air_flow_kg_s(&self.scene()?.environment)),
            _ => Err(format!(
                "`{function}` takes no {} hammers: `distance` takes two, the others ({}) one",
                arguments.len(),
                FUNCTIONS[..7].join(", ")
            )),
        }
    }
}

impl RowScope<'_> {
    /// Whether the row was found to describe no scene, by its own values only.
    fn misses(&self) -> bool {
        matches!(self.scene.get(), Some(Err(issues)) if issues.iter().all(|issue| issue.row_only))
    }

    fn scene(&self) -> Result<&Scene, String> {
        let scene = self.scene.get_or_init(|| self.study.scene_of(self.values, self.points));
        scene.as_ref().map_err(|issues| {
            let words = issues.iter().map(|issue| format!("`{}`: {}", issue.path, issue.message));
            words.collect::<Vec<_>>().join("; ")
        })
    }

    fn hammer(&self, name: &str) -> Result<&HammerUnit, String> {
        let hammers = &self.scene()?.hammers;
        let known = || hammers.iter().map(|hammer| hammer.name.as_str()).collect::<Vec<_>>().join(", ");
        let hammer = hammers.iter().find(|hammer| hammer.name == name);
        hammer.ok_or_else(|| format!("there is no hammer `{name}`; the study has: {}", known()))
    }

    /// Position of a hammer's mount in m.
    fn mount(&self, hammer: &HammerUnit) -> [f64; 3] {
        // A scene names points of the table only.
        hammer.mount.position_m(|point| self.points.position(point)).unwrap_or_default()
    }

    /// How far within the casting's extent the hammer's axis passes, seen from above, in m; negative outside.
    fn margin(&self, hammer: &HammerUnit) -> Result<f64, String> {
        let casting = self.scene()?.castings.get(hammer.casting);
        let margin = casting.and_then(|casting| casting.margin_m(hammer.strike_point_m, hammer.axis()));
        margin.ok_or_else(|| format!("the casting of hammer `{}` has no `size_m`", hammer.name))
    }
}

fn as_value(value: &toml::Value, name: &str) -> Result<Outcome, String> {
    match value {
        toml::Value::Float(number) => Ok(Outcome::Number(*number)),
        toml::Value::Integer(number) => Ok(Outcome::Number(*number as f64)),
        toml::Value::Boolean(truth) => Ok(Outcome::Truth(*truth)),
        toml::Value::String(text) => Ok(Outcome::Text(text.clone())),
        _ => Err(format!("`{name}` is no single value")),
    }
}

//! A study checked against its machine: all names known, constraints applied, rows final.

use super::constraints::{constrained, meets, unknown_names};
use super::demand::check_names;
use super::document::error::{InvalidRow, Problem, StudyError};
use super::document::path;
use super::document::read::read_tree;
use super::growth::{budget_free_hash, frame_hash};
use super::loaded::Study;
use super::plan::factor::{FactorInfo, FactorSource};
use super::resolve::issue::Issue;
use super::resolve::nodes::single_nodes;
use super::resolve::placement::PointTable;
use decore_model::parameter::Fault;
use decore_model::scene::{Method, Scene};
use decore_quantity::{Kind, Value};
use decore_statistics::design::{Acceptance, Design, Level};

/// Rows to compare in designs that compute each row alone: rows of one kind and seed do not start to differ later.
const COMPARED_ROWS: usize = 1 << 17;

/// A study with the interface points of its machine: it has rows.
///
/// The rows of a [`Study`] are known only here, because constraints may ask where points are.
#[derive(Debug, Clone)]
pub struct CheckedStudy {
    study: Study,
    points: PointTable,
    design: Design,
    warnings: Vec<Problem>,
    /// For each factor the value that it has in every row, where overrides give it one.
    overridden: Vec<Option<Value>>,
}

impl CheckedStudy {
    /// Checks a study against the machine's interface points, before any row is run: every name that a row can use, the values
    /// of the first row, and each factor at its ends (or each of its values) with the others as in the first row. Then the
    /// constraints of the design choose its rows.
    ///
    /// Hammers that miss their casting are no fault here: such rows end as invalid, and meet no constraint that asks for
    /// geometry.
    ///
    /// # Errors
    /// [`StudyError::Invalid`] with all faults found; if a constraint cannot be evaluated, or too few rows are left.
    pub fn new(study: Study, points: PointTable) -> Result<Self, StudyError> {
        let Findings { faults, warnings } = look_at(&study, &points);
        StudyError::from_problems(faults)?;
        let design = constrained(&study, &points)?;
        let overridden = study.factors().iter().map(|factor| overridden(&study, factor)).collect();
        Ok(Self { study, points, design, warnings, overridden })
    }

    /// Possible but unlikely values, for instance a pressure in another unit: in the first row, and at the ends of each factor.
    pub fn warnings(&self) -> &[Problem] {
        &self.warnings
    }

    /// The study.
    pub fn study(&self) -> &Study {
        &self.study
    }

    /// The interface points of its machine.
    pub fn points(&self) -> &PointTable {
        &self.points
    }

    /// The design, its constraints applied.
    pub fn design(&self) -> &Design {
        &self.design
    }

    /// Number of rows.
    pub fn row_count(&self) -> usize {
        self.design.row_count()
    }

    /// Number of points that met the constraints; `None` if none were left out.
    pub fn acceptance(&self) -> Option<Acceptance> {
        self.design.acceptance()
    }

    /// Values of the factors in a row, in the order of [`Study::factors`]; empty past the last row.
    ///
    /// A factor all of whose paths are overridden has the override's value.
    pub fn row_values(&self, row: usize) -> Vec<Value> {
        self.design.row(row).map_or(Vec::new(), |levels| self.values_at(&levels))
    }

    /// Values of the factors, derived ones included, where those that the design draws have these levels: as
    /// [`CheckedStudy::row_values`].
    pub fn values_at(&self, levels: &[Level]) -> Vec<Value> {
        let (mut values, _) = self.study.plan.values(levels);
        for (value, overridden) in values.iter_mut().zip(&self.overridden) {
            if let Some(overridden) = overridden {
                value.clone_from(overridden);
            }
        }
        values
    }

    /// Whether all constraints hold where the drawn factors have these levels.
    ///
    /// # Errors
    /// A constraint that cannot be evaluated.
    pub fn meets(&self, levels: &[Level]) -> Result<bool, StudyError> {
        meets(&self.study, &self.points, levels)
    }

    /// The scene of a row.
    ///
    /// Pure: touches no file, depends on no other row.
    ///
    /// # Errors
    /// [`InvalidRow`] if the row's values describe no scene that can be simulated, e.g. a hammer beside its casting, and
    /// for rows past the last one.
    pub fn scene(&self, row: usize) -> Result<Scene, InvalidRow> {
        let levels = self.design.row(row).ok_or_else(|| InvalidRow {
            reason: format!("row {row} does not exist: the study has the rows 0 to {}", self.row_count() - 1),
        })?;
        self.scene_at(&levels)
    }

    /// Scene for these levels of the drawn factors, see [`CheckedStudy::levels`], as [`CheckedStudy::scene`] for a row's levels. Ranges and
    /// constraints of the design are not checked.
    ///
    /// # Errors
    /// As for [`CheckedStudy::scene`].
    pub fn scene_at(&self, levels: &[Level]) -> Result<Scene, InvalidRow> {
        let (values, fault) = self.study.plan.values(levels);
        if let Some(reason) = fault {
            return Err(InvalidRow { reason });
        }
        self.study.scene_of(&values, &self.points).map_err(|issues| {
            let words = issues.iter().map(|issue| match &issue.nearest {
                Some(nearest) => format!("`{}`: {} (did you mean `{nearest}`?)", issue.path, issue.message),
                None => format!("`{}`: {}", issue.path, issue.message),
            });
            InvalidRow { reason: words.collect::<Vec<_>>().join("; ") }
        })
    }

    /// Hash (hex) as [`Study::hash`], but over all that is not the number of rows: a study of the same frame and the same
    /// first rows, see [`CheckedStudy::rows_hash`], is this one with rows added or taken away.
    ///
    /// Left out are `rows`, `grown_from`, `trajectories` and `base_points` of the design and its parts, and the contents of a
    /// table of rows.
    pub fn frame_hash(&self) -> String {
        frame_hash(&self.study)
    }

    /// Hash (hex) as [`Study::hash`], but over all that is not a budget: `solver.max_steps` and `solver.max_wall_time_s`. Rows
    /// that met no budget are the same in studies that have this one in common.
    pub fn budget_free_hash(&self) -> String {
        budget_free_hash(&self.study)
    }

    /// Hash (hex) of the factors' values in the first `rows` rows, by which two studies of one frame are compared.
    ///
    /// Only the first 131072 rows count where every row is computed alone, see [`Design::is_open`].
    pub fn rows_hash(&self, rows: usize) -> String {
        let compared = if self.design.is_open() { rows.min(COMPARED_ROWS) } else { rows };
        let mut hasher = blake3::Hasher::new();
        for row in 0..compared.min(self.row_count()) {
            for value in self.row_values(row) {
                match value {
                    Value::Real(value) => hasher.update(&value.to_bits().to_le_bytes()),
                    Value::Integer(value) => hasher.update(&value.to_le_bytes()),
                    Value::Count(value) => hasher.update(&value.to_le_bytes()),
                    Value::Text(text) => {
                        hasher.update(&(text.len() as u64).to_le_bytes());
                        hasher.update(text.as_bytes())
                    }
                };
            }
        }
        hasher.finalize().to_hex().to_string()
    }
}

/// The value that a factor has in every row because overrides give all its paths one; the first path's.
fn overridden(study: &Study, factor: &FactorInfo) -> Option<Value> {
    let values: Option<Vec<Value>> = factor.drives.iter().map(|driven| study.overridden(&driven.path)).collect();
    match values?.into_iter().next()? {
        Value::Integer(whole) if factor.kind == Kind::Real => Some(Value::Real(whole as f64)),
        value => Some(value),
    }
}

/// Findings in some rows of a study.
struct Findings {
    faults: Vec<Problem>,
    warnings: Vec<Problem>,
}

/// Finds errors and doubtful values of a study on a machine with these points. Rows share their faults: one report per place and key.
fn look_at(study: &Study, points: &PointTable) -> Findings {
    let mut findings = Findings { faults: check_names(study, points), warnings: Vec::new() };
    findings.faults.extend(unknown_names(study));
    findings.warnings.extend(without_effect(study));
    let first = study.plan.design.row(0).unwrap_or_default();
    findings.look_at_row(study, points, &Looked { levels: &first, factor: None });
    for factor in study.factors() {
        let FactorSource::Drawn { index, .. } = factor.source else { continue };
        for extreme in factor.extremes() {
            let mut levels = first.clone();
            if let Some(level) = levels.get_mut(index) {
                *level = extreme;
            }
            findings.look_at_row(study, points, &Looked { levels: &levels, factor: Some(factor) });
        }
    }
    for problems in [&mut findings.faults, &mut findings.warnings] {
        let mut seen = std::collections::BTreeSet::new();
        problems.retain(|problem| {
            let place = &problem.place;
            seen.insert((place.file.clone(), place.line, place.column, problem.key.clone()))
        });
    }
    findings
}

/// Keys of the solver that are given and that no method which some row has makes use of. A method may be set over the study, or
/// differ between rows: they are no faults.
fn without_effect(study: &Study) -> Vec<Problem> {
    let solver = &study.file.solver;
    let named = study.candidates(&["solver", "method"].map(str::to_string)).into_iter();
    let methods: Vec<Method> = named.filter_map(|one| read_tree(toml::Value::String(one.value)).ok()).collect();
    let methods = if methods.is_empty() { vec![Method::default()] } else { methods };
    let words = methods.iter().map(|method| format!("`{}`", method.name())).collect::<Vec<_>>().join(" and ");
    let mut idle = Vec::new();
    let mut look = |key: &str, given: bool, of_fixed_steps: bool| {
        if !given || methods.iter().any(|method| method.is_fixed() == of_fixed_steps) {
            return;
        }
        let (needs, instead) = match of_fixed_steps {
            true => ("a method with a fixed step", "tolerance"),
            false => ("a method under error control", "step_s"),
        };
        let message =
            format!("has no effect with {words}: it needs {needs} (`solver.method`); here `solver.{instead}` counts");
        idle.push(study.problem(Issue::new(format!("solver.{key}"), message)));
    };
    look("tolerance", solver.tolerance.is_some(), false);
    look("step_s", solver.step_s.is_some(), true);
    look("located", solver.located.is_some(), true);
    idle
}

/// A row that is looked at.
struct Looked<'a> {
    levels: &'a [Level],
    /// The factor that is at one of its ends, all others being as in the first row.
    factor: Option<&'a FactorInfo>,
}

impl Looked<'_> {
    /// Whether a value comes from a factor that is not at one of its ends here: nobody typed such a value.
    fn is_between(&self, study: &Study, at: &[String]) -> bool {
        let driver = study.plan.driver(|path| path.starts_with(at) || at.starts_with(path));
        let drawn = driver.filter(|factor| factor.distribution().is_some());
        drawn.is_some_and(|driver| self.factor.is_none_or(|own| own.name != driver.name))
    }
}

impl Findings {
    fn look_at_row(&mut self, study: &Study, points: &PointTable, looked: &Looked<'_>) {
        let (values, fault) = study.plan.values(looked.levels);
        if let Some(message) = fault {
            self.faults.push(study.problem(Issue::new("design.factor".to_string(), message)));
            return;
        }
        match study.scene_of(&values, points) {
            Ok(scene) => {
                let typed = |path: &str| path::split(path).is_ok_and(|at| !looked.is_between(study, &at));
                let remarks = scene.remarks().into_iter().filter(|remark| typed(&remark.path));
                self.warnings.extend(remarks.map(|Fault { path, message }| study.problem(Issue::new(path, message))));
                self.warnings.extend(single_nodes(&scene, points).into_iter().map(|issue| study.problem(issue)));
            }
            Err(issues) => {
                let issues = issues.into_iter().filter(|issue| !issue.row_only);
                self.faults.extend(issues.map(|issue| study.problem(issue)));
            }
        }
    }
}

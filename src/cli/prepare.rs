//! What every command needs first: the study, checked against its machine, and the machine, reduced.

use std::collections::BTreeMap;
use std::path::Path;

use super::exit::Failure;
use super::inputs::input_hashes;
use crate::dataset::{DatasetInfo, Factor, RowRecord, rows_per_part};
use crate::design::Quality;
use crate::quantity::Kind;
use crate::run::{DEFAULT_RETRIES, Machine, RowOutcome, SourceModel, run_row_with_retries};
use crate::scene::Scene;
use crate::study::{FactorInfo, InterfaceDemand, PointTable, Study};
use crate::system::InterfaceModes;

/// Distance in m within which two points are the same.
const SAME_PLACE_M: f64 = 1e-6;

/// A study ready to run.
pub(super) struct Prepared {
    pub study: Study,
    pub points: PointTable,
    machine: Machine,
    /// The study's further machines.
    further: Vec<Machine>,
    /// Times a row that diverges is run again.
    pub retries: u32,
    inputs: BTreeMap<String, String>,
}

/// Loads a study with the overrides `path=value`.
pub(super) fn load(path: &Path, overrides: &[String]) -> Result<Study, Failure> {
    let study = Study::load(path)?;
    Ok(if overrides.is_empty() { study } else { study.with_overrides(overrides)? })
}

/// Loads a study with the overrides `path=value`, checks it, reads and reduces its machine.
pub(super) fn prepare(path: &Path, overrides: &[String]) -> Result<Prepared, Failure> {
    let study = load(path, overrides)?;
    let mut inputs = input_hashes("structure", &study.structure().source)?;
    let model = SourceModel::read(study.structure())?;
    let points = model.points();
    study.check(&points)?;
    let study = study.constrained(&points)?;
    let demand = study.interface_demand();
    let machine = Machine::new(model, study.structure(), &demand)?;
    let mut further = Vec::new();
    for (name, settings) in study.structures() {
        let table = format!("structures.{name}");
        inputs.extend(input_hashes(&table, &settings.source)?);
        let model = SourceModel::read(settings)?;
        same_points(&table, &demand, [&points, &model.points()])?;
        further.push(Machine::new(model, settings, &demand)?);
    }
    Ok(Prepared { study, points, machine, further, retries: DEFAULT_RETRIES, inputs })
}

/// Strikes follow from where points are: the machines of a study have those that it uses at the same places.
fn same_points(table: &str, demand: &InterfaceDemand, [first, other]: [&PointTable; 2]) -> Result<(), Failure> {
    for name in demand.mounts.iter().chain(&demand.fixtures) {
        let (Some(expected), Some(found)) = (first.position(name), other.position(name)) else {
            return Err(Failure::Argument(format!("[{table}] has no interface point `{name}`, which the study uses")));
        };
        let apart = expected.iter().zip(found).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        if apart > SAME_PLACE_M {
            return Err(Failure::Argument(format!(
                "interface point `{name}` of [{table}] is at {found:?}, that of [structure] at {expected:?}: the machines of \
                 a study have the points that it uses at the same places"
            )));
        }
    }
    Ok(())
}

impl Prepared {
    /// A row asked for on the command line must be one of the study's.
    pub fn check_row(&self, row: usize) -> Result<(), Failure> {
        let last = self.study.row_count() - 1;
        if row <= last {
            return Ok(());
        }
        Err(Failure::Argument(format!("--row is {row}, but the study has the rows 0 to {last}")))
    }

    /// The scene of a row and the machine's modes for it; the reason if the row describes none.
    pub fn scene(&self, row: usize) -> Result<(Scene, InterfaceModes), String> {
        let scene = self.study.scene(row, &self.points).map_err(|invalid| invalid.reason)?;
        let modes = self.machine_of(&scene).modes(&scene).map_err(|error| error.to_string())?;
        Ok((scene, modes))
    }

    /// The machine that a scene is on.
    pub fn machine_of(&self, scene: &Scene) -> &Machine {
        scene.machine.and_then(|index| self.further.get(index)).unwrap_or(&self.machine)
    }

    /// Simulates a row. Pure: depends on the study and the row alone.
    pub fn run(&self, row: usize) -> RowOutcome {
        match self.scene(row) {
            Ok((scene, modes)) => run_row_with_retries(&scene, &modes, self.retries),
            Err(reason) => RowOutcome::invalid(reason),
        }
    }

    /// What the tables must know of the study.
    pub fn info(&self) -> DatasetInfo {
        let settings = BTreeMap::from([("retries".to_owned(), self.retries.to_string())]);
        dataset_info(&self.study, self.inputs.clone(), settings)
    }
}

/// What the tables must know of a study, the files it is computed from and the settings outside it.
pub(super) fn dataset_info(
    study: &Study,
    inputs: BTreeMap<String, String>,
    settings: BTreeMap<String, String>,
) -> DatasetInfo {
    let rows = study.row_count() as u64;
    let names = |names: Vec<&str>| names.into_iter().map(str::to_owned).collect();
    DatasetInfo {
        study_name: study.title().to_owned(),
        study_text: study.text().to_owned(),
        study_hash: study.hash().to_owned(),
        frame_hash: study.frame_hash(),
        rows_hash: study.rows_hash(study.row_count()),
        overrides: study.overrides(),
        inputs,
        settings,
        seed: study.seed(),
        program_version: env!("CARGO_PKG_VERSION").to_owned(),
        rows,
        rows_per_part: rows_per_part(rows),
        factors: study.factors().iter().map(factor).collect(),
        design_quality: design_quality(study),
        twins: study.twins() as u64,
        hammers: names(study.hammer_names()),
        castings: names(study.casting_names()),
    }
}

/// A row as the tables take it.
pub(super) fn record(study: &Study, row: u64, outcome: RowOutcome) -> RowRecord {
    RowRecord { row, factors: study.row_values(row as usize), outcome }
}

/// Measures of the design as JSON; `null` without factors.
fn design_quality(study: &Study) -> serde_json::Value {
    // Infinite measures (coinciding rows) become null, as JSON has no word for them.
    let quality = Quality::of(study.design()).and_then(|quality| serde_json::to_value(quality).ok());
    let Some(serde_json::Value::Object(mut summary)) = quality else {
        return serde_json::Value::Null;
    };
    for value in summary.values_mut().filter(|value| value.is_f64()) {
        *value = value.as_f64().map_or(serde_json::Value::Null, nine_digits);
    }
    if let Some(acceptance) = study.acceptance() {
        summary.insert("points_tried".into(), acceptance.tried.into());
        summary.insert("points_accepted".into(), acceptance.accepted.into());
    }
    summary.into()
}

/// A number of nine significant digits: more say nothing here, and these survive being read and written again.
fn nine_digits(value: f64) -> serde_json::Value {
    format!("{value:.8e}").parse::<f64>().map_or(serde_json::Value::Null, Into::into)
}

fn factor(info: &FactorInfo) -> Factor {
    let unit = if info.kind == Kind::Text { "" } else { "1" };
    Factor {
        name: info.name.clone(),
        kind: info.kind,
        unit: info.unit.clone().unwrap_or_else(|| unit.to_owned()),
        description: match (&info.expression, info.paths.is_empty()) {
            (None, _) => format!("Factor of the design; drives {}.", info.paths.join(", ")),
            (Some(expression), true) => format!("Derived: {expression}."),
            (Some(expression), false) => format!("Derived: {expression}; drives {}.", info.paths.join(", ")),
        },
    }
}

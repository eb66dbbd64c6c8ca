//! A study made ready: checked against its machines, the machines reduced.

use std::collections::BTreeMap;
use std::path::Path;

use super::error::EngineError;
use super::info::dataset_info;
use super::inputs::input_hashes;
use super::machine::{Machine, SourceModel};
use crate::dataset::DatasetInfo;
use crate::run::{DEFAULT_RETRIES, RowOutcome, run_row_with_retries};
use crate::scene::Scene;
use crate::structure::StructureError;
use crate::study::{InterfaceDemand, InvalidRow, PointTable, Study};
use crate::system::InterfaceModes;

/// Distance in m within which two points are the same.
const SAME_PLACE_M: f64 = 1e-6;

/// A study ready to run.
#[derive(Debug)]
pub struct Engine {
    study: Study,
    points: PointTable,
    machine: Machine,
    /// The study's further machines.
    further: Vec<Machine>,
    retries: u32,
    inputs: BTreeMap<String, String>,
}

/// The scene of a row and the modes of the machine that it is on.
#[derive(Debug, Clone)]
pub struct RowScene {
    /// All that the row says.
    pub scene: Scene,
    /// Modes of the machine with the scene's housings on their mounts.
    pub modes: InterfaceModes,
}

impl Engine {
    /// Loads a study with the settings `path=value` over its own and makes it ready.
    ///
    /// # Errors
    /// As for [`Study::load`], [`Study::with_overrides`] and [`Engine::new`].
    pub fn load(path: &Path, overrides: &[String]) -> Result<Self, EngineError> {
        Self::new(Study::load(path)?.with_overrides(overrides)?)
    }

    /// Checks a study against the interface points of its machines, applies its constraints, and reduces the machines to what
    /// its rows use.
    ///
    /// # Errors
    /// Faults of the study, of a machine's files or reduction; machines whose points are not at the same places.
    pub fn new(study: Study) -> Result<Self, EngineError> {
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
        Ok(Self { study, points, machine, further, retries: DEFAULT_RETRIES, inputs })
    }

    /// With another number of times that a row that diverges is run again; default [`DEFAULT_RETRIES`].
    pub fn with_retries(self, retries: u32) -> Self {
        Self { retries, ..self }
    }

    /// Times that a row that diverges is run again.
    pub fn retries(&self) -> u32 {
        self.retries
    }

    /// The study.
    pub fn study(&self) -> &Study {
        &self.study
    }

    /// The scene of a row and the modes of its machine.
    ///
    /// # Errors
    /// Why the row describes no scene that can be simulated.
    pub fn scene(&self, row: usize) -> Result<RowScene, InvalidRow> {
        let scene = self.study.scene(row, &self.points)?;
        let modes = self.modes(&scene).map_err(|error| InvalidRow { reason: error.to_string() })?;
        Ok(RowScene { scene, modes })
    }

    /// The modes of its machine for any scene whose mounts and fixtures are points that the study uses.
    ///
    /// # Errors
    /// As for [`Machine::modes`].
    pub fn modes(&self, scene: &Scene) -> Result<InterfaceModes, StructureError> {
        self.machine_of(scene).modes(scene)
    }

    /// The machine that a scene is on.
    pub fn machine_of(&self, scene: &Scene) -> &Machine {
        scene.machine.and_then(|index| self.further.get(index)).unwrap_or(&self.machine)
    }

    /// Simulates a row, retries and twins included. Pure: depends on the study and the row alone.
    pub fn run(&self, row: usize) -> RowOutcome {
        match self.scene(row) {
            Ok(RowScene { scene, modes }) => run_row_with_retries(&scene, &modes, self.retries),
            Err(invalid) => RowOutcome::invalid(invalid.reason),
        }
    }

    /// What the tables must know of the study.
    pub fn info(&self) -> DatasetInfo {
        let settings = BTreeMap::from([("retries".to_owned(), self.retries.to_string())]);
        dataset_info(&self.study, self.inputs.clone(), settings)
    }
}

/// Strikes follow from where points are: the machines of a study have those that it uses at the same places.
fn same_points(table: &str, demand: &InterfaceDemand, [first, other]: [&PointTable; 2]) -> Result<(), EngineError> {
    for name in demand.mounts.iter().chain(&demand.fixtures) {
        let (table, point) = (table.to_owned(), name.clone());
        let (Some(expected), Some(found)) = (first.position(name), other.position(name)) else {
            return Err(EngineError::MissingPoint { table, point });
        };
        let apart = expected.iter().zip(found).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        if apart > SAME_PLACE_M {
            return Err(EngineError::MovedPoint { table, point, found, expected });
        }
    }
    Ok(())
}

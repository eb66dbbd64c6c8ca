//! A study made ready: checked against its machines, the machines reduced.

use std::any::Any;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use super::error::{EngineError, MOST_SIGNAL_BYTES};
use super::info::dataset_info;
use super::inputs::input_hashes;
use super::machine::{Machine, SourceModel};
use crate::dataset::DatasetInfo;
use crate::metrics::{Signal, SignalRecorder};
use crate::run::{DEFAULT_RETRIES, JobSource, RowJob, RowOutcome, RowSource, run_jobs, run_one_by_one};
use crate::scene::Scene;
use crate::structure::StructureError;
use crate::study::{CheckedStudy, InterfaceDemand, InvalidRow, PointTable, Study};
use crate::system::InterfaceModes;

/// Distance in m within which two points are the same.
const SAME_PLACE_M: f64 = 1e-6;

/// The rows of a sweep: simulated by an [`Engine`], or made up.
pub trait Rows: Sync {
    /// The study whose rows they are, held to its machine.
    fn checked(&self) -> &CheckedStudy;
    /// The study as loaded.
    fn study(&self) -> &Study {
        self.checked().study()
    }
    /// What the tables must know of the study.
    fn info(&self) -> DatasetInfo;
    /// Runs a row. Pure: depends on the study and the row alone.
    fn outcome(&self, row: usize) -> RowOutcome;
    /// Runs rows on one thread until there are no more, with the outcomes that [`Rows::outcome`] gives; here one after the other.
    fn run(&self, rows: &mut dyn RowSource) {
        run_one_by_one(rows, |row| self.outcome(row as usize));
    }
}

/// A study ready to run.
#[derive(Debug)]
pub struct Engine {
    checked: CheckedStudy,
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
        let demand = InterfaceDemand::of(&study);
        let checked = CheckedStudy::new(study, model.points())?;
        let machine = Machine::new(model, checked.study().structure(), &demand)?;
        let mut further = Vec::new();
        for (name, settings) in checked.study().structures() {
            let table = format!("structures.{name}");
            inputs.extend(input_hashes(&table, &settings.source)?);
            let model = SourceModel::read(settings)?;
            same_points(&table, &demand, [checked.points(), &model.points()])?;
            further.push(Machine::new(model, settings, &demand)?);
        }
        Ok(Self { checked, machine, further, retries: DEFAULT_RETRIES, inputs })
    }

    /// With another number of times that a row that diverges is run again; default [`DEFAULT_RETRIES`].
    pub fn with_retries(self, retries: u32) -> Self {
        Self { retries, ..self }
    }

    /// What users should know of how the machines were made ready, in lines: kept reductions that could not be used.
    pub fn notes(&self) -> impl Iterator<Item = &str> {
        [&self.machine].into_iter().chain(&self.further).filter_map(Machine::note)
    }

    /// The scene of a row and the modes of its machine.
    ///
    /// # Errors
    /// Why the row describes no scene that can be simulated.
    pub fn scene(&self, row: usize) -> Result<RowScene, InvalidRow> {
        let scene = self.checked.scene(row)?;
        let modes = self.modes(&scene).map_err(|error| InvalidRow { reason: error.to_string() })?;
        Ok(RowScene { scene, modes })
    }

    /// What is to be done for a row, retries and twins included.
    fn job(&self, row: usize) -> Result<RowJob, InvalidRow> {
        let RowScene { scene, modes } = self.scene(row)?;
        Ok(RowJob::new(scene, modes, self.retries))
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

    /// The outcome of a row, retries and twins included, and its signals every `interval_s`; none where the row describes no
    /// scene.
    ///
    /// # Errors
    /// [`EngineError::Signals`] if they would take more than a gigabyte of memory.
    pub fn outcome_with_signals(
        &self,
        row: usize,
        interval_s: f64,
    ) -> Result<(RowOutcome, Option<Vec<Signal>>), EngineError> {
        let RowScene { scene, modes } = match self.scene(row) {
            Ok(found) => found,
            Err(invalid) => return Ok((RowOutcome::invalid(invalid.reason), None)),
        };
        let bytes = SignalRecorder::bytes(&scene, interval_s);
        if bytes > MOST_SIGNAL_BYTES {
            let least_interval_s = interval_s * bytes / MOST_SIGNAL_BYTES;
            return Err(EngineError::Signals { duration_s: scene.duration_s, bytes, least_interval_s });
        }
        let job = RowJob::new(scene.clone(), modes, self.retries);
        let (outcome, recorder) = job.run_observed(|model| SignalRecorder::new(model, &scene, interval_s));
        Ok((outcome, recorder.map(SignalRecorder::into_signals)))
    }
}

impl Rows for Engine {
    fn checked(&self) -> &CheckedStudy {
        &self.checked
    }

    fn info(&self) -> DatasetInfo {
        let settings = BTreeMap::from([("retries".to_owned(), self.retries.to_string())]);
        dataset_info(&self.checked, self.inputs.clone(), settings)
    }

    /// Simulates a row, retries and twins included.
    fn outcome(&self, row: usize) -> RowOutcome {
        match self.job(row) {
            Ok(job) => job.run(),
            Err(invalid) => RowOutcome::invalid(invalid.reason),
        }
    }

    /// Rows of one shape side by side.
    fn run(&self, rows: &mut dyn RowSource) {
        run_jobs(&mut Jobs { engine: self, rows });
    }
}

/// Rows of an engine as what is to be done.
struct Jobs<'j> {
    engine: &'j Engine,
    rows: &'j mut dyn RowSource,
}

impl JobSource for Jobs<'_> {
    fn next(&mut self, wait: bool) -> Option<(u64, RowJob)> {
        loop {
            let row = self.rows.next(wait)?;
            match catch_unwind(AssertUnwindSafe(|| self.engine.job(row as usize))) {
                Ok(Ok(job)) => return Some((row, job)),
                Ok(Err(invalid)) => self.rows.ended(row, RowOutcome::invalid(invalid.reason)),
                Err(payload) => self.panicked(row, payload),
            }
        }
    }

    fn ended(&mut self, row: u64, outcome: RowOutcome) {
        self.rows.ended(row, outcome);
    }

    fn panicked(&mut self, row: u64, payload: Box<dyn Any + Send>) {
        self.rows.ended(row, RowOutcome::panicked(payload.as_ref()));
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

/// A study held to its machine, which is read but not reduced: its rows are known, and cannot be run.
///
/// # Errors
/// What is wrong with the study or the files of its machine.
pub fn checked(study: Study) -> Result<CheckedStudy, EngineError> {
    let points = SourceModel::read(study.structure())?.points();
    Ok(CheckedStudy::new(study, points)?)
}

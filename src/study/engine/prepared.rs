//! A study ready to run: checked, with reduced machines.

use std::any::Any;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::error::{EngineError, MOST_SIGNAL_BYTES};
use super::info::dataset_info;
use super::inputs::input_hashes;
use super::machine::{ElasticCasting, ElasticCastings, Machine, SourceModel, named};
use super::sample::is_drawn;
use super::signals::KeptSignals;
use crate::{CheckedStudy, InterfaceDemand, InvalidRow, PointTable, Study};
use decore_dataset::{Columns, DatasetError, DatasetInfo, RETRIES};
use decore_model::metrics::{MeanRecorder, MeanSettings, Signal, SignalRecorder};
use decore_model::run::{
    BatchSettings, DEFAULT_RETRIES, DEFAULT_WINDOW, JobSource, RowJob, RowOutcome, RowSource, RowTask, run_batch,
    run_jobs, run_one_by_one,
};
use decore_model::scene::{NumericalTwin, Scene};
use decore_model::structure::{BodyNodes, FeModel, StructureError};
use decore_model::system::PlacedModes;
use decore_statistics::design::Level;

/// Distance in m within which two points are the same.
const SAME_PLACE_M: f64 = 1e-6;

/// The rows of a sweep: simulated by an [`Engine`], or made up.
pub trait RowRunner: Sync {
    /// Study of the rows, checked against its machine.
    fn checked(&self) -> &CheckedStudy;
    /// The study as loaded.
    fn study(&self) -> &Study {
        self.checked().study()
    }
    /// Information on the study for the tables.
    fn info(&self) -> DatasetInfo;
    /// Runs a row. Pure: depends on the study and the row alone.
    fn outcome(&self, row: usize) -> RowOutcome;
    /// Whether rows with the same factors have the same outcome.
    fn depends_on_factors_alone(&self) -> bool {
        true
    }
    /// Runs rows on one thread until there are no more, one after the other, with the outcomes of [`RowRunner::outcome`].
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
    /// The signals that a sweep keeps.
    signals: Option<KeptSignals>,
}

/// The scene of a row and the modes of the machine that it is on.
#[derive(Debug, Clone)]
pub struct RowScene {
    /// Scene of the row.
    pub scene: Scene,
    /// Modes of the machine with the scene's housings on their mounts.
    pub modes: Arc<PlacedModes>,
}

impl Engine {
    /// Loads a study with the settings `path=value` over its own and makes it ready.
    ///
    /// # Errors
    /// As for [`Study::load`], [`Study::with_overrides`] and [`Engine::new`].
    pub fn load(path: &Path, overrides: &[String]) -> Result<Self, EngineError> {
        Self::new(Study::load(path)?.with_overrides(overrides)?)
    }

    /// Checks a study against the interface points of its machines, applies its constraints, and reduces the machines for its rows.
    ///
    /// # Errors
    /// Faults of the study, of a machine's files or reduction; machines whose points are not at the same places.
    pub fn new(study: Study) -> Result<Self, EngineError> {
        let mut inputs = input_hashes("structure", &study.structure().source.files())?;
        let model = SourceModel::read(study.structure())?;
        let demand = InterfaceDemand::of(&study);
        let read = node_models(&study)?;
        let points = with_nodes(model.points(), &study, &read)?;
        let checked = CheckedStudy::new(study, points)?;
        let castings = elastic_castings(checked.study(), read, &mut inputs)?;
        let machine = Machine::new(model, checked.study().structure(), (&demand, &castings))?;
        let mut further = Vec::new();
        for (name, settings) in checked.study().structures() {
            let table = format!("structures.{name}");
            inputs.extend(input_hashes(&table, &settings.source.files())?);
            let model = SourceModel::read(settings)?;
            same_points(&table, &demand, [checked.points(), &model.points()])?;
            further.push(Machine::new(model, settings, (&demand, &castings))?);
        }
        let signals = KeptSignals::of(&checked)?;
        check_goal(&checked)?;
        Ok(Self { checked, machine, further, retries: DEFAULT_RETRIES, inputs, signals })
    }

    /// With another number of times that a row that diverges is run again; default [`DEFAULT_RETRIES`].
    pub fn with_retries(self, retries: u32) -> Self {
        Self { retries, ..self }
    }

    /// Notes on the machines for users, in lines: cached reductions that could not be used, doubtful matrices.
    pub fn notes(&self) -> impl Iterator<Item = &str> {
        [&self.machine].into_iter().chain(&self.further).flat_map(Machine::notes).map(String::as_str)
    }

    /// The scene of a row and the modes of its machine.
    ///
    /// # Errors
    /// Why the row describes no scene that can be simulated.
    pub fn scene(&self, row: usize) -> Result<RowScene, InvalidRow> {
        self.on_machine(self.checked.scene(row))
    }

    /// A scene with the modes of its machine.
    fn on_machine(&self, scene: Result<Scene, InvalidRow>) -> Result<RowScene, InvalidRow> {
        let scene = scene?;
        let modes = self.modes(&scene).map_err(|error| InvalidRow { reason: error.to_string() })?;
        Ok(RowScene { scene, modes })
    }

    /// Returns the job of a row, or of values that are no row, with its retries and twins.
    fn job(&self, scene: Result<Scene, InvalidRow>, row: Option<u64>) -> Result<RowJob, InvalidRow> {
        let RowScene { scene, modes } = self.on_machine(scene)?;
        // If the modes cannot be computed, the row's errors stay unknown: `numerical_twin_done` is 0.
        let numerical = self.has_numerical_twin(row).then(|| self.machine_of(&scene).all_modes(&scene).ok());
        let job = RowJob::new(scene, modes, self.retries);
        Ok(match numerical {
            Some(all_modes) => job.with_numerical_twin(all_modes),
            None => job,
        })
    }

    /// Whether a row has a numerical twin: a function of study, seed and row alone. Values that are not a row are never drawn.
    fn has_numerical_twin(&self, row: Option<u64>) -> bool {
        let study = self.checked.study();
        study.numerical_twin() == NumericalTwin::All || row.is_some_and(|row| is_drawn(study, row))
    }

    /// The modes of its machine for any scene whose mounts and fixtures are points that the study uses.
    ///
    /// # Errors
    /// As for [`Machine::modes`].
    pub fn modes(&self, scene: &Scene) -> Result<Arc<PlacedModes>, StructureError> {
        self.machine_of(scene).modes(scene)
    }

    /// The machine that a scene is on.
    pub fn machine_of(&self, scene: &Scene) -> &Machine {
        scene.machine.and_then(|index| self.further.get(index)).unwrap_or(&self.machine)
    }

    /// The outcome of a row, retries and twins included, and its signals every `interval_s`; none if the row describes no
    /// scene.
    ///
    /// # Errors
    /// [`EngineError::Signals`] if they would take more than a gigabyte of memory.
    pub fn outcome_with_signals(
        &self,
        row: usize,
        interval_s: f64,
    ) -> Result<(RowOutcome, Option<Vec<Signal>>), EngineError> {
        self.with_signals(self.checked.scene(row), Some(row as u64), interval_s)
    }

    /// As [`Engine::outcome_with_signals`], where the factors have these levels, see [`CheckedStudy::levels`].
    ///
    /// # Errors
    /// As for [`Engine::outcome_with_signals`].
    pub fn outcome_with_signals_at(
        &self,
        levels: &[Level],
        interval_s: f64,
    ) -> Result<(RowOutcome, Option<Vec<Signal>>), EngineError> {
        self.with_signals(self.checked.scene_at(levels), None, interval_s)
    }

    /// As [`RowRunner::outcome`], where the factors have these levels, see [`CheckedStudy::levels`].
    pub fn outcome_at(&self, levels: &[Level]) -> RowOutcome {
        self.alone(self.checked.scene_at(levels), None)
    }

    /// Outcomes at the levels of each of these points, in their order, as by [`Engine::outcome_at`], in lanes and on several threads.
    /// `None` if `stop` was set before all had begun.
    ///
    /// `threads`: as [`BatchSettings::threads`].
    ///
    /// # Errors
    /// [`EngineError::Batch`] if the threads cannot be started.
    pub fn outcomes_at(
        &self,
        points: &[Vec<Level>],
        threads: usize,
        stop: &AtomicBool,
    ) -> Result<Option<Vec<RowOutcome>>, EngineError> {
        let settings = BatchSettings { threads, window: DEFAULT_WINDOW, stop, tick: &|| () };
        let mut outcomes = Vec::with_capacity(points.len());
        let summary =
            run_batch(0..points.len() as u64, &settings, &GivenPoints { engine: self, points }, |_, outcome| {
                outcomes.push(outcome);
                Ok::<(), DatasetError>(())
            })?;
        Ok(Some(outcomes).filter(|_| !summary.stopped))
    }

    fn alone(&self, scene: Result<Scene, InvalidRow>, row: Option<u64>) -> RowOutcome {
        match self.job(scene, row) {
            Ok(job) => job.run(),
            Err(invalid) => RowOutcome::invalid(invalid.reason),
        }
    }

    /// The outcome of a row's scene with means of its signals; none of a row that does not reach its end.
    fn with_means(&self, scene: Result<Scene, InvalidRow>, row: u64, settings: &MeanSettings) -> RowOutcome {
        let (scene, job) = match scene.and_then(|scene| Ok((scene.clone(), self.job(Ok(scene), Some(row))?))) {
            Ok(found) => found,
            Err(invalid) => return RowOutcome::invalid(invalid.reason),
        };
        let (mut outcome, recorder) = job.run_observed(|model| MeanRecorder::new(model, &scene, settings.clone()));
        if let (Some(metrics), Some(recorder)) = (&mut outcome.metrics, recorder) {
            metrics.signals = recorder.into_means();
        }
        outcome
    }

    fn with_signals(
        &self,
        scene: Result<Scene, InvalidRow>,
        row: Option<u64>,
        interval_s: f64,
    ) -> Result<(RowOutcome, Option<Vec<Signal>>), EngineError> {
        let (scene, job) = match scene.and_then(|scene| Ok((scene.clone(), self.job(Ok(scene), row)?))) {
            Ok(found) => found,
            Err(invalid) => return Ok((RowOutcome::invalid(invalid.reason), None)),
        };
        let bytes = SignalRecorder::bytes(&scene, interval_s);
        if bytes > MOST_SIGNAL_BYTES {
            let least_interval_s = interval_s * bytes / MOST_SIGNAL_BYTES;
            return Err(EngineError::Signals { duration_s: scene.duration_s, bytes, least_interval_s });
        }
        let (outcome, recorder) = job.run_observed(|model| SignalRecorder::new(model, &scene, interval_s));
        Ok((outcome, recorder.map(SignalRecorder::into_signals)))
    }
}

impl RowRunner for Engine {
    fn checked(&self) -> &CheckedStudy {
        &self.checked
    }

    fn info(&self) -> DatasetInfo {
        let settings = BTreeMap::from([(RETRIES.to_owned(), self.retries.to_string())]);
        dataset_info(&self.checked, self.inputs.clone(), settings, self.signals.as_ref())
    }

    /// Simulates a row, retries and twins included.
    fn outcome(&self, row: usize) -> RowOutcome {
        self.alone(self.checked.scene(row), Some(row as u64))
    }

    /// Rows of one shape side by side; with the signals that a sweep keeps, whose rows run alone.
    fn run(&self, rows: &mut dyn RowSource) {
        let kept = self.signals.as_ref();
        let scene = |row| self.checked.scene(row as usize);
        run_jobs(&mut Jobs { engine: self, scene: &scene, rows, numbered: true, kept });
    }
}

/// Points whose factors were given.
struct GivenPoints<'p> {
    engine: &'p Engine,
    points: &'p [Vec<Level>],
}

impl RowTask for GivenPoints<'_> {
    type Kept = RowOutcome;

    fn run(&self, rows: &mut dyn RowSource) {
        let scene = |row: u64| match self.points.get(row as usize) {
            Some(levels) => self.engine.checked.scene_at(levels),
            None => Err(InvalidRow { reason: format!("there is no point {row}") }),
        };
        run_jobs(&mut Jobs { engine: self.engine, scene: &scene, rows, numbered: false, kept: None });
    }

    fn keep(&self, _: u64, outcome: RowOutcome) -> RowOutcome {
        outcome
    }
}

/// Rows of an engine as jobs.
struct Jobs<'j> {
    engine: &'j Engine,
    scene: &'j dyn Fn(u64) -> Result<Scene, InvalidRow>,
    rows: &'j mut dyn RowSource,
    /// Whether they are rows of the study, not points whose factors were given.
    numbered: bool,
    /// The signals that are kept.
    kept: Option<&'j KeptSignals>,
}

impl JobSource for Jobs<'_> {
    fn next(&mut self, wait: bool) -> Option<(u64, RowJob)> {
        loop {
            let row = self.rows.next(wait)?;
            if let Some(kept) = self.kept.filter(|kept| kept.keep(row)) {
                let run = || self.engine.with_means((self.scene)(row), row, &kept.settings);
                match catch_unwind(AssertUnwindSafe(run)) {
                    Ok(outcome) => self.rows.ended(row, outcome),
                    Err(payload) => self.panicked(row, payload),
                }
                continue;
            }
            let numbered = self.numbered.then_some(row);
            match catch_unwind(AssertUnwindSafe(|| self.engine.job((self.scene)(row), numbered))) {
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

/// Models of elastic castings by the castings' indices.
type CastingModels = BTreeMap<usize, FeModel>;

/// Reads the models of all elastic castings if the study has points that are nodes: their places belong to the rows.
fn node_models(study: &Study) -> Result<CastingModels, EngineError> {
    let named = study.elastic_castings().iter().filter(|_| study.names_nodes());
    named.map(|(index, (_, model))| Ok((*index, FeModel::read(&model.files)?))).collect()
}

/// Adds the nodes of castings to the points of the machine.
fn with_nodes(points: PointTable, study: &Study, models: &CastingModels) -> Result<PointTable, EngineError> {
    let mut points = points;
    for (index, model) in models {
        let Some((name, _)) = study.elastic_castings().get(index) else { continue };
        points = points.with_nodes(name, BodyNodes::new(model).map_err(|error| named(error, name))?);
    }
    Ok(points)
}

/// Computes the modes of a study's elastic castings; adds the checksums of their files. `read`: models that have been read.
fn elastic_castings(
    study: &Study,
    mut read: CastingModels,
    inputs: &mut BTreeMap<String, String>,
) -> Result<ElasticCastings, EngineError> {
    let mut castings = BTreeMap::new();
    for (index, (name, casting)) in study.elastic_castings() {
        inputs.extend(input_hashes(&format!("casting.{name}.structure"), &casting.listed())?);
        let model = match read.remove(index) {
            Some(model) => model,
            None => FeModel::read(&casting.files)?,
        };
        castings.insert(*index, ElasticCasting::new(name, model, &casting.settings)?);
    }
    Ok(Arc::new(castings))
}

/// Strikes follow from where points are: the machines of a study have those that it uses at the same places.
fn same_points(table: &str, demand: &InterfaceDemand, [first, other]: [&PointTable; 2]) -> Result<(), EngineError> {
    for name in demand.mounts.iter().chain(&demand.others) {
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

/// Checks a study against its machine, which is read but not reduced: its rows are known, but cannot run.
///
/// # Errors
/// What is wrong with the study or the files of its machine.
pub fn checked(study: Study) -> Result<CheckedStudy, EngineError> {
    let points = SourceModel::read(study.structure())?.points();
    let points = with_nodes(points, &study, &node_models(&study)?)?;
    let checked = CheckedStudy::new(study, points)?;
    check_goal(&checked)?;
    Ok(checked)
}

/// Checks the goal's names and units against the columns that the study's rows have.
fn check_goal(checked: &CheckedStudy) -> Result<(), EngineError> {
    if checked.study().goal().is_none() {
        return Ok(());
    }
    let columns = Columns::new(&dataset_info(checked, BTreeMap::new(), BTreeMap::new(), None))?;
    let numbers = columns.runs.iter().map(|column| &column.description).filter(|column| !column.kind.is_text());
    let known: Vec<(String, String)> = numbers.map(|column| (column.name.clone(), column.unit.clone())).collect();
    Ok(checked.study().check_goal(&known)?)
}

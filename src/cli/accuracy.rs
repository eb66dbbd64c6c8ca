//! `decore accuracy`: speed against error on one row of a study.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use clap::Args;
use schemars::JsonSchema;
use serde::Serialize;

use super::exit::{Exit, Failure, write_file};
use super::json::print_result;
use super::outputs::{Form, Output, StudyArguments};
use super::progress::clock;
use super::text::{check_row, eprint_line, print_line};
use crate::accuracy::{Accuracy, Begun, Experiment, Measurement, Setting, fixed_steps, ladder, measure, plot, text};
use decore_dataset::{TableColumn, write_table};
use decore_model::integrate::Counters;
use decore_model::metrics::RunTotals;
use decore_model::run::RowStatus;
use decore_model::system::PlacedModes;
use decore_quantity::{CellColumn, quantities};
use decore_study::StructureSource;
use decore_study::engine::{Engine, RowRunner, RowScene};

/// Cut-off of the modes with which truncation is judged, unless another is asked for: above all of most machines' models.
const ALL_MODES_HZ: f64 = 1e9;
/// Names of the written files: table, text, plot.
const FILES: [&str; 3] = ["accuracy.parquet", "accuracy.txt", "accuracy.svg"];

#[derive(Debug, Args)]
pub(super) struct AccuracyArguments {
    /// Study file (TOML)
    study: PathBuf,
    /// Row of the design
    #[arg(short, long, default_value_t = 0)]
    row: usize,
    /// Set a value of the study, for example `hammer.left.supply_bar=4.5`; repeatable
    #[arg(long = "set", value_name = "PATH=VALUE")]
    overrides: Vec<String>,
    /// Folder for the table, the text and the plot (default: STUDY_accuracy)
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Replace existing files
    #[arg(long)]
    replace: bool,
    /// Number of runs of each setting; the fastest counts
    #[arg(long, default_value_t = 3)]
    repeats: usize,
    /// Cut-off of the modes that serve as reference for the truncation, in Hz
    #[arg(long, default_value_t = ALL_MODES_HZ, value_name = "HZ")]
    full_cutoff_hz: f64,
    /// Skip the test of mode truncation
    #[arg(long)]
    no_truncation: bool,
    /// Skip the slowest fixed-step methods
    ///
    /// These are rk4 at 1 us and the implicit trapezoid.
    #[arg(long)]
    quick: bool,
    /// Print the comparison as JSON (schemas/accuracy.schema.json)
    #[arg(long)]
    json: bool,
}

pub(super) fn accuracy(arguments: &AccuracyArguments) -> Result<Exit, Failure> {
    let stem = arguments.study.file_stem().unwrap_or_default().to_string_lossy();
    let folder = arguments.output.clone().unwrap_or_else(|| PathBuf::from(format!("{stem}_accuracy")));
    let form = Form::Folder { names: &FILES, replace: arguments.replace };
    let outputs = [Output { flag: "--output", path: Some(&folder), form }];
    let engine =
        StudyArguments { file: &arguments.study, overrides: &arguments.overrides, outputs: &outputs }.engine()?;
    check_row(&engine, arguments.row)?;
    let invalid = |invalid| Failure::Argument(format!("row {} describes no scene: {invalid}", arguments.row));
    let RowScene { scene, modes } = engine.scene(arguments.row).map_err(invalid)?;
    let all_modes = all_modes(arguments, &engine)?;
    let mut settings = ladder(&scene);
    settings.extend(fixed_steps(&scene.solver, !arguments.quick));
    let experiment = Experiment {
        scene: &scene,
        modes: &modes,
        all_modes: all_modes.as_deref(),
        settings,
        repeats: arguments.repeats,
    };
    let started = Instant::now();
    let result = measure(&experiment, &mut |begun| eprint_line(&running(begun, started.elapsed())));
    let result = result
        .map_err(|error| Failure::Argument(format!("{error} (is the scene one that `decore scene` can run?)")))?;
    let words = text(&result);
    // Shown before it is written: a disk that is full by now costs the files alone.
    print_result(arguments.json, &AccuracyResult::of(&engine, arguments.row, &result), || words.clone())?;
    write(&folder, &engine, &result, &words)?;
    let place = format!("Table, text and plot are in {}", folder.display());
    match arguments.json {
        true => eprint_line(&place),
        false => print_line(&place)?,
    }
    Ok(Exit::Done)
}

/// `3 of 40: reference, about 00:01:20 left`, by the mean time of the runs so far.
fn running(Begun { number, of, what }: Begun<'_>, elapsed: Duration) -> String {
    let ended = number.saturating_sub(1);
    let left_s = elapsed.as_secs_f64() / ended as f64 * of.saturating_sub(ended) as f64;
    let left = if ended == 0 { String::new() } else { format!(", about {} left", clock(left_s)) };
    format!("{number} of {of}: {what}{left}")
}

/// The scene's modes with none left out below the cut-off; `None` where there are no more to be had.
fn all_modes(arguments: &AccuracyArguments, engine: &Engine) -> Result<Option<Arc<PlacedModes>>, Failure> {
    let table = matches!(engine.study().structure().source, StructureSource::ModalTable { .. });
    if arguments.no_truncation || table {
        return Ok(None);
    }
    let mut overrides = arguments.overrides.clone();
    for key in ["cutoff_hz", "fixed_interface_cutoff_hz"] {
        overrides.push(format!("structure.{key}={:e}", arguments.full_cutoff_hz));
    }
    if engine.study().structure().mode_tolerance.is_some() {
        overrides.push("structure.mode_tolerance=0".to_owned());
    }
    // What looks wrong with the study has been told.
    let all = Engine::load(&arguments.study, &overrides)?;
    let scene = all.scene(arguments.row).map_err(|invalid| Failure::Argument(invalid.reason))?;
    Ok(Some(scene.modes))
}

fn write(folder: &Path, engine: &Engine, result: &Accuracy, words: &str) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|source| Failure::Write { path: folder.display().to_string(), source })?;
    let [table, text, picture] = FILES.map(|name| folder.join(name));
    write_table(&table, &engine.info(), "accuracy", &columns(result))?;
    write_file(&text, words)?;
    write_file(&picture, plot(result)?)
}

/// Speed against error on one row.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct AccuracyResult {
    /// Title of the study.
    study: String,
    /// Hash of the study.
    study_hash: String,
    /// The row.
    row: usize,
    /// Outputs by name.
    outputs: BTreeMap<&'static str, String>,
    /// The settings that were run.
    settings: Vec<SettingResult>,
    /// Relative difference of each output between the reference and the same at ten times its tolerance.
    reference_error: Errors,
    /// Relative movement of each output where pressures and standoffs are perturbed.
    sensitivity: Errors,
    /// Effect of the modes that are left out; null if there are none, or none were requested.
    truncation: Option<Truncation>,
}

/// Largest relative error of each output over hammers or castings; null where one of the two runs has none.
type Errors = BTreeMap<&'static str, Option<f64>>;

/// One setting.
#[derive(Debug, Serialize, JsonSchema)]
struct SettingResult {
    #[serde(flatten)]
    row: TableRow,
    /// Work done.
    counters: Counters,
    /// Energy residual; null unless the run reached its end.
    energy_residual: Option<f64>,
    /// Errors of the outputs.
    errors: Errors,
}

/// Effect of the modes that are left out.
#[derive(Debug, Serialize, JsonSchema)]
struct Truncation {
    /// Modes with none left out.
    modes: usize,
    /// Errors of the outputs.
    errors: Errors,
}

impl AccuracyResult {
    fn of(engine: &Engine, row: usize, result: &Accuracy) -> Self {
        let errors = |values: &[f64]| -> Errors {
            let finite = values.iter().map(|value| Some(*value).filter(|value| value.is_finite()));
            result.outputs.iter().map(|output| output.name).zip(finite).collect()
        };
        let setting = |measurement: &Measurement| SettingResult {
            row: TableRow::of(measurement),
            counters: measurement.counters,
            energy_residual: measurement.totals.as_ref().map(|totals| totals.energy_residual),
            errors: errors(&measurement.errors),
        };
        Self {
            study: engine.study().title().to_owned(),
            study_hash: engine.study().hash().to_owned(),
            row,
            outputs: result.outputs.iter().map(|output| (output.name, output.description.clone())).collect(),
            settings: result.measurements.iter().map(setting).collect(),
            reference_error: errors(&result.reference_error),
            sensitivity: errors(&result.sensitivity),
            truncation: result.truncation.as_ref().map(|(modes, of)| Truncation { modes: *modes, errors: errors(of) }),
        }
    }
}

quantities! {
    /// A row of the table, before its errors.
    #[derive(Debug, Default, Serialize, JsonSchema)]
    pub struct TableRow {
        /// Family of settings, or a limit of all of them.
        pub setting: String => "",
        /// Fidelity preset that the setting is.
        pub preset: Option<String> => "",
        /// Method of integration.
        pub method: Option<String> => "",
        /// Model of the housing guide.
        pub guide: Option<String> => "",
        /// Integration of the modes.
        pub modes_treatment: Option<String> => "",
        /// Status of the run.
        pub status: Option<RowStatus> => "",
        /// Error tolerance of a step; NaN at a fixed step.
        pub tolerance: Option<f64> => "1",
        /// Length of a fixed step; NaN under error control.
        pub step_s: Option<f64> => "s",
        /// Wall time of the fastest run.
        pub ms_per_simulated_s: Option<f64> => "ms/s",
        /// Modes of the structure.
        pub modes: Option<usize> => "1",
        /// States integrated.
        pub states: Option<usize> => "1",
    }
}

impl TableRow {
    fn of(measurement: &Measurement) -> Self {
        let setting = &measurement.setting;
        let solver = setting.solver;
        Self {
            setting: setting.family.clone(),
            preset: setting.preset.map(str::to_owned),
            method: Some(method(setting)),
            guide: Some(solver.guide.name().to_owned()),
            modes_treatment: Some(solver.modes.name().to_owned()),
            status: Some(measurement.status),
            tolerance: (!fixed(setting)).then_some(solver.tolerance),
            step_s: fixed(setting).then_some(solver.step_s),
            ms_per_simulated_s: Some(measurement.ms_per_simulated_s),
            modes: Some(measurement.modes),
            states: Some(measurement.states),
        }
    }
}

/// The table: a row per setting, then the limits of all of them.
fn columns(result: &Accuracy) -> Vec<TableColumn> {
    let limit = |name: &str| TableRow { setting: name.to_owned(), ..TableRow::default() };
    let mut rows: Vec<TableRow> = result.measurements.iter().map(TableRow::of).collect();
    let mut errors: Vec<&Vec<f64>> = result.measurements.iter().map(|measurement| &measurement.errors).collect();
    for (name, limiting) in [
        ("error of the reference", Some(&result.reference_error)),
        ("sensitivity of the scene", Some(&result.sensitivity)),
        ("modes left out", result.truncation.as_ref().map(|(_, errors)| errors)),
    ] {
        rows.extend(limiting.map(|_| limit(name)));
        errors.extend(limiting);
    }
    let runs = || (0..rows.len()).map(|row| result.measurements.get(row));
    let mut columns: Vec<TableColumn> =
        TableRow::QUANTITIES.iter().map(|quantity| TableColumn::new(quantity, rows.iter().map(Some))).collect();
    // Every setting is run once.
    let counted = Counters::QUANTITIES.iter().filter(|quantity| quantity.name != Counters::retries.name);
    let counters = || runs().map(|run| run.map(|run| &run.counters));
    columns.extend(counted.map(|quantity| TableColumn::new(quantity, counters())));
    let totals = runs().map(|run| run.and_then(|run| run.totals.as_ref()));
    columns.push(TableColumn::new(&RunTotals::energy_residual, totals));
    columns.extend(result.outputs.iter().enumerate().map(|(index, output)| TableColumn {
        name: format!("error_{}", output.name),
        unit: "1".to_owned(),
        description: format!("Largest relative error. {}", output.description),
        values: CellColumn::reals(errors.iter().map(|of| of.get(index).copied().unwrap_or(f64::NAN))),
    }));
    columns
}

fn fixed(setting: &Setting) -> bool {
    setting.solver.method.is_fixed()
}

fn method(setting: &Setting) -> String {
    let solver = setting.solver;
    let located = if solver.method.is_fixed() && solver.located { ", contacts located" } else { "" };
    format!("{}{located}", solver.method.name())
}

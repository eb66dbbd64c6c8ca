//! `decore accuracy`: speed against error on one row of a study.

use std::path::{Path, PathBuf};

use clap::Args;

use super::exit::{Exit, Failure};
use super::text::{check_row, say, tell};
use crate::accuracy::{Accuracy, Experiment, Setting, fixed_steps, ladder, measure, plot, text};
use crate::dataset::{TableColumn, TableValues, write_table};
use crate::engine::{Engine, RowScene};
use crate::scene::{Guide, Method, ModeTreatment};
use crate::study::StructureSource;
use crate::system::InterfaceModes;

/// Cut-off of the modes with which truncation is judged, unless another is asked for: above all of most machines' models.
const ALL_MODES_HZ: f64 = 1e9;

#[derive(Debug, Args)]
pub(super) struct AccuracyArguments {
    /// Study file (TOML).
    study: PathBuf,
    /// Row of the design.
    #[arg(short, long, default_value_t = 0)]
    row: usize,
    /// Set a value of the study, e.g. `hammer.left.supply_bar=4.5`; may be given several times.
    #[arg(long = "set", value_name = "PATH=VALUE")]
    overrides: Vec<String>,
    /// Folder for the table, the text and the plot. Default: the study's name with `_accuracy`.
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Runs of each setting, of which the fastest counts.
    #[arg(long, default_value_t = 3)]
    repeats: usize,
    /// Cut-off in Hz of the modes with which the truncation of modes is judged.
    #[arg(long, default_value_t = ALL_MODES_HZ, value_name = "HZ")]
    full_cutoff_hz: f64,
    /// Do not judge the truncation of modes.
    #[arg(long)]
    no_truncation: bool,
    /// Leave out the slowest of the methods at a fixed step: rk4 at 1 us and the implicit trapezoid.
    #[arg(long)]
    quick: bool,
}

pub(super) fn accuracy(arguments: &AccuracyArguments) -> Result<Exit, Failure> {
    let engine = Engine::load(&arguments.study, &arguments.overrides)?;
    check_row(&engine, arguments.row)?;
    let invalid = |invalid| Failure::Argument(format!("row {} describes no scene: {invalid}", arguments.row));
    let RowScene { scene, modes } = engine.scene(arguments.row).map_err(invalid)?;
    let all_modes = all_modes(arguments, &engine)?;
    let mut settings = ladder(&scene.solver);
    settings.extend(fixed_steps(&scene.solver, !arguments.quick));
    let experiment = Experiment {
        scene: &scene,
        modes: &modes,
        all_modes: all_modes.as_ref(),
        settings,
        repeats: arguments.repeats,
    };
    let result = measure(&experiment, &mut |what| tell(&format_args!("running: {what}")));
    let result = result.map_err(|error| Failure::Argument(error.to_string()))?;
    let stem = arguments.study.file_stem().unwrap_or_default().to_string_lossy();
    let folder = arguments.output.clone().unwrap_or_else(|| PathBuf::from(format!("{stem}_accuracy")));
    let words = text(&result);
    write(&folder, &engine, (&result, &words))?;
    say(&words);
    say(&format_args!("Table, text and plot are in {}", folder.display()));
    Ok(Exit::Done)
}

/// The scene's modes with none left out below the cut-off; `None` where there are no more to be had.
fn all_modes(arguments: &AccuracyArguments, engine: &Engine) -> Result<Option<InterfaceModes>, Failure> {
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
    let all = Engine::load(&arguments.study, &overrides)?;
    let scene = all.scene(arguments.row).map_err(|invalid| Failure::Argument(invalid.reason))?;
    Ok(Some(scene.modes))
}

fn write(folder: &Path, engine: &Engine, (result, words): (&Accuracy, &str)) -> Result<(), Failure> {
    let failed = |path: &Path| {
        let path = path.display().to_string();
        move |source| Failure::Write { path, source }
    };
    std::fs::create_dir_all(folder).map_err(failed(folder))?;
    write_table(&folder.join("accuracy.parquet"), &engine.info(), ("accuracy", &columns(result)))?;
    let path = folder.join("accuracy.txt");
    std::fs::write(&path, words).map_err(failed(&path))?;
    let svg = plot(result).map_err(|error| Failure::Argument(format!("nothing to plot: {error}")))?;
    let path = folder.join("accuracy.svg");
    std::fs::write(&path, svg).map_err(failed(&path))
}

/// The table: a row per setting, then the floors.
fn columns(result: &Accuracy) -> Vec<TableColumn> {
    let measurements = &result.measurements;
    let column = |name: &str, unit: &str, description: &str, values: TableValues| TableColumn {
        name: name.to_owned(),
        unit: unit.to_owned(),
        description: description.to_owned(),
        values,
    };
    let floors: Vec<(&str, &Vec<f64>)> = [
        Some(("error of the reference", &result.reference_error)),
        Some(("sensitivity of the scene", &result.sensitivity)),
        result.truncation.as_ref().map(|(_, errors)| ("modes left out", errors)),
    ]
    .into_iter()
    .flatten()
    .collect();
    let text = |value: &dyn Fn(&Setting) -> String, floor: &dyn Fn(&str) -> String| {
        let settings = measurements.iter().map(|measurement| value(&measurement.setting));
        TableValues::Text(settings.chain(floors.iter().map(|(name, _)| floor(name))).collect())
    };
    let real = |value: &dyn Fn(&crate::accuracy::Measurement) -> f64| {
        TableValues::Real(measurements.iter().map(value).chain(floors.iter().map(|_| f64::NAN)).collect())
    };
    let none = |_: &str| String::new();
    let mut columns = vec![
        column(
            "setting",
            "",
            "Family of settings, or what limits all of them.",
            text(&|s| s.family.clone(), &str::to_owned),
        ),
        column(
            "preset",
            "",
            "Fidelity preset that the setting is.",
            text(&|s| s.preset.unwrap_or_default().to_owned(), &none),
        ),
        column("method", "", "Method of integration.", text(&|s| method(s).to_owned(), &none)),
        column("guide", "", "Model of the housing guide.", text(&|s| guide(s.solver.guide).to_owned(), &none)),
        column(
            "modes_treatment",
            "",
            "How modes are integrated.",
            text(&|s| treatment(s.solver.modes).to_owned(), &none),
        ),
        column("status", "", "How the run ended.", {
            let settings = measurements.iter().map(|measurement| measurement.status.text().to_owned());
            TableValues::Text(settings.chain(floors.iter().map(|_| String::new())).collect())
        }),
        column(
            "tolerance",
            "1",
            "Error tolerance of a step; NaN at a fixed step.",
            real(&|m| if fixed(&m.setting) { f64::NAN } else { m.setting.solver.tolerance }),
        ),
        column(
            "step_s",
            "s",
            "Length of a fixed step; NaN under error control.",
            real(&|m| if fixed(&m.setting) { m.setting.solver.stepping.step_s } else { f64::NAN }),
        ),
        column("ms_per_simulated_s", "ms/s", "Wall time of the fastest run.", real(&|m| m.ms_per_simulated_s)),
        column("modes", "1", "Modes of the structure.", real(&|m| m.modes as f64)),
        column("states", "1", "States integrated.", real(&|m| m.states as f64)),
        column("steps", "1", "Accepted steps.", real(&|m| m.counters.steps as f64)),
        column("rejected_steps", "1", "Rejected steps.", real(&|m| m.counters.rejected_steps as f64)),
        column("rhs_evaluations", "1", "Right-hand sides.", real(&|m| m.counters.rhs_evaluations as f64)),
        column("factorisations", "1", "Factorisations of a matrix.", real(&|m| m.counters.factorisations as f64)),
        column(
            "located_events",
            "1",
            "Contacts met or left; located unless the method notices them at the ends of steps.",
            real(&|m| m.counters.located_events as f64),
        ),
        column("energy_residual", "1", "Energy residual of the run.", real(&|m| m.energy_residual)),
    ];
    for (index, output) in result.outputs.iter().enumerate() {
        let errors =
            measurements.iter().map(|measurement| &measurement.errors).chain(floors.iter().map(|floor| floor.1));
        let values = errors.map(|errors| errors.get(index).copied().unwrap_or(f64::NAN)).collect();
        let description = format!("Largest relative error. {}", output.description);
        columns.push(column(&format!("error_{}", output.name), "1", &description, TableValues::Real(values)));
    }
    columns
}

fn fixed(setting: &Setting) -> bool {
    setting.solver.stepping.method != Method::Tsit5
}

fn method(setting: &Setting) -> &'static str {
    match (setting.solver.stepping.method, setting.solver.stepping.located) {
        (Method::Tsit5, _) => "tsit5",
        (Method::Rk4, false) => "rk4",
        (Method::Rk4, true) => "rk4, contacts located",
        (Method::Trapezoid, false) => "trapezoid",
        (Method::Trapezoid, true) => "trapezoid, contacts located",
    }
}

fn guide(guide: Guide) -> &'static str {
    match guide {
        Guide::Spring => "spring",
        Guide::Tied => "tied",
    }
}

fn treatment(modes: ModeTreatment) -> &'static str {
    match modes {
        ModeTreatment::Automatic => "automatic",
        ModeTreatment::Integrated => "integrated",
        ModeTreatment::Condensed => "condensed",
    }
}

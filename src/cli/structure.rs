//! `decore structure`: how good is the reduction of a machine?

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use clap::Args;
use schemars::JsonSchema;
use serde::Serialize;

use super::exit::{Exit, Failure, write_file};
use super::inputs::expect_study;
use super::json::{print_json, wants_words};
use super::mobility::{Asked, compare_with_measured};
use super::outputs::{Form, Output, StudyArguments, check_outputs};
use super::text::{eprint_line, plural, print_line};
use super::written::Written;
use crate::accuracy::{MAIN_OUTPUTS, main_differences};
use crate::page::quality_page;
use decore_model::run::run_row;
use decore_model::structure::{
    CACHE_FOLDER, DOF_NAMES, ExportFormat, FeModel, QualityReport, QualitySettings, ReductionSettings,
    SelectionSettings, assess_telling, write_model,
};
use decore_model::system::LinearModel;
use decore_study::engine::{RowRunner, RowScene, reduction_settings};
use decore_study::{InterfaceDemand, StructureSettings, StructureSource, load_structure};

/// Frequencies in the first lines of the report.
const LOWEST: usize = 6;
/// The report of a model with more rows takes seconds: what looks wrong about its matrices is printed at once.
const SLOW_ROWS: usize = 20_000;

#[derive(Debug, Args)]
pub(super) struct StructureArguments {
    /// Study file (TOML), or a file with the table `[structure]` alone
    ///
    /// With a study, the hammers' mounts and the fixtures' points are the interface. A structure alone uses all its points, in all
    /// directions that have mass or stiffness.
    file: PathBuf,
    /// Set a value of the study, for example `structure.cutoff_hz=500`; repeatable
    #[arg(long = "set", value_name = "PATH=VALUE")]
    overrides: Vec<String>,
    /// Also run row 0 with all modes and with each selection, and show how the outputs change
    #[arg(long)]
    effects: bool,
    /// Print the report as JSON (schemas/structure.schema.json)
    ///
    /// With --export, print the list of written files (schemas/written.schema.json).
    #[arg(long)]
    json: bool,
    /// Also write the report as an HTML page with plots
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Compare with measured frequency responses (UFF, UNV or CSV file)
    ///
    /// The report is replaced by this comparison. UFF and UNV files need data sets 58. The machine stands without hammers.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["export", "effects"])]
    measured: Option<PathBuf>,
    /// With --measured: write the proposed damping ratios, for `damping_ratio_file`
    #[arg(long, value_name = "FILE", requires = "measured")]
    damping_to: Option<PathBuf>,
    // The help says: write the model's matrices in another format instead of a report.
    #[arg(long, value_name = "FORMAT", value_parser = export_format, requires = "to", help = export_help())]
    export: Option<ExportFormat>,
    /// With --export: folder for the matrices
    #[arg(long, value_name = "FOLDER", requires = "export")]
    to: Option<PathBuf>,
    /// Replace existing files of --html, --damping-to and --to
    ///
    /// Files that the study reads are never replaced.
    #[arg(long)]
    replace: bool,
}

fn export_help() -> String {
    format!("Write the model's matrices in another format instead of a report: {}. Needs --to", export_names(" or "))
}

/// The names of all forms in a sentence; `last`: the word before the last one.
fn export_names(last: &str) -> String {
    let names: Vec<&str> = ExportFormat::all().map(ExportFormat::name).collect();
    let (end, others) = names.split_last().map_or(("", &[][..]), |(end, others)| (*end, others));
    format!("{}{last}{end}", others.join(", "))
}

fn export_format(text: &str) -> Result<ExportFormat, String> {
    ExportFormat::named(text).ok_or_else(|| format!("expected one of {}", export_names(", ")))
}

pub(super) fn structure(arguments: &StructureArguments) -> Result<Exit, Failure> {
    expect_study(&arguments.file)?;
    let (settings, interface) = settings(arguments)?;
    let model = match &settings.source {
        StructureSource::Station => FeModel::station()?,
        StructureSource::Matrices(source) => FeModel::read(&source.files)?,
        StructureSource::ModalTable { .. } => {
            let reason = "a modal table is not reduced: there is no full model to compare with";
            return Err(Failure::Argument(reason.to_owned()));
        }
    };
    if let (Some(format), Some(folder)) = (arguments.export, &arguments.to) {
        return export(&model, format, folder, arguments.json);
    }
    if let Some(measured) = &arguments.measured {
        let asked = Asked { measured, damping_to: arguments.damping_to.as_deref(), json: arguments.json };
        let html = arguments.html.as_deref();
        if html.is_some() {
            return Err(Failure::Argument("--html does not go with --measured: it has no page; use --json".to_owned()));
        }
        let reduction = whole_interface(&model, &settings)?;
        return compare_with_measured(&model, &reduction, &settings, &asked);
    }
    let has_scene = interface.is_some();
    let reduction = interface.map_or_else(|| whole_interface(&model, &settings), Ok)?;
    let damping_ratio = settings.damping_ratio.ratio(0, TAU * settings.cutoff_hz).unwrap_or(0.0);
    let quality = QualitySettings { reduction, cutoff_hz: settings.cutoff_hz, damping_ratio };
    let report = assess_telling(&model, &quality, |remarks| {
        if model.order() > SLOW_ROWS {
            remarks.iter().for_each(|remark| eprint_line(&format_args!("warning: the machine looks wrong: {remark}")));
        }
    })?;
    if let Some(path) = &arguments.html {
        let title = format!("Reduction of {}", arguments.file.display());
        write_file(path, quality_page(&report, &title)?)?;
    }
    // The report is there at once, the selections take a while.
    let words = wants_words(arguments.json);
    if words {
        print_line(&readable(&report).trim_end())?;
    }
    let selections = if has_scene { selections(arguments)? } else { None };
    if words {
        selections.iter().try_for_each(|selections| print_line(&selections_text(selections)))?;
    }
    if arguments.json {
        print_json(&StructureResult { report, selections })?;
    } else {
        if let Some(path) = &arguments.html {
            print_line(&format_args!("\npage           {}", path.display()))?;
        }
        if matches!(&settings.source, StructureSource::Matrices(source) if source.cache) {
            print_line(&format_args!(
                "cache          runs keep reductions in {CACHE_FOLDER} beside the stiffness file"
            ))?;
        }
    }
    Ok(Exit::Done)
}

/// Quality of a reduction.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct StructureResult {
    #[serde(flatten)]
    report: QualityReport,
    /// Number of modes that the scene of the study's first row needs; null for a structure alone.
    selections: Option<Selections>,
}

/// Number of modes that a scene needs, out of the basis with housings.
#[derive(Debug, Serialize, JsonSchema)]
struct Selections {
    /// Receptances are compared up to this frequency in Hz.
    band_hz: f64,
    /// Lowest natural frequencies in Hz of the machine with its castings on their fixtures; without the moving bodies of the hammers.
    with_castings_hz: Vec<f64>,
    /// One entry per tolerance.
    tried: Vec<Selected>,
}

/// Modes for one tolerance.
#[derive(Debug, Serialize, JsonSchema)]
struct Selected {
    /// Error of receptances that is allowed, over static flexibility.
    tolerance: f64,
    /// Modes kept.
    kept: usize,
    /// Modes that there are.
    available: usize,
    /// Residual modes.
    residual: usize,
    /// Error of receptances that was reached, over static flexibility.
    reached: f64,
    /// Largest relative change of each main output against all modes; null unless asked for.
    changes: Option<BTreeMap<&'static str, Option<f64>>>,
}

/// How many modes the scene of a study's first row needs, by the error of the receptances between its points and, where
/// asked for, by what the outputs of a run move; `None` where the row describes no scene.
fn selections(arguments: &StructureArguments) -> Result<Option<Selections>, Failure> {
    const TOLERANCES: [f64; 5] = [1e-6, 1e-4, 1e-3, 1e-2, 1e-1];
    let mut overrides = arguments.overrides.clone();
    overrides.push("structure.mode_tolerance=0".to_owned());
    let engine = StudyArguments { file: &arguments.file, overrides: &overrides, outputs: &[] }.engine()?;
    let Ok(RowScene { scene, modes }) = engine.scene(0) else { return Ok(None) };
    let band_hz = engine.study().structure().mode_band_hz;
    let together = LinearModel::new(&scene, &modes).ok().and_then(|model| model.frequencies_hz().ok());
    let with_castings_hz = together.into_iter().flatten().take(LOWEST).collect();
    let reference = arguments.effects.then(|| run_row(&scene, &modes).metrics).flatten();
    let select = |tolerance: f64| -> Result<Selected, Failure> {
        let (selection, modes) = engine.machine_of(&scene).select(&scene, SelectionSettings { tolerance, band_hz })?;
        let changes = reference.as_ref().and_then(|reference| {
            let metrics = run_row(&scene, &modes).metrics?;
            let changes =
                main_differences(&metrics, reference).map(|change| Some(change).filter(|one| one.is_finite()));
            Some(MAIN_OUTPUTS.into_iter().zip(changes).collect())
        });
        Ok(Selected {
            tolerance,
            kept: selection.kept.len(),
            available: selection.available,
            residual: selection.residual.omega_rad_s.len(),
            reached: selection.bound,
            changes,
        })
    };
    let tried = TOLERANCES.into_iter().map(select).collect::<Result<_, _>>()?;
    Ok(Some(Selections { band_hz, with_castings_hz, tried }))
}

fn selections_text(selections: &Selections) -> String {
    let Selections { band_hz, with_castings_hz, tried } = selections;
    let effects = match tried.iter().any(|selected| selected.changes.is_some()) {
        true => format!("  largest change of {}", MAIN_OUTPUTS.join(", ")),
        false => String::new(),
    };
    let mut text = format!(
        "\nmodes for the scene of row 0 out of all of the basis, housings added; error of receptances up to {band_hz} Hz over static \
         flexibility\n{:>9} {:>6} {:>5} {:>9} {:>10}{effects}",
        "tolerance", "kept", "of", "residual", "reached"
    );
    for Selected { tolerance, kept, available, residual, reached, changes } in tried {
        text += &format!("\n{tolerance:>9.0e} {kept:>6} {available:>5} {residual:>9} {reached:>10.1e}");
        for change in MAIN_OUTPUTS.iter().filter_map(|name| changes.as_ref()?.get(name)) {
            text += &format!(" {:>8.0e}", change.unwrap_or(f64::NAN));
        }
    }
    let lowest: Vec<String> = with_castings_hz.iter().map(|hz| format!("{hz:.4}")).collect();
    text += &format!("\n\nwith castings  {} Hz", lowest.join(", "));
    text
}

/// Settings of the structure, and the study's demand on it.
fn settings(arguments: &StructureArguments) -> Result<(StructureSettings, Option<ReductionSettings>), Failure> {
    let names = arguments.export.map_or(Vec::new(), |format| format.files().to_vec());
    let to = Form::Folder { names: &names, replace: arguments.replace };
    let outputs = [
        Output {
            flag: "--html",
            path: arguments.html.as_deref(),
            form: Form::File { endings: &["html"], replace: arguments.replace },
        },
        Output {
            flag: "--damping-to",
            path: arguments.damping_to.as_deref(),
            form: Form::File { endings: &["csv"], replace: arguments.replace },
        },
        Output { flag: "--to", path: arguments.to.as_deref(), form: to },
    ];
    if let Some(settings) = load_structure(&arguments.file)? {
        if !arguments.overrides.is_empty() {
            return Err(Failure::Argument("--set needs a study; this file has the table [structure] alone".to_owned()));
        }
        let files = settings.source.files().into_iter().map(|(_, path)| path.to_path_buf());
        check_outputs(&files.chain([arguments.file.clone()]).collect::<Vec<_>>(), &outputs)?;
        return Ok((settings, None));
    }
    let study = StudyArguments { file: &arguments.file, overrides: &arguments.overrides, outputs: &outputs }.study()?;
    let reduction = reduction_settings(study.structure(), &InterfaceDemand::of(&study));
    Ok((study.structure().clone(), Some(reduction)))
}

/// All points in all directions that carry something there: solid elements leave rotations empty.
fn whole_interface(model: &FeModel, settings: &StructureSettings) -> Result<ReductionSettings, Failure> {
    let mut interface = Vec::new();
    for point in model.points().iter() {
        let rows = model.rows_of(&point.name)?;
        let known = (0..DOF_NAMES.len()).filter(|dof| rows[*dof].is_some_and(|row| model.carries(row)));
        interface.extend(known.map(|dof| (point.name.clone(), dof)));
    }
    Ok(ReductionSettings { interface, fixed_interface_cutoff_hz: settings.fixed_interface_cutoff_hz })
}

fn export(model: &FeModel, format: ExportFormat, folder: &Path, json: bool) -> Result<Exit, Failure> {
    let failed = |source| Failure::Write { path: folder.display().to_string(), source };
    std::fs::create_dir_all(folder).map_err(failed)?;
    let files = write_model(model, format, folder)?;
    let named = [
        ("stiffness", Some(&files.stiffness.path)),
        ("mass", Some(&files.mass.path)),
        ("damping", files.damping.as_ref().map(|damping| &damping.path)),
        ("rows", files.dofs.as_ref()),
        ("points", Some(&files.points)),
    ];
    let mut written = Written::default();
    let mut lines = Vec::new();
    for (kind, path) in named.into_iter().filter_map(|(kind, path)| Some((kind, path?))) {
        written.file(kind, path)?;
        lines.push(format!("{kind:<15}{}", path.display()));
    }
    if let Some(loss) = format.loss() {
        lines.push(format!("{:<15}{loss}", "note"));
        written.note(loss);
    }
    written.print(json, &lines.join("\n"))?;
    Ok(Exit::Done)
}

fn readable(report: &QualityReport) -> String {
    let facts = &report.facts;
    let mut lines = sense_lines(report);
    lines.extend([
        format!("model          {} rows, {} of them interface", facts.order, facts.interface),
        format!(
            "basis          {} and {}",
            plural(facts.interface, "constraint mode"),
            plural(facts.fixed_interface_hz.len(), "fixed-interface mode")
        ),
    ]);
    if facts.empty_rows > 0 {
        lines.push(format!("left out       {} without mass and stiffness", plural(facts.empty_rows, "row")));
    }
    if facts.shift_hz > 0.0 {
        lines.push(format!(
            "shift          the interface does not hold the structure; shifted by ({:.3} Hz)^2",
            facts.shift_hz
        ));
    }
    lines.push(format!(
        "\n{:>5} {:>13} {:>13} {:>11} {:>9}   effective mass x, y, z in % (full)",
        "mode", "full Hz", "reduced Hz", "error", "MAC"
    ));
    mode_lines(report, &mut lines);
    static_lines(report, &mut lines);
    effort_lines(report, &mut lines);
    lines.join("\n")
}

/// Figures that show at a glance whether the matrices are right.
fn sense_lines(report: &QualityReport) -> Vec<String> {
    let kg = |mass: f64| {
        if mass == 0.0 || (1e-3..1e9).contains(&mass) { format!("{mass:.6}") } else { format!("{mass:.6e}") }
    };
    let mass = match report.total_mass_kg {
        None => "not known: name a dof_file or dofs_per_node, which tell the directions of the rows".to_owned(),
        Some([x, y, z]) if (x - y).abs().max((x - z).abs()) <= 1e-3 * x => format!("{} kg", kg(x)),
        Some([x, y, z]) => format!("{} along x, {} along y, {} kg along z", kg(x), kg(y), kg(z)),
    };
    let centre = match (report.centre_of_mass_m, report.nodes_without_place) {
        (Some([x, y, z]), _) => format!("{x:.4}, {y:.4}, {z:.4} m"),
        (None, Some([0, _])) => "not known: there is no mass along x or y".to_owned(),
        (None, Some([unknown, all])) => {
            format!(
                "not known: {unknown} of {} with mass have no coordinates (a dof_file may give them)",
                plural(all, "node")
            )
        }
        (None, None) => "not known".to_owned(),
    };
    let lowest: Vec<String> = report.modes.iter().take(LOWEST).map(|mode| format!("{:.4}", mode.full_hz)).collect();
    let mut lines = vec![
        format!("mass           {mass}"),
        format!("centre of mass {centre}"),
        match lowest.is_empty() {
            true => "lowest modes   none below the cut-off".to_owned(),
            false => format!("lowest modes   {} Hz", lowest.join(", ")),
        },
    ];
    lines.extend(report.notes.iter().map(|note| format!("note           {note}")));
    lines.extend(report.remarks.iter().map(|remark| format!("looks wrong    {remark}")));
    lines.push(String::new());
    lines
}

fn mode_lines(report: &QualityReport, lines: &mut Vec<String>) {
    for (index, mode) in report.modes.iter().enumerate() {
        let error = mode.relative_error.map_or("rigid".to_owned(), |error| format!("{error:.2e}"));
        let mass = mode
            .effective_mass_full
            .map_or(String::new(), |share| share.map(|value| format!("{:7.2}", 100.0 * value)).join(" "));
        lines.push(format!(
            "{:>5} {:>13.5} {:>13.5} {error:>11} {:>9.6}   {mass}",
            index + 1,
            mode.full_hz,
            mode.reduced_hz,
            mode.mac
        ));
    }
}

fn static_lines(report: &QualityReport, lines: &mut Vec<String>) {
    if report.static_stiffness.is_empty() {
        lines.push("\nThe structure floats: no static stiffness.".to_owned());
    } else {
        lines.push(format!(
            "\n{:<16} {:>15} {:>15} {:>9}   static, N/m or N m/rad",
            "interface DOF", "full", "reduced", "error"
        ));
    }
    for one in &report.static_stiffness {
        lines.push(format!("{:<16} {:>15.6e} {:>15.6e} {:>9.1e}", one.dof, one.full, one.reduced, one.relative_error));
    }
    let last = report.frequency_hz.last().copied().unwrap_or(0.0);
    lines
        .push(format!("\nmobility: largest difference of the curves up to {last:.0} Hz, relative to the curve's peak"));
    for curve in &report.mobility {
        lines.push(format!("{:<16} {:<16} {:>9.1e}", curve.response, curve.force, curve.largest_relative_difference));
    }
}

fn effort_lines(report: &QualityReport, lines: &mut Vec<String>) {
    let facts = &report.facts;
    let number = |value: Option<f64>| value.map_or("none".to_owned(), |value| format!("{value:.1e}"));
    let conditions = &report.conditions;
    lines.push(format!(
        "\ncondition      full stiffness {}, inner {}, reduced {}, reduced mass {}",
        number(conditions.full_stiffness),
        number(conditions.inner_stiffness),
        number(conditions.reduced_stiffness),
        number(conditions.reduced_mass)
    ));
    lines.push(format!(
        "factor         {:.1} MB, Lanczos basis of {} columns",
        facts.factor_len as f64 * 8e-6,
        facts.lanczos_basis
    ));
    for step in &report.steps {
        let memory = step.peak_bytes.map_or(String::new(), |bytes| format!(", peak {:.0} MB", bytes as f64 / 1e6));
        lines.push(format!("{:>9.3} s    {}{memory}", step.time_s, step.name));
    }
}

//! `decore scene`: one row, all outputs.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;

use super::exit::{Exit, Failure, write_file};
use super::inputs::is_dataset;
use super::json::say_json;
use super::measured::{Calculated, ChannelBeside, MeasuredArguments, channels_text};
use super::outputs::{Form, Output, StudyArguments, check_outputs};
use super::scene_plot::{Picture, scene_plot};
use super::scene_result::SceneResult;
use super::stored::Stored;
use super::text::{check_row, say, six_digits, tell};
use crate::dataset::write_signals;
use crate::engine::{Engine, EngineError, Rows};
use crate::integrate::Counters;
use crate::metrics::{Blow, CastingMetrics, HammerMetrics, RunMetrics, RunTotals, ScatterOf, Signal, SignalRecorder};
use crate::page::{MeasuredCurve, SceneView, scene_page};
use crate::quantity::{Quantity, Value};
use crate::run::{RowOutcome, RowStatus};
use crate::scene::Scene;

/// Interval in s at which a plot reads the signals.
const PLOT_INTERVAL_S: f64 = 2e-5;

#[derive(Debug, Args)]
pub(super) struct SceneArguments {
    /// Study file (TOML), or the folder of a dataset: then its study is run as it was, and the row compared with the stored one.
    study: PathBuf,
    /// Row of the design.
    #[arg(short, long, default_value_t = 0)]
    row: usize,
    /// Set a value of the study, e.g. `hammer.left.supply_bar=4.5`; may be given several times.
    #[arg(long = "set", value_name = "PATH=VALUE")]
    overrides: Vec<String>,
    /// Print the outcome as JSON (schemas/scene.schema.json).
    #[arg(long)]
    json: bool,
    /// Also write time signals to this Parquet file.
    #[arg(long, value_name = "FILE")]
    signals: Option<PathBuf>,
    /// Also draw motions, casting, work and machine over time to this file (SVG).
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Also write the row as one page of HTML: the mechanism in motion, all signals, spectra, blows; needs no network.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Folder in which the file names of a dataset's study start.
    #[arg(long, default_value = ".", value_name = "FOLDER")]
    files_in: PathBuf,
    /// Interval of the time signals in s.
    #[arg(long, default_value_t = 1e-4, value_name = "SECONDS")]
    signal_interval_s: f64,
    #[command(flatten)]
    measured: MeasuredArguments,
}

pub(super) fn scene(arguments: &SceneArguments) -> Result<Exit, Failure> {
    let interval = arguments.signal_interval_s;
    if !(interval > 0.0 && interval.is_finite()) {
        return Err(Failure::Argument(format!("--signal-interval-s is {interval}, expected a positive number")));
    }
    let outputs = [
        Output { flag: "--signals", path: arguments.signals.as_deref(), form: Form::File(&["parquet"]) },
        Output { flag: "--plot", path: arguments.plot.as_deref(), form: Form::File(&["svg"]) },
        Output { flag: "--html", path: arguments.html.as_deref(), form: Form::File(&["html"]) },
    ];
    if let Some(measured) = arguments.measured.file() {
        check_outputs(std::slice::from_ref(measured), &outputs)?;
    }
    let named = StudyArguments { file: &arguments.study, overrides: &arguments.overrides, outputs: &outputs };
    let stored = is_dataset(&arguments.study).then(|| Stored::open(&arguments.study)).transpose()?;
    let engine = match &stored {
        Some(stored) => named.engine_of(stored.study(&arguments.files_in)?)?,
        None => named.engine()?,
    };
    // What is set over the stored study makes another row of it: there is nothing to compare with.
    let stored = stored.filter(|_| arguments.overrides.is_empty());
    let engine = match &stored {
        Some(stored) => stored.settle(engine),
        None => engine,
    };
    check_row(&engine, arguments.row)?;
    let (outcome, channels) = simulate(&engine, arguments)?;
    let comparison = stored.map(|stored| stored.compare(&engine, arguments.row, &outcome)).transpose()?;
    if arguments.json {
        say_json(&SceneResult::of(&engine, arguments.row, &outcome, comparison).beside(channels))?;
    } else {
        say(&readable(&engine, arguments.row, &outcome).trim_end())?;
        comparison.map_or(Ok(()), |comparison| say(&comparison.text()))?;
        if !channels.is_empty() {
            say(&channels_text(&channels).trim_end())?;
        }
    }
    Ok(if outcome.status == RowStatus::Done { Exit::Done } else { Exit::RowsFailed })
}

/// The row's outcome, and measured channels beside its signals.
fn simulate(engine: &Engine, arguments: &SceneArguments) -> Result<(RowOutcome, Vec<ChannelBeside>), Failure> {
    let Some(interval_s) = interval_s(engine, arguments) else {
        return Ok((engine.outcome(arguments.row), Vec::new()));
    };
    let (outcome, signals) = engine.outcome_with_signals(arguments.row, interval_s).map_err(|error| match error {
        EngineError::Signals { .. } => Failure::Argument(format!("--signal-interval-s {interval_s:e}: {error}")),
        error => error.into(),
    })?;
    let Some(signals) = signals else { return Ok((outcome, Vec::new())) };
    let scene = engine.checked().scene(arguments.row).map_err(|invalid| Failure::Argument(invalid.reason))?;
    let blows = outcome.metrics.as_ref().map_or(&[][..], |metrics| &metrics.blows);
    let channels = arguments.measured.beside(Calculated { scene: &scene, blows, signals: &signals, interval_s })?;
    if let Some(path) = &arguments.signals {
        write_signals(path, &engine.info(), &signals)?;
        tell(&format_args!("signals are in {}", path.display()));
    }
    if let Some(path) = &arguments.plot {
        let study = engine.study();
        let title = format!("{}, row {}", study.title(), arguments.row);
        let picture = Picture { title, hammers: study.hammer_names(), signals: &signals, blows };
        write_file(path, scene_plot(&picture)?)?;
        tell(&format_args!("the plot is in {}", path.display()));
    }
    if let Some(path) = &arguments.html {
        let shown = Shown { scene: &scene, signals: &signals, interval_s, channels: &channels };
        let page = page(engine, arguments.row, &outcome, shown)?;
        write_file(path, &page)?;
        tell(&format_args!("the page is in {} ({:.1} MB)", path.display(), page.len() as f64 / 1e6));
    }
    Ok((outcome, channels))
}

/// Interval in s at which signals are read; `None` where nothing asks for them. Beside a table all shows what the table has; by itself
/// a picture shows the peaks of short contacts, and a page what it has room for.
fn interval_s(engine: &Engine, arguments: &SceneArguments) -> Option<f64> {
    if arguments.signals.is_some() {
        return Some(arguments.signal_interval_s);
    }
    let page = |scene: Scene| SceneView::page_interval_s(SignalRecorder::count(&scene), scene.duration_s);
    let scene = arguments.html.as_ref().and_then(|_| engine.checked().scene(arguments.row).ok());
    let plot = arguments.plot.as_ref().map(|_| arguments.signal_interval_s.min(PLOT_INTERVAL_S));
    let shown = arguments.html.is_some() || arguments.measured.is_given();
    scene.map(page).or(plot).or(shown.then_some(PLOT_INTERVAL_S))
}

/// What a row's page shows over time.
struct Shown<'a> {
    scene: &'a Scene,
    signals: &'a [Signal],
    interval_s: f64,
    channels: &'a [ChannelBeside],
}

/// A row's page.
fn page(
    engine: &Engine,
    row: usize,
    outcome: &RowOutcome,
    Shown { scene, signals, interval_s, channels }: Shown<'_>,
) -> Result<String, Failure> {
    let (info, factors) = (engine.info(), engine.checked().row_values(row));
    let measured = channels.iter().map(|channel| MeasuredCurve {
        signal: &channel.signal,
        column: &channel.column,
        from_s: channel.beside.from_s,
        values: &channel.beside.measured,
        spikes_s: &channel.beside.spikes_s,
    });
    let measured: Vec<MeasuredCurve<'_>> = measured.collect();
    let view =
        SceneView { info: &info, row, factors: &factors, scene, outcome, signals, interval_s, measured: &measured };
    Ok(scene_page(&view)?)
}

/// The outcome as text; writing to a string cannot fail.
fn readable(engine: &Engine, row: usize, outcome: &RowOutcome) -> String {
    let study = engine.study();
    let mut text = format!("{}, row {row}: {}\n", study.title(), outcome.status.name());
    if !outcome.reason.is_empty() {
        let _ = writeln!(text, "  {}; time reached: {} s", outcome.reason, six_digits(outcome.time_reached_s));
    }
    for setting in study.overrides() {
        let _ = writeln!(text, "  set {setting}");
    }
    for (factor, value) in study.factors().iter().zip(engine.checked().row_values(row)) {
        let value = match value {
            Value::Real(value) => six_digits(value),
            other => other.to_string(),
        };
        let unit = factor.unit.as_deref().map_or(String::new(), |unit| format!(" {unit}"));
        let _ = writeln!(text, "  {} = {value}{unit}", factor.name);
    }
    if let Some(metrics) = &outcome.metrics {
        outputs(&mut text, engine, metrics);
    }
    if outcome.states == 0 {
        return text;
    }
    let counted = Counters::QUANTITIES.iter().filter_map(|counter| match (counter.value)(&outcome.counters)? {
        Value::Count(0) => None,
        count => Some(format!("{count} {}, ", counter.name.replace('_', " "))),
    });
    let (modes, states, wall_time_s) = (outcome.modes, outcome.states, outcome.wall_time_s);
    let _ = writeln!(text, "{modes} modes, {states} states, {}{wall_time_s:.2} s", counted.collect::<String>());
    text
}

/// All outputs, with their scatter where the row has twins.
fn outputs(text: &mut String, engine: &Engine, metrics: &RunMetrics) {
    let study = engine.study();
    let scatter = metrics.scatter.as_ref();
    for (h, (name, hammer)) in study.hammer_names().iter().zip(&metrics.hammers).enumerate() {
        let scatter = scatter.and_then(|scatter| scatter.hammers.get(h));
        let _ = writeln!(text, "\nhammer {name}");
        section(text, HammerMetrics::QUANTITIES, hammer, scatter);
    }
    for (c, (name, casting)) in study.casting_names().iter().zip(&metrics.castings).enumerate() {
        let scatter = scatter.and_then(|scatter| scatter.castings.get(c));
        let _ = writeln!(text, "\ncasting {name}");
        section(text, CastingMetrics::QUANTITIES, casting, scatter);
    }
    let twins = scatter.map_or(String::new(), |scatter| format!(" (+- over the row and {} twins)", scatter.twins_done));
    let totals = scatter.map(|scatter| &scatter.totals);
    let _ = writeln!(text, "\nrun{twins}");
    section(text, RunTotals::QUANTITIES, &metrics.totals, totals);
    blows(text, study.hammer_names().as_slice(), metrics);
    let _ = writeln!(text);
}

fn section<T>(text: &mut String, quantities: &[Quantity<T>], metrics: &T, scatter: Option<&ScatterOf>) {
    for quantity in quantities {
        let (value, unit) = match (quantity.value)(metrics) {
            None => ("-".to_owned(), "1"),
            Some(Value::Real(value)) => (six_digits(value), quantity.unit),
            Some(other) => (other.to_string(), quantity.unit),
        };
        let unit = if unit == "1" { "" } else { unit };
        let moved = scatter.and_then(|scatter| scatter.get(quantity.name).copied().flatten());
        let moved = match (quantity.kind, moved) {
            (_, None) => String::new(),
            (kind, Some(share)) if kind.is_text() => format!("  another kind in {:.0} %", 100.0 * share),
            (_, Some(moved)) => format!("  +- {moved:.1e}"),
        };
        let line = format!("  {:<46} {value:>12} {unit:<4}{moved}", quantity.name);
        let _ = writeln!(text, "{}", line.trim_end());
    }
}

/// The blows as a table: the figures that have a heading.
fn blows(text: &mut String, hammers: &[&str], metrics: &RunMetrics) {
    let headed = Blow::QUANTITIES.iter().filter_map(|figure| Some((figure, figure.heading?)));
    let figures: Vec<(&Quantity<Blow>, String)> =
        headed.map(|(figure, heading)| (figure, format!("{heading} {}", figure.unit))).collect();
    let width = |heading: &str| heading.len().max(10);
    let _ = write!(text, "\nblows\n  {:<14} {:>4} {:>6} {:<13}", "hammer", "no.", "stroke", "kind");
    for (_, heading) in &figures {
        let _ = write!(text, " {heading:>0$}", width(heading));
    }
    for blow in &metrics.blows {
        let (hammer, kind) = (hammers.get(blow.hammer).copied().unwrap_or(""), blow.kind.name().replace('_', " "));
        let _ = write!(text, "\n  {hammer:<14} {:>4} {:>6} {kind:<13}", blow.number, blow.stroke);
        for (figure, heading) in &figures {
            let value = (figure.value)(blow).and_then(|value| value.number()).unwrap_or(f64::NAN);
            let decimals = match figure.unit {
                "s" => 6,
                "N" => 1,
                _ => 4,
            };
            let _ = write!(text, " {value:>0$.decimals$}", width(heading));
        }
    }
    let _ = writeln!(text);
}

//! `decore scene`: one row, all outputs.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;

use super::exit::{Exit, Failure, write_file};
use super::inputs::is_dataset;
use super::json::{print_json, wants_words};
use super::measured::{Calculated, ChannelBeside, MeasuredArguments, channels_text};
use super::outputs::{Form, Output, StudyArguments, check_outputs};
use super::scene_plot::{Picture, scene_plot};
use super::scene_result::SceneResult;
use super::stored::Stored;
use super::text::{check_row, eprint_line, print_line, six_digits};
use crate::page::{MeasuredCurve, MeasuredPiece, SceneView, Site, scene_page};
use decore_dataset::write_signals;
use decore_model::integrate::Counters;
use decore_model::metrics::{
    Blow, CastingMetrics, CoreMetrics, CoreTotals, ElasticMetrics, FixtureMetrics, HammerMetrics, NumericalErrors,
    PadMetrics, RunMetrics, RunTotals, ScatterOf, Signal, SignalRecorder, Warning,
};
use decore_model::run::{RowOutcome, RowStatus};
use decore_model::scene::Scene;
use decore_quantity::{Quantity, Value};
use decore_study::engine::{Engine, EngineError, RowRunner};

#[derive(Debug, Args)]
pub(super) struct SceneArguments {
    /// Study file (TOML), or folder of a dataset
    ///
    /// With a dataset, its study is run as it was, and the row is compared with the stored one.
    study: PathBuf,
    /// Row of the design
    #[arg(short, long, default_value_t = 0)]
    row: usize,
    /// Set a value of the study, for example `hammer.left.supply_bar=4.5`; repeatable
    #[arg(long = "set", value_name = "PATH=VALUE")]
    overrides: Vec<String>,
    /// Print the outputs as JSON (schemas/scene.schema.json)
    #[arg(long)]
    json: bool,
    /// Also write the signals over time to this Parquet file
    #[arg(long, value_name = "FILE")]
    signals: Option<PathBuf>,
    /// Also draw the motion, casting, work and machine over time (SVG)
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Also write the row as an HTML page: animation, plan and side views, all signals, spectra, blows
    ///
    /// The page needs no network.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Replace existing files of --signals, --plot and --html
    #[arg(long)]
    replace: bool,
    /// With a dataset: folder that contains the files its study names
    #[arg(long, default_value = ".", value_name = "FOLDER")]
    files_in: PathBuf,
    /// Interval of the signals that --signals writes, in s
    ///
    /// Plots and comparisons use their own interval.
    #[arg(long, default_value_t = 1e-4, value_name = "SECONDS", requires = "signals")]
    signal_interval_s: f64,
    #[command(flatten)]
    measured: MeasuredArguments,
}

impl SceneArguments {
    /// Whether signals are drawn or compared.
    fn shows(&self) -> bool {
        self.plot.is_some() || self.html.is_some() || self.measured.is_given()
    }
}

pub(super) fn scene(arguments: &SceneArguments) -> Result<Exit, Failure> {
    let interval = arguments.signal_interval_s;
    if !(interval > 0.0 && interval.is_finite()) {
        return Err(Failure::Argument(format!("--signal-interval-s is {interval}, expected a positive number")));
    }
    let outputs = [
        Output {
            flag: "--signals",
            path: arguments.signals.as_deref(),
            form: Form::File { endings: &["parquet"], replace: arguments.replace },
        },
        Output {
            flag: "--plot",
            path: arguments.plot.as_deref(),
            form: Form::File { endings: &["svg"], replace: arguments.replace },
        },
        Output {
            flag: "--html",
            path: arguments.html.as_deref(),
            form: Form::File { endings: &["html"], replace: arguments.replace },
        },
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
    if wants_words(arguments.json) {
        print_line(&readable(&engine, arguments.row, &outcome).trim_end())?;
        comparison.as_ref().map_or(Ok(()), |comparison| print_line(&comparison.text()))?;
        if !channels.is_empty() {
            print_line(&channels_text(&channels).trim_end())?;
        }
    }
    if arguments.json {
        print_json(&SceneResult::of(&engine, arguments.row, &outcome, comparison).beside(channels))?;
    }
    Ok(if outcome.status == RowStatus::Done { Exit::Done } else { Exit::RowsFailed })
}

/// The longest interval in s of signals that are compared with a measurement: the low-pass of 4 kHz needs eight thousand values a
/// second.
const COMPARED_INTERVAL_S: f64 = 1e-4;

/// The row's outcome, and measured channels beside its signals. What is shown has an interval of its own, whether signals are
/// written or not: where theirs is another one the row is run for each, which gives the same outcome.
fn simulate(engine: &Engine, arguments: &SceneArguments) -> Result<(RowOutcome, Vec<ChannelBeside>), Failure> {
    let row = arguments.row;
    let written_s = arguments.signals.as_ref().map(|_| arguments.signal_interval_s);
    let scene = engine.checked().scene(row).ok().filter(|_| arguments.shows());
    let most_s = if arguments.measured.is_given() { COMPARED_INTERVAL_S } else { f64::INFINITY };
    let shown_s = scene
        .as_ref()
        .map(|scene| SceneView::page_interval_s(SignalRecorder::count(scene), scene.duration_s).min(most_s));
    let mut intervals_s: Vec<f64> = written_s.into_iter().chain(shown_s).collect();
    intervals_s.dedup();
    // Signals that would not fit are refused before the row is run for anything else.
    let runs = intervals_s.into_iter().map(|interval_s| recorded(engine, row, interval_s));
    let mut runs = runs.collect::<Result<Vec<_>, Failure>>()?;
    let shown = runs.last().zip(scene.as_ref().zip(shown_s));
    let shown = shown.and_then(|((outcome, signals), (scene, interval_s))| {
        Some(DrawnRow { outcome, scene, signals: signals.as_deref()?, interval_s })
    });
    // A channel that is none is refused before anything is written.
    let channels = shown.as_ref().map_or(Ok(Vec::new()), |shown| shown.channels(&arguments.measured))?;
    if let (Some(path), Some((_, Some(signals)))) = (&arguments.signals, runs.first()) {
        write_signals(path, &engine.info(), signals)?;
        eprint_line(&format_args!("signals are in {}", path.display()));
    }
    shown.map_or(Ok(()), |shown| shown.draw((engine, arguments), &channels))?;
    Ok((runs.pop().map_or_else(|| engine.outcome(row), |(outcome, _)| outcome), channels))
}

/// The row's outcome with its signals every `interval_s`; none of a row that does not reach its end.
fn recorded(engine: &Engine, row: usize, interval_s: f64) -> Result<(RowOutcome, Option<Vec<Signal>>), Failure> {
    engine.outcome_with_signals(row, interval_s).map_err(|error| match error {
        EngineError::Signals { .. } => Failure::Argument(format!("--signal-interval-s {interval_s:e}: {error}")),
        error => error.into(),
    })
}

/// Signals of a row that are drawn or compared with a measurement.
struct DrawnRow<'a> {
    outcome: &'a RowOutcome,
    scene: &'a Scene,
    signals: &'a [Signal],
    interval_s: f64,
}

impl DrawnRow<'_> {
    fn blows(&self) -> &[Blow] {
        self.outcome.metrics.as_ref().map_or(&[], |metrics| &metrics.blows)
    }

    fn channels(&self, measured: &MeasuredArguments) -> Result<Vec<ChannelBeside>, Failure> {
        let DrawnRow { scene, signals, interval_s, .. } = *self;
        measured.beside(Calculated { scene, blows: self.blows(), signals, interval_s })
    }

    /// Writes the plot and the page that are asked for.
    fn draw(&self, (engine, arguments): (&Engine, &SceneArguments), channels: &[ChannelBeside]) -> Result<(), Failure> {
        if let Some(path) = &arguments.plot {
            let study = engine.study();
            let title = format!("{}, row {}", study.title(), arguments.row);
            let (signals, blows) = (self.signals, self.blows());
            write_file(path, scene_plot(&Picture { title, hammers: study.hammer_names(), signals, blows })?)?;
            eprint_line(&format_args!("the plot is in {}", path.display()));
        }
        if let Some(path) = &arguments.html {
            let page = self.page(engine, arguments.row, channels)?;
            write_file(path, &page)?;
            eprint_line(&format_args!("the page is in {} ({:.1} MB)", path.display(), page.len() as f64 / 1e6));
        }
        Ok(())
    }

    fn page(&self, engine: &Engine, row: usize, channels: &[ChannelBeside]) -> Result<String, Failure> {
        let DrawnRow { outcome, scene, signals, interval_s } = *self;
        let (info, factors) = (engine.info(), engine.checked().row_values(row));
        let measured = channels.iter().map(|channel| MeasuredCurve {
            signal: &channel.signal,
            column: &channel.column,
            pieces: (channel.beside.pieces.iter())
                .map(|piece| MeasuredPiece { first: piece.first, values: &piece.measured })
                .collect(),
            spikes_s: &channel.beside.spikes_s,
        });
        let measured: Vec<MeasuredCurve<'_>> = measured.collect();
        let site = Site {
            rails: engine.study().rails().collect(),
            points: engine.checked().points(),
            extents_m: (0..scene.castings.len())
                .map(|casting| engine.machine_of(scene).casting_extent_m(casting))
                .collect(),
        };
        let view = SceneView {
            info: &info,
            row,
            factors: &factors,
            scene,
            outcome,
            signals,
            interval_s,
            measured: &measured,
            site: &site,
        };
        Ok(scene_page(&view)?)
    }
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
        for warning in Warning::of(&metrics.totals.warnings) {
            let _ = writeln!(text, "  warning: {}", warning.advice());
        }
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

/// All outputs, with their scatter where the row has twins and their numerical error where it has a numerical twin.
fn outputs(text: &mut String, engine: &Engine, metrics: &RunMetrics) {
    let study = engine.study();
    let (scatter, numerical) = (metrics.scatter.as_ref(), metrics.numerical.as_ref());
    for (h, (name, hammer)) in study.hammer_names().iter().zip(&metrics.hammers).enumerate() {
        let scatter = scatter.and_then(|scatter| scatter.hammers.get(h));
        let errors = numerical.and_then(|numerical| numerical.hammers.get(h));
        let _ = writeln!(text, "\nhammer {name}");
        section(text, HammerMetrics::QUANTITIES, hammer, TwinFigures { scatter, errors });
    }
    for (c, (name, casting)) in study.casting_names().iter().zip(&metrics.castings).enumerate() {
        let scatter = scatter.and_then(|scatter| scatter.castings.get(c));
        let errors = numerical.and_then(|numerical| numerical.castings.get(c));
        let _ = writeln!(text, "\ncasting {name}");
        section(text, CastingMetrics::QUANTITIES, casting, TwinFigures { scatter, errors });
    }
    for (name, elastic) in study.elastic_names().iter().zip(&metrics.elastic) {
        let _ = writeln!(text, "\nelastic casting {name}");
        section(text, ElasticMetrics::QUANTITIES, elastic, TwinFigures::default());
    }
    for ((casting, fixture), pad) in study.pads().into_iter().zip(&metrics.pads) {
        let _ = writeln!(text, "\nfixture {fixture} of casting {casting}");
        section(text, PadMetrics::QUANTITIES, pad, TwinFigures::default());
    }
    for (name, fixture) in study.fixture_names().iter().zip(&metrics.fixtures) {
        let _ = writeln!(text, "\nfixture {name}");
        section(text, FixtureMetrics::QUANTITIES, fixture, TwinFigures::default());
    }
    for (name, core) in study.core_names().iter().zip(&metrics.cores) {
        let _ = writeln!(text, "\ncore point {name}");
        section(text, CoreMetrics::QUANTITIES, core, TwinFigures::default());
    }
    if let Some(totals) = &metrics.core_totals {
        let _ = writeln!(text, "\nall core points");
        section(text, CoreTotals::QUANTITIES, totals, TwinFigures::default());
    }
    let twins = scatter.map_or(String::new(), |scatter| format!(" (+- over the row and {} twins)", scatter.twins_done));
    let beside = TwinFigures {
        scatter: scatter.map(|scatter| &scatter.totals),
        errors: numerical.map(|numerical| &numerical.totals),
    };
    let _ = writeln!(text, "\nrun{twins}");
    section(text, RunTotals::QUANTITIES, &metrics.totals, beside);
    numerical.into_iter().for_each(|numerical| numerical_twin(text, numerical));
    blows(text, study.hammer_names().as_slice(), metrics);
    let _ = writeln!(text);
}

/// Figures that twins give beside the outputs of one hammer, one casting or the run.
#[derive(Clone, Copy, Default)]
struct TwinFigures<'a> {
    scatter: Option<&'a ScatterOf>,
    /// Numerical errors.
    errors: Option<&'a ScatterOf>,
}

/// Numerical errors of a row as text.
fn numerical_twin(text: &mut String, numerical: &NumericalErrors) {
    let words = match (numerical.numerical_errors_beyond_promise, numerical.worst_numerical_error_over_promise) {
        (None, _) | (_, None) => "it did not reach its end: the numerical errors are not known".to_owned(),
        (Some(0), _) => "no error is beyond the promise of the preset".to_owned(),
        (Some(count), Some(worst)) => {
            format!("BEYOND the promise of the preset in {count} outputs, at worst {} times", six_digits(worst))
        }
    };
    let _ = writeln!(text, "\nnumerical twin: {words} (`decore help accuracy`)");
}

fn section<T>(text: &mut String, quantities: &[Quantity<T>], metrics: &T, beside: TwinFigures<'_>) {
    for quantity in quantities {
        let (value, unit) = match (quantity.value)(metrics) {
            None => ("-".to_owned(), "1"),
            Some(Value::Real(value)) => (six_digits(value), quantity.unit),
            Some(other) => (other.to_string(), quantity.unit),
        };
        let unit = if unit == "1" { "" } else { unit };
        let of = |all: Option<&ScatterOf>| all.and_then(|all| all.get(quantity.name).copied().flatten());
        let (moved, error) = (of(beside.scatter), of(beside.errors));
        let moved = match (quantity.kind, moved) {
            (_, None) => String::new(),
            (kind, Some(share)) if kind.is_text() => format!("  another kind in {:.0} %", 100.0 * share),
            (_, Some(moved)) => format!("  +- {moved:.1e}"),
        };
        let error = match error {
            None => String::new(),
            Some(error) if quantity.kind.is_text() && error == 0.0 => String::new(),
            Some(_) if quantity.kind.is_text() => "  another kind in its numerical twin".to_owned(),
            Some(error) => format!("  numerical error {error:.1e}"),
        };
        let line = format!("  {:<46} {value:>12} {unit:<4}{moved}{error}", quantity.name);
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

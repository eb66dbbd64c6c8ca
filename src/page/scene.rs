//! Page of a row, drawn by `src/assets/pages/scene.js`.

use std::ops::Range;

use serde::Serialize;

use super::blocks::{Scripts, page};
use super::error::PageError;
use super::samples::{Samples, Scale};
use super::site::{DrawnCasting, DrawnHammer, Named, Site, follows, rails_plan};
use decore_dataset::DatasetInfo;
use decore_model::metrics::{
    Blow, CastingMetrics, CoreMetrics, CoreSpectrum, CoreTotals, ElasticMetrics, FixtureMetrics, FixtureSignals,
    HammerMetrics, HammerSignals, PadMetrics, Phase, RunTotals, Signal, SignalOf, spectrum_frequencies_hz,
};
use decore_model::run::RowOutcome;
use decore_model::scene::Scene;
use decore_quantity::{Quantity, Value};
use decore_statistics::signal::Spectrum;

/// Least interval in s at which a page reads the signals.
const LEAST_INTERVAL_S: f64 = 2e-5;
/// Values of all signals that a page carries, about.
const MOST_VALUES: f64 = 1.6e7;
/// Frequency in Hz up to which a page has spectra: as far as the paper's figures go.
const MOST_FREQUENCY_HZ: f64 = 1000.0;
/// Least samples that a spectrum is taken of.
const LEAST_SAMPLES: usize = 64;
/// Share of its force at rest below which a pad carries nothing.
const NOTHING: f64 = 1e-6;
/// Signals that have spectra.
const WITH_SPECTRA: [&str; 3] = [
    HammerSignals::arm_velocity_m_s.name,
    HammerSignals::chisel_velocity_m_s.name,
    HammerSignals::casting_velocity_m_s.name,
];

/// Data of a row's page.
#[derive(Debug, Clone, Copy)]
pub struct SceneView<'a> {
    /// Information on the study.
    pub info: &'a DatasetInfo,
    /// The row's index.
    pub row: usize,
    /// Values of the study's factors in the row.
    pub factors: &'a [Value],
    /// The row's scene.
    pub scene: &'a Scene,
    /// Outcome of the row.
    pub outcome: &'a RowOutcome,
    /// Signals, time first, one value every [`SceneView::interval_s`].
    pub signals: &'a [Signal],
    /// Interval of the signals in s.
    pub interval_s: f64,
    /// Measured curves to lay over the signals that they measure.
    pub measured: &'a [MeasuredCurve<'a>],
    /// Places of the machine and its castings.
    pub site: &'a Site<'a>,
}

/// A measured channel on the row's time, at the interval of the signals.
#[derive(Debug, Clone)]
pub struct MeasuredCurve<'a> {
    /// Name of the signal that it measures.
    pub signal: &'a str,
    /// Name of the column.
    pub column: &'a str,
    /// Pieces of the measurement: one, or several with gaps between them.
    pub pieces: Vec<MeasuredPiece<'a>>,
    /// Times in s of samples that stand out by themselves.
    pub spikes_s: &'a [f64],
}

/// A part of a measured channel without a gap.
#[derive(Debug, Clone, Copy)]
pub struct MeasuredPiece<'a> {
    /// Index of the signal's value at its first value.
    pub first: usize,
    /// Values in the signal's unit.
    pub values: &'a [f64],
}

/// Metadata of a page.
#[derive(Serialize)]
struct Meta<'a> {
    title: &'a str,
    row: usize,
    study_hash: &'a str,
    seed: u64,
    version: &'a str,
    overrides: &'a [String],
    inputs: Vec<(&'a String, &'a String)>,
    study_text: &'a str,
    factors: Vec<(&'a str, String, &'a str)>,
    status: &'static str,
    reason: &'a str,
    duration_s: f64,
    ambient_pa: f64,
    interval_s: f64,
    samples: usize,
    signals: Vec<Stored<'a>>,
    hammers: Vec<DrawnHammer<'a>>,
    castings: Vec<DrawnCasting<'a>>,
    rails: Vec<Named<Vec<[f64; 2]>>>,
    machine_points: Vec<Named<[f64; 2]>>,
    points: &'a [String],
    figures: Vec<BlowColumn>,
    blows: Vec<Struck>,
    outputs: Vec<Output>,
    spectra: Vec<Spectra<'a>>,
    shocks: Shocks,
    lifted: Vec<Lifted>,
    measured: Vec<Curve<'a>>,
}

/// Times during which a pad carries nothing, to the interval of the signals.
#[derive(Serialize)]
struct Lifted {
    casting: usize,
    fixture: usize,
    /// Begin and end of each lift-off, s.
    spans_s: Vec<[f64; 2]>,
}

/// Shock spectra of the core points.
#[derive(Serialize)]
struct Shocks {
    frequencies_hz: Vec<f64>,
    /// Name of each point, its largest pseudo-velocities in m/s within the first impact's window and in the run.
    cores: Vec<(String, CoreSpectrum)>,
}

/// A measured curve of the data block: signal and parts.
#[derive(Serialize)]
struct Curve<'a> {
    of: SignalOf,
    quantity: &'static str,
    column: &'a str,
    pieces: Vec<CurvePiece>,
    spikes_s: &'a [f64],
}

/// A part of a measured curve: where its numbers begin, how many.
#[derive(Serialize)]
struct CurvePiece {
    from_s: f64,
    offset: usize,
    count: usize,
}

/// A signal of the data block; the first takes the first bytes.
#[derive(Serialize)]
struct Stored<'a> {
    of: SignalOf,
    quantity: &'static str,
    unit: &'static str,
    text: &'a str,
    scale: Scale,
}

/// A column of the table of blows.
#[derive(Serialize)]
struct BlowColumn {
    name: &'static str,
    heading: &'static str,
    unit: &'static str,
    text: String,
}

/// A blow: its hammer, kind and figures, in the order of the columns.
#[derive(Serialize)]
struct Struck {
    hammer: usize,
    number: usize,
    kind: &'static str,
    start_s: f64,
    figures: Vec<Option<f64>>,
}

/// An output of the row.
#[derive(Serialize)]
struct Output {
    of: String,
    name: &'static str,
    value: Option<String>,
    unit: &'static str,
    text: String,
}

/// Spectrum of a signal over a phase, or of its measurement.
#[derive(Serialize)]
struct Spectra<'a> {
    hammer: usize,
    quantity: &'static str,
    name: &'a str,
    unit: &'static str,
    phase: &'static str,
    from_s: f64,
    to_s: f64,
    /// Begin and end of the phase, where the signals have less of it in common.
    cut_from_s: Option<[f64; 2]>,
    #[serde(flatten)]
    lines: Lines,
    measured: Vec<MeasuredLines<'a>>,
}

/// Lines of a measured curve over the same phase; none if it covers too little of it.
#[derive(Serialize)]
struct MeasuredLines<'a> {
    column: &'a str,
    lines: Option<Lines>,
}

/// A spectrum among the page's data.
#[derive(Serialize)]
struct Lines {
    resolution_hz: f64,
    offset: usize,
    count: usize,
}

impl SceneView<'_> {
    /// Interval in s of the displayed values of `signals` signals over `duration_s`: 20 us, which shows the peaks of short contacts; longer
    /// for long scenes with many signals.
    pub fn page_interval_s(signals: usize, duration_s: f64) -> f64 {
        (duration_s * signals as f64 / MOST_VALUES).max(LEAST_INTERVAL_S)
    }
}

/// A row as a page, whole in one file: signals, spectra, blows, and the mechanism as it moves.
///
/// # Errors
/// [`PageError`] if its data cannot be written.
pub fn scene_page(view: &SceneView<'_>) -> Result<String, PageError> {
    let SceneView { info, scene, outcome, .. } = view;
    let samples = view.signals.first().map_or(0, |time| time.values.len());
    let mut data = Samples::default();
    let mut signals = Vec::new();
    // The first is time: a multiple of the interval.
    let stored = view.signals.iter().skip(1).filter(|signal| !follows(scene, signal.of, signal.quantity));
    for signal in stored {
        let Signal { of, quantity, unit, description, .. } = signal;
        signals.push(Stored {
            of: *of,
            quantity,
            unit,
            text: description,
            scale: data.signal(&signal.values, signal.unit),
        });
    }
    let blows = outcome.metrics.as_ref().map_or(&[][..], |metrics| &metrics.blows);
    let spectra = spectra(view, blows, &mut data);
    let measured = measured(view, &mut data);
    let title = format!("{}, row {}", info.study_name, view.row);
    let meta = Meta {
        title: &title,
        row: view.row,
        study_hash: &info.study_hash,
        seed: info.seed,
        version: &info.program_version,
        overrides: &info.overrides,
        inputs: info.inputs.iter().collect(),
        study_text: &info.study_text,
        factors: factors(view),
        status: outcome.status.name(),
        reason: &outcome.reason,
        duration_s: scene.duration_s,
        ambient_pa: scene.environment.ambient_pressure_pa,
        interval_s: view.interval_s,
        samples,
        signals,
        hammers: view.site.hammers(scene),
        castings: view.site.castings(scene),
        rails: rails_plan(view.site.rails.iter().copied(), view.site.points),
        machine_points: view.site.points_plan(scene),
        points: &view.scene.outputs.points,
        figures: Blow::QUANTITIES.iter().filter_map(figure).collect(),
        blows: blows.iter().map(struck).collect(),
        outputs: outputs(view),
        spectra,
        shocks: shocks(view),
        lifted: lifted(view),
        measured,
    };
    Ok(page(&title, Scripts::Scene, &meta, &data.deflated()?)?)
}

/// Lift-offs of the pads, by the signals of their forces, which are 0 at rest.
fn lifted(view: &SceneView<'_>) -> Vec<Lifted> {
    let pads = view.scene.fixtures().filter(|(_, fixture)| fixture.one_sided);
    let outputs = view.outcome.metrics.iter().flat_map(|metrics| &metrics.pads);
    let spans = |(casting, fixture): (usize, usize), rest_force_n: f64| {
        let is_it = |signal: &&Signal| {
            signal.of == SignalOf::Fixture(casting, fixture) && signal.quantity == FixtureSignals::force_n.name
        };
        let force = view.signals.iter().find(is_it).map_or(&[][..], |signal| &signal.values);
        let is_off = |force: &f64| force + rest_force_n <= NOTHING * rest_force_n;
        let mut spans = Vec::new();
        let mut first = 0;
        for run in force.chunk_by(|a, b| is_off(a) == is_off(b)) {
            if run.first().is_some_and(is_off) {
                spans.push([first, first + run.len() - 1].map(|at| view.interval_s * at as f64));
            }
            first += run.len();
        }
        spans
    };
    pads.zip(outputs)
        .map(|((id, _), pad)| Lifted {
            casting: id.casting,
            fixture: id.fixture,
            spans_s: spans((id.casting, id.fixture), pad.rest_force_n),
        })
        .collect()
}

fn shocks(view: &SceneView<'_>) -> Shocks {
    let cores = view.outcome.metrics.iter().flat_map(|metrics| &metrics.cores);
    let named = view.scene.core_names().into_iter().zip(cores);
    let cores = named.filter_map(|(name, core)| Some((name, core.spectrum.clone()?))).collect();
    Shocks { frequencies_hz: spectrum_frequencies_hz().to_vec(), cores }
}

/// Measured curves with their signals.
fn measured<'a>(view: &SceneView<'a>, data: &mut Samples) -> Vec<Curve<'a>> {
    let of = |curve: &MeasuredCurve<'a>| view.signals.iter().find(|signal| signal.name == curve.signal);
    let curves = view.measured.iter().filter_map(|curve| Some((of(curve)?, curve)));
    curves
        .map(|(signal, curve)| Curve {
            of: signal.of,
            quantity: signal.quantity,
            column: curve.column,
            pieces: (curve.pieces.iter())
                .map(|piece| CurvePiece {
                    from_s: view.interval_s * piece.first as f64,
                    offset: data.numbers(piece.values),
                    count: piece.values.len(),
                })
                .collect(),
            spikes_s: curve.spikes_s,
        })
        .collect()
}

fn factors<'a>(view: &SceneView<'a>) -> Vec<(&'a str, String, &'a str)> {
    let values = view.info.factors.iter().zip(view.factors);
    values.map(|(factor, value)| (factor.name.as_str(), value.to_string(), factor.unit.as_str())).collect()
}

/// A column of the table of blows: a figure that has a heading.
fn figure(quantity: &Quantity<Blow>) -> Option<BlowColumn> {
    let text = quantity.description();
    Some(BlowColumn { name: quantity.name, heading: quantity.heading?, unit: quantity.unit, text })
}

fn struck(blow: &Blow) -> Struck {
    let headed = Blow::QUANTITIES.iter().filter(|quantity| quantity.heading.is_some());
    Struck {
        hammer: blow.hammer,
        number: blow.number,
        kind: blow.kind.name(),
        start_s: blow.start_time_s,
        figures: headed.map(|quantity| (quantity.value)(blow).and_then(|value| value.number())).collect(),
    }
}

/// All outputs of the row with their texts.
fn outputs(view: &SceneView<'_>) -> Vec<Output> {
    let Some(metrics) = &view.outcome.metrics else { return Vec::new() };
    let mut outputs = Vec::new();
    list(&mut outputs, "run", RunTotals::QUANTITIES, &metrics.totals);
    for (name, hammer) in view.info.hammers.iter().zip(&metrics.hammers) {
        list(&mut outputs, &format!("hammer {name}"), HammerMetrics::QUANTITIES, hammer);
    }
    for (name, casting) in view.info.castings.iter().zip(&metrics.castings) {
        list(&mut outputs, &format!("casting {name}"), CastingMetrics::QUANTITIES, casting);
    }
    for (name, elastic) in view.info.elastic_castings.iter().zip(&metrics.elastic) {
        list(&mut outputs, &format!("casting {name}"), ElasticMetrics::QUANTITIES, elastic);
    }
    let pads = view.scene.fixtures().filter(|(_, fixture)| fixture.one_sided);
    for ((id, fixture), pad) in pads.zip(&metrics.pads) {
        let of = format!("fixture {} of casting {}", fixture.name, view.scene.castings[id.casting].name);
        list(&mut outputs, &of, PadMetrics::QUANTITIES, pad);
    }
    for ((id, fixture), energy) in view.scene.fixtures().zip(&metrics.fixtures) {
        let of = format!("fixture {} of casting {}", fixture.name, view.scene.castings[id.casting].name);
        list(&mut outputs, &of, FixtureMetrics::QUANTITIES, energy);
    }
    for (name, core) in view.scene.core_names().iter().zip(&metrics.cores) {
        list(&mut outputs, &format!("core point {name}"), CoreMetrics::QUANTITIES, core);
    }
    metrics.core_totals.iter().for_each(|totals| list(&mut outputs, "all core points", CoreTotals::QUANTITIES, totals));
    outputs
}

fn list<T>(outputs: &mut Vec<Output>, of: &str, quantities: &[Quantity<T>], metrics: &T) {
    outputs.extend(quantities.iter().map(|quantity| Output {
        of: of.to_owned(),
        name: quantity.name,
        value: (quantity.value)(metrics).map(|value| value.to_string()),
        unit: quantity.unit,
        text: quantity.description(),
    }));
}

/// A signal whose spectra are shown by the phases of a hammer.
struct WithSpectra<'a> {
    hammer: usize,
    signal: &'a Signal,
}

/// Signals with spectra: the same ones of every hammer, and other measured ones.
fn with_spectra<'a>(view: &SceneView<'a>) -> Vec<WithSpectra<'a>> {
    let signals = || view.signals.iter();
    let own = (0..view.scene.hammers.len()).flat_map(|hammer| {
        let of = move |quantity: &&str| {
            signals().find(|signal| signal.of == SignalOf::Hammer(hammer) && signal.quantity == *quantity)
        };
        WITH_SPECTRA.iter().filter_map(of).map(move |signal| WithSpectra { hammer, signal })
    });
    let mut all: Vec<WithSpectra<'a>> = own.collect();
    for curve in view.measured {
        let Some(signal) = signals().find(|signal| signal.name == curve.signal) else { continue };
        if let Some(hammer) = Phase::hammer_of(view.scene, signal.of)
            && !all.iter().any(|one| one.signal.name == signal.name)
        {
            all.push(WithSpectra { hammer, signal });
        }
    }
    all
}

/// Spectra by phase, of measurements too: all signals over their common time without a gap.
fn spectra<'a>(view: &SceneView<'a>, blows: &[Blow], data: &mut Samples) -> Vec<Spectra<'a>> {
    let (mut spectra, interval_s) = (Vec::new(), view.interval_s);
    for WithSpectra { hammer, signal } in with_spectra(view) {
        let curves: Vec<&MeasuredCurve<'a>> =
            view.measured.iter().filter(|curve| curve.signal == signal.name).collect();
        let is_seen = |from_s, to_s| curves.iter().all(|curve| curve.has(from_s / interval_s, to_s / interval_s));
        for phase in Phase::all(view.scene, hammer, blows, &is_seen) {
            let whole = phase.samples(interval_s);
            let samples = curves.iter().fold(whole.clone(), |samples, curve| curve.common(samples));
            let part = within(&signal.values, 0, &samples);
            if part.len() < LEAST_SAMPLES {
                continue;
            }
            let is_cut = samples != whole;
            let [from_s, to_s] = if is_cut {
                [samples.start, samples.end].map(|at| interval_s * at as f64)
            } else {
                [phase.from_s, phase.to_s]
            };
            let measured = curves.iter().map(|curve| {
                let lines = curve.whole(&samples).map(|part| Lines::of(part, interval_s, data));
                MeasuredLines { column: curve.column, lines }
            });
            let measured = measured.collect();
            spectra.push(Spectra {
                hammer,
                quantity: signal.quantity,
                name: signal.name.as_str(),
                unit: signal.unit,
                phase: phase.kind.text(),
                from_s,
                to_s,
                cut_from_s: is_cut.then_some([phase.from_s, phase.to_s]),
                lines: Lines::of(part, interval_s, data),
                measured,
            });
        }
    }
    spectra
}

/// Values of a signal within `samples`; `first`: sample of its first value.
fn within<'v>(values: &'v [f64], first: usize, samples: &Range<usize>) -> &'v [f64] {
    let [from, to] = [samples.start, samples.end].map(|at| at.clamp(first, first + values.len()) - first);
    values.get(from..to).unwrap_or_default()
}

impl<'a> MeasuredCurve<'a> {
    /// Whether a piece has all between two places of the signal, in samples.
    fn has(&self, from: f64, to: f64) -> bool {
        let ends = |piece: &MeasuredPiece<'_>| (piece.first as f64, (piece.first + piece.values.len()) as f64 - 1.0);
        self.pieces.iter().map(ends).any(|(first, last)| first <= from && to <= last)
    }

    /// Returns the samples of the piece that covers most of `samples`; all samples if that is too little for a spectrum.
    fn common(&self, samples: Range<usize>) -> Range<usize> {
        let of = |piece: &MeasuredPiece<'_>| {
            samples.start.max(piece.first)..samples.end.min(piece.first + piece.values.len())
        };
        let longest = self.pieces.iter().map(of).max_by_key(Range::len);
        longest.filter(|common| common.len() >= LEAST_SAMPLES).unwrap_or(samples)
    }

    /// Values over `samples`, if one piece covers all of them.
    fn whole(&self, samples: &Range<usize>) -> Option<&'a [f64]> {
        let parts = self.pieces.iter().map(|piece| within(piece.values, piece.first, samples));
        parts.into_iter().find(|part| part.len() == samples.len())
    }
}

impl Lines {
    /// The spectrum of a part of a signal, its lines among the page's data.
    fn of(part: &[f64], interval_s: f64, data: &mut Samples) -> Self {
        let spectrum = Spectrum::of(part, interval_s);
        let lines = spectrum.up_to(MOST_FREQUENCY_HZ);
        let (resolution_hz, count) = (spectrum.resolution_hz, lines.len());
        Self { resolution_hz, offset: data.numbers(lines), count }
    }
}

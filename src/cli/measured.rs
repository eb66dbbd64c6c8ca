//! `decore scene --measured`: compares measured channels with the row's signals.

use std::path::PathBuf;

use clap::Args;
use schemars::JsonSchema;
use serde::Serialize;

use super::exit::Failure;
use super::text::six_digits;
use decore_lab::measurement::{
    Compared, LOW_PASS_HZ, LOW_PASS_ORDER, LineBeside, Measured, MeasuredBeside, PhaseBeside, Phases, Treatment, UNITS,
    Unit, beside, phases, read, unit,
};
use decore_model::metrics::{Blow, Phase, Signal};
use decore_model::scene::Scene;
use decore_quantity::words::{did_you_mean, nearest};

#[derive(Debug, Args)]
pub(super) struct MeasuredArguments {
    /// Compare the row's signals with this measurement (CSV or Parquet)
    ///
    /// The file needs a column of times and a column for each channel.
    #[arg(long, value_name = "FILE", requires = "channels")]
    measured: Option<PathBuf>,
    /// Signal, and the column and unit that measure it; repeatable
    ///
    /// Example: `left_arm_velocity_m_s=vibrometer_2:mm/s`. The default unit is m/s. A minus before the unit reverses the sign.
    #[arg(long = "channel", value_name = "SIGNAL=COLUMN[:UNIT]", requires = "measured", value_parser = channel)]
    channels: Vec<Channel>,
    /// Column of the measured times, and its unit (s, ms or us)
    ///
    /// Example: `Time [ms]:ms`. The default unit is s.
    #[arg(long, default_value = "time_s", value_name = "COLUMN[:UNIT]", requires = "measured", value_parser = time_column)]
    time_column: MeasuredColumn,
    /// Time by which the measurement's clock is ahead, in s
    ///
    /// By default, the offset with the best correlation of signal and channel.
    #[arg(long, value_name = "SECONDS", requires = "measured", allow_hyphen_values = true)]
    offset_s: Option<f64>,
    /// Cut-off in Hz of the low-pass before the comparison; 0: none
    ///
    /// The zero-phase low-pass applies to both signal and channel.
    #[arg(long, default_value_t = LOW_PASS_HZ, value_name = "HZ", requires = "measured")]
    low_pass_hz: f64,
}

/// A column that is asked for.
#[derive(Debug, Clone)]
struct MeasuredColumn {
    name: String,
    unit: Unit,
}

/// A channel that is asked for.
#[derive(Debug, Clone)]
struct Channel {
    signal: String,
    column: MeasuredColumn,
}

/// A channel compared with its signal.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct ChannelBeside {
    /// The signal.
    pub signal: String,
    /// SI unit of the figures.
    pub unit: &'static str,
    /// Column of the measurement.
    pub column: String,
    /// Figures of the whole measurement.
    #[serde(flatten)]
    pub beside: MeasuredBeside,
    /// The hammer whose phases are told: the signal's own, or the first that strikes its casting; null: none does.
    pub phases_of: Option<String>,
    /// Figures of each phase.
    #[serde(flatten)]
    pub phases: Phases,
}

/// What a row gave: the signals that channels measure, every `interval_s`, and what tells its phases.
#[derive(Debug, Clone, Copy)]
pub(super) struct Calculated<'a> {
    pub scene: &'a Scene,
    pub blows: &'a [Blow],
    pub signals: &'a [Signal],
    pub interval_s: f64,
}

/// Reads `SIGNAL=COLUMN[:UNIT]`.
fn channel(text: &str) -> Result<Channel, String> {
    let (signal, column) = text.split_once('=').ok_or("expected SIGNAL=COLUMN or SIGNAL=COLUMN:UNIT")?;
    Ok(Channel { signal: signal.to_owned(), column: MeasuredColumn::read(column, "m/s", &|_| true)? })
}

/// Reads `COLUMN[:UNIT]` of times.
fn time_column(text: &str) -> Result<MeasuredColumn, String> {
    MeasuredColumn::read(text, "s", &|unit| unit.si == "s" && unit.factor > 0.0)
}

impl MeasuredColumn {
    /// Reads `COLUMN[:UNIT]` in one of the units that are `meant`.
    fn read(text: &str, usual: &str, meant: &dyn Fn(&Unit) -> bool) -> Result<Self, String> {
        let (name, own) = text.rsplit_once(':').unwrap_or((text, usual));
        let known = || UNITS.iter().filter(|unit| meant(unit)).map(|unit| unit.name);
        let unit = unit(own).filter(meant).ok_or_else(|| {
            let hint = did_you_mean(nearest(own, known()));
            let known = known().collect::<Vec<_>>().join(", ");
            format!("`{own}` is no unit of column `{name}`; known are {known}{hint} (after a name with a colon the unit has to stand)")
        })?;
        Ok(Self { name: name.to_owned(), unit })
    }

    fn named(&self) -> (&str, Unit) {
        (&self.name, self.unit)
    }
}

impl MeasuredArguments {
    /// Whether there is a measurement.
    pub fn is_given(&self) -> bool {
        self.measured.is_some()
    }

    /// The file that is read.
    pub fn file(&self) -> Option<&PathBuf> {
        self.measured.as_ref()
    }

    /// The channels beside the signals that they measure.
    ///
    /// # Errors
    /// Signals that are not there or have another unit, what [`read`] and [`beside`] refuse.
    pub fn beside(&self, calculated: Calculated<'_>) -> Result<Vec<ChannelBeside>, Failure> {
        let Calculated { scene, blows, signals, interval_s } = calculated;
        let Some(file) = &self.measured else { return Ok(Vec::new()) };
        let told = |error: &dyn std::fmt::Display| Failure::Argument(error.to_string());
        let low_pass_hz = (self.low_pass_hz != 0.0).then_some(self.low_pass_hz);
        let treatment = Treatment { low_pass_hz, offset_s: self.offset_s };
        let signals = self.channels.iter().map(|channel| signal(channel, signals)).collect::<Result<Vec<_>, _>>()?;
        let columns: Vec<(&str, Unit)> = self.channels.iter().map(|channel| channel.column.named()).collect();
        let measured = read(file, self.time_column.named(), &columns).map_err(|error| told(&error))?;
        let one = |((channel, signal), measured): ((&Channel, &Signal), &Measured)| {
            let name = |error| told(&format_args!("channel `{}`: {error}", channel.column.name));
            let beside = beside((&signal.values, interval_s), measured, treatment).map_err(name)?;
            let hammer = Phase::hammer_of(scene, signal.of);
            let had = hammer.map_or(Vec::new(), |hammer| {
                Phase::all(scene, hammer, blows, &|from_s, to_s| beside.has(from_s, to_s))
            });
            Ok(ChannelBeside {
                signal: channel.signal.clone(),
                unit: signal.unit,
                column: channel.column.name.clone(),
                phases: phases(&beside, interval_s, &had).map_err(name)?,
                phases_of: hammer.and_then(|hammer| scene.hammers.get(hammer)).map(|unit| unit.name.clone()),
                beside,
            })
        };
        self.channels.iter().zip(signals).zip(&measured).map(one).collect()
    }
}

/// The signal that a channel measures.
fn signal<'a>(channel: &Channel, signals: &'a [Signal]) -> Result<&'a Signal, Failure> {
    let Channel { signal: name, column: MeasuredColumn { unit, .. } } = channel;
    let known = || signals.iter().map(|signal| signal.name.as_str());
    let Some(found) = signals.iter().find(|signal| signal.name == *name) else {
        let hint = did_you_mean(nearest(name, known()));
        return Err(Failure::Argument(format!("--channel: the row has no signal `{name}`{hint}")));
    };
    if found.unit != unit.si {
        let message = format!("--channel: `{name}` is in {}, which {} is no unit of", found.unit, unit.name);
        return Err(Failure::Argument(message));
    }
    Ok(found)
}

/// Comparison of channels and signals as text.
pub(super) fn channels_text(channels: &[ChannelBeside]) -> String {
    let mut text = String::new();
    for ChannelBeside { signal, unit, column, beside, phases_of, phases } in channels {
        let found = beside.correlation.map_or("given".to_owned(), |found| format!("correlation {found:.4}"));
        text += &format!(
            "\nmeasured `{column}` beside {signal}\n  offset                {} s ({found})",
            six_digits(beside.offset_s)
        );
        beside.warnings.iter().for_each(|warning| text += &format!("\n  warning               {warning}"));
        text += &format!("\n  compared from         {} to {} s", six_digits(beside.from_s), six_digits(beside.to_s));
        text += &gaps_text(beside);
        text += &beside.low_pass_hz.map_or("\n  low-pass              none".to_owned(), |cutoff_hz| {
            format!("\n  low-pass              {cutoff_hz} Hz, Butterworth of order {LOW_PASS_ORDER}, forwards and backwards, odd padding")
        });
        text += &match beside.spikes_s.as_slice() {
            [] => "\n  single-sample spikes  none".to_owned(),
            [first, ..] => format!(
                "\n  single-sample spikes  {}, the first at {} s: marked, not removed",
                beside.spikes_s.len(),
                six_digits(*first)
            ),
        };
        text += &format!("\n  {:<21} {:>12} {:>12}", "", "calculated", "measured");
        text += &figures_text([&beside.rms, &beside.peak], beside.frequency_hz.as_ref(), unit);
        let hammer = phases_of.as_ref().map_or("no hammer strikes there".to_owned(), |name| format!("hammer {name}"));
        text += &format!("\n  by phase: {hammer}");
        phases.phases.iter().for_each(|phase| text += &phase_text(phase, unit));
        for missing in &phases.missing_phases {
            text += &format!("\n  {}: missing, {}", missing.phase.text(), missing.reason);
        }
        text.push('\n');
    }
    text
}

/// The gaps of a measurement, and what is left of it for frequencies.
fn gaps_text(beside: &MeasuredBeside) -> String {
    let [first, second, ..] = beside.pieces.as_slice() else { return String::new() };
    let [begin, end] = [first.to_s, second.from_s].map(six_digits);
    let longest = beside.pieces.iter().rev().max_by_key(|piece| piece.measured.len()).unwrap_or(first);
    let [from, to] = [longest.from_s, longest.to_s].map(six_digits);
    format!(
        "\n  gaps of the record    {}, the first from {begin} to {end} s: left out of both signals\n  frequencies           of the longest \
         time without a gap, {from} to {to} s, and in phases likewise",
        beside.pieces.len() - 1
    )
}

fn figure_text(name: &str, unit: &str, of: &Compared) -> String {
    let [ours, theirs] = [of.calculated, of.measured].map(six_digits);
    format!("\n  {name:<21} {ours:>12} {theirs:>12} {unit:<4} {:+.1} %", 100.0 * of.difference)
}

fn figures_text([rms, peak]: [&Compared; 2], frequency_hz: Option<&Compared>, unit: &str) -> String {
    let frequency = frequency_hz.map_or(String::new(), |of| figure_text("frequency, highest", "Hz", of));
    figure_text("root mean square", unit, rms) + &figure_text("peak", unit, peak) + &frequency
}

/// A phase: its figures, and the strongest lines of both densities.
fn phase_text(phase: &PhaseBeside, unit: &str) -> String {
    let PhaseBeside { from_s, to_s, covered, rms, peak, frequency_hz, density, .. } = phase;
    let part = if *covered < 1.0 { format!(", {:.0} % of it", 100.0 * covered) } else { String::new() };
    let mut text = format!("\n  {}: {} to {} s{part}", phase.phase.text(), six_digits(*from_s), six_digits(*to_s));
    text += &figures_text([rms, peak], frequency_hz.as_ref(), unit);
    let Some(density) = density else { return text + "\n  too short for a density" };
    text += &format!("\n  lines of the densities (Welch, {:.1} Hz apart)", density.resolution_hz);
    for LineBeside { calculated_hz, measured_hz, difference } in &density.lines {
        let [ours, theirs] = [calculated_hz, measured_hz].map(|hz| hz.map_or("-".to_owned(), |hz| format!("{hz:.2}")));
        let difference = difference.map_or(String::new(), |share| format!(" {:+.1} %", 100.0 * share));
        text += &format!("\n  {:<21} {ours:>12} {theirs:>12} Hz  {difference}", "");
    }
    text
}

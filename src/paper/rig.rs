//! The paper's rig as a study, run unchanged and with one change at a time.

use std::path::Path;

use super::error::PaperError;
use super::lines::{ArmLines, Window};
use super::mobility::Mobility;
use decore_lab::measurement::{LOW_PASS_HZ, LOW_PASS_ORDER};
use decore_model::metrics::{
    Blow, BlowKind, FixtureSignals, HammerMetrics, HammerSignals, RunMetrics, Signal, SignalOf,
};
use decore_model::run::{RowOutcome, run_row};
use decore_model::scene::{FixtureId, PointId, Scene};
use decore_model::system::InterfaceModes;
use decore_statistics::signal::{Butterworth, peak, rms};
use decore_study::Study;
use decore_study::engine::{Engine, RowScene};

/// The shipped study of the rig.
const STUDY: &str = include_str!("../../studies/paper_rig.toml");
/// Interval of signals in s, short enough for contacts of 0.1 ms.
const INTERVAL_S: f64 = 2e-5;
/// Interval for the machine's points, whose modes end at 1000 Hz.
const GAUGE_INTERVAL_S: f64 = 1e-4;
/// Duration in s of runs that show steady hammering, and the time from which on the first impact's transient has decayed.
const LONG: &str = "duration_s=4.0";
pub(super) const DECAYED_S: f64 = 1.0;
/// Supplies in bar that are tried; the last is the paper's.
pub(super) const SUPPLIES_BAR: [f64; 4] = [4.4, 4.5, 4.6, 5.0];
/// Ratios of damping that are tried.
const DAMPING_RATIOS: [f64; 3] = [0.005, 0.02, 0.05];
/// Times in s after the first contact over which the arm's velocity is averaged; the last stands for the rest of the run.
const AVERAGED_S: [f64; 4] = [0.025, 0.15, 0.5, f64::INFINITY];
/// Points of the machine whose velocity is watched in addition to the mount's: along the arm, and the ends of its rail.
const WATCHED: [&str; 7] = ["A1", "A2", "A3", "A4", "A5", "R1", "R9"];
/// Values that make a fixture a gauge: it carries almost no force and reports the motion of its point.
const GAUGE: &str = "at_m = [0.0, 0.0]\nstiffness_n_per_m = 1e-3\ndamping_n_s_per_m = 0.0\n";
/// Further settings of a rig with gauges: gauges away from the points that they watch, and a casting that does not turn.
const GAUGED: [&str; 3] =
    ["geometry=as_given", "casting.part.centre_m=[0.36, 0.0]", "casting.part.inertia_kg_m2=[1.0, 1.0]"];

/// Results of the engine.
#[derive(Debug)]
pub(super) struct Ours {
    /// Natural frequencies of the machine with the hammer's housing in Hz, rising.
    pub frequencies_hz: Vec<f64>,
    pub mobility: Mobility,
    pub metrics: RunMetrics,
    /// Velocity of the mount from the first contact on, m/s, every [`INTERVAL_S`].
    pub arm_m_s: Vec<f64>,
    /// Lines of the arm's velocity: from the first contact to the end of the paper's run, then from [`DECAYED_S`] to the end of a
    /// longer one; each by a rectangular window, then by a Hann window.
    pub arm_lines: [ArmLines; 4],
    /// Every blow whose window lies in the run.
    pub impacts: Vec<Impact>,
    /// The rig at other supplies, in bar, over a longer time.
    pub supplies: Vec<Supplied>,
    /// With other ratios of damping.
    pub dampings: Vec<Varied>,
    /// Velocities of other points.
    pub places: Vec<RmsVelocity>,
}

/// Results of the hammer with one changed value.
#[derive(Debug)]
pub(super) struct Varied {
    pub value: f64,
    pub hammer: HammerMetrics,
}

/// Figures of the hammer at another supply pressure.
#[derive(Debug)]
pub(super) struct Supplied {
    pub supply_bar: f64,
    pub hammer: HammerMetrics,
    /// Standard deviation of the intervals between periodic blows over their mean.
    pub interval_spread: f64,
    /// Velocity of the mount from [`DECAYED_S`] on, m/s, every [`GAUGE_INTERVAL_S`].
    pub arm_m_s: Vec<f64>,
}

impl Supplied {
    /// RMS velocity of the mount once the first impact has decayed, m/s.
    pub fn steady_m_s(&self) -> f64 {
        rms(&self.arm_m_s)
    }
}

/// RMS velocity of a point of the machine in m/s.
#[derive(Debug)]
pub(super) struct RmsVelocity {
    pub point: &'static str,
    pub extension_m_s: f64,
    pub hammering_m_s: f64,
}

/// Velocities of one blow in m/s.
#[derive(Debug)]
pub(super) struct Impact {
    /// The chisel's at the blow's start.
    pub chisel_start_m_s: f64,
    pub casting: Peaks,
    pub chisel: Peaks,
}

/// A peak velocity, without and with the paper's low-pass, m/s.
#[derive(Debug)]
pub(super) struct Peaks {
    pub whole_m_s: f64,
    pub low_passed_m_s: f64,
}

impl Peaks {
    /// Excess of the peak over its low-passed value, in % of the latter.
    pub fn excess_percent(&self) -> f64 {
        100.0 * (self.whole_m_s / self.low_passed_m_s - 1.0)
    }
}

impl Ours {
    /// The hammer's outputs.
    pub fn hammer(&self) -> Result<&HammerMetrics, PaperError> {
        self.metrics.hammers.first().ok_or(PaperError::Missing("hammer"))
    }

    /// RMS velocities of the arm in m/s over the times in s after the first contact.
    pub fn averaged(&self) -> impl Iterator<Item = Averaged> {
        AVERAGED_S.into_iter().map(|time_s| {
            let count = ((time_s / INTERVAL_S).round() as usize).min(self.arm_m_s.len());
            Averaged { time_s: count as f64 * INTERVAL_S, rms_m_s: rms(&self.arm_m_s[..count]) }
        })
    }

    /// The longest time in s after the first contact over which the arm's RMS velocity reaches `least_m_s`.
    pub fn averaging_time_s(&self, least_m_s: f64) -> Option<f64> {
        let sums = self.arm_m_s.iter().scan(0.0, |sum, velocity| {
            *sum += velocity * velocity;
            Some(*sum)
        });
        let means = sums.enumerate().map(|(index, sum)| sum / (index + 1) as f64);
        let reached = means.enumerate().filter(|(_, mean)| *mean >= least_m_s * least_m_s);
        reached.last().map(|(index, _)| (index + 1) as f64 * INTERVAL_S)
    }
}

/// RMS velocity over a time.
#[derive(Debug, Clone, Copy)]
pub(super) struct Averaged {
    pub time_s: f64,
    pub rms_m_s: f64,
}

/// Runs the rig and its variants.
pub(super) fn run() -> Result<Ours, PaperError> {
    let engine = engine(&study_text(), &[])?;
    let RowScene { scene, modes } = engine.scene(0).map_err(|invalid| PaperError::Row(invalid.reason))?;
    let (outcome, signals) = engine.outcome_with_signals(0, INTERVAL_S)?;
    let metrics = done(outcome)?;
    let hammer = |quantity| named(signals.as_deref(), SignalOf::Hammer(0), quantity);
    let arm = hammer(HammerSignals::arm_velocity_m_s.name)?;
    let first_s = first_contact_s(&metrics)?;
    let arm_m_s = arm.values.get(sample(first_s, INTERVAL_S)..).unwrap_or_default().to_vec();
    let [casting, chisel] = [HammerSignals::casting_velocity_m_s.name, HammerSignals::chisel_velocity_m_s.name];
    let impacts = impacts(&metrics.blows, scene.outputs.blow_window_s, [hammer(casting)?, hammer(chisel)?])?;
    let shape = |point: PointId| modes.shapes.get(&point).ok_or(PaperError::Missing("mode shapes"));
    let mount = shape(PointId::Mount { hammer: 0 })?;
    let table = shape(PointId::Support(FixtureId { casting: 0, fixture: 0, axis: 0 }))?;
    let supplies = SUPPLIES_BAR.into_iter().map(supplied).collect::<Result<Vec<_>, _>>()?;
    Ok(Ours {
        frequencies_hz: modes.omega_rad_s.iter().map(|omega| omega / std::f64::consts::TAU).collect(),
        mobility: Mobility::of(&modes, mount, table),
        arm_lines: arm_lines(&metrics, &arm_m_s, supplies.last())?,
        arm_m_s,
        impacts,
        supplies,
        dampings: dampings(&scene, &modes)?,
        places: places()?,
        metrics,
    })
}

/// The study's text without the line that names the hammer's file: that file writes out the built-in hammer.
fn study_text() -> String {
    STUDY.lines().filter(|line| !line.starts_with("file = ")).flat_map(|line| [line, "\n"]).collect()
}

fn engine(text: &str, settings: &[&str]) -> Result<Engine, PaperError> {
    let settings: Vec<String> = settings.iter().map(|setting| (*setting).to_owned()).collect();
    Ok(Engine::new(Study::parse(text, Path::new(""), "paper_rig.toml")?.with_overrides(&settings)?)?)
}

/// The outputs of a run that reached its end.
fn done(outcome: RowOutcome) -> Result<RunMetrics, PaperError> {
    let reason = outcome.reason;
    outcome.metrics.ok_or(PaperError::Row(reason))
}

fn first_contact_s(metrics: &RunMetrics) -> Result<f64, PaperError> {
    let hammer = metrics.hammers.first().and_then(|hammer| hammer.first_impact_time_s);
    hammer.ok_or(PaperError::Missing("first impact"))
}

/// The first sample at a time or after it.
fn sample(time_s: f64, interval_s: f64) -> usize {
    (time_s / interval_s).ceil() as usize
}

fn named<'s>(signals: Option<&'s [Signal]>, of: SignalOf, quantity: &'static str) -> Result<&'s Signal, PaperError> {
    let found = signals.and_then(|signals| signals.iter().find(|one| one.of == of && one.quantity == quantity));
    found.ok_or(PaperError::Missing(quantity))
}

/// See [`Ours::arm_lines`]; `arm_m_s`: from the first contact on; `long`: at the same supply.
fn arm_lines(metrics: &RunMetrics, arm_m_s: &[f64], long: Option<&Supplied>) -> Result<[ArmLines; 4], PaperError> {
    let blows_hz = metrics.hammers.first().and_then(|hammer| hammer.hit_frequency_hz);
    let blows_hz = blows_hz.ok_or(PaperError::Missing("frequency of blows"))?;
    let first_s = first_contact_s(metrics)?;
    let end_s = first_s + INTERVAL_S * arm_m_s.len() as f64;
    let late_m_s = long.map_or(&[][..], |long| &long.arm_m_s);
    let late_end_s = DECAYED_S + GAUGE_INTERVAL_S * late_m_s.len() as f64;
    let early = |window| ArmLines::of(window, [first_s, end_s], (arm_m_s, INTERVAL_S), blows_hz);
    let late = |window| ArmLines::of(window, [DECAYED_S, late_end_s], (late_m_s, GAUGE_INTERVAL_S), blows_hz);
    let [rectangular, hann] = Window::ALL;
    Ok([early(rectangular)?, early(hann)?, late(rectangular)?, late(hann)?])
}

fn supplied(supply_bar: f64) -> Result<Supplied, PaperError> {
    let supply = format!("hammer.hammer.supply_bar={supply_bar}");
    let (outcome, signals) = engine(&study_text(), &[LONG, &supply])?.outcome_with_signals(0, GAUGE_INTERVAL_S)?;
    let arm = named(signals.as_deref(), SignalOf::Hammer(0), HammerSignals::arm_velocity_m_s.name)?;
    let arm_m_s = arm.values.get(sample(DECAYED_S, GAUGE_INTERVAL_S)..).unwrap_or_default().to_vec();
    let metrics = done(outcome)?;
    let periodic = metrics.blows.iter().filter(|blow| blow.kind == BlowKind::Periodic);
    let starts_s: Vec<f64> = periodic.map(|blow| blow.start_time_s).collect();
    let intervals_s: Vec<f64> = starts_s.iter().zip(starts_s.iter().skip(1)).map(|(from, to)| to - from).collect();
    let mean_s = intervals_s.iter().sum::<f64>() / intervals_s.len() as f64;
    let deviations: Vec<f64> = intervals_s.iter().map(|interval_s| interval_s / mean_s - 1.0).collect();
    let hammer = metrics.hammers.into_iter().next().ok_or(PaperError::Missing("hammer"))?;
    Ok(Supplied { supply_bar, hammer, interval_spread: rms(&deviations), arm_m_s })
}

/// Velocities of every blow: between its start and the end of its window, for the chisel, which a blow of the piston drives, as
/// for the casting.
fn impacts(blows: &[Blow], window_s: f64, [casting, chisel]: [&Signal; 2]) -> Result<Vec<Impact>, PaperError> {
    let filter = Butterworth::low_pass(LOW_PASS_ORDER, LOW_PASS_HZ, 1.0 / INTERVAL_S)?;
    let [filtered_casting, filtered_chisel] = [filter.zero_phase(&casting.values)?, filter.zero_phase(&chisel.values)?];
    let impact = |blow: &Blow| {
        let window = sample(blow.start_time_s, INTERVAL_S)..sample(blow.start_time_s + window_s, INTERVAL_S);
        let peak_of = |values: &[f64]| values.get(window.clone()).map(peak);
        Some(Impact {
            chisel_start_m_s: blow.chisel_velocity_m_s,
            casting: Peaks { whole_m_s: blow.casting_peak_velocity_m_s, low_passed_m_s: peak_of(&filtered_casting)? },
            chisel: Peaks { whole_m_s: peak_of(&chisel.values)?, low_passed_m_s: peak_of(&filtered_chisel)? },
        })
    };
    Ok(blows.iter().filter_map(impact).collect())
}

fn dampings(scene: &Scene, modes: &InterfaceModes) -> Result<Vec<Varied>, PaperError> {
    let at = |ratio: f64| {
        let modes = InterfaceModes { damping_ratio: vec![ratio; modes.damping_ratio.len()], ..modes.clone() };
        varied(ratio, scene, &modes)
    };
    DAMPING_RATIOS.into_iter().map(at).collect()
}

fn varied(value: f64, scene: &Scene, modes: &InterfaceModes) -> Result<Varied, PaperError> {
    let hammer = done(run_row(scene, modes))?.hammers.into_iter().next();
    Ok(Varied { value, hammer: hammer.ok_or(PaperError::Missing("hammer"))? })
}

/// Motion of other points of the machine while the hammer works at its mount.
fn places() -> Result<Vec<RmsVelocity>, PaperError> {
    let gauges = WATCHED.map(|point| format!("\n[casting.part.fixture.{point}]\npoint = \"{point}\"\n{GAUGE}"));
    let (outcome, signals) =
        engine(&(study_text() + &gauges.concat()), &GAUGED)?.outcome_with_signals(0, GAUGE_INTERVAL_S)?;
    let first = sample(first_contact_s(&done(outcome)?)?, GAUGE_INTERVAL_S);
    let place = |(index, point): (usize, &'static str)| {
        // The first fixture is the one that holds the casting.
        let of = SignalOf::Fixture(0, index + 1);
        let values = &named(signals.as_deref(), of, FixtureSignals::point_velocity_m_s.name)?.values;
        let (before, after) = values.split_at(first.min(values.len()));
        Ok(RmsVelocity { point, extension_m_s: rms(before), hammering_m_s: rms(after) })
    };
    WATCHED.into_iter().enumerate().map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rig_is_the_shipped_one() {
        let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/paper_rig.toml");
        let scene = |engine: Engine| engine.scene(0).expect("scene");
        let [ours, shipped] = [engine(&study_text(), &[]), Engine::load(&shipped, &[]).map_err(Into::into)]
            .map(|e| scene(e.expect("rig")));
        assert_eq!(ours.scene, shipped.scene);
        assert_eq!(**ours.modes, **shipped.modes);
    }
}

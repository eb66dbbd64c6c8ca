//! What is kept of one hammer while it works, and the outputs that follow from it.

use super::blow::{Blow, BlowKind, BlowStrain, Recorded};
use super::contacts::ContactTrack;
use super::instant::Instant;
use super::outputs::HammerMetrics;
use super::peak::{Probe, peak, reach, terms};
use super::percussion::judge;
use super::statistics::{error_of_mean, mean, variance};
use super::steady::{self, Interval, ShownTime, Sure};
use super::strain::StrainGauge;
use super::warning::Warning;
use crate::hammer::body;
use crate::integrate::{Step, Switching};
use crate::scene::{OutputSettings, PartId, Scene};
use crate::system::{Coupled, CoupledModel, HammerQuadrature};

/// State for which standard litres are counted: 101325 Pa and 293.15 K.
const STANDARD_PRESSURE_PA: f64 = 101_325.0;
/// See [`STANDARD_PRESSURE_PA`].
const STANDARD_TEMPERATURE_K: f64 = 293.15;
/// Litres in a cubic metre.
const LITRES_PER_M3: f64 = 1000.0;

/// A blow whose window is still open.
struct OpenWindow {
    recorded: Recorded,
    end_s: f64,
    impulse_at_start: f64,
    kinetic_at_start: f64,
}

/// What is remembered of one hammer.
pub(super) struct HammerTrack {
    hammer: usize,
    settings: OutputSettings,
    /// Stroke that had its impact last, from 1.
    impact_of: usize,
    /// Time of the first impact and the arm's integral then.
    first_impact: Option<(f64, f64)>,
    contacts: ContactTrack,
    /// Velocities of the casting that it strikes, as components of the state.
    casting: Vec<usize>,
    /// Strain of that casting; `None` if it is rigid.
    strain: Option<StrainGauge>,
    blows: usize,
    last_blow_s: f64,
    gated_s: f64,
    /// Struck blows of the percussion in a stroke, and which stroke.
    struck: (usize, usize),
    window: Option<OpenWindow>,
    recorded: Vec<Recorded>,
}

impl HammerTrack {
    pub fn new(hammer: usize, model: &CoupledModel, scene: &Scene) -> Self {
        let settings = scene.outputs.clone();
        let travel_m = scene.hammers[hammer].parameters.chisel.travel_m;
        Self {
            hammer,
            casting: model.velocities(PartId::Casting(scene.hammers[hammer].casting)).collect(),
            strain: StrainGauge::new(model, scene, scene.hammers[hammer].casting),
            contacts: ContactTrack::new(model.hammers()[hammer].strike, settings.contact_separation_s, travel_m),
            settings,
            impact_of: 0,
            first_impact: None,
            blows: 0,
            last_blow_s: f64::NEG_INFINITY,
            gated_s: 0.0,
            struck: (0, 0),
            window: None,
            recorded: Vec::new(),
        }
    }

    /// Follows a step: the time with the gate open, contacts, and the window if one is open.
    pub fn step(&mut self, system: &Coupled, step: &Step<'_>, scratch: &mut [f64]) {
        self.contacts.step(system, step, scratch);
        // The chisel may rest on the casting where the supply is switched on.
        if system.strokes(self.hammer) > self.impact_of
            && system.is_closed(system.model().hammers()[self.hammer].strike)
        {
            step.write_start(scratch);
            self.impact(system, Instant { t: step.t0, y: scratch });
        }
        if system.gate_open(self.hammer) {
            self.gated_s += step.t1() - step.t0;
        }
        let Some(window) = &mut self.window else { return };
        window.watch(system, step, Probe { support: &self.casting, scratch });
        if window.end_s <= step.t1() {
            let theta = step.fraction(window.end_s);
            let strain_j = self.strain.as_mut().map(|strain| {
                step.state(theta, scratch);
                strain.energy_j(system, Instant { t: step.time(theta), y: scratch })
            });
            self.close(system, strain_j, |index| step.component(index, theta));
        }
    }

    /// A contact of the chisel with the casting began.
    pub fn contact(&mut self, system: &Coupled, Instant { t, y }: Instant<'_>) {
        self.contacts.begins(system, Instant { t, y });
        self.impact(system, Instant { t, y });
    }

    /// A contact of the chisel with the casting ended.
    pub fn release(&mut self, t: f64) {
        self.contacts.ends(t);
    }

    /// Number of blows that have begun.
    pub fn blow_count(&self) -> usize {
        self.blows
    }

    /// The blow whose window is open, and the end of that window in s.
    pub fn present_blow(&self) -> Option<(&Blow, f64)> {
        self.window.as_ref().map(|window| (&window.recorded.blow, window.end_s))
    }

    /// Reasons to doubt the run.
    pub fn warnings(&self, system: &Coupled) -> impl Iterator<Item = Warning> {
        self.contacts.warnings(system)
    }

    /// The chisel touches the casting: in each stroke the first contact starts the stroke's impact.
    fn impact(&mut self, system: &Coupled, Instant { t, y }: Instant<'_>) {
        let stroke = system.strokes(self.hammer);
        if stroke > self.impact_of {
            self.impact_of = stroke;
            let arm = system.model().layout().quadrature(self.hammer, HammerQuadrature::ArmVelocitySquared);
            self.first_impact.get_or_insert((t, y[arm]));
            let kind = if stroke == 1 { BlowKind::FirstImpact } else { BlowKind::StrokeImpact };
            self.start(kind, system, Instant { t, y });
        }
    }

    /// The piston met the chisel with the gate open: a blow of the percussion, if it is fast and late enough.
    pub fn percussion(&mut self, closing_m_s: f64, system: &Coupled, Instant { t, y }: Instant<'_>) {
        let separate = t - self.last_blow_s >= self.settings.blow_separation_s;
        if separate && closing_m_s >= self.settings.blow_closing_speed_m_s {
            // Whether it is blank or settling is known when its window closes.
            self.start(BlowKind::Periodic, system, Instant { t, y });
        }
    }

    fn start(&mut self, kind: BlowKind, system: &Coupled, Instant { t, y }: Instant<'_>) {
        let is_open = self.window.is_some();
        let strain = self.strain.as_mut().filter(|_| is_open);
        let strain_j = strain.map(|strain| strain.energy_j(system, Instant { t, y }));
        self.close(system, strain_j, |index| y[index]);
        let model = system.model();
        let slot = &model.hammers()[self.hammer];
        let quadrature = |q| y[model.layout().quadrature(self.hammer, q)];
        let blow = Blow {
            hammer: self.hammer,
            casting: slot.casting,
            number: self.blows,
            stroke: system.strokes(self.hammer).saturating_sub(1),
            kind,
            start_time_s: t,
            energy_j: model.impact_energy(self.hammer, y),
            chisel_velocity_m_s: y[model.layout().velocity(slot.points[body::CHISEL])],
            ..Blow::default()
        };
        let arm_integral = quadrature(HammerQuadrature::ArmVelocitySquared);
        self.window = Some(OpenWindow {
            recorded: Recorded {
                blow,
                gated_s: self.gated_s,
                arm_integral,
                work_before_j: quadrature(HammerQuadrature::Work),
                run_work_before_j: run_work(system, y),
            },
            end_s: t + self.settings.blow_window_s,
            impulse_at_start: quadrature(HammerQuadrature::Impulse),
            kinetic_at_start: model.kinetic_energy(PartId::Casting(slot.casting), |velocity| y[velocity]),
        });
        self.blows += 1;
        self.last_blow_s = t;
    }

    /// Closes the window, if one is open; `component` reads the state at its end, and `strain_j` is the casting's strain energy then.
    fn close(&mut self, system: &Coupled, strain_j: Option<f64>, component: impl Fn(usize) -> f64) {
        let Some(OpenWindow { mut recorded, impulse_at_start, .. }) = self.window.take() else { return };
        let quadrature = |q| component(system.model().layout().quadrature(self.hammer, q));
        let work_at_start = recorded.work_before_j;
        let blow = &mut recorded.blow;
        blow.work_j = quadrature(HammerQuadrature::Work) - work_at_start;
        blow.impulse_n_s = quadrature(HammerQuadrature::Impulse) - impulse_at_start;
        blow.strain = strain_j.map(|casting_strain_energy_j| BlowStrain { casting_strain_energy_j });
        if blow.kind.is_percussion() {
            blow.kind = self.kind_of(blow);
        }
        self.recorded.push(recorded);
    }

    /// Kind of a blow of the percussion whose window is over.
    fn kind_of(&mut self, blow: &Blow) -> BlowKind {
        if blow.peak_force_n <= 0.0 {
            return BlowKind::Blank;
        }
        if self.struck.1 != blow.stroke {
            self.struck = (0, blow.stroke);
        }
        self.struck.0 += 1;
        if self.struck.0 <= self.settings.settling_blows { BlowKind::Settling } else { BlowKind::Periodic }
    }

    /// The blows and the outputs at the end of the simulation, at time `t` and state `y`.
    pub fn finish(self, system: &Coupled, Instant { t, y }: Instant<'_>) -> Finished {
        let quadrature = |q| y[system.model().layout().quadrature(self.hammer, q)];
        let rms = |integral: f64, duration: f64| (duration > 0.0).then(|| (integral.max(0.0) / duration).sqrt());
        let arm_total = quadrature(HammerQuadrature::ArmVelocitySquared);
        let (first_impact_s, arm_at_impact) = self.first_impact.unwrap_or((t, arm_total));
        let hammering = self.first_impact.and_then(|(start, arm)| rms(arm_total - arm, t - start));
        let (percussion, percussion_period) = judge(&self.recorded, self.gated_s, &self.settings);
        let count = |chosen: &dyn Fn(BlowKind) -> bool| {
            self.recorded.iter().filter(|recorded| chosen(recorded.blow.kind)).count() as u64
        };
        let over_blows =
            |value: fn(&Blow) -> f64| self.recorded.iter().fold(0.0, |sum, recorded| sum + value(&recorded.blow));
        let (blank, blows) = (count(&|kind| kind == BlowKind::Blank), count(&BlowKind::is_percussion));
        let metrics = HammerMetrics {
            stroke_count: system.strokes(self.hammer) as u64,
            struck_blow_count: blows - blank,
            blank_blow_count: blank,
            percussion,
            percussion_period,
            strike_momentum_n_s: over_blows(|blow| blow.strike_momentum_n_s),
            strike_energy_j: over_blows(|blow| blow.strike_energy_j),
            strike_kinetic_energy_j: over_blows(|blow| blow.strike_kinetic_energy_j),
            delivered_work_j: quadrature(HammerQuadrature::Work),
            delivered_impulse_n_s: quadrature(HammerQuadrature::Impulse),
            arm_rms_extension_m_s: rms(arm_at_impact, first_impact_s),
            arm_rms_hammering_m_s: hammering,
            contact_count: self.contacts.count,
            largest_penetration_m: self.contacts.largest_penetration_m,
            largest_jump_force_n: self.contacts.largest_jump_force_n,
            air_used_nl: standard_litres(quadrature(HammerQuadrature::Air), system.model().gas_constant_j_per_kg_k()),
            ..first_impact(&self.recorded)
        };
        let series = PeriodicBlows::of(&self.recorded, system.model().decay_per_s(self.hammer), t);
        let metrics = series.add_to(metrics);
        let run_work_error_j = metrics.percussion.is_sure().then(|| series.delivered(|interval| interval.run_work_j));
        let blows = self.recorded.into_iter().map(|recorded| recorded.blow).collect();
        Finished { metrics, blows, run_work_error_j: run_work_error_j.flatten() }
    }
}

/// The end of a hammer's record.
pub(super) struct Finished {
    pub metrics: HammerMetrics,
    pub blows: Vec<Blow>,
    /// Standard error of the work of all hammers by the intervals between this one's blows, J.
    pub run_work_error_j: Option<f64>,
}

/// Work that all hammers have delivered, J.
fn run_work(system: &Coupled, y: &[f64]) -> f64 {
    let layout = system.model().layout();
    (0..layout.hammers).map(|hammer| y[layout.quadrature(hammer, HammerQuadrature::Work)]).sum()
}

impl OpenWindow {
    /// Follows the peaks over what of a step belongs to the window.
    fn watch(&mut self, system: &Coupled, step: &Step<'_>, Probe { support: casting, scratch }: Probe<'_>) {
        let blow = &mut self.recorded.blow;
        let model = system.model();
        let slot = &model.hammers()[blow.hammer];
        let theta = step.fraction(self.end_s);
        if system.is_closed(slot.strike) && force_reach(system, blow.hammer, step) > blow.peak_force_n {
            let support = system.guard_support(slot.strike);
            let force = |t: f64, y: &[f64]| system.contact_force(slot.strike, t, y);
            let (value, _) = peak(step, theta, Probe { support, scratch }, force);
            blow.peak_force_n = blow.peak_force_n.max(value);
        }
        if speed_reach(system, blow.hammer, step) > blow.casting_peak_velocity_m_s {
            let support = system.guard_support(slot.strike);
            let (row, chisel) =
                (model.elements().contact_row(slot.strike), model.layout().velocity(slot.points[body::CHISEL]));
            let speed = |t: f64, y: &[f64]| y[chisel] - system.relative_motion(row, t, y).1;
            let (value, _) = peak(step, theta, Probe { support, scratch }, speed);
            blow.casting_peak_velocity_m_s = blow.casting_peak_velocity_m_s.max(value);
        }
        self.watch_strike(system, step, Probe { support: casting, scratch });
    }

    /// Follows the casting's kinetic energy to its largest value, where the strike ends.
    fn watch_strike(&mut self, system: &Coupled, step: &Step<'_>, probe: Probe<'_>) {
        let (model, blow) = (system.model(), &mut self.recorded.blow);
        let largest = self.kinetic_at_start + blow.strike_kinetic_energy_j;
        let part = PartId::Casting(blow.casting);
        if model.kinetic_energy(part, |velocity| reach(step, std::iter::once((velocity, 1.0)), 0.0)) <= largest {
            return;
        }
        let kinetic = |_: f64, y: &[f64]| model.kinetic_energy(part, |velocity| y[velocity]);
        let (energy, theta) = peak(step, step.fraction(self.end_s), probe, kinetic);
        if energy > largest {
            let at = |q| step.component(model.layout().quadrature(blow.hammer, q), theta);
            blow.strike_kinetic_energy_j = energy - self.kinetic_at_start;
            blow.strike_energy_j = at(HammerQuadrature::Work) - self.recorded.work_before_j;
            blow.strike_momentum_n_s = at(HammerQuadrature::Impulse) - self.impulse_at_start;
        }
    }
}

/// Practical bound within a step of the force, were it closed, between a hammer's chisel and its casting, N; none, infinity, where they
/// are no sums of states.
fn force_reach(system: &Coupled, hammer: usize, step: &Step<'_>) -> f64 {
    let model = system.model();
    let strike = model.hammers()[hammer].strike;
    let contact = &model.elements().contacts()[strike];
    let Some([penetration, rate]) = model.contact_sums(strike) else { return f64::INFINITY };
    // The absolute force of every law is largest where both are.
    let penetration = reach(step, terms(penetration), contact.offset_m);
    contact.law.closed_force(penetration, reach(step, terms(rate), 0.0))
}

/// Practical bound within a step of the casting's velocity where a hammer strikes it, m/s; as [`force_reach`].
fn speed_reach(system: &Coupled, hammer: usize, step: &Step<'_>) -> f64 {
    let model = system.model();
    let slot = &model.hammers()[hammer];
    let chisel = model.layout().velocity(slot.points[body::CHISEL]);
    let Some([_, rate]) = model.contact_sums(slot.strike) else { return f64::INFINITY };
    reach(step, terms(rate).filter(|(component, _)| *component != chisel), 0.0)
}

/// Standard litres of a mass of gas in kg.
fn standard_litres(mass_kg: f64, gas_constant_j_per_kg_k: f64) -> f64 {
    LITRES_PER_M3 * mass_kg * gas_constant_j_per_kg_k * STANDARD_TEMPERATURE_K / STANDARD_PRESSURE_PA
}

/// Outputs of the first impact.
fn first_impact(recorded: &[Recorded]) -> HammerMetrics {
    let first = recorded.iter().map(|recorded| &recorded.blow).find(|blow| blow.kind == BlowKind::FirstImpact);
    HammerMetrics {
        first_impact_time_s: first.map(|blow| blow.start_time_s),
        first_impact_energy_j: first.map(|blow| blow.energy_j),
        first_impact_chisel_velocity_m_s: first.map(|blow| blow.chisel_velocity_m_s),
        first_impact_work_j: first.map(|blow| blow.work_j),
        first_impact_impulse_n_s: first.map(|blow| blow.impulse_n_s),
        first_impact_peak_force_n: first.map(|blow| blow.peak_force_n),
        first_impact_casting_peak_velocity_m_s: first.map(|blow| blow.casting_peak_velocity_m_s),
        first_impact_strike_momentum_n_s: first.map(|blow| blow.strike_momentum_n_s),
        first_impact_strike_energy_j: first.map(|blow| blow.strike_energy_j),
        first_impact_strike_kinetic_energy_j: first.map(|blow| blow.strike_kinetic_energy_j),
        ..HammerMetrics::default()
    }
}

/// The periodic blows of a run and what lies between them.
struct PeriodicBlows {
    periodic: Vec<Blow>,
    intervals: Vec<Interval>,
    arm: Sure,
    shown: ShownTime,
}

impl PeriodicBlows {
    /// `decay_per_s`: rate at which the energy of the mount's slowest mode decays; `end_s`: end of the run.
    fn of(recorded: &[Recorded], decay_per_s: f64, end_s: f64) -> Self {
        let periodic: Vec<&Recorded> =
            recorded.iter().filter(|recorded| recorded.blow.kind == BlowKind::Periodic).collect();
        let intervals = steady::intervals(&periodic);
        let is_impact = |blow: &&Blow| !blow.kind.is_percussion();
        let impacts = recorded.iter().map(|recorded| &recorded.blow).filter(is_impact);
        let impacts: Vec<(usize, f64)> = impacts.map(|blow| (blow.stroke, blow.start_time_s)).collect();
        let since_last_s = periodic.last().map_or(0.0, |last| end_s - last.blow.start_time_s);
        let span_s = intervals.iter().map(|interval| interval.duration_s).sum::<f64>() + since_last_s;
        Self {
            arm: steady::arm(&intervals, &impacts, decay_per_s),
            shown: ShownTime { span_s, since_last_s },
            periodic: periodic.into_iter().map(|recorded| recorded.blow.clone()).collect(),
            intervals,
        }
    }

    fn delivered(&self, work: fn(&Interval) -> f64) -> Option<f64> {
        steady::delivered(&self.intervals, work, self.shown)
    }

    /// Adds the outputs of the periodic blows to `metrics`; errors only where the percussion has settled.
    fn add_to(&self, metrics: HammerMetrics) -> HammerMetrics {
        let figures = |value: fn(&Blow) -> f64| -> Vec<f64> { self.periodic.iter().map(value).collect() };
        let (energies, works) = (figures(|blow| blow.energy_j), figures(|blow| blow.work_j));
        let (impulses, forces) = (figures(|blow| blow.impulse_n_s), figures(|blow| blow.peak_force_n));
        let speeds = figures(|blow| blow.casting_peak_velocity_m_s);
        let (momenta, given) = (figures(|blow| blow.strike_momentum_n_s), figures(|blow| blow.strike_energy_j));
        let kinetic = figures(|blow| blow.strike_kinetic_energy_j);
        let sure = metrics.percussion.is_sure();
        let error = |values: &[f64]| error_of_mean(values).filter(|_| sure);
        let frequency = steady::frequency(&self.intervals);
        HammerMetrics {
            periodic_blows: self.periodic.len() as u64,
            periodic_energy_mean_j: mean(&energies),
            periodic_energy_mean_error_j: error(&energies),
            periodic_energy_std_j: variance(&energies).map(f64::sqrt),
            hit_frequency_hz: frequency.value,
            hit_frequency_error_hz: frequency.error.filter(|_| sure),
            periodic_work_mean_j: mean(&works),
            periodic_work_mean_error_j: error(&works),
            periodic_impulse_mean_n_s: mean(&impulses),
            periodic_impulse_mean_error_n_s: error(&impulses),
            periodic_peak_force_mean_n: mean(&forces),
            periodic_peak_force_mean_error_n: error(&forces),
            periodic_casting_peak_velocity_mean_m_s: mean(&speeds),
            periodic_casting_peak_velocity_mean_error_m_s: error(&speeds),
            periodic_strike_momentum_mean_n_s: mean(&momenta),
            periodic_strike_momentum_mean_error_n_s: error(&momenta),
            periodic_strike_energy_mean_j: mean(&given),
            periodic_strike_energy_mean_error_j: error(&given),
            periodic_strike_kinetic_energy_mean_j: mean(&kinetic),
            periodic_strike_kinetic_energy_mean_error_j: error(&kinetic),
            delivered_work_error_j: self.delivered(|interval| interval.work_j).filter(|_| sure),
            arm_rms_steady_m_s: self.arm.value,
            arm_rms_steady_error_m_s: self.arm.error.filter(|_| sure),
            ..metrics
        }
    }
}

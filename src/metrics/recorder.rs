//! Watches an integration and computes the outputs as it goes; no trajectory is stored.

use crate::hammer::body;
use crate::integrate::{Observer, Step};
use crate::metrics::peak::peak;
use crate::metrics::{Blow, BlowKind, CastingMetrics, HammerMetrics, RunMetrics};
use crate::scene::OutputSettings;
use crate::system::{ContactKind, Coupled, CoupledModel, HammerQuadrature};

/// Standard litres per kg of air: 1000 / (p / (R T)) at 101325 Pa and 273.15 K.
const NORMAL_LITRES_PER_KG: f64 = 1000.0 * 287.05 * 273.15 / 101_325.0;
/// Work in J, a thousandth of a blow's, below which the energy residual is taken relative to this value instead of the
/// work put in: a hammer that never starts puts in next to nothing, and a ratio of rounding errors says nothing.
const LEAST_WORK_J: f64 = 0.01;
/// Windows of one hammer that can be open at once before memory is taken for more.
const OPEN_WINDOWS: usize = 4;

/// A blow whose window is still open.
struct Window {
    blow: Blow,
    end_s: f64,
    work_at_start: f64,
    impulse_at_start: f64,
}

/// What is remembered of one hammer.
struct HammerTrack {
    first_contact_s: Option<f64>,
    arm_integral_at_first: f64,
    contacts: u64,
    blows: usize,
    last_blow_s: f64,
    open: Vec<Window>,
}

/// What is remembered of one casting.
struct CastingTrack {
    metrics: CastingMetrics,
    heave_velocity: [usize; 1],
    /// Velocity components and coefficients of the measuring point.
    measuring_support: Vec<usize>,
    measuring_coefficients: Vec<f64>,
}

/// Computes the outputs of a run while it is integrated.
pub struct Recorder {
    settings: OutputSettings,
    hammers: Vec<HammerTrack>,
    castings: Vec<CastingTrack>,
    blows: Vec<Blow>,
    scratch: Vec<f64>,
}

impl Recorder {
    /// Prepares the recording of `model`.
    pub fn new(model: &CoupledModel, settings: &OutputSettings) -> Self {
        let layout = model.layout();
        let casting = |slot: &crate::system::CastingSlot| CastingTrack {
            metrics: CastingMetrics {
                measuring_point_peak_velocity_m_s: (!slot.measuring_point.is_empty()).then_some(0.0),
                ..CastingMetrics::default()
            },
            heave_velocity: [layout.velocity(slot.heave)],
            measuring_support: slot.measuring_point.iter().map(|(body, _)| layout.velocity(*body)).collect(),
            measuring_coefficients: slot.measuring_point.iter().map(|(_, c)| *c).collect(),
        };
        let hammer = |_| HammerTrack {
            first_contact_s: None,
            arm_integral_at_first: 0.0,
            contacts: 0,
            blows: 0,
            last_blow_s: f64::NEG_INFINITY,
            open: Vec::with_capacity(OPEN_WINDOWS),
        };
        Self {
            settings: *settings,
            hammers: (0..layout.hammers).map(hammer).collect(),
            castings: model.castings().iter().map(casting).collect(),
            blows: Vec::new(),
            scratch: vec![0.0; layout.dimension()],
        }
    }

    /// The outputs, once the end of the simulation is reached at state `y` and time `t`.
    pub fn finish(self, system: &Coupled<'_>, t: f64, y: &[f64]) -> RunMetrics {
        let mut blows = self.blows;
        blows.sort_by(|a, b| a.start_time_s.total_cmp(&b.start_time_s).then(a.hammer.cmp(&b.hammer)));
        let hammers = self
            .hammers
            .iter()
            .enumerate()
            .map(|(h, track)| hammer_metrics(h, track, &blows, &End { system, t, y }))
            .collect();
        RunMetrics {
            hammers,
            castings: self.castings.into_iter().map(|track| track.metrics).collect(),
            blows,
            energy_residual: energy_residual(system, t, y),
        }
    }

    /// Updates the open windows of hammer `h`; moves those that end within the step to the finished blows.
    fn windows(&mut self, h: usize, system: &Coupled<'_>, step: &Step<'_>) {
        let model = system.model();
        let slot = &model.hammers()[h];
        let support = crate::integrate::System::guard_support(system, slot.strike);
        let row = model.elements().contact_row(slot.strike);
        let chisel = model.layout().velocity(slot.points[body::CHISEL]);
        let closed = system.is_closed(slot.strike);
        let track = &mut self.hammers[h];
        let [largest_force, largest_speed] = strike_reach(system, h, step);
        for window in &mut track.open {
            let theta = step.fraction(window.end_s);
            let blow = &mut window.blow;
            if closed && largest_force > blow.peak_force_n {
                let force = |t: f64, y: &[f64]| system.contact_force(slot.strike, t, y);
                let (value, _) = peak(step, theta, (support, &mut self.scratch), force);
                blow.peak_force_n = blow.peak_force_n.max(value);
            }
            if largest_speed > blow.casting_peak_velocity_m_s {
                let speed = |t: f64, y: &[f64]| y[chisel] - system.relative_motion(row, t, y).1;
                let (value, _) = peak(step, theta, (support, &mut self.scratch), speed);
                blow.casting_peak_velocity_m_s = blow.casting_peak_velocity_m_s.max(value);
            }
        }
        let quadrature = |q, theta| step.component(model.layout().quadrature(h, q), theta);
        let mut at = 0;
        while at < track.open.len() {
            if track.open[at].end_s > step.t1() {
                at += 1;
                continue;
            }
            let mut window = track.open.remove(at);
            let theta = step.fraction(window.end_s);
            window.blow.work_j = quadrature(HammerQuadrature::Work, theta) - window.work_at_start;
            window.blow.impulse_n_s = quadrature(HammerQuadrature::Impulse, theta) - window.impulse_at_start;
            self.blows.push(window.blow);
        }
    }

    /// Starts a blow of hammer `h`.
    fn start_blow(&mut self, h: usize, kind: BlowKind, model: &CoupledModel, (t, y): (f64, &[f64])) {
        let slot = &model.hammers()[h];
        let track = &mut self.hammers[h];
        let quadrature = |q| y[model.layout().quadrature(h, q)];
        track.open.push(Window {
            blow: Blow {
                hammer: h,
                casting: slot.casting,
                number: track.blows,
                kind,
                start_time_s: t,
                energy_j: model.impact_energy(h, y),
                chisel_velocity_m_s: y[model.layout().velocity(slot.points[body::CHISEL])],
                work_j: 0.0,
                impulse_n_s: 0.0,
                peak_force_n: 0.0,
                casting_peak_velocity_m_s: 0.0,
            },
            end_s: t + self.settings.blow_window_s,
            work_at_start: quadrature(HammerQuadrature::Work),
            impulse_at_start: quadrature(HammerQuadrature::Impulse),
        });
        track.blows += 1;
        track.last_blow_s = t;
    }
}

impl Observer<Coupled<'_>> for Recorder {
    fn step(&mut self, system: &Coupled<'_>, step: &Step<'_>) {
        for h in 0..self.hammers.len() {
            if !self.hammers[h].open.is_empty() {
                self.windows(h, system, step);
            }
        }
        for track in &mut self.castings {
            track.update(step, &mut self.scratch);
        }
    }

    fn event(&mut self, system: &Coupled<'_>, guard: usize, t: f64, y: &[f64]) {
        if !system.is_closed(guard) {
            return;
        }
        let model = system.model();
        let contact = &model.elements().contacts()[guard];
        let h = contact.hammer;
        match contact.kind {
            ContactKind::ChiselCasting => {
                self.hammers[h].contacts += 1;
                if self.hammers[h].first_contact_s.is_none() {
                    let arm = model.layout().quadrature(h, HammerQuadrature::ArmVelocitySquared);
                    self.hammers[h].first_contact_s = Some(t);
                    self.hammers[h].arm_integral_at_first = y[arm];
                    self.start_blow(h, BlowKind::FirstImpact, model, (t, y));
                }
            }
            ContactKind::PistonChisel if system.gate_open(h) => {
                let (_, closing) = system.penetration(guard, t, y);
                let separate = t - self.hammers[h].last_blow_s >= self.settings.blow_separation_s;
                if separate && closing >= self.settings.blow_closing_speed_m_s {
                    let settling = self.hammers[h].blows <= self.settings.settling_blows;
                    let kind = if settling { BlowKind::Settling } else { BlowKind::Periodic };
                    self.start_blow(h, kind, model, (t, y));
                }
            }
            _ => {}
        }
    }
}

/// Practical bound of the absolute value that a sum of components with coefficients, less `offset`, takes within a step.
fn reach(step: &Step<'_>, terms: impl Iterator<Item = (usize, f64)> + Clone, offset: f64) -> f64 {
    let start = terms.clone().map(|(index, c)| c * step.start()[index]).sum::<f64>() - offset;
    start.abs() + step.h * step.largest_rate(terms)
}

/// Practical bounds within a step of the force, were it closed, between a hammer's chisel and its casting, N, and of the
/// casting's velocity there, m/s.
fn strike_reach(system: &Coupled<'_>, hammer: usize, step: &Step<'_>) -> [f64; 2] {
    let model = system.model();
    let (layout, elements, slot) = (model.layout(), model.elements(), &model.hammers()[hammer]);
    let contact = &elements.contacts()[slot.strike];
    // Chisel and casting are bodies: no point of the structure is among them.
    let row = || elements.row(elements.contact_row(slot.strike));
    let velocities = || row().map(|(body, c)| (layout.velocity(body), c));
    let penetration = reach(step, row().map(|(body, c)| (layout.position(body), c)), contact.offset_m);
    // The absolute force of every law is largest where both are.
    let force = contact.law.closed_force(penetration, reach(step, velocities(), 0.0));
    let chisel = layout.velocity(slot.points[body::CHISEL]);
    [force, reach(step, velocities().filter(|(index, _)| *index != chisel), 0.0)]
}

impl CastingTrack {
    /// Updates the peaks; a step that cannot exceed them is left at once.
    fn update(&mut self, step: &Step<'_>, scratch: &mut [f64]) {
        let [heave] = self.heave_velocity;
        if reach(step, [(heave, 1.0)].into_iter(), 0.0) > self.metrics.peak_velocity_m_s {
            let (value, theta) = peak(step, step.theta_end, (&self.heave_velocity, scratch), |_, y| y[heave]);
            if value > self.metrics.peak_velocity_m_s {
                self.metrics.peak_velocity_m_s = value;
                self.metrics.peak_velocity_time_s = step.time(theta);
            }
        }
        if let Some(largest) = &mut self.metrics.measuring_point_peak_velocity_m_s {
            let (support, coefficients) = (&self.measuring_support, &self.measuring_coefficients);
            let terms = || support.iter().copied().zip(coefficients.iter().copied());
            if reach(step, terms(), 0.0) > *largest {
                let speed = |_: f64, y: &[f64]| terms().map(|(index, c)| c * y[index]).sum::<f64>();
                let (value, _) = peak(step, step.theta_end, (support, scratch), speed);
                *largest = largest.max(value);
            }
        }
    }
}

/// The end of a simulation.
struct End<'a> {
    system: &'a Coupled<'a>,
    t: f64,
    y: &'a [f64],
}

fn hammer_metrics(h: usize, track: &HammerTrack, blows: &[Blow], end: &End<'_>) -> HammerMetrics {
    let layout = end.system.model().layout();
    let quadrature = |q| end.y[layout.quadrature(h, q)];
    let own = || blows.iter().filter(|blow| blow.hammer == h);
    let first = own().find(|blow| blow.kind == BlowKind::FirstImpact);
    let periodic: Vec<&Blow> = own().filter(|blow| blow.kind == BlowKind::Periodic).collect();
    let mean = |value: fn(&Blow) -> f64| mean(periodic.iter().map(|blow| value(blow)));
    let energy_mean = mean(|blow| blow.energy_j);
    let variance = energy_mean
        .and_then(|energy| self::mean(periodic.iter().map(|blow| (blow.energy_j - energy) * (blow.energy_j - energy))));
    let arm_total = quadrature(HammerQuadrature::ArmVelocitySquared);
    let rms = |integral: f64, duration: f64| (duration > 0.0).then(|| (integral.max(0.0) / duration).sqrt());
    let extension = track.first_contact_s.unwrap_or(end.t);
    let arm_extension = if track.first_contact_s.is_some() { track.arm_integral_at_first } else { arm_total };
    HammerMetrics {
        first_impact_time_s: first.map(|blow| blow.start_time_s),
        first_impact_energy_j: first.map(|blow| blow.energy_j),
        first_impact_chisel_velocity_m_s: first.map(|blow| blow.chisel_velocity_m_s),
        first_impact_work_j: first.map(|blow| blow.work_j),
        first_impact_impulse_n_s: first.map(|blow| blow.impulse_n_s),
        first_impact_peak_force_n: first.map(|blow| blow.peak_force_n),
        first_impact_casting_peak_velocity_m_s: first.map(|blow| blow.casting_peak_velocity_m_s),
        periodic_blow_count: own().filter(|blow| blow.kind != BlowKind::FirstImpact).count() as u64,
        periodic_energy_mean_j: energy_mean,
        periodic_energy_std_j: variance.map(f64::sqrt),
        hit_frequency_hz: hit_frequency(&periodic),
        periodic_work_mean_j: mean(|blow| blow.work_j),
        periodic_impulse_mean_n_s: mean(|blow| blow.impulse_n_s),
        periodic_peak_force_mean_n: mean(|blow| blow.peak_force_n),
        periodic_casting_peak_velocity_mean_m_s: mean(|blow| blow.casting_peak_velocity_m_s),
        arm_rms_extension_m_s: rms(arm_extension, extension),
        arm_rms_hammering_m_s: track
            .first_contact_s
            .and_then(|t| rms(arm_total - track.arm_integral_at_first, end.t - t)),
        contact_count: track.contacts,
        air_used_nl: NORMAL_LITRES_PER_KG * quadrature(HammerQuadrature::Air),
    }
}

/// `(n - 1) / (t_n - t_1)`; needs two blows.
fn hit_frequency(periodic: &[&Blow]) -> Option<f64> {
    let (first, last) = (periodic.first()?, periodic.last()?);
    let span = last.start_time_s - first.start_time_s;
    (span > 0.0).then(|| (periodic.len() - 1) as f64 / span)
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> Option<f64> {
    let count = values.len();
    (count > 0).then(|| values.sum::<f64>() / count as f64)
}

/// (work put in - stored - dissipated) / (work put in), stored energy relative to rest.
fn energy_residual(system: &Coupled<'_>, t: f64, y: &[f64]) -> f64 {
    let model = system.model();
    let put_in = y[model.layout().work_in()];
    let at_rest = Coupled::new(model).stored_energy(0.0, model.initial_state());
    let stored = system.stored_energy(t, y) - at_rest;
    (put_in - stored - system.dissipated_energy(t, y)) / put_in.abs().max(LEAST_WORK_J)
}

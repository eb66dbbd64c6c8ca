//! What arrives at the core points: shock spectra and doses, computed as the run goes on.

use schemars::JsonSchema;
use serde::Serialize;

use super::blow::{Blow, BlowKind};
use super::casting::PointPeak;
use super::residual::ResidualTrack;
use crate::integrate::Step;
use crate::scene::{OutputSettings, PartId, PointId, Scene};
use crate::system::{Coupled, CoupledModel};
use decore_math::shock::{BAND, Damage, Oscillators, Piece, Propagator, ShockMotion, ShockResponse, Watch, lowest_hz};
use decore_quantity::quantities;

quantities! {
    /// Outputs of one core point. Pseudo-velocities are those of oscillators on the point, a third of an octave apart, from 98 Hz to 10 kHz.
    #[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
    pub struct CoreMetrics {
        /// Largest absolute velocity of the core point along the strike.
        pub peak_velocity_m_s: f64 => "m/s",
        /// Largest pseudo-velocity within the windows of the hammers' first impacts, 98 Hz to 10 kHz.
        pub first_impact_pseudo_velocity_98hz_10khz_m_s: Option<f64> => "m/s",
        /// Mean of the periodic blows' largest pseudo-velocity, each within its window, 98 Hz to 10 kHz. Blows whose windows overlap count
        /// once.
        pub periodic_pseudo_velocity_98hz_10khz_mean_m_s: Option<f64> => "m/s",
        /// Largest pseudo-velocity of the run, 98 Hz to 10 kHz.
        pub pseudo_velocity_98hz_10khz_m_s: Option<f64> => "m/s",
        /// Natural frequency of the oscillator with the largest pseudo-velocity of the run.
        pub pseudo_velocity_frequency_hz: Option<f64> => "Hz",
        /// Number of blows, first impacts included, with a pseudo-velocity of at least `outputs.core_threshold_m_s`.
        pub blows_above_threshold: Option<u64> => "1",
        /// Sum over the blows of half the square of the point's largest velocity within the blow's window. Blows whose windows overlap count
        /// once.
        pub blow_energy_per_mass_j_per_kg: Option<f64> => "J/kg",
        /// Dose of the run: the sum over an oscillator's cycles of (pseudo-velocity / `outputs.core_dose_reference_m_s`) to the power
        /// `outputs.core_dose_exponent`, the largest over 98 Hz to 10 kHz.
        pub dose_98hz_10khz: Option<f64> => "1",
        /// Natural frequency of the oscillator with the largest dose.
        pub dose_frequency_hz: Option<f64> => "Hz",
        /// Growth of the dose per second from the end of the first impact's window to the end of the run, the largest over 98 Hz to 10 kHz.
        /// None without a first impact.
        pub dose_rate_98hz_10khz_per_s: Option<f64> => "1/s",
        /// Time at which the dose reaches `outputs.core_wanted_dose`; beyond the run it is extrapolated with the mean rate since the first
        /// impact's window. None where the dose does not grow.
        pub time_to_dose_s: Option<f64> => "s" [less],
        /// Probability 1 - exp(-(v / `outputs.core_strength_m_s`)^`outputs.core_strength_exponent`) that the core is broken by its largest
        /// pseudo-velocity v: equal blows add nothing.
        pub break_probability: Option<f64> => "1",
        /// The whole spectra; `None` unless `outputs.core_spectra` asks for them.
        pub spectrum: Option<CoreSpectrum>,
    }
}

/// Shock spectra of a core point, oscillator by oscillator.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
pub struct CoreSpectrum {
    /// Largest pseudo-velocities within the windows of the hammers' first impacts, m/s; 0 without a first impact.
    pub first_impact_pseudo_velocity_m_s: Vec<f64>,
    /// Largest pseudo-velocities of the run, m/s.
    pub pseudo_velocity_m_s: Vec<f64>,
}

quantities! {
    /// Outputs over all core points: the point that gets least is the one that decides.
    #[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
    pub struct CoreTotals {
        /// Least over the core points of the largest pseudo-velocity of the run, 98 Hz to 10 kHz.
        pub least_core_pseudo_velocity_98hz_10khz_m_s: Option<f64> => "m/s",
        /// The core point that gets least: CASTING.NAME.
        pub least_core: String => "",
        /// Least over the core points of the largest pseudo-velocity within the windows of the hammers' first impacts, 98 Hz to
        /// 10 kHz.
        pub least_core_first_impact_pseudo_velocity_98hz_10khz_m_s: Option<f64> => "m/s",
        /// Least dose over the core points.
        pub least_core_dose_98hz_10khz: Option<f64> => "1",
        /// Longest of the core points' times to the wanted dose. None where a point never reaches it.
        pub longest_core_time_to_dose_s: Option<f64> => "s" [less],
    }
}

/// Natural frequencies in Hz of the oscillators of [`CoreSpectrum`].
pub fn spectrum_frequencies_hz() -> [f64; BAND] {
    Oscillators::new(lowest_hz(), 1.0).frequencies_hz()
}

/// Blows whose windows overlap, as the core points of their casting saw them.
struct Seen {
    /// Hammer and number of each blow.
    blows: Vec<(usize, usize)>,
    /// Whether one of them is a hammer's first impact.
    has_first: bool,
    /// Of each point of the casting: largest pseudo-velocity and largest velocity, m/s.
    points: Vec<[f64; 2]>,
}

/// What is remembered of one core point.
struct CorePointTrack {
    /// Its shares in the motions of its casting.
    shares: Vec<f64>,
    response: ShockResponse,
    first_impact: Option<[f64; BAND]>,
    /// Its largest velocity in the present window.
    largest: PointPeak,
    /// End of the first impact's window in s, and the doses then.
    since: Option<(f64, [f64; BAND])>,
    wanted: Option<Wanted>,
}

/// How far a dose is from the one that is wanted.
struct Wanted {
    dose: f64,
    reached_s: Option<f64>,
}

/// A motion of which those of points are sums: of a rigid casting's freedoms, or of the points themselves where these are fewer.
struct Motion {
    /// Its velocity as a sum of components of the state.
    velocity: Vec<(usize, f64)>,
    /// The present step.
    piece: Piece,
}

/// The core points of one casting.
struct CastingCores {
    motions: Vec<Motion>,
    /// The oscillators on each of the motions.
    shocks: Vec<ShockMotion>,
    /// What the residual flexibility of an elastic casting adds to each of the motions.
    residual: Option<ResidualTrack>,
    points: Vec<CorePointTrack>,
    /// The window that is open, and when it ends.
    open: Option<(Seen, f64)>,
    seen: Vec<Seen>,
}

/// The core points of a scene; none where no spectra are asked for.
pub(super) struct CoreTracks {
    settings: OutputSettings,
    oscillators: Oscillators,
    castings: Vec<CastingCores>,
}

impl CoreTracks {
    pub fn new(model: &CoupledModel, scene: &Scene) -> Option<Self> {
        let settings = scene.outputs.clone();
        let any = scene.castings.iter().any(|casting| !casting.cores.is_empty());
        (settings.core_spectra && any).then(|| Self {
            oscillators: Oscillators::new(lowest_hz(), settings.core_quality_factor),
            castings: (0..scene.castings.len()).map(|c| CastingCores::new(model, scene, c)).collect(),
            settings,
        })
    }

    /// A blow on a casting begins; its window ends at `end_s`. Blows whose windows overlap are seen together.
    pub fn open(&mut self, blow: &Blow, end_s: f64) {
        let cores = &mut self.castings[blow.casting];
        let is_first = blow.kind == BlowKind::FirstImpact;
        let watch = if is_first { Watch::Spectrum } else { Watch::Largest };
        match &mut cores.open {
            Some((seen, end)) => {
                seen.blows.push((blow.hammer, blow.number));
                if is_first {
                    seen.has_first = true;
                    cores.points.iter_mut().for_each(|point| point.response.watch(watch));
                }
                *end = end_s.max(*end);
            }
            none => {
                let seen = Seen { blows: vec![(blow.hammer, blow.number)], has_first: is_first, points: Vec::new() };
                *none = Some((seen, end_s));
                for point in &mut cores.points {
                    point.response.open(watch);
                }
            }
        }
    }

    /// A contact has closed or opened.
    pub fn event(&mut self) {
        self.castings.iter_mut().filter_map(|cores| cores.residual.as_mut()).for_each(ResidualTrack::jump);
    }

    /// Follows a step in pieces that are short enough, cut where windows end.
    pub fn step(&mut self, system: &Coupled, step: &Step<'_>, scratch: &mut [f64]) {
        for cores in &mut self.castings {
            for motion in &mut cores.motions {
                motion.piece.acceleration_m_s2 = step.rate(&motion.velocity);
            }
            let Some(residual) = &mut cores.residual else { continue };
            residual.step(system, step, scratch);
            for (point, motion) in cores.motions.iter_mut().enumerate() {
                motion.piece.residual_m = residual.motion(point, step.theta_end);
            }
        }
        for cores in self.castings.iter_mut().filter(|cores| cores.open.is_some()) {
            cores.points.iter_mut().for_each(|point| point.largest.follow(step, scratch));
        }
        let mut from = 0.0;
        while from < step.theta_end {
            let ends = self.castings.iter().filter_map(|cores| Some(step.fraction(cores.open.as_ref()?.1)));
            let to = ends.filter(|end| *end > from).fold(step.theta_end, f64::min);
            self.pieces(step, from, to);
            let now = step.time(to);
            let is_over = |end_s: f64| end_s <= now || to < step.theta_end && step.fraction(end_s) <= to;
            self.castings.iter_mut().for_each(|cores| cores.close_if(is_over, now));
            from = to;
        }
    }

    /// Follows a part of a step in equal pieces.
    fn pieces(&mut self, step: &Step<'_>, from: f64, to: f64) {
        let whole_s = (to - from) * step.h;
        let count = (whole_s / self.oscillators.longest_s()).ceil().max(1.0);
        let share = (to - from) / count;
        let propagator = Propagator::new(&self.oscillators, whole_s / count);
        for piece in 0..count as u64 {
            let at = from + piece as f64 * share;
            let end_s = step.time(at + share);
            for cores in &mut self.castings {
                for (shock, motion) in cores.shocks.iter_mut().zip(&cores.motions) {
                    shock.advance(&self.oscillators, &propagator, motion.piece.part(at, share));
                }
                for point in &mut cores.points {
                    point.response.follow(&self.oscillators, &propagator, (&cores.shocks, &point.shares));
                    point.note_dose(end_s);
                }
            }
        }
    }

    /// Adds what the core points saw to their outputs, which are in the order of the scene.
    pub fn finish(self, end_s: f64, blows: &[Blow], metrics: &mut [CoreMetrics]) {
        let frequencies_hz = self.oscillators.frequencies_hz();
        let mut metrics = metrics.iter_mut();
        for mut cores in self.castings {
            cores.close(end_s);
            let seen = cores.seen;
            for (place, (point, to)) in cores.points.into_iter().zip(&mut metrics).enumerate() {
                point.finish(to, (&frequencies_hz, end_s), &self.settings);
                by_blows(to, &seen, (place, blows), self.settings.core_threshold_m_s);
            }
        }
    }
}

impl CastingCores {
    fn new(model: &CoupledModel, scene: &Scene, casting: usize) -> Self {
        let outputs = &scene.outputs;
        let damage = outputs.core_dose_reference_m_s.map(|reference_m_s| Damage {
            reference_m_s,
            exponent: outputs.core_dose_exponent,
            threshold_m_s: outputs.core_dose_threshold_m_s,
        });
        let velocities = model.velocities(PartId::Casting(casting));
        let velocity = |core: usize| {
            let [_, velocity] = model.point_sums(PointId::Core { casting, core }).unwrap_or_default();
            velocity
        };
        let rows: Vec<_> = (0..scene.castings[casting].cores.len()).map(velocity).collect();
        let points: Vec<_> = (0..rows.len()).map(|core| PointId::Core { casting, core }).collect();
        let residual = ResidualTrack::new(model, &points);
        let by_freedoms = velocities.len() < rows.len() && residual.is_none();
        let motions = if by_freedoms { velocities.clone().map(|at| vec![(at, 1.0)]).collect() } else { rows.clone() };
        let shares = |core: usize, row: &[(usize, f64)]| {
            let share = |place: usize| match by_freedoms {
                true => row.iter().filter(|(at, _)| *at == velocities.start + place).map(|(_, c)| c).sum(),
                false => f64::from(u8::from(place == core)),
            };
            (0..motions.len()).map(share).collect()
        };
        let point = |(core, row): (usize, &Vec<(usize, f64)>)| CorePointTrack {
            shares: shares(core, row),
            response: ShockResponse::new(damage),
            first_impact: None,
            largest: PointPeak::new(velocities.start, row),
            since: None,
            wanted: outputs.core_wanted_dose.map(|dose| Wanted { dose, reached_s: None }),
        };
        let points = rows.iter().enumerate().map(point).collect();
        let shocks = vec![ShockMotion::AT_REST; motions.len()];
        let motions = motions.into_iter().map(|velocity| Motion { velocity, piece: Piece::default() }).collect();
        Self { motions, shocks, residual, points, open: None, seen: Vec::new() }
    }

    fn close_if(&mut self, ended: impl Fn(f64) -> bool, now_s: f64) {
        if self.open.as_ref().is_some_and(|(_, end_s)| ended(*end_s)) {
            self.close(now_s);
        }
    }

    /// Ends the window that is open.
    fn close(&mut self, now_s: f64) {
        let Some((mut seen, _)) = self.open.take() else { return };
        for point in &mut self.points {
            let window = point.response.open(Watch::Nothing);
            let largest = window.iter().fold(0.0_f64, |largest, one| largest.max(*one));
            seen.points.push([largest, point.largest.take()]);
            if seen.has_first {
                let before = point.first_impact.unwrap_or_default();
                point.first_impact = Some(std::array::from_fn(|k| before[k].max(window[k])));
                point.since.get_or_insert_with(|| (now_s, point.response.doses()));
            }
        }
        self.seen.push(seen);
    }
}

impl CorePointTrack {
    /// Notes when the dose that is wanted is reached.
    fn note_dose(&mut self, now_s: f64) {
        let Some(wanted) = self.wanted.as_mut().filter(|wanted| wanted.reached_s.is_none()) else { return };
        if self.response.has_dose(wanted.dose) {
            wanted.reached_s = Some(now_s);
        }
    }

    fn finish(self, to: &mut CoreMetrics, (frequencies_hz, end_s): (&[f64; BAND], f64), settings: &OutputSettings) {
        let run = self.response.spectrum_m_s();
        let best = largest_at(run);
        let pseudo_velocity = run[best];
        to.pseudo_velocity_98hz_10khz_m_s = Some(pseudo_velocity);
        to.pseudo_velocity_frequency_hz = Some(frequencies_hz[best]);
        to.first_impact_pseudo_velocity_98hz_10khz_m_s = self.first_impact.map(|window| window[largest_at(&window)]);
        to.break_probability = settings
            .core_strength_m_s
            .map(|strength| -libm::expm1(-libm::pow(pseudo_velocity / strength, settings.core_strength_exponent)));
        if settings.core_dose_reference_m_s.is_some() {
            let doses = self.response.doses();
            let most = largest_at(&doses);
            to.dose_98hz_10khz = Some(doses[most]);
            to.dose_frequency_hz = Some(frequencies_hz[most]);
            let rates = self.since.filter(|(since_s, _)| *since_s < end_s).map(|(since_s, before)| {
                std::array::from_fn::<f64, BAND, _>(|k| (doses[k] - before[k]) / (end_s - since_s))
            });
            to.dose_rate_98hz_10khz_per_s = rates.map(|rates| rates[largest_at(&rates)]);
            to.time_to_dose_s = self.wanted.and_then(|wanted| wanted.time_s((&doses, end_s), rates.as_ref()));
        }
        to.spectrum = Some(CoreSpectrum {
            first_impact_pseudo_velocity_m_s: self.first_impact.unwrap_or([0.0; BAND]).to_vec(),
            pseudo_velocity_m_s: run.to_vec(),
        });
    }
}

impl Wanted {
    /// When the dose is reached, within the run or beyond it at these rates in 1/s.
    fn time_s(&self, (doses, end_s): (&[f64; BAND], f64), rates: Option<&[f64; BAND]>) -> Option<f64> {
        if self.reached_s.is_some() {
            return self.reached_s;
        }
        let times = doses.iter().zip(rates?).map(|(dose, rate)| end_s + (self.dose - dose) / rate);
        Some(times.fold(f64::INFINITY, f64::min)).filter(|time| time.is_finite())
    }
}

/// Adds the figures over blows to the outputs of the point at a place of its casting.
fn by_blows(to: &mut CoreMetrics, seen: &[Seen], (place, blows): (usize, &[Blow]), threshold_m_s: f64) {
    let kind = |hammer: usize, number: usize| {
        let mut of_run = blows.iter().filter(|blow| blow.hammer == hammer && blow.number == number);
        of_run.next().map(|blow| blow.kind)
    };
    let (mut periodic, mut count, mut above, mut energy) = (0.0, 0_u64, 0, 0.0);
    for one in seen {
        let [pseudo_velocity, velocity] = one.points[place];
        let kinds = || one.blows.iter().map(|(hammer, number)| kind(*hammer, *number));
        if kinds().all(|kind| kind == Some(BlowKind::Periodic)) {
            (periodic, count) = (periodic + pseudo_velocity, count + 1);
        }
        let struck = kinds().filter(|kind| *kind != Some(BlowKind::Blank)).count() as u64;
        if pseudo_velocity >= threshold_m_s {
            above += struck;
        }
        if struck > 0 {
            energy += 0.5 * velocity * velocity;
        }
    }
    to.periodic_pseudo_velocity_98hz_10khz_mean_m_s = (count > 0).then(|| periodic / count as f64);
    (to.blows_above_threshold, to.blow_energy_per_mass_j_per_kg) = (Some(above), Some(energy));
}

/// Place of the largest value, the first of equals.
fn largest_at(values: &[f64; BAND]) -> usize {
    (0..BAND).fold(0, |best, k| if values[k] > values[best] { k } else { best })
}

impl CoreTotals {
    /// Those of core points with their names; `None` without spectra.
    pub fn of(cores: &[CoreMetrics], names: &[String]) -> Option<Self> {
        let least = |value: fn(&CoreMetrics) -> Option<f64>| {
            let values: Option<Vec<f64>> = cores.iter().map(value).collect();
            values.filter(|values| !values.is_empty())
        };
        let first = |values: Vec<f64>| {
            (0..values.len()).reduce(|best, k| if values[k] < values[best] { k } else { best }).map(|k| (k, values[k]))
        };
        let (place, pseudo_velocity) = least(|core| core.pseudo_velocity_98hz_10khz_m_s).and_then(first)?;
        let smallest = |value| least(value).and_then(first).map(|(_, value)| value);
        let times = least(|core| core.time_to_dose_s);
        Some(Self {
            least_core_pseudo_velocity_98hz_10khz_m_s: Some(pseudo_velocity),
            least_core: names.get(place).cloned().unwrap_or_default(),
            least_core_first_impact_pseudo_velocity_98hz_10khz_m_s: smallest(|core| {
                core.first_impact_pseudo_velocity_98hz_10khz_m_s
            }),
            least_core_dose_98hz_10khz: smallest(|core| core.dose_98hz_10khz),
            longest_core_time_to_dose_s: times.and_then(|times| times.into_iter().reduce(f64::max)),
        })
    }
}

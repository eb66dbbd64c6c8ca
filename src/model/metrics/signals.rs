//! Time signals of a run on a uniform grid, read off the dense output.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::hammer::body;
use crate::integrate::{Observer, Step};
use crate::scene::{FixtureId, HammerLink, Owner, PartId, PointId, Scene};
use crate::system::{Coupled, CoupledModel, HammerQuadrature};
use decore_quantity::{Quantity, quantities};

/// What a signal is of; hammers, castings, a casting's fixtures and points by their places in the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SignalOf {
    /// The run.
    Run,
    /// A hammer.
    Hammer(usize),
    /// A casting.
    Casting(usize),
    /// A fixture: its casting, its place among that casting's.
    Fixture(usize, usize),
    /// A core point: its casting, its place among that casting's.
    Core(usize, usize),
    /// A watched point of the machine.
    Point(usize),
}

/// One signal: name, unit, description, values on the grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Signal {
    /// Column name, with the unit as its suffix.
    pub name: String,
    /// What it is of.
    pub of: SignalOf,
    /// The quantity, by the name that it has for all that it can be of.
    pub quantity: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// What it is.
    pub description: String,
    /// One value per instant.
    pub values: Vec<f64>,
}

quantities! {
    /// The instant of a row of signals.
    #[derive(Debug)]
    pub struct Instant {
        /// time
        pub time_s: f64 => "s",
    }
}

quantities! {
    /// Signals of a hammer at one instant.
    #[derive(Debug)]
    pub struct HammerSignals {
        /// telescope extension
        pub extension_m: f64 => "m",
        /// piston position in the cylinder
        pub piston_m: f64 => "m",
        /// spool position in the cylinder
        pub spool_m: f64 => "m",
        /// chisel position in the cylinder
        pub chisel_m: f64 => "m",
        /// cylinder velocity
        pub cylinder_velocity_m_s: f64 => "m/s",
        /// piston velocity
        pub piston_velocity_m_s: f64 => "m/s",
        /// chisel velocity
        pub chisel_velocity_m_s: f64 => "m/s",
        /// pressure in the telescope's top chamber (P1)
        pub pressure_top_pa: f64 => "Pa",
        /// pressure in the telescope's annulus (P2)
        pub pressure_annulus_pa: f64 => "Pa",
        /// pressure behind the piston (P3)
        pub pressure_rear_pa: f64 => "Pa",
        /// pressure before the piston (P4)
        pub pressure_front_pa: f64 => "Pa",
        /// velocity of the structure at the mount
        pub arm_velocity_m_s: f64 => "m/s",
        /// force of the chisel on the casting
        pub casting_force_n: f64 => "N",
        /// velocity of the casting at the strike point
        pub casting_velocity_m_s: f64 => "m/s",
        /// work on the casting so far
        pub delivered_work_j: f64 => "J",
        /// impulse on the casting so far
        pub delivered_impulse_n_s: f64 => "N s",
        /// force of the piston on the chisel
        pub percussion_force_n: f64 => "N",
        /// spool velocity
        pub spool_velocity_m_s: f64 => "m/s",
        /// displacement of the structure at the mount, from its static equilibrium
        pub arm_displacement_m: f64 => "m",
        /// force of the telescope on its guide beyond that at rest: what the mount carries but for the guide's own inertia
        pub mount_force_n: f64 => "N",
        /// force between the telescope and its top stop
        pub top_stop_force_n: f64 => "N",
        /// force between the telescope and the end of its stroke
        pub end_stop_force_n: f64 => "N",
        /// force between the piston and the cylinder's rear wall
        pub rear_wall_force_n: f64 => "N",
        /// force between the chisel and the cylinder's nose
        pub nose_force_n: f64 => "N",
        /// force between the chisel and its retainer
        pub retainer_force_n: f64 => "N",
        /// force between the spool and its rear stop
        pub spool_rear_force_n: f64 => "N",
        /// force between the spool and its front stop
        pub spool_front_force_n: f64 => "N",
        /// cylinder acceleration
        pub cylinder_acceleration_m_s2: f64 => "m/s2",
        /// piston acceleration
        pub piston_acceleration_m_s2: f64 => "m/s2",
        /// chisel acceleration
        pub chisel_acceleration_m_s2: f64 => "m/s2",
        /// displacement of the casting at the strike point, from rest
        pub casting_displacement_m: f64 => "m",
    }
}

quantities! {
    /// Signals of a casting at one instant.
    #[derive(Debug)]
    pub struct CastingSignals {
        /// heave
        pub heave_m: f64 => "m",
        /// heave velocity
        pub heave_velocity_m_s: f64 => "m/s",
        /// rotation about x; 0 for a casting that does not need it
        pub rotation_x_rad: f64 => "rad",
        /// rotation about y; 0 for a casting that does not need it
        pub rotation_y_rad: f64 => "rad",
        /// heave acceleration
        pub heave_acceleration_m_s2: f64 => "m/s2",
        /// velocity of the measuring point, of the centre of mass where none is chosen
        pub measuring_point_velocity_m_s: f64 => "m/s",
        /// acceleration of the measuring point, of the centre of mass where none is chosen
        pub measuring_point_acceleration_m_s2: f64 => "m/s2",
        /// displacement of the measuring point, of the centre of mass where none is chosen, from rest
        pub measuring_point_displacement_m: f64 => "m",
    }
}

quantities! {
    /// Signals of a fixture at one instant.
    #[derive(Debug)]
    pub struct FixtureSignals {
        /// force of the casting on the structure
        pub force_n: f64 => "N",
        /// displacement of the structure at the fixture, from its static equilibrium
        pub point_displacement_m: f64 => "m",
        /// velocity of the structure at the fixture
        pub point_velocity_m_s: f64 => "m/s",
        /// displacement of the casting at the fixture, from rest
        pub casting_displacement_m: f64 => "m",
    }
}

quantities! {
    /// Signals of a watched point of the machine at one instant.
    #[derive(Debug)]
    pub struct PointSignals {
        /// displacement of the structure, from its static equilibrium
        pub displacement_m: f64 => "m",
        /// velocity of the structure
        pub velocity_m_s: f64 => "m/s",
    }
}

quantities! {
    /// The energy balance at one instant: work put in is what is stored and what is dissipated.
    #[derive(Debug)]
    pub struct EnergySignals {
        /// work put in by gas and gravity so far
        pub work_put_in_j: f64 => "J",
        /// energy stored, relative to rest
        pub stored_energy_j: f64 => "J",
        /// energy dissipated so far
        pub dissipated_energy_j: f64 => "J",
        /// work put in less what is stored and dissipated: what the balance leaves
        pub energy_unaccounted_j: f64 => "J",
    }
}

/// A state within a step.
#[derive(Clone, Copy)]
struct State<'a> {
    system: &'a Coupled,
    step: &'a Step<'a>,
    time_s: f64,
    y: &'a [f64],
    /// Displacement and velocity of the points of castings as sums of components.
    sums: &'a PointSums,
}

/// Displacement and velocity of points as sums of components of the state.
type PointSums = BTreeMap<PointId, [Vec<(usize, f64)>; 2]>;

impl State<'_> {
    /// Acceleration of a body: the slope of its velocity's dense output, of which the rates at the ends are those of the model.
    fn acceleration(&self, body: usize) -> f64 {
        let velocity = self.system.model().layout().velocity(body);
        self.step.slope(velocity, self.step.fraction(self.time_s))
    }

    /// Displacement, velocity and acceleration of a point of a casting.
    fn motion(&self, point: PointId) -> [f64; 3] {
        let theta = self.step.fraction(self.time_s);
        let sum = |terms: &[(usize, f64)], of: &dyn Fn(usize) -> f64| {
            terms.iter().fold(0.0, |sum, (at, c)| sum + c * of(*at))
        };
        self.sums.get(&point).map_or([f64::NAN; 3], |[displacement, velocity]| {
            [
                sum(displacement, &|at| self.y[at]),
                sum(velocity, &|at| self.y[at]),
                sum(velocity, &|at| self.step.slope(at, theta)),
            ]
        })
    }

    /// Force of a contact of a hammer in N.
    fn stop_force(&self, hammer: usize, link: HammerLink) -> f64 {
        let contact = self.system.model().elements().contact_of(Owner::Hammer { hammer, link });
        contact.map_or(0.0, |contact| self.system.contact_force(contact, self.time_s, self.y))
    }
}

impl HammerSignals {
    /// `forces`: whether forces are read, which costs most; they are NaN if not.
    fn at(state: &State<'_>, hammer: usize, forces: bool) -> Self {
        let State { system, time_s: t, y, .. } = *state;
        let (model, layout) = (system.model(), system.model().layout());
        let slot = &model.hammers()[hammer];
        let own = system.hammer_state(hammer, t, y);
        let position = own.position;
        let velocity = |body: usize| y[layout.velocity(slot.points[body])];
        let acceleration = |body: usize| state.acceleration(slot.points[body]);
        let pressures = &y[layout.pressures(hammer)];
        let integral = |quadrature| y[layout.quadrature(hammer, quadrature)];
        let contact = |contact| if forces { system.contact_force(contact, t, y) } else { f64::NAN };
        let stop = |kind| if forces { state.stop_force(hammer, kind) } else { f64::NAN };
        let (top_stop_force_n, end_stop_force_n) = (stop(HammerLink::TopStop), stop(HammerLink::EndStop));
        // Supply and gate, which the state leaves out, do not act on the guide.
        let guide_force_n = if forces { slot.model.evaluate(&own).force[body::GUIDE] } else { f64::NAN };
        // Of the chisel against the casting.
        let closing_m_s = system.relative_motion(model.elements().contact_row(slot.strike), t, y).1;
        let (arm_displacement_m, arm_velocity_m_s) = system.motion(PointId::Mount { hammer }, t, y);
        Self {
            extension_m: position[body::CYLINDER] - position[body::GUIDE],
            piston_m: position[body::PISTON] - position[body::CYLINDER],
            spool_m: position[body::SPOOL] - position[body::CYLINDER],
            chisel_m: position[body::CHISEL] - position[body::CYLINDER],
            cylinder_velocity_m_s: velocity(body::CYLINDER),
            piston_velocity_m_s: velocity(body::PISTON),
            chisel_velocity_m_s: velocity(body::CHISEL),
            pressure_top_pa: pressures[0],
            pressure_annulus_pa: pressures[1],
            pressure_rear_pa: pressures[2],
            pressure_front_pa: pressures[3],
            arm_velocity_m_s,
            casting_force_n: contact(slot.strike),
            casting_velocity_m_s: velocity(body::CHISEL) - closing_m_s,
            delivered_work_j: integral(HammerQuadrature::Work),
            delivered_impulse_n_s: integral(HammerQuadrature::Impulse),
            percussion_force_n: contact(slot.percussion),
            spool_velocity_m_s: velocity(body::SPOOL),
            arm_displacement_m,
            mount_force_n: guide_force_n - top_stop_force_n + end_stop_force_n,
            top_stop_force_n,
            end_stop_force_n,
            rear_wall_force_n: stop(HammerLink::RearWall),
            nose_force_n: stop(HammerLink::Nose),
            retainer_force_n: stop(HammerLink::Retainer),
            spool_rear_force_n: stop(HammerLink::SpoolRear),
            spool_front_force_n: stop(HammerLink::SpoolFront),
            cylinder_acceleration_m_s2: acceleration(body::CYLINDER),
            piston_acceleration_m_s2: acceleration(body::PISTON),
            chisel_acceleration_m_s2: acceleration(body::CHISEL),
            casting_displacement_m: state.motion(PointId::Strike { hammer })[0],
        }
    }
}

impl CastingSignals {
    fn at(state: &State<'_>, casting: usize) -> Self {
        let [heave_m, heave_velocity_m_s, heave_acceleration_m_s2] = state.motion(PointId::Centre { casting });
        let [rotation_x_rad, rotation_y_rad] = [0, 1].map(|axis| state.motion(PointId::Rotation { casting, axis })[0]);
        let [measuring_point_displacement_m, measuring_point_velocity_m_s, measuring_point_acceleration_m_s2] =
            state.motion(PointId::Measured { casting });
        Self {
            heave_m,
            heave_velocity_m_s,
            rotation_x_rad,
            rotation_y_rad,
            heave_acceleration_m_s2,
            measuring_point_velocity_m_s,
            measuring_point_acceleration_m_s2,
            measuring_point_displacement_m,
        }
    }
}

impl FixtureSignals {
    fn at(state: &State<'_>, fixture: FixtureId) -> Self {
        let State { system, time_s: t, y, .. } = *state;
        let elements = system.model().elements().owned(|owner| owner == Owner::Fixture(fixture));
        let (point_displacement_m, point_velocity_m_s) = system.motion(PointId::Support(fixture), t, y);
        Self {
            force_n: elements.map(|element| system.element_force(element, t, y)).sum(),
            point_displacement_m,
            point_velocity_m_s,
            casting_displacement_m: state.motion(PointId::Held(fixture))[0],
        }
    }
}

impl PointSignals {
    fn of([displacement_m, velocity_m_s]: [f64; 2]) -> Self {
        Self { displacement_m, velocity_m_s }
    }
}

/// What signals are read of together.
#[derive(Debug, Clone, Copy)]
enum SignalSource {
    Instant,
    Hammer(usize),
    Casting(usize),
    Fixture(FixtureId),
    Core(PointId),
    /// By its place among those.
    Point(usize),
    Energy,
}

impl SignalSource {
    /// All parts of a scene, in the order of their signals.
    fn all(scene: &Scene) -> Vec<Self> {
        let mut parts = vec![Self::Instant];
        parts.extend((0..scene.hammers.len()).map(Self::Hammer));
        parts.extend((0..scene.castings.len()).map(Self::Casting));
        parts.extend(scene.fixtures().map(|(fixture, _)| Self::Fixture(fixture)));
        for (casting, of_casting) in scene.castings.iter().enumerate() {
            parts.extend((0..of_casting.cores.len()).map(|core| Self::Core(PointId::Core { casting, core })));
        }
        parts.extend((0..scene.outputs.points.len()).map(Self::Point));
        parts.push(Self::Energy);
        parts
    }

    /// Number of its signals.
    fn count(self) -> usize {
        match self {
            Self::Instant => Instant::QUANTITIES.len(),
            Self::Hammer(_) => HammerSignals::QUANTITIES.len(),
            Self::Casting(_) => CastingSignals::QUANTITIES.len(),
            Self::Fixture(_) => FixtureSignals::QUANTITIES.len(),
            Self::Core(_) | Self::Point(_) => PointSignals::QUANTITIES.len(),
            Self::Energy => EnergySignals::QUANTITIES.len(),
        }
    }
}

/// A part of which signals are read.
#[derive(Debug, Clone)]
struct Read {
    part: SignalSource,
    /// Place of its first signal.
    begin: usize,
    /// Which of its signals are kept.
    kept: Vec<bool>,
    /// Whether one of them is a force.
    forces: bool,
}

/// Part of an interval by which the last instant may lie beyond the end by rounding.
const ROUNDING: f64 = 1e-6;

/// Records signals every `interval_s`, from 0 on; where the duration is a whole number of intervals, at its end too.
pub struct SignalRecorder {
    interval_s: f64,
    duration_s: f64,
    next: u64,
    signals: Vec<Signal>,
    reads: Vec<Read>,
    scratch: Vec<f64>,
    sums: PointSums,
    /// Displacement and velocity of each watched point at the instant; empty if no signal reads one.
    watched: Vec<[f64; 2]>,
    /// Whether signals of the energy balance are read.
    energy: bool,
    /// Energy stored at rest in J, once a step has been seen.
    rest_energy_j: Option<f64>,
}

impl SignalRecorder {
    /// Prepares the recording of all signals of `scene`, from which `model` was built.
    pub fn new(model: &CoupledModel, scene: &Scene, interval_s: f64) -> Self {
        Self::of(model, scene, interval_s, |_| true)
    }

    /// Prepares the recording of the signals at the places for which `kept` holds, see [`signal_list`]; the others have no values.
    pub(super) fn of(model: &CoupledModel, scene: &Scene, interval_s: f64, kept: impl Fn(usize) -> bool) -> Self {
        let signals = blank_signals(scene);
        let mut reads = Vec::new();
        let mut begin = 0;
        for part in SignalSource::all(scene) {
            let kept: Vec<bool> = (begin..begin + part.count()).map(&kept).collect();
            let mut own = signals.iter().skip(begin).zip(&kept).filter(|(_, kept)| **kept);
            let forces = own.any(|(signal, _)| signal.unit == "N");
            if kept.contains(&true) {
                reads.push(Read { part, begin, kept, forces });
            }
            begin += part.count();
        }
        let energy = reads.iter().any(|read| matches!(read.part, SignalSource::Energy));
        let points = scene.points().into_values().filter(|point| matches!(point.part, PartId::Casting(_)));
        let watches = reads.iter().any(|read| matches!(read.part, SignalSource::Point(_)));
        Self {
            interval_s,
            duration_s: scene.duration_s,
            next: 0,
            signals,
            reads,
            scratch: vec![0.0; model.layout().dimension()],
            sums: points.filter_map(|point| Some((point.id, model.point_sums(point.id)?))).collect(),
            watched: vec![[0.0; 2]; if watches { scene.outputs.points.len() } else { 0 }],
            energy,
            rest_energy_j: None,
        }
    }

    /// Number of signals of a scene, time among them.
    pub fn count(scene: &Scene) -> usize {
        blank_signals(scene).len()
    }

    /// Bytes in memory of the signals of a scene recorded every `interval_s`.
    pub fn bytes(scene: &Scene, interval_s: f64) -> f64 {
        Self::instants(scene.duration_s, interval_s) * (Self::count(scene) * size_of::<f64>()) as f64
    }

    /// Number of instants every `interval_s` of a duration, its begin and as far as it is one its end included.
    pub fn instants(duration_s: f64, interval_s: f64) -> f64 {
        (duration_s / interval_s + ROUNDING).floor() + 1.0
    }

    /// The values recorded so far of one signal, by its place in [`signal_list`].
    pub(super) fn recorded(&self, signal: usize) -> &[f64] {
        self.signals.get(signal).map_or(&[], |signal| &signal.values)
    }

    /// Forgets the first `count` values of every signal.
    pub(super) fn forget(&mut self, count: usize) {
        self.signals.iter_mut().for_each(|signal| _ = signal.values.drain(..count.min(signal.values.len())));
    }

    /// The signals recorded so far, time first.
    pub fn into_signals(self) -> Vec<Signal> {
        self.signals
    }

    /// The time in s of the next instant. `75000 * 2e-5` lies beyond 1.5 by rounding, and means it.
    fn next_s(&self) -> f64 {
        let time_s = self.next as f64 * self.interval_s;
        if time_s - self.duration_s <= ROUNDING * self.interval_s { time_s.min(self.duration_s) } else { time_s }
    }

    /// The energy balance at a state.
    fn energies(&mut self, state: &State<'_>) -> EnergySignals {
        let State { system, time_s: t, y, .. } = *state;
        let model = system.model();
        let at_rest = || system.at_rest().stored_energy(0.0, model.initial_state());
        let rest_energy_j = *self.rest_energy_j.get_or_insert_with(at_rest);
        let work_put_in_j = y[model.layout().work_in()];
        let stored_energy_j = system.stored_energy(t, y) - rest_energy_j;
        let dissipated_energy_j = system.dissipated_energy(t, y);
        EnergySignals {
            work_put_in_j,
            stored_energy_j,
            dissipated_energy_j,
            energy_unaccounted_j: work_put_in_j - stored_energy_j - dissipated_energy_j,
        }
    }

    /// Appends the values of the signals that are kept at a state.
    fn append(&mut self, state: &State<'_>) {
        let energies = self.energy.then(|| self.energies(state));
        if !self.watched.is_empty() {
            state.system.watched(state.time_s, state.y, &mut self.watched);
        }
        for read in &self.reads {
            let to = &mut self.signals[read.begin..];
            match read.part {
                SignalSource::Instant => read.push(to, Instant::QUANTITIES, &Instant { time_s: state.time_s }),
                SignalSource::Hammer(hammer) => {
                    let of = HammerSignals::at(state, hammer, read.forces);
                    read.push(to, HammerSignals::QUANTITIES, &of);
                }
                SignalSource::Casting(casting) => {
                    let of = CastingSignals::at(state, casting);
                    read.push(to, CastingSignals::QUANTITIES, &of);
                }
                SignalSource::Fixture(fixture) => {
                    let of = FixtureSignals::at(state, fixture);
                    read.push(to, FixtureSignals::QUANTITIES, &of);
                }
                SignalSource::Core(core) => {
                    let [displacement_m, velocity_m_s, _] = state.motion(core);
                    read.push(to, PointSignals::QUANTITIES, &PointSignals { displacement_m, velocity_m_s });
                }
                SignalSource::Point(point) => {
                    read.push(to, PointSignals::QUANTITIES, &PointSignals::of(self.watched[point]));
                }
                SignalSource::Energy => energies.iter().for_each(|of| read.push(to, EnergySignals::QUANTITIES, of)),
            }
        }
    }
}

impl Read {
    /// Appends the values of the signals that are kept at one instant, in the order of the quantities.
    fn push<T>(&self, signals: &mut [Signal], quantities: &[Quantity<T>], of: &T) {
        for ((quantity, signal), _) in quantities.iter().zip(signals).zip(&self.kept).filter(|(_, kept)| **kept) {
            signal.values.extend((quantity.value)(of).and_then(|value| value.number()));
        }
    }
}

/// The signals of a scene without values: time, those of each hammer, casting, fixture, core point and point, the energy balance.
fn blank_signals(scene: &Scene) -> Vec<Signal> {
    let hammers: Vec<&str> = scene.hammers.iter().map(|hammer| hammer.name.as_str()).collect();
    let castings: Vec<CastingNames<'_>> = (scene.castings.iter())
        .map(|casting| CastingNames {
            name: &casting.name,
            fixtures: casting.fixtures.iter().map(|fixture| fixture.name.as_str()).collect(),
            cores: casting.cores.iter().map(|core| core.name.as_str()).collect(),
        })
        .collect();
    signal_list(&hammers, &castings, &scene.outputs.points)
}

/// Names of a casting, its fixtures and its core points.
#[derive(Debug, Clone)]
pub struct CastingNames<'n> {
    /// Its name.
    pub name: &'n str,
    /// Names of its fixtures, in order.
    pub fixtures: Vec<&'n str>,
    /// Names of its core points, in order.
    pub cores: Vec<&'n str>,
}

/// The signals, without values, of scenes with hammers and castings of these names, and these watched points.
pub fn signal_list(hammers: &[&str], castings: &[CastingNames<'_>], points: &[String]) -> Vec<Signal> {
    let mut signals = Vec::new();
    add(&mut signals, Instant::QUANTITIES, SignalOf::Run, None);
    for (index, name) in hammers.iter().enumerate() {
        let names = (format!("hammer {name}"), (*name).to_owned());
        add(&mut signals, HammerSignals::QUANTITIES, SignalOf::Hammer(index), Some(names));
    }
    for (index, CastingNames { name, .. }) in castings.iter().enumerate() {
        let names = (format!("casting {name}"), (*name).to_owned());
        add(&mut signals, CastingSignals::QUANTITIES, SignalOf::Casting(index), Some(names));
    }
    for (index, CastingNames { name: casting, fixtures, .. }) in castings.iter().enumerate() {
        for (place, fixture) in fixtures.iter().enumerate() {
            let what = format!("fixture {fixture} of casting {casting}");
            let names = (what, format!("{casting}_fixture_{fixture}"));
            add(&mut signals, FixtureSignals::QUANTITIES, SignalOf::Fixture(index, place), Some(names));
        }
    }
    for (index, CastingNames { name: casting, cores, .. }) in castings.iter().enumerate() {
        for (place, core) in cores.iter().enumerate() {
            let names = (format!("core point {core} of casting {casting}"), format!("{casting}_core_{core}"));
            add(&mut signals, PointSignals::QUANTITIES, SignalOf::Core(index, place), Some(names));
        }
    }
    for (index, point) in points.iter().enumerate() {
        let names = (format!("interface point {point}"), format!("point_{point}"));
        add(&mut signals, PointSignals::QUANTITIES, SignalOf::Point(index), Some(names));
    }
    add(&mut signals, EnergySignals::QUANTITIES, SignalOf::Run, None);
    signals
}

/// Adds the signals of quantities; `names`: what they are of in words, and what their columns begin with.
fn add<T>(signals: &mut Vec<Signal>, quantities: &[Quantity<T>], of: SignalOf, names: Option<(String, String)>) {
    signals.extend(quantities.iter().map(|quantity| Signal {
        name: names.as_ref().map_or(quantity.name.to_owned(), |(_, name)| format!("{name}_{}", quantity.name)),
        of,
        quantity: quantity.name,
        unit: quantity.unit,
        description: names.as_ref().map_or(String::new(), |(what, _)| format!("{what}: ")) + &quantity.description(),
        values: Vec::new(),
    }));
}

impl Observer<Coupled> for SignalRecorder {
    fn step(&mut self, system: &Coupled, step: &Step<'_>) {
        let (mut scratch, sums) = (std::mem::take(&mut self.scratch), std::mem::take(&mut self.sums));
        loop {
            let time_s = self.next_s();
            if time_s > step.t1() {
                break;
            }
            step.state(step.fraction(time_s), &mut scratch);
            self.append(&State { system, step, time_s, y: &scratch, sums: &sums });
            self.next += 1;
        }
        (self.scratch, self.sums) = (scratch, sums);
    }

    fn event(&mut self, _system: &Coupled, _guard: usize, _t: f64, _y: &[f64]) {}
}

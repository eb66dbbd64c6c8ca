//! Time signals of a run on a uniform grid, read off the dense output.

use crate::hammer::body;
use crate::integrate::{Observer, Step};
use crate::quantity::{Quantity, quantities};
use crate::scene::Scene;
use crate::system::{Coupled, CoupledModel, HammerQuadrature};

/// One signal: name, unit, description, values on the grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Signal {
    /// Column name, with the unit as its suffix.
    pub name: String,
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
    }
}

impl HammerSignals {
    fn at(system: &Coupled, hammer: usize, (t, y): (f64, &[f64])) -> Self {
        let (model, layout) = (system.model(), system.model().layout());
        let slot = &model.hammers()[hammer];
        let position = system.hammer_state(hammer, t, y).position;
        let velocity = |body: usize| y[layout.velocity(slot.points[body])];
        let pressures = &y[layout.pressures(hammer)];
        let integral = |quadrature| y[layout.quadrature(hammer, quadrature)];
        // Of the chisel against the casting.
        let closing_m_s = system.relative_motion(model.elements().contact_row(slot.strike), t, y).1;
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
            arm_velocity_m_s: system.interface_motion(slot.mount, t, y).1,
            casting_force_n: system.contact_force(slot.strike, t, y),
            casting_velocity_m_s: velocity(body::CHISEL) - closing_m_s,
            delivered_work_j: integral(HammerQuadrature::Work),
            delivered_impulse_n_s: integral(HammerQuadrature::Impulse),
            percussion_force_n: system.contact_force(slot.percussion, t, y),
        }
    }
}

impl CastingSignals {
    fn at(model: &CoupledModel, casting: usize, y: &[f64]) -> Self {
        let heave = model.castings()[casting].heave;
        Self { heave_m: y[model.layout().position(heave)], heave_velocity_m_s: y[model.layout().velocity(heave)] }
    }
}

/// Records signals every `interval_s`, from 0 on.
pub struct SignalRecorder {
    interval_s: f64,
    next: u64,
    signals: Vec<Signal>,
    scratch: Vec<f64>,
}

impl SignalRecorder {
    /// Prepares the recording of the scene that `model` was built from; `hammers` and `castings` are their names.
    pub fn new(model: &CoupledModel, (hammers, castings): (&[&str], &[&str]), interval_s: f64) -> Self {
        let mut signals = Vec::new();
        add(&mut signals, Instant::QUANTITIES, None);
        for name in hammers.iter().take(model.layout().hammers) {
            add(&mut signals, HammerSignals::QUANTITIES, Some(("hammer", name)));
        }
        for name in castings.iter().take(model.castings().len()) {
            add(&mut signals, CastingSignals::QUANTITIES, Some(("casting", name)));
        }
        Self { interval_s, next: 0, signals, scratch: vec![0.0; model.layout().dimension()] }
    }

    /// Bytes in memory of the signals of a scene recorded every `interval_s`.
    pub fn bytes(scene: &Scene, interval_s: f64) -> f64 {
        let (hammer, casting) = (HammerSignals::QUANTITIES.len(), CastingSignals::QUANTITIES.len());
        let signals = Instant::QUANTITIES.len() + hammer * scene.hammers.len() + casting * scene.castings.len();
        ((scene.duration_s / interval_s).floor() + 1.0) * (signals * size_of::<f64>()) as f64
    }

    /// The signals recorded so far, time first.
    pub fn into_signals(self) -> Vec<Signal> {
        self.signals
    }
}

/// Adds the signals of quantities; of a hammer or a casting with its name.
fn add<T>(signals: &mut Vec<Signal>, quantities: &[Quantity<T>], of: Option<(&str, &str)>) {
    signals.extend(quantities.iter().map(|quantity| Signal {
        name: of.map_or(quantity.name.to_owned(), |(_, name)| format!("{name}_{}", quantity.name)),
        unit: quantity.unit,
        description: of.map_or(String::new(), |(what, name)| format!("{what} {name}: ")) + &quantity.description(),
        values: Vec::new(),
    }));
}

/// Appends the values at one instant, in the order of the quantities.
fn push<'s, T>(signals: &mut impl Iterator<Item = &'s mut Signal>, quantities: &[Quantity<T>], of: &T) {
    for (quantity, signal) in quantities.iter().zip(signals) {
        signal.values.extend((quantity.value)(of).and_then(|value| value.number()));
    }
}

impl Observer<Coupled> for SignalRecorder {
    fn step(&mut self, system: &Coupled, step: &Step<'_>) {
        let model = system.model();
        loop {
            let time_s = self.next as f64 * self.interval_s;
            if time_s > step.t1() {
                return;
            }
            step.state(step.fraction(time_s), &mut self.scratch);
            let (y, mut signals) = (self.scratch.as_slice(), self.signals.iter_mut());
            push(&mut signals, Instant::QUANTITIES, &Instant { time_s });
            for hammer in 0..model.layout().hammers {
                push(&mut signals, HammerSignals::QUANTITIES, &HammerSignals::at(system, hammer, (time_s, y)));
            }
            for casting in 0..model.castings().len() {
                push(&mut signals, CastingSignals::QUANTITIES, &CastingSignals::at(model, casting, y));
            }
            self.next += 1;
        }
    }

    fn event(&mut self, _system: &Coupled, _guard: usize, _t: f64, _y: &[f64]) {}
}

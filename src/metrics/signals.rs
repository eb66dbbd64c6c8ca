//! Time signals of a run on a uniform grid, read off the dense output.

use crate::hammer::body;
use crate::integrate::{Observer, Step};
use crate::scene::Scene;
use crate::system::{Coupled, CoupledModel, HammerQuadrature};

/// Signals of a hammer.
const HAMMER_SIGNALS: usize = 17;
/// Signals of a casting.
const CASTING_SIGNALS: usize = 2;

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

/// What a signal reads from the state.
#[derive(Debug, Clone, Copy)]
enum Source {
    Time,
    Component(usize),
    /// Difference of a body's position or velocity and the cylinder's or guide's.
    Relative {
        hammer: usize,
        upper: usize,
        lower: usize,
    },
    Arm {
        hammer: usize,
    },
    Strike {
        hammer: usize,
    },
    /// The casting's velocity where the hammer strikes it.
    Struck {
        hammer: usize,
    },
    Percussion {
        hammer: usize,
    },
}

/// Records signals every `interval_s`, from 0 on.
pub struct SignalRecorder {
    interval_s: f64,
    next: u64,
    sources: Vec<Source>,
    signals: Vec<Signal>,
    scratch: Vec<f64>,
}

impl SignalRecorder {
    /// Prepares the recording of the scene that `model` was built from; `hammers` and `castings` are their names.
    pub fn new(model: &CoupledModel, (hammers, castings): (&[&str], &[&str]), interval_s: f64) -> Self {
        let mut recorder = Self {
            interval_s,
            next: 0,
            sources: Vec::new(),
            signals: Vec::new(),
            scratch: vec![0.0; model.layout().dimension()],
        };
        recorder.add("time_s".into(), "s", "time".into(), Source::Time);
        for (h, name) in hammers.iter().enumerate().take(model.layout().hammers) {
            recorder.add_hammer(model, h, name);
        }
        for (slot, name) in model.castings().iter().zip(castings) {
            let layout = model.layout();
            let entries: [(usize, &str, &'static str); CASTING_SIGNALS] = [
                (layout.position(slot.heave), "heave_m", "m"),
                (layout.velocity(slot.heave), "heave_velocity_m_s", "m/s"),
            ];
            for (index, what, unit) in entries {
                let text = format!("casting {name}: {}", what.trim_end_matches("_m_s").trim_end_matches("_m"));
                recorder.add(format!("{name}_{what}"), unit, text.replace('_', " "), Source::Component(index));
            }
        }
        recorder
    }

    /// Bytes in memory of the signals of a scene recorded every `interval_s`.
    pub fn bytes(scene: &Scene, interval_s: f64) -> f64 {
        let signals = 1 + HAMMER_SIGNALS * scene.hammers.len() + CASTING_SIGNALS * scene.castings.len();
        ((scene.duration_s / interval_s).floor() + 1.0) * (signals * size_of::<f64>()) as f64
    }

    /// The signals recorded so far, time first.
    pub fn into_signals(self) -> Vec<Signal> {
        self.signals
    }

    fn add(&mut self, name: String, unit: &'static str, description: String, source: Source) {
        self.sources.push(source);
        self.signals.push(Signal { name, unit, description, values: Vec::new() });
    }

    fn add_hammer(&mut self, model: &CoupledModel, h: usize, name: &str) {
        let slot = &model.hammers()[h];
        let layout = model.layout();
        let relative = |upper, lower| Source::Relative { hammer: h, upper, lower };
        let velocity = |index: usize| Source::Component(layout.velocity(slot.points[index]));
        let pressure = |index: usize| Source::Component(layout.pressures(h).start + index);
        let integral = |quadrature| Source::Component(layout.quadrature(h, quadrature));
        let entries: [(&str, &'static str, &str, Source); HAMMER_SIGNALS] = [
            ("extension_m", "m", "telescope extension", relative(body::CYLINDER, body::GUIDE)),
            ("piston_m", "m", "piston position in the cylinder", relative(body::PISTON, body::CYLINDER)),
            ("spool_m", "m", "spool position in the cylinder", relative(body::SPOOL, body::CYLINDER)),
            ("chisel_m", "m", "chisel position in the cylinder", relative(body::CHISEL, body::CYLINDER)),
            ("cylinder_velocity_m_s", "m/s", "cylinder velocity", velocity(body::CYLINDER)),
            ("piston_velocity_m_s", "m/s", "piston velocity", velocity(body::PISTON)),
            ("chisel_velocity_m_s", "m/s", "chisel velocity", velocity(body::CHISEL)),
            ("pressure_top_pa", "Pa", "pressure in the telescope's top chamber (P1)", pressure(0)),
            ("pressure_annulus_pa", "Pa", "pressure in the telescope's annulus (P2)", pressure(1)),
            ("pressure_rear_pa", "Pa", "pressure behind the piston (P3)", pressure(2)),
            ("pressure_front_pa", "Pa", "pressure before the piston (P4)", pressure(3)),
            ("arm_velocity_m_s", "m/s", "velocity of the structure at the mount", Source::Arm { hammer: h }),
            ("casting_force_n", "N", "force of the chisel on the casting", Source::Strike { hammer: h }),
            (
                "casting_velocity_m_s",
                "m/s",
                "velocity of the casting at the strike point",
                Source::Struck { hammer: h },
            ),
            ("delivered_work_j", "J", "work on the casting so far", integral(HammerQuadrature::Work)),
            ("delivered_impulse_n_s", "N s", "impulse on the casting so far", integral(HammerQuadrature::Impulse)),
            ("percussion_force_n", "N", "force of the piston on the chisel", Source::Percussion { hammer: h }),
        ];
        for (what, unit, text, source) in entries {
            self.add(format!("{name}_{what}"), unit, format!("hammer {name}: {text}"), source);
        }
    }
}

impl Observer<Coupled<'_>> for SignalRecorder {
    fn step(&mut self, system: &Coupled<'_>, step: &Step<'_>) {
        let model = system.model();
        loop {
            let t = self.next as f64 * self.interval_s;
            if t > step.t1() {
                return;
            }
            step.state(step.fraction(t), &mut self.scratch);
            for (source, signal) in self.sources.iter().zip(&mut self.signals) {
                let y = &self.scratch;
                signal.values.push(match *source {
                    Source::Time => t,
                    Source::Component(index) => y[index],
                    Source::Relative { hammer, upper, lower } => {
                        let position = system.hammer_state(hammer, t, y).position;
                        position[upper] - position[lower]
                    }
                    Source::Arm { hammer } => system.interface_motion(model.hammers()[hammer].mount, t, y).1,
                    Source::Strike { hammer } => system.contact_force(model.hammers()[hammer].strike, t, y),
                    Source::Struck { hammer } => {
                        let slot = &model.hammers()[hammer];
                        let row = model.elements().contact_row(slot.strike);
                        let chisel = y[model.layout().velocity(slot.points[body::CHISEL])];
                        chisel - system.relative_motion(row, t, y).1
                    }
                    Source::Percussion { hammer } => system.contact_force(model.hammers()[hammer].percussion, t, y),
                });
            }
            self.next += 1;
        }
    }

    fn event(&mut self, _system: &Coupled<'_>, _guard: usize, _t: f64, _y: &[f64]) {}
}

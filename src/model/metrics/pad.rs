//! What the one-sided fixtures of castings do: their forces, and when a casting lifts off them.

use schemars::JsonSchema;
use serde::Serialize;

use super::peak::{Probe, peak};
use crate::integrate::{Step, Switching};
use crate::scene::{FixtureId, Owner, Scene};
use crate::system::{Coupled, CoupledModel};
use decore_quantity::quantities;

/// Share of the range of forces so far, from its ends, within which a step is searched for a new extreme.
const NEAR: f64 = 0.25;

quantities! {
    /// Outputs of one one-sided fixture (a pad).
    #[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
    pub struct PadMetrics {
        /// Force at rest: the pad's share of the casting's weight and of the clamps.
        pub rest_force_n: f64 => "N",
        /// Least force on the pad; 0 if the casting lifted off.
        pub least_force_n: f64 => "N",
        /// Largest force on the pad.
        pub largest_force_n: f64 => "N" [less],
        /// Number of times the casting lifted off the pad.
        pub lift_off_count: u64 => "1" [less],
        /// Share of the run in which the casting was off the pad.
        pub lifted_off_share: f64 => "1" [less],
        /// Longest time for which the casting was off the pad.
        pub longest_lift_off_s: f64 => "s" [less],
    }
}

/// What is remembered of one pad.
struct PadTrack {
    fixture: FixtureId,
    /// Its contact in the system.
    contact: usize,
    metrics: PadMetrics,
    off_s: f64,
    /// Since when the casting is off it.
    off_since_s: Option<f64>,
    /// Its force at the end of the last step.
    force_n: f64,
}

/// A casting's flights: the times in which it is off all its fixtures.
#[derive(Default)]
struct Flight {
    since_s: Option<f64>,
    longest_s: f64,
}

/// The pads of a scene.
pub(super) struct PadTracks {
    pads: Vec<PadTrack>,
    /// Of each casting; none where another fixture holds it or it has no pad.
    flights: Vec<Option<Flight>>,
}

impl PadTracks {
    pub fn new(model: &CoupledModel, scene: &Scene) -> Self {
        let pads = scene.fixtures().filter(|(_, fixture)| fixture.one_sided).filter_map(|(fixture, _)| {
            let contact = model.elements().contact_of(Owner::Fixture(fixture))?;
            let rest_force_n = model.elements().contacts()[contact].rest_force_n;
            let is_off = rest_force_n == 0.0;
            let metrics = PadMetrics {
                rest_force_n,
                least_force_n: rest_force_n,
                largest_force_n: rest_force_n,
                ..PadMetrics::default()
            };
            let off_since_s = is_off.then_some(0.0);
            Some(PadTrack { fixture, contact, metrics, off_s: 0.0, off_since_s, force_n: rest_force_n })
        });
        let flies = |casting: &crate::workpiece::Casting| {
            let held = casting.fixtures.iter().any(|of| !of.one_sided && of.clamp_force_n == 0.0);
            (casting.lies() && !held).then(Flight::default)
        };
        Self { pads: pads.collect(), flights: scene.castings.iter().map(flies).collect() }
    }

    /// Follows a step.
    pub fn step(&mut self, system: &Coupled, step: &Step<'_>, scratch: &mut [f64]) {
        for pad in self.pads.iter_mut().filter(|pad| system.is_closed(pad.contact)) {
            pad.step(system, step, scratch);
        }
    }

    /// A contact of a fixture has opened or closed.
    pub fn event(&mut self, system: &Coupled, (fixture, contact): (FixtureId, usize), t: f64) {
        let closed = system.is_closed(contact);
        for pad in self.pads.iter_mut().filter(|pad| pad.contact == contact) {
            if closed {
                pad.lands(t);
            } else {
                pad.metrics.lift_off_count += 1;
                pad.metrics.least_force_n = 0.0;
                pad.off_since_s = Some(t);
                pad.force_n = 0.0;
            }
        }
        let mut pads = self.pads.iter().filter(|pad| pad.fixture.casting == fixture.casting);
        let flies = pads.all(|pad| pad.off_since_s.is_some());
        if let Some(Some(flight)) = self.flights.get_mut(fixture.casting) {
            match (flight.since_s, flies) {
                (None, true) => flight.since_s = Some(t),
                (Some(_), false) => flight.ends(t),
                _ => {}
            }
        }
    }

    /// The outputs of the pads, and the longest flight of each casting in s, at the end of the run.
    pub fn finish(self, end_s: f64) -> (Vec<PadMetrics>, Vec<f64>) {
        let pads = self.pads.into_iter().map(|mut pad| {
            pad.lands(end_s);
            PadMetrics { lifted_off_share: pad.off_s / end_s, ..pad.metrics }
        });
        let flights = self.flights.into_iter().map(|flight| {
            let mut flight = flight.unwrap_or_default();
            flight.ends(end_s);
            flight.longest_s
        });
        (pads.collect(), flights.collect())
    }
}

impl Flight {
    fn ends(&mut self, t: f64) {
        if let Some(since_s) = self.since_s.take() {
            self.longest_s = self.longest_s.max(t - since_s);
        }
    }
}

impl PadTrack {
    fn lands(&mut self, t: f64) {
        if let Some(since_s) = self.off_since_s.take() {
            self.off_s += t - since_s;
            self.metrics.longest_lift_off_s = self.metrics.longest_lift_off_s.max(t - since_s);
        }
    }

    /// Follows the extremes of the force through a step with the pad pressed; only a step that ends near one is searched within.
    fn step(&mut self, system: &Coupled, step: &Step<'_>, scratch: &mut [f64]) {
        let support = system.guard_support(self.contact);
        step.components(support, step.theta_end, scratch);
        let end_n = system.contact_force(self.contact, step.t1(), scratch);
        let start_n = std::mem::replace(&mut self.force_n, end_n);
        let PadMetrics { least_force_n, largest_force_n, rest_force_n, .. } = self.metrics;
        let margin = NEAR * (largest_force_n - least_force_n);
        let mut extreme = |quantity: &dyn Fn(f64) -> f64| {
            let force = |t: f64, y: &[f64]| quantity(system.contact_force(self.contact, t, y)).max(0.0);
            peak(step, step.theta_end, Probe { support, scratch }, force).0
        };
        if start_n.max(end_n) >= largest_force_n - margin {
            let found = extreme(&|force| force);
            self.metrics.largest_force_n = largest_force_n.max(found);
        }
        if least_force_n > 0.0 && start_n.min(end_n) <= least_force_n + margin {
            let found = rest_force_n - extreme(&|force| rest_force_n - force);
            self.metrics.least_force_n = least_force_n.min(found.max(0.0));
        }
    }
}

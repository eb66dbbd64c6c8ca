//! The phases of a hammer's work.

use std::ops::Range;

use schemars::JsonSchema;
use serde::Serialize;

use super::blow::{Blow, BlowKind};
use super::signals::SignalOf;
use crate::scene::Scene;

/// A part of a hammer's work: those whose spectra the paper's Figures 18 to 20 show.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PhaseKind {
    /// From the hammer's start to its first impact; without one to the end.
    Extension,
    /// From the first impact to the next blow.
    FirstImpact,
    /// From one periodic blow to the next: the last that lies where a signal is seen.
    PeriodicBlow,
    /// From the first impact to the end.
    Hammering,
}

impl PhaseKind {
    /// All, in their order.
    pub const ALL: [Self; 4] = [Self::Extension, Self::FirstImpact, Self::PeriodicBlow, Self::Hammering];

    /// The phase in texts.
    pub fn text(self) -> &'static str {
        match self {
            Self::Extension => "extension",
            Self::FirstImpact => "first impact",
            Self::PeriodicBlow => "one periodic blow",
            Self::Hammering => "hammering",
        }
    }
}

/// A phase, and when it was.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Phase {
    /// Which one.
    pub kind: PhaseKind,
    /// Its begin, s.
    pub from_s: f64,
    /// Its end, s.
    pub to_s: f64,
}

impl Phase {
    /// The phases that a hammer's work had, by the blows of its row. `is_seen(from_s, to_s)`: whether all of that time is looked at:
    /// the periodic blow is the last of which it is, if there is one, else the row's last.
    pub fn all(scene: &Scene, hammer: usize, blows: &[Blow], is_seen: &dyn Fn(f64, f64) -> bool) -> Vec<Self> {
        let own: Vec<&Blow> = blows.iter().filter(|blow| blow.hammer == hammer).collect();
        let (begin_s, end_s) = (scene.hammers.get(hammer).map_or(0.0, |unit| unit.start_time_s), scene.duration_s);
        let phase = |kind, from_s, to_s| Self { kind, from_s, to_s };
        let Some(first_s) = own.first().map(|blow| blow.start_time_s) else {
            return vec![phase(PhaseKind::Extension, begin_s, end_s)];
        };
        let second_s = own.get(1).map_or(end_s, |blow| blow.start_time_s);
        let mut phases =
            vec![phase(PhaseKind::Extension, begin_s, first_s), phase(PhaseKind::FirstImpact, first_s, second_s)];
        let pairs = || own.windows(2).filter(|pair| pair.iter().all(|blow| blow.kind == BlowKind::Periodic));
        let seen = |pair: &&[&Blow]| matches!(pair, [from, to] if is_seen(from.start_time_s, to.start_time_s));
        if let Some([from, to]) = pairs().rfind(seen).or_else(|| pairs().next_back()) {
            phases.push(phase(PhaseKind::PeriodicBlow, from.start_time_s, to.start_time_s));
        }
        phases.push(phase(PhaseKind::Hammering, first_s, end_s));
        phases
    }

    /// The hammer whose phases are those of a signal: its own; of a casting and its fixtures the first that strikes it; of all else
    /// the first.
    pub fn hammer_of(scene: &Scene, of: SignalOf) -> Option<usize> {
        match of {
            SignalOf::Run | SignalOf::Point(_) => (!scene.hammers.is_empty()).then_some(0),
            SignalOf::Hammer(hammer) => Some(hammer),
            SignalOf::Casting(casting) | SignalOf::Fixture(casting, _) | SignalOf::Core(casting, _) => {
                scene.hammers.iter().position(|hammer| hammer.casting == casting)
            }
        }
    }

    /// The samples within it of signals that have one every `interval_s` from 0 on.
    pub fn samples(&self, interval_s: f64) -> Range<usize> {
        let index = |time_s: f64| (time_s / interval_s).ceil() as usize;
        index(self.from_s)..index(self.to_s)
    }
}

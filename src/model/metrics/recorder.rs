//! Watches an integration and computes the outputs as it goes; no trajectory is stored.

use super::audit::{chamber_residual, energy_residual};
use super::casting::CastingTrack;
use super::core::{CoreTotals, CoreTracks};
use super::fixture::FixtureTracks;
use super::hammer::{Finished, HammerTrack};
use super::instant::Instant;
use super::outputs::{CastingMetrics, RunMetrics, RunTotals};
use super::pad::PadTracks;
use super::strain::StrainTrack;
use super::warning::Warning;
use crate::integrate::{Observer, Step};
use crate::scene::{HammerLink, Owner, Scene};
use crate::system::{Coupled, CoupledModel};

/// Computes the outputs of a run while it is integrated.
pub struct Recorder {
    hammers: Vec<HammerTrack>,
    castings: Vec<CastingTrack>,
    /// `None` where no spectra of core points are asked for.
    cores: Option<CoreTracks>,
    core_names: Vec<String>,
    pads: PadTracks,
    /// `None` where no energies of fixtures are asked for.
    fixtures: Option<FixtureTracks>,
    strains: Vec<StrainTrack>,
    scratch: Vec<f64>,
}

impl Recorder {
    /// Prepares the recording of `model`, which was built from `scene`.
    pub fn new(model: &CoupledModel, scene: &Scene) -> Self {
        let layout = model.layout();
        Self {
            hammers: (0..layout.hammers).map(|h| HammerTrack::new(h, model, scene)).collect(),
            castings: (0..layout.castings).map(|c| CastingTrack::new(model, scene, c)).collect(),
            cores: CoreTracks::new(model, scene),
            core_names: scene.core_names(),
            pads: PadTracks::new(model, scene),
            fixtures: FixtureTracks::new(model, scene),
            strains: StrainTrack::all(model, scene),
            scratch: vec![0.0; layout.dimension()],
        }
    }

    /// The outputs, once the end of the simulation is reached at state `y` and time `t`.
    pub fn finish(self, system: &Coupled, t: f64, y: &[f64]) -> RunMetrics {
        let end = Instant { t, y };
        let warnings = Warning::text(self.hammers.iter().flat_map(|track| track.warnings(system)));
        let finished: Vec<Finished> = self.hammers.into_iter().map(|track| track.finish(system, end)).collect();
        let delivered_work_error_j = run_work_error_j(&finished);
        let (hammers, blows): (Vec<_>, Vec<_>) =
            finished.into_iter().map(|hammer| (hammer.metrics, hammer.blows)).unzip();
        let mut blows: Vec<_> = blows.into_iter().flatten().collect();
        blows.sort_by(|a, b| a.start_time_s.total_cmp(&b.start_time_s).then(a.hammer.cmp(&b.hammer)));
        let mut cores: Vec<_> = self.castings.iter().flat_map(CastingTrack::cores).collect();
        if let Some(tracks) = self.cores {
            tracks.finish(t, &blows, &mut cores);
        }
        let castings = self.castings.into_iter().enumerate();
        let castings = castings.map(|(casting, track)| CastingMetrics {
            strike_energy_j: sum(blows.iter().filter(|blow| blow.casting == casting).map(|blow| blow.strike_energy_j)),
            ..track.finish(system, end)
        });
        let castings = castings.collect();
        let totals = RunTotals {
            delivered_work_j: sum(hammers.iter().map(|hammer| hammer.delivered_work_j)),
            delivered_work_error_j,
            delivered_impulse_n_s: sum(hammers.iter().map(|hammer| hammer.delivered_impulse_n_s)),
            strike_energy_j: sum(hammers.iter().map(|hammer| hammer.strike_energy_j)),
            energy_residual: energy_residual(system, end),
            chamber_residual: chamber_residual(system, end),
            warnings,
        };
        let (pads, flights_s) = self.pads.finish(t);
        let core_totals = CoreTotals::of(&cores, &self.core_names);
        let elastic = self.strains.into_iter().map(|track| track.finish(&blows)).collect();
        RunMetrics {
            hammers,
            castings,
            elastic,
            cores,
            core_totals,
            pads,
            fixtures: self.fixtures.map_or_else(Vec::new, FixtureTracks::finish),
            flights_s,
            slides_m: slides_m(system, end),
            blows,
            totals,
            ..RunMetrics::default()
        }
    }
}

/// Distance in m by which each casting has slid across the axis of the pad on which it has slid farthest.
fn slides_m(system: &Coupled, Instant { t, y }: Instant<'_>) -> Vec<f64> {
    let elements = system.model().elements();
    let mut slides = vec![0.0; system.model().layout().castings];
    for sliding in elements.frictions() {
        let Owner::Fixture(fixture) = elements.contacts()[sliding.contact].owner else { continue };
        let [first, second] = sliding.springs.map(|spring| system.relative_motion(spring, t, y).0);
        let slide: &mut f64 = &mut slides[fixture.casting];
        *slide = slide.max(libm::hypot(first, second));
    }
    slides
}

/// Error of the run's delivered work, by the hammer with most periodic blows, which are the finest clock; `None` if a hammer's
/// percussion has not settled.
fn run_work_error_j(hammers: &[Finished]) -> Option<f64> {
    let unsure = |hammer: &&Finished| !hammer.metrics.percussion.is_sure() && hammer.metrics.struck_blow_count > 0;
    if hammers.iter().any(|hammer| unsure(&hammer)) {
        return None;
    }
    // `max_by_key` keeps the last of equals, so the first hammer comes last.
    hammers.iter().rev().max_by_key(|hammer| hammer.metrics.periodic_blows)?.run_work_error_j
}

/// The sum, 0.0 of nothing, where `Iterator::sum` has -0.0.
fn sum(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |sum, value| sum + value)
}

impl Observer<Coupled> for Recorder {
    fn step(&mut self, system: &Coupled, step: &Step<'_>) {
        for track in &mut self.hammers {
            let before = track.blow_count();
            track.step(system, step, &mut self.scratch);
            open_cores(&mut self.cores, track, before);
        }
        if let Some(cores) = &mut self.cores {
            cores.step(system, step, &mut self.scratch);
        }
        self.pads.step(system, step, &mut self.scratch);
        self.fixtures.iter_mut().for_each(|tracks| tracks.step(system, step, &mut self.scratch));
        self.strains.iter_mut().for_each(|track| track.step(system, step, &mut self.scratch));
        for track in &mut self.castings {
            track.step(step, &mut self.scratch);
        }
    }

    fn event(&mut self, system: &Coupled, guard: usize, t: f64, y: &[f64]) {
        if let Some(cores) = &mut self.cores {
            cores.event();
        }
        let contact = &system.model().elements().contacts()[guard];
        let (hammer, link) = match contact.owner {
            Owner::Hammer { hammer, link } => (hammer, link),
            Owner::Fixture(fixture) => return self.pads.event(system, (fixture, guard), t),
        };
        let track = &mut self.hammers[hammer];
        let before = track.blow_count();
        match (link, system.is_closed(guard)) {
            (HammerLink::ChiselCasting, true) => track.contact(system, Instant { t, y }),
            (HammerLink::ChiselCasting, false) => track.release(t),
            (HammerLink::PistonChisel, true) if system.gate_open(hammer) => {
                let (_, closing) = system.penetration(guard, t, y);
                track.percussion(closing, system, Instant { t, y });
            }
            _ => {}
        }
        open_cores(&mut self.cores, track, before);
    }
}

/// Opens the windows of core points for the blow that a hammer has begun, if it has had `before` blows until then.
fn open_cores(cores: &mut Option<CoreTracks>, track: &HammerTrack, before: usize) {
    if let Some((cores, (blow, end_s))) =
        cores.as_mut().zip(track.present_blow()).filter(|_| track.blow_count() > before)
    {
        cores.open(blow, end_s);
    }
}

//! What is kept of one casting while it moves, and the outputs that follow from it.

use std::ops::Range;

use super::core::CoreMetrics;
use super::instant::Instant;
use super::outputs::CastingMetrics;
use super::peak::{Probe, peak, reach};
use crate::integrate::Step;
use crate::scene::{PartId, PointId, Scene};
use crate::system::{CastingQuadrature, Coupled, CoupledModel, HammerQuadrature};

/// The largest absolute velocity of one point.
pub(super) struct PointPeak {
    /// Components of the state and their coefficients.
    support: Vec<usize>,
    coefficients: Vec<f64>,
    /// The same by the casting's own velocities: their number among these, and the size of the coefficient.
    shares: Vec<(usize, f64)>,
    largest_m_s: f64,
    time_s: f64,
}

impl PointPeak {
    /// `velocities`: first component of the casting's own.
    pub fn new(velocities: usize, row: &[(usize, f64)]) -> Self {
        Self {
            shares: row.iter().map(|(component, c)| (component - velocities, c.abs())).collect(),
            support: row.iter().map(|(component, _)| *component).collect(),
            coefficients: row.iter().map(|(_, c)| *c).collect(),
            largest_m_s: 0.0,
            time_s: 0.0,
        }
    }

    /// Updates the peak; a step that cannot exceed it is left at once, as `reaches` of the casting's own velocities tell or the
    /// point's own.
    fn update(&mut self, step: &Step<'_>, reaches: &[f64], scratch: &mut [f64]) {
        if self.shares.iter().map(|(own, c)| c * reaches[*own]).sum::<f64>() <= self.largest_m_s {
            return;
        }
        self.follow(step, scratch);
    }

    /// Updates the peak; a step that cannot exceed it is left at once.
    pub fn follow(&mut self, step: &Step<'_>, scratch: &mut [f64]) {
        let (support, coefficients) = (&self.support, &self.coefficients);
        let terms = || support.iter().copied().zip(coefficients.iter().copied());
        if reach(step, terms(), 0.0) <= self.largest_m_s {
            return;
        }
        let speed = |_: f64, y: &[f64]| terms().map(|(index, c)| c * y[index]).sum::<f64>();
        let (value, theta) = peak(step, step.theta_end, Probe { support, scratch }, speed);
        if value > self.largest_m_s {
            (self.largest_m_s, self.time_s) = (value, step.time(theta));
        }
    }

    /// The peak in m/s, which begins anew.
    pub fn take(&mut self) -> f64 {
        std::mem::take(&mut self.largest_m_s)
    }
}

/// What is remembered of one casting.
pub(super) struct CastingTrack {
    casting: usize,
    /// Peaks of points that move differently; that of the centre of mass comes first.
    peaks: Vec<PointPeak>,
    /// Points with their names, each with its place among the peaks.
    points: Vec<(PointId, String, usize)>,
    /// Components of its own velocities, and how far each reaches within a step.
    velocities: Range<usize>,
    reaches: Vec<f64>,
}

impl CastingTrack {
    pub fn new(model: &CoupledModel, scene: &Scene, casting: usize) -> Self {
        let velocities = model.velocities(PartId::Casting(casting));
        let velocity = |id: PointId| model.point_sums(id).map(|[_, velocity]| velocity).unwrap_or_default();
        let mut rows = vec![velocity(PointId::Centre { casting })];
        let mut place = |row| {
            let found = rows.iter().position(|known| *known == row);
            found.unwrap_or_else(|| {
                rows.push(row);
                rows.len() - 1
            })
        };
        let points = scene.points_of_casting(casting).into_iter();
        let points = points.map(|(id, name)| (id, name, place(velocity(id)))).collect();
        Self {
            casting,
            peaks: rows.iter().map(|row| PointPeak::new(velocities.start, row)).collect(),
            points,
            reaches: vec![0.0; velocities.len()],
            velocities,
        }
    }

    /// Follows a step.
    pub fn step(&mut self, step: &Step<'_>, scratch: &mut [f64]) {
        for (reached, component) in self.reaches.iter_mut().zip(self.velocities.clone()) {
            *reached = reach(step, std::iter::once((component, 1.0)), 0.0);
        }
        self.peaks.iter_mut().for_each(|point| point.update(step, &self.reaches, scratch));
    }

    /// Outputs of its core points.
    pub fn cores(&self) -> impl Iterator<Item = CoreMetrics> {
        let cores = self.points.iter().filter(|(id, ..)| matches!(id, PointId::Core { .. }));
        cores.map(|(_, _, place)| CoreMetrics {
            peak_velocity_m_s: self.peaks[*place].largest_m_s,
            ..CoreMetrics::default()
        })
    }

    /// The outputs at the end of the run; of points that are equally fast the first counts.
    pub fn finish(self, system: &Coupled, end: Instant<'_>) -> CastingMetrics {
        let mut metrics = CastingMetrics {
            peak_velocity_m_s: self.peaks[0].largest_m_s,
            peak_velocity_time_s: self.peaks[0].time_s,
            ..ledger(system, self.casting, end)
        };
        for (id, name, place) in &self.points {
            let PointPeak { largest_m_s, time_s, .. } = self.peaks[*place];
            if metrics.peak_point.is_empty() || largest_m_s > metrics.peak_point_velocity_m_s {
                (metrics.peak_point_velocity_m_s, metrics.peak_point_velocity_time_s) = (largest_m_s, time_s);
                metrics.peak_point.clone_from(name);
            }
            if matches!(id, PointId::Measured { .. }) {
                metrics.measuring_point_peak_velocity_m_s = Some(largest_m_s);
            }
        }
        metrics
    }
}

/// Ledger of the hammers' work on a casting. Each figure is computed by itself, none as the rest of the others.
fn ledger(system: &Coupled, casting: usize, Instant { t, y }: Instant<'_>) -> CastingMetrics {
    let model = system.model();
    let quadrature = |quantity| y[model.layout().casting_quadrature(casting, quantity)];
    let striking = || model.hammers().iter().enumerate().filter(|(_, hammer)| hammer.casting == casting);
    let work = |(hammer, _)| y[model.layout().quadrature(hammer, HammerQuadrature::Work)];
    let still_stored = striking().map(|(_, hammer)| system.contact_energy(hammer.strike, t, y)).sum::<f64>();
    CastingMetrics {
        delivered_work_j: striking().map(work).fold(0.0, |sum, work| sum + work),
        fixture_damper_loss_j: quadrature(CastingQuadrature::FixtureLoss),
        fixture_spring_energy_j: system.fixture_energy(casting, t, y),
        structure_work_j: quadrature(CastingQuadrature::StructureWork),
        kinetic_energy_j: model.kinetic_energy(PartId::Casting(casting), |velocity| y[velocity]),
        strike_contact_loss_j: quadrature(CastingQuadrature::ContactWork) - still_stored,
        ..CastingMetrics::default()
    }
}

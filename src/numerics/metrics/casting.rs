//! What is kept of one casting while it moves, and the outputs that follow from it.

use super::at::At;
use super::outputs::CastingMetrics;
use super::peak::{Probe, peak, reach};
use crate::integrate::Step;
use crate::system::{CastingQuadrature, CastingSlot, Coupled, HammerQuadrature, Layout, PointId};

/// The largest absolute velocity of one point.
struct PointPeak {
    /// Components of the state and their coefficients.
    support: Vec<usize>,
    coefficients: Vec<f64>,
    /// The same by the casting's own velocities: their number among these, and the size of the coefficient.
    shares: Vec<(usize, f64)>,
    largest_m_s: f64,
    time_s: f64,
}

impl PointPeak {
    fn new(layout: &Layout, heave: usize, row: &[(usize, f64)]) -> Self {
        Self {
            shares: row.iter().map(|(body, c)| (body - heave, c.abs())).collect(),
            support: row.iter().map(|(body, _)| layout.velocity(*body)).collect(),
            coefficients: row.iter().map(|(_, c)| *c).collect(),
            largest_m_s: 0.0,
            time_s: 0.0,
        }
    }

    /// Updates the peak; a step that cannot exceed it is left at once, as `reaches` of the casting's own velocities tell or the
    /// point's own.
    fn update(&mut self, step: &Step<'_>, reaches: &[f64], scratch: &mut [f64]) {
        if self.shares.iter().map(|(body, c)| c * reaches[*body]).sum::<f64>() <= self.largest_m_s {
            return;
        }
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
}

/// What is remembered of one casting.
pub(super) struct CastingTrack {
    heave: PointPeak,
    /// Points with their names. A casting that only heaves moves all its points alike: they are not followed.
    points: Vec<(PointId, String, PointPeak)>,
    rotates: bool,
    /// Components of its own velocities, heave first, and how far each reaches within a step.
    velocities: Vec<usize>,
    reaches: Vec<f64>,
}

impl CastingTrack {
    pub fn new(layout: &Layout, slot: &CastingSlot) -> Self {
        let peak = |row: &[(usize, f64)]| PointPeak::new(layout, slot.heave, row);
        let points = slot.points.iter().map(|point| (point.id, point.name.clone(), peak(&point.row)));
        Self {
            heave: peak(&[(slot.heave, 1.0)]),
            points: points.collect(),
            rotates: slot.rotations.iter().any(Option::is_some),
            reaches: vec![0.0; slot.velocities.len()],
            velocities: slot.velocities.clone(),
        }
    }

    /// Follows a step.
    pub fn step(&mut self, step: &Step<'_>, scratch: &mut [f64]) {
        for (reached, component) in self.reaches.iter_mut().zip(&self.velocities) {
            *reached = reach(step, std::iter::once((*component, 1.0)), 0.0);
        }
        self.heave.update(step, &self.reaches, scratch);
        if self.rotates {
            self.points.iter_mut().for_each(|(.., point)| point.update(step, &self.reaches, scratch));
        }
    }

    /// The outputs at the end of the run; of points that are equally fast the first counts.
    pub fn finish(self, system: &Coupled, casting: usize, end: At<'_>) -> CastingMetrics {
        let of = |point: &PointPeak| {
            let peak = if self.rotates { point } else { &self.heave };
            (peak.largest_m_s, peak.time_s)
        };
        let mut metrics = CastingMetrics {
            peak_velocity_m_s: self.heave.largest_m_s,
            peak_velocity_time_s: self.heave.time_s,
            ..ledger(system, casting, end)
        };
        for (id, name, point) in &self.points {
            let (largest, time_s) = of(point);
            if metrics.peak_point.is_empty() || largest > metrics.peak_point_velocity_m_s {
                (metrics.peak_point_velocity_m_s, metrics.peak_point_velocity_time_s) = (largest, time_s);
                metrics.peak_point.clone_from(name);
            }
            if matches!(id, PointId::Measured { .. }) {
                metrics.measuring_point_peak_velocity_m_s = Some(largest);
            }
        }
        metrics
    }
}

/// Ledger of the hammers' work on a casting. Each figure is computed by itself, none as the rest of the others.
fn ledger(system: &Coupled, casting: usize, At { t, y }: At<'_>) -> CastingMetrics {
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
        kinetic_energy_j: model.casting_energy(casting, y),
        strike_contact_loss_j: quadrature(CastingQuadrature::ContactWork) - still_stored,
        ..CastingMetrics::default()
    }
}

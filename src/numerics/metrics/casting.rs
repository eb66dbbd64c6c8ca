//! What is kept of one casting while it moves, and the outputs that follow from it.

use super::outputs::CastingMetrics;
use super::peak::{Probe, peak, reach};
use crate::integrate::Step;
use crate::system::{CastingSlot, Layout, MEASURING_POINT};

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
    /// Its points by name; those of a casting that only heaves move as the heave does and are not followed.
    points: Vec<(String, PointPeak)>,
    rotates: bool,
    /// Components of its own velocities, heave first, and how far each reaches within a step.
    velocities: Vec<usize>,
    reaches: Vec<f64>,
}

impl CastingTrack {
    pub fn new(layout: &Layout, slot: &CastingSlot) -> Self {
        let points =
            (slot.points.iter()).map(|point| (point.name.clone(), PointPeak::new(layout, slot.heave, &point.row)));
        let last = slot.points.iter().flat_map(|point| &point.row).map(|(body, _)| *body).fold(slot.heave, usize::max);
        let velocities: Vec<usize> = (slot.heave..=last).map(|body| layout.velocity(body)).collect();
        Self {
            heave: PointPeak::new(layout, slot.heave, &[(slot.heave, 1.0)]),
            points: points.collect(),
            rotates: slot.points.iter().any(|point| point.row.len() > 1),
            reaches: vec![0.0; velocities.len()],
            velocities,
        }
    }

    /// Follows a step.
    pub fn step(&mut self, step: &Step<'_>, scratch: &mut [f64]) {
        for (reached, component) in self.reaches.iter_mut().zip(&self.velocities) {
            *reached = reach(step, std::iter::once((*component, 1.0)), 0.0);
        }
        self.heave.update(step, &self.reaches, scratch);
        if self.rotates {
            self.points.iter_mut().for_each(|(_, point)| point.update(step, &self.reaches, scratch));
        }
    }

    /// The outputs; of points that are equally fast the first counts.
    pub fn finish(self) -> CastingMetrics {
        let of = |point: &PointPeak| {
            let peak = if self.rotates { point } else { &self.heave };
            (peak.largest_m_s, peak.time_s)
        };
        let mut metrics = CastingMetrics {
            peak_velocity_m_s: self.heave.largest_m_s,
            peak_velocity_time_s: self.heave.time_s,
            ..CastingMetrics::default()
        };
        for (name, point) in &self.points {
            let (largest, time_s) = of(point);
            if metrics.peak_point.is_empty() || largest > metrics.peak_point_velocity_m_s {
                (metrics.peak_point_velocity_m_s, metrics.peak_point_velocity_time_s) = (largest, time_s);
                metrics.peak_point.clone_from(name);
            }
            if name == MEASURING_POINT {
                metrics.measuring_point_peak_velocity_m_s = Some(largest);
            }
        }
        metrics
    }
}

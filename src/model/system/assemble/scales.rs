//! Error scales of the states.

use crate::hammer::body;
use crate::scene::{Freedom, Part};
use crate::system::block::{Block, CoupledPart};
use crate::system::impulse_response::SCALED_INTEGRALS;
use crate::system::layout::Layout;

/// Error scale of a body's position in m. At tolerance 1 it would be 29.5 kN in the contact of chisel and casting, 0.4 of the
/// peak of a first impact; at the default tolerance a step may miss 0.3 N of it.
const POSITION_SCALE_M: f64 = 1e-4;
/// Error scale of a body's velocity in m/s.
const VELOCITY_SCALE_M_S: f64 = 1.0;
/// Error scale of a piston's velocity in m/s: between blows it moves freely and steps are long, and its error reaches every
/// blow. Ten times finer than for other bodies costs one step in a hundred and errs five times less in the first impact.
const PISTON_VELOCITY_SCALE_M_S: f64 = 0.1;
/// Error scale of a chamber's pressure in Pa.
const PRESSURE_SCALE_PA: f64 = 1e5;
/// Lever in m that turns a rotation into the displacement whose scale applies.
const ROTATION_LEVER_M: f64 = 0.1;

/// Error scales of the states under error control, in their order. `parts` as the scene has them, and as they are coupled.
pub(super) fn scales<'s>(layout: &Layout, scene: impl Iterator<Item = &'s Part>, parts: &[CoupledPart]) -> Vec<f64> {
    let [mut bodies, mut velocities] = [(); 2].map(|()| Vec::with_capacity(layout.bodies));
    for part in scene {
        let Part::Rigid(freedoms) = part else { continue };
        for (freedom, _) in freedoms {
            let unit = if matches!(freedom, Freedom::Rotation(_)) { 1.0 / ROTATION_LEVER_M } else { 1.0 };
            let is_piston = *freedom == Freedom::Body(body::PISTON);
            bodies.push(unit);
            velocities.push(if is_piston { PISTON_VELOCITY_SCALE_M_S } else { unit * VELOCITY_SCALE_M_S });
        }
    }
    let mut scales = Vec::with_capacity(layout.states());
    let flexible: Vec<[Vec<f64>; 2]> = parts.iter().map(|part| of_flexible(&part.block)).collect();
    flexible.iter().for_each(|[displacements, _]| scales.extend_from_slice(displacements));
    scales.extend(scaled(&bodies, POSITION_SCALE_M));
    flexible.iter().for_each(|[_, velocities]| scales.extend_from_slice(velocities));
    scales.extend(velocities);
    scales.resize(layout.states(), PRESSURE_SCALE_PA);
    scales
}

fn scaled(unit: &[f64], scale: f64) -> Vec<f64> {
    unit.iter().map(|u| u * scale).collect()
}

/// Scales of a flexible part's states, from the motion that each state causes at the part's points.
fn of_flexible(block: &Block) -> [Vec<f64>; 2] {
    match block {
        Block::Rigid(_) => [Vec::new(), Vec::new()],
        // One scale for all modes: those that hardly move a point are held to the energy of those that do. An explicit method
        // may be unstable for them: the audit would find energy from nowhere that no output shows.
        Block::Modal(modes) => {
            let unit = vec![1.0 / modes.phi.amax(); modes.phi.nrows()];
            [POSITION_SCALE_M, VELOCITY_SCALE_M_S].map(|scale| scaled(&unit, scale))
        }
        Block::Condensed(condensed) => {
            let condensation = &condensed.constants.condensation;
            let unit: Vec<f64> = (0..condensation.points()).map(|point| condensation.force_scale(point)).collect();
            let integrals: [f64; SCALED_INTEGRALS] = [VELOCITY_SCALE_M_S, POSITION_SCALE_M];
            let mut scales: Vec<f64> = integrals.iter().flat_map(|scale| scaled(&unit, *scale)).collect();
            scales.resize(condensation.states(), f64::INFINITY);
            [scales, Vec::new()]
        }
    }
}

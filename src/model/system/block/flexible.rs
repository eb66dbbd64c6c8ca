//! Rates of a flexible part's block, of one row or of one in each lane.

use std::ops::Range;

use super::{Block, CoupledPart};
use crate::system::kernel::{Free, Kernel, TERMS};
use crate::system::modal::{MassShares, ModalRates, Motion};
use crate::system::products::{copy, long_sum, put_all};
use decore_math::number::Number;

/// Rates of a flexible part's block.
#[derive(Debug, Clone)]
pub(in crate::system) struct FlexibleRates<R> {
    /// Place of the part among all.
    pub part: usize,
    /// Columns of its points.
    pub columns: Range<usize>,
    states: [Range<usize>; 2],
    kind: StateKind<R>,
    tied: Option<MassShares<R>>,
    /// Accelerations of its points without the direct effect of the forces on them. Tied masses change them.
    acceleration: Vec<R>,
}

/// Kind of states, with their constants.
#[derive(Debug, Clone)]
enum StateKind<R> {
    /// Modes, integrated.
    Modal {
        modes: ModalRates<R>,
        /// Accelerations without forces, and the dissipated power, W.
        free: Vec<R>,
        loss: R,
    },
    /// Integrals of the forces, from a base on.
    Condensed { kernel: Kernel<R>, base_s: R, free: Vec<Free<R>> },
}

impl<R: Number> FlexibleRates<R> {
    /// Allocates the rates of part number `place`; `None` if the part is rigid.
    pub fn like(place: usize, part: &CoupledPart) -> Option<Self> {
        let zero = R::splat(0.0);
        let kind = match &part.block {
            Block::Rigid(_) => return None,
            Block::Modal(modes) => StateKind::Modal {
                modes: ModalRates::like(modes),
                free: vec![zero; modes.omega_squared.len()],
                loss: zero,
            },
            Block::Condensed(condensed) => StateKind::Condensed {
                kernel: Kernel::like(condensed.constants.condensation.kernel()),
                base_s: zero,
                free: vec![[zero; TERMS + 2]; part.columns.len()],
            },
        };
        Some(Self {
            part: place,
            columns: part.columns.clone(),
            states: part.states.clone(),
            kind,
            tied: part.tied.as_ref().map(MassShares::like),
            acceleration: vec![zero; part.columns.len()],
        })
    }

    /// Sets the constants of a lane, of the same shape.
    pub fn put(&mut self, lane: usize, part: &CoupledPart) {
        match (&mut self.kind, &part.block) {
            (StateKind::Modal { modes, .. }, Block::Modal(other)) => modes.put(lane, other),
            (StateKind::Condensed { kernel, .. }, Block::Condensed(other)) => {
                kernel.put(lane, other.constants.condensation.kernel());
            }
            _ => {}
        }
        if let (Some(own), Some(tied)) = (&mut self.tied, &part.tied) {
            own.put(lane, tied);
        }
    }

    /// Sets the modes of a lane's block that are outside the state.
    pub fn put_outside(&mut self, lane: usize, block: &Block) {
        if let (StateKind::Condensed { base_s, free, .. }, Block::Condensed(condensed)) = (&mut self.kind, block) {
            base_s.put(lane, &condensed.base.time_s);
            put_all(free.as_flattened_mut(), lane, condensed.base.free.as_flattened());
        }
    }

    /// Writes displacements and velocities of its points.
    #[inline(always)]
    pub fn gather(&mut self, t: R, y: &[R], [displacement, velocity]: [&mut [R]; 2]) {
        let [first, second] = &self.states;
        // Only tied masses ask for accelerations, and they are tied to the first points.
        let accelerated = self.tied.as_ref().map_or(0, MassShares::count);
        let acceleration = &mut self.acceleration[..accelerated];
        let mut motion = Motion { displacement, velocity, acceleration };
        let states = &y[first.clone()];
        match &mut self.kind {
            StateKind::Condensed { kernel, base_s, free } => kernel.motion(free, t - *base_s, states, &mut motion),
            StateKind::Modal { modes, free, loss } => {
                let velocities = &y[second.clone()];
                *loss = modes.free_accelerations(states, velocities, free);
                modes.motion([states, velocities, free], &mut motion);
            }
        }
    }

    /// Writes the rates of its states from the forces on its points, of which tied masses take their share; adds the power that
    /// states dissipate.
    #[inline(always)]
    pub fn write(&mut self, force: &mut [R], (y, rate): (&[R], &mut [R]), dissipated: &mut R) {
        let [first, second] = &self.states;
        if let Some(tied) = &self.tied {
            tied.share(force, &mut self.acceleration);
        }
        match &self.kind {
            // `z_1' = F`, `z_{k+1}' = z_k`.
            StateKind::Condensed { .. } => {
                let (points, z, rate) = (force.len(), &y[first.clone()], &mut rate[first.clone()]);
                copy(force, &mut rate[..points]);
                copy(&z[..z.len() - points], &mut rate[points..]);
            }
            // `x'' = -omega^2 x - 2 xi omega x' + Phi F` per mode.
            StateKind::Modal { modes, free, loss } => {
                rate[first.clone()].copy_from_slice(&y[second.clone()]);
                let acceleration = &mut rate[second.clone()];
                acceleration.copy_from_slice(free);
                modes.add_forces(force, acceleration);
                *dissipated += *loss;
            }
        }
    }

    /// Acceleration of its point `n` at a state whose rate is known.
    #[inline(always)]
    pub fn acceleration(&self, n: usize, t: R, [y, rate]: [&[R]; 2]) -> R {
        match &self.kind {
            StateKind::Condensed { kernel, base_s, free } => {
                let z = &y[self.states[0].clone()];
                let [_, _, mut acceleration] = kernel.point(free, t - *base_s, z, n);
                let forces = &rate[self.states[0].clone()][..self.acceleration.len()];
                for (m, force) in forces.iter().enumerate() {
                    acceleration = kernel.direct(n, m).mul_add(*force, acceleration);
                }
                acceleration
            }
            StateKind::Modal { modes, .. } => long_sum(modes.shapes_at(n), &rate[self.states[1].clone()]),
        }
    }
}

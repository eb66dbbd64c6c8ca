//! Positions of the quantities in the state vector.
//!
//! `y = [flexible | positions (b) | flexible' | velocities (b) | pressures (4 N) | quadratures]`. Blocks of flexible parts have states in
//! two places: modal displacements and velocities or, condensed, the integrals of the forces on their points and nothing. Rigid
//! parts have positions and velocities: hammers, then castings. Quadratures: per hammer four of its own and two per chamber, per
//! casting three, then work put in and energy dissipated.
//!
//! The columns of the elements' rows are the `b` rigid coordinates, then the driven points of the flexible blocks.

use std::ops::Range;

use crate::hammer::chamber;

/// Quadratures of one hammer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HammerQuadrature {
    /// Work of the chisel-casting force on the casting, J.
    Work = 0,
    /// Impulse of the chisel-casting force, N s.
    Impulse = 1,
    /// Mass drawn from the supply, kg.
    Air = 2,
    /// Integral of the squared velocity of the mount, m2/s.
    ArmVelocitySquared = 3,
}

impl HammerQuadrature {
    /// Number of them.
    const COUNT: usize = 4;
}

/// Quadratures of one casting: where the work of the hammers goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CastingQuadrature {
    /// Energy dissipated in the dampers of its fixtures, J.
    FixtureLoss = 0,
    /// Work of its fixtures on the structure, J.
    StructureWork = 1,
    /// Work that the chisels did on their contacts with it beyond the work on the casting, J: lost there, or still stored.
    ContactWork = 2,
}

impl CastingQuadrature {
    /// Number of quadratures.
    const COUNT: usize = 3;
}

/// Quadratures of one hammer, including its chambers.
const PER_HAMMER: usize = HammerQuadrature::COUNT + 2 * chamber::COUNT;
// Those of its own and either kind of its chambers' are equally many: a right-hand side writes them as three arrays.
const _: () = assert!(HammerQuadrature::COUNT == chamber::COUNT);

/// Sizes and offsets of the state vector.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    /// Numbers of states of the flexible blocks: in place of displacements, in place of velocities.
    pub flexible: [usize; 2],
    /// Coordinates of the rigid parts.
    pub bodies: usize,
    /// Hammers.
    pub hammers: usize,
    /// Castings.
    pub castings: usize,
}

impl Layout {
    /// States of flexible blocks in place of displacements.
    #[inline]
    pub fn flexible_displacements(&self) -> Range<usize> {
        0..self.flexible[0]
    }

    /// Position of rigid coordinate `body`.
    #[inline]
    pub fn position(&self, body: usize) -> usize {
        self.flexible[0] + body
    }

    /// States of flexible blocks in place of velocities.
    #[inline]
    pub fn flexible_velocities(&self) -> Range<usize> {
        let start = self.velocities();
        start..start + self.flexible[1]
    }

    /// Velocity of rigid coordinate `body`.
    #[inline]
    pub fn velocity(&self, body: usize) -> usize {
        self.velocities() + self.flexible[1] + body
    }

    /// Begin of the states that replace velocities.
    #[inline]
    pub fn velocities(&self) -> usize {
        self.flexible[0] + self.bodies
    }

    /// Chamber pressures of hammer `hammer`.
    #[inline]
    pub fn pressures(&self, hammer: usize) -> Range<usize> {
        let start = self.velocity(self.bodies) + chamber::COUNT * hammer;
        start..start + chamber::COUNT
    }

    /// Number of states of the coupled system (all that is under error control).
    pub fn states(&self) -> usize {
        self.velocity(self.bodies) + chamber::COUNT * self.hammers
    }

    /// All quadratures of hammer `hammer`: its own in the order of [`HammerQuadrature`], then its chambers'.
    #[inline]
    pub fn hammer_quadratures(&self, hammer: usize) -> Range<usize> {
        let start = self.quadrature(hammer, HammerQuadrature::Work);
        start..start + PER_HAMMER
    }

    /// A quadrature of hammer `hammer`.
    pub fn quadrature(&self, hammer: usize, quantity: HammerQuadrature) -> usize {
        self.states() + PER_HAMMER * hammer + quantity as usize
    }

    /// Energy supplied to the chambers of hammer `hammer` by their own equations, `int (R T (a_in m_in - a_out m_out) - (a - 1) P dV/dt)
    /// dt`, J.
    pub fn chambers_supplied(&self, hammer: usize) -> Range<usize> {
        let start = self.states() + PER_HAMMER * hammer + HammerQuadrature::COUNT;
        start..start + chamber::COUNT
    }

    /// `int |P dV|` of the chambers of hammer `hammer`, J.
    pub fn chambers_expansion(&self, hammer: usize) -> Range<usize> {
        let start = self.chambers_supplied(hammer).end;
        start..start + chamber::COUNT
    }

    /// All quadratures of the castings, casting by casting in the order of [`CastingQuadrature`].
    #[inline]
    pub fn casting_quadratures(&self) -> Range<usize> {
        let start = self.states() + PER_HAMMER * self.hammers;
        start..start + CastingQuadrature::COUNT * self.castings
    }

    /// A quadrature of casting `casting`.
    #[inline]
    pub fn casting_quadrature(&self, casting: usize, quantity: CastingQuadrature) -> usize {
        self.casting_quadratures().start + CastingQuadrature::COUNT * casting + quantity as usize
    }

    /// Work put in by gas and gravity, J.
    pub fn work_in(&self) -> usize {
        self.casting_quadratures().end
    }

    /// Dissipated energy, J, without condensed modes.
    pub fn dissipated(&self) -> usize {
        self.work_in() + 1
    }

    /// Length of the state vector.
    pub fn dimension(&self) -> usize {
        self.dissipated() + 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every component of the state has exactly one meaning.
    #[test]
    fn the_layout_is_a_partition() {
        for (flexible, hammers, castings) in [([0, 0], 0, 1), ([0, 0], 1, 1), ([12, 12], 3, 4), ([22, 0], 1, 1)] {
            let layout = Layout { flexible, bodies: 4 * hammers + castings, hammers, castings };
            let mut uses = vec![0; layout.dimension()];
            layout.flexible_displacements().chain(layout.flexible_velocities()).for_each(|at| uses[at] += 1);
            for body in 0..layout.bodies {
                uses[layout.position(body)] += 1;
                uses[layout.velocity(body)] += 1;
            }
            for hammer in 0..hammers {
                layout.pressures(hammer).for_each(|at| uses[at] += 1);
                use HammerQuadrature::{Air, ArmVelocitySquared, Impulse, Work};
                for quantity in [Work, Impulse, Air, ArmVelocitySquared] {
                    uses[layout.quadrature(hammer, quantity)] += 1;
                }
                layout.chambers_supplied(hammer).for_each(|at| uses[at] += 1);
                layout.chambers_expansion(hammer).for_each(|at| uses[at] += 1);
            }
            for casting in 0..castings {
                use CastingQuadrature::{ContactWork, FixtureLoss, StructureWork};
                for quantity in [FixtureLoss, StructureWork, ContactWork] {
                    uses[layout.casting_quadrature(casting, quantity)] += 1;
                }
            }
            uses[layout.work_in()] += 1;
            uses[layout.dissipated()] += 1;
            assert!(uses.iter().all(|count| *count == 1), "{uses:?}");
            assert_eq!(layout.states(), layout.quadrature(0, HammerQuadrature::Work));
        }
    }
}

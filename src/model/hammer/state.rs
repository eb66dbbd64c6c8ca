//! State of a hammer, with forces on its bodies and rates of its chambers.

use decore_math::number::Number;

/// Indices of the bodies within a hammer's state.
pub mod body {
    /// Housing guide (`Gh`).
    pub const GUIDE: usize = 0;
    /// Cylinder (`cb`).
    pub const CYLINDER: usize = 1;
    /// Spool valve (`sv`).
    pub const SPOOL: usize = 2;
    /// Piston (`p`).
    pub const PISTON: usize = 3;
    /// Chisel (`h`).
    pub const CHISEL: usize = 4;
    /// Number of bodies.
    pub const COUNT: usize = 5;
}

/// Indices of the gas chambers within a hammer's state.
pub mod chamber {
    /// Telescope top (`P1`).
    pub const TOP: usize = 0;
    /// Telescope annulus (`P2`).
    pub const ANNULUS: usize = 1;
    /// Behind the piston (`P3`).
    pub const REAR: usize = 2;
    /// Before the piston (`P4`).
    pub const FRONT: usize = 3;
    /// Number of chambers.
    pub const COUNT: usize = 4;
    /// Names of the states.
    pub const NAMES: [&str; COUNT] =
        ["top of the telescope", "annulus of the telescope", "rear of the piston", "front of the piston"];
    /// Parameters of a hammer that keep each from being driven empty: the stop before it and its room.
    pub const KEPT_BY: [&str; COUNT] = [
        "`telescope.top_stop.stiffness_n_per_m` or `telescope.top_clearance_m`",
        "`telescope.end_stop.stiffness_n_per_m` or `telescope.annulus_length_m`",
        "`piston.rear_wall.stiffness_n_per_m` or `piston.rear_clearance_m`",
        "`piston.front_clearance_m` or `piston.chamber_length_m`",
    ];
}

/// State of one hammer as the model sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HammerState<R: Number = f64> {
    /// Positions of the bodies in m.
    pub position: [R; body::COUNT],
    /// Velocities of the bodies in m/s.
    pub velocity: [R; body::COUNT],
    /// Absolute chamber pressures in Pa.
    pub pressure: [R; chamber::COUNT],
    /// Absolute supply pressure at this time in Pa (ambient before the start).
    pub supply_pa: R,
    /// Whether the percussion gate is open.
    pub gate_open: R::Mask,
}

/// Forces and rates at one state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HammerRates<R = f64> {
    /// Forces on the bodies in N, contacts excluded, gravity included.
    pub force: [R; body::COUNT],
    /// Pressure rates in Pa/s.
    pub pressure_rate: [R; chamber::COUNT],
    /// Power put in by gas and gravity in W.
    pub power_in_w: R,
    /// Power dissipated by friction and damping in W.
    pub dissipation_w: R,
    /// Mass flow drawn from the supply in kg/s.
    pub supply_flow_kg_s: R,
    /// Equation of each chamber for `d(P V)/dt`, in W: see [`ChamberBalance`].
    pub balance: [ChamberBalance<R>; chamber::COUNT],
}

/// Terms of a chamber's energy equation, from its flows and its walls and not from the rate of its pressure:
/// `d(P V)/dt = R T (a_in m_in - a_out m_out) - (a - 1) P dV/dt`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ChamberBalance<R = f64> {
    /// The right-hand side, W.
    pub supplied_w: R,
    /// `|P dV/dt|`, W: the size that the balance is measured by.
    pub expansion_w: R,
}

impl<R: Number> HammerRates<R> {
    /// Adds a force in N on a body, and its reaction on the one that it stands against.
    #[inline(always)]
    pub(super) fn push(&mut self, body: usize, against: usize, force_n: R) {
        self.force[body] += force_n;
        self.force[against] -= force_n;
    }
}

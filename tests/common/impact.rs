//! Problems with an impact law: at the stop the velocity turns round at once.

use super::harness::Piecewise;

/// `x'' = force`, `x <= stop`, `v -> -restitution v` there. States x, v. With restitution 0 the body stays at the stop.
#[derive(Debug, Clone, Copy)]
pub struct Bouncer {
    pub force: f64,
    pub stop: f64,
    pub restitution: f64,
    pub at_rest: bool,
}

impl Bouncer {
    pub fn new(force: f64, stop: f64, restitution: f64) -> Self {
        Self { force, stop, restitution, at_rest: false }
    }

    /// Time of bounce number `n` (from 1) of a body let go at x = 0, and the limit of all bounces.
    pub fn bounce(&self, n: i32) -> f64 {
        let (e, fall) = (self.restitution, (2.0 * self.stop / self.force).sqrt());
        fall * (1.0 + 2.0 * (e - e.powi(n)) / (1.0 - e))
    }

    pub fn last_bounce(&self) -> f64 {
        let e = self.restitution;
        (2.0 * self.stop / self.force).sqrt() * (1.0 + e) / (1.0 - e)
    }
}

impl Piecewise for Bouncer {
    fn states(&self) -> usize {
        2
    }

    fn rate(&self, _t: f64, y: &[f64], rate: &mut [f64]) {
        rate.copy_from_slice(&if self.at_rest { [0.0, 0.0] } else { [y[1], self.force] });
    }

    fn guards(&self) -> usize {
        1
    }

    fn guard(&self, _guard: usize, y: &[f64]) -> f64 {
        if self.at_rest { -1.0 } else { y[0] - self.stop }
    }

    fn guard_rate(&self, _guard: usize, rate: &[f64]) -> f64 {
        rate[0]
    }

    fn switch(&mut self, _guard: usize, _t: f64, y: &mut [f64]) {
        y[1] = -self.restitution * y[1].abs();
        self.at_rest = self.restitution == 0.0;
    }
}

/// One-sided impact oscillator (Shaw and Holmes 1983): `x'' + x = b cos(w t)`, `x <= s`, `v -> -r v` at the stop.
#[derive(Debug, Clone, Copy)]
pub struct ImpactOscillator {
    pub b: f64,
    pub w: f64,
    pub s: f64,
    pub r: f64,
}

/// The orbit with one impact per period of the forcing.
#[derive(Debug, Clone, Copy)]
pub struct Orbit {
    /// Velocity just before the impact.
    pub velocity: f64,
    /// `w t` at the impact, in (-pi, pi].
    pub phase: f64,
    /// Trace of the linearised return map; its determinant is `r^2`.
    pub trace: f64,
}

impl ImpactOscillator {
    /// The orbit from its closed form, for a stop at s = 0.
    pub fn orbit(&self) -> Orbit {
        assert_eq!(self.s, 0.0);
        let period = 2.0 * std::f64::consts::PI / self.w;
        let g = self.b / (1.0 - self.w * self.w);
        let across = 0.5 * (1.0 + self.r) / (0.5 * period).tan();
        let along = 0.5 * (1.0 - self.r) / self.w;
        let velocity = g.abs() / across.hypot(along);
        let phase = (-along * velocity / g).atan2(across * velocity / g);
        let acceleration = self.b * phase.cos() - self.s;
        // Free flight over one period times the jump at the impact, `[[-r, 0], [(1 + r) a / V, -r]]`.
        let trace = -2.0 * self.r * period.cos() + (1.0 + self.r) * acceleration / velocity * period.sin();
        Orbit { velocity, phase, trace }
    }
}

impl Piecewise for ImpactOscillator {
    fn states(&self) -> usize {
        2
    }

    fn rate(&self, t: f64, y: &[f64], rate: &mut [f64]) {
        rate.copy_from_slice(&[y[1], self.b * (self.w * t).cos() - y[0]]);
    }

    fn guards(&self) -> usize {
        1
    }

    fn guard(&self, _guard: usize, y: &[f64]) -> f64 {
        y[0] - self.s
    }

    fn guard_rate(&self, _guard: usize, rate: &[f64]) -> f64 {
        rate[0]
    }

    fn switch(&mut self, _guard: usize, _t: f64, y: &mut [f64]) {
        y[1] *= -self.r;
    }
}

/// Pressure-relief valve: `x'' = -1.25 x' - (x + 10) + p`, `p' = 20 (q - x sqrt(p))`, `x >= 0` with restitution 0.8.
#[derive(Debug, Clone, Copy)]
pub struct ReliefValve {
    pub q: f64,
}

impl Piecewise for ReliefValve {
    fn states(&self) -> usize {
        3
    }

    fn rate(&self, _t: f64, y: &[f64], rate: &mut [f64]) {
        rate.copy_from_slice(&[y[1], -1.25 * y[1] - (y[0] + 10.0) + y[2], 20.0 * (self.q - y[0] * y[2].sqrt())]);
    }

    fn guards(&self) -> usize {
        1
    }

    fn guard(&self, _guard: usize, y: &[f64]) -> f64 {
        -y[0]
    }

    fn guard_rate(&self, _guard: usize, rate: &[f64]) -> f64 {
        -rate[0]
    }

    fn switch(&mut self, _guard: usize, _t: f64, y: &mut [f64]) {
        y[1] = 0.8 * y[1].abs();
    }
}

//! Problems with a known solution between their switches.

use decore_model::integrate::System;

use super::harness::Piecewise;

/// Motion on an ellipse of semi-axis 1 and period `2 pi`; states x, y, x', y'. It starts one unit of time after the
/// pericentre: its symmetry there makes some powers of the step drop out of the errors.
#[derive(Debug, Clone, Copy)]
pub struct Kepler {
    pub eccentricity: f64,
}

impl Kepler {
    pub fn solution(&self, t: f64) -> Vec<f64> {
        let e = self.eccentricity;
        let t = t + 1.0;
        let mut anomaly = t;
        for _ in 0..100 {
            anomaly -= (anomaly - e * anomaly.sin() - t) / (1.0 - e * anomaly.cos());
        }
        let (sin, cos) = anomaly.sin_cos();
        let (width, speed) = ((1.0 - e * e).sqrt(), 1.0 / (1.0 - e * cos));
        vec![cos - e, width * sin, -sin * speed, width * cos * speed]
    }
}

impl System for Kepler {
    fn dimension(&self) -> usize {
        4
    }

    fn scales(&self) -> &[f64] {
        &[1.0; 4]
    }

    fn rhs(&mut self, _t: f64, y: &[f64], rate: &mut [f64]) {
        let cube = (y[0] * y[0] + y[1] * y[1]).powf(1.5);
        rate.copy_from_slice(&[y[2], y[3], -y[0] / cube, -y[1] / cube]);
    }
}

/// Two coupled nonlinear equations that depend on time, made so that the solution is `sin t + 2`, `cos 2 t + 2`; errors
/// made on the way die out.
#[derive(Debug, Clone, Copy)]
pub struct Manufactured;

impl Manufactured {
    pub fn solution(&self, t: f64) -> Vec<f64> {
        vec![t.sin() + 2.0, (2.0 * t).cos() + 2.0]
    }

    fn flow(y: &[f64]) -> [f64; 2] {
        [-y[0] * y[1], -0.5 * y[1] * y[1] + y[0].sin()]
    }
}

impl System for Manufactured {
    fn dimension(&self) -> usize {
        2
    }

    fn scales(&self) -> &[f64] {
        &[1.0; 2]
    }

    fn rhs(&mut self, t: f64, y: &[f64], rate: &mut [f64]) {
        let (own, exact) = (Self::flow(y), Self::flow(&self.solution(t)));
        rate.copy_from_slice(&[t.cos() + own[0] - exact[0], -2.0 * (2.0 * t).sin() + own[1] - exact[1]]);
    }
}

/// `x'' = -x` from (1, 0) with guards that follow the crossings of `levels` in both directions; the switch of a guard
/// only turns its direction round. Quadratures if asked for: the integral of `x^2` and of the kinetic energy.
#[derive(Debug, Clone)]
pub struct Oscillator {
    pub levels: Vec<f64>,
    /// 1 while the level is awaited from below.
    pub direction: Vec<f64>,
    pub quadratures: usize,
}

impl Oscillator {
    pub fn new(levels: &[f64]) -> Self {
        let direction = levels.iter().map(|level| if *level >= 1.0 { 1.0 } else { -1.0 }).collect();
        Self { levels: levels.to_vec(), direction, quadratures: 0 }
    }

    /// Times up to `end` at which the level is crossed: `+- acos(level) + 2 pi n`.
    pub fn crossings(level: f64, end: f64) -> Vec<f64> {
        let (turn, angle) = (2.0 * std::f64::consts::PI, level.acos());
        let all = (0..).flat_map(|n| [f64::from(n) * turn + angle, f64::from(n + 1) * turn - angle]);
        all.take_while(|t| *t <= end).collect()
    }
}

impl Piecewise for Oscillator {
    fn states(&self) -> usize {
        2
    }

    fn quadratures(&self) -> usize {
        self.quadratures
    }

    fn rate(&self, _t: f64, y: &[f64], rate: &mut [f64]) {
        rate[..2].copy_from_slice(&[y[1], -y[0]]);
        if self.quadratures > 0 {
            rate[2] = y[0] * y[0];
            rate[3] = 0.5 * y[1] * y[1];
        }
    }

    fn guards(&self) -> usize {
        self.levels.len()
    }

    fn guard(&self, guard: usize, y: &[f64]) -> f64 {
        self.direction[guard] * (y[0] - self.levels[guard])
    }

    fn guard_rate(&self, guard: usize, rate: &[f64]) -> f64 {
        self.direction[guard] * rate[0]
    }

    fn switch(&mut self, guard: usize, _t: f64, _y: &mut [f64]) {
        self.direction[guard] *= -1.0;
    }
}

/// `y' = slope`, the slope multiplied by `factor` at every stop: straight lines whose kinks are the stops.
#[derive(Debug, Clone)]
pub struct Polyline {
    pub stops: Vec<f64>,
    pub factor: f64,
    pub slope: f64,
    /// Stops passed, in the order in which they were.
    pub passed: Vec<usize>,
}

impl Polyline {
    pub fn new(stops: &[f64], factor: f64) -> Self {
        Self { stops: stops.to_vec(), factor, slope: 1.0, passed: Vec::new() }
    }

    pub fn solution(&self, t: f64) -> f64 {
        let (mut value, mut slope, mut from) = (0.0, 1.0, 0.0);
        for stop in self.stops.iter().filter(|stop| **stop < t) {
            value += slope * (stop - from);
            slope *= self.factor;
            from = *stop;
        }
        value + slope * (t - from)
    }
}

impl Piecewise for Polyline {
    fn states(&self) -> usize {
        1
    }

    fn rate(&self, _t: f64, _y: &[f64], rate: &mut [f64]) {
        rate[0] = self.slope;
    }

    fn stops(&self) -> &[f64] {
        &self.stops
    }

    fn pass(&mut self, stop: usize) {
        self.slope *= self.factor;
        self.passed.push(stop);
    }
}

/// `y' = y^2` from 1: the solution `1 / (1 - t)` ends at t = 1.
#[derive(Debug, Clone, Copy)]
pub struct Explosion;

impl System for Explosion {
    fn dimension(&self) -> usize {
        1
    }

    fn scales(&self) -> &[f64] {
        &[1.0; 1]
    }

    fn rhs(&mut self, _t: f64, y: &[f64], rate: &mut [f64]) {
        rate[0] = y[0] * y[0];
    }
}

/// `y' = 1` from 0, valid only up to `limit`: beyond it the rate is not a number.
#[derive(Debug, Clone, Copy)]
pub struct Cliff {
    pub limit: f64,
}

impl System for Cliff {
    fn dimension(&self) -> usize {
        1
    }

    fn scales(&self) -> &[f64] {
        &[1.0; 1]
    }

    fn rhs(&mut self, _t: f64, y: &[f64], rate: &mut [f64]) {
        rate[0] = if y[0] <= self.limit { 1.0 } else { f64::NAN };
    }
}

//! One accepted step with its dense output.

use crate::integrate::tsit5::{self, STAGES};
use decore_math::number::Number;

/// Interpolation of a step from rates. The first rate is the one at the start of the step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dense {
    /// The stages of the method of order 5.
    Tsit5,
    /// Rate at the start, rate at the end, mean rate: the cubic through both ends with their rates.
    Hermite,
}

impl Dense {
    /// Number of rates.
    pub(super) const fn rates(self) -> usize {
        match self {
            Self::Tsit5 => STAGES,
            Self::Hermite => 3,
        }
    }

    /// Index of the rate at the end of the step.
    pub(super) const fn last(self) -> usize {
        match self {
            Self::Tsit5 => STAGES - 1,
            Self::Hermite => 1,
        }
    }

    /// Coefficients of the weights of the rates, by powers of the fraction from 1 on.
    const fn coefficients(self) -> [[f64; 4]; STAGES] {
        match self {
            Self::Tsit5 => tsit5::INTERPOLANT,
            Self::Hermite => {
                let none = [0.0; 4];
                let [start, end, mean] = [[1.0, -2.0, 1.0, 0.0], [0.0, -1.0, 1.0, 0.0], [0.0, 3.0, -2.0, 0.0]];
                [start, end, mean, none, none, none, none]
            }
        }
    }

    /// Coefficients of the weights of the rates in the interpolant's own rate, by powers of the fraction from 0 on.
    pub(super) const fn slopes(self) -> [[f64; 4]; STAGES] {
        let mut slopes = self.coefficients();
        let mut rate = 0;
        while rate < STAGES {
            let mut power = 0;
            while power < 4 {
                slopes[rate][power] *= (power + 1) as f64;
                power += 1;
            }
            rate += 1;
        }
        slopes
    }

    /// Weights of the rates at fraction `theta`; 0 for rates that a method does not have.
    #[inline]
    fn weights(self, theta: f64) -> [f64; STAGES] {
        match self {
            Self::Tsit5 => tsit5::interpolant(theta),
            Self::Hermite => {
                let (back, square) = (1.0 - theta, theta * theta);
                [theta * back * back, -square * back, square * (3.0 - 2.0 * theta), 0.0, 0.0, 0.0, 0.0]
            }
        }
    }
}

/// Fractions and weights of Gauss and Legendre on the interval from 0 to 1: exact for polynomials of degree 5.
const GAUSS: [(f64, f64); 3] =
    [(0.112_701_665_379_258_3, 5.0 / 18.0), (0.5, 4.0 / 9.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];

/// The values of one lane.
#[derive(Debug, Clone, Copy)]
struct Values<'a> {
    /// Values of all lanes, component by component.
    all: &'a [f64],
    lanes: usize,
    lane: usize,
}

impl<'a> Values<'a> {
    fn new<R: Number>(all: &'a [R], lane: usize) -> Self {
        Self { all: bytemuck::cast_slice(all), lanes: R::LANES, lane }
    }

    #[inline(always)]
    fn at(&self, index: usize) -> f64 {
        self.all[index * self.lanes + self.lane]
    }
}

/// A polynomial in the fraction of a step: its value at 0, and the coefficients from the first power on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Polynomial {
    constant: f64,
    coefficients: [f64; 4],
}

impl Polynomial {
    /// Value at `theta`.
    pub fn at(&self, theta: f64) -> f64 {
        self.constant + self.coefficients.iter().rev().fold(0.0, |sum, coefficient| (sum + coefficient) * theta)
    }
}

/// Data of a step of one lane.
pub(super) struct Ingredients<'a, R> {
    /// The state at its start and that at its end, cut or not.
    pub ends: [&'a [R]; 2],
    /// Rates, one after the other, each of the state's length.
    pub rates: &'a [R],
    /// Interpolation of the steps.
    pub dense: Dense,
}

/// An accepted step: from `t0`, `theta_end * h` long, with dense output at any fraction of `h` up to `theta_end`.
#[derive(Debug, Clone, Copy)]
pub struct Step<'a> {
    /// Time at the start in s.
    pub t0: f64,
    /// Length of the step as computed, in s; the accepted part may be shorter.
    pub h: f64,
    /// Fraction of `h` that was accepted: 1, or less where an event ended the step.
    pub theta_end: f64,
    dense: Dense,
    n: usize,
    y0: Values<'a>,
    y1: Values<'a>,
    rates: Values<'a>,
}

impl<'a> Step<'a> {
    /// The step of a lane that begins at `t0` and is `h` long.
    pub(super) fn new<R: Number>(of: &Ingredients<'a, R>, lane: usize, (t0, h): (f64, f64)) -> Self {
        let values = |all| Values::new(all, lane);
        Self {
            t0,
            h,
            theta_end: 1.0,
            dense: of.dense,
            n: of.ends[0].len(),
            y0: values(of.ends[0]),
            y1: values(of.ends[1]),
            rates: values(of.rates),
        }
    }

    /// Time at the end of the accepted part in s.
    pub fn t1(&self) -> f64 {
        self.time(self.theta_end)
    }

    /// Time at fraction `theta` in s.
    pub fn time(&self, theta: f64) -> f64 {
        self.t0 + theta * self.h
    }

    /// Fraction at time `t` within the accepted part.
    pub fn fraction(&self, t: f64) -> f64 {
        ((t - self.t0) / self.h).clamp(0.0, self.theta_end)
    }

    /// Number of components of the state.
    pub fn dimension(&self) -> usize {
        self.n
    }

    /// Component `index` of the state at the start.
    pub fn start(&self, index: usize) -> f64 {
        self.y0.at(index)
    }

    /// Component `index` of the state at the end of the accepted part.
    pub fn end(&self, index: usize) -> f64 {
        self.y1.at(index)
    }

    /// Writes the state at the start into `y`.
    pub fn write_start(&self, y: &mut [f64]) {
        y.iter_mut().enumerate().for_each(|(index, value)| *value = self.start(index));
    }

    /// Writes the state at the end of the accepted part into `y`.
    pub fn write_end(&self, y: &mut [f64]) {
        y.iter_mut().enumerate().for_each(|(index, value)| *value = self.end(index));
    }

    /// Largest absolute rate of a sum of components with coefficients: a practical bound of its rate within the step.
    pub fn largest_rate(&self, terms: impl Iterator<Item = (usize, f64)> + Clone) -> f64 {
        match (self.dense, self.rates.lanes) {
            (Dense::Hermite, lanes) => self.largest::<{ Dense::Hermite.rates() }>(lanes, terms),
            (Dense::Tsit5, 1) => self.largest::<STAGES>(1, terms),
            (Dense::Tsit5, 4) => self.largest::<STAGES>(4, terms),
            (Dense::Tsit5, _) => self.largest::<STAGES>(8, terms),
        }
    }

    /// The same of `RATES` rates in one of some lanes.
    #[inline(always)]
    fn largest<const RATES: usize>(&self, lanes: usize, terms: impl Iterator<Item = (usize, f64)>) -> f64 {
        let mut sums = [0.0; RATES];
        // All of one length, to which an index is held once.
        let rates: [&[f64]; RATES] = std::array::from_fn(|j| &self.rates.all[j * self.n * lanes..][..self.n * lanes]);
        for (index, c) in terms {
            for (sum, rate) in sums.iter_mut().zip(rates) {
                *sum += c * rate[index * lanes + self.rates.lane];
            }
        }
        sums.iter().fold(0.0, |largest, sum| if sum.abs() > largest { sum.abs() } else { largest })
    }

    /// Component `index` of the state at fraction `theta`.
    pub fn component(&self, index: usize, theta: f64) -> f64 {
        let weights = self.dense.weights(theta);
        let rates = weights.iter().enumerate().take(self.dense.rates());
        let sum = rates.fold(0.0, |sum, (j, weight)| sum + weight * self.rates.at(j * self.n + index));
        self.y0.at(index) + self.h * sum
    }

    /// Writes the components `support` of the state at fraction `theta` into `y`; the others are left as they are.
    pub fn components(&self, support: &[usize], theta: f64, y: &mut [f64]) {
        self.write(theta, support.iter().copied(), y);
    }

    /// Writes the whole state at fraction `theta` into `y`.
    pub fn state(&self, theta: f64, y: &mut [f64]) {
        self.write(theta, 0..self.n, y);
    }

    /// Number of places at which an integral over the step is read, see [`Self::place`].
    pub fn places(&self) -> usize {
        match self.dense {
            Dense::Tsit5 => STAGES,
            Dense::Hermite => GAUSS.len(),
        }
    }

    /// Writes the state at a place of the step into `y`; returns its time and its weight in s. The sum of weights times values integrates a
    /// function of time and state over the accepted part: with the stages of the method of order 5 as if it were a component of the
    /// state, else on the dense output.
    pub fn place(&self, place: usize, y: &mut [f64]) -> (f64, f64) {
        match self.dense {
            Dense::Tsit5 => {
                for (index, value) in y.iter_mut().enumerate().take(self.n) {
                    let rates = tsit5::A[place].iter().enumerate().take(place);
                    let sum = rates.fold(0.0, |sum, (j, a)| sum + a * self.rates.at(j * self.n + index));
                    *value = self.y0.at(index) + self.h * sum;
                }
                (self.time(tsit5::C[place]), self.h * self.dense.weights(self.theta_end)[place])
            }
            Dense::Hermite => {
                let (fraction, weight) = GAUSS[place];
                let theta = fraction * self.theta_end;
                self.state(theta, y);
                (self.time(theta), weight * self.theta_end * self.h)
            }
        }
    }

    /// Rate of component `index` of the interpolated state at fraction `theta`: at both ends the rate of the system.
    pub fn slope(&self, index: usize, theta: f64) -> f64 {
        let powers = [1.0, 2.0 * theta, 3.0 * theta * theta, 4.0 * theta * theta * theta];
        let weight = |coefficients: &[f64; 4]| coefficients.iter().zip(powers).map(|(c, power)| c * power).sum::<f64>();
        let rates = self.dense.coefficients();
        (0..self.dense.rates()).map(|j| weight(&rates[j]) * self.rates.at(j * self.n + index)).sum()
    }

    /// A sum of components with coefficients, as a polynomial in the fraction of the step.
    pub(super) fn polynomial(&self, terms: &[(usize, f64)]) -> Polynomial {
        let sum =
            |values: &Values<'_>, from: usize| terms.iter().map(|(index, c)| c * values.at(from + index)).sum::<f64>();
        let mut coefficients = [0.0; 4];
        for (j, weights) in self.dense.coefficients().iter().enumerate().take(self.dense.rates()) {
            let rate = self.h * sum(&self.rates, j * self.n);
            for (coefficient, weight) in coefficients.iter_mut().zip(weights) {
                *coefficient += weight * rate;
            }
        }
        Polynomial { constant: sum(&self.y0, 0), coefficients }
    }

    /// Rate of a sum of components with coefficients in 1/s, by powers of the fraction of the step from 0 on.
    pub fn rate(&self, terms: &[(usize, f64)]) -> [f64; 4] {
        let mut powers = [0.0; 4];
        for (j, weights) in self.dense.slopes().iter().enumerate().take(self.dense.rates()) {
            let rate = terms.iter().map(|(index, c)| c * self.rates.at(j * self.n + index)).sum::<f64>();
            powers.iter_mut().zip(weights).for_each(|(power, weight)| *power += weight * rate);
        }
        powers
    }

    /// Writes components of the state at fraction `theta` into `y`, the way through memory worked out once.
    #[inline(always)]
    fn write(&self, theta: f64, components: impl Iterator<Item = usize>, y: &mut [f64]) {
        match (self.dense, self.rates.lanes) {
            (Dense::Hermite, _) => components.for_each(|index| y[index] = self.component(index, theta)),
            (Dense::Tsit5, 1) => self.write_lane::<1>(theta, components, y),
            (Dense::Tsit5, 4) => self.write_lane::<4>(theta, components, y),
            (Dense::Tsit5, _) => self.write_lane::<8>(theta, components, y),
        }
    }

    /// The same of a lane of `LANES`.
    #[inline(always)]
    fn write_lane<const LANES: usize>(&self, theta: f64, components: impl Iterator<Item = usize>, y: &mut [f64]) {
        let weights = self.dense.weights(theta);
        let (n, lane) = (self.n, self.rates.lane % LANES);
        let (start, rates) = (self.y0.all.as_chunks::<LANES>().0, self.rates.all.as_chunks::<LANES>().0);
        // All of one length, to which an index is held once.
        let rates: [&[[f64; LANES]]; STAGES] = std::array::from_fn(|j| &rates[j * n..][..n]);
        let start = &start[..n];
        for index in components {
            let mut sum = 0.0;
            for (weight, rate) in weights.iter().zip(rates) {
                sum += weight * rate[index][lane];
            }
            y[index] = start[index][lane] + self.h * sum;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums over the places of a step are exact integrals: with stages up to `t^4` over a whole step and `t^3` over a part of it, with the
    /// cubic up to `t^5`.
    #[test]
    fn analytic_integrals_by_places() {
        let (t0, h) = (0.3_f64, 0.7);
        // The state is the time itself.
        let (y0, y1, rates) = ([t0], [t0 + h], [1.0; STAGES]);
        let exact = |end: f64, power: i32| (end.powi(power + 1) - t0.powi(power + 1)) / f64::from(power + 1);
        for (dense, theta_end, powers) in [(Dense::Tsit5, 1.0, 4), (Dense::Tsit5, 0.6, 3), (Dense::Hermite, 0.6, 5)] {
            let of = Ingredients { ends: [&y0, &y1], rates: &rates[..dense.rates()], dense };
            let step = Step { theta_end, ..Step::new(&of, 0, (t0, h)) };
            for power in 0..=powers {
                let mut y = [0.0];
                let sum = (0..step.places()).fold(0.0, |sum, place| {
                    let (t, weight_s) = step.place(place, &mut y);
                    assert!((t - y[0]).abs() < 1e-14);
                    sum + weight_s * y[0].powi(power)
                });
                assert!((sum - exact(step.t1(), power)).abs() < 1e-13, "{dense:?} {power}");
            }
        }
    }

    /// The interpolant goes through both ends with their rates: a cubic is reproduced exactly.
    #[test]
    fn analytic_hermite_interpolant_reproduces_cubics() {
        let cubic = |t: f64| [1.0 + t * (2.0 + t * (-3.0 + 0.5 * t))];
        let slope = |t: f64| 2.0 + t * (-6.0 + 1.5 * t);
        let (t0, h) = (0.3, 0.7);
        let (y0, y1) = (cubic(t0), cubic(t0 + h));
        let rates = [slope(t0), slope(t0 + h), (y1[0] - y0[0]) / h];
        let of = Ingredients { ends: [&y0, &y1], rates: &rates, dense: Dense::Hermite };
        let step = Step::new(&of, 0, (t0, h));
        for theta in [0.0, 0.2, 0.5, 0.9, 1.0] {
            assert!((step.component(0, theta) - cubic(t0 + theta * h)[0]).abs() < 1e-14);
            assert!((step.slope(0, theta) - slope(t0 + theta * h)).abs() < 1e-14);
        }
        assert_eq!(
            step.largest_rate([(0, 1.0)].into_iter()),
            rates.iter().fold(0.0_f64, |largest, rate| largest.max(rate.abs()))
        );
    }
}

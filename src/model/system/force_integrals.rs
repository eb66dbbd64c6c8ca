//! Repeated integrals of the forces on the interface points since the last node of each row, `z_1' = F`, `z_{k+1}' = z_k`, for one row or
//! one in each lane. The dissipation of condensed modes follows from them.
//!
//! Within a step the forces are the slopes of the interpolated first integrals of the state, polynomials of the third degree. So nothing
//! beyond the first integrals is read, and what is integrated here has no error but that of the forces.

use pulp::{Simd, WithSimd};

use crate::integrate::Taken;
use crate::system::dissipation::Damping;
use crate::system::kernel::ORDER;
use decore_math::number::{Mask, Number};

/// The integrals of all lanes.
#[derive(Debug, Clone)]
pub(super) struct ForceIntegrals<R: Number> {
    /// Integrals that a lane needs at most.
    orders: usize,
    points: usize,
    /// Component of the state that is the first integral of the first point's force.
    first: usize,
    /// By order from 1 on, then by point; room for all orders.
    values: Vec<R>,
    /// The forces within a step, see [`Taken::slopes`]: by power, then by point.
    forces: Vec<R>,
    /// Time of the next node of each lane, s.
    next_s: R,
    /// Integrals of one lane.
    own: Vec<f64>,
}

impl<R: Number> ForceIntegrals<R> {
    /// Allocates moments for a number of points. `first` is the component of the state that is the first integral of the first point's
    /// force.
    pub fn new(points: usize, first: usize) -> Self {
        let none = R::splat(0.0);
        Self {
            orders: 0,
            points,
            first,
            values: vec![none; ORDER * points],
            forces: vec![none; POWERS * points],
            next_s: none,
            own: vec![0.0; ORDER * points],
        }
    }

    /// Begins anew in a lane, at rest.
    pub fn begin(&mut self, lane: usize, damping: &Damping) {
        self.orders = self.orders.max(damping.orders());
        self.values.iter_mut().for_each(|value| value.put(lane, &0.0));
        self.next_s.put(lane, &damping.node_s(0));
    }

    /// Follows a step; at each node of a lane its integrals are shown, which gives the time of the next node, and begin again.
    pub fn follow(&mut self, taken: &Taken<'_, R>, mut at_node: impl FnMut(usize, &[f64]) -> f64) {
        let (mut from, mut first, mut begun) = (R::splat(0.0), true, R::Mask::default());
        loop {
            let (to, reached) = R::dispatch(Passage { moments: self, taken, from, first, begun });
            if !reached.any() {
                return;
            }
            let count = self.orders * self.points;
            for lane in (0..R::LANES).filter(|lane| reached.lane(*lane)) {
                let values: &[f64] = bytemuck::cast_slice(&self.values[..count]);
                self.own.iter_mut().zip(values.chunks_exact(R::LANES)).for_each(|(own, lanes)| *own = lanes[lane]);
                self.next_s.put(lane, &at_node(lane, &self.own[..count]));
            }
            (from, first, begun) = (to, false, reached);
        }
    }
}

/// The way of each lane from a fraction of its step on to its next node, or to its end if there is none on the way.
struct Passage<'p, 't, R: Number> {
    moments: &'p mut ForceIntegrals<R>,
    taken: &'p Taken<'t, R>,
    from: R,
    /// Whether it is the first of the step.
    first: bool,
    /// Lanes in which the integrals begin again there.
    begun: R::Mask,
}

impl<R: Number> WithSimd for Passage<'_, '_, R> {
    /// End of the interval, and the lanes that are at a node there.
    type Output = (R, R::Mask);

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _: S) -> (R, R::Mask) {
        let taken = self.taken;
        let node = (self.moments.next_s - taken.t) / taken.h;
        let reached = taken.accepted.and(node.less_equal(taken.theta));
        let to = R::select(reached, node, taken.theta);
        let span = to - self.from;
        let terms = terms(span * taken.h);
        let (points, mut at) = (self.moments.points, 0);
        while at + 4 <= points {
            self.move_some::<4>(at, span, &terms);
            at += 4;
        }
        if at + 2 <= points {
            self.move_some::<2>(at, span, &terms);
            at += 2;
        }
        if at < points {
            self.move_some::<1>(at, span, &terms);
        }
        (to, reached)
    }
}

impl<R: Number> Passage<'_, '_, R> {
    /// Moves the integrals of `N` points from `at` on: points of a row alone stand in registers side by side.
    #[inline(always)]
    fn move_some<const N: usize>(&mut self, at: usize, span: R, terms: &[R; ORDER + 1]) {
        let (taken, ForceIntegrals { orders, points, first, values, forces, .. }) = (self.taken, &mut *self.moments);
        let own = |order: usize| order * *points + at..order * *points + at + N;
        if self.first {
            for (power, slope) in taken.slopes::<N>(*first + at).into_iter().enumerate() {
                forces[own(power)].copy_from_slice(&slope);
            }
        }
        let mut parts = [[R::splat(0.0); N]; POWERS];
        for n in 0..N {
            let force = std::array::from_fn(|power| forces[own(power)][n]);
            for (part, of_point) in parts.iter_mut().zip(over(force, self.from, span)) {
                part[n] = of_point;
            }
        }
        // The highest first: each follows from those below it as they were.
        for k in (1..=(*orders).min(ORDER)).rev() {
            let mut old = [R::splat(0.0); N];
            old.copy_from_slice(&values[own(k - 1)]);
            let mut sum = old;
            if self.first {
                for i in 1..k {
                    let lower = &values[own(k - 1 - i)];
                    for n in 0..N {
                        sum[n] = terms[i].mul_add(lower[n], sum[n]);
                    }
                }
            } else {
                // Begin again for the next interval; the other lanes are at their ends already.
                sum = sum.map(|sum| R::select(self.begun, R::splat(0.0), sum));
            }
            let to = &mut values[own(k - 1)];
            for n in 0..N {
                let mean = mean(std::array::from_fn(|power| parts[power][n]), k);
                to[n] = R::select(taken.accepted, terms[k].mul_add(mean, sum[n]), old[n]);
            }
        }
    }
}

/// Coefficients of the forces within a step.
const POWERS: usize = 4;

/// A polynomial of the fraction of a step, as one of the part of the way from `from` on over `span`.
#[inline(always)]
fn over<R: Number>([c0, c1, c2, c3]: [R; 4], from: R, span: R) -> [R; 4] {
    let (two, three) = (R::splat(2.0), R::splat(3.0));
    let value = from.mul_add(from.mul_add(from.mul_add(c3, c2), c1), c0);
    let slope = from.mul_add(from.mul_add(three * c3, two * c2), c1);
    let bend = from.mul_add(three * c3, c2);
    let square = span * span;
    [value, slope * span, bend * square, c3 * (square * span)]
}

/// `i! k! / (k + i)!` of the powers from 1 to 3, by `k`.
const WEIGHTS: [[f64; 3]; ORDER + 1] = {
    let mut weights = [[0.0; 3]; ORDER + 1];
    let mut k = 0;
    while k <= ORDER {
        let (mut weight, mut i) = (1.0, 1);
        while i <= 3 {
            weight *= i as f64 / (k + i) as f64;
            weights[k][i - 1] = weight;
            i += 1;
        }
        k += 1;
    }
    weights
};

/// The `k`-fold integral from 0 to 1 of a polynomial, times `k!`.
#[inline(always)]
fn mean<R: Number>([c0, c1, c2, c3]: [R; 4], k: usize) -> R {
    let [first, second, third] = WEIGHTS[k].map(R::splat);
    third.mul_add(c3, second.mul_add(c2, first.mul_add(c1, c0)))
}

/// `tau^k / k!` from 0 on.
#[inline(always)]
fn terms<R: Number>(tau: R) -> [R; ORDER + 1] {
    let mut terms = [R::splat(1.0); ORDER + 1];
    for k in 1..=ORDER {
        terms[k] = terms[k - 1] * (tau * R::splat(1.0 / k as f64));
    }
    terms
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::Dense;

    /// Nodes of Tsitouras' pair.
    const NODES: [f64; 7] = [0.0, 0.161, 0.327, 0.9, 0.980_025_540_904_509_7, 1.0, 1.0];

    /// Under a force that is a polynomial of the third degree the integrals are those of the closed form, whatever steps and nodes cut
    /// the time into.
    #[test]
    fn analytic_cubic_force() {
        let force = |t: f64| 3.0 - 2.0 * t + 5.0 * t * t - 4.0 * t * t * t;
        let (begin, end) = (0.15, 0.4);
        let derivatives = [force(begin), -2.0 + 10.0 * begin - 12.0 * begin * begin, 10.0 - 24.0 * begin, -24.0];
        let exact = |k: usize| -> f64 {
            let term = |i: usize| (end - begin).powi((k + i) as i32) / (1..=k + i).product::<usize>() as f64;
            derivatives.iter().enumerate().map(|(i, derivative)| derivative * term(i)).sum()
        };
        let mut moments = ForceIntegrals::<f64>::new(1, 0);
        (moments.orders, moments.next_s) = (ORDER, begin);
        let (mut seen, mut next) = (Vec::new(), [end, f64::INFINITY].into_iter());
        let mut t = 0.0;
        // The third step is cut at 0.7 of its length.
        for (h, theta) in [(0.1, 1.0), (0.03, 1.0), (0.2, 0.7), (0.25, 1.0)] {
            let rates = NODES.map(|node| force(t + node * h));
            moments.follow(&Taken { accepted: true, t, h, theta, rates: &rates, dense: Dense::Tsit5 }, |_, own| {
                seen.push(own.to_vec());
                next.next().unwrap()
            });
            t += theta * h;
        }
        assert_eq!(seen.len(), 2);
        for k in 1..=ORDER {
            let (found, exact) = (seen[1][k - 1], exact(k));
            assert!((found - exact).abs() < 1e-12 * exact.abs(), "order {k}: {found} and {exact}");
        }
    }
}

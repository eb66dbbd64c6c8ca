//! Location of a guard's upward zero on the dense output of a step.

use crate::integrate::step::{Polynomial, Step};
use crate::integrate::system::{GuardSample, Switching};
use decore_math::number::{Mask, Number};

/// Interior fraction from which the guards that have just switched are watched: at the switch itself their value is a
/// rounding error of either sign.
const INTERIOR: f64 = 1e-3;
/// Width of the final bracket as a fraction of the step.
const BRACKET: f64 = 1e-11;
/// Trials that interpolate: a simple zero takes five to eight. At others (a guard that starts like a Hertz force) the inverse
/// parabola closes in from one side and bisection, 37 trials, is faster.
const INTERPOLATED_TRIALS: usize = 10;
/// Trials after which the bracket is taken as it is.
const MOST_TRIALS: usize = 50;

/// Roots closer than this fraction of a step happen at the same instant.
const SAME_INSTANT: f64 = 1e-10;

/// State of one guard over a step.
struct Watch {
    /// Index of the guard.
    guard: usize,
    /// Value at the start of this step; unknown if it switched there.
    at_start: Option<f64>,
    /// Point at which it is positive.
    positive: Reading,
}

/// A function's value at a place.
#[derive(Debug, Clone, Copy)]
struct Reading {
    at: f64,
    value: f64,
}

/// Guards at both ends of a step in each lane.
pub(super) struct Ends<'a, R> {
    /// Length of the step, s.
    pub h: R,
    /// At the start.
    pub start: &'a [GuardSample<R>],
    /// At the end.
    pub end: &'a [GuardSample<R>],
}

impl<R: Number> Ends<'_, R> {
    /// Lanes in which a guard may be positive somewhere within the step: the others need no search.
    #[inline(always)]
    pub fn suspects(&self) -> R::Mask {
        let (none, third) = (R::splat(0.0), self.h * R::splat(1.0 / 3.0));
        let mut suspects = R::Mask::splat(false);
        for (start, end) in self.start.iter().zip(self.end) {
            let hump = start.smooth_rate.greater(none).and(end.smooth_rate.less(none));
            // A cubic stays below the largest of its four control points; both ends are negative.
            let rises = (start.smooth + third * start.smooth_rate).greater(none);
            let falls = (end.smooth - third * end.smooth_rate).greater(none);
            suspects = suspects.or(end.value.greater(none)).or(hump.and(rises.or(falls)));
        }
        suspects
    }
}

/// One lane of a step, and its guards that have just switched.
pub(super) struct SwitchedLane<'a, R> {
    /// The guards of all lanes.
    pub ends: &'a Ends<'a, R>,
    /// The lane.
    pub lane: usize,
    /// Guards that switched at the start.
    pub fresh: &'a [bool],
}

/// Scratch memory of a search for events.
pub(super) struct Memory<'m> {
    /// Receives the guards that cross zero at the first event; several if they cross at the same instant.
    pub hits: &'m mut Vec<usize>,
    /// Scratch of the state's length.
    pub y: &'m mut [f64],
}

/// Finds the first events of a lane's step, whose dense output is `step` (complete, not yet cut).
///
/// Returns the fraction of the step at which they are; 1 with no hits if there are none.
pub(super) fn first_events<S: Switching, R: Number>(
    system: &S,
    step: &Step<'_>,
    place: &SwitchedLane<'_, R>,
    Memory { hits, y }: Memory<'_>,
) -> f64 {
    hits.clear();
    let mut first = 1.0;
    for (guard, (start, end)) in place.ends.start.iter().zip(place.ends.end).enumerate() {
        let (start, end) = (start.lane(place.lane), end.lane(place.lane));
        // Strictly: a guard that rests at zero (bodies that just touch, without force or motion) must not switch for ever.
        let positive = if end.value > 0.0 {
            Reading { at: 1.0, value: end.value }
        } else {
            let Some(theta) = cubic_maximum(&start, &end, step.h) else { continue };
            let value = Along::new(system, step, guard, y).value(theta);
            if value <= 0.0 {
                continue;
            }
            Reading { at: theta, value }
        };
        let at_start = (!place.fresh[guard]).then_some(start.value);
        let theta = upward_zero(system, step, &Watch { guard, at_start, positive }, y);
        if hits.is_empty() || theta < first - SAME_INSTANT {
            hits.clear();
            hits.push(guard);
            first = theta;
        } else if theta <= first + SAME_INSTANT {
            hits.push(guard);
            first = first.max(theta);
        }
    }
    first
}

/// Finds a positive maximum of the cubic through a smooth function's values and rates at both ends of a step of length `h`.
fn cubic_maximum(start: &GuardSample, end: &GuardSample, h: f64) -> Option<f64> {
    let (f0, s0) = (start.smooth, start.smooth_rate * h);
    let (f1, s1) = (end.smooth, end.smooth_rate * h);
    if s0 <= 0.0 || s1 >= 0.0 {
        return None;
    }
    // f = f0 + s0 q + b q^2 + a q^3; its slope falls through zero between the ends.
    let a = 2.0 * (f0 - f1) + s0 + s1;
    let b = 3.0 * (f1 - f0) - 2.0 * s0 - s1;
    let discriminant = (b * b - 3.0 * a * s0).max(0.0).sqrt();
    // The form without cancellation of the root where the slope falls.
    let q = if b <= 0.0 { s0 / (discriminant - b) } else { -(b + discriminant) / (3.0 * a) };
    let value = f0 + q * (s0 + q * (b + q * a));
    (q > 0.0 && q < 1.0 && value > 0.0).then_some(q)
}

/// A guard along a step.
struct Along<'a, S> {
    system: &'a S,
    step: &'a Step<'a>,
    guard: usize,
    /// Sums; `None` for a guard that reads the state.
    sums: Option<[Polynomial; 2]>,
    /// Scratch of the state's length.
    y: &'a mut [f64],
}

impl<'a, S: Switching> Along<'a, S> {
    fn new(system: &'a S, step: &'a Step<'_>, guard: usize, y: &'a mut [f64]) -> Self {
        let sums = system.guard_sums(guard).map(|sums| sums.each_ref().map(|terms| step.polynomial(terms)));
        Self { system, step, guard, sums, y }
    }

    fn value(&mut self, theta: f64) -> f64 {
        if let Some(sums) = &self.sums {
            return self.system.guard_of(self.guard, sums.map(|sum| sum.at(theta)));
        }
        self.step.components(self.system.guard_support(self.guard), theta, self.y);
        self.system.guard(self.guard, self.step.time(theta), self.y)
    }
}

/// Fraction of the step at which the watched guard first reaches zero from below, on the non-negative side.
///
/// `y` is scratch of the state's length.
fn upward_zero<S: Switching>(system: &S, step: &Step<'_>, watch: &Watch, y: &mut [f64]) -> f64 {
    let mut guard = Along::new(system, step, watch.guard, y);
    let low = match watch.at_start {
        Some(value) => Reading { at: 0.0, value },
        None => {
            let at = INTERIOR.min(watch.positive.at);
            Reading { at, value: guard.value(at) }
        }
    };
    if low.value >= 0.0 { low.at } else { zero_between(low, watch.positive, |theta| guard.value(theta)) }
}

/// Zero of `value` between a place where it is negative and one where it is not, as the latter end of a bracket of width
/// [`BRACKET`]: inverse quadratic interpolation where three points allow it, bisection elsewhere (Chandrupatla 1997).
fn zero_between(negative: Reading, positive: Reading, mut value: impl FnMut(f64) -> f64) -> f64 {
    // The newest point, and the last one on the other side.
    let (mut newest, mut opposite) = (negative, positive);
    let mut part = newest.value / (newest.value - opposite.value);
    for trial in 0..MOST_TRIALS {
        let width = opposite.at - newest.at;
        let least = 0.5 * BRACKET / width.abs();
        if least > 0.5 || newest.value == 0.0 {
            break;
        }
        // Half a final bracket from either end at least: close to the zero, the next point lies beyond it. A NaN becomes
        // `least`.
        let theta = newest.at + part.max(least).min(1.0 - least) * width;
        let found = Reading { at: theta, value: value(theta) };
        let former = if (found.value >= 0.0) == (newest.value >= 0.0) {
            newest
        } else {
            std::mem::replace(&mut opposite, newest)
        };
        newest = found;
        part = if trial < INTERPOLATED_TRIALS { interpolated(newest, opposite, former) } else { None }.unwrap_or(0.5);
    }
    if newest.value >= 0.0 { newest.at } else { opposite.at }
}

/// Part of the way from `a` to `b` at which the inverse parabola through three points vanishes, where it is monotone.
fn interpolated(a: Reading, b: Reading, c: Reading) -> Option<f64> {
    let (Reading { at: a, value: at_a }, Reading { at: b, value: at_b }, Reading { at: c, value: at_c }) = (a, b, c);
    let (place, height) = ((a - b) / (c - b), (at_a - at_b) / (at_c - at_b));
    let monotone = height * height < place && (1.0 - height) * (1.0 - height) < 1.0 - place;
    monotone.then(|| {
        at_a / (at_b - at_a) * at_c / (at_b - at_c) + (c - a) / (b - a) * at_a / (at_c - at_a) * at_b / (at_c - at_b)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Over a step of length 0.1: value, slope per step, both twice.
    fn maximum([f0, s0, f1, s1]: [f64; 4]) -> Option<f64> {
        let sample = |smooth: f64, slope: f64| GuardSample { value: -1.0, smooth, smooth_rate: slope / 0.1 };
        cubic_maximum(&sample(f0, s0), &sample(f1, s1), 0.1)
    }

    /// Finds zeros to within the bracket from the non-negative side: simple zeros in few trials, all others (flat, as steep as a Hertz
    /// force, jumps, NaN) in little more than a bisection.
    #[test]
    fn analytic_zeros() {
        type Guard = fn(f64) -> f64;
        let guards: [(Guard, f64, usize); 8] = [
            (|x| x - 0.3, 0.3, 3),
            (|x| (x - 0.7) * (1.0 + x * (2.0 + x * x)), 0.7, 8),
            (|x| (50.0 * (x - 1e-4)).sinh(), 1e-4, 12),
            (|x| (x - 0.3).powi(3), 0.3, 47),
            (|x| (x - 0.3) * (x - 0.3).abs().powf(0.25), 0.3, 47),
            (|x| if x < 0.123 { -1e-3 } else { 1e3 }, 0.123, 47),
            (
                |x| {
                    if x < 0.1 {
                        -1.0
                    } else if x < 0.9 {
                        f64::NAN
                    } else {
                        1.0
                    }
                },
                0.9,
                MOST_TRIALS,
            ),
            (|x| if x < 0.2 { f64::NEG_INFINITY } else { f64::INFINITY }, 0.2, 47),
        ];
        for (case, (guard, zero, most)) in guards.into_iter().enumerate() {
            let mut trials = 0;
            let found =
                zero_between(Reading { at: 0.0, value: guard(0.0) }, Reading { at: 1.0, value: guard(1.0) }, |x| {
                    trials += 1;
                    guard(x)
                });
            assert!(found >= zero && found <= zero + BRACKET, "case {case}: {found}");
            assert!(trials <= most, "case {case}: {trials} trials");
        }
    }

    /// A cubic that rises at its start and falls at its end: the maximum found is the one that a fine sampling finds.
    #[test]
    fn analytic_cubic_maximum() {
        let mut found = 0;
        for i in 0..2000_u32 {
            // Values spread over the ranges by multiples of irrational numbers.
            let part = |step: f64| (f64::from(i) * step).fract();
            let [f0, s0, f1, s1] = [-part(0.618_034), 5.0 * part(0.414_214), -part(0.732_051), -5.0 * part(0.236_068)];
            let (a, b) = (2.0 * (f0 - f1) + s0 + s1, 3.0 * (f1 - f0) - 2.0 * s0 - s1);
            let cubic = |q: f64| f0 + q * (s0 + q * (b + q * a));
            let largest = (1..1000).map(|k| cubic(f64::from(k) / 1000.0)).fold(f64::NEG_INFINITY, f64::max);
            match maximum([f0, s0, f1, s1]) {
                Some(q) => {
                    found += 1;
                    assert!(q > 0.0 && q < 1.0 && cubic(q) > 0.0);
                    assert!(
                        cubic(q) >= largest - 1e-12 && cubic(q) < largest + 1e-5,
                        "{q}: {} and {largest}",
                        cubic(q)
                    );
                }
                None => assert!(largest <= 0.0, "missed {largest} of {:?}", [f0, s0, f1, s1]),
            }
        }
        assert!(found > 100, "{found}");
        assert_eq!(maximum([-1.0, 0.0, -1.0, -1.0]), None);
        assert_eq!(maximum([f64::NAN; 4]), None);
    }
}

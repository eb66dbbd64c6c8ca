//! Location of a guard's upward zero on the dense output of a step.

use crate::integrate::{GuardSample, Step, System};

/// Interior fraction from which the guards that have just switched are watched: at the switch itself their value is a
/// rounding error of either sign.
const INTERIOR: f64 = 1e-3;
/// Width of the final bracket as a fraction of the step.
const BRACKET: f64 = 1e-11;

/// Roots closer than this fraction of a step happen at the same instant.
const SAME_INSTANT: f64 = 1e-10;

/// What is known of one guard over a step.
struct Watch {
    /// Index of the guard.
    guard: usize,
    /// Whether it switched at the start of this step.
    fresh: bool,
    /// A fraction at which it is positive.
    positive_at: f64,
}

/// Guards at both ends of a step.
pub(super) struct Ends<'a> {
    /// At the start.
    pub start: &'a [GuardSample],
    /// At the end.
    pub end: &'a [GuardSample],
    /// Guards that switched at the start.
    pub fresh: &'a [bool],
}

/// Finds the first events of a step whose dense output is `step` (complete, not yet cut).
///
/// Fills `hits` with the guards that cross zero first, all those of the same instant, and returns the fraction of the
/// step at which they do; 1 with no hits if there are none. `y` is scratch of the state's length.
pub(super) fn first_events<S: System>(
    system: &S,
    step: &Step<'_>,
    ends: &Ends<'_>,
    (hits, y): (&mut Vec<usize>, &mut [f64]),
) -> f64 {
    hits.clear();
    let mut first = 1.0;
    for (guard, (start, end)) in ends.start.iter().zip(ends.end).enumerate() {
        // Strictly: a guard that rests at zero (bodies that just touch, without force or motion) must not switch for ever.
        let positive_at = if end.value > 0.0 {
            1.0
        } else {
            let Some(theta) = cubic_maximum(start, end, step.h) else { continue };
            step.components(system.guard_support(guard), theta, y);
            if system.guard(guard, step.time(theta), y) <= 0.0 {
                continue;
            }
            theta
        };
        let theta = upward_zero(system, step, &Watch { guard, fresh: ends.fresh[guard], positive_at }, y);
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

/// Where the cubic through a smooth function's values and rates at both ends of a step of length `h` has a positive
/// maximum in between.
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

/// Fraction of the step at which the watched guard first reaches zero from below, on the non-negative side.
///
/// `y` is scratch of the state's length.
fn upward_zero<S: System>(system: &S, step: &Step<'_>, watch: &Watch, y: &mut [f64]) -> f64 {
    let support = system.guard_support(watch.guard);
    let mut value = |theta: f64| {
        step.components(support, theta, y);
        system.guard(watch.guard, step.time(theta), y)
    };
    let mut low = if watch.fresh { INTERIOR.min(watch.positive_at) } else { 0.0 };
    let mut high = watch.positive_at;
    let mut at_low = value(low);
    if at_low >= 0.0 {
        return low;
    }
    let mut at_high = value(high);
    if at_high < 0.0 {
        return high;
    }
    // Interpolate-truncate-project (Oliveira and Takahashi 2020): superlinear, never slower than bisection.
    let half_iterations = ((high - low) / BRACKET).log2().ceil().max(0.0) as i32;
    let curvature = 0.2 / (high - low);
    for iteration in 0..=half_iterations {
        if high - low <= BRACKET {
            break;
        }
        let half = 0.5 * (low + high);
        let slack = 0.5 * BRACKET * 2f64.powi(half_iterations + 1 - iteration) - 0.5 * (high - low);
        let falsi = (at_high * low - at_low * high) / (at_high - at_low);
        let side = (half - falsi).signum();
        let shift = curvature * (high - low) * (high - low);
        let mut middle = if shift <= (half - falsi).abs() { falsi + side * shift } else { half };
        if (middle - half).abs() > slack {
            middle = half - side * slack;
        }
        let at_middle = value(middle);
        if at_middle >= 0.0 {
            high = middle;
            at_high = at_middle;
        } else {
            low = middle;
            at_low = at_middle;
        }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Over a step of length 0.1: value, slope per step, both twice.
    fn maximum([f0, s0, f1, s1]: [f64; 4]) -> Option<f64> {
        let sample = |smooth: f64, slope: f64| GuardSample { value: -1.0, smooth, smooth_rate: slope / 0.1 };
        cubic_maximum(&sample(f0, s0), &sample(f1, s1), 0.1)
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

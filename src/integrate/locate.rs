//! Location of a guard's upward zero on the dense output of a step.

use crate::integrate::{End, Step, System};

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

/// Finds the first events of a step whose dense output is `step` (complete, not yet cut).
///
/// Fills `hits` with the guards that cross zero first, all those of the same instant, and returns the fraction of the
/// step at which they do; 1 with no hits if there are none. `y` is scratch of the state's length.
pub(super) fn first_events<S: System>(
    system: &S,
    step: &Step<'_>,
    fresh: &[bool],
    hits: &mut Vec<usize>,
    y: &mut [f64],
) -> f64 {
    hits.clear();
    let mut first = 1.0;
    for (guard, &fresh) in fresh.iter().enumerate() {
        let Some(positive_at) = positive_fraction(system, step, guard, y) else {
            continue;
        };
        let watch = Watch { guard, fresh, positive_at };
        let theta = upward_zero(system, step, &watch, y);
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

/// A fraction of the step at which the guard is positive: its end, or an interior point that the system suspects.
fn positive_fraction<S: System>(system: &S, step: &Step<'_>, guard: usize, y: &mut [f64]) -> Option<f64> {
    // Strictly: a guard that rests at zero (bodies that just touch, without force or motion) must not switch for ever.
    if system.guard(guard, step.end()) > 0.0 {
        return Some(1.0);
    }
    let start = End { y: step.start(), rate: step.start_rate() };
    let end = End { y: step.end(), rate: step.end_rate() };
    let theta = system.suspect(guard, start, end, step.h)?;
    step.components(system.guard_support(guard), theta, y);
    (system.guard(guard, y) > 0.0).then_some(theta)
}

/// Fraction of the step at which the watched guard first reaches zero from below, on the non-negative side.
///
/// `y` is scratch of the state's length.
fn upward_zero<S: System>(system: &S, step: &Step<'_>, watch: &Watch, y: &mut [f64]) -> f64 {
    let support = system.guard_support(watch.guard);
    let mut value = |theta: f64| {
        step.components(support, theta, y);
        system.guard(watch.guard, y)
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

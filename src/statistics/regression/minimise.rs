//! Minima of smooth functions of a few parameters.

use std::collections::VecDeque;

/// Steps that curvature is learned from.
const MEMORY: usize = 8;
/// Largest change of a parameter in a step.
const LONGEST: f64 = 2.0;
/// Halvings of a step before the search ends.
const MOST_HALVINGS: usize = 12;
/// Share of the slope that a step must bring (Armijo).
const SUFFICIENT: f64 = 1e-4;

/// A value and its gradient.
pub(super) type Sloped = (f64, Vec<f64>);

/// When to stop.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stop {
    /// Steps at most.
    pub steps: usize,
    /// The value has to fall by more than this in one of two steps.
    pub gain: f64,
}

/// End of a search.
#[derive(Debug, Clone)]
pub(super) struct Minimum {
    /// The parameters.
    pub at: Vec<f64>,
    /// The value there.
    pub value: f64,
}

/// L-BFGS with halved steps (Nocedal and Wright, *Numerical Optimization*, 2006, algorithms 7.4 and 3.1) from `start`; `None` where
/// the function has no value there. A function that has no value somewhere is infinite there.
pub(super) fn minimise(
    start: Vec<f64>,
    stop: Stop,
    function: &mut dyn FnMut(&[f64]) -> Option<Sloped>,
) -> Option<Minimum> {
    let (mut value, mut slope) = function(&start)?;
    let mut at = start;
    let mut memory: VecDeque<[Vec<f64>; 2]> = VecDeque::new();
    let mut idle = 0;
    for _ in 0..stop.steps {
        let mut direction = descent(&slope, &memory);
        if dot(&direction, &slope) >= 0.0 {
            memory.clear();
            direction = descent(&slope, &memory);
        }
        let longest = direction.iter().fold(0.0, |longest: f64, part| longest.max(part.abs()));
        if longest == 0.0 {
            break;
        }
        // Without a known curvature, the slope gives no length: use a moderate one.
        let first = if memory.is_empty() { 0.5 / longest } else { (LONGEST / longest).min(1.0) };
        let along = dot(&direction, &slope);
        let step = (0..MOST_HALVINGS).find_map(|halving| {
            let length = first * 0.5f64.powi(halving as i32);
            let there: Vec<f64> = at.iter().zip(&direction).map(|(at, part)| at + length * part).collect();
            let (found, gradient) = function(&there)?;
            (found <= value + SUFFICIENT * length * along).then_some((there, found, gradient))
        });
        let Some((there, found, gradient)) = step else { break };
        let moved = difference(&there, &at);
        let turned = difference(&gradient, &slope);
        if dot(&moved, &turned) > 1e-10 * dot(&turned, &turned) {
            memory.push_back([moved, turned]);
            if memory.len() > MEMORY {
                memory.pop_front();
            }
        }
        idle = if value - found > stop.gain { 0 } else { idle + 1 };
        (at, value, slope) = (there, found, gradient);
        if idle == 2 {
            break;
        }
    }
    Some(Minimum { at, value })
}

/// The direction of descent: the inverse of the curvature that the steps showed, times the slope.
fn descent(slope: &[f64], memory: &VecDeque<[Vec<f64>; 2]>) -> Vec<f64> {
    let mut direction: Vec<f64> = slope.iter().map(|part| -part).collect();
    let mut shares = Vec::new();
    for [moved, turned] in memory.iter().rev() {
        let share = dot(moved, &direction) / dot(moved, turned);
        add(&mut direction, -share, turned);
        shares.push(share);
    }
    if let Some([moved, turned]) = memory.back() {
        let scale = dot(moved, turned) / dot(turned, turned);
        direction.iter_mut().for_each(|part| *part *= scale);
    }
    for ([moved, turned], share) in memory.iter().zip(shares.iter().rev()) {
        let back = dot(turned, &direction) / dot(moved, turned);
        add(&mut direction, share - back, moved);
    }
    direction
}

/// Sum of products.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn add(to: &mut [f64], times: f64, of: &[f64]) {
    to.iter_mut().zip(of).for_each(|(to, of)| *to += times * of);
}

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_valley_of_rosenbrock_ends_at_one_one() {
        let mut rosenbrock = |x: &[f64]| {
            let (a, b) = (1.0 - x[0], x[1] - x[0] * x[0]);
            Some((a * a + 100.0 * b * b, vec![-2.0 * a - 400.0 * x[0] * b, 200.0 * b]))
        };
        let found = minimise(vec![-1.2, 1.0], Stop { steps: 200, gain: 1e-14 }, &mut rosenbrock).expect("a value");
        assert!(found.at.iter().all(|x| (x - 1.0).abs() < 1e-6), "{found:?}");
    }

    #[test]
    fn a_function_may_have_no_value_on_the_way() {
        let mut logarithm = |x: &[f64]| (x[0] > 0.0).then(|| (x[0] - x[0].ln(), vec![1.0 - 1.0 / x[0]]));
        let found = minimise(vec![3.0], Stop { steps: 100, gain: 1e-14 }, &mut logarithm).expect("a value");
        assert!((found.at[0] - 1.0).abs() < 1e-6, "{found:?}");
        assert!(minimise(vec![-1.0], Stop { steps: 100, gain: 0.0 }, &mut logarithm).is_none());
    }
}

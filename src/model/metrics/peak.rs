//! Largest absolute value of a quantity within a step, read off the method's own dense output.

use crate::integrate::Step;

/// Most refinements of a peak's place, each with a parabola through the best three points.
const REFINEMENTS: usize = 8;
/// Fraction of a step to which a peak is located; its error enters the peak squared.
const RESOLUTION: f64 = 1e-5;
/// Parts into which a step is cut to bracket its peak; a step spans less than half a period of any contact.
const PARTS: usize = 4;

/// Where a quantity is read within a step.
pub(super) struct Probe<'a> {
    /// Components of the state that it reads.
    pub support: &'a [usize],
    /// Of the state's length.
    pub scratch: &'a mut [f64],
}

/// Practical bound of the absolute value that a sum of components with coefficients, less `offset`, takes within a step.
pub(super) fn reach(step: &Step<'_>, terms: impl Iterator<Item = (usize, f64)> + Clone, offset: f64) -> f64 {
    let start = terms.clone().map(|(index, c)| c * step.start(index)).sum::<f64>() - offset;
    start.abs() + step.h * step.largest_rate(terms)
}

/// Components with their coefficients, one by one.
pub(super) fn terms(sum: &[(usize, f64)]) -> impl Iterator<Item = (usize, f64)> + Clone {
    sum.iter().copied()
}

/// Largest absolute value of `quantity`, a function of time and state, between the start of the step and `theta_end`, and the fraction where it is.
pub(super) fn peak(
    step: &Step<'_>,
    theta_end: f64,
    Probe { support, scratch }: Probe<'_>,
    mut quantity: impl FnMut(f64, &[f64]) -> f64,
) -> (f64, f64) {
    let mut at = |theta: f64| {
        step.components(support, theta, scratch);
        quantity(step.time(theta), scratch).abs()
    };
    let spacing = theta_end / PARTS as f64;
    let mut samples = [0.0; PARTS + 1];
    for (i, sample) in samples.iter_mut().enumerate() {
        *sample = at(i as f64 * spacing);
    }
    let best = (0..=PARTS).fold(0, |best, i| if samples[i] > samples[best] { i } else { best });
    let sample = |i: usize| (i as f64 * spacing, samples[i]);
    let middle = best.clamp(1, PARTS - 1);
    let mut bracket = [sample(middle - 1), sample(middle), sample(middle + 1)];
    if best != middle {
        // The highest sample is an end of the step: its peak may still lie between that end and the next sample.
        let theta = vertex(&bracket);
        let (low, high) = if best == 0 { (sample(0), sample(1)) } else { (sample(PARTS - 1), sample(PARTS)) };
        let inside = theta > low.0 && theta < high.0;
        let found = (theta, if inside { at(theta) } else { 0.0 });
        if found.1 <= samples[best] {
            return (samples[best], sample(best).0);
        }
        bracket = [low, found, high];
    }
    for _ in 0..REFINEMENTS {
        let theta = vertex(&bracket);
        if (theta - bracket[1].0).abs() < RESOLUTION {
            break;
        }
        bracket = narrower(bracket, (theta, at(theta)));
    }
    (bracket[1].1, bracket[1].0)
}

/// Where the parabola through three points (fraction, value) has its vertex; the middle point if they are not concave.
fn vertex(&[(x0, y0), (x1, y1), (x2, y2)]: &[(f64, f64); 3]) -> f64 {
    let (left, right) = ((y1 - y0) / (x1 - x0), (y1 - y2) / (x2 - x1));
    // The slope falls linearly from `left` in the middle of the first half to `-right` in that of the second.
    if left + right > 0.0 { 0.5 * ((x0 + x1) * right + (x1 + x2) * left) / (left + right) } else { x1 }
}

/// The bracket of the highest of four points, of which `found` lies within the old bracket.
fn narrower([left, middle, right]: [(f64, f64); 3], found: (f64, f64)) -> [(f64, f64); 3] {
    match (found.0 > middle.0, found.1 > middle.1) {
        (true, true) => [middle, found, right],
        (true, false) => [left, middle, found],
        (false, true) => [left, found, middle],
        (false, false) => [found, middle, right],
    }
}

#[cfg(test)]
mod tests {
    use super::{narrower, vertex};

    /// The vertex of a parabola through any three of its points; refinement on a sine finds its top.
    #[test]
    fn analytic_vertex_and_refinement() {
        let parabola = |x: f64| 3.0 - 2.0 * (x - 0.37) * (x - 0.37);
        let points = [0.1, 0.3, 0.9].map(|x| (x, parabola(x)));
        assert!((vertex(&points) - 0.37).abs() < 1e-14);
        assert_eq!(vertex(&[(0.0, 1.0), (0.5, 1.0), (1.0, 1.0)]), 0.5);
        let lopsided = |x: f64| (3.0 * x).sin() * (-2.0 * x).exp();
        let mut bracket = [0.0, 0.25, 0.5].map(|x| (x, lopsided(x)));
        for _ in 0..8 {
            let x = vertex(&bracket);
            bracket = narrower(bracket, (x, lopsided(x)));
        }
        // Its slope vanishes where tan(3 x) = 3/2.
        assert!((bracket[1].0 - 1.5f64.atan() / 3.0).abs() < 1e-5, "{}", bracket[1].0);
    }
}

//! Largest absolute value of a quantity within a step, read off the method's own dense output.

use crate::integrate::Step;

/// Parts into which a step is cut to bracket its peak; a step spans less than half a period of any contact.
const PARTS: usize = 4;

/// Largest absolute value of `quantity`, a function of time and state, between the start of the step and `theta_end`, and the fraction where it is.
///
/// `support` lists the components that `quantity` reads; `y` is scratch of the state's length.
pub(super) fn peak(
    step: &Step<'_>,
    theta_end: f64,
    (support, y): (&[usize], &mut [f64]),
    quantity: impl Fn(f64, &[f64]) -> f64,
) -> (f64, f64) {
    let mut at = |theta: f64| {
        step.components(support, theta, y);
        quantity(step.time(theta), y).abs()
    };
    let spacing = theta_end / PARTS as f64;
    let mut samples = [0.0; PARTS + 1];
    for (i, sample) in samples.iter_mut().enumerate() {
        *sample = at(i as f64 * spacing);
    }
    let best = (0..=PARTS).fold(0, |best, i| if samples[i] > samples[best] { i } else { best });
    let mut peak = (samples[best], best as f64 * spacing);
    if best > 0 && best < PARTS {
        // The vertex of the parabola through the best three; its error enters the peak squared.
        let (left, right) = (samples[best] - samples[best - 1], samples[best] - samples[best + 1]);
        let theta = (best as f64 + 0.5 * (left - right) / (left + right)) * spacing;
        let value = at(theta);
        if value > peak.0 {
            peak = (value, theta);
        }
    }
    peak
}

//! Resonances in a set of frequency responses.

/// A resonance stands out of its surroundings by this factor in power.
const PROMINENCE: f64 = 2.0;
/// A resonance is fitted where the power is above this share of its own.
const SHARE: f64 = 0.2;
/// Fewest points of a fit.
const LEAST: usize = 7;

/// A resonance: the index of its top and the range of points around it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Peak {
    pub top: usize,
    pub range: std::ops::Range<usize>,
}

/// Resonances of a power spectrum.
pub(super) fn peaks(power: &[f64]) -> Vec<Peak> {
    let mut out = Vec::new();
    for top in 1..power.len().saturating_sub(1) {
        let value = power[top];
        if !(value > power[top - 1] && value >= power[top + 1]) {
            continue;
        }
        // Down to the lowest point before a higher one, on either side.
        let lowest = |side: &mut dyn Iterator<Item = usize>| {
            side.map(|at| power[at]).take_while(|other| *other <= value).fold(value, f64::min)
        };
        let (left, right) = (lowest(&mut (0..top).rev()), lowest(&mut (top + 1..power.len())));
        if value < PROMINENCE * left.max(right) {
            continue;
        }
        let falls = |from: usize, to: usize| power[to] > SHARE * value && power[to] <= power[from];
        let (mut begin, mut end) = (top, top + 1);
        while begin > 0 && (falls(begin, begin - 1) || top - begin < LEAST.div_ceil(2)) {
            begin -= 1;
        }
        while end < power.len() && (falls(end - 1, end) || end - top <= LEAST.div_ceil(2)) {
            end += 1;
        }
        out.push(Peak { top, range: begin..end });
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resonances_stand_out_and_ripples_do_not() {
        let at = |x: f64, centre: f64| 1.0 / (1.0 + (x - centre).powi(2));
        let power: Vec<f64> =
            (0..200).map(f64::from).map(|x| at(x, 50.0) + 0.5 * at(x, 120.0) + 1e-3 * libm::sin(x)).collect();
        let found = peaks(&power);
        assert_eq!(found.iter().map(|peak| peak.top).filter(|top| power[*top] > 0.1).collect::<Vec<_>>(), [50, 120]);
        assert!(found[0].range.len() >= LEAST);
        assert!(peaks(&[]).is_empty() && peaks(&[1.0, 2.0]).is_empty());
    }
}

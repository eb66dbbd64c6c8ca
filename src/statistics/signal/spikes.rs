//! Lost samples: a vibrometer that loses its laser's reflection gives one value far from its neighbours.

/// Samples on each side that a sample is held against.
const NEIGHBOURS: usize = 3;
/// Ranges of its neighbours by which a spike stands out of them.
const RANGES: f64 = 3.0;
/// Robust standard deviations of such distances over the whole signal by which a spike stands out.
const DEVIATIONS: f64 = 8.0;
/// Standard deviations in a normal variable's median absolute deviation.
const NORMAL: f64 = 1.4826;

/// Places of single-sample spikes: samples whose distance from the median of the three samples on each side is more than three
/// times the range of those six, and more than eight times the robust standard deviation (1.4826 times the median) of such
/// distances over the signal. A range counts as no less than the signal's resolution, its smallest step from one sample to the next: a
/// quantised signal flickers by that where it rests. A step or an impact that takes several samples is none: its neighbours differ
/// themselves, and
/// beside it a spike has to be as much higher to be found. Nothing is changed.
pub fn spikes(values: &[f64]) -> Vec<usize> {
    let found: Vec<(f64, f64)> = values.windows(2 * NEIGHBOURS + 1).map(distance).collect();
    let mut distances: Vec<f64> = found.iter().map(|(distance, _)| *distance).collect();
    let deviation = NORMAL * median(&mut distances);
    let steps = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|step| *step > 0.0);
    let resolution = steps.reduce(f64::min).unwrap_or(0.0);
    let is_spike = |(distance, range): &(f64, f64)| {
        *distance > RANGES * range.max(resolution) && *distance > DEVIATIONS * deviation
    };
    found.iter().enumerate().filter(|(_, found)| is_spike(found)).map(|(place, _)| place + NEIGHBOURS).collect()
}

/// Distance of the middle sample from the median of the others, and their range.
fn distance(window: &[f64]) -> (f64, f64) {
    let mut others = [&window[..NEIGHBOURS], &window[NEIGHBOURS + 1..]].concat();
    let middle = median(&mut others);
    let (low, high) = (others.first().copied().unwrap_or(0.0), others.last().copied().unwrap_or(0.0));
    ((window[NEIGHBOURS] - middle).abs(), high - low)
}

/// The median; the values are in order afterwards. Of none 0.
fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    let half = values.len() / 2;
    match (values.get(half.wrapping_sub(1)), values.get(half)) {
        (Some(low), Some(high)) if values.len().is_multiple_of(2) => 0.5 * (low + high),
        (_, Some(middle)) => *middle,
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::spikes;

    /// Noise of a fixed sequence, between -0.5 and 0.5.
    fn noise(k: usize) -> f64 {
        ((k as f64 * 12.9898).sin() * 43_758.545_3).rem_euclid(1.0) - 0.5
    }

    #[test]
    fn spikes_are_marked_and_impacts_are_not() {
        let mut values: Vec<f64> = (0..4000).map(|k| (k as f64 * 0.01).sin() + 0.01 * noise(k)).collect();
        // A step, and an impact that rings down.
        (1500..4000).for_each(|k| values[k] += 4.0);
        (3000..3200).for_each(|k| values[k] += 6.0 * (-(k as f64 - 3000.0) / 40.0).exp());
        assert_eq!(spikes(&values), [0_usize; 0]);
        // Two samples after the step of 4 one of 3 is not told from it, one of 14 is.
        for (place, height) in [(700, 2.0), (1502, -3.0), (2500, -1.0), (3050, 5.0)] {
            values[place] += height;
        }
        assert_eq!(spikes(&values), [700, 2500, 3050]);
        values[1502] -= 11.0;
        assert_eq!(spikes(&values), [700, 1502, 2500, 3050]);
        // A force with a resolution of 20 N that rests, and flickers by one step; only what is more than three steps away stands out.
        let mut force: Vec<f64> = (0..4000).map(|k| if k % 40 == 7 { 20.0 } else { 0.0 }).collect();
        assert_eq!(spikes(&force), [0_usize; 0]);
        (force[500], force[900]) = (60.0, 80.0);
        assert_eq!(spikes(&force), [900]);
        assert_eq!(spikes(&[1.0, 2.0]), [0_usize; 0]);
        assert_eq!(spikes(&vec![2.5; 50]), [0_usize; 0]);
    }
}

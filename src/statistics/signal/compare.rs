//! Figures that compare a calculated with a measured signal.

/// Difference of a calculated value from a measured one, relative to it: `(calculated - measured) / measured`, as the paper's
/// differences of RMS values (page 1221: 0.0254 to 0.0137 are 85 %) and velocities are taken.
pub fn relative_difference(calculated: f64, measured: f64) -> f64 {
    (calculated - measured) / measured
}

/// Root mean square: `sqrt(sum x^2 / n)`, the mean included; of no values 0.
pub fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// Largest absolute value; of no values 0.
pub fn peak(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |peak, value| value.abs().max(peak))
}

/// Frequency in Hz of the highest of the lines of a spectrum, the mean (the first) left out; `None` if there is none.
pub fn dominant_frequency_hz(lines: &[f64], resolution_hz: f64) -> Option<f64> {
    let highest = lines.iter().enumerate().skip(1).max_by(|(_, a), (_, b)| a.total_cmp(b))?;
    (*highest.1 > 0.0).then_some(highest.0 as f64 * resolution_hz)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_own_differences() {
        // Page 1221: RMS values of the hammering phase, and page 1223: "a higher deviation of 85 %".
        assert!((100.0 * relative_difference(0.0254, 0.0137) - 85.4).abs() < 0.05);
        assert_eq!((rms(&[3.0, -4.0]), peak(&[3.0, -4.0])), (12.5_f64.sqrt(), 4.0));
        assert_eq!(dominant_frequency_hz(&[9.0, 1.0, 3.0, 2.0], 0.5), Some(1.0));
        assert_eq!(dominant_frequency_hz(&[9.0], 0.5), None);
    }
}

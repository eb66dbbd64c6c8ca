//! Frequency and damping of a resonance, fitted to all responses at once.
//!
//! Near a resonance `H (omega_r^2 - omega^2 + 2 j xi omega_r omega) = e_0 + e_1 x + e_2 x^2`, with `x` the distance from its top: linear in
//! `a_0 = omega_r^2`, `a_1 = 2 xi omega_r` (real, common to all responses) and the complex e (one set per response). Weights
//! `1 / |omega_r^2 - omega^2 + j a_1 omega|` of the last solution make it a fit of H itself (Sanathanan and Koerner 1963).

/// Refinements of the weights.
const ROUNDS: usize = 8;

/// A response around a resonance.
pub(super) struct Near {
    /// Circular frequencies in rad/s.
    pub omega: Vec<f64>,
    /// Displacement per force.
    pub receptance: Vec<[f64; 2]>,
}

/// Circular frequency in rad/s and damping ratio; `None` if the responses show no resonance.
pub(super) fn fit(responses: &[Near], omega_top: f64) -> Option<(f64, f64)> {
    let (mut offset, mut rate) = (0.0, None::<f64>);
    for _ in 0..ROUNDS {
        let mut normal = [[0.0; 2]; 2];
        let mut right = [0.0; 2];
        for response in responses {
            accumulate(response, omega_top, (offset, rate), &mut (&mut normal, &mut right));
        }
        let determinant = normal[0][0] * normal[1][1] - normal[0][1] * normal[1][0];
        if !(determinant.is_finite() && determinant > 0.0) {
            return None;
        }
        offset = (right[0] * normal[1][1] - right[1] * normal[0][1]) / determinant * omega_top * omega_top;
        rate = Some((normal[0][0] * right[1] - normal[1][0] * right[0]) / determinant * omega_top);
    }
    let omega_r = (omega_top * omega_top + offset).sqrt();
    let ratio = rate? / (2.0 * omega_r);
    (omega_r.is_finite() && ratio.is_finite() && ratio > 0.0 && ratio < 1.0).then_some((omega_r, ratio))
}

/// Adds a response to the normal equations of `offset / omega_top^2` and `rate / omega_top`.
fn accumulate(
    response: &Near,
    omega_top: f64,
    (offset, rate): (f64, Option<f64>),
    (normal, right): &mut (&mut [[f64; 2]; 2], &mut [f64; 2]),
) {
    let square = omega_top * omega_top;
    let scale = response.receptance.iter().map(|[re, im]| libm::hypot(*re, *im)).fold(0.0, f64::max);
    if scale <= 0.0 {
        return;
    }
    let weight = |omega: f64| match rate {
        None => 1.0,
        Some(rate) => square / libm::hypot(square + offset - omega * omega, rate * omega).max(1e-12 * square),
    };
    let weights: Vec<f64> = response.omega.iter().map(|omega| weight(*omega)).collect();
    let basis = basis(&response.omega, &weights, omega_top);
    // Real and imaginary part of the columns `H`, `j omega H / omega_top` and of `(omega^2 - omega_top^2) H / omega_top^2`.
    let column = |value: &dyn Fn(f64, [f64; 2]) -> [f64; 2]| -> [Vec<f64>; 2] {
        let values: Vec<[f64; 2]> = (response.omega.iter().zip(&response.receptance).zip(&weights))
            .map(|((omega, h), weight)| value(*omega, h.map(|part| part / scale)).map(|part| part * weight))
            .collect();
        [0, 1].map(|part| without(&basis, values.iter().map(|value| value[part]).collect()))
    };
    let stiff = column(&|_, h| h);
    let damped = column(&|omega, [re, im]| [-im * omega / omega_top, re * omega / omega_top]);
    let target = column(&|omega, h| h.map(|part| part * (omega * omega - square) / square));
    let product = |a: &[Vec<f64>; 2], b: &[Vec<f64>; 2]| -> f64 {
        a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| a * b).sum()
    };
    let columns = [&stiff, &damped];
    for i in 0..2 {
        for j in 0..2 {
            normal[i][j] += product(columns[i], columns[j]);
        }
        right[i] += product(columns[i], &target);
    }
}

/// Orthonormal weighted powers 1, x, x^2.
fn basis(omega: &[f64], weights: &[f64], omega_top: f64) -> Vec<Vec<f64>> {
    let span = omega.iter().map(|omega| (omega - omega_top).abs()).fold(f64::MIN_POSITIVE, f64::max);
    let mut out: Vec<Vec<f64>> = Vec::new();
    for power in 0..3 {
        let values = omega.iter().zip(weights).map(|(omega, weight)| weight * ((omega - omega_top) / span).powi(power));
        let mut column = without(&out, values.collect());
        column = without(&out, column);
        let norm = column.iter().map(|value| value * value).sum::<f64>().sqrt();
        if norm > 0.0 {
            column.iter_mut().for_each(|value| *value /= norm);
            out.push(column);
        }
    }
    out
}

/// A column without its components along a basis.
fn without(basis: &[Vec<f64>], mut column: Vec<f64>) -> Vec<f64> {
    for known in basis {
        let along: f64 = known.iter().zip(&column).map(|(a, b)| a * b).sum();
        column.iter_mut().zip(known).for_each(|(value, known)| *value -= along * known);
    }
    column
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_resonance_on_the_flank_of_others_is_found() {
        let modes = [(300.0, 0.02, 1.0), (340.0, 0.01, -0.3), (900.0, 0.02, 5.0)];
        let omega: Vec<f64> = (0..25).map(|i| 330.0 + f64::from(i) * 0.8).collect();
        let h = |omega: &f64| {
            let term = |(own, ratio, residue): &(f64, f64, f64)| {
                let (re, im) = (own * own - omega * omega, 2.0 * ratio * own * omega);
                let square = re * re + im * im;
                [residue * re / square, -residue * im / square]
            };
            modes.iter().map(term).fold([0.0; 2], |[re, im], [a, b]| [re + a, im + b])
        };
        let receptance = omega.iter().map(h).collect();
        let (found, ratio) = fit(&[Near { omega, receptance }], 339.6).expect("a resonance");
        assert!((found / 340.0 - 1.0).abs() < 5e-4 && (ratio / 0.01 - 1.0).abs() < 1e-2, "{found} {ratio}");
    }
}

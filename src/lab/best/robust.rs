//! Averages and quantiles over uncertain factors, on plain numbers.
//!
//! An output at a decision is known at equally likely draws of the uncertain factors (nodes). At each node it is normal: the error of the
//! model makes its mean uncertain, and runs scatter around it. Averages use the mean; limits use the unfavourable side of the model's
//! error.

use crate::refinement::Side;
use decore_math::special::normal_cdf;

/// An output at one node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Predicted {
    /// Expected value.
    pub mean: f64,
    /// Standard deviation of the model's error.
    pub model: f64,
    /// Standard deviation of a run about its expected value.
    pub scatter: f64,
}

/// A limit of an output.
#[derive(Debug, Clone, Copy)]
pub struct Bounded<'a> {
    /// The output at each node.
    pub at: &'a [Predicted],
    /// Whether it must be small or large.
    pub side: Side,
    /// The limit.
    pub value: f64,
}

/// Expected value of an output over the nodes: of `(x + e)^2` with `e` of mean 0 and standard deviation `s`, `x^2 + s^2`.
pub fn expected(at: &[Predicted]) -> f64 {
    at.iter().map(|node| node.mean).sum::<f64>() / at.len().max(1) as f64
}

/// Standard deviation of the model's error of [`expected`], at most: errors of all nodes go the same way.
pub fn expected_error(at: &[Predicted]) -> f64 {
    at.iter().map(|node| node.model).sum::<f64>() / at.len().max(1) as f64
}

/// Share of runs that succeed and hold all limits: the mean over the nodes of `success * product Phi((limit - mean - caution * model) /
/// scatter)`. `caution`: standard deviations by which the model is taken to err to the bad side, negative for the good side.
pub fn held(limits: &[Bounded<'_>], success: &[f64], caution: f64) -> f64 {
    let at = |node: usize| {
        limits.iter().map(|limit| within(limit.at[node], (limit.side, limit.value), caution)).product::<f64>()
    };
    let sum: f64 = success.iter().enumerate().map(|(node, success)| success * at(node)).sum();
    sum / success.len().max(1) as f64
}

/// Probability that a run at a node is within a limit.
fn within(at: Predicted, (side, value): (Side, f64), caution: f64) -> f64 {
    let off = match side {
        Side::Least => value - at.mean,
        Side::Most => at.mean - value,
    } - caution * at.model;
    match at.scatter > 0.0 {
        true => normal_cdf(off / at.scatter),
        false => f64::from(u8::from(off >= 0.0)),
    }
}

/// The least limit that a share of runs hold (`Side::Most`: the largest): of one node without model error, `mean + 1.645 scatter` for 0.95.
/// By bisection, to 1e-9 of the width between the nodes' values.
pub fn quantile(at: &[Predicted], side: Side, (share, caution): (f64, f64)) -> f64 {
    let reach = |node: &Predicted| caution.abs() * node.model + 9.0 * node.scatter;
    let mut low = at.iter().map(|node| node.mean - reach(node)).fold(f64::INFINITY, f64::min);
    let mut high = at.iter().map(|node| node.mean + reach(node)).fold(f64::NEG_INFINITY, f64::max);
    let success = vec![1.0; at.len()];
    let holds = |value: f64| held(&[Bounded { at, side, value }], &success, caution) >= share;
    let least = 1e-9 * (high - low).max(f64::MIN_POSITIVE);
    while high - low > least {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        match (holds(middle), side) {
            (true, Side::Least) | (false, Side::Most) => high = middle,
            (false, Side::Least) | (true, Side::Most) => low = middle,
        }
    }
    match side {
        Side::Least => high,
        Side::Most => low,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use decore_math::special::normal_quantile;

    fn known(mean: f64, scatter: f64) -> Predicted {
        Predicted { mean, model: 0.0, scatter }
    }

    /// Middles of strata of a normal distribution.
    fn normal(count: usize) -> impl Iterator<Item = f64> {
        (0..count).map(move |node| normal_quantile((node as f64 + 0.5) / count as f64))
    }

    #[test]
    fn a_normal_output_has_its_normal_quantile() {
        let z = 1.644_853_626_951_472_7;
        let noisy = [known(3.0, 0.5)];
        assert!((quantile(&noisy, Side::Least, (0.95, 0.0)) - (3.0 + 0.5 * z)).abs() < 1e-7);
        assert!((quantile(&noisy, Side::Most, (0.95, 0.0)) - (3.0 - 0.5 * z)).abs() < 1e-7);
        // The same from a factor in place of scatter, in strata.
        let spread: Vec<Predicted> = normal(4000).map(|e| known(3.0 + 0.5 * e, 0.0)).collect();
        assert!((quantile(&spread, Side::Most, (0.95, 0.0)) - (3.0 - 0.5 * z)).abs() < 1e-3);
        // Scatter and factor together add their squares.
        let both: Vec<Predicted> = normal(4000).map(|e| known(3.0 + 0.3 * e, 0.4)).collect();
        assert!((quantile(&both, Side::Most, (0.95, 0.0)) - (3.0 - 0.5 * z)).abs() < 1e-3);
        // The model's error is taken as a whole.
        let unsure = [Predicted { mean: 3.0, model: 0.2, scatter: 0.5 }];
        assert!((quantile(&unsure, Side::Least, (0.95, 1.5)) - (3.0 + 0.5 * z + 0.3)).abs() < 1e-7);
    }

    #[test]
    fn a_square_gains_the_variance() {
        let (x, s) = (1.5, 0.7);
        let squares: Vec<Predicted> = normal(4000).map(|e| known((x + s * e).powi(2), 0.0)).collect();
        assert!((expected(&squares) - (x * x + s * s)).abs() < 1e-3);
    }

    #[test]
    fn a_noisy_limit_is_held_up_to_its_margin() {
        // x <= 2 with scatter 0.1 is held in 95 % up to x = 2 - 0.1645.
        let share = |x: f64| held(&[Bounded { at: &[known(x, 0.1)], side: Side::Least, value: 2.0 }], &[1.0], 0.0);
        assert!((share(2.0 - 0.164_485_362_695) - 0.95).abs() < 1e-9);
        assert!(share(1.8) > 0.95 && share(1.9) < 0.95);
        // Runs that fail hold no limit.
        let failing = held(&[Bounded { at: &[known(0.0, 0.1)], side: Side::Least, value: 2.0 }], &[0.9], 0.0);
        assert!((failing - 0.9).abs() < 1e-12);
    }
}

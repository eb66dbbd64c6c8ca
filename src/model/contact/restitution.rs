//! Closed forms between the damping of a contact law and its coefficient of restitution, and their inverses.
//!
//! Two bodies of reduced mass `mu` collide freely; `e` is the speed at which they part over the speed at which they meet. Damping is
//! dimensionless: the ratio `z = c / (2 sqrt(k mu))` for the linear laws, the product `a v0` with the closing speed `v0` for
//! Hunt-Crossley. All forms fall monotonically from 1 without damping towards 0.

use std::f64::consts::PI;

use libm::{acos, acosh, exp, expm1, hypot, log, log1p};

/// Halvings that bring any bracket down to neighbouring numbers.
const HALVINGS: usize = 200;

/// Kelvin-Voigt without tension: `e = exp(-2 z acos(z) / sqrt(1 - z^2))`, continued beyond `z = 1` (Schwager and
/// Poeschel 2007). Also that of Hertz with damping `C d^(1/4) d'`, with `z = C / sqrt(5 mu K)`: in the coordinate
/// `d^(5/4)` and the time `dtau = d^(1/4) dt` its motion is the linear one (Antypov and Elliott 2011).
pub fn kelvin_voigt(damping_ratio: f64) -> f64 {
    exp(-loss(damping_ratio))
}

/// Damping ratio at which [`kelvin_voigt`] gives `e`, for `0 < e <= 1`.
pub fn kelvin_voigt_damping(e: f64) -> f64 {
    // `loss(z) >= 2 ln z`, so the root lies below `1 / sqrt(e)`.
    rising_root(1.0 / e.sqrt(), |z| loss(z) + log(e))
}

/// Kelvin-Voigt with separation at zero penetration: `e = exp(-pi z / sqrt(1 - z^2))`; 0 from `z = 1` on.
pub fn separating(damping_ratio: f64) -> f64 {
    if damping_ratio >= 1.0 {
        return 0.0;
    }
    exp(-PI * damping_ratio / (1.0 - damping_ratio * damping_ratio).sqrt())
}

/// Damping ratio at which [`separating`] gives `e`, for `0 < e <= 1`.
pub fn separating_damping(e: f64) -> f64 {
    let loss = -log(e);
    loss / hypot(loss, PI)
}

/// Hunt-Crossley: the root of `x (1 + e) = ln((1 + x) / (1 - x e))` at `x = a v0`, whatever the exponent.
pub fn hunt_crossley(product: f64) -> f64 {
    if product <= 0.0 {
        return 1.0;
    }
    // With w = x e, which lies between 0 and both 1 and x.
    rising_root(product.min(1.0), |w| -(product + w - log1p(product) + log1p(-w))) / product
}

/// Product `a v0` at which [`hunt_crossley`] gives `e`, for `0 < e <= 1`.
pub fn hunt_crossley_damping(e: f64) -> f64 {
    if e >= 1.0 {
        return 0.0;
    }
    // In u = -ln(1 - x e), which resolves x close to its limit 1 / e.
    let product = |u: f64| -expm1(-u) / e;
    product(rising_root((1.0 + e) / e, |u| u - product(u) * (1.0 + e) + log1p(product(u))))
}

/// `-ln e = 2 z acos(z) / sqrt(1 - z^2)` of the law without tension.
fn loss(z: f64) -> f64 {
    let angle = if (z - 1.0).abs() < 1e-6 {
        // First terms of the series about 1.
        1.0 + (1.0 - z) / 3.0
    } else if z < 1.0 {
        acos(z) / (1.0 - z * z).sqrt()
    } else {
        acosh(z) / (z * z - 1.0).sqrt()
    };
    2.0 * z * angle
}

/// Finds the root of a function that is negative just above 0 and not negative at `high`.
fn rising_root(high: f64, function: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, high);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if function(middle) < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

//! Isentropic flow through an orifice between two chambers.

use decore_math::number::{Mask, Number, per_lane};

/// Pressure ratio above which the flow function is replaced by a straight line to zero (square-root singularity).
const LINEAR_ABOVE: f64 = 0.999;
/// Chebyshev terms of the subsonic part; 14 suffice for exponents between 1.1 and 1.7.
const TERMS: usize = 14;

/// Constants of the gas.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gas {
    /// `R T` in J/kg.
    pub specific_energy_j_per_kg: f64,
    /// Isentropic exponent `kappa`.
    pub isentropic_exponent: f64,
    /// Exponent of inflow `a_in`.
    pub inflow_exponent: f64,
    /// Exponent of outflow `a_out`.
    pub outflow_exponent: f64,
    /// Exponent of expansion `a`.
    pub expansion_exponent: f64,
    /// Ambient pressure `Pa` in Pa.
    pub ambient_pressure_pa: f64,
}

per_lane! {
    /// The flow function `psi(r)` of the pressure ratio `r = Pd / Pu`, and the mass flow built on it.
    ///
    /// `m(Pu, Pd, A) = A Pu sqrt(kappa / (R T)) psi(Pd / Pu)` in kg/s. `psi` is constant in choked flow,
    /// `sqrt(2 / (kappa - 1) (r^(2/kappa) - r^((kappa+1)/kappa)))` below, and a straight line for `r > 0.999`.
    ///
    /// The subsonic branch is `sqrt((1 - r) g(r))` with a smooth `g`, here a polynomial fitted once per gas: it costs half
    /// of what the power function does and agrees with it to 1e-12, where that function's own rounding ends. All is a function of
    /// `1 - r`, which is exactly 0 at equal pressures.
    pub(super) struct FlowFunction<R> {
        /// `sqrt(kappa / (R T))` in s/m.
        flow_factor: R,
        /// `1 - r` from which on flow is choked.
        critical: R,
        choked: R,
        tail_slope: R,
        /// Coefficients of `g` in powers of the interval's own coordinate in [-1, 1], that of `1 - r`.
        coefficients: [R; TERMS],
        centre: R,
        inverse_half_width: R,
    }
}

per_lane! {
    /// A pressure in Pa and its inverse.
    pub(super) struct Pressure<R> {
        pub pa: R,
        pub inverse: R,
    }
}

/// `psi` of choked flow.
fn choked(kappa: f64) -> f64 {
    libm::pow(2.0 / (kappa + 1.0), (kappa + 1.0) / (2.0 * (kappa - 1.0)))
}

/// Choked mass flow in kg/s of a gas at `pressure_pa` through the effective area `area_m2`: no pressure behind takes more.
///
/// `A P sqrt(kappa / (R T)) psi`, with `R T` = `specific_energy_j_per_kg`.
pub fn choked_flow(isentropic_exponent: f64, specific_energy_j_per_kg: f64, pressure_pa: f64, area_m2: f64) -> f64 {
    area_m2 * pressure_pa * (isentropic_exponent / specific_energy_j_per_kg).sqrt() * choked(isentropic_exponent)
}

/// The subsonic branch as published.
fn subsonic(kappa: f64, ratio: f64) -> f64 {
    let root = libm::pow(ratio, 1.0 / kappa);
    (2.0 / (kappa - 1.0) * root * (root - ratio)).max(0.0).sqrt()
}

impl FlowFunction<f64> {
    /// Prepares the flow function of a gas.
    pub fn new(gas: &Gas) -> Self {
        let kappa = gas.isentropic_exponent;
        let critical = 1.0 - libm::pow(2.0 / (kappa + 1.0), kappa / (kappa - 1.0));
        let linear = 1.0 - LINEAR_ABOVE;
        let (centre, half_width) = (0.5 * (critical + linear), 0.5 * (critical - linear));
        let coefficients = fit(|s| {
            let less = centre + half_width * s;
            let psi = subsonic(kappa, 1.0 - less);
            psi * psi / less
        });
        Self {
            flow_factor: (kappa / gas.specific_energy_j_per_kg).sqrt(),
            critical,
            choked: choked(kappa),
            tail_slope: subsonic(kappa, LINEAR_ABOVE) / linear,
            coefficients,
            centre,
            inverse_half_width: 1.0 / half_width,
        }
    }
}

impl<R: Number> FlowFunction<R> {
    /// The flow function at pressure ratio `1 - less`, `less` in [0, 1].
    #[inline(always)]
    fn psi(&self, less: R) -> R {
        let linear = less.less(R::splat(1.0 - LINEAR_ABOVE));
        let outside = R::select(linear, self.tail_slope * less, self.choked);
        let subsonic = less.less(self.critical).and(less.greater_equal(R::splat(1.0 - LINEAR_ABOVE)));
        if !subsonic.any() {
            return outside;
        }
        let s = (less - self.centre) * self.inverse_half_width;
        R::select(subsonic, (less * even_odd_polynomial(&self.coefficients, s)).sqrt(), outside)
    }

    /// Mass flow in kg/s from one pressure to another through the effective area `area_m2`; negative when it reverses, 0 through no
    /// area.
    #[inline(always)]
    pub(super) fn mass_flow(&self, from: Pressure<R>, to: Pressure<R>, area_m2: R) -> R {
        let none = R::splat(0.0);
        let open = area_m2.greater(none);
        if !open.any() {
            return none;
        }
        let forward = from.pa.greater_equal(to.pa);
        let high = R::select(forward, from.pa, to.pa);
        let low = R::select(forward, to.pa, from.pa);
        let inverse = R::select(forward, from.inverse, to.inverse);
        let flow = area_m2 * high * self.flow_factor * self.psi((high - low) * inverse);
        R::select(open, R::select(forward, flow, -flow), none)
    }
}

/// Open share of an orifice from `x`, the travelled share of its cover: the smooth step `q^2 (3 - 2 q)`, `q` = `x` clamped to [0, 1].
#[inline(always)]
pub(super) fn smooth_step<R: Number>(x: R) -> R {
    // In this order of arguments a NaN remains one.
    let q = R::splat(0.0).greatest(R::splat(1.0).least(x));
    q * q * (R::splat(3.0) - R::splat(2.0) * q)
}

/// Even and odd parts by Horner's rule in `s^2`: two short chains instead of one long one.
#[inline(always)]
fn even_odd_polynomial<R: Number>(coefficients: &[R; TERMS], s: R) -> R {
    let square = s * s;
    let mut at = TERMS - 2;
    let (mut even, mut odd) = (coefficients[at], coefficients[at + 1]);
    while at > 0 {
        at -= 2;
        even = even.mul_add(square, coefficients[at]);
        odd = odd.mul_add(square, coefficients[at + 1]);
    }
    s.mul_add(odd, even)
}

/// Interpolates `f` on [-1, 1] at the Chebyshev nodes; returns power-series coefficients.
fn fit(f: impl Fn(f64) -> f64) -> [f64; TERMS] {
    let n = TERMS as f64;
    let angle = |j: usize| std::f64::consts::PI * (j as f64 + 0.5) / n;
    let values: Vec<f64> = (0..TERMS).map(|j| f(libm::cos(angle(j)))).collect();
    let mut power = [0.0; TERMS];
    // Chebyshev polynomials in powers, by their recurrence.
    let mut previous = [0.0; TERMS];
    let mut current = [0.0; TERMS];
    current[0] = 1.0;
    for k in 0..TERMS {
        let sum: f64 = (0..TERMS).map(|j| values[j] * libm::cos(k as f64 * angle(j))).sum();
        let weight = sum * if k == 0 { 1.0 / n } else { 2.0 / n };
        for i in 0..TERMS {
            power[i] += weight * current[i];
        }
        let factor = if k == 0 { 1.0 } else { 2.0 };
        let mut next = [0.0; TERMS];
        for i in 0..TERMS {
            let shifted = if i > 0 { current[i - 1] } else { 0.0 };
            next[i] = factor * shifted - previous[i];
        }
        (previous, current) = (current, next);
    }
    power
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Air at 20 C with the exponents of the default hammer.
    pub(in crate::hammer) fn air() -> Gas {
        Gas {
            specific_energy_j_per_kg: 287.05 * 293.15,
            isentropic_exponent: 1.4,
            inflow_exponent: 1.4,
            outflow_exponent: 1.0,
            expansion_exponent: 1.2,
            ambient_pressure_pa: 101_325.0,
        }
    }

    #[test]
    fn analytic_polynomial_equals_the_power_function() {
        for kappa in [1.1, 1.3, 1.4, 1.67] {
            let gas = Gas { isentropic_exponent: kappa, ..air() };
            let flow = FlowFunction::new(&gas);
            let worst = (0..=20_000)
                .map(|i| f64::from(i) / 20_000.0)
                .filter(|r| 1.0 - *r < flow.critical && *r <= LINEAR_ABOVE)
                .map(|r| (flow.psi(1.0 - r) / subsonic(kappa, r) - 1.0).abs())
                .fold(0.0, f64::max);
            assert!(worst < 1e-12, "kappa {kappa}: {worst:e}");
        }
    }

    #[test]
    fn analytic_choked_flow_and_limits() {
        let flow = FlowFunction::new(&air());
        assert!((1.0 - flow.critical - 0.528_281_787_717_174).abs() < 1e-12);
        assert!((flow.psi(1.0) - 0.578_703_703_703_703).abs() < 1e-12);
        assert_eq!(flow.psi(0.0), 0.0);
        // Continuous at both joints.
        for joint in [flow.critical, 1.0 - LINEAR_ABOVE] {
            let jump = flow.psi(joint * (1.0 + 1e-12)) - flow.psi(joint * (1.0 - 1e-12));
            assert!(jump.abs() < 1e-6, "{jump:e}");
        }
        let [high, low] = [6e5, 1e5].map(|pa| Pressure { pa, inverse: 1.0 / pa });
        let forward = flow.mass_flow(high, low, 1e-5);
        assert!((forward / choked_flow(1.4, air().specific_energy_j_per_kg, 6e5, 1e-5) - 1.0).abs() < 1e-14);
        assert_eq!(forward, -flow.mass_flow(low, high, 1e-5));
        assert_eq!((flow.mass_flow(high, high, 1e-5), flow.mass_flow(high, low, 0.0)), (0.0, 0.0));
    }

    /// The step is smooth: 0, 1/2, 1 with zero slope at both ends.
    #[test]
    fn analytic_smooth_step() {
        assert_eq!([-3.0, 0.0, 0.5, 1.0, 7.0].map(smooth_step), [0.0, 0.0, 0.5, 1.0, 1.0]);
        assert!(smooth_step(1e-4) < 3.1e-8 && 1.0 - smooth_step(1.0 - 1e-4) < 3.1e-8);
    }
}

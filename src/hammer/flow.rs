//! Isentropic flow through an orifice between two chambers.

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

/// The flow function `psi(r)` of the pressure ratio `r = Pd / Pu`, and the mass flow built on it.
///
/// `m(Pu, Pd, A) = A Pu sqrt(kappa / (R T)) psi(Pd / Pu)` in kg/s. `psi` is constant in choked flow,
/// `sqrt(2 / (kappa - 1) (r^(2/kappa) - r^((kappa+1)/kappa)))` below, and a straight line for `r > 0.999`.
///
/// The subsonic branch is `sqrt((1 - r) g(r))` with a smooth `g`, here a polynomial fitted once per gas: it costs half
/// of what the power function does and agrees with it to 1e-12, where that function's own rounding ends.
#[derive(Debug, Clone, PartialEq)]
pub struct FlowFunction {
    /// `sqrt(kappa / (R T))` in s/m.
    flow_factor: f64,
    critical_ratio: f64,
    choked: f64,
    tail_slope: f64,
    /// Coefficients of `g` in powers of the interval's own coordinate in [-1, 1].
    coefficients: [f64; TERMS],
    centre: f64,
    inverse_half_width: f64,
}

/// `psi` of choked flow.
fn choked(kappa: f64) -> f64 {
    (2.0 / (kappa + 1.0)).powf((kappa + 1.0) / (2.0 * (kappa - 1.0)))
}

/// Choked mass flow in kg/s of a gas at `pressure_pa` through the effective area `area_m2`: no pressure behind takes more.
///
/// `A P sqrt(kappa / (R T)) psi`, with `R T` = `specific_energy_j_per_kg`, see [`FlowFunction`].
pub fn choked_flow(isentropic_exponent: f64, specific_energy_j_per_kg: f64, pressure_pa: f64, area_m2: f64) -> f64 {
    area_m2 * pressure_pa * (isentropic_exponent / specific_energy_j_per_kg).sqrt() * choked(isentropic_exponent)
}

/// The subsonic branch as published.
fn subsonic(kappa: f64, ratio: f64) -> f64 {
    let root = ratio.powf(1.0 / kappa);
    (2.0 / (kappa - 1.0) * root * (root - ratio)).max(0.0).sqrt()
}

impl FlowFunction {
    /// Prepares the flow function of a gas.
    pub fn new(gas: &Gas) -> Self {
        let kappa = gas.isentropic_exponent;
        let critical_ratio = (2.0 / (kappa + 1.0)).powf(kappa / (kappa - 1.0));
        let centre = 0.5 * (critical_ratio + LINEAR_ABOVE);
        let half_width = 0.5 * (LINEAR_ABOVE - critical_ratio);
        let coefficients = fit(|s| {
            let ratio = centre + half_width * s;
            let psi = subsonic(kappa, ratio);
            psi * psi / (1.0 - ratio)
        });
        Self {
            flow_factor: (kappa / gas.specific_energy_j_per_kg).sqrt(),
            critical_ratio,
            choked: choked(kappa),
            tail_slope: subsonic(kappa, LINEAR_ABOVE) / (1.0 - LINEAR_ABOVE),
            coefficients,
            centre,
            inverse_half_width: 1.0 / half_width,
        }
    }

    /// The flow function at pressure ratio `ratio` in [0, 1].
    #[inline(always)]
    pub fn psi(&self, ratio: f64) -> f64 {
        if ratio <= self.critical_ratio {
            return self.choked;
        }
        if ratio > LINEAR_ABOVE {
            return self.tail_slope * (1.0 - ratio);
        }
        let s = (ratio - self.centre) * self.inverse_half_width;
        ((1.0 - ratio) * even_odd_polynomial(&self.coefficients, s)).sqrt()
    }

    /// Mass flow in kg/s from `from_pa` to `to_pa` through the effective area `area_m2`; negative when it reverses.
    #[inline(always)]
    pub fn mass_flow(&self, from_pa: f64, to_pa: f64, area_m2: f64) -> f64 {
        if from_pa >= to_pa {
            area_m2 * from_pa * self.flow_factor * self.psi(to_pa / from_pa)
        } else {
            -area_m2 * to_pa * self.flow_factor * self.psi(from_pa / to_pa)
        }
    }

    /// How much the mass flow from `chamber_pa` to `ambient_pa` grows per Pa in the chamber where it is linear, close to equal
    /// pressures, in kg/(s Pa); 0 elsewhere.
    pub fn linear_conductance(&self, chamber_pa: f64, ambient_pa: f64, area_m2: f64) -> f64 {
        let linear = chamber_pa.min(ambient_pa) > LINEAR_ABOVE * chamber_pa.max(ambient_pa);
        if linear { area_m2 * self.flow_factor * self.tail_slope } else { 0.0 }
    }
}

/// Even and odd parts by Horner's rule in `s^2`: two short chains instead of one long one.
#[inline]
fn even_odd_polynomial(coefficients: &[f64; TERMS], s: f64) -> f64 {
    let square = s * s;
    let (mut even, mut odd) = (0.0, 0.0);
    for pair in coefficients.chunks_exact(2).rev() {
        even = even * square + pair[0];
        odd = odd * square + pair[1];
    }
    even + s * odd
}

/// Interpolates `f` on [-1, 1] at the Chebyshev nodes; returns power-series coefficients.
fn fit(f: impl Fn(f64) -> f64) -> [f64; TERMS] {
    let n = TERMS as f64;
    let angle = |j: usize| std::f64::consts::PI * (j as f64 + 0.5) / n;
    let values: Vec<f64> = (0..TERMS).map(|j| f(angle(j).cos())).collect();
    let mut power = [0.0; TERMS];
    // Chebyshev polynomials in powers, by their recurrence.
    let mut previous = [0.0; TERMS];
    let mut current = [0.0; TERMS];
    current[0] = 1.0;
    for k in 0..TERMS {
        let sum: f64 = (0..TERMS).map(|j| values[j] * (k as f64 * angle(j)).cos()).sum();
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
                .filter(|r| *r > flow.critical_ratio && *r <= LINEAR_ABOVE)
                .map(|r| (flow.psi(r) / subsonic(kappa, r) - 1.0).abs())
                .fold(0.0, f64::max);
            assert!(worst < 1e-12, "kappa {kappa}: {worst:e}");
        }
    }

    #[test]
    fn analytic_choked_flow_and_limits() {
        let flow = FlowFunction::new(&air());
        assert!((flow.critical_ratio - 0.528_281_787_717_174).abs() < 1e-12);
        assert!((flow.psi(0.0) - 0.578_703_703_703_703).abs() < 1e-12);
        assert_eq!(flow.psi(1.0), 0.0);
        // Continuous at both joints.
        for joint in [flow.critical_ratio, LINEAR_ABOVE] {
            let jump = flow.psi(joint * (1.0 + 1e-12)) - flow.psi(joint * (1.0 - 1e-12));
            assert!(jump.abs() < 1e-6, "{jump:e}");
        }
        let forward = flow.mass_flow(6e5, 1e5, 1e-5);
        assert_eq!(forward, -flow.mass_flow(1e5, 6e5, 1e-5));
    }
}

//! Gas chambers of a hammer whose bodies are held, against closed forms.

use std::f64::consts::PI;

use crate::common::harness::{Harness, Piecewise, assert_close, assert_relative, run, settings};
use decore_model::hammer::{Gas, HammerModel, HammerParameters, HammerState, body, chamber};
use decore_model::integrate::Stopped;

const VOLUME: f64 = 1e-4;
const AREA: f64 = 1e-5;
const SUPPLY: f64 = 6e5;
const AMBIENT: f64 = 1e5;
/// Critical pressure ratio at kappa = 1.4.
const CRITICAL: f64 = 0.528_281_787_717_174;

fn gas(inflow: f64, outflow: f64, expansion: f64) -> Gas {
    Gas {
        specific_energy_j_per_kg: 287.0 * 293.15,
        isentropic_exponent: 1.4,
        inflow_exponent: inflow,
        outflow_exponent: outflow,
        expansion_exponent: expansion,
        ambient_pressure_pa: AMBIENT,
    }
}

/// A hammer whose telescope chambers both have the closed form's volume and orifice, at rest at zero.
fn parameters() -> HammerParameters {
    let mut parameters = HammerParameters::default();
    let t = &mut parameters.telescope;
    (t.top_clearance_m, t.top_dead_volume_m3, t.inlet_area_m2, t.vent_area_m2) = (0.0, VOLUME, AREA, AREA);
    t.annulus_length_m = VOLUME / (t.annulus_area_ratio * 0.25 * PI * t.bore_m * t.bore_m);
    parameters
}

/// Chambers of a hammer with prescribed motion: states the four pressures in units of 1e5 Pa; guard 0 waits for chamber
/// `watched` to reach `target` from below; one quadrature, the mass drawn from the supply in kg.
struct Chambers {
    model: HammerModel,
    supply_pa: f64,
    /// Piston over time: position and velocity relative to the cylinder.
    piston: fn(f64) -> [f64; 2],
    /// Cylinder over time relative to the guide.
    cylinder: fn(f64) -> [f64; 2],
    watched: usize,
    target: f64,
}

impl Chambers {
    fn held(model: HammerModel, supply_pa: f64) -> Self {
        let piston = |_| [0.060, 0.0];
        Self { model, supply_pa, piston, cylinder: |_| [0.0, 0.0], watched: 0, target: f64::INFINITY }
    }
}

impl Piecewise for Chambers {
    fn states(&self) -> usize {
        4
    }

    fn quadratures(&self) -> usize {
        1
    }

    fn rate(&self, t: f64, y: &[f64], rate: &mut [f64]) {
        let ([e, e_rate], [p, p_rate]) = ((self.cylinder)(t), (self.piston)(t));
        let mut state = HammerState { supply_pa: self.supply_pa, ..self.model.rest() };
        state.position = [0.0, e, e, e + p, e];
        state.velocity = [0.0, e_rate, e_rate, e_rate + p_rate, e_rate];
        state.pressure = std::array::from_fn(|i| 1e5 * y[i]);
        let rates = self.model.evaluate(&state);
        for (i, pressure_rate) in rates.pressure_rate.iter().enumerate() {
            rate[i] = 1e-5 * pressure_rate;
        }
        rate[4] = rates.supply_flow_kg_s;
    }

    fn guards(&self) -> usize {
        1
    }

    fn guard(&self, _guard: usize, y: &[f64]) -> f64 {
        y[self.watched] - self.target
    }

    fn switch(&mut self, _guard: usize, _t: f64, _y: &mut [f64]) {
        self.target = f64::INFINITY;
    }
}

/// `tau = V / (A sqrt(kappa R T) psi*)`.
fn tau() -> f64 {
    let choked: f64 = (2.0f64 / 2.4).powf(3.0);
    VOLUME / (AREA * (1.4f64 * 287.0 * 293.15).sqrt() * choked)
}

/// Time at which the top chamber, filled from 1 bar, reaches `target` bar.
fn filling_time(inflow: f64, target: f64) -> f64 {
    let mut chambers = Chambers::held(HammerModel::new(&parameters(), gas(inflow, 1.0, 1.2), 0.0), SUPPLY);
    (chambers.watched, chambers.target) = (chamber::TOP, target);
    let run = run(&mut Harness::new(chambers), &[1.0, 1.0, 1.0, 1.0, 0.0], settings(1e-10, 1e-3), 0.2);
    assert_eq!(run.stopped, Stopped::AtEnd);
    assert_eq!(run.events.len(), 1);
    run.events[0].t
}

/// Choked filling is linear in time: 18.207 ms (exponent 1) or 13.005 ms (1.4) to the critical ratio. 1e-9: the tolerance.
#[test]
fn analytic_choked_filling() {
    assert_close("tau in ms", 1e3 * tau(), 50.349, 2e-5);
    for (exponent, published_ms) in [(1.0, 18.207), (1.4, 13.005)] {
        for target in [1.5, 2.0, 3.0, 6.0 * CRITICAL] {
            let expected = tau() / exponent * (target - 1.0) / 6.0;
            let found = filling_time(exponent, target);
            assert_relative("time to target", found, expected, 1e-9);
        }
        let end = filling_time(exponent, 6.0 * CRITICAL);
        println!("choked phase {} ms", 1e3 * end);
        assert_close("published choked phase in ms", 1e3 * end, published_ms, 1e-4);
    }
}

/// Subsonic filling: `dt = 7 (C1/C2) (tau/a) (sqrt(1 - u1) - sqrt(1 - u))`, `u = (P/Ps)^(2/7)`, up to the ratio 0.999 beyond
/// which the flow function is a straight line; from there pressure approaches the supply exponentially.
#[test]
fn analytic_subsonic_filling() {
    let (c1, c2) = ((2.0f64 / 2.4).powf(3.0) * (1.4f64 / 287.0).sqrt(), (2.8f64 / (287.0 * 0.4)).sqrt());
    assert_close("published C1", c1, 0.040_418, 1e-6);
    assert_close("published C2", c2, 0.156_174, 1e-6);
    let u = |ratio: f64| ratio.powf(2.0 / 7.0);
    for exponent in [1.0, 1.4] {
        let start = filling_time(exponent, 6.0 * CRITICAL);
        for ratio in [0.6, 0.8, 0.95, 0.999] {
            let expected = 7.0 * (c1 / c2) * tau() / exponent * ((1.0 - u(CRITICAL)).sqrt() - (1.0 - u(ratio)).sqrt());
            let found = filling_time(exponent, 6.0 * ratio) - start;
            println!("ratio {ratio}: off by {:.1e}", found / expected - 1.0);
            assert_relative("subsonic phase", found, expected, 1e-8);
        }
    }
    let to_supply = 7.0 * (c1 / c2) * tau() * (1.0 - u(CRITICAL)).sqrt();
    assert_close("published, in ms", 1e3 * to_supply, 37.238, 2e-5);
    // The straight line: Ps - P falls by e every (1 - 0.999) / psi(0.999) psi* tau.
    let psi: f64 = (5.0 * (0.999f64.powf(10.0 / 7.0) - 0.999f64.powf(12.0 / 7.0))).sqrt();
    let choked: f64 = (2.0f64 / 2.4).powf(3.0);
    let decay = 0.001 / psi * choked * tau();
    let found = filling_time(1.0, 6.0 * 0.9999) - filling_time(1.0, 6.0 * 0.999);
    assert_relative("tail", found, decay * 10f64.ln(), 1e-6);
}

/// Choked discharge of the annulus: `exp(-a t / tau)`.
#[test]
fn analytic_choked_discharge() {
    for exponent in [1.0, 1.4] {
        let chambers = Chambers::held(HammerModel::new(&parameters(), gas(1.4, exponent, 1.2), 0.0), AMBIENT);
        // Choked down to 1.89 bar.
        let end = 0.9 * tau() / exponent * (6.0 * CRITICAL).ln();
        let run = run(&mut Harness::new(chambers), &[1.0, 6.0, 1.0, 1.0, 0.0], settings(1e-10, 1e-3), end);
        let expected = 6.0 * (-exponent * end / tau()).exp();
        println!("discharge: {} bar, off by {:.1e}", run.y[1], run.y[1] / expected - 1.0);
        assert_relative("pressure", run.y[chamber::ANNULUS], expected, 1e-9);
    }
}

/// A supply that is lower than the chamber draws its gas off, with the exponent of outflow.
#[test]
fn analytic_discharge_into_the_supply() {
    let chambers = Chambers::held(HammerModel::new(&parameters(), gas(1.4, 1.1, 1.2), 0.0), AMBIENT);
    let end = 0.01;
    let run = run(&mut Harness::new(chambers), &[6.0, 1.0, 1.0, 1.0, 0.0], settings(1e-10, 1e-3), end);
    assert_relative("pressure", run.y[chamber::TOP], 6.0 * (-1.1 * end / tau()).exp(), 1e-9);
    assert!(run.y[4] < 0.0, "air flows back into the supply");
}

/// Closed chambers, moved: `P V^a` is constant in all four, whatever the motion.
#[test]
fn analytic_closed_chambers() {
    let mut parameters = parameters();
    (parameters.telescope.inlet_area_m2, parameters.telescope.vent_area_m2) = (0.0, 0.0);
    (parameters.piston.rear_exhaust_area_m2, parameters.piston.front_exhaust_area_m2) = (0.0, 0.0);
    for exponent in [1.0, 1.2, 1.4] {
        let model = HammerModel::new(&parameters, gas(1.4, 1.0, exponent), 0.0);
        let mut chambers = Chambers::held(model.clone(), SUPPLY);
        chambers.piston = |t| [0.07 + 0.05 * (40.0 * t).sin(), 2.0 * (40.0 * t).cos()];
        chambers.cylinder = |t| [0.01 - 0.01 * (70.0 * t).cos(), 0.7 * (70.0 * t).sin()];
        let volumes = |t: f64| {
            let ([e, _], [p, _]) = ((chambers.cylinder)(t), (chambers.piston)(t));
            model.volumes(&[0.0, e, e, e + p, e])
        };
        let (end, start) = (0.137, [1.0, 2.0, 3.0, 4.0, 0.0]);
        let (before, after) = (volumes(0.0), volumes(end));
        let run = run(&mut Harness::new(chambers), &start, settings(1e-10, 1e-3), end);
        for i in 0..chamber::COUNT {
            let expected = start[i] * (before[i] / after[i]).powf(exponent);
            assert_relative("pressure", run.y[i], expected, 1e-8);
        }
        assert_eq!(run.y[4], 0.0);
    }
}

/// With all exponents 1 the gas is isothermal: the mass in a chamber is `P V / (R T)`, and what the supply gave is in it.
#[test]
fn analytic_mass_balance() {
    let mut chambers = Chambers::held(HammerModel::new(&parameters(), gas(1.0, 1.0, 1.0), 0.0), SUPPLY);
    chambers.cylinder = |t| [0.01 - 0.01 * (70.0 * t).cos(), 0.7 * (70.0 * t).sin()];
    let area = 0.25 * PI * 0.0564 * 0.0564;
    let end = 0.05;
    let run = run(&mut Harness::new(chambers), &[1.0, 1.0, 1.0, 1.0, 0.0], settings(1e-10, 1e-3), end);
    let extension = 0.01 - 0.01 * (70.0 * end).cos();
    let energy = 287.0 * 293.15;
    let stored = (1e5 * run.y[0] * (VOLUME + area * extension) - 1e5 * VOLUME) / energy;
    println!("supply gave {} kg, stored {stored} kg", run.y[4]);
    assert_relative("mass", run.y[4], stored, 1e-8);
}

/// The work of the gas on the bodies is what the power says: pressures times areas times speeds.
#[test]
fn analytic_gas_forces() {
    let model = HammerModel::new(&HammerParameters::default(), gas(1.4, 1.0, 1.2), 0.0);
    let mut state = model.rest();
    state.position = [0.0, 0.02, 0.021, 0.09, 0.03];
    state.pressure = [3e5, 1.5e5, 4e5, 2e5];
    state.supply_pa = SUPPLY;
    let rates = model.evaluate(&state);
    let p = HammerParameters::default();
    let circle = |d: f64| 0.25 * PI * d * d;
    let (a1, a3) = (circle(p.telescope.bore_m), circle(p.piston.bore_m));
    let telescope = 2e5 * a1 - 0.5e5 * 0.35 * a1 - (140.0 + 1633.0 * 0.02);
    let piston = 3e5 * a3 - 1e5 * 0.9 * a3;
    let spool = 1.5e-4 * (0.5 * 5e5 - 3e5);
    assert_relative("piston", rates.force[body::PISTON], piston, 1e-12);
    assert_relative("spool", rates.force[body::SPOOL], spool, 1e-12);
    assert_relative("guide", rates.force[body::GUIDE], -telescope, 1e-12);
    assert_relative("cylinder", rates.force[body::CYLINDER], telescope - piston - spool, 1e-12);
    assert_eq!(rates.force[body::CHISEL], 0.0);
    // Actio and reactio: with no gravity all forces cancel.
    assert!(rates.force.iter().sum::<f64>().abs() < 1e-10);
}

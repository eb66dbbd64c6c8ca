//! Scenes for the coupled system: a bare bench of rigid bodies, and a rig with a structure of its own.

use std::collections::BTreeMap;
use std::sync::Arc;

use decore_model::contact::{ContactParameters, kelvin_voigt};
use decore_model::hammer::{HammerParameters, body};
use decore_model::integrate::{Observer, Step, System};
use decore_model::scene::{
    Environment, FixtureId, Guide, HammerLink, HammerUnit, ModeTreatment, Mount, OutputSettings, Owner, PointId, Scene,
    SolverSettings,
};
use decore_model::system::{Coupled, CoupledModel, InterfaceModes};
use decore_model::workpiece::{Casting, Fixture};

use super::harness::{Run, observe, settings};

/// A contact without damping that is too soft to be felt.
pub const NO_CONTACT: ContactParameters = kelvin_voigt(1e-12, 0.0);

/// One hammer and one casting as free rigid bodies on rigid ground: no gravity, no gas to speak of, no friction, no
/// springs. What a test is about it adds. Interface points: the mount, then the casting's one fixture (1e-9 N/m).
pub fn bench() -> (Scene, InterfaceModes) {
    let mut parameters = HammerParameters::default();
    let t = &mut parameters.telescope;
    // Force of the gas on a bore of a micrometre: below 1e-7 N.
    (t.bore_m, parameters.piston.bore_m, parameters.valve.area_m2) = (1e-6, 1e-6, 1e-12);
    (t.inlet_area_m2, t.vent_area_m2) = (0.0, 0.0);
    (t.spring_stiffness_n_per_m, t.spring_damping_n_s_per_m, t.spring_preload_n) = (0.0, 0.0, 0.0);
    (t.friction_static_n, t.friction_viscous_n_s_per_m, t.friction_directional_n_s_per_m) = (0.0, 0.0, 0.0);
    t.top_stop = NO_CONTACT;
    t.end_stop = NO_CONTACT;
    let p = &mut parameters.piston;
    (p.rear_exhaust_area_m2, p.front_exhaust_area_m2, p.friction_viscous_n_s_per_m) = (0.0, 0.0, 0.0);
    let v = &mut parameters.valve;
    (v.rear_feed_area_m2, v.front_feed_area_m2, v.friction_viscous_n_s_per_m) = (0.0, 0.0, 0.0);
    parameters.chisel.friction_viscous_n_s_per_m = 0.0;
    let scene = Scene {
        machine: None,
        environment: Environment { gravity_m_s2: 0.0, ..Environment::default() },
        hammers: vec![hammer("left", parameters)],
        castings: vec![casting("part", &[(1e-9, 0.0)])],
        duration_s: 1.0,
        solver: solver(Guide::Tied),
        outputs: OutputSettings::default(),
    };
    let modes = InterfaceModes {
        omega_rad_s: Vec::new(),
        damping_ratio: Vec::new(),
        shapes: shapes([Vec::new()], [Vec::new()]),
    };
    (scene, modes)
}

/// Mode shapes at the mounts of hammers and at the fixtures of the first casting.
pub fn shapes(
    mounts: impl IntoIterator<Item = Vec<f64>>,
    fixtures: impl IntoIterator<Item = Vec<f64>>,
) -> BTreeMap<PointId, Vec<f64>> {
    let mounts = mounts.into_iter().enumerate().map(|(hammer, row)| (PointId::Mount { hammer }, row));
    let fixtures = fixtures.into_iter().enumerate().map(|(fixture, row)| (support(0, fixture), row));
    mounts.chain(fixtures).collect()
}

/// Point of the machine that carries the first hammer.
pub const MOUNT: PointId = PointId::Mount { hammer: 0 };

/// Point of the machine that carries a fixture.
pub fn support(casting: usize, fixture: usize) -> PointId {
    PointId::Support(FixtureId { casting, fixture, axis: 0 })
}

/// Component of the state that is the velocity of a casting's centre of mass.
pub fn heave_velocity(model: &CoupledModel, casting: usize) -> usize {
    let [_, velocity] = model.point_sums(PointId::Centre { casting }).expect("a rigid casting");
    velocity[0].0
}

/// A hammer with the default supply over the centre of casting 0.
pub fn hammer(name: &str, parameters: HammerParameters) -> HammerUnit {
    HammerUnit {
        name: name.into(),
        parameters,
        supply_pressure_pa: 601_325.0,
        mount: Mount { points: vec![("M".into(), 1.0)] },
        ..HammerUnit::default()
    }
}

/// A casting of the default mass on fixtures (stiffness, damping) at its centre.
pub fn casting(name: &str, fixtures: &[(f64, f64)]) -> Casting {
    let fixture = |(i, (stiffness, damping)): (usize, &(f64, f64))| Fixture {
        name: format!("f{i}"),
        point: format!("T{i}"),
        stiffness_n_per_m: *stiffness,
        damping_n_s_per_m: *damping,
        ..Fixture::default()
    };
    Casting {
        name: name.into(),
        mass_kg: 0.517,
        fixtures: fixtures.iter().enumerate().map(fixture).collect(),
        ..Casting::default()
    }
}

/// Accuracy of the tests' runs.
pub fn solver(guide: Guide) -> SolverSettings {
    SolverSettings {
        tolerance: 1e-5,
        guide,
        modes: ModeTreatment::Integrated,
        max_steps: 5_000_000,
        max_wall_time_s: 60.0,
        ..SolverSettings::default()
    }
}

/// A castings-only scene: no hammers at all.
pub fn castings_only(castings: Vec<Casting>) -> Scene {
    let (scene, _) = bench();
    Scene { hammers: Vec::new(), castings, ..scene }
}

/// Whole default hammers on one casting and a structure of six modes (16 to 280 Hz). `hammers` of them, side by side.
pub fn rig(hammers: usize) -> (Scene, InterfaceModes) {
    let (empty, _) = bench();
    let scene = Scene {
        environment: Environment::default(),
        hammers: (0..hammers).map(|h| hammer(&format!("h{h}"), HammerParameters::default())).collect(),
        castings: vec![casting("part", &[(3e7, 4000.0)])],
        ..empty
    };
    let hertz: [f64; 6] = [16.3, 18.6, 44.7, 84.8, 144.0, 278.6];
    let shape = |seed: usize, k: usize| 0.06 * (0.7 + 1.3 * (seed * 7 + k * 3) as f64).cos();
    let row = |seed: usize| (0..hertz.len()).map(|k| shape(seed, k)).collect::<Vec<f64>>();
    let modes = InterfaceModes {
        omega_rad_s: hertz.iter().map(|f| 2.0 * std::f64::consts::PI * f).collect(),
        damping_ratio: vec![0.02; hertz.len()],
        shapes: shapes((0..hammers).map(|h| row(h + 1)), [row(0)]),
    };
    (scene, modes)
}

/// Components of the state that hold a body's position and velocity, by the body's place in the hammer.
pub fn body_components(model: &CoupledModel, hammer: usize, body: usize) -> (usize, usize) {
    let point = model.hammers()[hammer].points[body];
    (model.layout().position(point), model.layout().velocity(point))
}

/// Places a body of the first hammer at a position with a velocity.
pub fn place(model: &CoupledModel, y: &mut [f64], body: usize, (position, velocity): (f64, f64)) {
    let (x, v) = body_components(model, 0, body);
    (y[x], y[v]) = (position, velocity);
}

/// The bench's state with every body clear of every other: spool and chisel in the middle of their travels, the piston
/// 60 mm from the rear wall, all at rest.
pub fn clear(model: &CoupledModel) -> Vec<f64> {
    let mut y = model.initial_state().to_vec();
    place(model, &mut y, body::CYLINDER, (0.0, 0.0));
    place(model, &mut y, body::SPOOL, (0.002, 0.0));
    place(model, &mut y, body::PISTON, (0.060, 0.0));
    place(model, &mut y, body::CHISEL, (0.006, 0.0));
    y
}

/// Index of a contact of the first hammer.
pub fn contact_index(model: &CoupledModel, link: HammerLink) -> usize {
    model.elements().contact_of(Owner::Hammer { hammer: 0, link }).expect("every hammer has all of them")
}

/// Integrates a coupled model from a state with every contact open that is open at rest.
pub fn simulate(model: &Arc<CoupledModel>, y0: &[f64], (tolerance, longest_step_s): (f64, f64), end: f64) -> Run {
    observe(&mut Coupled::new(model), y0, settings(tolerance, longest_step_s), end, &mut ())
}

/// Largest force of one contact, sampled densely within every step.
pub struct PeakForce {
    pub contact: usize,
    pub newton: f64,
}

impl Observer<Coupled> for PeakForce {
    fn step(&mut self, system: &Coupled, step: &Step<'_>) {
        let mut y = vec![0.0; system.dimension()];
        for part in 0..=200 {
            let theta = step.theta_end * f64::from(part) / 200.0;
            step.state(theta, &mut y);
            self.newton = self.newton.max(system.contact_force(self.contact, step.time(theta), &y));
        }
    }

    fn event(&mut self, _system: &Coupled, _guard: usize, _t: f64, _y: &[f64]) {}
}

//! The linear part that exponential steps take exactly is that of the right-hand side itself: differences of one against the
//! matrices and rates of the other, at states met while a hammer works.

use std::ops::Range;
use std::path::Path;

use crate::common::changed::settings;
use decore::engine::{Engine, RowScene};
use decore::integrate::{ExponentialTsit5, Integrator, LinearPart, StiffBlock, StiffMatrices, Stopped, System};
use decore::system::{Coupled, CoupledModel, build};

/// Stiffness of the return spring, N/m, the one that the matrices leave out: it is soft.
const RETURN_SPRING_N_PER_M: f64 = 1.633e3;
/// Its damping, N s/m.
const RETURN_DAMPING_N_S_PER_M: f64 = 0.1633;
/// Mass of the cylinder that it pushes, kg.
const CYLINDER_KG: f64 = 6.5;

/// The paper's rig without friction, whose slope at rest would hide those of soft contacts.
fn model() -> CoupledModel {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/paper_rig.toml");
    let settings = ["solver.guide=tied", "solver.modes=condensed", "duration_s=0.5"].map(str::to_owned);
    let RowScene { mut scene, modes } = Engine::load(&path, &settings).unwrap().scene(0).unwrap();
    let parameters = &mut scene.hammers[0].parameters;
    let telescope = &mut parameters.telescope;
    telescope.friction_static_n = 0.0;
    telescope.friction_viscous_n_s_per_m = 0.0;
    telescope.friction_directional_n_s_per_m = 0.0;
    parameters.piston.friction_viscous_n_s_per_m = 0.0;
    parameters.valve.friction_viscous_n_s_per_m = 0.0;
    parameters.chisel.friction_viscous_n_s_per_m = 0.0;
    build(&scene, &modes).unwrap()
}

/// Central difference of the rates at `(t, y)` with respect to component `index`, moved by `by`.
fn slope(system: &mut Coupled<'_>, (t, y): (f64, &[f64]), index: usize, by: f64) -> Vec<f64> {
    let mut moved = |by: f64| {
        let (mut state, mut rate) = (y.to_vec(), vec![0.0; y.len()]);
        state[index] += by;
        system.rhs(t, &state, &mut rate);
        rate
    };
    moved(by).iter().zip(&moved(-by)).map(|(up, down)| (up - down) / (2.0 * by)).collect()
}

/// One slope against an entry of a matrix, to 1e-6 of it and what the return spring adds.
fn check(found: f64, entry: f64, soft: f64, what: &str) {
    assert!((found - entry).abs() < 1e-6 * entry.abs() + 1.1 * soft, "{what}: {found} and {entry}");
}

/// All rates' slopes with respect to one body.
fn check_body(
    system: &mut Coupled<'_>,
    at: (f64, &[f64]),
    (block, body): (&StiffBlock, usize),
    matrices: &StiffMatrices,
) {
    let positions = slope(system, at, block.positions + body, 1e-9);
    let velocities = slope(system, at, block.velocities + body, 1e-5);
    let t = at.0;
    for other in 0..block.bodies {
        let (row, what) = (block.velocities + other, format!("{t}, body {other} by {body}"));
        check(positions[row], -matrices.stiffness[(other, body)], RETURN_SPRING_N_PER_M / CYLINDER_KG, &what);
        check(velocities[row], -matrices.damping[(other, body)], RETURN_DAMPING_N_S_PER_M / CYLINDER_KG, &what);
    }
    for point in 0..block.integrals.width {
        let (row, what) = (block.integrals.from + point, format!("{t}, point {point} by {body}"));
        check(positions[row], matrices.integrated_stiffness[(point, body)], RETURN_SPRING_N_PER_M, &what);
        check(velocities[row], matrices.integrated_damping[(point, body)], RETURN_DAMPING_N_S_PER_M, &what);
    }
}

/// The rates of chambers that relax; returns how many do.
fn check_chambers(system: &mut Coupled<'_>, (t, y): (f64, &[f64]), relaxing: Range<usize>) -> usize {
    let mut lambda = vec![0.0; relaxing.len()];
    system.relaxation(t, y, &mut lambda);
    let found: Vec<(usize, f64)> = lambda.into_iter().enumerate().filter(|(_, lambda)| *lambda > 0.0).collect();
    for (chamber, lambda) in &found {
        let index = relaxing.start + chamber;
        let slope = -slope(system, (t, y), index, 1e-3)[index];
        // The slope holds the adiabatic part, -a V'/V, as well.
        assert!((slope / lambda - 1.0).abs() < 1e-2, "{t}, chamber {chamber}: {slope} and {lambda}");
    }
    found.len()
}

#[test]
fn matrices_are_the_slopes_of_the_rates() {
    let model = model();
    let mut system = Coupled::new(&model);
    let mut integrator = Integrator::<_, ExponentialTsit5>::new(&system, 0.0, model.initial_state(), &settings(1e-5));
    let block = system.stiff_block().expect("tied, condensed and linear");
    let mut matrices = StiffMatrices::zeros(&block);
    let (mut states, mut relaxing) = (std::collections::BTreeSet::new(), 0);
    for instant in 1..=80 {
        let t = 0.005 * f64::from(instant);
        assert_eq!(integrator.run(&mut system, &mut (), t), Stopped::AtEnd);
        let y = integrator.state().to_vec();
        system.stiff_matrices(&mut matrices);
        states.insert(system.discrete_state());
        for body in 0..block.bodies {
            check_body(&mut system, (t, &y), (&block, body), &matrices);
        }
        relaxing += check_chambers(&mut system, (t, &y), block.relaxing.clone());
    }
    // Different sets of closed contacts, and chambers close to ambient pressure.
    assert!(states.len() >= 5 && relaxing > 10, "{} states, {relaxing} chambers", states.len());
}

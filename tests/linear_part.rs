//! The linear part that exponential steps take exactly is that of the right-hand side itself: differences of one against the
//! matrices and rates of the other, at states met while a hammer works.

use std::path::Path;

use decore::integrate::{Integrator, Settings, StiffMatrices, Stopped, System};
use decore::run::{Machine, SourceModel};
use decore::study::Study;
use decore::system::{Coupled, build};
use nalgebra::DMatrix;

/// The body whose friction acts against the machine.
const CYLINDER: usize = 0;

/// Rate at a state whose component `index` is moved by `by`.
fn moved(system: &mut Coupled<'_>, t: f64, y: &[f64], (index, by): (usize, f64)) -> Vec<f64> {
    let (mut state, mut rate) = (y.to_vec(), vec![0.0; y.len()]);
    state[index] += by;
    system.rhs(t, &state, &mut rate);
    rate
}

/// Central difference of the rates with respect to component `index`.
fn slope(system: &mut Coupled<'_>, t: f64, y: &[f64], (index, by): (usize, f64)) -> Vec<f64> {
    let (up, down) = (moved(system, t, y, (index, by)), moved(system, t, y, (index, -by)));
    up.iter().zip(&down).map(|(up, down)| (up - down) / (2.0 * by)).collect()
}

/// What contacts and springs add, all else of the rates (gas, friction, return spring) is softer by three orders.
#[test]
fn matrices_are_the_slopes_of_the_rates() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/paper_rig.toml");
    let settings = ["solver.guide=tied", "solver.modes=condensed", "duration_s=0.5"].map(str::to_owned);
    let study = Study::load(&path).unwrap().with_overrides(&settings).unwrap();
    let source = SourceModel::read(study.structure()).unwrap();
    let points = source.points();
    let machine = Machine::new(source, study.structure(), &study.interface_demand()).unwrap();
    let scene = study.scene(0, &points).unwrap();
    let model = build(&scene, &machine.modes(&scene).unwrap()).unwrap();
    let mut system = Coupled::new(&model);
    let settings = Settings {
        tolerance: 1e-5,
        first_step_s: 1e-6,
        longest_step_s: 1e-3,
        max_steps: 1_000_000,
        max_wall_time_s: 600.0,
    };
    let mut integrator = Integrator::new(&system, 0.0, model.initial_state(), settings);
    let block = system.stiff_block().expect("tied, condensed and linear");
    let (b, width) = (block.bodies, block.integrals.1);
    let mut matrices = StiffMatrices {
        stiffness: DMatrix::zeros(b, b),
        damping: DMatrix::zeros(b, b),
        integrated_stiffness: DMatrix::zeros(width, b),
        integrated_damping: DMatrix::zeros(width, b),
    };
    let (mut joined, mut relaxing) = (0, 0);
    for instant in 1..=40 {
        let t = 0.01 * f64::from(instant);
        assert_eq!(integrator.run(&mut system, &mut (), t), Stopped::AtEnd);
        let y = integrator.state().to_vec();
        system.stiff_matrices(&mut matrices);
        let largest = [&matrices.stiffness, &matrices.damping].map(|matrix| matrix.amax());
        let rest = [&matrices.integrated_stiffness, &matrices.integrated_damping].map(|matrix| matrix.amax());
        joined += usize::from(largest[0] > 1e8);
        for body in 0..b {
            let positions = slope(&mut system, t, &y, (block.positions + body, 1e-9));
            let velocities = slope(&mut system, t, &y, (block.velocities + body, 1e-5));
            for other in 0..b {
                let at = block.velocities + other;
                let (k, c) = (-matrices.stiffness[(other, body)], -matrices.damping[(other, body)]);
                assert!((positions[at] - k).abs() < 1e-3 * largest[0].max(1e8), "{t}: {} and {k}", positions[at]);
                // Friction at rest is not in the matrices: of the cylinder 40 N over 0.01 m/s on 6.5 kg, within it far less.
                let friction = if (body, other) == (CYLINDER, CYLINDER) { 650.0 } else { 60.0 };
                let bound = 2e-3 * largest[1].max(1e3) + friction;
                assert!((velocities[at] - c).abs() < bound, "{t}: {} and {c}", velocities[at]);
            }
            for point in 0..width {
                let at = block.integrals.0 + point;
                let (k, c) = (matrices.integrated_stiffness[(point, body)], matrices.integrated_damping[(point, body)]);
                assert!((positions[at] - k).abs() < 2e-3 * rest[0].max(3e7), "{t}: {} and {k}", positions[at]);
                let friction = if body == CYLINDER { 4200.0 } else { 100.0 };
                let bound = 2e-3 * rest[1].max(4e3) + friction;
                assert!((velocities[at] - c).abs() < bound, "{t}: {} and {c}", velocities[at]);
            }
        }
        let (from, count) = block.relaxing;
        let mut lambda = vec![0.0; count];
        system.relaxation(t, &y, &mut lambda);
        for (chamber, lambda) in lambda.iter().enumerate().filter(|(_, lambda)| **lambda > 0.0) {
            let index = from + chamber;
            let found = -slope(&mut system, t, &y, (index, 1e-3))[index];
            // The slope holds the adiabatic part, -a V'/V, as well.
            assert!((found / lambda - 1.0).abs() < 1e-2, "{t}, chamber {chamber}: {found} and {lambda}");
            relaxing += 1;
        }
    }
    println!("{joined} states with hard contacts, {relaxing} relaxing chambers");
    assert!(joined > 10 && relaxing > 10);
}

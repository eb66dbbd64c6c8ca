//! The coupled system against closed forms and against its own invariants.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::common::harness::{assert_close, assert_relative, bisect, distance, observe, run, settings, slope};
use crate::common::scenes::{MOUNT, bench, casting, castings_only, hammer, rig, shapes, simulate, solver, support};
use decore_model::hammer::{HammerParameters, body};
use decore_model::integrate::{Stopped, System};
use decore_model::run::{RowStatus, run_row};
use decore_model::scene::{Guide, ModeTreatment, Owner, PointId, Scene};
use decore_model::system::{Coupled, CoupledModel, InterfaceModes, build};
use nalgebra::{DMatrix, Matrix2, SymmetricEigen};
use proptest::strategy::Strategy;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

/// A casting on its fixture over a structure of four modes: a mass mounted by a spring.
fn mounted_mass(stiffness: f64) -> (Arc<CoupledModel>, [f64; 4], [f64; 4]) {
    let omega = [120.0, 310.0, 555.0, 1300.0];
    let phi = [0.35, -0.22, 0.41, 0.1];
    let scene = castings_only(vec![casting("part", &[(stiffness, 0.0)])]);
    let modes =
        InterfaceModes { omega_rad_s: omega.to_vec(), damping_ratio: vec![0.0; 4], shapes: shapes([], [phi.to_vec()]) };
    (build(&scene, &modes).expect("sound"), omega, phi)
}

/// Stiffness over mass, symmetric: minus the acceleration per displacement, scaled by the roots of the masses.
fn scaled_stiffness(model: &Arc<CoupledModel>, masses: &[f64]) -> DMatrix<f64> {
    let n = model.layout().velocities();
    let mut system = Coupled::new(model);
    let mut matrix = DMatrix::zeros(n, n);
    let (mut y, mut rate) = (vec![0.0; system.dimension()], vec![0.0; system.dimension()]);
    for column in 0..n {
        y.fill(0.0);
        y[column] = 1.0;
        system.rhs(0.0, &y, &mut rate);
        for row in 0..n {
            matrix[(row, column)] = -rate[n + row] * (masses[row] / masses[column]).sqrt();
        }
    }
    matrix
}

/// Frequencies of a structure with a spring-mounted mass: `sum phi_i^2/(w_i^2 - w^2) + 1/k - 1/(w^2 m) = 0`, one root between
/// each two poles. The linearised system's eigenvalues are these roots, and its free vibration has their periods.
#[test]
fn analytic_structure_with_spring_mounted_mass() {
    for stiffness in [1e3, 5e4, 3e7] {
        let (model, omega, phi) = mounted_mass(stiffness);
        let mass = 0.517;
        let characteristic = |w: f64| {
            let sum: f64 = omega.iter().zip(&phi).map(|(wi, p)| p * p / (wi * wi - w * w)).sum();
            sum + 1.0 / stiffness - 1.0 / (w * w * mass)
        };
        let mut poles = vec![1e-3];
        poles.extend(omega);
        poles.push(1e5);
        let mut roots: Vec<f64> = poles
            .windows(2)
            .map(|pair| bisect(pair[0] * (1.0 + 1e-14), pair[1] * (1.0 - 1e-14), characteristic))
            .collect();
        roots.sort_by(f64::total_cmp);
        let matrix = scaled_stiffness(&model, &[1.0, 1.0, 1.0, 1.0, mass]);
        assert!((&matrix - matrix.transpose()).amax() < 1e-12 * matrix.amax(), "reciprocity of the assembled system");
        let eigen = SymmetricEigen::new(matrix);
        let mut frequencies: Vec<f64> = eigen.eigenvalues.iter().map(|value| value.sqrt()).collect();
        frequencies.sort_by(f64::total_cmp);
        for (found, root) in frequencies.iter().zip(&roots) {
            // Rounding of the largest eigenvalue, 6e7, against the square of the root.
            assert_relative("frequency", *found, *root, 1e-7);
        }
        println!("k {stiffness}: {roots:?}");
        let first = eigen.eigenvalues.imin();
        let shape = eigen.eigenvectors.column(first);
        let mut y0 = model.initial_state().to_vec();
        for s in 0..4 {
            y0[s] = 1e-2 * shape[s];
        }
        y0[4] = 1e-2 * shape[4] / f64::sqrt(mass);
        let period = 2.0 * PI / roots[0];
        let run = simulate(&model, &y0, (1e-6, 1e-2), period);
        // One period later everything is back; half a per mille of the amplitude would be a frequency off by 1e-4.
        assert!(distance(&run.y[..5], &y0[..5]) < 1e-8, "{:e}", distance(&run.y[..5], &y0[..5]));
    }
}

/// Chain of three masses and four springs between walls, all 1, a step force of 1 on the first: u2(80 s) = 0.417002 without
/// damping (Code_Aster SDLD102 with its damping taken out). The first two masses are the structure, the third is a casting
/// with one fixture to the second mass and one to the wall. A step from rest is free vibration about the static solution.
#[test]
fn analytic_chain_under_a_step_force() {
    let eigen = SymmetricEigen::new(Matrix2::<f64>::new(2.0, -1.0, -1.0, 1.0));
    let shape = |node: usize| vec![eigen.eigenvectors[(node, 0)], eigen.eigenvectors[(node, 1)]];
    let mut third = casting("third", &[(1.0, 0.0), (1.0, 0.0)]);
    third.mass_kg = 1.0;
    let modes = InterfaceModes {
        omega_rad_s: eigen.eigenvalues.iter().map(|value: &f64| value.sqrt()).collect(),
        damping_ratio: vec![0.0; 2],
        shapes: shapes([], [shape(1), vec![0.0; 2]]),
    };
    let model = build(&castings_only(vec![third]), &modes).expect("sound");
    let static_solution = [0.75, 0.5, 0.25];
    let mut y0 = model.initial_state().to_vec();
    for (s, modal) in y0.iter_mut().enumerate().take(2) {
        *modal = -(shape(0)[s] * static_solution[0] + shape(1)[s] * static_solution[1]);
    }
    y0[2] = -static_solution[2];
    let run = simulate(&model, &y0, (1e-5, 1.0), 80.0);
    let second = static_solution[1] + shape(1)[0] * run.y[0] + shape(1)[1] * run.y[1];
    // The chain's own modes: w_j = 2 sin(j pi / 8), shapes sin(i j pi / 4), norm 2.
    let exact: f64 = (1..=3)
        .map(|j| {
            let j = f64::from(j);
            let w = 2.0 * (j * PI / 8.0).sin();
            0.5 * (j * PI / 4.0).sin() * (j * PI / 2.0).sin() / (w * w) * (1.0 - (80.0 * w).cos())
        })
        .sum();
    println!("u2(80 s) = {second}, exact {exact}");
    assert_close("published", second, 0.417_002, 1e-6);
    // Scale 1e-4 m times tolerance 1e-5 per step, some thousand steps.
    assert_close("exact", second, exact, 1e-7);
}

/// An impulse at the mount moves the fixture as the same impulse at the fixture moves the mount, with the casting, the
/// dampers and the guide (tied or on its spring) in between.
#[test]
fn analytic_reciprocity() {
    for guide in [Guide::Spring, Guide::Tied] {
        let (mut scene, _) = bench();
        let (_, modes) = rig(1);
        scene.castings = vec![casting("part", &[(3e5, 40.0)])];
        scene.hammers[0].parameters.guide.stiffness_n_per_m = 1e7;
        scene.solver.guide = guide;
        let model = build(&scene, &modes).expect("sound");
        let (mount, fixture) = (&modes.shapes[&MOUNT], &modes.shapes[&support(0, 0)]);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        // Velocity after an impulse along `row`: the tied guide takes its share at once.
        let tied_mass = if guide == Guide::Tied { scene.hammers[0].parameters.guide.mass_kg } else { 0.0 };
        let response = |row: &[f64], point: PointId, end: f64| {
            let share = tied_mass * dot(mount, row) / (1.0 + tied_mass * dot(mount, mount));
            let mut y0 = model.initial_state().to_vec();
            for s in model.layout().flexible_displacements() {
                y0[model.layout().flexible_velocities().start + s] = row[s] - share * mount[s];
            }
            let run = simulate(&model, &y0, (1e-7, 1e-3), end);
            assert_eq!(run.stopped, Stopped::AtEnd);
            Coupled::new(&model).motion(point, end, &run.y).1
        };
        for end in [0.003, 0.011, 0.05] {
            let (there, back) = (response(mount, support(0, 0), end), response(fixture, MOUNT, end));
            println!("{guide:?} at {end}: {there} and {back}");
            assert!((there - back).abs() < 1e-6 * dot(mount, mount).max(dot(fixture, fixture)), "{there} and {back}");
            assert!(there.abs() > 1e-4, "nothing moved");
        }
    }
}

/// A hammer more is rows more: the number of entries grows by the same amount each time, no row has more than four, and the
/// rows of the hammers before it stay what they were.
#[test]
fn a_hammer_more_adds_rows_only() {
    for guide in [Guide::Spring, Guide::Tied] {
        let built: Vec<Arc<CoupledModel>> = (1..=6)
            .map(|count| {
                let (mut scene, modes) = rig(count);
                scene.solver.guide = guide;
                build(&scene, &modes).expect("sound")
            })
            .collect();
        let entries: Vec<usize> = built.iter().map(|model| model.elements().matrix().nnz()).collect();
        println!("{guide:?}: {entries:?}");
        assert!(entries.windows(3).all(|three| three[2] + three[0] == 2 * three[1]), "{entries:?}");
        let first = hammer_rows(&built[0]);
        for model in &built {
            assert_eq!(hammer_rows(model), first);
            let elements = model.elements();
            assert!((0..elements.matrix().rows()).all(|row| elements.row(row).count() <= 4));
        }
    }
}

/// What a point is, independent of how many others there are: a hammer body, the casting, a mount, the fixture.
#[derive(Debug, PartialEq)]
enum Point {
    Body(usize),
    Casting(usize),
    Mount(usize),
    Fixture(usize),
}

/// Entries of the first hammer's rows.
fn hammer_rows(model: &CoupledModel) -> Vec<Vec<(Point, f64)>> {
    let heave = model.points().row(PointId::Centre { casting: 0 })[0].0;
    let is = |column: usize, point: PointId| model.points().row(point) == [(column, 1.0)];
    let name = |column: usize| match column {
        p if is(p, support(0, 0)) => Point::Fixture(0),
        p if p == model.hammers()[0].mount => Point::Mount(0),
        p if p >= heave => Point::Casting(p - heave),
        p => Point::Body(p),
    };
    let elements = model.elements();
    let of_first = |owner| matches!(owner, Owner::Hammer { hammer: 0, .. });
    let own = elements.contacts().iter().enumerate().filter(|(_, contact)| of_first(contact.owner));
    let entries = |row: usize| {
        let mut entries: Vec<(Point, f64)> = elements.row(row).map(|(point, c)| (name(point), c)).collect();
        entries.sort_by(|a, b| format!("{:?}", a.0).cmp(&format!("{:?}", b.0)));
        entries
    };
    own.map(|(index, _)| entries(elements.contact_row(index))).collect()
}

/// The guide on an ever stiffer spring tends to the tied guide; the differences of the first impact fall as the spring's
/// compliance does.
#[test]
fn analytic_stiff_guide_tends_to_the_tied_one() {
    let impact = |guide: Guide, stiffness: f64| {
        let (mut scene, modes) = rig(1);
        scene.solver = solver(guide);
        scene.solver.tolerance = 1e-7;
        scene.hammers[0].parameters.guide.stiffness_n_per_m = stiffness;
        scene.duration_s = 0.06;
        let metrics = run_row(&scene, &modes).metrics.expect("done");
        let hammer = &metrics.hammers[0];
        [hammer.first_impact_energy_j.expect("an impact"), hammer.first_impact_time_s.expect("an impact")]
    };
    let tied = impact(Guide::Tied, 1e10);
    let differences = [1e8, 1e9, 1e10].map(|stiffness| {
        let spring = impact(Guide::Spring, stiffness);
        let [energy, time] = [0, 1].map(|i| (spring[i] / tied[i] - 1.0).abs());
        println!("{stiffness:e} N/m: energy {energy:.2e}, time {time:.2e}");
        (stiffness, energy, time)
    });
    let order = slope(&differences.map(|(stiffness, _, time)| (stiffness, time)));
    println!("time difference ~ stiffness^{order:.3}");
    assert!((order + 1.0).abs() < 0.05, "difference of the impact time ~ stiffness^{order}");
    // At the default stiffness: what tying costs.
    let (_, energy, time) = differences[2];
    assert!(energy < 2e-6 && time < 4e-6);
}

/// Condensed modes give what integrated modes give: the same contacts, the same outputs to well below the tolerance of the
/// studies, with the guide on its spring or tied, one hammer or two on a rail (which amplify what differs).
#[test]
fn condensed_modes_are_the_integrated_ones() {
    for (hammers, guide, duration) in [(1, Guide::Spring, 0.12), (1, Guide::Tied, 0.25), (2, Guide::Tied, 0.1)] {
        let outcome = |modes: ModeTreatment| {
            let (mut scene, shapes) = rig(hammers);
            scene.solver = solver(guide);
            scene.solver.modes = modes;
            scene.solver.tolerance = 1e-8;
            scene.duration_s = duration;
            run_row(&scene, &shapes)
        };
        let (integrated, condensed) = (outcome(ModeTreatment::Integrated), outcome(ModeTreatment::Condensed));
        assert_ne!(integrated.states, condensed.states);
        let (a, b) = (integrated.metrics.expect("done"), condensed.metrics.expect("done"));
        let value = |value: Option<f64>| value.expect("an impact");
        for (a, b) in a.hammers.iter().zip(&b.hammers) {
            assert_eq!(a.contact_count, b.contact_count);
            assert_relative("energy", value(b.first_impact_energy_j), value(a.first_impact_energy_j), 1e-8);
            assert_relative("impulse", value(b.first_impact_impulse_n_s), value(a.first_impact_impulse_n_s), 1e-6);
            assert_relative("arm", value(b.arm_rms_hammering_m_s), value(a.arm_rms_hammering_m_s), 1e-5);
        }
        assert_relative("casting", b.castings[0].peak_velocity_m_s, a.castings[0].peak_velocity_m_s, 1e-6);
        println!(
            "{hammers} hammers, {guide:?}: residuals {:.1e} and {:.1e}",
            a.totals.energy_residual, b.totals.energy_residual
        );
        assert!(b.totals.energy_residual.abs() < 1e-5, "{}", b.totals.energy_residual);
    }
}

/// Whole runs of random scenes through first impact and the first blows: the audit closes. What is put in by gas and
/// gravity is stored or dissipated; nothing is gained in contacts. 1e-5 at tolerance 1e-6 (0.1 % is what a study promises).
#[test]
fn energy_is_accounted_for_in_random_scenes() {
    let config = Config { cases: 12, failure_persistence: None, ..Config::default() };
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &[7; 32]);
    let mut runner = TestRunner::new_with_rng(config, rng);
    let supply = 3.0..7.0f64;
    let strategy = (1..=2usize, supply, 0.01..0.11f64, 0.3..5.0f64, 0.5..2.0f64, proptest::bool::ANY);
    let worst = std::cell::Cell::new(0.0f64);
    let outcome = runner.run(&strategy.boxed(), |(hammers, bar, standoff, casting_mass, scale, tied)| {
        let (mut scene, modes) = rig(hammers);
        scene.solver = solver(if tied { Guide::Tied } else { Guide::Spring });
        scene.solver.tolerance = 1e-6;
        scene.duration_s = 0.12;
        scene.castings[0].mass_kg = casting_mass;
        for unit in &mut scene.hammers {
            unit.supply_pressure_pa = 101_325.0 + 1e5 * bar;
            unit.standoff_m = standoff;
            unit.parameters.telescope.cylinder_mass_kg *= scale;
            unit.parameters.piston.mass_kg *= scale;
        }
        let outcome = run_row(&scene, &modes);
        assert_eq!(outcome.status, RowStatus::Done, "{}", outcome.reason);
        let metrics = outcome.metrics.expect("done");
        let residual = metrics.totals.energy_residual.abs();
        worst.set(worst.get().max(residual));
        assert!(metrics.hammers[0].contact_count > 0);
        assert!(residual < 1e-5, "energy residual {residual:e}");
        Ok(())
    });
    println!("worst energy residual {:e}", worst.get());
    outcome.expect("every scene's energy is accounted for");
}

/// The residual is a measure of the error: it falls with the tolerance.
#[test]
fn energy_residual_falls_with_the_tolerance() {
    let residual = |tolerance: f64| {
        let (mut scene, modes) = rig(1);
        scene.solver.tolerance = tolerance;
        scene.duration_s = 0.15;
        run_row(&scene, &modes).metrics.expect("done").totals.energy_residual.abs()
    };
    let residuals = [1e-4, 1e-5, 1e-6, 1e-7].map(residual);
    println!("{residuals:?}");
    assert!(residuals[0] < 1e-3 && residuals[3] < 1e-2 * residuals[0], "{residuals:?}");
}

/// A hammer alone on rigid ground, no modes at all: the empty structure is a structure.
#[test]
fn a_structure_without_modes() {
    let (mut scene, modes) = bench();
    scene.environment.gravity_m_s2 = 9.80665;
    scene.hammers = vec![hammer("left", HammerParameters::default())];
    scene.castings = vec![casting("part", &[(3e7, 4000.0)])];
    scene.duration_s = 0.08;
    let outcome = run_row(&scene, &modes);
    assert_eq!(outcome.status, RowStatus::Done, "{}", outcome.reason);
    assert_eq!(outcome.modes, 0);
    let metrics = outcome.metrics.expect("done");
    assert!(metrics.hammers[0].first_impact_energy_j.expect("an impact") > 10.0);
    assert_eq!(metrics.hammers[0].arm_rms_extension_m_s, Some(0.0));
}

/// Two hammers that stand apart on structures of their own do not know of each other: each does what it does alone.
/// The steps are common to both, so they agree to the accuracy of the run, not to the bit.
#[test]
fn analytic_uncoupled_hammers() {
    let (single, modes) = rig(1);
    let mut both = Scene { duration_s: 0.06, ..single.clone() };
    both.solver.tolerance = 1e-8;
    let mut alone = both.clone();
    alone.hammers[0].name = "alone".into();
    both.hammers.push(hammer("second", HammerParameters::default()));
    both.hammers[1].casting = 1;
    both.hammers[1].start_time_s = 0.0045;
    both.castings.push(casting("other", &[(3e7, 4000.0)]));
    let count = modes.omega_rad_s.len();
    let before = |row: &[f64]| row.iter().copied().chain(vec![0.0; count]).collect::<Vec<f64>>();
    let behind = |row: &[f64]| vec![0.0; count].into_iter().chain(row.iter().copied()).collect::<Vec<f64>>();
    let twice = |values: &[f64]| values.iter().chain(values).copied().collect::<Vec<f64>>();
    let [mount, fixture] = [MOUNT, support(0, 0)].map(|point| &modes.shapes[&point]);
    let mut double = shapes([before(mount), behind(mount)], [before(fixture)]);
    double.insert(support(1, 0), behind(fixture));
    let double = InterfaceModes {
        omega_rad_s: twice(&modes.omega_rad_s),
        damping_ratio: twice(&modes.damping_ratio),
        shapes: double,
    };
    let one = run_row(&alone, &modes).metrics.expect("done");
    let two = run_row(&both, &double).metrics.expect("done");
    let energy = |metrics: &decore_model::metrics::RunMetrics, h: usize| {
        metrics.hammers[h].first_impact_energy_j.expect("impact")
    };
    let time =
        |metrics: &decore_model::metrics::RunMetrics, h: usize| metrics.hammers[h].first_impact_time_s.expect("impact");
    println!("{} {} {}", energy(&one, 0), energy(&two, 0), energy(&two, 1));
    assert_relative("energy of the first", energy(&two, 0), energy(&one, 0), 1e-6);
    assert_relative("energy of the second", energy(&two, 1), energy(&one, 0), 1e-3);
    assert_relative("time of the first", time(&two, 0), time(&one, 0), 1e-7);
}

/// The same run twice, and with an observer more: the same bits.
#[test]
fn runs_are_reproducible_to_the_bit() {
    let (scene, modes) = rig(2);
    let model = build(&scene, &modes).expect("sound");
    let once = run(&mut Coupled::new(&model), model.initial_state(), settings(1e-5, 1e-3), 0.08);
    let mut samples = crate::common::harness::Samples::new(2);
    let again = observe(&mut Coupled::new(&model), model.initial_state(), settings(1e-5, 1e-3), 0.08, &mut samples);
    assert_eq!(once.y, again.y);
    assert_eq!(once.events, again.events);
    assert_eq!(once.counters, again.counters);
}

/// A chamber that vanishes is called by its name, and its hammer by that of the study.
#[test]
fn a_chamber_that_vanishes_is_named() {
    let (scene, modes) = bench();
    let model = build(&scene, &modes).expect("sound");
    let mut state = model.initial_state().to_vec();
    state[model.layout().position(model.hammers()[0].points[body::CYLINDER])] += 1.0;
    let words = Coupled::new(&model).diagnose(0.25, &state);
    let hammer = &scene.hammers[0].name;
    let expected = format!("the chamber at the annulus of the telescope of hammer `{hammer}` is driven to a volume of");
    assert!(words.starts_with(&expected), "{words}");
}

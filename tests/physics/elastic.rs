//! Elastic castings in the coupled system: the rigid limit, a rod struck by a mass, energy with a residual flexibility.

use std::f64::consts::PI;
use std::sync::Arc;

use decore_model::contact::kelvin_voigt;
use decore_model::hammer::body;
use decore_model::metrics::{Recorder, RunMetrics};
use decore_model::run::{RowJob, RowStatus};
use decore_model::scene::{FixtureId, HammerLink, PartId, PointId, Scene};
use decore_model::system::{Coupled, CoupledModel, InterfaceModes, PlacedModes, Residual, build_placed};
use decore_model::workpiece::{CorePoint, Elastic, Fixture};
use nalgebra::DMatrix;

use crate::common::harness::{assert_relative, observe, settings, switches};
use crate::common::scenes::{bench, clear, contact_index, place, rig, support};
use crate::ledger::missing_in_fixtures;
use crate::one_sided::assert_supports;

const STRIKE: PointId = PointId::Strike { hammer: 0 };
const HELD: PointId = PointId::Held(FixtureId { casting: 0, fixture: 0, axis: 0 });

/// Modes of a casting at its points: `row` gives those of a point at a share of its height, 0 at the top and 1 at the bottom; `centre` those
/// of its mean motion.
fn casting(
    (omega_rad_s, ratio): (Vec<f64>, f64),
    row: impl Fn(f64) -> Vec<f64>,
    centre: Vec<f64>,
    residual: [[f64; 2]; 2],
) -> PlacedModes {
    let still = vec![0.0; omega_rad_s.len()];
    let rotation = |axis: usize| (PointId::Rotation { casting: 0, axis }, still.clone());
    let shapes = [
        (STRIKE, row(0.0)),
        (HELD, row(1.0)),
        (PointId::Centre { casting: 0 }, centre),
        (PointId::Measured { casting: 0 }, row(1.0)),
        rotation(0),
        rotation(1),
    ];
    let damping_ratio = vec![ratio; omega_rad_s.len()];
    let interface = InterfaceModes { omega_rad_s, damping_ratio, shapes: shapes.into() };
    let flexibility = DMatrix::from_fn(2, 2, |i, j| residual[i][j]);
    let local = flexibility.diagonal().iter().copied().collect();
    PlacedModes::from(interface).with_residual(Residual { flexibility, watched: DMatrix::zeros(4, 2), local })
}

fn elastic(scene: &mut Scene, contact_includes_casting: bool) {
    scene.castings[0].elastic = Some(Elastic { contact_includes_casting });
}

/// A casting of its rigid mode and perhaps one in which its ends move against each other, with a residual flexibility.
fn two_modes(mass_kg: f64, elastic_hz: Option<f64>, residual: [[f64; 2]; 2]) -> PlacedModes {
    let omega = [0.0].into_iter().chain(elastic_hz.map(|hz| 2.0 * PI * hz)).collect::<Vec<f64>>();
    let rigid = 1.0 / mass_kg.sqrt();
    let row = |at: f64| [rigid, rigid * (1.0 - 2.0 * at)][..omega.len()].to_vec();
    let centre = [rigid, 0.0][..omega.len()].to_vec();
    casting((omega.clone(), 0.002), row, centre, residual)
}

/// Figures of a run of the rig; the audit must hold.
fn figures(casting: Option<PlacedModes>) -> Vec<f64> {
    let (mut scene, modes) = rig(1);
    scene.duration_s = 0.15;
    scene.solver.tolerance = 1e-7;
    let mut placed = PlacedModes::from(modes);
    if let Some(casting) = casting {
        elastic(&mut scene, true);
        placed = placed.with_casting(0, casting);
    }
    let outcome = RowJob::new(scene, Arc::new(placed), 0).run();
    assert_eq!(outcome.status, RowStatus::Done, "{}", outcome.reason);
    let metrics = outcome.metrics.unwrap();
    assert!(metrics.totals.energy_residual.abs() < 1e-5, "{:e}", metrics.totals.energy_residual);
    let (hammer, casting) = (&metrics.hammers[0], &metrics.castings[0]);
    let spent = casting.fixture_damper_loss_j
        + casting.fixture_spring_energy_j
        + casting.structure_work_j
        + casting.kinetic_energy_j
        + casting.strike_contact_loss_j;
    vec![
        hammer.first_impact_energy_j.unwrap(),
        hammer.first_impact_work_j.unwrap(),
        hammer.first_impact_casting_peak_velocity_m_s.unwrap(),
        casting.peak_velocity_m_s,
        casting.peak_point_velocity_m_s,
        spent,
    ]
}

/// A casting with its rigid mode alone is the rigid casting. A stiff one tends to it, be it by a fast mode or by a residual flexibility; a
/// soft one does not.
#[test]
fn analytic_rigid_limit() {
    let mass_kg = rig(1).0.castings[0].mass_kg;
    let rigid = figures(None);
    let compare = |what: &str, modes: PlacedModes, bound: f64| {
        let found = figures(Some(modes));
        println!("{what}: {found:?} instead of {rigid:?}");
        found.iter().zip(&rigid).for_each(|(found, rigid)| assert_relative(what, *found, *rigid, bound));
    };
    compare("rigid mode", two_modes(mass_kg, None, [[0.0; 2]; 2]), 1e-5);
    compare("residual of a stiff casting", two_modes(mass_kg, None, [[1e-15, -3e-16], [-3e-16, 2e-15]]), 1e-5);
    compare("mode at 300 kHz", two_modes(mass_kg, Some(3e5), [[0.0; 2]; 2]), 0.02);
    let soft = figures(Some(two_modes(mass_kg, Some(3000.0), [[0.0; 2]; 2])));
    assert!((soft[3] / rigid[3] - 1.0).abs() > 0.1, "{soft:?}");
    // A residual flexibility that couples contact and fixture keeps the audit.
    let coupled = figures(Some(two_modes(mass_kg, Some(9000.0), [[8e-10, -4e-10], [-4e-10, 9e-10]])));
    assert!((coupled[0] / rigid[0] - 1.0).abs() < 1e-4);
}

/// Spectrum of a core point of a casting with a rigid mode and a fast one. The fast mode is kept, or replaced by its static flexibility
/// at the points where forces act and, if `watched`, at the core point.
fn core_spectrum(kept: bool, watched: bool) -> Vec<f64> {
    let core = PointId::Core { casting: 0, core: 0 };
    let (mut scene, modes) = rig(1);
    scene.duration_s = 0.06;
    scene.outputs.core_spectra = true;
    scene.castings[0].cores = vec![CorePoint { name: "core".into(), ..CorePoint::default() }];
    elastic(&mut scene, false);
    let mass_kg = scene.castings[0].mass_kg;
    let omega = 2.0 * PI * 2e5;
    let rigid = 1.0 / mass_kg.sqrt();
    let (top, bottom, middle) = (2.0 * rigid, -0.5 * rigid, 10.0 * rigid);
    let per_n = |one: f64, other: f64| if kept { 0.0 } else { one * other / omega.powi(2) };
    let mut casting = casting(
        (if kept { vec![0.0, omega] } else { vec![0.0] }, 0.02),
        |at| if kept { vec![rigid, if at == 0.0 { top } else { bottom }] } else { vec![rigid] },
        if kept { vec![rigid, 0.0] } else { vec![rigid] },
        [[per_n(top, top), per_n(top, bottom)], [per_n(top, bottom), per_n(bottom, bottom)]],
    );
    let mut interface = InterfaceModes::clone(&casting);
    interface.shapes.insert(core, if kept { vec![rigid, middle] } else { vec![rigid] });
    let points: Vec<PointId> = interface.shapes.keys().copied().filter(|id| ![STRIKE, HELD].contains(id)).collect();
    let mut flexibility = DMatrix::zeros(points.len(), 2);
    if watched && let Some(place) = points.iter().position(|id| *id == core) {
        flexibility[(place, 0)] = per_n(middle, top);
        flexibility[(place, 1)] = per_n(middle, bottom);
    }
    let all = DMatrix::from_fn(2, 2, |i, j| per_n([top, bottom][i], [top, bottom][j]));
    let local = all.diagonal().iter().copied().collect();
    casting = PlacedModes::from(interface).with_residual(Residual { flexibility: all, watched: flexibility, local });
    let placed = PlacedModes::from(modes).with_casting(0, casting);
    let outcome = RowJob::new(scene, Arc::new(placed), 0).run();
    assert_eq!(outcome.status, RowStatus::Done, "{}", outcome.reason);
    outcome.metrics.unwrap().cores[0].spectrum.clone().unwrap().pseudo_velocity_m_s
}

/// The oscillators on a core point see the static deflection of modes that are left out.
#[test]
fn core_points_follow_the_residual_flexibility() {
    let (all, with, without) = (core_spectrum(true, false), core_spectrum(false, true), core_spectrum(false, false));
    let worst = |of: &[f64]| of.iter().zip(&all).map(|(one, all)| (one / all - 1.0).abs()).fold(0.0, f64::max);
    println!("with {:e}, without {:e}", worst(&with), worst(&without));
    assert!(worst(&with) < 1e-3, "{with:?} {all:?}");
    assert!(worst(&without) > 8e-3, "{without:?} {all:?}");
}

/// Residual flexibility of strike and pad. Between contacts it is left out: here it is small.
const BETWEEN: [[f64; 2]; 2] = [[8e-10, -4e-11], [-4e-11, 9e-10]];

/// Outputs of the rig with an elastic casting on its fixture, or on a pad and under a clamp of a force and a stiffness.
fn clamped(clamp: Option<(f64, f64)>) -> RunMetrics {
    let (mut scene, mut modes) = rig(1);
    scene.duration_s = 0.15;
    elastic(&mut scene, true);
    let mut casting = two_modes(scene.castings[0].mass_kg, Some(9000.0), BETWEEN);
    scene.outputs.fixture_energy = true;
    if let Some((clamp_force_n, clamp_stiffness_n_per_m)) = clamp {
        let fixtures = &mut scene.castings[0].fixtures;
        let clamp = Fixture { clamp_force_n, clamp_stiffness_n_per_m, ..fixtures[0].clone() };
        fixtures[0].one_sided = true;
        fixtures.push(clamp);
        modes.shapes.insert(support(0, 1), modes.shapes[&support(0, 0)].clone());
        let mut interface = InterfaceModes::clone(&casting);
        let clamped = PointId::Held(FixtureId { casting: 0, fixture: 1, axis: 0 });
        interface.shapes.insert(clamped, interface.shapes[&HELD].clone());
        // The clamp's point is that of the pad.
        let of = |point: usize| point.min(1);
        let flexibility = DMatrix::from_fn(3, 3, |i, j| BETWEEN[of(i)][of(j)]);
        let local = flexibility.diagonal().iter().copied().collect();
        let residual = Residual { flexibility, watched: DMatrix::zeros(4, 3), local };
        casting = PlacedModes::from(interface).with_residual(residual);
    }
    assert_eq!(scene.validate(), []);
    let placed = PlacedModes::from(modes).with_casting(0, casting);
    let outcome = RowJob::new(scene, Arc::new(placed), 0).run();
    assert_eq!(outcome.status, RowStatus::Done, "{}", outcome.reason);
    outcome.metrics.unwrap()
}

/// Pads under an elastic casting do what they do under a rigid one. The bound is wider: the residual flexibility between contacts is left out.
#[test]
fn elastic_castings_lie_on_pads() {
    assert_supports([None, Some((1e6, 0.0)), Some((50.0, 0.0))].map(clamped), 2e-3);
}

/// The residual flexibility passes the force of a chisel or pad on to a clamp with a spring; the books of casting and fixtures know that.
#[test]
fn energies_through_fixtures_of_elastic_castings_sum_up() {
    for clamp in [None, Some((1e6, 0.0)), Some((1e4, 2e7))] {
        let metrics = clamped(clamp);
        let missing = missing_in_fixtures(&metrics, &[metrics.fixtures.len()]);
        println!("{clamp:?}: {missing:.1e} of the delivered work is missing");
        assert!(
            metrics.fixtures.len() == 1 + usize::from(clamp.is_some()) && missing < 1e-10,
            "{clamp:?}: {missing:e}"
        );
    }
}

/// A scene of the bench whose chisel flies at 1 m/s, so far off the casting.
fn aimed(scene: &Scene, placed: &PlacedModes, distance_m: f64) -> (Arc<CoupledModel>, Vec<f64>) {
    let model = build_placed(scene, placed).unwrap();
    let mut y0 = clear(&model);
    let at = Coupled::new(&model).hammer_state(0, 0.0, &y0).position;
    for (index, position) in at.into_iter().enumerate().skip(body::CYLINDER) {
        place(&model, &mut y0, index, (position + 0.005, 0.0));
    }
    // The casting's face stands where the chisel's tip rests.
    let face = Coupled::new(&model).hammer_state(0, 0.0, model.initial_state()).position[body::CHISEL];
    place(&model, &mut y0, body::CHISEL, (face - distance_m, 1.0));
    (model, y0)
}

/// Outputs of one impact of the chisel on a free casting of 2 kg without damping, some time after the start.
fn struck_once(elastic_hz: Option<f64>, residual: f64, end_s: f64) -> RunMetrics {
    let mut interface = InterfaceModes::clone(&two_modes(2.0, elastic_hz, [[0.0; 2]; 2]));
    interface.damping_ratio.fill(0.0);
    let flexibility = DMatrix::from_fn(2, 2, |i, j| if i + j == 0 { residual } else { 0.0 });
    let residual = Residual { flexibility, watched: DMatrix::zeros(4, 2), local: vec![0.0; 2] };
    let modes = PlacedModes::from(interface).with_residual(residual);
    let (mut scene, machine) = bench();
    scene.castings[0].mass_kg = 2.0;
    scene.hammers[0].parameters.chisel.casting_contact = kelvin_voigt(1e8, 0.0);
    (scene.hammers[0].standoff_m, scene.hammers[0].start_time_s) = (0.0, 0.001);
    elastic(&mut scene, false);
    let placed = PlacedModes::from(machine).with_casting(0, modes);
    let (model, y0) = aimed(&scene, &placed, 0.0015);
    let mut system = Coupled::new(&model);
    let mut recorder = Recorder::new(&model, &scene);
    let run = observe(&mut system, &y0, settings(1e-9, 1e-4), end_s, &mut recorder);
    recorder.finish(&system, run.t, &run.y)
}

/// An impact on a free casting: what it gives beyond the motion of the centre of mass becomes strain of an undamped mode; at the end of the
/// blow's window, all that is not kinetic. Without modes the strain is `R F^2 / 2`, largest with the force.
#[test]
fn analytic_strain_energy_of_an_impact() {
    let metrics = struck_once(Some(800.0), 0.0, 0.008);
    let (work_j, impulse_n_s) = (metrics.castings[0].delivered_work_j, metrics.hammers[0].delivered_impulse_n_s);
    let peak_j = metrics.elastic[0].peak_strain_energy_j;
    assert_relative("largest", peak_j, work_j - impulse_n_s * impulse_n_s / (2.0 * 2.0), 1e-6);
    let start_s = metrics.blows[0].start_time_s;
    let at_end = struck_once(Some(800.0), 0.0, start_s + 0.005 + 1e-10);
    let casting = &at_end.castings[0];
    let found_j = at_end.blows[0].strain.as_ref().unwrap().casting_strain_energy_j;
    // The work is an integral outside the error control: its error is relative to the whole work.
    let rest_j = casting.delivered_work_j - casting.kinetic_energy_j;
    assert!((found_j - rest_j).abs() < 1e-6 * casting.delivered_work_j, "{found_j} instead of {rest_j}");
    assert_eq!(at_end.elastic[0].first_impact_strain_energy_j, Some(found_j));
    assert!(at_end.elastic[0].periodic_strain_energy_mean_j.is_none());

    let residual = 2e-9;
    let metrics = struck_once(None, residual, 0.008);
    let force_n = metrics.hammers[0].first_impact_peak_force_n.unwrap();
    let peak_j = metrics.elastic[0].peak_strain_energy_j;
    assert_relative("of the residual", peak_j, 0.5 * residual * force_n * force_n, 1e-6);
    assert!(metrics.blows[0].strain.as_ref().unwrap().casting_strain_energy_j < 1e-9 * peak_j);
}

/// A casting pushed into its fixture by d: the spring takes `F = k d / (1 + k R)` and stores `F^2 / (2 k)`, the casting the rest, `F^2 R / 2`;
/// both together are the stored energy of the audit. A mode under a static load F stores `(phi F)^2 / (2 omega^2)`.
#[test]
fn analytic_strain_energy_at_rest() {
    let (mut scene, machine) = bench();
    let (stiffness, residual, push_m) = (3e7, 4e-9, 1e-4);
    scene.castings[0].mass_kg = 2.0;
    scene.castings[0].fixtures[0].stiffness_n_per_m = stiffness;
    elastic(&mut scene, false);
    let placed = PlacedModes::from(machine);
    let placed = placed.with_casting(0, two_modes(2.0, Some(500.0), [[0.0, 0.0], [0.0, residual]]));
    let model = build_placed(&scene, &placed).unwrap();
    let [held, _] = model.point_sums(HELD).unwrap();
    let mut y = model.initial_state().to_vec();
    // The rigid mode alone moves the held point by `push_m`.
    y[held[0].0] = push_m / held[0].1;
    let system = Coupled::new(&model);
    let casting = PartId::Casting(0);
    let mut forces = vec![0.0; model.elements().matrix().rows()];
    let mut strain_j = |y: &[f64]| system.strain_energy(casting, (0.0, y), &mut forces);
    let force_n = stiffness * push_m / (1.0 + stiffness * residual);
    assert_relative("residual", strain_j(&y), 0.5 * force_n * force_n * residual, 1e-12);
    let stored_j = system.stored_energy(0.0, &y) - system.stored_energy(0.0, model.initial_state());
    assert_relative("both", stored_j, 0.5 * force_n * force_n * (residual + 1.0 / stiffness), 1e-9);
    let (shape, omega) = (held[1].1, 2.0 * PI * 500.0);
    let load_n = 1000.0;
    y[held[1].0] = shape * load_n / (omega * omega);
    y[held[0].0] = -shape * y[held[1].0] / held[0].1;
    assert_relative("mode", strain_j(&y), (shape * load_n / omega).powi(2) / 2.0, 1e-12);
}

/// Time in s for which a mass touches a rod of its own mass, by `count` elastic modes of the rod, without or with the residual
/// flexibility of the others; and the steps taken.
fn touch(count: usize, with_residual: bool) -> (f64, u64) {
    let (length_m, speed_m_s) = (0.17, 5000.0);
    let (mut scene, modes) = bench();
    let mass_kg = scene.hammers[0].parameters.chisel.mass_kg;
    scene.castings[0].mass_kg = mass_kg;
    scene.hammers[0].parameters.chisel.casting_contact = kelvin_voigt(1e9, 0.0);
    scene.hammers[0].standoff_m = 0.0;
    elastic(&mut scene, false);
    let omega: Vec<f64> = (0..=count).map(|s| s as f64 * PI * speed_m_s / length_m).collect();
    let scale = |s: usize| if s == 0 { 1.0 } else { 2.0_f64.sqrt() } / mass_kg.sqrt();
    let row = |at: f64| (0..=count).map(|s| scale(s) * (s as f64 * PI * at).cos()).collect::<Vec<f64>>();
    // Of all modes: L^2 / (3 M c^2) at the struck end, -L^2 / (6 M c^2) between both ends.
    let all = length_m * length_m / (mass_kg * speed_m_s * speed_m_s);
    let kept = |sign: f64| (1..=count).map(|s| 2.0 / mass_kg * sign.powi(s as i32) / omega[s].powi(2)).sum::<f64>();
    let (own, across) = (all / 3.0 - kept(1.0), -all / 6.0 - kept(-1.0));
    let residual = if with_residual { [[own, across], [across, own]] } else { [[0.0; 2]; 2] };
    let centre = (0..=count).map(|s| if s == 0 { scale(0) } else { 0.0 }).collect();
    let placed = PlacedModes::from(modes).with_casting(0, casting((omega.clone(), 0.0), row, centre, residual));
    let (model, y0) = aimed(&scene, &placed, 1e-6);
    let contact = contact_index(&model, HammerLink::ChiselCasting);
    let run = observe(&mut Coupled::new(&model), &y0, settings(1e-9, 1e-3), 150e-6, &mut ());
    let [onset, release] = switches(&run, contact);
    (release - onset, run.counters.steps)
}

/// A mass strikes the end of a free rod (Saint-Venant): with the residual flexibility of the modes left out, few modes give the time in
/// contact; without it they do not. The steps are not shorter for it.
#[test]
fn analytic_rod_struck_by_a_mass() {
    let (exact, _) = touch(400, true);
    for (count, bound) in [(20, 2e-3), (50, 1e-4)] {
        let (found, steps) = touch(count, true);
        let (truncated, plain) = touch(count, false);
        let [error, without] = [found, truncated].map(|time| (time / exact - 1.0).abs());
        println!("{count} modes: off by {error:.1e} in {steps} steps, truncated by {without:.1e} in {plain}");
        assert!(error < bound, "{count} modes: {error:e}");
        assert!(without > 5.0 * error && steps as f64 <= 1.1 * plain as f64, "{without:e}, {steps} and {plain}");
    }
}

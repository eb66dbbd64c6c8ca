//! Hammers, fixtures and gravity in any direction: a scene turned by 90 degrees does the same, and receptances are symmetric.

use std::fs;
use std::path::Path;

use decore_model::metrics::RunMetrics;
use decore_model::run::RowStatus;
use decore_model::scene::{FixtureId, PointId};
use decore_model::structure::{
    ExportFormat, FeModel, InterfacePoint, InterfacePoints, ModelMatrices, PointPlace, write_model,
};
use decore_model::system::LinearModel;
use decore_study::Study;
use decore_study::engine::{Engine, RowRunner};
use nalgebra::{Complex, DMatrix};
use sprs::{CsMat, TriMat};
use tempfile::TempDir;

use crate::solid::block;

/// The axis that each axis becomes, and its sign.
type Turn = [(usize, f64); 3];

const UPRIGHT: Turn = [(0, 1.0), (1, 1.0), (2, 1.0)];
/// 90 degrees about x, y and z.
const ABOUT: [Turn; 3] =
    [[(0, 1.0), (2, 1.0), (1, -1.0)], [(2, -1.0), (1, 1.0), (0, 1.0)], [(1, 1.0), (0, -1.0), (2, 1.0)]];

const STRUCTURE: &str = "[casting.part.structure]\nstiffness_file = \"part/K.mtx\"\nmass_file = \"part/M.mtx\"\n\
     dof_file = \"part/rows.dof\"\nnodes_file = \"part/nodes.csv\"\npoint_radius_m = 0.025\ncutoff_hz = 5000.0\n";

fn turn(by: &Turn, vector: [f64; 3]) -> [f64; 3] {
    let mut turned = [0.0; 3];
    by.iter().zip(vector).for_each(|((axis, sign), value)| turned[*axis] = sign * value);
    turned
}

/// The DOF that a DOF becomes, and the sign of its motion.
fn turned_dof(by: &Turn, dof: usize) -> (usize, f64) {
    let (axis, sign) = by[dof % 3];
    (dof / 3 * 3 + axis, sign)
}

/// Matrices of a model, and its points by the labels of their nodes.
fn labelled(model: &FeModel) -> (ModelMatrices, Vec<InterfacePoint>) {
    let matrices = model.matrices().clone();
    let mut points: Vec<InterfacePoint> = model.points().iter().cloned().collect();
    for point in &mut points {
        let row = model.rows_of(&point.name).unwrap()[0].unwrap();
        point.place = PointPlace::Node { node: matrices.labels[row].node, rotation_node: None };
    }
    (matrices, points)
}

/// A turned model, and its points.
fn turned(by: &Turn, model: &FeModel) -> FeModel {
    let (mut matrices, mut points) = labelled(model);
    let signs: Vec<f64> = matrices.labels.iter().map(|label| turned_dof(by, label.dof).1).collect();
    let flip = |matrix: &CsMat<f64>| {
        let mut flipped = TriMat::new(matrix.shape());
        for (value, (row, column)) in matrix {
            flipped.add_triplet(row, column, signs[row] * signs[column] * value);
        }
        flipped.to_csr()
    };
    (matrices.mass, matrices.stiffness) = (flip(&matrices.mass), flip(&matrices.stiffness));
    matrices.labels.iter_mut().for_each(|label| label.dof = turned_dof(by, label.dof).0);
    points.iter_mut().for_each(|point| point.position_m = turn(by, point.position_m));
    FeModel::new(matrices, InterfacePoints::new(points).unwrap()).unwrap()
}

/// Writes a machine's matrices as `K.mtx`, `M.mtx`, `rows.dof`, `points.csv` into a folder.
fn write_machine(model: &FeModel, folder: &Path) {
    let (matrices, points) = labelled(model);
    let model = FeModel::new(matrices, InterfacePoints::new(points).unwrap()).unwrap();
    let files = write_model(&model, ExportFormat::named("matrix_market").unwrap(), folder).unwrap();
    fs::rename(files.dofs.unwrap(), folder.join("rows.dof")).unwrap();
    fs::rename(files.points, folder.join("points.csv")).unwrap();
}

/// Numbers as a TOML list.
fn list(values: [f64; 3]) -> String {
    format!("[{}, {}, {}]", values[0], values[1], values[2])
}

/// A scene with a vertical hammer and one that strikes along x, on a casting that its fixtures hold in all directions, in a
/// turned world. `structure` makes the casting elastic.
fn study(by: &Turn, structure: &str) -> String {
    let to = |v: [f64; 3]| turn(by, v);
    let place = |key: &str, height: &str, at: [f64; 3]| {
        let [x, y, z] = to(at);
        format!("{key} = [{x}, {y}]\n{height} = {z}\n")
    };
    let down = list(to([0.0, 0.0, -1.0]));
    let hammer = |name: &str, mount: &str, axis: [f64; 3], at: [f64; 3]| {
        let strike = place("strike_point_m", "strike_height_m", at);
        format!("[hammer.{name}]\nmount = \"{mount}\"\nsupply_bar = 5.0\nstrike_axis = {}\n{strike}", list(to(axis)))
    };
    // The axes across a fixture follow each other as x, y and z do.
    let lateral = if by[0].0 < by[1].0 { "[1.2e7, 1.5e7]" } else { "[1.5e7, 1.2e7]" };
    let fixture = |name: &str, point: &str, at: [f64; 3]| {
        let held = place("at_m", "height_m", at);
        format!(
            "[casting.part.fixture.{name}]\npoint = \"{point}\"\naxis = {down}\n{held}stiffness_n_per_m = 2e7\n\
             lateral_stiffness_n_per_m = {lateral}\nlateral_damping_n_s_per_m = [500.0, 500.0]\n"
        )
    };
    let fixtures =
        [("a", "T1", -0.06, -0.02), ("b", "T3", 0.06, -0.02), ("c", "T7", -0.06, 0.02), ("d", "T9", 0.06, 0.02)];
    let fixtures = fixtures.map(|(name, point, x, y)| fixture(name, point, [x, y, -0.02])).concat();
    let [x, y, z] = to([4.5e-4, 2.35e-3, 2.4e-3]).map(f64::abs);
    format!(
        "duration_s = 0.06\ngeometry = \"as_given\"\n[environment]\ngravity_axis = {down}\n[solver]\ntolerance = 1e-11\n\
         modes = \"integrated\"\n[structure]\nsource = \"matrices\"\nformat = \"matrix_market\"\nstiffness_file = \"K.mtx\"\n\
         mass_file = \"M.mtx\"\ndof_file = \"rows.dof\"\npoints_file = \"points.csv\"\ncutoff_hz = 400.0\ncache = false\n{}{}\
         [casting.part]\nmass_kg = 1.0368\ninertia_kg_m2 = [{x}, {y}]\ninertia_z_kg_m2 = {z}\n[casting.part.core.top]\nat_m = {}\n\
         {fixtures}{structure}",
        hammer("top", "R5", [0.0, 0.0, -1.0], [0.01, 0.005, 0.02]),
        hammer("side", "R3", [1.0, 0.0, 0.0], [-0.08, 0.01, 0.0]),
        list(to([0.03, 0.01, 0.01])),
    )
}

fn engine(text: &str, folder: &Path) -> Engine {
    fs::write(folder.join("study.toml"), text).unwrap();
    let study = Study::load(&folder.join("study.toml")).unwrap_or_else(|error| panic!("{error}"));
    Engine::new(study).unwrap_or_else(|error| panic!("{error}"))
}

fn outcome(text: &str, folder: &Path) -> RunMetrics {
    let outcome = engine(text, folder).outcome(0);
    assert_eq!(outcome.status, RowStatus::Done, "{}", outcome.reason);
    outcome.metrics.unwrap()
}

/// Energies, works, velocities of both hammers, the casting and its core.
fn figures(metrics: &RunMetrics) -> Vec<f64> {
    assert!(metrics.totals.energy_residual.abs() < 1e-5, "{:e}", metrics.totals.energy_residual);
    let of_hammers = metrics.hammers.iter().flat_map(|hammer| {
        [
            hammer.first_impact_energy_j.unwrap(),
            hammer.first_impact_work_j.unwrap(),
            hammer.first_impact_impulse_n_s.unwrap(),
        ]
    });
    let casting = &metrics.castings[0];
    let of_casting = [
        casting.peak_velocity_m_s,
        casting.peak_point_velocity_m_s,
        casting.fixture_damper_loss_j,
        casting.structure_work_j,
        metrics.cores[0].peak_velocity_m_s,
    ];
    of_hammers.chain(of_casting).collect()
}

/// Writes the files of a turned world, and returns the folder.
fn world(by: &Turn) -> TempDir {
    let folder = TempDir::new().unwrap();
    write_machine(&turned(by, &FeModel::station().unwrap()), folder.path());
    let part = folder.path().join("part");
    fs::create_dir(&part).unwrap();
    let model = turned(by, &block(70e9));
    write_machine(&model, &part);
    let node = |(index, point): (usize, &InterfacePoint)| {
        let [x, y, z] = point.position_m;
        format!("{},{x},{y},{z}\n", index + 1)
    };
    let nodes: String = model.points().iter().enumerate().map(node).collect();
    fs::write(part.join("nodes.csv"), format!("node,x,y,z\n{nodes}")).unwrap();
    folder
}

fn assert_turned(structure: &str) {
    let [upright, turned] = [&UPRIGHT, &ABOUT[1]].map(|by| figures(&outcome(&study(by, structure), world(by).path())));
    for (found, expected) in turned.iter().zip(&upright) {
        println!("{found} and {expected}: {:.1e}", found / expected - 1.0);
        assert!((found / expected - 1.0).abs() < 1e-9, "{found} instead of {expected}");
    }
}

/// A scene turned by 90 degrees with its machine, its hammers and gravity has the same outputs: a rigid casting with six freedoms.
#[test]
fn a_turned_scene_does_the_same() {
    assert_turned("");
}

/// The same with an elastic casting.
#[test]
fn a_turned_scene_with_an_elastic_casting_does_the_same() {
    assert_turned(STRUCTURE);
}

/// Frequencies of the receptances, Hz: below, between and above the lowest modes of machine and casting.
const HERTZ: [f64; 5] = [0.0, 15.0, 90.0, 310.0, 2500.0];

/// Receptances of a study's machine and casting between all points on which forces act, for each frequency.
fn receptances(text: &str, folder: &Path) -> (Vec<PointId>, Vec<DMatrix<Complex<f64>>>) {
    let row = engine(text, folder).scene(0).unwrap();
    let model = LinearModel::new(&row.scene, &row.modes).unwrap();
    let driven: Vec<PointId> = model.driven().collect();
    let rows: Vec<usize> = model.points().enumerate().filter(|(_, id)| driven.contains(id)).map(|(at, _)| at).collect();
    (driven, HERTZ.map(|hz| model.receptances(hz).unwrap().select_rows(&rows)).to_vec())
}

/// Difference of two receptances over the geometric mean of those at their points.
fn difference(of: &DMatrix<Complex<f64>>, (i, j): (usize, usize), other: Complex<f64>) -> f64 {
    (of[(i, j)] - other).norm() / (of[(i, i)].norm() * of[(j, j)].norm()).sqrt()
}

/// A force at one point moves another one as a force at that one moves the first: with hammers and fixtures in slanted directions, held
/// across them too, a rigid or an elastic casting.
#[test]
fn receptances_are_symmetric() {
    for structure in ["", STRUCTURE] {
        let folder = world(&UPRIGHT);
        let text = study(&UPRIGHT, structure).replace("strike_axis = [1, 0, 0]", "strike_axis = [1.0, 0.3, -0.4]");
        // Each fixture in another direction.
        let mut axes = ["[0.2, -0.3, -1.0]", "[-0.5, 0.1, -1.0]", "[0.0, 0.6, -0.8]", "[0.7, 0.0, -0.7]"].into_iter();
        let slanted = |line: &str| match line.starts_with("axis = ") {
            true => format!("axis = {}\n", axes.next().unwrap()),
            false => format!("{line}\n"),
        };
        let (points, all) = receptances(&text.lines().map(slanted).collect::<String>(), folder.path());
        // Two mounts, two strikes, and both ends of four fixtures in three directions; further points of a rigid casting.
        assert!(points.len() >= 28 && axes.next().is_none(), "{points:?}");
        let pairs = || (0..points.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
        let differences = all.iter().flat_map(|of| pairs().map(|(i, j)| difference(of, (i, j), of[(j, i)])));
        let worst = differences.fold(0.0, f64::max);
        println!("{} points: symmetric within {worst:.1e}", points.len());
        assert!(worst < 1e-10, "{worst:e}");
        // Slanted directions couple points that straight ones do not.
        assert!(all[1].iter().all(|value| value.norm() > 0.0));
    }
}

/// The same receptances in a scene turned by 90 degrees about any axis. The two directions across a fixture may swap and change sign.
#[test]
fn a_turned_scene_has_the_same_receptances() {
    for structure in ["", STRUCTURE] {
        let (points, upright) = receptances(&study(&UPRIGHT, structure), world(&UPRIGHT).path());
        for by in &ABOUT {
            let (same, turned) = receptances(&study(by, structure), world(by).path());
            assert_eq!(same, points);
            let places: Vec<(usize, f64)> = points.iter().map(|point| turned_point(by, *point, &points)).collect();
            let mut worst = 0.0_f64;
            for (of, turned) in upright.iter().zip(&turned) {
                for (i, j) in (0..points.len()).flat_map(|i| (0..points.len()).map(move |j| (i, j))) {
                    let ((row, one), (column, other)) = (places[i], places[j]);
                    worst = worst.max(difference(of, (i, j), turned[(row, column)] * one * other));
                }
            }
            println!("{by:?}: the same within {worst:.1e}");
            assert!(worst < 1e-9, "{by:?}: {worst:e}");
        }
    }
}

/// Place of a point in the turned scene, and the sign of its direction.
fn turned_point(by: &Turn, point: PointId, points: &[PointId]) -> (usize, f64) {
    // The first and the second direction across the vertical are x and y.
    let across = |direction: usize| {
        let is_kept = by[0].0 < by[1].0;
        (if is_kept { direction } else { 1 - direction }, by[direction].1)
    };
    let fixture = |of: FixtureId| {
        let (direction, sign) = across(of.axis - 1);
        (FixtureId { axis: 1 + direction, ..of }, sign)
    };
    let (id, sign) = match point {
        PointId::Held(of) if of.axis > 0 => (PointId::Held(fixture(of).0), fixture(of).1),
        PointId::Support(of) if of.axis > 0 => (PointId::Support(fixture(of).0), fixture(of).1),
        PointId::Rotation { casting, axis } => (PointId::Rotation { casting, axis: across(axis).0 }, across(axis).1),
        other => (other, 1.0),
    };
    (points.iter().position(|one| *one == id).unwrap(), sign)
}

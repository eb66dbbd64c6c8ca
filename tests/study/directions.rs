//! Hammers, fixtures and gravity in any direction: a scene turned by 90 degrees does the same, and sideways holds act as springs.

use std::fs;
use std::path::Path;

use decore_model::metrics::RunMetrics;
use decore_model::run::RowStatus;
use decore_model::structure::{
    ExportFormat, FeModel, InterfacePoint, InterfacePoints, ModelMatrices, PointPlace, write_model,
};
use decore_study::Study;
use decore_study::engine::{Engine, RowRunner};
use sprs::{CsMat, TriMat};
use tempfile::TempDir;

use crate::solid::block;

/// A vector turned by 90 degrees about y: z becomes x.
fn turn([x, y, z]: [f64; 3]) -> [f64; 3] {
    [z, y, -x]
}

/// The DOF that a DOF becomes, and the sign of its motion.
fn turned_dof(dof: usize) -> (usize, f64) {
    let (kind, axis) = (dof / 3 * 3, dof % 3);
    [(kind + 2, -1.0), (kind + 1, 1.0), (kind, 1.0)][axis]
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

/// A model turned by 90 degrees about y, and its points.
fn turned(model: &FeModel) -> FeModel {
    let (mut matrices, mut points) = labelled(model);
    let signs: Vec<f64> = matrices.labels.iter().map(|label| turned_dof(label.dof).1).collect();
    let flip = |matrix: &CsMat<f64>| {
        let mut flipped = TriMat::new(matrix.shape());
        for (value, (row, column)) in matrix {
            flipped.add_triplet(row, column, signs[row] * signs[column] * value);
        }
        flipped.to_csr()
    };
    (matrices.mass, matrices.stiffness) = (flip(&matrices.mass), flip(&matrices.stiffness));
    matrices.labels.iter_mut().for_each(|label| label.dof = turned_dof(label.dof).0);
    points.iter_mut().for_each(|point| point.position_m = turn(point.position_m));
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

/// A scene with a vertical hammer and one that strikes along x, on a casting that its fixtures hold in all directions. With `turns` in the
/// turned world. `structure` makes the casting elastic.
fn study(turns: bool, structure: &str) -> String {
    let to = |v: [f64; 3]| if turns { turn(v) } else { v };
    let place = |key: &str, height: &str, at: [f64; 3]| {
        let [x, y, z] = to(at);
        format!("{key} = [{x}, {y}]\n{height} = {z}\n")
    };
    let down = list(to([0.0, 0.0, -1.0]));
    let hammer = |name: &str, mount: &str, axis: [f64; 3], at: [f64; 3]| {
        let strike = place("strike_point_m", "strike_height_m", at);
        format!("[hammer.{name}]\nmount = \"{mount}\"\nsupply_bar = 5.0\nstrike_axis = {}\n{strike}", list(to(axis)))
    };
    // Across a fixture that points against x lie y and z.
    let lateral = if turns { "[1.5e7, 1.2e7]" } else { "[1.2e7, 1.5e7]" };
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
    let [x, y, z] = if turns { [2.4e-3, 2.35e-3, 4.5e-4] } else { [4.5e-4, 2.35e-3, 2.4e-3] };
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

fn outcome(text: &str, folder: &Path) -> RunMetrics {
    fs::write(folder.join("study.toml"), text).unwrap();
    let study = Study::load(&folder.join("study.toml")).unwrap_or_else(|error| panic!("{error}"));
    let outcome = Engine::new(study).unwrap_or_else(|error| panic!("{error}")).outcome(0);
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

fn assert_turned(structure: &str, write: impl Fn(bool, &Path)) {
    let station = FeModel::station().unwrap();
    let [upright, turned] = [false, true].map(|turns| {
        let folder = TempDir::new().unwrap();
        write_machine(&if turns { turned(&station) } else { station.clone() }, folder.path());
        write(turns, folder.path());
        figures(&outcome(&study(turns, structure), folder.path()))
    });
    for (found, expected) in turned.iter().zip(&upright) {
        println!("{found} and {expected}: {:.1e}", found / expected - 1.0);
        assert!((found / expected - 1.0).abs() < 1e-9, "{found} instead of {expected}");
    }
}

/// A scene turned by 90 degrees with its machine, its hammers and gravity has the same outputs: a rigid casting with six freedoms.
#[test]
fn a_turned_scene_does_the_same() {
    assert_turned("", |_, _| {});
}

/// The same with an elastic casting.
#[test]
fn a_turned_scene_with_an_elastic_casting_does_the_same() {
    let structure = "[casting.part.structure]\nstiffness_file = \"part/K.mtx\"\nmass_file = \"part/M.mtx\"\n\
         dof_file = \"part/rows.dof\"\nnodes_file = \"part/nodes.csv\"\npoint_radius_m = 0.025\ncutoff_hz = 5000.0\n";
    assert_turned(structure, |turns, folder| {
        let part = folder.join("part");
        fs::create_dir(&part).unwrap();
        let model = if turns { turned(&block(70e9)) } else { block(70e9) };
        write_machine(&model, &part);
        let node = |(index, point): (usize, &InterfacePoint)| {
            let [x, y, z] = point.position_m;
            format!("{},{x},{y},{z}\n", index + 1)
        };
        let nodes: String = model.points().iter().enumerate().map(node).collect();
        fs::write(part.join("nodes.csv"), format!("node,x,y,z\n{nodes}")).unwrap();
    });
}

//! A machine whose interface points are several nodes, against the same machine with these points as nodes of their own, which constraints
//! in its matrices tie to the means.

use std::fs;
use std::path::Path;

use decore_model::structure::{
    DofLabel, ExportFormat, FeModel, InterfacePoint, InterfacePoints, ModelMatrices, PointPlace, WeightedNodes,
    write_model,
};
use sprs::{CsMat, TriMat};
use tempfile::TempDir;

use crate::elastic::{figures, outcome};
use crate::solid::block;

/// Mass and stiffness of the machine over the block's.
const HEAVIER: f64 = 200.0;
/// Stiffness of the spring under each point of several nodes in N/m.
const UNDER_POINT: f64 = 1e8;
/// Points of the machine: name, nodes, weights.
const POINTS: [(&str, &[i64], &[f64]); 5] = [
    ("M", &[51, 54, 57, 66, 69], &[1.0, 2.0, 1.0, 2.5, 1.5]),
    ("T1", &[27, 30, 54], &[1.0, 1.0, 0.5]),
    ("T2", &[36], &[1.0]),
    ("T3", &[75], &[1.0]),
    ("T4", &[84], &[1.0]),
];

/// The block, heavier, on springs under all nodes of its lower surface and under the points of several nodes. With `constraints` each of
/// these is a node of its own: a row without mass, and a Lagrange multiplier.
fn matrices(constraints: bool) -> ModelMatrices {
    let ModelMatrices { mass, stiffness, labels, .. } = block(70e9).matrices().clone();
    let several = POINTS.iter().filter(|(_, nodes, _)| nodes.len() > 1);
    let order = mass.rows() + if constraints { 2 * several.clone().count() } else { 0 };
    let mut labels = labels;
    let [mut k, mut m] = [(); 2].map(|()| TriMat::new((order, order)));
    let add = |to: &mut TriMat<f64>, from: &CsMat<f64>| {
        from.iter().for_each(|(value, (row, column))| to.add_triplet(row, column, HEAVIER * value));
    };
    add(&mut k, &stiffness);
    add(&mut m, &mass);
    (0..mass.rows()).filter(|row| row / 3 % 3 == 0).for_each(|row| k.add_triplet(row, row, 2e8));
    for (at, (_, nodes, weights)) in several.enumerate() {
        let sum: f64 = weights.iter().sum();
        let mean: Vec<(usize, f64)> =
            nodes.iter().zip(*weights).map(|(node, weight)| (3 * (*node as usize - 1) + 2, weight / sum)).collect();
        if !constraints {
            for ((row, share), (column, other)) in mean.iter().flat_map(|one| mean.iter().map(move |two| (*one, *two)))
            {
                k.add_triplet(row, column, UNDER_POINT * share * other);
            }
            continue;
        }
        let [point, multiplier] = [0, 1].map(|offset| mass.rows() + 2 * at + offset);
        labels.push(DofLabel { node: 1000 + at as i64, dof: 2 });
        // A coordinate of no node.
        labels.push(DofLabel { node: 2000 + at as i64, dof: 6 });
        k.add_triplet(point, point, UNDER_POINT);
        for (row, share) in mean.into_iter().map(|(row, share)| (row, -share)).chain([(point, 1.0)]) {
            k.add_triplet(row, multiplier, 1e9 * share);
            k.add_triplet(multiplier, row, 1e9 * share);
        }
    }
    ModelMatrices { mass: m.to_csr(), stiffness: k.to_csr(), damping: None, labels }
}

fn machine(constraints: bool) -> FeModel {
    let mut own = 1000..;
    let point = |(name, nodes, weights): &(&str, &[i64], &[f64])| {
        let place = match nodes {
            [node] => PointPlace::Node { node: *node, rotation_node: None },
            _ if constraints => PointPlace::Node { node: own.next().unwrap(), rotation_node: None },
            _ => PointPlace::Nodes(WeightedNodes::new(nodes, Some(weights)).unwrap()),
        };
        InterfacePoint { name: (*name).to_owned(), role: String::new(), place, position_m: [0.0; 3] }
    };
    FeModel::new(matrices(constraints), InterfacePoints::new(POINTS.iter().map(point).collect()).unwrap()).unwrap()
}

fn study() -> String {
    let pad = |name: &str, x: f64, y: f64| {
        format!(
            "[casting.part.fixture.{name}]\npoint = \"{name}\"\nat_m = [{x}, {y}]\nstiffness_n_per_m = 2e7\n\
             damping_n_s_per_m = 1500.0\n"
        )
    };
    let pads =
        [pad("T1", -0.06, -0.02), pad("T2", 0.06, -0.02), pad("T3", -0.06, 0.02), pad("T4", 0.06, 0.02)].concat();
    format!(
        "duration_s = 0.2\ngeometry = \"as_given\"\n[solver]\ntolerance = 1e-9\n[structure]\nsource = \"matrices\"\n\
         format = \"matrix_market\"\nstiffness_file = \"K.mtx\"\nmass_file = \"M.mtx\"\ndof_file = \"rows.dof\"\n\
         points_file = \"points.csv\"\nhousings = \"included\"\ncutoff_hz = 3000.0\nfixed_interface_cutoff_hz = 1e6\n\
         cache = false\n[hammer.left]\nmount = \"M\"\nsupply_bar = 5.0\nstrike_point_m = [0.01, 0.005]\n[casting.part]\n\
         mass_kg = 3.0\ninertia_kg_m2 = [0.0135, 0.026]\n{pads}"
    )
}

/// Figures of the hammer and the casting, and the work on the machine.
fn row(constraints: bool, folder: &Path) -> Vec<f64> {
    let files = write_model(&machine(constraints), ExportFormat::named("matrix_market").unwrap(), folder).unwrap();
    // Names as the study has them.
    for (from, to) in [(files.dofs.unwrap(), "rows.dof"), (files.points, "points.csv")] {
        fs::rename(from, folder.join(to)).unwrap();
    }
    let outcome = outcome(&study(), folder);
    let work = outcome.metrics.as_ref().unwrap().castings[0].structure_work_j;
    figures(&outcome).into_iter().chain([work]).collect()
}

/// The reduction of means and the elimination of constraints are two roads to the same machine.
#[test]
fn means_of_nodes_are_nodes_tied_by_constraints() {
    let [means, tied] = [false, true].map(|constraints| row(constraints, TempDir::new().unwrap().path()));
    for (found, expected) in means.into_iter().zip(tied) {
        println!("{found} and {expected}: {:.1e}", found / expected - 1.0);
        assert!((found / expected - 1.0).abs() < 1e-7, "{found} instead of {expected}");
    }
}

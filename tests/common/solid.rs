//! A block of eight-node bricks as a finite element model, for tests of elastic castings.

// Every test binary uses a part of this.
#![allow(dead_code)]

use std::fs;
use std::path::Path;

use decore_model::structure::{
    DofLabel, ExportFormat, FeModel, InterfacePoint, InterfacePoints, ModelMatrices, PointPlace, write_model,
};
use nalgebra::SMatrix;
use sprs::TriMat;

/// Edges of the block in m, and its bricks along them.
pub const EDGES: [f64; 3] = [0.16, 0.06, 0.04];
const BRICKS: [usize; 3] = [8, 3, 2];
/// Where the block's corner stands: coordinates need not begin at the centre of mass.
const CORNER: [f64; 3] = [1.0, -2.0, 0.5];
/// Density in kg/m3.
pub const DENSITY: f64 = 2700.0;
const POISSON: f64 = 0.3;

type Corner = [f64; 3];

fn corners() -> Vec<Corner> {
    (0..8).map(|n| [n >> 2, n >> 1, n].map(|bit| f64::from(bit & 1) * 2.0 - 1.0)).collect()
}

/// Stiffness and mass of a brick with eight nodes, integrated at two points per direction.
fn brick(half: [f64; 3], young: f64) -> (SMatrix<f64, 24, 24>, SMatrix<f64, 8, 8>) {
    let factor = young / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON));
    let elasticity = SMatrix::<f64, 6, 6>::from_fn(|i, j| match (i < 3, j < 3, i == j) {
        (true, true, true) => factor * (1.0 - POISSON),
        (true, true, false) => factor * POISSON,
        (false, false, true) => factor * (0.5 - POISSON),
        _ => 0.0,
    });
    let volume: f64 = half.iter().product();
    let (mut stiffness, mut mass) = (SMatrix::zeros(), SMatrix::zeros());
    for point in corners() {
        let at = point.map(|value| value / 3.0_f64.sqrt());
        let mut strain = SMatrix::<f64, 6, 24>::zeros();
        let mut values = SMatrix::<f64, 8, 1>::zeros();
        for (node, corner) in corners().into_iter().enumerate() {
            let terms = [0, 1, 2].map(|axis| 1.0 + corner[axis] * at[axis]);
            values[node] = terms.iter().product::<f64>() / 8.0;
            let slope = |axis: usize| corner[axis] / half[axis] * terms[(axis + 1) % 3] * terms[(axis + 2) % 3] / 8.0;
            let (x, y, z) = (slope(0), slope(1), slope(2));
            for (row, column, value) in
                [(0, 0, x), (1, 1, y), (2, 2, z), (3, 0, y), (3, 1, x), (4, 1, z), (4, 2, y), (5, 0, z), (5, 2, x)]
            {
                strain[(row, 3 * node + column)] = value;
            }
        }
        stiffness += strain.transpose() * elasticity * strain * volume;
        mass += values * values.transpose() * DENSITY * volume;
    }
    (stiffness, mass)
}

/// The block with `young` in Pa.
pub fn block(young: f64) -> FeModel {
    let counts = BRICKS.map(|bricks| bricks + 1);
    let size = [0, 1, 2].map(|axis| EDGES[axis] / BRICKS[axis] as f64);
    let number = |[i, j, k]: [usize; 3]| (i * counts[1] + j) * counts[2] + k;
    let nodes = counts.iter().product::<usize>();
    let (stiffness, mass) = brick(size.map(|edge| 0.5 * edge), young);
    let [mut k, mut m] = [(); 2].map(|()| TriMat::new((3 * nodes, 3 * nodes)));
    let each =
        |n: [usize; 3]| (0..n[0]).flat_map(move |i| (0..n[1]).flat_map(move |j| (0..n[2]).map(move |k| [i, j, k])));
    for [i, j, l] in each(BRICKS) {
        let of: Vec<usize> = (0..8_usize).map(|n| number([i + (n >> 2), j + (n >> 1 & 1), l + (n & 1)])).collect();
        for (a, b) in (0..24).flat_map(|a| (0..24).map(move |b| (a, b))) {
            let (row, column) = (3 * of[a / 3] + a % 3, 3 * of[b / 3] + b % 3);
            k.add_triplet(row, column, stiffness[(a, b)]);
            if a % 3 == b % 3 {
                m.add_triplet(row, column, mass[(a / 3, b / 3)]);
            }
        }
    }
    let point = |at: [usize; 3]| InterfacePoint {
        name: format!("{at:?}"),
        role: String::new(),
        place: PointPlace::Node { node: number(at) as i64 + 1, rotation_node: None },
        position_m: [0, 1, 2].map(|axis| CORNER[axis] + size[axis] * at[axis] as f64),
    };
    let labels = (0..3 * nodes).map(|row| DofLabel { node: (row / 3) as i64 + 1, dof: row % 3 }).collect();
    let matrices = ModelMatrices { mass: m.to_csr(), stiffness: k.to_csr(), damping: None, labels };
    let points = InterfacePoints::new(each(counts).map(point).collect()).unwrap();
    FeModel::new(matrices, points).unwrap()
}

/// Writes the block's matrices with `young` in Pa, and the coordinates of its nodes: `K.mtx`, `M.mtx`, `rows.dof`, `nodes.csv`.
pub fn write_block(young: f64, folder: &Path) {
    let model = block(young);
    let export = ExportFormat::named("matrix_market").unwrap();
    let files = write_model(&model, export, folder).unwrap();
    fs::rename(files.dofs.unwrap(), folder.join("rows.dof")).unwrap();
    let node = |(index, point): (usize, &InterfacePoint)| {
        let [x, y, z] = point.position_m;
        format!("{},{x},{y},{z}\n", index + 1)
    };
    let nodes: String = model.points().iter().enumerate().map(node).collect();
    fs::write(folder.join("nodes.csv"), format!("node,x,y,z\n{nodes}")).unwrap();
}

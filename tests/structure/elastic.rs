//! Elastic castings: free modes and residual flexibility of a block of bricks against dense solutions, and motion of areas.

use std::f64::consts::TAU;

use decore_math::linalg::symmetric_eigen;
use decore_model::direction::DOWN;
use decore_model::structure::{
    BodyNodes, BodyPoint, Damping, DirectedPoint, ElasticBody, ElasticSettings, FeModel, InterfacePoints, Side,
    WeightedNodes,
};
use nalgebra::{DMatrix, DVector};
use sprs::CsMat;

use crate::solid::{DENSITY, EDGES, block};

fn settings(cutoff_hz: f64) -> ElasticSettings {
    ElasticSettings { cutoff_hz, damping: Damping::Ratio(0.005), point_radius_m: 0.025 }
}

pub fn dense(matrix: &CsMat<f64>) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(matrix.rows(), matrix.cols());
    matrix.iter().for_each(|(value, (row, column))| out[(row, column)] += *value);
    out
}

/// All eigenpairs by a dense solver: mass-normalised.
pub fn all_modes(model: &FeModel) -> (Vec<f64>, DMatrix<f64>) {
    let mass = dense(model.mass());
    let factor = mass.clone().cholesky().unwrap().l();
    let half = factor.solve_lower_triangular(&dense(model.stiffness())).unwrap();
    let reduced = factor.solve_lower_triangular(&half.transpose()).unwrap();
    let symmetric = (&reduced + reduced.transpose()) * 0.5;
    let eigen = symmetric_eigen(&symmetric).unwrap();
    (eigen.values, factor.transpose().solve_upper_triangular(&eigen.vectors).unwrap())
}

const POINTS: [DirectedPoint; 5] = [
    (BodyPoint::Surface { at_m: [0.01, 0.005, 0.0], axis: DOWN, side: Side::Struck }, DOWN),
    (BodyPoint::Surface { at_m: [-0.07, -0.02, 0.0], axis: DOWN, side: Side::Held }, DOWN),
    (BodyPoint::Surface { at_m: [0.07, 0.02, 0.0], axis: DOWN, side: Side::Held }, DOWN),
    (BodyPoint::Centre, DOWN),
    (BodyPoint::Rotation(1), DOWN),
];

/// Horizontal and slanted strikes, a pad that holds sideways, mean motions along y.
const SIDEWAYS: [DirectedPoint; 5] = [
    (BodyPoint::Surface { at_m: [0.0, 0.01, 0.005], axis: [-1.0, 0.0, 0.0], side: Side::Struck }, [-1.0, 0.0, 0.0]),
    (BodyPoint::Surface { at_m: [0.02, 0.0, 0.0], axis: [0.6, 0.0, -0.8], side: Side::Struck }, [0.6, 0.0, -0.8]),
    (BodyPoint::Surface { at_m: [0.07, 0.02, 0.0], axis: DOWN, side: Side::Held }, [0.0, 1.0, 0.0]),
    (BodyPoint::Centre, [0.0, 1.0, 0.0]),
    (BodyPoint::Rotation(1), [0.0, 1.0, 0.0]),
];

/// Frequencies and mode shapes below the cut-off, and the residual flexibility of all modes above it, against the dense solution. The
/// sum of kept and residual flexibility does not depend on the cut-off: it is the static solution.
#[test]
fn modes_and_residual_are_those_of_the_dense_solution() {
    against_dense(&POINTS, 3);
}

/// The same for points that move sideways, with all six rigid motions.
#[test]
fn sideways_points_are_those_of_the_dense_solution() {
    against_dense(&SIDEWAYS, 6);
}

fn against_dense(points: &[DirectedPoint], rigid: usize) {
    let model = block(70e9);
    let (values, vectors) = all_modes(&model);
    let body = ElasticBody::new(model.clone(), settings(25_000.0)).unwrap();
    let found = body.at(points, points.len()).unwrap();
    let elastic: Vec<f64> = found.omega_rad_s.iter().copied().filter(|omega| *omega > 0.0).collect();
    let below = values.iter().filter(|value| **value < (TAU * 25_000.0).powi(2)).count();
    assert_eq!((found.omega_rad_s.len() - elastic.len(), elastic.len()), (rigid, below - 6));
    assert!(elastic.len() >= 5, "{}", elastic.len());
    for (omega, value) in elastic.iter().zip(&values[6..]) {
        assert!((omega / value.sqrt() - 1.0).abs() < 1e-8, "{omega} and {}", value.sqrt());
    }
    // Flexibility of the modes above, with the weights of each point from its motion under unit displacements.
    let weights = DMatrix::from_fn(model.order(), points.len(), |row, point| body.weight(&points[point], row).unwrap());
    let rows = weights.transpose() * &vectors;
    let above = rows.columns_range(below..).into_owned();
    let scale = DVector::from_iterator(above.ncols(), values[below..].iter().map(|value| value.recip()));
    let expected = &above * DMatrix::from_diagonal(&scale) * above.transpose();
    let error = (&found.residual - &expected).amax() / expected.amax();
    println!("residual flexibility {:.3e} m/N, off by {error:.1e}", expected[(0, 0)]);
    assert!(error < 1e-8, "{error:e}");
    // Kept and residual flexibility add up to the static one whatever is kept.
    let total = |cutoff_hz: f64| {
        let modes = ElasticBody::new(model.clone(), settings(cutoff_hz)).unwrap().at(points, points.len()).unwrap();
        let kept = modes.omega_rad_s.iter().map(|omega| if *omega > 0.0 { omega.powi(-2) } else { 0.0 });
        let kept = DMatrix::from_diagonal(&DVector::from_iterator(modes.omega_rad_s.len(), kept));
        &modes.rows * kept * modes.rows.transpose() + modes.residual
    };
    let [few, many] = [3000.0, 40_000.0].map(total);
    assert!((&few - &many).amax() / many.amax() < 1e-8);
    assert!((&few - few.transpose()).amax() == 0.0);
}

/// Areas move by rigid motions as their places do, and mean motions of the mass too.
#[test]
fn areas_follow_rigid_motions() {
    let body = ElasticBody::new(block(70e9), settings(1000.0)).unwrap();
    let mass = DENSITY * EDGES.iter().product::<f64>();
    assert!((body.mass_kg() / mass - 1.0).abs() < 1e-12);
    let found = body.at(&POINTS, POINTS.len()).unwrap();
    // A point (x, y) moves by `z + y tx - x ty` with what the mean motions of the mass show.
    let [first, second, _, centre, about_y] = POINTS;
    let more = body.at(&[first, second, centre, (BodyPoint::Rotation(0), DOWN), about_y], 0).unwrap();
    for mode in 0..3 {
        assert_eq!(found.omega_rad_s[mode], 0.0);
        let [heave, tx, ty] = [2, 3, 4].map(|row| more.rows[(row, mode)]);
        for (row, [x, y]) in [(0, [0.01, 0.005]), (1, [-0.07, -0.02])] {
            let expected = heave + y * tx - x * ty;
            assert!((more.rows[(row, mode)] - expected).abs() < 1e-9 * more.rows.amax(), "mode {mode}, point {row}");
        }
    }
}

/// Points that move sideways follow the six rigid motions as their places do: with the direction d and the place r by
/// `u d + theta (r x d)`.
#[test]
fn sideways_areas_follow_rigid_motions() {
    let body = ElasticBody::new(block(70e9), settings(1000.0)).unwrap();
    let place = [0.05, 0.01, 0.0];
    let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let slanted = [0.48, 0.6, -0.64];
    let centre = [x, y, z].map(|axis| (BodyPoint::Centre, axis));
    // Across y lie x and -z; across x lie y and z.
    let turns = [(BodyPoint::Rotation(0), y), (BodyPoint::Rotation(0), x), (BodyPoint::Rotation(1), y)];
    let found =
        body.at(&[centre.to_vec(), turns.to_vec(), vec![(BodyPoint::Place(place), slanted)]].concat(), 7).unwrap();
    let lever = [
        place[1] * slanted[2] - place[2] * slanted[1],
        place[2] * slanted[0] - place[0] * slanted[2],
        place[0] * slanted[1] - place[1] * slanted[0],
    ];
    let across = decore_model::direction::across;
    assert_eq!((across(y)[0], across(x)[0]), (x, y));
    let about_z = across(y)[1][2];
    for mode in 0..6 {
        let row = |at: usize| found.rows[(at, mode)];
        // Rotations count against the axes.
        let theta = [-row(3), -row(4), -row(5) * about_z];
        let expected: f64 = (0..3).map(|k| row(k) * slanted[k] + theta[k] * lever[k]).sum();
        assert!((row(6) - expected).abs() < 1e-9 * found.rows.amax(), "mode {mode}: {} and {expected}", row(6));
    }
}

/// Damping by a table is linear between its frequencies and constant outside; Rayleigh damping is `alpha / (2 omega) + beta omega / 2`.
#[test]
fn damping_by_table_and_by_rayleigh() {
    let modes = |damping: Damping| {
        let settings = ElasticSettings { damping, ..settings(20_000.0) };
        let found = ElasticBody::new(block(70e9), settings)?.at(&POINTS, POINTS.len())?;
        let elastic = found.omega_rad_s.into_iter().zip(found.damping_ratio).filter(|(omega, _)| *omega > 0.0);
        Ok::<Vec<(f64, f64)>, decore_model::structure::StructureError>(elastic.collect())
    };
    let table = [[6000.0, 0.01], [10_000.0, 0.05], [12_000.0, 0.03]];
    for (omega, ratio) in modes(Damping::Table(table.to_vec())).unwrap() {
        let hertz = omega / TAU;
        let expected = match hertz {
            hertz if hertz < 6000.0 => 0.01,
            hertz if hertz < 10_000.0 => 0.01 + 1e-5 * (hertz - 6000.0),
            hertz if hertz < 12_000.0 => 0.05 - 1e-5 * (hertz - 10_000.0),
            _ => 0.03,
        };
        assert!((ratio - expected).abs() < 1e-15, "{hertz} Hz: {ratio} instead of {expected}");
    }
    for (omega, ratio) in modes(Damping::Rayleigh { mass_per_s: 100.0, stiffness_s: 1e-6 }).unwrap() {
        assert!((ratio - (50.0 / omega + 0.5e-6 * omega)).abs() < 1e-15, "{omega}: {ratio}");
    }
    let stiff = modes(Damping::Rayleigh { mass_per_s: 0.0, stiffness_s: 1e-3 }).unwrap_err().to_string();
    assert!(stiff.contains("Rayleigh damping") && stiff.contains("below 1"), "{stiff}");
}

/// A block 1e8 times stiffer has its rigid motions alone below the cut-off, and a residual flexibility 1e8 times smaller than all of its
/// flexibility.
#[test]
fn a_stiff_block_is_rigid() {
    let flexibility = |young: f64, cutoff_hz: f64| {
        ElasticBody::new(block(young), settings(cutoff_hz)).unwrap().at(&POINTS, POINTS.len())
    };
    let [soft, stiff] = [flexibility(70e9, 100.0).unwrap(), flexibility(70e17, 10_000.0).unwrap()];
    assert_eq!((soft.omega_rad_s.len(), stiff.omega_rad_s.len()), (3, 3));
    let share = &stiff.residual * 1e8 - &soft.residual;
    assert!(share.amax() < 1e-6 * soft.residual.amax());
}

/// Points beside the body, lists of damping that are too short, and models without coordinates are errors with a way out.
#[test]
fn what_a_body_cannot_do() {
    let body = ElasticBody::new(block(70e9), settings(10_000.0)).unwrap();
    let beside = body
        .at(&[(BodyPoint::Surface { at_m: [0.3, 0.0, 0.0], axis: DOWN, side: Side::Struck }, DOWN)], 1)
        .unwrap_err()
        .to_string();
    assert!(beside.contains("x = 0.3000 m") && beside.contains("larger radius"), "{beside}");
    let few = ElasticSettings { damping: Damping::PerMode(vec![0.01]), ..settings(10_000.0) };
    let few = ElasticBody::new(block(70e9), few).unwrap_err().to_string();
    assert!(few.contains("damping ratios"), "{few}");
    // Held at a corner it still turns about it.
    let mut matrices = block(70e9).matrices().clone();
    (0..3).for_each(|row| *matrices.stiffness.get_mut(row, row).unwrap() += 1e12);
    let held = FeModel::new(matrices, block(70e9).points().clone()).unwrap();
    let held = ElasticBody::new(held, settings(10_000.0)).unwrap_err().to_string();
    assert!(held.contains("without supports") && held.contains("3 below"), "{held}");
    // A cut-off below all elastic modes leaves the rigid motions.
    let rigid = ElasticBody::new(block(70e9), settings(5.0)).unwrap().at(&POINTS, 3).unwrap();
    assert_eq!((rigid.omega_rad_s, rigid.residual.shape()), (vec![0.0; 3], (3, 3)));
    let nowhere = {
        let model = block(70e9);
        let bare = FeModel::new(model.matrices().clone(), InterfacePoints::default()).unwrap();
        ElasticBody::new(bare, settings(10_000.0)).unwrap_err().to_string()
    };
    assert!(nowhere.contains("nodes_file"), "{nowhere}");
}

/// The nodes of a point's area with their weights.
fn nodes_of_area(body: &ElasticBody, area: &DirectedPoint, order: usize) -> WeightedNodes {
    // Down is against z.
    let weight = |node: usize| -body.weight(area, 3 * node + 2).unwrap();
    let (nodes, weights): (Vec<i64>, Vec<f64>) =
        (0..order / 3).map(|node| (node as i64 + 1, weight(node))).filter(|(_, weight)| *weight != 0.0).unzip();
    assert!(nodes.len() > 3 && weights.iter().all(|weight| *weight > 0.0), "{weights:?}");
    WeightedNodes::new(&nodes, Some(&weights)).unwrap()
}

/// Nodes with the weights of an area are the area, bit by bit, and lie where it lies.
#[test]
fn nodes_with_the_weights_of_an_area_are_the_area() {
    let model = block(70e9);
    let body = ElasticBody::new(model.clone(), settings(25_000.0)).unwrap();
    let [areas, nodes] = [false, true].map(|by_nodes| {
        let point = |point: DirectedPoint| match point.0 {
            BodyPoint::Surface { .. } if by_nodes => {
                (BodyPoint::Nodes(nodes_of_area(&body, &point, model.order())), point.1)
            }
            _ => point,
        };
        body.at(&POINTS.map(point), 3).unwrap()
    });
    assert_eq!(areas, nodes);
    let table = BodyNodes::new(&model).unwrap();
    let place = table.place_m(&nodes_of_area(&body, &POINTS[0], model.order())).unwrap();
    assert!((place[0] - 0.01).abs() < 1e-15 && (place[1] - 0.005).abs() < 1e-15, "{place:?}");
    assert!((place[2] - 0.02).abs() < 1e-3, "{place:?}");
}

/// Static flexibility of points that are nodes against `w' P' K^+ P w` by dense algebra: held at three nodes, projected.
#[test]
fn nodes_have_the_flexibility_of_the_dense_solution() {
    let model = block(70e9);
    let order = model.order();
    let point = |nodes: &[i64], weights: &[f64]| WeightedNodes::new(nodes, Some(weights)).unwrap();
    let points = [point(&[3, 6, 9], &[1.0, 2.0, 3.0]), point(&[53], &[1.0]), point(&[50, 53, 106], &[0.2, 0.3, 0.5])];
    let directions = [DOWN, [1.0, 0.0, 0.0], [0.0, 0.6, -0.8]];
    let mut weights = DMatrix::zeros(order, 3);
    for (column, (nodes, direction)) in points.iter().zip(directions).enumerate() {
        for (node, weight) in nodes.iter() {
            (0..3).for_each(|axis| weights[(3 * (node as usize - 1) + axis, column)] = weight * direction[axis]);
        }
    }
    // Rigid motions by the places of the nodes; mass-normalised.
    let (mass, stiffness) = (dense(model.mass()), dense(model.stiffness()));
    let place: Vec<[f64; 3]> = model.points().iter().map(|point| point.position_m).collect();
    let rigid = DMatrix::from_fn(order, 6, |row, motion| {
        let ([x, y, z], axis) = (place[row / 3], row % 3);
        match motion.checked_sub(3) {
            None => f64::from(u8::from(axis == motion)),
            Some(about) => [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]][about][axis],
        }
    });
    let factor = (rigid.transpose() * &mass * &rigid).cholesky().unwrap().l();
    let rigid = factor.solve_lower_triangular(&rigid.transpose()).unwrap().transpose();
    let project = |forces: &DMatrix<f64>| forces - &mass * (&rigid * (rigid.transpose() * forces));
    // Three nodes at corners, held in six directions that leave no rigid motion.
    let held = [0, 1, 2, 3 * 96 + 1, 3 * 96 + 2, 3 * 9 + 2];
    let free: Vec<usize> = (0..order).filter(|row| !held.contains(row)).collect();
    let loads = project(&weights);
    let solved =
        stiffness.select_rows(&free).select_columns(&free).cholesky().unwrap().solve(&loads.select_rows(&free));
    let mut moved = DMatrix::zeros(order, 3);
    free.iter().enumerate().for_each(|(at, row)| moved.row_mut(*row).copy_from(&solved.row(at)));
    let expected = loads.transpose() * moved;
    let body = ElasticBody::new(model, settings(3000.0)).unwrap();
    let directed: Vec<DirectedPoint> = points.into_iter().map(BodyPoint::Nodes).zip(directions).collect();
    let found = body.at(&directed, 3).unwrap();
    let kept = found.omega_rad_s.iter().map(|omega| if *omega > 0.0 { omega.powi(-2) } else { 0.0 });
    let kept = DMatrix::from_diagonal(&DVector::from_iterator(found.omega_rad_s.len(), kept));
    let total = &found.rows * kept * found.rows.transpose() + found.residual;
    let error = (&total - &expected).amax() / expected.amax();
    println!("static flexibility {:.3e} m/N, off by {error:.1e}", expected[(0, 0)]);
    assert!(error < 5e-12, "{error:e}");
}

/// Unknown nodes are errors. A single node of bricks is a node of a solid mesh.
#[test]
fn unknown_and_single_nodes() {
    let model = block(70e9);
    let nodes = BodyNodes::new(&model).unwrap();
    let one = |node: i64| WeightedNodes::new(&[node], None).unwrap();
    let unknown = nodes.place_m(&one(999)).unwrap_err();
    assert!(unknown.contains("node 999, which the model does not have"), "{unknown}");
    assert_eq!(nodes.single_solid(&one(53)), Some(53));
    assert_eq!(nodes.single_solid(&WeightedNodes::new(&[53, 54], None).unwrap()), None);
    let body = ElasticBody::new(model, settings(3000.0)).unwrap();
    let unknown = body.at(&[(BodyPoint::Nodes(one(999)), DOWN)], 1).unwrap_err().to_string();
    assert!(unknown.contains("casting: expected nodes") && unknown.contains("node 999"), "{unknown}");
}

//! Interface points of a machine that are several nodes: flexibility and modes against dense solutions, files, faults.

use std::f64::consts::TAU;

use decore_model::structure::{
    CacheOutcome, Damping, DirectedPoints, ExportFormat, FeModel, InterfacePoint, InterfacePoints, ModalOptions,
    ModalTable, ModelMatrices, PointPlace, QualitySettings, ReducedStructure, ReductionSettings, WeightedNodes, assess,
    reduce, reduce_files, write_model,
};
use nalgebra::DMatrix;

use crate::elastic::{all_modes, dense};
use crate::solid::block;

/// Nodes of the point P with their weights, as a table has them.
const P: ([i64; 4], [f64; 4]) = ([50, 53, 56, 80], [1.0, 2.0, 3.0, 1.0]);
/// DOFs of the interface: P overlaps with the nodes of Q and S.
const INTERFACE: [(&str, usize); 6] = [("P", 2), ("P", 0), ("Q", 2), ("S", 2), ("T", 2), ("P", 2)];

/// The block of bricks on springs at the nodes of one end.
fn held() -> ModelMatrices {
    let mut matrices = block(70e9).matrices().clone();
    (0..36).for_each(|row| *matrices.stiffness.get_mut(row, row).unwrap() += 1e8);
    matrices
}

fn several((nodes, weights): (&[i64], &[f64])) -> PointPlace {
    PointPlace::Nodes(WeightedNodes::new(nodes, Some(weights)).unwrap())
}

fn node(node: i64) -> PointPlace {
    PointPlace::Node { node, rotation_node: None }
}

fn model(places: &[(&str, PointPlace)]) -> Result<FeModel, String> {
    let point = |(name, place): &(&str, PointPlace)| InterfacePoint {
        name: (*name).to_owned(),
        role: String::new(),
        place: place.clone(),
        position_m: [0.0; 3],
    };
    let points = InterfacePoints::new(places.iter().map(point).collect()).unwrap();
    FeModel::new(held(), points).map_err(|error| error.to_string())
}

fn machine() -> FeModel {
    model(&[("P", several((&P.0, &P.1))), ("Q", node(53)), ("S", several((&[53, 54], &[1.0, 1.0]))), ("T", node(9))])
        .unwrap()
}

fn settings(interface: &[(&str, usize)]) -> ReductionSettings {
    let interface = interface.iter().map(|(point, dof)| ((*point).to_owned(), *dof)).collect();
    ReductionSettings { interface, fixed_interface_cutoff_hz: 60_000.0 }
}

/// Weights of the rows in the distinct DOFs of [`INTERFACE`].
fn weights(order: usize) -> DMatrix<f64> {
    let mut weights = DMatrix::zeros(order, 5);
    let row = |node: i64, dof: usize| 3 * (node as usize - 1) + dof;
    for (node, weight) in P.0.into_iter().zip(P.1) {
        weights[(row(node, 2), 0)] = weight / 7.0;
        weights[(row(node, 0), 1)] = weight / 7.0;
    }
    weights[(row(53, 2), 2)] = 1.0;
    (weights[(row(53, 2), 3)], weights[(row(54, 2), 3)]) = (0.5, 0.5);
    weights[(row(9, 2), 4)] = 1.0;
    weights
}

fn rows(structure: &ReducedStructure) -> Vec<usize> {
    INTERFACE.iter().map(|(point, dof)| structure.interface().row_of(point, *dof).unwrap()).collect()
}

/// A point of several nodes is one DOF of the reduction, however many nodes it has. Its static flexibility is `w' K^-1 w`. This also holds
/// between points that share nodes. The frequencies are those of the full model.
#[test]
fn a_mean_of_nodes_is_one_dof_with_the_flexibility_of_the_full_model() {
    let model = machine();
    // With all fixed-interface modes the reduction is exact.
    let settings = ReductionSettings { fixed_interface_cutoff_hz: 1e6, ..settings(&INTERFACE) };
    let reduced = reduce(&model, &settings).unwrap();
    assert_eq!(rows(&reduced), [0, 1, 2, 3, 4, 0]);
    assert_eq!(reduced.transfer().nrows(), 5);
    let weights = weights(model.order());
    let expected = weights.transpose() * dense(model.stiffness()).cholesky().unwrap().solve(&weights);
    let error = (reduced.static_flexibility().unwrap() - &expected).amax() / expected.amax();
    println!("static flexibility off by {error:.1e}");
    assert!(error < 2e-12, "{error:e}");
    let (values, vectors) = all_modes(&model);
    let found = reduced.modes_at(&[], &options(), &[along("P"), along("S")]).unwrap();
    let shapes = weights.transpose() * vectors;
    for mode in 0..10 {
        let (omega, expected) = (found.omega_rad_s[mode], values[mode].sqrt());
        assert!((omega / expected - 1.0).abs() < 1e-9, "mode {mode}: {} Hz and {} Hz", omega / TAU, expected / TAU);
        for (row, dof) in [(0, 0), (1, 3)] {
            let [found, expected] = [found.rows[(row, mode)].abs(), shapes[(dof, mode)].abs()];
            assert!((found - expected).abs() < 1e-6 * shapes.row(dof).amax(), "mode {mode}: {found} and {expected}");
        }
    }
}

fn options() -> ModalOptions {
    ModalOptions { cutoff_hz: 1e5, damping: Damping::Ratio(0.02) }
}

fn along(point: &str) -> DirectedPoints {
    (vec![(point.to_owned(), 1.0)], [0.0, 0.0, 1.0])
}

/// One node with a weight is the node itself, bit by bit; points of the same nodes share a DOF.
#[test]
fn one_node_and_the_same_nodes() {
    let alone = reduce(&model(&[("A", node(53))]).unwrap(), &settings(&[("A", 2)])).unwrap();
    let places = [("P", several((&P.0, &P.1))), ("again", several((&P.0, &P.1))), ("A", node(53))];
    let both = reduce(&model(&places).unwrap(), &settings(&[("P", 2), ("again", 2)])).unwrap();
    assert_eq!(both.interface().row_of("again", 2).unwrap(), 0);
    assert_eq!(both.interface().len(), 1);
    // A point that no interface asks for changes nothing.
    let unused = reduce(&model(&places).unwrap(), &settings(&[("A", 2)])).unwrap();
    assert_eq!((unused.k_zz(), unused.m_zz()), (alone.k_zz(), alone.m_zz()));
}

/// The report compares the reduced machine with the full one at means as at nodes.
#[test]
fn the_report_knows_means() {
    let settings = QualitySettings { reduction: settings(&INTERFACE), cutoff_hz: 10_000.0, damping_ratio: 0.02 };
    let report = assess(&machine(), &settings).unwrap();
    assert!(report.modes.len() >= 5);
    for mode in &report.modes {
        assert!(mode.mac > 1.0 - 1e-6 && mode.relative_error.unwrap() < 1e-4, "{mode:?}");
        let [full, reduced] = [mode.effective_mass_full.unwrap(), mode.effective_mass_reduced.unwrap()];
        assert!(full.iter().zip(reduced).all(|(full, reduced)| (full - reduced).abs() < 1e-3), "{mode:?}");
    }
    assert_eq!(report.static_stiffness.len(), 5);
    assert!(report.static_stiffness.iter().all(|dof| dof.relative_error.abs() < 1e-9), "{:?}", report.static_stiffness);
    let largest = report.mobility.iter().map(|curve| curve.largest_relative_difference).fold(0.0, f64::max);
    println!("mobilities differ by {largest:.1e}");
    assert!(largest < 1e-2, "{largest:e}");
}

/// Points that are several nodes go through files: written, read again, kept in the cache, and made again if a weight changes.
#[test]
fn means_go_through_files_and_the_cache() {
    let folder = tempfile::tempdir().unwrap();
    let written = write_model(&machine(), ExportFormat::named("matrix_market").unwrap(), folder.path()).unwrap();
    let table = std::fs::read_to_string(&written.points).unwrap();
    assert!(table.contains("node,rotation_node,weights\nP,,0e0,0e0,0e0,50 53 56 80,,0.1"), "{table}");
    let settings = settings(&INTERFACE);
    let expected = reduce(&machine(), &settings).unwrap();
    let mut outcomes = Vec::new();
    let mut reduced = || {
        let (reduced, outcome) = reduce_files(&written, &settings, true).unwrap();
        outcomes.push(outcome);
        reduced
    };
    for found in [reduced(), reduced()] {
        assert_eq!((found.k_zz(), found.m_zz()), (expected.k_zz(), expected.m_zz()));
    }
    // The same ratios of other numbers.
    std::fs::write(&written.points, table.replace("50 53 56 80,,", "50 53 56 80,,1 2 3 1 #").replace(" #", "\n#"))
        .unwrap();
    assert_eq!(reduced().k_zz(), expected.k_zz());
    std::fs::write(&written.points, table.replace("50 53 56 80,,", "50 53 56 80,,3 2 1 1 #").replace(" #", "\n#"))
        .unwrap();
    assert!(reduced().k_zz() != expected.k_zz());
    assert_eq!(outcomes, [CacheOutcome::Stored, CacheOutcome::Used, CacheOutcome::Stale, CacheOutcome::Stale]);
}

/// Where the nodes give a point another place than `points.csv` does, the report says so.
#[test]
fn a_point_beside_its_nodes_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let mut written = write_model(&machine(), ExportFormat::named("matrix_market").unwrap(), folder.path()).unwrap();
    let places: String = block(70e9)
        .points()
        .iter()
        .enumerate()
        .map(|(at, point)| {
            let [x, y, z] = point.position_m;
            format!("{},{x},{y},{z}\n", at + 1)
        })
        .collect();
    let nodes = folder.path().join("nodes.csv");
    written.nodes = Some(nodes.clone());
    std::fs::write(&nodes, format!("node,x,y,z\n{places}")).unwrap();
    let points = |at: &str| {
        std::fs::write(&written.points, format!("name,x_m,y_m,z_m,node\nP,{at},50 53\n")).unwrap();
        let settings = QualitySettings { reduction: settings(&[("P", 2)]), cutoff_hz: 10_000.0, damping_ratio: 0.02 };
        assess(&FeModel::read(&written).unwrap(), &settings).unwrap().remarks.join("; ")
    };
    // Nodes 50 and 53 stand at (4, 0, 1) and (4, 1, 1) of 9 x 4 x 3.
    assert!(!points("1.08,-1.99,0.52").contains("point P"), "{}", points("1.08,-1.99,0.52"));
    let beside = points("1080,-1990,520");
    assert!(beside.contains("point P (the mean of its nodes) lies at [1080.0"), "{beside}");
}

#[test]
fn faults_of_points_that_are_several_nodes() {
    let fails = |places: &[(&str, PointPlace)], interface: &[(&str, usize)], wanted: &str| {
        let found =
            model(places).and_then(|model| reduce(&model, &settings(interface)).map_err(|error| error.to_string()));
        let error = found.err().unwrap_or_else(|| panic!("reduced, but expected: {wanted}"));
        assert!(error.contains(wanted), "{error}");
    };
    let pair = || several((&[50, 53], &[1.0, 1.0]));
    fails(
        &[("P", several((&[50, 999], &[1.0, 1.0])))],
        &[("P", 2)],
        "point P: no row of the matrices belongs to node 999",
    );
    fails(
        &[("P", pair())],
        &[("P", 3)],
        "interface point \"P\": the model has no row for direction rx (it has: x y z)",
    );
    let dependent = [("A", node(50)), ("B", node(53)), ("P", pair())];
    fails(&dependent, &[("A", 2), ("P", 2), ("B", 2)], "interface point P: expected nodes of which at least one");
    let twice = [("P", several((&[50, 53], &[1.0, 2.0]))), ("Q", pair()), ("R", several((&[50, 53], &[2.0, 1.0])))];
    fails(&twice, &[("P", 2), ("Q", 2), ("R", 2)], "interface point R");
    // Two of the three are free.
    assert!(reduce(&model(&twice).unwrap(), &settings(&[("P", 2), ("Q", 2), ("R", 0)])).is_ok());
    let points = InterfacePoints::parse("p", "name,x_m,y_m,z_m,node\nA,0,0,0,1 2\n").unwrap();
    let table = ModalTable::parse("m", "mode,frequency_hz,damping_ratio,1.z\n1,10,0.01,0.1\n").unwrap();
    let error = ReducedStructure::from_modal_table(&table, points).unwrap_err().to_string();
    assert!(error.contains("interface point A: expected one node"), "{error}");
}

//! Structures that break naive reductions, each with its closed form or its error.

use std::f64::consts::{PI, TAU};

use decore_model::structure::{
    Damping, DofLabel, FeModel, InterfacePoint, InterfacePoints, ModalOptions, ModelMatrices, Observer, PointPlace,
    ReducedStructure, ReductionFacts, ReductionSettings, StructureError, reduce, reduce_observed,
};
use sprs::TriMat;

use crate::road;

const SPRING: f64 = 500.0;
const MASS: f64 = 2.0;
const X: [f64; 3] = [1.0, 0.0, 0.0];

/// Springs between neighbouring DOFs and from DOFs to ground, masses on DOFs.
struct Springs {
    stiffness: TriMat<f64>,
    mass: TriMat<f64>,
}

impl Springs {
    fn new(order: usize) -> Self {
        Self { stiffness: TriMat::new((order, order)), mass: TriMat::new((order, order)) }
    }

    fn connect(&mut self, i: usize, j: usize, k: f64) {
        for (row, column, value) in [(i, i, k), (j, j, k), (i, j, -k), (j, i, -k)] {
            self.stiffness.add_triplet(row, column, value);
        }
    }

    fn ground(&mut self, i: usize, k: f64) {
        self.stiffness.add_triplet(i, i, k);
    }

    fn weigh(&mut self, i: usize, m: f64) {
        self.mass.add_triplet(i, i, m);
    }

    /// Every DOF is x of a node of its own; points P0, P1, ... at the given DOFs.
    fn model(&self, points: &[usize]) -> Result<FeModel, StructureError> {
        let order = self.mass.rows();
        let labels = (0..order).map(|row| DofLabel { node: row as i64, dof: 0 }).collect();
        let point = |(index, row): (usize, &usize)| InterfacePoint {
            name: format!("P{index}"),
            role: "mount".to_owned(),
            place: PointPlace::Node { node: *row as i64, rotation_node: None },
            position_m: [*row as f64, 0.0, 0.0],
        };
        let points = InterfacePoints::new(points.iter().enumerate().map(point).collect()).expect("unique names");
        let (mass, stiffness) = (self.mass.to_csr(), self.stiffness.to_csr());
        FeModel::new(ModelMatrices { mass, stiffness, damping: None, labels }, points)
    }
}

/// n masses in a row, held at both ends or free.
fn chain(n: usize, held: bool) -> Springs {
    let mut springs = Springs::new(n);
    for i in 0..n {
        springs.weigh(i, MASS);
        if i + 1 < n {
            springs.connect(i, i + 1, SPRING);
        }
    }
    if held {
        springs.ground(0, SPRING);
        springs.ground(n - 1, SPRING);
    }
    springs
}

fn held_hz(n: usize, j: usize) -> f64 {
    2.0 * (SPRING / MASS).sqrt() * (j as f64 * PI / (2.0 * (n as f64 + 1.0))).sin() / TAU
}

/// j = 0 is the free motion.
fn free_hz(n: usize, j: usize) -> f64 {
    2.0 * (SPRING / MASS).sqrt() * (j as f64 * PI / (2.0 * n as f64)).sin() / TAU
}

fn settings(points: usize, cutoff_hz: f64) -> ReductionSettings {
    ReductionSettings {
        interface: (0..points).map(|index| (format!("P{index}"), 0)).collect(),
        fixed_interface_cutoff_hz: cutoff_hz,
    }
}

fn reduced(springs: &Springs, points: &[usize], cutoff_hz: f64) -> (ReducedStructure, ReductionFacts) {
    let model = springs.model(points).expect("sound");
    reduce_observed(&model, &settings(points.len(), cutoff_hz), &mut Observer::none()).expect("reduces")
}

fn hz(structure: &ReducedStructure) -> Vec<f64> {
    let options = ModalOptions { cutoff_hz: 1e9, damping: Damping::Ratio(0.0) };
    road::hz(structure, &[], &options)
}

fn assert_close(found: &[f64], expected: impl Iterator<Item = f64>, tolerance: f64) {
    for (index, (f, e)) in found.iter().zip(expected).enumerate() {
        assert!((f - e).abs() <= tolerance * e.abs(), "value {index}: {f} instead of {e}");
    }
}

#[test]
fn floating_structure_that_its_interface_does_not_hold() {
    // Two free chains, the interface on one of them: the other moves freely with the interface held.
    let n = 150;
    let mut springs = Springs::new(2 * n);
    for i in 0..2 * n {
        springs.weigh(i, MASS);
        if i + 1 != n && i + 1 != 2 * n {
            springs.connect(i, i + 1, SPRING);
        }
    }
    let (structure, facts) = reduced(&springs, &[10, 70], 1.2);
    assert!(facts.shift_hz > 0.0);
    assert!(facts.fixed_interface_hz[0] < 1e-3 && facts.fixed_interface_hz[1] > 0.01);
    assert!(structure.static_flexibility().is_none());
    let found = hz(&structure);
    assert_eq!(found[..2], [0.0, 0.0]);
    // Two equal chains: one keeps its interface and is cut, the other is all fixed-interface modes and therefore exact.
    assert_close(&found[2..12], (2..12).map(|j| free_hz(n, j / 2)), 1e-3);
    // With all modes it is exact, statically and dynamically.
    let (complete, _) = reduced(&springs, &[10, 70], 100.0);
    assert_close(&hz(&complete)[2..40], (2..40).map(|j| free_hz(n, j / 2)), 1e-9);
}

#[test]
fn constraint_modes_of_a_floating_structure_are_static_solutions() {
    // A chain of 30 on which only the first mass is interface, and a second, free one beside it: between P0 and P1 of the
    // first there are 10 springs in series, whatever floats elsewhere.
    let mut springs = Springs::new(60);
    for i in 0..60 {
        springs.weigh(i, MASS);
        if i != 29 && i != 59 {
            springs.connect(i, i + 1, SPRING);
        }
    }
    let (structure, _) = reduced(&springs, &[5, 15], 1.0);
    let q = structure.k_zz().nrows() - 2;
    let k = SPRING / 10.0;
    for (i, j, exact) in [(0, 0, k), (1, 1, k), (0, 1, -k)] {
        let found = structure.k_zz()[(q + i, q + j)];
        assert!((found / exact - 1.0).abs() < 1e-9, "({i}, {j}): {found} instead of {exact}");
    }
}

#[test]
fn inner_stiffness_that_is_nearly_singular() {
    // The free chain is held by 1e-9 of a spring: 0.0000002 Hz.
    let n = 80;
    let mut springs = Springs::new(2 * n);
    for i in 0..2 * n {
        springs.weigh(i, MASS);
        if i + 1 != n && i + 1 != 2 * n {
            springs.connect(i, i + 1, SPRING);
        }
    }
    springs.ground(0, SPRING);
    springs.ground(n, 1e-9 * SPRING);
    let (structure, facts) = reduced(&springs, &[10], 100.0);
    assert!(facts.shift_hz > 0.0, "{facts:?}");
    let found = hz(&structure);
    assert_eq!(found[0], 0.0);
    let held = |j: usize| 2.0 * (SPRING / MASS).sqrt() * ((2 * j - 1) as f64 * PI / (4.0 * n as f64 + 2.0)).sin() / TAU;
    let mut expected: Vec<f64> = (1..=10).flat_map(|j| [held(j), free_hz(n, j)]).collect();
    expected.sort_by(f64::total_cmp);
    assert_close(&found[1..15], expected.into_iter(), 1e-8);
}

#[test]
fn dofs_without_mass_inside_and_on_the_interface() {
    // Every spring of the chain is two springs in series with a massless DOF between; P1 is such a DOF.
    let n = 60;
    let mut springs = Springs::new(2 * n - 1);
    for i in 0..2 * n - 1 {
        if i % 2 == 0 {
            springs.weigh(i, MASS);
        }
        if i + 1 < 2 * n - 1 {
            springs.connect(i, i + 1, 2.0 * SPRING);
        }
    }
    springs.ground(0, SPRING);
    springs.ground(2 * n - 2, SPRING);
    let (structure, facts) = reduced(&springs, &[20, 51], 100.0);
    assert_eq!(facts.fixed_interface_hz.len(), n - 1);
    let found = hz(&structure);
    assert_eq!(found.len(), n, "massless DOFs bring no mode");
    assert_close(&found, (1..=n).map(|j| held_hz(n, j)), 1e-9);

    let mut free_part = Springs::new(22);
    for i in 0..20 {
        free_part.weigh(i, MASS);
        free_part.ground(i, SPRING);
    }
    free_part.connect(20, 21, SPRING);
    let error = reduce(&free_part.model(&[0]).expect("sound"), &settings(1, 1.0)).expect_err("hangs loose").to_string();
    assert!(error.contains("a part without mass moves freely"), "{error}");
}

#[test]
fn mass_that_is_not_positive_semidefinite_is_refused() {
    let mut springs = chain(200, true);
    springs.mass.add_triplet(90, 91, 2.1);
    springs.mass.add_triplet(91, 90, 2.1);
    let error = springs.model(&[0]).expect_err("indefinite").to_string();
    assert!(
        error.contains("not positive semidefinite: scaled to a diagonal of 1 it has the eigenvalue -5.0"),
        "{error}"
    );
    let mut springs = Springs::new(2);
    springs.weigh(0, 1.0);
    springs.mass.add_triplet(0, 1, 0.5);
    springs.mass.add_triplet(1, 0, 0.5);
    let error = springs.model(&[0]).expect_err("coupled").to_string();
    assert!(error.contains("diagonal 2 is 0, but entry (2, 1)"), "{error}");
}

#[test]
fn points_on_the_same_node_share_their_rows() {
    let springs = chain(40, true);
    let (single, _) = reduced(&springs, &[7, 20], 3.0);
    let (double, facts) = reduced(&springs, &[7, 20, 7], 3.0);
    assert_eq!(facts.interface, 2);
    assert_eq!(hz(&single), hz(&double));
    let options = ModalOptions { cutoff_hz: 3.0, damping: Damping::Ratio(0.01) };
    let points = ["P0", "P1", "P2"].map(|name| road::along(&[(name, 1.0)], X));
    let modes = double.modes_at(&[], &options, &points).expect("modes");
    assert_eq!(road::row(&modes, 0), road::row(&modes, 2));
    assert_ne!(road::row(&modes, 0), road::row(&modes, 1));
}

#[test]
fn interface_dofs_that_are_fixed() {
    // Left in the matrices as an empty row, as programs do with DOFs that they fix themselves.
    let mut springs = Springs::new(31);
    for i in 0..30 {
        springs.weigh(i, MASS);
        springs.ground(i, SPRING);
    }
    let model = springs.model(&[3, 30]).expect("sound");
    let error = reduce(&model, &settings(2, 10.0)).expect_err("empty").to_string();
    assert!(
        error.contains("interface point \"P1\": direction x (row 31) carries neither mass nor stiffness"),
        "{error}"
    );
    let (_, facts) = reduced(&springs, &[3], 10.0);
    assert_eq!((facts.empty_rows, facts.inner), (1, 29));

    // Taken out of the matrices: the label is missing.
    let settings_y = ReductionSettings { interface: vec![("P0".to_owned(), 1)], fixed_interface_cutoff_hz: 10.0 };
    let error = reduce(&model, &settings_y).expect_err("no such row").to_string();
    assert!(error.contains("no row for direction y (it has: x)"), "{error}");

    // Held by a penalty stiffness: it does not move, and the rest is exact.
    let n = 40;
    let mut penalty = chain(n + 2, false);
    penalty.ground(0, 1e36);
    penalty.ground(n + 1, 1e36);
    let (structure, _) = reduced(&penalty, &[0, 12], 100.0);
    let found = hz(&structure);
    assert_close(&found[..n], (1..=n).map(|j| held_hz(n, j)), 1e-9);
    let flexibility = structure.static_flexibility().expect("stands");
    assert!(flexibility[(0, 0)] < 1e-35);
    // 12 springs to one side, 29 to the other.
    assert!((flexibility[(1, 1)] * SPRING * (1.0 / 12.0 + 1.0 / 29.0) - 1.0).abs() < 1e-9);
}

#[test]
fn mode_pairs_of_symmetric_structures_are_complete() {
    // Forty equal chains and one that differs by 1e-10: pairs and clusters of 41.
    let (n, copies) = (25, 41);
    let mut springs = Springs::new(n * copies);
    for copy in 0..copies {
        let k = if copy == 40 { SPRING * (1.0 + 1e-10) } else { SPRING };
        for i in 0..n {
            let row = copy * n + i;
            springs.weigh(row, MASS);
            if i + 1 < n {
                springs.connect(row, row + 1, k);
            }
        }
        springs.ground(copy * n, k);
        springs.ground(copy * n + n - 1, k);
    }
    let cutoff_hz = 0.5 * (held_hz(n, 3) + held_hz(n, 4));
    let (structure, facts) = reduced(&springs, &[0], cutoff_hz);
    // The chain that carries the interface is held there and has its modes elsewhere.
    assert_eq!(facts.fixed_interface_hz.len(), 3 * 40 + 3);
    let found = hz(&structure);
    for j in 1..=3 {
        // All but the chain with the truncated basis are exact.
        let equal = found.iter().filter(|hz| (**hz / held_hz(n, j) - 1.0).abs() < 1e-9).count();
        assert_eq!(equal, 40, "mode {j}");
    }
}

/// What a spread of 1e12 leaves of soft springs that only show in differences of stiff ones: 16 - 12 digits.
#[test]
fn stiffness_spread_of_twelve_orders() {
    // Three masses of the chain are two halves with a spring 1e12 stiffer between them.
    let n = 10;
    let mut springs = Springs::new(n + 3);
    let mut last: Option<usize> = None;
    let mut row = 0;
    for i in 0..n {
        let halves = if [2, 5, 8].contains(&i) { 2 } else { 1 };
        for half in 0..halves {
            springs.weigh(row, MASS / f64::from(halves));
            match last {
                Some(last) => springs.connect(last, row, if half == 1 { 1e12 * SPRING } else { SPRING }),
                None => springs.ground(row, SPRING),
            }
            last = Some(row);
            row += 1;
        }
    }
    springs.ground(row - 1, SPRING);
    let (structure, facts) = reduced(&springs, &[4], 10.0);
    assert_eq!(facts.shift_hz, 0.0);
    let found = hz(&structure);
    assert_close(&found[..n], (1..=n).map(|j| held_hz(n, j)), 1e-3);
    let flexibility = structure.static_flexibility().expect("stands")[(0, 0)];
    let exact = 1.0 / (SPRING * (1.0 / 4.0 + 1.0 / 7.0));
    assert!((flexibility / exact - 1.0).abs() < 1e-3, "{flexibility} {exact}");
    // Stiff springs to ground need no differences and cost nothing.
    let mut held = chain(40, false);
    held.ground(0, 1e12 * SPRING);
    held.ground(39, 1e12 * SPRING);
    let (structure, _) = reduced(&held, &[12], 10.0);
    assert_close(&hz(&structure)[..38], (1..=38).map(|j| held_hz(38, j)), 1e-9);
}

#[test]
fn steps_and_facts_are_told_to_who_asks() {
    let model = chain(300, true).model(&[100]).expect("sound");
    let mut observer = Observer::active();
    let (_, facts) = reduce_observed(&model, &settings(1, 1.0), &mut observer).expect("reduces");
    let names: Vec<&str> = observer.records().iter().map(|record| record.name.as_str()).collect();
    assert!(names.len() >= 6 && names[1].starts_with("count of fixed-interface modes"), "{names:?}");
    assert!(
        observer.records().iter().all(|record| record.time_s >= 0.0 && record.peak_bytes.is_none_or(|b| b > 1 << 20))
    );
    assert!(facts.inner_condition.is_some_and(|condition| condition > 1e3 && condition < 1e5));
    assert_eq!((facts.order, facts.inner, facts.interface), (300, 299, 1));
    assert!(facts.factor_len >= 299);
}

//! The classic slips with matrices of other programs, each made from a right model: told with the right reason, before the work; and
//! right models, of which nothing is said.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use decore_model::structure::{
    FeModel, MatrixFormat, QualityReport, QualitySettings, ReductionSettings, Units, assess, reduce,
};

use crate::outside::{Case, dense, market};

/// Files of the frame: 16 nodes with six directions each, 167.2433 kg, lowest modes 3.8006, 15.7737, 24.3111, 38.6159 Hz.
fn data(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/foreign").join(name)
}

fn text(name: &str) -> String {
    fs::read_to_string(data(name)).expect("shipped")
}

/// Lowest frequencies in Hz with two displacements tied, by elimination with SciPy.
const TIED_HZ: [f64; 4] = [3.8006273258, 20.2044817089, 24.3154781825, 38.6158821524];

const POINTS: &str = "name,role,x_m,y_m,z_m,node\nA,mount,0.5,0,1.2,12\nB,mount,0.5,0.1,0.3,15\n";

/// The frame as it is, with coordinates in its list of rows.
fn frame() -> Case {
    let mut case = Case::new(MatrixFormat::MatrixMarket, POINTS);
    case.write("K", text("frame_K.mtx"));
    case.files.mass.path = case.write("M", text("frame_M.mtx"));
    case.files.dofs = Some(case.write("rows.dof", text("frame.dof")));
    case
}

fn assessed(model: &FeModel) -> QualityReport {
    let interface = (0..3).map(|dof| ("A".to_owned(), dof)).collect();
    let reduction = ReductionSettings { interface, fixed_interface_cutoff_hz: 300.0 };
    assess(model, &QualitySettings { reduction, cutoff_hz: 100.0, damping_ratio: 0.02 }).expect("a report")
}

fn remarks(case: &Case) -> Vec<String> {
    assessed(&case.read().expect("valid")).remarks
}

fn says(case: &Case, wanted: &str) {
    let found = remarks(case);
    assert!(found.iter().any(|remark| remark.contains(wanted)), "{wanted}: {found:?}");
}

/// A list of rows of the frame with its lines changed.
fn relabelled(case: &mut Case, line: impl Fn(usize, [f64; 5]) -> [f64; 5]) {
    let lines = text("frame.dof");
    let numbers = |line: &str| -> [f64; 5] {
        let words: Vec<f64> = line.split_whitespace().map(|word| word.parse().expect("a number")).collect();
        words.try_into().expect("five")
    };
    let changed = |(row, text): (usize, &str)| {
        let [node, dof, x, y, z] = line(row, numbers(text));
        format!("{node} {dof} {x} {y} {z}\n")
    };
    case.files.dofs = Some(case.write("rows.dof", lines.lines().enumerate().map(changed).collect::<String>()));
}

/// Entries of a Matrix Market file, from 0.
fn entries(text: &str) -> Vec<(usize, usize, f64)> {
    let entry = |line: &str| {
        let words: Vec<&str> = line.split_whitespace().collect();
        let index = |word: &str| word.parse::<usize>().expect("an index") - 1;
        (index(words[0]), index(words[1]), words[2].parse().expect("a number"))
    };
    text.lines().filter(|line| !line.starts_with('%')).skip(1).map(entry).collect()
}

#[test]
fn a_right_frame_gives_no_remark() {
    let mut case = frame();
    let report = assessed(&case.read().expect("valid"));
    assert!(report.remarks.is_empty() && report.notes.is_empty(), "{:?} {:?}", report.remarks, report.notes);
    for (mode, hz) in report.modes.iter().zip([3.8006, 15.7737, 24.3111, 38.6159]) {
        assert!((mode.full_hz - hz).abs() < 1e-4, "{}", mode.full_hz);
    }
    // Without coordinates, without a list, and free of its supports.
    case.files.dofs = None;
    case.files.dofs_per_node = Some(6);
    assert!(remarks(&case).is_empty());
}

#[test]
fn wrong_labels_are_told() {
    const ROTATION: &str = "a rotation as a rigid body strains";
    const TRANSLATION: &str = "a translation as a rigid body strains";
    let mut case = frame();
    relabelled(&mut case, |_, [node, dof, x, y, z]| {
        let (block, axis) = ((dof - 1.0).div_euclid(3.0), (dof - 1.0).rem_euclid(3.0));
        [node, 3.0 * block + (axis + 2.0).rem_euclid(3.0) + 1.0, x, y, z]
    });
    says(&case, ROTATION);
    says(&case, "are directions permuted");
    relabelled(&mut case, |_, [node, dof, x, y, z]| [node, dof, 1e3 * x, 1e3 * y, 1e3 * z]);
    case.write("points.csv", POINTS.replace("0.5,0,1.2", "500,0,1200").replace("0.5,0.1,0.3", "500,100,300"));
    says(&case, ROTATION);
    case.write("points.csv", POINTS);
    // Field by field: the matrices hold all x, then all y, while the list goes by nodes.
    let mut fields = frame();
    for (name, text) in [("K", text("frame_K.mtx")), ("M", text("frame_M.mtx"))] {
        let place = |row: usize| 16 * (row % 6) + row / 6;
        let moved: Vec<_> = entries(&text)
            .into_iter()
            .map(|(row, column, value)| {
                let (row, column) = (place(row), place(column));
                (row.max(column), row.min(column), value)
            })
            .collect();
        fields.write(name, market(96, &moved));
    }
    says(&fields, TRANSLATION);
    says(&fields, "in another order than the rows");
    fields.files.dofs = None;
    fields.files.dofs_per_node = Some(6);
    says(&fields, TRANSLATION);
    // Shuffled.
    let shuffled = text("frame.dof");
    let mut lines: Vec<&str> = shuffled.lines().collect();
    let count = lines.len();
    (0..count).for_each(|row| lines.swap(row, (row * 37 + 11) % count));
    case.files.dofs = Some(case.write("rows.dof", lines.join("\n")));
    says(&case, TRANSLATION);
}

/// A cube of n x n x n nodes 0.05 m apart, each joined to its 26 neighbours by a spring, on soft springs at its corner. In its list of rows
/// the directions are `axes`. `spread`: share by which springs differ; `digits`: of the stiffness.
fn lattice(n: usize, axes: [usize; 3], spread: f64, digits: usize) -> Case {
    let number = |at: [usize; 3]| (at[0] * n + at[1]) * n + at[2];
    let each = || (0..n).flat_map(move |i| (0..n).flat_map(move |j| (0..n).map(move |k| [i, j, k])));
    let mut stiffness: BTreeMap<(usize, usize), f64> = (0..3).map(|row| ((row, row), 1e6)).collect();
    for at in each() {
        for step in (0..27_usize).map(|s| [s / 9, s / 3 % 3, s % 3]).filter(|step| *step != [1; 3]) {
            let other = [0, 1, 2].map(|axis| (at[axis] + step[axis]).wrapping_sub(1));
            if other.iter().any(|index| *index >= n) {
                continue;
            }
            let along = step.map(|step| step as f64 - 1.0);
            let differs = spread * ((number(at) + number(other)) % 97) as f64 / 97.0;
            let k = 1.1e9 * (1.0 + differs) / along.iter().map(|value| value * value).sum::<f64>();
            for (i, j) in (0..9).map(|pair| (pair / 3, pair % 3)).filter(|(i, j)| along[*i] * along[*j] != 0.0) {
                let own = 3 * number(at);
                *stiffness.entry((own + i, own + j)).or_default() += k * along[i] * along[j];
                *stiffness.entry((own + i, 3 * number(other) + j)).or_default() -= k * along[i] * along[j];
            }
        }
    }
    let rounded = |value: f64| format!("{value:.*e}", digits - 1).parse().expect("a number");
    let lower = stiffness.into_iter().filter(|((row, column), value)| row >= column && *value != 0.0);
    let entries: Vec<_> = lower.map(|((row, column), value)| (row, column, rounded(value))).collect();
    let rows = 3 * n * n * n;
    let mut case = Case::new(MatrixFormat::MatrixMarket, "name,x_m,y_m,z_m,node\nA,0,0,0,1\n");
    case.write("K", market(rows, &entries));
    case.files.mass.path = case.write("M", market(rows, &(0..rows).map(|row| (row, row, 0.98)).collect::<Vec<_>>()));
    let line = |at: [usize; 3], axis: usize| {
        let [x, y, z] = at.map(|index| 0.05 * index as f64);
        format!("{} {} {x} {y} {z}\n", number(at) + 1, axes[axis] + 1)
    };
    case.files.dofs =
        Some(case.write("rows.dof", each().flat_map(|at| (0..3).map(move |axis| line(at, axis))).collect::<String>()));
    case
}

#[test]
fn permuted_directions_of_a_large_block_are_told() {
    // All nodes within are in balance under every linear motion: 35 % of the nodes are at the surface.
    const N: usize = 15;
    let said = |axes: [usize; 3]| {
        let model = lattice(N, axes, 0.0, 17).read().expect("valid");
        let settings = ReductionSettings { interface: vec![("A".to_owned(), 2)], fixed_interface_cutoff_hz: 200.0 };
        reduce(&model, &settings).expect("reduces").remarks().to_vec()
    };
    assert_eq!(said([0, 1, 2]), Vec::<String>::new());
    for axes in [[2, 0, 1], [1, 0, 2]] {
        let found = said(axes);
        assert!(found.len() == 1 && found[0].starts_with("a rotation as a rigid body strains"), "{found:?}");
    }
}

#[test]
fn a_failure_names_what_looks_wrong() {
    // With four digits a cube on soft springs is not positive definite.
    let model = lattice(7, [0, 1, 2], 0.3, 4).read().expect("valid");
    let settings = ReductionSettings { interface: vec![("A".to_owned(), 2)], fixed_interface_cutoff_hz: 200.0 };
    let error = reduce(&model, &settings).expect_err("refused").to_string();
    assert!(
        error.starts_with("the matrices look wrong: the entries of the stiffness have 4 significant digits"),
        "{error}"
    );
}

#[test]
fn other_units_are_converted_and_told_where_they_are_not_named() {
    // Coordinates in mm, rotations against mN mm: as NX writes mm, kg, s.
    let mut case = frame();
    let turns = |row: usize| i32::from(row % 6 >= 3);
    for (name, text) in [("K", text("frame_K.mtx")), ("M", text("frame_M.mtx"))] {
        let scaled =
            |(row, column, value): (usize, usize, f64)| (row, column, value * 1e3_f64.powi(turns(row) + turns(column)));
        case.write(name, market(96, &entries(&text).into_iter().map(scaled).collect::<Vec<_>>()));
    }
    says(&case, "a rotation as a rigid body strains");
    relabelled(&mut case, |_, [node, dof, x, y, z]| [node, dof, 1e3 * x, 1e3 * y, 1e3 * z]);
    case.files.units = Units::MillimetreKilogramSecond;
    let right = frame();
    let report = assessed(&case.read().expect("valid"));
    assert!(report.remarks.is_empty(), "{:?}", report.remarks);
    assert!((report.modes[0].full_hz - 3.8006).abs() < 1e-4);
    let (found, exact) = (case.read().expect("valid"), right.read().expect("valid"));
    for (found, exact) in [(found.stiffness(), exact.stiffness()), (found.mass(), exact.mass())] {
        let largest = dense(exact).into_iter().flatten().fold(0.0, f64::max);
        let pairs = dense(found).into_iter().flatten().zip(dense(exact).into_iter().flatten());
        assert!(pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 1e-12 * largest);
    }
    // Without coordinates the size of elements tells.
    case.files.units = Units::Si;
    case.files.dofs = None;
    case.files.dofs_per_node = Some(6);
    says(&case, "against rotation and displacement are in the ratio of elements of");
    // A unit of each kind: 1 in, 1 lbf s2/in.
    let mut inch = Case::new(MatrixFormat::MatrixMarket, "name,role,x_m,y_m,z_m,node\nA,mount,0,0,0,1\n");
    inch.write("K", market(2, &[(0, 0, 1.0), (1, 1, 1.0)]));
    inch.files.mass.path = inch.write("M", market(2, &[(0, 0, 1.0), (1, 1, 1.0)]));
    inch.files.dofs = Some(inch.write("rows.dof", "1.1\n1.4\n"));
    inch.files.units = Units::InchPoundForceSecond;
    let model = inch.read().expect("valid");
    let expected = [175.126_835_2, 0.112_984_829];
    for (row, value) in expected.into_iter().enumerate() {
        assert!((dense(model.stiffness())[row][row] / value - 1.0).abs() < 1e-8);
        assert_eq!(dense(model.mass())[row][row], dense(model.stiffness())[row][row]);
    }
}

#[test]
fn few_digits_are_told() {
    for digits in [4, 6, 8] {
        let case = frame();
        let rounded = entries(&text("frame_K.mtx"))
            .into_iter()
            .map(|(row, column, value)| (row, column, format!("{value:.*e}", digits - 1).parse().expect("a number")))
            .collect::<Vec<_>>();
        case.write("K", market(96, &rounded));
        says(&case, &format!("the entries of the stiffness have {digits} significant digits"));
    }
}

#[test]
fn multipliers_are_eliminated() {
    let mut case = frame();
    case.write("K", text("multiplier_K.mtx"));
    case.write("M", text("frame_M.mtx").replacen("96 96 ", "97 97 ", 1));
    case.write("points.csv", "name,role,x_m,y_m,z_m,first_row_0based,dofs\nA,mount,0.5,0,1.2,66,6\n");
    case.files.dofs = None;
    let report = assessed(&case.read().expect("valid"));
    assert!(
        report.notes[0].starts_with("1 Lagrange multiplier (the first is row 97): 1 of 1 constraint"),
        "{:?}",
        report.notes
    );
    assert!(report.remarks.is_empty(), "{:?}", report.remarks);
    for (mode, hz) in report.modes.iter().zip(TIED_HZ) {
        assert!((mode.full_hz / hz - 1.0).abs() < 1e-9, "{} {hz}", mode.full_hz);
    }
    // Two multipliers for the constraint, as Code_Aster has them: the same machine.
    let mut double = entries(&text("multiplier_K.mtx"));
    let constraint: Vec<_> = double.iter().copied().filter(|(row, ..)| *row == 96).collect();
    double.extend(
        constraint.iter().filter(|(row, column, _)| row != column).map(|(_, column, value)| (97, *column, *value)),
    );
    double.retain(|(row, column, _)| (*row, *column) != (96, 96));
    double.extend([(96, 96, -1e8), (97, 96, 1e8), (97, 97, -1e8)]);
    case.write("K", market(98, &double));
    case.write("M", text("frame_M.mtx").replacen("96 96 ", "98 98 ", 1));
    let report = assessed(&case.read().expect("valid"));
    assert!(report.notes[0].starts_with("2 Lagrange multipliers"), "{:?}", report.notes);
    for (mode, hz) in report.modes.iter().zip(TIED_HZ) {
        assert!((mode.full_hz / hz - 1.0).abs() < 1e-9, "{} {hz}", mode.full_hz);
    }
    // A row without mass that is soft against its own motion and coupled to nothing stiff: signs.
    case.write("K", market(98, &[(0, 0, 1e6), (1, 1, -1e6)]));
    case.write("M", market(98, &[(0, 0, 1.0), (1, 1, 1.0)]));
    case.fails("K: diagonal 2 is -1e6: it must not be negative");
}

#[test]
fn rows_held_by_ones_are_left_out() {
    let mut case = frame();
    let bordered = |text: &str| {
        let mut all = entries(text);
        all.extend((96..108).map(|row| (row, row, 1.0)));
        market(108, &all)
    };
    case.write("K", bordered(&text("frame_K.mtx")));
    case.write("M", bordered(&text("frame_M.mtx")));
    let held: String = (0..12).map(|row| format!("{} {}\n", 100 + row / 6, row % 6 + 1)).collect();
    case.files.dofs = Some(case.write("rows.dof", text("frame.dof") + &held));
    let report = assessed(&case.read().expect("valid"));
    assert!(
        report.notes[0].starts_with("12 rows have a diagonal of 1 and nothing else (the first is row 97)"),
        "{:?}",
        report.notes
    );
    assert!(report.remarks.is_empty(), "{:?}", report.remarks);
    assert!((report.modes[0].full_hz - 3.8006).abs() < 1e-4, "{}", report.modes[0].full_hz);
    assert!((report.total_mass_kg.expect("labels")[0] - 167.2433).abs() < 1e-4);
}

#[test]
fn inner_shapes_of_calculix_have_no_mass() {
    let points = "name,role,x_m,y_m,z_m,node\nA,fixture,0.4,0.2,0.06,46\n";
    let mut case = Case::new(MatrixFormat::Calculix, points);
    case.files.stiffness.path = data("c3d8i.sti.gz");
    case.files.mass.path = data("c3d8i.mas.gz");
    case.files.dofs = Some(data("c3d8i.dof"));
    case.files.units = Units::MillimetreTonneSecond;
    let report = assessed(&case.read().expect("valid"));
    assert!(report.remarks.is_empty(), "{:?}", report.remarks);
    let mass = report.total_mass_kg.expect("labels");
    assert!(mass.iter().all(|mass| (mass / 113.04 - 1.0).abs() < 1e-3), "{mass:?}");
    assert!((report.modes[0].full_hz / 42.09367 - 1.0).abs() < 1e-6, "{}", report.modes[0].full_hz);
    // With the nodes of the input file also the centre, of a block of 0.6 x 0.4 x 0.06 m.
    case.files.nodes = Some(data("c3d8i.inp"));
    let report = assessed(&case.read().expect("valid"));
    assert!(report.remarks.is_empty(), "{:?}", report.remarks);
    let centre = report.centre_of_mass_m.expect("places");
    assert!(centre.iter().zip([0.3, 0.2, 0.03]).all(|(found, exact)| (found - exact).abs() < 1e-4), "{centre:?}");
}

/// Two rigid bodies (reference nodes 1 and 3, rotation nodes 2 and 4) of ten arms each that end in springs to masses on the ground.
fn two_bodies(points: &str) -> Case {
    const ARMS: usize = 10;
    let rows = 12 + 2 * 3 * ARMS;
    let mut stiffness: BTreeMap<(usize, usize), f64> = BTreeMap::new();
    let mut add = |shape: &[(usize, f64)], k: f64| {
        for (row, a) in shape {
            for (column, b) in shape.iter().filter(|(column, _)| column <= row) {
                *stiffness.entry((*row, *column)).or_default() += k * a * b;
            }
        }
    };
    for body in 0..2 {
        for arm in 0..ARMS {
            let angle = 0.7 * arm as f64;
            let [x, y, z] = [0.3 * angle.cos(), 0.3 * angle.sin(), 0.05 * arm as f64];
            let turned = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]];
            for (axis, turned) in turned.into_iter().enumerate() {
                let own = 12 + 3 * (ARMS * body + arm) + axis;
                let turn = (0..3).map(|about| (6 * body + 3 + about, turned[about]));
                let shape: Vec<_> = [(own, -1.0), (6 * body + axis, 1.0)].into_iter().chain(turn).collect();
                add(&shape, 1e7);
                add(&[(own, 1.0)], 1e6);
            }
        }
    }
    let case = Case::new(MatrixFormat::MatrixMarket, points);
    let entries: Vec<_> = stiffness.into_iter().map(|((row, column), value)| (row, column, value)).collect();
    case.write("K", market(rows, &entries));
    let mass = case.write("M", market(rows, &(0..rows).map(|row| (row, row, 2.0)).collect::<Vec<_>>()));
    let labels: String = (0..rows).map(|row| format!("{}.{}\n", row / 3 + 1, row % 3 + 1)).collect();
    let mut case = case;
    case.files.mass.path = mass;
    case.files.dofs = Some(case.write("rows.dof", labels));
    case
}

#[test]
fn a_rotation_node_of_another_body_is_told() {
    let points = |first: u32, second: u32| {
        format!("name,x_m,y_m,z_m,node,rotation_node\nA,0,0,0,1,{first}\nB,2,0,0,3,{second}\n")
    };
    let right = remarks(&two_bodies(&points(2, 4)));
    assert!(right.is_empty(), "{right:?}");
    says(
        &two_bodies(&points(4, 2)),
        "point A: rotation_node 4 is joined to other rows than node 1 (0 in common): does it belong to another",
    );
    says(&two_bodies(&points(2, 2)), "point B: rotation_node 2 is joined to other rows than node 3");
}

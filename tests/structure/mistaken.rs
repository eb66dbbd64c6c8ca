//! Files that another than the one that was meant hides in: cut between columns, a matrix of another kind, axes of their own; and
//! what a report says of a model that no machine is.

use decore_model::structure::{ExportFormat, MatrixFormat, QualitySettings, ReductionSettings, assess, write_model};

use crate::outside::{Case, as_calculix, decore, dense, full, market, punch, report};

/// A symmetric matrix as DMIG in free field, columns of zeros left out; `lower`: the lower triangle instead of the upper one.
fn dmig(name: &str, matrix: &[Vec<f64>], label: impl Fn(usize) -> (usize, usize), lower: bool) -> String {
    let order = matrix.len();
    let mut text = format!("DMIG,{name},0,6,2,0,,,{order}\n");
    for (column, values) in matrix.iter().enumerate() {
        let rows = if lower { column..order } else { 0..column + 1 };
        let entries: String = rows
            .filter(|row| values[*row] != 0.0)
            .map(|row| format!("*,{},{},{:.15E}\n", label(row).0, label(row).1, values[row]))
            .collect();
        if !entries.is_empty() {
            text += &format!("DMIG*,{name},{},{},\n{entries}", label(column).0, label(column).1);
        }
    }
    text
}

/// Nodes on a line, held at both ends, that move along z.
fn chain(order: usize) -> Vec<Vec<f64>> {
    let entry = |i: usize, j: usize| match i.abs_diff(j) {
        0 => 2e6,
        1 => -1e6,
        _ => 0.0,
    };
    (0..order).map(|i| (0..order).map(|j| entry(i, j)).collect()).collect()
}

fn masses(values: &[f64]) -> Vec<Vec<f64>> {
    let order = values.len();
    (0..order).map(|i| (0..order).map(|j| if i == j { values[i] } else { 0.0 }).collect()).collect()
}

/// The text without its last columns.
fn cut(text: &str, columns: usize) -> String {
    let mut end = text.len();
    for _ in 0..columns {
        end = text[..end].rfind("DMIG*").expect("a column");
    }
    text[..end].to_owned()
}

#[test]
fn a_punch_file_cut_between_columns_is_told() {
    let mut case = Case::new(MatrixFormat::Dmig, "name,role,x_m,y_m,z_m,node\nA,mount,0,0,0,1\n");
    let z = |row: usize| (row + 1, 3);
    let (upper, lower) = (dmig("KAA", &chain(8), z, false), dmig("KAA", &chain(8), z, true));
    let mass = dmig("MAA", &masses(&[5.0; 8]), z, false);
    case.files.mass.path = case.write("M", &mass);
    case.write("K", &upper);
    assert!(report(&case.read().expect("whole")).remarks.is_empty());
    case.write("K", cut(&upper, 3));
    case.fails(
        "K: the file is truncated: its header states 8 columns but it has 5, and from node 6 direction 3 on 3 with mass have no stiffness",
    );
    case.write("K", cut(&lower, 3));
    case.fails(
        "in matrix KAA node 6 direction 3 is coupled to others, but its own entry (6, 3) of the diagonal is missing",
    );
    let last = upper.trim_end().rfind('\n').expect("lines");
    case.write("K", &upper[..=last]);
    case.fails("in matrix KAA node 8 direction 3 is coupled to others, but its own entry");

    // Columns without mass are left out by right; where they are the last ones, who exported them knows better.
    case.write("K", &upper);
    case.write("M", dmig("MAA", &masses(&[5.0, 0.0, 5.0, 5.0, 5.0, 5.0, 5.0, 0.0]), z, false));
    assert!(report(&case.read().expect("valid")).remarks.is_empty());
    case.write("M", cut(&mass, 2));
    let remarks = report(&case.read().expect("valid")).remarks;
    assert!(
        remarks.iter().any(|remark| remark.contains(
            "M: the header states 8 columns, 6 are there, and from node 7 direction 3 on 2 with stiffness have no mass"
        )),
        "{remarks:?}"
    );
}

#[test]
fn more_motions_than_a_machine_has_are_told() {
    let remarks = |stiffness: &[(usize, usize, f64)], rows: usize| {
        let mut case = Case::new(MatrixFormat::MatrixMarket, "name,role,x_m,y_m,z_m,node\nA,mount,0,0,0,1\n");
        case.write("K", market(rows, stiffness));
        case.files.mass.path = case.write("M", market(rows, &(0..rows).map(|row| (row, row, 2.0)).collect::<Vec<_>>()));
        case.files.dofs =
            Some(case.write("rows.dof", (0..rows).map(|row| format!("{}.3\n", row + 1)).collect::<String>()));
        report(&case.read().expect("valid")).remarks
    };
    // Pairs of masses with a spring between, that nothing holds.
    let pairs = |count: usize| -> Vec<(usize, usize, f64)> {
        let pair = |pair: usize| {
            let (i, j) = (2 * pair, 2 * pair + 1);
            [(i, i, 1e6), (j, i, -1e6), (j, j, 1e6)]
        };
        (0..count).flat_map(pair).collect()
    };
    assert!(remarks(&pairs(6), 12).is_empty());
    let found = remarks(&pairs(7), 14);
    assert!(found.len() == 1 && found[0].starts_with("7 modes at 0 Hz: a machine that floats has 6;"), "{found:?}");
    let found = remarks(&pairs(2), 6);
    assert!(
        found.len() == 1 && found[0].starts_with("2 rows with mass but no stiffness, the first node 5 z"),
        "{found:?}"
    );
}

#[test]
fn a_stiffness_without_digits_and_a_band_without_modes_are_told() {
    // Two nodes with a spring between that is stiffer than what holds them, and one that is held by far more.
    let remarks = |between: f64, held: f64| {
        let mut case = Case::new(MatrixFormat::MatrixMarket, "name,role,x_m,y_m,z_m,node\nA,mount,0,0,0,1\n");
        let stiffness = [(0, 0, between + 2e6), (1, 0, -between), (1, 1, between + 1e6), (2, 1, -1e6), (2, 2, held)];
        case.write("K", market(3, &stiffness));
        case.files.mass.path = case.write("M", market(3, &[(0, 0, 5.0), (1, 1, 5.0), (2, 2, 5.0)]));
        case.files.dofs = Some(case.write("rows.dof", "1.3\n2.3\n3.3\n"));
        report(&case.read().expect("valid")).remarks
    };
    assert!(remarks(1e12, 2e6).is_empty() && remarks(1e6, 1e36).is_empty());
    let found = remarks(4e20, 2e6);
    assert!(found.iter().any(|remark| remark.starts_with("the stiffness is ill-conditioned")), "{found:?}");
    let found = remarks(1e15, 1e300);
    assert!(found.is_empty(), "{found:?}");
    let mut stiff = Case::new(MatrixFormat::MatrixMarket, "name,role,x_m,y_m,z_m,node\nA,mount,0,0,0,1\n");
    stiff.write("K", market(1, &[(0, 0, 1e300)]));
    stiff.files.mass.path = stiff.write("M", market(1, &[(0, 0, 5.0)]));
    stiff.files.dofs = Some(stiff.write("rows.dof", "1.3\n"));
    let found = report(&stiff.read().expect("valid")).remarks;
    assert!(found.len() == 1 && found[0].starts_with("no mode below 5000 Hz (cutoff_hz)"), "{found:?}");
}

#[test]
fn a_punch_file_states_the_axes_of_its_own_matrices() {
    let mut case =
        Case::new(MatrixFormat::Dmig, "name,role,x_m,y_m,z_m,node\nA,mount,0,0,0.3,3\nB,fixture,0.6,0,0.3,11\n");
    // The rows of the table are in rising order, as those without a table are.
    let label = |row: usize| match row {
        0..6 => (3, row + 1),
        6..12 => (11, row - 5),
        _ => (2_995_001, 0),
    };
    let matrices = dmig("KAA", &full(0.3, 1e3), label, false) + &dmig("MAA", &full(1.1, 1.0), label, false);
    let bare = case.write("bare", &matrices);
    let whole = case.write("K", punch() + &matrices);
    case.files.dofs = Some(case.write("se.pch", punch()));
    case.files.stiffness.path = bare.clone();
    case.files.mass.path = bare.clone();
    let expected = case.read().expect("valid");
    // With its table or without, in one file or in that of the stiffness alone.
    let table = case.files.dofs.take();
    for (stiffness, mass, dofs) in
        [(&whole, &whole, None), (&whole, &bare, None), (&bare, &whole, None), (&whole, &whole, table.clone())]
    {
        case.files.stiffness.path.clone_from(stiffness);
        case.files.mass.path.clone_from(mass);
        case.files.dofs = dofs;
        let model = case.read().expect("valid");
        for (found, expected) in [(model.stiffness(), expected.stiffness()), (model.mass(), expected.mass())] {
            let (found, expected) = (dense(found), dense(expected));
            let largest = found.iter().flatten().zip(expected.iter().flatten());
            assert!(largest.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 1e-12 * expected[0][0]);
        }
    }
    assert!((dense(expected.stiffness())[6][6] - full(0.3, 1e3)[8][8]).abs() < 1e-9, "turned");

    let turned =
        punch().replace("0.      0.      0.      1.      0.      0.", "0.      0.      0.      0.      0.      1.");
    case.files.dofs = Some(case.write("se.pch", turned));
    case.fails("K: the displacements of node 11 are along other axes here than in");
    case.files.dofs = None;
    case.write("K", (punch() + &matrices).replace("CORD2R ", "CORD2C "));
    case.fails("displacements of GRID 11: coordinate system 10 is a CORD2C: expected a rectangular one");
    case.write("K", (punch() + &matrices).replace("CORD2R ", "$ORD2R "));
    case.fails("system 10 is not in the file; the matrix is along these axes: add their entry");
}

#[test]
fn of_several_abaqus_blocks_the_one_of_the_type_is_read() {
    let mut case = Case::new(MatrixFormat::Abaqus, "name,role,x_m,y_m,z_m,node\nA,mount,0,0,0,1\n");
    let stiffness = "*MATRIX, TYPE=STIFFNESS\n1,3, 1,3, 3e6\n2,3, 1,3, -1e6\n2,3, 2,3, 1e6\n";
    let mass = "** of the same model\n*Matrix, type = mass\n1,3, 1,3, 2.0\n2,3, 2,3, 4.0\n";
    let damping = "*MATRIX,TYPE=VISCOUS DAMPING\n1,3, 1,3, 7.0\n";
    let both = case.write("K", format!("{mass}{stiffness}{damping}"));
    case.files.mass.path.clone_from(&both);
    let model = case.read().expect("valid");
    assert_eq!(dense(model.stiffness()), [[3e6, -1e6], [-1e6, 1e6]]);
    assert_eq!(dense(model.mass()), [[2.0, 0.0], [0.0, 4.0]]);
    case.files.damping = Some(case.files.mass.clone());
    assert_eq!(case.read().expect("valid").damping().map(dense), Some(vec![vec![7.0, 0.0], vec![0.0, 0.0]]));
    case.files.damping = None;

    case.write("K", format!("{stiffness}{mass}{stiffness}"));
    case.fails("K, line 10: a second block of entries that may be the stiffness, the first begins at line 1");
    case.write("K", format!("{}{stiffness}{mass}", stiffness.replace(", TYPE=STIFFNESS", "")));
    case.fails("K, line 6: a second block");
    case.write("K", stiffness);
    case.fails("K: no mass: expected *MATRIX, TYPE=MASS, found TYPE STIFFNESS (line 1)");
    // Of matrix input `TYPE` is the shape, and `MATRIX` says which it is, if anything does.
    let input = |text: &str, words: &str| text.replace("*MATRIX, TYPE=STIFFNESS", words);
    case.files.mass.path = case.write("M", mass);
    for words in ["*MATRIX INPUT, NAME=STIF, TYPE=SYMMETRIC", "*MATRIX INPUT, NAME=S, MATRIX=STIFFNESS, TYPE=SYMMETRIC"]
    {
        case.write("K", input(stiffness, words));
        assert_eq!(dense(case.read().expect("valid").stiffness()), [[3e6, -1e6], [-1e6, 1e6]], "{words}");
    }
    case.write("K", input(stiffness, "*MATRIX INPUT, NAME=M, MATRIX=MASS"));
    case.fails("K: no stiffness: expected *MATRIX, TYPE=STIFFNESS, found TYPE MASS (line 1)");
}

#[test]
fn labels_that_calculix_repeats_are_those_of_inner_rows() {
    const HEAD: &str = "name,role,x_m,y_m,z_m,";
    let mut case = Case::new(MatrixFormat::Calculix, &format!("{HEAD}node\nA,mount,0,0,0,9001\n"));
    let triangle = |matrix: &[Vec<f64>]| -> String {
        let order = matrix.len();
        let pairs = (0..order).flat_map(|column| (0..=column).map(move |row| (row, column)));
        pairs.map(|(row, column)| format!("{} {} {:e}\n", row + 1, column + 1, matrix[row][column])).collect()
    };
    case.write("K", triangle(&chain(6)));
    case.files.mass.path = case.write("M", triangle(&masses(&[5.0; 6])));
    let distinct = "1.3\n9001.3\n11.3\n12.3\n2.3\n22.3\n";
    let expanded = "1.3\n9001.3\n1.3\n1.3\n2.3\n2.3\n";
    let hz = |rows: &str, case: &mut Case| -> Vec<f64> {
        case.files.dofs = Some(case.write("rows.dof", rows));
        let interface = vec![("A".to_owned(), 2)];
        let reduction = ReductionSettings { interface, fixed_interface_cutoff_hz: 1e4 };
        let settings = QualitySettings { reduction, cutoff_hz: 5e3, damping_ratio: 0.02 };
        let report = assess(&case.read().expect("valid"), &settings).expect("a report");
        report.modes.iter().map(|mode| mode.full_hz).collect()
    };
    let expected = hz(distinct, &mut case);
    assert!(expected.len() == 6 && hz(expanded, &mut case) == expected, "{expected:?}");
    let model = case.read().expect("valid");
    assert_eq!(model.rows_of("A"), Ok([None, None, Some(1), None, None, None]));
    let folder = tempfile::tempdir().expect("a folder");
    for format in ExportFormat::all() {
        let by_label = ["dmig", "abaqus"].contains(&format.name());
        assert_eq!(write_model(&model, format, folder.path()).is_err(), by_label, "{}", format.name());
    }

    case.write("points.csv", format!("{HEAD}node\nA,mount,0,0,0,1\n"));
    case.fails(
        "rows.dof: rows 1 and 3 (counted from 1) both are node 1 z, the place of point A, so the point is ambiguous",
    );
    case.write("points.csv", format!("{HEAD}node,rotation_node\nA,mount,0,0,0,9001,2\n"));
    case.fails("rows.dof: rows 5 and 6 (counted from 1) both are node 2 z");
    case.write("points.csv", format!("{HEAD}first_row_0based\nA,mount,0,0,0,0\n"));
    case.files.dofs = Some(case.write("rows.dof", expanded.replace(".3", ".1")));
    assert_eq!(case.read().expect("valid").rows_of("A"), Ok([Some(0), None, None, None, None, None]));

    // Entries that go by node and direction cannot be told apart.
    let mut case = Case::new(MatrixFormat::Abaqus, &format!("{HEAD}node\nA,mount,0,0,0,9001\n"));
    case.files.mass.path = case.write("K", "9001,3, 9001,3, 3e6\n2,3, 2,3, 1e6\n");
    case.files.dofs = Some(case.write("rows.dof", "9001.3\n2.3\n2.3\n"));
    case.fails(
        "rows.dof: rows 2 and 3 (counted from 1) both are node 2 direction 3, and the entries of the matrices go by",
    );
}

#[test]
fn shells_and_beams_of_calculix_have_the_frequencies_that_calculix_finds() {
    // A plate on springs at its corners, a rigid body in its middle.
    let points = "name,role,x_m,y_m,z_m,node,rotation_node\nA,mount,0.3,0.2,0.1,9001,9002\n";
    as_calculix(points, &plate());
    // A cantilever that ends in a rigid body.
    as_calculix(points, &bar());
}

const STEEL: &str = "*MATERIAL,NAME=STEEL\n*ELASTIC\n2.1e11,0.3\n*DENSITY\n7850.\n";

/// 0.6 x 0.4 x 0.02 m of 8 x 6 elements S8.
fn plate() -> String {
    const N: [usize; 2] = [8, 6];
    let node = |i: usize, j: usize| 1 + i + (2 * N[0] + 1) * j;
    let mut text = String::from("*NODE,NSET=ALL\n9001,0.3,0.2,0.1\n9002,0.3,0.2,0.1\n");
    for j in 0..=2 * N[1] {
        for i in (0..=2 * N[0]).filter(|i| i % 2 == 0 || j % 2 == 0) {
            text += &format!("{},{},{},0.\n", node(i, j), 0.0375 * i as f64, j as f64 / 30.0);
        }
    }
    text += "*ELEMENT,TYPE=S8,ELSET=PLATE\n";
    for element in 0..N[0] * N[1] {
        let (i, j) = (2 * (element % N[0]), 2 * (element / N[0]));
        let corners = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1)];
        let nodes = corners.map(|(a, b)| node(i + a, j + b).to_string());
        text += &format!("{},{}\n", element + 1, nodes.join(","));
    }
    text += STEEL;
    text += "*SHELL SECTION,ELSET=PLATE,MATERIAL=STEEL\n0.02\n*NSET,NSET=MIDDLE\n";
    for (i, j) in (7..=9).flat_map(|i| (5..=7).map(move |j| (i, j))).filter(|(i, j)| i % 2 == 0 || j % 2 == 0) {
        text += &format!("{},\n", node(i, j));
    }
    text += "*RIGID BODY,NSET=MIDDLE,REF NODE=9001,ROT NODE=9002\n";
    text += "*ELEMENT,TYPE=MASS,ELSET=MASS\n5001,9001\n*MASS,ELSET=MASS\n3.\n";
    let corners = [(0, 0), (2 * N[0], 0), (0, 2 * N[1]), (2 * N[0], 2 * N[1])];
    for (spring, (corner, axis)) in (0..4).flat_map(|corner| (0..3).map(move |axis| (corner, axis))).enumerate() {
        let (i, j) = corners[corner];
        let stiffness = [2e5, 3e5, 1e6][axis];
        text += &format!(
            "*ELEMENT,TYPE=SPRING1,ELSET=SP{spring}\n{},{}\n*SPRING,ELSET=SP{spring}\n{}\n{stiffness:?}\n",
            6001 + spring,
            node(i, j),
            axis + 1
        );
    }
    text
}

/// 0.8 m of 10 elements B32 with 40 x 30 mm.
fn bar() -> String {
    let mut text = String::from("*NODE,NSET=ALL\n9001,0.8,0.,0.\n9002,0.8,0.,0.\n");
    (0..21).for_each(|i| text += &format!("{},{},0.,0.\n", i + 1, 0.04 * f64::from(i)));
    text += "*ELEMENT,TYPE=B32,ELSET=BAR\n";
    (0..10).for_each(|i| text += &format!("{},{},{},{}\n", i + 1, 2 * i + 1, 2 * i + 2, 2 * i + 3));
    text += STEEL;
    text += "*BEAM SECTION,ELSET=BAR,MATERIAL=STEEL,SECTION=RECT\n0.04,0.03\n0.,0.,1.\n*BOUNDARY\n1,1,6\n*NSET,NSET=TIP\n21\n";
    text + "*RIGID BODY,NSET=TIP,REF NODE=9001,ROT NODE=9002\n*ELEMENT,TYPE=MASS,ELSET=MASS\n500,9001\n*MASS,ELSET=MASS\n1.5\n"
}

#[test]
fn a_mount_needs_its_vertical_alone_where_housings_are_part_of_the_machine() {
    let case = Case::new(
        MatrixFormat::MatrixMarket,
        "name,role,x_m,y_m,z_m,node\nR1,mount,0,0,2,1\nT1,fixture,0,0,0,2\nT2,fixture,0.3,0,0,3\n",
    );
    case.write("K.mtx", market(3, &[(0, 0, 2e7), (1, 0, -1e7), (1, 1, 2e7), (2, 2, 1e7)]));
    case.write("M.mtx", market(3, &[(0, 0, 500.0), (1, 1, 500.0), (2, 2, 500.0)]));
    case.write("rows.dof", "1.3\n2.3\n3.3\n");
    let study = |housings: &str| {
        let text = format!(
            "duration_s = 0.1\n[hammer.h]\nmount = \"R1\"\n[casting.c]\nmass_kg = 3.0\n[casting.c.fixture.f]\npoint = \"T1\"\n\
             [structure]\nsource = \"matrices\"\nstiffness_file = \"K.mtx\"\nmass_file = \"M.mtx\"\ndof_file = \"rows.dof\"\n\
             points_file = \"points.csv\"\nhousings = \"{housings}\"\ncache = false\n"
        );
        decore(&["scene", &case.write("study.toml", text).display().to_string()])
    };
    let included = study("included");
    assert!(included.status.success(), "{}", String::from_utf8_lossy(&included.stderr));
    let added = study("add");
    let error = String::from_utf8_lossy(&added.stderr).into_owned();
    assert!(
        !added.status.success() && error.contains("needs all six only where the hammers' housings are added"),
        "{error}"
    );
}

#[test]
fn two_words_a_value_in_single_precision_are_read_where_all_strings_have_them() {
    let mut case = Case::new(MatrixFormat::Op4, "name,role,x_m,y_m,z_m,node\nA,mount,0,0,0,1\n");
    case.files.dofs = Some(case.write("rows.dof", "1.1\n2.1\n"));
    let matrix = |name: &str, heads: [i64; 2]| {
        let column = |column: usize, head: i64, values: &str| {
            format!("{column:>8}{:>8}{:>8}\n{head:>8}{:>8}\n{values}\n", 0, head + 1, 1)
        };
        format!("{:>8}{:>8}{:>8}{:>8}{name:<8}1P,3E16.9\n", 2, -2, 6, 1)
            + &column(1, heads[0], " 3.000000000E+00-1.000000000E+00")
            + &column(2, heads[1], "-1.000000000E+00 2.000000000E+00")
            + "       3       1       1\n 1.000000000E+00\n"
    };
    let write = |heads| case.write("K", matrix("KAA", heads) + &matrix("MAA", heads));
    for head in [3, 5] {
        write([head; 2]);
        assert_eq!(dense(case.read().expect("valid").stiffness()), [[3.0, -1.0], [-1.0, 2.0]], "{head}");
    }
    // In one way or the other, not both: of one of these two strings half may be missing.
    for heads in [[3, 5], [5, 3]] {
        write(heads);
        case.fails("column 2 announces");
    }
}

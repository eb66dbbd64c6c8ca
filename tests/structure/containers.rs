//! Superelements as Abaqus and CalculiX write them, and matrices of SciPy.

use std::fs;
use std::path::PathBuf;

use decore_model::structure::{DofLabel, MatrixFormat};

use crate::outside::{Case, dense};

const POINTS: &str = "name,x_m,y_m,z_m,node\nA,0,0,0,11\n";

fn data(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/formats").join(name)
}

fn tiny() -> String {
    fs::read_to_string(data("tiny_user_element.mtx")).expect("shipped")
}

#[test]
fn a_superelement_of_calculix_names_a_node_per_row() {
    let mut case = Case::new(MatrixFormat::Abaqus, "name,x_m,y_m,z_m,node\nA,0,0,0.2,9\n");
    case.files.stiffness.path = data("ccx_superelement.mtx");
    case.files.mass.path =
        case.write("M", "9,1, 9,1, 2.0\n9,2, 9,2, 2.0\n9,3, 9,3, 2.0\n10,1, 10,1, 3.0\n11,3, 11,3, 4.0\n");
    let model = case.read().expect("valid");
    let label = |node, dof| DofLabel { node, dof };
    let labels = [label(9, 0), label(9, 1), label(9, 2), label(10, 0), label(10, 1), label(11, 2)];
    assert_eq!(model.labels(), labels);
    // Of the whole model by *FREQUENCY, SOLVER=MATRIXSTORAGE.
    let exact = [
        [4.93589744e9, 1.68269231e9, -1.68269231e9, -2.24358974e9, 3.36538462e8, -1.68269231e8],
        [1.68269231e9, 4.93589744e9, -1.68269231e9, -3.36538462e8, 1.12179487e9, -1.68269231e8],
        [-1.68269231e9, -1.68269231e9, 4.93589744e9, 3.36538462e8, -8.41346154e8, -1.12179487e8],
        [-2.24358974e9, -3.36538462e8, 3.36538462e8, 4.93589744e9, -1.68269231e9, 8.41346154e8],
        [3.36538462e8, 1.12179487e9, -8.41346154e8, -1.68269231e9, 4.93589744e9, -3.36538462e8],
        [-1.68269231e8, -1.68269231e8, -1.12179487e8, 8.41346154e8, -3.36538462e8, 4.93589744e9],
    ];
    for (found, exact) in dense(model.stiffness()).iter().flatten().zip(exact.iter().flatten()) {
        assert!((found / exact - 1.0).abs() < 1e-8, "{found} {exact}");
    }
    case.files.mass.path.clone_from(&case.files.stiffness.path);
    case.fails("no mass: expected *MATRIX, TYPE=MASS behind *USER ELEMENT, found TYPE STIFFNESS (line 12); CalculiX writes no mass");
}

#[test]
fn user_elements_add_up_and_their_directions_may_change() {
    // Three nodes, the last with x alone; a second element of the last two.
    let element = |nodes: &str, directions: &str, values: &str| {
        let count = nodes.split(',').count();
        format!(
            "*User Element, nodes={count}, linear\n** ELEMENT NODES\n** {nodes}\n{directions}*Matrix, type=stiffness\n{values}"
        )
    };
    let first = element("1, 2, 3", "1,3\n3,1\n", "9.,\n0., 8.\n1., 0., 7.\n0., 2., 0., 6.\n\n3., 0., 0., 0.\n5.,\n");
    let second = element("2, 3", "1\n", "10.\n-10., 10.\n");
    let case = Case::new(MatrixFormat::Abaqus, "name,x_m,y_m,z_m,node\nA,0,0,0,1\n");
    let mut case = case;
    case.files.mass.path = case.write("M", "1,1, 1,1, 1.\n2,1, 2,1, 1.\n");
    case.write("K", first + &second);
    let model = case.read().expect("valid");
    let rows = [(1, 0), (1, 2), (2, 0), (2, 2), (3, 0)].map(|(node, dof)| DofLabel { node, dof });
    assert_eq!(model.labels(), rows);
    let expected = [
        [9.0, 0.0, 1.0, 0.0, 3.0],
        [0.0, 8.0, 0.0, 2.0, 0.0],
        [1.0, 0.0, 17.0, 0.0, -10.0],
        [0.0, 2.0, 0.0, 6.0, 0.0],
        [3.0, 0.0, -10.0, 0.0, 15.0],
    ];
    assert_eq!(dense(model.stiffness()), expected);
}

#[test]
fn faults_of_user_elements_name_their_line() {
    let mut case = Case::new(MatrixFormat::Abaqus, POINTS);
    case.files.mass.path = data("tiny_user_element.mtx");
    let text = tiny();
    let fails = |from: &str, to: &str, wanted: &str| {
        assert!(text.contains(from), "{from}");
        case.write("K", text.replacen(from, to, 1));
        case.fails(wanted);
    };
    fails("NODES=2", "NODES=3", "K, line 6: expected 21 values of the lower triangle for 6 rows of 3 nodes, found 10");
    fails("11, 12\n", "11, 12, 13\n", "K, line 2: NODES=2, but 3 nodes are listed");
    fails("NODES=2", "NODES=x", "K, line 2: expected NODES= from 1 to");
    fails("  1,  3\n", "  1,  7\n", "K, line 5: expected directions 1 to 6");
    fails("  1,  3\n", "  1,  3\n4,1\n", "K, line 6: expected the position of a node from 2 to 2");
    fails("  1,  3\n", "", "K, line 5: expected 0 values of the lower triangle for 0 rows of 2 nodes, found 10");
    fails(
        ",  2.5000000000000E+03\n*MATRIX",
        "\n*MATRIX",
        "K, line 6: expected 10 values of the lower triangle for 4 rows of 2 nodes, found 9: is the file truncated",
    );
    fails("3.0000000000000E+03", "3.0x", "K, line 7: expected a finite number, found \"3.0x\"");
    fails("TYPE=STIFFNESS", "TYPE=STIFFNESS, INPUT=k.txt", "K, line 6: the values are in another file");
    // Without the comment the rows are numbered.
    case.files.dofs = Some(data("tiny.dofmap"));
    case.write("K", text.replace("** ELEMENT NODES\n**  11, 12\n", ""));
    assert_eq!(dense(case.read().expect("valid").stiffness())[0][2], -1e3);
}

#[test]
fn damaged_archives_are_told() {
    let mut case = Case::new(MatrixFormat::Npz, POINTS);
    case.files.dofs = Some(data("tiny.dofmap"));
    case.files.mass.path = data("tiny_M_csc.npz");
    let packed = fs::read(data("tiny_K_csr.npz")).expect("shipped");
    case.write("K", &packed[..packed.len() - 30]);
    case.fails("K: the file is truncated or no archive: expected a file of scipy.sparse.save_npz");
    case.write("K", tiny());
    case.fails("K: the file is truncated or no archive");
    let plain = fs::read(data("tiny_M_csc.npz")).expect("shipped");
    let at = plain.windows(3).rposition(|window| window == b"csc").expect("its format");
    let mut flipped = plain.clone();
    flipped[at] = b'b';
    case.write("K", flipped);
    case.fails("K: array \"format\": the file is truncated or damaged");
    // A flipped bit of the values is told by their sum.
    for at in (0..plain.len() - 6).filter(|at| plain[*at..].starts_with(b"\x93NUMPY")) {
        let mut flipped = plain.clone();
        flipped[at + 100] ^= 1;
        case.write("K", flipped);
        case.fails("the file is truncated or damaged");
    }
}

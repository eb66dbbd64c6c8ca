//! Machines as other programs hand them over: rows that a list of rows decides, OUTPUT4 files of every kind, superelements with
//! their tables, sizes that a file does not bear out, matrices that make no sense.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::op4_files::{Form, Matrix, file};
use crate::road;
use decore_model::structure::{
    Damping, DofLabel, ExportFormat, FeModel, InterfacePoint, InterfacePoints, MatrixFile, MatrixFormat, ModalOptions,
    ModelFiles, ModelMatrices, PointPlace, QualityReport, QualitySettings, ReductionSettings, Units, assess, reduce,
    write_model,
};
use sprs::{CsMat, TriMat};
use tempfile::TempDir;

/// A folder with files, and a model read from them.
pub struct Case {
    pub folder: TempDir,
    pub files: ModelFiles,
}

impl Case {
    pub fn new(format: MatrixFormat, points: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        fs::write(path("points.csv"), points).expect("written");
        let matrix = |name: &str| MatrixFile { path: path("K"), name: name.to_owned() };
        let files = ModelFiles {
            format,
            units: Units::Si,
            stiffness: matrix("KAA"),
            mass: matrix("MAA"),
            damping: None,
            dofs: None,
            nodes: None,
            dofs_per_node: None,
            points: path("points.csv"),
        };
        Self { folder, files }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        fs::write(self.path(name), bytes).expect("written");
        self.path(name)
    }

    pub fn read(&self) -> Result<FeModel, String> {
        FeModel::read(&self.files).map_err(|error| error.to_string())
    }

    pub fn fails(&self, wanted: &str) {
        let error = self.read().err().unwrap_or_else(|| panic!("read, but expected: {wanted}"));
        assert!(error.contains(wanted), "{error}");
    }
}

pub fn dense(matrix: &CsMat<f64>) -> Vec<Vec<f64>> {
    (0..matrix.rows()).map(|i| (0..matrix.cols()).map(|j| matrix.get(i, j).copied().unwrap_or(0.0)).collect()).collect()
}

pub fn market(order: usize, entries: &[(usize, usize, f64)]) -> String {
    let head = format!("%%MatrixMarket matrix coordinate real symmetric\n{order} {order} {}\n", entries.len());
    entries.iter().fold(head, |text, (row, column, value)| text + &format!("{} {} {value:e}\n", row + 1, column + 1))
}

fn diagonal(order: usize) -> String {
    market(order, &(0..order).map(|row| (row, row, 9.0 + row as f64)).collect::<Vec<_>>())
}

#[test]
fn rows_of_a_point_are_those_of_its_node() {
    let points = |text: &str| format!("name,role,x_m,y_m,z_m,{text}\n");
    let mut case = Case::new(MatrixFormat::MatrixMarket, &points("first_row_0based\nA,mount,0,0,0,3"));
    case.write("K", diagonal(12));
    case.files.mass = case.files.stiffness.clone();
    // Four nodes of a solid: the three rows after A's displacements are the next node's.
    let solid: String = (1..=4).flat_map(|node| (1..=3).map(move |dof| format!("{node}.{dof}\n"))).collect();
    case.files.dofs = Some(case.write("rows.dof", &solid));
    let rows = |case: &Case| case.read().expect("valid").rows_of("A").expect("known");
    let three = [Some(3), Some(4), Some(5), None, None, None];
    assert_eq!(rows(&case), three);
    let retold = case.read().expect("valid").points().to_csv();
    assert!(retold.contains("first_row_0based,dofs\nA,mount,0e0,0e0,0e0,3,3\n"), "{retold}");
    case.write("points.csv", points("first_row_0based,dofs\nA,mount,0,0,0,3,6"));
    case.fails(
        "rows 3 to 8 (counted from 0, dofs = 6) do not belong to one node: row 3 is node 2 x, but row 6 is node 3 x",
    );
    case.write("points.csv", points("first_row_0based,dofs\nA,mount,0,0,0,4,3"));
    case.fails("row 4 (counted from 0) is node 2 y, but a point begins with the x displacement");
    case.write("points.csv", points("first_row_0based,dofs\nA,mount,0,0,0,4,"));
    case.fails("row 4 (counted from 0) is node 2 y");

    // A list that begins a node with another direction, and one with a modal coordinate.
    case.files.dofs = Some(case.write("rows.dof", solid.replace("2.1\n2.2\n2.3", "2.2\n2.3\n2.4")));
    case.write("points.csv", points("first_row_0based,dofs\nA,mount,0,0,0,3,3"));
    case.fails("row 3 (counted from 0) is node 2 y");
    case.files.dofs = Some(case.write("rows.dof", solid.replace("2.1\n", "2.0\n")));
    case.fails("row 3 (counted from 0) is modal coordinate 2");

    // Without a list the number of DOFs per node decides, or the table has to say it.
    case.files.dofs = None;
    case.write("points.csv", points("first_row_0based\nA,mount,0,0,0,3"));
    case.fails("point A: column dofs (3 or 6) is missing");
    case.files.dofs_per_node = Some(3);
    assert_eq!(rows(&case), three);
    case.files.dofs_per_node = Some(6);
    case.fails("row 3 (counted from 0) is node 1 rx");
    case.write("points.csv", points("first_row_0based\nA,mount,0,0,0,6"));
    assert_eq!(rows(&case), [Some(6), Some(7), Some(8), Some(9), Some(10), Some(11)]);
    case.write("K", diagonal(10));
    case.fails("10 rows are not a whole number of nodes with dofs_per_node = 6");
    case.files.dofs_per_node = None;
    case.write("points.csv", points("first_row_0based,dofs\nA,mount,0,0,0,0,6\nB,mount,0,0,0,3,3"));
    case.fails("row 3 (counted from 0) is direction rx of point A and x of point B");
}

const POINT: &str = "name,role,x_m,y_m,z_m,first_row_0based,dofs\nA,mount,0,0,0,0,3\n";

/// Stiffness and mass of four rows among matrices that are neither; the values are exact in single precision.
fn superelement() -> (Vec<Matrix>, [Vec<Vec<f64>>; 2]) {
    let k = [[3.0, 0.0, -1.0, 0.5], [0.0, 5.0, 0.0, -2.5], [-1.0, 0.0, 1.5, 0.0], [0.5, -2.5, 0.0, 2.5]];
    let m = [[2.0, 0.0, 0.25, 0.0], [0.0, 2.0, 0.0, 0.0], [0.25, 0.0, 1.5, 0.0], [0.0, 0.0, 0.0, 0.0]];
    let table = |rows: &[[f64; 4]]| rows.iter().map(|row| row.to_vec()).collect::<Vec<_>>();
    let (k, m) = (table(&k), table(&m));
    let all = vec![
        Matrix::real("MUG1", table(&[[1.0, 0.0, 0.0, 4.0], [0.0, -7.5, 1.0, 0.0], [0.0, 0.0, 0.0, 2.0]])),
        Matrix::real("KAA", k.clone()),
        Matrix::real("VA", vec![vec![1.0]; 4]),
        Matrix::complex("QHH", vec![vec![1.0, -2.0], vec![0.0, 3.0]]),
        Matrix::real("MAA", m.clone()),
        Matrix::real("PA", vec![vec![0.0]; 4]),
    ];
    (all, [k, m])
}

#[test]
fn the_named_matrix_is_read_from_every_kind_of_output4() {
    let (matrices, [k, m]) = superelement();
    let case = Case::new(MatrixFormat::Op4, POINT);
    let mut kinds = 0;
    for form in Form::all() {
        case.write("K", file(&matrices, &form));
        let model = case.read().unwrap_or_else(|error| panic!("{form:?}: {error}"));
        assert_eq!(dense(model.stiffness()), k, "{form:?}");
        assert_eq!(dense(model.mass()), m, "{form:?}");
        kinds += 1;
    }
    // Text and four binaries (two byte orders, two sizes of integers), single and double, dense, bigmat and nonbigmat.
    assert_eq!(kinds, 30);
}

#[test]
fn an_error_lists_what_an_output4_file_holds() {
    let (matrices, _) = superelement();
    let mut case = Case::new(MatrixFormat::Op4, POINT);
    for form in [Form::text(), Form::binary()] {
        case.write("K", file(&matrices, &form));
        let refuses = |case: &mut Case, name: &str, wanted: &str| {
            case.files.stiffness.name = name.to_owned();
            case.fails(wanted);
            case.fails(
                "the file holds MUG1 (3 x 4, real double), KAA (4 x 4, real double), VA (4 x 1, real double), QHH (2 x 2, complex double)",
            );
            case.files.stiffness.name = "KAA".to_owned();
        };
        refuses(&mut case, "KXX", "no matrix KXX; the file holds");
        refuses(&mut case, "va", "VA has 4 rows and 1 columns: expected a square matrix");
        refuses(&mut case, "QHH", "QHH is a complex matrix: expected a real one");
        refuses(&mut case, "KAA#2", "no matrix KAA#2: there are 1 of that name");
    }
    // Several matrices of a name: none is taken without being told apart.
    let twice = [Matrix::real("MAA", vec![vec![1.0; 2]; 2]), matrices[1].clone(), matrices[4].clone()];
    case.write("K", file(&twice, &Form::binary()));
    case.fails("2 matrices MAA; name one of them, MAA#1 to MAA#2; the file holds MAA (2 x 2, real double), KAA");
    case.files.mass.name = "maa#2".to_owned();
    assert_eq!(dense(case.read().expect("valid").mass())[0], [2.0, 0.0, 0.25, 0.0]);
    // Lines and records that are missing or do not belong there.
    let text = String::from_utf8(file(&matrices[1..2], &Form::text())).expect("text");
    case.files.mass.name = "KAA".to_owned();
    let mut lines: Vec<&str> = text.lines().collect();
    lines.remove(3);
    case.write("K", lines.join("\n"));
    case.fails("announces");
    let factor = text.replacen("       4       4       6", "       4       4       4", 1);
    case.write("K", factor);
    case.fails("line 1: KAA is a triangular factor (form 4)");
    // A square matrix has all its entries: one triangle of it is not the other's mirror.
    let square = text.replacen("       4       4       6", "       4       4       1", 1);
    case.write("K", &square);
    assert_eq!(dense(case.read().expect("valid").stiffness())[0], [3.0, 0.0, -1.0, 0.5]);
    let triangle = vec![vec![3.0, -1.0], vec![0.0, 3.0]];
    let form = |bytes: Vec<u8>, form: u8| {
        String::from_utf8(bytes).expect("text").replacen("       6", &format!("       {form}"), 1)
    };
    let file = |number| form(file(&[Matrix::real("KAA", triangle.clone())], &Form::text()), number);
    case.write("points.csv", POINT.replace("first_row_0based,dofs", "node").replace("0,3\n", "1\n"));
    case.files.dofs = Some(case.write("rows.dof", "1.1\n2.1\n"));
    case.write("K", file(6));
    assert_eq!(dense(case.read().expect("valid").stiffness()), [[3.0, -1.0], [-1.0, 3.0]]);
    case.write("K", file(1));
    case.fails("the matrix is not symmetric: entry (1, 2) is -1e0, entry (2, 1) is 0e0");
    for integers in [24_u32, 48] {
        case.write("K", [integers.to_le_bytes().as_slice(), &[0; 20]].concat());
        case.fails("record 1: the file is truncated");
    }
}

/// A model whose entries lie far from its diagonal.
fn scattered(n: usize) -> FeModel {
    let (mut k, mut m) = (TriMat::new((n, n)), TriMat::new((n, n)));
    for row in 0..n {
        k.add_triplet(row, row, 4e6 + row as f64 / 3.0);
        m.add_triplet(row, row, 1.0 / 7.0);
        if row != n - 1 - row {
            k.add_triplet(row, n - 1 - row, if row == 0 || row == n - 1 { -1.25e-120 } else { -1e6 / 3.0 });
        }
    }
    let labels = (0..n).map(|row| DofLabel { node: (row / 3) as i64 + 1, dof: row % 3 }).collect();
    let place = PointPlace::Rows { first: 0, dofs: None };
    let point = InterfacePoint { name: "A".to_owned(), role: "mount".to_owned(), place, position_m: [0.0; 3] };
    let matrices = ModelMatrices { mass: m.to_csr(), stiffness: k.to_csr(), damping: None, labels };
    FeModel::new(matrices, InterfacePoints::new(vec![point]).expect("unique")).expect("sound")
}

fn export(name: &str) -> ExportFormat {
    ExportFormat::named(name).expect("a name of the list")
}

#[test]
fn output4_is_written_sparse_and_whole() {
    let model = scattered(1800);
    let folder = tempfile::tempdir().expect("a folder");
    let size = |path: &Path| fs::metadata(path).expect("written").len();
    let market = write_model(&model, export("matrix_market"), folder.path()).expect("written");
    for format in [export("op4"), export("op4_binary")] {
        let files = write_model(&model, format, folder.path()).expect("written");
        assert!(
            size(&files.stiffness.path) < 5 * size(&market.stiffness.path) / 2,
            "strings of one entry, both triangles"
        );
        let read = FeModel::read(&files).expect("valid");
        assert_eq!(dense(read.stiffness()), dense(model.stiffness()));
        assert_eq!(dense(read.mass()), dense(model.mass()));
    }
}

#[test]
fn node_numbers_that_nastran_does_not_have_are_not_written() {
    let model = scattered(6);
    let labels = model.labels().iter().map(|label| DofLabel { node: label.node - 1, ..*label }).collect();
    let model = FeModel::new(ModelMatrices { labels, ..model.matrices().clone() }, model.points().clone());
    let folder = tempfile::tempdir().expect("a folder");
    let error = write_model(&model.expect("sound"), export("dmig"), folder.path()).expect_err("node 0").to_string();
    assert!(error.contains("nodes numbered from 1 on, as Nastran has them, found node 0"), "{error}");
}

#[test]
fn memory_is_not_asked_for_by_a_number_in_a_file() {
    let mut case = Case::new(MatrixFormat::Abaqus, POINT);
    case.files.mass = case.files.stiffness.clone();
    for order in ["4294967294", "4000000000", "200000000"] {
        case.write("K", format!("1,1,5.0\n{order},{order},2.0\n"));
        case.fails(&format!("{order} rows, but only 2 entries"));
    }
    case.write("K", "1,1,5.0\n9000000000000000000,1,2.0\n");
    case.fails("line 2: row out of range");
    case.files.format = MatrixFormat::MatrixMarket;
    for order in ["9000000000000000000", "4000000000", "200000000"] {
        case.write("K", format!("%%MatrixMarket matrix coordinate real symmetric\n{order} {order} 1\n1 1 2.0\n"));
        case.fails(&format!("{order} rows"));
    }
    // Rows that a list names may be empty, however many: a mass of 120,000 rows with one entry.
    let n = 120_000;
    let dense_enough: Vec<_> = (0..n).map(|row| (row, row, 1e6)).collect();
    case.files.stiffness.path = case.write("all", market(n, &dense_enough));
    case.write("K", market(n, &[(0, 0, 5.0)]));
    case.fails("120000 rows, but only 1 entries");
    case.files.dofs = Some(
        case.write("rows.dof", (0..n).map(|row| format!("{}.{}\n", row / 3 + 1, row % 3 + 1)).collect::<String>()),
    );
    assert_eq!(case.read().expect("valid").order(), n);
    case.files.dofs = None;
    case.files.stiffness = case.files.mass.clone();
    case.files.format = MatrixFormat::HarwellBoeing;
    for (size, wanted) in [
        ("18446744073709551615 18446744073709551615 1 0", "line 3: expected rows, columns and entries (at most"),
        ("4000000000 4000000000 1 0", "line 5: column pointer: expected 1 to 2"),
        ("2 2 18446744073709551615 0", "line 3: expected rows, columns and entries (at most"),
    ] {
        case.write("K", format!("t\n4 1 1 1 0\nRSA {size}\n(1I14)(1I14)(1E26.17)\n9\n"));
        case.fails(wanted);
    }
    case.write("K", "t\n4 1 1 1 0\nRSA 1 1 1 0\n(18446744073709551615I18446744073709551615)(1I1)(1I1)\n1\n2\n1\n1\n");
    case.fails("line 4: expected three formats");
    case.files.format = MatrixFormat::Op4;
    case.write(
        "K",
        "200000002000000006       2KAA     1P,3E23.16\n       1       1       1\n 1.0000000000000000E+00\n",
    );
    case.fails("line 1");
    for name in ["KAA", "MAA"] {
        let head = "       200000000       200000000       6       2";
        let text = format!(
            "{head}{name:<8}1P,3E23.16|I16\n       1       1       1\n 1.0000000000000000E+00\n200000001 1 1\n 1.0000000000000000E+00\n"
        );
        case.write("K", text);
        case.files.stiffness.name = name.to_owned();
        case.fails("200000000 rows, but only 1 entries");
    }
}

#[test]
fn marks_and_umlauts_of_other_programs_are_read() {
    let mut case = Case::new(MatrixFormat::Dmig, "\u{feff}name,role,x_m,y_m,z_m,node\nA,mount,0,0,0,1\n");
    let punch = "DMIG,KAA,0,6,2,0,,,3\nDMIG,KAA,1,1,,1,1,4.5\nDMIG,MAA,0,6,2,0,,,3\nDMIG,MAA,1,1,,1,1,2.5\n";
    let latin = [b"$ St\xfctze, M\xe4rz\n".as_slice(), punch.as_bytes()].concat();
    for bytes in [latin, [b"\xef\xbb\xbf".as_slice(), punch.as_bytes()].concat()] {
        case.write("K", bytes);
        assert_eq!(dense(case.read().expect("valid").stiffness()), [[4.5]]);
    }
    case.write("K", [0xff, 0xfe, b'D', 0]);
    case.fails("line 1: not text in UTF-8: it begins as UTF-16 or binary");
    case.write("K", b"DMIG\x00\x01\n");
    case.fails("line 1: not text: a byte 0");
    // A square matrix has all its entries.
    let square = punch.replacen("0,6,2", "0,1,2", 1);
    case.write("K", square.replace("1,1,,1,1,4.5", "1,1,,1,1,4.5\n,2,1,-1.5\nDMIG,KAA,2,1,,2,1,4.5"));
    case.fails("the matrix is not symmetric");
    // Matrix Market with a mark, as Windows programs write it.
    case.files.format = MatrixFormat::MatrixMarket;
    case.files.mass = case.files.stiffness.clone();
    case.write("K", format!("\u{feff}{}", diagonal(3)));
    case.write("points.csv", POINT);
    assert_eq!(case.read().expect("valid").order(), 3);
}

/// Two free nodes on springs with a modal coordinate, the second with axes of its own, as Nastran writes a superelement.
pub fn punch() -> String {
    let lines = [
        "$ BOUNDARY GRID DATA",
        "BEGIN SUPER       75",
        "EXTRN          3  123456      11  123456 2995001       0",
        "GRID           3       0      0.      0.    300.       0",
        "GRID          11       0    600.      0.    300.      10",
        "CORD2R        10       0      0.      0.      0.      1.      0.      0.",
        "              0.      1.      0.",
        "SPOINT   2995001",
    ];
    lines.join("\n") + "\n"
}

/// A symmetric positive definite matrix of 13 rows that nothing simple describes.
pub fn full(seed: f64, size: f64) -> Vec<Vec<f64>> {
    let entry = |i: usize, j: usize| {
        let wave = ((i + j) as f64 * 1.7 + seed).sin() + ((i * j) as f64 * 0.3 + seed).cos();
        size * if i == j { 30.0 + i as f64 } else { wave }
    };
    (0..13).map(|i| (0..13).map(|j| entry(i, j)).collect()).collect()
}

#[test]
fn a_superelement_stands_on_its_own_table_of_rows() {
    let mut case =
        Case::new(MatrixFormat::Op4, "name,role,x_m,y_m,z_m,node\nA,mount,0,0,0.3,3\nB,fixture,0.6,0,0.3,11\n");
    let (k, m) = (full(0.3, 1e3), full(1.1, 1.0));
    case.write("K", file(&[Matrix::real("KAA", k.clone()), Matrix::real("MAA", m)], &Form::binary()));
    case.files.dofs = Some(case.write("se.pch", punch()));
    let model = case.read().expect("valid");
    assert_eq!(model.rows_of("A"), Ok(std::array::from_fn(Some)));
    assert_eq!(model.rows_of("B"), Ok(std::array::from_fn(|dof| Some(6 + dof))));
    // System 10: z along the basic x, x along the basic y, y along the basic z.
    let local = |row: usize| if (6..12).contains(&row) { [2, 0, 1, 5, 3, 4][row - 6] + 6 } else { row };
    for (i, row) in dense(model.stiffness()).iter().enumerate() {
        for (j, value) in row.iter().enumerate() {
            let expected = k[local(i)][local(j)];
            assert!((value - expected).abs() <= 1e-12 * expected.abs(), "({i}, {j}): {value} instead of {expected}");
        }
    }
    // Without EXTRN all six directions are taken; a table with fewer rows than the matrices is an error that says so.
    let assembly =
        "SECONCT       75       0\n               3       3      11      11\nGRID           3\nGRID          11\n";
    case.files.dofs = Some(case.write("se.asm", assembly));
    case.fails("13 rows, but the list of rows has 12; SECONCT does not contain the retained directions");
    case.files.dofs = Some(
        case.write("se.asm", assembly.replace("11      11\n", "11      11 2995001 2995001\n") + "SPOINT   2995001\n"),
    );
    assert_eq!(case.read().expect("valid").rows_of("B"), Ok(std::array::from_fn(|dof| Some(6 + dof))));
    let partly = punch().replace("11  123456", "11   23456");
    case.write(
        "K",
        file(
            &[Matrix::real("KAA", vec![vec![1.0; 12]; 12]), Matrix::real("MAA", vec![vec![1.0; 12]; 12])],
            &Form::text(),
        ),
    );
    case.files.dofs = Some(case.write("se.pch", partly));
    case.fails("node 11 has displacements along axes of its own, but not all three");
}

/// Masses in kg at places in m, each on springs in x, y, z.
fn masses(at: &[(f64, [f64; 3])], scale: [f64; 2]) -> Case {
    let points = "name,role,x_m,y_m,z_m,node\nA,mount,0,0,0,1\n";
    let mut case = Case::new(MatrixFormat::MatrixMarket, points);
    let entry = |value: &dyn Fn(usize) -> f64| (0..3 * at.len()).map(|row| (row, row, value(row))).collect::<Vec<_>>();
    let stiffness = entry(&|row| scale[0] * 1e7 * (1.0 + row as f64));
    case.write("K", market(3 * at.len(), &stiffness));
    case.files.mass.path = case.write("M", market(3 * at.len(), &entry(&|row| scale[1] * at[row / 3].0)));
    let rows: String = (0..3 * at.len())
        .map(|row| {
            let [x, y, z] = at[row / 3].1;
            format!("{} {} {x} {y} {z}\n", row / 3 + 1, row % 3 + 1)
        })
        .collect();
    case.files.dofs = Some(case.write("rows.dof", rows));
    case
}

const PLACES: [(f64, [f64; 3]); 3] = [(10.0, [0.0, 0.0, 0.0]), (20.0, [1.0, 0.5, 0.25]), (50.0, [2.0, -1.0, 0.5])];

pub fn report(model: &FeModel) -> QualityReport {
    assessed(model).expect("a report")
}

pub fn assessed(model: &FeModel) -> Result<QualityReport, String> {
    let reduction = ReductionSettings { interface: vec![("A".to_owned(), 2)], fixed_interface_cutoff_hz: 1e4 };
    assess(model, &QualitySettings { reduction, cutoff_hz: 5e3, damping_ratio: 0.02 })
        .map_err(|error| error.to_string())
}

#[test]
fn a_report_weighs_the_machine_and_says_what_looks_wrong() {
    let sound = report(&masses(&PLACES, [1.0, 1.0]).read().expect("valid"));
    assert!(sound.remarks.is_empty(), "{:?}", sound.remarks);
    let total = sound.total_mass_kg.expect("labels");
    assert!(total.iter().all(|mass| (mass - 80.0).abs() < 1e-9), "{total:?}");
    // (20 + 100, 10 - 50, 5 + 25) / 80.
    let centre = sound.centre_of_mass_m.expect("places");
    assert!(centre.iter().zip([1.5, -0.5, 0.375]).all(|(found, exact)| (found - exact).abs() < 1e-12), "{centre:?}");

    let says = |scale: [f64; 2], wanted: &str| {
        let found = report(&masses(&PLACES, scale).read().expect("valid")).remarks;
        assert!(found.iter().any(|remark| remark.contains(wanted)), "{wanted}: {found:?}");
    };
    let moved = masses(&PLACES, [1.0, 1.0]);
    moved.write("points.csv", "name,role,x_m,y_m,z_m,node\nA,mount,1000,500,250,2\n");
    let found = report(&moved.read().expect("valid")).remarks;
    assert!(
        found[0].contains("node 2 lies at [1000.0, 500.0, 250.0] m by the table of points, but at [1.0, 0.5, 0.25] m"),
        "{found:?}"
    );
    says([2.5e28, 2.5e28], "a mass of 2.000e30 kg (along x): machines have 1 to 1e6 kg");
    says([1e-3, 1e-3], "does `units` match the matrices (mm, t, s are \"mm_t_s\")");
    let refused = |case: &Case| assessed(&case.read().expect("valid")).expect_err("exchanged");
    let found = refused(&masses(&PLACES, [1e-9, 1.0]));
    assert!(found.starts_with("stiffness and mass look exchanged"), "{found}");

    let mut case = masses(&PLACES, [1.0, 1.0]);
    let entries: Vec<_> = (0..9).map(|row| (row, row, if row % 3 == 1 { 5.0 } else { 9.0 })).collect();
    case.write("M", market(9, &entries));
    let uneven = report(&case.read().expect("valid")).remarks;
    assert!(
        uneven.iter().any(|remark| remark.contains("not the same in all directions (x 2.7000e1, y 1.5000e1")),
        "{uneven:?}"
    );
    case.write("M", market(9, &[(0, 0, 0.0)]));
    case.fails("M: every entry is 0");
    std::mem::swap(&mut case.files.mass, &mut case.files.stiffness);
    case.write("K", diagonal(9));
    case.fails("M: every entry is 0");
    let free = (0..3).flat_map(|axis| [(axis, axis, 2e6), (axis + 3, axis, -1e6), (axis + 3, axis + 3, 1e6)]);
    let mut exchanged = masses(&PLACES[..2], [1.0, 1.0]);
    exchanged.write("K", market(6, &free.collect::<Vec<_>>()));
    std::mem::swap(&mut exchanged.files.mass, &mut exchanged.files.stiffness);
    let found = refused(&exchanged);
    assert!(found.starts_with("stiffness and mass look exchanged"), "{found}");
}

pub fn decore(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_decore")).args(arguments).output().expect("runs")
}

#[test]
fn the_text_report_begins_with_mass_and_frequencies() {
    let case = masses(&PLACES, [2.5e28, 2.5e28]);
    let study = "[structure]\nsource = \"matrices\"\nformat = \"matrix_market\"\nstiffness_file = \"K\"\nmass_file = \"M\"\n\
                 dof_file = \"rows.dof\"\npoints_file = \"points.csv\"\ncutoff_hz = 1000.0\n";
    let study = case.write("machine.toml", study);
    let path = study.display().to_string();
    let output = decore(&["structure", &path]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(&lines[..2], ["mass           2.000000e30 kg", "centre of mass 1.5000, -0.5000, 0.3750 m"]);
    // sqrt(1e7 / 10) and sqrt(7e7 / 50) rad/s.
    assert!(lines[2].starts_with("lowest modes   159.1549, 188.3147, "), "{text}");
    assert!(lines[3].starts_with("looks wrong    a mass of 2.000e30 kg"), "{text}");
    let rig = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/paper_rig.toml").display().to_string();
    let folder = case.folder.path().display().to_string();
    let export = |format: &str| {
        let output = decore(&["structure", &rig, "--export", format, "--to", &folder, "--replace"]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    // Rotations of a solid node that Nastran keeps as empty rows are no interface.
    let rows: String = (1..=6).map(|dof| format!("1.{dof}\n")).collect();
    case.write("rows.dof", rows);
    for (name, scale) in [("K", 1e6), ("M", 1.0)] {
        let entries = [(0, 0, 1e3), (1, 1, 2e3), (2, 2, 3e3), (5, 5, 0.0)].map(|(i, j, value)| (i, j, scale * value));
        case.write(name, market(6, &entries));
    }
    let output = decore(&["structure", &path]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        text.contains("model          6 rows, 3 of them interface"),
        "{text}{}",
        String::from_utf8_lossy(&output.stderr)
    );
    assert!(export("dmig").contains("DMIG entries have ten digits"));
    assert!(!export("op4").contains("ten digits"));
}

/// `DECORE_CCX` names CalculiX.
#[test]
fn a_beam_of_calculix_has_the_frequencies_that_calculix_finds() {
    as_calculix("name,role,x_m,y_m,z_m,node\nA,mount,0.4,0,0.05,63\n", &beam());
}

/// Compares frequencies with those that CalculiX itself finds; `deck`: a model without its step, held or on springs. The interface
/// is x, y and z of point A.
pub fn as_calculix(points: &str, deck: &str) {
    let Some(program) = std::env::var_os("DECORE_CCX") else {
        eprintln!("DECORE_CCX is not set: CalculiX was not tried");
        return;
    };
    let mut case = Case::new(MatrixFormat::Calculix, points);
    let run = |job: &str, step: &str| {
        case.write(&format!("{job}.inp"), format!("{deck}*STEP\n{step}*END STEP\n"));
        let output = Command::new(&program).args(["-i", job]).current_dir(case.folder.path()).output().expect("starts");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
    };
    run("matrices", "*FREQUENCY,SOLVER=MATRIXSTORAGE\n");
    run("modes", "*FREQUENCY\n6\n");
    let table = fs::read_to_string(case.path("modes.dat")).expect("written by CalculiX");
    let expected: Vec<f64> = table
        .lines()
        .map(|line| line.split_whitespace().collect::<Vec<_>>())
        .filter(|words| words.len() == 5 && words[0].parse::<usize>().is_ok())
        .map(|words| words[3].parse().expect("Hz"))
        .collect();
    assert_eq!(expected.len(), 6);
    case.files.stiffness.path = case.path("matrices.sti");
    case.files.mass.path = case.path("matrices.mas");
    case.files.dofs = Some(case.path("matrices.dof"));
    let interface = (0..3).map(|dof| ("A".to_owned(), dof)).collect();
    let settings = ReductionSettings { interface, fixed_interface_cutoff_hz: 1e5 };
    let structure = reduce(&case.read().expect("valid"), &settings).expect("reduces");
    let options = ModalOptions { cutoff_hz: 1e4, damping: Damping::Ratio(0.02) };
    let found = road::hz(&structure, &[], &options);
    for (found, expected) in found.iter().zip(&expected) {
        // Seven digits are printed.
        assert!((found / expected - 1.0).abs() < 1e-6, "{found} instead of {expected}");
    }
}

/// A cantilever of 8 x 2 x 2 elements in CalculiX' words: 0.4 m of steel, held at x = 0.
fn beam() -> String {
    const N: [usize; 3] = [8, 2, 2];
    let node = |i: usize, j: usize, k: usize| 1 + i + (N[0] + 1) * (j + (N[1] + 1) * k);
    let mut text = String::from("*NODE,NSET=ALL\n");
    let mut held = String::new();
    for (k, j) in (0..=N[2]).flat_map(|k| (0..=N[1]).map(move |j| (k, j))) {
        for i in 0..=N[0] {
            let at = [i as f64 * 0.05, j as f64 * 0.025, k as f64 * 0.025];
            text += &format!("{},{},{},{}\n", node(i, j, k), at[0], at[1], at[2]);
        }
        held += &format!("{},1,3\n", node(0, j, k));
    }
    text += "*ELEMENT,TYPE=C3D8,ELSET=BODY\n";
    for element in 0..N[0] * N[1] * N[2] {
        let (i, j, k) = (element % N[0], element / N[0] % N[1], element / (N[0] * N[1]));
        let corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)];
        let nodes = corners.map(|(a, b, c)| node(i + a, j + b, k + c).to_string());
        text += &format!("{},{}\n", element + 1, nodes.join(","));
    }
    text += "*MATERIAL,NAME=STEEL\n*ELASTIC\n2.1e11,0.3\n*DENSITY\n7850.\n*SOLID SECTION,ELSET=BODY,MATERIAL=STEEL\n";
    text + "*BOUNDARY\n" + &held
}

//! Every exchange format: small files with known matrices, a real CalculiX model against scipy's reduction of it, a reduced
//! frame through Nastran's formats, round trips of the station, units, and wrong files.
//!
//! `tests/data/formats` holds the same four DOFs in every format, `tests/data/solid` a station of 9762 DOF of quadratic
//! tetrahedra as CalculiX exports it, and `reduction.json` what scipy's Craig-Bampton makes of it.

use std::fs;
use std::path::{Path, PathBuf};

use decore_files::Limit;
use decore_model::structure::{
    CACHE_FOLDER, CacheOutcome, Damping, ExportFormat, FeModel, InterfacePoints, MatrixFile, MatrixFormat,
    ModalOptions, ModelFiles, ModelMatrices, ModesAt, QualitySettings, ReducedStructure, ReductionSettings,
    StructureError, Units, assess, cache_path, reduce, reduce_files, write_model,
};
use serde_json::Value;
use sprs::CsMat;

use crate::road;

const Z: [f64; 3] = [0.0, 0.0, 1.0];

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

fn matrix(path: PathBuf, name: &str) -> MatrixFile {
    MatrixFile { path, name: name.to_owned() }
}

fn export(name: &str) -> ExportFormat {
    ExportFormat::named(name).expect("a name of the list")
}

fn files(format: MatrixFormat, stiffness: PathBuf, mass: PathBuf, points: PathBuf) -> ModelFiles {
    ModelFiles {
        format,
        units: Units::Si,
        stiffness: matrix(stiffness, "KAAX"),
        mass: matrix(mass, "MAAX"),
        damping: None,
        dofs: None,
        nodes: None,
        dofs_per_node: None,
        points,
    }
}

fn dense(matrix: &CsMat<f64>) -> Vec<Vec<f64>> {
    (0..matrix.rows()).map(|i| (0..matrix.cols()).map(|j| matrix.get(i, j).copied().unwrap_or(0.0)).collect()).collect()
}

const TINY_K: [[f64; 4]; 4] =
    [[3e3, 0.0, -1e3, 0.0], [0.0, 5e3, 0.0, -2.5e3], [-1e3, 0.0, 1e3, 0.0], [0.0, -2.5e3, 0.0, 2.5e3]];
const TINY_M: [[f64; 4]; 4] =
    [[2.0, 0.0, 0.25, 0.0], [0.0, 2.0, 0.0, 0.0], [0.25, 0.0, 1.5, 0.0], [0.0, 0.0, 0.0, 1.5]];

/// A line with a tab for the blanks at the end of every eight columns.
fn with_tabs(line: &str) -> String {
    let columns: Vec<char> = line.chars().collect();
    let field = |field: &[char]| {
        let text: String = field.iter().collect();
        if field.len() == 8 && text.ends_with(' ') { format!("{}\t", text.trim_end()) } else { text }
    };
    columns.chunks(8).map(field).collect()
}

#[test]
fn the_same_small_model_in_every_format() {
    let folder = tempfile::tempdir().expect("a folder");
    let points = folder.path().join("points.csv");
    fs::write(&points, "name,role,x_m,y_m,z_m,node\nA,mount,0,0,0,11\nB,fixture,1,0,0,12\n").expect("written");
    let tiny = |name: &str| data("formats").join(format!("tiny{name}"));
    let cases = [
        (MatrixFormat::MatrixMarket, "_K.mtx", "_M.mtx", Some(".dofmap")),
        (MatrixFormat::Calculix, "_ccxstyle.sti", "_ccxstyle.mas", Some("_ccxstyle.dof")),
        (MatrixFormat::Dmig, "_nastranstyle.pch", "_nastranstyle.pch", None),
        (MatrixFormat::Dmig, "_dmig_small.bdf", "_dmig_small.bdf", None),
        (MatrixFormat::Dmig, "_dmig_large.bdf", "_dmig_large.bdf", None),
        (MatrixFormat::Op4, "_ascii_d.op4", "_ascii_d.op4", Some(".dofmap")),
        (MatrixFormat::Op4, "_ascii_sparse.op4", "_ascii_sparse.op4", Some(".dofmap")),
        (MatrixFormat::Op4, "_binary_handmade.op4", "_binary_handmade.op4", Some("_ccxstyle.dof")),
        (MatrixFormat::HarwellBoeing, "_hbstyle_K.matrix", "_hbstyle_M.matrix", Some(".dofmap")),
        (MatrixFormat::Abaqus, "_user_element.mtx", "_user_element.mtx", None),
        (MatrixFormat::Npz, "_K_csr.npz", "_M_csc.npz", Some(".dofmap")),
        (MatrixFormat::Npz, "_K_coo.npz", "_M_array.npz", Some(".dofmap")),
    ];
    for (format, stiffness, mass, dofs) in cases {
        let source = ModelFiles { dofs: dofs.map(tiny), ..files(format, tiny(stiffness), tiny(mass), points.clone()) };
        let model = FeModel::read(&source).unwrap_or_else(|error| panic!("{stiffness}: {error}"));
        assert_eq!(dense(model.stiffness()), TINY_K, "{stiffness}");
        assert_eq!(dense(model.mass()), TINY_M, "{mass}");
        assert_eq!(model.rows_of("B"), Ok([Some(2), None, Some(3), None, None, None]));
    }
    // Tabs lead to the next column of eight.
    for name in ["_dmig_small.bdf", "_dmig_large.bdf", "_nastranstyle.pch"] {
        let text = fs::read_to_string(tiny(name)).expect("shipped");
        let tabbed: String = text.lines().map(|line| with_tabs(line) + "\n").collect();
        assert!(tabbed.matches('\t').count() > 20, "{tabbed}");
        let path = folder.path().join("tabs.pch");
        fs::write(&path, tabbed).expect("written");
        let model = FeModel::read(&files(MatrixFormat::Dmig, path.clone(), path, points.clone())).expect(name);
        assert_eq!(
            (dense(model.stiffness()), dense(model.mass())),
            (TINY_K.map(Vec::from).to_vec(), TINY_M.map(Vec::from).to_vec())
        );
    }
    let (k, m) = ("_abaqusstyle_STIF1_matrixinput.mtx", "_abaqusstyle_STIF1_coordinate.mtx");
    for (file, dofs) in [(k, None), (m, Some(tiny(".dofmap")))] {
        let source = ModelFiles { dofs, ..files(MatrixFormat::Abaqus, tiny(file), tiny(file), points.clone()) };
        assert_eq!(dense(FeModel::read(&source).expect("valid").stiffness()), TINY_K, "{file}");
    }
    // A file of CalculiX 2.20 with a rigid body.
    let real = |end: &str| data("formats").join(format!("ccx_real_tiny.{end}"));
    fs::write(&points, "name,role,x_m,y_m,z_m,node,rotation_node\nA,mount,0.5,0.5,1.3,9,10\n").expect("written");
    let source = ModelFiles {
        dofs: Some(real("dof")),
        ..files(MatrixFormat::Calculix, real("sti"), real("mas"), points.clone())
    };
    let model = FeModel::read(&source).expect("valid");
    let rows = model.rows_of("A").expect("known").map(|row| row.expect("six"));
    assert!(model.mass().get(rows[0], rows[0]).is_some_and(|mass| *mass > 27.0));
}

fn solid_files() -> ModelFiles {
    let solid = |name: &str| data("solid").join(name);
    ModelFiles {
        dofs: Some(solid("ccx_raw.dof.gz")),
        ..files(MatrixFormat::Calculix, solid("ccx_raw.sti.gz"), solid("ccx_raw.mas.gz"), solid("points.csv"))
    }
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|number| number.as_f64().expect("a number")).collect()
}

fn hz(structure: &ReducedStructure, cutoff_hz: f64) -> Vec<f64> {
    let options = ModalOptions { cutoff_hz, damping: Damping::Ratio(0.02) };
    road::hz(structure, &[], &options)
}

#[test]
fn calculix_station_reduces_as_scipy_reduces_it() {
    let model = FeModel::read(&solid_files()).expect("valid");
    assert_eq!(model.order(), 9762);
    let reference: Value =
        serde_json::from_str(&fs::read_to_string(data("solid/reduction.json")).expect("there")).expect("JSON");
    let full = numbers(&reference["full_hz"]);
    for (name, set) in reference["sets"].as_object().expect("sets") {
        let directions: &[usize] = if name.starts_with("S1") { &[2] } else { &[0, 1, 2] };
        let interface = ["HREF", "TREF"]
            .iter()
            .flat_map(|point| directions.iter().map(|dof| ((*point).to_owned(), *dof)))
            .collect();
        let settings =
            ReductionSettings { interface, fixed_interface_cutoff_hz: set["fmax"].as_f64().expect("a number") };
        let reduced = reduce(&model, &settings).expect("reduces");
        let modes = set["n_fixed_modes"].as_u64().expect("a number") as usize;
        assert_eq!(reduced.m_zz().nrows(), modes + 2 * directions.len(), "{name}");
        let found = hz(&reduced, 400.0);
        let expected = numbers(&set["reduced_hz_below_400"]);
        for (f, e) in found.iter().zip(&expected) {
            assert!((f / e - 1.0).abs() < 1e-8, "{name}: {f} instead of {e}");
        }
        let error =
            found.iter().zip(&full).filter(|(_, full)| **full < 300.0).map(|(f, g)| f / g - 1.0).fold(0.0, f64::max);
        let stated = set["max_rel_err_below_300"].as_f64().expect("a number");
        assert!((error - stated).abs() < 1e-3 * stated + 2e-9, "{name}: {error:e} instead of {stated:e}");
        let stiffness = reduced.static_flexibility().expect("stands").clone().try_inverse().expect("regular");
        for (i, row) in set["static_Kbb_full"].as_array().expect("rows").iter().map(numbers).enumerate() {
            for (j, expected) in row.iter().enumerate() {
                let scale = (stiffness[(i, i)] * stiffness[(j, j)]).sqrt();
                assert!((stiffness[(i, j)] - expected).abs() < 1e-9 * scale, "{name} ({i}, {j})");
            }
        }
    }
}

#[test]
fn calculix_station_has_the_frequencies_of_the_full_model() {
    let model = FeModel::read(&solid_files()).expect("valid");
    let reference: Value =
        serde_json::from_str(&fs::read_to_string(data("solid/reduction.json")).expect("there")).expect("JSON");
    let reduction = ReductionSettings { interface: vec![("HREF".to_owned(), 2)], fixed_interface_cutoff_hz: 600.0 };
    let report =
        assess(&model, &QualitySettings { reduction, cutoff_hz: 300.0, damping_ratio: 0.02 }).expect("a report");
    let full = numbers(&reference["full_hz"]);
    assert!(report.modes.len() >= full.len() && full.len() >= 20);
    for (mode, expected) in report.modes.iter().zip(&full) {
        // The lowest frequencies of a stiffness with a condition of 1e9 have so many digits.
        assert!((mode.full_hz / expected - 1.0).abs() < 1e-7, "{} instead of {expected}", mode.full_hz);
    }
    let [x, y, z] = report.total_mass_kg.expect("directions");
    assert!((x - z).abs() < 1e-6 * x && (x - y).abs() < 1e-6 * x && x > 1600.0 && x < 1720.0, "{x} {y} {z}");
    let rotation = ReductionSettings { interface: vec![("R5".to_owned(), 3)], fixed_interface_cutoff_hz: 10.0 };
    let error = reduce(&model, &rotation).expect_err("no rotation").to_string();
    assert!(error.contains("\"R5\": the model has no row for direction rx (it has: x y z)"), "{error}");
}

/// The reduced frame of the built-in station with a housing, as Nastran would hand it over: two points and modal coordinates.
#[test]
fn a_superelement_comes_in_through_op4_and_punch_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let points = folder.path().join("points.csv");
    let reference: Value =
        serde_json::from_str(&fs::read_to_string(data("station_reduction.json")).expect("there")).expect("JSON");
    let expected = numbers(&reference["station"]["sets"]["S1_hammer_fixture_z_f1000"]["reduced_hz_below_400"]);
    let op4 = data("formats/frame_cb_S1_f1000.op4");
    let punch = data("formats/frame_cb_S1_f1000.pch");
    // Ten digits of a punch file leave less than the text of OP4.
    for (format, file, place, digits) in [
        (MatrixFormat::Op4, op4, "first_row_0based,dofs\nH,mount,0,0,0,0,3", 1e-8),
        (MatrixFormat::Dmig, punch, "node\nH,mount,0,0,0,101", 1e-6),
    ] {
        fs::write(&points, format!("name,role,x_m,y_m,z_m,{place}\n")).expect("written");
        let model = FeModel::read(&files(format, file.clone(), file, points.clone())).expect("valid");
        assert_eq!(model.order(), 61);
        let dof = if format == MatrixFormat::Op4 { 0 } else { 2 };
        let settings = ReductionSettings { interface: vec![("H".to_owned(), dof)], fixed_interface_cutoff_hz: 1e5 };
        let found = hz(&reduce(&model, &settings).expect("reduces"), 400.0);
        for (f, e) in found.iter().zip(&expected) {
            assert!((f / e - 1.0).abs() < digits, "{f} instead of {e}");
        }
    }
}

fn station_settings() -> ReductionSettings {
    let mut interface: Vec<(String, usize)> = (0..6).map(|dof| ("R5".to_owned(), dof)).collect();
    interface.push(("T5".to_owned(), 2));
    ReductionSettings { interface, fixed_interface_cutoff_hz: 1500.0 }
}

fn with_damping(model: &FeModel) -> FeModel {
    let matrices = model.matrices().clone();
    let damping = matrices.stiffness.map(|value| 1e-5 * value);
    FeModel::new(ModelMatrices { damping: Some(damping), ..matrices }, model.points().clone()).expect("valid")
}

#[test]
fn what_is_written_reads_back_to_the_same_reduction() {
    let model = with_damping(&FeModel::station().expect("shipped"));
    let direct = reduce(&model, &station_settings()).expect("reduces");
    let options = ModalOptions { cutoff_hz: 1000.0, damping: Damping::Ratio(0.5) };
    let expected = direct.modes_at(&[], &options, &[]).expect("modes");
    // D = beta K: 2 xi omega = beta omega^2.
    for (ratio, omega) in expected.damping_ratio.iter().zip(&expected.omega_rad_s) {
        assert!((ratio / (0.5e-5 * omega) - 1.0).abs() < 1e-8);
    }
    for format in ExportFormat::all() {
        let name = format.name();
        let folder = tempfile::tempdir().expect("a folder");
        let files = write_model(&model, format, folder.path()).unwrap_or_else(|error| panic!("{name}: {error}"));
        let read = FeModel::read(&files).unwrap_or_else(|error| panic!("{name}: {error}"));
        let modes = reduce(&read, &station_settings()).expect("reduces").modes_at(&[], &options, &[]).expect("modes");
        // Ten digits of a full stiffness move the lowest frequencies by some 1e-5.
        // Formats that leave out zeros change the order of elimination, and with it the rounding.
        let bound = if format.loss().is_some() { 2e-4 } else { 1e-9 };
        assert_eq!(modes.omega_rad_s.len(), expected.omega_rad_s.len(), "{name}");
        for (found, exact) in modes.omega_rad_s.iter().zip(&expected.omega_rad_s) {
            assert!((found / exact - 1.0).abs() < bound, "{name}: {found} instead of {exact}");
        }
        for (found, exact) in modes.damping_ratio.iter().zip(&expected.damping_ratio) {
            assert!((found / exact - 1.0).abs() < 10.0 * bound, "{name}: {found} instead of {exact}");
        }
    }
    let nameless =
        FeModel::new(ModelMatrices { labels: Vec::new(), ..model.matrices().clone() }, model.points().clone());
    let folder = tempfile::tempdir().expect("a folder");
    let error = write_model(&nameless.expect("valid"), export("dmig"), folder.path()).expect_err("no labels");
    assert!(error.to_string().contains("nodes and directions of the rows"), "{error}");
}

#[test]
fn tonnes_and_millimetres_become_si() {
    let model = FeModel::station().expect("shipped");
    let folder = tempfile::tempdir().expect("a folder");
    // In mm, t, s: forces in N stay, lengths grow by 1000, so K_tt / 1000, K_rr * 1000, K_tr stay; M alike.
    let scaled = |matrix: &CsMat<f64>| {
        let mut out = matrix.clone();
        for (row, mut view) in out.outer_iterator_mut().enumerate() {
            for (column, value) in view.iter_mut() {
                *value *= match (row % 6 < 3, column % 6 < 3) {
                    (true, true) => 1e-3,
                    (false, false) => 1e3,
                    _ => 1.0,
                };
            }
        }
        out
    };
    let matrices = ModelMatrices {
        mass: scaled(model.mass()),
        stiffness: scaled(model.stiffness()),
        damping: None,
        labels: model.labels().to_vec(),
    };
    let tonnes = FeModel::new(matrices, model.points().clone()).expect("valid");
    let expected = reduce(&model, &station_settings()).expect("reduces");
    let options = ModalOptions { cutoff_hz: 1000.0, damping: Damping::Ratio(0.02) };
    let mount = [road::along(&[("R5", 1.0)], Z)];
    let expected = expected.modes_at(&[], &options, &mount).expect("modes");
    // Each product rounds an entry's last digit, which the lowest frequencies magnify.
    for (labels, bound) in [(true, 1e-9), (false, 1e-9)] {
        let mut files = write_model(&tonnes, export("matrix_market_gz"), folder.path()).expect("written");
        files.units = Units::MillimetreTonneSecond;
        if !labels {
            // Without the list only the rows of interface points are known to be rotations; that is enough.
            files.dofs = None;
        }
        let read = FeModel::read(&files).expect("valid");
        let modes =
            reduce(&read, &station_settings()).expect("reduces").modes_at(&[], &options, &mount).expect("modes");
        for (found, exact) in modes.omega_rad_s.iter().zip(&expected.omega_rad_s) {
            assert!((found / exact - 1.0).abs() < bound, "{found} instead of {exact}");
        }
        let row = |modes: &ModesAt| road::row(modes, 0);
        let largest = row(&expected).iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
        assert!(row(&modes).iter().zip(row(&expected)).all(|(f, e)| (f - e).abs() < 1e-6 * largest));
    }
}

#[test]
fn wrong_and_cut_files_are_named_with_line_and_reason() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    fs::write(path("points.csv"), "name,role,x_m,y_m,z_m,node\nA,mount,0,0,0,11\n").expect("written");
    fs::copy(data("formats/tiny_ccxstyle.dof"), path("rows.dof")).expect("copied");
    let fails = |format: MatrixFormat, bytes: &[u8], wanted: &str| {
        fs::write(path("K"), bytes).expect("written");
        let source =
            ModelFiles { dofs: Some(path("rows.dof")), ..files(format, path("K"), path("K"), path("points.csv")) };
        let error = FeModel::read(&source).expect_err(wanted).to_string();
        assert!(error.contains(wanted) && error.contains(&path("K").display().to_string()), "{error}");
    };
    let text = |name: &str| fs::read_to_string(data("formats").join(name)).expect("there");
    let sti = text("tiny_ccxstyle.sti");
    fails(MatrixFormat::Calculix, &sti.as_bytes()[..sti.len() / 2], "truncated");
    fails(
        MatrixFormat::Calculix,
        b"1 1 2.0\n1 9 1.0\n",
        "K, line 2: column out of range: expected 1 to 4, found \"9\"",
    );
    fails(MatrixFormat::Calculix, b"1 1 2.0\n1 2 1.0\n3 1 1.0\n", "line 3: expected one triangle only");
    fails(MatrixFormat::Calculix, b"1 1 NaN\n", "line 1: expected a finite number, found \"NaN\"");
    fails(MatrixFormat::Calculix, b"1,1,2.0\n", "line 1: expected row, column and value");

    let punch = text("tiny_nastranstyle.pch");
    fails(MatrixFormat::Dmig, punch.replace("KAAX", "KBBX").as_bytes(), "no DMIG matrix KAAX; found: KBBX, MAAX");
    fails(
        MatrixFormat::Dmig,
        punch.replacen("       6       2", "       9       2", 1).as_bytes(),
        "line 1: form 9 of KAAX",
    );
    fails(
        MatrixFormat::Dmig,
        punch.replacen("       6       2", "       6       4", 1).as_bytes(),
        "line 1: type 4 of KAAX",
    );
    fails(
        MatrixFormat::Dmig,
        punch.replacen("3.000000000D+03", "3.0000000Z0D+03", 1).as_bytes(),
        "line 2: expected a finite number",
    );
    let cut: String = punch.lines().take(2).map(|line| format!("{line}\n")).collect();
    fails(MatrixFormat::Dmig, cut.as_bytes(), "line 2: a column without entries (is the file truncated?)");
    let twice = punch.lines().count() + 1;
    fails(
        MatrixFormat::Dmig,
        punch.repeat(2).as_bytes(),
        &format!("line {twice}: a second matrix KAAX, the first begins at line 1"),
    );
    fails(MatrixFormat::Dmig, b"GRID,1\n", "no DMIG matrix KAAX; found: none");

    let op4 = text("tiny_ascii_d.op4");
    fails(MatrixFormat::Op4, &op4.as_bytes()[..200], "truncated");
    fails(
        MatrixFormat::Op4,
        op4.replace("KAAX", "KXXX").as_bytes(),
        "no matrix KAAX; the file holds KXXX (4 x 4, real double), MAAX (4 x 4, real double)",
    );
    fails(
        MatrixFormat::Op4,
        op4.replacen("       6       2", "       6       4", 1).as_bytes(),
        "line 1: KAAX is a complex matrix",
    );
    fails(
        MatrixFormat::Op4,
        op4.replacen("       4       4", "       4       3", 1).as_bytes(),
        "line 1: KAAX has 3 rows and 4 columns: expected a square matrix",
    );
    let binary = fs::read(data("formats/tiny_binary_handmade.op4")).expect("there");
    fails(MatrixFormat::Op4, &binary[..100], "the file is truncated");
    fails(MatrixFormat::Op4, &binary[..binary.len() - 20], "truncated");
    let mut wrong = binary.clone();
    wrong[32] = 1;
    fails(MatrixFormat::Op4, &wrong, "two length marks differ");

    let hb = text("tiny_hbstyle_K.matrix");
    fails(MatrixFormat::HarwellBoeing, &hb.as_bytes()[..hb.len() - 60], "truncated: value");
    fails(MatrixFormat::HarwellBoeing, hb.replace("RSA", "PSA").as_bytes(), "line 3: expected type RSA or RUA");
    fails(MatrixFormat::HarwellBoeing, hb.replace("(1D25.15)", "").as_bytes(), "line 4: expected three formats");
    fails(MatrixFormat::HarwellBoeing, format!("{hb}1.0\n").as_bytes(), "more than the 6 values");

    let abaqus = text("tiny_abaqusstyle_STIF1_matrixinput.mtx");
    fails(
        MatrixFormat::Abaqus,
        abaqus.replacen("12,1, 11,1", "12,1, 11", 1).as_bytes(),
        "line 2: expected node, direction",
    );
    fails(
        MatrixFormat::Abaqus,
        abaqus.replacen("12,1, 11,1", "12,9, 11,1", 1).as_bytes(),
        "line 2: expected a node and a direction",
    );
    fails(MatrixFormat::Abaqus, b"", "the file is empty");
    fails(
        MatrixFormat::Abaqus,
        b"11,1, 11,1, 2.0\n12,1, 11,1, 1.0\n11,1, 12,1, 1.0\n11,3, 11,1, 0.1\n",
        "expected one triangle or both",
    );
    fails(MatrixFormat::Abaqus, &[0xff, 0xfe, 0x00], "line 1: not text");
}

#[test]
fn entries_given_twice_are_summed_and_explicit_zeros_kept_out_of_the_way() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    fs::write(path("points.csv"), "name,role,x_m,y_m,z_m,node\nA,mount,0,0,0,1\n").expect("written");
    fs::write(
        path("K"),
        "1,1, 1,1, 2.0\n1,1, 1,1, 1.0\n2,1, 1,1, -0.5\n2,1, 1,1, -0.5\n2,1, 2,1, 1.0\n3,1, 2,1, 0.0\n3,1, 3,1, 1.0\n",
    )
    .expect("written");
    let model = FeModel::read(&files(MatrixFormat::Abaqus, path("K"), path("K"), path("points.csv"))).expect("valid");
    assert_eq!(dense(model.stiffness()), [[3.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
}

#[test]
fn a_cache_is_used_when_it_is_sound_and_made_anew_when_not() {
    let folder = tempfile::tempdir().expect("a folder");
    let model = with_damping(&FeModel::station().expect("shipped"));
    let files = write_model(&model, export("matrix_market"), folder.path()).expect("written");
    let settings = station_settings();
    let run = || reduce_files(&files, &settings, true).expect("reduces");
    let (fresh, outcome) = run();
    assert_eq!(outcome, CacheOutcome::Stored);
    let same = |other: &ReducedStructure| {
        let options = ModalOptions { cutoff_hz: 1000.0, damping: Damping::Ratio(0.02) };
        let points = ["R5", "T5"].map(|name| road::along(&[(name, 1.0)], Z));
        let [a, b] = [&fresh, other].map(|structure| structure.modes_at(&[], &options, &points).expect("modes"));
        let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&a.omega_rad_s), bits(&b.omega_rad_s));
        assert_eq!(bits(&a.damping_ratio), bits(&b.damping_ratio));
        assert_eq!(bits(a.rows.as_slice()), bits(b.rows.as_slice()));
    };
    let (kept, outcome) = run();
    assert_eq!(outcome, CacheOutcome::Used);
    same(&kept);

    // What looks wrong about a machine is kept with it.
    assert!(fresh.remarks().is_empty(), "{:?}", fresh.remarks());
    let heavy = ModelFiles { units: Units::MillimetreTonneSecond, ..files.clone() };
    for wanted in [CacheOutcome::Stored, CacheOutcome::Used] {
        let (odd, outcome) = reduce_files(&heavy, &settings, true).expect("reduces");
        assert_eq!(outcome, wanted);
        assert!(odd.remarks().iter().any(|remark| remark.contains("a mass of 2.176e6 kg")), "{:?}", odd.remarks());
    }

    // Other settings have a cache of their own.
    let other = ReductionSettings { fixed_interface_cutoff_hz: 500.0, ..settings.clone() };
    assert_ne!(cache_path(&files, &other), cache_path(&files, &settings));
    assert_eq!(reduce_files(&files, &other, true).expect("reduces").1, CacheOutcome::Stored);

    // Every kind of damage, anywhere in the file.
    let path = cache_path(&files, &settings);
    let sound = fs::read(&path).expect("there");
    for at in [0, 20, 50, 90, 200, sound.len() - 1] {
        let mut bytes = sound.clone();
        bytes[at] ^= 1;
        fs::write(&path, &bytes).expect("written");
        let (again, outcome) = run();
        assert_eq!(outcome, CacheOutcome::Damaged, "byte {at}");
        assert!(outcome.note(&path).is_some_and(|note| note.contains("is damaged")), "byte {at}");
        same(&again);
        assert_eq!(fs::read(&path).expect("there"), sound);
    }
    fs::write(&path, &sound[..sound.len() / 2]).expect("written");
    assert_eq!(run().1, CacheOutcome::Damaged);
    fs::write(&path, b"").expect("written");
    assert_eq!(run().1, CacheOutcome::Damaged);
    // A file with a hole of more bytes than are read costs no memory.
    fs::File::create(&path).and_then(|file| file.set_len(Limit::REDUCED.bytes + 1)).expect("made");
    assert_eq!(run().1, CacheOutcome::Damaged);
    assert_eq!(fs::read(&path).expect("there"), sound);

    // A changed matrix makes it stale.
    let stiffness = fs::read_to_string(&files.stiffness.path).expect("there");
    fs::write(&files.stiffness.path, stiffness.replacen("\n1 1 ", "\n1 1 1", 1)).expect("written");
    let (changed, outcome) = run();
    assert_eq!(outcome, CacheOutcome::Stale);
    assert_ne!(changed.k_zz(), fresh.k_zz());

    // No cache wanted, or none possible.
    assert_eq!(reduce_files(&files, &settings, false).expect("reduces").1, CacheOutcome::Off);
    fs::remove_dir_all(folder.path().join(CACHE_FOLDER)).expect("removed");
    fs::write(folder.path().join(CACHE_FOLDER), "in the way").expect("written");
    assert!(matches!(run().1, CacheOutcome::NotStored(_)));
}

#[test]
fn points_need_a_place_that_the_matrices_have() {
    let folder = tempfile::tempdir().expect("a folder");
    let points = folder.path().join("points.csv");
    let tiny = |name: &str| data("formats").join(format!("tiny{name}"));
    let fails = |table: &str, dofs: Option<PathBuf>, wanted: &str| {
        fs::write(&points, table).expect("written");
        let (k, m) = (tiny("_K.mtx"), tiny("_M.mtx"));
        let source = ModelFiles { dofs, ..files(MatrixFormat::MatrixMarket, k, m, points.clone()) };
        let error: StructureError = FeModel::read(&source).expect_err(wanted);
        assert!(error.to_string().contains(wanted), "{error}");
    };
    const HEAD: &str = "name,role,x_m,y_m,z_m";
    fails(&format!("{HEAD},node\nA,m,0,0,0,11\n"), None, "the rows of the matrices have no labels");
    fails(&format!("{HEAD},node\nA,m,0,0,0,99\n"), Some(tiny(".dofmap")), "no row of the matrices belongs to node 99");
    fails(&format!("{HEAD},first_row_0based,dofs\nA,m,0,0,0,2,3\n"), None, "rows 2 to 4 exceed the matrices' 4");
    fails(&format!("{HEAD},first_row_0based,dofs\nA,m,0,0,0,0,4\n"), None, "line 2: dofs: expected 3 or 6");
    fails(&format!("{HEAD},first_row_0based,node\nA,m,0,0,0,0,4\n"), None, "both give the rows of a point");
    fails(&format!("{HEAD},node,dofs\nA,m,0,0,0,0,3\n"), None, "\"dofs\" goes with \"first_row_0based\"");
    let short = folder.path().join("short.dof");
    fs::write(&short, "1.1\n1.2\n").expect("written");
    fails(&format!("{HEAD},node\nA,m,0,0,0,1\n"), Some(short), "4 rows, but");
    let table = InterfacePoints::read(&points).expect("valid");
    assert_eq!(InterfacePoints::parse("again", &table.to_csv()), Ok(table));
}

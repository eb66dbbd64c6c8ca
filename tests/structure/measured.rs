//! Measured mobilities beside the machine's. The files were written by pyuff; their values are solutions of the solid model by SciPy, with a
//! damping ratio of 0.02 for all modes up to 4456 Hz and none for the others.

use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};

use decore_model::structure::{MatrixFormat, ModalTable, read_measured};
use decore_study::engine::Engine;
use serde_json::Value;

use crate::outside::{Case, decore, market};

fn data(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

/// The solid model with two points, and what the comparison with a file says.
fn compared(file: &str) -> Value {
    let folder = tempfile::tempdir().expect("a folder");
    let points = "name,x_m,y_m,z_m,node\nR5,0.5461,0,1.7298,73\nT2,0.35102,0,0.4249,79\n";
    fs::write(folder.path().join("points.csv"), points).expect("written");
    let solid = |end: &str| data("solid").join(format!("ccx_raw.{end}.gz")).display().to_string();
    let [stiffness, mass, rows] = ["sti", "mas", "dof"].map(solid);
    let text = format!(
        "[structure]\nsource = \"matrices\"\nstiffness_file = {stiffness:?}\nmass_file = {mass:?}\ndof_file = {rows:?}\n\
         points_file = \"points.csv\"\nfixed_interface_cutoff_hz = 8000.0\ndamping_ratio = 0.02\n"
    );
    fs::write(folder.path().join("machine.toml"), text).expect("written");
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (machine, ratios) = (path("machine.toml"), path("damping.csv"));
    let measured = data("foreign").join(file).display().to_string();
    let output = decore(&["structure", &machine, "--measured", &measured, "--json", "--damping-to", &ratios]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let listed = fs::read_to_string(&ratios).expect("written");
    assert!(listed.starts_with("mode,damping_ratio\n1,"), "{listed}");
    serde_json::from_slice(&output.stdout).expect("JSON")
}

fn list<'a>(report: &'a Value, key: &str) -> &'a [Value] {
    report[key].as_array().expect("a list")
}

#[test]
fn an_frf_of_the_same_model_lies_on_the_machines_curve() {
    for file in ["solid_text.uff", "solid_binary.uff"] {
        let report = compared(file);
        assert_eq!((list(&report, "curves").len(), list(&report, "remarks").len()), (3, 0), "{}", report["remarks"]);
        for curve in list(&report, "curves") {
            let difference = curve["largest_relative_difference"].as_f64().expect("a number");
            assert!(difference < 1e-6, "{file}: {difference}");
        }
        assert_eq!(list(&report, "curves")[2]["response"], "73.-x");
        for mode in list(&report, "modes") {
            let of = |key: &str| mode[key].as_f64().expect("a number");
            assert!((of("measured_hz") / of("machine_hz") - 1.0).abs() < 1e-5, "{mode}");
            assert!((of("measured_damping_ratio") / of("machine_damping_ratio") - 1.0).abs() < 1e-3, "{mode}");
        }
        for ratio in list(&report, "proposed_damping_ratio") {
            assert!((ratio.as_f64().expect("a number") - 0.02).abs() < 1e-4, "{ratio}");
        }
    }
}

#[test]
fn two_marks_at_the_beginning_are_one() {
    // As pyuff writes a file over another one.
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["solid_text.uff", "solid_binary.uff"] {
        let path = folder.path().join(name);
        fs::write(&path, [&b"    -1\n"[..], &fs::read(data("foreign").join(name)).expect("shipped")].concat())
            .expect("written");
        assert_eq!(read_measured(&path).expect("responses").len(), 3, "{name}");
    }
}

#[test]
fn an_frf_of_another_model_is_told() {
    // All modes are 10 Hz higher.
    let report = compared("solid_shifted.uff");
    let remarks = report["remarks"].to_string();
    let (_, shift) = remarks.split_once("are off by more than 1 % in frequency, the most +").expect(&remarks);
    let shift_hz: f64 = shift.split(' ').next().and_then(|number| number.parse().ok()).expect(&remarks);
    assert!((shift_hz - 10.0).abs() < 0.1, "{remarks}");
}

/// Stiffness in N/m and mass in kg of a point that nothing is coupled to.
const ALONE: [f64; 2] = [1.7e7, 500.0];

/// A machine of three vertical displacements in a folder: R1 on T1 on the ground, T2 alone. `keys`: more keys of the structure.
fn three_masses(case: &Case, keys: &str) -> String {
    let [stiffness, mass] = ALONE;
    case.write("K.mtx", market(3, &[(0, 0, 2e7), (1, 0, -1e7), (1, 1, 2e7), (2, 2, stiffness)]));
    case.write("M.mtx", market(3, &[(0, 0, 500.0), (1, 1, 500.0), (2, 2, mass)]));
    case.write("rows.dof", "1.3\n2.3\n3.3\n");
    let structure = format!(
        "[structure]\nsource = \"matrices\"\nstiffness_file = \"K.mtx\"\nmass_file = \"M.mtx\"\ndof_file = \"rows.dof\"\n\
         points_file = \"points.csv\"\ncache = false\ncutoff_hz = 200.0\n{keys}\n"
    );
    case.write("machine.toml", structure).display().to_string()
}

fn masses() -> Case {
    let points = "name,x_m,y_m,z_m,node\nR1,0,0,2,1\nT1,0.3,0,0,2\nT2,0,0,0,3\n";
    Case::new(MatrixFormat::MatrixMarket, points)
}

/// The closed form of T2's response as a table: `(j omega)^power / (k - m omega^2 + 2 j xi omega_0 omega m)`, times `sign`.
fn table((names, power): (&str, i32), (response, sign): (&str, f64), ratio: f64) -> String {
    let [k, m] = ALONE;
    let mut text = format!("response,force,frequency_hz,{names}_re,{names}_im\n");
    for step in 1..2000 {
        let hz = 0.05 * f64::from(step);
        let omega = TAU * hz;
        let (re, im) = (k - m * omega * omega, 2.0 * ratio * (k * m).sqrt() * omega);
        let size = re * re + im * im;
        let receptance = [sign * re / size, -sign * im / size];
        let [re, im] = match power {
            0 => receptance,
            1 => [-omega * receptance[1], omega * receptance[0]],
            _ => receptance.map(|part| -omega * omega * part),
        };
        text += &format!("{response},3.z,{hz:?},{re:e},{im:e}\n");
    }
    text
}

fn beside(machine: &str, measured: &Path, further: &[&str]) -> Value {
    let measured = measured.display().to_string();
    let output = decore(&[&["structure", machine, "--measured", &measured, "--json"], further].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

#[test]
fn tables_of_every_quantity_and_sign_lie_on_the_machines_curve() {
    let case = masses();
    let machine = three_masses(&case, "damping_ratio = 0.02");
    let exact_hz = (ALONE[0] / ALONE[1]).sqrt() / TAU;
    for quantity in [("receptance", 0), ("mobility", 1), ("accelerance", 2)] {
        for response in [("T2.z", 1.0), ("3.-z", -1.0)] {
            let measured = case.write("frf.csv", table(quantity, response, 0.02));
            let report = beside(&machine, &measured, &[]);
            let (curve, mode) = (&list(&report, "curves")[0], &list(&report, "modes")[0]);
            let difference = curve["largest_relative_difference"].as_f64().expect("a number");
            assert!(difference < 1e-9, "{quantity:?} {response:?}: {difference}");
            assert_eq!((list(&report, "modes").len(), list(&report, "remarks").len()), (1, 0));
            for (key, exact) in [("measured_hz", exact_hz), ("measured_damping_ratio", 0.02), ("machine_hz", exact_hz)]
            {
                let found = mode[key].as_f64().expect("a number");
                assert!((found / exact - 1.0).abs() < 1e-6, "{key} {found}");
            }
        }
    }
    let fails = |text: &str, wanted: &str| {
        let measured = case.write("frf.csv", text).display().to_string();
        let output = decore(&["structure", &machine, "--measured", &measured]);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && error.contains(wanted), "{error}");
    };
    let head = "response,force,frequency_hz,mobility_re,mobility_im\n";
    fails(
        &(head.replace("mobility_im", "phase") + "T2.z,T2.z,5,1,0\n"),
        "frf.csv, line 1: expected columns mobility_re and mobility_im",
    );
    fails(&format!("{head}T2.z,T2.z,5,1,0\nT2.z,T2.z,4,1,0\n"), "frf.csv, line 3: frequency_hz: expected more than 5");
    fails(&format!("{head}T2.q,T2.z,5,1,0\n"), "frf.csv, line 2");
    fails(&format!("{head}T9.z,T2.z,5,1,0\n"), "expected an interface point or its node");
    fails(head, "frf.csv, line 2: the table has a header but no rows");
    fails("MATLAB 5.0 MAT-file, Platform: GLNXA64", "frf.csv: a file of MATLAB: write a table in it");
}

#[test]
fn proposed_damping_ratios_are_those_that_the_study_uses() {
    let case = masses();
    let measured = case.write("frf.csv", table(("mobility", 1), ("T2.z", 1.0), 0.05));
    let machine = three_masses(&case, "damping_ratio = 0.02");
    let path = case.path("damping.csv");
    let report = beside(&machine, &measured, &["--damping-to", &path.display().to_string()]);
    let difference =
        |report: &Value| list(report, "curves")[0]["largest_relative_difference"].as_f64().expect("a number");
    assert!(difference(&report) > 0.1);
    // T2's mode is the second of three.
    let listed = fs::read_to_string(&path).expect("written");
    let ratios: Vec<f64> = listed
        .lines()
        .skip(1)
        .map(|line| line.split_once(',').expect("two columns").1.parse().expect("a ratio"))
        .collect();
    assert_eq!((ratios.len(), ratios[0], ratios[2]), (3, 0.02, 0.02), "{listed}");
    assert!((ratios[1] / 0.05 - 1.0).abs() < 1e-6, "{listed}");
    let machine = three_masses(&case, "damping_ratio_file = \"damping.csv\"");
    assert!(difference(&beside(&machine, &measured, &[])) < 1e-6);

    // A study on the same machine.
    let structure = fs::read_to_string(&machine).expect("written");
    let study = |keys: &str| {
        let text = format!(
            "duration_s = 0.1\n[hammer.h]\nmount = \"R1\"\n[casting.c]\nmass_kg = 3.0\n[casting.c.fixture.f]\npoint = \"T2\"\n{structure}{keys}\n"
        );
        case.write("study.toml", text)
    };
    let path_of_study = study("housings = \"included\"");
    let modes = Engine::load(&path_of_study, &[]).expect("a study").scene(0).expect("a scene").modes;
    assert_eq!(modes.damping_ratio, ratios);
    let fails = |wanted: &str| {
        let error = Engine::load(&study("housings = \"included\""), &[]).expect_err("refused").to_string();
        assert!(error.contains(wanted), "{error}");
    };
    fs::write(&path, "mode,damping_ratio\n1,0.02\n3,0.02\n").expect("written");
    fails("damping.csv, line 3: mode: expected the numbers of modes from 1 on");
    fs::write(&path, "mode,damping_ratio\n1,1.5\n").expect("written");
    fails("damping.csv, line 2: damping_ratio: expected a ratio from 0 to below 1");
    let error = Engine::load(&study("housings = \"included\"\ndamping_ratio = 0.1"), &[]).expect_err("refused");
    assert!(error.to_string().contains("cannot be combined with `damping_ratio`"), "{error}");
}

#[test]
fn normal_modes_of_a_universal_file_are_a_modal_table() {
    // Three modes that pyuff wrote in mm, t, s with modal masses of 2.5, 1 and 4 kg; the table has them in SI and scaled to 1 kg.
    let case = Case::new(MatrixFormat::MatrixMarket, "name,x_m,y_m,z_m,node\nR5,0,0,1,5\nT5,0,0,0,9\n");
    fs::copy(data("foreign/modes_55.uff"), case.path("modes.uff")).expect("copied");
    let shapes = [[1.5, -0.75], [-0.5, 1.0], [2.5, 0.25]];
    let facts = [(20.5, 0.01, 2.5_f64), (75.25, 0.02, 1.0), (180.125, 0.015, 4.0)];
    let mut table = "mode,frequency_hz,damping_ratio,R5.z,T5.z\n".to_owned();
    for (mode, ([r5, t5], (hz, ratio, mass))) in shapes.into_iter().zip(facts).enumerate() {
        let scaled = [r5, t5].map(|value: f64| value / mass.sqrt());
        table += &format!("{},{hz},{ratio},{:?},{:?}\n", mode + 1, scaled[0], scaled[1]);
    }
    case.write("modes.csv", table);
    let [from_uff, from_csv] = ["modes.uff", "modes.csv"].map(|file| {
        let text = format!(
            "duration_s = 0.1\n[hammer.h]\nmount = \"R5\"\n[casting.c]\nmass_kg = 3.0\n[casting.c.fixture.f]\npoint = \"T5\"\n\
             [structure]\nsource = \"modal_table\"\nmodal_file = \"{file}\"\npoints_file = \"points.csv\"\nhousings = \"included\"\n"
        );
        let path = case.write("study.toml", text);
        Engine::load(&path, &[]).expect("a study").scene(0).expect("a scene").modes
    });
    assert_eq!(from_uff.damping_ratio, from_csv.damping_ratio);
    let close =
        |a: &[f64], b: &[f64]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12 * b.abs());
    assert!(from_uff.omega_rad_s.len() == 3 && close(&from_uff.omega_rad_s, &from_csv.omega_rad_s));
    assert!(from_uff.shapes.len() == 2);
    for (point, shape) in &from_uff.shapes {
        assert!(close(shape, &from_csv.shapes[point]), "{shape:?} {:?}", from_csv.shapes[point]);
    }
    // Complex modes and a file that is cut are refused.
    let text = fs::read_to_string(case.path("modes.uff")).expect("copied");
    let fails = |text: String, wanted: &str| {
        let path = case.write("modes.uff", text);
        let error = ModalTable::read(&path).expect_err(wanted).to_string();
        assert!(error.contains(wanted), "{error}");
    };
    fails(
        text.replacen(
            "         1         2         3         8         2",
            "         1         3         3         8         5",
            1,
        ),
        "a complex mode",
    );
    fails(text[..text.len() - 200].to_owned(), "the file is truncated");
    fails(text.replace("    55", "    58"), "no normal modes found");
}

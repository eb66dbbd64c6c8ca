//! Measured mobilities beside the machine's. The files were written by pyuff; their values are direct solutions of the solid model by SciPy,
//! with a damping ratio of 0.02 for every mode.

use std::fs;
use std::path::PathBuf;

use serde_json::Value;

use crate::outside::decore;

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
            assert!(difference < 4e-6, "{file}: {difference}");
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
fn an_frf_of_another_model_is_told() {
    // All modes are 10 Hz higher.
    let report = compared("solid_shifted.uff");
    let remarks = report["remarks"].to_string();
    let (_, shift) = remarks.split_once("are off by more than 1 % in frequency, the most +").expect(&remarks);
    let shift_hz: f64 = shift.split(' ').next().and_then(|number| number.parse().ok()).expect(&remarks);
    assert!((shift_hz - 10.0).abs() < 0.1, "{remarks}");
}

//! The quality report against references and closed forms, the command that prints it, and the selection of modes.

use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use decore::page::quality_page;
use decore_model::structure::{
    Damping, DofLabel, FeModel, InterfacePoint, InterfacePoints, MOBILITY_SHARE, ModalOptions, ModeSelection,
    ModelMatrices, ModesAt, PointPlace, QualityReport, QualitySettings, ReductionSettings, SelectionSettings, assess,
    reduce,
};
use nalgebra::DMatrix;
use serde_json::Value;
use sprs::TriMat;

use crate::road;

const Z: [f64; 3] = [0.0, 0.0, 1.0];
const X: [f64; 3] = [1.0, 0.0, 0.0];

fn station_settings(cutoff_hz: f64) -> QualitySettings {
    let mut interface: Vec<(String, usize)> = (0..6).map(|dof| ("R5".to_owned(), dof)).collect();
    interface.push(("T5".to_owned(), 2));
    QualitySettings {
        reduction: ReductionSettings { interface, fixed_interface_cutoff_hz: 3000.0 },
        cutoff_hz,
        damping_ratio: 0.02,
    }
}

fn station_report() -> QualityReport {
    assess(&FeModel::station().expect("shipped"), &station_settings(1000.0)).expect("a report")
}

#[test]
fn the_station_is_reported_as_scipy_sees_it() {
    let report = station_report();
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/station_reduction.json"));
    let reference: Value = serde_json::from_str(&text.expect("there")).expect("JSON");
    let expected = reference["station"]["hz_no_hammer"].as_array().expect("a list");
    for (mode, expected) in report.modes.iter().zip(expected) {
        let expected = expected.as_f64().expect("a number");
        assert!((mode.full_hz / expected - 1.0).abs() < 2e-5, "{} {expected}", mode.full_hz);
    }
    assert!(report.modes.iter().all(|mode| mode.reduced_hz >= mode.full_hz * (1.0 - 1e-9)), "upper bounds");
    assert!(report.largest_frequency_error(300.0) < 1e-5, "{:e}", report.largest_frequency_error(300.0));
    assert!(report.largest_frequency_error(300.0) > 1e-12);
    assert!(report.modes.iter().filter(|mode| mode.full_hz < 300.0).all(|mode| mode.mac > 0.999_999));
    let [x, y, z] = report.total_mass_kg.expect("six directions per node");
    assert!([x, y, z].iter().all(|mass| (mass / 2176.0 - 1.0).abs() < 1e-2), "{x} {y} {z}");
    let moved: f64 = report.modes.iter().filter_map(|mode| mode.effective_mass_full).map(|share| share[2]).sum();
    assert!(moved > 0.95 && moved < 1.0 + 1e-9, "{moved}");
    assert_eq!(report.static_stiffness.len(), 7);
    assert!(report.static_stiffness.iter().all(|one| one.relative_error.abs() < 1e-9));
    assert!(report.mobility.iter().all(|curve| curve.largest_relative_difference < 2e-3), "{:?}", report.mobility[0]);
    assert!(report.conditions.inner_stiffness.is_some_and(|condition| condition > 1e3));
    assert!(report.steps.iter().any(|step| step.name.starts_with("full model: count")));
    let page = quality_page(&report, "Station <1>").expect("drawn");
    assert!(page.contains("Station &lt;1&gt;") && page.matches("<svg").count() == 1 + report.mobility.len());
    assert!(!page.contains("NaN") && !page.contains("inf"));
    // A phone: its own width, tables and plots scroll, and only the first curves are unfolded.
    assert!(page.contains("name=\"viewport\" content=\"width=device-width"));
    assert_eq!(page.matches("<table>").count(), page.matches("<div class=\"scroll\"><table>").count());
    assert_eq!(page.matches("<svg").count(), page.matches("class=\"plot\"").count());
    let mobility = page.find("<h2>Mobility").expect("the curves");
    let unfolded = page[mobility..].split("<details>").next().expect("a part").matches("<svg").count();
    assert_eq!(unfolded, report.mobility.len().min(4));
}

/// n masses in a row between walls, every one x of a node; points on the nodes given.
fn chain(n: usize, at: &[usize], held: bool) -> FeModel {
    let (mut k, mut m) = (TriMat::new((n, n)), TriMat::new((n, n)));
    for i in 0..n {
        m.add_triplet(i, i, 2.0 + 0.01 * i as f64);
        let end = usize::from(!held && (i == 0 || i + 1 == n));
        k.add_triplet(i, i, 500.0 * (2 - end) as f64);
        if i + 1 < n {
            k.add_triplet(i, i + 1, -500.0);
            k.add_triplet(i + 1, i, -500.0);
        }
    }
    let labels = (0..n).map(|row| DofLabel { node: row as i64, dof: 0 }).collect();
    let point = |(index, row): (usize, &usize)| InterfacePoint {
        name: format!("P{index}"),
        role: "mount".to_owned(),
        place: PointPlace::Node { node: *row as i64, rotation_node: None },
        position_m: [*row as f64, 0.0, 0.0],
    };
    let points = InterfacePoints::new(at.iter().enumerate().map(point).collect()).expect("unique");
    FeModel::new(ModelMatrices { mass: m.to_csr(), stiffness: k.to_csr(), damping: None, labels }, points)
        .expect("sound")
}

fn chain_settings(points: usize, cutoff_hz: f64) -> QualitySettings {
    QualitySettings {
        reduction: ReductionSettings {
            interface: (0..points).map(|index| (format!("P{index}"), 0)).collect(),
            fixed_interface_cutoff_hz: 100.0,
        },
        cutoff_hz,
        damping_ratio: 0.0,
    }
}

/// The largest error of the full model's curves against a direct solution, over its largest entry. Without damping both are real.
fn direct_error(model: &FeModel, report: &QualityReport, row: impl Fn(&str) -> usize) -> f64 {
    let n = model.order();
    let dense = |matrix: &sprs::CsMat<f64>| DMatrix::from_fn(n, n, |i, j| matrix.get(i, j).copied().unwrap_or(0.0));
    let (k, m) = (dense(model.stiffness()), dense(model.mass()));
    let mut worst = 0.0_f64;
    for index in (0..report.frequency_hz.len()).step_by(79) {
        let omega = TAU * report.frequency_hz[index];
        let factor = (&k - &m * (omega * omega)).lu();
        for curve in &report.mobility {
            let mut load = DMatrix::zeros(n, 1);
            load[row(&curve.force)] = omega;
            let exact = factor.solve(&load).expect("no resonance");
            let error = (curve.full[index] - exact[row(&curve.response)].abs()).abs();
            worst = worst.max(error / exact.amax());
        }
    }
    worst
}

#[test]
fn mobilities_of_the_full_model_are_those_of_a_direct_solution() {
    let (n, at) = (60, [7, 31]);
    for held in [true, false] {
        let model = chain(n, &at, held);
        let report = assess(&model, &chain_settings(2, 3.0)).expect("a report");
        assert_eq!(report.mobility.len(), 3);
        assert!((report.frequency_hz.last().expect("a curve") / (MOBILITY_SHARE * 3.0) - 1.0).abs() < 1e-12);
        let error = direct_error(&model, &report, |name| at[usize::from(name == "P1.x")]);
        assert!(error < 1e-9, "{error:e}");
        // The reduced structure has all modes here.
        for curve in &report.mobility {
            assert!(curve.largest_relative_difference < 1e-6, "{}", curve.largest_relative_difference);
        }
    }
    // A cut-off with few modes below it leaves most of the response to the others.
    let model = FeModel::station().expect("shipped");
    let settings = QualitySettings { damping_ratio: 0.0, ..station_settings(120.0) };
    let report = assess(&model, &settings).expect("a report");
    assert!(report.mobility.len() > 4 && report.modes.len() < 60, "{}", report.modes.len());
    let row = |name: &str| {
        let (point, direction) = name.split_once('.').expect("a direction");
        let dof = ["x", "y", "z"].iter().position(|known| *known == direction).expect("a translation");
        model.rows_of(point).expect("known")[dof].expect("a row")
    };
    let error = direct_error(&model, &report, row);
    assert!(error < 1e-9, "{error:e}");
}

#[test]
fn effective_masses_of_all_modes_are_the_whole_mass() {
    let report = assess(&chain(40, &[10], true), &chain_settings(1, 100.0)).expect("a report");
    assert_eq!(report.modes.len(), 40);
    for pick in [0, 1] {
        let sum: f64 = report
            .modes
            .iter()
            .filter_map(|mode| [mode.effective_mass_full, mode.effective_mass_reduced][pick])
            .map(|share| share[0])
            .sum();
        assert!((sum - 1.0).abs() < 1e-9, "{sum}");
    }
    assert!(report.modes.iter().all(|mode| mode.mac > 1.0 - 1e-9));
    assert_eq!(report.total_mass_kg.map(|mass| mass[1]), Some(0.0));
}

#[test]
fn a_floating_structure_is_reported_without_statics() {
    let report = assess(&chain(50, &[3, 30], false), &chain_settings(2, 2.0)).expect("a report");
    assert!(report.static_stiffness.is_empty());
    assert_eq!((report.modes[0].full_hz, report.modes[0].reduced_hz, report.modes[0].relative_error), (0.0, 0.0, None));
    assert!(report.modes[0].mac > 0.999_999 && report.largest_frequency_error(2.0) < 1e-8);
    let share = report.modes[0].effective_mass_full.expect("x of every node");
    assert!((share[0] - 1.0).abs() < 1e-9, "the free motion carries all the mass: {share:?}");
    assert!(quality_page(&report, "free").expect("drawn").contains("The structure floats"));
}

fn decore(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_decore")).args(arguments).output().expect("runs")
}

fn studies(name: &str) -> String {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("studies").join(name).display().to_string()
}

#[test]
fn the_command_reports_exports_and_reads_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    let rig = studies("paper_rig.toml");
    let output = decore(&["structure", &rig, "--html", &path("page.html")]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(text.contains("reduced Hz") && text.contains("R5.z") && text.contains("condition"), "{text}");
    assert!(fs::read_to_string(path("page.html")).expect("written").starts_with("<!doctype html>"));

    let output = decore(&["structure", &rig, "--json"]);
    let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert!(report["modes"].as_array().is_some_and(|modes| modes.len() > 20));

    // Export, then read what was written as a structure file of its own.
    let output = decore(&["structure", &rig, "--export", "calculix", "--to", &folder.path().display().to_string()]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let own = "[structure]\nsource = \"matrices\"\nstiffness_file = \"model.sti\"\nmass_file = \"model.mas\"\n\
               dof_file = \"model.dof\"\npoints_file = \"points.csv\"\ncutoff_hz = 300.0\n";
    fs::write(path("machine.toml"), own).expect("written");
    let output = decore(&["structure", &path("machine.toml"), "--json"]);
    let again: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(again["modes"][0]["full_hz"].as_f64().map(|hz| (hz * 1e4).round()), Some(32084.0));
    assert!(again["static_stiffness"].as_array().is_some_and(|list| list.len() > 100), "all points, all directions");

    let fails = |arguments: &[&str], wanted: &str| {
        let output = decore(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(text.contains(wanted), "{text}");
    };
    fails(&["structure", &path("machine.toml"), "--set", "structure.cutoff_hz=1"], "--set needs a study");
    fails(&["structure", &rig, "--export", "nastran", "--to", "."], "expected one of matrix_market");
    fails(&["structure", &path("none.toml")], "none.toml");
    fs::write(path("machine.toml"), own.replace("cutoff_hz", "cutof_hz")).expect("written");
    fails(&["structure", &path("machine.toml")], "cutof_hz");
    fs::write(path("machine.toml"), own.replace("model.dof", "model.dog")).expect("written");
    fails(&["structure", &path("machine.toml")], "there is no file");
}

#[test]
fn modes_are_selected_within_the_bound_that_is_stated() {
    let settings = station_settings(1000.0);
    let structure = reduce(&FeModel::station().expect("shipped"), &settings.reduction).expect("reduces");
    let options = ModalOptions { cutoff_hz: f64::MAX, damping: Damping::Ratio(0.02) };
    let rows = ["R5", "T5"].map(|name| road::along(&[(name, 1.0)], Z));
    let at = structure.modes_at(&[], &options, &rows).expect("modes");
    let (modes, phi) = (&at, [road::row(&at, 0), road::row(&at, 1)]);
    let all = at.select(SelectionSettings { tolerance: 0.0, band_hz: 1000.0 }).expect("selected");
    assert!(all.kept.len() > modes.omega_rad_s.len() / 2 && all.bound == 0.0);
    let mut last = all.kept.len() + 1;
    for tolerance in [1e-6, 1e-4, 1e-2, 0.3] {
        let selected = at.select(SelectionSettings { tolerance, band_hz: 1000.0 }).expect("selected");
        assert!(selected.kept.len() < last, "{tolerance}: {} modes", selected.kept.len());
        assert!(selected.bound <= tolerance && selected.bound > 0.0);
        last = selected.kept.len();
        let flexibility =
            |i: usize| -> f64 { phi[i].iter().zip(&modes.omega_rad_s).map(|(p, w)| (p / w).powi(2)).sum() };
        // Receptances with the kept and the residual modes against all modes, over the whole band.
        let mut worst = 0.0_f64;
        for step in 0..=4000 {
            let w = TAU * 0.25 * f64::from(step);
            for (i, j) in [(0, 0), (1, 1), (0, 1)] {
                let full = receptance((&modes.omega_rad_s, &modes.damping_ratio), w, |s| phi[i][s] * phi[j][s]);
                let few = selected_receptance(modes, &selected, w, (i, j));
                let error = (full[0] - few[0]).hypot(full[1] - few[1]) / (flexibility(i) * flexibility(j)).sqrt();
                worst = worst.max(error);
                // Nothing is lost at rest.
                assert!(step > 0 || error < 1e-10, "static error {error}");
            }
        }
        assert!(worst <= selected.bound * (1.0 + 1e-9) + 1e-10, "{worst} beyond {}", selected.bound);
        assert!(worst > 0.01 * selected.bound, "the bound is not idle: {worst} {}", selected.bound);
        // Nor of the response to a jump of force.
        for (i, j) in [(0, 0), (1, 1), (0, 1)] {
            let all: f64 = (0..modes.omega_rad_s.len()).map(|s| phi[i][s] * phi[j][s]).sum();
            let few = selected.rows.row(i).dot(&selected.rows.row(j))
                + selected.residual.rows.row(i).dot(&selected.residual.rows.row(j));
            assert!((few / all - 1.0).abs() < 1e-9, "{few} and {all}");
        }
        assert!(selected.residual.omega_rad_s.len() <= rows.len());
        assert!(selected.residual.damping_ratio.iter().all(|xi| (0.02 - 1e-9..0.2).contains(xi)));
    }
    assert!(at.select(SelectionSettings { tolerance: -1.0, band_hz: 1.0 }).is_err());
    assert!(at.select(SelectionSettings { tolerance: 0.1, band_hz: 0.0 }).is_err());
    assert!(structure.modes_at(&[], &options, &[road::along(&[("R9", 1.0)], X)]).is_err());
}

/// `sum shape_s / (omega_s^2 - w^2 + 2 i xi_s omega_s w)`: real and imaginary part.
fn receptance((omega, xi): (&[f64], &[f64]), w: f64, shape: impl Fn(usize) -> f64) -> [f64; 2] {
    (0..omega.len()).fold([0.0; 2], |sum, s| {
        let (re, im) = (omega[s] * omega[s] - w * w, 2.0 * xi[s] * omega[s] * w);
        let scale = shape(s) / (re * re + im * im);
        [sum[0] + scale * re, sum[1] - scale * im]
    })
}

fn selected_receptance(modes: &ModesAt, selected: &ModeSelection, w: f64, (i, j): (usize, usize)) -> [f64; 2] {
    let of = |values: &[f64]| -> Vec<f64> { selected.kept.iter().map(|&s| values[s]).collect() };
    let (omega, xi) = (of(&modes.omega_rad_s), of(&modes.damping_ratio));
    let kept = receptance((&omega, &xi), w, |s| selected.rows[(i, s)] * selected.rows[(j, s)]);
    let residual = &selected.residual;
    let rest = receptance((&residual.omega_rad_s, &residual.damping_ratio), w, |s| {
        residual.rows[(i, s)] * residual.rows[(j, s)]
    });
    [kept[0] + rest[0], kept[1] + rest[1]]
}

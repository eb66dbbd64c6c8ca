//! The reduction against scipy's on the station, closed forms, and bad input.
//!
//! `tests/data/station_reduction.json` was computed with scipy from the same matrices (one 27 kg housing at R5 where nothing
//! else is said).

use std::f64::consts::{PI, TAU};
use std::path::Path;

use decore_math::linalg::{SymmetricEigen, cholesky, multiply, solve_lower, solve_lower_transposed, symmetric_eigen};
use decore_model::direction::DOWN;
use decore_model::structure::{
    Damping, DirectedPoints, FeModel, InterfacePoint, InterfacePoints, MatrixFile, MatrixFormat, ModalOptions,
    ModalTable, ModelFiles, ModelMatrices, ModesAt, PointPlace, ReducedStructure, ReductionSettings, RigidMass,
    StructureError, Units, reduce,
};
use serde_json::Value;
use sprs::{CsMat, TriMat};

use crate::road::{along, frequencies_hz, hz, row};

const Z: [f64; 3] = [0.0, 0.0, 1.0];

/// One point that moves along [`Z`].
fn upwards(point: &str) -> DirectedPoints {
    along(&[(point, 1.0)], Z)
}

/// Rounding of scipy's dense solver in the lowest frequencies, relative (found with extended precision).
const SCIPY_ROUNDING: f64 = 2e-9;

fn reference() -> Value {
    let text = include_str!("../data/station_reduction.json");
    serde_json::from_str::<Value>(text).expect("valid JSON")["station"].clone()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|number| number.as_f64().expect("a number")).collect()
}

fn housing(points: &[(&str, f64)]) -> RigidMass {
    RigidMass {
        points: weights(points),
        mass_kg: 27.0,
        inertia_kg_m2: [0.55, 0.55, 0.12],
        centre_of_mass_m: [0.0, 0.0, -0.2],
        axis: DOWN,
    }
}

fn weights(points: &[(&str, f64)]) -> Vec<(String, f64)> {
    points.iter().map(|(name, weight)| ((*name).to_owned(), *weight)).collect()
}

fn options(cutoff_hz: f64) -> ModalOptions {
    ModalOptions { cutoff_hz, damping: Damping::Ratio(0.02) }
}

/// All six DOFs of the rail, z of the table.
fn study_interface(cutoff_hz: f64) -> ReductionSettings {
    let rail = (1..=9).flat_map(|n| (0..6).map(move |dof| (format!("R{n}"), dof)));
    let table = (1..=9).map(|n| (format!("T{n}"), 2));
    ReductionSettings { interface: rail.chain(table).collect(), fixed_interface_cutoff_hz: cutoff_hz }
}

fn station(settings: &ReductionSettings) -> ReducedStructure {
    reduce(&FeModel::station().expect("shipped data"), settings).expect("reduces")
}

fn fe_model(mass: CsMat<f64>, stiffness: CsMat<f64>, points: InterfacePoints) -> Result<FeModel, StructureError> {
    FeModel::new(ModelMatrices { mass, stiffness, damping: None, labels: Vec::new() }, points)
}

/// The station with the housing of R5 in its mass matrix, as the reference has it.
fn station_with_housing() -> FeModel {
    let bare = FeModel::station().expect("shipped data");
    let order = bare.order();
    let mut mass = TriMat::new((order, order));
    for (&value, (row, column)) in bare.mass() {
        mass.add_triplet(row, column, value);
    }
    let (m, h, first) = (27.0, -0.2, 336);
    let s = [[0.0, -h, 0.0], [h, 0.0, 0.0], [0.0, 0.0, 0.0]];
    let inertia = [0.55 + m * h * h, 0.55 + m * h * h, 0.12];
    for i in 0..3 {
        mass.add_triplet(first + i, first + i, m);
        mass.add_triplet(first + 3 + i, first + 3 + i, inertia[i]);
        for (j, value) in s[i].iter().enumerate() {
            mass.add_triplet(first + i, first + 3 + j, -m * value);
            mass.add_triplet(first + 3 + j, first + i, -m * value);
        }
    }
    fe_model(mass.to_csr(), bare.stiffness().clone(), bare.points().clone()).expect("valid")
}

/// Interface DOFs from rows of the matrices.
fn interface_of_rows(model: &FeModel, rows: &[f64]) -> Vec<(String, usize)> {
    let name = |row: usize| {
        let point = model
            .points()
            .iter()
            .find(|point| matches!(point.place, PointPlace::Rows { first, .. } if first == row / 6 * 6));
        (point.expect("an interface row").name.clone(), row % 6)
    };
    rows.iter().map(|row| name(*row as usize)).collect()
}

fn assert_close(found: &[f64], expected: &[f64], tolerance: f64) {
    assert!(found.len() >= expected.len(), "{} values, {} expected", found.len(), expected.len());
    for (index, (f, e)) in found.iter().zip(expected).enumerate() {
        assert!((f / e - 1.0).abs() < tolerance, "value {index}: {f} instead of {e}");
    }
}

#[test]
fn full_frequencies_follow_the_housing() {
    let complete = station(&study_interface(1e7));
    let reference = reference();
    assert_close(&hz(&complete, &[], &options(310.0)), &numbers(&reference["hz_no_hammer"]), 2e-5);
    for mount in ["R1", "R3", "R5", "R9"] {
        let found = hz(&complete, &[housing(&[(mount, 1.0)])], &options(310.0));
        assert_close(&found, &numbers(&reference["hz_by_mount"][mount]), 2e-5);
    }
    let found = hz(&complete, &[housing(&[("R5", 1.0)])], &options(310.0));
    assert_close(&found, &numbers(&reference["full_hz"]), SCIPY_ROUNDING);
    // Inverse iteration in extended precision on the same matrices.
    let precise = [
        3.145_854_552_993_23,
        3.689_839_016_278_047,
        5.108_338_020_467_726,
        6.699_363_013_754_608,
        7.643_795_173_576_418,
        8.654_341_455_671_284,
    ];
    assert_close(&found, &precise, 1e-10);
}

#[test]
fn adding_the_housing_after_the_reduction_equals_having_it_in_the_matrices() {
    let settings = study_interface(1500.0);
    let after = hz(&station(&settings), &[housing(&[("R5", 1.0)])], &options(1000.0));
    let within = hz(&reduce(&station_with_housing(), &settings).expect("reduces"), &[], &options(1000.0));
    assert_close(&after, &within, 1e-10);
}

#[test]
fn craig_bampton_truncation_errors_equal_scipys() {
    let model = station_with_housing();
    let reference = reference();
    let full = numbers(&reference["full_hz"]);
    let sets = reference["sets"].as_object().expect("sets");
    assert_eq!(sets.len(), 4);
    for (name, set) in sets {
        let settings = ReductionSettings {
            interface: interface_of_rows(&model, &numbers(&set["b_dof0"])),
            fixed_interface_cutoff_hz: set["fmax"].as_f64().expect("fmax"),
        };
        let reduced = reduce(&model, &settings).expect("reduces");
        let (inner, interface) = (set["n_fixed_modes"].as_u64(), set["n_b"].as_u64());
        assert_eq!(Some(reduced.m_zz().nrows() as u64), inner.zip(interface).map(|(a, b)| a + b), "{name}");
        let hz = hz(&reduced, &[], &options(400.0));
        assert_close(&hz, &numbers(&set["reduced_hz_below_400"]), SCIPY_ROUNDING);
        let error = hz.iter().zip(&full).filter(|(_, full)| **full < 300.0).map(|(f, g)| f / g - 1.0);
        let (least, largest) = error.fold((f64::INFINITY, 0.0_f64), |(a, b), e| (a.min(e), b.max(e)));
        let expected = set["max_rel_err_below_300"].as_f64().expect("a number");
        assert!((largest / expected - 1.0).abs() < 1e-3, "{name}: {largest:e} instead of {expected:e}");
        assert!(least > -SCIPY_ROUNDING, "{name}: a frequency below the full one by {least:e}");
    }
}

#[test]
fn static_interface_stiffness_equals_scipys() {
    let model = station_with_housing();
    let reference = reference();
    for name in ["S1_hammer_fixture_z_f1000", "S2_hammer_fixture_xyz_f1000"] {
        let set = &reference["sets"][name];
        let settings = ReductionSettings {
            interface: interface_of_rows(&model, &numbers(&set["b_dof0"])),
            fixed_interface_cutoff_hz: 300.0,
        };
        let reduced = reduce(&model, &settings).expect("reduces");
        let stiffness = reduced.static_flexibility().expect("stands").clone().try_inverse().expect("regular");
        let rows: Vec<Vec<f64>> = set["static_Kbb_full"].as_array().expect("rows").iter().map(numbers).collect();
        for (i, row) in rows.iter().enumerate() {
            for (j, expected) in row.iter().enumerate() {
                let scale = (stiffness[(i, i)] * stiffness[(j, j)]).sqrt();
                assert!((stiffness[(i, j)] - expected).abs() < 1e-9 * scale, "{name} ({i}, {j})");
            }
        }
    }
    let flexibility = &reference["drive_point_flexibility_m_per_n"];
    let reduced = station(&study_interface(300.0));
    let modes = reduced.modes_at(&[], &options(250.0), &["R5", "T5"].map(upwards)).expect("modes");
    let whole = reduced.static_flexibility().expect("stands");
    let rows = ["R5", "T5"].map(|point| reduced.interface().row_of(point, 2).expect("kept"));
    for i in 0..2 {
        for j in 0..2 {
            let full = whole[(rows[i], rows[j])];
            assert_close(&[full], &[flexibility[i][j].as_f64().expect("a number")], 1e-9);
            // Modes below the cut-off are softer than the whole machine nowhere.
            let (p, q) = (row(&modes, i), row(&modes, j));
            let kept: f64 = p.iter().zip(&q).zip(&modes.omega_rad_s).map(|((p, q), w)| p * q / (w * w)).sum();
            assert!(i != j || full > kept);
        }
    }
}

fn mobility(modes: &ModesAt, rows: [&[f64]; 2], hz: f64) -> [f64; 2] {
    let w = TAU * hz;
    let mut sum = [0.0; 2];
    for (((p, q), omega), xi) in rows[0].iter().zip(rows[1]).zip(&modes.omega_rad_s).zip(&modes.damping_ratio) {
        let (a, b) = (omega * omega - w * w, 2.0 * xi * omega * w);
        let scale = p * q * w / (a * a + b * b);
        // i w / (a + i b) = w (b + i a) / (a^2 + b^2)
        sum[0] += scale * b;
        sum[1] += scale * a;
    }
    sum
}

#[test]
fn mobilities_equal_scipys() {
    let reference = reference();
    let complete = station(&study_interface(1e7));
    let points = ["R5", "T5"].map(upwards);
    let modes = complete.modes_at(&[housing(&[("R5", 1.0)])], &options(1e7), &points).expect("modes");
    let (h, t) = (row(&modes, 0), row(&modes, 1));
    for (name, rows) in [("hh", [&h[..], &h[..]]), ("tt", [&t, &t]), ("ht", [&h, &t])] {
        let samples = reference["mobility_samples_hz_re_im"][name].as_object().expect("samples");
        for (hz, sample) in samples {
            let (expected, found) = (numbers(sample), mobility(&modes, rows, hz.parse().expect("Hz")));
            let scale = expected[0].hypot(expected[1]);
            let error = (found[0] - expected[0]).hypot(found[1] - expected[1]) / scale;
            assert!(error < 1e-6, "{name} at {hz} Hz: {found:?} instead of {expected:?}");
        }
    }
}

/// Fixed-fixed chain of n masses of 2 kg, n + 1 springs of 500 N/m; every mass is "x" of a point with five idle DOFs.
fn chain(n: usize) -> FeModel {
    let (mut k, mut m) = (TriMat::new((6 * n, 6 * n)), TriMat::new((6 * n, 6 * n)));
    for i in 0..n {
        for dof in 0..6 {
            m.add_triplet(6 * i + dof, 6 * i + dof, 2.0);
            k.add_triplet(6 * i + dof, 6 * i + dof, if dof == 0 { 1000.0 } else { 1e9 });
        }
        if i + 1 < n {
            k.add_triplet(6 * i, 6 * i + 6, -500.0);
            k.add_triplet(6 * i + 6, 6 * i, -500.0);
        }
    }
    fe_model(m.to_csr(), k.to_csr(), points(n)).expect("valid")
}

fn points(n: usize) -> InterfacePoints {
    let point = |i: usize| InterfacePoint {
        name: format!("N{i}"),
        role: "mount".to_owned(),
        place: PointPlace::Rows { first: 6 * i, dofs: Some(6) },
        position_m: [i as f64, 0.0, 0.0],
    };
    InterfacePoints::new((0..n).map(point).collect()).expect("unique")
}

fn chain_hz(n: usize, j: usize) -> f64 {
    2.0 * (500.0_f64 / 2.0).sqrt() * (j as f64 * PI / (2.0 * (n as f64 + 1.0))).sin() / TAU
}

#[test]
fn chain_closed_form_exact_with_all_modes_upper_bounds_when_cut() {
    let (n, model) = (30, chain(30));
    let mut settings = ReductionSettings {
        interface: vec![("N7".to_owned(), 0), ("N20".to_owned(), 0)],
        fixed_interface_cutoff_hz: 1e6,
    };
    let exact: Vec<f64> = (1..=n).map(|j| chain_hz(n, j)).collect();
    let complete = hz(&reduce(&model, &settings).expect("reduces"), &[], &options(100.0));
    assert_eq!(complete.len(), n);
    assert_close(&complete, &exact, 1e-11);

    let mut last: Option<Vec<f64>> = None;
    for cutoff in [1.0, 2.0, 3.0, 4.0] {
        settings.fixed_interface_cutoff_hz = cutoff;
        let hz = hz(&reduce(&model, &settings).expect("reduces"), &[], &options(100.0));
        assert!(hz.len() < n && hz.iter().zip(&exact).all(|(cut, full)| cut > &(full * (1.0 - 1e-11))));
        if let Some(coarse) = last {
            assert!(coarse.iter().zip(&hz).all(|(coarse, fine)| *fine <= coarse * (1.0 + 1e-11)));
        }
        last = Some(hz);
    }
}

#[test]
fn all_dofs_on_the_interface_is_exact_too() {
    let (n, model) = (4, chain(4));
    let interface = (0..n).flat_map(|i| (0..6).map(move |dof| (format!("N{i}"), dof))).collect();
    let settings = ReductionSettings { interface, fixed_interface_cutoff_hz: 1.0 };
    let end = [along(&[("N0", 1.0)], [1.0, 0.0, 0.0])];
    let modes = reduce(&model, &settings).expect("reduces").modes_at(&[], &options(100.0), &end).expect("modes");
    assert_close(&frequencies_hz(&modes), &[1, 2, 3, 4].map(|j| chain_hz(4, j)), 1e-11);
    for (j, value) in (1..).zip(row(&modes, 0)) {
        let exact = (2.0_f64 / (5.0 * 2.0)).sqrt() * (f64::from(j) * PI / 5.0).sin();
        assert!((value.abs() / exact.abs() - 1.0).abs() < 1e-10, "mode {j}: {value} {exact}");
    }
}

#[test]
fn floating_structure_has_rigid_modes_and_no_static_flexibility() {
    let n = 10;
    let (mut k, mut m) = (TriMat::new((6 * n, 6 * n)), TriMat::new((6 * n, 6 * n)));
    for i in 0..6 * n {
        m.add_triplet(i, i, 2.0);
        let springs = if i < 6 || i >= 6 * (n - 1) { 1.0 } else { 2.0 };
        k.add_triplet(i, i, 500.0 * springs);
        if i + 6 < 6 * n {
            k.add_triplet(i, i + 6, -500.0);
            k.add_triplet(i + 6, i, -500.0);
        }
    }
    let model = fe_model(m.to_csr(), k.to_csr(), points(n)).expect("valid");
    let interface: Vec<_> = (0..6).map(|dof| ("N3".to_owned(), dof)).collect();
    let settings = ReductionSettings { interface, fixed_interface_cutoff_hz: 1e4 };
    let reduced = reduce(&model, &settings).expect("reduces");
    assert!(reduced.static_flexibility().is_none());
    let modes = reduced.modes_at(&[housing(&[("N3", 1.0)])], &options(5.0), &[upwards("N3")]).expect("modes");
    assert_eq!(modes.omega_rad_s[..6], [0.0; 6]);
    // Along z the centre of mass lies below the mount, so z is a pure translation of 20 + 27 kg.
    let rigid: f64 = row(&modes, 0)[..6].iter().map(|value| value * value).sum();
    assert!((rigid * 47.0 - 1.0).abs() < 1e-9, "{rigid}");
}

#[test]
fn interpolated_mount_and_two_housings() {
    let reduced = station(&study_interface(1500.0));
    let hz = |bodies: &[RigidMass]| hz(&reduced, bodies, &options(1000.0));
    assert_eq!(hz(&[housing(&[("R5", 1.0), ("R6", 0.0)])]), hz(&[housing(&[("R5", 1.0)])]));
    let (left, between, right) =
        (hz(&[housing(&[("R1", 1.0)])]), hz(&[housing(&[("R1", 0.5), ("R2", 0.5)])]), hz(&[housing(&[("R2", 1.0)])]));
    assert!(left[9] < between[9] && between[9] < right[9]);
    let one = hz(&[housing(&[("R3", 1.0)])]);
    let two = hz(&[housing(&[("R3", 1.0)]), housing(&[("R7", 1.0)])]);
    assert!(two.iter().zip(&one).all(|(two, one)| *two <= one * (1.0 + 1e-12)));
    let halves = RigidMass { mass_kg: 13.5, inertia_kg_m2: [0.275, 0.275, 0.06], ..housing(&[("R3", 1.0)]) };
    assert_close(&hz(&[halves.clone(), halves]), &one, 1e-11);
}

#[test]
fn receptance_is_symmetric_and_signs_are_fixed() {
    let points = [along(&[("R4", 0.25), ("R5", 0.75)], [0.0, 0.0, -1.0]), upwards("R4"), upwards("R5")];
    let body = housing(&[("R4", 1.0)]);
    let modes = station(&study_interface(1500.0)).modes_at(&[body], &options(1000.0), &points).expect("modes");
    for column in modes.rows.column_iter() {
        let largest = column.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs())).expect("rows");
        assert!(largest > -1e-5 * column.amax());
    }
    let [between, a, b] = [0, 1, 2].map(|at| row(&modes, at));
    for ((value, a), b) in between.iter().zip(a).zip(b) {
        assert!((value + 0.25 * a + 0.75 * b).abs() < 1e-14);
    }
    assert_eq!(modes.damping_ratio, vec![0.02; modes.omega_rad_s.len()]);
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("pool");
        pool.install(|| {
            let (body, points) = (housing(&[("R2", 1.0)]), ["R1", "R2", "R9", "T5"].map(upwards));
            let modes = station(&study_interface(1500.0)).modes_at(&[body], &options(1000.0), &points);
            let modes = modes.expect("modes");
            let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
            (bits(&modes.omega_rad_s), bits(modes.rows.as_slice()))
        })
    };
    assert_eq!(run(1), run(4));
}

/// The station's modes as a table of z at R5 and T5 and all DOFs of R5, solved for here.
fn station_table() -> (ModalTable, InterfacePoints) {
    let reduced = station(&study_interface(1e7));
    // `L^-1 M L^-T y = y / omega^2` with `K = L L'`, whose large eigenvalues are the low frequencies.
    let l = cholesky(reduced.k_zz().clone()).expect("stands");
    let mut half = reduced.m_zz().clone();
    solve_lower(&l, &mut half).expect("regular");
    let mut scaled = half.transpose();
    solve_lower(&l, &mut scaled).expect("regular");
    let SymmetricEigen { values, vectors: mut shapes } = symmetric_eigen(&scaled).expect("symmetric");
    solve_lower_transposed(&l, &mut shapes).expect("regular");
    let shapes = multiply(reduced.transfer(), &shapes).expect("fits");
    let columns: Vec<String> = (0..6).map(|dof| format!("R5.{}", decore_model::structure::DOF_NAMES[dof])).collect();
    let mut text = format!("mode,frequency_hz,damping_ratio,{},T5.z\n", columns.join(","));
    let interface = reduced.interface();
    let mut rows: Vec<usize> = (0..6).map(|dof| interface.row_of("R5", dof).expect("kept")).collect();
    rows.push(interface.row_of("T5", 2).expect("kept"));
    for (s, mode) in (0..values.len()).rev().enumerate() {
        let omega = values[mode].sqrt().recip();
        let values: Vec<String> = rows.iter().map(|row| (shapes[(*row, mode)] * omega).to_string()).collect();
        text += &format!("{},{},{},{}\n", s + 1, omega / TAU, 0.01 + 1e-5 * s as f64, values.join(","));
    }
    let points = "name,role,x_m,y_m,z_m\nR5,mount,0.36,0,1.605\nT5,fixture,0.36,0,0.41\n";
    let points = InterfacePoints::parse("points.csv", points).expect("valid");
    (ModalTable::parse("modes.csv", &text).expect("valid"), points)
}

#[test]
fn modal_table_returns_its_own_modes_and_takes_housings() {
    let (table, points) = station_table();
    let structure = ReducedStructure::from_modal_table(&table, points).expect("valid");
    assert!(structure.has_own_damping());
    let own = structure.modes_at(&[], &options(1000.0), &[upwards("T5")]).expect("modes");
    let count = own.omega_rad_s.len();
    assert_eq!(own.damping_ratio[..], table.damping_ratio[..count]);
    let listed = table.shapes.row(table.shapes.nrows() - 1).iter().copied().take(count).collect::<Vec<f64>>();
    assert_eq!(row(&own, 0), listed);
    for (own, listed) in frequencies_hz(&own).iter().zip(&table.frequency_hz) {
        assert!((own / listed - 1.0).abs() < 1e-15);
    }
    let body = housing(&[("R5", 1.0)]);
    let with_housing = structure.modes_at(&[body], &options(310.0), &[]).expect("modes");
    assert_close(&frequencies_hz(&with_housing), &numbers(&reference()["full_hz"]), 1e-9);
    let range = 0.01..0.01 + 1e-5 * table.frequency_hz.len() as f64;
    assert!(with_housing.damping_ratio.iter().all(|ratio| *ratio > 0.5 * range.start && *ratio < range.end));
}

/// Two unit modes, one grows heavier: `omega^2 = k/(1 + m phi^2)`, `2 xi omega = c/(1 + m phi^2)`.
#[test]
fn modal_table_with_one_mode_has_a_closed_form() {
    let table = "mode,frequency_hz,damping_ratio,A.x,A.y,A.z,A.rx,A.ry,A.rz\n1,10,0.03,0,0,0.5,0,0,0\n";
    let points = InterfacePoints::parse("p", "name,role,x_m,y_m,z_m\nA,mount,0,0,0\n").expect("valid");
    let table = ModalTable::parse("m", table).expect("valid");
    let structure = ReducedStructure::from_modal_table(&table, points).expect("valid");
    let modes = structure.modes_at(&[housing(&[("A", 1.0)])], &options(100.0), &[upwards("A")]).expect("modes");
    let factor = 1.0 + 27.0 * 0.25;
    assert_close(&frequencies_hz(&modes), &[10.0 / f64::sqrt(factor)], 1e-13);
    assert_close(&modes.damping_ratio, &[0.03 / f64::sqrt(factor)], 1e-13);
    assert_close(&row(&modes, 0), &[0.5 / f64::sqrt(factor)], 1e-13);
}

#[test]
fn modal_tables_that_do_not_fit_together_are_errors() {
    let (table, points) = station_table();
    let refuses = |change: &dyn Fn(&mut ModalTable), wanted: &str| {
        let mut changed = table.clone();
        change(&mut changed);
        let error = ReducedStructure::from_modal_table(&changed, points.clone()).expect_err(wanted).to_string();
        assert!(error.contains(wanted), "{error}");
    };
    refuses(&|table| table.damping_ratio.truncate(3), "damping ratios, shapes of");
    refuses(&|table| table.dofs.truncate(1), "shapes of 1 x");
    refuses(&|table| table.frequency_hz.swap(0, 9), "frequencies that rise");
    refuses(&|table| table.damping_ratio[0] = -0.1, "all >= 0");
    refuses(&|table| table.shapes[(0, 0)] = f64::NAN, "finite modal displacements");
    refuses(&|table| table.dofs[0].dof = 6, "direction of R5: expected 0 to 5");
    refuses(&|table| table.dofs[0].point = "R6".to_owned(), "nearest known name is \"R5\"");
}

fn diagonal(values: &[f64]) -> CsMat<f64> {
    let mut triplets = TriMat::new((values.len(), values.len()));
    for (i, value) in values.iter().enumerate() {
        triplets.add_triplet(i, i, *value);
    }
    triplets.to_csr()
}

#[test]
fn bad_models_are_errors() {
    let fails = |mass: CsMat<f64>, stiffness: CsMat<f64>, points: InterfacePoints, wanted: &str| {
        let error = fe_model(mass, stiffness, points).expect_err(wanted).to_string();
        assert!(error.contains(wanted), "{error}");
    };
    let one = || diagonal(&[1.0; 6]);
    fails(diagonal(&[1.0; 7]), one(), points(1), "stiffness: 6 rows, but the mass mass has 7");
    fails(
        diagonal(&[1.0, -2.0, 1.0, 1.0, 1.0, 1.0]),
        one(),
        points(1),
        "mass: diagonal 2 is -2e0: a mass is not negative",
    );
    fails(one(), diagonal(&[1.0, 1.0, -1.0, 1.0, 1.0, 1.0]), points(1), "stiffness: diagonal 3 is -1e0");
    fails(diagonal(&[1.0, f64::NAN, 1.0, 1.0, 1.0, 1.0]), one(), points(1), "mass: an entry is not finite");
    fails(one(), one(), points(2), "points: point N1: rows 6 to 11 exceed the matrices' 6");
    fails(CsMat::zero((6, 7)), one(), points(1), "mass: not square: 6 rows, 7 columns");
    let coupled = |value: f64| {
        let mut triplets = TriMat::new((6, 6));
        (0..6).for_each(|i| triplets.add_triplet(i, i, 1.0));
        triplets.add_triplet(0, 1, value);
        triplets.add_triplet(1, 0, 1.5);
        triplets.to_csr()
    };
    fails(coupled(1.5), one(), points(1), "mass: the mass matrix is not positive semidefinite");
    fails(
        one(),
        coupled(1.4),
        points(1),
        "stiffness: the matrix is not symmetric: entry (1, 2) is 1.4e0, entry (2, 1) is 1.5e0",
    );
    let no_rows = InterfacePoints::parse("p", "name,role,x_m,y_m,z_m\nA,mount,0,0,0\n").expect("valid");
    fails(one(), one(), no_rows, "points: column first_row_0based or node is missing: point A");
}

#[test]
fn files_are_read_and_their_faults_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("written");
        path
    };
    const HEAD: &str = "%%MatrixMarket matrix coordinate real symmetric\n6 6 6\n";
    let entries: String = (1..=6).map(|i| format!("{i} {i} {i}\n")).collect();
    let mass = write("M.mtx", &format!("{HEAD}{entries}"));
    let points = write("points.csv", "name,role,first_row_0based,dofs,x_m,y_m,z_m\nA,mount,0,6,0,0,0\n");
    let read = |mass: &Path, stiffness: &Path| {
        let file = |path: &Path| MatrixFile { path: path.to_owned(), name: String::new() };
        FeModel::read(&ModelFiles {
            format: MatrixFormat::MatrixMarket,
            units: Units::Si,
            stiffness: file(stiffness),
            mass: file(mass),
            damping: None,
            dofs: None,
            nodes: None,
            dofs_per_node: None,
            points: points.clone(),
        })
    };
    let model = read(&mass, &mass).expect("valid");
    assert_eq!((model.order(), model.points().iter().count()), (6, 1));
    let cut = write("K.mtx", &format!("{HEAD}{}", entries.split_at(12).0));
    let error = read(&mass, &cut).expect_err("cut").to_string();
    assert!(error.contains("K.mtx, line 5: the file is truncated: entry 3 of 6 expected"), "{error}");
    let missing = read(&folder.path().join("none.mtx"), &mass);
    assert!(matches!(missing, Err(StructureError::Read { .. })), "{missing:?}");
    let binary = folder.path().join("binary.mtx");
    std::fs::write(&binary, [0xff, 0xfe, 0x00, 0x9f]).expect("written");
    assert!(read(&binary, &mass).is_err());
}

#[test]
fn bad_requests_are_errors() {
    let model = FeModel::station().expect("shipped data");
    let fails = |interface: Vec<(String, usize)>, cutoff: f64, wanted: &str| {
        let settings = ReductionSettings { interface, fixed_interface_cutoff_hz: cutoff };
        let error = reduce(&model, &settings).expect_err(wanted).to_string();
        assert!(error.contains(wanted), "{error}");
    };
    let r5z = || vec![("R5".to_owned(), 2)];
    fails(vec![("R10".to_owned(), 2)], 1e3, "unknown interface point \"R10\"; the nearest known name is \"R1\"");
    fails(vec![("R5".to_owned(), 6)], 1e3, "direction of interface point R5: expected 0 to 5");
    fails(vec![("R5".to_owned(), usize::MAX)], 1e3, "expected 0 to 5");
    fails(vec![], 1e3, "at least one interface DOF");
    for cutoff in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        fails(r5z(), cutoff, "fixed_interface_cutoff_hz: expected a positive, finite frequency");
    }

    let reduced = station(&ReductionSettings { interface: r5z(), fixed_interface_cutoff_hz: 1500.0 });
    let refuses = |bodies: &[RigidMass], options: &ModalOptions, wanted: &str| {
        let error = reduced.modes_at(bodies, options, &[]).expect_err(wanted).to_string();
        assert!(error.contains(wanted), "{error}");
    };
    let good = options(1000.0);
    refuses(&[housing(&[("R5", 1.0)])], &good, "direction x is not in the reduced structure (kept: z)");
    refuses(&[housing(&[("R55", 1.0)])], &good, "nearest known name is \"R5\"");
    refuses(&[housing(&[])], &good, "at least one interface point");
    refuses(&[housing(&[("R5", f64::NAN)])], &good, "weight of R5");
    for mass_kg in [0.0, -27.0, f64::NAN] {
        refuses(&[RigidMass { mass_kg, ..housing(&[("R5", 1.0)]) }], &good, "attached mass: expected a positive mass");
    }
    let body = housing(&[("R5", 1.0)]);
    refuses(&[RigidMass { inertia_kg_m2: [-1.0, 0.0, 0.0], ..body.clone() }], &good, "attached inertia");
    refuses(&[RigidMass { centre_of_mass_m: [f64::NAN; 3], ..body }], &good, "attached centre of mass");
    refuses(&[], &options(0.0), "cutoff_hz: expected a positive");
    refuses(&[], &options(1.0), "no mode below 1 Hz; the lowest lies at 3.2084 Hz");
    refuses(&[], &ModalOptions { damping: Damping::Ratio(-0.1), ..good.clone() }, "damping ratio");
    refuses(
        &[],
        &ModalOptions { damping: Damping::PerMode(vec![0.02; 3]), ..good.clone() },
        "damping ratios: expected one for",
    );
    refuses(&[], &ModalOptions { damping: Damping::PerMode(vec![f64::NAN; 300]), ..good.clone() }, "damping ratio");
    assert!(reduced.modes_at(&[], &good, &[upwards("T5")]).is_err());
    assert!(reduced.modes_at(&[], &good, &[along(&[("R5", 1.0)], [1.0, 0.0, 0.0])]).is_err());
}

#[test]
fn wrong_signs_of_the_stiffness_are_found() {
    let mut k = TriMat::new((6, 6));
    (0..6).for_each(|i| k.add_triplet(i, i, 1e4));
    k.add_triplet(0, 1, 1.001e4);
    k.add_triplet(1, 0, 1.001e4);
    let model = fe_model(diagonal(&[1.0; 6]), k.to_csr(), points(1)).expect("valid");
    let interface = (0..6).map(|dof| ("N0".to_owned(), dof)).collect();
    let error =
        reduce(&model, &ReductionSettings { interface, fixed_interface_cutoff_hz: 1.0 }).expect_err("indefinite");
    assert!(
        matches!(error, StructureError::Indefinite { omega_squared } if (omega_squared + 10.0).abs() < 1e-6),
        "{error}"
    );
}

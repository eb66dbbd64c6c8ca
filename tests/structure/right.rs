//! Right models of CalculiX, each of a kind that once gave a false alarm or a wrong mass. The masses and frequencies are CalculiX' own.

use std::path::PathBuf;

use decore_model::structure::{MatrixFormat, QualityReport, QualitySettings, ReductionSettings, assess};

use crate::outside::Case;

fn data(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/foreign").join(name)
}

/// The report of a model, with the places of its nodes or without.
fn report(name: &str, points: &str, with_nodes: bool) -> QualityReport {
    let mut case = Case::new(MatrixFormat::Calculix, points);
    case.files.stiffness.path = data(&format!("{name}.sti.gz"));
    case.files.mass.path = data(&format!("{name}.mas.gz"));
    case.files.dofs = Some(data(&format!("{name}.dof")));
    case.files.nodes = with_nodes.then(|| data(&format!("{name}.inp")));
    let point = points.lines().nth(1).and_then(|line| line.split(',').next()).expect("a point");
    let interface = (0..3).map(|dof| (point.to_owned(), dof)).collect();
    let reduction = ReductionSettings { interface, fixed_interface_cutoff_hz: 2e3 };
    let settings = QualitySettings { reduction, cutoff_hz: 1e3, damping_ratio: 0.02 };
    assess(&case.read().expect("valid"), &settings).expect("a report")
}

/// What a report says of mass (kg, along x, y, z), within 1e-3, and of the lowest mode.
fn agrees(report: &QualityReport, mass_kg: [f64; 3], lowest_hz: f64) {
    assert!(report.remarks.is_empty(), "{:?}", report.remarks);
    let found = report.total_mass_kg.expect("labels");
    assert!(found.iter().zip(mass_kg).all(|(found, exact)| (found / exact - 1.0).abs() < 1e-3), "{found:?}");
    let hz = report.modes[0].full_hz;
    assert!((hz / lowest_hz - 1.0).abs() < 1e-6, "{hz} {lowest_hz}");
}

#[test]
fn inner_shapes_beside_held_nodes_have_no_mass() {
    // Distorted C3D8I of 125.6 kg, held at one face: the consistent mass of the nodes that are left is 105.2482 kg.
    for with_nodes in [false, true] {
        let report = report("held_c3d8i", "name,x_m,y_m,z_m,node\nA,0.4,0.2,0.2,45\n", with_nodes);
        agrees(&report, HELD_KG, 935.5874);
    }
}

const HELD_KG: [f64; 3] = [105.248_212; 3];

#[test]
fn beams_that_are_held_keep_their_mass() {
    // B31 is expanded to C3D8I; the mass of held ends is in no row. A rigid body on a beam may turn about its axis.
    for with_nodes in [false, true] {
        let report = report("frame_b31", "name,x_m,y_m,z_m,node,rotation_node\nARM,0.6,0,1.05,18,19\n", with_nodes);
        assert!(report.remarks.is_empty(), "{:?}", report.remarks);
        let mass = report.total_mass_kg.expect("labels");
        assert!(mass.iter().all(|mass| (0.90 * 58.24..58.24).contains(mass)), "{mass:?}");
        let hz: Vec<f64> = report.modes.iter().map(|mode| mode.full_hz).collect();
        assert!(hz[0] == 0.0 && (hz[1] / 17.99764 - 1.0).abs() < 1e-6, "{hz:?}");
    }
}

#[test]
fn thin_shells_are_not_taken_for_mixed_units_nor_rounding_for_coupling() {
    // S4R of 4 mm on elements of 150 mm; its mass has entries of 1e-19 in rows without mass.
    let points = "name,x_m,y_m,z_m,node,rotation_node\nMID,0.45,0.3,0.1,36,37\n";
    for with_nodes in [false, true] {
        let report = report("plate_s4r", points, with_nodes);
        agrees(&report, [22.956; 3], 57.51587);
        if with_nodes {
            let centre = report.centre_of_mass_m.expect("places");
            let exact = [0.45, 0.3, 0.026_136_957_658];
            assert!(centre.iter().zip(exact).all(|(found, exact)| (found - exact).abs() < 1e-6), "{centre:?}");
        }
    }
}

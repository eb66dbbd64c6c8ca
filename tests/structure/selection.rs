//! Modes that are selected without solving for those above an edge, against the selection among all.

use std::f64::consts::TAU;

use decore_model::direction::DOWN;
use decore_model::structure::{
    Damping, DirectedPoints, FeModel, ModalOptions, ModesAt, ReducedStructure, ReductionSettings, RigidMass,
    SelectionSettings, reduce,
};
use nalgebra::DMatrix;

/// All ratios.
const XI: f64 = 0.02;

/// The station with the mounts of its rail and the points of its table.
fn station() -> ReducedStructure {
    let mounts = ["R4", "R5", "R6"].into_iter().flat_map(|point| (0..6).map(move |dof| (point.to_owned(), dof)));
    let verticals = ["T1", "T3", "T7", "T9"].into_iter().map(|point| (point.to_owned(), 2));
    let interface = mounts.chain(verticals).collect();
    let settings = ReductionSettings { interface, fixed_interface_cutoff_hz: 25_000.0 };
    reduce(&FeModel::station().expect("shipped"), &settings).expect("reduces")
}

fn rows(mount: &[(String, f64)]) -> Vec<DirectedPoints> {
    let verticals = ["T1", "T3", "T7", "T9"].into_iter().map(|point| vec![(point.to_owned(), 1.0)]);
    [mount.to_vec()].into_iter().chain(verticals).map(|points| (points, [0.0, 0.0, -1.0])).collect()
}

/// A housing of a mass between two mounts of the rail.
fn housing(mass_kg: f64, share: f64) -> RigidMass {
    RigidMass {
        points: vec![("R5".to_owned(), 1.0 - share), ("R6".to_owned(), share)],
        mass_kg,
        inertia_kg_m2: [0.55, 0.5, 0.12],
        centre_of_mass_m: [0.03, -0.05, -0.2],
        axis: DOWN,
    }
}

/// Receptances between all rows, `sum phi phi' / (omega^2 - w^2 + 2 i xi omega w)`: real and imaginary parts.
fn receptances(omega: &[f64], xi: &[f64], rows: &DMatrix<f64>, w: f64) -> [DMatrix<f64>; 2] {
    let part = |of: fn(f64, f64) -> f64| {
        let mut scaled = rows.clone();
        for ((mut column, omega), xi) in scaled.column_iter_mut().zip(omega).zip(xi) {
            let (re, im) = (omega * omega - w * w, 2.0 * xi * omega * w);
            column.scale_mut(of(re, im) / (re * re + im * im));
        }
        scaled * rows.transpose()
    };
    [part(|re, _| re), part(|_, im| -im)]
}

/// `sum phi phi' omega^power` over all modes.
fn weighted(modes: &ModesAt, power: i32) -> DMatrix<f64> {
    let mut scaled = modes.rows.clone();
    for (mut column, omega) in scaled.column_iter_mut().zip(&modes.omega_rad_s) {
        column.scale_mut(omega.powi(power));
    }
    scaled * modes.rows.transpose()
}

#[test]
fn the_rest_has_the_statics_and_the_mass_of_the_modes_that_were_not_solved_for() {
    let station = station();
    let damping = Damping::Ratio(XI);
    let settings = SelectionSettings { tolerance: 1e-3, band_hz: 1000.0 };
    for body in [housing(27.0, 0.0), housing(27.0, 0.37), housing(0.5, 0.9), housing(300.0, 0.5)] {
        let rows = rows(&body.points);
        let options = ModalOptions { cutoff_hz: f64::MAX, damping: damping.clone() };
        let all = station.modes_at(std::slice::from_ref(&body), &options, &rows).expect("modes");
        let few = station.modes_to_select(std::slice::from_ref(&body), &damping, &rows, settings).expect("modes");
        let rest = few.rest.expect("most modes are not needed one by one");
        assert_eq!(rest.first + rest.count, all.omega_rad_s.len());
        assert!(2 * rest.count > rest.first, "{rest:?}");
        for (mode, (found, expected)) in few.omega_rad_s[..rest.first].iter().zip(&all.omega_rad_s).enumerate() {
            assert!((found / expected - 1.0).abs() < 1e-9, "mode {mode}: {found} rad/s instead of {expected}");
        }
        assert!(few.omega_rad_s[rest.first..].iter().all(|omega| *omega >= rest.edge_rad_s));
        for power in [0, -2] {
            let (found, expected) = (weighted(&few, power), weighted(&all, power));
            let off = (found - &expected).amax() / expected.amax();
            assert!(off < 1e-9, "{} kg: off by {off:e} at power {power}", body.mass_kg);
        }

        // The selection keeps its promise against all modes, and asks for few modes more than one among all.
        let [selected, among_all] = [&few, &all].map(|modes| modes.select(settings).expect("selected"));
        assert_eq!(selected.available, among_all.available);
        assert!(selected.bound <= settings.tolerance && selected.kept.len() <= among_all.kept.len() + 20);
        let omega: Vec<f64> = selected.kept.iter().map(|mode| few.omega_rad_s[*mode]).collect();
        let flexibility = weighted(&all, -2);
        for step in 0..=400 {
            let w = TAU * 2.5 * f64::from(step);
            let full = receptances(&all.omega_rad_s, &all.damping_ratio, &all.rows, w);
            let kept = receptances(&omega, &vec![XI; omega.len()], &selected.rows, w);
            let residual = &selected.residual;
            let residual = receptances(&residual.omega_rad_s, &residual.damping_ratio, &residual.rows, w);
            for (i, j) in (0..rows.len()).flat_map(|i| (0..=i).map(move |j| (i, j))) {
                let off = [0, 1].map(|part| full[part][(i, j)] - kept[part][(i, j)] - residual[part][(i, j)]);
                let error = off[0].hypot(off[1]) / (flexibility[(i, i)] * flexibility[(j, j)]).sqrt();
                assert!(error <= selected.bound, "{error} beyond {} at {w} rad/s", selected.bound);
            }
        }
    }
}

#[test]
fn modes_are_all_solved_for_where_the_rest_is_not_known_together() {
    let station = station();
    let body = housing(27.0, 0.0);
    let rows = rows(&body.points);
    let all = |damping: Damping, tolerance: f64| {
        let settings = SelectionSettings { tolerance, band_hz: 1000.0 };
        let modes = station.modes_to_select(std::slice::from_ref(&body), &damping, &rows, settings);
        modes.expect("modes").rest.is_none()
    };
    assert!(all(Damping::Ratio(XI), 0.0), "every mode counts");
    assert!(all(Damping::PerMode(vec![XI; 2000]), 1e-3), "whose ratio is it?");
    assert!(!all(Damping::Ratio(XI), 1e-3));
    assert!(
        station
            .modes_to_select(
                std::slice::from_ref(&body),
                &Damping::Ratio(-1.0),
                &rows,
                SelectionSettings { tolerance: 1e-3, band_hz: 1000.0 }
            )
            .is_err()
    );
}

//! Studies with an elastic casting, from files of matrices to a row.

use std::fs;
use std::path::Path;

use decore_dataset::{Columns, TableName};
use decore_model::run::{RowOutcome, RowStatus};
use decore_study::Study;
use decore_study::engine::{Engine, RowRunner};
use tempfile::TempDir;

use crate::solid::write_block;

/// The part of a study that makes its casting elastic.
const STRUCTURE: &str = "[casting.part.structure]\nstiffness_file = \"K.mtx\"\nmass_file = \"M.mtx\"\ndof_file = \"rows.dof\"\n\
     nodes_file = \"nodes.csv\"\npoint_radius_m = 0.025\ncutoff_hz = 5000.0\n";

/// A study of one hammer on the block of bricks on four pads; `structure` makes it elastic.
fn study(structure: &str) -> String {
    let pad = |name: &str, x: f64, y: f64| {
        format!(
            "[casting.part.fixture.{name}]\npoint = \"T5\"\nat_m = [{x}, {y}]\nstiffness_n_per_m = 8e6\ndamping_n_s_per_m = 1500.0\n"
        )
    };
    let pads = [pad("a", -0.06, -0.02), pad("b", 0.06, -0.02), pad("c", -0.06, 0.02), pad("d", 0.06, 0.02)].concat();
    format!(
        "duration_s = 0.2\ngeometry = \"as_given\"\n[structure]\ncutoff_hz = 300.0\n[hammer.left]\nmount = \"R5\"\nsupply_bar = 5.0\n\
         [solver]\ntolerance = 1e-7\n[casting.part]\nmass_kg = 1.0368\ninertia_kg_m2 = [4.49280e-4, 2.350080e-3]\n\
         [casting.part.core.top]\nat_m = [0.03, 0.01, 0.01]\n{pads}{structure}"
    )
}

fn engine(text: &str, folder: &Path) -> Result<Engine, String> {
    fs::write(folder.join("study.toml"), text).unwrap();
    let study = Study::load(&folder.join("study.toml")).map_err(|error| error.to_string())?;
    Engine::new(study).map_err(|error| error.to_string())
}

fn outcome(text: &str, folder: &Path) -> RowOutcome {
    let outcome = engine(text, folder).unwrap_or_else(|error| panic!("{error}")).outcome(0);
    assert_eq!(outcome.status, RowStatus::Done, "{}", outcome.reason);
    outcome
}

/// Energy, work, casting velocities and the share of the audit that is missing.
fn figures(outcome: &RowOutcome) -> [f64; 5] {
    let metrics = outcome.metrics.as_ref().unwrap();
    assert!(metrics.totals.energy_residual.abs() < 1e-5, "{:e}", metrics.totals.energy_residual);
    let (hammer, casting) = (&metrics.hammers[0], &metrics.castings[0]);
    [
        hammer.first_impact_energy_j.unwrap(),
        hammer.first_impact_work_j.unwrap(),
        hammer.first_impact_casting_peak_velocity_m_s.unwrap(),
        casting.peak_velocity_m_s,
        casting.peak_point_velocity_m_s,
    ]
}

/// A casting 1e5 and 1e8 times stiffer than aluminium gives the outputs of the rigid one, and takes no more steps for it. Aluminium does not.
#[test]
fn a_stiff_casting_is_the_rigid_one() {
    let folder = TempDir::new().unwrap();
    let rigid = outcome(&study(""), folder.path());
    let steps = |outcome: &RowOutcome| outcome.counters.steps as f64;
    for stiffer in [1e5, 1e8] {
        write_block(70e9 * stiffer, folder.path());
        let stiff = outcome(&study(STRUCTURE), folder.path());
        for (found, expected) in figures(&stiff).into_iter().zip(figures(&rigid)) {
            println!("{stiffer:e}: {found} instead of {expected}: {:.1e}", found / expected - 1.0);
            assert!((found / expected - 1.0).abs() < 5e-6, "{stiffer:e}: {found} instead of {expected}");
        }
        assert!(steps(&stiff) < 1.2 * steps(&rigid), "{} and {}", steps(&stiff), steps(&rigid));
    }
    write_block(70e9, folder.path());
    let soft = figures(&outcome(&study(STRUCTURE), folder.path()));
    assert!((soft[0] / figures(&rigid)[0] - 1.0).abs() < 1e-4 && (soft[2] / figures(&rigid)[2] - 1.0).abs() > 1e-3);
}

/// Strain energy is an output of elastic castings alone; a stiff casting hardly strains.
#[test]
fn strain_energy_of_elastic_castings_alone() {
    let folder = TempDir::new().unwrap();
    let columns = |text: &str| {
        let columns = Columns::new(&engine(text, folder.path()).unwrap().info()).unwrap();
        let named = |table| columns.describe(table).into_iter().map(|column| column.name);
        let strain = named(TableName::Runs).chain(named(TableName::Blows)).filter(|name| name.contains("strain"));
        strain.collect::<Vec<_>>()
    };
    let peak = |young: f64| {
        write_block(young, folder.path());
        let outcome = outcome(&study(STRUCTURE), folder.path());
        let metrics = outcome.metrics.unwrap();
        let blows_j = metrics.blows.iter().map(|blow| blow.strain.as_ref().unwrap().casting_strain_energy_j);
        let [peak_j, last_j] = [metrics.elastic[0].peak_strain_energy_j, blows_j.fold(0.0, f64::max)];
        assert!(metrics.castings.len() == 1 && 0.0 < last_j && last_j < peak_j, "{last_j} {peak_j}");
        peak_j
    };
    let (soft, stiff) = (peak(70e9), peak(70e9 * 1e4));
    assert!(soft > 1e-3 && stiff < 1e-3 * soft, "{soft} {stiff}");
    assert_eq!(
        columns(&study(STRUCTURE)),
        [
            "part_peak_strain_energy_j",
            "part_peak_strain_energy_time_s",
            "part_first_impact_strain_energy_j",
            "part_periodic_strain_energy_mean_j",
            "casting_strain_energy_j"
        ]
    );
    assert!(columns(&study("")).is_empty());
    let rigid = outcome(&study(""), folder.path()).metrics.unwrap();
    assert!(rigid.elastic.is_empty() && rigid.blows.iter().all(|blow| blow.strain.is_none()));
}

/// Faults name the casting and the way out.
#[test]
fn faults_of_an_elastic_casting() {
    let folder = TempDir::new().unwrap();
    write_block(70e9, folder.path());
    let text = study(STRUCTURE);
    let reason = |text: &str| match engine(text, folder.path()) {
        Err(error) => error,
        Ok(engine) => engine.outcome(0).reason,
    };
    let heavy = reason(&text.replace("mass_kg = 1.0368", "mass_kg = 2.0"));
    assert!(heavy.contains("casting.part.mass_kg") && heavy.contains("1.0368 kg"), "{heavy}");
    let missing = reason(&text.replace("\"M.mtx\"", "\"N.mtx\""));
    assert!(missing.contains("there is no file") && missing.contains("N.mtx"), "{missing}");
    let bare = reason(&text.replace("nodes_file = \"nodes.csv\"\n", ""));
    assert!(bare.contains("casting.part.structure") && bare.contains("nodes_file"), "{bare}");
    let beside = reason(&text.replace("at_m = [0.03, 0.01, 0.01]", "at_m = [0.3, 0.0, 0.0]"));
    assert!(beside.contains("casting.part.structure") && beside.contains("larger radius"), "{beside}");
    let design = "[design]\nkind = \"full_factorial\"\n[design.factor.c]\npath = \"casting.part.structure.cutoff_hz\"\nvalues = [1000.0, 2000.0]\n";
    let driven = reason(&format!("{text}{design}"));
    assert!(driven.contains("shared by all rows"), "{driven}");
    let powers = text.replace(
        "supply_bar = 5.0\n",
        "supply_bar = 5.0\nparameters = { chisel = { casting_contact = { law = \"hertz\" } } }\n",
    );
    let hertz =
        reason(&powers.replace("cutoff_hz = 5000.0\n", "cutoff_hz = 5000.0\ncontact_includes_casting = false\n"));
    assert!(hertz.contains("contact_includes_casting = true"), "{hertz}");
}

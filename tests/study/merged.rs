//! Machine and elastic casting in decore against one finite element model of both, which SciPy solves.

use std::path::Path;
use std::process::Command;

use decore_model::scene::{FixtureId, PointId};
use decore_model::system::LinearModel;
use decore_study::engine::{Engine, RowScene};
use serde_json::Value as Json;
use tempfile::TempDir;

/// Makes the models and what SciPy finds; `None` without an interpreter that has it.
fn merged(folder: &Path) -> Option<Json> {
    let Some(python) = std::env::var_os("DECORE_PYTHON") else {
        eprintln!("DECORE_PYTHON is not set: the merged model was not compared");
        return None;
    };
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let script = [root.join("tests/merged_model.py"), root.join("studies/guide"), folder.to_owned()];
    let output = Command::new(python).args(script).output().expect("interpreter started");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read_to_string(folder.join("merged.json")).expect("written");
    Some(serde_json::from_str(&text).expect("JSON"))
}

/// Machine and casting of the study, and the modes kept of the casting.
fn linear(folder: &Path, cutoff_hz: f64) -> LinearModel {
    let setting = format!("casting.beam.structure.cutoff_hz={cutoff_hz:?}");
    let engine = Engine::load(&folder.join("study.toml"), &[setting]).unwrap_or_else(|error| panic!("{error}"));
    let RowScene { scene, modes } = engine.scene(0).expect("a scene");
    LinearModel::new(&scene, &modes).expect("sound")
}

fn numbers(json: &Json) -> Vec<f64> {
    json.as_array().expect("a list").iter().map(|value| value.as_f64().expect("a number")).collect()
}

fn point(name: &str) -> PointId {
    let fixture = |of: &str| FixtureId {
        casting: 0,
        fixture: ["a", "b", "c"].iter().position(|one| *one == of).unwrap(),
        axis: 0,
    };
    match name.split_once('.') {
        Some(("support", of)) => PointId::Support(fixture(of)),
        Some(("held", of)) => PointId::Held(fixture(of)),
        _ => match name {
            "mount" => PointId::Mount { hammer: 0 },
            "strike" => PointId::Strike { hammer: 0 },
            _ => PointId::Core { casting: 0, core: 0 },
        },
    }
}

/// Largest difference of receptances at a frequency from a table, points x points, relative to the larger of the receptance and the
/// static flexibility of its points.
fn worst(model: &LinearModel, hz: f64, (names, expected, flexibility): (&[PointId], &[Vec<f64>], &[Vec<f64>])) -> f64 {
    let found = model.receptances(hz).expect("an answer");
    let mut worst = 0.0_f64;
    let mut compared = 0;
    for (row, motion) in model.points().enumerate() {
        for (column, force) in model.driven().enumerate() {
            let place = |id: PointId| names.iter().position(|known| *known == id);
            let (Some(to), Some(from)) = (place(motion), place(force)) else { continue };
            let scale = (flexibility[to][to] * flexibility[from][from]).sqrt().max(expected[to][from].abs());
            assert!(found[(row, column)].im == 0.0);
            worst = worst.max((found[(row, column)].re - expected[to][from]).abs() / scale);
            compared += 1;
        }
    }
    assert_eq!(compared, names.len() * (names.len() - 1), "all points but the core take forces");
    worst
}

/// With all modes decore's machine and casting are the merged model: same frequencies and static flexibility. With 50 modes of the casting the
/// static flexibility stays the same, and receptances hold up to a third of the cut-off.
#[test]
fn machine_and_casting_are_one_model() {
    let folder = TempDir::new().unwrap();
    let Some(merged) = merged(folder.path()) else { return };
    let names: Vec<PointId> =
        merged["points"].as_array().unwrap().iter().map(|name| point(name.as_str().unwrap())).collect();
    let table = |json: &Json| json.as_array().unwrap().iter().map(numbers).collect::<Vec<_>>();
    let flexibility = table(&merged["static_m_per_n"]);

    let all = linear(folder.path(), 6e5);
    let expected = numbers(&merged["frequencies_hz"]);
    let found = all.frequencies_hz().unwrap();
    let mut furthest = 0.0_f64;
    for (found, expected) in found.iter().zip(&expected) {
        furthest = furthest.max((found / expected - 1.0).abs());
    }
    let still = worst(&all, 0.0, (&names, &flexibility, &flexibility));
    println!("{} modes: {} frequencies within {furthest:.1e}, static within {still:.1e}", found.len(), expected.len());
    assert!(furthest < 1e-8 && still < 1e-8, "{furthest:e} {still:e}");

    let cutoff_hz = 54_500.0;
    let few = linear(folder.path(), cutoff_hz);
    let left_out = found.len() - few.frequencies_hz().unwrap().len();
    let still = worst(&few, 0.0, (&names, &flexibility, &flexibility));
    let hertz = numbers(&merged["receptance_hz"]);
    let receptances = merged["receptance_m_per_n"].as_array().unwrap();
    let off = hertz.iter().zip(receptances).map(|(hz, expected)| {
        assert!(*hz < cutoff_hz / 3.0);
        worst(&few, *hz, (&names, &table(expected), &flexibility))
    });
    let off = off.fold(0.0, f64::max);
    println!("{left_out} modes left out: static within {still:.1e}, receptances within {off:.1e}");
    assert!(left_out > 500 && still < 1e-8 && off < 1e-3, "{left_out} {still:e} {off:e}");
}

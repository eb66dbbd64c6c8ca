//! Rows of real scenes: sweeps that are run once and kept in the target folder.

use std::path::{Path, PathBuf};
use std::process::Command;

use decore_dataset::DatasetReader;
use decore_lab::sensitivity::{FactorColumn, Table};
use decore_statistics::regression::Points;
use decore_study::DesignOutline;

/// The shipped study of three hammers has no design: pressures and standoffs.
const THREE_HAMMERS: &str = r#"
[design]
kind = "latin_hypercube"
rows = 1100
seed = 1

[design.factor.pressure_one]
path = "hammer.one.supply_bar"
range = [4.0, 6.0]

[design.factor.pressure_two]
path = "hammer.two.supply_bar"
range = [4.0, 6.0]

[design.factor.pressure_three]
path = "hammer.three.supply_bar"
range = [4.0, 6.0]

[design.factor.standoff]
paths = ["hammer.one.standoff_m", "hammer.two.standoff_m"]
range = [0.070, 0.095]

[design.factor.standoff_three]
path = "hammer.three.standoff_m"
range = [0.070, 0.095]
"#;

/// A scene whose rows are there.
pub struct Scene {
    /// Name of its study.
    pub name: &'static str,
    /// Places of the rows that are done.
    pub points: Points,
    /// Outputs of these rows, by their columns.
    pub outputs: Vec<(&'static str, Vec<f64>)>,
}

/// The outputs that are modelled.
pub const OUTPUTS: [&str; 2] = ["delivered_work_j", "max_casting_point_velocity_m_s"];

/// 1100 rows of the placement study and of three hammers: run by the built program, which goes on where it was stopped.
pub fn scenes() -> Vec<Scene> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
    let studies = root.join("studies");
    let text = std::fs::read_to_string(studies.join("three_hammers.toml")).expect("a study");
    let three = folder.join("three_hammers.toml");
    std::fs::write(&three, text + THREE_HAMMERS).expect("written");
    let placement = run(&studies.join("placement.toml"), &folder.join("placement"), &["--set", "design.rows=1100"]);
    let three = run(&three, &folder.join("three_hammers"), &[]);
    vec![scene("placement", &placement), scene("three_hammers", &three)]
}

fn run(study: &Path, folder: &Path, arguments: &[&str]) -> PathBuf {
    let mut command = Command::new(env!("CARGO_BIN_EXE_decore"));
    let output = command.arg("run").arg(study).arg("--output").arg(folder).args(arguments).output().expect("runs");
    // Rows that fail are left out.
    assert!(matches!(output.status.code(), Some(0 | 4)), "{}", String::from_utf8_lossy(&output.stderr));
    folder.to_owned()
}

fn scene(name: &'static str, folder: &Path) -> Scene {
    let reader = DatasetReader::open(folder).expect("a dataset");
    let info = &reader.manifest().study;
    let outline = DesignOutline::read(&info.study_text, &info.overrides, &info.study_name).expect("a design");
    let table = Table::read(&reader, &outline, &OUTPUTS.map(str::to_owned)).expect("a table");
    let whole = |row: &usize| {
        table.faults[*row].is_none() && table.outputs.iter().all(|output| output.values[*row].is_finite())
    };
    let rows: Vec<usize> = (0..table.rows.len()).filter(whole).collect();
    let scaled = |column: &FactorColumn| {
        let logarithmic = outline.factors.iter().any(|factor| factor.name == column.name && factor.logarithmic);
        let values = column.values.iter().map(|value| if logarithmic { value.ln() } else { *value });
        let values: Vec<f64> = values.collect();
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        values.into_iter().map(|value| (value - low) / (high - low)).collect::<Vec<f64>>()
    };
    let columns: Vec<Vec<f64>> = table.factors.iter().map(scaled).collect();
    let coordinates = rows.iter().flat_map(|row| columns.iter().map(move |column| column[*row]));
    let points = Points::new(coordinates.collect(), vec![false; columns.len()]).expect("points");
    let outputs = OUTPUTS.iter().zip(&table.outputs);
    let outputs = outputs.map(|(name, output)| (*name, rows.iter().map(|row| output.values[*row]).collect()));
    Scene { name, points, outputs: outputs.collect() }
}

//! Designs as a study asks for them: links, derived factors, tables, constraints on geometry, correlations, parts, pictures.

use std::path::Path;
use std::process::{Command, Output};
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::station::{checked, rows as rows_of, station_points};
use arrow_array::types::Int8Type;
use arrow_array::{ArrayRef, DictionaryArray, Float32Array, Int16Array, RecordBatch};
use decore_model::hammer::{HammerParameters, ValveParameters};
use decore_model::scene::Scene;
use decore_quantity::Value;
use decore_study::{CheckedStudy, Study, StudyError};
use parquet::arrow::ArrowWriter;
use tempfile::TempDir;

/// Two hammers on the rail over one casting, without a design.
const MACHINE: &str = "
[hammer.left]
rail = 'rail'
rail_position_m = -0.05
[hammer.right]
rail = 'rail'
rail_position_m = 0.05
[casting.part]
mass_kg = 3.0
centre_m = [0.36, 0.0]
size_m = [0.30, 0.28]
inertia_kg_m2 = [0.0135, 0.026]
[casting.part.fixture.front]
point = 'T1'
[casting.part.fixture.middle]
point = 'T6'
[casting.part.fixture.back]
point = 'T7'
";

const POSITIONS: &str = "
[design.factor.a]
path = 'hammer.left.rail_position_m'
range = [-0.2, 0.2]
[design.factor.b]
path = 'hammer.right.rail_position_m'
range = [-0.2, 0.2]
[design.factor.pressure]
paths = ['hammer.left.supply_bar', 'hammer.right.supply_bar']
range = [3.0, 7.0]
";

fn parse(directory: &Path, design: &str) -> Result<Study, StudyError> {
    Study::parse(&format!("{MACHINE}\n{design}"), directory, "test.toml")
}

/// The rows of a study that has some.
fn study(design: &str) -> CheckedStudy {
    constrained(design).unwrap_or_else(|error| panic!("{error}"))
}

/// The study with its constraints applied.
fn constrained(design: &str) -> Result<CheckedStudy, StudyError> {
    checked(&parse(Path::new(""), design)?)
}

fn message<T: std::fmt::Debug>(result: Result<T, StudyError>) -> String {
    result.expect_err("a fault").to_string()
}

fn scenes(study: &CheckedStudy) -> Vec<Scene> {
    (0..study.row_count()).map(|row| study.scene(row).expect("a scene")).collect()
}

fn number(value: &Value) -> f64 {
    value.number().unwrap_or_else(|| panic!("the text {value}"))
}

/// Position of a hammer of a scene along the rail, which runs along y.
fn along_rail(scene: &Scene, hammer: usize) -> f64 {
    let points = station_points();
    let mount = &scene.hammers[hammer].mount.points;
    mount.iter().map(|(point, weight)| weight * points.position(point).expect("a point")[1]).sum()
}

#[test]
fn one_factor_drives_several_paths_with_factor_and_offset() {
    let study = study(
        "[design]\nkind = 'sobol'\nrows = 16\n[design.factor.pressure]\npath = 'hammer.left.supply_bar'\nrange = [4.0, 6.0]\n\
         link = [{ path = 'hammer.right.supply_bar', factor = 0.5, offset = 1.0 },\n\
         { path = 'hammer.right.standoff_m', factor = 0.01 }]",
    );
    assert_eq!(study.study().factors()[0].paths().len(), 3);
    for (row, scene) in scenes(&study).iter().enumerate() {
        let pressure = number(&study.row_values(row)[0]);
        let gauge = |hammer: usize| (scene.hammers[hammer].supply_pressure_pa - 101_325.0) / 1e5;
        assert!((gauge(0) - pressure).abs() < 1e-9 && (gauge(1) - (0.5 * pressure + 1.0)).abs() < 1e-9);
        assert!((scene.hammers[1].standoff_m - 0.01 * pressure).abs() < 1e-12);
    }
    let fault = message(parse(
        Path::new(""),
        "[design]\nkind = 'full_factorial'\n[design.factor.mount]\nvalues = ['spring', 'tied']\n\
         link = [{ path = 'solver.guide', factor = 2.0 }]",
    ));
    assert!(fault.contains("a text has no factor or offset"), "{fault}");
}

#[test]
fn derived_factors_follow_their_expression() {
    let design = |expression: &str| {
        format!(
            "[design]\nkind = 'random'\nrows = 30\n[design.factor.middle]\npath = 'hammer.left.rail_position_m'\n\
             range = [-0.1, 0.03]\n[design.factor.right]\nexpression = '{expression}'\n\
             path = 'hammer.right.rail_position_m'\nunit = 'm'"
        )
    };
    let study = study(&design("min(middle + 0.1, 0.15) - 0.5 * middle^2"));
    for (row, scene) in scenes(&study).iter().enumerate() {
        let values = study.row_values(row);
        let middle = number(&values[0]);
        let known = (middle + 0.1).min(0.15) - 0.5 * middle * middle;
        assert!((number(&values[1]) - known).abs() < 1e-15 && (along_rail(scene, 1) - known).abs() < 1e-12);
    }
    let fault = message(parse(Path::new(""), &design("midle + 0.1")));
    assert!(fault.contains("there is no factor `midle`") && fault.contains("did you mean `middle`?"), "{fault}");
    let fault = message(parse(Path::new(""), &design("middle +")));
    assert!(fault.contains("design.factor.right.expression") && fault.contains("test.toml:27:14"), "{fault}");
}

/// Rows as a file for `kind = "table"`: position, a whole number of steps, a guide.
fn csv(rows: &[(f64, i16, &str)]) -> String {
    let line = |(position, steps, guide): &(f64, i16, &str)| format!("{steps},\"{guide}\",x, {position}\n");
    format!("\u{feff}steps,guide,remark,\"position\"\n{}", rows.iter().map(line).collect::<String>())
}

const TABLE: &str = "
[design.factor.position]
path = 'hammer.left.rail_position_m'
range = [-0.1, 0.1]
[design.factor.guide]
path = 'solver.guide'
values = ['spring', 'tied']
[design.factor.steps]
path = 'solver.max_steps'
range = [1000, 2000]
integer = true
";

#[test]
fn tables_come_from_csv_and_parquet() {
    let folder = TempDir::new().expect("scratch folder");
    let rows = [(0.05, 1000, "tied"), (-0.1, 1500, "spring"), (0.0625, 2000, "tied")];
    std::fs::write(folder.path().join("rows.csv"), csv(&rows)).expect("written");
    let columns: Vec<(&str, ArrayRef)> = vec![
        ("steps", Arc::new(Int16Array::from_iter_values(rows.map(|row| row.1)))),
        ("guide", Arc::new(DictionaryArray::<Int8Type>::from_iter(rows.map(|row| row.2)))),
        ("position", Arc::new(Float32Array::from_iter_values(rows.map(|row| row.0 as f32)))),
    ];
    let batch = RecordBatch::try_from_iter(columns).expect("a batch");
    let file = std::fs::File::create(folder.path().join("rows.parquet")).expect("created");
    let mut writer = ArrowWriter::try_new(file, batch.schema(), None).expect("a writer");
    writer.write(&batch).and_then(|()| writer.close().map(|_| ())).expect("written");
    for name in ["rows.csv", "rows.parquet"] {
        let study = parse(folder.path(), &format!("[design]\nkind = 'table'\nfile = '{name}'\n{TABLE}"));
        let study = rows_of(&study.unwrap_or_else(|error| panic!("{error}")));
        assert_eq!(study.row_count(), 3);
        for (row, (position, steps, guide)) in rows.iter().enumerate() {
            let values = study.row_values(row);
            assert!((number(&values[0]) - position).abs() < 1e-8, "{name}: {values:?}");
            assert_eq!(values[1..], [Value::Text((*guide).into()), Value::Integer(i64::from(*steps))]);
        }
    }
}

/// A design whose rows are a file of `tests/data/tables`.
fn shipped_table(name: &str) -> Result<Study, StudyError> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/tables");
    parse(&folder, &format!("[design]\nkind = 'table'\nfile = '{name}.parquet'\n{TABLE}"))
}

#[test]
fn tables_of_other_programs_are_read_however_they_are_packed() {
    let packed = ["none", "snappy", "gzip", "zstd", "lz4"].map(|name| format!("pyarrow_{name}"));
    for name in packed.iter().map(String::as_str).chain(["pandas", "polars", "duckdb"]) {
        let study = shipped_table(name).map(|study| rows_of(&study)).unwrap_or_else(|error| panic!("{name}: {error}"));
        let rows: Vec<Vec<String>> =
            (0..3).map(|row| study.row_values(row).iter().map(ToString::to_string).collect()).collect();
        assert_eq!(rows, [["0.05", "tied", "1000"], ["-0.1", "spring", "1500"], ["0.0625", "tied", "2000"]], "{name}");
    }
    let brotli = message(shipped_table("pyarrow_brotli"));
    assert!(brotli.contains("is packed with BROTLI") && brotli.contains("snappy, gzip, zstd, lz4"), "{brotli}");
}

/// Each of these ended the decoder by a panic, or took 700 MB.
#[test]
fn damaged_tables_are_refused_with_words() {
    for number in 1..=3 {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/tables");
        let fuzzed = std::fs::read_to_string(folder.join("../fuzz/kinds.toml")).expect("study");
        let (before, after) = fuzzed.split_once("[design]").expect("design");
        let (_, factors) = after.split_once("[design.factor.x]").expect("factors");
        let table = format!("[design]\nkind = 'table'\nfile = 'damaged_{number}.parquet'\n[design.factor.x]{factors}");
        let text = message(Study::parse(&format!("{before}{table}"), &folder, "test.toml"));
        assert!(text.contains(&format!("damaged_{number}.parquet: ")) && text.contains("cannot read"), "{text}");
    }
}

#[test]
fn faults_of_tables_name_file_line_and_column() {
    let folder = TempDir::new().expect("scratch folder");
    let fault = |text: &str| {
        std::fs::write(folder.path().join("rows.csv"), text).expect("written");
        message(parse(folder.path(), &format!("[design]\nkind = 'table'\nfile = 'rows.csv'\n{TABLE}")))
    };
    let good = csv(&[(0.05, 1000, "tied"), (0.0, 1500, "spring")]);
    // Between semicolons a comma is the decimal point.
    let other = good.replace(',', ";").replace('.', ",");
    std::fs::write(folder.path().join("rows.csv"), other).expect("written");
    let read = parse(folder.path(), &format!("[design]\nkind = 'table'\nfile = 'rows.csv'\n{TABLE}")).expect("study");
    assert_eq!(rows_of(&read).row_values(0)[0].to_string(), "0.05");
    let holds = |text: &str, words: &[&str]| {
        let fault = fault(text);
        assert!(words.iter().all(|word| fault.contains(word)), "{fault}");
        assert!(fault.contains("design.file") && fault.contains("test.toml:22:8"), "{fault}");
    };
    holds(
        &good.replace("0.05", "0.5"),
        &["rows.csv, line 2, column `position`", "outside the factor's range, -0.1 to 0.1"],
    );
    holds(&good.replace("spring", "sprung"), &["line 3, column `guide`: `sprung` is none of spring | tied"]);
    holds(&good.replace("1500", "1500.5"), &["line 3, column `steps`", "no whole number from 1000 to 2000"]);
    holds(&good.replace(" 0.05", "wide"), &["line 2, column `position`: `wide` is no number"]);
    holds(&good.replace("1000,", ""), &["line: 2"]);
    holds(
        &good.replace("steps", "stages"),
        &["has no column `steps` (or `factor_steps`); it has: stages, guide, remark, position"],
    );
    holds(
        &good.replace("remark", "factor_steps"),
        &["a column `steps` and a column `factor_steps`: rename the one that is not meant"],
    );
    holds(&good.replace("remark", "steps"), &["both are `steps`: rename the one that is not meant"]);
    holds("steps;guide;position\n1,500;tied;0\n1,250;tied;0\n", &["is 1,500 a thousand or a decimal comma?"]);
    holds("steps,guide,position\n", &["has no rows"]);
    let missing = message(parse(folder.path(), &format!("[design]\nkind = 'table'\nfile = 'none.parquet'\n{TABLE}")));
    assert!(missing.contains("cannot read") && missing.contains("none.parquet"), "{missing}");
}

/// Every kind of design that constraints choose the rows of.
const KINDS: [&str; 6] = [
    "kind = 'random'\nrows = 60",
    "kind = 'sobol'\nrows = 60",
    "kind = 'halton'\nrows = 60",
    "kind = 'latin_hypercube'\nrows = 60",
    "kind = 'latin_hypercube'\nrows = 30\noptimise = 'maximin'",
    "kind = 'morris'\ntrajectories = 12",
];

const SEPARATE: &str = "
[design.factor.a]
path = 'hammer.left.rail_position_m'
range = [-0.13, 0.13]
[design.factor.b]
path = 'hammer.right.rail_position_m'
range = [-0.15, 0.15]
[design.factor.left_pressure]
path = 'hammer.left.supply_bar'
range = [3.0, 7.0]
[design.factor.right_pressure]
path = 'hammer.right.supply_bar'
range = [3.0, 7.0]
";

/// Choked flow through the larger feed in kg/s: `A p sqrt(kappa / (R T)) (2 / (kappa + 1))^3` for kappa = 1.4.
fn choked_flow(valve: &ValveParameters, supply_pa: f64) -> f64 {
    let area_m2 = valve.rear_feed_area_m2.max(valve.front_feed_area_m2);
    area_m2 * supply_pa * (1.4_f64 / (287.05 * 293.15)).sqrt() * (2.0_f64 / 2.4).powi(3)
}

#[test]
fn geometry_constraints_hold_in_every_row() {
    for kind in KINDS {
        // A Latin hypercube uses all of every range, a trajectory its ends: all of it must hit the casting.
        let (latin, morris) = (kind.contains("latin"), kind.contains("morris"));
        let factors = if latin || morris { SEPARATE.replace("0.15", "0.14") } else { SEPARATE.to_string() };
        let share = if morris { 2.75 } else { 2.2 };
        let most = share * choked_flow(&HammerParameters::default().valve, 6.01325e5);
        let constraints = format!(
            "constraints = ['distance(left, right) >= 0.08', 'strike_margin(left) >= 0', \
             'air_flow(left) + air_flow(right) <= {most}', 'mount_y(left) + mount_y(right) < 0.25']"
        );
        let study = study(&format!("[design]\n{kind}\n{constraints}\n{factors}"));
        let scenes = scenes(&study);
        assert!(scenes.len() >= 30, "{kind}");
        for (row, scene) in scenes.iter().enumerate() {
            let (left, right) = (along_rail(scene, 0), along_rail(scene, 1));
            assert!((left - right).abs() >= 0.08 && left + right < 0.25, "{kind}, row {row}: {left}, {right}");
            // Inside the casting, or the row would have been left out.
            assert!(
                scene.hammers.iter().all(|hammer| hammer.strike_point_m[1].abs() < 0.14 + 1e-9),
                "{kind}, row {row}"
            );
            let flow: f64 = scene.hammers.iter().map(|h| choked_flow(&h.parameters.valve, h.supply_pressure_pa)).sum();
            assert!(flow <= most * (1.0 + 1e-9), "{kind}, row {row}: {flow}");
        }
        // They bite: without them rows differ.
        let free = study_of(kind, &factors);
        assert!((0..free.row_count()).any(|row| free.row_values(row) != study.row_values(row)), "{kind}");
        if !latin {
            let acceptance = study.acceptance().expect("rejection");
            assert!(acceptance.rate() < 0.9 && acceptance.rate() > 0.01, "{kind}: {acceptance:?}");
        }
    }
}

fn study_of(kind: &str, factors: &str) -> CheckedStudy {
    study(&format!("[design]\n{kind}\n{factors}"))
}

#[test]
fn a_strike_stays_inside_the_casting_by_its_margin() {
    let design =
        format!("[design]\nkind = 'random'\nrows = 80\nconstraints = ['strike_margin(left) >= 0.05']\n{POSITIONS}");
    let study = study(&design);
    let positions: Vec<f64> = (0..80).map(|row| number(&study.row_values(row)[0])).collect();
    assert!(positions.iter().all(|position| position.abs() <= 0.09 + 1e-12));
    assert!(positions.iter().any(|position| position.abs() > 0.08));
}

#[test]
fn constraints_that_contradict_each_other_are_an_error_and_no_hang() {
    let begin = Instant::now();
    for kind in KINDS {
        let fault = message(constrained(&format!(
            "[design]\n{kind}\nconstraints = ['a > b', 'distance(left, right) > 0.05', 'b > a']\n{POSITIONS}"
        )));
        assert!(fault.contains("design.constraints") && fault.contains("test.toml:"), "{kind}: {fault}");
    }
    assert!(begin.elapsed() < Duration::from_secs(60), "{:?}", begin.elapsed());
    for (constraint, words) in [
        ("a + b", "expected a comparison"),
        ("a > c", "`c` is neither a factor"),
        ("distance(left, rght) > 0", "there is no hammer `rght`; there is: left, right"),
        ("clearance(left) > 0", "there is no function `clearance`"),
    ] {
        let design = format!("[design]\nkind = 'random'\nrows = 9\nconstraints = ['{constraint}']\n{POSITIONS}");
        let fault = message(constrained(&design));
        assert!(fault.contains(words) && fault.contains("design.constraints"), "{fault}");
    }
    let fault = message(parse(Path::new(""), "[design]\nconstraints = ['a >']"));
    assert!(fault.contains("design.constraints.0"), "{fault}");
}

#[test]
fn unions_and_products_have_their_parts() {
    let union = study(&format!(
        "[design]\nkind = 'union'\n[[design.part]]\nkind = 'box_behnken'\n[[design.part]]\nkind = 'latin_hypercube'\nrows = 20\n\
         {POSITIONS}"
    ));
    assert_eq!(union.row_count(), 13 + 20);
    assert_eq!(union.row_values(12).iter().map(number).collect::<Vec<_>>(), [0.0, 0.0, 5.0]);
    let product = study(&format!(
        "[design]\nkind = 'product'\n[[design.part]]\nkind = 'sobol'\nrows = 8\nfactors = ['a', 'pressure']\n[[design.part]]\n\
         kind = 'full_factorial'\nfactors = ['b']\n{}",
        POSITIONS.replace("[design.factor.pressure]", "levels = 3\n[design.factor.pressure]")
    ));
    assert_eq!(product.row_count(), 24);
    for row in 0..24 {
        let (values, first) = (product.row_values(row), product.row_values(row / 3 * 3));
        assert_eq!((&values[0], &values[2]), (&first[0], &first[2]));
        assert!((number(&values[1]) - [-0.2, 0.0, 0.2][row % 3]).abs() < 1e-15);
    }
    for (parts, words) in [
        ("", "needs parts"),
        ("[[design.part]]\nkind = 'sobol'\nrows = 4", "name the factors of this part"),
        ("[[design.part]]\nkind = 'sobol'\nrows = 4\nfactors = ['a', 'c']", "there is no drawn factor `c`"),
        ("[[design.part]]\nkind = 'sobol'\nrows = 4\nfactors = ['a']", "exactly one part"),
    ] {
        let fault = message(parse(Path::new(""), &format!("[design]\nkind = 'product'\n{parts}\n{POSITIONS}")));
        assert!(fault.contains(words), "{fault}");
    }
    let fault =
        message(parse(Path::new(""), &format!("[design]\nkind = 'sobol'\nrows = 4\ncentred = true\n{POSITIONS}")));
    assert!(fault.contains("design.centred") && fault.contains("belongs to other kinds"), "{fault}");
}

#[test]
fn named_factors_are_correlated() {
    let study = study(&format!(
        "[design]\nkind = 'latin_hypercube'\nrows = 400\n[design.correlation]\nfactors = ['a', 'pressure']\n\
         matrix = [[1.0, -0.7], [-0.7, 1.0]]\n{POSITIONS}"
    ));
    let column = |index: usize| (0..400).map(|row| number(&study.row_values(row)[index])).collect::<Vec<f64>>();
    let ranks = |values: &[f64]| -> Vec<f64> {
        values.iter().map(|x| values.iter().filter(|y| *y < x).count() as f64 - 199.5).collect()
    };
    let [a, b, pressure] = [0, 1, 2].map(|index| ranks(&column(index)));
    let correlation = |x: &[f64], y: &[f64]| {
        let product = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
        product(x, y) / (product(x, x) * product(y, y)).sqrt()
    };
    assert!((correlation(&a, &pressure) + 0.7).abs() < 0.03, "{}", correlation(&a, &pressure));
    assert!(correlation(&a, &b).abs() < 0.03, "{}", correlation(&a, &b));
}

fn decore(arguments: &[&str], study: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_decore")).args(arguments).arg(study).output().expect("decore runs")
}

#[test]
fn check_tells_the_quality_of_a_design_and_draws_it() {
    let folder = TempDir::new().expect("scratch folder");
    let file = folder.path().join("study.toml");
    let design = "[design]\nkind = 'sobol'\nrows = 32\nconstraints = ['distance(left, right) >= 0.1']";
    let mounts = "[design.factor.guide]\npath = 'solver.guide'\nvalues = ['spring', 'tied']";
    std::fs::write(&file, format!("duration_s = 0.01\n{MACHINE}\n{design}\n{POSITIONS}\n{mounts}")).expect("written");
    // Windows has no such names.
    let picture = folder.path().join(if cfg!(windows) { "design 1.svg" } else { "design <1>.svg" });
    let output = decore(&["check", "--scatter", picture.to_str().expect("a path")], &file);
    let text = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    for word in
        ["acceptance", "smallest", "phi_20", "centred", "wrap-around", "correlation", "distance(left, right) >= 0.1"]
    {
        assert!(text.contains(word), "{word}: {text}");
    }
    let svg = std::fs::read_to_string(&picture).expect("a picture");
    // A panel per pair of factors, a point per row in those off the diagonal.
    assert_eq!(svg.matches("fill=\"none\" stroke=\"#969696\"").count(), 16);
    assert_eq!(svg.matches("<circle").count(), 12 * 32);
    let impossible = std::fs::read_to_string(&file).expect("study").replace(">= 0.1", ">= 3.0");
    std::fs::write(&file, impossible).expect("written");
    let output = decore(&["check"], &file);
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("design.constraints") && text.contains("0 of"), "{text}");
}

#[test]
fn a_dataset_knows_the_quality_of_its_design() {
    let folder = TempDir::new().expect("scratch folder");
    let file = folder.path().join("study.toml");
    let design = "[design]\nkind = 'random'\nrows = 40\nconstraints = ['a < b']";
    std::fs::write(&file, format!("{MACHINE}\n{design}\n{POSITIONS}")).expect("written");
    let out = folder.path().join("out");
    let output = decore(&["run", "--stub-row-ms", "0", "--output", out.to_str().expect("a path")], &file);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let manifest = std::fs::read_to_string(out.join("manifest.json")).expect("a manifest");
    let manifest: serde_json::Value = serde_json::from_str(&manifest).expect("JSON");
    let quality = &manifest["study"]["design_quality"];
    let number = |key: &str| quality[key].as_f64().unwrap_or_else(|| panic!("{key}: {quality}"));
    let study = rows_of(&Study::load(&file).expect("a study"));
    let measured = decore_statistics::design::Quality::of(study.design()).expect("factors");
    assert!((number("minimum_distance") / measured.minimum_distance - 1.0).abs() < 1e-8);
    assert!((number("centred_discrepancy") / measured.centred_discrepancy - 1.0).abs() < 1e-8);
    assert!((number("wrap_around_discrepancy") / measured.wrap_around_discrepancy - 1.0).abs() < 1e-8);
    assert!((number("maximum_correlation") / measured.maximum_correlation - 1.0).abs() < 1e-8);
    assert!(number("phi_p") > 0.0 && number("points_accepted") == 40.0 && number("points_tried") > 50.0);
}

/// Factors of every kind, among them a derived one.
const WRITTEN: &str = "
[design.factor.position]
path = 'hammer.left.rail_position_m'
range = [-0.1, 0.1]
unit = 'm'
[design.factor.twice]
expression = '2 * position'
[design.factor.guide]
path = 'solver.guide'
values = ['spring', 'tied']
[design.factor.steps]
path = 'solver.max_steps'
range = [1000, 2000000]
integer = true
scale = 'log'
";

#[test]
fn a_written_design_is_read_back() {
    let folder = TempDir::new().expect("scratch folder");
    let file = folder.path().join("study.toml");
    let design = "[design]\nkind = 'latin_hypercube'\nrows = 30\nconstraints = ['position > -0.2']";
    std::fs::write(&file, format!("{MACHINE}\n{design}\n{WRITTEN}")).expect("written");
    let first = rows_of(&Study::load(&file).expect("a study"));
    // What the file tells need not be said again; whole numbers must be asked for.
    let spared = WRITTEN.replace("range = [-0.1, 0.1]\n", "").replace("range = [1000, 2000000]\n", "");
    let spared = spared.replace("values = ['spring', 'tied']\n", "");
    for name in ["design.parquet", "design.csv", "design.PARQUET"] {
        let path = folder.path().join(name);
        let output = decore(&["design", "--output", path.to_str().expect("a path")], &file);
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        for factors in [WRITTEN, &spared] {
            let study = parse(folder.path(), &format!("[design]\nkind = 'table'\nfile = '{name}'\n{factors}"))
                .unwrap_or_else(|error| panic!("{name}: {error}"));
            let study = rows_of(&study);
            assert_eq!(study.row_count(), 30);
            for row in 0..30 {
                assert_eq!(study.row_values(row), first.row_values(row), "{name}, row {row}");
            }
        }
        let study = parse(folder.path(), &format!("[design]\nkind = 'table'\nfile = '{name}'\n{spared}")).unwrap();
        let column = |index: usize| (0..30).map(|row| number(&first.row_values(row)[index])).collect::<Vec<f64>>();
        let ends = |values: &[f64]| values.iter().fold([f64::MAX, f64::MIN], |[a, b], x| [a.min(*x), b.max(*x)]);
        let [low, high] = ends(&column(0));
        assert_eq!(study.factors()[0].domain(), format!("{low} to {high}"));
        let [low, high] = ends(&column(3));
        assert_eq!(study.factors()[3].domain(), format!("{low} to {high} (whole numbers, logarithmic)"));
        assert!(["spring | tied", "tied | spring"].contains(&study.factors()[2].domain().as_str()));
    }
    let output = decore(&["design", "--output", "design.txt"], &file);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("ends in `.parquet` or `.csv`"));
    // A column of one value is that value; a range may stand beside a column.
    std::fs::write(folder.path().join("one.csv"), "position,steps,guide\n0.05,1000,tied\n0.05,1000,tied\n").unwrap();
    let one = parse(folder.path(), &format!("[design]\nkind = 'table'\nfile = 'one.csv'\n{spared}")).unwrap();
    assert_eq!(rows_of(&one).row_values(1)[3], Value::Integer(1000));
    let fault = message(parse(folder.path(), &format!("[design]\nkind = 'table'\nfile = 'none.csv'\n{spared}")));
    assert!(fault.contains("cannot read") && fault.contains("design.factor.position"), "{fault}");
}

/// The example of a user: the antimonotone pairing meets it, and little else.
#[test]
fn a_tight_constraint_of_a_hypercube_is_met_for_every_seed() {
    for seed in 0..16 {
        let study = study(&format!(
            "[design]\nkind = 'latin_hypercube'\nrows = 200\nseed = {seed}\n\
             constraints = ['pressure <= 6 - 150 * (standoff - 0.08)']\n\
             [design.factor.pressure]\npath = 'hammer.left.supply_bar'\nrange = [4.0, 6.0]\n\
             [design.factor.standoff]\npath = 'hammer.left.standoff_m'\nrange = [0.08, 0.09]\n\
             [design.factor.start]\npath = 'hammer.right.start_time_s'\nrange = [0.0, 0.01]\n"
        ));
        for row in 0..200 {
            let values = study.row_values(row);
            assert!(number(&values[0]) <= 6.0 - 150.0 * (number(&values[1]) - 0.08) + 1e-12, "{seed}: {values:?}");
        }
    }
    let fault = message(constrained(
        "[design]\nkind = 'latin_hypercube'\nrows = 50\nconstraints = ['hammer.left.supply_bar + twice < 11.5']\n\
         [design.factor.pressure]\npath = 'hammer.left.supply_bar'\nrange = [4.0, 6.0]\n\
         [design.factor.standoff]\npath = 'hammer.left.standoff_m'\nrange = [0.06, 0.08]\n\
         [design.factor.twice]\nexpression = '100 * standoff - 0.2'\n",
    ));
    assert!(fault.contains("cannot be met") && fault.contains("design.constraints"), "{fault}");
}

#[test]
fn check_tells_what_a_fraction_confuses() {
    let folder = TempDir::new().expect("scratch folder");
    let file = folder.path().join("study.toml");
    let factor = |(name, path): (&str, &str)| format!("[design.factor.{name}]\npath = '{path}'\nrange = [0.06, 0.1]\n");
    let factors = [
        ("a", "hammer.left.standoff_m"),
        ("b", "hammer.right.standoff_m"),
        ("c", "hammer.left.rail_position_m"),
        ("d", "hammer.right.rail_position_m"),
        ("e", "casting.part.centre_m.0"),
    ]
    .map(factor)
    .concat();
    let machine =
        MACHINE.replace("[hammer.right]", "strike_point_m = [0.0, 0.0]\n[hammer.right]\nstrike_point_m = [0.0, 0.0]");
    let design = "[design]\nkind = 'fractional_factorial'\nresolution = 5";
    std::fs::write(&file, format!("duration_s = 0.01\n{machine}\n{design}\n{factors}")).expect("written");
    let text = |arguments: &[&str]| {
        let output = decore(arguments, &file);
        // The design is looked at: no row of this machine can be simulated, hence exit code 4.
        assert!(matches!(output.status.code(), Some(0 | 4)), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let five = text(&["check"]);
    for line in
        ["generator    e = a*b*c*d", "words        1 of length 5: resolution 5", "no effects of one or two factors"]
    {
        assert!(five.contains(line), "{line}: {five}");
    }
    let three = text(&["check", "--set", "design.resolution=3"]);
    assert!(three.contains("words        2 of length 3, 1 of length 4: resolution 3"), "{three}");
    assert!(three.contains("aliased      a = "), "{three}");
}

/// A factor over machines: every row runs on its own, and what names no machine is found before any row.
#[test]
fn a_factor_chooses_the_machine() {
    let scratch = TempDir::new().unwrap();
    let text = "duration_s = 0.02\nmachine = \"few\"\n[structure]\ncutoff_hz = 300\n[structures.few]\ncutoff_hz = 60\n\
        [hammer.a]\nmount = \"R5\"\nstrike_point_m = [0.0, 0.0]\n[casting.c]\nmass_kg = 0.5\n[casting.c.fixture.f]\npoint = \"T5\"\nstiffness_n_per_m = 3e7\n\
        [design]\nkind = \"full_factorial\"\n[design.factor.machine]\npath = \"machine\"\nvalues = [\"structure\", \"few\"]\n";
    let write = |text: &str| {
        let path = scratch.path().join("study.toml");
        std::fs::write(&path, text).unwrap();
        path
    };
    let run = |path: &Path| {
        let folder = scratch.path().join("out");
        let output = Command::new(env!("CARGO_BIN_EXE_decore"))
            .args(["run", "--replace", "--output"])
            .arg(&folder)
            .arg(path)
            .output()
            .unwrap();
        (output, folder)
    };
    let (output, folder) = run(&write(text));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut modes = Vec::new();
    let reader = decore_dataset::DatasetReader::open(&folder).unwrap();
    let table = decore_dataset::TableName::Runs;
    reader.visit(table, &["factor_machine", "modes"], |cells| modes.push(format!("{cells:?}"))).unwrap();
    assert!(modes[0].contains("structure") && modes[0].contains("19"), "{modes:?}");
    assert!(modes[1].contains("few") && modes[1].contains("10"), "{modes:?}");
    for (from, to, word) in [
        ("\"structure\", \"few\"]", "\"structure\", \"fews\"]", "did you mean `few`"),
        (
            "[structures.few]\n",
            "[structures.few]\nrails.r = [\"R1\", \"R2\"]\n",
            "rails belong to the table [structure]",
        ),
        ("path = \"machine\"", "path = \"structures.few.cutoff_hz\"", "structures"),
    ] {
        let (output, _) = run(&write(&text.replace(from, to)));
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{stderr}");
        assert!(stderr.contains(word), "no `{word}` in {stderr}");
    }
}

//! `decore cores`: tests of cores that were drawn from a known law give that law back, and times by the doses of the dataset.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use decore_dataset::{DatasetReader, TableName};
use decore_math::random::uniform;
use decore_math::special::normal_quantile;
use decore_quantity::Value;
use serde_json::Value as Json;
use tempfile::TempDir;

/// Four supply pressures at one hammer on a casting with two core points.
const STUDY: &str = "duration_s = 0.3\ngeometry = \"as_given\"\n[structure]\ncutoff_hz = 300.0\n[hammer.left]\nmount = \"R5\"\n\
    [casting.part]\nmass_kg = 3.0\ninertia_kg_m2 = [0.01, 0.02]\n[casting.part.core.near]\nat_m = [0.0, 0.0, 0.0]\n\
    [casting.part.core.far]\nat_m = [0.08, 0.02, 0.0]\n[casting.part.fixture.a]\npoint = \"T5\"\nat_m = [-0.08, 0.0]\n\
    [casting.part.fixture.b]\npoint = \"T5\"\nat_m = [0.06, 0.03]\n[casting.part.fixture.c]\npoint = \"T5\"\nat_m = [0.06, -0.02]\n\
    [outputs]\ncore_spectra = true\ncore_dose_reference_m_s = 1.0\ncore_wanted_dose = 1e7\n\
    [design]\nkind = \"full_factorial\"\n[design.factor.pressure]\npath = \"hammer.left.supply_bar\"\nvalues = [4.0, 4.5, 5.0, 5.5]\n";
/// Median of the true law, and its standard deviation of logarithms.
const TRUE: [f64; 2] = [2e7, 0.5];
/// Length of a test in which the core stays in, as a multiple of the median time.
const TESTED: f64 = 1.4;

struct Cores {
    scratch: TempDir,
}

impl Cores {
    fn new(study: &str) -> Self {
        let scratch = TempDir::new().unwrap();
        fs::write(scratch.path().join("study.toml"), study).unwrap();
        let cores = Self { scratch };
        let output = cores.decore(&["run", "study.toml", "--output", "rows"]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        cores
    }

    fn decore(&self, arguments: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_decore")).args(arguments).current_dir(self.scratch.path()).output().unwrap()
    }

    fn path(&self, name: &str) -> PathBuf {
        self.scratch.path().join(name)
    }

    fn found(&self, tests: &str, more: &[&str]) -> Json {
        fs::write(self.path("tests.csv"), tests).unwrap();
        let output = self.decore(&[&["cores", "rows", "--tests", "tests.csv", "--json"], more].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    }

    fn refused(&self, tests: &str) -> String {
        fs::write(self.path("tests.csv"), tests).unwrap();
        let output = self.decore(&["cores", "rows", "--tests", "tests.csv"]);
        assert_eq!(output.status.code(), Some(2));
        String::from_utf8_lossy(&output.stderr).into_owned()
    }

    /// Dose at the end of the run and its growth per second of a core point, row by row.
    fn courses(&self, core: &str) -> Vec<[f64; 2]> {
        let reader = DatasetReader::open(&self.path("rows")).unwrap();
        let names =
            ["dose_98hz_10khz", "dose_rate_98hz_10khz_per_s"].map(|quantity| format!("part_core_{core}_{quantity}"));
        let mut found = Vec::new();
        let names = names.each_ref().map(String::as_str);
        reader
            .visit(TableName::Runs, &names, |cells| {
                let [Some(Value::Real(dose)), Some(Value::Real(rate_per_s))] = cells else { panic!("{cells:?}") };
                found.push([*dose, *rate_per_s]);
            })
            .unwrap();
        found
    }
}

fn number(json: &Json) -> f64 {
    json.as_f64().unwrap_or_else(|| panic!("{json}"))
}

/// Twelve cores with doses of a known law, of which some are still in at the end of their tests: the intervals hold the law's median; times
/// are where the doses of the dataset's rows reach it.
#[test]
fn tests_give_the_law_they_were_drawn_from() {
    let cores = Cores::new(STUDY);
    let courses = ["near", "far"].map(|core| cores.courses(core));
    let [median, scatter] = TRUE;
    let mut text = "row,core,core_out_after_s,test_ended_after_s\n".to_owned();
    let mut by_factor = "pressure;core;core_out_after_s;test_ended_after_s\n".to_owned();
    let mut still_in = 0;
    for test in 0..12_u64 {
        let (row, core) = ((test % 4) as usize, (test % 2) as usize);
        let [dose, rate] = courses[core][row];
        let time_s = |wanted: f64| 0.3 + (wanted - dose) / rate;
        let drawn = median * (scatter * normal_quantile(uniform(3, 0, test))).exp();
        let (out, end) = (time_s(drawn), time_s(TESTED * median));
        let cells = if out < end { format!("{out:.6}") } else { String::new() };
        still_in += u64::from(out >= end);
        let name = ["near", "part.far"][core];
        text += &format!("{row},{name},{cells},{end:.6}\n");
        by_factor += &format!("{};{name};{cells};{end:.6}\n", [4.0, 4.5, 5.0, 5.5][row]);
    }
    assert!(still_in > 1, "some cores stay in");
    for law in ["lognormal", "weibull"] {
        let found = cores.found(&text, &["--law", law, "--output", "times.parquet", "--replace"]);
        let dose = &found["doses"][1]["dose"];
        let [low, value, high] = ["low", "value", "high"].map(|end| number(&dose[end]));
        assert!(low < median && median < high && low > 0.3 * value && high < 3.0 * value, "{law}: {dose}");
        assert_eq!((&found["still_in"], &found["rows_done"]), (&still_in.into(), &4.into()));
        // The slowest core of the best row, by hand.
        let best = &found["rows"][0];
        let row = best["row"].as_u64().unwrap() as usize;
        let slowest = |end: &str| {
            let wanted = number(&found["next_core"][end]);
            courses.iter().map(|course| 0.3 + (wanted - course[row][0]) / course[row][1]).fold(0.0, f64::max)
        };
        for end in ["low", "value", "high"] {
            let time_s = number(&best["core_out_after_s"][end]);
            assert!((time_s / slowest(end) - 1.0).abs() < 1e-9, "{time_s} {}", slowest(end));
        }
    }
    let columns = decore_study::column_names(&cores.path("times.parquet"), "row").unwrap();
    assert!(columns.contains(&"core_out_after_high_s".to_owned()), "{columns:?}");
    let [by_row, by_factor] = [text.as_str(), &by_factor].map(|tests| cores.found(tests, &[]));
    assert_eq!(by_row, by_factor, "the values of factors name the rows");
    mistakes(&cores, &text);
}

/// What is wrong with a table of tests is named with its line and column.
fn mistakes(cores: &Cores, text: &str) {
    let head = "row,core,core_out_after_s,test_ended_after_s\n";
    for (tests, expected) in [
        (format!("{head}9,near,5,\n"), "line 2, column `row`: the dataset has no row 9 that is done"),
        (format!("{head}0,nearr,5,\n"), "did you mean `near`?"),
        (format!("{head}0,,5,\n"), "expected the core that was tested, one of part.near, part.far"),
        (format!("{head}0,near,,\n"), "column `core_out_after_s`: expected a time in s"),
        (format!("{head}0,near,1e-4,\n"), "has no dose yet after 0.0001 s"),
        (format!("{head}0,near,5,\n0,far,,9\n"), "tests.csv: 1 of 2 tests ended with a failure, expected at least 2"),
        ("core,core_out_after_s\nnear,5\n".to_owned(), "has no column `row` and none of the factors (pressure)"),
        (
            "pressure,core,core_out_after_s\n4.7,near,5\n".to_owned(),
            "no row of the dataset has these values of pressure",
        ),
        (text.replacen("core_out_after_s", "core_out_s", 1), "has no column `core_out_after_s`"),
    ] {
        let found = cores.refused(&tests);
        assert!(found.contains(expected), "{expected}\n{found}");
    }
}

/// Without doses there is nothing to compare tests with. The growth of the dose does not depend on a wanted dose.
#[test]
fn datasets_need_doses() {
    let without = STUDY.replace("core_dose_reference_m_s = 1.0\ncore_wanted_dose = 1e7\n", "");
    let text = "row,core,core_out_after_s\n0,near,5\n1,near,7\n2,far,9\n";
    assert!(Cores::new(&without).refused(text).contains("the dataset has no doses of core points"));
    let found = |study: &str| Cores::new(study).found(text, &[]);
    assert_eq!(found(&STUDY.replace("core_wanted_dose = 1e7\n", "")), found(STUDY));
    let driven = "[design.factor.reference]\npath = \"outputs.core_dose_reference_m_s\"\nvalues = [1.0, 2.0]\n";
    let driven = Cores::new(&format!("{STUDY}{driven}")).refused(text);
    assert!(driven.contains("factor `reference` drives `outputs.core_dose_reference_m_s`"), "{driven}");
}

/// The table for predictors has the figures of core points, and groups by sand and binder, which a factor can choose.
#[test]
fn features_of_cores() {
    let binder = "[design.factor.binder]\npath = \"casting.part.sand_binder\"\nvalues = [\"cold box\", \"furan\"]\n";
    let stated = STUDY.replace("mass_kg = 3.0", "mass_kg = 3.0\nsand_binder = \"shell\"");
    let cores = Cores::new(&format!("{stated}{binder}"));
    let export = |folder: &str, more: &[&str]| {
        let output = cores.decore(&[&["export", "rows", "--features", folder, "--format", "csv"], more].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let path = cores.path(folder).join("features.csv");
        let read = |name: &str| {
            let rows = decore_study::column_rows(&path, &[name]).unwrap_or_else(|error| panic!("{error}"));
            rows.into_iter().map(|row| row.cells[0].clone()).collect::<Vec<_>>()
        };
        let names =
            ["sand_binder", "group_sand_binder", "group_id", "core_far_dose_98hz_10khz", "core_near_dose_98hz_10khz"];
        (names.map(read), read("least_core_dose_98hz_10khz"))
    };
    let ([binders, numbers, ids, far, near], least) = export("features", &[]);
    assert_eq!(binders.len(), 8);
    let number = |text: &String| text.parse::<f64>().unwrap();
    for row in 0..8 {
        let other = (0..8).find(|other| binders[*other] != binders[row]).unwrap();
        assert!(["cold box", "furan"].contains(&binders[row].as_str()) && numbers[row] != numbers[other]);
        assert_eq!(number(&least[row]), number(&far[row]).min(number(&near[row])));
    }
    let courses = ["far", "near"].map(|core| cores.courses(core).into_iter().map(|[dose, _]| dose).collect::<Vec<_>>());
    assert_eq!([far, near].map(|doses| doses.iter().map(number).collect::<Vec<_>>()), courses);
    assert!(ids.iter().any(|id| *id != numbers[0]), "binders bind rows only on request: {ids:?}");
    let ([_, numbers, ids, ..], _) = export("bound", &["--group-by", "sand_binder"]);
    assert_eq!(ids, numbers);
    // A binder changes no row.
    let doses =
        |binder: &str| (0..8).filter(|row| binders[*row] == binder).map(|row| courses[0][row]).collect::<Vec<_>>();
    assert_eq!(doses("cold box"), doses("furan"));
    let fixed = Cores::new(&stated);
    let output = fixed.decore(&["export", "rows", "--features", "f", "--format", "csv"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let rows = decore_study::column_rows(&fixed.path("f/features.csv"), &["sand_binder"]).unwrap();
    assert!(rows.len() == 4 && rows.iter().all(|row| row.cells == ["shell"]), "{rows:?}");
}

/// The page of a row marks when its pads are lifted off: together as long as the outputs say.
#[test]
fn pages_mark_lift_offs() {
    let pad = |name: &str, [x, y]: [f64; 2]| {
        format!(
            "[casting.part.fixture.{name}]\npoint = \"T5\"\nat_m = [{x}, {y}]\none_sided = true\nmaterial = \"steel\"\npad_area_m2 = 3e-4\npad_thickness_m = 0.02\n"
        )
    };
    let pads = [("a", [-0.08, -0.04]), ("b", [0.08, -0.04]), ("c", [-0.08, 0.04]), ("d", [0.08, 0.04])];
    let pads: String = pads.into_iter().map(|(name, at)| pad(name, at)).collect();
    let study = format!(
        "duration_s = 0.3\ngeometry = \"as_given\"\n[structure]\ncutoff_hz = 300.0\n[hammer.left]\nmount = \"R5\"\n[casting.part]\n\
         mass_kg = 12.0\ninertia_kg_m2 = [0.02, 0.05]\n{pads}[casting.part.fixture.clamp]\npoint = \"T5\"\nat_m = [0.0, 0.0]\nclamp_force_n = 1500.0\n"
    );
    let scratch = TempDir::new().unwrap();
    fs::write(scratch.path().join("study.toml"), study).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_decore"));
    let output =
        command.args(["scene", "study.toml", "--html", "row.html"]).current_dir(scratch.path()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let page = fs::read_to_string(scratch.path().join("row.html")).unwrap();
    let meta = page.split_once("id=\"meta\">").and_then(|(_, rest)| rest.split_once("</script>")).unwrap().0;
    let meta: Json = serde_json::from_str(meta).unwrap();
    let outputs = meta["outputs"].as_array().unwrap();
    let lifted = meta["lifted"].as_array().unwrap();
    assert_eq!(lifted.len(), 4, "the clamp is no pad");
    for (pad, name) in lifted.iter().zip(["a", "b", "c", "d"]) {
        let output = |quantity: &str| {
            let of = format!("fixture {name} of casting part");
            let found =
                outputs.iter().find(|output| output["of"] == of.as_str() && output["name"] == quantity).unwrap();
            found["value"].as_str().unwrap().parse::<f64>().unwrap()
        };
        let spans = pad["spans_s"].as_array().unwrap();
        let (count, interval_s) = (output("lift_off_count"), number(&meta["interval_s"]));
        assert!(count > 0.0 && spans.len() as f64 <= count && !spans.is_empty(), "{count} {spans:?}");
        let long: f64 = spans.iter().map(|span| number(&span[1]) - number(&span[0])).sum();
        let expected = 0.3 * output("lifted_off_share");
        assert!((long - expected).abs() <= 2.0 * interval_s * count, "{long} {expected}");
    }
}

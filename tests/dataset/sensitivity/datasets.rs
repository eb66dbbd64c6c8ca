//! Indices of datasets: by the command, from rows that are made up, some of which fail.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use decore_math::random::uniform;
use serde_json::Value;
use tempfile::TempDir;

use crate::growth::{FACTORS, MACHINE};
use crate::sweeps::decore;

/// A dataset of made-up rows: row 613 diverges.
struct Dataset {
    scratch: TempDir,
}

impl Dataset {
    fn of(design: &str) -> Self {
        let dataset = Self { scratch: TempDir::new().expect("scratch folder") };
        dataset.run(design, &["--stub-row-ms", "0"]);
        dataset
    }

    fn folder(&self) -> PathBuf {
        self.scratch.path().join("out")
    }

    fn run(&self, design: &str, arguments: &[&str]) {
        let study = self.scratch.path().join("study.toml");
        fs::write(&study, format!("{MACHINE}\n[design]\n{design}\n{FACTORS}")).expect("study");
        let output = decore().arg("run").arg(study).arg("--output").arg(self.folder()).args(arguments).output();
        let output = output.expect("runs");
        assert!(matches!(output.status.code(), Some(0 | 4)), "{}", text(&output.stderr));
    }

    fn analyse(&self, arguments: &[&str]) -> Output {
        decore().arg("analyse").arg(self.folder()).args(arguments).output().expect("runs")
    }

    fn json(&self, arguments: &[&str]) -> Value {
        let output = self.analyse(&[arguments, &["--json"]].concat());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        serde_json::from_slice(&output.stdout).expect("JSON")
    }
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn failed_rows_are_named_and_their_blocks_left_out() {
    // Blocks of five rows: 613 is the fourth row of block 122.
    let dataset = Dataset::of("kind = \"saltelli\"\nbase_points = 128");
    let found = dataset.json(&["--output", "delivered_work_j", "--bootstrap", "20"]);
    let used = &found["outputs"][0]["used"];
    assert_eq!(
        (used["unit"].as_str(), used["whole"].as_u64(), used["of"].as_u64()),
        (Some("blocks"), Some(127), Some(128))
    );
    assert_eq!((used["left_out"][0]["count"].as_u64(), used["left_out"][0]["rows"][0].as_u64()), (Some(1), Some(613)));
    assert!(used["left_out"][0]["reason"].as_str().expect("a text").starts_with("diverged: "));
    assert!(found["outputs"][0]["indices"].as_array().expect("a list").iter().all(|index| index["value"].is_number()));
    let shown = text(&dataset.analyse(&["--output", "delivered_work_j", "--bootstrap", "0"]).stdout);
    for expected in [
        "FROM 127 OF 128 blocks: 1 are incomplete and left out",
        "1 row (613): diverged: ",
        "the failed rows are not a random sample",
        "estimator salib",
    ] {
        assert!(shown.contains(expected), "{expected} in\n{shown}");
    }
}

#[test]
fn intervals_of_few_units_are_told() {
    let said = |design: &str| {
        let shown = text(&Dataset::of(design).analyse(&["--output", "delivered_work_j", "--bootstrap", "20"]).stdout);
        shown.contains("intervals from fewer than 20 ")
    };
    assert!(said("kind = \"morris\"\ntrajectories = 19") && said("kind = \"saltelli\"\nbase_points = 16"));
    assert!(!said("kind = \"morris\"\ntrajectories = 20") && !said("kind = \"saltelli\"\nbase_points = 32"));
}

#[test]
fn rows_that_are_not_run_yet_and_constant_outputs_are_said() {
    let dataset = Dataset::of("kind = \"saltelli\"\nbase_points = 128\nsecond_order = true");
    let names = ["left_contact_count", "left_hit_frequency_hz", "left_arm_rms_steady_m_s"];
    let found = dataset.json(&[&["--bootstrap", "0", "--output"][..], &names].concat());
    let refused = |output: usize| found["outputs"][output]["refused"].as_str().unwrap_or_default().to_owned();
    assert!(refused(0).contains("constant (30)"), "{}", refused(0));
    assert!(refused(1).is_empty());
    assert!(refused(2).contains("0 blocks are too few"), "{}", refused(2));
    let left_out = &found["outputs"][2]["used"]["left_out"];
    assert!(left_out.to_string().contains("done, but without this output"), "{left_out}");
    let pairs = found["outputs"][1]["indices"].as_array().expect("a list").iter();
    assert_eq!(pairs.filter(|index| index["index"] == "s2").count(), 3);

    // Rows that are to come failed by no factor.
    let begun = Dataset { scratch: TempDir::new().expect("scratch folder") };
    begun.run("kind = \"saltelli\"\nbase_points = 64", &["--stub-row-ms", "0", "--shard", "1/2"]);
    let shown = text(&begun.analyse(&["--output", "delivered_work_j", "--bootstrap", "0"]).stdout);
    assert!(shown.contains("rows: not run yet") && !shown.contains("no sample of all"), "{shown}");
}

#[test]
fn bytes_depend_on_the_seed_and_on_no_number_of_threads() {
    for design in ["kind = \"saltelli\"\nbase_points = 32", "kind = \"halton\"\nrows = 200"] {
        let dataset = Dataset::of(design);
        let bytes = |threads: &str, seed: &str| {
            let mut command = decore();
            command.env("RAYON_NUM_THREADS", threads).arg("analyse").arg(dataset.folder());
            command.args(["--json", "--bootstrap", "200", "--seed", seed]).output().expect("runs").stdout
        };
        for seed in ["0", "1"] {
            assert_eq!(text(&bytes("1", seed)), text(&bytes("3", seed)), "{design}, seed {seed}");
        }
        assert_ne!(bytes("1", "0"), bytes("1", "1"), "{design}");
    }
}

#[test]
fn names_have_only_the_size_of_their_effects() {
    let dataset = Dataset::of("kind = \"morris\"\ntrajectories = 20");
    let found = dataset.json(&["--output", "delivered_work_j", "--bootstrap", "50"]);
    assert_eq!(
        (names(&found, "pressure"), names(&found, "guide")),
        (vec!["mu_star".into(), "mu".into(), "sigma".into()], vec!["mu_star".into()])
    );
    assert!(found["notes"].to_string().contains("`guide`"), "{}", found["notes"]);
}

/// Names of the indices of a factor, in order.
fn names(found: &Value, factor: &str) -> Vec<String> {
    let indices = found["outputs"][0]["indices"].as_array().expect("a list").iter();
    let alone = |index: &&Value| index["factors"].as_array().is_some_and(|of| of.len() == 1 && of[0] == factor);
    indices.filter(alone).map(|index| index["index"].as_str().expect("a name").to_owned()).collect()
}

const OF_ANY_ROWS: [&str; 7] =
    ["shapley", "rank", "correlation_ratio", "pawn", "pawn_maximum", "hsic_r2", "hsic_p_value"];

#[test]
fn dependent_factors_have_shapley_effects_and_no_sobol_indices() {
    let constrained = "kind = \"random\"\nrows = 128\nconstraints = [\"pressure <= 5.9 - abs(position)\"]";
    let correlated = "kind = \"latin_hypercube\"\nrows = 128\n[design.correlation]\nfactors = [\"position\", \"pressure\"]\n\
                      matrix = [[1.0, 0.8], [0.8, 1.0]]";
    for (design, why) in
        [(constrained, "pressure <= 5.9 - abs(position)"), (correlated, "correlates position, pressure")]
    {
        let found = Dataset::of(design).json(&["--output", "delivered_work_j", "--bootstrap", "20"]);
        assert_eq!(found["method"]["name"], "given");
        let note = found["notes"].to_string();
        assert!(note.contains(why) && note.contains("Shapley effects do it here"), "{note}");
        assert_eq!(found["outputs"][0]["used"]["whole"], 128);
        for factor in ["position", "pressure", "guide"] {
            assert_eq!(names(&found, factor), OF_ANY_ROWS, "{factor}");
        }
        let shares = found["outputs"][0]["indices"].as_array().expect("a list").iter();
        let shares = shares.filter(|index| index["index"] == "shapley").filter_map(|index| index["value"].as_f64());
        assert!((shares.sum::<f64>() - 1.0).abs() < 1e-12);
    }
}

/// Estimators that compare neighbours take rows for independent draws; where they are none, there is no figure and a reason.
#[test]
fn rows_that_are_laid_out_evenly_have_no_indices_by_neighbours() {
    let even =
        ["kind = \"sobol\"\nrows = 200", "kind = \"halton\"\nrows = 200", "kind = \"saltelli\"\nbase_points = 64"];
    for design in even {
        let dataset = Dataset::of(design);
        let given: &[&str] = if design.contains("saltelli") { &["--given"] } else { &[] };
        let arguments = [&["--output", "delivered_work_j", "--bootstrap", "20"], given].concat();
        let found = dataset.json(&arguments);
        let note = found["notes"].to_string();
        assert!(note.contains("S1 by ranks and Shapley effects are not computed"), "{design}: {note}");
        if found["outputs"][0]["refused"].is_null() {
            assert_eq!(names(&found, "pressure"), OF_ANY_ROWS[2..], "{design}");
        }
        let shown = text(&dataset.analyse(&arguments).stdout);
        assert!(shown.contains("are not computed: they need independent draws"), "{design}: {shown}");
    }
    for (optimise, noted) in [("maximin", true), ("none", false)] {
        let design = format!("kind = \"latin_hypercube\"\nrows = 60\noptimise = \"{optimise}\"");
        let found = Dataset::of(&design).json(&["--output", "delivered_work_j", "--bootstrap", "20"]);
        assert_eq!(names(&found, "pressure"), OF_ANY_ROWS, "{optimise}");
        assert_eq!(found["notes"].to_string().contains("more even than independent draws"), noted, "{optimise}");
    }
}

/// Rows of a file, each of which is there twice.
#[test]
fn rows_at_one_place_count_once() {
    let dataset = Dataset { scratch: TempDir::new().expect("scratch folder") };
    let row = |row: u64| {
        let [position, pressure] = [0, 1].map(|factor| uniform(9, factor, row / 2));
        let guide = if uniform(9, 2, row / 2) < 0.5 { "spring" } else { "tied" };
        format!("{},{},{guide}\n", 0.2 * position - 0.1, 4.0 + 2.0 * pressure)
    };
    let rows: String = (0..120).map(row).collect();
    fs::write(dataset.scratch.path().join("rows.csv"), format!("position,pressure,guide\n{rows}")).expect("written");
    dataset.run("kind = \"table\"\nfile = \"rows.csv\"", &["--stub-row-ms", "0"]);
    let found = dataset.json(&["--output", "delivered_work_j", "--bootstrap", "0"]);
    let note = found["notes"].to_string();
    assert!(note.contains("Rows at the place of another one in all factors: 60."), "{note}");
    assert_eq!(names(&found, "guide"), OF_ANY_ROWS, "drawn rows: {note}");
}

#[test]
fn a_few_replicates_are_no_intervals() {
    let dataset = Dataset::of("kind = \"random\"\nrows = 40");
    for (replicates, code) in [("1", 2), ("19", 2), ("0", 0), ("20", 0)] {
        assert_eq!(dataset.analyse(&["--bootstrap", replicates]).status.code(), Some(code), "{replicates}");
    }
}

#[test]
fn rows_by_themselves_are_left_out_alone() {
    // Row 613 diverges.
    let dataset = Dataset::of("kind = \"latin_hypercube\"\nrows = 640");
    let found = dataset.json(&["--output", "delivered_work_j", "--bootstrap", "0"]);
    let used = &found["outputs"][0]["used"];
    assert_eq!((used["whole"].as_u64(), used["of"].as_u64()), (Some(639), Some(640)));
    assert_eq!(found["notes"].as_array().map(Vec::len), Some(0), "independent: {}", found["notes"]);
    // Made-up outputs depend on no factor.
    let indices = found["outputs"][0]["indices"].as_array().expect("a list");
    let ranks = indices.iter().filter(|index| index["index"] == "rank").filter_map(|index| index["value"].as_f64());
    let ranks: Vec<f64> = ranks.collect();
    assert!(ranks.len() == 3 && ranks.iter().all(|rank| rank.abs() < 0.15), "{ranks:?}");
}

#[test]
fn a_saltelli_design_may_be_analysed_as_any_rows_and_morris_not() {
    let dataset = Dataset::of("kind = \"saltelli\"\nbase_points = 64");
    let found = dataset.json(&["--given", "--output", "delivered_work_j", "--bootstrap", "0"]);
    assert_eq!((found["outputs"][0]["used"]["whole"].as_u64(), names(&found, "guide").len()), (Some(128), 5));
    let output = Dataset::of("kind = \"morris\"\ntrajectories = 10").analyse(&["--given"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("elementary effects only"), "{}", text(&output.stderr));
}

/// What would have no effect is refused, before rows are run again.
#[test]
fn an_estimator_without_sobol_indices_and_rows_analysed_as_any_anyway_are_refused() {
    let random = Dataset::of("kind = \"random\"\nrows = 40");
    let saltelli = Dataset::of("kind = \"saltelli\"\nbase_points = 32");
    let bound =
        Dataset::of("kind = \"saltelli\"\nbase_points = 32\nconstraints = [\"pressure + 10 * position <= 6.5\"]");
    for (dataset, arguments, told) in [
        (
            &random,
            &["--estimator", "jansen"][..],
            "`jansen` is one of Sobol' indices, which these rows do not have: they do not",
        ),
        (&random, &["--estimator", "salib"], "run a `saltelli` design"),
        (&random, &["--given"], "leave `given` out"),
        (&saltelli, &["--given", "--estimator", "martinez"], "with `given`, other indices are computed"),
        (&bound, &["--estimator", "martinez"], "constraints make the factors depend"),
    ] {
        let output = dataset.analyse(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", text(&output.stdout));
        assert!(text(&output.stderr).contains(told), "{arguments:?}: {}", text(&output.stderr));
    }
    for (dataset, arguments) in [(&random, &[][..]), (&saltelli, &["--estimator", "jansen"]), (&bound, &["--given"])] {
        assert_eq!(dataset.analyse(arguments).status.code(), Some(0), "{arguments:?}");
    }
}

#[test]
fn tables_have_a_row_per_index() {
    let dataset = Dataset::of("kind = \"saltelli\"\nbase_points = 16\nsecond_order = true");
    let file = dataset.scratch.path().join("indices.parquet");
    let output = dataset.analyse(&["--parquet", file.to_str().expect("a path"), "--output", "delivered_work_j"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let Some(python) = std::env::var_os("DECORE_PYTHON") else {
        eprintln!("DECORE_PYTHON is not set: the table was not read, the JSON not held to its schema");
        return;
    };
    let json = dataset.scratch.path().join("found.json");
    fs::write(&json, dataset.analyse(&["--output", "delivered_work_j", "--json"]).stdout).expect("written");
    let schema = concat!(env!("CARGO_MANIFEST_DIR"), "/schemas/sensitivity.schema.json");
    let script = "import json, sys, jsonschema, pyarrow.parquet\n\
        rows = pyarrow.parquet.read_table(sys.argv[1]).to_pylist()\n\
        found, schema = (json.load(open(name)) for name in sys.argv[2:])\n\
        jsonschema.Draft202012Validator(schema).validate(found)\n\
        listed = found['outputs'][0]['indices']\n\
        assert len(rows) == len(listed) == 9, len(rows)\n\
        assert [row['value'] for row in rows] == [index['value'] for index in listed]\n\
        assert [row['low'] for row in rows] == [index['interval'][0] for index in listed]\n\
        assert rows[6]['index'] == 's2' and rows[6]['second_factor'] == 'pressure', rows[6]\n";
    let output = Command::new(python).args(["-c", script]).args([&file, &json]).arg(schema).output().expect("runs");
    assert!(output.status.success(), "{}", text(&output.stderr));
}

/// The page has what `decore analyse` and `decore surrogate` print, number by number; of a dataset too large for them it says so.
#[test]
fn the_page_knows_what_the_commands_print() {
    let dataset = Dataset::of("kind = \"saltelli\"\nbase_points = 128");
    let page = dataset.scratch.path().join("page.html");
    let printed = |arguments: &[&str]| -> Value {
        let output = decore().arg(arguments[0]).arg(dataset.folder()).args(&arguments[1..]).output().expect("runs");
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        serde_json::from_slice(&output.stdout).expect("JSON")
    };
    let meta = || -> Value {
        printed(&["report", "--json", "--replace", "--html", page.to_str().expect("a path")]);
        let page = fs::read_to_string(&page).expect("a page");
        let meta = page.split_once("id=\"meta\">").expect("data").1.split_once("</script>").expect("its end").0;
        serde_json::from_str(meta).expect("JSON")
    };
    let said = meta();
    assert_eq!(said["sensitivity"]["found"], printed(&["analyse", "--json"]));
    assert_eq!(said["models"]["found"]["surrogate"], printed(&["surrogate", "--json"]));
    assert!(said["sensitivity"]["found"]["method"]["name"] == "sobol" && said["sensitivity"]["why"].is_null());
    // 1280 rows are too many for models, not for indices.
    dataset.run("kind = \"saltelli\"\nbase_points = 256", &["--replace", "--stub-row-ms", "0"]);
    let said = meta();
    assert!(said["sensitivity"]["found"].is_object() && said["models"]["found"].is_null());
    assert!(
        said["models"]["why"].as_str().is_some_and(|why| why.contains("1280 rows") && why.contains("decore surrogate"))
    );
}

//! `decore best`: the answer to a study's question, the same whatever happened meanwhile.

use std::fs;
use std::path::PathBuf;
use std::process::Command;
use std::time::{Duration, Instant};

use serde_json::Value;
use tempfile::TempDir;

use crate::growth::MACHINE;
use crate::sweeps::{assert_same, decore, errors, expect_code};

const FACTORS: &str = r#"
[design.factor.pressure]
path = "hammer.left.supply_bar"
range = [4.0, 6.0]
unit = "bar"
[design.factor.stiffness]
path = "casting.part.fixture.front.stiffness_n_per_m"
range = [1e7, 1e8]
scale = "log"
role = "uncertain"
"#;

struct Study {
    scratch: TempDir,
}

impl Study {
    /// A study with this goal and these factors, 16 rows of 0.1 s.
    fn new(goal: &str, factors: &str) -> Self {
        Self::of(MACHINE, goal, factors)
    }

    fn of(machine: &str, goal: &str, factors: &str) -> Self {
        let study = Self { scratch: TempDir::new().expect("scratch folder") };
        let design = "[design]\nkind = \"latin_hypercube\"\nrows = 16\nseed = 5";
        let text = format!("duration_s = 0.1\n{machine}\n[goal]\n{goal}\n{design}\n{factors}");
        fs::write(study.file("study.toml"), text).expect("study");
        study
    }

    fn file(&self, name: &str) -> PathBuf {
        self.scratch.path().join(name)
    }

    fn best(&self, arguments: &[&str]) -> Command {
        let mut command = decore();
        command.current_dir(self.scratch.path()).args(["best", "study.toml", "--output", "out"]).args(arguments);
        command
    }

    /// The answer of 16 rows, 8 to learn and 20 checks, and the exit code.
    fn answer(&self, code: i32) -> Value {
        let command = self.best(&["--rows", "28", "--checks", "20", "--batch", "4", "--json"]);
        serde_json::from_slice(&expect_code(command, code).stdout).expect("JSON")
    }

    fn rows(&self) -> String {
        fs::read_to_string(self.file("out.best.csv")).unwrap_or_default()
    }
}

fn sentence(answer: &Value) -> &str {
    answer["sentence"].as_str().expect("a sentence")
}

const ENERGY: &str = "maximise = \"strike_energy_j\"";

#[test]
fn an_answer_is_proven_and_the_same_after_a_kill() {
    let goal = format!("{ENERGY}\nlimits = [\"max_casting_point_velocity_m_s <= 100\"]");
    let whole = Study::new(&goal, FACTORS);
    let answer = whole.answer(0);
    assert_eq!(answer["verdict"], "proven", "{answer}");
    assert!(
        sentence(&answer).starts_with("Choose pressure ") || sentence(&answer).starts_with("Choose 6 bar: "),
        "{answer}"
    );
    assert!(sentence(&answer).ends_with("held in 20 of 20 checks."), "{answer}");
    // More pressure is more energy: the corner.
    assert_eq!(answer["settings"][0]["value"], 6.0);
    let rows = whole.rows();
    let checks: Vec<&str> = rows.lines().filter(|line| line.contains(",check,")).collect();
    assert!(checks.len() == 20 && checks.iter().all(|line| line.starts_with("6,")), "{rows}");
    // Another look runs nothing more.
    assert_eq!(whole.answer(0), answer);
    assert_eq!(whole.rows(), rows);

    let killed = Study::new(&goal, FACTORS);
    let mut child = killed.best(&["--rows", "28", "--checks", "20", "--batch", "4", "--json"]).spawn().expect("starts");
    let begun = Instant::now();
    while killed.rows().is_empty() && begun.elapsed() < Duration::from_secs(120) {
        std::thread::sleep(Duration::from_millis(2));
    }
    child.kill().expect("killed");
    child.wait().expect("ended");
    assert_eq!(killed.answer(0), answer);
    assert_eq!(killed.rows(), rows);
    assert_same(&killed.file("out"), &whole.file("out"));
    // In another folder: no path of a folder is in them.
    assert_same(&killed.file("out.best"), &whole.file("out.best"));

    // Checks prove nothing of another question: no rows are left to check its answer.
    let other = ["--set", "goal.confidence=0.9", "--rows", "28", "--checks", "20", "--batch", "4", "--json"];
    let other: Value = serde_json::from_slice(&expect_code(whole.best(&other), 0).stdout).expect("JSON");
    assert_eq!((&other["verdict"], &other["proof"]), (&Value::from("unchecked"), &Value::Null));
    assert!(other["notes"].to_string().contains("No rows are left to prove it: give at least --rows "), "{other}");

    // The dataset alone answers the same question.
    let mut command = decore();
    command
        .current_dir(whole.scratch.path())
        .args(["best", "out", "--rows", "28", "--checks", "20", "--batch", "4", "--json"]);
    let again: Value = serde_json::from_slice(&expect_code(command, 0).stdout).expect("JSON");
    assert_eq!(again, answer);
}

/// Without uncertain factors, the best places are compared by runs before one is proven; an interruption while they run changes nothing.
#[test]
fn places_are_compared_before_one_is_proven() {
    let goal = format!("{ENERGY}\nlimits = [\"max_casting_point_velocity_m_s <= 100\"]");
    let arguments = ["--rows", "48", "--checks", "20", "--batch", "4", "--json"];
    let factors = FACTORS.replace("role = \"uncertain\"\n", "");
    let whole = Study::new(&goal, &factors);
    let answer: Value = serde_json::from_slice(&expect_code(whole.best(&arguments), 0).stdout).expect("JSON");
    assert_eq!((&answer["verdict"], &answer["proof"]["runs"]), (&Value::from("proven"), &Value::from(20)), "{answer}");
    let compared =
        answer["alternatives"].as_array().expect("alternatives").iter().filter(|one| one["proof"].is_object());
    let energies: Vec<f64> = compared
        .inspect(|one| {
            assert_eq!((&one["proof"]["runs"], &one["proof"]["held"]), (&Value::from(4), &Value::from(4)), "{one}")
        })
        .map(|one| one["goal"].as_f64().expect("a number"))
        .collect();
    assert!(
        !energies.is_empty() && energies.iter().all(|one| *one < answer["goal"]["mean"].as_f64().expect("a number")),
        "{answer}"
    );
    let rows = whole.rows();
    let purposes: Vec<&str> = rows.lines().skip(1).filter_map(|line| line.split(',').nth(2)).collect();
    let first = purposes.iter().position(|purpose| *purpose == "compare").expect("rows to compare");
    assert!(purposes[..first].iter().all(|purpose| *purpose == "learn") && purposes.contains(&"check"), "{rows}");

    let killed = Study::new(&goal, &factors);
    let mut child = killed.best(&arguments).env("RAYON_NUM_THREADS", "1").spawn().expect("starts");
    let begun = Instant::now();
    while !killed.rows().contains(",compare,") && begun.elapsed() < Duration::from_secs(120) {
        std::thread::sleep(Duration::from_millis(2));
    }
    child.kill().expect("killed");
    child.wait().expect("ended");
    let again: Value = serde_json::from_slice(&expect_code(killed.best(&arguments), 0).stdout).expect("JSON");
    assert_eq!((again, killed.rows()), (answer, rows));
    assert_same(&killed.file("out.best"), &whole.file("out.best"));
}

#[test]
fn limits_that_nothing_holds_are_named_with_the_nearest_place() {
    let study = Study::new(&format!("{ENERGY}\nlimits = [\"max_casting_point_velocity_m_s <= 0.01\"]"), FACTORS);
    let answer = study.answer(4);
    assert_eq!((&answer["verdict"], &answer["proof"]), (&Value::from("infeasible"), &Value::Null));
    let sentence = sentence(&answer);
    assert!(sentence.starts_with("No place holds the limits in 95 % of runs; nearest: "), "{sentence}");
    assert!(
        sentence.contains("max_casting_point_velocity_m_s reaches ") && sentence.contains("limit 0.01"),
        "{sentence}"
    );
    assert_eq!(answer["looser"][0]["goal"], Value::Null);

    // Far from all places: the nearest is where most is reached, whatever the goal has there.
    let goal = "minimise = \"total_air_used_nl\"\nlimits = [\"strike_energy_j >= 1000\"]";
    let answer = Study::new(goal, FACTORS).answer(4);
    assert_eq!((&answer["verdict"], &answer["settings"][0]["value"]), (&Value::from("infeasible"), &Value::from(6.0)));
}

#[test]
fn a_goal_that_is_the_same_everywhere_says_so() {
    let study = Study::new("maximise = \"0 * strike_energy_j + 3\"", FACTORS);
    let answer = study.answer(0);
    let notes = answer["notes"].to_string();
    assert!(notes.contains("is 3.000 in all rows: every place is as good"), "{answer}");
    assert_eq!(answer["goal"]["mean"], 3.0);
    assert!(sentence(&answer).contains(": 0 * strike_energy_j + 3 = 3 (3 to 3)"), "{answer}");
}

#[test]
fn names_are_chosen_among() {
    let factors = FACTORS.replace("range = [4.0, 6.0]\nunit = \"bar\"", "values = [4.0, 5.0, 6.0]\nunit = \"bar\"");
    let names = "[design.factor.mount]\npath = \"hammer.left.mount\"\nvalues = [\"R4\", \"R5\", \"R6\"]\n";
    let machine = MACHINE.replace("rail = \"rail\"\nrail_position_m = 0.0\n", "mount = \"R5\"\n");
    let study = Study::of(&machine, ENERGY, &format!("{factors}{names}"));
    let answer = study.answer(0);
    let settings = answer["settings"].as_array().expect("settings");
    let mount = settings.iter().find(|setting| setting["factor"] == "mount").expect("a mount");
    let mount = mount["value"].as_str().expect("a name");
    assert!(["R4", "R5", "R6"].contains(&mount), "{answer}");
    // The checks were run with the name that is proposed.
    let rows = study.rows();
    let checks: Vec<&str> = rows.lines().filter(|line| line.contains(",check,")).collect();
    assert!(checks.len() == 20 && checks.iter().all(|line| line.contains(&format!(",{mount},"))), "{mount}: {rows}");
    assert!(sentence(&answer).starts_with("Put the hammer on R"), "{answer}");
}

#[test]
fn hammers_are_chosen_among_their_files() {
    let hammer = decore_study::hammer_file().expect("a hammer file");
    let factors = "[design.factor.hammer]\npath = \"hammer.left.file\"\nvalues = [\"light.toml\", \"heavy.toml\"]\n\
                   [design.factor.pressure]\npath = \"hammer.left.supply_bar\"\nrange = [4.0, 6.0]\n";
    let study = Study::new(ENERGY, factors);
    let mass = hammer.lines().find(|line| line.starts_with("mass_kg")).expect("a mass").to_owned();
    fs::write(study.file("light.toml"), &hammer).expect("hammer");
    let number: f64 =
        mass.split_once("= ").and_then(|(_, text)| text.split_whitespace().next()?.parse().ok()).expect("kg");
    fs::write(study.file("heavy.toml"), hammer.replacen(&mass, &format!("mass_kg = {}", 1.2 * number), 1))
        .expect("hammer");
    let answer = study.answer(0);
    assert_eq!(answer["settings"][0]["factor"], "hammer");
    let file = answer["settings"][0]["value"].as_str().expect("a name");
    assert!(["light.toml", "heavy.toml"].contains(&file), "{answer}");
    assert!(sentence(&answer).starts_with(&format!("Choose hammer {file}, ")), "{answer}");
    let (meta, _) = page(&study);
    assert_eq!(meta["answer"]["found"]["answer"]["sentence"], answer["sentence"]);
}

#[test]
fn a_page_begins_with_the_answer() {
    let limits = "limits = [\"max_casting_point_velocity_m_s <= 100\"]";
    let study = Study::new(&format!("{ENERGY}\n{limits}"), FACTORS);
    let answer = study.answer(0);
    let (meta, text) = page(&study);
    let found = &meta["answer"]["found"];
    assert_eq!((&found["answer"]["sentence"], &found["answer"]["verdict"]), (&answer["sentence"], &answer["verdict"]));
    assert_eq!(found["answer"]["proof"], answer["proof"]);
    // The page names what it predicts: goal and limit, the uncertain factor and its draws, the machine.
    assert_eq!(found["values"][1]["limit"], 100.0);
    assert_eq!((&found["uncertain"], found["nodes"].as_array().map(Vec::len)), (&serde_json::json!([1]), Some(40)));
    assert_eq!(found["model"]["outputs"].as_array().map(Vec::len), Some(2));
    let plan = &found["plan"];
    assert_eq!(plan["castings"][0]["fixtures"].as_array().map(Vec::len), Some(3), "{plan}");
    assert!(plan["rails"][0]["at"].as_array().is_some_and(|points| points.len() > 1), "{plan}");
    assert!(!text.contains(study.scratch.path().to_str().expect("path")), "the page names a folder of this machine");

    // Without the rows of `best` it is what a model of the sweep's rows expects.
    fs::remove_dir_all(study.file("out.best")).expect("removed");
    assert_eq!(page(&study).0["answer"]["found"]["answer"]["verdict"], "unchecked");
    // Added rows of another study are no proof.
    let other = Study::of(&MACHINE.replace("mass_kg = 3.0", "mass_kg = 4.0"), &format!("{ENERGY}\n{limits}"), FACTORS);
    other.answer(0);
    for name in ["out.best", "out.best.csv"] {
        fs::rename(other.file(name), study.file(name)).expect("moved");
    }
    let (meta, _) = page(&study);
    assert_eq!(meta["answer"]["found"], Value::Null);
    assert!(
        meta["answer"]["why"].as_str().is_some_and(|why| why.contains("out.best holds rows of another study")),
        "{meta}"
    );
}

#[test]
fn a_page_tells_limits_that_nothing_holds_and_rows_that_fail() {
    let factors = "[design.factor.pressure]\npath = \"hammer.left.supply_bar\"\nrange = [4.0, 6.0]\n\
                   [design.factor.position]\npath = \"hammer.left.rail_position_m\"\nrange = [-0.2, 0.2]\n";
    let study = Study::new(&format!("{ENERGY}\nlimits = [\"max_casting_point_velocity_m_s <= 0.01\"]"), factors);
    study.answer(4);
    let (meta, _) = page(&study);
    let found = &meta["answer"]["found"];
    assert_eq!(found["answer"]["verdict"], "infeasible");
    assert!(
        found["model"]["outputs"][0]["success"]["everywhere"].is_number()
            || found["model"]["outputs"][0]["success"]["process"].is_object()
    );
    // The tracks of the hammer end where it misses the casting: such rows describe no scene that can run, yet they have a place.
    assert_eq!(found["plan"]["tracks"][0]["factor"], "position");

    // A value that no row has: the page says why there is no answer.
    let study = Study::new(&format!("{ENERGY}\nlimits = [\"left_arm_rms_steady_m_s <= 1\"]"), FACTORS);
    expect_code(study.best(&["--rows", "0"]), 2);
    let (meta, _) = page(&study);
    assert!(
        meta["answer"]["why"].as_str().is_some_and(|why| why.contains("none of 16 rows has it")),
        "{}",
        meta["answer"]
    );
}

/// What the page of the study's dataset says, and its text.
fn page(study: &Study) -> (Value, String) {
    let mut report = decore();
    report.current_dir(study.scratch.path()).args(["report", "out", "--html", "page.html", "--replace"]);
    expect_code(report, 0);
    let text = fs::read_to_string(study.file("page.html")).expect("page");
    let start = text.split_once("id=\"meta\">").expect("data").1;
    let meta = serde_json::from_str(start.split_once("</script>").expect("its end").0).expect("JSON");
    (meta, text)
}

#[test]
fn a_limit_on_a_value_that_no_row_has_is_an_error() {
    let study = Study::new(&format!("{ENERGY}\nlimits = [\"left_arm_rms_steady_m_s <= 1\"]"), FACTORS);
    let error = errors(&expect_code(study.best(&["--rows", "0"]), 2));
    assert!(error.contains("`left_arm_rms_steady_m_s` cannot be predicted: none of 16 rows has it"), "{error}");
}

#[test]
fn places_where_rows_fail_are_not_proposed() {
    let factors = "[design.factor.pressure]\npath = \"hammer.left.supply_bar\"\nrange = [4.0, 6.0]\n\
                   [design.factor.position]\npath = \"hammer.left.rail_position_m\"\nrange = [-0.2, 0.2]\n";
    let study = Study::new(ENERGY, factors);
    let answer = study.answer(0);
    // The casting is 0.30 m long about its centre: the hammer misses it farther out.
    let position = answer["settings"][1]["value"].as_f64().expect("a number");
    assert!(position.abs() < 0.15 && answer["proof"]["failed"] == 0, "{answer}");
    assert!(answer["notes"].to_string().contains("rows have no value"), "{answer}");
}

#[test]
fn a_study_that_asks_nothing_is_told_how_to_ask() {
    let study = Study::new(ENERGY, FACTORS);
    let text = fs::read_to_string(study.file("study.toml")).expect("study");
    fs::write(study.file("study.toml"), text.replace("[goal]\nmaximise = \"strike_energy_j\"\n", "")).expect("study");
    let error = errors(&expect_code(study.best(&[]), 2));
    assert!(error.contains("the study has no goal: add, for example") && !study.file("out").exists(), "{error}");
}

#[test]
fn refine_narrows_the_choice_and_ends_with_the_sentence() {
    let study = Study::new(&format!("{ENERGY}\nlimits = [\"max_casting_point_velocity_m_s <= 100\"]"), FACTORS);
    let mut design = decore();
    design.current_dir(study.scratch.path()).args(["design", "study.toml", "--output", "rows.csv"]);
    expect_code(design, 0);
    let text = fs::read_to_string(study.file("study.toml")).expect("study");
    let table = text.replace("kind = \"latin_hypercube\"\nrows = 16", "kind = \"table\"\nfile = \"rows.csv\"");
    fs::write(study.file("table.toml"), table).expect("study");
    let mut refine = decore();
    refine.current_dir(study.scratch.path()).args([
        "refine",
        "table.toml",
        "--goal",
        "--most-rows",
        "24",
        "--output",
        "table",
    ]);
    let printed = String::from_utf8(expect_code(refine, 0).stdout).expect("text");
    let last = printed.lines().last().expect("a line");
    assert!(last.contains("bar: ") && last.contains("not checked by runs."), "{printed}");
    let rows = fs::read_to_string(study.file("rows.csv")).expect("rows").lines().count() - 1;
    assert!((16..=24).contains(&rows), "{rows}");
}

#[test]
fn a_sweep_ends_with_what_a_model_of_its_rows_expects() {
    let study = Study::new(ENERGY, FACTORS);
    let mut run = decore();
    run.current_dir(study.scratch.path()).args(["run", "study.toml", "--output", "out"]);
    let printed = String::from_utf8(expect_code(run, 0).stdout).expect("text");
    let end: Vec<&str> = printed.lines().rev().take(2).collect();
    assert_eq!(end[0], "`decore best study.toml` confirms it by runs.");
    assert!(end[1].ends_with("expected by a model of 16 rows, not checked by runs."), "{printed}");
}

#[test]
fn a_shard_has_no_answer_of_its_own() {
    let study = Study::new(ENERGY, FACTORS);
    let mut run = decore();
    run.current_dir(study.scratch.path()).args(["run", "study.toml", "--shard", "1/1", "--output", "shard"]);
    let printed = String::from_utf8(expect_code(run, 0).stdout).expect("text");
    assert!(!printed.contains("decore best") && !printed.contains("expected by a model"), "{printed}");
}

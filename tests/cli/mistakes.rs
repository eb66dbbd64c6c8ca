//! Common mistakes, and what the program says to do about them.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::TempDir;

/// A folder with the shipped studies.
fn folder() -> TempDir {
    let scratch = TempDir::new().expect("a folder");
    let studies = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies");
    fs::create_dir(scratch.path().join("hammers")).expect("a folder");
    for name in ["paper_rig.toml", "pressure_grid.toml", "hammers/default.toml"] {
        fs::copy(studies.join(name), scratch.path().join(name)).expect("copied");
    }
    scratch
}

/// Exit code and what is said on both streams.
fn says(scratch: &TempDir, arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_decore"));
    let output = command.args(arguments).current_dir(scratch.path()).output().expect("the program starts");
    let text = String::from_utf8_lossy(&[output.stderr, output.stdout].concat()).into_owned();
    (output.status.code(), if cfg!(windows) { text.replace('\\', "/") } else { text })
}

#[test]
fn what_is_given_in_place_of_a_study_or_a_dataset_is_named() {
    let scratch = folder();
    let quick = ["--set", "duration_s=0.01", "--set", "solver.guide=tied"];
    let run = says(&scratch, &[&["run", "pressure_grid.toml"], &quick[..]].concat());
    assert!(run.0 == Some(0) || run.0 == Some(4), "{}", run.1);
    for (arguments, words) in [
        (vec!["run", "paper_rg.toml"], "there is no study paper_rg.toml; did you mean paper_rig.toml?"),
        (vec!["run", "no/paper_rig.toml"], "the folder no does not exist"),
        (vec!["check", "zzz"], "`decore init zzz` writes one to start from"),
        (
            vec!["scene", "."],
            ". is a folder, where a study (a TOML file) is expected; it holds paper_rig.toml, pressure_grid.toml",
        ),
        (vec!["run", "out/pressure_grid"], "out/pressure_grid is a dataset, where a study (a TOML file) is expected"),
        (vec!["accuracy", "out/pressure_grid/manifest.json"], "is no study: a TOML file is expected"),
        (vec!["status", "pressure_grid.toml"], "`decore run pressure_grid.toml` wrote out/pressure_grid"),
        (vec!["report", "out/presure_grid"], "there is no dataset out/presure_grid; did you mean out/pressure_grid?"),
        (vec!["report", "out/pressure_grid/runs"], "give out/pressure_grid"),
        (vec!["verify", "out/pressure_grid/manifest.json"], "give the folder out/pressure_grid"),
        (vec!["report", "out/pressure_grid", "--best", "0"], "expected a whole number from 1 on"),
        (vec!["help", "accuarcy"], "did you mean `accuracy`?"),
        (vec!["analise"], "analyse"),
        (
            vec!["scene", "paper_rig.toml", "--plot", "rig.png"],
            "the output format is SVG: use a file name that ends in `.svg`",
        ),
        (vec!["scene", "paper_rig.toml", "--signals", "out"], "--signals out is a folder"),
        (vec!["scene", "paper_rig.toml", "--row", "1"], "--row is 1, but the study has row 0 only"),
        (vec!["scene", "paper_rig.toml", "--set", "hammer.hammer.supply_bar=5,0"], "a number, with a point as in 5.0"),
        (vec!["scene", "paper_rig.toml", "--set", "solver.fidelity=standart"], "did you mean `standard`?"),
    ] {
        let (code, text) = says(&scratch, &arguments);
        assert_eq!(code, Some(2), "{arguments:?}: {text}");
        assert!(text.contains(words), "{arguments:?}: {text}");
    }
    let (code, text) = says(&scratch, &["init", "no/study.toml"]);
    assert!(code == Some(3) && text.contains("make the folder no first"), "{text}");
}

/// What is to be copied to a shell is one word there, whatever the name.
#[cfg(unix)]
#[test]
fn commands_that_are_suggested_can_be_copied() {
    let scratch = folder();
    let name = "it's my $(touch forged) study";
    let file = format!("{name}.toml");
    let (code, text) = says(&scratch, &["init", &file]);
    assert_eq!(code, Some(0), "{text}");
    let copied = |command: &str| {
        let program = Path::new(env!("CARGO_BIN_EXE_decore")).display();
        let line = format!("decore() {{ '{program}' \"$@\"; }}; {command}");
        let output = Command::new("sh").args(["-c", &line]).current_dir(scratch.path()).output().expect("a shell");
        assert!(output.status.success(), "{command}: {}", String::from_utf8_lossy(&output.stderr));
    };
    let (_, next) = text.trim_end().split_once("next: ").expect("commands");
    let (check, run) = next.split_once(", ").expect("two commands");
    assert!(run.starts_with("decore run "), "{run}");
    copied(check);
    let (_, text) = says(&scratch, &["check", "no such one"]);
    copied(text.split('`').nth(1).expect("a command"));
    let quick = ["run", "pressure_grid.toml", "--stub-row-ms", "0", "--output", name];
    assert_ne!(says(&scratch, &quick).0, Some(2));
    let (_, text) = says(&scratch, &["status", name]);
    copied(text.split('`').nth(1).expect("a command"));
    let (_, text) = says(&scratch, &["run", name]);
    text.split('`').skip(1).step_by(2).take(2).for_each(copied);
    assert!(!scratch.path().join("forged").exists());
}

#[test]
fn a_report_shows_distributions_and_fits_its_reader() {
    let scratch = folder();
    let quick = ["run", "pressure_grid.toml", "--set", "duration_s=0.1", "--set", "solver.guide=tied"];
    assert_eq!(says(&scratch, &quick).0, Some(0));
    let report = |locale: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_decore"));
        command.args(["report", "out/pressure_grid"]).current_dir(scratch.path()).env("LC_ALL", locale);
        String::from_utf8(command.output().expect("the program starts").stdout).expect("UTF-8")
    };
    let (blocks, plain) = (report("C.UTF-8"), report("C"));
    for text in [&blocks, &plain] {
        assert!(
            text.contains("Best rows by `strike_energy_j`") && text.contains("Distributions (rows done)"),
            "{text}"
        );
        assert!(text.contains("`strike_energy_j` over factor `"), "{text}");
    }
    assert!(blocks.contains('\u{2588}') && plain.is_ascii(), "{blocks}{plain}");
    let tables: PathBuf = scratch.path().join("out/pressure_grid/runs");
    let named = Path::new("out/pressure_grid").join("runs");
    assert!(tables.is_dir() && plain.contains(named.to_str().expect("a path")), "{plain}");
}

/// Slips of units are told once, and the row is run nevertheless.
#[test]
fn warnings_are_told_once() {
    let scratch = folder();
    let slip = ["--set", "environment.temperature_k=20", "--set", "duration_s=0.01"];
    for command in ["scene", "run", "check"] {
        let (code, text) = says(&scratch, &[&[command, "paper_rig.toml"], &slip[..]].concat());
        assert_ne!(code, Some(2), "{text}");
        assert_eq!(text.matches("20 K is unusual").count(), 1, "{command}: {text}");
        assert!(
            text.contains("warning: ") && text.contains("is it in degrees Celsius (293.1 K)?"),
            "{command}: {text}"
        );
    }
}

/// Mistakes in a study: what is replaced by what, and the words of the answer. Each names the line and the key, or shows the line,
/// and says what to write.
const MISTAKES: &[(&str, &str, &[&str])] = &[
    ("rows = 240", "rows = 240\nkind2 = fast", &["m.toml:48:9", "a text without quotes", "`kind2 = \"fast\"`"]),
    ("fidelity = \"standard\"", "fidelity = fast", &["a text without quotes", "`fidelity = \"fast\"`"]),
    ("fidelity = \"standard\"", "fidelity = \"fast\"", &["`solver.fidelity`", "is \"fast\"", "\"draft\""]),
    (
        "range = [4.0, 6.0]",
        "min = 4.0\nmax = 6.0",
        &["`design.factor.pressure.min`", "did you mean `range = [LOW, HIGH]`"],
    ),
    (
        "range = [4.0, 6.0]",
        "range = [6.0, 4.0]",
        &["`design.factor.pressure.range`", "is empty", "lower end comes first"],
    ),
    ("range = [4.0, 6.0]", "range = [4.0]", &["is a list of 1 entry\n", "a list of 2 entries, each a number"]),
    ("range = [4.0, 6.0]", "range = [4,0, 6,0]", &["is a list of 4 entries", "a point in a number, as in 4.5"]),
    ("range = [4.0, 6.0]", "range = \"4 to 6\"", &["is the text \"4 to 6\"", "a list of 2 entries, each a number"]),
    ("range = [4.0, 6.0]", "", &["`design.factor.pressure`: has no range and no values", "`range = [LOW, HIGH]`"]),
    ("range = [4.0, 6.0]", "range = [4.0, 6.0]\nvalues = [5.0]", &["has both a `range` and `values`"]),
    ("rows = 240", "rows = \"240\"", &["`design.rows`: is the text \"240\"", "write 240, without quotes"]),
    ("rows = 240", "rows = 240.0", &["`design.rows`: is the number 240.0", "write 240"]),
    ("rows = 240", "rows = -5", &["`design.rows`: is -5", "a whole number of at least 0"]),
    ("rows = 240", "rows = 0", &["`design.rows`: a design needs at least one row"]),
    ("rows = 240", "rows: 240", &["m.toml:47:", "a colon between key and value", "`rows = 240`"]),
    ("rows = 240", "rows =", &["m.toml:47:", "a key without a value", "`rows = VALUE`"]),
    ("rows = 240", "rows = 240 runs", &["a number with text behind it", "`rows = 240`"]),
    ("rows = 240", "samples = 240", &["`design.samples`: unknown key", "did you mean `rows`?"]),
    ("supply_bar = 5.0", "supply_bar = 5,0", &["m.toml:16:", "a comma in a number", "a point in a number, as in 5.0"]),
    ("supply_bar = 5.0", "supply_bar = 5.0 bar", &["a number with text behind it", "`supply_bar = 5.0`"]),
    (
        "supply_bar = 5.0",
        "supply_bar = \"5.0\"",
        &["`hammer.hammer.supply_bar`: is the text \"5.0\"", "write 5.0, without quotes"],
    ),
    ("supply_bar = 5.0", "pressure = 5.0", &["`hammer.hammer.pressure`: unknown key", "did you mean `supply_bar`?"]),
    ("mass_kg = 3.0", "mass_kg = -3.0", &["`casting.part.mass_kg`", "is -3, expected a positive number"]),
    ("rail = \"rail\"", "rail = \"rial\"", &["`hammer.hammer.rail`", "did you mean `rail`?"]),
    (
        "rail = \"rail\"",
        "mount = \"R55\"\nrail = \"rail\"",
        &["`hammer.hammer.mount`", "no interface point `R55`", "did you mean `R5`?"],
    ),
    ("file = \"hammers/default.toml\"", "file = \"hammers/no.toml\"", &["`hammer.hammer.file`", "hammers/no.toml"]),
    ("mass_kg = 3.0", "mass = 3.0", &["`casting.part.mass`: unknown key", "did you mean `mass_kg`?"]),
    ("mass_kg = 3.0", "mass_kg = 3000", &["3000 kg is unusual", "is it in g (3 kg)?"]),
    ("mass_kg = 3.0", "", &["`casting.part.mass_kg`: missing key", "add `mass_kg = ...` to `[casting.part]`"]),
    ("point = \"T1\"", "point = \"T11\"", &["`casting.part.fixture.front_left.point`", "did you mean `T1`?"]),
    ("point = \"T1\"", "point = T1", &["a text without quotes", "`point = \"T1\"`"]),
    ("point = \"T1\"", "point = \u{201c}T1\u{201d}", &["curly quotes", "`point = \"T1\"`"]),
    ("[design]", "[design", &["without its closing bracket", "`[design]`"]),
    ("[solver]", "[sover]", &["`sover`: unknown key", "did you mean `solver`?"]),
    ("[solver]", "[casting.part]\n[solver]", &["is defined twice; the first definition is in line 19"]),
    (
        "[design.factor.standoff]",
        "[design.factor.pressure]",
        &["m.toml:60:", "is defined twice; the first definition is in line 55", "delete or rename one of them"],
    ),
    ("seed = 1", "rows = 20", &["is defined twice; the first definition is in line 47"]),
    ("\"latin_hypercube\"", "\"latin\"", &["`design.kind`: is \"latin\"", "did you mean `latin_hypercube`?"]),
    ("\"latin_hypercube\"", "\"lhs\"", &["did you mean `latin_hypercube`?"]),
    ("\"hammer.hammer.supply_bar\"", "\"hammer.hamer.supply_bar\"", &["did you mean `hammer.hammer.supply_bar`?"]),
    ("\"hammer.hammer.supply_bar\"", "\"supply_bar\"", &["did you mean `hammer.hammer.supply_bar`?"]),
    ("\"hammer.hammer.supply_bar\"", "\"hammer.hammer.standoff_m\"", &["is driven twice"]),
    ("unit = \"bar\"", "unit = \"kg\"", &["`design.factor.pressure.unit`: is \"kg\"", "which is in bar", "\"psi\""]),
    ("unit = \"N/m\"", "unit = \"N/mn\"", &["`design.factor.fixture_stiffness.unit`", "did you mean `N/m`?"]),
    ("role = \"uncertain\"", "role = \"unsure\"", &["`design.factor.fixture_stiffness.role`", "\"uncertain\""]),
    ("scale = \"log\"", "scale = \"logarithmic\"", &["`design.factor.fixture_stiffness.scale`", "\"log\""]),
    (
        "maximise = \"strike_energy_j\"",
        "maximise = \"strike_energy\"",
        &["goal.maximise", "did you mean `strike_energy_j`?"],
    ),
    (
        "maximise = \"strike_energy_j\"",
        "maximize = \"strike_energy_j\"",
        &["`goal.maximize`: unknown key", "did you mean `maximise`?"],
    ),
];

#[test]
fn each_mistake_in_a_study_is_answered() {
    let scratch = folder();
    let base =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/placement.toml")).expect("a study");
    let mut wrong = Vec::new();
    for (old, new, words) in MISTAKES {
        assert!(base.contains(old), "{old}");
        fs::write(scratch.path().join("m.toml"), base.replacen(old, new, 1)).expect("written");
        let (code, text) = says(&scratch, &["check", "m.toml", "--set", "duration_s=0.01"]);
        let is_warning = text.starts_with("warning: ");
        if !(is_warning || code == Some(2) && text.starts_with("error: "))
            || !words.iter().all(|word| text.contains(word))
        {
            wrong
                .push(format!("{new:?}, {words:?}: {code:?}\n{}", text.lines().take(9).collect::<Vec<_>>().join("\n")));
        }
    }
    assert!(MISTAKES.len() >= 40 && wrong.is_empty(), "{}", wrong.join("\n\n"));
}

#[test]
fn other_encodings_are_named() {
    let scratch = folder();
    let text = fs::read_to_string(scratch.path().join("paper_rig.toml")).expect("a study");
    let utf16 = |order: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(order).collect::<Vec<u8>>();
    let cases = [
        ([&[0xff, 0xfe][..], &utf16(u16::to_le_bytes)].concat(), "is encoded as UTF-16: save it as UTF-8"),
        ([&[0xfe, 0xff][..], &utf16(u16::to_be_bytes)].concat(), "is encoded as UTF-16: save it as UTF-8"),
        (utf16(u16::to_le_bytes), "is encoded as UTF-16: save it as UTF-8"),
        ([b"title = \"x\"\n# M\xfcnchen\n", text.as_bytes()].concat(), "line 2 is not UTF-8 text (byte 0xfc)"),
    ];
    for (bytes, words) in cases {
        fs::write(scratch.path().join("m.toml"), bytes).expect("written");
        let (code, text) = says(&scratch, &["check", "m.toml"]);
        assert!(code == Some(2) && text.contains("m.toml") && text.contains(words), "{words}: {text}");
    }
}

/// Rows that cannot be simulated come first, by kind, with the range that works; `--strict` makes them an exit code.
#[test]
fn rows_that_cannot_be_simulated_come_first() {
    let scratch = folder();
    let base =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/placement.toml")).expect("a study");
    fs::write(scratch.path().join("m.toml"), base.replace("[-0.12, 0.12]", "[-0.30, 0.30]")).expect("written");
    let check = ["check", "m.toml", "--set", "duration_s=0.01", "--set", "design.rows=40"];
    let (code, text) = says(&scratch, &check);
    let first = text.lines().next().unwrap_or_default();
    assert!(
        code == Some(0) && first.starts_with("warning: ") && first.ends_with(" of 40 rows cannot be simulated"),
        "{text}"
    );
    assert!(text.contains("hammer `hammer` would miss casting `part`; position must stay within +-0.14 m\n"), "{text}");
    assert!(text.find("cannot be simulated") < text.find("design         40 rows"), "{text}");
    assert_eq!(says(&scratch, &[&check[..], &["--strict"]].concat()).0, Some(4));
    let (code, text) = says(&scratch, &["check", "paper_rig.toml", "--strict", "--set", "duration_s=0.01"]);
    assert!(code == Some(0) && !text.contains("cannot be simulated"), "{text}");
    let (_, json) = says(&scratch, &[&check[..], &["--json"]].concat());
    let json: serde_json::Value = serde_json::from_str(&json[json.find('{').expect("JSON")..]).expect("JSON");
    let working = &json["invalid"]["kinds"][0]["working"][0];
    let [low, high] = ["low", "high"].map(|end| working[end].as_f64().expect("a number"));
    assert!(working["factor"] == "position" && (high - 0.14).abs() < 1e-6 && (low + 0.14).abs() < 1e-6, "{working}");
}

/// A scene that is sound by itself but cannot be built is a warning before the plan, and exit code 4 if no row can be built.
#[test]
fn rows_that_cannot_be_built_come_first() {
    let scratch = folder();
    let pad = |name: &str, x: f64, y: f64| {
        format!("[casting.part.fixture.{name}]\npoint = \"T5\"\nat_m = [{x}, {y}]\none_sided = true\n")
    };
    let study = |beside: f64| {
        let pads =
            [pad("a", -0.06, beside), pad("b", 0.06, beside), pad("c", -0.06, 0.05), pad("d", 0.06, 0.06)].concat();
        let text = format!(
            "duration_s = 0.01\ngeometry = \"as_given\"\n[hammer.left]\nmount = \"R5\"\n[casting.part]\nmass_kg = 0.517\n\
             inertia_kg_m2 = [1e-3, 1e-3]\n{pads}"
        );
        fs::write(scratch.path().join("m.toml"), text).expect("written");
        says(&scratch, &["check", "m.toml"])
    };
    let (code, text) = study(-0.05);
    assert!(code == Some(0) && !text.contains("cannot be simulated"), "{text}");
    let tips = |text: &str| text.starts_with("warning: row 0 cannot be simulated: casting `part` cannot rest");
    let (code, text) = study(0.03);
    assert!(code == Some(4) && tips(&text) && text.contains("design"), "{code:?} {text}");
}

/// A factor in another unit of its parameter's quantity gives the rows of the same factor in the parameter's unit.
#[test]
fn factors_are_converted_to_their_parameters_unit() {
    let scratch = folder();
    let base =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/placement.toml")).expect("a study");
    fs::write(scratch.path().join("bar.toml"), &base).expect("written");
    let kilopascal = base.replace("range = [4.0, 6.0]\nunit = \"bar\"", "range = [400.0, 600.0]\nunit = \"kPa\"");
    fs::write(scratch.path().join("kpa.toml"), kilopascal).expect("written");
    let (code, text) = says(&scratch, &["check", "kpa.toml", "--set", "duration_s=0.01"]);
    let note = "note: factor `pressure`: 400 to 600 kPa are converted to 4 to 6 bar for `hammer.hammer.supply_bar`";
    assert!(code == Some(0) && text.contains(note) && text.contains("pressure: 400 to 600 kPa"), "{text}");
    let quick = ["--set", "duration_s=0.1", "--set", "solver.fidelity=draft", "--row", "3", "--json"];
    let scene = |study: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_decore"));
        let output = command.args([&["scene", study][..], &quick].concat()).current_dir(scratch.path()).output();
        let json: serde_json::Value = serde_json::from_slice(&output.expect("started").stdout).expect("JSON");
        json
    };
    let (bar, kpa) = (scene("bar.toml"), scene("kpa.toml"));
    let energy = |json: &serde_json::Value| {
        let text = json.to_string();
        let at = text.find("\"strike_energy_j\":").expect("an output") + 18;
        text[at..].split([',', '}']).next().and_then(|number| number.parse::<f64>().ok()).expect("a number")
    };
    let (a, b) = (energy(&bar), energy(&kpa));
    assert!(a > 10.0 && (a - b).abs() < 1e-6 * a, "{a} and {b}");
}

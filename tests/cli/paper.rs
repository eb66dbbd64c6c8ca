//! `decore paper`: the publication beside its rig.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value as Json;
use tempfile::TempDir;

/// Most columns of a text that no terminal reads.
const COLUMNS: usize = 80;
/// What the publication prints, name, calculated, measured, and the share within which ours was seen to lie of each.
const PRINTED: [Printed; 6] = [
    Printed { name: "energy of the first impact", values: [Some(70.0), None], within: [0.002, 0.0] },
    Printed { name: "mean energy of later blows", values: [Some(12.2), None], within: [0.012, 0.0] },
    Printed { name: "frequency of blows", values: [Some(22.0), Some(20.5)], within: [0.003, 0.072] },
    Printed { name: "RMS during the extension", values: [Some(0.0216), Some(0.0209)], within: [0.24, 0.282] },
    Printed { name: "RMS during hammering", values: [Some(0.0254), Some(0.0137)], within: [0.63, 0.312] },
    Printed { name: "strongest line, hammering", values: [Some(44.0), Some(81.0)], within: [0.01, 0.46] },
];
/// Table 3: measured, calculated, and the printed difference in %, `(measured - calculated) / measured`.
const TABLE_3: [[f64; 3]; 12] = [
    [16.0, 16.29, -1.81],
    [18.0, 18.61, -3.39],
    [21.0, 19.93, 5.10],
    [44.0, 44.69, -1.57],
    [79.0, 81.55, -3.23],
    [85.0, 84.81, 0.22],
    [90.0, 91.53, -1.70],
    [118.0, 117.35, 0.55],
    [148.0, 144.0, 2.70],
    [208.0, 212.0, -1.92],
    [231.0, 231.85, -0.37],
    [271.0, 278.61, -2.81],
];

/// A figure of the publication: calculated and measured.
struct Printed {
    name: &'static str,
    values: [Option<f64>; 2],
    within: [f64; 2],
}

/// Standard output of the program in an empty folder, which stays empty.
fn said(arguments: &[&str]) -> String {
    let folder = TempDir::new().expect("scratch folder");
    let output = Command::new(env!("CARGO_BIN_EXE_decore")).args(arguments).current_dir(folder.path()).output();
    let output = output.expect("started");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    assert_eq!(fs::read_dir(folder.path()).expect("folder").count(), 0);
    String::from_utf8(output.stdout).expect("UTF-8")
}

fn list<'a>(of: &'a Json, key: &str) -> &'a [Json] {
    of[key].as_array().unwrap_or_else(|| panic!("{key}"))
}

#[test]
fn figures_stand_beside_those_of_the_publication() {
    let comparison: Json = serde_json::from_str(&said(&["paper", "--json"])).expect("JSON");
    let figures: Vec<&Json> = list(&comparison, "groups").iter().flat_map(|group| list(group, "figures")).collect();
    let figure = |name: &str| *figures.iter().find(|one| one["name"] == name).unwrap_or_else(|| panic!("no {name}"));
    for Printed { name, values, within } in PRINTED {
        let (one, ours) = (figure(name), figure(name)["ours"].as_f64().expect("ours"));
        for ((key, value), within) in ["calculated", "measured"].into_iter().zip(values).zip(within) {
            assert_eq!(one[key]["paper"].as_f64(), value, "{name}, {key}");
            let Some(value) = value else { continue };
            let difference = (ours - value) / value;
            assert!(difference.abs() <= within, "{name}, {key}: {ours} beside {value}");
            assert!((one[key]["difference"].as_f64().expect("difference") - difference).abs() < 1e-12);
        }
    }
    for (index, [measured, calculated, printed]) in TABLE_3.into_iter().enumerate() {
        let one = figure(&format!("mode {}", index + 1));
        assert_eq!(
            (one["measured"]["paper"].as_f64(), one["calculated"]["paper"].as_f64()),
            (Some(measured), Some(calculated))
        );
        // The publication's own column of differences.
        assert!((100.0 * (measured - calculated) / measured - printed).abs() < 0.006, "mode {}", index + 1);
        let ours = one["ours"].as_f64().expect("ours");
        assert!((ours / calculated - 1.0).abs() < 5e-4, "mode {}: {ours}", index + 1);
    }
    // Ours are what `decore scene` says of the shipped study.
    let rig = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/paper_rig.toml");
    let scene: Json = serde_json::from_str(&said(&["scene", rig.to_str().expect("path"), "--json"])).expect("JSON");
    let hammer = &scene["outcome"]["metrics"]["hammers"][0];
    for (name, output) in [
        ("energy of the first impact", "first_impact_energy_j"),
        ("mean energy of later blows", "periodic_energy_mean_j"),
        ("frequency of blows", "hit_frequency_hz"),
        ("RMS during the extension", "arm_rms_extension_m_s"),
        ("RMS during hammering", "arm_rms_hammering_m_s"),
    ] {
        assert_eq!(figure(name)["ours"], hammer[output], "{name}");
    }
    for (count, key) in [("calculations", "calculated"), ("measurements", "measured"), ("quoted_differences", "quoted")]
    {
        let against: Vec<&Json> = figures.iter().map(|one| &one[key]).filter(|one| !one.is_null()).collect();
        let agree = against.iter().filter(|one| one["agrees"] == true).count();
        assert!(agree < against.len(), "{count}: all agree");
        assert_eq!(
            (comparison[count]["of"].as_u64(), comparison[count]["agree"].as_u64()),
            (Some(against.len() as u64), Some(agree as u64))
        );
    }
}

#[test]
fn the_text_fits_and_marks_what_differs() {
    let text = said(&["paper"]);
    for line in text.lines() {
        assert!(line.chars().count() <= COLUMNS, "{line}");
    }
    let line =
        |name: &str| text.lines().find(|line| line.starts_with(name)).unwrap_or_else(|| panic!("{name} in\n{text}"));
    assert!(line("RMS during hammering (m/s)").ends_with("%*"));
    let frequency = line("frequency of blows (Hz)");
    assert!(frequency.ends_with("+7.1 %*") && frequency.matches('*').count() == 1, "{frequency}");
    assert!(!line("energy of the first impact (J)").contains('*'));
}

/// Values of the rows of a table of evidence.
fn evidence(comparison: &Json, name: &str) -> Vec<Vec<f64>> {
    let tables = list(comparison, "groups").iter().flat_map(|group| list(group, "evidence"));
    let table = tables.clone().find(|table| table["name"] == name).unwrap_or_else(|| panic!("no {name}"));
    let values = |row: &Json| list(row, "values").iter().map(|value| value.as_f64().expect("a number")).collect();
    list(table, "rows").iter().map(values).collect()
}

/// Contradictions with the paper are printed, with runs that show them.
#[test]
fn contradictions_are_shown_as_such() {
    let comparison: Json = serde_json::from_str(&said(&["paper", "--json"])).expect("JSON");
    // 44 Hz leads by a rectangular window over the whole run alone.
    let lines = evidence(&comparison, "Lines of the mount's velocity by window and span");
    assert!((lines[0][0] - 44.0).abs() < 0.7 && lines[0][1] < lines[0][2], "{lines:?}");
    assert_eq!(lines.len(), 4);
    for line in &lines[1..] {
        let ratio = line[1] / line[2];
        assert!((line[0] - 22.0).abs() < 0.7 && (2.5..4.0).contains(&ratio), "{line:?}: {ratio}");
    }
    // Blows at 4.4 to 4.5 bar have the measured frequency, and meet the mode at 19.9 Hz.
    let supplies = evidence(&comparison, "Intervals of blows, and the arm once the first impact has decayed");
    let last = supplies.last().expect("5 bar");
    for one in &supplies[..2] {
        assert!((one[0] - 20.5).abs() < 0.3, "{one:?}");
        assert!((1.8..2.6).contains(&(one[2] / last[2])), "{one:?} beside {last:?}");
    }
    assert!(supplies.iter().all(|one| one[1] < 0.15), "the frequency is constant: {supplies:?}");
    let remarks = |group: &Json| list(group, "remarks").iter().filter_map(Json::as_str).map(str::to_owned).collect();
    let remarks: Vec<String> =
        list(&comparison, "groups").iter().flat_map(|group| -> Vec<String> { remarks(group) }).collect();
    let begin = |words: &str| remarks.iter().filter(|remark| remark.starts_with(words)).count();
    assert_eq!((begin("Contradiction: "), begin("Unexplained: ")), (3, 1), "{remarks:#?}");
    let lines = remarks.iter().find(|remark| remark.contains("Hann window")).expect("windows are stated");
    assert!(lines.contains("rectangular window over 1.46 s"), "{lines}");
}

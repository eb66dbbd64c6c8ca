//! `decore scene --measured`: records of loggers beside the signal that they measured.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use decore_study::engine::Engine;
use serde_json::Value as Json;
use tempfile::TempDir;

const SETTINGS: [&str; 2] = ["solver.guide=tied", "duration_s=0.5"];
const SIGNAL: &str = "hammer_arm_velocity_m_s";
const VIB: &str = "hammer_arm_velocity_m_s=vib";
const INTERVAL_S: f64 = 2e-5;

/// A rig whose arm's velocity was recorded.
struct Rig {
    scratch: TempDir,
    study: PathBuf,
    velocity_m_s: Vec<f64>,
}

impl Rig {
    fn new() -> Self {
        let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/paper_rig.toml");
        let engine = Engine::load(&study, &SETTINGS.map(str::to_owned)).expect("study");
        let (_, signals) = engine.outcome_with_signals(0, INTERVAL_S).expect("row");
        let velocity = signals.expect("signals").into_iter().find(|signal| signal.name == SIGNAL).expect("signal");
        Self { scratch: TempDir::new().expect("scratch folder"), study, velocity_m_s: velocity.values }
    }

    /// Writes a record `rig.csv`: a line for each instant and value for which `line` has one.
    fn record(&self, header: &str, line: impl Fn(f64, f64) -> Option<String>) {
        let mut text = format!("{header}\n");
        for (k, value) in self.velocity_m_s.iter().enumerate() {
            if let Some(line) = line(INTERVAL_S * k as f64, *value) {
                let _ = writeln!(text, "{line}");
            }
        }
        fs::write(self.scratch.path().join("rig.csv"), text).expect("written");
    }

    /// Sets channels of the record beside their signals.
    fn beside(&self, channels: &[&str], further: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_decore"));
        command.arg("scene").arg(&self.study).args(SETTINGS.iter().flat_map(|setting| ["--set", setting]));
        command.args(["--measured", "rig.csv"]).args(channels.iter().flat_map(|channel| ["--channel", channel]));
        command.args(further).current_dir(self.scratch.path());
        command.output().expect("started")
    }

    /// What is printed of it.
    fn text(&self, channels: &[&str], further: &[&str]) -> String {
        let output = self.beside(channels, further);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).into_owned()
    }

    /// What is found of a channel.
    fn json(&self, channel: &str, further: &[&str]) -> Json {
        let text = self.text(&[channel], &[further, &["--json"]].concat());
        serde_json::from_str::<Json>(&text).expect("JSON")["measured"][0].clone()
    }

    /// Why a record is refused.
    fn refused(&self, channel: &str, further: &[&str]) -> String {
        let output = self.beside(&[channel], further);
        assert_eq!(output.status.code(), Some(2));
        String::from_utf8_lossy(&output.stderr).into_owned()
    }

    /// What is found, and the page that is drawn.
    fn found(&self) -> (Json, Json) {
        let json = self.json(VIB, &["--html", "row.html"]);
        let page = fs::read_to_string(self.scratch.path().join("row.html")).expect("page");
        let meta = page.split_once("id=\"meta\">").and_then(|(_, rest)| rest.split_once("</script>")).expect("data").0;
        (json, serde_json::from_str(meta).expect("JSON"))
    }
}

fn number(json: &Json, at: &str) -> f64 {
    json.pointer(at).and_then(Json::as_f64).expect(at)
}

#[test]
fn gaps_of_a_record_are_left_out_of_both_signals() {
    let rig = Rig::new();
    rig.record("time_s,vib", |time_s, value| {
        (!(0.25..0.35).contains(&time_s) && !(0.45..0.49).contains(&time_s)).then(|| format!("{time_s},{value}"))
    });
    let (found, page) = rig.found();
    let near = |at: &str, wanted: f64| assert!((number(&found, at) - wanted).abs() < 1e-4, "{at}: {found}");
    assert_eq!(found["pieces"].as_array().map(Vec::len), Some(3), "{found}");
    near("/pieces/0/to_s", 0.25);
    near("/pieces/1/from_s", 0.35);
    near("/pieces/2/from_s", 0.49);
    for at in ["/rms/difference", "/peak/difference", "/frequency_hz/difference"] {
        near(at, 0.0);
    }
    let phases = found["phases"].as_array().expect("phases");
    let of = |name: &str| phases.iter().find(|phase| phase["phase"] == name).expect("phase");
    // The periodic blow is one that the record has whole; of the hammering a part is missing.
    assert_eq!(number(of("periodic_blow"), "/covered"), 1.0);
    assert!(number(of("periodic_blow"), "/to_s") < 0.45, "{found}");
    assert!((number(of("hammering"), "/covered") - 0.69).abs() < 0.02, "{found}");
    assert!(phases.iter().all(|phase| number(phase, "/rms/difference").abs() < 1e-4), "{found}");
    let text = rig.text(&[VIB], &[]);
    assert!(
        text.contains("gaps of the record    2, the first from 0.2499") && text.contains("left out of both"),
        "{text}"
    );
    // Neither does the page draw over them, and its spectra are of the same time.
    let pieces = page["measured"][0]["pieces"].as_array().expect("pieces");
    assert_eq!(pieces.len(), 3, "{pieces:?}");
    let of_arm = |lines: &&Json| lines["quantity"] == "arm_velocity_m_s";
    let spectra: Vec<&Json> = page["spectra"].as_array().expect("spectra").iter().filter(of_arm).collect();
    assert_eq!(spectra.len(), 4);
    for lines in &spectra {
        assert_eq!(lines["measured"][0]["lines"]["count"], lines["count"], "{lines}");
        assert_eq!(lines["measured"][0]["lines"]["resolution_hz"], lines["resolution_hz"], "{lines}");
    }
    let hammering = spectra.iter().find(|lines| lines["phase"] == "hammering").expect("hammering");
    assert!((number(hammering, "/to_s") - 0.25).abs() < 1e-4, "{hammering}");
    assert_eq!(number(hammering, "/cut_from_s/1"), 0.5);
    assert_eq!(spectra[0]["cut_from_s"], Json::Null, "{}", spectra[0]);
}

#[test]
fn an_offset_that_is_doubtful_is_told() {
    let rig = Rig::new();
    // Times in ms, read as seconds, and read as what they are.
    rig.record("Time [ms],vib", |time_s, value| (time_s < 0.3).then(|| format!("{},{value}", 1000.0 * time_s)));
    let text = rig.text(&[VIB], &["--time-column", "Time [ms]"]);
    assert!(text.contains("warning               the best correlation is below 0.5"), "{text}");
    assert!(text.contains("`--time-column COLUMN:ms`"), "{text}");
    let text = rig.text(&[VIB], &["--time-column", "Time [ms]:ms"]);
    assert!(!text.contains("warning  ") && text.contains("(correlation 1.0000)"), "{text}");
    let error = rig.refused(VIB, &["--time-column", "Time [ms]:min"]);
    assert!(error.contains("`min` is no unit of column `Time [ms]`; known are s, ms, us"), "{error}");
    // A sensor the other way round, and its sign turned.
    rig.record("time_s,vib,right", |time_s, value| Some(format!("{},{},{value}", time_s + 2.5, -value)));
    let text = rig.text(&[VIB], &[]);
    let better = "with its sign turned the channel correlates better, by 1.0000 at an offset of 2.500000 s";
    assert!(text.contains(better) && text.contains("SIGNAL=COLUMN:-UNIT"), "{text}");
    let text = rig.text(&[&format!("{VIB}:-m/s"), "hammer_arm_velocity_m_s=right"], &[]);
    assert!(!text.contains("warning  "), "{text}");
    assert_eq!(text.matches("(correlation 1.0000)").count(), 2, "{text}");
}

#[test]
fn accelerations_are_compared_in_their_units() {
    let rig = Rig::new();
    rig.record("time_s,acc", |time_s, value| Some(format!("{time_s},{value}")));
    let measured = |unit: &str| {
        let found = rig.json(&format!("part_heave_acceleration_m_s2=acc:{unit}"), &["--offset-s", "0"]);
        number(&found, "/rms/measured")
    };
    let [si, mm, g] = ["m/s2", "mm/s2", "g"].map(measured);
    assert!(si > 0.0 && (1000.0 * mm / si - 1.0).abs() < 1e-9 && (g / si - 9.80665).abs() < 1e-9, "{si} {mm} {g}");
}

#[test]
fn files_of_loggers_are_read_or_it_is_told_what_to_do() {
    let rig = Rig::new();
    let channel = format!("{VIB}:mm/s");
    for (header, between) in [("\u{feff}time_s;vib", ";"), ("time_s\tvib", "\t")] {
        rig.record(header, |time_s, value| {
            Some(format!("{time_s:.7}{between}{:.9}", 1000.0 * value).replace('.', ","))
        });
        let found = rig.json(&channel, &[]);
        assert!(number(&found, "/rms/difference").abs() < 1e-5, "{found}");
    }
    let refused = |bytes: &[u8]| {
        fs::write(rig.scratch.path().join("rig.csv"), bytes).expect("written");
        rig.refused(&channel, &[])
    };
    for (bytes, words) in [
        (&b"time;vib\n0;1\n"[..], "has no column `time_s`; it has: time, vib"),
        (
            b"time_s,vib\n[s],[mm/s]\n0,1\n",
            "line 2, column `time_s`: expected a number, found `[s]` (remove a row of units",
        ),
        (
            b"time_s;vib\n0.5;1\n1.5;1,234\n",
            "line 3, column `vib`: expected a number, found `1,234` (a comma is read as",
        ),
        (b"time_s,vib\n0,1\n1,\n", "found `` (a sample that is missing is left out"),
        (b"\xff\xfet\0i\0", "it is text in UTF-16: save it as UTF-8"),
        (b"time_s,vib\n0,1\n1,\xf6\n", "line 3: not text in UTF-8 (Latin-1 or Windows-1252?): save it as UTF-8"),
    ] {
        let said = refused(bytes);
        assert!(said.contains(words) && !said.contains("factor_"), "{said}");
    }
}

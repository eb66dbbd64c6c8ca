//! `decore scene --measured`: records of loggers beside the signal that they measured.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use decore::engine::Engine;
use serde_json::Value as Json;
use tempfile::TempDir;

const SETTINGS: [&str; 2] = ["solver.guide=tied", "duration_s=0.5"];
const SIGNAL: &str = "hammer_arm_velocity_m_s";
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

    /// Sets the record beside the signal.
    fn beside(&self, further: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_decore"));
        command.arg("scene").arg(&self.study).args(SETTINGS.iter().flat_map(|setting| ["--set", setting]));
        let channel = format!("{SIGNAL}=vib");
        command.args(["--measured", "rig.csv", "--channel", &channel]).args(further).current_dir(self.scratch.path());
        command.output().expect("started")
    }

    /// What is printed of it.
    fn text(&self, further: &[&str]) -> String {
        let output = self.beside(further);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).into_owned()
    }

    /// What is found, and the page that is drawn.
    fn found(&self) -> (Json, Json) {
        let json: Json = serde_json::from_str(&self.text(&["--json", "--html", "row.html"])).expect("JSON");
        let page = fs::read_to_string(self.scratch.path().join("row.html")).expect("page");
        let meta = page.split_once("id=\"meta\">").and_then(|(_, rest)| rest.split_once("</script>")).expect("data").0;
        (json["measured"][0].clone(), serde_json::from_str(meta).expect("JSON"))
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
    let text = rig.text(&[]);
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

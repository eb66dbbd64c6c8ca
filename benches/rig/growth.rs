//! Growth of the cost with hammers and with modes, and the gain of a second thread.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use decore_model::run::{RowOutcome, run_row};
use decore_model::scene::{Guide, ModeTreatment, Scene, SolverSettings};
use decore_model::system::InterfaceModes;
use decore_study::engine::{ElasticCastings, Machine, SourceModel};
use decore_study::{CheckedStudy, InterfaceDemand, Study};

use crate::methods::cells;
use crate::scene::{FIGURES, Rig, errors, figures, prepare};
use crate::study_path;
use crate::timing::{Timed, exponent, interleaved};

/// Hammers, each on a casting of its own.
const HAMMERS: [usize; 5] = [1, 2, 4, 8, 16];
/// Simulated time in s of the scenes with several hammers.
const HAMMERS_DURATION_S: f64 = 0.4;
/// Points of rail and table, from the middle outwards; beyond nine, hammers share a point.
const PLACES: [usize; 9] = [5, 6, 4, 7, 3, 8, 2, 9, 1];
/// Modes kept.
const MODES: [usize; 6] = [10, 30, 60, 120, 250, 500];
/// Time in s by which each hammer starts after the one before: none of their events coincide.
const STAGGER_S: f64 = 1.37e-3;
/// Rows of the sweep that two threads share, half of the shipped study: starting and waiting for the last row cost about one per
/// cent of it.
const SWEEP_ROWS: usize = 120;
/// Speed of two threads over that of one to be reached.
const THREADS_GOAL: f64 = 1.9;

/// The rig with all modes of its structure.
pub fn all_modes() -> Rig {
    prepare(&study_path(), &["structure.cutoff_hz=1e9", "structure.fixed_interface_cutoff_hz=1e9"])
}

/// `count` hammers under the rail's points, each over a casting of its own on one fixture of the table, 60 modes; `setting` of the
/// shipped study.
fn hammers(count: usize, setting: &str) -> Rig {
    let study = Study::load(&study_path()).and_then(|study| study.with_overrides(&[setting.to_owned()]));
    let study = study.expect("the shipped study");
    let model = SourceModel::read(study.structure()).expect("the built-in station");
    let points = model.points();
    let names = |role: &str| (1..=9).map(|i| format!("{role}{i}")).collect::<Vec<_>>();
    let demand = InterfaceDemand { mounts: names("R"), others: names("T"), sideways: false };
    let machine =
        Machine::new(model, study.structure(), (&demand, &ElasticCastings::default())).expect("its reduction");
    let checked = CheckedStudy::new(study, points).expect("its points");
    let single = checked.scene(0).expect("its scene");
    let place = |h: usize| PLACES[h % PLACES.len()];
    let mut scene =
        Scene { hammers: Vec::new(), castings: Vec::new(), duration_s: HAMMERS_DURATION_S, ..single.clone() };
    for h in 0..count {
        let mut unit = single.hammers[0].clone();
        unit.casting = h;
        unit.start_time_s += STAGGER_S * h as f64;
        unit.mount.points = vec![(format!("R{}", place(h)), 1.0)];
        let mut casting = single.castings[0].clone();
        casting.fixtures[0].point = format!("T{}", place(h));
        scene.hammers.push(unit);
        scene.castings.push(casting);
    }
    let mut modes = InterfaceModes::clone(&machine.modes(&scene).expect("its modes"));
    keep(&mut modes, 60);
    Rig { scene, modes }
}

/// Drops all but the first modes.
fn keep(modes: &mut InterfaceModes, count: usize) {
    modes.omega_rad_s.truncate(count);
    modes.damping_ratio.truncate(count);
    modes.shapes.values_mut().for_each(|row| row.truncate(count));
}

fn tied(rig: &Rig, modes: ModeTreatment) -> Scene {
    let solver = SolverSettings { guide: Guide::Tied, tolerance: 1e-5, modes, ..rig.scene.solver };
    Scene { solver, ..rig.scene.clone() }
}

/// The tables of hammers, for the presets' guides and tolerances.
pub fn hammers_text(text: &mut String, repeats: usize) {
    let _ = writeln!(
        text,
        "\n## Growth with hammers\n\n60 modes, {HAMMERS_DURATION_S} s; hammers at the points of the rail, each over a casting of its own on one \
         fixture, starting {:.2} ms after one another\nso that no events coincide.",
        1e3 * STAGGER_S
    );
    for (name, setting) in [
        ("Guides on their springs, 1e-5", "solver.guide=spring"),
        ("`standard`, the default: guides tied, 1e-5", "solver.fidelity=standard"),
        ("`draft`: guides tied, 1e-4", "solver.fidelity=draft"),
    ] {
        let _ = writeln!(text, "\n{name}:\n");
        let rigs = HAMMERS.map(|count| hammers(count, setting));
        let timed = interleaved(repeats, &rigs, |rig| run_row(&rig.scene, &rig.modes));
        let fitted = hammers_table(text, &timed);
        let verdict = if fitted <= 1.05 { "met" } else { "**missed**" };
        let _ = writeln!(text, "\nExponent over all rows: {fitted:.2} (aim: 1, {verdict}).");
    }
}

/// One table of hammers; returns the exponent of its times.
fn hammers_table(text: &mut String, timed: &[Timed<RowOutcome>]) -> f64 {
    let _ = writeln!(
        text,
        "| hammers | states | ms per s | per hammer | steps | us per hammer and step | events |\n|---|---|---|---|---|---|---|"
    );
    let mut points = Vec::new();
    for (count, timed) in HAMMERS.iter().zip(timed) {
        let ms = 1e3 * timed.cpu_s / HAMMERS_DURATION_S;
        points.push((*count as f64, ms));
        let work = &timed.value.counters;
        let _ = writeln!(
            text,
            "| {count} | {} | {ms:.0} | {:.0} | {} | {:.1} | {} |",
            timed.value.states,
            ms / *count as f64,
            work.steps,
            1e6 * timed.cpu_s / (work.steps * *count as u64) as f64,
            work.located_events
        );
    }
    exponent(&points)
}

/// The table of modes: cost, and what the modes left out cost in accuracy against all of them.
pub fn modes_text(text: &mut String, all: &Rig, repeats: usize) {
    let total = all.modes.omega_rad_s.len();
    let cut = |count: usize| {
        let mut modes = all.modes.clone();
        keep(&mut modes, count);
        Rig { scene: all.scene.clone(), modes }
    };
    let cases: Vec<(usize, Rig)> = MODES.iter().filter(|&&count| count <= total).map(|&c| (c, cut(c))).collect();
    let of =
        |treatment: ModeTreatment| interleaved(repeats, &cases, |(_, rig)| run_row(&tied(rig, treatment), &rig.modes));
    let (automatic, integrated) = (of(ModeTreatment::Automatic), of(ModeTreatment::Integrated));
    let mut fine = tied(all, ModeTreatment::Automatic);
    fine.solver.tolerance = 1e-6;
    let exact = figures(run_row(&fine, &all.modes).metrics.as_ref().expect("the run with all modes"));
    let _ = writeln!(
        text,
        "\n## Growth with modes\n\nGuide tied, tolerance 1e-5. Errors are against all {total} modes of the full structure (guide tied, 1e-6): the \
         modes left out, not the integration.\n\n| modes | ms per s | modes integrated | {} |\n|---|---|---|---|---|---|---|",
        FIGURES.join(" | ")
    );
    let (mut first, mut second) = (Vec::new(), Vec::new());
    for (((count, rig), a), b) in cases.iter().zip(&automatic).zip(&integrated) {
        let [a_ms, b_ms] = [a.cpu_s, b.cpu_s].map(|cpu_s| 1e3 * cpu_s / rig.scene.duration_s);
        first.push((*count as f64, a_ms));
        second.push((*count as f64, b_ms));
        let found = a.value.metrics.as_ref().map_or([f64::NAN; 4], figures);
        let _ = writeln!(text, "| {count} | {a_ms:.1} | {b_ms:.1} | {} |", cells(&errors(&found, &exact)));
    }
    selected_row(text, repeats, &exact);
    let (a, b) = (exponent(&first), exponent(&second));
    let last = |points: &[(f64, f64)]| exponent(&points[points.len().saturating_sub(2)..]);
    let _ = writeln!(
        text,
        "\nExponents over all rows: {a:.2}, with modes integrated {b:.2} (aim: at most 1); over the last two, where the fastest mode \
         bounds the step: {:.2} and\n{:.2}. The last row is `structure.mode_tolerance = 1e-2`: the modes that the scene needs and \
         residual modes for the others.",
        last(&first),
        last(&second)
    );
}

/// The row of modes selected for the scene, out of all that the structure has.
fn selected_row(text: &mut String, repeats: usize, exact: &[f64; 4]) {
    let settings = ["structure.mode_tolerance=1e-2", "structure.fixed_interface_cutoff_hz=1e9"];
    let cases = [prepare(&study_path(), &settings)];
    let of = |treatment| interleaved(repeats, &cases, |rig| run_row(&tied(rig, treatment), &rig.modes));
    for (a, b) in of(ModeTreatment::Automatic).iter().zip(of(ModeTreatment::Integrated)) {
        let [a_ms, b_ms] = [a.cpu_s, b.cpu_s].map(|cpu_s| 1e3 * cpu_s / cases[0].scene.duration_s);
        let found = a.value.metrics.as_ref().map_or([f64::NAN; 4], figures);
        let count = a.value.modes;
        let _ = writeln!(text, "| {count}, selected | {a_ms:.1} | {b_ms:.1} | {} |", cells(&errors(&found, exact)));
    }
}

/// Wall time in s of a sweep of the shipped Latin hypercube.
fn sweep_s(threads: usize) -> Option<f64> {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("bench-rig-{threads}"));
    let summary = folder.with_extension("json");
    let status = Command::new(env!("CARGO_BIN_EXE_decore"))
        .arg("run")
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/placement.toml"))
        .args([
            "--replace",
            "--threads",
            &threads.to_string(),
            "--set",
            &format!("design.rows={SWEEP_ROWS}"),
            "--output",
        ])
        .arg(&folder)
        .arg("--summary")
        .arg(&summary)
        .stderr(std::process::Stdio::null())
        .stdout(std::process::Stdio::null())
        .status();
    if !status.ok()?.success() {
        return None;
    }
    let summary: serde_json::Value = serde_json::from_slice(&std::fs::read(&summary).ok()?).ok()?;
    summary["wall_time_s"].as_f64()
}

/// Two threads against one, in turns; the least time of each counts, because only wall time shows it.
pub fn threads_text(text: &mut String, repeats: usize) {
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    let load = load.split_whitespace().next().unwrap_or("not known").to_owned();
    let mut least = [f64::INFINITY; 2];
    for _ in 0..repeats {
        for threads in [1, 2] {
            least[threads - 1] = least[threads - 1].min(sweep_s(threads).unwrap_or(f64::INFINITY));
        }
    }
    let ratio = least[0] / least[1];
    let verdict = if ratio >= THREADS_GOAL { "met" } else { "**missed**" };
    let _ = writeln!(
        text,
        "\n## Two threads\n\n{SWEEP_ROWS} rows of `studies/placement.toml`: {:.1} s on one thread, {:.1} s on two, **{ratio:.2} times** the \
         speed (goal {THREADS_GOAL}: {verdict}). Wall times, the least of\n{repeats}; other work on the machine shows: its load was {load} \
         before.",
        least[0], least[1]
    );
}

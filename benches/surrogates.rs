//! Surrogates beside those of SMT and egobox at their own defaults, of the same rows in the same run. Writes its section of
//! `benches/RESULTS.md`. `DECORE_PYTHON`: a Python with smt and egobox, for the comparison; `DECORE_ROWS`: sizes of
//! the tables, by default `60,240`; 960 takes long.

#[path = "support/cases.rs"]
mod cases;
#[path = "support/scenes.rs"]
mod scenes;
mod support;

use std::fmt::Write;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use cases::{BOREHOLE, Function, G, ISHIGAMI, OTL, median, plain_hypercube, q2, sobol};
use decore_math::random::hash;
use decore_statistics::regression::{GaussianProcess, Points};
use rayon::prelude::*;
use scenes::{Scene, scenes};

/// Tables of each case that all programs see, other ones each: of up to 240 rows, and of more, as SMT takes minutes.
const REPEATS: [u64; 2] = [3, 1];
/// Tables of each case whose intervals are counted: of up to 60, up to 240 and more rows. One table of 60 rows says its own share to five
/// in a hundred at best.
const COUNTED: [(usize, u64); 3] = [(60, 40), (240, 10), (usize::MAX, 2)];
/// Rows that no model knows.
const NEW_ROWS: usize = 1000;
/// What Q2 may fall short of the better of the others.
const SHORT: f64 = 0.005;
/// Shares of the new rows that 95 % intervals may hold.
const COVERAGE: [f64; 2] = [0.92, 0.98];

/// A table and rows that it does not have.
struct Case {
    name: String,
    known: [Part; 2],
}

/// Rows and their values.
struct Part {
    points: Points,
    values: Vec<f64>,
}

/// What a model of a table is worth.
#[derive(Clone, Copy, serde::Deserialize)]
struct Worth {
    q2: f64,
    coverage: f64,
    fit_s: f64,
}

fn of_function(function: &Function, rows: usize, repeat: u64) -> Case {
    let part = |points: Points| Part { values: function.values(&points), points };
    let known = plain_hypercube(rows, function.factors, repeat);
    let known = [part(known), part(sobol(NEW_ROWS, function.factors, 1000 + repeat))];
    Case { name: format!("{}, {rows} rows", function.name), known }
}

/// Some rows of a scene; the others are new.
fn of_scene(scene: &Scene, output: usize, (rows, repeat): (usize, u64)) -> Case {
    let mut order: Vec<usize> = (0..scene.points.rows()).collect();
    order.sort_by_key(|row| hash(repeat, 0, *row as u64));
    let (name, values) = &scene.outputs[output];
    let part = |rows: &[usize]| Part {
        points: scene.points.select(rows),
        values: rows.iter().map(|row| values[*row]).collect(),
    };
    let known = [part(&order[..rows]), part(&order[rows..])];
    Case { name: format!("{} `{name}`, {rows} rows", scene.name), known }
}

/// Ours: `fit_s` is the fit without the folds that intervals of few rows come from; those are told beside it.
fn ours(case: &Case) -> (Worth, f64) {
    let [known, new] = &case.known;
    let start = Instant::now();
    let model = GaussianProcess::fit(&known.points, &known.values).expect("a model");
    let fit_s = start.elapsed().as_secs_f64();
    let folds = model.folds().expect("folds");
    let with_folds_s = start.elapsed().as_secs_f64();
    let reach = folds.as_ref().unwrap_or(model.residuals()).reach(0.95);
    let predicted = model.predict(&new.points).expect("predictions");
    let inside = predicted.iter().zip(&new.values).filter(|(at, truth)| (at.mean - *truth).abs() <= reach * at.std_dev);
    let coverage = inside.count() as f64 / new.values.len() as f64;
    let means: Vec<f64> = predicted.iter().map(|at| at.mean).collect();
    (Worth { q2: q2(&new.values, &means), coverage, fit_s }, with_folds_s)
}

/// Those of SMT and egobox, case by case.
fn theirs(python: &str, cases: &[Case]) -> Vec<[Worth; 2]> {
    let part = |Part { points, values }: &Part| {
        let rows: Vec<&[f64]> = (0..points.rows()).map(|row| points.row(row)).collect();
        serde_json::json!([rows, values])
    };
    let tables: Vec<serde_json::Value> = cases.iter().map(|case| case.known.iter().map(part).collect()).collect();
    let scratch = tempfile::tempdir().expect("scratch folder");
    let file = scratch.path().join("cases.json");
    std::fs::write(&file, serde_json::to_vec(&tables).expect("JSON")).expect("written");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/surrogates_reference.py");
    let mut command = Command::new(python);
    // Numerical libraries of Python take the whole machine otherwise, and small products then wait for each other.
    command.envs(["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "RAYON_NUM_THREADS"].map(|name| (name, "1")));
    let output = command.arg(script).arg(&file).output().expect("Python runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

fn main() {
    let Ok(python) = std::env::var("DECORE_PYTHON") else {
        eprintln!("DECORE_PYTHON is not set: a Python with smt and egobox is needed for the comparison");
        return;
    };
    let sizes = std::env::var("DECORE_ROWS").unwrap_or_else(|_| "60,240".to_owned());
    let sizes = sizes.split(',').map(|size| size.trim().parse::<usize>().expect("DECORE_ROWS: numbers of rows"));
    let scenes = scenes();
    let mut text = format!(
        "# Surrogates beside SMT and egobox\n\nWritten by `cargo bench --bench surrogates`: the Gaussian process of `decore surrogate` \
         beside `smt.surrogate_models.KRG` and `egobox.Gpx` at their own defaults, of the same tables. Functions: Latin \
         hypercubes as studies have them by default and {NEW_ROWS} new Sobol' points; scenes: some of 1100 rows that were run, the others are \
         new. Medians of {} tables of up to 240 rows, {} of more; of decore's intervals the mean of {} tables of 60 rows, {} of 240 and {} of more, \
         with the least and the most. Q2 and the share that 95 % intervals hold are those of the new rows; SMT's and egobox's intervals \
         are 1.96 of their standard deviations. Times are wall times of the fit in this run, each program on one thread, SMT's and egobox's over \
         decore's; in brackets with the folds that decore's intervals come from. The machine had other work besides, so that only ratios \
         mean something.\n\n\
         | table | Q2 decore | SMT | egobox | held, % | SMT | egobox | decore, s | SMT / decore | egobox / decore |\n\
         |---|---|---|---|---|---|---|---|---|---|\n",
        REPEATS[0], REPEATS[1], COUNTED[0].1, COUNTED[1].1, COUNTED[2].1
    );
    let mut missed = Vec::new();
    for rows in sizes {
        let repeats = if rows > 240 { REPEATS[1] } else { REPEATS[0] };
        let counted = COUNTED.iter().find(|(most, _)| rows <= *most).map_or(1, |(_, tables)| *tables);
        let mut makers: Vec<Box<dyn Fn(u64) -> Case + Sync>> = Vec::new();
        for function in [ISHIGAMI, G, OTL, BOREHOLE] {
            makers.push(Box::new(move |repeat| of_function(&function, rows, repeat)));
        }
        for scene in scenes.iter().filter(|scene| scene.points.rows() > rows + 100) {
            for output in 0..scene.outputs.len() {
                makers.push(Box::new(move |repeat| of_scene(scene, output, (rows, repeat))));
            }
        }
        for maker in makers {
            let cases: Vec<Case> = (0..repeats).map(&maker).collect();
            let held = (0..counted).into_par_iter().map(|repeat| ours(&maker(repeat)).0.coverage).collect::<Vec<f64>>();
            let (line, fault) = compared(&python, &cases, &held);
            eprint!("{line}");
            text += &line;
            missed.extend(fault);
        }
    }
    let _ = match missed.is_empty() {
        true => writeln!(
            text,
            "\nNowhere is Q2 more than {SHORT} below the better of both, or a coverage outside 92 to 98 %."
        ),
        false => writeln!(text, "\nMissed: {}.", missed.join("; ")),
    };
    print!("{text}");
    support::write_section("surrogates", &text);
}

/// The line of the table, and what is missed; `shares`: what the intervals of each counted table hold.
fn compared(python: &str, cases: &[Case], shares: &[f64]) -> (String, Option<String>) {
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    let own: Vec<(Worth, f64)> = alone.install(|| cases.iter().map(ours).collect());
    let others = theirs(python, cases);
    let middle = |of: &dyn Fn(usize) -> f64| median((0..cases.len()).map(of).collect());
    let [q2, time] = [middle(&|case| own[case].0.q2), middle(&|case| own[case].0.fit_s)];
    let held = shares.iter().sum::<f64>() / shares.len() as f64;
    let least = shares.iter().copied().fold(f64::INFINITY, f64::min);
    let most = shares.iter().copied().fold(0.0, f64::max);
    let with_folds = middle(&|case| own[case].1);
    let [smt, egobox] = [0, 1].map(|program| {
        let of = |worth: &dyn Fn(&Worth) -> f64| middle(&|case| worth(&others[case][program]));
        Worth { q2: of(&|worth| worth.q2), coverage: of(&|worth| worth.coverage), fit_s: of(&|worth| worth.fit_s) }
    });
    let name = &cases[0].name;
    let line = format!(
        "| {name} | {q2:.4} | {:.4} | {:.4} | {:.1} ({:.1} to {:.1}) | {:.1} | {:.1} | {time:.2} ({with_folds:.2}) | {:.1} | {:.1} |\n",
        smt.q2,
        egobox.q2,
        100.0 * held,
        100.0 * least,
        100.0 * most,
        100.0 * smt.coverage,
        100.0 * egobox.coverage,
        smt.fit_s / time,
        egobox.fit_s / time
    );
    let mut faults = Vec::new();
    if q2 < smt.q2.max(egobox.q2) - SHORT {
        faults.push(format!("Q2 {q2:.4} where {:.4} is the better", smt.q2.max(egobox.q2)));
    }
    if !(COVERAGE[0]..=COVERAGE[1]).contains(&held) {
        faults.push(format!("intervals hold {:.1} %", 100.0 * held));
    }
    if time > smt.fit_s.min(egobox.fit_s) {
        faults.push(format!("time {time:.2} s where {:.2} s is the less", smt.fit_s.min(egobox.fit_s)));
    }
    (line, (!faults.is_empty()).then(|| format!("{name}: {}", faults.join(", "))))
}

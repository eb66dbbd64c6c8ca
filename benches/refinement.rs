//! Refinement beside maximin hypercubes and egobox' optimiser. Writes its section of `benches/RESULTS.md`. `DECORE_PYTHON`: a Python
//! with egobox, for the comparison.

#[path = "support/cases.rs"]
mod cases;
#[path = "support/scenes.rs"]
mod scenes;
mod support;

use std::fmt::Write;
use std::path::Path;
use std::process::Command;

use cases::{BOREHOLE, Function, G, ISHIGAMI, OTL, hypercube, median, q2, sobol};
use decore_lab::refinement::{
    CAUTIOUS, LEAST_DISTANCE, Learned, SHARP_NOISE, Seeking, Side, highest_peak, improving, is_apart, learning,
};
use decore_math::random::{hash, uniform};
use decore_statistics::regression::{GaussianProcess, Places, Points, RegressionError};
use rayon::prelude::*;
use scenes::scenes;

/// Seeds.
const SEEDS: u64 = 20;
/// Q2 of new rows that is sought.
const TARGET: f64 = 0.95;
/// Rows at a time, as `decore refine` has it.
const BATCH: usize = 4;
/// Rows at most.
const MOST: usize = 100;
/// Places among which rows are chosen, as in `decore refine`: to learn, to optimise, near the best for each reach.
const PLACES: [usize; 3] = [512, 2048, 512];
/// How far the latter lie from the best row.
const REACHES: [f64; 3] = [0.1, 0.02, 0.004];
/// Share of a hypercube's rows that is the goal on two of three.
const GOAL: f64 = 0.7;

/// Values at places.
type Values<'a> = dyn Fn(&Points) -> Vec<f64> + Sync + 'a;

/// What is asked for a value.
struct Truth<'a> {
    name: String,
    factors: usize,
    at: Box<Values<'a>>,
}

fn of_function(function: Function) -> Truth<'static> {
    let at = move |places: &Points| function.values(places);
    Truth { name: function.name.to_owned(), factors: function.factors, at: Box::new(at) }
}

/// Rows at which Q2 of new rows is at least [`TARGET`] for the first time; [`MOST`] where it is not.
fn rows_needed(truth: &Truth<'_>, seed: u64, refined: bool) -> usize {
    let new = sobol(1000, truth.factors, 5000 + seed);
    let expected = (truth.at)(&new);
    let start = 3 * truth.factors.max(4);
    let mut points = hypercube(start, truth.factors, seed);
    while points.rows() < MOST {
        let model = GaussianProcess::fit(&points, &(truth.at)(&points)).expect("a model");
        let means: Vec<f64> = model.predict(&new).expect("predictions").iter().map(|at| at.mean).collect();
        if q2(&expected, &means) >= TARGET {
            break;
        }
        let rows = points.rows() + BATCH;
        if refined {
            let candidates = sobol(PLACES[0], truth.factors, hash(seed, rows as u64, 0));
            let learned = Learned { process: &model, success: vec![1.0; candidates.rows()], boundary: None };
            let chosen = learning(&[learned], &candidates, BATCH).expect("rows");
            points = points.with(&candidates.select(&chosen)).expect("rows");
        } else {
            points = hypercube(rows, truth.factors, seed);
        }
    }
    points.rows()
}

/// What rows gave, and where the next one may lie: the criterion of `decore refine --minimise`.
struct Sought<'a> {
    model: &'a GaussianProcess,
    best: f64,
    share: f64,
    rows: &'a [Vec<f64>],
}

impl Sought<'_> {
    fn merits(&self, places: &Points) -> Vec<f64> {
        let seeking =
            Seeking { process: self.model, side: Side::Least, limits: &[], best: Some(self.best), share: self.share };
        let merits = improving(&seeking, places).expect("merits").into_iter().enumerate();
        merits
            .map(
                |(place, merit)| {
                    if is_apart(places.row(place), self.rows, LEAST_DISTANCE) { merit } else { f64::NEG_INFINITY }
                },
            )
            .collect()
    }

    /// The highest of the peaks near the best candidates.
    fn peak(&self, candidates: &Points) -> Vec<f64> {
        let places: Vec<Vec<f64>> = (0..candidates.rows()).map(|place| candidates.row(place).to_vec()).collect();
        let mut near = |places: &[Vec<f64>]| {
            // Points of no rows there are none.
            if places.is_empty() {
                return Ok(Vec::new());
            }
            Ok(self.merits(&Points::new(places.concat(), candidates.nominal().to_vec())?))
        };
        let peak = highest_peak::<RegressionError>((&places, &self.merits(candidates)), &mut near);
        peak.expect("merits").expect("a peak").at
    }
}

/// The least value after so many rows, one at a time after the first.
fn least(function: &Function, seed: u64, (start, rows): (usize, usize)) -> f64 {
    let mut points = hypercube(start, function.factors, seed);
    while points.rows() < rows {
        let values = function.values(&points);
        let model = Places::new(&points, &values)
            .and_then(|places| GaussianProcess::fit_above(&places, SHARP_NOISE))
            .expect("a model");
        let best = (0..values.len()).fold(0, |best, row| if values[row] < values[best] { row } else { best });
        let key = hash(seed, points.rows() as u64, 1);
        let mut candidates = sobol(PLACES[1], function.factors, key);
        for (stage, reach) in REACHES.into_iter().enumerate() {
            let near = |place: usize| {
                let number = (place % function.factors, place / function.factors);
                let moved = 2.0 * uniform(hash(key, stage as u64, number.1 as u64), 0, number.0 as u64) - 1.0;
                (points.row(best)[number.0] + reach * moved).clamp(0.0, 1.0)
            };
            let near = (0..PLACES[2] * function.factors).map(near).collect();
            let near = Points::new(near, vec![false; function.factors]).expect("points");
            candidates = candidates.with(&near).expect("places");
        }
        let expected = model.predict(&points).expect("predictions").into_iter().map(|at| at.mean);
        let share = if points.rows().is_multiple_of(2) { 1.0 } else { CAUTIOUS };
        let rows: Vec<Vec<f64>> = (0..points.rows()).map(|row| points.row(row).to_vec()).collect();
        let sought = Sought { model: &model, best: expected.fold(f64::INFINITY, f64::min), share, rows: &rows };
        let next = Points::new(sought.peak(&candidates), vec![false; function.factors]).expect("a place");
        points = points.with(&next).expect("a row");
    }
    function.values(&points).into_iter().fold(f64::INFINITY, f64::min)
}

/// Branin's function over [-5, 10] x [0, 15]; least value 0.397887.
const BRANIN: Function = Function { name: "Branin", factors: 2, at: branin };
/// Hartmann's function of six factors; least value -3.32237.
const HARTMANN: Function = Function { name: "Hartmann 6", factors: 6, at: hartmann };

fn branin(x: &[f64]) -> f64 {
    let (a, b) = (15.0 * x[0] - 5.0, 15.0 * x[1]);
    let pi = std::f64::consts::PI;
    (b - 5.1 / (4.0 * pi * pi) * a * a + 5.0 / pi * a - 6.0).powi(2) + 10.0 * (1.0 - 1.0 / (8.0 * pi)) * a.cos() + 10.0
}

fn hartmann(x: &[f64]) -> f64 {
    let steep = [
        [10.0, 3.0, 17.0, 3.5, 1.7, 8.0],
        [0.05, 10.0, 17.0, 0.1, 8.0, 14.0],
        [3.0, 3.5, 1.7, 10.0, 17.0, 8.0],
        [17.0, 8.0, 0.05, 10.0, 0.1, 14.0],
    ];
    let middles = [
        [0.1312, 0.1696, 0.5569, 0.0124, 0.8283, 0.5886],
        [0.2329, 0.4135, 0.8307, 0.3736, 0.1004, 0.9991],
        [0.2348, 0.1451, 0.3522, 0.2883, 0.3047, 0.6650],
        [0.4047, 0.8828, 0.8732, 0.5743, 0.1091, 0.0381],
    ];
    let well = |(steep, middle): (&[f64; 6], &[f64; 6])| {
        let off: f64 = (0..6).map(|factor| steep[factor] * (x[factor] - middle[factor]).powi(2)).sum();
        (-off).exp()
    };
    let depths = [1.0, 1.2, 3.0, 3.2];
    -steep.iter().zip(&middles).zip(depths).map(|(pair, depth)| depth * well(pair)).sum::<f64>()
}

/// The least values that egobox' Egor finds, seed by seed.
fn egor(python: &str, function: &Function, (start, rows): (usize, usize)) -> Vec<f64> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/refinement_reference.py");
    let arguments = [function.name.to_owned(), start.to_string(), rows.to_string(), SEEDS.to_string()];
    let output = Command::new(python).arg(script).args(arguments).output().expect("Python runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

/// The lines of what learning needs, and how many reach the goal.
fn learnt(truths: &[Truth<'_>]) -> String {
    let mut text = String::new();
    for truth in truths {
        let needed = |refined: bool| -> Vec<usize> {
            (0..SEEDS).into_par_iter().map(|seed| rows_needed(truth, seed, refined)).collect()
        };
        let [spread, refined] = [false, true].map(needed);
        let middle = |rows: &[usize]| median(rows.iter().map(|rows| *rows as f64).collect());
        let ends = |rows: &[usize]| [rows.iter().min(), rows.iter().max()].map(|end| end.copied().unwrap_or_default());
        let share = middle(&refined) / middle(&spread);
        let ([low, high], [least, most]) = (ends(&spread), ends(&refined));
        let line = format!(
            "| {} | {} | {} ({low} to {high}) | {} ({least} to {most}) | {:.0} % |{}\n",
            truth.name,
            truth.factors,
            middle(&spread),
            middle(&refined),
            100.0 * share,
            if share <= GOAL { " reached |" } else { " |" }
        );
        eprint!("{line}");
        text += &line;
    }
    text
}

fn main() {
    let scenes = scenes();
    let mut truths: Vec<Truth<'_>> = Vec::new();
    for scene in &scenes {
        for (name, values) in &scene.outputs {
            let model = GaussianProcess::fit(&scene.points, values).expect("a model");
            let at = move |places: &Points| -> Vec<f64> {
                model.predict(places).expect("predictions").iter().map(|at| at.mean).collect()
            };
            let factors = scene.points.factors();
            truths.push(Truth { name: format!("{} `{name}`", scene.name), factors, at: Box::new(at) });
        }
    }
    truths.extend([ISHIGAMI, G, OTL, BOREHOLE].map(of_function));
    let mut text = format!(
        "# Refinement beside hypercubes and egobox' optimiser\n\nWritten by `cargo bench --bench refinement`, {SEEDS} seeds each.\n\n\
         Rows until a model predicts {TARGET} of the variance of 1000 new Sobol' points (median, least and most): maximin Latin \
         hypercubes of 3 rows for each factor (at least 12) and {BATCH} more each, and the same first rows with batches of {BATCH} by the \
         criterion of `decore refine --learn`. For the scenes, the truth is the expected value of a model of their 1100 rows, so that it \
         has no noise. The goal is {:.0} % on two of three. At most {MOST} rows.\n\n\
         | what | factors | hypercube | refined | share | |\n|---|---|---|---|---|---|\n",
        100.0 * GOAL
    );
    text += &learnt(&truths);
    let python = std::env::var("DECORE_PYTHON").ok();
    if let Some(python) = &python {
        text += "\nLeast value found by as many evaluations (median, worst), one row at a time after the first ones, beside `egobox.Egor` at \
                 its own defaults with as many first rows:\n\n| function | rows | of them first | decore | Egor |\n|---|---|---|---|---|\n";
        for (function, start, rows) in [(BRANIN, 8, 30), (HARTMANN, 14, 60)] {
            let ours: Vec<f64> = (0..SEEDS).into_par_iter().map(|seed| least(&function, seed, (start, rows))).collect();
            let theirs = egor(python, &function, (start, rows));
            let figures = |found: Vec<f64>| {
                let worst = found.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                format!("{:.5}, {worst:.5}", median(found))
            };
            let line = format!("| {} | {rows} | {start} | {} | {} |\n", function.name, figures(ours), figures(theirs));
            eprint!("{line}");
            let _ = write!(text, "{line}");
        }
    }
    print!("{text}");
    if python.is_some() {
        support::write_section("refinement", &text);
    }
}

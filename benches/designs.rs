//! Designs: optimised Latin hypercubes against other programs, and the time of a million rows. Writes its section of
//! `benches/RESULTS.md`. `DECORE_PYTHON`: a Python with scipy, smt and openturns, for the comparison.

mod support;

use std::fmt::Write;
use std::path::Path;
use std::process::Command;

use cpu_time::ThreadTime;
use decore_model::structure::peak_memory_bytes;
use decore_statistics::design::{
    Design, Distribution, Factor, Halton, HypercubeKind, Kind, LatinHypercube, Morris, Placement, Quality, Random,
    Saltelli, Sobol,
};

/// Factors, points, best known squared distance on whole levels (spacefillingdesigns.nl), OpenTURNS' annealing steps.
const SIZES: [(usize, usize, f64, u64); 6] = [
    (2, 10, 10.0, 20_000),
    (3, 20, 66.0, 20_000),
    (4, 30, 234.0, 20_000),
    (6, 50, 1218.0, 50_000),
    (8, 80, 4695.0, 50_000),
    (10, 100, 10_233.0, 50_000),
];
/// The goal: distance relative to the best known, of every seed, up to so many points.
const GOAL: (f64, usize) = (0.99, 50);

/// CPU seconds of this thread.
fn cpu_s() -> f64 {
    ThreadTime::now().as_duration().as_secs_f64()
}

fn cube(factors: usize) -> Vec<Factor> {
    vec![Factor { distribution: Distribution::Uniform { low: 0.0, high: 1.0 }, levels: None }; factors]
}

fn hypercube(factors: usize, rows: usize, kind: HypercubeKind, seed: u64) -> (Quality, f64) {
    let spec = LatinHypercube { rows, kind, placement: Placement::Centred, ..LatinHypercube::default() };
    let start = cpu_s();
    let design = Design::new(Kind::LatinHypercube(spec), cube(factors), seed).expect("a design");
    let seconds = cpu_s() - start;
    (Quality::of(&design).expect("factors"), seconds)
}

/// Returns the CPU seconds of a maximin design and of one of small discrepancy.
fn ours(table: &mut String, (factors, rows, known, _): (usize, usize, f64, u64)) -> [f64; 2] {
    let runs: Vec<(Quality, f64)> = (0..3).map(|seed| hypercube(factors, rows, HypercubeKind::Maximin, seed)).collect();
    let shares: Vec<f64> = runs.iter().map(|(q, _)| q.minimum_distance * rows as f64 / known.sqrt()).collect();
    let mean_s = runs.iter().map(|(_, s)| s).sum::<f64>() / 3.0;
    let (least, most) = (shares.iter().copied().fold(2.0, f64::min), shares.iter().copied().fold(0.0, f64::max));
    if rows <= GOAL.1 && least < GOAL.0 {
        eprintln!("goal missed: ({factors}, {rows}) reaches {least:.3}, not {}", GOAL.0);
    }
    let (quality, seconds) = hypercube(factors, rows, HypercubeKind::CentredDiscrepancy, 0);
    let _ = writeln!(
        table,
        "| {factors}, {rows} | decore maximin | {least:.3} to {most:.3} (3 seeds) | | {mean_s:.2} | 1 |"
    );
    let _ = writeln!(
        table,
        "| {factors}, {rows} | decore centred discrepancy | | {:.3e} | {seconds:.2} | 1 |",
        quality.centred_discrepancy
    );
    [mean_s, seconds]
}

fn others(table: &mut String, python: &str, size: (usize, usize, f64, u64), budgets_s: [f64; 2]) {
    let (factors, rows, known, steps) = size;
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/designs_reference.py");
    let argument = format!("{factors},{rows},{steps},{},{}", budgets_s[0], budgets_s[1]);
    let output = Command::new(python).arg(script).arg(argument).output().expect("Python runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for line in String::from_utf8_lossy(&output.stdout).lines() {
        let Ok((tool, criterion, _, _, value, seconds, runs)) =
            serde_json::from_str::<(String, String, usize, usize, f64, f64, u32)>(line)
        else {
            continue;
        };
        let (distance, discrepancy) = match criterion.as_str() {
            "distance" => (format!("{:.3}", value / known.sqrt()), String::new()),
            _ => (String::new(), format!("{value:.3e}")),
        };
        let _ = writeln!(table, "| {factors}, {rows} | {tool} | {distance} | {discrepancy} | {seconds:.2} | {runs} |");
    }
}

fn million(table: &mut String) {
    let hypercube = LatinHypercube { rows: 1_000_000, ..LatinHypercube::default() };
    for (name, kind) in [
        ("Sobol', scrambled", Kind::Sobol(Sobol { rows: 1_000_000, scramble: true })),
        ("Halton, scrambled", Kind::Halton(Halton { rows: 1_000_000, scramble: true })),
        ("Latin hypercube", Kind::LatinHypercube(hypercube)),
        ("random", Kind::Random(Random { rows: 1_000_000 })),
        ("Saltelli", Kind::Saltelli(Saltelli { base: 1_000_000 / 22 + 1, second_order: false })),
        ("Morris", Kind::Morris(Morris { trajectories: 1_000_000 / 21 + 1, levels: 4 })),
    ] {
        let start = cpu_s();
        let design = Design::new(kind, cube(20), 1).expect("a design");
        let mut sum = 0.0;
        for row in 0..1_000_000 {
            sum += design.row(row).map_or(0.0, |row| row.len() as f64);
        }
        assert_eq!(sum, 2e7);
        let _ = writeln!(table, "| {name} | {:.2} |", cpu_s() - start);
    }
}

fn main() {
    let mut text = String::from(
        "## Designs\n\nDistance relative to the best known; squared centred L2 discrepancy; CPU seconds of one thread. Other \
         programs ran with further seeds until they had used the time that decore's design of the same purpose took; the best \
         of their runs is shown. SciPy's \"lloyd\" builds Voronoi cells, which in 10 dimensions take more than ten minutes \
         and 6 GB: it is left out there. Three seeds of decore are three designs, each of one run; the goal of each is a distance of 0.99 up to (6, 50).\n\n\
         | factors, points | program | distance | discrepancy | CPU s | runs |\n|---|---|---|---|---|---|\n",
    );
    let python = std::env::var("DECORE_PYTHON").ok();
    for size in SIZES {
        let budgets_s = ours(&mut text, size);
        if let Some(python) = &python {
            others(&mut text, python, size, budgets_s);
        }
    }
    text.push_str("\nA million rows of 20 factors, one after the other, none kept:\n\n| kind | CPU s |\n|---|---|\n");
    million(&mut text);
    if let Some(peak) = peak_memory_bytes().map(|bytes| bytes as f64 / 1e6) {
        let _ = writeln!(text, "\nPeak memory of the whole bench: {peak:.0} MB.");
    }
    print!("{text}");
    if python.is_some() {
        support::write_section("designs", &text);
    }
}

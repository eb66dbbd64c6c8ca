//! Sensitivity indices of a large table, beside SALib on the same numbers in the same run. Writes its section of
//! `benches/RESULTS.md`. `DECORE_PYTHON`: a Python with SALib, for the comparison.

mod support;

use std::fmt::Write;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use decore_math::random::uniform;
use decore_statistics::analysis::{Bootstrap, Estimator, SaltelliBlocks, SobolIndices, sobol};
use rayon::prelude::*;

const FACTORS: usize = 10;
const OUTPUTS: usize = 20;
/// Blocks whose rows are a million.
const BLOCKS: usize = 1_000_000 / (FACTORS + 2) + 1;
/// The goal for decore, s.
const GOAL_S: f64 = 10.0;
/// Largest difference to SALib that rounding explains.
const ROUNDING: f64 = 1e-12;

/// An output: a product and sums of the factors, other ones with each output.
fn value(output: usize, x: &[f64]) -> f64 {
    let weight = |factor: usize| 1.0 + ((factor * 7 + output * 3) % 11) as f64;
    let sum: f64 = x.iter().enumerate().map(|(factor, x)| x * weight(factor)).sum();
    sum + 10.0 * x[output % FACTORS] * x[(output + 3) % FACTORS]
}

fn table() -> Vec<Vec<f64>> {
    let rows = |block: usize| {
        let point: Vec<f64> = (0..2 * FACTORS).map(|column| uniform(1, block as u64, column as u64)).collect();
        (0..FACTORS + 2).map(move |place| {
            let from_b = |factor: usize| place == FACTORS + 1 || place == factor + 1;
            (0..FACTORS).map(|factor| point[factor + if from_b(factor) { FACTORS } else { 0 }]).collect::<Vec<f64>>()
        })
    };
    let output = |output: usize| (0..BLOCKS).flat_map(rows).map(|x| value(output, &x)).collect();
    (0..OUTPUTS).into_par_iter().map(output).collect()
}

fn ours(table: &[Vec<f64>], bootstrap: &Bootstrap) -> (Vec<SobolIndices>, f64) {
    let blocks = SaltelliBlocks { factors: FACTORS, second_order: false };
    let start = Instant::now();
    let found = table.par_iter().map(|values| sobol(values, blocks, Estimator::Salib, bootstrap).expect("indices"));
    let found = found.collect();
    (found, start.elapsed().as_secs_f64())
}

/// Seconds that SALib takes, with as few replicates as it allows, and the largest difference of its indices to ours.
fn salib(python: &str, table: &[Vec<f64>], found: &[SobolIndices]) -> (f64, f64) {
    let scratch = tempfile::tempdir().expect("scratch folder");
    let file = scratch.path().join("outputs.f64");
    let bytes: Vec<u8> = table.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
    std::fs::write(&file, bytes).expect("written");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/sensitivity_reference.py");
    let output = Command::new(python).arg(script).arg(&file).args([FACTORS.to_string(), OUTPUTS.to_string()]).output();
    let output = output.expect("Python runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let (seconds, indices): (f64, Vec<[Vec<f64>; 2]>) = serde_json::from_slice(&output.stdout).expect("JSON");
    let far = found.iter().zip(&indices).flat_map(|(ours, [first, total])| {
        let pairs = ours.first.iter().zip(first).chain(ours.total.iter().zip(total));
        pairs.map(|(ours, theirs)| (ours.value - theirs).abs())
    });
    (seconds, far.fold(0.0, f64::max))
}

fn main() {
    let table = table();
    let none = Bootstrap { replicates: 0, seed: 0, level: Bootstrap::LEVEL };
    let (found, seconds) = ours(&table, &none);
    let (_, with_intervals) = ours(&table, &Bootstrap { replicates: 100, ..none });
    let mut text = format!(
        "# Sensitivity indices of a large table\n\nWritten by `cargo bench --bench sensitivity`: S1 and ST of {FACTORS} factors for \
         {OUTPUTS} outputs from {} rows of a Saltelli table in memory, wall time on {} threads.\n\n\
         | program | s | largest difference |\n|---|---|---|\n| decore, `salib`, no intervals | {seconds:.2} | |\n\
         | decore, `salib`, 100 bootstrap replicates | {with_intervals:.2} | |\n",
        table[0].len(),
        rayon::current_num_threads()
    );
    if seconds > GOAL_S {
        eprintln!("goal missed: {seconds:.2} s, not {GOAL_S}");
    }
    let python = std::env::var("DECORE_PYTHON").ok();
    if let Some(python) = &python {
        let (theirs, far) = salib(python, &table, &found);
        assert!(far < ROUNDING, "indices differ by {far}");
        let _ = writeln!(text, "| SALib, 2 replicates (fewer are not possible) | {theirs:.2} | {far:.0e} |");
    }
    print!("{text}");
    if python.is_some() {
        support::write_section("sensitivity", &text);
    }
}

//! Speed against error on the paper's rig, all figures from one run on one core.
//!
//! `cargo bench --bench rig` prints its tables and writes its section of `benches/RESULTS.md`. Times are CPU times of one thread,
//! medians of turns of a second at least; compare them with each other only. Names of sections after `--` run these alone and write
//! nothing: `methods`, `peers`, `presets`, `located`, `lanes`, `hammers`,
//! `modes`, `threads`.
//! `peers` builds a program of its own; SUNDIALS (`libsundials-cvode6`) and SciPy count where they are installed.

#[path = "../tests/common/changed.rs"]
mod changed;
#[path = "rig/growth.rs"]
mod growth;
#[path = "rig/lanes.rs"]
mod lanes;
#[path = "rig/located.rs"]
mod located;
#[path = "rig/methods.rs"]
mod methods;
#[path = "rig/peers.rs"]
mod peers;
#[path = "rig/presets.rs"]
mod presets;
#[path = "rig/scene.rs"]
mod scene;
mod support;
#[path = "rig/timing.rs"]
mod timing;

use std::path::{Path, PathBuf};

/// Turns of a short setting.
const REPEATS: usize = 5;
/// Turns of what takes longer.
const FEW_REPEATS: usize = 3;
/// Turns of whole sweeps.
const SWEEPS: usize = 2;

const HEAD: &str = "# Speed against error on the paper's rig

Written by `cargo bench --bench rig`: `studies/paper_rig.toml`, 1.5 s, one hammer, modes below 1000 Hz. Times are CPU times of one
thread, medians of interleaved turns of a second at least; trust their ratios.

";

const RESERVES: &str = "
## Open reserves

- Where the chisel rests on nose and casting, stability bounds the explicit steps at 70 to 90 us although nothing happens.
- Most other steps resolve the ringing of contacts at 10 to 60 us, which may open at any time: exact propagation would need
  events located on its own dense output.
- With tied guides every event of one hammer ends the common step of all: steps grow about as the square root of the hammers,
  while a step costs less per hammer.
- A guide on its spring bounds every step, whatever the number of hammers.
";

/// The shipped study of the rig.
fn study_path() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/paper_rig.toml")
}

fn main() {
    let asked: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect();
    let wanted = |section: &str| asked.is_empty() || asked.iter().any(|name| name == section);
    let rig = scene::prepare(&study_path(), &[]);
    let mut text = HEAD.to_owned();
    // Tolerance of the fastest setting within the goals, for the peers.
    let mut tolerance = 1e-5;
    if wanted("methods") {
        let methods = methods::measure(&rig, REPEATS);
        methods.text(&mut text);
        tolerance = methods.best().map_or(tolerance, |best| best.case.solver.tolerance);
    }
    if wanted("peers") {
        peers::text(&mut text, &study_path(), tolerance);
    }
    if wanted("presets") {
        presets::text(&mut text, REPEATS);
    }
    if wanted("located") {
        located::text(&mut text, &rig);
    }
    if wanted("lanes") {
        lanes::text(&mut text, &rig, FEW_REPEATS);
    }
    if wanted("hammers") {
        growth::hammers_text(&mut text, FEW_REPEATS);
    }
    if wanted("modes") {
        growth::modes_text(&mut text, &growth::all_modes(), FEW_REPEATS);
    }
    if wanted("threads") {
        growth::threads_text(&mut text, SWEEPS);
    }
    text.push_str(RESERVES);
    print!("{text}");
    if asked.is_empty() {
        support::write_section("rig", &text);
    }
}

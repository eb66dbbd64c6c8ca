//! `decore check`: is the study sound, how large is it, how long will it take?

use std::path::{Path, PathBuf};

use clap::Args;

use super::exit::{Exit, Failure, write_file};
use super::outputs::{Output, StudyArguments};
use super::text::{plural, say, threads};
use crate::dataset::{Columns, TableName};
use crate::design::{Aliases, Distribution, Level, PHI_EXPONENT, Quality};
use crate::engine::{Engine, RowScene, Rows};
use crate::plot::{Factor, scatter_matrix};
use crate::run::{RowOutcome, RowStatus, amplifies, run_row, twin};
use crate::scene::Scene;
use crate::study::{CheckedStudy, FactorInfo, Study};
use crate::system::InterfaceModes;

/// Wall time in s spent at most on the row that tells the time of the others.
const PROBE_WALL_TIME_S: f64 = 10.0;
/// Rows drawn in a scatter matrix: more only make it black.
const SCATTERED_ROWS: usize = 2000;
/// Chains of aliased effects that are printed.
const ALIAS_CHAINS: usize = 16;
/// Rows looked at for one that can be simulated.
const PROBED_ROWS: usize = 100;

#[derive(Debug, Args)]
pub(super) struct CheckArguments {
    /// Study file (TOML).
    study: PathBuf,
    /// Threads for which the time is estimated, at most 1024; 0: as many as the machine has.
    #[arg(short, long, default_value_t = 0, value_parser = threads)]
    threads: usize,
    /// Set a value of the study, e.g. `hammer.left.supply_bar=4.5`; may be given several times.
    #[arg(long = "set", value_name = "PATH=VALUE")]
    overrides: Vec<String>,
    /// Write a scatter matrix of the design (SVG), every factor against every other one.
    #[arg(long, value_name = "FILE")]
    scatter: Option<PathBuf>,
}

pub(super) fn check(arguments: &CheckArguments) -> Result<Exit, Failure> {
    let outputs = [Output { flag: "--scatter", path: arguments.scatter.as_ref(), ending: Some("svg") }];
    let engine =
        StudyArguments { file: &arguments.study, overrides: &arguments.overrides, outputs: &outputs }.engine()?;
    let columns = Columns::new(&engine.info())?;
    let (study, checked) = (engine.study(), engine.checked());
    say(&format_args!("study          {} (hash {})", study.title(), &study.hash()[..16]))?;
    say(&format_args!("design         {}, seed {}", plural(checked.row_count(), "row"), study.seed()))?;
    for factor in study.factors() {
        let unit = factor.unit.as_deref().map_or(String::new(), |unit| format!(" {unit}"));
        say(&format_args!("  factor       {}: {}{unit}", factor.name, factor.domain()))?;
        for path in factor.paths() {
            say(&format_args!("    drives     {path}"))?;
        }
    }
    describe_design(checked)?;
    if let Some(file) = &arguments.scatter {
        write_scatter(checked, file)?;
    }
    say(&format_args!("hammers        {}", study.hammer_names().join(", ")))?;
    say(&format_args!("castings       {}", study.casting_names().join(", ")))?;
    say(&format_args!(
        "columns        {} per run, {} per blow",
        columns.describe(TableName::Runs).len(),
        columns.describe(TableName::Blows).len()
    ))?;
    probe(&engine, arguments.threads)?;
    Ok(Exit::Done)
}

/// Constraints with the share of points that met them, and the design's measures.
fn describe_design(checked: &CheckedStudy) -> Result<(), Failure> {
    let study = checked.study();
    for constraint in study.constraints() {
        say(&format_args!("  constraint   {constraint}"))?;
    }
    match checked.acceptance() {
        Some(acceptance) => say(&format_args!(
            "  acceptance   {:.1} % ({} of {} {})",
            100.0 * acceptance.rate(),
            acceptance.accepted,
            acceptance.tried,
            if acceptance.accepted == checked.row_count() { "points" } else { "blocks of rows that belong together" }
        ))?,
        None if !study.constraints().is_empty() => {
            say(&"  acceptance   100 % (a Latin hypercube that meets the constraints)")?;
        }
        None => {}
    }
    if let Some(aliases) = checked.design().aliases() {
        describe_aliases(study, &aliases)?;
    }
    let Some(quality) = Quality::of(checked.design()) else { return Ok(()) };
    let part =
        if quality.rows < checked.row_count() { format!(" of the first {} rows", quality.rows) } else { String::new() };
    say(&format_args!(
        "  distance     smallest {:.4}, phi_{} {:.4}{part}",
        quality.minimum_distance, PHI_EXPONENT, quality.phi_p
    ))?;
    say(&format_args!(
        "  discrepancy  centred {:.4e}, wrap-around {:.4e} (squared L2){part}",
        quality.centred_discrepancy, quality.wrap_around_discrepancy
    ))?;
    say(&format_args!("  correlation  at most {:.4} between two factors{part}", quality.maximum_correlation))
}

/// What a two-level fraction confuses: its generators, how many words have which length, effects of one or two factors.
fn describe_aliases(study: &Study, aliases: &Aliases) -> Result<(), Failure> {
    let drawn = study.factors().iter().filter(|factor| factor.distribution().is_some());
    let names: Vec<&str> = drawn.map(|factor| factor.name.as_str()).collect();
    let product = |effect: &[usize]| effect.iter().map(|factor| names[*factor]).collect::<Vec<_>>().join("*");
    for (factor, others) in &aliases.generators {
        say(&format_args!("  generator    {} = {}", names[*factor], product(others)))?;
    }
    if let (Some(lengths), Some(resolution)) = (&aliases.word_lengths, aliases.resolution()) {
        let counts = lengths.iter().enumerate().skip(1).filter(|(_, count)| **count > 0);
        let counts: Vec<String> = counts.map(|(length, count)| format!("{count} of length {length}")).collect();
        say(&format_args!("  words        {}: resolution {resolution}", counts.join(", ")))?;
    }
    for chain in aliases.chains.iter().take(ALIAS_CHAINS) {
        let effects: Vec<String> = chain.iter().map(|effect| product(effect)).collect();
        say(&format_args!("  aliased      {}", effects.join(" = ")))?;
    }
    match aliases.chains.len() {
        0 if aliases.generators.is_empty() => Ok(()),
        0 => say(&"  aliased      no effects of one or two factors with each other"),
        count if count > ALIAS_CHAINS => say(&format_args!("               and {} more", count - ALIAS_CHAINS)),
        _ => Ok(()),
    }
}

fn write_scatter(checked: &CheckedStudy, file: &Path) -> Result<(), Failure> {
    let study = checked.study();
    let design = checked.design();
    let rows: Vec<Vec<Level>> = (0..design.row_count().min(SCATTERED_ROWS)).filter_map(|row| design.row(row)).collect();
    let drawn = study.factors().iter().filter_map(|factor| Some((factor, factor.distribution()?)));
    let panel = |(index, (factor, distribution)): (usize, (&FactorInfo, &Distribution))| Factor {
        name: factor.name.clone(),
        domain: format!("{} {}", factor.domain(), factor.unit.as_deref().unwrap_or_default()).trim_end().to_owned(),
        shares: rows.iter().filter_map(|row| row.get(index)).map(|level| distribution.share(*level)).collect(),
    };
    let panels: Vec<Factor> = drawn.enumerate().map(panel).collect();
    write_file(file, scatter_matrix(study.title(), &panels)?)?;
    say(&format_args!("scatter        {}", file.display()))?;
    Ok(())
}

/// Time in s of a row from which on it is told in larger units.
const LONG_S: f64 = 1e4;
/// A year in s.
const YEAR_S: f64 = 365.25 * 86400.0;

/// Twins that are suggested where a scene amplifies.
const SUGGESTED_TWINS: usize = 4;

/// Simulates the first row that describes a scene and tells what it took.
fn probe(engine: &Engine, threads: usize) -> Result<(), Failure> {
    let rows = engine.checked().row_count();
    let mut invalid = 0;
    for row in 0..rows.min(PROBED_ROWS) {
        let Ok(RowScene { mut scene, modes }) = engine.scene(row) else {
            invalid += 1;
            continue;
        };
        scene.solver.max_wall_time_s = scene.solver.max_wall_time_s.min(PROBE_WALL_TIME_S);
        let outcome = run_row(&scene, &modes);
        say(&format_args!("modes          {} kept (row {row})", outcome.modes))?;
        if let Ok(Some(selection)) = engine.machine_of(&scene).selection(&scene) {
            let residual = selection.residual.omega_rad_s.len();
            let (kept, available, bound) = (selection.kept.len(), selection.available, selection.bound);
            say(&format_args!(
                "               {kept} of {available} and {residual} residual; receptances within {bound:.1e} of static flexibility"
            ))?;
        }
        say(&format_args!("states         {}", outcome.states))?;
        let times = describe_twins(&scene, &modes, &outcome)?;
        say(&estimate(&outcome, &Sweep { rows, threads, duration_s: scene.duration_s, times }))?;
        if invalid > 0 {
            say(&format_args!("note           the first {invalid} rows describe no scene that can be simulated"))?;
        }
        return Ok(());
    }
    say(&format_args!("note           none of the first {invalid} rows describes a scene that can be simulated"))
}

/// Tells whether the scene is known to amplify perturbations and what twins cost, by the time of one; returns how many times as
/// long as a plain run a row takes.
fn describe_twins(scene: &Scene, modes: &InterfaceModes, outcome: &RowOutcome) -> Result<f64, Failure> {
    let (twins, amplifies) = (scene.outputs.twins, amplifies(scene));
    if twins == 0 && amplifies.is_none() {
        return Ok(1.0);
    }
    let one = run_row(&twin(scene, 0), modes).wall_time_s / outcome.wall_time_s;
    let times = |twins: usize| 1.0 + one * twins as f64;
    if twins > 0 {
        say(&format_args!("twins          {twins} per row, {:.1} times the time of a row without", times(twins)))?;
    } else if let Some(reason) = amplifies {
        say(&format_args!(
            "note           {reason}: its periodic figures may scatter; `outputs.twins = {SUGGESTED_TWINS}` shows by how much, for {:.1} \
             times the time",
            times(SUGGESTED_TWINS)
        ))?;
    }
    Ok(times(twins))
}

/// What a sweep runs.
struct Sweep {
    rows: usize,
    /// 0: as many as the machine has.
    threads: usize,
    /// Simulated time of a row, s.
    duration_s: f64,
    /// How many times as long as a plain run a row takes with its twins.
    times: f64,
}

/// Time of a row alone, by a run that may have ended before its time, and of all were they run one by one.
fn estimate(outcome: &RowOutcome, sweep: &Sweep) -> String {
    let Sweep { rows, threads, duration_s, times } = *sweep;
    if outcome.time_reached_s <= 0.0 {
        return format!("time           unknown: the first row ended at once ({})", outcome.reason);
    }
    // A duration may be as long as a number can be: what is more than that is as much.
    let row_s = (times * outcome.wall_time_s * (duration_s / outcome.time_reached_s)).min(f64::MAX);
    let threads = if threads == 0 { std::thread::available_parallelism().map_or(1, usize::from) } else { threads };
    let total_s = (row_s * (rows as f64 / threads.min(rows.max(1)) as f64)).min(f64::MAX);
    let note = match outcome.status {
        RowStatus::Diverged => format!("; the first row diverges ({})", outcome.reason),
        _ => String::new(),
    };
    let threads = plural(threads, "thread");
    // What rows side by side save depends on their shapes, known only by running them.
    format!(
        "time           {} per row alone, at most about {} in all with {threads}{note}",
        if row_s < LONG_S { format!("{row_s:.2} s") } else { duration(row_s) },
        duration(total_s)
    )
}

fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 9.95 => format!("{s:.1} s"),
        s if s < 90.0 => format!("{s:.0} s"),
        s if s < 5400.0 => format!("{:.0} min", s / 60.0),
        s if s < YEAR_S => format!("{:.1} h", s / 3600.0),
        s if s < 1e4 * YEAR_S => format!("{:.1} years", s / YEAR_S),
        s => format!("{:.0e} years", s / YEAR_S),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::Counters;

    fn estimated(duration_s: f64, rows: usize) -> String {
        let outcome = RowOutcome {
            status: RowStatus::Done,
            reason: String::new(),
            time_reached_s: 0.5,
            modes: 0,
            states: 0,
            metrics: None,
            counters: Counters::default(),
            wall_time_s: 1.0,
        };
        estimate(&outcome, &Sweep { rows, threads: 1, duration_s, times: 1.0 })
    }

    #[test]
    fn every_duration_has_an_estimate_that_can_be_read() {
        let words = |row: &str, all: &str| {
            format!("time           {row} per row alone, at most about {all} in all with 1 thread")
        };
        assert_eq!(estimated(1.5, 240), words("3.00 s", "12 min"));
        assert_eq!(estimated(1e6, 1), words("555.6 h", "555.6 h"));
        assert_eq!(estimated(1e9, 2), words("63.4 years", "126.8 years"));
        assert_eq!(estimated(1e308, 1000), words("6e300 years", "6e300 years"));
    }
}

//! Results of `decore check` as plain data, printed as text or as JSON.

use schemars::JsonSchema;
use serde::Serialize;

use super::check_invalid::Invalid;
use super::check_links::{ElasticCasting, ElasticLink, elastic_castings, elastic_links};
use super::exit::Failure;
use decore_dataset::{Columns, TableName};
use decore_model::metrics::{HammerMetrics, duration_for};
use decore_model::run::{RowOutcome, RowStatus, amplifies, run_row, twin};
use decore_model::scene::{HammerUnit, Scene};
use decore_model::system::{PlacedModes, build_placed};
use decore_statistics::design::{Acceptance, Aliases, Design, Kind, Quality};
use decore_study::Study;
use decore_study::engine::{Engine, Repeats, RowRunner, RowScene};

/// Largest wall time in s of the row from which the time of the others is estimated.
const PROBE_WALL_TIME_S: f64 = 10.0;
/// Rows looked at for one that can be simulated.
const PROBED_ROWS: usize = 100;

/// All that is found.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Check {
    /// Facts that need no run.
    #[serde(flatten)]
    pub plan: StudyOutline,
    /// The first row that can be simulated, run for at most 10 s of wall time; null where none of the first 100 can.
    pub probe: Option<Probe>,
    /// The first of these rows that describes a scene for which machine or castings have no modes, or that cannot be built; null for none.
    pub unbuilt: Option<UnbuiltRow>,
}

/// A row whose scene is sound by itself, but does not fit the models of its machine or its castings.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct UnbuiltRow {
    /// The row.
    pub row: usize,
    /// Reason.
    pub reason: String,
}

/// Facts about a study that need no run.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct StudyOutline {
    /// Title of the study.
    pub study: String,
    /// Hash of the study.
    pub study_hash: String,
    /// Warnings, a sentence each; the rows are run nevertheless.
    pub warnings: Vec<String>,
    /// Rows of the design.
    pub rows: usize,
    /// Rows that have the same factors as an earlier one, which is run for both; of the first 1048576 rows.
    pub repeated: usize,
    /// Hints for a better design at no cost, a sentence each.
    pub hints: Vec<String>,
    /// Seed of the design.
    pub seed: u64,
    /// The factors.
    pub factors: Vec<FactorPlan>,
    /// The constraints as typed.
    pub constraints: Vec<String>,
    /// Number of points, or of blocks of rows that belong together, that met the constraints; null if none were left out.
    pub acceptance: Option<Acceptance>,
    /// Aliases of a two-level fraction; null for another design.
    pub confused: Option<Confused>,
    /// Measures of the design; null without factors.
    pub quality: Option<Quality>,
    /// Names of the hammers.
    pub hammers: Vec<String>,
    /// Names of the castings.
    pub castings: Vec<String>,
    /// Columns of the table of runs.
    pub columns_per_run: usize,
    /// Columns of the table of blows.
    pub columns_per_blow: usize,
    /// Rows that cannot be simulated.
    pub invalid: Invalid,
}

/// One factor.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct FactorPlan {
    /// Name.
    pub name: String,
    /// Unit; null where the study names none.
    pub unit: Option<String>,
    /// Range or values, in words.
    pub domain: String,
    /// The study's values that it drives.
    pub drives: Vec<String>,
    /// Converted ranges: one sentence for each driven value whose unit differs from the unit of the factor.
    pub conversions: Vec<String>,
}

/// Aliases of a two-level fraction.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Confused {
    /// Factors that are products of others.
    pub generators: Vec<Generator>,
    /// Number of products of factors that are the same in every row, by their number of factors, from 0; null where there are
    /// too many to count.
    pub word_lengths: Option<Vec<usize>>,
    /// Least number of factors of such a product; null where there is none or too many to count.
    pub resolution: Option<usize>,
    /// Effects of one or two factors (`a`, `a*b`) that cannot be told apart, in lists.
    pub aliased: Vec<Vec<String>>,
}

/// A factor that is a product of others.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Generator {
    /// The factor.
    pub factor: String,
    /// The product, `a*b*c`.
    pub product: String,
}

/// Cost of a row, and estimate for the others.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Probe {
    /// The row that was run.
    pub row: usize,
    /// Status of the run.
    pub status: RowStatus,
    /// Reason if it is not done; else empty.
    pub reason: String,
    /// Simulated time reached, s.
    pub time_reached_s: f64,
    /// Modes of the structure that were kept.
    pub modes: usize,
    /// Selection of the modes; null if they are not selected.
    pub selection: Option<Selected>,
    /// States of the coupled system.
    pub states: usize,
    /// Elastic castings; empty without one.
    pub elastic_castings: Vec<ElasticCasting>,
    /// Links of elastic castings; empty without one.
    pub elastic_links: Vec<ElasticLink>,
    /// Twins of each row.
    pub twins: u64,
    /// Reason for scatter of the row's outputs; null if there is none.
    pub amplifies: Option<String>,
    /// How many times as long a row takes with one twin as without, less one; null where neither twins nor a scene that
    /// amplifies make it worth knowing.
    pub twin_time_ratio: Option<f64>,
    /// Outputs of its hammers with standard errors, and the duration that these need; empty where the run did not reach its end or
    /// has too few blows, or its percussion has not settled.
    pub precision: Vec<Needed>,
    /// Wall time of a row alone, its twins included, s; null if the row ended at once.
    pub row_time_s: Option<f64>,
    /// Threads of the forecast.
    pub threads: usize,
    /// Wall time of all rows were they run one by one, s: an upper bound; null if the row ended at once.
    pub total_time_s: Option<f64>,
}

/// Standard error of an output, and the duration at which it would be as small as asked for.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Needed {
    /// Name of the hammer.
    pub hammer: String,
    /// The output.
    pub output: &'static str,
    /// Relative standard error in the row that was run.
    pub relative_error: f64,
    /// Relative standard error asked for.
    pub wanted_error: f64,
    /// Duration of a run for that error, s: errors fall with the root of the duration.
    pub needed_s: f64,
}

impl Needed {
    /// Returns the needs of all hammers in a run of `scene`.
    fn all(scene: &Scene, outcome: &RowOutcome, wanted_error: f64) -> Vec<Self> {
        let metrics = outcome.metrics.as_ref();
        let hammers = metrics.iter().flat_map(|metrics| scene.hammers.iter().zip(&metrics.hammers));
        let of = |(unit, hammer): (&HammerUnit, &HammerMetrics)| -> Vec<Self> {
            let needed = |(output, value, error): (&'static str, f64, f64)| Self {
                hammer: unit.name.clone(),
                output,
                relative_error: error / value.abs(),
                wanted_error,
                needed_s: duration_for(wanted_error, scene.duration_s, (value, error)),
            };
            hammer.erring().map(needed).filter(|needed| needed.needed_s.is_finite()).collect()
        };
        hammers.flat_map(of).collect()
    }
}

/// A selection of modes.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Selected {
    /// Modes kept.
    pub kept: usize,
    /// Modes that there are.
    pub available: usize,
    /// Residual modes.
    pub residual: usize,
    /// Largest error of receptances over static flexibility.
    pub bound: f64,
}

impl StudyOutline {
    /// The plan of a study.
    ///
    /// # Errors
    /// Names of which no columns can be made.
    pub fn of(engine: &Engine) -> Result<Self, Failure> {
        let columns = Columns::new(&engine.info())?;
        let (study, checked) = (engine.study(), engine.checked());
        let owned = |names: Vec<&str>| names.into_iter().map(str::to_owned).collect::<Vec<_>>();
        let factors = study.factors().iter().map(|factor| FactorPlan {
            name: factor.name.clone(),
            unit: factor.unit.clone(),
            domain: factor.domain(),
            drives: factor.paths(),
            conversions: factor.conversions(),
        });
        Ok(Self {
            study: study.title().to_owned(),
            study_hash: study.hash().to_owned(),
            warnings: checked.warnings().iter().map(ToString::to_string).collect(),
            rows: checked.row_count(),
            repeated: repeated(engine),
            hints: hints(checked.design()),
            seed: study.seed(),
            factors: factors.collect(),
            constraints: owned(study.constraints()),
            acceptance: checked.acceptance(),
            confused: checked.design().aliases().map(|aliases| Confused::of(study, &aliases)),
            quality: Quality::of(checked.design()),
            hammers: owned(study.hammer_names()),
            castings: owned(study.casting_names()),
            columns_per_run: columns.describe(TableName::Runs).len(),
            columns_per_blow: columns.describe(TableName::Blows).len(),
            invalid: Invalid::of(checked),
        })
    }
}

/// Rows of a study that repeat an earlier one and are not run.
fn repeated(engine: &Engine) -> usize {
    match engine.info().signals.is_empty() {
        true => Repeats::of(engine.checked(), 0..engine.checked().row_count() as u64).count(),
        false => 0,
    }
}

/// Hints for a better design.
fn hints(design: &Design) -> Vec<String> {
    let parts: Vec<&Kind> = match design.kind() {
        Kind::Union(union) => union.parts.iter().collect(),
        Kind::Product(product) => product.parts.iter().map(|part| &part.kind).collect(),
        kind => vec![kind],
    };
    parts.into_iter().filter_map(power_of_two).collect()
}

/// Sobol' points are balanced in numbers that are powers of two.
fn power_of_two(kind: &Kind) -> Option<String> {
    let (key, count) = match kind {
        Kind::Sobol(sobol) => ("rows", sobol.rows),
        Kind::Saltelli(saltelli) => ("base_points", saltelli.base),
        _ => return None,
    };
    let above = count.checked_next_power_of_two().filter(|above| *above != count)?;
    let below = above / 2;
    Some(format!(
        "{count} Sobol' points are not balanced: with a power of two they fill the ranges evenly (`{key} = {below}` or `{key} = {above}`)"
    ))
}

impl Confused {
    fn of(study: &Study, aliases: &Aliases) -> Self {
        let drawn = study.factors().iter().filter(|factor| factor.distribution().is_some());
        let names: Vec<&str> = drawn.map(|factor| factor.name.as_str()).collect();
        let product = |effect: &[usize]| effect.iter().map(|factor| names[*factor]).collect::<Vec<_>>().join("*");
        let generators = aliases.generators.iter();
        Self {
            generators: generators
                .map(|(factor, others)| Generator { factor: names[*factor].to_owned(), product: product(others) })
                .collect(),
            word_lengths: aliases.word_lengths.clone(),
            resolution: aliases.resolution(),
            aliased: aliases.chains.iter().map(|chain| chain.iter().map(|effect| product(effect)).collect()).collect(),
        }
    }
}

/// Rows to skip and threads to use, for the estimate of a sweep's time.
pub(super) struct Probed {
    /// Rows that repeat others and are not run.
    pub repeated: usize,
    /// Threads that run the others.
    pub threads: usize,
}

/// Looks for the first row that can be simulated, and for the first before it that only lacks modes or cannot be built.
pub(super) fn first_scene(engine: &Engine) -> (Option<(usize, RowScene)>, Option<UnbuiltRow>) {
    let mut unbuilt = None;
    for row in 0..engine.checked().row_count().min(PROBED_ROWS) {
        if engine.checked().scene(row).is_err() {
            continue;
        }
        let built = engine.scene(row).map_err(|invalid| invalid.reason);
        let built = built.and_then(|found| match build_placed(&found.scene, &found.modes) {
            Ok(_) => Ok(found),
            Err(error) => Err(error.to_string()),
        });
        match built {
            Ok(found) => return (Some((row, found)), unbuilt),
            Err(reason) => _ = unbuilt.get_or_insert(UnbuiltRow { row, reason }),
        }
    }
    (None, unbuilt)
}

/// Simulates a row and returns its cost, and the time of all rows.
pub(super) fn probe(
    engine: &Engine,
    (row, found): (usize, RowScene),
    Probed { repeated, threads }: Probed,
    wanted_error: f64,
) -> Probe {
    let rows = engine.checked().row_count();
    let RowScene { mut scene, modes } = found;
    scene.solver.max_wall_time_s = scene.solver.max_wall_time_s.min(PROBE_WALL_TIME_S);
    let outcome = run_row(&scene, &modes);
    let selection = engine.machine_of(&scene).selection(&scene).ok().flatten();
    let amplifies = amplifies(&scene);
    let twins = scene.outputs.twins;
    let twin_time_ratio = (twins > 0 || amplifies.is_some()).then(|| twin_time_ratio(&scene, &modes, &outcome));
    let times = 1.0 + twin_time_ratio.unwrap_or(0.0) * twins as f64;
    let row_time_s = row_time_s(&outcome, scene.duration_s).map(|row_s| (times * row_s).min(f64::MAX));
    let different = rows.saturating_sub(repeated).max(1);
    let rows_one_by_one = different as f64 / threads.min(different) as f64;
    Probe {
        row,
        status: outcome.status,
        modes: outcome.modes,
        selection: selection.map(|selection| Selected {
            kept: selection.kept.len(),
            available: selection.available,
            residual: selection.residual.omega_rad_s.len(),
            bound: selection.bound,
        }),
        states: outcome.states,
        elastic_castings: elastic_castings(&scene, &modes),
        elastic_links: elastic_links(&scene, &modes),
        twins: twins as u64,
        amplifies,
        twin_time_ratio,
        precision: Needed::all(&scene, &outcome, wanted_error),
        row_time_s,
        threads,
        total_time_s: row_time_s.map(|row_s| (row_s * rows_one_by_one).min(f64::MAX)),
        time_reached_s: outcome.time_reached_s,
        reason: outcome.reason,
    }
}

/// Time of a twin relative to its row.
fn twin_time_ratio(scene: &Scene, modes: &PlacedModes, outcome: &RowOutcome) -> f64 {
    run_row(&twin(scene, 0), modes).wall_time_s / outcome.wall_time_s
}

/// Share of its duration that a row which diverges must have reached to tell how long others take: its last steps shrink without end.
const TOLD_BY: f64 = 0.01;

/// Time of a row by a run that may have ended before its time; `None` for one that ended at once. A duration may be as long as a
/// number can be: what is more than that is as much.
fn row_time_s(outcome: &RowOutcome, duration_s: f64) -> Option<f64> {
    let reached_s = outcome.time_reached_s;
    let least_s = if outcome.status == RowStatus::Diverged { TOLD_BY * duration_s } else { 0.0 };
    (reached_s > least_s).then(|| (outcome.wall_time_s * (duration_s / reached_s)).min(f64::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;
    use decore_model::integrate::Counters;

    #[test]
    fn a_row_that_ended_early_would_have_taken_longer() {
        let outcome = |time_reached_s: f64| RowOutcome {
            status: RowStatus::Done,
            reason: String::new(),
            time_reached_s,
            modes: 0,
            states: 0,
            metrics: None,
            counters: Counters::default(),
            wall_time_s: 1.0,
            numerical_twin_wall_time_s: None,
        };
        assert_eq!(row_time_s(&outcome(0.5), 1.5), Some(3.0));
        assert_eq!(row_time_s(&outcome(0.5), 1e308), Some(f64::MAX));
        assert_eq!(row_time_s(&outcome(0.0), 1.5), None);
        let diverged = |time_reached_s: f64| RowOutcome { status: RowStatus::Diverged, ..outcome(time_reached_s) };
        assert_eq!([1e-18, 0.75].map(|reached_s| row_time_s(&diverged(reached_s), 1.5)), [None, Some(2.0)]);
    }
}

//! `decore check`: is the study sound, how large is it, how long will it take?

use std::path::PathBuf;

use clap::Args;

use super::check_invalid::Invalid;
use super::check_links::{link_lines, mode_lines};
use super::check_result::{Check, Confused, Needed, Probe, Probed, StudyOutline, UnbuiltRow, first_scene, probe};
use super::exit::{Exit, Failure, write_file};
use super::json::{print_json, wants_words};
use super::outputs::{Form, Output, StudyArguments};
use super::text::{eprint_line, fit, plural, print_line, terminal_columns, threads, wanted_error};
use crate::plot::{MatrixFactor, scatter_matrix};
use decore_model::run::{RowStatus, thread_count};
use decore_statistics::design::{Distribution, Level, PHI_EXPONENT, Quality};
use decore_study::engine::{MOST_COMPARED, RowRunner};
use decore_study::{CheckedStudy, FactorInfo};

/// Rows drawn in a scatter matrix: more only make it black.
const SCATTERED_ROWS: usize = 2000;
/// Chains of aliased effects that are printed.
const ALIAS_CHAINS: usize = 16;
/// Time in s below which it is told in ms.
const SHORT_S: f64 = 0.1;
/// Time in s of a row from which on it is told in larger units.
const LONG_S: f64 = 1e4;
/// A year in s.
const YEAR_S: f64 = 365.25 * 86400.0;
/// Twins that are suggested where a scene amplifies.
const SUGGESTED_TWINS: usize = 4;

#[derive(Debug, Args)]
pub(super) struct CheckArguments {
    /// Study file (TOML)
    study: PathBuf,
    /// Number of threads for the time estimate, at most 1024; 0: one per core
    ///
    /// With 0, `RAYON_NUM_THREADS` can set the number.
    #[arg(short, long, default_value_t = 0, value_parser = threads)]
    threads: usize,
    /// Set a value of the study, for example `hammer.left.supply_bar=4.5`; repeatable
    #[arg(long = "set", value_name = "PATH=VALUE")]
    overrides: Vec<String>,
    /// Write a scatter matrix of the design (SVG): each factor against each other factor
    #[arg(long, value_name = "FILE")]
    scatter: Option<PathBuf>,
    /// With --scatter: replace an existing file
    #[arg(long, requires = "scatter")]
    replace: bool,
    /// Relative standard error for which the run duration is estimated
    #[arg(long, default_value_t = decore_lab::report::WANTED_ERROR, value_name = "SHARE", value_parser = wanted_error)]
    wanted_error: f64,
    /// End with exit code 4 if a row cannot be simulated
    #[arg(long)]
    strict: bool,
    /// Print the result as JSON (schemas/check.schema.json)
    #[arg(long)]
    json: bool,
}

pub(super) fn check(arguments: &CheckArguments) -> Result<Exit, Failure> {
    let outputs = [Output {
        flag: "--scatter",
        path: arguments.scatter.as_deref(),
        form: Form::File { endings: &["svg"], replace: arguments.replace },
    }];
    let engine =
        StudyArguments { file: &arguments.study, overrides: &arguments.overrides, outputs: &outputs }.engine()?;
    let plan = StudyOutline::of(&engine)?;
    // Problems come first.
    plan.invalid.warning(plan.rows).iter().for_each(|warning| eprint_line(warning));
    let (found, unbuilt) = first_scene(&engine);
    if let Some(UnbuiltRow { row, reason }) = &unbuilt {
        eprint_line(&format_args!("warning: row {row} cannot be simulated: {reason}"));
    }
    // The plan is there at once, the probe takes some seconds.
    if wants_words(arguments.json) {
        print_fitted(&plan_text(&plan))?;
    }
    if let Some(file) = &arguments.scatter {
        write_file(file, scatter(engine.checked())?)?;
        eprint_line(&format_args!("the scatter matrix is in {}", file.display()));
    }
    let Invalid { looked_at, count, .. } = plan.invalid;
    let none = count == looked_at || (found.is_none() && unbuilt.is_some());
    let has_failed = none || (arguments.strict && (count > 0 || unbuilt.is_some()));
    let rows = Probed { repeated: plan.repeated, threads: thread_count(arguments.threads)? };
    let probe = found.map(|found| probe(&engine, found, rows, arguments.wanted_error));
    if wants_words(arguments.json) {
        probe.iter().try_for_each(|probe| print_fitted(&probe_text(probe)))?;
    }
    if arguments.json {
        print_json(&Check { plan, probe, unbuilt })?;
    }
    Ok(if has_failed { Exit::RowsFailed } else { Exit::Done })
}

/// Prints lines that end where the terminal does.
fn print_fitted(text: &str) -> Result<(), Failure> {
    match terminal_columns() {
        Some(columns) => print_line(&fit(text, columns).trim_end()),
        None => print_line(&text),
    }
}

fn plan_text(plan: &StudyOutline) -> String {
    let mut lines = vec![
        format!("study          {} (hash {})", plan.study, &plan.study_hash[..16]),
        format!("design         {}, seed {}", plural(plan.rows, "row"), plan.seed),
    ];
    if plan.repeated > 0 {
        let of = if plan.rows > MOST_COMPARED { format!(" (of the first {MOST_COMPARED})") } else { String::new() };
        let rows = plural(plan.repeated, "row");
        lines.push(format!(
            "  repeats      {rows} with the same factors as an earlier one{of}: each of these is run once"
        ));
    }
    lines.extend(plan.hints.iter().map(|hint| format!("  hint         {hint}")));
    for factor in &plan.factors {
        let unit = factor.unit.as_deref().map_or(String::new(), |unit| format!(" {unit}"));
        lines.push(format!("  factor       {}: {}{unit}", factor.name, factor.domain));
        lines.extend(factor.drives.iter().map(|path| format!("    drives     {path}")));
    }
    lines.extend(plan.constraints.iter().map(|constraint| format!("  constraint   {constraint}")));
    match &plan.acceptance {
        Some(acceptance) => lines.push(format!(
            "  acceptance   {:.1} % ({} of {} {})",
            100.0 * acceptance.rate(),
            acceptance.accepted,
            acceptance.tried,
            if acceptance.accepted == plan.rows { "points" } else { "blocks of rows that belong together" }
        )),
        None if !plan.constraints.is_empty() => {
            lines.push("  acceptance   100 % (a Latin hypercube that meets the constraints)".to_owned());
        }
        None => {}
    }
    plan.confused.iter().for_each(|confused| confused_lines(confused, &mut lines));
    plan.quality.iter().for_each(|quality| quality_lines(quality, plan.rows, &mut lines));
    lines.push(format!("hammers        {}", plan.hammers.join(", ")));
    lines.push(format!("castings       {}", plan.castings.join(", ")));
    lines.push(format!("columns        {} per run, {} per blow", plan.columns_per_run, plan.columns_per_blow));
    lines.join("\n")
}

fn quality_lines(quality: &Quality, rows: usize, lines: &mut Vec<String>) {
    let part = if quality.rows < rows { format!(" of the first {} rows", quality.rows) } else { String::new() };
    lines.push(format!(
        "  distance     smallest {:.4}, phi_{} {:.4}{part}",
        quality.minimum_distance, PHI_EXPONENT, quality.phi_p
    ));
    lines.push(format!(
        "  discrepancy  centred {:.4e}, wrap-around {:.4e} (squared L2){part}",
        quality.centred_discrepancy, quality.wrap_around_discrepancy
    ));
    lines.push(format!("  correlation  at most {:.4} between two factors{part}", quality.maximum_correlation));
}

/// Aliases of a two-level fraction: generators, number of words by length, effects of one or two factors.
fn confused_lines(confused: &Confused, lines: &mut Vec<String>) {
    let generators = confused.generators.iter();
    lines.extend(generators.map(|one| format!("  generator    {} = {}", one.factor, one.product)));
    if let (Some(lengths), Some(resolution)) = (&confused.word_lengths, confused.resolution) {
        let counts = lengths.iter().enumerate().skip(1).filter(|(_, count)| **count > 0);
        let counts: Vec<String> = counts.map(|(length, count)| format!("{count} of length {length}")).collect();
        lines.push(format!("  words        {}: resolution {resolution}", counts.join(", ")));
    }
    let chains = confused.aliased.iter().take(ALIAS_CHAINS);
    lines.extend(chains.map(|chain| format!("  aliased      {}", chain.join(" = "))));
    match confused.aliased.len() {
        0 if confused.generators.is_empty() => {}
        0 => lines.push("  aliased      no effects of one or two factors with each other".to_owned()),
        count if count > ALIAS_CHAINS => lines.push(format!("               and {} more", count - ALIAS_CHAINS)),
        _ => {}
    }
}

/// A scatter matrix of the design as SVG.
fn scatter(checked: &CheckedStudy) -> Result<String, Failure> {
    let study = checked.study();
    let design = checked.design();
    let rows: Vec<Vec<Level>> = (0..design.row_count().min(SCATTERED_ROWS)).filter_map(|row| design.row(row)).collect();
    let drawn = study.factors().iter().filter_map(|factor| Some((factor, factor.distribution()?)));
    let panel = |(index, (factor, distribution)): (usize, (&FactorInfo, &Distribution))| MatrixFactor {
        name: factor.name.clone(),
        domain: format!("{} {}", factor.domain(), factor.unit.as_deref().unwrap_or_default()).trim_end().to_owned(),
        shares: rows.iter().filter_map(|row| row.get(index)).map(|level| distribution.share(*level)).collect(),
    };
    let panels: Vec<MatrixFactor> = drawn.enumerate().map(panel).collect();
    Ok(scatter_matrix(study.title(), &panels)?)
}

fn probe_text(probe: &Probe) -> String {
    let mut lines = vec![format!("modes          {} kept (row {})", probe.modes, probe.row)];
    lines.extend(probe.selection.iter().map(|selected| {
        format!(
            "               {} of {} and {} residual; receptances within {:.1e} of static flexibility",
            selected.kept, selected.available, selected.residual, selected.bound
        )
    }));
    lines.push(format!("states         {}", probe.states));
    lines.extend(mode_lines(&probe.elastic_castings));
    lines.extend(link_lines(&probe.elastic_links));
    lines.extend(twins_line(probe));
    lines.push(precision_line(probe));
    lines.push(time_line(probe));
    lines.join("\n")
}

/// Cost of twins, or a note that the scene amplifies perturbations.
fn twins_line(probe: &Probe) -> Option<String> {
    let times = |twins: f64| 1.0 + probe.twin_time_ratio.unwrap_or(0.0) * twins;
    if probe.twins > 0 {
        let times = times(probe.twins as f64);
        return Some(format!("twins          {} per row, {times:.1} times the time of a row without", probe.twins));
    }
    let times = times(SUGGESTED_TWINS as f64);
    let line = |reason: &String| {
        format!(
            "note           {reason}: its periodic figures may scatter; `outputs.twins = {SUGGESTED_TWINS}` shows by how much, for {times:.1} \
             times the time"
        )
    };
    probe.amplifies.as_ref().map(line)
}

/// Which duration the standard errors of the row need.
fn precision_line(probe: &Probe) -> String {
    let worst = probe.precision.iter().max_by(|a, b| a.needed_s.total_cmp(&b.needed_s));
    let Some(Needed { hammer, output, relative_error, wanted_error, needed_s }) = worst else {
        return format!(
            "precision      row {} has no standard errors: too few blows, or a percussion that has not settled; try a longer duration_s",
            probe.row
        );
    };
    let percent = |share: f64| format!("{:.2} %", 100.0 * share);
    let error = format!("at most {} (`{hammer}_{output}`, row {})", percent(*relative_error), probe.row);
    if relative_error <= wanted_error {
        return format!("precision      standard errors of {error}");
    }
    format!(
        "precision      standard errors of {error}; for {} set duration_s to about {needed_s:.1}",
        percent(*wanted_error)
    )
}

/// Time of a row alone, and of all were they run one by one: what rows side by side save depends on their shapes, known only by
/// running them.
fn time_line(probe: &Probe) -> String {
    let (Some(row_s), Some(total_s)) = (probe.row_time_s, probe.total_time_s) else {
        return format!("time           unknown: the first row ended at once ({})", probe.reason);
    };
    let note = match probe.status {
        RowStatus::Diverged => format!("; the first row diverges ({})", probe.reason),
        _ => String::new(),
    };
    format!(
        "time           {} per row alone, at most about {} in all with {}{note}",
        if (SHORT_S..LONG_S).contains(&row_s) { format!("{row_s:.2} s") } else { duration(row_s) },
        duration(total_s),
        plural(probe.threads, "thread")
    )
}

fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 1e-4 => "less than 0.1 ms".to_owned(),
        s if s < 9.95e-3 => format!("{:.1} ms", s * 1e3),
        s if s < SHORT_S => format!("{:.0} ms", s * 1e3),
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
    use super::duration;

    #[test]
    fn every_duration_can_be_read() {
        let cases = [
            (0.0, "less than 0.1 ms"),
            (0.0047, "4.7 ms"),
            (0.053, "53 ms"),
            (0.1, "0.1 s"),
            (3.0, "3.0 s"),
            (720.0, "12 min"),
            (2e6, "555.6 h"),
            (2e9, "63.4 years"),
            (4e9, "126.8 years"),
            (f64::MAX, "6e300 years"),
        ];
        for (seconds, text) in cases {
            assert_eq!(duration(seconds), text);
        }
    }
}

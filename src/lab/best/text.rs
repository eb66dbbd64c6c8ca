//! The text of an answer.

use std::fmt;

use super::result::{Alternative, Answer, Estimate, LimitState, Setting, Verdict};
use super::search::{Merit, Pool};
use crate::sensitivity::four_digits;
use decore_quantity::Value;

/// Units that are displayed in another unit, with its factor.
const SHOWN_MM: f64 = 1e3;

/// Describes the progress of a search.
pub(super) fn progress(pool: &Pool<'_>, best: usize, merit: Merit) -> String {
    let goal = &pool.models.wanted[0];
    let value = with_unit(pool.all[best].goal(), &goal.unit);
    match merit.holds {
        true => format!("best so far: {} {value}", goal.text),
        false => format!("no place holds the limits yet; nearest: {:.0} % of runs", 100.0 * merit.share),
    }
}

/// The answer in one sentence. `one_hammer`: the study has one, which needs no name.
pub(super) fn sentence(answer: &Answer, one_hammer: bool) -> String {
    let place = settings(&answer.settings, one_hammer);
    let goal = estimate(&answer.goal);
    let limits: Vec<String> = answer.limits.iter().map(limit).collect();
    let beside = if limits.is_empty() { String::new() } else { format!(", {}", limits.join(", ")) };
    let share = 100.0 * answer.confidence;
    match (answer.verdict, &answer.proof) {
        (Verdict::Proven, Some(proof)) if limits.is_empty() => {
            format!("{place}: {goal} in {} checks.", proof.runs)
        }
        (Verdict::Proven, Some(proof)) => {
            format!("{place}: {goal}{beside}, held in {} of {} checks.", proof.held, proof.runs)
        }
        (Verdict::Refuted, Some(proof)) => {
            let failed = if proof.failed > 0 { format!(", {} failed", proof.failed) } else { String::new() };
            format!(
                "Not proven: {}: {goal}{beside}, held in only {} of {} checks{failed}, {share:.0} % are wanted.",
                lower(&place),
                proof.held,
                proof.runs
            )
        }
        (Verdict::Infeasible, _) => {
            let nearest = answer.limits.iter().filter(|limit| limit.binds).map(|limit| {
                let (reached, value) = (with_unit(limit.reached, &limit.unit), number(limit.limit));
                format!("{} reaches {reached} there, limit {value}", limit.text)
            });
            let nearest = nearest.collect::<Vec<_>>().join("; ");
            let nearest = if nearest.is_empty() { "rows fail there".to_owned() } else { nearest };
            format!("No place holds the limits in {share:.0} % of runs; nearest: {} ({nearest}).", lower(&place))
        }
        (Verdict::Unsure, _) => format!(
            "The models are not sure enough to hold the limits anywhere: perhaps {}: {goal}{beside}; run more rows.",
            lower(&place)
        ),
        _ => format!("{place}: {goal}{beside}, expected by a model of {} rows, not checked by runs.", answer.rows),
    }
}

fn lower(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_lowercase().chain(letters).collect())
}

/// The values to choose: `Put the hammer at +0.021 m, 5.7 bar, 74 mm standoff`.
fn settings(settings: &[Setting], one_hammer: bool) -> String {
    let moves = |setting: &Setting| ["rail_position_m", "mount"].contains(&last(&setting.path));
    let placed = settings.iter().filter(|setting| moves(setting)).count() == 1 && one_hammer;
    let (first, rest): (Vec<&Setting>, Vec<&Setting>) = settings.iter().partition(|setting| placed && moves(setting));
    let words = first.into_iter().chain(rest).map(|setting| words(setting, one_hammer));
    let words = words.collect::<Vec<String>>().join(", ");
    if placed { format!("Put the hammer {words}") } else { format!("Choose {words}") }
}

fn last(path: &str) -> &str {
    path.rsplit('.').next().unwrap_or_default()
}

fn words(setting: &Setting, one_hammer: bool) -> String {
    let value = || match &setting.value {
        Value::Text(text) => text.clone(),
        other => other.number().map_or_else(String::new, number),
    };
    match (last(&setting.path), setting.value.number(), one_hammer) {
        ("rail_position_m", Some(position), true) => {
            format!("at {}{} m", if position < 0.0 { "" } else { "+" }, number(position))
        }
        ("mount", _, true) => format!("on {}", value()),
        ("supply_bar", Some(_), true) => format!("{} bar", value()),
        ("standoff_m", Some(standoff), true) => format!("{} mm standoff", number(SHOWN_MM * standoff)),
        _ => {
            let unit = if setting.unit.is_empty() { String::new() } else { format!(" {}", setting.unit) };
            format!("{} {}{unit}", setting.factor.replace('_', " "), value())
        }
    }
}

fn estimate(goal: &Estimate) -> String {
    let (low, high) = (number(goal.low), number(goal.high));
    let name = if goal.unit.is_empty() { format!("{} = ", goal.text) } else { String::new() };
    format!("{name}{} ({low} to {high})", with_unit(goal.mean, &goal.unit))
}

fn limit(limit: &LimitState) -> String {
    let name = name(&limit.text, &limit.unit);
    let end = if limit.at_most { "at most" } else { "at least" };
    format!("{name} {end} {}, limit {}", with_unit(limit.reached, &limit.unit), number(limit.limit))
}

/// A column in words, without its unit.
fn name(text: &str, unit: &str) -> String {
    let suffix = format!("_{}", unit.to_lowercase().replace('/', "_"));
    text.strip_suffix(&suffix).unwrap_or(text).replace('_', " ")
}

fn with_unit(value: f64, unit: &str) -> String {
    if unit.is_empty() { number(value) } else { format!("{} {unit}", number(value)) }
}

/// At most four digits, without zeros at the end.
fn number(value: f64) -> String {
    let text = four_digits(value);
    match text.contains('.') && !text.contains('e') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.sentence)?;
        writeln!(f)?;
        writeln!(f, "study         {}; models of {} rows", self.study, self.rows)?;
        for limit in &self.limits {
            let binds = if limit.binds { "this is what limits" } else { "room is left" };
            let (reached, value) = (with_unit(limit.reached, &limit.unit), number(limit.limit));
            let order = if limit.at_most { "<=" } else { ">=" };
            writeln!(
                f,
                "limit         {} {order} {value}: {reached} in {:.0} % of runs; {binds}",
                limit.text,
                100.0 * self.confidence
            )?;
        }
        for looser in &self.looser {
            let limit = number(looser.limit);
            match looser.goal {
                Some(goal) => writeln!(
                    f,
                    "looser limit  {} {limit}: {} {} with {}",
                    looser.text,
                    self.goal.text,
                    with_unit(goal, &self.goal.unit),
                    plain(&looser.settings)
                )?,
                None => writeln!(f, "looser limit  {} {limit}: still no place holds the limits", looser.text)?,
            }
        }
        self.write_alternatives(f)?;
        self.write_factors(f)?;
        let of = &self.uncertainty;
        let [factors, model, scatter] =
            [of.factors, of.model, of.scatter].map(|value| with_unit(value, &self.goal.unit));
        writeln!(
            f,
            "uncertain     {}: {factors} by the uncertain factors, {model} by the models, {scatter} by scatter (standard deviations)",
            self.goal.text
        )?;
        writeln!(f, "to narrow it  {}", of.advice)?;
        if let Some(proof) = &self.proof {
            let [first, last] = proof.rows;
            writeln!(
                f,
                "checks        {} of {} runs held all limits, {} failed (rows {first} to {last} of the added ones)",
                proof.held, proof.runs, proof.failed
            )?;
        }
        self.notes.iter().try_for_each(|note| writeln!(f, "note          {note}"))
    }
}

impl Answer {
    fn write_alternatives(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.alternatives.is_empty() {
            return writeln!(f, "elsewhere     no other place holds the limits");
        }
        for Alternative { settings, goal, reached, proof, .. } in &self.alternatives {
            let reached = self.limits.iter().zip(reached).map(|(limit, reached)| with_unit(*reached, &limit.unit));
            let beside: String = reached.map(|reached| format!(", {reached}")).collect();
            let (place, goal) = (plain(settings), with_unit(*goal, &self.goal.unit));
            match proof {
                Some(of) => {
                    writeln!(f, "elsewhere     {place}: {goal}{beside}, held in {} of {} runs", of.held, of.runs)?
                }
                None => writeln!(f, "elsewhere     {place}: {goal}{beside}, predicted")?,
            }
        }
        Ok(())
    }

    fn write_factors(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut effects: Vec<_> = self.factors.iter().collect();
        effects.sort_by(|a, b| b.goal.total_cmp(&a.goal));
        for effect in effects {
            let limits = self.limits.iter().zip(&effect.limits);
            let limits: String =
                limits.map(|(limit, change)| format!(", {}", with_unit(*change, &limit.unit))).collect();
            let over = if effect.decision { "a tenth of its range to either side" } else { "its 5 % to 95 % points" };
            let goal = with_unit(effect.goal, &self.goal.unit);
            writeln!(f, "factor        {} changes it by {goal}{limits} over {over}", effect.factor)?;
        }
        Ok(())
    }
}

/// Settings with their factors' names.
fn plain(settings: &[Setting]) -> String {
    settings.iter().map(|setting| words(setting, false)).collect::<Vec<_>>().join(", ")
}

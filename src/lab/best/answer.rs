//! Turns the expected decision into the answer.

use super::checks::Checks;
use super::error::BestError;
use super::model::{Expected, Models};
use super::result::{Alternative, Answer, Effect, Estimate, LimitState, Looser, Proof, Setting, Uncertainty, Verdict};
use super::rivals::{ALTERNATIVES, COMPARED, may_exceed, noticeably};
use super::search::Pool;
use super::space::{Decision, Space};
use super::task::{BestSettings, Purpose, There};
use super::text;
use super::trials::Trials;
use crate::refinement::Side;
use decore_statistics::design::Level;
use decore_study::{CheckedStudy, FactorInfo};

/// Share of a range to either side of the proposal, for the effect of a decision factor.
const MOVED: f64 = 0.1;
/// Shares of the distribution between which the effect of an uncertain factor is taken.
const BETWEEN: [f64; 2] = [0.05, 0.95];
/// Share by which a limit is loosened.
const LOOSER: f64 = 0.1;
/// Share of the runs on either side of an interval.
const TAIL: f64 = 0.025;
/// Share of a limit within which it counts as binding.
const NEAR: f64 = 0.05;
/// Q2 below which a model is not relied on, unless scatter is why.
const LEAST_Q2: f64 = 0.5;

/// Inputs of an answer, apart from the models.
pub(super) struct Asked<'a> {
    pub study: &'a CheckedStudy,
    pub trials: &'a Trials,
    pub settings: &'a BestSettings,
    pub there: There<'a>,
}

/// Makes the answer.
pub(super) fn answer(mut pool: Pool<'_>, asked: &Asked<'_>) -> Result<Answer, BestError> {
    let (space, models, bounds) = (pool.space, pool.models, pool.models.bounds());
    let trials = asked.trials;
    // Without a proof: the last decision that was checked, if nothing was learned since.
    let last = trials.all.last().filter(|last| last.purpose == Purpose::Check);
    let refuted = last.filter(|last| last.runs.rows[1] + 1 == asked.there.rows.len() as u64);
    let trial = trials.proven().map(|(trial, _)| trial).or(refuted);
    let checks = trial.map(|trial| &trial.runs);
    let decision = trial.map_or_else(|| pool.all[pool.best(&bounds).0].decision.clone(), |own| own.decision.clone());
    let found = models.expected(space, std::slice::from_ref(&decision))?;
    let [found] = found.as_slice() else { return Err(BestError::NoDecision) };
    let merit = pool.merit(found, &bounds);
    let limits = limit_states(models, found, checks);
    let verdict = match checks {
        Some(checks) if checks.are_held(models.confidence) => Verdict::Proven,
        Some(_) => Verdict::Refuted,
        None if merit.holds => Verdict::Unchecked,
        None if found.held(&models.wanted, &bounds, -models.caution()) >= models.confidence => Verdict::Unsure,
        None => Verdict::Infeasible,
    };
    let others = elsewhere(&pool, trials, &decision);
    let alternatives = others.iter().map(|one| alternative(&pool, trials, *one)).collect();
    let mut notes = notes(models, (asked.settings, asked.there.rows.len()), verdict);
    notes.extend(trials.proven().and_then(|(_, goal)| unproven(&pool, asked, (&others, goal))));
    let looser = looser(&mut pool, &limits)?;
    let mut answer = Answer {
        study: asked.study.study().title().to_owned(),
        sentence: String::new(),
        verdict,
        confidence: models.confidence,
        settings: settings(space, &decision),
        goal: estimate(models, found, checks),
        share: merit.share,
        proof: checks.map(proof),
        rows: models.output(0).0.used,
        factors: effects(space, models, &decision)?,
        uncertainty: uncertainty(space, models, found),
        notes,
        limits,
        alternatives,
        looser,
    };
    answer.sentence = text::sentence(&answer, asked.study.study().hammer_names().len() == 1);
    Ok(answer)
}

fn proof(checks: &Checks) -> Proof {
    Proof { runs: checks.count, held: checks.held, failed: checks.failed, rows: checks.rows }
}

fn settings(space: &Space<'_>, decision: &Decision) -> Vec<Setting> {
    let values = space.study.values_at(&space.levels(decision, &space.nodes[0]));
    let all = space.study.study().factors();
    let setting = |place: usize| {
        let info: &FactorInfo = space.info(place);
        let own = all.iter().position(|other| other.name == info.name)?;
        Some(Setting {
            factor: info.name.clone(),
            path: info.paths().into_iter().next().unwrap_or_default(),
            value: values.get(own)?.clone(),
            unit: info.unit.clone().unwrap_or_default(),
        })
    };
    (0..decision.len()).filter_map(setting).collect()
}

fn estimate(models: &Models, found: &Expected, checks: Option<&Checks>) -> Estimate {
    let goal = &models.wanted[0];
    let end = |side: Side| found.quantile(0, side, (1.0 - TAIL, 0.0));
    let [mean, low, high] = match checks.filter(|checks| !checks.values[0].is_empty()) {
        Some(checks) => [checks.mean(0), checks.quantile(0, TAIL), checks.quantile(0, 1.0 - TAIL)],
        None => [found.goal(), end(Side::Most), end(Side::Least)],
    };
    let model_error = found.goal_error();
    Estimate { text: goal.text.clone(), unit: goal.unit.clone(), mean, low, high, model_error }
}

fn limit_states(models: &Models, found: &Expected, checks: Option<&Checks>) -> Vec<LimitState> {
    let state = |(place, wanted): (usize, &super::model::Wanted)| {
        let limit = wanted.bound?;
        let expected = found.quantile(place, wanted.side, (models.confidence, models.caution()));
        let share = if wanted.side == Side::Least { models.confidence } else { 1.0 - models.confidence };
        let checked =
            checks.filter(|checks| !checks.values[place].is_empty()).map(|checks| checks.quantile(place, share));
        let reached = checked.unwrap_or(expected);
        let room =
            if wanted.side == Side::Least { limit - expected.max(reached) } else { expected.min(reached) - limit };
        Some(LimitState {
            text: wanted.text.clone(),
            unit: wanted.unit.clone(),
            at_most: wanted.side == Side::Least,
            limit,
            reached,
            binds: room <= NEAR * limit.abs().max(f64::MIN_POSITIVE),
        })
    };
    models.wanted.iter().enumerate().filter_map(state).collect()
}

/// The best decisions within the limits at other places: different in a factor that moves a hammer, if there is one, otherwise in any
/// factor. Of decisions at one place, one that was run comes first.
fn elsewhere(pool: &Pool<'_>, trials: &Trials, decision: &Decision) -> Vec<usize> {
    let bounds = pool.models.bounds();
    let holds = |one: &usize| {
        let of = &pool.all[*one];
        let checks = trials.of(&of.decision).filter(|trial| trial.purpose == Purpose::Check);
        checks.map_or_else(|| pool.merit(of, &bounds).holds, |trial| trial.runs.are_held(pool.models.confidence))
    };
    let ranked: Vec<usize> = pool.ranked(&bounds, (usize::MAX, 0.0)).into_iter().filter(holds).collect();
    let (run, others): (Vec<usize>, Vec<usize>) = ranked.iter().partition(|one| **one < pool.run);
    let found = pool.elsewhere(run.into_iter().chain(others), std::slice::from_ref(decision), usize::MAX);
    ranked.into_iter().filter(|one| found.contains(one)).take(ALTERNATIVES).collect()
}

/// An alternative with the figures of its runs, otherwise of the models.
fn alternative(pool: &Pool<'_>, trials: &Trials, one: usize) -> Alternative {
    let (of, models) = (&pool.all[one], pool.models);
    let runs = trials.of(&of.decision).map(|trial| &trial.runs);
    Alternative {
        settings: settings(pool.space, &of.decision),
        goal: estimate(models, of, runs).mean,
        reached: limit_states(models, of, runs).iter().map(|limit| limit.reached).collect(),
        share: pool.merit(of, &models.bounds()).share,
        proof: runs.map(proof),
    }
}

/// A note about alternatives that may be better than the proven decision, but are not proven.
fn unproven(pool: &Pool<'_>, asked: &Asked<'_>, (others, goal): (&[usize], f64)) -> Option<String> {
    let trial = |one: &usize| asked.trials.of(&pool.all[*one].decision);
    let is_open = |one: &&usize| {
        trial(one).is_none_or(|trial| trial.purpose == Purpose::Compare)
            && may_exceed(pool, (**one, pool.models.caution()), noticeably(goal))
    };
    let open: Vec<&usize> = others.iter().filter(is_open).collect();
    let compared = if open.iter().all(|one| trial(one).is_some()) { 0 } else { COMPARED };
    let rows = asked.there.rows.len() + compared + asked.settings.checks;
    let be = if open.len() == 1 { "Another place may be better" } else { "Other places may be better" };
    (!open.is_empty() && asked.settings.checks > 0)
        .then(|| format!("{be}: no rows are left to check, give at least --rows {rows}."))
}

/// Computes the gain of each active limit if it is relaxed by a tenth.
fn looser(pool: &mut Pool<'_>, limits: &[LimitState]) -> Result<Vec<Looser>, BestError> {
    let mut found = Vec::new();
    for (place, state) in limits.iter().enumerate().filter(|(_, state)| state.binds) {
        let mut bounds = pool.models.bounds();
        let by = LOOSER * state.limit.abs();
        bounds[place] += if state.at_most { by } else { -by };
        pool.zoom(&bounds, 1 + place as u64)?;
        let (best, merit) = pool.best(&bounds);
        found.push(Looser {
            text: state.text.clone(),
            limit: bounds[place],
            goal: merit.holds.then(|| pool.all[best].goal()),
            settings: settings(pool.space, &pool.all[best].decision),
        });
    }
    Ok(found)
}

fn effects(space: &Space<'_>, models: &Models, decision: &Decision) -> Result<Vec<Effect>, BestError> {
    let mut effects = Vec::new();
    for place in 0..decision.len() {
        let moved: Vec<Decision> = space.around(decision, place, MOVED);
        let found = models.expected(space, &moved)?;
        effects.push(effect(&space.info(place).name, true, &found));
    }
    for place in 0..space.uncertain.len() {
        let one = space.between(place, BETWEEN);
        let found = models.expected(&one, std::slice::from_ref(decision))?;
        // Each node by itself.
        let nodes = |node: usize| Expected {
            decision: decision.clone(),
            success: vec![found[0].success[node]],
            at: found[0].at.iter().map(|at| vec![at[node]]).collect(),
        };
        let ends: Vec<Expected> = (0..one.nodes.len()).map(nodes).collect();
        effects.push(effect(&space.uncertain_info(place).name, false, &ends));
    }
    Ok(effects)
}

/// The change over some decisions.
fn effect(factor: &str, decision: bool, found: &[Expected]) -> Effect {
    let change = |place: usize| {
        let means = found.iter().map(|of| super::robust::expected(&of.at[place]));
        let span = means.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], mean| [low.min(mean), high.max(mean)]);
        span[1] - span[0]
    };
    let values = found.first().map_or(0, |of| of.at.len());
    Effect { factor: factor.to_owned(), decision, goal: change(0), limits: (1..values).map(change).collect() }
}

fn uncertainty(space: &Space<'_>, models: &Models, found: &Expected) -> Uncertainty {
    let nodes = &found.at[0];
    let mean = found.goal();
    let variance = nodes.iter().map(|node| (node.mean - mean).powi(2)).sum::<f64>() / nodes.len() as f64;
    let (factors, model) = (variance.sqrt(), found.goal_error());
    let scatter = nodes.iter().map(|node| node.scatter).fold(0.0, f64::max);
    let names: Vec<&str> = (0..space.uncertain.len()).map(|place| space.uncertain_info(place).name.as_str()).collect();
    let binding = models.wanted.iter().enumerate().skip(1).map(|(place, wanted)| {
        let at = &found.at[place];
        let mean = super::robust::expected(at);
        let spread = (at.iter().map(|node| (node.mean - mean).powi(2)).sum::<f64>() / at.len() as f64).sqrt();
        (spread, super::robust::expected_error(at), wanted.bound.unwrap_or_default())
    });
    // At an active limit, everything that widens the limited value costs most.
    let (by_factors, by_model) = binding.fold((factors, model), |(a, b), (spread, error, _)| (a + spread, b + error));
    let advice = match (names.is_empty(), by_factors >= by_model.max(scatter)) {
        (false, true) => format!("measure {}: a narrower distribution leaves more room", names.join(" and ")),
        _ if model + by_model >= scatter => {
            "run more rows (`decore best --rows`): the models cause most of the uncertainty".to_owned()
        }
        _ => "runs scatter: average over longer runs (`duration_s`), or accept the spread".to_owned(),
    };
    Uncertainty { factors, model, scatter, advice }
}

fn notes(models: &Models, (settings, added): (&BestSettings, usize), verdict: Verdict) -> Vec<String> {
    let mut notes = Vec::new();
    for place in 0..models.wanted.len() {
        let (figures, of) = models.output(place);
        if let Some(value) = of.constant {
            let value = crate::sensitivity::four_digits(value);
            notes.push(format!("{} is {value} in all rows: every place is as good.", figures.output));
        }
        let Some(process) = &figures.process else { continue };
        if process.least_q2() < LEAST_Q2 && process.noise_std_dev < 0.7 * process.rms_error {
            notes.push(format!(
                "The model of {} is poor (Q2 {:.2}): run more rows before you rely on it.",
                figures.output,
                process.least_q2()
            ));
        }
        let out: u64 = figures.left_out.iter().map(|left_out| left_out.count).sum();
        if out > 0 && place == 0 {
            let reason = figures.left_out.first().map_or("", |first| first.reason.as_str());
            notes.push(format!(
                "{out} of {} rows have no value ({reason}); places where rows fail count as breaking the limits.",
                figures.used + out
            ));
        }
    }
    if verdict == Verdict::Unchecked && settings.checks > 0 {
        notes.push(format!("No rows are left to prove it: give at least --rows {}.", added + settings.checks));
    }
    if verdict == Verdict::Refuted {
        notes.push(format!("Give more rows to improve the proposal: --rows {}.", 2 * settings.rows.max(1)));
    }
    notes
}

impl Space<'_> {
    /// A decision with one factor moved over a share of its range to either side; of names, each of them.
    fn around(&self, decision: &Decision, place: usize, reach: f64) -> Vec<Decision> {
        let share = match decision[place] {
            Level::Category(_) => 0.0,
            _ => self.place(decision)[place],
        };
        self.varied(
            decision,
            place,
            [-1.0, -0.5, 0.0, 0.5, 1.0].into_iter().map(|step| (share + reach * step).clamp(0.0, 1.0)),
        )
    }

    /// The space with two nodes: one uncertain factor at two shares of its distribution, the others at their medians.
    fn between(&self, place: usize, shares: [f64; 2]) -> Space<'_> {
        let node = |share: f64| {
            let level = |(other, factor): (usize, &usize)| {
                let distribution = &self.study.design().factors()[*factor].distribution;
                distribution.quantile(if other == place { share } else { 0.5 })
            };
            self.uncertain.iter().enumerate().map(level).collect::<Vec<Level>>()
        };
        let (decisions, uncertain) = (self.decisions.clone(), self.uncertain.clone());
        Space { study: self.study, decisions, uncertain, nodes: shares.map(node).to_vec() }
    }
}

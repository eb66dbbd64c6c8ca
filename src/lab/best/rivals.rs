//! Decisions that are run before one is proposed: models can err by more than they expect, runs do not.

use super::error::BestError;
use super::search::Pool;
use super::space::Decision;
use super::trials::Trials;
use decore_statistics::design::Placement;

/// Runs that compare a decision with others.
pub(super) const COMPARED: usize = 4;
/// Number of alternatives.
pub(super) const ALTERNATIVES: usize = 3;
/// Share of the goal below which no decision is noticeably better than another one.
const NOTICEABLE: f64 = 0.005;

/// The least goal that is noticeably better. Goals are larger where they are better.
pub(super) fn noticeably(goal: f64) -> f64 {
    goal + NOTICEABLE * goal.abs()
}

/// Finds at most so many decisions to compare by runs: the best one by the models and the best ones at other places, later only decisions
/// that may be better than all that were run.
pub(super) fn rivals(pool: &Pool<'_>, trials: &Trials, most: usize) -> Vec<usize> {
    let bounds = pool.models.bounds();
    let (best, merit) = pool.best(&bounds);
    if !merit.holds {
        return Vec::new();
    }
    let (own, caution) = (&pool.all[best].decision, pool.models.caution());
    let least = known(pool, trials).map_or(f64::NEG_INFINITY, noticeably);
    let is_new = trials.of(own).is_none() && merit.goal > least;
    let order = pool.ranked(&bounds, (usize::MAX, 0.0)).into_iter();
    let may = order.filter(|one| may_exceed(pool, (*one, caution), least));
    let others = pool.elsewhere(may, &[trials.decisions(), vec![own.clone()]].concat(), ALTERNATIVES);
    let rivals: Vec<usize> = is_new.then_some(best).into_iter().chain(others).take(most).collect();
    // Nothing to compare: it is checked at once.
    if trials.all.is_empty() && rivals.len() < 2 { Vec::new() } else { rivals }
}

/// Whether a decision holds the limits, and may have a better goal if the models err by so many standard deviations to its disadvantage.
pub(super) fn may_exceed(pool: &Pool<'_>, (one, caution): (usize, f64), least: f64) -> bool {
    let of = &pool.all[one];
    let merit = pool.merit(of, &pool.models.bounds());
    merit.holds && merit.goal + caution * of.goal_error() > least
}

/// Goal of the best decision that was run and holds the limits.
fn known(pool: &Pool<'_>, trials: &Trials) -> Option<f64> {
    let expected = (0..pool.run).map(|one| pool.merit(&pool.all[one], &pool.models.bounds()));
    let compared = expected.zip(trials.decisions()).filter(|(merit, of)| merit.holds && !trials.is_checked(of));
    let proven = trials.proven().map(|(_, goal)| goal);
    compared.map(|(merit, _)| merit.goal).chain(proven).reduce(f64::max)
}

/// Finds the decision to prove: not checked, and noticeably better than the proven ones. Without uncertain factors, decisions that were run
/// come first: their few runs nearly prove them. Otherwise, a few runs only correct the models.
pub(super) fn candidate(pool: &Pool<'_>, trials: &Trials) -> Option<usize> {
    let proven = trials.proven().map(|(_, goal)| goal);
    let least = proven.map_or(f64::NEG_INFINITY, noticeably);
    let is_open = |one: &usize| may_exceed(pool, (*one, 0.0), least) && !trials.is_checked(&pool.all[*one].decision);
    let order = pool.ranked(&pool.models.bounds(), (usize::MAX, 0.0));
    let open: Vec<usize> = order.into_iter().filter(is_open).collect();
    let run = open.iter().copied().find(|one| *one < pool.run);
    let first = open.first().copied();
    match (proven.is_some(), pool.space.uncertain.is_empty()) {
        (true, _) => run,
        (false, true) => run.or(first),
        (false, false) => first,
    }
}

/// Rows of a decision with draws of the uncertain factors; without such factors, with values varied within the accuracy of their
/// setting. The first of these has exactly the decision. `before`: number of rows that were added.
pub(super) fn drawn(
    pool: &Pool<'_>,
    decision: &Decision,
    (count, before): (usize, usize),
) -> Result<Vec<Vec<String>>, BestError> {
    let space = pool.space;
    if space.uncertain.is_empty() {
        let varied = (1..count).map(|row| space.jittered(decision, (before + row) as u64));
        let decisions = std::iter::once(decision.clone()).chain(varied);
        return Ok(decisions.map(|one| space.cells(&space.levels(&one, &[]))).collect());
    }
    let draws = space.draws(count, Placement::Random, 1 + before as u64)?;
    Ok(draws.iter().map(|node| space.cells(&space.levels(decision, node))).collect())
}

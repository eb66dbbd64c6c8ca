//! Rows to run next: rows that narrow the choice, then the proposal with draws of the uncertain factors.

use super::answer::{Asked, answer};
use super::checks::Checks;
use super::error::BestError;
use super::model::Models;
use super::result::Answer;
use super::search::Pool;
use super::space::Space;
use super::task::{BestSettings, Purpose, There, question};
use crate::refinement::{LEAST_DISTANCE, Learned, is_apart, learning};
use decore_dataset::DatasetReader;
use decore_statistics::design::Placement;
use decore_study::{CheckedStudy, Goal};

/// Decisions among whose nodes rows are chosen.
const OPEN: usize = 12;
/// Smallest distance between them, as a share of the ranges.
const OPEN_APART: f64 = 0.01;
/// Share of the goal below which no decision may be better: then the choice is made.
const CHOSEN: f64 = 0.005;

/// Next step of a search.
#[derive(Debug)]
pub enum Step {
    /// Rows to add: values of all factors as cells of a table.
    More {
        /// The rows.
        rows: Vec<Vec<String>>,
        /// Purpose of the rows.
        purpose: Purpose,
        /// Progress for the user.
        progress: String,
    },
    /// Nothing is left to run.
    Done(Box<Answer>),
}

/// Decides the next rows, or answers. Depends only on the study, its seed, the settings and the rows.
///
/// # Errors
/// Those of [`Models::fit`]; [`BestError::NoGoal`], [`BestError::NoDecision`], [`BestError::NoCandidates`].
pub fn next(study: &CheckedStudy, there: There<'_>, settings: &BestSettings) -> Result<Step, BestError> {
    let goal = study.study().goal().ok_or(BestError::NoGoal)?;
    let space = Space::new(study)?;
    let others: Vec<&DatasetReader> = there.added.into_iter().collect();
    let models = Models::fit(goal, there.base, &others)?;
    let pool = Pool::new(&space, &models)?;
    let (left, batch) = (settings.rows.saturating_sub(there.rows.len()), settings.batch);
    let checked = checks(goal, there, &models)?;
    if checked.as_ref().is_none_or(|checks| !checks.are_held(goal.confidence)) {
        let (best, merit) = pool.best(&models.bounds());
        let room = left >= batch + settings.checks;
        if room && batch > 0 && !is_chosen(&pool) {
            let rows = to_learn(&pool, batch)?;
            if !rows.is_empty() {
                let progress = super::text::progress(&pool, best, merit);
                return Ok(Step::More { rows, purpose: Purpose::Learn, progress });
            }
        }
        if merit.holds && settings.checks > 0 && left >= settings.checks {
            let rows = to_check(&pool, best, (settings.checks, there.rows.len()))?;
            let progress = super::text::progress(&pool, best, merit);
            return Ok(Step::More { rows, purpose: Purpose::Check, progress });
        }
    }
    Ok(Step::Done(Box::new(answer(pool, &Asked { checked, settings, there, study })?)))
}

/// Returns the checks of the last proposal; `None` without checks, or if they belong to another question.
///
/// # Errors
/// Damaged or missing files of the dataset.
pub(super) fn checks(goal: &Goal, there: There<'_>, models: &Models) -> Result<Option<Checks>, BestError> {
    let last = there.rows.last().filter(|row| row.question == question(goal)).map(|row| row.purpose);
    match (there.added, last) {
        (Some(added), Some(Purpose::Check)) => Ok(Some(Checks::read(added, models, there.rows)?)),
        _ => Ok(None),
    }
}

/// Returns the answer that the models of the existing rows expect, without checks.
///
/// # Errors
/// As [`next`].
pub fn expected(study: &CheckedStudy, reader: &DatasetReader) -> Result<Answer, BestError> {
    let settings = BestSettings { rows: 0, checks: 0, batch: 0 };
    match next(study, There { base: reader, added: None, rows: &[] }, &settings)? {
        Step::Done(answer) => Ok(*answer),
        // Without a budget there is nothing to run.
        Step::More { .. } => Err(BestError::NoDecision),
    }
}

/// Rows of a batch that narrow the choice, for a table with all rows; none if the choice is made.
///
/// # Errors
/// As [`next`].
pub fn learn(study: &CheckedStudy, reader: &DatasetReader, batch: usize) -> Result<Vec<Vec<String>>, BestError> {
    let goal = study.study().goal().ok_or(BestError::NoGoal)?;
    let space = Space::new(study)?;
    let models = Models::fit(goal, reader, &[])?;
    let pool = Pool::new(&space, &models)?;
    if is_chosen(&pool) { Ok(Vec::new()) } else { to_learn(&pool, batch) }
}

/// Finds decisions that may be the best: all limits may hold, and the goal may be better than at the best decision within the limits. The
/// most promising first, with the possible gain.
fn open(pool: &Pool<'_>) -> Vec<(usize, f64)> {
    let (models, bounds) = (pool.models, pool.models.bounds());
    let (_, best) = pool.best(&bounds);
    let least = if best.holds { best.goal } else { f64::NEG_INFINITY };
    let may = |of: &super::model::Expected| {
        let goal = pool.sign() * of.goal() + models.caution() * of.goal_error();
        let share = of.held(&models.wanted, &bounds, -models.caution());
        (share >= models.confidence && goal > least).then_some(goal - least)
    };
    let mut open: Vec<(usize, f64)> =
        pool.all.iter().enumerate().filter_map(|(place, of)| may(of).map(|gain| (place, gain))).collect();
    open.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    open
}

/// Whether no decision may be noticeably better than the best one.
fn is_chosen(pool: &Pool<'_>) -> bool {
    let (_, best) = pool.best(&pool.models.bounds());
    let gain = open(pool).first().map_or(0.0, |(_, gain)| *gain);
    best.holds && gain <= CHOSEN * best.goal.abs()
}

fn to_learn(pool: &Pool<'_>, batch: usize) -> Result<Vec<Vec<String>>, BestError> {
    let (space, models) = (pool.space, pool.models);
    let order: Vec<usize> = open(pool).into_iter().map(|(place, _)| place).collect();
    let mut chosen = pool.apart(order, (OPEN, OPEN_APART));
    if chosen.is_empty() {
        // No limit may hold anywhere: it is looked at where it nearly does.
        chosen = pool.ranked(&models.bounds(), (OPEN, OPEN_APART));
    }
    let decisions: Vec<_> = chosen.iter().map(|place| pool.all[*place].decision.clone()).collect();
    let all = models.points(space, &decisions)?;
    let known: Vec<Vec<f64>> =
        (0..models.model.points.rows()).map(|row| models.model.points.row(row).to_vec()).collect();
    let free: Vec<usize> = (0..all.rows()).filter(|row| is_apart(all.row(*row), &known, LEAST_DISTANCE)).collect();
    if free.is_empty() {
        return Ok(Vec::new());
    }
    let points = all.select(&free);
    let success = models.success(&points)?;
    let learned = |place: usize| {
        let boundary = models.wanted[place].bound;
        models.process(place).map(|process| Learned { process, success: success.clone(), boundary })
    };
    let outputs: Vec<Learned<'_>> = (0..models.wanted.len()).filter_map(learned).collect();
    let rows = learning(&outputs, &points, batch)?;
    let nodes = space.nodes.len();
    let row = |row: usize| space.cells(&space.levels(&decisions[free[row] / nodes], &space.nodes[free[row] % nodes]));
    Ok(rows.into_iter().map(row).collect())
}

/// The proposal with draws of the uncertain factors; without such factors, with values varied within the accuracy of their setting.
fn to_check(pool: &Pool<'_>, best: usize, (count, before): (usize, usize)) -> Result<Vec<Vec<String>>, BestError> {
    let (space, decision) = (pool.space, &pool.all[best].decision);
    if space.uncertain.is_empty() {
        let row = |row: usize| space.cells(&space.levels(&space.jittered(decision, (before + row) as u64), &[]));
        return Ok((0..count).map(row).collect());
    }
    let draws = space.draws(count, Placement::Random, 1 + before as u64)?;
    Ok(draws.iter().map(|node| space.cells(&space.levels(decision, node))).collect())
}

//! Rows to run next: rows that narrow the choice, rows that compare the best places, then the proposal with draws of the uncertain factors.

use super::answer::{Asked, answer};
use super::error::BestError;
use super::model::Models;
use super::result::Answer;
use super::rivals::{ALTERNATIVES, COMPARED, candidate, drawn, noticeably, rivals};
use super::search::Pool;
use super::space::Space;
use super::task::{BestSettings, Purpose, There, question};
use super::trials::Trials;
use crate::refinement::{LEAST_DISTANCE, Learned, is_apart, learning};
use decore_dataset::DatasetReader;
use decore_study::CheckedStudy;

/// Decisions among whose nodes rows are chosen.
const OPEN: usize = 12;
/// Smallest distance between them, as a share of the ranges.
const OPEN_APART: f64 = 0.01;

/// Values of all factors as cells of a table, row by row.
type Rows = Vec<Vec<String>>;

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
    let trials = Trials::read(there, &question(goal), (&space, &models))?;
    let pool = Pool::new(&space, &models, &trials.decisions())?;
    if let Some((rows, purpose)) = more(&pool, &trials, (settings, there.rows.len()))? {
        let (best, merit) = pool.best(&models.bounds());
        return Ok(Step::More { rows, purpose, progress: super::text::progress(&pool, best, merit) });
    }
    Ok(Step::Done(Box::new(answer(pool, &Asked { trials: &trials, settings, there, study })?)))
}

/// Decides the next rows and their purpose; `None` if nothing is left to run. `before`: number of rows that were added.
fn more(
    pool: &Pool<'_>,
    trials: &Trials,
    (settings, before): (&BestSettings, usize),
) -> Result<Option<(Rows, Purpose)>, BestError> {
    let (left, batch, checks) = (settings.rows.saturating_sub(before), settings.batch, settings.checks);
    // Few draws of uncertain factors prove little: with such factors, rows that learn are worth more than rows that compare.
    let compares = pool.space.uncertain.is_empty();
    let spared = if compares { spared(settings) } else { 0 };
    let is_learning = trials.proven().is_none() && batch > 0 && left >= batch + checks + spared;
    if is_learning && !is_chosen(pool) {
        let rows = to_learn(pool, batch)?;
        if !rows.is_empty() {
            return Ok(Some((rows, Purpose::Learn)));
        }
    }
    if checks == 0 {
        return Ok(None);
    }
    let count = COMPARED.min(checks);
    let compare = |rows: usize| {
        let rivals = rivals(pool, trials, rows / count).into_iter();
        let rows = rivals.map(|one| drawn(pool, &pool.all[one].decision, (count, before)));
        let rows = rows.collect::<Result<Vec<_>, _>>()?.concat();
        Ok::<_, BestError>((!rows.is_empty()).then_some((rows, Purpose::Compare)))
    };
    if let Some(left) = left.checked_sub(checks) {
        if (compares || trials.proven().is_some())
            && let Some(more) = compare(left)?
        {
            return Ok(Some(more));
        }
        if let Some(one) = candidate(pool, trials) {
            return Ok(Some((drawn(pool, &pool.all[one].decision, (checks, before))?, Purpose::Check)));
        }
    }
    // Rows that prove nothing more show whether other places may be better.
    if trials.proven().is_some() { compare(left) } else { Ok(None) }
}

/// Rows that are not used to learn, so that places can be compared: at most a quarter of the rows that are not checks.
fn spared(settings: &BestSettings) -> usize {
    match settings.checks {
        0 => 0,
        checks => (COMPARED * (1 + ALTERNATIVES)).min(settings.rows.saturating_sub(checks) / 4),
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
    let pool = Pool::new(&space, &models, &[])?;
    if is_chosen(&pool) { Ok(Vec::new()) } else { to_learn(&pool, batch) }
}

/// Finds decisions that may be the best: all limits may hold, and the goal may be better than at the best decision within the limits. The
/// most promising first, with the possible gain.
fn open(pool: &Pool<'_>) -> Vec<(usize, f64)> {
    let (models, bounds) = (pool.models, pool.models.bounds());
    let (_, best) = pool.best(&bounds);
    let least = if best.holds { best.goal } else { f64::NEG_INFINITY };
    let may = |of: &super::model::Expected| {
        let goal = models.sign() * of.goal() + models.caution() * of.goal_error();
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
    best.holds && best.goal + gain <= noticeably(best.goal)
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

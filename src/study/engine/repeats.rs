//! Repeated rows of a design: rows with equal factors, and how each is run once.

use std::collections::{HashMap, VecDeque};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::sample::is_drawn;
use crate::CheckedStudy;
use decore_model::run::{RowOutcome, RowSource};
use decore_quantity::Value;
use decore_statistics::design::{Distribution, Kind};

/// Rows that are compared at most, the first ones of a sweep: later ones are all run. They take 16 bytes each while they are compared.
pub const MOST_COMPARED: usize = 1 << 20;
/// Outcomes that are kept at most for rows to come, some tens of megabytes; a row whose outcome was given up is run.
const MOST_KEPT: usize = 4096;
/// Time after which a thread looks again for an outcome that it waits for.
const LOOK: Duration = Duration::from_millis(50);

/// Rows of a sweep with equal factors.
#[derive(Debug, Default)]
pub struct Repeats {
    /// The class of each row that is not by itself.
    classes: HashMap<u64, usize>,
    /// Rows of each class.
    sizes: Vec<usize>,
}

impl Repeats {
    /// Compares these rows of a study, [`MOST_COMPARED`] at most. A row that is drawn for a numerical twin is by itself: rows with its
    /// factors have no such twin.
    pub fn of(study: &CheckedStudy, rows: impl Iterator<Item = u64>) -> Self {
        if never_repeats(study) {
            return Self::default();
        }
        let hash = |row: u64| (key(&study.row_values(row as usize)), row);
        let mut hashes: Vec<(u64, u64)> =
            rows.take(MOST_COMPARED).filter(|row| !is_drawn(study.study(), *row)).map(hash).collect();
        hashes.sort_unstable();
        let mut found = Self::default();
        for same in hashes.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() > 1) {
            // Rows of one hash with other values are by themselves: they are run, as if they were alone.
            let values = study.row_values(same[0].1 as usize);
            let equal: Vec<u64> = same.iter().map(|(_, row)| *row).collect();
            let equal: Vec<u64> =
                equal.into_iter().filter(|row| are_same(&values, &study.row_values(*row as usize))).collect();
            if equal.len() > 1 {
                found.classes.extend(equal.iter().map(|row| (*row, found.sizes.len())));
                found.sizes.push(equal.len());
            }
        }
        found
    }

    /// Rows that repeat an earlier one.
    pub fn count(&self) -> usize {
        self.classes.len() - self.sizes.len()
    }
}

/// Whether no two rows of a study can be the same: a factor varies continuously, and each row draws a value of its own.
fn never_repeats(study: &CheckedStudy) -> bool {
    let draws = matches!(
        study.design().kind(),
        Kind::LatinHypercube(_) | Kind::Sobol(_) | Kind::Halton(_) | Kind::Random(_) | Kind::Single(_)
    );
    let is_continuous = |distribution: &Distribution| distribution.value_count().is_none();
    draws && study.free_factors().any(|factor| factor.distribution().is_some_and(is_continuous))
}

fn key(values: &[Value]) -> u64 {
    let mut hasher = blake3::Hasher::new();
    for value in values {
        match value {
            Value::Real(value) => hasher.update(&value.to_bits().to_le_bytes()),
            other => hasher.update(other.to_string().as_bytes()).update(&[0]),
        };
    }
    let mut first = [0; 8];
    first.copy_from_slice(&hasher.finalize().as_bytes()[..8]);
    u64::from_le_bytes(first)
}

/// Whether values are the same to the last bit.
fn are_same(a: &[Value], b: &[Value]) -> bool {
    let same = |(a, b): (&Value, &Value)| match (a, b) {
        (Value::Real(a), Value::Real(b)) => a.to_bits() == b.to_bits(),
        _ => a == b,
    };
    a.len() == b.len() && a.iter().zip(b).all(same)
}

/// State of a class.
#[derive(Debug, Clone)]
enum ClassState {
    /// None of its rows runs, and no outcome is kept.
    Open,
    /// A row of it runs.
    Running,
    /// The outcome of a row of it.
    Ended(Box<RowOutcome>),
}

/// The outcomes of repeated rows while a sweep runs, shared by its threads.
#[derive(Debug)]
pub(super) struct Shared {
    repeats: Repeats,
    table: Mutex<RepeatTable>,
    /// A row that others repeat has ended.
    ended: Condvar,
}

#[derive(Debug)]
struct RepeatTable {
    states: Vec<ClassState>,
    /// Rows of each class that have not been given out.
    left: Vec<usize>,
    /// Classes with a kept outcome, the oldest first.
    kept: VecDeque<usize>,
}

/// Action of a thread on a row.
enum Turn {
    Run,
    Wait,
    Copy(Box<RowOutcome>),
}

impl Shared {
    pub fn new(repeats: Repeats) -> Self {
        let left = repeats.sizes.clone();
        let table = RepeatTable { states: vec![ClassState::Open; left.len()], left, kept: VecDeque::new() };
        Self { repeats, table: Mutex::new(table), ended: Condvar::new() }
    }

    fn lock(&self) -> MutexGuard<'_, RepeatTable> {
        self.table.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the action for a row of a class: the first row runs, the others wait for its outcome.
    fn turn(&self, class: usize) -> Turn {
        let mut table = self.lock();
        let turn = match &table.states[class] {
            ClassState::Open => Turn::Run,
            ClassState::Running => return Turn::Wait,
            ClassState::Ended(outcome) => Turn::Copy(Box::new(RowOutcome { wall_time_s: 0.0, ..(**outcome).clone() })),
        };
        table.left[class] = table.left[class].saturating_sub(1);
        match turn {
            Turn::Run => table.states[class] = ClassState::Running,
            _ if table.left[class] == 0 => table.give_up(class),
            _ => {}
        }
        turn
    }

    /// Stores the outcome of a class's row for later ones; `None` for a row that did not end.
    fn note(&self, class: usize, outcome: Option<&RowOutcome>) {
        let mut table = self.lock();
        table.states[class] = ClassState::Open;
        if let Some(outcome) = outcome.filter(|_| table.left[class] > 0) {
            if table.kept.len() == MOST_KEPT
                && let Some(oldest) = table.kept.front().copied()
            {
                table.give_up(oldest);
            }
            table.states[class] = ClassState::Ended(Box::new(outcome.clone()));
            table.kept.push_back(class);
        }
        drop(table);
        self.ended.notify_all();
    }
}

impl RepeatTable {
    fn give_up(&mut self, class: usize) {
        self.states[class] = ClassState::Open;
        self.kept.retain(|kept| *kept != class);
    }
}

/// The rows of a thread without those that repeat others: these get the outcome of the first that ran.
pub(super) struct Once<'a> {
    rows: &'a mut dyn RowSource,
    shared: &'a Shared,
    /// Classes whose row runs on this thread.
    running: Vec<(u64, usize)>,
    /// Rows of this thread that wait for the outcome of their class.
    waiting: Vec<(u64, usize)>,
}

impl<'a> Once<'a> {
    pub fn new(rows: &'a mut dyn RowSource, shared: &'a Shared) -> Self {
        Self { rows, shared, running: Vec::new(), waiting: Vec::new() }
    }

    /// A waiting row that has to be run after all; those whose outcomes are there end.
    fn waited(&mut self) -> Option<u64> {
        let mut place = 0;
        while let Some(&(row, class)) = self.waiting.get(place) {
            match self.shared.turn(class) {
                Turn::Wait => place += 1,
                Turn::Copy(outcome) => {
                    self.waiting.remove(place);
                    self.rows.ended(row, *outcome);
                }
                Turn::Run => {
                    self.waiting.remove(place);
                    self.running.push((row, class));
                    return Some(row);
                }
            }
        }
        None
    }
}

impl RowSource for Once<'_> {
    fn next(&mut self, wait: bool) -> Option<u64> {
        loop {
            if let Some(row) = self.waited() {
                return Some(row);
            }
            // A thread with waiting rows must not wait for the window, which may wait for these.
            let Some(row) = self.rows.next(wait && self.waiting.is_empty()) else {
                if !wait || self.waiting.is_empty() {
                    return None;
                }
                // Rows that these wait for run on other threads: all of this one have ended.
                let table = self.shared.lock();
                drop(self.shared.ended.wait_timeout(table, LOOK).unwrap_or_else(PoisonError::into_inner));
                continue;
            };
            match self.shared.repeats.classes.get(&row) {
                None => return Some(row),
                Some(class) => self.waiting.push((row, *class)),
            }
        }
    }

    fn ended(&mut self, row: u64, outcome: RowOutcome) {
        if let Some(at) = self.running.iter().position(|running| running.0 == row) {
            let (_, class) = self.running.swap_remove(at);
            self.shared.note(class, Some(&outcome));
        }
        self.rows.ended(row, outcome);
    }
}

impl Drop for Once<'_> {
    /// A thread that ends early leaves its rows to others.
    fn drop(&mut self) {
        self.running.iter().for_each(|(_, class)| self.shared.note(*class, None));
    }
}

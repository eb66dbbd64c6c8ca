//! Improves Latin hypercubes with swaps: wanted rank correlations, large distances, small discrepancies.

use super::constraint::Conditions;
use super::error::DesignError;
use super::mirrored::{self, Mirrored};
use super::optimise::{CentredDiscrepancy, Criterion, Crowding, Freedom, Schedule, Swap, anneal};
use super::ranks::Ranks;
use super::strata::HypercubeKind;
use super::table::{Builder, Candidate, Strata};
use decore_math::random::Stream;

/// Rank correlations are refined until none is farther than this from the one asked for.
const REFINED: f64 = 1e-3;
/// Largest deviation of rank correlations from the wanted ones while something else is optimised.
const STRAYED: f64 = 5e-3;
/// Swaps tried per entry to refine rank correlations.
const REFINING_SWAPS: usize = 200;

/// Squarings of squared distances: p = 32, which distinguishes nearly equal designs, and p = 16, which finds better optima of small ones.
const SHARP: u32 = 4;
const BLUNT: u32 = 3;

/// The best of several attempts: its badness and its strata.
type Best = Option<(f64, Vec<Vec<u32>>)>;

/// Kind of attempt: from a table, with a number of fixed rows.
#[derive(Clone, Copy)]
struct Attempt<'t> {
    table: &'t Strata,
    frozen: usize,
    schedule: Schedule,
}

/// Objective of the attempts, and their random numbers.
struct Sought<'s> {
    best: &'s mut Best,
    stream: &'s mut Stream,
}

impl Builder<'_, '_> {
    /// Swaps entries of new rows that are close in rank until the rank correlations are those asked for; constraints that hold go
    /// on to do so.
    pub fn refine(&mut self, table: &mut Strata, frozen: usize, stream: &mut Stream) -> Result<(), DesignError> {
        let Some(correlation) = self.correlation else {
            return Ok(());
        };
        let mut ranks = Ranks::new(correlation, &table.columns, frozen);
        let (fresh, columns) = (table.rows() - frozen, table.columns.len());
        for _ in 0..REFINING_SWAPS * fresh * columns {
            if ranks.worst() <= REFINED {
                break;
            }
            let column = stream.below(columns);
            let Some([a, b]) = ranks.neighbours(column, stream) else { continue };
            let swap = Swap { column, a: frozen + a, b: frozen + b };
            if ranks.change(swap) < 0.0 && self.meet_after(table, swap)? {
                table.columns[column].swap(swap.a, swap.b);
                ranks.swap(swap);
            }
        }
        Ok(())
    }

    /// Whether both rows of a swap meet the constraints after it.
    fn meet_after(&mut self, table: &mut Strata, Swap { column, a, b }: Swap) -> Result<bool, DesignError> {
        let Some(all) = self.conditions.as_ref().map(Conditions::all) else {
            return Ok(true);
        };
        let [mut row_a, mut row_b] = [table.strata(a), table.strata(b)];
        std::mem::swap(&mut row_a[column], &mut row_b[column]);
        Ok(self.meets(table, Candidate { row: a, strata: &row_a }, &all)?
            && self.meets(table, Candidate { row: b, strata: &row_b }, &all)?)
    }

    /// Anneals for the criterion of the hypercube.
    pub fn optimise(&mut self, table: &mut Strata, frozen: usize, stream: &mut Stream) -> Result<(), DesignError> {
        let best = match self.latin.spec.kind {
            HypercubeKind::Maximin => self.spread(table, frozen, stream)?,
            HypercubeKind::CentredDiscrepancy => {
                let (rows, volume) = volume(table);
                let proposals = self.affordable(volume.saturating_mul(10).max(100_000).min(200_000_000 / rows));
                let schedule = Schedule { proposals, thresholds: [0.01, 1e-6] };
                let points = self.points(table, (frozen, 1.0));
                let mut best = Best::default();
                let make = || CentredDiscrepancy::new(points.clone());
                self.attempt(Attempt { table, frozen, schedule }, make, &mut Sought { best: &mut best, stream })?;
                best
            }
            _ => Best::default(),
        };
        if let Some((_, columns)) = best {
            table.columns = columns;
        }
        Ok(())
    }

    /// Every proposal near acceptance asks the constraints, which cost more than the criterion.
    fn affordable(&self, proposals: u64) -> u64 {
        if self.conditions.is_some() { proposals / 10 } else { proposals }
    }

    /// Attempts at large distances; where no row is bound also such as keep the hypercube its own mirror image.
    fn spread(&mut self, table: &Strata, frozen: usize, stream: &mut Stream) -> Result<Best, DesignError> {
        let (rows, volume) = volume(table);
        let most = 600_000_000 / rows;
        if frozen == 0 && self.conditions.is_none() && self.correlation.is_none() {
            return self.spread_freely(table, stream);
        }
        let restarts = (60_000 / volume).clamp(1, 50);
        let thresholds = match volume {
            0..3000 => [0.3, 3e-3],
            3000..20_000 => [0.1, 1e-3],
            _ => [0.05, 1e-4],
        };
        let proposals = self.affordable(volume.saturating_mul(60).max(20_000).min(most));
        let schedule = Schedule { proposals, thresholds };
        let points = self.points(table, (frozen, rows as f64));
        let mut best = Best::default();
        for _ in 0..restarts {
            let make = || Crowding::<SHARP>::new(points.clone());
            self.attempt(Attempt { table, frozen, schedule }, make, &mut Sought { best: &mut best, stream })?;
        }
        Ok(best)
    }

    /// The same of rows that nothing binds. Measured over sizes up to (10, 100): small designs end in one of many local optima and
    /// want many attempts with a blunt criterion; larger ones a single long one; from (6, 50) on only mirrored ones count.
    fn spread_freely(&mut self, table: &Strata, stream: &mut Stream) -> Result<Best, DesignError> {
        let (rows, volume) = volume(table);
        let most = 600_000_000 / rows;
        let schedule = |proposals: u64, thresholds: [f64; 2]| Schedule { proposals, thresholds };
        let (plain, images) = match volume {
            0..1000 => (
                (60, schedule(40_000.min(150 * volume), [0.3, 0.03])),
                (12, schedule(120_000.min(450 * volume), [0.1, 0.01])),
            ),
            1000..3000 => ((1, schedule(1_200_000, [0.05, 5e-3])), (12, schedule(240_000, [0.1, 0.01]))),
            3000..15_000 => ((1, schedule(1_800_000, [0.05, 5e-3])), (1, schedule(1_800_000, [0.1, 1e-3]))),
            15_000..20_000 => ((0, schedule(0, [1.0; 2])), (1, schedule(1_800_000, [0.1, 1e-3]))),
            _ => {
                let proposals = volume.saturating_mul(30).max(1_800_000).min(most);
                ((0, schedule(0, [1.0; 2])), (1, schedule(proposals, [0.05, 1e-4])))
            }
        };
        let points = self.points(table, (0, rows as f64));
        let mut best = Best::default();
        for _ in 0..plain.0 {
            let attempt = Attempt { table, frozen: 0, schedule: plain.1 };
            if volume < 1000 {
                self.attempt(
                    attempt,
                    || Crowding::<BLUNT>::new(points.clone()),
                    &mut Sought { best: &mut best, stream },
                )?;
            } else {
                self.attempt(
                    attempt,
                    || Crowding::<SHARP>::new(points.clone()),
                    &mut Sought { best: &mut best, stream },
                )?;
            }
        }
        for _ in 0..images.0 {
            let attempt = Attempt { table, frozen: 0, schedule: images.1 };
            if volume < 3000 {
                mirrored::<BLUNT>(attempt, (&mut best, stream));
            } else {
                mirrored::<SHARP>(attempt, (&mut best, stream));
            }
        }
        Ok(best)
    }

    /// Coordinates in a cube of this side by column: new rows in the middle of their strata.
    fn points(&self, table: &Strata, (frozen, side): (usize, f64)) -> Vec<Vec<f64>> {
        let coordinate = |(row, stratum): (usize, &u32), column: usize| {
            let place = if row < frozen { self.latin.place(row, column) } else { 0.5 };
            (f64::from(*stratum) + place) / table.strata_of(row) as f64 * side
        };
        let column = |(column, entries): (usize, &Vec<u32>)| {
            entries.iter().enumerate().map(|entry| coordinate(entry, column)).collect()
        };
        table.columns.iter().enumerate().map(column).collect()
    }

    fn attempt<C: Criterion>(
        &mut self,
        Attempt { table, frozen, schedule }: Attempt<'_>,
        make: impl Fn() -> C,
        sought: &mut Sought<'_>,
    ) -> Result<(), DesignError> {
        let ranks = self.correlation.map(|correlation| Ranks::new(correlation, &table.columns, frozen));
        let strayed = ranks.as_ref().map_or(0.0, Ranks::worst).max(STRAYED);
        let mut guard = Guard { builder: self, table: table.clone(), ranks, strayed, applied: 0, error: None };
        let mut allowed = |taken: &[Swap], swap: Swap| guard.allows(taken, swap);
        let freedom = Freedom { columns: table.columns.len(), frozen, rows: table.rows(), allowed: &mut allowed };
        let swaps = anneal(&mut make(), schedule, freedom, sought.stream);
        if let Some(error) = guard.error {
            return Err(error);
        }
        let mut result = make();
        result.refresh();
        swaps.iter().for_each(|swap| result.swap(*swap));
        keep(sought.best, result.badness(), || {
            let mut columns = table.columns.clone();
            swaps.iter().for_each(|Swap { column, a, b }| columns[*column].swap(*a, *b));
            columns
        });
        Ok(())
    }
}

/// Number of rows of a table, and its square times the columns: the cost of a sweep over all pairs of rows.
fn volume(table: &Strata) -> (u64, u64) {
    let (rows, columns) = (table.rows() as u64, table.columns.len() as u64);
    (rows.max(1), rows.saturating_mul(rows).saturating_mul(columns))
}

/// An attempt that starts at random and keeps the hypercube its own mirror image; its rows are put into a random order.
fn mirrored<const SQUARINGS: u32>(
    Attempt { table, schedule, .. }: Attempt<'_>,
    (best, stream): (&mut Best, &mut Stream),
) {
    let rows = table.rows();
    let mut columns = mirrored::columns(rows, table.columns.len(), stream);
    let points = |columns: &[Vec<u32>]| {
        columns.iter().map(|column| column.iter().map(|stratum| f64::from(*stratum)).collect()).collect()
    };
    let mut criterion = Mirrored::new(Crowding::<SQUARINGS>::new(points(&columns)));
    let freedom = Freedom { columns: columns.len(), frozen: 0, rows, allowed: &mut |_, _| true };
    for swap in anneal(&mut criterion, schedule, freedom, stream) {
        for Swap { column, a, b } in [Some(swap), mirrored::companion(rows, swap)].into_iter().flatten() {
            columns[column].swap(a, b);
        }
    }
    let mut order: Vec<usize> = (0..rows).collect();
    stream.shuffle(&mut order);
    keep(best, Crowding::<SQUARINGS>::new(points(&columns)).badness(), || {
        columns.iter().map(|column| order.iter().map(|row| column[*row]).collect()).collect()
    });
}

/// Keeps the better one.
fn keep(best: &mut Best, badness: f64, columns: impl FnOnce() -> Vec<Vec<u32>>) {
    if best.as_ref().is_none_or(|(least, _)| badness < *least) {
        *best = Some((badness, columns()));
    }
}

/// Keeps an optimiser within the constraints and near the rank correlations; follows its swaps in a table of its own.
struct Guard<'g, 'a, 'b> {
    builder: &'g mut Builder<'a, 'b>,
    table: Strata,
    ranks: Option<Ranks>,
    /// Largest deviation of the rank correlations from the wanted ones.
    strayed: f64,
    applied: usize,
    error: Option<DesignError>,
}

impl Guard<'_, '_, '_> {
    fn allows(&mut self, taken: &[Swap], swap: Swap) -> bool {
        if self.builder.conditions.is_none() && self.ranks.is_none() {
            return true;
        }
        for done in taken.get(self.applied..).unwrap_or(&[]) {
            self.table.columns[done.column].swap(done.a, done.b);
            if let Some(ranks) = &mut self.ranks {
                ranks.swap(*done);
            }
        }
        self.applied = taken.len();
        if self.ranks.as_ref().is_some_and(|ranks| ranks.worst_after(swap) > self.strayed) {
            return false;
        }
        self.builder.meet_after(&mut self.table, swap).unwrap_or_else(|error| {
            self.error = Some(error);
            false
        })
    }
}

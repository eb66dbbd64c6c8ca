//! Latin hypercubes: plain, sliced, on orthogonal arrays, optimised, correlated, constrained, grown.

use super::Factor;
use super::coordinate::Coordinate;
use super::correlation::Correlation;
use super::distribution::Distribution;
use super::error::DesignError;
use super::optimise::{CentredDiscrepancy, Criterion, Crowding, Freedom, Schedule, Swap, anneal};
use super::orthogonal::{Field, bose};
use super::permutation::{Permutation, Stream, hash, uniform};

/// Most rows of an optimised hypercube: its effort and memory grow with their square.
const MAX_OPTIMISED_ROWS: usize = 3000;
/// Most entries (rows times factors) of a hypercube that is kept as a table.
const MAX_TABLE_ENTRIES: usize = 1 << 28;
/// Streams of random numbers beyond those of the factors, counted on by the stage.
const OPTIMISER_STREAM: u64 = 1 << 40;
const GROWTH_STREAM: u64 = 1 << 41;
const REPAIR_STREAM: u64 = 1 << 42;

/// Place of a point within its stratum.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Placement {
    /// Uniform at random.
    #[default]
    Random,
    /// In the stratum's middle.
    Centred,
}

/// What a Latin hypercube is chosen for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum HypercubeKind {
    /// At random among all.
    #[default]
    Random,
    /// A large smallest distance (by phi_p with p = 32 over the strata's middles).
    Maximin,
    /// A small centred L2 discrepancy (of the strata's middles).
    CentredDiscrepancy,
    /// Built on an orthogonal array of strength two (Tang 1993): `q^2` rows for a prime power `q`, at most `q + 1`
    /// factors; every pair of factors hits each of its `q x q` cells once.
    OrthogonalArray,
    /// Sliced over the categories (Qian 2012): there is a slice per combination of categories, row r belongs to slice
    /// `r mod slices`, and the other factors form a Latin hypercube in each slice and in the whole.
    Sliced,
}

/// A Latin hypercube.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct LatinHypercube {
    /// Number of rows.
    pub rows: usize,
    /// Numbers of rows that the design had before, ascending: its first rows are that design's.
    ///
    /// Each stage fills strata that the rows before it leave empty. The whole is a Latin hypercube where `rows` is a multiple
    /// of the stage before; otherwise as many strata are hit as the first rows allow.
    pub grown_from: Vec<usize>,
    /// Place of a point within its stratum.
    pub placement: Placement,
    /// What it is chosen for.
    pub kind: HypercubeKind,
}

/// Whether a row may be used.
pub(super) type Accept<'a> = dyn FnMut(&[Coordinate]) -> Result<bool, DesignError> + 'a;

/// A Latin hypercube ready to give rows.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Latin {
    spec: LatinHypercube,
    seed: u64,
    columns: usize,
    /// Number of categories per factor, where the hypercube is sliced; 1 for other factors.
    categories: Vec<u64>,
    form: Form,
}

#[derive(Debug, Clone, PartialEq)]
enum Form {
    /// Every row computed alone.
    Open,
    /// On an orthogonal array over this field, every row computed alone.
    Orthogonal(Field),
    Table(Table),
}

/// Strata by column and row; `stages`: number of strata and of rows at the end of each stage.
#[derive(Debug, Clone, PartialEq)]
struct Table {
    stages: Vec<usize>,
    columns: Vec<Vec<u32>>,
}

impl Latin {
    /// Checks and, where rows cannot be computed alone, makes the table.
    pub(super) fn new(
        spec: &LatinHypercube,
        factors: &[Factor],
        seed: u64,
        correlation: Option<&Correlation>,
    ) -> Result<Self, DesignError> {
        let categories = match spec.kind {
            HypercubeKind::Sliced => factors.iter().map(categories).collect(),
            _ => vec![1; factors.len()],
        };
        Self::open(spec, categories, seed)?.tabulated(correlation, None)
    }

    /// The same with rows that `accept` lets pass: entries of a column are swapped until all do.
    ///
    /// # Errors
    /// [`DesignError::Unsatisfiable`] if some rows find no partner, the errors of `accept`.
    pub(super) fn constrained(
        &self,
        correlation: Option<&Correlation>,
        accept: &mut Accept<'_>,
    ) -> Result<Self, DesignError> {
        Self::open(&self.spec, self.categories.clone(), self.seed)?.tabulated(correlation, Some(accept))
    }

    fn open(spec: &LatinHypercube, categories: Vec<u64>, seed: u64) -> Result<Self, DesignError> {
        let columns = categories.len();
        if spec.rows == 0 {
            return Err(DesignError::NoRows);
        }
        let stages = [spec.grown_from.as_slice(), &[spec.rows]].concat();
        if stages.first() == Some(&0) || stages.windows(2).any(|pair| pair[0] >= pair[1]) {
            let message = format!("{:?} and then {} rows do not ascend from 1", spec.grown_from, spec.rows);
            return Err(DesignError::setting("grown_from", message));
        }
        let form = match spec.kind {
            HypercubeKind::OrthogonalArray => Form::Orthogonal(array_field(spec.rows, columns)?),
            _ => Form::Open,
        };
        let slices = categories.iter().try_fold(1_u64, |product, count| product.checked_mul(*count));
        let slices = slices.ok_or(DesignError::TooManyRows)?;
        if !(spec.rows as u64).is_multiple_of(slices) {
            let message = format!(
                "{} rows do not divide into {slices} slices of the same size, one per combination of categories",
                spec.rows
            );
            return Err(DesignError::setting("rows", message));
        }
        let optimised = matches!(spec.kind, HypercubeKind::Maximin | HypercubeKind::CentredDiscrepancy);
        if optimised && spec.rows > MAX_OPTIMISED_ROWS {
            let message = format!(
                "{} rows are too many to optimise (at most {MAX_OPTIMISED_ROWS}): Sobol' points fill a cube as well",
                spec.rows
            );
            return Err(DesignError::setting("rows", message));
        }
        Ok(Self { spec: spec.clone(), seed, columns, categories, form })
    }

    fn tabulated(
        self,
        correlation: Option<&Correlation>,
        accept: Option<&mut Accept<'_>>,
    ) -> Result<Self, DesignError> {
        let optimised = matches!(self.spec.kind, HypercubeKind::Maximin | HypercubeKind::CentredDiscrepancy);
        let plain = optimised || self.spec.kind == HypercubeKind::Random;
        let (grown, constrained) = (!self.spec.grown_from.is_empty(), accept.is_some());
        if !plain && (grown || constrained || correlation.is_some()) {
            return Err(DesignError::setting(
                "optimise",
                "sliced hypercubes and those on orthogonal arrays cannot be grown, constrained or correlated: that would \
                 break their structure",
            ));
        }
        if optimised && correlation.is_some() {
            return Err(DesignError::setting(
                "optimise",
                "a correlated hypercube cannot be optimised: the points shall not fill the cube",
            ));
        }
        if !(optimised || grown || constrained || correlation.is_some()) {
            return Ok(self);
        }
        if self.spec.rows.saturating_mul(self.columns) > MAX_TABLE_ENTRIES {
            return Err(DesignError::TooManyRows);
        }
        let table = Builder { latin: &self, accept }.build(correlation)?;
        Ok(Self { form: Form::Table(table), ..self })
    }

    /// Whether rows are computed alone, without a table.
    pub(super) fn is_open(&self) -> bool {
        !matches!(self.form, Form::Table(_))
    }

    pub(super) fn at(&self, row: usize, column: usize) -> Coordinate {
        let count = self.categories.get(column).copied().unwrap_or(1);
        if count > 1 {
            // The last factor's category changes fastest.
            let faster: u64 = self.categories.iter().skip(column + 1).product();
            return Coordinate::Step { step: row as u64 / faster % count, count };
        }
        let (stratum, strata) = match &self.form {
            Form::Table(table) => {
                let stratum = table.columns.get(column).and_then(|column| column.get(row)).copied().unwrap_or(0);
                (u64::from(stratum), table.strata_of(row) as u64)
            }
            Form::Open => (self.open_stratum(row as u64, column as u64), self.spec.rows as u64),
            Form::Orthogonal(field) => (self.array_stratum(field, row as u64, column as u64), self.spec.rows as u64),
        };
        Coordinate::Stratum { stratum, strata, place: self.place(row, column) }
    }

    /// Two streams per factor: one for the permutation, one for the places within the strata.
    fn place(&self, row: usize, column: usize) -> f64 {
        match self.spec.placement {
            Placement::Random => uniform(self.seed, 2 * column as u64 + 1, row as u64),
            Placement::Centred => 0.5,
        }
    }

    fn open_stratum(&self, row: u64, column: u64) -> u64 {
        let key = hash(self.seed, 2 * column, 0);
        // A grown design starts as the first one did.
        let rows = self.spec.grown_from.first().copied().unwrap_or(self.spec.rows) as u64;
        match self.spec.kind {
            HypercubeKind::Sliced => {
                let slices: u64 = self.categories.iter().product();
                let (slice, index, coarse) = (row % slices, row / slices, rows / slices);
                let stratum = Permutation::new(hash(key, 1, slice), coarse).at(index);
                stratum * slices + Permutation::new(hash(key, 2, stratum), slices).at(slice)
            }
            _ => Permutation::new(key, rows).at(row),
        }
    }

    /// Symbols and the strata within a symbol are permuted at random.
    fn array_stratum(&self, field: &Field, row: u64, column: u64) -> u64 {
        let key = hash(self.seed, 2 * column, 0);
        let order = field.order();
        let scattered = Permutation::new(hash(self.seed, OPTIMISER_STREAM, 0), order * order).at(row);
        let (symbol, rank) = bose(field, scattered, column);
        let fine = Permutation::new(hash(key, 3, symbol), order).at(rank);
        Permutation::new(key, order).at(symbol) * order + fine
    }
}

/// Number of categories; 1 for other factors.
fn categories(factor: &Factor) -> u64 {
    match factor.distribution {
        Distribution::Categories { count } => count as u64,
        _ => 1,
    }
}

fn array_field(rows: usize, columns: usize) -> Result<Field, DesignError> {
    let field = |order: u64| Field::new(order).filter(|_| columns as u64 <= order + 1);
    let order = rows.isqrt() as u64;
    let exact = field(order).filter(|_| order as usize * order as usize == rows);
    exact.ok_or_else(|| {
        let below = (2..=order).rev().find(|order| field(*order).is_some()).map(|order| order * order);
        let above = (order + 1..).take(1000).find(|order| field(*order).is_some()).map(|order| order * order);
        let near: Vec<String> = [below, above].into_iter().flatten().map(|rows| rows.to_string()).collect();
        let message = format!(
            "no orthogonal array of {rows} rows for {columns} factors: expected the square of a prime power, e.g. {}",
            near.join(" or ")
        );
        DesignError::setting("rows", message)
    })
}

impl Table {
    fn strata_of(&self, row: usize) -> usize {
        self.stages.iter().copied().find(|stage| row < *stage).unwrap_or(1)
    }
}

struct Builder<'a, 'b> {
    latin: &'a Latin,
    accept: Option<&'a mut Accept<'b>>,
}

impl Builder<'_, '_> {
    fn build(mut self, correlation: Option<&Correlation>) -> Result<Table, DesignError> {
        let spec = &self.latin.spec;
        let mut table = Table { stages: Vec::new(), columns: vec![Vec::new(); self.latin.columns] };
        for (stage, &rows) in spec.grown_from.iter().chain([&spec.rows]).enumerate() {
            let frozen = table.stages.last().copied().unwrap_or(0);
            let key = |stream: u64| hash(self.latin.seed, stream, stage as u64);
            if frozen == 0 {
                for (column, strata) in table.columns.iter_mut().enumerate() {
                    strata.extend((0..rows).map(|row| self.latin.open_stratum(row as u64, column as u64) as u32));
                }
            } else {
                self.grow(&mut table, rows, &mut Stream::new(key(GROWTH_STREAM)));
            }
            table.stages.push(rows);
            if let Some(correlation) = correlation {
                let mut fresh: Vec<&mut [u32]> =
                    table.columns.iter_mut().filter_map(|column| column.get_mut(frozen..)).collect();
                correlation.rearrange(&mut fresh)?;
            }
            self.repair(&mut table, frozen, &mut Stream::new(key(REPAIR_STREAM)))?;
            self.optimise(&mut table, frozen, &mut Stream::new(key(OPTIMISER_STREAM)))?;
        }
        Ok(table)
    }

    /// Adds rows in strata that are empty, the ones farthest from being hit first where there are more than rows.
    fn grow(&self, table: &mut Table, rows: usize, stream: &mut Stream) {
        let frozen = table.stages.last().copied().unwrap_or(0);
        for column in 0..self.latin.columns {
            let mut hit = vec![false; rows];
            for row in 0..frozen {
                if let Some(hit) = hit.get_mut(self.stratum_among(table, (row, column), rows)) {
                    *hit = true;
                }
            }
            let empty: Vec<u32> = (0..rows as u32).filter(|stratum| !hit[*stratum as usize]).collect();
            let added = rows - frozen;
            // Evenly spread over the empty strata; there are at least as many as rows are added.
            let spread = |index: usize| empty[((2 * index + 1) * empty.len()) / (2 * added)];
            let mut fresh: Vec<u32> = (0..added).map(spread).collect();
            stream.shuffle(&mut fresh);
            table.columns[column].extend(fresh);
        }
    }

    /// Stratum of an earlier row when the range is cut into `strata` ones.
    fn stratum_among(&self, table: &Table, (row, column): (usize, usize), strata: usize) -> usize {
        let before = table.strata_of(row);
        let stratum = table.columns[column][row] as usize;
        // In whole numbers as far as possible: exact where the new number is a multiple of the old.
        let (whole, rest) = (stratum * strata / before, stratum * strata % before);
        let place = self.latin.place(row, column) * strata as f64;
        (whole + ((rest as f64 + place) / before as f64) as usize).min(strata - 1)
    }

    fn row(&self, table: &Table, row: usize) -> Vec<Coordinate> {
        let strata = table.strata_of(row) as u64;
        let coordinate = |(column, entries): (usize, &Vec<u32>)| {
            let place = self.latin.place(row, column);
            Coordinate::Stratum { stratum: u64::from(entries[row]), strata, place }
        };
        table.columns.iter().enumerate().map(coordinate).collect()
    }

    fn accepts(&mut self, table: &Table, row: usize) -> Result<bool, DesignError> {
        let coordinates = self.row(table, row);
        self.accept.as_mut().map_or(Ok(true), |accept| accept(&coordinates))
    }

    /// Swaps entries of new rows until the constraints hold in all of them.
    fn repair(&mut self, table: &mut Table, frozen: usize, stream: &mut Stream) -> Result<(), DesignError> {
        if self.accept.is_none() {
            return Ok(());
        }
        let rows = table.columns.first().map_or(0, Vec::len);
        let fresh = rows - frozen;
        let mut sound = (frozen..rows).map(|row| self.accepts(table, row)).collect::<Result<Vec<bool>, _>>()?;
        let mut bad: Vec<usize> = (0..fresh).filter(|row| !sound[*row]).collect();
        let mut left = 10_000 + 200 * fresh;
        while let Some(&last) = bad.last() {
            if sound[last] {
                bad.pop();
                continue;
            }
            if left == 0 || fresh < 2 {
                let open = sound.iter().filter(|sound| !**sound).count();
                return Err(DesignError::Unsatisfiable(format!(
                    "the constraints cannot be met by a Latin hypercube: {open} of {fresh} rows break them whatever is \
                     swapped, because every stratum of every factor must be used; narrow the ranges, or choose a kind \
                     that leaves out rows (`sobol`, `halton`, `random`)"
                )));
            }
            left -= 1;
            let column = stream.below(self.latin.columns);
            let other = stream.below(fresh);
            if other == last {
                continue;
            }
            let (a, b) = (frozen + last, frozen + other);
            table.columns[column].swap(a, b);
            let after = [self.accepts(table, a)?, self.accepts(table, b)?];
            let score = |pair: [bool; 2]| u8::from(pair[0]) + u8::from(pair[1]);
            if score(after) < score([sound[last], sound[other]]) {
                table.columns[column].swap(a, b);
                continue;
            }
            if sound[other] && !after[1] {
                bad.push(other);
            }
            [sound[last], sound[other]] = after;
        }
        Ok(())
    }

    fn optimise(&mut self, table: &mut Table, frozen: usize, stream: &mut Stream) -> Result<(), DesignError> {
        let kind = self.latin.spec.kind;
        let points = self.points(table, frozen);
        let (rows, columns) = (points.first().map_or(0, Vec::len) as u64, points.len() as u64);
        let volume = rows.saturating_mul(rows).saturating_mul(columns);
        let limit = |per_row: u64| per_row / rows.max(1);
        let scaled = |factor: f64| points.iter().map(|column| column.iter().map(|x| x * factor).collect()).collect();
        match kind {
            HypercubeKind::Maximin => {
                let proposals = volume.saturating_mul(60).max(20_000).min(limit(600_000_000));
                // Small designs end in one of many local optima: the best of several, from higher thresholds.
                let restarts = (60_000 / volume.max(1)).clamp(1, 50) as usize;
                let thresholds = match volume {
                    0..3000 => [0.3, 3e-3],
                    3000..20_000 => [0.1, 1e-3],
                    _ => [0.05, 1e-4],
                };
                let make = || Crowding::new(scaled(rows as f64));
                self.best_of(table, (frozen, restarts), (make, proposals, thresholds), stream)
            }
            HypercubeKind::CentredDiscrepancy => {
                let proposals = volume.saturating_mul(10).max(100_000).min(limit(200_000_000));
                let make = || CentredDiscrepancy::new(scaled(1.0));
                self.best_of(table, (frozen, 1), (make, proposals, [0.01, 1e-6]), stream)
            }
            _ => Ok(()),
        }
    }

    /// Coordinates in the unit cube by column: new rows in the middle of their strata.
    fn points(&self, table: &Table, frozen: usize) -> Vec<Vec<f64>> {
        let coordinate = |(row, stratum): (usize, &u32), column: usize| {
            let place = if row < frozen { self.latin.place(row, column) } else { 0.5 };
            (f64::from(*stratum) + place) / table.strata_of(row) as f64
        };
        let column = |(column, entries): (usize, &Vec<u32>)| {
            entries.iter().enumerate().map(|entry| coordinate(entry, column)).collect()
        };
        table.columns.iter().enumerate().map(column).collect()
    }

    fn best_of<C: Criterion>(
        &mut self,
        table: &mut Table,
        (frozen, restarts): (usize, usize),
        (make, proposals, thresholds): (impl Fn() -> C, u64, [f64; 2]),
        stream: &mut Stream,
    ) -> Result<(), DesignError> {
        // Every proposal near acceptance asks the constraints, which cost more than the criterion.
        let proposals = if self.accept.is_some() { proposals / 10 } else { proposals };
        let schedule = Schedule { proposals, thresholds };
        let mut best: Option<(f64, Vec<Swap>)> = None;
        for _ in 0..restarts {
            let mut criterion = make();
            let mut guard = Guard { builder: self, table: table.clone(), applied: 0, error: None };
            let mut allowed = |taken: &[Swap], swap: Swap| guard.allows(taken, swap);
            let rows = table.columns.first().map_or(0, Vec::len);
            let freedom = Freedom { columns: table.columns.len(), frozen, rows, allowed: &mut allowed };
            let swaps = anneal(&mut criterion, schedule, freedom, stream);
            if let Some(error) = guard.error {
                return Err(error);
            }
            let mut result = make();
            result.refresh();
            swaps.iter().for_each(|swap| result.swap(*swap));
            let badness = result.badness();
            if best.as_ref().is_none_or(|(least, _)| badness < *least) {
                best = Some((badness, swaps));
            }
        }
        for Swap { column, a, b } in best.into_iter().flat_map(|(_, swaps)| swaps) {
            table.columns[column].swap(a, b);
        }
        Ok(())
    }
}

/// Keeps an optimiser within the constraints; follows its swaps in a table of its own.
struct Guard<'g, 'a, 'b> {
    builder: &'g mut Builder<'a, 'b>,
    table: Table,
    applied: usize,
    error: Option<DesignError>,
}

impl Guard<'_, '_, '_> {
    fn allows(&mut self, taken: &[Swap], swap: Swap) -> bool {
        if self.builder.accept.is_none() {
            return true;
        }
        for Swap { column, a, b } in taken.get(self.applied..).unwrap_or(&[]) {
            self.table.columns[*column].swap(*a, *b);
        }
        self.applied = taken.len();
        let Swap { column, a, b } = swap;
        self.table.columns[column].swap(a, b);
        let verdicts = [a, b].map(|row| self.builder.accepts(&self.table, row));
        self.table.columns[column].swap(a, b);
        verdicts.into_iter().all(|verdict| {
            verdict.unwrap_or_else(|error| {
                self.error = Some(error);
                false
            })
        })
    }
}

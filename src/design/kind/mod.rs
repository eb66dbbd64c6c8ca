//! Kinds of designs, and the generators of their points, addressed by row.

mod factorial;
mod fraction;
mod halton;
mod sensitivity;

use std::sync::Arc;

use factorial::{OneAtATime, Shares, box_behnken, central_composite, screening};
use fraction::Fraction;
use halton::Halton;
use sensitivity::{Morris, Saltelli};

use super::constraint::Conditions;
use super::coordinate::Coordinate;
use super::correlation::Correlation;
use super::distribution::{Distribution, Level};
use super::error::{DesignError, MOST_ROWS};
use super::factor::Factor;
use super::latin::Latin;
use super::permutation::{hash, uniform};
use super::sobol::{MAX_DIMENSIONS, Sobol};
use super::strata::LatinHypercube;

pub use factorial::Axial;
pub use fraction::Aliases;

/// Most rows that a number in the study alone puts into memory.
const MOST_STATED_ROWS: usize = 1_000_000;

/// How the rows are chosen.
#[derive(Debug, Clone, PartialEq)]
pub enum Kind {
    /// One row; only for a design without factors.
    Single,
    /// Every combination of the factors' levels; the last factor changes fastest.
    FullFactorial,
    /// A regular fraction of the two-level factorial: main effects clear of effects of up to `resolution - 2` factors; of least
    /// aberration up to 15 factors.
    FractionalFactorial {
        /// 3 to 8.
        resolution: u32,
    },
    /// The smallest known orthogonal two-level design for main effects.
    PlackettBurman,
    /// Corners, axial points and centre, for quadratic models.
    CentralComposite {
        /// Where the axial points lie.
        axial: Axial,
        /// Number of centre points.
        centres: usize,
    },
    /// Middles of edges (or of faces) and centre, for quadratic models without corners.
    BoxBehnken {
        /// Number of centre points.
        centres: usize,
    },
    /// Latin hypercube: every factor's range is cut into `rows` strata of equal probability and each is hit once.
    ///
    /// Integers and categories take each of their values `floor(rows / n)` or `ceil(rows / n)` times.
    LatinHypercube(LatinHypercube),
    /// Sobol' points in the order of the Gray code, direction numbers of Joe and Kuo.
    Sobol {
        /// Number of rows; powers of two are best.
        rows: usize,
        /// Whether digits are scrambled after Owen; without, the first point is the lower corner.
        scramble: bool,
    },
    /// Halton points.
    Halton {
        /// Number of rows.
        rows: usize,
        /// Whether digits are scrambled; without, the first point is the lower corner.
        scramble: bool,
    },
    /// Independent random points.
    Random {
        /// Number of rows.
        rows: usize,
    },
    /// The middle of all ranges, then each factor at each of its other levels (real ones: two levels unless given).
    OneAtATime,
    /// Morris trajectories, `factors + 1` rows each.
    Morris {
        /// Number of trajectories.
        trajectories: usize,
        /// Levels of the grid, even.
        levels: u64,
    },
    /// Saltelli's design for Sobol' indices, `factors + 2` rows per base point (`2 factors + 2` with second order).
    Saltelli {
        /// Number of base points.
        base: usize,
        /// Whether second-order indices are wanted.
        second_order: bool,
    },
    /// Rows given by the user.
    Table(Arc<Vec<Vec<Level>>>),
    /// The rows of one design after the other, all of the same factors.
    Union(Vec<Kind>),
    /// Every row of each design with every row of the others; each has factors of its own, the last part changes fastest.
    Product(Vec<(Kind, Vec<usize>)>),
}

/// A kind of design, ready to give rows.
#[derive(Debug, Clone, PartialEq)]
enum Generator {
    Single,
    Grid(Vec<u64>),
    Fraction(Fraction),
    Shares(Shares),
    Latin(Latin),
    Sobol(Sobol),
    Halton(Halton),
    Random(u64),
    OneAtATime(OneAtATime),
    Morris(Morris),
    Saltelli(Saltelli),
    Table(Arc<Vec<Vec<Level>>>),
    Union(Vec<Plan>),
    Product(Vec<(Plan, Vec<usize>)>),
}

/// A generator and its number of rows.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Plan {
    generator: Generator,
    pub rows: usize,
    factors: usize,
}

/// What a generator is made for.
#[derive(Clone, Copy)]
pub(super) struct Request<'a> {
    pub factors: &'a [Factor],
    pub seed: u64,
    pub correlation: Option<&'a Correlation>,
}

impl Plan {
    pub(super) fn new(kind: &Kind, request: Request<'_>) -> Result<Self, DesignError> {
        let Request { factors, seed, correlation } = request;
        let count = factors.len();
        if count == 0 && *kind != Kind::Single {
            return Err(DesignError::Factors("a design needs at least one factor"));
        }
        let shares = |shares: Shares| (shares.0.len(), Generator::Shares(shares));
        let (rows, generator) = match kind {
            Kind::Single if count == 0 => (1, Generator::Single),
            Kind::Single => return Err(DesignError::Factors("factors are given, but no kind of design")),
            Kind::FullFactorial => {
                let levels = factors.iter().enumerate().map(|(index, factor)| factor.level_count(index));
                let levels = levels.collect::<Result<Vec<u64>, _>>()?;
                (combinations(&levels)?, Generator::Grid(levels))
            }
            Kind::FractionalFactorial { resolution } => {
                two_levels(factors)?;
                let fraction = Fraction::new(count, *resolution)?;
                (fraction.rows(), Generator::Fraction(fraction))
            }
            Kind::PlackettBurman => {
                two_levels(factors)?;
                shares(screening(count)?)
            }
            Kind::CentralComposite { axial, centres } => {
                numbers_only(factors)?;
                bounded("centre_points", *centres as u64)?;
                shares(central_composite(count, *axial, *centres)?)
            }
            Kind::BoxBehnken { centres } => {
                numbers_only(factors)?;
                bounded("centre_points", *centres as u64)?;
                shares(box_behnken(count, *centres)?)
            }
            Kind::LatinHypercube(spec) => (spec.rows, Generator::Latin(Latin::new(spec, factors, seed, correlation)?)),
            Kind::Sobol { rows, scramble } => (*rows, Generator::Sobol(sobol(count, scramble.then_some(seed))?)),
            Kind::Halton { rows, scramble } => (*rows, Generator::Halton(Halton::new(count, scramble.then_some(seed)))),
            Kind::Random { rows } => (*rows, Generator::Random(seed)),
            Kind::OneAtATime => {
                let levels = at_a_time(factors)?;
                bounded("kind", levels.iter().fold(0, |rows: u64, (count, ..)| rows.saturating_add(*count)))?;
                let plan = OneAtATime::new(&levels);
                (plan.rows(), Generator::OneAtATime(plan))
            }
            Kind::Morris { trajectories, levels } => {
                let morris = morris(factors, *levels, seed)?;
                (blocks(*trajectories, count + 1)?, Generator::Morris(morris))
            }
            Kind::Saltelli { base, second_order } => {
                let points = sobol(2 * count, Some(seed))?;
                let saltelli = Saltelli { factors: count, second_order: *second_order, points };
                (blocks(*base, saltelli.block())?, Generator::Saltelli(saltelli))
            }
            Kind::Table(table) => {
                if table.iter().any(|row| row.len() != count) {
                    return Err(DesignError::Factors("a row of the table has not one value per factor"));
                }
                (table.len(), Generator::Table(Arc::clone(table)))
            }
            Kind::Union(kinds) => union(kinds, request)?,
            Kind::Product(parts) => product(parts, request)?,
        };
        if rows == 0 {
            return Err(DesignError::NoRows);
        }
        if rows > MOST_ROWS {
            return Err(DesignError::TooManyRows);
        }
        Ok(Self { generator, rows, factors: count })
    }

    /// Coordinates of a row. Rows past the last are defined for endless kinds only.
    pub(super) fn at(&self, row: usize) -> Vec<Coordinate> {
        let each = |coordinate: &dyn Fn(usize) -> Coordinate| (0..self.factors).map(coordinate).collect();
        let end = |high: bool| Coordinate::Step { step: u64::from(high), count: 2 };
        let index = row as u64;
        match &self.generator {
            Generator::Single => Vec::new(),
            Generator::Grid(levels) => grid_row(levels, index),
            Generator::Fraction(fraction) => each(&|factor| end(fraction.is_high(index, factor))),
            Generator::Shares(Shares(rows)) => {
                rows.get(row).into_iter().flatten().map(|share| Coordinate::Share(*share)).collect()
            }
            Generator::Latin(latin) => each(&|factor| latin.at(row, factor)),
            Generator::Sobol(sobol) => each(&|factor| Coordinate::Probability(sobol.at(index, factor))),
            Generator::Halton(halton) => each(&|factor| Coordinate::Probability(halton.at(index, factor))),
            Generator::Random(seed) => each(&|factor| Coordinate::Probability(uniform(*seed, factor as u64, index))),
            Generator::OneAtATime(plan) => plan.at(row),
            Generator::Morris(morris) => each(&|factor| morris.at(index, factor as u64)),
            Generator::Saltelli(saltelli) => each(&|factor| Coordinate::Probability(saltelli.at(index, factor))),
            Generator::Table(table) => {
                table.get(row).into_iter().flatten().map(|level| Coordinate::Value(*level)).collect()
            }
            Generator::Union(parts) => union_row(parts, row),
            Generator::Product(parts) => product_row(parts, row, self.factors),
        }
    }

    /// Whether points are probabilities that a copula can correlate.
    pub(super) fn is_sampled(&self) -> bool {
        matches!(self.generator, Generator::Sobol(_) | Generator::Halton(_) | Generator::Random(_))
    }

    /// Rows that belong together and are left out together.
    pub(super) fn block(&self) -> usize {
        match &self.generator {
            Generator::Morris(morris) => morris.factors as usize + 1,
            Generator::Saltelli(saltelli) => saltelli.block(),
            _ => 1,
        }
    }

    /// Whether there are points past the last row to take instead of rows left out.
    pub(super) fn is_endless(&self) -> bool {
        self.is_sampled() || matches!(self.generator, Generator::Morris(_) | Generator::Saltelli(_))
    }

    /// The Latin hypercube with its rows made to fit the constraints; `None` for other kinds.
    pub(super) fn constrained_latin(
        &self,
        correlation: Option<&Correlation>,
        conditions: Conditions<'_>,
    ) -> Option<Result<Self, DesignError>> {
        let Generator::Latin(latin) = &self.generator else { return None };
        let constrained = latin.constrained(correlation, conditions);
        Some(constrained.map(|latin| Self { generator: Generator::Latin(latin), ..self.clone() }))
    }

    /// What a regular fraction confuses.
    pub(super) fn aliases(&self) -> Option<Aliases> {
        match &self.generator {
            Generator::Fraction(fraction) => Some(Aliases::of(fraction)),
            _ => None,
        }
    }

    /// Whether every row is computed alone, without a table of all.
    pub(super) fn is_open(&self) -> bool {
        match &self.generator {
            Generator::Latin(latin) => latin.is_open(),
            Generator::Shares(_) | Generator::Table(_) => false,
            Generator::Union(parts) => parts.iter().all(Self::is_open),
            Generator::Product(parts) => parts.iter().all(|(part, _)| part.is_open()),
            _ => true,
        }
    }
}

fn grid_row(levels: &[u64], index: u64) -> Vec<Coordinate> {
    let mut rest = index;
    let mut coordinates: Vec<Coordinate> = Vec::with_capacity(levels.len());
    for &count in levels.iter().rev() {
        coordinates.push(Coordinate::Step { step: rest % count, count });
        rest /= count;
    }
    coordinates.reverse();
    coordinates
}

fn combinations(levels: &[u64]) -> Result<usize, DesignError> {
    let product = levels.iter().try_fold(1_u64, |rows, levels| rows.checked_mul(*levels));
    product.and_then(|rows| usize::try_from(rows).ok()).ok_or(DesignError::TooManyRows)
}

/// Rows that are kept in memory although no file lists them.
fn bounded(key: &'static str, rows: u64) -> Result<(), DesignError> {
    if rows <= MOST_STATED_ROWS as u64 {
        return Ok(());
    }
    Err(DesignError::setting(
        key,
        format!("{rows} rows of this kind are too many, expected {MOST_STATED_ROWS} at most"),
    ))
}

fn blocks(count: usize, block: usize) -> Result<usize, DesignError> {
    count.checked_mul(block).ok_or(DesignError::TooManyRows)
}

fn sobol(dimensions: usize, scramble: Option<u64>) -> Result<Sobol, DesignError> {
    if dimensions > MAX_DIMENSIONS {
        let message =
            format!("Sobol' points of {dimensions} dimensions are not known, expected {MAX_DIMENSIONS} at most");
        return Err(DesignError::setting("kind", message));
    }
    Ok(Sobol::new(dimensions, scramble))
}

fn two_levels(factors: &[Factor]) -> Result<(), DesignError> {
    let odd = |factor: &Factor| matches!(factor.distribution, Distribution::Categories { count } if count != 2);
    match factors.iter().position(odd) {
        Some(factor) => Err(DesignError::FactorKind {
            factor,
            expected: "a two-level design needs exactly two values to choose from",
        }),
        None => Ok(()),
    }
}

fn numbers_only(factors: &[Factor]) -> Result<(), DesignError> {
    match factors.iter().position(|factor| matches!(factor.distribution, Distribution::Categories { .. })) {
        Some(factor) => Err(DesignError::FactorKind {
            factor,
            expected: "this kind of design needs ranges, no lists of values: put the list into another part of a product",
        }),
        None => Ok(()),
    }
}

fn morris(factors: &[Factor], levels: u64, seed: u64) -> Result<Morris, DesignError> {
    if levels < 2 || !levels.is_multiple_of(2) {
        let message = format!("a Morris design has an even number of levels, not {levels}");
        return Err(DesignError::setting("morris_levels", message));
    }
    let short = |factor: &Factor| factor.distribution.value_count().is_some_and(|count| count < 2);
    if let Some(factor) = factors.iter().position(short) {
        return Err(DesignError::FactorKind { factor, expected: "a factor with a single value cannot move" });
    }
    Ok(Morris { factors: factors.len() as u64, levels, seed })
}

fn at_a_time(factors: &[Factor]) -> Result<Vec<(u64, bool, bool)>, DesignError> {
    let levels = |(index, factor): (usize, &Factor)| {
        let real = factor.distribution.value_count().is_none();
        let category = matches!(factor.distribution, Distribution::Categories { .. });
        let count = if real && factor.levels.is_none() { 2 } else { factor.level_count(index)? };
        Ok((count, real, category))
    };
    factors.iter().enumerate().map(levels).collect()
}

fn union(kinds: &[Kind], request: Request<'_>) -> Result<(usize, Generator), DesignError> {
    let part = |(index, kind)| Plan::new(kind, Request { seed: hash(request.seed, index as u64, 1), ..request });
    let parts = kinds.iter().enumerate().map(part).collect::<Result<Vec<Plan>, _>>()?;
    let rows = parts.iter().try_fold(0_usize, |rows, part| rows.checked_add(part.rows));
    Ok((rows.ok_or(DesignError::TooManyRows)?, Generator::Union(parts)))
}

fn product(kinds: &[(Kind, Vec<usize>)], request: Request<'_>) -> Result<(usize, Generator), DesignError> {
    let mut used = vec![0; request.factors.len()];
    for index in kinds.iter().flat_map(|(_, factors)| factors) {
        if let Some(used) = used.get_mut(*index) {
            *used += 1;
        }
    }
    if used.iter().any(|used| *used != 1) {
        return Err(DesignError::Factors("every factor must belong to exactly one part of a product"));
    }
    let mut parts = Vec::with_capacity(kinds.len());
    for (index, (kind, places)) in kinds.iter().enumerate() {
        let factors: Vec<Factor> = places.iter().filter_map(|place| request.factors.get(*place)).cloned().collect();
        let part = Request { factors: &factors, seed: hash(request.seed, index as u64, 1), correlation: None };
        parts.push((Plan::new(kind, part)?, places.clone()));
    }
    let rows = parts.iter().try_fold(1_usize, |rows, (part, _)| rows.checked_mul(part.rows));
    Ok((rows.ok_or(DesignError::TooManyRows)?, Generator::Product(parts)))
}

fn union_row(parts: &[Plan], row: usize) -> Vec<Coordinate> {
    let mut rest = row;
    for part in parts {
        if rest < part.rows {
            return part.at(rest);
        }
        rest -= part.rows;
    }
    Vec::new()
}

fn product_row(parts: &[(Plan, Vec<usize>)], row: usize, factors: usize) -> Vec<Coordinate> {
    let mut coordinates = vec![Coordinate::Share(0.0); factors];
    let mut rest = row;
    for (part, places) in parts.iter().rev() {
        for (place, coordinate) in places.iter().zip(part.at(rest % part.rows)) {
            if let Some(entry) = coordinates.get_mut(*place) {
                *entry = coordinate;
            }
        }
        rest /= part.rows;
    }
    coordinates
}

//! Latin hypercubes: plain, sliced, on orthogonal arrays, optimised, correlated, constrained, grown.

use super::constraint::Conditions;
use super::coordinate::Coordinate;
use super::correlation::Correlation;
use super::distribution::Distribution;
use super::error::{DesignError, MOST_ROWS};
use super::factor::Factor;
use super::orthogonal::{Field, bose};
use super::permutation::Permutation;
use super::strata::{HypercubeKind, LatinHypercube, OpenHypercube};
use super::table::{Builder, OPTIMISER_STREAM, Strata};
use decore_math::random::hash;

/// Most rows of an optimised hypercube: its effort and memory grow with their square.
const MAX_OPTIMISED_ROWS: usize = 3000;
/// Most entries (rows times factors) of a hypercube that is kept as a table.
const MAX_TABLE_ENTRIES: usize = 100_000_000;

/// A Latin hypercube ready to give rows.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Latin {
    open: OpenHypercube,
    form: Form,
}

#[derive(Debug, Clone, PartialEq)]
enum Form {
    /// Every row computed alone.
    Open,
    /// On an orthogonal array over this field, every row computed alone.
    Orthogonal(Field),
    Table(Strata),
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

    /// The same with rows that meet the conditions: entries are moved within their columns until all do.
    ///
    /// # Errors
    /// [`DesignError::Unsatisfiable`] if no such hypercube is found, the errors of the conditions.
    pub(super) fn repaired(
        &self,
        correlation: Option<&Correlation>,
        conditions: Conditions<'_>,
    ) -> Result<Self, DesignError> {
        let OpenHypercube { spec, seed, categories } = &self.open;
        Self::open(spec, categories.clone(), *seed)?.tabulated(correlation, Some(conditions))
    }

    fn open(spec: &LatinHypercube, categories: Vec<u64>, seed: u64) -> Result<Self, DesignError> {
        let columns = categories.len();
        if spec.rows == 0 {
            return Err(DesignError::NoRows);
        }
        if spec.rows > MOST_ROWS {
            return Err(DesignError::TooManyRows);
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
        Ok(Self { open: OpenHypercube { spec: spec.clone(), seed, categories }, form })
    }

    fn tabulated(
        self,
        correlation: Option<&Correlation>,
        conditions: Option<Conditions<'_>>,
    ) -> Result<Self, DesignError> {
        let spec = &self.open.spec;
        let optimised = matches!(spec.kind, HypercubeKind::Maximin | HypercubeKind::CentredDiscrepancy);
        let plain = optimised || spec.kind == HypercubeKind::Random;
        let (grown, constrained) = (!spec.grown_from.is_empty(), conditions.is_some());
        if !plain && (grown || constrained || correlation.is_some()) {
            return Err(DesignError::setting(
                "optimise",
                "sliced hypercubes and those on orthogonal arrays cannot be grown, constrained or correlated: that would \
                 break their structure",
            ));
        }
        if !(optimised || grown || constrained || correlation.is_some()) {
            return Ok(self);
        }
        if spec.rows.saturating_mul(self.open.columns()) > MAX_TABLE_ENTRIES {
            let message = format!(
                "{} rows of {} factors are too many for a hypercube that is kept in memory (at most {MAX_TABLE_ENTRIES} values)",
                spec.rows,
                self.open.columns()
            );
            return Err(DesignError::setting("rows", message));
        }
        let table = Builder { latin: &self.open, conditions, correlation }.build()?;
        Ok(Self { form: Form::Table(table), ..self })
    }

    /// Whether rows come from a table of all of them.
    pub(super) fn is_table(&self) -> bool {
        matches!(self.form, Form::Table(_))
    }

    /// Numbers of rows at the ends of the stages that it grew by.
    pub(super) fn stages(&self) -> Vec<usize> {
        [self.open.spec.grown_from.as_slice(), &[self.open.spec.rows]].concat()
    }

    /// Number of rows.
    pub(super) fn row_count(&self) -> usize {
        self.open.spec.rows
    }

    /// Number of factors.
    pub(super) fn columns(&self) -> usize {
        self.open.columns()
    }

    /// Coordinate of a row in a column.
    pub(super) fn coordinate(&self, row: usize, column: usize) -> Coordinate {
        let count = self.open.categories.get(column).copied().unwrap_or(1);
        if count > 1 {
            // The last factor's category changes fastest.
            let faster: u64 = self.open.categories.iter().skip(column + 1).product();
            return Coordinate::Step { step: row as u64 / faster % count, count };
        }
        let (stratum, strata) = match &self.form {
            Form::Table(table) => {
                let stratum = table.columns.get(column).and_then(|column| column.get(row)).copied().unwrap_or(0);
                (u64::from(stratum), table.strata_of(row) as u64)
            }
            Form::Open => (self.open.stratum(row as u64, column as u64), self.open.spec.rows as u64),
            Form::Orthogonal(field) => {
                (self.array_stratum(field, row as u64, column as u64), self.open.spec.rows as u64)
            }
        };
        Coordinate::Stratum { stratum, strata, place: self.open.place(row, column) }
    }

    /// Symbols and the strata within a symbol are permuted at random.
    fn array_stratum(&self, field: &Field, row: u64, column: u64) -> u64 {
        let key = hash(self.open.seed, 2 * column, 0);
        let order = field.order();
        let scattered = Permutation::new(hash(self.open.seed, OPTIMISER_STREAM, 0), order * order).at(row);
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

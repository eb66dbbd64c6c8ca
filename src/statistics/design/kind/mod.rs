//! Kinds of designs. A new kind needs an entry here, and a file with its keys and its rows.

mod factorial;
mod fraction;
mod grid;
mod growth;
mod halton;
mod hypercube;
mod points;
mod sampled;
mod sensitivity;

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::coordinate::Coordinate;
use super::distribution::Level;
use super::error::{DesignError, MOST_ROWS};
use super::factor::Factor;
use super::group::{GroupSpan, chained, crossed};
use super::options::{DesignOptions, Needs};
use super::strata::LatinHypercube;
use decore_math::random::hash;

pub use factorial::{BoxBehnken, CentralComposite, FractionalFactorial, PlackettBurman};
pub use fraction::Aliases;
pub use grid::{FullFactorial, OneAtATime, Single};
pub(crate) use growth::Growth;
use points::Specification;
pub(super) use points::{Points, Request};
pub use sampled::{Halton, Random, Sobol};
pub use sensitivity::{Morris, Saltelli};

/// Declares the kinds. An entry has a text, its name in a study (in snake case), the type with its keys, and the keys of a study that
/// belong to it.
macro_rules! kinds {
    (
        $(#[doc = $first_text:tt])+ $first:ident: $first_kind:ident [$($first_key:literal),*],
        $($(#[doc = $text:tt])+ $name:ident: $kind:ident [$($key:literal),*],)*
    ) => {
        /// Kind of design.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum DesignKind {
            $(#[doc = $first_text])+ #[default] $first,
            $($(#[doc = $text])+ $name,)*
        }

        /// Kind of design.
        #[derive(Debug, Clone, PartialEq)]
        pub enum Kind {
            $(#[doc = $first_text])+ $first_kind($first_kind),
            $($(#[doc = $text])+ $kind($kind),)*
        }

        impl DesignKind {
            /// The keys of a study that belong to it.
            pub fn keys(self) -> &'static [&'static str] {
                match self {
                    Self::$first => &[$($first_key),*],
                    $(Self::$name => &[$($key),*],)*
                }
            }

            /// Reads the keys of a study.
            ///
            /// # Errors
            /// What the keys do not tell.
            pub fn of(self, keys: &DesignOptions) -> Result<Kind, Needs> {
                match self {
                    Self::$first => $first_kind::of(keys).map(Kind::$first_kind),
                    $(Self::$name => $kind::of(keys).map(Kind::$kind),)*
                }
            }
        }

        impl Kind {
            /// The number by which it grows; `None` where more rows are other rows.
            pub fn growth(&self) -> Option<Growth> {
                match self {
                    Self::$first_kind(kind) => kind.growth(),
                    $(Self::$kind(kind) => kind.growth(),)*
                }
            }

            fn prepared(&self, request: Request<'_>) -> Result<Arc<dyn Points>, DesignError> {
                match self {
                    Self::$first_kind(kind) => kind.points(request),
                    $(Self::$kind(kind) => kind.points(request),)*
                }
            }
        }
    };
}

kinds! {
    /// One row.
    None: Single [],
    /// Every combination of the factors' levels.
    FullFactorial: FullFactorial [],
    /// A regular fraction of the two-level factorial, with minimum aberration up to 15 factors.
    FractionalFactorial: FractionalFactorial ["resolution"],
    /// The fewest rows for main effects at two levels.
    PlackettBurman: PlackettBurman [],
    /// Corners, axial points and centre.
    CentralComposite: CentralComposite ["axial", "centre_points"],
    /// Middles of edges and centre.
    BoxBehnken: BoxBehnken ["centre_points"],
    /// Latin hypercube, optimised according to `optimise`.
    LatinHypercube: LatinHypercube ["rows", "centred", "optimise", "grown_from"],
    /// Sobol' points, scrambled unless `scramble = false`.
    Sobol: Sobol ["rows", "scramble"],
    /// Halton points, scrambled unless `scramble = false`.
    Halton: Halton ["rows", "scramble"],
    /// Independent random points.
    Random: Random ["rows"],
    /// Each factor alone, the others in the middle of their ranges.
    OneAtATime: OneAtATime [],
    /// Morris trajectories, for elementary effects.
    Morris: Morris ["trajectories", "morris_levels"],
    /// Saltelli's design for Sobol' indices.
    Saltelli: Saltelli ["base_points", "second_order"],
    /// Rows of a CSV or Parquet file, a column per factor, e.g. of `decore design`. Default ranges: the ranges of the columns.
    Table: Table ["file"],
    /// The rows of several parts, one after the other. Each part is a `[[design.part]]`.
    Union: Union [],
    /// Every row of each part, combined with every row of the others.
    Product: Product [],
}

impl Kind {
    /// Makes it ready to give rows.
    pub(super) fn points(&self, request: Request<'_>) -> Result<Arc<dyn Points>, DesignError> {
        if request.factors.is_empty() && !matches!(self, Self::Single(_)) {
            return Err(DesignError::Factors("a design needs at least one factor"));
        }
        let points = self.prepared(request)?;
        match points.rows() {
            0 => Err(DesignError::NoRows),
            rows if rows > MOST_ROWS => Err(DesignError::TooManyRows),
            _ => Ok(points),
        }
    }
}

/// Rows given by the user.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// The rows, a level per factor.
    pub rows: Arc<Vec<Vec<Level>>>,
}

impl Specification for Table {
    fn of(_: &DesignOptions) -> Result<Self, Needs> {
        Err(Needs::Rows)
    }

    fn points(&self, request: Request<'_>) -> Result<Arc<dyn Points>, DesignError> {
        if self.rows.iter().any(|row| row.len() != request.factors.len()) {
            return Err(DesignError::Factors("a row of the table has not one value per factor"));
        }
        Ok(Arc::new(self.clone()))
    }
}

impl Points for Table {
    fn rows(&self) -> usize {
        self.rows.len()
    }

    fn at(&self, row: usize) -> Vec<Coordinate> {
        self.rows.get(row).into_iter().flatten().map(|level| Coordinate::Value(*level)).collect()
    }

    fn is_open(&self) -> bool {
        false
    }
}

/// The rows of one design after the other, all of the same factors.
#[derive(Debug, Clone, PartialEq)]
pub struct Union {
    /// The designs, in order.
    pub parts: Vec<Kind>,
}

impl Specification for Union {
    fn of(_: &DesignOptions) -> Result<Self, Needs> {
        Err(Needs::Parts)
    }

    fn points(&self, request: Request<'_>) -> Result<Arc<dyn Points>, DesignError> {
        let part = |(index, kind): (usize, &Kind)| {
            kind.points(Request { seed: hash(request.seed, index as u64, 1), ..request })
        };
        let parts = self.parts.iter().enumerate().map(part).collect::<Result<Vec<_>, _>>()?;
        let rows = parts.iter().try_fold(0_usize, |rows, part| rows.checked_add(part.rows()));
        Ok(Arc::new(Chain { rows: rows.ok_or(DesignError::TooManyRows)?, parts }))
    }
}

/// Designs one after the other.
#[derive(Debug)]
struct Chain {
    parts: Vec<Arc<dyn Points>>,
    rows: usize,
}

impl Points for Chain {
    fn rows(&self) -> usize {
        self.rows
    }

    fn at(&self, row: usize) -> Vec<Coordinate> {
        let mut rest = row;
        for part in &self.parts {
            if rest < part.rows() {
                return part.at(rest);
            }
            rest -= part.rows();
        }
        Vec::new()
    }

    fn is_open(&self) -> bool {
        self.parts.iter().all(|part| part.is_open())
    }

    fn groups(&self) -> Vec<GroupSpan> {
        chained(self.parts.iter().map(|part| (part.rows(), part.groups())))
    }
}

/// Every row of each design with every row of the others; each has factors of its own, the last part changes fastest.
#[derive(Debug, Clone, PartialEq)]
pub struct Product {
    /// The designs, in order.
    pub parts: Vec<ProductPart>,
}

/// A design of some of the factors.
#[derive(Debug, Clone, PartialEq)]
pub struct ProductPart {
    /// Kind of design.
    pub kind: Kind,
    /// Indices of its factors.
    pub factors: Vec<usize>,
}

impl Specification for Product {
    fn of(_: &DesignOptions) -> Result<Self, Needs> {
        Err(Needs::Parts)
    }

    fn points(&self, request: Request<'_>) -> Result<Arc<dyn Points>, DesignError> {
        let mut used = vec![0; request.factors.len()];
        for index in self.parts.iter().flat_map(|part| &part.factors) {
            if let Some(used) = used.get_mut(*index) {
                *used += 1;
            }
        }
        if used.iter().any(|used| *used != 1) {
            return Err(DesignError::Factors("every factor must belong to exactly one part of a product"));
        }
        let mut parts = Vec::with_capacity(self.parts.len());
        for (index, ProductPart { kind, factors: places }) in self.parts.iter().enumerate() {
            let factors: Vec<Factor> = places.iter().filter_map(|place| request.factors.get(*place)).cloned().collect();
            let part = Request { factors: &factors, seed: hash(request.seed, index as u64, 1), correlation: None };
            parts.push(Crossed { points: kind.points(part)?, places: places.clone() });
        }
        let rows = parts.iter().try_fold(1_usize, |rows, part| rows.checked_mul(part.points.rows()));
        let rows = rows.ok_or(DesignError::TooManyRows)?;
        Ok(Arc::new(Cross { parts, rows, factors: request.factors.len() }))
    }
}

/// Designs with each other.
#[derive(Debug)]
struct Cross {
    parts: Vec<Crossed>,
    rows: usize,
    factors: usize,
}

/// One of them, and where its factors are among all.
#[derive(Debug)]
struct Crossed {
    points: Arc<dyn Points>,
    places: Vec<usize>,
}

impl Points for Cross {
    fn rows(&self) -> usize {
        self.rows
    }

    fn at(&self, row: usize) -> Vec<Coordinate> {
        let mut coordinates = vec![Coordinate::Share(0.0); self.factors];
        let mut rest = row;
        for Crossed { points, places } in self.parts.iter().rev() {
            for (place, coordinate) in places.iter().zip(points.at(rest % points.rows())) {
                if let Some(entry) = coordinates.get_mut(*place) {
                    *entry = coordinate;
                }
            }
            rest /= points.rows();
        }
        coordinates
    }

    fn is_open(&self) -> bool {
        self.parts.iter().all(|part| part.points.is_open())
    }

    fn groups(&self) -> Vec<GroupSpan> {
        let parts: Vec<_> = self.parts.iter().map(|part| (part.points.rows(), part.points.groups())).collect();
        crossed(&parts)
    }
}

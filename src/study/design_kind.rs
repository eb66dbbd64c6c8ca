//! The kinds of design with their keys: what a new one needs here is an entry, and its keys if it has some of its own.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::design::{Axial, HypercubeKind, Kind, LatinHypercube, Placement};

/// Morris trajectories.
const TRAJECTORIES: u64 = 10;
/// Levels of the Morris grid.
const MORRIS_LEVELS: u64 = 4;
/// Resolution of a fractional factorial: main effects clear of products of two factors.
const RESOLUTION: u64 = 4;
/// Centre points: more would repeat a deterministic simulation.
const CENTRE_POINTS: u64 = 1;

/// Hands the keys that say how rows are chosen to a macro: one list for `[design]`, for the parts of a union or product, and for
/// [`DesignOptions`].
macro_rules! design_keys {
    ($then:ident) => {
        $then! {
                /// Kind of design. Default `none`: one row.
                kind: DesignKind,
                /// Number of rows (Latin hypercube, Sobol', Halton, random).
                rows: u64,
                /// Points in the middle of their strata instead of at random in them (Latin hypercube). Default false; true where the
                /// hypercube is optimised.
                centred: bool,
                /// What a Latin hypercube is chosen for. Default `none`.
                optimise: HypercubeKind,
                /// Numbers of rows that a Latin hypercube had before: its first rows are that design's.
                grown_from: Vec<u64>,
                /// Whether Sobol' or Halton points are scrambled. Default true.
                scramble: bool,
                /// Resolution of a fractional factorial, 3 to 8. Default 4.
                resolution: u64,
                /// Where a central composite design has its axial points. Default `inscribed`.
                axial: Axial,
                /// Number of centre points (central composite, Box-Behnken). Default 1.
                centre_points: u64,
                /// Number of Morris trajectories. Default 10.
                trajectories: u64,
                /// Levels of the Morris grid, even. Default 4.
                morris_levels: u64,
                /// Number of base points of a Saltelli design; powers of two are best.
                base_points: u64,
                /// Whether a Saltelli design serves second-order indices. Default false.
                second_order: bool,
                /// File with the rows of a table, CSV or Parquet, relative to the study: a column per factor, named like it or `factor_` and
                /// its name, as `decore design` writes them.
                file: String,
        }
    };
}
pub(super) use design_keys;

macro_rules! design_options {
    ($(#[doc = $first:literal] $(#[doc = $more:literal])* $name:ident: $kind:ty,)*) => {
        /// The keys of a design or a part as given.
        #[derive(Debug, Clone, Default)]
        pub(super) struct DesignOptions {
            $(pub $name: Option<$kind>,)*
        }

        impl DesignOptions {
            /// Names of the keys that are given, `kind` apart.
            pub fn given(&self) -> Vec<&'static str> {
                let all = [$((stringify!($name), self.$name.is_some())),*];
                all.into_iter().filter(|(name, given)| *given && *name != "kind").map(|(name, _)| name).collect()
            }
        }
    };
}

design_keys!(design_options);

/// What a kind of design is made of.
pub(super) enum Made {
    /// Its keys say all.
    Kind(Kind),
    /// Rows of a file.
    Table,
    /// Parts, one after the other.
    Union,
    /// Parts, every row of each with every row of the others.
    Product,
}

/// A kind and how it is made of its keys; the error is the key that it needs.
type Maker = fn(&DesignOptions) -> Result<Made, &'static str>;

macro_rules! design_kinds {
    ($($(#[$note:meta])* $name:ident: [$($key:literal),*] => $make:expr,)*) => {
        /// Kind of design.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum DesignKind {
            $($(#[$note])* $name,)*
        }

        impl DesignKind {
            /// The keys that belong to it, and what makes it of them.
            pub(super) fn entry(self) -> (&'static [&'static str], Maker) {
                match self {
                    $(Self::$name => (&[$($key),*], $make),)*
                }
            }
        }
    };
}

design_kinds! {
    /// One row.
    #[default]
    None: [] => |_| made(Kind::Single),
    /// Every combination of the factors' levels.
    FullFactorial: [] => |_| made(Kind::FullFactorial),
    /// A regular fraction of the two-level factorial, of least aberration up to 15 factors.
    FractionalFactorial: ["resolution"] => |keys| {
        let resolution = u32::try_from(keys.resolution.unwrap_or(RESOLUTION)).unwrap_or(u32::MAX);
        made(Kind::FractionalFactorial { resolution })
    },
    /// The fewest rows for main effects at two levels.
    PlackettBurman: [] => |_| made(Kind::PlackettBurman),
    /// Corners, axial points and centre.
    CentralComposite: ["axial", "centre_points"] => |keys| {
        made(Kind::CentralComposite { axial: keys.axial.unwrap_or_default(), centres: centres(keys) })
    },
    /// Middles of edges and centre.
    BoxBehnken: ["centre_points"] => |keys| made(Kind::BoxBehnken { centres: centres(keys) }),
    /// Latin hypercube.
    LatinHypercube: ["rows", "centred", "optimise", "grown_from"] => |keys| {
        let kind = keys.optimise.unwrap_or_default();
        let optimised = matches!(kind, HypercubeKind::Maximin | HypercubeKind::CentredDiscrepancy);
        let centred = keys.centred.unwrap_or(optimised);
        made(Kind::LatinHypercube(LatinHypercube {
            rows: rows(keys)?,
            grown_from: keys.grown_from.iter().flatten().map(|rows| count(*rows)).collect(),
            placement: if centred { Placement::Centred } else { Placement::Random },
            kind,
        }))
    },
    /// Sobol' points.
    Sobol: ["rows", "scramble"] => |keys| made(Kind::Sobol { rows: rows(keys)?, scramble: scramble(keys) }),
    /// Halton points.
    Halton: ["rows", "scramble"] => |keys| made(Kind::Halton { rows: rows(keys)?, scramble: scramble(keys) }),
    /// Independent random points.
    Random: ["rows"] => |keys| made(Kind::Random { rows: rows(keys)? }),
    /// Each factor alone, the others in the middle of their ranges.
    OneAtATime: [] => |_| made(Kind::OneAtATime),
    /// Morris trajectories.
    Morris: ["trajectories", "morris_levels"] => |keys| {
        let trajectories = count(keys.trajectories.unwrap_or(TRAJECTORIES));
        made(Kind::Morris { trajectories, levels: keys.morris_levels.unwrap_or(MORRIS_LEVELS) })
    },
    /// Saltelli's design for Sobol' indices.
    Saltelli: ["base_points", "second_order"] => |keys| {
        let base = keys.base_points.map(count).ok_or("base_points")?;
        made(Kind::Saltelli { base, second_order: keys.second_order.unwrap_or(false) })
    },
    /// Rows from a file.
    Table: ["file"] => |_| Ok(Made::Table),
    /// The rows of several parts, one part after the other.
    Union: [] => |_| Ok(Made::Union),
    /// Every row of each part with every row of the others.
    Product: [] => |_| Ok(Made::Product),
}

fn made(kind: Kind) -> Result<Made, &'static str> {
    Ok(Made::Kind(kind))
}

fn count(number: u64) -> usize {
    usize::try_from(number).unwrap_or(usize::MAX)
}

fn rows(keys: &DesignOptions) -> Result<usize, &'static str> {
    keys.rows.map(count).ok_or("rows")
}

fn centres(keys: &DesignOptions) -> usize {
    count(keys.centre_points.unwrap_or(CENTRE_POINTS))
}

fn scramble(keys: &DesignOptions) -> bool {
    keys.scramble.unwrap_or(true)
}

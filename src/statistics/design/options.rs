//! Keys of a study for the choice of rows. A new key needs an entry here.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::strata::HypercubeKind;

/// Position of the axial points of a central composite design.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Axial {
    /// At the ends of the ranges. The corners move inwards, so that the design is rotatable: `alpha = F^(1/4)` for F corners.
    #[default]
    Inscribed,
    /// In the middle of the faces, with the corners at the ends of the ranges.
    Faces,
}

/// Hands the keys to a macro: one list for `[design]`, for the parts of a union or product, and for [`DesignOptions`]. A key has a
/// text, a name, a type and a value to show (TOML).
#[macro_export]
macro_rules! design_keys {
    ($then:ident) => {
        $then! {
            /// Number of rows (Latin hypercube, Sobol', Halton, random).
            rows: u64 = "20",
            /// Points in the middle of their strata instead of at random positions (Latin hypercube). Default false; true for optimised
            /// hypercubes.
            centred: bool = "false",
            /// Criterion of a Latin hypercube. Default `none`.
            optimise: HypercubeKind = "\"none\"",
            /// Earlier numbers of rows of a Latin hypercube. Its first rows are the rows of that design.
            grown_from: Vec<u64> = "[10]",
            /// Whether Sobol' or Halton points are scrambled. Default true.
            scramble: bool = "true",
            /// Resolution of a fractional factorial, 3 to 8. Default 4.
            resolution: u64 = "4",
            /// Position of the axial points of a central composite design. Default `inscribed`.
            axial: Axial = "\"inscribed\"",
            /// Number of centre points (central composite, Box-Behnken). Default 1.
            centre_points: u64 = "1",
            /// Number of Morris trajectories. Default 10.
            trajectories: u64 = "10",
            /// Levels of the Morris grid, even. Default 4.
            morris_levels: u64 = "4",
            /// Number of base points of a Saltelli design; powers of two are best.
            base_points: u64 = "64",
            /// Whether a Saltelli design has rows for second-order indices. Default false.
            second_order: bool = "false",
            /// File with the rows of a table, CSV or Parquet, relative to the study: a column per factor, named like it or `factor_` and
            /// its name, as `decore design` writes them.
            file: String = "\"rows.csv\"",
        }
    };
}
pub use design_keys;

macro_rules! design_options {
    ($($(#[doc = $text:tt])+ $name:ident: $kind:ty = $shown:literal,)*) => {
        /// The keys of a design or a part as given.
        #[derive(Debug, Clone, Default)]
        pub struct DesignOptions {
            $($(#[doc = $text])+ pub $name: Option<$kind>,)*
        }

        impl DesignOptions {
            /// All keys, in the order of the file.
            pub const KEYS: &'static [DesignKey] =
                &[$(DesignKey { name: stringify!($name), text: &[$($text),+], shown: $shown }),*];

            /// Names of the keys that are given.
            pub fn given(&self) -> Vec<&'static str> {
                let all = [$((stringify!($name), self.$name.is_some())),*];
                all.into_iter().filter(|(_, given)| *given).map(|(name, _)| name).collect()
            }
        }
    };
}

design_keys!(design_options);

/// A key of a study for the choice of rows.
#[derive(Debug, Clone, Copy)]
pub struct DesignKey {
    /// Name.
    pub name: &'static str,
    /// Text, line by line.
    pub text: &'static [&'static str],
    /// A value to show (TOML): the default if there is one.
    pub shown: &'static str,
}

/// Default number of centre points: more would repeat a deterministic simulation.
const CENTRE_POINTS: u64 = 1;

impl DesignOptions {
    pub(super) fn row_count(&self) -> Result<usize, Needs> {
        self.rows.map(count).ok_or(Needs::Number("rows"))
    }

    pub(super) fn centres(&self) -> usize {
        count(self.centre_points.unwrap_or(CENTRE_POINTS))
    }

    pub(super) fn scrambled(&self) -> bool {
        self.scramble.unwrap_or(true)
    }
}

/// Further requirements of a kind of design, beyond its keys.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Needs {
    /// A number: the key of this name.
    Number(&'static str),
    /// The rows of a file.
    Rows,
    /// Parts.
    Parts,
}

/// Converts a number of a study to a count; too large numbers become the largest.
pub(super) fn count(number: u64) -> usize {
    usize::try_from(number).unwrap_or(usize::MAX)
}

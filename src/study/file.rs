//! The study file: keys and types of the TOML, without defaults. The schema derives from it.

use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use decore_model::parameter::describe;
use decore_model::scene::{Environment, HammerEntry, OutputSettings, Scene, SolverEntry, StructureEntry};
use decore_model::workpiece::CastingEntry;
use decore_quantity::Value;
use decore_statistics::design::{Axial, DesignKind, DesignOptions, HypercubeKind, design_keys};

/// A study: a machine, hammers over castings, and the design of the runs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(transform = describe::<Scene>)]
pub struct StudyFile {
    /// Title for tables and reports. Default: the file's name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// As in [`Scene`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub duration_s: Option<f64>,
    /// The machine.
    #[serde(default)]
    pub structure: StructureEntry,
    /// Further machines by name, with the keys of `structure` except rails. Each must have the interface points of the study, at the same
    /// places.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub structures: IndexMap<String, StructureEntry>,
    /// Machine of `structures` that carries the hammers; a factor can drive it. Default `structure`: the machine of that table.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub machine: Option<String>,
    /// Whether hammers, castings and fixtures must be at the machine's interface points. Default `checked`.
    #[serde(default, skip_serializing_if = "is_checked")]
    pub geometry: Geometry,
    /// Hammers by name; their order is the order of the columns.
    pub hammer: IndexMap<String, HammerEntry>,
    /// Castings by name; their order is the order of the columns.
    pub casting: IndexMap<String, CastingEntry>,
    /// Accuracy and effort.
    #[serde(default)]
    pub solver: SolverEntry,
    /// Windows and thresholds of the outputs.
    #[serde(default)]
    pub outputs: OutputSettings,
    /// Gas, surroundings and gravity.
    #[serde(default)]
    pub environment: Environment,
    /// The design of the runs; without it the study has one row.
    #[serde(default)]
    pub design: DesignEntry,
    /// Goal of the study, see `decore best`. It changes no row.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub goal: Option<GoalEntry>,
}

impl StudyFile {
    /// All that determines the rows: without the title, the goal and the roles of factors.
    pub(super) fn of_rows(&self) -> Self {
        let mut of_rows = Self { title: None, goal: None, ..self.clone() };
        of_rows.design.factor.values_mut().for_each(|factor| factor.role = None);
        of_rows
    }
}

/// Goal of the rows: one of `maximise` and `minimise`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GoalEntry {
    /// Expression over columns of the table of runs to maximise, e.g. `"delivered_work_j"`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub maximise: Option<String>,
    /// Expression over columns of the table of runs to minimise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub minimise: Option<String>,
    /// Comparisons of columns that must hold, e.g. `"max_casting_point_velocity_m_s <= 4.5"`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub limits: Vec<String>,
    /// Share of the uncertain factors' draws in which all limits must hold, scatter and model error included. Default 0.95.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub confidence: Option<f64>,
}

/// Role of a factor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FactorRole {
    /// You choose its value: `decore best` looks for the best one.
    #[default]
    Decision,
    /// Nobody can choose its value: limits must hold over its distribution, and the goal is an average over it.
    Uncertain,
}

/// Treatment of positions that contradict the coordinates of interface points.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Geometry {
    /// Contradictions are errors. Strikes are vertical: a strike point must be under its hammer's mount, and a fixture above its interface
    /// point. Two housings cannot be in one place.
    #[default]
    Checked,
    /// Positions are used as given, for example if a bracket holds the hammer next to its mount, or if the coordinates are not the
    /// machine's. The model has forces only along the strike; it ignores the moments of such offsets.
    AsGiven,
}

fn is_checked(geometry: &Geometry) -> bool {
    *geometry == Geometry::Checked
}

/// A file that describes a machine alone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StructureFile {
    /// The machine.
    pub structure: StructureEntry,
}

/// The sections that have the keys of designs.
macro_rules! design_entries {
    ($($(#[$note:meta])* $name:ident: $kind:ty = $shown:literal,)*) => {
        /// The design of the runs.
        #[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub struct DesignEntry {
            /// Kind of design. Default `none`: one row.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub kind: Option<DesignKind>,
            $($(#[$note])* #[serde(skip_serializing_if = "Option::is_none")] pub $name: Option<$kind>,)*
            /// Seed of the design's random numbers. Default 0.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub seed: Option<u64>,
            /// Parts of a union (all of them with all factors) or product (each with factors of its own).
            #[serde(default, skip_serializing_if = "Vec::is_empty")]
            pub part: Vec<PartEntry>,
            /// Rank correlations of factors.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub correlation: Option<CorrelationEntry>,
            /// Expressions that hold in every row, e.g. `"distance(left, right) >= 0.12"`. Names are factors or paths of the
            /// study; functions of hammers: `mount_x`, `mount_y`, `mount_z`, `distance`, `strike_x`, `strike_y`,
            /// `strike_margin` (m), `air_flow` (kg/s).
            #[serde(default, skip_serializing_if = "Vec::is_empty")]
            pub constraints: Vec<String>,
            /// Factors by name; their order is the order of the columns and belongs to the design.
            #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
            pub factor: IndexMap<String, FactorEntry>,
        }

        /// A part of a union or product.
        #[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub struct PartEntry {
            /// Kind of design. Default `none`: one row.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub kind: Option<DesignKind>,
            $($(#[$note])* #[serde(skip_serializing_if = "Option::is_none")] pub $name: Option<$kind>,)*
            /// Names of the part's factors, in a product.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub factors: Option<Vec<String>>,
        }

        impl DesignEntry {
            /// Choice of the whole design's rows, as a part without factors of its own.
            pub fn as_part(&self) -> PartEntry {
                PartEntry { kind: self.kind, $($name: self.$name.clone(),)* factors: None }
            }
        }

        impl PartEntry {
            /// Given options of its kind.
            pub(super) fn options(&self) -> DesignOptions {
                DesignOptions { $($name: self.$name.clone(),)* }
            }
        }
    };
}

design_keys!(design_entries);

/// Rank correlations (Spearman) of some factors.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CorrelationEntry {
    /// Names of the factors; all others are uncorrelated.
    pub factors: Vec<String>,
    /// Matrix with one row per factor of `factors`.
    pub matrix: Vec<Vec<f64>>,
}

/// One factor: its targets and its domain, either `range` or `values`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FactorEntry {
    /// Path of the parameter that it drives, e.g. `hammer.left.supply_bar`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub path: Option<String>,
    /// Paths of several parameters that it drives with the same value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub paths: Option<Vec<String>>,
    /// Lower and upper end. If you give no domain for a factor of a table, it comes from the file: the ends of its column, or its texts as
    /// values.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// Spacing within the range. Default `linear`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale: Option<Scale>,
    /// Whether the range holds integers only. Default false.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub integer: Option<bool>,
    /// Number of levels of the range in a full factorial, ends included.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub levels: Option<u64>,
    /// Values to choose from: texts or numbers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub values: Option<Vec<Value>>,
    /// Distribution of a real number. Default `uniform` in the range (`scale = "log"`: in its logarithm).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distribution: Option<DistributionName>,
    /// Mean (normal; with a range: before it is cut).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean: Option<f64>,
    /// Standard deviation (normal; with a range: before it is cut).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub std_dev: Option<f64>,
    /// Most likely value (triangular).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mode: Option<f64>,
    /// First shape (beta).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alpha: Option<f64>,
    /// Second shape (beta).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub beta: Option<f64>,
    /// Observations (empirical).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub data: Option<Vec<f64>>,
    /// Expression of factors before it that gives its value, instead of a range or values.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expression: Option<String>,
    /// Parameters that it drives with a factor and an offset.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub link: Vec<LinkEntry>,
    /// Unit of its range and values, stored with the tables: the parameter's unit, or one that is converted to it (`decore help
    /// units`).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Whether you choose its value or nobody can, for `[goal]`. Changes no row. Default `decision`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub role: Option<FactorRole>,
}

/// A parameter driven with `factor * value + offset`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LinkEntry {
    /// Path of the parameter.
    pub path: String,
    /// Factor. Default 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub factor: Option<f64>,
    /// Offset. Default 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub offset: Option<f64>,
}

/// Distribution of a real number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum DistributionName {
    /// Uniform in the range.
    #[default]
    Uniform,
    /// Normal with `mean` and `std_dev`; cut to the range if one is given.
    Normal,
    /// Triangular in the range with `mode`.
    Triangular,
    /// Beta in the range with `alpha` and `beta`.
    Beta,
    /// As observed: `data`.
    Empirical,
}

/// Spacing of a range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Scale {
    /// Uniform.
    #[default]
    Linear,
    /// Uniform in the logarithm.
    Log,
}

//! A row's outcome as JSON, with names where it counts hammers and castings: those of the tables.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Value as Json, json};

use super::json::schema;
use super::measured::ChannelBeside;
use super::stored::Comparison;
use decore_model::run::RowOutcome;
use decore_quantity::Value;
use decore_study::engine::{Engine, RowRunner};

/// One row.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct SceneResult {
    /// Title of the study.
    study: String,
    /// Hash of the study.
    study_hash: String,
    /// Index of the row in the design.
    row: usize,
    /// Values set over the study's, `path=value`.
    overrides: Vec<String>,
    /// Values of the factors.
    factors: BTreeMap<String, Value>,
    /// Names of the hammers.
    hammers: Vec<String>,
    /// Names of the castings.
    castings: Vec<String>,
    /// Status and outputs of the row.
    #[schemars(with = "RowOutcome")]
    outcome: Json,
    /// Comparison with the stored row; null unless a dataset's row was run again.
    stored_row: Option<Comparison>,
    /// Measured channels compared with the row's signals.
    measured: Vec<ChannelBeside>,
}

impl SceneResult {
    /// The row's outcome under the names of `engine`'s study.
    pub fn of(engine: &Engine, row: usize, outcome: &RowOutcome, stored_row: Option<Comparison>) -> Self {
        let study = engine.study();
        let (hammers, castings, cores) = (study.hammer_names(), study.casting_names(), study.core_names());
        let cores: Vec<&str> = cores.iter().map(String::as_str).collect();
        let elastic = study.elastic_names();
        let pads = study.pads().into_iter().map(|(casting, fixture)| format!("{casting}.{fixture}"));
        let pads: Vec<String> = pads.collect();
        let pads: Vec<&str> = pads.iter().map(String::as_str).collect();
        let fixtures = study.fixture_names();
        let fixtures: Vec<&str> = fixtures.iter().map(String::as_str).collect();
        let values = study.factors().iter().zip(engine.checked().row_values(row));
        let owned = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
        Self {
            study: study.title().to_owned(),
            study_hash: study.hash().to_owned(),
            row,
            overrides: study.overrides().to_vec(),
            factors: values.map(|(factor, value)| (factor.name.clone(), value)).collect(),
            hammers: owned(&hammers),
            castings: owned(&castings),
            outcome: named(outcome, [&hammers, &castings, &elastic, &cores, &pads, &fixtures]),
            stored_row,
            measured: Vec::new(),
        }
    }

    /// With measured channels.
    pub fn beside(self, measured: Vec<ChannelBeside>) -> Self {
        Self { measured, ..self }
    }
}

/// Schema of [`SceneResult`]: that of the outcome, with what [`named`] changes.
pub(super) fn scene_schema() -> Json {
    let mut schema = schema::<SceneResult>("scene");
    let name = json!({ "type": "string", "description": "Name in the study." });
    for of in ["HammerMetrics", "CastingMetrics", "ElasticMetrics", "CoreMetrics", "PadMetrics", "FixtureMetrics"] {
        schema["$defs"][of]["properties"]["name"] = name.clone();
    }
    schema["$defs"]["Blow"]["properties"]["hammer"] = name;
    let scatter = json!({ "type": ["number", "string", "null"] });
    for of in ["hammers", "castings"] {
        for beside in ["Scatter", "NumericalErrors"] {
            schema["$defs"][beside]["properties"][of]["items"]["additionalProperties"] = scatter.clone();
        }
    }
    schema
}

fn named(outcome: &RowOutcome, [hammers, castings, elastic, cores, pads, fixtures]: [&[&str]; 6]) -> Json {
    let mut value = json!(outcome);
    let Some(metrics) = value.get_mut("metrics").filter(|metrics| metrics.is_object()) else { return value };
    let lists = ["hammers", "castings", "elastic", "cores", "pads", "fixtures"];
    for (list, names) in lists.into_iter().zip([hammers, castings, elastic, cores, pads, fixtures]) {
        for of in [format!("/{list}"), format!("/scatter/{list}"), format!("/numerical/{list}")] {
            let entries = metrics.pointer_mut(&of).and_then(Json::as_array_mut);
            for (entry, name) in entries.into_iter().flatten().zip(names) {
                entry["name"] = json!(name);
            }
        }
    }
    for blow in metrics["blows"].as_array_mut().into_iter().flatten() {
        let hammer = blow["hammer"].as_u64().and_then(|index| hammers.get(usize::try_from(index).ok()?));
        blow["hammer"] = json!(hammer);
    }
    value
}

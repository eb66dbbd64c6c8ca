//! Information for the tables: the study, and the rows.

use std::collections::BTreeMap;

use super::signals::KeptSignals;
use crate::{CheckedStudy, FactorInfo, Study};
use decore_dataset::{Columns, DatasetInfo, FactorColumn, PartColumn, RowRecord, rows_per_part};
use decore_model::metrics::CastingNames;
use decore_model::run::RowOutcome;
use decore_model::scene::NumericalTwin;
use decore_quantity::Kind;
use decore_statistics::design::Quality;

/// Collects the information for the tables: the study, its files, its outside settings, and the stored signals.
pub fn dataset_info(
    checked: &CheckedStudy,
    inputs: BTreeMap<String, String>,
    settings: BTreeMap<String, String>,
    signals: Option<&KeptSignals>,
) -> DatasetInfo {
    let (study, rows) = (checked.study(), checked.row_count() as u64);
    let names = |names: Vec<&str>| names.into_iter().map(str::to_owned).collect();
    let mut info = DatasetInfo {
        study_name: study.title().to_owned(),
        study_text: study.text().to_owned(),
        study_hash: study.hash().to_owned(),
        frame_hash: checked.frame_hash(),
        budget_free_hash: checked.budget_free_hash(),
        rows_hash: checked.rows_hash(checked.row_count()),
        overrides: study.overrides(),
        inputs,
        hammer_files: study.hammer_files(),
        settings,
        seed: study.seed(),
        program_version: env!("CARGO_PKG_VERSION").to_owned(),
        columns_hash: String::new(),
        rows,
        rows_per_part: signals.map_or(rows_per_part(rows), |kept| kept.rows_per_part(rows_per_part(rows))),
        factors: study.factors().iter().map(factor).collect(),
        design_quality: design_quality(checked),
        row_groups: Some(checked.design().groups()),
        twins: study.twins() as u64,
        numerical_twins: study.numerical_twin() != NumericalTwin::None,
        hammers: names(study.hammer_names()),
        castings: names(study.casting_names()),
        elastic_castings: names(study.elastic_names()),
        cores: cores(study),
        pads: study.pads().into_iter().map(|(casting, name)| part(casting, name)).collect(),
        fixture_energies: fixtures(study).filter(|_| study.outputs().fixture_energy).collect(),
        core_spectra: study.outputs().core_spectra,
        signals: signals.map_or_else(Vec::new, |kept| kept.columns.clone()),
    };
    // Two columns of one name are refused where a dataset is made.
    info.columns_hash = Columns::new(&info).map(|columns| columns.hash()).unwrap_or_default();
    info
}

/// Core points of all castings.
fn cores(study: &Study) -> Vec<PartColumn> {
    let of = |casting: &CastingNames<'_>| casting.cores.iter().map(|core| part(casting.name, core)).collect::<Vec<_>>();
    study.castings().iter().flat_map(of).collect()
}

/// Fixtures of all castings.
fn fixtures(study: &Study) -> impl Iterator<Item = PartColumn> {
    study.castings().into_iter().flat_map(|casting| {
        casting.fixtures.into_iter().map(move |fixture| part(casting.name, fixture)).collect::<Vec<_>>()
    })
}

fn part(casting: &str, name: &str) -> PartColumn {
    PartColumn { casting: casting.to_owned(), name: name.to_owned() }
}

/// A row as the tables take it.
pub(super) fn record(study: &CheckedStudy, row: u64, outcome: RowOutcome) -> RowRecord {
    RowRecord { row, factors: study.row_values(row as usize), outcome }
}

/// Measures of the design as JSON; `null` without factors.
fn design_quality(study: &CheckedStudy) -> serde_json::Value {
    // Infinite measures (coinciding rows) become null, as JSON has no word for them.
    let quality = Quality::of(study.design()).and_then(|quality| serde_json::to_value(quality).ok());
    let Some(serde_json::Value::Object(mut summary)) = quality else {
        return serde_json::Value::Null;
    };
    for value in summary.values_mut().filter(|value| value.is_f64()) {
        *value = value.as_f64().map_or(serde_json::Value::Null, nine_digits);
    }
    if let Some(acceptance) = study.acceptance() {
        summary.insert("points_tried".into(), acceptance.tried.into());
        summary.insert("points_accepted".into(), acceptance.accepted.into());
    }
    summary.into()
}

/// A number with nine significant digits: more carry no information, and these survive writing and reading.
fn nine_digits(value: f64) -> serde_json::Value {
    format!("{value:.8e}").parse::<f64>().map_or(serde_json::Value::Null, Into::into)
}

fn factor(info: &FactorInfo) -> FactorColumn {
    let unit = if info.kind == Kind::Text { "" } else { "1" };
    FactorColumn {
        name: info.name.clone(),
        kind: info.kind,
        unit: info.unit.clone().unwrap_or_else(|| unit.to_owned()),
        description: match (info.expression(), info.paths().as_slice()) {
            (None, paths) => format!("Factor of the design; drives {}.", paths.join(", ")),
            (Some(expression), []) => format!("Derived: {expression}."),
            (Some(expression), paths) => format!("Derived: {expression}; drives {}.", paths.join(", ")),
        },
    }
}

//! Schemas of the JSON output of commands.

use serde_json::Value;

use super::accuracy::AccuracyResult;
use super::check_result::Check;
use super::json::schema;
use super::scene_result::scene_schema;
use super::status::DatasetStatus;
use super::structure::StructureResult;
use super::verify::Verified;
use super::written::Written;
use crate::paper::PaperComparison;
use decore_lab::best::Answer;
use decore_lab::comparison::Comparison;
use decore_lab::cores::CoreTests;
use decore_lab::refinement::Progress;
use decore_lab::report::Report;
use decore_lab::sensitivity::Sensitivity;
use decore_lab::surrogate::Surrogate;
use decore_model::structure::MeasuredReport;

/// The schema (JSON Schema 2020-12) of what each command prints with `--json`, by the name that its file in `schemas/` has.
pub fn output_schemas() -> Vec<(&'static str, Value)> {
    vec![
        ("accuracy", schema::<AccuracyResult>("accuracy")),
        ("best", schema::<Answer>("best")),
        ("check", schema::<Check>("check")),
        ("comparison", schema::<Comparison>("comparison")),
        ("cores", schema::<CoreTests>("cores")),
        ("mobility", schema::<MeasuredReport>("mobility")),
        ("paper", schema::<PaperComparison>("paper")),
        ("refinement", schema::<Progress>("refinement")),
        ("report", schema::<Report>("report")),
        ("scene", scene_schema()),
        ("sensitivity", schema::<Sensitivity>("sensitivity")),
        ("status", schema::<Vec<DatasetStatus>>("status")),
        ("structure", schema::<StructureResult>("structure")),
        ("surrogate", schema::<Surrogate>("surrogate")),
        ("verification", schema::<Vec<Verified>>("verification")),
        ("written", schema::<Written>("written")),
    ]
}

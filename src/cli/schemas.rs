//! The schemas of what commands print as JSON.

use serde_json::Value;

use super::accuracy::AccuracyResult;
use super::check_result::Check;
use super::json::schema;
use super::scene_result::scene_schema;
use super::status::DatasetStatus;
use super::structure::StructureResult;
use super::verify::Verified;
use super::written::Written;
use crate::best::Answer;
use crate::comparison::Comparison;
use crate::paper::PaperComparison;
use crate::refinement::Progress;
use crate::report::Report;
use crate::sensitivity::Sensitivity;
use crate::structure::MeasuredReport;
use crate::surrogate::Surrogate;

/// The schema (JSON Schema 2020-12) of what each command prints with `--json`, by the name that its file in `schemas/` has.
pub fn output_schemas() -> Vec<(&'static str, Value)> {
    vec![
        ("accuracy", schema::<AccuracyResult>("accuracy")),
        ("best", schema::<Answer>("best")),
        ("check", schema::<Check>("check")),
        ("comparison", schema::<Comparison>("comparison")),
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

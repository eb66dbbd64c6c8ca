//! First part of a page: the answer to the study's goal, the models behind it, and a plan of the machine.

use serde::Serialize;

use super::knowledge::{Known, MOST_MODELLED};
use super::model::{ModelData, model_data};
use super::site::{CastingPlan, Named, rails_plan};
use decore_dataset::{DatasetReader, TableName};
use decore_lab::best::{
    Added, Answer, AnswerView, ShownValue, There, Track, added_file, added_folder, answer_view, read_added,
};
use decore_lab::surrogate::{Model, SurrogateSettings, fit_with};
use decore_model::metrics::{Aggregates, CoreTotals, RunTotals};
use decore_study::CheckedStudy;
use decore_study::engine::checked;

/// Outputs for the comparison of placements, in addition to goal and limits: work, frequency, velocities, forces and air.
const COMPARED: [&str; 9] = [
    RunTotals::strike_energy_j.name,
    RunTotals::delivered_work_j.name,
    Aggregates::total_first_impact_work_j.name,
    Aggregates::mean_hit_frequency_hz.name,
    CoreTotals::least_core_pseudo_velocity_98hz_10khz_m_s.name,
    Aggregates::max_casting_point_velocity_m_s.name,
    Aggregates::max_arm_rms_steady_m_s.name,
    Aggregates::max_first_impact_peak_force_n.name,
    Aggregates::total_air_used_nl.name,
];

/// The answer as a page has it.
#[derive(Debug, Serialize)]
pub(super) struct Answered {
    answer: Answer,
    values: Vec<ShownValue>,
    uncertain: Vec<usize>,
    nodes: Vec<Vec<f64>>,
    caution: f64,
    model: ModelData,
    /// Models of further outputs, by which placements are compared.
    others: Option<ModelData>,
    plan: Option<Plan>,
}

/// The machine from above: lengths in m, in its plane.
#[derive(Debug, Serialize)]
struct Plan {
    rails: Vec<Named<Vec<[f64; 2]>>>,
    castings: Vec<CastingPlan>,
    hammers: Vec<String>,
    /// Places of the hammers at the proposal, then at the alternatives.
    standing: Vec<Vec<[f64; 2]>>,
    tracks: Vec<Track>,
}

/// Answers the goal of a dataset's study from its rows and the rows that `decore best` added; `None` if the study has no goal. `rows`:
/// number of rows of the dataset. The models are appended to the page's data.
pub(super) fn answered(
    reader: &DatasetReader,
    study: Result<&CheckedStudy, &str>,
    rows: u64,
    data: &mut Vec<u8>,
) -> Option<Known<Answered>> {
    let study = match study {
        Ok(study) => study,
        Err(why) => return (!why.is_empty()).then(|| Known::not(why.to_owned())),
    };
    study.study().goal()?;
    if rows > MOST_MODELLED {
        let why = format!(
            "Models of {rows} rows take longer than a page should: `decore best` answers the goal of the study."
        );
        return Some(Known::not(why));
    }
    let added = match added(reader, study) {
        Ok(added) => added,
        Err(why) => return Some(Known::not(why)),
    };
    let (others, rows) = added.as_ref().map_or((None, &[][..]), |(reader, rows)| (Some(reader), rows.as_slice()));
    let view = answer_view(study, There { base: reader, added: others, rows });
    Some(Known::of(view.map(|view| {
        let model = model_data(&view.model, data);
        let further = further(reader, others, &view.model).map(|model| model_data(&model, data));
        shown(view, (model, further), study)
    })))
}

/// Models of the outputs that the goal does not name; `None` if no row has any.
fn further(reader: &DatasetReader, added: Option<&DatasetReader>, known: &Model) -> Option<Model> {
    let is_new = |name: &&&str| {
        let modelled = known.surrogate.outputs.iter().any(|output| output.output == **name);
        !modelled && reader.column(TableName::Runs, name).is_ok()
    };
    let outputs: Vec<String> = COMPARED.iter().filter(is_new).map(|name| (*name).to_owned()).collect();
    let added: Vec<&DatasetReader> = added.into_iter().collect();
    fit_with(reader, &added, &SurrogateSettings { outputs, ..SurrogateSettings::default() }).ok()
}

/// The rows that `decore best` added to a dataset.
fn added(reader: &DatasetReader, study: &CheckedStudy) -> Result<Option<(DatasetReader, Vec<Added>)>, String> {
    let (folder, file) = (added_folder(reader.folder()), added_file(reader.folder()));
    let Ok(added) = DatasetReader::open(&folder) else { return Ok(None) };
    let rows = read_added(&file, study.study())?;
    let own = study.study().with_rows(&file).map_err(|error| error.to_string())?;
    let own = checked(own).map_err(|error| error.to_string())?;
    if own.frame_hash() != added.manifest().study.frame_hash {
        return Err(format!(
            "{} holds rows of another study: remove it and {}, or run `decore best` on the dataset it belongs to",
            folder.display(),
            file.display()
        ));
    }
    Ok(Some((added, rows)))
}

fn shown(view: AnswerView, (model, others): (ModelData, Option<ModelData>), study: &CheckedStudy) -> Answered {
    let AnswerView { answer, values, uncertain, nodes, caution, standing, tracks, .. } = view;
    Answered { answer, values, uncertain, nodes, caution, model, others, plan: plan(study, standing, tracks) }
}

/// The plan of the first scene, with the hammers of all decisions; `None` if no row describes a scene.
fn plan(study: &CheckedStudy, standing: Vec<Vec<[f64; 2]>>, tracks: Vec<Track>) -> Option<Plan> {
    let scene = (0..study.row_count().min(64)).find_map(|row| study.scene(row).ok())?;
    let castings = scene.castings.iter().map(|casting| CastingPlan::of(casting, None)).collect();
    Some(Plan {
        rails: rails_plan(study.study().rails(), study.points()),
        castings,
        hammers: scene.hammers.iter().map(|hammer| hammer.name.clone()).collect(),
        standing,
        tracks,
    })
}

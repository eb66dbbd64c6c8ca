//! Data of an answer for a page: its models, the draws of the uncertain factors, and the positions of the hammers.

use serde::Serialize;

use super::answer::{Asked, answer};
use super::error::BestError;
use super::model::Models;
use super::result::Answer;
use super::search::Pool;
use super::space::{Decision, Space};
use super::task::{BestSettings, There, question};
use super::trials::Trials;
use crate::refinement::Side;
use crate::surrogate::Model;
use decore_dataset::DatasetReader;
use decore_study::CheckedStudy;

/// Number of steps over a factor's range for the displayed positions of hammers.
const STEPS: usize = 24;

/// An answer with the data for its page, including predictions of other decisions.
#[derive(Debug, Clone)]
pub struct AnswerView {
    /// The answer.
    pub answer: Answer,
    /// Models of the goal and the limits.
    pub model: Model,
    /// The goal, then each limit.
    pub values: Vec<ShownValue>,
    /// The uncertain factors, by their places among the model's factors.
    pub uncertain: Vec<usize>,
    /// Equally likely draws of the uncertain factors, as places in their ranges.
    pub nodes: Vec<Vec<f64>>,
    /// Standard deviations by which the model is taken to err where limits must hold.
    pub caution: f64,
    /// Places of the hammers at the proposal, then at the alternatives; empty if a scene cannot be made.
    pub standing: Vec<Vec<[f64; 2]>>,
    /// Factors that move hammers.
    pub tracks: Vec<Track>,
}

/// A value of the goal or a limit, as a page shows it.
#[derive(Debug, Clone, Serialize)]
pub struct ShownValue {
    /// As the goal states it.
    pub text: String,
    /// Unit; empty if there is none.
    pub unit: String,
    /// Place of its model among the outputs.
    pub output: usize,
    /// Whether small values are better, or must be small.
    pub smaller: bool,
    /// The limit; null for the goal.
    pub limit: Option<f64>,
}

/// Places of the hammers over the range of a decision factor, all others as proposed.
#[derive(Debug, Clone, Serialize)]
pub struct Track {
    /// Name of the factor.
    pub factor: String,
    /// Positions within the range of the factor, 0 to 1, ascending. For a factor of names: the numbers of the names.
    pub at: Vec<f64>,
    /// For each of these the x and y of every hammer, m.
    pub hammers: Vec<Vec<[f64; 2]>>,
}

/// Computes the answer from the existing rows, with the data for its page.
///
/// # Errors
/// As [`super::next`].
pub fn answer_view(study: &CheckedStudy, there: There<'_>) -> Result<AnswerView, BestError> {
    let goal = study.study().goal().ok_or(BestError::NoGoal)?;
    let space = Space::new(study)?;
    let others: Vec<&DatasetReader> = there.added.into_iter().collect();
    let models = Models::fit(goal, there.base, &others)?;
    let trials = Trials::read(there, &question(goal), (&space, &models))?;
    let settings = BestSettings { rows: there.rows.len(), checks: 0, batch: 0 };
    let pool = Pool::new(&space, &models, &trials.decisions())?;
    let answer = answer(pool, &Asked { trials: &trials, settings: &settings, there, study })?;
    let proposals = std::iter::once(&answer.settings).chain(answer.alternatives.iter().map(|one| &one.settings));
    let decisions: Vec<Decision> = proposals.filter_map(|settings| space.decision_at(settings)).collect();
    let standing = decisions.iter().filter_map(|decision| space.standing(decision)).collect();
    let tracks = decisions.first().map_or_else(Vec::new, |decision| tracks(&space, &models, decision));
    let names = (0..space.uncertain.len()).map(|place| &space.uncertain_info(place).name);
    let place = |name: &String| models.model.surrogate.factors.iter().position(|factor| factor.name == *name);
    let uncertain: Vec<usize> = names.filter_map(place).collect();
    let nodes = decisions.first().map(|decision| models.points(&space, std::slice::from_ref(decision))).transpose()?;
    let node = |row: &[f64]| uncertain.iter().map(|place| row[*place]).collect::<Vec<f64>>();
    let nodes = nodes.map_or_else(Vec::new, |points| (0..points.rows()).map(|row| node(points.row(row))).collect());
    let (values, caution) = (shown(&models), models.caution());
    Ok(AnswerView { answer, values, uncertain, nodes, caution, standing, tracks, model: models.model })
}

fn shown(models: &Models) -> Vec<ShownValue> {
    let value = |(place, wanted): (usize, &super::model::Wanted)| ShownValue {
        text: wanted.text.clone(),
        unit: wanted.unit.clone(),
        output: models.output_place(place),
        smaller: wanted.side == Side::Least,
        limit: wanted.bound,
    };
    models.wanted.iter().enumerate().map(value).collect()
}

/// The decision factors that move a hammer.
fn tracks(space: &Space<'_>, models: &Models, decision: &Decision) -> Vec<Track> {
    let mut tracks = Vec::new();
    for place in 0..decision.len() {
        let factor = space.info(place).name.clone();
        let Some(own) = models.model.surrogate.factors.iter().position(|one| one.name == factor) else { continue };
        let along = space.varied(decision, place, (0..=STEPS).map(|step| step as f64 / STEPS as f64));
        let Ok(points) = models.places(space, &along) else { continue };
        let found =
            along.iter().enumerate().filter_map(|(row, one)| Some((points.row(row)[own], space.standing(one)?)));
        let (at, hammers): (Vec<f64>, Vec<Vec<[f64; 2]>>) = found.unzip();
        if hammers.windows(2).any(|pair| pair[0] != pair[1]) {
            tracks.push(Track { factor, at, hammers });
        }
    }
    tracks
}

impl Space<'_> {
    /// Positions of the hammers, x and y in m. `None` if the decision describes no scene, or if a mount has no coordinates.
    fn standing(&self, decision: &Decision) -> Option<Vec<[f64; 2]>> {
        let scene = self.study.scene_at(&self.levels(decision, &self.nodes[self.nodes.len() / 2])).ok()?;
        let points = self.study.points();
        let place = |unit: &decore_model::scene::HammerUnit| {
            let [x, y, _] = unit.mount.position_m(|name| points.position(name))?;
            Some([x, y])
        };
        scene.hammers.iter().map(place).collect()
    }
}

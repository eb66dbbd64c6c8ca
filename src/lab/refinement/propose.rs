//! Proposes the rows of the next batch from a dataset.

use super::acquisition::{Learned, Limited, Seeking, Side, improving, learning};
use super::candidates::{Around, Collector, beside};
use super::climb::{LEAST_DISTANCE, highest_peak};
use super::constant::Constant;
use super::error::RefinementError;
use super::goal::{Aim, Goal, Limit, Target};
use super::progress::{Best, Boundary, OutputProgress, Progress};
use super::separate::{Tried, bounding, separating, sides};
use crate::sensitivity::four_digits;
use crate::surrogate::{FactorSpace, Model, OutputModel, OutputSurrogate, ProcessFigures, RowsProcess, SuccessModel};
use crate::surrogate::{SurrogateError, SurrogateSettings, fit, fit_success, text_places};
use decore_dataset::DatasetReader;
use decore_math::random::hash;
use decore_statistics::regression::{GaussianProcess, LEAST_NOISE, Points, RegressionError};
use decore_study::CheckedStudy;

/// Places among which rows that teach the most are chosen; over them the variance is summed.
const LEARNING: usize = 512;
/// Places among which a better row or a boundary is sought.
const SEARCHED: usize = 2048;
/// Places near the best row, for each of [`REACHES`].
const NEAR_BEST: usize = 512;
/// Distances from it, as shares of the ranges.
const REACHES: [f64; 3] = [0.1, 0.02, 0.004];

/// Least noise where an optimum is sought: under a larger one it would not be found to more than three digits.
pub const SHARP_NOISE: f64 = 1e-10;
/// Rows up to which rounding is smaller than that.
const SHARP_ROWS: usize = 320;
/// Share of the standard deviation that counts in every second row. Those rows follow the expectation, the others explore.
pub const CAUTIOUS: f64 = 0.1;

/// Settings of a proposal.
#[derive(Debug, Clone, PartialEq)]
pub struct RefinementSettings {
    /// Goal of the rows.
    pub goal: Goal,
    /// Rows at a time.
    pub batch: usize,
}

/// Rows to run next.
#[derive(Debug, Clone, PartialEq)]
pub struct Proposal {
    /// Progress without them.
    pub progress: Progress,
    /// Values of all factors, in the study's order, row by row, as cells of a table; none if the goal is reached.
    pub rows: Vec<Vec<String>>,
}

/// Proposes the rows of the next batch from those that the dataset of the study holds.
///
/// Depends on the study, its seed and the rows alone. Every row meets the study's constraints, and is not a row already. None are proposed
/// where the goal is reached, or no place is left ([`Progress::exhausted`]).
///
/// # Errors
/// Those of [`fit`]; [`RefinementError::NoModel`], [`RefinementError::NoCandidates`].
pub fn propose(
    study: &CheckedStudy,
    reader: &DatasetReader,
    settings: &RefinementSettings,
) -> Result<Proposal, RefinementError> {
    let mut proposal = proposed(study, reader, settings)?;
    proposal.progress.exhausted = !proposal.progress.reached && proposal.rows.is_empty();
    Ok(proposal)
}

fn proposed(
    study: &CheckedStudy,
    reader: &DatasetReader,
    settings: &RefinementSettings,
) -> Result<Proposal, RefinementError> {
    let outputs = settings.goal.outputs();
    let modelled = |least_noise: f64| {
        fit(reader, &SurrogateSettings { outputs: outputs.clone(), least_noise, ..SurrogateSettings::default() })
    };
    match &settings.goal {
        Goal::Learn { targets } => {
            ProposalInputs::new(study, reader, &modelled(LEAST_NOISE)?)?.learn(targets, settings.batch)
        }
        Goal::Optimise { side, limits, gain, .. } => {
            let wanted = SoughtOptimum { side: *side, limits, gain: *gain };
            let model = modelled(LEAST_NOISE)?;
            let told = ProposalInputs::new(study, reader, &model)?;
            if study.row_count() > SHARP_ROWS {
                return told.optimise(&wanted, settings.batch, &told);
            }
            ProposalInputs::new(study, reader, &modelled(SHARP_NOISE)?)?.optimise(&wanted, settings.batch, &told)
        }
        Goal::Bound { limit, unsure } => {
            ProposalInputs::new(study, reader, &modelled(LEAST_NOISE)?)?.bound((limit, *unsure), settings.batch)
        }
        Goal::Separate { unsure } => separate(study, reader, (*unsure, settings.batch)),
    }
}

/// An output with its model.
struct Modelled<'a> {
    figures: &'a OutputSurrogate,
    of: &'a OutputModel,
    process: &'a RowsProcess,
    fitted: &'a ProcessFigures,
}

impl<'a> Modelled<'a> {
    fn new((figures, of): (&'a OutputSurrogate, &'a OutputModel)) -> Result<Self, RefinementError> {
        match (&of.process, &figures.process) {
            (Some(process), Some(fitted)) => Ok(Self { figures, of, process, fitted }),
            _ => {
                let reason = figures.refused.clone().unwrap_or_default();
                Err(RefinementError::NoModel { output: figures.output.clone(), reason })
            }
        }
    }

    /// Probability of each place that a run there has the output.
    fn success(&self, places: &Points) -> Result<Vec<f64>, RegressionError> {
        match self.of.success_of(self.figures) {
            None => Ok(vec![1.0; places.rows()]),
            Some(success) => success.predict(places),
        }
    }

    fn progress(&self, places: &Points) -> Result<OutputProgress, RegressionError> {
        let predicted = self.process.process.predict(places)?;
        let sum: f64 = predicted.iter().map(|at| at.std_dev).sum();
        Ok(OutputProgress {
            output: self.figures.output.clone(),
            unit: self.figures.unit.clone(),
            used: self.figures.used,
            constant: None,
            q2: self.fitted.least_q2(),
            width: 2.0 * self.fitted.reach * sum / predicted.len() as f64,
        })
    }
}

/// An optimum that is sought.
struct SoughtOptimum<'a> {
    side: Side,
    limits: &'a [Limit],
    gain: Option<f64>,
}

/// A row to be run, as cells of a table, and its merit.
struct ProposedRow {
    row: Vec<String>,
    merit: f64,
}

/// Data from which proposals are made.
struct ProposalInputs<'a> {
    study: &'a CheckedStudy,
    model: &'a Model,
    outputs: Vec<Modelled<'a>>,
    /// Outputs that need no model.
    constants: Vec<Constant>,
    seed: u64,
}

impl<'a> ProposalInputs<'a> {
    fn new(study: &'a CheckedStudy, reader: &DatasetReader, model: &'a Model) -> Result<Self, RefinementError> {
        let (mut outputs, mut constants) = (Vec::new(), Vec::new());
        for of in model.surrogate.outputs.iter().zip(&model.outputs) {
            match Modelled::new(of) {
                Ok(modelled) => outputs.push(modelled),
                Err(error) => constants.push(Constant::read(reader, model, of.0)?.ok_or(error)?),
            }
        }
        Ok(Self { study, model, outputs, constants, seed: seed_of(study) })
    }

    fn progress(&self, places: &Points) -> Result<Progress, RegressionError> {
        let mut progress = Progress::new(self.model.surrogate.study.clone(), self.study.row_count() as u64);
        progress.outputs = self.outputs.iter().map(|of| of.progress(places)).collect::<Result<_, _>>()?;
        progress.outputs.extend(self.constants.iter().map(Constant::progress));
        progress.notes.clone_from(&self.model.surrogate.notes);
        Ok(progress)
    }

    fn learn(&self, targets: &[Target], batch: usize) -> Result<Proposal, RefinementError> {
        let collector = self.spread(LEARNING, LEAST_DISTANCE)?;
        let places = self.places(&collector.places())?;
        let mut progress = self.progress(&places)?;
        let mut short = Vec::new();
        for (of, own) in self.outputs.iter().zip(&progress.outputs) {
            let aim = targets.iter().find(|target| target.output == own.output).map(|target| target.aim);
            let reached = match aim {
                Some(Aim::Q2(least)) => own.q2 >= least,
                Some(Aim::Width(most)) => own.width <= most,
                None => true,
            };
            if !reached {
                short.push(Learned { process: &of.process.process, success: of.success(&places)?, boundary: None });
            }
        }
        progress.reached = short.is_empty();
        let is_over = progress.reached || collector.found.is_empty();
        let chosen = if is_over { Vec::new() } else { learning(&short, &places, batch)? };
        Ok(Proposal::new(progress, &collector, chosen))
    }

    fn bound(&self, (limit, unsure): (&Limit, f64), batch: usize) -> Result<Proposal, RefinementError> {
        let collector = self.spread(SEARCHED, LEAST_DISTANCE)?;
        let places = self.places(&collector.places())?;
        let mut progress = self.progress(&places)?;
        let Some(Modelled { process, .. }) = self.outputs.first() else {
            let within = self.constants.iter().all(|of| limit.holds(of.value));
            progress.boundary = Some(Boundary { within: if within { 1.0 } else { 0.0 }, unsure: 0.0 });
            progress.reached = true;
            return Ok(Proposal { progress, rows: Vec::new() });
        };
        let process = &process.process;
        let limited = Limited { process, side: limit.side, value: limit.value };
        let found = Boundary::new(&limited.beside(&places)?);
        progress.reached = found.unsure <= unsure;
        progress.boundary = Some(found);
        if progress.reached || collector.found.is_empty() {
            return Ok(Proposal { progress, rows: Vec::new() });
        }
        let chosen = bounding(&limited, &self.outputs[0].success(&places)?, &places, batch)?;
        Ok(Proposal::new(progress, &collector, chosen))
    }

    /// `told`: models of the rows as in `decore surrogate`, for the printed figures.
    fn optimise(
        &self,
        wanted: &SoughtOptimum<'_>,
        batch: usize,
        told: &ProposalInputs<'_>,
    ) -> Result<Proposal, RefinementError> {
        if let Some(of) = self.constants.iter().find(|of| of.output == self.model.surrogate.outputs[0].output) {
            let reason = format!("it is {} in all rows that have it: none is better", four_digits(of.value));
            return Err(RefinementError::NoModel { output: of.output.clone(), reason });
        }
        let mut collector = self.spread(SEARCHED, beside(batch, self.study.design().factors().len()))?;
        let mut progress = told.progress(&self.places(&collector.places())?)?;
        progress.rows_within = Some(self.within(wanted).len() as u64);
        progress.best = told.best(wanted)?;
        if let Some(levels) = progress.best.as_ref().and_then(|best| self.study.design().row(best.row as usize)) {
            for (stage, reach) in REACHES.into_iter().enumerate() {
                collector.near(&levels, Around { count: NEAR_BEST, reach }, hash(self.seed, 1, stage as u64))?;
            }
        }
        let mut believed: Vec<GaussianProcess> = self.outputs.iter().map(|of| of.process.process.clone()).collect();
        let mut rows: Vec<Vec<String>> = Vec::new();
        let mut best = self.expected(wanted)?;
        while rows.len() < batch {
            let limits: Vec<Limited<'_>> =
                wanted.limits.iter().filter_map(|limit| self.limited(&believed, limit)).collect();
            let bold = (self.study.row_count() + rows.len()).is_multiple_of(2);
            let share = if bold { 1.0 } else { CAUTIOUS };
            let seeking = Seeking { process: &believed[0], side: wanted.side, limits: &limits, best, share };
            let Some(ProposedRow { row, merit }) = self.peak(&seeking, &mut collector)? else { break };
            let next = [row];
            if rows.is_empty() && best.is_some() {
                // Print the gain by the expected improvement itself, even if another criterion chooses the row.
                let merit = if bold { merit } else { self.merits(&Seeking { share: 1.0, ..seeking }, &next)?[0] };
                progress.gain = Some(merit.exp());
                progress.reached = wanted.gain.zip(progress.gain).is_some_and(|(least, gain)| gain < least);
                if progress.reached {
                    break;
                }
            }
            for at in believed[0].predict(&self.places(&next)?)? {
                best = best.map(|best| better(wanted.side, [best, at.mean]));
            }
            rows.extend(next);
            believed = self.believed(&self.places(&rows)?)?;
        }
        Ok(Proposal { progress, rows })
    }

    /// The row at the highest peak near the candidates; it is no candidate any more.
    fn peak(
        &self,
        seeking: &Seeking<'_>,
        collector: &mut Collector<'_>,
    ) -> Result<Option<ProposedRow>, RefinementError> {
        if collector.found.is_empty() {
            return Ok(None);
        }
        let merits = self.merits(seeking, &collector.found)?;
        let mut near = |places: &[Vec<f64>]| self.merits_at(seeking, collector, places);
        let Some(peak) = highest_peak((&collector.shares, &merits), &mut near)? else { return Ok(None) };
        // Rounding of its shares may bring a candidate too near to a row, or past a constraint.
        let Some(row) = collector.cells_at(&peak.at)? else {
            collector.discard(&peak.at);
            return self.peak(seeking, collector);
        };
        collector.take(&peak.at);
        Ok(Some(ProposedRow { row, merit: peak.merit }))
    }

    /// Merits of places by their shares of the ranges: none if no row may be run.
    fn merits_at(
        &self,
        seeking: &Seeking<'_>,
        collector: &Collector<'_>,
        places: &[Vec<f64>],
    ) -> Result<Vec<f64>, RefinementError> {
        let cells = places.iter().map(|place| collector.cells_at(place));
        let cells = cells.collect::<Result<Vec<Option<Vec<String>>>, RefinementError>>()?;
        let allowed: Vec<Vec<String>> = cells.iter().flatten().cloned().collect();
        if allowed.is_empty() {
            return Ok(vec![f64::NEG_INFINITY; places.len()]);
        }
        let mut merits = self.merits(seeking, &allowed)?.into_iter();
        Ok(cells.iter().map(|cells| cells.as_ref().and_then(|_| merits.next()).unwrap_or(f64::NEG_INFINITY)).collect())
    }

    /// Merits of candidates, and how likely runs there have all outputs.
    fn merits(&self, seeking: &Seeking<'_>, candidates: &[Vec<String>]) -> Result<Vec<f64>, RefinementError> {
        let places = self.places(candidates)?;
        let mut merits = improving(seeking, &places)?;
        merits.iter_mut().zip(self.success_of_all(&places)?).for_each(|(merit, success)| *merit += success);
        Ok(merits)
    }

    /// Candidates over the whole ranges; `beside`: smallest distance between the rows that are taken.
    fn spread(&self, count: usize, beside: f64) -> Result<Collector<'_>, RefinementError> {
        let mut collector = Collector::new(self.study, beside);
        collector.fill(count, self.seed)?;
        Ok(collector)
    }

    /// Logarithm of the probability at each place that a run there has all outputs: the value of the least probable output, because rows
    /// fail as a whole.
    fn success_of_all(&self, places: &Points) -> Result<Vec<f64>, RegressionError> {
        let mut least = vec![1.0_f64; places.rows()];
        for of in &self.outputs {
            least.iter_mut().zip(of.success(places)?).for_each(|(least, own)| *least = least.min(own));
        }
        Ok(least.into_iter().map(|success| success.max(f64::MIN_POSITIVE).ln()).collect())
    }

    fn limited<'b>(&self, believed: &'b [GaussianProcess], limit: &Limit) -> Option<Limited<'b>> {
        let process = believed.get(self.place_of(limit)?)?;
        Some(Limited { process, side: limit.side, value: limit.value })
    }

    /// The place of a limit's output among the modelled ones.
    fn place_of(&self, limit: &Limit) -> Option<usize> {
        self.outputs.iter().position(|of| of.figures.output == limit.output)
    }

    /// Processes with the chosen rows at their expected values (kriging believer, Ginsbourger and others, 2010).
    fn believed(&self, chosen: &Points) -> Result<Vec<GaussianProcess>, RegressionError> {
        let believe = |modelled: &Modelled<'_>| {
            let of = modelled.process;
            let expected: Vec<f64> = of.process.predict(chosen)?.iter().map(|at| at.mean).collect();
            let places = of.process.places().with(chosen, &expected)?;
            GaussianProcess::with(&places, (of.process.kernel(), of.process.hyperparameters().clone()))
        };
        self.outputs.iter().map(believe).collect()
    }

    /// The row with the best value among those within the limits.
    fn best(&self, wanted: &SoughtOptimum<'_>) -> Result<Option<Best>, RegressionError> {
        let own = self.outputs[0].process;
        let rows = self.within(wanted).into_iter().map(|place| (own.rows[place], own.values[place]));
        let found = rows.fold(None, |best: Option<(usize, f64)>, (row, value)| match best {
            Some((_, least)) if better(wanted.side, [least, value]) == least => best,
            _ => Some((row, value)),
        });
        let Some((row, value)) = found else { return Ok(None) };
        let at = own.process.predict(&self.model.points.select(&[row]))?;
        Ok(at.first().map(|at| Best { row: self.model.rows[row], value, expected: at.mean, std_dev: at.std_dev }))
    }

    /// Best expected value of a row within the limits, without noise: the value to improve.
    fn expected(&self, wanted: &SoughtOptimum<'_>) -> Result<Option<f64>, RegressionError> {
        let own = self.outputs[0].process;
        let rows: Vec<usize> = self.within(wanted).into_iter().map(|place| own.rows[place]).collect();
        let means = own.process.predict(&self.model.points.select(&rows))?.into_iter().map(|at| at.mean);
        Ok(means.reduce(|best, mean| better(wanted.side, [best, mean])))
    }

    /// The rows within the limits, by their places among those that have the output.
    fn within(&self, wanted: &SoughtOptimum<'_>) -> Vec<usize> {
        let value_of = |output: usize, row: usize| {
            let of = self.outputs[output].process;
            of.rows.binary_search(&row).ok().map(|place| of.values[place])
        };
        let holds = |limit: &Limit, row: usize| match self.place_of(limit) {
            Some(output) => value_of(output, row).is_some_and(|value| limit.holds(value)),
            None => self.constants.iter().any(|of| of.output == limit.output && of.holds(limit, row)),
        };
        let rows = self.outputs[0].process.rows.iter().enumerate();
        rows.filter(|(_, row)| wanted.limits.iter().all(|limit| holds(limit, **row))).map(|(place, _)| place).collect()
    }

    fn places(&self, candidates: &[Vec<String>]) -> Result<Points, SurrogateError> {
        places(self.study, &self.model.surrogate.factors, candidates)
    }
}

/// Candidates, given as the cells of all factors, as places of models, whose factors are some of the study's.
///
/// # Errors
/// Those of [`text_places`].
pub fn places(
    study: &CheckedStudy,
    factors: &[FactorSpace],
    candidates: &[Vec<String>],
) -> Result<Points, SurrogateError> {
    let known: Vec<&str> = study.study().factors().iter().map(|factor| factor.name.as_str()).collect();
    let columns: Vec<usize> =
        factors.iter().filter_map(|factor| known.iter().position(|name| *name == factor.name)).collect();
    let row = |cells: &Vec<String>| columns.iter().map(|column| cells[*column].clone()).collect();
    text_places(factors, &candidates.iter().map(row).collect::<Vec<Vec<String>>>())
}

/// Rows that show where rows fail; `unsure`: the share of the places whose side may remain uncertain.
fn separate(
    study: &CheckedStudy,
    reader: &DatasetReader,
    (unsure, batch): (f64, usize),
) -> Result<Proposal, RefinementError> {
    let SuccessModel { study: name, factors, points, succeeded, success } = fit_success(reader)?;
    let mut collector = Collector::new(study, LEAST_DISTANCE);
    collector.fill(SEARCHED, seed_of(study))?;
    let places = places(study, &factors, &collector.places())?;
    let found = Boundary::new(&sides(&success, &places)?);
    let mut progress = Progress::new(name, study.row_count() as u64);
    progress.failed = Some(succeeded.iter().filter(|success| !**success).count() as u64);
    let without_scene = (0..study.row_count()).filter(|row| study.scene(*row).is_err()).count();
    progress.without_scene = Some(without_scene as u64);
    progress.reached = found.unsure <= unsure;
    progress.boundary = Some(found);
    let chosen = match progress.reached || collector.found.is_empty() {
        true => Vec::new(),
        false => separating(&success, &Tried { points: &points, succeeded: &succeeded }, &places, batch)?,
    };
    Ok(Proposal::new(progress, &collector, chosen))
}

/// The seed of a batch.
fn seed_of(study: &CheckedStudy) -> u64 {
    hash(study.design().seed(), study.row_count() as u64, 0)
}

impl Proposal {
    fn new(progress: Progress, candidates: &Collector<'_>, chosen: Vec<usize>) -> Self {
        Self { progress, rows: chosen.into_iter().map(|place| candidates.found[place].clone()).collect() }
    }
}

/// The better of two values.
fn better(side: Side, [a, b]: [f64; 2]) -> f64 {
    match side {
        Side::Least => a.min(b),
        Side::Most => a.max(b),
    }
}

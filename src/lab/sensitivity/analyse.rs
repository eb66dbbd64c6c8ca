//! Computes indices from a dataset.

use rayon::prelude::*;

use super::dependence::dependence;
use super::error::SensitivityError;
use super::neighbours::Neighbours;
use super::reach::moves;
use super::result::{Index, IndexName, Intervals, Method, OutputSensitivity, Sensitivity, UnitName, Used};
use super::table::{FactorColumn, OutputColumn, Table, differ};
use super::units::{NOT_RUN, Units, UsableUnits};
use decore_dataset::{DatasetReader, TableName};
use decore_model::metrics::{Aggregates, CoreTotals, RunTotals};
use decore_statistics::analysis::{
    AnalysisError, Bootstrap, Effects, Estimate, Estimator, FactorValues, MOST_SHAPLEY_FACTORS, SaltelliBlocks,
    SobolIndices, Trajectories, given, morris, shapley, sobol,
};
use decore_statistics::design::{Kind, Morris, Saltelli};
use decore_study::DesignOutline;

/// Default outputs of an analysis.
pub const DEFAULT_OUTPUTS: [&str; 6] = [
    RunTotals::strike_energy_j.name,
    Aggregates::total_first_impact_work_j.name,
    Aggregates::mean_hit_frequency_hz.name,
    CoreTotals::least_core_pseudo_velocity_98hz_10khz_m_s.name,
    Aggregates::max_casting_point_velocity_m_s.name,
    Aggregates::total_air_used_nl.name,
];

/// Settings of an analysis.
#[derive(Debug, Clone, PartialEq)]
pub struct SensitivitySettings {
    /// Columns of `runs`; empty (default): [`DEFAULT_OUTPUTS`].
    pub outputs: Vec<String>,
    /// Estimator of Sobol' indices, if there are such. Default: `None`, [`Estimator::Salib`].
    pub estimator: Option<Estimator>,
    /// Whether a Saltelli design is analysed as any rows are, by its base points. Default: no.
    pub given: bool,
    /// Settings of the intervals. Default: 1000 replicates, seed 0, 95 %.
    pub bootstrap: Bootstrap,
}

impl Default for SensitivitySettings {
    fn default() -> Self {
        let bootstrap = Bootstrap { replicates: 1000, seed: 0, level: Bootstrap::LEVEL };
        Self { outputs: Vec::new(), estimator: None, given: false, bootstrap }
    }
}

/// Reads a dataset and computes the indices of its outputs. If the dataset is still being written, its present rows count.
///
/// Takes memory for the requested columns.
///
/// # Errors
/// Those of reading, and [`SensitivityError`] where the rows are not those of a design that has indices. An output that has
/// none (constant, too few whole units) is no error: it says why.
pub fn analyse(reader: &DatasetReader, settings: &SensitivitySettings) -> Result<Sensitivity, SensitivityError> {
    let study = &reader.manifest().study;
    let outline = DesignOutline::read(&study.study_text, &study.overrides, &study.study_name)?;
    serves(&outline, settings)?;
    let named = |name: &&str| reader.columns(TableName::Runs).iter().any(|column| column.name == *name);
    let outputs = match settings.outputs.as_slice() {
        [] => DEFAULT_OUTPUTS.iter().filter(|name| named(name)).map(|name| (*name).to_owned()).collect(),
        some => some.to_vec(),
    };
    let mut table = Table::read(reader, &outline, &outputs)?;
    if table.factors.is_empty() {
        return Err(SensitivityError::NoFactors);
    }
    let rows_there = table.rows.len() as u64;
    let plan = AnalysisPlan::of(&mut table, &outline, (settings, study.rows))?;
    let neighbours =
        if plan.method == Method::Given { Neighbours::of(&table, &outline) } else { Neighbours::default() };
    let task = TablePlan { table: &table, outline: &outline, plan, neighbours, bootstrap: settings.bootstrap };
    let replicates = match plan.method {
        Method::Given => settings.bootstrap.halves(),
        _ => settings.bootstrap.replicates,
    };
    Ok(Sensitivity {
        study: study.study_name.clone(),
        study_hash: study.study_hash.clone(),
        program_version: study.program_version.clone(),
        rows: study.rows,
        rows_there,
        factors: table.factors.iter().map(|factor| factor.name.clone()).collect(),
        method: plan.method,
        intervals: Intervals { replicates, seed: settings.bootstrap.seed, level: settings.bootstrap.level },
        notes: notes(&task),
        outputs: table.outputs.par_iter().map(|output| task.output(output)).collect(),
    })
}

/// Checks settings against the design of a dataset, before anything is run or computed.
///
/// # Errors
/// Those of reading; [`SensitivityError::Estimator`], [`SensitivityError::Given`], [`SensitivityError::Trajectories`].
pub fn check(reader: &DatasetReader, settings: &SensitivitySettings) -> Result<(), SensitivityError> {
    let study = &reader.manifest().study;
    serves(&DesignOutline::read(&study.study_text, &study.overrides, &study.study_name)?, settings)
}

/// Returns an error for settings that have no effect with this design.
fn serves(outline: &DesignOutline, settings: &SensitivitySettings) -> Result<(), SensitivityError> {
    let saltelli = matches!(outline.design, Some(Kind::Saltelli(_)));
    let morris = matches!(outline.design, Some(Kind::Morris(_)));
    match (settings.given, settings.estimator) {
        (true, _) if morris => Err(SensitivityError::Trajectories),
        (true, _) if !saltelli => Err(SensitivityError::Given),
        (given, Some(estimator)) if given || !saltelli || !outline.constraints.is_empty() => {
            let why = match (given, saltelli) {
                (true, _) => "with `given`, other indices are computed",
                (false, true) => "constraints make the factors depend on each other",
                (false, false) => "they do not belong to a `saltelli` design",
            };
            Err(SensitivityError::Estimator { estimator: estimator.name(), why })
        }
        _ => Ok(()),
    }
}

/// Method, and the rows that it uses.
#[derive(Clone, Copy)]
struct AnalysisPlan {
    method: Method,
    units: Units,
}

impl AnalysisPlan {
    /// Chooses the method for the design. If a Saltelli design is analysed like other rows, the table keeps only its base points.
    fn of(
        table: &mut Table,
        outline: &DesignOutline,
        (settings, rows): (&SensitivitySettings, u64),
    ) -> Result<Self, SensitivityError> {
        let factors = table.factors.len();
        match outline.design {
            Some(Kind::Saltelli(Saltelli { second_order, .. })) => {
                let blocks = SaltelliBlocks { factors, second_order };
                let size = blocks.size();
                let units = Units { name: UnitName::Blocks, size, rows };
                units.check(table, "block", |factor, place| origin(blocks, (factor, place)))?;
                if !settings.given && outline.constraints.is_empty() {
                    let estimator = settings.estimator.unwrap_or_default();
                    return Ok(Self { method: Method::Sobol { estimator, block: size }, units });
                }
                let last = size as u64 - 1;
                table.retain(|row| matches!(row % (last + 1), place if place == 0 || place == last));
                Ok(Self::given(2 * (rows / size as u64)))
            }
            Some(Kind::Morris(Morris { levels, .. })) => {
                let size = factors + 1;
                let units = Units { name: UnitName::Trajectories, size, rows };
                Ok(Self { method: Method::Morris { levels, block: size }, units })
            }
            _ => Ok(Self::given(rows)),
        }
    }

    fn given(rows: u64) -> Self {
        Self { method: Method::Given, units: Units { name: UnitName::Rows, size: 1, rows } }
    }
}

/// The row of a block, the first (A) or the last (B), whose value a factor has in the row at this place of the block.
fn origin(blocks: SaltelliBlocks, (factor, place): (usize, usize)) -> usize {
    let last = blocks.size() - 1;
    let from_b = match place {
        0 => false,
        place if place == last => true,
        place if place <= blocks.factors => place - 1 == factor,
        place => place - 1 - blocks.factors != factor,
    };
    if from_b { last } else { 0 }
}

/// Blocks or trajectories below which the ends of bootstrap intervals lie too near.
const FEW_UNITS: u64 = 20;

/// A plan for a table.
struct TablePlan<'a> {
    table: &'a Table,
    outline: &'a DesignOutline,
    plan: AnalysisPlan,
    neighbours: Neighbours,
    bootstrap: Bootstrap,
}

impl TablePlan<'_> {
    fn output(&self, output: &OutputColumn) -> OutputSensitivity {
        let AnalysisPlan { method, units } = self.plan;
        let UsableUnits { starts, used } = units.whole(self.table, output);
        let values = units.gather(&output.values, &starts);
        let indices = match method {
            Method::Sobol { estimator, block } => {
                let factors = self.table.factors.len();
                let blocks = SaltelliBlocks { factors, second_order: block > factors + 2 };
                sobol(&values, blocks, estimator, &self.bootstrap).map(|found| self.sobol_indices(&found))
            }
            Method::Morris { levels, .. } => {
                let columns = self.table.factors.iter().map(|factor| {
                    let outline = self.outline.factors.iter().find(|of| of.name == factor.name);
                    moves(factor, outline, units.gather(&factor.values, &starts))
                });
                let (factors, reaches): (Vec<_>, Vec<_>) = columns.unzip();
                morris(&values, Trajectories { factors: &factors, levels, reaches: &reaches }, &self.bootstrap)
                    .map(|found| self.effects(&found))
            }
            Method::Given => self.given_indices(values, &starts),
        };
        let (refused, indices) = match indices {
            Ok(indices) => (None, indices),
            Err(error) => (Some(refusal(&error)), Vec::new()),
        };
        let description = output.description.clone();
        let notes = if refused.is_none() { self.output_notes(&indices, &starts, &used) } else { Vec::new() };
        OutputSensitivity {
            output: description.name,
            unit: description.unit,
            description: description.description,
            used,
            refused,
            notes,
            indices,
        }
    }

    /// Indices of the factors that vary.
    fn given_indices(&self, mut values: Vec<f64>, starts: &[usize]) -> Result<Vec<Index>, AnalysisError> {
        let factors = self.table.factors.iter().enumerate();
        let of_rows = |(place, factor): (usize, &FactorColumn)| {
            let values = self.plan.units.gather(&factor.values, starts);
            (place, values)
        };
        let varying = factors.map(of_rows).filter(|(_, values)| differ(values));
        let (places, mut columns): (Vec<usize>, Vec<Vec<f64>>) = varying.unzip();
        self.neighbours.once_each(&mut columns, &mut values);
        let nominal = |place: usize| self.table.factors[place].nominal;
        let factors: Vec<FactorValues<'_>> = places
            .iter()
            .zip(&columns)
            .map(|(place, values)| FactorValues { values, nominal: nominal(*place) })
            .collect();
        let drawn = self.neighbours.refused.is_none();
        let mut indices = Vec::new();
        // The other indices take more factors.
        if drawn && factors.len() <= MOST_SHAPLEY_FACTORS {
            let found = shapley(&values, &factors, &self.bootstrap)?;
            indices.extend(places.iter().zip(&found).map(|(place, of)| self.index(IndexName::Shapley, &[*place], of)));
        }
        for (place, found) in places.iter().zip(&given(&values, &factors, &self.bootstrap)?) {
            let plain = |value: f64| Estimate { value, interval: None };
            let ratio = if self.neighbours.even { found.even_correlation_ratio } else { found.correlation_ratio };
            if drawn {
                indices.push(self.index(IndexName::Rank, &[*place], &found.rank));
            }
            indices.extend(
                [
                    (IndexName::CorrelationRatio, ratio),
                    (IndexName::Pawn, plain(found.pawn.median)),
                    (IndexName::PawnMaximum, plain(found.pawn.maximum)),
                    (IndexName::HsicR2, plain(found.hsic.r2)),
                    (IndexName::HsicPValue, plain(found.hsic.p_value)),
                ]
                .iter()
                .map(|(name, estimate)| self.index(*name, &[*place], estimate)),
            );
        }
        Ok(indices)
    }

    /// Returns notes on the indices of one output.
    fn output_notes(&self, indices: &[Index], starts: &[usize], used: &Used) -> Vec<String> {
        let AnalysisPlan { method, units } = self.plan;
        let mut notes = Vec::new();
        if method != Method::Given && used.whole < FEW_UNITS && self.bootstrap.replicates > 0 {
            let unit = units.name.plural();
            notes.push(format!(
                "intervals from fewer than {FEW_UNITS} {unit} contain the true value less often than \
                stated"
            ));
        }
        if used.left_out.iter().any(|left_out| left_out.reason != NOT_RUN) {
            notes.push(
                "the failed rows are not a random sample: a factor that makes rows fail matters more than shown here \
                 (`decore surrogate` shows the probability of success over the factors)"
                    .to_owned(),
            );
        }
        let still = |factor: &&FactorColumn| factor.varies() && !differ(&units.gather(&factor.values, starts));
        let still: Vec<String> =
            self.table.factors.iter().filter(still).map(|factor| format!("`{}`", factor.name)).collect();
        // Blocks have indices of it: it does nothing.
        if !still.is_empty() && !matches!(method, Method::Sobol { .. }) {
            let (still, unit) = (still.join(", "), units.name.plural());
            notes.push(format!("no indices of {still}: only one value is left in the {unit} that have this output"));
        }
        let varying = self.table.factors.iter().filter(|factor| factor.varies()).count() - still.len();
        if method == Method::Given && self.neighbours.refused.is_none() && varying > MOST_SHAPLEY_FACTORS {
            notes.push(format!("no Shapley effects: {varying} factors are more than {MOST_SHAPLEY_FACTORS}"));
        }
        let bare = |index: &&Index| index.index.has_interval() && index.interval.is_none();
        let mut bare: Vec<&str> = indices.iter().filter(bare).map(|index| index.index.symbol()).collect();
        bare.sort_unstable();
        bare.dedup();
        if self.bootstrap.replicates > 0 && !bare.is_empty() {
            notes.push(format!(
                "some intervals of {} are missing: some replicates have no such index, for example if the output \
                 differs in only a few {}",
                bare.join(", "),
                units.name.plural()
            ));
        }
        notes
    }

    fn index(&self, index: IndexName, factors: &[usize], estimate: &Estimate) -> Index {
        Index {
            index,
            factors: factors.iter().map(|factor| self.table.factors[*factor].name.clone()).collect(),
            value: Some(estimate.value).filter(|value| value.is_finite()),
            interval: estimate.interval,
        }
    }

    fn sobol_indices(&self, found: &SobolIndices) -> Vec<Index> {
        let of_factors = [(IndexName::S1, &found.first), (IndexName::St, &found.total)];
        let mut indices = Vec::new();
        for (name, estimates) in of_factors {
            indices.extend(estimates.iter().enumerate().map(|(factor, found)| self.index(name, &[factor], found)));
        }
        indices.extend(found.second.iter().map(|pair| self.index(IndexName::S2, &pair.factors, &pair.index)));
        indices
    }

    /// Names have no direction, so their factors have only mu*.
    fn effects(&self, found: &[Option<Effects>]) -> Vec<Index> {
        let mut indices = Vec::new();
        for (factor, effects) in found.iter().enumerate() {
            let Some(effects) = effects else { continue };
            indices.push(self.index(IndexName::MuStar, &[factor], &effects.mean_size));
            if !self.table.factors[factor].nominal {
                indices.push(self.index(IndexName::Mu, &[factor], &effects.mean));
                indices.push(self.index(IndexName::Sigma, &[factor], &effects.std_dev));
            }
        }
        indices
    }
}

fn refusal(error: &AnalysisError) -> String {
    format!("no indices: {error}")
}

/// Returns notes for the reader.
fn notes(task: &TablePlan<'_>) -> Vec<String> {
    let TablePlan { table, outline, plan, neighbours, bootstrap } = task;
    let mut notes = Vec::new();
    let constant = table.factors.iter().filter(|factor| !factor.varies()).map(|factor| &factor.name);
    let constant: Vec<String> = constant.map(|name| format!("`{name}`")).collect();
    if !constant.is_empty() {
        notes.push(format!("These factors do not vary in the rows: {}.", constant.join(", ")));
    }
    let derived = outline.factors.iter().filter(|factor| factor.derived);
    let derived: Vec<String> = derived.map(|factor| format!("`{}`", factor.name)).collect();
    if !derived.is_empty() {
        notes.push(format!("Left out, as they follow from the other factors: {}.", derived.join(", ")));
    }
    match plan.method {
        Method::Sobol { .. } if bootstrap.replicates == 0 => {}
        Method::Sobol { .. } => notes.push(
            "The intervals assume independent base points. The design's Sobol' points usually scatter less, so the \
             intervals contain the true value more often than stated."
                .to_owned(),
        ),
        Method::Morris { .. } => {
            notes.push("mu*, mu and sigma are changes of the output per whole range of the factor, of names from one to another.".to_owned());
            let nominal = table.factors.iter().filter(|factor| factor.nominal);
            let nominal: Vec<String> = nominal.map(|factor| format!("`{}`", factor.name)).collect();
            if !nominal.is_empty() {
                notes.push(format!(
                    "Factors of names have only mu*, because names have no order: {}.",
                    nominal.join(", ")
                ));
            }
        }
        Method::Given => {
            notes.extend(dependence(table, outline, neighbours.refused.is_none()));
            notes.extend(neighbours.notes());
        }
    }
    notes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A table of one Saltelli block of two factors: A is 0 and 1, B is 10 and 11.
    fn block(first: [f64; 6], second: [f64; 6]) -> Table {
        let column = |values: [f64; 6]| FactorColumn {
            name: "x".into(),
            values: values.to_vec(),
            nominal: false,
            names: Vec::new(),
        };
        Table {
            rows: (0..6).collect(),
            faults: vec![None; 6],
            reasons: Vec::new(),
            factors: vec![column(first), column(second)],
            outputs: Vec::new(),
        }
    }

    #[test]
    fn rows_that_are_not_the_design_s_are_refused() {
        let blocks = SaltelliBlocks { factors: 2, second_order: true };
        let units = Units { name: UnitName::Blocks, size: blocks.size(), rows: 6 };
        let check = |table: Table| units.check(&table, "block", |factor, place| origin(blocks, (factor, place)));
        let first = [0.0, 10.0, 0.0, 0.0, 10.0, 10.0];
        assert!(check(block(first, [1.0, 1.0, 11.0, 11.0, 1.0, 11.0])).is_ok());
        // The second factor in the order of a design without second order.
        let wrong = check(block(first, [1.0, 1.0, 11.0, 1.0, 1.0, 11.0]));
        assert!(matches!(wrong, Err(SensitivityError::Layout { first: 0, last: 5, .. })), "{wrong:?}");
    }
}

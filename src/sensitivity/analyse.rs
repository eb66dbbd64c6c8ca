//! From a dataset to indices.

use rayon::prelude::*;

use super::error::SensitivityError;
use super::result::{Index, IndexName, Intervals, Method, OutputSensitivity, Sensitivity, UnitName};
use super::table::{OutputColumn, Table};
use super::units::{Units, Whole};
use crate::analysis::{
    AnalysisError, Bootstrap, Effects, Estimate, Estimator, SaltelliBlocks, SobolIndices, Trajectories, morris, sobol,
};
use crate::dataset::{Aggregates, DatasetReader, TableName};
use crate::design::{Kind, Morris, Saltelli};
use crate::metrics::RunTotals;
use crate::study::DesignOutline;

/// Outputs that are analysed unless others are asked for.
pub const DEFAULT_OUTPUTS: [&str; 5] = [
    RunTotals::delivered_work_j.name,
    Aggregates::total_first_impact_work_j.name,
    Aggregates::mean_hit_frequency_hz.name,
    Aggregates::max_casting_point_velocity_m_s.name,
    Aggregates::total_air_used_nl.name,
];

/// What to compute.
#[derive(Debug, Clone, PartialEq)]
pub struct SensitivitySettings {
    /// Columns of `runs`; empty (default): [`DEFAULT_OUTPUTS`].
    pub outputs: Vec<String>,
    /// Estimator of Sobol' indices. Default [`Estimator::Salib`].
    pub estimator: Estimator,
    /// How intervals are found. Default: 1000 replicates, seed 0, 95 %.
    pub bootstrap: Bootstrap,
}

impl Default for SensitivitySettings {
    fn default() -> Self {
        let bootstrap = Bootstrap { replicates: 1000, seed: 0, level: Bootstrap::LEVEL };
        Self { outputs: Vec::new(), estimator: Estimator::default(), bootstrap }
    }
}

/// Reads a dataset and computes the indices of its outputs. The dataset may still be written: what is there counts.
///
/// Takes memory for the columns that are asked for.
///
/// # Errors
/// Those of reading, and [`SensitivityError`] where the rows are not those of a design that has indices. An output that has
/// none (constant, too few whole units) is no error: it says why.
pub fn analyse(reader: &DatasetReader, settings: &SensitivitySettings) -> Result<Sensitivity, SensitivityError> {
    let study = &reader.manifest().study;
    let outline = DesignOutline::read(&study.study_text, &study.overrides, &study.study_name)?;
    let named = |name: &&str| reader.columns(TableName::Runs).iter().any(|column| column.name == *name);
    let outputs = match settings.outputs.as_slice() {
        [] => DEFAULT_OUTPUTS.iter().filter(|name| named(name)).map(|name| (*name).to_owned()).collect(),
        some => some.to_vec(),
    };
    let table = Table::read(reader, &outline, &outputs)?;
    if table.factors.is_empty() {
        return Err(SensitivityError::NoFactors);
    }
    let task = Task::of(&table, &outline, (settings, study.rows))?;
    let bootstrap = settings.bootstrap;
    Ok(Sensitivity {
        study: study.study_name.clone(),
        study_hash: study.study_hash.clone(),
        program_version: study.program_version.clone(),
        rows: study.rows,
        rows_there: table.rows.len() as u64,
        factors: table.factors.iter().map(|factor| factor.name.clone()).collect(),
        method: task.method,
        intervals: Intervals { replicates: bootstrap.replicates, seed: bootstrap.seed, level: bootstrap.level },
        notes: notes(&table, &outline, task.method),
        outputs: table.outputs.par_iter().map(|output| task.output(output)).collect(),
    })
}

/// What is computed from which rows.
struct Task<'a> {
    table: &'a Table,
    method: Method,
    units: Units,
    bootstrap: Bootstrap,
}

impl<'a> Task<'a> {
    fn of(
        table: &'a Table,
        outline: &DesignOutline,
        (settings, rows): (&SensitivitySettings, u64),
    ) -> Result<Self, SensitivityError> {
        let factors = table.factors.len();
        let (method, units) = match outline.design {
            Some(Kind::Saltelli(_)) if !outline.constraints.is_empty() => {
                return Err(SensitivityError::Dependent { constraints: outline.constraints.clone() });
            }
            Some(Kind::Saltelli(Saltelli { second_order, .. })) => {
                let size = SaltelliBlocks { factors, second_order }.size();
                let units = Units { name: UnitName::Blocks, size, rows };
                // A factor has its value of A or of B, the first and the last row.
                units.check(table, "block", |factor, place| match place.checked_sub(1) {
                    None => 0,
                    Some(_) if place == size - 1 => place,
                    Some(mixed) if mixed < factors => {
                        if mixed == factor {
                            size - 1
                        } else {
                            0
                        }
                    }
                    Some(mixed) => {
                        if mixed - factors == factor {
                            0
                        } else {
                            size - 1
                        }
                    }
                })?;
                (Method::Sobol { estimator: settings.estimator, block: size }, units)
            }
            Some(Kind::Morris(Morris { levels, .. })) => {
                let size = factors + 1;
                (Method::Morris { levels, block: size }, Units { name: UnitName::Trajectories, size, rows })
            }
            _ => return Err(SensitivityError::Design { kind: kind_name(outline) }),
        };
        Ok(Self { table, method, units, bootstrap: settings.bootstrap })
    }

    fn output(&self, output: &OutputColumn) -> OutputSensitivity {
        let Whole { starts, used } = self.units.whole(self.table, output);
        let values = self.units.gather(&output.values, &starts);
        let indices = match self.method {
            Method::Sobol { estimator, block } => {
                let factors = self.table.factors.len();
                let blocks = SaltelliBlocks { factors, second_order: block > factors + 2 };
                sobol(&values, blocks, estimator, &self.bootstrap).map(|found| self.sobol_indices(&found))
            }
            Method::Morris { levels, .. } => {
                let columns = self.table.factors.iter().map(|factor| self.units.gather(&factor.values, &starts));
                let factors: Vec<Vec<f64>> = columns.collect();
                morris(&values, Trajectories { factors: &factors, levels }, &self.bootstrap)
                    .map(|found| self.effects(&found))
            }
        };
        let (refused, indices) = match indices {
            Ok(indices) => (None, indices),
            Err(error) => (Some(refusal(&error)), Vec::new()),
        };
        let description = output.description.clone();
        OutputSensitivity {
            output: description.name,
            unit: description.unit,
            description: description.description,
            used,
            refused,
            indices,
        }
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

    /// Names have no direction: of their factors only mu* is told.
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

fn kind_name(outline: &DesignOutline) -> String {
    serde_json::to_value(outline.kind).ok().and_then(|kind| kind.as_str().map(str::to_owned)).unwrap_or_default()
}

/// What a reader must know.
fn notes(table: &Table, outline: &DesignOutline, method: Method) -> Vec<String> {
    let mut notes = Vec::new();
    let still = |values: &[f64]| values.windows(2).all(|pair| pair[0] == pair[1]);
    let constant = table.factors.iter().filter(|factor| still(&factor.values)).map(|factor| &factor.name);
    let constant: Vec<String> = constant.map(|name| format!("`{name}`")).collect();
    if !constant.is_empty() {
        notes.push(format!("These factors do not vary in the rows: {}.", constant.join(", ")));
    }
    let derived = outline.factors.iter().filter(|factor| factor.derived);
    let derived: Vec<String> = derived.map(|factor| format!("`{}`", factor.name)).collect();
    if !derived.is_empty() {
        notes.push(format!("Left out, as they follow from the other factors: {}.", derived.join(", ")));
    }
    if matches!(method, Method::Sobol { .. }) {
        notes.push(
            "Intervals are those of independent base points; the design's Sobol' points mostly scatter less: then they hold the truth \
             more often than they say."
                .to_owned(),
        );
    }
    if matches!(method, Method::Morris { .. }) {
        notes.push("mu*, mu and sigma are changes of the output per whole range of the factor.".to_owned());
        let nominal = table.factors.iter().filter(|factor| factor.nominal);
        let nominal: Vec<String> = nominal.map(|factor| format!("`{}`", factor.name)).collect();
        if !nominal.is_empty() {
            notes.push(format!("Of factors of names only mu* is told, names having no order: {}.", nominal.join(", ")));
        }
    }
    notes
}

//! Space of the decisions, and draws of the uncertain factors.

use super::error::BestError;
use super::result::Setting;
use decore_math::random::{hash, uniform};
use decore_quantity::Value;
use decore_statistics::design::{
    Coordinate, Design, Distribution, Factor, Kind, LatinHypercube, Level, Placement, Sobol,
};
use decore_study::{CheckedStudy, FactorInfo, FactorRole};

/// Draws of the uncertain factors by which averages and quantiles are computed: 38 of 40 are 95 %.
const NODES: usize = 40;
/// The same where several factors are uncertain.
const MORE_NODES: usize = 80;
/// Smallest number of steps in a range when values are rounded.
const STEPS: f64 = 100.0;
/// Rounding error, as a share of a step.
const ROUNDING: f64 = 1e-6;
/// Share of a distribution without ends that is cut off on either side.
const CUT_OFF: f64 = 5e-4;

/// Levels of the decision factors, in the design's order.
pub(super) type Decision = Vec<Level>;

/// The factors of a study by their roles.
pub(super) struct Space<'a> {
    pub study: &'a CheckedStudy,
    /// Decision factors, by their places in the design.
    pub decisions: Vec<usize>,
    /// Uncertain factors, by their places in the design.
    pub uncertain: Vec<usize>,
    /// Equally likely levels of the uncertain factors; one empty list if there are none.
    pub nodes: Vec<Vec<Level>>,
}

impl<'a> Space<'a> {
    /// # Errors
    /// [`BestError::NoDecision`].
    pub fn new(study: &'a CheckedStudy) -> Result<Self, BestError> {
        let drawn: Vec<&FactorInfo> = drawn(study);
        let of = |role: FactorRole| (0..drawn.len()).filter(|place| drawn[*place].role == role).collect::<Vec<usize>>();
        let (decisions, uncertain) = (of(FactorRole::Decision), of(FactorRole::Uncertain));
        if decisions.is_empty() {
            return Err(BestError::NoDecision);
        }
        let mut space = Self { study, decisions, uncertain, nodes: vec![Vec::new()] };
        if !space.uncertain.is_empty() {
            let count = if space.uncertain.len() == 1 { NODES } else { MORE_NODES };
            space.nodes = space.draws(count, Placement::Centred, 0)?;
        }
        Ok(space)
    }

    /// Levels of the uncertain factors, one of each stratum of their distributions.
    pub fn draws(&self, count: usize, placement: Placement, stream: u64) -> Result<Vec<Vec<Level>>, BestError> {
        let kind = Kind::LatinHypercube(LatinHypercube { rows: count, placement, ..LatinHypercube::default() });
        let design = Design::new(kind, self.factors(&self.uncertain), hash(self.seed(), 1, stream))?;
        Ok((0..count).filter_map(|row| design.row(row)).collect())
    }

    pub fn seed(&self) -> u64 {
        self.study.design().seed()
    }

    fn factors(&self, places: &[usize]) -> Vec<Factor> {
        places.iter().map(|place| self.study.design().factors()[*place].clone()).collect()
    }

    fn distribution(&self, decision: usize) -> &Distribution {
        &self.study.design().factors()[self.decisions[decision]].distribution
    }

    /// Study's description of a decision factor.
    pub fn info(&self, decision: usize) -> &FactorInfo {
        drawn(self.study)[self.decisions[decision]]
    }

    /// Study's description of an uncertain factor.
    pub fn uncertain_info(&self, place: usize) -> &FactorInfo {
        drawn(self.study)[self.uncertain[place]]
    }

    /// Decisions that fill their ranges, and decisions in a box around a feasible place.
    pub fn spread(&self, count: usize) -> Result<Vec<Decision>, BestError> {
        let kind = Kind::Sobol(Sobol { rows: 4 * count, scramble: true });
        let design = Design::new(kind, self.factors(&self.decisions), hash(self.seed(), 2, 0))?;
        let mut found: Vec<Decision> = Vec::new();
        for row in 0..4 * count {
            let decision = self.settable(&design.row(row).unwrap_or_default());
            if found.len() < count && !found.contains(&decision) && self.is_allowed(&decision)? {
                found.push(decision);
            }
        }
        match found.is_empty() {
            true => Err(BestError::NoCandidates { tried: 4 * count }),
            false => Ok(found),
        }
    }

    /// Decisions up to `reach` of each range away from one; of names, one in four changes.
    pub fn near(
        &self,
        centre: &[Level],
        (count, reach): (usize, f64),
        stream: u64,
    ) -> Result<Vec<Decision>, BestError> {
        let mut found: Vec<Decision> = Vec::new();
        for index in 0..count {
            let at = hash(hash(self.seed(), 3, stream), 0, index as u64);
            let moved = |(place, level): (usize, &Level)| {
                let draw = |number: u64| uniform(at, number, place as u64);
                let distribution = self.distribution(place);
                if let Distribution::Categories { .. } = distribution {
                    return if draw(1) < 0.25 { distribution.quantile(draw(0)) } else { *level };
                }
                let share = Coordinate::Value(*level).unit(distribution) + reach * (2.0 * draw(0) - 1.0);
                distribution.quantile(share.clamp(0.0, 1.0))
            };
            let decision = self.settable(&centre.iter().enumerate().map(moved).collect::<Decision>());
            if !found.contains(&decision) && self.is_allowed(&decision)? {
                found.push(decision);
            }
        }
        Ok(found)
    }

    /// A decision with numbers rounded for setting: to a power of ten below a hundredth of the range.
    fn settable(&self, decision: &[Level]) -> Decision {
        let rounded = |(place, level): (usize, &Level)| match level {
            Level::Real(value) => Level::Real(rounded(*value, self.distribution(place))),
            other => *other,
        };
        decision.iter().enumerate().map(rounded).collect()
    }

    /// A decision moved by up to half a step of its numbers: within the accuracy with which it is set.
    pub fn jittered(&self, decision: &[Level], stream: u64) -> Decision {
        let moved = |(place, level): (usize, &Level)| match level {
            Level::Real(value) => {
                let [low, high] = ends(self.distribution(place));
                let away = step(*value, self.distribution(place))
                    * (uniform(hash(self.seed(), 4, stream), 0, place as u64) - 0.5);
                Level::Real((value + away).clamp(low, high))
            }
            other => *other,
        };
        decision.iter().enumerate().map(moved).collect()
    }

    /// Levels of all drawn factors.
    pub fn levels(&self, decision: &[Level], node: &[Level]) -> Vec<Level> {
        let mut levels = vec![Level::Real(f64::NAN); self.study.design().factors().len()];
        self.decisions.iter().zip(decision).for_each(|(place, level)| levels[*place] = *level);
        self.uncertain.iter().zip(node).for_each(|(place, level)| levels[*place] = *level);
        levels
    }

    /// Values of all factors as cells of a table that read back the same.
    pub fn cells(&self, levels: &[Level]) -> Vec<String> {
        self.study.values_at(levels).iter().map(Value::to_string).collect()
    }

    /// The decision of a row, given as [`Self::cells`]; `None` for cells that are not values of the factors.
    pub fn decision_of(&self, cells: &[String]) -> Option<Decision> {
        Some(self.settable(&self.levels_of(cells)?))
    }

    /// Whether a row has a decision, within the accuracy with which it is set.
    pub fn has(&self, cells: &[String], decision: &[Level]) -> bool {
        let near = |(place, (own, level)): (usize, (&Level, &Level))| match (own, level) {
            (Level::Real(own), Level::Real(value)) => {
                (own - value).abs() <= (0.5 + ROUNDING) * step(*value, self.distribution(place))
            }
            _ => own == level,
        };
        self.levels_of(cells).is_some_and(|levels| levels.iter().zip(decision).enumerate().all(near))
    }

    /// Levels of a row's decision factors, as they were set.
    fn levels_of(&self, cells: &[String]) -> Option<Vec<Level>> {
        let drawn = drawn(self.study);
        let level = |place: &usize| {
            let factor = drawn[*place];
            let own = self.study.study().factors().iter().position(|other| other.name == factor.name)?;
            let cell = cells.get(own)?;
            match factor.distribution()? {
                Distribution::Categories { .. } => {
                    let number = cell.parse::<f64>().ok();
                    // A text is not a number: `None` on both sides would be the same.
                    let same = |value: &Value| {
                        value.to_string() == *cell || number.is_some_and(|number| value.number() == Some(number))
                    };
                    factor.values.iter().position(same).map(Level::Category)
                }
                Distribution::Integer { .. } | Distribution::LogInteger { .. } => cell.parse().ok().map(Level::Integer),
                _ => cell.parse().ok().map(Level::Real),
            }
        };
        self.decisions.iter().map(level).collect()
    }

    /// The decision with these settings; `None` if one is missing or no value of its factor.
    pub fn decision_at(&self, settings: &[Setting]) -> Option<Decision> {
        let factors = self.study.study().factors();
        let of = |name: &str| settings.iter().find(|setting| setting.factor == name);
        let cells = factors.iter().map(|factor| of(&factor.name).map_or_else(String::new, |one| one.value.to_string()));
        self.decision_of(&cells.collect::<Vec<String>>())
    }

    /// Decisions with one factor at these shares of its distribution; of names, at each of them.
    pub fn varied(&self, decision: &[Level], place: usize, shares: impl Iterator<Item = f64>) -> Vec<Decision> {
        let distribution = self.distribution(place);
        let with = |level: Level| {
            let mut moved = decision.to_vec();
            moved[place] = level;
            moved
        };
        match distribution {
            Distribution::Categories { count } => (0..*count).map(|number| with(Level::Category(number))).collect(),
            _ => shares.map(|share| with(distribution.quantile(share))).collect(),
        }
    }

    /// Position of a decision: shares of the ranges; for names their numbers.
    pub fn place(&self, decision: &[Level]) -> Vec<f64> {
        let at = |(place, level): (usize, &Level)| match level {
            Level::Category(number) => *number as f64,
            level => Coordinate::Value(*level).unit(self.distribution(place)),
        };
        decision.iter().enumerate().map(at).collect()
    }

    /// Whether rows of a decision meet the constraints and describe scenes, as the first, the middle and the last node show.
    fn is_allowed(&self, decision: &[Level]) -> Result<bool, BestError> {
        let mut nodes = vec![0, self.nodes.len() / 2, self.nodes.len() - 1];
        nodes.dedup();
        for node in nodes {
            let levels = self.levels(decision, &self.nodes[node]);
            if !self.study.meets(&levels)? || self.study.scene_at(&levels).is_err() {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

/// Factors that the design draws, in its order.
fn drawn(study: &CheckedStudy) -> Vec<&FactorInfo> {
    study.study().factors().iter().filter(|factor| factor.distribution().is_some()).collect()
}

fn ends(distribution: &Distribution) -> [f64; 2] {
    let end = |share: f64| match distribution.quantile(share) {
        Level::Real(value) => value,
        _ => f64::NAN,
    };
    match distribution {
        Distribution::Normal { .. } => [CUT_OFF, 1.0 - CUT_OFF].map(end),
        _ => distribution.range().map_or([f64::NEG_INFINITY, f64::INFINITY], |(low, high)| [low, high]),
    }
}

/// Step to which a value is rounded: a power of ten; of a logarithmic range by the value itself.
fn step(value: f64, distribution: &Distribution) -> f64 {
    let [low, high] = ends(distribution);
    let size = match distribution {
        Distribution::LogUniform { .. } => value.abs(),
        _ => high - low,
    };
    let step = 10_f64.powf((size / STEPS).log10().floor());
    if step.is_finite() && step > 0.0 { step } else { f64::MIN_POSITIVE }
}

fn rounded(value: f64, distribution: &Distribution) -> f64 {
    let step = step(value, distribution);
    // By its decimals, so that it has no more digits than needed.
    let decimals = (-step.log10()).round();
    let near = match (1.0..300.0).contains(&decimals) {
        true => format!("{value:.0$}", decimals as usize).parse().unwrap_or(value),
        false => (value / step).round() * step,
    };
    let [low, high] = ends(distribution);
    near.clamp(low, high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_rounded_to_what_can_be_set() {
        let uniform = Distribution::Uniform { low: -0.12, high: 0.12 };
        assert_eq!(rounded(0.020_62, &uniform), 0.021);
        assert_eq!(rounded(0.119_99, &uniform), 0.12);
        assert_eq!(rounded(7.123_4, &Distribution::Uniform { low: 4.0, high: 8.123_456 }), 7.12);
        assert_eq!(rounded(8.118, &Distribution::Uniform { low: 4.0, high: 8.118 }), 8.118, "not beyond the range");
        assert_eq!(rounded(12_345_678.0, &Distribution::LogUniform { low: 1e6, high: 1e9 }), 12_300_000.0);
    }
}

//! Training, validation and test rows. A number from (seed, group) decides alone, so that no group is in two parts, and a group keeps its
//! part when the dataset grows.

use super::column::{FeatureColumn, Role};
use super::error::FeaturesError;
use super::groups::Groups;
use decore_math::random::uniform;
use decore_quantity::{CellColumn, Kind, Value};

/// Stream of the numbers that decide.
const STREAM: u64 = 0x7370_6c69_7473;
/// Largest deviation of the sum of the shares from 1 through rounding of decimals.
const ROUNDING: f64 = 1e-9;

/// Shares of the groups that go into the parts.
#[derive(Debug, Clone, PartialEq)]
pub struct Splits {
    shares: Vec<f64>,
    seed: u64,
}

impl Splits {
    /// Shares of training and test, or of training, validation and test.
    ///
    /// # Errors
    /// [`FeaturesError::Shares`] for anything but two or three positive numbers that add up to 1.
    pub fn new(shares: &[f64], seed: u64) -> Result<Self, FeaturesError> {
        let sum: f64 = shares.iter().sum();
        let positive = shares.iter().all(|share| *share > 0.0);
        match (2..=3).contains(&shares.len()) && positive && (sum - 1.0).abs() <= ROUNDING {
            true => Ok(Self { shares: shares.to_vec(), seed }),
            false => Err(FeaturesError::Shares { given: shares.to_vec() }),
        }
    }

    /// Names of the parts, in the order of the shares.
    pub fn names(&self) -> &'static [&'static str] {
        if self.shares.len() == 2 { &["train", "test"] } else { &["train", "validation", "test"] }
    }

    /// The part of the group whose first row this is.
    fn part(&self, first_row: u64) -> &'static str {
        let drawn = uniform(self.seed, STREAM, first_row);
        let mut end = 0.0;
        for (share, name) in self.shares.iter().zip(self.names()) {
            end += share;
            if drawn < end {
                return name;
            }
        }
        "test"
    }

    /// The column of the parts, each run repeated for its castings.
    ///
    /// # Errors
    /// [`FeaturesError::EmptyPart`].
    pub(super) fn column(&self, groups: &Groups, castings: usize) -> Result<FeatureColumn, FeaturesError> {
        let parts: Vec<&str> = groups.first_rows.iter().map(|row| self.part(*row)).collect();
        if let Some(name) = self.names().iter().find(|name| !parts.contains(name)) {
            return Err(FeaturesError::EmptyPart { part: name, groups: parts.len() });
        }
        let part = |group: &usize| parts.get(*group).map(|part| Value::Text(*part));
        let values = groups.groups.iter().flat_map(|group| std::iter::repeat_n(part(group), castings));
        Ok(FeatureColumn {
            name: "split".to_owned(),
            unit: String::new(),
            role: Role::Split,
            description: format!("Part that the row is for: {}; no group is in two of them.", self.names().join(", ")),
            formula: format!("by a number from (seed {}, group), shares {:?}", self.seed, self.shares),
            valid: [None, None],
            derived_from: vec!["group_id".to_owned()],
            values: CellColumn::of(Kind::Category, values),
        })
    }
}

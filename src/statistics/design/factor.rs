//! Factors and their domains.

use super::distribution::Distribution;
use super::error::DesignError;

/// One factor of a design.
#[derive(Debug, Clone, PartialEq)]
pub struct Factor {
    /// Domain of the factor.
    pub distribution: Distribution,
    /// Number of levels in a grid, ends included. Needed there for real factors; integers and categories default to all
    /// their values. Not used by sampling kinds.
    pub levels: Option<usize>,
}

impl Factor {
    /// Number of levels in a grid; `index` is for the error.
    pub(super) fn level_count(&self, index: usize) -> Result<u64, DesignError> {
        match (self.distribution.value_count(), self.levels) {
            (Some(all), None) => Ok(all),
            (None, None) => Err(DesignError::LevelsNeeded { factor: index }),
            (all, Some(levels)) => {
                let most = all.unwrap_or(u64::MAX);
                let wanted = levels as u64;
                if wanted < 2.min(most) || wanted > most {
                    return Err(DesignError::Levels { factor: index, levels, most });
                }
                Ok(wanted)
            }
        }
    }
}

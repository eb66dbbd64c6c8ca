//! Castings of the hammers.

use super::error::FeaturesError;
use super::plan::{Reads, factor_column};
use decore_dataset::{DatasetInfo, DatasetReader};
use decore_quantity::{Cell, Value};
use decore_study::DesignOutline;

/// How a study gives the casting of a hammer.
enum Said {
    /// The same in all rows: its place among the castings.
    Always(usize),
    /// By a factor: the place of its column among those read.
    Factor(usize),
}

/// Casting of each hammer, in the order of the hammers.
pub(super) struct Assignment<'a> {
    info: &'a DatasetInfo,
    said: Vec<Said>,
}

impl<'a> Assignment<'a> {
    /// Reads it from the study's text: the key `casting` of a hammer, the factor that drives it, or the only casting.
    ///
    /// # Errors
    /// [`FeaturesError::Casting`].
    pub fn of(
        reader: &'a DatasetReader,
        outline: &DesignOutline,
        reads: &mut Reads<'a>,
    ) -> Result<Self, FeaturesError> {
        let info = &reader.manifest().study;
        let mut said = Vec::with_capacity(info.hammers.len());
        for hammer in &info.hammers {
            let driver = outline.driver(&["hammer", hammer, "casting"]);
            let column = driver.and_then(|factor| factor_column(reader, &factor.name));
            said.push(match (column, outline.strikes.get(hammer)) {
                (Some(column), _) => Said::Factor(reads.place(&column.name)),
                (None, Some(casting)) => Said::Always(place(info, hammer, (casting, 0))?),
                (None, None) => Said::Always(0),
            });
        }
        Ok(Self { info, said })
    }

    /// The casting of each hammer in a row with these cells.
    ///
    /// # Errors
    /// [`FeaturesError::Casting`].
    pub fn castings(&self, row: u64, cells: &[Cell<'_>]) -> Result<Vec<usize>, FeaturesError> {
        let mut castings = Vec::with_capacity(self.said.len());
        for (hammer, said) in self.info.hammers.iter().zip(&self.said) {
            castings.push(match said {
                Said::Always(place) => *place,
                Said::Factor(column) => match cells.get(*column) {
                    Some(Some(Value::Text(name))) => place(self.info, hammer, (name, row))?,
                    _ => 0,
                },
            });
        }
        Ok(castings)
    }
}

fn place(info: &DatasetInfo, hammer: &str, (casting, row): (&str, u64)) -> Result<usize, FeaturesError> {
    info.castings.iter().position(|name| name == casting).ok_or_else(|| FeaturesError::Casting {
        hammer: hammer.to_owned(),
        casting: casting.to_owned(),
        row,
    })
}

//! Sand and binder of the cores of each casting: a text of the study, or of the factor that drives it.

use super::plan::{Reads, factor_column};
use decore_dataset::DatasetReader;
use decore_quantity::Cell;
use decore_study::DesignOutline;

/// Where the sand and binder of a casting come from.
enum Stated {
    /// The study.
    Always(String),
    /// A cell of the run.
    Factor(usize),
    Nowhere,
}

/// Sand and binder of each casting.
pub(super) struct Binders(Vec<Stated>);

impl Binders {
    /// Reads `casting.NAME.sand_binder` of the study, and the factors that drive it.
    pub fn of<'a>(reader: &'a DatasetReader, outline: &DesignOutline, reads: &mut Reads<'a>) -> Self {
        let stated = |casting: &String| {
            let driver = outline.driver(&["casting", casting, "sand_binder"]);
            match driver.and_then(|factor| factor_column(reader, &factor.name)) {
                Some(column) => Stated::Factor(reads.place(&column.name)),
                None => outline.sand_binders.get(casting).cloned().map_or(Stated::Nowhere, Stated::Always),
            }
        };
        Self(reader.manifest().study.castings.iter().map(stated).collect())
    }

    /// Whether some casting has one.
    pub fn any(&self) -> bool {
        self.0.iter().any(|stated| !matches!(stated, Stated::Nowhere))
    }

    /// Sand and binder of a casting, by its place, in a row with these cells.
    pub fn of_casting(&self, casting: usize, cells: &[Cell<'_>]) -> Option<String> {
        match self.0.get(casting)? {
            Stated::Always(text) => Some(text.clone()),
            Stated::Factor(place) => Some(cells.get(*place)?.as_ref()?.to_string()),
            Stated::Nowhere => None,
        }
    }

    /// Sand and binder of all castings; `None` if no casting has one.
    pub fn of_run(&self, cells: &[Cell<'_>]) -> Option<Vec<Option<String>>> {
        self.any().then(|| (0..self.0.len()).map(|casting| self.of_casting(casting, cells)).collect())
    }
}

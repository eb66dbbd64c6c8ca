//! The exchange formats, one file each.

mod abaqus;
mod calculix;
mod dmig;
mod harwell_boeing;
mod matrix_market;
mod op4;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::entry::{Form, Format};

pub(super) use matrix_market::parse_matrix_market;

/// The formats with the files that hold their entries; names and documentation are those of the study's key `format`.
macro_rules! matrix_formats {
    ($($(#[$documentation:meta])+ $format:ident: $file:ident,)+) => {
        /// Exchange format of matrices.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum MatrixFormat {
            $($(#[$documentation])+ $format,)+
        }

        impl MatrixFormat {
            const ALL: &[Self] = &[$(Self::$format),+];

            pub(super) fn entry(self) -> &'static Format {
                match self {
                    $(Self::$format => &$file::FORMAT,)+
                }
            }
        }
    };
}

matrix_formats! {
    /// Matrix Market text (`.mtx`), coordinate or array; also from APDL Math and SciPy.
    MatrixMarket: matrix_market,
    /// CalculiX `.sti` and `.mas` of `*FREQUENCY, SOLVER=MATRIXSTORAGE`, with the `.dof` file as `dof_file`.
    Calculix: calculix,
    /// Nastran DMIG entries in a punch or bulk data file (`.pch`, `.bdf`), small, large and free field; its ten digits suit reduced
    /// models only.
    Dmig: dmig,
    /// Nastran OUTPUT4 (`.op4`), text or binary of either byte order and integer size, dense or sparse; all matrices but the named
    /// ones are passed over.
    Op4: op4,
    /// Harwell-Boeing text (`.matrix`, `.rsa`), as ANSYS writes it with `HBMAT`, its `.mapping` as `dof_file`.
    HarwellBoeing: harwell_boeing,
    /// Abaqus text of `*MATRIX OUTPUT`, by node and direction or by row.
    Abaqus: abaqus,
}

impl MatrixFormat {
    /// The format that the end of a file's name stands for; `.gz` may follow.
    pub fn of_file(file: &str) -> Option<Self> {
        let name = file.to_ascii_lowercase();
        let ending = name.strip_suffix(".gz").unwrap_or(&name).rsplit_once('.')?.1;
        Self::ALL.iter().copied().find(|format| format.entry().endings.contains(&ending))
    }
}

/// A form in which matrices can be written.
#[derive(Clone, Copy)]
pub struct ExportFormat {
    pub(super) format: MatrixFormat,
    pub(super) form: &'static Form,
}

/// Name of the list of rows.
const ROWS_FILE: &str = "model.dof";
/// Name of the table of points.
const POINTS_FILE: &str = "points.csv";

impl ExportFormat {
    /// All forms.
    pub fn all() -> impl Iterator<Item = Self> {
        let forms = |format: MatrixFormat| format.entry().forms.iter().map(move |form| Self { format, form });
        MatrixFormat::ALL.iter().copied().flat_map(forms)
    }

    /// The form of this name on the command line.
    pub fn named(name: &str) -> Option<Self> {
        Self::all().find(|format| format.name() == name)
    }

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        self.form.name
    }

    /// Names of the files that are written in it: stiffness, mass, damping where the model has some, rows where they are labelled,
    /// points.
    pub fn files(self) -> [&'static str; 5] {
        let [stiffness, mass, damping] = self.form.files;
        [stiffness, mass, damping, ROWS_FILE, POINTS_FILE]
    }

    /// What gets lost in it, for the user to know; `None` where every bit is kept.
    pub fn loss(self) -> Option<&'static str> {
        self.form.loss
    }
}

impl std::fmt::Debug for ExportFormat {
    fn fmt(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        formatter.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first of two would hide the other: no ending of a file, and no name of a form, stands for two.
    #[test]
    fn endings_and_names_are_of_one_format_each() {
        let endings = MatrixFormat::ALL.iter().flat_map(|format| format.entry().endings.iter().copied());
        for mut words in [endings.collect::<Vec<_>>(), ExportFormat::all().map(ExportFormat::name).collect()] {
            let count = words.len();
            words.sort_unstable();
            words.dedup();
            assert!(count > 5 && words.len() == count, "{words:?}");
        }
    }
}

//! The exchange formats, one file each.

mod abaqus;
mod calculix;
mod dmig;
mod harwell_boeing;
mod matrix_market;
mod npz;
mod op4;
mod user_element;

use std::fs::File;
use std::io::Read;
use std::path::Path;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::entry::{Form, Format};
use super::lines::unpacked;

pub(super) use matrix_market::parse_matrix_market;

/// Formats and their files. Names and documentation belong to the study's key `format`.
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
    /// Nastran DMIG entries in a punch or bulk data file (`.pch`, `.bdf`), small, large and free field; its ten digits are enough only for
    /// reduced models.
    Dmig: dmig,
    /// Nastran OUTPUT4 (`.op4`), text or binary of either byte order and integer size, dense or sparse; reads only the named matrices.
    Op4: op4,
    /// Harwell-Boeing text (`.matrix`, `.rsa`) of ANSYS (`HBMAT`), with its `.mapping` as `dof_file`.
    HarwellBoeing: harwell_boeing,
    /// Abaqus text of `*MATRIX OUTPUT`, by node and direction or by row; superelements of Abaqus and CalculiX (`*USER ELEMENT`) of
    /// `*SUBSTRUCTURE MATRIX OUTPUT, OUTPUT FILE=USER DEFINED`.
    Abaqus: abaqus,
    /// SciPy's `scipy.sparse.save_npz` (`.npz`), CSR, CSC or COO, packed or not.
    Npz: npz,
}

impl MatrixFormat {
    /// The format that the end of a file's name stands for; `.gz` may follow.
    pub fn of_file(file: &str) -> Option<Self> {
        let name = file.to_ascii_lowercase();
        let ending = name.strip_suffix(".gz").unwrap_or(&name).rsplit_once('.')?.1;
        Self::ALL.iter().copied().find(|format| format.entry().endings.contains(&ending))
    }
}

impl MatrixFormat {
    /// Finds the format from the first lines of a file, if its name does not show it.
    pub fn of_content(path: &Path) -> Option<Self> {
        const LOOKED_AT: u64 = 10_000;
        let mut bytes = Vec::new();
        File::open(path).ok()?.take(LOOKED_AT).read_to_end(&mut bytes).ok()?;
        let mut plain = Vec::new();
        // A packed file ends within a block here: use the bytes before.
        let _ = unpacked(&bytes).take(LOOKED_AT).read_to_end(&mut plain);
        if plain.starts_with(b"PK\x03\x04") {
            return Some(Self::Npz);
        }
        let text = String::from_utf8_lossy(&plain).to_ascii_uppercase();
        if text.trim_start_matches('\u{feff}').starts_with("%%MATRIXMARKET") {
            return Some(Self::MatrixMarket);
        }
        let begins =
            |words: &[&str]| text.lines().any(|line| words.iter().any(|word| line.trim_start().starts_with(word)));
        if begins(&["DMIG,", "DMIG ", "DMIG*", "DMIG\t"]) {
            return Some(Self::Dmig);
        }
        begins(&["*MATRIX", "*USER ELEMENT"]).then_some(Self::Abaqus)
    }

    /// Advice for a readable file from a program whose own files cannot be read; `None` for an unknown ending.
    pub fn way_out(file: &str) -> Option<&'static str> {
        let name = file.to_ascii_lowercase();
        let ending = name.strip_suffix(".gz").unwrap_or(&name).rsplit_once('.')?.1;
        Some(match ending {
            "full" | "rst" | "rstp" | "rth" | "sub" | "emat" | "cdb" | "cms" => {
                "ANSYS: write the .full file with `HBMAT` (stiffness and mass, with a mapping file), or with APDL Math: `*SMAT,K,D,IMPORT,FULL,file.full,STIFF` and `*EXPORT,K,MMF,K.mtx`"
            }
            "odb" | "sim" | "prt" | "fil" | "cae" => {
                "Abaqus: add a step with `*MATRIX GENERATE, STIFFNESS, MASS` and `*MATRIX OUTPUT, STIFFNESS, MASS, FORMAT=MATRIX INPUT`"
            }
            "inp" => {
                "a deck contains no matrices; Abaqus: run it with a step of `*MATRIX GENERATE, STIFFNESS, MASS` and \
                 `*MATRIX OUTPUT, STIFFNESS, MASS, FORMAT=MATRIX INPUT`; CalculiX: with `*FREQUENCY, \
                 SOLVER=MATRIXSTORAGE`, which writes .sti, .mas and .dof"
            }
            "op2" | "xdb" | "f06" | "h5" | "hdf5" | "hdf" | "nas" => {
                "Nastran and OptiStruct: `EXTSEOUT(STIFF,MASS,DMIGPCH)` writes a .pch, `EXTSEOUT(STIFF,MASS,DMIGOP4)` an OUTPUT4 file; of a file of Python or MATLAB read K with `h5py` and write it with `scipy.sparse.save_npz('K.npz', K)`"
            }
            "mnf" | "fbi" | "sid_fem" | "rfi" => {
                "flexible bodies of multibody programs: take stiffness and mass from the finite element program that made the body, or its normal modes as a `modal_file`"
            }
            "k" | "key" => "LS-DYNA: `MTXDMP` of *CONTROL_IMPLICIT_SOLVER writes the matrices in Harwell-Boeing format",
            "unv" | "uff" => {
                "a universal file contains no matrices: its modes (data sets 55) are a `modal_file` of `source = \
                 \"modal_table\"`, its responses (58) go to `--measured`"
            }
            "med" | "rmed" | "mess" => {
                "Code_Aster: in Python `K.EXTR_MATR(sparse=True)`, then `scipy.io.mmwrite('K.mtx', ...)`"
            }
            "npy" | "mat" | "pkl" => {
                "Python: `scipy.sparse.save_npz('K.npz', scipy.sparse.csr_matrix(K))`, of an array with K from `numpy.load`, of MATLAB from `scipy.io.loadmat`"
            }
            "frd" | "dat" | "sta" => "CalculiX: `*FREQUENCY, SOLVER=MATRIXSTORAGE` writes .sti, .mas and .dof",
            "petsc" | "bin" => {
                "PETSc: `-ksp_view_mat ascii:K.mtx:ascii_matrixmarket`, or `MatView` with PETSC_VIEWER_ASCII_MATRIXMARKET"
            }
            _ => return None,
        })
    }

    /// Names of all formats with the ends of files that stand for them.
    pub fn names() -> String {
        let name = |format: &Self| {
            let endings: Vec<String> = format.entry().endings.iter().map(|ending| format!(".{ending}")).collect();
            let name = serde_json::to_value(format).ok().and_then(|name| Some(name.as_str()?.to_owned()));
            let name = name.unwrap_or_default();
            if endings.is_empty() { name } else { format!("{name} ({})", endings.join(", ")) }
        };
        Self::ALL.iter().map(name).collect::<Vec<_>>().join(", ")
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

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        self.form.name
    }

    /// Names of the files that are written in it: stiffness, mass, damping where the model has some, rows where they are labelled,
    /// points.
    pub fn files(self) -> [&'static str; 5] {
        let [stiffness, mass, damping] = self.form.files;
        [stiffness, mass, damping, ROWS_FILE, POINTS_FILE]
    }

    /// Loss of information, for the user; `None` if every bit is kept.
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

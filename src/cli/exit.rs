//! Exit codes and the errors behind them.

use std::fs::File;
use std::io::ErrorKind;
use std::path::Path;
use std::process::ExitCode;

use crate::page::PageError;
use crate::paper::PaperError;
use crate::plot::PlotError;
use decore_dataset::DatasetError;
use decore_files::Staged;
use decore_lab::best::BestError;
use decore_lab::comparison::ComparisonError;
use decore_lab::cores::CoresError;
use decore_lab::features::FeaturesError;
use decore_lab::refinement::RefinementError;
use decore_lab::sensitivity::SensitivityError;
use decore_lab::surrogate::SurrogateError;
use decore_model::run::{BatchError, ThreadCountError};
use decore_model::structure::StructureError;
use decore_study::StudyError;
use decore_study::engine::EngineError;

/// End of a command; the numbers are part of the interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exit {
    /// All rows are done.
    Done = 0,
    /// The command line, the study or the machine is wrong.
    BadInput = 2,
    /// Results could not be written.
    NotWritten = 3,
    /// Finished, but some rows are not done, no row of a checked study can run, or intervals are not as narrow as asked for.
    RowsFailed = 4,
    /// Interrupted; the same command goes on.
    Interrupted = 5,
    /// Stopped because more rows failed than were allowed.
    TooManyFailed = 6,
    /// Another process writes to the dataset, or changed it while it was read.
    InUse = 7,
    /// A dataset that was verified or read is not whole.
    NotWhole = 8,
    /// Two datasets that were compared differ.
    Differ = 9,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        ExitCode::from(exit as u8)
    }
}

/// Error of a command.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error("{0}")]
    Study(#[from] StudyError),
    #[error("{error}{advice}", error = .0, advice = advice(.0))]
    Engine(#[from] EngineError),
    #[error("failed to prepare the machine: {0}")]
    Structure(#[from] StructureError),
    #[error("{0}")]
    Dataset(#[from] DatasetError),
    #[error("{0}")]
    Sensitivity(SensitivityError),
    #[error("{0}")]
    Surrogate(SurrogateError),
    #[error("{0}")]
    Features(FeaturesError),
    #[error("{0}")]
    Refinement(RefinementError),
    #[error("{0}")]
    Best(BestError),
    #[error("{0}")]
    Cores(CoresError),
    #[error("{0}")]
    Page(PageError),
    #[error("{0}")]
    Paper(#[from] PaperError),
    #[error("{0}")]
    Comparison(ComparisonError),
    #[error("{0}")]
    Plot(#[from] PlotError),
    #[error("{0}")]
    Threads(#[from] ThreadCountError),
    #[error("{0}")]
    Argument(String),
    #[error("{}", not_written(path, source))]
    Write { path: String, source: std::io::Error },
    #[error("failed to write to standard output: {0} (the printed text is incomplete)")]
    Print(std::io::Error),
}

/// Advice for an error of the library.
fn advice(error: &EngineError) -> &'static str {
    match error {
        EngineError::Dataset(DatasetError::Exists { .. } | DatasetError::Changed { .. }) => {
            " (`--output` names another folder, `--replace` replaces)"
        }
        _ => "",
    }
}

impl Failure {
    /// The exit code that stands for it.
    pub fn exit(&self) -> Exit {
        match self {
            Self::Dataset(error) | Self::Engine(EngineError::Dataset(error)) => match error {
                DatasetError::InUse { .. } | DatasetError::Replaced { .. } => Exit::InUse,
                error if error.is_damage() => Exit::NotWhole,
                error if error.is_usage() => Exit::BadInput,
                _ => Exit::NotWritten,
            },
            Self::Engine(EngineError::Batch(BatchError::Sink { .. })) | Self::Write { .. } => Exit::NotWritten,
            Self::Features(FeaturesError::Write { .. } | FeaturesError::Parquet(_)) => Exit::NotWritten,
            Self::Page(_) | Self::Plot(_) | Self::Print(_) | Self::Surrogate(SurrogateError::Write { .. }) => {
                Exit::NotWritten
            }
            Self::Study(_) | Self::Engine(_) | Self::Structure(_) => Exit::BadInput,
            Self::Sensitivity(_) | Self::Comparison(_) | Self::Surrogate(_) => Exit::BadInput,
            Self::Features(_)
            | Self::Refinement(_)
            | Self::Best(_)
            | Self::Cores(_)
            | Self::Paper(_)
            | Self::Threads(_)
            | Self::Argument(_) => Exit::BadInput,
        }
    }
}

impl From<SensitivityError> for Failure {
    fn from(error: SensitivityError) -> Self {
        match error {
            SensitivityError::Dataset(error) => Self::Dataset(error),
            other => Self::Sensitivity(other),
        }
    }
}

impl From<BestError> for Failure {
    fn from(error: BestError) -> Self {
        match error {
            BestError::Dataset(error) => Self::Dataset(error),
            BestError::Study(error) => Self::Study(error),
            BestError::Surrogate(error) => error.into(),
            other => Self::Best(other),
        }
    }
}

impl From<CoresError> for Failure {
    fn from(error: CoresError) -> Self {
        match error {
            CoresError::Dataset(error) => Self::Dataset(error),
            other => Self::Cores(other),
        }
    }
}

impl From<SurrogateError> for Failure {
    fn from(error: SurrogateError) -> Self {
        match error {
            SurrogateError::Dataset(error) => Self::Dataset(error),
            other => Self::Surrogate(other),
        }
    }
}

impl From<FeaturesError> for Failure {
    fn from(error: FeaturesError) -> Self {
        match error {
            FeaturesError::Dataset(error) => Self::Dataset(error),
            other => Self::Features(other),
        }
    }
}

impl From<RefinementError> for Failure {
    fn from(error: RefinementError) -> Self {
        match error {
            RefinementError::Surrogate(error) => error.into(),
            other => Self::Refinement(other),
        }
    }
}

impl From<ComparisonError> for Failure {
    fn from(error: ComparisonError) -> Self {
        match error {
            ComparisonError::Dataset(error) => Self::Dataset(error),
            other => Self::Comparison(other),
        }
    }
}

impl From<PageError> for Failure {
    fn from(error: PageError) -> Self {
        match error {
            PageError::Dataset(error) => Self::Dataset(error),
            other => Self::Page(other),
        }
    }
}

/// Names the file that cannot be written, the reason, and what to do.
fn not_written(path: &str, source: &std::io::Error) -> String {
    let folder = Path::new(path).parent().filter(|folder| !folder.as_os_str().is_empty());
    let (reason, advice) = match (source.kind(), folder) {
        (ErrorKind::NotFound, Some(folder)) if !folder.exists() => (
            format!("the folder {} does not exist", folder.display()),
            format!("make the folder {} first, or give another one", folder.display()),
        ),
        (ErrorKind::IsADirectory, _) => ("it is a folder".to_owned(), "give the name of a file".to_owned()),
        (ErrorKind::NotADirectory, _) => {
            ("a part of this path is a file, where a folder is needed".to_owned(), "give another place".to_owned())
        }
        (ErrorKind::PermissionDenied, _) => {
            (source.to_string(), "give another folder, or change the permissions".to_owned())
        }
        (ErrorKind::StorageFull | ErrorKind::QuotaExceeded, _) => {
            (source.to_string(), "check free space, or give another folder".to_owned())
        }
        _ => (source.to_string(), "check free space and permissions".to_owned()),
    };
    format!("failed to write {path}: {reason}; {advice}")
}

/// Writes a file that is either whole or as it was before.
pub(super) fn write_file(path: &Path, content: impl AsRef<[u8]>) -> Result<(), Failure> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    Staged::write(folder, path, content.as_ref())
        .and_then(Staged::put_in_place)
        .map_err(|source| Failure::Write { path: path.display().to_string(), source: without_path(source) })
}

/// Writes a file as [`write_file`] does and syncs it to disk. Use it for a file that the next step depends on.
pub(super) fn write_durable_file(path: &Path, content: impl AsRef<[u8]>) -> Result<(), Failure> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let write = || {
        let staged = Staged::write(folder, path, content.as_ref())?;
        staged.sync()?;
        staged.put_in_place()?;
        // Elsewhere folders cannot be opened as files.
        if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) }
    };
    write().map_err(|source| Failure::Write { path: path.display().to_string(), source: without_path(source) })
}

/// Checks that a file can be created in a folder, for the output at `path`. The created file is removed.
pub(super) fn check_writable(folder: &Path, path: &Path) -> Result<(), Failure> {
    // Of a name that any file system takes, whatever that of the output.
    Staged::write(folder, Path::new("decore"), b"")
        .map(drop)
        .map_err(|source| Failure::Write { path: path.display().to_string(), source: without_path(source) })
}

/// An error of the system without the temporary name of the file.
fn without_path(error: std::io::Error) -> std::io::Error {
    if error.raw_os_error().is_some() { error } else { error.kind().into() }
}

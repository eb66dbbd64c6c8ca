//! Reads the study of a command and checks its outputs: no command overwrites its inputs, the files of a dataset or, without `--replace`,
//! an existing file. A command that cannot write its outputs fails before it starts to work.

use std::fs::{self, File};
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

use super::exit::{Failure, check_writable};
use super::inputs::{expect_ending, expect_study, is_dataset};
use super::text::eprint_line;
use decore_dataset::{SweepStatus, check_free, is_part_of, own_files, place};
use decore_study::engine::{Engine, RowRunner, checked};
use decore_study::{CheckedStudy, FactorInfo, Study};

/// A file or folder for the results of a command.
#[derive(Debug, Clone, Copy)]
pub(super) struct Output<'a> {
    /// Option or argument of the command line.
    pub flag: &'static str,
    /// Path; `None` if the option was not given.
    pub path: Option<&'a Path>,
    /// Kind of output.
    pub form: Form<'a>,
}

/// Kind of an output, and which existing files it may replace.
#[derive(Debug, Clone, Copy)]
pub(super) enum Form<'a> {
    /// A file in an existing folder. Its name ends in one of `endings`, if there are any. It takes the place of an existing file only if
    /// `replace` is set.
    File { endings: &'a [&'static str], replace: bool },
    /// The status of a sweep in a folder that the sweep may create. It takes the place of an earlier status, but of no other file: the
    /// same command continues a sweep.
    Status,
    /// A file with this text under a fixed name. It takes the place only of a file that decore wrote.
    Companion(&'a str),
    /// A folder, created if it does not exist, for files with these names. They take the place of existing files only if `replace` is
    /// set. No names: decore writes its own files into the folder and replaces them.
    Folder { names: &'a [&'a str], replace: bool },
    /// The folder of a dataset, which its writer checks.
    Dataset,
}

/// The study that a command line names. Each way to take it looks at the command line before it reads, reads before it
/// reduces, and tells what looks wrong: a command has one call to make and no order to keep.
#[derive(Debug, Clone, Copy)]
pub(super) struct StudyArguments<'a> {
    /// The study's file.
    pub file: &'a Path,
    /// Settings `path=value` over its own.
    pub overrides: &'a [String],
    /// Outputs of the command.
    pub outputs: &'a [Output<'a>],
}

impl StudyArguments<'_> {
    /// The study ready to run.
    ///
    /// # Errors
    /// As for [`Self::study`]; errors of [`Engine::new`].
    pub fn engine(&self) -> Result<Engine, Failure> {
        ready(self.study()?)
    }

    /// Another study in place of the file's, that of a dataset, with the same settings and outputs, ready to run.
    ///
    /// # Errors
    /// As for [`Self::engine`].
    pub fn engine_of(&self, study: Study) -> Result<Engine, Failure> {
        ready(self.set(study)?)
    }

    /// The study held to its machine, which is not reduced: rows to look at, not to run.
    ///
    /// # Errors
    /// As for [`Self::study`]; errors of the files of its machine.
    pub fn checked(&self) -> Result<CheckedStudy, Failure> {
        let checked = checked(self.study()?)?;
        warn(&checked);
        Ok(checked)
    }

    /// The study by itself.
    ///
    /// # Errors
    /// A path that cannot be a study, a study with faults; outputs that [`check_outputs`] refuses.
    pub fn study(&self) -> Result<Study, Failure> {
        expect_study(self.file)?;
        self.set(Study::load(self.file)?)
    }

    fn set(&self, study: Study) -> Result<Study, Failure> {
        let study = study.with_overrides(self.overrides)?;
        let mut inputs = study.files();
        inputs.extend(is_dataset(self.file).then(|| self.file.to_owned()));
        check_outputs(&inputs, self.outputs)?;
        Ok(study)
    }
}

/// Prepares a study to run, and prints notes and warnings.
fn ready(study: Study) -> Result<Engine, Failure> {
    let engine = Engine::new(study)?;
    engine.notes().for_each(|note| eprint_line(&format_args!("note: {note}")));
    warn(engine.checked());
    Ok(engine)
}

/// Prints the warnings of a study, and the units that are converted.
fn warn(study: &CheckedStudy) {
    let conversions = study.study().factors().iter().flat_map(FactorInfo::conversions);
    conversions.for_each(|conversion| eprint_line(&format_args!("note: {conversion}")));
    study.warnings().iter().for_each(|warning| eprint_line(&format_args!("warning: {warning}")));
}

/// Refuses what a command was asked to write where it would destroy something or could not be written. `inputs`: files that the
/// command reads, and folders of datasets. All commands that write what the command line names call this before they work.
///
/// # Errors
/// [`Failure::Argument`] for a file of another kind than its name says, for one that is an input by whatever path or link, lies
/// where a dataset keeps its own, or stands in the place of a companion or of a folder's file; [`Failure::Write`].
pub(super) fn check_outputs(inputs: &[PathBuf], outputs: &[Output<'_>]) -> Result<(), Failure> {
    let asked = || outputs.iter().filter_map(|output| Some((output.path?, output)));
    refuse_inputs(inputs, asked().map(|(path, output)| (path, output.form)))?;
    // What this command is about to make a dataset is none yet.
    let coming = asked().filter(|(_, output)| matches!(output.form, Form::Dataset)).map(|(path, _)| place(path));
    let coming: Vec<PathBuf> = coming.collect();
    for (path, Output { flag, form, .. }) in asked() {
        match form {
            Form::File { endings, .. } if !endings.is_empty() => expect_ending(flag, path, endings)?,
            Form::Status => expect_ending(flag, path, &["json"])?,
            Form::Companion(text) => expect_own(flag, path, text)?,
            _ => {}
        }
        check_free(path, &coming).map_err(|error| Failure::Argument(format!("{flag} {error}")))?;
        match form {
            Form::File { replace, .. } => expect_free(flag, path, *replace)?,
            Form::Status if path.symlink_metadata().is_ok() && !is_status(path) => {
                let shown = path.display();
                let message = format!("{shown} exists and is not the status of a sweep: choose another name ({flag})");
                return Err(Failure::Argument(message));
            }
            Form::Folder { names, replace } => {
                names.iter().try_for_each(|name| expect_free(flag, &path.join(name), *replace))?;
            }
            _ => {}
        }
    }
    asked().try_for_each(|(path, output)| match output.form {
        Form::File { .. } | Form::Companion(_) => check_writable(folder_of(path), path),
        Form::Status => check_writable(nearest(folder_of(path)), path),
        Form::Folder { .. } => check_writable(nearest(path), path),
        Form::Dataset => Ok(()),
    })
}

/// Refuses outputs that are one of the inputs. A folder must hold none under a name that is written; a dataset must not consist of
/// any.
fn refuse_inputs<'a>(
    inputs: &[PathBuf],
    outputs: impl Iterator<Item = (&'a Path, Form<'a>)> + Clone,
) -> Result<(), Failure> {
    let files = outputs.clone().flat_map(|(path, form)| match form {
        Form::Folder { names, .. } => names.iter().map(|name| path.join(name)).collect(),
        Form::Dataset => Vec::new(),
        _ => vec![path.to_owned()],
    });
    // What is not there yet is no input.
    let written: Vec<(PathBuf, Identity)> =
        files.filter_map(|path| identity(&path).map(|found| (path, found))).collect();
    let folders: Vec<(&Path, PathBuf, bool)> = outputs
        .filter_map(|(path, form)| match form {
            Form::Folder { names: [], .. } => Some((path, place(path), false)),
            Form::Dataset => Some((path, place(path), true)),
            _ => None,
        })
        .collect();
    if written.is_empty() && folders.is_empty() {
        return Ok(());
    }
    let refused = |output: &Path, input: &Path| {
        Err(Failure::Argument(format!(
            "the output {} would overwrite what the command reads ({}): give another name or folder",
            output.display(),
            input.display()
        )))
    };
    let all = inputs.iter().flat_map(|input| if input.is_dir() { own_files(input) } else { vec![input.clone()] });
    for input in all {
        // Nor is an input that is not there.
        let Some(found) = identity(&input) else { continue };
        if let Some((output, _)) = written.iter().find(|(_, one)| *one == found) {
            return refused(output, &input);
        }
        let input_place = place(&input);
        let holds = |(_, folder, is_dataset): &&(&Path, PathBuf, bool)| match is_dataset {
            true => is_part_of(&input_place, folder),
            false => input_place.parent().is_some_and(|parent| parent == folder),
        };
        if let Some((output, ..)) = folders.iter().find(holds) {
            return refused(output, &input);
        }
    }
    Ok(())
}

/// Refuses an existing file, unless it may be replaced, and a folder under the name of a file.
fn expect_free(flag: &str, path: &Path, replace: bool) -> Result<(), Failure> {
    let path_shown = path.display();
    if path.is_dir() {
        return Err(Failure::Argument(format!("{flag}: {path_shown} is a folder: give the name of a file")));
    }
    match replace || path.symlink_metadata().is_err() {
        true => Ok(()),
        false => Err(exists(flag, path)),
    }
}

/// Error for an existing file that was not to be replaced.
pub(super) fn exists(flag: &str, path: &Path) -> Failure {
    Failure::Argument(format!(
        "{} exists and was not changed: choose another name ({flag}), or add `--replace` to replace it",
        path.display()
    ))
}

/// Whether a file is the status of a sweep.
fn is_status(path: &Path) -> bool {
    fs::read(path).is_ok_and(|bytes| serde_json::from_slice::<SweepStatus>(&bytes).is_ok())
}

/// Refuses a companion if another file has its name, unless that file begins like the companion.
fn expect_own(flag: &str, path: &Path, text: &str) -> Result<(), Failure> {
    match fs::metadata(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
        Ok(found) if found.is_file() && begins_with(path, text.lines().next().unwrap_or_default()) => return Ok(()),
        _ => {}
    }
    Err(Failure::Argument(format!(
        "{flag}: {} is to be written too, and what is there was not written by decore: rename it, or give another folder",
        path.display()
    )))
}

fn begins_with(path: &Path, line: &str) -> bool {
    let mut begin = Vec::new();
    let read = File::open(path).and_then(|file| file.take(line.len() as u64).read_to_end(&mut begin));
    read.is_ok() && begin == line.as_bytes()
}

/// The folder that a file is in.
fn folder_of(file: &Path) -> &Path {
    file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// The folder itself, or the last one above it that is there.
fn nearest(folder: &Path) -> &Path {
    let found = folder.ancestors().find(|above| above.exists());
    found.unwrap_or(Path::new("."))
}

/// Identity of a file, the same for all its paths and links; `None`: there is no file.
#[cfg(unix)]
fn identity(path: &Path) -> Option<Identity> {
    use std::os::unix::fs::MetadataExt;
    fs::metadata(path).ok().map(|found| (found.dev(), found.ino()))
}
#[cfg(unix)]
type Identity = (u64, u64);

/// Hard links are not seen through here.
#[cfg(not(unix))]
fn identity(path: &Path) -> Option<Identity> {
    path.canonicalize().ok()
}
#[cfg(not(unix))]
type Identity = PathBuf;

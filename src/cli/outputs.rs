//! The study of a command, and its outputs: a command overwrites neither what it reads nor what a dataset consists of, and knows
//! before it works that it can write.

use std::fs::{self, File};
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

use super::exit::{Failure, check_writable};
use super::inputs::{expect_ending, expect_study, is_dataset};
use super::text::eprint_line;
use decore_dataset::{check_free, is_part_of, own_files, place};
use decore_study::engine::{Engine, RowRunner, checked};
use decore_study::{CheckedStudy, FactorInfo, Study};

/// A file or folder that a command was asked to write.
#[derive(Debug, Clone, Copy)]
pub(super) struct Output<'a> {
    /// What names it on the command line.
    pub flag: &'static str,
    /// Where; `None`: it was not asked for.
    pub path: Option<&'a Path>,
    /// What is written there.
    pub form: Form<'a>,
}

/// What an output is.
#[derive(Debug, Clone, Copy)]
pub(super) enum Form<'a> {
    /// A file in a folder that is there. Its name ends in one of these; empty: as it likes.
    File(&'a [&'static str]),
    /// The same in a folder that may be made while the command works.
    LateFile(&'a [&'static str]),
    /// A file of this text under a name that nobody gave: it takes the place only of one that the program wrote.
    Companion(&'a str),
    /// A folder, made where it is not there, for files under names that nobody gave: they take the place of none that is there,
    /// unless they are to. No names: those that the program alone gives to what is in a folder of that name.
    Folder { names: &'a [&'a str], replace: bool },
    /// The folder of a dataset, whose writer has more to say about it.
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
    /// What the command writes.
    pub outputs: &'a [Output<'a>],
}

impl StudyArguments<'_> {
    /// The study ready to run.
    ///
    /// # Errors
    /// As for [`Self::study`]; what [`Engine::new`] finds wrong.
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
    /// As for [`Self::study`]; what is wrong with the files of its machine.
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

/// A study made ready to run, with a word about what was not as expected.
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
            Form::File(endings) | Form::LateFile(endings) if !endings.is_empty() => expect_ending(flag, path, endings)?,
            Form::Companion(text) => expect_own(flag, path, text)?,
            Form::Folder { names, replace: false } => expect_free(flag, path, names)?,
            _ => {}
        }
        check_free(path, &coming).map_err(|error| Failure::Argument(format!("{flag} {error}")))?;
    }
    asked().try_for_each(|(path, output)| match output.form {
        Form::File(_) | Form::Companion(_) => check_writable(folder_of(path), path),
        Form::LateFile(_) => check_writable(nearest(folder_of(path)), path),
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

/// Refuses a folder that holds one of the files that are to be written.
fn expect_free(flag: &str, folder: &Path, names: &[&str]) -> Result<(), Failure> {
    let Some(taken) = names.iter().map(|name| folder.join(name)).find(|path| path.symlink_metadata().is_ok()) else {
        return Ok(());
    };
    Err(Failure::Argument(format!(
        "{flag}: {} is there already: give another folder, or --replace to write over it",
        taken.display()
    )))
}

/// Refuses a companion whose place is taken by a file that does not begin as what the program writes there.
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

/// What tells a file from all others, whatever path or link names it; `None`: there is none.
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

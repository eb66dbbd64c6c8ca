//! Exports a dataset to a folder with the table and its descriptions.

use std::path::{Path, PathBuf};

use parquet::errors::ParquetError;

use super::card::card;
use super::croissant::{Described, croissant};
use super::dictionary::Dictionary;
use super::error::FeaturesError;
use super::file::columns_csv;
use super::settings::{FeatureSettings, Format};
use super::table::{Features, features};
use decore_dataset::{DatasetReader, table_bytes};
use decore_files::Staged;

/// Result of an export.
#[derive(Debug, Clone, PartialEq)]
pub struct Exported {
    /// The table.
    pub features: Features,
    /// The files, the table first.
    pub files: Vec<PathBuf>,
}

/// Names of the files that an export writes, the table first.
pub fn files(format: Format) -> [&'static str; 5] {
    [format.file(), "dictionary.json", "dictionary.csv", "croissant.json", "README.md"]
}

/// Writes the table of a dataset, its dictionary, Croissant metadata and a card into `folder`, which is made if it is not there. Files
/// appear whole, and none
/// before all could be written.
///
/// # Errors
/// As [`features`]; [`FeaturesError::Exists`] unless they are to be replaced, [`FeaturesError::Write`].
pub fn export(reader: &DatasetReader, folder: &Path, settings: &FeatureSettings) -> Result<Exported, FeaturesError> {
    let paths = files(settings.format).map(|name| folder.join(name));
    if let (false, Some(path)) = (settings.replace, paths.iter().find(|path| path.exists())) {
        return Err(FeaturesError::Exists { path: path.clone() });
    }
    let features = features(reader, settings)?;
    let dictionary = Dictionary::of(settings.format.file(), &features.columns);
    let table = match settings.format {
        Format::Parquet => {
            let fields: Result<Vec<_>, _> = features.columns.iter().map(|column| column.field()).collect();
            table_bytes(&reader.manifest().study, dictionary.json(), fields.map_err(ParquetError::from)?)?
        }
        Format::Csv => columns_csv(&features.columns)?,
    };
    let mut contents = vec![table, dictionary.json().into_bytes(), dictionary.csv()?];
    let described: Vec<Described> =
        files(settings.format).iter().zip(&contents).map(|(name, bytes)| Described::of(name, bytes)).collect();
    let manifest = reader.manifest();
    contents.push(croissant(manifest, &features.columns, &described).into_bytes());
    contents.push(card(manifest, (&features, settings), &described).into_bytes());
    write(folder, paths.iter().zip(&contents))?;
    Ok(Exported { features, files: paths.to_vec() })
}

/// Writes all files under passing names, then puts them in place.
fn write<'a>(folder: &Path, contents: impl Iterator<Item = (&'a PathBuf, &'a Vec<u8>)>) -> Result<(), FeaturesError> {
    let fault = |path: &Path| {
        let path = path.to_owned();
        move |source| FeaturesError::Write { path, source }
    };
    std::fs::create_dir_all(folder).map_err(fault(folder))?;
    let mut staged = Vec::new();
    for (path, bytes) in contents {
        staged.push(Staged::write(folder, path, bytes).map_err(fault(path))?);
    }
    staged.into_iter().try_for_each(|file| {
        let path = file.target().to_owned();
        file.put_in_place().map_err(fault(&path))
    })
}

//! Cache of reductions next to their source.
//!
//! A reduction depends on the bytes of its files and on the settings. The name of the cache file contains a hash of the settings and the
//! program's version; its folder `.decore-cache` is next to the stiffness file. Its header contains a hash of the files. Changed files
//! make it stale, a wrong checksum damaged; both are computed again, and [`CacheOutcome::note`] reports it. If the cache cannot be
//! written, there is no error.

use std::borrow::Cow;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use super::error::StructureError;
use super::import::ModelFiles;
use super::model::FeModel;
use super::points::{Interface, InterfaceDof, InterfacePoints};
use super::reduced::{ReducedMatrices, ReducedStructure};
use super::reduction::{ReductionSettings, reduce};
use decore_files::{Limit, Staged, read};

/// Folder of the caches.
pub const CACHE_FOLDER: &str = ".decore-cache";
/// First bytes of a cache file; the number changes with its layout.
const MAGIC: &[u8; 16] = b"decore-reduced-6";
const HASH: usize = 32;

/// Origin of a reduction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum CacheOutcome {
    /// Computed; no cache was wanted.
    Off,
    /// Read from the cache.
    Used,
    /// Computed, as there was no cache, and stored.
    Stored,
    /// Computed and stored, as the cache was made from other files.
    Stale,
    /// Computed and stored, as the cache was damaged, could not be read, or was no cache at all.
    Damaged,
    /// Computed, but not stored, for this reason.
    NotStored(String),
}

impl CacheOutcome {
    /// Note for the user in one line; `path`: the file of the cache, see [`cache_path`].
    pub fn note(&self, path: &Path) -> Option<String> {
        let path = path.display();
        match self {
            Self::Off | Self::Used | Self::Stored => None,
            Self::Stale => Some(format!("{path} belongs to other files: the machine was reduced again")),
            Self::Damaged => {
                Some(format!("{path} is damaged, or not a reduced machine: the machine was reduced again"))
            }
            Self::NotStored(reason) => {
                Some(format!("the reduced machine could not be kept for the next run: {reason}"))
            }
        }
    }
}

/// The reduction of the model in these files, from the cache where it holds one.
///
/// # Errors
/// As for [`FeModel::read`] and [`reduce`].
pub fn reduce_files(
    files: &ModelFiles,
    settings: &ReductionSettings,
    cache: bool,
) -> Result<(ReducedStructure, CacheOutcome), StructureError> {
    if !cache {
        return Ok((reduce(&FeModel::read(files)?, settings)?, CacheOutcome::Off));
    }
    let content = content_hash(files)?;
    let path = cache_path(files, settings);
    let state = match read(&path, Limit::REDUCED).map(|bytes| from_bytes(&bytes)) {
        Err(error) if error.kind() == ErrorKind::NotFound => CacheOutcome::Stored,
        Ok(Some((made_from, _))) if made_from != content => CacheOutcome::Stale,
        Ok(Some((_, kept))) => match kept.into_structure(InterfacePoints::read(&files.points)?) {
            Some(structure) => return Ok((structure, CacheOutcome::Used)),
            None => CacheOutcome::Damaged,
        },
        Ok(None) | Err(_) => CacheOutcome::Damaged,
    };
    let structure = reduce(&FeModel::read(files)?, settings)?;
    // The files may have changed while they were read: then nothing is stored.
    if content_hash(files)? != content {
        return Ok((structure, CacheOutcome::NotStored("the files changed while they were read".to_owned())));
    }
    let outcome = match store(&path, &content, &structure) {
        Ok(()) => state,
        Err(error) => CacheOutcome::NotStored(format!("{}: {error}", path.display())),
    };
    Ok((structure, outcome))
}

/// The cache file of a reduction.
pub fn cache_path(files: &ModelFiles, settings: &ReductionSettings) -> PathBuf {
    let mut hasher = blake3::Hasher::new();
    hasher.update(MAGIC);
    hasher.update(env!("CARGO_PKG_VERSION").as_bytes());
    let names = [Some(&files.stiffness), Some(&files.mass), files.damping.as_ref()];
    let names = names.map(|file| file.map(|file| file.name.as_str()));
    let words = format!("{:?} {:?} {:?} {names:?} {settings:?}", files.format, files.units, files.dofs_per_node);
    hasher.update(words.as_bytes());
    let folder = files.stiffness.path.parent().unwrap_or(Path::new("")).join(CACHE_FOLDER);
    let stem = files.stiffness.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    folder.join(format!("{stem}-{}.reduced", &hasher.finalize().to_hex()[..16]))
}

/// Hash of the bytes of all files.
fn content_hash(files: &ModelFiles) -> Result<[u8; HASH], StructureError> {
    let matrices = [Some(&files.stiffness), Some(&files.mass), files.damping.as_ref()];
    let paths = matrices
        .into_iter()
        .flatten()
        .map(|file| &file.path)
        .chain(&files.dofs)
        .chain(&files.nodes)
        .chain([&files.points]);
    let mut all = blake3::Hasher::new();
    for path in paths {
        let fault = |error: std::io::Error| StructureError::Read {
            file: path.display().to_string(),
            reason: error.to_string(),
        };
        let mut hasher = blake3::Hasher::new();
        hasher.update_reader(fs::File::open(path).map_err(fault)?).map_err(fault)?;
        all.update(hasher.finalize().as_bytes());
    }
    Ok(*all.finalize().as_bytes())
}

/// Contents of a cache, in the format of postcard; matrices column by column.
#[derive(Serialize, Deserialize)]
struct CachedReduction<'a> {
    /// Reduced coordinates, and rows of the interface displacement.
    n_z: usize,
    n_b: usize,
    m_zz: Cow<'a, [f64]>,
    k_zz: Cow<'a, [f64]>,
    d_zz: Option<Cow<'a, [f64]>>,
    transfer: Cow<'a, [f64]>,
    /// The interface DOFs with their rows.
    dofs: Vec<(InterfaceDof, usize)>,
    remarks: Cow<'a, [String]>,
}

impl<'a> CachedReduction<'a> {
    fn of(structure: &'a ReducedStructure) -> Self {
        let values = |matrix: &'a DMatrix<f64>| Cow::Borrowed(matrix.as_slice());
        Self {
            n_z: structure.m_zz().nrows(),
            n_b: structure.transfer().nrows(),
            m_zz: values(structure.m_zz()),
            k_zz: values(structure.k_zz()),
            d_zz: structure.d_zz().map(values),
            transfer: values(structure.transfer()),
            dofs: structure.interface().dofs(),
            remarks: Cow::Borrowed(structure.remarks()),
        }
    }

    /// The structure; `None` if its parts do not fit together or are not a reduction.
    fn into_structure(self, points: InterfacePoints) -> Option<ReducedStructure> {
        let Self { n_z, n_b, .. } = self;
        let matrix = |rows: usize, values: Cow<'_, [f64]>| {
            let fits = rows.checked_mul(n_z)? == values.len() && values.iter().all(|value| value.is_finite());
            fits.then(|| DMatrix::from_vec(rows, n_z, values.into_owned()))
        };
        let d_zz = match self.d_zz {
            Some(values) => Some(matrix(n_z, values)?),
            None => None,
        };
        let (m_zz, k_zz) = (matrix(n_z, self.m_zz)?, matrix(n_z, self.k_zz)?);
        let matrices = ReducedMatrices { m_zz, k_zz, d_zz, transfer: matrix(n_b, self.transfer)? };
        let known = self.dofs.iter().all(|(_, row)| *row < n_b);
        let interface = Interface::new(points, &self.dofs);
        let structure = known.then(|| ReducedStructure::new(matrices, interface).ok())??;
        Some(structure.with_remarks(self.remarks.into_owned()))
    }
}

/// Bytes of a cache file: [`MAGIC`], the hash of the content, the reduction, the hash of all.
fn to_bytes(content: &[u8; HASH], kept: &CachedReduction<'_>) -> postcard::Result<Vec<u8>> {
    let mut bytes = postcard::to_extend(kept, [MAGIC.as_slice(), content].concat())?;
    bytes.extend_from_slice(blake3::hash(&bytes).as_bytes());
    Ok(bytes)
}

/// Reads a cache file and the hash of its source. `None` if the bytes are not a complete cache.
fn from_bytes(bytes: &[u8]) -> Option<([u8; HASH], CachedReduction<'static>)> {
    let (sealed, checksum) = bytes.split_last_chunk::<HASH>()?;
    if checksum != blake3::hash(sealed).as_bytes() {
        return None;
    }
    let (content, body) = sealed.strip_prefix(MAGIC)?.split_first_chunk::<HASH>()?;
    match postcard::take_from_bytes(body) {
        Ok((kept, [])) => Some((*content, kept)),
        _ => None,
    }
}

fn store(path: &Path, content: &[u8; HASH], structure: &ReducedStructure) -> std::io::Result<()> {
    let bytes = to_bytes(content, &CachedReduction::of(structure)).map_err(std::io::Error::other)?;
    if bytes.len() as u64 > Limit::REDUCED.bytes {
        return Err(std::io::Error::other(format!("it would have {} MB", bytes.len() / 1_000_000)));
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    fs::create_dir_all(folder)?;
    let staged = Staged::write(folder, path, &bytes)?;
    staged.sync()?;
    staged.put_in_place()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(first: f64) -> Cow<'static, [f64]> {
        Cow::Owned(vec![first, 0.0, 0.0, 1.0])
    }

    /// A cache of two coordinates and one row.
    fn kept() -> CachedReduction<'static> {
        CachedReduction {
            n_z: 2,
            n_b: 1,
            m_zz: square(1.0),
            k_zz: square(2.0),
            d_zz: None,
            transfer: Cow::Owned(vec![1.0, 0.5]),
            dofs: vec![(InterfaceDof { point: "A".to_owned(), dof: 2 }, 0)],
            remarks: Cow::Owned(vec!["odd".to_owned()]),
        }
    }

    #[test]
    fn a_sound_seal_does_not_make_a_cache_that_fits() {
        let content = [7; HASH];
        let points = InterfacePoints::parse("p", "name,role,x_m,y_m,z_m\nA,mount,0,0,0\n").expect("valid");
        let read = |kept: &CachedReduction<'_>| {
            let bytes = to_bytes(&content, kept).expect("written");
            let (found, kept) = from_bytes(&bytes).expect("sealed");
            assert_eq!(found, content);
            kept.into_structure(points.clone())
        };
        let structure = read(&kept()).expect("fits");
        assert_eq!(
            (structure.k_zz()[(0, 0)], structure.transfer()[(0, 1)], structure.interface().len()),
            (2.0, 0.5, 1)
        );
        assert_eq!(structure.remarks(), ["odd"]);
        let row = |row: usize| vec![(InterfaceDof { point: "A".to_owned(), dof: 2 }, row)];
        // Sizes whose product overflows to 0 entries.
        let huge = 1 << (usize::BITS / 2);
        let none = || Cow::Owned(Vec::new());
        for other in [
            CachedReduction { n_z: 1, ..kept() },
            CachedReduction { n_b: 2, ..kept() },
            CachedReduction { k_zz: Cow::Owned(vec![1.0; 3]), ..kept() },
            CachedReduction { d_zz: Some(Cow::Owned(vec![1.0])), ..kept() },
            CachedReduction { m_zz: square(f64::NAN), ..kept() },
            CachedReduction { k_zz: square(-1e9), ..kept() },
            CachedReduction { dofs: row(1), ..kept() },
            CachedReduction { dofs: row(usize::MAX), ..kept() },
            CachedReduction {
                n_z: huge,
                n_b: huge,
                m_zz: none(),
                k_zz: none(),
                transfer: none(),
                dofs: vec![],
                ..kept()
            },
        ] {
            assert!(read(&other).is_none(), "{} x {}", other.n_b, other.n_z);
        }
    }

    #[test]
    fn no_changed_or_cut_file_is_a_cache() {
        let sound = to_bytes(&[7; HASH], &kept()).expect("written");
        assert!(from_bytes(&sound).is_some());
        for length in 0..sound.len() {
            assert!(from_bytes(&sound[..length]).is_none(), "{length} bytes");
        }
        for at in 0..sound.len() {
            let mut changed = sound.clone();
            changed[at] ^= 1;
            assert!(from_bytes(&changed).is_none(), "byte {at}");
        }
        assert!(from_bytes(&[sound.as_slice(), &[0]].concat()).is_none());
    }
}

//! Reductions kept beside their source.
//!
//! A reduction depends on the bytes of its files and on the settings. The settings (and this program's version) give the
//! name of the cache file in the folder `.decore-cache` beside the stiffness, the bytes a hash in its head: a change of the
//! files makes it stale, a wrong checksum damaged, and both are computed anew. A cache that cannot be written is no error.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use nalgebra::DMatrix;

use super::error::StructureError;
use super::import::ModelFiles;
use super::model::FeModel;
use super::points::{Interface, InterfaceDof, InterfacePoints};
use super::reduced::{ReducedMatrices, ReducedStructure};
use super::reduction::{ReductionSettings, reduce};

/// Folder of the caches.
pub const CACHE_FOLDER: &str = ".decore-cache";
/// First bytes of a cache file; the number changes with its layout.
const MAGIC: &[u8; 16] = b"decore-reduced-2";
const HASH: usize = 32;
/// Others who share the folder may read a cache, as far as the user's mask lets them.
#[cfg(unix)]
const READABLE: u32 = 0o666;

/// Where a reduction came from.
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
    /// Computed and stored, as the cache was damaged.
    Damaged,
    /// Computed, but not stored, for this reason.
    NotStored(String),
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
    let (kept, state) = match fs::read(&path) {
        Ok(bytes) => load(&bytes, &content),
        Err(_) => (None, CacheOutcome::Stored),
    };
    if let Some(stored) = kept {
        let interface = Interface::new(InterfacePoints::read(&files.points)?, &stored.dofs);
        return Ok((ReducedStructure::new(stored.matrices, interface)?, CacheOutcome::Used));
    }
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
    let paths = matrices.into_iter().flatten().map(|file| &file.path).chain(&files.dofs).chain([&files.points]);
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

struct Stored {
    matrices: ReducedMatrices,
    dofs: Vec<(InterfaceDof, usize)>,
}

/// MAGIC, hash of the content, hash of the body, body.
fn load(bytes: &[u8], content: &[u8; HASH]) -> (Option<Stored>, CacheOutcome) {
    let begin = MAGIC.len();
    let head = bytes.get(begin..begin + HASH).zip(bytes.get(begin + HASH..begin + 2 * HASH));
    let (Some((made_from, checksum)), true) = (head, bytes.starts_with(MAGIC)) else {
        return (None, CacheOutcome::Damaged);
    };
    if made_from != content {
        return (None, CacheOutcome::Stale);
    }
    let body = &bytes[begin + 2 * HASH..];
    if checksum != blake3::hash(body).as_bytes() {
        return (None, CacheOutcome::Damaged);
    }
    match decode(body) {
        Some(stored) => (Some(stored), CacheOutcome::Used),
        None => (None, CacheOutcome::Damaged),
    }
}

fn store(path: &Path, content: &[u8; HASH], structure: &ReducedStructure) -> std::io::Result<()> {
    let folder = path.parent().unwrap_or(Path::new(""));
    fs::create_dir_all(folder)?;
    let body = encode(structure);
    // Whole or not at all, also with several processes at it.
    let mut unfinished = tempfile::Builder::new();
    #[cfg(unix)]
    unfinished.permissions(std::os::unix::fs::PermissionsExt::from_mode(READABLE));
    let mut unfinished = unfinished.tempfile_in(folder)?;
    for part in [MAGIC.as_slice(), content, blake3::hash(&body).as_bytes(), &body] {
        unfinished.write_all(part)?;
    }
    unfinished.as_file().sync_all()?;
    unfinished.persist(path)?;
    Ok(())
}

fn encode(structure: &ReducedStructure) -> Vec<u8> {
    let mut out = Vec::new();
    let mut number = |value: usize| out.extend_from_slice(&(value as u64).to_le_bytes());
    let dofs = structure.interface().dofs();
    number(structure.m_zz().nrows());
    number(structure.interface().len());
    number(usize::from(structure.d_zz().is_some()));
    number(dofs.len());
    for matrix in [Some(structure.m_zz()), Some(structure.k_zz()), structure.d_zz(), Some(structure.transfer())] {
        out.extend(matrix.iter().flat_map(|matrix| matrix.iter()).flat_map(|value| value.to_le_bytes()));
    }
    for (dof, row) in dofs {
        out.extend_from_slice(&(row as u64).to_le_bytes());
        out.extend_from_slice(&(dof.dof as u64).to_le_bytes());
        out.extend_from_slice(&(dof.point.len() as u64).to_le_bytes());
        out.extend_from_slice(dof.point.as_bytes());
    }
    out
}

fn decode(mut body: &[u8]) -> Option<Stored> {
    let n_z = take_number(&mut body)?;
    let n_b = take_number(&mut body)?;
    let damped = take_number(&mut body)? == 1;
    let count = take_number(&mut body)?;
    let m_zz = take_matrix(&mut body, n_z, n_z)?;
    let k_zz = take_matrix(&mut body, n_z, n_z)?;
    let d_zz = if damped { Some(take_matrix(&mut body, n_z, n_z)?) } else { None };
    let transfer = take_matrix(&mut body, n_b, n_z)?;
    let mut dofs = Vec::new();
    for _ in 0..count {
        let (row, dof, length) = (take_number(&mut body)?, take_number(&mut body)?, take_number(&mut body)?);
        let point = String::from_utf8(take(&mut body, length)?.to_vec()).ok()?;
        dofs.push((InterfaceDof { point, dof }, row));
    }
    body.is_empty().then_some(Stored { matrices: ReducedMatrices { m_zz, k_zz, d_zz, transfer }, dofs })
}

fn take<'a>(body: &mut &'a [u8], length: usize) -> Option<&'a [u8]> {
    let (part, rest) = body.split_at_checked(length)?;
    *body = rest;
    Some(part)
}

fn take_number(body: &mut &[u8]) -> Option<usize> {
    let bytes: [u8; 8] = take(body, 8)?.try_into().ok()?;
    usize::try_from(u64::from_le_bytes(bytes)).ok()
}

fn take_matrix(body: &mut &[u8], rows: usize, columns: usize) -> Option<DMatrix<f64>> {
    let bytes = take(body, rows.checked_mul(columns)?.checked_mul(8)?)?;
    let values = bytes.chunks_exact(8).filter_map(|bytes| Some(f64::from_le_bytes(bytes.try_into().ok()?)));
    Some(DMatrix::from_iterator(rows, columns, values))
}

//! The journal stores every finished row until it is in a part.
//!
//! There is one file per part's block of rows; the threads that run rows write to it. A killed process loses no finished row. A power
//! failure loses the rows since the last [`Journal::sync`]. A file grows by spans of zeros, which are mapped into memory. Rows are copied
//! there without a system call, and a full disk is noticed before a row arrives.
//!
//! # Files
//!
//! ```text
//! .journal/study.json          the dataset as it begins: study, range, rows to run again; sealed as the manifest is
//! .journal/000000000064.rows   MAGIC, the study's key and its checksum, then frames: length, checksum, row
//! ```
//!
//! `study.json` is in place before the first row, so a folder that lost its manifest before its first part continues from the journal.
//! The key keeps rows of another study out: such a file is moved to the damaged parts. Files of earlier programs begin with another word
//! and contain no study; their rows count as rows of the manifest's study.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use memmap2::{MmapMut, MmapOptions};
use twox_hash::XxHash64;

use super::difference::{StudyKey, study_key};
use super::durable::{StagedFile, failed_to, refuse_link, sync_folder};
use super::error::DatasetError;
use super::info::DatasetInfo;
use super::lock::DatasetDir;
use super::manifest::{Manifest, to_sealed_json};
use super::record::StoredRow;
#[cfg(test)]
use super::trace::{Event, note};
use decore_files::{Limit, read};

/// Folder of the journal in the dataset's folder.
pub const JOURNAL: &str = ".journal";
/// Bytes by which a file grows.
const SPAN: usize = 1 << 18;
/// Zeros that extend the file; static, because a span is too large to allocate each time.
static ZEROS: [u8; SPAN] = [0; SPAN];
/// Name of the file in the journal that describes the dataset.
const STUDY_NAME: &str = "study.json";
/// Ending of the files of rows.
const ROWS_ENDING: &str = "rows";
/// First bytes of a file; the study's key follows.
const MAGIC: &[u8; 16] = b"decore journal2\n";
/// First bytes of a file of an earlier program; rows follow.
const EARLIER_MAGIC: &[u8; 16] = b"decore journal1\n";
/// No design has more rows.
const MOST_ROWS: u64 = 1 << 48;
/// Bytes of a frame's head: length and checksum. No frame has a head of zeros: the checksum of no bytes is not zero.
const HEAD: usize = 12;

/// Appends rows; shared by the threads that run them.
#[derive(Debug)]
pub struct Journal {
    place: DatasetDir,
    folder: PathBuf,
    rows_per_part: u64,
    /// First bytes of a file that is new.
    begin: Vec<u8>,
    state: Mutex<State>,
    /// Locked while files are synced: a caller that finds nothing to sync must still wait until another caller's sync is complete.
    syncing: Mutex<()>,
}

#[derive(Debug, Default)]
struct State {
    files: BTreeMap<u64, BlockFile>,
    /// Blocks written to since the last sync.
    unsynced: BTreeMap<u64, Arc<File>>,
    /// First failure. Nothing is appended after it, because rows behind a torn row would be lost.
    failed: Option<io::ErrorKind>,
}

/// The file of a block.
#[derive(Debug)]
struct BlockFile {
    file: Arc<File>,
    /// The last span of the file.
    span: MmapMut,
    /// Bytes of the span that are taken.
    taken: usize,
}

impl Journal {
    /// The journal of the dataset of a study at `place`; its folder must exist.
    pub fn new(place: DatasetDir, info: &DatasetInfo) -> Self {
        let folder = place.path().join(JOURNAL);
        let (rows_per_part, begin) = (info.rows_per_part, begin_of(study_key(info)));
        Self { place, folder, rows_per_part, begin, state: Mutex::default(), syncing: Mutex::default() }
    }

    /// Appends a row; when this returns, it outlives the process.
    ///
    /// # Errors
    /// The system's, such as a full disk: the rows before are kept, this one and later ones are refused. [`DatasetError::Gone`] where a
    /// block's file is to be opened and the folder is another one's: a file that is open stays this dataset's.
    pub fn append(&self, row: &StoredRow) -> Result<(), DatasetError> {
        let head = frame_head(row.bytes());
        let block = row.row() / self.rows_per_part;
        let path = || self.path(block);
        let mut state = self.lock();
        if let Some(kind) = state.failed {
            return Err(failed_to("write", &path())(kind.into()));
        }
        if !state.files.contains_key(&block) {
            self.place.check()?;
        }
        state.append(block, || BlockFile::open(&path(), &self.begin), [&head, row.bytes()]).map_err(|error| {
            state.failed = Some(error.kind());
            failed_to("write", &path())(error)
        })
    }

    /// The state stays consistent even if a thread panicked with the lock: every change is a single assignment.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until all rows appended so far are on the disk; rows may be appended meanwhile. Linux knows the pages of a map
    /// that were written to: syncing the file brings them along, without a lock on the map.
    ///
    /// # Errors
    /// The system's.
    pub fn sync(&self) -> Result<(), DatasetError> {
        let _syncing = self.syncing.lock().unwrap_or_else(PoisonError::into_inner);
        let mut state = self.lock();
        let files = std::mem::take(&mut state.unsynced);
        if files.is_empty() {
            return Ok(());
        }
        let handed = files.keys().filter_map(|block| state.files.get(block)).try_for_each(BlockFile::hand_over);
        handed.map_err(failed_to("sync the files in", &self.folder))?;
        drop(state);
        files.values().try_for_each(|file| file.sync_data()).map_err(failed_to("sync the files in", &self.folder))?;
        #[cfg(test)]
        files.keys().for_each(|block| note(&self.path(*block), || Event::SyncFile(self.path(*block))));
        // A file that is new is not there without its name.
        sync_folder(&self.folder)
    }

    /// Forgets a block whose part is in place.
    ///
    /// # Errors
    /// The system's.
    pub fn remove(&self, block: u64) -> Result<(), DatasetError> {
        let mut state = self.lock();
        state.files.remove(&block);
        state.unsynced.remove(&block);
        drop(state);
        let path = self.path(block);
        #[cfg(test)]
        note(&path, || Event::Remove(path.clone()));
        match fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(failed_to("remove", &path)(error)),
            _ => Ok(()),
        }
    }

    fn path(&self, block: u64) -> PathBuf {
        self.folder.join(format!("{:012}.{ROWS_ENDING}", block * self.rows_per_part))
    }
}

impl State {
    fn append(&mut self, block: u64, open: impl Fn() -> io::Result<BlockFile>, frame: [&[u8]; 2]) -> io::Result<()> {
        let file = match self.files.entry(block) {
            Entry::Occupied(entry) => entry.into_mut(),
            Entry::Vacant(entry) => entry.insert(open()?),
        };
        file.append(frame)?;
        self.unsynced.entry(block).or_insert_with(|| Arc::clone(&file.file));
        Ok(())
    }
}

impl BlockFile {
    /// Opens a file behind its last whole row, or makes it with these first bytes.
    fn open(path: &Path, begin: &[u8]) -> io::Result<Self> {
        refuse_link(path)?;
        let mut file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path)?;
        if file.seek(SeekFrom::End(0))? == 0 {
            file.write_all(begin)?;
        }
        Ok(Self { span: map_zeros(&file, (0, SPAN))?, file: Arc::new(file), taken: 0 })
    }

    fn append(&mut self, frame: [&[u8]; 2]) -> io::Result<()> {
        let length = frame.iter().map(|part| part.len()).sum::<usize>();
        let room = self.span.len() - self.taken;
        if room < length {
            self.hand_over()?;
            self.span = map_zeros(&self.file, (room, length.max(SPAN)))?;
            self.taken = 0;
        }
        let mut rest = self.span.get_mut(self.taken..).unwrap_or_default();
        frame.iter().try_for_each(|part| rest.write_all(part))?;
        self.taken += length;
        Ok(())
    }

    /// Elsewhere than on Linux syncing a file passes over the pages of its map: they are handed to the system first.
    fn hand_over(&self) -> io::Result<()> {
        if cfg!(target_os = "linux") { Ok(()) } else { self.span.flush_async() }
    }
}

/// Maps the last bytes of a file that are `left`, and `more` zeros that are added to it.
fn map_zeros(mut file: &File, (left, more): (usize, usize)) -> io::Result<MmapMut> {
    let end = file.seek(SeekFrom::End(0))?;
    // Written, not left as a hole: the system refuses zeros for which there is no room, but ends a process that touches a
    // hole for which there is none.
    let mut rest = more;
    while rest > 0 {
        let zeros = ZEROS.get(..rest).unwrap_or(&ZEROS);
        file.write_all(zeros)?;
        rest -= zeros.len();
    }
    // SAFETY: the lock of the dataset keeps other writers away; readers of this process only append through this map.
    unsafe { MmapOptions::new().offset(end - left as u64).len(left + more).map_mut(file) }
}

fn frame_head(payload: &[u8]) -> [u8; HEAD] {
    // A row of 4 GiB does not exist: its metrics would not fit into memory; a wrong length would be seen by the checksum.
    let [l0, l1, l2, l3] = (payload.len() as u32).to_le_bytes();
    let [c0, c1, c2, c3, c4, c5, c6, c7] = checksum(payload);
    [l0, l1, l2, l3, c0, c1, c2, c3, c4, c5, c6, c7]
}

/// Made for every row on the thread that runs rows, and gone with the journal: a fast one. Parts have a cryptographic one.
fn checksum(payload: &[u8]) -> [u8; 8] {
    XxHash64::oneshot(0, payload).to_le_bytes()
}

/// The checksum that earlier programs made: the rows of a sweep that one of them began are read.
fn earlier_checksum(payload: &[u8]) -> [u8; 8] {
    let [c0, c1, c2, c3, c4, c5, c6, c7, ..] = *blake3::hash(payload).as_bytes();
    [c0, c1, c2, c3, c4, c5, c6, c7]
}

/// First bytes of a file of rows of the study with this key.
fn begin_of(key: StudyKey) -> Vec<u8> {
    [&MAGIC[..], &key, &checksum(&key)].concat()
}

/// Writes the description of a dataset into its journal, unless it is there already. `staging`: folder for temporary files.
///
/// # Errors
/// The system's.
pub fn describe(dataset: &Path, staging: &Path, manifest: &Manifest) -> Result<(), DatasetError> {
    let begun = Manifest { reruns: manifest.reruns.clone(), ..Manifest::new(manifest.study.clone(), manifest.range) };
    let folder = dataset.join(JOURNAL);
    let path = folder.join(STUDY_NAME);
    if Manifest::read_file(&path, dataset).is_ok_and(|known| known == begun) {
        return Ok(());
    }
    StagedFile::write(staging, &path, &to_sealed_json(&begun, &path)?)?.put_in_place()?;
    sync_folder(&folder)
}

/// The manifest, without rows, of the dataset that the journal describes; `None` if it describes none.
pub fn described(dataset: &Path) -> Option<Manifest> {
    Manifest::read_file(&dataset.join(JOURNAL).join(STUDY_NAME), dataset).ok()
}

/// Whether the journal has a description, readable or not.
pub fn is_described(dataset: &Path) -> bool {
    dataset.join(JOURNAL).join(STUDY_NAME).is_file()
}

/// Rows recovered from the journal.
#[derive(Debug, Default, PartialEq)]
pub struct Salvage {
    /// Descriptions of entries that are not rows.
    pub notes: Vec<String>,
    /// Files with rows of another study; they were left as they are.
    pub foreign: Vec<PathBuf>,
}

/// Calls `take` for every complete row of this study in the journal, then truncates each file after its last complete row.
///
/// # Errors
/// The system's.
pub fn recover(dataset: &Path, info: &DatasetInfo, take: &mut dyn FnMut(StoredRow)) -> Result<Salvage, DatasetError> {
    let own = study_key(info);
    let Salvage { mut notes, mut foreign } = Salvage::default();
    for path in files(dataset)? {
        let bytes = read(&path, Limit::PART).map_err(failed_to("read", &path))?;
        if key_of(&bytes).is_some_and(|key| key != own) {
            foreign.push(path);
            continue;
        }
        let Frames { whole, lost } = visit_frames(&bytes, take);
        if lost > 0 {
            notes.push(format!(
                "{}: {lost} bytes are not complete rows (truncated when the process or its machine stopped, or changed \
                 since); their rows are computed again",
                path.display()
            ));
        }
        if whole < bytes.len() {
            let file = OpenOptions::new().write(true).open(&path).map_err(failed_to("open", &path))?;
            file.set_len(whole as u64).map_err(failed_to("shorten", &path))?;
        }
    }
    Ok(Salvage { notes, foreign })
}

/// Counts complete rows of the journal that `counts` accepts, and rows among them that are not done. Changes nothing.
///
/// # Errors
/// The system's.
pub fn count(dataset: &Path, counts: &dyn Fn(u64) -> bool) -> Result<(u64, u64), DatasetError> {
    let (mut rows, mut failed) = (0, 0);
    visit(dataset, &mut |row| {
        let counted = counts(row.row());
        rows += u64::from(counted);
        failed += u64::from(counted && row.failed());
    })?;
    Ok((rows, failed))
}

/// Calls `take` for every whole row of the journal, without changing it.
///
/// # Errors
/// The system's.
pub fn visit(dataset: &Path, take: &mut dyn FnMut(StoredRow)) -> Result<(), DatasetError> {
    for path in files(dataset)? {
        match read(&path, Limit::PART) {
            Ok(bytes) => _ = visit_frames(&bytes, take),
            // Its part came into place since the folder was listed.
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => return Err(failed_to("read", &path)(error)),
        }
    }
    Ok(())
}

/// The files of rows.
fn files(dataset: &Path) -> Result<Vec<PathBuf>, DatasetError> {
    let folder = dataset.join(JOURNAL);
    let entries = match fs::read_dir(&folder) {
        Ok(entries) => entries,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(failed_to("read the folder", &folder)(error)),
    };
    let mut paths = Vec::new();
    for entry in entries {
        let path = entry.map_err(failed_to("read the folder", &folder))?.path();
        refuse_link(&path).map_err(failed_to("open", &path))?;
        paths.push(path);
    }
    paths.retain(|path| path.extension().is_some_and(|ending| ending == ROWS_ENDING));
    paths.sort();
    Ok(paths)
}

/// Contents of a journal file.
struct Frames {
    /// Bytes up to the end of the last whole row.
    whole: usize,
    /// Bytes that are neither of whole rows nor zeros that wait for some.
    lost: usize,
}

/// Key of the study in a file of rows; `None` if the file has none, or its first bytes are damaged.
fn key_of(bytes: &[u8]) -> Option<StudyKey> {
    let (key, rest) = bytes.strip_prefix(MAGIC)?.split_first_chunk()?;
    rest.starts_with(&checksum(key)).then_some(*key)
}

/// Visits all complete rows, also after damaged bytes.
fn visit_frames(bytes: &[u8], take: &mut dyn FnMut(StoredRow)) -> Frames {
    let begin = match key_of(bytes) {
        Some(key) => begin_of(key).len(),
        None if bytes.starts_with(EARLIER_MAGIC) => EARLIER_MAGIC.len(),
        None => 0,
    };
    let mut frames = Frames { whole: begin, lost: 0 };
    let mut at = frames.whole;
    // Behind the last byte that is not zero nothing was written; a row may end with zeros.
    let written = bytes.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
    while at < written {
        match bytes.get(at..).and_then(read_frame) {
            Some((row, left)) => {
                frames.lost += at - frames.whole;
                take(row);
                at = bytes.len() - left.len();
                frames.whole = at;
            }
            None => at += 1,
        }
    }
    frames.lost += written.saturating_sub(frames.whole);
    frames
}

fn read_frame(bytes: &[u8]) -> Option<(StoredRow, &[u8])> {
    let (head, rest) = bytes.split_at_checked(HEAD)?;
    let (length, sum) = head.split_at_checked(4)?;
    let length = u32::from_le_bytes(length.try_into().ok()?) as usize;
    let (payload, rest) = rest.split_at_checked(length)?;
    // Looked at first: where a row is searched for behind damage, most places are none.
    let row = u64::from_le_bytes(payload.get(..8)?.try_into().ok()?);
    if row > MOST_ROWS || *payload.get(8)? > 1 {
        return None;
    }
    if checksum(payload) != sum && earlier_checksum(payload) != sum {
        return None;
    }
    Some((StoredRow::from_bytes(payload.to_vec())?, rest))
}

#[cfg(test)]
mod tests {
    use super::super::lock::Lock;
    use super::super::record::RowWriter;
    use super::*;
    use decore_quantity::Value;

    fn info() -> DatasetInfo {
        DatasetInfo { rows_per_part: 4, ..DatasetInfo::empty() }
    }

    fn row(row: u64) -> StoredRow {
        let mut writer = RowWriter::new(row, row == 3);
        writer.cell(Some(Value::Real(row as f64)));
        writer.finish()
    }

    #[test]
    fn what_is_torn_is_cut_and_the_rest_comes_back() {
        let scratch = tempfile::TempDir::new().expect("scratch folder");
        fs::create_dir(scratch.path().join(JOURNAL)).expect("folder");
        let lock = Lock::take(scratch.path()).expect("taken");
        let journal = Journal::new(lock.place().clone(), &info());
        (0..6).for_each(|index| journal.append(&row(index)).expect("written"));
        let path = scratch.path().join(JOURNAL).join("000000000004.rows");
        let bytes = fs::read(&path).expect("journal");
        let end = bytes.iter().rposition(|byte| *byte != 0).expect("rows") + 1;
        for (length, expected) in [(bytes.len(), 6), (end, 6), (end - 1, 5), (17, 4), (3, 4), (0, 4)] {
            fs::write(&path, &bytes[..length]).expect("cut");
            assert_eq!(count(scratch.path(), &|_| true).expect("counted"), (expected, 1));
            let mut rows = Vec::new();
            recover(scratch.path(), &info(), &mut |row| rows.push(row)).expect("recovered");
            assert_eq!(rows, (0..expected).map(row).collect::<Vec<_>>(), "{length} bytes");
            // Find the next frame after a cut.
            let again = Journal::new(lock.place().clone(), &info());
            again.append(&row(7)).expect("written");
            assert_eq!(count(scratch.path(), &|_| true).expect("counted").0, expected + 1);
        }
        let mut flipped = bytes.clone();
        flipped[60] ^= 1;
        fs::write(&path, flipped).expect("written");
        assert_eq!(count(scratch.path(), &|_| true).expect("counted").0, 5, "all but the damaged one");
    }

    #[test]
    fn rows_of_another_study_stay_out() {
        let scratch = tempfile::TempDir::new().expect("scratch folder");
        fs::create_dir(scratch.path().join(JOURNAL)).expect("folder");
        let lock = Lock::take(scratch.path()).expect("taken");
        Journal::new(lock.place().clone(), &info()).append(&row(2)).expect("written");
        let other = DatasetInfo { seed: 7, ..info() };
        let mut rows = Vec::new();
        let salvage = recover(scratch.path(), &other, &mut |row| rows.push(row)).expect("recovered");
        assert_eq!((rows.len(), salvage.foreign.len()), (0, 1));
        // Damaged first bytes name no study: the rows behind them count.
        let path = &salvage.foreign[0];
        let mut bytes = fs::read(path).expect("journal");
        bytes[20] ^= 1;
        fs::write(path, bytes).expect("written");
        let salvage = recover(scratch.path(), &other, &mut |row| rows.push(row)).expect("recovered");
        assert_eq!((rows.as_slice(), salvage.notes.len()), ([row(2)].as_slice(), 1));
    }

    /// A sweep that an earlier program began loses none of its rows.
    #[test]
    fn rows_of_an_earlier_program_are_read_and_others_follow() {
        let scratch = tempfile::TempDir::new().expect("scratch folder");
        fs::create_dir(scratch.path().join(JOURNAL)).expect("folder");
        let lock = Lock::take(scratch.path()).expect("taken");
        let mut bytes = EARLIER_MAGIC.to_vec();
        for earlier in [row(0), row(1)] {
            bytes.extend((earlier.bytes().len() as u32).to_le_bytes());
            bytes.extend(earlier_checksum(earlier.bytes()));
            bytes.extend(earlier.bytes());
        }
        fs::write(scratch.path().join(JOURNAL).join("000000000000.rows"), bytes).expect("written");
        Journal::new(lock.place().clone(), &info()).append(&row(2)).expect("written");
        let mut rows = Vec::new();
        let salvage = recover(scratch.path(), &info(), &mut |row| rows.push(row)).expect("recovered");
        assert_eq!((rows, salvage), ((0..3).map(row).collect(), Salvage::default()));
    }
}

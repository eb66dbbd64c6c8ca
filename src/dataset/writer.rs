//! Writes a dataset: finished rows into the journal at once, parts in a thread of their own.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::columns::{Columns, TableName};
use super::difference::{differences, is_same_but_budgets};
use super::durable::{failed_to, make_folder};
use super::error::DatasetError;
use super::info::{DatasetInfo, RowRecord};
use super::journal::{self, JOURNAL, Journal};
use super::lock::{DatasetDir, LOCK_NAME, Lock};
use super::manifest::{MANIFEST_NAME, Manifest, Rerun, RowSpan, TIMINGS_NAME, TimingsManifest};
use super::rebuild::{Known, known, strays};
use super::record::{StoredRow, check_record};
use super::recovery::{Recovered, recover, rows_left, supersede};
use super::rerun::RerunSelection;
use super::settled::settle_locked;
use super::status::{self, STATUS_NAME};
use super::store::{Block, DAMAGED, GROWING, REPLACED, STAGING, Store, columns_of, remove, set_aside};

/// Time after which rows in the journal are brought to the disk: a power failure costs no more.
const SYNC_INTERVAL: Duration = Duration::from_secs(5);

/// Action if the folder already holds a dataset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Existing {
    /// Refuse with [`DatasetError::Exists`].
    Refuse,
    /// Continue with it if it is of the same study and rows, else refuse with [`DatasetError::Changed`].
    Resume,
    /// Start anew: the dataset's tables and manifests (nothing else) go to a folder `.replaced` within, and are removed when
    /// the new dataset is whole.
    Replace,
}

/// Writes the rows of a study, in any order.
///
/// Memory is bounded by the blocks that are not full: with rows that come about in order, the records of three parts. A row
/// is in the journal when [`RowRecorder::record`] returns: whatever ends the process, [`Existing::Resume`] finds it.
pub struct DatasetWriter {
    folder: PathBuf,
    recorder: RowRecorder,
    range: RowSpan,
    pending: BTreeMap<u64, Block>,
    left: BTreeSet<(u64, u64)>,
    damaged: Vec<DatasetError>,
    notes: Vec<String>,
    recovered: (u64, u64),
    parts: Option<PartThread>,
    /// Dropped last: nobody else writes before everything here is over.
    _lock: Lock,
}

/// The thread that encodes and writes parts.
struct PartThread {
    blocks: SyncSender<Block>,
    thread: JoinHandle<(Store, Result<(), DatasetError>)>,
}

/// Turns records into stored rows, from any thread.
#[derive(Clone)]
pub struct RowRecorder {
    info: Arc<DatasetInfo>,
    columns: Arc<Columns>,
    journal: Arc<Journal>,
    place: DatasetDir,
}

impl RowRecorder {
    /// Puts a row into the journal. It must be handed to [`DatasetWriter::accept`] too, to get into a part.
    ///
    /// # Errors
    /// [`DatasetError::Record`] if the row has not the shape of the study; [`DatasetError::Gone`] if it is the first of a block here and
    /// the folder is another one; the system's, such as a full disk.
    pub fn record(&self, record: &RowRecord) -> Result<StoredRow, DatasetError> {
        check_record(&self.info, record)?;
        let row = StoredRow::new(&self.info, &self.columns, record);
        self.journal.append(&row)?;
        Ok(row)
    }
}

impl DatasetWriter {
    /// Opens the dataset of all rows of a study: see [`DatasetWriter::open`].
    ///
    /// # Errors
    /// As [`DatasetWriter::open`].
    pub fn create(folder: &Path, info: &DatasetInfo, existing: Existing) -> Result<Self, DatasetError> {
        Self::open(folder, info, RowSpan { first: 0, end: info.rows }, existing)
    }

    /// As [`DatasetWriter::create`], for rows of other datasets, including their records of re-run rows.
    pub(super) fn copy(
        folder: &Path,
        info: &DatasetInfo,
        reruns: Vec<Rerun>,
        existing: Existing,
    ) -> Result<Self, DatasetError> {
        let mut manifest = Manifest::new(info.clone(), RowSpan { first: 0, end: info.rows });
        reruns.into_iter().for_each(|rerun| manifest.note_rerun(rerun));
        Self::open_noting(folder, info, manifest, existing)
    }

    /// Creates the dataset's folder and manifests for the rows of `range`, or continues an existing dataset.
    ///
    /// # Errors
    /// [`DatasetError::Exists`], [`DatasetError::Changed`] or [`DatasetError::Occupied`] for what the folder holds;
    /// [`DatasetError::InUse`]; [`DatasetError::DuplicateColumn`]; [`DatasetError::Setting`] if there are no rows per part;
    /// the system's. Names and settings are checked before anything is written or removed.
    pub fn open(folder: &Path, info: &DatasetInfo, range: RowSpan, existing: Existing) -> Result<Self, DatasetError> {
        Self::open_noting(folder, info, Manifest::new(info.clone(), range), existing)
    }

    /// Opens a dataset, with this manifest if it is a new one.
    fn open_noting(
        folder: &Path,
        info: &DatasetInfo,
        manifest: Manifest,
        existing: Existing,
    ) -> Result<Self, DatasetError> {
        let columns = columns_of(info)?;
        look(folder, existing)?;
        make_folder(folder)?;
        let lock = Lock::take(folder)?;
        if existing == Existing::Resume {
            settle_locked(folder)?;
        }
        let recovered = match look(folder, existing)? {
            Found::Dataset(known) if existing == Existing::Resume => {
                return Self::go_on(folder, lock, *known, ResumeCheck { info, range: manifest.range, chosen: None });
            }
            found => {
                let mut recovered = Recovered::nothing(manifest, TimingsManifest::default());
                if !matches!(found, Found::Nothing) {
                    recovered.notes.push(replace_dataset(folder)?);
                }
                recovered
            }
        };
        Self::start(folder, columns, recovered, lock)
    }

    /// Opens a dataset to re-run and replace chosen rows. The budgets of `info` may differ.
    ///
    /// A row that is not done does not replace one that is.
    ///
    /// # Errors
    /// As [`DatasetWriter::open`]; [`DatasetError::Missing`].
    pub fn again(
        folder: &Path,
        info: &DatasetInfo,
        range: RowSpan,
        chosen: &RerunSelection,
    ) -> Result<Self, DatasetError> {
        let missing = || DatasetError::Missing { path: folder.to_owned() };
        let Found::Dataset(_) = look(folder, Existing::Resume)? else { return Err(missing()) };
        let lock = Lock::take(folder)?;
        settle_locked(folder)?;
        // Another process may have written until the lock was taken.
        let Found::Dataset(known) = look(folder, Existing::Resume)? else { return Err(missing()) };
        Self::go_on(folder, lock, *known, ResumeCheck { info, range, chosen: Some(chosen) })
    }

    /// Continues with a dataset: with the rows that are missing, or those chosen.
    fn go_on(folder: &Path, lock: Lock, known: Known, asked: ResumeCheck<'_>) -> Result<Self, DatasetError> {
        let changed = refuse_change(folder, &known.manifest, asked)?;
        let chosen = asked.chosen;
        // Title and comments of the first run stay, so that all parts have the same bytes.
        let columns = columns_of(&known.manifest.study)?;
        let mut recovered = recover(folder, &columns, known)?;
        recovered.notes.extend(strays(folder, &recovered.manifest)?.iter().map(ToString::to_string));
        recovered.chosen = chosen.map(|chosen| recovered.choose(folder, &columns, chosen)).transpose()?;
        let rows = recovered.chosen.clone().unwrap_or_else(|| rows_left(&recovered.manifest, &recovered.pending));
        if !changed.is_empty() && !rows.is_empty() {
            recovered.manifest.note_rerun(Rerun { changed, rows });
        }
        Self::start(folder, columns, recovered, lock)
    }

    fn start(folder: &Path, columns: Arc<Columns>, recovered: Recovered, lock: Lock) -> Result<Self, DatasetError> {
        status::remove_staged(folder)?;
        let staging = folder.join(STAGING);
        remove(&staging)?;
        [&staging, &folder.join(JOURNAL)].into_iter().try_for_each(|path| make_folder(path))?;
        // Before the first row, and before the manifest that it stands for.
        journal::describe(folder, &staging, &recovered.manifest)?;
        let untimed = recovered.untimed();
        let Recovered { manifest, timings, pending, only_in_parts, chosen, damaged, notes } = recovered;
        let missing = rows_left(&manifest, &pending);
        let left = chosen.unwrap_or_else(|| missing.clone());
        let is_left = |row: u64| {
            let before = left.partition_point(|span| span.first <= row);
            before.checked_sub(1).and_then(|index| left.get(index)).is_some_and(|span| row < span.end)
        };
        let again = pending.values().flat_map(BTreeMap::keys).filter(|row| is_left(**row)).count() as u64;
        let rows = again + missing.iter().map(|span| span.len()).sum::<u64>();
        // Rows of a block that is not full are in its part and pending: the pending ones count.
        let full =
            manifest.runs.iter().filter(|part| !pending.contains_key(&(part.first_row / manifest.study.rows_per_part)));
        let failed = full.map(|part| part.failed).sum::<u64>()
            + pending.values().flat_map(BTreeMap::values).filter(|row| row.failed() && !is_left(row.row())).count()
                as u64;
        let info = Arc::new(manifest.study.clone());
        let place = lock.place().clone();
        let journal = Arc::new(Journal::new(place.clone(), &info));
        let unjournaled = pending.values().flat_map(BTreeMap::values).filter(|row| only_in_parts.contains(&row.row()));
        unjournaled.into_iter().try_for_each(|row| journal.append(row))?;
        journal.sync()?;
        let range = manifest.range;
        let mut store = Store::open(place.clone(), Arc::clone(&columns), manifest, timings)?;
        untimed.into_iter().try_for_each(|first_row| store.put_null_timings(first_row))?;
        let recorder = RowRecorder { info, columns, journal, place };
        let mut writer = Self {
            folder: folder.to_owned(),
            parts: Some(PartThread::start(store, Arc::clone(&recorder.journal))?),
            recorder,
            range,
            pending,
            left: left.into_iter().map(|span| (span.first, span.end)).collect(),
            damaged,
            notes,
            recovered: (range.len() - rows, failed),
            _lock: lock,
        };
        // A run may have ended between a block's last row and its part.
        for block in writer.pending.keys().copied().collect::<Vec<_>>() {
            writer.write_if_full(block)?;
        }
        Ok(writer)
    }

    /// Turns records into rows for [`DatasetWriter::accept`], from any thread.
    pub fn recorder(&self) -> RowRecorder {
        self.recorder.clone()
    }

    /// Folder of the dataset.
    pub fn place(&self) -> DatasetDir {
        self.recorder.place.clone()
    }

    /// The rows that are still to come, ascending.
    pub fn rows_left(&self) -> Vec<RowSpan> {
        self.left.iter().map(|&(first, end)| RowSpan { first, end }).collect()
    }

    /// Rows that existed when the dataset was opened, and those that are not done.
    pub fn recovered(&self) -> (u64, u64) {
        self.recovered
    }

    /// Damaged parts; their rows must be computed again. The files are in `.damaged`.
    pub fn damaged(&self) -> &[DatasetError] {
        &self.damaged
    }

    /// Further losses when the dataset was opened, and files kept aside, a sentence each.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Takes one row; [`RowRecorder::record`] and [`DatasetWriter::accept`] in one.
    ///
    /// # Errors
    /// As both.
    pub fn write(&mut self, record: &RowRecord) -> Result<(), DatasetError> {
        self.expect(record.row)?;
        let row = self.recorder.record(record)?;
        self.accept(row)
    }

    /// Takes a stored row, and writes its block when it is complete.
    ///
    /// # Errors
    /// [`DatasetError::UnexpectedRow`]; [`DatasetError::Gone`] if the folder is another one: asked for every row here, on the one
    /// thread that takes them, and not on those that run them; what went wrong with an earlier block (its rows are in the journal still).
    pub fn accept(&mut self, row: StoredRow) -> Result<(), DatasetError> {
        self.expect(row.row())?;
        self.recorder.place.check()?;
        self.take_off(row.row());
        let block = row.row() / self.recorder.info.rows_per_part;
        supersede(self.pending.entry(block).or_default(), row);
        self.write_if_full(block)
    }

    /// Writes the blocks that are not full too, and returns the manifest.
    ///
    /// The manifest shows whether the dataset has all its rows.
    ///
    /// # Errors
    /// The system's or the Parquet library's; the rows are in the journal then.
    pub fn finish(mut self) -> Result<Manifest, DatasetError> {
        for (_, block) in std::mem::take(&mut self.pending) {
            self.hand_over(block)?;
        }
        let parts = self.parts.take().ok_or(DatasetError::WriterLost)?;
        let store = parts.finish()?;
        self.recorder.place.check()?;
        remove(&self.folder.join(JOURNAL))?;
        remove(&self.folder.join(STAGING))?;
        if store.manifest().complete {
            remove(&self.folder.join(REPLACED))?;
        }
        Ok(store.manifest().clone())
    }

    /// Brings the journal to the disk, as the writer does now and then.
    #[cfg(test)]
    pub(super) fn sync_journal(&self) -> Result<(), DatasetError> {
        self.recorder.journal.sync()
    }

    /// Whether the row is still to come.
    pub fn needs(&self, row: u64) -> bool {
        self.span_of(row).is_some()
    }

    fn expect(&self, row: u64) -> Result<(), DatasetError> {
        match self.span_of(row) {
            Some(_) => Ok(()),
            None => {
                Err(DatasetError::UnexpectedRow { row, expected_from: self.range.first, expected_end: self.range.end })
            }
        }
    }

    /// The span of rows to come that has the row.
    fn span_of(&self, row: u64) -> Option<(u64, u64)> {
        let span = self.left.range(..=(row, u64::MAX)).next_back().copied();
        span.filter(|(_, end)| row < *end)
    }

    fn take_off(&mut self, row: u64) {
        if let Some((first, end)) = self.span_of(row) {
            self.left.remove(&(first, end));
            self.left.extend([(first, row), (row + 1, end)].into_iter().filter(|(first, end)| first < end));
        }
    }

    fn write_if_full(&mut self, block: u64) -> Result<(), DatasetError> {
        let per_part = self.recorder.info.rows_per_part;
        let first = block * per_part;
        let wanted = RowSpan { first, end: first.saturating_add(per_part) }.intersection(self.range);
        // Rows that are run again are there and still to come.
        let waits = self.left.range(..(wanted.end, 0)).next_back().is_some_and(|(_, end)| *end > wanted.first);
        match self.pending.remove(&block) {
            Some(rows) if !waits && rows.len() as u64 == wanted.len() => self.hand_over(rows),
            Some(rows) => {
                self.pending.insert(block, rows);
                Ok(())
            }
            None => Ok(()),
        }
    }

    fn hand_over(&mut self, block: Block) -> Result<(), DatasetError> {
        let parts = self.parts.as_ref().ok_or(DatasetError::WriterLost)?;
        if parts.blocks.send(block).is_ok() {
            return Ok(());
        }
        // The thread has ended early: it knows why.
        match self.parts.take().map(PartThread::finish) {
            Some(Err(error)) => Err(error),
            _ => Err(DatasetError::WriterLost),
        }
    }
}

impl Drop for DatasetWriter {
    fn drop(&mut self) {
        if let Some(parts) = self.parts.take() {
            // Write all submitted rows. Failed writes stay in the journal; drop cannot report errors.
            let _ = parts.finish();
        }
        let _ = self.recorder.journal.sync();
        if self.recorder.place.check().is_err() {
            return;
        }
        let _ = fs::remove_dir_all(self.folder.join(STAGING));
    }
}

impl PartThread {
    fn start(store: Store, journal: Arc<Journal>) -> Result<Self, DatasetError> {
        // One block waits while another is written: the rows need not.
        let (blocks, receiver) = sync_channel(1);
        let thread = std::thread::Builder::new().name("parts".to_owned());
        let thread = thread.spawn(move || write_parts(store, &journal, &receiver));
        let thread = thread.map_err(failed_to("start the thread that writes parts for", Path::new(".")))?;
        Ok(Self { blocks, thread })
    }

    fn finish(self) -> Result<Store, DatasetError> {
        drop(self.blocks);
        let (store, result) = self.thread.join().map_err(|_| DatasetError::WriterLost)?;
        result.map(|()| store)
    }
}

/// Writes the blocks that come, and syncs the journal, so that the threads that run rows need not wait for the disk.
fn write_parts(mut store: Store, journal: &Journal, blocks: &Receiver<Block>) -> (Store, Result<(), DatasetError>) {
    let mut last_sync = Instant::now();
    loop {
        let received = blocks.recv_timeout(SYNC_INTERVAL.saturating_sub(last_sync.elapsed()));
        let mut result = match received {
            Ok(block) => {
                let number = block.keys().next().map(|row| row / store.manifest().study.rows_per_part);
                store.put_block(&block).and_then(|()| number.map_or(Ok(()), |number| journal.remove(number)))
            }
            Err(RecvTimeoutError::Timeout) => store.check_place(),
            Err(RecvTimeoutError::Disconnected) => return (store, Ok(())),
        };
        if last_sync.elapsed() >= SYNC_INTERVAL {
            result = result.and_then(|()| journal.sync());
            last_sync = Instant::now();
        }
        if result.is_err() {
            return (store, result);
        }
    }
}

/// Properties that an existing dataset must have to be continued.
#[derive(Clone, Copy)]
struct ResumeCheck<'a> {
    /// The study.
    info: &'a DatasetInfo,
    /// Rows that the dataset is to hold.
    range: RowSpan,
    /// Rows to re-run; `None`: missing rows.
    chosen: Option<&'a RerunSelection>,
}

/// Contents of a folder.
enum Found {
    /// Nothing, or the files of an interrupted creation.
    Nothing,
    /// A dataset.
    Dataset(Box<Known>),
    /// A dataset of another version, or one whose manifest is lost for good.
    Unreadable,
}

/// Looks at a folder: it must be absent, empty, or a dataset that `existing` allows for.
fn look(folder: &Path, existing: Existing) -> Result<Found, DatasetError> {
    if is_vacant(folder)? {
        return Ok(Found::Nothing);
    }
    match (known(folder), existing) {
        (Ok(Known { manifest, .. }), Existing::Refuse) => Err(DatasetError::Exists {
            path: folder.to_owned(),
            rows_done: rows_there(folder, &manifest)?,
            rows: manifest.study.rows,
            study: manifest.study.study_name,
        }),
        (Ok(known), _) => Ok(Found::Dataset(Box::new(known))),
        (Err(DatasetError::Missing { .. }), _) => Err(DatasetError::Occupied { path: folder.to_owned() }),
        // Whoever asks for replacement of a damaged dataset, or one of another version, gets it.
        (Err(DatasetError::Version { .. }), Existing::Replace) => Ok(Found::Unreadable),
        (Err(DatasetError::Lost { .. }), Existing::Replace) => Ok(Found::Unreadable),
        (Err(error), _) => Err(error),
    }
}

/// Refuses another study, unless only budgets differ and no remaining row reached the old ones. Returns the differences.
fn refuse_change(
    folder: &Path,
    manifest: &Manifest,
    ResumeCheck { info, range, chosen }: ResumeCheck<'_>,
) -> Result<Vec<String>, DatasetError> {
    let mut differences = differences(&manifest.study, info);
    let only_budgets = is_same_but_budgets(&manifest.study, info);
    let is_whole = |span: RowSpan, info: &DatasetInfo| span == RowSpan { first: 0, end: info.rows };
    if manifest.range != range && !(is_whole(manifest.range, &manifest.study) && is_whole(range, info)) {
        let words = |span: RowSpan| format!("{} to {}", span.first, span.end.saturating_sub(1));
        differences.push(format!("--shard (rows): {} -> {}", words(manifest.range), words(range)));
    } else if differences.is_empty() {
        return Ok(differences);
    } else if only_budgets {
        let failed = manifest.rows_failed() + journal::count(folder, &|row| !manifest.has(row))?.1;
        if failed == 0 || chosen.is_some() {
            return Ok(differences);
        }
        differences.push(format!(
            "{failed} rows are not done with the budgets before: `--only-failed` runs these again with the new ones, and keeps \
             the others"
        ));
    }
    let before = &manifest.study;
    if before.frame_hash == info.frame_hash && before.rows < info.rows {
        differences.push(format!(
            "with these rows the first {rows} are others than before, so they cannot be kept: a Latin hypercube keeps them with \
             `grown_from = [{rows}]`, a table if rows are added at its end",
            rows = before.rows
        ));
    }
    Err(DatasetError::Changed {
        path: folder.to_owned(),
        rows_done: rows_there(folder, manifest)?,
        rows: manifest.study.rows,
        differences,
    })
}

/// Number of rows of a dataset, including its journal.
fn rows_there(folder: &Path, manifest: &Manifest) -> Result<u64, DatasetError> {
    Ok(manifest.rows_done + journal::count(folder, &|row| !manifest.has(row))?.0)
}

/// Whether a folder is absent, empty, or contains only files of an interrupted creation.
fn is_vacant(folder: &Path) -> Result<bool, DatasetError> {
    let entries = match fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(true),
        Err(error) => return Err(failed_to("open the folder", folder)(error)),
    };
    for entry in entries {
        let entry = entry.map_err(failed_to("read the folder", folder))?;
        let name = entry.file_name();
        let is_table = TableName::KNOWN.iter().any(|table| name == table.folder());
        let ours = [STAGING, JOURNAL, LOCK_NAME, STATUS_NAME, TIMINGS_NAME, REPLACED, DAMAGED];
        let is_ours = ours.iter().any(|ours| name == *ours) || status::is_staged(Path::new(&name));
        let is_empty = |path: &Path| fs::read_dir(path).is_ok_and(|mut entries| entries.next().is_none());
        let may_stay = is_ours || (is_table && is_empty(&entry.path()));
        if !may_stay {
            return Ok(false);
        }
    }
    // Rows of a dataset whose manifest is gone.
    Ok(journal::count(folder, &|_| true)?.0 == 0)
}

/// Moves all files of a dataset aside, the manifest last, so that an interrupted move can be repeated. Returns the new place.
fn replace_dataset(folder: &Path) -> Result<String, DatasetError> {
    let earlier = fs::read_dir(folder.join(REPLACED)).map_or(0, Iterator::count);
    let aside = folder.join(REPLACED).join((earlier + 1).to_string());
    let tables = TableName::KNOWN.map(TableName::folder);
    let names = tables.into_iter().chain([JOURNAL, DAMAGED, GROWING, STATUS_NAME, TIMINGS_NAME, MANIFEST_NAME]);
    names.map(|name| folder.join(name)).try_for_each(|path| set_aside(&path, &aside))?;
    Ok(format!("the dataset that was there is kept in {} until the new one is whole", aside.display()))
}

//! Power cuts: replays a record of all disk operations, with unsynced ones dropped, torn or reordered.
//!
//! A kill keeps everything that a process wrote. A power cut keeps everything that was synced, and any part of the rest. The model is
//! stricter than file systems: every unsynced page of a file and entry of a folder may exist or not, independently. Only a rename is
//! atomic.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use super::info::{DatasetInfo, RowRecord};
use super::journal::JOURNAL;
use super::trace::{Event, RECORD, note};
use super::writer::{DatasetWriter, Existing};
use decore_model::metrics::{Blow, CastingMetrics, HammerMetrics, RunMetrics, RunTotals};
use decore_model::run::{RowOutcome, RowStatus};

/// Bytes that a disk writes whole or not, unless it tears them.
const PAGE: usize = 4096;
/// Rows of the study.
const ROWS: u64 = 150;
/// Moments at which the power is cut, and times that each is replayed.
const CUTS: usize = 200;
const REPLAYS: usize = 1;

/// A change of a folder's entries.
#[derive(Debug, Clone)]
enum Entry {
    File(PathBuf, usize),
    Folder(PathBuf),
    Moved(PathBuf, PathBuf, usize),
    Gone(PathBuf),
}

/// Entries of all folders: files by number, folders without.
type Names = BTreeMap<PathBuf, Option<usize>>;

/// Contents of a disk, and its pending writes.
#[derive(Default)]
struct Disk {
    /// Synced and last written contents.
    files: Vec<[Vec<u8>; 2]>,
    safe: Names,
    asked: Names,
    /// Changes that are not safe, with the folder whose sync makes them so.
    pending: Vec<(PathBuf, Entry)>,
    durable: BTreeSet<u64>,
}

fn apply(names: &mut Names, entry: &Entry) {
    match entry {
        Entry::File(path, file) => _ = names.insert(path.clone(), Some(*file)),
        Entry::Folder(path) => _ = names.insert(path.clone(), None),
        Entry::Moved(from, to, file) => {
            names.remove(from);
            names.insert(to.clone(), Some(*file));
        }
        Entry::Gone(path) => names.retain(|name, _| !name.starts_with(path)),
    }
}

impl Disk {
    fn change(&mut self, folder: &Path, entry: Entry) {
        apply(&mut self.asked, &entry);
        self.pending.push((folder.to_owned(), entry));
    }

    fn take(&mut self, event: &Event) {
        let parent = |path: &Path| path.parent().expect("below the root").to_owned();
        match event {
            Event::Contents(path, bytes) => {
                let known = self.asked.get(path).copied().flatten();
                let file = known.unwrap_or(self.files.len());
                if known.is_none() {
                    self.files.push([Vec::new(), Vec::new()]);
                    self.change(&parent(path), Entry::File(path.clone(), file));
                }
                self.files[file][1].clone_from(bytes);
            }
            Event::SyncFile(path) => {
                if let Some(Some(file)) = self.asked.get(path) {
                    let [safe, asked] = &mut self.files[*file];
                    safe.clone_from(asked);
                }
            }
            Event::MakeFolder(path) if self.asked.contains_key(path) => {}
            Event::MakeFolder(path) => self.change(&parent(path), Entry::Folder(path.clone())),
            Event::Rename(from, to) => {
                let file = self.asked.get(from).copied().flatten().expect("a file that was written");
                self.change(&parent(to), Entry::Moved(from.clone(), to.clone(), file));
            }
            Event::Remove(path) => self.change(&parent(path), Entry::Gone(path.clone())),
            Event::SyncFolder(folder) => {
                let (safe, left) = std::mem::take(&mut self.pending).into_iter().partition(|(at, _)| at == folder);
                self.pending = left;
                let safe: Vec<(PathBuf, Entry)> = safe;
                safe.iter().for_each(|(_, entry)| apply(&mut self.safe, entry));
            }
            Event::Durable(rows) => self.durable.extend(rows),
        }
    }

    /// Writes the files that a power cut leaves below `root`.
    fn cut(&self, root: &Path, random: &mut impl FnMut(usize) -> usize) {
        let mut names = self.safe.clone();
        for (_, entry) in &self.pending {
            if random(2) == 0 {
                apply(&mut names, entry);
            }
        }
        fs::create_dir_all(root).expect("root");
        // Folders come before their files: a file in a missing folder is missing too.
        for (name, file) in &names {
            let path = root.join(name);
            if !path.parent().is_some_and(Path::is_dir) {
                continue;
            }
            match file {
                None => fs::create_dir_all(&path).expect("folder"),
                Some(file) => fs::write(&path, mixed(&self.files[*file], random)).expect("file"),
            }
        }
    }
}

/// Mixes the synced and the written bytes page by page, or cuts the written bytes and appends the rest of the synced ones.
fn mixed([safe, asked]: &[Vec<u8>; 2], random: &mut impl FnMut(usize) -> usize) -> Vec<u8> {
    if safe == asked {
        return safe.clone();
    }
    let mut mixed = safe.clone();
    if random(2) == 0 {
        mixed.resize(asked.len(), 0);
    }
    for (index, page) in asked.chunks(PAGE).enumerate() {
        let kept = [0, page.len(), random(page.len() + 1)][random(3)];
        let from = index * PAGE;
        if kept > 0 && safe.get(from..from + page.len()) != Some(page) {
            mixed.resize(mixed.len().max(from + kept), 0);
            mixed[from..from + kept].copy_from_slice(&page[..kept]);
        }
    }
    mixed
}

fn info() -> DatasetInfo {
    let names = |name: &str| vec![name.to_owned()];
    DatasetInfo { rows: ROWS, hammers: names("left"), castings: names("part"), ..DatasetInfo::empty() }
}

fn record(row: u64) -> RowRecord {
    let blow = Blow { start_time_s: 0.1, energy_j: row as f64, ..Blow::default() };
    let metrics = RunMetrics {
        hammers: vec![HammerMetrics::default()],
        castings: vec![CastingMetrics::default()],
        blows: vec![blow],
        totals: RunTotals { delivered_work_j: row as f64, ..RunTotals::default() },
        ..RunMetrics::default()
    };
    let mut outcome = RowOutcome::invalid(String::new());
    (outcome.status, outcome.metrics, outcome.wall_time_s) = (RowStatus::Done, Some(metrics), 1.0);
    RowRecord { row, factors: Vec::new(), outcome }
}

/// The rows in an order of their own, a journal that is synced now and then, an end within the sweep, a second run.
fn recorded(folder: &Path) -> Vec<Event> {
    fs::create_dir_all(folder).expect("folder");
    *RECORD.lock().expect("record") = Some((folder.to_owned(), Vec::new()));
    let order: Vec<u64> = (0..ROWS).map(|step| step * 77 % ROWS).collect();
    let mut done = Vec::new();
    for (rows, every) in [(&order[..90], 7), (&order[90..], 4)] {
        let mut writer = DatasetWriter::create(folder, &info(), Existing::Resume).expect("opened");
        for (number, row) in rows.iter().enumerate() {
            writer.write(&record(*row)).expect("taken");
            done.push(*row);
            note_journal(folder);
            if number % every == 0 {
                writer.sync_journal().expect("synced");
                note(folder, || Event::Durable(done.clone()));
            }
        }
        if done.len() as u64 == ROWS {
            writer.finish().expect("finished");
        }
    }
    RECORD.lock().expect("record").take().map(|(_, events)| events).unwrap_or_default()
}

/// Rows get into the journal through maps of its files, without a call that could be recorded.
fn note_journal(folder: &Path) {
    for entry in fs::read_dir(folder.join(JOURNAL)).expect("journal") {
        let path = entry.expect("entry").path();
        // The part may have come into place meanwhile.
        if let Ok(bytes) = fs::read(&path) {
            note(&path, || Event::Contents(path.clone(), bytes));
        }
    }
}

/// The bytes of `runs`, `blows` and the manifest.
fn contract(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let parts = ["runs", "blows"].iter().flat_map(|table| fs::read_dir(folder.join(table)).expect("table"));
    let paths = parts.map(|entry| entry.expect("entry").path()).chain([folder.join("manifest.json")]);
    paths.map(|path| (path.strip_prefix(folder).expect("below").to_owned(), fs::read(&path).expect("file"))).collect()
}

#[test]
fn no_durable_row_is_lost_to_a_power_cut() {
    let scratch = tempfile::TempDir::new().expect("scratch folder");
    let whole = scratch.path().join("whole");
    let events = recorded(&whole);
    let expected = contract(&whole);
    let mut state = 5_u64;
    let mut random = |limit: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % limit
    };
    let (mut durable, mut found) = (0, 0);
    for cut in 1..=CUTS {
        let mut disk = Disk::default();
        disk.asked.insert(whole.clone(), None);
        disk.safe.insert(whole.clone(), None);
        events[..events.len() * cut / CUTS].iter().for_each(|event| disk.take(event));
        for replay in 0..REPLAYS {
            let root = scratch.path().join("cut");
            let _ = fs::remove_dir_all(&root);
            relative(&disk, &whole).cut(&root, &mut random);
            let writer = DatasetWriter::create(&root, &info(), Existing::Resume);
            let mut writer = writer.unwrap_or_else(|error| panic!("cut {cut}, replay {replay}: {error}"));
            let left: BTreeSet<u64> = writer.rows_left().iter().flat_map(|span| span.first..span.end).collect();
            let lost: Vec<&u64> = disk.durable.intersection(&left).collect();
            assert!(lost.is_empty(), "cut {cut}, replay {replay}: rows {lost:?} were durable and are lost");
            durable += disk.durable.len();
            found += ROWS as usize - left.len();
            left.into_iter().for_each(|row| writer.write(&record(row)).expect("taken"));
            assert!(writer.finish().expect("finished").complete);
            assert!(contract(&root) == expected, "cut {cut}, replay {replay}: other bytes");
        }
    }
    println!("{} events, {CUTS} cuts, {REPLAYS} replays each: {durable} durable rows, {found} found", events.len());
    assert!(found >= durable && durable > CUTS * REPLAYS * 10);
}

/// The disk with names relative to the dataset's folder.
fn relative(disk: &Disk, root: &Path) -> Disk {
    let short = |path: &PathBuf| path.strip_prefix(root).expect("below the root").to_owned();
    let entry = |entry: &Entry| match entry {
        Entry::File(path, file) => Entry::File(short(path), *file),
        Entry::Folder(path) => Entry::Folder(short(path)),
        Entry::Moved(from, to, file) => Entry::Moved(short(from), short(to), *file),
        Entry::Gone(path) => Entry::Gone(short(path)),
    };
    Disk {
        files: disk.files.clone(),
        safe: disk.safe.iter().map(|(path, file)| (short(path), *file)).collect(),
        asked: Names::new(),
        pending: disk.pending.iter().map(|(folder, change)| (folder.clone(), entry(change))).collect(),
        durable: BTreeSet::new(),
    }
}

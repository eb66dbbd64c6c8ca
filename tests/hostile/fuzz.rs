//! Mutated files at every reader: no panic, no abort, no input that takes seconds or half a gigabyte.
//!
//! A few hundred inputs per reader by default; `DECORE_FUZZ=1000000` tries so many in all, `DECORE_FUZZ_SEED` others.

use std::alloc::{GlobalAlloc, Layout, System as Heap};
use std::cell::Cell;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use cpu_time::ThreadTime;
use decore_dataset::{Columns, DatasetReader, SweepStatus, TableName};
use decore_model::structure::{
    BodyNodes, FeModel, InterfacePoints, MatrixFile, MatrixFormat, ModalTable, ModelFiles, Units, read_measured,
};
use decore_study::{CheckedStudy, PointTable, Study, load_structure};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use tempfile::TempDir;

use crate::solid::block;

/// Inputs per reader, unless asked for more.
const INPUTS: u64 = 150;
const MOST_TIME: Duration = Duration::from_secs(2);
const MOST_BYTES: i64 = 500_000_000;

thread_local! {
    static LIVE: Cell<i64> = const { Cell::new(0) };
    static PEAK: Cell<i64> = const { Cell::new(0) };
}

/// The system's allocator, which knows the bytes that a thread holds.
struct Weighing;

fn weigh(change: i64) {
    // A thread that is being torn down has no scale any more.
    let _ = LIVE.try_with(|live| {
        live.set(live.get() + change);
        let _ = PEAK.try_with(|peak| peak.set(peak.get().max(live.get())));
    });
}

unsafe impl GlobalAlloc for Weighing {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        weigh(layout.size() as i64);
        unsafe { Heap.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        weigh(layout.size() as i64);
        unsafe { Heap.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        weigh(-(layout.size() as i64));
        unsafe { Heap.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        weigh(size as i64 - layout.size() as i64);
        unsafe { Heap.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Weighing = Weighing;

/// What numbers, words and brackets are replaced by.
const TOKENS: [&str; 40] = [
    "0",
    "-1",
    "1e308",
    "-1e-308",
    "nan",
    "inf",
    "4294967296",
    "18446744073709551615",
    "9223372036854775807",
    "1e12",
    "0x7f",
    "99999999999999999999",
    "3.5",
    "\"\"",
    "\"a\"",
    "'",
    "\"",
    "[",
    "]",
    "{",
    "}",
    "[[",
    "=",
    ",",
    "\n",
    "\r\n",
    "\t",
    "\0",
    "\u{1b}[2J",
    "\u{202e}",
    "\u{feff}",
    "\u{fffd}é",
    "#",
    "$",
    "*",
    "%%",
    "true",
    "a.b.c",
    "1D+400",
    " ",
];

/// A change at a place: what is done, where, how much or which token.
type Mutation = (u8, u32, u32);

fn mutations() -> impl Strategy<Value = Vec<Mutation>> {
    prop::collection::vec((0..9_u8, any::<u32>(), any::<u32>()), 1..6)
}

fn mutate(bytes: &mut Vec<u8>, other: &[u8], (what, place, size): Mutation) {
    let at = place as usize % (bytes.len() + 1);
    let end = (at + 1 + size as usize % 64).min(bytes.len());
    let token = TOKENS[size as usize % TOKENS.len()].as_bytes();
    let is_word = |byte: &u8| byte.is_ascii_alphanumeric() || b"_.+-".contains(byte);
    match what {
        0 if at < bytes.len() => bytes[at] ^= 1 << (size % 8),
        1 if at < bytes.len() => bytes[at] = size as u8,
        2 => drop(bytes.splice(at..at, token.iter().copied())),
        3 => drop(bytes.drain(at..end)),
        4 => {
            // A part again, up to many times.
            let part = bytes[at..end].repeat(1 + (size as usize >> 8) % 200);
            drop(bytes.splice(at..at, part));
        }
        5 => bytes.truncate(at),
        6 => {
            let from = size as usize % (other.len() + 1);
            let part = &other[from..(from + 200).min(other.len())];
            drop(bytes.splice(at..at, part.iter().copied()));
        }
        // A whole word, number or name.
        _ => {
            let begin = bytes[..at].iter().rposition(|byte| !is_word(byte)).map_or(0, |before| before + 1);
            let end = bytes[at..].iter().position(|byte| !is_word(byte)).map_or(bytes.len(), |length| at + length);
            drop(bytes.splice(begin..end, token.iter().copied()));
        }
    }
}

/// Tries the bytes in a folder; whether they were accepted.
type Try = Box<dyn Fn(&Path, &[u8]) -> bool>;

/// A reader: its name, files to begin with, and a try, which tells whether the bytes were accepted. The folder holds what the
/// files name.
struct Target {
    name: &'static str,
    seeds: Vec<Vec<u8>>,
    read: Try,
}

fn root(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

fn seeds(names: &[&str]) -> Vec<Vec<u8>> {
    names.iter().map(|name| fs::read(root(name)).unwrap_or_else(|error| panic!("{name}: {error}"))).collect()
}

/// Puts the bytes into a file of the folder.
fn file(folder: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.join(name);
    fs::write(&path, bytes).expect("written");
    path
}

/// Reads a study to its first scene.
fn study(folder: &Path, text: &str, points: &PointTable) -> bool {
    let Ok(study) = Study::parse(text, folder, "study.toml") else { return false };
    let Ok(study) = CheckedStudy::new(study, points.clone()) else { return false };
    // The last row has gone through every generator.
    [0, study.row_count() - 1].into_iter().all(|row| study.scene(row).is_ok())
}

fn studies() -> Target {
    let names = ["paper_rig", "placement", "pressure_grid", "three_hammers"].map(|name| format!("studies/{name}.toml"));
    let further = ["design.toml", "kinds.toml", "nodes.toml"].map(|name| format!("tests/data/fuzz/{name}"));
    let further = further.iter().map(String::as_str).chain(["src/assets/study_template.toml"]);
    let names: Vec<&str> = names.iter().map(String::as_str).chain(further).collect();
    let points = station_points().with_nodes("part", BodyNodes::new(&block(70e9)).expect("valid"));
    let read = move |folder: &Path, bytes: &[u8]| match std::str::from_utf8(bytes) {
        Ok(text) => study(folder, text, &points),
        Err(_) => Study::load(&file(folder, "study.toml", bytes)).is_ok(),
    };
    Target { name: "study", seeds: seeds(&names), read: Box::new(read) }
}

fn station_points() -> PointTable {
    let points = InterfacePoints::read(&root("src/assets/station/interface_points.csv")).expect("valid");
    points.iter().map(|point| (point.name.clone(), point.position_m)).collect()
}

/// A study whose first lines name the file `name`.
fn naming(name: &str, key: &str) -> String {
    let text = fs::read_to_string(root("tests/data/fuzz/kinds.toml")).expect("there");
    match key {
        "hammer" => text.replace("[hammer.a]\n", &format!("[hammer.a]\nfile = '{name}'\n")),
        _ => {
            let (before, after) = text.split_once("[design]").expect("design");
            let (_, factors) = after.split_once("[design.factor.x]").expect("factors");
            format!("{before}[design]\nkind = 'table'\nfile = '{name}'\n[design.factor.x]{factors}")
        }
    }
}

/// A file that a study names under a key.
fn named(name: &'static str, key: &'static str, seeds: Vec<Vec<u8>>) -> Target {
    let points = station_points();
    let text = naming(name, key);
    let read = move |folder: &Path, bytes: &[u8]| {
        file(folder, name, bytes);
        study(folder, &text, &points)
    };
    Target { name, seeds, read: Box::new(read) }
}

/// Parquet tables of other programs, packed in every way.
fn tables() -> Target {
    let names = ["duckdb", "pandas", "polars", "pyarrow_gzip", "pyarrow_lz4", "pyarrow_none", "pyarrow_zstd"];
    let names = names.map(|name| format!("tests/data/tables/{name}.parquet"));
    let points = station_points();
    let text = naming("table.parquet", "design").replace("design.factor.x]", "design.factor.position]");
    let (before, _) = text.split_once("[design.factor.y]").expect("factors");
    let text = before.to_owned();
    let read = move |folder: &Path, bytes: &[u8]| {
        file(folder, "table.parquet", bytes);
        study(folder, &text, &points)
    };
    Target { name: "tables", seeds: seeds(&names.each_ref().map(String::as_str)), read: Box::new(read) }
}

fn matrices(name: &'static str, format: MatrixFormat, files: &[&str], dofs: Option<&'static str>) -> Target {
    let names: Vec<String> = files.iter().map(|name| format!("tests/data/formats/{name}")).collect();
    let seeds = seeds(&names.iter().map(String::as_str).collect::<Vec<_>>());
    let read = move |folder: &Path, bytes: &[u8]| {
        let matrix = |name: &str| MatrixFile { path: folder.join("matrix"), name: name.to_owned() };
        file(folder, "matrix", bytes);
        let points = file(folder, "p.csv", b"name,role,x_m,y_m,z_m,node\nA,mount,0,0,0,11\nB,fixture,1,0,0,12\n");
        FeModel::read(&ModelFiles {
            format,
            units: Units::Si,
            stiffness: matrix("KAAX"),
            mass: matrix("MAAX"),
            damping: None,
            dofs: dofs.map(|name| root("tests/data/formats").join(name)),
            nodes: None,
            dofs_per_node: None,
            points,
        })
        .is_ok()
    };
    Target { name, seeds, read: Box::new(read) }
}

/// What the rows of CalculiX' matrices stand for.
fn dofs() -> Target {
    let read = |folder: &Path, bytes: &[u8]| {
        let matrix = |end: &str| MatrixFile {
            path: root("tests/data/formats").join(format!("tiny_ccxstyle.{end}")),
            name: String::new(),
        };
        FeModel::read(&ModelFiles {
            format: MatrixFormat::Calculix,
            units: Units::MillimetreTonneSecond,
            stiffness: matrix("sti"),
            mass: matrix("mas"),
            damping: None,
            dofs: Some(file(folder, "dofs", bytes)),
            nodes: None,
            dofs_per_node: None,
            points: file(folder, "p.csv", b"name,role,x_m,y_m,z_m,node\nA,mount,0,0,0,11\nB,fixture,1,0,0,12\n"),
        })
        .is_ok()
    };
    let names = ["tiny.dofmap", "tiny_ccxstyle.dof", "ccx_real_tiny.dof", "frame_cb_S1_f1000.pch"];
    let names = names.map(|name| format!("tests/data/formats/{name}"));
    Target { name: "dofs", seeds: seeds(&names.each_ref().map(String::as_str)), read: Box::new(read) }
}

/// A dataset of a sweep that was killed: with parts, if it has any, and a journal.
fn killed_sweep(folder: &Path) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_decore"));
    command.arg("run").arg(root("studies/placement.toml")).args(["--stub-row-ms", "20", "--threads", "1"]);
    command.arg("--output").arg(folder).stdout(Stdio::null()).stderr(Stdio::null());
    let mut child = command.spawn().expect("decore runs");
    let written = || {
        let rows = journal(folder).and_then(|path| fs::read(path).ok());
        rows.is_some_and(|bytes| bytes.iter().skip(4000).any(|byte| *byte != 0))
    };
    while !written() {
        assert!(child.try_wait().expect("known").is_none(), "the sweep ended before it was killed");
        std::thread::sleep(Duration::from_millis(20));
    }
    child.kill().expect("killed");
    child.wait().expect("ended");
}

/// The file of the journal that holds rows; beside it lies the description of its study.
fn journal(folder: &Path) -> Option<PathBuf> {
    let files = fs::read_dir(folder.join(".journal")).into_iter().flatten().flatten().map(|entry| entry.path());
    files.into_iter().find(|path| path.extension().is_some_and(|ending| ending == "rows"))
}

/// A file of a dataset, read as `status` and the report read it.
fn dataset(name: &'static str, dataset: &Path, place: PathBuf) -> Target {
    let (folder, seed) = (dataset.to_owned(), fs::read(&place).expect("there"));
    // Mapped zeros at the end of a journal say nothing.
    let length = seed.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
    let whole = seed.clone();
    let read = move |_: &Path, bytes: &[u8]| {
        fs::write(&place, bytes).expect("written");
        let status = SweepStatus::read(&folder).is_ok();
        let visited = DatasetReader::open(&folder).and_then(|reader| {
            Columns::new(&reader.manifest().study)?;
            reader.visit(TableName::Runs, &["row"], |_| {})
        });
        // The other targets of this dataset find it whole.
        fs::write(&place, &whole).expect("written");
        status && visited.is_ok()
    };
    Target { name, seeds: vec![seed[..length].to_vec()], read: Box::new(read) }
}

fn targets(folder: &Path) -> Vec<Target> {
    let points = |folder: &Path, bytes: &[u8]| InterfacePoints::read(&file(folder, "points.csv", bytes)).is_ok();
    let modes = |folder: &Path, bytes: &[u8]| ModalTable::read(&file(folder, "modes.csv", bytes)).is_ok();
    let measured = |folder: &Path, bytes: &[u8]| read_measured(&file(folder, "frf.uff", bytes)).is_ok();
    let structure =
        |folder: &Path, bytes: &[u8]| matches!(load_structure(&file(folder, "machine.toml", bytes)), Ok(Some(_)));
    let machine = b"[structure]\nsource = \"matrices\"\nformat = \"matrix_market\"\nstiffness_file = \"points.csv\"\nmass_file = \
                    \"points.csv\"\npoints_file = \"points.csv\"\ndamping_ratio = 0.02\n[structure.rails]\nr = [\"A\", \"B\"]\n";
    let mut design = Command::new(env!("CARGO_BIN_EXE_decore"));
    design.arg("design").arg(root("tests/data/fuzz/kinds.toml")).args(["--set", "design.rows=40", "--output"]);
    let rows = folder.join("seed.parquet");
    assert!(design.arg(&rows).stdout(Stdio::null()).status().expect("decore runs").success());
    let sweep = folder.join("sweep");
    killed_sweep(&sweep);
    let journal = journal(&sweep).expect("a file");
    let names = |format, files: &[&str], dofs| matrices(format, format_of(format), files, dofs);
    vec![
        studies(),
        named("hammer.toml", "hammer", seeds(&["studies/hammers/default.toml"])),
        Target { name: "structure", seeds: vec![machine.to_vec()], read: Box::new(structure) },
        Target {
            name: "points",
            seeds: seeds(&[
                "tests/data/fuzz/points.csv",
                "tests/data/fuzz/point_nodes.csv",
                "src/assets/station/interface_points.csv",
            ]),
            read: Box::new(points),
        },
        Target {
            name: "modes",
            seeds: seeds(&["tests/data/fuzz/modes.csv", "tests/data/foreign/modes_55.uff"]),
            read: Box::new(modes),
        },
        named("rows.csv", "design", seeds(&["tests/data/fuzz/rows.csv"])),
        named("rows.parquet", "design", vec![fs::read(rows).expect("there")]),
        tables(),
        names("matrix_market", &["tiny_K.mtx", "tiny_M.mtx"], Some("tiny.dofmap")),
        names("calculix", &["tiny_ccxstyle.sti", "ccx_real_tiny.sti"], Some("tiny_ccxstyle.dof")),
        names(
            "dmig",
            &["tiny_dmig_large.bdf", "tiny_dmig_small.bdf", "tiny_nastranstyle.pch", "frame_cb_S1_f1000.pch"],
            None,
        ),
        names("op4", &["tiny_ascii_d.op4", "tiny_ascii_sparse.op4", "tiny_binary_handmade.op4"], Some("tiny.dofmap")),
        names("harwell_boeing", &["tiny_hbstyle_K.matrix", "tiny_hbstyle_M.matrix"], Some("tiny.dofmap")),
        names(
            "abaqus",
            &[
                "tiny_abaqusstyle_STIF1_coordinate.mtx",
                "tiny_abaqusstyle_STIF1_matrixinput.mtx",
                "tiny_user_element.mtx",
                "ccx_superelement.mtx",
            ],
            None,
        ),
        names("npz", &["tiny_K_csr.npz", "tiny_M_csc.npz", "tiny_K_coo.npz"], Some("tiny.dofmap")),
        Target {
            name: "measured",
            seeds: seeds(&["tests/data/foreign/solid_text.uff", "tests/data/foreign/solid_binary.uff"]),
            read: Box::new(measured),
        },
        dofs(),
        dataset("manifest", &sweep, sweep.join("manifest.json")),
        dataset("journal", &sweep, journal),
    ]
}

fn format_of(name: &str) -> MatrixFormat {
    serde_json::from_value(name.into()).expect("a format")
}

/// What became of a reader's inputs.
#[derive(Default)]
struct Tally {
    inputs: u64,
    accepted: u64,
    slowest: Duration,
    largest: i64,
    faults: Vec<String>,
}

/// Tries a mutated input.
fn attempt(target: &Target, folder: &Path, bytes: &[u8], tally: &mut Tally) {
    let weighed = || {
        let before = LIVE.get();
        PEAK.set(before);
        let begin = ThreadTime::now();
        let result = catch_unwind(AssertUnwindSafe(|| (target.read)(folder, bytes)));
        (result, begin.elapsed(), PEAK.get() - before)
    };
    let (result, time, mut peak) = weighed();
    if peak > MOST_BYTES {
        // What a package sets aside once for a thread is there the second time: gemm's buffer, a gigabyte of addresses on a machine
        // with large caches, hardly any of which is ever touched.
        peak = (0..3).map(|_| weighed().2).fold(peak, i64::min);
    }
    tally.inputs += 1;
    tally.accepted += u64::from(matches!(result, Ok(true)));
    tally.slowest = tally.slowest.max(time);
    tally.largest = tally.largest.max(peak);
    let fault = match result {
        Err(_) => Some("panic"),
        Ok(_) if time > MOST_TIME => Some("time"),
        Ok(_) if peak > MOST_BYTES => Some("memory"),
        Ok(_) => None,
    };
    if let Some(fault) = fault {
        let kept = std::env::temp_dir().join(format!("decore-fuzz-{}-{fault}-{}", target.name, tally.faults.len()));
        let _ = fs::write(&kept, bytes);
        tally.faults.push(format!("{fault} ({time:?}, {peak} bytes): {}", kept.display()));
    }
}

#[test]
fn no_mutated_file_ends_in_a_panic_or_takes_more_than_its_share() {
    let number = |name: &str| std::env::var(name).ok().and_then(|text| text.parse::<u64>().ok());
    let folder = TempDir::new().expect("scratch folder");
    fs::create_dir(folder.path().join("hammers")).expect("folder");
    for (from, to) in
        [("studies/hammers/default.toml", "hammers/default.toml"), ("tests/data/fuzz/points.csv", "points.csv")]
    {
        fs::copy(root(from), folder.path().join(to)).expect("copied");
    }
    let targets = targets(folder.path());
    let only = std::env::var("DECORE_FUZZ_ONLY").ok();
    let chosen: Vec<&Target> = targets.iter().filter(|one| only.as_ref().is_none_or(|only| only == one.name)).collect();
    let each = number("DECORE_FUZZ").map_or(INPUTS, |all| all.div_ceil(chosen.len() as u64));
    let mut seed = [17; 32];
    seed[..8].copy_from_slice(&number("DECORE_FUZZ_SEED").unwrap_or(17).to_le_bytes());
    let mut runner = TestRunner::new_with_rng(Config::default(), TestRng::from_seed(RngAlgorithm::ChaCha, &seed));
    let strategy = (any::<prop::sample::Index>(), any::<prop::sample::Index>(), mutations());
    let mut faults = Vec::new();
    for target in chosen {
        let mut tally = Tally::default();
        for seed in &target.seeds {
            assert!(
                (target.read)(folder.path(), seed) || target.seeds.len() > 1,
                "{}: the seed is not accepted",
                target.name
            );
        }
        for _ in 0..each {
            let (seed, other, mutations) = strategy.new_tree(&mut runner).expect("a value").current();
            let mut bytes = target.seeds[seed.index(target.seeds.len())].clone();
            let other = &target.seeds[other.index(target.seeds.len())];
            mutations.into_iter().for_each(|mutation| mutate(&mut bytes, other, mutation));
            attempt(target, folder.path(), &bytes, &mut tally);
        }
        println!(
            "{:<15} {:>8} inputs, {:>7} accepted, slowest {:.3} s, largest {:.1} MB, {} faults",
            target.name,
            tally.inputs,
            tally.accepted,
            tally.slowest.as_secs_f64(),
            tally.largest as f64 / 1e6,
            tally.faults.len()
        );
        faults.extend(tally.faults.into_iter().map(|fault| format!("{}: {fault}", target.name)));
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

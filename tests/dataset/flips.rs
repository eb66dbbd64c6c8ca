//! One flipped bit in any file of a dataset: every verb gives the bytes of the whole dataset, or an error.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use decore::page::{MOST_ROWS, PageOf, dataset_page};
use decore_dataset::{DatasetReader, DatasetWriter, Existing, SweepStatus, verify};
use decore_lab::comparison::{ComparisonSettings, compare};
use decore_lab::features::{FeatureSettings, export};
use decore_lab::report::{Charts, Paper, ReportSettings, summarise};
use decore_lab::sensitivity::{SensitivitySettings, analyse};
use decore_lab::surrogate::{SurrogateSettings, fit, predict, read, write};
use decore_statistics::analysis::Bootstrap;
use decore_study::engine::{Engine, SweepSettings};
use tempfile::TempDir;

use crate::growth::{FACTORS, MACHINE};
use crate::sweeps::{decore, errors, expect_code};
use crate::synthetic::{self, contract, files, outcome, record};

/// Variable that sets the number of flips of the campaign.
const FLIPS: &str = "DECORE_FLIPS";

/// Result of a command on a dataset: bytes or an error message.
type Verb<'v> = (&'static str, Box<dyn Fn() -> Result<Vec<u8>, String> + 'v>);

fn flips(share: usize) -> usize {
    std::env::var(FLIPS).ok().and_then(|text| text.parse().ok()).unwrap_or(72) / share
}

fn words<E: ToString>(error: E) -> String {
    error.to_string()
}

fn open(folder: &Path) -> Result<DatasetReader, String> {
    DatasetReader::open(folder).map_err(words)
}

/// Summary, charts and the page.
fn report(folder: &Path) -> Result<Vec<u8>, String> {
    let (reader, settings) = (open(folder)?, ReportSettings::default());
    let summary = summarise(&reader, &settings).map_err(words)?;
    let charts = Charts::of(&reader, &summary).map_err(words)?.text(Paper { columns: None, blocks: false });
    let page = dataset_page(PageOf { reader: &reader, study: Err("") }, &settings, MOST_ROWS).map_err(words)?;
    Ok(format!("{summary:?}{charts}{page}").into_bytes())
}

fn features(folder: &Path, target: &Path) -> Result<Vec<u8>, String> {
    let settings = FeatureSettings { replace: true, ..FeatureSettings::default() };
    let exported = export(&open(folder)?, target, &settings).map_err(words)?;
    Ok(exported.files.iter().flat_map(|file| fs::read(file).expect("written")).collect())
}

/// All tables, as Python reads them.
fn tables(folder: &Path) -> Result<Vec<u8>, String> {
    let reader = open(folder)?;
    let mut text = String::new();
    for table in reader.tables() {
        for batch in reader.batches(table) {
            text += &format!("{:?}", batch.map_err(words)?.columns());
        }
    }
    Ok(text.into_bytes())
}

fn status(folder: &Path) -> Result<Vec<u8>, String> {
    let status = SweepStatus::read(folder).map_err(words)?;
    Ok(format!("{status:?}").into_bytes())
}

/// Takes wall times out, which differ from run to run.
fn without_times(found: &mut serde_json::Value) {
    if let Some(list) = found.as_array_mut() {
        list.iter_mut().for_each(without_times);
    }
    if let Some(keys) = found.as_object_mut() {
        keys.retain(|key, _| key != "wall_time_s");
        keys.values_mut().for_each(without_times);
    }
}

/// Flips bits of the files, one at a time, and runs all verbs on each. Returns how many flips each verb refused.
fn campaign(folder: &Path, count: usize, verbs: &[Verb<'_>]) -> BTreeMap<&'static str, usize> {
    let whole: Vec<Vec<u8>> =
        verbs.iter().map(|(name, verb)| verb().unwrap_or_else(|e| panic!("{name}: {e}"))).collect();
    assert_eq!(verify(folder).expect("read").faults.iter().filter(|fault| !fault.contains("in no part")).count(), 0);
    let origin = files(folder);
    let next =
        |state: &u64| Some(state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407));
    let mut random = std::iter::successors(Some(49), next).skip(1).map(|state| (state >> 33) as usize);
    let mut refused = BTreeMap::new();
    for number in 0..count {
        let (name, bytes) = origin.iter().nth(number % origin.len()).expect("a file");
        // Zeros behind the last row of a journal wait for rows.
        let written = bytes.iter().rposition(|byte| *byte != 0).map_or(1, |last| last + 1);
        let (at, bit) = (random.next().unwrap_or(0) % written, random.next().unwrap_or(0) % 8);
        let mut flipped = bytes.clone();
        flipped[at] ^= 1 << bit;
        fs::write(folder.join(name), flipped).expect("written");
        let what = format!("flip {number}: bit {bit} of byte {at} of {}", name.display());
        for ((verb, run), whole) in verbs.iter().zip(&whole) {
            match run() {
                Ok(found) => assert!(found == *whole, "{what}: `{verb}` gives other bytes, and no error"),
                Err(error) => {
                    assert!(!error.is_empty(), "{what}: `{verb}`");
                    *refused.entry(*verb).or_default() += 1;
                }
            }
        }
        let is_own = ["runs", "blows", "timings", "signals", "manifest.json", "timings.json"];
        if is_own.iter().any(|own| name.starts_with(own)) {
            let is_found = verify(folder).map_or(true, |found| !found.faults.is_empty());
            assert!(is_found, "{what}: `verify` finds nothing");
        }
        fs::write(folder.join(name), bytes).expect("restored");
    }
    println!("{count} flips over {} files; refused: {refused:?}", origin.len());
    refused
}

#[test]
fn no_verb_gives_other_figures() {
    let scratch = TempDir::new().expect("scratch folder");
    let [study, folder, copy, model, places] =
        ["study.toml", "out", "copy", "out/model.parquet", "rows.csv"].map(|name| scratch.path().join(name));
    let design = "[design]\nkind = \"latin_hypercube\"\nrows = 100\nseed = 3";
    fs::write(&study, format!("{MACHINE}\n{design}\n{FACTORS}")).expect("study");
    fs::write(&places, "position,pressure,guide\n0.01,4.5,tied\n-0.05,5.5,spring\n").expect("rows");
    for folder in [&folder, &copy] {
        let mut command = decore();
        command.arg("run").arg(&study).arg("--output").arg(folder).args(["--stub-row-ms", "0"]);
        expect_code(command, 0);
    }
    let outputs = vec!["delivered_work_j".to_owned()];
    let fitted = |folder: &Path| {
        let settings = SurrogateSettings { outputs: outputs.clone(), ..SurrogateSettings::default() };
        fit(&open(folder)?, &settings).map_err(words)
    };
    write(&fitted(&folder).expect("a model"), &model).expect("written");
    let bootstrap = Bootstrap { replicates: 0, ..SensitivitySettings::default().bootstrap };
    let settings = SensitivitySettings { outputs: outputs.clone(), bootstrap, ..SensitivitySettings::default() };
    let verbs: [Verb<'_>; 8] = [
        ("report", Box::new(|| report(&folder))),
        ("export", Box::new(|| features(&folder, &scratch.path().join("features")))),
        ("tables", Box::new(|| tables(&folder))),
        ("status", Box::new(|| status(&folder))),
        (
            "analyse",
            Box::new(|| {
                let found = analyse(&open(&folder)?, &settings).map_err(words)?;
                Ok(serde_json::to_vec(&found).expect("JSON"))
            }),
        ),
        (
            "surrogate",
            Box::new(|| {
                let target = scratch.path().join("again.parquet");
                write(&fitted(&folder)?, &target).map_err(words)?;
                Ok(fs::read(target).expect("written"))
            }),
        ),
        (
            "predict",
            Box::new(|| {
                let predicted = read(&model).and_then(|model| predict(&model, &places)).map_err(words)?;
                Ok(format!("{predicted:?}").into_bytes())
            }),
        ),
        (
            "compare",
            Box::new(|| {
                let found = compare(&open(&copy)?, &open(&folder)?, &ComparisonSettings::default()).map_err(words)?;
                assert!(found.is_same(), "{found:?}");
                Ok(serde_json::to_vec(&found).expect("JSON"))
            }),
        ),
    ];
    let refused = campaign(&folder, flips(2), &verbs);
    assert!(verbs.iter().all(|(name, _)| refused.get(name).is_some_and(|refused| *refused > 0)), "{refused:?}");
}

/// Rows that were simulated, with signals; a row that is run again is compared with the stored one.
#[test]
fn no_table_of_simulated_rows_gives_other_figures() {
    let scratch = TempDir::new().expect("scratch folder");
    let folder = scratch.path().join("out");
    let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/pressure_grid.toml");
    let settings = ["duration_s=0.12", "outputs.signals=[\"hammer_casting_force_n\"]", "outputs.signal_rows=[1, 4]"];
    let engine = Engine::load(&study, &settings.map(str::to_owned)).expect("a study");
    engine.run(&folder, &SweepSettings::default()).expect("run");
    let scene = || {
        let ended = decore().arg("scene").arg(&folder).args(["--row", "1", "--json"]).output().expect("decore runs");
        match ended.status.code() {
            Some(0) => {
                let mut found: serde_json::Value = serde_json::from_slice(&ended.stdout).expect("JSON");
                assert_eq!(found["stored_row"]["differences"].as_array().map(Vec::len), Some(0), "{found}");
                without_times(&mut found);
                Ok(found.to_string().into_bytes())
            }
            code => Err(format!("{code:?}: {}", errors(&ended))),
        }
    };
    let target = scratch.path().join("features");
    let mut verbs: Vec<Verb<'_>> = vec![
        ("report", Box::new(|| report(&folder))),
        ("export", Box::new(|| features(&folder, &target))),
        ("tables", Box::new(|| tables(&folder))),
    ];
    campaign(&folder, flips(4), &verbs);
    verbs.push(("scene", Box::new(scene)));
    let refused = campaign(&folder, flips(8), &verbs);
    assert!(verbs.iter().all(|(name, _)| refused.get(name).is_some_and(|refused| *refused > 0)), "{refused:?}");
}

/// A sweep that was stopped: what it gives when it goes on is what it would have given.
#[test]
fn no_stopped_sweep_goes_on_to_other_figures() {
    let scratch = TempDir::new().expect("scratch folder");
    let [stopped, whole, again] = ["stopped", "whole", "again"].map(|name| scratch.path().join(name));
    synthetic::write(&whole, 2);
    let mut writer = DatasetWriter::create(&stopped, &synthetic::info(), Existing::Refuse).expect("created");
    (0..100).for_each(|row| writer.write(&record(row, outcome(row))).expect("taken"));
    drop(writer);
    let resume = || -> Result<BTreeMap<PathBuf, Vec<u8>>, String> {
        let _ = fs::remove_dir_all(&again);
        for (name, bytes) in files(&stopped) {
            let path = again.join(name);
            fs::create_dir_all(path.parent().expect("a folder")).expect("folder");
            fs::write(path, bytes).expect("copied");
        }
        let mut writer = DatasetWriter::create(&again, &synthetic::info(), Existing::Resume).map_err(words)?;
        let left = writer.rows_left();
        for row in left.iter().flat_map(|span| span.first..span.end) {
            writer.write(&record(row, outcome(row))).map_err(words)?;
        }
        writer.finish().map_err(words)?;
        let mut found = contract(&again);
        found.retain(|name, _| !name.starts_with(".damaged"));
        Ok(found)
    };
    assert!(resume().expect("resumed") == contract(&whole));
    let verbs: [Verb<'_>; 2] = [
        ("run", Box::new(|| Ok(resume()?.into_values().flatten().collect()))),
        ("tables", Box::new(|| tables(&stopped))),
    ];
    let refused = campaign(&stopped, flips(4), &verbs);
    assert!(!refused.contains_key("run"), "a sweep mends what is damaged: {refused:?}");
}

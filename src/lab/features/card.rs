//! Card of a table for human readers: contents, origin and cautions.

use std::fmt::Write;

use super::column::{FeatureColumn, Role};
use super::croissant::Described;
use super::settings::FeatureSettings;
use super::table::Features;
use decore_dataset::Manifest;
use decore_model::run::{RowOutcome, RowStatus};

/// The card as Markdown.
pub(super) fn card(
    manifest: &Manifest,
    (features, settings): (&Features, &FeatureSettings),
    files: &[Described],
) -> String {
    let sections = [
        head(manifest, features),
        written(files),
        provenance(manifest, settings),
        outcomes(manifest, features),
        columns(&features.columns),
        cautions(features),
        study(manifest),
    ];
    sections.join("\n")
}

const CAUTIONS: &str = "\
## To mind

- Train on rows whose `status` is `done`; rows of other runs are there so that their share is known, with nulls for what was not computed.
- A column with the role `target` or `scatter` is a result. Factors are what a predictor may know. Columns that follow from others by
  arithmetic are listed above and in the dictionary (`derived_from`).
- Rows with one `group_id` belong in one part of a split, the castings of one run always do.
- All figures are simulated; the limits of the model are those that `decore help limits` prints.
";

fn cautions(features: &Features) -> String {
    let signals = match features.signal_interval_s {
        Some(interval_s) => format!(
            "Root mean squares in bands and accelerations are of means of the heave velocity over {interval_s} s; runs whose signals were \
             not kept have nulls there."
        ),
        None => "Accelerations and root mean squares in bands need the means of a casting's heave velocity, which the dataset does not \
                 hold (`decore help features`)."
            .to_owned(),
    };
    format!("{CAUTIONS}- {signals}\n- Licence and citation are the owner's to add.\n")
}

fn head(manifest: &Manifest, features: &Features) -> String {
    let rows = features.columns.first().map_or(0, |column| column.values.count);
    format!(
        "# {}\n\nA flat table of simulated pneumatic de-coring: {rows} rows, one per run and casting, {} columns.\n",
        manifest.study.study_name,
        features.columns.len()
    )
}

fn written(files: &[Described]) -> String {
    let mut text = "## Files\n\n| file | bytes | SHA-256 |\n|---|---|---|\n".to_owned();
    for Described { name, bytes, sha256 } in files {
        _ = writeln!(text, "| `{name}` | {bytes} | `{sha256}` |");
    }
    text + "\n`croissant.json` describes them for loaders (Croissant 1.0), `dictionary.json` and `dictionary.csv` every column.\n"
}

fn provenance(manifest: &Manifest, settings: &FeatureSettings) -> String {
    let info = &manifest.study;
    let mut text = "## Provenance\n\n| | |\n|---|---|\n".to_owned();
    let mut line = |name: &str, value: String| _ = writeln!(text, "| {name} | {value} |");
    line("program", format!("decore {}", info.program_version));
    line("study hash", format!("`{}`", info.study_hash));
    line("seed of the design", info.seed.to_string());
    for setting in &info.overrides {
        line("set over the study", format!("`{setting}`"));
    }
    for (name, hash) in &info.inputs {
        line("BLAKE3 of an input", format!("{name}: `{hash}`"));
    }
    for (name, value) in &info.settings {
        line("setting", format!("{name}: {value}"));
    }
    line("threshold of the dose", format!("{} J", settings.dose_threshold_j));
    if let Some(work_j) = settings.work_j {
        line("work whose time is a column", format!("{work_j} J"));
    }
    text
}

fn outcomes(manifest: &Manifest, features: &Features) -> String {
    let castings = manifest.study.castings.len().max(1);
    let status = features.columns.iter().find(|column| column.name == RowOutcome::status.name);
    let ended = |wanted: RowStatus| {
        let rows = status.map_or(0, |column| column.values.count);
        let is_so = |row: &usize| status.is_some_and(|column| column.values.text(*row) == wanted.name());
        (0..rows).filter(is_so).count() / castings
    };
    let mut text = format!("## Runs\n\nThe design has {} runs, {} are there:\n\n", manifest.study.rows, features.runs);
    text += "| status | runs |\n|---|---|\n";
    for status in RowStatus::ALL {
        _ = writeln!(text, "| `{}` | {} |", status.name(), ended(status));
    }
    text
}

fn columns(columns: &[FeatureColumn]) -> String {
    let mut text = "## Columns\n\n| role | columns |\n|---|---|\n".to_owned();
    for role in Role::ALL {
        let names: Vec<String> =
            columns.iter().filter(|column| column.role == role).map(|column| format!("`{}`", column.name)).collect();
        if !names.is_empty() {
            _ = writeln!(text, "| {} | {} |", role.name(), names.join(", "));
        }
    }
    let derived = columns.iter().filter(|column| !column.derived_from.is_empty());
    let lines: Vec<String> = derived
        .map(|column| format!("- `{}` follows from {}\n", column.name, column.derived_from.join(", ")))
        .collect();
    if !lines.is_empty() {
        text += &format!("\nColumns that follow from others by arithmetic:\n\n{}", lines.concat());
    }
    text
}

/// The study's text, indented: it may hold any marks of Markdown.
fn study(manifest: &Manifest) -> String {
    let lines: Vec<String> =
        manifest.study.study_text.lines().map(|line| format!("    {line}").trim_end().to_owned()).collect();
    format!("## The study\n\n{}\n", lines.join("\n"))
}

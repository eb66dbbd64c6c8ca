//! Checks a manifest for consistency: parts under their own names, in order, each once, with all rows of the manifest.

use std::path::Path;

use super::columns::TableName;
use super::error::DatasetError;
use super::manifest::{MANIFEST_NAME, Manifest, RowSpan, TIMINGS_NAME, TablePart, TimingsManifest, part_file};

/// Refuses manifests whose parts are listed twice, leave a gap, do not have the name of their block, or do not add up to the existing rows.
///
/// # Errors
/// [`DatasetError::Damaged`].
pub fn check_manifests(folder: &Path, manifest: &Manifest, timings: &TimingsManifest) -> Result<(), DatasetError> {
    let fault = |name: &str, (found, expected): (String, &str)| DatasetError::Damaged {
        path: folder.join(name),
        found,
        expected: expected.to_owned(),
    };
    let tables = [
        (TableName::Runs, &manifest.runs, MANIFEST_NAME),
        (TableName::Blows, &manifest.blows, MANIFEST_NAME),
        (TableName::Signals, &manifest.signals, MANIFEST_NAME),
        (TableName::Timings, &timings.timings, TIMINGS_NAME),
    ];
    for (table, parts, name) in tables {
        check_parts(manifest, table, parts).map_err(|words| fault(name, words))?;
    }
    check_rows(manifest).map_err(|words| fault(MANIFEST_NAME, words))
}

/// Found and expected values.
type Words = (String, &'static str);

/// Compares the parts of a table with each other and with the parts of the runs.
fn check_parts(manifest: &Manifest, table: TableName, parts: &[TablePart]) -> Result<(), Words> {
    for part in parts {
        let is_block = part.first_row.checked_rem(manifest.study.rows_per_part) == Some(0);
        if !is_block || part.file != part_file(table, part.first_row) {
            return Err((
                format!("the part `{}` for the rows from {}", part.file, part.first_row),
                "the part of a block under its own name",
            ));
        }
    }
    if !parts.is_sorted_by(|one, next| one.first_row < next.first_row) {
        return Err((
            format!("parts of {} twice or out of order", table.folder()),
            "every part once, by its first row",
        ));
    }
    let is_optional = table == TableName::Timings || (table == TableName::Signals && manifest.study.signals.is_empty());
    let blocks = |parts: &[TablePart]| parts.iter().map(|part| part.first_row).collect::<Vec<u64>>();
    if !is_optional && blocks(parts) != blocks(&manifest.runs) {
        return Err((format!("{} parts of {}", parts.len(), table.folder()), "one for each part of `runs`"));
    }
    Ok(())
}

/// Compares the existing rows with the parts of the runs.
fn check_rows(manifest: &Manifest) -> Result<(), Words> {
    let Manifest { done, range, runs, .. } = manifest;
    let is_ascending = done.is_sorted_by(|one, next| one.end <= next.first);
    let is_within = |span: &RowSpan| !span.is_empty() && span.intersection(*range) == *span;
    if !is_ascending || !done.iter().all(is_within) {
        return Err((
            "rows twice or outside the dataset's range".to_owned(),
            "spans of rows that ascend, within `range`",
        ));
    }
    for part in runs {
        let block = manifest.block(part.first_row);
        let from = done.partition_point(|span| span.end <= block.first);
        let spans = done.iter().skip(from).take_while(|span| span.first < block.end);
        let rows = total(spans.map(|span| span.intersection(block).len()));
        if rows != part.records || part.failed > rows {
            let found = format!("the part `{}` with {} rows, {} of them failed", part.file, part.records, part.failed);
            return Err((found, "as many rows as are done in its block"));
        }
    }
    let (listed, rows) = (total(runs.iter().map(|part| part.records)), total(done.iter().map(|span| span.len())));
    if listed != rows || rows != manifest.rows_done || manifest.complete != (rows == range.len()) {
        let found = format!("parts with {listed} rows, {rows} rows in spans, `rows_done` {}", manifest.rows_done);
        return Err((found, "the same number, and `complete` if the dataset has all its rows"));
    }
    Ok(())
}

fn total(counts: impl Iterator<Item = u64>) -> u64 {
    counts.fold(0, u64::saturating_add)
}

#[cfg(test)]
mod tests {
    use super::super::info::DatasetInfo;
    use super::super::manifest::BlockFiles;
    use super::*;

    fn part(table: TableName, first_row: u64, records: u64) -> TablePart {
        let file = part_file(table, first_row);
        TablePart { file, first_row, records, failed: 0, bytes: 0, blake3: String::new() }
    }

    /// Rows 0 to 9 in blocks of 4, without rows 5 to 7.
    fn manifest() -> Manifest {
        let info = DatasetInfo { rows: 10, rows_per_part: 4, ..DatasetInfo::empty() };
        let mut manifest = Manifest::new(info, RowSpan { first: 0, end: 10 });
        for (rows, first_row) in [(0..4, 0), (4..5, 4), (8..10, 8)] {
            let runs = part(TableName::Runs, first_row, rows.end - rows.start);
            manifest.put_block(rows, BlockFiles { runs, blows: part(TableName::Blows, first_row, 7), signals: None });
        }
        manifest
    }

    #[test]
    fn manifests_that_contradict_themselves_are_refused_with_words() {
        let check = |change: &dyn Fn(&mut Manifest, &mut TimingsManifest)| {
            let (mut manifest, mut timings) = (manifest(), TimingsManifest::default());
            timings.put(part(TableName::Timings, 4, 1));
            change(&mut manifest, &mut timings);
            check_manifests(Path::new("data"), &manifest, &timings).map_err(|error| error.to_string())
        };
        assert_eq!(check(&|_, _| ()), Ok(()));
        type Change<'c> = &'c dyn Fn(&mut Manifest, &mut TimingsManifest);
        let cases: [(Change<'_>, &str); 11] = [
            (&|manifest, _| manifest.runs.push(part(TableName::Runs, 8, 2)), "runs twice"),
            (&|manifest, _| manifest.runs.swap(0, 1), "out of order"),
            (&|manifest, _| _ = manifest.blows.pop(), "2 parts of blows"),
            (&|manifest, _| manifest.runs[1].file = "../runs-000000000004.parquet".to_owned(), "under its own name"),
            (&|manifest, _| manifest.runs[1] = part(TableName::Runs, 5, 1), "the rows from 5"),
            (&|manifest, _| manifest.runs[1].records = 2, "with 2 rows"),
            (&|manifest, _| manifest.runs[1].failed = 2, "2 of them failed"),
            (&|manifest, _| manifest.done[0].end = 11, "outside the dataset's range"),
            (&|manifest, _| manifest.done.swap(0, 1), "rows twice"),
            (&|manifest, _| manifest.rows_done = 9, "`rows_done` 9"),
            (&|_, timings| timings.timings[0].file = "timings/copy.parquet".to_owned(), "timings.json"),
        ];
        for (change, words) in cases {
            let error = check(change).expect_err(words);
            assert!(error.contains(words), "{words}: {error}");
        }
        let complete = check(&|manifest, _| manifest.complete = true).expect_err("not complete");
        assert!(complete.contains("manifest.json") && complete.contains("`complete`"), "{complete}");
        let gone = check(&|manifest, _| {
            manifest.runs.remove(1);
            manifest.blows.remove(1);
        });
        assert!(gone.expect_err("a gap").contains("parts with 6 rows, 7 rows in spans"));
    }
}

//! The page of a dataset: its bytes, and the data that can be read back from it.

use std::path::Path;

use crate::synthetic::{ROWS, dataset, described, info, record, write};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use decore::page::{MOST_ROWS, PageOf, dataset_page};
use decore_dataset::{DatasetReader, DatasetWriter, Existing, TableName};
use decore_lab::report::ReportSettings;
use decore_quantity::Value;
use serde_json::Value as Json;
use tempfile::TempDir;

fn page_of(folder: &Path, most_rows: u64) -> String {
    let reader = DatasetReader::open(folder).expect("opened");
    dataset_page(PageOf { reader: &reader, study: Err("") }, &ReportSettings::default(), most_rows).expect("page")
}

/// The text of the page's element with this `id`.
fn block<'a>(page: &'a str, id: &str) -> &'a str {
    let start = page.split_once(&format!("id=\"{id}\">")).expect("element").1;
    start.split_once("</script>").expect("its end").0
}

/// What the page says of its data, and the data.
fn parts(page: &str) -> (Json, Vec<u8>) {
    let meta = serde_json::from_str(block(page, "meta")).expect("JSON");
    (meta, STANDARD.decode(block(page, "data")).expect("base64"))
}

/// The values of a column of numbers as the page has them.
fn numbers((meta, data): &(Json, Vec<u8>), name: &str) -> Vec<f64> {
    let column = meta["columns"].as_array().expect("columns").iter().find(|column| column["name"] == name).expect(name);
    assert_eq!(column["form"], "f64", "{name}");
    let start = column["offset"].as_u64().expect("offset") as usize;
    let rows = meta["rows_shown"].as_u64().expect("rows") as usize;
    let words = data[start..start + 8 * rows].chunks_exact(8);
    words.map(|word| f64::from_le_bytes(word.try_into().expect("eight bytes"))).collect()
}

#[test]
fn a_page_depends_on_the_dataset_alone() {
    let scratch = TempDir::new().expect("scratch folder");
    let (one, other) = (scratch.path().join("one"), scratch.path().join("in/another place"));
    write(&one, 1);
    std::fs::create_dir_all(&other).expect("folder");
    write(&other, 2);
    let page = page_of(&one, MOST_ROWS);
    assert_eq!(page, page_of(&other, MOST_ROWS));
    let path = scratch.path().to_str().expect("path");
    assert!(!page.contains(path), "the page names a folder of this machine");
    // Eight bytes a number, in base64: what is beside them does not grow with the rows.
    let (meta, data) = parts(&page);
    let columns = meta["columns"].as_array().expect("columns").len();
    assert!(data.len() <= columns * (8 * ROWS as usize + 8), "{} bytes of {columns} columns", data.len());
    let known: usize = ["sensitivity", "models"].iter().map(|name| meta[*name].to_string().len()).sum();
    assert!(
        known < 60_000 && page.len() < data.len() * 4 / 3 + 60_000 + 900 * columns + known,
        "{} bytes for {ROWS} rows",
        page.len()
    );
}

/// The name of SVG's namespace is the only address; nothing loads anything.
#[test]
fn a_page_asks_no_network() {
    let (_scratch, folder) = dataset();
    let page = page_of(&folder, MOST_ROWS).replace("http://www.w3.org/2000/svg", "");
    for loads in
        ["http:", "https:", "//www", "src=", "url(", "@import", "fetch(", "XMLHttpRequest", "WebSocket", "<link"]
    {
        assert!(!page.contains(loads), "{loads}");
    }
    assert!(page.contains("default-src 'none'"));
}

#[test]
fn values_of_a_page_equal_the_table() {
    let (_scratch, folder) = dataset();
    let parts = parts(&page_of(&folder, MOST_ROWS));
    let (meta, _) = &parts;
    assert_eq!((meta["rows_there"].as_u64(), meta["rows_shown"].as_u64()), (Some(ROWS), Some(ROWS)));
    assert_eq!(meta["notes"], Json::Array(Vec::new()));
    let reader = DatasetReader::open(&folder).expect("opened");
    let mut compared = 0;
    for column in reader.columns(TableName::Runs).iter().filter(|column| !column.kind.is_text()) {
        let mut table = Vec::new();
        reader
            .visit(TableName::Runs, &[&column.name], |cells| {
                table.push(cells[0].and_then(|value| value.number()).map(f64::to_bits));
            })
            .expect("read");
        let page: Vec<Option<u64>> = numbers(&parts, &column.name)
            .into_iter()
            .map(|value| Some(value).filter(|value| !value.is_nan()).map(f64::to_bits))
            .collect();
        assert_eq!(page, table, "{}", column.name);
        compared += 1;
    }
    assert!(compared > 50, "{compared} columns");
}

#[test]
fn texts_of_a_page_are_codes_into_names() {
    let (_scratch, folder) = dataset();
    let (meta, data) = parts(&page_of(&folder, MOST_ROWS));
    let columns = meta["columns"].as_array().expect("columns");
    let names = |name: &str| {
        let column = columns.iter().find(|column| column["name"] == name).expect(name);
        assert_eq!(column["form"], "u8");
        let start = column["offset"].as_u64().expect("offset") as usize;
        let names = column["names"].as_array().expect("names");
        let named = |code: &u8| names.get(usize::from(*code)).and_then(Json::as_str).unwrap_or("").to_owned();
        data[start..start + ROWS as usize].iter().map(named).collect::<Vec<String>>()
    };
    let (status, reason) = (names("status"), names("reason"));
    for row in 0..ROWS as usize {
        let invalid = row % 7 == 3;
        assert_eq!(status[row], if invalid { "invalid" } else { "done" });
        assert_eq!(reason[row], if invalid { "hammer `left` misses its casting" } else { "" });
    }
    assert_eq!(meta["reasons"], serde_json::json!([["hammer `left` misses its casting", 21]]));
}

/// Of many rows the page has about as many as it may, the extremes of each column among them, and says so.
#[test]
fn a_thinned_page_keeps_the_extremes() {
    let scratch = TempDir::new().expect("scratch folder");
    let rows = 3000;
    let info = decore_dataset::DatasetInfo { rows, ..info() };
    let mut writer = DatasetWriter::create(scratch.path(), &info, Existing::Refuse).expect("created");
    for row in 0..rows {
        writer.write(&record(row, crate::synthetic::outcome(row))).expect("written");
    }
    writer.finish().expect("finished");
    let parts = parts(&page_of(scratch.path(), 500));
    let kept = numbers(&parts, "row");
    // Columns whose values are those of few rows have their extremes in common.
    assert!((450..1500).contains(&kept.len()), "{} rows", kept.len());
    assert!(kept.windows(2).all(|pair| pair[0] < pair[1]), "in the table's order");
    let work = numbers(&parts, "delivered_work_j");
    let largest = (0..rows).rev().filter(|row| row % 7 != 3).take(20).map(|row| row as f64);
    for row in largest.chain([0.0, 1.0, 2.0, 20.0]) {
        assert!(work.contains(&row), "the row with the work {row}");
    }
    let note = parts.0["notes"][0].as_str().expect("note");
    assert!(note.contains(&format!("shows {} of 3000 rows", kept.len())), "{note}");
}

/// Names from files of others are data: they end no element and begin none.
#[test]
fn names_of_a_page_are_text() {
    let scratch = TempDir::new().expect("scratch folder");
    let name = "</script><img onerror=\"alert('Ω')\"> & <!-- <script>";
    let mut info = info();
    info.study_name = name.to_owned();
    info.study_text = name.to_owned();
    info.factors[2].name = name.to_owned();
    let info = described(info);
    let mut writer = DatasetWriter::create(scratch.path(), &info, Existing::Refuse).expect("created");
    let mut first = record(0, crate::synthetic::outcome(0));
    first.factors[2] = Value::Text(name.to_owned());
    writer.write(&first).expect("written");
    writer.finish().expect("finished");
    let page = page_of(scratch.path(), MOST_ROWS);
    assert!(!page.contains("<img") && !page.contains("<!--"));
    assert_eq!(page.matches("<script").count(), page.matches("</script>").count());
    assert_eq!(page.matches("</script>").count(), 3);
    let (meta, _) = parts(&page);
    assert_eq!((meta["title"].as_str(), meta["study_text"].as_str()), (Some(name), Some(name)));
    let columns = meta["columns"].as_array().expect("columns");
    assert!(columns.iter().any(|column| column["subject"] == name && column["names"][0] == name));
}

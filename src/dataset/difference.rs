//! Differences between the study of a dataset and the study to run.

use std::collections::BTreeMap;

use super::info::{DatasetInfo, RETRIES};

/// Most differences that are listed one by one.
const LISTED: usize = 12;

/// Whether both have the same columns, or an older program did not record its columns.
pub fn has_same_columns(one: &DatasetInfo, other: &DatasetInfo) -> bool {
    [&one.columns_hash, &other.columns_hash].iter().any(|hash| hash.is_empty())
        || one.columns_hash == other.columns_hash
}

/// Whether rows of both go into one dataset: titles, comments and layout do not count.
pub fn is_same_study(one: &DatasetInfo, other: &DatasetInfo) -> bool {
    let key = |info: &DatasetInfo| {
        let DatasetInfo { study_hash, seed, program_version, rows, rows_per_part, .. } = info.clone();
        (study_hash, seed, program_version, rows, rows_per_part, info.inputs.clone(), info.settings.clone())
    };
    key(one) == key(other) && has_same_columns(one, other)
}

/// Key of everything that determines a study's rows.
pub type StudyKey = [u8; 16];

/// The key of a study: titles, comments and layout do not count.
pub fn study_key(info: &DatasetInfo) -> StudyKey {
    let DatasetInfo { study_hash, seed, program_version, columns_hash, rows, rows_per_part, inputs, settings, .. } =
        info;
    let numbers = [*seed, *rows, *rows_per_part];
    let texts = [study_hash, program_version, columns_hash];
    // Length by length, so that no two lists of texts give the same bytes.
    let mut bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
    for text in texts.into_iter().chain(inputs.iter().chain(settings).flat_map(|(name, value)| [name, value])) {
        bytes.extend((text.len() as u64).to_le_bytes());
        bytes.extend(text.as_bytes());
    }
    let mut key = StudyKey::default();
    key.iter_mut().zip(blake3::hash(&bytes).as_bytes()).for_each(|(key, byte)| *key = *byte);
    key
}

/// Settings outside the study that are budgets of a row.
const BUDGETS: [&str; 1] = [RETRIES];

/// Whether two studies differ only in the budgets of a row.
pub fn is_same_but_budgets(one: &DatasetInfo, other: &DatasetInfo) -> bool {
    let without_budgets = |info: &DatasetInfo| {
        let mut info = DatasetInfo { study_hash: info.budget_free_hash.clone(), ..info.clone() };
        info.settings.retain(|name, _| !BUDGETS.contains(&name.as_str()));
        info
    };
    !one.budget_free_hash.is_empty() && is_same_study(&without_budgets(one), &without_budgets(other))
}

/// The differences from `before` to `now`, one sentence each; empty if they are of one study.
pub fn differences(before: &DatasetInfo, now: &DatasetInfo) -> Vec<String> {
    if is_same_study(before, now) {
        return Vec::new();
    }
    let mut found = keyed("", &study_values(&before.study_text), &study_values(&now.study_text));
    if before.overrides != now.overrides {
        let words = |list: &[String]| if list.is_empty() { "none".to_owned() } else { list.join(", ") };
        found.push(format!("--set: {} -> {}", words(&before.overrides), words(&now.overrides)));
    }
    found.extend(keyed("contents of ", &before.inputs, &now.inputs));
    found.extend(keyed("--", &before.settings, &now.settings));
    let numbers = [
        ("seed", before.seed, now.seed),
        ("rows", before.rows, now.rows),
        ("rows per part", before.rows_per_part, now.rows_per_part),
    ];
    for (name, was, is) in numbers {
        // Report the key of the study that makes the difference.
        let key = format!("design.{name}");
        if was != is && !found.iter().any(|line| line.contains(&key)) {
            found.push(format!("{name}: {was} -> {is}"));
        }
    }
    if before.program_version != now.program_version {
        found.push(format!("version of decore: {} -> {}", before.program_version, now.program_version));
    }
    if !has_same_columns(before, now) {
        found.push("columns of the tables: this program has others".to_owned());
    }
    if found.is_empty() {
        found.push("values in a hammer file that the study names".to_owned());
    }
    if found.len() > LISTED {
        let more = found.len() - LISTED;
        found.truncate(LISTED);
        found.push(format!("and {more} more"));
    }
    found
}

fn keyed(prefix: &str, before: &BTreeMap<String, String>, now: &BTreeMap<String, String>) -> Vec<String> {
    let mut keys: Vec<&String> = before.keys().chain(now.keys()).collect();
    keys.sort();
    keys.dedup();
    let word = |value: Option<&String>| value.map_or_else(|| "absent".to_owned(), |value| short(value));
    let changed = keys.into_iter().filter(|key| before.get(*key) != now.get(*key));
    changed.map(|key| format!("{prefix}{key}: {} -> {}", word(before.get(key)), word(now.get(key)))).collect()
}

fn short(value: &str) -> String {
    const LONGEST: usize = 60;
    match value.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}...", value.get(..end).unwrap_or_default()),
        None => value.to_owned(),
    }
}

/// The values of a study's text by path; the title does not count.
fn study_values(text: &str) -> BTreeMap<String, String> {
    let mut values = BTreeMap::new();
    if let Ok(table) = text.parse::<toml::Table>() {
        flatten("", &toml::Value::Table(table), &mut values);
    }
    values.remove("title");
    values
}

fn flatten(path: &str, value: &toml::Value, values: &mut BTreeMap<String, String>) {
    let toml::Value::Table(table) = value else {
        values.insert(path.to_owned(), value.to_string());
        return;
    };
    for (key, value) in table {
        let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        flatten(&path, value, values);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn info(text: &str, hash: &str) -> DatasetInfo {
        DatasetInfo { study_text: text.to_owned(), study_hash: hash.to_owned(), ..DatasetInfo::empty() }
    }

    #[test]
    fn the_changed_value_is_named() {
        let before = info("title = 'a'\n[hammer.left]\nsupply_bar = 4.5\nmount = 'R3'\n", "1");
        let mut now = info("title = 'b'\n[hammer.left]\nsupply_bar = 5.0\n", "2");
        let expected = ["hammer.left.mount: \"R3\" -> absent", "hammer.left.supply_bar: 4.5 -> 5.0"];
        assert_eq!(differences(&before, &now), expected);
        now.study_text.clone_from(&before.study_text);
        assert_eq!(differences(&before, &now), ["values in a hammer file that the study names"]);
        now.study_hash.clone_from(&before.study_hash);
        now.inputs.insert("structure.mass_file (M.mtx)".to_owned(), "00ff".to_owned());
        now.settings.insert(RETRIES.to_owned(), "2".to_owned());
        now.overrides = vec!["duration_s=2".to_owned()];
        let expected = [
            "--set: none -> duration_s=2",
            "contents of structure.mass_file (M.mtx): absent -> 00ff",
            "--retries: absent -> 2",
        ];
        assert_eq!(differences(&before, &now), expected);
    }

    #[test]
    fn comments_and_titles_do_not_count() {
        assert!(differences(&info("title = 'a'", "1"), &info("title = 'b' # new", "1")).is_empty());
    }
}

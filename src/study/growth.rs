//! A study without its number of rows, or without the budgets of a row. A finished sweep continues with this study if rows are added, or
//! run again.

use super::document::path;
use super::file::{DesignEntry, PartEntry, StudyFile};
use super::hash::hash;
use super::loaded::Study;

/// Keys of a design and its parts that only set the number of rows.
const ROW_KEYS: [&str; 4] = ["rows", "grown_from", "trajectories", "base_points"];
/// See [`super::CheckedStudy::frame_hash`].
pub(super) fn frame_hash(study: &Study) -> String {
    let of_rows = study.file.of_rows();
    let typed = StudyFile { design: without_rows(&of_rows.design), ..of_rows };
    let mut tree = serde_json::to_value(&typed).unwrap_or_default();
    // Where only factors give a value, the first row's stands in, which more rows may change.
    let typed = study.typed.tree();
    let silent = study.plan.driven_paths().filter(|at| path::get(&typed, at).is_none());
    silent.for_each(|at| forget(&mut tree, at));
    let overrides = study.typed.overrides.iter().filter(|one| one.reaches_values() && !counts_rows(&one.path));
    hash(&(tree.to_string() + &study.plan.conversions()), overrides, (&[], &study.scenes.library))
}

fn without_rows(design: &DesignEntry) -> DesignEntry {
    let part = |part: &PartEntry| PartEntry {
        rows: None,
        grown_from: None,
        trajectories: None,
        base_points: None,
        ..part.clone()
    };
    DesignEntry {
        rows: None,
        grown_from: None,
        trajectories: None,
        base_points: None,
        part: design.part.iter().map(part).collect(),
        ..design.clone()
    }
}

/// Removes the value at a path.
fn forget(tree: &mut serde_json::Value, at: &[String]) {
    match (tree, at) {
        (serde_json::Value::Object(entries), [last]) => {
            entries.remove(last);
        }
        (serde_json::Value::Object(entries), [first, rest @ ..]) => {
            if let Some(inner) = entries.get_mut(first) {
                forget(inner, rest);
            }
        }
        _ => {}
    }
}

/// Whether a path is one of [`ROW_KEYS`] of the design or a part.
fn counts_rows(at: &[String]) -> bool {
    let inner = match at {
        [design, rest @ ..] if design == "design" => rest,
        _ => return false,
    };
    let key = match inner {
        [key] => key,
        [part, _, key] if part == "part" => key,
        _ => return false,
    };
    ROW_KEYS.contains(&key.as_str())
}

/// Keys of a study that only set the budgets of a row.
const BUDGET_KEYS: [[&str; 2]; 2] = [["solver", "max_steps"], ["solver", "max_wall_time_s"]];

/// See [`super::CheckedStudy::budget_free_hash`].
pub(super) fn budget_free_hash(study: &Study) -> String {
    let mut tree = serde_json::to_value(study.file.of_rows()).unwrap_or_default();
    BUDGET_KEYS.iter().for_each(|key| forget(&mut tree, &key.map(str::to_owned)));
    let overrides = study
        .typed
        .overrides
        .iter()
        .filter(|one| one.reaches_values() && !BUDGET_KEYS.iter().any(|key| one.path == *key));
    hash(&(tree.to_string() + &study.plan.conversions()), overrides, (&study.plan.files, &study.scenes.library))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_of_rows_are_told_from_others() {
        let counts = |text: &str| counts_rows(&path::split(text).expect("a path"));
        assert!(counts("design.rows") && counts("design.part.0.trajectories"));
        assert!(!counts("design.seed") && !counts("hammer.rows") && !counts("design.factor.rows"));
    }
}

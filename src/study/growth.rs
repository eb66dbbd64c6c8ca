//! What a study is but for its number of rows: by it a sweep that was finished goes on when rows are added.

use super::Study;
use super::file::{DesignEntry, PartEntry, StudyFile};
use crate::quantity::Value;

/// Keys of a design and its parts that only say how many rows there are.
const ROW_KEYS: [&str; 4] = ["rows", "grown_from", "trajectories", "base_points"];
/// Rows compared of designs that compute each row alone: those of one kind and seed do not start to differ later.
const COMPARED_ROWS: usize = 1 << 17;

impl Study {
    /// Hash (hex) as [`Study::hash`], but over all that is not the number of rows: a study of the same frame and the same
    /// first rows, see [`Study::rows_hash`], is this one with rows added or taken away.
    ///
    /// Left out are `rows`, `grown_from`, `trajectories` and `base_points` of the design and its parts, and the contents of a
    /// table of rows.
    pub fn frame_hash(&self) -> String {
        let typed = StudyFile { title: None, design: without_rows(&self.base.design), ..self.base.clone() };
        let mut tree = serde_json::to_value(&typed).unwrap_or_default();
        // Where only factors give a value, the first row's stands in, which more rows may change.
        self.filled.iter().for_each(|at| forget(&mut tree, at));
        let overrides = self.overrides.iter().filter(|one| !counts_rows(&one.path));
        self.hash_of(&tree.to_string(), overrides, &[])
    }

    /// Hash (hex) of the factors' values in the first `rows` rows, by which two studies of one frame are compared.
    ///
    /// Only the first 131072 rows count where every row is computed alone, see [`crate::design::Design::is_open`].
    pub fn rows_hash(&self, rows: usize) -> String {
        let compared = if self.design().is_open() { rows.min(COMPARED_ROWS) } else { rows };
        let mut hasher = blake3::Hasher::new();
        for row in 0..compared.min(self.row_count()) {
            for value in self.row_values(row) {
                match value {
                    Value::Real(value) => hasher.update(&value.to_bits().to_le_bytes()),
                    Value::Integer(value) => hasher.update(&value.to_le_bytes()),
                    Value::Count(value) => hasher.update(&value.to_le_bytes()),
                    Value::Text(text) => {
                        hasher.update(&(text.len() as u64).to_le_bytes());
                        hasher.update(text.as_bytes())
                    }
                };
            }
        }
        hasher.finalize().to_hex().to_string()
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::path;

    #[test]
    fn keys_of_rows_are_told_from_others() {
        let counts = |text: &str| counts_rows(&path::split(text).expect("a path"));
        assert!(counts("design.rows") && counts("design.part.0.trajectories"));
        assert!(!counts("design.seed") && !counts("hammer.rows") && !counts("design.factor.rows"));
    }
}

//! Groups of dependent rows of a design. A predictor trained on some rows of a group has partly seen the others.

use serde::{Deserialize, Serialize};

/// Reason why rows belong together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GroupKind {
    /// They lie on one trajectory of a Morris design: neighbours differ in one factor alone.
    Trajectory,
    /// They mix the coordinates of one base point of Saltelli's design.
    BasePoint,
    /// A Latin hypercube got them at once when it grew.
    GrownPart,
}

/// Consecutive rows in groups of the same number of consecutive rows; the last group may have fewer.
///
/// A group is known by its kind and number: row `r` of the span is in group `first_group + (r - first_row) / group_rows`. Spans may
/// overlap where a product puts a row on several trajectories.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct GroupSpan {
    /// Reason why they belong together.
    pub kind: GroupKind,
    /// The first row.
    pub first_row: u64,
    /// Number of rows.
    pub rows: u64,
    /// Rows of a group, at least one.
    pub group_rows: u64,
    /// Number of the first group.
    pub first_group: u64,
}

impl GroupSpan {
    /// Groups of `group_rows` rows from the first row of a design on.
    pub(super) fn whole(kind: GroupKind, rows: usize, group_rows: usize) -> Self {
        Self { kind, first_row: 0, rows: rows as u64, group_rows: group_rows.max(1) as u64, first_group: 0 }
    }

    /// The group of a row of the design; `None` outside the span.
    pub fn group(&self, row: u64) -> Option<u64> {
        let within = row.checked_sub(self.first_row).filter(|within| *within < self.rows)?;
        Some(self.first_group + within / self.group_rows.max(1))
    }

    /// One past the number of the last group.
    fn groups_end(&self) -> u64 {
        self.first_group + self.rows.div_ceil(self.group_rows.max(1))
    }

    /// The same rows later, with other numbers.
    fn shifted(self, rows: u64, groups: u64) -> Self {
        Self { first_row: self.first_row + rows, first_group: self.first_group + groups, ..self }
    }
}

/// One past the largest number of a group.
fn groups_end(spans: &[GroupSpan]) -> u64 {
    spans.iter().map(GroupSpan::groups_end).max().unwrap_or(0)
}

/// The groups of designs one after the other; `parts`: the rows and spans of each.
pub(super) fn chained(parts: impl Iterator<Item = (usize, Vec<GroupSpan>)>) -> Vec<GroupSpan> {
    let (mut rows, mut groups, mut found) = (0, 0, Vec::new());
    for (count, spans) in parts {
        found.extend(spans.iter().map(|span| span.shifted(rows, groups)));
        rows += count as u64;
        groups += groups_end(&spans);
    }
    found
}

/// Groups of designs that are crossed, the last one changing fastest: rows share a group if the rows of one of the parts do, whatever the
/// other parts.
pub(super) fn crossed(parts: &[(usize, Vec<GroupSpan>)]) -> Vec<GroupSpan> {
    let total: u64 = parts.iter().map(|(rows, _)| *rows as u64).product();
    let (mut period, mut groups, mut found) = (total, 0, Vec::new());
    for (rows, spans) in parts {
        let stride = period / (*rows as u64).max(1);
        let scaled = |span: &GroupSpan| GroupSpan {
            first_row: span.first_row * stride,
            rows: span.rows * stride,
            group_rows: span.group_rows * stride,
            ..*span
        };
        for repeat in 0..total / period.max(1) {
            found.extend(spans.iter().map(|span| scaled(span).shifted(repeat * period, groups)));
        }
        groups += groups_end(spans);
        period = stride;
    }
    found
}

/// The groups of the rows that are left of a design: `kept` are their former numbers, ascending.
pub(super) fn kept(spans: &[GroupSpan], kept: &[usize]) -> Vec<GroupSpan> {
    let mut found: Vec<GroupSpan> = Vec::new();
    for span in spans {
        let place = |row: u64| kept.partition_point(|kept| (*kept as u64) < row);
        let rows = place(span.first_row)..place(span.first_row + span.rows);
        let mut last: Option<GroupSpan> = None;
        for (row, group) in rows.filter_map(|row| Some((row, span.group(*kept.get(row)? as u64)?))) {
            match &mut last {
                Some(last) if last.first_group == group => {
                    (last.rows, last.group_rows) = (last.rows + 1, last.group_rows + 1);
                }
                other => {
                    let first =
                        GroupSpan { first_row: row as u64, rows: 1, group_rows: 1, first_group: group, ..*span };
                    found.extend(other.replace(first));
                }
            }
        }
        found.extend(last);
    }
    found
}

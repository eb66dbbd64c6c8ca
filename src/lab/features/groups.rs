//! Groups of dependent rows: a number per reason, and one for all reasons.

use std::collections::HashMap;
use std::hash::Hash;

use serde::Serialize;

use super::column::{FeatureColumn, Role};
use decore_dataset::ValuesKey;
use decore_quantity::{CellColumn, Kind, Value, named};
use decore_statistics::design::{GroupKind, GroupSpan};

named! {
    /// A reason for which rows are kept together only where requested: such groups are few and large.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
    pub enum GroupBy {
        /// Rows on one machine.
        Machine = "machine",
        /// Rows that a Latin hypercube got at once when it grew.
        GrownPart = "grown_part",
        /// Rows whose castings have cores of one sand and binder.
        SandBinder = "sand_binder",
    }
}

/// Keys of a run, known when all runs are read.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RunKeys {
    /// Row in the design.
    pub row: u64,
    /// Key of the values of its factors.
    pub point: ValuesKey,
    /// Machine, as the value of the factor that selects it; empty without such a factor.
    pub machine: String,
    /// Sand and binder of the cores of each casting; `None` where the study states none.
    pub binders: Option<Vec<Option<String>>>,
}

/// The groups of runs.
pub(super) struct Groups {
    /// A number per run for each reason that the design or the values give; `None` for runs that have no such reason.
    pub keys: Vec<GroupKey>,
    /// All reasons together that a split keeps: a number per run, in the order of the first run of each.
    pub groups: Vec<usize>,
    /// The first row of each group.
    pub first_rows: Vec<u64>,
}

/// The groups of one reason.
pub(super) struct GroupKey {
    reason: Reason,
    binds: bool,
    numbers: Vec<Option<usize>>,
}

/// Reason why runs belong together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Reason {
    Design(GroupKind),
    Machine,
    SandBinder,
    Point,
}

impl Reason {
    /// Kinds of the designs first, then groups from the values.
    const ALL: [Self; 6] = [
        Self::Design(GroupKind::Trajectory),
        Self::Design(GroupKind::BasePoint),
        Self::Design(GroupKind::GrownPart),
        Self::Machine,
        Self::SandBinder,
        Self::Point,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::Design(GroupKind::Trajectory) => "group_trajectory",
            Self::Design(GroupKind::BasePoint) => "group_base_point",
            Self::Design(GroupKind::GrownPart) => "group_grown_part",
            Self::Machine => "group_machine",
            Self::SandBinder => "group_sand_binder",
            Self::Point => "group_point",
        }
    }

    fn text(self) -> &'static str {
        match self {
            Self::Design(GroupKind::Trajectory) => {
                "Rows on one trajectory of a Morris design: neighbours differ in one factor."
            }
            Self::Design(GroupKind::BasePoint) => {
                "Rows that mix the coordinates of one base point of a Saltelli design."
            }
            Self::Design(GroupKind::GrownPart) => "Rows that a Latin hypercube got at once when it grew.",
            Self::Machine => "Rows on one machine of the study.",
            Self::SandBinder => "Rows whose castings have cores of one sand and binder.",
            Self::Point => "Rows whose factors have equal values, to the last bit.",
        }
    }

    /// Whether a split keeps such rows together.
    fn binds(self, group_by: &[GroupBy]) -> bool {
        match self {
            Self::Design(GroupKind::Trajectory | GroupKind::BasePoint) | Self::Point => true,
            Self::Design(GroupKind::GrownPart) => group_by.contains(&GroupBy::GrownPart),
            Self::Machine => group_by.contains(&GroupBy::Machine),
            Self::SandBinder => group_by.contains(&GroupBy::SandBinder),
        }
    }
}

impl Groups {
    /// Groups of runs, from the groups of the design.
    pub fn of(runs: &[RunKeys], spans: &[GroupSpan], group_by: &[GroupBy]) -> Self {
        let mut bound = Forest::new(runs.len());
        let mut keys = Vec::new();
        for reason in Reason::ALL {
            let mut own = Forest::new(runs.len());
            let member = match reason {
                Reason::Design(kind) => own.join_spans(runs, spans.iter().filter(|span| span.kind == kind)),
                Reason::Machine => own.join_equal(runs.iter().map(|run| Some(&run.machine))),
                Reason::SandBinder => own.join_equal(runs.iter().map(|run| run.binders.as_ref())),
                Reason::Point => own.join_equal(runs.iter().map(|run| Some(run.point))),
            };
            let binds = reason.binds(group_by);
            if binds {
                (0..runs.len()).for_each(|run| bound.join(run, own.root(run)));
            }
            if member.contains(&true) {
                let numbers = own.numbers();
                let numbers = numbers.into_iter().zip(&member);
                // Numbered among the members alone.
                let mut seen = HashMap::new();
                let numbers = numbers.map(|(number, member)| {
                    let next = seen.len();
                    member.then(|| *seen.entry(number).or_insert(next))
                });
                keys.push(GroupKey { reason, binds, numbers: numbers.collect() });
            }
        }
        let groups = bound.numbers();
        let mut first_rows: Vec<u64> = Vec::new();
        for (run, group) in runs.iter().zip(&groups) {
            match first_rows.get_mut(*group) {
                Some(first) => *first = run.row.min(*first),
                None => first_rows.push(run.row),
            }
        }
        Self { keys, groups, first_rows }
    }

    /// The columns, each run repeated for its castings.
    pub fn columns(&self, castings: usize) -> Vec<FeatureColumn> {
        let mut columns: Vec<FeatureColumn> = self.keys.iter().map(|key| key.column(castings)).collect();
        let bound = self.keys.iter().filter(|key| key.binds).map(|key| key.reason.name().to_owned()).collect();
        let numbers = self.groups.iter().map(|group| Some(*group as i64));
        columns.push(FeatureColumn {
            values: repeated(numbers, castings),
            derived_from: bound,
            ..column(
                "group_id",
                "Rows that a split keeps together, for any of its reasons.",
                "connected rows of the group keys that bind",
            )
        });
        columns
    }
}

impl GroupKey {
    fn column(&self, castings: usize) -> FeatureColumn {
        let numbers = self.numbers.iter().map(|number| number.map(|number| number as i64));
        FeatureColumn {
            values: repeated(numbers, castings),
            ..column(self.reason.name(), self.reason.text(), "number of the group, in the order of its first row")
        }
    }
}

/// Each value once per casting.
pub(super) fn repeated(values: impl Iterator<Item = Option<i64>>, castings: usize) -> CellColumn {
    let cells = values.map(|value| value.map(Value::Integer));
    CellColumn::of(Kind::Integer, cells.flat_map(|cell| std::iter::repeat_n(cell, castings)))
}

fn column(name: &str, description: &str, formula: &str) -> FeatureColumn {
    FeatureColumn {
        name: name.to_owned(),
        unit: "1".to_owned(),
        role: Role::Group,
        description: description.to_owned(),
        formula: formula.to_owned(),
        valid: [Some(0.0), None],
        derived_from: Vec::new(),
        values: CellColumn::new(Kind::Integer),
    }
}

/// Disjoint sets (Tarjan, J. ACM 22, 1975): the root of a set is its least member.
struct Forest(Vec<usize>);

impl Forest {
    fn new(count: usize) -> Self {
        Self((0..count).collect())
    }

    fn root(&mut self, mut member: usize) -> usize {
        while self.0[member] != member {
            self.0[member] = self.0[self.0[member]];
            member = self.0[member];
        }
        member
    }

    fn join(&mut self, one: usize, other: usize) {
        let (one, other) = (self.root(one), self.root(other));
        self.0[one.max(other)] = one.min(other);
    }

    /// Joins members with equal keys; returns which members have one.
    fn join_equal<K: Eq + Hash>(&mut self, keys: impl Iterator<Item = Option<K>>) -> Vec<bool> {
        let mut first = HashMap::new();
        let join = |(member, key): (usize, Option<K>)| match key {
            Some(key) => {
                let one = *first.entry(key).or_insert(member);
                self.join(one, member);
                true
            }
            None => false,
        };
        keys.enumerate().map(join).collect()
    }

    /// Joins runs in one group of the spans; returns which runs are in one.
    fn join_spans<'s>(&mut self, runs: &[RunKeys], spans: impl Iterator<Item = &'s GroupSpan>) -> Vec<bool> {
        let mut member = vec![false; runs.len()];
        let mut first: HashMap<u64, usize> = HashMap::new();
        for span in spans {
            // Runs are in the order of their rows.
            let begin = runs.partition_point(|run| run.row < span.first_row);
            for (place, run) in runs.iter().enumerate().skip(begin) {
                let Some(group) = span.group(run.row) else { break };
                let one = *first.entry(group).or_insert(place);
                self.join(one, place);
                if let Some(member) = member.get_mut(place) {
                    *member = true;
                }
            }
        }
        member
    }

    /// A number per set, in the order of their least members.
    fn numbers(&mut self) -> Vec<usize> {
        let mut numbers = HashMap::new();
        (0..self.0.len())
            .map(|member| {
                let (root, next) = (self.root(member), numbers.len());
                *numbers.entry(root).or_insert(next)
            })
            .collect()
    }
}

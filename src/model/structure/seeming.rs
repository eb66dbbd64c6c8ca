//! Rows with labels of displacements that are none.
//!
//! CalculiX gives inner shapes of elements (C3D8I), rotations of rigid bodies and the knots of shells and beams directions 1 to 3. Two
//! signs tell them from displacements, those beside held nodes among them:
//!
//! - A translation of the machine does not move such a row: its stiffnesses against all displacements along its direction sum to 0, where
//!   those of a displacement sum to minus its own stiffness.
//! - Its node is coupled to the same nodes as another one: an inner node to those of its element, a rotation to those of its body.

use std::collections::HashMap;

use nalgebra::DMatrix;
use sprs::CsMat;

use super::balance::{Balance, under_motions};
use super::model::FeModel;
use super::motions::{MOST_TRANSLATED, translations};

/// At least this share of the rows that labels call displacements has to be displacements.
const LEAST_TRUE: f64 = 0.1;
/// A row is not a displacement if a translation moves it by less than this share, or backwards. Inner shapes of distorted elements beside
/// held
/// nodes reach 0.1; what CalculiX keeps of the held end of a beam moves backwards.
const LEAST_MOVED: f64 = 0.2;
/// Rounds of the search for rows that are not displacements; each uses the results of the round before.
const MOST_ROUNDS: usize = 20;

/// Rows that labels call displacements, but are none.
pub(super) struct Seeming {
    pub rows: Vec<bool>,
    /// Translations that leave these rows at rest.
    pub translations: DMatrix<f64>,
    /// Balance under these.
    pub balance: Balance,
}

impl Seeming {
    /// Of the rows out of balance those that the others of their direction do not move. `None` where leaving them at rest does not bring
    /// balance: labels are wrong then.
    pub fn find(model: &FeModel, directions: &[Option<usize>], balance: &Balance) -> Option<Self> {
        let mut doubtful = doubtful(model, directions, balance);
        twins(model).into_iter().zip(&mut doubtful).for_each(|(twin, doubtful)| *doubtful &= twin);
        let rows = not_moved(model.stiffness(), directions, &doubtful);
        let displacements = directions.iter().filter(|direction| matches!(direction, Some(0..3))).count();
        let seeming = rows.iter().filter(|seeming| **seeming).count();
        if ((displacements - seeming) as f64) < LEAST_TRUE * displacements as f64 {
            return None;
        }
        let kept: Vec<Option<usize>> =
            directions.iter().zip(&rows).map(|(direction, seeming)| direction.filter(|_| !*seeming)).collect();
        let translations = translations(&kept);
        let balance = under_motions(model.stiffness(), &translations);
        (balance.share() < MOST_TRANSLATED).then_some(Self { rows, translations, balance })
    }
}

/// Rows out of balance that labels call displacements. A user names the nodes of points with care.
fn doubtful(model: &FeModel, directions: &[Option<usize>], balance: &Balance) -> Vec<bool> {
    let mut doubtful: Vec<bool> = (balance.out.iter().zip(directions))
        .map(|(out, direction)| *out == Some(true) && matches!(direction, Some(0..3)))
        .collect();
    for rows in model.rows_of_points() {
        rows[..3].iter().flatten().for_each(|row| doubtful[*row] = false);
    }
    doubtful
}

/// Doubtful rows r that a translation does not move: `-sum_j K_rj / K_rr` over the other displacements j along the same axis is near 0.
fn not_moved(stiffness: &CsMat<f64>, directions: &[Option<usize>], doubtful: &[bool]) -> Vec<bool> {
    let mut rows = vec![false; doubtful.len()];
    for _ in 0..MOST_ROUNDS {
        let moved = |row: usize| {
            let (mut others, mut own) = (0.0, 0.0);
            for (column, entry) in stiffness.outer_view(row).iter().flat_map(|view| view.iter()) {
                if column == row {
                    own = *entry;
                } else if directions[column] == directions[row] && !rows[column] {
                    others -= entry;
                }
            }
            others / own
        };
        let found: Vec<bool> = (0..rows.len()).map(|row| doubtful[row] && moved(row) < LEAST_MOVED).collect();
        if found == rows {
            break;
        }
        rows = found;
    }
    rows
}

/// Rows of nodes that are coupled to the same nodes as another one.
fn twins(model: &FeModel) -> Vec<bool> {
    let nodes = nodes(model);
    let count = nodes.last().map_or(0, |last| last + 1);
    // A fingerprint of the nodes that each one is coupled to: their number, and a sum that does not depend on their order.
    let mut prints = vec![(0_usize, 0_u64); count];
    let mut last_seen_by = vec![usize::MAX; count];
    for (row, &node) in nodes.iter().enumerate() {
        for view in [model.stiffness(), model.mass()].into_iter().filter_map(|matrix| matrix.outer_view(row)) {
            for (column, _) in view.iter().filter(|(_, value)| **value != 0.0) {
                let other = nodes[column];
                if last_seen_by[other] != node {
                    last_seen_by[other] = node;
                    prints[node].0 += 1;
                    prints[node].1 = prints[node].1.wrapping_add(mixed(other as u64));
                }
            }
        }
    }
    let mut counts: HashMap<(usize, u64), usize> = HashMap::new();
    prints.iter().for_each(|print| *counts.entry(*print).or_default() += 1);
    nodes.iter().map(|node| counts[&prints[*node]] > 1).collect()
}

/// A number with its bits mixed (SplitMix64), so that sums of others do not meet.
fn mixed(value: u64) -> u64 {
    let value = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let value = (value ^ (value >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let value = (value ^ (value >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    value ^ (value >> 31)
}

/// Number of the node of every row: consecutive rows with the same label and other directions are one.
fn nodes(model: &FeModel) -> Vec<usize> {
    let mut out: Vec<usize> = Vec::new();
    let mut seen: Vec<usize> = Vec::new();
    for (row, label) in model.labels().iter().enumerate() {
        let same = row > 0 && model.labels()[row - 1].node == label.node && !seen.contains(&label.dof);
        let last = out.last().copied();
        if !same {
            seen.clear();
        }
        seen.push(label.dof);
        out.push(last.map_or(0, |last| if same { last } else { last + 1 }));
    }
    out
}

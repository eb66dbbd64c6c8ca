//! Checks that parts on the machine are at their interface points: across the axis of a strike or a fixture both must agree.

use super::issue::Issue;
use super::placement::PointTable;
use decore_model::direction::{dot, is_down, perpendicular};
use decore_model::scene::HammerUnit;
use decore_model::workpiece::Casting;

/// Distance in m up to which places agree: coordinates are typed to a millimetre.
const AGREEMENT_M: f64 = 1e-3;
/// Remedy for a fault.
const REMEDY: &str = "correct one of them, or set `geometry = \"as_given\"`";

/// Errors of a row's geometry: strike points that are not under their mounts, fixtures that are not at their interface points, two hammers
/// in one place or nearer than the width of their bores (their outside is unknown). They are errors of the row: another row may place a
/// hammer elsewhere.
pub(crate) fn check(hammers: &[HammerUnit], castings: &[Casting], points: &PointTable) -> Vec<Issue> {
    let mut issues = Vec::new();
    let mut fault = |path: String, message: String| {
        issues.push(Issue { row_only: true, ..Issue::new(path, message) });
    };
    let place = |hammer: &HammerUnit| hammer.mount.position_m(|name| points.position(name));
    for (h, hammer) in hammers.iter().enumerate() {
        let (Some(mount), Some(casting)) = (place(hammer), castings.get(hammer.casting)) else { continue };
        let (centre, point) = (casting.centre_place_m(), hammer.strike_place_m());
        let strike = [0, 1, 2].map(|axis| centre[axis] + point[axis]);
        if apart((strike, mount), hammer.axis()) > AGREEMENT_M {
            let message = format!(
                "hammer `{}` strikes {} from {}, but its strike point on casting `{}` is at {}: {REMEDY}",
                hammer.name,
                along(hammer.axis()),
                words(mount, hammer.axis()),
                casting.name,
                words(strike, hammer.axis())
            );
            fault(format!("hammer.{}.{}", hammer.name, hammer.strike_key()), message);
        }
        for other in &hammers[..h] {
            let Some(taken) = place(other) else { continue };
            let between = mount.iter().zip(taken).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
            let least = 0.5 * (hammer.parameters.telescope.bore_m + other.parameters.telescope.bore_m);
            let at = words(mount, hammer.axis());
            let wrong = if between <= AGREEMENT_M {
                format!("stands where hammer `{}` does, at {at}", other.name)
            } else if between < least {
                format!(
                    "stands at {at}, {between:.4} m from hammer `{}`: the bores of their telescopes alone need {least:.4} m",
                    other.name
                )
            } else {
                continue;
            };
            let message =
                format!("hammer `{}` {wrong}: move one of them, or set `geometry = \"as_given\"`", hammer.name);
            fault(format!("hammer.{}.mount", hammer.name), message);
        }
    }
    for casting in castings {
        for fixture in &casting.fixtures {
            let Some(point) = points.position(&fixture.point) else { continue };
            let (centre, place, axis) = (casting.centre_place_m(), fixture.place_m(), fixture.axes()[0]);
            let held = [0, 1, 2].map(|axis| centre[axis] + place[axis]);
            if apart((held, point), axis) > AGREEMENT_M {
                let message = format!(
                    "fixture `{}` holds casting `{}` at {}, but its interface point `{}` is at {}: {REMEDY}",
                    fixture.name,
                    casting.name,
                    words(held, axis),
                    fixture.point,
                    words(point, axis)
                );
                let key = if fixture.at_nodes.is_some() { "at_nodes" } else { "at_m" };
                fault(format!("casting.{}.fixture.{}.{key}", casting.name, fixture.name), message);
            }
        }
    }
    issues
}

/// Distance of two places across an axis.
fn apart((a, b): ([f64; 3], [f64; 3]), axis: [f64; 3]) -> f64 {
    let between = perpendicular([0, 1, 2].map(|k| a[k] - b[k]), axis);
    dot(between, between).sqrt()
}

fn along(axis: [f64; 3]) -> String {
    if is_down(&axis) {
        return "downwards".to_owned();
    }
    let [x, y, z] = axis;
    format!("along ({x:.4}, {y:.4}, {z:.4})")
}

/// A place; where the axis is vertical, its height does not matter.
fn words([x, y, z]: [f64; 3], axis: [f64; 3]) -> String {
    if is_down(&axis) { format!("({x:.4}, {y:.4}) m") } else { format!("({x:.4}, {y:.4}, {z:.4}) m") }
}

//! Checks that parts on the machine are at their interface points: strikes are vertical, so x and y must agree.

use super::issue::Issue;
use super::placement::PointTable;
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
        let strike = [0, 1].map(|axis| casting.centre_m[axis] + hammer.strike_point_m[axis]);
        if apart(strike, [mount[0], mount[1]]) > AGREEMENT_M {
            let message = format!(
                "hammer `{}` strikes downwards from {}, but its strike point on casting `{}` is at {}: {REMEDY}",
                hammer.name,
                words([mount[0], mount[1]]),
                casting.name,
                words(strike)
            );
            fault(format!("hammer.{}.strike_point_m", hammer.name), message);
        }
        for other in &hammers[..h] {
            let Some(taken) = place(other) else { continue };
            let between = mount.iter().zip(taken).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
            let least = 0.5 * (hammer.parameters.telescope.bore_m + other.parameters.telescope.bore_m);
            let at = words([mount[0], mount[1]]);
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
            let Some([x, y, _]) = points.position(&fixture.point) else { continue };
            let held = [0, 1].map(|axis| casting.centre_m[axis] + fixture.at_m[axis]);
            if apart(held, [x, y]) > AGREEMENT_M {
                let message = format!(
                    "fixture `{}` holds casting `{}` at {}, but its interface point `{}` is at {}: {REMEDY}",
                    fixture.name,
                    casting.name,
                    words(held),
                    fixture.point,
                    words([x, y])
                );
                fault(format!("casting.{}.fixture.{}.at_m", casting.name, fixture.name), message);
            }
        }
    }
    issues
}

fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    libm::hypot(a[0] - b[0], a[1] - b[1])
}

fn words([x, y]: [f64; 2]) -> String {
    format!("({x:.4}, {y:.4}) m")
}

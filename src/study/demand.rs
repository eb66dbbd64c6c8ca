//! Interface points that the rows of a study can use.

use super::document::error::Problem;
use super::document::path;
use super::loaded::{Candidate, Study};
use super::plan::factor::FactorInfo;
use super::resolve::placement::PointTable;
use super::resolve::scene::DEFAULT_MACHINE;
use decore_model::direction::is_down;
use decore_quantity::words::nearest;

/// Interface points that some row of a study can use. The reduced machine must keep them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct InterfaceDemand {
    /// Candidate mounts, all points of the rails used included; each once, in the order of first use.
    pub mounts: Vec<String>,
    /// Further points whose motion is needed, because they carry fixtures or are watched; each once, in the order of first use.
    pub others: Vec<String>,
    /// Whether some row can have a direction that is not vertical: of a hammer, a fixture, a measurement.
    pub sideways: bool,
}

impl InterfaceDemand {
    /// All interface points that some row of a study can use; names are not checked, see [`super::CheckedStudy::new`].
    pub fn of(study: &Study) -> Self {
        let mut demand = Self::default();
        for candidate in mounts(study) {
            add(&mut demand.mounts, candidate.value);
        }
        for candidate in rails(study) {
            let rail = study.scenes.rails.iter().find(|rail| rail.name == candidate.value);
            for point in rail.into_iter().flat_map(|rail| &rail.points) {
                add(&mut demand.mounts, point.clone());
            }
        }
        for candidate in fixture_points(study) {
            add(&mut demand.others, candidate.value);
        }
        for point in &study.outputs().points {
            add(&mut demand.others, point.clone());
        }
        demand.sideways = sideways(study);
        demand
    }
}

/// Whether the study states directions or sideways stiffness of what touches the machine, in its tables or by its factors.
fn sideways(study: &Study) -> bool {
    let file = &study.file;
    let across = |axis: Option<[f64; 3]>| axis.is_some_and(|axis| !is_down(&axis));
    let fixtures = file.casting.values().flat_map(|casting| casting.fixture.values());
    let held = fixtures.into_iter().any(|fixture| {
        across(fixture.axis)
            || fixture.lateral_stiffness_n_per_m.is_some()
            || fixture.lateral_damping_n_s_per_m.is_some()
    });
    let struck = file.hammer.values().any(|hammer| across(hammer.strike_axis));
    let driven = study.factors().iter().flat_map(FactorInfo::paths).any(|path| {
        let mut keys = path.split('.');
        keys.any(|key| {
            matches!(key, "axis" | "strike_axis" | "lateral_stiffness_n_per_m" | "lateral_damping_n_s_per_m")
        })
    });
    held || struck || driven || !is_down(&study.outputs().points_axis)
}

fn hammer_candidates(study: &Study, key: &str) -> Vec<Candidate> {
    let names = study.file.hammer.keys();
    names.flat_map(|name| study.candidates(&["hammer", name, key].map(str::to_string))).collect()
}

fn mounts(study: &Study) -> Vec<Candidate> {
    hammer_candidates(study, "mount")
}

/// Rails that hammers name, or use as the only one there is.
fn rails(study: &Study) -> Vec<Candidate> {
    let mut rails = hammer_candidates(study, "rail");
    if let [only] = study.scenes.rails.as_slice() {
        for (name, entry) in &study.file.hammer {
            if entry.rail.is_none() && entry.rail_position_m.is_some() {
                let at = ["hammer", name, "rail_position_m"].map(str::to_string).to_vec();
                rails.push(Candidate { value: only.name.clone(), place: study.typed.locate(&at), at });
            }
        }
    }
    rails
}

fn fixture_points(study: &Study) -> Vec<Candidate> {
    let castings = study.file.casting.iter();
    let fixtures = castings.flat_map(|(casting, entry)| {
        entry.fixture.keys().map(move |fixture| ["casting", casting, "fixture", fixture, "point"].map(str::to_string))
    });
    fixtures.flat_map(|at| study.candidates(&at)).collect()
}

/// Names of interface points, in rails or where some row can use them, that the machine does not have.
pub(super) fn check_names(study: &Study, points: &PointTable) -> Vec<Problem> {
    let mut problems = Vec::new();
    for candidate in mounts(study).into_iter().chain(fixture_points(study)) {
        if points.position(&candidate.value).is_none() {
            let message = format!("the machine has no interface point `{}`", candidate.value);
            let nearest = points.nearest_name(&candidate.value);
            problems.push(Problem::new(candidate.place, path::join(&candidate.at), message).nearest(nearest));
        }
    }
    let seen = &study.outputs().points;
    for (index, name) in seen.iter().enumerate() {
        let wrong = match (points.position(name), seen.iter().take(index).any(|before| before == name)) {
            (None, _) => format!("the machine has no interface point `{name}`"),
            (Some(_), true) => format!("point `{name}` stands there twice"),
            (Some(_), false) => continue,
        };
        let at = ["outputs", "points", &index.to_string()].map(str::to_string);
        let problem = Problem::new(study.typed.locate(&at), path::join(&at), wrong);
        problems.push(problem.nearest(points.nearest_name(name).filter(|nearest| nearest != name)));
    }
    for candidate in study.candidates(&["machine".to_string()]) {
        let mut known = study.scenes.machines.iter().map(String::as_str).chain([DEFAULT_MACHINE]);
        if known.clone().all(|name| name != candidate.value) {
            let message =
                format!("no machine `{}`: expected one of [structures], or `{DEFAULT_MACHINE}`", candidate.value);
            let nearest = nearest(&candidate.value, known.by_ref());
            problems.push(Problem::new(candidate.place, path::join(&candidate.at), message).nearest(nearest));
        }
    }
    for rail in &study.scenes.rails {
        for (index, point) in rail.points.iter().enumerate() {
            if points.position(point).is_none() {
                let entry = index.to_string();
                let at = ["structure", "rails", &rail.name, &entry].map(str::to_string);
                let message = format!("the machine has no interface point `{point}`");
                let problem = Problem::new(study.typed.locate(&at), path::join(&at), message);
                problems.push(problem.nearest(points.nearest_name(point)));
            }
        }
    }
    problems
}
fn add(names: &mut Vec<String>, name: String) {
    if !names.contains(&name) {
        names.push(name);
    }
}

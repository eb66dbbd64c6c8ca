//! Which interface points the rows of a study can use.

use super::Study;
use super::error::{Place, Problem};
use super::factors::to_toml;
use super::path;
use super::placement::PointTable;
use super::resolve::DEFAULT_MACHINE;
use crate::words::nearest;

/// The interface points that some row of a study can use: what the reduced machine must keep.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct InterfaceDemand {
    /// Candidate mounts, all points of the rails used included; each once, in the order of first use.
    pub mounts: Vec<String>,
    /// Points that carry fixtures; each once, in the order of first use.
    pub fixtures: Vec<String>,
}

/// A text that some row has at a path.
pub(super) struct Candidate {
    pub value: String,
    /// Where the study says so.
    pub place: Place,
    /// Path of the key that says so.
    pub at: Vec<String>,
}

impl Study {
    /// All interface points that some row can use; names are not checked, see [`Study::check`].
    pub fn interface_demand(&self) -> InterfaceDemand {
        let mut demand = InterfaceDemand::default();
        for candidate in self.mounts() {
            add(&mut demand.mounts, candidate.value);
        }
        for candidate in self.rails() {
            let rail = self.structure.rails.iter().find(|rail| rail.name == candidate.value);
            for point in rail.into_iter().flat_map(|rail| &rail.points) {
                add(&mut demand.mounts, point.clone());
            }
        }
        for candidate in self.fixture_points() {
            add(&mut demand.fixtures, candidate.value);
        }
        demand
    }

    /// All texts that some row can have at a path.
    pub(super) fn candidates(&self, at: &[String]) -> Vec<Candidate> {
        let overridden = self.overrides.iter().rev().find(|one| one.path == at);
        let driver = self.plan.paths.iter().position(|paths| paths.iter().any(|path| path == at));
        let factor = driver.and_then(|index| self.plan.factors.get(index));
        match (overridden, factor) {
            (Some(one), _) => {
                let text = one.value.as_str().map(str::to_string);
                text.into_iter().map(|value| Candidate { value, place: one.place(), at: at.to_vec() }).collect()
            }
            (None, Some(factor)) => {
                let candidate = |(index, value)| {
                    let index: usize = index;
                    let entry = index.to_string();
                    let key = ["design", "factor", &factor.name, "values", &entry].map(str::to_string);
                    let value = to_toml(value).as_str()?.to_string();
                    Some(Candidate { value, place: self.document.locate(&key), at: key.to_vec() })
                };
                factor.values.iter().enumerate().filter_map(candidate).collect()
            }
            (None, None) => {
                let value = path::get(&self.template, at).and_then(toml::Value::as_str);
                let candidate = |value: &str| Candidate {
                    value: value.to_string(),
                    place: self.document.locate(at),
                    at: at.to_vec(),
                };
                value.map(candidate).into_iter().collect()
            }
        }
    }

    fn hammer_candidates(&self, key: &str) -> Vec<Candidate> {
        let names = self.base.hammer.keys();
        names.flat_map(|name| self.candidates(&["hammer", name, key].map(str::to_string))).collect()
    }

    fn mounts(&self) -> Vec<Candidate> {
        self.hammer_candidates("mount")
    }

    /// Rails that hammers name, or use as the only one there is.
    fn rails(&self) -> Vec<Candidate> {
        let mut rails = self.hammer_candidates("rail");
        if let [only] = self.structure.rails.as_slice() {
            for (name, entry) in &self.base.hammer {
                if entry.rail.is_none() && entry.rail_position_m.is_some() {
                    let at = ["hammer", name, "rail_position_m"].map(str::to_string).to_vec();
                    rails.push(Candidate { value: only.name.clone(), place: self.document.locate(&at), at });
                }
            }
        }
        rails
    }

    fn fixture_points(&self) -> Vec<Candidate> {
        let castings = self.base.casting.iter();
        let fixtures = castings.flat_map(|(casting, entry)| {
            entry
                .fixture
                .keys()
                .map(move |fixture| ["casting", casting, "fixture", fixture, "point"].map(str::to_string))
        });
        fixtures.flat_map(|at| self.candidates(&at)).collect()
    }

    /// Names of interface points, in rails or where some row can use them, that the machine does not have.
    pub(super) fn check_names(&self, points: &PointTable) -> Vec<Problem> {
        let mut problems = Vec::new();
        for candidate in self.mounts().into_iter().chain(self.fixture_points()) {
            if points.position(&candidate.value).is_none() {
                let message = format!("the machine has no interface point `{}`", candidate.value);
                let nearest = points.nearest_name(&candidate.value);
                problems.push(Problem::new(candidate.place, path::join(&candidate.at), message).nearest(nearest));
            }
        }
        for candidate in self.candidates(&["machine".to_string()]) {
            let mut known = self.structures.iter().map(|(name, _)| name.as_str()).chain([DEFAULT_MACHINE]);
            if known.clone().all(|name| name != candidate.value) {
                let message =
                    format!("no machine `{}`: expected one of [structures], or `{DEFAULT_MACHINE}`", candidate.value);
                let nearest = nearest(&candidate.value, known.by_ref());
                problems.push(Problem::new(candidate.place, path::join(&candidate.at), message).nearest(nearest));
            }
        }
        for rail in &self.structure.rails {
            for (index, point) in rail.points.iter().enumerate() {
                if points.position(point).is_none() {
                    let entry = index.to_string();
                    let at = ["structure", "rails", &rail.name, &entry].map(str::to_string);
                    let message = format!("the machine has no interface point `{point}`");
                    let problem = Problem::new(self.document.locate(&at), path::join(&at), message);
                    problems.push(problem.nearest(points.nearest_name(point)));
                }
            }
        }
        problems
    }
}

fn add(names: &mut Vec<String>, name: String) {
    if !names.contains(&name) {
        names.push(name);
    }
}

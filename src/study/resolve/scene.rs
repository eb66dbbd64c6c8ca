//! Converts the study with one row's values to the scene: fills in defaults, looks up names, computes the geometry.

use super::geometry;
use super::issue::Issue;
use super::library::Library;
use super::nodes::{NodesKey, NodesOf, PlacedNodes};
use super::placement::{Placed, PlacementError, PointTable, Rail, at_point, on_rail};
use crate::file::{Geometry, StudyFile};
use decore_model::direction::{DOWN, perpendicular};
use decore_model::scene::{
    Guide, HammerEntry, HammerUnit, Method, ModeTreatment, Preset, Scene, SceneProblemKind, SolverEntry,
    SolverSettings, Supply,
};
use decore_model::workpiece::{
    Casting, CastingEntry, CastingStructureEntry, CorePoint, CorePointEntry, Elastic, Fixture, FixtureEntry, Pad,
};
use decore_quantity::words::nearest;

/// Data that rows share.
pub(crate) struct Context<'a> {
    pub rails: &'a [Rail],
    /// Names of the further machines.
    pub machines: &'a [String],
    pub library: &'a Library,
    pub points: &'a PointTable,
}

/// Resolves a study with one row's values applied.
pub(crate) fn resolve(file: &StudyFile, context: &Context<'_>) -> Result<Scene, Vec<Issue>> {
    let mut issues = Vec::new();
    if file.hammer.is_empty() {
        issues.push(Issue::new("hammer".into(), "a study needs at least one hammer: [hammer.NAME]"));
    }
    if file.casting.is_empty() {
        issues.push(Issue::new("casting".into(), "a study needs at least one casting: [casting.NAME]"));
    }
    let machine = machine(file.machine.as_deref(), context.machines, &mut issues);
    let mut castings = Vec::new();
    for (name, entry) in &file.casting {
        castings.push(casting(name, entry, context.points, &mut issues));
    }
    let mut hammers = Vec::new();
    for (name, entry) in &file.hammer {
        let resolver = HammerResolver { name, entry, file, context, castings: &castings };
        hammers.extend(resolver.resolve(&mut issues));
    }
    if issues.is_empty() && file.geometry == Geometry::Checked {
        issues.extend(geometry::check(&hammers, &castings, context.points));
    }
    if !issues.is_empty() {
        return Err(issues);
    }
    let scene = Scene {
        machine,
        environment: file.environment,
        solver: solver(&file.solver, &hammers),
        hammers,
        castings,
        duration_s: file.duration_s.unwrap_or(Scene::default().duration_s),
        outputs: file.outputs.clone(),
    };
    let problems = scene.validate();
    if problems.is_empty() {
        return Ok(scene);
    }
    let issue = |problem: decore_model::scene::SceneProblem| Issue {
        row_only: problem.kind == SceneProblemKind::Miss,
        path: problem.path,
        message: problem.message,
        nearest: None,
    };
    Err(problems.into_iter().map(issue).collect())
}

/// Name of the machine of the table `[structure]`.
pub(crate) const DEFAULT_MACHINE: &str = "structure";

/// Index of the machine among the further ones.
fn machine(name: Option<&str>, known: &[String], issues: &mut Vec<Issue>) -> Option<usize> {
    let name = name.filter(|name| *name != DEFAULT_MACHINE)?;
    let found = known.iter().position(|known| *known == name);
    if found.is_none() {
        let nearest = nearest(name, known.iter().map(String::as_str).chain([DEFAULT_MACHINE]));
        let message = format!("no machine `{name}`: it is neither `{DEFAULT_MACHINE}` nor in [structures]");
        issues.push(Issue { nearest, ..Issue::new("machine".into(), message) });
    }
    found
}

fn solver(entry: &SolverEntry, hammers: &[HammerUnit]) -> SolverSettings {
    let preset = Preset::of(entry.fidelity.unwrap_or_default());
    let Preset { fidelity, guide, .. } = preset;
    let tolerance = preset.tolerance_for(hammers.iter().map(|hammer| &hammer.parameters));
    let default = SolverSettings { fidelity, tolerance, guide, ..SolverSettings::default() };
    let fixed = entry.method.is_some_and(Method::is_fixed);
    // Fixed steps are for comparison: the model as published.
    let published = SolverSettings { guide: Guide::Spring, modes: ModeTreatment::Integrated, ..default };
    entry.over(if fixed { published } else { default })
}

fn casting(name: &str, entry: &CastingEntry, points: &PointTable, issues: &mut Vec<Issue>) -> Casting {
    let mut places = Vec::new();
    for (fixture, fixture_entry) in &entry.fixture {
        match points.position(&fixture_entry.point) {
            Some(position) => places.push(position),
            None => {
                let path = format!("casting.{name}.fixture.{fixture}.point");
                issues.push(unknown_point(path, &fixture_entry.point, points));
            }
        }
    }
    let [mean_x, mean_y, mean_z] = mean(&places);
    let [x, y] = entry.centre_m.unwrap_or([mean_x, mean_y]);
    let centre = [x, y, entry.centre_height_m.unwrap_or(mean_z)];
    let nodes = NodesOf { casting: name, is_elastic: entry.structure.is_some(), points };
    let known = entry.fixture.iter().filter(|(_, fixture)| points.position(&fixture.point).is_some());
    let fixtures = known.zip(&places).map(|((fixture, fixture_entry), place)| {
        let above = [0, 1, 2].map(|axis| place[axis] - centre[axis]);
        fixture_of((fixture, fixture_entry), above, nodes, issues)
    });
    let fixtures = fixtures.collect();
    let cores = entry.core.iter().map(|(core, entry)| core_of(core, entry, nodes, issues)).collect();
    let key = NodesKey {
        table: format!("casting.{name}"),
        key: "measuring_nodes",
        entry: entry.measuring_nodes.as_ref(),
        beside: &[
            ("measuring_point_m", entry.measuring_point_m.is_some()),
            ("measuring_height_m", entry.measuring_height_m.is_some()),
        ],
    };
    let measured = nodes.resolve(key, issues);
    let measured_m = measured.as_ref().map(|(_, place)| *place);
    let elastic = |structure: &CastingStructureEntry| Elastic {
        contact_includes_casting: structure.contact_includes_casting.unwrap_or(true),
    };
    entry.over(Casting {
        name: name.to_string(),
        fixtures,
        cores,
        elastic: entry.structure.as_ref().map(elastic),
        measuring_point_m: measured_m.map(|[x, y, _]| [x, y]),
        measuring_height_m: measured_m.map_or(0.0, |[_, _, z]| z),
        measuring_nodes: measured.map(|(nodes, _)| nodes),
        centre_m: [x, y],
        centre_height_m: centre[2],
        ..Casting::default()
    })
}

fn core_of(name: &str, entry: &CorePointEntry, nodes: NodesOf<'_>, issues: &mut Vec<Issue>) -> CorePoint {
    let key = NodesKey {
        table: format!("casting.{}.core.{name}", nodes.casting),
        key: "at_nodes",
        entry: entry.at_nodes.as_ref(),
        beside: &[("at_m", entry.at_m.is_some())],
    };
    let (at_nodes, at_m) = nodes.resolve(key, issues).unzip();
    entry.over(CorePoint { name: name.to_owned(), at_nodes, at_m: at_m.unwrap_or_default() })
}

/// A fixture that holds the casting at a place above its interface point, from the centre of mass, unless its table states another one.
fn fixture_of(
    (name, entry): (&str, &FixtureEntry),
    above: [f64; 3],
    nodes: NodesOf<'_>,
    issues: &mut Vec<Issue>,
) -> Fixture {
    let table = format!("casting.{}.fixture.{name}", nodes.casting);
    let pad = pad(&table, entry).unwrap_or_else(|issue| {
        issues.push(issue);
        None
    });
    let key = NodesKey {
        table,
        key: "at_nodes",
        entry: entry.at_nodes.as_ref(),
        beside: &[("at_m", entry.at_m.is_some()), ("height_m", entry.height_m.is_some())],
    };
    let (at_nodes, place) = nodes.resolve(key, issues).unzip();
    let [x, y, z] = place.unwrap_or(above);
    let default = Fixture::default();
    let [stiffness_n_per_m, damping_n_s_per_m] = pad.map_or(default.spring(), |pad| pad.spring());
    entry.over(Fixture {
        at_nodes,
        name: name.to_string(),
        point: entry.point.clone(),
        pad,
        at_m: [x, y],
        height_m: z,
        stiffness_n_per_m,
        damping_n_s_per_m,
        ..default
    })
}

/// Pad of a fixture, if the study states its material.
fn pad(path: &str, entry: &FixtureEntry) -> Result<Option<Pad>, Issue> {
    let issue = |key: &str, message: String| Err(Issue::new(format!("{path}.{key}"), message));
    let sizes = [("pad_area_m2", entry.pad_area_m2), ("pad_thickness_m", entry.pad_thickness_m)];
    let Some(material) = entry.material else {
        return match sizes.into_iter().find(|(_, size)| size.is_some()) {
            Some((key, _)) => issue(key, "needs the `material` of the pad".to_owned()),
            None => Ok(None),
        };
    };
    let stated = [("stiffness_n_per_m", entry.stiffness_n_per_m), ("damping_n_s_per_m", entry.damping_n_s_per_m)];
    if let Some((key, _)) = stated.into_iter().find(|(_, value)| value.is_some()) {
        let name = material.name();
        return issue(key, format!("follows from `material = \"{name}\"`: remove either `{key}` or `material`"));
    }
    match sizes {
        [(_, Some(pad_area_m2)), (_, Some(pad_thickness_m))] => {
            Ok(Some(Pad { material, pad_area_m2, pad_thickness_m }))
        }
        _ => issue("material", "needs `pad_area_m2` and `pad_thickness_m`".to_owned()),
    }
}

fn mean(places: &[[f64; 3]]) -> [f64; 3] {
    let count = places.len().max(1) as f64;
    [0, 1, 2].map(|axis| places.iter().map(|place| place[axis]).sum::<f64>() / count)
}

fn unknown_point(path: String, point: &str, points: &PointTable) -> Issue {
    let message = PlacementError::UnknownPoint(point.to_string()).to_string();
    Issue { nearest: points.nearest_name(point), ..Issue::new(path, message) }
}

struct HammerResolver<'a> {
    name: &'a str,
    entry: &'a HammerEntry,
    file: &'a StudyFile,
    context: &'a Context<'a>,
    castings: &'a [Casting],
}

impl HammerResolver<'_> {
    fn path(&self, key: &str) -> String {
        format!("hammer.{}.{key}", self.name)
    }

    fn resolve(&self, issues: &mut Vec<Issue>) -> Option<HammerUnit> {
        let entry = self.entry;
        let placed = self.place().map_err(|issue| issues.push(issue)).ok();
        let casting = self.casting().map_err(|issue| issues.push(issue)).ok();
        let parameters = self.context.library.parameters(entry.file.as_deref(), &entry.parameters.0);
        let parameters = parameters.map_err(|message| issues.push(Issue::new(self.path("parameters"), message))).ok();
        let (Some(placed), Some(casting), Some(parameters)) = (placed, casting, parameters) else {
            return None;
        };
        let centre = self.castings.get(casting).map_or([0.0; 3], Casting::centre_place_m);
        // By default the hammer strikes the point of its axis that is nearest to the centre of mass.
        let mount = [0, 1, 2].map(|axis| placed.position[axis] - centre[axis]);
        let nearest = perpendicular(mount, entry.strike_axis.unwrap_or(DOWN));
        let (strike_nodes, place) = self.strike_nodes(casting, issues).unzip();
        let [x, y, z] = place.unwrap_or(nearest);
        let supply = entry.supply_bar.map_or_else(Supply::default, |supply_bar| Supply { supply_bar });
        Some(entry.over(HammerUnit {
            name: self.name.to_string(),
            parameters,
            supply_pressure_pa: supply.pressure_pa(&self.file.environment),
            mount: placed.mount,
            casting,
            strike_point_m: [x, y],
            strike_height_m: z,
            strike_nodes,
            ..HammerUnit::default()
        }))
    }

    fn strike_nodes(&self, casting: usize, issues: &mut Vec<Issue>) -> Option<PlacedNodes> {
        let entry = self.entry;
        let casting = self.castings.get(casting)?;
        let key = NodesKey {
            table: format!("hammer.{}", self.name),
            key: "strike_nodes",
            entry: entry.strike_nodes.as_ref(),
            beside: &[
                ("strike_point_m", entry.strike_point_m.is_some()),
                ("strike_height_m", entry.strike_height_m.is_some()),
            ],
        };
        let (is_elastic, points) = (casting.elastic.is_some(), self.context.points);
        NodesOf { casting: &casting.name, is_elastic, points }.resolve(key, issues)
    }

    fn place(&self) -> Result<Placed, Issue> {
        let points = self.context.points;
        match (&self.entry.mount, self.entry.rail_position_m) {
            (Some(mount), None) if self.entry.rail.is_none() => {
                at_point(mount, points).map_err(|_| unknown_point(self.path("mount"), mount, points))
            }
            (None, Some(position)) => {
                let rail = self.rail()?;
                on_rail(rail, position, points).map_err(|error| {
                    let key = if matches!(error, PlacementError::OffRail { .. }) { "rail_position_m" } else { "rail" };
                    Issue::new(self.path(key), error.to_string())
                })
            }
            (None, None) => Err(Issue::new(
                self.path("mount"),
                "the hammer has no place: give `mount = \"POINT\"`, or `rail` with `rail_position_m`",
            )),
            (Some(_), _) => Err(Issue::new(
                self.path("mount"),
                "the hammer has two places: give either `mount`, or `rail` with `rail_position_m`",
            )),
        }
    }

    fn rail(&self) -> Result<&Rail, Issue> {
        let rails = self.context.rails;
        let names = || rails.iter().map(|rail| rail.name.as_str());
        match (&self.entry.rail, rails) {
            (Some(name), _) => rails.iter().find(|rail| rail.name == *name).ok_or_else(|| Issue {
                nearest: nearest(name, names()),
                ..Issue::new(
                    self.path("rail"),
                    format!("the structure has no rail `{name}`; it has: {}", names().collect::<Vec<_>>().join(", ")),
                )
            }),
            (None, [only]) => Ok(only),
            (None, _) => {
                let known = names().collect::<Vec<_>>().join(", ");
                let message = format!("`rail_position_m` needs the name of a rail; the structure has: {known}");
                Err(Issue::new(self.path("rail"), message))
            }
        }
    }

    fn casting(&self) -> Result<usize, Issue> {
        let names = || self.castings.iter().map(|casting| casting.name.as_str());
        match &self.entry.casting {
            Some(wanted) => names().position(|name| name == wanted).ok_or_else(|| Issue {
                nearest: nearest(wanted, names()),
                ..Issue::new(
                    self.path("casting"),
                    format!("the study has no casting `{wanted}`; it has: {}", names().collect::<Vec<_>>().join(", ")),
                )
            }),
            None if self.castings.len() <= 1 => Ok(0),
            None => {
                let known = names().collect::<Vec<_>>().join(", ");
                let message = format!("which casting does it strike? The study has: {known}");
                Err(Issue::new(self.path("casting"), message))
            }
        }
    }
}

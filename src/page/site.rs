//! Places of a scene for its drawings: machine, castings, fixtures, hammers. Lengths in m, in world axes (x forward, y lateral, z up).

use serde::Serialize;

use decore_model::direction::{across, dot};
use decore_model::hammer::HammerParameters;
use decore_model::metrics::{CastingSignals, FixtureSignals, HammerSignals, SignalOf};
use decore_model::scene::{HammerUnit, Scene};
use decore_model::workpiece::{Casting, Fixture};
use decore_study::PointTable;

/// Share of one direction along another from which on the two count as parallel.
const PARALLEL: f64 = 1.0 - 1e-9;

/// Smallest and largest x, y and z of a body, m from its centre of mass.
pub type Extent = [[f64; 2]; 3];

/// The machine of a scene, and the bodies of its elastic castings.
#[derive(Debug, Clone)]
pub struct Site<'a> {
    /// Rails: their names and interface points, in order.
    pub rails: Vec<(&'a str, &'a [String])>,
    /// Positions of the interface points.
    pub points: &'a PointTable,
    /// Extent of each casting; `None` for a rigid casting.
    pub extents_m: Vec<Option<Extent>>,
}

/// A name and its place.
#[derive(Debug, Serialize)]
pub(super) struct Named<T> {
    pub name: String,
    pub at: T,
}

/// A casting from above.
#[derive(Debug, Serialize)]
pub(super) struct CastingPlan {
    name: String,
    centre_m: [f64; 2],
    /// Smallest and largest x and y; `None` where nobody states a size.
    outline_m: Option<[[f64; 2]; 2]>,
    fixtures: Vec<FixturePlan>,
}

/// A fixture from above.
#[derive(Debug, Serialize)]
struct FixturePlan {
    name: String,
    kind: FixtureKind,
    at: [f64; 2],
}

/// Kind of a fixture, as it is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
enum FixtureKind {
    /// It pushes and pulls.
    Spring,
    /// It only pushes.
    Pad,
    /// It presses the casting onto its pads.
    Clamp,
}

/// A hammer of a scene.
#[derive(Debug, Serialize)]
pub(super) struct DrawnHammer<'a> {
    name: &'a str,
    casting: usize,
    /// Strike point from the casting's centre of mass.
    strike_m: [f64; 3],
    /// Direction in which it strikes.
    axis: [f64; 3],
    /// Share of its direction along the one in which its casting is measured.
    along: f64,
    /// Place of its mount; `None` where the machine does not state it.
    mount_m: Option<[f64; 3]>,
    standoff_m: f64,
    supply_pa: f64,
    telescope_stroke_m: f64,
    piston_stroke_m: f64,
    chamber_length_m: f64,
    spool_travel_m: f64,
    chisel_travel_m: f64,
}

/// A casting of a scene. Its places are from its centre of mass.
#[derive(Debug, Serialize)]
pub(super) struct DrawnCasting<'a> {
    #[serde(flatten)]
    plan: CastingPlan,
    elastic: bool,
    centre_height_m: f64,
    /// Two directions across the one in which it is measured, and that direction.
    axes: [[f64; 3]; 3],
    extent_m: Option<Extent>,
    /// Measuring point, if one is chosen.
    measured_m: Option<[f64; 3]>,
    /// Fixtures, in the order of the plan.
    held: Vec<DrawnFixture<'a>>,
    cores: Vec<Named<[f64; 3]>>,
}

/// A fixture as the page draws it: its point on the machine, and its place on the casting.
#[derive(Debug, Serialize)]
struct DrawnFixture<'a> {
    point: &'a str,
    at_m: [f64; 3],
    axis: [f64; 3],
    /// Share of its direction along the one in which its casting is measured.
    along: f64,
}

impl FixtureKind {
    fn of(fixture: &Fixture) -> Self {
        match fixture {
            _ if fixture.clamp_force_n > 0.0 => Self::Clamp,
            _ if fixture.one_sided => Self::Pad,
            _ => Self::Spring,
        }
    }
}

impl CastingPlan {
    /// A casting with the extent of its body, if that is known. A size that the study states comes first.
    pub(super) fn of(casting: &Casting, extent_m: Option<Extent>) -> Self {
        let centre_m = casting.centre_m;
        let of_axis = |axis: usize| {
            let half = casting.size_m.map(|size| [-0.5, 0.5].map(|share| share * size[axis]));
            let ends = half.or(extent_m.map(|extent| extent[axis]))?;
            Some(ends.map(|end| centre_m[axis] + end))
        };
        let fixtures = casting.fixtures.iter().map(|fixture| FixturePlan {
            name: fixture.name.clone(),
            kind: FixtureKind::of(fixture),
            at: [0, 1].map(|axis| centre_m[axis] + fixture.at_m[axis]),
        });
        Self {
            name: casting.name.clone(),
            centre_m,
            outline_m: of_axis(0).zip(of_axis(1)).map(|(x, y)| [x, y]),
            fixtures: fixtures.collect(),
        }
    }
}

/// Rails from above: the points of each whose place the machine states.
pub(super) fn rails_plan<'a>(
    rails: impl Iterator<Item = (&'a str, &'a [String])>,
    points: &PointTable,
) -> Vec<Named<Vec<[f64; 2]>>> {
    let flat = |[x, y, _]: [f64; 3]| [x, y];
    let rail = |(name, on): (&str, &[String])| Named {
        name: name.to_owned(),
        at: on.iter().filter_map(|point| points.position(point).map(flat)).collect(),
    };
    let mut rails: Vec<Named<Vec<[f64; 2]>>> = rails.map(rail).collect();
    rails.sort_by(|a, b| a.name.cmp(&b.name));
    rails
}

impl Site<'_> {
    /// Interface points that the scene or a rail uses, by name.
    pub(super) fn points_plan(&self, scene: &Scene) -> Vec<Named<[f64; 2]>> {
        let mounts = scene.hammers.iter().flat_map(|unit| unit.mount.points.iter().map(|(name, _)| name));
        let supports = scene.fixtures().map(|(_, fixture)| &fixture.point);
        let on_rails = self.rails.iter().flat_map(|(_, points)| *points);
        let mut names: Vec<&String> = mounts.chain(supports).chain(on_rails).chain(&scene.outputs.points).collect();
        names.sort();
        names.dedup();
        let known = names.into_iter().filter_map(|name| Some((name, self.points.position(name)?)));
        known.map(|(name, [x, y, _])| Named { name: name.clone(), at: [x, y] }).collect()
    }

    /// The hammers of the scene.
    pub(super) fn hammers<'s>(&self, scene: &'s Scene) -> Vec<DrawnHammer<'s>> {
        let hammer = |unit: &'s HammerUnit| {
            let HammerParameters { telescope, piston, valve, chisel, .. } = unit.parameters;
            DrawnHammer {
                name: unit.name.as_str(),
                casting: unit.casting,
                strike_m: unit.strike_place_m(),
                axis: unit.axis(),
                along: dot(unit.axis(), scene.measuring_axis(unit.casting)),
                mount_m: unit.mount.position_m(|name| self.points.position(name)),
                standoff_m: unit.standoff_m,
                supply_pa: unit.supply_pressure_pa,
                telescope_stroke_m: telescope.stroke_m,
                piston_stroke_m: piston.stroke_m,
                chamber_length_m: piston.chamber_length_m,
                spool_travel_m: valve.travel_m,
                chisel_travel_m: chisel.travel_m,
            }
        };
        scene.hammers.iter().map(hammer).collect()
    }

    /// The castings of the scene.
    pub(super) fn castings<'s>(&self, scene: &'s Scene) -> Vec<DrawnCasting<'s>> {
        let casting = |(index, casting): (usize, &'s Casting)| {
            let extent_m = self.extents_m.get(index).copied().flatten();
            let along = scene.measuring_axis(index);
            let [first, second] = across(along);
            let held = casting.fixtures.iter().map(|fixture| DrawnFixture {
                point: &fixture.point,
                at_m: fixture.place_m(),
                axis: fixture.axes()[0],
                along: dot(fixture.axes()[0], along),
            });
            let cores = casting.cores.iter().map(|core| Named { name: core.name.clone(), at: core.at_m });
            DrawnCasting {
                plan: CastingPlan::of(casting, extent_m),
                elastic: casting.elastic.is_some(),
                centre_height_m: casting.centre_height_m,
                axes: [first, second, along],
                extent_m,
                measured_m: casting.measuring_point_m.map(|_| casting.measured_place_m()),
                held: held.collect(),
                cores: cores.collect(),
            }
        };
        scene.castings.iter().enumerate().map(casting).collect()
    }
}

/// Whether a signal follows from the heave and the rotations of a rigid casting: it is the displacement of one of its points along the
/// direction in which it is measured.
pub(super) fn follows(scene: &Scene, of: SignalOf, quantity: &str) -> bool {
    let parallel = |casting: usize, axis: [f64; 3]| {
        let is_rigid = scene.castings[casting].elastic.is_none();
        is_rigid && dot(axis, scene.measuring_axis(casting)).abs() >= PARALLEL
    };
    match of {
        SignalOf::Hammer(hammer) if quantity == HammerSignals::casting_displacement_m.name => {
            let unit = &scene.hammers[hammer];
            parallel(unit.casting, unit.axis())
        }
        SignalOf::Fixture(casting, fixture) if quantity == FixtureSignals::casting_displacement_m.name => {
            parallel(casting, scene.castings[casting].fixtures[fixture].axes()[0])
        }
        SignalOf::Casting(casting) if quantity == CastingSignals::measuring_point_displacement_m.name => {
            scene.castings[casting].elastic.is_none()
        }
        _ => false,
    }
}

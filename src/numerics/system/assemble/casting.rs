//! Points of a casting: strike points, held points, the measuring point.

use super::columns::Columns;
use crate::scene::Scene;
use crate::system::layout::Layout;
use crate::system::model::{CastingPoint, CastingSlot};
use crate::system::points::{FixtureId, PointId, Points};

/// Name of a casting's measuring point among its points.
const MEASURING_POINT: &str = "measuring_point";

/// Point of a casting: id, name, position relative to the centre of mass.
type Place = (PointId, String, [f64; 2]);

/// Lists the points of a casting: strike points, held points, then the measuring point if the study sets one.
fn places(scene: &Scene, c: usize) -> Vec<Place> {
    let casting = &scene.castings[c];
    let strikes = scene.hammers.iter().enumerate().filter(|(_, unit)| unit.casting == c);
    let strikes = strikes
        .map(|(hammer, unit)| (PointId::Strike { hammer }, format!("hammer.{}", unit.name), unit.strike_point_m));
    let held = casting.fixtures.iter().enumerate().map(|(at, fixture)| {
        let id = PointId::Held(FixtureId { casting: c, fixture: at });
        (id, format!("fixture.{}", fixture.name), fixture.at_m)
    });
    let measured = casting.measuring_point_m;
    let measured = measured.map(|at_m| (PointId::Measured { casting: c }, MEASURING_POINT.to_owned(), at_m));
    strikes.chain(held).chain(measured).collect()
}

/// Adds the points of casting `c` of a scene.
pub(super) fn add_points(points: &mut Points, columns: &Columns, (scene, c): (&Scene, usize)) {
    places(scene, c).into_iter().for_each(|(id, _, at_m)| points.add(id, columns.castings[c].point(at_m)));
}

/// Returns the castings of the coupled system.
pub(super) fn slots(scene: &Scene, columns: &Columns, layout: &Layout) -> Vec<CastingSlot> {
    let slot = |c: usize| {
        let own = &columns.castings[c];
        let rotates = own.rotations.iter().any(Option::is_some);
        let (measured, named): (Vec<Place>, Vec<Place>) =
            places(scene, c).into_iter().partition(|(id, ..)| matches!(id, PointId::Measured { .. }));
        let watched = if rotates { named.len() } else { 1 };
        let points = named.into_iter().take(watched).chain(measured);
        CastingSlot {
            heave: own.heave,
            rotations: own.rotations,
            velocities: own.all().map(|body| layout.velocity(body)).collect(),
            points: points.map(|(id, name, at_m)| CastingPoint { id, name, row: own.point(at_m) }).collect(),
        }
    };
    (0..scene.castings.len()).map(slot).collect()
}

//! A hammer within the coupled system.

use crate::scene::{HammerLink, Owner, PointId, Scene};
use crate::system::elements::Elements;
use crate::system::model::HammerSlot;
use crate::system::points::Points;

/// Returns hammer `hammer` of a scene with the columns and contacts that it has.
pub(super) fn slot(scene: &Scene, hammer: usize, (points, elements): (&Points, &Elements)) -> HammerSlot {
    let unit = &scene.hammers[hammer];
    let column = |id: PointId| points.row(scene.point(id).id).first().map_or(0, |(column, _)| *column);
    let contact = |link: HammerLink| elements.contact_of(Owner::Hammer { hammer, link }).unwrap_or(0);
    HammerSlot {
        name: unit.name.clone(),
        model: unit.model(&scene.environment),
        points: std::array::from_fn(|body: usize| column(PointId::Body { hammer, body })),
        mount: column(PointId::Mount { hammer }),
        strike: contact(HammerLink::ChiselCasting),
        percussion: contact(HammerLink::PistonChisel),
        casting: unit.casting,
        supply_pressure_pa: unit.supply_pressure_pa,
        supply_times_s: std::iter::once(unit.start_time_s).chain(unit.supply_switch_times_s.iter().copied()).collect(),
        gate_delay_s: unit.gate_delay_s,
    }
}

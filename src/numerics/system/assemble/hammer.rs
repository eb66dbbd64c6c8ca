//! Points and links of a hammer: the spring of its guide, the contacts between its bodies, the contact with its casting.

use super::columns::Columns;
use crate::contact::{ContactLaw, ContactParameters};
use crate::hammer::{Gas, HammerModel, body};
use crate::scene::{Environment, HammerUnit, Scene};
use crate::system::elements::{Contact, ContactKind, ElementsBuilder, Spring};
use crate::system::model::HammerSlot;
use crate::system::points::{Owner, PointId, Points};

/// Adds the points of a hammer's bodies. The mount must be there already.
pub(super) fn add_points(points: &mut Points, columns: &Columns, hammer: usize) {
    for body in 0..body::COUNT {
        let row = match columns.body(hammer, body) {
            Some(column) => vec![(column, 1.0)],
            None => points.row(PointId::Mount { hammer }).to_vec(),
        };
        points.add(PointId::Body { hammer, body }, row);
    }
}

/// Adds the springs and contacts of one hammer.
pub(super) fn add_links(elements: &mut ElementsBuilder<'_>, scene: &Scene, hammer: usize) -> HammerSlot {
    let unit = &scene.hammers[hammer];
    let model = HammerModel::new(&unit.parameters, gas(&scene.environment), scene.environment.gravity_m_s2);
    let owner = Owner::Hammer(hammer);
    let of_body = |body: usize| PointId::Body { hammer, body };
    if !scene.ties(scene.solver.guide) {
        let stiffness_n_per_m = unit.parameters.guide.stiffness_n_per_m;
        let spring = Spring { stiffness_n_per_m, damping_n_s_per_m: 0.0, owner };
        elements.spring([of_body(body::GUIDE), PointId::Mount { hammer }], spring);
    }
    let mut percussion = 0;
    for (kind, bodies, parameters, offset_m) in internal_contacts(unit) {
        let law = internal_law(&parameters, model.mass(), bodies);
        let index = elements.contact(bodies.map(of_body), Contact { owner, kind, law, offset_m });
        if kind == ContactKind::PistonChisel {
            percussion = index;
        }
    }
    // The tip of the resting chisel stands `standoff` off the casting.
    let offset_m = model.rest().position[body::CHISEL] + unit.standoff_m;
    let law = unit.parameters.chisel.casting_contact.law(scene.strike_mass_kg(unit));
    let contact = Contact { owner, kind: ContactKind::ChiselCasting, law, offset_m };
    let strike = elements.contact([of_body(body::CHISEL), PointId::Strike { hammer }], contact);
    let column = |point: PointId| elements.points().row(point).first().map_or(0, |(column, _)| *column);
    HammerSlot {
        name: unit.name.clone(),
        model,
        points: std::array::from_fn(|body| column(of_body(body))),
        mount: column(PointId::Mount { hammer }),
        strike,
        percussion,
        casting: unit.casting,
        supply_pressure_pa: unit.supply_pressure_pa,
        supply_times_s: std::iter::once(unit.start_time_s).chain(unit.supply_switch_times_s.iter().copied()).collect(),
        gate_delay_s: unit.gate_delay_s,
    }
}

/// Contacts within a hammer: kind, the bodies with coefficients +1 and -1, parameters, offset.
fn internal_contacts(unit: &HammerUnit) -> [(ContactKind, [usize; 2], ContactParameters, f64); 8] {
    use ContactKind::{EndStop, Nose, PistonChisel, RearWall, Retainer, SpoolFront, SpoolRear, TopStop};
    use body::{CHISEL, CYLINDER, GUIDE, PISTON, SPOOL};
    let p = &unit.parameters;
    let (nose, stop) = (p.chisel.cylinder_contact, p.valve.stop);
    [
        (TopStop, [GUIDE, CYLINDER], p.telescope.top_stop, 0.0),
        (EndStop, [CYLINDER, GUIDE], p.telescope.end_stop, p.telescope.stroke_m),
        (RearWall, [CYLINDER, PISTON], p.piston.rear_wall, 0.0),
        (PistonChisel, [PISTON, CHISEL], p.piston.chisel_contact, p.piston.stroke_m),
        (Nose, [CYLINDER, CHISEL], nose, 0.0),
        (Retainer, [CHISEL, CYLINDER], nose, p.chisel.travel_m),
        (SpoolRear, [CYLINDER, SPOOL], stop, 0.0),
        (SpoolFront, [SPOOL, CYLINDER], stop, p.valve.travel_m),
    ]
}

/// Law of a contact between two bodies of a hammer. The guide stands on its mount: only the other body's mass counts.
fn internal_law(parameters: &ContactParameters, mass: &[f64; body::COUNT], bodies: [usize; 2]) -> ContactLaw {
    let inverse = bodies.iter().filter(|body| **body != body::GUIDE).map(|body| 1.0 / mass[*body]).sum::<f64>();
    parameters.law(1.0 / inverse)
}

fn gas(environment: &Environment) -> Gas {
    Gas {
        specific_energy_j_per_kg: environment.gas_constant_j_per_kg_k * environment.temperature_k,
        isentropic_exponent: environment.isentropic_exponent,
        inflow_exponent: environment.inflow_exponent,
        outflow_exponent: environment.outflow_exponent,
        expansion_exponent: environment.expansion_exponent,
        ambient_pressure_pa: environment.ambient_pressure_pa,
    }
}

//! Strike of a chisel on its casting, from the inputs alone: mass, largest speed, and contacts that are too soft or too damped.

use std::f64::consts::PI;

use super::links::{Location, Part, PartId};
use super::model::{HammerUnit, Scene};
use crate::parameter::{Fault, short};

/// Penetration over the chisel's free travel from which a contact is too soft to describe a deformation of the surface.
pub const DEEP_SHARE: f64 = 0.25;
/// Force at touch over the elastic force of the same contact from which the damper rules the peak.
pub const JUMP_RATIO: f64 = 2.0;

impl Scene {
    /// Reduced mass in kg of a hammer's chisel and its casting, whose mass counts as at the strike point:
    /// `1/m + y^2/J_x + x^2/J_y` under a vertical strike, with the rotations that it has. The chisel's own mass where the casting is not rigid or not held.
    pub fn strike_mass_kg(&self, unit: &HammerUnit) -> f64 {
        let casting = self.part(PartId::Casting(unit.casting));
        let Ok(part @ Part::Rigid(freedoms)) = &casting else { return unit.parameters.chisel.mass_kg };
        let row = part.row(&Location::Offset(unit.strike_place_m()), unit.axis());
        let inverse = row.iter().map(|(freedom, lever)| lever * lever / freedoms[*freedom].1);
        1.0 / inverse.fold(1.0 / unit.parameters.chisel.mass_kg, |sum, inverse| sum + inverse)
    }

    /// Largest possible speed in m/s of a hammer before its first impact: all work of the supply on the telescope's bore over the standoff
    /// becomes kinetic energy.
    fn largest_strike_speed_m_s(&self, unit: &HammerUnit) -> f64 {
        let p = &unit.parameters;
        let area_m2 = 0.25 * PI * p.telescope.bore_m * p.telescope.bore_m;
        let mass_kg = p.telescope.cylinder_mass_kg + p.valve.mass_kg + p.piston.mass_kg + p.chisel.mass_kg;
        let force_n = (unit.supply_pressure_pa - self.environment.ambient_pressure_pa) * area_m2;
        let weight_n = mass_kg * self.environment.gravity_along(unit.axis());
        let energy_j = (force_n + weight_n) * unit.standoff_m.min(p.telescope.stroke_m);
        (2.0 * energy_j.max(0.0) / mass_kg).sqrt()
    }

    /// Remarks about a chisel's contact with its casting.
    pub(super) fn contact_remarks(&self, unit: &HammerUnit) -> Vec<Fault> {
        let Some(casting) = self.castings.get(unit.casting) else { return Vec::new() };
        let chisel = &unit.parameters.chisel;
        let (mass_kg, speed_m_s) = (self.strike_mass_kg(unit), self.largest_strike_speed_m_s(unit));
        let law = chisel.casting_contact.law(mass_kg);
        let energy_j = 0.5 * mass_kg * speed_m_s * speed_m_s;
        let (depth_m, jump_n) = (law.depth_of_energy(energy_j), law.jump(speed_m_s));
        let path = |key: &str| format!("hammer.{}.parameters.chisel.casting_contact.{key}", unit.name);
        let mut remarks = Vec::new();
        if depth_m > DEEP_SHARE * chisel.travel_m {
            let stiff = chisel
                .casting_contact
                .power_stiffness_n_per_m_n
                .map_or("stiffness_n_per_m", |_| "power_stiffness_n_per_m_n");
            let message = format!(
                "the contact is too soft: by its energy alone the chisel goes {} mm into casting `{}` at up to {speed_m_s:.1} m/s, \
                 expected less than a quarter of the chisel's travel of {} mm",
                short(decimals(1e3 * depth_m)),
                casting.name,
                short(decimals(1e3 * chisel.travel_m))
            );
            remarks.push(Fault { path: path(stiff), message });
        }
        let elastic_n = law.closed_force(law.depth_of_energy(energy_j), 0.0);
        if jump_n > JUMP_RATIO * elastic_n {
            let damping = chisel.casting_contact.restitution.map_or("damping_n_s_per_m", |_| "restitution");
            let message = format!(
                "the contact begins with a jump of the damper's force, {:.0} kN at up to {speed_m_s:.1} m/s, where its spring alone \
                 makes {:.0} kN: peak forces are the damper's. Take a larger restitution or less damping, or, for a restitution near 0, \
                 `law = \"kelvin_voigt_separating\"`; `hertz` and `hunt_crossley` have no jump",
                1e-3 * jump_n,
                1e-3 * elastic_n
            );
            remarks.push(Fault { path: path(damping), message });
        }
        remarks
    }
}

/// Two decimals.
fn decimals(value: f64) -> f64 {
    (100.0 * value).round() / 100.0
}

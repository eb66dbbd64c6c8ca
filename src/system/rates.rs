//! The right-hand side of the coupled system: motion of all points, forces, accelerations, quadratures.

use pulp::{Arch, Simd, WithSimd};

use crate::hammer::{HammerState, body};
use crate::system::coupled::Coupled;
use crate::system::elements::ContactKind;
use crate::system::layout::HammerQuadrature;
use crate::system::modal::Motion;

/// Sums over one right-hand side.
#[derive(Default)]
struct Power {
    put_in: f64,
    dissipated: f64,
}

impl Coupled<'_> {
    /// Writes the rates of the state at `(t, y)`.
    pub(super) fn rates(&mut self, t: f64, y: &[f64], rate: &mut [f64]) {
        // The widest vector registers that the processor has; the order of sums, and so the result, is the same with all.
        Arch::new().dispatch(Evaluation { system: self, t, y, rate });
    }

    /// Writes the right-hand side.
    #[inline(always)]
    fn evaluate(&mut self, t: f64, y: &[f64], rate: &mut [f64]) {
        let mut power = Power::default();
        self.gather(t, y);
        self.force.fill(0.0);
        self.hammers(y, rate, &mut power);
        self.elements(rate, &mut power);
        self.accelerations(y, rate, &mut power);
        rate[self.model.layout.work_in()] = power.put_in;
        rate[self.model.layout.dissipated()] = power.dissipated;
    }

    /// Displacements and velocities of all points: bodies as they are, interface points from the structure.
    #[inline(always)]
    fn gather(&mut self, t: f64, y: &[f64]) {
        let layout = &self.model.layout;
        let b = layout.bodies;
        self.displacement[..b].copy_from_slice(&y[layout.position(0)..layout.velocities()]);
        self.velocity[..b].copy_from_slice(&y[layout.velocity(0)..layout.velocity(b)]);
        // Only tied guides ask for accelerations, and hammers' mounts are the first points.
        let accelerated = self.model.tied.as_ref().map_or(0, |tied| tied.mass.len());
        let mut motion = Motion {
            displacement: &mut self.displacement[b..],
            velocity: &mut self.velocity[b..],
            acceleration: &mut self.acceleration[..accelerated],
        };
        let states = &y[layout.structure_displacements()];
        match (&self.base, &self.model.condensation) {
            (Some(base), Some(condensation)) => {
                condensation.motion(base, t - base.time_s, states, &mut motion);
            }
            _ => {
                let velocities = &y[layout.structure_velocities()];
                let modes = &self.model.modes;
                self.modal_loss = modes.free_accelerations(states, velocities, &mut self.free);
                modes.motion([states, velocities, &self.free], &mut motion);
            }
        }
    }

    /// Forces, pressure rates and quadratures of the hammers.
    #[inline(always)]
    fn hammers(&mut self, y: &[f64], rate: &mut [f64], power: &mut Power) {
        let model = self.model;
        let layout = &model.layout;
        for (h, slot) in model.hammers.iter().enumerate() {
            let mut pressure = [0.0; 4];
            pressure.copy_from_slice(&y[layout.pressures(h)]);
            let supply_on = self.supply_switched[h] % 2 == 1;
            let supply_pa = if supply_on { slot.supply_pressure_pa } else { model.ambient_pressure_pa };
            let state = HammerState {
                position: slot.points.map(|point| self.displacement[point]),
                velocity: slot.points.map(|point| self.velocity[point]),
                pressure,
                supply_pa,
                gate_open: self.gate_open[h],
            };
            let rates = slot.model.evaluate(&state);
            for i in 0..body::COUNT {
                self.force[slot.points[i]] += rates.force[i];
            }
            rate[layout.pressures(h)].copy_from_slice(&rates.pressure_rate);
            // What flows back into a line that is vented does not return to the supply.
            let drawn = if self.vented(h) { 0.0 } else { rates.supply_flow_kg_s };
            rate[layout.quadrature(h, HammerQuadrature::Air)] = drawn;
            let arm = self.velocity[layout.bodies + slot.mount];
            rate[layout.quadrature(h, HammerQuadrature::ArmVelocitySquared)] = arm * arm;
            rate[layout.quadrature(h, HammerQuadrature::Work)] = 0.0;
            rate[layout.quadrature(h, HammerQuadrature::Impulse)] = 0.0;
            let (supplied, expansion) = (layout.chambers_supplied(h), layout.chambers_expansion(h));
            for ((balance, supplied), expansion) in rates.balance.iter().zip(supplied).zip(expansion) {
                rate[supplied] = balance.supplied_w;
                rate[expansion] = balance.expansion_w;
            }
            power.put_in += rates.power_in_w;
            power.dissipated += rates.dissipation_w;
        }
    }

    /// Forces of springs and closed contacts.
    #[inline(always)]
    fn elements(&mut self, rate: &mut [f64], power: &mut Power) {
        let model = self.model;
        let elements = &model.elements;
        for (row, spring) in elements.springs().iter().enumerate() {
            let [extension, speed] = elements.values(row, [&self.displacement, &self.velocity]);
            let force = spring.stiffness_n_per_m * extension + spring.damping_n_s_per_m * speed;
            elements.apply(row, force, &mut self.force);
            power.dissipated += spring.damping_n_s_per_m * speed * speed;
        }
        for &index in &self.acting {
            let (contact, row) = (&elements.contacts()[index], elements.contact_row(index));
            let [d, speed] = elements.values(row, [&self.displacement, &self.velocity]);
            let penetration = d - contact.offset_m;
            if self.following && contact.law.onset_indicator(penetration, speed) <= 0.0 {
                continue;
            }
            let force = contact.law.closed_force(penetration, speed);
            elements.apply(row, force, &mut self.force);
            power.dissipated += contact.law.dissipated_power(penetration, speed);
            if contact.kind == ContactKind::ChiselCasting {
                let chisel = model.hammers[contact.hammer].points[body::CHISEL];
                let casting_speed = self.velocity[chisel] - speed;
                let quadrature = |q| model.layout.quadrature(contact.hammer, q);
                rate[quadrature(HammerQuadrature::Work)] = force * casting_speed;
                rate[quadrature(HammerQuadrature::Impulse)] = force;
            }
        }
    }

    /// Accelerations of the bodies and rates of the structure from the forces on the points; tied guides take their share of the
    /// forces on their mounts.
    #[inline(always)]
    fn accelerations(&mut self, y: &[f64], rate: &mut [f64], power: &mut Power) {
        let model = self.model;
        let layout = &model.layout;
        let b = layout.bodies;
        rate[layout.position(0)..layout.velocities()].copy_from_slice(&y[layout.velocity(0)..layout.velocity(b)]);
        let acceleration = &mut rate[layout.velocity(0)..layout.velocity(b)];
        for ((acceleration, force), mass) in acceleration.iter_mut().zip(&self.force).zip(&model.body_mass) {
            *acceleration = force / mass;
        }
        let force = &mut self.force[b..];
        if let Some(tied) = &model.tied {
            tied.share(force, &mut self.acceleration);
        }
        if model.condensation.is_some() {
            self.integral_rates(y, rate);
        } else {
            self.modal_rates(y, rate);
            power.dissipated += self.modal_loss;
        }
    }

    /// `z_1' = F`, `z_{k+1}' = z_k`.
    #[inline(always)]
    fn integral_rates(&self, y: &[f64], rate: &mut [f64]) {
        let layout = &self.model.layout;
        let force = &self.force[layout.bodies..];
        let (points, states) = (force.len(), layout.structure[0]);
        rate[..points].copy_from_slice(force);
        rate[points..states].copy_from_slice(&y[..states - points]);
    }

    /// `x'' = -omega^2 x - 2 xi omega x' + Phi F` per mode.
    #[inline(always)]
    fn modal_rates(&self, y: &[f64], rate: &mut [f64]) {
        let layout = &self.model.layout;
        rate[layout.structure_displacements()].copy_from_slice(&y[layout.structure_velocities()]);
        let acceleration = &mut rate[layout.structure_velocities()];
        acceleration.copy_from_slice(&self.free);
        self.model.modes.add_forces(&self.force[layout.bodies..], acceleration);
    }
}

/// A right-hand side to be evaluated.
struct Evaluation<'e, 'a> {
    system: &'e mut Coupled<'a>,
    t: f64,
    y: &'e [f64],
    rate: &'e mut [f64],
}

impl WithSimd for Evaluation<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.system.evaluate(self.t, self.y, self.rate);
    }
}

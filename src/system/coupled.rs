//! The coupled model with its discrete state, as the integrator sees it.

use nalgebra::{DVector, DVectorView, DVectorViewMut};

use crate::hammer::{HammerState, body};
use crate::integrate::{GuardSample, System};
use crate::system::elements::ContactKind;
use crate::system::layout::HammerQuadrature;
use crate::system::model::CoupledModel;

/// A coupled model being integrated: which contacts are closed, which supplies and gates are open, and scratch memory.
#[derive(Debug, Clone)]
pub struct Coupled<'a> {
    model: &'a CoupledModel,
    closed: Vec<bool>,
    supply_on: Vec<bool>,
    gate_open: Vec<bool>,
    /// When each gate opens; infinite until the hammer's first contact.
    gate_time_s: Vec<f64>,
    /// Energy that springs of contacts held when these opened under compression, J.
    released_energy_j: f64,
    displacement: Vec<f64>,
    velocity: Vec<f64>,
    force: Vec<f64>,
    /// Accelerations of the tied guides' mounts, and their correction.
    mount_acceleration: DVector<f64>,
    mount_correction: DVector<f64>,
}

/// Sums over one right-hand side.
#[derive(Default)]
struct Power {
    put_in: f64,
    dissipated: f64,
}

impl<'a> Coupled<'a> {
    /// The model at rest.
    pub fn new(model: &'a CoupledModel) -> Self {
        let hammers = model.hammers.len();
        let points = model.layout.bodies + model.phi.ncols();
        let tied = model.tied.as_ref().map_or(0, |tied| tied.mounts.len());
        let closed = (0..model.elements.contacts().len())
            .map(|contact| {
                let (d, rate) = model.penetration(contact, &model.initial);
                model.elements.contacts()[contact].law.onset_indicator(d, rate) > 0.0
            })
            .collect();
        Self {
            model,
            closed,
            supply_on: vec![false; hammers],
            gate_open: vec![false; hammers],
            gate_time_s: vec![f64::INFINITY; hammers],
            released_energy_j: 0.0,
            displacement: vec![0.0; points],
            velocity: vec![0.0; points],
            force: vec![0.0; points],
            mount_acceleration: DVector::zeros(tied),
            mount_correction: DVector::zeros(tied),
        }
    }

    /// The constants.
    pub fn model(&self) -> &'a CoupledModel {
        self.model
    }

    /// Whether a contact is closed.
    pub fn is_closed(&self, contact: usize) -> bool {
        self.closed[contact]
    }

    /// Whether a hammer's percussion gate is open.
    pub fn gate_open(&self, hammer: usize) -> bool {
        self.gate_open[hammer]
    }

    /// Force of a contact at a state in N; 0 while it is open.
    pub fn contact_force(&self, contact: usize, y: &[f64]) -> f64 {
        if !self.closed[contact] {
            return 0.0;
        }
        let (d, rate) = self.model.penetration(contact, y);
        self.model.elements.contacts()[contact].law.closed_force(d, rate)
    }

    /// Energy stored at a state, J.
    pub fn stored_energy(&self, y: &[f64]) -> f64 {
        self.model.stored_energy(y, &self.closed)
    }

    /// Energy dissipated up to a state, J, what opening contacts released included.
    pub fn dissipated_energy(&self, y: &[f64]) -> f64 {
        y[self.model.layout.dissipated()] + self.released_energy_j
    }

    /// Displacements and velocities of all points: bodies as they are, interface points from the modes.
    fn gather(&mut self, y: &[f64]) {
        let layout = &self.model.layout;
        let (n, m, b) = (layout.mechanical(), layout.modes, layout.bodies);
        for (points, state) in [(&mut self.displacement, &y[..n]), (&mut self.velocity, &y[n..2 * n])] {
            points[..b].copy_from_slice(&state[m..]);
            let nodes = points.len() - b;
            DVectorViewMut::from_slice(&mut points[b..], nodes).gemv_tr(
                1.0,
                &self.model.phi,
                &DVectorView::from_slice(&state[..m], m),
                0.0,
            );
        }
    }

    /// Forces, pressure rates and quadratures of the hammers.
    fn hammers(&mut self, y: &[f64], rate: &mut [f64], power: &mut Power) {
        let model = self.model;
        let layout = &model.layout;
        for (h, slot) in model.hammers.iter().enumerate() {
            let mut pressure = [0.0; 4];
            pressure.copy_from_slice(&y[layout.pressures(h)]);
            let supply_pa = if self.supply_on[h] { slot.supply_pressure_pa } else { model.ambient_pressure_pa };
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
            rate[layout.quadrature(h, HammerQuadrature::Air)] = rates.supply_flow_kg_s;
            let arm = self.velocity[layout.bodies + slot.mount];
            rate[layout.quadrature(h, HammerQuadrature::ArmVelocitySquared)] = arm * arm;
            rate[layout.quadrature(h, HammerQuadrature::Work)] = 0.0;
            rate[layout.quadrature(h, HammerQuadrature::Impulse)] = 0.0;
            power.put_in += rates.power_in_w;
            power.dissipated += rates.dissipation_w;
        }
    }

    /// Forces of springs and closed contacts.
    fn elements(&mut self, rate: &mut [f64], power: &mut Power) {
        let model = self.model;
        let elements = &model.elements;
        for (row, spring) in elements.springs().iter().enumerate() {
            let speed = elements.value(row, &self.velocity);
            let force =
                spring.stiffness_n_per_m * elements.value(row, &self.displacement) + spring.damping_n_s_per_m * speed;
            elements.apply(row, force, &mut self.force);
            power.dissipated += spring.damping_n_s_per_m * speed * speed;
        }
        for (index, contact) in elements.contacts().iter().enumerate() {
            if !self.closed[index] {
                continue;
            }
            let row = elements.contact_row(index);
            let speed = elements.value(row, &self.velocity);
            let penetration = elements.value(row, &self.displacement) - contact.offset_m;
            let force = contact.law.closed_force(penetration, speed);
            elements.apply(row, force, &mut self.force);
            power.dissipated += contact.law.damping_n_s_per_m * speed * speed;
            if contact.kind == ContactKind::ChiselCasting {
                let chisel = model.hammers[contact.hammer].points[body::CHISEL];
                let casting_speed = self.velocity[chisel] - speed;
                let quadrature = |q| model.layout.quadrature(contact.hammer, q);
                rate[quadrature(HammerQuadrature::Work)] = force * casting_speed;
                rate[quadrature(HammerQuadrature::Impulse)] = force;
            }
        }
    }

    /// Accelerations of modes and bodies from the forces on the points.
    fn accelerations(&mut self, y: &[f64], rate: &mut [f64], power: &mut Power) {
        let model = self.model;
        let layout = &model.layout;
        let (n, m, b) = (layout.mechanical(), layout.modes, layout.bodies);
        rate[..n].copy_from_slice(&y[n..2 * n]);
        let (x, v) = (&y[..m], &y[n..n + m]);
        let acceleration = &mut rate[n..n + m];
        let mut modal_loss = 0.0;
        for s in 0..m {
            let damping = model.modal_damping[s] * v[s];
            acceleration[s] = -model.omega_squared[s] * x[s] - damping;
            modal_loss += damping * v[s];
        }
        power.dissipated += modal_loss;
        let mut acceleration = DVectorViewMut::from_slice(acceleration, m);
        let node_force = DVectorView::from_slice(&self.force[b..], self.force.len() - b);
        acceleration.gemv(1.0, &model.phi, &node_force, 1.0);
        if let Some(tied) = &model.tied {
            for (at, &mount) in tied.mounts.iter().enumerate() {
                self.mount_acceleration[at] = model.phi.column(mount).dot(&acceleration);
            }
            self.mount_correction.gemv(1.0, &tied.update, &self.mount_acceleration, 0.0);
            for (at, &mount) in tied.mounts.iter().enumerate() {
                acceleration.axpy(-self.mount_correction[at], &model.phi.column(mount), 1.0);
            }
        }
        for (body, mass) in model.body_mass.iter().enumerate() {
            rate[layout.velocity(body)] = self.force[body] / mass;
        }
    }

    fn refresh_gate(&mut self, contact: usize, t: f64) {
        let hammer = self.model.elements.contacts()[contact].hammer;
        let first = self.gate_time_s[hammer].is_infinite();
        if first && self.model.hammers[hammer].strike == contact {
            self.gate_time_s[hammer] = t + self.model.hammers[hammer].gate_delay_s;
        }
    }

    /// The pending stop that is due first: its time, its hammer, and whether it is the supply's.
    fn pending(&self) -> Option<(f64, usize, bool)> {
        let hammers = 0..self.model.hammers.len();
        let supplies =
            hammers.clone().filter(|&h| !self.supply_on[h]).map(|h| (self.model.hammers[h].start_time_s, h, true));
        let gates = hammers
            .filter(|&h| !self.gate_open[h] && self.gate_time_s[h].is_finite())
            .map(|h| (self.gate_time_s[h], h, false));
        supplies.chain(gates).min_by(|a, b| a.0.total_cmp(&b.0))
    }
}

impl System for Coupled<'_> {
    fn dimension(&self) -> usize {
        self.model.layout.dimension()
    }

    fn controlled(&self) -> usize {
        self.model.layout.states()
    }

    fn scales(&self) -> &[f64] {
        &self.model.scales
    }

    fn rhs(&mut self, _t: f64, y: &[f64], rate: &mut [f64]) {
        let mut power = Power::default();
        self.gather(y);
        self.force.fill(0.0);
        self.hammers(y, rate, &mut power);
        self.elements(rate, &mut power);
        self.accelerations(y, rate, &mut power);
        rate[self.model.layout.work_in()] = power.put_in;
        rate[self.model.layout.dissipated()] = power.dissipated;
    }

    fn guard_count(&self) -> usize {
        self.closed.len()
    }

    fn guard_support(&self, guard: usize) -> &[usize] {
        &self.model.supports[guard]
    }

    fn guard(&self, guard: usize, y: &[f64]) -> f64 {
        let (d, rate) = self.model.penetration(guard, y);
        let law = &self.model.elements.contacts()[guard].law;
        if self.closed[guard] { -law.closed_force(d, rate) } else { law.onset_indicator(d, rate) }
    }

    fn sample_guards(&self, y: &[f64], rate: &[f64], samples: &mut [GuardSample]) {
        let elements = &self.model.elements;
        for (guard, sample) in samples.iter_mut().enumerate() {
            let law = &elements.contacts()[guard].law;
            let (d, speed) = self.model.penetration(guard, y);
            *sample = if self.closed[guard] {
                let (_, acceleration) = self.model.relative_motion(elements.contact_row(guard), rate);
                let value = -law.closed_force(d, speed);
                GuardSample { value, smooth: value, smooth_rate: -law.closed_force(speed, acceleration) }
            } else {
                GuardSample { value: law.onset_indicator(d, speed), smooth: d, smooth_rate: speed }
            };
        }
    }

    fn switch(&mut self, guard: usize, t: f64, y: &mut [f64]) {
        let (d, _) = self.model.penetration(guard, y);
        let stored = self.model.elements.contacts()[guard].law.stored_energy(d);
        self.closed[guard] = !self.closed[guard];
        if self.closed[guard] {
            self.released_energy_j -= stored;
            self.refresh_gate(guard, t);
        } else {
            self.released_energy_j += stored;
        }
    }

    fn next_stop(&self) -> f64 {
        self.pending().map_or(f64::INFINITY, |(t, ..)| t)
    }

    fn pass_stop(&mut self) {
        match self.pending() {
            Some((_, hammer, true)) => self.supply_on[hammer] = true,
            Some((_, hammer, false)) => self.gate_open[hammer] = true,
            None => {}
        }
    }

    fn diagnose(&self, t: f64, y: &[f64]) -> String {
        if y.iter().any(|value| !value.is_finite()) {
            return format!("the state is no longer finite at t = {t:.6} s");
        }
        for (h, slot) in self.model.hammers.iter().enumerate() {
            let state = self.model.hammer_state(h, y);
            for (i, volume) in slot.model.volumes(&state.position).into_iter().enumerate() {
                if volume < 1e-9 {
                    return format!(
                        "chamber {} of hammer {} is driven to a volume of {volume:.2e} m3 at t = {t:.6} s",
                        i + 1,
                        h + 1
                    );
                }
            }
        }
        format!("the step size fell below the resolution of time at t = {t:.6} s")
    }
}

//! The coupled model with its discrete state, as the integrator sees it.

use pulp::{Arch, Simd, WithSimd};

use crate::hammer::{HammerState, body, chamber};
use crate::integrate::{GuardSample, StiffBlock, StiffMatrices, System};
use crate::system::elements::ContactKind;
use crate::system::impulse_response::{self, Base};
use crate::system::layout::HammerQuadrature;
use crate::system::modal::Motion;
use crate::system::model::CoupledModel;

/// Most bodies for which exponential steps are offered: those of one hammer and what it strikes, and one hammer more.
const STIFF_BODIES: usize = 10;

/// A coupled model being integrated: which contacts are closed, which supplies and gates are open, and scratch memory.
#[derive(Debug, Clone)]
pub struct Coupled<'a> {
    pub(super) model: &'a CoupledModel,
    /// The condensed modes at their last rebase; `None` if modes are integrated.
    pub(super) base: Option<Base>,
    pub(super) closed: Vec<bool>,
    /// Whether forces of contacts follow the state alone, see [`System::follow_state`].
    following: bool,
    /// Contacts that may exert a force: the closed ones, or all where forces follow the state.
    acting: Vec<usize>,
    /// How often each supply has been switched: it is on after an odd number of times.
    supply_switched: Vec<usize>,
    gate_open: Vec<bool>,
    /// When each gate opens; infinite until the hammer's first contact.
    gate_time_s: Vec<f64>,
    /// Energy that springs of contacts held when these opened under compression, J.
    pub(super) released_energy_j: f64,
    displacement: Vec<f64>,
    velocity: Vec<f64>,
    force: Vec<f64>,
    /// Accelerations of interface points without what forces on them cause at once; changed when guides take their share.
    acceleration: Vec<f64>,
    /// Accelerations of integrated modes without forces, and the power that they dissipate, W.
    free: Vec<f64>,
    modal_loss: f64,
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
        let points = model.layout.bodies + model.modes.phi.ncols();
        let mut system = Self {
            model,
            base: model.condensation.as_ref().map(Base::at_rest),
            closed: vec![false; model.elements.contacts().len()],
            following: false,
            acting: Vec::with_capacity(model.elements.contacts().len()),
            supply_switched: vec![0; hammers],
            gate_open: vec![false; hammers],
            gate_time_s: vec![f64::INFINITY; hammers],
            released_energy_j: 0.0,
            displacement: vec![0.0; points],
            velocity: vec![0.0; points],
            force: vec![0.0; points],
            acceleration: vec![0.0; model.modes.phi.ncols()],
            free: vec![0.0; model.layout.structure[1]],
            modal_loss: 0.0,
        };
        for contact in 0..system.closed.len() {
            let (d, rate) = system.penetration(contact, 0.0, &model.initial);
            system.closed[contact] = model.elements.contacts()[contact].law.onset_indicator(d, rate) > 0.0;
        }
        system.list_acting();
        system
    }

    /// The constants.
    pub fn model(&self) -> &'a CoupledModel {
        self.model
    }

    /// Whether a contact is closed.
    pub fn is_closed(&self, contact: usize) -> bool {
        self.closed[contact]
    }

    /// How often a hammer's supply has been switched on so far: the number of its strokes.
    pub fn strokes(&self, hammer: usize) -> usize {
        self.supply_switched[hammer].div_ceil(2)
    }

    /// Whether a hammer's percussion gate is open.
    pub fn gate_open(&self, hammer: usize) -> bool {
        self.gate_open[hammer]
    }

    /// Lists the contacts that may exert a force.
    fn list_acting(&mut self) {
        self.acting.clear();
        let (closed, following) = (&self.closed, self.following);
        self.acting.extend((0..closed.len()).filter(|&contact| following || closed[contact]));
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
        let mut motion = Motion {
            displacement: &mut self.displacement[b..],
            velocity: &mut self.velocity[b..],
            acceleration: &mut self.acceleration,
        };
        // Only tied guides ask for accelerations, and hammers' mounts are the first points.
        let accelerated = self.model.tied.as_ref().map_or(0, |tied| tied.mass.len());
        let states = &y[layout.structure_displacements()];
        match (&self.base, &self.model.condensation) {
            (Some(base), Some(condensation)) => {
                condensation.motion((base, t - base.time_s), states, accelerated, &mut motion);
            }
            _ => {
                let velocities = &y[layout.structure_velocities()];
                let modes = &self.model.modes;
                self.modal_loss = modes.free_accelerations(states, velocities, &mut self.free);
                modes.motion([states, velocities, &self.free], accelerated, &mut motion);
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

    fn refresh_gate(&mut self, contact: usize, t: f64) {
        let hammer = self.model.elements.contacts()[contact].hammer;
        let first = self.gate_time_s[hammer].is_infinite();
        if first && !self.vented(hammer) && self.model.hammers[hammer].strike == contact {
            self.gate_time_s[hammer] = t + self.model.hammers[hammer].gate_delay_s;
        }
    }

    /// Whether a hammer's supply has been switched off.
    fn vented(&self, hammer: usize) -> bool {
        self.supply_switched[hammer] > 0 && self.supply_switched[hammer].is_multiple_of(2)
    }

    /// Switches a supply over. Off ends the percussion; on starts the hammer anew: the gate waits for the next contact,
    /// or from now where the chisel rests on the casting.
    fn switch_supply(&mut self, hammer: usize, time_s: f64) {
        let slot = &self.model.hammers[hammer];
        self.supply_switched[hammer] += 1;
        if self.vented(hammer) {
            self.gate_open[hammer] = false;
            self.gate_time_s[hammer] = f64::INFINITY;
        } else if self.supply_switched[hammer] > 1 && self.closed[slot.strike] {
            self.gate_time_s[hammer] = time_s + slot.gate_delay_s;
        }
    }

    /// The pending stop that is due first: its time, its hammer, and whether it is the supply's.
    fn pending(&self) -> Option<(f64, usize, bool)> {
        let hammers = 0..self.model.hammers.len();
        let supplies = hammers.clone().filter_map(|h| {
            let time = self.model.hammers[h].supply_times_s.get(self.supply_switched[h])?;
            Some((*time, h, true))
        });
        let gates = hammers
            .filter(|&h| !self.gate_open[h] && self.gate_time_s[h].is_finite())
            .map(|h| (self.gate_time_s[h], h, false));
        supplies.chain(gates).min_by(|a, b| a.0.total_cmp(&b.0))
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

    fn rhs(&mut self, t: f64, y: &[f64], rate: &mut [f64]) {
        // The widest vector registers that the processor has; the order of sums, and so the result, is the same with all.
        Arch::new().dispatch(Evaluation { system: self, t, y, rate });
    }

    fn guard_count(&self) -> usize {
        self.closed.len()
    }

    fn guard_support(&self, guard: usize) -> &[usize] {
        &self.model.supports[guard]
    }

    fn guard(&self, guard: usize, t: f64, y: &[f64]) -> f64 {
        let (d, rate) = self.penetration(guard, t, y);
        let law = &self.model.elements.contacts()[guard].law;
        if self.closed[guard] { law.release_indicator(d, rate) } else { law.onset_indicator(d, rate) }
    }

    fn sample_guards(&mut self, t: f64, (y, rate): (&[f64], &[f64]), samples: &mut [GuardSample]) {
        // The motion of all points is at hand from the right-hand side.
        let elements = &self.model.elements;
        for (guard, sample) in samples.iter_mut().enumerate() {
            let (contact, row) = (&elements.contacts()[guard], elements.contact_row(guard));
            let law = &contact.law;
            let [d, speed] = elements.values(row, [&self.displacement, &self.velocity]);
            let d = d - contact.offset_m;
            *sample = if self.closed[guard] {
                let acceleration = self.relative_acceleration(row, t, (y, rate));
                let (smooth, smooth_rate) = law.smooth_release(d, speed, acceleration);
                GuardSample { value: law.release_indicator(d, speed), smooth, smooth_rate }
            } else {
                GuardSample { value: law.onset_indicator(d, speed), smooth: d, smooth_rate: speed }
            };
        }
    }

    fn follow_state(&mut self, follow: bool) -> bool {
        self.following = follow;
        self.list_acting();
        follow
    }

    fn horizon(&self) -> f64 {
        match (&self.base, &self.model.condensation) {
            (Some(base), Some(condensation)) => base.time_s + condensation.horizon_s,
            _ => f64::INFINITY,
        }
    }

    fn rebase(&mut self, t: f64, y: &mut [f64], rate: &mut [f64]) {
        let layout = &self.model.layout;
        if let (Some(base), Some(condensation)) = (&mut self.base, &self.model.condensation) {
            let (z, rate) = (&mut y[layout.structure_displacements()], &mut rate[layout.structure_displacements()]);
            base.rebase(condensation, t, z);
            z.fill(0.0);
            // The rates of the first integrals are the forces: they stay.
            rate[self.acceleration.len()..].fill(0.0);
        }
    }

    fn stiff_block(&self) -> Option<StiffBlock> {
        let model = self.model;
        let (layout, contacts) = (&model.layout, model.elements.contacts());
        let linear = contacts.iter().all(|contact| contact.law.linear().is_some());
        // A guide on its spring is joined to the structure as stiffly as bodies are among each other: its step stays short.
        // Integrated modes would not feel the impulses that the bodies do.
        let integrals = match (&model.condensation, model.modes.phi.is_empty()) {
            (Some(_), _) => (0, model.modes.phi.ncols(), impulse_response::ORDER),
            (None, true) => (0, 0, 0),
            (None, false) => return None,
        };
        let few = layout.bodies <= STIFF_BODIES && contacts.len() <= u64::BITS as usize;
        (linear && few && model.tied.is_some()).then_some(StiffBlock {
            positions: layout.position(0),
            velocities: layout.velocity(0),
            bodies: layout.bodies,
            integrals,
            relaxing: (layout.pressures(0).start, chamber::COUNT * layout.hammers),
        })
    }

    fn discrete_state(&self) -> u64 {
        self.closed.iter().rev().fold(0, |bits, closed| bits << 1 | u64::from(*closed))
    }

    fn stiff_matrices(&mut self, matrices: &mut StiffMatrices) {
        let StiffMatrices { stiffness, damping, integrated_stiffness, integrated_damping } = matrices;
        for matrix in [&mut *stiffness, damping, integrated_stiffness, integrated_damping] {
            matrix.fill(0.0);
        }
        let model = self.model;
        let (elements, count) = (&model.elements, model.layout.bodies);
        let springs = elements.springs().iter().map(|spring| [spring.stiffness_n_per_m, spring.damping_n_s_per_m]);
        let closed = elements.contacts().iter().enumerate().filter(|(contact, _)| self.closed[*contact]);
        let contacts = closed.filter_map(|(at, contact)| Some((elements.contact_row(at), contact.law.linear()?)));
        for (row, [k, c]) in springs.enumerate().chain(contacts) {
            for (j, at_j) in elements.row(row).filter(|(point, _)| *point < count) {
                for (i, at_i) in elements.row(row) {
                    if i < count {
                        let share = at_i * at_j / model.body_mass[i];
                        stiffness[(i, j)] += k * share;
                        damping[(i, j)] += c * share;
                    } else if !integrated_stiffness.is_empty() {
                        integrated_stiffness[(i - count, j)] -= k * at_i * at_j;
                        integrated_damping[(i - count, j)] -= c * at_i * at_j;
                    }
                }
            }
        }
        if let (Some(condensation), Some(tied)) = (&model.condensation, &model.tied) {
            for matrix in [integrated_stiffness, integrated_damping] {
                for force in matrix.as_mut_slice().chunks_exact_mut(condensation.points()) {
                    self.acceleration.fill(0.0);
                    tied.share(force, &mut self.acceleration);
                }
            }
        }
    }

    fn relaxation(&self, t: f64, y: &[f64], lambda: &mut [f64]) {
        for (h, lambda) in lambda.chunks_exact_mut(chamber::COUNT).enumerate() {
            let state = self.hammer_state(h, t, y);
            lambda.copy_from_slice(&self.model.hammers[h].model.relaxation(&state));
        }
    }

    fn switch(&mut self, guard: usize, t: f64, y: &mut [f64]) {
        let (mut d, _) = self.penetration(guard, t, y);
        if self.following {
            // The state is that before the step in which the bodies met or parted: apart, they store nothing.
            d = d.max(0.0);
        }
        let stored = self.model.elements.contacts()[guard].law.stored_energy(d);
        self.closed[guard] = !self.closed[guard];
        self.list_acting();
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
            Some((time, hammer, true)) => self.switch_supply(hammer, time),
            Some((_, hammer, false)) => self.gate_open[hammer] = true,
            None => {}
        }
    }

    fn diagnose(&self, t: f64, y: &[f64]) -> String {
        if y.iter().any(|value| !value.is_finite()) {
            return format!("the state is no longer finite at t = {t:.6} s");
        }
        for (h, slot) in self.model.hammers.iter().enumerate() {
            let state = self.hammer_state(h, t, y);
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

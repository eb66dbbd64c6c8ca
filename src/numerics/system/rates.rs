//! The right-hand side of the coupled system, of one row or of one in each lane: motion of all points, forces, accelerations,
//! quadratures.

use pulp::{Simd, WithSimd};

use crate::contact::ContactLaw;
use crate::hammer::{HammerConstants, HammerState, body};
use crate::integrate::GuardSample;
use crate::number::{Lanes, Mask, Number, in_lanes};
use crate::system::base::Base;
use crate::system::discrete::Discrete;
use crate::system::elements::ContactKind;
use crate::system::kernel::{Free, Kernel, TERMS};
use crate::system::layout::{CastingQuadrature, HammerQuadrature, Layout};
use crate::system::modal::{GuideShares, ModalRates, Motion};
use crate::system::model::CoupledModel;
use crate::system::products::{clear, copy, long_sum, put_all};

/// Sums over one right-hand side.
struct Power<R> {
    put_in: R,
    dissipated: R,
}

/// One hammer of each lane.
#[derive(Debug, Clone)]
struct Hammer<R: Number> {
    points: [usize; body::COUNT],
    mount: usize,
    constants: HammerConstants<R>,
    supply_pa: R,
    /// Whether the supply has been switched off: what then flows back does not return to it.
    vented: R::Mask,
    gate_open: R::Mask,
}

/// A spring of each lane.
#[derive(Debug, Clone, Copy)]
struct Spring<R> {
    stiffness_n_per_m: R,
    damping_n_s_per_m: R,
    casting: Option<usize>,
}

/// A contact of each lane.
#[derive(Debug, Clone, Copy)]
struct Contact<R: Number> {
    hammer: usize,
    /// Casting that it strikes, for a chisel's contact with it.
    strikes: Option<usize>,
    law: ContactLaw<R>,
    offset_m: R,
    closed: R::Mask,
}

/// Rows of elements over the points: the pattern, and the coefficients of each lane.
///
/// Copied out of the matrix of sprs that [`crate::system::Elements`] assembles: its products take one number per entry and one vector,
/// while here an entry has a number per lane, two vectors are met in one pass, and a row is applied as soon as its force is known.
#[derive(Debug, Clone)]
struct ElementRows<R> {
    /// Where each row begins, and the last ends.
    begins: Vec<usize>,
    points: Vec<usize>,
    coefficients: Vec<R>,
}

impl<R: Number> ElementRows<R> {
    /// The rows from row `first` on, each with its entries.
    #[inline(always)]
    fn from(&self, first: usize) -> impl Iterator<Item = Row<'_, R>> {
        let ends = self.begins[first..].windows(2);
        ends.map(|ends| Row {
            points: &self.points[ends[0]..ends[1]],
            coefficients: &self.coefficients[ends[0]..ends[1]],
        })
    }
}

/// The entries of a row.
#[derive(Debug, Clone, Copy)]
struct Row<'r, R> {
    points: &'r [usize],
    coefficients: &'r [R],
}

impl<R: Number> Row<'_, R> {
    #[inline(always)]
    fn entries(&self) -> impl Iterator<Item = (usize, R)> {
        self.points.iter().copied().zip(self.coefficients.iter().copied())
    }

    /// `r u` of the displacements and of the velocities, of which there are equally many.
    #[inline(always)]
    fn values(&self, displacement: &[R], velocity: &[R]) -> [R; 2] {
        let velocity = &velocity[..displacement.len()];
        let mut sums = [R::splat(0.0); 2];
        for (point, coefficient) in self.entries() {
            sums[0] = coefficient.mul_add(displacement[point], sums[0]);
            sums[1] = coefficient.mul_add(velocity[point], sums[1]);
        }
        sums
    }

    /// The part of `-r u` that points from `first` on contribute: for a fixture's row the motion of the structure under it.
    #[inline(always)]
    fn carried(&self, first: usize, motion: &[R]) -> R {
        let entries = self.entries().filter(|(point, _)| *point >= first);
        entries.fold(R::splat(0.0), |sum, (point, coefficient)| (-coefficient).mul_add(motion[point], sum))
    }

    /// Adds `-r' f` to the forces on the points.
    #[inline(always)]
    fn apply(&self, force: R, forces: &mut [R]) {
        for (point, coefficient) in self.entries() {
            forces[point] = (-coefficient).mul_add(force, forces[point]);
        }
    }
}

/// What the structure's part of the state is.
#[derive(Debug, Clone)]
enum Structure<R> {
    /// Modes, integrated.
    Integrated {
        modes: ModalRates<R>,
        /// Their accelerations without forces, and the power that they dissipate, W.
        free: Vec<R>,
        loss: R,
    },
    /// Integrals of the forces, from a base on.
    Condensed { kernel: Kernel<R>, base_s: R, free: Vec<Free<R>> },
}

/// The right-hand side with its constants, the discrete state that it follows, and scratch memory.
#[derive(Debug, Clone)]
pub(super) struct Rates<R: Number> {
    layout: Layout,
    rows: ElementRows<R>,
    springs: Vec<Spring<R>>,
    contacts: Vec<Contact<R>>,
    hammers: Vec<Hammer<R>>,
    inverse_mass: Vec<R>,
    structure: Structure<R>,
    tied: Option<GuideShares<R>>,
    following: bool,
    displacement: Vec<R>,
    velocity: Vec<R>,
    force: Vec<R>,
    /// Accelerations of interface points without what forces on them cause at once; changed when guides take their share.
    acceleration: Vec<R>,
}

impl<R: Number> Rates<R> {
    /// Room for rows of a model's shape, all lanes with its constants.
    pub fn new(model: &CoupledModel, discrete: &Discrete) -> Self {
        let layout = model.layout;
        let zero = R::splat(0.0);
        let interface = model.modes.phi.ncols();
        let points = layout.bodies + interface;
        let rows = 0..model.elements.springs().len() + model.elements.contacts().len();
        let mut begins = vec![0];
        let mut of_rows = Vec::new();
        for row in rows {
            of_rows.extend(model.elements.row(row).map(|(point, _)| point));
            begins.push(of_rows.len());
        }
        let structure = match &model.condensation {
            Some(condensation) => Structure::Condensed {
                kernel: Kernel::like(condensation.kernel()),
                base_s: zero,
                free: vec![[zero; TERMS + 2]; interface],
            },
            None => Structure::Integrated {
                modes: ModalRates::like(&model.modes),
                free: vec![zero; layout.structure[1]],
                loss: zero,
            },
        };
        let mut rates = Self {
            layout,
            rows: ElementRows { begins, coefficients: vec![zero; of_rows.len()], points: of_rows },
            springs: (model.elements.springs().iter())
                .map(|spring| Spring { stiffness_n_per_m: zero, damping_n_s_per_m: zero, casting: spring.casting })
                .collect(),
            contacts: model.elements.contacts().iter().map(|contact| Contact::like(contact, model)).collect(),
            hammers: (model.hammers.iter())
                .map(|slot| Hammer {
                    points: slot.points,
                    mount: slot.mount,
                    constants: in_lanes::<R, _>(slot.model.constants()),
                    supply_pa: zero,
                    vented: R::Mask::default(),
                    gate_open: R::Mask::default(),
                })
                .collect(),
            inverse_mass: vec![zero; layout.bodies],
            structure,
            tied: model.tied.as_ref().map(GuideShares::like),
            following: false,
            displacement: vec![zero; points],
            velocity: vec![zero; points],
            force: vec![zero; points],
            acceleration: vec![zero; interface],
        };
        for lane in 0..R::LANES {
            rates.put_model(lane, model);
            rates.put_discrete(lane, model, discrete);
        }
        rates
    }

    /// Sets the constants of a lane, of the same shape.
    pub fn put_model(&mut self, lane: usize, model: &CoupledModel) {
        let elements = &model.elements;
        for row in 0..self.rows.begins.len() - 1 {
            let own = &mut self.rows.coefficients[self.rows.begins[row]..self.rows.begins[row + 1]];
            for (own, (_, coefficient)) in own.iter_mut().zip(elements.row(row)) {
                own.put(lane, &coefficient);
            }
        }
        for (own, spring) in self.springs.iter_mut().zip(elements.springs()) {
            own.stiffness_n_per_m.put(lane, &spring.stiffness_n_per_m);
            own.damping_n_s_per_m.put(lane, &spring.damping_n_s_per_m);
        }
        for (own, contact) in self.contacts.iter_mut().zip(elements.contacts()) {
            own.law.put(lane, &contact.law);
            own.offset_m.put(lane, &contact.offset_m);
        }
        for (own, slot) in self.hammers.iter_mut().zip(&model.hammers) {
            own.constants.put(lane, slot.model.constants());
        }
        for (own, mass) in self.inverse_mass.iter_mut().zip(&model.body_mass) {
            own.put(lane, &(1.0 / mass));
        }
        match &mut self.structure {
            Structure::Integrated { modes, .. } => modes.put(lane, &model.modes),
            Structure::Condensed { kernel, .. } => {
                model.condensation.iter().for_each(|other| kernel.put(lane, other.kernel()));
            }
        }
        if let (Some(own), Some(tied)) = (&mut self.tied, &model.tied) {
            own.put(lane, tied);
        }
    }

    /// Sets the discrete state of a lane.
    pub fn put_discrete(&mut self, lane: usize, model: &CoupledModel, discrete: &Discrete) {
        for (own, closed) in self.contacts.iter_mut().zip(&discrete.closed) {
            own.closed.put(lane, *closed);
        }
        for (h, (own, slot)) in self.hammers.iter_mut().zip(&model.hammers).enumerate() {
            let on = discrete.supply_switched[h] % 2 == 1;
            own.supply_pa.put(lane, if on { &slot.supply_pressure_pa } else { &model.ambient_pressure_pa });
            own.vented.put(lane, discrete.vented(h));
            own.gate_open.put(lane, discrete.gate_open[h]);
        }
    }

    /// Sets what a lane's condensed modes follow from.
    pub fn put_base(&mut self, lane: usize, base: &Base) {
        if let Structure::Condensed { base_s, free, .. } = &mut self.structure {
            base_s.put(lane, &base.time_s);
            put_all(free.as_flattened_mut(), lane, base.free.as_flattened());
        }
    }

    /// Whether forces of contacts follow the state alone, see [`crate::integrate::Switching::follow_state`].
    pub fn follow(&mut self, following: bool) {
        self.following = following;
    }

    /// Writes the rates of the state at `(t, y)`.
    pub fn evaluate(&mut self, t: R, y: &[R], rate: &mut [R]) {
        R::dispatch(Evaluation { rates: self, t, y, rate });
    }

    /// Samples the guards where the rates were evaluated last.
    pub fn sample(&mut self, t: R, y: &[R], rate: &[R], samples: &mut [GuardSample<R>]) {
        R::dispatch(Sampling { rates: self, t, y, rate, samples });
    }

    #[inline(always)]
    fn write(&mut self, t: R, y: &[R], rate: &mut [R]) {
        let mut power = Power { put_in: R::splat(0.0), dissipated: R::splat(0.0) };
        self.gather(t, y);
        clear(&mut self.force);
        self.hammers(y, rate, &mut power);
        self.elements(rate, &mut power);
        self.accelerations(y, rate, &mut power);
        rate[self.layout.work_in()] = power.put_in;
        rate[self.layout.dissipated()] = power.dissipated;
    }

    /// Displacements and velocities of all points: bodies as they are, interface points from the structure.
    #[inline(always)]
    fn gather(&mut self, t: R, y: &[R]) {
        let layout = &self.layout;
        let b = layout.bodies;
        copy(&y[layout.position(0)..layout.velocities()], &mut self.displacement[..b]);
        copy(&y[layout.velocity(0)..layout.velocity(b)], &mut self.velocity[..b]);
        // Only tied guides ask for accelerations, and hammers' mounts are the first points.
        let accelerated = self.tied.as_ref().map_or(0, GuideShares::guides);
        let mut motion = Motion {
            displacement: &mut self.displacement[b..],
            velocity: &mut self.velocity[b..],
            acceleration: &mut self.acceleration[..accelerated],
        };
        let states = &y[layout.structure_displacements()];
        match &mut self.structure {
            Structure::Condensed { kernel, base_s, free } => kernel.motion(free, t - *base_s, states, &mut motion),
            Structure::Integrated { modes, free, loss } => {
                let velocities = &y[layout.structure_velocities()];
                *loss = modes.free_accelerations(states, velocities, free);
                modes.motion([states, velocities, free], &mut motion);
            }
        }
    }

    /// Forces, pressure rates and quadratures of the hammers.
    #[inline(always)]
    fn hammers(&mut self, y: &[R], rate: &mut [R], power: &mut Power<R>) {
        let (layout, none) = (self.layout, R::splat(0.0));
        let (displacement, velocities, forces) = (&self.displacement[..], &self.velocity[..], &mut self.force[..]);
        for (h, hammer) in self.hammers.iter().enumerate() {
            let mut pressure = [none; 4];
            pressure.copy_from_slice(&y[layout.pressures(h)]);
            let (mut position, mut velocity) = ([none; body::COUNT], [none; body::COUNT]);
            for i in 0..body::COUNT {
                position[i] = displacement[hammer.points[i]];
                velocity[i] = velocities[hammer.points[i]];
            }
            let state =
                HammerState { position, velocity, pressure, supply_pa: hammer.supply_pa, gate_open: hammer.gate_open };
            let rates = hammer.constants.evaluate(&state);
            for i in 0..body::COUNT {
                forces[hammer.points[i]] += rates.force[i];
            }
            rate[layout.pressures(h)].copy_from_slice(&rates.pressure_rate);
            // In arrays of a known length what was evaluated goes to memory once.
            if let ([own, supplied, expansion], []) = rate[layout.hammer_quadratures(h)].as_chunks_mut() {
                // What flows back into a line that is vented does not return to the supply.
                own[HammerQuadrature::Air as usize] = R::select(hammer.vented, none, rates.supply_flow_kg_s);
                let arm = velocities[layout.bodies + hammer.mount];
                own[HammerQuadrature::ArmVelocitySquared as usize] = arm * arm;
                own[HammerQuadrature::Work as usize] = none;
                own[HammerQuadrature::Impulse as usize] = none;
                *supplied = rates.balance.map(|balance| balance.supplied_w);
                *expansion = rates.balance.map(|balance| balance.expansion_w);
            }
            power.put_in += rates.power_in_w;
            power.dissipated += rates.dissipation_w;
        }
    }

    /// Forces of springs and closed contacts. A force of 0 in a lane leaves all sums there as they are, signs of zeros included,
    /// as they begin at +0: a contact that is open in all lanes can be passed over.
    #[inline(always)]
    fn elements(&mut self, rate: &mut [R], power: &mut Power<R>) {
        let none = R::splat(0.0);
        // Slices at hand: what is written through one of them changes where none of the others begins.
        let (displacement, velocity, forces) = (&self.displacement[..], &self.velocity[..], &mut self.force[..]);
        let layout = self.layout;
        rate[layout.casting_quadratures()].fill(none);
        for (spring, row) in self.springs.iter().zip(self.rows.from(0)) {
            let [extension, speed] = row.values(displacement, velocity);
            let force = spring.stiffness_n_per_m * extension + spring.damping_n_s_per_m * speed;
            row.apply(force, forces);
            let loss = spring.damping_n_s_per_m * speed * speed;
            power.dissipated += loss;
            if let Some(casting) = spring.casting {
                rate[layout.casting_quadrature(casting, CastingQuadrature::FixtureLoss)] += loss;
                let carried = force * row.carried(layout.bodies, velocity);
                rate[layout.casting_quadrature(casting, CastingQuadrature::StructureWork)] += carried;
            }
        }
        let following = self.following;
        for (contact, row) in self.contacts.iter().zip(self.rows.from(self.springs.len())) {
            if !following && !contact.closed.any() {
                continue;
            }
            let [d, speed] = row.values(displacement, velocity);
            let penetration = d - contact.offset_m;
            let acts =
                if following { contact.law.onset_indicator(penetration, speed).greater(none) } else { contact.closed };
            let force = R::select(acts, contact.law.closed_force(penetration, speed), none);
            row.apply(force, forces);
            power.dissipated += R::select(acts, contact.law.dissipated_power(penetration, speed), none);
            if let Some(casting) = contact.strikes {
                rate[layout.casting_quadrature(casting, CastingQuadrature::ContactWork)] += force * speed;
                let chisel = self.hammers[contact.hammer].points[body::CHISEL];
                let casting_speed = velocity[chisel] - speed;
                let work = R::select(acts, force * casting_speed, none);
                rate[layout.quadrature(contact.hammer, HammerQuadrature::Work)] = work;
                rate[layout.quadrature(contact.hammer, HammerQuadrature::Impulse)] = force;
            }
        }
    }

    /// Accelerations of the bodies and rates of the structure from the forces on the points; tied guides take their share of the
    /// forces on their mounts.
    #[inline(always)]
    fn accelerations(&mut self, y: &[R], rate: &mut [R], power: &mut Power<R>) {
        let layout = &self.layout;
        let b = layout.bodies;
        copy(&y[layout.velocity(0)..layout.velocity(b)], &mut rate[layout.position(0)..layout.velocities()]);
        let acceleration = &mut rate[layout.velocity(0)..layout.velocity(b)];
        for ((acceleration, force), inverse) in acceleration.iter_mut().zip(&self.force).zip(&self.inverse_mass) {
            *acceleration = *force * *inverse;
        }
        let force = &mut self.force[b..];
        if let Some(tied) = &self.tied {
            tied.share(force, &mut self.acceleration);
        }
        match &self.structure {
            // `z_1' = F`, `z_{k+1}' = z_k`.
            Structure::Condensed { .. } => {
                let (points, states) = (force.len(), layout.structure[0]);
                copy(force, &mut rate[..points]);
                copy(&y[..states - points], &mut rate[points..states]);
            }
            // `x'' = -omega^2 x - 2 xi omega x' + Phi F` per mode.
            Structure::Integrated { modes, free, loss } => {
                rate[layout.structure_displacements()].copy_from_slice(&y[layout.structure_velocities()]);
                let acceleration = &mut rate[layout.structure_velocities()];
                acceleration.copy_from_slice(free);
                modes.add_forces(force, acceleration);
                power.dissipated += *loss;
            }
        }
    }

    #[inline(always)]
    fn write_samples(&mut self, t: R, y: &[R], rate: &[R], samples: &mut [GuardSample<R>]) {
        let rows = self.rows.from(self.springs.len());
        for ((contact, row), sample) in self.contacts.iter().zip(rows).zip(samples) {
            let [d, speed] = row.values(&self.displacement, &self.velocity);
            let d = d - contact.offset_m;
            *sample = GuardSample { value: contact.law.onset_indicator(d, speed), smooth: d, smooth_rate: speed };
            if contact.closed.any() {
                let acceleration = self.relative_acceleration(&row, t, y, rate);
                let (smooth, smooth_rate) = contact.law.smooth_release(d, speed, acceleration);
                let value = contact.law.release_indicator(d, speed);
                sample.value = R::select(contact.closed, value, sample.value);
                sample.smooth = R::select(contact.closed, smooth, sample.smooth);
                sample.smooth_rate = R::select(contact.closed, smooth_rate, sample.smooth_rate);
            }
        }
    }

    /// Relative acceleration along an element's row at a state whose rate is known.
    #[inline(always)]
    fn relative_acceleration(&self, row: &Row<'_, R>, t: R, y: &[R], rate: &[R]) -> R {
        let mut relative = R::splat(0.0);
        for (point, coefficient) in row.entries() {
            let acceleration = match point.checked_sub(self.layout.bodies) {
                None => rate[self.layout.velocity(point)],
                Some(node) => self.interface_acceleration(node, t, y, rate),
            };
            relative = coefficient.mul_add(acceleration, relative);
        }
        relative
    }

    /// Acceleration of an interface point at a state whose rate is known.
    #[inline(always)]
    fn interface_acceleration(&self, node: usize, t: R, y: &[R], rate: &[R]) -> R {
        match &self.structure {
            Structure::Condensed { kernel, base_s, free } => {
                let z = &y[self.layout.structure_displacements()];
                let [_, _, mut acceleration] = kernel.point(free, t - *base_s, z, node);
                for (m, force) in rate[..self.acceleration.len()].iter().enumerate() {
                    acceleration = kernel.direct(node, m).mul_add(*force, acceleration);
                }
                acceleration
            }
            Structure::Integrated { modes, .. } => {
                long_sum(modes.shapes_at(node), &rate[self.layout.structure_velocities()])
            }
        }
    }
}

impl<R: Number> Contact<R> {
    fn like(contact: &crate::system::elements::Contact, model: &CoupledModel) -> Self {
        let strikes = contact.kind == ContactKind::ChiselCasting;
        Self {
            hammer: contact.hammer,
            strikes: strikes.then(|| model.hammers[contact.hammer].casting),
            law: contact.law.in_lanes(),
            offset_m: R::splat(contact.offset_m),
            closed: R::Mask::default(),
        }
    }
}

/// A right-hand side to be evaluated.
struct Evaluation<'e, R: Number> {
    rates: &'e mut Rates<R>,
    t: R,
    y: &'e [R],
    rate: &'e mut [R],
}

impl<R: Number> WithSimd for Evaluation<'_, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.rates.write(self.t, self.y, self.rate);
    }
}

/// Guards to be sampled.
struct Sampling<'s, R: Number> {
    rates: &'s mut Rates<R>,
    t: R,
    y: &'s [R],
    rate: &'s [R],
    samples: &'s mut [GuardSample<R>],
}

impl<R: Number> WithSimd for Sampling<'_, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.rates.write_samples(self.t, self.y, self.rate, self.samples);
    }
}

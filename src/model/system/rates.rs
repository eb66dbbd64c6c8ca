//! The right-hand side of the coupled system, of one row or of one in each lane: motion of all points, forces, accelerations,
//! quadratures.

use std::ops::Range;

use pulp::{Simd, WithSimd};

use crate::contact::ContactLaw;
use crate::hammer::{HammerConstants, HammerState, body};
use crate::integrate::GuardSample;
use crate::scene::PartId;
use crate::system::block::{Block, FlexibleRates};
use crate::system::discrete::Discrete;
use crate::system::elements::friction as sliding;
use crate::system::layout::{CastingQuadrature, HammerQuadrature, Layout};
use crate::system::model::{Books, CoupledModel};
use crate::system::products::{clear, copy, put_all};
use decore_math::number::{Lanes, Mask, Number, in_lanes};

/// Sums over one right-hand side.
struct Power<R> {
    put_in: R,
    dissipated: R,
}

/// One hammer of each lane.
#[derive(Debug, Clone)]
struct Hammer<R: Number> {
    /// Columns of its bodies, and of its mount.
    bodies: [usize; body::COUNT],
    mount: usize,
    constants: HammerConstants<R>,
    supply_pa: R,
    /// Whether the supply has been switched off: returning flow then does not enter it.
    vented: R::Mask,
    gate_open: R::Mask,
}

/// A spring of each lane.
#[derive(Debug, Clone, Copy)]
struct Spring<R> {
    stiffness_n_per_m: R,
    damping_n_s_per_m: R,
    books: Books,
}

/// A contact of each lane.
#[derive(Debug, Clone, Copy)]
struct Contact<R: Number> {
    books: Books,
    law: ContactLaw<R>,
    offset_m: R,
    rest_force_n: R,
    /// Whether a lane has a force at rest, which acts on while the contact is open.
    loaded: bool,
    closed: R::Mask,
}

/// Friction of a pad of each lane.
#[derive(Debug, Clone, Copy)]
struct Sliding<R> {
    contact: usize,
    springs: [usize; 2],
    coefficient: R,
    speed_m_s: R,
}

/// Rows of elements over the columns: the pattern, and the coefficients of each lane.
///
/// Copied out of the matrix of sprs that [`crate::system::Elements`] assembles: its products take one number per entry and one vector,
/// while here an entry has a number per lane, two vectors are met in one pass, and a row is applied as soon as its force is known.
#[derive(Debug, Clone)]
struct ElementRows<R> {
    /// Begin of each row, and end of the last one.
    begins: Vec<usize>,
    columns: Vec<usize>,
    coefficients: Vec<R>,
}

impl<R: Number> ElementRows<R> {
    /// The entries of a row.
    #[inline(always)]
    fn at(&self, row: usize) -> RowEntries<'_, R> {
        let own = self.begins[row]..self.begins[row + 1];
        RowEntries { columns: &self.columns[own.clone()], coefficients: &self.coefficients[own] }
    }

    /// The rows from row `first` on, each with its entries.
    #[inline(always)]
    fn from(&self, first: usize) -> impl Iterator<Item = RowEntries<'_, R>> {
        let ends = self.begins[first..].windows(2);
        ends.map(|ends| RowEntries {
            columns: &self.columns[ends[0]..ends[1]],
            coefficients: &self.coefficients[ends[0]..ends[1]],
        })
    }
}

/// The entries of a row.
#[derive(Debug, Clone, Copy)]
struct RowEntries<'r, R> {
    columns: &'r [usize],
    coefficients: &'r [R],
}

impl<R: Number> RowEntries<'_, R> {
    #[inline(always)]
    fn entries(&self) -> impl Iterator<Item = (usize, R)> {
        self.columns.iter().copied().zip(self.coefficients.iter().copied())
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

    /// Power of the force on some of the columns.
    #[inline(always)]
    fn work_on(&self, columns: &Range<usize>, force: R, velocity: &[R]) -> R {
        let acting = self.entries().filter(|(column, _)| columns.contains(column));
        acting.fold(R::splat(0.0), |sum, (column, c)| sum - c * force * velocity[column])
    }

    /// Adds `-r' f` to the forces on the points.
    #[inline(always)]
    fn apply(&self, force: R, forces: &mut [R]) {
        for (point, coefficient) in self.entries() {
            forces[point] = (-coefficient).mul_add(force, forces[point]);
        }
    }
}

/// The right-hand side with its constants, the discrete state that it follows, and scratch memory.
#[derive(Debug, Clone)]
pub(super) struct Rates<R: Number> {
    layout: Layout,
    rows: ElementRows<R>,
    springs: Vec<Spring<R>>,
    /// Stiffness and damping of springs in series with a residual flexibility, row by row; empty without any.
    series: [Vec<R>; 2],
    /// Elongation and rate of each spring.
    elongations: Vec<[R; 2]>,
    /// Columns of the machine, on which contacts act through fixtures in series with a residual flexibility.
    machine: Range<usize>,
    contacts: Vec<Contact<R>>,
    frictions: Vec<Sliding<R>>,
    hammers: Vec<Hammer<R>>,
    /// Masses of the rigid coordinates of all parts, side by side.
    inverse_mass: Vec<R>,
    flexible: Vec<FlexibleRates<R>>,
    following: bool,
    /// Displacements, velocities and forces of all columns.
    displacement: Vec<R>,
    velocity: Vec<R>,
    force: Vec<R>,
}

impl<R: Number> Rates<R> {
    /// Room for rows of a model's shape, all lanes with its constants.
    pub fn new(model: &CoupledModel, discrete: &Discrete) -> Self {
        let layout = model.layout;
        let zero = R::splat(0.0);
        let columns = model.elements.matrix().cols();
        let rows = 0..model.elements.springs().len() + model.elements.contacts().len();
        let mut begins = vec![0];
        let mut of_rows = Vec::new();
        for row in rows {
            of_rows.extend(model.elements.row(row).map(|(column, _)| column));
            begins.push(of_rows.len());
        }
        let mut rates = Self {
            layout,
            rows: ElementRows { begins, coefficients: vec![zero; of_rows.len()], columns: of_rows },
            springs: (model.elements.springs().iter())
                .map(|spring| {
                    let books = model.books(spring.owner);
                    Spring { stiffness_n_per_m: zero, damping_n_s_per_m: zero, books }
                })
                .collect(),
            series: [(); 2].map(|()| vec![zero; model.elements.series().map_or(0, |series| series.stiffness.len())]),
            elongations: vec![[zero; 2]; model.elements.springs().len()],
            machine: model.columns(PartId::Machine),
            contacts: model.elements.contacts().iter().map(|contact| Contact::like(contact, model)).collect(),
            frictions: (model.elements.frictions().iter())
                .map(|sliding| Sliding {
                    contact: sliding.contact,
                    springs: sliding.springs,
                    coefficient: zero,
                    speed_m_s: zero,
                })
                .collect(),
            hammers: (model.hammers.iter())
                .map(|slot| Hammer {
                    bodies: slot.points,
                    mount: slot.mount,
                    constants: in_lanes::<R, _>(slot.model.constants()),
                    supply_pa: zero,
                    vented: R::Mask::default(),
                    gate_open: R::Mask::default(),
                })
                .collect(),
            inverse_mass: vec![zero; layout.bodies],
            flexible: (model.parts.iter().enumerate())
                .filter_map(|(place, part)| FlexibleRates::like(place, part))
                .collect(),
            following: false,
            displacement: vec![zero; columns],
            velocity: vec![zero; columns],
            force: vec![zero; columns],
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
        if let Some(series) = elements.series() {
            // Both are symmetric: columns are rows.
            put_all(&mut self.series[0], lane, series.stiffness.as_slice());
            put_all(&mut self.series[1], lane, series.damping.as_slice());
        }
        for (own, contact) in self.contacts.iter_mut().zip(elements.contacts()) {
            own.law.put(lane, &contact.law);
            own.offset_m.put(lane, &contact.offset_m);
            own.rest_force_n.put(lane, &contact.rest_force_n);
            own.loaded |= contact.rest_force_n != 0.0;
        }
        for (own, sliding) in self.frictions.iter_mut().zip(elements.frictions()) {
            own.coefficient.put(lane, &sliding.coefficient);
            own.speed_m_s.put(lane, &sliding.speed_m_s);
        }
        for (own, slot) in self.hammers.iter_mut().zip(&model.hammers) {
            own.constants.put(lane, slot.model.constants());
        }
        for (own, mass) in self.inverse_mass.iter_mut().zip(model.masses()) {
            own.put(lane, &(1.0 / mass));
        }
        for flexible in &mut self.flexible {
            flexible.put(lane, &model.parts[flexible.part]);
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

    /// Sets the modes of a lane's blocks that are outside the state.
    pub fn put_outside(&mut self, lane: usize, blocks: &[Block]) {
        for flexible in &mut self.flexible {
            flexible.put_outside(lane, &blocks[flexible.part]);
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
        self.frictions(rate, &mut power);
        self.accelerations(y, rate, &mut power);
        rate[self.layout.work_in()] = power.put_in;
        rate[self.layout.dissipated()] = power.dissipated;
    }

    /// Displacements and velocities of all columns: rigid coordinates as they are, points from their blocks.
    #[inline(always)]
    fn gather(&mut self, t: R, y: &[R]) {
        let layout = &self.layout;
        let b = layout.bodies;
        copy(&y[layout.position(0)..layout.velocities()], &mut self.displacement[..b]);
        copy(&y[layout.velocity(0)..layout.velocity(b)], &mut self.velocity[..b]);
        for flexible in &mut self.flexible {
            let columns = flexible.columns.clone();
            flexible.gather(t, y, [&mut self.displacement[columns.clone()], &mut self.velocity[columns]]);
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
                position[i] = displacement[hammer.bodies[i]];
                velocity[i] = velocities[hammer.bodies[i]];
            }
            let state =
                HammerState { position, velocity, pressure, supply_pa: hammer.supply_pa, gate_open: hammer.gate_open };
            let rates = hammer.constants.evaluate(&state);
            for i in 0..body::COUNT {
                forces[hammer.bodies[i]] += rates.force[i];
            }
            rate[layout.pressures(h)].copy_from_slice(&rates.pressure_rate);
            // In arrays of a known length what was evaluated goes to memory once.
            if let ([own, supplied, expansion], []) = rate[layout.hammer_quadratures(h)].as_chunks_mut() {
                // Flow into a vented line does not return to the supply.
                own[HammerQuadrature::Air as usize] = R::select(hammer.vented, none, rates.supply_flow_kg_s);
                let arm = velocities[hammer.mount];
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
        if !self.series[0].is_empty() {
            for (elongation, row) in self.elongations.iter_mut().zip(self.rows.from(0)) {
                *elongation = row.values(displacement, velocity);
            }
        }
        for (at, (spring, row)) in self.springs.iter().zip(self.rows.from(0)).enumerate() {
            let (force, loss);
            if self.series[0].is_empty() {
                let [extension, speed] = row.values(displacement, velocity);
                force = spring.stiffness_n_per_m * extension + spring.damping_n_s_per_m * speed;
                loss = spring.damping_n_s_per_m * speed * speed;
            } else {
                (force, loss) = in_series(&self.series, &self.elongations, at);
            }
            row.apply(force, forces);
            power.dissipated += loss;
            if let Books::Fixture { casting, support } = spring.books {
                rate[layout.casting_quadrature(casting, CastingQuadrature::FixtureLoss)] += loss;
                let carried = force * velocity[support];
                rate[layout.casting_quadrature(casting, CastingQuadrature::StructureWork)] += carried;
            }
        }
        let following = self.following;
        for (contact, row) in self.contacts.iter().zip(self.rows.from(self.springs.len())) {
            if !following && !contact.loaded && !contact.closed.any() {
                continue;
            }
            let [d, speed] = row.values(displacement, velocity);
            let penetration = d - contact.offset_m;
            let acts =
                if following { contact.law.onset_indicator(penetration, speed).greater(none) } else { contact.closed };
            let pushing = R::select(acts, contact.law.closed_force(penetration, speed), none);
            let force = pushing - contact.rest_force_n;
            row.apply(force, forces);
            let loss = R::select(acts, contact.law.dissipated_power(penetration, speed), none);
            power.dissipated += loss;
            match contact.books {
                Books::Inner => {}
                Books::Strike { hammer, casting, chisel } => {
                    rate[layout.casting_quadrature(casting, CastingQuadrature::ContactWork)] += force * speed;
                    let casting_speed = velocity[chisel] - speed;
                    let work = R::select(acts, force * casting_speed, none);
                    rate[layout.quadrature(hammer, HammerQuadrature::Work)] = work;
                    rate[layout.quadrature(hammer, HammerQuadrature::Impulse)] = force;
                    if !self.series[0].is_empty() {
                        let carried = row.work_on(&self.machine, force, velocity);
                        rate[layout.casting_quadrature(casting, CastingQuadrature::StructureWork)] += carried;
                    }
                }
                Books::Fixture { casting, support } => {
                    rate[layout.casting_quadrature(casting, CastingQuadrature::FixtureLoss)] += loss;
                    // In series with a residual flexibility the row acts on the supports of springs too.
                    let in_series = !self.series[0].is_empty();
                    let carried =
                        if in_series { row.work_on(&self.machine, force, velocity) } else { force * velocity[support] };
                    rate[layout.casting_quadrature(casting, CastingQuadrature::StructureWork)] += carried;
                }
            }
        }
    }

    /// Friction of the pads against the velocity across their axes.
    #[inline(always)]
    fn frictions(&mut self, rate: &mut [R], power: &mut Power<R>) {
        let none = R::splat(0.0);
        let (displacement, velocity, forces) = (&self.displacement[..], &self.velocity[..], &mut self.force[..]);
        for friction in &self.frictions {
            let contact = &self.contacts[friction.contact];
            let [d, approach] = self.rows.at(self.springs.len() + friction.contact).values(displacement, velocity);
            let penetration = d - contact.offset_m;
            let acts = if self.following {
                contact.law.onset_indicator(penetration, approach).greater(none)
            } else {
                contact.closed
            };
            let pressing = contact.law.closed_force(penetration, approach);
            let pressing = R::select(acts.and(pressing.greater(none)), pressing, none);
            let across = friction.springs.map(|spring| self.rows.at(spring).values(displacement, velocity)[1]);
            let [per_speed, speed] = sliding([friction.coefficient, friction.speed_m_s], pressing, across);
            let loss = per_speed * speed * speed;
            power.dissipated += loss;
            for (spring, across) in friction.springs.into_iter().zip(across) {
                let force = per_speed * across;
                self.rows.at(spring).apply(force, forces);
                if let Books::Fixture { casting, support } = self.springs[spring].books {
                    let carried = force * velocity[support];
                    rate[self.layout.casting_quadrature(casting, CastingQuadrature::FixtureLoss)] += force * across;
                    rate[self.layout.casting_quadrature(casting, CastingQuadrature::StructureWork)] += carried;
                }
            }
        }
    }

    /// Accelerations of the rigid coordinates and rates of the flexible parts from the forces on the columns.
    #[inline(always)]
    fn accelerations(&mut self, y: &[R], rate: &mut [R], power: &mut Power<R>) {
        let layout = &self.layout;
        let b = layout.bodies;
        copy(&y[layout.velocity(0)..layout.velocity(b)], &mut rate[layout.position(0)..layout.velocities()]);
        let acceleration = &mut rate[layout.velocity(0)..layout.velocity(b)];
        for ((acceleration, force), inverse) in acceleration.iter_mut().zip(&self.force).zip(&self.inverse_mass) {
            *acceleration = *force * *inverse;
        }
        for flexible in &mut self.flexible {
            let force = &mut self.force[flexible.columns.clone()];
            flexible.write(force, (y, &mut *rate), &mut power.dissipated);
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
    fn relative_acceleration(&self, row: &RowEntries<'_, R>, t: R, y: &[R], rate: &[R]) -> R {
        let mut relative = R::splat(0.0);
        for (column, coefficient) in row.entries() {
            let acceleration = if column < self.layout.bodies {
                rate[self.layout.velocity(column)]
            } else {
                self.point_acceleration(column, t, [y, rate])
            };
            relative = coefficient.mul_add(acceleration, relative);
        }
        relative
    }

    /// Acceleration of a flexible part's point at a state whose rate is known.
    #[inline(always)]
    fn point_acceleration(&self, column: usize, t: R, state: [&[R]; 2]) -> R {
        let mut flexible = self.flexible.iter();
        let found = flexible.find(|flexible| flexible.columns.contains(&column));
        found.map_or(R::splat(0.0), |flexible| flexible.acceleration(column - flexible.columns.start, t, state))
    }
}

/// Force of spring `at` in series with a residual flexibility, and the power that it dissipates.
#[inline(always)]
fn in_series<R: Number>([stiffness, damping]: &[Vec<R>; 2], elongations: &[[R; 2]], at: usize) -> (R, R) {
    let own = at * elongations.len()..(at + 1) * elongations.len();
    let (mut elastic, mut damped) = (R::splat(0.0), R::splat(0.0));
    for ([elongation, speed], (k, c)) in elongations.iter().zip(stiffness[own.clone()].iter().zip(&damping[own])) {
        elastic = k.mul_add(*elongation, elastic);
        damped = c.mul_add(*speed, damped);
    }
    (elastic + damped, damped * elongations[at][1])
}

impl<R: Number> Contact<R> {
    fn like(contact: &crate::system::elements::Contact, model: &CoupledModel) -> Self {
        Self {
            books: model.books(contact.owner),
            law: contact.law.in_lanes(),
            offset_m: R::splat(contact.offset_m),
            rest_force_n: R::splat(contact.rest_force_n),
            loaded: false,
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

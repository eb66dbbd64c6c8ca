//! Rows of one shape in lanes.

use std::mem::{Discriminant, discriminant};
use std::ops::Range;
use std::sync::Arc;

use crate::contact::ContactLaw;
use crate::integrate::{GuardSample, InLanes, Taken};
use crate::scene::PartId;
use crate::system::block::{Block, CoupledPart};
use crate::system::coupled::Coupled;
use crate::system::force_integrals::ForceIntegrals;
use crate::system::layout::Layout;
use crate::system::model::{Books, CoupledModel};
use crate::system::rates::Rates;
use decore_math::number::Number;

/// Properties that rows must share to run side by side: the layout of the state, the kinds of blocks, the columns and books of each
/// element, and the kinds of laws. Numbers are each row's own.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    layout: Layout,
    parts: Vec<PartShape>,
    books: Vec<Books>,
    columns: Vec<usize>,
    begins: Vec<usize>,
    slides: Vec<(usize, [usize; 2])>,
    laws: Vec<Discriminant<ContactLaw>>,
}

/// Properties of a part that rows must share. Condensed modes are not states: rows may differ in their number.
#[derive(Debug, Clone, PartialEq)]
struct PartShape {
    id: PartId,
    block: Discriminant<Block>,
    states: [Range<usize>; 2],
    columns: Range<usize>,
    tied: bool,
}

impl PartShape {
    fn of(part: &CoupledPart) -> Self {
        Self {
            id: part.id,
            block: discriminant(&part.block),
            states: part.states.clone(),
            columns: part.columns.clone(),
            tied: part.tied.is_some(),
        }
    }
}

impl Shape {
    /// The shape of a model.
    pub fn of(model: &CoupledModel) -> Self {
        let elements = &model.elements;
        let springs = elements.springs().iter().map(|spring| spring.owner);
        let contacts = elements.contacts().iter().map(|contact| contact.owner);
        Self {
            layout: model.layout,
            parts: model.parts.iter().map(PartShape::of).collect(),
            books: springs.chain(contacts).map(|owner| model.books(owner)).collect(),
            columns: elements.matrix().indices().to_vec(),
            begins: elements.matrix().indptr().raw_storage().to_vec(),
            slides: elements.frictions().iter().map(|sliding| (sliding.contact, sliding.springs)).collect(),
            laws: elements.contacts().iter().map(|contact| discriminant(&contact.law)).collect(),
        }
    }
}

/// Coupled models of one shape being integrated, one in each lane of `R`.
#[derive(Debug)]
pub struct CoupledLanes<R: Number> {
    rows: Vec<Coupled>,
    rates: Rates<R>,
    /// Integrals of each condensed part, with the index of the part.
    moments: Vec<(usize, ForceIntegrals<R>)>,
}

impl<R: Number> CoupledLanes<R> {
    /// All lanes with the same model at rest.
    pub fn new(model: &Arc<CoupledModel>) -> Self {
        let row = Coupled::new(model);
        let rates = Rates::new(model, &row.discrete);
        let parts = model.parts.iter().enumerate().filter(|(_, part)| part.block.condensed().is_some());
        let moments =
            parts.map(|(at, part)| (at, ForceIntegrals::new(part.columns.len(), part.states[0].start))).collect();
        let mut lanes = Self { rows: vec![row; R::LANES], rates, moments };
        (0..R::LANES).for_each(|lane| lanes.begin(lane));
        lanes
    }

    /// Puts a model of the same shape, at rest, into a lane.
    pub fn load(&mut self, lane: usize, model: &Arc<CoupledModel>) {
        self.rows[lane] = Coupled::new(model);
        self.rates.put_model(lane, model);
        self.begin(lane);
        self.switched(lane);
        self.rebased(lane);
    }

    /// Begins to follow the dissipation of a lane's row.
    fn begin(&mut self, lane: usize) {
        for (part, moments) in &mut self.moments {
            let condensed = self.rows[lane].blocks[*part].condensed();
            condensed.iter().for_each(|condensed| moments.begin(lane, &condensed.constants.damping));
        }
    }

    /// The row in a lane.
    pub fn lane(&self, lane: usize) -> &Coupled {
        &self.rows[lane]
    }
}

impl<R: Number> InLanes<R> for CoupledLanes<R> {
    type Row = Coupled;

    fn row(&self, lane: usize) -> &Coupled {
        &self.rows[lane]
    }

    fn row_mut(&mut self, lane: usize) -> &mut Coupled {
        &mut self.rows[lane]
    }

    fn switched(&mut self, lane: usize) {
        let row = &self.rows[lane];
        self.rates.put_discrete(lane, &row.model, &row.discrete);
    }

    fn rebased(&mut self, lane: usize) {
        self.rates.put_outside(lane, &self.rows[lane].blocks);
    }

    fn stepped(&mut self, taken: &Taken<'_, R>) {
        for (part, moments) in &mut self.moments {
            moments.follow(taken, |lane, own| {
                let condensed = self.rows[lane].blocks[*part].condensed_mut();
                condensed.map_or(f64::INFINITY, |condensed| condensed.at_node(own))
            });
        }
    }

    fn rhs(&mut self, t: R, y: &[R], rate: &mut [R]) {
        self.rates.evaluate(t, y, rate);
    }

    fn sample_guards(&mut self, t: R, y: &[R], rate: &[R], samples: &mut [GuardSample<R>]) {
        self.rates.sample(t, y, rate, samples);
    }
}

//! Rows of one shape side by side.

use std::mem::{Discriminant, discriminant};
use std::sync::Arc;

use crate::contact::ContactLaw;
use crate::integrate::{GuardSample, InLanes, Taken};
use crate::number::Number;
use crate::system::coupled::Coupled;
use crate::system::layout::Layout;
use crate::system::model::CoupledModel;
use crate::system::moments::Moments;
use crate::system::rates::Rates;

/// What rows side by side have in common: the layout of the state, which points each element joins, and the kinds of laws. Numbers
/// are each row's own.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    layout: Layout,
    tied: bool,
    /// Casting that each spring holds.
    held: Vec<Option<usize>>,
    /// Casting that each hammer strikes.
    struck: Vec<usize>,
    points: Vec<usize>,
    begins: Vec<usize>,
    laws: Vec<Discriminant<ContactLaw>>,
}

impl Shape {
    /// The shape of a model.
    pub fn of(model: &CoupledModel) -> Self {
        let elements = &model.elements;
        // Condensed modes are no states: rows may differ in their number.
        let modes = if model.condensation.is_some() { 0 } else { model.layout.modes };
        Self {
            layout: Layout { modes, ..model.layout },
            tied: model.tied.is_some(),
            held: elements.springs().iter().map(|spring| spring.casting).collect(),
            struck: model.hammers.iter().map(|hammer| hammer.casting).collect(),
            points: elements.matrix().indices().to_vec(),
            begins: elements.matrix().indptr().raw_storage().to_vec(),
            laws: elements.contacts().iter().map(|contact| discriminant(&contact.law)).collect(),
        }
    }
}

/// Coupled models of one shape being integrated, one in each lane of `R`.
#[derive(Debug)]
pub struct CoupledLanes<R: Number> {
    rows: Vec<Coupled>,
    rates: Rates<R>,
    moments: Option<Moments<R>>,
}

impl<R: Number> CoupledLanes<R> {
    /// All lanes with the same model at rest.
    pub fn new(model: &Arc<CoupledModel>) -> Self {
        let row = Coupled::new(model);
        let rates = Rates::new(model, &row.discrete);
        let moments = model.condensation.as_ref().map(|condensation| Moments::new(condensation.points()));
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

    /// Begins to follow what the row in a lane dissipates.
    fn begin(&mut self, lane: usize) {
        if let (Some(moments), Some(damping)) = (&mut self.moments, &self.rows[lane].model.damping) {
            moments.begin(lane, damping);
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
        self.rows[lane].base.iter().for_each(|base| self.rates.put_base(lane, base));
    }

    fn stepped(&mut self, taken: &Taken<'_, R>) {
        if let Some(moments) = &mut self.moments {
            moments.follow(taken, |lane, own| self.rows[lane].at_node(own));
        }
    }

    fn rhs(&mut self, t: R, y: &[R], rate: &mut [R]) {
        self.rates.evaluate(t, y, rate);
    }

    fn sample_guards(&mut self, t: R, y: &[R], rate: &[R], samples: &mut [GuardSample<R>]) {
        self.rates.sample(t, y, rate, samples);
    }
}

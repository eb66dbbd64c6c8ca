//! Motion of core points that the residual flexibility of an elastic casting adds: `R F`, without mass.
//!
//! It follows the forces of fixtures and contacts at once, so its rate jumps where a contact closes or opens. Steps end there.

use crate::integrate::Step;
use crate::scene::PointId;
use crate::system::{Coupled, CoupledModel, ResidualMotion};

/// Places in a step at which the motion is known: start, middle, end.
const PLACES: usize = 3;

/// Residual motion of the core points of one casting.
pub(super) struct ResidualTrack {
    /// Springs and contacts whose forces move a point.
    springs: Vec<usize>,
    contacts: Vec<usize>,
    /// Shares of each point: of the springs' elongations, of their rates, of the contacts' forces.
    shares: Vec<Vec<f64>>,
    /// The same elongations, rates and forces.
    inputs: Vec<f64>,
    /// Motion of each point at the places of the present step, m.
    motions_m: Vec<[f64; PLACES]>,
    /// Whether the motion at the end of the step before is that at the start of the next.
    goes_on: bool,
}

impl ResidualTrack {
    /// Of these points; `None` where their casting has no residual flexibility.
    pub fn new(model: &CoupledModel, points: &[PointId]) -> Option<Self> {
        let motions: Vec<ResidualMotion> =
            points.iter().map(|point| model.residual_motion(*point)).collect::<Option<_>>()?;
        let first = motions.first()?;
        let moves = |of: &dyn Fn(&ResidualMotion) -> f64| motions.iter().any(|motion| of(motion) != 0.0);
        let springs: Vec<usize> =
            (0..first.elongations.len()).filter(|&at| moves(&|motion| motion.elongations[at])).collect();
        let contacts: Vec<usize> =
            (0..first.contacts_m_per_n.len()).filter(|&at| moves(&|motion| motion.contacts_m_per_n[at])).collect();
        let shares = |motion: &ResidualMotion| {
            let of = |shares: &[f64], places: &[usize]| places.iter().map(|at| shares[*at]).collect::<Vec<f64>>();
            let ResidualMotion { elongations, rates_s, contacts_m_per_n } = motion;
            [of(elongations, &springs), of(rates_s, &springs), of(contacts_m_per_n, &contacts)].concat()
        };
        Some(Self {
            shares: motions.iter().map(shares).collect(),
            inputs: vec![0.0; 2 * springs.len() + contacts.len()],
            motions_m: vec![[0.0; PLACES]; points.len()],
            goes_on: false,
            springs,
            contacts,
        })
    }

    /// A contact has closed or opened: forces jump.
    pub fn jump(&mut self) {
        self.goes_on = false;
    }

    /// Reads the motion in a step.
    pub fn step(&mut self, system: &Coupled, step: &Step<'_>, scratch: &mut [f64]) {
        if self.goes_on {
            self.motions_m.iter_mut().for_each(|motion| motion[0] = motion[PLACES - 1]);
        } else {
            step.write_start(scratch);
            self.read(0, system, (step.t0, scratch));
        }
        let middle = 0.5 * step.theta_end;
        step.state(middle, scratch);
        self.read(1, system, (step.time(middle), scratch));
        step.write_end(scratch);
        self.read(2, system, (step.t1(), scratch));
        self.goes_on = true;
    }

    fn read(&mut self, place: usize, system: &Coupled, (t, y): (f64, &[f64])) {
        let springs = self.springs.len();
        for (at, spring) in self.springs.iter().enumerate() {
            (self.inputs[at], self.inputs[springs + at]) = system.relative_motion(*spring, t, y);
        }
        for (at, contact) in self.contacts.iter().enumerate() {
            let at_rest_n = system.model().elements().contacts()[*contact].rest_force_n;
            self.inputs[2 * springs + at] = system.contact_force(*contact, t, y) - at_rest_n;
        }
        for (motion, shares) in self.motions_m.iter_mut().zip(&self.shares) {
            motion[place] = shares.iter().zip(&self.inputs).map(|(share, input)| share * input).sum();
        }
    }

    /// Motion of a point in m by powers of the fraction of the whole step, of which a part up to `theta_end` has been read.
    pub fn motion(&self, point: usize, theta_end: f64) -> [f64; 4] {
        let [start, middle, end] = self.motions_m[point];
        let bend = 2.0 * (start - 2.0 * middle + end);
        [start, (end - start - bend) / theta_end, bend / (theta_end * theta_end), 0.0]
    }
}

//! The equations with their discrete state, and what is kept of a solution.

use std::sync::Arc;

use decore_model::integrate::{Switching, System};
use decore_model::scene::{Guide, Method, ModeTreatment, OutputSettings, PointId, Scene, SolverSettings};
use decore_model::system::{Coupled, CoupledModel, build};

use crate::scene::Rig;

/// Parts into which a step is cut to bracket the casting's peak velocity.
const PARTS: usize = 8;
/// Parabolas through the best three points by which it is refined.
const REFINEMENTS: usize = 4;

/// Time in s after its own switch for which a guard is taken as negative: at the switch it is a rounding error of either sign.
const FRESH_S: f64 = 1e-10;

/// The model of a rig with its modes integrated.
pub fn problem_model(rig: &Rig, guide: Guide) -> Arc<CoupledModel> {
    let solver = SolverSettings { guide, modes: ModeTreatment::Integrated, method: Method::Tsit5, ..rig.scene.solver };
    build(&Scene { solver, ..rig.scene.clone() }, &rig.modes).expect("the rig can be built")
}

/// What is kept of a solution.
#[derive(Default)]
pub struct Solution {
    first_impact_j: Option<f64>,
    /// Time and energy of each blow of the percussion.
    blows: Vec<(f64, f64)>,
    peak_velocity_m_s: f64,
}

impl Solution {
    /// Energy of the first impact in J, once it has happened.
    pub fn first_impact_j(&self) -> Option<f64> {
        self.first_impact_j
    }

    /// First-impact energy, mean periodic energy, hit frequency, casting peak velocity, of a run that ended at `end_s`.
    pub fn figures(&self, settings: &OutputSettings, end_s: f64) -> [f64; 4] {
        let whole = self.blows.iter().filter(|(t, _)| t + settings.blow_window_s <= end_s);
        let periodic: Vec<&(f64, f64)> = whole.skip(settings.settling_blows).collect();
        let count = periodic.len() as f64;
        let energy = periodic.iter().map(|(_, energy)| energy).sum::<f64>() / count;
        let frequency = match (periodic.first(), periodic.last()) {
            (Some(first), Some(last)) => (count - 1.0) / (last.0 - first.0),
            _ => f64::NAN,
        };
        [self.first_impact_j.unwrap_or(f64::NAN), energy, frequency, self.peak_velocity_m_s]
    }
}

/// A coupled system in the hands of a foreign solver.
pub struct Problem {
    system: Coupled,
    settings: OutputSettings,
    /// State and rate with the quadratures, which the solver does not see.
    full: [Vec<f64>; 2],
    /// What is kept.
    pub solution: Solution,
    /// Right-hand sides.
    pub evaluations: u64,
    /// Steps.
    pub steps: u64,
    /// Switches of contacts, and how many of them the solver's root finding had missed.
    pub switches: [u64; 2],
    scratch: Vec<f64>,
    /// Time of each contact's last switch.
    switched_s: Vec<f64>,
}

impl Problem {
    /// The problem at rest.
    pub fn new(model: &Arc<CoupledModel>, settings: OutputSettings) -> Self {
        let rest = model.initial_state().to_vec();
        Self {
            system: Coupled::new(model),
            settings,
            full: [rest.clone(), rest],
            solution: Solution::default(),
            evaluations: 0,
            steps: 0,
            switches: [0; 2],
            scratch: vec![0.0; model.layout().states()],
            switched_s: vec![f64::NEG_INFINITY; model.elements().contacts().len()],
        }
    }

    /// States at rest.
    pub fn initial(&self) -> Vec<f64> {
        let model = self.system.model();
        model.initial_state()[..model.layout().states()].to_vec()
    }

    /// Size of each state at which an error counts as 1 / tolerance.
    pub fn scales(&self) -> &[f64] {
        self.system.scales()
    }

    /// Forces of contacts follow the state from now on.
    pub fn follow_state(&mut self) {
        self.system.follow_state(true);
    }

    /// Guard of the chisel's contact with the casting.
    pub fn strike(&self) -> usize {
        self.system.model().hammers()[0].strike
    }

    /// Index of the casting's heave velocity.
    pub fn heave(&self) -> usize {
        let model = self.system.model();
        model.layout().velocity(model.points().row(PointId::Centre { casting: 0 })[0].0)
    }

    /// Contacts.
    pub fn guard_count(&self) -> usize {
        self.system.guard_count()
    }

    /// Writes the rate at a state.
    pub fn rhs(&mut self, t: f64, y: &[f64], rate: &mut [f64]) {
        let [full, full_rate] = &mut self.full;
        full[..y.len()].copy_from_slice(y);
        self.system.rhs(t, full, full_rate);
        rate.copy_from_slice(&full_rate[..y.len()]);
        self.evaluations += 1;
    }

    /// Value of a guard: switches when it rises through zero.
    pub fn guard(&self, guard: usize, t: f64, y: &[f64]) -> f64 {
        if t < self.switched_s[guard] + FRESH_S { -1.0 } else { self.system.guard(guard, t, y) }
    }

    /// Switches a contact and keeps what follows from it.
    pub fn switch(&mut self, guard: usize, t: f64, y: &[f64]) {
        self.full[0][..y.len()].copy_from_slice(y);
        self.system.switch(guard, t, &mut self.full[0]);
        self.switched_s[guard] = t;
        self.switches[0] += 1;
        if !self.system.is_closed(guard) {
            return;
        }
        let model = self.system.model();
        let energy = model.impact_energy(0, &self.full[0]);
        let hammer = &model.hammers()[0];
        match guard {
            strike if strike == hammer.strike && self.solution.first_impact_j.is_none() => {
                self.solution.first_impact_j = Some(energy);
            }
            piston if piston == hammer.percussion && self.system.gate_open(0) => {
                let (_, closing) = self.system.penetration(guard, t, &self.full[0]);
                let last = self.solution.blows.last().map_or(f64::NEG_INFINITY, |blow| blow.0);
                let separate = t - last >= self.settings.blow_separation_s;
                if separate && closing >= self.settings.blow_closing_speed_m_s {
                    self.solution.blows.push((t, energy));
                }
            }
            _ => {}
        }
    }

    /// Switches every contact whose guard is positive although the solver has found no root; returns whether there was one.
    pub fn switch_late(&mut self, t: f64, y: &[f64]) -> bool {
        let late: Vec<usize> = (0..self.guard_count()).filter(|&guard| self.guard(guard, t, y) > 0.0).collect();
        late.iter().for_each(|&guard| self.switch(guard, t, y));
        self.switches[1] += late.len() as u64;
        !late.is_empty()
    }

    /// Time of the next scheduled stop, at most `end_s`.
    pub fn next_stop(&self, end_s: f64) -> f64 {
        self.system.next_stop().min(end_s)
    }

    /// Passes the stops due at `t`; returns whether there was one.
    pub fn pass_stops(&mut self, t: f64) -> bool {
        let mut any = false;
        while self.system.next_stop() <= t {
            self.system.pass_stop();
            any = true;
        }
        any
    }

    /// Keeps the casting's peak velocity over a step from `t0` to `t1` with dense output.
    pub fn step(&mut self, (t0, t1): (f64, f64), dense: &mut dyn FnMut(f64, &mut [f64])) {
        self.steps += 1;
        let heave = self.heave();
        let scratch = &mut self.scratch;
        let mut at = |share: f64| {
            dense(t0 + share * (t1 - t0), scratch);
            scratch[heave].abs()
        };
        let known = self.solution.peak_velocity_m_s;
        // Far below the peak a step cannot reach it.
        if at(0.0).max(at(1.0)) < 0.7 * known {
            return;
        }
        let spacing = 1.0 / PARTS as f64;
        let samples: Vec<f64> = (0..=PARTS).map(|i| at(i as f64 * spacing)).collect();
        let best = (1..PARTS).fold(1, |best, i| if samples[i] > samples[best] { i } else { best });
        let mut peak = samples.iter().copied().fold(known, f64::max);
        let (mut middle, mut width) = (best as f64 * spacing, spacing);
        for _ in 0..REFINEMENTS {
            let [low, here, high] = [middle - width, middle, middle + width].map(&mut at);
            let bend = low - 2.0 * here + high;
            if bend >= 0.0 {
                break;
            }
            middle = (middle + 0.5 * width * (low - high) / bend).clamp(0.0, 1.0);
            peak = peak.max(here).max(at(middle));
            width = (0.25 * width).min(middle).min(1.0 - middle);
        }
        self.solution.peak_velocity_m_s = peak;
    }
}

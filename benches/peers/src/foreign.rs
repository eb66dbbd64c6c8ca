//! diffsol with root finding: its methods on the same right-hand side, dense algebra of nalgebra.

use std::cell::RefCell;

use diffsol::{
    NalgebraLU, NalgebraMat, NalgebraVec, OdeBuilder, OdeEquations, OdeSolverMethod, OdeSolverStopReason, Vector,
};
use peers::Problem;

use crate::run::{Goal, Stop};

type Matrix = NalgebraMat<f64>;

/// Methods of diffsol.
#[derive(Clone, Copy)]
pub enum Method {
    /// Explicit, order 5(4).
    Tsit45,
    /// Variable order BDF.
    Bdf,
    /// L-stable, order 3(4).
    Esdirk34,
}

/// Share of a scale by which a state is moved for a directional derivative.
const PERTURBATION: f64 = 1e-4;
/// First step in s, also after an event.
const FIRST_STEP_S: f64 = 1e-6;

/// The rate at the state of the last directional derivative.
#[derive(Default)]
struct Base {
    y: Vec<f64>,
    rate: Vec<f64>,
    moved: Vec<f64>,
}

/// Integrates from rest until the goal says stop; returns the time reached.
pub fn integrate(method: Method, problem: &mut Problem, goal: &Goal) -> Result<f64, Stop> {
    let (initial, scales) = (problem.initial(), problem.scales().to_vec());
    let (states, guards) = (initial.len(), problem.guard_count());
    let problem = RefCell::new(problem);
    let base = RefCell::new(Base::default());
    let rhs = |y: &[f64], _: &[f64], t: f64, rate: &mut [f64]| problem.borrow_mut().rhs(t, y, rate);
    let jacobian = |y: &[f64], _: &[f64], t: f64, v: &[f64], product: &mut [f64]| {
        let (base, problem) = (&mut *base.borrow_mut(), &mut *problem.borrow_mut());
        if base.y != y {
            base.y = y.to_vec();
            base.rate.resize(states, 0.0);
            problem.rhs(t, y, &mut base.rate);
        }
        let size = v.iter().zip(&scales).map(|(v, scale)| (v / scale).abs()).fold(0.0, f64::max);
        if size == 0.0 {
            return product.fill(0.0);
        }
        let by = PERTURBATION / size;
        base.moved.clear();
        base.moved.extend(y.iter().zip(v).map(|(y, v)| y + by * v));
        problem.rhs(t, &base.moved, product);
        product.iter_mut().zip(&base.rate).for_each(|(product, rate)| *product = (*product - rate) / by);
    };
    let roots = |y: &[f64], _: &[f64], t: f64, values: &mut [f64]| {
        let problem = problem.borrow();
        values.iter_mut().enumerate().for_each(|(guard, value)| *value = problem.guard(guard, t, y));
    };
    let problem_of_theirs = OdeBuilder::<Matrix>::new()
        // Relative tolerances are of no use here: a contact's force is felt in a millionth of a position.
        .rtol(1e-16)
        .atol(scales.iter().map(|scale| goal.tolerance * scale))
        .h0(FIRST_STEP_S)
        .rhs_implicit(rhs, jacobian)
        .init(|_: &[f64], _, y: &mut [f64]| y.copy_from_slice(&initial), states)
        .root(roots, guards)
        .build()
        .map_err(failed)?;
    match method {
        Method::Tsit45 => drive(&mut problem_of_theirs.tsit45().map_err(failed)?, &problem, goal),
        Method::Bdf => drive(&mut problem_of_theirs.bdf::<NalgebraLU<f64>>().map_err(failed)?, &problem, goal),
        Method::Esdirk34 => {
            drive(&mut problem_of_theirs.esdirk34::<NalgebraLU<f64>>().map_err(failed)?, &problem, goal)
        }
    }
}

fn elements(y: &NalgebraVec<f64>) -> Vec<f64> {
    (0..y.len()).map(|i| y[i]).collect()
}

fn failed(error: diffsol::DiffsolError) -> Stop {
    Stop::Failed(error.to_string())
}

fn drive<'a, Equations, Solver>(solver: &mut Solver, problem: &RefCell<&mut Problem>, goal: &Goal) -> Result<f64, Stop>
where
    Equations: OdeEquations<T = f64, V = NalgebraVec<f64>, M = Matrix> + 'a,
    Solver: OdeSolverMethod<'a, Equations>,
{
    let mut begin = 0.0;
    let mut stop = problem.borrow().next_stop(goal.end_s);
    solver.set_stop_time(stop).map_err(failed)?;
    while begin < goal.end_s {
        if goal.out_of_time() {
            return Err(Stop::OutOfTime(begin));
        }
        let reason = solver.step().map_err(failed)?;
        // A guard that falls through zero has switched before: nothing to do.
        let rising = match reason {
            OdeSolverStopReason::RootFound(t, guard) => {
                let now = solver.state();
                (problem.borrow().guard(guard, now.t, &elements(now.y)) > 0.0).then_some((t, guard))
            }
            _ => None,
        };
        let reached = rising.map_or(solver.state().t, |(t, _)| t);
        let mut dense = |t: f64, out: &mut [f64]| {
            if let Ok(y) = solver.interpolate(t.min(reached)) {
                out.copy_from_slice(&elements(&y));
            }
        };
        if reached > begin {
            problem.borrow_mut().step((begin, reached), &mut dense);
        }
        let mut changed = false;
        if let Some((t, guard)) = rising {
            solver.state_mut_back(t).map_err(failed)?;
            let state = elements(solver.state().y);
            problem.borrow_mut().switch(guard, t, &state);
            changed = true;
        } else {
            let state = elements(solver.state().y);
            changed |= problem.borrow_mut().switch_late(reached, &state);
        }
        changed |= problem.borrow_mut().pass_stops(reached);
        if changed {
            let state = elements(solver.state().y);
            let mut rate = vec![0.0; state.len()];
            let now = solver.state_mut();
            problem.borrow_mut().rhs(reached, &state, &mut rate);
            rate.iter().enumerate().for_each(|(i, rate)| now.dy[i] = *rate);
            *now.h = FIRST_STEP_S;
        }
        begin = reached;
        let next = problem.borrow().next_stop(goal.end_s);
        if (changed || next != stop) && next > begin {
            stop = next;
            solver.set_stop_time(stop).map_err(failed)?;
        }
    }
    Ok(begin)
}

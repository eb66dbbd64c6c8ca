//! The problem for `ctypes`: contacts follow the state, stops are passed by the caller.

use std::ffi::{CStr, c_char};
use std::path::Path;

use decore_model::scene::Guide;

use crate::problem::{Problem, problem_model};
use crate::scene::prepare;

/// Loads the study at `path`, guide tied or not; the problem lives as long as the process.
///
/// # Safety
/// `path` is a string that ends in a zero byte.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn peer_new(path: *const c_char, tied: i32) -> *mut Problem {
    // SAFETY: the caller's promise.
    let path = unsafe { CStr::from_ptr(path) }.to_string_lossy().into_owned();
    let rig = prepare(Path::new(&path), &[]);
    let guide = if tied != 0 { Guide::Tied } else { Guide::Spring };
    let model = Box::leak(Box::new(problem_model(&rig, guide)));
    let mut problem = Problem::new(model, rig.scene.outputs);
    problem.follow_state();
    Box::into_raw(Box::new(problem))
}

/// Number of states.
///
/// # Safety
/// `problem` comes from [`peer_new`]; so for all functions here.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn peer_states(problem: *const Problem) -> usize {
    // SAFETY: the caller's promise.
    unsafe { &*problem }.initial().len()
}

/// Writes the states at rest and their scales.
///
/// # Safety
/// Both arrays have [`peer_states`] elements.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn peer_initial(problem: *const Problem, y: *mut f64, scales: *mut f64) {
    // SAFETY: the caller's promise.
    let problem = unsafe { &*problem };
    let n = problem.initial().len();
    // SAFETY: the caller's promise.
    let (y, scales) = unsafe { (std::slice::from_raw_parts_mut(y, n), std::slice::from_raw_parts_mut(scales, n)) };
    y.copy_from_slice(&problem.initial());
    scales.copy_from_slice(problem.scales());
}

/// Writes the rate at a state.
///
/// # Safety
/// Both arrays have [`peer_states`] elements.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn peer_rhs(problem: *mut Problem, t: f64, y: *const f64, rate: *mut f64) {
    // SAFETY: the caller's promise.
    let problem = unsafe { &mut *problem };
    let n = problem.initial().len();
    // SAFETY: the caller's promise.
    let (y, rate) = unsafe { (std::slice::from_raw_parts(y, n), std::slice::from_raw_parts_mut(rate, n)) };
    problem.rhs(t, y, rate);
}

/// Value of the guard of the chisel's contact with the casting: zero at the first impact.
///
/// # Safety
/// `y` has [`peer_states`] elements.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn peer_strike(problem: *const Problem, t: f64, y: *const f64) -> f64 {
    // SAFETY: the caller's promise.
    let problem = unsafe { &*problem };
    // SAFETY: the caller's promise.
    let y = unsafe { std::slice::from_raw_parts(y, problem.initial().len()) };
    problem.guard(problem.strike(), t, y)
}

/// Starts the gate's clock at the first impact; returns the impact's energy in J.
///
/// # Safety
/// `y` has [`peer_states`] elements.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn peer_first_impact(problem: *mut Problem, t: f64, y: *const f64) -> f64 {
    // SAFETY: the caller's promise.
    let problem = unsafe { &mut *problem };
    // SAFETY: the caller's promise.
    let y = unsafe { std::slice::from_raw_parts(y, problem.initial().len()) };
    problem.switch(problem.strike(), t, y);
    problem.solution.first_impact_j().unwrap_or(f64::NAN)
}

/// Index of the casting's heave velocity.
///
/// # Safety
/// As [`peer_states`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn peer_heave(problem: *const Problem) -> usize {
    // SAFETY: the caller's promise.
    unsafe { &*problem }.heave()
}

/// Time of the next scheduled stop after passing those due at `t`.
///
/// # Safety
/// As [`peer_states`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn peer_next_stop(problem: *mut Problem, t: f64) -> f64 {
    // SAFETY: the caller's promise.
    let problem = unsafe { &mut *problem };
    problem.pass_stops(t);
    problem.next_stop(f64::INFINITY)
}

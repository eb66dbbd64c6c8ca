//! SUNDIALS CVODE (BDF, dense direct solver, root finding), loaded when it is installed.

use std::ffi::{CStr, c_char, c_double, c_int, c_long, c_void};

use peers::Problem;

use crate::run::{Goal, Stop};

/// Names under which the library is looked for.
const LIBRARIES: [&CStr; 3] = [c"libsundials_cvode.so.6", c"libsundials_cvode.so.7", c"libsundials_cvode.so"];
const BDF: c_int = 2;
const ONE_STEP: c_int = 2;
const ROOT_RETURN: c_int = 2;
const RTLD_NOW: c_int = 2;
/// Steps between two calls.
const MAX_STEPS: c_long = 10_000_000;

unsafe extern "C" {
    fn dlopen(path: *const c_char, flags: c_int) -> *mut c_void;
    fn dlsym(library: *mut c_void, name: *const c_char) -> *mut c_void;
}

type Rhs = extern "C" fn(c_double, *mut c_void, *mut c_void, *mut c_void) -> c_int;
type Root = extern "C" fn(c_double, *mut c_void, *mut c_double, *mut c_void) -> c_int;

/// Functions of the library, by their own names.
#[derive(Clone, Copy)]
pub struct Library {
    context_create: unsafe extern "C" fn(*mut c_void, *mut *mut c_void) -> c_int,
    vector: unsafe extern "C" fn(i64, *mut c_void) -> *mut c_void,
    vector_data: unsafe extern "C" fn(*mut c_void) -> *mut c_double,
    matrix: unsafe extern "C" fn(i64, i64, *mut c_void) -> *mut c_void,
    linear_solver: unsafe extern "C" fn(*mut c_void, *mut c_void, *mut c_void) -> *mut c_void,
    create: unsafe extern "C" fn(c_int, *mut c_void) -> *mut c_void,
    init: unsafe extern "C" fn(*mut c_void, Rhs, c_double, *mut c_void) -> c_int,
    tolerances: unsafe extern "C" fn(*mut c_void, c_double, *mut c_void) -> c_int,
    user_data: unsafe extern "C" fn(*mut c_void, *mut c_void) -> c_int,
    set_linear_solver: unsafe extern "C" fn(*mut c_void, *mut c_void, *mut c_void) -> c_int,
    max_steps: unsafe extern "C" fn(*mut c_void, c_long) -> c_int,
    root_init: unsafe extern "C" fn(*mut c_void, c_int, Root) -> c_int,
    root_direction: unsafe extern "C" fn(*mut c_void, *mut c_int) -> c_int,
    root_info: unsafe extern "C" fn(*mut c_void, *mut c_int) -> c_int,
    stop_time: unsafe extern "C" fn(*mut c_void, c_double) -> c_int,
    step: unsafe extern "C" fn(*mut c_void, c_double, *mut c_void, *mut c_double, c_int) -> c_int,
    dense: unsafe extern "C" fn(*mut c_void, c_double, c_int, *mut c_void) -> c_int,
    restart: unsafe extern "C" fn(*mut c_void, c_double, *mut c_void) -> c_int,
}

impl Library {
    /// Loads it; `None` where it is not installed.
    #[expect(clippy::missing_transmute_annotations, reason = "the fields of this type say what each symbol is")]
    pub fn load() -> Option<Self> {
        // SAFETY: the names end in a zero byte.
        let library = LIBRARIES.iter().map(|name| unsafe { dlopen(name.as_ptr(), RTLD_NOW) }).find(|l| !l.is_null())?;
        macro_rules! symbol {
            ($name:literal) => {{
                // SAFETY: the library is open and the name ends in a zero byte.
                let address = unsafe { dlsym(library, $name.as_ptr()) };
                if address.is_null() {
                    return None;
                }
                // SAFETY: the signatures are those of the headers of SUNDIALS 6 with 64-bit indices and double precision.
                unsafe { std::mem::transmute(address) }
            }};
        }
        Some(Self {
            context_create: symbol!(c"SUNContext_Create"),
            vector: symbol!(c"N_VNew_Serial"),
            vector_data: symbol!(c"N_VGetArrayPointer"),
            matrix: symbol!(c"SUNDenseMatrix"),
            linear_solver: symbol!(c"SUNLinSol_Dense"),
            create: symbol!(c"CVodeCreate"),
            init: symbol!(c"CVodeInit"),
            tolerances: symbol!(c"CVodeSVtolerances"),
            user_data: symbol!(c"CVodeSetUserData"),
            set_linear_solver: symbol!(c"CVodeSetLinearSolver"),
            max_steps: symbol!(c"CVodeSetMaxNumSteps"),
            root_init: symbol!(c"CVodeRootInit"),
            root_direction: symbol!(c"CVodeSetRootDirection"),
            root_info: symbol!(c"CVodeGetRootInfo"),
            stop_time: symbol!(c"CVodeSetStopTime"),
            step: symbol!(c"CVode"),
            dense: symbol!(c"CVodeGetDky"),
            restart: symbol!(c"CVodeReInit"),
        })
    }
}

/// What the callbacks are given.
struct User<'p> {
    library: Library,
    problem: &'p mut Problem,
    states: usize,
}

impl User<'_> {
    /// The elements of a vector of the library.
    fn elements<'v>(&self, vector: *mut c_void) -> &'v mut [f64] {
        // SAFETY: all vectors of one solver have as many elements as there are states, and outlive its callbacks.
        unsafe { std::slice::from_raw_parts_mut((self.library.vector_data)(vector), self.states) }
    }
}

extern "C" fn rhs(t: c_double, y: *mut c_void, rate: *mut c_void, user: *mut c_void) -> c_int {
    // SAFETY: `user` is the one that was set.
    let user = unsafe { &mut *user.cast::<User>() };
    let (y, rate) = (user.elements(y), user.elements(rate));
    user.problem.rhs(t, y, rate);
    // Positive: recoverable, with a shorter step.
    c_int::from(rate.iter().any(|rate| !rate.is_finite()))
}

extern "C" fn roots(t: c_double, y: *mut c_void, values: *mut c_double, user: *mut c_void) -> c_int {
    // SAFETY: `user` is the one that was set; there is a value per guard.
    let user = unsafe { &mut *user.cast::<User>() };
    let y = user.elements(y);
    let count = user.problem.guard_count();
    // SAFETY: as above.
    let values = unsafe { std::slice::from_raw_parts_mut(values, count) };
    values.iter_mut().enumerate().for_each(|(guard, value)| *value = user.problem.guard(guard, t, y));
    0
}

/// Integrates from rest until the goal says stop; returns the time reached.
pub fn integrate(library: Library, problem: &mut Problem, goal: &Goal) -> Result<f64, Stop> {
    let (initial, scales) = (problem.initial(), problem.scales().to_vec());
    let (states, guards) = (initial.len(), problem.guard_count());
    let mut user = User { library, problem, states };
    let mut context = std::ptr::null_mut();
    let mut reached = 0.0;
    // SAFETY: objects are made and used as the library's manual says; `user` outlives the solver's last call. What the
    // library has allocated is left to the end of the process.
    unsafe {
        (library.context_create)(std::ptr::null_mut(), &raw mut context);
        let [y, absolute, between] = [(); 3].map(|()| (library.vector)(states as i64, context));
        user.elements(y).copy_from_slice(&initial);
        user.elements(absolute).iter_mut().zip(&scales).for_each(|(to, scale)| *to = goal.tolerance * scale);
        let solver = (library.create)(BDF, context);
        let matrix = (library.matrix)(states as i64, states as i64, context);
        (library.init)(solver, rhs, 0.0, y);
        (library.tolerances)(solver, 0.0, absolute);
        (library.user_data)(solver, (&raw mut user).cast());
        (library.set_linear_solver)(solver, (library.linear_solver)(y, matrix, context), matrix);
        (library.max_steps)(solver, MAX_STEPS);
        (library.root_init)(solver, guards as c_int, roots);
        (library.root_direction)(solver, vec![1; guards].as_mut_ptr());
        let mut found = vec![0; guards];
        while reached < goal.end_s {
            if goal.out_of_time() {
                return Err(Stop::OutOfTime(reached));
            }
            (library.stop_time)(solver, user.problem.next_stop(goal.end_s));
            let begin = reached;
            let flag = (library.step)(solver, goal.end_s, y, &raw mut reached, ONE_STEP);
            if flag < 0 {
                return Err(Stop::Failed(format!("CVODE's error {flag} at t = {reached:.4} s")));
            }
            let mut dense = |t: f64, out: &mut [f64]| {
                (library.dense)(solver, t, 0, between);
                let data = (library.vector_data)(between);
                out.copy_from_slice(std::slice::from_raw_parts(data, states));
            };
            user.problem.step((begin, reached), &mut dense);
            let mut changed = false;
            let state = user.elements(y);
            if flag == ROOT_RETURN {
                (library.root_info)(solver, found.as_mut_ptr());
                for guard in (0..guards).filter(|&guard| found[guard] > 0) {
                    user.problem.switch(guard, reached, state);
                    changed = true;
                }
            }
            changed |= user.problem.switch_late(reached, state);
            changed |= user.problem.pass_stops(reached);
            if changed {
                (library.restart)(solver, reached, y);
            }
        }
    }
    Ok(reached)
}

//! Nothing is allocated in the step loop: the number of allocations does not grow with the simulated time.

mod common;

use std::alloc::{GlobalAlloc, Layout, System as Heap};
use std::cell::Cell;
use std::sync::Arc;

use common::harness::settings;
use common::scenes::rig;
use decore_model::integrate::{Counters, FixedStep, Integrator, Rk4, Settings, Stepper, Stopped, Trapezoid, Tsit5};
use decore_model::metrics::Recorder;
use decore_model::system::{Coupled, CoupledModel, build};

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

/// The system's allocator with a counter per thread (the test runner has threads of its own).
struct Counting;

unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // A thread that is being torn down has no counter any more.
        let _ = ALLOCATIONS.try_with(|count| count.set(count.get() + 1));
        unsafe { Heap.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { Heap.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        let _ = ALLOCATIONS.try_with(|count| count.set(count.get() + 1));
        unsafe { Heap.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn counted<T>(work: impl FnOnce() -> T) -> (T, u64) {
    let before = ALLOCATIONS.with(Cell::get);
    let result = work();
    (result, ALLOCATIONS.with(Cell::get) - before)
}

/// The counter counts.
#[test]
fn the_counter_sees_an_allocation() {
    let (kept, count) = counted(|| vec![1.0; 10]);
    assert_eq!((kept.len(), count), (10, 1));
}

/// Two whole hammers through 0.3 s: first impacts, percussion, some thousand contacts. None but the growth of the list of
/// blows, which a step knows nothing of.
#[test]
fn a_step_allocates_nothing() {
    let (scene, modes) = rig(2);
    let model = build(&scene, &modes).expect("sound");
    let mut system = Coupled::new(&model);
    let mut integrator = Integrator::<_, Tsit5>::new(&system, 0.0, model.initial_state(), &settings(1e-5, 1e-3));
    let (stopped, count) = counted(|| integrator.run(&mut system, &mut (), 0.3));
    assert_eq!(stopped, Stopped::AtEnd);
    println!(
        "{} steps, {} events, {count} allocations",
        integrator.counters().steps,
        integrator.counters().located_events
    );
    assert!(integrator.counters().located_events > 100);
    assert_eq!(count, 0);
    let mut system = Coupled::new(&model);
    let mut recorder = Recorder::new(&model, &scene);
    let mut integrator = Integrator::<_, Tsit5>::new(&system, 0.0, model.initial_state(), &settings(1e-5, 1e-3));
    let (stopped, count) = counted(|| integrator.run(&mut system, &mut recorder, 0.3));
    assert_eq!(stopped, Stopped::AtEnd);
    let blows = recorder.finish(&system, integrator.time(), integrator.state()).blows.len();
    println!("{blows} blows, {count} allocations");
    // A list of n entries doubles log2(n) times.
    assert!(blows > 4);
    assert!(count <= u64::from(blows.ilog2()) + 1, "{count} allocations for {blows} blows");
}

/// Neither do the methods at a fixed step; a new factorisation of the implicit one takes memory for its matrix, the
/// permutation and their bookkeeping.
#[test]
fn a_fixed_step_allocates_nothing() {
    let (scene, modes) = rig(2);
    let model = build(&scene, &modes).expect("sound");
    for run in [fixed::<FixedStep<Rk4>>, fixed::<FixedStep<Trapezoid>>] {
        let (counters, count) = run(&model);
        println!("{counters:?}, {count} allocations");
        assert!(counters.steps >= 10_000 && counters.located_events > 10);
        assert!(count <= 4 * counters.factorisations, "{count} allocations");
    }
}

/// Work and allocations of a method at a fixed step.
fn fixed<P: Stepper<Coupled>>(model: &Arc<CoupledModel>) -> (Counters, u64) {
    let settings = Settings { step_s: 1e-5, located: false, ..settings(1e-5, 1e-3) };
    let mut system = Coupled::new(model);
    let mut integrator = Integrator::<_, P>::new(&system, 0.0, model.initial_state(), &settings);
    let (stopped, count) = counted(|| integrator.run(&mut system, &mut (), 0.1));
    assert_eq!(stopped, Stopped::AtEnd);
    (integrator.counters(), count)
}

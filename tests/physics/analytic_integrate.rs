//! The integrator against closed forms: orders, events, stops, budgets, divergence, quadratures.

use std::f64::consts::PI;

use crate::common::harness::{
    Event, Harness, Piecewise, Run, Samples, Smooth, Solved, assert_close, distance, fixed_step, observe, run,
    settings, slope,
};
use crate::common::smooth::{Cliff, Explosion, Kepler, Manufactured, Oscillator, Polyline};
use decore_model::integrate::Stopped;

const ORBIT: Kepler = Kepler { eccentricity: 0.3 };

fn at_end(run: Run) -> Run {
    assert_eq!(run.stopped, Stopped::AtEnd);
    run
}

/// The error at the end of an arc falls with the fifth power of the step. 0.2: the method's leading error term is very
/// small, so the next power is still felt at steps whose errors stand clear of rounding (5.16, 5.10 from pair to pair).
#[test]
fn analytic_order_five() {
    let errors: Vec<(f64, f64)> = [40, 56, 80, 113, 160]
        .map(|steps| {
            let h = 2.0 / f64::from(steps);
            let run = at_end(run(&mut Smooth(ORBIT), &ORBIT.solution(0.0), fixed_step(h), 2.0));
            (h, distance(&run.y, &ORBIT.solution(2.0)))
        })
        .to_vec();
    let order = slope(&errors);
    println!("order {order:.3}, errors {errors:?}");
    assert!((order - 5.0).abs() < 0.2, "observed order {order}");
}

/// One step of length `h` from the exact solution: error at its end, worst error of its dense output.
fn local_errors<S: Solved>(mut system: S, solution: impl Fn(f64) -> Vec<f64>, h: f64) -> [f64; 2] {
    let mut samples = Samples::new(40);
    let run = observe(&mut system, &solution(0.0), fixed_step(h), h, &mut samples);
    assert_eq!(run.counters.steps, 1);
    let worst = samples.points.iter().map(|(t, y)| distance(y, &solution(*t)));
    [distance(&run.y, &solution(h)), worst.fold(0.0, f64::max)]
}

/// The end of one step is off by h^6 (order 5), the worst point of the interpolant by h^5 (order 4). Each on the problem
/// where that power shows: elsewhere the method's small leading term hides behind the next one at steps whose errors
/// stand clear of rounding. 0.3: what the next power contributes here (6.17 at the shortest steps).
#[test]
fn analytic_local_errors_of_step_and_dense_output() {
    let steps = [0.06, 0.048, 0.038, 0.03, 0.024];
    let ends = steps.map(|h| (h, local_errors(Smooth(Manufactured), |t| Manufactured.solution(t), h)[0]));
    let steps = [0.2, 0.14, 0.1, 0.07, 0.05];
    let insides = steps.map(|h| (h, local_errors(Smooth(ORBIT), |t| ORBIT.solution(t), h)[1]));
    let (step, dense) = (slope(&ends), slope(&insides));
    println!("step {step:.3}, dense output {dense:.3}");
    assert!((step - 6.0).abs() < 0.3, "local error of the step: order {step}");
    assert!((dense - 5.0).abs() < 0.1, "local error of the dense output: order {dense}");
}

/// The dense output meets both ends of its step to rounding, so that what is read off it is continuous.
#[test]
fn analytic_dense_output_meets_the_ends() {
    let mut samples = Samples::new(1);
    let run = observe(&mut Smooth(ORBIT), &ORBIT.solution(0.0), fixed_step(0.1), 0.1, &mut samples);
    let (_, end) = &samples.points[0];
    assert!(distance(end, &run.y) < 1e-14);
}

/// The step's error estimate is of order 4, so steps follow tolerance^(1/5), and the error of the fifth-order solution
/// follows the tolerance itself.
#[test]
fn analytic_error_follows_the_tolerance() {
    let (mut errors, mut steps) = (Vec::new(), Vec::new());
    for tolerance in [1e-5, 1e-6, 1e-7, 1e-8, 1e-9] {
        let mut samples = Samples::new(1);
        let mut system = Smooth(Manufactured);
        let start = Manufactured.solution(0.0);
        let run = at_end(observe(&mut system, &start, settings(tolerance, 1.0), 20.0, &mut samples));
        let error = samples.points.iter().map(|(t, y)| distance(y, &Manufactured.solution(*t))).fold(0.0, f64::max);
        println!(
            "{tolerance:e}: {error:.2e} in {} steps, {} rejected",
            run.counters.steps, run.counters.rejected_steps
        );
        errors.push((tolerance, error));
        steps.push((tolerance, run.counters.steps as f64));
    }
    let (proportion, growth) = (slope(&errors), slope(&steps));
    println!("error ~ tolerance^{proportion:.3}, steps ~ tolerance^{growth:.3}");
    assert!((proportion - 1.0).abs() < 0.1, "error ~ tolerance^{proportion}");
    assert!((growth + 0.2).abs() < 0.02, "steps ~ tolerance^{growth}");
}

/// Every crossing of three levels over fifty periods is found once, at its time; levels that are never reached, one of
/// them a hair above the peak, are not. The bound on the times: the solution's own error at this tolerance.
#[test]
fn analytic_every_crossing_is_found_once() {
    let end = 100.0 * PI;
    let levels = [0.5, -0.9, 0.0, 1.0 + 1e-6, 7.0];
    let mut system = Harness::new(Oscillator::new(&levels));
    let run = at_end(run(&mut system, &[1.0, 0.0], settings(1e-10, 1.0), end));
    for (guard, level) in levels.iter().enumerate() {
        let found: Vec<f64> = run.events.iter().filter(|event| event.guard == guard).map(|event| event.t).collect();
        let expected = if *level < 1.0 { Oscillator::crossings(*level, end) } else { Vec::new() };
        assert_eq!(found.len(), expected.len(), "level {level}");
        let worst = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!("level {level}: {} crossings, worst time error {worst:.1e}", found.len());
        assert!(worst < 2e-8, "level {level}: {worst:e}");
    }
    assert_eq!(run.counters.located_events as usize, run.events.len());
}

/// A level just below a peak within a step: the guard is negative at both ends, and what happens in between must not be
/// missed, down to a share of 1e-5 of the amplitude. What the dense output errs by over this step moves a crossing
/// of slope `sin(half)` by that over `sin(half)`.
#[test]
fn analytic_contact_that_opens_and_closes_within_a_step() {
    let h: f64 = 0.2;
    for depth in [1e-3, 1e-4, 1e-5] {
        for start in [0.3, 0.45, 0.5, 0.62, 0.7] {
            let mut problem = Oscillator::new(&[1.0 - depth]);
            problem.direction = vec![1.0];
            let peak = start * h;
            let solution = |t: f64| vec![(t - peak).cos(), -(t - peak).sin()];
            let [_, dense] = local_errors(Harness::new(Oscillator::new(&[])), solution, h);
            let run = at_end(run(&mut Harness::new(problem), &[peak.cos(), peak.sin()], fixed_step(h), h));
            let times: Vec<f64> = run.events.iter().map(|event| event.t).collect();
            assert_eq!(times.len(), 2, "depth {depth}, start {start}");
            let half = (1.0 - depth).acos();
            // A tenth more for the curvature.
            let bound = 1.1 * dense / half.sin();
            assert_close("up", times[0], peak - half, bound);
            assert_close("down", times[1], peak + half, bound);
        }
    }
}

/// `x'' = -1`: a parabola, exact for the method, with guards that open at a height and close again below it.
struct Parabola {
    heights: Vec<f64>,
    above: Vec<bool>,
    /// The guard is closed by guard 0's switch rather than by its own height.
    follower: Option<usize>,
}

impl Parabola {
    fn new(heights: &[f64]) -> Self {
        Self { heights: heights.to_vec(), above: vec![false; heights.len()], follower: None }
    }
}

impl Piecewise for Parabola {
    fn states(&self) -> usize {
        2
    }

    fn rate(&self, _t: f64, y: &[f64], rate: &mut [f64]) {
        rate.copy_from_slice(&[y[1], -1.0]);
    }

    fn guards(&self) -> usize {
        self.heights.len()
    }

    fn guard(&self, guard: usize, y: &[f64]) -> f64 {
        if self.follower == Some(guard) {
            return if self.above[0] && !self.above[guard] { 1.0 } else { -1.0 };
        }
        let height = y[0] - self.heights[guard];
        if self.above[guard] { -height } else { height }
    }

    fn guard_rate(&self, guard: usize, rate: &[f64]) -> f64 {
        if self.above[guard] { -rate[0] } else { rate[0] }
    }

    fn switch(&mut self, guard: usize, _t: f64, _y: &mut [f64]) {
        self.above[guard] = !self.above[guard];
    }
}

fn times(events: &[Event], guard: usize) -> Vec<f64> {
    events.iter().filter(|event| event.guard == guard).map(|event| event.t).collect()
}

/// Two guards whose roots lie from nothing to a thousandth apart: each rises once and falls once, in order of time. This
/// is where a root found at a restart would be found again.
#[test]
fn analytic_roots_within_rounding_are_found_once() {
    for exponent in 0..60 {
        let apart = if exponent == 0 { 0.0 } else { 10f64.powf(-3.0 - 0.25 * f64::from(exponent)) };
        // x = 2 t - t^2 / 2 reaches 1.5 at t = 1 and t = 3.
        let mut system = Harness::new(Parabola::new(&[1.5, 1.5 + apart, 1.5 - apart]));
        let run = at_end(run(&mut system, &[0.0, 2.0], settings(1e-6, 5.0), 4.0));
        for (guard, height) in [1.5, 1.5 + apart, 1.5 - apart].into_iter().enumerate() {
            let found = times(&run.events, guard);
            assert_eq!(found.len(), 2, "{apart:e} apart, guard {guard}: {:?}", run.events);
            // Roots within 1e-10 of a step, here 5, count as one instant.
            let half = (4.0 - 2.0 * height).sqrt();
            assert_close("rise", found[0], 2.0 - half, 5e-10);
            assert_close("fall", found[1], 2.0 + half, 5e-10);
        }
    }
}

/// Guards with the same root switch at one and the same time, and the state is not integrated in between.
#[test]
fn analytic_events_of_the_same_instant() {
    let mut system = Harness::new(Parabola::new(&[1.5, 1.5, 1.5]));
    let run = at_end(run(&mut system, &[0.0, 2.0], settings(1e-6, 5.0), 4.0));
    assert_eq!(run.events.len(), 6);
    for three in run.events.chunks(3) {
        assert_eq!(three.iter().map(|event| event.guard).collect::<Vec<_>>(), [0, 1, 2]);
        assert!(three.iter().all(|event| event.t == three[0].t && event.y == three[0].y));
    }
}

/// A switch that makes another guard positive at once: the other follows at the same time, and the first, whose value
/// there is a rounding error of either sign, is not switched back.
#[test]
fn regress_switch_that_triggers_another() {
    for offset in 0..200 {
        // Different roots, so that the rounding differs.
        let height = 1.3 + 1e-3 * f64::from(offset);
        let mut problem = Parabola::new(&[height, 0.0]);
        problem.follower = Some(1);
        let run = at_end(run(&mut Harness::new(problem), &[0.0, 2.0], settings(1e-6, 5.0), 4.0));
        let guards: Vec<usize> = run.events.iter().map(|event| event.guard).collect();
        assert_eq!(guards, [0, 1, 0], "height {height}: {:?}", run.events);
        // The second event is seen at the very start of the next step.
        assert_eq!(run.events[0].t, run.events[1].t);
    }
}

/// Scheduled stops are met to the last bit: a polyline with its kinks there is exact. Two stops at once, one at the
/// start, two apart by less than the resolution of time, and one beyond the end, which is not passed.
#[test]
fn analytic_scheduled_stops() {
    let stops = [0.0, 0.3, 0.3, 0.7, 0.7 * (1.0 + 2e-16), 1.1, 9.0];
    for longest in [1.0, 0.0123] {
        let mut system = Harness::new(Polyline::new(&stops, -2.0));
        let run = at_end(run(&mut system, &[0.0], settings(1e-6, longest), 2.0));
        assert_eq!(system.problem.passed, [0, 1, 2, 3, 4, 5]);
        assert_eq!(run.t, 2.0);
        // Slopes reach 64: a stop missed by one rounding would cost 64 times 1e-16.
        assert_close("end", run.y[0], system.problem.solution(2.0), 1e-13);
    }
}

/// A stop does not ruin the step size: the steps after it are as long as before.
#[test]
fn analytic_stops_cost_one_step_each() {
    let stops: Vec<f64> = (1..50).map(|i| 0.37 * f64::from(i)).collect();
    let plain = run(&mut Harness::new(Polyline::new(&[], 1.0)), &[0.0], settings(1e-6, 0.5), 20.0);
    let stopped = run(&mut Harness::new(Polyline::new(&stops, 1.0)), &[0.0], settings(1e-6, 0.5), 20.0);
    assert!(stopped.counters.steps <= plain.counters.steps + 2 * stops.len() as u64);
}

/// Integrals that no right-hand side depends on: over `[0, T]`, of cos^2 and of the kinetic energy. They follow the
/// states' steps, are as accurate, and change none of them.
#[test]
fn analytic_quadratures() {
    let (end, plain) = (7.3_f64, Oscillator::new(&[0.5]));
    let mut counted = plain.clone();
    counted.quadratures = 2;
    let bare = at_end(run(&mut Harness::new(plain), &[1.0, 0.0], settings(1e-9, 1.0), end));
    let full = at_end(run(&mut Harness::new(counted), &[1.0, 0.0, 0.0, 0.0], settings(1e-9, 1.0), end));
    assert_eq!(bare.counters, full.counters);
    assert_eq!(bare.y, full.y[..2]);
    let wave = (2.0 * end).sin() / 4.0;
    println!("quadratures off by {:.1e}, {:.1e}", full.y[2] - end / 2.0 - wave, full.y[3] - (end / 4.0 - wave / 2.0));
    // Thirty steps, each within its tolerance.
    assert_close("integral of x^2", full.y[2], end / 2.0 + wave, 1e-8);
    assert_close("integral of x'^2 / 2", full.y[3], end / 4.0 - wave / 2.0, 1e-8);
}

/// Budgets end a run with what was reached, never with a failure.
#[test]
fn budgets_end_a_run() {
    let start = ORBIT.solution(0.0);
    let few = decore_model::integrate::Settings { max_steps: 10, ..settings(1e-8, 1.0) };
    let run_few = run(&mut Smooth(ORBIT), &start, few, 100.0);
    assert_eq!(run_few.stopped, Stopped::StepBudget);
    assert_eq!(run_few.counters.steps + run_few.counters.rejected_steps, 10);
    assert!(run_few.t > 0.0 && run_few.t < 100.0);
    // The state is the one at the time reached.
    assert!(distance(&run_few.y, &ORBIT.solution(run_few.t)) < 1e-6);
    let no_time = decore_model::integrate::Settings { max_wall_time_s: 0.0, ..settings(1e-8, 1e-3) };
    let run_short = run(&mut Smooth(ORBIT), &start, no_time, 100.0);
    assert_eq!(run_short.stopped, Stopped::TimeBudget);
    // The clock is looked at now and then only.
    assert!(run_short.counters.steps < 1000);
}

/// A solution that explodes at t = 1 and one that leaves its model's validity at t = 0.6: both end as diverged, in the
/// system's own words, at that time.
#[test]
fn analytic_divergence_is_diagnosed() {
    let explosion = run(&mut Smooth(Explosion), &[1.0], settings(1e-6, 1.0), 2.0);
    assert!(matches!(&explosion.stopped, Stopped::Diverged(words) if words.starts_with("the step size fell below")));
    println!("explosion ends at {}", explosion.t);
    assert_close("explosion", explosion.t, 1.0, 1e-5);
    let cliff = run(&mut Smooth(Cliff { limit: 0.6 }), &[0.0], settings(1e-6, 1.0), 2.0);
    assert!(matches!(cliff.stopped, Stopped::Diverged(_)));
    // Up to the last bits of the clock: a rejected step is retried with a fifth of its length.
    assert_close("cliff", cliff.t, 0.6, 2e-15);
    let nothing = run(&mut Smooth(ORBIT), &[f64::NAN; 4], settings(1e-6, 1.0), 2.0);
    assert!(matches!(nothing.stopped, Stopped::Diverged(_)));
    assert_eq!(nothing.t, 0.0);
}

/// A run in pieces goes on where it stopped: the same steps, the same end.
#[test]
fn a_run_can_be_continued() {
    use decore_model::integrate::{Integrator, Tsit5};
    let start = ORBIT.solution(0.0);
    let mut system = Smooth(ORBIT);
    let mut integrator = Integrator::<_, Tsit5>::new(&system, 0.0, &start, &settings(1e-9, 1.0));
    for piece in 1..=10 {
        assert_eq!(integrator.run(&mut system, &mut (), 0.2 * PI * f64::from(piece)), Stopped::AtEnd);
    }
    assert_eq!(integrator.time(), 2.0 * PI);
    assert!(distance(integrator.state(), &start) < 1e-7);
}

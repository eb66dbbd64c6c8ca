//! Impact laws against closed forms: restitution, accumulating bounces, periodic orbits and their stability.

use std::f64::consts::PI;

use crate::common::harness::{
    EventLog, Harness, assert_close, assert_relative, bisect, fixed_step, run, settings, slope,
};
use crate::common::impact::{Bouncer, ImpactOscillator, ReliefValve};
use decore_model::integrate::{Integrator, Settings, Stopped, Tsit5};

/// A free body against a wall leaves with exactly its restitution; with none it stays there.
#[test]
fn analytic_restitution() {
    for e in [0.0, 0.25, 0.5, 0.75, 1.0] {
        let mut system = Harness::new(Bouncer::new(0.0, 0.7, e));
        let run = run(&mut system, &[0.0, 1.3], settings(1e-6, 0.4), 2.0);
        assert_eq!(run.stopped, Stopped::AtEnd);
        assert_eq!(run.events.len(), 1, "restitution {e}");
        // The velocity is constant before and after: rounding only.
        assert_close("out over in", -run.y[1] / 1.3, e, 1e-14);
        let hit = 0.7 / 1.3;
        // Located to 1e-11 of a step.
        assert_close("time of the hit", run.events[0].t, hit, 1e-11);
        assert_close("way back", 0.7 - run.y[0], e * 1.3 * (2.0 - hit), 3e-11);
    }
}

/// Accumulating bounces, up to the last one that the closed form still tells apart: the times of 60 bounces, of which
/// the last lies 1e-6 s before the limit.
#[test]
fn analytic_bouncing_ball() {
    let ball = Bouncer::new(9.81, 0.1, 0.8);
    assert_close("limit of all bounces", ball.last_bounce(), 1.28506, 1e-5);
    let end = ball.bounce(60) + 1e-8;
    let run = run(&mut Harness::new(ball), &[0.0, 0.0], settings(1e-6, 0.01), end);
    assert_eq!(run.stopped, Stopped::AtEnd);
    let errors: Vec<f64> = run.events.iter().zip(1..).map(|(event, n)| (event.t - ball.bounce(n)).abs()).collect();
    println!("{} bounces, {:?}", errors.len(), errors.iter().cloned().fold(0.0, f64::max));
    assert_eq!(errors.len(), 60);
    // A bounce is located to 1e-11 of a step of 0.01 s, and what it is off by changes all flights after it: 60 times
    // 1e-13 s / (1 - e) at most.
    assert!(errors.iter().all(|error| *error < 60.0 * 1e-13 / (1.0 - 0.8) * 2.0), "{errors:?}");
}

/// What happens beyond the limit: a step's interior fraction of 1e-3, from which a guard that has just switched is watched,
/// ends the accumulation. Flights shorter than that are no longer resolved one by one; the integrator goes on with one
/// bounce per thousandth of a step and never hangs: the budget of steps ends the run shortly after the limit.
#[test]
fn bounces_beyond_the_limit_end_with_the_budget() {
    let ball = Bouncer::new(9.81, 0.1, 0.8);
    let budget = Settings { max_steps: 2000, ..settings(1e-6, 0.01) };
    let run = run(&mut Harness::new(ball), &[0.0, 0.0], budget, 2.0);
    println!("{:?} at {} after {} events, x - stop = {:e}", run.stopped, run.t, run.events.len(), run.y[0] - 0.1);
    assert_eq!(run.stopped, Stopped::StepBudget);
    assert!(run.t > ball.last_bounce() - 1e-3 && run.t < 2.0);
    // It has not fallen through the floor.
    assert!(run.y[0] - 0.1 < 1e-4);
}

/// From a start off the orbit, 100 impacts lead to the published orbit. Bound: the tolerance per step adds up to less.
#[test]
fn analytic_impact_oscillator_reaches_its_stable_orbit() {
    let problem = ImpactOscillator { b: 1.0, w: 1.9, s: 0.0, r: 0.6 };
    let orbit = problem.orbit();
    assert_close("velocity", orbit.velocity, 3.079_985_18, 1e-8);
    assert_close("phase", orbit.phase, 1.008_785_74, 1e-8);
    assert!(orbit.trace.abs() < 1.0 + problem.r * problem.r, "the closed form calls it stable");
    let period = 2.0 * PI / problem.w;
    let mut system = Harness::new(problem);
    // Half a period after an impact of the orbit, but too slow by a tenth.
    let run = run(&mut system, &[-1e-3, -0.9 * problem.r * orbit.velocity], settings(1e-10, 0.5), 100.0 * period);
    assert_eq!(run.stopped, Stopped::AtEnd);
    let last = run.events.last().expect("impacts");
    let before = -last.y[1] / problem.r;
    let phase = (problem.w * last.t).rem_euclid(2.0 * PI);
    println!("velocity {before}, phase {phase}, {} impacts", run.events.len());
    assert_close("velocity", before, orbit.velocity, 1e-7);
    assert_close("phase", phase, orbit.phase, 1e-7);
}

/// On the unstable orbit a perturbation grows by the eigenvalue of the linearised return map at every impact, until the
/// motion has left the orbit. 1 %: what the second order adds at deviations up to 1e-3.
///
/// At w = 2.6 the orbit (V = 0.50544) is stable, against a table that has the sign of the acceleration in the trace turned
/// round; the run there confirms it.
#[test]
fn analytic_impact_oscillator_leaves_its_unstable_orbit() {
    let problem = ImpactOscillator { b: 1.0, w: 2.8, s: 0.0, r: 0.8 };
    let orbit = problem.orbit();
    let (trace, determinant) = (orbit.trace, problem.r * problem.r);
    assert!(trace.abs() > 1.0 + determinant, "the closed form calls it unstable");
    let eigenvalue = 0.5 * (trace.abs() + (trace * trace - 4.0 * determinant).sqrt());
    let deviations = deviations(problem, 1e-8, 60);
    println!("eigenvalue {eigenvalue}, deviations {:?}", &deviations[..20.min(deviations.len())]);
    let linear: Vec<(f64, f64)> = deviations
        .iter()
        .zip(1..)
        .skip(3)
        .take_while(|(deviation, _)| **deviation < 1e-3)
        .map(|(deviation, n)| (f64::from(n).exp(), *deviation))
        .collect();
    assert!(linear.len() >= 5, "{deviations:?}");
    assert_relative("growth per impact", slope(&linear).exp(), eigenvalue, 0.01);
    assert!(deviations.iter().any(|deviation| *deviation > 0.05), "it never left");
    let stable = ImpactOscillator { w: 2.6, ..problem };
    assert_close("velocity", stable.orbit().velocity, 0.505_44, 1e-5);
    assert!(stable.orbit().trace.abs() < 1.0 + determinant);
    // Contracts by r per impact: 0.8^60 = 1.5e-6 of the start, 1e-6.
    let contracted = self::deviations(stable, 1e-6, 60);
    assert!(contracted.iter().skip(50).all(|deviation| *deviation < 1e-10), "{contracted:?}");
}

/// Deviations of the impact velocity from the orbit's, impact after impact, from one that is `perturbation` too fast.
fn deviations(problem: ImpactOscillator, perturbation: f64, periods: u32) -> Vec<f64> {
    let orbit = problem.orbit();
    // Starts at an impact of the orbit: the forcing's clock is set to it.
    let start = orbit.phase.rem_euclid(2.0 * PI) / problem.w;
    let end = start + f64::from(periods) * 2.0 * PI / problem.w;
    let mut system = Harness::new(problem);
    let y0 = [-1e-16, -problem.r * (orbit.velocity + perturbation)];
    let mut integrator = Integrator::<_, Tsit5>::new(&system, start, &y0, &settings(1e-12, 0.2));
    let mut log = EventLog::default();
    assert_eq!(integrator.run(&mut system, &mut log, end), Stopped::AtEnd);
    log.0.iter().map(|event| (-event.y[1] / problem.r - orbit.velocity).abs()).collect()
}

/// Flow through the valve high enough for its equilibrium to be stable: `(p - 10) sqrt(p) = q`, `x = p - 10`. Low flow:
/// it hammers on its seat, never through it.
#[test]
fn analytic_relief_valve() {
    let q = 10.0;
    let p = bisect(10.0, 20.0, |p| (p - 10.0) * p.sqrt() - q);
    let open = run(&mut Harness::new(ReliefValve { q }), &[p - 9.9, 0.0, p], settings(1e-9, 0.1), 200.0);
    assert_eq!(open.stopped, Stopped::AtEnd);
    println!("equilibrium {p}: {:?}, {} impacts", open.y, open.events.len());
    assert_close("lift", open.y[0], p - 10.0, 1e-8);
    assert_close("pressure", open.y[2], p, 1e-8);
    for q in [0.3, 2.0, 5.0] {
        let run = run(&mut Harness::new(ReliefValve { q }), &[0.5, 0.0, 10.5], settings(1e-8, 0.1), 60.0);
        assert_eq!(run.stopped, Stopped::AtEnd);
        println!("q {q}: {} impacts, {} steps", run.events.len(), run.counters.steps);
        assert!(run.events.len() > 10, "q {q}: {} impacts", run.events.len());
        // At an impact the seat is reached to the precision of its location and never passed.
        assert!(run.events.iter().all(|event| event.y[0].abs() < 1e-9 && event.y[1] >= 0.0));
        assert!(run.y[0] > -1e-9);
    }
}

/// Shortening the longest step changes neither the number of impacts nor, beyond the tolerance, the outcome.
#[test]
fn impacts_do_not_depend_on_the_longest_step() {
    let problem = ImpactOscillator { b: 1.0, w: 1.9, s: 0.0, r: 0.6 };
    let coarse = run(&mut Harness::new(problem), &[-0.1, 0.0], settings(1e-9, 10.0), 50.0);
    let fine = run(&mut Harness::new(problem), &[-0.1, 0.0], settings(1e-9, 0.01), 50.0);
    assert_eq!(coarse.events.len(), fine.events.len());
    assert_close("position", coarse.y[0], fine.y[0], 1e-6);
    // Error control off and steps of a tenth of a period: the method alone, still the same impacts.
    let crude = run(&mut Harness::new(problem), &[-0.1, 0.0], fixed_step(0.3), 50.0);
    assert_eq!(crude.events.len(), fine.events.len());
}

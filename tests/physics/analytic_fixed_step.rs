//! The methods at a fixed step: order, switching at the ends of steps or located, work, failure.

use crate::common::harness::{self, EventLog, Harness, Samples, Smooth, assert_close, slope};
use crate::common::impact::Bouncer;
use crate::common::smooth::{Cliff, Kepler, Manufactured, Oscillator, Polyline};
use decore_model::integrate::{
    Counters, FixedStep, Integrator, Observer, Rebasing, Rk4, Settings, Stepper, Stopped, System, Trapezoid,
};

fn settings(step_s: f64, located: bool) -> Settings {
    Settings { step_s, located, ..harness::settings(1e-6, 1.0) }
}

#[derive(Debug, Clone, Copy)]
enum Rule {
    Rk4,
    Trapezoid,
}

struct Run {
    stopped: Stopped,
    t: f64,
    y: Vec<f64>,
    counters: Counters,
}

fn run<S: Rebasing, O: Observer<S>>(rule: Rule, system: S, y0: &[f64], settings: Settings, at: (f64, &mut O)) -> Run {
    match rule {
        Rule::Rk4 => by::<FixedStep<Rk4>, S, O>(system, y0, settings, at),
        Rule::Trapezoid => by::<FixedStep<Trapezoid>, S, O>(system, y0, settings, at),
    }
}

fn by<P: Stepper<S>, S: Rebasing, O: Observer<S>>(
    mut system: S,
    y0: &[f64],
    settings: Settings,
    (end, observer): (f64, &mut O),
) -> Run {
    let mut integrator = Integrator::<_, P>::new(&system, 0.0, y0, &settings);
    let stopped = integrator.run(&mut system, observer, end);
    Run { stopped, t: integrator.time(), y: integrator.state().to_vec(), counters: integrator.counters() }
}

const RULES: [(Rule, f64); 2] = [(Rule::Rk4, 4.0), (Rule::Trapezoid, 2.0)];

/// Observed orders on two nonlinear problems; steps whose errors are far from rounding.
#[test]
fn analytic_orders() {
    for (rule, order) in RULES {
        let steps = [0.04, 0.02, 0.01, 0.005];
        let error = |h: f64| {
            let found =
                run(rule, Smooth(Manufactured), &Manufactured.solution(0.0), settings(h, false), (2.0, &mut ()));
            assert_eq!((found.stopped, found.t), (Stopped::AtEnd, 2.0));
            crate::common::harness::distance(&found.y, &Manufactured.solution(2.0))
        };
        let observed = slope(&steps.map(|h| (h, error(h))));
        assert_close("order, manufactured", observed, order, 0.05);
        let kepler = Kepler { eccentricity: 0.3 };
        let error = |h: f64| {
            let found = run(rule, Smooth(kepler), &kepler.solution(0.0), settings(h, false), (3.0, &mut ()));
            crate::common::harness::distance(&found.y, &kepler.solution(3.0))
        };
        let observed = slope(&steps.map(|h| (h, error(h))));
        println!("{rule:?}: order {observed} on Kepler's problem");
        assert_close("order, Kepler", observed, order, 0.05);
    }
}

/// Between the ends the cubic interpolant is as good as the method up to order 4, quadratures included.
#[test]
fn analytic_interpolant() {
    // h^2 t / 12 = 4e-5 for the trapezoid.
    for (rule, bound) in [(Rule::Rk4, 1e-8), (Rule::Trapezoid, 5e-5)] {
        let mut samples = Samples::new(5);
        let problem = Oscillator { quadratures: 2, ..Oscillator::new(&[]) };
        let found = run(rule, Harness::new(problem), &[1.0, 0.0, 0.0, 0.0], settings(0.01, false), (5.0, &mut samples));
        assert_eq!(found.stopped, Stopped::AtEnd);
        for (t, y) in &samples.points {
            let expected = [t.cos(), -t.sin(), 0.5 * (t + t.sin() * t.cos()), 0.25 * (t - t.sin() * t.cos())];
            for (found, expected) in y.iter().zip(expected) {
                assert_close("dense output", *found, expected, bound);
            }
        }
    }
}

/// A linear problem needs one matrix for the whole run, a stiff one is no trouble at a step of fifty time constants.
#[test]
fn analytic_trapezoid_keeps_its_matrix() {
    struct Stiff;
    impl System for Stiff {
        fn dimension(&self) -> usize {
            2
        }
        fn scales(&self) -> &[f64] {
            &[1.0; 2]
        }
        fn rhs(&mut self, t: f64, y: &[f64], rate: &mut [f64]) {
            rate.copy_from_slice(&[-5000.0 * (y[0] - t.cos()), y[0] - y[1]]);
        }
    }
    let found = run(Rule::Trapezoid, Smooth(Stiff), &[1.0, 0.0], settings(0.01, false), (10.0, &mut ()));
    assert_eq!((found.stopped, found.counters.factorisations), (Stopped::AtEnd, 1));
    assert_eq!(found.counters.steps, 1000);
    // Its own motion has died out long ago: y[0] = cos t + sin t / 5000.
    let t = 10.0_f64;
    assert_close("stiff component", found.y[0], t.cos() + t.sin() / 5000.0, 1e-6);
    let explicit = run(Rule::Rk4, Smooth(Stiff), &[1.0, 0.0], settings(0.01, false), (10.0, &mut ()));
    assert!(matches!(explicit.stopped, Stopped::Diverged(_)), "{:?}", explicit.stopped);
    assert_eq!(explicit.counters.factorisations, 0);
}

/// Not located, a bounce is late by up to a step and the error is of first order; located, it is the method's own.
#[test]
fn analytic_switches_at_the_ends_of_steps_or_located() {
    for (rule, _) in RULES {
        let bounce = |h: f64, located: bool| {
            let mut log = EventLog::default();
            let ball = Bouncer::new(9.81, 0.1, 0.8);
            let found = run(rule, Harness::new(ball), &[0.0, 0.0], settings(h, located), (0.2, &mut log));
            assert_eq!(found.stopped, Stopped::AtEnd);
            assert_eq!(log.0.len(), 1, "{rule:?} at {h}, located: {located}");
            (log.0[0].t - ball.bounce(1), found.y[0])
        };
        for h in [1e-2, 1e-3, 1e-4] {
            let (late, _) = bounce(h, false);
            assert!(late > 0.0 && late <= h, "{rule:?}: {late} at {h}");
            // The flight is a parabola, which both rules and the interpolant follow exactly.
            let (late, _) = bounce(h, true);
            assert!(late.abs() < 1e-10 * h.max(1e-3), "{rule:?}: {late:e} at {h}");
        }
    }
}

/// Scheduled stops are passed at the next step's start, or exactly where they are.
#[test]
fn analytic_stops() {
    for (rule, _) in RULES {
        for (stops, located, bound) in [
            // On the grid: exact either way, up to the rounding of its times.
            (vec![0.2, 0.5, 0.5], false, 1e-12),
            (vec![0.2, 0.5, 0.5], true, 1e-12),
            // Off it: each kink is late by 0.003 of a slope of 1 to 2.
            (vec![0.207, 0.517], true, 1e-12),
            (vec![0.207, 0.517], false, 0.01),
        ] {
            let problem = Polyline::new(&stops, 2.0);
            let expected = problem.solution(1.0);
            let found = run(rule, Harness::new(problem), &[0.0], settings(0.01, located), (1.0, &mut ()));
            assert_eq!((found.stopped, found.t), (Stopped::AtEnd, 1.0));
            let error = (found.y[0] - expected).abs();
            assert!(error <= bound, "{stops:?}, located {located}: off by {error}");
            assert!(located || stops[0] == 0.2 || error > 1e-3, "late stops must show");
        }
    }
}

/// No state beyond a cliff, no hang: the run ends with a reason; so it does at its budget.
#[test]
fn failures_end_with_a_reason() {
    for (rule, _) in RULES {
        let found = run(rule, Smooth(Cliff { limit: 0.5 }), &[0.0], settings(0.01, false), (1.0, &mut ()));
        assert!(matches!(found.stopped, Stopped::Diverged(_)), "{:?}", found.stopped);
        assert!((found.t - 0.5).abs() < 0.02 && found.y[0].is_finite());
        let budget = Settings { max_steps: 17, ..settings(0.01, false) };
        let found = run(rule, Smooth(Manufactured), &[2.0, 3.0], budget, (1.0, &mut ()));
        assert_eq!((found.stopped, found.counters.steps), (Stopped::StepBudget, 17));
        let budget = Settings { max_wall_time_s: 0.0, ..settings(0.001, false) };
        let found = run(rule, Smooth(Manufactured), &[2.0, 3.0], budget, (10.0, &mut ()));
        assert_eq!(found.stopped, Stopped::TimeBudget);
    }
}

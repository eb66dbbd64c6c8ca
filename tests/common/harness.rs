//! Piecewise smooth problems as the integrator sees them, logs of a run, observed orders.

use decore_model::integrate::{
    Counters, GuardSample, Integrator, Observer, Rebasing, Settings, Step, Stepper, Stopped, Switching, System, Tsit5,
};
use decore_model::system::Coupled;

/// A piecewise smooth problem; what a problem does not need has a default.
pub trait Piecewise {
    /// Number of states under error control.
    fn states(&self) -> usize;

    /// Number of quadratures, which follow the states.
    fn quadratures(&self) -> usize {
        0
    }

    /// The right-hand side.
    fn rate(&self, t: f64, y: &[f64], rate: &mut [f64]);

    /// Number of guards; each may depend on the whole state.
    fn guards(&self) -> usize {
        0
    }

    /// Value of a guard.
    fn guard(&self, _guard: usize, _y: &[f64]) -> f64 {
        -1.0
    }

    /// Rate of a guard along the solution, for guards that may rise and fall within a step; `rate` is the state's.
    fn guard_rate(&self, _guard: usize, _rate: &[f64]) -> f64 {
        0.0
    }

    /// The switch.
    fn switch(&mut self, _guard: usize, _t: f64, _y: &mut [f64]) {}

    /// Times of the scheduled stops, in order.
    fn stops(&self) -> &[f64] {
        &[]
    }

    /// What happens at stop number `stop`.
    fn pass(&mut self, _stop: usize) {}
}

/// A [`Piecewise`] problem behind the integrator's trait, all scales 1.
pub struct Harness<P> {
    pub problem: P,
    scales: Vec<f64>,
    support: Vec<usize>,
    passed: usize,
}

impl<P: Piecewise> Harness<P> {
    pub fn new(problem: P) -> Self {
        let states = problem.states();
        Self { problem, scales: vec![1.0; states], support: (0..states).collect(), passed: 0 }
    }
}

impl<P: Piecewise> System for Harness<P> {
    fn dimension(&self) -> usize {
        self.problem.states() + self.problem.quadratures()
    }

    fn scales(&self) -> &[f64] {
        &self.scales
    }

    fn rhs(&mut self, t: f64, y: &[f64], rate: &mut [f64]) {
        self.problem.rate(t, y, rate);
    }
}

impl<P: Piecewise> Switching for Harness<P> {
    fn guard_count(&self) -> usize {
        self.problem.guards()
    }

    fn guard_support(&self, _guard: usize) -> &[usize] {
        &self.support
    }

    fn guard(&self, guard: usize, _t: f64, y: &[f64]) -> f64 {
        self.problem.guard(guard, y)
    }

    fn sample_guards(&mut self, _t: f64, y: &[f64], rate: &[f64], samples: &mut [GuardSample]) {
        for (guard, sample) in samples.iter_mut().enumerate() {
            let value = self.problem.guard(guard, y);
            *sample = GuardSample { value, smooth: value, smooth_rate: self.problem.guard_rate(guard, rate) };
        }
    }

    fn switch(&mut self, guard: usize, t: f64, y: &mut [f64]) {
        self.problem.switch(guard, t, y);
    }

    fn next_stop(&self) -> f64 {
        self.problem.stops().get(self.passed).copied().unwrap_or(f64::INFINITY)
    }

    fn pass_stop(&mut self) {
        self.problem.pass(self.passed);
        self.passed += 1;
    }
}

impl<P: Piecewise> Rebasing for Harness<P> {}

/// A smooth system: it never switches.
pub struct Smooth<S>(pub S);

impl<S: System> System for Smooth<S> {
    fn dimension(&self) -> usize {
        self.0.dimension()
    }

    fn scales(&self) -> &[f64] {
        self.0.scales()
    }

    fn rhs(&mut self, t: f64, y: &[f64], rate: &mut [f64]) {
        self.0.rhs(t, y, rate);
    }
}

impl<S: System> Switching for Smooth<S> {
    fn guard_count(&self) -> usize {
        0
    }

    fn guard_support(&self, _guard: usize) -> &[usize] {
        &[]
    }

    fn guard(&self, _guard: usize, _t: f64, _y: &[f64]) -> f64 {
        -1.0
    }

    fn sample_guards(&mut self, _t: f64, _y: &[f64], _rate: &[f64], _samples: &mut [GuardSample]) {}

    fn switch(&mut self, _guard: usize, _t: f64, _y: &mut [f64]) {}

    fn next_stop(&self) -> f64 {
        f64::INFINITY
    }

    fn pass_stop(&mut self) {}
}

impl<S: System> Rebasing for Smooth<S> {}

/// A system with the method that it is integrated by: the default one.
pub trait Solved: Rebasing + Sized {
    type Method: Stepper<Self>;
}

impl<P: Piecewise> Solved for Harness<P> {
    type Method = Tsit5;
}

impl<S: System> Solved for Smooth<S> {
    type Method = Tsit5;
}

impl Solved for Coupled {
    type Method = Tsit5;
}

/// A switch as it was seen: guard, time, state after the switch.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    pub guard: usize,
    pub t: f64,
    pub y: Vec<f64>,
}

/// Remembers every switch.
#[derive(Debug, Default)]
pub struct EventLog(pub Vec<Event>);

impl<S> Observer<S> for EventLog {
    fn step(&mut self, _system: &S, _step: &Step<'_>) {}

    fn event(&mut self, _system: &S, guard: usize, t: f64, y: &[f64]) {
        self.0.push(Event { guard, t, y: y.to_vec() });
    }
}

/// Reads the dense output at `parts` points of every accepted step: (time, state).
pub struct Samples {
    pub parts: usize,
    pub points: Vec<(f64, Vec<f64>)>,
}

impl Samples {
    pub fn new(parts: usize) -> Self {
        Self { parts, points: Vec::new() }
    }
}

impl<S: System> Observer<S> for Samples {
    fn step(&mut self, system: &S, step: &Step<'_>) {
        for part in 1..=self.parts {
            let theta = step.theta_end * part as f64 / self.parts as f64;
            let mut y = vec![0.0; system.dimension()];
            step.state(theta, &mut y);
            self.points.push((step.time(theta), y));
        }
    }

    fn event(&mut self, _system: &S, _guard: usize, _t: f64, _y: &[f64]) {}
}

/// Settings with budgets that no test reaches by accident.
pub fn settings(tolerance: f64, longest_step_s: f64) -> Settings {
    Settings {
        tolerance,
        first_step_s: longest_step_s.min(1e-3),
        longest_step_s,
        step_s: 1e-5,
        located: false,
        max_steps: 5_000_000,
        max_wall_time_s: 60.0,
    }
}

/// Settings under which every step has the length `h`: error control is switched off.
pub fn fixed_step(h: f64) -> Settings {
    Settings { first_step_s: h, ..settings(1e30, h) }
}

/// The end of a run.
#[derive(Debug, Clone)]
pub struct Run {
    pub stopped: Stopped,
    pub t: f64,
    pub y: Vec<f64>,
    pub counters: Counters,
    pub events: Vec<Event>,
}

/// Times of the only onset and the only release of a contact.
pub fn switches(run: &Run, contact: usize) -> [f64; 2] {
    assert_eq!(run.stopped, Stopped::AtEnd);
    let times: Vec<f64> = run.events.iter().filter(|event| event.guard == contact).map(|event| event.t).collect();
    assert_eq!(times.len(), 2, "one onset, one release: {times:?}");
    [times[0], times[1]]
}

/// Integrates from `(0, y0)` to `end`, with the log of its switches.
pub fn run<S: Solved>(system: &mut S, y0: &[f64], settings: Settings, end: f64) -> Run {
    observe(system, y0, settings, end, &mut ())
}

/// As [`run`], with an observer that sees the same.
pub fn observe<S: Solved, O: Observer<S>>(
    system: &mut S,
    y0: &[f64],
    settings: Settings,
    end: f64,
    observer: &mut O,
) -> Run {
    let mut integrator = Integrator::<_, S::Method>::new(system, 0.0, y0, &settings);
    let mut both = (EventLog::default(), Borrowed(observer));
    let stopped = integrator.run(system, &mut both, end);
    Run {
        stopped,
        t: integrator.time(),
        y: integrator.state().to_vec(),
        counters: integrator.counters(),
        events: both.0.0,
    }
}

struct Borrowed<'a, O>(&'a mut O);

impl<S, O: Observer<S>> Observer<S> for Borrowed<'_, O> {
    fn step(&mut self, system: &S, step: &Step<'_>) {
        self.0.step(system, step);
    }

    fn event(&mut self, system: &S, guard: usize, t: f64, y: &[f64]) {
        self.0.event(system, guard, t, y);
    }
}

/// Slope of `ln y` over `ln x` by least squares.
pub fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let mean = |f: fn(&(f64, f64)) -> f64| logs.iter().map(f).sum::<f64>() / n;
    let (mx, my) = (mean(|p| p.0), mean(|p| p.1));
    let (mut xy, mut xx) = (0.0, 0.0);
    for (x, y) in &logs {
        xy += (x - mx) * (y - my);
        xx += (x - mx) * (x - mx);
    }
    xy / xx
}

/// Largest absolute difference of two states.
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).fold(0.0, |largest, (a, b)| largest.max((a - b).abs()))
}

/// Asserts that two numbers agree to a relative (for numbers below 1: absolute) bound.
#[track_caller]
pub fn assert_close(what: &str, found: f64, expected: f64, bound: f64) {
    let error = (found - expected).abs() / expected.abs().max(1.0);
    assert!(error <= bound, "{what}: {found} instead of {expected}, off by {error:.2e}, allowed {bound:.1e}");
}

/// Asserts that two numbers agree to a relative bound.
#[track_caller]
pub fn assert_relative(what: &str, found: f64, expected: f64, bound: f64) {
    let error = (found / expected - 1.0).abs();
    assert!(error <= bound, "{what}: {found} instead of {expected}, off by {error:.2e}, allowed {bound:.1e}");
}

/// Root of `f` between `low` and `high`, where it changes its sign, by bisection.
pub fn bisect(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let sign = f(low).signum();
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if f(middle).signum() == sign { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

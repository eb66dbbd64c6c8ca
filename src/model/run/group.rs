//! Runs rows of one shape in the lanes of a vector.

use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Instant;

use super::job::RowJob;
use super::outcome::RowOutcome;
use super::row::{outcome, settings};
use crate::integrate::{End, Integrator, Method, Start, Stopped, Tsit5};
use crate::metrics::Recorder;
use crate::scene::Scene;
use crate::system::{CoupledLanes, CoupledModel, Shape, build_placed};
#[cfg(not(target_arch = "x86_64"))]
use decore_math::number::Four;
#[cfg(target_arch = "x86_64")]
use decore_math::number::{EightAvx, FourAvx};
use decore_math::number::{Number, Registers};

/// Number of further rows in which rows of the running shape are searched.
const LOOK_AHEAD: usize = 16;

/// Source of rows and destination of their outcomes.
pub trait JobSource {
    /// Returns the next row and its job. With `wait`, waits until a row may be started; otherwise also `None` if none may be started now.
    fn next(&mut self, wait: bool) -> Option<(u64, RowJob)>;

    /// A row has ended.
    fn ended(&mut self, row: u64, outcome: RowOutcome);

    /// A row has panicked, with this payload.
    fn panicked(&mut self, row: u64, payload: Box<dyn std::any::Any + Send>);
}

/// A row whose next simulation is ready to begin.
struct Ready {
    row: u64,
    job: RowJob,
    scene: Scene,
    model: Arc<CoupledModel>,
    shape: Shape,
    /// Time that it took to make it ready, s.
    wall_time_s: f64,
}

/// Runs all rows of a source, rows of one shape in lanes. The result of a row does not depend on the other rows.
pub fn run_jobs(source: &mut dyn JobSource) {
    run_jobs_in(Registers::widest(), source);
}

/// As [`run_jobs`], in other registers than the widest; in the widest if this processor does not have them.
pub fn run_jobs_in(registers: Registers, source: &mut dyn JobSource) {
    let registers = if registers.are_available() { registers } else { Registers::widest() };
    let mut waiting = VecDeque::new();
    while let Some(first) = waiting.pop_front().or_else(|| next_ready(source, true)) {
        while waiting.len() + 1 < registers.lanes() {
            let Some(ready) = next_ready(source, false) else { break };
            waiting.push_back(ready);
        }
        let others = waiting.iter().filter(|ready| ready.shape == first.shape).count();
        match registers.for_rows(others + 1) {
            #[cfg(target_arch = "x86_64")]
            Registers::Avx512 => Group::<EightAvx>::new(first, source, &mut waiting).run(),
            #[cfg(target_arch = "x86_64")]
            Registers::Avx2 => Group::<FourAvx>::new(first, source, &mut waiting).run(),
            #[cfg(target_arch = "x86_64")]
            Registers::Any => run_alone(source, first.row, first.job),
            #[cfg(not(target_arch = "x86_64"))]
            _ => Group::<Four>::new(first, source, &mut waiting).run(),
        }
    }
}

/// As [`run_jobs`], over numbers of one kind, which this processor must be able to compute with.
pub fn run_jobs_over<R: Number>(source: &mut dyn JobSource) {
    let mut waiting = VecDeque::new();
    while let Some(first) = waiting.pop_front().or_else(|| next_ready(source, true)) {
        Group::<R>::new(first, source, &mut waiting).run();
    }
}

/// Returns the next row of a source for lanes; runs all others on the way.
fn next_ready(source: &mut dyn JobSource, wait: bool) -> Option<Ready> {
    loop {
        let (row, job) = source.next(wait)?;
        if let Some(ready) = made_ready(source, row, job) {
            return Some(ready);
        }
    }
}

/// Prepares a row's next simulation. Ends a row that has none, cannot be built, or uses another method.
fn made_ready(source: &mut dyn JobSource, row: u64, mut job: RowJob) -> Option<Ready> {
    let begin = Instant::now();
    while let Some(scene) = job.scene() {
        if scene.solver.method != Method::Tsit5 {
            run_alone(source, row, job);
            return None;
        }
        match catch_unwind(AssertUnwindSafe(|| build_placed(&scene, job.modes()))) {
            Ok(Ok(model)) => {
                let shape = Shape::of(&model);
                let wall_time_s = begin.elapsed().as_secs_f64();
                return Some(Ready { row, job, scene, model, shape, wall_time_s });
            }
            Ok(Err(error)) => job.take(RowOutcome::invalid(error.to_string())),
            Err(payload) => {
                source.panicked(row, payload);
                return None;
            }
        }
    }
    source.ended(row, job.outcome());
    None
}

/// Runs the rest of a row alone.
fn run_alone(source: &mut dyn JobSource, row: u64, job: RowJob) {
    match catch_unwind(AssertUnwindSafe(|| job.run())) {
        Ok(outcome) => source.ended(row, outcome),
        Err(payload) => source.panicked(row, payload),
    }
}

/// Rows of one shape that are being run.
struct Group<'g, R: Number> {
    shape: Shape,
    source: &'g mut dyn JobSource,
    /// Rows that are ready and not yet begun, of any shape.
    waiting: &'g mut VecDeque<Ready>,
    system: CoupledLanes<R>,
    integrator: Integrator<CoupledLanes<R>, Tsit5<R>, R>,
    rows: Vec<Option<Ready>>,
    recorders: Vec<Option<Recorder>>,
}

impl<'g, R: Number> Group<'g, R> {
    fn new(first: Ready, source: &'g mut dyn JobSource, waiting: &'g mut VecDeque<Ready>) -> Self {
        let system = CoupledLanes::new(&first.model);
        let mut group = Self {
            shape: first.shape.clone(),
            source,
            waiting,
            integrator: Integrator::idle(&system),
            system,
            rows: (0..R::LANES).map(|_| None).collect(),
            recorders: (0..R::LANES).map(|_| None).collect(),
        };
        group.begin(0, first);
        (1..R::LANES).for_each(|lane| group.refill(lane));
        group
    }

    /// Runs until all lanes are empty; a row without neighbours alone, which gives the same and is faster.
    fn run(mut self) {
        if self.rows.iter().flatten().count() == 1 {
            return self.run_each_alone();
        }
        loop {
            let (integrator, system, recorders) = (&mut self.integrator, &mut self.system, &mut self.recorders);
            match catch_unwind(AssertUnwindSafe(|| integrator.run_until_one_ends(system, recorders))) {
                Ok(Some((lane, stopped))) => self.ended(lane, stopped),
                Ok(None) => return,
                Err(_) => return self.run_each_alone(),
            }
        }
    }

    /// Begins a row's next simulation in a lane.
    fn begin(&mut self, lane: usize, ready: Ready) {
        self.system.load(lane, &ready.model);
        let start = Start { t0: 0.0, y0: ready.model.initial_state(), t_end: ready.scene.duration_s };
        self.integrator.load(&self.system, lane, &start, &settings(&ready.scene));
        self.recorders[lane] = Some(Recorder::new(&ready.model, &ready.scene));
        self.rows[lane] = Some(ready);
    }

    /// Begins another row in a lane, if there is one of the shape.
    fn refill(&mut self, lane: usize) {
        let mut next = self.waiting.iter().position(|ready| ready.shape == self.shape);
        while next.is_none() && self.waiting.len() < LOOK_AHEAD {
            let Some(ready) = next_ready(self.source, false) else { break };
            next = (ready.shape == self.shape).then_some(self.waiting.len());
            self.waiting.push_back(ready);
        }
        if let Some(ready) = next.and_then(|at| self.waiting.remove(at)) {
            self.begin(lane, ready);
        }
    }

    /// The simulation in a lane has ended: the lane continues with the row's next simulation, or with another row.
    fn ended(&mut self, lane: usize, stopped: Stopped) {
        let (Some(mut ready), Some(recorder)) = (self.rows[lane].take(), self.recorders[lane].take()) else { return };
        let mut y = ready.model.initial_state().to_vec();
        let (t, counters, wall_time_s) = self.integrator.reached(lane, &mut y);
        let end = End { stopped, t, y, counters };
        let system = self.system.lane(lane);
        match catch_unwind(AssertUnwindSafe(|| outcome(&ready.scene, system, recorder, end))) {
            Ok(mut outcome) => {
                outcome.wall_time_s = ready.wall_time_s + wall_time_s;
                ready.job.take(outcome);
                match made_ready(self.source, ready.row, ready.job) {
                    Some(ready) if ready.shape == self.shape => self.begin(lane, ready),
                    // A numerical twin has another shape: it waits for its group.
                    Some(ready) => self.waiting.push_back(ready),
                    None => {}
                }
            }
            Err(payload) => self.source.panicked(ready.row, payload),
        }
        // Lanes may also be empty because no row could be started when another one ended.
        for lane in 0..R::LANES {
            if self.rows[lane].is_none() {
                self.refill(lane);
            }
        }
    }

    /// One of the rows has panicked: each is run alone, which gives the same, and only that one panics again.
    fn run_each_alone(self) {
        for ready in self.rows.into_iter().flatten() {
            run_alone(self.source, ready.row, ready.job);
        }
    }
}

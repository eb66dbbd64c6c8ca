//! Which events must be located: contacts whose onsets or releases are hidden from location, one kind at a time.
//!
//! A hidden contact's force follows the state at every stage, as a plain program has it, and error control alone deals with
//! its switches. Its events are still booked at the right instant on the dense output: what is measured is the integration.

use std::cell::Cell;
use std::fmt::Write as _;

use decore::integrate::{
    Counters, GuardSample, Integrator, Observer, Settings, Step, Stopped, Switching, System, Tsit5,
};
use decore::metrics::Recorder;
use decore::scene::{Guide, Scene, SolverSettings};
use decore::system::{ContactKind, Coupled, build};

use crate::methods::cells;
use crate::scene::{FIGURES, Rig, errors, figures};

/// Tolerance of the runs.
const TOLERANCE: f64 = 1e-5;
/// Halvings by which an event is placed on the dense output.
const HALVINGS: usize = 40;

/// A system with events hidden from location.
struct Hidden {
    inner: Coupled,
    /// Whether a contact's onset is hidden, and its release.
    hidden: Vec<[bool; 2]>,
    /// Time of the last samples: the end of the step.
    sampled_s: Cell<f64>,
}

impl Hidden {
    /// Whether the next switch of a contact is hidden. The first blow on the casting starts the gate's clock: it is located.
    fn is_hidden(&self, contact: usize) -> bool {
        let strike = self.inner.model().elements().contacts()[contact].kind == ContactKind::ChiselCasting;
        let waiting = strike && self.inner.next_stop().is_infinite() && !self.inner.gate_open(0);
        self.hidden[contact][usize::from(self.inner.is_closed(contact))] && !waiting
    }
}

impl System for Hidden {
    fn dimension(&self) -> usize {
        self.inner.dimension()
    }

    fn scales(&self) -> &[f64] {
        self.inner.scales()
    }

    fn rhs(&mut self, t: f64, y: &[f64], rate: &mut [f64]) {
        let mut state = y.to_vec();
        let due = |system: &Self, contact: usize| system.is_hidden(contact) && system.inner.guard(contact, t, y) > 0.0;
        let due: Vec<usize> = (0..self.hidden.len()).filter(|&contact| due(self, contact)).collect();
        due.iter().for_each(|&contact| self.inner.switch(contact, t, &mut state));
        self.inner.rhs(t, y, rate);
        due.iter().for_each(|&contact| self.inner.switch(contact, t, &mut state));
    }

    fn diagnose(&self, t: f64, y: &[f64]) -> String {
        self.inner.diagnose(t, y)
    }
}

impl Switching for Hidden {
    fn guard_count(&self) -> usize {
        self.inner.guard_count()
    }

    fn guard_support(&self, guard: usize) -> &[usize] {
        self.inner.guard_support(guard)
    }

    fn guard(&self, guard: usize, t: f64, y: &[f64]) -> f64 {
        // Within a step nothing is to be seen of it: it is switched at the end.
        if self.is_hidden(guard) && t < self.sampled_s.get() { -1.0 } else { self.inner.guard(guard, t, y) }
    }

    fn sample_guards(&mut self, t: f64, y: &[f64], rate: &[f64], samples: &mut [GuardSample]) {
        self.sampled_s.set(t);
        self.inner.sample_guards(t, y, rate, samples);
        for (guard, sample) in samples.iter_mut().enumerate() {
            if self.is_hidden(guard) {
                (sample.smooth, sample.smooth_rate) = (-1.0, 0.0);
            }
        }
    }

    fn horizon(&self) -> f64 {
        self.inner.horizon()
    }

    fn rebase(&mut self, t: f64, y: &mut [f64], rate: &mut [f64]) {
        self.inner.rebase(t, y, rate);
    }

    fn switch(&mut self, guard: usize, t: f64, y: &mut [f64]) {
        self.inner.switch(guard, t, y);
    }

    fn next_stop(&self) -> f64 {
        self.inner.next_stop()
    }

    fn pass_stop(&mut self) {
        self.inner.pass_stop();
    }
}

/// The recorder of the outputs; hidden events are placed on the dense output of the step that passed over them.
struct Book {
    recorder: Recorder,
    state: Vec<f64>,
    /// Hidden events of the last step.
    booked: Vec<usize>,
}

impl Observer<Hidden> for Book {
    fn step(&mut self, system: &Hidden, step: &Step<'_>) {
        self.recorder.step(&system.inner, step);
        self.booked.clear();
        let mut end = vec![0.0; step.dimension()];
        step.write_end(&mut end);
        for guard in (0..system.hidden.len()).filter(|&guard| system.is_hidden(guard)) {
            if system.inner.guard(guard, step.t1(), &end) <= 0.0 {
                continue;
            }
            let (mut low, mut high) = (0.0, step.theta_end);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                step.state(middle, &mut self.state);
                let value = system.inner.guard(guard, step.time(middle), &self.state);
                if value > 0.0 {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            step.state(high, &mut self.state);
            let mut after = system.inner.clone();
            after.switch(guard, step.time(high), &mut self.state);
            self.recorder.event(&after, guard, step.time(high), &self.state);
            self.booked.push(guard);
        }
    }

    fn event(&mut self, system: &Hidden, guard: usize, t: f64, y: &[f64]) {
        if !self.booked.contains(&guard) {
            self.recorder.event(&system.inner, guard, t, y);
        }
    }
}

/// A choice of hidden events.
struct Case {
    name: &'static str,
    kinds: &'static [ContactKind],
    onsets: bool,
    releases: bool,
}

const ALL: [ContactKind; 9] = [
    ContactKind::TopStop,
    ContactKind::EndStop,
    ContactKind::RearWall,
    ContactKind::PistonChisel,
    ContactKind::Nose,
    ContactKind::Retainer,
    ContactKind::SpoolRear,
    ContactKind::SpoolFront,
    ContactKind::ChiselCasting,
];

fn cases() -> Vec<Case> {
    let groups: [(&'static str, &'static [ContactKind]); 6] = [
        ("piston on chisel", &[ContactKind::PistonChisel]),
        ("chisel on nose", &[ContactKind::Nose]),
        ("chisel on casting", &[ContactKind::ChiselCasting]),
        ("spool on its stops", &[ContactKind::SpoolRear, ContactKind::SpoolFront]),
        (
            "others (retainer, walls, telescope)",
            &[ContactKind::TopStop, ContactKind::EndStop, ContactKind::RearWall, ContactKind::Retainer],
        ),
        ("all", &ALL),
    ];
    let mut cases = vec![Case { name: "none", kinds: &[], onsets: false, releases: false }];
    for (name, kinds) in groups {
        cases.push(Case { name, kinds, onsets: true, releases: false });
        cases.push(Case { name, kinds, onsets: false, releases: true });
    }
    cases.push(Case { name: "all", kinds: &ALL, onsets: true, releases: true });
    cases
}

/// Integrates a scene with events hidden; its figures and the work.
fn run(scene: &Scene, rig: &Rig, case: &Case) -> ([f64; 4], Counters) {
    let model = build(scene, &rig.modes).expect("the rig");
    let contacts = model.elements().contacts();
    let hidden = contacts.iter().map(|contact| {
        let chosen = case.kinds.contains(&contact.kind);
        [chosen && case.onsets, chosen && case.releases]
    });
    let mut system =
        Hidden { inner: Coupled::new(&model), hidden: hidden.collect(), sampled_s: Cell::new(f64::NEG_INFINITY) };
    let settings = Settings {
        tolerance: TOLERANCE,
        first_step_s: 1e-6,
        longest_step_s: 1e-3,
        step_s: scene.solver.step_s,
        located: true,
        max_steps: scene.solver.max_steps,
        max_wall_time_s: scene.solver.max_wall_time_s,
    };
    let y0 = model.initial_state();
    let mut book = Book { recorder: Recorder::new(&model, scene), state: y0.to_vec(), booked: Vec::new() };
    let mut integrator = Integrator::<_, Tsit5>::new(&system, 0.0, y0, &settings);
    if integrator.run(&mut system, &mut book, scene.duration_s) != Stopped::AtEnd {
        return ([f64::NAN; 4], integrator.counters());
    }
    let metrics = book.recorder.finish(&system.inner, integrator.time(), integrator.state());
    (figures(&metrics), integrator.counters())
}

/// The table: the tied rig at [`TOLERANCE`], against the same run at a thousandth of it.
pub fn text(text: &mut String, rig: &Rig) {
    let solver = |tolerance| SolverSettings { tolerance, guide: Guide::Tied, ..rig.scene.solver };
    let scene = |tolerance| Scene { solver: solver(tolerance), ..rig.scene.clone() };
    let exact = crate::methods::run(rig, solver(1e-3 * TOLERANCE));
    let exact = figures(exact.metrics.as_ref().expect("the reference run"));
    let scene = scene(TOLERANCE);
    let _ = writeln!(
        text,
        "\n## Which events must be located\n\nGuide tied, tolerance {TOLERANCE:.0e}, against the same at {:.0e}; a contact that is not located follows the state at every stage, and \
         error control alone finds its switches.\nThe others are located. Ports, flows and friction are never located, supplies and \
         gates are scheduled stops: the first row is\nwhat error control leaves there.\n\n| not located | switches | steps | rejected | {} |\n|---|---|---|---|---|---|---|---|",
        1e-3 * TOLERANCE,
        FIGURES.join(" | ")
    );
    for case in cases() {
        let (found, work) = run(&scene, rig, &case);
        let switches = match (case.onsets, case.releases) {
            (true, true) => "both",
            (true, false) => "onsets",
            (false, true) => "releases",
            (false, false) => "",
        };
        let _ = writeln!(
            text,
            "| {} | {switches} | {} | {} | {} |",
            case.name,
            work.steps,
            work.rejected_steps,
            cells(&errors(&found, &exact))
        );
    }
}

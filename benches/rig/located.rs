//! Which events must be located: contacts whose onsets or releases are hidden from location, one kind at a time.
//!
//! A hidden contact's force follows the state at every stage, as a plain program has it, and error control alone deals with
//! its switches. Its events are still booked at the right instant on the dense output: what is measured is the integration.

use std::fmt::Write as _;

use decore_model::integrate::{
    Counters, GuardSample, Integrator, Observer, Settings, Step, Stopped, Switching, System, Tsit5,
};
use decore_model::metrics::Recorder;
use decore_model::scene::{Guide, HammerLink, Owner, Scene, SolverSettings};
use decore_model::system::{Coupled, build};

use crate::changed::{Change, Changed, settings};
use crate::methods::cells;
use crate::scene::{FIGURES, Rig, errors, figures};

/// Tolerance of the runs.
const TOLERANCE: f64 = 1e-5;
/// Halvings by which an event is placed on the dense output.
const HALVINGS: usize = 40;

/// Events hidden from location.
struct Hiding {
    /// Whether a contact's onset is hidden, and its release.
    hidden: Vec<[bool; 2]>,
    /// Time of the last samples: the end of the step.
    sampled_s: f64,
}

/// A system with events hidden from location.
type Hidden = Changed<Hiding>;

impl Hiding {
    /// Whether the next switch of a contact is hidden. The first blow on the casting starts the gate's clock: it is located.
    fn hides(&self, inner: &Coupled, contact: usize) -> bool {
        let strike = inner.model().hammers()[0].strike;
        let waiting = contact == strike && inner.next_stop().is_infinite() && !inner.gate_open(0);
        self.hidden[contact][usize::from(inner.is_closed(contact))] && !waiting
    }

    /// The contacts whose next switch is hidden.
    fn contacts(&self, inner: &Coupled) -> impl Iterator<Item = usize> {
        (0..self.hidden.len()).filter(|&contact| self.hides(inner, contact))
    }
}

impl Change for Hiding {
    fn rhs(&self, inner: &mut Coupled, (t, y): (f64, &[f64]), rate: &mut [f64]) {
        let mut state = y.to_vec();
        let due: Vec<usize> = self.contacts(inner).filter(|&contact| inner.guard(contact, t, y) > 0.0).collect();
        due.iter().for_each(|&contact| inner.switch(contact, t, &mut state));
        inner.rhs(t, y, rate);
        due.iter().for_each(|&contact| inner.switch(contact, t, &mut state));
    }

    fn guard(&self, inner: &Coupled, guard: usize, (t, y): (f64, &[f64])) -> f64 {
        // Within a step nothing is to be seen of it: it is switched at the end.
        if self.hides(inner, guard) && t < self.sampled_s { -1.0 } else { inner.guard(guard, t, y) }
    }

    fn change_samples(&mut self, inner: &Coupled, t: f64, samples: &mut [GuardSample]) {
        self.sampled_s = t;
        for (guard, sample) in samples.iter_mut().enumerate() {
            if self.hides(inner, guard) {
                (sample.smooth, sample.smooth_rate) = (-1.0, 0.0);
            }
        }
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
        for guard in system.change.contacts(&system.inner) {
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
    kinds: &'static [HammerLink],
    onsets: bool,
    releases: bool,
}

const ALL: [HammerLink; 9] = [
    HammerLink::TopStop,
    HammerLink::EndStop,
    HammerLink::RearWall,
    HammerLink::PistonChisel,
    HammerLink::Nose,
    HammerLink::Retainer,
    HammerLink::SpoolRear,
    HammerLink::SpoolFront,
    HammerLink::ChiselCasting,
];

fn cases() -> Vec<Case> {
    let groups: [(&'static str, &'static [HammerLink]); 6] = [
        ("piston on chisel", &[HammerLink::PistonChisel]),
        ("chisel on nose", &[HammerLink::Nose]),
        ("chisel on casting", &[HammerLink::ChiselCasting]),
        ("spool on its stops", &[HammerLink::SpoolRear, HammerLink::SpoolFront]),
        (
            "others (retainer, walls, telescope)",
            &[HammerLink::TopStop, HammerLink::EndStop, HammerLink::RearWall, HammerLink::Retainer],
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
        let chosen = matches!(contact.owner, Owner::Hammer { link, .. } if case.kinds.contains(&link));
        [chosen && case.onsets, chosen && case.releases]
    });
    let change = Hiding { hidden: hidden.collect(), sampled_s: f64::NEG_INFINITY };
    let mut system = Hidden { inner: Coupled::new(&model), change };
    let settings = Settings {
        step_s: scene.solver.step_s,
        located: true,
        max_steps: scene.solver.max_steps,
        max_wall_time_s: scene.solver.max_wall_time_s,
        ..settings(TOLERANCE)
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

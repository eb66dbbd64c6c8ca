//! The audits can fail: an error planted in any part of the books moves a residual, each by itself.

use crate::common::changed::{Change, Changed, settings};
use crate::common::studies::scene;
use decore_model::hammer::chamber;
use decore_model::integrate::{Integrator, Observer, Step, Stopped, System, Tsit5};
use decore_model::metrics::{Recorder, RunTotals};
use decore_model::system::{Coupled, CoupledModel, build};
use std::sync::Arc;

/// What is wrong with a system.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Plant {
    Nothing,
    /// The rate of a chamber's pressure, by a share.
    Pressure(usize, f64),
    /// A drag on a body that no book knows: its acceleration falls by this rate in 1/s times its velocity.
    Drag(usize, f64),
    /// The structure: condensed, the forces that it feels, by a share; integrated, a drag on its modes of 100/s times the share.
    Structure(f64),
    /// The power that friction, dampers and contacts dissipate, by a share.
    Dissipation(f64),
    /// The power that gas and gravity put in, by a share.
    Input(f64),
}

impl Change for Plant {
    fn rhs(&self, inner: &mut Coupled, (t, y): (f64, &[f64]), rate: &mut [f64]) {
        inner.rhs(t, y, rate);
        let layout = inner.model().layout();
        let change = |at: usize, share: f64, rate: &mut [f64]| rate[at] *= 1.0 + share;
        match *self {
            Plant::Nothing => {}
            Plant::Pressure(index, share) => change(layout.pressures(0).start + index, share, rate),
            Plant::Drag(body, rate_per_s) => rate[layout.velocity(body)] -= rate_per_s * y[layout.velocity(body)],
            Plant::Structure(share) => {
                // The rates of the first integrals, two points; velocities exist where modes are integrated.
                if layout.flexible[1] == 0 {
                    (0..2).for_each(|at| change(at, share, rate));
                }
                layout.flexible_velocities().for_each(|at| rate[at] -= 100.0 * share * y[at]);
            }
            Plant::Dissipation(share) => change(layout.dissipated(), share, rate),
            Plant::Input(share) => change(layout.work_in(), share, rate),
        }
    }
}

type Planted = Changed<Plant>;

/// Shows a recorder the system within.
struct Through(Recorder);

impl Observer<Planted> for Through {
    fn step(&mut self, system: &Planted, step: &Step<'_>) {
        self.0.step(&system.inner, step);
    }
    fn event(&mut self, system: &Planted, guard: usize, t: f64, y: &[f64]) {
        self.0.event(&system.inner, guard, t, y);
    }
}

const DURATION_S: f64 = 0.25;

/// The audits of a run of `model` with an error planted; books kept by the model itself.
fn audits(model: &Arc<CoupledModel>, scene: &decore_model::scene::Scene, plant: Plant) -> RunTotals {
    let mut system = Planted { inner: Coupled::new(model), change: plant };
    let mut integrator = Integrator::<_, Tsit5>::new(&system, 0.0, model.initial_state(), &settings(1e-5));
    let mut observer = Through(Recorder::new(model, scene));
    assert_eq!(integrator.run(&mut system, &mut observer, DURATION_S), Stopped::AtEnd, "{plant:?}");
    observer.0.finish(&system.inner, integrator.time(), integrator.state()).totals
}

/// Modes condensed and integrated: sound books close to 1e-5, and an error of one per cent in any part opens them.
#[test]
fn an_error_in_any_part_moves_a_residual() {
    for treatment in ["condensed", "integrated"] {
        let (mut scene, modes) =
            scene("paper_rig.toml", 0, &["solver.guide=tied", &format!("solver.modes={treatment}")]).unwrap();
        scene.duration_s = DURATION_S;
        let model = build(&scene, &modes).unwrap();
        let sound = audits(&model, &scene, Plant::Nothing);
        println!("{treatment}: energy {:.1e}, chambers {:.1e}", sound.energy_residual, sound.chamber_residual);
        assert!(sound.energy_residual.abs() < 1e-5 && sound.chamber_residual < 1e-8, "{sound:?}");
        for index in 0..chamber::COUNT {
            let planted = audits(&model, &scene, Plant::Pressure(index, 0.01)).chamber_residual;
            println!("  chamber {index}: {planted:.1e}");
            assert!(planted > 1e-4, "chamber {index}: {planted:e}");
        }
        let others = [
            Plant::Drag(0, 1.0),
            Plant::Drag(2, 1.0),
            Plant::Drag(3, 1.0),
            Plant::Drag(4, 1.0),
            Plant::Structure(0.01),
            Plant::Dissipation(0.01),
            Plant::Input(0.01),
        ];
        for plant in others {
            let planted = audits(&model, &scene, plant).energy_residual.abs();
            println!("  {plant:?}: {planted:.1e}");
            assert!(planted > 10.0 * sound.energy_residual.abs(), "{plant:?}: {planted:e}");
        }
    }
}

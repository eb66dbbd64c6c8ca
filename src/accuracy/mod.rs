//! Speed and error of solver settings on one scene: the same run with many settings, compared with a converged reference.
//!
//! Three figures separate numerical errors from other differences. The reference runs at two tolerances, which gives its own error. The
//! scene's sensitivity is the change of the outputs between a run and its twins; no method can be judged below it. The third figure is
//! the truncation of modes.

mod measure;
mod outputs;
mod plot;
mod text;

use decore_model::integrate::Counters;
use decore_model::metrics::RunTotals;
use decore_model::run::RowStatus;
use decore_model::scene::{Guide, Method, ModeTreatment, PRESETS, Preset, Scene, SolverSettings};

pub use measure::{AccuracyError, Begun, Experiment, measure};
pub use outputs::{MAIN_OUTPUTS, Output, main_differences};
pub use plot::plot;
pub use text::text;

/// Tolerance of the reference run.
pub const REFERENCE_TOLERANCE: f64 = 1e-9;

/// A setting of the solver that is measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// Family of settings that differ in their tolerance or step only: a line of the plot.
    pub family: String,
    /// Preset that it is, if it is one.
    pub preset: Option<&'static str>,
    /// Method, guide, modes, tolerance and step; the budgets are the scene's.
    pub solver: SolverSettings,
}

impl Setting {
    /// Setting that varies within its family: the tolerance or the fixed step.
    pub fn grade(&self) -> String {
        let SolverSettings { tolerance, method, step_s, .. } = self.solver;
        if method.is_fixed() { format!("{} us", (1e6 * step_s).round()) } else { format!("{tolerance:.0e}") }
    }
}

/// The settings under error control: both models of the guide at tolerances from 1e-3 to 1e-8, each with modes as the scene
/// would have them and with modes integrated.
pub fn ladder(scene: &Scene) -> Vec<Setting> {
    let families = [
        ("guide on its spring", Guide::Spring, ModeTreatment::Automatic),
        ("guide tied", Guide::Tied, ModeTreatment::Automatic),
        ("guide on its spring, modes integrated", Guide::Spring, ModeTreatment::Integrated),
        ("guide tied, modes integrated", Guide::Tied, ModeTreatment::Integrated),
    ];
    let mut settings = Vec::new();
    for (family, guide, modes) in families {
        for tolerance in [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8] {
            let same =
                |preset: &&Preset| preset.tolerance == tolerance && scene.ties(preset.guide) == scene.ties(guide);
            let preset = PRESETS.iter().find(same).filter(|_| modes == ModeTreatment::Automatic);
            let solver = SolverSettings { tolerance, guide, modes, method: Method::Tsit5, ..scene.solver };
            settings.push(Setting {
                family: family.to_owned(),
                preset: preset.map(|preset| preset.fidelity.name()),
                solver,
            });
        }
    }
    settings
}

/// The methods at a fixed step, for comparison: the model as published (guide on its spring, modes integrated), contacts
/// noticed at the ends of steps unless located.
///
/// Without `slow`, leaves out the methods that take many times as long: the Runge-Kutta rule at 1 us and the implicit trapezoid.
pub fn fixed_steps(scene: &SolverSettings, slow: bool) -> Vec<Setting> {
    // Family, method, step, whether contacts are located, whether it is slow.
    let all = [
        ("rk4", Method::Rk4, 1e-5, false, false),
        ("rk4", Method::Rk4, 1e-6, false, true),
        ("rk4, contacts located", Method::Rk4, 1e-5, true, false),
        ("rk4, contacts located", Method::Rk4, 5e-6, true, false),
        ("implicit trapezoid", Method::Trapezoid, 1e-5, false, true),
    ];
    let mut settings = Vec::new();
    for (family, method, step_s, located, is_slow) in all {
        if slow || !is_slow {
            let (guide, modes) = (Guide::Spring, ModeTreatment::Integrated);
            let solver = SolverSettings { guide, modes, method, step_s, located, ..*scene };
            settings.push(Setting { family: family.to_owned(), preset: None, solver });
        }
    }
    settings
}

/// One setting's work and errors.
#[derive(Debug, Clone, PartialEq)]
pub struct Measurement {
    /// The setting.
    pub setting: Setting,
    /// Status of its run.
    pub status: RowStatus,
    /// Wall time of the fastest of its runs per simulated second, ms.
    pub ms_per_simulated_s: f64,
    /// Modes of the structure.
    pub modes: usize,
    /// States integrated.
    pub states: usize,
    /// Work done.
    pub counters: Counters,
    /// Outputs of the run as a whole; `None` unless it reached its end.
    pub totals: Option<RunTotals>,
    /// Relative error of each output, compared with the reference; NaN if neither has the output, infinite if one lacks it.
    pub errors: Vec<f64>,
}

/// Speed against error of one scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Accuracy {
    /// The outputs that errors are of.
    pub outputs: Vec<Output>,
    /// One entry per setting.
    pub measurements: Vec<Measurement>,
    /// Relative difference of each output between the reference and the same at ten times its tolerance.
    pub reference_error: Vec<f64>,
    /// Relative movement of each output from the reference to its twins, at the same tolerance.
    pub sensitivity: Vec<f64>,
    /// Relative error of each output by the modes left out, and the number of modes with none left out below the cut-off
    /// of the comparison; `None` without finite elements to take more modes from.
    pub truncation: Option<(usize, Vec<f64>)>,
}

impl Accuracy {
    /// Largest of `errors` over [`MAIN_OUTPUTS`] that the scene has.
    pub fn worst(&self, errors: &[f64]) -> f64 {
        let main = self.outputs.iter().zip(errors).filter(|(output, _)| MAIN_OUTPUTS.contains(&output.name));
        main.map(|(_, error)| *error).filter(|error| !error.is_nan()).fold(0.0, f64::max)
    }
}

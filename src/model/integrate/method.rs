//! Methods that a study can select, each with one entry.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::integrate::counters::Counters;
use crate::integrate::driver::Integrator;
use crate::integrate::explicit::Tsit5;
use crate::integrate::fixed::FixedStep;
use crate::integrate::lane::Stopped;
use crate::integrate::observer::Observer;
use crate::integrate::rk4::Rk4;
use crate::integrate::stepper::{Settings, Stepper};
use crate::integrate::system::Rebasing;
use crate::integrate::trapezoid::Trapezoid;

/// Declares the methods: documentation, name in a study, whether its steps have a fixed length and whether they are implicit, so
/// that no motion bounds them, stepper.
macro_rules! methods {
    ($($(#[$attribute:meta])* $method:ident($name:tt, fixed: $fixed:literal, implicit: $implicit:literal, $stepper:ty),)+) => {
        /// Method of integration.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
        pub enum Method {
            $($(#[$attribute])* #[serde(rename = $name)] $method,)+
        }

        impl Method {
            /// Name in a study.
            pub fn name(self) -> &'static str {
                match self { $(Self::$method => $name,)+ }
            }

            /// Whether steps have a fixed length; otherwise error control chooses it.
            pub fn is_fixed(self) -> bool {
                match self { $(Self::$method => $fixed,)+ }
            }

            /// Whether steps are implicit: stable, however fast a motion is.
            pub fn is_implicit(self) -> bool {
                match self { $(Self::$method => $implicit,)+ }
            }

            /// Integrates `system` from rest at time 0 over `span`; shows every step and switch to `observer`.
            pub fn integrate<S, O>(self, system: &mut S, observer: &mut O, settings: &Settings, span: &Span<'_>) -> End
            where
                S: Rebasing,
                O: Observer<S>,
            {
                match self { $(Self::$method => run::<$stepper, S, O>(system, observer, settings, span),)+ }
            }
        }
    };
}

methods! {
    /// Explicit Runge-Kutta pair of order 5(4) with error control and located contacts.
    #[default]
    Tsit5("tsit5", fixed: false, implicit: false, Tsit5),
    /// Classical Runge-Kutta rule of order 4 with a fixed step, for comparison.
    Rk4("rk4", fixed: true, implicit: false, FixedStep<Rk4>),
    /// Implicit trapezoid with a fixed step (as in the published program), for comparison.
    Trapezoid("trapezoid", fixed: true, implicit: true, FixedStep<Trapezoid>),
}

/// From where to where is integrated.
#[derive(Debug, Clone, Copy)]
pub struct Span<'a> {
    /// State at time 0.
    pub y0: &'a [f64],
    /// Time at the end in s.
    pub t_end: f64,
}

/// End of an integration: state and reason.
#[derive(Debug, Clone, PartialEq)]
pub struct End {
    /// Reason for the end.
    pub stopped: Stopped,
    /// Time reached in s.
    pub t: f64,
    /// State there.
    pub y: Vec<f64>,
    /// Work done.
    pub counters: Counters,
}

fn run<P, S, O>(system: &mut S, observer: &mut O, settings: &Settings, span: &Span<'_>) -> End
where
    P: Stepper<S>,
    S: Rebasing,
    O: Observer<S>,
{
    let mut integrator = Integrator::<_, P>::new(system, 0.0, span.y0, settings);
    let stopped = integrator.run(system, observer, span.t_end);
    End { stopped, t: integrator.time(), y: integrator.state().to_vec(), counters: integrator.counters() }
}

//! Time integration of piecewise smooth systems with located events. Independent of hammers.
//!
//! A [`Switching`] system is smooth between switches. Its guards are functions of the state that are negative while its
//! present discrete state is right; the [`Integrator`] locates the first upward zero of a guard on the method's own dense
//! output, ends the step there and lets the system switch. Times known beforehand (a valve that opens) are scheduled stops.
//! A method is a [`Stepper`]: it computes a step, all else is done once for all of them.
//!
//! - `system`: traits of systems, alone or in lanes
//! - `tsit5`: coefficients of the explicit pair
//! - `step`, `observer`: an accepted step with its dense output, and its observers
//! - `taken`: the steps of all lanes
//! - `stepper`: interface between driver and method
//! - `explicit`: the default method
//! - `fixed`, `rk4`, `trapezoid`: rules at a fixed step
//! - `locate`: events within a step
//! - `lane`, `blend`, `driver`: one lane, some lanes of a vector, and the step loop
//! - `method`: the methods by name

mod blend;
mod counters;
mod driver;
mod explicit;
mod fixed;
mod lane;
mod locate;
mod method;
mod observer;
mod rk4;
mod step;
mod stepper;
mod system;
mod taken;
mod trapezoid;
mod tsit5;

pub use counters::Counters;
pub use driver::Integrator;
pub(crate) use driver::Start;
pub use explicit::Tsit5;
pub use fixed::FixedStep;
pub use lane::Stopped;
pub(crate) use method::End;
pub use method::{Method, Span};
pub use observer::Observer;
pub use rk4::Rk4;
pub use step::{Dense, Step};
pub use stepper::{Settings, Stepper};
pub(crate) use system::InLanes;
pub use system::{GuardSample, Rebasing, Switching, System};
pub use taken::Taken;
pub use trapezoid::Trapezoid;

//! What hostile or careless files must not do: order a terminal about, take memory or time that nothing justifies, end in a panic.

mod bounds;
mod fuzz;
mod hosts;
mod links;
#[path = "../common/solid.rs"]
mod solid;
mod terminal;

//! The static equilibrium from which a run starts.
//!
//! Coordinates of the machine and the castings are measured from it: they start at 0. A fixture's force is measured from its share of the
//! weight and also starts at 0. Each hammer starts at its own state of rest: it hangs on its mount, its chisel off the casting.

use crate::system::model::CoupledModel;

/// Returns the state at rest.
pub(super) fn rest(model: &CoupledModel) -> Vec<f64> {
    let layout = &model.layout;
    let mut y = vec![0.0; layout.dimension()];
    for (h, slot) in model.hammers.iter().enumerate() {
        let rest = slot.model.rest();
        for (&column, position) in slot.points.iter().zip(rest.position) {
            if column < layout.bodies {
                y[layout.position(column)] = position;
            }
        }
        y[layout.pressures(h)].copy_from_slice(&rest.pressure);
    }
    y
}

//! The static equilibrium from which a run starts.
//!
//! Coordinates of the machine and of castings are counted from it: they are 0, and so are the forces of springs between them beyond those
//! that carry the weight. Hammers stand at the rest that each has by itself, their weight on their mounts, their chisels off the castings.

use crate::system::model::CoupledModel;

/// The state of rest.
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

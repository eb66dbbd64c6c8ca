//! The static equilibrium from which a run starts.
//!
//! Coordinates of the machine and the castings are measured from it: they start at 0. Forces of fixtures are measured from their forces at
//! rest. Those of one-sided fixtures have to be known, as they decide when a casting lifts off: they are solved for here. Each hammer
//! starts at its own state of rest: it hangs on its mount, its chisel off the casting.

use nalgebra::{DMatrix, DVector};

use super::BuildError;
use crate::direction::unit;
use crate::scene::{Link, LinkLaw, Location, Owner, Part, Scene};
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

/// Share of the largest load up to which a force is rounding.
const NO_LOAD: f64 = 1e-9;

/// Share of the largest load beyond which fixtures that ought to bear it do not.
const UNBORNE: f64 = 1e-6;

/// A fixture that carries a casting.
struct Carrier<'l> {
    link: &'l mut Link,
    /// Motion of its point by the freedoms of the casting.
    row: DVector<f64>,
    stiffness_n_per_m: f64,
    /// Whether it only pushes.
    one_sided: bool,
    /// Whether it holds by friction alone, which bears no load at rest.
    rubs: bool,
    /// Whether it takes part: a one-sided fixture from which the casting stands off does not.
    acts: bool,
}

/// Gives the contacts under a casting their shares of its weight and of the forces of its clamps; those from which it then stands off get
/// a gap. Machine and castings are rigid here: how an elastic casting shares its load between more than three pads depends on
/// the heights to which these are set.
///
/// Solves `K u = W` with `K = sum k b b'` over the fixtures that carry, `b` the row of the held point, until none pulls and none that was
/// left out is pressed: `F = k b u`.
///
/// # Errors
/// [`BuildError::NoRest`] if the casting tips off its fixtures, [`BuildError::Slides`] if only friction keeps it from sliding.
pub(super) fn share_loads(scene: &Scene, links: &mut [Link]) -> Result<(), BuildError> {
    for (index, casting) in scene.castings.iter().enumerate().filter(|(_, casting)| casting.lies()) {
        let part = scene.rigid_casting(index)?;
        let Part::Rigid(freedoms) = &part else { continue };
        let mut load = DVector::zeros(freedoms.len());
        let weight_n = casting.mass_kg * scene.environment.gravity_m_s2;
        let falls = part.row(&Location::Offset([0.0; 3]), unit(scene.environment.gravity_axis));
        falls.into_iter().for_each(|(freedom, share)| load[freedom] = weight_n * share);
        let mut carriers = Vec::new();
        for link in links.iter_mut() {
            let Owner::Fixture(fixture) = link.owner else { continue };
            if fixture.casting != index {
                continue;
            }
            let held = &casting.fixtures[fixture.fixture];
            let mut row = DVector::zeros(freedoms.len());
            let along = part.row(&Location::Offset(held.place_m()), held.axes()[fixture.axis]);
            along.into_iter().for_each(|(freedom, lever)| row[freedom] = lever);
            if fixture.axis == 0 && held.clamp_force_n > 0.0 {
                load.axpy(held.clamp_force_n, &row, 1.0);
            } else {
                let mut carrier = carrier(link, row);
                if fixture.axis > 0 && carrier.stiffness_n_per_m == 0.0 && held.friction > 0.0 {
                    (carrier.rubs, carrier.stiffness_n_per_m) = (true, held.spring()[0]);
                }
                carriers.push(carrier);
            }
        }
        let u = settle(&mut carriers, &load).ok_or_else(|| BuildError::NoRest { casting: casting.name.clone() })?;
        let borne = |carrier: &Carrier<'_>| {
            carrier.rubs && { (carrier.stiffness_n_per_m * carrier.row.dot(&u)).abs() > NO_LOAD * load.amax() }
        };
        if carriers.iter().any(borne) {
            return Err(BuildError::Slides { casting: casting.name.clone() });
        }
        for carrier in carriers {
            let depth_m = carrier.row.dot(&u);
            if let LinkLaw::Contact { gap_m, preload_n, .. } = &mut carrier.link.law {
                (*gap_m, *preload_n) =
                    if carrier.acts { (0.0, carrier.stiffness_n_per_m * depth_m) } else { (-depth_m, 0.0) };
            }
        }
    }
    Ok(())
}

/// Returns the link of a fixture as a carrier, which starts with all fixtures acting.
fn carrier(link: &mut Link, row: DVector<f64>) -> Carrier<'_> {
    let (stiffness_n_per_m, one_sided) = match link.law {
        LinkLaw::Spring { stiffness_n_per_m, .. } => (stiffness_n_per_m, false),
        LinkLaw::Contact { law, .. } => (law.closed_force(1.0, 0.0), true),
    };
    Carrier { link, row, stiffness_n_per_m, one_sided, rubs: false, acts: true }
}

/// Finds the fixtures that carry a load and returns how far they let the casting down; `None` if it tips off them.
fn settle(carriers: &mut [Carrier<'_>], load: &DVector<f64>) -> Option<DVector<f64>> {
    // In each round one fixture changes sides; a handful settles in fewer rounds than there are fixtures.
    for _ in 0..=4 * carriers.len() {
        let mut stiffness = DMatrix::zeros(load.len(), load.len());
        for carrier in carriers.iter().filter(|carrier| carrier.acts) {
            stiffness.ger(carrier.stiffness_n_per_m, &carrier.row, &carrier.row, 1.0);
        }
        let u = stiffness.clone().cholesky()?.solve(load);
        // Rounding can hide that nothing holds a motion: then the fixtures do not bear the load.
        if (&stiffness * &u - load).amax() > UNBORNE * load.amax() {
            return None;
        }
        let wrong = |carrier: &Carrier<'_>| {
            let depth_m = carrier.row.dot(&u);
            if !carrier.one_sided {
                0.0
            } else if carrier.acts {
                -depth_m
            } else {
                depth_m
            }
        };
        let worst = carriers.iter_mut().max_by(|a, b| wrong(a).total_cmp(&wrong(b)))?;
        if wrong(worst) <= 0.0 {
            return Some(u);
        }
        worst.acts = !worst.acts;
    }
    None
}

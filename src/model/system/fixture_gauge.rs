//! Powers of single fixtures at a state: loss in their dampers and by friction, and work on the machine.

use crate::scene::{FixtureId, Owner};
use crate::system::coupled::Coupled;
use crate::system::elements::{ElementId, Sliding, friction};
use crate::system::model::{Books, CoupledModel};

/// Power of a fixture, W.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FixturePower {
    /// Lost in its damper.
    pub loss_w: f64,
    /// Work per time on the machine.
    pub structure_w: f64,
    /// Speed with which the casting slides on it, m/s.
    pub slip_m_s: f64,
}

/// Element of a fixture.
#[derive(Debug, Clone, Copy)]
struct FixtureElement {
    /// Place of the fixture among those that are read.
    fixture: usize,
    element: ElementId,
    /// Column of the machine's point that carries it.
    support: usize,
}

/// Friction of a fixture.
#[derive(Debug, Clone, Copy)]
struct FixtureFriction {
    /// Place of the fixture among those that are read.
    fixture: usize,
    sliding: Sliding,
    /// Columns of the machine's point across the axis.
    supports: [usize; 2],
}

/// Reads the powers of chosen fixtures; holds the memory for it.
#[derive(Debug, Clone)]
pub struct FixtureGauge {
    elements: Vec<FixtureElement>,
    frictions: Vec<FixtureFriction>,
    /// Elongation in m and its rate in m/s of each spring.
    springs: Vec<[f64; 2]>,
    /// Force of each contact beyond that at rest, N.
    contacts: Vec<f64>,
    powers: Vec<FixturePower>,
}

impl FixtureGauge {
    /// Reads these fixtures.
    pub fn new(model: &CoupledModel, fixtures: &[FixtureId]) -> Self {
        let support = |id: FixtureId| match model.books(Owner::Fixture(id)) {
            Books::Fixture { support, .. } => Some(support),
            _ => None,
        };
        let (mut elements, mut frictions) = (Vec::new(), Vec::new());
        for (place, fixture) in fixtures.iter().enumerate() {
            let along = [0, 1, 2].map(|axis| FixtureId { axis, ..*fixture });
            for id in along {
                let Some(support) = support(id) else { continue };
                let own = model.elements().owned(|known| known == Owner::Fixture(id));
                elements.extend(own.map(|element| FixtureElement { fixture: place, element, support }));
            }
            let rubs =
                |sliding: &&Sliding| model.elements().contacts()[sliding.contact].owner == Owner::Fixture(*fixture);
            let supports = support(along[1]).zip(support(along[2]));
            let own = model.elements().frictions().iter().find(rubs).zip(supports);
            frictions.extend(own.map(|(sliding, (first, second))| FixtureFriction {
                fixture: place,
                sliding: *sliding,
                supports: [first, second],
            }));
        }
        Self {
            elements,
            frictions,
            springs: vec![[0.0; 2]; model.elements().springs().len()],
            contacts: vec![0.0; model.elements().contacts().len()],
            powers: vec![FixturePower::default(); fixtures.len()],
        }
    }

    /// Powers at a state, fixture by fixture.
    pub fn read(&mut self, system: &Coupled, (t, y): (f64, &[f64])) -> &[FixturePower] {
        self.powers.fill(FixturePower::default());
        let model = system.model();
        let series = model.elements().series();
        // With a residual flexibility the force of a spring follows all springs and contacts.
        if series.is_some() {
            for (row, spring) in self.springs.iter_mut().enumerate() {
                *spring = system.relative_motion(row, t, y).into();
            }
            for (contact, force_n) in self.contacts.iter_mut().enumerate() {
                *force_n = system.element_force(ElementId::Contact(contact), t, y);
            }
        }
        for FixtureElement { fixture, element, support } in &self.elements {
            let (force_n, loss_w) = match (element, series) {
                (ElementId::Spring(row), Some(series)) => {
                    let own = series.spring_force(*row, &self.springs, &self.contacts);
                    (own.force_n, own.damped_n * self.springs[*row][1])
                }
                (ElementId::Spring(row), None) => {
                    let (elongation_m, rate_m_s) = system.relative_motion(*row, t, y);
                    let spring = &model.elements().springs()[*row];
                    let damped_n = spring.damping_n_s_per_m * rate_m_s;
                    (spring.stiffness_n_per_m * elongation_m + damped_n, damped_n * rate_m_s)
                }
                (ElementId::Contact(contact), _) => {
                    let of = &model.elements().contacts()[*contact];
                    let (penetration_m, rate_m_s) = system.penetration(*contact, t, y);
                    match system.is_closed(*contact) {
                        true => {
                            let force_n = of.law.closed_force(penetration_m, rate_m_s) - of.rest_force_n;
                            (force_n, of.law.dissipated_power(penetration_m, rate_m_s))
                        }
                        false => (-of.rest_force_n, 0.0),
                    }
                }
            };
            let power = &mut self.powers[*fixture];
            power.loss_w += loss_w;
            power.structure_w += force_n * system.column_motion(*support, t, y)[1];
        }
        for FixtureFriction { fixture, sliding, supports } in &self.frictions {
            let pressing_n = system.contact_force(sliding.contact, t, y).max(0.0);
            let across = sliding.springs.map(|spring| system.relative_motion(spring, t, y).1);
            let [per_speed, slip_m_s] = friction([sliding.coefficient, sliding.speed_m_s], pressing_n, across);
            let power = &mut self.powers[*fixture];
            power.loss_w += per_speed * slip_m_s * slip_m_s;
            power.slip_m_s = if pressing_n > 0.0 { slip_m_s } else { 0.0 };
            for (support, rate_m_s) in supports.iter().zip(across) {
                power.structure_w += per_speed * rate_m_s * system.column_motion(*support, t, y)[1];
            }
        }
        &self.powers
    }
}

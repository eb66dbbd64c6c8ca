//! Parts of a scene, their points, and the links between points: plain data, the source of the coupled system.
//!
//! A part is rigid or elastic: the machine, a hammer or a casting. A point belongs to a part; a link joins two points with a law. Only
//! this file knows the parts, points and links of a scene, and the freedoms of a rigid part.

use std::collections::BTreeMap;

use super::model::{Environment, HammerUnit, Scene};
use crate::contact::{ContactLaw, ContactParameters};
use crate::direction::{DOWN, across, unit};
use crate::hammer::{Gas, HammerModel, body};
use crate::structure::{BodyPoint, Side, WeightedNodes};
use crate::workpiece::{Casting, FREEDOMS, Fixture, Motion, WorkpieceError};

/// Id of a part of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum PartId {
    /// The machine.
    Machine,
    /// The bodies of a hammer.
    Hammer(usize),
    /// A casting.
    Casting(usize),
}

/// A part: how it can move.
#[derive(Debug, Clone, PartialEq)]
pub enum Part {
    /// Rigid bodies: their freedoms, each with its mass in kg or inertia in kg m2.
    Rigid(Vec<(Freedom, f64)>),
    /// A reduced structure. Its modes are separate from the scene, see [`crate::system::InterfaceModes`].
    Elastic,
}

/// Freedom of a rigid part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Freedom {
    /// Motion of a hammer's body along the strike axis, see [`body`].
    Body(usize),
    /// Motion of a casting's centre of mass against x (0), y (1) or z (2); the last is its heave, downwards.
    Shift(usize),
    /// Rotation of a casting about x (0), y (1) or z (2).
    Rotation(usize),
}

/// Id of a fixture: its casting, its index among that casting's fixtures, and the direction in which it holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FixtureId {
    /// The casting that it holds.
    pub casting: usize,
    /// Index among the fixtures of that casting.
    pub fixture: usize,
    /// Along its axis (0) or in one of the directions across it (1, 2), see [`Fixture::axes`].
    pub axis: usize,
}

/// Id of a point of a part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum PointId {
    /// A body of a hammer.
    Body {
        /// The hammer.
        hammer: usize,
        /// The body, see [`body`].
        body: usize,
    },
    /// The point of the machine that carries a hammer.
    Mount {
        /// The hammer.
        hammer: usize,
    },
    /// The point of a casting that a hammer strikes.
    Strike {
        /// The hammer.
        hammer: usize,
    },
    /// The point of the machine that carries a fixture.
    Support(FixtureId),
    /// The point of a casting that a fixture holds.
    Held(FixtureId),
    /// The measuring point of a casting; its centre of mass where none is chosen.
    Measured {
        /// The casting.
        casting: usize,
    },
    /// The centre of mass of a casting.
    Centre {
        /// The casting.
        casting: usize,
    },
    /// A core point of a casting. No link joins it.
    Core {
        /// The casting.
        casting: usize,
        /// Index among the casting's core points.
        core: usize,
    },
    /// A casting as a whole, as it rotates.
    Rotation {
        /// The casting.
        casting: usize,
        /// About the first (0) or the second (1) direction across the one in which the casting is measured: about x or y.
        axis: usize,
    },
    /// A watched point of the machine. No link joins it.
    Watched {
        /// Index among these points.
        point: usize,
    },
}

impl PointId {
    /// Whether no link joins the point. Such a point of an elastic part costs no state.
    pub fn is_watched(self) -> bool {
        matches!(
            self,
            Self::Watched { .. }
                | Self::Measured { .. }
                | Self::Centre { .. }
                | Self::Core { .. }
                | Self::Rotation { .. }
        )
    }
}

/// Location of a point on its part.
#[derive(Debug, Clone, PartialEq)]
pub enum Location {
    /// A hammer's body.
    Body(usize),
    /// Interface points of a reduced structure with their weights, which sum to 1.
    Nodes(Vec<(String, f64)>),
    /// Place from a rigid casting's centre of mass, m.
    Offset([f64; 3]),
    /// A point of an elastic casting.
    Place(BodyPoint),
    /// No place: the rotation of a rigid casting about a unit vector, rad.
    Rotation([f64; 3]),
}

/// A point, its part, where it is on that, and the direction in which its motion counts.
#[derive(Debug, Clone, PartialEq)]
pub struct PointRef {
    /// Id.
    pub id: PointId,
    /// The part that it belongs to.
    pub part: PartId,
    /// Location on the part.
    pub location: Location,
    /// Unit vector in world axes.
    pub direction: [f64; 3],
}

/// Link of a hammer: its guide's spring, its contacts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HammerLink {
    /// Spring of the guide on its mount.
    Guide,
    /// Telescope against its top stop.
    TopStop,
    /// Telescope at the end of its stroke.
    EndStop,
    /// Piston against the rear wall of the cylinder.
    RearWall,
    /// Piston on chisel.
    PistonChisel,
    /// Chisel against the nose of the cylinder.
    Nose,
    /// Chisel against its retainer.
    Retainer,
    /// Spool against its rear stop.
    SpoolRear,
    /// Spool against its front stop.
    SpoolFront,
    /// Chisel on casting.
    ChiselCasting,
}

/// Owner of a link. Its books record the link's work and loss.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Owner {
    /// A hammer.
    Hammer {
        /// The hammer.
        hammer: usize,
        /// Link of the hammer.
        link: HammerLink,
    },
    /// A fixture of a casting.
    Fixture(FixtureId),
}

/// Law of a link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LinkLaw {
    /// `F = k d + c d'`, d the motion of the first point relative to the second since rest.
    Spring {
        /// Stiffness in N/m.
        stiffness_n_per_m: f64,
        /// Damping in N s/m.
        damping_n_s_per_m: f64,
    },
    /// One-sided contact: it pushes once the first point has moved by more than the gap towards the second.
    Contact {
        /// Force by penetration and rate.
        law: ContactLaw,
        /// The gap in m, before the contact is pressed together by its preload.
        gap_m: f64,
        /// Force at rest in N.
        preload_n: f64,
        /// Whether the law includes the residual flexibility of elastic parts at its own points.
        includes_flexibility: bool,
    },
}

/// Friction of a pad in its plane: `mu F tanh(|v| / v_s)` against the velocity v across its axis, F the force along it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Friction {
    /// The pad, along its axis.
    pub pad: FixtureId,
    /// Coefficient `mu`.
    pub coefficient: f64,
    /// Speed `v_s`.
    pub speed_m_s: f64,
}

/// Two points joined by a law.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// The points.
    pub ends: [PointRef; 2],
    /// The law.
    pub law: LinkLaw,
    /// The owner.
    pub owner: Owner,
}

impl Part {
    /// Motion of a location along a direction as a sum over the freedoms of a rigid part, by their indices; empty for an elastic one.
    pub fn row(&self, location: &Location, direction: [f64; 3]) -> Vec<(usize, f64)> {
        let Self::Rigid(freedoms) = self else { return Vec::new() };
        let terms = freedoms.iter().map(|(freedom, _)| location.motion_per(*freedom, direction)).enumerate();
        terms.filter(|(_, coefficient)| *coefficient != 0.0).collect()
    }
}

impl Location {
    /// Motion of the location along a direction per motion of a freedom, see [`Motion::per_freedom`].
    fn motion_per(&self, freedom: Freedom, direction: [f64; 3]) -> f64 {
        let on_casting = |at_m: [f64; 3]| Motion { at_m, direction }.per_freedom();
        match (self, freedom) {
            (Self::Body(own), Freedom::Body(body)) if *own == body => 1.0,
            (Self::Offset(at_m), Freedom::Shift(axis)) => on_casting(*at_m)[axis],
            (Self::Offset(at_m), Freedom::Rotation(axis)) => on_casting(*at_m)[3 + axis],
            (Self::Rotation(about), Freedom::Rotation(axis)) => about[axis],
            _ => 0.0,
        }
    }
}

impl HammerUnit {
    /// The hammer's constants in an environment.
    pub fn model(&self, environment: &Environment) -> HammerModel {
        let gas = Gas {
            specific_energy_j_per_kg: environment.gas_constant_j_per_kg_k * environment.temperature_k,
            isentropic_exponent: environment.isentropic_exponent,
            inflow_exponent: environment.inflow_exponent,
            outflow_exponent: environment.outflow_exponent,
            expansion_exponent: environment.expansion_exponent,
            ambient_pressure_pa: environment.ambient_pressure_pa,
        };
        HammerModel::new(&self.parameters, gas, environment.gravity_along(self.axis()))
    }

    /// Contacts between the hammer's bodies: the bodies with coefficients +1 and -1, the parameters, the gap in m.
    fn inner_contacts(&self) -> [(HammerLink, [usize; 2], ContactParameters, f64); 8] {
        use HammerLink::{EndStop, Nose, PistonChisel, RearWall, Retainer, SpoolFront, SpoolRear, TopStop};
        use body::{CHISEL, CYLINDER, GUIDE, PISTON, SPOOL};
        let p = &self.parameters;
        let (nose, stop) = (p.chisel.cylinder_contact, p.valve.stop);
        [
            (TopStop, [GUIDE, CYLINDER], p.telescope.top_stop, 0.0),
            (EndStop, [CYLINDER, GUIDE], p.telescope.end_stop, p.telescope.stroke_m),
            (RearWall, [CYLINDER, PISTON], p.piston.rear_wall, 0.0),
            (PistonChisel, [PISTON, CHISEL], p.piston.chisel_contact, p.piston.stroke_m),
            (Nose, [CYLINDER, CHISEL], nose, 0.0),
            (Retainer, [CHISEL, CYLINDER], nose, p.chisel.travel_m),
            (SpoolRear, [CYLINDER, SPOOL], stop, 0.0),
            (SpoolFront, [SPOOL, CYLINDER], stop, p.valve.travel_m),
        ]
    }
}

impl Scene {
    /// All parts: the machine, the hammers, the castings.
    ///
    /// # Errors
    /// As for [`Scene::part`].
    pub fn parts(&self) -> Result<Vec<(PartId, Part)>, WorkpieceError> {
        let hammers = (0..self.hammers.len()).map(PartId::Hammer);
        let castings = (0..self.castings.len()).map(PartId::Casting);
        let ids = [PartId::Machine].into_iter().chain(hammers).chain(castings);
        ids.map(|id| Ok((id, self.part(id)?))).collect()
    }

    /// A part. A casting has the freedoms that the scene needs.
    ///
    /// # Errors
    /// A casting that its fixtures do not hold, or that rotates and lacks its inertia.
    pub fn part(&self, id: PartId) -> Result<Part, WorkpieceError> {
        Ok(match id {
            PartId::Machine => Part::Elastic,
            PartId::Casting(index) if self.castings[index].elastic.is_some() => {
                self.castings[index].check_restraint(self.freedoms(index))?;
                Part::Elastic
            }
            PartId::Hammer(hammer) => {
                let masses = self.hammers[hammer].parameters.masses_kg().into_iter().enumerate();
                let moves = |body: usize| body != body::GUIDE || !self.ties(self.solver.guide);
                let free = masses.filter(|(body, _)| moves(*body));
                Part::Rigid(free.map(|(body, mass)| (Freedom::Body(body), mass)).collect())
            }
            PartId::Casting(index) => self.rigid_casting(index)?,
        })
    }

    /// A casting as a rigid part, also one that is elastic: its fixtures share loads at rest as under a rigid casting.
    ///
    /// # Errors
    /// As for [`Self::part`].
    pub(crate) fn rigid_casting(&self, index: usize) -> Result<Part, WorkpieceError> {
        let casting = &self.castings[index];
        let active = self.freedoms(index);
        casting.check_restraint(active)?;
        let moments = casting.moments_kg_m2().map(Option::unwrap_or_default);
        let all = (0..FREEDOMS).map(|freedom| match freedom.checked_sub(3) {
            None => (Freedom::Shift(freedom), casting.mass_kg),
            Some(axis) => (Freedom::Rotation(axis), moments[axis]),
        });
        Ok(Part::Rigid(all.zip(active).filter(|(_, active)| *active).map(|(freedom, _)| freedom).collect()))
    }

    /// Direction in which the velocities of a casting are measured: the strike axis of the first hammer that strikes it, unless it
    /// has its own.
    pub fn measuring_axis(&self, casting: usize) -> [f64; 3] {
        let strikes = self.hammers.iter().find(|unit| unit.casting == casting).map(HammerUnit::axis);
        self.castings[casting].measuring_axis.map(unit).or(strikes).unwrap_or(DOWN)
    }

    /// Freedoms that a rigid casting needs: shifts along x, y, z, then rotations about them. A freedom is needed if it moves a strike
    /// point, a fixture, the measuring point or a core point in its direction.
    pub fn freedoms(&self, index: usize) -> [bool; FREEDOMS] {
        let casting = &self.castings[index];
        let struck = self.hammers.iter().filter(|unit| unit.casting == index);
        let strikes = struck.map(|unit| Motion { at_m: unit.strike_place_m(), direction: unit.axis() });
        let held = casting.fixtures.iter().flat_map(|fixture| {
            let axes = fixture.axes();
            fixture.held_axes().map(move |axis| Motion { at_m: fixture.place_m(), direction: axes[axis] })
        });
        let direction = self.measuring_axis(index);
        let cores = casting.cores.iter().map(|core| core.at_m);
        let watched = cores.chain([casting.measured_place_m()]).map(|at_m| Motion { at_m, direction });
        casting.freedoms(&strikes.chain(held).chain(watched).collect::<Vec<_>>())
    }

    /// All points, by id.
    pub fn points(&self) -> BTreeMap<PointId, PointRef> {
        let hammers = (0..self.hammers.len()).flat_map(|hammer| {
            let bodies = (0..body::COUNT).map(move |body| PointId::Body { hammer, body });
            bodies.chain([PointId::Mount { hammer }, PointId::Strike { hammer }])
        });
        let castings = (0..self.castings.len()).flat_map(|casting| {
            let rotations = [0, 1].map(|axis| PointId::Rotation { casting, axis });
            let cores = (0..self.castings[casting].cores.len()).map(move |core| PointId::Core { casting, core });
            cores.chain(rotations).chain([PointId::Centre { casting }, PointId::Measured { casting }])
        });
        let fixtures = self.holds().flat_map(|(id, _)| [PointId::Support(id), PointId::Held(id)]);
        let watched = (0..self.outputs.points.len()).map(|point| PointId::Watched { point });
        let all = hammers.chain(castings).chain(fixtures).chain(watched);
        all.map(|id| self.point(id)).map(|point| (point.id, point)).collect()
    }

    /// Points of a casting whose velocity is watched, with their names: struck, held, then the measuring point if one is chosen.
    pub fn points_of_casting(&self, casting: usize) -> Vec<(PointId, String)> {
        let strikes = self.hammers.iter().enumerate().filter(|(_, unit)| unit.casting == casting);
        let strikes = strikes.map(|(hammer, unit)| (PointId::Strike { hammer }, format!("hammer.{}", unit.name)));
        let held = self.fixtures().filter(|(id, _)| id.casting == casting);
        let held = held.map(|(id, fixture)| (PointId::Held(id), format!("fixture.{}", fixture.name)));
        let measured = self.castings[casting].measuring_point_m;
        let measured = measured.map(|_| (PointId::Measured { casting }, "measuring_point".to_owned()));
        let cores = self.castings[casting].cores.iter().enumerate();
        let cores = cores.map(|(core, point)| (PointId::Core { casting, core }, format!("core.{}", point.name)));
        strikes.chain(held).chain(measured).chain(cores).collect()
    }

    /// Names of all core points, CASTING.NAME, casting by casting.
    pub fn core_names(&self) -> Vec<String> {
        let names = |casting: &Casting| {
            let cores = casting.cores.iter().map(|core| format!("{}.{}", casting.name, core.name));
            cores.collect::<Vec<String>>()
        };
        self.castings.iter().flat_map(names).collect()
    }

    /// All fixtures, casting by casting.
    pub fn fixtures(&self) -> impl Iterator<Item = (FixtureId, &Fixture)> {
        let of_casting = |(casting, held): (usize, &'_ Casting)| {
            (0..held.fixtures.len()).map(move |fixture| FixtureId { casting, fixture, axis: 0 })
        };
        let ids = self.castings.iter().enumerate().flat_map(of_casting);
        ids.zip(self.castings.iter().flat_map(|casting| &casting.fixtures))
    }

    /// All directions in which fixtures hold, fixture by fixture.
    fn holds(&self) -> impl Iterator<Item = (FixtureId, &Fixture)> {
        let axes = |(id, fixture): (FixtureId, &Fixture)| {
            fixture.held_axes().map(move |axis| FixtureId { axis, ..id }).collect::<Vec<_>>()
        };
        let ids = self.fixtures().flat_map(axes);
        ids.map(|id| (id, &self.castings[id.casting].fixtures[id.fixture]))
    }

    /// Returns a point. The point of a tied guide is its mount.
    pub fn point(&self, id: PointId) -> PointRef {
        let on = |casting: usize, rigid: Location, elastic: BodyPoint| {
            let location = self.castings[casting].elastic.map_or(rigid, |_| Location::Place(elastic));
            (PartId::Casting(casting), location)
        };
        let at = |casting: usize, at_m: [f64; 3], nodes: &Option<WeightedNodes>, area: BodyPoint| {
            on(casting, Location::Offset(at_m), nodes.clone().map_or(area, BodyPoint::Nodes))
        };
        let surface = |at_m: [f64; 3], axis: [f64; 3], side: Side| BodyPoint::Surface { at_m, axis, side };
        let node = |name: &str| (PartId::Machine, Location::Nodes(vec![(name.to_owned(), 1.0)]));
        let fixture = |id: FixtureId| &self.castings[id.casting].fixtures[id.fixture];
        let strikes = |hammer: usize| self.hammers[hammer].axis();
        let ((part, location), direction) = match id {
            PointId::Body { hammer, body: body::GUIDE } if self.ties(self.solver.guide) => {
                return self.point(PointId::Mount { hammer });
            }
            PointId::Body { hammer, body } => ((PartId::Hammer(hammer), Location::Body(body)), strikes(hammer)),
            PointId::Mount { hammer } => {
                ((PartId::Machine, Location::Nodes(self.hammers[hammer].mount.points.clone())), strikes(hammer))
            }
            PointId::Strike { hammer } => {
                let (unit, axis) = (&self.hammers[hammer], strikes(hammer));
                let place = unit.strike_place_m();
                (at(unit.casting, place, &unit.strike_nodes, surface(place, axis, Side::Struck)), axis)
            }
            PointId::Support(id) => (node(&fixture(id).point), fixture(id).axes()[id.axis]),
            PointId::Held(id) => {
                let (held, axes) = (fixture(id), fixture(id).axes());
                // A clamp presses from the side from which it acts.
                let side = if held.clamp_force_n > 0.0 { Side::Struck } else { Side::Held };
                let place = held.place_m();
                (at(id.casting, place, &held.at_nodes, surface(place, axes[0], side)), axes[id.axis])
            }
            PointId::Measured { casting } => {
                let (measured, axis) = (&self.castings[casting], self.measuring_axis(casting));
                let place = measured.measured_place_m();
                (at(casting, place, &measured.measuring_nodes, surface(place, axis, Side::Held)), axis)
            }
            PointId::Centre { casting } => {
                (on(casting, Location::Offset([0.0; 3]), BodyPoint::Centre), self.measuring_axis(casting))
            }
            PointId::Core { casting, core } => {
                let core = &self.castings[casting].cores[core];
                (at(casting, core.at_m, &core.at_nodes, BodyPoint::Place(core.at_m)), self.measuring_axis(casting))
            }
            PointId::Rotation { casting, axis } => {
                let direction = self.measuring_axis(casting);
                let about = across(direction)[axis];
                (on(casting, Location::Rotation(about), BodyPoint::Rotation(axis)), direction)
            }
            PointId::Watched { point } => (node(&self.outputs.points[point]), unit(self.outputs.points_axis)),
        };
        PointRef { id, part, location, direction }
    }

    /// Returns all links: hammer by hammer, then the fixtures.
    pub fn links(&self) -> Vec<Link> {
        let hammers = (0..self.hammers.len()).flat_map(|hammer| self.links_of_hammer(hammer));
        hammers.chain(self.holds().map(|(id, fixture)| self.link_of_fixture(id, fixture))).collect()
    }

    /// Friction of all pads that hold in both directions across their axes.
    pub fn frictions(&self) -> Vec<Friction> {
        let slides = |fixture: &Fixture| fixture.one_sided && fixture.held_axes().count() == 3;
        let pads = self.fixtures().filter(|(_, fixture)| slides(fixture));
        let friction = |(pad, fixture): (FixtureId, &Fixture)| Friction {
            pad,
            coefficient: fixture.friction,
            speed_m_s: fixture.friction_speed_m_s,
        };
        pads.map(friction).collect()
    }

    fn link_of_fixture(&self, id: FixtureId, fixture: &Fixture) -> Link {
        let lateral = id.axis.checked_sub(1);
        let [stiffness_n_per_m, damping_n_s_per_m] =
            lateral.map_or_else(|| fixture.spring(), |axis| fixture.lateral_spring(axis));
        let law = if fixture.one_sided && lateral.is_none() {
            let law = ContactLaw::KelvinVoigt { stiffness_n_per_m, damping_n_s_per_m };
            // The equilibrium gives it its force at rest.
            LinkLaw::Contact { law, gap_m: 0.0, preload_n: 0.0, includes_flexibility: false }
        } else {
            LinkLaw::Spring { stiffness_n_per_m, damping_n_s_per_m }
        };
        Link {
            ends: [PointId::Held(id), PointId::Support(id)].map(|end| self.point(end)),
            law,
            owner: Owner::Fixture(id),
        }
    }

    /// The spring of a hammer's guide unless that is tied, the contacts between its bodies, the contact with its casting.
    fn links_of_hammer(&self, hammer: usize) -> Vec<Link> {
        let unit = &self.hammers[hammer];
        let model = unit.model(&self.environment);
        let of_body = |body: usize| PointId::Body { hammer, body };
        let link = |link: HammerLink, ends: [PointId; 2], law: LinkLaw| Link {
            ends: ends.map(|end| self.point(end)),
            law,
            owner: Owner::Hammer { hammer, link },
        };
        let mut links = Vec::with_capacity(10);
        if !self.ties(self.solver.guide) {
            let stiffness_n_per_m = unit.parameters.guide.stiffness_n_per_m;
            let law = LinkLaw::Spring { stiffness_n_per_m, damping_n_s_per_m: 0.0 };
            links.push(link(HammerLink::Guide, [of_body(body::GUIDE), PointId::Mount { hammer }], law));
        }
        links.extend(unit.inner_contacts().map(|(name, bodies, parameters, gap_m)| {
            // The guide stands on its mount: only the other body's mass counts.
            let moving = bodies.iter().filter(|body| **body != body::GUIDE);
            let law = parameters.law(1.0 / moving.map(|body| 1.0 / model.mass()[*body]).sum::<f64>());
            link(
                name,
                bodies.map(of_body),
                LinkLaw::Contact { law, gap_m, preload_n: 0.0, includes_flexibility: false },
            )
        }));
        // The tip of the resting chisel stands `standoff` off the casting.
        let gap_m = model.rest().position[body::CHISEL] + unit.standoff_m;
        let law = unit.parameters.chisel.casting_contact.law(self.strike_mass_kg(unit));
        let elastic = self.castings.get(unit.casting).and_then(|casting| casting.elastic);
        let includes_flexibility = elastic.is_some_and(|elastic| elastic.contact_includes_casting);
        let law = LinkLaw::Contact { law, gap_m, preload_n: 0.0, includes_flexibility };
        links.push(link(HammerLink::ChiselCasting, [of_body(body::CHISEL), PointId::Strike { hammer }], law));
        links
    }
}

//! Springs and one-sided contacts as sparse rows over the points that move.
//!
//! Every element acts along one relative coordinate, a sparse row `r` over the columns: the coordinates of rigid parts and the driven
//! points of flexible ones ([`crate::system::Layout`]). Its elongation (or penetration) is `r u - offset`, its force `f` acts
//! as `-r' f`. One matrix serves motion and force, so reciprocity holds by construction; an element more is a row more.

use sprs::{CsMat, TriMat};

use crate::contact::ContactLaw;
use crate::system::points::{FixtureId, Owner, PointId, Points, Row};

/// Kind of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContactKind {
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

/// A linear spring and damper; its row in the matrix has the same index.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spring {
    /// Stiffness in N/m.
    pub stiffness_n_per_m: f64,
    /// Damping in N s/m.
    pub damping_n_s_per_m: f64,
    /// Owner.
    pub owner: Owner,
}

/// A one-sided contact; its row follows those of the springs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Owner.
    pub owner: Owner,
    /// Kind.
    pub kind: ContactKind,
    /// Law.
    pub law: ContactLaw,
    /// Subtracted from the row's value to give the penetration, m.
    pub offset_m: f64,
}

/// All elements of a coupled system.
#[derive(Debug, Clone)]
pub struct Elements {
    rows: CsMat<f64>,
    springs: Vec<Spring>,
    contacts: Vec<Contact>,
}

/// Element: index of a spring or of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ElementId {
    /// A spring.
    Spring(usize),
    /// A contact.
    Contact(usize),
}

/// Collects links; springs must come before contacts in the matrix, so both are kept apart until the end.
#[derive(Debug)]
pub(super) struct ElementsBuilder<'p> {
    points: &'p Points,
    springs: Vec<(Row, Spring)>,
    contacts: Vec<(Row, Contact)>,
}

impl<'p> ElementsBuilder<'p> {
    /// Starts without links.
    pub fn new(points: &'p Points) -> Self {
        Self { points, springs: Vec::new(), contacts: Vec::new() }
    }

    /// The points.
    pub fn points(&self) -> &Points {
        self.points
    }

    /// Adds a spring between two points; its elongation is the motion of the first less that of the second.
    pub fn spring(&mut self, ends: [PointId; 2], spring: Spring) {
        self.springs.push((self.points.between(ends), spring));
    }

    /// Adds a contact between two points, whose penetration grows as the first moves towards the second; returns its index among the
    /// contacts.
    pub fn contact(&mut self, ends: [PointId; 2], contact: Contact) -> usize {
        self.contacts.push((self.points.between(ends), contact));
        self.contacts.len() - 1
    }

    /// Assembles the sparse matrix over `columns` columns.
    pub fn assemble(self, columns: usize) -> Elements {
        let mut matrix = TriMat::new((self.springs.len() + self.contacts.len(), columns));
        let rows = self.springs.iter().map(|(row, _)| row);
        for (index, row) in rows.chain(self.contacts.iter().map(|(row, _)| row)).enumerate() {
            for &(column, coefficient) in row.iter().filter(|entry| entry.1 != 0.0) {
                matrix.add_triplet(index, column, coefficient);
            }
        }
        let rows: CsMat<f64> = matrix.to_csr();
        Elements {
            rows,
            springs: self.springs.into_iter().map(|(_, spring)| spring).collect(),
            contacts: self.contacts.into_iter().map(|(_, contact)| contact).collect(),
        }
    }
}

impl Elements {
    /// The linear springs.
    pub fn springs(&self) -> &[Spring] {
        &self.springs
    }

    /// The contacts; a contact's index here is its guard's index.
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    /// The elements of a fixture.
    pub fn of_fixture(&self, fixture: FixtureId) -> impl Iterator<Item = ElementId> {
        self.all().filter(move |(_, owner)| *owner == Owner::Fixture(fixture)).map(|(element, _)| element)
    }

    /// The elements of all fixtures of a casting.
    pub fn of_fixtures_of(&self, casting: usize) -> impl Iterator<Item = ElementId> {
        let holds = move |owner: Owner| matches!(owner, Owner::Fixture(fixture) if fixture.casting == casting);
        self.all().filter(move |(_, owner)| holds(*owner)).map(|(element, _)| element)
    }

    /// Iterates over all elements and their owners, springs first.
    fn all(&self) -> impl Iterator<Item = (ElementId, Owner)> {
        let springs = self.springs.iter().enumerate().map(|(at, spring)| (ElementId::Spring(at), spring.owner));
        let contacts = self.contacts.iter().enumerate().map(|(at, contact)| (ElementId::Contact(at), contact.owner));
        springs.chain(contacts)
    }

    /// The sparse matrix: one row per element.
    pub fn matrix(&self) -> &CsMat<f64> {
        &self.rows
    }

    /// Row of contact `contact`.
    #[inline(always)]
    pub fn contact_row(&self, contact: usize) -> usize {
        self.springs.len() + contact
    }

    /// Entries (column, coefficient) of a row.
    #[inline(always)]
    pub fn row(&self, row: usize) -> impl Iterator<Item = (usize, f64)> + Clone {
        let entries = self.rows.indptr().outer_inds_sz(row);
        let points = self.rows.indices()[entries.clone()].iter().copied();
        points.zip(self.rows.data()[entries].iter().copied())
    }
}

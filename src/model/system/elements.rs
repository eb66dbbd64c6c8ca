//! Springs and one-sided contacts as sparse rows over the points that move.
//!
//! Every element acts along one relative coordinate, a sparse row `r` over the columns: the coordinates of rigid parts and the driven
//! points of flexible ones ([`crate::system::Layout`]). Its elongation (or penetration) is `r u - offset`, its force `f` acts
//! as `-r' f`. One matrix serves motion and force, so reciprocity holds by construction; an element more is a row more.

use sprs::{CsMat, TriMat};

use crate::contact::ContactLaw;
use crate::scene::{Link, LinkLaw, Owner};
use crate::system::points::{PointRow, Points};

/// A linear spring and damper; its row in the matrix has the same index. Its force is measured from rest.
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
    /// Law.
    pub law: ContactLaw,
    /// Subtracted from the row's value to give the penetration, m.
    pub offset_m: f64,
    /// Force at rest, N: what holds it is in equilibrium with it and acts on when the contact opens.
    pub rest_force_n: f64,
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

impl Elements {
    /// Makes the elements of links between points whose rows have `columns` columns. The rows of springs come before those of contacts.
    pub(super) fn new(links: &[Link], points: &Points, columns: usize) -> Self {
        let (mut springs, mut contacts) = (Vec::new(), Vec::new());
        let mut rows: [Vec<PointRow>; 2] = Default::default();
        for Link { ends, law, owner } in links {
            let (owner, row) = (*owner, points.between(ends.each_ref().map(|end| end.id)));
            match *law {
                LinkLaw::Spring { stiffness_n_per_m, damping_n_s_per_m } => {
                    rows[0].push(row);
                    springs.push(Spring { stiffness_n_per_m, damping_n_s_per_m, owner });
                }
                LinkLaw::Contact { law, gap_m, preload_n } => {
                    rows[1].push(row);
                    let offset_m = gap_m - law.static_penetration(preload_n, 0.0);
                    contacts.push(Contact { owner, law, offset_m, rest_force_n: preload_n });
                }
            }
        }
        let mut matrix = TriMat::new((links.len(), columns));
        for (index, row) in rows.iter().flatten().enumerate() {
            for &(column, coefficient) in row.iter().filter(|entry| entry.1 != 0.0) {
                matrix.add_triplet(index, column, coefficient);
            }
        }
        Self { rows: matrix.to_csr(), springs, contacts }
    }

    /// The linear springs.
    pub fn springs(&self) -> &[Spring] {
        &self.springs
    }

    /// The contacts; a contact's index here is its guard's index.
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    /// Index of the contact of an owner, its first if it has several.
    pub fn contact_of(&self, owner: Owner) -> Option<usize> {
        self.contacts.iter().position(|contact| contact.owner == owner)
    }

    /// The elements whose owners are chosen, springs first.
    pub fn owned(&self, chosen: impl Fn(Owner) -> bool) -> impl Iterator<Item = ElementId> {
        let springs = self.springs.iter().enumerate().map(|(at, spring)| (ElementId::Spring(at), spring.owner));
        let contacts = self.contacts.iter().enumerate().map(|(at, contact)| (ElementId::Contact(at), contact.owner));
        springs.chain(contacts).filter(move |(_, owner)| chosen(*owner)).map(|(element, _)| element)
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

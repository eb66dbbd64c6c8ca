//! Springs and one-sided contacts as sparse rows over the points that move.
//!
//! Every element acts along one relative coordinate, a sparse row `r` over the points: hammer bodies, casting degrees of
//! freedom, then interface points of the structure. Its elongation (or penetration) is `r u - offset`, its force `f` acts
//! as `-r' f`. One matrix serves motion and force, so reciprocity holds by construction; an element more is a row more.

use sprs::{CsMat, TriMat};

use crate::contact::ContactLaw;

/// Which contact of a hammer a row is.
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
    /// Casting that it holds on the structure; `None` for the spring of a guide.
    pub casting: Option<usize>,
}

/// A one-sided contact; its row follows those of the springs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Hammer that it belongs to.
    pub hammer: usize,
    /// Which of the hammer's contacts.
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

/// Collects elements; springs must come before contacts in the matrix, so both are kept apart until the end.
#[derive(Debug, Default)]
pub(super) struct ElementsBuilder {
    springs: Vec<(Vec<(usize, f64)>, Spring)>,
    contacts: Vec<(Vec<(usize, f64)>, Contact)>,
}

impl ElementsBuilder {
    /// Adds a spring along `row`.
    pub fn spring(&mut self, row: Vec<(usize, f64)>, spring: Spring) {
        self.springs.push((row, spring));
    }

    /// Adds a contact along `row`; returns its index among the contacts.
    pub fn contact(&mut self, row: Vec<(usize, f64)>, contact: Contact) -> usize {
        self.contacts.push((row, contact));
        self.contacts.len() - 1
    }

    /// Assembles the sparse matrix over `points` points.
    pub fn assemble(self, points: usize) -> Elements {
        let mut matrix = TriMat::new((self.springs.len() + self.contacts.len(), points));
        let rows = self.springs.iter().map(|(row, _)| row);
        for (index, row) in rows.chain(self.contacts.iter().map(|(row, _)| row)).enumerate() {
            for &(point, coefficient) in row.iter().filter(|entry| entry.1 != 0.0) {
                matrix.add_triplet(index, point, coefficient);
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

    /// The sparse matrix: one row per element, one column per point.
    pub fn matrix(&self) -> &CsMat<f64> {
        &self.rows
    }

    /// Row of contact `contact`.
    #[inline(always)]
    pub fn contact_row(&self, contact: usize) -> usize {
        self.springs.len() + contact
    }

    /// Entries (point, coefficient) of a row.
    #[inline(always)]
    pub fn row(&self, row: usize) -> impl Iterator<Item = (usize, f64)> + Clone {
        let entries = self.rows.indptr().outer_inds_sz(row);
        let points = self.rows.indices()[entries.clone()].iter().copied();
        points.zip(self.rows.data()[entries].iter().copied())
    }
}

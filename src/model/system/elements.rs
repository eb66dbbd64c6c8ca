//! Springs and one-sided contacts as sparse rows over the moving points.
//!
//! Every element acts along one relative coordinate, a sparse row `r` over the columns: the coordinates of rigid parts and the driven
//! points of flexible ones ([`crate::system::Layout`]). Its elongation (or penetration) is `r u - offset`, its force `f` acts
//! as `-r' f`. One matrix serves motion and force, so reciprocity holds by construction; an element more is a row more.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};
use sprs::{CsMat, TriMat};

use crate::contact::ContactLaw;
use crate::scene::{FixtureId, Friction, Link, LinkLaw, Owner};
use crate::system::placed::Residual;
use crate::system::points::{PointRow, Points};
use decore_math::number::{Number, tanh};

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

/// A one-sided contact; its row comes after the springs' rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Owner.
    pub owner: Owner,
    /// Law.
    pub law: ContactLaw,
    /// Subtracted from the row's value to give the penetration, m.
    pub offset_m: f64,
    /// Force at rest, N. Its opposing load is in equilibrium with it and continues when the contact opens.
    pub rest_force_n: f64,
}

/// Friction of a pad, on rows that the elements have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sliding {
    /// Contact whose force presses.
    pub contact: usize,
    /// Springs in the two directions across its axis; they may have no stiffness.
    pub springs: [usize; 2],
    /// Coefficient `mu`.
    pub coefficient: f64,
    /// Speed `v_s` in m/s.
    pub speed_m_s: f64,
}

/// Friction per velocity in N s/m, `mu F tanh(|v| / v_s) / |v|`, and the speed `|v|` across the axis of a pad that is pressed by a force.
#[inline(always)]
pub(super) fn friction<R: Number>([coefficient, speed_m_s]: [R; 2], pressing_n: R, across: [R; 2]) -> [R; 2] {
    let speed = across[0].mul_add(across[0], across[1] * across[1]).sqrt();
    let share = speed / speed_m_s;
    // The ratio tends to 1 where the casting is at rest.
    let ratio = R::select(share.greater(R::splat(0.0)), tanh(share) / share, R::splat(1.0));
    [coefficient * pressing_n * ratio / speed_m_s, speed]
}

/// All elements of a coupled system.
#[derive(Debug, Clone)]
pub struct Elements {
    rows: CsMat<f64>,
    springs: Vec<Spring>,
    contacts: Vec<Contact>,
    frictions: Vec<Sliding>,
    /// Springs in series with the residual flexibility of elastic parts; `None` without any.
    series: Option<Series>,
    flexibilities: Vec<LinkFlexibility>,
}

/// A link in series with the residual flexibility R of an elastic part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkFlexibility {
    /// Owner.
    pub owner: Owner,
    /// Stiffness k by the study in N/m. Laws with a power of the penetration have none.
    pub stiffness_n_per_m: Option<f64>,
    /// R along the link in m/N.
    pub residual_m_per_n: f64,
    /// Part of the casting's flexibility that k includes in m/N.
    pub included_m_per_n: f64,
}

impl LinkFlexibility {
    /// `k R`: the error of the link's force without R.
    pub fn k_r(&self) -> Option<f64> {
        self.stiffness_n_per_m.map(|stiffness| stiffness * self.residual_m_per_n)
    }

    /// Stiffness in N/m of the link alone, `1/k - included`.
    pub fn own_stiffness_n_per_m(&self) -> Option<f64> {
        self.stiffness_n_per_m.map(|stiffness| stiffness / (1.0 - stiffness * self.included_m_per_n))
    }
}

/// Springs in series with the residual flexibility R of the elastic parts that they hold. R has no mass.
///
/// With `d` the elongations without R and `F_c` the forces of contacts, the springs' forces are `F = S d + B d' - S R_sc F_c`,
/// `S = (I + K R)^-1 K`, and to first order in the time constant `R c` `B = (I + K R)^-1 C (I + R K)^-1`. `d' S d / 2` is the energy of springs
/// and residual flexibility. The term of the contacts is part of their rows: `r_c - R_cs S r_s` in place of `r_c`. Each contact is in
/// series with its own R; the residual flexibility between contacts at different points is left out, as all of it is where modes are cut off.
#[derive(Debug, Clone)]
pub(super) struct Series {
    /// S, springs x springs.
    pub stiffness: DMatrix<f64>,
    /// B.
    pub damping: DMatrix<f64>,
    /// `S R_sc`, springs x contacts.
    pub contacts: DMatrix<f64>,
    /// Of each elastic part by its first column: what the forces add to the motion of its watched points.
    pub watched: BTreeMap<usize, WatchedResidual>,
    /// Of each elastic part by its first column: its own R along the elements that act on it.
    pub own: BTreeMap<usize, OwnResidual>,
}

/// Residual flexibility of one elastic part along the elements that act on it. Under their forces F it holds `F' R F / 2`.
#[derive(Debug, Clone)]
pub(super) struct OwnResidual {
    /// The elements.
    pub elements: Vec<ElementId>,
    /// R in m/N, elements x elements.
    pub flexibility: DMatrix<f64>,
}

/// Residual motion `R_w F` of watched points, a row for each: with the elongations d of springs and the forces `F_c` of contacts
/// `-(R_ws S d + R_ws B d' + (R_wc - R_ws S R_sc) F_c)`, since a force acts as `-r' f`.
#[derive(Debug, Clone)]
pub(super) struct WatchedResidual {
    /// `-R_ws S`, points x springs.
    pub elongations: DMatrix<f64>,
    /// `-R_ws B` in s, points x springs.
    pub rates_s: DMatrix<f64>,
    /// Motion per contact force in m/N, points x contacts.
    pub contacts: DMatrix<f64>,
}

/// A contact whose law cannot take the residual flexibility of its casting.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FlexibilityError {
    /// A law that includes less than the casting's own flexibility.
    #[error(
        "has a stiffness of {stiffness_n_per_m:.3e} N/m, but the casting alone yields by {local_m_per_n:.3e} m/N under it: the stiffness \
         cannot include the casting; set `contact_includes_casting = false`, or a larger `point_radius_m`"
    )]
    TooStiff {
        /// Owner of the contact.
        owner: Owner,
        /// Stiffness.
        stiffness_n_per_m: f64,
        /// Local flexibility of the casting at the point.
        local_m_per_n: f64,
    },
    /// A law with a power of the penetration.
    #[error(
        "has a law with a power of the penetration, to which the flexibility of the casting cannot be added: set \
         `contact_includes_casting = true` and `cutoff_hz = 10000.0`, or the law to \"kelvin_voigt\""
    )]
    Law {
        /// Owner of the contact.
        owner: Owner,
    },
}

impl FlexibilityError {
    /// Owner of the contact.
    pub(super) fn owner(&self) -> Owner {
        match self {
            Self::TooStiff { owner, .. } | Self::Law { owner } => *owner,
        }
    }
}

/// Element: index of a spring or of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ElementId {
    /// A spring.
    Spring(usize),
    /// A contact.
    Contact(usize),
}

impl Contact {
    /// The law in series with a residual flexibility R, of which the stiffness includes a part: with `r = R - included`
    /// `k / (1 + k r)` and `c / (1 + k r)^2`.
    fn in_series(&self, residual_m_per_n: f64, included_m_per_n: f64) -> Result<ContactLaw, FlexibilityError> {
        let owner = self.owner;
        let more = residual_m_per_n - included_m_per_n;
        let series = |stiffness_n_per_m: f64, damping_n_s_per_m: f64| {
            if stiffness_n_per_m * included_m_per_n >= 1.0 {
                return Err(FlexibilityError::TooStiff { owner, stiffness_n_per_m, local_m_per_n: included_m_per_n });
            }
            let factor = 1.0 / (1.0 + stiffness_n_per_m * more);
            Ok((stiffness_n_per_m * factor, damping_n_s_per_m * factor * factor))
        };
        match self.law {
            ContactLaw::KelvinVoigt { stiffness_n_per_m, damping_n_s_per_m } => {
                let (stiffness_n_per_m, damping_n_s_per_m) = series(stiffness_n_per_m, damping_n_s_per_m)?;
                Ok(ContactLaw::KelvinVoigt { stiffness_n_per_m, damping_n_s_per_m })
            }
            ContactLaw::KelvinVoigtSeparating { stiffness_n_per_m, damping_n_s_per_m } => {
                let (stiffness_n_per_m, damping_n_s_per_m) = series(stiffness_n_per_m, damping_n_s_per_m)?;
                Ok(ContactLaw::KelvinVoigtSeparating { stiffness_n_per_m, damping_n_s_per_m })
            }
            law if more == 0.0 => Ok(law),
            ContactLaw::HuntCrossley { .. } | ContactLaw::Hertz { .. } => Err(FlexibilityError::Law { owner }),
        }
    }
}

impl Elements {
    /// Makes the elements of links between points whose rows have `columns` columns. Rows of springs come before rows of contacts.
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
                LinkLaw::Contact { law, gap_m, preload_n, .. } => {
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
        Self {
            rows: matrix.to_csr(),
            springs,
            contacts,
            frictions: Vec::new(),
            series: None,
            flexibilities: Vec::new(),
        }
    }

    /// Adds the friction of pads.
    pub(super) fn with_frictions(mut self, frictions: &[Friction]) -> Self {
        let spring = |id: FixtureId| self.springs.iter().position(|spring| spring.owner == Owner::Fixture(id));
        let sliding = |Friction { pad, coefficient, speed_m_s }: &Friction| {
            let contact = self.contact_of(Owner::Fixture(*pad))?;
            let springs = [spring(FixtureId { axis: 1, ..*pad })?, spring(FixtureId { axis: 2, ..*pad })?];
            Some(Sliding { contact, springs, coefficient: *coefficient, speed_m_s: *speed_m_s })
        };
        self.frictions = frictions.iter().filter_map(sliding).collect();
        self
    }

    /// Puts the elements in series with the residual flexibility of elastic parts. Each part has the column of its first point, and R
    /// over its points. `links` are the links from which the elements were made.
    pub(super) fn with_residuals(
        mut self,
        links: &[Link],
        residuals: &[(usize, &Residual)],
    ) -> Result<Self, FlexibilityError> {
        if residuals.is_empty() {
            return Ok(self);
        }
        let springs = self.springs.len();
        let shares: Vec<_> =
            residuals.iter().map(|(first, residual)| self.shares(*first, residual.local.len())).collect();
        let of_parts = || shares.iter().zip(residuals).map(|(shares, (_, residual))| (shares, *residual));
        let (flexibility, local) = flexibility(of_parts());
        let diagonal = |of: &dyn Fn(&Spring) -> f64| {
            DMatrix::from_diagonal(&DVector::from_iterator(springs, self.springs.iter().map(of)))
        };
        let stiffness = diagonal(&|spring| spring.stiffness_n_per_m);
        let damping = diagonal(&|spring| spring.damping_n_s_per_m);
        let between = flexibility.view((0, 0), (springs, springs)).into_owned();
        let identity = DMatrix::identity(springs, springs);
        // `I + K R` has no eigenvalue below 1.
        let inverse = (&identity + &stiffness * between).try_inverse().unwrap_or(identity);
        let stiffness = &inverse * stiffness;
        let damping = &inverse * damping * inverse.transpose();
        let contacts = &stiffness * flexibility.view((0, springs), (springs, self.contacts.len()));
        let laws = links.iter().filter_map(|link| match link.law {
            LinkLaw::Contact { includes_flexibility, gap_m, .. } => Some((includes_flexibility, gap_m)),
            LinkLaw::Spring { .. } => None,
        });
        for (at, spring) in self.springs.iter().enumerate().filter(|(at, _)| flexibility[(*at, *at)] != 0.0) {
            self.flexibilities.push(LinkFlexibility {
                owner: spring.owner,
                stiffness_n_per_m: Some(spring.stiffness_n_per_m),
                residual_m_per_n: flexibility[(at, at)],
                included_m_per_n: 0.0,
            });
        }
        for ((at, contact), (includes, gap_m)) in self.contacts.iter_mut().enumerate().zip(laws) {
            let included = if includes { local[springs + at] } else { 0.0 };
            let residual_m_per_n = flexibility[(springs + at, springs + at)];
            if residual_m_per_n != 0.0 {
                self.flexibilities.push(LinkFlexibility {
                    owner: contact.owner,
                    stiffness_n_per_m: contact.law.stiffness_n_per_m(),
                    residual_m_per_n,
                    included_m_per_n: included,
                });
            }
            contact.law = contact.in_series(residual_m_per_n, included)?;
            contact.offset_m = gap_m - contact.law.static_penetration(contact.rest_force_n, 0.0);
        }
        let watched = residuals.iter().zip(&shares).map(|((first, residual), shares)| {
            let motion = -&residual.watched * shares.transpose();
            let of_springs = motion.columns(0, springs);
            let elongations = of_springs * &stiffness;
            let contacts = motion.columns_range(springs..) - of_springs * &contacts;
            (*first, WatchedResidual { elongations, rates_s: of_springs * &damping, contacts })
        });
        let watched = watched.collect();
        let own = residuals.iter().zip(&shares);
        let own =
            own.map(|((first, residual), shares)| (*first, OwnResidual::new(residual, shares, springs))).collect();
        self.rows = self.coupled_rows(&contacts);
        self.series = Some(Series { stiffness, damping, contacts, watched, own });
        Ok(self)
    }

    /// Entries of the elements' rows in columns of a part: elements x columns.
    fn shares(&self, first: usize, count: usize) -> DMatrix<f64> {
        let columns = first..first + count;
        let mut shares = DMatrix::zeros(self.rows.rows(), count);
        for element in 0..self.rows.rows() {
            let of_part = self.row(element).filter(|(column, _)| columns.contains(column));
            of_part.for_each(|(column, coefficient)| shares[(element, column - first)] = coefficient);
        }
        shares
    }

    /// Rows of the elements, contacts with the shares of the springs that their forces reach.
    fn coupled_rows(&self, contacts: &DMatrix<f64>) -> CsMat<f64> {
        let springs = self.springs.len();
        let mut matrix = TriMat::new(self.rows.shape());
        for element in 0..self.rows.rows() {
            self.row(element).for_each(|(column, coefficient)| matrix.add_triplet(element, column, coefficient));
            let Some(contact) = element.checked_sub(springs) else { continue };
            for (spring, share) in contacts.column(contact).iter().enumerate().filter(|(_, share)| **share != 0.0) {
                self.row(spring)
                    .for_each(|(column, coefficient)| matrix.add_triplet(element, column, -share * coefficient));
            }
        }
        matrix.to_csr()
    }

    /// Links in series with the residual flexibility of elastic parts.
    pub fn flexibilities(&self) -> &[LinkFlexibility] {
        &self.flexibilities
    }

    /// Springs in series with the residual flexibility of elastic parts.
    pub(super) fn series(&self) -> Option<&Series> {
        self.series.as_ref()
    }

    /// The linear springs.
    pub fn springs(&self) -> &[Spring] {
        &self.springs
    }

    /// The contacts; a contact's index here is its guard's index.
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    /// Friction of the pads.
    pub fn frictions(&self) -> &[Sliding] {
        &self.frictions
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

/// Force of a spring in series with a residual flexibility, N.
#[derive(Debug, Clone, Copy)]
pub(super) struct SeriesForce {
    /// Force beyond that at rest.
    pub force_n: f64,
    /// Part of it that damps.
    pub damped_n: f64,
}

impl Series {
    /// Force of a spring from elongation in m and rate in m/s of each spring, and the force of each contact beyond that at rest, N.
    pub fn spring_force(&self, spring: usize, motions: &[[f64; 2]], contacts: &[f64]) -> SeriesForce {
        let sum = |of: &DMatrix<f64>, values: &dyn Fn(usize) -> f64| {
            (0..of.ncols()).map(|other| of[(spring, other)] * values(other)).sum::<f64>()
        };
        let damped_n = sum(&self.damping, &|other| motions[other][1]);
        let elastic_n = sum(&self.stiffness, &|other| motions[other][0]) - sum(&self.contacts, &|at| contacts[at]);
        SeriesForce { force_n: elastic_n + damped_n, damped_n }
    }
}

impl OwnResidual {
    /// Of a part on whose points the elements act by these shares, elements x points; springs come first.
    fn new(residual: &Residual, shares: &DMatrix<f64>, springs: usize) -> Self {
        let acts = |element: &usize| shares.row(*element).iter().any(|share| *share != 0.0);
        let acting: Vec<usize> = (0..shares.nrows()).filter(acts).collect();
        let id = |element: &usize| match element.checked_sub(springs) {
            Some(contact) => ElementId::Contact(contact),
            None => ElementId::Spring(*element),
        };
        let shares = shares.select_rows(&acting);
        let flexibility = &shares * &residual.flexibility * shares.transpose();
        Self { elements: acting.iter().map(id).collect(), flexibility }
    }
}

/// Residual flexibility of elastic parts along the elements' rows, elements x elements, and the local one along each.
fn flexibility<'r>(
    parts: impl Iterator<Item = (&'r DMatrix<f64>, &'r Residual)> + Clone,
) -> (DMatrix<f64>, DVector<f64>) {
    let all = parts.clone().map(|(shares, _)| shares.nrows()).max().unwrap_or_default();
    parts.fold((DMatrix::zeros(all, all), DVector::zeros(all)), |(flexibility, local), (shares, residual)| {
        (
            flexibility + shares * &residual.flexibility * shares.transpose(),
            local + shares.component_mul(shares) * DVector::from_column_slice(&residual.local),
        )
    })
}

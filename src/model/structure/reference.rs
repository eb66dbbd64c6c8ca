//! Receptances of the full model at the frequencies of the curves: what its modes below the cut-off do not bring.
//!
//! A receptance is the sum over these modes and `b' (K - omega^2 M)^-1 b` for loads b without a share in them. With `A = K + shift M` and
//! `z = omega^2 + shift` the equations are `(I - z A^-1 M) x = A^-1 b`. They are solved at all frequencies at once in the block Krylov space
//! of `A^-1 M`, over a basis with `V' A V = I`: `x = V (I - z N)^-1 V' b`, `N = V' M V`. Blocks are added until the residual of the highest
//! frequency leaves an error below [`ERROR`].
//!
//! The eigenvectors of N are vectors s with `s' (K + shift M) s = 1` and `nu = s' M s`, each bringing `s_i s_j / (1 - z nu)`: the same form
//! as that of a mode, `nu = 1 / (omega_s^2 + shift)`, or of a motion without mass, `nu = 0`.

use nalgebra::DMatrix;

use super::error::{Step, StructureError};
use super::fixed_interface::Inner;
use decore_math::linalg::{LinalgError, PencilFactor, SymmetricPencil, multiply, multiply_transposed, symmetric_eigen};

/// Largest error of a receptance that the basis may leave, over its static value.
const ERROR: f64 = 1e-10;
/// Most blocks of a basis. Up to [`super::MOBILITY_SHARE`] of the cut-off a block gains a factor of 80.
const MOST_BLOCKS: usize = 20;
/// Share of a block's largest direction below which one is none.
const LEAST_DIRECTION: f64 = 1e-12;
const STEP: &str = "receptances of the full model";
const ADVICE: &str = "check signs and units of mass and stiffness";

/// Vectors that bring `s_i s_j / (1 - (omega^2 + shift) nu)` to the receptance between rows i and j, undamped.
pub(super) struct Vectors {
    /// Shift in 1/s2.
    pub shift: f64,
    /// `nu` in s2.
    pub nu: Vec<f64>,
    /// Interface rows x vectors, scaled to `s' (K + shift M) s = 1`.
    pub rows: DMatrix<f64>,
}

impl Vectors {
    /// Returns their receptance between two rows at a circular frequency in rad/s, m/N.
    pub fn receptance(&self, (i, j): (usize, usize), omega: f64) -> f64 {
        let z = omega * omega + self.shift;
        let vectors = self.nu.iter().enumerate();
        vectors.map(|(at, nu)| self.rows[(i, at)] * self.rows[(j, at)] / (1.0 - z * nu)).sum()
    }
}

/// The full model, its factor and its modes.
pub(super) struct Known<'a> {
    pub pencil: &'a SymmetricPencil<'a>,
    pub factor: &'a PencilFactor,
    /// Modes below the cut-off, and the shift of the factor.
    pub full: &'a Inner,
}

/// Computes the contribution of all modes except the known ones between rows. `loads`: a unit load per row of the interface (rows of the
/// pencil x interface rows), 0 for rows that no curve needs. `highest`: largest squared circular frequency.
pub(super) fn beyond_modes(known: &Known<'_>, loads: &DMatrix<f64>, highest: f64) -> Result<Vectors, StructureError> {
    Basis::solve(known, loads, highest).step(STEP, ADVICE)
}

/// Vectors V and `A V`.
#[derive(Clone)]
struct Block {
    vectors: DMatrix<f64>,
    forces: DMatrix<f64>,
}

struct Basis<'a> {
    known: &'a Known<'a>,
    /// `M Phi` of the known modes.
    inertia: DMatrix<f64>,
    /// Orthonormal by A, also to each other.
    blocks: Vec<Block>,
    /// `V' M V` of pairs of blocks (i, j) with i <= j, by j.
    products: Vec<Vec<DMatrix<f64>>>,
}

impl Basis<'_> {
    fn solve(known: &Known<'_>, loads: &DMatrix<f64>, highest: f64) -> Result<Vectors, LinalgError> {
        let z = highest + known.full.shift;
        let inertia = known.pencil.mass_times(&known.full.psi)?;
        let mut basis = Basis { known, inertia, blocks: Vec::new(), products: Vec::new() };
        let share = loads - multiply(&basis.inertia, &multiply_transposed(&known.full.psi, loads)?)?;
        let mut forces = share.clone();
        while basis.blocks.len() < MOST_BLOCKS {
            let mut vectors = forces.clone();
            known.factor.solve(&mut vectors)?;
            let (block, outside) = basis.orthonormalised(Block { vectors, forces })?;
            let begun = !basis.blocks.is_empty();
            if block.vectors.ncols() == 0 || (begun && basis.error(&share, z, &outside)? < ERROR) {
                break;
            }
            forces = known.pencil.mass_times(&block.vectors)?;
            basis.blocks.push(block);
            let products = basis.blocks.iter().map(|other| multiply_transposed(&other.vectors, &forces));
            basis.products.push(products.collect::<Result<_, _>>()?);
        }
        basis.vectors(&share)
    }

    fn width(&self) -> usize {
        self.blocks.iter().map(|block| block.vectors.ncols()).sum()
    }

    /// A block without its share in the known modes and the blocks before, orthonormal by A, and R with `old = ... + new R`.
    fn orthonormalised(&self, mut block: Block) -> Result<(Block, DMatrix<f64>), LinalgError> {
        let full = self.known.full;
        let mut outside = DMatrix::identity(block.vectors.ncols(), block.vectors.ncols());
        // Repeat for rounding errors.
        for _ in 0..2 {
            let mut along = multiply_transposed(&self.inertia, &block.vectors)?;
            block.vectors -= multiply(&full.psi, &along)?;
            for (mut row, omega_squared) in along.row_iter_mut().zip(&full.omega_squared) {
                row *= omega_squared + full.shift;
            }
            block.forces -= multiply(&self.inertia, &along)?;
            for other in &self.blocks {
                let along = multiply_transposed(&other.vectors, &block.forces)?;
                block.vectors -= multiply(&other.vectors, &along)?;
                block.forces -= multiply(&other.forces, &along)?;
            }
            let (turn, back) = normalising(&multiply_transposed(&block.vectors, &block.forces)?)?;
            block = Block { vectors: multiply(&block.vectors, &turn)?, forces: multiply(&block.forces, &turn)? };
            outside = back * outside;
        }
        Ok((block, outside))
    }

    /// `V' M V`.
    fn mass(&self) -> DMatrix<f64> {
        let width = self.width();
        let mut mass = DMatrix::zeros(width, width);
        let mut column = 0;
        for products in &self.products {
            let mut row = 0;
            for product in products {
                mass.view_mut((row, column), product.shape()).copy_from(product);
                mass.view_mut((column, row), (product.ncols(), product.nrows())).copy_from(&product.transpose());
                row += product.nrows();
            }
            column += products.last().map_or(0, DMatrix::ncols);
        }
        mass
    }

    /// `V' b`.
    fn shares(&self, share: &DMatrix<f64>) -> Result<DMatrix<f64>, LinalgError> {
        let mut out = DMatrix::zeros(self.width(), share.ncols());
        let mut row = 0;
        for block in &self.blocks {
            let part = multiply_transposed(&block.vectors, share)?;
            out.rows_mut(row, part.nrows()).copy_from(&part);
            row += part.nrows();
        }
        Ok(out)
    }

    /// Bound of the error of all receptances at z, over the static value. `outside`: what `A^-1 M` of the last block adds to the basis. The
    /// residual is `z A V_next R y_last`, and the error of a receptance is quadratic in it.
    fn error(&self, share: &DMatrix<f64>, z: f64, outside: &DMatrix<f64>) -> Result<f64, LinalgError> {
        let (mass, shares) = (self.mass(), self.shares(share)?);
        let eigen = symmetric_eigen(&mass)?;
        let least = 1.0 - z * eigen.values.last().copied().unwrap_or(0.0);
        let mut solution = multiply_transposed(&eigen.vectors, &shares)?;
        for (mut row, nu) in solution.row_iter_mut().zip(&eigen.values) {
            row /= 1.0 - z * nu;
        }
        let solution = multiply(&eigen.vectors, &solution)?;
        let last = self.blocks.last().map_or(0, |block| block.vectors.ncols());
        let residual = outside * solution.rows(self.width() - last, last) * z;
        let columns = residual.column_iter().zip(shares.column_iter()).filter(|(_, share)| share.norm_squared() > 0.0);
        let errors = columns.map(|(residual, share)| residual.norm_squared() / share.norm_squared());
        // Of a space that is not closed yet 1 - z nu may be less than it seems.
        Ok(errors.fold(0.0, f64::max) / least.max(f64::EPSILON))
    }

    fn vectors(&self, share: &DMatrix<f64>) -> Result<Vectors, LinalgError> {
        let eigen = symmetric_eigen(&self.mass())?;
        let rows = multiply_transposed(&self.shares(share)?, &eigen.vectors)?;
        Ok(Vectors { shift: self.known.full.shift, nu: eigen.values, rows })
    }
}

/// T that makes a block with this product `V' A V` orthonormal, without directions that are none, and the R with `V = (V T) R`.
fn normalising(gram: &DMatrix<f64>) -> Result<(DMatrix<f64>, DMatrix<f64>), LinalgError> {
    let eigen = symmetric_eigen(gram)?;
    let largest = eigen.values.last().copied().unwrap_or(0.0);
    let kept: Vec<usize> = (0..eigen.values.len()).filter(|at| eigen.values[*at] > LEAST_DIRECTION * largest).collect();
    let mut turn = eigen.vectors.select_columns(&kept);
    let mut back = turn.transpose();
    for (column, &at) in kept.iter().enumerate() {
        let size = eigen.values[at].sqrt();
        turn.column_mut(column).unscale_mut(size);
        back.row_mut(column).scale_mut(size);
    }
    Ok((turn, back))
}

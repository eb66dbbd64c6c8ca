//! Fill-reducing order of a symmetric sparse matrix: nested dissection of its graph, then a postorder of the elimination
//! tree.

use std::collections::HashMap;
use std::ffi::{c_int, c_uint};
use std::ptr::null_mut;
use std::sync::{Mutex, PoisonError};

use metis_sys::{METIS_NOPTIONS, METIS_NodeND, METIS_SetDefaultOptions, idx_t, rstatus_et_METIS_OK};

use super::LinalgError;
use super::draws::Generator;

/// METIS draws from a generator that all threads share (see `draws`): one call at a time makes the order a function of the matrix
/// alone.
static METIS: Mutex<()> = Mutex::new(());

/// Random numbers of METIS.
static GENERATOR: Mutex<Generator> = Mutex::new(Generator::UNSEEDED);

/// Seeds [`rand`]: METIS does before it draws.
// SAFETY: name and types equal the C library's function, which this one replaces.
#[unsafe(no_mangle)]
extern "C" fn srand(seed: c_uint) {
    *GENERATOR.lock().unwrap_or_else(PoisonError::into_inner) = Generator::seeded(seed);
}

/// A draw.
// SAFETY: as above.
#[unsafe(no_mangle)]
extern "C" fn rand() -> c_int {
    GENERATOR.lock().unwrap_or_else(PoisonError::into_inner).draw() as c_int
}

/// Positions of the non-zeros of a symmetric matrix: both triangles; the diagonal is optional.
///
/// No structure of sprs, which wants rising columns: they come in the order in which K and M have them and are only gone through.
pub(super) struct SymmetricPattern {
    pub pointers: Vec<usize>,
    pub indices: Vec<u32>,
}

impl SymmetricPattern {
    pub fn order(&self) -> usize {
        self.pointers.len() - 1
    }

    pub fn row(&self, row: usize) -> &[u32] {
        &self.indices[self.pointers[row]..self.pointers[row + 1]]
    }
}

/// The order of elimination: entry i is the row that is eliminated as the i-th.
pub(super) fn fill_reducing(pattern: &SymmetricPattern) -> Result<Vec<u32>, LinalgError> {
    let dissected = nested_dissection(pattern)?;
    let inverse = inverse(&dissected);
    let parents = elimination_tree(pattern, &dissected, &inverse);
    Ok(postorder(&parents).into_iter().map(|position| dissected[position as usize]).collect())
}

/// `inverse[order[i]] = i`.
pub(super) fn inverse(order: &[u32]) -> Vec<u32> {
    let mut inverse = vec![0; order.len()];
    for (position, &row) in (0_u32..).zip(order) {
        inverse[row as usize] = position;
    }
    inverse
}

/// Rows with equal closed neighbourhoods (the DOFs of one node) are ordered as one vertex.
fn nested_dissection(pattern: &SymmetricPattern) -> Result<Vec<u32>, LinalgError> {
    let (groups, members) = group(pattern);
    let (mut pointers, mut neighbours, mut weights) = (vec![0 as idx_t], Vec::new(), Vec::new());
    let mut seen = vec![usize::MAX; members.len()];
    for (index, rows) in members.iter().enumerate() {
        seen[index] = index;
        for &column in rows.first().map_or(&[][..], |row| pattern.row(*row as usize)) {
            let neighbour = groups[column as usize];
            if seen[neighbour as usize] != index {
                seen[neighbour as usize] = index;
                neighbours.push(neighbour as idx_t);
            }
        }
        pointers.push(idx_t::try_from(neighbours.len()).map_err(|_| too_large(pattern))?);
        weights.push(rows.len() as idx_t);
    }
    let order = if neighbours.is_empty() {
        (0..members.len() as idx_t).collect()
    } else {
        metis(&mut pointers, &mut neighbours, &mut weights).ok_or_else(|| too_large(pattern))?
    };
    Ok(order.into_iter().flat_map(|group| members[group as usize].iter().copied()).collect())
}

fn too_large(pattern: &SymmetricPattern) -> LinalgError {
    LinalgError::OutOfMemory { order: pattern.order() }
}

fn metis(pointers: &mut [idx_t], neighbours: &mut [idx_t], weights: &mut [idx_t]) -> Option<Vec<idx_t>> {
    let mut count = idx_t::try_from(weights.len()).ok()?;
    let (mut order, mut inverse) = (vec![0; weights.len()], vec![0; weights.len()]);
    let mut options = [0; METIS_NOPTIONS as usize];
    let _guard = METIS.lock().unwrap_or_else(PoisonError::into_inner);
    // SAFETY: the arrays have the lengths that METIS_NodeND asks for (count + 1, pointers[count], count, METIS_NOPTIONS,
    // count, count), the adjacency is symmetric and without loops, and all outlive the call.
    let status = unsafe {
        METIS_SetDefaultOptions(options.as_mut_ptr());
        METIS_NodeND(
            &mut count,
            pointers.as_mut_ptr(),
            neighbours.as_mut_ptr(),
            if weights.is_empty() { null_mut() } else { weights.as_mut_ptr() },
            options.as_mut_ptr(),
            order.as_mut_ptr(),
            inverse.as_mut_ptr(),
        )
    };
    (status == rstatus_et_METIS_OK).then_some(order)
}

/// Group of every row, and the rows of every group in the order of their first row.
fn group(pattern: &SymmetricPattern) -> (Vec<u32>, Vec<Vec<u32>>) {
    let mut known: HashMap<u64, u32> = HashMap::new();
    let mut members: Vec<Vec<u32>> = Vec::new();
    let groups = (0..pattern.order()).map(|row| {
        // Two different neighbourhoods with the same sum would only make the order worse, not the result wrong.
        let others = pattern.row(row).iter().map(|&column| column as usize).filter(|&column| column != row);
        let hash = others.fold(mix(row as u64), |sum, column| sum.wrapping_add(mix(column as u64)));
        let group = *known.entry(hash).or_insert(members.len() as u32);
        if group as usize == members.len() {
            members.push(Vec::new());
        }
        members[group as usize].push(row as u32);
        group
    });
    (groups.collect(), members)
}

/// The finaliser of SplitMix64: spreads a number over 64 bits.
fn mix(number: u64) -> u64 {
    let mut z = number.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

const NONE: u32 = u32::MAX;

/// Parent of every column of the factor, in positions of the order (Liu's algorithm with path compression).
fn elimination_tree(pattern: &SymmetricPattern, order: &[u32], inverse: &[u32]) -> Vec<u32> {
    let mut parents = vec![NONE; order.len()];
    let mut ancestors = vec![NONE; order.len()];
    for (position, &row) in (0_u32..).zip(order) {
        for &column in pattern.row(row as usize) {
            let mut node = inverse[column as usize];
            while node < position {
                let next = ancestors[node as usize];
                ancestors[node as usize] = position;
                if next == NONE {
                    parents[node as usize] = position;
                    break;
                }
                node = next;
            }
        }
    }
    parents
}

/// Children before parents, subtree by subtree.
fn postorder(parents: &[u32]) -> Vec<u32> {
    let mut first_child = vec![NONE; parents.len()];
    let mut sibling = vec![NONE; parents.len()];
    let mut roots = Vec::new();
    for (node, &parent) in parents.iter().enumerate().rev() {
        let node = node as u32;
        match first_child.get_mut(parent as usize) {
            Some(first) => {
                sibling[node as usize] = *first;
                *first = node;
            }
            None => roots.push(node),
        }
    }
    let mut order = Vec::with_capacity(parents.len());
    let mut stack = roots;
    while let Some(&node) = stack.last() {
        let child = first_child[node as usize];
        if child == NONE {
            stack.pop();
            order.push(node);
        } else {
            first_child[node as usize] = sibling[child as usize];
            stack.push(child);
        }
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of nodes with two DOFs each; every DOF couples to both of its node and of the four neighbours.
    fn grid(side: usize) -> SymmetricPattern {
        let (mut pointers, mut indices) = (vec![0], Vec::new());
        let node = |x: usize, y: usize| x * side + y;
        for (x, y) in (0..side).flat_map(|x| (0..side).map(move |y| (x, y))) {
            let mut near = vec![node(x, y)];
            near.extend((x > 0).then(|| node(x - 1, y)));
            near.extend((x + 1 < side).then(|| node(x + 1, y)));
            near.extend((y > 0).then(|| node(x, y - 1)));
            near.extend((y + 1 < side).then(|| node(x, y + 1)));
            for _ in 0..2 {
                indices.extend(near.iter().flat_map(|n| [2 * *n as u32, 2 * *n as u32 + 1]));
                pointers.push(indices.len());
            }
        }
        SymmetricPattern { pointers, indices }
    }

    #[test]
    fn dofs_of_a_node_are_grouped_and_the_order_is_a_permutation_in_postorder() {
        let pattern = grid(20);
        assert_eq!(group(&pattern).1.len(), 400);
        let order = fill_reducing(&pattern).expect("small");
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..800).collect::<Vec<u32>>());
        let parents = elimination_tree(&pattern, &order, &inverse(&order));
        assert_eq!(postorder(&parents), (0..800).collect::<Vec<u32>>());
        assert_eq!(order, fill_reducing(&pattern).expect("small"));
    }

    #[test]
    fn matrices_without_couplings_are_ordered_too() {
        let diagonal = SymmetricPattern { pointers: vec![0, 1, 2, 3], indices: vec![0, 1, 2] };
        assert_eq!(fill_reducing(&diagonal).expect("small").len(), 3);
        let empty = SymmetricPattern { pointers: vec![0], indices: vec![] };
        assert!(fill_reducing(&empty).expect("small").is_empty());
    }
}

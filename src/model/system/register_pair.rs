//! Numbers of a block's modes in registers.

use crate::system::impulse_response::Lanes;
use decore_math::number::{Number, load, store};

/// Some registers of a block's modes, whose sums hide each other's latency.
pub(super) type RegisterPair<W> = [W; 2];

/// Numbers of a block's modes from mode `first` on.
#[inline(always)]
pub(super) fn pair<W: Number>(lanes: &Lanes, first: usize) -> RegisterPair<W> {
    [load(lanes, first), load(lanes, first + W::LANES)]
}

#[inline(always)]
pub(super) fn put_pair<W: Number>(pair: RegisterPair<W>, lanes: &mut Lanes, first: usize) {
    store(pair[0], lanes, first);
    store(pair[1], lanes, first + W::LANES);
}

/// `a + b c`, rounded once.
#[inline(always)]
pub(super) fn fused<W: Number>(a: RegisterPair<W>, b: RegisterPair<W>, c: RegisterPair<W>) -> RegisterPair<W> {
    [b[0].mul_add(c[0], a[0]), b[1].mul_add(c[1], a[1])]
}

#[inline(always)]
pub(super) fn product<W: Number>(a: RegisterPair<W>, b: RegisterPair<W>) -> RegisterPair<W> {
    [a[0] * b[0], a[1] * b[1]]
}

/// How many points loops are unrolled for; 0 is any number. Numbers one by one are those of processors that call a library for each fused
/// product: nothing is won there, and a third of the code is saved.
#[inline(always)]
pub(super) fn unrolled<W: Number>(points: usize) -> usize {
    if W::LANES > 1 { points } else { 0 }
}

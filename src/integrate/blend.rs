//! Takes over some lanes of a vector.

use pulp::{Arch, Simd, WithSimd};

use crate::number::Number;

/// Takes the lanes of a mask over from `from` into `into`.
pub(super) fn blend<R: Number>(mask: R::Mask, from: &[R], into: &mut [R]) {
    Arch::new().dispatch(Blend { mask, from, into });
}

struct Blend<'b, R: Number> {
    mask: R::Mask,
    from: &'b [R],
    into: &'b mut [R],
}

impl<R: Number> WithSimd for Blend<'_, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for (into, from) in self.into.iter_mut().zip(self.from) {
            *into = R::select(self.mask, *from, *into);
        }
    }
}

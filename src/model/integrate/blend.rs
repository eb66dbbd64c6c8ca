//! Operations of the driver on all lanes at once.

use pulp::{Simd, WithSimd};

use crate::integrate::locate::Ends;
use crate::integrate::system::GuardSample;
use decore_math::number::Number;

/// Takes the lanes of a mask over from `from` into `into`.
pub(super) fn blend<R: Number>(mask: R::Mask, from: &[R], into: &mut [R]) {
    R::dispatch(Blend { mask, from, into });
}

/// The same of samples of guards.
pub(super) fn blend_samples<R: Number>(mask: R::Mask, from: &[GuardSample<R>], into: &mut [GuardSample<R>]) {
    R::dispatch(BlendSamples { mask, from, into });
}

/// Lanes in which a guard may be positive somewhere within the step: the others need no search.
pub(super) fn suspects<R: Number>(ends: &Ends<'_, R>) -> R::Mask {
    R::dispatch(Suspects { ends })
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

struct BlendSamples<'b, R: Number> {
    mask: R::Mask,
    from: &'b [GuardSample<R>],
    into: &'b mut [GuardSample<R>],
}

impl<R: Number> WithSimd for BlendSamples<'_, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for (into, from) in self.into.iter_mut().zip(self.from) {
            *into = GuardSample::select(self.mask, from, into);
        }
    }
}

struct Suspects<'s, 'e, R> {
    ends: &'s Ends<'e, R>,
}

impl<R: Number> WithSimd for Suspects<'_, '_, R> {
    type Output = R::Mask;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> R::Mask {
        self.ends.suspects()
    }
}

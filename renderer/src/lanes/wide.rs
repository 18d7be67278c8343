//! Lanes as arrays that the compiler turns into vectors: for AVX2, and for processors without either.

use super::{Lanes, MAX_LANES, Mask, Routine, call_plain, elementary};
use std::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, MulAssign, Neg, Not, Sub};

/// `N` single-precision lanes.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub struct Wide<const N: usize>(pub [f32; N]);

/// `N` truth values, held as all-ones or zero words so that selects become bit operations.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub struct WideMask<const N: usize>([u32; N]);

/// An array made lane by lane. Written out: `std::array::from_fn` is not always inlined into code for wider instructions, and thousands
/// of small loops in one function take the compiler minutes.
#[inline(always)]
pub(super) fn each<const N: usize, T: Copy + Default>(mut f: impl FnMut(usize) -> T) -> [T; N] {
    let mut out = [T::default(); N];
    macro_rules! fill {
        ($($i:literal)*) => { $(if $i < N { out[$i] = f($i); })* };
    }
    fill!(0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15);
    out
}

/// All lanes put together by a function of two.
#[inline(always)]
fn reduce<const N: usize, T: Copy>(lanes: &[T; N], f: impl Fn(T, T) -> T) -> T {
    let mut sum = lanes[0];
    macro_rules! reduce {
        ($($i:literal)*) => { $(if $i < N { sum = f(sum, lanes[$i]); })* };
    }
    reduce!(1 2 3 4 5 6 7 8 9 10 11 12 13 14 15);
    sum
}

macro_rules! wide_operator {
    ($trait:ident, $method:ident, $op:tt) => {
        impl<const N: usize> $trait for Wide<N> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(each(|i| self.0[i] $op other.0[i]))
            }
        }
    };
}
wide_operator!(Add, add, +);
wide_operator!(Sub, sub, -);
wide_operator!(Mul, mul, *);
wide_operator!(Div, div, /);

impl<const N: usize> Neg for Wide<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(each(|i| -self.0[i]))
    }
}
impl<const N: usize> AddAssign for Wide<N> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}
impl<const N: usize> MulAssign for Wide<N> {
    #[inline(always)]
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}
impl<const N: usize> BitAnd for WideMask<N> {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(each(|i| self.0[i] & other.0[i]))
    }
}
impl<const N: usize> BitOr for WideMask<N> {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(each(|i| self.0[i] | other.0[i]))
    }
}
impl<const N: usize> Not for WideMask<N> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(each(|i| !self.0[i]))
    }
}

#[inline(always)]
fn word(x: bool) -> u32 {
    if x { u32::MAX } else { 0 }
}

impl<const N: usize> Mask for WideMask<N> {
    #[inline(always)]
    fn splat(x: bool) -> Self {
        Self([word(x); N])
    }
    #[inline(always)]
    fn any(self) -> bool {
        reduce(&self.0, |a, b| a | b) != 0
    }
    #[inline(always)]
    fn all(self) -> bool {
        reduce(&self.0, |a, b| a & b) != 0
    }
    #[inline(always)]
    fn lane(self, i: usize) -> bool {
        self.0[i] != 0
    }
    #[inline(always)]
    fn from_fn(mut f: impl FnMut(usize) -> bool) -> Self {
        Self(each(|i| word(f(i))))
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        reduce(&each::<N, u32>(|i| self.0[i] & (1 << i)), |a, b| a | b)
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        Self(each(|i| 0u32.wrapping_sub((bits >> i) & 1)))
    }
}

/// [`Lanes::call`] with the instructions that [`super::dispatch`] runs these lanes with.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
#[inline(never)]
fn call_avx2<L: Lanes, R: Routine<L>>(routine: R) -> R::Output {
    routine.run()
}

impl<const N: usize> Lanes for Wide<N> {
    type Mask = WideMask<N>;
    const WIDTH: usize = N;
    const ALPHA_MIN: f64 = <f32 as Lanes>::ALPHA_MIN;
    #[inline(always)]
    fn call<R: Routine<Self>>(routine: R) -> R::Output {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has just been found to offer these instructions.
            #[expect(unsafe_code, reason = "calls a function compiled for instructions that were detected")]
            return unsafe { call_avx2(routine) };
        }
        call_plain(routine)
    }
    #[inline(always)]
    fn of(x: f64) -> Self {
        Self([x as f32; N])
    }
    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self([x; N])
    }
    #[inline(always)]
    fn from_fn(f: impl FnMut(usize) -> f32) -> Self {
        Self(each(f))
    }
    #[inline(always)]
    fn from_array(x: &[f32; MAX_LANES]) -> Self {
        Self(each(|i| x[i]))
    }
    #[inline(always)]
    fn to_array(self) -> [f32; MAX_LANES] {
        each(|i| if i < N { self.0[i] } else { 0.0 })
    }
    #[inline(always)]
    fn lane(self, i: usize) -> f32 {
        self.0[i]
    }
    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self(each(|i| f(f64::from(self.0[i])) as f32))
    }
    #[inline(always)]
    fn gather(table: &[f32], index: Self) -> Self {
        let Some(last) = table.len().checked_sub(1) else { return Self([0.0; N]) };
        // SAFETY: the table is not empty, and indices are clamped to its last. A check in every lane makes thousands of branches.
        #[expect(unsafe_code, reason = "the index has been clamped")]
        Self(each(|i| unsafe { *table.get_unchecked((index.0[i] as usize).min(last)) }))
    }
    #[inline(always)]
    fn gather_at(table: &[f32], index: &[usize; MAX_LANES]) -> Self {
        let Some(last) = table.len().checked_sub(1) else { return Self([0.0; N]) };
        // SAFETY: as above.
        #[expect(unsafe_code, reason = "the index has been clamped")]
        Self(each(|i| unsafe { *table.get_unchecked(index[i].min(last)) }))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(each(|i| (if self.0[i] > 0.0 { self.0[i] } else { 0.0 }).sqrt()))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(each(|i| self.0[i].abs()))
    }
    #[inline(always)]
    fn floor(self) -> Self {
        Self(each(|i| self.0[i].floor()))
    }
    #[inline(always)]
    fn exp(self) -> Self {
        elementary::exp(self)
    }
    #[inline(always)]
    fn exp_m1(self) -> Self {
        elementary::exp_m1(self)
    }
    #[inline(always)]
    fn ln(self) -> Self {
        elementary::ln(self)
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        elementary::sin_cos(self)
    }
    #[inline(always)]
    fn exp2_whole(self) -> Self {
        Self(each(|i| elementary::exp2_whole(self.0[i])))
    }
    #[inline(always)]
    fn split_binary(self) -> (Self, Self) {
        (Self(each(|i| elementary::split_binary(self.0[i]).0)), Self(each(|i| elementary::split_binary(self.0[i]).1)))
    }
    #[inline(always)]
    fn halves(self) -> (Self, Self) {
        (Self(each(|i| elementary::halves(self.0[i]).0)), Self(each(|i| elementary::halves(self.0[i]).1)))
    }
    #[inline(always)]
    fn lesser(self, other: Self) -> Self {
        Self(each(|i| if self.0[i] < other.0[i] { self.0[i] } else { other.0[i] }))
    }
    #[inline(always)]
    fn greater(self, other: Self) -> Self {
        Self(each(|i| if self.0[i] > other.0[i] { self.0[i] } else { other.0[i] }))
    }
    #[inline(always)]
    fn least_lane(self) -> f32 {
        reduce(&self.0, |a, b| if b < a { b } else { a })
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(each(|i| self.0[i].min(other.0[i])))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(each(|i| self.0[i].max(other.0[i])))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> WideMask<N> {
        WideMask(each(|i| word(self.0[i] < other.0[i])))
    }
    #[inline(always)]
    fn le(self, other: Self) -> WideMask<N> {
        WideMask(each(|i| word(self.0[i] <= other.0[i])))
    }
    #[inline(always)]
    fn eq(self, other: Self) -> WideMask<N> {
        WideMask(each(|i| word(self.0[i] == other.0[i])))
    }
    #[inline(always)]
    fn select(mask: WideMask<N>, a: Self, b: Self) -> Self {
        Self(each(|i| f32::from_bits((a.0[i].to_bits() & mask.0[i]) | (b.0[i].to_bits() & !mask.0[i]))))
    }
    #[inline(always)]
    fn is_finite(self) -> WideMask<N> {
        WideMask(each(|i| word(self.0[i].is_finite())))
    }
}

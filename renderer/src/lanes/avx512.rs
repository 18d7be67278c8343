//! Sixteen lanes as one AVX-512 register. Twin of [`super::Wide`]: the same operations, the same bits.
//!
//! Explicit instructions, because truth values become mask registers and table look-ups become gathers, which the compiler does not
//! make of arrays.
//!
//! The types are private to `lanes`, and the only place that names them is reached after [`is_there`] has found the instructions: every
//! `unsafe` block below calls an instruction of the sets that it checks.

#![expect(unsafe_code, reason = "instructions that were detected before these types can be named")]

use super::wide::each;
use super::{Lanes, MAX_LANES, Mask, Routine, elementary};
use std::arch::x86_64::*;
use std::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, MulAssign, Neg, Not, Sub};

/// Whether this processor has the instructions.
pub(super) fn is_there() -> bool {
    is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512vl")
        && is_x86_feature_detected!("avx512bw")
}

/// Asks for a value of a table to be brought near. Every processor of this kind has the instruction.
#[inline(always)]
pub(super) fn prefetch<T>(value: &T) {
    const LINE: usize = 64;
    for at in (0..size_of::<T>()).step_by(LINE) {
        // SAFETY: the address lies within a value that is borrowed; nothing is read.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(value).cast::<i8>().add(at)) };
    }
}

/// Sixteen single-precision numbers.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub(super) struct V16(__m512);

/// Sixteen truth values.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub(super) struct M16(__mmask16);

/// A method that is one expression of instructions.
macro_rules! instructions {
    ($(fn $name:ident($($arg:ident $(: $t:ty)?),*) -> $out:ty $body:block)*) => {
        $(
            #[inline(always)]
            fn $name($($arg $(: $t)?),*) -> $out {
                // SAFETY: the instructions have been found, see the module.
                unsafe { $body }
            }
        )*
    };
}

macro_rules! operator {
    ($trait:ident, $method:ident, $instruction:ident) => {
        impl $trait for V16 {
            type Output = Self;
            instructions! {
                fn $method(self, other: Self) -> Self { Self($instruction(self.0, other.0)) }
            }
        }
    };
}
operator!(Add, add, _mm512_add_ps);
operator!(Sub, sub, _mm512_sub_ps);
operator!(Mul, mul, _mm512_mul_ps);
operator!(Div, div, _mm512_div_ps);

impl Neg for V16 {
    type Output = Self;
    instructions! {
        fn neg(self) -> Self { Self(_mm512_xor_ps(self.0, _mm512_set1_ps(-0.0))) }
    }
}
impl AddAssign for V16 {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}
impl MulAssign for V16 {
    #[inline(always)]
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}
impl BitAnd for M16 {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}
impl BitOr for M16 {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}
impl Not for M16 {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}

impl Mask for M16 {
    #[inline(always)]
    fn splat(x: bool) -> Self {
        Self(if x { u16::MAX } else { 0 })
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.0 != 0
    }
    #[inline(always)]
    fn all(self) -> bool {
        self.0 == u16::MAX
    }
    #[inline(always)]
    fn lane(self, i: usize) -> bool {
        (self.0 >> i) & 1 == 1
    }
    #[inline(always)]
    fn from_fn(mut f: impl FnMut(usize) -> bool) -> Self {
        let mut bits = 0;
        each::<16, _>(|i| bits |= u16::from(f(i)) << i);
        Self(bits)
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self.0)
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        Self(bits as u16)
    }
}

#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,avx2")]
#[inline(never)]
fn call<R: Routine<V16>>(routine: R) -> R::Output {
    routine.run()
}

impl Lanes for V16 {
    type Mask = M16;
    const WIDTH: usize = 16;
    const ALPHA_MIN: f64 = <f32 as Lanes>::ALPHA_MIN;
    #[inline(always)]
    fn call<R: Routine<Self>>(routine: R) -> R::Output {
        // SAFETY: the instructions have been found, see the module.
        unsafe { call(routine) }
    }
    #[inline(always)]
    fn from_fn(f: impl FnMut(usize) -> f32) -> Self {
        Self::from_array(&each(f))
    }
    #[inline(always)]
    fn lane(self, i: usize) -> f32 {
        self.to_array()[i]
    }
    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        let x = self.to_array();
        Self::from_fn(|i| f(f64::from(x[i])) as f32)
    }
    #[inline(always)]
    fn gather(table: &[f32], index: Self) -> Self {
        let Some(last) = table.len().checked_sub(1) else { return Self::of(0.0) };
        if last > i32::MAX as usize {
            let index = index.to_array();
            return Self::from_fn(|i| table[(index[i] as usize).min(last)]);
        }
        // SAFETY: indices are clamped to `0..=last`. Negative numbers and NaN become 0 first, as in a cast to `usize`; too large ones
        // convert to the most negative word, which is the largest without a sign.
        unsafe {
            let index = _mm512_max_ps(index.0, _mm512_setzero_ps());
            let index = _mm512_min_epu32(_mm512_cvttps_epi32(index), _mm512_set1_epi32(last as i32));
            Self(_mm512_i32gather_ps::<4>(index, table.as_ptr()))
        }
    }
    #[inline(always)]
    fn gather_at(table: &[f32], index: &[usize; MAX_LANES]) -> Self {
        let Some(last) = table.len().checked_sub(1) else { return Self::of(0.0) };
        // SAFETY: indices are clamped to `0..=last`; both halves of `index` are read from inside it, and a `usize` has 64 bits.
        unsafe {
            let last = _mm512_set1_epi64(last as i64);
            let low = _mm512_min_epu64(_mm512_loadu_si512(index.as_ptr().cast()), last);
            let high = _mm512_min_epu64(_mm512_loadu_si512(index.as_ptr().add(8).cast()), last);
            let low = _mm512_i64gather_ps::<4>(low, table.as_ptr());
            let high = _mm512_i64gather_ps::<4>(high, table.as_ptr());
            Self(_mm512_insertf32x8::<1>(_mm512_castps256_ps512(low), high))
        }
    }
    instructions! {
        fn of(x: f64) -> Self { Self(_mm512_set1_ps(x as f32)) }
        fn splat(x: f32) -> Self { Self(_mm512_set1_ps(x)) }
        fn from_array(x: &[f32; MAX_LANES]) -> Self { Self(_mm512_loadu_ps(x.as_ptr())) }
        fn to_array(self) -> [f32; MAX_LANES] {
            let mut x = [0.0; MAX_LANES];
            _mm512_storeu_ps(x.as_mut_ptr(), self.0);
            x
        }
        fn sqrt(self) -> Self { Self(_mm512_sqrt_ps(_mm512_max_ps(self.0, _mm512_setzero_ps()))) }
        fn abs(self) -> Self { Self(_mm512_abs_ps(self.0)) }
        fn floor(self) -> Self {
            Self(_mm512_roundscale_ps::<{ _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC }>(self.0))
        }
        fn exp2_whole(self) -> Self {
            let biased = _mm512_add_ps(self.0, _mm512_set1_ps(12_582_912.0 + 127.0));
            Self(_mm512_castsi512_ps(_mm512_slli_epi32::<23>(_mm512_castps_si512(biased))))
        }
        fn split_binary(self) -> (Self, Self) {
            let root_half = _mm512_set1_epi32(0x3f35_04f3);
            let steps = _mm512_sub_epi32(_mm512_castps_si512(self.0), root_half);
            let m = _mm512_add_epi32(_mm512_and_si512(steps, _mm512_set1_epi32(0x007f_ffff)), root_half);
            (Self(_mm512_castsi512_ps(m)), Self(_mm512_cvtepi32_ps(_mm512_srai_epi32::<23>(steps))))
        }
        fn halves(self) -> (Self, Self) {
            let (bits, mask) = (_mm512_castps_si512(self.0), _mm512_set1_epi32(0x7fff));
            let low = _mm512_slli_epi32::<13>(_mm512_and_si512(bits, mask));
            let high = _mm512_slli_epi32::<13>(_mm512_and_si512(_mm512_srli_epi32::<16>(bits), mask));
            (Self(_mm512_castsi512_ps(low)), Self(_mm512_castsi512_ps(high)))
        }
        fn lesser(self, other: Self) -> Self { Self(_mm512_min_ps(self.0, other.0)) }
        fn greater(self, other: Self) -> Self { Self(_mm512_max_ps(self.0, other.0)) }
        fn least_lane(self) -> f32 { _mm512_reduce_min_ps(self.0) }
        fn min(self, other: Self) -> Self {
            let is_nan = _mm512_cmp_ps_mask::<_CMP_UNORD_Q>(self.0, self.0);
            Self(_mm512_mask_mov_ps(_mm512_min_ps(other.0, self.0), is_nan, other.0))
        }
        fn max(self, other: Self) -> Self {
            let is_nan = _mm512_cmp_ps_mask::<_CMP_UNORD_Q>(self.0, self.0);
            Self(_mm512_mask_mov_ps(_mm512_max_ps(other.0, self.0), is_nan, other.0))
        }
        fn lt(self, other: Self) -> M16 { M16(_mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, other.0)) }
        fn le(self, other: Self) -> M16 { M16(_mm512_cmp_ps_mask::<_CMP_LE_OQ>(self.0, other.0)) }
        fn eq(self, other: Self) -> M16 { M16(_mm512_cmp_ps_mask::<_CMP_EQ_OQ>(self.0, other.0)) }
        fn select(mask: M16, a: Self, b: Self) -> Self { Self(_mm512_mask_mov_ps(b.0, mask.0, a.0)) }
        fn is_finite(self) -> M16 {
            M16(_mm512_cmp_ps_mask::<_CMP_LT_OQ>(_mm512_abs_ps(self.0), _mm512_set1_ps(f32::INFINITY)))
        }
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
}

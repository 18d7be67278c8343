//! Numbers with one or many lanes behind one interface, so that a lobe is written once.
//!
//! `f32` is the readable reference and the twin of the WGSL, `f64` the double-precision check, [`Wide`] what the path
//! tracer runs. All lane operations are plain IEEE operations in a fixed order and nothing is contracted, so every width and every
//! instruction set gives the same bits. `unsafe` here: calling a function compiled for more instructions.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, MulAssign, Neg, Not, Sub};

/// One truth value per lane.
pub trait Mask: Copy + Debug + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// The same truth in every lane.
    fn splat(x: bool) -> Self;
    /// Whether any lane holds.
    fn any(self) -> bool;
    /// Whether every lane holds.
    fn all(self) -> bool;
    /// One lane.
    fn lane(self, i: usize) -> bool;
    /// A mask made lane by lane.
    fn from_fn(f: impl FnMut(usize) -> bool) -> Self;
}

/// A real number per lane.
pub trait Lanes:
    Copy
    + Debug
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + MulAssign
{
    /// The matching truth type.
    type Mask: Mask;
    /// Number of lanes.
    const WIDTH: usize;
    /// Smallest microfacet alpha that this precision holds.
    const ALPHA_MIN: f64;

    /// A constant in every lane.
    fn of(x: f64) -> Self;
    /// Lanes from single-precision numbers.
    fn from_fn(f: impl FnMut(usize) -> f32) -> Self;
    /// One lane in single precision.
    fn lane(self, i: usize) -> f32;
    /// Applies a function to every lane.
    fn map(self, f: impl Fn(f64) -> f64) -> Self;
    /// Reads `table[index]` per lane; the index is a whole number, clamped into the table.
    fn gather(table: &[f32], index: Self) -> Self;
    /// Square root; negative arguments count as 0.
    fn sqrt(self) -> Self;
    /// Magnitude.
    fn abs(self) -> Self;
    /// Largest whole number not above.
    fn floor(self) -> Self;
    /// Natural exponential.
    fn exp(self) -> Self;
    /// `exp(x) - 1` without cancellation.
    fn exp_m1(self) -> Self;
    /// Natural logarithm.
    fn ln(self) -> Self;
    /// Sine and cosine, radians.
    fn sin_cos(self) -> (Self, Self);
    /// The smaller; the other one if one is NaN.
    fn min(self, other: Self) -> Self;
    /// The larger; the other one if one is NaN.
    fn max(self, other: Self) -> Self;
    /// `self < other`.
    fn lt(self, other: Self) -> Self::Mask;
    /// `self <= other`.
    fn le(self, other: Self) -> Self::Mask;
    /// `self > other`.
    fn gt(self, other: Self) -> Self::Mask {
        other.lt(self)
    }
    /// `self >= other`.
    fn ge(self, other: Self) -> Self::Mask {
        other.le(self)
    }
    /// `self == other`.
    fn eq(self, other: Self) -> Self::Mask;
    /// `a` where the mask holds, `b` elsewhere. Both are evaluated: guard operands, not results.
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self;
    /// Neither infinite nor NaN.
    fn is_finite(self) -> Self::Mask;

    /// 0.
    fn zero() -> Self {
        Self::of(0.0)
    }
    /// 1.
    fn one() -> Self {
        Self::of(1.0)
    }
    /// Clamped to `[0, 1]`.
    fn sat(self) -> Self {
        self.max(Self::zero()).min(Self::one())
    }
    /// `self + t (b - self)`.
    fn lerp(self, b: Self, t: Self) -> Self {
        self + t * (b - self)
    }
    /// Square.
    fn sqr(self) -> Self {
        self * self
    }
}

macro_rules! scalar_lanes {
    ($t:ty, $alpha_min:expr) => {
        impl Lanes for $t {
            type Mask = bool;
            const WIDTH: usize = 1;
            const ALPHA_MIN: f64 = $alpha_min;
            #[inline(always)]
            fn of(x: f64) -> Self {
                x as Self
            }
            #[inline(always)]
            fn from_fn(mut f: impl FnMut(usize) -> f32) -> Self {
                Self::from(f(0))
            }
            #[inline(always)]
            fn lane(self, _: usize) -> f32 {
                self as f32
            }
            #[inline(always)]
            fn map(self, f: impl Fn(f64) -> f64) -> Self {
                f(f64::from(self)) as Self
            }
            #[inline(always)]
            fn gather(table: &[f32], index: Self) -> Self {
                let last = table.len() - 1;
                Self::from(table[(index as usize).min(last)])
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                Self::sqrt(self.max(0.0))
            }
            #[inline(always)]
            fn abs(self) -> Self {
                Self::abs(self)
            }
            #[inline(always)]
            fn floor(self) -> Self {
                Self::floor(self)
            }
            #[inline(always)]
            fn exp(self) -> Self {
                Self::exp(self)
            }
            #[inline(always)]
            fn exp_m1(self) -> Self {
                Self::exp_m1(self)
            }
            #[inline(always)]
            fn ln(self) -> Self {
                Self::ln(self)
            }
            #[inline(always)]
            fn sin_cos(self) -> (Self, Self) {
                Self::sin_cos(self)
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                Self::min(self, other)
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                Self::max(self, other)
            }
            #[inline(always)]
            fn lt(self, other: Self) -> bool {
                self < other
            }
            #[inline(always)]
            fn le(self, other: Self) -> bool {
                self <= other
            }
            #[inline(always)]
            fn eq(self, other: Self) -> bool {
                self == other
            }
            #[inline(always)]
            fn select(mask: bool, a: Self, b: Self) -> Self {
                if mask { a } else { b }
            }
            #[inline(always)]
            fn is_finite(self) -> bool {
                Self::is_finite(self)
            }
        }
    };
}

scalar_lanes!(f32, 1e-4);
scalar_lanes!(f64, 1e-4);

impl Mask for bool {
    #[inline(always)]
    fn splat(x: bool) -> Self {
        x
    }
    #[inline(always)]
    fn any(self) -> bool {
        self
    }
    #[inline(always)]
    fn all(self) -> bool {
        self
    }
    #[inline(always)]
    fn lane(self, _: usize) -> bool {
        self
    }
    #[inline(always)]
    fn from_fn(mut f: impl FnMut(usize) -> bool) -> Self {
        f(0)
    }
}

/// `N` single-precision lanes.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub struct Wide<const N: usize>(pub [f32; N]);

/// `N` truth values, held as all-ones or zero words so that selects become bit operations.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub struct WideMask<const N: usize>([u32; N]);

#[inline(always)]
fn each<const N: usize, T>(f: impl FnMut(usize) -> T) -> [T; N] {
    std::array::from_fn(f)
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
        self.0.iter().fold(0, |a, b| a | b) != 0
    }
    #[inline(always)]
    fn all(self) -> bool {
        self.0.iter().fold(u32::MAX, |a, b| a & b) != 0
    }
    #[inline(always)]
    fn lane(self, i: usize) -> bool {
        self.0[i] != 0
    }
    #[inline(always)]
    fn from_fn(mut f: impl FnMut(usize) -> bool) -> Self {
        Self(each(|i| word(f(i))))
    }
}

impl<const N: usize> Lanes for Wide<N> {
    type Mask = WideMask<N>;
    const WIDTH: usize = N;
    const ALPHA_MIN: f64 = <f32 as Lanes>::ALPHA_MIN;
    #[inline(always)]
    fn of(x: f64) -> Self {
        Self([x as f32; N])
    }
    #[inline(always)]
    fn from_fn(f: impl FnMut(usize) -> f32) -> Self {
        Self(each(f))
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
        let last = table.len() - 1;
        Self(each(|i| table[(index.0[i] as usize).min(last)]))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(each(|i| self.0[i].max(0.0).sqrt()))
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
        Self(each(|i| self.0[i].exp()))
    }
    #[inline(always)]
    fn exp_m1(self) -> Self {
        Self(each(|i| self.0[i].exp_m1()))
    }
    #[inline(always)]
    fn ln(self) -> Self {
        Self(each(|i| self.0[i].ln()))
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let both: [(f32, f32); N] = each(|i| self.0[i].sin_cos());
        (Self(each(|i| both[i].0)), Self(each(|i| both[i].1)))
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

/// A stage of work over many rays that can run at any width. `run` must be `#[inline(always)]`, so that it is compiled
/// with the instructions of the place that [`dispatch`] chooses.
pub trait Kernel {
    /// What the stage returns.
    type Output;
    /// Does the work with lanes of type `L`.
    fn run<L: Lanes>(self) -> Self::Output;
}

/// Runs a kernel at the widest instruction set of this processor. One decision for thousands of rays.
pub fn dispatch<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") && is_x86_feature_detected!("avx512vl") {
            // SAFETY: the processor has just been found to offer these instructions.
            #[expect(unsafe_code, reason = "calls a function compiled for instructions that were detected")]
            return unsafe { run_avx512(kernel) };
        }
        if is_x86_feature_detected!("avx2") {
            // SAFETY: as above.
            #[expect(unsafe_code, reason = "calls a function compiled for instructions that were detected")]
            return unsafe { run_avx2(kernel) };
        }
    }
    kernel.run::<Wide<8>>()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,avx2")]
fn run_avx512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<Wide<16>>()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn run_avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<Wide<8>>()
}

//! Numbers with one or many lanes behind one interface, so that a lobe is written once.
//!
//! `f32` is the readable reference and the twin of the WGSL, `f64` the double-precision check, [`Wide`] and its twin for AVX-512 what
//! the path tracer runs. All lane operations are plain IEEE operations in a fixed order and nothing is contracted, so every width and
//! every instruction set gives the same bits. `unsafe` here: calling a function compiled for more instructions, and
//! the instructions themselves.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, MulAssign, Neg, Not, Sub};

#[cfg(target_arch = "x86_64")]
mod avx512;
mod elementary;
#[cfg(test)]
mod tests;
mod wide;

pub use wide::{Wide, WideMask};

/// The widest number of lanes that a stage runs with.
pub const MAX_LANES: usize = 16;

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
    /// Lane `i` is bit `i`; bits beyond the lanes are 0.
    fn bits(self) -> u32;
    /// The mask with these bits; those beyond the lanes are ignored.
    fn from_bits(bits: u32) -> Self;
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
    /// A single-precision number in every lane.
    fn splat(x: f32) -> Self;
    /// Lanes from single-precision numbers.
    fn from_fn(f: impl FnMut(usize) -> f32) -> Self;
    /// The first numbers of an array.
    fn from_array(x: &[f32; MAX_LANES]) -> Self;
    /// All lanes in single precision, zeros behind them.
    fn to_array(self) -> [f32; MAX_LANES];
    /// One lane in single precision.
    fn lane(self, i: usize) -> f32;
    /// Applies a function to every lane.
    fn map(self, f: impl Fn(f64) -> f64) -> Self;
    /// Reads `table[index]` per lane; the index is a whole number, clamped into the table. An empty one gives zeros.
    fn gather(table: &[f32], index: Self) -> Self;
    /// Reads `table[index[i]]` in lane `i`; indices are clamped into the table. An empty one gives zeros.
    fn gather_at(table: &[f32], index: &[usize; MAX_LANES]) -> Self;
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
    /// `self` if it is smaller, else `other`: so `other` if one is NaN.
    fn lesser(self, other: Self) -> Self;
    /// `self` if it is larger, else `other`: so `other` if one is NaN.
    fn greater(self, other: Self) -> Self;
    /// The least lane in single precision. None may be NaN.
    fn least_lane(self) -> f32;
    /// 2 to the power of a whole number in `[-126, 127]`.
    fn exp2_whole(self) -> Self;
    /// `(m, e)` with `self == m 2^e`, `e` whole and `m` in `[sqrt(1/2), sqrt(2))`, for normal positive numbers.
    fn split_binary(self) -> (Self, Self);
    /// The two half-precision numbers, at least 0, in the lower and the upper bits of each lane, times 2^-112. Sixteen bits of a
    /// half are the leading ones of a single but for its sign and the width of its exponent.
    fn halves(self) -> (Self, Self);
    /// The smaller; the other one if one is NaN.
    fn min(self, other: Self) -> Self;
    /// The larger; the other one if one is NaN.
    fn max(self, other: Self) -> Self;
    /// `self < other`.
    fn lt(self, other: Self) -> Self::Mask;
    /// `self <= other`.
    fn le(self, other: Self) -> Self::Mask;
    /// `self > other`.
    #[inline(always)]
    fn gt(self, other: Self) -> Self::Mask {
        other.lt(self)
    }
    /// `self >= other`.
    #[inline(always)]
    fn ge(self, other: Self) -> Self::Mask {
        other.le(self)
    }
    /// `self == other`.
    fn eq(self, other: Self) -> Self::Mask;
    /// `a` where the mask holds, `b` elsewhere. Both are evaluated: guard operands, not results.
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self;
    /// Neither infinite nor NaN.
    fn is_finite(self) -> Self::Mask;
    /// Runs a routine with the instructions of these lanes, compiled once for all its callers.
    fn call<R: Routine<Self>>(routine: R) -> R::Output;

    /// 0.
    #[inline(always)]
    fn zero() -> Self {
        Self::of(0.0)
    }
    /// 1.
    #[inline(always)]
    fn one() -> Self {
        Self::of(1.0)
    }
    /// Clamped to `[0, 1]`.
    #[inline(always)]
    fn sat(self) -> Self {
        self.max(Self::zero()).min(Self::one())
    }
    /// `self + t (b - self)`.
    #[inline(always)]
    fn lerp(self, b: Self, t: Self) -> Self {
        self + t * (b - self)
    }
    /// Square.
    #[inline(always)]
    fn sqr(self) -> Self {
        self * self
    }
}

macro_rules! scalar_lanes {
    ($t:ty, $alpha_min:expr, { $($own:item)* }) => {
        impl Lanes for $t {
            type Mask = bool;
            const WIDTH: usize = 1;
            const ALPHA_MIN: f64 = $alpha_min;
            #[inline(always)]
            fn of(x: f64) -> Self {
                x as Self
            }
            #[inline(always)]
            fn splat(x: f32) -> Self {
                Self::from(x)
            }
            #[inline(always)]
            fn from_fn(mut f: impl FnMut(usize) -> f32) -> Self {
                Self::from(f(0))
            }
            #[inline(always)]
            fn from_array(x: &[f32; MAX_LANES]) -> Self {
                Self::from(x[0])
            }
            #[inline(always)]
            fn to_array(self) -> [f32; MAX_LANES] {
                let mut x = [0.0; MAX_LANES];
                x[0] = self as f32;
                x
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
                table.get(index as usize).or(table.last()).map_or(0.0, |x| Self::from(*x))
            }
            #[inline(always)]
            fn gather_at(table: &[f32], index: &[usize; MAX_LANES]) -> Self {
                table.get(index[0]).or(table.last()).map_or(0.0, |x| Self::from(*x))
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                Self::sqrt(if self > 0.0 { self } else { 0.0 })
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
            fn lesser(self, other: Self) -> Self {
                if self < other { self } else { other }
            }
            #[inline(always)]
            fn greater(self, other: Self) -> Self {
                if self > other { self } else { other }
            }
            #[inline(always)]
            fn least_lane(self) -> f32 {
                self as f32
            }
            #[inline(always)]
            fn halves(self) -> (Self, Self) {
                let (low, high) = elementary::halves(self as f32);
                (Self::from(low), Self::from(high))
            }
            $($own)*
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
            #[inline(always)]
            fn call<R: Routine<Self>>(routine: R) -> R::Output {
                call_plain(routine)
            }
        }
    };
}

scalar_lanes!(f32, 1e-4, {
    #[inline(always)]
    fn exp2_whole(self) -> Self {
        elementary::exp2_whole(self)
    }
    #[inline(always)]
    fn split_binary(self) -> (Self, Self) {
        elementary::split_binary(self)
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
});
scalar_lanes!(f64, 1e-4, {
    #[inline(always)]
    fn exp2_whole(self) -> Self {
        self.exp2()
    }
    #[inline(always)]
    fn split_binary(self) -> (Self, Self) {
        let exponent = (self.log2() + 0.5).floor();
        (self / exponent.exp2(), exponent)
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
});

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
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self)
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        bits & 1 == 1
    }
}

/// A part of a kernel that is too large to stand in the code of each of its callers. `run` must be `#[inline(always)]`.
pub trait Routine<L: Lanes> {
    /// What it returns.
    type Output;
    /// Does the work.
    fn run(self) -> Self::Output;
}

/// [`Lanes::call`] for lanes that need no further instructions.
#[inline(never)]
fn call_plain<L: Lanes, R: Routine<L>>(routine: R) -> R::Output {
    routine.run()
}

/// Asks for `table[index]`, if there is one, to be brought near: it will be read soon.
#[inline(always)]
pub fn prefetch<T>(table: &[T], index: usize) {
    #[cfg(target_arch = "x86_64")]
    if let Some(value) = table.get(index) {
        avx512::prefetch(value);
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (table, index);
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
        if avx512::is_there() {
            // SAFETY: the processor has just been found to offer these instructions.
            #[expect(unsafe_code, reason = "calls a function compiled for instructions that were detected")]
            return unsafe { run_avx512(kernel) };
        }
        if is_x86_feature_detected!("avx2") {
            // SAFETY: as above.
            #[expect(unsafe_code, reason = "calls a function compiled for instructions that were detected")]
            return unsafe { run_avx2(kernel) };
        }
        // Only old processors come here: not worth a third wide copy of every kernel.
        kernel.run::<f32>()
    }
    #[cfg(not(target_arch = "x86_64"))]
    kernel.run::<Wide<8>>()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,avx2")]
fn run_avx512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<avx512::V16>()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn run_avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<Wide<8>>()
}

//! Vectors and colours with many lanes. Spaces and units are the callers'.

use crate::lanes::{Lanes, Mask};
use std::ops::{Add, Mul, Neg, Sub};

/// A direction or point in three dimensions.
#[derive(Clone, Copy, Debug)]
pub struct V3<L> {
    /// Along the tangent in a local frame.
    pub x: L,
    /// Along the bitangent in a local frame.
    pub y: L,
    /// Along the normal in a local frame.
    pub z: L,
}

/// Linear Rec.709 values per channel.
#[derive(Clone, Copy, Debug)]
pub struct Rgb<L>(pub [L; 3]);

impl<L: Lanes> V3<L> {
    /// From components.
    #[inline(always)]
    pub fn new(x: L, y: L, z: L) -> Self {
        Self { x, y, z }
    }
    /// Dot product.
    #[inline(always)]
    pub fn dot(self, o: Self) -> L {
        self.x * o.x + self.y * o.y + self.z * o.z
    }
    /// Cross product.
    #[inline(always)]
    pub fn cross(self, o: Self) -> Self {
        Self::new(self.y * o.z - self.z * o.y, self.z * o.x - self.x * o.z, self.x * o.y - self.y * o.x)
    }
    /// Times a number.
    #[inline(always)]
    pub fn scale(self, s: L) -> Self {
        Self::new(self.x * s, self.y * s, self.z * s)
    }
    /// Squared length.
    #[inline(always)]
    pub fn length_squared(self) -> L {
        self.dot(self)
    }
    /// Unit vector; vectors shorter than about 1e-18 give `+z`.
    #[inline(always)]
    pub fn normalize(self) -> Self {
        let l2 = self.length_squared();
        let is_short = l2.lt(L::of(1e-36));
        let inverse = L::one() / L::select(is_short, L::one(), l2).sqrt();
        Self::select(is_short, Self::new(L::zero(), L::zero(), L::one()), self.scale(inverse))
    }
    /// `a` where the mask holds, else `b`.
    #[inline(always)]
    pub fn select(mask: L::Mask, a: Self, b: Self) -> Self {
        Self::new(L::select(mask, a.x, b.x), L::select(mask, a.y, b.y), L::select(mask, a.z, b.z))
    }
}

impl<L: Lanes> Add for V3<L> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self::new(self.x + o.x, self.y + o.y, self.z + o.z)
    }
}
impl<L: Lanes> Sub for V3<L> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self::new(self.x - o.x, self.y - o.y, self.z - o.z)
    }
}
impl<L: Lanes> Neg for V3<L> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y, -self.z)
    }
}

impl<L: Lanes> Rgb<L> {
    /// The same value in every channel.
    #[inline(always)]
    pub fn grey(x: L) -> Self {
        Self([x; 3])
    }
    /// No light.
    #[inline(always)]
    pub fn black() -> Self {
        Self::grey(L::zero())
    }
    /// A neutral factor.
    #[inline(always)]
    pub fn white() -> Self {
        Self::grey(L::one())
    }
    /// Applies a function to every channel.
    #[inline(always)]
    pub fn map(self, f: impl Fn(L) -> L) -> Self {
        Self([f(self.0[0]), f(self.0[1]), f(self.0[2])])
    }
    /// Combines two colours channel by channel.
    #[inline(always)]
    pub fn zip(self, o: Self, f: impl Fn(L, L) -> L) -> Self {
        Self([f(self.0[0], o.0[0]), f(self.0[1], o.0[1]), f(self.0[2], o.0[2])])
    }
    /// Times a number.
    #[inline(always)]
    pub fn scale(self, s: L) -> Self {
        self.map(|c| c * s)
    }
    /// Largest channel.
    #[inline(always)]
    pub fn max_channel(self) -> L {
        self.0[0].max(self.0[1]).max(self.0[2])
    }
    /// Smallest channel.
    #[inline(always)]
    pub fn min_channel(self) -> L {
        self.0[0].min(self.0[1]).min(self.0[2])
    }
    /// Rec.709 luminance.
    #[inline(always)]
    pub fn luminance(self) -> L {
        self.0[0] * L::of(0.212_639) + self.0[1] * L::of(0.715_168_7) + self.0[2] * L::of(0.072_192_3)
    }
    /// `a` where the mask holds, else `b`.
    #[inline(always)]
    pub fn select(mask: L::Mask, a: Self, b: Self) -> Self {
        a.zip(b, |a, b| L::select(mask, a, b))
    }
    /// Every channel is finite.
    #[inline(always)]
    pub fn is_finite(self) -> L::Mask {
        self.0[0].is_finite() & self.0[1].is_finite() & self.0[2].is_finite()
    }
    /// Whether any lane holds light.
    #[inline(always)]
    pub fn any(self) -> bool {
        self.max_channel().gt(L::zero()).any()
    }
}

impl<L: Lanes> Add for Rgb<L> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        self.zip(o, |a, b| a + b)
    }
}
impl<L: Lanes> Mul for Rgb<L> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        self.zip(o, |a, b| a * b)
    }
}

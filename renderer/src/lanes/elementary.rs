//! Elementary functions in lane arithmetic: one source for one lane and for many, so the same bits. Within 2 units in the last place
//! of single precision. Polynomials: Moshier, Cephes library, single precision.

use super::{Lanes, Mask};
use std::f64::consts::{FRAC_2_PI, LN_2, LOG2_E};

/// Beyond this, sines and cosines need more digits of pi than the reduction has.
const ANGLE_MAX: f32 = 8192.0;

/// 2 to the power of a whole number in `[-126, 127]`: the number, biased, becomes the exponent.
#[inline(always)]
pub(super) fn exp2_whole(x: f32) -> f32 {
    // Behind 1.5 2^23 the last bits of the significand are the whole number.
    f32::from_bits((x + (12_582_912.0 + 127.0)).to_bits() << 23)
}

/// [`Lanes::halves`] of one lane.
#[inline(always)]
pub(super) fn halves(x: f32) -> (f32, f32) {
    let bits = x.to_bits();
    (f32::from_bits((bits & 0x7fff) << 13), f32::from_bits(((bits >> 16) & 0x7fff) << 13))
}

/// Significand in `[sqrt(1/2), sqrt(2))` and exponent of a normal positive number.
#[inline(always)]
pub(super) fn split_binary(x: f32) -> (f32, f32) {
    const ROOT_HALF: u32 = 0x3f35_04f3;
    let steps = x.to_bits().wrapping_sub(ROOT_HALF);
    (f32::from_bits((steps & 0x007f_ffff).wrapping_add(ROOT_HALF)), (steps as i32 >> 23) as f32)
}

/// Horner's rule, highest power first; written out, because a loop at every use takes the compiler long.
macro_rules! polynomial {
    ($x:expr; $sum:expr) => { $sum };
    ($x:expr; $sum:expr, $next:expr $(, $rest:expr)*) => { polynomial!($x; $sum * $x + L::of($next) $(, $rest)*) };
    ($x:expr, [$first:expr $(, $rest:expr)* $(,)?] $(,)?) => { polynomial!($x; L::of($first) $(, $rest)*) };
}

/// `(p, k)` with `exp(x) = (1 + p) 2^k` and `k` whole, for `x` in `[-110, 90]`.
#[inline(always)]
fn reduced_exp<L: Lanes>(x: L) -> (L, L) {
    let k = (x * L::of(LOG2_E) + L::of(0.5)).floor();
    // ln 2 in two parts: the product with the first is exact.
    const HIGH: f64 = 0.693_359_375;
    let r = (x - k * L::of(HIGH)) - k * L::of(LN_2 - HIGH);
    let p = polynomial!(
        r,
        [1.987_569_15e-4, 1.398_199_950_7e-3, 8.333_451_907_3e-3, 4.166_579_589_4e-2, 1.666_666_545_9e-1, 5.000_000_120_1e-1],
    );
    (p * r * r + r, k)
}

/// Natural exponential.
#[inline(always)]
pub(super) fn exp<L: Lanes>(x: L) -> L {
    let (p, k) = reduced_exp(x.max(L::of(-110.0)).min(L::of(90.0)));
    // In two steps, because 2^k alone may lie outside the normal numbers.
    let half = (k * L::of(0.5)).floor();
    let y = (L::one() + p) * half.exp2_whole() * (k - half).exp2_whole();
    L::select(x.eq(x), y, x)
}

/// `exp(x) - 1` without cancellation.
#[inline(always)]
pub(super) fn exp_m1<L: Lanes>(x: L) -> L {
    let (p, k) = reduced_exp(x.max(L::of(-30.0)).min(L::of(90.0)));
    let half = (k * L::of(0.5)).floor();
    let (a, b) = (half.exp2_whole(), (k - half).exp2_whole());
    // 2^k (1 + p) - 1 = 2^k p + (2^k - 1); above 2^24 the 1 no longer counts.
    let small = a * b * p + (a * b - L::one());
    let y = L::select(k.lt(L::of(24.0)), small, (L::one() + p) * a * b);
    L::select(x.eq(x) & !x.eq(L::zero()), y, x)
}

/// Natural logarithm.
#[inline(always)]
pub(super) fn ln<L: Lanes>(x: L) -> L {
    let is_subnormal = x.lt(L::of(f64::from(f32::MIN_POSITIVE)));
    let scaled = L::select(is_subnormal, x * L::of(33_554_432.0), x);
    let (m, e) = scaled.split_binary();
    let e = L::select(is_subnormal, e - L::of(25.0), e);
    let f = m - L::one();
    let z = f * f;
    let series = polynomial!(
        f,
        [
            7.037_683_629_2e-2,
            -1.151_461_031_0e-1,
            1.167_699_874_0e-1,
            -1.242_014_084_6e-1,
            1.424_932_278_7e-1,
            -1.666_805_766_5e-1,
            2.000_071_476_5e-1,
            -2.499_999_399_3e-1,
            3.333_333_117_4e-1,
        ],
    );
    const HIGH: f64 = 0.693_359_375;
    let y = f * z * series + e * L::of(LN_2 - HIGH) - z * L::of(0.5);
    let y = f + y + e * L::of(HIGH);
    let zero = L::zero();
    let y = L::select(x.eq(zero), L::of(f64::NEG_INFINITY), y);
    let y = L::select(x.eq(L::of(f64::INFINITY)), x, y);
    L::select(x.ge(zero), y, L::of(f64::NAN))
}

/// Sine and cosine, radians. Lanes beyond [`ANGLE_MAX`] take the way of the standard library.
#[inline(always)]
pub(super) fn sin_cos<L: Lanes>(x: L) -> (L, L) {
    let is_near = x.abs().le(L::splat(ANGLE_MAX));
    let near = L::select(is_near, x, L::zero());
    let quadrant = (near * L::of(FRAC_2_PI) + L::of(0.5)).floor();
    // A right angle in three parts: products with the first two are exact.
    let r = ((near - quadrant * L::of(1.570_312_5)) - quadrant * L::of(4.837_512_969_970_703e-4))
        - quadrant * L::of(7.549_789_954_891_9e-8);
    let z = r * r;
    let s = polynomial!(z, [-1.951_529_589_1e-4, 8.332_160_873_6e-3, -1.666_665_461_1e-1]) * z * r + r;
    let c = polynomial!(z, [2.443_315_711_809_948e-5, -1.388_731_625_493_765e-3, 4.166_664_568_298_827e-2]) * z * z
        - z * L::of(0.5)
        + L::one();
    let turn = quadrant - (quadrant * L::of(0.25)).floor() * L::of(4.0);
    let is = |q: f64| turn.eq(L::of(q));
    let is_swapped = is(1.0) | is(3.0);
    let (a, b) = (L::select(is_swapped, c, s), L::select(is_swapped, s, c));
    let sin = L::select(is(2.0) | is(3.0), -a, a);
    let cos = L::select(is(1.0) | is(2.0), -b, b);
    if is_near.all() {
        return (sin, cos);
    }
    let far = L::select(is_near, L::zero(), x);
    (L::select(is_near, sin, far.map(f64::sin)), L::select(is_near, cos, far.map(f64::cos)))
}

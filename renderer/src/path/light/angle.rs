//! Angles for places on a map: polynomials, the same bits at any width.

use crate::lanes::Lanes;
use std::f64::consts::{PI, TAU};

/// Sine and cosine of a number of turns in `[0, 1]`. Taylor series on an eighth of a turn; error below 2e-7.
#[inline(always)]
pub(in crate::path) fn sin_cos_turn<L: Lanes>(turn: L) -> (L, L) {
    let quadrant = (turn * L::of(4.0) + L::of(0.5)).floor();
    let x = (turn - quadrant * L::of(0.25)) * L::of(TAU);
    let x2 = x * x;
    let s = x
        * (L::one()
            + x2 * (L::of(-1.0 / 6.0) + x2 * (L::of(1.0 / 120.0) + x2 * (L::of(-1.0 / 5040.0) + x2 * L::of(1.0 / 362_880.0)))));
    let c = L::one() + x2 * (L::of(-0.5) + x2 * (L::of(1.0 / 24.0) + x2 * (L::of(-1.0 / 720.0) + x2 * L::of(1.0 / 40_320.0))));
    let is = |q: f64| quadrant.eq(L::of(q));
    let is_swapped = is(1.0) | is(3.0);
    let (a, b) = (L::select(is_swapped, c, s), L::select(is_swapped, s, c));
    (L::select(is(2.0) | is(3.0), -a, a), L::select(is(1.0) | is(2.0), -b, b))
}

/// Angle of the point (x, y) from the x axis, radians, `[-pi, pi]`. Odd polynomial of Abramowitz and Stegun's kind on `[0, 1]` after
/// a reduction by 45 degrees; error below 3e-7.
#[inline(always)]
pub(super) fn atan2<L: Lanes>(y: L, x: L) -> L {
    let (ax, ay) = (x.abs(), y.abs());
    let (large, small) = (ax.max(ay), ax.min(ay));
    let is_zero = large.le(L::zero());
    let r = small / L::select(is_zero, L::one(), large);
    // atan(r) = pi/8 + atan((r - k) / (1 + k r)) with k = tan(pi/8), for r above k/2: the argument then stays below 0.415.
    let k = L::of(0.414_213_562_373_095_03);
    let is_upper = r.gt(L::of(0.207));
    let z = L::select(is_upper, (r - k) / (L::one() + k * r), r);
    let z2 = z * z;
    let series = L::one()
        + z2 * (L::of(-1.0 / 3.0)
            + z2 * (L::of(0.2)
                + z2 * (L::of(-1.0 / 7.0) + z2 * (L::of(1.0 / 9.0) + z2 * (L::of(-1.0 / 11.0) + z2 * L::of(1.0 / 13.0))))));
    let a = z * series + L::select(is_upper, L::of(PI / 8.0), L::zero());
    let a = L::select(ay.gt(ax), L::of(PI / 2.0) - a, a);
    let a = L::select(x.lt(L::zero()), L::of(PI) - a, a);
    L::select(y.lt(L::zero()), -a, a)
}

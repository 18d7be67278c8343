//! The coat's tint of what lies below, and its frame. Its reflection is an ordinary GGX lobe. Twin of `coat.wgsl`.

use crate::lanes::Lanes;
use crate::vector::{Rgb, V3};

/// Exponent of the coat tint for one passage at cosine `mu`: longer at grazing angles. Model reference 8.3.
#[inline(always)]
pub fn coat_exponent<L: Lanes>(mu: L) -> L {
    L::of(0.25) + L::of(0.1575) / L::of(0.24).lerp(L::one(), mu * mu)
}

/// Factor on light that passes the coat once at cosine `mu`; `ln_tint` is the logarithm of the tint, at least `ln 1e-6`.
#[inline(always)]
pub fn coat_passage<L: Lanes>(ln_tint: Rgb<L>, mu: L) -> Rgb<L> {
    let p = coat_exponent(mu);
    let Rgb([r, g, b]) = ln_tint.scale(p);
    Rgb([r.exp(), g.exp(), b.exp()])
}

/// Axes of a coat with normals of its own, in the frame of the base. Which tangents does not matter: the coat is isotropic.
#[derive(Clone, Copy, Debug)]
pub struct CoatFrame<L> {
    t: V3<L>,
    b: V3<L>,
    n: V3<L>,
}

impl<L: Lanes> CoatFrame<L> {
    /// Axes about a unit normal. Source: Duff et al. 2017.
    #[inline(always)]
    pub fn new(n: V3<L>) -> Self {
        let sign = L::select(n.z.lt(L::zero()), -L::one(), L::one());
        let a = -(L::one() / (sign + n.z));
        let b = n.x * n.y * a;
        let t = V3::new(L::one() + sign * n.x * n.x * a, sign * b, -(sign * n.x));
        Self { t, b: V3::new(b, sign + n.y * n.y * a, -n.y), n }
    }

    /// A direction of the base's frame in this one.
    #[inline(always)]
    pub fn local(&self, w: V3<L>) -> V3<L> {
        V3::new(w.dot(self.t), w.dot(self.b), w.dot(self.n))
    }

    /// A direction of this frame in the base's.
    #[inline(always)]
    pub fn outer(&self, w: V3<L>) -> V3<L> {
        self.t.scale(w.x) + self.b.scale(w.y) + self.n.scale(w.z)
    }
}

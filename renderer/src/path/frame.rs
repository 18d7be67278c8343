//! Local frames at hits: interpolated attributes, texture coordinates across a triangle, and normals bent so that the viewer is on the
//! right side.

use super::geometry::{Geometry, Vertex};
use super::sampler::MAX_LANES;
use crate::bvh::Hit;
use crate::lanes::{Lanes, Mask};
use crate::vector::V3;

/// Least cosine between shading normal and viewer.
const COS_VIEWER_MIN: f64 = 1e-3;

/// What lies at the hits of one group of lanes, world space in normalised units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point<L> {
    /// The hit, from the vertices: nearer to the surface than the ray's end.
    pub position: V3<L>,
    /// Geometric normal, outwards.
    pub ng: V3<L>,
    /// Interpolated normal, on the side of the geometric one.
    pub n: V3<L>,
    /// Interpolated tangent, and the sign of the bitangent.
    pub tangent: (V3<L>, L),
    /// Texture coordinate.
    pub uv: [L; 2],
}

/// Axes of the shading frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame<L> {
    /// Tangent, x.
    pub t: V3<L>,
    /// Bitangent, y.
    pub b: V3<L>,
    /// Normal, z.
    pub n: V3<L>,
}

impl<L: Lanes> Frame<L> {
    /// World direction into the frame.
    #[inline(always)]
    pub(super) fn local(&self, w: V3<L>) -> V3<L> {
        V3::new(w.dot(self.t), w.dot(self.b), w.dot(self.n))
    }

    /// Local direction into the world.
    #[inline(always)]
    pub(super) fn world(&self, w: V3<L>) -> V3<L> {
        self.t.scale(w.x) + self.b.scale(w.y) + self.n.scale(w.z)
    }

    /// A frame with any tangent. Source: Duff et al. 2017.
    #[inline(always)]
    pub(super) fn around(n: V3<L>) -> Self {
        let one = L::one();
        let sign = L::select(n.z.lt(L::zero()), -one, one);
        let a = -(one / (sign + n.z));
        let b = n.x * n.y * a;
        Self { t: V3::new(one + sign * n.x * n.x * a, sign * b, -(sign * n.x)), b: V3::new(b, sign + n.y * n.y * a, -n.y), n }
    }

    /// A frame along the tangent of the mesh; any tangent where it is parallel to the normal.
    #[inline(always)]
    pub(super) fn along(n: V3<L>, (tangent, sign): (V3<L>, L)) -> Self {
        let t = tangent - n.scale(n.dot(tangent));
        let is_short = t.length_squared().lt(L::of(1e-12));
        let t = V3::select(is_short, Self::around(n).t, t).normalize();
        Self { t, b: n.cross(t).scale(sign), n }
    }
}

/// Attributes at the hits. Tangents and texture coordinates are read only where asked for.
#[inline(always)]
pub(super) fn point<L: Lanes>(geometry: &Geometry, hits: &[Hit; MAX_LANES], needs_tangent: bool, needs_uv: bool) -> Point<L> {
    // Places of the corners and of the triangles in the flat tables.
    let mut corners = [[0usize; MAX_LANES]; 3];
    let mut triangle = [0usize; MAX_LANES];
    for i in 0..L::WIDTH {
        triangle[i] = hits[i].triangle as usize * 3;
        let t = &geometry.triangles[hits[i].triangle as usize];
        for c in 0..3 {
            corners[c][i] = t[c] as usize * size_of::<Vertex>() / size_of::<f32>();
        }
    }
    let u = L::from_fn(|i| hits[i].u);
    let v = L::from_fn(|i| hits[i].v);
    let w = L::one() - u - v;
    let (vertices, normals) = (geometry.vertices.as_flattened(), geometry.normals.as_flattened());
    let weights = [w, u, v];
    let ng =
        V3::new(L::gather_at(normals, &triangle), L::gather_at(&normals[1..], &triangle), L::gather_at(&normals[2..], &triangle));
    let n = weighted_vector(vertices, 3, &corners, weights);
    let n = V3::select(n.length_squared().lt(L::of(1e-12)), ng, n.normalize());
    let n = V3::select(n.dot(ng).lt(L::zero()), -n, n);
    let tangent = if needs_tangent {
        let w = weighted(&vertices[9..], &corners, weights);
        (weighted_vector(vertices, 6, &corners, weights), L::select(w.lt(L::zero()), -L::one(), L::one()))
    } else {
        (V3::new(L::one(), L::zero(), L::zero()), L::one())
    };
    let uv = if needs_uv {
        [weighted(&vertices[10..], &corners, weights), weighted(&vertices[11..], &corners, weights)]
    } else {
        [L::zero(); 2]
    };
    Point { position: weighted_vector(vertices, 0, &corners, weights), ng, n, tangent, uv }
}

/// A number of three corners, weighted.
#[inline(always)]
fn weighted<L: Lanes>(table: &[f32], corners: &[[usize; MAX_LANES]; 3], [a, b, c]: [L; 3]) -> L {
    L::gather_at(table, &corners[0]) * a + L::gather_at(table, &corners[1]) * b + L::gather_at(table, &corners[2]) * c
}

/// A vector of three corners, weighted: the numbers from `k` of a vertex.
#[inline(always)]
fn weighted_vector<L: Lanes>(table: &[f32], k: usize, corners: &[[usize; MAX_LANES]; 3], weights: [L; 3]) -> V3<L> {
    V3::new(
        weighted(&table[k..], corners, weights),
        weighted(&table[k + 1..], corners, weights),
        weighted(&table[k + 2..], corners, weights),
    )
}

/// Two edges of the triangles that were hit, in the world and in uv.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span<L> {
    /// From the first corner, normalised units.
    pub edges: [V3<L>; 2],
    /// The same edges in uv.
    pub uv: [[L; 2]; 2],
}

/// The triangles at the hits.
#[inline(always)]
pub(super) fn span<L: Lanes>(geometry: &Geometry, hits: &[Hit; MAX_LANES]) -> Span<L> {
    let mut corners = [[0usize; MAX_LANES]; 3];
    for i in 0..L::WIDTH {
        let t = &geometry.triangles[hits[i].triangle as usize];
        for c in 0..3 {
            corners[c][i] = t[c] as usize;
        }
    }
    let edge = |c: usize, k: usize| L::from_fn(|i| geometry.vertices[corners[c][i]][k] - geometry.vertices[corners[0][i]][k]);
    Span { edges: [1, 2].map(|c| V3::new(edge(c, 0), edge(c, 1), edge(c, 2))), uv: [1, 2].map(|c| [edge(c, 10), edge(c, 11)]) }
}

impl<L: Lanes> Span<L> {
    /// Length in uv of a short way on the triangle, over all directions: the root of the ratio of areas. 0 without an area.
    #[inline(always)]
    pub(super) fn uv_length(&self, width: L) -> L {
        let [[a, b], [c, d]] = self.uv;
        let area = self.edges[0].cross(self.edges[1]).length_squared().sqrt();
        let ratio = (a * d - b * c).abs() / area.max(L::of(1e-30));
        width * ratio.sqrt()
    }

    /// Slopes along the tangent and the bitangent of a quantity whose derivatives by u and v are given; zeros where the triangle, seen
    /// along the normal, has no area.
    ///
    /// The edges are looked at in the tangent plane, so a displaced triangle counts as the flat one that it was made from.
    #[inline(always)]
    pub(super) fn slopes(&self, frame: &Frame<L>, by_uv: [L; 2]) -> [L; 2] {
        let [e, f] = self.edges.map(|e| [e.dot(frame.t), e.dot(frame.b)]);
        let [de, df] = self.uv.map(|uv| by_uv[0] * uv[0] + by_uv[1] * uv[1]);
        let area = e[0] * f[1] - e[1] * f[0];
        let lengths = (e[0] * e[0] + e[1] * e[1]).sqrt() * (f[0] * f[0] + f[1] * f[1]).sqrt();
        let is_flat = area.abs().le(lengths * L::of(1e-6)) | area.abs().lt(L::of(1e-30));
        let inverse = L::one() / L::select(is_flat, L::one(), area);
        let slope = |x: L| {
            // Steeper than this all slopes look alike, and squares stay numbers.
            let x = x * inverse;
            L::select(x.eq(x) & !is_flat, x.max(L::of(-1e8)).min(L::of(1e8)), L::zero())
        };
        [slope(de * f[1] - df * e[1]), slope(df * e[0] - de * f[0])]
    }
}

/// Strength of a normal map on a direction of the tangent frame (model reference 13): above 1 the slopes grow, below 1 the angle shrinks.
#[inline(always)]
pub(super) fn scale_normal<L: Lanes>(n: [L; 3], scale: f64) -> V3<L> {
    // Divided by the largest component first: squares of what a file may hold would overflow.
    let largest = n[0].abs().max(n[1].abs()).max(n[2].abs()).max(L::of(1e-30));
    let n = V3::new(n[0] / largest, n[1] / largest, n[2] / largest).normalize();
    let flat = V3::new(L::zero(), L::zero(), L::one());
    let slope = (n.x * n.x + n.y * n.y).sqrt();
    let is_flat = slope.lt(L::of(1e-8)) | !slope.is_finite();
    if scale > 1.0 {
        let scale = L::of(scale.min(1e8));
        return V3::select(is_flat, flat, V3::new(n.x * scale, n.y * scale, n.z).normalize());
    }
    // The angle to z, by a half-angle arc tangent that the lanes offer as a map: normal maps are rare and this is exact.
    let mut sine = [0.0f32; MAX_LANES];
    let mut cosine = [0.0f32; MAX_LANES];
    for i in 0..L::WIDTH {
        let (s, c) = (slope.lane(i).atan2(n.z.lane(i)) * scale.max(0.0) as f32).sin_cos();
        (sine[i], cosine[i]) = (s, c);
    }
    let factor = L::from_fn(|i| sine[i]) / L::select(is_flat, L::one(), slope);
    V3::select(is_flat, flat, V3::new(n.x * factor, n.y * factor, L::from_fn(|i| cosine[i])))
}

/// The shading normal, bent where the viewer (`wo`, on the side `is_front` of the geometric normal) would see its back.
#[inline(always)]
pub(super) fn facing<L: Lanes>(n: V3<L>, wo: V3<L>, is_front: L::Mask) -> V3<L> {
    let sign = L::select(is_front, L::one(), -L::one());
    let cosine = sign * wo.dot(n);
    let lack = L::of(COS_VIEWER_MIN) - cosine;
    let is_back = lack.gt(L::zero());
    if !is_back.any() {
        return n;
    }
    V3::select(is_back, (n + wo.scale(sign * lack)).normalize(), n)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn v(x: f32, y: f32, z: f32) -> V3<f32> {
        V3::new(x, y, z).normalize()
    }

    #[test]
    fn frames_are_orthonormal() {
        for n in [v(0.0, 0.0, 1.0), v(0.0, 0.0, -1.0), v(1.0, 2.0, -3.0), v(1.0, 0.0, 0.0), v(0.0, -1.0, 1e-4)] {
            for f in [Frame::around(n), Frame::along(n, (v(1.0, 0.3, 0.0), 1.0)), Frame::along(n, (n, 1.0))] {
                for (a, b) in [(f.t, f.b), (f.t, f.n), (f.b, f.n)] {
                    assert!(a.dot(b).abs() < 1e-5, "{f:?}");
                }
                for a in [f.t, f.b, f.n] {
                    assert!((a.length_squared() - 1.0).abs() < 1e-5, "{f:?}");
                }
                assert!(f.t.cross(f.b).dot(f.n) > 0.999, "{f:?}");
            }
        }
    }

    #[test]
    fn normals_scale_as_specified() {
        let n = [0.6f32, 0.0, 0.8];
        let angle = |n: V3<f32>| n.x.atan2(n.z);
        assert!((angle(scale_normal(n, 1.0)) - 0.6f32.atan2(0.8)).abs() < 1e-6);
        assert!((angle(scale_normal(n, 0.5)) - 0.5 * 0.6f32.atan2(0.8)).abs() < 1e-6);
        assert!((angle(scale_normal(n, 2.0)) - 1.2f32.atan2(0.8)).abs() < 1e-6);
        assert_eq!(angle(scale_normal(n, 0.0)), 0.0);
        assert_eq!(angle(scale_normal([0.0f32; 3], 1.0)), 0.0);
        assert_eq!(angle(scale_normal(n, -2.0)), 0.0);
        assert_eq!(angle(scale_normal([f32::NAN, 0.0, 1.0], 1.0)), 0.0);
        assert!((angle(scale_normal(n.map(|x| x * 1e30), 1.0)) - 0.6f32.atan2(0.8)).abs() < 1e-6);
        assert!((angle(scale_normal(n, 1e300)) - std::f32::consts::FRAC_PI_2).abs() < 1e-6);
    }

    #[test]
    fn bent_normals_face_the_viewer() {
        for (wo, n) in
            [(v(1.0, 0.0, 0.05), v(-0.5, 0.0, 1.0)), (v(1.0, 0.0, -0.05), v(0.5, 0.0, 1.0)), (v(0.0, 0.0, 1.0), v(0.0, 0.0, 1.0))]
        {
            let is_front = wo.z > 0.0;
            let bent = facing(n, wo, is_front);
            let cosine = bent.dot(wo) * if is_front { 1.0 } else { -1.0 };
            assert!(cosine > 0.9e-3, "{cosine}");
        }
    }
}

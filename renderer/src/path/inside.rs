//! Light that scattering bodies send straight out: one collision of each walk is connected to the environment through the surface.
//!
//! The end of a walk alone would find a small light rarely: it leaves in any direction, and what a nearly smooth surface makes of that
//! direction is hardly left to choose. So the connection is built the other way round. A direction to the light is drawn first; it is
//! refracted inwards at a facet of the nearest surface, which gives the direction in which light would have to leave the collision; a
//! ray in that direction finds where it crosses the surface, and there the BSDF says how much of it takes the way to the light.
//!
//! The walk's own exits find the same light. Each direction to the light is shared out between the two by a weight of its own, the
//! balance heuristic with a constant in the place of the exits' density ([`EXIT_DENSITY`]): any weights that sum to 1 are unbiased, and
//! these need to know nothing of the walk.

use super::PassStats;
use super::batch::{Batch, Paths, Shadows};
use super::detail::{Footprint, Shading};
use super::frame::{Frame, Point, point, span};
use super::light::Light;
use super::prepared::{Prepared, Surface};
use super::sampler::{Group, MAX_LANES, Words, draw, per_lane};
use super::shade::{lane_of, lane_vector, leave, wavelength};
use super::walk::{Boundary, Interior, Source};
use crate::bsdf::ggx::{d_ggx, refract, smith_length, vndf_pdf, vndf_sample};
use crate::bsdf::{Bsdf, View, interpret};
use crate::bvh::{Hit, NONE, Ray};
use crate::lanes::{Kernel, Lanes, Mask};
use crate::vector::{Rgb, V3};
use burnish_material::Lobe;
use glam::Vec3;
use std::f64::consts::PI;

/// Density, 1/sr, that the exits of walks count with where they share light with connections: uniform over a hemisphere.
pub(super) const EXIT_DENSITY: f64 = 0.5 / PI;
/// Least cosine inside between the surface and what connections send to it. Flatter light is left to the exits: hardly any of it crosses
/// the surface, and connections, which come from outside, find it where their density has only its tails.
pub(super) const COS_INSIDE_MIN: f64 = 0.5;
/// Least cosine between the normals of the surface nearest to a collision and of the surface where its light leaves.
const COS_NORMALS_MIN: f32 = 0.94;
/// Smallest roughness (alpha) of a surface through which bodies are connected: the normals of the nearest surface and of the point of
/// exit differ, and narrow lobes do not forgive that.
const ALPHA_MIN: f64 = 0.03;
/// Smallest roughness for the direction of a connection, for the same reason.
const ALPHA_DRAWN_MIN: f64 = 0.08;
/// What the depth, in radii of the body, adds to it.
const ALPHA_PER_DEPTH: f32 = 0.3;
/// Shares of connections refracted at a very rough surface, and of those that leave in any direction: they bound the weights where the
/// nearest surface tells little or nothing of the point of exit.
const BROAD_SHARE: f64 = 0.2;
const UNIFORM_SHARE: f64 = 0.05;
/// Roughness (alpha) of the very rough surface.
const ALPHA_BROAD: f64 = 0.5;
/// Connections of a walk: one collision is connected to several lights.
pub(super) const CONNECTIONS: u32 = 2;
/// Share of the lights drawn for the surface nearest to the collision; the others are drawn from everywhere.
const EVEN_SHARE: f64 = 0.85;
/// Least cosine between the light and the normal that the light is refracted at.
const COS_LIGHT_MIN: f32 = 0.05;

/// How a surface refracts, as far as it decides where connections go.
#[derive(Clone, Copy, Debug)]
pub(super) struct Passage {
    alpha: f32,
    eta: f32,
}

impl Passage {
    /// None for surfaces through which nothing is connected.
    pub(super) fn of(surface: &Surface) -> Option<Self> {
        if !surface.lobes.has(Lobe::scattering) {
            return None;
        }
        let optics = interpret(&surface.inputs, surface.lobes, surface.length_scale);
        let alpha = optics.alpha_x.max(optics.alpha_y);
        let is_rough = alpha >= ALPHA_MIN && !optics.is_smooth && !optics.is_matched;
        is_rough.then_some(Self { alpha: alpha.max(ALPHA_DRAWN_MIN) as f32, eta: optics.eta as f32 })
    }
}

impl Passage {
    /// The same for a collision at a depth, as a share of the body's radius: the deeper, the less the nearest surface tells of the point of
    /// exit.
    pub(super) fn over(self, depth: f32) -> Self {
        Self { alpha: (self.alpha + ALPHA_PER_DEPTH * depth).min(1.0), ..self }
    }
}

/// A connection under way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Connection {
    /// The path that gets the light.
    path: u32,
    /// Number among those of its walk, below [`CONNECTIONS`].
    number: u32,
    /// The collision.
    source: Source,
    /// Extinction in the body.
    extinction: [f32; 3],
    passage: Passage,
    /// Numbers for the facet, and for whether it is asked at all.
    u: [f32; 3],
    /// Direction in which it leaves the collision.
    direction: Vec3,
    /// Direction to the light.
    light: Vec3,
    /// What arrives if nothing is in the way: the light times everything but the BSDF.
    weight: [f32; 3],
    /// Where it leaves the body.
    exit: Hit,
}

impl Connection {
    /// From a collision; `u` are three numbers in `[0, 1)`.
    pub(super) fn new(path: u32, number: u32, source: Source, extinction: [f32; 3], passage: Passage, u: [f32; 3]) -> Self {
        let (direction, light) = (Vec3::ZERO, Vec3::ZERO);
        Self { path, number, source, extinction, passage, u, direction, light, weight: [0.0; 3], exit: Hit::MISS }
    }
}

/// Makes all connections of a batch at one depth into shadow rays.
pub(super) fn connect(prepared: &Prepared, batch: &mut Batch, vertex: u32, stats: &mut PassStats) {
    let Batch { paths, inside, lists, shadows, .. } = batch;
    crate::lanes::dispatch(Aim { prepared, vertex, paths, connections: inside });
    inside.retain_mut(|connection| connection.weight.iter().any(|w| *w > 0.0) && leave_body(prepared, connection));
    lists.iter_mut().for_each(Vec::clear);
    for (i, connection) in inside.iter().enumerate() {
        let object = prepared.geometry.triangles[connection.exit.triangle as usize][3];
        lists[prepared.surface_of_object[object as usize] as usize].push(i as u32);
    }
    for (surface, list) in prepared.surfaces.iter().zip(lists.iter()) {
        if !list.is_empty() {
            crate::lanes::dispatch(Emerge { prepared, surface, list, connections: inside, paths, shadows, stats });
        }
    }
    inside.clear();
}

/// Whether connections, and not the exits of walks, bring light to a collision from where `hit` lies: on a surface whose normal is much
/// that of the nearest surface, `normal`. Beyond an edge the nearest surface tells nothing.
pub(super) fn reaches(prepared: &Prepared, normal: Vec3, hit: &Hit) -> bool {
    let at_exit = prepared.geometry.normals.get(hit.triangle as usize);
    at_exit.is_some_and(|n| Vec3::from(*n).dot(normal) >= COS_NORMALS_MIN)
}

/// Follows a connection to the surface. False: it does not arrive where connections serve.
fn leave_body(prepared: &Prepared, connection: &mut Connection) -> bool {
    let geometry = prepared.geometry.as_ref();
    let hit = Interior::new(geometry, NONE).hit(connection.source.position, connection.direction, f32::INFINITY);
    let is_leaving = |n: &[f32; 3]| Vec3::from(*n).dot(connection.direction) > 0.0;
    let is_inside = geometry.normals.get(hit.triangle as usize).is_some_and(is_leaving);
    if !is_inside || !reaches(prepared, connection.source.normal, &hit) {
        return false;
    }
    for k in 0..3 {
        connection.weight[k] *= (-connection.extinction[k] * hit.t).exp();
    }
    connection.exit = hit;
    true
}

/// Draws directions to the light and the directions inside that lead there.
struct Aim<'a> {
    prepared: &'a Prepared,
    vertex: u32,
    paths: &'a Paths,
    connections: &'a mut [Connection],
}

impl Kernel for Aim<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { prepared, vertex, paths, connections } = self;
        for group in connections.chunks_mut(L::WIDTH) {
            let at = |i: usize| &group[if i < group.len() { i } else { 0 }];
            let seeds: Words = per_lane(0, |i| paths.seeds[at(i).path as usize]);
            let indices: Words = per_lane(0, |i| paths.indices[at(i).path as usize]);
            let indices: Words = per_lane(0, |i| indices[i].wrapping_mul(CONNECTIONS).wrapping_add(at(i).number));
            let choice: [L; 4] = draw(Group::LightCandidate, vertex, &seeds, &indices);
            let normal = |k: usize| L::from_fn(|i| at(i).source.normal[k]);
            let light = shone_on(&prepared.light, V3::new(normal(0), normal(1), normal(2)), choice);
            let share = L::select(light.pdf.gt(L::zero()), light.share / (light.pdf * L::of(f64::from(CONNECTIONS))), L::zero());
            let normals = per_lane([0.0; 3], |i| {
                let interior = Interior::new(&prepared.geometry, paths.body[at(i).path as usize]);
                exit_normal(&interior, at(i), lane_vector(light.direction, i)).to_array()
            });
            let n = |k: usize| L::from_fn(|i| normals[i][k]);
            let frame = Frame::around(V3::new(n(0), n(1), n(2)));
            let lobe = Lobes {
                wo: frame.local(light.direction),
                alpha: L::from_fn(|i| at(i).passage.alpha),
                eta: L::from_fn(|i| at(i).passage.eta),
            };
            let (inwards, pdf) = lobe.sample([0, 1, 2].map(|k| L::from_fn(|i| at(i).u[k])));
            // Isotropic: 1/(4 pi) in every direction.
            let scale = share / (pdf * L::of(4.0 * PI)).max(L::of(1e-30));
            let throughput = Rgb([0, 1, 2].map(|k| L::from_fn(|i| at(i).source.throughput[k])));
            let weight = (light.radiance * throughput).scale(L::select(pdf.gt(L::zero()), scale, L::zero()));
            let direction = frame.world(-inwards).normalize();
            for (i, connection) in group.iter_mut().enumerate() {
                connection.direction = lane_vector(direction, i);
                connection.light = lane_vector(light.direction, i);
                connection.weight = lane_of(weight, i);
            }
        }
    }
}

/// A light for a connection.
struct Shone<L> {
    direction: V3<L>,
    radiance: Rgb<L>,
    /// Density, 1/sr.
    pdf: L,
    /// What connections bring of this light; the rest is left to exits.
    share: L,
}

/// Draws a light for a surface with a unit normal, which is known roughly.
#[inline(always)]
fn shone_on<L: Lanes>(light: &Light, normal: V3<L>, u: [L; 4]) -> Shone<L> {
    let plain = light.sample(u[0], u[1]);
    let exits = L::of(EXIT_DENSITY);
    let Some(facing) = light.facing(normal) else {
        let share = plain.pdf / (plain.pdf + exits);
        return Shone { direction: plain.direction, radiance: plain.radiance, pdf: plain.pdf, share };
    };
    let even = light.sample_facing(&facing, [u[0], u[1], u[2] * L::of(1.0 / EVEN_SHARE)]);
    let is_even = u[2].lt(L::of(EVEN_SHARE));
    let direction = V3::select(is_even, even.direction, plain.direction);
    let pdf_plain = L::select(is_even, light.eval(direction).1, plain.pdf);
    let pdf_even = L::select(is_even, even.pdf, light.eval_facing(&facing, direction).1);
    Shone {
        direction,
        radiance: Rgb::select(is_even, even.radiance, plain.radiance),
        pdf: L::of(EVEN_SHARE) * pdf_even + L::of(1.0 - EVEN_SHARE) * pdf_plain,
        share: pdf_plain / (pdf_plain + exits),
    }
}

/// Normal of the surface about where light in a direction leaves the body, on the side of the light: that of the surface nearest to the
/// point where straight refraction at the surface nearest to the collision would take it.
fn exit_normal(interior: &Interior<'_>, connection: &Connection, light: Vec3) -> Vec3 {
    // The point of exit may see a light that the nearest surface does not.
    let towards = |n: Vec3| {
        let lack = COS_LIGHT_MIN - n.dot(light);
        if lack > 0.0 { (n + light * lack).try_normalize().unwrap_or(light) } else { n }
    };
    let (n, eta) = (towards(connection.source.normal), connection.passage.eta);
    let cos = n.dot(light);
    let cos2 = 1.0 - (1.0 - cos * cos).max(0.0) / (eta * eta);
    if cos2 < 0.01 {
        return n;
    }
    let way = light / eta - n * (cos / eta - cos2.sqrt());
    let exit = connection.source.position + (way * (connection.source.depth / cos2.sqrt())).as_dvec3();
    let found = interior.outer_normal(exit);
    found.filter(|found| found.dot(connection.source.normal) >= COS_NORMALS_MIN).map_or(n, towards)
}

/// Directions inwards for light from `wo` (local, unit, above the surface): refraction at a facet, or any direction.
struct Lobes<L: Lanes> {
    wo: V3<L>,
    alpha: L,
    eta: L,
}

impl<L: Lanes> Lobes<L> {
    /// A direction away from the light, unit, and its density over the whole sphere.
    #[inline(always)]
    fn sample(&self, u: [L; 3]) -> (V3<L>, L) {
        let one = L::one();
        let is_broad = u[2].lt(L::of(UNIFORM_SHARE + BROAD_SHARE));
        let alpha = L::select(is_broad, L::of(ALPHA_BROAD), self.alpha);
        let m = vndf_sample(self.wo, alpha, alpha, one, u[0], u[1]);
        let (bent, exists) = refract(self.wo, m, self.wo.dot(m), self.eta);
        let z = one - L::of(2.0) * u[0];
        let (sin, cos) = (L::of(2.0 * PI) * u[1]).sin_cos();
        let across = (one - z * z).max(L::zero()).sqrt();
        let is_uniform = u[2].lt(L::of(UNIFORM_SHARE));
        let wi = V3::select(is_uniform, V3::new(across * cos, across * sin, z), bent);
        (wi, L::select(is_uniform | exists, self.density(wi), L::zero()))
    }

    /// Density of [`Lobes::sample`], 1/sr.
    #[inline(always)]
    fn density(&self, wi: V3<L>) -> L {
        L::of(UNIFORM_SHARE * 0.25 / PI)
            + L::of(BROAD_SHARE) * self.refracted(wi, L::of(ALPHA_BROAD))
            + L::of(1.0 - UNIFORM_SHARE - BROAD_SHARE) * self.refracted(wi, self.alpha)
    }

    /// Density of refraction at visible facets. Source: Walter et al. 2007.
    #[inline(always)]
    fn refracted(&self, wi: V3<L>, alpha: L) -> L {
        let zero = L::zero();
        let sum = self.wo + wi.scale(self.eta);
        let m = V3::select(sum.z.lt(zero), -sum, sum).normalize();
        let (cos_om, cos_im) = (self.wo.dot(m), wi.dot(m));
        let is_possible = cos_om.gt(zero) & cos_im.lt(zero) & m.z.gt(zero) & self.wo.z.gt(zero);
        let pdf_m = vndf_pdf(self.wo, cos_om, d_ggx(m, alpha, alpha), smith_length(self.wo, alpha, alpha));
        let jacobian = self.eta.sqr() * cos_im.abs() / sum.length_squared().max(L::of(1e-20));
        L::select(is_possible, pdf_m * jacobian, zero)
    }
}

/// Evaluates the surface where connections leave through it.
struct Emerge<'a> {
    prepared: &'a Prepared,
    surface: &'a Surface,
    list: &'a [u32],
    connections: &'a [Connection],
    paths: &'a Paths,
    shadows: &'a mut Shadows,
    stats: &'a mut PassStats,
}

impl Kernel for Emerge<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self) {
        let inputs = self.surface.inputs.convert(L::of);
        let uniform = interpret(&inputs, self.surface.lobes, L::of(self.surface.length_scale));
        let list = self.list;
        for numbers in list.chunks(L::WIDTH) {
            let number = |i: usize| numbers[if i < numbers.len() { i } else { 0 }] as usize;
            self.group(per_lane(0usize, number), numbers.len(), &inputs, &uniform);
        }
    }
}

impl Emerge<'_> {
    #[inline(always)]
    fn group<L: Lanes>(
        &mut self,
        number: [usize; MAX_LANES],
        live: usize,
        inputs: &burnish_material::Inputs<L>,
        uniform: &crate::bsdf::Optics<L>,
    ) {
        let Self { prepared, surface, connections, paths, .. } = *self;
        let lobes = surface.lobes;
        let of = |i: usize| &connections[number[i]];
        let id = per_lane(0usize, |i| of(i).path as usize);
        let hits = per_lane(Hit::MISS, |i| of(i).exit);
        let vector = |f: fn(&Connection) -> Vec3| {
            V3::new(L::from_fn(|i| f(of(i)).x), L::from_fn(|i| f(of(i)).y), L::from_fn(|i| f(of(i)).z))
        };
        let wo = -vector(|c| c.direction);
        let light = vector(|c| c.light);
        let at: Point<L> = point(&prepared.geometry, &hits, surface.needs_tangent(), surface.reads_images());
        let is_front = <L::Mask as Mask>::splat(false);
        let footprint = surface.reads_images().then(|| {
            let span = span(&prepared.geometry, &hits);
            let width = L::from_fn(|i| paths.cone_width[id[i]] + paths.cone_spread[id[i]] * hits[i].t);
            Footprint { uv: span.uv_length(width), span }
        });
        let made = footprint.as_ref().and_then(|f| surface.textured(inputs, &at.uv, f.uv));
        let interpreted;
        let optics = match &made {
            Some(inputs) => {
                interpreted = interpret(inputs, lobes, L::of(surface.length_scale));
                &interpreted
            }
            None => uniform,
        };
        let Shading { frame, coat_normal } =
            surface.shading(&at, made.as_ref().unwrap_or(inputs), footprint.as_ref(), wo, is_front);
        let wavelength = lobes.has(Lobe::dispersion).then(|| wavelength(paths, &id));
        let coat_normal = surface.has_coat_normal().then(|| frame.local(coat_normal));
        let throughput = Rgb([0, 1, 2].map(|k| L::from_fn(|i| of(i).weight[k])));
        let local_wo = frame.local(wo);
        let is_steep = local_wo.z.le(L::of(-COS_INSIDE_MIN));
        let view = View { throughput, light: wavelength, coat_normal, ..View::new(local_wo) };
        let bsdf = Bsdf::prepare(optics, &surface.albedos, lobes, &view);
        let local = frame.local(light);
        let (value, _) = bsdf.eval(local);
        let outwards = light.dot(at.ng);
        // What passes a cut-through surface straight on is left to the walk.
        let c = (throughput * value).scale(optics.opacity);
        let is_used = is_steep & outwards.gt(L::zero()) & local.z.gt(L::zero()) & !c.max_channel().le(L::zero());
        for (i, hit) in hits.iter().enumerate().take(live) {
            if !is_used.lane(i) {
                continue;
            }
            let contribution = lane_of(c, i);
            if !self.stats.accepts(contribution) {
                continue;
            }
            let origin = leave(lane_vector(at.position, i), lane_vector(at.ng, i));
            self.shadows.rays.push(Ray { excluded: hit.triangle, ..Ray::new(origin, of(i).light) });
            self.shadows.contributions.push(contribution);
            self.shadows.targets.push(of(i).path);
            self.shadows.sigmas.push([0.0; 3]);
        }
    }
}

#[cfg(test)]
mod tests;

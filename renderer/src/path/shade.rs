//! Third stage: what happens at a surface. Emission, cut-through, one light connection, one scattered direction, roulette.
//!
//! One call shades all paths that hit one material, as many at a time as there are lanes. The instance with one lane is the
//! reference: the same source, the same numbers.

#![allow(clippy::needless_range_loop, reason = "one number runs over several arrays of lanes or axes")]

use super::PassStats;
use super::batch::{Paths, Shadows, Triples};
use super::detail::{Footprint, Shading};
use super::frame::{Frame, Point, point};
use super::geometry::offset;
use super::prepared::{Prepared, Surface};
use super::sampler::{Group, MAX_LANES, draw, per_lane};
use crate::bsdf::{Bsdf, Optics, interpret};
use crate::bvh::{Hit, Ray};
use crate::lanes::{Kernel, Lanes, Mask};
use crate::vector::{Rgb, V3};
use burnish_material::{Inputs, Lobe};
use glam::Vec3;

/// Scattering events before roulette may end a path. Earlier roulette costs more noise than it saves time, glass above all.
const ROULETTE_START: u32 = 8;

/// Shades the paths of `list`, all on `surface`. `vertex` counts the interfaces that each of them met before.
pub(super) struct Shade<'a> {
    pub prepared: &'a Prepared,
    pub surface: &'a Surface,
    pub list: &'a [u32],
    pub vertex: u32,
    pub paths: &'a mut Paths,
    /// Paths that go on.
    pub next: &'a mut Vec<u32>,
    /// Light connections to test.
    pub shadows: &'a mut Shadows,
    pub stats: &'a mut PassStats,
}

impl Kernel for Shade<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self) {
        // Uniform materials are interpreted once for the whole list.
        let inputs = self.surface.inputs.convert(L::of);
        let uniform = interpret(&inputs, self.surface.lobes, L::of(self.surface.length_scale));
        for ids in self.list.chunks(L::WIDTH) {
            self.group(ids, &inputs, &uniform);
        }
    }
}

impl Shade<'_> {
    /// Shades as many paths as there are lanes, or fewer: lanes beyond repeat the first path and write nothing.
    #[inline(always)]
    fn group<L: Lanes>(&mut self, ids: &[u32], inputs: &Inputs<L>, uniform: &Optics<L>) {
        let (prepared, surface) = (self.prepared, self.surface);
        let lobes = surface.lobes;
        let id = per_lane(0usize, |i| ids[if i < ids.len() { i } else { 0 }] as usize);
        let is_live = <L::Mask as Mask>::from_fn(|i| i < ids.len());
        let hits = per_lane(Hit::MISS, |i| self.paths.hits[id[i]]);
        let seeds = per_lane(0u32, |i| self.paths.seeds[id[i]]);
        let indices = per_lane(0u32, |i| self.paths.indices[id[i]]);
        let wo = -load_vector::<L>(&self.paths.direction, &id);
        let mut throughput = Rgb(load(&self.paths.throughput, &id));
        let sigma: Rgb<L> = Rgb(load(&self.paths.sigma, &id));
        if sigma.any() {
            // The way through the body (Beer and Lambert).
            let t = L::from_fn(|i| hits[i].t);
            throughput = throughput.zip(sigma, |b, s| b * (-(s * t)).exp());
        }

        let at: Point<L> = point(&prepared.geometry, &hits, surface.needs_tangent(), surface.reads_images());
        let is_front = wo.dot(at.ng).gt(L::zero());
        let footprint = surface.reads_images().then(|| Footprint::new(&prepared.geometry, &hits, self.paths, &id));
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
        // Waits here for a BSDF that takes it.
        let _coat_normal = frame.local(coat_normal);

        // Cut-through: straight on, as if there were no surface. It keeps the density of the last choice of direction.
        let mut is_passed = <L::Mask as Mask>::splat(false);
        if lobes.has(Lobe::opacity) {
            let u: [L; 4] = draw(Group::Medium, self.vertex, &seeds, &indices);
            is_passed = u[0].ge(optics.opacity) & is_live;
        }
        let is_met = is_live & !is_passed;
        for (i, id) in id.iter().enumerate().take(ids.len()) {
            self.paths.is_covered[*id] |= is_met.lane(i);
        }
        if lobes.has(Lobe::emission) {
            let emitted = throughput * optics.emission;
            let shines = is_met & is_front;
            for (i, id) in id.iter().enumerate().take(ids.len()) {
                if shines.lane(i) {
                    add(self.paths, self.stats, *id, lane_of(emitted, i));
                }
            }
        }

        let is_scattered = is_met & <L::Mask as Mask>::from_fn(|i| self.paths.bounces[id[i]] <= prepared.max_bounces);
        let mut go = Continuation {
            direction: -wo,
            throughput,
            pdf: L::from_fn(|i| self.paths.pdf[id[i]]),
            sigma: Rgb::select(is_front, optics.sigma_a, Rgb::black()),
            is_across: is_passed,
            is_alive: is_passed,
        };
        if is_scattered.any() {
            let bsdf = Bsdf::prepare(optics, lobes, frame.local(wo), throughput);
            let choice: [L; 4] = draw(Group::Light, self.vertex, &seeds, &indices);
            if prepared.light.is_sampled() {
                self.connect(&bsdf, &frame, &at, throughput, sigma, choice, is_scattered, &id);
            }
            let u: [L; 4] = draw(Group::Bsdf, self.vertex, &seeds, &indices);
            self.scatter(&bsdf, &frame, &at, wo, choice[3], u, is_scattered, &id, &mut go);
        }
        self.write(&go, &at, sigma, is_passed, &id[..ids.len()], &hits);
    }

    /// One light sample, weighted against BSDF sampling by the balance heuristic.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "values that stay in registers")]
    fn connect<L: Lanes>(
        &mut self,
        bsdf: &Bsdf<'_, L>,
        frame: &Frame<L>,
        at: &Point<L>,
        throughput: Rgb<L>,
        sigma: Rgb<L>,
        u: [L; 4],
        is_scattered: L::Mask,
        id: &[usize; MAX_LANES],
    ) {
        let zero = L::zero();
        let light = self.prepared.light.sample(u[0], u[1]);
        let local = frame.local(light.direction);
        let (value, pdf) = bsdf.eval(local);
        let outwards = light.direction.dot(at.ng);
        // A direction must be on the same side of both normals, or light leaks through the surface.
        let is_consistent = (outwards * local.z).gt(zero);
        let weight = L::one() / (light.pdf + pdf).max(L::of(1e-30));
        let c = (throughput * value * light.radiance).scale(weight);
        let is_used = is_scattered & is_consistent & light.pdf.gt(zero) & !c.max_channel().le(zero);
        if !is_used.any() {
            return;
        }
        let side = L::select(outwards.gt(zero), L::one(), -L::one());
        for i in 0..L::WIDTH {
            if !is_used.lane(i) {
                continue;
            }
            let contribution = lane_of(c, i);
            if !self.stats.accepts(contribution) {
                continue;
            }
            let direction = lane_vector(light.direction, i);
            let origin = leave(lane_vector(at.position, i), lane_vector(at.ng, i) * side.lane(i));
            let excluded = self.paths.hits[id[i]].triangle;
            self.shadows.rays.push(Ray { excluded, ..Ray::new(origin, direction) });
            self.shadows.contributions.push(contribution);
            self.shadows.paths.push(id[i] as u32);
            // Transmitted connections start in the other medium; they are blocked by the body's far side unless it is cut
            // through, and that exception is left to the paths.
            self.shadows.sigmas.push(lane_of(sigma, i));
        }
    }

    /// One scattered direction, and roulette.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "values that stay in registers")]
    fn scatter<L: Lanes>(
        &mut self,
        bsdf: &Bsdf<'_, L>,
        frame: &Frame<L>,
        at: &Point<L>,
        wo: V3<L>,
        roulette: L,
        u: [L; 4],
        is_scattered: L::Mask,
        id: &[usize; MAX_LANES],
        go: &mut Continuation<L>,
    ) {
        let zero = L::zero();
        let sample = bsdf.sample(u);
        let wi = frame.world(sample.wi).normalize();
        let is_same_side = (wi.dot(at.ng) * wo.dot(at.ng)).gt(zero);
        let is_consistent = (is_same_side & !sample.is_transmission) | (!is_same_side & sample.is_transmission);
        let mut throughput = go.throughput * sample.weight;
        let is_valid = is_scattered & sample.is_valid;
        let is_sound = throughput.is_finite() & throughput.min_channel().ge(zero) & sample.pdf.is_finite();
        for i in 0..L::WIDTH {
            if is_valid.lane(i) && !is_sound.lane(i) {
                self.stats.accepts(lane_of(throughput, i).map(|x| if x.is_finite() && x >= 0.0 { f32::NAN } else { x }));
            }
        }
        let mut is_alive = is_valid & is_sound & is_consistent & throughput.max_channel().gt(zero);
        let may_end = <L::Mask as Mask>::from_fn(|i| self.paths.bounces[id[i]] >= ROULETTE_START);
        if may_end.any() {
            let survival = L::select(may_end, throughput.max_channel().min(L::one()), L::one());
            is_alive = is_alive & roulette.lt(survival);
            throughput = throughput.scale(L::one() / survival.max(L::of(1e-30)));
        }
        go.direction = V3::select(is_scattered, wi, go.direction);
        go.throughput = Rgb::select(is_scattered, throughput, go.throughput);
        go.pdf = L::select(is_scattered, L::select(sample.is_delta, zero, sample.pdf), go.pdf);
        go.is_across = go.is_across | (is_scattered & sample.is_transmission);
        go.is_alive = go.is_alive | is_alive;
    }

    /// Stores where the paths go on.
    #[inline(always)]
    fn write<L: Lanes>(
        &mut self,
        go: &Continuation<L>,
        at: &Point<L>,
        sigma: Rgb<L>,
        is_passed: L::Mask,
        id: &[usize],
        hits: &[Hit; MAX_LANES],
    ) {
        let sigma = Rgb::select(go.is_across, go.sigma, sigma);
        let outwards = go.direction.dot(at.ng);
        let side = L::select(outwards.gt(L::zero()), L::one(), -L::one());
        for (i, &id) in id.iter().enumerate() {
            if !go.is_alive.lane(i) {
                continue;
            }
            let origin = leave(lane_vector(at.position, i), lane_vector(at.ng, i) * side.lane(i)).to_array();
            let direction = lane_vector(go.direction, i).to_array();
            if self.prepared.has_images {
                // What passes straight on keeps the density of an earlier choice, which the cone knows already.
                self.paths.extend_cone(id, if is_passed.lane(i) { 0.0 } else { go.pdf.lane(i) });
            }
            for k in 0..3 {
                self.paths.origin[k][id] = origin[k];
                self.paths.direction[k][id] = direction[k];
                self.paths.throughput[k][id] = go.throughput.0[k].lane(i);
                self.paths.sigma[k][id] = sigma.0[k].lane(i);
            }
            self.paths.pdf[id] = go.pdf.lane(i);
            self.paths.excluded[id] = hits[i].triangle;
            self.paths.bounces[id] += u32::from(!is_passed.lane(i));
            self.next.push(id as u32);
        }
    }
}

/// How the paths of a group go on.
struct Continuation<L: Lanes> {
    direction: V3<L>,
    throughput: Rgb<L>,
    pdf: L,
    /// Absorption of the medium behind the surface, as seen by the viewer.
    sigma: Rgb<L>,
    is_across: L::Mask,
    is_alive: L::Mask,
}

impl Surface {
    /// Inputs with images looked up, at the level for a footprint (a length in uv; 0 reads the finest); `None` for a material
    /// without images.
    #[inline(always)]
    pub(super) fn textured<L: Lanes>(&self, inputs: &Inputs<L>, uv: &[L; 2], footprint: L) -> Option<Inputs<L>> {
        if self.textures.is_empty() {
            return None;
        }
        let mut inputs = *inputs;
        for texture in &self.textures {
            let mut texels = [[0.0; MAX_LANES]; 3];
            for i in 0..L::WIDTH {
                let value = texture.lookup([uv[0].lane(i), uv[1].lane(i)], texture.level(footprint.lane(i)));
                for k in 0..3 {
                    texels[k][i] = value[k];
                }
            }
            texture.apply(&texels, &mut inputs);
        }
        Some(inputs)
    }
}

/// Opacity of a surface at a hit, and the absorption (1/normalised unit) of the body below it.
pub(super) fn opacity_at(prepared: &Prepared, surface: &Surface, hit: &Hit) -> (f32, [f32; 3]) {
    let at: Point<f32> = point(&prepared.geometry, &[*hit; MAX_LANES], false, !surface.textures.is_empty());
    let uniform = surface.inputs.convert(|x| x as f32);
    let inputs = surface.textured(&uniform, &at.uv, 0.0).unwrap_or(uniform);
    let optics = interpret(&inputs, surface.lobes, surface.length_scale as f32);
    (optics.opacity, optics.sigma_a.0)
}

/// Adds light to a path, or counts why not.
#[inline(always)]
pub(super) fn add(paths: &mut Paths, stats: &mut PassStats, path: usize, light: [f32; 3]) {
    if stats.accepts(light) {
        for k in 0..3 {
            paths.radiance[k][path] += light[k];
        }
    }
}

/// A point just off its surface, on the side that `n` (unit) points to.
#[inline(always)]
fn leave(p: Vec3, n: Vec3) -> Vec3 {
    Vec3::new(offset(p.x, n.x), offset(p.y, n.y), offset(p.z, n.z))
}

/// Three numbers of each path.
#[inline(always)]
pub(super) fn load<L: Lanes>(triple: &Triples, id: &[usize; MAX_LANES]) -> [L; 3] {
    [0, 1, 2].map(|k| L::from_fn(|i| triple[k][id[i]]))
}

#[inline(always)]
fn load_vector<L: Lanes>(triple: &Triples, id: &[usize; MAX_LANES]) -> V3<L> {
    let [x, y, z] = load(triple, id);
    V3::new(x, y, z)
}

#[inline(always)]
fn lane_vector<L: Lanes>(v: V3<L>, i: usize) -> Vec3 {
    Vec3::new(v.x.lane(i), v.y.lane(i), v.z.lane(i))
}

/// One lane of a colour.
#[inline(always)]
pub(super) fn lane_of<L: Lanes>(c: Rgb<L>, i: usize) -> [f32; 3] {
    c.0.map(|x| x.lane(i))
}

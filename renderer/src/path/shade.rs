//! Third stage: what happens at a surface. Emission, cut-through, connections to the light (`direct`), scattered directions, roulette.
//!
//! One call shades all paths that hit one material, as many at a time as there are lanes. The instance with one lane is the
//! reference: the same source, the same numbers.

#![allow(clippy::needless_range_loop, reason = "one number runs over several arrays of lanes or axes")]

use super::PassStats;
use super::batch::{Paths, Shadows, Triples};
use super::caustics::Role;
use super::detail::{Footprint, Shading};
use super::frame::{Frame, Point, point};
use super::geometry::offset;
use super::inside::{COS_INSIDE_MIN, EXIT_DENSITY};
use super::prepared::{Prepared, Surface};
use super::sampler::{Group, MAX_LANES, Words, draw, per_lane};
use crate::bsdf::dispersion::spectrum;
use crate::bsdf::{Bsdf, Optics, Side, View, Wavelength, interpret};
use crate::bvh::Hit;
use crate::lanes::{Kernel, Lanes, Mask};
use crate::vector::{Rgb, V3};
use burnish_material::{Inputs, Lobe};
use glam::Vec3;

/// Scattering events before roulette may end a path. Earlier roulette costs more noise than it saves time, glass above all.
pub(super) const ROULETTE_START: u32 = 8;
/// The same where connections bring all direct light, so that what goes on looks for the rest.
const ROULETTE_START_LIT: u32 = 1;
/// Weight from which such paths go on in any case, over 1.
const WORTH_LIT: f64 = 4.0;

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
        let medium: Medium<L> =
            Medium { sigma_a: Rgb(load(&self.paths.sigma_a, &id)), sigma_s: Rgb(load(&self.paths.sigma_s, &id)) };
        if medium.sigma_a.any() {
            // The way through a clear body (Beer and Lambert). A walk has weighted its own.
            let t = L::from_fn(|i| hits[i].t);
            let is_clear = medium.sigma_s.max_channel().le(L::zero());
            let Rgb([r, g, b]) = medium.sigma_a.scale(-t);
            throughput = throughput * Rgb::select(is_clear, Rgb([r.exp(), g.exp(), b.exp()]), Rgb::white());
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

        // Cut-through: straight on, as if there were no surface. It keeps the density of the last choice of direction.
        let mut is_passed = <L::Mask as Mask>::splat(false);
        if lobes.has(Lobe::opacity) {
            let u: [L; 4] = draw(Group::Medium, self.vertex, &seeds, &indices);
            is_passed = u[0].ge(optics.opacity) & is_live;
        }
        let is_met = is_live & !is_passed;
        for (i, id) in id.iter().enumerate().take(ids.len()) {
            self.paths.is_covered[*id] |= is_met.lane(i);
            if is_met.lane(i) && self.paths.bounces[*id] == 0 {
                self.paths.is_from_receiver[*id] = surface.role == Role::Receiver;
            }
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
        let straight = Continuation {
            direction: -wo,
            throughput,
            pdf: L::from_fn(|i| self.paths.pdf[id[i]]),
            beyond: Medium {
                sigma_a: Rgb::select(is_front, optics.sigma_a, Rgb::black()),
                sigma_s: Rgb::select(is_front, optics.sigma_s, Rgb::black()),
            },
            is_across: is_passed,
            is_alive: is_passed,
        };
        let mut choice = [L::zero(); 4];
        // No closures around lanes: they are not always inlined into code for wider instructions.
        let mut view = View { throughput, ..View::new(frame.local(wo)) };
        let mut bsdf = None;
        if is_scattered.any() {
            if lobes.has(Lobe::dispersion) {
                view.light = Some(wavelength(self.paths, &id));
            }
            if surface.has_coat_normal() {
                view.coat_normal = Some(frame.local(coat_normal));
            }
            bsdf = Some(Bsdf::prepare(optics, &surface.albedos, lobes, &view));
        }
        let (media, seeds, indices) = ([medium, straight.beyond], &seeds, &indices);
        let is_dispersing = optics.dispersion.gt(L::zero());
        // Those that come from a collision have been connected by it.
        let is_steep = frame.local(wo).z.le(L::of(-COS_INSIDE_MIN));
        let scatters = lobes.has(Lobe::scattering);
        let is_connected = <L::Mask as Mask>::from_fn(|i| scatters && self.paths.is_connected[id[i]]) & is_steep & !is_front;
        let mut here = None;
        if let Some(bsdf) = &bsdf {
            let frame = &frame;
            let (at, id) = (&at, &id);
            let is_open = is_scattered & !is_connected;
            here = Some(Encounter {
                bsdf,
                frame,
                at,
                wo,
                throughput,
                media,
                is_scattered,
                is_open,
                is_dispersing,
                id,
                seeds,
                indices,
            });
        }
        if let Some(here) = &here {
            choice = draw(Group::Light, self.vertex, seeds, indices);
            self.direct_light(here, choice);
        }
        // What a refracting body reflects and what it lets through are both followed where the camera sees it first.
        let sides: &[Side] = if self.vertex == 0 && surface.splits { &[Side::Same, Side::Across] } else { &[Side::Both] };
        for &side in sides {
            let mut go = straight;
            if let Some(here) = &here {
                self.scatter(here, side, choice[3], &mut go);
            }
            let mut paths = id;
            if side == Side::Same {
                go.is_alive = go.is_alive & is_scattered;
                for (i, path) in paths.iter_mut().enumerate().take(ids.len()) {
                    if go.is_alive.lane(i) {
                        *path = self.paths.branch(id[i]);
                    }
                }
            }
            self.write(&go, &at, medium, is_passed, &paths[..ids.len()], &hits);
        }
    }

    /// One scattered direction on a side of the surface, and roulette.
    #[inline(always)]
    fn scatter<L: Lanes>(&mut self, here: &Encounter<'_, L>, side: Side, roulette: L, go: &mut Continuation<L>) {
        let zero = L::zero();
        let &Encounter { bsdf, frame, at, wo, is_scattered, is_open, is_dispersing, id, .. } = here;
        let sample = bsdf.sample_side(draw(Group::Bsdf, self.vertex, here.seeds, here.indices), side);
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
        let (start, worth) = self.roulette();
        let may_end = <L::Mask as Mask>::from_fn(|i| self.paths.bounces[id[i]] >= start);
        if may_end.any() {
            let survival = L::select(may_end, (throughput.max_channel() * L::of(worth)).min(L::one()), L::one());
            is_alive = is_alive & roulette.lt(survival);
            throughput = throughput.scale(L::one() / survival.max(L::of(1e-30)));
        }
        go.direction = V3::select(is_scattered, wi, go.direction);
        go.throughput = Rgb::select(is_scattered, throughput, go.throughput);
        let pdf = L::select(!is_open & sample.is_transmission, L::of(EXIT_DENSITY), sample.pdf);
        go.pdf = L::select(is_scattered, L::select(sample.is_delta, zero, pdf), go.pdf);
        go.is_across = go.is_across | (is_scattered & sample.is_transmission);
        if self.surface.lobes.has(Lobe::dispersion) {
            let disperses = is_alive & sample.is_transmission & is_dispersing;
            for (i, id) in id.iter().enumerate().take(L::WIDTH) {
                self.paths.is_dispersed[*id] |= disperses.lane(i);
            }
        }
        go.is_alive = go.is_alive | is_alive;
    }

    /// Scattering events before roulette may end a path, and the factor from weights to odds of survival.
    #[inline(always)]
    fn roulette(&self) -> (u32, f64) {
        // Through a refracting body a path may find light that no connection brings.
        let is_lit = self.brings_all() && !self.prepared.refracts;
        if is_lit { (ROULETTE_START_LIT, WORTH_LIT) } else { (ROULETTE_START, 1.0) }
    }

    /// Stores where the paths go on.
    #[inline(always)]
    fn write<L: Lanes>(
        &mut self,
        go: &Continuation<L>,
        at: &Point<L>,
        here: Medium<L>,
        is_passed: L::Mask,
        id: &[usize],
        hits: &[Hit; MAX_LANES],
    ) {
        let sigma_a = Rgb::select(go.is_across, go.beyond.sigma_a, here.sigma_a);
        let sigma_s = Rgb::select(go.is_across, go.beyond.sigma_s, here.sigma_s);
        let is_scattering = sigma_s.max_channel().gt(L::zero());
        let outwards = go.direction.dot(at.ng);
        let side = L::select(outwards.gt(L::zero()), L::one(), -L::one());
        let is_lit = self.brings_all();
        for (i, &id) in id.iter().enumerate() {
            if !go.is_alive.lane(i) {
                continue;
            }
            let position = lane_vector(at.position, i);
            // A walk may be shorter than the step off the surface.
            let origin =
                if is_scattering.lane(i) { position } else { leave(position, lane_vector(at.ng, i) * side.lane(i)) }.to_array();
            let direction = lane_vector(go.direction, i).to_array();
            if self.prepared.has_images {
                // What passes straight on keeps the density of an earlier choice, which the cone knows already.
                self.paths.extend_cone(id, if is_passed.lane(i) { 0.0 } else { go.pdf.lane(i) });
            }
            for k in 0..3 {
                self.paths.origin[k][id] = origin[k];
                self.paths.direction[k][id] = direction[k];
                self.paths.throughput[k][id] = go.throughput.0[k].lane(i);
                self.paths.sigma_a[k][id] = sigma_a.0[k].lane(i);
                self.paths.sigma_s[k][id] = sigma_s.0[k].lane(i);
            }
            self.paths.is_from_receiver[id] &= !is_scattering.lane(i);
            if !is_passed.lane(i) {
                // What connections have brought the path must not find once more.
                self.paths.is_lit[id] = is_lit && go.pdf.lane(i) > 0.0;
                self.paths.is_cold[id] = self.surface.role == Role::Caster;
            }
            self.paths.is_cold[id] &= self.paths.is_from_receiver[id];
            if go.is_across.lane(i) {
                self.paths.body[id] = self.prepared.geometry.triangles[hits[i].triangle as usize][3];
            }
            self.paths.pdf[id] = go.pdf.lane(i);
            self.paths.is_connected[id] = false;
            self.paths.excluded[id] = hits[i].triangle;
            self.paths.bounces[id] += u32::from(!is_passed.lane(i));
            self.next.push(id as u32);
        }
    }
}

/// Coefficients of a body, 1/normalised unit; zeros outside.
#[derive(Clone, Copy)]
pub(super) struct Medium<L: Lanes> {
    /// Absorption.
    pub sigma_a: Rgb<L>,
    /// Scattering.
    pub sigma_s: Rgb<L>,
}

/// Paths of a group at their surface, about to be connected and scattered.
pub(super) struct Encounter<'a, L: Lanes> {
    pub bsdf: &'a Bsdf<'a, L>,
    pub frame: &'a Frame<L>,
    pub at: &'a Point<L>,
    /// To where the paths came from.
    pub wo: V3<L>,
    pub throughput: Rgb<L>,
    /// What the paths are in, and what is behind the surface.
    pub media: [Medium<L>; 2],
    pub is_scattered: L::Mask,
    /// Those of them that are to be connected to the light.
    pub is_open: L::Mask,
    pub is_dispersing: L::Mask,
    pub id: &'a [usize; MAX_LANES],
    pub seeds: &'a Words,
    pub indices: &'a Words,
}

/// How the paths of a group go on.
#[derive(Clone, Copy)]
struct Continuation<L: Lanes> {
    direction: V3<L>,
    throughput: Rgb<L>,
    pdf: L,
    /// The medium behind the surface, as seen by the viewer.
    beyond: Medium<L>,
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

/// Wavelengths of paths.
#[inline(always)]
pub(super) fn wavelength<L: Lanes>(paths: &Paths, id: &[usize; MAX_LANES]) -> Wavelength<L> {
    let weights = per_lane([0.0; 3], |i| spectrum().weights(f64::from(paths.wavelength[id[i]])));
    Wavelength {
        nm: L::from_fn(|i| paths.wavelength[id[i]]),
        weights: Rgb([0, 1, 2].map(|k| L::from_fn(|i| weights[i][k]))),
        is_dispersed: <L::Mask as Mask>::from_fn(|i| paths.is_dispersed[id[i]]),
    }
}

/// Opacity of a surface at a hit, and the extinction (1/normalised unit) of the body below it.
pub(super) fn opacity_at(prepared: &Prepared, surface: &Surface, hit: &Hit) -> (f32, [f32; 3]) {
    let at: Point<f32> = point(&prepared.geometry, &[*hit; MAX_LANES], false, !surface.textures.is_empty());
    let uniform = surface.inputs.convert(|x| x as f32);
    let inputs = surface.textured(&uniform, &at.uv, 0.0).unwrap_or(uniform);
    let optics = interpret(&inputs, surface.lobes, surface.length_scale as f32);
    (optics.opacity, (optics.sigma_a + optics.sigma_s).0)
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
pub(super) fn leave(p: Vec3, n: Vec3) -> Vec3 {
    Vec3::new(offset(p.x, n.x), offset(p.y, n.y), offset(p.z, n.z))
}

/// Three numbers of each path.
#[inline(always)]
pub(super) fn load<L: Lanes>(triple: &Triples, id: &[usize; MAX_LANES]) -> [L; 3] {
    [L::gather_at(&triple[0], id), L::gather_at(&triple[1], id), L::gather_at(&triple[2], id)]
}

#[inline(always)]
pub(super) fn load_vector<L: Lanes>(triple: &Triples, id: &[usize; MAX_LANES]) -> V3<L> {
    let [x, y, z] = load(triple, id);
    V3::new(x, y, z)
}

#[inline(always)]
pub(super) fn lane_vector<L: Lanes>(v: V3<L>, i: usize) -> Vec3 {
    Vec3::new(v.x.lane(i), v.y.lane(i), v.z.lane(i))
}

/// One lane of a colour.
#[inline(always)]
pub(super) fn lane_of<L: Lanes>(c: Rgb<L>, i: usize) -> [f32; 3] {
    [c.0[0].lane(i), c.0[1].lane(i), c.0[2].lane(i)]
}

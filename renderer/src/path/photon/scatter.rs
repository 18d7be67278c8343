//! What happens to photons at a surface: connection to the camera, one scattered direction, roulette.

#![allow(clippy::needless_range_loop, reason = "one number runs over several arrays of lanes or axes")]

use crate::bsdf::adjoint::Crossing;
use crate::bsdf::{self, Bsdf, Optics, interpret};
use crate::bvh::{Hit, Ray};
use crate::lanes::{Kernel, Lanes, Mask};
use crate::path::PassStats;
use crate::path::batch::{Paths, Shadows};
use crate::path::caustics::Role;
use crate::path::detail::Footprint;
use crate::path::frame::{Frame, Point, point};
use crate::path::prepared::{Prepared, Surface};
use crate::path::raygen::{View, splat};
use crate::path::sampler::{Group, MAX_LANES, Words, draw, per_lane};
use crate::path::shade::{ROULETTE_START, lane_of, lane_vector, leave, load, load_vector, wavelength};
use crate::vector::{Rgb, V3};
use burnish_material::{Inputs, Lobe};
use glam::Vec3;

/// Cosines to the geometric normal below this are raised to it where they divide.
const COS_MIN: f64 = 1e-3;
/// Share of the way to the camera that is tested: the camera itself is not in the way.
const WAY: f32 = 0.9999;

/// Scatters the photons of `list`, all on `surface`. `vertex` counts the interfaces that each of them met before.
pub(super) struct Scatter<'a> {
    pub prepared: &'a Prepared,
    pub surface: &'a Surface,
    pub view: &'a View,
    pub list: &'a [u32],
    pub vertex: u32,
    pub paths: &'a mut Paths,
    /// Photons that go on.
    pub next: &'a mut Vec<u32>,
    /// Connections to the camera.
    pub shadows: &'a mut Shadows,
    pub stats: &'a mut PassStats,
}

/// Photons at their hits: as many as there are lanes, or fewer; lanes beyond repeat the first and write nothing.
struct Arrival<'a, L: Lanes> {
    id: [usize; MAX_LANES],
    count: usize,
    at: Point<L>,
    inputs: &'a Inputs<L>,
    optics: &'a Optics<L>,
    footprint: Option<Footprint<L>>,
    /// To where the photons came from.
    to_light: V3<L>,
    power: Rgb<L>,
    wavelength: Option<bsdf::Wavelength<L>>,
}

impl Kernel for Scatter<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self) {
        let inputs = self.surface.inputs.convert(L::of);
        let uniform = interpret(&inputs, self.surface.lobes, L::of(self.surface.length_scale));
        for ids in self.list.chunks(L::WIDTH) {
            self.group(ids, &inputs, &uniform);
        }
    }
}

impl Scatter<'_> {
    #[inline(always)]
    fn group<L: Lanes>(&mut self, ids: &[u32], inputs: &Inputs<L>, uniform: &Optics<L>) {
        let surface = self.surface;
        let id = per_lane(0usize, |i| ids[if i < ids.len() { i } else { 0 }] as usize);
        let is_live = <L::Mask as Mask>::from_fn(|i| i < ids.len());
        let hits = per_lane(Hit::MISS, |i| self.paths.hits[id[i]]);
        let seeds = per_lane(0u32, |i| self.paths.seeds[id[i]]);
        let indices = per_lane(0u32, |i| self.paths.indices[id[i]]);
        let sigma_a = Rgb(load::<L>(&self.paths.sigma_a, &id));
        let t = L::from_fn(|i| hits[i].t);
        let power = Rgb(load(&self.paths.throughput, &id)).zip(sigma_a, |p, s| p * (-(s * t)).exp());

        let at: Point<L> = point(&self.prepared.geometry, &hits, surface.needs_tangent(), surface.reads_images());
        let footprint = surface.reads_images().then(|| Footprint::new(&self.prepared.geometry, &hits, self.paths, &id));
        let made = footprint.as_ref().and_then(|f| surface.textured(inputs, &at.uv, f.uv));
        let interpreted;
        let optics = match &made {
            Some(inputs) => {
                interpreted = interpret(inputs, surface.lobes, L::of(surface.length_scale));
                &interpreted
            }
            None => uniform,
        };
        let wavelength = surface.lobes.has(Lobe::dispersion).then(|| wavelength(self.paths, &id));
        let to_light = -load_vector::<L>(&self.paths.direction, &id);
        let inputs = made.as_ref().unwrap_or(inputs);
        let here = Arrival { id, count: ids.len(), at, inputs, optics, footprint, to_light, power, wavelength };

        let mut is_passed = <L::Mask as Mask>::splat(false);
        if surface.lobes.has(Lobe::opacity) {
            let u: [L; 4] = draw(Group::Medium, self.vertex, &seeds, &indices);
            is_passed = u[0].ge(optics.opacity) & is_live;
        }
        // The first thing that a photon meets must be a caster: other light is found from the camera.
        let bounces = per_lane(0u32, |i| self.paths.bounces[id[i]]);
        let is_bound = <L::Mask as Mask>::from_fn(|i| {
            bounces[i] <= self.prepared.max_bounces && (bounces[i] > 0 || surface.role == Role::Caster)
        });
        let is_met = is_live & !is_passed & is_bound;
        if is_met.any() {
            if surface.role == Role::Receiver {
                self.connect(&here, is_met, &hits);
            }
            self.scatter(&here, is_met, &bounces, &hits, [&seeds, &indices]);
        }
        if is_passed.any() {
            let is_front = to_light.dot(here.at.ng).gt(L::zero());
            self.write(&here, is_passed, is_passed, is_front, -to_light, power, &hits);
        }
    }

    /// The surface as seen along a direction, with that direction and the one to the light in its frame.
    #[inline(always)]
    fn seen_along<'b, L: Lanes>(&'b self, here: &Arrival<'b, L>, wo: V3<L>, throughput: Rgb<L>) -> (Bsdf<'b, L>, Frame<L>) {
        let is_front = wo.dot(here.at.ng).gt(L::zero());
        let shading = self.surface.shading(&here.at, here.inputs, here.footprint.as_ref(), wo, is_front);
        let frame = shading.frame;
        let coat_normal = self.surface.has_coat_normal().then(|| frame.local(shading.coat_normal));
        let view = bsdf::View { throughput, light: here.wavelength, coat_normal, ..bsdf::View::new(frame.local(wo)) };
        (Bsdf::prepare(here.optics, &self.surface.albedos, self.surface.lobes, &view), frame)
    }

    /// Light that goes from here to the camera straight away.
    #[inline(always)]
    fn connect<L: Lanes>(&mut self, here: &Arrival<'_, L>, is_met: L::Mask, hits: &[Hit; MAX_LANES]) {
        let (zero, one) = (L::zero(), L::one());
        let basis = &self.view.basis;
        let to_eye = splat::<L>(basis.origin) - here.at.position;
        let square = to_eye.length_squared().max(L::of(1e-30));
        let distance = square.sqrt();
        let wo = to_eye.scale(one / distance);
        let depth = -to_eye.dot(splat(basis.forward));
        let is_ahead = depth.gt(L::of(1e-6) * distance);
        let inverse = one / L::select(is_ahead, depth, one);
        let across = |axis: Vec3| -to_eye.dot(splat(axis)) * inverse * L::of(1.0 / f64::from(axis.length_squared()));
        let (x, y) = (across(basis.right), across(basis.up));
        let column = ((x + one) * L::of(0.5 * self.view.width as f64)).floor();
        let row = ((one - y) * L::of(0.5 * self.view.height as f64)).floor();
        let is_inside = |c: L, n: usize| c.ge(zero) & c.lt(L::of(n as f64));
        let [light, eye] = [here.to_light, wo].map(|w| w.dot(here.at.ng));
        let is_seen =
            is_met & is_ahead & is_inside(column, self.view.width) & is_inside(row, self.view.height) & (light * eye).gt(zero);
        if !is_seen.any() {
            return;
        }
        let (bsdf, frame) = self.seen_along(here, wo, Rgb::white());
        let to_light = frame.local(here.to_light);
        let is_consistent = (to_light.z * light).gt(zero);
        let (value, _) = bsdf.eval(to_light);
        // A pixel is the mean over its area on the film; a place on the film sees the surface under these cosines.
        let area =
            4.0 * f64::from(basis.right.length()) * f64::from(basis.up.length()) / (self.view.width * self.view.height) as f64;
        let cos = depth / distance;
        let scale = eye.abs() / (light.abs().max(L::of(COS_MIN)) * square * cos * cos * cos * L::of(area));
        let brought = (here.power * value).scale(scale);
        let is_used = is_seen & is_consistent & brought.max_channel().gt(zero);
        let side = L::select(eye.gt(zero), one, -one);
        for i in 0..here.count {
            let contribution = lane_of(brought, i);
            if !is_used.lane(i) || !self.stats.accepts(contribution) {
                continue;
            }
            let origin = leave(lane_vector(here.at.position, i), lane_vector(here.at.ng, i) * side.lane(i));
            let ray = Ray::new(origin, lane_vector(wo, i));
            self.shadows.rays.push(Ray { t_max: distance.lane(i) * WAY, excluded: hits[i].triangle, ..ray });
            self.shadows.contributions.push(contribution);
            self.shadows.sigmas.push([0.0; 3]);
            self.shadows.targets.push(row.lane(i) as u32 * self.view.width as u32 + column.lane(i) as u32);
        }
    }

    /// One scattered direction, and roulette.
    #[inline(always)]
    fn scatter<L: Lanes>(
        &mut self,
        here: &Arrival<'_, L>,
        is_met: L::Mask,
        bounces: &Words,
        hits: &[Hit; MAX_LANES],
        [seeds, indices]: [&Words; 2],
    ) {
        let (zero, one) = (L::zero(), L::one());
        let (from_light, frame) = self.seen_along(here, here.to_light, here.power);
        let sample = from_light.sample(draw(Group::Bsdf, self.vertex, seeds, indices));
        let wo = frame.world(sample.wi).normalize();
        let [light, viewer] = [here.to_light, wo].map(|w| w.dot(here.at.ng));
        let is_same_side = (light * viewer).gt(zero);
        let is_consistent = (is_same_side & !sample.is_transmission) | (!is_same_side & sample.is_transmission);
        let (from_viewer, seen) = self.seen_along(here, wo, Rgb::white());
        let to_light = seen.local(here.to_light);
        let is_facing = (to_light.z * light).gt(zero);
        let crossing = Crossing {
            to_light,
            cos_light: here.to_light.dot(frame.n),
            cos_geometric: [light, viewer],
            cos_viewer: wo.dot(frame.n),
        };
        let mut power = here.power * from_light.adjoint(&sample, &from_viewer, &crossing);
        let is_sound = power.is_finite() & power.min_channel().ge(zero);
        let mut is_alive = is_met & sample.is_valid & is_consistent & is_facing & is_sound & power.max_channel().gt(zero);
        for i in 0..here.count {
            if is_met.lane(i) && sample.is_valid.lane(i) && !is_sound.lane(i) {
                self.stats.accepts(lane_of(power, i).map(|x| if x.is_finite() && x >= 0.0 { f32::NAN } else { x }));
            }
        }
        // Matt surfaces keep little of a photon; what a caster sends on is what it came for.
        let start = if self.surface.role == Role::Receiver { 0 } else { ROULETTE_START };
        let may_end = <L::Mask as Mask>::from_fn(|i| bounces[i] >= start);
        if may_end.any() {
            let u: [L; 4] = draw(Group::Light, self.vertex, seeds, indices);
            let first = L::from_fn(|i| self.paths.radiance[0][here.id[i]]);
            let survival = L::select(may_end, (power.max_channel() / first.max(L::of(1e-30))).min(one), one);
            is_alive = is_alive & u[3].lt(survival);
            power = power.scale(one / survival.max(L::of(1e-30)));
        }
        let disperses = sample.is_transmission & here.optics.dispersion.gt(zero);
        for (i, &id) in here.id.iter().enumerate().take(here.count) {
            self.paths.is_dispersed[id] |= is_alive.lane(i) && disperses.lane(i);
            self.paths.bounces[id] += u32::from(is_alive.lane(i));
        }
        self.write(here, is_alive, sample.is_transmission, light.gt(zero), wo, power, hits);
    }

    /// Stores where photons go on. Those that would enter a scattering body end: such paths are found from the camera.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "values that stay in registers")]
    fn write<L: Lanes>(
        &mut self,
        here: &Arrival<'_, L>,
        is_alive: L::Mask,
        is_across: L::Mask,
        is_front: L::Mask,
        direction: V3<L>,
        power: Rgb<L>,
        hits: &[Hit; MAX_LANES],
    ) {
        let inside = Rgb::select(is_front, here.optics.sigma_a, Rgb::black());
        let sigma_a = Rgb::select(is_across, inside, Rgb(load(&self.paths.sigma_a, &here.id)));
        let is_ended = is_across & is_front & here.optics.sigma_s.max_channel().gt(L::zero());
        let side = L::select(direction.dot(here.at.ng).gt(L::zero()), L::one(), -L::one());
        for (i, &id) in here.id.iter().enumerate().take(here.count) {
            if !is_alive.lane(i) || is_ended.lane(i) {
                continue;
            }
            let origin = leave(lane_vector(here.at.position, i), lane_vector(here.at.ng, i) * side.lane(i)).to_array();
            let direction = lane_vector(direction, i).to_array();
            for k in 0..3 {
                self.paths.origin[k][id] = origin[k];
                self.paths.direction[k][id] = direction[k];
                self.paths.throughput[k][id] = power.0[k].lane(i);
                self.paths.sigma_a[k][id] = sigma_a.0[k].lane(i);
            }
            self.paths.excluded[id] = hits[i].triangle;
            self.next.push(id as u32);
        }
    }
}

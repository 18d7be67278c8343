//! Direct light: connections of a surface to the environment.
//!
//! In general one direction is drawn from the light and weighed against the one that the BSDF draws for the path itself (balance
//! heuristic). On what the camera sees first, where most of the error of a picture comes from, several directions are drawn from both, and
//! one of them is connected in proportion to what each would bring: resampled importance sampling (Talbot et al. 2005) with the same
//! weights. It costs the rays of one connection, and where nothing stands in the way it is as good as all of the candidates, which are
//! stratified among themselves. What refracts gains nothing by it, since its light comes through another surface. Surfaces that only mirror
//! or refract sharply are not connected at all.
//!
//! Matt surfaces draw the light in proportion to what it brings them (`irradiance`): nothing needs to be weighed, and shadows are the noise that is
//! left. Where the camera sees them first, they get two directions, since a shadow ray costs less than the rest of a sample.

use super::caustics::Role;
use super::sampler::{Group, Words, draw, per_lane};
use super::shade::{Encounter, Shade, lane_of, lane_vector, leave};
use crate::bsdf::Optics;
use crate::bvh::Ray;
use crate::lanes::{Lanes, Mask};
use crate::vector::{Rgb, V3};
use burnish_material::{Lobe, LobeSet, Property};

/// Candidates from the light's table; a power of two, so that candidates of consecutive samples form one sequence.
const LIGHT_CANDIDATES: u32 = 2;
/// Candidates from the BSDF, a power of two.
const BSDF_CANDIDATES: u32 = 4;

/// Directions that connect a matt surface that the camera sees first, a power of two.
const EVEN_DIRECTIONS: u32 = 2;

/// What is left to choose from of the candidates seen so far.
struct Reservoir<L: Lanes> {
    /// Sum of the candidates' luminances.
    sum: L,
    /// Luminance of the chosen one.
    luminance: L,
    /// What it would bring.
    light: Rgb<L>,
    direction: V3<L>,
    /// A number in `[0, 1)` that makes the choices.
    u: L,
}

impl<L: Lanes> Reservoir<L> {
    #[inline(always)]
    fn new(u: L) -> Self {
        let zero = L::zero();
        Self { sum: zero, luminance: zero, light: Rgb::black(), direction: V3::new(zero, zero, L::one()), u }
    }

    /// Takes a candidate into account where the mask holds.
    #[inline(always)]
    fn consider(&mut self, is_used: L::Mask, light: Rgb<L>, direction: V3<L>) {
        let [r, g, b] = light.0;
        let luminance = r * L::of(0.25) + g * L::of(0.5) + b * L::of(0.25);
        let luminance = L::select(is_used & luminance.gt(L::zero()) & luminance.is_finite(), luminance, L::zero());
        self.sum += luminance;
        let share = luminance / L::select(self.sum.gt(L::zero()), self.sum, L::one());
        let is_chosen = self.u.lt(share);
        // What is left of the number is uniform again.
        let (low, width) = (L::select(is_chosen, L::zero(), share), L::select(is_chosen, share, L::one() - share));
        self.u = ((self.u - low) / L::select(width.gt(L::zero()), width, L::one())).max(L::zero()).min(L::of(1.0 - 1e-7));
        self.luminance = L::select(is_chosen, luminance, self.luminance);
        self.light = Rgb::select(is_chosen, light, self.light);
        self.direction = V3::select(is_chosen, direction, self.direction);
    }
}

/// Sample numbers of the `j`-th of `n` (a power of two) numbers of every sample: those of consecutive samples form one sequence.
#[inline(always)]
fn numbers(indices: &Words, n: u32, j: u32) -> Words {
    per_lane(0, |i| indices[i].wrapping_mul(n).wrapping_add(j))
}

/// How a surface is connected to the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Connection {
    /// Not at all: no direction of the light is one of its own.
    None,
    /// By one direction, drawn in proportion to radiance times cosine: that stands for all light.
    Matt,
    /// By one direction.
    One,
    /// Seen first, by one of several candidates; else as above.
    Candidates,
}

impl Connection {
    /// The best for a material with these uniform values; `varies` tells which are replaced by images.
    pub(super) fn of(optics: &Optics<f64>, lobes: LobeSet, varies: impl Fn(Property) -> bool) -> Self {
        let has = |lobe| lobes.has(lobe);
        let is_coat_sharp = !has(Lobe::coat) || (optics.coat_is_smooth && !varies(Property::coat_roughness));
        let is_sharp = optics.is_smooth && !varies(Property::roughness) && is_coat_sharp;
        let spreads = has(Lobe::diffuse) || has(Lobe::sheen) || (has(Lobe::metal) && has(Lobe::multiple_scattering));
        if is_sharp && !spreads {
            return Self::None;
        }
        let has_gloss = has(Lobe::metal) || has(Lobe::specular) || has(Lobe::coat);
        if !has_gloss && !has(Lobe::transmission) && !has(Lobe::sheen) {
            return Self::Matt;
        }
        if has_gloss && !has(Lobe::transmission) { Self::Candidates } else { Self::One }
    }

    /// Whether directions are drawn for the normal of a surface with these lobes.
    pub(super) fn is_even(self, lobes: LobeSet) -> bool {
        self == Self::Matt || (self == Self::Candidates && lobes.has(Lobe::diffuse))
    }
}

impl<L: Lanes> Encounter<'_, L> {
    /// The shading normal on the side of the viewer.
    #[inline(always)]
    fn lit_normal(&self) -> V3<L> {
        let n = self.frame.n;
        V3::select(self.wo.dot(n).lt(L::zero()), -n, n)
    }
}

impl Shade<'_> {
    /// Whether connections bring all light that the next ray might find by a lobe that is not delta.
    pub(super) fn brings_all(&self) -> bool {
        let light = &self.prepared.light;
        self.prepared.resamples
            && match self.surface.connection {
                Connection::Matt => light.lights_evenly(),
                Connection::Candidates => self.vertex == 0 && light.is_sampled(),
                Connection::None | Connection::One => false,
            }
    }

    /// Connects paths to the environment. `u` are the numbers of [`Group::Light`].
    #[inline(always)]
    pub(super) fn direct_light<L: Lanes>(&mut self, here: &Encounter<'_, L>, u: [L; 4]) {
        match self.surface.connection {
            Connection::None => {}
            Connection::Matt if self.brings_all() => self.connect_evenly(here, u),
            Connection::Candidates if self.brings_all() => {
                self.connect_one_of(here, u, Group::LightCandidate, [LIGHT_CANDIDATES, BSDF_CANDIDATES])
            }
            // One direction from the light alone is a candidate, too: the path itself draws the one from the BSDF.
            _ if self.prepared.light.is_sampled() => self.connect_one_of(here, u, Group::Light, [1, 0]),
            _ => {}
        }
    }

    /// A direction in proportion to what it brings, shadows aside.
    #[inline(always)]
    fn connect_evenly<L: Lanes>(&mut self, here: &Encounter<'_, L>, u: [L; 4]) {
        let zero = L::zero();
        let Some(facing) = self.prepared.light.facing(here.lit_normal()) else {
            return;
        };
        let n = if self.vertex == 0 { EVEN_DIRECTIONS } else { 1 };
        for j in 0..n {
            let u = match n {
                1 => u,
                _ => draw(Group::LightCandidate, self.vertex, here.seeds, &numbers(here.indices, n, j)),
            };
            let light = self.prepared.light.sample_facing(&facing, [u[0], u[1], u[2]]);
            let local = here.frame.local(light.direction);
            let (value, _) = here.bsdf.eval(local);
            let is_used = light.pdf.gt(zero) & self.is_open(here, light.direction, local);
            let scale = L::one() / (L::select(is_used, light.pdf, L::one()) * L::of(f64::from(n)));
            self.push(here, is_used, light.direction, (here.throughput * value * light.radiance).scale(scale));
        }
    }

    /// One of several directions.
    #[inline(always)]
    fn connect_one_of<L: Lanes>(&mut self, here: &Encounter<'_, L>, u: [L; 4], group: Group, counts: [u32; 2]) {
        let zero = L::zero();
        let techniques = counts.map(|n| L::of(f64::from(n.max(1))));
        let weight = |light: L, bsdf: L| L::one() / (techniques[0] * light + techniques[1] * bsdf).max(L::of(1e-30));
        let mut reservoir = Reservoir::new(u[2]);
        let facing = if counts[1] > 0 && self.surface.connection.is_even(self.surface.lobes) {
            self.prepared.light.facing(here.lit_normal())
        } else {
            None
        };
        // Where light is drawn for what scatters evenly, the BSDF need not be.
        let glossy;
        let bsdf = if facing.is_some() {
            glossy = here.bsdf.glossy();
            &glossy
        } else {
            here.bsdf
        };
        for j in 0..counts[0] {
            let x: [L; 4] = draw(group, self.vertex, here.seeds, &numbers(here.indices, counts[0], j));
            let light = match &facing {
                Some(facing) => self.prepared.light.sample_facing(facing, [x[0], x[1], x[2]]),
                None => self.prepared.light.sample(x[0], x[1]),
            };
            let local = here.frame.local(light.direction);
            let (value, pdf) = bsdf.eval(local);
            let radiance = self.found(here, light.radiance);
            let brought = (here.throughput * value * radiance).scale(weight(light.pdf, pdf));
            reservoir.consider(light.pdf.gt(zero) & self.is_open(here, light.direction, local), brought, light.direction);
        }
        for j in 0..counts[1] {
            let x: [L; 4] = draw(Group::BsdfCandidate, self.vertex, here.seeds, &numbers(here.indices, counts[1], j));
            // Lobes by turns: the candidates of a sample share a number for it.
            let lobe = (u[0] + L::of(f64::from(j))) * L::of(1.0 / f64::from(counts[1]));
            let sample = bsdf.sample([lobe, x[0], x[1], zero]);
            let direction = here.frame.world(sample.wi).normalize();
            let (radiance, pdf) = match &facing {
                Some(facing) => self.prepared.light.eval_facing(facing, direction),
                None => self.prepared.light.eval(direction),
            };
            let radiance = self.found(here, radiance);
            let brought = (here.throughput * sample.weight * radiance).scale(sample.pdf * weight(pdf, sample.pdf));
            let is_used = sample.is_valid & !sample.is_delta & self.is_open(here, direction, sample.wi);
            reservoir.consider(is_used, brought, direction);
        }
        let scale = reservoir.sum / L::select(reservoir.luminance.gt(zero), reservoir.luminance, L::one());
        self.push(here, reservoir.luminance.gt(zero), reservoir.direction, reservoir.light.scale(scale));
    }

    /// Whether a direction is on the same side of both normals; light leaks through the surface otherwise.
    #[inline(always)]
    fn is_open<L: Lanes>(&self, here: &Encounter<'_, L>, direction: V3<L>, local: V3<L>) -> L::Mask {
        (direction.dot(here.at.ng) * local.z).gt(L::zero())
    }

    /// Radiance of the environment less what photons bring.
    #[inline(always)]
    fn found<L: Lanes>(&self, here: &Encounter<'_, L>, radiance: Rgb<L>) -> Rgb<L> {
        if self.surface.role != Role::Caster {
            return radiance;
        }
        let is_cold = <L::Mask as Mask>::from_fn(|i| self.paths.is_from_receiver[here.id[i]]);
        Rgb::select(is_cold, self.prepared.light.cold(radiance), radiance)
    }

    /// Notes connections that are to be found free.
    #[inline(always)]
    fn push<L: Lanes>(&mut self, here: &Encounter<'_, L>, is_used: L::Mask, direction: V3<L>, brought: Rgb<L>) {
        let zero = L::zero();
        let outwards = direction.dot(here.at.ng);
        let is_used = is_used & here.is_open & !brought.max_channel().le(zero);
        if !is_used.any() {
            return;
        }
        let side = L::select(outwards.gt(zero), L::one(), -L::one());
        // A connection across the surface starts in the medium beyond it.
        let is_across = (outwards * here.wo.dot(here.at.ng)).lt(zero);
        let [near, beyond] = here.media;
        let extinction = Rgb::select(is_across, beyond.sigma_a + beyond.sigma_s, near.sigma_a + near.sigma_s);
        for i in 0..L::WIDTH {
            if !is_used.lane(i) {
                continue;
            }
            let contribution = lane_of(brought, i);
            if !self.stats.accepts(contribution) {
                continue;
            }
            let direction = lane_vector(direction, i);
            let origin = leave(lane_vector(here.at.position, i), lane_vector(here.at.ng, i) * side.lane(i));
            let excluded = self.paths.hits[here.id[i]].triangle;
            self.shadows.rays.push(Ray { excluded, ..Ray::new(origin, direction) });
            self.shadows.contributions.push(contribution);
            self.shadows.targets.push(here.id[i] as u32);
            self.shadows.sigmas.push(lane_of(extinction, i));
        }
    }
}

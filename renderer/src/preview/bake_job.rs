//! The rays of baked light: directions of a pass, what they meet, and sums that become vertices and a floor map.

use super::bake::{Baked, BakedFloor};
use super::environment::{Level, Prefiltered, solid_angle};
use super::floor::{self, Floor, LIGHT_SIZE};
use super::upload::BakedVertex;
use crate::bvh::{Bvh, Hit, Ray};
use crate::path::HeightKey;
use crate::scene::{EnvironmentLight, Scene};
use burnish_assets::{Environment, Mesh};
use burnish_material::Property;
use glam::Vec3;
use std::f32::consts::PI;
use std::sync::Arc;

/// Directions of the first pass, which should be there soon, and of each later one.
const FIRST_DIRECTIONS: usize = 24;
const LATER_DIRECTIONS: usize = 48;
/// Passes in all; results are handed over after 1, 2, 4 and 8.
const PASSES: usize = 8;
/// Vertices closer than this part of the radius, and of about the same normal, share one computation.
const SHARED_DISTANCE: f32 = 0.02;
/// Rounds of averaging with neighbours, which hide that sharing.
const SMOOTHING: usize = 3;
/// Rays per batch: the work can be called off between two.
const BATCH: usize = 4096;
/// What other bodies reflect of open light, besides their colour: they stand in shadows themselves.
const NEIGHBOUR_LIGHT: f32 = 0.6;

/// A direction that light comes from.
struct Direction {
    d: Vec3,
    /// Radiance of the open sky or the endless floor there.
    radiance: Vec3,
    /// Solid angle that it stands for: 1 over density and count.
    weight: f32,
}

/// Sums over all passes for one vertex.
#[derive(Clone, Default)]
struct Sums {
    light: Vec3,
    own: f32,
    /// Spherical harmonics of all that covers, the solid angle of it that is another body, and the luminance of that body if it were white,
    /// summed over it.
    covered: [f32; 11],
}

/// One mesh that takes part.
struct Body {
    mesh: Arc<Mesh>,
    /// Of the vertices: where a height displaces, those that its slopes have.
    normals: Vec<Vec3>,
    /// Colour that it reflects; `None` for a body being edited.
    albedo: Option<Vec3>,
    /// Its first triangle in the tree.
    first: u32,
    /// Vertices that are computed, and for each vertex which of them stands for it.
    chosen: Vec<u32>,
    stand_in: Vec<u32>,
}

/// The whole work; holds all it needs.
pub(super) struct Job {
    bodies: Vec<Body>,
    floor: Option<Floor>,
    light: Arc<Prefiltered>,
    environment: EnvironmentLight,
    /// Sphere about all bodies: rays of the floor that miss it hit nothing.
    center: Vec3,
    radius: f32,
}

impl Job {
    pub(super) fn new(scene: &Scene, floor: Option<Floor>, light: Arc<Prefiltered>) -> Self {
        let radius = scene.document_bounds().radius();
        let mut bodies = Vec::new();
        let mut first = 0;
        let mut bounds: Option<burnish_assets::Bounds> = None;
        for object in scene.objects.iter().filter(|o| !floor::is_floor(o)) {
            let albedo = (!object.is_document).then(|| object.material.color(Property::base_color).map(|c| c as f32).into());
            let mesh = &object.mesh;
            let has_normals = mesh.normals.len() == mesh.positions.len() && HeightKey::of(object).is_none();
            let normals = if has_normals { mesh.normals.clone() } else { mesh.area_weighted_normals() };
            let (chosen, stand_in) = shared(mesh, &normals, SHARED_DISTANCE * radius.max(1e-6));
            bodies.push(Body { mesh: mesh.clone(), normals, albedo, first, chosen, stand_in });
            first += object.mesh.triangles.len() as u32;
            let own = object.mesh.bounds();
            bounds = Some(bounds.map_or(own, |b| b.union(own)));
        }
        let (center, radius) = bounds.map_or((Vec3::ZERO, 0.0), |b| (b.center(), b.radius()));
        Self { bodies, floor, light, environment: scene.environment.clone(), center, radius }
    }

    /// Runs all passes, unless `is_cancelled` says to stop. `publish` gets the results and whether they are the last.
    pub(super) fn run(self, is_cancelled: &dyn Fn() -> bool, publish: &dyn Fn(Baked, bool)) {
        let triangles: Vec<[Vec3; 3]> =
            self.bodies.iter().flat_map(|b| b.mesh.triangles.iter().map(|t| t.map(|i| b.mesh.positions[i as usize]))).collect();
        let tree = Bvh::new(&triangles);
        let mut sums: Vec<Vec<Sums>> = self.bodies.iter().map(|b| vec![Sums::default(); b.chosen.len()]).collect();
        let texels = if self.floor.is_some() { LIGHT_SIZE * LIGHT_SIZE } else { 0 };
        let (mut floor_sums, mut glow_sums) = (vec![Vec3::ZERO; texels], vec![Vec3::ZERO; texels]);
        let mut shine_sums = vec![Vec3::ZERO; texels];
        let mut total = 0.0;
        for pass in 0..PASSES {
            let count = if pass == 0 { FIRST_DIRECTIONS } else { LATER_DIRECTIONS };
            let directions = self.directions(pass, count);
            if let Some(floor) = &self.floor
                && !self.light_floor(
                    floor,
                    &tree,
                    &triangles,
                    &directions,
                    [&mut floor_sums, &mut glow_sums, &mut shine_sums],
                    is_cancelled,
                )
            {
                return;
            }
            total += count as f32;
            // The floor's own light of this pass serves the bodies of this pass.
            let floor_light = self.floor.as_ref().map(|_| blurred(&floor_sums, total, if pass < 2 { 3 } else { 1 }));
            for (body, sums) in self.bodies.iter().zip(&mut sums) {
                if !self.light_body(body, floor_light.as_ref(), &tree, &triangles, &directions, sums, is_cancelled) {
                    return;
                }
            }
            let is_last = pass + 1 == PASSES;
            if is_last || (pass + 1).is_power_of_two() {
                let meshes = self.bodies.iter().zip(&sums).map(|(b, s)| (b.mesh.clone(), b.vertices(s, total)));
                let floor = self.floor.as_ref().zip(floor_light).map(|(floor, light)| {
                    let reach = if pass < 2 { 3 } else { 1 };
                    let [glow, shine] = [&glow_sums, &shine_sums].map(|sums| blurred(sums, total, reach));
                    BakedFloor {
                        radiance: floor.radiance(self.light.up, Some(&light)),
                        glow_radiance: floor.radiance(Vec3::ZERO, Some(&glow)),
                        shine_radiance: floor.radiance(Vec3::ZERO, Some(&shine)),
                        light,
                        glow,
                        shine,
                    }
                });
                publish(Baked { meshes: meshes.collect(), floor }, is_last);
            }
        }
    }

    /// Directions of a pass: where the environment is bright by its distribution, and evenly; weighted by both densities.
    fn directions(&self, pass: usize, count: usize) -> Vec<Direction> {
        let map = &self.light.seen;
        let power = |k: usize| luminance(map.texels[k]) * solid_angle(map.width, map.height, k / map.width);
        let sum: f32 = (0..map.texels.len()).map(power).sum();
        let shift = (0.5 + pass as f32 * 0.618_034).fract();
        let turn = (0.5 + pass as f32 * 0.754_877_7).fract();
        let mut chosen = Vec::with_capacity(count);
        let bright = if sum > 0.0 { count / 2 } else { 0 };
        let (mut k, mut below) = (0, power(0));
        for i in 0..bright {
            let wanted = (i as f32 + shift) / bright as f32 * sum;
            while below < wanted && k + 1 < map.texels.len() {
                k += 1;
                below += power(k);
            }
            let u = ((k % map.width) as f32 + turn) / map.width as f32;
            let v = ((k / map.width) as f32 + (turn + shift).fract()) / map.height as f32;
            chosen.push(Environment::direction(u, v));
        }
        let even = count - bright;
        for i in 0..even {
            let y = 1.0 - 2.0 * (i as f32 + shift) / even as f32;
            let phi = 2.0 * PI * (i as f32 * 0.618_034 + turn);
            let r = (1.0 - y * y).max(0.0).sqrt();
            chosen.push(Vec3::new(r * phi.cos(), y, r * phi.sin()));
        }
        let share = bright as f32 / count as f32;
        chosen
            .into_iter()
            .map(|d| {
                let uv = Environment::uv(d);
                let i = ((uv.x * map.width as f32) as usize).min(map.width - 1);
                let j = ((uv.y * map.height as f32) as usize).min(map.height - 1);
                let radiance = map.texels[j * map.width + i];
                let density = share * luminance(radiance) / sum.max(f32::MIN_POSITIVE) + (1.0 - share) / (4.0 * PI);
                Direction { d: self.environment.world_from_map(d), radiance, weight: 1.0 / density }
            })
            .collect()
    }

    /// The body that was hit.
    fn owner(&self, hit: &Hit) -> Option<&Body> {
        self.bodies.iter().rev().find(|b| b.first <= hit.triangle)
    }

    /// Radiance of a white body where a ray along `d` meets it: open light, less what stands around it.
    fn light_on(&self, [a, b, c]: [Vec3; 3], d: Vec3) -> Vec3 {
        let n = (b - a).cross(c - a).try_normalize().unwrap_or(Vec3::Y);
        let n = if n.dot(d) > 0.0 { -n } else { n };
        self.light.irradiance.nearest(self.environment.map_from_world(n)) * (NEIGHBOUR_LIGHT / PI)
    }

    /// Adds a pass to the floor: directions that a body stands in are lost. Returns whether it was finished.
    fn light_floor(
        &self,
        floor: &Floor,
        tree: &Bvh,
        triangles: &[[Vec3; 3]],
        directions: &[Direction],
        [sums, glow, shine]: [&mut [Vec3]; 3],
        is_cancelled: &dyn Fn() -> bool,
    ) -> bool {
        let mut rays = Vec::with_capacity(BATCH);
        let mut what = Vec::with_capacity(BATCH);
        for texel in 0..sums.len() {
            let p = floor.place(texel);
            let to_center = self.center - p;
            for direction in directions.iter().filter(|x| x.d.y > 0.0) {
                let along = to_center.dot(direction.d);
                if to_center.length_squared() - along * along.abs() > self.radius * self.radius {
                    continue;
                }
                rays.push(Ray { t_min: 1e-4 * self.radius, ..Ray::new(p, direction.d) });
                what.push((texel, direction));
            }
            if rays.len() >= BATCH || texel + 1 == sums.len() {
                let mut hits = vec![Hit::MISS; rays.len()];
                tree.trace(&rays, &mut hits);
                for (&(texel, x), hit) in what.iter().zip(&hits).filter(|(_, hit)| !hit.is_miss()) {
                    let share = x.d.y * x.weight;
                    sums[texel] -= x.radiance * share;
                    let light = self.light_on(triangles[hit.triangle as usize], x.d) * share;
                    match self.owner(hit).and_then(|body| body.albedo) {
                        Some(albedo) => sums[texel] += albedo * light,
                        None => {
                            glow[texel] += light;
                            shine[texel] += Vec3::splat(share);
                        }
                    }
                }
                rays.clear();
                what.clear();
                if is_cancelled() {
                    return false;
                }
            }
        }
        true
    }

    /// Adds a pass to a body's vertices. Returns whether it was finished.
    #[expect(clippy::too_many_arguments, reason = "the state of one pass")]
    fn light_body(
        &self,
        body: &Body,
        floor_light: Option<&Level>,
        tree: &Bvh,
        triangles: &[[Vec3; 3]],
        directions: &[Direction],
        sums: &mut [Sums],
        is_cancelled: &dyn Fn() -> bool,
    ) -> bool {
        let mut rays = Vec::with_capacity(BATCH);
        let mut what = Vec::with_capacity(BATCH);
        for k in 0..sums.len() {
            let vertex = body.chosen[k] as usize;
            let n = body.normals[vertex];
            // A little off the surface: triangles around a vertex would else cover half of what it sees.
            let p = body.mesh.positions[vertex] + n * (2e-3 * self.radius);
            for x in directions.iter().filter(|x| n.dot(x.d) > 0.0) {
                rays.push(Ray::new(p, x.d));
                what.push((k, n.dot(x.d), x));
            }
            if rays.len() >= BATCH || k + 1 == sums.len() {
                let mut hits = vec![Hit::MISS; rays.len()];
                tree.trace(&rays, &mut hits);
                for ((&(k, mu, x), ray), hit) in what.iter().zip(&rays).zip(&hits) {
                    self.add(body, floor_light, triangles, ray, hit, mu, x, &mut sums[k]);
                }
                rays.clear();
                what.clear();
                if is_cancelled() {
                    return false;
                }
            }
        }
        true
    }

    #[expect(clippy::too_many_arguments, reason = "one ray with all that it may meet")]
    fn add(
        &self,
        body: &Body,
        floor_light: Option<&Level>,
        triangles: &[[Vec3; 3]],
        ray: &Ray,
        hit: &Hit,
        mu: f32,
        x: &Direction,
        sums: &mut Sums,
    ) {
        let floor_t = self.floor.as_ref().filter(|_| x.d.y < -1e-4).map_or(f32::INFINITY, |f| (f.y - ray.origin.y) / x.d.y);
        if hit.is_miss() || hit.t >= floor_t {
            if let (Some(floor), Some(light), true) = (&self.floor, floor_light, floor_t.is_finite()) {
                let p = ray.origin + x.d * floor_t;
                if floor.holds(p) {
                    let seen = floor.radiance_at(p, self.light.up, light).unwrap_or(self.light.floor_mean);
                    sums.light += (seen - x.radiance) * (mu * x.weight);
                }
            }
            return;
        }
        sums.light -= x.radiance * (mu * x.weight);
        for (sum, y) in sums.covered.iter_mut().zip(harmonics(x.d)) {
            *sum += y * x.weight;
        }
        match self.owner(hit).and_then(|b| b.albedo.filter(|_| !Arc::ptr_eq(&b.mesh, &body.mesh))) {
            Some(albedo) => {
                let light = self.light_on(triangles[hit.triangle as usize], x.d);
                sums.covered[9] += x.weight;
                sums.covered[10] += luminance(light) * x.weight;
                sums.light += albedo * light * (mu * x.weight);
            }
            None => sums.own += mu / PI * x.weight,
        }
    }
}

impl Body {
    /// What every vertex gets: the result of its stand-in, smoothed over the mesh.
    fn vertices(&self, sums: &[Sums], count: f32) -> Vec<BakedVertex> {
        let made: Vec<[f32; 16]> = sums.iter().map(|s| bytemuck::cast(s.mean(count))).collect();
        let mut values: Vec<[f32; 16]> = self.stand_in.iter().map(|&k| made[k as usize]).collect();
        for _ in 0..SMOOTHING {
            let mut sum = values.clone();
            let mut weight = vec![1.0_f32; values.len()];
            for [a, b, c] in self.mesh.triangles.iter().map(|t| t.map(|i| i as usize)) {
                for (to, from) in [(a, b), (b, c), (c, a), (b, a), (c, b), (a, c)] {
                    // Across an edge the light is another.
                    if self.normals[to].dot(self.normals[from]) > 0.9 {
                        weight[to] += 1.0;
                        for (s, v) in sum[to].iter_mut().zip(&values[from]) {
                            *s += v;
                        }
                    }
                }
            }
            for ((v, s), w) in values.iter_mut().zip(&sum).zip(&weight) {
                *v = s.map(|x| x / w);
            }
        }
        values.into_iter().map(bytemuck::cast).collect()
    }
}

/// Groups vertices by place and normal: those that are computed, and for each vertex the position of its own among them.
fn shared(mesh: &Mesh, normals: &[Vec3], distance: f32) -> (Vec<u32>, Vec<u32>) {
    let mut cells = std::collections::HashMap::new();
    let mut chosen = Vec::new();
    let stand_in = (0..mesh.positions.len())
        .map(|i| {
            let cell = ((mesh.positions[i] / distance).floor().as_ivec3(), (normals[i] * 4.0).round().as_ivec3());
            *cells.entry(cell).or_insert_with(|| {
                chosen.push(i as u32);
                chosen.len() as u32 - 1
            })
        })
        .collect();
    (chosen, stand_in)
}

impl Sums {
    fn mean(&self, count: f32) -> BakedVertex {
        let s = 1.0 / count;
        let mut covered = [0.0; 12];
        for (to, from) in covered.iter_mut().zip(&self.covered) {
            *to = from * s;
        }
        BakedVertex { light: (self.light * s).extend((self.own * s).clamp(0.0, 1.0)).to_array(), covered }
    }
}

/// Sums to means, smoothed over `reach` texels each way: hides the edges of the first passes.
fn blurred(sums: &[Vec3], count: f32, reach: isize) -> Level {
    let n = LIGHT_SIZE as isize;
    let pass = |from: &[Vec3], dx: isize, dy: isize| -> Vec<Vec3> {
        (0..n * n)
            .map(|k| {
                let (x, y) = (k % n, k / n);
                let at = |s: isize| from[((y + s * dy).clamp(0, n - 1) * n + (x + s * dx).clamp(0, n - 1)) as usize];
                (-reach..=reach).map(at).sum::<Vec3>() / (2 * reach + 1) as f32
            })
            .collect()
    };
    let means: Vec<Vec3> = sums.iter().map(|s| *s / count).collect();
    Level { width: LIGHT_SIZE, height: LIGHT_SIZE, texels: pass(&pass(&means, 1, 0), 0, 1) }
}

/// Real spherical harmonics up to the second band, in the order of `coverage` in `lighting.wgsl`.
fn harmonics(d: Vec3) -> [f32; 9] {
    [
        0.282_094_8,
        0.488_602_5 * d.y,
        0.488_602_5 * d.z,
        0.488_602_5 * d.x,
        1.092_548_4 * d.x * d.y,
        1.092_548_4 * d.y * d.z,
        0.315_391_6 * (3.0 * d.z * d.z - 1.0),
        1.092_548_4 * d.x * d.z,
        0.546_274_2 * (d.x * d.x - d.y * d.y),
    ]
}

fn luminance(c: Vec3) -> f32 {
    c.dot(Vec3::new(0.212_639, 0.715_168_7, 0.072_192_3))
}

//! The environment as textures: the map with a chain of averages over solid angle, and the irradiance for every normal.
//!
//! Each level but the map itself is smooth: its texels are averages by a bell of [`BELL`] texels, so that looking it up shows no grid.
//!
//! Where there is a floor, everything but the map itself has the floor's mean colour below the floor's edge: wide lobes and diffuse surfaces
//! then see it without tracing a ray.

use super::floor::Pavement;
use burnish_assets::Environment;
use glam::Vec3;
use std::f32::consts::PI;

/// Standard deviation of the bell that a level is averaged by, in its own texels: `environment_radiance` in `environment.wgsl` counts on it.
const BELL: f32 = 2.0;
/// Largest number that a half float keeps, with some room.
const HALF_MAX: f32 = 60_000.0;
/// Largest radiance that is summed up.
const RADIANCE_MAX: f32 = 1e30;
/// Columns and rows of the irradiance map: interpolating a cosine over 5.6 degrees is off by 0.1 %.
pub(super) const IRRADIANCE_SIZE: (usize, usize) = (64, 32);
/// Largest width that is uploaded; larger maps are averaged down.
const WIDTH_MAX: usize = 2048;

/// A rectangle of linear radiance over the sphere.
#[derive(Clone, Debug)]
pub(super) struct Level {
    pub width: usize,
    pub height: usize,
    pub texels: Vec<Vec3>,
}

impl Level {
    /// The texel that unit direction `d` of the map's own frame falls in.
    pub fn nearest(&self, d: Vec3) -> Vec3 {
        let uv = Environment::uv(d);
        let i = ((uv.x * self.width as f32) as usize).min(self.width - 1);
        let j = ((uv.y * self.height as f32) as usize).min(self.height - 1);
        self.texels[j * self.width + i]
    }
}

/// Everything that follows from an environment and a floor.
#[derive(Debug)]
pub(super) struct Prefiltered {
    /// The map itself, then its averages.
    pub levels: Vec<Level>,
    /// Irradiance by normal, [`IRRADIANCE_SIZE`].
    pub irradiance: Level,
    /// What is seen in every direction, floor included, small enough to sum over: about 128 columns.
    pub seen: Level,
    /// Irradiance on a horizontal surface.
    pub up: Vec3,
    /// Mean radiance of the floor.
    pub floor_mean: Vec3,
}

/// Averages of `environment`, over a floor if there is one.
pub(super) fn prefilter(environment: &Environment, floor: Option<Pavement>) -> Prefiltered {
    let mut base = Level {
        width: environment.width.max(1),
        height: environment.height.max(1),
        texels: environment.texels.iter().map(|t| Vec3::from_array(*t).clamp(Vec3::ZERO, Vec3::splat(RADIANCE_MAX))).collect(),
    };
    base.texels.resize(base.width * base.height, Vec3::ZERO);
    while base.width > WIDTH_MAX {
        base = shrink(&base);
    }
    spread_peaks(&mut base);

    let mut small = base.clone();
    while small.width > 128 {
        small = shrink(&small);
    }
    let up = irradiance(&small, Vec3::Y);
    let floor_mean = floor.map_or(Vec3::ZERO, |floor| floor.albedo * up / PI);
    let mut seen = base.clone();
    if let Some(floor) = floor {
        pave(&mut seen, floor_mean, floor.edge);
        pave(&mut small, floor_mean, floor.edge);
    }

    let mut levels = vec![base];
    while seen.width > 1 || seen.height > 1 {
        // The bell of the level before counts half as much now.
        let before = if levels.len() > 1 { 0.5 * BELL } else { 0.0 };
        seen = shrink(&seen);
        smooth(&mut seen, BELL * BELL - before * before);
        levels.push(seen.clone());
    }
    let (width, height) = IRRADIANCE_SIZE;
    let texels = (0..width * height)
        .map(|k| {
            let (i, j) = (k % width, k / width);
            let n = Environment::direction((i as f32 + 0.5) / width as f32, (j as f32 + 0.5) / height as f32);
            irradiance(&small, n)
        })
        .collect();
    Prefiltered { levels, irradiance: Level { width, height, texels }, seen: small, up, floor_mean }
}

/// Solid angle of a texel in row `j`.
pub(super) fn solid_angle(width: usize, height: usize, j: usize) -> f32 {
    let edge = |j: usize| (j as f32 / height as f32 * PI).cos();
    (edge(j) - edge(j + 1)) * 2.0 * PI / width as f32
}

/// Replaces what lies below an edge, given by the sine of its angle below the horizon.
fn pave(level: &mut Level, color: Vec3, edge: f32) {
    let row = (0.5 + edge.clamp(0.0, 1.0).asin() / PI) * level.height as f32;
    for j in 0..level.height {
        // The row that the edge runs through is paved in part.
        let share = (j as f32 + 1.0 - row).clamp(0.0, 1.0);
        for texel in &mut level.texels[j * level.width..(j + 1) * level.width] {
            *texel = texel.lerp(color, share);
        }
    }
}

/// Irradiance on a surface of normal `n`: the sum over all texels.
fn irradiance(level: &Level, n: Vec3) -> Vec3 {
    let mut sum = Vec3::ZERO;
    for j in 0..level.height {
        let mut row = Vec3::ZERO;
        let (sin, cos) = ((j as f32 + 0.5) / level.height as f32 * PI).sin_cos();
        for i in 0..level.width {
            let phi = (i as f32 + 0.5) / level.width as f32 * 2.0 * PI;
            let mu = n.x * sin * phi.sin() + n.y * cos - n.z * sin * phi.cos();
            row += level.texels[j * level.width + i] * mu.max(0.0);
        }
        sum += row * solid_angle(level.width, level.height, j);
    }
    sum
}

/// Half the columns and rows, by means over solid angle: the energy of the sphere stays.
fn shrink(from: &Level) -> Level {
    let (width, height) = ((from.width / 2).max(1), (from.height / 2).max(1));
    let mut texels = Vec::with_capacity(width * height);
    let range = |k: usize, n: usize, total: usize| (k * total / n, ((k + 1) * total).div_ceil(n).max(k * total / n + 1));
    for j in 0..height {
        let rows = range(j, height, from.height);
        for i in 0..width {
            let columns = range(i, width, from.width);
            let (mut sum, mut weight) = (Vec3::ZERO, 0.0);
            for y in rows.0..rows.1.min(from.height) {
                let w = solid_angle(from.width, from.height, y);
                for x in columns.0..columns.1.min(from.width) {
                    sum += from.texels[y * from.width + x] * w;
                    weight += w;
                }
            }
            texels.push(sum / weight.max(f32::MIN_POSITIVE));
        }
    }
    Level { width, height, texels }
}

/// Averages by a bell of this variance in texels along a meridian, and as far along a parallel.
fn smooth(level: &mut Level, variance: f32) {
    let (width, height) = (level.width, level.height);
    let weight = |j: usize| solid_angle(width, height, j);
    let reach = (3.0 * variance.sqrt()).ceil() as isize;
    let bell: Vec<f32> = (-reach..=reach).map(|k| (-0.5 * (k * k) as f32 / variance).exp()).collect();
    // Down a meridian and over the poles, where it goes on half a turn away.
    let mut texels = vec![Vec3::ZERO; level.texels.len()];
    for j in 0..height {
        for i in 0..width {
            let (mut sum, mut total) = (Vec3::ZERO, 0.0);
            for (k, w) in (-reach..=reach).zip(&bell) {
                let turned = (j as isize + k).rem_euclid(2 * height as isize) as usize;
                let (y, x) = if turned < height { (turned, i) } else { (2 * height - 1 - turned, (i + width / 2) % width) };
                let w = w * weight(y);
                sum += level.texels[y * width + x] * w;
                total += w;
            }
            texels[j * width + i] = sum / total.max(f32::MIN_POSITIVE);
        }
    }
    // Along a parallel a texel is the shorter the nearer the pole: three boxes make a bell.
    for (j, row) in texels.chunks_exact_mut(width).enumerate() {
        let across = (j as f32 + 0.5) / height as f32 * PI;
        let box_width = (4.0 * variance / across.sin().powi(2) + 1.0).sqrt();
        let half = ((0.5 * (box_width - 1.0)).round() as usize).min(width.saturating_sub(1) / 2);
        for _ in 0..3 {
            let old = row.to_vec();
            let mut sum: Vec3 = (0..=2 * half).map(|k| old[(k + width - half) % width]).sum();
            for i in 0..width {
                row[i] = (sum / (2 * half + 1) as f32).max(Vec3::ZERO);
                sum += old[(i + half + 1) % width] - old[(i + width - half) % width];
            }
        }
    }
    level.texels = texels;
}

/// Gives what half floats cannot hold to the neighbours, so that a sun keeps its light.
fn spread_peaks(level: &mut Level) {
    for _ in 0..64 {
        let peaks: Vec<usize> = (0..level.texels.len()).filter(|&k| level.texels[k].max_element() > HALF_MAX).collect();
        if peaks.is_empty() {
            return;
        }
        for k in peaks {
            let (i, j) = (k % level.width, k / level.width);
            let excess = level.texels[k] - level.texels[k].min(Vec3::splat(HALF_MAX));
            level.texels[k] -= excess;
            let own = solid_angle(level.width, level.height, j);
            for (dx, dy) in [(1, 0), (level.width - 1, 0), (0, 1), (0, level.height - 1)] {
                let y = (j + dy) % level.height;
                let x = (i + dx) % level.width;
                level.texels[y * level.width + x] += excess * (0.25 * own / solid_angle(level.width, level.height, y));
            }
        }
    }
    for texel in &mut level.texels {
        *texel = texel.min(Vec3::splat(HALF_MAX));
    }
}

/// Bits of the nearest half float; `x` is cut to what one holds.
pub(super) fn half_bits(x: f32) -> u16 {
    let sign = if x < 0.0 { 0x8000 } else { 0 };
    let a = x.abs().min(65_504.0);
    if a < 6.103_515_6e-5 {
        // Below the smallest normal half, steps are even.
        return sign | (a * 16_777_216.0 + 0.5) as u16;
    }
    let bits = a.to_bits();
    let rounded = bits + 0x0fff + ((bits >> 13) & 1);
    sign | (((rounded >> 13) - (112 << 10)) as u16).min(0x7bff)
}

/// A level as texels of `Rgba16Float`.
pub(super) fn half_texels(texels: &[Vec3]) -> Vec<[u16; 4]> {
    texels.iter().map(|t| [half_bits(t.x), half_bits(t.y), half_bits(t.z), half_bits(1.0)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_round_to_nearest() {
        for (x, bits) in
            [(0.0, 0), (1.0, 0x3c00), (-2.0, 0xc000), (65_504.0, 0x7bff), (1e9, 0x7bff), (6.0e-8, 1), (0.333_251_95, 0x3555)]
        {
            assert_eq!(half_bits(x), bits, "{x}");
        }
    }

    #[test]
    fn a_white_sphere_stays_white() {
        let white = Environment { name: String::new(), width: 50, height: 25, texels: vec![[1.0; 3]; 1250] };
        let made = prefilter(&white, None);
        assert!(made.levels.iter().flat_map(|l| &l.texels).all(|t| (*t - Vec3::ONE).length() < 1e-5));
        assert!(made.irradiance.texels.iter().all(|t| (t.x - PI).abs() < 0.01), "{:?}", made.irradiance.texels[0]);
        let floor = prefilter(&white, Some(Pavement { albedo: Vec3::splat(0.5), edge: 0.0 }));
        assert!((floor.floor_mean.x - 0.5).abs() < 2e-3);
    }
}

//! Boards: one structure of growth rings, pores and rays, and the species that fill it in. The grain runs along u.

use std::f32::consts::TAU;

use glam::{UVec2, Vec2, Vec3, Vec4};

use super::grid::{Grid, Surface, ramp, srgb};
use super::noise::{Cells, Random, fbm, gradient, hash, smoothstep, unit, warp};
use super::strokes::Stroke;

/// What makes a species look like itself.
struct Species {
    /// Rings between the heart and the flank of the board.
    rings: f32,
    /// How far late wood is from early wood in colour, 0 to 1.
    contrast: f32,
    /// Where in a ring the late wood begins to show, 0 to 1.
    late_from: f32,
    /// Number of pores.
    pores: usize,
    /// Share of the pores that lie in the early wood.
    ring_porous: f32,
    /// Length and width of a pore in sides of the tile.
    pore: [f32; 2],
    /// How dark pores are, 0 to 1.
    pore_depth: f32,
    /// Number of rays, which show as short dark dashes.
    rays: usize,
    /// Strength of broad streaks of colour, 0 to 1.
    streaks: f32,
    /// Strength of the shimmer that runs across the grain, 0 to 1.
    figure: f32,
    /// Colours from early wood over late wood to pores.
    colors: [u32; 4],
    seed: u32,
}

const PINE: Species = Species {
    rings: 7.0,
    contrast: 1.0,
    late_from: 0.35,
    pores: 70,
    ring_porous: 0.0,
    pore: [0.05, 0.003],
    pore_depth: 0.35,
    rays: 0,
    streaks: 0.35,
    figure: 0.0,
    colors: [0xE6C592, 0xDDB177, 0xB97B3F, 0x8A5426],
    seed: 11,
};

const OAK: Species = Species {
    rings: 9.0,
    contrast: 0.55,
    late_from: 0.3,
    pores: 5200,
    ring_porous: 0.8,
    pore: [0.03, 0.0032],
    pore_depth: 0.75,
    rays: 700,
    streaks: 0.4,
    figure: 0.12,
    colors: [0xC9A878, 0xBE9561, 0x9D7345, 0x62421F],
    seed: 23,
};

const WALNUT: Species = Species {
    rings: 7.0,
    contrast: 0.75,
    late_from: 0.25,
    pores: 3000,
    ring_porous: 0.35,
    pore: [0.04, 0.003],
    pore_depth: 0.8,
    rays: 0,
    streaks: 0.9,
    figure: 0.25,
    colors: [0x8F6A4C, 0x76523A, 0x513323, 0x2A1810],
    seed: 37,
};

const CHERRY: Species = Species {
    rings: 7.0,
    contrast: 0.5,
    late_from: 0.4,
    pores: 1800,
    ring_porous: 0.1,
    pore: [0.02, 0.0018],
    pore_depth: 0.3,
    rays: 900,
    streaks: 0.5,
    figure: 0.3,
    colors: [0xC28A5F, 0xB2764B, 0x935731, 0x5F3319],
    seed: 53,
};

const MAHOGANY: Species = Species {
    rings: 4.0,
    contrast: 0.35,
    late_from: 0.2,
    pores: 4200,
    ring_porous: 0.0,
    pore: [0.028, 0.003],
    pore_depth: 0.75,
    rays: 0,
    streaks: 0.6,
    figure: 0.8,
    colors: [0x9F5C3B, 0x8A4A2D, 0x6C331D, 0x3A170C],
    seed: 71,
};

pub(super) fn pine(size: usize) -> Surface {
    board(size, &PINE)
}

pub(super) fn oak(size: usize) -> Surface {
    board(size, &OAK)
}

pub(super) fn walnut(size: usize) -> Surface {
    board(size, &WALNUT)
}

pub(super) fn cherry(size: usize) -> Surface {
    board(size, &CHERRY)
}

pub(super) fn mahogany(size: usize) -> Surface {
    board(size, &MAHOGANY)
}

/// Rings that the tile's ends are apart along the grain: a whole number, so that they meet.
const TAPER: f32 = 4.0;

/// The age of the wood in rings. Level lines are nested arches, as where a saw cuts a tree that tapers.
fn age(p: Vec2, species: &Species) -> f32 {
    let seed = species.seed;
    let slow = 1.3 * fbm(p, UVec2::new(1, 2), 2, seed);
    let wobble = 0.22 * fbm(p, UVec2::new(3, 10), 2, seed + 10);
    let v = p.y + 0.06 * fbm(p, UVec2::new(2, 1), 2, seed + 20);
    0.5 * species.rings * (1.0 - (TAU * v).cos()) + TAPER * p.x + slow + wobble
}

fn board(size: usize, species: &Species) -> Surface {
    let seed = species.seed;
    let ages = Grid::from_fn(size, |p| age(p, species));
    let n = size as f32;
    // Rings differ: each has its own strength, which repeats with the taper.
    let strength = |age: f32| 0.55 + 0.45 * unit(hash((age.floor() as i32).rem_euclid(TAPER as i32) as u32, 0, seed));
    // How late in its ring the wood grew: a slow rise and a sudden end, which is blurred over a texel and a half.
    let late = ages.map(|p, age| {
        let t = age - age.floor();
        let steep = (age_slope(p, species, n) * 1.5).clamp(0.02, 0.4);
        let rise = smoothstep(species.late_from, 0.95 - steep, t);
        rise * (1.0 - smoothstep(1.0 - steep, 1.0, t)) * strength(age)
    });
    let fibres = Grid::from_fn(size, |p| {
        let fine = gradient(p, UVec2::new(7, 210), seed + 30) + 0.7 * gradient(p, UVec2::new(14, 130), seed + 31);
        let streak = fbm(p, UVec2::new(1, 9), 3, seed + 32);
        let across = fbm(p, UVec2::new(9, 3), 2, seed + 33);
        Vec3::new(fine / 1.7, streak, across)
    });
    let pores = pores(size, species, &ages);

    let mut shade = late.clone();
    for (shade, fibre) in shade.values.iter_mut().zip(&fibres.values) {
        *shade = 0.12
            + 0.62 * species.contrast * *shade
            + 0.1 * fibre.x
            + 0.3 * species.streaks * fibre.y
            + 0.14 * species.figure * fibre.z;
    }
    let [early, middle, dark, pore] = species.colors.map(srgb);
    let mut holes = pores.values.iter();
    let color = shade.map(|_, shade| {
        let hole = species.pore_depth * holes.next().copied().unwrap_or(0.0);
        ramp(&[(0.0, early), (0.4, middle), (0.95, dark)], shade).lerp(pore, hole)
    });
    let mut height = late.clone();
    for ((height, fibre), hole) in height.values.iter_mut().zip(&fibres.values).zip(&pores.values) {
        *height = 0.25 * *height + 0.1 * fibre.x - 0.9 * species.pore_depth * hole;
    }
    let mut surface = Surface::of_height(height, 0.004);
    let mut parts = pores.values.iter().zip(&late.values).zip(&fibres.values);
    surface = surface.rough(|_, _| {
        let Some(((hole, late), fibre)) = parts.next() else { return 0.5 };
        0.5 - 0.08 * late + 0.25 * hole + 0.05 * fibre.x
    });
    surface.base_color = Some(color);
    surface
}

/// Rings per texel across the grain.
fn age_slope(p: Vec2, species: &Species, n: f32) -> f32 {
    (0.5 * species.rings * TAU * (TAU * p.y).sin()).abs().max(1.0) / n
}

/// Pores and rays, 0 to 1. They follow the grain, so they are dashes.
fn pores(size: usize, species: &Species, ages: &Grid<f32>) -> Grid<f32> {
    let mut grid = Grid::filled(size, 0.0_f32);
    let mut random = Random::new(species.seed + 40);
    for _ in 0..species.pores {
        // Some tries to find a place in the early wood.
        let in_early = random.next() < species.ring_porous;
        let mut start = random.point();
        for _ in 0..8 {
            let t = ages.wrapped((start.x * size as f32) as i32, (start.y * size as f32) as i32).rem_euclid(1.0);
            if !in_early || t < 0.26 {
                break;
            }
            start = random.point();
        }
        let length = species.pore[0] * random.between(0.4, 1.5);
        let width = species.pore[1] * random.between(0.6, 1.2) * if in_early { 1.15 } else { 0.85 };
        let depth = random.between(0.5, 1.0);
        let stroke = Stroke { start, angle: random.between(-0.02, 0.02), length, bend: 0.0, width };
        stroke.draw(&mut grid, |value, cover| *value = value.max(cover.sqrt() * depth));
    }
    for _ in 0..species.rays {
        let (start, length) = (random.point(), random.between(0.01, 0.04));
        let stroke = Stroke { start, angle: random.between(-0.01, 0.01), length, bend: 0.0, width: 0.0022 };
        stroke.draw(&mut grid, |value, cover| *value = value.max(0.45 * cover));
    }
    grid
}

/// Granules of bark pressed together: bright and dark ones, with brown flecks.
pub(super) fn cork(size: usize) -> Surface {
    let granules = Cells::new(UVec2::splat(20), 1.0, 83);
    let flecks = Cells::new(UVec2::splat(34), 1.0, 84);
    let parts = Grid::from_fn(size, |p| {
        let bent = p + 0.014 * warp(p, UVec2::splat(16), 3, 85);
        let (granule, fleck) = (granules.at(bent), flecks.at(bent));
        let seam = smoothstep(0.0, 0.16, granule.border);
        let spot = if unit(fleck.id) > 0.78 { 1.0 - smoothstep(0.15, 0.4, fleck.nearest) } else { 0.0 };
        let grain = fbm(p, UVec2::splat(34), 3, 86);
        Vec4::new(seam, unit(granule.id), spot, grain)
    });
    let height = parts.map(|_, s| 0.35 * s.x + 0.4 * s.y * s.x - 0.3 * s.z + 0.25 * s.w);
    let mut surface = Surface::of_height(height, 0.014).rough(|_, h| 0.85 - 0.15 * h);
    surface.base_color = Some(parts.map(|p, s| {
        let tone = 0.15 + 0.65 * s.y + 0.3 * s.w + 0.2 * fbm(p, UVec2::splat(5), 2, 87);
        let bark = ramp(&[(0.0, srgb(0x8F6238)), (0.45, srgb(0xBB8C58)), (0.9, srgb(0xD6AF80))], tone);
        bark.lerp(srgb(0x5A3A20), 0.75 * s.z) * (0.72 + 0.28 * s.x)
    }));
    surface
}

//! What is cast, fired or laid: concrete, plaster, terrazzo, asphalt, terracotta, brick.

use std::f32::consts::TAU;

use glam::{UVec2, Vec2, Vec3};

use super::grid::{Grid, Surface, ramp, srgb};
use super::noise::{Cells, Random, fbm, hash, smoothstep, unit, warp};
use super::strokes::Stroke;

/// Round holes, one in each cell of which the share `present` has one: 1 inside, with a soft edge.
fn holes(cells: &Cells, p: Vec2, present: f32, radius: f32) -> f32 {
    let cell = cells.at(p);
    if unit(cell.id) > present {
        return 0.0;
    }
    let radius = radius * (0.25 + 0.75 * unit(cell.id.rotate_left(8)).powi(2));
    1.0 - smoothstep(0.7 * radius, radius, cell.nearest)
}

/// Smooth concrete as the formwork leaves it: stains, fine sand, holes of air.
pub(super) fn concrete(size: usize) -> Surface {
    let air = Cells::new(UVec2::splat(22), 0.9, 501);
    let parts = Grid::from_fn(size, |p| {
        let stain = fbm(p + 0.06 * warp(p, UVec2::splat(3), 3, 502), UVec2::splat(3), 6, 503);
        let sand = fbm(p, UVec2::splat(100), 2, 504);
        Vec3::new(holes(&air, p + 0.004 * warp(p, UVec2::splat(40), 1, 505), 0.32, 0.26), stain, sand)
    });
    let height = parts.map(|p, s| -s.x + 0.07 * s.z + 0.12 * fbm(p, UVec2::splat(9), 4, 506));
    let mut each = parts.values.iter();
    let mut surface = Surface::of_height(height, 0.018).rough(|_, _| {
        let s = each.next().copied().unwrap_or(Vec3::ZERO);
        0.78 + 0.12 * s.y + 0.1 * s.z
    });
    surface.base_color = Some(parts.map(|_, s| {
        let ground = ramp(&[(0.0, srgb(0x84827D)), (0.5, srgb(0xA19F99)), (1.0, srgb(0xB8B5AD))], 0.5 + 0.75 * s.y);
        ground * (1.0 + 0.16 * s.z) * (1.0 - 0.5 * s.x)
    }));
    surface
}

/// A wall that was smoothed with a trowel: flat sweeps, each over the edges of those before.
pub(super) fn plaster(size: usize) -> Surface {
    let mut sweeps = Grid::filled(size, 0.0_f32);
    let mut random = Random::new(511);
    for _ in 0..110 {
        let level = random.between(-0.35, 0.35);
        let stroke = Stroke {
            start: random.point(),
            angle: random.between(0.0, TAU),
            length: random.between(0.15, 0.4),
            bend: random.between(-1.4, 1.4),
            width: random.between(0.08, 0.16),
        };
        // Flat within, with a burr that the edge of the trowel leaves.
        stroke.draw(&mut sweeps, |h, cover| {
            let burr = 0.5 * smoothstep(0.02, 0.06, cover) * (1.0 - smoothstep(0.06, 0.16, cover));
            *h += (level + burr - *h) * 0.3 * smoothstep(0.0, 0.1, cover);
        });
    }
    let height = sweeps.map(|p, h| h + 0.2 * fbm(p, UVec2::splat(4), 3, 512) + 0.1 * fbm(p, UVec2::splat(60), 3, 514));
    Surface::of_height(height, 0.02)
        .colored(|p, h| srgb(0xE6E1D7) * (0.9 + 0.12 * h + 0.06 * fbm(p, UVec2::splat(3), 5, 515)))
        .rough(|_, h| 0.85 - 0.1 * h)
}

/// Chips of several stones in cement, ground flat.
pub(super) fn terrazzo(size: usize) -> Surface {
    let large = Cells::new(UVec2::splat(9), 1.0, 521);
    let small = Cells::new(UVec2::splat(24), 1.0, 522);
    const CHIPS: [u32; 6] = [0xE8E2D8, 0x9C8F84, 0x4A4744, 0xC08A6B, 0x7F8F86, 0xD8C2A4];
    let chip = |cells: &Cells, p: Vec2, present: f32, gap: f32| {
        let cell = cells.at(p);
        let is_there = unit(cell.id) < present;
        let edge = gap * (0.6 + unit(cell.id.rotate_left(4)));
        let cover = if is_there { smoothstep(edge, edge + 0.02, cell.border) } else { 0.0 };
        (cover, cell.id.rotate_left(11))
    };
    let parts = Grid::from_fn(size, |p| {
        let bent = p + 0.004 * warp(p, UVec2::splat(24), 2, 523);
        let (first, second) = (chip(&large, bent, 0.62, 0.11), chip(&small, bent, 0.6, 0.12));
        if first.0 >= second.0 { first } else { second }
    });
    let height = parts.map(|p, (cover, _)| 0.5 * cover + 0.05 * fbm(p, UVec2::splat(50), 2, 524));
    let mut each = parts.values.iter();
    let mut surface = Surface::of_height(height, 0.0008).rough(|_, _| 0.3 - 0.15 * each.next().map_or(0.0, |part| part.0));
    surface.base_color = Some(parts.map(|p, (cover, bits)| {
        let cement = srgb(0xC9C5BD) * (1.0 + 0.1 * fbm(p, UVec2::splat(70), 2, 525));
        let stone = srgb(CHIPS[(bits % CHIPS.len() as u32) as usize]) * (1.0 + 0.15 * fbm(p, UVec2::splat(26), 3, 526));
        cement.lerp(stone, cover)
    }));
    surface
}

/// Stones that stand out of tar.
pub(super) fn asphalt(size: usize) -> Surface {
    let large = Cells::new(UVec2::splat(24), 1.0, 531);
    let small = Cells::new(UVec2::splat(60), 1.0, 532);
    let parts = Grid::from_fn(size, |p| {
        let bent = p + 0.006 * warp(p, UVec2::splat(30), 2, 533);
        let (stone, grit) = (large.at(bent), small.at(bent));
        let rise = |border: f32, id: u32| smoothstep(0.02, 0.25, border) * (0.4 + 0.6 * unit(id));
        let high = rise(stone.border, stone.id) * f32::from(u8::from(unit(stone.id.rotate_left(3)) < 0.7));
        let low = 0.55 * rise(grit.border, grit.id);
        if high > low { (high, stone.id) } else { (low, grit.id) }
    });
    let height = parts.map(|p, (h, _)| h + 0.2 * fbm(p, UVec2::splat(70), 2, 534));
    let mut each = parts.values.iter();
    Surface::of_height(height, 0.035)
        .colored(|_, h| {
            let Some((rise, id)) = each.next() else { return Vec3::ONE };
            let stone = srgb(0x5B5A58).lerp(srgb(0x8A857D), unit(id.rotate_left(6)));
            srgb(0x232324).lerp(stone, 0.75 * smoothstep(0.35, 0.8, *rise)) * (0.6 + 0.5 * h)
        })
        .rough(|_, h| 0.9 - 0.15 * h)
}

/// Fired clay: fine pores, darker and lighter specks, marks of turning.
pub(super) fn terracotta(size: usize) -> Surface {
    let specks = Cells::new(UVec2::splat(54), 1.0, 541);
    let pores = Cells::new(UVec2::splat(40), 1.0, 542);
    let parts = Grid::from_fn(size, |p| {
        let turned = fbm(p + Vec2::new(0.0, 0.004) * fbm(p, UVec2::splat(4), 2, 543), UVec2::new(1, 30), 2, 544);
        let cloud = fbm(p, UVec2::splat(4), 5, 545);
        let speck = holes(&specks, p, 0.5, 0.35) * if unit(specks.at(p).id.rotate_left(13)) < 0.6 { -1.0 } else { 1.0 };
        (holes(&pores, p, 0.35, 0.25), turned, cloud, speck)
    });
    let height = parts.map(|p, (pore, turned, _, _)| 0.25 * turned - 0.6 * pore + 0.2 * fbm(p, UVec2::splat(50), 3, 546));
    let mut surface = Surface::of_height(height, 0.012).rough(|_, h| 0.88 - 0.1 * h);
    surface.base_color = Some(parts.map(|p, (pore, turned, cloud, speck)| {
        let ground =
            ramp(&[(0.0, srgb(0xA9583A)), (0.5, srgb(0xBE6C49)), (1.0, srgb(0xD08A66))], 0.5 + 0.6 * cloud + 0.2 * turned);
        let grain = 1.0 + 0.1 * fbm(p, UVec2::splat(90), 2, 547);
        ground * grain * (1.0 - 0.35 * pore) * (1.0 + if speck < 0.0 { 0.45 } else { 0.35 } * speck)
    }));
    surface
}

/// A wall of bricks in running bond. u is along the courses.
pub(super) fn brick(size: usize) -> Surface {
    const COURSES: i32 = 8;
    const BRICKS: f32 = 3.0;
    const JOINT: f32 = 0.0075;
    let parts = Grid::from_fn(size, |p| {
        let q = p + 0.0035 * warp(p, UVec2::splat(22), 3, 551);
        let course = (q.y * COURSES as f32).floor() as i32;
        let shift = if course.rem_euclid(2) == 0 { 0.0 } else { 0.5 };
        let x = q.x * BRICKS + shift;
        let number = (x.floor() as i32).rem_euclid(BRICKS as i32) as u32;
        let bits = hash(number, course.rem_euclid(COURSES) as u32, 552);
        // Distances to the brick's sides in sides of the tile.
        let f = Vec2::new(x - x.floor(), q.y * COURSES as f32 - course as f32);
        let inside = Vec2::new(f.x.min(1.0 - f.x) / BRICKS, f.y.min(1.0 - f.y) / COURSES as f32);
        // Corners are round.
        let radius = 0.012;
        let corner = (Vec2::splat(JOINT + radius) - inside).max(Vec2::ZERO).length();
        let clay = 1.0 - smoothstep(radius - 0.004, radius + 0.003, corner);
        (clay, bits)
    });
    let grain = Grid::from_fn(size, |p| fbm(p, UVec2::splat(34), 4, 553));
    let mut grains = grain.values.iter();
    let height = parts.map(|_, (clay, bits)| {
        let grain = grains.next().copied().unwrap_or(0.0);
        clay * (0.85 + 0.15 * unit(bits)) + 0.14 * grain
    });
    let mut grains = grain.values.iter();
    let mut surface = Surface::of_height(height, 0.02).rough(|_, h| 0.95 - 0.12 * h);
    surface.base_color = Some(parts.map(|p, (clay, bits)| {
        let grain = grains.next().copied().unwrap_or(0.0);
        let fired = unit(bits.rotate_left(5)) + 0.35 * fbm(p, UVec2::splat(8), 3, 554) + 0.25 * grain;
        let brick = ramp(&[(0.0, srgb(0x6E3527)), (0.45, srgb(0x98503A)), (0.8, srgb(0xAE6448)), (1.2, srgb(0xC08262))], fired);
        let spots = 1.0 - 0.4 * smoothstep(0.32, 0.5, fbm(p, UVec2::splat(60), 2, 555));
        let mortar = srgb(0xA9A196) * (1.0 + 0.2 * grain);
        mortar.lerp(brick * spots, clay)
    }));
    surface
}

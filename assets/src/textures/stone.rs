//! Natural stone that is not marble.

use glam::{UVec2, Vec2, Vec3};

use super::grid::{Grid, Surface, ramp, srgb};
use super::noise::{Cells, fbm, smoothstep, unit, warp};

/// Interlocked crystals of feldspar, quartz and mica.
pub(super) fn granite(size: usize) -> Surface {
    let large = Cells::new(UVec2::splat(26), 1.0, 401);
    let small = Cells::new(UVec2::splat(64), 1.0, 402);
    let mineral = |p: Vec2| {
        let p = p + 0.008 * warp(p, UVec2::splat(30), 2, 403);
        let (crystal, grain) = (large.at(p), small.at(p));
        // Mica gathers.
        let dark = 0.11 + 0.13 * fbm(p, UVec2::splat(5), 2, 404);
        let (kind, shade) = (unit(crystal.id), unit(grain.id));
        if shade < dark {
            (srgb(0x1D1C1E) * (0.8 + 0.5 * unit(grain.id.rotate_left(9))), 0.0)
        } else if kind < 0.42 {
            (srgb(0xB79A8C).lerp(srgb(0xCDB4A6), shade), 1.0)
        } else if kind < 0.72 || shade < 0.35 {
            (srgb(0x8B8A88).lerp(srgb(0x6E6D6E), unit(grain.id.rotate_left(5))), 0.6)
        } else {
            (srgb(0xD9D5CE).lerp(srgb(0xC4BFB8), shade), 0.9)
        }
    };
    let minerals = Grid::from_fn(size, mineral);
    let height = minerals.map(|p, (_, level)| 0.5 * level + 0.2 * fbm(p, UVec2::splat(50), 2, 405));
    let mut each = minerals.values.iter();
    let mut surface = Surface::of_height(height, 0.0012).rough(|_, _| 0.34 - 0.18 * each.next().map_or(0.5, |(_, level)| *level));
    surface.base_color = Some(minerals.map(|p, (color, _)| color * (1.0 + 0.12 * fbm(p, UVec2::splat(60), 2, 406))));
    surface
}

/// Layers of sand that settled one upon the other.
pub(super) fn sandstone(size: usize) -> Surface {
    let layers = |p: Vec2| {
        let v = p.y + 0.035 * fbm(p, UVec2::splat(2), 4, 411);
        0.6 * fbm(Vec2::new(p.x, v), UVec2::new(1, 9), 4, 412) + 0.4 * fbm(Vec2::new(p.x, v), UVec2::new(2, 34), 2, 413)
    };
    let grains = Grid::from_fn(size, |p| fbm(p, UVec2::splat(110), 2, 414));
    let bands = Grid::from_fn(size, layers);
    let mut parts = grains.values.iter().zip(&bands.values);
    let height = grains.map(|p, grain| {
        let band = parts.next().map_or(0.0, |(_, band)| *band);
        0.35 * grain + 0.45 * band + 0.4 * fbm(p, UVec2::splat(14), 3, 415)
    });
    let mut parts = grains.values.iter().zip(&bands.values);
    Surface::of_height(height, 0.02)
        .colored(|_, _| {
            let Some((grain, band)) = parts.next() else { return Vec3::ONE };
            let color = ramp(
                &[(0.0, srgb(0x9E6B45)), (0.35, srgb(0xC09468)), (0.6, srgb(0xD6B185)), (1.0, srgb(0xE3CBA4))],
                0.5 + 0.85 * band,
            );
            color * (1.0 + 0.28 * grain)
        })
        .rough(|_, h| 0.96 - 0.12 * h)
}

/// Bands of lime with holes along them.
pub(super) fn travertine(size: usize) -> Surface {
    let bent = |p: Vec2| Vec2::new(p.x, p.y + 0.025 * fbm(p, UVec2::new(2, 3), 3, 421));
    let holes = |p: Vec2| {
        let q = bent(p) + 0.012 * warp(p, UVec2::splat(18), 2, 422);
        // Holes gather in some of the bands.
        let band = smoothstep(0.0, 0.45, fbm(bent(p), UVec2::new(1, 6), 2, 423));
        let open = fbm(q, UVec2::new(9, 34), 3, 424);
        smoothstep(0.30, 0.42, open + 0.22 * band - 0.1)
    };
    let parts = Grid::from_fn(size, |p| {
        let band = fbm(bent(p), UVec2::new(1, 10), 4, 425);
        Vec3::new(holes(p), band, fbm(p, UVec2::splat(60), 2, 426))
    });
    let height = parts.map(|_, s| -s.x + 0.05 * s.y + 0.03 * s.z);
    let mut each = parts.values.iter();
    let mut surface = Surface::of_height(height, 0.02).rough(|_, _| 0.35 + 0.5 * each.next().map_or(0.0, |s| s.x));
    surface.base_color = Some(parts.map(|_, s| {
        let ground =
            ramp(&[(0.0, srgb(0xB99C78)), (0.4, srgb(0xD3BD9B)), (0.8, srgb(0xE5D6BC)), (1.0, srgb(0xEFE5D3))], 0.5 + 0.8 * s.y);
        (ground * (1.0 + 0.06 * s.z)).lerp(srgb(0x7A6247), 0.75 * s.x)
    }));
    surface
}

/// Grains with ripples of wind.
pub(super) fn sand(size: usize) -> Surface {
    let grains = Cells::new(UVec2::splat(130), 1.0, 431);
    let cells = Grid::from_fn(size, |p| grains.at(p));
    let ripple = |p: Vec2| {
        let v = p.y + 0.05 * fbm(p, UVec2::splat(3), 2, 432) + 0.008 * fbm(p, UVec2::splat(12), 2, 433);
        let t = (7.0 * v).rem_euclid(1.0);
        // Shallow to the wind and steep behind.
        if t < 0.68 { smoothstep(0.0, 0.68, t) } else { 1.0 - smoothstep(0.68, 1.0, t) }
    };
    let height = cells.map(|p, grain| 1.2 * ripple(p) + 0.2 * (1.0 - grain.nearest) * (0.5 + unit(grain.id)));
    let mut each = cells.values.iter();
    Surface::of_height(height, 0.035)
        .colored(|p, _| {
            let Some(grain) = each.next() else { return Vec3::ONE };
            let kind = unit(grain.id);
            let color =
                ramp(&[(0.0, srgb(0x7A5B3C)), (0.12, srgb(0xB48F63)), (0.6, srgb(0xCFAE80)), (1.0, srgb(0xE9D9BC))], kind);
            color * (0.85 + 0.15 * ripple(p)) * (1.0 - 0.25 * grain.nearest)
        })
        .rough(|_, h| 0.96 - 0.12 * h)
}

/// Crumbs and clods of several sizes, with some stones.
pub(super) fn soil(size: usize) -> Surface {
    let clods = Cells::new(UVec2::splat(11), 1.0, 441);
    let crumbs = Cells::new(UVec2::splat(38), 1.0, 442);
    let parts = Grid::from_fn(size, |p| {
        let bent = p + 0.02 * warp(p, UVec2::splat(8), 4, 443);
        let (clod, crumb) = (clods.at(bent), crumbs.at(bent));
        let dome = |nearest: f32, id: u32| (1.0 - (nearest / (0.45 + 0.4 * unit(id))).powi(2)).max(0.0).sqrt();
        let clump = dome(clod.nearest, clod.id) * unit(clod.id) * smoothstep(0.0, 0.3, clod.border);
        let height = 0.65 * clump + 0.35 * dome(crumb.nearest, crumb.id) + 0.3 * fbm(p, UVec2::splat(20), 5, 444);
        let is_stone = unit(crumb.id.rotate_left(7)) > 0.95;
        (height, unit(crumb.id), f32::from(u8::from(is_stone)))
    });
    let mut each = parts.values.iter();
    Surface::of_height(parts.map(|_, part| part.0), 0.07)
        .colored(|p, h| {
            let Some((_, tone, stone)) = each.next() else { return Vec3::ONE };
            let damp = 0.5 + 0.6 * fbm(p, UVec2::splat(3), 3, 445);
            let earth = srgb(0x6B4A30).lerp(srgb(0x4A311F), damp.clamp(0.0, 1.0)).lerp(srgb(0x86694B), 0.35 * tone);
            earth.lerp(srgb(0x9A8F80), 0.7 * stone * smoothstep(0.4, 0.6, h)) * (0.45 + 0.75 * h)
        })
        .rough(|_, h| 0.97 - 0.1 * h)
}

/// Ice with white flaws: planes of small bubbles, and cracks.
pub(super) fn ice(size: usize) -> Surface {
    let plates = Cells::new(UVec2::splat(5), 0.9, 451);
    let parts = Grid::from_fn(size, |p| {
        let bent = p + 0.05 * warp(p, UVec2::splat(3), 4, 452);
        let crack =
            (1.0 - smoothstep(0.0, 0.035, plates.at(bent).border)) * smoothstep(-0.2, 0.3, fbm(p, UVec2::splat(4), 2, 453));
        let cloud = smoothstep(0.05, 0.6, fbm(bent, UVec2::splat(3), 5, 454));
        (crack, cloud)
    });
    let height = parts.map(|p, (crack, _)| 0.6 * fbm(p, UVec2::splat(5), 3, 455) - 0.35 * crack);
    let mut each = parts.values.iter();
    let mut surface = Surface::of_height(height, 0.025).rough(|p, _| {
        let (crack, cloud) = each.next().copied().unwrap_or_default();
        0.06 + 0.3 * crack + 0.15 * cloud + 0.04 * fbm(p, UVec2::splat(20), 3, 456)
    });
    surface.base_color =
        Some(parts.map(|_, (crack, cloud)| srgb(0xB9D2DC).lerp(srgb(0xF4F8FA), (0.7 * cloud + 0.6 * crack).min(1.0))));
    surface
}

/// Needles of frost that grow from seeds, each field of them in a direction of its own.
pub(super) fn frost(size: usize) -> Surface {
    let fields = Cells::new(UVec2::splat(9), 1.0, 461);
    let height = Grid::from_fn(size, |p| {
        let bent = p + 0.015 * warp(p, UVec2::splat(10), 3, 462);
        let field = fields.at(bent);
        let axis = Vec2::from_angle(std::f32::consts::TAU * unit(field.id));
        let (along, across) = (field.offset.dot(axis), field.offset.perp_dot(axis));
        // Side branches leave the middle rib at 60 degrees, mirrored.
        let branch = 11.0 * (across.abs() * 0.5 + along * 0.87);
        let tooth = 1.0 - (2.0 * (branch - branch.floor()) - 1.0).abs();
        let rib = (-across.abs() * 14.0).exp();
        0.6 * tooth.powi(2) * (1.0 - 0.5 * field.nearest)
            + 0.6 * rib
            + 0.4 * fbm(p, UVec2::splat(40), 3, 463)
            + 0.3 * (1.0 - smoothstep(0.0, 0.06, field.border))
    });
    Surface::of_height(height, 0.012)
        .colored(|_, h| Vec3::splat(0.62 + 0.35 * h) * Vec3::new(0.96, 0.985, 1.0))
        .rough(|_, h| 0.35 + 0.4 * h)
}

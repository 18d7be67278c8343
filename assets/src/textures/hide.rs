//! Skins: leather, human skin, peel.

use glam::{UVec2, Vec2, Vec3};

use super::grid::{Grid, Surface, srgb};
use super::noise::{Cells, fbm, smoothstep, unit, warp};

/// Pebbles of several sizes with creases between them, and fine wrinkles on top.
pub(super) fn leather(size: usize) -> Surface {
    let pebbles = Cells::new(UVec2::splat(24), 0.85, 601);
    let fine = Cells::new(UVec2::splat(64), 0.9, 602);
    let parts = Grid::from_fn(size, |p| {
        // The size of the pebbles changes slowly: the coordinates are stretched here and pressed there.
        let bent = p + 0.03 * warp(p, UVec2::splat(3), 2, 603) + 0.005 * warp(p, UVec2::splat(24), 2, 604);
        let (pebble, wrinkle) = (pebbles.at(bent), fine.at(bent));
        let dome = smoothstep(0.0, 0.3, pebble.border);
        let crease = 0.4 + 0.6 * smoothstep(-0.3, 0.3, fbm(p, UVec2::splat(6), 2, 605));
        let height = 1.0 - crease * (1.0 - dome).powi(2)
            + 0.1 * smoothstep(0.0, 0.3, wrinkle.border)
            + 0.1 * (unit(pebble.id) - 0.5)
            + 0.05 * fbm(p, UVec2::splat(60), 2, 606);
        (height, dome)
    });
    let mut each = parts.values.iter();
    Surface::of_height(parts.map(|_, part| part.0), 0.018)
        .colored(|p, _| {
            let dome = each.next().map_or(1.0, |part| part.1);
            // Dye stays in the creases; the tops are rubbed lighter.
            let tone = 0.72 + 0.33 * dome + 0.12 * fbm(p, UVec2::splat(4), 4, 607);
            srgb(0x6B3F24) * tone
        })
        .rough(|_, h| 0.6 - 0.18 * h)
}

/// A net of fine furrows that cross, pores where they meet, and blood below.
pub(super) fn skin(size: usize) -> Surface {
    let coarse = Cells::new(UVec2::splat(30), 0.9, 611);
    let fine = Cells::new(UVec2::splat(62), 0.9, 612);
    let pores = Cells::new(UVec2::splat(22), 0.8, 613);
    let parts = Grid::from_fn(size, |p| {
        let bent = p + 0.012 * warp(p, UVec2::splat(6), 3, 614);
        let furrow = |cells: &Cells, p: Vec2, width: f32| (1.0 - smoothstep(0.0, width, cells.at(p).border)).powi(2);
        let pore = pores.at(bent);
        let radius = 0.1 + 0.1 * unit(pore.id);
        let hole = 1.0 - smoothstep(0.3 * radius, 1.6 * radius, pore.nearest);
        let deep = 0.5 + 0.5 * smoothstep(-0.4, 0.3, fbm(p, UVec2::splat(7), 2, 615));
        let lines = deep * furrow(&coarse, bent, 0.22) + 0.45 * furrow(&fine, bent, 0.25);
        (lines, hole)
    });
    let height = parts.map(|p, (lines, hole)| 0.08 * fbm(p, UVec2::splat(9), 3, 616) - 0.5 * lines - 0.55 * hole);
    let mut each = parts.values.iter();
    let mut surface = Surface::of_height(height, 0.006).rough(|p, h| 0.5 - 0.12 * h + 0.07 * fbm(p, UVec2::splat(5), 3, 617));
    surface = surface.colored(|p, _| {
        let (lines, hole) = each.next().copied().unwrap_or_default();
        let blood = 0.5 + 0.75 * fbm(p, UVec2::splat(5), 5, 618);
        let melanin = smoothstep(0.42, 0.62, fbm(p, UVec2::splat(14), 4, 619));
        let ground = Vec3::new(0.62, 0.40, 0.30).lerp(Vec3::new(0.60, 0.34, 0.26), blood.clamp(0.0, 1.0));
        ground * (1.0 - 0.06 * lines - 0.14 * hole) * (Vec3::ONE - melanin * Vec3::new(0.10, 0.16, 0.2))
    });
    surface
}

/// The rind of citrus fruit: glands that bulge or are sunk.
pub(super) fn peel(size: usize) -> Surface {
    let glands = Cells::new(UVec2::splat(28), 0.9, 621);
    let parts = Grid::from_fn(size, |p| {
        let gland = glands.at(p + 0.01 * warp(p, UVec2::splat(5), 2, 622));
        let pit = (-(gland.nearest * (2.6 + 1.4 * unit(gland.id))).powi(2) * 2.0).exp();
        (pit, unit(gland.id.rotate_left(3)))
    });
    let height = parts.map(|p, (pit, deep)| 0.3 * fbm(p, UVec2::splat(8), 3, 623) - pit * (0.35 + 0.65 * deep));
    let mut each = parts.values.iter();
    Surface::of_height(height, 0.01)
        .colored(|p, _| {
            let pit = each.next().map_or(0.0, |part| part.0);
            srgb(0xE8871E).lerp(srgb(0xF2A63A), (0.4 + 0.7 * fbm(p, UVec2::splat(4), 4, 624)).clamp(0.0, 1.0))
                * (1.0 - 0.12 * pit)
        })
        .rough(|_, h| 0.42 - 0.08 * h)
}

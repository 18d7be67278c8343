//! Loose fibres pressed together: felt, fleece, paper and cardboard.

use glam::UVec2;

use super::grid::{Grid, Surface, srgb};
use super::noise::fbm;
use super::strokes::mat;

pub(super) fn felt(size: usize) -> Surface {
    let fibres = mat(size, 5200, [0.05, 0.16], 0.0042, 2.4, 171);
    let height = fibres.map(|p, h| h + 0.35 * fbm(p, UVec2::splat(7), 3, 172));
    let mut strands = fibres.values.iter();
    Surface::of_height(height, 0.02)
        .colored(|p, h| {
            let strand = strands.next().copied().unwrap_or(0.5);
            srgb(0x8A8A86) * (0.5 + 0.45 * h + 0.35 * (strand - 0.4) + 0.12 * fbm(p, UVec2::splat(5), 3, 173))
        })
        .rough(|_, h| 0.98 - 0.12 * h)
}

pub(super) fn paper(size: usize) -> Surface {
    let fibres = mat(size, 5200, [0.03, 0.1], 0.003, 1.2, 181).blurred(1);
    let cloud = Grid::from_fn(size, |p| fbm(p, UVec2::splat(12), 4, 182));
    let mut clouds = cloud.values.iter();
    let height = fibres.map(|_, h| h + 0.3 * clouds.next().copied().unwrap_or(0.0));
    let mut clouds = cloud.values.iter();
    Surface::of_height(height, 0.0035)
        .colored(|_, h| srgb(0xECEAE4) * (0.95 + 0.05 * h + 0.035 * clouds.next().copied().unwrap_or(0.0)))
        .rough(|_, h| 0.85 - 0.1 * h)
}

/// Brown board with flutes under its liner, which show faintly, and darker and lighter fibres.
pub(super) fn cardboard(size: usize) -> Surface {
    const FLUTES: f32 = 16.0;
    let fibres = mat(size, 3400, [0.03, 0.12], 0.0035, 0.9, 191).blurred(1);
    let flute = |p: glam::Vec2| (std::f32::consts::TAU * FLUTES * (p.x + 0.004 * fbm(p, UVec2::splat(4), 2, 192))).cos();
    let height = fibres.map(|p, h| 0.35 * h + 0.4 * flute(p) + 0.1 * fbm(p, UVec2::splat(10), 3, 193));
    let mut strands = fibres.values.iter();
    Surface::of_height(height, 0.006)
        .colored(|p, _| {
            let strand = strands.next().copied().unwrap_or(0.5);
            srgb(0xB18D62) * (0.8 + 0.35 * strand + 0.1 * fbm(p, UVec2::splat(14), 4, 194) + 0.04 * flute(p))
        })
        .rough(|_, h| 0.9 - 0.1 * h)
}

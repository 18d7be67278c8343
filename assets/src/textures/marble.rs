//! Marble: a pale or dark ground that veins run through, in one main direction and branching.

use glam::{UVec2, Vec2, Vec3};

use super::grid::{Grid, Surface, srgb};
use super::noise::{fbm, gradient, smoothstep, warp};

/// Veins of one scale, 0 to 1: where a noise changes sign, of changing width and strength. `bent` is where the noise is looked at.
fn veins(p: Vec2, bent: Vec2, cells: UVec2, width: f32, seed: u32) -> f32 {
    let distance = gradient(bent, cells, seed).abs();
    let swell = 0.5 + 0.9 * fbm(p, UVec2::splat(3), 3, seed + 10);
    let presence = smoothstep(-0.35, 0.2, fbm(p, UVec2::splat(2), 2, seed + 20));
    let half = width * swell.max(0.08);
    let core = half / (half + distance * distance / half);
    core * presence
}

/// Veins, hair lines and the clouds between them, in 0 to 1 each.
fn structure(p: Vec2, seed: u32) -> Vec3 {
    // Sheared by whole cells, so that the main direction is a diagonal and still tiles.
    let sheared = Vec2::new(p.x + p.y, p.y);
    // What moved the rock moved all of it; thinner veins followed less and another way.
    let bend = warp(p, UVec2::splat(2), 5, seed);
    let broad = veins(p, sheared + 0.22 * bend, UVec2::new(3, 1), 0.07, seed + 100);
    let fine = veins(p, sheared + 0.16 * bend.perp(), UVec2::new(6, 3), 0.03, seed + 200);
    let hair = veins(p, p - 0.12 * bend, UVec2::new(7, 8), 0.014, seed + 300);
    let cloud = 0.5 + 0.75 * fbm(sheared - 0.16 * bend.perp(), UVec2::new(4, 2), 5, seed + 400);
    Vec3::new(broad.max(0.85 * fine), hair, cloud.clamp(0.0, 1.0))
}

fn marble(size: usize, seed: u32, color: impl Fn(Vec3) -> Vec3) -> Surface {
    let parts = Grid::from_fn(size, |p| structure(p, seed));
    // Polished flat: veins are a little softer than the ground, and take less polish.
    let height = parts.map(|_, s| -s.x - 0.4 * s.y);
    let mut each = parts.values.iter();
    let mut surface = Surface::of_height(height, 0.0008).rough(|_, _| {
        let s = each.next().copied().unwrap_or(Vec3::ZERO);
        0.08 + 0.07 * s.x + 0.03 * s.z
    });
    surface.base_color = Some(parts.map(|_, s| color(s).clamp(Vec3::ZERO, Vec3::ONE)));
    surface
}

/// White with grey clouds and veins.
pub(super) fn white(size: usize) -> Surface {
    marble(size, 301, |s| {
        let ground = srgb(0xF1EFEB).lerp(srgb(0xB9BBBD), smoothstep(0.35, 0.9, s.z));
        ground.lerp(srgb(0x5E6369), 0.9 * s.x).lerp(srgb(0x8F8D88), 0.5 * s.y)
    })
}

/// Black with white veins.
pub(super) fn black(size: usize) -> Surface {
    marble(size, 341, |s| {
        let ground = srgb(0x1B1B1C).lerp(srgb(0x33322F), smoothstep(0.4, 1.0, s.z));
        ground.lerp(srgb(0xE2DED4), 0.9 * smoothstep(0.15, 0.8, s.x)).lerp(srgb(0xB99F78), 0.5 * smoothstep(0.2, 0.9, s.y))
    })
}

/// Green with pale veins, as serpentine is.
pub(super) fn green(size: usize) -> Surface {
    marble(size, 371, |s| {
        let ground = srgb(0x1F3B2C).lerp(srgb(0x48705A), smoothstep(0.3, 0.95, s.z));
        ground.lerp(srgb(0xC4D3C2), 0.7 * s.x).lerp(srgb(0x0E1C15), 0.6 * s.y)
    })
}

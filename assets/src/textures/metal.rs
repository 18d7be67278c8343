//! Metal as tools leave it, and as weather does.

use std::f32::consts::TAU;

use glam::{UVec2, Vec2};

use super::grid::{Grid, Surface, ramp, srgb};
use super::noise::{Cells, Random, fbm, gradient, smoothstep, unit, warp};
use super::strokes::Stroke;

/// Fine scratches along u, most of them long, on a faint grain.
pub(super) fn brushed(size: usize) -> Surface {
    let mut scratches = Grid::from_fn(size, |p| {
        0.5 * gradient(p, UVec2::new(2, 240), 201)
            + 0.35 * gradient(p, UVec2::new(5, 160), 202)
            + 0.2 * gradient(p, UVec2::new(3, 60), 203)
    });
    let mut random = Random::new(204);
    for _ in 0..900 {
        let stroke = Stroke {
            start: random.point(),
            angle: random.between(-0.012, 0.012),
            length: random.between(0.08, 0.6),
            bend: 0.0,
            width: random.between(0.0008, 0.0024),
        };
        let depth = random.between(-1.0, 0.5);
        stroke.draw(&mut scratches, |h, cover| *h += (depth - *h) * 0.6 * cover);
    }
    let mut each = scratches.clone().values.into_iter();
    Surface::of_height(scratches, 0.0022).rough(|_, _| 0.3 + 0.16 * each.next().unwrap_or(0.0))
}

/// Short scratches in all directions, as from a grinder, each an arc.
pub(super) fn ground(size: usize) -> Surface {
    let mut height = Grid::filled(size, 0.0_f32);
    let mut random = Random::new(211);
    for _ in 0..2400 {
        let stroke = Stroke {
            start: random.point(),
            angle: random.between(0.0, TAU),
            length: random.between(0.05, 0.3),
            bend: random.between(-0.5, 0.5),
            width: random.between(0.0015, 0.004),
        };
        let depth = random.between(-0.6, 0.35);
        stroke.draw(&mut height, |h, cover| *h += (depth - *h) * 0.7 * cover);
    }
    let mut each = height.clone().values.into_iter();
    Surface::of_height(height, 0.003)
        .rough(|p, _| 0.35 - 0.25 * each.next().unwrap_or(0.0) + 0.06 * fbm(p, UVec2::splat(5), 3, 212))
}

/// What a mould of sand leaves: lumps, fine grain and some pits.
pub(super) fn cast(size: usize) -> Surface {
    let pits = Cells::new(UVec2::splat(26), 1.0, 221);
    let height = Grid::from_fn(size, |p| {
        let grain = fbm(p, UVec2::splat(44), 3, 222);
        let lumps = fbm(p, UVec2::splat(9), 3, 223);
        let pit = pits.at(p);
        let radius = 0.45 * unit(pit.id).powi(3);
        grain * 0.5 + lumps * 0.6 - 0.9 * (1.0 - smoothstep(0.5 * radius, radius + 0.02, pit.nearest))
    });
    Surface::of_height(height, 0.03).rough(|p, h| 0.62 - 0.2 * h + 0.12 * fbm(p, UVec2::splat(6), 3, 224))
}

/// Dents of a round hammer, side by side and across one another.
pub(super) fn hammered(size: usize) -> Surface {
    let dents = Cells::new(UVec2::splat(9), 0.75, 231);
    let height = Grid::from_fn(size, |p| {
        let dent = dents.at(p);
        // A ball's dent, with a ridge that was pressed round.
        let bowl = dent.nearest * dent.nearest;
        bowl.min(0.55) - 0.1 * (-dent.border * 9.0).exp() + 0.012 * fbm(p, UVec2::splat(40), 2, 232)
    });
    Surface::of_height(height.blurred(size / 256), 0.022).rough(|p, _| 0.2 + 0.05 * fbm(p, UVec2::splat(30), 3, 233))
}

/// Iron that rusts from pits outwards: what is not metal any more is rough, brown and swollen.
pub(super) fn rust(size: usize) -> Surface {
    let rusted = Grid::from_fn(size, |p| {
        let bent = p + 0.03 * warp(p, UVec2::splat(6), 3, 241);
        let spread = fbm(bent, UVec2::splat(3), 6, 242) + 0.25 * fbm(p, UVec2::splat(40), 3, 243);
        smoothstep(-0.16, -0.02, spread)
    });
    let crust = Grid::from_fn(size, |p| fbm(p + 0.01 * warp(p, UVec2::splat(16), 2, 244), UVec2::splat(22), 5, 245));
    let mut layers = rusted.values.iter().zip(&crust.values);
    let height = rusted.map(|_, _| layers.next().map_or(0.0, |(rust, crust)| rust * (0.5 + 0.7 * crust)));
    let mut layers = rusted.values.iter().zip(&crust.values);
    let mut surface = Surface::of_height(height, 0.018).colored(|p, _| {
        let Some((&rust, &crust)) = layers.next() else { return srgb(0) };
        let metal = srgb(0xB5B0AA) * (1.0 + 0.12 * fbm(p, UVec2::splat(8), 4, 246));
        let age = 0.5 + 0.8 * fbm(p, UVec2::splat(4), 4, 247) + 0.45 * crust;
        let oxide = ramp(&[(0.0, srgb(0x3A2118)), (0.35, srgb(0x6B3219)), (0.7, srgb(0x9A4A1E)), (1.1, srgb(0xC27A36))], age);
        metal.lerp(oxide, rust)
    });
    let mut layers = rusted.values.iter();
    surface = surface.rough(|p, _| 0.38 + 0.06 * fbm(p, UVec2::splat(9), 3, 248) + 0.5 * layers.next().copied().unwrap_or(0.0));
    surface.metallic = Some(rusted.map(|_, rust| 1.0 - rust));
    surface
}

/// Copper that turned green where rain stood and ran, brown where the green has not come yet.
pub(super) fn patina(size: usize) -> Surface {
    let green = Grid::from_fn(size, |p| {
        let bent = p + 0.05 * warp(p, UVec2::splat(4), 3, 251);
        let run = fbm(bent, UVec2::new(7, 2), 4, 252);
        smoothstep(-0.22, 0.16, run + 0.5 * fbm(bent, UVec2::splat(4), 5, 253) + 0.12 * fbm(p, UVec2::splat(50), 2, 254))
    });
    let grain = Grid::from_fn(size, |p| fbm(p, UVec2::splat(30), 4, 255));
    let mut layers = green.values.iter().zip(&grain.values);
    let height = green.map(|_, _| layers.next().map_or(0.0, |(green, grain)| green * (0.6 + 0.5 * grain)));
    let mut layers = green.values.iter().zip(&grain.values);
    let mut surface = Surface::of_height(height, 0.008).colored(|p, _| {
        let Some((&green, &grain)) = layers.next() else { return srgb(0) };
        let tone = fbm(p, UVec2::splat(5), 4, 256);
        let brown = srgb(0x8C5133).lerp(srgb(0x54301F), (0.5 + 0.9 * tone).clamp(0.0, 1.0));
        let crust = srgb(0x4F9484).lerp(srgb(0x93C4B2), (0.5 + 0.6 * grain + 0.5 * tone).clamp(0.0, 1.0));
        brown.lerp(crust, green)
    });
    let mut layers = green.values.iter();
    surface = surface.rough(|_, _| 0.4 + 0.45 * layers.next().copied().unwrap_or(0.0));
    surface.metallic = Some(green.map(|_, green| 1.0 - green));
    surface
}

/// Flakes in a lacquer: cells that each face their own way.
pub(super) fn flakes(size: usize) -> Surface {
    let flakes = Cells::new(UVec2::splat(150), 1.0, 261);
    let normal = Grid::from_fn(size, |p| {
        let bits = flakes.at(p).id;
        let angle = TAU * unit(bits);
        // Most lie flat; a share of the cosine that falls off like a lobe.
        let tilt = 0.28 * (-2.0 * (1.0 - 0.98 * unit(bits.rotate_left(16))).ln()).sqrt() * 0.6;
        (Vec2::from_angle(angle) * tilt).extend(1.0).normalize()
    });
    Surface::of_directions(normal)
}

/// The ripple of sprayed lacquer.
pub(super) fn orange_peel(size: usize) -> Surface {
    let height = Grid::from_fn(size, |p| fbm(p + 0.01 * warp(p, UVec2::splat(9), 1, 271), UVec2::splat(16), 2, 272));
    Surface::of_height(height, 0.0022)
}

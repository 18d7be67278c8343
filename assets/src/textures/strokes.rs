//! Fibres and scratches, drawn one by one across the edges of the tile.

use std::f32::consts::TAU;

use glam::Vec2;

use super::grid::Grid;
use super::noise::Random;

/// A line of round cross-section. Lengths are in sides of the tile.
#[derive(Clone, Copy)]
pub(super) struct Stroke {
    pub(super) start: Vec2,
    /// Direction at the start, radians from +u towards +v.
    pub(super) angle: f32,
    pub(super) length: f32,
    /// Change of direction from start to end, radians.
    pub(super) bend: f32,
    /// Full width; below a texel the stroke becomes fainter instead.
    pub(super) width: f32,
}

impl Stroke {
    /// Calls `paint(value, cover)` for the texels touched; the cover is the cross-section (1 in the middle, 0 at the edge) times a fade
    /// towards both ends. A texel is met several times.
    pub(super) fn draw<T>(&self, grid: &mut Grid<T>, mut paint: impl FnMut(&mut T, f32)) {
        let n = grid.size as f32;
        let radius = (0.5 * self.width * n).max(0.75);
        let faint = (self.width * n / 1.5).min(1.0);
        // Steps of a texel, longer for wide strokes, whose stamps overlap more than enough.
        let stride = (0.2 * radius).max(1.0);
        let steps = ((self.length * n / stride) as usize).max(1);
        let reach = radius.ceil() as i32;
        let mut p = self.start * n;
        for step in 0..=steps {
            let along = step as f32 / steps as f32;
            let fade = faint * (8.0 * along.min(1.0 - along)).min(1.0);
            let (x, y) = (p.x.floor() as i32, p.y.floor() as i32);
            for dy in -reach..=reach {
                for dx in -reach..=reach {
                    let middle = Vec2::new((x + dx) as f32 + 0.5, (y + dy) as f32 + 0.5);
                    let d = middle.distance_squared(p) / (radius * radius);
                    if d < 1.0 {
                        let wrap = |i: i32| i.rem_euclid(grid.size as i32) as usize;
                        let index = wrap(y + dy) * grid.size + wrap(x + dx);
                        paint(&mut grid.values[index], fade * (1.0 - d));
                    }
                }
            }
            p += stride * Vec2::from_angle(self.angle + self.bend * along);
        }
    }
}

/// A mat of `count` fibres in all directions: heights, those drawn later on top.
pub(super) fn mat(size: usize, count: usize, length: [f32; 2], width: f32, bend: f32, seed: u32) -> Grid<f32> {
    let mut grid = Grid::filled(size, 0.0_f32);
    let mut random = Random::new(seed);
    for k in 0..count {
        let stroke = Stroke {
            start: random.point(),
            angle: random.between(0.0, TAU),
            length: random.between(length[0], length[1]),
            bend: random.between(-bend, bend),
            width: width * random.between(0.6, 1.3),
        };
        let level = 0.7 * k as f32 / count as f32;
        stroke.draw(&mut grid, |h: &mut f32, cover| *h = h.max(level + 0.3 * cover - 0.3 * (1.0 - cover)));
    }
    grid
}

//! Maps while they are made: numbers on a square grid that wraps around, and the surface they describe together.

use glam::{Vec2, Vec3};

use super::noise::smoothstep;
use crate::image::Image;

/// A square of `size * size` numbers or colours, row by row from the upper left corner; it tiles.
#[derive(Clone)]
pub(super) struct Grid<T> {
    pub(super) size: usize,
    pub(super) values: Vec<T>,
}

/// The middle of a texel of a grid.
fn middle(size: usize, index: usize) -> Vec2 {
    (Vec2::new((index % size) as f32, (index / size) as f32) + 0.5) / size as f32
}

impl<T: Copy> Grid<T> {
    /// Asks for the value at the middle of every texel, on all cores; coordinates are 0 to 1, v grows downwards.
    pub(super) fn from_fn(size: usize, value: impl Fn(Vec2) -> T + Sync) -> Self
    where
        T: Default + Send,
    {
        let mut values = vec![T::default(); size * size];
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let rows = size.div_ceil(threads);
        std::thread::scope(|scope| {
            for (band, texels) in values.chunks_mut(rows * size).enumerate() {
                let value = &value;
                scope.spawn(move || {
                    for (i, texel) in texels.iter_mut().enumerate() {
                        *texel = value(middle(size, band * rows * size + i));
                    }
                });
            }
        });
        Self { size, values }
    }

    /// The same value everywhere.
    pub(super) fn filled(size: usize, value: T) -> Self {
        Self { size, values: vec![value; size * size] }
    }

    /// Another grid from each value and its place.
    pub(super) fn map<U: Copy>(&self, mut f: impl FnMut(Vec2, T) -> U) -> Grid<U> {
        let values = self.values.iter().enumerate().map(|(i, value)| f(middle(self.size, i), *value)).collect();
        Grid { size: self.size, values }
    }

    /// The texel `x` to the right and `y` down, wrapped around.
    pub(super) fn wrapped(&self, x: i32, y: i32) -> T {
        let wrap = |i: i32| i.rem_euclid(self.size as i32) as usize;
        self.values[wrap(y) * self.size + wrap(x)]
    }
}

impl Grid<f32> {
    /// The same numbers, stretched so that the lowest is 0 and the highest 1.
    pub(super) fn normalized(mut self) -> Self {
        let (low, high) = self.values.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
        let width = (high - low).max(1e-6);
        self.values.iter_mut().for_each(|x| *x = (*x - low) / width);
        self
    }

    /// Means over squares of `2 radius + 1` texels, twice: close to a bell.
    pub(super) fn blurred(&self, radius: usize) -> Self {
        let mut grid = self.clone();
        for _ in 0..2 {
            grid = grid.blurred_along(radius, [1, 0]).blurred_along(radius, [0, 1]);
        }
        grid
    }

    fn blurred_along(&self, radius: usize, [dx, dy]: [i32; 2]) -> Self {
        let reach = radius as i32;
        let mut values = vec![0.0; self.values.len()];
        for line in 0..self.size as i32 {
            let at = |k: i32| self.wrapped(k * dx + line * dy, k * dy + line * dx);
            let mut sum: f32 = (-reach..=reach).map(at).sum();
            for k in 0..self.size as i32 {
                values[((k * dy + line * dx) * self.size as i32 + k * dx + line * dy) as usize] = sum / (2 * reach + 1) as f32;
                sum += at(k + reach + 1) - at(k - reach);
            }
        }
        Self { size: self.size, values }
    }

    /// Directions of a surface whose heights 0 to 1 span `relief` sides of the tile: unit vectors, +X to the right, +Y up.
    fn directions(&self, relief: f32) -> Grid<Vec3> {
        let n = self.size as i32;
        let slope = 0.5 * relief * self.size as f32;
        let direction = |i: i32| {
            let (x, y) = (i % n, i / n);
            let right = self.wrapped(x + 1, y) - self.wrapped(x - 1, y);
            let down = self.wrapped(x, y + 1) - self.wrapped(x, y - 1);
            Vec3::new(-right * slope, down * slope, 1.0).normalize()
        };
        Grid { size: self.size, values: (0..n * n).map(direction).collect() }
    }
}

/// What a generator makes: the maps that its row in the table names, and no others.
pub(super) struct Surface {
    /// Linear reflectance.
    pub(super) base_color: Option<Grid<Vec3>>,
    /// 0 to 1.
    pub(super) roughness: Option<Grid<f32>>,
    /// 0 to 1.
    pub(super) metallic: Option<Grid<f32>>,
    /// In turns, 0 to 1.
    pub(super) anisotropy_rotation: Option<Grid<f32>>,
    /// 0 to 1.
    pub(super) height: Option<Grid<f32>>,
    /// Directions that do not come from the height.
    pub(super) normal: Option<Grid<Vec3>>,
    /// Difference between the heights 0 and 1 in sides of the tile; what the normals are made from.
    pub(super) relief: f32,
}

impl Surface {
    /// A surface of these heights, of any range.
    pub(super) fn of_height(height: Grid<f32>, relief: f32) -> Self {
        let height = Some(height.normalized());
        Self { height, relief, base_color: None, roughness: None, metallic: None, anisotropy_rotation: None, normal: None }
    }

    /// A surface of these directions, without height.
    pub(super) fn of_directions(normal: Grid<Vec3>) -> Self {
        let normal = Some(normal);
        Self { normal, relief: 0.0, base_color: None, roughness: None, metallic: None, anisotropy_rotation: None, height: None }
    }

    /// With these colours; `color` gets the place and the height.
    pub(super) fn colored(mut self, mut color: impl FnMut(Vec2, f32) -> Vec3) -> Self {
        self.base_color = self.height.as_ref().map(|height| height.map(|p, h| color(p, h).clamp(Vec3::ZERO, Vec3::ONE)));
        self
    }

    /// With this roughness; `roughness` gets the place and the height.
    pub(super) fn rough(mut self, mut roughness: impl FnMut(Vec2, f32) -> f32) -> Self {
        self.roughness = self.height.as_ref().map(|height| height.map(|p, h| roughness(p, h).clamp(0.0, 1.0)));
        self
    }

    /// The directions, stored as 0 to 1.
    pub(super) fn normal_image(&self) -> Option<Image> {
        let from_height = || Some(self.height.as_ref()?.directions(self.relief));
        self.normal.clone().or_else(from_height).map(|grid| grid.map(|_, n| n * 0.5 + 0.5).image())
    }
}

impl Grid<f32> {
    /// As an image with the value in all three channels.
    pub(super) fn image(&self) -> Image {
        self.map(|_, x| Vec3::splat(x)).image()
    }
}

impl Grid<Vec3> {
    /// As an image of linear values.
    pub(super) fn image(&self) -> Image {
        let texels = self.values.iter().map(|v| v.extend(1.0).to_array()).collect();
        Image { width: self.size, height: self.size, texels, is_eight_bit: false }
    }
}

/// A colour between several: `stops` are places in 0 to 1, in order, with their colours; smooth between.
pub(super) fn ramp(stops: &[(f32, Vec3)], x: f32) -> Vec3 {
    let mut color = stops[0].1;
    for pair in stops.windows(2) {
        color = color.lerp(pair[1].1, smoothstep(pair[0].0, pair[1].0, x));
    }
    color
}

/// A linear colour from the sRGB bytes that a picture of it would have.
pub(super) fn srgb(hex: u32) -> Vec3 {
    let decode = |byte: u32| {
        let x = (byte & 0xFF) as f32 / 255.0;
        if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
    };
    Vec3::new(decode(hex >> 16), decode(hex >> 8), decode(hex))
}

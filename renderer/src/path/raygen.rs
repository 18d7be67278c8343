//! First stage: camera rays.

use super::batch::Paths;
use super::sampler::{Group, MAX_LANES, Words, draw, pixel_seed};
use super::{Prepared, REPLICATES};
use crate::bsdf::dispersion::spectrum;
use crate::bvh::NONE;
use crate::lanes::{Kernel, Lanes};
use crate::scene::CameraBasis;
use crate::vector::V3;
use glam::Vec3;

/// A rectangle of pixels and a run of samples for each of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tile {
    /// Left column.
    pub x: usize,
    /// Upper row.
    pub y: usize,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Number of the first sample.
    pub first: u32,
    /// Samples per pixel.
    pub count: u32,
}

impl Tile {
    /// Number of paths.
    pub(super) fn paths(&self) -> usize {
        self.width * self.height * self.count as usize
    }

    /// Pixel within the tile and sample number of a path: all samples of a pixel follow each other, so their rays stay together.
    pub(super) fn place(&self, path: usize) -> (usize, u32) {
        (path / self.count as usize, self.first + (path % self.count as usize) as u32)
    }
}

/// The camera in normalised units and the size of the picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    /// Basis with the origin in normalised units.
    pub basis: CameraBasis,
    /// Columns of the picture.
    pub width: usize,
    /// Rows of the picture.
    pub height: usize,
}

impl View {
    /// The view of a scene at a resolution.
    pub(super) fn new(prepared: &Prepared, width: usize, height: usize) -> Self {
        let mut basis = prepared.camera.basis(width as f32 / height.max(1) as f32);
        basis.origin = prepared.geometry.normalized(basis.origin);
        Self { basis, width, height }
    }
}

/// Fills the state of every path of a tile.
pub(super) struct Raygen<'a> {
    pub prepared: &'a Prepared,
    pub view: &'a View,
    pub tile: Tile,
    pub seed: u64,
    pub paths: &'a mut Paths,
}

impl Kernel for Raygen<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { prepared, view, tile, seed, paths } = self;
        let total = tile.paths();
        let medium = &prepared.camera_medium;
        // Where nothing reads images, footprints are nobody's concern.
        let spread = if prepared.has_images { view.spread() } else { 0.0 };
        let (forward, right, up) = (splat(view.basis.forward), splat(view.basis.right), splat(view.basis.up));
        let mut start = 0;
        while start < total {
            let live = L::WIDTH.min(total - start);
            let mut seeds: Words = [0; MAX_LANES];
            let mut indices: Words = [0; MAX_LANES];
            let mut corner = [[0.0f32; MAX_LANES]; 2];
            for lane in 0..live {
                let (pixel, sample) = tile.place(start + lane);
                let (x, y) = (tile.x + pixel % tile.width, tile.y + pixel / tile.width);
                seeds[lane] = pixel_seed(seed, sample % REPLICATES as u32, (y * view.width + x) as u32);
                indices[lane] = sample / REPLICATES as u32;
                corner[0][lane] = x as f32;
                corner[1][lane] = y as f32;
            }
            let u = draw::<L>(Group::Pixel, 0, &seeds, &indices);
            let x = (L::from_fn(|i| corner[0][i]) + u[0]) * L::of(2.0 / view.width as f64) - L::one();
            let y = L::one() - (L::from_fn(|i| corner[1][i]) + u[1]) * L::of(2.0 / view.height as f64);
            let direction = (forward + right.scale(x) + up.scale(y)).normalize();
            for lane in 0..live {
                let path = start + lane;
                let d = [direction.x.lane(lane), direction.y.lane(lane), direction.z.lane(lane)];
                let o = view.basis.origin.to_array();
                for k in 0..3 {
                    paths.origin[k][path] = o[k];
                    paths.direction[k][path] = d[k];
                    paths.throughput[k][path] = 1.0;
                    paths.radiance[k][path] = 0.0;
                    paths.sigma_a[k][path] = medium.sigma_a[k];
                    paths.sigma_s[k][path] = medium.sigma_s[k];
                }
                if prepared.has_dispersion {
                    paths.wavelength[path] = spectrum().wavelength(f64::from(u[2].lane(lane))) as f32;
                }
                paths.is_dispersed[path] = false;
                paths.is_connected[path] = false;
                paths.body[path] = medium.object;
                paths.pdf[path] = 0.0;
                paths.cone_width[path] = 0.0;
                paths.cone_spread[path] = spread;
                paths.bounces[path] = 0;
                paths.excluded[path] = NONE;
                paths.seeds[path] = seeds[lane];
                paths.indices[path] = indices[lane];
                paths.is_covered[path] = false;
            }
            start += L::WIDTH;
        }
    }
}

/// One vector in every lane.
#[inline(always)]
pub(super) fn splat<L: Lanes>(v: Vec3) -> V3<L> {
    V3::new(L::of(f64::from(v.x)), L::of(f64::from(v.y)), L::of(f64::from(v.z)))
}

//! First stage: camera rays.

use super::batch::Paths;
use super::film::{Film, Window};
use super::sampler::{Group, MAX_LANES, Words, draw, pixel_seed};
use super::{Prepared, REPLICATES};
use crate::bsdf::dispersion::spectrum;
use crate::bvh::NONE;
use crate::lanes::{Kernel, Lanes};
use crate::scene::CameraBasis;
use crate::vector::V3;
use glam::Vec3;

/// Where a path belongs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Number of the pixel among those of its job.
    pub cell: u32,
    /// Pixel of the picture, row by row.
    pub pixel: u32,
    /// Sample number within the pixel.
    pub sample: u32,
}

/// The paths of a batch. All samples of a pixel follow each other, so their rays stay together.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tile<'a> {
    /// One entry per path.
    pub places: &'a [Place],
}

impl Tile<'_> {
    /// Number of paths.
    pub(super) fn paths(&self) -> usize {
        self.places.len()
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
    /// Columns of the film, and the column and row of the picture where it begins.
    film: [usize; 3],
}

impl View {
    /// The view of a scene at a resolution.
    pub(super) fn new(prepared: &Prepared, width: usize, height: usize) -> Self {
        let mut basis = prepared.camera.basis(width as f32 / height.max(1) as f32);
        basis.origin = prepared.geometry.normalized(basis.origin);
        Self { basis, width, height, film: [width, 0, 0] }
    }

    /// The view of the picture that a film belongs to.
    pub(super) fn of_film(prepared: &Prepared, film: &Film) -> Self {
        let Window { full: [width, height], at: [x, y] } = film.window;
        Self { film: [film.width, x, y], ..Self::new(prepared, width, height) }
    }

    /// The pixel of the picture that a pixel of the film is.
    pub(super) fn in_picture(&self, pixel: u32) -> u32 {
        let ([columns, x, y], pixel) = (self.film, pixel as usize);
        ((pixel / columns + y) * self.width + pixel % columns + x) as u32
    }
}

/// Fills the state of every path of a tile.
pub(super) struct Raygen<'a> {
    pub prepared: &'a Prepared,
    pub view: &'a View,
    pub tile: Tile<'a>,
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
                let Place { pixel, sample, .. } = tile.places[start + lane];
                let (x, y) = (pixel % view.width as u32, pixel / view.width as u32);
                seeds[lane] = pixel_seed(seed, sample % REPLICATES as u32, pixel);
                indices[lane] = sample / REPLICATES as u32;
                corner[0][lane] = x as f32;
                corner[1][lane] = y as f32;
            }
            let u = draw::<L>(Group::Pixel, 0, &seeds, &indices);
            let x = (L::from_array(&corner[0]) + u[0]) * L::of(2.0 / view.width as f64) - L::one();
            let y = L::one() - (L::from_array(&corner[1]) + u[1]) * L::of(2.0 / view.height as f64);
            let direction = (forward + right.scale(x) + up.scale(y)).normalize();
            let place = start..start + live;
            let store = |column: &mut [f32], x: L| column[place.clone()].copy_from_slice(&x.to_array()[..live]);
            let origin = view.basis.origin.to_array();
            for (k, d) in [direction.x, direction.y, direction.z].into_iter().enumerate() {
                store(&mut paths.direction[k], d);
                paths.origin[k][place.clone()].fill(origin[k]);
                paths.throughput[k][place.clone()].fill(1.0);
                paths.radiance[k][place.clone()].fill(0.0);
                paths.sigma_a[k][place.clone()].fill(medium.sigma_a[k]);
                paths.sigma_s[k][place.clone()].fill(medium.sigma_s[k]);
            }
            if prepared.has_dispersion {
                let u = u[2].to_array();
                for (wavelength, u) in paths.wavelength[place.clone()].iter_mut().zip(u) {
                    *wavelength = spectrum().wavelength(f64::from(u)) as f32;
                }
            }
            paths.is_dispersed[place.clone()].fill(false);
            paths.is_connected[place.clone()].fill(false);
            paths.body[place.clone()].fill(medium.object);
            paths.pdf[place.clone()].fill(0.0);
            paths.cone_width[place.clone()].fill(0.0);
            paths.cone_spread[place.clone()].fill(spread);
            paths.bounces[place.clone()].fill(0);
            paths.excluded[place.clone()].fill(NONE);
            paths.seeds[place.clone()].copy_from_slice(&seeds[..live]);
            paths.indices[place.clone()].copy_from_slice(&indices[..live]);
            for column in [&mut paths.is_covered, &mut paths.is_from_receiver, &mut paths.is_cold, &mut paths.is_lit] {
                column[place.clone()].fill(false);
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

//! Small pictures with equal random numbers, so that what two of them have in common has no noise in their difference.

use burnish::exchange::measure::Shown;
use burnish::files::load_textures;
use burnish::library::setup::{Frame, Setup, Stage};
use burnish::picture_diff::mean_flip;
use burnish_assets::Image;
use burnish_material::{Material, Property};
use burnish_renderer::path::{Prepared, Settings, StopRules, render_prepared};
use burnish_renderer::scene::TextureSet;
use burnish_renderer::tonemap::Display;
use std::sync::Arc;
use std::time::Instant;

/// Columns and rows.
pub const SIDE: usize = 64;
/// Samples per pixel of materials that no light enters, and of others.
pub const SAMPLES: [u32; 2] = [64, 32];

/// Columns of images at most: finer texels would not be seen in pictures of this size.
pub const TEXELS: usize = 256;

/// Pixels, display-referred.
pub type Picture = Vec<[f32; 3]>;

/// What all pictures have in common.
pub struct Studio {
    setup: Setup,
    threads: usize,
    last: Option<Prepared>,
    /// Pictures so far.
    pub drawn: usize,
}

/// Whether light goes into a material.
pub fn is_entered(material: &Material) -> bool {
    let property = Property::translucency;
    material.float(property) > 0.0 || material.is_textured(property)
}

/// Samples per pixel for a material.
pub fn samples(material: &Material) -> u32 {
    SAMPLES[usize::from(is_entered(material))]
}

/// Images of a material, halved until they are small enough. An error if one cannot be read.
pub fn images(material: &Material) -> Result<TextureSet, String> {
    let (textures, problems) = load_textures(material, None);
    match problems.into_iter().next() {
        Some(problem) => Err(problem),
        None => Ok(textures.into_iter().map(|(path, image)| (path, small(image))).collect()),
    }
}

fn small(image: Arc<Image>) -> Arc<Image> {
    if image.width <= TEXELS || image.width % 2 + image.height % 2 > 0 {
        return image;
    }
    let (width, height) = (image.width / 2, image.height / 2);
    let texel = |place: usize| {
        let first = place / width * 2 * image.width + place % width * 2;
        let four = [0, 1, image.width, image.width + 1].map(|step| image.texels[first + step]);
        std::array::from_fn(|k| four.iter().map(|texel| texel[k]).sum::<f32>() / 4.0)
    };
    small(Arc::new(Image { width, height, texels: (0..width * height).map(texel).collect(), ..*image }))
}

impl Studio {
    pub fn new() -> Result<Self, Box<dyn std::error::Error>> {
        let setup = Setup::new(Stage::standard().ok_or("there is no built-in scene")?, Frame::default(), Vec::new());
        Ok(Self { setup, threads: std::thread::available_parallelism()?.get(), last: None, drawn: 0 })
    }

    pub fn picture(&mut self, shown: Shown<'_>, spp: u32, seed: u64) -> Picture {
        let scene = self.setup.scene_of(shown.material.clone(), shown.textures.clone());
        let prepared = &*self.last.insert(Prepared::new(&scene, self.last.as_ref()));
        let stop = StopRules { spp: Some(spp), ..StopRules::default() };
        // Evenly, so that both sides have the same samples everywhere.
        let settings = Settings { width: SIDE, height: SIDE, seed, threads: self.threads, stop, is_adaptive: false };
        let rendering = render_prepared(prepared, &settings, Instant::now(), &mut |_| true);
        self.drawn += 1;
        rendering.film.mean().iter().map(|rgb| Display::default().apply(*rgb)).collect()
    }

    /// Draws another material, and tells how far its picture is from the first, as mean of FLIP.
    pub fn flip(&mut self, first: &Picture, other: Shown<'_>, spp: u32, seed: u64) -> f64 {
        mean_flip(first, &self.picture(other, spp, seed), SIDE)
    }
}

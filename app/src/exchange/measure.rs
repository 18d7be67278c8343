//! How different a material looks after a translation, and which property that is due to: pictures before and after, and their FLIP.

use super::bake::bake;
use crate::library::setup::Setup;
use crate::picture_diff::{self, Drawing, mean_flip};
use burnish_assets::Image;
use burnish_material::exchange::ShadingModel;
use burnish_material::exchange::loss::{Fate, Row};
use burnish_material::exchange::model::Context;
use burnish_material::exchange::plan::{Job, Texel};
use burnish_material::{Channel, ColorSpace, Kind, Material, Property, TextureRef};
use burnish_renderer::scene::TextureSet;
use std::sync::Arc;

/// Properties that are tried one by one, at most: those that are said to lose most come first.
const MAX_TRIED: usize = 12;

/// A material with its images.
#[derive(Clone, Copy, Debug)]
pub struct Shown<'a> {
    /// The material.
    pub material: &'a Material,
    /// Its images by the path that it names.
    pub textures: &'a TextureSet,
}

/// What a translation costs, seen.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// Mean of FLIP between the picture before and the one after, 0 to 1.
    pub flip_mean: f64,
    /// Properties that were tried alone, with the mean of FLIP that each gives, the largest first.
    pub by_property: Vec<(Property, f64)>,
}

impl Measured {
    /// The property that the difference is due to: the one that gives most of it alone. `None` where there is nothing to explain.
    pub fn explanation(&self) -> Option<(Property, f64)> {
        /// Smaller differences are noise of the pictures.
        const NOISE: f64 = 0.002;
        self.by_property.first().copied().filter(|(_, flip)| *flip > NOISE)
    }
}

/// Properties that a picture can show the loss of, those that are said to lose most first.
pub fn suspects(before: &Material, after: &Material, rows: &[Row]) -> Vec<Property> {
    let differs = |row: &&Row| before.slot(row.property) != after.slot(row.property);
    let is_suspect = |row: &&Row| row.fate > Fate::Remapped && row.has_effect && differs(row);
    let mut suspects: Vec<&Row> = rows.iter().filter(is_suspect).collect();
    suspects.sort_by_key(|row| std::cmp::Reverse(row.fate));
    suspects.truncate(MAX_TRIED);
    suspects.into_iter().map(|row| row.property).collect()
}

/// The material before with one property from after.
pub fn with_one(before: Shown<'_>, after: Shown<'_>, property: Property) -> (Material, TextureSet) {
    let mut changed = before.material.clone();
    *changed.slot_mut(property) = after.material.slot(property).clone();
    // Images of both: the slot may name either's.
    let mut textures = before.textures.clone();
    textures.extend(after.textures.iter().map(|(name, image)| (name.clone(), image.clone())));
    (changed, textures)
}

/// Draws a material before and after a translation, then before with one property after the other from after. `tell` hears the share that is
/// done, 0 to 1. `None` if it is cancelled.
pub fn measure(
    setup: &Setup,
    before: Shown<'_>,
    after: Shown<'_>,
    rows: &[Row],
    drawing: &Drawing,
    tell: &mut dyn FnMut(f32),
    is_cancelled: &dyn Fn() -> bool,
) -> Option<Measured> {
    let suspects = suspects(before.material, after.material, rows);
    let (mut done, steps) = (0.0, suspects.len() as f32 + 2.0);
    let mut last = None;
    let mut picture = |shown: Shown<'_>| {
        let scene = setup.scene_of(shown.material.clone(), shown.textures.clone());
        let picture = picture_diff::picture(&scene, &mut last, drawing, &mut |share| tell((done + share) / steps), is_cancelled)?;
        done += 1.0;
        Some(picture)
    };
    let first = picture(before)?;
    let mut flip = |other: Shown<'_>| Some(mean_flip(&first, &picture(other)?, drawing.size[0]));
    let flip_mean = flip(after)?;
    let mut by_property = Vec::new();
    for property in suspects {
        let (material, textures) = with_one(before, after, property);
        by_property.push((property, flip(Shown { material: &material, textures: &textures })?));
    }
    by_property.sort_by(|(_, a), (_, b)| b.total_cmp(a));
    Some(Measured { flip_mean, by_property })
}

/// The material that other programs see: the way there and back without the native copy, with the images that had to be computed.
pub fn without_native_copy(model: &ShadingModel, shown: Shown<'_>, context: &Context) -> (Material, TextureSet) {
    let mut translation = model.translate(shown.material, context);
    let mut textures = shown.textures.clone();
    for image in &translation.images {
        let Some((def, field)) = model.fields.get(image.field).zip(translation.fields.0.get_mut(image.field)) else { continue };
        let count = def.default.numbers().len();
        let channel = |component: usize| match component < count {
            true => Texel::Number { field: image.field, component, factor: 1.0 },
            false => Texel::ONE,
        };
        let is_srgb = count == 3 && def.default.kind() == Kind::Color;
        let file = format!("{}: computed", def.name);
        let channels = [channel(0), channel(1), channel(2), Texel::ONE];
        let job = Job { file: file.clone(), material: 0, from: image.from.clone(), is_in_place: false, is_srgb, channels };
        let Some(baked) = bake(&job, model, shown.material, shown.textures, context, &|_| true) else { continue };
        let texels = baked.rgba.chunks_exact(4).map(|t| [t[0], t[1], t[2], t[3]].map(|x| f32::from(x) / 255.0)).collect();
        let made = Image { width: baked.width, height: baked.height, texels, is_eight_bit: true };
        let space = if is_srgb { ColorSpace::Srgb } else { ColorSpace::Linear };
        let channel = if count == 1 { Channel::R } else { Channel::Rgb };
        field.texture = Some(TextureRef { color_space: space, channel, ..TextureRef::new(file.clone()) });
        textures.insert(file, Arc::new(made));
    }
    let mut material = model.interpret(&translation.fields, context, &mut Vec::new());
    material.unit_mm = shown.material.unit_mm;
    (material, textures)
}

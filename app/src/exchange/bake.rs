//! Images that a translation needs and nobody has: computed texel by texel, by the formulas of the translation itself.

use burnish_assets::Image;
use burnish_material::exchange::ShadingModel;
use burnish_material::exchange::model::Context;
use burnish_material::exchange::plan::Job;
use burnish_material::{Material, Property, TextureRef, Value, Wrap};
use burnish_renderer::scene::TextureSet;
use burnish_renderer::texel;
use std::sync::Arc;

/// Largest side of an image that is computed.
const MAX_SIDE: usize = 8192;

/// An image of 8 bits per channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Baked {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Red, green, blue and alpha as stored, row by row from the top.
    pub rgba: Vec<u8>,
}

/// A map of a property, looked up in 0 to 1 of its image.
struct Map<'a> {
    property: Property,
    reference: &'a TextureRef,
    image: &'a Arc<Image>,
}

/// Computes an image. As large as the largest that it is made of, at most [`MAX_SIDE`] a side; one texel if it is made of none.
///
/// Maps that could not be read are left at the value of the material. `None` once `go_on` says no.
pub fn bake(
    job: &Job,
    model: &ShadingModel,
    material: &Material,
    textures: &TextureSet,
    context: &Context,
    go_on: &dyn Fn(f32) -> bool,
) -> Option<Baked> {
    let map = |property: &Property| {
        let reference = material.slot(*property).texture.as_ref()?;
        let image = textures.get(&reference.path).filter(|image| image.width > 0 && image.height > 0)?;
        Some(Map { property: *property, reference, image })
    };
    let maps: Vec<Map<'_>> = job.from.iter().filter_map(map).collect();
    let side = |of: fn(&Image) -> usize| maps.iter().map(|map| of(map.image)).max().unwrap_or(1).min(MAX_SIDE);
    let (width, height) = (side(|image| image.width), side(|image| image.height));
    let base = material.inputs();
    let mut rgba = Vec::with_capacity(width * height * 4);
    let (mut last, mut stored): (Vec<Value>, _) = (Vec::new(), [0; 4]);
    for y in 0..height {
        if !go_on(y as f32 / height as f32) {
            return None;
        }
        for x in 0..width {
            let at = [(x as f64 + 0.5) / width as f64, (y as f64 + 0.5) / height as f64];
            let values: Vec<Value> = maps.iter().map(|map| map.value(at, job.is_in_place)).collect();
            // Neighbours are often the same.
            if values != last || rgba.is_empty() {
                let mut inputs = base;
                for (map, value) in maps.iter().zip(&values) {
                    inputs.set(map.property, *value);
                }
                let channels = job.texel(model, &inputs, context);
                stored = std::array::from_fn(|k| byte(channels[k], job.is_srgb && k < 3));
                last = values;
            }
            rgba.extend(stored);
        }
    }
    Some(Baked { width, height, rgba })
}

fn byte(linear: f64, is_srgb: bool) -> u8 {
    let x = linear as f32;
    let x = if is_srgb { burnish_renderer::tonemap::srgb_encode(x) } else { x };
    (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

impl Map<'_> {
    /// The property's value at a place of the result, within its range.
    fn value(&self, at: [f64; 2], is_in_place: bool) -> Value {
        let placed = || self.reference.transform().map(|[a, b, shift]| a * at[0] + b * at[1] + shift);
        let [u, v] = if is_in_place { at } else { placed() };
        let read = self.filtered(u, v);
        let limits = self.property.def().limits;
        let kept = |k: usize| limits.enforce(f64::from(read[k]));
        match self.property.def().default {
            Value::Color(_) => Value::Color([kept(0), kept(1), kept(2)]),
            Value::Float(_) => Value::Float(kept(0)),
            Value::Normal(_) => Value::Normal(read.map(f64::from)),
            value @ Value::Bool(_) => value,
        }
    }

    /// Linear value between the four nearest texels. Where the result is as large as this image, that is one texel.
    fn filtered(&self, u: f64, v: f64) -> [f32; 3] {
        let (width, height) = (self.image.width, self.image.height);
        let (x, y) = (u * width as f64 - 0.5, v * height as f64 - 0.5);
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = ((x - x0) as f32, (y - y0) as f32);
        let texel = |i: f64, j: f64| {
            let (i, j) = (self.wrapped(i, width), self.wrapped(j, height));
            texel::decode(self.image.texels[j * width + i], self.property, self.reference, self.image.is_eight_bit)
        };
        let mix = |a: [f32; 3], b: [f32; 3], t: f32| -> [f32; 3] {
            // Exactly one of both where there is nothing between them.
            std::array::from_fn(|k| {
                if t < 1e-4 {
                    a[k]
                } else if t > 1.0 - 1e-4 {
                    b[k]
                } else {
                    a[k] + (b[k] - a[k]) * t
                }
            })
        };
        let upper = mix(texel(x0, y0), texel(x0 + 1.0, y0), fx);
        mix(upper, mix(texel(x0, y0 + 1.0), texel(x0 + 1.0, y0 + 1.0), fx), fy)
    }

    fn wrapped(&self, i: f64, count: usize) -> usize {
        let (i, count) = (if i.is_finite() { i as i64 } else { 0 }, count as i64);
        let place = match self.reference.wrap {
            Wrap::Repeat => i.rem_euclid(count),
            Wrap::Clamp => i.clamp(0, count - 1),
            Wrap::Mirror => {
                let folded = i.rem_euclid(2 * count);
                folded.min(2 * count - 1 - folded)
            }
        };
        place as usize
    }
}

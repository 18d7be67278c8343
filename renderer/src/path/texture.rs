//! Images on surfaces: bilinear lookups that overwrite the uniform values of a material, lane by lane.

use super::sampler::MAX_LANES;
use crate::lanes::Lanes;
use crate::scene::Object;
use crate::tonemap::srgb_decode;
use burnish_assets::Image;
use burnish_material::{Channel, ColorSpace, Inputs, Kind, Property, TextureRef, Value, Wrap};
use std::sync::Arc;

/// Lanes of a texture lookup: three channels each.
pub(super) type Texels = [[f32; MAX_LANES]; 3];

/// One image in the slot of one property.
#[derive(Clone, Debug)]
pub(super) struct Texture {
    /// The property whose value it replaces.
    pub property: Property,
    image: Arc<Image>,
    channel: Channel,
    wrap: Wrap,
    /// uv to image coordinates: two rows of three.
    transform: [[f32; 3]; 2],
    /// Linear values of the 256 stored ones; empty where stored values are linear.
    decode: Vec<f32>,
    is_srgb: bool,
    /// What stands for a texel that is not finite.
    default: [f32; 3],
}

impl Texture {
    /// The textures of an object that can be shown: slots whose image is there.
    pub(super) fn all_of(object: &Object) -> Vec<Self> {
        object
            .material
            .slots()
            .filter_map(|(property, slot)| {
                let reference = slot.texture.as_ref()?;
                let image = object.textures.get(&reference.path)?;
                let is_complete = image.width > 0 && image.height > 0 && image.texels.len() >= image.width * image.height;
                is_complete.then(|| Self::new(property, reference, image))
            })
            .collect()
    }

    fn new(property: Property, reference: &TextureRef, image: &Arc<Image>) -> Self {
        let def = property.def();
        let is_srgb = match reference.color_space {
            ColorSpace::Auto => image.is_eight_bit && def.default.kind() == Kind::Color,
            ColorSpace::Srgb => true,
            ColorSpace::Linear => false,
        };
        let decode =
            if is_srgb && image.is_eight_bit { (0..256).map(|i| srgb_decode(i as f32 / 255.0)).collect() } else { Vec::new() };
        // Scale, then rotation, then shift; v grows downwards, so a counterclockwise turn has the sine below the diagonal negative.
        let (sin, cos) = reference.uv_rotation.to_radians().sin_cos();
        let [su, sv] = reference.uv_scale;
        let [ou, ov] = reference.uv_offset;
        let transform = [[cos * su, sin * sv, ou], [-sin * su, cos * sv, ov]];
        let default = match def.default {
            Value::Color(v) | Value::Normal(v) => v.map(|x| x as f32),
            Value::Float(v) => [v as f32; 3],
            Value::Bool(_) => [0.0; 3],
        };
        Self {
            property,
            image: image.clone(),
            channel: reference.channel,
            wrap: reference.wrap,
            transform: transform.map(|row| row.map(|x| x as f32)),
            decode,
            is_srgb,
            default,
        }
    }

    /// Linear value at a texture coordinate. A scalar stands in all three numbers.
    pub(super) fn lookup(&self, uv: [f32; 2]) -> [f32; 3] {
        let at = |row: [f32; 3]| row[0] * uv[0] + row[1] * uv[1] + row[2];
        let (width, height) = (self.image.width, self.image.height);
        let (x0, x1, fx) = self.taps(at(self.transform[0]), width);
        let (y0, y1, fy) = self.taps(at(self.transform[1]), height);
        let tap = |x: usize, y: usize| self.texel(y * width + x);
        let (a, b, c, d) = (tap(x0, y0), tap(x1, y0), tap(x0, y1), tap(x1, y1));
        let value: [f32; 3] = std::array::from_fn(|k| {
            let upper = a[k] + (b[k] - a[k]) * fx;
            let lower = c[k] + (d[k] - c[k]) * fx;
            upper + (lower - upper) * fy
        });
        std::array::from_fn(|k| if value[k].is_finite() { value[k] } else { self.default[k] })
    }

    /// Two neighbouring texels along an axis and the weight of the second.
    fn taps(&self, u: f32, size: usize) -> (usize, usize, f32) {
        let u = if u.is_finite() { u } else { 0.0 };
        // Wrapping before scaling keeps the digits of coordinates far from 0.
        let u = match self.wrap {
            Wrap::Repeat => u - u.floor(),
            Wrap::Clamp => u.clamp(0.0, 1.0),
            Wrap::Mirror => u - 2.0 * (u * 0.5).floor(),
        };
        let x = u * size as f32 - 0.5;
        let first = x.floor();
        let index = |i: i64| -> usize {
            let n = size as i64;
            let i = match self.wrap {
                Wrap::Repeat => i.rem_euclid(n),
                Wrap::Clamp => i.clamp(0, n - 1),
                Wrap::Mirror => {
                    let i = i.rem_euclid(2 * n);
                    if i < n { i } else { 2 * n - 1 - i }
                }
            };
            i as usize
        };
        (index(first as i64), index(first as i64 + 1), x - first)
    }

    fn texel(&self, at: usize) -> [f32; 3] {
        let t = self.image.texels[at];
        let decode = |x: f32| {
            if !self.is_srgb {
                x
            } else if self.decode.is_empty() {
                srgb_decode(x)
            } else {
                self.decode[(x * 255.0 + 0.5).clamp(0.0, 255.0) as usize]
            }
        };
        let channel = match self.channel {
            Channel::Rgb => {
                let c = [decode(t[0]), decode(t[1]), decode(t[2])];
                let is_scalar = self.property.def().default.kind() == Kind::Float;
                return if is_scalar { [(c[0] + c[1] + c[2]) / 3.0; 3] } else { c };
            }
            Channel::R => decode(t[0]),
            Channel::G => decode(t[1]),
            Channel::B => decode(t[2]),
            // Alpha is never encoded.
            Channel::A => t[3],
        };
        [channel; 3]
    }

    /// Overwrites the property in `inputs` with texels. Maps that only other stages use are left alone.
    #[inline(always)]
    pub(super) fn apply<L: Lanes>(&self, texels: &Texels, inputs: &mut Inputs<L>) {
        let number = |k: usize| L::from_fn(|i| texels[k][i]);
        if let Some(target) = color_mut(inputs, self.property) {
            *target = [number(0), number(1), number(2)];
        } else if let Some(target) = float_mut(inputs, self.property) {
            *target = number(0);
        }
    }
}

/// The field of a colour that may be textured.
#[inline(always)]
fn color_mut<L>(inputs: &mut Inputs<L>, property: Property) -> Option<&mut [L; 3]> {
    Some(match property {
        Property::base_color => &mut inputs.base_color,
        Property::specular_edge_color => &mut inputs.specular_edge_color,
        Property::normal => &mut inputs.normal,
        Property::emission_color => &mut inputs.emission_color,
        Property::sheen_color => &mut inputs.sheen_color,
        Property::absorption_color => &mut inputs.absorption_color,
        Property::scatter_color => &mut inputs.scatter_color,
        Property::scatter_distance_scale => &mut inputs.scatter_distance_scale,
        Property::coat_color => &mut inputs.coat_color,
        Property::coat_normal => &mut inputs.coat_normal,
        _ => return None,
    })
}

/// The field of a scalar that may be textured.
#[inline(always)]
fn float_mut<L>(inputs: &mut Inputs<L>, property: Property) -> Option<&mut L> {
    Some(match property {
        Property::roughness => &mut inputs.roughness,
        Property::metallic => &mut inputs.metallic,
        Property::opacity => &mut inputs.opacity,
        Property::specular_level => &mut inputs.specular_level,
        Property::anisotropy => &mut inputs.anisotropy,
        Property::anisotropy_rotation => &mut inputs.anisotropy_rotation,
        Property::sheen => &mut inputs.sheen,
        Property::sheen_roughness => &mut inputs.sheen_roughness,
        Property::translucency => &mut inputs.translucency,
        Property::coat => &mut inputs.coat,
        Property::coat_roughness => &mut inputs.coat_roughness,
        Property::coat_specular_level => &mut inputs.coat_specular_level,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use burnish_material::{Material, PROPERTIES, Vary};

    #[test]
    fn every_texturable_property_is_read() {
        let mut inputs: Inputs<f32> = Material::default().inputs().convert(|x| x as f32);
        for def in PROPERTIES.iter().filter(|def| def.vary == Vary::Texturable) {
            let is_read = color_mut(&mut inputs, def.id).is_some() || float_mut(&mut inputs, def.id).is_some();
            assert!(is_read, "{}", def.name);
        }
    }

    fn texture(
        property: Property,
        texels: Vec<[f32; 4]>,
        width: usize,
        is_eight_bit: bool,
        edit: impl Fn(&mut TextureRef),
    ) -> Texture {
        let image = Arc::new(Image { width, height: texels.len() / width, texels, is_eight_bit });
        let mut reference = TextureRef::new("a.png");
        edit(&mut reference);
        Texture::new(property, &reference, &image)
    }

    #[test]
    fn texels_are_found_where_they_are() {
        let texels: Vec<[f32; 4]> = (0..8).map(|i| [i as f32; 4]).collect();
        let t = texture(Property::roughness, texels.clone(), 4, false, |_| {});
        assert_eq!(t.lookup([0.125, 0.25])[0], 0.0);
        assert_eq!(t.lookup([0.875, 0.75])[0], 7.0);
        assert_eq!(t.lookup([0.25, 0.25])[0], 0.5);
        // Halfway between the last and the first column.
        assert_eq!(t.lookup([1.0, 0.25])[0], 1.5);
        let clamped = texture(Property::roughness, texels.clone(), 4, false, |r| r.wrap = Wrap::Clamp);
        assert_eq!([clamped.lookup([-3.0, 0.25])[0], clamped.lookup([9.0, 0.25])[0]], [0.0, 3.0]);
        let mirrored = texture(Property::roughness, texels.clone(), 4, false, |r| r.wrap = Wrap::Mirror);
        assert_eq!([mirrored.lookup([1.0, 0.25])[0], mirrored.lookup([1.125, 0.25])[0]], [3.0, 3.0]);
        let turned = texture(Property::roughness, texels, 4, false, |r| r.uv_rotation = 90.0);
        // (u, v) becomes (v, -u).
        assert!((turned.lookup([-0.25, 0.125])[0] - 0.0).abs() < 1e-5);
    }

    #[test]
    fn only_colours_of_eight_bits_are_decoded() {
        let grey = || vec![[0.5, 0.5, 0.5, 0.5]];
        let value = |p, bits, space| texture(p, grey(), 1, bits, |r| r.color_space = space).lookup([0.5, 0.5])[0];
        assert!((value(Property::base_color, true, ColorSpace::Auto) - 0.2159).abs() < 2e-3);
        assert_eq!(value(Property::base_color, false, ColorSpace::Auto), 0.5);
        assert_eq!(value(Property::roughness, true, ColorSpace::Auto), 0.5);
        assert!((value(Property::roughness, false, ColorSpace::Srgb) - 0.2140).abs() < 1e-3);
    }

    #[test]
    fn unusable_texels_are_the_default() {
        let t = texture(Property::roughness, vec![[f32::NAN; 4]], 1, false, |_| {});
        assert_eq!(t.lookup([0.5, 0.5])[0], 0.3);
    }
}

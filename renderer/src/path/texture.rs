//! Images on surfaces: filtered lookups that overwrite the uniform values of a material, lane by lane.
//!
//! A lookup takes the level whose texels are at most half as long as the footprint, and is bilinear there. One level instead of a
//! blend of two halves the reads; where the level changes, the difference stays finer than the pixel's own filter. The footprint's
//! shorter axis counts: the longer one of a slanted view is left to the samples of the pixel, since texels as long as that would
//! blur across it as well.

use super::mip::{Source, Sources};
use super::sampler::MAX_LANES;
use crate::lanes::Lanes;
use crate::scene::Object;
use burnish_material::{Inputs, Property, TextureRef, Wrap};
use std::sync::Arc;

/// Lanes of a texture lookup: three channels each.
pub(super) type Texels = [[f32; MAX_LANES]; 3];

/// Longest texel as a fraction of the footprint: the pixel's own filter stays the wider one.
const TEXEL_MAX: f32 = 0.5;

/// One image in the slot of one property.
#[derive(Clone, Debug)]
pub(super) struct Texture {
    /// The property whose value it replaces.
    pub property: Property,
    source: Arc<Source>,
    wrap: Wrap,
    /// uv to image coordinates: two rows of three.
    transform: [[f32; 3]; 2],
    /// Texels of the finest level per unit of uv: the root of their number per area.
    density: f32,
}

impl Texture {
    /// The textures of an object that shading reads: slots whose image is there, less those that act elsewhere or not at all.
    pub(super) fn all_of(object: &Object, sources: &mut Sources) -> Vec<Self> {
        let properties = object.material.slots().map(|(property, _)| property).filter(|p| is_read(*p));
        properties.filter_map(|p| Self::of(object, p, sources)).collect()
    }

    /// The texture in the slot of a property, if its image is there.
    pub(super) fn of(object: &Object, property: Property, sources: &mut Sources) -> Option<Self> {
        let reference = object.material.slot(property).texture.as_ref()?;
        let image = object.textures.get(&reference.path)?;
        let is_complete = image.width > 0 && image.height > 0 && image.texels.len() >= image.width * image.height;
        is_complete.then(|| Self::new(property, reference, sources.get(property, reference, image)))
    }

    fn new(property: Property, reference: &TextureRef, source: Arc<Source>) -> Self {
        let [su, sv] = reference.uv_scale;
        let (width, height) = source.size(0);
        let density = ((su * sv).abs() * (width * height) as f64).sqrt() as f32;
        Self {
            property,
            wrap: reference.wrap,
            transform: reference.transform().map(|row| row.map(|x| x as f32)),
            density,
            source,
        }
    }

    /// The value if it is the same everywhere.
    pub(super) fn constant(&self) -> Option<[f32; 3]> {
        self.source.constant()
    }

    /// The level for a footprint, a length in uv; 0 takes the finest.
    #[inline(always)]
    pub(super) fn level(&self, footprint: f32) -> usize {
        // The exponent is the logarithm to base 2, rounded down; what is below 1 and what is no number fall out on their own.
        let texels = footprint * self.density * TEXEL_MAX;
        let exponent = ((texels.to_bits() >> 23) & 0xff) as usize;
        if texels >= 2.0 { (exponent - 127).min(self.source.coarsest()) } else { 0 }
    }

    /// Linear value at a texture coordinate. A scalar stands in all three numbers.
    #[inline(always)]
    pub(super) fn lookup(&self, uv: [f32; 2], level: usize) -> [f32; 3] {
        self.sample(self.place(uv), level)
    }

    /// Derivatives of a scalar by u and by v: differences over one texel of the level, about the place.
    pub(super) fn gradient(&self, uv: [f32; 2], level: usize) -> [f32; 2] {
        let [x, y] = self.place(uv);
        let (width, height) = self.source.size(level);
        let (width, height) = (width as f32, height as f32);
        let at = |x: f32, y: f32| self.sample([x, y], level)[0];
        let (sx, sy) = (0.5 / width, 0.5 / height);
        let dx = (at(x + sx, y) - at(x - sx, y)) * width;
        let dy = (at(x, y + sy) - at(x, y - sy)) * height;
        let [a, b] = self.transform;
        [dx * a[0] + dy * b[0], dx * a[1] + dy * b[1]]
    }

    /// Image coordinates, brought near 0 where that changes nothing: the digits of a step of half a texel are kept.
    #[inline(always)]
    fn place(&self, uv: [f32; 2]) -> [f32; 2] {
        self.transform.map(|row| {
            let u = row[0] * uv[0] + row[1] * uv[1] + row[2];
            let u = if u.is_finite() { u } else { 0.0 };
            match self.wrap {
                Wrap::Repeat => u - u.floor(),
                Wrap::Clamp => u,
                Wrap::Mirror => u - 2.0 * (u * 0.5).floor(),
            }
        })
    }

    #[inline(always)]
    fn sample(&self, [x, y]: [f32; 2], level: usize) -> [f32; 3] {
        let (width, height) = self.source.size(level);
        let (x0, x1, fx) = self.taps(x, width);
        let (y0, y1, fy) = self.taps(y, height);
        let tap = |x: usize, y: usize| self.source.texel(level, x, y);
        let (a, b, c, d) = (tap(x0, y0), tap(x1, y0), tap(x0, y1), tap(x1, y1));
        self.source.value(std::array::from_fn(|k| {
            let upper = a[k] + (b[k] - a[k]) * fx;
            let lower = c[k] + (d[k] - c[k]) * fx;
            upper + (lower - upper) * fy
        }))
    }

    /// Two neighbouring texels along an axis and the weight of the second.
    #[inline(always)]
    fn taps(&self, u: f32, size: usize) -> (usize, usize, f32) {
        let u = if self.wrap == Wrap::Clamp { u.clamp(0.0, 1.0) } else { u };
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

/// Whether shading reads a texture of this property: neither the height, which acts on geometry, nor maps for rasterisers.
fn is_read(property: Property) -> bool {
    !matches!(property, Property::height | Property::ambient_occlusion | Property::volume_thickness)
}

#[cfg(test)]
mod tests {
    use super::*;
    use burnish_assets::Image;
    use burnish_material::{ColorSpace, Material, PROPERTIES, Vary};

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
        Texture::new(property, &reference, Sources::default().get(property, &reference, &image))
    }

    #[test]
    fn texels_are_found_where_they_are() {
        let texels: Vec<[f32; 4]> = (0..8).map(|i| [i as f32; 4]).collect();
        let t = texture(Property::roughness, texels.clone(), 4, false, |_| {});
        assert_eq!(t.lookup([0.125, 0.25], 0)[0], 0.0);
        assert_eq!(t.lookup([0.875, 0.75], 0)[0], 7.0);
        assert_eq!(t.lookup([0.25, 0.25], 0)[0], 0.5);
        // Halfway between the last and the first column.
        assert_eq!(t.lookup([1.0, 0.25], 0)[0], 1.5);
        let clamped = texture(Property::roughness, texels.clone(), 4, false, |r| r.wrap = Wrap::Clamp);
        assert_eq!([clamped.lookup([-3.0, 0.25], 0)[0], clamped.lookup([9.0, 0.25], 0)[0]], [0.0, 3.0]);
        let mirrored = texture(Property::roughness, texels.clone(), 4, false, |r| r.wrap = Wrap::Mirror);
        assert_eq!([mirrored.lookup([1.0, 0.25], 0)[0], mirrored.lookup([1.125, 0.25], 0)[0]], [3.0, 3.0]);
        let turned = texture(Property::roughness, texels, 4, false, |r| r.uv_rotation = 90.0);
        // (u, v) becomes (v, -u).
        assert!((turned.lookup([-0.25, 0.125], 0)[0] - 0.0).abs() < 1e-5);
    }

    #[test]
    fn only_colours_of_eight_bits_are_decoded() {
        let grey = || vec![[0.5, 0.5, 0.5, 0.5]];
        let value = |p, bits, space| texture(p, grey(), 1, bits, |r| r.color_space = space).lookup([0.5, 0.5], 0)[0];
        assert!((value(Property::base_color, true, ColorSpace::Auto) - 0.2159).abs() < 2e-3);
        assert_eq!(value(Property::base_color, false, ColorSpace::Auto), 0.5);
        assert_eq!(value(Property::roughness, true, ColorSpace::Auto), 0.5);
        assert!((value(Property::roughness, false, ColorSpace::Srgb) - 0.2140).abs() < 1e-3);
    }

    #[test]
    fn turns_are_read_across_the_wrap() {
        let texels = vec![[0.96; 4], [0.04; 4]];
        let t = texture(Property::anisotropy_rotation, texels, 2, false, |r| r.wrap = Wrap::Clamp);
        for (u, turn) in [(0.0, 0.96), (0.25, 0.96), (0.5, 0.0), (0.75, 0.04), (1.0, 0.04)] {
            let got = t.lookup([u, 0.5], 0)[0];
            // Half a turn looks the same as none.
            let difference = (got - turn) * 2.0;
            assert!((difference - difference.round()).abs() < 1e-5 && (0.0..0.5).contains(&got), "{u}: {got}");
        }
        assert!((t.lookup([0.5, 0.5], 1)[0] * 2.0).fract().min(1.0) < 1e-5);
    }

    #[test]
    fn texels_are_at_most_half_the_footprint() {
        let t = texture(Property::roughness, vec![[0.5; 4]; 64 * 16], 64, false, |r| r.uv_scale = [2.0, 0.5]);
        // 32 texels per unit of uv.
        for (footprint, level) in
            [(0.0, 0), (1.0 / 32.0, 0), (3.9 / 32.0, 0), (4.1 / 32.0, 1), (8.1 / 32.0, 2), (1.0, 4), (1e9, 6)]
        {
            assert_eq!(t.level(footprint), level, "{footprint}");
        }
        assert_eq!([t.level(f32::NAN), t.level(-1.0), t.level(f32::INFINITY)], [0, 0, 6]);
    }

    #[test]
    fn unusable_texels_are_the_default() {
        let t = texture(Property::roughness, vec![[f32::NAN; 4]], 1, false, |_| {});
        assert_eq!(t.lookup([0.5, 0.5], 0)[0], 0.3);
    }
}

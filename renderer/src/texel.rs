//! What a texel of an image means for a property: colour space, channel, inversion, scale and bias, in that order.

use crate::tonemap::srgb_decode;
use burnish_material::{Channel, ColorSpace, Kind, Property, TextureRef};

/// One texel as the property means it: linear colour, a number in all three, or a direction of any length. Not clamped; as finite as the texel.
pub fn decode(texel: [f32; 4], property: Property, reference: &TextureRef, is_eight_bit: bool) -> [f32; 3] {
    let value = stored(texel, property, reference, is_eight_bit);
    if property.def().default.kind() == Kind::Normal { value.map(|x| x * 2.0 - 1.0) } else { value }
}

/// The same with directions as images store them, 0 to 1.
pub fn stored(texel: [f32; 4], property: Property, reference: &TextureRef, is_eight_bit: bool) -> [f32; 3] {
    let kind = property.def().default.kind();
    let is_srgb = match reference.color_space {
        ColorSpace::Srgb => true,
        ColorSpace::Linear => false,
        ColorSpace::Auto => is_eight_bit && kind == Kind::Color,
    };
    let linear = |x: f32| if is_srgb { srgb_decode(x) } else { x };
    let [r, g, b, a] = texel;
    let value = match (reference.channel, kind) {
        (Channel::R, _) => [linear(r); 3],
        (Channel::G, _) => [linear(g); 3],
        (Channel::B, _) => [linear(b); 3],
        (Channel::A, _) => [a; 3],
        (Channel::Rgb, Kind::Color | Kind::Normal) => [linear(r), linear(g), linear(b)],
        (Channel::Rgb, Kind::Float | Kind::Bool) => [(linear(r) + linear(g) + linear(b)) / 3.0; 3],
    };
    reference.affine(kind).map_or(value, |affine| affine.apply(value))
}

//! Images of a document: the nodes that read them, where on the surface they lie, and the bindings they become.

use super::color::Space;
use super::numbers::{Part, Parts};
use super::walk::{COORDINATES, Normal, Term, Walk};
use super::xml::Id;
use crate::exchange::paths::refusal;
use crate::exchange::short::short;
use crate::exchange::uv::{offset_from_above, offset_from_below};
use crate::slot::{Channel, ColorSpace, TextureRef, Wrap};
use crate::value::Kind;

/// An image that a node reads.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageSource {
    /// Path as the file gives it, with its prefix and `/`.
    path: String,
    space: ColorSpace,
    wrap: Wrap,
    /// Coordinates as parts of those of the surface.
    uv: [Part; 2],
}

/// The numbers that an image node gives.
pub fn read(walk: &mut Walk, node: Id, count: usize) -> Result<Term, Term> {
    let tag = walk.graph.tree.tag(node);
    let uv = coordinates(walk, node, tag)?;
    let (file, at) = walk.text(node, "file");
    let prefix = walk.graph.tree.inherited(at, "fileprefix").unwrap_or_default();
    let path = format!("{prefix}{file}").replace('\\', "/");
    if file.is_empty() {
        return walk.input(node, "default").ok_or(Term::Unknown(node, "names no image"));
    }
    if let Some(reason) = refusal(&path) {
        let name = walk.graph.path(node);
        walk.note(format!("{name}: the image `{}` {reason}; not taken", short(&path)));
        return Err(Term::Unknown(node, "names an image that is refused"));
    }
    if path.contains('<') {
        walk.note(format!("`{}`: tiles and other tokens in names of images are not replaced", short(&path)));
    }
    let space = color_space(walk, node, at);
    let wrap = wrap(walk, node, tag);
    let source = walk.add_source(ImageSource { path, space, wrap, uv });
    let channels: Vec<Part> = (0..4).map(|channel| Part::channel(source, channel)).collect();
    let parts = Parts::of(&channels[..if tag == "UsdUVTexture" || tag == "gltf_colorimage" { 4 } else { count.clamp(1, 4) }]);
    let parts = parts.ok_or(Term::Unknown(node, "gives no numbers"))?;
    let scaled = match tag {
        "gltf_image" => parts.zip(&walk.numbers(node, "factor", &[1.0])?, parts.count, Part::product),
        "gltf_colorimage" => parts.zip(&walk.numbers(node, "color", &[1.0; 4])?, parts.count, Part::product),
        "UsdUVTexture" => {
            let (scale, bias) = (walk.numbers(node, "scale", &[1.0; 4])?, walk.numbers(node, "bias", &[0.0; 4])?);
            parts.zip(&scale, parts.count, Part::product).and_then(|parts| parts.zip(&bias, parts.count, Part::plus))
        }
        _ => Some(parts),
    };
    scaled.map(|parts| Term::Numbers(Box::new(parts))).ok_or(Term::Unknown(node, "is scaled by another image"))
}

fn color_space(walk: &mut Walk, node: Id, file: Id) -> ColorSpace {
    let tree = walk.graph.tree;
    let kind = tree.attribute(node, "type").unwrap_or_default();
    let is_color = matches!(kind, "color3" | "color4" | "multioutput") || tree.tag(node) == "UsdUVTexture";
    let own = tree.attribute(file, "colorspace").or(tree.attribute(node, "colorspace"));
    // Only colours have the space of the document.
    let Some(name) = own.or(if is_color { tree.inherited(node, "colorspace") } else { None }) else { return ColorSpace::Linear };
    match Space::named(name) {
        Some(space) if space.is_srgb() => {
            if !is_color {
                let note =
                    format!("{}: numbers in an image of the space `{}`; read as the file says", walk.graph.path(node), name);
                walk.note(note);
            }
            ColorSpace::Srgb
        }
        Some(space) if space.is_linear_rec709() => ColorSpace::Linear,
        _ => {
            let note = format!(
                "{}: images of the colour space `{}` cannot be converted; read as linear",
                walk.graph.path(node),
                short(name)
            );
            walk.note(note);
            ColorSpace::Linear
        }
    }
}

fn wrap(walk: &mut Walk, node: Id, tag: &str) -> Wrap {
    let names = match tag {
        // Always periodic, whatever stands there.
        "tiledimage" | "gltf_colorimage" => return Wrap::Repeat,
        "UsdUVTexture" => ["wrapS", "wrapT"],
        _ => ["uaddressmode", "vaddressmode"],
    };
    let [u, v] = names.map(|name| walk.text(node, name).0);
    if u != v {
        walk.note(format!("{}: outside of the image, u and v differ; as u in both", walk.graph.path(node)));
    }
    match u {
        "clamp" => Wrap::Clamp,
        "mirror" => Wrap::Mirror,
        "constant" | "black" => {
            walk.note(format!("{}: a colour of its own outside of the image became its border", walk.graph.path(node)));
            Wrap::Clamp
        }
        _ => Wrap::Repeat,
    }
}

/// Coordinates of an image node, as parts of those of the surface.
fn coordinates(walk: &mut Walk, node: Id, tag: &str) -> Result<[Part; 2], Term> {
    let name = if tag == "UsdUVTexture" { "st" } else { "texcoord" };
    let own = [Part::channel(COORDINATES, 0), Part::channel(COORDINATES, 1)];
    let before = match walk.input(node, name) {
        Some(Term::Numbers(parts)) => *parts,
        Some(_) => {
            walk.note(format!("{}: its coordinates are computed; taken as they are", walk.graph.path(node)));
            Parts::of(&own).ok_or(Term::Unknown(node, "has no coordinates"))?
        }
        None => Parts::of(&own).ok_or(Term::Unknown(node, "has no coordinates"))?,
    };
    let unknown = Term::Unknown(node, "lies on coordinates that are more than scaled, turned and shifted");
    let placed = match tag {
        "tiledimage" => {
            let tiling = walk.constants(node, "uvtiling", [1.0; 2])?;
            let offset = walk.constants(node, "uvoffset", [0.0; 2])?;
            let (image, tile) =
                (walk.constants(node, "realworldimagesize", [1.0; 2])?, walk.constants(node, "realworldtilesize", [1.0; 2])?);
            let axis = |k: usize| {
                let ratio = tile[k] / image[k];
                before.at(k).times(tiling[k] * ratio)?.plus(&Part::constant(-offset[k] * ratio))
            };
            axis(0).zip(axis(1)).map(|(u, v)| [u, v])
        }
        "gltf_image" | "gltf_colorimage" | "gltf_normalmap" => {
            let pivot = walk.constants(node, "pivot", [0.0, 1.0])?;
            let (scale, [rotate]) = (walk.constants(node, "scale", [1.0; 2])?, walk.constants(node, "rotate", [0.0])?);
            let [x, y] = walk.constants(node, "offset", [0.0; 2])?;
            let order = if tag == "gltf_colorimage" { [0.0] } else { walk.constants(node, "operationorder", [0.0])? };
            placed(&before, pivot, scale.map(|s| 1.0 / s), -rotate, [-x, y], order[0] == 0.0)
                .map(|parts| [parts.at(0), parts.at(1)])
        }
        _ => Some([before.at(0), before.at(1)]),
    };
    let placed = placed.ok_or(unknown)?;
    if placed.iter().any(|part| part.source.is_some_and(|source| source != COORDINATES)) {
        walk.note(format!("{}: its coordinates come from an image; taken as they are", walk.graph.path(node)));
        return Ok(own);
    }
    Ok(placed)
}

/// Numbers turned clockwise, in degrees.
pub fn rotated(value: &Parts, degrees: f64) -> Option<Parts> {
    if degrees == 0.0 {
        return Some(*value);
    }
    let (sin, cos) = degrees.to_radians().sin_cos();
    let (x, y) = (value.at(0), value.at(1));
    Parts::of(&[x.times(cos)?.plus(&y.times(sin)?)?, x.times(-sin)?.plus(&y.times(cos)?)?])
}

/// What MaterialX's place2d does: divide, turn clockwise, subtract, about a pivot; or the other way round.
fn placed(uv: &Parts, pivot: [f64; 2], scale: [f64; 2], rotate: f64, offset: [f64; 2], scale_first: bool) -> Option<Parts> {
    let shifted = |uv: &Parts, by: [f64; 2], sign: f64| {
        Parts::of(&[uv.at(0).plus(&Part::constant(sign * by[0]))?, uv.at(1).plus(&Part::constant(sign * by[1]))?])
    };
    let divided = |uv: &Parts| Parts::of(&[uv.at(0).times(1.0 / scale[0])?, uv.at(1).times(1.0 / scale[1])?]);
    let uv = shifted(uv, pivot, -1.0)?;
    let uv = match scale_first {
        true => shifted(&rotated(&divided(&uv)?, rotate)?, offset, -1.0)?,
        false => divided(&rotated(&shifted(&uv, offset, -1.0)?, rotate)?)?,
    };
    shifted(&uv, pivot, 1.0)
}

/// A place2d node.
pub fn place2d(walk: &mut Walk, node: Id) -> Result<Term, Term> {
    let uv = match walk.input(node, "texcoord") {
        Some(Term::Numbers(parts)) => *parts,
        Some(term) => return Err(term),
        None => Parts { count: 2, parts: [0, 1, 2, 3].map(|k| Part::channel(COORDINATES, k.min(1))) },
    };
    let (pivot, offset) = (walk.constants(node, "pivot", [0.0; 2])?, walk.constants(node, "offset", [0.0; 2])?);
    let (scale, [rotate]) = (walk.constants(node, "scale", [1.0; 2])?, walk.constants(node, "rotate", [0.0])?);
    let [order] = walk.constants(node, "operationorder", [0.0])?;
    let placed = placed(&uv, pivot, scale, rotate, offset, order == 0.0);
    placed.map(|parts| Term::Numbers(Box::new(parts))).ok_or(Term::Unknown(node, "divides the coordinates by 0"))
}

/// A UsdTransform2d node: scaled, turned counterclockwise, shifted.
pub fn transform2d(walk: &mut Walk, node: Id) -> Result<Term, Term> {
    let uv = walk.numbers(node, "in", &[0.0; 2])?;
    let scale = walk.constants(node, "scale", [1.0; 2])?;
    let ([rotation], shift) = (walk.constants(node, "rotation", [0.0])?, walk.constants(node, "translation", [0.0; 2])?);
    let moved = || {
        let turned = rotated(&Parts::of(&[uv.at(0).times(scale[0])?, uv.at(1).times(scale[1])?])?, -rotation)?;
        Parts::of(&[turned.at(0).plus(&Part::constant(shift[0]))?, turned.at(1).plus(&Part::constant(shift[1]))?])
    };
    moved().map(|parts| Term::Numbers(Box::new(parts))).ok_or(Term::Unknown(node, "has settings that are too large"))
}

impl ImageSource {
    /// The image with nothing but where it lies; none where its coordinates are sheared.
    fn placed(&self) -> Option<TextureRef> {
        let mut texture = TextureRef::new(self.path.clone());
        (texture.color_space, texture.wrap) = (self.space, self.wrap);
        let row = |k: usize| [self.uv[k].weights[0], self.uv[k].weights[1]];
        let ([a, b], [c, d]) = (row(0), row(1));
        let offset = [self.uv[0].bias, self.uv[1].bias];
        let above = |texture: &TextureRef| offset_from_above(texture.uv_scale, texture.uv_rotation, offset).map(tidied);
        if b == 0.0 && c == 0.0 {
            texture.uv_scale = [a, d].map(tidied);
            texture.uv_offset = above(&texture);
            return Some(texture);
        }
        let size = a.hypot(c).max(b.hypot(d));
        if !size.is_finite() || (a * b + c * d).abs() > 1e-5 * size * size {
            return None;
        }
        let angle = c.atan2(a);
        let (sin, cos) = angle.sin_cos();
        texture.uv_scale = [a.hypot(c), d * cos - b * sin].map(tidied);
        texture.uv_rotation = tidied(angle.to_degrees());
        texture.uv_offset = above(&texture);
        Some(texture)
    }
}

/// A number that went through single precision, without the last digits that it does not have.
fn tidied(x: f64) -> f64 {
    let step = 10_f64.powi(6 - x.abs().max(1e-6).log10().ceil() as i32);
    let rounded = (x * step).round() / step;
    if (rounded - x).abs() <= 2e-7 * x.abs().max(1e-6) { rounded } else { x }
}

/// The binding that numbers mean for a parameter of this kind. Errors say what is in the way.
pub fn binding(walk: &Walk, parts: &Parts, kind: Kind) -> Result<TextureRef, &'static str> {
    let used = &parts.parts[..if kind == Kind::Color { 3 } else { 1 }];
    let mut sources = used.iter().filter_map(|part| part.source);
    let source = sources.next().ok_or("has no image")?;
    if sources.any(|other| other != source) {
        return Err("mixes several images");
    }
    let image = walk.image(source).ok_or("follows the coordinates, not an image")?;
    through(used, image.placed().ok_or("lies on sheared coordinates")?)
}

/// An image with the channel, scale and bias of one part for a number, of three for a colour.
fn through(parts: &[Part], mut texture: TextureRef) -> Result<TextureRef, &'static str> {
    const CHANNELS: [Channel; 4] = [Channel::R, Channel::G, Channel::B, Channel::A];
    let single = |part: &Part| {
        let mut places = (0..4).filter(|k| part.weights[*k] != 0.0);
        let first = places.next();
        if places.next().is_some() { Err("mixes the channels of an image") } else { Ok(first) }
    };
    if let [part] = parts {
        let [r, g, b, a] = part.weights;
        let is_mean = r != 0.0 && (r - g).abs() <= 1e-6 * r.abs() && (r - b).abs() <= 1e-6 * r.abs() && a == 0.0;
        let factor = match is_mean {
            true => 3.0 * r,
            false => {
                let place = single(part)?.unwrap_or(0);
                texture.channel = CHANNELS[place];
                part.weights[place]
            }
        };
        (texture.scale, texture.bias) = ([factor; 3], [part.bias; 3]);
        return Ok(without_curve(texture));
    }
    let places: Vec<Option<usize>> = parts.iter().map(single).collect::<Result<_, _>>()?;
    let is_rgb = places.iter().enumerate().all(|(k, place)| place.is_none_or(|place| place == k));
    if !is_rgb {
        let mut used = places.iter().flatten();
        let first = used.next().copied().unwrap_or(0);
        if used.any(|place| *place != first) {
            return Err("swaps the channels of an image");
        }
        texture.channel = CHANNELS[first];
    }
    for (k, part) in parts.iter().enumerate().take(3) {
        texture.scale[k] = places[k].map_or(0.0, |place| part.weights[place]);
        texture.bias[k] = part.bias;
    }
    Ok(without_curve(texture))
}

/// Alpha is never stored by a curve.
fn without_curve(texture: TextureRef) -> TextureRef {
    let color_space = if texture.channel == Channel::A { ColorSpace::Linear } else { texture.color_space };
    TextureRef { color_space, ..texture }
}

/// The binding that a reader finds after this one was written for a parameter of this kind; none where nothing of the image is left.
pub fn reread(texture: &TextureRef, kind: Kind) -> Option<TextureRef> {
    let uv = Parts { count: 2, parts: [0, 1, 2, 3].map(|k| Part::channel(COORDINATES, k.min(1))) };
    let ([su, sv], [tu, tv]) = (texture.uv_scale, offset_from_below(texture));
    let uv = placed(&uv, [0.0; 2], [1.0 / su, 1.0 / sv], -texture.uv_rotation, [-tu, -tv], true)?;
    let image =
        ImageSource { path: texture.path.clone(), space: texture.color_space, wrap: texture.wrap, uv: [uv.at(0), uv.at(1)] };
    let image = image.placed()?;
    if kind == Kind::Normal {
        return Some(TextureRef { is_inverted: texture.is_inverted, ..image });
    }
    let part = |k: usize| {
        let channel = match (texture.channel, kind) {
            (Channel::Rgb, Kind::Color) => k,
            (Channel::Rgb | Channel::R, _) => 0,
            (Channel::G, _) => 1,
            (Channel::B, _) => 2,
            (Channel::A, _) => 3,
        };
        let (scale, bias) = factors(texture, k);
        Part::channel(COORDINATES, channel).times(scale)?.plus(&Part::constant(bias))
    };
    let parts: Vec<Part> = (0..if kind == Kind::Color { 3 } else { 1 }).map(part).collect::<Option<_>>()?;
    if parts.iter().all(|part| part.source.is_none()) { None } else { through(&parts, image).ok() }
}

/// Factor and offset of one channel of a binding, the inversion in them.
pub fn factors(texture: &TextureRef, channel: usize) -> (f64, f64) {
    let (scale, bias) = (texture.scale[channel.min(2)], texture.bias[channel.min(2)]);
    if texture.is_inverted { (-scale, scale + bias) } else { (scale, bias) }
}

/// The binding of a normal map.
pub fn normal_binding(walk: &Walk, normal: &Normal) -> Option<TextureRef> {
    let mut texture = walk.image(normal.source?)?.placed()?;
    (texture.is_inverted, texture.color_space) = (normal.is_flipped, ColorSpace::Auto);
    Some(texture)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_of_place2d_become_a_transform() {
        // Scale (2, 3), 30 degrees, shift (0.1, 0.2), as the mapping writes it.
        let uv = Parts { count: 2, parts: [0, 1, 2, 3].map(|k| Part::channel(COORDINATES, k.min(1))) };
        let parts = placed(&uv, [0.0; 2], [0.5, 0.333_333_34], -30.0, [-0.1, -0.2], true).expect("a transform");
        let image = ImageSource {
            path: "a.png".to_owned(),
            space: ColorSpace::Linear,
            wrap: Wrap::Repeat,
            uv: [parts.at(0), parts.at(1)],
        };
        let texture = image.placed().expect("a transform");
        assert_eq!((texture.uv_scale, texture.uv_rotation), ([2.0, 3.0], 30.0));
        assert!(texture.uv_offset.iter().zip([-1.4, -1.798_076_2]).all(|(a, b)| (a - b).abs() < 1e-6), "{:?}", texture.uv_offset);
    }
}

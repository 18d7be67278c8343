//! Networks of images to references to images: what stands between a file and an input of a surface.

use super::connections::{Source, constant, follow, numbers, shader_id, text};
use super::layer::{Layer, PrimId, entry};
use super::numbers::{file_path, single};
use crate::exchange::model::Notes;
use crate::exchange::uv::{offset_from_above, offset_from_below};
use crate::slot::{Channel, ColorSpace, TextureRef, Wrap};
use crate::value::Kind;

/// More nodes behind each other than are read.
const MAX_NODES: usize = 8;
/// Longest path of a file, bytes.
const MAX_FILE_PATH: usize = 2_000;

/// An image that an input reads.
#[derive(Clone, Debug)]
pub(super) struct Found {
    /// The image; its path is that of the file as the layer says it.
    pub texture: TextureRef,
    /// Strength of a normal map that stands in the network.
    pub normal_scale: f64,
}

/// The image behind an output of a shader, for an input of this kind. Errors, in words for a note, where a node is not understood.
pub(super) fn image(layer: &Layer, shader: PrimId, output: &str, kind: Kind, notes: &mut Notes) -> Result<Found, String> {
    node(layer, shader, output, kind, notes, 0)
}

fn node(layer: &Layer, shader: PrimId, output: &str, kind: Kind, notes: &mut Notes, depth: usize) -> Result<Found, String> {
    if depth > MAX_NODES {
        return Err(format!("expected at most {MAX_NODES} nodes behind each other, found more"));
    }
    let id = shader_id(layer, shader);
    if id == "UsdUVTexture" || id.starts_with("ND_UsdUVTexture") {
        return uv_texture(layer, shader, output, kind, notes);
    }
    let mut behind = |input: &str, kind| match follow(layer, shader, &format!("inputs:{input}"))? {
        Some(Source::Output(shader, output)) => node(layer, shader, output, kind, notes, depth + 1),
        _ => Err(format!("expected an image at `{input}` of the node `{id}`, found none")),
    };
    let operation = id.strip_prefix("ND_").and_then(|id| id.split('_').next()).unwrap_or_default();
    match operation {
        "image" | "tiledimage" => materialx_image(layer, shader, operation, notes),
        "normalmap" => {
            let mut found = behind("in", Kind::Color)?;
            found.texture.is_inverted = found.texture.scale[1] < 0.0;
            (found.texture.scale, found.texture.bias) = ([1.0; 3], [0.0; 3]);
            let scale = numbers::<1>(layer, shader, "scale").map(|[s]| s);
            let scale = scale.or_else(|| numbers::<2>(layer, shader, "scale").map(|[s, _]| s)).unwrap_or(1.0);
            Ok(Found { normal_scale: scale, ..found })
        }
        "multiply" | "add" => {
            let is_first = matches!(follow(layer, shader, "inputs:in1"), Ok(Some(Source::Output(..))));
            let (input, other) = if is_first { ("in1", "in2") } else { ("in2", "in1") };
            let image = behind(input, kind)?;
            let by = numbers::<3>(layer, shader, other).or_else(|| numbers::<1>(layer, shader, other).map(|[x]| [x; 3]));
            let by = by.ok_or_else(|| format!("expected an image and a number at the node `{id}`, found other inputs"))?;
            let mut texture = image.texture;
            for (k, by) in by.into_iter().enumerate() {
                if operation == "multiply" {
                    (texture.scale[k], texture.bias[k]) = (texture.scale[k] * by, texture.bias[k] * by);
                } else {
                    texture.bias[k] += by;
                }
            }
            Ok(Found { texture, ..image })
        }
        "extract" => {
            let index = numbers::<1>(layer, shader, "index").map_or(0.0, |[x]| x);
            one_channel(behind("in", kind)?, index as usize)
        }
        _ if operation.starts_with("separate") => {
            let place = output.strip_prefix("out").and_then(|name| "rgbaxyzw".find(name)).map_or(4, |place| place % 4);
            one_channel(behind("in", kind)?, place)
        }
        "convert" | "dot" => behind("in", kind),
        _ => Err(format!("expected an image, found the node `{id}`, which is not understood")),
    }
}

const CHANNELS: [Channel; 4] = [Channel::R, Channel::G, Channel::B, Channel::A];

/// One channel of an image; alpha has the first one's scale, as images have none of their own for it here.
fn one_channel(mut found: Found, place: usize) -> Result<Found, String> {
    let channel = *CHANNELS.get(place).ok_or("expected one of four channels, found another")?;
    let k = if place < 3 { place } else { 0 };
    if found.texture.channel == Channel::Rgb {
        found.texture.channel = channel;
        (found.texture.scale, found.texture.bias) = ([found.texture.scale[k]; 3], [found.texture.bias[k]; 3]);
    }
    Ok(found)
}

fn uv_texture(layer: &Layer, shader: PrimId, output: &str, kind: Kind, notes: &mut Notes) -> Result<Found, String> {
    let mut texture = TextureRef::new(file(layer, shader)?);
    texture.color_space = match text(layer, shader, "sourceColorSpace") {
        Some("raw") => ColorSpace::Linear,
        Some("sRGB") => ColorSpace::Srgb,
        _ => ColorSpace::Auto,
    };
    let wrap = |input| match text(layer, shader, input) {
        Some("clamp") => (Wrap::Clamp, false),
        Some("black") => (Wrap::Clamp, true),
        Some("mirror") => (Wrap::Mirror, false),
        _ => (Wrap::Repeat, false),
    };
    wraps(&mut texture, [wrap("wrapS"), wrap("wrapT")], notes);
    let scale = numbers::<4>(layer, shader, "scale");
    let bias = numbers::<4>(layer, shader, "bias");
    let (factor, offset) = (scale.unwrap_or([1.0; 4]).map(single), bias.unwrap_or([0.0; 4]).map(single));
    coordinates(layer, shader, "st", &mut texture, notes);
    let mut normal_scale = 1.0;
    if kind == Kind::Normal {
        texture.color_space = ColorSpace::Linear;
        if scale.is_some() || bias.is_some() {
            normal_scale = factor[0].abs() / 2.0;
            texture.is_inverted = factor[1] < 0.0;
            // Adobe's writers scale all three, which has no other meaning.
            let is_usual = factor[0] > 0.0
                && is_near(factor[0], factor[1].abs())
                && is_near(offset[0], -factor[0] / 2.0)
                && is_near(offset[1], -factor[1] / 2.0)
                && (is_near(factor[2], 2.0) || is_near(factor[2], factor[0]));
            if !is_usual {
                notes.push(format!(
                    "the image `{}`: expected a scale and bias of directions, (2, 2, 2) and (-1, -1, -1), found others; only the \
                     strength and the side of green are kept",
                    texture.path
                ));
            }
        }
        return Ok(Found { texture, normal_scale });
    }
    match CHANNELS.iter().zip(["r", "g", "b", "a"]).position(|(_, name)| name == output) {
        Some(k) => {
            texture.channel = CHANNELS[k];
            (texture.scale, texture.bias) = ([factor[k]; 3], [offset[k]; 3]);
        }
        None if output == "rgb" => {
            (texture.scale, texture.bias) = ([factor[0], factor[1], factor[2]], [offset[0], offset[1], offset[2]]);
        }
        None => return Err(format!("expected the output r, g, b, a or rgb of an image, found `{output}`")),
    }
    Ok(Found { texture, normal_scale })
}

fn materialx_image(layer: &Layer, shader: PrimId, operation: &str, notes: &mut Notes) -> Result<Found, String> {
    let mut texture = TextureRef::new(file(layer, shader)?);
    let space =
        constant(layer, shader, "file").and_then(|file| entry(&file.metadata, "colorSpace")).and_then(|space| space.text());
    texture.color_space = if space == Some("srgb_texture") { ColorSpace::Srgb } else { ColorSpace::Linear };
    if shader_id(layer, shader).ends_with("_float") {
        texture.channel = Channel::R;
    }
    let wrap = |input| match text(layer, shader, input) {
        Some("clamp") => (Wrap::Clamp, false),
        Some("constant") => (Wrap::Clamp, true),
        Some("mirror") => (Wrap::Mirror, false),
        _ => (Wrap::Repeat, false),
    };
    wraps(&mut texture, [wrap("uaddressmode"), wrap("vaddressmode")], notes);
    coordinates(layer, shader, "texcoord", &mut texture, notes);
    if operation == "tiledimage" {
        texture.uv_scale = numbers(layer, shader, "uvtiling").unwrap_or(texture.uv_scale);
        let offset = numbers::<2>(layer, shader, "uvoffset").unwrap_or([0.0; 2]).map(|x| -x);
        texture.uv_offset = offset_from_above(texture.uv_scale, texture.uv_rotation, offset);
    }
    Ok(Found { texture, normal_scale: 1.0 })
}

fn file(layer: &Layer, shader: PrimId) -> Result<String, String> {
    let path = text(layer, shader, "file").unwrap_or_default();
    let path = path.strip_prefix("./").unwrap_or(path);
    match path.len() {
        0 => Err("expected the file of an image, found none".to_owned()),
        1..=MAX_FILE_PATH => Ok(path.to_owned()),
        _ => Err(format!("expected the path of a file of at most {MAX_FILE_PATH} bytes, found a longer one")),
    }
}

fn wraps(texture: &mut TextureRef, [(u, u_ends), (v, v_ends)]: [(Wrap, bool); 2], notes: &mut Notes) {
    texture.wrap = u;
    if u != v {
        notes.push(format!("the image `{}`: wraps otherwise along v than along u; read as along u", texture.path));
    }
    if u_ends || v_ends {
        notes.push(format!("the image `{}`: ends at its border; its border pixels are repeated instead", texture.path));
    }
}

/// Reads how an image lies on the surface.
fn coordinates(layer: &Layer, shader: PrimId, input: &str, texture: &mut TextureRef, notes: &mut Notes) {
    let mut source = follow(layer, shader, &format!("inputs:{input}"));
    for step in 0..MAX_NODES {
        let Ok(Some(Source::Output(node, _))) = source else { return };
        let id = shader_id(layer, node);
        let pair = |name| numbers::<2>(layer, node, name);
        let turn = |name| numbers::<1>(layer, node, name).map_or(0.0, |[x]| x);
        let next = match id.strip_prefix("ND_").unwrap_or(id) {
            "UsdTransform2d" if step == 0 => {
                texture.uv_scale = pair("scale").unwrap_or([1.0; 2]).map(single);
                texture.uv_rotation = single(turn("rotation"));
                let offset = pair("translation").unwrap_or([0.0; 2]).map(single);
                texture.uv_offset = offset_from_above(texture.uv_scale, texture.uv_rotation, offset);
                "inputs:in"
            }
            "place2d_vector2" if step == 0 => {
                let scale = pair("scale").unwrap_or([1.0; 2]);
                if scale.contains(&0.0) {
                    return notes.push(format!("the image `{}`: expected a scale of uv other than 0; not read", texture.path));
                }
                texture.uv_scale = scale.map(|s| single(1.0 / s));
                texture.uv_rotation = single(-turn("rotate"));
                let offset = pair("offset").unwrap_or([0.0; 2]).map(|x| single(-x));
                texture.uv_offset = offset_from_above(texture.uv_scale, texture.uv_rotation, offset);
                "inputs:texcoord"
            }
            "geompropvalue_vector2" | "texcoord_vector2" | "UsdPrimvarReader_float2" | "UsdPrimvarReader_vector2" => return,
            _ => {
                return notes.push(format!(
                    "the image `{}`: expected coordinates from one transform of uv, found the node `{id}`; not read",
                    texture.path
                ));
            }
        };
        source = follow(layer, node, next);
    }
}

fn is_near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-4
}

/// How an image of a property of this kind comes back from the network that is written for it, at this path. Scalars from all channels
/// come back from red, inversions as a scale and a bias.
pub(super) fn as_written(kind: Kind, texture: &TextureRef, path: &str) -> TextureRef {
    let mut out = TextureRef { path: file_path(path.strip_prefix("./").unwrap_or(path)), ..texture.clone() };
    let is_color = kind == Kind::Color;
    let has_curve = is_color && ![".hdr", ".exr"].iter().any(|end| path.to_ascii_lowercase().ends_with(end));
    out.color_space = match texture.color_space {
        ColorSpace::Auto if has_curve => ColorSpace::Srgb,
        ColorSpace::Auto => ColorSpace::Linear,
        other => other,
    };
    match kind {
        Kind::Normal => {
            (out.channel, out.color_space) = (Channel::Rgb, ColorSpace::Linear);
            (out.scale, out.bias) = ([1.0; 3], [0.0; 3]);
        }
        Kind::Color => out.channel = Channel::Rgb,
        Kind::Float | Kind::Bool => {
            out.channel = if texture.channel == Channel::Rgb { Channel::R } else { texture.channel };
            (out.scale, out.bias) = ([texture.scale[0]; 3], [texture.bias[0]; 3]);
        }
    }
    if out.is_inverted && kind != Kind::Normal {
        out.is_inverted = false;
        for k in 0..3 {
            (out.scale[k], out.bias[k]) = (-out.scale[k], out.scale[k] + out.bias[k]);
        }
    }
    (out.scale, out.bias) = (out.scale.map(single), out.bias.map(single));
    let offset = offset_from_below(&out).map(single);
    (out.uv_scale, out.uv_rotation) = (out.uv_scale.map(single), single(out.uv_rotation));
    out.uv_offset = offset_from_above(out.uv_scale, out.uv_rotation, offset);
    out
}

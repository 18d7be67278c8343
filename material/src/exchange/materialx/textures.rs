//! Images of a material as a graph: each image and each placement once, channels, factors and offsets, normal maps, and an output for each
//! parameter that follows one.
//!
//! A number that follows all three channels of an image reads red alone: such images are grey, and programs load them with one channel or
//! with three.

use std::collections::HashMap;

use super::image::{factors, reread};
use super::nodes::readable_normal;
use super::numbers;
use super::xml_write::Xml;
use crate::exchange::paths::refusal;
use crate::exchange::uv::offset_from_below;
use crate::slot::{Channel, ColorSpace, TextureRef, Wrap};
use crate::value::Kind;

/// A graph of images that grows.
#[derive(Clone, Debug)]
pub struct TextureGraph {
    name: String,
    xml: Xml,
    nodes: usize,
    /// Nodes by what they do.
    known: HashMap<String, String>,
    outputs: Vec<(String, &'static str, String)>,
}

/// Type, attributes and value or connection of an input.
type Input<'a> = (&'a str, &'a str, Feed<'a>);

#[derive(Clone, Copy)]
enum Feed<'a> {
    Value(&'a str),
    Node(&'a str),
    /// A file and its colour space.
    File(&'a str, Option<&'static str>),
}

impl TextureGraph {
    /// An empty graph of this name.
    pub fn named(name: String) -> Self {
        Self { name, xml: Xml::inside(2), nodes: 0, known: HashMap::new(), outputs: Vec::new() }
    }

    /// Writes the graph, unless nothing is in it.
    pub fn write(self, xml: &mut Xml) {
        if self.outputs.is_empty() {
            return;
        }
        xml.open("nodegraph", &[("name", &self.name)]);
        xml.raw(&self.xml.into_text());
        for (name, kind, node) in &self.outputs {
            xml.empty("output", &[("name", name), ("type", kind), ("nodename", node)]);
        }
        xml.close("nodegraph");
    }

    /// An output that carries a node; the name of the output.
    pub fn output(&mut self, name: &str, kind: &'static str, node: String) -> String {
        let name = format!("{}_out", name.replace('.', "_"));
        self.outputs.push((name.clone(), kind, node));
        name
    }

    /// The node that gives an image to a parameter of this kind. `is_color` says whether automatic colour spaces mean sRGB.
    pub fn numbers(&mut self, texture: &TextureRef, kind: Kind, is_color: bool) -> String {
        let is_srgb = is_srgb(texture, is_color);
        let (channel, is_wide) = (texture.channel, kind == Kind::Color);
        let node = match (channel, is_wide, is_srgb) {
            (Channel::Rgb, true, _) => self.image(texture, "color3", is_srgb),
            (Channel::Rgb | Channel::R, false, false) => self.image(texture, "float", false),
            _ => {
                let (source, index) = match channel {
                    Channel::Rgb | Channel::R => (if is_srgb || is_wide { "color3" } else { "vector3" }, "0"),
                    Channel::G => (if is_srgb || is_wide { "color3" } else { "vector3" }, "1"),
                    Channel::B => (if is_srgb || is_wide { "color3" } else { "vector3" }, "2"),
                    Channel::A => (if is_srgb || is_wide { "color4" } else { "vector4" }, "3"),
                };
                let image = self.image(texture, source, is_srgb);
                let one = self.node(
                    "extract",
                    "float",
                    &[("in", source, Feed::Node(&image)), ("index", "integer", Feed::Value(index))],
                );
                if is_wide { self.node("convert", "color3", &[("in", "float", Feed::Node(&one))]) } else { one }
            }
        };
        let kind = if is_wide { "color3" } else { "float" };
        let (scale, bias): (Vec<f64>, Vec<f64>) = (0..if is_wide { 3 } else { 1 }).map(|k| factors(texture, k)).unzip();
        let node = self.affine(node, kind, &scale, 1.0, "multiply");
        self.affine(node, kind, &bias, 0.0, "add")
    }

    /// A node with a constant added or multiplied, unless it changes nothing.
    fn affine(&mut self, node: String, kind: &'static str, by: &[f64], neutral: f64, tag: &str) -> String {
        if by.iter().all(|x| *x == neutral) {
            return node;
        }
        self.node(tag, kind, &[("in1", kind, Feed::Node(&node)), ("in2", kind, Feed::Value(&numbers::list(by)))])
    }

    /// The node that gives a normal map: an image, or a constant direction, and its strength.
    pub fn normal(&mut self, texture: Option<&TextureRef>, constant: [f64; 3], scale: f64) -> String {
        let scale = numbers::text(scale);
        let stored = numbers::list(&readable_normal(constant).map(|x| 0.5 * x + 0.5));
        let image = texture.map(|texture| {
            let image = self.image(texture, "vector3", false);
            let flip = |by: [f64; 3]| if texture.is_inverted { by.to_vec() } else { vec![] };
            let image = self.affine(image, "vector3", &flip([1.0, -1.0, 1.0]), 1.0, "multiply");
            self.affine(image, "vector3", &flip([0.0, 1.0, 0.0]), 0.0, "add")
        });
        let feed = image.as_deref().map_or(Feed::Value(&stored), Feed::Node);
        self.node("normalmap", "vector3", &[("in", "vector3", feed), ("scale", "float", Feed::Value(&scale))])
    }

    /// The node that gives the direction in a normal map, for surfaces that take no normal map.
    pub fn direction(&mut self, texture: &TextureRef) -> String {
        let green = if texture.is_inverted { -1.0 } else { 1.0 };
        let image = self.image(texture, "vector3", false);
        let image = self.affine(image, "vector3", &[2.0, 2.0 * green, 2.0], 1.0, "multiply");
        self.affine(image, "vector3", &[-1.0, -green, -1.0], 0.0, "add")
    }

    /// The node that turns the tangent about the normal: by turns counterclockwise, or by the turns that a node gives.
    pub fn tangent(&mut self, turns: Result<f64, String>) -> String {
        let world = [("space", "string", Feed::Value("world"))];
        let (normal, tangent) = (self.node("normal", "vector3", &world), self.node("tangent", "vector3", &world));
        let degrees = numbers::text(-360.0 * turns.as_ref().copied().unwrap_or(1.0));
        let amount = turns.err().map(|node| {
            self.node("multiply", "float", &[("in1", "float", Feed::Node(&node)), ("in2", "float", Feed::Value(&degrees))])
        });
        let amount = amount.as_deref().map_or(Feed::Value(&degrees), Feed::Node);
        self.node(
            "rotate3d",
            "vector3",
            &[("in", "vector3", Feed::Node(&tangent)), ("amount", "float", amount), ("axis", "vector3", Feed::Node(&normal))],
        )
    }

    fn image(&mut self, texture: &TextureRef, kind: &'static str, is_srgb: bool) -> String {
        let uv = self.placement(texture);
        let wrap = match texture.wrap {
            Wrap::Repeat => "periodic",
            Wrap::Clamp => "clamp",
            Wrap::Mirror => "mirror",
        };
        self.node(
            "image",
            kind,
            &[
                ("file", "filename", Feed::File(&texture.path, is_srgb.then_some("srgb_texture"))),
                ("texcoord", "vector2", Feed::Node(&uv)),
                ("uaddressmode", "string", Feed::Value(wrap)),
                ("vaddressmode", "string", Feed::Value(wrap)),
            ],
        )
    }

    /// Coordinates: scaled, turned counterclockwise, shifted. place2d divides, turns clockwise and subtracts.
    fn placement(&mut self, texture: &TextureRef) -> String {
        let own = self.node("texcoord", "vector2", &[("index", "integer", Feed::Value("0"))]);
        let default = TextureRef::new("");
        if (texture.uv_scale, texture.uv_offset, texture.uv_rotation)
            == (default.uv_scale, default.uv_offset, default.uv_rotation)
        {
            return own;
        }
        let scale = numbers::list(&texture.uv_scale.map(|s| 1.0 / s));
        let offset = numbers::list(&offset_from_below(texture).map(|t| -t));
        let rotate = numbers::text(-texture.uv_rotation);
        self.node(
            "place2d",
            "vector2",
            &[
                ("texcoord", "vector2", Feed::Node(&own)),
                ("scale", "vector2", Feed::Value(&scale)),
                ("rotate", "float", Feed::Value(&rotate)),
                ("offset", "vector2", Feed::Value(&offset)),
            ],
        )
    }

    /// The node that does this; a new one unless there is one.
    fn node(&mut self, tag: &str, kind: &str, inputs: &[Input]) -> String {
        let mut xml = Xml::inside(3);
        for (name, kind, feed) in inputs {
            match feed {
                Feed::Value(value) => xml.empty("input", &[("name", name), ("type", kind), ("value", value)]),
                Feed::Node(node) => xml.empty("input", &[("name", name), ("type", kind), ("nodename", node)]),
                Feed::File(file, None) => xml.empty("input", &[("name", name), ("type", kind), ("value", file)]),
                Feed::File(file, Some(space)) => {
                    xml.empty("input", &[("name", name), ("type", kind), ("value", file), ("colorspace", space)]);
                }
            }
        }
        let inputs = xml.into_text();
        let key = format!("{tag} {kind}\n{inputs}");
        if let Some(name) = self.known.get(&key) {
            return name.clone();
        }
        self.nodes += 1;
        let name = format!("{tag}{}", self.nodes);
        self.xml.open(tag, &[("name", &name), ("type", kind)]);
        self.xml.raw(&inputs);
        self.xml.close(tag);
        self.known.insert(key, name.clone());
        name
    }
}

/// Whether the colours of an image are stored by the sRGB curve.
fn is_srgb(texture: &TextureRef, is_color: bool) -> bool {
    let lower = texture.path.to_ascii_lowercase();
    let is_linear = [".exr", ".hdr", ".pfm"].iter().any(|end| lower.ends_with(end));
    match texture.color_space {
        ColorSpace::Srgb => true,
        ColorSpace::Linear => false,
        ColorSpace::Auto => is_color && !is_linear,
    }
}

/// A binding as it can be written: with its path in the document, and what a reader finds of it. Errors say why it cannot.
pub fn writable(texture: &TextureRef, kind: Kind, path: String) -> Result<(TextureRef, TextureRef), &'static str> {
    if let Some(reason) = refusal(&path) {
        return Err(reason);
    }
    if kind == Kind::Bool {
        return Err("belongs to a switch, which has none");
    }
    if texture.uv_scale.contains(&0.0) {
        return Err("is stretched without end");
    }
    let texture = TextureRef { path, ..texture.clone() };
    let found = reread(&texture, kind).ok_or("is scaled to nothing, or by numbers that are too large")?;
    Ok((texture, found))
}

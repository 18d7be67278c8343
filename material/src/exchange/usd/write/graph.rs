//! The nodes of a material that surfaces share: images, and how they lie on the surface. Equal nodes are written once.

use super::super::numbers::{asset, number, tuple};
use super::text::Text;
use crate::exchange::uv::offset_from_below;
use crate::slot::{Channel, ColorSpace, TextureRef, Wrap};
use crate::value::Kind;

struct Node {
    name: String,
    lines: Vec<String>,
    outputs: Vec<String>,
}

/// The nodes of one material.
pub(super) struct Graph<'o> {
    path: &'o str,
    nodes: Vec<Node>,
}

/// A line that says what a shader is.
pub(super) fn id_line(id: &str) -> String {
    format!("uniform token info:id = \"{id}\"")
}

impl<'o> Graph<'o> {
    /// For the material at this path.
    pub fn new(path: &'o str) -> Self {
        Self { path, nodes: Vec::new() }
    }

    /// Name of the material's prim.
    pub fn name(&self) -> &'o str {
        self.path.rsplit('/').next().unwrap_or_default()
    }

    /// Writes all nodes.
    pub fn write(&self, text: &mut Text) {
        for node in &self.nodes {
            let lines: Vec<String> = node.lines.iter().chain(&node.outputs).cloned().collect();
            text.shader(&node.name, &lines);
        }
    }

    /// A node with these lines, and the path of one of its outputs.
    pub fn node(&mut self, stem: &str, lines: Vec<String>, (kind, output): (&str, &str)) -> String {
        let place = self.nodes.iter().position(|node| node.lines == lines).unwrap_or_else(|| {
            let count = self.nodes.iter().filter(|node| node.name.trim_end_matches(|c: char| c.is_ascii_digit()) == stem).count();
            let name = if count == 0 { stem.to_owned() } else { format!("{stem}{}", count + 1) };
            self.nodes.push(Node { name, lines, outputs: Vec::new() });
            self.nodes.len() - 1
        });
        let node = &mut self.nodes[place];
        let line = format!("{kind} outputs:{output}");
        if !node.outputs.contains(&line) {
            node.outputs.push(line);
        }
        format!("<{}/{}.outputs:{output}>", self.path, node.name)
    }

    /// An image as nodes of UsdPreviewSurface, for an input of this kind; the image as [`super::super::images::as_written`] has it.
    pub fn uv_texture(&mut self, kind: Kind, texture: &TextureRef, strength: f64) -> String {
        let st = self.transform(texture);
        let space = match texture.color_space {
            ColorSpace::Srgb => "sRGB",
            ColorSpace::Linear => "raw",
            ColorSpace::Auto => "auto",
        };
        let mut lines = vec![
            id_line("UsdUVTexture"),
            format!("asset inputs:file = {}", asset(&texture.path)),
            format!("token inputs:sourceColorSpace = \"{space}\""),
        ];
        let (scale, bias) = match kind {
            Kind::Normal => {
                let up = if texture.is_inverted { -strength } else { strength };
                ([2.0 * strength, 2.0 * up, 2.0, 1.0], [-strength, -up, -1.0, 0.0])
            }
            Kind::Color => {
                let ([r, g, b], [x, y, z]) = (texture.scale, texture.bias);
                ([r, g, b, 1.0], [x, y, z, 0.0])
            }
            Kind::Float | Kind::Bool => ([texture.scale[0]; 4], [texture.bias[0]; 4]),
        };
        if scale != [1.0; 4] {
            lines.push(format!("float4 inputs:scale = {}", tuple(&scale)));
        }
        if bias != [0.0; 4] {
            lines.push(format!("float4 inputs:bias = {}", tuple(&bias)));
        }
        lines.push(format!("float2 inputs:st.connect = {st}"));
        let wrap = texture.wrap.word();
        lines.extend(["wrapS", "wrapT"].map(|side| format!("token inputs:{side} = \"{wrap}\"")));
        let output = match (kind, texture.channel) {
            (Kind::Color | Kind::Normal, _) | (_, Channel::Rgb) => ("float3", "rgb"),
            (_, channel) => ("float", channel.word()),
        };
        self.node("Image", lines, output)
    }

    fn transform(&mut self, texture: &TextureRef) -> String {
        let lines = vec![id_line("UsdPrimvarReader_float2"), "string inputs:varname = \"st\"".to_owned()];
        let st = self.node("UV", lines, ("float2", "result"));
        if is_in_place(texture) {
            return st;
        }
        let lines = vec![
            id_line("UsdTransform2d"),
            format!("float2 inputs:in.connect = {st}"),
            format!("float inputs:rotation = {}", number(texture.uv_rotation)),
            format!("float2 inputs:scale = {}", tuple(&texture.uv_scale)),
            format!("float2 inputs:translation = {}", tuple(&offset_from_below(texture))),
        ];
        self.node("Transform", lines, ("float2", "result"))
    }

    /// An image as nodes of MaterialX, for an input of this kind.
    pub fn materialx_image(&mut self, kind: Kind, texture: &TextureRef, strength: f64) -> String {
        let st = self.place2d(texture);
        let (name, usd) = match (kind, texture.channel) {
            (Kind::Color, _) => ("color3", "color3f"),
            (Kind::Normal, _) => ("vector3", "float3"),
            (_, Channel::Rgb | Channel::R) => ("float", "float"),
            _ => ("vector4", "float4"),
        };
        let space = if texture.color_space == ColorSpace::Srgb { " (colorSpace = \"srgb_texture\")" } else { "" };
        let wrap = match texture.wrap {
            Wrap::Repeat => "periodic",
            Wrap::Clamp => "clamp",
            Wrap::Mirror => "mirror",
        };
        let mut lines = vec![
            id_line(&format!("ND_image_{name}")),
            format!("asset inputs:file = {}{space}", asset(&texture.path)),
            format!("float2 inputs:texcoord.connect = {st}"),
        ];
        lines.extend(["uaddressmode", "vaddressmode"].map(|side| format!("string inputs:{side} = \"{wrap}\"")));
        let mut out = self.node("MtlxImage", lines, (usd, "out"));
        let (mut name, mut usd) = (name, usd);
        if name == "vector4" {
            let index = match texture.channel {
                Channel::G => 1,
                Channel::B => 2,
                _ => 3,
            };
            let lines = vec![
                id_line("ND_extract_vector4"),
                format!("float4 inputs:in.connect = {out}"),
                format!("int inputs:index = {index}"),
            ];
            out = self.node("Channel", lines, ("float", "out"));
            (name, usd) = ("float", "float");
        }
        let flip = kind == Kind::Normal && texture.is_inverted;
        let (scale, bias) = if flip { ([1.0, -1.0, 1.0], [0.0, 1.0, 0.0]) } else { (texture.scale, texture.bias) };
        let width = if usd == "float" { 1 } else { 3 };
        for (operation, by, idle) in [("multiply", scale, 1.0), ("add", bias, 0.0)] {
            if by[..width].iter().any(|x| *x != idle) {
                let lines = vec![
                    id_line(&format!("ND_{operation}_{name}")),
                    format!("{usd} inputs:in1.connect = {out}"),
                    format!("{usd} inputs:in2 = {}", tuple(&by[..width])),
                ];
                out = self.node("Operation", lines, (usd, "out"));
            }
        }
        if kind == Kind::Normal {
            let lines = vec![
                id_line("ND_normalmap_float"),
                format!("float3 inputs:in.connect = {out}"),
                format!("float inputs:scale = {}", number(strength)),
            ];
            out = self.node("NormalMap", lines, ("float3", "out"));
        }
        out
    }

    /// MaterialX divides by the scale, turns clockwise and subtracts the offset. A scale of 0 cannot be said and is left out.
    fn place2d(&mut self, texture: &TextureRef) -> String {
        let lines = vec![id_line("ND_geompropvalue_vector2"), "string inputs:geomprop = \"st\"".to_owned()];
        let st = self.node("MtlxUV", lines, ("float2", "out"));
        if is_in_place(texture) {
            return st;
        }
        let scale = texture.uv_scale.map(|s| if s == 0.0 { 1.0 } else { 1.0 / s });
        let lines = vec![
            id_line("ND_place2d_vector2"),
            format!("float2 inputs:texcoord.connect = {st}"),
            format!("float2 inputs:scale = {}", tuple(&scale)),
            format!("float inputs:rotate = {}", number(-texture.uv_rotation)),
            format!("float2 inputs:offset = {}", tuple(&offset_from_below(texture).map(|x| -x))),
        ];
        self.node("Place", lines, ("float2", "out"))
    }
}

fn is_in_place(texture: &TextureRef) -> bool {
    texture.uv_scale == [1.0; 2] && texture.uv_offset == [0.0; 2] && texture.uv_rotation == 0.0
}

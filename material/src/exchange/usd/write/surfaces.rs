//! The three surfaces of a material.

use super::super::copy::{held, is_finite};
use super::super::images::as_written;
use super::super::materials::{ASM_ID, FOREIGN};
use super::super::numbers::{number, tuple};
use super::super::parse::parse;
use super::graph::{Graph, id_line};
use super::{ComputedImage, Options};
use crate::exchange::field::FieldDef;
use crate::exchange::model::{Context, ShadingModel, Translation};
use crate::exchange::models::{open_pbr, usd_preview};
use crate::exchange::plan::Job;
use crate::material::Material;
use crate::properties::PROPERTIES;
use crate::slot::{ColorSpace, TextureRef};
use crate::value::{Kind, Value};

/// A surface of a material, being written.
pub(super) struct Surface {
    /// Name of its prim.
    pub name: &'static str,
    /// What stands in it.
    pub lines: Vec<String>,
    /// Whether the material's displacement comes with it.
    pub displaces: bool,
}

/// What all surfaces of a material need.
pub(super) struct Surfaces<'s, 'o> {
    pub material: &'s Material,
    /// Place of the material in the list.
    pub place: usize,
    pub options: &'s Options<'s>,
    pub graph: &'s mut Graph<'o>,
    pub images: &'s mut Vec<ComputedImage>,
}

/// What a field of a model becomes.
enum Input {
    Constant(Value),
    Connected(String),
}

/// The nodes that a surface takes its images from.
#[derive(Clone, Copy, PartialEq)]
enum Nodes {
    Preview,
    MaterialX,
}

impl Surfaces<'_, '_> {
    /// The shader of the Adobe Standard Material: all 40 inputs, images beside values.
    pub fn standard(&mut self) -> Surface {
        let mut lines = vec![id_line(ASM_ID)];
        for def in PROPERTIES {
            let slot = self.material.slot(def.id);
            let kind = def.default.kind();
            let head = format!("{} inputs:{}", usd_type(kind), def.usage);
            let value = slot.value.filter(is_finite);
            if value.is_some() || slot.texture.is_none() {
                lines.push(format!("{head} = {}", value_text(held(value.unwrap_or(def.default)))));
            }
            if let Some(texture) = &slot.texture {
                let written = as_written(kind, texture, &(self.options.path_of)(texture));
                lines.push(format!("{head}.connect = {}", self.graph.uv_texture(kind, &written, 1.0)));
            }
        }
        lines.extend(self.foreign(ASM_ID));
        lines.push("token outputs:surface".to_owned());
        Surface { name: "ASM", lines, displaces: false }
    }

    /// UsdPreviewSurface.
    pub fn preview(&mut self) -> Surface {
        let (model, id) = (&usd_preview::MODEL, "UsdPreviewSurface");
        let translation = model.translate(self.material, &Context::of(self.material));
        let mut surface = Surface { name: "Preview", lines: vec![id_line(id)], displaces: false };
        for (place, def) in model.fields.iter().enumerate().filter(|(_, def)| !def.name.contains('.')) {
            let Some(input) = self.input(model, &translation, place, Nodes::Preview) else { continue };
            surface.displaces |= def.name == "displacement";
            surface.lines.push(line(usd_type(def.default.kind()), def.name, &input));
        }
        surface.lines.extend(self.foreign(id));
        surface.lines.push("token outputs:surface".to_owned());
        if surface.displaces {
            surface.lines.push("token outputs:displacement".to_owned());
        }
        surface
    }

    /// OpenPBR, with the nodes of MaterialX.
    pub fn open_pbr(&mut self) -> Surface {
        let (model, id) = (&open_pbr::MODEL, "ND_open_pbr_surface_surfaceshader");
        let translation = model.translate(self.material, &Context::of(self.material));
        let mut surface = Surface { name: "OpenPBR", lines: vec![id_line(id)], displaces: false };
        for (place, def) in model.fields.iter().enumerate().filter(|(_, def)| !def.name.contains('.')) {
            let Some(input) = self.input(model, &translation, place, Nodes::MaterialX) else { continue };
            match (def.name, def.default.kind()) {
                ("displacement", _) => {
                    let scale = field_value(model, &translation, "displacement.scale").unwrap_or(1.0);
                    let lines = vec![
                        id_line("ND_displacement_float"),
                        line("float", "displacement", &input),
                        format!("float inputs:scale = {}", number(scale)),
                    ];
                    self.graph.node("Displacement", lines, ("token", "out"));
                    surface.displaces = true;
                }
                ("geometry_tangent", _) => {
                    let tangent = self.tangent(&input);
                    surface.lines.push(format!("float3 inputs:geometry_tangent.connect = {tangent}"));
                }
                // A uniform direction is one of the surface here, but one of the scene there.
                (_, Kind::Normal) if matches!(input, Input::Constant(_)) => {}
                (_, Kind::Normal) => surface.lines.push(line("float3", def.name, &input)),
                (_, kind) => surface.lines.push(line(usd_type(kind), def.name, &input)),
            }
        }
        surface.lines.extend(self.foreign(id));
        surface.lines.push("token outputs:out".to_owned());
        surface
    }

    /// The tangent, turned clockwise as MaterialX does.
    fn tangent(&mut self, turns: &Input) -> String {
        let mut world = |stem: &str, id: &str| {
            let lines = vec![id_line(id), "string inputs:space = \"world\"".to_owned()];
            self.graph.node(stem, lines, ("float3", "out"))
        };
        let (tangent, normal) = (world("Tangent", "ND_tangent_vector3"), world("Normal", "ND_normal_vector3"));
        let amount = match turns {
            Input::Constant(Value::Float(turns)) => format!("float inputs:amount = {}", number(-360.0 * turns)),
            Input::Constant(_) => "float inputs:amount = 0".to_owned(),
            Input::Connected(source) => format!("float inputs:amount.connect = {source}"),
        };
        let lines = vec![
            id_line("ND_rotate3d_vector3"),
            format!("float3 inputs:in.connect = {tangent}"),
            amount,
            format!("float3 inputs:axis.connect = {normal}"),
        ];
        self.graph.node("Turn", lines, ("float3", "out"))
    }

    /// What a parameter of a model is written as; `None` where it stands at its default.
    fn input(&mut self, model: &'static ShadingModel, translation: &Translation, place: usize, nodes: Nodes) -> Option<Input> {
        let (def, field) = (model.fields.get(place)?, translation.fields.0.get(place)?);
        let kind = def.default.kind();
        let written = match (&field.texture, translation.images.iter().find(|image| image.field == place)) {
            (Some(texture), _) => Some(as_written(kind, texture, &(self.options.path_of)(texture))),
            (None, Some(image)) => {
                let texture = self.computed(model, def, place);
                let job = Job { material: self.place, ..Job::of_parameter(model, image, texture.path.clone(), 1.0)? };
                self.images.push(ComputedImage { model, job });
                Some(as_written(kind, &texture, &texture.path))
            }
            (None, None) => None,
        };
        let Some(mut texture) = written else {
            let is_said = field.is_authored && is_finite(&field.value);
            return is_said.then_some(Input::Constant(field.value));
        };
        if def.name == "geometry_tangent" {
            // Degrees the other way round, from turns.
            (texture.scale, texture.bias) = (texture.scale.map(|s| -360.0 * s), texture.bias.map(|b| -360.0 * b));
        }
        let strength = field_value(model, translation, &format!("{}.scale", def.name)).filter(|s| s.is_finite());
        let strength = if kind == Kind::Normal { strength.unwrap_or(1.0) } else { 1.0 };
        Some(Input::Connected(match nodes {
            Nodes::Preview => self.graph.uv_texture(kind, &texture, strength),
            Nodes::MaterialX => self.graph.materialx_image(kind, &texture, strength),
        }))
    }

    fn computed(&self, model: &ShadingModel, def: &FieldDef, place: usize) -> TextureRef {
        let (folder, name) = (self.options.image_folder, self.graph.name());
        let mut texture = TextureRef::new(format!("{folder}{name}_{}_{}.png", model.name, def.name.replace('.', "_")));
        let is_color = model.fields.get(place).is_some_and(|def| def.default.kind() == Kind::Color);
        texture.color_space = if is_color { ColorSpace::Srgb } else { ColorSpace::Linear };
        texture
    }

    /// What a file said about this surface that ASM has no place for. Entries that are no line of usda are left out.
    fn foreign(&self, id: &str) -> Vec<String> {
        let entries = self.material.foreign.get(FOREIGN).into_iter().flatten();
        let lines = entries.filter_map(|(key, json)| {
            let name = key.strip_prefix(id)?.strip_prefix('.')?;
            let text: String = serde_json::from_str(json).ok()?;
            let (kind, value) = text.split_once(' ')?;
            let line = format!("{kind} inputs:{name} = {value}");
            is_one_input(&line).then_some(line)
        });
        lines.collect()
    }
}

/// Whether a line is one input with a value and nothing else.
fn is_one_input(line: &str) -> bool {
    let text = format!("#usda 1.0\ndef Shader \"a\"\n{{\n{line}\n}}\n");
    let Ok(layer) = parse(&text) else { return false };
    let is_alone = layer.prims().count() == 1 && layer.attributes(1).count() == 1;
    is_alone
        && !line.contains(['\n', '\r', '#', '/', '@'])
        && layer.attributes(1).all(|a| a.value.is_some() && a.name.starts_with("inputs:"))
}

fn field_value(model: &ShadingModel, translation: &Translation, name: &str) -> Option<f64> {
    match translation.fields.get(model.fields, name)?.value {
        Value::Float(x) => Some(x),
        _ => None,
    }
}

fn line(usd_type: &str, name: &str, input: &Input) -> String {
    match input {
        Input::Constant(value) => format!("{usd_type} inputs:{name} = {}", value_text(*value)),
        Input::Connected(source) => format!("{usd_type} inputs:{name}.connect = {source}"),
    }
}

fn usd_type(kind: Kind) -> &'static str {
    match kind {
        Kind::Color => "color3f",
        Kind::Float => "float",
        Kind::Bool => "bool",
        Kind::Normal => "normal3f",
    }
}

fn value_text(value: Value) -> String {
    match value {
        Value::Bool(on) => (if on { "1" } else { "0" }).to_owned(),
        value => tuple(value.numbers()),
    }
}

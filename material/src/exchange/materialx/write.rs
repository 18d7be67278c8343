//! Writing: the translation that every program understands, and the native copy beside it.

use std::collections::HashSet;

use super::definition::{self, NODE, type_of, value_text};
use super::native_copy;
use super::nodes::readable_normal;
use super::surfaces::{PREVIEW, node_of, type_of_input};
use super::textures::{TextureGraph, writable};
use super::xml_write::Xml;
use super::{foreign, numbers};
use crate::exchange::field::{FieldDef, Fields};
use crate::exchange::loss::Row;
use crate::exchange::model::{Context, Notes, ShadingModel};
use crate::exchange::models::open_pbr;
use crate::exchange::plan::Job;
use crate::exchange::plan::largest;
use crate::file::ASM_VERSION;
use crate::material::Material;
use crate::slot::{ColorSpace, TextureRef};
use crate::value::{Kind, Value};

/// How a document is written.
pub struct WriteOptions<'a> {
    /// The model of the translation: one of MaterialX's surfaces.
    pub surface: &'static ShadingModel,
    /// The path in the document of an image whose path a material has.
    pub path: &'a dyn Fn(&str) -> String,
    /// Folder of computed images relative to the document, with `/` at its end; may be empty.
    pub folder: &'a str,
    /// Whether the native copy stands beside the translation.
    pub has_native_copy: bool,
}

impl Default for WriteOptions<'_> {
    fn default() -> Self {
        Self { surface: &open_pbr::MODEL, path: &str::to_owned, folder: "", has_native_copy: true }
    }
}

/// A document, and what the caller has to know and do beside it.
#[derive(Clone, Debug, PartialEq)]
pub struct Written {
    /// Its text.
    pub text: String,
    /// By material, in the order given.
    pub materials: Vec<WrittenMaterial>,
}

/// One material of a document.
#[derive(Clone, Debug, PartialEq)]
pub struct WrittenMaterial {
    /// Name in the document.
    pub name: String,
    /// Images to compute.
    pub images: Vec<Job>,
    /// What the translation costs, for programs that know nothing of the native copy.
    pub rows: Vec<Row>,
    /// What did not go as it stands.
    pub notes: Notes,
}

/// What an input of a node has.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Feed {
    /// A value.
    Value(String),
    /// An output of the graph of images.
    Output(String),
}

/// An input of a node.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Input {
    pub name: String,
    pub kind: &'static str,
    pub feed: Feed,
    /// The number with all its digits, where single precision does not hold it.
    pub wide: Option<String>,
}

impl Input {
    /// One without digits beyond single precision.
    pub fn plain(name: &str, kind: &'static str, feed: Feed) -> Self {
        Self { name: name.to_owned(), kind, feed, wide: None }
    }
}

/// Writes a document with these materials.
pub fn write(materials: &[&Material], options: &WriteOptions) -> Written {
    let mut xml = Xml::inside(0);
    xml.raw("<?xml version=\"1.0\"?>\n");
    xml.open("materialx", &[("version", "1.39"), ("colorspace", "lin_rec709")]);
    if options.has_native_copy {
        definition::write(&mut xml);
    }
    let mut names = HashSet::new();
    let materials = materials.iter().map(|material| write_material(&mut xml, material, options, &mut names)).collect();
    xml.close("materialx");
    Written { text: xml.into_text(), materials }
}

fn write_material(xml: &mut Xml, material: &Material, options: &WriteOptions, names: &mut HashSet<String>) -> WrittenMaterial {
    let name = free_name(&material.name, names);
    let mut notes = Notes::new();
    let material = finite(material, "not written", &mut notes);
    let mut graph = TextureGraph::named(graph_name(&name));
    let (fields, images, rows) = translated(&material, &name, options, &mut notes);
    let node = node_of(options.surface);
    let mut surface = surface_inputs(node, options.surface.fields, &fields, &mut graph);
    foreign::add(&material, node, &mut surface);
    let native = options.has_native_copy.then(|| native_copy::write(&material, options, &fields.found, &mut graph, &mut notes));

    let displacement = displacement_inputs(options.surface.fields, &fields, &mut graph);
    let graph_name = graph_name(&name);
    graph.write(xml);
    let (native_name, surface_name, displacement_name) =
        (format!("{name}_ASM"), format!("{name}_surface"), format!("{name}_displacement"));
    if let Some(native) = &native {
        let record = native.record.to_string();
        let attributes = [
            ("name", native_name.as_str()),
            ("type", "surfaceshader"),
            ("version", ASM_VERSION),
            (native_copy::RECORD, record.as_str()),
        ];
        write_node(xml, NODE, &attributes, &native.inputs, &graph_name);
    }
    write_node(xml, node, &[("name", &surface_name), ("type", "surfaceshader")], &surface, &graph_name);
    if !displacement.is_empty() {
        write_node(
            xml,
            "displacement",
            &[("name", &displacement_name), ("type", "displacementshader")],
            &displacement,
            &graph_name,
        );
    }
    let source = [(native_copy::SOURCE, native_name.as_str()), (native_copy::VERSION, ASM_VERSION)];
    let plain = format!("{name}_native");
    let both = [(&name, &surface_name, source.as_slice()), (&plain, &native_name, &[])];
    let alone = [(&name, &surface_name, [].as_slice())];
    for &(name, shader, more) in if native.is_some() { both.as_slice() } else { alone.as_slice() } {
        let mut attributes = vec![("name", name.as_str()), ("type", "material")];
        attributes.extend(more);
        xml.open("surfacematerial", &attributes);
        xml.empty("input", &[("name", "surfaceshader"), ("type", "surfaceshader"), ("nodename", shader)]);
        if !displacement.is_empty() {
            xml.empty(
                "input",
                &[("name", "displacementshader"), ("type", "displacementshader"), ("nodename", &displacement_name)],
            );
        }
        xml.close("surfacematerial");
    }
    WrittenMaterial { name, images, rows, notes }
}

fn write_node(xml: &mut Xml, tag: &str, attributes: &[(&str, &str)], inputs: &[Input], graph: &str) {
    xml.open(tag, attributes);
    for input in inputs {
        let mut attributes = vec![("name", input.name.as_str()), ("type", input.kind)];
        match &input.feed {
            Feed::Value(value) => attributes.push(("value", value)),
            Feed::Output(output) => attributes.extend([("nodegraph", graph), ("output", output.as_str())]),
        }
        attributes.extend(input.wide.as_deref().map(|wide| (native_copy::WIDE, wide)));
        xml.empty("input", &attributes);
    }
    xml.close(tag);
}

/// A name that MaterialX takes and that no other material of the document has, nor any of its nodes.
fn free_name(name: &str, names: &mut HashSet<String>) -> String {
    let mut valid: String = name.chars().take(100).map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if !valid.starts_with(|c: char| c.is_ascii_alphabetic()) {
        valid.insert_str(0, "Material_");
    }
    let candidates = std::iter::once(valid.clone()).chain((2_usize..).map(|k| format!("{valid}_{k}")));
    let nodes = |name: &str| {
        let suffixes = ["", "_native", "_ASM", "_surface", "_displacement"];
        suffixes.map(|suffix| format!("{name}{suffix}")).into_iter().chain([graph_name(name)])
    };
    let is_free = |name: &String| !nodes(name).any(|node| names.contains(&node) || definition::names().contains(&node));
    let free = candidates.into_iter().find(is_free).unwrap_or(valid);
    names.extend(nodes(&free));
    free
}

fn graph_name(name: &str) -> String {
    format!("NG_{name}_textures")
}

/// The material without numbers that are not finite. A note about each says what became of it: `not written`.
pub(super) fn finite(material: &Material, outcome: &str, notes: &mut Notes) -> Material {
    let mut clean = material.clone();
    for (property, slot) in material.slots() {
        let name = property.def().name;
        if slot.value.is_some_and(|value| value.numbers().iter().any(|x| !x.is_finite())) {
            clean.slot_mut(property).value = None;
            notes.push(format!("{name}: expected finite numbers; {outcome}"));
        }
        let Some(t) = &slot.texture else { continue };
        let all = [t.scale.as_slice(), &t.bias, &t.uv_scale, &t.uv_offset, &[t.uv_rotation]].concat();
        if all.iter().any(|x| !x.is_finite()) {
            clean.slot_mut(property).texture = Some(TextureRef { channel: t.channel, ..TextureRef::new(t.path.clone()) });
            notes.push(format!("{name}: expected finite settings of the image; {outcome}"));
        }
    }
    clean
}

/// A translation as it is written, and as a reader will find it.
struct WrittenFields {
    /// Bindings with paths in the document.
    bindings: Vec<Option<TextureRef>>,
    /// What a reader finds.
    found: Fields,
    /// The values.
    values: Vec<Value>,
    /// Whether automatic colour spaces of the bindings mean sRGB.
    is_color: Vec<bool>,
}

/// Translates a material. Images that cannot be written cost a note, and their parameter keeps its uniform value.
fn translated(material: &Material, name: &str, options: &WriteOptions, notes: &mut Notes) -> (WrittenFields, Vec<Job>, Vec<Row>) {
    let model = options.surface;
    let context = Context::of(material);
    let mut translation = model.translate(material, &context);
    let inputs = material.inputs();
    let mut planned = Vec::new();
    for image in &translation.images {
        let Some(def) = model.fields.get(image.field) else { continue };
        let largest = largest(image, &inputs, |i| (model.translate)(i, &context).get(image.field).copied()).max(1.0);
        let file = format!("{}{name}_{}.png", options.folder, def.name);
        if let Some(plan) = Job::of_parameter(model, image, file, largest) {
            let mut texture = TextureRef::new(plan.file.clone());
            texture.color_space = if plan.is_srgb { ColorSpace::Srgb } else { ColorSpace::Linear };
            texture.scale = [largest; 3];
            if let Some(field) = translation.fields.0.get_mut(image.field) {
                (field.texture, field.is_authored) = (Some(texture), true);
            }
            planned.push(plan);
        }
    }
    let mut fields = WrittenFields { bindings: Vec::new(), found: Fields(Vec::new()), values: Vec::new(), is_color: Vec::new() };
    for (place, (def, mut field)) in model.fields.iter().zip(translation.fields.0).enumerate() {
        let is_planned = translation.images.iter().any(|image| image.field == place);
        let binding = field.texture.take().and_then(|texture| {
            let path = if is_planned { texture.path.clone() } else { (options.path)(&texture.path) };
            match writable(&texture, def.default.kind(), path) {
                Ok((binding, found)) => {
                    field.texture = Some(found);
                    Some(binding)
                }
                Err(reason) => {
                    let note = format!("{}: the image `{}` {reason}; written without it", def.name, texture.path);
                    notes.push(note);
                    None
                }
            }
        });
        fields.is_color.push(def.from.iter().any(|property| property.def().default.kind() == Kind::Color));
        fields.values.push(field.value);
        field.value = stored(field.value);
        field.is_authored = field.value != def.default || binding.is_some();
        fields.bindings.push(binding);
        fields.found.0.push(field);
    }
    (fields, planned, translation.rows)
}

/// What a reader finds of a material's translation, and the parameters whose images had to be computed under names that nobody knows.
pub(super) fn expected(model: &'static ShadingModel, material: &Material) -> (Fields, Vec<usize>) {
    let options = WriteOptions { surface: model, ..WriteOptions::default() };
    let (fields, planned, _) = translated(material, &material.name, &options, &mut Notes::new());
    let computed = planned.iter().flat_map(Job::fields).collect();
    (fields.found, computed)
}

/// A value as a reader finds it.
pub(super) fn stored(value: Value) -> Value {
    match value {
        Value::Color(v) => Value::Color(v.map(numbers::stored)),
        Value::Normal(v) => Value::Normal(readable_normal(v)),
        Value::Float(v) => Value::Float(numbers::stored(v)),
        Value::Bool(v) => Value::Bool(v),
    }
}

const DISPLACEMENT: [&str; 2] = ["displacement", "displacement.scale"];

/// The inputs of the surface, and what they need in the graph.
fn surface_inputs(node: &str, table: &[FieldDef], fields: &WrittenFields, graph: &mut TextureGraph) -> Vec<Input> {
    let place = |name: &str| table.iter().position(|def| def.name == name);
    let is_said = |place: usize| fields.found.0.get(place).is_some_and(|field| field.is_authored);
    let mut inputs = Vec::new();
    for (at, def) in table.iter().enumerate() {
        let kind = def.default.kind();
        let scale = place(&format!("{}.scale", def.name));
        if DISPLACEMENT.contains(&def.name) || def.name.ends_with(".scale") || !(is_said(at) || scale.is_some_and(is_said)) {
            continue;
        }
        let (value, binding) = (fields.values[at], fields.bindings[at].as_ref());
        let feed = match (kind, value) {
            (Kind::Normal, Value::Normal(constant)) if node == PREVIEW => match binding {
                Some(binding) => {
                    let node = graph.direction(binding);
                    Feed::Output(graph.output(def.name, "vector3", node))
                }
                None => Feed::Value(numbers::list(&readable_normal(constant))),
            },
            (Kind::Normal, Value::Normal(constant)) => {
                let strength = scale.map_or(1.0, |scale| number(fields.values[scale]));
                let node = graph.normal(binding, constant, strength);
                Feed::Output(graph.output(def.name, "vector3", node))
            }
            (_, _) if def.name == "geometry_tangent" => {
                let turns = binding.map_or(Ok(number(value)), |binding| Err(graph.numbers(binding, Kind::Float, false)));
                let node = graph.tangent(turns);
                inputs.push(Input::plain(def.name, "vector3", Feed::Output(graph.output(def.name, "vector3", node))));
                continue;
            }
            _ => match binding {
                Some(binding) => {
                    let node = graph.numbers(binding, kind, fields.is_color[at]);
                    Feed::Output(graph.output(def.name, type_of(kind), node))
                }
                None => Feed::Value(value_text(value)),
            },
        };
        let (kind, feed) = match (type_of_input(def.name), value) {
            (Some(kind), value) => (kind, Feed::Value(integer(value))),
            (None, _) => (type_of(kind), feed),
        };
        inputs.push(Input::plain(def.name, kind, feed));
    }
    inputs
}

/// A switch or a choice as MaterialX has it.
fn integer(value: Value) -> String {
    match value {
        Value::Bool(on) => i32::from(on).to_string(),
        value => number(value).round().to_string(),
    }
}

/// The inputs of the displacement; empty where nothing says anything about it.
fn displacement_inputs(table: &[FieldDef], fields: &WrittenFields, graph: &mut TextureGraph) -> Vec<Input> {
    let [height, scale] = DISPLACEMENT.map(|name| table.iter().position(|def| def.name == name));
    let Some(height) = height else { return Vec::new() };
    if ![Some(height), scale].into_iter().flatten().any(|place| fields.found.0[place].is_authored) {
        return Vec::new();
    }
    let feed = match &fields.bindings[height] {
        Some(binding) => {
            let node = graph.numbers(binding, Kind::Float, false);
            Feed::Output(graph.output("displacement", "float", node))
        }
        None => Feed::Value(value_text(fields.values[height])),
    };
    let scale = scale.map(|scale| Input::plain("scale", "float", Feed::Value(value_text(fields.values[scale]))));
    std::iter::once(Input::plain("displacement", "float", feed)).chain(scale).collect()
}

fn number(value: Value) -> f64 {
    if let Value::Float(x) = value { x } else { 0.0 }
}

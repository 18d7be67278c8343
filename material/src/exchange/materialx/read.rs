//! Reading: each material of a document, from its native copy where there is one, else from its surface.

use std::collections::HashSet;

use super::definition::NODE;
use super::graph::{Graph, Link};
use super::surfaces::{SURFACES, model_of};
use super::walk::Walk;
use super::write::{expected, finite};
use super::xml::{Id, ROOT, ReadError, Tree};
use super::{fields, foreign, native_copy};
use crate::exchange::field::Fields;
use crate::exchange::merge::merge;
use crate::exchange::model::{Context, Notes, ShadingModel};
use crate::exchange::native::Native;
use crate::exchange::short::short;
use crate::material::Material;

/// Most materials of a document.
pub const MAX_MATERIALS: usize = 1000;
/// Most notes about a material; more help nobody.
const MAX_NOTES: usize = 100;

/// A material of a document.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadMaterial {
    /// Name of its surfacematerial.
    pub name: String,
    /// Category of the surface that it was read from: `open_pbr_surface`, or `adobe_standard_material` where the native copy stands alone.
    pub surface: String,
    /// Whether a native copy was found and used.
    pub is_native: bool,
    /// The material.
    pub material: Material,
    /// What did not go as it stands, in sentences for the user.
    pub notes: Notes,
}

/// Reads a document: all its materials, in the order of the text.
pub fn read(text: &str) -> Result<Vec<ReadMaterial>, ReadError> {
    let tree = Tree::parse(text)?;
    if tree.tag(ROOT) != "materialx" {
        return Err(ReadError::NotMaterialX { found: short(tree.tag(ROOT)) });
    }
    let graph = Graph::of(&tree);
    let mut walk = Walk::of(&graph);
    tell_of_document(&mut walk);
    let materials = found_materials(&graph);
    if materials.len() > MAX_MATERIALS {
        return Err(ReadError::TooMany { what: "materials", most: MAX_MATERIALS });
    }
    let native = |material: Id| {
        let name = tree.attribute(material, native_copy::SOURCE)?;
        graph.named(tree.parent(material).unwrap_or(ROOT), name).filter(|node| tree.tag(*node) == NODE)
    };
    // The other material of a native copy shows the copy itself: no second material.
    let claimed: HashSet<Id> = materials.iter().filter_map(|material| native(*material)).collect();
    let (mut read, mut unread, mut used) = (Vec::new(), Vec::new(), HashSet::new());
    for material in materials {
        let shader = shader_of(&graph, material);
        let copy = native(material).or(shader.filter(|shader| tree.tag(*shader) == NODE));
        if native(material).is_none() && copy.is_some_and(|copy| claimed.contains(&copy)) {
            continue;
        }
        // A copy is that of one material.
        let copy = copy.filter(|copy| used.insert(*copy));
        match read_material(&mut walk, material, shader, copy) {
            Ok(found) => read.push(found),
            Err(what) => unread.push(what),
        }
    }
    if read.is_empty() {
        unread.truncate(3);
        return Err(ReadError::NoMaterial { found: unread.join(", ") });
    }
    for material in &mut read {
        material.notes.splice(0..0, walk.document_notes.iter().cloned());
        material.notes.extend(unread.iter().map(|what| format!("another material of the file was not read: {what}")));
        tidy(&mut material.notes);
    }
    Ok(read)
}

/// The materials of a document; without any, its surfaces stand for themselves.
fn found_materials(graph: &Graph) -> Vec<Id> {
    let tree = graph.tree;
    let all = |is_wanted: &dyn Fn(Id) -> bool| {
        (0..tree.len() as Id).filter(|id| is_wanted(*id)).take(MAX_MATERIALS + 1).collect::<Vec<_>>()
    };
    let materials = all(&|id| tree.tag(id) == "surfacematerial");
    if !materials.is_empty() {
        return materials;
    }
    let is_definition = |id: Id| tree.parent(id).is_some_and(|parent| tree.attribute(parent, "nodedef").is_some());
    let is_surface = |id: Id| tree.tag(id) == NODE || SURFACES.iter().any(|surface| surface.node == tree.tag(id));
    all(&|id| is_surface(id) && !is_definition(id))
}

/// The node behind the surface of a material, through the outputs of graphs.
fn shader_of(graph: &Graph, material: Id) -> Option<Id> {
    if graph.tree.tag(material) != "surfacematerial" {
        return Some(material);
    }
    node_behind(graph, graph.input(material, "surfaceshader")?)
}

fn node_behind(graph: &Graph, input: Id) -> Option<Id> {
    let mut at = input;
    for _ in 0..64 {
        match graph.link(at) {
            Link::Node(node, _) if graph.tree.tag(node) == "output" => at = node,
            Link::Node(node, _) => return Some(node),
            _ => return None,
        }
    }
    None
}

fn read_material(walk: &mut Walk, material: Id, shader: Option<Id>, copy: Option<Id>) -> Result<ReadMaterial, String> {
    let graph = walk.graph;
    let name = graph.tree.attribute(material, "name").unwrap_or_default().to_owned();
    walk.notes.clear();
    let category = shader.map_or("", |shader| graph.tree.tag(shader));
    let surface = shader.zip(model_of(category));
    let version = graph.tree.attribute(material, native_copy::VERSION).map(str::to_owned);
    let found = copy.and_then(|copy| native_copy::read(walk, copy, version.as_deref(), surface.map(|(_, model)| model)));
    let is_native = found.is_some();
    let mut read = match (found, surface) {
        (found, Some((shader, model))) => {
            let displacement = displacement_of(walk, material);
            let said = fields::read(walk, shader, displacement, model);
            let is_known = |name: &str| {
                let is_scaled = |field: &str| field.strip_suffix(".scale").unwrap_or(field) == name;
                model.fields.iter().any(|def| is_scaled(def.name))
            };
            let mut notes = std::mem::take(&mut walk.notes);
            foreign::tell_unknown(walk, shader, category, is_known, &mut notes);
            let read = match found {
                Some(found) => merged(model, found, &said, &mut notes),
                None => model.interpret(&said, &Context::of(&Material::default()), &mut notes),
            };
            walk.notes = notes;
            read
        }
        (Some(found), None) => found.native.material,
        (None, None) if category.is_empty() => return Err(format!("`{}` without a surface", short(&name))),
        (None, None) => return Err(format!("`{}` with the surface <{}>", short(&name), short(category))),
    };
    // Products of numbers that are finite may not be.
    read = finite(&read, "not taken", &mut walk.notes);
    if !is_native {
        read.name.clone_from(&name);
    }
    if let Some((shader, _)) = surface {
        foreign::keep(walk, shader, category, &mut read);
    }
    Ok(ReadMaterial { name, surface: category.to_owned(), is_native, material: read, notes: std::mem::take(&mut walk.notes) })
}

/// The material of a native copy and of a surface that a program may have changed since.
fn merged(model: &'static ShadingModel, found: native_copy::Found, said: &Fields, notes: &mut Notes) -> Material {
    let native_copy::Found { native, broken } = found;
    let context = Context::of(&native.material);
    let translation = native.translation.unwrap_or_else(|| {
        // Without a record, what the surface leaves out was not changed, and neither are images that only the writer can name.
        let (mut fields, computed) = expected(model, &native.material);
        for (place, (field, said)) in fields.0.iter_mut().zip(&said.0).enumerate() {
            if !said.is_authored || (said.texture.is_some() && computed.contains(&place)) {
                field.clone_from(said);
            }
        }
        fields
    });
    let native = Native { material: native.material, translation: Some(translation) };
    let mut material = merge(model, &native, said, &context, notes);
    if !broken.is_empty() {
        let derived = model.interpret(said, &context, &mut Notes::new());
        for property in broken {
            *material.slot_mut(property) = derived.slot(property).clone();
        }
    }
    material
}

/// The displacement node of a material.
fn displacement_of(walk: &mut Walk, material: Id) -> Option<Id> {
    let graph = walk.graph;
    let node = node_behind(graph, graph.input(material, "displacementshader")?)?;
    if graph.tree.tag(node) == "displacement" {
        return Some(node);
    }
    walk.note(format!(
        "{}: <{}> is no displacement that a material can hold; not taken",
        graph.path(node),
        short(graph.tree.tag(node))
    ));
    None
}

fn tell_of_document(walk: &mut Walk) {
    let tree = walk.graph.tree;
    match tree.attribute(ROOT, "version") {
        Some(version) if version.starts_with("1.38") || version.starts_with("1.39") => {}
        Some(version) => walk.document_notes.push(format!("MaterialX {}: read as if it were 1.39", short(version))),
        None => walk.document_notes.push("a file without a version of MaterialX: read as if it were 1.39".to_owned()),
    }
    let includes = (0..tree.len() as Id).filter(|id| tree.tag(*id) == "xi:include");
    for include in includes.take(MAX_NOTES) {
        let href = tree.attribute(include, "href").unwrap_or_default();
        walk.document_notes.push(format!("xi:include `{}`: no other file is opened; what it defines is missing", short(href)));
    }
}

/// Each note once, and not more than anybody reads.
fn tidy(notes: &mut Notes) {
    let mut seen = HashSet::new();
    notes.retain(|note| seen.insert(note.clone()));
    if notes.len() > MAX_NOTES {
        let more = notes.len() - MAX_NOTES;
        notes.truncate(MAX_NOTES);
        notes.push(format!("and {more} notes more"));
    }
}

//! Writing usda: the frame of the file, the materials with three networks each, and a mesh that wears them.

mod graph;
mod mesh;
mod surfaces;
mod text;

use super::super::model::{Notes, ShadingModel};
use super::super::plan::Job;
use super::copy;
use super::numbers::{double, quoted};
use crate::material::Material;
use crate::properties::PROPERTIES;
use crate::slot::TextureRef;
use graph::Graph;
pub use mesh::MeshArrays;
use surfaces::Surfaces;
use text::Text;

/// What an export is told beside its materials.
pub struct Options<'a> {
    /// Where the file of an image lies beside the layer: a relative path with `/`. The caller copies it there.
    pub path_of: &'a dyn Fn(&TextureRef) -> String,
    /// Folder beside the layer, with its last `/`, for images that are computed.
    pub image_folder: &'a str,
    /// A mesh to wear the materials.
    pub mesh: Option<&'a MeshArrays<'a>>,
    /// Whether the native copy stands beside the networks.
    pub has_native_copy: bool,
}

/// An export: the text, and the images that the caller computes for it.
#[derive(Clone, Debug)]
pub struct Export {
    /// The layer.
    pub text: String,
    /// Images to be computed.
    pub images: Vec<ComputedImage>,
    /// Sentences for the user about what did not go as it stands in the materials.
    pub notes: Notes,
}

/// An image that the caller computes.
#[derive(Clone, Debug)]
pub struct ComputedImage {
    /// Whose parameters it holds.
    pub model: &'static ShadingModel,
    /// What it holds.
    pub job: Job,
}

/// Writes materials as a layer. The same input makes the same text; no number in it is NaN or infinite.
///
/// One material without a mesh is the default prim itself; several stand in a scope in a scene. The unit of the file is the first
/// material's.
pub fn write(materials: &[&Material], options: &Options) -> Export {
    let mut export = Export { text: String::new(), images: Vec::new(), notes: Notes::new() };
    let meters_per_unit = materials.first().map_or(0.01, |material| material.unit_mm() / 1000.0);
    let names = identifiers(materials);
    let is_alone = materials.len() == 1 && options.mesh.is_none();
    let (root, parent) = if is_alone { (names[0].as_str(), String::new()) } else { ("Scene", "/Scene/Materials".to_owned()) };

    let mut text = Text::default();
    text.line("#usda 1.0");
    text.open_round("");
    text.line(&format!("defaultPrim = {}", quoted(root)));
    text.line(&format!("metersPerUnit = {}", double(meters_per_unit)));
    text.line("upAxis = \"Y\"");
    text.close(")");
    if !is_alone {
        text.line("");
        text.open_round(&format!("def Xform {} ", quoted(root)));
        text.line("kind = \"component\"");
        text.close(")");
        text.open();
        text.open_prim("def Scope \"Materials\"");
    }
    for (place, (material, name)) in materials.iter().zip(&names).enumerate() {
        tell(material, name, meters_per_unit, &mut export.notes);
        let path = format!("{parent}/{name}");
        write_material(&mut text, material, place, &path, options, &mut export);
    }
    if !is_alone {
        text.close("}");
        if let Some(mesh) = options.mesh {
            let paths: Vec<String> = names.iter().map(|name| format!("{parent}/{name}")).collect();
            mesh::write(&mut text, mesh, &paths, meters_per_unit);
        }
        text.close("}");
    }
    export.text = text.finish();
    export
}

fn write_material(text: &mut Text, material: &Material, place: usize, path: &str, options: &Options, export: &mut Export) {
    let name = path.rsplit('/').next().unwrap_or_default();
    let mut graph = Graph::new(path);
    let mut surfaces = Surfaces { material, place, options, graph: &mut graph, images: &mut export.images };
    let (standard, preview, open_pbr) = (surfaces.standard(), surfaces.preview(), surfaces.open_pbr());

    text.line("");
    text.open_round(&format!("def Material {} ", quoted(name)));
    if options.has_native_copy {
        text.open_round("customData = {");
        text.open_round("dictionary asm = {");
        for line in copy::lines(material, options.path_of) {
            text.line(&line);
        }
        text.close("}");
        text.close("}");
    }
    if !material.name.is_empty() && material.name != name {
        text.line(&format!("displayName = {}", quoted(&material.name)));
    }
    text.close(")");
    text.open();
    let mut connect = |terminal: &str, source: &str| text.line(&format!("token outputs:{terminal}.connect = <{path}/{source}>"));
    connect("adobe:surface", "ASM.outputs:surface");
    connect("surface", "Preview.outputs:surface");
    connect("mtlx:surface", "OpenPBR.outputs:out");
    if preview.displaces {
        connect("displacement", "Preview.outputs:displacement");
    }
    if open_pbr.displaces {
        connect("mtlx:displacement", "Displacement.outputs:out");
    }
    for surface in [standard, preview, open_pbr] {
        text.shader(surface.name, &surface.lines);
    }
    graph.write(text);
    text.close("}");
}

fn tell(material: &Material, name: &str, meters_per_unit: f64, notes: &mut Notes) {
    if material.unit_mm() / 1000.0 != meters_per_unit {
        notes.push(format!(
            "{name}: its lengths are in units of {} mm, those of the file in {} mm; its numbers are written as they are",
            material.unit_mm(),
            meters_per_unit * 1000.0
        ));
    }
    for def in PROPERTIES {
        if material.slot(def.id).value.as_ref().is_some_and(|value| !copy::is_finite(value)) {
            notes.push(format!("{name}: {}: expected finite numbers, found others; the default is written", def.name));
        }
    }
}

/// Names that USD lets prims have, each one once.
fn identifiers(materials: &[&Material]) -> Vec<String> {
    const LENGTH: usize = 100;
    let mut used = std::collections::HashSet::new();
    let fits = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let mut unique = |material: &&Material| {
        let mut stem: String = material.name.chars().take(LENGTH).map(fits).collect();
        if !stem.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') {
            stem.insert_str(0, if stem.is_empty() { "Material" } else { "_" });
        }
        let mut name = stem.clone();
        let mut count = 1;
        while !used.insert(name.clone()) {
            count += 1;
            name = format!("{stem}_{count}");
        }
        name
    };
    materials.iter().map(&mut unique).collect()
}

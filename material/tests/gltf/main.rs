//! glTF: what is written comes back, what others wrote is read, and what is broken is refused in one sentence.

#[path = "../common/mod.rs"]
mod common;

mod broken;
mod edits;
mod images;
mod import;
mod round_trip;
mod vectors;

use burnish_material::exchange::gltf::{Document, Mesh, Options, Part, Written, read, write};
use burnish_material::exchange::model::Context;
use burnish_material::exchange::models::gltf::MODEL;
use burnish_material::{Channel, ColorSpace, Material, PROPERTIES, Property, TextureRef, Value, Wrap};
use serde_json::{Value as Json, json};

const PNG: &[u8] = &[0x89, b'P', b'N', b'G', 13, 10, 26, 10];

const QUAD: Mesh = Mesh {
    positions: &[[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]],
    normals: &[[0.0, 0.0, 1.0]; 4],
    tangents: &[[1.0, 0.0, 0.0, 1.0]; 4],
    uvs: &[[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]],
    triangles: &[[0, 1, 2], [0, 2, 3]],
};

fn written(material: &Material, mesh: Option<&Mesh>, options: &Options) -> Written {
    let context = Context { mesh_width: mesh.map_or(1.0, Mesh::width), ..Context::of(material) };
    let translation = MODEL.translate(material, &context);
    write(&[Part { material, translation: &translation, context }], mesh, options).expect("a mesh in order")
}

fn gltf(material: &Material) -> Json {
    parsed(&written(material, None, &Options::default()))
}

fn parsed(written: &Written) -> Json {
    serde_json::from_str(&written.gltf("mesh.bin")).expect("our own JSON")
}

fn bare() -> Options {
    Options { has_native_copy: false, ..Options::default() }
}

fn opened(bytes: &[u8]) -> Document {
    read(bytes).expect("a document in order")
}

/// The only material of a document, and what was told about it.
fn only(json: &Json) -> (Material, Vec<String>) {
    opened(json.to_string().as_bytes()).materials[0].material()
}

fn of_material(material: Json) -> Json {
    json!({ "asset": { "version": "2.0" }, "materials": [material] })
}

fn with_image(material: Json) -> Json {
    let mut root = of_material(material);
    root["textures"] = json!([{ "source": 0 }]);
    root["images"] = json!([{ "uri": "a.png" }]);
    root
}

fn all_at(value: impl Fn(&'static burnish_material::PropertyDef) -> f64) -> Material {
    let mut material = Material::named("All");
    for def in PROPERTIES {
        material.set(
            def.id,
            match def.default {
                Value::Float(_) => Value::Float(value(def)),
                Value::Color(_) => Value::Color([value(def); 3]),
                Value::Bool(_) => Value::Bool(value(def) > 0.5),
                normal => normal,
            },
        );
    }
    material
}

fn least() -> Material {
    all_at(|def| def.limits.min.unwrap_or(0.0))
}

fn most() -> Material {
    all_at(|def| def.limits.max.unwrap_or(def.limits.slider_max))
}

fn off_default() -> Material {
    let mut material = all_at(|def| match def.default {
        Value::Float(x) if x > 0.5 => 0.75 * x + def.limits.min.unwrap_or(0.0) * 0.25,
        Value::Float(x) => x + 0.1 * (def.limits.slider_max - x),
        _ => 0.7,
    });
    material.unit_mm = Some(1000.0);
    material.tags = vec!["test".to_owned()];
    for (property, path) in [(Property::normal, "tex/normal.png"), (Property::roughness, "tex/orm.png")] {
        material.slot_mut(property).texture = Some(TextureRef::new(path));
    }
    let roughness = material.slot_mut(Property::roughness).texture.as_mut().expect("just put there");
    (roughness.channel, roughness.uv_scale, roughness.uv_rotation, roughness.uv_offset) =
        (Channel::G, [2.0, 3.0], 30.0, [-1.4, -1.7980762]);
    material
}

/// Different settings for the images of a material, the same for the same number.
fn varied(mut material: Material, number: u64) -> Material {
    let mut state = number;
    let mut draw = |count: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % count
    };
    for def in PROPERTIES {
        let Some(texture) = &mut material.slot_mut(def.id).texture else { continue };
        texture.channel = Channel::ALL[draw(Channel::ALL.len())].0;
        texture.color_space = ColorSpace::ALL[draw(ColorSpace::ALL.len())].0;
        texture.wrap = Wrap::ALL[draw(Wrap::ALL.len())].0;
        texture.is_inverted = draw(4) == 0;
        texture.scale = [[1.0; 3], [0.5; 3], [0.25, 0.5, 1.0], [2.0; 3]][draw(4)];
        texture.bias = [[0.0; 3], [0.0; 3], [0.1; 3]][draw(3)];
        (texture.uv_scale, texture.uv_rotation) = [([1.0; 2], 0.0), ([2.0, 3.0], 30.0)][draw(2)];
        let path = ["a.png", "b.jpg", "/absolute/a.png", "builtin:wood-oak/base_color", "folder/c.exr", "d.webp"][draw(6)];
        texture.path = path.to_owned();
    }
    material
}

/// The material as a document can hold it: images beside the document.
fn beside(written: &Written, material: &Material) -> Material {
    let mut moved = material.clone();
    for def in PROPERTIES {
        let Some(texture) = &mut moved.slot_mut(def.id).texture else { continue };
        if texture.path.starts_with('/') {
            let copy = written.plan.copies.iter().find(|copy| copy.path == texture.path).expect("a place for each image");
            texture.path = copy.file.clone();
        }
    }
    moved
}

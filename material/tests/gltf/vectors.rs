//! Numbers that the mapping and the formats publish.

use burnish_material::exchange::gltf::{Mesh, Options};
use burnish_material::{Channel, Material, Property, TextureRef, Value};
use serde_json::json;

use super::{QUAD, bare, gltf, parsed, written};

fn near(json: &serde_json::Value, expected: &[f64]) {
    let list = json.as_array().cloned().unwrap_or_else(|| vec![json.clone()]);
    assert_eq!(list.len(), expected.len(), "{json}");
    for (found, expected) in list.iter().zip(expected) {
        let found = found.as_f64().expect("a number");
        assert!((found - expected).abs() <= 1e-6 * expected.abs().max(1.0), "{found} {expected}");
    }
}

#[test]
fn anisotropy_is_the_published_strength() {
    for (roughness, anisotropy, strength) in [(0.3, 0.5, 0.2620712), (0.1, 0.8, 0.6432242), (0.6, 0.3, 0.1125), (0.9, 0.9, 1.0)] {
        let mut material = Material::named("Brushed");
        material.set(Property::roughness, Value::Float(roughness)).set(Property::anisotropy, Value::Float(anisotropy));
        near(&gltf(&material)["materials"][0]["extensions"]["KHR_materials_anisotropy"]["anisotropyStrength"], &[strength]);
    }
}

#[test]
fn a_level_of_the_coat_above_the_middle_becomes_its_index() {
    for (ior, level, written, factor) in [(1.6, 0.4, 1.6, 0.8), (1.5, 1.0, 1.788789, 1.0)] {
        let mut material = Material::named("Lacquer");
        material.set(Property::coat, Value::Float(1.0)).set(Property::coat_ior, Value::Float(ior));
        material.set(Property::coat_specular_level, Value::Float(level));
        let json = gltf(&material);
        let coat = &json["materials"][0]["extensions"]["ADOBE_materials_clearcoat_specular"];
        near(&coat["clearcoatIor"], &[written]);
        near(coat.get("clearcoatSpecularFactor").unwrap_or(&json!(1.0)), &[factor]);
    }
}

/// The base of ASM has its coat as surroundings and reflects less for it, that of glTF does not: the factor is what is left.
#[test]
fn under_a_coat_the_reflection_is_what_the_coat_leaves_of_it() {
    for (coat, ior, coat_ior, left) in
        [(1.0, 1.5, 1.6, 0.0260145681581686), (0.5, 1.5, 1.6, 0.5130072840790843), (1.0, 1.5, 1.5, 0.0), (0.0, 1.5, 1.6, 1.0)]
    {
        let mut material = Material::named("Lacquer");
        material.set(Property::coat, Value::Float(coat)).set(Property::coat_ior, Value::Float(coat_ior));
        material.set(Property::specular_ior, Value::Float(ior)).set(Property::specular_level, Value::Float(0.5));
        let json = gltf(&material);
        let factor = json["materials"][0]["extensions"]["KHR_materials_specular"].get("specularFactor");
        near(factor.unwrap_or(&json!(1.0)), &[left]);
    }
}

#[test]
fn a_scattering_body_is_written_as_its_extinction() {
    let mut material = Material::named("Wax");
    material.unit_mm = Some(1000.0);
    for (property, value) in [
        (Property::translucency, 0.6),
        (Property::absorption_distance, 12.5),
        (Property::scatter_distance, 3.75),
        (Property::scatter_red_shift, 0.5),
        (Property::scatter_rayleigh, 0.3),
        (Property::volume_thickness, 0.8),
        (Property::volume_thickness_scale, 2.0),
    ] {
        material.set(property, Value::Float(value));
    }
    material.set(Property::scatter, Value::Bool(true));
    material.set(Property::absorption_color, Value::Color([0.9, 0.5, 0.2]));
    material.set(Property::scatter_color, Value::Color([0.8, 0.6, 0.5]));
    material.set(Property::scatter_distance_scale, Value::Color([1.0, 0.4, 0.25]));
    let extensions = &gltf(&material)["materials"][0]["extensions"];
    let volume = &extensions["KHR_materials_volume"];
    near(&volume["attenuationDistance"], &[12.456447580509154]);
    near(&volume["attenuationColor"], &[0.36787944117144233, 8.791836853257702e-5, 2.2014814112348024e-9]);
    near(&volume["thicknessFactor"], &[1.6]);
    near(&extensions["KHR_materials_diffuse_transmission"]["diffuseTransmissionFactor"], &[0.6]);
    assert!(extensions.get("KHR_materials_transmission").is_none());
}

#[test]
fn lengths_are_metres_and_thickness_is_in_units_of_the_mesh() {
    let mut material = Material::named("Glass");
    material.unit_mm = Some(10.0);
    material.set(Property::translucency, Value::Float(1.0)).set(Property::absorption_distance, Value::Float(5.0));
    let json = parsed(&written(&material, Some(&QUAD), &Options::default()));
    let volume = &json["materials"][0]["extensions"]["KHR_materials_volume"];
    near(&volume["attenuationDistance"], &[0.05]);
    near(&volume["thicknessFactor"], &[2.0]);
    assert_eq!(Mesh::width(&QUAD), 2.0);
}

/// Where a point of the surface reads an image, with the origin at the lower left corner: turn (scale (st)) + shift.
fn place([s, t]: [f64; 2], degrees: f64, scale: [f64; 2], shift: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let [s, t] = [s * scale[0], t * scale[1]];
    [cos * s - sin * t + shift[0], sin * s + cos * t + shift[1]]
}

#[test]
fn the_base_colour_takes_the_tint_of_what_is_transmitted() {
    let mut material = Material::named("Tinted");
    material.set(Property::metallic, Value::Float(0.5)).set(Property::translucency, Value::Float(0.5));
    material.set(Property::absorption_color, Value::Color([0.1, 0.5, 0.9]));
    let color = |material: &Material| gltf(material)["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"].clone();
    near(&color(&material), &[0.4, 0.5, 0.6, 1.0]);
    material.set(Property::absorption_distance, Value::Float(1.0));
    near(&color(&material), &[0.625, 0.625, 0.625, 1.0]);
    material.set(Property::scatter, Value::Bool(true));
    near(&color(&material), &[0.5, 0.5, 0.5, 1.0]);
}

#[test]
fn transforms_of_images_are_those_of_the_format() {
    let mut material = Material::named("Turned");
    let mut texture = TextureRef::new("a.png");
    (texture.uv_scale, texture.uv_rotation, texture.uv_offset) = ([2.0, 3.0], 30.0, [-1.4, -1.7980762113533158]);
    texture.channel = Channel::G;
    material.slot_mut(Property::base_color).texture = Some(TextureRef { channel: Channel::Rgb, ..texture.clone() });
    let json = parsed(&written(&material, None, &bare()));
    assert_eq!(json["extensionsRequired"], json!(["KHR_texture_transform"]));
    let info = &json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]["KHR_texture_transform"];
    near(&info["rotation"], &[std::f64::consts::FRAC_PI_6]);
    near(&info["scale"], &[2.0, 3.0]);
    near(&info["offset"], &[-1.4, -1.7980762]);
    // The same place as a shift of (.1, .2) means with the origin at the lower left.
    let number = |key: &str, k: usize| info[key][k].as_f64().expect("a number");
    let (sin, cos) = info["rotation"].as_f64().expect("a number").sin_cos();
    for [u, v] in [[0.0, 0.0], [0.3, 0.8], [1.0, 0.25]] {
        let (x, y) = (number("scale", 0) * u, number("scale", 1) * v);
        let here = [cos * x + sin * y + number("offset", 0), -sin * x + cos * y + number("offset", 1)];
        let [s, t] = place([u, 1.0 - v], 30.0, [2.0, 3.0], [0.1, 0.2]);
        near(&json!(here), &[s, 1.0 - t]);
    }
}

#[test]
fn emission_beyond_one_goes_to_the_strength() {
    let mut material = Material::named("Lamp");
    material.set(Property::emission, Value::Float(3.0)).set(Property::emission_color, Value::Color([4.0, 2.0, 0.0]));
    let json = gltf(&material);
    near(&json["materials"][0]["emissiveFactor"], &[1.0, 0.5, 0.0]);
    near(&json["materials"][0]["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"], &[12.0]);
}

#[test]
fn defaults_take_no_extension() {
    let json = parsed(&written(&Material::named("Plain"), None, &bare()));
    assert_eq!(
        json["materials"],
        json!([{ "name": "Plain", "pbrMetallicRoughness": {
            "baseColorFactor": [0.5, 0.5, 0.5, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.3 } }])
    );
    assert!(json.get("extensionsUsed").is_none() && json.get("extensionsRequired").is_none());
}

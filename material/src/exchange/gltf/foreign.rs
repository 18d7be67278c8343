//! What a material says that ASM has no place for: kept word for word, and written back while the properties beside it stand as they were.
//!
//! An entry is a JSON text `{"json": …, "beside": {"roughness": …}}`: what stood in the file, and the properties next to it as they were
//! read. Numbers of textures mean nothing in another file, so that an `index` becomes the path and the wrap mode of its image.

use std::collections::BTreeMap;

use serde_json::{Map, Value as Json, json};

use super::images::Images;
use super::slots::{ANISOTROPY_IMAGE, SLOTS};
use super::uri;
use crate::exchange::model::Notes;
use crate::exchange::models::gltf::{Gltf, MODEL};
use crate::exchange::native::{texture_json, value_json};
use crate::exchange::short::short;
use crate::foreign::MAX_FOREIGN_TEXTS;
use crate::material::Material;
use crate::properties::Property;
use crate::slot::{Slot, Wrap};

const ANISOTROPY: &str = "KHR_materials_anisotropy";

/// Longest text that is kept, bytes.
const MAX_ENTRY_BYTES: usize = 1 << 20;

/// What is kept of a material, by key: names of extensions, and of keys of the material itself.
pub(super) fn collect(material: &Json, images: &Images) -> BTreeMap<String, Json> {
    let mut kept = BTreeMap::new();
    // Directions have no place here, and a strength over an image of roughness is another one at each texel.
    let has_image = |name: &str| super::json::at(material, name).is_some();
    let is_approximated = has_image(ANISOTROPY_IMAGE) || has_image("pbrMetallicRoughness.metallicRoughnessTexture");
    // More than a material can keep is not worth the time.
    for (name, body) in material.get("extensions").and_then(Json::as_object).into_iter().flatten().take(MAX_FOREIGN_TEXTS) {
        if !is_read(name) || (is_approximated && name == ANISOTROPY) {
            kept.insert(name.clone(), named(body, images));
        }
    }
    if material.get("doubleSided").and_then(Json::as_bool) == Some(true) {
        kept.insert("doubleSided".to_owned(), json!(true));
    }
    if let Some(extras) = material.get("extras") {
        let mut extras = extras.clone();
        if let Some(entries) = extras.as_object_mut() {
            entries.shift_remove("asm");
        }
        if extras.as_object().is_none_or(|entries| !entries.is_empty()) {
            kept.insert("extras".to_owned(), extras);
        }
    }
    kept.retain(|_, body| body.to_string().len() <= MAX_ENTRY_BYTES);
    kept
}

/// Whether the user should hear of it: not of what changes no look, nor of what a note tells of already.
pub(super) fn is_worth_a_note(key: &str) -> bool {
    !["doubleSided", "extras", "KHR_materials_unlit", "KHR_materials_volume"].contains(&key)
}

/// What is kept of an extension: numbers of textures become what they mean.
pub(super) fn named(body: &Json, images: &Images) -> Json {
    let mut body = body.clone();
    name_images(&mut body, images);
    body
}

/// Whether all that an extension says is read.
fn is_read(extension: &str) -> bool {
    let is_of = |name: &str| name.split('.').next() == Some(extension);
    extension == "KHR_materials_pbrSpecularGlossiness"
        || Gltf::FIELDS.iter().any(|def| is_of(def.name))
        || SLOTS.iter().any(|slot| is_of(slot.name))
}

/// Replaces numbers of textures by what they mean; those of images that cannot be had go.
fn name_images(json: &mut Json, images: &Images) {
    match json {
        Json::Object(entries) => {
            entries.retain(|key, value| {
                if !key.ends_with("Texture") || value.get("index").is_none() {
                    return true;
                }
                let Ok(texture) = images.used(value, "", &mut Vec::new()) else { return false };
                value["index"] = json!({ "path": texture.path, "wrap": texture.wrap.word() });
                true
            });
            entries.values_mut().for_each(|value| name_images(value, images));
        }
        Json::Array(list) => list.iter_mut().for_each(|value| name_images(value, images)),
        _ => {}
    }
}

/// Turns such names back into numbers of textures.
pub(super) fn number_images(json: &mut Json, number_of: &mut impl FnMut(&str, Wrap) -> usize) {
    match json {
        Json::Object(entries) => {
            entries.retain(|key, value| {
                let Some(index) = value.get("index").filter(|_| key.ends_with("Texture")) else { return true };
                // Whatever stands in a file: images come from beside the document, as they did.
                let Some(path) = index.get("path").and_then(Json::as_str).and_then(uri::safe) else { return false };
                let wrap = index.get("wrap").and_then(Json::as_str).and_then(Wrap::from_word).unwrap_or(Wrap::Repeat);
                let number = number_of(&path, wrap);
                value["index"] = json!(number);
                true
            });
            entries.values_mut().for_each(|value| number_images(value, number_of));
        }
        Json::Array(list) => list.iter_mut().for_each(|value| number_images(value, number_of)),
        _ => {}
    }
}

/// Properties that mean something else once they are changed beside what is kept under this key.
fn beside(key: &str) -> &'static [Property] {
    use Property as P;
    match key {
        "alphaMode" => &[P::opacity],
        "KHR_materials_unlit" => &[P::base_color, P::metallic, P::specular_level, P::emission, P::emission_color],
        ANISOTROPY => &[P::roughness, P::anisotropy, P::anisotropy_rotation],
        "KHR_materials_volume" => &[
            P::translucency,
            P::scatter,
            P::scatter_distance,
            P::dispersion,
            P::absorption_color,
            P::absorption_distance,
            P::volume_thickness,
            P::volume_thickness_scale,
        ],
        "KHR_materials_iridescence" => &[P::specular_level, P::specular_ior],
        "KHR_materials_volume_scatter" => &[P::translucency, P::scatter, P::scatter_color, P::scatter_distance],
        "KHR_materials_diffuse_roughness" => &[P::base_color, P::roughness],
        "KHR_materials_coat" => &[P::coat, P::coat_color, P::coat_roughness, P::coat_ior],
        "KHR_materials_fuzz" => &[P::sheen, P::sheen_color, P::sheen_roughness],
        _ => &[],
    }
}

fn slot_json(slot: &Slot) -> Json {
    json!({ "value": slot.value.map(value_json), "texture": slot.texture.as_ref().map(texture_json) })
}

/// The entry of a material for something that stands beside its properties as they are.
pub(super) fn entry(key: &str, body: &Json, material: &Material) -> String {
    let slots = beside(key).iter().map(|p| (p.def().name.to_owned(), slot_json(material.slot(*p))));
    json!({ "json": body, "beside": slots.collect::<Map<_, _>>() }).to_string()
}

/// What an entry holds.
pub(super) fn body(entry: &str) -> Option<Json> {
    serde_json::from_str::<Json>(entry).ok()?.get("json").cloned()
}

/// All that may be written back: what stands beside properties that have not changed since.
pub(super) fn unchanged(material: &Material) -> BTreeMap<String, Json> {
    let entries = material.foreign.get(MODEL.name).into_iter().flatten();
    let holds = |key: &str, text: &str| {
        let entry = serde_json::from_str::<Json>(text).ok()?;
        let slots = entry.get("beside").and_then(Json::as_object);
        let is_same = |(name, old): (&String, &Json)| {
            Property::from_name(name).is_some_and(|property| slot_json(material.slot(property)) == *old)
        };
        let is_unchanged = slots.into_iter().flatten().all(is_same);
        is_unchanged.then(|| Some((key.to_owned(), entry.get("json")?.clone())))?
    };
    entries.filter_map(|(key, text)| holds(key, text)).collect()
}

/// Takes over what a file says into a material, which has what its native copy kept. What the copy has in the same words stays.
pub(super) fn take(found: &BTreeMap<String, Json>, is_native: bool, material: &mut Material, notes: &mut Notes) {
    let known = material.foreign.get(MODEL.name).cloned().unwrap_or_default();
    for (key, json) in found {
        let is_known = known.get(key).is_some_and(|entry| body(entry).as_ref() == Some(json));
        // Beside a native copy this is what the copy was written as.
        let is_translation = is_native && !known.contains_key(key) && key == ANISOTROPY;
        if !is_known && !is_translation {
            let entry = entry(key, json, material);
            if let Err(error) = material.set_foreign(MODEL.name, key, Some(entry)) {
                notes.push(format!("{}: {error}; not kept", short(key)));
            }
        }
    }
}

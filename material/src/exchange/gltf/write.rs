//! The way out: materials to a document.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Map, Value as Json, json};

use super::document::Written;
use super::draft::{Content, Draft, is_alike};
use super::error::GltfError;
use super::files::{Files, Textures};
use super::images::{Images, list};
use super::json::{at, put};
use super::mesh::Mesh;
use super::restore::Restored;
use super::slots::{self, SLOTS, Slot};
use super::{foreign, numbers, read};
use crate::exchange::model::{Context, Translation};
use crate::exchange::models::gltf::Gltf;
use crate::exchange::native;
use crate::exchange::plan::{Job, Texel};
use crate::material::Material;
use crate::properties::Property;
use crate::slot::TextureRef;

/// A material that is written.
#[derive(Clone, Copy, Debug)]
pub struct Part<'a> {
    /// The material.
    pub material: &'a Material,
    /// What it was translated to: parameters of the shading model `gltf`.
    pub translation: &'a Translation,
    /// What it was translated with.
    pub context: Context,
}

/// How a document is written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Options {
    /// Whether each material carries its native copy, and the document the images of it.
    pub has_native_copy: bool,
    /// What is known of images, by path. More is computed where less is known.
    pub facts: BTreeMap<String, Facts>,
}

impl Default for Options {
    fn default() -> Self {
        Self { has_native_copy: true, facts: BTreeMap::new() }
    }
}

/// What is known of an image; all false where nothing is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Facts {
    /// Red, green and blue are the same everywhere.
    pub is_gray: bool,
    /// It has more than 8 bits per channel, so that [`crate::ColorSpace::Auto`] reads it as linear.
    pub is_wide: bool,
    /// It has no alpha, or alpha is 1 everywhere.
    pub is_opaque: bool,
}

/// Makes a document of materials, and of a mesh that wears each of them, side by side. Without a mesh it holds the materials alone.
///
/// An error tells what is wrong with the mesh; materials are always written.
pub fn write(parts: &[Part], mesh: Option<&Mesh>, options: &Options) -> Result<Written, GltfError> {
    let mut writer = Writer { files: Files::of(parts), textures: Textures::default(), options };
    let materials: Vec<Json> = parts.iter().enumerate().map(|(k, part)| writer.material(k, part)).collect();
    let Writer { mut files, textures, .. } = writer;
    files.keep_needed(options.has_native_copy);

    let mut root = Map::new();
    root.insert("asset".to_owned(), json!({ "version": "2.0", "generator": "Burnish" }));
    let mut blob = Vec::new();
    let mut body = Map::new();
    if let Some(mesh) = mesh {
        mesh.write(parts.len(), &mut body, &mut blob)?;
    }
    textures.write(&files, &mut body);
    if !materials.is_empty() {
        body.insert("materials".to_owned(), Json::Array(materials));
    }
    let (used, required) = extensions(&body);
    for (key, names) in [("extensionsUsed", used), ("extensionsRequired", required)] {
        if !names.is_empty() {
            root.insert(key.to_owned(), json!(names));
        }
    }
    root.extend(body);
    let mut root = Json::Object(root);
    if options.has_native_copy {
        add_copies(&mut root, parts, &files);
    }
    Ok(Written { root, blob, plan: files.plan })
}

/// Native copies, each with what is found in the document for a record of its translation.
fn add_copies(root: &mut Json, parts: &[Part], files: &Files) {
    let images = Images::of(root, None);
    let copies: Vec<Json> = list(root, "materials")
        .iter()
        .zip(parts)
        .enumerate()
        .map(|(k, (json, part))| {
            let fields = read::found(json, k, &images).fields;
            native::write(&files.portable(part.material), Some((Gltf::FIELDS, &fields)))
        })
        .collect();
    for (k, copy) in copies.into_iter().enumerate() {
        let extras = &mut root["materials"][k]["extras"];
        match extras.as_object_mut() {
            Some(extras) => _ = extras.insert("asm".to_owned(), copy),
            // What others left there may be anything; only an object has room for more.
            None => *extras = json!({ "asm": copy }),
        }
    }
}

/// Extensions that a document uses, and those that it cannot be shown without.
fn extensions(body: &Map<String, Json>) -> (BTreeSet<String>, BTreeSet<String>) {
    let (mut used, mut required) = (BTreeSet::new(), BTreeSet::new());
    let mut note = |json: &Json| {
        for name in json.get("extensions").and_then(Json::as_object).into_iter().flat_map(Map::keys) {
            used.insert(name.clone());
            // There is no other way to say these.
            if name.starts_with("KHR_texture_") || name.starts_with("EXT_texture_") {
                required.insert(name.clone());
            }
        }
    };
    let lists = ["materials", "textures"].into_iter().filter_map(|key| body.get(key)?.as_array());
    for json in lists.flatten() {
        note(json);
        SLOTS.iter().filter_map(|slot| at(json, slot.name)).for_each(&mut note);
        let kept = json.get("extensions").and_then(Json::as_object).into_iter().flat_map(Map::values);
        kept.filter_map(Json::as_object).flat_map(Map::values).for_each(&mut note);
    }
    (used, required)
}

struct Writer<'a> {
    files: Files,
    textures: Textures,
    options: &'a Options,
}

impl Writer<'_> {
    fn material(&mut self, index: usize, part: &Part) -> Json {
        let Restored { content, mask, kept } = Restored::of(part);
        let mut draft = Draft::new(part, content, self.options);
        let mut material = Map::new();
        if !part.material.name.is_empty() {
            material.insert("name".to_owned(), json!(part.material.name));
        }
        self.images(index, &mut draft, &mut material);
        numbers::write(&draft, &mut material);
        numbers::complete(&mut material);
        match mask {
            Some(mask) => {
                material.insert("alphaMode".to_owned(), json!("MASK"));
                material.insert("alphaCutoff".to_owned(), mask.get("alphaCutoff").cloned().unwrap_or(json!(0.5)));
            }
            None if draft.is_see_through() => _ = material.insert("alphaMode".to_owned(), json!("BLEND")),
            None => {}
        }
        if part.material.is_textured(Property::absorption_color) && draft.float(slots::ATTENUATION) > 0.0 {
            let name = &part.material.name;
            self.files.plan.notes.push(format!("{name}: absorption_color: takes no image in glTF; its uniform value is written"));
        }
        for (key, mut body) in kept {
            foreign::number_images(&mut body, &mut |path, wrap| self.textures.number(self.files.used(path), wrap));
            if ["doubleSided", "extras"].contains(&key.as_str()) {
                material.insert(key, body);
            } else if body.is_null() {
                // What is kept is that there was nothing.
            } else if let Some(all) = material.entry("extensions").or_insert_with(|| json!({})).as_object_mut() {
                all.insert(key, body);
            }
        }
        Json::Object(material)
    }

    /// Puts the images of a material in their places. Those to be computed become one where their channels and places allow.
    fn images(&mut self, index: usize, draft: &mut Draft, material: &mut Map<String, Json>) {
        let mut shared: Vec<(&'static Slot, usize, Job, TextureRef)> = Vec::new();
        let mut group_of = Vec::new();
        for (slot, content) in &draft.images {
            let Content::Job(job, lies) = content else {
                group_of.push(None);
                continue;
            };
            let fitting =
                shared.iter().position(|(other, _, with, there)| other.group == slot.group && fit(job, lies, with, there));
            let place = fitting.unwrap_or(shared.len());
            match shared.get_mut(place) {
                Some((_, count, with, there)) => {
                    *count += 1;
                    if with.from.is_empty() {
                        *there = lies.clone();
                    }
                    join(with, job);
                }
                None => shared.push((slot, 1, job.clone(), lies.clone())),
            }
            group_of.push(Some(place));
        }
        let name = &draft.part.material.name;
        let files: Vec<String> = shared
            .iter_mut()
            .map(|(slot, count, job, _)| {
                let file = self.files.fresh(name, if *count > 1 { slot.group } else { slot.suffix });
                if !job.is_in_place {
                    let note = "made of images that lie in different ways on the surface; it covers uv from 0 to 1 alone";
                    self.files.plan.notes.push(format!("{file}: {note}"));
                }
                (job.file, job.material) = (file.clone(), index);
                self.files.plan.jobs.push(job.clone());
                file
            })
            .collect();
        for ((slot, content), group) in draft.images.iter().zip(group_of) {
            let (file, lies) = match (content, group) {
                (Content::Image(texture), _) => (self.files.used(&texture.path), texture),
                (Content::Job(..), Some(group)) => (files[group].clone(), &shared[group].3),
                (Content::Job(..), None) => continue,
            };
            let number = self.textures.number(file, lies.wrap);
            put(material, &format!("{}.index", slot.name), json!(number));
            if let Some(transform) = transform(lies) {
                put(material, &format!("{}.extensions.KHR_texture_transform", slot.name), transform);
            }
            if let (Content::Image(texture), slots::OCCLUSION) = (content, slot.name)
                && texture.scale[0] != 1.0
            {
                put(material, "occlusionTexture.strength", json!(texture.scale[0]));
            }
        }
    }
}

fn uses_colors(job: &Job) -> bool {
    job.channels[..3].iter().any(|channel| *channel != Texel::ONE)
}

/// Whether two images can be one: no channel in both, one curve, one place on the surface.
fn fit(a: &Job, a_lies: &TextureRef, b: &Job, b_lies: &TextureRef) -> bool {
    let is_free = a.channels.iter().zip(&b.channels).all(|(a, b)| *a == Texel::ONE || *b == Texel::ONE);
    let is_one_curve = a.is_srgb == b.is_srgb || !uses_colors(a) || !uses_colors(b);
    let is_one_place = a.is_in_place == b.is_in_place && is_alike(a_lies, b_lies);
    is_free && is_one_curve && (is_one_place || a.from.is_empty() || b.from.is_empty())
}

/// Puts the channels of `other` into an image.
fn join(job: &mut Job, other: &Job) {
    if !uses_colors(job) {
        job.is_srgb = other.is_srgb;
    }
    job.is_in_place &= other.is_in_place;
    for (channel, other) in job.channels.iter_mut().zip(other.channels) {
        if *channel == Texel::ONE {
            *channel = other;
        }
    }
    for property in &other.from {
        if !job.from.contains(property) {
            job.from.push(*property);
        }
    }
}

/// `KHR_texture_transform`, where an image does not lie as it is. Origin and order of steps are the same there and here.
fn transform(texture: &TextureRef) -> Option<Json> {
    let mut transform = Map::new();
    let TextureRef { uv_scale, uv_offset, uv_rotation, .. } = texture;
    let is_finite = [uv_scale.as_slice(), uv_offset, &[*uv_rotation]].concat().iter().all(|x| x.is_finite());
    let mut add = |key: &str, is_default: bool, value: Json| {
        if !is_default {
            transform.insert(key.to_owned(), value);
        }
    };
    add("offset", *uv_offset == [0.0; 2], json!(uv_offset));
    add("rotation", *uv_rotation == 0.0, json!(uv_rotation.to_radians()));
    add("scale", *uv_scale == [1.0; 2], json!(uv_scale));
    (is_finite && !transform.is_empty()).then_some(Json::Object(transform))
}

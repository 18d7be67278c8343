//! The images of a document on the way in: what they are called here, where their bytes are, and how textures use them.

use std::collections::BTreeSet;
use std::collections::btree_map::{BTreeMap, Entry};
use std::f64::consts::TAU;
use std::ops::Range;

use serde_json::Value as Json;

use super::error::Wrong;
use super::uri;
use crate::slot::{TextureRef, Wrap};

/// Most bytes of images and buffers inside of documents that are copied out, together.
pub const MAX_EMBEDDED_BYTES: usize = 512 << 20;

/// An image that a document refers to or holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// What textures of the materials call it: a relative path with `/`, none of it outside of the document's folder.
    pub path: String,
    /// Where its bytes are.
    pub source: Source,
}

/// Where the bytes of an image are.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// In the file that `path` names, in the document's folder.
    File,
    /// In the document: a whole file of PNG, JPEG, WebP or KTX.
    Bytes(Vec<u8>),
    /// In a part of another file in the document's folder.
    Part {
        /// Its relative path.
        file: String,
        /// The bytes of the image; the file may be shorter.
        range: Range<usize>,
    },
}

/// Images and textures of a document, each with why it cannot be used where that is so.
pub(super) struct Images {
    pub all: Vec<Result<Image, String>>,
    textures: Vec<Result<TextureRef, String>>,
}

impl Images {
    /// Looks at a document. `blob` is the block of bytes of a binary file.
    pub fn of(root: &Json, blob: Option<&[u8]>) -> Self {
        let mut reader = Reader { root, blob, left: MAX_EMBEDDED_BYTES, taken: BTreeSet::new(), buffers: BTreeMap::new() };
        let images = list(root, "images").iter().enumerate();
        let all: Vec<_> = images.map(|(k, image)| reader.image(k, image).map_err(|e| format!("/images/{k}: {e}"))).collect();
        let textures = list(root, "textures").iter().enumerate();
        let textures = textures.map(|(k, texture)| self::texture(root, &all, texture).map_err(|e| format!("/textures/{k}: {e}")));
        Self { textures: textures.collect(), all }
    }

    /// The image that a place in a material (a `textureInfo`) uses, in full; an error is a sentence about what was expected and found.
    pub fn used(&self, info: &Json, at: &str, notes: &mut Vec<String>) -> Result<TextureRef, String> {
        let index = info.get("index").and_then(Json::as_u64).and_then(|index| usize::try_from(index).ok());
        let Some(found) = index.and_then(|index| self.textures.get(index)) else {
            let expected = format!("a number below {}, the number of textures", self.textures.len());
            return Err(Wrong::value(format!("{at}/index"), expected, info.get("index")).to_string());
        };
        let mut texture = found.clone().map_err(|problem| format!("{at}: the image is not used: {problem}"))?;
        let transform = info.pointer("/extensions/KHR_texture_transform");
        let numbers = |key: &str, default: [f64; 2], notes: &mut Vec<String>| {
            let Some(json) = transform.and_then(|t| t.get(key)) else { return default };
            let list = json.as_array().filter(|list| list.len() == 2);
            let pair = list.and_then(|list| Some([list[0].as_f64()?, list[1].as_f64()?]));
            pair.unwrap_or_else(|| {
                notes.push(Wrong::value(format!("{at}: {key}"), "two numbers", Some(json)).to_string());
                default
            })
        };
        // Both measure from the upper left corner, scale first, then turn counterclockwise, then shift.
        (texture.uv_scale, texture.uv_offset) = (numbers("scale", [1.0; 2], notes), numbers("offset", [0.0; 2], notes));
        texture.uv_rotation = transform.and_then(|t| t.get("rotation")).and_then(Json::as_f64).unwrap_or(0.0) * 360.0 / TAU;
        let set = transform.and_then(|t| t.get("texCoord")).or_else(|| info.get("texCoord")).and_then(Json::as_u64);
        if let Some(set) = set.filter(|set| *set != 0) {
            notes.push(format!("{at}: uses the texture coordinates of set {set}; ASM knows set 0 alone, which is used instead"));
        }
        Ok(texture)
    }

    /// The images that can be had.
    pub fn into_found(self) -> Vec<Image> {
        self.all.into_iter().flatten().collect()
    }
}

/// A list of the document; empty where it has none.
pub(super) fn list<'a>(root: &'a Json, key: &str) -> &'a [Json] {
    root.get(key).and_then(Json::as_array).map_or(&[], Vec::as_slice)
}

fn texture(root: &Json, images: &[Result<Image, String>], texture: &Json) -> Result<TextureRef, String> {
    let extended = |name: &str| texture.get("extensions")?.get(name)?.get("source");
    let source = texture.get("source").or_else(|| extended("EXT_texture_webp")).or_else(|| extended("KHR_texture_basisu"));
    if source.is_none() {
        return Err("expected a source, found none".to_owned());
    }
    let index = source.and_then(Json::as_u64).and_then(|index| usize::try_from(index).ok());
    let Some(image) = index.and_then(|index| images.get(index)) else {
        let expected = format!("a number below {}, the number of images", images.len());
        return Err(Wrong::value("source", expected, source).to_string());
    };
    let mut reference = TextureRef::new(image.as_ref().map_err(Clone::clone)?.path.clone());
    let sampler = texture.get("sampler").and_then(Json::as_u64).and_then(|index| usize::try_from(index).ok());
    let sampler = sampler.and_then(|index| list(root, "samplers").get(index));
    // An image has one mode here; where the axes differ, the horizontal one holds.
    reference.wrap = match sampler.and_then(|s| s.get("wrapS").or_else(|| s.get("wrapT"))).and_then(Json::as_u64) {
        Some(33071) => Wrap::Clamp,
        Some(33648) => Wrap::Mirror,
        _ => Wrap::Repeat,
    };
    Ok(reference)
}

fn too_many() -> String {
    format!("expected at most {MAX_EMBEDDED_BYTES} bytes of images in a document, found more")
}

struct Reader<'a> {
    root: &'a Json,
    blob: Option<&'a [u8]>,
    /// Bytes that may still be copied out.
    left: usize,
    /// Paths in use, in lower case.
    taken: BTreeSet<String>,
    /// Buffers in data URIs, by number: decoded once, however many images lie in one.
    buffers: BTreeMap<usize, Vec<u8>>,
}

impl Reader<'_> {
    fn image(&mut self, index: usize, image: &Json) -> Result<Image, String> {
        let kind = image.get("mimeType").and_then(Json::as_str).unwrap_or_default();
        match (image.get("uri").and_then(Json::as_str), image.get("bufferView")) {
            (Some(text), _) if text.starts_with("data:") => {
                let bytes = uri::read_data(text, self.left)?;
                self.left = self.left.checked_sub(bytes.len()).ok_or_else(too_many)?;
                let kind = text["data:".len()..].split([';', ',']).next().unwrap_or(kind);
                Ok(Image { path: self.name(index, image, kind), source: Source::Bytes(bytes) })
            }
            (Some(text), _) => {
                let path = uri::read(text)?;
                self.taken.insert(path.to_lowercase());
                Ok(Image { path, source: Source::File })
            }
            (None, Some(view)) => {
                let source = self.view(view)?;
                Ok(Image { path: self.name(index, image, kind), source })
            }
            (None, None) => Err("expected a uri or a bufferView, found neither".to_owned()),
        }
    }

    /// A path for an image inside of the document: its name where that is one, else one made of it.
    fn name(&mut self, index: usize, image: &Json, kind: &str) -> String {
        let end = match kind {
            "image/jpeg" => "jpg",
            "image/webp" => "webp",
            "image/ktx2" => "ktx2",
            _ => "png",
        };
        let name = image.get("name").and_then(Json::as_str).unwrap_or_default();
        let is_path = ["png", "jpg", "jpeg", "webp", "ktx2"].contains(&uri::extension(name).as_str());
        let stem = if name.is_empty() { format!("image_{index}") } else { uri::file_word(name) };
        let path = uri::safe(name).filter(|_| is_path).unwrap_or_else(|| format!("{stem}.{end}"));
        let is_free = self.taken.insert(path.to_lowercase());
        // The number of the image makes it another one.
        if is_free { path } else { format!("image_{index}/{path}") }
    }

    fn view(&mut self, view: &Json) -> Result<Source, String> {
        let number = |json: &Json, key: &str| json.get(key).and_then(Json::as_u64).and_then(|n| usize::try_from(n).ok());
        let index = view.as_u64().and_then(|n| usize::try_from(n).ok());
        let views = list(self.root, "bufferViews");
        let wrong = |what: &str, found: Option<&Json>| Wrong::value("bufferView", what, found).to_string();
        let found = index.and_then(|index| views.get(index)).ok_or_else(|| wrong("the number of a bufferView", Some(view)))?;
        let length = number(found, "byteLength").ok_or_else(|| wrong("a byteLength", found.get("byteLength")))?;
        let start = number(found, "byteOffset").unwrap_or(0);
        let range = start..start.saturating_add(length);
        let buffer = number(found, "buffer").and_then(|k| Some((k, list(self.root, "buffers").get(k)?)));
        let (k, buffer) = buffer.ok_or_else(|| wrong("the number of a buffer", found.get("buffer")))?;
        let bytes = match (buffer.get("uri").and_then(Json::as_str), self.blob) {
            (Some(text), _) if text.starts_with("data:") => match self.buffers.entry(k) {
                Entry::Occupied(entry) => entry.into_mut(),
                Entry::Vacant(entry) => entry.insert(uri::read_data(text, MAX_EMBEDDED_BYTES)?),
            },
            (Some(text), _) => return Ok(Source::Part { file: uri::read(text)?, range }),
            (None, Some(blob)) => blob,
            (None, None) => return Err("buffer: expected a uri, found none, and no binary file around it".to_owned()),
        };
        let part = bytes.get(range.clone());
        let part = part.ok_or_else(|| format!("bufferView: expected bytes {start} to {}, found {}", range.end, bytes.len()))?;
        self.left = self.left.checked_sub(part.len()).ok_or_else(too_many)?;
        Ok(Source::Bytes(part.to_vec()))
    }
}

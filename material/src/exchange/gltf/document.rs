//! A document that was written, as text or as a binary file.

use serde_json::{Value as Json, json};

use super::container;
use super::error::{GltfError, Wrong};
use super::images::list;
use super::plan::Plan;
use super::uri;

/// A document, complete but for its images.
#[derive(Clone, Debug, PartialEq)]
pub struct Written {
    pub(super) root: Json,
    pub(super) blob: Vec<u8>,
    /// The images that it needs.
    pub plan: Plan,
}

impl Written {
    /// The text of a `.gltf` file. The mesh is in [`Self::buffer`], to be written beside it under `buffer_name`.
    pub fn gltf(&self, buffer_name: &str) -> String {
        let mut root = self.root.clone();
        if !self.blob.is_empty() {
            root["buffers"] = json!([{ "uri": uri::write(buffer_name), "byteLength": self.blob.len() }]);
        }
        let mut text = serde_json::to_string_pretty(&root).unwrap_or_default();
        text.push('\n');
        text
    }

    /// The bytes of the mesh; empty without one.
    pub fn buffer(&self) -> &[u8] {
        &self.blob
    }

    /// The bytes of a `.glb` file with the images whose bytes `bytes_of` has by the names of [`Plan`]: files of PNG, JPEG, WebP or KTX 2.
    /// Others stay beside it.
    pub fn glb(&self, mut bytes_of: impl FnMut(&str) -> Option<Vec<u8>>) -> Result<Vec<u8>, GltfError> {
        let (mut root, mut blob) = (self.root.clone(), self.blob.clone());
        let mut views = list(&root, "bufferViews").to_vec();
        let mut images = list(&root, "images").to_vec();
        for image in &mut images {
            let Some(file) = image.get("uri").and_then(Json::as_str).and_then(|text| uri::read(text).ok()) else { continue };
            let Some(bytes) = bytes_of(&file) else { continue };
            let Some(kind) = kind_of(&bytes) else {
                return Err(GltfError::NotBinary(Wrong::new(file, "a file of PNG, JPEG, WebP or KTX 2", "another")));
            };
            blob.resize(blob.len().next_multiple_of(4), 0);
            views.push(json!({ "buffer": 0, "byteOffset": blob.len(), "byteLength": bytes.len() }));
            blob.extend(bytes);
            *image = json!({ "name": file, "mimeType": kind, "bufferView": views.len() - 1 });
        }
        for (key, list) in [("images", images), ("bufferViews", views)] {
            if !list.is_empty() {
                root[key] = Json::Array(list);
            }
        }
        if !blob.is_empty() {
            root["buffers"] = json!([{ "byteLength": blob.len() }]);
        }
        let size = blob.len();
        container::join(&root.to_string(), &blob)
            .ok_or_else(|| GltfError::NotBinary(Wrong::new("file", "at most 4 GB", format!("{size} bytes of images and meshes"))))
    }
}

/// The media type of an image file, by its first bytes.
fn kind_of(bytes: &[u8]) -> Option<&'static str> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => Some("image/png"),
        [0xff, 0xd8, 0xff, ..] => Some("image/jpeg"),
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Some("image/webp"),
        [0xab, b'K', b'T', b'X', b' ', b'2', b'0', ..] => Some("image/ktx2"),
        _ => None,
    }
}

//! The list of everything in a pack, with a hash for each file.

use super::super::entry::Entry;
use super::super::sheet::slashed;
use super::content::Content;
use super::formats::Written;
use super::{MATERIALS, PackError, place};
use crate::digest::Digest;
use crate::files::FilesError;
use crate::picture_job::PROGRAM;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::Arc;

/// Name of the file.
pub const MANIFEST: &str = "manifest.json";
/// What it says of itself.
pub const FORMAT: &str = "burnish-pack/1";
/// How its hashes are made.
const HASH: &str =
    "SipHash-2-4, 128 bits, key of zeros, of 8 (as 8 bytes, little-endian), the file's size (the same) and its bytes";

/// The list of what is in a folder now, and how many files those are.
pub(super) fn text(
    name: &str,
    folder: &Path,
    content: &Content<'_>,
    packed: &[Arc<Entry>],
    written: &[Written],
) -> Result<(String, usize), PackError> {
    let unreadable = |source| FilesError::Read { path: folder.to_path_buf(), source };
    let mut files = Vec::new();
    for path in place::files(folder).map_err(unreadable)? {
        let hash = Digest::of_file(&path, &|| true).map_err(unreadable)?;
        let bytes = fs::metadata(&path).map_err(unreadable)?.len();
        files.push(json!({ "path": slashed(path.strip_prefix(folder).unwrap_or(&path)), "bytes": bytes, "hash": hash }));
    }
    let looks: BTreeMap<&Path, Digest> = packed.iter().map(|entry| (entry.path.as_path(), entry.look)).collect();
    let materials = content.materials.iter().zip(written).map(|(one, written)| {
        let (entry, provenance) = (one.entry, &one.file.material().provenance);
        json!({
            "path": format!("{MATERIALS}/{}", slashed(&entry.path)),
            "name": entry.name,
            "group": entry.group(),
            "tags": entry.tags,
            "licence": provenance.licence,
            "source": provenance.source,
            "look": looks.get(entry.path.as_path()),
            "images": one.images.iter().map(|image| format!("{MATERIALS}/{image}")).collect::<Vec<_>>(),
            "formats": written,
        })
    });
    let materials: Vec<Value> = materials.collect();
    let left_out = content.left_out.iter().map(|(entry, problem)| json!({ "path": slashed(&entry.path), "problem": problem }));
    let left_out: Vec<Value> = left_out.collect();
    let count = files.len();
    let object = json!({
        "format": FORMAT,
        "program": PROGRAM,
        "name": name,
        "hash": HASH,
        "files": files,
        "materials": materials,
        "left_out": left_out,
    });
    Ok((format!("{object:#}\n"), count))
}

/// Hashes by path; `None` if the text is none of ours.
pub(super) fn hashes(text: &str) -> Option<BTreeMap<String, Digest>> {
    let object: Value = serde_json::from_str(text).ok()?;
    let is_ours = object["format"] == FORMAT;
    let row = |row: &Value| Some((row["path"].as_str()?.to_owned(), Digest::parse(row["hash"].as_str()?)?));
    object["files"].as_array().filter(|_| is_ours)?.iter().map(row).collect()
}

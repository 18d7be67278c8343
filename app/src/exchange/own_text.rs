//! The text of a material file on its way through other formats: comments, unknown keys and spelling, which no value holds.

use burnish_material::{Material, MaterialFile};

/// Where the native copy of every format keeps the text.
const FORMAT: &str = "burnish";
const KEY: &str = "file";

/// Lets the native copy take along the text that `file` has for this material; nothing where the text says no more than the values, or more
/// than a native copy holds.
pub(super) fn put(material: &mut Material, file: &MaterialFile) {
    let text = file.to_text(material);
    if text != MaterialFile::new(material).to_text(material) {
        let json = serde_json::Value::from(text).to_string();
        // Too long a text stays behind; the values do not.
        _ = material.set_foreign(FORMAT, KEY, Some(json));
    }
}

/// The file of a material that came from another format, with the text that was taken along.
pub(super) fn take(mut material: Material) -> MaterialFile {
    let text = material.foreign_text(FORMAT, KEY).and_then(|json| serde_json::from_str::<String>(json).ok());
    // It cannot fail: there is nothing to add.
    _ = material.set_foreign(FORMAT, KEY, None);
    let carried = text.and_then(|text| MaterialFile::parse(&text).ok()).map(|(file, _)| file.to_text(&material));
    match carried.and_then(|text| MaterialFile::parse(&text).ok()) {
        Some((file, _)) if *file.material() == material => file,
        _ => MaterialFile::new(&material),
    }
}

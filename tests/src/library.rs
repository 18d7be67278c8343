//! Folders of made-up materials, the same for the same number.

use burnish_material::{Material, MaterialFile, Property, TextureRef, Value};
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Kinds of made-up materials: the folder, a tag, metallic.
const KINDS: [(&str, &str, f64); 5] = [
    ("metals", "measured", 1.0),
    ("metals/worn", "by eye", 1.0),
    ("plastics", "injection moulded", 0.0),
    ("glass", "measured", 0.0),
    ("fabrics/wool", "woven", 0.0),
];

/// The material of this number.
pub fn material(number: usize) -> Material {
    let (group, tag, metallic) = KINDS[number % KINDS.len()];
    let share = |prime: usize| (number * prime % 1000) as f64 / 1000.0;
    let mut material = Material::named(format!("Sample {number} of {group}"));
    material.tags = vec![tag.to_owned(), format!("batch {}", number / 100)];
    material.notes =
        format!("Made up for tests; number {number}. {}", "Values follow from the number alone. ".repeat(number % 8));
    material.provenance.licence = if number.is_multiple_of(3) { "CC0-1.0".to_owned() } else { "MIT".to_owned() };
    material.set(Property::metallic, Value::Float(metallic));
    material.set(Property::roughness, Value::Float(share(7)));
    material.set(Property::base_color, Value::Color([share(11), share(13), share(17)]));
    if group == "glass" {
        material.set(Property::translucency, Value::Float(1.0)).set(Property::specular_ior, Value::Float(1.3 + share(19)));
    }
    if number.is_multiple_of(7) {
        material.set(Property::coat, Value::Float(share(23)));
    }
    if number.is_multiple_of(50) {
        material.slot_mut(Property::roughness).texture = Some(TextureRef::new(format!("maps/{}.png", number % 4)));
    }
    material
}

/// Where the material of this number lies in a folder of them.
pub fn path(number: usize) -> PathBuf {
    PathBuf::from(KINDS[number % KINDS.len()].0).join(format!("sample-{number:05}.asm.ron"))
}

/// Writes this many materials into a folder, as if some hours ago: what was written just now is read again to be safe.
pub fn write(folder: &Path, count: usize) -> io::Result<()> {
    for (group, ..) in KINDS {
        fs::create_dir_all(folder.join(group))?;
    }
    for number in 0..count {
        write_old(&folder.join(path(number)), MaterialFile::new(&material(number)).text().as_bytes(), 10_000)?;
    }
    Ok(())
}

/// Writes a file as if some seconds ago.
pub fn write_old(path: &Path, bytes: &[u8], seconds: u64) -> io::Result<()> {
    fs::write(path, bytes)?;
    File::options().write(true).open(path)?.set_modified(SystemTime::now() - Duration::from_secs(seconds))
}

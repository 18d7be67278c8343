//! What a library knows of one material file without opening it again.

use super::walk::{Found, Stamp};
use crate::digest::{Digest, Digesting};
use crate::files::{self, FilesError};
use burnish_material::{LOBES, Lobe, LobeSet, MAX_FILE_BYTES, Material, MaterialFile, PROPERTIES, Property, TextureRef, Value};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Characters of notes that are kept.
const NOTES: usize = 200;

/// One material file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// Relative to the library's folder.
    pub path: PathBuf,
    /// Size and time of the file when it was read.
    pub stamp: Stamp,
    /// Name of the material; that of the file where it has none.
    pub name: String,
    /// Other names.
    pub aliases: Vec<String>,
    /// Free words.
    pub tags: Vec<String>,
    /// The first 200 characters of the notes.
    pub notes: String,
    /// Licence of the data; empty if the file does not tell.
    pub licence: String,
    /// Images that the material names, each once, as it names them.
    pub textures: Vec<String>,
    /// Why it cannot be used, as a sentence without the path.
    pub problem: Option<String>,
    /// Hash of the file's bytes.
    pub bytes: Digest,
    /// Hash of what can be seen: values and how textures are read, but not name, tags and notes.
    values_hash: Digest,
    /// The last [`Entry::look`] of this path before this one of which there was a small picture.
    pub previous: Option<Digest>,
    /// Values that differ from the default, by row in the table of properties. Of colours the luminance.
    values: Vec<(u8, f32)>,
    /// Properties with a texture, as bits.
    textured: u64,
    /// Lobes in use, as bits by row in the table of lobes.
    lobes: u32,
    /// Hash of the file's bytes and of the images it names.
    #[serde(skip)]
    pub content: Digest,
    /// Hash of what can be seen: [`Entry::content`] without name, tags, notes and spelling. Names the small picture.
    #[serde(skip)]
    pub look: Digest,
    /// Names, tags, group, notes and lobes in lower case, for searching.
    #[serde(skip)]
    pub(super) words: String,
}

impl Entry {
    /// Reads the file `root/found.path`. What is wrong with it is kept in [`Entry::problem`]; files larger than a material can be are not read.
    pub fn read(root: &Path, found: &Found) -> Self {
        let stamp = found.stamp.settled();
        let path = root.join(&found.path);
        let entry = match files::read_text_file(&path, MAX_FILE_BYTES as u64) {
            Ok(text) => Self { stamp, ..Self::of_text(&found.path, &text) },
            Err(error) => {
                // Permission may come, or a network, without a new stamp.
                let is_final = !matches!(error, FilesError::Read { .. });
                let stamp = Stamp { modified: stamp.modified.filter(|_| is_final), ..stamp };
                Self { stamp, ..Self::unusable(&found.path, reason(&error, &path)) }
            }
        };
        entry.completed()
    }

    /// What is named like a material file and cannot be used as one.
    pub fn unusable(path: &Path, problem: String) -> Self {
        Self { path: path.to_path_buf(), name: stem(path), problem: Some(problem), ..Self::default() }.completed()
    }

    fn of_text(path: &Path, text: &str) -> Self {
        let bytes = Digest::of(text.as_bytes());
        let (file, warnings) = match MaterialFile::parse(text) {
            Ok(read) => read,
            Err(error) => return Self { bytes, ..Self::unusable(path, error.to_string()) },
        };
        let material = file.material();
        let name = if material.name.trim().is_empty() { stem(path) } else { material.name.clone() };
        let lobes = LobeSet::of(material);
        let mut entry = Self {
            path: path.to_path_buf(),
            name,
            aliases: material.aliases.clone(),
            tags: material.tags.clone(),
            notes: material.notes.chars().take(NOTES).collect(),
            licence: material.provenance.licence.clone(),
            problem: warnings.iter().find(|warning| warning.is_refused).map(ToString::to_string),
            bytes,
            lobes: LOBES.iter().filter(|def| lobes.has(def.lobe)).fold(0, |bits, def| bits | 1 << def.lobe as u32),
            ..Self::default()
        };
        for (property, slot) in material.slots() {
            if let Some(texture) = &slot.texture {
                entry.textured |= 1 << property as u64;
                if !texture.path.is_empty() && !entry.textures.contains(&texture.path) {
                    entry.textures.push(texture.path.clone());
                }
            }
            let (value, default) = (number(material.value(property)), number(property.def().default));
            if let Some(value) = value.filter(|value| Some(*value) != default) {
                entry.values.push((property as u8, value));
            }
        }
        entry.values_hash = values_hash(material, &entry.textures);
        entry
    }

    /// Fills in what is not kept on disk, but for the hashes of images.
    pub(super) fn completed(mut self) -> Self {
        let texts = [&self.name, &self.aliases.join("\n"), &self.tags.join(" "), &self.group(), &self.notes];
        let mut words = texts.map(|text| text.to_lowercase()).join("\n");
        for name in self.lobes().names(true) {
            words += "\n";
            words += name;
        }
        self.words = words;
        self.tags.shrink_to_fit();
        self
    }

    /// Sets the hashes that depend on images; one hash per image in the order of [`Entry::textures`], `None` where there is none.
    pub(super) fn set_images(&mut self, images: &[Option<Digest>]) {
        let with_images = |first: Digest| {
            let mut all = Digesting::default();
            all.digest(first);
            for image in images {
                all.digest(image.unwrap_or_default());
            }
            all.end()
        };
        self.content = with_images(self.bytes);
        self.look = with_images(self.values_hash);
    }

    /// The folder it lies in, relative to the library's, with `/`; empty at the top.
    pub fn group(&self) -> String {
        let folder = self.path.parent().unwrap_or(Path::new("")).to_string_lossy();
        if std::path::MAIN_SEPARATOR == '/' { folder.into_owned() } else { folder.replace(std::path::MAIN_SEPARATOR, "/") }
    }

    /// The value of a property, of colours the luminance, of switches 0 or 1. `None` for directions, for what a texture replaces, and for
    /// files that cannot be used.
    pub fn value(&self, property: Property) -> Option<f32> {
        if self.problem.is_some() || self.is_textured(property) {
            return None;
        }
        let given = self.values.iter().find(|(row, _)| usize::from(*row) == property as usize);
        given.map(|(_, value)| *value).or_else(|| number(property.def().default))
    }

    /// Whether a property has a texture.
    pub fn is_textured(&self, property: Property) -> bool {
        self.textured & (1 << property as u64) != 0
    }

    /// Lobes in use; none of a file that cannot be used.
    pub fn lobes(&self) -> LobeSet {
        let is_in = |lobe: Lobe| self.lobes & (1 << lobe as u32) != 0;
        LOBES.iter().filter(|def| is_in(def.lobe)).fold(LobeSet::EMPTY, |set, def| set.with(def.lobe))
    }

    /// Bytes of memory that this takes, about.
    pub fn memory_bytes(&self) -> usize {
        let texts = [&self.name, &self.notes, &self.licence, &self.words];
        let lists = self
            .aliases
            .iter()
            .chain(&self.tags)
            .chain(&self.textures)
            .map(|text| size_of::<String>() + text.capacity())
            .sum::<usize>();
        let values = self.values.capacity() * size_of::<(u8, f32)>();
        size_of::<Self>() + self.path.as_os_str().len() + texts.iter().map(|text| text.capacity()).sum::<usize>() + lists + values
    }
}

/// The reason in an error about a file, without the file.
pub(super) fn reason(error: &FilesError, path: &Path) -> String {
    let text = error.to_string();
    text.strip_prefix(&format!("{}: ", path.display())).map(str::to_owned).unwrap_or(text)
}

/// The name of a file without `.asm.ron`.
pub(super) fn stem(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let (stem, ending) = name.split_at_checked(name.len().saturating_sub(".asm.ron".len())).unwrap_or((&name, ""));
    if ending.eq_ignore_ascii_case(".asm.ron") { stem.to_owned() } else { name.into_owned() }
}

/// The number that a value is compared by.
fn number(value: Value) -> Option<f32> {
    let number = match value {
        Value::Float(x) => x,
        Value::Bool(is_on) => f64::from(u8::from(is_on)),
        Value::Color([r, g, b]) => 0.2126 * r + 0.7152 * g + 0.0722 * b,
        Value::Normal(_) => return None,
    };
    Some(number.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32)
}

/// Hash of everything about a material that can be seen, but for the pixels of its images. Those count by their place in `textures`, so that
/// moving them changes nothing.
pub(super) fn values_hash(material: &Material, textures: &[String]) -> Digest {
    let mut all = Digesting::default();
    all.numbers(&[material.unit_mm()]);
    for (def, (property, slot)) in PROPERTIES.iter().zip(material.slots()) {
        let value = material.value(property);
        all.text(def.name).numbers(value.numbers()).whole(&[u64::from(value == Value::Bool(true))]);
        if let Some(TextureRef { path, channel, color_space, is_inverted, scale, bias, wrap, uv_scale, uv_offset, uv_rotation }) =
            &slot.texture
        {
            let place = textures.iter().position(|known| known == path);
            all.whole(&[place.map_or(0, |place| place as u64 + 1), u64::from(*is_inverted)])
                .text(channel.word())
                .text(color_space.word())
                .text(wrap.word());
            all.numbers(uv_scale).numbers(uv_offset).numbers(&[*uv_rotation]);
            // Left out at their defaults, so that small pictures made before there were scales keep their names.
            if (*scale, *bias) != ([1.0; 3], [0.0; 3]) {
                all.text("scale").numbers(scale).numbers(bias);
            }
        }
    }
    all.end()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(text: &str) -> Entry {
        let mut entry = Entry::of_text(Path::new("metals/plain.asm.ron"), text).completed();
        let images = vec![None; entry.textures.len()];
        entry.set_images(&images);
        entry
    }

    #[test]
    fn what_cannot_be_seen_leaves_the_look_alone() {
        let plain = entry(r#"{"asm": "4.0", "properties": {"roughness": 0.2}}"#);
        let tagged =
            entry("// Note.\n{\"asm\": \"4.0\", \"name\": \"Other\", \"tags\": [\"a\"], \"properties\": {\"roughness\": 0.20}}");
        assert_eq!(plain.look, tagged.look);
        assert_ne!(plain.content, tagged.content);
        for other in [
            r#"{"properties": {"roughness": 0.21}}"#,
            r#"{"unit_mm": 1.0, "properties": {"roughness": 0.2}}"#,
            r#"{"properties": {"roughness": {"value": 0.2, "texture": {"path": "a.png"}}}}"#,
        ] {
            assert_ne!(entry(other).look, plain.look, "{other}");
        }
        let mut painted = entry(r#"{"properties": {"roughness": {"texture": {"path": "a.png"}}}}"#);
        let before = painted.look;
        assert_eq!(painted.textures, ["a.png"], "{:?}", painted.problem);
        painted.set_images(&[Some(Digest::of(b"pixels"))]);
        assert_ne!(painted.look, before);
    }

    #[test]
    fn scales_of_textures_are_seen_where_they_are_not_the_default() {
        let look = |settings: &str| {
            let entry = entry(&format!(r#"{{"properties": {{"roughness": {{"texture": {{"path": "a.png"{settings}}}}}}}}}"#));
            assert_eq!(entry.problem, None);
            entry.look
        };
        // The name that small pictures of this texture had before there were scales.
        assert_eq!(look("").to_string(), "484fa7bee257943252acdc4f5674bf61");
        assert_eq!(look(r#", "scale": 1.0, "bias": (0.0, 0.0, -0.0)"#), look(""));
        let looks = [look(""), look(r#", "scale": 0.5"#), look(r#", "bias": 0.5"#), look(r#", "scale": (1.0, 0.5, 1.0)"#)];
        assert!((1..looks.len()).all(|k| !looks[..k].contains(&looks[k])), "{looks:?}");
    }

    #[test]
    fn values_are_those_of_the_file_or_defaults() {
        let entry = entry(
            r#"{"properties": {"roughness": 0.2, "base_color": (1.0, 0.0, 0.0), "scatter": true, "coat": {"texture": {"path": "c.png"}}}}"#,
        );
        assert_eq!(entry.problem, None);
        assert_eq!((entry.name.as_str(), entry.group().as_str()), ("plain", "metals"));
        for (property, expected) in [
            (Property::roughness, Some(0.2)),
            (Property::base_color, Some(0.2126)),
            (Property::scatter, Some(1.0)),
            (Property::metallic, Some(0.0)),
            (Property::coat, None),
            (Property::normal, None),
        ] {
            assert_eq!(entry.value(property), expected, "{property:?}");
        }
        assert!(entry.lobes().has(Lobe::coat) && !entry.lobes().has(Lobe::metal) && entry.is_textured(Property::coat));
    }
}

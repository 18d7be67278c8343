//! The built-in library of real-world materials: data, not code.
//!
//! Every preset is one file `data/<group>/<name>.asm.ron` with its sources inside; the build embeds them all. This
//! crate lists, finds and parses them. It does not render, and it never changes a value: what was measured stays as
//! measured, and what was set by eye says so in the file. [`measured`] compares values with those of real materials.

pub mod measured;
pub mod pictures;

use burnish_material::{FileError, MaterialFile, Warning};

/// One material of the library.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Preset {
    /// Folder of the file, such as `metals`; [`group_title`] has its title.
    pub group: &'static str,
    /// Name shown to users, as written in the file. No two presets share one.
    pub name: &'static str,
    /// Name of the file without `.asm.ron`, in lower case with hyphens. No two presets share one.
    pub file_stem: &'static str,
    /// Words for searching, as written in the file.
    pub tags: &'static [&'static str],
    /// Main dataset or person, the `source` of the file's provenance.
    pub source: &'static str,
    /// The whole file.
    pub text: &'static str,
}

impl Preset {
    /// Reads the embedded file.
    ///
    /// A test reads every preset without an error or a warning, so both only arise from an edited library.
    pub fn parse(&self) -> Result<(MaterialFile, Vec<Warning>), FileError> {
        MaterialFile::parse(self.text)
    }
}

/// Titles of the groups, in the order of [`presets`].
const GROUP_TITLES: &[(&str, &str)] = &[
    ("ceramics", "Ceramics"),
    ("emitters", "Emitters"),
    ("fabrics", "Fabrics and leather"),
    ("foods", "Foods"),
    ("glass-gems", "Glass and gems"),
    ("liquids", "Liquids, pastes and ice"),
    ("metals", "Metals"),
    ("organic", "Wax, shell, bone and plants"),
    ("paints", "Paints and coats"),
    ("papers", "Papers"),
    ("plastics", "Plastics and rubber"),
    ("skin", "Skin"),
    ("stone", "Stone, ground and building"),
    ("woods", "Woods"),
];

/// All presets, sorted by group, then by name.
pub fn presets() -> &'static [Preset] {
    // One place in memory, so that a preset can be told by its address.
    static PRESETS: &[Preset] = include!(concat!(env!("OUT_DIR"), "/presets.rs"));
    PRESETS
}

/// The preset whose name or file stem is `name` in any case, or `None`. Spaces around `name` do not matter.
pub fn find(name: &str) -> Option<&'static Preset> {
    let name = name.trim().to_lowercase();
    presets().iter().find(|preset| preset.name.to_lowercase() == name || preset.file_stem == name)
}

/// Presets in which every word of `query` occurs, in any case and also as part of a longer word, in the order of
/// [`presets`].
///
/// Looked at are name, group, title of the group and tags. An empty query finds all.
pub fn search(query: &str) -> Vec<&'static Preset> {
    let query = query.to_lowercase();
    let holds = |preset: &&Preset| {
        let title = group_title(preset.group);
        let text = [preset.name, preset.group, title, &preset.tags.join(" ")].join(" ").to_lowercase();
        query.split_whitespace().all(|word| text.contains(word))
    };
    presets().iter().filter(holds).collect()
}

/// The title of a group for headings; `Other` for a group that the library does not have.
pub fn group_title(group: &str) -> &'static str {
    GROUP_TITLES.iter().find(|(name, _)| *name == group).map_or("Other", |(_, title)| title)
}

//! Interchange on disk: files of other formats to materials with their images and meshes, and back. What the formats mean is in
//! `burnish_material::exchange`; here they get their paths, folders and images.

pub mod bake;
mod error;
mod import;
pub mod measure;
mod mesh;
pub(crate) mod names;
pub mod open;
mod own_text;
pub mod save;

pub use error::ExchangeError;
pub use import::{Import, import, imported_images};
pub use mesh::{is_mesh_path, load_mesh};

use burnish_material::Material;
use burnish_material::exchange::loss::Row;
use burnish_material::exchange::model::Context;
use burnish_material::exchange::models::{gltf, open_pbr, usd_preview};
use burnish_material::exchange::{ShadingModel, mdl};
use std::path::Path;

/// A format of material files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// The native file.
    Native,
    /// glTF 2.0 as text with files beside it.
    Gltf,
    /// glTF 2.0 in one file.
    Glb,
    /// MaterialX.
    MaterialX,
    /// USD as text.
    Usda,
    /// USD with its images in one file.
    Usdz,
    /// MDL.
    Mdl,
}

/// One row of the table of formats.
#[derive(Clone, Copy, Debug)]
pub struct FormatDef {
    /// Which one.
    pub format: Format,
    /// What to show the user.
    pub label: &'static str,
    /// Ending of file names, without the dot.
    pub ending: &'static str,
    /// The last part of it, as dialogs filter by.
    pub endings: &'static [&'static str],
    /// What a material becomes for programs that do not know ASM; `None` for the native file and for MDL, which brings ASM along.
    pub model: Option<&'static ShadingModel>,
}

/// Every format.
pub const FORMATS: &[FormatDef] = &[
    FormatDef { format: Format::Native, label: "Burnish material", ending: "asm.ron", endings: &["ron"], model: None },
    FormatDef { format: Format::Gltf, label: "glTF", ending: "gltf", endings: &["gltf"], model: Some(&gltf::MODEL) },
    FormatDef { format: Format::Glb, label: "glTF binary", ending: "glb", endings: &["glb"], model: Some(&gltf::MODEL) },
    FormatDef {
        format: Format::MaterialX,
        label: "MaterialX (OpenPBR)",
        ending: "mtlx",
        endings: &["mtlx"],
        model: Some(&open_pbr::MODEL),
    },
    FormatDef { format: Format::Usda, label: "USD", ending: "usda", endings: &["usda"], model: Some(&usd_preview::MODEL) },
    FormatDef {
        format: Format::Usdz,
        label: "USD package",
        ending: "usdz",
        endings: &["usdz"],
        model: Some(&usd_preview::MODEL),
    },
    FormatDef { format: Format::Mdl, label: "MDL", ending: "mdl", endings: &["mdl"], model: None },
];

impl Format {
    /// The format of a file name, by its ending in any case.
    pub fn of(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_string_lossy().to_lowercase();
        let has = |ending: &str| name.strip_suffix(ending).is_some_and(|stem| stem.ends_with('.'));
        FORMATS.iter().find(|def| has(def.ending)).map(|def| def.format).or_else(|| has("ron").then_some(Self::Native))
    }

    /// Whether a file holds one material only.
    pub fn holds_one(self) -> bool {
        matches!(self, Self::Native | Self::Mdl)
    }

    /// Its row of the table.
    pub fn def(self) -> &'static FormatDef {
        FORMATS.iter().find(|def| def.format == self).unwrap_or(&FORMATS[0])
    }
}

/// What becomes of each property of a material in a format; nothing to tell for the native file.
pub fn rows(format: Format, material: &Material) -> Vec<Row> {
    match (format, format.def().model) {
        (Format::Mdl, _) => mdl::loss(material, mdl::Flavour::Own),
        (_, Some(model)) => model.translate(material, &Context::of(material)).rows,
        (_, None) => Vec::new(),
    }
}

/// The endings of all formats, for messages.
pub fn endings() -> String {
    FORMATS.iter().map(|def| format!(".{}", def.ending)).collect::<Vec<_>>().join(", ")
}

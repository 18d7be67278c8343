//! Documents as this program writes them.

use burnish_material::Material;
use burnish_material::exchange::ShadingModel;
use burnish_material::exchange::materialx::{ReadMaterial, WriteOptions, read, write};

pub fn options(surface: &'static ShadingModel) -> WriteOptions<'static> {
    WriteOptions { surface, ..WriteOptions::default() }
}

pub fn text(material: &Material, surface: &'static ShadingModel) -> String {
    write(&[material], &options(surface)).text
}

pub fn one(text: &str) -> ReadMaterial {
    let mut all = read(text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    assert_eq!(all.len(), 1);
    all.remove(0)
}

/// The document without anything that only this program reads.
pub fn without_native_copy(text: &str) -> String {
    let mut text = text.replace(" asm_source=", " other_source=");
    for tag in ["adobe_standard_material name=", "surfacematerial name="] {
        let mut from = 0;
        while let Some(start) = text[from..].find(&format!("<{tag}")).map(|at| at + from) {
            let name = tag.split(' ').next().unwrap_or_default();
            let end = text[start..].find(&format!("</{name}>")).map_or(text.len(), |at| start + at + name.len() + 3);
            if name == "surfacematerial" && !text[start..end].contains("_native\"") {
                from = end;
            } else {
                text.replace_range(start..end, "");
            }
        }
    }
    text
}

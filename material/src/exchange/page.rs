//! The reference page of the interchange for users, made from the tables of the shading models.

use std::fmt::Write;

use super::loss::{Row, rows};
use super::model::{Context, MODELS};
use super::models::imageworks;
use crate::material::Material;
use crate::properties::PROPERTIES;
use crate::value::Value;

/// Where files hold a model, by its name.
const FILES: &[(&str, &str)] = &[
    ("open_pbr_surface", "MaterialX (`.mtlx`), beside the native copy."),
    ("standard_surface", "MaterialX (`.mtlx`) with `--model standard_surface`."),
    ("gltf", "glTF (`.gltf`, `.glb`)."),
    ("gltf_pbr", "MaterialX (`.mtlx`) with `--model gltf_pbr`."),
    ("usd_preview_surface", "USD (`.usda`, `.usdz`); MaterialX (`.mtlx`) with `--model usd_preview_surface`."),
    ("disney_principled", "MaterialX (`.mtlx`) with `--model disney_principled`."),
    (
        "filament",
        "Definitions of Filament (`.mat`): images are parameters that the application binds, and comments name the file of each.",
    ),
    (
        "dassault_enterprise_pbr",
        "None of its own. The draft of a glTF extension, `3DS_materials_enterprise_pbr`, is not what its sample renderer reads: that takes glTF with the ratified extensions, \
         so write `.gltf`. The table tells what its parameters mean.",
    ),
    (
        "specular_glossiness",
        "Texture sets (`NAME.textures.json` with `NAME_Diffuse.png`, `NAME_Specular.png`, `NAME_Glossiness.png`) with `--model specular_glossiness`. glTF's archived extension \
         `KHR_materials_pbrSpecularGlossiness` is read and not written.",
    ),
    (
        "metallic_roughness",
        "Texture sets (`NAME.textures.json`, the native copy, with `NAME_BaseColor.png` and so on). Images that had to be changed lie in `NAME_originals` as they were. Folders of images \
         by others are read by their names.",
    ),
];

/// What the numbers of the formulas in the code mean.
const FORMULAS: &[(&str, &str)] = &[
    (
        "5.1",
        "Anisotropy. The highlight of ASM has the widths `min(1, r² + A⁴)` along the turned tangent and `r²` across. Models split the same two widths into other numbers; the way back is exact until a width reaches 1.",
    ),
    (
        "5.2",
        "A level folded into an index of refraction, where a model has no level: `e = sqrt(2 level F0(n))`, `n' = (1 + e)/(1 - e)`. Refraction then follows the folded index as well.",
    ),
    ("5.3", "Dispersion is 20 divided by the Abbe number."),
    ("5.4", "Emission. A luminance of 1000 nits stands for an emission of 1, by Adobe's convention."),
    ("5.5", "Absorption is `-ln(color)/distance`. At a distance of 0 the colour tints each crossing of the surface."),
    (
        "5.6",
        "Scattering. The colour of a thick body is turned into an albedo and a mean free path for each channel (Kulla and Conty 2017); red shift and Rayleigh scattering become part of the paths.",
    ),
    (
        "5.9",
        "Strength of normal maps. From 1 upwards the slope is scaled in every format; below 1 ASM scales the angle, others the slope. The number is kept.",
    ),
];

/// A material with every property inside its range and off its default.
pub fn material_off_default() -> Material {
    let mut material = Material::default();
    for def in PROPERTIES {
        let (low, high) = (def.limits.min.unwrap_or(0.0), def.limits.max.unwrap_or(def.limits.slider_max));
        let at = |share: f64| low + share * (high - low);
        let value = match def.default {
            Value::Color(_) => Value::Color([at(0.371), at(0.5), at(0.25)]),
            Value::Float(_) => Value::Float(at(0.371)),
            Value::Bool(on) => Value::Bool(!on),
            Value::Normal(_) => Value::Normal([0.6, 0.0, 0.8]),
        };
        material.set(def.id, value);
    }
    material
}

/// Makes the text of `INTERCHANGE.md`; a test keeps the file current.
pub fn interchange_page() -> String {
    let mut page = String::from(
        "# Interchange\n\n\
         Generated from `src/exchange`; a test keeps it current.\n\n\
         Each table tells what becomes of a material that has every property off its default, as far as other programs see it: *exact* is the \
         same number, or one that leads back to it; *remapped* other numbers with the same look and the way back; *approximated* another look, \
         or no exact way back; *dropped* is not there. A property at its default is never lost, and the native copy beside each translation gives \
         back every bit to this program. What that looks like for each preset was measured: \
         [interchange_loss.md](../tests/benches/results/interchange_loss.md).\n",
    );
    let material = material_off_default();
    // Writing to a String cannot fail.
    for model in MODELS {
        _ = writeln!(page, "\n## {}\n", model.label);
        if let Some((_, files)) = FILES.iter().find(|(name, _)| *name == model.name) {
            _ = writeln!(page, "Files: {files}\n");
        }
        table(&mut page, &model.translate(&material, &Context::of(&material)).rows);
    }
    _ = writeln!(page, "\n## {}\n", imageworks::LABEL);
    page += "Nothing is translated to it: its parameters are not published. What its description has for each property:\n\n";
    table(&mut page, &rows(imageworks::CELLS, &material));
    page += "\n## Formulas\n\nThe code names them by these numbers.\n\n";
    for (number, text) in FORMULAS {
        _ = writeln!(page, "- **{number}** {text}");
    }
    page
}

fn table(page: &mut String, rows: &[Row]) {
    *page += "| Property | Parameters | What becomes of it |\n| --- | --- | --- |\n";
    for row in rows {
        let targets = row.target.split(", ").filter(|target| !target.is_empty());
        let targets: Vec<_> = targets.map(|target| format!("`{target}`")).collect();
        let note = if row.note.is_empty() { String::new() } else { format!(": {}", row.note) };
        _ = writeln!(page, "| `{}` | {} | {}{note} |", row.property.def().name, targets.join(", "), row.fate.word());
    }
}

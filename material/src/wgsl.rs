//! The property table as WGSL: rows as they are uploaded, and the same values under their names.

use std::fmt::Write;

use crate::properties::PROPERTIES;
use crate::value::Kind;

/// Generated from the property table: `MaterialRows`, `Inputs` and `inputs_from_rows`.
pub const ASM_MATERIAL_WGSL: &str = include_str!("asm_material.gen.wgsl");

/// Makes the text of [`ASM_MATERIAL_WGSL`] from the table; a test keeps the file current.
pub fn inputs_wgsl() -> String {
    let mut rows = String::new();
    let mut fields = String::new();
    let mut arguments = String::new();
    for def in PROPERTIES {
        let name = def.name;
        let (wgsl, read) = match def.default.kind() {
            Kind::Color | Kind::Normal => ("vec3f", format!("rows.{name}.xyz")),
            Kind::Float => ("f32", format!("rows.{name}.x")),
            Kind::Bool => ("bool", format!("rows.{name}.x > 0.5")),
        };
        // Writing to a String cannot fail.
        _ = writeln!(rows, "    {name}: vec4f,");
        _ = writeln!(fields, "    // {}\n    {name}: {wgsl},", def.doc);
        _ = writeln!(arguments, "        {read},");
    }
    format!(
        "// Generated from material/src/properties.rs; a test keeps it current. Do not edit.\n\
         \n\
         // One row per property, in the order of the specification: the value in xyz, the texture slot or -1 in w.\n\
         struct MaterialRows {{\n{rows}}}\n\
         \n\
         // All property values at one shading point, textures already sampled.\n\
         struct Inputs {{\n{fields}}}\n\
         \n\
         fn inputs_from_rows(rows: MaterialRows) -> Inputs {{\n    return Inputs(\n{arguments}    );\n}}\n"
    )
}

//! A mesh that wears the materials.

use std::ops::Range;

use super::super::numbers::{quoted, tuple};
use super::text::Text;

/// A mesh as plain arrays. Lists by position have the length of `positions` or are empty.
#[derive(Clone, Copy, Debug)]
pub struct MeshArrays<'a> {
    /// Name of its prim; letters, digits and `_`.
    pub name: &'a str,
    /// Positions in metres, +Y up.
    pub positions: &'a [[f32; 3]],
    /// Directions across the surface, of length 1.
    pub normals: &'a [[f32; 3]],
    /// Directions along u, of length 1, and the side of v: 1 or -1.
    pub tangents: &'a [[f32; 4]],
    /// Texture coordinates, origin bottom left.
    pub uvs: &'a [[f32; 2]],
    /// Places of positions, counterclockwise seen from outside.
    pub triangles: &'a [[u32; 3]],
    /// Which triangles have which material: its place in the list.
    pub parts: &'a [(usize, Range<usize>)],
}

/// Writes the mesh; materials by their paths.
pub(super) fn write(text: &mut Text, mesh: &MeshArrays, materials: &[String], meters_per_unit: f64) {
    let name: String = mesh.name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    let name =
        if name.starts_with(|c: char| c.is_ascii_alphabetic()) && name != "Materials" { name } else { format!("Mesh_{name}") };
    let parts: Vec<(&String, Range<usize>)> = mesh
        .parts
        .iter()
        .filter_map(|(material, range)| {
            Some((materials.get(*material)?, range.start.min(mesh.triangles.len())..range.end.min(mesh.triangles.len())))
        })
        .collect();
    let positions: Vec<[f64; 3]> = mesh.positions.iter().map(|p| p.map(|x| f64::from(x) / meters_per_unit)).collect();

    text.line("");
    text.open_round(&format!("def Mesh {} ", quoted(&name)));
    text.line("prepend apiSchemas = [\"MaterialBindingAPI\"]");
    text.close(")");
    text.open();
    text.line("uniform token subdivisionScheme = \"none\"");
    text.line(&format!("float3[] extent = {}", items(&extent(&positions))));
    text.line(&format!("int[] faceVertexCounts = [{}]", vec!["3"; mesh.triangles.len()].join(", ")));
    let corners: Vec<String> = mesh.triangles.as_flattened().iter().map(u32::to_string).collect();
    text.line(&format!("int[] faceVertexIndices = [{}]", corners.join(", ")));
    text.line(&format!("point3f[] points = {}", items(&positions)));
    vertex_data(text, "normal3f[] normals", mesh.normals, mesh.positions.len());
    vertex_data(text, "texCoord2f[] primvars:st", mesh.uvs, mesh.positions.len());
    vertex_data(text, "float4[] primvars:tangents", mesh.tangents, mesh.positions.len());
    if let [(material, triangles)] = parts.as_slice()
        && triangles.len() == mesh.triangles.len()
    {
        text.line(&format!("rel material:binding = <{material}>"));
    } else if !parts.is_empty() {
        text.line("uniform token subsetFamily:materialBind:familyType = \"nonOverlapping\"");
        for (place, (material, triangles)) in parts.into_iter().enumerate() {
            text.line("");
            text.open_round(&format!("def GeomSubset \"Part{}\" ", place + 1));
            text.line("prepend apiSchemas = [\"MaterialBindingAPI\"]");
            text.close(")");
            text.open();
            text.line("uniform token elementType = \"face\"");
            text.line("uniform token familyName = \"materialBind\"");
            let faces: Vec<String> = triangles.map(|face| face.to_string()).collect();
            text.line(&format!("int[] indices = [{}]", faces.join(", ")));
            text.line(&format!("rel material:binding = <{material}>"));
            text.close("}");
        }
    }
    text.close("}");
}

fn vertex_data<const N: usize>(text: &mut Text, head: &str, data: &[[f32; N]], count: usize) {
    if data.is_empty() || data.len() != count {
        return;
    }
    let wide: Vec<[f64; N]> = data.iter().map(|item| item.map(f64::from)).collect();
    text.open_round(&format!("{head} = {} ", items(&wide)));
    text.line("interpolation = \"vertex\"");
    text.close(")");
}

fn items<const N: usize>(items: &[[f64; N]]) -> String {
    format!("[{}]", items.iter().map(|item| tuple(item)).collect::<Vec<_>>().join(", "))
}

fn extent(positions: &[[f64; 3]]) -> [[f64; 3]; 2] {
    let Some(first) = positions.first() else { return [[0.0; 3]; 2] };
    positions.iter().fold([*first; 2], |[low, high], p| {
        [std::array::from_fn(|k| low[k].min(p[k])), std::array::from_fn(|k| high[k].max(p[k]))]
    })
}

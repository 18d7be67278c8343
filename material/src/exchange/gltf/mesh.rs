//! The mesh of a document: plain arrays to accessors.

use serde_json::{Map, Value as Json, json};

use super::error::{GltfError, Wrong};

const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY: u32 = 34962;
const ELEMENT_ARRAY: u32 = 34963;

/// Gap between two meshes side by side, as a share of their width.
const GAP: f64 = 0.25;

/// A triangle mesh as plain arrays. Lengths are metres, +y is up; normals, tangents and uvs are one per position, or none.
#[derive(Clone, Copy, Debug, Default)]
pub struct Mesh<'a> {
    /// Points in space.
    pub positions: &'a [[f32; 3]],
    /// Unit normals, outwards.
    pub normals: &'a [[f32; 3]],
    /// Unit tangents along u; `w` is 1 or -1, the sign of the bitangent, which points to smaller v.
    pub tangents: &'a [[f32; 4]],
    /// Texture coordinates; (0, 0) is the upper left corner of an image.
    pub uvs: &'a [[f32; 2]],
    /// Three vertex numbers each, counter-clockwise seen from outside.
    pub triangles: &'a [[u32; 3]],
}

impl Mesh<'_> {
    /// Width of the box around the mesh, along x: what the thickness of a material is a share of. 1 where it has none.
    pub fn width(&self) -> f64 {
        let (least, most) = bounds(self.positions);
        let width = f64::from(most[0]) - f64::from(least[0]);
        if width.is_finite() && width > 0.0 { width } else { 1.0 }
    }

    /// Writes the mesh once for each of `count` materials, side by side, or bare where there are none.
    pub(super) fn write(&self, count: usize, body: &mut Map<String, Json>, blob: &mut Vec<u8>) -> Result<(), GltfError> {
        self.check().map_err(GltfError::Mesh)?;
        let (mut views, mut accessors) = (Vec::new(), Vec::new());
        let mut attributes = Map::new();
        let mut add = |numbers: &mut dyn Iterator<Item = u32>, count: usize, kind: &str, component: u32, target: u32, ends| {
            let start = blob.len();
            numbers.for_each(|bits| blob.extend(bits.to_le_bytes()));
            views.push(json!({ "buffer": 0, "byteOffset": start, "byteLength": blob.len() - start, "target": target }));
            let mut accessor = json!({ "bufferView": views.len() - 1, "componentType": component, "count": count, "type": kind });
            if let Some((least, most)) = ends {
                let (least, most): ([f32; 3], [f32; 3]) = (least, most);
                (accessor["min"], accessor["max"]) = (json!(least), json!(most));
            }
            accessors.push(accessor);
            accessors.len() - 1
        };
        let points = self.positions.len();
        let bits = |numbers: &[f32]| numbers.iter().map(|x| x.to_bits()).collect::<Vec<_>>().into_iter();
        let ends = Some(bounds(self.positions));
        let position = add(&mut bits(self.positions.as_flattened()), points, "VEC3", FLOAT, ARRAY, ends);
        attributes.insert("POSITION".to_owned(), json!(position));
        for (name, numbers, kind) in [
            ("NORMAL", self.normals.as_flattened(), "VEC3"),
            ("TANGENT", self.tangents.as_flattened(), "VEC4"),
            ("TEXCOORD_0", self.uvs.as_flattened(), "VEC2"),
        ] {
            if !numbers.is_empty() {
                attributes.insert(name.to_owned(), json!(add(&mut bits(numbers), points, kind, FLOAT, ARRAY, None)));
            }
        }
        let corners = self.triangles.as_flattened();
        let indices = add(&mut corners.iter().copied(), corners.len(), "SCALAR", UNSIGNED_INT, ELEMENT_ARRAY, None);
        let primitive = |material: Option<usize>| {
            let mut primitive = json!({ "attributes": attributes, "indices": indices });
            if let Some(material) = material {
                primitive["material"] = json!(material);
            }
            json!({ "primitives": [primitive] })
        };
        let worn: Vec<Option<usize>> = if count == 0 { vec![None] } else { (0..count).map(Some).collect() };
        let step = self.width() * (1.0 + GAP);
        let nodes = (0..worn.len()).map(|k| match k {
            0 => json!({ "mesh": 0 }),
            k => json!({ "mesh": k, "translation": [k as f64 * step, 0.0, 0.0] }),
        });
        body.insert("scene".to_owned(), json!(0));
        body.insert("scenes".to_owned(), json!([{ "nodes": (0..worn.len()).collect::<Vec<_>>() }]));
        body.insert("nodes".to_owned(), Json::Array(nodes.collect()));
        body.insert("meshes".to_owned(), Json::Array(worn.into_iter().map(primitive).collect()));
        body.insert("accessors".to_owned(), Json::Array(accessors));
        body.insert("bufferViews".to_owned(), Json::Array(views));
        Ok(())
    }

    fn check(&self) -> Result<(), Wrong> {
        let points = self.positions.len();
        if points == 0 || self.triangles.is_empty() {
            return Err(Wrong::new("mesh", "triangles", "none"));
        }
        for (name, count) in [("normals", self.normals.len()), ("tangents", self.tangents.len()), ("uvs", self.uvs.len())] {
            if count != 0 && count != points {
                return Err(Wrong::new(name, format!("{points}, one per position, or none"), count.to_string()));
            }
        }
        if !self.tangents.is_empty() && self.normals.is_empty() {
            return Err(Wrong::new("tangents", "normals beside them", "none"));
        }
        let numbers =
            [self.positions.as_flattened(), self.normals.as_flattened(), self.tangents.as_flattened(), self.uvs.as_flattened()];
        if let Some(number) = numbers.into_iter().flatten().find(|x| !x.is_finite()) {
            return Err(Wrong::new("mesh", "finite numbers", number.to_string()));
        }
        let is_unit = |v: &[f32]| (v.iter().map(|x| x * x).sum::<f32>().sqrt() - 1.0).abs() < 1e-3;
        if let Some(normal) = self.normals.iter().find(|normal| !is_unit(&normal[..])) {
            return Err(Wrong::new("normals", "unit vectors", format!("{normal:?}")));
        }
        if let Some(tangent) = self.tangents.iter().find(|t| !is_unit(&t[..3]) || t[3].abs() != 1.0) {
            return Err(Wrong::new("tangents", "unit vectors with 1 or -1 behind them", format!("{tangent:?}")));
        }
        match self.triangles.as_flattened().iter().find(|corner| **corner as usize >= points) {
            Some(corner) => Err(Wrong::new("triangles", format!("numbers below {points}"), corner.to_string())),
            None => Ok(()),
        }
    }
}

/// Least and greatest coordinates.
fn bounds(positions: &[[f32; 3]]) -> ([f32; 3], [f32; 3]) {
    positions.iter().fold(([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]), |(least, most), p| {
        (std::array::from_fn(|k| least[k].min(p[k])), std::array::from_fn(|k| most[k].max(p[k])))
    })
}

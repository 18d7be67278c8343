//! Meshes of a layer as plain arrays: metres, +Y up, triangles, one vertex for each combination of position, normal and uv.

use std::collections::HashMap;
use std::ops::Range;

use super::layer::{Attribute, Layer, PrimId, Value, entry};
use super::materials::{FoundMaterial, meters_per_unit};
use super::transform::{self, Matrix};
use crate::exchange::model::Notes;
use crate::exchange::short::short;

/// Most triangles of all meshes of a layer.
pub const MAX_TRIANGLES: usize = 2_000_000;
/// Most meshes that are read from a layer.
pub const MAX_MESHES: usize = 20_000;
/// Most notes about meshes.
const MAX_NOTES: usize = 200;

/// A mesh of a layer.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundMesh {
    /// Path of its prim.
    pub path: String,
    /// Positions in metres, +Y up, where they stand in the scene. All finite.
    pub positions: Vec<[f32; 3]>,
    /// Directions across the surface by position, of length 1; `None` where the layer says none.
    pub normals: Option<Vec<[f32; 3]>>,
    /// Texture coordinates by position, origin bottom left; `None` where the layer says none.
    pub uvs: Option<Vec<[f32; 2]>>,
    /// Places of positions, counterclockwise seen from outside; sorted by part.
    pub triangles: Vec<[u32; 3]>,
    /// Which triangles have which material.
    pub parts: Vec<Part>,
}

/// Triangles of one material.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Place in the list of materials; `None` where none is bound.
    pub material: Option<usize>,
    /// The triangles.
    pub triangles: Range<usize>,
}

/// The meshes of a layer; of very many the first ones, with a note. One that cannot be read costs a note.
pub(super) fn meshes(layer: &Layer, materials: &[FoundMaterial], notes: &mut Notes) -> Vec<FoundMesh> {
    let notes_before = notes.len();
    let places: HashMap<&str, usize> = materials.iter().enumerate().map(|(place, found)| (found.path.as_str(), place)).collect();
    let (mut found, mut left) = (Vec::new(), MAX_TRIANGLES);
    let to_metres = to_metres(layer);
    let mut all = layer.in_scene("Mesh");
    for id in all.by_ref().take(MAX_MESHES) {
        let mut faults = Notes::new();
        match mesh(layer, id, &places, left, &to_metres, &mut faults) {
            Ok(mesh) => {
                left -= mesh.triangles.len();
                found.push(mesh);
            }
            Err(fault) => faults.push(format!("<{}>: {fault}; the mesh is not read", short(&layer.path(id)))),
        }
        faults.truncate(MAX_NOTES.saturating_sub(notes.len().saturating_sub(notes_before)));
        notes.append(&mut faults);
    }
    if all.next().is_some() {
        notes.push(format!("expected at most {MAX_MESHES} meshes, found more; the first ones are read"));
    }
    found
}

/// A quantity over a mesh: how many numbers it has, and which of its items belongs where.
struct Primvar<'t> {
    data: &'t [f64],
    width: usize,
    indices: Option<&'t [f64]>,
    interpolation: &'t str,
}

/// One corner of a face.
#[derive(Clone, Copy)]
struct Corner {
    face: usize,
    /// Place among all corners.
    corner: usize,
    vertex: usize,
}

impl<'t> Primvar<'t> {
    fn of(layer: &'t Layer, prim: PrimId, attribute: &'t Attribute, width: usize, otherwise: &'t str) -> Option<Self> {
        let data = attribute.value.as_ref()?.list(width)?;
        let indices = layer.value(prim, &format!("{}:indices", attribute.name)).and_then(|value| value.list(1));
        let interpolation = entry(&attribute.metadata, "interpolation").and_then(Value::text).unwrap_or(otherwise);
        (!data.is_empty()).then_some(Self { data, width, indices, interpolation })
    }

    /// Place of the item that belongs to a corner.
    fn place(&self, at: Corner) -> Option<usize> {
        let place = match self.interpolation {
            "constant" => 0,
            "uniform" => at.face,
            "vertex" | "varying" => at.vertex,
            "faceVarying" => at.corner,
            _ => return None,
        };
        let place = match self.indices {
            Some(indices) => whole(*indices.get(place)?)?,
            None => place,
        };
        (place < self.data.len() / self.width).then_some(place)
    }

    fn item<const N: usize>(&self, place: usize) -> [f64; N] {
        std::array::from_fn(|k| self.data.get(place * self.width + k).copied().unwrap_or(0.0))
    }
}

fn whole(x: f64) -> Option<usize> {
    (x >= 0.0 && x <= f64::from(u32::MAX) && x.fract() == 0.0).then_some(x as usize)
}

fn mesh(
    layer: &Layer,
    prim: PrimId,
    places: &HashMap<&str, usize>,
    most: usize,
    to_metres: &Matrix,
    notes: &mut Notes,
) -> Result<FoundMesh, String> {
    let list = |name: &str, width| layer.value(prim, name).and_then(|value| value.list(width)).unwrap_or_default();
    let (points, counts, indices) = (list("points", 3), list("faceVertexCounts", 1), list("faceVertexIndices", 1));
    let vertex_count = points.len() / 3;
    let counts: Option<Vec<usize>> = counts.iter().map(|x| whole(*x)).collect();
    let indices: Option<Vec<usize>> = indices.iter().map(|x| whole(*x).filter(|vertex| *vertex < vertex_count)).collect();
    let (Some(counts), Some(indices)) = (counts, indices) else {
        return Err(format!("expected faces of its {vertex_count} points, found others"));
    };
    let corners = counts.iter().try_fold(0_usize, |sum, count| sum.checked_add(*count));
    if corners != Some(indices.len()) || indices.is_empty() {
        return Err(format!("expected as many corners as its faces have together, found {}", indices.len()));
    }
    if counts.iter().map(|count| count.saturating_sub(2)).sum::<usize>() > most {
        return Err(format!("expected at most {MAX_TRIANGLES} triangles in all meshes, found more"));
    }

    let path = layer.path(prim);
    let attribute = |name: &str| layer.attribute(prim, name);
    let normals = attribute("primvars:normals").or_else(|| attribute("normals"));
    let normals = normals.and_then(|attribute| Primvar::of(layer, prim, attribute, 3, "vertex"));
    let is_uv = |attribute: &&Attribute| {
        attribute.name.starts_with("primvars:")
            && matches!(attribute.type_name, "texCoord2f" | "texCoord2h" | "texCoord2d" | "float2")
    };
    let uvs = attribute("primvars:st").or_else(|| layer.attributes(prim).find(is_uv));
    let uvs = uvs.and_then(|attribute| Primvar::of(layer, prim, attribute, 2, "constant"));
    let (parts, part_of_face) = parts(layer, prim, counts.len(), places);

    let mut shape = Shape::new(normals, uvs);
    let mut by_part: Vec<Vec<[u32; 3]>> = vec![Vec::new(); parts.len()];
    let mut first = 0;
    for (face, count) in counts.iter().enumerate() {
        let mut fan = Vec::with_capacity(*count);
        for (corner, vertex) in indices.iter().enumerate().skip(first).take(*count) {
            fan.push(shape.vertex(Corner { face, corner, vertex: *vertex }));
        }
        first += count;
        if let Some(triangles) = by_part.get_mut(part_of_face[face]) {
            triangles.extend((2..fan.len()).map(|k| [fan[0], fan[k - 1], fan[k]]));
        }
    }
    if shape.lacks_normals || shape.lacks_uvs {
        notes.push(format!("<{}>: expected a normal and a uv at each corner, found fewer; not read", short(&path)));
    }

    let matrix = transform::product(&transform::to_layer(layer, prim, notes), to_metres);
    let is_left_handed = layer.value(prim, "orientation").and_then(Value::text) == Some("leftHanded");
    let mut mesh = shape.moved(path, points, &matrix)?;
    for (material, mut triangles) in parts.into_iter().zip(by_part) {
        if is_left_handed != transform::mirrors(&matrix) {
            triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        let start = mesh.triangles.len();
        mesh.triangles.append(&mut triangles);
        if mesh.triangles.len() > start {
            mesh.parts.push(Part { material, triangles: start..mesh.triangles.len() });
        }
    }
    if mesh.triangles.is_empty() { Err("expected at least one face of three corners, found none".to_owned()) } else { Ok(mesh) }
}

/// Vertices as they come together from the corners.
struct Shape<'t> {
    normals: Option<Primvar<'t>>,
    uvs: Option<Primvar<'t>>,
    lacks_normals: bool,
    lacks_uvs: bool,
    /// Places of position, normal and uv.
    vertices: Vec<[usize; 3]>,
    /// Vertices by their position's place and the bits of normal and uv: corners that look the same are one.
    places: HashMap<[u32; 6], u32>,
}

impl<'t> Shape<'t> {
    fn new(normals: Option<Primvar<'t>>, uvs: Option<Primvar<'t>>) -> Self {
        Self { normals, uvs, lacks_normals: false, lacks_uvs: false, vertices: Vec::new(), places: HashMap::new() }
    }

    fn vertex(&mut self, at: Corner) -> u32 {
        let (normal, direction) = corner_item::<3>(&self.normals, at, &mut self.lacks_normals);
        let (uv, coordinates) = corner_item::<2>(&self.uvs, at, &mut self.lacks_uvs);
        let ([x, y, z], [u, v]) = (direction, coordinates);
        *self.places.entry([at.vertex as u32, x, y, z, u, v]).or_insert_with(|| {
            self.vertices.push([at.vertex, normal, uv]);
            (self.vertices.len() - 1) as u32
        })
    }

    fn moved(&self, path: String, points: &[f64], matrix: &Matrix) -> Result<FoundMesh, String> {
        let float = |v: [f64; 3]| v.map(|x| x as f32);
        let mut positions = Vec::with_capacity(self.vertices.len());
        for [vertex, ..] in &self.vertices {
            let place = 3 * vertex;
            let point = points.get(place..place + 3).and_then(|p| p.try_into().ok()).unwrap_or([0.0; 3]);
            let position = float(transform::point(matrix, point));
            if position.iter().any(|x| !x.is_finite()) {
                return Err("expected finite positions, found others".to_owned());
            }
            positions.push(position);
        }
        let inverse =
            transform::inverse(matrix).ok_or("expected a transform that keeps its three dimensions, found a flat one")?;
        let normals = self.normals.as_ref().filter(|_| !self.lacks_normals);
        let normals = normals.map(|normals| {
            self.vertices.iter().map(|[_, place, _]| float(transform::normal(&inverse, normals.item(*place)))).collect()
        });
        let uvs = self.uvs.as_ref().filter(|_| !self.lacks_uvs);
        let uvs = uvs.map(|uvs| self.vertices.iter().map(|[.., place]| uvs.item(*place).map(|x: f64| x as f32)).collect());
        Ok(FoundMesh { path, positions, normals, uvs, triangles: Vec::new(), parts: Vec::new() })
    }
}

/// Place and bits of what belongs to a corner; sets `lacks` where nothing finite does.
fn corner_item<const N: usize>(primvar: &Option<Primvar>, at: Corner, lacks: &mut bool) -> (usize, [u32; N]) {
    let Some(primvar) = primvar else { return (0, [0; N]) };
    let found = primvar.place(at).map(|place| (place, primvar.item::<N>(place).map(|x| x as f32)));
    match found.filter(|(_, item)| item.iter().all(|x| x.is_finite())) {
        Some((place, item)) => (place, item.map(f32::to_bits)),
        None => {
            *lacks = true;
            (0, [0; N])
        }
    }
}

/// From the layer's space into metres with +Y up.
fn to_metres(layer: &Layer) -> Matrix {
    let metres = meters_per_unit(layer);
    let is_z_up = layer.metadata("upAxis").and_then(Value::text) == Some("Z");
    let mut turn = transform::IDENTITY;
    if is_z_up {
        (turn[1], turn[2]) = ([0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0]);
    }
    for row in &mut turn[..3] {
        *row = row.map(|x| x * metres);
    }
    turn
}

/// Materials of a mesh, its own first, and for each face which of them it has.
fn parts(layer: &Layer, prim: PrimId, faces: usize, places: &HashMap<&str, usize>) -> (Vec<Option<usize>>, Vec<usize>) {
    let mut parts = vec![bound(layer, prim, places)];
    let mut part_of_face = vec![0; faces];
    for child in &layer.prim(prim).children {
        let is_subset = layer.prim(*child).type_name == "GeomSubset" && layer.prim(*child).is_defined;
        let is_of_faces = layer.value(*child, "elementType").and_then(Value::text).is_none_or(|kind| kind == "face");
        if !is_subset || !is_of_faces || !has_binding(layer, *child) {
            continue;
        }
        let material = bound(layer, *child, places);
        let part = parts.iter().position(|found| *found == material).unwrap_or(parts.len());
        if part == parts.len() {
            parts.push(material);
        }
        for index in layer.value(*child, "indices").and_then(|value| value.list(1)).unwrap_or_default() {
            if let Some(face) = whole(*index).and_then(|face| part_of_face.get_mut(face)) {
                *face = part;
            }
        }
    }
    (parts, part_of_face)
}

const BINDINGS: [&str; 3] = ["material:binding", "material:binding:full", "material:binding:preview"];

fn has_binding(layer: &Layer, prim: PrimId) -> bool {
    BINDINGS.iter().any(|name| layer.attribute(prim, name).is_some_and(|binding| !binding.targets.is_empty()))
}

/// The material of a prim: its own, or that of the nearest prim that it stands in.
fn bound(layer: &Layer, mut prim: PrimId, places: &HashMap<&str, usize>) -> Option<usize> {
    while prim != Layer::ROOT {
        for name in BINDINGS {
            let target = layer.attribute(prim, name).and_then(|binding| binding.targets.first().copied());
            if let Some((material, _)) = target.and_then(|target| layer.find(prim, target)) {
                return places.get(layer.path(material).as_str()).copied();
            }
        }
        prim = layer.prim(prim).parent;
    }
    None
}

//! Meshes in PLY files: text, and binary of either byte order.
//!
//! Read are the vertices' x, y, z, nx, ny, nz and texture coordinates, and the faces' lists of vertices; polygons are
//! cut into fans. Other elements and properties are skipped. Texture coordinates are taken as they stand.

use std::path::Path;

use glam::{Vec2, Vec3};

use super::AssetError;
use super::ply_values::{Encoding, ScalarType, Values};
use crate::mesh::Mesh;

/// Longer headers are refused; real ones have a few hundred bytes.
const MAX_HEADER_BYTES: usize = 1 << 20;

/// A kind of record: `count` of them, each with the same properties.
struct Element {
    name: String,
    count: u64,
    properties: Vec<Property>,
}

struct Property {
    name: String,
    /// The type that a list's length is stored in; `None` for a single value.
    list: Option<ScalarType>,
    item: ScalarType,
}

impl Element {
    /// The least number of bytes that one record takes in the file.
    fn min_bytes(&self, encoding: Encoding) -> u64 {
        let least = |property: &Property| match encoding {
            // A digit and a separator; the last digit may end the file.
            Encoding::Ascii => 2,
            _ => property.list.unwrap_or(property.item).size() as u64,
        };
        self.properties.iter().map(least).sum()
    }
}

/// Reads the mesh in `bytes`, the contents of `file`, and sentences about what was left out.
pub(super) fn read(file: &Path, bytes: &[u8]) -> Result<(Mesh, Vec<String>), AssetError> {
    let (encoding, elements, header_bytes) = read_header(file, bytes)?;
    let mut values = Values::new(file, encoding, &bytes[header_bytes..]);
    let mut mesh = Mesh::default();
    let mut warnings = Vec::new();
    let mut has_faces = false;
    for element in &elements {
        if element.count == 0 || element.properties.is_empty() {
            continue;
        }
        // A wrong count must not ask for memory that the file could never fill.
        let least = element.count.saturating_mul(element.min_bytes(encoding));
        let left = values.bytes_left() as u64;
        // The last value of a text has no separator after it.
        if least > left.saturating_add(1) {
            let problem = format!("expected {} records, which take at least {least} bytes, found {left} bytes", element.count);
            return Err(AssetError::truncated(file, format!("element {}", element.name), problem));
        }
        match element.name.as_str() {
            "vertex" => read_vertices(file, element, &mut values, &mut mesh)?,
            "face" => {
                has_faces = true;
                read_faces(file, element, &mut values, &mut mesh, &mut warnings)?;
            }
            _ => skip(element, &mut values)?,
        }
    }
    if mesh.positions.is_empty() {
        return Err(AssetError::Empty { file: file.to_owned(), expected: "vertices" });
    }
    if !has_faces {
        return Err(AssetError::Empty { file: file.to_owned(), expected: "faces (a PLY element named face)" });
    }
    let count = mesh.positions.len();
    for (k, triangle) in mesh.triangles.iter().enumerate() {
        if let Some(&i) = triangle.iter().find(|&&i| i as usize >= count) {
            let problem = format!("expected vertex numbers below {count}, found {i}");
            return Err(AssetError::malformed(file, format!("element face, triangle {k}"), problem));
        }
    }
    Ok((mesh, warnings))
}

/// The encoding, the elements in order, and the number of bytes up to the data.
fn read_header(file: &Path, bytes: &[u8]) -> Result<(Encoding, Vec<Element>, usize), AssetError> {
    let malformed = |line: usize, problem: String| AssetError::malformed(file, format!("header line {line}"), problem);
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    let mut begin = 0;
    for number in 1.. {
        let rest = &bytes[begin..bytes.len().min(MAX_HEADER_BYTES)];
        let Some(length) = rest.iter().position(|&b| b == b'\n') else {
            let problem = if number == 1 { "expected \"ply\"" } else { "expected \"end_header\", found the end" };
            return Err(malformed(number, problem.to_owned()));
        };
        let line = String::from_utf8_lossy(&rest[..length]);
        begin += length + 1;
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        match words.as_slice() {
            ["ply"] if number == 1 => {}
            _ if number == 1 => return Err(malformed(number, "expected \"ply\"".to_owned())),
            ["end_header"] => break,
            [] | ["comment" | "obj_info", ..] => {}
            ["format", name, _version] => {
                let known = Encoding::named(name);
                let expected = "ascii, binary_little_endian or binary_big_endian";
                encoding = Some(known.ok_or_else(|| malformed(number, format!("expected {expected}, found {name}")))?);
            }
            ["element", name, count] => {
                let count = count.parse().map_err(|_| malformed(number, format!("expected a count, found {count}")))?;
                elements.push(Element { name: (*name).to_owned(), count, properties: Vec::new() });
            }
            ["property", words @ ..] => {
                let scalar = |name: &str| {
                    ScalarType::named(name).ok_or_else(|| malformed(number, format!("expected a type, found {name}")))
                };
                let property = match *words {
                    ["list", count, item, name] => {
                        Property { name: name.to_owned(), list: Some(scalar(count)?), item: scalar(item)? }
                    }
                    [item, name] => Property { name: name.to_owned(), list: None, item: scalar(item)? },
                    _ => return Err(malformed(number, format!("expected a type and a name, found \"{line}\""))),
                };
                let Some(element) = elements.last_mut() else {
                    return Err(malformed(number, "expected an element before its properties".to_owned()));
                };
                element.properties.push(property);
            }
            _ => return Err(malformed(number, format!("expected a keyword of PLY, found \"{}\"", line.trim()))),
        }
    }
    let encoding = encoding.ok_or_else(|| AssetError::malformed(file, "header", "expected a line \"format\""))?;
    Ok((encoding, elements, begin))
}

fn read_vertices(file: &Path, element: &Element, values: &mut Values<'_>, mesh: &mut Mesh) -> Result<(), AssetError> {
    let find = |names: &[&str]| element.properties.iter().position(|p| p.list.is_none() && names.contains(&p.name.as_str()));
    let (Some(x), Some(y), Some(z)) = (find(&["x"]), find(&["y"]), find(&["z"])) else {
        return Err(AssetError::malformed(file, "element vertex", "expected properties x, y and z"));
    };
    let normal = find(&["nx"]).zip(find(&["ny"])).zip(find(&["nz"]));
    let uv = find(&["u", "s", "texture_u", "texture_s"]).zip(find(&["v", "t", "texture_v", "texture_t"]));
    if u32::try_from(element.count).is_err() {
        let problem = format!("expected fewer than 2^32 vertices, found {}", element.count);
        return Err(AssetError::too_large(file, problem));
    }
    let count = element.count as usize;
    mesh.positions.reserve_exact(count);
    mesh.normals.reserve_exact(if normal.is_some() { count } else { 0 });
    mesh.uvs.reserve_exact(if uv.is_some() { count } else { 0 });
    let mut row = vec![0.0_f32; element.properties.len()];
    for record in 0..count {
        for (value, property) in row.iter_mut().zip(&element.properties) {
            *value = read_or_skip(values, property, element, record)?;
        }
        mesh.positions.push(Vec3::new(row[x], row[y], row[z]));
        if let Some(((nx, ny), nz)) = normal {
            mesh.normals.push(Vec3::new(row[nx], row[ny], row[nz]));
        }
        if let Some((u, v)) = uv {
            mesh.uvs.push(Vec2::new(row[u], row[v]));
        }
    }
    Ok(())
}

fn read_faces(
    file: &Path,
    element: &Element,
    values: &mut Values<'_>,
    mesh: &mut Mesh,
    warnings: &mut Vec<String>,
) -> Result<(), AssetError> {
    let is_corners = |p: &Property| p.list.is_some() && matches!(p.name.as_str(), "vertex_indices" | "vertex_index");
    if !element.properties.iter().any(is_corners) {
        return Err(AssetError::malformed(file, "element face", "expected a list named vertex_indices"));
    }
    let count = usize::try_from(element.count).unwrap_or(usize::MAX);
    mesh.triangles.reserve(count.min(values.bytes_left()));
    let mut short_faces = 0;
    for record in 0..count {
        for property in &element.properties {
            if !is_corners(property) {
                read_or_skip(values, property, element, record)?;
                continue;
            }
            let corners = list_length(values, property, element, record)?;
            short_faces += u64::from(corners < 3);
            let mut fan = [0; 2];
            for k in 0..corners {
                let value = values.next(property.item, &element.name, record)?;
                let Some(i) = as_index(value) else {
                    let problem = format!("expected a vertex number, found {value}");
                    return Err(AssetError::malformed(file, format!("element face, record {record}"), problem));
                };
                if k >= 2 {
                    mesh.triangles.push([fan[0], fan[1], i]);
                }
                fan[usize::from(k > 0)] = i;
            }
        }
    }
    if short_faces > 0 {
        warnings.push(format!("{short_faces} faces have fewer than three corners: they were left out."));
    }
    Ok(())
}

fn skip(element: &Element, values: &mut Values<'_>) -> Result<(), AssetError> {
    for record in 0..usize::try_from(element.count).unwrap_or(usize::MAX) {
        for property in &element.properties {
            read_or_skip(values, property, element, record)?;
        }
    }
    Ok(())
}

/// The value of a single property; a list is passed over and gives 0.
fn read_or_skip(values: &mut Values<'_>, property: &Property, element: &Element, record: usize) -> Result<f32, AssetError> {
    if property.list.is_none() {
        return Ok(values.next(property.item, &element.name, record)? as f32);
    }
    for _ in 0..list_length(values, property, element, record)? {
        values.next(property.item, &element.name, record)?;
    }
    Ok(0.0)
}

/// How many items the list has that comes next.
fn list_length(values: &mut Values<'_>, property: &Property, element: &Element, record: usize) -> Result<u32, AssetError> {
    let value = values.next(property.list.unwrap_or(property.item), &element.name, record)?;
    as_index(value).ok_or_else(|| values.malformed(&element.name, record, format!("expected a list length, found {value}")))
}

/// `value` as a whole number, if it is one that `u32` holds.
fn as_index(value: f64) -> Option<u32> {
    (value >= 0.0 && value <= f64::from(u32::MAX) && value.fract() == 0.0).then_some(value as u32)
}

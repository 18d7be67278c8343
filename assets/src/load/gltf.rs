//! Meshes in glTF 2.0 files, as text with buffers or as GLB.
//!
//! Only geometry is read: the triangles of the scene with its transforms, as one mesh. Materials, cameras, skins,
//! morph targets and animations are not; what would change the shape is named in a warning. The document is used as
//! parsed and unchecked, and every number in it is checked where it is used: its validation would refuse documents
//! for extensions that do not concern geometry.

use std::collections::BTreeSet;
use std::path::Path;

use glam::{Affine3A, Mat3, Mat4, Quat, Vec2, Vec3, Vec4};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Root, scene};

use super::AssetError;
use super::accessors::Accessors;
use super::error::one_line;
use crate::mesh::Mesh;
use crate::progress::{Ended, Progress};

/// A document can show one mesh many times; beyond this it is refused.
const MAX_TRIANGLES: usize = 1 << 25;

/// Extensions that store geometry in ways that are not read.
const COMPRESSIONS: &[&str] = &["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"];

/// Reads the mesh in `bytes`, the contents of `file`, and sentences about what was left out.
pub(super) fn read(file: &Path, bytes: &[u8], progress: Progress<'_>) -> Result<(Mesh, Vec<String>), AssetError> {
    let (json, blob) = if bytes.starts_with(b"glTF") { split_binary(file, bytes)? } else { (bytes, None) };
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    let root = Root::from_slice(json)
        .map_err(|problem| AssetError::malformed(file, "JSON", format!("expected a document of glTF 2.0: {problem}")))?;
    let mut warnings = Vec::new();
    check_features(file, &root, &mut warnings)?;

    let mut reader = Reader { file, root: &root, accessors: Accessors::new(file, &root, blob), warnings };
    let mut whole = Mesh::default();
    let placed = placed_meshes(file, &root)?;
    // A mesh is as long as its vertices are many.
    let work_of = |&(mesh, _): &(usize, Mat4)| root.meshes.get(mesh).map_or(0, |mesh| vertex_count(&root, mesh));
    let total = placed.iter().map(work_of).sum::<u64>().max(1) as f32;
    let mut done = 0;
    for (mesh, transform) in &placed {
        let begin = done as f32 / total;
        done += work_of(&(*mesh, *transform));
        progress.tell(begin).map_err(|Ended| AssetError::Ended { file: file.to_owned() })?;
        reader.append_mesh(&mut whole, *mesh, *transform, progress.part(begin, done as f32 / total))?;
    }
    let mut warnings = reader.warnings;
    // A mesh that is shown many times has the same remarks each time.
    let mut seen = BTreeSet::new();
    warnings.retain(|warning| seen.insert(warning.clone()));
    Ok((whole, warnings))
}

/// The JSON text and the binary data in a GLB file.
fn split_binary<'a>(file: &Path, bytes: &'a [u8]) -> Result<(&'a [u8], Option<&'a [u8]>), AssetError> {
    let word = |at: usize| bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let cut_off = |place: &str| AssetError::truncated(file, place, "expected more bytes, found the end of the file");
    let version = word(4).ok_or_else(|| cut_off("GLB header"))?;
    if version != 2 {
        return Err(AssetError::unsupported(file, "GLB header", format!("expected version 2, found {version}")));
    }
    let (mut json, mut blob) = (None, None);
    let mut at = 12;
    while at < bytes.len() {
        let place = format!("GLB chunk at byte {at}");
        let (Some(length), Some(kind)) = (word(at), bytes.get(at + 4..at + 8)) else { return Err(cut_off(&place)) };
        let begin = at + 8;
        let end = begin.saturating_add(length as usize);
        let Some(data) = bytes.get(begin..end) else {
            let found = bytes.len() - begin;
            return Err(AssetError::truncated(file, place, format!("expected {length} bytes, found {found}")));
        };
        // Chunks of other kinds are allowed and have no meaning here.
        match kind {
            b"JSON" if json.is_none() => json = Some(data),
            b"BIN\0" if blob.is_none() => blob = Some(data),
            _ => {}
        }
        at = end;
    }
    let json = json.ok_or_else(|| AssetError::malformed(file, "GLB", "expected a JSON chunk, found none"))?;
    Ok((json, blob))
}

/// Refuses documents whose geometry cannot be read, and says what will be missing of the others.
fn check_features(file: &Path, root: &Root, warnings: &mut Vec<String>) -> Result<(), AssetError> {
    if !root.asset.version.starts_with("2.") {
        let problem = format!("expected version 2, found \"{}\"", root.asset.version);
        return Err(AssetError::unsupported(file, "asset.version", problem));
    }
    for name in &root.extensions_required {
        if COMPRESSIONS.contains(&name.as_str()) {
            let problem = format!("{name} is not supported; expected a file exported without compression");
            return Err(AssetError::unsupported(file, "extensionsRequired", problem));
        }
        let concerns_looks = ["KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_"];
        if name != "KHR_mesh_quantization" && !concerns_looks.iter().any(|prefix| name.starts_with(prefix)) {
            warnings.push(format!("The extension {} is required and was left out.", one_line(name.clone())));
        }
    }
    let left_out = [(root.cameras.len(), "cameras"), (root.skins.len(), "skins"), (root.animations.len(), "animations")];
    for (count, what) in left_out {
        if count > 0 {
            warnings.push(format!("{count} {what} were left out."));
        }
    }
    Ok(())
}

/// The numbers of the scene's meshes with their transforms into the world, in document order.
fn placed_meshes(file: &Path, root: &Root) -> Result<Vec<(usize, Mat4)>, AssetError> {
    if root.nodes.is_empty() {
        return Ok((0..root.meshes.len()).map(|mesh| (mesh, Mat4::IDENTITY)).collect());
    }
    let roots: Vec<usize> = match root.scene.map_or(0, |scene| scene.value()) {
        number if root.scene.is_some() && number >= root.scenes.len() => {
            let problem = format!("expected a number below {}, found {number}", root.scenes.len());
            return Err(AssetError::malformed(file, "scene", problem));
        }
        number if number < root.scenes.len() => root.scenes[number].nodes.iter().map(|node| node.value()).collect(),
        _ => {
            // Without scenes, every node that no other holds is shown.
            let children: BTreeSet<usize> =
                root.nodes.iter().flat_map(|node| node.children.iter().flatten()).map(|node| node.value()).collect();
            (0..root.nodes.len()).filter(|node| !children.contains(node)).collect()
        }
    };
    let mut placed = Vec::new();
    let mut is_visited = vec![false; root.nodes.len()];
    let mut stack: Vec<(usize, Mat4)> = roots.into_iter().rev().map(|node| (node, Mat4::IDENTITY)).collect();
    while let Some((number, world_from_parent)) = stack.pop() {
        let Some(node) = root.nodes.get(number) else {
            let problem = format!("expected a number below {}, found {number}", root.nodes.len());
            return Err(AssetError::malformed(file, "nodes", problem));
        };
        // Nodes must form trees; a loop would never end.
        if std::mem::replace(&mut is_visited[number], true) {
            let problem = "expected at most one parent, found several or a loop";
            return Err(AssetError::malformed(file, format!("node {number}"), problem));
        }
        let world_from_node = world_from_parent * transform_of(node);
        if !world_from_node.is_finite() {
            return Err(AssetError::malformed(file, format!("node {number}"), "expected a finite transform"));
        }
        placed.extend(node.mesh.map(|mesh| (mesh.value(), world_from_node)));
        stack.extend(node.children.iter().flatten().rev().map(|child| (child.value(), world_from_node)));
    }
    Ok(placed)
}

/// How many vertices the document says a mesh has.
fn vertex_count(root: &Root, mesh: &gltf::json::Mesh) -> u64 {
    let positions = |primitive: &Primitive| Some(primitive.attributes.get(&Checked::Valid(Semantic::Positions))?.value());
    let counts = mesh.primitives.iter().filter_map(|primitive| root.accessors.get(positions(primitive)?)).map(|a| a.count.0);
    counts.fold(0, u64::saturating_add)
}

fn transform_of(node: &scene::Node) -> Mat4 {
    if let Some(matrix) = &node.matrix {
        return Mat4::from_cols_array(matrix);
    }
    let scale = node.scale.map_or(Vec3::ONE, Vec3::from_array);
    let translation = node.translation.map_or(Vec3::ZERO, Vec3::from_array);
    // A rotation of no length means none.
    let rotation = node.rotation.map_or(Quat::IDENTITY, |q| Quat::from_array(q.0));
    let rotation = if rotation.length_squared() > 0.0 { rotation.normalize() } else { Quat::IDENTITY };
    Mat4::from_scale_rotation_translation(scale, rotation, translation)
}

struct Reader<'a> {
    file: &'a Path,
    root: &'a Root,
    accessors: Accessors<'a>,
    warnings: Vec<String>,
}

impl Reader<'_> {
    /// Adds all triangles of mesh `number` to `whole`, moved by `transform`.
    fn append_mesh(
        &mut self,
        whole: &mut Mesh,
        number: usize,
        transform: Mat4,
        progress: Progress<'_>,
    ) -> Result<(), AssetError> {
        let Some(mesh) = self.root.meshes.get(number) else {
            let problem = format!("expected a number below {}, found {number}", self.root.meshes.len());
            return Err(AssetError::malformed(self.file, "node.mesh", problem));
        };
        for (k, primitive) in mesh.primitives.iter().enumerate() {
            let place = format!("mesh {number}, primitive {k}");
            let Some(mut part) = self.read_primitive(primitive, &place)? else { continue };
            if whole.triangles.len() + part.triangles.len() > MAX_TRIANGLES {
                let problem = format!("expected at most {MAX_TRIANGLES} triangles, found more");
                return Err(AssetError::too_large(self.file, problem));
            }
            place_in_world(&mut part, transform);
            let (part, notes) = part.complete_telling(progress);
            self.warnings.extend(notes.into_iter().map(|note| format!("{place}: {note}")));
            append(whole, part);
        }
        Ok(())
    }

    /// The triangles of a primitive as stored; `None` if it holds points or lines.
    fn read_primitive(&mut self, primitive: &Primitive, place: &str) -> Result<Option<Mesh>, AssetError> {
        let mode = match primitive.mode {
            Checked::Valid(mode) => mode,
            Checked::Invalid => {
                return Err(AssetError::malformed(self.file, format!("{place}, mode"), "expected a number from 0 to 6"));
            }
        };
        if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            self.warnings.push(format!("{place}: points and lines were left out."));
            return Ok(None);
        }
        if primitive.targets.as_ref().is_some_and(|targets| !targets.is_empty()) {
            self.warnings.push(format!("{place}: morph targets were left out."));
        }
        let find = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).map(|accessor| accessor.value());
        let Some(positions) = find(Semantic::Positions) else {
            return Err(AssetError::malformed(self.file, place, "expected the attribute POSITION, found none"));
        };
        let mut mesh = Mesh::default();
        let name = |attribute: &str| format!("{place}, {attribute}");
        mesh.positions = self.accessors.floats::<3>(positions, &name("POSITION"))?.into_iter().map(Vec3::from).collect();
        if let Some(normals) = find(Semantic::Normals) {
            mesh.normals = self.accessors.floats::<3>(normals, &name("NORMAL"))?.into_iter().map(Vec3::from).collect();
            // Tangents mean nothing without normals.
            if let Some(tangents) = find(Semantic::Tangents) {
                let tangents = self.accessors.floats::<4>(tangents, &name("TANGENT"))?;
                mesh.tangents = tangents.into_iter().map(Vec4::from).collect();
            }
        }
        if let Some(uvs) = find(Semantic::TexCoords(0)) {
            mesh.uvs = self.accessors.floats::<2>(uvs, &name("TEXCOORD_0"))?.into_iter().map(Vec2::from).collect();
        }
        let count = mesh.positions.len();
        for (found, attribute) in
            [(mesh.normals.len(), "NORMAL"), (mesh.tangents.len(), "TANGENT"), (mesh.uvs.len(), "TEXCOORD_0")]
        {
            if found != 0 && found != count {
                let problem = format!("expected {count} elements, as POSITION has, found {found}");
                return Err(AssetError::malformed(self.file, name(attribute), problem));
            }
        }
        let indices = match primitive.indices {
            Some(accessor) => self.accessors.indices(accessor.value(), &name("indices"))?,
            None => (0..u32::try_from(count).unwrap_or(u32::MAX)).collect(),
        };
        if let Some(index) = indices.iter().find(|&&index| index as usize >= count) {
            let problem = format!("expected vertex numbers below {count}, found {index}");
            return Err(AssetError::malformed(self.file, name("indices"), problem));
        }
        mesh.triangles = triangles(mode, &indices);
        Ok(Some(mesh))
    }
}

/// The corners of each triangle; incomplete ones at the end are left out.
fn triangles(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => {
            let corners = indices.windows(3).enumerate();
            corners.map(|(k, t)| if k % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] }).collect()
        }
        Mode::TriangleFan => {
            indices.first().map_or_else(Vec::new, |&hub| indices[1..].windows(2).map(|edge| [hub, edge[0], edge[1]]).collect())
        }
        _ => indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
    }
}

/// Moves a mesh. A mirroring transform turns the triangles round, so that they still face outwards.
fn place_in_world(mesh: &mut Mesh, transform: Mat4) {
    if transform == Mat4::IDENTITY {
        return;
    }
    let affine = Affine3A::from_mat4(transform);
    let linear = Mat3::from(affine.matrix3);
    let is_mirrored = linear.determinant() < 0.0;
    let sign = if is_mirrored { -1.0 } else { 1.0 };
    // The cofactors are the inverse transpose times the determinant: finite for flat transforms as well.
    let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis];
    let cofactors = Mat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * sign;
    for p in &mut mesh.positions {
        *p = affine.transform_point3(*p);
    }
    for n in &mut mesh.normals {
        // Scaled first: the cofactors of a model in micrometres would vanish in f32 when squared.
        let moved = cofactors * *n;
        *n = (moved / moved.abs().max_element().max(f32::MIN_POSITIVE)).normalize_or_zero();
    }
    for t in &mut mesh.tangents {
        *t = (linear * t.truncate()).normalize_or_zero().extend(t.w * sign);
    }
    if is_mirrored {
        for t in &mut mesh.triangles {
            t.swap(1, 2);
        }
    }
}

/// Adds a complete mesh to another.
fn append(whole: &mut Mesh, part: Mesh) {
    let first = whole.positions.len() as u32;
    whole.positions.extend(part.positions);
    whole.normals.extend(part.normals);
    whole.tangents.extend(part.tangents);
    whole.uvs.extend(part.uvs);
    whole.triangles.extend(part.triangles.into_iter().map(|t| t.map(|i| first + i)));
}

//! Meshes of files: of their own formats as the assets read them, and out of USD.

use super::open::usd_scene;
use super::{ExchangeError, Format};
use burnish_assets::{AssetError, Mesh, Model, Part, Progress, Role};
use burnish_material::exchange::usd::FoundMesh;
use glam::{Vec2, Vec3};
use std::path::Path;

/// True if [`load_mesh`] reads files with such a name: `.gltf`, `.glb`, `.ply`, `.usda`, `.usdz`, in any case.
pub fn is_mesh_path(path: &Path) -> bool {
    burnish_assets::is_model_path(path) || is_usd(path)
}

fn is_usd(path: &Path) -> bool {
    matches!(Format::of(path), Some(Format::Usda | Format::Usdz))
}

/// All meshes of a file as one, and sentences about what was strange.
pub fn load_mesh(path: &Path, progress: Progress<'_>) -> Result<(Model, Vec<String>), ExchangeError> {
    if is_usd(path) {
        return usd_model(path, usd_scene(path)?.0.meshes).ok_or_else(|| ExchangeError::NoMesh { path: path.to_path_buf() });
    }
    burnish_assets::load_model_with(path, progress).map_err(|error| match error {
        AssetError::Ended { .. } => ExchangeError::Cancelled,
        AssetError::Empty { file, .. } => ExchangeError::NoMesh { path: file },
        error => ExchangeError::Mesh(error),
    })
}

/// All meshes of a layer as one; `None` if there is no triangle.
pub(super) fn usd_model(path: &Path, meshes: Vec<FoundMesh>) -> Option<(Model, Vec<String>)> {
    let mut mesh = Mesh::default();
    let have = |of: fn(&FoundMesh) -> bool| meshes.iter().all(of);
    let (has_normals, has_uvs) = (have(|mesh| mesh.normals.is_some()), have(|mesh| mesh.uvs.is_some()));
    for found in meshes {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(found.positions.into_iter().map(Vec3::from));
        mesh.normals.extend(found.normals.into_iter().flatten().filter(|_| has_normals).map(Vec3::from));
        // The lower left corner there, the upper left one here.
        mesh.uvs.extend(found.uvs.into_iter().flatten().filter(|_| has_uvs).map(|[u, v]| Vec2::new(u, 1.0 - v)));
        mesh.triangles.extend(found.triangles.into_iter().map(|triangle| triangle.map(|vertex| first + vertex)));
    }
    let (mut mesh, notes) = mesh.complete();
    let name = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    mesh.name.clone_from(&name);
    let parts = vec![Part { role: Role::Object, mesh }];
    (!parts[0].mesh.triangles.is_empty()).then_some((Model { name, parts, unit_mm: Some(1000.0) }, notes))
}

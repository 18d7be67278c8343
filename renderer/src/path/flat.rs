//! Geometry and light as plain arrays: what a graphics device needs to trace the same scene.

use super::displace::Relief;
use super::geometry::Geometry;
use super::light::LightTables;
use super::mip::Sources;
use crate::bvh::FlatTree;
use crate::scene::Scene;
use glam::Vec3;
use std::sync::Arc;

/// A scene's triangles and where its light comes from, without materials. Lengths are normalised units (`geometry`).
#[derive(Debug)]
pub(crate) struct Flat {
    geometry: Arc<Geometry>,
    light: Arc<LightTables>,
    /// The tree.
    pub tree: FlatTree,
    /// Places of the vertices and the object of each triangle.
    pub triangles: Vec<[u32; 4]>,
}

/// The table that directions to the light are drawn from, as one array.
pub(crate) struct FlatLight {
    /// Rows of cells.
    pub rows: usize,
    /// Columns of cells.
    pub columns: usize,
    /// Cumulative shares of the rows, `rows + 1`; those of the columns of each row, `columns + 1` each; densities over the unit square by cell.
    pub values: Vec<f32>,
}

impl Flat {
    /// Flattens a scene; what has not changed since `previous` is taken from there.
    pub fn new(scene: &Scene, previous: Option<&Self>) -> Self {
        let geometry = match previous.filter(|p| p.geometry.is_of(scene)) {
            Some(previous) => previous.geometry.clone(),
            None => Arc::new(Geometry::new(scene, &mut Sources::default())),
        };
        let light = match previous.filter(|p| p.light.is_of(&scene.environment.map)) {
            Some(previous) => previous.light.clone(),
            None => Arc::new(LightTables::new(&scene.environment.map)),
        };
        let corners: Vec<[Vec3; 3]> = geometry
            .triangles
            .iter()
            .map(|t| [t[0], t[1], t[2]].map(|i| Vec3::from_slice(&geometry.vertices[i as usize][..3])))
            .collect();
        Self { tree: FlatTree::new(&corners), triangles: geometry.triangles.clone(), geometry, light }
    }

    /// Whether the triangles are those of another.
    pub fn has_geometry_of(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.geometry, &other.geometry)
    }

    /// Whether the light is that of another.
    pub fn has_light_of(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.light, &other.light)
    }

    /// Whether geometry and light are those of a scene.
    pub fn is_of(&self, scene: &Scene) -> bool {
        self.geometry.is_of(scene) && self.light.is_of(&scene.environment.map)
    }

    /// Position, normal, tangent with handedness, texture coordinate of every vertex.
    pub fn vertices(&self) -> &[[f32; 12]] {
        &self.geometry.vertices
    }

    /// The table of the light; `None` where nothing is brighter than the mean.
    pub fn light(&self) -> Option<FlatLight> {
        self.light.flat()
    }

    /// Normalised units per scene unit.
    pub fn scale(&self) -> f64 {
        self.geometry.scale
    }

    /// A scene point in normalised units.
    pub fn normalized(&self, p: Vec3) -> Vec3 {
        self.geometry.normalized(p)
    }

    /// How the height map of an object shows: 0 not at all, 1 in its normals, 2 in its triangles as well.
    pub fn relief(&self, object: usize) -> f32 {
        match self.geometry.reliefs.get(object) {
            Some(Relief::Bumped(_)) => 1.0,
            Some(Relief::Displaced(_)) => 2.0,
            _ => 0.0,
        }
    }

    /// The object that holds a scene point, if any.
    pub fn object_around(&self, p: Vec3) -> Option<u32> {
        self.geometry.object_around(self.normalized(p))
    }
}

//! What is drawn: objects with their materials, light from all around, a camera. The one input of both renderers.
//!
//! A scene is immutable and cheap to clone; heavy parts are shared. Exposure and display transform are not part of it:
//! they act on finished pictures (`tonemap`).

use burnish_assets::{BackdropDef, Bounds, Environment, Image, Mesh, Model, Role};
use burnish_material::{DEFAULT_UNIT_MM, Material, Property, Value};
use glam::{DQuat, Vec3};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Images by the path that the material file names.
pub type TextureSet = BTreeMap<String, Arc<Image>>;

/// Everything that both renderers need.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Bodies, each with one material.
    pub objects: Vec<Object>,
    /// Light from all directions.
    pub environment: EnvironmentLight,
    /// Point of view.
    pub camera: Camera,
    /// Scattering events after the camera ray's first hit, at most.
    pub max_bounces: u32,
}

/// A mesh and its material.
#[derive(Clone, Debug)]
pub struct Object {
    /// Geometry in scene units.
    pub mesh: Arc<Mesh>,
    /// Surface and interior.
    pub material: Arc<Material>,
    /// Images that the material refers to.
    pub textures: Arc<TextureSet>,
    /// Whether this object carries the material that is being edited.
    pub is_document: bool,
    /// Scene units per unit of the material's lengths.
    pub length_scale: f64,
}

/// An environment map, turned and scaled.
#[derive(Clone, Debug)]
pub struct EnvironmentLight {
    /// Radiance map.
    pub map: Arc<Environment>,
    /// Counterclockwise rotation about +Y seen from above, degrees.
    pub rotation_deg: f32,
    /// Factor on the map's radiance.
    pub scale: f32,
}

/// A pinhole camera. The field of view is vertical.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position.
    pub origin: Vec3,
    /// Point in the middle of the picture.
    pub target: Vec3,
    /// Up direction, not parallel to the view.
    pub up: Vec3,
    /// Full vertical angle, degrees.
    pub fov_deg: f32,
}

/// An orthonormal camera basis with half extents of the picture at distance 1.
#[derive(Clone, Copy, Debug)]
pub struct CameraBasis {
    /// Position.
    pub origin: Vec3,
    /// Unit, to the right of the picture, times half its width at distance 1.
    pub right: Vec3,
    /// Unit, up in the picture, times half its height at distance 1.
    pub up: Vec3,
    /// Unit, into the picture.
    pub forward: Vec3,
}

impl Camera {
    /// A camera on a sphere about `target`: azimuth 0 looks along -Z from +Z, elevation 90 looks down. Degrees.
    pub fn orbit(target: Vec3, azimuth_deg: f32, elevation_deg: f32, distance: f32, fov_deg: f32) -> Self {
        let (sa, ca) = azimuth_deg.to_radians().sin_cos();
        let (se, ce) = elevation_deg.clamp(-89.9, 89.9).to_radians().sin_cos();
        Self { origin: target + distance * Vec3::new(sa * ce, se, ca * ce), target, up: Vec3::Y, fov_deg }
    }

    /// Axes for a picture of this aspect (width over height). The picture's +x is `cross(forward, up)`.
    pub fn basis(&self, aspect: f32) -> CameraBasis {
        let forward = (self.target - self.origin).try_normalize().unwrap_or(Vec3::NEG_Z);
        let side = forward.cross(self.up).try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
        let half = (self.fov_deg.clamp(0.1, 179.0).to_radians() * 0.5).tan();
        CameraBasis { origin: self.origin, right: side * half * aspect, up: side.cross(forward) * half, forward }
    }
}

impl CameraBasis {
    /// Unit direction through a point of the picture; `x`, `y` in `[0, 1]`, `y` downwards.
    pub fn direction(&self, x: f32, y: f32) -> Vec3 {
        (self.forward + (2.0 * x - 1.0) * self.right + (1.0 - 2.0 * y) * self.up).normalize()
    }
}

impl EnvironmentLight {
    /// World direction into the map's own frame.
    pub fn map_from_world(&self, d: Vec3) -> Vec3 {
        let (s, c) = self.rotation_deg.to_radians().sin_cos();
        Vec3::new(c * d.x - s * d.z, d.y, s * d.x + c * d.z)
    }

    /// Direction in the map's own frame into the world.
    pub fn world_from_map(&self, d: Vec3) -> Vec3 {
        let (s, c) = self.rotation_deg.to_radians().sin_cos();
        Vec3::new(c * d.x + s * d.z, d.y, -s * d.x + c * d.z)
    }

    /// Radiance that arrives from world direction `d` (unit, away from the scene).
    pub fn radiance(&self, d: Vec3) -> Vec3 {
        self.map.lookup(self.map_from_world(d)) * self.scale
    }
}

/// Where the camera stands at first: slightly above, looking at the object.
pub const DEFAULT_ELEVATION_DEG: f32 = 14.0;
/// Vertical field of view at first.
pub const DEFAULT_FOV_DEG: f32 = 32.0;
/// Bounces unless a scene says otherwise.
pub const DEFAULT_MAX_BOUNCES: u32 = 16;

impl Scene {
    /// A model under an environment, seen so that the object fills the picture.
    ///
    /// `scene_unit_mm` is the size of a scene unit; the material's lengths are converted by it.
    pub fn of_model(
        model: &ModelMeshes,
        material: Arc<Material>,
        textures: Arc<TextureSet>,
        environment: EnvironmentLight,
        scene_unit_mm: f64,
    ) -> Self {
        let objects = model
            .parts
            .iter()
            .map(|(role, mesh)| match role {
                Role::Object => Object {
                    mesh: mesh.clone(),
                    length_scale: material.unit_mm() / scene_unit_mm,
                    material: material.clone(),
                    textures: textures.clone(),
                    is_document: true,
                },
                role => Object {
                    mesh: mesh.clone(),
                    length_scale: 1.0,
                    material: stage_material(*role),
                    textures: Arc::default(),
                    is_document: false,
                },
            })
            .collect();
        Self { objects, environment, camera: model.default_camera(), max_bounces: DEFAULT_MAX_BOUNCES }
    }

    /// The scene with the objects that carry the edited material (all, if none does) turned counterclockwise, seen from above, about the vertical
    /// through their middle. At 0 degrees, the same meshes.
    #[must_use]
    pub fn turned(&self, deg: f64) -> Self {
        let (mut scene, middle) = (self.clone(), self.document_bounds().center().as_dvec3());
        let rotation = DQuat::from_rotation_y(deg.to_radians());
        let has_document = scene.objects.iter().any(|object| object.is_document);
        for object in scene.objects.iter_mut().filter(|object| deg != 0.0 && (object.is_document || !has_document)) {
            let mesh = Arc::make_mut(&mut object.mesh);
            for p in &mut mesh.positions {
                *p = (rotation * (p.as_dvec3() - middle) + middle).as_vec3();
            }
            for n in &mut mesh.normals {
                *n = (rotation * n.as_dvec3()).as_vec3();
            }
            for t in &mut mesh.tangents {
                *t = (rotation * t.truncate().as_dvec3()).as_vec3().extend(t.w);
            }
        }
        scene
    }

    /// Bounds of the objects that carry the edited material; of everything if there is none.
    pub fn document_bounds(&self) -> Bounds {
        let of =
            |all: bool| self.objects.iter().filter(|o| all || o.is_document).map(|o| o.mesh.bounds()).reduce(|a, b| a.union(b));
        of(false).or_else(|| of(true)).unwrap_or(Bounds { min: Vec3::NEG_ONE, max: Vec3::ONE })
    }
}

/// A model with its meshes shared, so that scenes can be made again and again without copying geometry.
#[derive(Clone, Debug)]
pub struct ModelMeshes {
    /// Name shown to users.
    pub name: String,
    /// Meshes with what they are for.
    pub parts: Vec<(Role, Arc<Mesh>)>,
    /// Millimetres per scene unit.
    pub unit_mm: f64,
    /// Bounds of the object parts.
    pub object_bounds: Bounds,
}

impl From<Model> for ModelMeshes {
    fn from(model: Model) -> Self {
        let object_bounds = model.object_bounds();
        Self {
            name: model.name,
            unit_mm: model.unit_mm.unwrap_or(DEFAULT_UNIT_MM),
            parts: model.parts.into_iter().map(|part| (part.role, Arc::new(part.mesh))).collect(),
            object_bounds,
        }
    }
}

impl ModelMeshes {
    /// The same on another backdrop; what was floor before is left out.
    #[must_use]
    pub fn on(&self, backdrop: &BackdropDef) -> Self {
        let parts = backdrop.parts(self.parts.iter().map(|(role, mesh)| (*role, mesh.bounds())));
        let mut model = self.clone();
        model.parts.retain(|(role, _)| !role.is_floor());
        model.parts.extend(parts.into_iter().map(|part| (part.role, Arc::new(part.mesh))));
        model
    }

    /// A camera that frames the object.
    pub fn default_camera(&self) -> Camera {
        let half = (self.object_bounds.size() * 0.5).max_element().max(1e-6);
        let distance = 1.5 * half / (DEFAULT_FOV_DEG.to_radians() * 0.5).sin();
        // A little below the middle, so that what the object stands on is in the picture.
        let target = self.object_bounds.center() - Vec3::Y * (0.12 * half);
        Camera::orbit(target, 0.0, DEFAULT_ELEVATION_DEG, distance, DEFAULT_FOV_DEG)
    }
}

/// The fixed material of a part that is not being edited: matt, without reflection.
fn stage_material(role: Role) -> Arc<Material> {
    let color = match role {
        Role::Stand => [0.08, 0.08, 0.085],
        Role::FloorLight => [0.18, 0.18, 0.18],
        Role::FloorDark => [0.13, 0.13, 0.135],
        Role::Sweep => [0.25, 0.25, 0.25],
        Role::Object => [0.5; 3],
    };
    let mut material = Material::named("stage");
    material.set(Property::base_color, Value::Color(color));
    material.set(Property::roughness, Value::Float(1.0));
    material.set(Property::specular_level, Value::Float(0.0));
    Arc::new(material)
}

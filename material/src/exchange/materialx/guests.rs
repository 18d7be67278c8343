//! Surfaces of MaterialX that come from other formats: glTF's and USD's. They are read here; their own formats write them.

use super::super::formulas as f;
use crate::exchange::interpreting::{default_inputs, emission, turn, unit};
use crate::exchange::model::{Context, Notes, ShadingModel};
use crate::properties::Inputs;

/// Index of refraction of the coat in both models.
const COAT_IOR: f64 = 1.5;
const MASK: &str = "opacity: cut off at a threshold there; a value is cut off here too, an image is taken as it is";

crate::shading_fields! {
    /// Parameters of `gltf_pbr` 2.0.1.
    GltfPbr {
        base_color: Color([1.0; 3]), "base_color", from [], to [base_color, absorption_color], image;
        metallic: Float(1.0), "metallic", from [], to [metallic], image;
        roughness: Float(1.0), "roughness", from [], to [roughness, anisotropy], image;
        normal: Normal([0.0, 0.0, 1.0]), "normal", from [], to [normal], image;
        normal_scale: Float(1.0), "normal.scale", from [], to [normal_scale], uniform;
        occlusion: Float(1.0), "occlusion", from [], to [ambient_occlusion], image;
        transmission: Float(0.0), "transmission", from [], to [translucency, absorption_color], image;
        specular: Float(1.0), "specular", from [], to [specular_level], image;
        specular_color: Color([1.0; 3]), "specular_color", from [], to [specular_edge_color, specular_level], image;
        ior: Float(1.5), "ior", from [], to [specular_ior], uniform;
        alpha: Float(1.0), "alpha", from [], to [opacity], image;
        /// 0 opaque, 1 mask, 2 blend.
        alpha_mode: Float(0.0), "alpha_mode", from [], to [opacity], uniform;
        alpha_cutoff: Float(0.5), "alpha_cutoff", from [], to [opacity], uniform;
        sheen_color: Color([0.0; 3]), "sheen_color", from [], to [sheen, sheen_color], image;
        sheen_roughness: Float(0.0), "sheen_roughness", from [], to [sheen_roughness], image;
        clearcoat: Float(0.0), "clearcoat", from [], to [coat, coat_ior], image;
        clearcoat_roughness: Float(0.0), "clearcoat_roughness", from [], to [coat_roughness], image;
        clearcoat_normal: Normal([0.0, 0.0, 1.0]), "clearcoat_normal", from [], to [coat_normal], image;
        clearcoat_normal_scale: Float(1.0), "clearcoat_normal.scale", from [], to [coat_normal_scale], uniform;
        emissive: Color([0.0; 3]), "emissive", from [], to [emission, emission_color], image;
        emissive_strength: Float(1.0), "emissive_strength", from [], to [emission], uniform;
        thickness: Float(0.0), "thickness", from [], to [volume_thickness_scale], uniform;
        /// 0 where the file says nothing: no absorption.
        attenuation_distance: Float(0.0), "attenuation_distance", from [], to [absorption_distance], uniform;
        attenuation_color: Color([1.0; 3]), "attenuation_color", from [], to [absorption_color], image;
        anisotropy_strength: Float(0.0), "anisotropy_strength", from [], to [anisotropy], image;
        /// Radians, counterclockwise.
        anisotropy_rotation: Float(0.0), "anisotropy_rotation", from [], to [anisotropy_rotation], image;
        dispersion: Float(0.0), "dispersion", from [], to [dispersion], uniform;
        displacement: Float(0.0), "displacement", from [], to [height], image;
        displacement_scale: Float(1.0), "displacement.scale", from [], to [height_scale], uniform;
    }
}

/// glTF's surface.
pub const GLTF_PBR: ShadingModel = ShadingModel {
    name: "gltf_pbr",
    label: "glTF",
    fields: GltfPbr::FIELDS,
    cells: &[],
    translate: |_, _| GltfPbr::from_values(&[]).to_values(),
    interpret: |values, _, notes| interpret_gltf(&GltfPbr::from_values(values), notes),
};

fn interpret_gltf(p: &GltfPbr, notes: &mut Notes) -> Inputs<f64> {
    let mut i = default_inputs();
    i.base_color = p.base_color.map(|c| unit("base_color", c, notes));
    i.metallic = unit("metallic", p.metallic, notes);
    i.roughness = unit("roughness", p.roughness, notes);
    let alpha = i.roughness * i.roughness;
    let strength = unit("anisotropy_strength", p.anisotropy_strength, notes);
    i.anisotropy = ((1.0 - alpha) * strength * strength).powf(0.25);
    i.anisotropy_rotation = turn(p.anisotropy_rotation / std::f64::consts::TAU);
    (i.normal, i.normal_scale) = (p.normal, p.normal_scale);
    i.ambient_occlusion = unit("occlusion", p.occlusion, notes);
    let above = f::largest(p.specular_color).max(1.0);
    i.specular_edge_color = p.specular_color.map(|c| unit("specular_color", c / above, notes));
    i.specular_level = (0.5 * p.specular.max(0.0) * above).min(1.0);
    i.specular_ior = p.ior.max(1.0);
    i.opacity = match p.alpha_mode {
        0.0 => 1.0,
        1.0 => {
            if p.alpha >= p.alpha_cutoff {
                1.0
            } else {
                0.0
            }
        }
        _ => unit("alpha", p.alpha, notes),
    };
    if p.alpha_mode == 1.0 {
        notes.push(MASK.to_owned());
    }
    (i.sheen, i.sheen_color) = f::split_amount(p.sheen_color.map(|c| unit("sheen_color", c, notes)));
    i.sheen_roughness = unit("sheen_roughness", p.sheen_roughness, notes);
    i.coat = unit("clearcoat", p.clearcoat, notes);
    i.coat_roughness = unit("clearcoat_roughness", p.clearcoat_roughness, notes);
    if i.coat > 0.0 {
        i.coat_ior = COAT_IOR;
    }
    (i.coat_normal, i.coat_normal_scale) = (p.clearcoat_normal, p.clearcoat_normal_scale);
    if f::largest(p.emissive) > 0.0 {
        (i.emission, i.emission_color) = (p.emissive_strength.max(0.0), p.emissive);
    }
    i.dispersion = p.dispersion.clamp(0.0, 20.0);
    i.translucency = unit("transmission", p.transmission, notes);
    if i.translucency > 0.0 {
        if p.thickness <= 0.0 {
            notes.push(
                "thickness: without one the surface is a thin wall, which ASM has not; it became a body without absorption"
                    .to_owned(),
            );
            i.absorption_color = i.base_color;
        } else if p.attenuation_distance > 0.0 {
            i.absorption_color = p.attenuation_color.map(|c| unit("attenuation_color", c, notes));
            i.absorption_distance = p.attenuation_distance;
            if i.base_color != [1.0; 3] {
                notes.push("base_color: here it does not tint the light that goes through".to_owned());
            }
        } else {
            i.absorption_color = i.base_color;
        }
        i.volume_thickness_scale = if p.thickness > 0.0 { p.thickness } else { i.volume_thickness_scale };
    }
    i.height = p.displacement + i.height_level;
    i.height_scale = p.displacement_scale;
    i
}

crate::shading_fields! {
    /// Parameters of `UsdPreviewSurface` 2.6.
    PreviewSurface {
        diffuse_color: Color([0.18; 3]), "diffuseColor", from [], to [base_color], image;
        emissive_color: Color([0.0; 3]), "emissiveColor", from [], to [emission, emission_color], image;
        use_specular_workflow: Float(0.0), "useSpecularWorkflow", from [], to [metallic, specular_level, specular_edge_color, specular_ior], uniform;
        specular_color: Color([0.0; 3]), "specularColor", from [], to [specular_level, specular_edge_color], image;
        metallic: Float(0.0), "metallic", from [], to [metallic], image;
        roughness: Float(0.5), "roughness", from [], to [roughness], image;
        clearcoat: Float(0.0), "clearcoat", from [], to [coat, coat_ior], image;
        clearcoat_roughness: Float(0.01), "clearcoatRoughness", from [], to [coat_roughness], image;
        opacity: Float(1.0), "opacity", from [], to [opacity], image;
        opacity_mode: Float(0.0), "opacityMode", from [], to [], uniform;
        opacity_threshold: Float(0.0), "opacityThreshold", from [], to [opacity], uniform;
        ior: Float(1.5), "ior", from [], to [specular_ior], uniform;
        normal: Normal([0.0, 0.0, 1.0]), "normal", from [], to [normal], image;
        normal_scale: Float(1.0), "normal.scale", from [], to [normal_scale], uniform;
        displacement: Float(0.0), "displacement", from [], to [height], image;
        occlusion: Float(1.0), "occlusion", from [], to [ambient_occlusion], image;
    }
}

/// USD's surface.
pub const PREVIEW_SURFACE: ShadingModel = ShadingModel {
    name: "UsdPreviewSurface",
    label: "UsdPreviewSurface",
    fields: PreviewSurface::FIELDS,
    cells: &[],
    translate: |_, _| PreviewSurface::from_values(&[]).to_values(),
    interpret: |values: &[crate::Value], _: &Context, notes| interpret_preview(&PreviewSurface::from_values(values), notes),
};

fn interpret_preview(p: &PreviewSurface, notes: &mut Notes) -> Inputs<f64> {
    let mut i = default_inputs();
    i.base_color = p.diffuse_color.map(|c| unit("diffuseColor", c, notes));
    i.roughness = unit("roughness", p.roughness, notes);
    i.specular_ior = p.ior.max(1.0);
    if p.use_specular_workflow == 0.0 {
        i.metallic = unit("metallic", p.metallic, notes);
    } else {
        let f0 = p.specular_color.map(|c| unit("specularColor", c, notes));
        (i.specular_ior, i.specular_level, i.specular_edge_color) = f::dielectric_of_f0(f0);
    }
    i.coat = unit("clearcoat", p.clearcoat, notes);
    i.coat_roughness = unit("clearcoatRoughness", p.clearcoat_roughness, notes);
    if i.coat > 0.0 {
        i.coat_ior = COAT_IOR;
    }
    i.opacity = unit("opacity", p.opacity, notes);
    if p.opacity_threshold > 0.0 {
        i.opacity = if i.opacity >= p.opacity_threshold { 1.0 } else { 0.0 };
        notes.push(MASK.to_owned());
    }
    (i.emission, i.emission_color) = emission(p.emissive_color);
    (i.normal, i.normal_scale) = (p.normal, p.normal_scale);
    i.ambient_occlusion = unit("occlusion", p.occlusion, notes);
    i.height = p.displacement + i.height_level;
    i
}

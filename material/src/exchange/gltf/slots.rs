//! The places for images in a glTF material: which parameters each holds, in which channels.

use crate::exchange::field::FieldDef;
use crate::exchange::models::gltf::Gltf;
use crate::slot::Channel;

/// A place for an image. Constant data.
#[derive(Debug)]
pub(super) struct Slot {
    /// Its place in the material, as the names of parameters are.
    pub name: &'static str,
    /// End of the name of an image that is made for it alone.
    pub suffix: &'static str,
    /// End of the name of an image that it shares: slots of one group have different channels.
    pub group: &'static str,
    /// Whether red, green and blue are stored by the sRGB curve.
    pub is_srgb: bool,
    /// Parameters and their channels.
    pub parts: &'static [(&'static str, Channel)],
}

pub(super) const BASE_COLOR: &str = "pbrMetallicRoughness.baseColorFactor";
pub(super) const ALPHA: &str = "pbrMetallicRoughness.baseColorFactor.alpha";
pub(super) const METALLIC: &str = "pbrMetallicRoughness.metallicFactor";
pub(super) const ROUGHNESS: &str = "pbrMetallicRoughness.roughnessFactor";
pub(super) const OCCLUSION: &str = "occlusionTexture";
pub(super) const EMISSIVE: &str = "emissiveFactor";
pub(super) const STRENGTH: &str = "KHR_materials_emissive_strength.emissiveStrength";
pub(super) const IOR: &str = "KHR_materials_ior.ior";
pub(super) const SPECULAR: &str = "KHR_materials_specular.specularFactor";
pub(super) const SPECULAR_COLOR: &str = "KHR_materials_specular.specularColorFactor";
pub(super) const ROTATION: &str = "KHR_materials_anisotropy.anisotropyRotation";
pub(super) const ANISOTROPY: &str = "KHR_materials_anisotropy.anisotropyStrength";
pub(super) const SHEEN: &str = "KHR_materials_sheen.sheenColorFactor";
pub(super) const SHEEN_IMAGE: &str = "KHR_materials_sheen.sheenColorTexture.factor";
pub(super) const SHEEN_ROUGHNESS: &str = "KHR_materials_sheen.sheenRoughnessFactor";
pub(super) const TRANSMISSION: &str = "KHR_materials_transmission.transmissionFactor";
pub(super) const DISPERSION: &str = "KHR_materials_dispersion.dispersion";
pub(super) const THICKNESS: &str = "KHR_materials_volume.thicknessTexture";
pub(super) const THICKNESS_FACTOR: &str = "KHR_materials_volume.thicknessFactor";
pub(super) const ATTENUATION: &str = "KHR_materials_volume.attenuationDistance";
pub(super) const DIFFUSE: &str = "KHR_materials_diffuse_transmission.diffuseTransmissionFactor";
pub(super) const DIFFUSE_COLOR: &str = "KHR_materials_diffuse_transmission.diffuseTransmissionColorFactor";
pub(super) const COAT: &str = "KHR_materials_clearcoat.clearcoatFactor";
pub(super) const COAT_ROUGHNESS: &str = "KHR_materials_clearcoat.clearcoatRoughnessFactor";
pub(super) const COAT_TINT: &str = "ADOBE_materials_clearcoat_tint.clearcoatTintFactor";
pub(super) const COAT_IOR: &str = "ADOBE_materials_clearcoat_specular.clearcoatIor";
pub(super) const ANISOTROPY_IMAGE: &str = "KHR_materials_anisotropy.anisotropyTexture";

/// All places, in the order of files.
pub(super) const SLOTS: &[Slot] = &[
    own("pbrMetallicRoughness.baseColorTexture", "base_color", true, &[(BASE_COLOR, Channel::Rgb), (ALPHA, Channel::A)]),
    shared(
        "pbrMetallicRoughness.metallicRoughnessTexture",
        ("metallic_roughness", "orm"),
        &[(ROUGHNESS, Channel::G), (METALLIC, Channel::B)],
    ),
    own("normalTexture", "normal", false, &[("normalTexture", Channel::Rgb)]),
    shared("occlusionTexture", ("occlusion", "orm"), &[(OCCLUSION, Channel::R)]),
    own("emissiveTexture", "emissive", true, &[(EMISSIVE, Channel::Rgb)]),
    shared("KHR_materials_specular.specularTexture", ("specular_level", "specular"), &[(SPECULAR, Channel::A)]),
    Slot {
        is_srgb: true,
        ..shared("KHR_materials_specular.specularColorTexture", ("specular_color", "specular"), &[(SPECULAR_COLOR, Channel::Rgb)])
    },
    // Red and green are the cosine and the sine of the rotation.
    own(ANISOTROPY_IMAGE, "anisotropy", false, &[(ROTATION, Channel::R), (ANISOTROPY, Channel::B)]),
    Slot { is_srgb: true, ..shared("KHR_materials_sheen.sheenColorTexture", ("sheen_color", "sheen"), &[(SHEEN, Channel::Rgb)]) },
    shared("KHR_materials_sheen.sheenRoughnessTexture", ("sheen_roughness", "sheen"), &[(SHEEN_ROUGHNESS, Channel::A)]),
    shared("KHR_materials_transmission.transmissionTexture", ("transmission", "body"), &[(TRANSMISSION, Channel::R)]),
    shared(THICKNESS, ("thickness", "body"), &[(THICKNESS, Channel::G)]),
    shared(
        "KHR_materials_diffuse_transmission.diffuseTransmissionTexture",
        ("scattering_amount", "scattering"),
        &[(DIFFUSE, Channel::A)],
    ),
    Slot {
        is_srgb: true,
        ..shared(
            "KHR_materials_diffuse_transmission.diffuseTransmissionColorTexture",
            ("scattering_color", "scattering"),
            &[(DIFFUSE_COLOR, Channel::Rgb)],
        )
    },
    shared("KHR_materials_clearcoat.clearcoatTexture", ("coat_amount", "coat"), &[(COAT, Channel::R)]),
    shared("KHR_materials_clearcoat.clearcoatRoughnessTexture", ("coat_roughness", "coat"), &[(COAT_ROUGHNESS, Channel::G)]),
    own(
        "KHR_materials_clearcoat.clearcoatNormalTexture",
        "coat_normal",
        false,
        &[("KHR_materials_clearcoat.clearcoatNormalTexture", Channel::Rgb)],
    ),
    own("ADOBE_materials_clearcoat_tint.clearcoatTintTexture", "coat_color", true, &[(COAT_TINT, Channel::Rgb)]),
    shared(
        "ADOBE_materials_clearcoat_specular.clearcoatSpecularTexture",
        ("coat_level", "coat"),
        &[("ADOBE_materials_clearcoat_specular.clearcoatSpecularFactor", Channel::B)],
    ),
];

const fn own(name: &'static str, suffix: &'static str, is_srgb: bool, parts: &'static [(&'static str, Channel)]) -> Slot {
    Slot { name, suffix, group: suffix, is_srgb, parts }
}

const fn shared(
    name: &'static str,
    (suffix, group): (&'static str, &'static str),
    parts: &'static [(&'static str, Channel)],
) -> Slot {
    Slot { name, suffix, group, is_srgb: false, parts }
}

/// A parameter's place in the table, and its row.
pub(super) fn field(name: &str) -> Option<(usize, &'static FieldDef)> {
    Gltf::FIELDS.iter().enumerate().find(|(_, def)| def.name == name)
}

/// Where the file holds the number of a parameter: not those that are made of others, nor images without a factor.
pub(super) fn is_number(def: &FieldDef) -> bool {
    !(def.name.ends_with("Texture") || def.name == SHEEN_IMAGE || def.name == ALPHA || def.name == BASE_COLOR)
}

/// Largest factor beside an image of a parameter: what 1 in the image means at most. `None`: there is no factor.
pub(super) fn most_factor(name: &str) -> Option<f64> {
    match name {
        SPECULAR_COLOR => Some(f64::from(f32::MAX)),
        OCCLUSION | "normalTexture" | "KHR_materials_clearcoat.clearcoatNormalTexture" => None,
        _ => Some(1.0),
    }
}

/// What 1 means in an image that is computed for a parameter.
pub(super) fn baked_factor(name: &str) -> f64 {
    // A level of 1 doubles the colour.
    if name == SPECULAR_COLOR { 2.0 } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_image_parameter_has_one_place() {
        for def in Gltf::FIELDS {
            let places = SLOTS.iter().flat_map(|slot| slot.parts).filter(|(name, _)| *name == def.name).count();
            assert_eq!(places, usize::from(def.takes_image), "{}", def.name);
        }
        assert!(SLOTS.iter().flat_map(|slot| slot.parts).all(|(name, _)| field(name).is_some()));
    }
}

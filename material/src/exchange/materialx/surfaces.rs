//! The surfaces of MaterialX that are read, and the shading model of each.

use super::guests;
use crate::exchange::model::ShadingModel;
use crate::exchange::models;

/// A surface of MaterialX.
pub struct Surface {
    /// Category of its node.
    pub node: &'static str,
    /// The model; its parameters have the names of the node's inputs.
    pub model: &'static ShadingModel,
}

/// All surfaces that are read. The first is what is written where nothing else is asked for.
pub const SURFACES: &[Surface] = &[
    Surface { node: "open_pbr_surface", model: &models::open_pbr::MODEL },
    Surface { node: "standard_surface", model: &models::standard_surface::MODEL },
    Surface { node: "gltf_pbr", model: &guests::GLTF_PBR },
    Surface { node: "UsdPreviewSurface", model: &guests::PREVIEW_SURFACE },
    Surface { node: "disney_principled", model: &models::disney_principled::MODEL },
];

/// The model of a node of this category.
pub fn model_of(node: &str) -> Option<&'static ShadingModel> {
    SURFACES.iter().find(|surface| surface.node == node).map(|surface| surface.model)
}

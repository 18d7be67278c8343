//! The surfaces of MaterialX, and the shading model of each.

use crate::exchange::model::ShadingModel;
use crate::exchange::models;

/// A surface of MaterialX.
pub struct Surface {
    /// Category of its node.
    pub node: &'static str,
    /// The model; its parameters have the names of the node's inputs.
    pub model: &'static ShadingModel,
}

/// USD's surface, whose normal is the direction itself and not a normal map.
pub const PREVIEW: &str = "UsdPreviewSurface";

/// All surfaces. The first is what is written where nothing else is asked for.
pub const SURFACES: &[Surface] = &[
    Surface { node: "open_pbr_surface", model: &models::open_pbr::MODEL },
    Surface { node: "standard_surface", model: &models::standard_surface::MODEL },
    Surface { node: "gltf_pbr", model: &models::gltf_pbr::MODEL },
    Surface { node: PREVIEW, model: &models::usd_preview::MODEL },
    Surface { node: "disney_principled", model: &models::disney_principled::MODEL },
];

/// The model of a node of this category.
pub fn model_of(node: &str) -> Option<&'static ShadingModel> {
    SURFACES.iter().find(|surface| surface.node == node).map(|surface| surface.model)
}

/// The category of the node of a model.
pub fn node_of(model: &ShadingModel) -> &'static str {
    SURFACES.iter().find(|surface| surface.model.name == model.name).map_or(SURFACES[0].node, |surface| surface.node)
}

/// The type of an input, where that is another than its value has here.
pub fn type_of_input(name: &str) -> Option<&'static str> {
    ["alpha_mode", "useSpecularWorkflow"].contains(&name).then_some("integer")
}

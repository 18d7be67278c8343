//! What several tests need: cases, scenes, quadrature, the GPU.

pub mod coverage;
pub mod exchange;
pub mod export_panel;
pub mod gpu;
pub mod library;
pub mod materials;
pub mod number;
pub mod quadrature;
pub mod scenes;
pub mod surface;
pub mod window;

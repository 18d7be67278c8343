//! What several tests need: cases, quadrature, statistics, the GPU.

pub mod materials;
pub mod quadrature;
pub mod scenes;

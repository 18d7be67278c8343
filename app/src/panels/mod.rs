//! The parts of the window, one file each. A panel edits the document or asks for something; it carries nothing out.

pub mod chart;
pub mod messages;
pub mod presets;
pub mod properties;
pub mod status;
pub mod viewport;

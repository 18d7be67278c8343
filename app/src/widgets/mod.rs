//! Controls that a property needs and egui does not have.

pub mod color_edit;
pub mod gesture;
pub mod number;
pub mod number_field;
pub mod row_notes;
pub mod search_field;
pub mod texture_slot;
pub mod track;
pub mod value_edit;

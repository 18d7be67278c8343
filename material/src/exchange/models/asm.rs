//! The Adobe Standard Material itself: parameters that are the properties, by their usage strings. For formats that hold properties one by one.

use super::super::field::FieldDef;
use super::super::loss::Cell;
use super::super::model::ShadingModel;
use crate::exchange::interpreting::default_inputs;
use crate::properties::{PROPERTIES, PROPERTY_COUNT};
use crate::value::Vary;

/// The Adobe Standard Material.
pub const MODEL: ShadingModel = ShadingModel {
    name: "adobe_standard_material",
    label: "Adobe Standard Material",
    fields: FIELDS,
    cells: CELLS,
    translate: |inputs, _| PROPERTIES.iter().map(|def| inputs.value(def.id)).collect(),
    interpret: |values, _, _| {
        let mut inputs = default_inputs();
        for (def, value) in PROPERTIES.iter().zip(values) {
            inputs.set(def.id, *value);
        }
        inputs
    },
};

const FIELDS: &[FieldDef] = &{
    let first = &PROPERTIES[0];
    let mut fields =
        [FieldDef { name: first.usage, default: first.default, from: &[], to: &[], takes_image: false }; PROPERTY_COUNT];
    let mut place = 0;
    while place < PROPERTY_COUNT {
        let def = &PROPERTIES[place];
        let itself = std::slice::from_ref(&def.id);
        let takes_image = !matches!(def.vary, Vary::Uniform);
        fields[place] = FieldDef { name: def.usage, default: def.default, from: itself, to: itself, takes_image };
        place += 1;
    }
    fields
};

const CELLS: &[Cell] = &{
    let mut cells = [Cell::dropped(PROPERTIES[0].id); PROPERTY_COUNT];
    let mut place = 0;
    while place < PROPERTY_COUNT {
        cells[place] = Cell::exact(PROPERTIES[place].id, PROPERTIES[place].usage);
        place += 1;
    }
    cells
};

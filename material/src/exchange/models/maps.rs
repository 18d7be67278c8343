//! The images of a texture set by metallic and roughness: every property that may vary over the surface, by its usage string.

use super::super::field::FieldDef;
use super::super::loss::{Cell, Fate};
use super::super::model::ShadingModel;
use crate::exchange::interpreting::default_inputs;
use crate::properties::{PROPERTIES, PROPERTY_COUNT};
use crate::value::{PropertyDef, Vary};

/// Metallic and roughness maps, and all others.
pub const MODEL: ShadingModel = ShadingModel {
    name: "metallic_roughness",
    label: "Metallic/Roughness Maps",
    fields: FIELDS,
    cells: CELLS,
    translate: |inputs, _| PROPERTIES.iter().filter(|def| has_map(def)).map(|def| inputs.value(def.id)).collect(),
    interpret: |values, _, _| {
        let mut inputs = default_inputs();
        for (def, value) in PROPERTIES.iter().filter(|def| has_map(def)).zip(values) {
            inputs.set(def.id, *value);
        }
        inputs
    },
};

const fn has_map(def: &PropertyDef) -> bool {
    !matches!(def.vary, Vary::Uniform)
}

const COUNT: usize = {
    let (mut count, mut place) = (0, 0);
    while place < PROPERTY_COUNT {
        count += has_map(&PROPERTIES[place]) as usize;
        place += 1;
    }
    count
};

const FIELDS: &[FieldDef] = &{
    let first = &PROPERTIES[0];
    let mut fields = [FieldDef { name: first.usage, default: first.default, from: &[], to: &[], takes_image: true }; COUNT];
    let (mut count, mut place) = (0, 0);
    while place < PROPERTY_COUNT {
        let def = &PROPERTIES[place];
        if has_map(def) {
            let itself = std::slice::from_ref(&def.id);
            fields[count] = FieldDef { name: def.usage, default: def.default, from: itself, to: itself, takes_image: true };
            count += 1;
        }
        place += 1;
    }
    fields
};

const CELLS: &[Cell] = &{
    let mut cells = [Cell::dropped(PROPERTIES[0].id); PROPERTY_COUNT];
    let mut place = 0;
    while place < PROPERTY_COUNT {
        let def = &PROPERTIES[place];
        cells[place] = match has_map(def) {
            true => {
                let fate = |_: &_| (Fate::Remapped, "as an image; 8 bits for each number where it has to be computed");
                Cell { property: def.id, target: def.usage, fate }
            }
            false => {
                let fate = |_: &_| (Fate::Dropped, "one value for the whole material, which no image holds");
                Cell { property: def.id, target: "", fate }
            }
        };
        place += 1;
    }
    cells
};

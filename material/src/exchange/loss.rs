//! What a translation costs, property by property: the rows of the loss sheet.

use crate::lobes::idle_lobe;
use crate::material::Material;
use crate::properties::{Inputs, Property};

/// What becomes of a property.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Fate {
    /// The other program means the same by the same number, or by another number that leads back to it.
    Exact,
    /// Other numbers, the same look, and the way back.
    Remapped,
    /// The look differs, or the way back is not exact.
    Approximated,
    /// Nothing in the format means it.
    Dropped,
}

impl Fate {
    /// All fates with the words of reports.
    pub const ALL: [(Self, &'static str); 4] =
        [(Self::Exact, "exact"), (Self::Remapped, "remapped"), (Self::Approximated, "approximated"), (Self::Dropped, "dropped")];

    /// The word of reports.
    pub fn word(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Remapped => "remapped",
            Self::Approximated => "approximated",
            Self::Dropped => "dropped",
        }
    }
}

/// How a shading model holds one property. Constant data.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// The property.
    pub property: Property,
    /// The parameters that hold it; empty where none does.
    pub target: &'static str,
    /// What becomes of it in a material with these values, and why, in words for the user; empty where there is nothing to say.
    pub fate: fn(&Inputs<f64>) -> (Fate, &'static str),
}

impl Cell {
    /// A property that a parameter of the same meaning holds.
    pub const fn exact(property: Property, target: &'static str) -> Self {
        Self { property, target, fate: |_| (Fate::Exact, "") }
    }

    /// A property that no parameter holds.
    pub const fn dropped(property: Property) -> Self {
        Self { property, target: "", fate: |_| (Fate::Dropped, "the format has nothing that means it") }
    }
}

/// One row of the loss sheet.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The property.
    pub property: Property,
    /// The parameters that hold it; empty where none does.
    pub target: String,
    /// What becomes of it.
    pub fate: Fate,
    /// Why, in words for the user; may be empty.
    pub note: String,
    /// Whether the material needs the property: only then a picture can show the loss.
    pub has_effect: bool,
}

/// The rows of a material, in the order of the property table. A property that stands at its default is never lost.
pub fn rows(cells: &[Cell], material: &Material) -> Vec<Row> {
    let inputs = material.inputs();
    material
        .slots()
        .map(|(property, slot)| {
            let has_effect = idle_lobe(material, property).is_none();
            let is_default = slot.texture.is_none() && material.value(property) == property.def().default;
            let cell = cells.iter().find(|cell| cell.property == property);
            let (mut fate, note) = cell.map_or((Fate::Dropped, ""), |cell| (cell.fate)(&inputs));
            let mut note = note.to_owned();
            if fate == Fate::Dropped && is_default {
                (fate, note) = (Fate::Exact, "at its default, which needs no words".to_owned());
            } else if !has_effect && fate > Fate::Remapped {
                note += if note.is_empty() { "without effect in this material" } else { "; without effect in this material" };
            }
            Row { property, target: cell.map_or("", |cell| cell.target).to_owned(), fate, note, has_effect }
        })
        .collect()
}

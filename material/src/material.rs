//! The material document: one slot per property, and what people say about it.

use crate::foreign::Foreign;
use crate::properties::{Inputs, PROPERTIES, PROPERTY_COUNT, Property};
use crate::slot::Slot;
use crate::value::Value;

/// Millimetres per unit of a material file that does not state its unit.
pub const DEFAULT_UNIT_MM: f64 = 100.0;

/// A material as authored. Values outside their range are kept; renderers clamp what must be clamped.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name shown to users.
    pub name: String,
    /// Other names that it is found by, such as that of a file that became one with this one.
    pub aliases: Vec<String>,
    /// Free words for searching.
    pub tags: Vec<String>,
    /// Free text.
    pub notes: String,
    /// Where the values come from.
    pub provenance: Provenance,
    /// Millimetres per unit of the lengths in this material; `None` means [`DEFAULT_UNIT_MM`].
    pub unit_mm: Option<f64>,
    /// What files of other formats said that ASM has no place for: by format and key, a JSON text each. Goes back out to that format.
    /// [`Material::set_foreign`] keeps what a file can hold.
    pub foreign: Foreign,
    slots: Box<[Slot; PROPERTY_COUNT]>,
}

/// Where the values of a material come from. Empty texts are absent in the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Provenance {
    /// Dataset or person.
    pub source: String,
    /// Paper, standard or page.
    pub reference: String,
    /// How values were obtained, with conversions.
    pub method: String,
    /// Licence of the data.
    pub licence: String,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            aliases: Vec::new(),
            tags: Vec::new(),
            notes: String::new(),
            provenance: Provenance::default(),
            unit_mm: None,
            foreign: Foreign::new(),
            slots: Box::new(std::array::from_fn(|_| Slot::default())),
        }
    }
}

impl Material {
    /// A material with this name and every property at its default.
    pub fn named(name: impl Into<String>) -> Self {
        Self { name: name.into(), ..Self::default() }
    }

    /// The slot of a property.
    pub fn slot(&self, property: Property) -> &Slot {
        &self.slots[property as usize]
    }

    /// The slot of a property, for editing.
    pub fn slot_mut(&mut self, property: Property) -> &mut Slot {
        &mut self.slots[property as usize]
    }

    /// The authored value or the default. Not clamped.
    pub fn value(&self, property: Property) -> Value {
        self.slot(property).value.unwrap_or(property.def().default)
    }

    /// The value as a number; 0 for other kinds.
    pub fn float(&self, property: Property) -> f64 {
        if let Value::Float(v) = self.value(property) { v } else { 0.0 }
    }

    /// The value as a colour or vector; zeros for other kinds.
    pub fn color(&self, property: Property) -> [f64; 3] {
        match self.value(property) {
            Value::Color(v) | Value::Normal(v) => v,
            _ => [0.0; 3],
        }
    }

    /// The value as a switch; false for other kinds.
    pub fn switch(&self, property: Property) -> bool {
        matches!(self.value(property), Value::Bool(true))
    }

    /// Sets a value. The kind must be the property's own, which callers take from the table.
    pub fn set(&mut self, property: Property, value: Value) -> &mut Self {
        debug_assert_eq!(value.kind(), property.def().default.kind(), "{}", property.def().name);
        self.slot_mut(property).value = Some(value);
        self
    }

    /// Whether a texture stands in the slot.
    pub fn is_textured(&self, property: Property) -> bool {
        self.slot(property).texture.is_some()
    }

    /// All slots with their properties, in specification order.
    pub fn slots(&self) -> impl Iterator<Item = (Property, &Slot)> {
        PROPERTIES.iter().map(|def| def.id).zip(self.slots.iter())
    }

    /// Millimetres per unit of this material's lengths.
    pub fn unit_mm(&self) -> f64 {
        self.unit_mm.filter(|mm| mm.is_finite() && *mm > 0.0).unwrap_or(DEFAULT_UNIT_MM)
    }

    /// Values for evaluation: uniform values, hard ranges enforced, non-finite ones replaced by the default.
    pub fn inputs(&self) -> Inputs<f64> {
        Inputs::gather(|property| {
            let def = property.def();
            let fix = |x: f64, default: f64| {
                if x.is_nan() { default } else { def.limits.enforce(x).clamp(f64::from(f32::MIN), f64::from(f32::MAX)) }
            };
            match (self.value(property), def.default) {
                (Value::Float(v), Value::Float(d)) => Value::Float(fix(v, d)),
                (Value::Color(v), Value::Color(d)) => Value::Color([fix(v[0], d[0]), fix(v[1], d[1]), fix(v[2], d[2])]),
                (value, _) => value,
            }
        })
    }
}

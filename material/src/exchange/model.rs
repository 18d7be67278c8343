//! Shading models: what their parameters are, and how ASM's properties become them and come from them.

use super::field::{Field, FieldDef, Fields};
use super::loss::{Cell, Fate, Row, rows};
use super::models;
use super::texture::{Image, Link, link};
use crate::material::Material;
use crate::properties::{Inputs, PROPERTIES, Property};
use crate::value::{Kind, Value, Vary};

/// What a translation has to know beside the values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Context {
    /// Metres per unit of the material's lengths.
    pub meters_per_unit: f64,
    /// Width of the bounding box of the mesh in its own space, in units of the file; 1 without a mesh.
    pub mesh_width: f64,
}

impl Context {
    /// That of a material without a mesh.
    pub fn of(material: &Material) -> Self {
        Self { meters_per_unit: material.unit_mm() / 1000.0, mesh_width: 1.0 }
    }
}

/// Sentences for the user about what did not go as it stands in the file.
pub type Notes = Vec<String>;

/// One shading model. Constant data.
#[derive(Clone, Copy, Debug)]
pub struct ShadingModel {
    /// Its name in code, reports and `foreign` entries: `open_pbr_surface`.
    pub name: &'static str,
    /// Its name for the user: `OpenPBR`.
    pub label: &'static str,
    /// Its parameters.
    pub fields: &'static [FieldDef],
    /// How it holds each property.
    pub cells: &'static [Cell],
    /// Values of the parameters, in the order of the table.
    pub translate: fn(&Inputs<f64>, &Context) -> Vec<Value>,
    /// The way back. Numbers are finite; those out of range are clamped with a note.
    pub interpret: fn(&[Value], &Context, &mut Notes) -> Inputs<f64>,
}

/// Every shading model that something is translated to or from.
pub const MODELS: &[&ShadingModel] = &[
    &models::open_pbr::MODEL,
    &models::standard_surface::MODEL,
    &models::gltf::MODEL,
    &models::gltf_pbr::MODEL,
    &models::usd_preview::MODEL,
    &models::disney_principled::MODEL,
    &models::filament::MODEL,
    &models::dassault::MODEL,
    &models::specular_glossiness::MODEL,
    &models::maps::MODEL,
];

/// What a material becomes in a shading model.
#[derive(Clone, Debug, PartialEq)]
pub struct Translation {
    /// Its parameters; images stand where they can be used as they are.
    pub fields: Fields,
    /// Images that have to be computed: for each such parameter its place in the table. Its field holds the uniform value.
    pub images: Vec<Image>,
    /// What it costs.
    pub rows: Vec<Row>,
}

impl ShadingModel {
    /// The model of this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        MODELS.iter().copied().find(|model| model.name == name)
    }

    /// Translates a material.
    pub fn translate(&self, material: &Material, context: &Context) -> Translation {
        let inputs = material.inputs();
        let values = (self.translate)(&inputs, context);
        let mut images = Vec::new();
        let fields = self.fields.iter().zip(values).enumerate().map(|(place, (def, value))| {
            let textured: Vec<Property> = def.from.iter().copied().filter(|p| material.is_textured(*p)).collect();
            let mut texture = None;
            if def.takes_image && !textured.is_empty() {
                match link(&textured, material, &inputs, |i| (self.translate)(i, context).get(place).copied()) {
                    Link::Direct(reference) => texture = Some(*reference),
                    Link::Computed => images.push(Image { field: place, from: textured }),
                    Link::Constant => {}
                }
            }
            Field { is_authored: value != def.default || texture.is_some(), value, texture }
        });
        let fields = Fields(fields.collect());
        let mut rows = rows(self.cells, material);
        self.try_way_back(material, &fields, context, &mut rows);
        Translation { fields, images, rows }
    }

    /// What is said to come back is brought back; where the number is another one, the row says so.
    fn try_way_back(&self, material: &Material, fields: &Fields, context: &Context, rows: &mut [Row]) {
        let back = (self.interpret)(&fields.values(), context, &mut Notes::new());
        for row in rows.iter_mut().filter(|row| row.fate <= Fate::Remapped && !row.target.is_empty()) {
            let (here, there) = (material.value(row.property), back.value(row.property));
            if !is_near(here, there) && !material.is_textured(row.property) {
                row.fate = Fate::Approximated;
                row.note += if row.note.is_empty() { "" } else { "; " };
                row.note += &format!("comes back as {}", numbers_text(there));
            }
        }
    }

    /// The material that these parameters mean. Values at ASM's default are left out unless the file says something that leads to them.
    pub fn interpret(&self, fields: &Fields, context: &Context, notes: &mut Notes) -> Material {
        let values = fields.values();
        let inputs = (self.interpret)(&values, context, notes);
        let mut material = Material::default();
        for def in PROPERTIES {
            let sources = self.fields.iter().zip(&fields.0).enumerate().filter(|(_, (f, _))| f.to.contains(&def.id));
            let (mut is_said, mut textured) = (false, Vec::new());
            for (place, (_, field)) in sources {
                is_said |= field.is_authored;
                if field.texture.is_some() {
                    textured.push(place);
                }
            }
            let value = inputs.value(def.id);
            let mut texture = super::texture::back(def.id, &textured, fields, &values, notes, |v| {
                (self.interpret)(v, context, &mut Notes::new()).value(def.id)
            });
            if def.vary == Vary::Uniform && texture.take().is_some() && def.default.kind() != Kind::Bool {
                notes.push(format!(
                    "{}: one value for the whole material, no image: that at the image's middle is taken",
                    def.name
                ));
            }
            if texture.is_none() && (value != def.default || (is_said && textured.is_empty())) {
                material.set(def.id, value);
            }
            material.slot_mut(def.id).texture = texture;
        }
        material
    }
}

/// Whether a value that went there and back is the same, to four digits.
fn is_near(a: Value, b: Value) -> bool {
    match (a, b) {
        (Value::Bool(a), Value::Bool(b)) => a == b,
        (a, b) => a.numbers().iter().zip(b.numbers()).all(|(a, b)| (a - b).abs() <= 1e-4 * a.abs().max(1.0)),
    }
}

fn numbers_text(value: Value) -> String {
    let short = |x: &f64| format!("{}", (x * 1e4).round() / 1e4);
    match value {
        Value::Bool(on) => (if on { "on" } else { "off" }).to_owned(),
        value => value.numbers().iter().map(short).collect::<Vec<_>>().join(", "),
    }
}

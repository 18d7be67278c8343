//! Materials of a layer.
//!
//! Of several networks the shader of the Adobe Standard Material counts first, then one of MaterialX's models, then UsdPreviewSurface.

use super::connections::{Source, constant, follow, shader_id};
use super::copy::{self, Copy};
use super::images::{Found, image};
use super::layer::{Attribute, Entries, Layer, PrimId, entry};
use super::numbers::{double, single};
use crate::exchange::field::{FieldDef, Fields};
use crate::exchange::model::{Context, Notes, ShadingModel};
use crate::exchange::paths::refusal;
use crate::exchange::short::short;
use crate::material::{DEFAULT_UNIT_MM, Material};
use crate::properties::{PROPERTIES, Property};
use crate::slot::{Slot, TextureRef};
use crate::value::{Kind, Value};

/// What shaders of the Adobe Standard Material 4.0 say that they are.
pub(super) const ASM_ID: &str = "AdobeStandardMaterial_4_0";
/// Key of `Material::foreign` for what surfaces of USD say beside their model.
pub(super) const FOREIGN: &str = "usd";
/// Most materials that are read from a layer.
pub const MAX_MATERIALS: usize = 2_000;
/// Most attributes of a shader that are searched without regard to case, or for what ASM has no place for.
const MAX_SEARCHED: usize = 300;
/// Longest value of an input that is kept although ASM has no place for it, bytes.
const MAX_KEPT_BYTES: usize = 300;

/// A material of a layer.
#[derive(Clone, Debug)]
pub struct FoundMaterial {
    /// Path of its prim.
    pub path: String,
    /// The material.
    pub material: Material,
    /// What the shader that was read says that it is, such as `UsdPreviewSurface`; empty where there was none.
    pub network: String,
    /// Whether it comes from a native copy: equal to what was exported, but for what the notes tell of.
    pub is_native: bool,
    /// Paths of images in the material with their places beside the layer, where these differ.
    pub files: Vec<(String, String)>,
    /// Sentences for the user about what did not go as it stands in the file.
    pub notes: Notes,
}

/// The materials of a layer, in the order of the text; of very many the first ones, with a note.
pub(super) fn materials(layer: &Layer, notes: &mut Notes) -> Vec<FoundMaterial> {
    let mut all = layer.in_scene("Material");
    let meters_per_unit = meters_per_unit(layer);
    let read = |id| Reader { layer, meters_per_unit, notes: Notes::new() }.material(id);
    let found = all.by_ref().take(MAX_MATERIALS).map(read).collect();
    if all.next().is_some() {
        notes.push(format!("expected at most {MAX_MATERIALS} materials, found more; the first ones are read"));
    }
    found
}

/// Metres per unit of a layer's lengths; USD's default of a centimetre where it says none.
pub(super) fn meters_per_unit(layer: &Layer) -> f64 {
    let said = layer.metadata("metersPerUnit").and_then(|value| value.number());
    said.filter(|m| m.is_finite() && *m > 0.0).unwrap_or(0.01)
}

struct Reader<'t, 'a> {
    layer: &'t Layer<'a>,
    meters_per_unit: f64,
    notes: Notes,
}

impl<'t, 'a> Reader<'t, 'a> {
    fn material(mut self, prim: PrimId) -> FoundMaterial {
        let layer = self.layer;
        let metadata = &layer.prim(prim).metadata;
        let native = entry(metadata, "customData").and_then(|data| entry(data.entries()?, "asm")?.entries());
        let mut found = FoundMaterial {
            path: layer.path(prim),
            material: Material::default(),
            network: String::new(),
            is_native: false,
            files: Vec::new(),
            notes: Notes::new(),
        };
        let mut has_texts = false;
        match self.terminal(prim) {
            Some((shader, id)) if id == ASM_ID => {
                found.network = id.to_owned();
                has_texts = self.standard_material(shader, native, &mut found);
            }
            Some((shader, id)) => {
                found.network = id.to_owned();
                if let Some(model) = model_of(id) {
                    found.material = self.model(model, prim, shader, id);
                }
            }
            None => self.notes.push("expected a surface that this program knows, found none; the default is used".to_owned()),
        }
        if !has_texts {
            let name = entry(metadata, "displayName").and_then(|name| name.text());
            found.material.name = name.filter(|name| !name.is_empty()).unwrap_or(&layer.prim(prim).name).to_owned();
            let unit_mm = 1000.0 * self.meters_per_unit;
            found.material.unit_mm = (unit_mm != DEFAULT_UNIT_MM).then_some(unit_mm);
        }
        let place = short(&found.path);
        found.notes = self.notes.into_iter().map(|note| format!("<{place}>: {note}")).collect();
        found
    }

    /// The surface that counts, and what it says that it is.
    fn terminal(&mut self, prim: PrimId) -> Option<(PrimId, &'t str)> {
        let mut best: Option<(usize, PrimId, &str)> = None;
        for attribute in self.layer.attributes(prim) {
            if !(attribute.name.starts_with("outputs:") && attribute.name.ends_with(":surface")) {
                continue;
            }
            match follow(self.layer, prim, attribute.name) {
                Ok(Some(Source::Output(shader, _))) => {
                    let id = shader_id(self.layer, shader);
                    let rank = match id {
                        ASM_ID => 0,
                        _ if model_of(id).is_none() => {
                            self.notes.push(format!(
                                "{}: the surface `{}` is not known; not read",
                                short(attribute.name),
                                short(id)
                            ));
                            continue;
                        }
                        "UsdPreviewSurface" => 2,
                        _ => 1,
                    };
                    if best.is_none_or(|(least, ..)| rank < least) {
                        best = Some((rank, shader, id));
                    }
                }
                Ok(_) => {}
                Err(reason) => self.notes.push(format!("{}: {reason}", short(attribute.name))),
            }
        }
        best.map(|(_, shader, id)| (shader, id))
    }

    /// Reads the native shader; whether the copy beside it holds the texts of the material as well.
    fn standard_material(&mut self, shader: PrimId, native: Option<&Entries>, found: &mut FoundMaterial) -> bool {
        let copy = native.and_then(|entries| copy::read(entries, &mut self.notes));
        let Some(copy) = copy else {
            let inputs = PROPERTIES.iter().map(|def| (def.id, self.input(shader, def.usage, def.default.kind())));
            let inputs: Vec<_> = inputs.collect();
            for (property, (value, _)) in &inputs {
                found.material.slot_mut(*property).value = *value;
            }
            // Strengths of normal maps multiply what the values say.
            for (property, (_, image)) in inputs {
                self.set_image(&mut found.material, property, image);
            }
            self.keep_others(&mut found.material, shader, ASM_ID, is_input);
            return false;
        };
        found.is_native = true;
        found.material = copy.material.clone();
        for def in PROPERTIES {
            let slot = self.slot(shader, &copy, def.id);
            if let Some(texture) = &slot.texture
                && copy.file(def.id, texture) != texture.path
            {
                found.files.push((texture.path.clone(), copy.file(def.id, texture).to_owned()));
            }
            *found.material.slot_mut(def.id) = slot;
        }
        self.keep_others(&mut found.material, shader, ASM_ID, is_input);
        copy.has_document
    }

    /// A slot of a native copy.
    fn slot(&mut self, shader: PrimId, copy: &Copy, property: Property) -> Slot {
        let def = property.def();
        let (value, image) = self.input(shader, def.usage, def.default.kind());
        // Behind an image the input keeps its own value.
        let own = self.find_input(shader, def.usage).and_then(|attribute| typed(attribute, def.default.kind()));
        let value = copy.value(property, value.or(own), &mut self.notes);
        let texture = copy.texture(property, image.map(|found| found.texture), &mut self.notes);
        let texture = if texture == copy.material.slot(property).texture { texture } else { texture.and_then(|t| self.safe(t)) };
        Slot { value, texture }
    }

    fn set_image(&mut self, material: &mut Material, property: Property, image: Option<Found>) {
        let Some(Found { texture, normal_scale }) = image else { return };
        let strength = match property {
            Property::normal => Some(Property::normal_scale),
            Property::coat_normal => Some(Property::coat_normal_scale),
            _ => None,
        };
        material.slot_mut(property).texture = self.safe(texture);
        if let Some(strength) = strength.filter(|_| normal_scale != 1.0) {
            let value = material.float(strength) * normal_scale;
            material.set(strength, Value::Float(value));
        }
    }

    /// An image whose file lies beside the layer or below its folder.
    fn safe(&mut self, texture: TextureRef) -> Option<TextureRef> {
        let path = &texture.path;
        if refusal(path).is_some() {
            let path = short(path);
            self.notes.push(format!("the image `{path}`: expected a file in the folder of this one or below; not used"));
            return None;
        }
        if path.contains("<UDIM>") {
            self.notes
                .push(format!("the image `{}`: expected one image, found a name for many tiles; kept as a path", short(path)));
        }
        Some(texture)
    }

    fn find_input(&self, shader: PrimId, name: &str) -> Option<&'t Attribute<'a>> {
        let layer = self.layer;
        let full = format!("inputs:{name}");
        let any_case =
            || layer.attributes(shader).take(MAX_SEARCHED).find(|attribute| attribute.name.eq_ignore_ascii_case(&full));
        layer.attribute(shader, &full).or_else(any_case)
    }

    /// What an input holds: a value, or an image.
    fn input(&mut self, shader: PrimId, name: &str, kind: Kind) -> (Option<Value>, Option<Found>) {
        let Some(input) = self.find_input(shader, name) else { return (None, None) };
        let fault = match follow(self.layer, shader, input.name) {
            Ok(None) => return (None, None),
            Ok(Some(Source::Value(attribute))) => match typed(attribute, kind) {
                Some(value) => return (Some(value), None),
                None => format!("line {}: expected {}, found another value; not read", attribute.line, kind.expectation()),
            },
            Ok(Some(Source::Output(node, _))) if shader_id(self.layer, node).starts_with("ND_constant_") => {
                match constant(self.layer, node, "value").and_then(|attribute| typed(attribute, kind)) {
                    Some(value) => return (Some(value), None),
                    None => format!("expected {} from a constant, found another value; not read", kind.expectation()),
                }
            }
            Ok(Some(Source::Output(node, output))) => match image(self.layer, node, output, kind, &mut self.notes) {
                Ok(found) => return (None, Some(found)),
                Err(fault) => fault,
            },
            Err(fault) => fault,
        };
        self.notes.push(format!("inputs:{name}: {fault}"));
        (typed(input, kind), None)
    }

    fn model(&mut self, model: &ShadingModel, prim: PrimId, shader: PrimId, id: &str) -> Material {
        let mut fields = Fields::unsaid(model.fields);
        let displacement = match follow(self.layer, prim, "outputs:mtlx:displacement") {
            Ok(Some(Source::Output(node, _))) if id != "UsdPreviewSurface" => Some(node),
            _ => None,
        };
        for def in model.fields {
            match (def.name, displacement) {
                ("displacement", Some(node)) => self.field(&mut fields, model, def, node, "displacement"),
                ("displacement.scale", Some(node)) => self.field(&mut fields, model, def, node, "scale"),
                ("geometry_tangent", _) => self.rotation(&mut fields, model, shader, def),
                _ => self.field(&mut fields, model, def, shader, def.name),
            }
        }
        let context = Context { meters_per_unit: self.meters_per_unit, mesh_width: 1.0 };
        let mut material = model.interpret(&fields, &context, &mut self.notes);
        let table = model.fields;
        let is_known = |name: &str| table.iter().any(|def| def.name.eq_ignore_ascii_case(name)) || name == "tangent";
        self.keep_others(&mut material, shader, id, is_known);
        material
    }

    fn field(&mut self, fields: &mut Fields, model: &ShadingModel, def: &FieldDef, shader: PrimId, name: &str) {
        let (value, image) = self.input(shader, name, def.default.kind());
        let image = image.filter(|_| def.takes_image);
        if let Some(Found { normal_scale, .. }) = image
            && normal_scale != 1.0
            && let Some(strength) = fields.say(model.fields, &format!("{}.scale", def.name))
        {
            strength.value = Value::Float(normal_scale);
        }
        let texture = image.and_then(|found| self.safe(found.texture));
        if value.is_none() && texture.is_none() {
            return;
        }
        if let Some(field) = fields.say(model.fields, def.name) {
            field.value = match value {
                Some(value) => value,
                // A black default would hide the image from the formulas.
                None if def.default == Value::Color([0.0; 3]) => Value::Color([1.0; 3]),
                None => def.default,
            };
            field.texture = texture;
        }
    }

    /// A rotation of the tangent, in turns, from the node that turns it the other way round.
    fn rotation(&mut self, fields: &mut Fields, model: &ShadingModel, shader: PrimId, def: &FieldDef) {
        let Ok(Some(Source::Output(node, _))) = follow(self.layer, shader, &format!("inputs:{}", def.name)) else { return };
        if !shader_id(self.layer, node).starts_with("ND_rotate3d") {
            return self
                .notes
                .push(format!("inputs:{}: expected a rotation of the tangent, found another node; not read", def.name));
        }
        let (value, image) = self.input(node, "amount", Kind::Float);
        let Some(field) = fields.say(model.fields, def.name) else { return };
        if let Some(Value::Float(degrees)) = value {
            field.value = Value::Float(single(-degrees / 360.0));
        }
        field.texture = image.and_then(|found| self.safe(found.texture)).map(|mut texture| {
            texture.scale = texture.scale.map(|s| single(-s / 360.0));
            texture.bias = texture.bias.map(|b| single(-b / 360.0));
            texture
        });
    }

    /// Tells of inputs that the model does not know, and keeps those that hold plain numbers or texts, for the way back.
    fn keep_others(&mut self, material: &mut Material, shader: PrimId, id: &str, is_known: impl Fn(&str) -> bool) {
        let mut names = Vec::new();
        for attribute in self.layer.attributes(shader).take(MAX_SEARCHED) {
            let Some(name) = attribute.name.strip_prefix("inputs:").filter(|name| !is_known(name)) else { continue };
            names.push(name);
            let value = constant(self.layer, shader, name).and_then(|source| source.value.as_ref());
            if let Some(value) = value {
                let numbers = [1, 2, 3, 4].iter().find_map(|count| value.tuple(*count));
                let text = match (numbers, value.text()) {
                    (Some([one]), _) => double(*one),
                    (Some(many), _) => format!("({})", many.iter().map(|x| double(*x)).collect::<Vec<_>>().join(", ")),
                    (None, Some(text)) if matches!(attribute.type_name, "token" | "string") => super::numbers::quoted(text),
                    _ => continue,
                };
                if text.len() > MAX_KEPT_BYTES {
                    continue;
                }
                let json = serde_json::json!(format!("{} {text}", attribute.type_name)).to_string();
                // More than a material holds stays behind.
                _ = material.set_foreign(FOREIGN, &format!("{id}.{name}"), Some(json));
            }
        }
        if !names.is_empty() {
            self.notes.push(format!("no property of ASM means: {}", short(&names.join(", "))));
        }
    }
}

/// Whether the shader of the Adobe Standard Material has an input of this name.
fn is_input(name: &str) -> bool {
    PROPERTIES.iter().any(|def| def.usage.eq_ignore_ascii_case(name))
}

/// The model of a surface that says that it is this.
pub(super) fn model_of(id: &str) -> Option<&'static ShadingModel> {
    match id {
        "UsdPreviewSurface" | "ND_UsdPreviewSurface_surfaceshader" => ShadingModel::named("usd_preview_surface"),
        _ => ShadingModel::named(id.strip_prefix("ND_")?.strip_suffix("_surfaceshader")?),
    }
}

/// The value of an attribute as one of this kind. Numbers of single precision are those that their shortest decimals mean.
fn typed(attribute: &Attribute, kind: Kind) -> Option<Value> {
    let value = attribute.value.as_ref()?;
    let is_double = attribute.type_name.starts_with("double") || attribute.type_name.ends_with("3d");
    let fix = |x: f64| if is_double { x } else { single(x) };
    let three = |numbers: &[f64]| Some([fix(*numbers.first()?), fix(*numbers.get(1)?), fix(*numbers.get(2)?)]);
    match kind {
        Kind::Float => value.number().map(fix).map(Value::Float),
        Kind::Bool => value.number().map(|x| Value::Bool(x != 0.0)),
        Kind::Color => value.tuple(3).or_else(|| value.tuple(4)).and_then(three).map(Value::Color),
        Kind::Normal => value.tuple(3).and_then(three).map(Value::Normal),
    }
}

//! A material on the way out: which of its parameters have images, and whether those serve as they are.

use std::collections::BTreeMap;

use super::slots::{self, SLOTS, Slot, field};
use super::uri;
use super::write::{Facts, Options, Part};
use crate::exchange::field::{Field, FieldDef};
use crate::exchange::models::gltf::MODEL;
use crate::exchange::plan::{Job, Texel};
use crate::properties::{Inputs, Property};
use crate::slot::{Channel, ColorSpace, TextureRef};
use crate::value::{Kind, Value};

/// A material whose images are decided.
pub(super) struct Draft<'a> {
    pub part: &'a Part<'a>,
    /// Parameters; those with an image have the factor beside it for a value.
    pub fields: Vec<Field>,
    /// What stands in the places for images.
    pub images: Vec<(&'static Slot, Content)>,
    options: &'a Options,
    /// Properties that each parameter without a direct image is made of, by its place.
    computed: BTreeMap<usize, Vec<Property>>,
}

/// What stands in a place for images.
pub(super) enum Content {
    /// An image as it is.
    Image(TextureRef),
    /// One that is computed; the reference says how it lies.
    Job(Job, TextureRef),
}

/// How a parameter takes part in the image of its place.
enum State {
    Uniform,
    /// By an image as it is, and a factor by component.
    Direct(TextureRef, [f64; 3]),
    /// By an image made of these properties' images, and a factor by component.
    Computed(Vec<Property>, [f64; 3]),
}

impl<'a> Draft<'a> {
    /// Decides about all images. `fields` and `computed` (what parameters without an image of their own are made of, by place) are those of
    /// the translation, or what stands for them.
    pub fn new(
        part: &'a Part<'a>,
        (fields, computed): (Vec<Field>, BTreeMap<usize, Vec<Property>>),
        options: &'a Options,
    ) -> Self {
        let mut draft = Self { part, fields, images: Vec::new(), options, computed };
        draft.settle();
        for slot in SLOTS {
            draft.fill(slot);
        }
        draft
    }

    /// The parameter's uniform value, or the factor beside its image.
    pub fn value(&self, name: &str) -> Value {
        field(name).and_then(|(place, _)| self.fields.get(place)).map_or(Value::Float(0.0), |field| field.value)
    }

    pub fn float(&self, name: &str) -> f64 {
        self.value(name).numbers().first().copied().unwrap_or(0.0)
    }

    fn set(&mut self, place: usize, value: Value) {
        if let Some(field) = self.fields.get_mut(place) {
            field.value = value;
        }
    }

    /// Whether the place of the parameter has an image.
    pub fn has_image(&self, name: &str) -> bool {
        self.images.iter().any(|(slot, _)| slot.parts.iter().any(|(part, _)| *part == name))
    }

    /// Whether the material has less than full opacity anywhere.
    pub fn is_see_through(&self) -> bool {
        let alpha = field(slots::ALPHA).and_then(|(place, _)| Some((place, self.fields.get(place)?)));
        alpha.is_some_and(|(k, alpha)| {
            alpha.texture.is_some() || alpha.value != Value::Float(1.0) || self.computed.contains_key(&k)
        })
    }

    /// Numbers that follow a value which an image has taken over: the uniform value of the material no longer counts for them.
    fn settle(&mut self) {
        let inputs = self.part.material.inputs();
        if self.part.material.is_textured(Property::coat_specular_level)
            && let Some((ior, _)) = field(slots::COAT_IOR)
        {
            self.set(ior, Value::Float(inputs.coat_ior.max(1.0)));
        }
        let (Some((color, _)), Some((strength, _))) = (field(slots::EMISSIVE), field(slots::STRENGTH)) else { return };
        if !self.part.material.is_textured(Property::emission_color) || inputs.emission == 0.0 {
            return;
        }
        // An image that is scaled beyond 1: the strength takes over what the factor cannot.
        let mut most = 1.0;
        if let Some(texture) = self.fields.get_mut(color).and_then(|field| field.texture.as_mut()) {
            let scale = texture.scale.into_iter().fold(1.0, f64::max);
            if scale.is_finite() {
                texture.scale = texture.scale.map(|s| s / scale);
                most = scale;
            }
        }
        self.set(strength, Value::Float((inputs.emission * most).min(f64::from(f32::MAX))));
    }

    fn fill(&mut self, slot: &'static Slot) {
        let parts: Vec<_> = slot.parts.iter().filter_map(|(name, channel)| Some((field(name)?, *channel))).collect();
        let states: Vec<State> = parts.iter().map(|((place, def), channel)| self.state(*place, def, *channel, slot)).collect();
        if states.iter().all(|state| matches!(state, State::Uniform)) {
            return;
        }
        let common = self.common_image(slot, &parts, &states);
        let mut channels = [Texel::ONE; 4];
        let mut from = Vec::new();
        for (((place, def), channel), state) in parts.iter().zip(&states) {
            let (factor, made_of) = match state {
                State::Uniform => (None, Vec::new()),
                State::Direct(_, factor) => (Some(*factor), self.makers(*place, def)),
                State::Computed(from, factor) => (Some(*factor), from.clone()),
            };
            for property in made_of {
                if !from.contains(&property) {
                    from.push(property);
                }
            }
            if def.name == slots::ROTATION {
                // A direction along the tangent leaves the angle to the number beside the image.
                (channels[0], channels[1]) = match factor {
                    Some(_) => (Texel::Cosine { field: *place }, Texel::Sine { field: *place }),
                    None => (Texel::ONE, Texel::Constant(0.5)),
                };
                if factor.is_some() {
                    self.set(*place, Value::Float(0.0));
                }
                continue;
            }
            let Some(factor) = factor else { continue };
            for (component, at) in components(*channel) {
                let (field, factor) = (*place, factor[component]);
                channels[at] = match def.default.kind() {
                    Kind::Normal => Texel::Direction { field, component },
                    _ if factor <= 0.0 => Texel::ONE,
                    _ => Texel::Number { field, component, factor },
                };
            }
            match def.default {
                Value::Color(_) => self.set(*place, Value::Color(factor)),
                Value::Float(_) if slots::most_factor(def.name).is_some() => self.set(*place, Value::Float(factor[0])),
                _ => {}
            }
        }
        let content = match common {
            Some(texture) => Content::Image(texture),
            None => {
                let lies = self.common_place(&from);
                let job =
                    Job { file: String::new(), material: 0, from, is_in_place: lies.is_some(), is_srgb: slot.is_srgb, channels };
                Content::Job(job, lies.unwrap_or_else(|| TextureRef::new("")))
            }
        };
        self.images.push((slot, content));
    }

    fn state(&self, place: usize, def: &'static FieldDef, channel: Channel, slot: &Slot) -> State {
        let baked = [slots::baked_factor(def.name); 3];
        if self.computed.contains_key(&place) {
            return State::Computed(self.makers(place, def), baked);
        }
        let Some(field) = self.fields.get(place) else { return State::Uniform };
        let Some(texture) = &field.texture else {
            // Without a factor, a value that is not the default needs an image of one texel.
            let needs_image = slots::most_factor(def.name).is_none() && field.value != def.default;
            return if needs_image { State::Computed(Vec::new(), baked) } else { State::Uniform };
        };
        match (scale(def, texture), self.serves(def, channel, texture, slot)) {
            (Some(factor), true) => State::Direct(texture.clone(), factor),
            // The scale of an image leaves all steps of its copy to what it has.
            (Some(factor), false) if slots::most_factor(def.name).is_some() => State::Computed(self.makers(place, def), factor),
            _ => State::Computed(self.makers(place, def), baked),
        }
    }

    /// Properties with images that a parameter is made of: those that it follows, wherever the others stand.
    fn makers(&self, place: usize, def: &FieldDef) -> Vec<Property> {
        let textured: Vec<Property> =
            def.from.iter().copied().filter(|property| self.part.material.is_textured(*property)).collect();
        let probe = |property: Property, numbers: [f64; 3]| match property.def().default {
            Value::Color(_) => Value::Color(numbers),
            Value::Float(_) => Value::Float(numbers[0]),
            // Directions act on their own place alone.
            other => other,
        };
        let mut inputs = self.part.material.inputs();
        for property in &textured {
            inputs.set(*property, probe(*property, [0.37, 0.53, 0.71]));
        }
        let value = |inputs: &Inputs<f64>| (MODEL.translate)(inputs, &self.part.context).get(place).copied();
        let follows = |property: &Property| {
            let mut moved = inputs;
            moved.set(*property, probe(*property, [0.83, 0.29, 0.11]));
            property.def().default.kind() == Kind::Normal || value(&moved) != value(&inputs)
        };
        textured.into_iter().filter(follows).collect()
    }

    fn facts(&self, path: &str) -> Facts {
        self.options.facts.get(path).copied().unwrap_or_default()
    }

    /// Whether a place reads from an image file what its reference says, but for scale and bias.
    fn serves(&self, def: &FieldDef, channel: Channel, texture: &TextureRef, slot: &Slot) -> bool {
        let facts = self.facts(&texture.path);
        let is_format = super::read::is_builtin(&texture.path)
            || ["png", "jpg", "jpeg", "webp", "ktx2"].contains(&uri::extension(&texture.path).as_str());
        let stores_srgb = slot.is_srgb && channel == Channel::Rgb;
        // `Auto` decodes images of colours that have 8 bits, and no others.
        let reads_srgb = match texture.color_space {
            ColorSpace::Auto => !facts.is_wide && self.is_of_color(def, &texture.path),
            ColorSpace::Srgb => texture.channel != Channel::A,
            ColorSpace::Linear => false,
        };
        let is_channel = texture.channel == channel || (facts.is_gray && channel != Channel::A && texture.channel != Channel::A);
        is_format && !texture.is_inverted && stores_srgb == reads_srgb && is_channel
    }

    /// Whether an image of a parameter is that of a colour.
    fn is_of_color(&self, def: &FieldDef, path: &str) -> bool {
        def.from.iter().any(|property| {
            let texture = self.part.material.slot(*property).texture.as_ref();
            property.def().default.kind() == Kind::Color && texture.is_some_and(|texture| texture.path == path)
        })
    }

    /// The image that serves all parameters of a place as it is.
    fn common_image(&self, slot: &Slot, parts: &[((usize, &'static FieldDef), Channel)], states: &[State]) -> Option<TextureRef> {
        if slot.name == slots::ANISOTROPY_IMAGE {
            return None;
        }
        let first = states.iter().find_map(|state| if let State::Direct(texture, _) = state { Some(texture) } else { None })?;
        let serves = |((place, def), _): &((usize, &'static FieldDef), Channel), state: &State| match state {
            State::Direct(texture, _) => is_alike(texture, first) && texture.path == first.path,
            State::Computed(..) => false,
            // What else is in the image must not matter.
            State::Uniform => {
                let value = self.fields.get(*place).map_or(1.0, |field| field.value.numbers().first().copied().unwrap_or(1.0));
                let has_no_alpha =
                    ["jpg", "jpeg"].contains(&uri::extension(&first.path).as_str()) || self.facts(&first.path).is_opaque;
                value == 0.0 || (def.name == slots::ALPHA && (value == 1.0 || has_no_alpha))
            }
        };
        parts.iter().zip(states).all(|(part, state)| serves(part, state)).then(|| first.clone())
    }

    /// How the images of these properties lie on the surface, if all of them lie in the same way.
    fn common_place(&self, from: &[Property]) -> Option<TextureRef> {
        let mut textures = from.iter().filter_map(|property| self.part.material.slot(*property).texture.as_ref());
        let Some(first) = textures.next() else { return Some(TextureRef::new("")) };
        textures.all(|texture| is_alike(texture, first)).then(|| first.clone())
    }
}

/// The factor by component that does what the scale and the bias of an image do; `None` if no factor does.
fn scale(def: &FieldDef, texture: &TextureRef) -> Option<[f64; 3]> {
    let kind = def.default.kind();
    let (scale, bias) = (texture.scale, texture.bias);
    if kind == Kind::Normal {
        return Some([1.0; 3]);
    }
    let is_even = |v: [f64; 3]| kind == Kind::Color || (v[0] == v[1] && v[1] == v[2]);
    if !is_even(scale) || !is_even(bias) {
        return None;
    }
    match slots::most_factor(def.name) {
        // The strength of occlusion: 1 stays 1.
        None => ((0.0..=1.0).contains(&scale[0]) && (bias[0] - (1.0 - scale[0])).abs() < 1e-9).then_some(scale),
        Some(most) => (bias == [0.0; 3] && scale.iter().all(|s| (0.0..=most).contains(s))).then_some(scale),
    }
}

/// Whether two images lie on the surface in the same way.
pub(super) fn is_alike(a: &TextureRef, b: &TextureRef) -> bool {
    let place = |t: &TextureRef| (t.wrap, t.uv_scale, t.uv_offset, t.uv_rotation);
    place(a) == place(b)
}

/// Components of a parameter and the channels that they have in an image.
fn components(channel: Channel) -> impl Iterator<Item = (usize, usize)> {
    let (first, count) = match channel {
        Channel::Rgb => (0, 3),
        Channel::R => (0, 1),
        Channel::G => (1, 1),
        Channel::B => (2, 1),
        Channel::A => (3, 1),
    };
    (0..count).map(move |k| (k, first + k))
}

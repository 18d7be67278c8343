//! Kinds of values, their limits, and what one row of the property table holds.

use crate::properties::Property;

/// A property value as authored. Numbers are `f64` and never clamped here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// Linear Rec.709 colour, or a scale per channel.
    Color([f64; 3]),
    /// Scalar.
    Float(f64),
    /// Switch.
    Bool(bool),
    /// Tangent-space direction, OpenGL orientation (+Y up). `(0, 0, 1)` leaves the surface as it is.
    Normal([f64; 3]),
}

impl Value {
    /// The kind of this value.
    pub fn kind(self) -> Kind {
        match self {
            Self::Color(_) => Kind::Color,
            Self::Float(_) => Kind::Float,
            Self::Bool(_) => Kind::Bool,
            Self::Normal(_) => Kind::Normal,
        }
    }

    /// The numbers of this value: three, one, or none for a switch.
    pub fn numbers(&self) -> &[f64] {
        match self {
            Self::Color(v) | Self::Normal(v) => v,
            Self::Float(v) => std::slice::from_ref(v),
            Self::Bool(_) => &[],
        }
    }

    /// The value as four floats for a GPU row: colour or vector in `xyz`, a scalar in all of them, a switch as 0 or 1.
    pub fn row(self) -> [f32; 4] {
        let f = |x: f64| x.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32;
        match self {
            Self::Color(v) | Self::Normal(v) => [f(v[0]), f(v[1]), f(v[2]), -1.0],
            Self::Float(v) => [f(v), f(v), f(v), -1.0],
            Self::Bool(v) => {
                let v = if v { 1.0 } else { 0.0 };
                [v, v, v, -1.0]
            }
        }
    }
}

/// What kind of editor, text and GPU row a value needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Three numbers in linear Rec.709.
    Color,
    /// One number.
    Float,
    /// On or off.
    Bool,
    /// Tangent-space vector.
    Normal,
}

impl Kind {
    /// What a reader expects to see for this kind, for messages.
    pub fn expectation(self) -> &'static str {
        match self {
            Self::Color => "three numbers (r, g, b), linear",
            Self::Float => "a number",
            Self::Bool => "true or false",
            Self::Normal => "three numbers (x, y, z), a direction",
        }
    }
}

/// How binding a range is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitKind {
    /// "range" in the specification: values outside are kept in the file and clamped by the renderers.
    Hard,
    /// "typical range": values outside are legal and used as they are.
    Typical,
    /// No range is stated.
    Open,
}

/// The stated range of a property. An end that the specification leaves open is `None`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// How binding the range is.
    pub kind: LimitKind,
    /// Lower end, inclusive.
    pub min: Option<f64>,
    /// Upper end, inclusive.
    pub max: Option<f64>,
    /// Upper end of a slider where `max` is open; equals `max` otherwise.
    pub slider_max: f64,
}

impl Limits {
    /// A closed range that renderers enforce.
    pub const fn hard(min: f64, max: f64) -> Self {
        Self { kind: LimitKind::Hard, min: Some(min), max: Some(max), slider_max: max }
    }
    /// A range that renderers enforce at its lower end only.
    pub const fn hard_from(min: f64, slider_max: f64) -> Self {
        Self { kind: LimitKind::Hard, min: Some(min), max: None, slider_max }
    }
    /// A closed range that values may leave.
    pub const fn typical(min: f64, max: f64) -> Self {
        Self { kind: LimitKind::Typical, min: Some(min), max: Some(max), slider_max: max }
    }
    /// A half-open range that values may leave.
    pub const fn typical_from(min: f64, slider_max: f64) -> Self {
        Self { kind: LimitKind::Typical, min: Some(min), max: None, slider_max }
    }
    /// No stated range.
    pub const fn open(slider_max: f64) -> Self {
        Self { kind: LimitKind::Open, min: None, max: None, slider_max }
    }
    /// Whether `x` lies within the stated ends. An end that is open holds for every finite number.
    pub fn contains(&self, x: f64) -> bool {
        x.is_finite() && self.min.is_none_or(|min| x >= min) && self.max.is_none_or(|max| x <= max)
    }
    /// `x` brought inside if the range is hard, unchanged otherwise.
    pub fn enforce(&self, x: f64) -> f64 {
        if self.kind != LimitKind::Hard {
            return x;
        }
        let x = self.min.map_or(x, |min| x.max(min));
        self.max.map_or(x, |max| x.min(max))
    }
    /// The range in words: `range 0 to 1`, `typical range 0 and more`, or an empty text.
    pub fn text(&self) -> String {
        let name = match self.kind {
            LimitKind::Hard => "range",
            LimitKind::Typical => "typical range",
            LimitKind::Open => return String::new(),
        };
        match (self.min, self.max) {
            (Some(min), Some(max)) => format!("{name} {min} to {max}"),
            (Some(min), None) => format!("{name} {min} and more"),
            (None, Some(max)) => format!("{name} up to {max}"),
            (None, None) => String::new(),
        }
    }
}

/// How a property may vary over the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Vary {
    /// One value for the whole material.
    Uniform,
    /// A value or a texture.
    Texturable,
    /// A map by nature; a single value stands for a constant map.
    TextureOnly,
}

/// Groups of the specification, in its order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Group {
    /// Reflectivity and transmissivity.
    Surface,
    /// Normal and height.
    Detail,
    /// Elongated highlights.
    Anisotropy,
    /// Emitted light.
    Emission,
    /// Fibres above the base.
    Sheen,
    /// Refraction into the body.
    Interior,
    /// Colour by distance in the body.
    Absorption,
    /// Colour by scattering in the body.
    Scattering,
    /// Dielectric layer above everything.
    Coat,
    /// Maps that only rasterisers use.
    Auxiliary,
}

impl Group {
    /// All groups in specification order.
    pub const ALL: [Self; 10] = [
        Self::Surface,
        Self::Detail,
        Self::Anisotropy,
        Self::Emission,
        Self::Sheen,
        Self::Interior,
        Self::Absorption,
        Self::Scattering,
        Self::Coat,
        Self::Auxiliary,
    ];
    /// The heading shown to users.
    pub fn title(self) -> &'static str {
        match self {
            Self::Surface => "Surface",
            Self::Detail => "Surface detail",
            Self::Anisotropy => "Anisotropy",
            Self::Emission => "Emission",
            Self::Sheen => "Sheen",
            Self::Interior => "Interior",
            Self::Absorption => "Absorption",
            Self::Scattering => "Subsurface scattering",
            Self::Coat => "Coat",
            Self::Auxiliary => "Auxiliary",
        }
    }
}

/// What a number measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Unit {
    /// A plain number.
    None,
    /// A length in units of the material file.
    Length,
    /// A full turn is 1.
    Turn,
    /// Radiance, relative to the environment.
    Radiance,
}

impl Unit {
    /// The suffix shown after a number.
    pub fn suffix(self) -> &'static str {
        match self {
            Self::None => "",
            Self::Length => " units",
            Self::Turn => " turn",
            Self::Radiance => " radiance",
        }
    }
}

/// Every fact about one property. Constant data; see [`crate::PROPERTIES`].
#[derive(Clone, Copy, Debug)]
pub struct PropertyDef {
    /// Identity; `id as usize` is the row number.
    pub id: Property,
    /// Formal name, `base_color`: the key in files and code.
    pub name: &'static str,
    /// Channel usage string, `baseColor`.
    pub usage: &'static str,
    /// Common name as the specification's headings write it, `Base color`.
    pub label: &'static str,
    /// Value when absent.
    pub default: Value,
    /// Stated range of each number.
    pub limits: Limits,
    /// How it may vary over the surface.
    pub vary: Vary,
    /// Group in the specification.
    pub group: Group,
    /// What the number measures.
    pub unit: Unit,
    /// One or more sentences for the user.
    pub doc: &'static str,
}

impl PropertyDef {
    /// Whether `text` is one of the property's three names; case of the common name is ignored.
    pub fn is_named(&self, text: &str) -> bool {
        self.name == text || self.usage == text || self.label.eq_ignore_ascii_case(text)
    }
}

/// Conversion of a [`Value`] into the field type of [`crate::Inputs`].
///
/// The file reader refuses values of the wrong kind, so a mismatch cannot come from a user; it yields zeros.
pub(crate) trait FromValue {
    fn from_value(value: Value) -> Self;
}

impl FromValue for [f64; 3] {
    fn from_value(value: Value) -> Self {
        match value {
            Value::Color(v) | Value::Normal(v) => v,
            Value::Float(v) => [v; 3],
            Value::Bool(_) => [0.0; 3],
        }
    }
}

impl FromValue for f64 {
    fn from_value(value: Value) -> Self {
        match value {
            Value::Float(v) => v,
            Value::Color(v) | Value::Normal(v) => v[0],
            Value::Bool(_) => 0.0,
        }
    }
}

impl FromValue for bool {
    fn from_value(value: Value) -> Self {
        matches!(value, Value::Bool(true))
    }
}

//! THE TABLE: the 40 properties of the Adobe Standard Material 4.0, each declared once.
//!
//! Everything that deals with properties (file, panel, command line, GPU rows, tests) loops over [`PROPERTIES`]
//! or reads a field of [`Inputs`]. Source: Adobe Standard Material 4.0, property specification, October 2021.

use crate::value::{FromValue, Group, Limits, PropertyDef, Unit, Value, Vary};

macro_rules! field_type {
    (Color, $t:ty) => {
        [$t; 3]
    };
    (Normal, $t:ty) => {
        [$t; 3]
    };
    (Float, $t:ty) => {
        $t
    };
    (Bool, $t:ty) => {
        bool
    };
}

macro_rules! convert_field {
    (Color, $v:expr, $f:expr) => {
        $v.map($f)
    };
    (Normal, $v:expr, $f:expr) => {
        $v.map($f)
    };
    (Float, $v:expr, $f:expr) => {
        ($f)($v)
    };
    (Bool, $v:expr, $f:expr) => {
        $v
    };
}

macro_rules! asm_properties {
    ($( $(#[doc = $doc:literal])+ $name:ident: $kind:ident($default:expr), $usage:literal, $label:literal, $limits:expr, $vary:ident, $group:ident, $unit:ident; )+) => {
        /// Names of the properties, in specification order.
        #[allow(non_camel_case_types)] // Variants carry the formal names, so one search finds every use.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum Property { $( $(#[doc = $doc])+ $name ),+ }

        /// Every fact about every property, in specification order; row number is `Property as usize`.
        pub const PROPERTIES: &[PropertyDef] = &[$( PropertyDef {
            id: Property::$name, name: stringify!($name), usage: $usage, label: $label, default: Value::$kind($default),
            limits: $limits, vary: Vary::$vary, group: Group::$group, unit: Unit::$unit, doc: concat!($($doc),+).trim_ascii(),
        } ),+];

        /// All property values at one shading point, textures already sampled.
        pub struct Inputs<T> { $( $(#[doc = $doc])+ pub $name: field_type!($kind, T) ),+ }

        impl<T: Copy> Clone for Inputs<T> {
            fn clone(&self) -> Self {
                *self
            }
        }

        impl<T: Copy> Copy for Inputs<T> {}

        impl<T: std::fmt::Debug> std::fmt::Debug for Inputs<T> {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.debug_struct("Inputs")$( .field(stringify!($name), &self.$name) )+.finish()
            }
        }

        impl Inputs<f64> {
            /// Asks `value_of` for every property.
            pub fn gather(value_of: impl Fn(Property) -> Value) -> Self {
                Self { $( $name: FromValue::from_value(value_of(Property::$name)) ),+ }
            }

            /// The value of one property.
            pub fn value(&self, property: Property) -> Value {
                match property { $( Property::$name => Value::$kind(self.$name) ),+ }
            }

            /// Sets the value of one property; a value of another kind changes nothing.
            pub fn set(&mut self, property: Property, value: Value) {
                match (property, value) {
                    $( (Property::$name, Value::$kind(value)) => self.$name = value, )+
                    _ => {}
                }
            }
        }

        impl<T: Copy> Inputs<T> {
            /// The same values in another number type.
            pub fn convert<U>(&self, f: impl Fn(T) -> U) -> Inputs<U> {
                Inputs { $( $name: convert_field!($kind, self.$name, &f) ),+ }
            }
        }
    };
}

asm_properties! {
    /// Ideal colour at normal incidence: diffuse reflection of dielectrics, specular reflection of metals.
    base_color: Color([0.5; 3]), "baseColor", "Base color", Limits::hard(0.0, 1.0), Texturable, Surface, None;
    /// Roughness of the surface reflections and refractions; 0 is a perfect mirror.
    roughness: Float(0.3), "roughness", "Roughness", Limits::hard(0.0, 1.0), Texturable, Surface, None;
    /// Whether the surface behaves as a dielectric (0) or a conductor (1). Metal has priority over translucency.
    metallic: Float(0.0), "metallic", "Metallic", Limits::hard(0.0, 1.0), Texturable, Surface, None;
    /// Cut-through opacity without refraction, evaluated at each interface: 0 is not there, 1 is opaque.
    opacity: Float(1.0), "opacity", "Opacity", Limits::hard(0.0, 1.0), Texturable, Surface, None;
    /// Modifier of the index of refraction, linear in reflectivity: 0.5 leaves it, 0 removes the reflection, 1 doubles it. Dielectrics only.
    specular_level: Float(0.5), "specularLevel", "Specular level", Limits::hard(0.0, 1.0), Texturable, Surface, None;
    /// Tints dielectric reflections at every angle and metallic reflections at grazing angles (F82 tint).
    specular_edge_color: Color([1.0; 3]), "specularEdgeColor", "Specular edge color", Limits::hard(0.0, 1.0), Texturable, Surface, None;

    /// Tangent-space normal map of the surface, OpenGL orientation (+Y up).
    normal: Normal([0.0, 0.0, 1.0]), "normal", "Normal", Limits::open(1.0), TextureOnly, Detail, None;
    /// Strength of the normal map; 0 switches it off.
    normal_scale: Float(1.0), "normalScale", "Normal scale", Limits::typical_from(0.0, 2.0), Uniform, Detail, None;
    /// Whether the normal map is added to the detail of the height map (true) or already contains it (false).
    combine_normal_and_height: Bool(false), "combineNormalAndHeight", "Combine normal and height", Limits::open(1.0), Uniform, Detail, None;
    /// Displacement along the normal; no displacement where it equals the height level.
    height: Float(0.5), "height", "Height", Limits::open(1.0), TextureOnly, Detail, None;
    /// Size of the displacement between height 0 and height 1.
    height_scale: Float(1.0), "heightScale", "Height scale", Limits::typical_from(0.0, 1.0), Uniform, Detail, Length;
    /// Value of the height map that means no displacement.
    height_level: Float(0.5), "heightLevel", "Height level", Limits::hard(0.0, 1.0), Uniform, Detail, None;

    /// How far the highlight is stretched along the direction of anisotropy; visible at any roughness below 1.
    anisotropy: Float(0.0), "anisotropyLevel", "Anisotropy", Limits::hard(0.0, 1.0), Texturable, Anisotropy, None;
    /// Counterclockwise rotation of the stretch from the tangent; 1 is a full turn, half a turn looks the same as none.
    anisotropy_rotation: Float(0.0), "anisotropyAngle", "Anisotropy angle", Limits::hard(0.0, 1.0), Texturable, Anisotropy, Turn;

    /// Multiplier of the emitted radiance.
    emission: Float(0.0), "emissiveIntensity", "Emission", Limits::hard_from(0.0, 10.0), Uniform, Emission, Radiance;
    /// Colour of the emitted light when the emission is 1.
    emission_color: Color([1.0; 3]), "emissive", "Emission color", Limits::open(1.0), Texturable, Emission, None;

    /// Amount of the lustre of woven fibres.
    sheen: Float(0.0), "sheenOpacity", "Sheen opacity", Limits::hard(0.0, 1.0), Texturable, Sheen, None;
    /// Colour of the sheen.
    sheen_color: Color([1.0; 3]), "sheenColor", "Sheen color", Limits::hard(0.0, 1.0), Texturable, Sheen, None;
    /// Range of angles at which the sheen is seen: low values keep it at the silhouette.
    sheen_roughness: Float(0.5), "sheenRoughness", "Sheen roughness", Limits::hard(0.0, 1.0), Texturable, Sheen, None;

    /// Amount of refraction into the body. Metal does not transmit.
    translucency: Float(0.0), "translucency", "Translucency", Limits::hard(0.0, 1.0), Texturable, Interior, None;
    /// Index of refraction of the dielectric relative to its surroundings, for reflection and refraction.
    specular_ior: Float(1.5), "IOR", "Index of refraction", Limits::typical(1.0, 3.0), Uniform, Interior, None;
    /// Chromatic dispersion as 20 divided by the Abbe number. Real glasses lie between 0 and 1, few crystals above.
    dispersion: Float(0.0), "dispersion", "Dispersion", Limits::hard(0.0, 20.0), Uniform, Interior, None;

    /// Colour of white light after the absorption distance in the body.
    absorption_color: Color([1.0; 3]), "absorptionColor", "Absorption color", Limits::hard(0.0, 1.0), Texturable, Absorption, None;
    /// Depth at which the absorption colour is reached. At 0 the colour tints each crossing of the surface instead, whatever the size.
    absorption_distance: Float(0.0), "absorptionDistance", "Absorption distance", Limits::hard_from(0.0, 10.0), Uniform, Absorption, Length;

    /// Enables scattering in the body where translucency is above 0 or opacity below 1.
    scatter: Bool(false), "scatter", "Scatter", Limits::open(1.0), Uniform, Scattering, None;
    /// Overall colour that scattering gives a thick body.
    scatter_color: Color([1.0; 3]), "scatteringColor", "Scattering color", Limits::hard(0.0, 1.0), Texturable, Scattering, None;
    /// Mean free path of the brightest channel: lower values make the body denser.
    scatter_distance: Float(1.0), "scatteringDistance", "Scattering distance", Limits::hard_from(0.0, 10.0), Uniform, Scattering, Length;
    /// Scales the scattering distance by channel.
    scatter_distance_scale: Color([1.0; 3]), "scatteringDistanceScale", "Scattering distance scale", Limits::open(1.0), Texturable, Scattering, None;
    /// Lets red light travel up to ten times further, as blood does in skin.
    scatter_red_shift: Float(0.0), "scatteringRedShift", "Red shift", Limits::typical(0.0, 1.0), Uniform, Scattering, None;
    /// Scatters blue light sooner than red, as small particles do in milk, skin and smoke.
    scatter_rayleigh: Float(0.0), "scatteringRayleigh", "Rayleigh scattering", Limits::typical(0.0, 1.0), Uniform, Scattering, None;

    /// Presence of the coat, a dielectric layer above everything else.
    coat: Float(0.0), "coatOpacity", "Coat opacity", Limits::hard(0.0, 1.0), Texturable, Coat, None;
    /// Tint that the coat gives to all that is seen through it; its own reflection stays untinted.
    coat_color: Color([1.0; 3]), "coatColor", "Coat color", Limits::hard(0.0, 1.0), Texturable, Coat, None;
    /// Roughness of the coat's own reflection.
    coat_roughness: Float(0.0), "coatRoughness", "Coat roughness", Limits::hard(0.0, 1.0), Texturable, Coat, None;
    /// Index of refraction of the coat; it also weakens the reflection of a dielectric below.
    coat_ior: Float(1.6), "coatIOR", "Coat index of refraction", Limits::typical(1.0, 3.0), Uniform, Coat, None;
    /// Modifier of the coat's reflectivity, as the specular level is for the base.
    coat_specular_level: Float(0.5), "coatSpecularLevel", "Coat specular level", Limits::hard(0.0, 1.0), Texturable, Coat, None;
    /// Tangent-space normal map of the coat alone, OpenGL orientation (+Y up).
    coat_normal: Normal([0.0, 0.0, 1.0]), "coatNormal", "Coat normal", Limits::open(1.0), TextureOnly, Coat, None;
    /// Strength of the coat's normal map; 0 switches it off.
    coat_normal_scale: Float(1.0), "coatNormalScale", "Coat normal scale", Limits::typical_from(0.0, 2.0), Uniform, Coat, None;

    /// Share of indirect light that reaches the surface. Rasterisers use it; the path tracer computes occlusion itself.
    ambient_occlusion: Float(1.0), "ambientOcclusion", "Ambient occlusion", Limits::hard(0.0, 1.0), TextureOnly, Auxiliary, None;
    /// Mean thickness of the body below the surface as a fraction of the bounding box width. Rasterisers use it.
    volume_thickness: Float(1.0), "volumeThickness", "Volume thickness", Limits::hard(0.0, 1.0), TextureOnly, Auxiliary, None;
    /// Multiplier of the volume thickness.
    volume_thickness_scale: Float(1.0), "volumeThicknessScale", "Volume thickness scale", Limits::hard_from(0.0, 2.0), Uniform, Auxiliary, None;
}

/// Number of properties.
pub const PROPERTY_COUNT: usize = PROPERTIES.len();

impl Property {
    /// The row of this property.
    pub fn def(self) -> &'static PropertyDef {
        &PROPERTIES[self as usize]
    }

    /// The property with this formal name.
    pub fn from_name(name: &str) -> Option<Self> {
        PROPERTIES.iter().find(|def| def.name == name).map(|def| def.id)
    }

    /// The property with this formal name, usage string or common name.
    pub fn from_any_name(name: &str) -> Option<Self> {
        PROPERTIES.iter().find(|def| def.is_named(name)).map(|def| def.id)
    }
}

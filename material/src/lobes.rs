//! THE SECOND TABLE: what a material needs, decided here and nowhere else.
//!
//! Both renderers, the panel and the tests read [`LOBES`]. A texture counts as "may be on".

use crate::material::Material;
use crate::properties::Property;
use crate::value::Value;

macro_rules! lobes {
    ($( $(#[doc = $doc:literal])+ $name:ident, $switch:literal, [$($property:ident),* $(,)?], $active:expr; )+) => {
        /// Parts of the model that can be left out.
        #[allow(non_camel_case_types)] // Variants are shown and stored by these names.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum Lobe { $( $(#[doc = $doc])+ $name ),+ }

        /// One row per lobe.
        pub const LOBES: &[LobeDef] = &[$( LobeDef {
            lobe: Lobe::$name, name: stringify!($name), switch: $switch,
            properties: &[$(Property::$property),*], active: $active, doc: concat!($($doc),+).trim_ascii(),
        } ),+];
    };
}

/// Facts about one lobe.
#[derive(Clone, Copy, Debug)]
pub struct LobeDef {
    /// Identity; `lobe as usize` is the row number.
    pub lobe: Lobe,
    /// Name in statistics, JSON and tests.
    pub name: &'static str,
    /// WGSL `override` constant that switches it.
    pub switch: &'static str,
    /// Properties that have no effect while the lobe is out.
    pub properties: &'static [Property],
    /// Whether a material needs it.
    pub active: fn(&Material) -> bool,
    /// A sentence for the user: what it is and when it is left out.
    pub doc: &'static str,
}

/// The value that renderers use for what a file holds: the default where that is not a number.
fn number(m: &Material, property: Property) -> f64 {
    let value = m.float(property);
    if let (true, Value::Float(default)) = (value.is_nan(), property.def().default) { default } else { value }
}

fn above(m: &Material, property: Property, limit: f64) -> bool {
    m.is_textured(property) || number(m, property) > limit
}

fn below(m: &Material, property: Property, limit: f64) -> bool {
    m.is_textured(property) || number(m, property) < limit
}

fn not_white(m: &Material, property: Property) -> bool {
    m.is_textured(property) || m.color(property).iter().any(|c| *c < 1.0)
}

fn not_black(m: &Material, property: Property) -> bool {
    m.is_textured(property) || m.color(property).iter().any(|c| *c > 0.0)
}

fn is_dielectric(m: &Material) -> bool {
    below(m, Property::metallic, 1.0)
}

fn transmits(m: &Material) -> bool {
    above(m, Property::translucency, 0.0) && is_dielectric(m)
}

fn has_interior(m: &Material) -> bool {
    transmits(m) || below(m, Property::opacity, 1.0)
}

lobes! {
    /// Metallic reflection; out while metallic is 0.
    metal, "HAS_METAL", [], |m| above(m, Property::metallic, 0.0);
    /// Reflection of the dielectric; out when fully metallic, or without a contrast of refraction.
    specular, "HAS_SPECULAR", [specular_level], |m| {
        is_dielectric(m) && above(m, Property::specular_level, 0.0) && (number(m, Property::specular_ior) != 1.0 || above(m, Property::coat, 0.0))
    };
    /// Diffuse reflection; out when fully metallic or fully translucent.
    diffuse, "HAS_DIFFUSE", [], |m| is_dielectric(m) && below(m, Property::translucency, 1.0);
    /// Refraction into the body; out while translucency is 0 or metallic is 1.
    transmission, "HAS_TRANSMISSION", [], transmits;
    /// Light that meets several facets of rough metal or glass; out for smooth ones, and for opaque dielectrics, whose diffuse reflection takes it.
    multiple_scattering, "HAS_MULTIPLE_SCATTERING", [], |m| {
        (above(m, Property::metallic, 0.0) || transmits(m)) && (above(m, Property::roughness, 0.04) || above(m, Property::anisotropy, 0.0))
    };
    /// Stretched highlights; out while anisotropy is 0.
    anisotropy, "HAS_ANISOTROPY", [anisotropy_rotation], |m| above(m, Property::anisotropy, 0.0) && below(m, Property::roughness, 1.0);
    /// Woven fibres above the base; out while its opacity is 0.
    sheen, "HAS_SHEEN", [sheen_color, sheen_roughness], |m| above(m, Property::sheen, 0.0);
    /// Dielectric layer above everything; out while its opacity is 0.
    coat, "HAS_COAT", [coat_color, coat_roughness, coat_ior, coat_specular_level, coat_normal, coat_normal_scale], |m| above(m, Property::coat, 0.0);
    /// Emitted light; out while emission is 0 or its colour black.
    emission, "HAS_EMISSION", [emission_color], |m| number(m, Property::emission) > 0.0 && not_black(m, Property::emission_color);
    /// Cut-through; out while opacity is 1.
    opacity, "HAS_OPACITY", [], |m| below(m, Property::opacity, 1.0);
    /// Colour by distance or at the crossings; out without an interior or with a white absorption colour.
    absorption, "HAS_ABSORPTION", [], |m| has_interior(m) && not_white(m, Property::absorption_color)
        && (number(m, Property::absorption_distance) > 0.0 || transmits(m));
    /// Scattering in the body; out while scatter is off or nothing lets light in.
    scattering, "HAS_SCATTERING", [scatter_color, scatter_distance, scatter_distance_scale, scatter_red_shift, scatter_rayleigh],
        |m| m.switch(Property::scatter) && has_interior(m);
    /// Wavelength-dependent refraction; out while dispersion is 0 or nothing refracts.
    dispersion, "HAS_DISPERSION", [], |m| number(m, Property::dispersion) > 0.0 && transmits(m) && number(m, Property::specular_ior) != 1.0;
    /// Normal map of the surface; out without a map or at scale 0.
    normal_map, "HAS_NORMAL_MAP", [normal_scale], |m| {
        (m.is_textured(Property::normal) || m.color(Property::normal) != [0.0, 0.0, 1.0]) && number(m, Property::normal_scale) > 0.0
    };
    /// Normal map of the coat; out without a coat, a map or at scale 0.
    coat_normal_map, "HAS_COAT_NORMAL_MAP", [coat_normal_scale], |m| {
        above(m, Property::coat, 0.0)
            && (m.is_textured(Property::coat_normal) || m.color(Property::coat_normal) != [0.0, 0.0, 1.0])
            && number(m, Property::coat_normal_scale) > 0.0
    };
    /// Displacement or bump; out without a height map or at scale 0.
    height, "HAS_HEIGHT", [height_scale, height_level, combine_normal_and_height], |m| {
        (m.is_textured(Property::height) || number(m, Property::height) != number(m, Property::height_level)) && number(m, Property::height_scale) != 0.0
    };
    /// Image textures; out while every value is uniform.
    textures, "HAS_TEXTURES", [], |m| m.slots().any(|(_, slot)| slot.texture.is_some());
}

impl Lobe {
    /// The row of this lobe.
    pub fn def(self) -> &'static LobeDef {
        &LOBES[self as usize]
    }
}

/// The lobes that a material needs, as bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct LobeSet(u32);

impl LobeSet {
    /// No lobe at all.
    pub const EMPTY: Self = Self(0);

    /// Every lobe: what a kernel that leaves nothing out evaluates.
    pub fn all() -> Self {
        LOBES.iter().fold(Self::EMPTY, |set, def| set.with(def.lobe))
    }

    /// What this material needs.
    pub fn of(material: &Material) -> Self {
        LOBES.iter().filter(|def| (def.active)(material)).fold(Self::EMPTY, |set, def| set.with(def.lobe))
    }

    /// Whether a lobe is in.
    pub fn has(self, lobe: Lobe) -> bool {
        self.0 & (1 << lobe as u32) != 0
    }

    /// This set and one more lobe.
    #[must_use]
    pub fn with(self, lobe: Lobe) -> Self {
        Self(self.0 | (1 << lobe as u32))
    }

    /// This set without one lobe.
    #[must_use]
    pub fn without(self, lobe: Lobe) -> Self {
        Self(self.0 & !(1 << lobe as u32))
    }

    /// Lobes of this set that are not in the other.
    #[must_use]
    pub fn minus(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// Lobes in either set.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Names of the lobes that are in, or that are left out.
    pub fn names(self, is_in: bool) -> Vec<&'static str> {
        LOBES.iter().filter(|def| self.has(def.lobe) == is_in).map(|def| def.name).collect()
    }
}

/// Lobes through which a property acts; without all of them it has no effect. Empty: it acts through none in particular.
pub fn acts_through(property: Property) -> Vec<Lobe> {
    match property {
        Property::base_color => vec![Lobe::metal, Lobe::diffuse],
        Property::specular_edge_color => vec![Lobe::metal, Lobe::specular],
        Property::specular_ior => vec![Lobe::specular, Lobe::transmission],
        Property::translucency => vec![Lobe::transmission],
        Property::normal | Property::normal_scale => vec![Lobe::normal_map],
        Property::coat_normal | Property::coat_normal_scale => vec![Lobe::coat_normal_map],
        Property::anisotropy => vec![Lobe::anisotropy],
        Property::dispersion => vec![Lobe::dispersion],
        Property::absorption_color | Property::absorption_distance => vec![Lobe::absorption],
        Property::scatter => vec![Lobe::scattering],
        _ => LOBES.iter().filter(|def| def.properties.contains(&property)).map(|def| def.lobe).collect(),
    }
}

/// The lobe whose absence leaves `property` without effect, whatever its value; `None` if changing it can show.
///
/// This differs from [`LobeDef::properties`] in one respect: a property that would itself bring its lobe in
/// (`dispersion` in a glass, `normal_scale` beside a normal map) is not idle.
pub fn idle_lobe(material: &Material, property: Property) -> Option<&'static LobeDef> {
    let through = acts_through(property);
    let first = *through.first()?;
    let mut probe = material.clone();
    let def = property.def();
    probe.slot_mut(property).texture = Some(crate::TextureRef::new("any"));
    match def.default {
        Value::Float(_) => _ = probe.set(property, Value::Float(def.limits.slider_max)),
        Value::Bool(_) => _ = probe.set(property, Value::Bool(true)),
        Value::Color(_) | Value::Normal(_) => {}
    }
    let lobes = LobeSet::of(&probe);
    if through.iter().any(|lobe| lobes.has(*lobe)) { None } else { Some(first.def()) }
}

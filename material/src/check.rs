//! What is odd about a material: limits, values without effect, and values that no real substance has.
//!
//! Nothing is changed here. Files, textures and duplicates are not looked at: this crate opens no files.

use crate::lobes::idle_lobe;
use crate::material::Material;
use crate::properties::Property;
use crate::slot::Slot;
use crate::value::{Kind, LimitKind, PropertyDef, Value, Vary};

/// How much a finding matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Severity {
    /// Worth knowing: legal and used as it is.
    Note,
    /// Probably not meant: legal, but unlikely or ambiguous.
    Warning,
    /// Outside the specification: renderers use something else than what is written.
    Error,
}

impl Severity {
    /// The word shown before the message.
    pub fn word(self) -> &'static str {
        match self {
            Self::Note => "note",
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }
}

/// What a finding is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FindingKind {
    /// A value outside the range that renderers enforce, or that is no number.
    Range,
    /// A value outside the typical range.
    Typical,
    /// How a texture is placed or used.
    Texture,
    /// A value that no real substance has.
    Unlikely,
    /// Values that are odd only together.
    Combination,
    /// A value without effect.
    Effect,
    /// The unit of lengths.
    Scale,
}

/// One odd thing about a material.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// How much it matters.
    pub severity: Severity,
    /// What it is about.
    pub kind: FindingKind,
    /// The property to look at; `None` for the material as a whole.
    pub property: Option<Property>,
    /// A sentence without the name of the property.
    pub message: String,
}

impl std::fmt::Display for Finding {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self.property {
            Some(property) => write!(f, "{}: {}: {}", self.severity.word(), property.def().name, self.message),
            None => write!(f, "{}: {}", self.severity.word(), self.message),
        }
    }
}

/// Lowest normal-incidence reflectance of any channel among the metals, alloys and metallic nitrides of the measured
/// library: titanium nitride in blue. The next one is gold in blue, 0.31. Linear Rec.709.
const LOWEST_METAL_REFLECTANCE: f64 = 0.23;
/// Diffuse albedo that only fresh snow and optical standards exceed, and that only light traps fall below.
const PLAUSIBLE_ALBEDO: std::ops::RangeInclusive<f64> = 0.02..=0.9;

/// All findings: those of single properties in specification order, then those of their combinations.
pub fn check(material: &Material) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (property, slot) in material.slots() {
        check_slot(property.def(), slot, &mut findings);
        let is_default = slot.value.is_none_or(|value| value == property.def().default) && slot.texture.is_none();
        if let Some(lobe) = Some(property).filter(|_| !is_default).and_then(|property| idle_lobe(material, property)) {
            let message = format!("no effect on this material: {} is left out. {}", lobe.name, lobe.doc);
            findings.push(Finding { severity: Severity::Note, kind: FindingKind::Effect, property: Some(property), message });
        }
    }
    check_unit(material, &mut findings);
    findings.extend(combinations(material));
    findings
}

fn check_slot(def: &PropertyDef, slot: &Slot, findings: &mut Vec<Finding>) {
    let mut add = |severity, kind, message| findings.push(Finding { severity, kind, property: Some(def.id), message });
    if let Some(texture) = &slot.texture {
        if def.vary == Vary::Uniform {
            add(
                Severity::Error,
                FindingKind::Texture,
                "has a texture, but takes one value for the whole material; renderers use the value".into(),
            );
        }
        if texture.path.is_empty() {
            add(Severity::Error, FindingKind::Texture, "has a texture without a path".into());
        }
        let is_direction = def.default.kind() == Kind::Normal;
        let (scale, bias) = (&texture.scale, &texture.bias);
        if [texture.uv_scale, texture.uv_offset, [texture.uv_rotation, 0.0]].iter().flatten().any(|x| !x.is_finite()) {
            add(Severity::Error, FindingKind::Texture, "has a texture whose placement holds a number that is not finite".into());
        } else if scale.iter().chain(bias).any(|x| !x.is_finite()) {
            let message = "has a texture whose scale or bias holds a number that is not finite; renderers use the default";
            add(Severity::Error, FindingKind::Texture, message.into());
        } else if is_direction && (*scale, *bias) != ([1.0; 3], [0.0; 3]) {
            let message = "has a texture with a scale or a bias, which change nothing in a map of directions";
            add(Severity::Note, FindingKind::Effect, message.into());
        } else if !is_direction && *scale == [0.0; 3] {
            let message = "has a texture whose values are scaled by 0, which leaves its bias alone";
            add(Severity::Warning, FindingKind::Texture, message.into());
        }
        if texture.uv_scale.contains(&0.0) {
            add(
                Severity::Warning,
                FindingKind::Texture,
                "has a texture scaled by 0, which shows a single line or point of the image".into(),
            );
        }
    }
    let Some(value) = slot.value else { return };
    let numbers = value.numbers();
    if let Some(bad) = numbers.iter().find(|x| !x.is_finite()) {
        add(Severity::Error, FindingKind::Range, format!("{bad} is not a finite number; renderers use a finite one"));
        return;
    }
    if let (Value::Normal(normal), true) = (value, slot.texture.is_none()) {
        let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
        if (length - 1.0).abs() > 0.01 {
            add(Severity::Warning, FindingKind::Range, format!("has length {length:.3}; a direction has length 1"));
        }
    }
    // Of a colour, the number that is furthest outside speaks for all three.
    let distance = |x: f64| (def.limits.enforce(x) - x).abs();
    let outside = numbers.iter().copied().filter(|x| !def.limits.contains(*x));
    let Some(worst) = outside.max_by(|a, b| distance(*a).total_cmp(&distance(*b))) else { return };
    let range = def.limits.text();
    match def.limits.kind {
        LimitKind::Hard => add(
            Severity::Error,
            FindingKind::Range,
            format!("{worst} is outside the {range}; used as {} by the renderers", def.limits.enforce(worst)),
        ),
        LimitKind::Typical => {
            add(Severity::Note, FindingKind::Typical, format!("{worst} is outside the {range}; legal, and used as it is"))
        }
        LimitKind::Open => {}
    }
}

fn check_unit(material: &Material, findings: &mut Vec<Finding>) {
    if let Some(unit) = material.unit_mm.filter(|unit| !(unit.is_finite() && *unit > 0.0)) {
        let message = format!("unit_mm is {unit}, expected a positive number; used as {}", material.unit_mm());
        findings.push(Finding { severity: Severity::Error, kind: FindingKind::Scale, property: None, message });
    }
}

/// What is odd only together. Textures may hold any value, so a textured property raises nothing here.
fn combinations(m: &Material) -> Vec<Finding> {
    use Property as P;
    let mut findings = Vec::new();
    let mut add = |severity, kind, property: Property, message: String| {
        findings.push(Finding { severity, kind, property: Some(property), message });
    };
    let number = |property| Some(property).filter(|p| !m.is_textured(*p)).map(|p| m.float(p));
    let color = |property| Some(property).filter(|p| !m.is_textured(*p)).map(|p| m.color(p));
    let metallic = number(P::metallic);
    let transmits = number(P::translucency).is_none_or(|x| x > 0.0) && metallic.is_none_or(|x| x < 1.0);
    let has_interior = transmits || number(P::opacity).is_none_or(|x| x < 1.0);

    if let Some(metallic) = metallic.filter(|x| *x > 0.0 && *x < 1.0) {
        let message = format!("{metallic} is between a dielectric and a metal, which no homogeneous substance is");
        add(Severity::Note, FindingKind::Unlikely, P::metallic, message);
    }
    if let Some(base) = color(P::base_color) {
        let lowest = base.iter().copied().fold(f64::INFINITY, f64::min);
        if metallic == Some(1.0) && lowest < LOWEST_METAL_REFLECTANCE {
            let channel = ["red", "green", "blue"][base.iter().position(|x| *x == lowest).unwrap_or(0)];
            let message = format!(
                "reflectance {lowest} in {channel} is below every metal and alloy in the library (lowest: titanium nitride \
                 {LOWEST_METAL_REFLECTANCE}, gold 0.31)"
            );
            // Below a coat it may be flakes in a tinted lacquer.
            let is_bare = number(P::coat) == Some(0.0);
            add(if is_bare { Severity::Warning } else { Severity::Note }, FindingKind::Unlikely, P::base_color, message);
        }
        // Of what shines by itself, what it reflects is of no account.
        let is_diffuse = metallic == Some(0.0) && m.float(P::emission) <= 0.0 && number(P::translucency).is_none_or(|x| x < 1.0);
        let highest = base.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if is_diffuse && lowest > *PLAUSIBLE_ALBEDO.end() && lowest <= 1.0 {
            add(
                Severity::Note,
                FindingKind::Unlikely,
                P::base_color,
                format!("an albedo of {lowest} or more is brighter than anything but fresh snow"),
            );
        }
        if is_diffuse && (0.0..*PLAUSIBLE_ALBEDO.start()).contains(&highest) {
            add(
                Severity::Note,
                FindingKind::Unlikely,
                P::base_color,
                format!("an albedo of {highest} or less is darker than soot"),
            );
        }
    }
    for (property, lobe_in) in [(P::specular_ior, true), (P::coat_ior, number(P::coat).is_none_or(|x| x > 0.0))] {
        let ior = m.float(property);
        if lobe_in && ior < 1.0 {
            let message = format!("{ior} is below 1: light would be faster inside than in air, as in no solid or liquid");
            add(Severity::Warning, FindingKind::Unlikely, property, message);
        }
    }
    if number(P::coat).is_none_or(|x| x > 0.0) && m.float(P::coat_ior) == 1.0 {
        add(
            Severity::Note,
            FindingKind::Effect,
            P::coat_ior,
            "a coat of index 1 has no reflection of its own; it only tints".into(),
        );
    }
    if transmits && number(P::opacity).is_none_or(|x| x < 1.0) {
        let message = "below 1 together with translucency: opacity is evaluated at every interface, so light also passes without refraction";
        add(Severity::Warning, FindingKind::Combination, P::opacity, message.into());
    }
    if m.switch(P::scatter) && has_interior && m.float(P::scatter_distance) == 0.0 {
        let message = "0 while scatter is on: no light could enter; renderers use the smallest distance they can";
        add(Severity::Error, FindingKind::Combination, P::scatter_distance, message.into());
    }
    if m.float(P::absorption_distance) > 0.0 && color(P::absorption_color) == Some([1.0; 3]) {
        add(
            Severity::Note,
            FindingKind::Effect,
            P::absorption_distance,
            "no effect with a white absorption color, which absorbs nothing".into(),
        );
    }
    if m.float(P::dispersion) > 2.5 && transmits {
        let message = format!("{} is beyond every measured transparent crystal (zinc selenide: 2.48)", m.float(P::dispersion));
        add(Severity::Note, FindingKind::Unlikely, P::dispersion, message);
    }
    findings
}

/// Whether any finding is an error.
pub fn has_errors(findings: &[Finding]) -> bool {
    findings.iter().any(|finding| finding.severity == Severity::Error)
}

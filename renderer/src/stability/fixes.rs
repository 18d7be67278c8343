//! What brings a material back to where it holds: named lists of changed values.

use super::{Check, Report};
use burnish_material::{Kind, LimitKind, Lobe, LobeSet, Material, PROPERTIES, Property, Value};

/// A change that can be made in one step.
#[derive(Clone, Debug, PartialEq)]
pub struct Fix {
    /// What it does, for a button: `Set Scatter distance to 0.001`.
    pub name: String,
    /// Why, in a sentence.
    pub reason: String,
    /// New values; images in the slots stay.
    pub changes: Vec<(Property, Value)>,
}

impl Fix {
    fn new(changes: Vec<(Property, Value)>, reason: impl Into<String>) -> Self {
        let names: Vec<String> = changes.iter().map(|(p, v)| format!("{} to {}", p.def().label, text(*v))).collect();
        Self { name: format!("Set {}", names.join(" and ")), reason: reason.into(), changes }
    }

    /// Makes the changes.
    pub fn apply(&self, material: &mut Material) {
        for (property, value) in &self.changes {
            material.set(*property, *value);
        }
    }
}

/// Shortest mean free path that is followed event by event in reasonable time, units of the material: a ten-thousandth of a small body.
const SCATTER_DISTANCE_SAFE: f64 = 1e-3;
/// Shorter ones count as a risk.
const SCATTER_DISTANCE_RISKY: f64 = 1e-6;
/// Shortest absorption distance with a dark colour that still lets some light through a thin part, units of the material.
const ABSORPTION_DISTANCE_SAFE: f64 = 1e-2;
/// Shorter ones make a body with this or a darker colour black.
const ABSORPTION_DISTANCE_RISKY: f64 = 1e-3;
const ABSORPTION_COLOR_DARK: f64 = 0.05;
/// Roughness below which a stretched highlight is narrower across than single precision resolves well.
const STRETCHED_ROUGHNESS_MIN: f64 = 0.02;
/// Largest dispersion of a measured transparent crystal (zinc selenide).
const DISPERSION_REAL: f64 = 2.48;
/// Index of refraction from which strong dispersion leaves the range of any substance.
const DISPERSION_IOR: f64 = 2.0;
/// Emission beyond which neighbouring samples lose their digits in single precision.
const EMISSION_SAFE: f64 = 1e6;
/// Contrast of refraction that half vectors resolve in single precision.
const CONTRAST_MIN: f64 = 1e-3;

/// Changes for what the report found and for values at which numbers get hard. The material may be changed in any order; nothing else
/// about it changes.
pub fn fixes(material: &Material, report: Option<&Report>) -> Vec<Fix> {
    let mut fixes = outside(material);
    risky(material, &mut fixes);
    if let Some(report) = report.filter(|report| !report.holds()) {
        found(material, report, &mut fixes);
    }
    fixes
}

/// Values that are not finite or outside a range that renderers enforce.
fn outside(material: &Material) -> Vec<Fix> {
    let mut fixes = Vec::new();
    for def in PROPERTIES {
        let Some(value) = material.slot(def.id).value else { continue };
        let is_bad = |x: &f64| !x.is_finite() || (def.limits.kind == LimitKind::Hard && !def.limits.contains(*x));
        if !value.numbers().iter().any(is_bad) {
            continue;
        }
        let fix = |x: f64, default: f64| if x.is_finite() { def.limits.enforce(x) } else { default };
        let safe = match (value, def.default) {
            (Value::Float(x), Value::Float(d)) => Value::Float(fix(x, d)),
            (Value::Color(x), Value::Color(d)) => Value::Color(std::array::from_fn(|k| fix(x[k], d[k]))),
            (_, default) => default,
        };
        let reason = format!("{} is outside what renderers take; they use another value than the file says.", def.label);
        fixes.push(Fix::new(vec![(def.id, safe)], reason));
    }
    fixes
}

/// Values and pairs of values at which numbers get hard.
fn risky(m: &Material, fixes: &mut Vec<Fix>) {
    use Property as P;
    let lobes = LobeSet::of(m);
    let mut set = |property, value, reason: &str| {
        if !fixes.iter().any(|fix| fix.changes.iter().any(|(p, _)| *p == property)) {
            fixes.push(Fix::new(vec![(property, Value::Float(value))], reason));
        }
    };
    if lobes.has(Lobe::scattering) && m.float(P::scatter_distance) < SCATTER_DISTANCE_RISKY {
        set(
            P::scatter_distance,
            SCATTER_DISTANCE_SAFE,
            "The medium is denser than any that was measured: light cannot enter, and following it takes long.",
        );
    }
    let darkest = m.color(P::absorption_color).into_iter().fold(f64::INFINITY, f64::min);
    let distance = m.float(P::absorption_distance);
    if lobes.has(Lobe::absorption) && distance > 0.0 && distance < ABSORPTION_DISTANCE_RISKY && darkest < ABSORPTION_COLOR_DARK {
        set(P::absorption_distance, ABSORPTION_DISTANCE_SAFE, "With so dark a colour nothing passes even the thinnest part.");
    }
    let is_narrow = !m.is_textured(P::roughness) && m.float(P::roughness) < STRETCHED_ROUGHNESS_MIN;
    if lobes.has(Lobe::anisotropy) && is_narrow {
        set(
            P::roughness,
            STRETCHED_ROUGHNESS_MIN,
            "A stretched highlight without roughness is a line without width, which samples find only by chance.",
        );
    }
    if lobes.has(Lobe::dispersion) && m.float(P::dispersion) > DISPERSION_REAL && m.float(P::specular_ior) >= DISPERSION_IOR {
        set(P::dispersion, DISPERSION_REAL, "With this index of refraction no substance separates colours as far.");
    }
    if lobes.has(Lobe::emission) && m.float(P::emission) > EMISSION_SAFE {
        set(P::emission, EMISSION_SAFE, "Beyond this the emission drowns all other light in single precision.");
    }
    let ior = m.float(P::specular_ior);
    if lobes.has(Lobe::transmission) && ior != 1.0 && (ior - 1.0).abs() < CONTRAST_MIN {
        set(P::specular_ior, 1.0, "So little contrast is not resolved; at exactly 1 light passes straight on.");
    }
}

/// What a finding calls for where no single value stands out.
fn found(m: &Material, report: &Report, fixes: &mut Vec<Fix>) {
    let is_changed = |fixes: &[Fix], property| fixes.iter().any(|fix| fix.changes.iter().any(|(p, _)| *p == property));
    let lobes = LobeSet::of(m);
    let mut bring = |check: Check, property: Property, safe: f64, is_due: bool, reason: &str| {
        if report.failed.contains(&check) && is_due && !is_changed(fixes, property) {
            fixes.push(Fix::new(vec![(property, Value::Float(safe))], reason));
        }
    };
    let rough = m.float(Property::roughness);
    for check in [Check::Precision, Check::PdfMismatch, Check::Density] {
        bring(
            check,
            Property::roughness,
            0.05,
            rough > 0.0 && rough < 0.05 && !m.is_textured(Property::roughness),
            "Wider highlights are resolved in single precision.",
        );
        bring(
            check,
            Property::coat_roughness,
            0.05,
            lobes.has(Lobe::coat) && (1e-9..0.05).contains(&m.float(Property::coat_roughness)),
            "Wider highlights of the coat are resolved in single precision.",
        );
    }
    for check in [Check::Gain, Check::Loss, Check::Brightness] {
        let ior = m.float(Property::specular_ior);
        bring(
            check,
            Property::specular_ior,
            3.0,
            ior > 3.0,
            "Indices of refraction above 3 leave the range the tables are made for.",
        );
        bring(
            check,
            Property::specular_ior,
            1.0,
            ior < 1.0,
            "Indices of refraction below 1 leave the range the tables are made for.",
        );
        let coat_ior = m.float(Property::coat_ior);
        bring(
            check,
            Property::coat_ior,
            coat_ior.clamp(1.0, 3.0),
            lobes.has(Lobe::coat) && !(1.0..=3.0).contains(&coat_ior),
            "Indices of refraction of the coat are meant to lie between 1 and 3.",
        );
    }
    bring(
        Check::Time,
        Property::scatter_distance,
        (10.0 * m.float(Property::scatter_distance)).max(SCATTER_DISTANCE_SAFE),
        lobes.has(Lobe::scattering),
        "A thinner medium has fewer events to follow.",
    );
}

/// A value in few digits.
fn text(value: Value) -> String {
    match value {
        Value::Float(x) => x.to_string(),
        Value::Bool(x) => (if x { "on" } else { "off" }).to_owned(),
        Value::Color(v) | Value::Normal(v) => {
            debug_assert!(matches!(value.kind(), Kind::Color | Kind::Normal));
            format!("({}, {}, {})", v[0], v[1], v[2])
        }
    }
}

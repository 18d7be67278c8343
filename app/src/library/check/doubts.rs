//! What is legal and hardly meant: values beside those of real materials, lengths in the wrong unit, data without an origin.

use burnish_material::{Finding, FindingKind, Material, MaterialFile, Property, Unit};
use burnish_presets::measured::{nearest, neighbours, sentence, zone};

/// Metals of a colour farther from every measured one, in OKLab, are none.
const FAR: f64 = 0.1;
/// Scattering distances beyond the measured ones by more than this factor are doubted; a tenth of the shortest one is still paint.
const SCATTER_FACTOR: f64 = 30.0;
/// The same for absorption, which a body of any colour may have.
const ABSORPTION_FACTOR: f64 = 100.0;
/// Units that somebody may measure in: from micrometres to kilometres.
const UNITS_MM: std::ops::RangeInclusive<f64> = 1e-3..=1e6;

/// The message of a finding; if it is about an unlikely value, with the measured material that comes nearest.
pub fn with_nearest(material: &Material, finding: &Finding) -> String {
    let property = finding.property.filter(|_| finding.kind == FindingKind::Unlikely);
    match property.and_then(|property| sentence(material, property)) {
        Some(sentence) => format!("{}. {sentence}", finding.message),
        None => finding.message.clone(),
    }
}

/// Values that no measured material has, beside those of `findings`; each with the nearest one.
pub fn unlikely(material: &Material, findings: &[Finding]) -> Vec<(Property, String)> {
    let number = |property| (!material.is_textured(property)).then(|| material.float(property));
    let is_metal = number(Property::metallic) == Some(1.0);
    let mut found = Vec::new();
    let mut add = |property: Property, message: &str| {
        let is_known = findings.iter().any(|f| f.kind == FindingKind::Unlikely && f.property == Some(property));
        if let Some(sentence) = sentence(material, property).filter(|_| !is_known) {
            found.push((property, format!("{message}. {sentence}")));
        }
    };
    if is_metal && nearest(material, Property::base_color).is_some_and(|near| near.distance > FAR) {
        add(Property::base_color, "no measured metal has a colour like this");
    }
    let indices = [(Property::specular_ior, !is_metal), (Property::coat_ior, number(Property::coat).is_none_or(|x| x > 0.0))];
    for (property, _) in indices.into_iter().filter(|(_, is_used)| *is_used) {
        if neighbours(material, property).is_some_and(|near| near.below.is_none() || near.above.is_none()) {
            add(property, "no measured body has an index like this");
        }
    }
    found
}

/// Lengths that make no sense in the unit of the file. Keys are properties or `unit_mm`.
pub fn scale(file: &MaterialFile) -> Vec<(&'static str, String)> {
    let material = file.material();
    let mut found = Vec::new();
    if let Some(unit) = material.unit_mm.filter(|unit| unit.is_finite() && *unit > 0.0 && !UNITS_MM.contains(unit)) {
        let (least, most) = UNITS_MM.into_inner();
        found.push(("unit_mm", format!("a unit of {unit:?} mm is hardly meant; expected {least:?} to {most:?}")));
    }
    let used: Vec<Property> = used_lengths(material).collect();
    for property in &used {
        let factor = if *property == Property::scatter_distance { SCATTER_FACTOR } else { ABSORPTION_FACTOR };
        let Some((least, most)) = zone(material, *property) else { continue };
        let value = material.float(*property);
        let (side, times, end) = if value * factor < least {
            ("shorter than the shortest", least / value, least)
        } else if value > most * factor {
            ("longer than the longest", value / most, most)
        } else {
            continue;
        };
        let unit = material.unit_mm();
        // Whether the number is a usual one where it is taken for millimetres.
        let is_mm = material.unit_mm.is_none() && (least * unit..=most * unit).contains(&value);
        let advice = if is_mm { "; if it is in mm, the file lacks unit_mm: 1.0" } else { "" };
        let sentence = format!(
            "{value:?} is {} mm, {} times {side} measured ({} mm){advice}",
            short(value * unit),
            short(times),
            short(end * unit)
        );
        found.push((property.def().name, sentence));
    }
    if material.unit_mm.is_none()
        && found.is_empty()
        && used.iter().any(|property| material.slot(*property).value.is_some())
        && speaks_of_mm(file, &used)
    {
        let sentence = format!("is absent, so that lengths are in units of {} mm, but the texts speak of mm", material.unit_mm());
        found.push(("unit_mm", sentence));
    }
    found
}

/// What is not said of where the data come from.
pub fn provenance(material: &Material) -> Vec<(&'static str, &'static str)> {
    let texts = [
        ("provenance.source", &material.provenance.source, "where the values come from is not said"),
        ("provenance.licence", &material.provenance.licence, "the licence is not said"),
    ];
    texts.into_iter().filter(|(_, text, _)| text.trim().is_empty()).map(|(key, _, message)| (key, message)).collect()
}

/// Lengths inside the body that act on the picture.
fn used_lengths(material: &Material) -> impl Iterator<Item = Property> {
    let number = |property| (!material.is_textured(property)).then(|| material.float(property));
    let transmits = number(Property::translucency).is_none_or(|x| x > 0.0) && number(Property::metallic).is_none_or(|x| x < 1.0);
    let has_interior = transmits || number(Property::opacity).is_none_or(|x| x < 1.0);
    let lengths = [
        (Property::scatter_distance, material.switch(Property::scatter) && has_interior),
        (Property::absorption_distance, transmits && !material.is_textured(Property::absorption_color)),
    ];
    let is_positive = |property: &Property| material.float(*property) > 0.0 && material.float(*property).is_finite();
    lengths
        .into_iter()
        .filter(|(_, is_used)| *is_used)
        .map(|(property, _)| property)
        .filter(is_positive)
        .collect::<Vec<_>>()
        .into_iter()
}

/// Whether notes or sources say that lengths are in millimetres, and nothing says that they are in units of 100 mm.
fn speaks_of_mm(file: &MaterialFile, lengths: &[Property]) -> bool {
    let material = file.material();
    debug_assert!(lengths.iter().all(|property| property.def().unit == Unit::Length));
    let methods = lengths.iter().filter_map(|property| Some(file.source_of(*property)?.method));
    let texts = [material.notes.clone(), material.provenance.method.clone()].into_iter().chain(methods);
    let text = texts.collect::<Vec<_>>().join(" ").to_lowercase();
    let words: Vec<&str> = text.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()).collect();
    let is_mm = |word: &str| ["mm", "millimetre", "millimetres", "millimeter", "millimeters"].contains(&word);
    let is_hundred = |at: usize| at > 0 && words[at - 1] == "100";
    let places: Vec<usize> = (0..words.len()).filter(|at| is_mm(words[*at])).collect();
    !places.is_empty() && !places.iter().any(|at| is_hundred(*at))
}

/// Three digits.
fn short(x: f64) -> String {
    if !(1e-4..1e7).contains(&x) {
        return format!("{x:.2e}");
    }
    let digits = (2.0 - x.log10().floor()).clamp(0.0, 12.0) as usize;
    let text = format!("{x:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scale_keys(text: &str) -> Vec<&'static str> {
        let (file, _) = MaterialFile::parse(text).unwrap();
        scale(&file).into_iter().map(|(key, _)| key).collect()
    }

    #[test]
    fn lengths_are_doubted_where_no_body_has_them() {
        let milk = |rest: &str, distance: &str| {
            format!("{{{rest} \"properties\": {{\"translucency\": 1.0, \"scatter\": true, \"scatter_distance\": {distance}}}}}")
        };
        for (rest, distance, expected) in [
            ("", "0.004", &[][..]),
            ("", "1.0", &[]),
            ("", "5.0", &["scatter_distance"]),
            ("\"unit_mm\": 1.0,", "5.0", &[]),
            ("\"unit_mm\": 1.0,", "0.0001", &["scatter_distance"]),
            ("\"unit_mm\": 1e9,", "1.0", &["unit_mm", "scatter_distance"]),
            ("\"notes\": \"Distances in mm.\",", "0.4", &["unit_mm"]),
            ("\"notes\": \"Distances in mm.\", \"unit_mm\": 1.0,", "0.4", &[]),
            ("\"notes\": \"In units of 100 mm: 1.5 mm.\",", "0.4", &[]),
        ] {
            assert_eq!(scale_keys(&milk(rest, distance)), expected, "{rest} {distance}");
        }
        let (file, _) = MaterialFile::parse(&milk("", "5.0")).unwrap();
        let message = &scale(&file)[0].1;
        assert!(message.contains("is 500 mm, 82.5 times longer") && message.ends_with("lacks unit_mm: 1.0"), "{message}");
        // Without a body nothing scatters.
        assert_eq!(scale_keys("{\"properties\": {\"scatter\": true, \"scatter_distance\": 5.0}}"), [""; 0]);
    }
}

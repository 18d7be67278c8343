//! The line that an editor shows below a value.

use burnish_material::{Material, Property, Unit, Value};

use super::compare::{Near, Neighbours, extremes, is_metal, nearest, neighbours, opposite};

/// Colours closer than this look alike, in OKLab.
const ALIKE: f64 = 0.01;
/// Colours farther than this have little in common, in OKLab.
const FAR: f64 = 0.1;

/// One line that names the measured materials around a value: `Nearest measured: Diamond (2.418)`, `Between Copper (…) and
/// Gold (…)`, `Above every measured one; highest: Zinc selenide (2.479)`, `Far from every measured one; nearest: Brick (…)`.
/// A base colour of a metal whose channels are beyond all metals says so, with the two metals that come nearest.
///
/// `None` where [`nearest`] is.
pub fn sentence(material: &Material, property: Property) -> Option<String> {
    let near = nearest(material, property)?;
    let show = |near: &Near| {
        let value = match near.value {
            Value::Float(value) if property.def().unit == Unit::Length => length(value, material.unit_mm()),
            Value::Color(color) => color.map(number).join(", "),
            value => value.numbers().iter().map(|x| number(*x)).collect(),
        };
        format!("{} ({value})", near.measured.name)
    };
    let single = || {
        let how = if near.measured.is_computed() { "computed" } else { "measured" };
        format!("Nearest {how}: {}", show(&near))
    };
    let line = match (neighbours(material, property), near.value) {
        (Some(Neighbours { below: None, above: Some(lowest) }), _) => {
            format!("Below every measured one; lowest: {}", show(&lowest))
        }
        (Some(Neighbours { below: Some(highest), above: None }), _) => {
            format!("Above every measured one; highest: {}", show(&highest))
        }
        (Some(Neighbours { below: Some(below), above: Some(above) }), Value::Float(at))
            if number(at) != number(material.float(property)) =>
        {
            format!("Between {} and {}", show(&below), show(&above))
        }
        // A scale per channel is not a colour.
        (None, Value::Color(_)) if property == Property::scatter_distance_scale || near.distance <= ALIKE => single(),
        (None, Value::Color(_)) if near.distance > FAR => format!("Far from every measured one; nearest: {}", show(&near)),
        (None, Value::Color(_)) => match opposite(material, property, &near).filter(|other| other.distance <= FAR) {
            Some(other) => format!("Between {} and {}", show(&near), show(&other)),
            None => single(),
        },
        _ => single(),
    };
    let is_metal = property == Property::base_color && is_metal(material);
    Some(if is_metal { line + &beyond_metals(material.color(property)) } else { line })
}

/// What is to be said of channels that no metal has.
fn beyond_metals(color: [f64; 3]) -> String {
    let mut text = String::new();
    for (channel, name) in ["red", "green", "blue"].into_iter().enumerate() {
        for (is_highest, side, end) in [(false, "below", "lowest"), (true, "above", "highest")] {
            let ends = extremes(channel, is_highest);
            let is_beyond = |end: f64| if is_highest { color[channel] > end } else { color[channel] < end };
            if ends[0].is_some_and(|(end, _)| is_beyond(end)) {
                let metals = ends.iter().flatten().map(|(value, row)| format!("{} {}", row.name, number(*value)));
                let metals = metals.collect::<Vec<_>>().join(", ");
                text += &format!("; {name} {} is {side} every measured metal ({end}: {metals})", number(color[channel]));
            }
        }
    }
    text
}

/// A length in the material's unit, and in millimetres where that is another one.
fn length(value: f64, unit_mm: f64) -> String {
    let mm = number(value * unit_mm);
    if unit_mm == 1.0 { format!("{mm} mm") } else { format!("{}, {mm} mm", number(value)) }
}

/// Four digits, without zeros at the end.
fn number(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return if x == 0.0 { "0".into() } else { x.to_string() };
    }
    let decimals = (3.0 - x.abs().log10().floor()).clamp(0.0, 9.0) as usize;
    let text = format!("{x:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits() {
        let shown = [0.0, 1.0, 1.5168, 0.3073, 0.000391994, 9332.4, 123456.0, -0.5].map(number);
        assert_eq!(shown, ["0", "1", "1.517", "0.3073", "0.000392", "9332", "123456", "-0.5"]);
    }
}

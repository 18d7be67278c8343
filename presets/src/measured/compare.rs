//! Distances between a material's values and the measured ones.
//!
//! Plain numbers differ by their difference, lengths by the logarithm of their ratio, colours by their distance in OKLab.

use std::sync::OnceLock;

use burnish_material::{Material, Property, Unit, Value};

use super::{Measured, measured};

/// A measurement beside a value of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Near {
    /// What was measured, with its name and sources.
    pub measured: &'static Measured,
    /// What the material's value would be if it were this one: lengths in the material's unit, and absorption as
    /// [`nearest`] explains.
    pub value: Value,
    /// How far the material's value is from it, at least 0: a difference for plain numbers, the logarithm of the
    /// ratio for lengths, a distance in OKLab for colours (0.02 is just visible), the length of the three logarithms of the
    /// ratios for a scale per channel.
    pub distance: f64,
}

/// The measurements between which a number lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neighbours {
    /// The highest that is not above the value; `None` if the value is below all.
    pub below: Option<Near>,
    /// The lowest that is not below the value; `None` if the value is above all. Equals `below` where the value was measured.
    pub above: Option<Near>,
}

/// Measured numbers of one property, rising, each value once with the first measurement that has it.
type Numbers = Vec<(f64, &'static Measured)>;

/// Measured colours of one property, with their places in the space of comparison.
type Colors = Vec<([f64; 3], &'static Measured)>;

/// From a colour to its place in the space of comparison.
type Place = fn([f64; 3]) -> [f64; 3];

/// What is compared, sorted out once.
struct Tables {
    index: Numbers,
    dispersion: Numbers,
    scatter_distance: Numbers,
    /// 1 over the mean absorption coefficient, mm.
    absorption: Numbers,
    metal_base: Colors,
    diffuse_base: Colors,
    edge: Colors,
    scatter_color: Colors,
    scatter_scale: Colors,
    emission: Colors,
    /// Absorption coefficients per mm, which become places only at a depth.
    coefficients: Colors,
}

fn tables() -> &'static Tables {
    static TABLES: OnceLock<Tables> = OnceLock::new();
    TABLES.get_or_init(|| {
        let is_metal = |row: &Measured| row.value(Property::metallic).is_some();
        let colors = |property: Property, place: Place| -> Colors {
            measured().iter().filter_map(|row| Some((place(row.color(property)?), row))).collect()
        };
        let (metal_base, diffuse_base) = colors(Property::base_color, oklab).into_iter().partition(|(_, row)| is_metal(row));
        let coefficients: Colors = measured()
            .iter()
            .filter_map(|row| {
                let distance = row.float(Property::absorption_distance)?;
                Some((row.color(Property::absorption_color)?.map(|c| depth(c) / distance), row))
            })
            .collect();
        Tables {
            index: numbers(|row| row.float(Property::specular_ior)),
            dispersion: numbers(|row| row.float(Property::dispersion)),
            scatter_distance: numbers(|row| row.float(Property::scatter_distance)),
            absorption: numbers(|row| row.float(Property::absorption_distance)),
            metal_base,
            diffuse_base,
            edge: colors(Property::specular_edge_color, oklab),
            scatter_color: colors(Property::scatter_color, oklab),
            scatter_scale: colors(Property::scatter_distance_scale, logarithms),
            emission: colors(Property::emission_color, chroma),
            coefficients,
        }
    })
}

fn numbers(value: impl Fn(&Measured) -> Option<f64>) -> Numbers {
    let mut numbers: Numbers = measured().iter().filter_map(|row| Some((value(row)?, row))).collect();
    numbers.sort_by(|a, b| a.0.total_cmp(&b.0));
    numbers.dedup_by_key(|(value, _)| *value);
    numbers
}

/// Measured numbers, and the factor from them to values of this material. `None` where nothing was measured, or where the
/// property has no meaning in this material.
fn numbers_for(material: &Material, property: Property) -> Option<(&'static Numbers, f64)> {
    let tables = tables();
    match property {
        Property::specular_ior | Property::coat_ior => Some((&tables.index, 1.0)),
        Property::dispersion => Some((&tables.dispersion, 1.0)),
        Property::scatter_distance => Some((&tables.scatter_distance, 1.0 / material.unit_mm())),
        Property::absorption_distance => {
            // The same body looks deeper in colour further in: a distance is real only for a colour.
            let depth = material.color(Property::absorption_color).map(depth).iter().sum::<f64>() / 3.0;
            (depth > 0.0).then(|| (&tables.absorption, depth / material.unit_mm()))
        }
        _ => None,
    }
}

/// Measured colours that this colour of the material may be compared with, and its own place among them.
fn colors_for(material: &Material, property: Property) -> Option<(&'static Colors, [f64; 3])> {
    let tables = tables();
    let is_metal = is_metal(material);
    let (colors, place): (_, Place) = match property {
        Property::base_color if is_metal => (&tables.metal_base, oklab),
        Property::base_color if material.float(Property::translucency) < 1.0 => (&tables.diffuse_base, oklab),
        Property::specular_edge_color if is_metal => (&tables.edge, oklab),
        Property::scatter_color => (&tables.scatter_color, oklab),
        Property::scatter_distance_scale => (&tables.scatter_scale, logarithms),
        Property::emission_color => (&tables.emission, chroma),
        _ => return None,
    };
    let color = finite(material.color(property))?;
    // Black has no colour to shine in.
    let is_dark = property == Property::emission_color && !color.iter().any(|c| *c > 0.0);
    (!is_dark).then(|| (colors, place(color)))
}

/// Whether a base colour of this material is that of a metal.
pub(super) fn is_metal(material: &Material) -> bool {
    material.float(Property::metallic) >= 0.5
}

/// The measurement that a value of the material comes closest to. `None` where nothing comparable was measured, the value is
/// not finite, or a texture replaces it.
///
/// - `base_color` of a metal is compared with reflections of metals, that of a dielectric with diffuse colours, and that
///   of a clear body with nothing. `specular_edge_color` is compared for metals only.
/// - `emission_color` is compared without its brightness, `coat_ior` with indices of all clear bodies.
/// - `absorption_color` is compared with the colours that measured bodies show at the material's `absorption_distance`.
///   `absorption_distance` is compared by mean absorption: its value is where the measured body would have as
///   deep a colour. With a distance of 0 or a white colour the material does not absorb, and there is no nearest.
/// - Whether scattering, coat or emission are switched on does not matter.
pub fn nearest(material: &Material, property: Property) -> Option<Near> {
    if material.is_textured(property) {
        return None;
    }
    if property == Property::absorption_color {
        return nearest_absorption(material);
    }
    if let Some((colors, place)) = colors_for(material, property) {
        let near = colors.iter().map(|(at, row)| (squared(*at, place), *row)).min_by(|a, b| a.0.total_cmp(&b.0));
        return near
            .and_then(|(squared, row)| Some(Near { measured: row, value: row.value(property)?, distance: squared.sqrt() }));
    }
    let Neighbours { below, above } = neighbours(material, property)?;
    [below, above].into_iter().flatten().min_by(|a, b| a.distance.total_cmp(&b.distance))
}

/// A second measurement so that the colour lies between it and [`nearest`]: seen from the colour, at least 120 degrees are
/// between them. `None` where there is none, or where colours are not compared.
pub(super) fn opposite(material: &Material, property: Property, nearest: &Near) -> Option<Near> {
    let (colors, place) = colors_for(material, property)?;
    let (first, _) = colors.iter().find(|(_, row)| std::ptr::eq(*row, nearest.measured))?;
    let is_opposite = |at: &[f64; 3]| {
        let dot: f64 = (0..3).map(|c| (at[c] - place[c]) * (first[c] - place[c])).sum();
        dot < -0.5 * squared(*at, place).sqrt() * nearest.distance
    };
    let others = colors.iter().filter(|(at, _)| is_opposite(at)).map(|(at, row)| (squared(*at, place), *row));
    let (squared, row) = others.min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(Near { measured: row, value: row.value(property)?, distance: squared.sqrt() })
}

/// The measurements between which a number of the material lies. `None` for colours, and as for [`nearest`].
pub fn neighbours(material: &Material, property: Property) -> Option<Neighbours> {
    let (numbers, scale) = numbers_for(material, property)?;
    let value = material.float(property);
    let is_off = property == Property::absorption_distance && value <= 0.0;
    if material.is_textured(property) || !value.is_finite() || is_off {
        return None;
    }
    let near = |&(mm, row): &(f64, &'static Measured)| {
        let (at, is_length) = (mm * scale, property.def().unit == Unit::Length);
        let distance = if is_length { (value.max(1e-12) / at).ln().abs() } else { (value - at).abs() };
        Near { measured: row, value: Value::Float(at), distance }
    };
    let above = numbers.partition_point(|(at, _)| at * scale < value);
    let below = numbers.partition_point(|(at, _)| at * scale <= value);
    Some(Neighbours { below: below.checked_sub(1).map(|i| near(&numbers[i])), above: numbers.get(above).map(near) })
}

/// The nearest measured body by its colour at the material's absorption distance.
fn nearest_absorption(material: &Material) -> Option<Near> {
    let distance = material.float(Property::absorption_distance);
    let color = finite(material.color(Property::absorption_color))?;
    if !distance.is_finite() || distance <= 0.0 || color.map(depth) == [0.0; 3] {
        return None;
    }
    let place = oklab(color);
    let shown = |sigma: &[f64; 3]| sigma.map(|sigma| (-sigma * distance * material.unit_mm()).exp());
    let near = tables().coefficients.iter().map(|(sigma, row)| {
        let color = shown(sigma);
        Near { measured: row, value: Value::Color(color), distance: squared(oklab(color), place).sqrt() }
    });
    near.min_by(|a, b| a.distance.total_cmp(&b.distance))
}

/// Lowest and highest measured value of a number, in the material's unit; gases and the vacuum are left out, as no surface
/// is made of them. `None` where nothing comparable was measured.
///
/// The zone of `absorption_distance` depends on the material's `absorption_color`, as [`nearest`] explains.
pub fn zone(material: &Material, property: Property) -> Option<(f64, f64)> {
    let (numbers, scale) = numbers_for(material, property)?;
    let mut solid = numbers.iter().filter(|(_, row)| row.group != "gas").map(|(at, _)| at * scale);
    let first = solid.next()?;
    Some((first, solid.next_back().unwrap_or(first)))
}

/// The distinct measured values of a number inside its [`zone`], rising, in the material's unit. Empty where there is no zone.
pub fn marks(material: &Material, property: Property) -> impl Iterator<Item = f64> {
    let solid = |(numbers, scale): (&'static Numbers, f64)| {
        numbers.iter().filter(|(_, row)| row.group != "gas").map(move |(at, _)| at * scale)
    };
    numbers_for(material, property).into_iter().flat_map(solid)
}

/// Lowest or highest reflections of metals in one channel, the extreme one first.
pub(super) fn extremes(channel: usize, is_highest: bool) -> [Option<(f64, &'static Measured)>; 2] {
    let sign = if is_highest { -1.0 } else { 1.0 };
    let mut found: [Option<(f64, &'static Measured)>; 2] = [None; 2];
    for (_, row) in tables().metal_base.iter().filter(|(_, row)| row.group == "metal") {
        let Some(color) = row.color(Property::base_color) else { continue };
        let beats = |other: &Option<(f64, _)>| other.is_none_or(|(value, _)| color[channel] * sign < value * sign);
        if beats(&found[0]) {
            found = [Some((color[channel], row)), found[0]];
        } else if beats(&found[1]) {
            found[1] = Some((color[channel], row));
        }
    }
    found
}

/// Optical depth that leaves this share of the light, as the model computes it.
fn depth(share: f64) -> f64 {
    // Adding 0 makes the negative zero of white a plain one.
    -share.clamp(1e-3, 1.0).ln() + 0.0
}

fn squared(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|c| (a[c] - b[c]) * (a[c] - b[c])).sum()
}

fn finite(color: [f64; 3]) -> Option<[f64; 3]> {
    // Far beyond any colour, and small enough to be squared.
    color.iter().all(|c| c.is_finite()).then(|| color.map(|c| c.clamp(-1e9, 1e9)))
}

fn logarithms(scale: [f64; 3]) -> [f64; 3] {
    scale.map(|c| c.max(1e-3).ln())
}

/// OKLab of a colour at a brightness of its own: scaled to a maximum of 1.
fn chroma(color: [f64; 3]) -> [f64; 3] {
    let max = color.into_iter().fold(0.0, f64::max);
    oklab(color.map(|c| if max > 0.0 { c / max } else { 0.0 }))
}

/// OKLab of a linear Rec.709 colour: Björn Ottosson, A perceptual color space for image processing, 2020.
fn oklab([r, g, b]: [f64; 3]) -> [f64; 3] {
    let l = (0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b).cbrt();
    let m = (0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b).cbrt();
    let s = (0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b).cbrt();
    [
        0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s,
        1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s,
        0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_is_light_without_hue() {
        let [l, a, b] = oklab([1.0; 3]);
        assert!((l - 1.0).abs() < 1e-6 && a.abs() < 1e-6 && b.abs() < 1e-6, "{l} {a} {b}");
        // Published for linear red.
        let red = oklab([1.0, 0.0, 0.0]);
        assert!(squared(red, [0.627955, 0.224863, 0.125846]).sqrt() < 1e-5, "{red:?}");
    }
}

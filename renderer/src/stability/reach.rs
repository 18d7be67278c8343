//! The values that shading can meet on a material with images.

use crate::scene::Object;
use crate::texel;
use burnish_assets::Image;
use burnish_material::{Inputs, Material, Property, TextureRef, Value};

/// The values that shading can meet: every image at its least and at its largest texel.
pub(super) fn reachable(object: &Object, uniform: &Inputs<f64>) -> Vec<(String, Inputs<f64>)> {
    let material = &object.material;
    let ranges: Vec<(Property, [[f64; 3]; 2])> = material
        .slots()
        .filter_map(|(property, _)| {
            let (reference, image) = texture_of(object, property)?;
            Some((property, texel_range(property, reference, image)))
        })
        .collect();
    if ranges.is_empty() {
        return vec![(String::new(), *uniform)];
    }
    let mut choices: Vec<(String, Vec<usize>)> =
        vec![("least texels".into(), vec![0; ranges.len()]), ("largest texels".into(), vec![1; ranges.len()])];
    if ranges.len() > 1 {
        // One image against all others is what two maps that do not fit together give.
        for (k, (property, _)) in ranges.iter().enumerate() {
            let mut choice = vec![1; ranges.len()];
            choice[k] = 0;
            choices.push((format!("least {}", property.def().name), choice));
        }
    }
    let inputs_of = |choice: &[usize]| {
        let at = |property: Property| ranges.iter().position(|(p, _)| *p == property);
        Inputs::gather(|property| match (at(property).map(|k| ranges[k].1[choice[k]]), property.def().default) {
            // Texels are clamped by the lobes alone.
            (Some(v), Value::Color(_)) => Value::Color(v),
            (Some(v), Value::Normal(_)) => Value::Normal(v.map(|x| 2.0 * x - 1.0)),
            (Some(v), Value::Float(_)) => Value::Float(v[0]),
            _ => uniform_value(material, property),
        })
    };
    choices.iter().map(|(name, choice)| (name.clone(), inputs_of(choice))).collect()
}

/// A uniform value as [`Material::inputs`] gives it.
fn uniform_value(material: &Material, property: Property) -> Value {
    let def = property.def();
    let fix = |x: f64, default: f64| {
        if x.is_nan() { default } else { def.limits.enforce(x).clamp(f64::from(f32::MIN), f64::from(f32::MAX)) }
    };
    match (material.value(property), def.default) {
        (Value::Float(v), Value::Float(d)) => Value::Float(fix(v, d)),
        (Value::Color(v), Value::Color(d)) => Value::Color(std::array::from_fn(|k| fix(v[k], d[k]))),
        (value, _) => value,
    }
}

/// The texture of a property and its image, where both are there.
pub(super) fn texture_of(object: &Object, property: Property) -> Option<(&TextureRef, &Image)> {
    let reference = object.material.slot(property).texture.as_ref()?;
    let image = object.textures.get(&reference.path)?;
    Some((reference, &**image))
}

/// Least and largest texel of each channel, linear. Texels that are not finite count as the default, as in a picture.
fn texel_range(property: Property, reference: &TextureRef, image: &Image) -> [[f64; 3]; 2] {
    let default = property.def().default;
    let stand_in = match default {
        Value::Float(x) => [x; 3],
        Value::Color(c) | Value::Normal(c) => c,
        Value::Bool(_) => [0.0; 3],
    };
    let mut range = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for texel in &image.texels {
        let value = texel::stored(*texel, property, reference, image.is_eight_bit);
        for k in 0..3 {
            let x = if value[k].is_finite() { f64::from(value[k]) } else { stand_in[k] };
            range[0][k] = range[0][k].min(x);
            range[1][k] = range[1][k].max(x);
        }
    }
    range.map(|end| std::array::from_fn(|k| if end[k].is_finite() { end[k] } else { stand_in[k] }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_of_inverted_images_are_turned_over() {
        let image = Image { width: 2, height: 1, texels: vec![[0.25; 4], [0.875; 4]], is_eight_bit: false };
        let of = |property, is_inverted| texel_range(property, &TextureRef { is_inverted, ..TextureRef::new("a") }, &image);
        assert_eq!(of(Property::roughness, false), [[0.25; 3], [0.875; 3]]);
        assert_eq!(of(Property::roughness, true), [[0.125; 3], [0.75; 3]]);
        assert_eq!(of(Property::normal, true), [[0.25, 0.125, 0.25], [0.875, 0.75, 0.875]]);
    }

    #[test]
    fn ranges_of_scaled_images_are_scaled() {
        let image = Image { width: 2, height: 1, texels: vec![[0.25; 4], [0.875; 4]], is_eight_bit: false };
        let reference = TextureRef { scale: [-2.0, 0.0, 1.0], bias: [1.0, 0.5, 0.0], ..TextureRef::new("a") };
        let of = |property| texel_range(property, &reference, &image);
        assert_eq!(of(Property::base_color), [[-0.75, 0.5, 0.25], [0.5, 0.5, 0.875]]);
        assert_eq!(of(Property::height), [[-0.75; 3], [0.5; 3]]);
        assert_eq!(of(Property::normal), [[0.25; 3], [0.875; 3]]);
    }
}

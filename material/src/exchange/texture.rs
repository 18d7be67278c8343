//! Images through a translation: whether a parameter can use a property's image as it is, perhaps scaled, or needs one of its own.
//!
//! Nothing is written down about that: the formulas themselves are asked. Where a parameter follows one property in a straight line, the
//! image serves with a scale and a bias; where it bends, or follows several images, its own image has to be computed, texel by texel.

use super::field::Fields;
use super::model::Notes;
use crate::material::Material;
use crate::properties::{Inputs, Property};
use crate::slot::{Channel, TextureRef};
use crate::value::{Kind, Value};

/// An image that has to be computed for a parameter: at each texel the properties take their images' values, and the model is translated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Place of the parameter in the model's table.
    pub field: usize,
    /// Properties whose images decide.
    pub from: Vec<Property>,
}

/// What an image of a property means for a parameter.
pub(super) enum Link {
    /// Its value does not depend on it.
    Constant,
    /// The image serves, as this says.
    Direct(Box<TextureRef>),
    /// The parameter needs an image of its own.
    Computed,
}

/// A straight line between values of up to three components.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Line {
    inputs: usize,
    outputs: usize,
    /// `slope[out][in]`.
    slope: [[f64; 3]; 3],
    offset: [f64; 3],
}

/// Points where a line is looked for and checked, as shares of the range. Inside of it: ends are where formulas clamp.
const START: f64 = 0.3;
const STEP: f64 = 0.4;
const CHECKS: [[f64; 3]; 4] = [[0.15, 0.55, 0.85], [0.9, 0.2, 0.5], [0.05, 0.95, 0.35], [0.62, 0.62, 0.62]];
const TOLERANCE: f64 = 1e-7;

/// Least value and extent of what an image holds, within what properties take: its own range, or 0 to 1 where that is hardly any.
fn range(scale: f64, bias: f64) -> (f64, f64) {
    let (least, most) = (bias.min(bias + scale).max(0.0), bias.max(bias + scale).min(1.0));
    if most - least > 1e-3 { (least, most - least) } else { (0.0, 1.0) }
}

fn same_kind(kind: Kind, v: [f64; 3]) -> Value {
    match kind {
        Kind::Color => Value::Color(v),
        Kind::Normal => Value::Normal(v),
        Kind::Float | Kind::Bool => Value::Float(v[0]),
    }
}

impl Line {
    /// The line that `f` is for the values of an image; `None` if it bends there.
    fn of(kind: Kind, image: &TextureRef, f: impl Fn(Value) -> Option<Value>) -> Option<Self> {
        let inputs = if kind == Kind::Float { 1 } else { 3 };
        let range: [(f64, f64); 3] = std::array::from_fn(|k| range(image.scale[k], image.bias[k]));
        let inside = |v: [f64; 3]| std::array::from_fn(|k| range[k].0 + range[k].1 * v[k]);
        let at = |v: [f64; 3]| -> Option<([f64; 3], usize)> {
            let out = f(same_kind(kind, v))?;
            let mut numbers = [0.0; 3];
            let count = out.numbers().len();
            numbers[..count].copy_from_slice(out.numbers());
            (count > 0 && numbers.iter().all(|x| x.is_finite())).then_some((numbers, count))
        };
        let first: [f64; 3] = inside([START; 3]);
        let (start, outputs) = at(first)?;
        let mut line = Self { inputs, outputs, slope: [[0.0; 3]; 3], offset: start };
        for i in 0..inputs {
            let mut v = first;
            v[i] += STEP * range[i].1;
            let (moved, _) = at(v)?;
            for out in 0..outputs {
                line.slope[out][i] = (moved[out] - start[out]) / (STEP * range[i].1);
                line.offset[out] -= line.slope[out][i] * first[i];
            }
        }
        let is_on = |v: &[f64; 3]| {
            at(*v).is_some_and(|(found, _)| {
                (0..outputs).all(|out| (found[out] - line.at(out, v)).abs() <= TOLERANCE * (1.0 + found[out].abs()))
            })
        };
        CHECKS.iter().all(|v| is_on(&inside(*v))).then(|| line.tidied())
    }

    fn at(&self, out: usize, v: &[f64; 3]) -> f64 {
        self.offset[out] + (0..self.inputs).map(|i| self.slope[out][i] * v[i]).sum::<f64>()
    }

    /// Without the last digits of rounding, so that a factor of 1 is 1.
    fn tidied(mut self) -> Self {
        let tidy = |x: f64| (x * 1e9).round() / 1e9;
        self.slope = self.slope.map(|row| row.map(tidy));
        self.offset = self.offset.map(tidy);
        self
    }

    fn is_constant(&self) -> bool {
        self.slope.as_flattened().iter().all(|x| *x == 0.0)
    }

    /// The image through the line; `None` where channels would have to be mixed.
    fn through(&self, image: &TextureRef) -> Option<TextureRef> {
        let mut out = image.clone();
        let (mut factor, mut offset) = ([1.0; 3], [0.0; 3]);
        match (self.inputs, self.outputs) {
            (1, _) => {
                for k in 0..3 {
                    let row = if self.outputs == 1 { 0 } else { k };
                    (factor[k], offset[k]) = (self.slope[row][0], self.offset[row]);
                }
            }
            (_, 3) => {
                let is_diagonal = (0..3).all(|o| (0..3).all(|i| o == i || self.slope[o][i] == 0.0));
                if !is_diagonal {
                    return None;
                }
                for k in 0..3 {
                    (factor[k], offset[k]) = (self.slope[k][k], self.offset[k]);
                }
            }
            _ => {
                let row = self.slope[0];
                let used: Vec<usize> = (0..3).filter(|i| row[*i] != 0.0).collect();
                let is_mean = used.len() == 3 && row.iter().all(|x| (x - row[0]).abs() <= TOLERANCE);
                let is_even = image.scale.iter().all(|x| *x == image.scale[0]) && image.bias.iter().all(|x| *x == image.bias[0]);
                match (used.as_slice(), image.channel) {
                    ([only], Channel::Rgb) => {
                        out.channel = [Channel::R, Channel::G, Channel::B][*only];
                        (out.scale, out.bias) = ([image.scale[*only]; 3], [image.bias[*only]; 3]);
                        (factor, offset) = ([row[*only]; 3], [self.offset[0]; 3]);
                    }
                    (_, _) if is_mean && is_even => (factor, offset) = ([3.0 * row[0]; 3], [self.offset[0]; 3]),
                    _ => return None,
                }
            }
        }
        for k in 0..3 {
            (out.scale[k], out.bias[k]) = (out.scale[k] * factor[k], out.bias[k] * factor[k] + offset[k]);
        }
        Some(out)
    }
}

/// How a parameter, `value_of` the properties, follows the images of these properties.
pub(super) fn link(
    textured: &[Property],
    material: &Material,
    inputs: &Inputs<f64>,
    value_of: impl Fn(&Inputs<f64>) -> Option<Value>,
) -> Link {
    let with = |inputs: &Inputs<f64>, property: Property, value: Value| {
        let mut changed = *inputs;
        changed.set(property, value);
        value_of(&changed)
    };
    // What one image does may depend on the value of another: each is asked with the others at their uniform values and at two more.
    let others_at = |x: f64| {
        let mut moved = *inputs;
        for other in textured {
            let kind = other.def().default.kind();
            if kind != Kind::Normal {
                moved.set(*other, same_kind(kind, [x; 3]));
            }
        }
        moved
    };
    let settings = [*inputs, others_at(START), others_at(START + STEP)];
    let settings = if textured.len() > 1 { settings.as_slice() } else { &settings[..1] };
    let mut direct = None;
    for property in textured {
        let kind = property.def().default.kind();
        let Some(image) = &material.slot(*property).texture else { continue };
        if kind == Kind::Normal {
            let tilted = Value::Normal([0.6, 0.0, 0.8]);
            match with(inputs, *property, tilted) {
                Some(value) if value == tilted && direct.is_none() => direct = Some(image.clone()),
                Some(value) if Some(value) == with(inputs, *property, Value::Normal([0.0, 0.0, 1.0])) => {}
                _ => return Link::Computed,
            }
            continue;
        }
        let lines = settings.iter().map(|inputs| Line::of(kind, image, |value| with(inputs, *property, value)));
        let Some(lines) = lines.collect::<Option<Vec<Line>>>() else { return Link::Computed };
        if lines.iter().all(Line::is_constant) {
            continue;
        }
        match lines[0].through(image) {
            Some(image) if direct.is_none() && lines.iter().all(|line| *line == lines[0]) => direct = Some(image),
            _ => return Link::Computed,
        }
    }
    direct.map_or(Link::Constant, |image| Link::Direct(Box::new(image)))
}

/// The image of a property on the way back, from those of the parameters at `places`.
///
/// Where the formula bends, the first image is taken as it is, with a note.
pub(super) fn back(
    property: Property,
    places: &[usize],
    fields: &Fields,
    values: &[Value],
    notes: &mut Notes,
    value_of: impl Fn(&[Value]) -> Value,
) -> Option<TextureRef> {
    let kind = property.def().default.kind();
    let mut found: Option<TextureRef> = None;
    for place in places {
        let (field, value) = (fields.0.get(*place)?, *values.get(*place)?);
        let Some(image) = &field.texture else { continue };
        if kind == Kind::Normal || value.kind() == Kind::Normal {
            if kind == value.kind() {
                found = found.or_else(|| Some(image.clone()));
            }
            continue;
        }
        let line = Line::of(value.kind(), image, |new| {
            let mut changed = values.to_vec();
            *changed.get_mut(*place)? = new;
            Some(value_of(&changed))
        });
        let through = match &line {
            Some(line) if line.is_constant() => continue,
            Some(line) => line.through(image),
            None => None,
        };
        let name = property.def().name;
        match through {
            Some(through) if found.is_none() => found = Some(through),
            _ if found.is_some() => notes.push(format!("{name}: depends on several images; the first one is used alone")),
            _ => {
                notes.push(format!("{name}: the image `{}` is used as it is, although the models differ", image.path));
                found = Some(image.clone());
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn material(property: Property, path: &str) -> Material {
        let mut material = Material::default();
        material.slot_mut(property).texture = Some(TextureRef::new(path));
        material
    }

    fn linked(property: Property, f: impl Fn(&Inputs<f64>) -> Value) -> Link {
        let material = material(property, "a.png");
        link(&[property], &material, &material.inputs(), |i| Some(f(i)))
    }

    #[test]
    fn a_straight_line_scales_the_image_and_a_bent_one_needs_another() {
        let direct = |link| match link {
            Link::Direct(image) => (image.scale, image.bias, image.channel),
            _ => panic!("expected the image itself"),
        };
        let found = direct(linked(Property::roughness, |i| Value::Float(1.0 - 2.0 * i.roughness)));
        assert_eq!(found, ([-2.0; 3], [1.0; 3], Channel::Rgb));
        let found = direct(linked(Property::base_color, |i| Value::Color([i.base_color[0], 0.5 * i.base_color[1], 0.2])));
        assert_eq!(found, ([1.0, 0.5, 0.0], [0.0, 0.0, 0.2], Channel::Rgb));
        let found = direct(linked(Property::base_color, |i| Value::Float(i.base_color[1])));
        assert_eq!(found.2, Channel::G);
        assert!(matches!(linked(Property::roughness, |i| Value::Float(i.roughness.powi(2))), Link::Computed));
        let clamped = |i: &Inputs<f64>| Some(Value::Float((2.0 * i.roughness).min(1.0)));
        assert!(matches!(linked(Property::roughness, |i| clamped(i).unwrap_or(Value::Float(0.0))), Link::Computed));
        let mut dark = material(Property::roughness, "a.png");
        dark.slot_mut(Property::roughness).texture.as_mut().expect("just put there").scale = [0.5; 3];
        assert_eq!(direct(link(&[Property::roughness], &dark, &dark.inputs(), clamped)).0, [1.0; 3]);
        assert!(matches!(linked(Property::base_color, |i| Value::Color([i.base_color[1]; 3])), Link::Computed));
        assert!(matches!(linked(Property::roughness, |i| Value::Float(i.metallic)), Link::Constant));
    }

    #[test]
    fn images_that_multiply_need_one_of_their_own() {
        let mut material = material(Property::specular_level, "l.png");
        material.slot_mut(Property::metallic).texture = Some(TextureRef::new("m.png"));
        let textured = [Property::specular_level, Property::metallic];
        let linked = |f: fn(&Inputs<f64>) -> f64| link(&textured, &material, &material.inputs(), |i| Some(Value::Float(f(i))));
        // At the uniform values, 0.5 and 0, the metal seems to change nothing.
        assert!(matches!(linked(|i| 2.0 * i.specular_level * (1.0 - i.metallic) + i.metallic), Link::Computed));
        assert!(matches!(linked(|i| 2.0 * i.specular_level), Link::Direct(_)));
    }
}

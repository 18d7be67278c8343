//! Which of both holds on import: the native copy, or what another program made of the translation. Property by property.

use super::field::{Field, Fields};
use super::model::{Context, Notes, ShadingModel};
use super::native::Native;
use crate::material::Material;
use crate::value::Value;

/// How far two numbers may be apart and count as the same, relative to the larger of the number and 1: other programs store single
/// precision.
const TOLERANCE: f64 = 1e-5;

/// Largest angle between two turns that count as the same, in degrees: single precision is 3e-5 near 360.
const SAME_TURN: f64 = 1e-4;

/// The material of a file that holds a native copy, and fields that a program may have changed since.
///
/// A property whose parameters say what they said when the file was written has its native value, bit for bit. Where a parameter was
/// changed, the properties that mean something else by it have the values that the parameters mean now, and a note tells of it.
pub fn merge(model: &ShadingModel, native: &Native, file: &Fields, context: &Context, notes: &mut Notes) -> Material {
    let written = native.translation.clone().unwrap_or_else(|| model.translate(&native.material, context).fields);
    let pairs = model.fields.iter().zip(written.0.iter().zip(&file.0));
    // What no property follows is kept or dropped by the format.
    let changed: Vec<_> = pairs.filter(|(def, (old, new))| !def.to.is_empty() && !is_same(old, new)).collect();
    if changed.is_empty() {
        return native.material.clone();
    }
    let meaning_of = |fields: &Fields| model.interpret(fields, context, &mut Notes::new());
    let (before, after) = (meaning_of(&written), meaning_of(file));
    let mut material = native.material.clone();
    for (def, (old, new)) in changed {
        // A parameter may lead to a property in some materials only; where it means what it meant, the native value stays.
        let moved: Vec<_> = def.to.iter().copied().filter(|property| before.slot(*property) != after.slot(*property)).collect();
        for property in &moved {
            *material.slot_mut(*property) = after.slot(*property).clone();
        }
        let names: Vec<&str> = moved.iter().map(|property| property.def().name).collect();
        let (old, new) = (text(old), text(new));
        notes.push(match names.as_slice() {
            [] => format!("another program changed `{}` from {old} to {new}; nothing follows it here", def.name),
            _ => format!("{}: another program changed `{}` from {old} to {new}; its value holds", names.join(", "), def.name),
        });
    }
    material
}

/// Whether a parameter says what it said.
pub fn is_same(old: &Field, new: &Field) -> bool {
    let is_near = |a: &f64, b: &f64| (a - b).abs() <= TOLERANCE * a.abs().max(1.0);
    let same_value = match (old.value, new.value) {
        (Value::Bool(a), Value::Bool(b)) => a == b,
        (a, b) => a.kind() == b.kind() && a.numbers().iter().zip(b.numbers()).all(|(a, b)| is_near(a, b)),
    };
    let same_texture = match (&old.texture, &new.texture) {
        (None, None) => true,
        (Some(a), Some(b)) => {
            let numbers = |t: &crate::TextureRef| [t.scale.as_slice(), &t.bias, &t.uv_scale, &t.uv_offset].concat();
            let turn = (a.uv_rotation - b.uv_rotation).rem_euclid(360.0);
            let words = |t: &crate::TextureRef| (t.path.clone(), t.channel, t.is_inverted, t.wrap);
            words(a) == words(b)
                && turn.min(360.0 - turn) <= SAME_TURN
                && numbers(a).iter().zip(&numbers(b)).all(|(a, b)| is_near(a, b))
        }
        _ => false,
    };
    // A parameter with an image does not use its value.
    same_texture && (same_value || new.texture.is_some())
}

fn text(field: &Field) -> String {
    match (&field.texture, field.value) {
        (Some(texture), _) => format!("the image `{}`", texture.path),
        (None, Value::Bool(value)) => value.to_string(),
        (None, value) => value.numbers().iter().map(f64::to_string).collect::<Vec<_>>().join(", "),
    }
}

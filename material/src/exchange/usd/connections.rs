//! Where the value of a shader's input comes from: through inputs of materials and outputs of node graphs.

use super::error::MAX_NAME_BYTES;
use super::layer::{Attribute, Layer, PrimId};
use crate::exchange::short::short;

/// More steps than a network has.
const MAX_STEPS: usize = 8;

/// Where a value comes from.
#[derive(Clone, Copy, Debug)]
pub(super) enum Source<'t, 'a> {
    /// An attribute that holds it.
    Value(&'t Attribute<'a>),
    /// An output of a shader, by its name without `outputs:`.
    Output(PrimId, &'a str),
}

/// The source of an attribute; `None` where it says nothing. Errors, in words for a note, where a connection leads nowhere or in a circle.
pub(super) fn follow<'t, 'a>(layer: &'t Layer<'a>, prim: PrimId, name: &str) -> Result<Option<Source<'t, 'a>>, String> {
    let Some(mut attribute) = layer.attribute(prim, name) else { return Ok(None) };
    let (mut prim, mut seen) = (prim, Vec::new());
    while let Some(target) = attribute.targets.first().copied() {
        if seen.contains(&(prim, attribute.name)) || seen.len() > MAX_STEPS {
            return Err("expected a connection that ends, found one that leads in a circle".to_owned());
        }
        seen.push((prim, attribute.name));
        let nowhere = || format!("expected a connection to an output, found <{}>, which is not there", short(target));
        let (next, property) = layer.find(prim, target).ok_or_else(nowhere)?;
        match property.strip_prefix("outputs:") {
            Some(output) if layer.prim(next).type_name == "Shader" => return Ok(Some(Source::Output(next, output))),
            _ => attribute = layer.attribute(next, property).ok_or_else(nowhere)?,
        }
        prim = next;
    }
    if attribute.value.is_none() && !seen.is_empty() {
        return Err(format!(
            "expected a connection to a value, found `{}` of <{}>, which has none",
            short(attribute.name),
            short(&layer.path(prim))
        ));
    }
    Ok(attribute.value.is_some().then_some(Source::Value(attribute)))
}

/// The attribute that an input's value comes from, if it is no output of a shader. Connections that lead nowhere say nothing.
pub(super) fn constant<'t, 'a>(layer: &'t Layer<'a>, prim: PrimId, input: &str) -> Option<&'t Attribute<'a>> {
    match follow(layer, prim, &format!("inputs:{input}")) {
        Ok(Some(Source::Value(attribute))) => Some(attribute),
        _ => None,
    }
}

/// The numbers of an input that holds this many.
pub(super) fn numbers<const N: usize>(layer: &Layer, prim: PrimId, input: &str) -> Option<[f64; N]> {
    constant(layer, prim, input)?.value.as_ref()?.tuple(N)?.try_into().ok()
}

/// The text of an input.
pub(super) fn text<'t>(layer: &'t Layer, prim: PrimId, input: &str) -> Option<&'t str> {
    constant(layer, prim, input)?.value.as_ref()?.text()
}

/// What a shader is: its `info:id`. Empty where that is longer than any name.
pub(super) fn shader_id<'t>(layer: &'t Layer, shader: PrimId) -> &'t str {
    let id = layer.value(shader, "info:id").and_then(|value| value.text()).unwrap_or_default();
    if id.len() <= MAX_NAME_BYTES { id } else { "" }
}

//! Reading how a property reads its image.

use super::{Reader, number, numbers};
use crate::file::FileError;
use crate::file::tree::Node;
use crate::properties::Property;
use crate::slot::{Channel, ColorSpace, TextureRef, Wrap};

impl Reader<'_> {
    pub(super) fn texture(&mut self, property: Property, node: &Node) -> Result<Option<TextureRef>, FileError> {
        let prefix = format!("{}.texture", property.def().name);
        let Some(block) = self.map(node) else {
            let found = self.excerpt(&node.value);
            self.refuse_of(property, &node.value, &prefix, &format!("expected a map {{ \"path\": … }}, found {found}"));
            return Ok(None);
        };
        self.expect_unique(&block, &prefix)?;
        let mut texture = TextureRef::new("");
        let mut path = None;
        for node in &block.nodes {
            let text = self.text;
            let word = self.string(node);
            let result = match node.key.as_str() {
                _ if !node.is_name => Ok(false),
                "path" => word.map(|word| path = Some(word)).ok_or("a text in quotes".into()).map(|()| true),
                "channel" => choose(word, Channel::from_word, Channel::ALL, &mut texture.channel),
                "color_space" => choose(word, ColorSpace::from_word, ColorSpace::ALL, &mut texture.color_space),
                "invert" => ron::from_str(&text[node.value.clone()])
                    .map(|is_inverted| texture.is_inverted = is_inverted)
                    .map_err(|_| "true or false".into())
                    .map(|()| true),
                "scale" => channels(text, node, &mut texture.scale),
                "bias" => channels(text, node, &mut texture.bias),
                "wrap" => choose(word, Wrap::from_word, Wrap::ALL, &mut texture.wrap),
                "uv_scale" => pair(text, node, &mut texture.uv_scale),
                "uv_offset" => pair(text, node, &mut texture.uv_offset),
                "uv_rotation" => number(text, &node.value)
                    .map(|degrees| texture.uv_rotation = degrees)
                    .map_err(|_| "a finite number".into())
                    .map(|()| true),
                _ => Ok(false),
            };
            match result {
                Ok(true) => {}
                Ok(false) => self.unknown_key(&prefix, node, "unknown key"),
                Err(expected) => {
                    let key = format!("{prefix}.{}", node.key);
                    let found = self.excerpt(&node.value);
                    self.refuse_of(property, &node.value, &key, &format!("expected {expected}, found {found}"));
                }
            }
        }
        if path.is_none() && block.get("path").is_none() {
            self.refuse_of(property, &node.value, &prefix, "expected a \"path\", found none");
        }
        Ok(path.map(|path| TextureRef { path, ..texture }))
    }
}

fn pair(text: &str, node: &Node, target: &mut [f64; 2]) -> Result<bool, String> {
    *target = numbers(text, &node.value).ok_or("two finite numbers (u, v)")?;
    Ok(true)
}

/// One number for all channels, or one for each.
fn channels(text: &str, node: &Node, target: &mut [f64; 3]) -> Result<bool, String> {
    let one = number(text, &node.value).ok().map(|x| [x; 3]);
    *target = one.or_else(|| numbers(text, &node.value)).ok_or("a finite number or three (r, g, b)")?;
    Ok(true)
}

fn choose<T: Copy>(
    word: Option<String>,
    from_word: fn(&str) -> Option<T>,
    all: &[(T, &str)],
    target: &mut T,
) -> Result<bool, String> {
    let expected = || all.iter().map(|(_, word)| format!("{word:?}")).collect::<Vec<_>>().join(" or ");
    *target = word.as_deref().and_then(from_word).ok_or_else(expected)?;
    Ok(true)
}

//! Writing how a property reads its image.

use super::{Changes, Fate, Writer, number, string, tuple};
use crate::file::read::numbers;
use crate::file::tree::Node;
use crate::slot::TextureRef;

impl Writer<'_> {
    /// Edits a texture that stands in the file, setting by setting.
    pub(super) fn texture(&mut self, node: &Node, old: &TextureRef, new: &TextureRef) {
        let Some(block) = self.block(&node.value, b"{") else { return };
        let mut changes = Changes::default();
        let differing = fields(old).into_iter().zip(fields(new)).filter(|(old, new)| old != new);
        for ((key, _), (_, new_text)) in differing {
            let lists = numbers_of(old, key).zip(numbers_of(new, key));
            // A list of which every number was read; other texts give way as a whole.
            let items = block.get(key).filter(|node| match lists {
                Some((old, _)) if old.len() == 2 => numbers::<2>(self.text, &node.value).is_some(),
                Some(_) => numbers::<3>(self.text, &node.value).is_some(),
                None => false,
            });
            match (lists, items.and_then(|node| self.block(&node.value, b"(["))) {
                (Some((old, new)), Some(items)) => self.numbers(&items, old, new),
                _ => self.entry(&block, key, Fate::Write(new_text), &mut changes),
            }
        }
        self.edits.change_block(&block, &[], &changes.added);
    }
}

/// The numbers of a setting that is a list of them.
fn numbers_of<'t>(texture: &'t TextureRef, key: &str) -> Option<&'t [f64]> {
    Some(match key {
        "scale" => &texture.scale,
        "bias" => &texture.bias,
        "uv_scale" => &texture.uv_scale,
        "uv_offset" => &texture.uv_offset,
        _ => return None,
    })
}

/// All settings of a texture reference as they are written.
fn fields(t: &TextureRef) -> [(&'static str, String); 10] {
    [
        ("path", string(&t.path)),
        ("channel", string(t.channel.word())),
        ("color_space", string(t.color_space.word())),
        ("invert", t.is_inverted.to_string()),
        ("scale", channels(&t.scale)),
        ("bias", channels(&t.bias)),
        ("wrap", string(t.wrap.word())),
        ("uv_scale", tuple(&t.uv_scale)),
        ("uv_offset", tuple(&t.uv_offset)),
        ("uv_rotation", number(t.uv_rotation)),
    ]
}

/// One number where it is that of all channels.
fn channels(numbers: &[f64; 3]) -> String {
    let [r, g, b] = numbers.map(f64::to_bits);
    if r == g && r == b { number(numbers[0]) } else { tuple(numbers) }
}

/// A texture reference with its path and whatever is not at its default.
pub(crate) fn texture(texture: &TextureRef) -> String {
    let plain = fields(&TextureRef::new(""));
    let fields = fields(texture).into_iter().zip(plain).filter(|((key, text), (_, plain))| *key == "path" || text != plain);
    let fields: Vec<_> = fields.map(|((key, text), _)| format!("{}: {text}", string(key))).collect();
    format!("{{ {} }}", fields.join(", "))
}

pub(crate) fn same_texture(a: Option<&TextureRef>, b: Option<&TextureRef>) -> bool {
    match (a, b) {
        (None, None) => true,
        (Some(a), Some(b)) => fields(a) == fields(b),
        _ => false,
    }
}

//! Sides A and B: a stored state of the material beside the one being edited.

use crate::editor::Document;
use burnish_material::Material;
use burnish_renderer::scene::TextureSet;
use std::sync::Arc;

/// A state kept for comparison.
#[derive(Clone, Debug)]
pub struct Side {
    /// Its values.
    pub material: Arc<Material>,
    /// Its images.
    pub textures: Arc<TextureSet>,
    /// Where it comes from, for the picture's corner.
    pub label: String,
}

impl Side {
    /// The present state of a document.
    pub fn of(document: &Document, label: impl Into<String>) -> Self {
        Self { material: Arc::new(document.material.clone()), textures: document.textures.clone(), label: label.into() }
    }
}

/// The stored side of a document, and which of both is being edited.
#[derive(Clone, Debug, Default)]
pub struct Sides {
    stored: Option<Side>,
    /// Whether what is being edited is A, and what is stored B.
    is_flipped: bool,
}

impl Sides {
    /// Keeps a state as side A.
    pub fn store(&mut self, side: Side) {
        *self = Self { stored: Some(side), is_flipped: false };
    }

    /// The stored state.
    pub fn stored(&self) -> Option<&Side> {
        self.stored.as_ref()
    }

    /// Exchanges the document's state with the stored one. Whether there was one.
    pub fn flip(&mut self, document: &mut Document) -> bool {
        let Some(side) = &mut self.stored else { return false };
        let label = if self.is_flipped { "A" } else { "B" };
        let here = Side::of(document, label);
        let there = std::mem::replace(side, here);
        document.material = (*there.material).clone();
        document.textures = there.textures;
        self.is_flipped = !self.is_flipped;
        true
    }

    /// The letter of the state being edited, and of the stored one.
    pub fn letters(&self) -> (&'static str, &'static str) {
        if self.is_flipped { ("A", "B") } else { ("B", "A") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use burnish_material::{Property, Value};

    #[test]
    fn flipping_twice_changes_nothing() {
        let mut document = Document::new(Material::named("m"));
        let mut sides = Sides::default();
        assert!(!sides.flip(&mut document));
        sides.store(Side::of(&document, "A"));
        document.material.set(Property::roughness, Value::Float(0.9));
        let edited = document.material.clone();
        assert!(sides.flip(&mut document));
        assert_eq!(document.material, Material::named("m"));
        assert_eq!(sides.letters(), ("A", "B"));
        assert!(sides.flip(&mut document));
        assert_eq!(document.material, edited);
        assert_eq!(sides.letters(), ("B", "A"));
    }
}

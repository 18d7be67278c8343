//! A merge that is being decided: what two versions of a material disagree in, and the text that comes of the choices.

use crate::sources::Sourced;
use burnish_material::diff::{self, Change, can_take, take};
use burnish_material::merge::{Conflict, Side, merge_files};
use burnish_material::{Material, MaterialFile};
use burnish_renderer::scene::TextureSet;
use std::collections::BTreeMap;
use std::sync::Arc;

/// What is to be decided, and what is not.
pub struct Merging {
    mine: Arc<MaterialFile>,
    /// With what was taken without a question.
    merged: Material,
    theirs: Material,
    /// Whether a property and its texture are one entry.
    is_by_slot: bool,
    /// Images of both by the paths that the result names.
    pub textures: TextureSet,
    /// What both changed differently; without a base all that differs.
    pub conflicts: Vec<Conflict>,
    /// Keys of what comes from the second version without a question.
    pub taken: Vec<String>,
    /// What the second version has and the result lacks, because nothing can take it over.
    pub left_out: Vec<Change>,
}

impl Merging {
    /// Two versions and, if there is one, what both were made from. Images are named as from the folder of the first.
    pub fn new(base: Option<&Sourced>, mine: &Sourced, theirs: &Sourced) -> Self {
        let folder = mine.folder();
        let moved = |sourced: &Sourced| {
            let (material, textures) = sourced.seen_from(folder);
            let text = sourced.file.to_text(&material);
            // What a file's own writer has written can be read.
            let file = MaterialFile::parse(&text).map_or_else(|_| MaterialFile::new(&material), |(file, _)| file);
            (file, textures)
        };
        let (their_file, mut textures) = moved(theirs);
        textures.extend(mine.textures.iter().map(|(name, image)| (name.clone(), image.clone())));
        let their_material = their_file.material().clone();
        let (mut merged, mut taken) = ((*mine.material).clone(), Vec::new());
        let (conflicts, left_out) = match base {
            Some(base) => {
                let found = merge_files(&moved(base).0, &mine.file, &their_file, Side::A);
                let conflicts = found.merged.conflicts;
                (merged, taken) = (found.merged.material, found.merged.taken);
                taken.retain(|key| conflicts.iter().all(|conflict| conflict.key != *key));
                (conflicts, found.left_out)
            }
            None => {
                let all = diff::file_changes(&mine.file, &their_file);
                let is_open = |change: &Change| can_take(&merged, &their_material, &change.key);
                let (open, left): (Vec<Change>, Vec<Change>) = all.into_iter().partition(is_open);
                let conflict = |Change { key, property, a, b, .. }| Conflict { key, property, base: None, a, b };
                (open.into_iter().map(conflict).collect(), left)
            }
        };
        let is_by_slot = base.is_some();
        Self { mine: mine.file.clone(), merged, theirs: their_material, is_by_slot, textures, conflicts, taken, left_out }
    }

    /// How many conflicts are not decided yet.
    pub fn open(&self, choices: &BTreeMap<String, Side>) -> usize {
        self.conflicts.iter().filter(|conflict| !choices.contains_key(&conflict.key)).count()
    }

    /// The material that comes of the choices; the first version's entry where nothing is chosen.
    pub fn material(&self, choices: &BTreeMap<String, Side>) -> Material {
        let mut material = self.merged.clone();
        for conflict in self.conflicts.iter().filter(|conflict| choices.get(&conflict.key) == Some(&Side::B)) {
            take(&mut material, &self.theirs, &conflict.key);
            if let Some(property) = conflict.property.filter(|property| self.is_by_slot && property.def().name == conflict.key) {
                take(&mut material, &self.theirs, &format!("{}.texture", property.def().name));
            }
        }
        material
    }

    /// The first version's text with only what differs replaced.
    pub fn text(&self, choices: &BTreeMap<String, Side>) -> String {
        self.mine.to_text(&self.material(choices))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    fn sourced(path: &str, text: &str) -> Sourced {
        let file = Arc::new(MaterialFile::parse(text).unwrap().0);
        let material = Arc::new(file.material().clone());
        Sourced { title: path.into(), file, material, textures: Arc::default(), path: Some(PathBuf::from(path)) }
    }

    fn merging(base: Option<&str>) -> Merging {
        let mine = sourced("/a/m.ron", r#"{ "asm": "4.0", "properties": { "roughness": 0.40, "coat": 1.0 } } // mine"#);
        let text =
            r#"{ "asm": "4.0", "silk": 1, "properties": { "roughness": 0.6, "metallic": { "texture": { "path": "m.png" } } } }"#;
        let theirs = sourced("/b/m.ron", text);
        Merging::new(base.map(|text| sourced("/a/base.ron", text)).as_ref(), &mine, &theirs)
    }

    #[test]
    fn choices_decide_conflicts_alone() {
        let merging = merging(Some(r#"{ "asm": "4.0", "properties": { "roughness": 0.3 } }"#));
        let keys: Vec<&str> = merging.conflicts.iter().map(|conflict| conflict.key.as_str()).collect();
        assert_eq!((keys, merging.taken.clone(), merging.left_out.len()), (vec!["roughness"], vec!["metallic".to_owned()], 1));
        let mut choices = BTreeMap::new();
        assert_eq!(merging.open(&choices), 1);
        choices.insert("roughness".to_owned(), Side::A);
        let text = merging.text(&choices);
        assert!(merging.open(&choices) == 0 && text.contains("0.40") && text.ends_with("// mine"), "{text}");
        // From the other folder, so by its whole path.
        assert!(text.contains("\"/b/m.png\"") && text.contains("\"coat\": 1.0"), "{text}");
        choices.insert("roughness".to_owned(), Side::B);
        assert!(merging.text(&choices).contains("\"roughness\": 0.6"));
    }

    #[test]
    fn without_a_base_all_that_differs_is_a_question() {
        let merging = merging(None);
        let keys: Vec<&str> = merging.conflicts.iter().map(|conflict| conflict.key.as_str()).collect();
        assert_eq!((keys, merging.taken.len()), (vec!["roughness", "metallic.texture", "coat"], 0));
        let theirs = ["roughness", "metallic.texture", "coat"].map(|key| (key.to_owned(), Side::B)).into();
        let text = merging.text(&theirs);
        assert!(text.contains("0.6") && text.contains("/b/m.png") && !text.contains("coat"), "{text}");
        assert_eq!(merging.left_out[0].key, "silk");
    }
}

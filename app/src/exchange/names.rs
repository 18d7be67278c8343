//! Names of images beside a document.

use burnish_assets::BuiltInTexture;
use std::collections::{BTreeMap, BTreeSet};

/// Names beside a document for images: the last part of their paths, no two the same.
pub(crate) struct FileNames(BTreeMap<String, String>);

impl FileNames {
    /// Names for the images of these paths.
    pub fn of<'a>(paths: impl Iterator<Item = &'a str>) -> Self {
        let mut names = BTreeMap::new();
        // In lower case: not every system tells cases apart.
        let mut taken = BTreeSet::new();
        for path in paths {
            if names.contains_key(path) || path.is_empty() {
                continue;
            }
            let is_made = BuiltInTexture::parse(path).is_some();
            let last = path.rsplit(['/', '\\']).next().unwrap_or(path);
            let clean = |c: char| if c.is_ascii_alphanumeric() || "._-".contains(c) { c } else { '_' };
            let clean: String = (if is_made { path } else { last }).chars().map(clean).collect();
            let (stem, ending) = match clean.rsplit_once('.') {
                Some((stem, ending)) if !is_made => (stem.to_owned(), ending.to_owned()),
                _ => (clean, "png".to_owned()),
            };
            let free = (1..).map(|n| if n == 1 { format!("{stem}.{ending}") } else { format!("{stem}-{n}.{ending}") });
            let name = free.into_iter().find(|name| !taken.contains(&name.to_lowercase())).unwrap_or_default();
            taken.insert(name.to_lowercase());
            names.insert(path.to_owned(), name);
        }
        Self(names)
    }

    /// The name of an image; empty if it has none.
    pub fn file(&self, path: &str) -> String {
        self.0.get(path).cloned().unwrap_or_default()
    }
}

//! How the panels were arranged, as `layout.ron` in the state folder. What the text means is the window's affair.

use crate::files::FilesError;
use crate::own_files;
use serde::de::IgnoredAny;
use std::path::Path;

const FILE: &str = "layout.ron";

/// The text that was saved last, as RON; `None` if there is none or it is no RON, which is set aside with a sentence.
pub fn load_layout(folder: &Path) -> (Option<String>, Vec<String>) {
    let (layout, message) = own_files::load(&folder.join(FILE), own_files::MAX_BYTES, |text| {
        ron::from_str::<IgnoredAny>(text).map_err(|error| format!("expected a layout of the window: {error}"))?;
        Ok(text.to_owned())
    });
    (layout, message.into_iter().collect())
}

/// Sets a layout aside that is RON but cannot be used, and says so. `why` is what was expected and found.
pub fn set_layout_aside(folder: &Path, why: &str) -> String {
    let path = folder.join(FILE);
    format!("{}: {why}; {}", path.display(), own_files::set_aside(&path))
}

/// Saves a layout, RON in whatever form the window likes.
pub fn save_layout(folder: &Path, layout: &str) -> Result<(), FilesError> {
    own_files::save(&folder.join(FILE), layout)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_layout_comes_back_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("state");
        assert_eq!(load_layout(&folder), (None, vec![]));
        let layout = "(tiles: {1: Tabs([2, 3])}, // by hand\n)";
        save_layout(&folder, layout).unwrap();
        assert_eq!(load_layout(&folder), (Some(layout.to_owned()), vec![]));
        let message = set_layout_aside(&folder, "expected a tab called 4");
        assert!(message.contains("tab called 4; it was renamed to layout.broken-1.ron"), "{message}");
        assert_eq!(load_layout(&folder), (None, vec![]));
    }

    #[test]
    fn a_broken_layout_is_set_aside() {
        let folder = tempfile::tempdir().unwrap();
        let deep = "[".repeat(100_000);
        for (index, text) in ["(tiles: ", "", &deep].into_iter().enumerate() {
            save_layout(folder.path(), text).unwrap();
            let (layout, messages) = load_layout(folder.path());
            assert_eq!((layout, messages.len()), (None, 1));
            assert!(messages[0].contains(&format!("layout.broken-{}.ron", index + 1)), "{messages:?}");
        }
    }
}

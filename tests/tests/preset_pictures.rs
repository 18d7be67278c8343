//! Whether the small pictures of the presets show them as they are.

use burnish::library::entry::Entry;
use burnish::library::walk::walk;
use burnish_presets::{pictures, presets};
use std::path::Path;

#[test]
fn every_preset_has_a_picture_of_its_present_look() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../presets/data");
    let files = walk(&data, &|| false).expect("the presets are there").files;
    assert_eq!(files.len(), presets().len());
    let made: Vec<(&str, &str)> = pictures::cells().collect();
    let mut old = Vec::new();
    for found in &files {
        let entry = Entry::read(&data, found);
        let stem = entry.path.file_name().unwrap_or_default().to_string_lossy().replace(".asm.ron", "");
        if !made.contains(&(&*stem, &*entry.look.to_string())) {
            old.push(stem);
        }
    }
    assert!(old.is_empty(), "run the example preset_pictures; not of the present look: {old:?}");
    let sheet = image::load_from_memory(pictures::SHEET).expect("the sheet is a picture");
    let rows = made.len().div_ceil(pictures::ACROSS);
    assert_eq!([sheet.width() as usize, sheet.height() as usize], [pictures::SIDE * pictures::ACROSS, pictures::SIDE * rows]);
}

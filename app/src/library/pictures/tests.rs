use super::*;
use crate::library::index::Index;
use crate::library::scan::Scan;
use crate::library::setup::{Frame, Stage};
use std::time::Duration;

#[test]
fn drafts_come_first_and_are_not_kept() {
    let folder = tempfile::tempdir().unwrap();
    let (root, kept) = (folder.path().join("library"), folder.path().join("pictures"));
    std::fs::create_dir(&root).unwrap();
    for preset in &burnish_presets::presets()[..2] {
        std::fs::write(root.join(format!("{}.asm.ron", preset.file_stem)), preset.text).unwrap();
    }
    let scan =
        Scan { root: &root, old: &Index::default(), threads: 1, has_picture: &|_| false, is_cancelled: &|| false, tell: &|_| {} };
    let entries = scan.run().unwrap().index.entries;
    let frame = Frame { width: 16, height: 16, relmse: 0.5, ..Frame::default() };
    let setup = Arc::new(Setup::new(Stage::standard().unwrap(), frame, Vec::new()));
    let mut pictures = Pictures::new(&root, Some(&kept), Arc::new(|| {}));
    let shelf = Shelf::empty(&kept);
    pictures.want(&entries.iter().collect::<Vec<_>>(), &shelf, &setup, true);
    for (is_draft, entry) in [(true, 0), (true, 1), (false, 0), (false, 1)] {
        let Ok(Done::Made(new)) = pictures.results.recv_timeout(Duration::from_secs(60)) else { panic!("it does not come") };
        let side = if is_draft { 8 } else { 16 };
        assert_eq!((new.is_draft, new.path, new.thumbnail.width), (is_draft, entries[entry].path.clone(), side));
        assert_eq!(new.key.1 == setup.digest(), !is_draft);
        assert_eq!(shelf.path(new.key.0, new.key.1).exists(), !is_draft);
    }
}

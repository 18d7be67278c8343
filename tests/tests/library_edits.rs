//! Edits of many material files at once: does everything else keep its bytes, and does nothing get lost?

use burnish::library::edit::{self, Change};
use burnish_material::{MaterialFile, Property, Value};
use burnish_tests::library::material;
use std::fs;
use std::path::PathBuf;

#[test]
fn a_batch_of_edits_taken_back_gives_the_starting_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let odd = "// Kept.\r\n{ \"asm\": \"4.0\", \"velvet\": [1, 2], \"tags\": [\"Old\"],\r\n  \"properties\": { \"roughness\": 3e-1, }, }\r\n";
    let files: Vec<PathBuf> = (0..42).map(|n| folder.path().join(format!("{n:02}.asm.ron"))).collect();
    for (n, file) in files.iter().enumerate() {
        let text = MaterialFile::new(&material(n)).text().to_owned();
        fs::write(file, if n % 2 == 0 { odd } else { &text }).unwrap();
    }
    fs::write(&files[41], "{ broken").unwrap();
    let bytes = || -> Vec<Vec<u8>> { files.iter().map(|file| fs::read(file).unwrap_or_default()).collect() };
    let before = bytes();

    let changes = [
        Change::AddTag("Reviewed".to_owned()),
        Change::RemoveTag("old".to_owned()),
        Change::SetLicence("CC-BY-4.0".to_owned()),
        Change::SetValue(Property::roughness, Value::Float(0.25)),
    ];
    let planned = edit::change(&files, &changes);
    assert_eq!(planned.edit.files.len(), 41);
    assert!(planned.refused.len() == 1 && planned.refused[0].contains("41.asm.ron: line 1"), "{:?}", planned.refused);
    assert!(bytes() == before, "planning writes nothing");

    // Somebody else is faster with one of them.
    fs::write(&files[1], "{}").unwrap();
    let (done, refused) = planned.edit.carry_out();
    assert_eq!(done.files.len(), 40);
    assert!(refused.len() == 1 && refused[0].contains("01.asm.ron") && refused[0].contains("another program"), "{refused:?}");
    let text = fs::read_to_string(&files[0]).unwrap();
    for words in ["// Kept.\r\n", "\"velvet\": [1, 2]", "Reviewed", "CC-BY-4.0", "0.25"] {
        assert!(text.contains(words), "{words}: {text}");
    }
    assert!(!text.contains("Old"));
    let after = bytes();
    let (undone, refused) = done.reversed().carry_out();
    assert!(refused.is_empty() && undone.files.len() == 40, "{refused:?}");
    for (n, (now, before)) in bytes().iter().zip(&before).enumerate() {
        assert!(n == 1 || now == before, "{n} differs after undo");
    }
    assert!(undone.reversed().carry_out().1.is_empty() && bytes() == after, "redo differs");
    // The same again changes nothing, so there is nothing to do.
    assert!(edit::change(&files[2..41], &changes).edit.files.is_empty());
}

#[test]
fn files_are_renamed_copied_and_made_without_losing_any() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(format!("{name}.asm.ron"));
    let names = || {
        let mut names: Vec<String> =
            fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    };
    fs::write(at("copper"), "// Mine.\n{\"name\": \"Copper\"}").unwrap();
    fs::write(at("gold"), "{}").unwrap();

    let copies = edit::duplicate(&[at("copper"), at("copper"), at("none")]);
    assert!(copies.refused.len() == 1 && copies.refused[0].contains("none.asm.ron"), "{:?}", copies.refused);
    let (copied, refused) = copies.edit.carry_out();
    assert!(refused.is_empty());
    assert_eq!(names(), ["copper copy 2.asm.ron", "copper copy.asm.ron", "copper.asm.ron", "gold.asm.ron"]);
    assert_eq!(fs::read_to_string(at("copper copy 2")).unwrap(), "// Mine.\n{\"name\": \"Copper copy 2\"}");
    // A copy that was changed since is not deleted.
    fs::write(at("copper copy"), "{}").unwrap();
    assert_eq!(copied.reversed().carry_out().1.len(), 1);
    assert_eq!(names(), ["copper copy.asm.ron", "copper.asm.ron", "gold.asm.ron"]);

    let renamed = edit::rename(&at("copper"), "Cu");
    let (done, refused) = renamed.edit.carry_out();
    assert!(refused.is_empty() && renamed.refused.is_empty());
    assert_eq!(fs::read_to_string(at("Cu")).unwrap(), "// Mine.\n{\"name\": \"Cu\"}");
    assert!(!at("copper").exists());
    assert!(done.reversed().carry_out().1.is_empty() && at("copper").exists() && !at("Cu").exists());
    for bad in ["gold", "", "a/b", "..", "nul\0", &"x".repeat(300)] {
        let planned = edit::rename(&at("copper"), bad);
        assert!(planned.refused.len() == 1 && planned.edit.files.is_empty(), "{bad}");
    }
    let taken = edit::rename(&at("copper"), "silver");
    fs::write(at("silver"), "{}").unwrap();
    assert!(taken.edit.carry_out().1[0].contains("another file has this name"));
    assert!(at("copper").exists() && fs::read_to_string(at("silver")).unwrap() == "{}");

    let mut new = material(0);
    new.name = "gold".to_owned();
    let planned = edit::create(folder.path(), &new.name, MaterialFile::new(&new).text().to_owned());
    assert!(planned.edit.carry_out().1.is_empty());
    assert!(MaterialFile::parse(&fs::read_to_string(at("gold 2")).unwrap()).unwrap().0.material() == &new);
}

//! Checks before materials are handed out: does each fault give its row and nothing else, and do versions of a material come together?

use burnish::digest::Digest;
use burnish::library::check::against::{LookChange, compare};
use burnish::library::check::{Checked, Kind, Options, Row, Shelved, check_files, check_library};
use burnish::library::index::Index;
use burnish::library::scan::Scan;
use burnish::library::shelf::Shelf;
use burnish_material::diff::{changes, file_changes, take};
use burnish_material::merge::{Side, merge, merge_files};
use burnish_material::{Material, MaterialFile, PROPERTIES, Property, Severity, TextureRef, Value};
use proptest::prelude::*;
use proptest::sample::{select, subsequence};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

/// A row: kind, severity, key, and a part of the message.
type Expected = (Kind, Severity, &'static str, &'static str);

/// A file without a fault but for what the properties bring.
fn text(name: &str, properties: &str) -> String {
    format!(
        "{{\n\"asm\": \"4.0\", \"name\": {name:?},\n\"provenance\": {{\"source\": \"Tests\", \"licence\": \"CC0-1.0\"}},\n\
         \"properties\": {{{properties}}}\n}}\n"
    )
}

fn index(root: &Path) -> Index {
    let scan = Scan { root, old: &Index::default(), threads: 2, has_picture: &|_| true, is_cancelled: &|| false, tell: &|_| {} };
    scan.run().expect("the folder is there").index
}

fn shelved<'a>(root: &'a Path, index: &'a Index, shelf: &'a Shelf) -> Shelved<'a> {
    Shelved { root, entries: &index.entries, shelf, setup: Digest::default() }
}

fn check_of(root: &Path, options: &Options) -> Checked {
    let (index, shelf) = (index(root), Shelf::default());
    check_library(&shelved(root, &index, &shelf), options, &|_| {}, &|| false).expect("nobody cancels")
}

#[test]
fn each_fault_gives_its_row_and_nothing_else() {
    use Kind as K;
    use Severity::{Error, Note, Warning};
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    fs::write(root.join("broken.png"), b"\x89PNG\r\n\x1a\n and no more").unwrap();
    let cases: Vec<(&str, String, &[Expected])> = vec![
        ("good", text("Good", r#""roughness": 0.21"#), &[]),
        ("idle", text("Idle", r#""coat_roughness": 0.5"#), &[(K::Effect, Note, "coat_roughness", "no effect")]),
        (
            "image-broken",
            text("A", r#""roughness": {"texture": {"path": "broken.png"}}"#),
            &[(K::Texture, Error, "roughness", "broken.png")],
        ),
        ("image-made", text("B", r#""roughness": {"texture": {"path": "builtin:wood-oak/roughness"}}"#), &[]),
        (
            "image-missing",
            text("C", r#""metallic": {"texture": {"path": "maps/none.png"}}"#),
            &[(K::Texture, Error, "metallic", "found no file")],
        ),
        (
            "metal-green",
            text("D", r#""metallic": 1.0, "base_color": (0.1, 0.9, 0.1)"#),
            &[(K::Unlikely, Warning, "base_color", "nearest: ")],
        ),
        (
            "metal-violet",
            text("E", r#""metallic": 1.0, "base_color": (0.5, 0.3, 0.9)"#),
            &[(K::Unlikely, Note, "base_color", "nearest: ")],
        ),
        (
            "range",
            text("F", r#""base_color": (1.4, 0.3, 0.3)"#),
            &[(K::Range, Error, "base_color", "1.4 is outside the range 0 to 1")],
        ),
        ("refused", text("G", "\n\"roughness\": NaN"), &[(K::Parse, Error, "roughness", "finite")]),
        (
            "scatter-zero",
            text("H", r#""translucency": 1.0, "scatter": true, "scatter_distance": 0.0"#),
            &[(K::Combination, Error, "scatter_distance", "0 while scatter is on")],
        ),
        (
            "scale",
            text("I", r#""translucency": 1.0, "scatter": true, "scatter_distance": 5.0"#),
            &[(K::Scale, Warning, "scatter_distance", "lacks unit_mm: 1.0")],
        ),
        (
            "source-none",
            r#"{"asm": "4.0", "provenance": {"licence": "MIT"}, "properties": {"roughness": 0.22}}"#.to_owned(),
            &[(K::Provenance, Warning, "provenance.source", "not said")],
        ),
        (
            "source-unlicensed",
            r#"{"asm": "4.0", "provenance": {"source": "Me"}, "properties": {"roughness": 0.23}}"#.to_owned(),
            &[(K::Provenance, Warning, "provenance.licence", "licence")],
        ),
        ("truncated", "{\n\"asm\": \"4.0\",\n\"properties\": {\"rough".to_owned(), &[(K::Parse, Error, "", "not valid RON")]),
        ("twin", text("Twin", r#""roughness": 0.210"#), &[(K::Value, Warning, "", "good.asm.ron (Good)")]),
        (
            "typical",
            text("J", r#""specular_ior": 3.5"#),
            &[
                (K::Typical, Note, "specular_ior", "typical range 1 to 3"),
                (K::Unlikely, Note, "specular_ior", "Above every measured one; highest: "),
            ],
        ),
        (
            "unknown",
            text("K", r#""velvet": 1.0, "roughness": 0.24"#),
            &[(K::Parse, Warning, "properties.velvet", "unknown property")],
        ),
    ];
    for (name, text, _) in &cases {
        fs::write(root.join(format!("{name}.asm.ron")), text).unwrap();
    }
    // Neither is read: the first has 2 GB of nothing.
    File::create(root.join("sparse.asm.ron")).unwrap().set_len(2 << 30).unwrap();
    fs::write(root.join("binary.asm.ron"), [0xff, 0xfe, 0]).unwrap();
    let others: &[(&str, &[Expected])] = &[
        ("sparse", &[(K::Parse, Error, "", "expected a file of at most")]),
        ("binary", &[(K::Parse, Error, "", "expected text in UTF-8")]),
    ];

    let checked = check_of(root, &Options { threads: 2, ..Options::default() });
    let all = cases.iter().map(|(name, _, rows)| (*name, *rows)).chain(others.iter().copied());
    for (name, expected) in all {
        let path = root.join(format!("{name}.asm.ron"));
        let rows: Vec<_> = checked.rows.iter().filter(|row| row.path == path && row.kind != K::Thumbnail).collect();
        assert_eq!(rows.len(), expected.len(), "{name}: {rows:#?}");
        for (row, (kind, severity, key, words)) in rows.iter().zip(expected) {
            assert_eq!((row.kind, row.severity, row.key.as_str()), (*kind, *severity, *key), "{name}: {}", row.message);
            assert!(row.message.contains(words) && !row.message.starts_with('/'), "{name}: {}", row.message);
        }
    }
    let line = |name: &str| checked.rows.iter().find(|row| row.path == root.join(name)).and_then(|row| row.line);
    assert_eq!((line("refused.asm.ron"), line("truncated.asm.ron")), (Some(5), Some(3)));
    let pictures = checked.rows.iter().filter(|row| row.kind == K::Thumbnail && row.severity == Note).count();
    // What cannot be read can have no picture.
    assert_eq!(pictures, cases.len() - 2);
    let pairs: Vec<_> = checked.pairs.iter().map(|pair| (pair.a.clone(), pair.b.clone(), pair.kind)).collect();
    assert_eq!(pairs, [(root.join("good.asm.ron"), root.join("twin.asm.ron"), K::Value)]);
    assert_eq!((checked.files, checked.errors, checked.warnings), (cases.len() + 2, 8, 6));

    // The order is that of the paths, whatever thread is first; what renderers cope with is no error in files that are no library.
    let paths: Vec<PathBuf> = index(root).entries.iter().map(|entry| root.join(&entry.path)).collect();
    let of =
        |threads| check_files(&paths, &Options { threads, ..Options::default() }, &|_| {}, &|| false).expect("nobody cancels");
    let one = of(1);
    assert!(one.rows == of(3).rows && one.rows.is_sorted_by_key(|row| &row.path));
    assert_eq!((one.errors, one.warnings), (4, 8));
    assert!(one.rows.iter().all(|row| row.kind != K::Thumbnail));
}

#[test]
fn images_count_by_their_pixels() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    for (name, pixels) in [("a", 1_u8), ("b", 1), ("c", 2)] {
        let image = image::RgbImage::from_pixel(4, 4, image::Rgb([pixels; 3]));
        image.save(root.join(format!("{name}.png"))).unwrap();
        let painted = format!("\"roughness\": {{\"texture\": {{\"path\": \"{name}.png\"}}}}");
        fs::write(root.join(format!("{name}.asm.ron")), text(name, &painted)).unwrap();
    }
    let checked = check_of(root, &Options::default());
    let seconds: Vec<_> = checked.pairs.iter().map(|pair| (pair.b.clone(), pair.kind)).collect();
    assert_eq!(seconds, [(root.join("b.asm.ron"), Kind::Value)]);
}

#[test]
fn what_looks_the_same_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    for (name, properties) in [
        ("a", r#""base_color": (0.5, 0.2, 0.1), "roughness": 0.4"#),
        ("b", r#""base_color": (0.5, 0.2001, 0.1), "roughness": 0.4"#),
        ("c", r#""base_color": (0.5, 0.2, 0.1), "roughness": 0.45"#),
        ("d", r#""base_color": (0.5, 0.3, 0.1), "roughness": 0.4"#),
    ] {
        fs::write(root.join(format!("{name}.asm.ron")), text(name, properties)).unwrap();
    }
    let checked = check_of(root, &Options { threads: 2, renders_looks: true, probes_stability: false });
    let pairs: Vec<_> = checked.pairs.iter().map(|pair| (pair.b.clone(), pair.kind)).collect();
    assert_eq!(pairs, [(root.join("b.asm.ron"), Kind::Look)], "{:?}", checked.pairs);
    // The verdict of each is told on request.
    let probed = check_of(root, &Options { threads: 2, renders_looks: false, probes_stability: true });
    let verdicts: Vec<_> = probed.rows.iter().filter(|row| row.kind == Kind::Stability).collect();
    assert_eq!(verdicts.len(), 4);
    let holds = |row: &&Row| row.severity == Severity::Note && row.message.starts_with("holds; the worst: ");
    assert!(verdicts.iter().all(holds) && probed.errors == 0, "{verdicts:#?}");
    let row = checked.rows.iter().find(|row| row.kind == Kind::Look).expect("it has a row");
    assert!(row.path == root.join("b.asm.ron") && row.message.contains("a.asm.ron (a): 0.0"), "{}", row.message);
}

#[test]
fn checking_can_be_cancelled() {
    let folder = tempfile::tempdir().unwrap();
    let paths: Vec<PathBuf> = (0..50).map(|n| folder.path().join(format!("{n}.asm.ron"))).collect();
    paths.iter().for_each(|path| fs::write(path, text("Any", "")).unwrap());
    let asked = AtomicUsize::new(0);
    let after = |limit: usize| {
        asked.store(0, Ordering::Relaxed);
        check_files(&paths, &Options::default(), &|_| {}, &|| asked.fetch_add(1, Ordering::Relaxed) >= limit)
    };
    for limit in [0, 1, 25, 50] {
        assert!(after(limit).is_none(), "{limit}");
    }
    assert_eq!(after(usize::MAX).map(|checked| (checked.files, checked.pairs.len())), Some((50, 49)));
}

#[test]
fn the_built_in_materials_pass() {
    let folder = tempfile::tempdir().unwrap();
    for preset in burnish_presets::presets() {
        let group = folder.path().join(preset.group);
        fs::create_dir_all(&group).unwrap();
        fs::write(group.join(format!("{}.asm.ron", preset.file_stem)), preset.text).unwrap();
    }
    let checked = check_of(folder.path(), &Options { threads: 2, ..Options::default() });
    assert_eq!(checked.files, burnish_presets::presets().len());
    let serious: Vec<_> = checked.rows.iter().filter(|row| row.severity >= Severity::Warning).collect();
    assert!(serious.is_empty() && checked.pairs.is_empty(), "{serious:#?} {:#?}", checked.pairs);
    // Measurements become files without a word, too.
    for row in burnish_presets::measured::measured() {
        let (file, _) = MaterialFile::parse(&row.file_text()).expect("it is written here");
        let findings = burnish_material::check(file.material());
        assert!(findings.iter().all(|finding| finding.severity < Severity::Error), "{}: {findings:?}", row.id);
    }
}

#[test]
fn a_library_is_compared_with_an_earlier_release() {
    let folder = tempfile::tempdir().unwrap();
    let (old, new) = (folder.path().join("old"), folder.path().join("new"));
    for root in [&old, &new] {
        fs::create_dir(root).unwrap();
        fs::write(root.join("same.asm.ron"), text("Same", r#""roughness": 0.1"#)).unwrap();
        fs::write(root.join("tagged.asm.ron"), text("Tagged", r#""roughness": 0.2"#)).unwrap();
        fs::write(root.join("edited.asm.ron"), text("Edited", r#""roughness": 0.3"#)).unwrap();
        fs::write(root.join("nudged.asm.ron"), text("Nudged", r#""base_color": (0.5, 0.5, 0.5)"#)).unwrap();
    }
    fs::write(old.join("gone.asm.ron"), text("Gone", "")).unwrap();
    fs::write(new.join("come.asm.ron"), text("Come", "")).unwrap();
    fs::write(new.join("tagged.asm.ron"), text("Renamed", r#""roughness": 0.2"#)).unwrap();
    fs::write(new.join("edited.asm.ron"), text("Edited", r#""roughness": 0.9, "metallic": 1.0"#)).unwrap();
    fs::write(new.join("nudged.asm.ron"), text("Nudged", r#""base_color": (0.5, 0.5, 0.5001)"#)).unwrap();
    let (old_index, new_index, shelf) = (index(&old), index(&new), Shelf::default());
    let with = |renders_looks| {
        let options = Options { threads: 2, renders_looks, ..Options::default() };
        let (before, now) = (shelved(&old, &old_index, &shelf), shelved(&new, &new_index, &shelf));
        compare(&before, &now, &options, &|_| {}, &|| false).expect("nobody cancels")
    };
    let against = with(false);
    assert_eq!(against.added, [PathBuf::from("come.asm.ron")]);
    assert_eq!(against.removed, [PathBuf::from("gone.asm.ron")]);
    assert_eq!(against.unchanged, 1);
    let rows: Vec<_> =
        against.changed.iter().map(|changed| (changed.path.to_str().unwrap(), changed.is_by_value, changed.look)).collect();
    assert_eq!(
        rows,
        [
            ("edited.asm.ron", true, LookChange::Unknown),
            ("nudged.asm.ron", true, LookChange::Unknown),
            ("tagged.asm.ron", false, LookChange::Same(0.0)),
        ]
    );
    let keys: Vec<_> = against.changed[0].changes.iter().map(|change| change.key.as_str()).collect();
    assert_eq!(keys, ["roughness", "metallic"]);
    let looks: Vec<_> = with(true).changed.iter().map(|changed| changed.look).collect();
    assert!(matches!(looks[..], [LookChange::Changed(_), LookChange::Same(_), LookChange::Same(0.0)]), "{looks:?}");
}

#[test]
fn differences_are_listed_entry_by_entry() {
    let mut a = Material::named("Gold");
    a.set(Property::roughness, Value::Float(0.3)).set(Property::base_color, Value::Color([1.0, 0.5, 0.25]));
    let mut b = a.clone();
    (b.notes, b.unit_mm) = ("Second".to_owned(), Some(1.0));
    b.provenance.licence = "MIT".to_owned();
    assert!(changes(&a, &a.clone()).is_empty());
    // The default, written out, is none.
    b.set(Property::roughness, Value::Float(0.5))
        .set(Property::metallic, Value::Float(0.0))
        .set(Property::scatter, Value::Bool(true));
    b.slot_mut(Property::coat).texture = Some(TextureRef::new("coat.png"));
    let found = changes(&a, &b);
    let rows: Vec<_> =
        found.iter().map(|change| (change.key.as_str(), change.a.as_deref(), change.b.as_deref(), change.is_visible)).collect();
    assert_eq!(
        rows,
        [
            ("notes", None, Some("\"Second\""), false),
            ("unit_mm", None, Some("1.0"), true),
            ("provenance.licence", None, Some("\"MIT\""), false),
            ("roughness", None, Some("0.5"), true),
            ("scatter", None, Some("true"), true),
            ("coat.texture", None, Some("{ \"path\": \"coat.png\" }"), true),
        ]
    );
    let file = |text: &str| MaterialFile::parse(text).expect("it is RON").0;
    let (a, b) = (file(r#"{"velvet": 1, "sources": {"roughness": "x"}}"#), file(r#"{"velvet": 2, "silk": [1]}"#));
    let rows: Vec<_> = file_changes(&a, &b).into_iter().map(|change| (change.key, change.a, change.b)).collect();
    let some = |text: &str| Some(text.to_owned());
    let expected = [("sources.roughness", some("\"x\""), None), ("velvet", some("1"), some("2")), ("silk", None, some("[1]"))];
    assert_eq!(rows, expected.map(|(key, a, b)| (key.to_owned(), a, b)));
}

#[test]
fn conflicts_are_told_and_decided() {
    let of = |name: &str, roughness: f64, distance: f64, unit: Option<f64>| {
        let mut material = Material::named(name);
        material.unit_mm = unit;
        material.set(Property::roughness, Value::Float(roughness)).set(Property::scatter_distance, Value::Float(distance));
        material
    };
    let base = of("Wax", 0.3, 0.5, None);
    let (a, b) = (of("Bee wax", 0.4, 0.5, None), of("Candle wax", 0.6, 0.5, None));
    for (prefer, roughness, name, alias) in [(Side::A, 0.4, "Bee wax", "Candle wax"), (Side::B, 0.6, "Candle wax", "Bee wax")] {
        let merged = merge(&base, &a, &b, prefer);
        let keys: Vec<_> = merged.conflicts.iter().map(|conflict| conflict.key.as_str()).collect();
        assert_eq!(keys, ["roughness"]);
        assert_eq!((merged.material.float(Property::roughness), merged.material.name.as_str()), (roughness, name));
        assert_eq!(merged.material.aliases, [alias]);
    }
    // A length means nothing without its unit: one version changed the unit, the other a length.
    let merged = merge(&base, &of("Wax", 0.3, 50.0, Some(1.0)), &of("Wax", 0.3, 0.6, None), Side::A);
    assert_eq!(merged.conflicts.iter().map(|conflict| conflict.key.as_str()).collect::<Vec<_>>(), ["unit_mm"]);
    assert_eq!((merged.material.unit_mm, merged.material.float(Property::scatter_distance)), (Some(1.0), 50.0));
    let merged = merge(&base, &of("Wax", 0.3, 50.0, Some(1.0)), &of("Wax", 0.9, 0.5, None), Side::A);
    assert!(merged.conflicts.is_empty());
    assert_eq!(merged.material, of("Wax", 0.9, 50.0, Some(1.0)));
}

#[test]
fn a_merged_file_keeps_the_first_text_and_tells_what_it_lacks() {
    let file = |text: &str| MaterialFile::parse(text).expect("it is RON").0;
    let base = file("{\n    \"asm\": \"4.0\", \"mine\": 1,\n    \"properties\": { \"roughness\": 0.3, \"coat\": 1.0 },\n}\n");
    let a = file(
        "// Mine.\n{\n    \"asm\": \"4.0\", \"mine\": 2,\n    \"properties\": { \"roughness\": 0.30, \"coat\": 0.5 }, // so\n}\n",
    );
    let b = file(
        "{\"asm\": \"4.0\", \"mine\": 1, \"theirs\": [3], \"sources\": {\"roughness\": {\"method\": \"measured\"}}, \
         \"properties\": {\"roughness\": 0.7, \"coat\": 1.0}}",
    );
    let merged = merge_files(&base, &a, &b, Side::A);
    assert_eq!(
        merged.text,
        "// Mine.\n{\n    \"asm\": \"4.0\", \"mine\": 2,\n    \"properties\": { \"roughness\": 0.7, \"coat\": 0.5 }, // so\n}\n"
    );
    assert_eq!((merged.merged.taken, merged.merged.conflicts.len()), (vec!["roughness".to_owned()], 0));
    let left: Vec<_> = merged.left_out.iter().map(|change| change.key.as_str()).collect();
    assert_eq!(left, ["sources.roughness", "theirs"]);
}

/// Materials with few different entries, so that two versions often change the same.
fn material() -> impl Strategy<Value = Material> {
    let properties = || select(vec![Property::roughness, Property::metallic, Property::coat, Property::scatter_distance]);
    let edits = proptest::collection::vec((properties(), 0_u8..4), 0..5);
    let words = || select(vec!["", "one", "two"]);
    let tags = subsequence(vec!["a", "b", "c", "d"], 0..=4);
    (edits, words(), words(), tags, select(vec![None, Some(100.0), Some(1.0)])).prop_map(
        |(edits, name, licence, tags, unit_mm)| {
            let mut material = Material::named(name);
            material.unit_mm = unit_mm;
            material.provenance.licence = licence.to_owned();
            material.tags = tags.into_iter().map(str::to_owned).collect();
            for (property, choice) in edits {
                match choice {
                    0 => _ = material.set(property, property.def().default),
                    1 => material.slot_mut(property).texture = Some(TextureRef::new("map.png")),
                    choice => _ = material.set(property, Value::Float(f64::from(choice) / 8.0)),
                }
            }
            material
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn taking_every_entry_over_leaves_no_difference(a in material(), b in material(), alias in "[a-z]{0,3}") {
        let (mut to, mut from) = (a, b);
        from.aliases.push(alias);
        for change in changes(&to.clone(), &from) {
            prop_assert!(take(&mut to, &from, &change.key), "{}", change.key);
        }
        let found = changes(&to, &from);
        prop_assert!(found.is_empty(), "{found:?}");
        prop_assert!(!take(&mut to, &from, "velvet"));
    }

    #[test]
    fn what_one_version_changed_is_taken(base in material(), a in material(), b in material()) {
        for prefer in [Side::A, Side::B] {
            for (x, y, expected) in [(&a, &base, &a), (&base, &b, &b), (&a, &a, &a)] {
                let merged = merge(&base, x, y, prefer);
                prop_assert!(merged.conflicts.is_empty(), "{:?}", merged.conflicts);
                prop_assert_eq!(&merged.material, expected);
            }
        }
        let (mut one, mut other) = (merge(&base, &a, &b, Side::A), merge(&base, &b, &a, Side::A));
        prop_assert_eq!(one.conflicts.len(), other.conflicts.len());
        let is_renamed_twice = a.name != base.name && b.name != base.name && a.name != b.name;
        if one.conflicts.is_empty() && !is_renamed_twice {
            one.material.tags.sort();
            other.material.tags.sort();
            let found = changes(&one.material, &other.material);
            prop_assert!(found.is_empty(), "{found:?}");
        }
        // Preferring the other side is the same as changing sides.
        let (one, other) = (merge(&base, &a, &b, Side::B), merge(&base, &b, &a, Side::A));
        for def in PROPERTIES {
            prop_assert_eq!(one.material.value(def.id), other.material.value(def.id));
            prop_assert_eq!(&one.material.slot(def.id).texture, &other.material.slot(def.id).texture);
        }
        let file = MaterialFile::new(&a);
        let merged = merge_files(&MaterialFile::new(&base), &file, &MaterialFile::new(&b), Side::A);
        let (read, warnings) = MaterialFile::parse(&merged.text).expect("the writer makes readable text");
        prop_assert!(warnings.is_empty() && merged.left_out.is_empty());
        prop_assert_eq!(read.material(), &merged.merged.material);
    }
}

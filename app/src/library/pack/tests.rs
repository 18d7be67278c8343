#![allow(clippy::unwrap_used)] // A helper that fails fails its test.

use super::*;
use burnish_material::Property;
use serde_json::Value;
use std::collections::BTreeSet;
use tempfile::TempDir;

/// A library with images inside, outside and twice, and one file that is none.
struct Place {
    folder: TempDir,
}

impl Place {
    fn new() -> Self {
        let place = Self { folder: tempfile::tempdir().unwrap() };
        let image = |path: &str, level: u8| {
            let path = place.path(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            image::GrayImage::from_pixel(2, 2, image::Luma([level])).save(path).unwrap();
        };
        image("library/metals/maps/a.png", 10);
        image("library/woods/same.png", 10);
        image("library/textures/out.png", 20);
        image("elsewhere/out.png", 30);
        let outside = place.path("elsewhere/out.png");
        let texture = |path: &str| format!("{{ \"texture\": {{ \"path\": \"{path}\" }} }}");
        place.write("metals/a.asm.ron", "A", "CC0-1.0", &texture("maps/./a.png"));
        place.write("metals/b.asm.ron", "B *bold*", "", &texture(outside.to_str().unwrap()));
        place.write("metals/c.asm.ron", "C", "CC0-1.0", &texture("builtin:wood-oak/roughness"));
        place.write("woods/d.asm.ron", "D", "MIT", &texture("same.png"));
        place.write("woods/e.asm.ron", "E", "MIT", &texture("../textures/out.png"));
        place.write("plain.asm.ron", "P", "MIT", "0.5");
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, path: &str, name: &str, licence: &str, roughness: &str) {
        let path = self.path("library").join(path);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        let text = format!(
            "// Kept.\n{{\n    \"asm\": \"4.0\",\n    \"name\": \"{name}\",\n    \"provenance\": {{ \"source\": \"Somebody\", \"licence\": \"{licence}\" }},\n    \"properties\": {{ \
             \"roughness\": {roughness} }},\n    \"sources\": {{ \"roughness\": {{ \"dataset\": \"data\", \"licence\": \"Other\" }} }},\n}}\n"
        );
        fs::write(path, text).unwrap();
    }

    fn pack(&self, target: &str) -> Result<Option<Packed>, PackError> {
        self.pack_with(target, Formats::NONE)
    }

    fn pack_with(&self, target: &str, formats: Formats) -> Result<Option<Packed>, PackError> {
        let root = self.path("library");
        let scan = Scan {
            root: &root,
            old: &Index::default(),
            threads: 1,
            has_picture: &|_| false,
            is_cancelled: &|| false,
            tell: &|_| {},
        };
        let entries = scan.run().unwrap().index.entries;
        let shelf = Shelf::open(&self.path("pictures"));
        let setup = Digest::default();
        let pack = Pack { name: "Test", root: &root, entries: &entries, shelf: &shelf, setup, threads: 1, formats };
        pack.write(&self.path(target), &|_, _| {}, &|| false)
    }

    fn read(&self, path: &str) -> String {
        fs::read_to_string(self.path(path)).unwrap()
    }

    fn names(&self, folder: &str) -> BTreeSet<String> {
        let root = self.path(folder);
        place::files(&root).unwrap().iter().map(|path| super::super::sheet::slashed(path.strip_prefix(&root).unwrap())).collect()
    }
}

#[test]
fn a_pack_holds_all_that_belongs_to_it() {
    let place = Place::new();
    let packed = place.pack("out").unwrap().unwrap();
    assert_eq!((packed.materials, packed.images, packed.warnings), (6, 3, vec![]));
    let expected = [
        "LICENCES.md",
        "check.json",
        "manifest.json",
        "materials/metals/a.asm.ron",
        "materials/metals/b.asm.ron",
        "materials/metals/c.asm.ron",
        "materials/metals/maps/a.png",
        "materials/plain.asm.ron",
        "materials/textures/out.png",
        "materials/woods/d.asm.ron",
        "materials/woods/e.asm.ron",
        "sheet.html",
        "sheet.png",
    ];
    let names = place.names("out");
    let (outside, names): (BTreeSet<_>, BTreeSet<_>) =
        names.into_iter().partition(|name| name.starts_with("materials/textures/out-"));
    assert_eq!(names, expected.into_iter().map(str::to_owned).collect());
    assert_eq!((outside.len(), packed.files), (1, 14), "two images of one name");

    // Only what has to be is edited, and nothing else of the file.
    for same in ["metals/a.asm.ron", "metals/c.asm.ron", "woods/e.asm.ron", "plain.asm.ron"] {
        assert_eq!(place.read(&format!("out/materials/{same}")), place.read(&format!("library/{same}")), "{same}");
    }
    let twin = place.read("out/materials/woods/d.asm.ron");
    assert_eq!(twin, place.read("library/woods/d.asm.ron").replace("same.png", "../metals/maps/a.png"));
    // Every image is found from its material.
    let entries = Index::default();
    let scan = Scan {
        root: &place.path("out/materials"),
        old: &entries,
        threads: 1,
        has_picture: &|_| false,
        is_cancelled: &|| false,
        tell: &|_| {},
    };
    for entry in scan.run().unwrap().index.entries {
        let folder = place.path("out/materials").join(&entry.path);
        for texture in &entry.textures {
            assert_eq!(crate::files::texture_problem(texture, folder.parent()), None);
            assert!(!Path::new(texture).is_absolute());
        }
    }

    let manifest: Value = serde_json::from_str(&place.read("out/manifest.json")).unwrap();
    let files = manifest["files"].as_array().unwrap();
    assert_eq!((files.len(), manifest["materials"].as_array().unwrap().len()), (13, 6));
    for file in files {
        let path = place.path("out").join(file["path"].as_str().unwrap());
        assert_eq!(file["hash"], Digest::of_file(&path, &|| true).unwrap().unwrap().to_string());
    }
    let check: Value = serde_json::from_str(&place.read("out/check.json")).unwrap();
    assert_eq!((&check["files"], &check["errors"]), (&6.into(), &0.into()), "{check}");
    let licences = place.read("out/LICENCES.md");
    let order = [
        "## No licence stated (1)",
        "**B \\*bold\\***",
        "## CC0-1.0 (2)",
        "## MIT (3)",
        "Somebody",
        "`roughness`: Other, data",
        "images: `materials/metals/maps/a.png`",
    ];
    let places: Vec<Option<usize>> = order.iter().map(|text| licences.find(text)).collect();
    assert!(places.iter().all(Option::is_some) && places[..4].is_sorted(), "{licences}");
    for file in ["manifest.json", "check.json", "LICENCES.md", "sheet.html"] {
        let text = place.read(&format!("out/{file}"));
        assert!(!text.contains(place.folder.path().to_str().unwrap()) && !text.contains(".tmp"), "{file}");
    }
}

#[test]
fn a_pack_is_replaced_only_if_nothing_is_lost() {
    let place = Place::new();
    place.pack("out").unwrap();
    fs::create_dir(place.path("empty")).unwrap();
    place.pack("empty").unwrap();
    for name in place.names("out") {
        assert!(fs::read(place.path("out").join(&name)).unwrap() == fs::read(place.path("empty").join(&name)).unwrap(), "{name}");
    }
    fs::remove_file(place.path("library/plain.asm.ron")).unwrap();
    place.write("broken.asm.ron", "", "", "{");
    let packed = place.pack("out").unwrap().unwrap();
    assert!(packed.materials == 5 && packed.warnings.len() == 1 && packed.warnings[0].contains("broken.asm.ron: left out: line"));
    assert!(!place.path("out/materials/plain.asm.ron").exists());

    let refused = |place: &Place, target: &str, expected: &str| {
        let before = place.names("");
        let error = place.pack(target).unwrap_err().to_string();
        assert!(error.contains(expected) && error.contains(target), "{error}");
        assert_eq!(place.names(""), before, "{target}");
    };
    refused(&place, "library/pack", "outside the library");
    refused(&place, "elsewhere", "without its manifest.json");
    refused(&place, "elsewhere/out.png", "found a file");
    refused(&place, "none/pack", "in a folder that exists");
    fs::write(place.path("out/mine.txt"), "mine").unwrap();
    refused(&place, "out", "holds mine.txt, which is not of the older pack");
    fs::remove_file(place.path("out/mine.txt")).unwrap();
    fs::write(place.path("out/LICENCES.md"), "mine").unwrap();
    refused(&place, "out", "LICENCES.md was changed since it was packed");
    fs::write(place.path("out/manifest.json"), "{}").unwrap();
    refused(&place, "out", "not of burnish-pack/1");
    // Nothing is left of packs that were not finished.
    let all = place.names("");
    assert!(!all.iter().any(|name| name.contains(".tmp") || name.contains(".old")), "{all:?}");
}

#[test]
fn missing_images_are_told_and_a_change_on_the_way_ends_it() {
    let place = Place::new();
    fs::remove_file(place.path("library/woods/same.png")).unwrap();
    fs::write(place.path("elsewhere/secret.txt"), "mine").unwrap();
    place.write("secret.asm.ron", "S", "MIT", "{ \"texture\": { \"path\": \"../elsewhere/secret.txt\" } }");
    let packed = place.pack("out").unwrap().unwrap();
    let [no_image, missing] = packed.warnings.as_slice() else { panic!("{:?}", packed.warnings) };
    assert!(missing.starts_with("woods/d.asm.ron: roughness: its image is not in the pack: expected an image"), "{missing}");
    assert!(
        no_image.starts_with("secret.asm.ron: roughness: its image") && no_image.ends_with("without the ending of one"),
        "{no_image}"
    );
    assert!(!place.names("out").iter().any(|name| name.contains("secret.txt")));
    let check: Value = serde_json::from_str(&place.read("out/check.json")).unwrap();
    assert_eq!(check["errors"], 2);
    assert!(check.to_string().contains("\"materials/woods/d.asm.ron\""), "{check}");

    let mut entry = Entry::unusable(Path::new("plain.asm.ron"), String::new());
    entry.problem = None;
    let entries = [Arc::new(entry)];
    let (root, shelf) = (place.path("library"), Shelf::default());
    let (setup, formats) = (Digest::default(), Formats::NONE);
    let pack = Pack { name: "Test", root: &root, entries: &entries, shelf: &shelf, setup, threads: 1, formats };
    let error = pack.write(&place.path("late"), &|_, _| {}, &|| false).unwrap_err().to_string();
    assert!(error.contains("plain.asm.ron: was changed while it was packed"), "{error}");
    assert_eq!(pack.write(&place.path("late"), &|_, _| {}, &|| true).unwrap(), None);
    assert!(!place.path("late").exists());
}

/// The material that a file of the pack holds, and the bytes of the image of its roughness.
fn reopened(path: &Path) -> (burnish_material::Material, Option<Vec<u8>>) {
    let opened = crate::exchange::open::open(path).unwrap();
    let [one] = opened.as_slice() else { panic!("{}: {} materials", path.display(), opened.len()) };
    assert_eq!(one.notes, [""; 0], "{}", path.display());
    assert!(one.file.text().starts_with("// Kept."), "{}: {}", path.display(), one.file.text());
    let texture = one.file.material().slot(Property::roughness).texture.clone();
    let image = texture.filter(|texture| !texture.path.starts_with("builtin:")).map(|texture| {
        let held = one.embedded.get(&texture.path).map(|bytes| bytes.to_vec());
        held.unwrap_or_else(|| fs::read(one.folder.as_deref().unwrap().join(&texture.path)).unwrap())
    });
    (one.file.material().clone(), image)
}

#[test]
fn every_format_holds_the_same_materials_again() {
    let place = Place::new();
    // Of one file name and one name in the file, with another image of one name: nothing takes the place of anything else.
    let colour = r#"{ "texture": { "path": "../metals/maps/a.png", "scale": [0.5, 0.5, 0.5] } }, "metallic": 0.1, "scatter_red_shift": 0.3"#;
    place.write("woods/a.asm.ron", "A", "MIT", colour);
    place.write("metals/a.asm.ron", "A", "CC0-1.0", &colour.replace("../metals/maps/a.png", "../textures/out.png"));
    place.write("woods/f.asm.ron", "F", "MIT", r#"{ "texture": { "path": "builtin:wood-oak/roughness?mean=0.4" } }"#);
    let packed = place.pack_with("out", Formats::default()).unwrap().unwrap();
    assert_eq!((packed.materials, packed.images, packed.warnings), (8, 3, vec![]));
    let made: Vec<String> = place.names("out/gltf").into_iter().filter(|name| name.contains("wood-oak_roughness")).collect();
    let bytes: BTreeSet<Vec<u8>> = made.iter().map(|name| fs::read(place.path("out/gltf").join(name)).unwrap()).collect();
    assert!(made.len() == 2 && bytes.len() == 2, "two made images of one name: {made:?}");
    let manifest: Value = serde_json::from_str(&place.read("out/manifest.json")).unwrap();
    let hashed: BTreeSet<&str> = manifest["files"].as_array().unwrap().iter().map(|row| row["path"].as_str().unwrap()).collect();
    for row in manifest["materials"].as_array().unwrap() {
        let (native, image) = reopened(&place.path("out").join(row["path"].as_str().unwrap()));
        let files = row["formats"].as_object().unwrap();
        assert_eq!(files.keys().collect::<Vec<_>>(), ["gltf", "materialx", "usd"]);
        for file in files.values().map(|file| file.as_str().unwrap()) {
            assert!(hashed.contains(file), "{file}");
            let (material, other_image) = reopened(&place.path("out").join(file));
            assert_eq!((material.name.as_str(), &other_image), (native.name.as_str(), &image), "{file}");
            for (property, slot) in native.slots() {
                let other = material.slot(property);
                assert_eq!(slot.value, other.value, "{file}: {}", property.def().name);
                let how = |slot: &burnish_material::Slot| {
                    slot.texture.clone().map(|texture| burnish_material::TextureRef { path: String::new(), ..texture })
                };
                assert_eq!(how(slot), how(other), "{file}: {}", property.def().name);
            }
        }
    }
    // An image that many use lies there once.
    for folder in ["usd", "materialx"] {
        let all = place.names(&format!("out/{folder}"));
        assert_eq!(all.iter().filter(|name| name.ends_with("a.png")).count(), 1, "{all:?}");
    }
    let losses: Value = serde_json::from_str(&place.read("out/losses.json")).unwrap();
    let shift = losses["materials"].as_array().unwrap().iter().filter(|row| row["name"] == "A");
    let lost: Vec<&Value> = shift
        .flat_map(|row| row["formats"].as_object().unwrap().values())
        .flat_map(|format| format["rows"].as_array().unwrap())
        .filter(|row| row["property"] == "scatter_red_shift")
        .map(|row| &row["fate"])
        .collect();
    assert!(lost.len() == 6 && lost.contains(&&Value::from("dropped")), "{losses}");

    fs::create_dir(place.path("empty")).unwrap();
    place.pack_with("empty", Formats::default()).unwrap();
    assert_eq!(place.names("out"), place.names("empty"));
    for name in place.names("out") {
        assert!(fs::read(place.path("out").join(&name)).unwrap() == fs::read(place.path("empty").join(&name)).unwrap(), "{name}");
        let text = String::from_utf8_lossy(&fs::read(place.path("out").join(&name)).unwrap()).into_owned();
        assert!(!text.contains(place.folder.path().to_str().unwrap()), "{name}");
    }
    let fewer = place.pack_with("out", Formats::parse("gltf").unwrap()).unwrap().unwrap();
    assert!(fewer.files < packed.files && place.path("out/gltf").is_dir() && !place.path("out/usd").exists());
}

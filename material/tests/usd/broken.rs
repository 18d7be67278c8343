//! Files from strangers: broken and hostile files cost one clear sentence, neither a panic nor much time or memory.

use burnish_material::exchange::usd::{self, UsdError, usdz};
use burnish_material::{Material, Property};

const BODY: &str = "def Material \"M\" {\n    token outputs:adobe:surface.connect = </M/S.outputs:surface>\n    def Shader \"S\" {\n        \
                    uniform token info:id = \"AdobeStandardMaterial_4_0\"\n        INPUT\n        token outputs:surface\n    }\n}\n";

fn with_input(input: &str) -> String {
    format!("#usda 1.0\n{}", BODY.replace("INPUT", input))
}

fn fault(text: &str) -> String {
    match usd::read(text) {
        Ok(scene) => panic!("expected an error, read {} materials, {:?}", scene.materials.len(), scene.notes),
        Err(error) => error.to_string(),
    }
}

#[test]
fn broken_text_is_refused_with_its_line() {
    for (text, line, words) in [
        ("#usda 1.0\ndef Material \"M\" {\n", 3, "the end of the file"),
        ("#usda 1.0\n}\n", 2, "`def`, `over` or `class`"),
        ("#usda 1.0\ndef Material M {}\n", 2, "in quotes"),
        ("#usda 1.0\ndef Material \"M {\n}\n", 2, "the end of a text"),
        ("#usda 1.0\n(\n  doc = \"\"\"never\n ends\n", 3, "the end of a text"),
        ("#usda 1.0\ndef \"a\" {\n  asset x = @file\n}\n", 3, "a file path"),
        ("#usda 1.0\ndef \"a\" {\n  rel x = </a\n}\n", 3, "a path"),
        ("#usda 1.0\n\n/* no end", 3, "a comment"),
        ("#usda 1.0\ndef \"a\" {\n  float x = 1.2.3\n}\n", 3, "a number"),
        ("#usda 1.0\ndef \"a\" {\n  float x = -banana\n}\n", 3, "a number"),
        ("#usda 1.0\ndef \"a\" {\n  float x = \n}\n", 4, "a value"),
        ("#usda 1.0\ndef \"a\" {\n  color3f x = (1, 2\n}\n", 4, "`,` or `)`"),
        ("#usda 1.0\ndef \"a\" {\n  float3[] x = [(1, 2, 3), (1, 2)]\n}\n", 3, "items of 3 numbers"),
        ("#usda 1.0\ndef \"a\" {\n  float[] x = [1, \"two\"]\n}\n", 3, "a number"),
        ("#usda 1.0\ndef \"a\" {\n  float x = (((1)))\n}\n", 3, "a number"),
        ("#usda 1.0\ndef \"a\" {\n  float x.timeSamples = { 0: 1, b: 2 }\n}\n", 3, "a time"),
        ("#usda 1.0\ndef \"a\" {\n  float x.connect = 5\n}\n", 3, "a path"),
        ("#usda 1.0\ndef \"a\" (\n  kind\n) {\n}\n", 4, "`=`"),
        ("#usda 1.0\ndef \"a\" (\n  x = { int }\n) {\n}\n", 3, "the name of an entry"),
        ("#usda 1.0\ndef \"a\" {\n  float x = 1 $\n}\n", 3, "found `$`"),
        ("#usda 1.0\ndef \"a\" {\n  variantSet \"v\" = {\n   \"x\" {\n", 4, "the end of a block"),
    ] {
        let message = fault(text);
        assert!(message.starts_with(&format!("line {line}: expected")) && message.contains(words), "{text}\n{message}");
    }
}

#[test]
fn other_files_are_refused_by_what_they_are() {
    assert_eq!(usd::layer_text(b"PXR-USDC\0\0").map(str::len), Err(UsdError::Binary));
    assert!(UsdError::Binary.to_string().contains("usdcat"));
    assert_eq!(usd::layer_text(b"PK\x03\x04...").map(str::len), Err(UsdError::IsPackage));
    assert!(matches!(usd::layer_text(b"#usda 1.0\n\xff"), Err(UsdError::Syntax { line: 2, .. })));
    for text in ["", "{}", "#usd", "<?xml?>", "#usdaX"] {
        assert_eq!(usd::read(text).map(|scene| scene.notes), Err(UsdError::NotUsd), "{text}");
    }
    assert!(usd::read("\u{feff}#usda 1.0\r\n\r\ndef \"a\"\r\n{\r\n}\r\n").is_ok());
}

#[test]
fn numbers_that_are_not_finite_are_not_taken() {
    for number in ["1e400", "-1e400", "nan", "inf", "-inf", "+nan"] {
        let scene = usd::read(&with_input(&format!("float inputs:emissiveIntensity = {number}"))).expect("a scene");
        assert!(
            scene.notes.iter().any(|note| note.starts_with("line 6:") && note.contains("finite")),
            "{number}: {:?}",
            scene.notes
        );
        assert_eq!(scene.materials[0].material.slot(Property::emission).value, None, "{number}");
    }
}

#[test]
fn strange_inputs_cost_notes() {
    for (input, words) in [
        ("color3f inputs:baseColor = 0.5", "three numbers"),
        ("float inputs:roughness = \"rough\"", "a number"),
        ("float inputs:roughness = [0.5]", "a number"),
        ("float inputs:roughness.connect = </M/S.inputs:roughness>", "circle"),
        (
            "float inputs:roughness.connect = </M/S.inputs:metallic>\n float inputs:metallic.connect = </M/S.inputs:roughness>",
            "circle",
        ),
        ("float inputs:roughness.connect = </Nowhere.outputs:r>", "not there"),
        ("float inputs:roughness.connect = </M/S.outputs:surface>", "not understood"),
        ("float inputs:velvet = 0.5", "velvet"),
    ] {
        let scene = usd::read(&with_input(input)).expect("a scene");
        assert!(scene.notes.iter().any(|note| note.contains(words)), "{input}: {:?}", scene.notes);
        assert_eq!(scene.materials[0].material.slots().filter(|(_, slot)| slot.value.is_some()).count(), 0, "{input}");
    }
}

#[test]
fn images_outside_of_the_folder_are_not_used() {
    for path in ["/etc/passwd", "../../secret.png", "a/../../b.png", "http://host/a.png", "C:/a.png", "\\\\host\\a.png", ""] {
        let image = format!(
            "def Shader \"T\" {{ uniform token info:id = \"UsdUVTexture\"; asset inputs:file = @{path}@; float outputs:r }}"
        );
        let text = with_input("float inputs:roughness.connect = </M/T.outputs:r>")
            .replace("    def Shader \"S\"", &format!("{image}\ndef Shader \"S\""));
        let scene = usd::read(&text).expect("a scene");
        assert!(scene.materials[0].material.slot(Property::roughness).texture.is_none(), "{path}");
        assert_eq!(scene.notes.len(), 1, "{path}: {:?}", scene.notes);
    }
}

#[test]
fn files_without_end_are_bounded() {
    let prims = format!("#usda 1.0\n{}", "def \"a\" {}\n".repeat(1_000));
    assert!(usd::read(&prims).is_ok(), "the same prim again is one prim");
    let mut many = String::from("#usda 1.0\n");
    (0..1_000_000).for_each(|k| many += &format!("over \"p{k}\" {{}}\n"));
    assert!(fault(&many).contains("500000 prims"));
    assert!(fault(&format!("#usda 1.0\n{}", "def \"a\" {".repeat(100_000))).contains("inside each other"));
    let nested = format!("#usda 1.0\n(\n x = {}\n", "{ dictionary a = ".repeat(100_000));
    assert!(fault(&nested).contains("inside each other"));
    assert!(fault(&format!("#usda 1.0\ndef \"a\" {{ float x = {}", "(".repeat(100_000))).contains("a number"));
    assert!(fault(&format!("#usda 1.0\ndef \"{}\" {{}}", "n".repeat(5_000))).contains("1000 bytes"));
    assert!(fault(&format!("#usda 1.0\n({})", "a = 1 ".repeat(20_000))).contains("10000 entries"));
    let sets = "variantSet \"v\" = {} ".repeat(20_000);
    assert!(fault(&format!("#usda 1.0\ndef \"a\" {{ {sets} }}")).contains("sets of variants"));
    // One long line must not be searched again for each of its tokens.
    let paths = format!("#usda 1.0\ndef \"a\" {{ rel x = [{}] }}", "</a>, ".repeat(500_000));
    assert!(usd::read(&paths).is_ok());
    let quotes = format!("#usda 1.0\n(\n{}\n", "\"".repeat(1_000_000));
    assert!(usd::read(&quotes).is_err());
    let large = format!("#usda 1.0\n{}", " ".repeat(usd::MAX_USDA_BYTES));
    assert!(fault(&large).contains("bytes"));
}

/// Every prefix of a good file, and every byte of it replaced, is read or refused, but never more than that.
#[test]
fn damaged_files_never_panic() {
    let mut material = Material::named("a");
    material.slot_mut(Property::roughness).texture = Some(burnish_material::TextureRef::new("a.png"));
    material.set(Property::metallic, burnish_material::Value::Float(0.1 + 0.2));
    let options = usd::Options { path_of: &|texture| texture.path.clone(), image_folder: "", mesh: None, has_native_copy: true };
    let text = usd::write(&[&material], &options).text;
    for length in (0..text.len()).step_by(7) {
        _ = usd::read(&text[..length]);
    }
    for (place, new) in (0..text.len()).step_by(3).zip("\0\"(){}[]<>@=.,:-9eE#\n".bytes().cycle()) {
        let mut bytes = text.clone().into_bytes();
        bytes[place] = new;
        if let Ok(text) = usd::layer_text(&bytes) {
            _ = usd::read(text);
        }
    }
}

fn package() -> Vec<u8> {
    usdz::write("a.usda", "#usda 1.0\n", &[("maps/a.png", b"abcd"), ("b.png", b"")]).expect("a package")
}

/// Offsets of `name` in the package: in front of the file and in the list.
fn places(bytes: &[u8], name: &str) -> (usize, usize) {
    let mut found = bytes.windows(name.len()).enumerate().filter(|(_, window)| *window == name.as_bytes()).map(|(at, _)| at);
    let mut next = || found.next().expect("the name");
    (next() - 30, next() - 46)
}

#[test]
fn packages_are_aligned_and_come_back() {
    let bytes = package();
    let read = usdz::read(&bytes).expect("our own package");
    let names: Vec<&str> = read.files().map(|(name, _)| name).collect();
    assert_eq!(names, ["a.usda", "maps/a.png", "b.png"]);
    for (_, data) in read.files() {
        assert_eq!((data.as_ptr() as usize - bytes.as_ptr() as usize) % 64, 0);
    }
    assert_eq!(read.beside_layer("maps/a.png"), Some(&b"abcd"[..]));
    let deep = usdz::write("d/a.usda", "#usda 1.0\n", &[("d/b.png", b"b")]).expect("a package");
    assert_eq!(usdz::read(&deep).expect("our own package").beside_layer("b.png"), Some(&b"b"[..]));
    assert_eq!((read.layer(), read.file("maps/a.png"), read.file("c")), (Ok("#usda 1.0\n"), Some(&b"abcd"[..]), None));
}

#[test]
fn broken_packages_are_refused() {
    let refused = |change: &dyn Fn(&mut Vec<u8>), words: &str| {
        let mut bytes = package();
        change(&mut bytes);
        match usdz::read(&bytes) {
            Ok(read) => {
                panic!("expected an error with `{words}`, read {:?}", read.files().map(|(name, _)| name).collect::<Vec<_>>())
            }
            Err(error) => assert!(error.to_string().contains(words), "{error} has no `{words}`"),
        }
    };
    let (local, list) = places(&package(), "maps/a.png");
    let end = package().len() - 22;
    let put = |at: usize, new: &'static [u8]| move |bytes: &mut Vec<u8>| bytes[at..at + new.len()].copy_from_slice(new);
    refused(&put(list + 10, &[8, 0]), "compressed");
    refused(&put(list + 20, &[3, 0]), "compressed");
    refused(&put(list + 8, &[1, 8]), "encrypted");
    refused(&put(list + 46, b"../s/a.png"), "leads out");
    refused(&put(list + 46, b"/aps/a.png"), "leads out");
    refused(&put(list + 46, b"C:ps/a.png"), "leads out");
    refused(&put(list + 46, b"ma\\s/a.png"), "leads out");
    refused(&put(list + 46, b"ma\0s/a.png"), "readable");
    refused(&put(list + 46, b"ma\xffs/a.png"), "UTF-8");
    refused(&put(list + 46, b"mops/a.png"), "same name");
    refused(&put(local, b"XX"), "same name");
    refused(&put(list + 20, &[255, 255, 255, 255, 255, 255, 255, 255]), "zip64");
    refused(&put(list + 20, &[0, 0, 255, 0, 0, 0, 255, 0]), "lies outside");
    refused(&put(list + 42, &[255, 255, 255, 0]), "lies outside");
    refused(&put(list + 16, &[1, 2, 3, 4]), "checksum");
    refused(&put(list + 28, &[255, 255]), "ends too early");
    refused(&put(end + 10, &[2, 0]), "in one piece");
    refused(&put(end + 8, &[9, 0, 9, 0]), "ends too early");
    refused(&put(end + 8, &[255, 255, 255, 255]), "zip64");
    refused(&put(end + 16, &[1, 0, 0, 0]), "list of files");
    refused(&|bytes| bytes.truncate(40), "no end");
    refused(&|bytes| bytes.clear(), "too few bytes");
    // Two entries of the list that mean the same bytes.
    refused(
        &|bytes| {
            let (_, first) = places(bytes, "a.usda");
            let twin = bytes[first..first + 46 + 6].to_vec();
            let (_, second) = places(bytes, "b.png");
            bytes.splice(second..second + 46 + 5, twin);
            let end = bytes.len() - 22;
            let size = bytes[end + 12] + 1;
            bytes[end + 12] = size;
        },
        "twice",
    );
    // A file within the bytes of another one.
    let inner = usdz::write("q.png", "same", &[]).expect("a package");
    let files: [(&str, &[u8]); 2] = [("hold.bin", &inner), ("q.png", b"same")];
    let mut bytes = usdz::write("a.usda", "", &files).expect("a package");
    assert!(usdz::read(&bytes).is_ok());
    let start = bytes.windows(inner.len()).position(|window| window == inner).expect("the inner one");
    let list = bytes.windows(5).rposition(|window| window == b"q.png").expect("the entry") - 46;
    bytes[list + 42..list + 46].copy_from_slice(&(start as u32).to_le_bytes());
    let error = usdz::read(&bytes).map(|read| read.files().count()).expect_err("files that share bytes");
    assert!(error.to_string().contains("bytes of its own"), "{error}");

    let layer = usdz::write("a.png", "no layer", &[]).expect("a package");
    assert!(usdz::read(&layer).and_then(|read| read.layer().map(str::len)).is_err());
    assert!(usdz::write("a.usda", "", &[("../a.png", b"")]).is_err() && usdz::write("a.usda", "", &[("a.usda", b"")]).is_err());
    for place in 0..package().len() {
        let mut bytes = package();
        bytes[place] ^= 0x55;
        _ = usdz::read(&bytes).map(|read| read.layer().map(str::len));
    }
}

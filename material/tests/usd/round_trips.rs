//! What is exported comes back bit for bit, and another program's edits hold.

use burnish_material::exchange::usd::{self, Options, usdz};
use burnish_material::{Channel, ColorSpace, Kind, Material, MaterialFile, PROPERTIES, Property, TextureRef, Value, Vary, Wrap};

use super::{export, read};

/// Small seeded generator (Marsaglia's xorshift).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }
    fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }
    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn value_of(kind: Kind, mut number: impl FnMut() -> f64) -> Value {
    match kind {
        Kind::Bool => Value::Bool(number() > 0.5),
        Kind::Float => Value::Float(number()),
        Kind::Color => Value::Color([number(), number(), number()]),
        Kind::Normal => Value::Normal([number(), number(), number()]),
    }
}

/// Every property by one rule from its row.
fn filled(name: &str, number: impl Fn(&burnish_material::PropertyDef) -> f64) -> Material {
    let mut material = Material::named(name);
    for def in PROPERTIES {
        material.set(def.id, value_of(def.default.kind(), || number(def)));
    }
    material
}

fn random_texture(random: &mut Random) -> TextureRef {
    let mut texture = TextureRef::new(["a.png", "./maps/bild 1@ä.png", "odd@@@\n.exr", "../b.png"][random.below(4) as usize]);
    texture.channel = Channel::ALL[random.below(5) as usize].0;
    texture.color_space = ColorSpace::ALL[random.below(3) as usize].0;
    texture.wrap = Wrap::ALL[random.below(3) as usize].0;
    texture.is_inverted = random.below(3) == 0;
    if random.below(2) == 0 {
        texture.scale = [random.unit(), 0.1 + 0.2, -random.unit()];
        texture.bias = [random.unit(), 0.0, 1e-9];
        texture.uv_scale = [3.0 * random.unit(), -1.5];
        texture.uv_offset = [random.unit(), 0.25];
        texture.uv_rotation = 360.0 * random.unit();
    }
    texture
}

fn random_material(random: &mut Random) -> Material {
    let mut material = Material::named(["", "Oak, \"old\" \\ wood", "木", "9 lives", "plain_name"][random.below(5) as usize]);
    for def in PROPERTIES {
        let number = |random: &mut Random| match random.below(9) {
            0 => def.limits.min.unwrap_or(-1.0),
            1 => def.limits.max.unwrap_or(1e300),
            2 => [0.1 + 0.2, -0.0, 5e-324, -7.5][random.below(4) as usize],
            3 => f64::from((random.unit() * 3.0) as f32),
            4 => (random.unit() * 100.0).round() / 100.0,
            _ => random.unit(),
        };
        if random.below(3) > 0 {
            material.set(def.id, value_of(def.default.kind(), || number(random)));
        }
        if def.vary != Vary::Uniform && random.below(6) == 0 {
            material.slot_mut(def.id).texture = Some(random_texture(random));
        }
    }
    if random.below(2) == 0 {
        material.notes = "line one\nline \"two\" \\ \t§ \u{1}\u{7f}\u{85}".to_owned();
        material.tags = vec!["a".to_owned(), "b,\"c\"".to_owned()];
        material.aliases = vec!["other".to_owned()];
        material.provenance.source = "somebody".to_owned();
        material.unit_mm = Some(1.0 / 3.0);
        let entry = ("KHR_materials_iridescence".to_owned(), "{\"iridescenceFactor\":0.1}".to_owned());
        material.foreign.entry("gltf".to_owned()).or_default().extend([entry]);
    }
    material
}

/// As the file writes it, to the last bit, with everything that a file does not hold.
fn exact(material: &Material) -> String {
    let bits: Vec<_> = material
        .slots()
        .map(|(_, slot)| slot.value.map(|v| v.numbers().iter().map(|x| x.to_bits()).collect::<Vec<_>>()))
        .collect();
    let textures: Vec<_> = material.slots().map(|(_, slot)| format!("{:?}", slot.texture)).collect();
    format!("{}{bits:?}{textures:?}{:?}", MaterialFile::new(material).text(), material.foreign)
}

fn assert_comes_back(materials: &[&Material]) {
    let export = export(materials);
    assert_eq!(self::export(materials).text, export.text, "not the same twice");
    let package = usdz::write("scene.usda", &export.text, &[("maps/a.png", b"abc")]).expect("a package");
    assert_eq!(usdz::write("scene.usda", &export.text, &[("maps/a.png", b"abc")]).as_ref(), Ok(&package));
    let package = usdz::read(&package).expect("our own package");
    assert_eq!(package.file("maps/a.png"), Some(&b"abc"[..]));
    for text in [export.text.as_str(), package.layer().expect("a layer")] {
        let scene = read(text);
        assert!(scene.notes.is_empty(), "{:?}\n{text}", scene.notes);
        assert_eq!(scene.materials.len(), materials.len());
        for (found, material) in scene.materials.iter().zip(materials) {
            assert!(found.is_native && found.network == "AdobeStandardMaterial_4_0");
            assert_eq!(exact(&found.material), exact(material), "{text}");
        }
    }
}

#[test]
fn materials_come_back_bit_for_bit() {
    let low = filled("low", |def| def.limits.min.unwrap_or(-2.0));
    let high = filled("high", |def| def.limits.max.unwrap_or(1000.0));
    let off = filled("off", |def| def.limits.min.unwrap_or(0.0) + 0.3);
    let wide = filled("wide", |_| 0.1 + 0.2);
    let all = [Material::default(), Material::named("named"), off, low, high, wide];
    for material in &all {
        assert_comes_back(&[material]);
    }
    assert_comes_back(&all.each_ref());
    assert_comes_back(&[]);
}

#[test]
fn random_materials_come_back_bit_for_bit() {
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    for _ in 0..150 {
        assert_comes_back(&[&random_material(&mut random)]);
    }
    let three: Vec<Material> = (0..3).map(|_| random_material(&mut random)).collect();
    let mut units = three;
    units.iter_mut().for_each(|material| material.unit_mm = Some(10.0));
    assert_comes_back(&units.iter().collect::<Vec<_>>());
}

#[test]
fn images_in_another_place_keep_their_bindings() {
    let mut material = Material::named("a");
    material.slot_mut(Property::roughness).texture = Some(TextureRef::new("builtin:wood-oak/roughness"));
    let options =
        Options { path_of: &|_| "textures/roughness.png".to_owned(), image_folder: "", mesh: None, has_native_copy: true };
    let text = usd::write(&[&material], &options).text;
    assert!(text.contains("@./textures/roughness.png@"), "{text}");
    let scene = read(&text);
    assert_eq!(scene.materials[0].material, material);
    assert_eq!(scene.materials[0].files, [("builtin:wood-oak/roughness".to_owned(), "textures/roughness.png".to_owned())]);
}

#[test]
fn no_number_that_is_not_finite_is_written() {
    let mut material = filled("odd", |_| f64::NAN);
    material.set(Property::emission, Value::Float(f64::INFINITY));
    material.slot_mut(Property::base_color).texture = Some(TextureRef { scale: [f64::NAN; 3], ..TextureRef::new("a.png") });
    let export = export(&[&material]);
    let mut words = export.text.split(|c: char| !c.is_ascii_alphanumeric());
    assert!(!words.any(|word| matches!(word, "inf" | "nan" | "NaN")) && !export.notes.is_empty(), "{}", export.text);
    read(&export.text);
}

#[test]
fn a_wide_number_counts_while_the_input_holds_its_rounding() {
    let mut material = Material::named("a");
    material.set(Property::roughness, Value::Float(0.1 + 0.2));
    let text = export(&[&material]).text;
    assert!(text.contains("\"roughness=0.30000000000000004\""), "{text}");
    let changed = text.replace("float inputs:roughness = 0.3\n", "float inputs:roughness = 0.4\n");
    assert_ne!(text, changed);
    assert_eq!(read(&changed).materials[0].material.float(Property::roughness), 0.4);
}

#[test]
fn what_another_program_changes_holds_alone() {
    let mut material = Material::named("a");
    material.set(Property::metallic, Value::Float(0.5));
    material.slot_mut(Property::roughness).texture = Some(TextureRef::new("r.png"));
    let text = export(&[&material]).text;
    let changed =
        text.replace("float inputs:sheenOpacity = 0\n", "float inputs:sheenOpacity = 0.25\n").replace("r.png@", "s.png@");
    let scene = read(&changed);
    let found = &scene.materials[0].material;
    assert_eq!(scene.notes.len(), 2, "{:?}", scene.notes);
    assert_eq!(found.float(Property::sheen), 0.25);
    assert_eq!(found.slot(Property::roughness).texture.as_ref().map(|t| t.path.as_str()), Some("s.png"));
    assert_eq!(found.slot(Property::metallic).value, Some(Value::Float(0.5)));
    assert_eq!(found.slots().filter(|(_, slot)| slot.value.is_some()).count(), 2);
}

#[test]
fn a_dictionary_of_another_version_is_ignored() {
    let text = export(&[&filled("a", |_| 0.25)]).text.replace("version = \"4.0\"", "version = \"5.0\"");
    let scene = read(&text);
    assert!(!scene.materials[0].is_native && scene.notes.iter().any(|note| note.contains("version")), "{:?}", scene.notes);
    assert_eq!(scene.materials[0].material.float(Property::dispersion), 0.25);
}

#[test]
fn inputs_that_asm_does_not_know_are_kept_and_go_out_again() {
    let text = export(&[&filled("a", |_| 0.25)]).text;
    let more = "color3f inputs:glitter = (1, 0.5, 0)\n                float inputs:shininess = 3\n                ";
    let with = text.replacen("float inputs:dispersion", &format!("{more}float inputs:dispersion"), 1);
    assert_ne!(with, text);
    for (with, is_native) in [(with.clone(), true), (with.replace("version = \"4.0\"", "version = \"5.0\""), false)] {
        let scene = read(&with);
        let found = &scene.materials[0];
        assert_eq!(found.is_native, is_native);
        assert!(scene.notes.iter().any(|note| note.contains("glitter, shininess")), "{:?}", scene.notes);
        assert_eq!(found.material.foreign["usd"].len(), 2);
        let again = export(&[&found.material]).text;
        assert!(
            again.contains("color3f inputs:glitter = (1, 0.5, 0)") && again.contains("float inputs:shininess = 3"),
            "{again}"
        );
        assert_eq!(read(&again).materials[0].material, found.material);
    }
}

#[test]
fn foreign_entries_cannot_smuggle_lines_in() {
    let mut material = Material::named("a");
    let evil = "\"float 0.5 } def Shader \\\"x\\\" {\"".to_owned();
    let entries =
        [("UsdPreviewSurface.a".to_owned(), evil), ("UsdPreviewSurface.b\nfloat c".to_owned(), "\"float 1\"".to_owned())];
    material.foreign.entry("usd".to_owned()).or_default().extend(entries);
    let text = export(&[&material]).text;
    assert!(!text.contains("inputs:a =") && !text.contains("inputs:b\n"), "{text}");
    // A name that no file can hold is told on the way back; without it the material comes back.
    material.foreign.entry("usd".to_owned()).or_default().remove("UsdPreviewSurface.b\nfloat c");
    assert_comes_back(&[&material]);
}

#[test]
fn images_that_must_be_computed_are_planned() {
    let mut material = Material::named("two maps");
    for property in [Property::roughness, Property::anisotropy, Property::translucency, Property::opacity] {
        material.slot_mut(property).texture = Some(TextureRef::new(format!("{}.png", property.def().name)));
    }
    let export = export(&[&material]);
    let plan = |model: &str, name: &str| {
        let path = format!("textures/two_maps_{model}_{name}.png");
        let image = export.images.iter().find(|image| image.job.file == path).unwrap_or_else(|| panic!("{:?}", export.images));
        assert!(export.text.contains(&format!("@./{path}@")));
        (image.job.from.clone(), image.job.is_srgb, image.model.name)
    };
    let rough = vec![Property::roughness, Property::anisotropy];
    assert_eq!(plan("open_pbr_surface", "specular_roughness"), (rough, false, "open_pbr_surface"));
    let clear = vec![Property::opacity, Property::translucency];
    assert_eq!(plan("usd_preview_surface", "opacity"), (clear, false, "usd_preview_surface"));
    assert_comes_back(&[&material]);
}

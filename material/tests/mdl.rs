//! MDL: what is written comes back bit for bit, what others changed in it holds, and everything else is refused with a sentence.

use burnish_material::exchange::loss::Fate;
use burnish_material::exchange::mdl::{Flavour, Imported, MdlError, loss, read, write};
use burnish_material::{Kind, Material, PROPERTIES, Property, TextureRef, Value};
use proptest::prelude::*;

const FLAVOURS: [Flavour; 2] = [Flavour::Adobe, Flavour::Own];

fn text_of(material: &Material, flavour: Flavour) -> String {
    write(material, flavour, &|image| Some(image.path.clone()))
}

fn read_one(text: &str) -> Imported {
    let mut all = read(text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    assert_eq!(all.len(), 1);
    all.remove(0)
}

fn value(def: &'static burnish_material::PropertyDef) -> BoxedStrategy<Option<Value>> {
    let low = def.limits.min.unwrap_or(-1.0);
    let high = def.limits.max.unwrap_or(def.limits.slider_max);
    let number = || prop_oneof![Just(low), Just(high), low..=high, Just(1e-12), Just(1e12), Just(0.1 + 0.2)];
    let some = match def.default.kind() {
        Kind::Bool => any::<bool>().prop_map(Value::Bool).boxed(),
        Kind::Float => number().prop_map(Value::Float).boxed(),
        Kind::Color => [number(), number(), number()].prop_map(Value::Color).boxed(),
        Kind::Normal => Just(Value::Normal([0.1, 0.0, 0.9])).boxed(),
    };
    prop_oneof![1 => Just(None), 2 => some.prop_map(Some)].boxed()
}

fn material() -> impl Strategy<Value = Material> {
    let values: Vec<_> = PROPERTIES.iter().map(value).collect();
    let textured = proptest::collection::vec((0..PROPERTIES.len(), any::<bool>(), -2.0..2.0f64), 0..4);
    (values, textured, "\\PC{0,12}").prop_map(|(values, textured, name)| {
        let mut material = Material::named(name);
        material.notes = "says \"no\" to \\ and\nto */ [[ ]] ;".to_owned();
        for (def, value) in PROPERTIES.iter().zip(values) {
            material.slot_mut(def.id).value = value;
        }
        for (place, is_inverted, scale) in textured {
            let property = PROPERTIES[place].id;
            let image = TextureRef { is_inverted, scale: [scale; 3], ..TextureRef::new(format!("{}.png", property.def().name)) };
            material.slot_mut(property).texture = Some(image);
        }
        material
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn every_bit_comes_back(material in material()) {
        for flavour in FLAVOURS {
            let text = text_of(&material, flavour);
            let read = read_one(&text);
            prop_assert_eq!(&read.material, &material, "{}", text);
            prop_assert!(read.notes.is_empty(), "{:?}", read.notes);
            // Where an image has no file, its property has a value for others and the image for us.
            let text = write(&material, flavour, &|_| None);
            prop_assert_eq!(&read_one(&text).material, &material);
            prop_assert!(!text.contains("texture_2d(\""));
        }
    }

    #[test]
    fn a_call_says_the_values_without_the_native_copy(material in material()) {
        let mut plain = Material::named(material.name.clone());
        for (property, slot) in material.slots().filter(|(p, slot)| slot.texture.is_none() && p.def().default.kind() != Kind::Normal) {
            plain.slot_mut(property).value = slot.value;
        }
        let text: String = text_of(&plain, Flavour::Adobe).lines().filter(|line| !line.contains("asm_native")).collect::<Vec<_>>().join("\n");
        let read = read_one(&text);
        for (property, slot) in plain.slots() {
            prop_assert_eq!(slot, read.material.slot(property), "{}", property.def().name);
        }
    }

    #[test]
    fn cut_and_spoilt_modules_are_read_or_refused(material in material(), at in 0..100_000_usize, byte in any::<char>()) {
        let text = text_of(&material, Flavour::Own);
        let place = text.char_indices().map(|(at, _)| at).nth(at % text.chars().count()).unwrap_or(0);
        let length = text[place..].chars().next().map_or(0, char::len_utf8);
        _ = read(&text[..place]);
        if let Err(error) = read(&format!("{}{byte}{}", &text[..place], &text[place + length..])) {
            prop_assert!(!error.to_string().contains('\n'));
        }
    }
}

#[test]
fn default_and_extreme_materials_come_back() {
    for flavour in FLAVOURS {
        let plain = Material::default();
        assert_eq!(read_one(&text_of(&plain, flavour)).material, plain);
        for pick in [|low: f64, _: f64| low, |_: f64, high: f64| high] {
            let mut material = Material::named("extreme");
            for def in PROPERTIES {
                let x = pick(def.limits.min.unwrap_or(-1e300), def.limits.max.unwrap_or(f64::MAX));
                material.set(
                    def.id,
                    match def.default.kind() {
                        Kind::Color => Value::Color([x; 3]),
                        Kind::Normal => Value::Normal([x; 3]),
                        Kind::Float => Value::Float(x),
                        Kind::Bool => Value::Bool(x > 0.0),
                    },
                );
            }
            assert_eq!(read_one(&text_of(&material, flavour)).material, material);
        }
    }
}

#[test]
fn numbers_that_are_none_are_never_written() {
    let mut material = Material::named("odd");
    material.set(Property::roughness, Value::Float(f64::NAN));
    material.set(Property::base_color, Value::Color([f64::INFINITY, 0.0, 0.0]));
    let mut image = TextureRef::new("a.png");
    (image.scale, image.uv_rotation) = ([f64::NAN; 3], f64::INFINITY);
    material.slot_mut(Property::metallic).texture = Some(image);
    for flavour in FLAVOURS {
        let text = text_of(&material, flavour);
        assert!(!text.contains("NaN") && !text.contains("inf,") && !text.contains("inf)"), "{text}");
        assert!(!text.contains("roughness: ") || flavour == Flavour::Own);
    }
}

#[test]
fn what_was_changed_in_the_call_holds() {
    let mut material = Material::named("Red paint");
    material.set(Property::roughness, Value::Float(0.25)).set(Property::coat, Value::Float(1.0));
    material.slot_mut(Property::base_color).texture = Some(TextureRef::new("red.png"));
    let text = text_of(&material, Flavour::Own);
    let changed = text.replace("    roughness: 0.25,", "    roughness: 0.5f,").replace(",\n    coat: 1.0", ",\n    metallic: 1");
    assert_ne!(text, changed);
    let read = read_one(&changed);
    assert_eq!(read.material.float(Property::roughness), 0.5);
    assert_eq!(read.material.float(Property::metallic), 1.0);
    assert_eq!(read.material.slot(Property::coat).value, None);
    assert_eq!(read.material.slot(Property::base_color), material.slot(Property::base_color));
    assert_eq!(read.notes.len(), 3, "{:?}", read.notes);
}

#[test]
fn calls_of_adobes_material_are_read() {
    let text = "mdl 1.8; /* by hand */\nimport ::adobe::materials::standard;\nexport material A(*) = ::adobe::materials::standard(\n  \
        base_color: color(.5, 1e-1f, 0.25), // a comment, with (\n  roughness: 0.5, scatter: true, emission: 2, dispersion: 1.5d, velvet: 3);\n\
        export material B(*) [[ anno::author(\"me ]] (\") ]] = ::adobe::materials::standard(coat_color: color(0.5));";
    let all = read(text).expect("two materials");
    assert_eq!(all.len(), 2);
    let a = &all[0].material;
    assert_eq!((a.name.as_str(), a.color(Property::base_color), a.float(Property::emission)), ("A", [0.5, 0.1, 0.25], 2.0));
    assert!(a.switch(Property::scatter) && a.float(Property::dispersion) == 1.5);
    assert_eq!(all[0].notes.len(), 1, "{:?}", all[0].notes);
    assert_eq!(all[1].material.color(Property::coat_color), [0.5; 3]);
}

#[test]
fn everything_else_is_refused_with_a_sentence() {
    let head = "mdl 1.7;\nexport material A";
    for (text, expected) in [
        ("".to_owned(), "begins with `mdl`"),
        ("<materialx/>".to_owned(), "begins with `mdl`"),
        ("mdl 1.7; import ::df::*;".to_owned(), "found none"),
        ("mdl 1.7; export float f() { return 1.0; }".to_owned(), "found none"),
        (format!("{head}(*) = OmniPBR(roughness: 0.5);"), "`A`: expected a call of `::adobe::materials::standard`"),
        (format!("{head}(*) = material(surface: material_surface());"), "found `material`"),
        (format!("{head}(float r = 0.5) = ::adobe::materials::standard(roughness: r);"), "parameters of its own"),
        (format!("{head}(*) = ::adobe::materials::standard(roughness: 0.5 * 2.0);"), "`A`: roughness: expected"),
        (format!("{head}(*) = ::adobe::materials::standard(base_color: color(1, 2));"), "base_color"),
        (format!("{head}(*) = ::adobe::materials::standard(roughness: 1e999);"), "roughness"),
        (format!("{head}(*) = ::adobe::materials::standard(0.5);"), "name: value"),
        (format!("{head}(*) = ::adobe::materials::standard(roughness: 0.5"), "line 2: expected a closing bracket"),
        (format!("{head}(*) = ::adobe::materials::standard{}", "(".repeat(100_000)), "closing bracket"),
        (format!("{head}(*) [[ asm_native(\"{{}}\") ]] = x();"), "found `x`"),
    ] {
        let error = read(&text).expect_err(&text).to_string();
        assert!(error.contains(expected) && !error.contains('\n'), "{error}");
    }
    assert_eq!(read(&" ".repeat((16 << 20) + 1)), Err(MdlError::TooLarge((16 << 20) + 1)));
    // A copy that cannot be read leaves the call to decide.
    let text = format!("{head}(*) [[ asm_native(\"no JSON\") ]] = ::adobe::materials::standard(roughness: 0.5);");
    let read = read_one(&text);
    assert_eq!((read.material.float(Property::roughness), read.notes.len()), (0.5, 1));
}

#[test]
fn the_module_holds_what_its_call_needs() {
    let mut material = Material::named("brushed steel");
    material.slot_mut(Property::normal).texture = Some(TextureRef { is_inverted: true, ..TextureRef::new("maps/n.png") });
    material.set(Property::normal_scale, Value::Float(0.5));
    let own = text_of(&material, Flavour::Own);
    assert!(own.contains("export material brushed_steel(*)") && own.contains("material adobe_standard_material("));
    assert!(own.contains("texture_2d(\"./maps/n.png\", ::tex::gamma_linear)") && own.contains(", -1.0, 0.5)"));
    // Every property is a parameter of the material that comes along.
    for def in PROPERTIES {
        assert!(own.contains(&format!(" {} = ", def.name)), "{}", def.name);
    }
    let adobe = text_of(&material, Flavour::Adobe);
    assert!(
        adobe.contains("= ::adobe::materials::standard(")
            && !adobe.contains("adobe_standard_material")
            && adobe.contains(", -1.0, 1.0)")
    );
    let plain = text_of(&Material::default(), Flavour::Adobe);
    assert!(plain.contains("export material asm_material(*)") && !plain.contains("asm_normal"));
    for flavour in FLAVOURS {
        let rows = loss(&material, flavour);
        assert_eq!(rows.len(), PROPERTIES.len());
        let lost = rows.iter().filter(|row| row.fate > Fate::Remapped).count();
        assert_eq!(lost, if flavour == Flavour::Adobe { 0 } else { 2 }, "{rows:?}");
    }
}

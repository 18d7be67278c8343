//! Texture sets: which files a material becomes, and what is in them.

use burnish_material::exchange::model::Context;
use burnish_material::exchange::texture_set::copy::{self, NativeSet, Placed};
use burnish_material::exchange::texture_set::{self, Flavour, Options, TextureSet};
use burnish_material::{Channel, Material, Property, TextureRef, Value};

fn material() -> Material {
    let mut material = Material::named("Old Wood");
    let image = |path: &str| Some(TextureRef::new(path));
    material.slot_mut(Property::base_color).texture = image("maps/wood.JPG");
    material.slot_mut(Property::normal).texture = image("maps/n.png");
    material.slot_mut(Property::roughness).texture = Some(TextureRef { channel: Channel::G, ..TextureRef::new("maps/orm.png") });
    material.slot_mut(Property::height).texture = Some(TextureRef { uv_scale: [2.0; 2], ..TextureRef::new("maps/h.png") });
    material.set(Property::metallic, Value::Float(0.25));
    material.set(Property::coat_ior, Value::Float(1.7));
    material
}

fn plan(material: &Material, options: Options) -> TextureSet {
    let last = |path: &str| path.rsplit('/').next().unwrap_or_default().to_owned();
    texture_set::plan(material, "Old_Wood", &last, options)
}

fn copies(set: &TextureSet) -> Vec<(&str, &str)> {
    set.copies.iter().map(|copy| (copy.path.as_str(), copy.file.as_str())).collect()
}

fn files(set: &TextureSet) -> Vec<&str> {
    set.images.iter().map(|image| image.job.file.as_str()).collect()
}

#[test]
fn plain_images_are_copied_and_others_computed() {
    let set = plan(&material(), Options::default());
    assert_eq!(set.native_file, "Old_Wood.textures.json");
    assert_eq!(copies(&set), [("maps/wood.JPG", "Old_Wood_BaseColor.jpg"), ("maps/n.png", "Old_Wood_Normal.png")]);
    assert_eq!(files(&set), ["Old_Wood_Roughness.png", "Old_Wood_Height.png"]);
    let originals: Vec<&str> = set.originals.iter().map(|copy| copy.file.as_str()).collect();
    assert_eq!(originals, ["Old_Wood_originals/orm.png", "Old_Wood_originals/h.png"]);
    assert!(set.images[0].job.is_in_place && !set.images[1].job.is_in_place);
    assert_eq!(set.notes.len(), 1, "{:?}", set.notes);
    let texel = {
        let mut inputs = material().inputs();
        inputs.roughness = 0.625;
        set.images[0].job.texel(set.images[0].model, &inputs, &Context::of(&material()))
    };
    assert_eq!(texel, [0.625, 0.625, 0.625, 1.0]);
}

#[test]
fn uniform_values_become_images_only_when_asked() {
    let set = plan(&material(), Options { has_uniform: true, ..Options::default() });
    assert_eq!(files(&set), ["Old_Wood_Roughness.png", "Old_Wood_Metallic.png", "Old_Wood_Height.png"]);
    let metallic = &set.images[1];
    assert!(metallic.job.from.is_empty() && !metallic.job.is_srgb);
    assert_eq!(metallic.job.texel(metallic.model, &material().inputs(), &Context::of(&material()))[0], 0.25);
}

#[test]
fn specular_and_glossiness_stand_for_metal_and_roughness() {
    let mut material = material();
    let options = Options { flavour: Flavour::SpecularGlossiness, has_uniform: false };
    let set = plan(&material, options);
    // Some metal makes the specular colour follow the base colour.
    assert_eq!(files(&set), ["Old_Wood_Diffuse.png", "Old_Wood_Specular.png", "Old_Wood_Glossiness.png", "Old_Wood_Height.png"]);
    assert_eq!(copies(&set), [("maps/n.png", "Old_Wood_Normal.png")]);
    let glossiness = &set.images[2];
    let mut inputs = material.inputs();
    inputs.roughness = 0.75;
    assert_eq!(glossiness.job.texel(glossiness.model, &inputs, &Context::of(&material))[0], 0.25);
    material.set(Property::metallic, Value::Float(0.0));
    let set = plan(&material, options);
    assert_eq!(copies(&set)[0], ("maps/wood.JPG", "Old_Wood_Diffuse.jpg"));
    assert_eq!(files(&set), ["Old_Wood_Glossiness.png", "Old_Wood_Height.png"]);
}

#[test]
fn what_images_cannot_hold_is_told() {
    let mut material = Material::named("a");
    material.slot_mut(Property::emission_color).texture = Some(TextureRef { scale: [4.0; 3], ..TextureRef::new("e.png") });
    let set = plan(&material, Options::default());
    assert!(set.notes[0].contains("emissive") && set.notes[0].contains("e.png"), "{:?}", set.notes);
}

#[test]
fn images_that_others_changed_hold_one_by_one() {
    let set = plan(&material(), Options::default());
    let material = set.placed(&material());
    assert_eq!(material.slot(Property::roughness).texture.as_ref().map(|t| t.path.as_str()), Some("Old_Wood_originals/orm.png"));
    let images: std::collections::BTreeMap<_, _> =
        ["Old_Wood_BaseColor.jpg", "Old_Wood_Normal.png", "Old_Wood_Roughness.png", "Old_Wood_Height.png"]
            .map(|file| (file.to_owned(), format!("print of {file}")))
            .into();
    let read = || copy::read(&copy::write(&material, &images)).expect("our own text");
    let placed =
        |property: Property, file: &str| Placed { property, file: file.to_owned(), channel: Channel::Rgb, is_inverted: false };
    let mut found = vec![
        placed(Property::base_color, "Old_Wood_BaseColor.jpg"),
        placed(Property::normal, "Old_Wood_Normal.png"),
        placed(Property::roughness, "Old_Wood_Roughness.png"),
        placed(Property::height, "Old_Wood_Height.png"),
    ];
    let same = |file: &str| Some(format!("print of {file}"));
    assert_eq!(copy::merge(Some(read()), &found, &same), (material.clone(), Vec::new()));
    // One is painted over, one is gone, one is new.
    found.push(placed(Property::coat, "Old_Wood_CoatOpacity.png"));
    let now = |file: &str| match file {
        "Old_Wood_Roughness.png" => Some("another".to_owned()),
        "Old_Wood_Height.png" => None,
        file => same(file),
    };
    let (merged, notes) = copy::merge(Some(read()), &found, &now);
    assert_eq!(notes.len(), 3, "{notes:?}");
    for def in burnish_material::PROPERTIES {
        let path = merged.slot(def.id).texture.as_ref().map(|texture| texture.path.as_str());
        match def.id {
            Property::roughness => assert_eq!(path, Some("Old_Wood_Roughness.png")),
            Property::coat => assert_eq!(path, Some("Old_Wood_CoatOpacity.png")),
            other => assert_eq!(merged.slot(other), material.slot(other)),
        }
    }
    let (alone, _) = copy::merge(None, &found, &same);
    assert_eq!(alone.slots().filter(|(_, slot)| slot.texture.is_some()).count(), 5);
}

#[test]
fn what_is_no_native_copy_is_refused_with_a_reason() {
    let refused = |text: &str| copy::read(text).map(|NativeSet { .. }| ()).expect_err(text).to_string();
    assert!(refused("{").contains("JSON"));
    assert!(refused("{}").contains("found none"));
    assert!(refused("{\"material\": {\"version\": \"3.0\", \"properties\": {}}}").contains("3.0"));
    assert!(refused(&" ".repeat(copy::MAX_BYTES + 1)).contains("at most"));
}

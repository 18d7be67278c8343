//! Which images a document uses as they are, and which have to be computed.

use burnish_material::exchange::gltf::{Facts, Options, Written};
use burnish_material::exchange::model::Context;
use burnish_material::exchange::models::gltf::MODEL;
use burnish_material::exchange::plan::{Job, Texel};
use burnish_material::{Channel, ColorSpace, Material, Property, TextureRef, Value, Wrap};
use serde_json::{Value as Json, json};

use super::{bare, opened, parsed, written};

fn texture(path: &str, channel: Channel) -> TextureRef {
    TextureRef { channel, ..TextureRef::new(path) }
}

fn material(textures: &[(Property, TextureRef)]) -> Material {
    let mut material = Material::named("M");
    for (property, texture) in textures {
        material.slot_mut(*property).texture = Some(texture.clone());
    }
    material
}

fn core(written: &Written) -> Json {
    parsed(written)["materials"][0]["pbrMetallicRoughness"].clone()
}

fn only_job(written: &Written) -> &Job {
    let [job] = written.plan.jobs.as_slice() else { panic!("expected one job: {:?}", written.plan) };
    job
}

/// What a job stores where these properties have these values, and all others those of the material.
fn texel(job: &Job, material: &Material, values: &[(Property, Value)]) -> [f64; 4] {
    let mut inputs = material.inputs();
    for (property, value) in values {
        inputs.set(*property, *value);
    }
    job.texel(&MODEL, &inputs, &Context::of(material))
}

#[test]
fn one_packed_image_serves_all_its_parameters() {
    let written = written(
        &material(&[
            (Property::ambient_occlusion, texture("orm.png", Channel::R)),
            (Property::roughness, texture("orm.png", Channel::G)),
            (Property::metallic, texture("orm.png", Channel::B)),
            (Property::base_color, TextureRef { scale: [0.5, 1.0, 0.25], ..TextureRef::new("color.jpg") }),
        ]),
        None,
        &bare(),
    );
    assert!(written.plan.jobs.is_empty(), "{:?}", written.plan.jobs);
    assert!(written.plan.copies.iter().all(|copy| copy.is_used && copy.path == copy.file));
    let json = parsed(&written);
    assert_eq!(json["images"], json!([{ "uri": "color.jpg" }, { "uri": "orm.png" }]));
    assert_eq!(core(&written)["baseColorFactor"], json!([0.5, 1.0, 0.25, 1.0]));
    assert_eq!(core(&written)["roughnessFactor"], json!(1.0));
    assert_eq!(json["materials"][0]["occlusionTexture"], json!({ "index": 1 }));
}

#[test]
fn images_of_their_own_are_packed_into_one() {
    let mut material = material(&[
        (Property::ambient_occlusion, texture("ao.png", Channel::Rgb)),
        (Property::roughness, TextureRef { scale: [0.5; 3], ..texture("rough.png", Channel::R) }),
        (Property::metallic, texture("metal.png", Channel::A)),
    ]);
    let packed = written(&material, None, &bare());
    let job = only_job(&packed);
    assert_eq!((job.file.as_str(), job.is_in_place, job.is_srgb), ("textures/M_orm.png", true, false));
    let values = [
        (Property::ambient_occlusion, Value::Float(0.25)),
        (Property::roughness, Value::Float(0.4)),
        (Property::metallic, Value::Float(0.75)),
    ];
    assert_eq!(texel(job, &material, &values), [0.25, 0.8, 0.75, 1.0]);
    assert_eq!(core(&packed)["roughnessFactor"], json!(0.5));
    // Another place on the surface: two images, and of those in one slot one without the transforms.
    material.slot_mut(Property::metallic).texture.as_mut().expect("just put there").uv_scale = [2.0; 2];
    let apart = written(&material, None, &bare());
    let places: Vec<_> = apart.plan.jobs.iter().map(|job| (job.file.as_str(), job.is_in_place)).collect();
    assert_eq!(places, [("textures/M_metallic_roughness.png", false), ("textures/M_occlusion.png", true)]);
    assert_eq!(apart.plan.notes.len(), 1);
}

#[test]
fn an_unused_channel_changes_nothing() {
    let rough = material(&[(Property::roughness, texture("rough.png", Channel::G))]);
    // Without metal, what is blue does not matter.
    assert!(written(&rough, None, &bare()).plan.jobs.is_empty());
    let mut metal = rough.clone();
    metal.set(Property::metallic, Value::Float(0.5));
    let written = written(&metal, None, &bare());
    let job = only_job(&written);
    assert_eq!(job.channels[0], Texel::ONE);
    assert_eq!(job.channels[2], Texel::ONE);
    assert_eq!(core(&written)["metallicFactor"], json!(0.5));
}

#[test]
fn what_a_place_cannot_say_is_computed() {
    let direct = texture("rough.png", Channel::G);
    let cases = [
        ("as it is", direct.clone(), true),
        ("scaled", TextureRef { scale: [0.5; 3], ..direct.clone() }, true),
        ("mirrored", TextureRef { wrap: Wrap::Mirror, ..direct.clone() }, true),
        ("scaled beyond 1", TextureRef { scale: [1.5; 3], ..direct.clone() }, false),
        ("negative", TextureRef { scale: [-1.0; 3], ..direct.clone() }, false),
        ("shifted", TextureRef { bias: [0.1; 3], ..direct.clone() }, false),
        ("inverted", TextureRef { is_inverted: true, ..direct.clone() }, false),
        ("of sRGB", TextureRef { color_space: ColorSpace::Srgb, ..direct.clone() }, false),
        ("of another channel", texture("rough.png", Channel::R), false),
        ("of another format", TextureRef { path: "rough.exr".to_owned(), ..direct }, false),
    ];
    for (name, texture, is_direct) in cases {
        let material = material(&[(Property::roughness, texture)]);
        let written = written(&material, None, &bare());
        assert_eq!(written.plan.jobs.is_empty(), is_direct, "{name}");
        let [found] = opened(written.gltf("").as_bytes()).materials.try_into().expect("one material");
        let image = found.material().0.slot(Property::roughness).texture.clone().expect("an image");
        assert_eq!(image.path, if is_direct { "rough.png" } else { "textures/M_metallic_roughness.png" }, "{name}");
    }
}

#[test]
fn what_is_known_of_an_image_saves_computing() {
    let material = material(&[
        (Property::roughness, texture("gray.png", Channel::Rgb)),
        (Property::base_color, TextureRef::new("color.png")),
    ]);
    let mut options = bare();
    assert_eq!(written(&material, None, &options).plan.jobs.len(), 1);
    options.facts.insert("gray.png".to_owned(), Facts { is_gray: true, ..Facts::default() });
    assert!(written(&material, None, &options).plan.jobs.is_empty());
    options.facts.insert("color.png".to_owned(), Facts { is_wide: true, ..Facts::default() });
    let written = written(&material, None, &options);
    assert!(only_job(&written).is_srgb);
}

#[test]
fn colour_and_opacity_share_an_image() {
    let mut material =
        material(&[(Property::base_color, TextureRef::new("color.png")), (Property::opacity, texture("cutout.png", Channel::R))]);
    let both = written(&material, None, &bare());
    let job = only_job(&both);
    let values = [(Property::base_color, Value::Color([0.1, 0.2, 0.3])), (Property::opacity, Value::Float(0.4))];
    assert_eq!(texel(job, &material, &values), [0.1, 0.2, 0.3, 0.4]);
    assert_eq!(parsed(&both)["materials"][0]["alphaMode"], "BLEND");
    // An image that may have alpha must not add to a uniform opacity; one without alpha cannot.
    material.slot_mut(Property::opacity).texture = None;
    material.set(Property::opacity, Value::Float(0.5));
    assert_eq!(written(&material, None, &bare()).plan.jobs.len(), 1);
    material.slot_mut(Property::base_color).texture = Some(TextureRef::new("color.jpg"));
    assert!(written(&material, None, &bare()).plan.jobs.is_empty());
}

#[test]
fn levels_coats_and_directions_are_packed() {
    let mut material = material(&[
        (Property::specular_level, texture("level.png", Channel::R)),
        (Property::coat, texture("coat.png", Channel::G)),
        (Property::coat_roughness, texture("coat.png", Channel::B)),
        (Property::coat_specular_level, texture("coat.png", Channel::R)),
        (Property::anisotropy, texture("brush.png", Channel::R)),
        (Property::anisotropy_rotation, texture("brush.png", Channel::G)),
    ]);
    material.set(Property::roughness, Value::Float(0.3));
    let written = written(&material, None, &bare());
    let named = |suffix: &str| {
        let file = format!("textures/M_{suffix}.png");
        written.plan.jobs.iter().find(|job| job.file == file).unwrap_or_else(|| panic!("{file}: {:?}", written.plan.jobs))
    };
    let (specular, coat, brush) = (named("specular"), named("coat"), named("anisotropy"));
    assert_eq!(written.plan.jobs.len(), 3);
    assert!(specular.is_srgb && !coat.is_srgb);
    // A level of 0.8: 1.6 times the colour, which a factor of 2 stands beside.
    assert_eq!(texel(specular, &material, &[(Property::specular_level, Value::Float(0.8))]), [0.8, 0.8, 0.8, 1.0]);
    assert_eq!(texel(specular, &material, &[(Property::specular_level, Value::Float(0.25))]), [0.5, 0.5, 0.5, 0.5]);
    let values = [(Property::coat, 0.1), (Property::coat_roughness, 0.2), (Property::coat_specular_level, 0.25)];
    let values = values.map(|(property, value)| (property, Value::Float(value)));
    assert_eq!(texel(coat, &material, &values), [0.1, 0.2, 0.5, 1.0]);
    let values = [(Property::anisotropy, Value::Float(0.5)), (Property::anisotropy_rotation, Value::Float(0.25))];
    let [cosine, sine, strength, _] = texel(brush, &material, &values);
    assert!((cosine - 0.5).abs() < 1e-9 && (sine - 1.0).abs() < 1e-9 && (strength - 0.2620712).abs() < 1e-6);
}

#[test]
fn uniform_values_without_a_factor_are_one_texel() {
    let mut material = Material::named("M");
    material.set(Property::ambient_occlusion, Value::Float(0.25));
    let written = written(&material, None, &bare());
    let job = only_job(&written);
    assert!(job.from.is_empty());
    assert_eq!(texel(job, &material, &[]), [0.25, 1.0, 1.0, 1.0]);
}

#[test]
fn files_from_elsewhere_get_a_place_beside_the_document() {
    let material = material(&[
        (Property::base_color, TextureRef::new("/home/me/a b.png")),
        (Property::normal, TextureRef::new("../a_b.png")),
        (Property::emission_color, TextureRef::new("textures/a_b.png")),
        (Property::coat_normal, TextureRef::new("builtin:wood-oak/normal?contrast=0.5")),
    ]);
    let written = written(&material, None, &Options::default());
    let files: Vec<_> = written.plan.copies.iter().map(|copy| (copy.path.as_str(), copy.file.as_str())).collect();
    assert_eq!(
        files,
        [
            ("textures/a_b.png", "textures/a_b.png"),
            ("../a_b.png", "textures/a_b_2.png"),
            ("/home/me/a b.png", "textures/a_b_3.png"),
            ("builtin:wood-oak/normal?contrast=0.5", "textures/wood-oak_normal_contrast_0_5.png"),
        ]
    );
    assert!(!written.gltf("").contains("/home"));
}

#[test]
fn an_emitting_image_leaves_the_strength_alone() {
    let mut material = material(&[(Property::emission_color, TextureRef { scale: [4.0, 2.0, 1.0], ..TextureRef::new("e.png") })]);
    material.set(Property::emission, Value::Float(3.0)).set(Property::emission_color, Value::Color([9.0; 3]));
    let written = written(&material, None, &bare());
    assert!(written.plan.jobs.is_empty());
    let json = parsed(&written);
    assert_eq!(json["materials"][0]["emissiveFactor"], json!([1.0, 0.5, 0.25]));
    assert_eq!(json["materials"][0]["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"], json!(12.0));
}

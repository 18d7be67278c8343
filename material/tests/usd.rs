//! USD: what is exported comes back bit for bit, and what others write is understood.

use burnish_material::exchange::usd::{self, Export, MeshArrays, Options, Scene, usdz};
use burnish_material::{Channel, ColorSpace, Kind, Material, MaterialFile, PROPERTIES, Property, TextureRef, Value, Vary, Wrap};

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
    let mut texture = TextureRef::new(format!("maps/bild {}@ä.png", random.below(5)));
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
        material.notes = "line one\nline \"two\" \\ \t§ \u{1}".to_owned();
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

fn export(materials: &[&Material]) -> Export {
    usd::write(materials, &Options { path_of: &|texture| texture.path.clone(), image_folder: "textures/", mesh: None })
}

fn read(text: &str) -> Scene {
    usd::read(text).unwrap_or_else(|error| panic!("{error}\n{text}"))
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
    let options = Options { path_of: &|_| "textures/roughness.png".to_owned(), image_folder: "", mesh: None };
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

/// As Adobe's writers do it: inputs promoted to the material, a node graph around the shader, other types and case.
#[test]
fn promoted_inputs_and_node_graphs_are_followed() {
    let text = r#"#usda 1.0
def Scope "Looks" {
    def Material "Wood" ( displayName = "Old wood" ) {
        float3 inputs:baseColor = (0.25, 0.5, 0.75) ( customData = { dictionary range = { double max = 1 } } )
        asset inputs:file = @./a/rough.png@ ( colorSpace = "raw" )
        half inputs:coat_amount = 0.5
        token outputs:adobe:surface.connect = </Looks/Wood/Graph.outputs:surface>
        def NodeGraph "Graph" {
            token outputs:surface.connect = <../Graph/ASM.outputs:surface>
            float outputs:coat.connect = </Looks/Wood.inputs:coat_amount>
            def Shader "ASM" {
                uniform token info:id = "AdobeStandardMaterial_4_0"
                color3f inputs:baseColor.connect = </Looks/Wood.inputs:baseColor>
                float inputs:ROUGHNESS.connect = </Looks/Wood/Graph/Rough.outputs:g>
                float inputs:ior = 1.25
                double inputs:coatIOR = 1.3000000000000003
                float inputs:coatOpacity.connect = </Looks/Wood/Graph.outputs:coat>
                int inputs:scatter = 1
                token outputs:surface
            }
            def Shader "Rough" {
                uniform token info:id = "UsdUVTexture"
                asset inputs:file.connect = </Looks/Wood.inputs:file>
                token inputs:wrapS = "mirror"
                token inputs:wrapT = "mirror"
                float4 inputs:scale = (1, 0.5, 1, 1)
                float4 inputs:bias = (0, 0.25, 0, 0)
                float outputs:g
            }
        }
    }
}
"#;
    let scene = read(text);
    assert!(scene.notes.is_empty(), "{:?}", scene.notes);
    let found = &scene.materials[0].material;
    assert_eq!(found.name, "Old wood");
    assert_eq!(found.unit_mm, Some(10.0));
    assert_eq!(found.color(Property::base_color), [0.25, 0.5, 0.75]);
    assert_eq!((found.float(Property::specular_ior), found.float(Property::coat_ior)), (1.25, 1.3000000000000003));
    assert_eq!((found.float(Property::coat), found.switch(Property::scatter)), (0.5, true));
    let expected = TextureRef {
        channel: Channel::G,
        wrap: Wrap::Mirror,
        scale: [0.5; 3],
        bias: [0.25; 3],
        ..TextureRef::new("a/rough.png")
    };
    assert_eq!(found.slot(Property::roughness).texture, Some(expected));
}

fn material_with(surface: &str, rest: &str) -> String {
    format!(
        "#usda 1.0\n(\nmetersPerUnit = 0.1\n)\ndef Material \"M\" {{\ntoken outputs:surface.connect = </M/S.outputs:surface>\n\
         def Shader \"S\" {{\n{surface}\ntoken outputs:surface\n}}\n{rest}\n}}\n"
    )
}

fn only(text: &str) -> (Material, Vec<String>) {
    let mut scene = read(text);
    (scene.materials.remove(0).material, scene.notes)
}

#[test]
fn preview_surfaces_of_others_are_understood() {
    let image = |name: &str, scale: &str, more: &str| {
        format!(
            "def Shader \"{name}\" {{ uniform token info:id = \"UsdUVTexture\"; asset inputs:file = @{name}.png@; {scale} {more} float3 outputs:rgb }}"
        )
    };
    let directx = "float4 inputs:scale = (3, -3, 2, 1); float4 inputs:bias = (-1.5, 1.5, -1, 0);";
    let placed =
        "token inputs:wrapS = \"clamp\"; token inputs:wrapT = \"clamp\"; float2 inputs:st.connect = </M/T.outputs:result>";
    let transform = "def Shader \"T\" { uniform token info:id = \"UsdTransform2d\"; float inputs:rotation = 30; \
                     float2 inputs:scale = (2, 3); float2 inputs:translation = (0.1, 0.2); float2 outputs:result }";
    let surface = "uniform token info:id = \"UsdPreviewSurface\"; color3f inputs:diffuseColor = (0.2, 0.4, 0.6); float inputs:clearcoat = 1; \
                   normal3f inputs:normal.connect = </M/N.outputs:rgb>; color3f inputs:emissiveColor.connect = </M/E.outputs:rgb>; \
                   float inputs:metallic.connect = </M/E.outputs:b>; float inputs:fancy = 0.5";
    let (found, notes) =
        only(&material_with(surface, &[image("N", directx, ""), image("E", "", placed), transform.to_owned()].concat()));
    assert_eq!(notes.len(), 1, "{notes:?}");
    assert_eq!(found.unit_mm, None);
    assert_eq!(found.color(Property::base_color), [0.2, 0.4, 0.6]);
    assert_eq!((found.float(Property::roughness), found.float(Property::coat_ior)), (0.5, 1.5));
    let normal = found.slot(Property::normal).texture.as_ref().expect("a normal map");
    assert!(normal.is_inverted && found.float(Property::normal_scale) == 1.5);
    let emission = found.slot(Property::emission_color).texture.as_ref().expect("an image");
    assert_eq!((emission.uv_scale, emission.uv_offset, emission.uv_rotation), ([2.0, 3.0], [0.1, 0.2], 30.0));
    assert_eq!((emission.wrap, emission.channel, found.float(Property::emission)), (Wrap::Clamp, Channel::Rgb, 1.0));
    assert_eq!(found.slot(Property::metallic).texture.as_ref().map(|t| t.channel), Some(Channel::B));
    // What has no place goes back out.
    let text = export(&[&found]).text;
    assert!(text.contains("float inputs:fancy = 0.5"), "{text}");
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
    assert_comes_back(&[&material]);
}

#[test]
fn specular_workflows_become_levels() {
    let spec = |f0: &str| {
        let surface =
            "uniform token info:id = \"UsdPreviewSurface\"; int inputs:useSpecularWorkflow = 1; float inputs:metallic = 1;";
        only(&material_with(&format!("{surface} color3f inputs:specularColor = {f0}"), "")).0
    };
    let dielectric = spec("(0.04, 0.04, 0.02)");
    assert_eq!((dielectric.float(Property::specular_level), dielectric.float(Property::metallic)), (0.5, 0.0));
    assert_eq!(dielectric.color(Property::specular_edge_color), [1.0, 1.0, 0.5]);
    let metal = spec("(0.25, 0.25, 0.25)");
    assert!((metal.float(Property::specular_ior) - 3.0).abs() < 1e-6);
}

/// Without the native shader, OpenPBR counts before the preview; its images come back through MaterialX's nodes.
#[test]
fn open_pbr_comes_back_through_its_nodes() {
    let mut material = Material::named("a");
    let texture = TextureRef {
        uv_scale: [2.0, 4.0],
        uv_offset: [0.25, 0.5],
        uv_rotation: 30.0,
        wrap: Wrap::Mirror,
        color_space: ColorSpace::Srgb,
        ..TextureRef::new("c.png")
    };
    let linear = TextureRef { color_space: ColorSpace::Linear, ..texture.clone() };
    let scalar = TextureRef { channel: Channel::G, scale: [0.5; 3], bias: [0.25; 3], ..linear.clone() };
    material.slot_mut(Property::base_color).texture = Some(texture);
    material.slot_mut(Property::coat).texture = Some(scalar);
    material.slot_mut(Property::normal).texture = Some(TextureRef { is_inverted: true, ..linear });
    material.set(Property::normal_scale, Value::Float(1.5)).set(Property::anisotropy_rotation, Value::Float(0.25));
    material.set(Property::anisotropy, Value::Float(0.5)).set(Property::roughness, Value::Float(0.3));
    material.set(Property::height_scale, Value::Float(0.125)).set(Property::height, Value::Float(0.75));
    let text = export(&[&material])
        .text
        .replace("outputs:adobe:surface", "outputs:other:surface")
        .replace("AdobeStandardMaterial_4_0", "X");
    // Vectors of section 5.1 of the mapping.
    assert!(text.contains("specular_roughness = 0.35385") && text.contains("specular_roughness_anisotropy = 0.40983"), "{text}");
    let scene = read(&text);
    assert_eq!(scene.materials[0].network, "ND_open_pbr_surface_surfaceshader");
    let found = &scene.materials[0].material;
    for property in [Property::base_color, Property::coat, Property::normal] {
        let (a, b) = (found.slot(property).texture.as_ref(), material.slot(property).texture.as_ref());
        let (a, b) = (a.expect("an image"), b.expect("an image"));
        if property != Property::normal {
            assert_eq!((a.scale, a.bias), (b.scale, b.bias), "{property:?}");
        }
        assert_eq!((&a.path, a.channel, a.color_space, a.wrap), (&b.path, b.channel, b.color_space, b.wrap), "{property:?}");
        assert_eq!(
            (a.uv_scale, a.uv_offset, a.uv_rotation, a.is_inverted),
            (b.uv_scale, b.uv_offset, b.uv_rotation, b.is_inverted)
        );
    }
    for property in
        [Property::normal_scale, Property::anisotropy_rotation, Property::anisotropy, Property::roughness, Property::height_scale]
    {
        assert!((found.float(property) - material.float(property)).abs() < 1e-5, "{property:?}: {}", found.float(property));
    }
    assert!((found.float(Property::height) - 0.75).abs() < 1e-6);
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
        let image = export.images.iter().find(|image| image.path == path).unwrap_or_else(|| panic!("{:?}", export.images));
        assert!(export.text.contains(&format!("@./{path}@")));
        (image.from.clone(), image.channels.len(), image.color_space, image.model)
    };
    let rough = vec![Property::roughness, Property::anisotropy];
    assert_eq!(plan("open_pbr_surface", "specular_roughness"), (rough, 1, ColorSpace::Linear, "open_pbr_surface"));
    let clear = vec![Property::opacity, Property::translucency];
    assert_eq!(plan("usd_preview_surface", "opacity"), (clear, 1, ColorSpace::Linear, "usd_preview_surface"));
    assert_comes_back(&[&material]);
}

#[test]
fn a_mesh_opens_with_its_materials() {
    let (a, b) = (Material::named("Same"), Material::named("Same"));
    let mesh = MeshArrays {
        name: "Quad",
        positions: &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.5], [0.0, 1.0, 0.5]],
        normals: &[[0.0, 0.0, 1.0]; 4],
        tangents: &[[1.0, 0.0, 0.0, 1.0]; 4],
        uvs: &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
        triangles: &[[0, 1, 2], [0, 2, 3]],
        parts: &[(1, 0..1), (0, 1..2)],
    };
    let options = Options { path_of: &|texture| texture.path.clone(), image_folder: "", mesh: Some(&mesh) };
    let scene = read(&usd::write(&[&a, &b], &options).text);
    assert!(scene.notes.is_empty(), "{:?}", scene.notes);
    let found = &scene.meshes[0];
    assert_eq!(found.path, "/Scene/Quad");
    for (p, q) in found.positions.iter().zip(mesh.positions) {
        assert!(p.iter().zip(q).all(|(p, q)| (p - q).abs() < 1e-6), "{p:?} {q:?}");
    }
    assert_eq!((found.uvs.as_deref(), found.normals.as_deref()), (Some(mesh.uvs), Some(mesh.normals)));
    assert_eq!(found.triangles, mesh.triangles);
    let parts: Vec<_> = found.parts.iter().map(|part| (part.material, part.triangles.clone())).collect();
    assert_eq!(parts, [(Some(1), 0..1), (Some(0), 1..2)]);
    assert_eq!(scene.materials[1].path, "/Scene/Materials/Same_2");
}

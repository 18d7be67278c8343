//! Materials as other programs write them.

use burnish_material::{Channel, ColorSpace, Material, Property, TextureRef, Value, Wrap};

use super::{export, read};

/// As Adobe's writers do it: inputs promoted to the material, a node graph around the shader, other types and case.
#[test]
fn promoted_inputs_and_node_graphs_are_followed() {
    let text = r#"#usda 1.0
def Scope "Looks" {
    def Material "Wood" ( displayName = "Old\t\"wood\"\x21 \\ \'\n" ) {
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
                normal3f inputs:normal.connect = </Looks/Wood/Graph/Normal.outputs:rgb>
                float inputs:normalScale = 0.5
                color3f inputs:sheenColor.connect = </Looks/Wood/Graph/Constant.outputs:out>
                double inputs:coatIOR = 1.3000000000000003
                float inputs:coatOpacity.connect = </Looks/Wood/Graph.outputs:coat>
                int inputs:scatter = 1
                token outputs:surface
            }
            def Shader "Constant" {
                uniform token info:id = "ND_constant_color3"
                color3f inputs:value = (0.5, 0.25, 0)
            }
            def Shader "Normal" {
                uniform token info:id = "UsdUVTexture"
                asset inputs:file = @n.png@
                float4 inputs:scale = (1.5, 1.5, 1.5, 0.75)
                float4 inputs:bias = (-0.75, -0.75, -0.75, 0)
                float3 outputs:rgb
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
    assert_eq!(found.name, "Old\t\"wood\"! \\ '\n");
    assert_eq!(found.unit_mm, Some(10.0));
    assert_eq!(found.color(Property::base_color), [0.25, 0.5, 0.75]);
    assert_eq!((found.float(Property::specular_ior), found.float(Property::coat_ior)), (1.25, 1.3000000000000003));
    assert_eq!((found.float(Property::coat), found.switch(Property::scatter)), (0.5, true));
    assert_eq!((found.float(Property::normal_scale), found.color(Property::sheen_color)), (0.375, [0.5, 0.25, 0.0]));
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
    assert_eq!((emission.uv_scale, emission.uv_rotation), ([2.0, 3.0], 30.0));
    // Counted from above, as in glTF.
    for (a, b) in emission.uv_offset.iter().zip([-1.4, -1.798_076_2]) {
        assert!((a - b).abs() < 1e-6, "{a} {b}");
    }
    assert_eq!((emission.wrap, emission.channel, found.float(Property::emission)), (Wrap::Clamp, Channel::Rgb, 1.0));
    assert_eq!(found.slot(Property::metallic).texture.as_ref().map(|t| t.channel), Some(Channel::B));
    // What has no place goes back out.
    let text = export(&[&found]).text;
    assert!(text.contains("float inputs:fancy = 0.5"), "{text}");
}

/// Vectors of section 5 of the mapping.
#[test]
fn the_networks_hold_the_published_numbers() {
    let input = |text: &str, shader: &str, name: &str| -> f64 {
        let surface = text.split(&format!("def Shader \"{shader}\"")).nth(1).expect("the shader");
        let value = surface.split(&format!("inputs:{name} = ")).nth(1).expect("the input");
        value.lines().next().and_then(|number| number.parse().ok()).expect("a number")
    };
    let near = |a: f64, b: f64| assert!((a - b).abs() <= 1e-6, "{a} {b}");
    for (roughness, anisotropy, along, split) in [
        (0.3, 0.5, 0.3538535, 0.4098361),
        (0.1, 0.8, 0.5447809, 0.9761678),
        (0.6, 0.3, 0.6033842, 0.02200489),
        (0.9, 0.9, 0.9539248, 0.19),
    ] {
        let mut material = Material::default();
        material.set(Property::roughness, Value::Float(roughness)).set(Property::anisotropy, Value::Float(anisotropy));
        let text = export(&[&material]).text;
        near(input(&text, "OpenPBR", "specular_roughness"), along);
        near(input(&text, "OpenPBR", "specular_roughness_anisotropy"), split);
        near(input(&text, "Preview", "roughness"), roughness);
    }
    for (ior, level, folded) in [(1.5, 0.25, 1.329431), (1.5, 1.0, 1.788789), (2.4, 0.8, 3.174021), (1.6, 0.4, 1.520181)] {
        let mut material = Material::default();
        for (property, number) in [
            (Property::specular_ior, ior),
            (Property::specular_level, level),
            (Property::coat_ior, ior),
            (Property::coat_specular_level, level),
            (Property::emission, 2.5),
            (Property::anisotropy_rotation, 0.7),
        ] {
            material.set(property, Value::Float(number));
        }
        let text = export(&[&material]).text;
        near(input(&text, "Preview", "ior"), folded);
        near(input(&text, "OpenPBR", "coat_ior"), folded);
        near(input(&text, "OpenPBR", "specular_weight"), 2.0 * level);
        near(input(&text, "OpenPBR", "emission_luminance"), 2500.0);
        near(input(&text, "Turn", "amount"), -252.0);
    }
    let mut material = Material::default();
    let placed = TextureRef { uv_rotation: 30.0, uv_scale: [2.0, 4.0], uv_offset: [0.1, 0.2], ..TextureRef::new("a.png") };
    material.slot_mut(Property::metallic).texture = Some(placed);
    let inverted = |scale: f64| TextureRef { is_inverted: true, scale: [scale; 3], ..TextureRef::new("a.png") };
    material.slot_mut(Property::coat).texture = Some(inverted(0.5));
    material.slot_mut(Property::normal).texture = Some(inverted(1.0));
    let text = export(&[&material]).text;
    for line in [
        "float inputs:rotation = 30",
        "float2 inputs:scale = (2, 4)",
        "float2 inputs:translation = (2.1, -2.6641016)",
        "float inputs:rotate = -30",
        "float2 inputs:scale = (0.5, 0.25)",
        "float2 inputs:offset = (-2.1, 2.6641016)",
        // 0.5·(1 - x), and the other side of green.
        "float4 inputs:scale = (-0.5, -0.5, -0.5, -0.5)\n        float4 inputs:bias = (0.5, 0.5, 0.5, 0.5)",
        "float4 inputs:scale = (2, -2, 2, 1)\n        float4 inputs:bias = (-1, 1, -1, 0)",
        "token inputs:sourceColorSpace = \"raw\"",
    ] {
        assert!(text.contains(line), "{line}\n{text}");
    }
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
        assert_eq!((a.uv_scale, a.uv_rotation, a.is_inverted), (b.uv_scale, b.uv_rotation, b.is_inverted));
        for (a, b) in a.uv_offset.iter().zip(b.uv_offset) {
            assert!((a - b).abs() < 1e-6, "{a} {b}");
        }
    }
    for property in
        [Property::normal_scale, Property::anisotropy_rotation, Property::anisotropy, Property::roughness, Property::height_scale]
    {
        assert!((found.float(property) - material.float(property)).abs() < 1e-5, "{property:?}: {}", found.float(property));
    }
    assert!((found.float(Property::height) - 0.75).abs() < 1e-6);
}

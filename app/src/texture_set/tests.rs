use super::names::{NAMES, named};
use super::*;
use Channel::{A, B, G, R, Rgb};
use Property as P;
use burnish_material::{PROPERTIES, Vary};

fn matched(names: &[&str]) -> TextureSetMatch {
    match_set(&names.iter().map(PathBuf::from).collect::<Vec<_>>())
}

/// Expects these textures, and nothing to be left over but `unmatched`.
fn expect(names: &[&str], slots: &[(Property, &str, Channel, bool)], unmatched: &[&str]) {
    let found = matched(names);
    let found_slots: Vec<_> =
        found.slots.iter().map(|s| (s.property, s.path.to_str().unwrap(), s.channel, s.is_inverted)).collect();
    assert_eq!(found_slots, slots, "{names:?}");
    let left: Vec<_> = found.unmatched.iter().map(|(path, _)| path.to_str().unwrap()).collect();
    assert_eq!(left, unmatched, "{:?}", found.unmatched);
    assert!(found.unmatched.iter().all(|(_, why)| !why.is_empty()));
}

#[test]
fn sets_of_painter_and_designer() {
    let p = |name: &str| format!("robot_Arm_1001_{name}.png");
    let names =
        ["BaseColor", "Height", "Metallic", "Normal", "Roughness", "Emissive", "Mixed_AO", "coatOpacity", "Coat_Roughness"];
    let names: Vec<String> = names.iter().map(|name| p(name)).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let slot = |property, i: usize| (property, names[i], Rgb, false);
    let slots = [
        slot(P::base_color, 0),
        slot(P::roughness, 4),
        slot(P::metallic, 2),
        slot(P::normal, 3),
        slot(P::height, 1),
        slot(P::emission_color, 5),
        slot(P::coat, 7),
        slot(P::coat_roughness, 8),
        slot(P::ambient_occlusion, 6),
    ];
    expect(&names, &slots, &[]);
    expect(
        &["lambert1_Base_color_1002.exr", "lambert1_Base_color_1001.exr", "lambert1_Normal_DirectX_1001.png", "sbs.sbsar"],
        &[
            (P::base_color, "lambert1_Base_color_1001.exr", Rgb, false),
            (P::normal, "lambert1_Normal_DirectX_1001.png", Rgb, true),
        ],
        &["lambert1_Base_color_1002.exr", "sbs.sbsar"],
    );
    expect(
        &["crate_OcclusionRoughnessMetallic - Linear.png", "crate_AnisotropyAngle.png", "crate_anisotropylevel.png"],
        &[
            (P::roughness, "crate_OcclusionRoughnessMetallic - Linear.png", G, false),
            (P::metallic, "crate_OcclusionRoughnessMetallic - Linear.png", B, false),
            (P::anisotropy, "crate_anisotropylevel.png", Rgb, false),
            (P::anisotropy_rotation, "crate_AnisotropyAngle.png", Rgb, false),
            (P::ambient_occlusion, "crate_OcclusionRoughnessMetallic - Linear.png", R, false),
        ],
        &[],
    );
}

#[test]
fn sets_of_libraries() {
    // ambientCG
    expect(
        &[
            "Metal032_1K-JPG_Color.jpg",
            "Metal032_1K-JPG_Displacement.jpg",
            "Metal032_1K-JPG_Metalness.jpg",
            "Metal032_1K-JPG_NormalDX.jpg",
            "Metal032_1K-JPG_NormalGL.jpg",
            "Metal032_1K-JPG_Roughness.jpg",
            "Metal032_1K-JPG.usdc",
            "Metal032.png",
        ],
        &[
            (P::base_color, "Metal032_1K-JPG_Color.jpg", Rgb, false),
            (P::roughness, "Metal032_1K-JPG_Roughness.jpg", Rgb, false),
            (P::metallic, "Metal032_1K-JPG_Metalness.jpg", Rgb, false),
            (P::normal, "Metal032_1K-JPG_NormalGL.jpg", Rgb, false),
            (P::height, "Metal032_1K-JPG_Displacement.jpg", Rgb, false),
        ],
        &["Metal032_1K-JPG_NormalDX.jpg", "Metal032_1K-JPG.usdc", "Metal032.png"],
    );
    // Poly Haven
    expect(
        &["rust_02_arm_1k.jpg", "rust_02_diff_1k.jpg", "rust_02_nor_gl_1k.exr", "rust_02_nor_dx_1k.exr", "rust_02_disp_1k.png"],
        &[
            (P::base_color, "rust_02_diff_1k.jpg", Rgb, false),
            (P::roughness, "rust_02_arm_1k.jpg", G, false),
            (P::metallic, "rust_02_arm_1k.jpg", B, false),
            (P::normal, "rust_02_nor_gl_1k.exr", Rgb, false),
            (P::height, "rust_02_disp_1k.png", Rgb, false),
            (P::ambient_occlusion, "rust_02_arm_1k.jpg", R, false),
        ],
        &["rust_02_nor_dx_1k.exr"],
    );
    // Poliigon
    expect(
        &[
            "MetalRust001_COL_VAR1_2K_METALNESS.jpg",
            "MetalRust001_METALNESS_2K_METALNESS.jpg",
            "MetalRust001_NRM_2K_METALNESS.jpg",
            "MetalRust001_NRM16_2K_METALNESS.jpg",
            "MetalRust001_GLOSS_2K_SPECULAR.jpg",
            "MetalRust001_REFL_2K_SPECULAR.jpg",
        ],
        &[
            (P::base_color, "MetalRust001_COL_VAR1_2K_METALNESS.jpg", Rgb, false),
            (P::roughness, "MetalRust001_GLOSS_2K_SPECULAR.jpg", Rgb, true),
            (P::metallic, "MetalRust001_METALNESS_2K_METALNESS.jpg", Rgb, false),
            (P::normal, "MetalRust001_NRM16_2K_METALNESS.jpg", Rgb, false),
        ],
        &["MetalRust001_NRM_2K_METALNESS.jpg", "MetalRust001_REFL_2K_SPECULAR.jpg"],
    );
    // Quixel
    expect(
        &[
            "vlkh_4K_Albedo.jpg",
            "vlkh_8K_Albedo.jpg",
            "vlkh_4K_Cavity.jpg",
            "vlkh_4K_AO.jpg",
            "vlkh_4K_Gloss.jpg",
            "vlkh_4K_Bump.jpg",
        ],
        &[
            (P::base_color, "vlkh_8K_Albedo.jpg", Rgb, false),
            (P::roughness, "vlkh_4K_Gloss.jpg", Rgb, true),
            (P::height, "vlkh_4K_Bump.jpg", Rgb, false),
            (P::ambient_occlusion, "vlkh_4K_AO.jpg", Rgb, false),
        ],
        &["vlkh_4K_Albedo.jpg", "vlkh_4K_Cavity.jpg"],
    );
}

#[test]
fn of_two_the_better_one_is_taken_in_any_order() {
    let cases: [(&[&str], &str); 7] = [
        (&["a_Height.jpg", "a_Height.png", "a_Height.exr"], "a_Height.exr"),
        (&["a_ORM.exr", "a_Roughness.jpg"], "a_Roughness.jpg"),
        (&["a_Normal_1k.png", "a_Normal_4k.png"], "a_Normal_4k.png"),
        (&["a_Roughness.png", "a_Glossiness.png"], "a_Roughness.png"),
        (&["a_Displacement.png", "a_Height.png"], "a_Height.png"),
        (&["a_DISP.png", "a_DISP16.png"], "a_DISP16.png"),
        (&["B/a_AO.png", "A/a_AO.png"], "A/a_AO.png"),
    ];
    for (names, best) in cases {
        let mut names = names.to_vec();
        for _ in 0..names.len() {
            names.rotate_left(1);
            let found = matched(&names);
            let is_taken = |slot: &MatchedSlot| slot.path == Path::new(best);
            assert!(found.slots.iter().any(is_taken), "{names:?}: {found:?}");
            assert!(found.unmatched.iter().all(|(path, _)| path != Path::new(best)));
        }
    }
    let found = matched(&["a_Height.jpg", "a_Height.exr"]);
    assert_eq!(found.unmatched, [(PathBuf::from("a_Height.jpg"), "is not needed: Height is read from a_Height.exr".into())]);
}

#[test]
fn every_name_of_every_property_with_a_texture_is_known() {
    for def in PROPERTIES.iter().filter(|def| def.vary != Vary::Uniform) {
        for name in [def.name, def.usage, def.label, &def.label.to_uppercase().replace(' ', "-"), &def.name.replace('_', ".")] {
            let file = format!("Wood_{name}_4096.tif.PNG");
            let found = matched(&[&file]).slots;
            assert_eq!(found.iter().map(|s| s.property).collect::<Vec<_>>(), [def.id], "{file}");
        }
    }
    for (names, _) in NAMES {
        for name in names.split(' ') {
            assert!(
                matches!(named(name), Some(Meaning::Uses(_, place)) if place > 0),
                "{name} stands for something else already"
            );
        }
    }
}

#[test]
fn odd_names_are_told_and_names_of_sets_may_stand_last() {
    expect(
        &["roughness-oak.png", "BaseColor oak.png"],
        &[(P::base_color, "BaseColor oak.png", Rgb, false), (P::roughness, "roughness-oak.png", Rgb, false)],
        &[],
    );
    expect(
        &["", "_", "1001.png", "....png", "é_Ö.jpg", "map.png", "16.png", "notes.txt"],
        &[],
        &["", "_", "1001.png", "....png", "é_Ö.jpg", "map.png", "16.png", "notes.txt"],
    );
    expect(
        &["x_MaskMap.png"],
        &[
            (P::roughness, "x_MaskMap.png", A, true),
            (P::metallic, "x_MaskMap.png", R, false),
            (P::ambient_occlusion, "x_MaskMap.png", G, false),
        ],
        &[],
    );
    assert_eq!(matched(&[]), TextureSetMatch::default());
}

#[test]
fn folders_give_the_images_directly_in_them() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["b_Normal.png", "a_Color.JPG", "notes.txt"] {
        std::fs::write(folder.path().join(name), b"x").unwrap();
    }
    std::fs::create_dir(folder.path().join("deeper.png")).unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink("circle.png", folder.path().join("circle.png")).unwrap();
    let files = read_folder(folder.path()).unwrap();
    assert_eq!(files, [folder.path().join("a_Color.JPG"), folder.path().join("b_Normal.png")]);
    let missing = folder.path().join("missing");
    assert!(read_folder(&missing).unwrap_err().starts_with(&format!("{}: cannot be read", missing.display())));
}

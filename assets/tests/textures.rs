//! Do the built-in textures tile, repeat bit by bit, keep their means, and are they named as they are said to be?

use burnish_assets::{BuiltInTexture, Image, TEXTURES, TextureDef, TextureError, TextureMaker, TextureMap};

/// The same texture with few texels, which is quick.
fn small(def: &TextureDef, size: usize) -> &'static TextureDef {
    let mut def = *def;
    def.size = size;
    Box::leak(Box::new(def))
}

fn plain(def: &'static TextureDef, map: TextureMap) -> BuiltInTexture {
    BuiltInTexture { def, map, mean: None, contrast: 1.0 }
}

/// Calls `check` for every map of every texture, made with `size` texels along each side.
fn for_all_maps(size: usize, mut check: impl FnMut(&str, TextureMap, &Image)) {
    for def in TEXTURES {
        let def = small(def, size);
        let mut maker = TextureMaker::default();
        for map in def.maps {
            let image = maker.make(&plain(def, *map));
            assert_eq!((image.width, image.height, image.texels.len()), (size, size, size * size), "{}", def.name);
            check(&format!("{}/{}", def.name, map.word()), *map, &image);
        }
    }
}

fn mean(image: &Image) -> [f64; 3] {
    let sum = image.texels.iter().fold([0.0; 3], |sum: [f64; 3], t| std::array::from_fn(|k| sum[k] + f64::from(t[k])));
    sum.map(|x| x / image.texels.len() as f64)
}

fn made(path: &str) -> Image {
    let texture = BuiltInTexture::parse(path).expect("it is built in").unwrap_or_else(|error| panic!("{path}: {error}"));
    TextureMaker::default().make(&BuiltInTexture { def: small(texture.def, 128), ..texture })
}

#[test]
fn every_map_lies_in_its_range_and_says_something() {
    for_all_maps(96, |name, map, image| {
        let is_good = |t: &[f32; 4]| t[..3].iter().all(|x| (0.0..=1.0).contains(x)) && t[3] == 1.0;
        assert!(image.texels.iter().all(is_good), "{name}");
        assert!(!image.is_eight_bit, "{name}: values are linear");
        assert!(image.texels.iter().any(|t| t != &image.texels[0]), "{name} is the same everywhere");
        let is_color = matches!(map, TextureMap::BaseColor | TextureMap::Normal);
        assert!(is_color || image.texels.iter().all(|t| t[0] == t[1] && t[1] == t[2]), "{name} is a number");
    });
}

#[test]
fn normals_are_unit_vectors_that_face_outwards() {
    for_all_maps(96, |name, map, image| {
        if map == TextureMap::Normal {
            for t in &image.texels {
                let n = [t[0], t[1], t[2]].map(|x| 2.0 * x - 1.0);
                let length = n.iter().map(|x| x * x).sum::<f32>().sqrt();
                assert!((length - 1.0).abs() < 1e-4 && n[2] > 0.0, "{name}: {n:?}");
            }
        }
    });
}

#[test]
fn normals_lean_away_from_what_is_high() {
    let (height, normal) = (made("builtin:brick/height"), made("builtin:brick/normal"));
    let n = height.width;
    let at = |image: &Image, x: usize, y: usize, k: usize| image.texels[(y % n) * n + x % n][k];
    for y in 1..n {
        for x in 1..n {
            let right = at(&height, x + 1, y, 0) - at(&height, x - 1, y, 0);
            let up = at(&height, x, y - 1, 0) - at(&height, x, y + 1, 0);
            let lean = [at(&normal, x, y, 0), at(&normal, x, y, 1)].map(|x| 2.0 * x - 1.0);
            assert!(lean[0] * right <= 1e-6 && lean[1] * up <= 1e-6, "at {x}, {y}");
        }
    }
}

#[test]
fn maps_are_the_same_every_time() {
    let mut first = Vec::new();
    for_all_maps(48, |_, _, image| first.push(image.clone()));
    let mut first = first.into_iter();
    for_all_maps(48, |name, _, image| assert!(first.next().is_some_and(|other| other == *image), "{name}"));
}

/// Largest mean step between neighbouring columns (or rows) inside, and the step from the last to the first.
fn steps(image: &Image, is_column: bool) -> (f32, f32) {
    let n = image.width;
    let texel = |line: usize, k: usize| if is_column { image.texels[k * n + line] } else { image.texels[line * n + k] };
    let step = |a: usize, b: usize| {
        let difference = |k: usize| (0..3).map(|c| (texel(a, k)[c] - texel(b, k)[c]).abs()).sum::<f32>();
        (0..n).map(difference).sum::<f32>() / n as f32
    };
    ((1..n).map(|line| step(line - 1, line)).fold(0.0, f32::max), step(n - 1, 0))
}

#[test]
fn maps_go_on_across_their_edges() {
    for_all_maps(128, |name, _, image| {
        for is_column in [true, false] {
            let (inside, edge) = steps(image, is_column);
            assert!(edge <= 1.15 * inside + 1e-4, "{name}: a step of {edge} at the edge, at most {inside} inside");
        }
    });
}

#[test]
fn a_mean_that_is_asked_for_is_kept() {
    let wanted = [0.62, 0.31, 0.045];
    for def in TEXTURES.iter().filter(|def| def.maps.contains(&TextureMap::BaseColor)) {
        for settings in ["?mean=0.62,0.31,0.045", "?contrast=1.5&mean=0.62,0.31,0.045"] {
            let found = mean(&made(&format!("builtin:{}/base_color{settings}", def.name)));
            let is_kept = found.iter().zip(wanted).all(|(found, wanted)| (found / wanted - 1.0).abs() < 0.01);
            assert!(is_kept, "{}{settings}: {found:?}", def.name);
        }
        let found = mean(&made(&format!("builtin:{}/roughness?mean=0.4", def.name)))[0];
        assert!((found / 0.4 - 1.0).abs() < 0.01, "{}: {found}", def.name);
    }
}

#[test]
fn contrast_spreads_values_about_the_mean() {
    let deviation = |path: &str| {
        let image = made(path);
        let m = mean(&image)[0];
        (image.texels.iter().map(|t| (f64::from(t[0]) - m).powi(2)).sum::<f64>() / image.texels.len() as f64).sqrt()
    };
    let at = |contrast: f64| deviation(&format!("builtin:wood-oak/base_color?mean=0.3&contrast={contrast}"));
    assert!(at(0.0) < 1e-4);
    assert!(at(0.5) < 0.7 * at(1.0) && at(1.0) < 0.7 * at(2.0), "{} {} {}", at(0.5), at(1.0), at(2.0));
}

#[test]
fn every_map_has_one_name() {
    for (i, def) in TEXTURES.iter().enumerate() {
        assert!(TEXTURES[..i].iter().all(|other| other.name != def.name), "{}", def.name);
        assert!(def.doc.ends_with('.') && def.size == 512, "{}", def.name);
        for map in def.maps {
            let texture = BuiltInTexture::parse(&format!("builtin:{}/{}", def.name, map.word()));
            let texture = texture.expect("it is built in").unwrap_or_else(|error| panic!("{error}"));
            assert!(texture.def.name == def.name && texture.map == *map, "{}/{}", def.name, map.word());
        }
    }
    assert!(BuiltInTexture::parse("wood-oak/base_color.png").is_none(), "a file");
}

#[test]
fn what_is_wrong_with_a_name_is_told() {
    let error = |path: &str| match BuiltInTexture::parse(path) {
        Some(Err(error)) => error,
        other => panic!("{path}: {other:?}"),
    };
    let cases = [
        ("builtin:wood-oka/base_color", "built-in texture, found `wood-oka`"),
        ("builtin:wood-oak/metallic", "wood-oak (base_color, roughness, height, normal), found `metallic`"),
        ("builtin:wood-oak", "found ``"),
        ("builtin:wood-oak/base_color?mean=2", "numbers from 0 to 1 of a built-in texture, found `mean=2`"),
        ("builtin:wood-oak/base_color?mean=nan", "found `mean=nan`"),
        ("builtin:wood-oak/base_color?contrast=5", "from 0 to 4"),
        ("builtin:wood-oak/base_color?tint=1", "found `tint=1`"),
        ("builtin:wood-oak/roughness?mean=0.1,0.2,0.3", "mean=NUMBER from 0 to 1"),
        ("builtin:wood-oak/height?mean=0.5", "no settings for this map"),
        ("builtin:wood-oak/base_color?", "found ``"),
    ];
    for (path, expected) in cases {
        let message = error(path).to_string();
        assert!(message.contains(expected), "{path}: {message}");
    }
    assert!(matches!(error("builtin:"), TextureError::Texture { name } if name.is_empty()));
    let unknown = error("builtin:wood-oka/base_color");
    assert!(unknown.unknown().is_some_and(|(name, known)| name == "wood-oka" && known.contains(&"wood-oak")));
}

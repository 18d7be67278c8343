//! Pictures that say how they were made: the material comes back, and the picture comes again.

use super::{Place, Run};
use exr::meta::attribute::AttributeValue;
use exr::prelude::{Text, read_first_flat_layer_from_file};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Channels by name.
fn planes(path: &Path) -> BTreeMap<String, Vec<f32>> {
    let image = read_first_flat_layer_from_file(path).unwrap();
    let list = image.layer_data.channel_data.list.into_iter();
    list.map(|channel| (channel.name.to_string(), channel.sample_data.values_as_f32().collect())).collect()
}

fn job(path: &Path) -> Value {
    let image = read_first_flat_layer_from_file(path).unwrap();
    match image.layer_data.attributes.other.get(&Text::from("burnish")) {
        Some(AttributeValue::Text(text)) => serde_json::from_str(&text.to_string()).unwrap(),
        _ => panic!("the job is there"),
    }
}

fn is_fine(run: &Run) {
    assert_eq!(run.code, Some(0), "{}", run.err);
}

/// A picture's job, changed and put back; the pixels are left alone.
fn change_job(from: &Path, to: &Path, change: impl Fn(&str) -> String) {
    let mut image = read_first_flat_layer_from_file(from).unwrap();
    let attribute = image.layer_data.attributes.other.get_mut(&Text::from("burnish")).unwrap();
    let AttributeValue::Text(text) = attribute else { panic!("a text") };
    *text = Text::from(change(&text.to_string()).as_str());
    exr::prelude::WritableImage::write(&image).to_file(to).unwrap();
}

#[test]
fn a_picture_made_again_is_the_same_whatever_ended_it() {
    let place = Place::new();
    let scene = ["--scene", "scenes/quad.json", "--size", "40x36", "--seed", "11"];
    let ball =
        ["preset:gold, POLISHED", "--mesh", "torus", "--size", "36x30", "--rotate-environment", "33", "--camera", "20,10,6"];
    let cases: &[(&[&str], &[&str])] = &[
        (&["red.asm.ron", "--error", "8%", "--aov", "samples,albedo", "--half"], &scene),
        (&["--time", "0.4", "--transparent", "--set", "roughness=0.3"], &scene),
        // Too short for a sample in every pixel.
        (&["--time", "0.00001"], &scene),
        (&["--spp", "9", "--exposure", "1", "--display-transform", "agx", "--bits", "16", "--denoise=burnish"], &ball),
        (&["--spp", "5", "--no-adaptive", "--no-photons", "--without", "specular", "--fov", "50", "--max-bounces", "2"], &ball),
    ];
    for (words, scene) in cases {
        for ending in ["exr", "png"] {
            let [first, second] = ["first", "second"].map(|name| format!("{name}.{ending}"));
            let made = place.run(&[&["render"], *words, *scene, &["--out", &first, "--json"]].concat());
            is_fine(&made);
            let again = place.run(&["render", &first, "--out", &second, "--threads", "1", "--json"]);
            is_fine(&again);
            let read = |name: &str| fs::read(place.path(name)).unwrap();
            assert!(read(&first) == read(&second), "{words:?}: {ending}");
            for key in ["spp", "stop_reason", "relmse_estimate", "width", "seed"] {
                assert_eq!(made.json()[key], again.json()[key], "{words:?} {key}");
            }
        }
    }
    // From one format to the other, and from another folder.
    is_fine(&place.run(&["render", "first.exr", "--out", "other.png"]));
    assert!(fs::read(place.path("other.png")).unwrap() == fs::read(place.path("first.png")).unwrap());
    fs::create_dir(place.path("sub")).unwrap();
    let run: Run = place
        .command()
        .current_dir(place.path("sub"))
        .args(["render", "../first.exr", "--out", "a.exr"])
        .output()
        .unwrap()
        .into();
    is_fine(&run);
    assert!(planes(&place.path("sub/a.exr")) == planes(&place.path("first.exr")));
}

#[test]
fn all_passes_are_layers_and_lobes_sum_to_the_picture() {
    let place = Place::new();
    let names = "albedo,normal,depth,position,emission,lobes,samples,error,variance";
    let words = ["red.asm.ron", "--set", "emission=0.5", "--set", "coat=1", "--spp", "16", "--aov", names];
    is_fine(&place.render(&[&words[..], &["--out", "a.exr"]].concat()));
    let planes_of = planes(&place.path("a.exr"));
    for name in [
        "R",
        "albedo.R",
        "normal.Z",
        "depth.Z",
        "position.X",
        "emission.G",
        "lobes.coat.R",
        "lobes.diffuse.B",
        "lobes.emission.R",
        "lobes.through.R",
        "samples.V",
        "error.V",
        "variance.R",
    ] {
        assert!(planes_of.contains_key(name), "{name}: {:?}", planes_of.keys());
    }
    let middle = 32 * 16 + 16;
    let at = |name: &str| planes_of[name][middle];
    assert!(
        (at("emission.R") - 0.5).abs() < 1e-6 && (at("position.Z")).abs() < 1e-3,
        "{} {}",
        at("emission.R"),
        at("position.Z")
    );
    // The pixel's middle lies half a pixel right of the picture's.
    assert!(at("position.X") > 0.0 && at("position.X") < 0.2 && at("position.Y") < 0.0);
    for channel in ["R", "G", "B"] {
        let lobes: Vec<_> = planes_of.iter().filter(|(name, _)| name.starts_with("lobes.") && name.ends_with(channel)).collect();
        for (i, whole) in planes_of[channel].iter().enumerate() {
            let sum: f32 = lobes.iter().map(|(_, plane)| plane[i]).sum();
            assert!((sum - whole).abs() <= 1e-4 * whole.max(0.01), "{channel} {i}: {sum} {whole}");
        }
    }
    // Colours as halves, what needs digits as floats.
    is_fine(&place.render(&[&words[..], &["--half", "--out", "b.exr"]].concat()));
    let image = read_first_flat_layer_from_file(place.path("b.exr")).unwrap();
    for channel in &image.layer_data.channel_data.list {
        let is_half = matches!(channel.sample_data, exr::prelude::FlatSamples::F16(_));
        let name = channel.name.to_string();
        let needs_digits = ["depth", "position", "samples", "error", "variance"].iter().any(|kind| name.starts_with(kind));
        assert_eq!(is_half, !needs_digits, "{name}");
    }
    // PNG: files beside it, of 8 or 16 bits.
    for (bits, color) in [("8", image::ColorType::Rgb8), ("16", image::ColorType::Rgb16)] {
        let json = place.render(&[&words[..], &["--bits", bits, "--out", "c.png", "--json"]].concat()).json();
        assert_eq!(json["encoding"], "PNG: display-referred sRGB");
        for name in ["c.png", "c.lobes.diffuse.png", "c.position.png", "c.error.png"] {
            assert!(json["files"].as_array().unwrap().contains(&name.into()), "{name}: {json}");
            assert_eq!(image::open(place.path(name)).unwrap().color(), color, "{name}");
        }
    }
}

#[test]
fn what_a_picture_needs_must_be_what_it_was() {
    let place = Place::new();
    image::RgbImage::from_pixel(4, 4, image::Rgb([200, 30, 30])).save(place.path("map.png")).unwrap();
    place.write(
        "mapped.asm.ron",
        "{\"asm\": \"4.0\", // kept\n\"properties\": {\"base_color\": {\"texture\": {\"path\": \"map.png\"}}, \"velvet\": 1}}",
    );
    let words = ["mapped.asm.ron", "--mesh", "meshes/quad.ply", "--environment", "env/grey.exr", "--size", "16x16", "--spp", "4"];
    is_fine(&place.run(&[&["render"], &words[..], &["--out", "a.exr"]].concat()));
    is_fine(&place.run(&["render", "a.exr", "--out", "b.exr"]));
    assert!(fs::read(place.path("a.exr")).unwrap() == fs::read(place.path("b.exr")).unwrap());
    // With another option it is only the material.
    let other = place.run(&["render", "a.exr", "--size", "8x8", "--spp", "1", "--out", "c.exr", "--json"]);
    is_fine(&other);
    assert_eq!(
        (&other.json()["width"], job(&place.path("c.exr"))["material"].as_str()),
        (&8.into(), job(&place.path("a.exr"))["material"].as_str())
    );
    assert_eq!(job(&place.path("a.exr"))["material"].as_str(), fs::read_to_string(place.path("mapped.asm.ron")).ok().as_deref());
    for (file, what) in [("meshes/quad.ply", "mesh"), ("env/grey.exr", "environment"), ("map.png", "image")] {
        let bytes = fs::read(place.path(file)).unwrap();
        let mut changed = bytes.clone();
        changed.push(0);
        fs::write(place.path(file), &changed).unwrap();
        let refused = place.run(&["render", "a.exr", "--out", "d.exr"]);
        assert_eq!(refused.code, Some(2), "{file}");
        let has = |text: &str| refused.err.contains(text);
        assert!(has("a.exr: the ") && has(what) && has(file) && has("not what it was"), "{}", refused.err);
        fs::remove_file(place.path(file)).unwrap();
        let missing = place.run(&["render", "a.exr", "--out", "d.exr"]);
        assert_eq!((missing.code, missing.err.trim().lines().count()), (Some(2), 1), "{}", missing.err);
        assert!(missing.err.contains(&format!("needs the {what}")) && !place.path("d.exr").exists(), "{}", missing.err);
        fs::write(place.path(file), &bytes).unwrap();
    }
}

#[test]
fn pictures_of_other_versions_say_how_they_may_differ() {
    let place = Place::new();
    is_fine(&place.render(&["--spp", "4", "--out", "a.exr"]));
    let (a, old) = (place.path("a.exr"), place.path("old.exr"));
    change_job(&a, &old, |job| {
        job.replace("\"picture_version\":1", "\"picture_version\":0").replace("Burnish 0.1.0", "Burnish 0.0.1")
    });
    let run = place.run(&["render", "old.exr", "--out", "b.exr"]);
    is_fine(&run);
    for text in ["old.exr", "Burnish 0.0.1", "version 0", "noise may differ", "within the error"] {
        assert!(run.err.contains(text), "{text}: {}", run.err);
    }
    assert_eq!(run.err.lines().count(), 1);
    assert!(planes(&place.path("b.exr")) == planes(&a));
    change_job(&a, &old, |job| job.replace("Burnish 0.1.0", "Burnish 0.0.1"));
    let run = place.run(&["render", "old.exr", "--out", "b.exr"]);
    is_fine(&run);
    assert!(run.err.contains("the same bits"), "{}", run.err);
    // Jobs that make no sense are refused with a sentence each.
    for (from, to, said) in [
        ("\"size\":[32,32]", "\"size\":[99999,3]", "99999 x 3"),
        ("\"samples\":[4096]", "\"samples\":[]", "how many samples"),
        ("\"samples\":[4096]", "\"samples\":[4096,4096]", "how many samples"),
        ("\"samples\":[4096]", "\"samples\":[18446744073709551615]", "how many samples"),
        ("\"fov_deg\":40.0", "\"fov_deg\":400.0", "camera"),
        ("\"seed\":0", "\"seed\":true", "cannot be read"),
        ("\"display_transform\":\"neutral\"", "\"display_transform\":\"film\"", "neutral, agx"),
    ] {
        change_job(&a, &old, |job| {
            assert!(job.contains(from), "{from}: {job}");
            job.replace(from, to)
        });
        let run = place.run(&["render", "old.exr", "--out", "b.exr"]);
        assert_eq!((run.code, run.err.trim().lines().count()), (Some(2), 1), "{from}: {}", run.err);
        assert!(run.err.contains(said), "{said}: {}", run.err);
    }
}

#[test]
fn broken_pictures_are_refused_with_a_sentence() {
    let place = Place::new();
    for name in ["a.exr", "a.png"] {
        is_fine(&place.render(&["--spp", "1", "--out", name]));
        let bytes = fs::read(place.path(name)).unwrap();
        for length in [0, 3, 50, 200] {
            let broken = format!("broken.{}", &name[2..]);
            fs::write(place.path(&broken), &bytes[..length]).unwrap();
            let run = place.run(&["render", &broken, "--out", "b.png"]);
            assert_eq!((run.code, run.err.trim().lines().count()), (Some(2), 1), "{name} {length}: {}", run.err);
            assert!(run.err.contains(&broken), "{}", run.err);
        }
    }
}

#[cfg(unix)]
#[test]
fn a_full_disk_is_one_message_and_leaves_nothing() {
    let place = Place::new();
    let before = place.names();
    for name in ["a.png", "a.exr"] {
        // Files may not grow beyond one block, which stands for a disk without room.
        let script = format!(
            "trap '' XFSZ; ulimit -f 1; exec {} render --scene scenes/quad.json --size 64x64 --spp 2 --aov albedo --out {name}",
            env!("CARGO_BIN_EXE_burnish")
        );
        let mut shell = std::process::Command::new("sh");
        let run: Run = shell.current_dir(place.path("")).args(["-c", &script]).output().unwrap().into();
        assert_eq!((run.code, run.err.trim().lines().count()), (Some(2), 1), "{}", run.err);
        assert!(run.err.contains(&format!("{name}: cannot be written")), "{}", run.err);
        assert_eq!(place.names(), before);
    }
}

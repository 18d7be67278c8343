//! Pictures: what is written, said and obeyed.

use super::{Place, Run, SCENE, pixels};
use exr::meta::attribute::AttributeValue;
use serde_json::Value;
use std::fs;
use std::process::Command;

#[test]
fn render_json_is_one_object_with_the_promised_fields() {
    let place = Place::new();
    let run = place.render(&["--spp", "4", "--out", "a.png", "--json"]);
    assert_eq!(run.code, Some(0), "{}", run.err);
    assert_eq!(run.err, "");
    let json = run.json();
    for key in [
        "out",
        "width",
        "height",
        "spp",
        "seconds",
        "load_seconds",
        "first_image_seconds",
        "stop_reason",
        "relmse_estimate",
        "relmse_low",
        "relmse_high",
        "samples_per_second",
        "threads",
        "seed",
        "lobes",
        "left_out",
        "peak_memory_bytes",
        "nonfinite_samples",
    ] {
        assert!(json.get(key).is_some(), "{key}: {json}");
    }
    assert_eq!((&json["width"], &json["height"], &json["spp"]), (&32.into(), &32.into(), &4.into()));
    assert_eq!((&json["stop_reason"], &json["nonfinite_samples"], &json["seed"]), (&"spp".into(), &0.into(), &0.into()));
    assert!(json["lobes"].as_array().unwrap().contains(&"diffuse".into()), "{json}");
    assert!(json["left_out"].as_array().unwrap().contains(&"coat".into()), "{json}");
    let picture = image::open(place.path("a.png")).unwrap();
    assert_eq!((picture.width(), picture.height()), (32, 32));
}

#[test]
fn text_tells_error_against_time() {
    let place = Place::new();
    let run = place.render(&["--spp", "8", "--out", "a.png"]);
    assert_eq!(run.code, Some(0), "{}", run.err);
    for text in ["a.png", "8 spp in ", " s, error ", " % (±", "stopped by spp"] {
        assert!(run.out.contains(text), "{text}: {}", run.out);
    }
}

#[test]
fn the_first_stop_rule_to_hit_wins() {
    let place = Place::new();
    let cases: &[(&[&str], &str)] = &[
        (&["--time", "0.2"], "time"),
        (&["--time", "100", "--spp", "2"], "spp"),
        (&["--error", "50%", "--time", "100"], "error"),
    ];
    for (words, reason) in cases {
        let json = place.render(&[words, &["--out", "a.exr", "--json"][..]].concat()).json();
        assert_eq!(json["stop_reason"], *reason, "{words:?}: {json}");
        // The picture itself says the same.
        let image = exr::prelude::read_first_flat_layer_from_file(place.path("a.exr")).unwrap();
        let Some(AttributeValue::Text(job)) = image.layer_data.attributes.other.get(&exr::prelude::Text::from("burnish")) else {
            panic!("the job is there")
        };
        let job: Value = serde_json::from_str(&job.to_string()).unwrap();
        for key in ["stop_reason", "spp", "relmse_estimate", "relmse_low", "relmse_high", "is_firefly_limited"] {
            assert_eq!(job.get(key), json.get(key), "{key}: {job} {json}");
        }
    }
}

#[test]
fn pictures_do_not_depend_on_threads_but_on_the_seed() {
    let place = Place::new();
    let file = |name: &str, words: &[&str]| {
        let run = place.render(&[words, &["--spp", "5", "--aov", "albedo,variance", "--out", name][..]].concat());
        assert_eq!(run.code, Some(0), "{}", run.err);
        fs::read(place.path(name)).unwrap()
    };
    for ending in ["exr", "png"] {
        let one = file(&format!("1.{ending}"), &["--threads", "1"]);
        assert!(one == file(&format!("2.{ending}"), &["--threads", "2"]), "{ending}: threads change the picture");
        assert!(one == file(&format!("3.{ending}"), &["--seed", "0"]), "{ending}: a run changes the picture");
    }
    assert!(file("4.exr", &["--seed", "1"]) != file("5.exr", &["--seed", "2"]), "the seed changes nothing");
}

#[test]
fn exr_holds_layers_and_png_has_them_beside_it() {
    let place = Place::new();
    let layers = ["--aov", "albedo,normal,depth,variance,samples,albedo", "--transparent", "--spp", "4"];
    assert_eq!(place.render(&[&layers[..], &["--out", "a.exr"]].concat()).code, Some(0));
    let image = exr::prelude::read_first_flat_layer_from_file(place.path("a.exr")).unwrap();
    let channels = &image.layer_data.channel_data.list;
    let names: Vec<String> = channels.iter().map(|channel| channel.name.to_string()).collect();
    for name in ["R", "G", "B", "A", "albedo.R", "normal.X", "depth.Z", "variance.B", "samples.V"] {
        assert!(names.iter().any(|known| known == name), "{name}: {names:?}");
    }
    let middle = |name: &str| {
        let channel = channels.iter().find(|channel| channel.name.to_string() == name).unwrap();
        channel.sample_data.values_as_f32().nth(32 * 16 + 16).unwrap()
    };
    assert!((middle("albedo.B") - 0.6).abs() < 0.05, "{}", middle("albedo.B"));
    assert!((middle("normal.Z") - 1.0).abs() < 1e-3 && (middle("depth.Z") - 5.0).abs() < 0.01);
    assert_eq!((middle("samples.V"), middle("A")), (4.0, 1.0));

    let json = place.render(&[&layers[..], &["--out", "b.png", "--json"]].concat()).json();
    assert_eq!(json["files"].as_array().unwrap().len(), 6);
    for name in ["b.png", "b.albedo.png", "b.normal.png", "b.depth.png", "b.variance.png", "b.samples.png"] {
        assert!(place.path(name).is_file(), "{name}");
    }
    let picture = image::open(place.path("b.png")).unwrap().to_rgba8();
    assert_eq!((picture.get_pixel(16, 16)[3], picture.get_pixel(0, 0)[3]), (255, 0));
}

#[test]
fn denoised_pictures_say_so_and_keep_the_raw_one() {
    let place = Place::new();
    let words = ["--denoise=burnish", "--spp", "8", "--json"];
    let render = |more: &[&str]| {
        let run = place.render(&[&words[..], more].concat());
        assert_eq!(run.code, Some(0), "{}", run.err);
        run.json()
    };
    let json = render(&["--out", "a.exr"]);
    assert_eq!(json["denoiser"], "burnish");
    let [low, relmse, high] =
        ["relmse_low_denoised", "relmse_estimate_denoised", "relmse_high_denoised"].map(|key| json[key].as_f64().unwrap());
    assert!(low <= relmse && relmse <= high, "{json}");
    let channel = |name: &str, channel: &str| -> Vec<f32> {
        let image = exr::prelude::read_first_flat_layer_from_file(place.path(name)).unwrap();
        let list = &image.layer_data.channel_data.list;
        let found = list.iter().find(|known| known.name.to_string() == channel);
        found.unwrap_or_else(|| panic!("{name}: no {channel}")).sample_data.values_as_f32().collect()
    };
    assert!(fs::read(place.path("a.exr")).unwrap().windows(20).any(|text| text == b"\"denoiser\":\"burnish\""[..20].as_ref()));
    // The raw layer is the picture without the option; the picture itself is another.
    assert_eq!(place.render(&["--spp", "8", "--out", "b.exr"]).code, Some(0));
    assert!(channel("a.exr", "raw.R") == channel("b.exr", "R") && channel("a.exr", "R") != channel("b.exr", "R"));

    let json = render(&["--transparent", "--threads", "2", "--out", "c.png"]);
    let files: Vec<&str> = json["files"].as_array().unwrap().iter().map(|file| file.as_str().unwrap()).collect();
    assert_eq!(files, ["c.png", "c.raw.png"]);
    assert_eq!(place.render(&["--transparent", "--spp", "8", "--out", "d.png"]).code, Some(0));
    let read = |name: &str| fs::read(place.path(name)).unwrap();
    assert!(read("c.raw.png") == read("d.png") && read("c.png") != read("d.png"));
    render(&["--transparent", "--threads", "1", "--out", "e.png"]);
    assert!(read("c.png") == read("e.png"), "threads change the denoised picture");

    // Too few samples, and a library that is not there, are told.
    let few = place.render(&["--denoise=burnish", "--spp", "3", "--json", "--out", "f.png"]);
    assert_eq!((few.code, &few.json()["denoiser"]), (Some(0), &Value::Null));
    assert!(few.err.contains("at least 4 samples") && !place.path("f.raw.png").exists(), "{}", few.err);
    let mut command = place.command();
    command.args([
        "render",
        "red.asm.ron",
        "--scene",
        "scenes/quad.json",
        "--denoise=oidn",
        "--spp",
        "4",
        "--out",
        "g.png",
        "--json",
    ]);
    let missing = Run::from(command.env("BURNISH_OIDN", "nowhere.so").output().unwrap());
    assert_eq!((missing.code, &missing.json()["denoiser"]), (Some(0), &"burnish".into()), "{}", missing.err);
    assert!(missing.err.contains("nowhere.so") && missing.err.contains("own filter"), "{}", missing.err);
}

#[test]
fn the_preview_needs_an_adapter_and_says_so() {
    let place = Place::new();
    let run = place.render(&["--view", "preview", "--spp", "2", "--out", "a.png", "--json"]);
    if run.code == Some(2) && std::env::var_os("BURNISH_REQUIRE_GPU").is_none() {
        assert!(run.err.contains("--view preview: ") && !place.path("a.png").exists(), "{}", run.err);
        eprintln!("skipped: {}", run.err);
        return;
    }
    assert_eq!(run.code, Some(0), "{}", run.err);
    assert_eq!((&run.json()["view"], &run.json()["relmse_estimate"]), (&"preview".into(), &Value::Null));
    let picture = image::open(place.path("a.png")).unwrap().to_rgb8();
    assert!(picture.get_pixel(16, 16) != picture.get_pixel(0, 0), "the quad differs from the background");
    for words in [&["--aov", "albedo"][..], &["--transparent"], &["--error", "1%"]] {
        let refused = place.render(&[words, &["--view", "preview", "--out", "b.png"]].concat());
        assert_eq!(refused.code, Some(2), "{words:?}");
        assert!(refused.err.contains("--view final"), "{}", refused.err);
    }
}

#[test]
fn scene_options_change_the_picture() {
    let place = Place::new();
    let mean = |words: &[&str]| {
        let run = place.render(&[words, &["--spp", "16", "--out", "a.exr"][..]].concat());
        assert_eq!(run.code, Some(0), "{words:?}: {}", run.err);
        let pixels = pixels(&place.path("a.exr"));
        pixels.iter().fold([0.0; 3], |sum, pixel| [0, 1, 2].map(|c| sum[c] + pixel[c] / pixels.len() as f32))
    };
    let plain = mean(&[]);
    for words in [
        &["red.asm.ron"][..],
        &["preset:gold, POLISHED"],
        &["--set", "baseColor=#ff0000"],
        &["--set", "base_color=0.9,0.9,0.9"],
        &["--set", "metallic=1", "--set", "roughness=0"],
        &["--environment", "white-furnace"],
        &["--environment", "env/grey.exr"],
        &["--camera", "40,10,3"],
        &["--fov", "80"],
        &["--set", "emission=3"],
    ] {
        assert!(mean(words) != plain, "{words:?} changes nothing");
    }
    // Exposure belongs to the display, so the radiance stays.
    assert_eq!(mean(&["--exposure", "2"]), plain);
    let size = place.run(&["render", "--scene", "scenes/quad.json", "--spp", "1", "--out", "a.png", "--json"]).json();
    assert_eq!((&size["width"], &size["height"]), (&24.into(), &16.into()), "the size of the film holds");
}

#[test]
fn warnings_are_told_and_do_not_stop() {
    let place = Place::new();
    place.write("odd.asm.ron", "{\"properties\": {\"velvet\": 1}}");
    place.write("scenes/odd.json", &SCENE.replace("\"roughness\": 0.5", "\"roughness\": 1.5, \"velvet\": 1"));
    for (words, text) in [
        (&["odd.asm.ron", "--scene", "scenes/quad.json"][..], "velvet"),
        (&["--scene", "scenes/odd.json"], "velvet"),
        (&["--scene", "scenes/odd.json"], "range 0 to 1"),
        (&["--scene", "scenes/quad.json", "--set", "roughness=7"], "range 0 to 1"),
    ] {
        let run = place.run(&[&["render"], words, &["--spp", "1", "--out", "a.png", "--json"]].concat());
        assert_eq!(run.code, Some(0), "{words:?}: {}", run.err);
        assert!(run.err.contains("warning: ") && run.err.contains(text), "{words:?}: {}", run.err);
        assert!(!run.json()["warnings"].as_array().unwrap().is_empty(), "{words:?}");
    }
}

#[test]
fn a_material_file_is_warned_about_once_each() {
    let place = Place::new();
    let texture = |path: &str| format!("{{\"texture\": {{\"path\": \"{path}\"}}}}");
    let cases = [
        ("1.5".to_owned(), "roughness: expected range 0 to 1, found 1.5"),
        (texture("none.png"), "none.png, found no file"),
        (texture("env"), "env, found a folder"),
        (texture("red.asm.ron"), "red.asm.ron, found a name without"),
        (texture(""), "roughness: has a texture without a path"),
        (texture("builtin:wood-oka/roughness"), "found `wood-oka`; did you mean `wood-oak`?"),
        (texture("builtin:wood-oak/roughnes"), "found `roughnes`; did you mean `roughness`?"),
    ];
    for (value, text) in cases {
        place.write("odd.asm.ron", &format!("{{\"asm\": \"4.0\", \"properties\": {{\"roughness\": {value}}}}}"));
        let run = place.render(&["odd.asm.ron", "--spp", "1", "--out", "a.png", "--json"]);
        assert_eq!(run.code, Some(0), "{value}: {}", run.err);
        let json = run.json();
        let warnings: Vec<_> = json["warnings"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
        assert!(matches!(warnings[..], [only] if only.starts_with("odd.asm.ron: ") && only.contains(text)), "{warnings:?}");
        assert_eq!(run.err.lines().count(), 1, "{}", run.err);

        let rows = place.run(&["check", "odd.asm.ron", "--json"]).json();
        assert_eq!((&rows["errors"], &rows["warnings"]), (&0.into(), &1.into()), "{rows}");
    }
}

#[test]
fn built_in_textures_are_rendered_and_never_missing() {
    let place = Place::new();
    let color = |value: &str| format!("{{\"asm\": \"4.0\", \"properties\": {{\"base_color\": {value}}}}}");
    place.write("plain.asm.ron", &color("(0.4, 0.3, 0.2)"));
    place.write("oak.asm.ron", &color("{\"texture\": {\"path\": \"builtin:wood-oak/base_color?mean=0.4,0.3,0.2\"}}"));
    for name in ["plain", "oak"] {
        let run = place.render(&[&format!("{name}.asm.ron"), "--spp", "4", "--out", &format!("{name}.png"), "--json"]);
        assert_eq!((run.code, run.err.as_str()), (Some(0), ""), "{name}");
    }
    assert!(fs::read(place.path("plain.png")).unwrap() != fs::read(place.path("oak.png")).unwrap());
    let rows = place.run(&["check", "oak.asm.ron", "--json"]).json();
    assert_eq!((&rows["errors"], &rows["warnings"]), (&0.into(), &0.into()), "{rows}");
}

#[cfg(unix)]
#[test]
fn an_interrupted_render_exits_with_130_and_leaves_nothing() {
    let place = Place::new();
    let before = place.names();
    let mut child = place
        .command()
        .args(["render", "--scene", "scenes/quad.json", "--time", "600", "--out", "a.png", "--json"])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    // Long enough to be inside the render on a slow machine; the outcome is the same if it is not.
    std::thread::sleep(std::time::Duration::from_millis(1500));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let code = child.wait().unwrap().code();
    let run: Run = child.wait_with_output().unwrap().into();
    assert_eq!((code, run.out.as_str()), (Some(130), ""), "{}", run.err);
    assert_eq!(place.names(), before);
}

//! Errors: comparing pictures, curves against time.

use super::{Place, Run};
use serde_json::Value;
use std::fs;
use std::process::Command;

#[test]
fn compare_tells_how_far_pictures_are_apart() {
    let place = Place::new();
    let write = |name: &str, value: f32| {
        exr::prelude::write_rgb_file(place.path(name), 96, 8, |_, _| (value, 0.5 * value, 0.25_f32)).unwrap();
    };
    write("a.exr", 0.5);
    write("b.exr", 0.4);
    let same = place.run(&["compare", "a.exr", "a.exr", "--limit", "relmse=0", "--limit", "flip_p99=0", "--json"]);
    assert_eq!((same.code, same.err.as_str()), (Some(0), ""));
    let json = same.json();
    for key in ["relmse", "relmse_trimmed", "flip_mean", "flip_p99"] {
        assert_eq!(json[key], 0.0, "{key}: {json}");
    }
    let json = place.run(&["compare", "a.exr", "b.exr", "--json", "--heatmap", "map.png"]).json();
    let number = |key: &str| json[key].as_f64().unwrap();
    let expected = (0.01 / (0.16 + 0.01) + 0.0025 / (0.04 + 0.01)) / 3.0;
    assert!((number("relmse") - expected).abs() < 1e-6 && (number("relmse_trimmed") - expected).abs() < 1e-6, "{json}");
    assert!(number("flip_mean") > 0.0 && (number("flip_mean") - number("flip_p99")).abs() < 1e-6, "{json}");
    assert!((number("mean_a") - (0.5 + 0.25 + 0.25) / 3.0).abs() < 1e-6, "{json}");
    assert!((number("mean_b") - (0.4 + 0.2 + 0.25) / 3.0).abs() < 1e-6, "{json}");
    let map = image::open(place.path("map.png")).unwrap();
    assert_eq!((map.width(), map.height()), (96, 8 + 16));

    let over = place.run(&["compare", "a.exr", "b.exr", "--limit", "relmse=1%", "--limit", "flip_mean=1"]);
    assert_eq!(over.code, Some(1), "{}", over.err);
    assert!(over.out.contains("relmse: ") && over.out.contains("is over 0.0001"), "{}", over.out);
    assert!(!over.out.contains("flip_mean: "), "{}", over.out);
    let json = place.run(&["compare", "a.exr", "b.exr", "--limit", "relmse=1%", "--limit", "flip_mean=1", "--json"]);
    assert_eq!(json.code, Some(1));
    assert_eq!((&json.json()["limits"][0]["holds"], &json.json()["limits"][1]["holds"]), (&false.into(), &true.into()));
}

#[test]
fn compare_takes_the_picture_of_a_file_with_layers_and_pictures_of_a_display() {
    let place = Place::new();
    for (name, words) in [("layers.exr", &["--aov", "albedo,normal,variance"][..]), ("plain.exr", &[]), ("plain.png", &[])] {
        assert_eq!(place.render(&[words, &["--spp", "4", "--out", name][..]].concat()).code, Some(0));
    }
    let json = place.run(&["compare", "layers.exr", "plain.exr", "--json"]).json();
    assert_eq!((&json["relmse"], &json["width"]), (&0.0.into(), &32.into()), "{json}");
    // What the display shows of radiance is what the PNG holds, up to the rounding of its bytes.
    let json = place.run(&["compare", "plain.exr", "plain.png", "--json"]).json();
    assert!(json["flip_mean"].as_f64().unwrap() < 0.02, "{json}");
    let shifted = place.run(&["compare", "plain.exr", "plain.png", "--exposure", "1", "--json"]).json();
    assert!(shifted["flip_mean"].as_f64().unwrap() > 0.05, "{shifted}");
}

#[test]
fn converge_writes_the_curve_in_three_formats() {
    let place = Place::new();
    let curve = |words: &[&str]| {
        let scene = ["converge", "--scene", "scenes/quad.json", "--size", "32x32", "--spp-max", "64", "--set", "roughness=0.2"];
        let run = place.run(&[&scene[..], words].concat());
        assert_eq!(run.code, Some(0), "{}", run.err);
        run
    };
    let run = curve(&["--out", "a.json", "--json"]);
    assert_eq!(run.err, "");
    assert_eq!(fs::read_to_string(place.path("a.json")).unwrap(), run.out, "the file holds what is printed");
    let json = run.json();
    let rows = json["rows"].as_array().unwrap();
    let spp: Vec<u64> = rows.iter().map(|row| row["spp"].as_u64().unwrap()).collect();
    assert_eq!(spp, [1, 4, 8, 16, 32, 64]);
    let values = |key: &str| rows.iter().map(|row| row[key].as_f64().unwrap_or(f64::NAN)).collect::<Vec<_>>();
    assert!(values("seconds").is_sorted() && values("seconds")[0] > 0.0, "{json}");
    let errors = values("relmse");
    assert!(errors[5] < 0.2 * errors[1] && errors[5] > 0.0, "{errors:?}");
    assert!(values("flip")[5] < values("flip")[0] && values("relmse_trimmed")[1] <= errors[1], "{json}");
    // The renderer's own estimate tells the same as the comparison; one sample has none.
    assert!(rows[0]["relmse_estimate"].is_null());
    let ratio = values("relmse_estimate")[5] / errors[5];
    assert!((0.5..2.0).contains(&ratio), "{ratio}: {json}");
    let reference = &json["reference"];
    assert_eq!((&reference["kind"], &reference["spp"], &reference["is_subtracted"]), (&"own".into(), &512.into(), &true.into()));
    assert!(reference["seed"] != json["seed"] && reference["relmse_of_reference"].as_f64().unwrap() < 0.3 * errors[5], "{json}");
    assert!(json["slope"].as_f64().unwrap() >= 0.8 && json["targets"][1]["relmse"] == 0.001, "{json}");

    let text = curve(&["--out", "a.csv", "--threads", "1"]).out;
    assert!(text.contains("relMSE 0.001: ") && text.contains("a.csv"), "{text}");
    let csv = fs::read_to_string(place.path("a.csv")).unwrap();
    assert_eq!(csv.lines().count(), 7);
    let fields = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<_>>();
    let last = fields(csv.lines().last().unwrap());
    assert_eq!(fields(csv.lines().next().unwrap()).len(), last.len());
    let error: f64 = last[6].parse().unwrap();
    assert!(last[2] == "64" && (error / errors[5] - 1.0).abs() < 1e-12, "threads change nothing but seconds: {error} {errors:?}");

    curve(&["--out", "a.html"]);
    let html = fs::read_to_string(place.path("a.html")).unwrap();
    for text in
        ["<svg", "role=\"img\"", "<title id=", "<desc id=", "class=\"band\"", "<table>", "Slope", "prefers-color-scheme: dark"]
    {
        assert!(html.contains(text), "{text}");
    }
    for text in ["http:", "https:", "src=", "<link", "@import", "<script", "NaN", "inf"] {
        assert!(!html.contains(text), "{text}: the page needs nothing beside itself");
    }
    assert_eq!(html.matches("<tr>").count(), 7);
}

#[test]
fn converge_takes_a_reference_from_a_file() {
    let place = Place::new();
    let render = |name: &str, words: &[&str]| {
        assert_eq!(place.render(&[words, &["--spp", "256", "--out", name][..]].concat()).code, Some(0));
    };
    let curve = |reference: &str| {
        let words = ["converge", "--scene", "scenes/quad.json", "--size", "32x32", "--spp-max", "32", "--json"];
        let run = place.run(&[&words[..], &["--reference", reference]].concat());
        assert_eq!(run.code, Some(0), "{}", run.err);
        (run.json(), run.err)
    };
    render("with.exr", &["--seed", "9", "--aov", "variance"]);
    render("without.exr", &["--seed", "9"]);
    render("same.exr", &["--aov", "variance"]);
    let last = |json: &Value| json["rows"][4]["relmse"].as_f64().unwrap();
    let (with, err) = curve("with.exr");
    assert_eq!(err, "");
    let reference = &with["reference"];
    assert_eq!((&reference["kind"], &reference["seed"], &reference["spp"]), (&"file".into(), &9.into(), &256.into()), "{with}");
    let (without, err) = curve("without.exr");
    assert!(err.contains("without.exr") && err.contains("variance"), "{err}");
    assert_eq!(without["reference"]["is_subtracted"], false);
    assert!(last(&with) < last(&without), "the noise of the reference is taken off");
    let (same, err) = curve("same.exr");
    assert!(err.contains("same.exr") && err.contains("seed 0"), "{err}");
    assert!(last(&same) < last(&with));
}

#[cfg(unix)]
#[test]
fn an_interrupted_curve_exits_with_130_and_leaves_nothing() {
    let place = Place::new();
    let before = place.names();
    let words = ["converge", "--scene", "scenes/quad.json", "--seconds", "600", "--out", "a.html"];
    let mut command = place.command();
    let command = command.args(words).stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::piped());
    let mut child = command.spawn().unwrap();
    std::thread::sleep(std::time::Duration::from_millis(1500));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let code = child.wait().unwrap().code();
    let run: Run = child.wait_with_output().unwrap().into();
    assert_eq!((code, run.out.as_str()), (Some(130), ""), "{}", run.err);
    assert_eq!(place.names(), before);
}

//! Contact sheets and packs of a library.

use super::{Place, Run};
use serde_json::Value;
use std::fs;

/// Four materials in two groups, one with an image, and small pictures that cost nothing.
fn place() -> Place {
    let place = Place::new();
    for (number, group) in ["metals", "metals", "woods", "woods"].iter().enumerate() {
        let text = format!(
            "{{\"name\": \"Clay {number}\", \"provenance\": {{\"source\": \"me\", \"licence\": \"MIT\"}}, \"properties\": {{\"roughness\": 0.{number}5}}}}"
        );
        place.write(&format!("library/{group}/clay{number}.asm.ron"), &text);
    }
    let textured = "{\"name\": \"<b>Tag</b>\", \"properties\": {\"roughness\": {\"texture\": {\"path\": \"../maps/grey.png\"}}}}";
    place.write("library/woods/textured.asm.ron", textured);
    fs::create_dir(place.path("library/maps")).unwrap();
    image::GrayImage::from_pixel(2, 2, image::Luma([90])).save(place.path("library/maps/grey.png")).unwrap();
    place
}

fn run(place: &Place, what: &str, words: &[&str]) -> Run {
    let quick =
        ["library", what, "library", "--mesh", "sphere", "--environment", "white-furnace", "--size", "16", "--error", "30%"];
    place.command().env("BURNISH_HOME", place.path("home")).args([&quick[..], words].concat()).output().unwrap().into()
}

fn rows(run: &Run) -> Vec<Value> {
    run.json()["rows"].as_array().unwrap().clone()
}

#[test]
fn a_sheet_is_a_page_a_picture_or_both() {
    let place = place();
    let bare = run(&place, "sheet", &["--no-render", "--json"]);
    assert_eq!((bare.code, &bare.json()["made"], &bare.json()["shown"]), (Some(0), &0.into(), &5.into()), "{}", bare.err);
    assert!(rows(&bare).iter().all(|row| row["state"] == "missing" && row["seconds"].is_null()));
    let page = fs::read_to_string(place.path("contact-sheet.html")).unwrap();
    assert_eq!((page.matches("no picture").count(), page.matches("data:image").count()), (5, 0));

    let both = run(&place, "sheet", &["--out", "a.html", "--out", "a.png", "--title", "My & clay", "--columns", "2", "--json"]);
    assert_eq!((both.code, &both.json()["made"]), (Some(0), &5.into()), "{}", both.err);
    for row in rows(&both) {
        assert!(row["hash"].as_str().is_some_and(|hash| hash.len() == 32) && row["state"] == "fresh", "{row}");
        assert!(row["path"].is_string() && row["seconds"].is_number() && row["relmse_estimate"].is_number(), "{row}");
    }
    let page = fs::read_to_string(place.path("a.html")).unwrap();
    assert_eq!((page.matches("data:image/jpeg").count(), page.matches("<b>").count()), (5, 0));
    assert!(page.contains("My &amp; clay") && page.contains("5 materials in 2 groups") && page.contains("no licence stated"));
    let picture = image::open(place.path("a.png")).unwrap().into_rgb8();
    assert!(picture.width() == 2 * 28 + 2 * 104 + 18 && picture.height() > 200, "{:?}", picture.dimensions());

    // What is there is not made again; what cannot be used is told and left out.
    place.write("library/broken.asm.ron", "{\"properties\": ");
    let found = run(&place, "sheet", &["--out", "b.html", "--search", "rough<0.2", "--json"]);
    assert_eq!((found.code, &found.json()["made"], rows(&found).len()), (Some(0), &0.into(), 2), "{}", found.err);
    let broken = run(&place, "sheet", &["--out", "b.html"]);
    assert_eq!(broken.code, Some(1), "{}", broken.err);
    assert!(
        broken.out.contains("broken.asm.ron: line 1")
            && broken.out.contains("b.html: 5 materials, 0 pictures made, 1 that cannot be shown")
    );

    for (words, expected) in [
        (&["--out", "a.pdf"][..], "--out: a.pdf: expected a file name that ends in .html or .png"),
        (&["--out", "none/a.png"], "none/a.png"),
        (&["--search", "gold"], "--search: nothing in this library matches"),
        (&["--search", "rough<x"], "--search: `rough<x`: expected a number"),
    ] {
        let run = run(&place, "sheet", words);
        assert_eq!((run.code, run.out.as_str()), (Some(2), ""), "{words:?}");
        assert!(run.err.contains(expected) && run.err.lines().count() == 1, "{words:?}: {}", run.err);
    }
}

#[test]
fn a_pack_is_made_unless_there_are_errors() {
    let place = place();
    let packed = run(&place, "pack", &["--out", "pack", "--name", "Clays", "--json"]);
    assert_eq!(packed.code, Some(0), "{}", packed.err);
    let json = packed.json();
    let counts = ["materials", "images", "files", "made"].map(|key| json[key].as_u64().unwrap());
    assert_eq!((counts, &json["check"]["errors"], rows(&packed).len()), ([5, 1, 30, 5], &0.into(), 5), "{json}");
    assert_eq!(json["formats"], serde_json::json!(["usd", "materialx", "gltf"]));
    for file in ["usd/clay0.usda", "usd/grey.png", "materialx/textured.mtlx", "gltf/clay3.gltf", "losses.json"] {
        assert!(place.path("pack").join(file).is_file(), "{file}");
    }
    assert!(fs::read_to_string(place.path("pack/LICENCES.md")).unwrap().contains("## No licence stated (1)"));
    // The pack is a library itself.
    let again =
        place.command().env("BURNISH_HOME", place.path("home")).args(["library", "check", "pack/materials"]).output().unwrap();
    assert_eq!(Run::from(again).code, Some(0));

    place.write("library/bad.asm.ron", "{\"properties\": {\"roughness\": 1.5}}");
    let before = place.names();
    let refused = run(&place, "pack", &["--out", "other"]);
    assert_eq!((refused.code, place.names()), (Some(1), before), "{}", refused.err);
    assert!(
        refused.out.contains("bad.asm.ron: error: roughness") && refused.err.contains("--allow-errors"),
        "{}{}",
        refused.out,
        refused.err
    );
    let refused = run(&place, "pack", &["--out", "other", "--json"]);
    assert_eq!((refused.code, &refused.json()["is_packed"]), (Some(1), &false.into()), "{}", refused.err);
    let allowed = run(&place, "pack", &["--out", "pack", "--allow-errors", "--no-render", "--formats", "none"]);
    assert_eq!(allowed.code, Some(0), "{}", allowed.err);
    assert!(
        allowed.out.contains("pack: packed; materials: 6, images: 1, files: 12, pictures made: 0; check: 6 files, 1 error"),
        "{}",
        allowed.out
    );

    let taken = run(&place, "pack", &["--out", "scenes", "--allow-errors"]);
    assert_eq!((taken.code, taken.err.lines().count()), (Some(2), 1), "{}", taken.err);
    assert!(
        taken.err.contains("--out: ") && taken.err.contains("scenes: expected nothing there or an older pack"),
        "{}",
        taken.err
    );
}

#[cfg(unix)]
#[test]
fn an_interruption_keeps_the_pictures_and_leaves_nothing_half() {
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};
    let place = place();
    for (what, out) in [("sheet", "late.html"), ("pack", "late")] {
        let before = place.names();
        let words =
            ["library", what, "library", "--out", out, "--pictures", "pictures", "--json", "--mesh", "sphere", "--size", "32"];
        let rules = ["--error", "1e-12", "--time-limit", "0.5", "--seed", if what == "sheet" { "1" } else { "2" }];
        let mut command = place.command();
        command.env("BURNISH_HOME", place.path("home")).args(words).args(rules).stdout(Stdio::piped()).stderr(Stdio::piped());
        let child = command.spawn().unwrap();
        let pictures = || -> usize {
            let names = fs::read_dir(place.path("pictures")).into_iter().flatten().map(|entry| entry.unwrap().file_name());
            names.filter(|name| name.to_str().unwrap().ends_with(".png")).count()
        };
        let (had, start) = (pictures(), Instant::now());
        while pictures() == had {
            assert!(start.elapsed() < Duration::from_secs(60), "no pictures come");
            std::thread::sleep(Duration::from_millis(5));
        }
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        let ended = Run::from(child.wait_with_output().unwrap());
        assert_eq!(ended.code, Some(130), "{}", ended.err);
        assert!(ended.err.contains("pictures were made and are kept") && pictures() > had, "{}", ended.err);
        assert_eq!(ended.json()["made"].as_u64(), Some((pictures() - had) as u64));
        let after: Vec<String> =
            place.names().into_iter().filter(|name| !["pictures", "home"].contains(&name.as_str())).collect();
        assert_eq!(after, before.into_iter().filter(|name| !["pictures", "home"].contains(&name.as_str())).collect::<Vec<_>>());
    }
}

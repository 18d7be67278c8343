//! Folders as libraries: what is in them, and small pictures of it, also in parts and after an interruption.

use super::{Place, Run};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Nine materials, one of them twice, and one file that is none.
fn place() -> Place {
    let place = Place::new();
    for number in 0..8 {
        let text =
            format!("{{\"name\": \"Clay {number}\", \"tags\": [\"clay\"], \"properties\": {{\"roughness\": 0.{number}5}}}}");
        place.write(&format!("library/group{}/clay{number}.asm.ron", number % 2), &text);
    }
    place.write("library/twin.asm.ron", "{\"name\": \"Twin\", \"properties\": {\"roughness\": 0.35}}");
    place.write("library/broken.asm.ron", "{\"properties\": ");
    place
}

/// A program that keeps nothing outside the place.
fn command(place: &Place) -> Command {
    let mut command = place.command();
    command.env("BURNISH_HOME", place.path("home"));
    command
}

fn run(place: &Place, words: &[&str]) -> Run {
    command(place).args(words).output().unwrap().into()
}

/// Makes tiny pictures into a folder.
fn make(place: &Place, out: &str, words: &[&str]) -> Run {
    let scene = ["library", "thumbnails", "library", "--json", "--out", out];
    let quick = ["--mesh", "sphere", "--environment", "white-furnace", "--size", "16"];
    let error: &[&str] = if words.contains(&"--error") { &[] } else { &["--error", "20%"] };
    run(place, &[&scene[..], &quick, error, words].concat())
}

fn rows(run: &Run) -> Vec<Value> {
    run.json()["rows"].as_array().unwrap().clone()
}

fn pictures(folder: &Path) -> BTreeSet<PathBuf> {
    fs::read_dir(folder).map(|entries| entries.map(|entry| entry.unwrap().file_name().into()).collect()).unwrap_or_default()
}

#[test]
fn a_library_is_listed_and_only_changes_are_read() {
    let place = place();
    let listed = run(&place, &["library", "index", "library", "--json"]);
    assert_eq!((listed.code, listed.err.as_str()), (Some(1), ""), "a file is broken");
    let json = listed.json();
    assert_eq!((&json["files"], &json["read"], &json["broken"]), (&10.into(), &10.into(), &1.into()));
    for row in rows(&listed) {
        assert!(row["hash"].as_str().is_some_and(|hash| hash.len() == 32) && row["state"] == "missing", "{row}");
        let is_broken = row["path"] == "broken.asm.ron";
        assert_eq!(row["problem"].as_str().is_some_and(|problem| problem.contains("line 1")), is_broken, "{row}");
    }
    // Files that are some seconds old are not read again.
    for row in rows(&listed) {
        let file = fs::File::options().write(true).open(place.path("library").join(row["path"].as_str().unwrap())).unwrap();
        file.set_modified(std::time::SystemTime::now() - std::time::Duration::from_secs(60)).unwrap();
    }
    run(&place, &["library", "index", "library"]);
    let found = run(&place, &["library", "index", "library", "--json", "--search", "clay rough>0.5 -group:group1"]);
    assert_eq!(found.json()["read"], 0);
    let names: Vec<String> = rows(&found).iter().map(|row| row["name"].as_str().unwrap().to_owned()).collect();
    assert_eq!(names, ["Clay 6"]);

    let text = run(&place, &["library", "index", "library"]);
    assert!(text.out.contains("broken.asm.ron: line 1") && text.out.contains("twin.asm.ron: Twin (missing)"), "{}", text.out);
    for (words, expected) in [
        (vec!["library", "index", "none"], "none: expected a folder"),
        (vec!["library", "index", "red.asm.ron"], "red.asm.ron: expected a folder"),
        (vec!["library", "index", "env"], "env: expected .asm.ron files"),
        (vec!["library", "index", "library", "--search", "clay rough<x"], "--search: `rough<x`: expected a number"),
        (vec!["library", "thumbnails", "library", "--shard", "3/2"], "K/N"),
        (vec!["library", "thumbnails", "library", "--only", "old"], "missing, stale or fresh"),
        (vec!["library", "thumbnails", "library", "--size", "0"], "WIDTHxHEIGHT"),
        (vec!["library", "thumbnails", "library", "--error", "-1"], "relMSE above 0"),
        (vec!["library", "thumbnails", "library", "--out", "red.asm.ron", "--size", "8"], "red.asm.ron: cannot be written"),
    ] {
        let run = run(&place, &words);
        assert_eq!(run.code, Some(2), "{words:?}: {}", run.err);
        assert!(run.err.contains(expected) && run.err.lines().count() == 1, "{words:?}: {}", run.err);
    }
}

#[test]
fn parts_of_a_library_are_put_together_by_copying() {
    let place = place();
    let mut paths = BTreeSet::new();
    for part in 1..=3 {
        let out = format!("part{part}");
        let made = make(&place, &out, &["--shard", &format!("{part}/3")]);
        let rows = rows(&made);
        let has_broken = rows.iter().any(|row| !row["problem"].is_null());
        assert_eq!(made.code, Some(i32::from(has_broken)), "{}", made.err);
        for row in rows {
            assert!(paths.insert(row["path"].as_str().unwrap().to_owned()), "{row} is in two parts");
            if row["problem"].is_null() {
                assert_eq!(row["state"], "fresh");
                assert!(Path::new(row["file"].as_str().unwrap()).starts_with(&out));
                assert!(row["seconds"].is_null() || row["relmse_estimate"].as_f64().is_some_and(|relmse| relmse < 0.04), "{row}");
            }
        }
        for name in pictures(&place.path(&out)) {
            assert_eq!(image::open(place.path(&out).join(&name)).unwrap().width(), 16);
            fs::create_dir_all(place.path("all")).unwrap();
            assert!(!place.path("all").join(&name).exists(), "two parts have made {}", name.display());
            fs::copy(place.path(&out).join(&name), place.path("all").join(&name)).unwrap();
        }
    }
    assert_eq!(paths.len(), 10);
    assert_eq!(pictures(&place.path("all")).len(), 8, "twins look the same and share a picture");
    let again = make(&place, "all", &[]);
    assert_eq!((again.json()["made"].as_u64(), again.code), (Some(0), Some(1)), "{}", again.err);
    // The same picture comes from another machine.
    assert_eq!(make(&place, "whole", &[]).json()["made"], 8);
    for name in pictures(&place.path("all")) {
        assert!(fs::read(place.path("all").join(&name)).unwrap() == fs::read(place.path("whole").join(&name)).unwrap());
    }

    // A tag cannot be seen, a value can.
    place.write("library/twin.asm.ron", "{\"name\": \"Twin\", \"tags\": [\"new\"], \"properties\": {\"roughness\": 0.35}}");
    assert_eq!(make(&place, "all", &[]).json()["made"], 0);
    place.write("library/twin.asm.ron", "{\"name\": \"Twin\", \"properties\": {\"roughness\": 0.36}}");
    let stale = make(&place, "all", &["--only", "stale"]);
    let made: Vec<Value> = rows(&stale).into_iter().filter(|row| !row["seconds"].is_null()).collect();
    assert!(made.len() == 1 && made[0]["path"] == "twin.asm.ron" && made[0]["state_before"] == "stale", "{made:?}");
    // Other quality, other pictures.
    assert_eq!(make(&place, "all", &["--error", "30%"]).json()["made"], 9);
    // A whole scene instead of a mesh: its lengths stand as they are, its size holds.
    let scene = ["library", "thumbnails", "library", "--json", "--out", "scene", "--scene", "scenes/quad.json", "--error", "50%"];
    assert_eq!(run(&place, &scene).json()["made"], 9);
    let sizes = pictures(&place.path("scene")).into_iter().map(|name| image::open(place.path("scene").join(name)).unwrap());
    assert!(sizes.map(|picture| (picture.width(), picture.height())).all(|size| size == (24, 16)));
    let limited = make(&place, "limited", &["--error", "1e-12", "--time-limit", "0.05", "--shard", "1/3"]).json();
    assert!(limited["limited"].as_array().unwrap().len() == limited["made"].as_u64().unwrap() as usize, "{limited}");
}

#[cfg(unix)]
#[test]
fn an_interruption_keeps_all_pictures_but_the_one_in_work() {
    use std::process::Stdio;
    use std::time::{Duration, Instant};
    let place = place();
    let mut words = vec!["library", "thumbnails", "library", "--json", "--out", "out", "--mesh", "sphere"];
    words.extend(["--size", "32", "--error", "1e-12", "--time-limit", "0.5"]);
    let child = command(&place).args(&words).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let start = Instant::now();
    while pictures(&place.path("out")).iter().filter(|name| name.extension().is_some_and(|e| e == "png")).count() < 2 {
        assert!(start.elapsed() < Duration::from_secs(60), "no pictures come");
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let ended = Run::from(child.wait_with_output().unwrap());
    assert_eq!(ended.code, Some(130), "{}", ended.err);
    let kept = pictures(&place.path("out"));
    let made = ended.json()["made"].as_u64().unwrap();
    assert!(ended.json()["is_interrupted"] == true && made >= 2 && kept.len() as u64 == made, "{made} {kept:?}");
    assert!(ended.err.contains("are kept"), "{}", ended.err);
    for name in kept {
        assert_eq!(image::open(place.path("out").join(name)).unwrap().width(), 32);
    }
}

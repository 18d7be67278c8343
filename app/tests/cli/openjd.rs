//! The templates of `app/farm`, run by the reference program of Open Job Description: what many tasks make is what one process makes.
//!
//! `BURNISH_OPENJD` names the program, else it is looked for on the path. Without it nothing is tested, which is an error where
//! `BURNISH_REQUIRE_OPENJD` is set.

use super::{Place, Run};
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

fn program() -> OsString {
    std::env::var_os("BURNISH_OPENJD").filter(|path| !path.is_empty()).unwrap_or_else(|| "openjd".into())
}

/// Whether there is an `openjd`; says so if not.
fn is_there() -> bool {
    let found = Command::new(program()).arg("--version").output().is_ok_and(|output| output.status.success());
    let is_required = std::env::var_os("BURNISH_REQUIRE_OPENJD").is_some_and(|value| !value.is_empty() && value != "0");
    assert!(found || !is_required, "BURNISH_REQUIRE_OPENJD is set, and there is no program `openjd` (PyPI: openjd-cli)");
    if !found {
        // Not by a macro, whose output a test that passes does not show.
        let sentence = b"SKIPPED: there is no program `openjd` (PyPI: openjd-cli); BURNISH_OPENJD may name it\n";
        std::io::stderr().write_all(sentence).unwrap();
    }
    found
}

fn template(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("farm").join(name)
}

/// Checks a template, and runs tasks of its only step with these parameters: the one that is named, or all.
fn run(place: &Place, name: &str, step: &str, parameters: &[String], task: Option<&str>) -> Run {
    let mut command = Command::new(program());
    command.current_dir(place.folder.path()).env("BURNISH_HOME", place.path("home")).env("TMPDIR", place.folder.path());
    command.arg("run").arg(template(name)).args(["--step", step]);
    command.arg("-p").arg(format!("Burnish={}", env!("CARGO_BIN_EXE_burnish")));
    parameters.iter().for_each(|parameter| _ = command.args(["-p", parameter]));
    if let Some(number) = task {
        command.args(["--tasks", &format!("[{{\"Shard\": \"{number}\"}}]")]);
    }
    command.output().unwrap().into()
}

/// Files with an ending in a folder, by name.
fn files(folder: &Path, ending: &str) -> BTreeMap<OsString, Vec<u8>> {
    let paths = fs::read_dir(folder).into_iter().flatten().map(|entry| entry.unwrap().path());
    let chosen = paths.filter(|path| path.extension().is_some_and(|found| found == ending));
    chosen.map(|path| (path.file_name().unwrap().to_owned(), fs::read(path).unwrap())).collect()
}

#[test]
fn templates_are_valid() {
    if !is_there() {
        return;
    }
    for name in ["thumbnails.yaml", "turntable.yaml"] {
        let checked = Run::from(Command::new(program()).arg("check").arg(template(name)).output().unwrap());
        assert_eq!(checked.code, Some(0), "{name}: {}{}", checked.out, checked.err);
    }
}

#[test]
fn four_tasks_make_the_pictures_of_one_process() {
    if !is_there() {
        return;
    }
    let place = Place::new();
    for number in 0..10 {
        place.write(
            &format!("library/group{}/m{number}.asm.ron", number % 3),
            &format!("{{\"name\": \"Made {number}\", \"properties\": {{\"roughness\": 0.{number}5}}}}"),
        );
    }
    let words = ["library", "thumbnails", "library", "--out", "whole", "--mesh", "sphere", "--environment", "white-furnace"];
    let whole =
        place.command().env("BURNISH_HOME", place.path("home")).args(words).args(["--size", "16", "--error", "30%"]).output();
    let whole = Run::from(whole.unwrap());
    assert_eq!(whole.code, Some(0), "{}", whole.err);
    let whole = files(&place.path("whole"), "png");
    assert_eq!(whole.len(), 10);

    let parameters = |out: &str| -> Vec<String> {
        let paths = [("Library", "library"), ("Out", out)].map(|(key, name)| format!("{key}={}", place.path(name).display()));
        let rest = ["Mesh=sphere", "Environment=white-furnace", "Size=16", "Error=30%", "Shards=4"].map(str::to_owned);
        paths.into_iter().chain(rest).collect()
    };
    // All tasks into one folder.
    let all = run(&place, "thumbnails.yaml", "Thumbnails", &parameters("shared"), None);
    assert_eq!(all.code, Some(0), "{}{}", all.out, all.err);
    assert!(files(&place.path("shared"), "png") == whole, "other pictures than those of one process");

    // Each on a machine of its own, of which one fails: a file lies where its folder should be.
    fs::write(place.path("part3"), "in the way").unwrap();
    let task = |number: &str| run(&place, "thumbnails.yaml", "Thumbnails", &parameters(&format!("part{number}")), Some(number));
    let (mut merged, mut count) = (BTreeMap::new(), 0);
    for number in ["1", "2", "3", "4"] {
        let mut done = task(number);
        if number == "3" {
            assert!(done.code != Some(0) && done.out.contains("part3"), "{:?}: {}{}", done.code, done.out, done.err);
            fs::remove_file(place.path("part3")).unwrap();
            done = task(number);
        }
        assert_eq!(done.code, Some(0), "{number}: {}{}", done.out, done.err);
        let made = files(&place.path(&format!("part{number}")), "png");
        count += made.len();
        merged.extend(made);
    }
    assert!(count == 10 && merged == whole, "{count} pictures in all parts, and those of one process differ");
}

#[test]
fn tasks_of_a_turntable_make_the_frames_of_one_process() {
    if !is_there() {
        return;
    }
    let place = Place::new();
    let rules = ["--mesh=sphere", "--environment=white-furnace", "--size=16x16", "--frames=5", "--error=30%", "--time=90"];
    let whole = place.command().args(["turntable", "red.asm.ron", "--out=whole"]).args(rules).output().unwrap();
    assert_eq!(Run::from(whole).code, Some(0));
    let paths = [("Material", "red.asm.ron"), ("Out", "out")].map(|(key, name)| format!("{key}={}", place.path(name).display()));
    let rest = ["Mesh=sphere", "Environment=white-furnace", "Size=16x16", "Frames=5", "Error=30%", "Shards=4"].map(str::to_owned);
    let parameters: Vec<String> = paths.into_iter().chain(rest).collect();
    let all = run(&place, "turntable.yaml", "Frames", &parameters, None);
    assert_eq!(all.code, Some(0), "{}{}", all.out, all.err);
    let frames = files(&place.path("whole"), "png");
    assert!(frames.len() == 5 && files(&place.path("out"), "png") == frames);
    // One that was lost comes back alone.
    fs::remove_file(place.path("out/frame_0002.png")).unwrap();
    let again = run(&place, "turntable.yaml", "Frames", &parameters, Some("2"));
    assert_eq!(again.code, Some(0), "{}{}", again.out, again.err);
    assert!(files(&place.path("out"), "png") == frames);
}

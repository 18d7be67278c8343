//! Image sequences: named, resumed, divided, and the same bits whichever way they were made.

use super::{Place, Run};
use std::fs;

const SCENE: &[&str] = &["turntable", "--scene", "scenes/quad.json", "--size", "24x20"];

fn turntable(place: &Place, words: &[&str]) -> Run {
    place.run(&[SCENE, words].concat())
}

fn frames(place: &Place, folder: &str) -> Vec<(String, Vec<u8>)> {
    let entries = fs::read_dir(place.path(folder)).unwrap().map(|entry| entry.unwrap().path());
    let pictures = entries.filter(|path| path.extension().is_some_and(|e| e == "png" || e == "exr"));
    let mut frames: Vec<_> =
        pictures.map(|path| (path.file_name().unwrap().to_str().unwrap().to_owned(), fs::read(path).unwrap())).collect();
    frames.sort();
    frames
}

#[test]
fn frames_have_rows_and_are_jobs_of_their_own() {
    let place = Place::new();
    for (turn, format) in [("object", "exr"), ("light", "png")] {
        let run =
            turntable(&place, &["--out", turn, "--frames", "4", "--turn", turn, "--format", format, "--spp", "6", "--json"]);
        assert_eq!(run.code, Some(0), "{}", run.err);
        assert!(run.err.contains("probe frames: 4 frames take about"), "{}", run.err);
        let json = run.json();
        let rows = json["frames"].as_array().unwrap();
        assert_eq!(rows.len(), 4);
        for (i, row) in rows.iter().enumerate() {
            assert_eq!(row["file"], format!("frame_{:04}.{format}", i + 1));
            assert_eq!((&row["stop_reason"], row["seconds"].as_f64() > Some(0.0)), (&"spp".into(), true));
            assert!(row["relmse_estimate"].as_f64().is_some(), "{row}");
        }
        assert!(json["time_limited"].as_array().unwrap().is_empty() && !json["prediction"][0].is_null(), "{json}");
        let made = frames(&place, turn);
        assert_eq!(made.len(), 4);
        assert!(made.windows(2).all(|pair| pair[0].1 != pair[1].1), "{turn}: frames differ");
        assert!(
            !fs::read_dir(place.path(turn)).unwrap().any(|entry| entry
                .unwrap()
                .path()
                .extension()
                .is_some_and(|e| e == "samples"))
        );
        // A frame is a picture like others.
        let (frame, again) = (format!("{turn}/{}", made[2].0), format!("{turn}/again.{format}"));
        let run = place.run(&["render", &frame, "--out", &again]);
        assert_eq!(run.code, Some(0), "{}", run.err);
        assert!(fs::read(place.path(&again)).unwrap() == made[2].1, "{turn}");
    }
}

#[test]
fn frames_that_stopped_short_go_on_to_the_same_bits() {
    let place = Place::new();
    // Far more samples than any machine makes in a hundredth of a second.
    let words = ["--frames", "3", "--error", "0.2%", "--format", "exr", "--probe", "0"];
    let through = turntable(&place, &[&words[..], &["--out", "through"]].concat());
    assert_eq!(through.code, Some(0), "{}", through.err);
    let short = turntable(&place, &[&words[..], &["--out", "parts", "--time", "0.01", "--json"]].concat());
    assert_eq!(short.code, Some(0), "{}", short.err);
    let json = short.json();
    let limited = json["time_limited"].as_array().unwrap();
    assert!(!limited.is_empty(), "{json}");
    for file in limited {
        let stored = place.path("parts").join(file.as_str().unwrap()).with_extension("samples");
        assert!(stored.is_file());
    }
    let again = turntable(&place, &[&words[..], &["--out", "parts", "--time", "0.01"]].concat());
    assert_eq!(again.code, Some(2));
    assert!(again.err.contains("--resume"), "{}", again.err);
    for (word, value) in [("--seed", "5"), ("--degrees", "90"), ("--fov", "20"), ("--set", "roughness=1")] {
        let other = turntable(&place, &[&words[..], &["--out", "parts", "--resume", word, value]].concat());
        assert_eq!((other.code, other.err.trim().lines().count()), (Some(2), 1), "{}", other.err);
        assert!(other.err.contains("was begun with another"), "{}", other.err);
    }
    let on = turntable(&place, &[&words[..], &["--out", "parts", "--resume", "--json"]].concat());
    assert_eq!(on.code, Some(0), "{}", on.err);
    assert!(on.json()["frames"].as_array().unwrap().iter().all(|row| row["stop_reason"] == "error"), "{}", on.out);
    // The frames also hold the rules; pixels and samples are the same.
    for (name, _) in frames(&place, "through") {
        let [a, b] = ["through", "parts"].map(|folder| pixels(&place, &format!("{folder}/{name}")));
        assert!(a == b, "{name}");
    }
    assert!(!place.path("parts/frame_0001.samples").exists());
    // Nothing is left to do.
    let before = frames(&place, "parts");
    assert_eq!(turntable(&place, &[&words[..], &["--out", "parts", "--resume"]].concat()).code, Some(0));
    assert!(frames(&place, "parts") == before);
}

fn pixels(place: &Place, name: &str) -> Vec<Vec<f32>> {
    let image = exr::prelude::read_first_flat_layer_from_file(place.path(name)).unwrap();
    image.layer_data.channel_data.list.iter().map(|channel| channel.sample_data.values_as_f32().collect()).collect()
}

#[test]
fn shards_make_the_frames_of_the_whole() {
    let place = Place::new();
    let words = ["--frames", "5", "--spp", "3", "--probe", "0"];
    assert_eq!(turntable(&place, &[&words[..], &["--out", "whole"]].concat()).code, Some(0));
    for shard in ["1/2", "2/2"] {
        let run = turntable(&place, &[&words[..], &["--out", "parts", "--shard", shard, "--json"]].concat());
        assert_eq!(run.code, Some(0), "{}", run.err);
        assert_eq!(run.json()["frames"].as_array().unwrap().len(), if shard == "1/2" { 3 } else { 2 });
    }
    assert!(frames(&place, "whole") == frames(&place, "parts"));
}

#[cfg(unix)]
#[test]
fn an_interrupted_turntable_keeps_its_frames_and_goes_on() {
    let place = Place::new();
    let words = ["--frames", "4", "--spp", "3000", "--out", "t", "--probe", "0"];
    let mut child = place
        .command()
        .args([SCENE, &words].concat())
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let start = std::time::Instant::now();
    while !place.path("t/frame_0001.png").exists() && start.elapsed().as_secs() < 120 {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    assert!(std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let code = child.wait().unwrap().code();
    let run: Run = child.wait_with_output().unwrap().into();
    assert_eq!((code, run.out.as_str()), (Some(130), ""), "{}", run.err);
    assert!(run.err.contains("of 4 frames") && run.err.contains("--resume"), "{}", run.err);
    let kept = frames(&place, "t");
    assert!(!kept.is_empty() && kept.len() < 4);
    let on = turntable(&place, &[&words[..], &["--resume"]].concat());
    assert_eq!(on.code, Some(0), "{}", on.err);
    let all = frames(&place, "t");
    assert!(all.len() == 4 && kept.iter().all(|frame| all.contains(frame)));
    assert_eq!(turntable(&place, &["--frames", "4", "--spp", "3000", "--out", "u", "--probe", "0"]).code, Some(0));
    assert!(frames(&place, "u") == all, "as if it had not been interrupted");
}

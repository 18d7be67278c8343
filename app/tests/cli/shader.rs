//! `shader`: what is written, and what is said about it.

use super::Place;
use std::fs;

#[test]
fn shader_code_is_written_in_every_language() {
    let place = Place::new();
    for language in ["wgsl", "hlsl", "glsl", "msl", "spirv", "osl"] {
        let file = format!("red.{language}");
        let run = place.run(&["shader", "red.asm.ron", "--lang", language, "--out", &file, "--json"]);
        assert_eq!(run.code, Some(0), "{}", run.err);
        let json = run.json();
        assert_eq!(json["bytes"].as_u64(), Some(fs::metadata(place.path(&file)).unwrap().len()));
        assert_eq!(json["lobes"], serde_json::json!(["specular", "diffuse"]));
        assert!(json["left_out"].as_array().unwrap().contains(&serde_json::json!("coat")));
    }
    let run = place.run(&["shader", "red.asm.ron", "--lang", "WGSL", "--uniform", "--out", "block.wgsl"]);
    assert_eq!((run.code, run.err.as_str()), (Some(0), ""));
    assert!(run.out.contains("block.wgsl") && run.out.contains("specular, diffuse"), "{}", run.out);
    assert!(fs::read_to_string(place.path("block.wgsl")).unwrap().contains("var<uniform>"));
}

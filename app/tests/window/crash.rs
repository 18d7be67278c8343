//! The program is killed while a number is edited; what the recovery store holds then.

use crate::hands::{NUMBER, Window, hands, wait};
use burnish::recovery;
use burnish_material::{MaterialFile, Property, Value};
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

/// How many times the program is killed: a run takes a quarter of a minute, most of it for opening the window. The variable asks for more.
const RUNS: u64 = 2;
const RUNS_VARIABLE: &str = "BURNISH_CRASHES";
/// How old the newest kept state may be when the program dies: the autosave's 3 s, and what writing and slow frames take.
const AGE_MAX: Duration = Duration::from_secs(5);
/// Where the number begins, and what one press of an arrow key adds.
const START: f64 = 1.5;
const STEP: f64 = 0.1;

const MATERIAL: &str = "// Kept as it is.
{ \"asm\": \"4.0\", \"name\": \"Killed\", \"properties\": { \"base_color\": (0.1, 0.4, 0.2), \"specular_ior\": 1.5 } }
";

/// Numbers from 0 to 1 (SplitMix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// How many presses the newest kept state knows of: none if nothing was kept.
fn presses_kept(home: &Path) -> usize {
    let (left, messages) = recovery::left_behind(&home.join("state"));
    assert!(messages.is_empty(), "{messages:?}");
    let Some(kept) = left.iter().flat_map(recovery::Abandoned::documents).next() else { return 0 };
    assert_eq!(kept.original, MATERIAL);
    let (file, warnings) = MaterialFile::parse(&kept.text).expect("what was kept is a material");
    assert!(warnings.is_empty(), "{warnings:?}");
    let Value::Float(value) = file.material().value(Property::specular_ior) else { panic!("a number is expected") };
    let presses = ((value - START) / STEP).round();
    assert!((START + STEP * presses - value).abs() < 1e-6 && presses >= 1.0, "nobody set {value}");
    presses as usize
}

#[test]
fn a_killed_program_loses_at_most_five_seconds() {
    let Some(_hands) = hands() else { return };
    let runs = std::env::var(RUNS_VARIABLE).ok().and_then(|text| text.parse().ok()).unwrap_or(RUNS);
    for run in 0..runs {
        let mut random = Random(run);
        let folder = tempfile::tempdir().unwrap();
        let (home, file) = (folder.path().join("home"), folder.path().join("killed.asm.ron"));
        std::fs::write(&file, MATERIAL).unwrap();
        let window = Window::open(&home, &[&file]);
        window.wait_for_title("Killed");
        window.key("1");
        window.find_rows("ior");
        window.type_into(NUMBER, "1.5");

        let mut pressed: Vec<Instant> = Vec::new();
        let mut press = || {
            pressed.push(Instant::now());
            assert!(Command::new("xdotool").args(["key", "Up"]).status().unwrap().success());
        };
        press();
        wait("the number to change", || window.title().contains('•').then_some(()));
        let end = Instant::now() + Duration::from_secs_f64(0.5 + 8.5 * random.next());
        while Instant::now() < end {
            press();
            std::thread::sleep(Duration::from_secs_f64(0.03 + 0.2 * random.next()));
        }
        let killed = Instant::now();
        window.kill();

        let kept = presses_kept(&home);
        assert!(kept <= pressed.len(), "{kept} presses kept of {}", pressed.len());
        // What was kept was the newest state until the next press.
        let age = pressed.get(kept).map_or(Duration::ZERO, |next| killed.duration_since(*next));
        eprintln!(
            "run {run}: {} presses in {:.1} s, {kept} kept, age {:.2} s",
            pressed.len(),
            killed.duration_since(pressed[0]).as_secs_f64(),
            age.as_secs_f64()
        );
        assert!(age <= AGE_MAX, "run {run}: the newest state kept is {age:?} old");
        assert_eq!(std::fs::read_to_string(&file).unwrap(), MATERIAL, "the file itself is not touched");
    }
}

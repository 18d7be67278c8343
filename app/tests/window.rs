//! The editor's window driven by real input events: drag a slider, see both views follow, save, undo, save, reopen.
//!
//! Needs an X display, `xdotool` and ImageMagick's `import`; `tests/run` provides them and makes their absence a failure.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Longest wait for anything that the window shows: a software adapter on a busy machine is slow.
const PATIENCE: Duration = Duration::from_secs(90);
/// The window's size at start; without a window manager it stands at the display's corner.
const SIZE: (u32, u32) = (1280, 800);
/// Middle of the roughness slider's handle at 0.3, and where it is dragged to.
const ROUGHNESS_FROM: (u32, u32) = (1075, 237);
const ROUGHNESS_TO: (u32, u32) = (1118, 237);
/// A part of each view that shows the ball: left, top, width, height.
const PREVIEW: [u32; 4] = [300, 300, 160, 200];
const FINAL: [u32; 4] = [600, 300, 160, 200];

/// There is one keyboard and one mouse: tests that use them take turns.
static HANDS: Mutex<()> = Mutex::new(());

const MATERIAL: &str = "// Kept as it is.
{
    \"asm\": \"4.0\",
    \"name\": \"Driven\",
    \"properties\": {
        \"base_color\": (0.9, 5e-2, 0.05), // spelled so
        \"roughness\": 3e-1,
        \"of_the_future\": [1, 2],
    },
}
";

fn run(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).stderr(Stdio::null()).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

struct Window {
    child: Child,
    id: String,
}

impl Window {
    fn open(file: &Path) -> Self {
        Self::open_with(file, &[])
    }

    fn open_with(file: &Path, arguments: &[&str]) -> Self {
        let said = file.with_extension("said");
        let child = Command::new(env!("CARGO_BIN_EXE_burnish"))
            .arg(file)
            .args(arguments)
            .current_dir(file.parent().expect("the file is in a folder"))
            .stderr(std::fs::File::create(&said).expect("the folder can be written"))
            .spawn()
            .expect("the program starts");
        let mut window = Self { child, id: String::new() };
        let pid = window.child.id().to_string();
        window.id = wait("a window", || {
            let said = std::fs::read_to_string(&said).unwrap_or_default();
            assert!(!said.contains("instead"), "the window did not open: {said}");
            let found = run("xdotool", &["search", "--onlyvisible", "--pid", &pid])?;
            found.lines().next().map(str::to_owned)
        });
        run("xdotool", &["windowmove", &window.id, "0", "0"]);
        run("xdotool", &["windowsize", &window.id, &SIZE.0.to_string(), &SIZE.1.to_string()]);
        run("xdotool", &["windowfocus", &window.id]);
        window
    }

    fn key(&self, keys: &str) {
        run("xdotool", &["key", "--delay", "60", keys]).expect("keys can be sent");
        std::thread::sleep(Duration::from_millis(500));
    }

    /// Saves again and again until the file's text is as wanted: a key may fall into a slow frame.
    fn save_until(&self, what: &str, file: &Path, is_wanted: impl Fn(&str) -> bool) -> String {
        wait(what, || {
            self.key("ctrl+s");
            std::fs::read_to_string(file).ok().filter(|text| is_wanted(text))
        })
    }

    /// Drags in small steps, as a hand does.
    fn drag(&self, from: (u32, u32), to: (u32, u32)) {
        let place = |(x, y): (u32, u32)| run("xdotool", &["mousemove", &x.to_string(), &y.to_string()]).expect("the mouse moves");
        let pause = || std::thread::sleep(Duration::from_millis(120));
        place(from);
        pause();
        run("xdotool", &["mousedown", "1"]);
        pause();
        for i in 1..=8 {
            place((from.0 + (to.0 - from.0) * i / 8, from.1 + to.1.abs_diff(from.1) * i / 8));
            pause();
        }
        run("xdotool", &["mouseup", "1"]);
    }

    fn picture(&self, folder: &Path) -> Option<image::RgbImage> {
        let file = folder.join("shot.png");
        run("import", &["-window", &self.id, file.to_str()?])?;
        image::open(file).ok().map(|picture| picture.to_rgb8())
    }
}

impl Drop for Window {
    fn drop(&mut self) {
        // It may have ended already.
        _ = self.child.kill();
        _ = self.child.wait();
    }
}

fn wait<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(start.elapsed() < PATIENCE, "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(200));
    }
}

/// Mean over a part of the picture, and the mean difference of neighbours: both change with the roughness of the ball.
fn look(picture: &image::RgbImage, [x, y, w, h]: [u32; 4]) -> [f64; 2] {
    let at = |i: u32, j: u32| picture.get_pixel(x + i, y + j).0.map(f64::from).iter().sum::<f64>();
    let (mut sum, mut rough) = (0.0, 0.0);
    for j in 0..h - 1 {
        for i in 0..w {
            sum += at(i, j);
            rough += (at(i, j + 1) - at(i, j)).abs();
        }
    }
    let n = f64::from(w * (h - 1));
    [sum / n, rough / n]
}

/// Whether a window can be driven here; it must be where tests may not be skipped.
fn has_tools() -> bool {
    let tools =
        std::env::var_os("DISPLAY").is_some() && run("xdotool", &["version"]).is_some() && run("import", &["-version"]).is_some();
    if !tools {
        assert!(std::env::var_os("BURNISH_REQUIRE_GPU").is_none(), "a display, xdotool and ImageMagick are needed here");
        eprintln!("SKIPPED: no display, xdotool or ImageMagick");
    }
    tools
}

#[test]
fn a_slider_moves_both_views_and_the_file_follows() {
    if !has_tools() {
        return;
    }
    let _hands = HANDS.lock().unwrap_or_else(PoisonError::into_inner);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("driven.asm.ron");
    std::fs::write(&file, MATERIAL).unwrap();
    let window = Window::open(&file);

    let is_red = |picture: &image::RgbImage, [x, y, w, h]: [u32; 4]| {
        let p = picture.get_pixel(x + w / 2, y + h / 2).0;
        p[0] > 80 && p[0] > 2 * p[2]
    };
    let before = wait("both views to show the red ball", || {
        let picture = window.picture(folder.path())?;
        (is_red(&picture, PREVIEW) && is_red(&picture, FINAL)).then_some(picture)
    });

    window.drag(ROUGHNESS_FROM, ROUGHNESS_TO);
    for (view, part) in [("preview", PREVIEW), ("final view", FINAL)] {
        let old = look(&before, part);
        wait(&format!("the {view} to follow the slider"), || {
            let new = look(&window.picture(folder.path())?, part);
            ((new[0] - old[0]).abs() > 1.5 || (new[1] - old[1]).abs() > 1.5).then_some(())
        });
    }

    let saved = window.save_until("the file to change", &file, |text| text != MATERIAL);
    let (head, tail) = MATERIAL.split_once("3e-1").unwrap();
    let value = saved.strip_prefix(head).and_then(|rest| rest.strip_suffix(tail)).expect("nothing but the number changes");
    assert!(value.parse::<f64>().unwrap() > 0.5, "roughness was dragged to {value}");

    window.key("ctrl+z");
    window.save_until("the file to be as it was", &file, |text| text == MATERIAL);
    drop(window);

    std::fs::write(&file, &saved).unwrap();
    let window = Window::open(&file);
    wait("the saved file to open", || {
        let picture = window.picture(folder.path())?;
        is_red(&picture, PREVIEW).then_some(())
    });
}

#[test]
fn a_lost_device_costs_nothing_but_a_blink() {
    if !has_tools() {
        return;
    }
    let _hands = HANDS.lock().unwrap_or_else(PoisonError::into_inner);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("lost.asm.ron");
    std::fs::write(&file, MATERIAL).unwrap();
    let mut window = Window::open_with(&file, &["--lose-device", "12"]);
    let first = window.id.clone();
    let pid = window.child.id().to_string();
    // Unsaved, and to be found again in the next window.
    wait("the window to show the red ball", || {
        let picture = window.picture(folder.path())?;
        (picture.get_pixel(PREVIEW[0] + 80, PREVIEW[1] + 100).0[0] > 80).then_some(())
    });
    window.drag(ROUGHNESS_FROM, ROUGHNESS_TO);
    window.id = wait("another window", || {
        let found = run("xdotool", &["search", "--onlyvisible", "--pid", &pid])?;
        found.lines().map(str::to_owned).find(|id| *id != first)
    });
    run("xdotool", &["windowfocus", &window.id]);
    window.save_until("the unsaved value to be saved from the new window", &file, |text| text != MATERIAL);
    window.key("ctrl+z");
    window.save_until("undo to reach back across the loss", &file, |text| text == MATERIAL);
    assert!(window.child.try_wait().expect("the program can be asked").is_none(), "the program goes on");
}

//! Mouse, keyboard and eyes of the tests.

use image::RgbImage;
use std::ffi::OsStr;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Names a folder for screenshots: of the journey, and of windows in which something was waited for in vain.
pub const SCREENSHOTS_VARIABLE: &str = "BURNISH_SCREENSHOTS";
/// Longest wait for anything that the window shows: a software adapter on a busy machine is slow.
const PATIENCE: Duration = Duration::from_secs(90);
/// What a slow frame takes: keys that come in the same frame as the click before them would go elsewhere.
const SLOW_FRAME: Duration = Duration::from_millis(500);
/// The window's size at start; without a window manager it stands at the display's corner.
pub const SIZE: (u32, u32) = (1280, 800);
/// The field that filters the properties, where its text begins.
const SEARCH: (u32, u32) = (925, 64);
/// The button that empties it.
const CLEAR: (u32, u32) = (1268, 65);
/// The row that a search finds first: the height of its middle.
pub const ROW: u32 = 111;
/// The middle of its label, and of its number.
pub const LABEL: (u32, u32) = (950, ROW);
pub const NUMBER: (u32, u32) = (1190, ROW);
/// Below the rows of a narrow search, where nothing is.
const NOTHING: (u32, u32) = (1080, 700);
/// The property panel below its search field: left, top, width, height.
const ROWS: Part = [890, 80, 380, 500];

/// A part of the window: left, top, width, height.
pub type Part = [u32; 4];

/// There is one keyboard and one mouse: tests that use them take turns.
static HANDS: Mutex<()> = Mutex::new(());

/// Waits for keyboard and mouse; `None` if a window cannot be driven here, which is a failure where tests may not be skipped.
pub fn hands() -> Option<MutexGuard<'static, ()>> {
    let has = |program, argument| run(program, &[argument]).is_some();
    if std::env::var_os("DISPLAY").is_some() && has("xdotool", "version") && has("import", "-version") {
        return Some(HANDS.lock().unwrap_or_else(PoisonError::into_inner));
    }
    assert!(std::env::var_os("BURNISH_REQUIRE_GPU").is_none(), "a display, xdotool and ImageMagick are needed here");
    eprintln!("SKIPPED: no display, xdotool or ImageMagick");
    None
}

fn output(program: &str, arguments: &[&str]) -> Option<Vec<u8>> {
    let output = Command::new(program).args(arguments).stderr(Stdio::null()).output().ok()?;
    output.status.success().then_some(output.stdout)
}

fn run(program: &str, arguments: &[&str]) -> Option<String> {
    output(program, arguments).map(|bytes| String::from_utf8_lossy(&bytes).trim().to_owned())
}

/// One call of `xdotool`, its words separated by blanks.
fn act(words: &str) {
    let words: Vec<&str> = words.split(' ').collect();
    run("xdotool", &words).expect("input can be sent");
}

pub fn pause() {
    std::thread::sleep(SLOW_FRAME);
}

pub fn wait<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(start.elapsed() < PATIENCE, "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(200));
    }
}

/// A window of a program of its own.
pub struct Window {
    pub child: Child,
    id: String,
}

impl Window {
    /// Starts the program with these arguments; all that it remembers is in the folder `home`.
    pub fn open<S: AsRef<OsStr>>(home: &Path, arguments: &[S]) -> Self {
        std::fs::create_dir_all(home).unwrap();
        let said = home.join("said");
        let child = Command::new(env!("CARGO_BIN_EXE_burnish"))
            .args(arguments)
            .current_dir(home)
            .env("BURNISH_HOME", home)
            .stderr(std::fs::File::create(&said).unwrap())
            .spawn()
            .expect("the program starts");
        let mut window = Self { child, id: String::new() };
        window.find(|_| {
            let said = std::fs::read_to_string(&said).unwrap_or_default();
            assert!(!said.contains("instead"), "the window did not open: {said}");
            true
        });
        act(&format!("windowmove {0} 0 0 windowsize {0} {1} {2}", window.id, SIZE.0, SIZE.1));
        wait("the first picture", || window.picture().filter(|picture| spread(picture) > 10.0));
        window
    }

    /// Waits for another window of the program, as after a lost device.
    pub fn find_next(&mut self) {
        let first = self.id.clone();
        self.find(|id| id != first);
    }

    fn find(&mut self, is_wanted: impl Fn(&str) -> bool) {
        let pid = self.child.id().to_string();
        self.id = wait("a window", || {
            let found = run("xdotool", &["search", "--onlyvisible", "--pid", &pid])?;
            found.lines().find(|id| is_wanted(id)).map(str::to_owned)
        });
        // Without a window manager, nobody else gives it the keyboard.
        act(&format!("windowfocus {}", self.id));
    }

    pub fn title(&self) -> String {
        run("xdotool", &["getwindowname", &self.id]).unwrap_or_default()
    }

    pub fn wait_for_title(&self, part: &str) {
        wait(&format!("“{part}” in the title, which is “{}”", self.title()), || {
            self.title().contains(part).then_some(())
        });
    }

    /// What the window shows.
    pub fn picture(&self) -> Option<RgbImage> {
        let bytes = output("import", &["-window", &self.id, "-depth", "8", "rgb:-"])?;
        RgbImage::from_raw(SIZE.0, SIZE.1, bytes)
    }

    /// Does something, and waits until a part of the window has become another than before by at least `least` of 255 levels on the mean.
    pub fn wait_for_change(&self, what: &str, part: Part, least: f64, act: impl FnOnce()) -> RgbImage {
        let before = wait("a picture", || self.picture());
        act();
        wait(what, || self.picture().filter(|now| difference(&before, now, part) >= least))
    }

    /// Drags until a part of the window has become another: again where a drag fell into frames that were over.
    pub fn drag_for_change(&self, what: &str, part: Part, least: f64, drag: impl Fn()) {
        let before = wait("a picture", || self.picture());
        wait(what, || {
            drag();
            (0..20).find_map(|_| {
                pause();
                self.picture().filter(|now| difference(&before, now, part) >= least)
            })
        });
    }

    pub fn key(&self, keys: &str) {
        act(&format!("key --delay 60 {keys}"));
        pause();
    }

    /// Types a text without blanks.
    pub fn type_text(&self, text: &str) {
        act(&format!("type --delay 40 {text}"));
        pause();
    }

    /// Presses a button of the mouse and lets it go.
    pub fn click(&self, button: u32, (x, y): (u32, u32)) {
        act(&format!("mousemove {x} {y} sleep 0.2 click {button}"));
        pause();
    }

    /// Drags with a button of the mouse in small steps, as a hand does, while a key is held if it has a name.
    pub fn drag(&self, held: &str, button: u32, from: (u32, u32), to: (u32, u32)) {
        const STEPS: u32 = 8;
        let between = |a: u32, b: u32, i: u32| (a * (STEPS - i) + b * i) / STEPS;
        let (down, up) =
            if held.is_empty() { (String::new(), String::new()) } else { (format!("keydown {held} "), format!(" keyup {held}")) };
        let mut words = format!("{down}mousemove {} {} sleep 0.2 mousedown {button} sleep 0.12", from.0, from.1);
        for i in 1..=STEPS {
            words += &format!(" mousemove {} {} sleep 0.12", between(from.0, to.0, i), between(from.1, to.1, i));
        }
        // A drag that begins and ends between two frames would be none.
        act(&format!("{words} sleep 0.7 mouseup {button} sleep 0.3{up}"));
        pause();
    }

    /// Drags a value of a document without changes; again where that fell into frames that were over.
    pub fn drag_value(&self, from: (u32, u32), to: (u32, u32)) {
        wait("the document to be changed", || {
            self.drag("", 1, from, to);
            // A second drag would be a second step.
            (0..20).find_map(|_| {
                pause();
                self.title().contains('•').then_some(())
            })
        });
    }

    /// Types into the search field of the properties, and leaves the keyboard to the window.
    pub fn find_rows(&self, query: &str) {
        self.wait_for_change("the rows to be searched", ROWS, 0.05, || {
            self.click(1, CLEAR);
            self.type_into(SEARCH, query);
            self.click(1, NOTHING);
        });
        pause();
    }

    /// Clicks into a number field, or an empty one, and types instead of what it holds.
    pub fn type_into(&self, (x, y): (u32, u32), text: &str) {
        let field = field((x, y));
        act(&format!("mousemove {x} {y}"));
        pause();
        // On a busy machine a click may fall into a frame that is over: then the keys did nothing here, and both come again.
        wait(&format!("“{text}” in the field"), || {
            self.wait_for_change("the field to take the keyboard", field, 0.5, || act("click 1"));
            pause();
            let before = self.picture()?;
            self.type_text(text);
            pause();
            let is_there = difference(&before, &self.picture()?, field) >= 0.5;
            if !is_there {
                self.key("Escape");
                act(&format!("mousemove {} {}", x + 1, y));
            }
            is_there.then_some(())
        });
    }

    /// Types a number into the row that a search finds first.
    pub fn type_number(&self, query: &str, number: &str) {
        self.find_rows(query);
        self.type_into(NUMBER, number);
        self.key("Return");
    }

    /// Saves again and again until the file's text is as wanted: a key may fall into a slow frame.
    pub fn save_until(&self, what: &str, file: &Path, is_wanted: impl Fn(&str) -> bool) -> String {
        wait(what, || {
            self.key("ctrl+s");
            std::fs::read_to_string(file).ok().filter(|text| is_wanted(text))
        })
    }

    /// Ends the program as a crash or a power failure does.
    pub fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }
}

impl Drop for Window {
    fn drop(&mut self) {
        if std::thread::panicking()
            && let (Some(folder), Some(picture)) = (std::env::var_os(SCREENSHOTS_VARIABLE), self.picture())
        {
            _ = picture.save(Path::new(&folder).join(format!("failed-{}.png", self.child.id())));
        }
        // It may have ended already.
        _ = self.child.kill();
        _ = self.child.wait();
    }
}

/// The part of the window around the middle of a field.
pub fn field((x, y): (u32, u32)) -> Part {
    [x - 30, y - 10, 60, 20]
}

/// Mean difference of two pictures within a part, 0 to 255.
pub fn difference(a: &RgbImage, b: &RgbImage, [x, y, w, h]: Part) -> f64 {
    let places = (y..y + h).flat_map(|j| (x..x + w).map(move |i| (i, j)));
    let sum: u64 = places
        .map(|(i, j)| (0..3).map(|c| u64::from(a.get_pixel(i, j).0[c].abs_diff(b.get_pixel(i, j).0[c]))).sum::<u64>())
        .sum();
    sum as f64 / f64::from(3 * w * h)
}

/// How far the pixels of the whole picture are from its mean, on the mean: 0 before anything is drawn.
fn spread(picture: &RgbImage) -> f64 {
    let values: Vec<f64> = picture.pixels().map(|p| f64::from(p.0[0])).collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    values.iter().map(|v| (v - mean).abs()).sum::<f64>() / values.len() as f64
}

//! Drag a slider, see both views follow, save, undo, save, reopen; and lose the graphics device meanwhile.

use crate::hands::{Part, ROW, Window, hands, wait};
use image::RgbImage;

/// On the track of the roughness, left and right of its middle.
const ROUGHNESS_FROM: (u32, u32) = (1083, ROW);
const ROUGHNESS_TO: (u32, u32) = (1120, ROW);
/// Where the row is before anything is searched.
const UNSEARCHED_ROUGHNESS: u32 = 236;
/// A part of each view that shows the ball.
const PREVIEW: Part = [300, 270, 160, 150];
const FINAL: Part = [636, 270, 160, 150];

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

/// Mean over a part of the picture, and the mean difference of neighbours: both change with the roughness of the ball.
fn look(picture: &RgbImage, [x, y, w, h]: Part) -> [f64; 2] {
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

fn is_red(picture: &RgbImage, [x, y, w, h]: Part) -> bool {
    let p = picture.get_pixel(x + w / 2, y + h / 2).0;
    p[0] > 80 && p[0] > 2 * p[2]
}

#[test]
fn a_slider_moves_both_views_and_the_file_follows() {
    let Some(_hands) = hands() else { return };
    let folder = tempfile::tempdir().unwrap();
    let (home, file) = (folder.path().join("home"), folder.path().join("driven.asm.ron"));
    std::fs::write(&file, MATERIAL).unwrap();
    let window = Window::open(&home, &[&file]);

    let before = wait("both views to show the red ball", || {
        window.picture().filter(|picture| is_red(picture, PREVIEW) && is_red(picture, FINAL))
    });
    window.find_rows("roughness");
    window.drag_value(ROUGHNESS_FROM, ROUGHNESS_TO);
    for (view, part) in [("preview", PREVIEW), ("final view", FINAL)] {
        let old = look(&before, part);
        wait(&format!("the {view} to follow the slider"), || {
            let new = look(&window.picture()?, part);
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
    let window = Window::open(&home, &[&file]);
    wait("the saved file to open", || window.picture().filter(|picture| is_red(picture, PREVIEW)));
}

#[test]
fn a_lost_device_costs_nothing_but_a_blink() {
    let Some(_hands) = hands() else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("lost.asm.ron");
    std::fs::write(&file, MATERIAL).unwrap();
    let arguments = [file.as_os_str(), "--lose-device".as_ref(), "14".as_ref()];
    let mut window = Window::open(&folder.path().join("home"), &arguments);
    wait("the window to show the red ball", || window.picture().filter(|picture| is_red(picture, PREVIEW)));
    // Unsaved, and to be found again in the next window; without a search, as time runs.
    window.drag("", 1, (ROUGHNESS_FROM.0, UNSEARCHED_ROUGHNESS), (ROUGHNESS_TO.0, UNSEARCHED_ROUGHNESS));
    window.wait_for_title("•");
    window.find_next();
    window.save_until("the unsaved value to be saved from the new window", &file, |text| text != MATERIAL);
    window.key("ctrl+z");
    window.save_until("undo to reach back across the loss", &file, |text| text == MATERIAL);
    assert!(window.child.try_wait().unwrap().is_none(), "the program goes on");
}

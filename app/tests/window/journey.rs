//! An artist tweaks one material, minute by minute: open, turn, type, drag, compare, map, final view, difference, save, crash, restore.

use crate::hands::{LABEL, Part, ROW, SCREENSHOTS_VARIABLE, SIZE, Window, difference, field, hands, pause, wait};
use image::{Rgb, RgbImage};
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// The picture between presets and properties, and the ball in it, while the photo stands at its right.
const VIEW: Part = [214, 190, 464, 420];
const BALL: Part = [330, 230, 230, 230];
/// The field with the angle of the light.
const LIGHT_ANGLE: Part = [618, 34, 36, 18];
/// The property panel, and the number of the row that the command palette brings to its middle, and the one below.
const PROPERTIES: Part = [890, 80, 380, 680];
const SOUGHT_IOR: (u32, u32) = (1180, 427);
const SOUGHT_DISPERSION: (u32, u32) = (1180, 451);
/// The photo, and the entry of a colour's context menu that takes it.
const PHOTO: (u32, u32) = (780, 100);
const PICK: (u32, u32) = (1014, 287);
/// The first button of the page about unsaved work.
const BRING_BACK: (u32, u32) = (468, 447);
const PHOTO_COLOR: Rgb<u8> = Rgb([0x33, 0x66, 0xCC]);

const MATERIAL: &str = "// A bottle, 1 unit = 10 mm.
{
    \"asm\": \"4.0\",
    \"name\": \"Bottle\",
    \"unit_mm\": 10.0,
    \"properties\": {
        \"roughness\": { \"value\": 0.1, \"texture\": { \"path\": \"rough.png\", \"channel\": \"g\" } }, // of the outside
        \"translucency\": 1.0,
        \"specular_ior\": 1.5,
        \"dispersion\": 0.0,
        \"absorption_color\": (0.5, 0.8, 0.6),
        \"absorption_distance\": 1.2, // 12 mm
        \"of_the_future\": [1, 2],
        \"red_shift_of_the_future\": 0.5,
    },
}
";

/// The text after a key, to the end of its line.
fn entry(text: &str, key: &str) -> String {
    let key = format!("\"{key}\": ");
    let line = text.lines().find(|line| line.trim_start().starts_with(&key)).unwrap_or_default();
    line.trim_start().trim_start_matches(&key).split(", //").next().unwrap_or_default().trim_end_matches(',').to_owned()
}

fn number(text: &str, key: &str) -> f64 {
    entry(text, key).parse().unwrap_or(f64::NAN)
}

#[test]
fn an_artist_tweaks_one_material() {
    let Some(_hands) = hands() else { return };
    let folder = tempfile::tempdir().unwrap();
    let shots = std::env::var_os(SCREENSHOTS_VARIABLE).map_or_else(|| folder.path().join("shots"), PathBuf::from);
    std::fs::create_dir_all(&shots).unwrap();
    let [home, file, photo, map] = ["home", "bottle.asm.ron", "photo.png", "rough.png"].map(|name| folder.path().join(name));
    std::fs::write(&file, MATERIAL).unwrap();
    RgbImage::from_pixel(200, 100, PHOTO_COLOR).save(&photo).unwrap();
    // Only G is smooth.
    RgbImage::from_pixel(16, 16, Rgb([255, 10, 255])).save(&map).unwrap();

    // 0:00
    let window = Window::open(&home, &[&file, &photo]);
    let shoot = |name: &str| window.picture().unwrap().save(shots.join(format!("{name}.png"))).unwrap();
    window.wait_for_title("Bottle — Burnish");
    wait("the photo to be shown", || window.picture().filter(|picture| *picture.get_pixel(PHOTO.0, PHOTO.1) == PHOTO_COLOR));
    window.key("1");
    wait("the bottle", || window.picture().filter(|picture| difference(picture, &RgbImage::new(SIZE.0, SIZE.1), BALL) > 20.0));
    pause();
    shoot("0-00-opened");

    // 0:30
    let center = (BALL[0] + BALL[2] / 2, BALL[1] + BALL[3] / 2);
    window.drag_for_change("the view to turn", VIEW, 4.0, || window.drag("", 1, center, (center.0 + 90, center.1 - 20)));
    window.drag_for_change("the light to turn", LIGHT_ANGLE, 0.5, || window.drag("shift", 3, center, (center.0 + 150, center.1)));
    shoot("0-30-turned");
    assert!(!window.title().contains('•'), "looking is no change");

    // 1:00
    window.wait_for_change("the palette", PROPERTIES, 4.0, || window.key("ctrl+k"));
    window.type_text("refraction");
    window.wait_for_change("the palette to close", PROPERTIES, 4.0, || window.key("Return"));
    wait("the row to stand still", || {
        let before = window.picture()?;
        pause();
        window.picture().filter(|now| difference(&before, now, PROPERTIES) == 0.0)
    });
    window.type_into(SOUGHT_IOR, "1.52");
    window.wait_for_change("Tab to go to the dispersion", field(SOUGHT_DISPERSION), 0.5, || window.key("Tab"));
    window.type_text("20/64");
    window.key("Return");
    shoot("1-00-typed");
    let saved = window.save_until("the dispersion to be saved", &file, |text| number(text, "dispersion") != 0.0);
    assert_eq!((number(&saved, "specular_ior"), number(&saved, "dispersion")), (1.52, 0.3125));

    // 2:00
    window.find_rows("absorptiondist");
    let distance = |text: &str| number(text, "absorption_distance");
    window.drag("", 1, (1129, ROW), (1100, ROW));
    let dragged = distance(&window.save_until("the drag", &file, |text| distance(text) != 1.2));
    assert!(dragged > 0.0 && dragged < 0.5, "dragged to {dragged}");
    window.drag("shift", 1, (1100, ROW), (1120, ROW));
    let slower = distance(&window.save_until("the slow drag", &file, |text| distance(text) != dragged));
    assert!(slower > dragged && slower < 1.6 * dragged, "Shift moves a tenth: from {dragged} to {slower}");
    shoot("2-00-dragged");
    for (key, expected) in [("ctrl+z", dragged), ("ctrl+z", 1.2), ("ctrl+y", dragged)] {
        window.key(key);
        window.save_until("one step per drag", &file, |text| distance(text) == expected);
    }

    // 3:00
    window.key("a");
    window.find_rows("absorptioncolor");
    window.wait_for_change("a menu", PROPERTIES, 1.0, || window.click(3, LABEL));
    window.wait_for_change("the menu to close", PROPERTIES, 1.0, || window.click(1, PICK));
    window.click(1, PHOTO);
    let is_photo = |text: &str| entry(text, "absorption_color").starts_with("(0.033");
    let saved = window.save_until("the colour of the photo", &file, is_photo);
    assert_eq!(entry(&saved, "absorption_color"), "(0.0331, 0.1329, 0.6038)", "linear");
    shoot("3-00-picked");
    window.key("b");
    let flipped = window.save_until("side A", &file, |text| !is_photo(text));
    assert_eq!(entry(&flipped, "absorption_color"), "(0.5, 0.8, 0.6)");
    window.key("b");
    window.save_until("side B again", &file, is_photo);
    window.wait_for_change("both sides", VIEW, 4.0, || window.key("s"));
    pause();
    shoot("3-20-sides");
    window.wait_for_change("the wipe", VIEW, 2.0, || window.key("4"));
    pause();
    let middle = VIEW[0] + VIEW[2] / 2;
    window.wait_for_change("the line of the wipe to move", BALL, 2.0, || window.drag("", 1, (middle, 500), (middle - 120, 500)));
    shoot("3-40-wipe");

    // 4:30
    window.wait_for_change("the preview alone", VIEW, 1.0, || window.key("1"));
    pause();
    window.wait_for_change("the view to follow the map", BALL, 2.0, || {
        RgbImage::from_pixel(16, 16, Rgb([255, 230, 255])).save(&map).unwrap()
    });
    shoot("4-30-map");

    // 5:30
    window.wait_for_change("the final view", VIEW, 2.0, || window.key("backslash"));
    shoot("5-30-final");
    let is_edited = |text: &str| number(text, "specular_level") == 0.9;
    window.wait_for_change("the final view to begin anew", BALL, 0.3, || window.type_number("specularlevel", "0.9"));
    shoot("5-40-edited");
    window.save_until("an edit while the final view renders", &file, is_edited);

    // 7:00
    let final_view = window.picture().unwrap();
    window.key("5");
    wait("the difference, which needs both pictures", || {
        window.picture().filter(|now| difference(&final_view, now, VIEW) > 4.0 && colors(now, VIEW) > 500)
    });
    shoot("7-00-difference");

    // 9:00
    let saved = window.save_until("everything to be saved", &file, is_edited);
    wait("the title to say that nothing is unsaved", || (!window.title().contains('•')).then_some(()));
    for line in MATERIAL.lines().filter(|line| !["specular_ior", "dispersion", "absorption"].iter().any(|key| line.contains(key)))
    {
        assert!(saved.contains(line), "kept: {line}");
    }
    shoot("9-00-saved");

    // And then the power fails.
    window.key("1");
    window.type_number("coatopacity", "0.25");
    window.wait_for_title("•");
    let recovery = home.join("state").join("recovery");
    wait("the unsaved value to be kept", || {
        let sessions = std::fs::read_dir(&recovery).ok()?;
        sessions.flatten().any(|session| has_document(&session.path())).then_some(())
    });
    window.kill();
    assert_eq!(std::fs::read_to_string(&file).unwrap(), saved, "it was not saved");
    let window = Window::open(&home, &[&file]);
    window.wait_for_title("Bottle");
    pause();
    window.picture().unwrap().save(shots.join("9-30-recovery.png")).unwrap();
    window.click(1, BRING_BACK);
    window.wait_for_title("•");
    window.save_until("what was brought back to be saved", &file, |text| number(text, "coat") == 0.25);
    window.picture().unwrap().save(shots.join("9-40-restored.png")).unwrap();
}

/// How many colours there are in a part of the window: few where only a text stands.
fn colors(picture: &RgbImage, [x, y, w, h]: Part) -> usize {
    let places = (y..y + h).flat_map(|j| (x..x + w).map(move |i| (i, j)));
    places.map(|(i, j)| picture.get_pixel(i, j).0).collect::<HashSet<_>>().len()
}

/// Whether a session of the recovery store holds a document.
fn has_document(session: &Path) -> bool {
    let entries = std::fs::read_dir(session).into_iter().flatten().flatten();
    entries.into_iter().any(|entry| entry.path().extension().is_some_and(|ending| ending == "ron"))
}

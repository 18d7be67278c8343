#![allow(clippy::unwrap_used)] // A helper that fails fails its test.

use super::*;
use image::Rgb;

/// Cards of this many materials in two groups, all with one red picture of this size.
fn sheet(folder: &Path, count: usize, size: [u32; 2]) -> Sheet {
    let picture = folder.join("red.png");
    RgbImage::from_pixel(size[0], size[1], Rgb([250, 10, 10])).save(&picture).unwrap();
    let card = |number: usize| Card {
        path: format!("group{}/m{number:05}.asm.ron", number % 2),
        name: format!("Material {number}"),
        group: format!("group{}", number % 2),
        tags: vec!["red".into()],
        provenance: Provenance { licence: "MIT".into(), ..Provenance::default() },
        hash: Digest::of(b"x"),
        picture: Some(picture.clone()),
        is_stale: false,
    };
    Sheet::new("Reds", (0..count).map(card).collect())
}

fn picture_of(sheet: &Sheet) -> RgbImage {
    image::load_from_memory(&sheet.png(&mut |_| true).unwrap().unwrap()).unwrap().into_rgb8()
}

#[test]
fn a_page_holds_everything_and_escapes_it() {
    let folder = tempfile::tempdir().unwrap();
    let mut sheet = sheet(folder.path(), 5, [40, 30]);
    let evil = "<img src=x onerror=\"alert('1')\"> & </script>";
    let card = &mut sheet.cards[1];
    (card.name, card.tags, card.picture, card.is_stale) = (evil.into(), vec![evil.into()], None, true);
    card.provenance = Provenance { source: evil.into(), reference: "漆".into(), method: evil.into(), licence: String::new() };
    (card.path, sheet.title) = (evil.into(), evil.into());
    let page = sheet.html(&mut |_| true).unwrap().unwrap();
    assert_eq!(page.matches("src=\"data:image/jpeg;base64,").count(), 4);
    assert!(!page.contains("<img src=x") && page.contains("&lt;img src=x onerror=&quot;alert(&#39;1&#39;)&quot;&gt; &amp;"));
    assert_eq!(page.matches("</script>").count(), 1);
    for text in [
        "5 materials in 2 groups",
        "group1",
        "no licence stated",
        "no picture",
        "picture of an earlier state",
        "漆",
        "MIT",
        "width=\"40\" height=\"30\"",
    ] {
        assert!(page.contains(text), "{text}");
    }
    // Nothing comes from elsewhere.
    assert!(!page.contains("http:") && !page.contains("https:") && !page.contains("<link"));
    assert!(sheet.html(&mut |done| done < 3).unwrap().is_none());
    let many = Sheet { cards: vec![sheet.cards[0].clone(); MAX_CARDS + 1], ..sheet };
    assert!(
        many.html(&mut |_| true)
            .unwrap_err()
            .to_string()
            .contains("20001 materials are too many for a sheet: expected at most 20000")
    );
}

#[test]
fn a_picture_has_all_pictures_and_their_names() {
    let folder = tempfile::tempdir().unwrap();
    for (count, size, shown) in [(1, [16, 16], [16, 16]), (11, [40, 20], [40, 20]), (3, [600, 300], [256, 128])] {
        let sheet = sheet(folder.path(), count, size);
        let picture = picture_of(&sheet);
        let red = picture.pixels().filter(|pixel| pixel[0] > 200 && pixel[1] < 60).count() as u32;
        assert_eq!(red, count as u32 * shown[0] * shown[1], "{count}");
        let grey = |picture: &RgbImage| picture.pixels().filter(|pixel| pixel[1] > 120).count();
        assert!(grey(&picture) > 100 + 40 * count, "{count}: names are there");
    }
    let wide = picture_of(&sheet(folder.path(), 9, [160, 160]).shaped(Some(120), Some(3)));
    assert_eq!(wide.width(), 2 * 28 + 3 * 120 + 2 * 18);
    assert!(sheet(folder.path(), 9, [16, 16]).png(&mut |done| done < 3).unwrap().is_none());
}

#[test]
fn many_materials_get_smaller_pictures_and_then_a_message() {
    let folder = tempfile::tempdir().unwrap();
    let mut lettering = crate::lettering::Lettering::default();
    let mut size_of = |count| {
        let sheet = sheet(folder.path(), count, [256, 256]);
        sheet.fitting(&mut lettering).map(|layout| (layout.side, layout.pictures.len(), layout.size))
    };
    assert_eq!(size_of(200).map(|(side, count, _)| (side, count)), Ok((256, 200)));
    let (side, count, size) = size_of(3000).unwrap();
    assert!(count == 3000 && side < 192 && u64::from(size[0]) * u64::from(size[1]) <= 1 << 26, "{side} {size:?}");
    let error = size_of(20_000).unwrap_err().to_string();
    assert!(error.contains("20000 materials are too many") && error.contains("search"), "{error}");
}

#[test]
fn names_of_any_length_and_script_are_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let mut sheet = sheet(folder.path(), 6, [64, 64]);
    let before = picture_of(&sheet).dimensions();
    for (card, name) in sheet.cards.iter_mut().zip(["漆器", "ذهب", "🥇", "", "x\u{0}\u{202e}y", &"Long name ".repeat(40)])
    {
        name.clone_into(&mut card.name);
    }
    assert!(sheet.names_with_boxes() >= 2);
    let after = picture_of(&sheet).dimensions();
    assert!(after.0 == before.0 && after.1 > before.1, "the row makes room: {before:?} {after:?}");
}

//! The sheet as one picture: a grid whose names are never cut off; where there are many materials, their pictures are smaller.

use super::{Card, Sheet, SheetError};
use crate::lettering::Lettering;
use egui::Galley;
use image::codecs::png::PngEncoder;
use image::{Rgb, RgbImage, imageops};

/// Most pixels of a sheet.
const MAX_PIXELS: u64 = 1 << 26;
/// Most columns or rows of pixels.
const MAX_LENGTH: u32 = 16_384;
/// Sides that pictures have unless something else is asked for, the largest that fits first; smaller ones of the library stay as they are.
const SIDES: [u32; 5] = [256, 192, 128, 96, 64];
/// Narrower columns would break names into pieces.
const MIN_COLUMN: u32 = 104;
/// Rows that a name may have; only longer ones end in an ellipsis.
const NAME_ROWS: usize = 6;
const MARGIN: u32 = 28;
const GAP: u32 = 18;
/// Pixels between a picture and its name.
const NAME_GAP: u32 = 7;

const PAPER: [u8; 3] = [24, 25, 28];
const EMPTY: [u8; 3] = [43, 46, 51];
const INK: [u8; 3] = [226, 229, 233];
const WEAK: [u8; 3] = [150, 157, 167];

/// A text in its place.
pub(super) struct Text {
    galley: Galley,
    at: [u32; 2],
    color: [u8; 3],
}

/// Where everything goes.
pub(super) struct Layout<'a> {
    pub size: [u32; 2],
    texts: Vec<Text>,
    /// Upper left corners of the boxes for pictures.
    pub pictures: Vec<(&'a Card, [u32; 2])>,
    pub side: u32,
}

impl Sheet {
    /// The sheet as PNG. `go_on` as for [`Sheet::bytes`].
    pub fn png(&self, go_on: &mut dyn FnMut(usize) -> bool) -> Result<Option<Vec<u8>>, SheetError> {
        let mut lettering = Lettering::default();
        let layout = self.fitting(&mut lettering)?;
        let [width, height] = layout.size;
        let mut sheet = RgbImage::from_pixel(width, height, Rgb(PAPER));
        for (done, (card, [x, y])) in layout.pictures.iter().enumerate() {
            match card.small_picture(layout.side) {
                Some(picture) => {
                    // Pictures that are not square lie in the middle of their box.
                    let [left, top] =
                        [(x, picture.width()), (y, picture.height())].map(|(at, n)| i64::from(at + (layout.side - n) / 2));
                    imageops::replace(&mut sheet, &picture, left, top);
                }
                None => imageops::replace(
                    &mut sheet,
                    &RgbImage::from_pixel(layout.side, layout.side, Rgb(EMPTY)),
                    i64::from(*x),
                    i64::from(*y),
                ),
            }
            if !go_on(done + 1) {
                return Ok(None);
            }
        }
        layout.texts.iter().for_each(|text| lettering.draw(&text.galley, &mut sheet, text.at, text.color));
        let mut bytes = Vec::new();
        sheet.write_with_encoder(PngEncoder::new(&mut bytes)).map_err(|error| SheetError::Encode(error.to_string()))?;
        Ok(Some(bytes))
    }

    /// The letters that the font of a PNG lacks are boxes there: how many names have some.
    pub fn names_with_boxes(&self) -> usize {
        let mut lettering = Lettering::default();
        self.cards.iter().filter(|card| !lettering.has_all(&card.name)).count()
    }

    /// The layout with the largest pictures that fits.
    pub(super) fn fitting(&self, lettering: &mut Lettering) -> Result<Layout<'_>, SheetError> {
        let count = self.cards.len();
        // Pictures of one library are of one size, and none is drawn larger than it is.
        let own = self.cards.iter().find_map(|card| image::image_dimensions(card.picture.as_deref()?).ok());
        let own = own.map_or(SIDES[0], |(width, height)| width.max(height)).min(self.side.unwrap_or(SIDES[0])).max(1);
        let sides = std::iter::once(own).chain(SIDES.into_iter().filter(|side| *side < own));
        for side in sides {
            // The least that it takes, so that what cannot fit is not laid out.
            let least = count as u64 * u64::from(side) * u64::from(side);
            if least <= MAX_PIXELS
                && let Some(layout) = self.layout(side, lettering)
            {
                return Ok(layout);
            }
        }
        let most = "about 4000 in a PNG; a search narrows them down, and a page (.html) holds more".to_owned();
        Err(SheetError::TooMany { count, most })
    }

    /// Everything in its place around pictures of this size; `None` if it is too large.
    fn layout(&self, side: u32, lettering: &mut Lettering) -> Option<Layout<'_>> {
        let column = side.max(MIN_COLUMN);
        let size = if side >= 192 { 15.0 } else { 12.0 };
        // About three by two, without columns that no group fills, and wide enough for the title.
        let longest = self.groups().map(<[Card]>::len).max().unwrap_or_default() as u32;
        let wished = (self.cards.len() as f64 * 1.6).sqrt().ceil() as u32;
        let most = (MAX_LENGTH - 2 * MARGIN) / (column + GAP);
        let across = self.columns.unwrap_or(wished.min(longest).max(4)).clamp(1, most);
        let width = 2 * MARGIN + across * (column + GAP) - GAP;
        let inner = (width - 2 * MARGIN) as f32;
        let mut layout = Layout { size: [width, 0], texts: Vec::new(), pictures: Vec::with_capacity(self.cards.len()), side };
        let mut y = MARGIN;
        let mut text = |layout: &mut Layout, text: &str, size: f32, room: f32, at: [u32; 2], color| {
            let galley = lettering.lay_out(text, size, room, NAME_ROWS);
            let height = galley.rect.height().ceil() as u32;
            layout.texts.push(Text { galley, at, color });
            height
        };
        y += text(&mut layout, &self.title, 26.0, inner, [MARGIN, y], INK);
        y += 2 + text(&mut layout, &self.facts(), 14.0, inner, [MARGIN, y + 2], WEAK);
        for cards in self.groups() {
            y += GAP;
            if let Some(group) = cards.first().map(|card| &card.group).filter(|group| !group.is_empty()) {
                y += NAME_GAP + text(&mut layout, group, 17.0, inner, [MARGIN, y], INK);
            }
            for row in cards.chunks(across as usize) {
                let mut names = 0;
                for (card, place) in row.iter().zip(0..) {
                    let x = MARGIN + place * (column + GAP);
                    layout.pictures.push((card, [x, y]));
                    names = names.max(text(&mut layout, &card.name, size, column as f32, [x, y + side + NAME_GAP], INK));
                }
                y += side + NAME_GAP + names + GAP;
                if y > MAX_LENGTH {
                    return None;
                }
            }
        }
        layout.size[1] = y - GAP + MARGIN;
        let pixels = u64::from(layout.size[0]) * u64::from(layout.size[1]);
        (pixels <= MAX_PIXELS && layout.size[1] <= MAX_LENGTH).then_some(layout)
    }
}

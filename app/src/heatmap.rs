//! Values per pixel as a picture: Viridis, which readers with any colour vision can order, above a bar with numbers.

/// Viridis by Stéfan van der Walt and Nathaniel Smith (CC0) in eight equal steps.
const VIRIDIS: [[u8; 3]; 9] = [
    [0x44, 0x01, 0x54],
    [0x47, 0x2d, 0x7b],
    [0x3b, 0x52, 0x8b],
    [0x2c, 0x72, 0x8e],
    [0x21, 0x91, 0x8c],
    [0x28, 0xae, 0x80],
    [0x5e, 0xc9, 0x62],
    [0xad, 0xdc, 0x30],
    [0xfd, 0xe7, 0x25],
];

/// Height of the bar with its numbers, pixels.
const BAR: usize = 16;
/// Narrower pictures have no room for the numbers and go without the bar.
const NARROWEST: usize = 64;
/// Digits of 3 by 5 pixels, a bit each, rows from the top; the last is the point.
const DIGITS: [[u8; 5]; 11] = [
    [7, 5, 5, 5, 7],
    [2, 6, 2, 2, 7],
    [7, 1, 7, 4, 7],
    [7, 1, 7, 1, 7],
    [5, 5, 7, 1, 1],
    [7, 4, 7, 1, 7],
    [7, 4, 7, 5, 7],
    [7, 1, 1, 2, 2],
    [7, 5, 7, 5, 7],
    [7, 5, 7, 1, 7],
    [0, 0, 0, 0, 2],
];

/// An opaque picture of 8 bits per channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Heatmap {
    /// Pixels.
    pub width: usize,
    /// Pixels, the bar included.
    pub height: usize,
    /// sRGB, row by row from the top.
    pub bytes: Vec<u8>,
}

/// Values in `[0, 1]`, row by row of `width`, as colours from dark blue (0) to yellow (1).
pub fn heatmap(values: &[f32], width: usize) -> Heatmap {
    let rows = values.len().checked_div(width).unwrap_or(0);
    let mut bytes: Vec<u8> = values.iter().take(rows * width).flat_map(|value| color(*value)).collect();
    if width < NARROWEST {
        return Heatmap { width, height: rows, bytes };
    }
    let mut bar = vec![[0_u8; 3]; BAR * width];
    for x in 0..width {
        for y in 0..BAR / 2 {
            bar[y * width + x] = color(x as f32 / (width - 1) as f32);
        }
    }
    for (text, share) in [("0", 0.0), ("0.25", 0.25), ("0.5", 0.5), ("0.75", 0.75), ("1", 1.0)] {
        let length = 4 * text.len() - 1;
        let x = (share * width as f64 - 0.5 * length as f64).clamp(1.0, (width - length - 1) as f64) as usize;
        write(&mut bar, width, text, x, BAR / 2 + 2);
    }
    bytes.extend(bar.into_iter().flatten());
    Heatmap { width, height: rows + BAR, bytes }
}

/// Dark blue for 0 to yellow for 1.
pub fn color(value: f32) -> [u8; 3] {
    let steps = (VIRIDIS.len() - 1) as f32;
    let place = if value.is_finite() { value.clamp(0.0, 1.0) * steps } else { steps };
    let step = (place as usize).min(VIRIDIS.len() - 2);
    let (from, to, share) = (VIRIDIS[step], VIRIDIS[step + 1], place - step as f32);
    std::array::from_fn(|k| (f32::from(from[k]) + share * (f32::from(to[k]) - f32::from(from[k])) + 0.5) as u8)
}

/// Writes white digits with their upper left corner at column `x` of row `y`.
fn write(pixels: &mut [[u8; 3]], width: usize, text: &str, x: usize, y: usize) {
    for (i, c) in text.chars().enumerate() {
        let rows = &DIGITS[c.to_digit(10).map_or(DIGITS.len() - 1, |digit| digit as usize)];
        for (row, bits) in rows.iter().enumerate() {
            for column in (0..3).filter(|column| bits & (4 >> column) != 0) {
                pixels[(y + row) * width + x + 4 * i + column] = [255; 3];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_grow_brighter_with_the_value() {
        let luminance = |value: f32| {
            let [r, g, b] = color(value).map(f32::from);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        for i in 0..20 {
            assert!(luminance(i as f32 / 20.0) < luminance((i + 1) as f32 / 20.0), "{i}");
        }
        assert_eq!((color(-1.0), color(f32::NAN)), (VIRIDIS[0], VIRIDIS[8]));
    }

    #[test]
    fn wide_pictures_get_a_bar_with_numbers() {
        for (width, height) in [(0, 0), (1, 1), (63, 2), (64, 2 + BAR), (500, 2 + BAR)] {
            let map = heatmap(&vec![0.5; width * 2], width);
            let rows = if width == 1 { 2 } else { height };
            assert_eq!((map.height, map.bytes.len()), (rows, 3 * width * rows), "{width}");
            let has_white = map.bytes.chunks(3).any(|pixel| pixel == [255; 3]);
            assert_eq!(has_white, width >= NARROWEST, "{width}");
        }
    }
}

//! Colours of the views that show numbers.

use crate::tonemap::srgb_decode;

/// Linear Rec.709, `[0, 1]`.
pub(super) type Color = [f32; 3];

/// Viridis at even steps, sRGB: brightness rises evenly, for the colour-blind too.
const VIRIDIS: [u32; 9] = [0x44_0154, 0x47_2d7b, 0x3b_528b, 0x2c_728e, 0x21_918c, 0x28_ae80, 0x5e_c962, 0xad_dc30, 0xfd_e725];

/// An sRGB colour given as `0xrrggbb`.
pub(super) fn hex(rgb: u32) -> Color {
    [16, 8, 0].map(|shift| srgb_decode((rgb >> shift & 0xff) as f32 / 255.0))
}

/// A ramp from dark blue at 0 to yellow at 1; numbers beyond are cut off, what is no number is 0.
pub(super) fn ramp(x: f32) -> Color {
    let steps = VIRIDIS.len() - 1;
    let at = if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) } * steps as f32;
    let cell = (at as usize).min(steps - 1);
    let (low, high) = (hex(VIRIDIS[cell]), hex(VIRIDIS[cell + 1]));
    std::array::from_fn(|k| low[k] + (at - cell as f32) * (high[k] - low[k]))
}

/// Two ramps from grey at 0: to orange at 1 and to blue at -1.
pub(super) fn diverging(x: f32) -> Color {
    let x = if x.is_nan() { 0.0 } else { x.clamp(-1.0, 1.0) };
    let (grey, end) = (hex(0x80_8080), hex(if x > 0.0 { 0xe6_9f00 } else { 0x00_72b2 }));
    std::array::from_fn(|k| grey[k] + x.abs() * (end[k] - grey[k]))
}

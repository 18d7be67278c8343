//! An image as its file stores it. It is not decoded here: what the numbers mean depends on what they are used for.

/// A rectangle of texels, four channels each.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Number of columns, at least 1 for a loaded image.
    pub width: usize,
    /// Number of rows, at least 1 for a loaded image.
    pub height: usize,
    /// Red, green, blue, alpha, row by row from the upper left corner: `width * height` of them.
    ///
    /// As stored, which is 0 to 1 for files of 8 and 16 bits and unbounded for files of floats; never decoded from
    /// sRGB. One-channel files repeat their value in red, green and blue; without alpha it is 1.
    pub texels: Vec<[f32; 4]>,
    /// True where colours are display-encoded (sRGB) by convention, which is so for PNG and JPEG of 8 bits.
    pub is_eight_bit: bool,
}

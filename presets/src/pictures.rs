//! Small pictures of the presets, rendered by the final view: one sheet of square cells, and how each preset looked when its cell was made.
//!
//! `cargo run --release -p burnish-tests --example preset_pictures` makes the cells anew of which the presets have changed.

/// Side of a cell, pixels: a multiple of what JPEG divides pictures into, so that a cell is written again without loss.
pub const SIDE: usize = 96;
/// Cells beside each other.
pub const ACROSS: usize = 15;

/// The sheet, a JPEG in sRGB; cells row by row in the order of [`cells`].
pub const SHEET: &[u8] = include_bytes!("../pictures/sheet.jpg");

/// File stem of each cell's preset, and the hash of the look that the cell shows.
pub fn cells() -> impl Iterator<Item = (&'static str, &'static str)> {
    include_str!("../pictures/looks.txt").lines().filter_map(|line| line.split_once(' '))
}

/// Column and row of the cell of a preset, if it has one.
pub fn cell(file_stem: &str) -> Option<[usize; 2]> {
    cells().position(|(stem, _)| stem == file_stem).map(|index| [index % ACROSS, index / ACROSS])
}

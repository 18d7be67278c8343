//! Large pictures in parts, so that the memory they take while they are made is that of a part.

use crate::scene_file::MAX_PIXELS;
use burnish_renderer::path::Tile;

/// Side of the parts of a picture of the path tracer: 0.9 GB of samples.
const SIDE: usize = 2048;

/// The parts that a picture of the path tracer is rendered in, row by row: the whole up to 2^24 pixels.
pub fn of_final(width: usize, height: usize) -> Vec<Tile> {
    if width * height <= MAX_PIXELS { vec![Tile { at: [0, 0], size: [width, height] }] } else { of_side(width, height, SIDE) }
}

/// Parts of at most this side, row by row.
pub fn of_side(width: usize, height: usize, side: usize) -> Vec<Tile> {
    let mut tiles = Vec::new();
    for y in (0..height).step_by(side) {
        for x in (0..width).step_by(side) {
            tiles.push(Tile { at: [x, y], size: [side.min(width - x), side.min(height - y)] });
        }
    }
    tiles
}

/// Puts the pixels of a part where they belong in a picture of this width.
pub fn put<T: Copy>(picture: &mut [T], width: usize, tile: Tile, pixels: &[T]) {
    let [columns, _] = tile.size;
    for (row, of_tile) in pixels.chunks_exact(columns.max(1)).enumerate() {
        let first = (tile.at[1] + row) * width + tile.at[0];
        if let Some(place) = picture.get_mut(first..first + columns) {
            place.copy_from_slice(of_tile);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_cover_a_picture_once() {
        assert_eq!((of_final(4096, 4096).len(), of_final(8192, 8192).len(), of_final(16_384, 4096).len()), (1, 16, 16));
        let mut picture = vec![0; 5 * 7];
        for (i, tile) in of_side(5, 7, 3).into_iter().enumerate() {
            let [columns, rows] = tile.size;
            put(&mut picture, 5, tile, &vec![i + 1; columns * rows]);
        }
        assert_eq!(picture[..5], [1, 1, 1, 2, 2]);
        assert_eq!(picture[30..], [5, 5, 5, 6, 6]);
        assert!(picture.iter().all(|part| *part > 0));
    }
}

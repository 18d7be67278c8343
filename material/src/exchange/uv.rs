//! Two ways to say how an image lies on a surface. Here, in glTF and in images, v grows downwards from the upper left corner; in USD and
//! MaterialX it grows upwards from the lower left one. Scale and angle are the same in both, the shift is not: both turn about their own
//! origin.

use crate::slot::TextureRef;

/// Cosine and sine of an angle in degrees, exact for quarter turns.
fn turn(degrees: f64) -> (f64, f64) {
    match degrees.rem_euclid(360.0) {
        0.0 => (1.0, 0.0),
        90.0 => (0.0, 1.0),
        180.0 => (-1.0, 0.0),
        270.0 => (0.0, -1.0),
        _ => {
            let (sin, cos) = degrees.to_radians().sin_cos();
            (cos, sin)
        }
    }
}

/// The shift of a texture as seen from the lower left corner.
pub fn offset_from_below(texture: &TextureRef) -> [f64; 2] {
    let ((cos, sin), scale) = (turn(texture.uv_rotation), texture.uv_scale[1]);
    [texture.uv_offset[0] + sin * scale, 1.0 - cos * scale - texture.uv_offset[1]]
}

/// The shift from the upper left corner of what has this scale, this angle in degrees and this shift from the lower left one.
pub fn offset_from_above(scale: [f64; 2], rotation: f64, offset: [f64; 2]) -> [f64; 2] {
    let (cos, sin) = turn(rotation);
    [offset[0] - sin * scale[1], 1.0 - cos * scale[1] - offset[1]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_texel_is_found_from_both_corners() {
        let texture =
            TextureRef { uv_scale: [2.0, 3.0], uv_rotation: 30.0, uv_offset: [-1.4, -1.798_076_2], ..TextureRef::new("a.png") };
        let below = offset_from_below(&texture);
        assert!((below[0] - 0.1).abs() < 1e-6 && (below[1] - 0.2).abs() < 1e-6, "{below:?}");
        let above = offset_from_above(texture.uv_scale, texture.uv_rotation, below);
        assert!(above.iter().zip(texture.uv_offset).all(|(a, b)| (a - b).abs() < 1e-12));
        // A point of the surface, by both: the row of the image is 1 - v of the other.
        let (cos, sin) = turn(30.0);
        let (u, v) = (0.3, 0.8);
        let down = -sin * 2.0 * u + cos * 3.0 * v + texture.uv_offset[1];
        let up = sin * 2.0 * u + cos * 3.0 * (1.0 - v) + below[1];
        assert!((down - (1.0 - up)).abs() < 1e-12);
    }

    #[test]
    fn an_image_that_fills_the_square_is_not_moved() {
        let texture = TextureRef::new("a.png");
        assert_eq!(offset_from_below(&texture), [0.0; 2]);
        assert_eq!(offset_from_above([1.0; 2], 0.0, [0.0; 2]), [0.0; 2]);
    }
}

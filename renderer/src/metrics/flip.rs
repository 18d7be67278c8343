//! FLIP of pictures in the range of a display: how different two of them look when they alternate in place.
//!
//! Pontus Andersson, Jim Nilsson, Tomas Akenine-Möller, Magnus Oskarsson, Kalle Åström, Mark D. Fairchild, "FLIP: A Difference Evaluator for
//! Alternating Images", HPG 2020. Section numbers are of that paper. All its filters are sums of separable ones, so they run per row and column.

use crate::tonemap::srgb_decode;
use glam::{DMat3, Mat3, Vec3};

/// Pixels per degree of visual angle: a 4K display of 0.7 m width seen from 0.7 m.
const PIXELS_PER_DEGREE: f64 = 67.0;

/// Contrast sensitivity of the eye per opponent channel, as a sum of Gaussians `a sqrt(π/b) exp(-π² x² / b)`, x in degrees (section 4.1.1).
const SENSITIVITY: [&[[f64; 2]]; 3] = [&[[1.0, 0.0047]], &[[1.0, 0.0053]], &[[34.1, 0.04], [13.5, 0.025]]];

/// Width of the edges and points that count as features, degrees (section 4.2).
const FEATURE_WIDTH: f64 = 0.082;

/// Exponents of colour and feature differences, and the knee that spreads small colour differences (sections 4.1.4 and 4.2).
const COLOR_EXPONENT: f32 = 0.7;
const FEATURE_EXPONENT: f32 = 0.5;
const KNEE: f32 = 0.4;
const KNEE_VALUE: f32 = 0.95;

/// Linear Rec.709 to CIE XYZ (IEC 61966-2-1), from its primaries and white point.
const RGB_TO_XYZ: [[f64; 3]; 3] = [
    [0.412_390_799, 0.357_584_339, 0.180_480_788],
    [0.212_639_006, 0.715_168_679, 0.072_192_315],
    [0.019_330_819, 0.119_194_780, 0.950_532_152],
];

/// FLIP per pixel, `[0, 1]`, of two pictures of `width` columns: display-referred sRGB, encoded, in `[0, 1]`. Symmetric in both.
pub fn flip(picture: &[[f32; 3]], reference: &[[f32; 3]], width: usize) -> Vec<f32> {
    if width == 0 || picture.is_empty() {
        return Vec::new();
    }
    let space = Space::new();
    let (a, b) = (Seen::new(picture, width, &space), Seen::new(reference, width, &space));
    let largest = space.largest_distance();
    let color = |a: Vec3, b: Vec3| {
        let distance = hyab(a, b).powf(COLOR_EXPONENT);
        let knee = KNEE * largest;
        if distance < knee {
            KNEE_VALUE / knee * distance
        } else {
            KNEE_VALUE + (distance - knee) / (largest - knee) * (1.0 - KNEE_VALUE)
        }
    };
    let features = |a: [f32; 2], b: [f32; 2]| {
        let largest = (a[0] - b[0]).abs().max((a[1] - b[1]).abs());
        (std::f32::consts::FRAC_1_SQRT_2 * largest).powf(FEATURE_EXPONENT)
    };
    (0..picture.len().min(reference.len()))
        .map(|i| {
            let color = color(a.colors[i], b.colors[i]).clamp(0.0, 1.0);
            let feature = features(a.features[i], b.features[i]).clamp(0.0, 1.0);
            color.powf(1.0 - feature)
        })
        .collect()
}

/// Conversions between linear Rec.709 and XYZ relative to the white point.
struct Space {
    to_xyz: Mat3,
    to_rgb: Mat3,
}

impl Space {
    fn new() -> Self {
        let rows = RGB_TO_XYZ.map(|row| row.map(|x| x / row.iter().sum::<f64>()));
        let to_xyz = DMat3::from_cols_array_2d(&rows).transpose();
        Self { to_xyz: to_xyz.as_mat3(), to_rgb: to_xyz.inverse().as_mat3() }
    }

    /// The linearised opponent space YCxCz (section 4.1.1).
    fn opponent(&self, rgb: Vec3) -> Vec3 {
        let Vec3 { x, y, z } = self.to_xyz * rgb;
        Vec3::new(116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z))
    }

    /// What of an opponent colour a display can show, in CIELAB with chroma scaled by lightness: colours of dark pixels differ less to the
    /// eye (Hunt effect, sections 4.1.2 and 4.1.3).
    fn hunt_lab(&self, opponent: Vec3) -> Vec3 {
        let y = (opponent.x + 16.0) / 116.0;
        let xyz = Vec3::new(y + opponent.y / 500.0, y, y - opponent.z / 200.0);
        self.hunt_lab_of_rgb((self.to_rgb * xyz).clamp(Vec3::ZERO, Vec3::ONE))
    }

    fn hunt_lab_of_rgb(&self, rgb: Vec3) -> Vec3 {
        const D: f32 = 6.0 / 29.0;
        let f = (self.to_xyz * rgb).to_array().map(|t| if t > D * D * D { t.cbrt() } else { t / (3.0 * D * D) + 4.0 / 29.0 });
        let lightness = 116.0 * f[1] - 16.0;
        let chroma = 0.01 * lightness;
        Vec3::new(lightness, 500.0 * (f[0] - f[1]) * chroma, 200.0 * (f[1] - f[2]) * chroma)
    }

    /// The largest colour difference of a display: green against blue.
    fn largest_distance(&self) -> f32 {
        hyab(self.hunt_lab_of_rgb(Vec3::Y), self.hunt_lab_of_rgb(Vec3::Z)).powf(COLOR_EXPONENT)
    }
}

/// Distance of colours that are far apart: city block between lightness and chroma (section 4.1.4).
fn hyab(a: Vec3, b: Vec3) -> f32 {
    let d = a - b;
    d.x.abs() + (d.y * d.y + d.z * d.z).sqrt()
}

/// What the eye makes of a picture.
struct Seen {
    /// Filtered colours, CIELAB with the Hunt effect.
    colors: Vec<Vec3>,
    /// Strength of edges and of points.
    features: Vec<[f32; 2]>,
}

impl Seen {
    fn new(picture: &[[f32; 3]], width: usize, space: &Space) -> Self {
        let decode = |x: f32| srgb_decode(x.clamp(0.0, 1.0));
        let opponent: Vec<Vec3> = picture.iter().map(|c| space.opponent(Vec3::from(c.map(decode)))).collect();
        let plane = |k: usize| opponent.iter().map(|c| c[k]).collect::<Vec<f32>>();
        let filtered: [Vec<f32>; 3] = std::array::from_fn(|k| see(&plane(k), width, SENSITIVITY[k]));
        let colors =
            (0..opponent.len()).map(|i| space.hunt_lab(Vec3::new(filtered[0][i], filtered[1][i], filtered[2][i]))).collect();
        let lightness: Vec<f32> = opponent.iter().map(|c| (c.x + 16.0) / 116.0).collect();
        Self { colors, features: features(&lightness, width) }
    }
}

/// A plane as the eye resolves it. Every Gaussian is separable, their sum is not: each runs alone.
fn see(plane: &[f32], width: usize, gaussians: &[[f64; 2]]) -> Vec<f32> {
    use std::f64::consts::PI;
    let widest = SENSITIVITY.iter().flat_map(|gaussians| gaussians.iter()).map(|[_, b]| *b).fold(0.0, f64::max);
    let radius = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as i32;
    let taps = |b: f64| -> Vec<f64> {
        (-radius..=radius).map(|i| (-(PI * f64::from(i) / PIXELS_PER_DEGREE).powi(2) / b).exp()).collect()
    };
    let sum_of = |taps: &[f64]| taps.iter().sum::<f64>();
    let weight = |[a, b]: [f64; 2]| a * (PI / b).sqrt() * sum_of(&taps(b)).powi(2);
    let total: f64 = gaussians.iter().map(|gaussian| weight(*gaussian)).sum();
    let mut seen = vec![0.0; plane.len()];
    for gaussian in gaussians {
        let kernel = taps(gaussian[1]);
        let kernel: Vec<f32> = kernel.iter().map(|x| (x / sum_of(&kernel)) as f32).collect();
        let share = (weight(*gaussian) / total) as f32;
        for (seen, x) in seen.iter_mut().zip(filter(plane, width, &kernel, &kernel)) {
            *seen += share * x;
        }
    }
    seen
}

/// Magnitudes of the first and second derivatives of a Gaussian over lightness in `[0, 1]`: edges and points (section 4.2).
fn features(lightness: &[f32], width: usize) -> Vec<[f32; 2]> {
    let deviation = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
    let radius = (3.0 * deviation).ceil() as i32;
    let of = |f: &dyn Fn(f64) -> f64| -> Vec<f64> {
        (-radius..=radius).map(|i| f64::from(i) / deviation).map(|x| f(x) * (-0.5 * x * x).exp()).collect()
    };
    // Positive and negative weights each sum to one.
    let normalised = |taps: Vec<f64>| -> Vec<f32> {
        let positive: f64 = taps.iter().filter(|x| **x > 0.0).sum();
        let negative: f64 = -taps.iter().filter(|x| **x < 0.0).sum::<f64>();
        taps.iter().map(|x| (if *x > 0.0 { x / positive } else { x / negative.max(f64::MIN_POSITIVE) }) as f32).collect()
    };
    let (smooth, edge, point) = (normalised(of(&|_| 1.0)), normalised(of(&|x| -x)), normalised(of(&|x| x * x - 1.0)));
    let magnitude = |kernel: &[f32]| -> Vec<f32> {
        let (x, y) = (filter(lightness, width, kernel, &smooth), filter(lightness, width, &smooth, kernel));
        x.iter().zip(&y).map(|(x, y)| (x * x + y * y).sqrt()).collect()
    };
    magnitude(&edge).into_iter().zip(magnitude(&point)).map(|(edge, point)| [edge, point]).collect()
}

/// Filters rows by one kernel and columns by another, both of odd length; pixels beyond the border are those at it.
fn filter(plane: &[f32], width: usize, row_kernel: &[f32], column_kernel: &[f32]) -> Vec<f32> {
    let height = plane.len() / width;
    let mut rows = vec![0.0; width * height];
    let radius = row_kernel.len() / 2;
    let mut padded = vec![0.0; width + 2 * radius];
    for (row, out) in plane.chunks_exact(width).zip(rows.chunks_exact_mut(width)) {
        padded[..radius].fill(row[0]);
        padded[radius..radius + width].copy_from_slice(row);
        padded[radius + width..].fill(row[width - 1]);
        for (k, weight) in row_kernel.iter().enumerate() {
            accumulate(out, &padded[k..k + width], *weight);
        }
    }
    let mut filtered = vec![0.0; width * height];
    let radius = column_kernel.len() / 2;
    for (y, out) in filtered.chunks_exact_mut(width).enumerate() {
        for (k, weight) in column_kernel.iter().enumerate() {
            let from = (y + k).saturating_sub(radius).min(height - 1);
            accumulate(out, &rows[from * width..(from + 1) * width], *weight);
        }
    }
    filtered
}

fn accumulate(out: &mut [f32], values: &[f32], weight: f32) {
    for (out, value) in out.iter_mut().zip(values) {
        *out += weight * value;
    }
}

#[cfg(test)]
mod tests {
    use super::super::quantile;
    use super::*;

    fn picture(width: usize, height: usize, color: impl Fn(usize, usize) -> [f32; 3]) -> Vec<[f32; 3]> {
        (0..width * height).map(|i| color(i % width, i / width)).collect()
    }

    /// Bytes of a hash, so that other programs can make the same pictures.
    fn noise(x: usize, y: usize, k: usize) -> f32 {
        let h = (x as u32).wrapping_mul(73_856_093) ^ (y as u32).wrapping_mul(19_349_663) ^ (k as u32).wrapping_mul(83_492_791);
        let h = (h ^ (h >> 13)).wrapping_mul(0x5bd1_e995);
        ((h >> 15) & 0xff) as f32 / 255.0
    }

    #[test]
    fn equal_pictures_do_not_differ_and_opposite_ones_do_fully() {
        let a = picture(40, 30, |x, y| [0, 1, 2].map(|k| noise(x, y, k)));
        assert!(flip(&a, &a, 40).iter().all(|e| *e == 0.0));
        let of = |rgb: [f32; 3]| vec![rgb; 32 * 32];
        let green_blue = flip(&of([0.0, 1.0, 0.0]), &of([0.0, 0.0, 1.0]), 32);
        assert!(green_blue.iter().all(|e| (e - 1.0).abs() < 1e-4), "{}", green_blue[0]);
        assert!(flip(&[], &[], 0).is_empty());
        // Out of range and smaller than every filter.
        assert!(flip(&[[9.0, -1.0, 0.5]], &[[0.0; 3]], 1).iter().all(|e| (0.0..=1.0).contains(e)));
    }

    /// Mean, 99th percentile, and the pixels (30, 20) and (0, 0) as `flip-evaluator` 1.7, the program of the paper's authors, gives them.
    #[test]
    fn values_are_those_of_the_published_program() {
        const WIDTH: usize = 64;
        const HEIGHT: usize = 48;
        let make = |color: &dyn Fn(usize, usize) -> [f32; 3]| picture(WIDTH, HEIGHT, color);
        let gradient = |x: usize, y: usize| [x as f32 / 63.0, y as f32 / 47.0, 0.5];
        let bar =
            |from: usize| move |x: usize, _: usize| if (from..from + 4).contains(&x) { [1.0, 0.2, 0.1] } else { [0.1, 0.1, 0.2] };
        let cases = [
            (
                "gradient, noisy",
                make(&|x, y| [0, 1, 2].map(|k| 0.8 * gradient(x, y)[k] + 0.2 * noise(x, y, k))),
                make(&gradient),
                [0.300_353, 0.611_056, 0.217_299, 0.315_938],
            ),
            (
                "noise against noise",
                make(&|x, y| [0, 1, 2].map(|k| noise(x, y, k))),
                make(&|x, y| [0, 1, 2].map(|k| noise(x + 100, y, k))),
                [0.446_924, 0.840_735, 0.425_504, 0.593_321],
            ),
            (
                "checker against grey",
                make(&|x, y| [((x / 8 + y / 8) % 2) as f32; 3]),
                make(&|_, _| [0.5; 3]),
                [0.845_733, 0.982_198, 0.928_278, 0.945_822],
            ),
            ("bar, moved", make(&bar(20)), make(&bar(22)), [0.129_950, 0.952_660, 0.090_987, 0.0]),
            (
                "dark",
                make(&|x, y| [0, 1, 2].map(|k| 0.05 * noise(x, y, k))),
                make(&|_, _| [0.02, 0.03, 0.01]),
                [0.019_942, 0.044_086, 0.019_932, 0.026_151],
            ),
        ];
        for (name, a, b, expected) in cases {
            let errors = flip(&a, &b, WIDTH);
            assert_eq!(errors, flip(&b, &a, WIDTH), "{name}: symmetric");
            let mean = errors.iter().map(|e| f64::from(*e)).sum::<f64>() / errors.len() as f64;
            let found = [mean, quantile(&errors, 0.99), f64::from(errors[20 * WIDTH + 30]), f64::from(errors[0])];
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 3e-4, "{name}: {found} for {expected}");
            }
        }
    }
}

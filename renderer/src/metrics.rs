//! How far a picture is from another: one place for every command, report and test that compares pictures.
//!
//! relMSE and its trimmed form are taken on linear radiance, [`flip`] on what a display shows.

mod flip;

pub use flip::flip;

/// Added to the squared reference, so that black pixels do not divide by 0.
const EPSILON: f64 = 0.01;

/// Share of the pixels, the worst ones, that the trimmed error leaves out.
const TRIMMED: f64 = 0.001;

/// Mean error of a picture relative to a reference, 0 or more.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RelativeError {
    /// Mean over pixels and channels of `(x - r)^2 / (r^2 + 0.01)`.
    pub relmse: f64,
    /// The same without the worst 0.1 % of the pixels, at least one: what fireflies leave.
    pub trimmed: f64,
}

/// The error of `picture` against `reference`, both linear radiance of equally many pixels, finite.
///
/// `variance`, of the reference's own mean per pixel and channel, is what its noise adds to a squared difference on average; given, it is
/// taken off. Which pixels are the worst is told before that. 0 for pictures without pixels.
pub fn relative_error(picture: &[[f32; 3]], reference: &[[f32; 3]], variance: Option<&[[f32; 3]]>) -> RelativeError {
    let mut errors: Vec<(f64, f64)> = picture
        .iter()
        .zip(reference)
        .enumerate()
        .map(|(i, (x, r))| {
            let (mut whole, mut noise) = (0.0, 0.0);
            for k in 0..3 {
                let r_k = f64::from(r[k]);
                let weight = 1.0 / (3.0 * (r_k * r_k + EPSILON));
                whole += weight * (f64::from(x[k]) - r_k).powi(2);
                noise += variance.and_then(|variance| variance.get(i)).map_or(0.0, |v| weight * f64::from(v[k]));
            }
            (whole, whole - noise)
        })
        .collect();
    if errors.is_empty() {
        return RelativeError::default();
    }
    let mean = |errors: &[(f64, f64)]| (errors.iter().map(|e| e.1).sum::<f64>() / errors.len() as f64).max(0.0);
    let relmse = mean(&errors);
    let kept = errors.len() - ((errors.len() as f64 * TRIMMED) as usize).max(1);
    if kept > 0 {
        errors.select_nth_unstable_by(kept - 1, |a, b| a.0.total_cmp(&b.0));
        errors.truncate(kept);
    }
    RelativeError { relmse, trimmed: mean(&errors) }
}

/// relMSE that noise of this variance of the mean has on average around `reference`.
pub fn relative_noise(reference: &[[f32; 3]], variance: &[[f32; 3]]) -> f64 {
    let term =
        |(r, v): (&[f32; 3], &[f32; 3])| (0..3).map(|k| f64::from(v[k]) / (f64::from(r[k]).powi(2) + EPSILON)).sum::<f64>();
    reference.iter().zip(variance).map(term).sum::<f64>() / (3 * reference.len().max(1)) as f64
}

/// Mean over pixels of each channel; zeros without pixels.
pub fn mean(picture: &[[f32; 3]]) -> [f64; 3] {
    let sum = |k: usize| picture.iter().map(|x| f64::from(x[k])).sum::<f64>();
    [0, 1, 2].map(|k| sum(k) / picture.len().max(1) as f64)
}

/// The smallest value that a share of `share`, 0 to 1, of the values does not exceed; 0 without values.
pub fn quantile(values: &[f32], share: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let mut sorted = values.to_vec();
    let rank = (share.clamp(0.0, 1.0) * sorted.len() as f64).ceil() as usize;
    let (_, value, _) = sorted.select_nth_unstable_by(rank.saturating_sub(1), f32::total_cmp);
    f64::from(*value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relmse_is_relative_to_the_reference() {
        let reference = [[1.0, 0.0, 3.0], [0.5; 3]];
        let picture = [[1.1, 0.1, 3.0], [0.5; 3]];
        let expected = (0.01 / 1.01 + 0.01 / 0.01) / 6.0;
        let error = relative_error(&picture, &reference, None);
        assert!((error.relmse - expected).abs() < 1e-6, "{error:?}");
        assert_eq!(error.trimmed, 0.0, "the worst pixel is left out");
        assert_eq!(relative_error(&[], &[], None), RelativeError::default());
        assert_eq!(relative_error(&[[2.0; 3]], &[[2.0; 3]], None), RelativeError::default());
    }

    #[test]
    fn one_pixel_in_a_thousand_is_trimmed() {
        let reference = vec![[1.0; 3]; 2000];
        let mut picture = vec![[1.1_f32; 3]; 2000];
        picture[7] = [100.0; 3];
        picture[1500] = [50.0; 3];
        picture[1501] = [2.0; 3];
        let error = relative_error(&picture, &reference, None);
        let expected = (1997.0 * 0.01 + 1.0) / 1.01 / 1998.0;
        assert!((error.trimmed - expected).abs() < 1e-6, "{error:?} {expected}");
        assert!(error.relmse > 5.0, "{error:?}");
    }

    /// Noise of known size in the reference: with its variance taken off, the error is that of the picture.
    #[test]
    fn the_noise_of_the_reference_is_taken_off() {
        let noise = |i: usize, k: usize| {
            let x = (i * 3 + k) as u64 + 1;
            let x = (x ^ (x << 13)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            (x >> 40) as f32 / (1 << 24) as f32 - 0.5
        };
        let at = |scale: f32, offset: usize| -> Vec<[f32; 3]> {
            (0..20_000).map(|i| [0, 1, 2].map(|k| 2.0 + scale * noise(i + offset, k))).collect()
        };
        let (picture, reference) = (at(0.2, 0), at(0.1, 777_777));
        // A uniform distribution of width w has the variance w^2 / 12.
        let variance = vec![[0.01 / 12.0; 3]; 20_000];
        let truth = 0.04 / 12.0 / 4.01;
        let corrected = relative_error(&picture, &reference, Some(&variance));
        assert!((corrected.relmse / truth - 1.0).abs() < 0.03, "{corrected:?} {truth}");
        assert!((corrected.trimmed / truth - 1.0).abs() < 0.03, "{corrected:?} {truth}");
        let plain = relative_error(&picture, &reference, None);
        assert!((plain.relmse / truth - 1.25).abs() < 0.04, "{plain:?} {truth}");
        assert!((relative_noise(&reference, &variance) / truth - 0.25).abs() < 0.01);
    }

    #[test]
    fn quantiles_are_values_of_the_list() {
        let values: Vec<f32> = (0..100).rev().map(|i| i as f32).collect();
        assert_eq!([0.0, 0.01, 0.5, 0.99, 1.0].map(|p| quantile(&values, p)), [0.0, 0.0, 49.0, 98.0, 99.0]);
        assert_eq!(quantile(&[], 0.5), 0.0);
        assert_eq!(mean(&[[1.0, 2.0, 3.0], [3.0, 2.0, 1.0]]), [2.0; 3]);
    }
}

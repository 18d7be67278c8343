//! The law that an error follows in time, and when it reaches a target.

/// Errors whose times are told: 10 % and 3.2 %.
pub const TARGETS: [f64; 2] = [0.01, 0.001];

/// Points that the law is fitted to: the last doublings.
const POINTS: usize = 5;

/// Slopes beyond these are accidents of few points.
const SLOPES: [f64; 2] = [0.8, 1.6];

/// `error = exp(intercept) * seconds^-slope`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// `ln` of the error after one second.
    pub intercept: f64,
    /// Exponent of time, 0.8 to 1.6; independent samples have 1.
    pub slope: f64,
}

/// When an error is reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// The error.
    pub error: f64,
    /// Seconds; `None` where nothing can be told.
    pub seconds: Option<f64>,
    /// Whether the seconds lie beyond what was measured.
    pub is_extrapolated: bool,
}

/// Fits the law to the last four doublings of `(seconds, error)`; points that are not above 0 are left out. `None` below two points.
pub fn fit(points: &[(f64, f64)]) -> Option<Fit> {
    let points: Vec<(f64, f64)> = logarithms(points);
    let points = &points[points.len().saturating_sub(POINTS)..];
    let n = points.len() as f64;
    if points.len() < 2 {
        return None;
    }
    let (x, y) = points.iter().fold((0.0, 0.0), |(x, y), p| (x + p.0 / n, y + p.1 / n));
    let (xx, xy) = points.iter().fold((0.0, 0.0), |(xx, xy), p| (xx + (p.0 - x).powi(2), xy + (p.0 - x) * (p.1 - y)));
    if xx < 1e-12 {
        return None;
    }
    let slope = (-xy / xx).clamp(SLOPES[0], SLOPES[1]);
    Some(Fit { intercept: y + slope * x, slope })
}

/// When each of [`TARGETS`] is reached: between two points by a straight line on log axes, else by the fitted law.
pub fn targets(points: &[(f64, f64)]) -> [Target; 2] {
    let fit = fit(points);
    let logarithms = logarithms(points);
    TARGETS.map(|error| {
        let y = error.ln();
        let crossing = logarithms.windows(2).find(|pair| pair[0].1 >= y && y >= pair[1].1 && pair[0].1 > pair[1].1);
        if let Some([a, b]) = crossing {
            let seconds = (a.0 + (y - a.1) / (b.1 - a.1) * (b.0 - a.0)).exp();
            return Target { error, seconds: Some(seconds), is_extrapolated: false };
        }
        let seconds = fit.map(|fit| ((fit.intercept - y) / fit.slope).exp());
        Target { error, seconds: seconds.filter(|seconds| seconds.is_finite()), is_extrapolated: true }
    })
}

fn logarithms(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let positive = points.iter().filter(|(seconds, error)| *seconds > 0.0 && *error > 0.0);
    positive.map(|(seconds, error)| (seconds.ln(), error.ln())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_law_is_found_and_continued() {
        let points: Vec<(f64, f64)> = (0..8).map(|i| f64::from(1 << i) * 0.01).map(|t| (t, 0.02 * t.powf(-1.1))).collect();
        let found = fit(&points).unwrap();
        assert!((found.slope - 1.1).abs() < 1e-9 && (found.intercept.exp() - 0.02).abs() < 1e-9, "{found:?}");
        let [near, far] = targets(&points);
        for (target, is_extrapolated) in [(near, true), (far, true)] {
            let expected = (0.02 / target.error).powf(1.0 / 1.1);
            assert!((target.seconds.unwrap() / expected - 1.0).abs() < 1e-9, "{target:?} {expected}");
            assert_eq!(target.is_extrapolated, is_extrapolated);
        }
        let [within, _] = targets(&[(1.0, 0.1), (100.0, 0.001)]);
        assert!(!within.is_extrapolated && (within.seconds.unwrap() - 10.0).abs() < 1e-9, "{within:?}");
    }

    #[test]
    fn nothing_is_told_of_too_little() {
        assert_eq!(fit(&[]), None);
        assert_eq!(fit(&[(1.0, 0.1), (2.0, 0.0)]), None);
        assert_eq!(fit(&[(1.0, 0.1), (1.0, 0.2)]), None);
        assert_eq!(targets(&[(1.0, 0.0)]).map(|target| target.seconds), [None; 2]);
        // Constant error: the slope is held within what can be believed.
        assert_eq!(fit(&[(1.0, 0.1), (2.0, 0.1)]).unwrap().slope, 0.8);
    }
}

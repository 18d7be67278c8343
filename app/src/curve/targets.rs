//! When an error reaches a target.

use burnish_renderer::path::Convergence;

/// Errors whose times are told: 10 % and 3.2 %.
pub const TARGETS: [f64; 2] = [0.01, 0.001];

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

/// When each of [`TARGETS`] is reached by `(seconds, error)`: between two points by a straight line on log axes, else by the line through
/// the last ones.
pub fn targets(points: &[(f64, f64)], line: Option<&Convergence>) -> [Target; 2] {
    let positive = points.iter().filter(|(seconds, error)| *seconds > 0.0 && *error > 0.0);
    let logarithms: Vec<(f64, f64)> = positive.map(|(seconds, error)| (seconds.ln(), error.ln())).collect();
    TARGETS.map(|error| {
        let y = error.ln();
        let crossing = logarithms.windows(2).find(|pair| pair[0].1 >= y && y >= pair[1].1 && pair[0].1 > pair[1].1);
        if let Some([a, b]) = crossing {
            let seconds = (a.0 + (y - a.1) / (b.1 - a.1) * (b.0 - a.0)).exp();
            return Target { error, seconds: Some(seconds), is_extrapolated: false };
        }
        let seconds = line.map(|line| (line.relmse_at(1.0) / error).powf(1.0 / line.slope));
        Target { error, seconds: seconds.filter(|seconds| seconds.is_finite()), is_extrapolated: true }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use burnish_renderer::path::ErrorPoint;

    #[test]
    fn a_target_is_found_between_points_or_on_their_line() {
        let points: Vec<(f64, f64)> = (0..8).map(|i| f64::from(1 << i) * 0.01).map(|t| (t, 0.02 * t.powf(-1.1))).collect();
        let history: Vec<ErrorPoint> =
            points.iter().map(|&(seconds, e)| ErrorPoint { seconds, spp: 1, relmse: e, low: 0.9 * e, high: 1.1 * e }).collect();
        let line = Convergence::fit(&history);
        // Both beyond the end, and with other points both before the beginning.
        for points in [&points[..], &[(5.0, 1e-5)]] {
            for target in targets(points, line.as_ref()) {
                let expected = (0.02 / target.error).powf(1.0 / 1.1);
                assert!(target.is_extrapolated, "{target:?}");
                assert!((target.seconds.unwrap() / expected - 1.0).abs() < 1e-9, "{target:?} {expected}");
            }
        }
        let [within, beyond] = targets(&[(1.0, 0.1), (100.0, 0.0015)], None);
        let expected = (0.1_f64 / 0.01).powf(100_f64.ln() / (0.1_f64 / 0.0015).ln());
        assert!(!within.is_extrapolated && (within.seconds.unwrap() / expected - 1.0).abs() < 1e-9, "{within:?}");
        assert_eq!(beyond.seconds, None);
        assert_eq!(targets(&[(1.0, 0.0)], None).map(|target| target.seconds), [None; 2]);
    }
}

//! How the error of a picture falls with time, and when it will be small enough.
//!
//! The logarithm of the error is fitted by a straight line over the logarithm of the seconds (weights by the width of the intervals).
//! The slope is held where path tracing with low-discrepancy samples can be: 1 for independent samples, more where the picture is smooth.

/// Slopes that are believed.
const SLOPES: std::ops::RangeInclusive<f64> = 0.8..=1.6;
/// The fit looks back to this share of the seconds: four doublings.
const BACK: f64 = 1.0 / 16.0;
/// Points that a fit needs.
const POINTS_MIN: usize = 3;
/// Least uncertainty of the logarithm of a point.
const DEVIATION_MIN: f64 = 0.01;
/// Half width of a 95 % interval in standard deviations.
const HALF_WIDTH: f64 = 1.96;

/// How far a picture was at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorPoint {
    /// Seconds of rendering.
    pub seconds: f64,
    /// Samples per pixel, the mean over the picture.
    pub spp: u32,
    /// Estimated relative mean squared error.
    pub relmse: f64,
    /// Lower end of its 95 % interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// The line `ln relmse = level - slope ln seconds`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Convergence {
    /// How fast the error falls, in `[0.8, 1.6]`: doubling the time divides it by `2^slope`.
    pub slope: f64,
    level: f64,
    /// Middle of the points on the time axis, logarithmic.
    middle: f64,
    /// Variance of the line there, and of its slope.
    variance: f64,
    slope_variance: f64,
    last: ErrorPoint,
    /// Variance of the logarithm of the last point.
    last_variance: f64,
}

/// When a target will be reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// Seconds of rendering, counted from its start.
    pub seconds: f64,
    /// Lower end of the 95 % interval, not below the seconds that have passed.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Convergence {
    /// Fits the end of a history in order of time. `None` with fewer than 3 usable points in the last four doublings. While
    /// any point is more than three standard deviations off the line (caustics have entered, say), the oldest is given up.
    pub fn fit(history: &[ErrorPoint]) -> Option<Self> {
        let is_usable = |p: &&ErrorPoint| p.seconds > 0.0 && p.relmse > 0.0 && p.seconds.is_finite() && p.relmse.is_finite();
        let usable: Vec<ErrorPoint> = history.iter().filter(is_usable).copied().collect();
        let from = usable.last()?.seconds * BACK;
        let mut points: &[ErrorPoint] = &usable[usable.iter().position(|p| p.seconds >= from)?..];
        loop {
            let line = Self::of(points)?;
            let is_off = |p: &ErrorPoint| line.residual(p).abs() > 3.0 * variance(p).sqrt();
            if points.len() == POINTS_MIN || !points.iter().any(is_off) {
                return Some(line);
            }
            points = &points[1..];
        }
    }

    fn of(points: &[ErrorPoint]) -> Option<Self> {
        let last = *points.last()?;
        if points.len() < POINTS_MIN {
            return None;
        }
        let rows: Vec<[f64; 3]> = points.iter().map(|p| [p.seconds.ln(), p.relmse.ln(), 1.0 / variance(p)]).collect();
        let total: f64 = rows.iter().map(|[_, _, w]| w).sum();
        let mean = |of: &dyn Fn(&[f64; 3]) -> f64| rows.iter().map(|row| row[2] * of(row)).sum::<f64>() / total;
        let (x, y) = (mean(&|row| row[0]), mean(&|row| row[1]));
        let spread = mean(&|row| (row[0] - x).powi(2));
        if spread <= 0.0 {
            return None;
        }
        let slope = (-mean(&|row| (row[0] - x) * (row[1] - y)) / spread).clamp(*SLOPES.start(), *SLOPES.end());
        let level = y + slope * x;
        // Points that scatter more than they say are believed less.
        let excess = total * mean(&|row| (row[1] - level + slope * row[0]).powi(2)) / (rows.len() - 2) as f64;
        let scale = excess.max(1.0) / total;
        Some(Self {
            slope,
            level,
            middle: x,
            variance: scale,
            slope_variance: scale / spread,
            last,
            last_variance: variance(&last),
        })
    }

    /// Logarithm of an error, less that of the line.
    fn residual(&self, point: &ErrorPoint) -> f64 {
        point.relmse.ln() - self.level + self.slope * point.seconds.ln()
    }

    /// The error on the line after `seconds` of rendering.
    pub fn relmse_at(&self, seconds: f64) -> f64 {
        (self.level - self.slope * seconds.ln()).exp()
    }

    /// When the error falls to `relmse`. `None` where the last estimate is not above it.
    pub fn seconds_to(&self, relmse: f64) -> Option<Prediction> {
        if !(relmse > 0.0 && self.last.relmse > relmse) {
            return None;
        }
        let x = (self.level - relmse.ln()) / self.slope;
        let variance = self.variance + self.slope_variance * (x - self.middle).powi(2) + self.last_variance;
        let width = HALF_WIDTH * variance.sqrt() / self.slope;
        let not_past = |x: f64| x.exp().max(self.last.seconds);
        let [seconds, low, high] = [x, x - width, x + width].map(not_past);
        (high.is_finite()).then_some(Prediction { seconds, low, high })
    }
}

/// Variance of the logarithm of an error that its interval tells.
fn variance(point: &ErrorPoint) -> f64 {
    let width = (point.high.max(point.relmse) / point.low.max(0.01 * point.relmse)).ln();
    (width / (2.0 * HALF_WIDTH)).max(DEVIATION_MIN).powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn history(slope: f64, count: usize, noise: f64) -> Vec<ErrorPoint> {
        let point = |i: usize| {
            let seconds = 0.5 * 2f64.powi(i as i32);
            let relmse = 0.1 * seconds.powf(-slope) * if i.is_multiple_of(2) { 1.0 + noise } else { 1.0 - noise };
            ErrorPoint { seconds, spp: 4 << i, relmse, low: 0.9 * relmse, high: 1.1 * relmse }
        };
        (0..count).map(point).collect()
    }

    #[test]
    fn a_straight_line_is_found_and_extended() {
        for slope in [0.9, 1.0, 1.3] {
            let line = Convergence::fit(&history(slope, 6, 0.0)).expect("six points");
            assert!((line.slope - slope).abs() < 1e-9);
            assert!((line.relmse_at(3.0) / (0.1 * 3f64.powf(-slope)) - 1.0).abs() < 1e-9);
            let target = 0.1 * 100f64.powf(-slope);
            let prediction = line.seconds_to(target).expect("not reached");
            assert!((prediction.seconds / 100.0 - 1.0).abs() < 1e-9);
            assert!(prediction.low < 95.0 && prediction.high > 105.0 && prediction.high < 200.0, "{prediction:?}");
            assert_eq!(line.seconds_to(1.0), None);
        }
    }

    #[test]
    fn noise_widens_and_extreme_slopes_are_not_believed() {
        let calm = Convergence::fit(&history(1.0, 5, 0.0)).and_then(|line| line.seconds_to(1e-4)).expect("not reached");
        let noisy = Convergence::fit(&history(1.0, 5, 0.2)).and_then(|line| line.seconds_to(1e-4)).expect("not reached");
        assert!(noisy.high / noisy.low > 1.5 * calm.high / calm.low, "{noisy:?} {calm:?}");
        assert_eq!(Convergence::fit(&history(3.0, 5, 0.0)).map(|line| line.slope), Some(1.6));
        assert_eq!(Convergence::fit(&history(0.2, 5, 0.0)).map(|line| line.slope), Some(0.8));
    }

    #[test]
    fn there_is_no_line_through_two_points_and_jumps_start_anew() {
        assert_eq!(Convergence::fit(&history(1.0, 2, 0.0)), None);
        assert_eq!(Convergence::fit(&[]), None);
        let mut jump = history(1.0, 5, 0.0);
        for point in &mut jump[2..] {
            for x in [&mut point.relmse, &mut point.low, &mut point.high] {
                *x *= 3.0;
            }
        }
        let line = Convergence::fit(&jump).expect("three points after the jump");
        assert!((line.slope - 1.0).abs() < 1e-9 && line.residual(&line.last).abs() < 1e-9, "{line:?}");
    }
}

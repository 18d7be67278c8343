//! A logarithmic axis that begins and ends at round numbers, and its ticks.

/// Below this many decades ticks are 1, 2, 5 of every decade, else whole decades.
const FINE_DECADES: f64 = 2.0;
/// Ticks at most where they are whole decades.
const DECADES_MAX: i32 = 6;
/// Values that can stand on an axis.
const RANGE: std::ops::Range<f64> = 1e-30..1e30;
/// What a rounded number may be off.
const TOLERANCE: f64 = 1e-9;

/// Positive numbers on a line, equal ratios equally far apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogAxis {
    low: f64,
    high: f64,
}

impl LogAxis {
    /// From the last of 1, 2, 5 of a decade below all values to the first above them. Values outside [`RANGE`] are left out; without
    /// any, the axis is that of 1.
    pub fn covering(values: impl Iterator<Item = f64>) -> Self {
        let usable = values.filter(|x| RANGE.contains(x));
        let (low, high) = usable.fold((f64::INFINITY, 0.0_f64), |(low, high), x| (low.min(x), high.max(x)));
        let (low, high) = if low <= high { (low, high) } else { (1.0, 1.0) };
        let (low, mut high) = (round_below(low), round_above(high));
        if high <= low {
            high = round_above(low * 1.1);
        }
        Self { low, high }
    }

    /// Where a value stands: 0 at the beginning, 1 at the end, and not beyond.
    pub fn share(&self, value: f64) -> f32 {
        let share = (value.max(f64::MIN_POSITIVE) / self.low).ln() / (self.high / self.low).ln();
        if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) as f32 }
    }

    /// The values that are written at the axis: at least two, in order.
    pub fn ticks(&self) -> Vec<f64> {
        let is_within = |x: &f64| *x >= self.low * (1.0 - TOLERANCE) && *x <= self.high * (1.0 + TOLERANCE);
        let (first, last) = (self.low.log10().floor() as i32, self.high.log10().ceil() as i32);
        let is_fine = (self.high / self.low).log10() < FINE_DECADES - TOLERANCE;
        let steps: &[f64] = if is_fine { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let every = if is_fine { 1 } else { (last - first) / DECADES_MAX + 1 };
        let decades = (first..=last).filter(|decade| decade.rem_euclid(every) == 0);
        decades.flat_map(|decade| steps.iter().map(move |step| step * 10_f64.powi(decade))).filter(is_within).collect()
    }
}

/// The largest of 1, 2, 5 of a decade that is not above `x`.
fn round_below(x: f64) -> f64 {
    let decade = 10_f64.powf(x.log10().floor());
    let step = [5.0, 2.0, 1.0].into_iter().find(|step| step * decade <= x * (1.0 + TOLERANCE)).unwrap_or(1.0);
    step * decade
}

/// The least of 1, 2, 5 of a decade that is not below `x`.
fn round_above(x: f64) -> f64 {
    let decade = 10_f64.powf(x.log10().floor());
    let step = [1.0, 2.0, 5.0].into_iter().find(|step| step * decade >= x * (1.0 - TOLERANCE)).unwrap_or(10.0);
    step * decade
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ticks(values: &[f64]) -> Vec<String> {
        LogAxis::covering(values.iter().copied())
            .ticks()
            .into_iter()
            .map(|tick| crate::widgets::number::format(tick, 3))
            .collect()
    }

    #[test]
    fn ticks_are_round_and_neither_few_nor_many() {
        assert_eq!(ticks(&[1.3, 8.0]), ["1", "2", "5", "10"]);
        assert_eq!(ticks(&[0.31, 0.33]), ["0.2", "0.5"]);
        assert_eq!(ticks(&[0.5]), ["0.5", "1"]);
        assert_eq!(ticks(&[0.03, 2.9]), ["0.1", "1"]);
        assert_eq!(ticks(&[0.1, 10.0]), ["0.1", "1", "10"]);
        assert_eq!(ticks(&[1e-5, 1e5]), ["0.0001", "0.01", "1", "100", "10000"]);
        assert_eq!(ticks(&[]), ["1", "2"]);
        assert_eq!(ticks(&[f64::NAN, -1.0, 0.0, f64::INFINITY, 30.0]), ["20", "50"]);
        for low in [1e-4, 0.07, 0.9, 3.0, 450.0] {
            for span in [1.0, 1.01, 2.0, 7.0, 60.0, 99.0, 1e3, 1e9] {
                let count = ticks(&[low, low * span]).len();
                assert!((2..=8).contains(&count), "{low} {span}: {count}");
            }
        }
    }

    #[test]
    fn all_values_lie_on_the_axis() {
        let axis = LogAxis::covering([0.013, 4.2].into_iter());
        assert_eq!((axis.low, axis.high), (0.01, 5.0));
        assert_eq!([0.01, 5.0, 1e-9, 1e9, 0.0, f64::NAN].map(|x| axis.share(x)), [0.0, 1.0, 0.0, 1.0, 0.0, 0.0]);
        assert!((axis.share(0.05_f64.sqrt()) - 0.5).abs() < 1e-6);
    }
}

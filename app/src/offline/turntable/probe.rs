//! How long a turntable will take, told by a few frames rendered a little.

use burnish_renderer::path::{Convergence, ErrorPoint, Rendering, StopRules};
use serde_json::{Value, json};

/// Samples per pixel of a probe.
const SPP: u32 = 64;
/// Seconds that it takes at most.
const SECONDS: f64 = 20.0;
/// Errors that are always predicted: 1, 2 and 3 %.
const TARGETS: [f64; 3] = [1e-4, 4e-4, 9e-4];

/// Some of the frames that are due, spread over all of them.
pub(super) fn chosen(due: &[u32], count: usize) -> Vec<u32> {
    let count = count.min(due.len());
    (0..count).map(|i| due[i * due.len() / count]).collect()
}

/// When a probe ends.
pub(super) fn rules(rules: &StopRules) -> StopRules {
    StopRules {
        spp: Some(rules.spp.map_or(SPP, |spp| spp.min(SPP))),
        seconds: Some(rules.seconds.map_or(SECONDS, |seconds| seconds.min(SECONDS))),
        relmse: rules.relmse,
    }
}

/// A frame that was rendered a little.
#[derive(Clone, Debug)]
struct Probe {
    name: String,
    history: Vec<ErrorPoint>,
    seconds: f64,
    spp: u32,
}

impl Probe {
    /// Seconds to an error; `None` where it cannot be told.
    fn seconds_to(&self, relmse: f64) -> Option<f64> {
        let last = self.history.last()?;
        if let Some(i) = self.history.iter().position(|point| point.relmse <= relmse) {
            // Between two estimates, as independent samples fall.
            let (reached, before) = (self.history[i], self.history[..i].last().map_or(0.0, |point| point.seconds));
            return Some((reached.seconds * reached.relmse / relmse).max(before));
        }
        let predicted = Convergence::fit(&self.history).and_then(|line| line.seconds_to(relmse));
        // Too few points for a line: independent samples.
        Some(predicted.map_or(last.seconds * last.relmse / relmse, |predicted| predicted.seconds))
    }
}

/// What the probes say.
#[derive(Clone, Debug)]
pub struct Prediction {
    /// The rules of a frame.
    pub rules: StopRules,
    probes: Vec<Probe>,
}

impl Prediction {
    pub(super) fn new(rules: StopRules) -> Self {
        Self { rules, probes: Vec::new() }
    }

    pub(super) fn add(&mut self, name: String, rendering: &Rendering) {
        let spp = rendering.film.spp();
        self.probes.push(Probe { name, history: rendering.history.clone(), seconds: rendering.seconds, spp });
    }

    /// Seconds of each probe to an error (`None`: the number of samples alone), within the rules for samples and time.
    fn seconds(&self, relmse: Option<f64>) -> Option<Vec<f64>> {
        let of = |probe: &Probe| {
            let by_spp = self.rules.spp.map(|spp| probe.seconds / f64::from(probe.spp.max(1)) * f64::from(spp));
            let by_error = match relmse {
                Some(relmse) => Some(probe.seconds_to(relmse)?),
                None => None,
            };
            let rules = [by_error, by_spp, self.rules.seconds];
            let first = rules.into_iter().flatten().fold(f64::INFINITY, f64::min);
            first.is_finite().then_some(first)
        };
        self.probes.iter().map(of).collect()
    }

    /// Seconds that so many frames take to an error within the other rules (`None`: until those alone); `None` where it cannot be told.
    pub fn total(&self, relmse: Option<f64>, frames: usize) -> Option<f64> {
        let seconds = self.seconds(relmse)?;
        (!seconds.is_empty()).then(|| seconds.iter().sum::<f64>() / seconds.len() as f64 * frames as f64)
    }

    /// How many of the probes, and of how many, other rules end before an error.
    pub fn limited(&self, relmse: f64) -> (usize, usize) {
        let (ends, to_error) = (self.seconds(Some(relmse)), self.without_limits().seconds(Some(relmse)));
        let pairs = ends.into_iter().flatten().zip(to_error.into_iter().flatten());
        (pairs.filter(|(end, to_error)| end < to_error).count(), self.probes.len())
    }

    /// The same without other rules than the error.
    #[must_use]
    pub fn without_limits(&self) -> Self {
        Self { rules: StopRules::default(), probes: self.probes.clone() }
    }

    /// The probe that takes longest to an error, and its seconds.
    pub fn slowest(&self, relmse: Option<f64>) -> Option<(&str, f64)> {
        let seconds = self.seconds(relmse)?;
        let slowest = (0..seconds.len()).max_by(|a, b| seconds[*a].total_cmp(&seconds[*b]))?;
        Some((&self.probes[slowest].name, seconds[slowest]))
    }

    /// What is told: the errors by percent, or the rules without an error; seconds of the mean frame and of the slowest.
    fn rows(&self) -> Vec<(Option<f64>, f64, &str, f64)> {
        let mut targets: Vec<Option<f64>> = TARGETS.iter().map(|target| Some(*target)).collect();
        match self.rules.relmse {
            Some(relmse) if !TARGETS.contains(&relmse) => targets.insert(0, Some(relmse)),
            None if self.rules.spp.is_some() || self.rules.seconds.is_some() => targets = vec![None],
            _ => {}
        }
        let row = |target: Option<f64>| {
            let (slowest, seconds) = self.slowest(target)?;
            Some((target, self.total(target, 1)?, slowest, seconds))
        };
        targets.into_iter().filter_map(row).collect()
    }

    /// One line for people, for so many frames.
    pub fn text(&self, frames: usize) -> String {
        let rows = self.rows();
        let goal =
            |target: Option<f64>| target.map_or("with these rules".to_owned(), |t| format!("at {:.3} %", 100.0 * t.sqrt()));
        let goal = |target: Option<f64>| goal(target).replace(".000 %", " %");
        let part =
            |(target, mean, ..): &(Option<f64>, f64, &str, f64)| format!("{} {}", duration(mean * frames as f64), goal(*target));
        let slowest = rows.first().map_or_else(String::new, |(target, _, slowest, seconds)| {
            format!("; the slowest, {slowest}, {} {}", duration(*seconds), goal(*target))
        });
        let parts: Vec<String> = rows.iter().map(part).collect();
        if parts.is_empty() {
            return format!("{} probe frames tell no error yet", self.probes.len());
        }
        format!("{} probe frames: {frames} frames take about {}{slowest}", self.probes.len(), parts.join(", "))
    }

    /// The same for machines.
    pub fn json(&self, frames: usize) -> Value {
        let row = |(target, mean, slowest, seconds): (Option<f64>, f64, &str, f64)| {
            json!({
                "relmse": target,
                "seconds": mean * frames as f64,
                "slowest": slowest,
                "slowest_seconds": seconds,
            })
        };
        Value::Array(self.rows().into_iter().map(row).collect())
    }
}

/// `2 h 3 min`, `31 min`, `22 s`, `0.4 s`.
pub fn duration(seconds: f64) -> String {
    let minutes = (seconds / 60.0).round();
    match seconds {
        s if s < 10.0 => format!("{s:.1} s"),
        s if s < 90.0 => format!("{s:.0} s"),
        _ if minutes < 90.0 => format!("{minutes:.0} min"),
        _ => format!("{:.0} h {:.0} min", (minutes / 60.0).floor(), minutes % 60.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn probe(name: &str, scale: f64) -> Probe {
        let point = |i: i32| {
            let (seconds, relmse) = (scale * 2f64.powi(i), 0.01 / 2f64.powi(i));
            ErrorPoint { seconds, spp: 4 << i, relmse, low: 0.9 * relmse, high: 1.1 * relmse }
        };
        Probe { name: name.to_owned(), history: (0..5).map(point).collect(), seconds: 16.0 * scale, spp: 64 }
    }

    #[test]
    fn totals_come_from_the_mean_and_the_slowest_is_named() {
        let rules = StopRules { relmse: Some(1e-4), ..StopRules::default() };
        let mut prediction = Prediction { rules, probes: vec![probe("a", 0.5), probe("b", 1.0)] };
        // 0.01 after 1 s of slope 1: 100 s to 0.0001.
        let text = prediction.text(120);
        for part in ["2 probe frames: 120 frames", "2 h 30 min at 1 %", "37 min at 2 %", "17 min at 3 %", "b, 2 min at 1 %"] {
            assert!(text.contains(part), "{part}: {text}");
        }
        prediction.rules.seconds = Some(10.0);
        assert!(prediction.text(120).contains("20 min at 1 %"), "no frame takes longer than its limit");
        assert_eq!((prediction.limited(1e-4), prediction.limited(9e-4)), ((2, 2), (1, 2)));
        let total = prediction.without_limits().total(Some(1e-4), 2);
        assert!(total.is_some_and(|total| (total - 150.0).abs() < 1e-6), "{total:?}");
        prediction.rules = StopRules { spp: Some(128), ..StopRules::default() };
        assert!(prediction.text(10).contains("4 min with these rules"), "{}", prediction.text(10));
        assert_eq!(chosen(&[0, 1, 2, 3, 4, 5, 6, 7, 8, 9], 5), [0, 2, 4, 6, 8]);
        assert_eq!((chosen(&[3, 4], 5), chosen(&[], 5)), (vec![3, 4], vec![]));
    }
}

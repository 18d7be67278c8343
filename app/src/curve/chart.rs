//! A curve as SVG: error against seconds, both on log axes.

use super::Curve;
use crate::html::escape;
use std::fmt::Write;

const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 440.0;
/// Left, top, right, bottom of the axes.
const FRAME: [f64; 4] = [74.0, 18.0, 740.0, 386.0];
/// Side of the marks, pixels.
const MARK: f64 = 7.0;

/// A log axis that covers whole decades around the data.
struct Axis {
    low: i32,
    high: i32,
    from: f64,
    to: f64,
}

impl Axis {
    fn new(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Self {
        let (low, high) = values
            .filter(|x| *x > 0.0 && x.is_finite())
            .map(f64::log10)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        if low > high {
            return Self { low: -3, high: 0, from, to };
        }
        let low = low.floor() as i32;
        Self { low, high: (high.ceil() as i32).max(low + 1), from, to }
    }

    fn at(&self, value: f64) -> f64 {
        let share = (value.log10() - f64::from(self.low)) / f64::from(self.high - self.low);
        self.from + share.clamp(0.0, 1.0) * (self.to - self.from)
    }

    /// Values of gridlines, and whether each is a decade.
    fn lines(&self) -> impl Iterator<Item = (f64, bool)> {
        let high = self.high;
        (self.low..=high)
            .flat_map(move |decade| (1..10).map(move |k| (f64::from(k) * 10_f64.powi(decade), k == 1)))
            .take_while(move |(value, _)| *value <= 10_f64.powi(high) * 1.000_001)
    }
}

/// The chart as one `<svg>` element without outside resources; `id` makes its parts' names unique on the page.
pub(super) fn svg(curve: &Curve, id: &str) -> String {
    let [left, top, right, bottom] = FRAME;
    let rows = &curve.rows;
    let x = Axis::new(rows.iter().map(|row| row.seconds), left, right);
    let estimates = || rows.iter().filter_map(|row| row.estimate.map(|estimate| (row.seconds, estimate)));
    let errors = rows.iter().map(|row| row.relmse).chain(estimates().flat_map(|(_, e)| [e.relmse, e.low, e.high]));
    let y = Axis::new(errors, bottom, top);

    let mut svg = format!(
        "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-labelledby=\"{id}-title {id}-desc\">\
         <title id=\"{id}-title\">Error against seconds: {}</title><desc id=\"{id}-desc\">{}</desc>",
        escape(&curve.name),
        escape(&description(curve))
    );
    let mut line = |class: &str, [x1, y1, x2, y2]: [f64; 4]| {
        let _ = write!(svg, "<line class=\"{class}\" x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\"/>");
    };
    for (value, is_decade) in x.lines() {
        line(if is_decade { "grid" } else { "grid fine" }, [x.at(value), top, x.at(value), bottom]);
    }
    for (value, is_decade) in y.lines() {
        line(if is_decade { "grid" } else { "grid fine" }, [left, y.at(value), right, y.at(value)]);
    }
    let mut text = |class: &str, x: f64, y: f64, words: &str| {
        let _ = write!(svg, "<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\">{}</text>", escape(words));
    };
    for (value, _) in x.lines().filter(|(_, is_decade)| *is_decade) {
        text("middle", x.at(value), bottom + 18.0, &format!("{value}"));
    }
    for (value, _) in y.lines().filter(|(_, is_decade)| *is_decade) {
        text("end", left - 8.0, y.at(value) + 4.0, &format!("{value}"));
    }
    text("middle", 0.5 * (left + right), bottom + 40.0, "seconds of rendering");
    let _ = write!(
        svg,
        "<text class=\"middle\" transform=\"translate(16 {:.1}) rotate(-90)\">relMSE (1 % error = 0.0001)</text>",
        0.5 * (top + bottom)
    );

    let is_drawn = |value: f64| value > 0.0 && value.is_finite();
    let estimated: Vec<_> = estimates().filter(|(_, e)| is_drawn(e.relmse) && is_drawn(e.high)).collect();
    let floor = 10_f64.powi(y.low);
    let band = estimated.iter().map(|(s, e)| (*s, e.high)).chain(estimated.iter().rev().map(|(s, e)| (*s, e.low.max(floor))));
    let points = |values: &mut dyn Iterator<Item = (f64, f64)>| -> String {
        values.map(|(seconds, error)| format!("{:.1},{:.1}", x.at(seconds), y.at(error))).collect::<Vec<_>>().join(" ")
    };
    let _ = write!(svg, "<polygon class=\"band\" points=\"{}\"/>", points(&mut band.into_iter()));
    let _ =
        write!(svg, "<polyline class=\"estimate\" points=\"{}\"/>", points(&mut estimated.iter().map(|(s, e)| (*s, e.relmse))));
    let measured: Vec<(f64, f64)> = rows.iter().map(|row| (row.seconds, row.relmse)).filter(|p| is_drawn(p.1)).collect();
    let _ = write!(svg, "<polyline class=\"true\" points=\"{}\"/>", points(&mut measured.iter().copied()));
    for (seconds, estimate) in &estimated {
        let (cx, cy) = (x.at(*seconds), y.at(estimate.relmse));
        let _ = write!(svg, "<circle class=\"estimate mark\" cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"{:.1}\"/>", 0.5 * MARK);
    }
    for row in rows.iter().filter(|row| is_drawn(row.relmse)) {
        let (mx, my) = (x.at(row.seconds) - 0.5 * MARK, y.at(row.relmse) - 0.5 * MARK);
        let _ = write!(
            svg,
            "<rect class=\"true mark\" x=\"{mx:.1}\" y=\"{my:.1}\" width=\"{MARK}\" height=\"{MARK}\">\
             <title>{} spp, {:.3} s: relMSE {:.3e}</title></rect>",
            row.spp, row.seconds, row.relmse
        );
    }
    legend(&mut svg, right - 262.0, top + 12.0);
    svg + "</svg>"
}

/// Marks and lines with their meaning: shapes and dashes tell them apart without colour.
fn legend(svg: &mut String, x: f64, y: f64) {
    let _ = write!(svg, "<rect class=\"legend\" x=\"{x}\" y=\"{y}\" width=\"250\" height=\"66\"/>");
    let entry = |row: f64| (x + 10.0, x + 38.0, y + 16.0 + 18.0 * row);
    let (a, b, at) = entry(0.0);
    let _ = write!(
        svg,
        "<line class=\"true\" x1=\"{a}\" y1=\"{at}\" x2=\"{b}\" y2=\"{at}\"/>\
         <rect class=\"true mark\" x=\"{}\" y=\"{}\" width=\"{MARK}\" height=\"{MARK}\"/>\
         <text x=\"{}\" y=\"{}\">error against the reference</text>",
        0.5 * (a + b - MARK),
        at - 0.5 * MARK,
        b + 8.0,
        at + 4.0
    );
    let (a, b, at) = entry(1.0);
    let _ = write!(
        svg,
        "<line class=\"estimate\" x1=\"{a}\" y1=\"{at}\" x2=\"{b}\" y2=\"{at}\"/>\
         <circle class=\"estimate mark\" cx=\"{}\" cy=\"{at}\" r=\"{}\"/>\
         <text x=\"{}\" y=\"{}\">the renderer's own estimate</text>",
        0.5 * (a + b),
        0.5 * MARK,
        b + 8.0,
        at + 4.0
    );
    let (a, b, at) = entry(2.0);
    let _ = write!(
        svg,
        "<rect class=\"band\" x=\"{a}\" y=\"{}\" width=\"{}\" height=\"12\"/><text x=\"{}\" y=\"{}\">its 95 % interval</text>",
        at - 6.0,
        b - a,
        b + 8.0,
        at + 4.0
    );
}

/// The curve in a sentence, for readers who do not see it.
fn description(curve: &Curve) -> String {
    match (curve.rows.first(), curve.rows.last()) {
        (Some(first), Some(last)) => format!(
            "From relMSE {:.3e} after {:.3} s ({} spp) to {:.3e} after {:.2} s ({} spp). The table holds all values.",
            first.relmse, first.seconds, first.spp, last.relmse, last.seconds, last.spp
        ),
        _ => "No picture was finished.".to_owned(),
    }
}

//! Estimated error over time on two logarithmic axes: the estimates with their interval, the line through them, and when that
//! reaches the target.

use super::axis::LogAxis;
use crate::theme;
use crate::widgets::number;
use burnish_renderer::path::{Convergence, ErrorPoint, Prediction};
use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Role, Sense, Shape, Stroke, Ui, WidgetInfo, pos2, vec2};

/// Height that the plot needs with its axis.
const PLOT_MIN: f32 = 60.0;
/// Height of the text at a mark of an axis.
const LABEL: f32 = 14.0;

/// The estimates of a picture, and what they tell about its future.
#[derive(Clone, Debug)]
pub struct ErrorCurve {
    points: Vec<ErrorPoint>,
    line: Convergence,
    target: Option<f64>,
    prediction: Option<Prediction>,
}

impl ErrorCurve {
    /// `None` where there are too few estimates for a line: fewer than three. `target` is a relMSE; when it is reached is
    /// predicted unless rendering has ended.
    pub fn new(history: &[ErrorPoint], target: Option<f64>, is_done: bool) -> Option<Self> {
        let line = Convergence::fit(history)?;
        let prediction = target.filter(|_| !is_done).and_then(|target| line.seconds_to(target));
        let points = history.iter().filter(|p| p.seconds > 0.0 && p.relmse > 0.0).copied().collect();
        Some(Self { points, line, target, prediction })
    }

    /// How fast the error falls.
    fn slope(&self) -> String {
        format!("error² falls as t^−{:.1}", self.line.slope)
    }

    /// When the target is reached.
    fn forecast(&self) -> Option<String> {
        let Prediction { seconds, low, high } = self.prediction?;
        let (target, [seconds, low, high]) = (percent(self.target?), [seconds, low, high].map(duration));
        Some(format!("{target} % after about {seconds} ({low} to {high})"))
    }

    /// All of it in words, for readers who do not see it.
    pub fn sentence(&self) -> String {
        let mut text = "Error against time".to_owned();
        if let Some(last) = self.points.last() {
            text += &format!(
                ": estimated error {} % ({} to {} %) after {} and {} samples per pixel",
                percent(last.relmse),
                percent(last.low),
                percent(last.high),
                duration(last.seconds),
                last.spp
            );
        }
        text += &format!("; {}", self.slope());
        match (self.forecast(), self.target) {
            (Some(forecast), _) => text += &format!("; predicted: {forecast}"),
            (None, Some(target)) => text += &format!("; target {} %", percent(target)),
            (None, None) => {}
        }
        text + "."
    }
}

/// A relMSE as the error that is shown: its square root, in percent.
pub fn percent(relmse: f64) -> String {
    number::format(100.0 * relmse.max(0.0).sqrt(), 2)
}

/// Seconds as people say them.
pub fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 120.0 => format!("{} s", number::format(s, 2)),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s if s < 172_800.0 => format!("{:.0} h", s / 3600.0),
        s => format!("{:.0} days", s / 86_400.0),
    }
}

/// Shows the chart in a rectangle.
pub fn show(ui: &Ui, rect: Rect, curve: &ErrorCurve) {
    let response = ui.interact(rect, ui.scope_id().with("error chart"), Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, curve.sentence()));
    paint(&ui.painter_at(rect), rect, curve);
    response.on_hover_text(curve.sentence());
}

fn paint(painter: &Painter, rect: Rect, curve: &ErrorCurve) {
    painter.rect_filled(rect, 4, Color32::from_black_alpha(200));
    let font = FontId::proportional(11.0);
    let mut top = rect.top() + 5.0;
    // What leaves no room for the plot is left to the tooltip.
    let mut say = |text: String, color| {
        let galley = painter.layout(text, font.clone(), color, rect.width() - 16.0);
        if top + galley.size().y + PLOT_MIN < rect.bottom() {
            let bottom = top + galley.size().y;
            painter.galley(pos2(rect.left() + 8.0, top), galley, color);
            top = bottom;
        }
    };
    say("estimated error, % over seconds".into(), theme::ON_PICTURE.weak);
    say(curve.slope(), theme::ON_PICTURE.text);
    if let Some(forecast) = curve.forecast() {
        say(forecast, theme::ON_PICTURE.text);
    }
    let plot = Rect::from_min_max(pos2(rect.left() + 36.0, top + 8.0), rect.max - vec2(14.0, 19.0));
    if plot.width() < 20.0 || plot.height() < 20.0 {
        return;
    }
    let axes = Axes::new(curve, plot);
    axes.paint(painter, &font);

    // Piece by piece, as only convex shapes can be filled.
    for pair in curve.points.windows(2) {
        let [a, b] = [pair[0], pair[1]];
        let corners = [(a.seconds, a.low), (a.seconds, a.high), (b.seconds, b.high), (b.seconds, b.low)];
        let corners = corners.map(|(seconds, relmse)| axes.place(seconds, relmse)).to_vec();
        painter.add(Shape::convex_polygon(corners, theme::ON_PICTURE.accent.gamma_multiply(0.28), Stroke::NONE));
    }
    let dashed = |from: Pos2, to: Pos2, color| {
        painter.extend(Shape::dashed_line(&[from, to], Stroke::new(1.0, color), 4.0, 3.0));
    };
    if let Some(target) = curve.target {
        let y = axes.place(1.0, target).y;
        dashed(pos2(plot.left(), y), pos2(plot.right(), y), theme::ON_PICTURE.good);
        let text = format!("{} %", percent(target));
        painter.text(pos2(plot.left() + 3.0, y - 1.0), Align2::LEFT_BOTTOM, text, font, theme::ON_PICTURE.good);
    }
    let places: Vec<Pos2> = curve.points.iter().map(|p| axes.place(p.seconds, p.relmse)).collect();
    if let (Some(prediction), Some(target), Some(last)) = (curve.prediction, curve.target, curve.points.last()) {
        let end = axes.place(prediction.seconds, target);
        dashed(axes.place(last.seconds, curve.line.relmse_at(last.seconds)), end, theme::ON_PICTURE.text);
        let [low, high] = [prediction.low, prediction.high].map(|seconds| axes.place(seconds, target).x);
        painter.hline(low..=high, end.y, Stroke::new(3.0, theme::ON_PICTURE.good));
        painter.circle(end, 3.5, Color32::BLACK, Stroke::new(1.5, theme::ON_PICTURE.good));
    }
    if let Some(last) = places.last() {
        painter.circle_filled(*last, 3.0, theme::ON_PICTURE.accent);
    }
    painter.line(places, Stroke::new(1.5, theme::ON_PICTURE.accent));
}

/// Seconds to the right, error upwards.
struct Axes {
    seconds: LogAxis,
    percent: LogAxis,
    plot: Rect,
}

impl Axes {
    fn new(curve: &ErrorCurve, plot: Rect) -> Self {
        let errors = curve.points.iter().flat_map(|p| [p.relmse, p.low, p.high]).chain(curve.target);
        let seconds = curve.points.iter().map(|p| p.seconds).chain(curve.prediction.map(|p| p.seconds));
        Self { seconds: LogAxis::covering(seconds), percent: LogAxis::covering(errors.map(|e| 100.0 * e.sqrt())), plot }
    }

    fn place(&self, seconds: f64, relmse: f64) -> Pos2 {
        let (x, y) = (self.seconds.share(seconds), self.percent.share(100.0 * relmse.sqrt()));
        pos2(self.plot.left() + x * self.plot.width(), self.plot.bottom() - y * self.plot.height())
    }

    /// Lines and numbers; a number that would touch the last one is left out.
    fn paint(&self, painter: &Painter, font: &FontId) {
        let (plot, grid) = (self.plot, Stroke::new(1.0, Color32::from_gray(62)));
        let mut end = f32::NEG_INFINITY;
        for tick in self.seconds.ticks() {
            let x = plot.left() + self.seconds.share(tick) * plot.width();
            painter.vline(x, plot.y_range(), grid);
            let galley = painter.layout_no_wrap(number::format(tick, 1), font.clone(), theme::ON_PICTURE.weak);
            let left = x - 0.5 * galley.size().x;
            if left > end + 5.0 {
                end = left + galley.size().x;
                painter.galley(pos2(left, plot.bottom() + 3.0), galley, theme::ON_PICTURE.weak);
            }
        }
        let mut end = f32::INFINITY;
        for tick in self.percent.ticks() {
            let y = plot.bottom() - self.percent.share(tick) * plot.height();
            painter.hline(plot.x_range(), y, grid);
            if y < end - LABEL {
                end = y;
                let place = pos2(plot.left() - 5.0, y);
                painter.text(place, Align2::RIGHT_CENTER, number::format(tick, 1), font.clone(), theme::ON_PICTURE.weak);
            }
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Estimates of `0.04 / seconds` with an interval of a fifth.
    pub fn history(count: i32) -> Vec<ErrorPoint> {
        let point = |i: i32| {
            let seconds = 0.5 * 2_f64.powi(i);
            let relmse = 0.04 / seconds;
            ErrorPoint { seconds, spp: 4 << i, relmse, low: relmse / 1.2, high: relmse * 1.2 }
        };
        (0..count).map(point).collect()
    }

    #[test]
    fn the_curve_says_its_numbers() {
        assert!(ErrorCurve::new(&history(2), Some(1e-4), false).is_none());
        let curve = ErrorCurve::new(&history(5), Some(1e-4), false).expect("five estimates");
        let text = curve.sentence();
        let begin = "Error against time: estimated error 7.1 % (6.5 to 7.7 %) after 8 s and 64 samples per pixel; \
                     error² falls as t^−1.0; predicted: 1 % after about 7 min (";
        assert!(text.starts_with(begin), "{text}");
        // Reached, or not asked for: nothing is predicted.
        let reached = ErrorCurve::new(&history(5), Some(0.01), false).expect("five estimates").sentence();
        assert!(reached.ends_with("t^−1.0; target 10 %."), "{reached}");
        let done = ErrorCurve::new(&history(5), Some(1e-4), true).expect("five estimates").sentence();
        assert!(done.ends_with("t^−1.0; target 1 %."), "{done}");
        let free = ErrorCurve::new(&history(5), None, false).expect("five estimates").sentence();
        assert!(free.ends_with("t^−1.0."), "{free}");
    }

    #[test]
    fn durations_in_fitting_units() {
        assert_eq!([0.123, 9.0, 61.4, 400.0, 7300.0, 2e5].map(duration), ["0.12 s", "9 s", "61 s", "7 min", "2 h", "2 days"]);
    }

    #[test]
    fn the_chart_can_be_drawn_in_any_rectangle() {
        let ctx = egui::Context::default();
        let curve = ErrorCurve::new(&history(5), Some(1e-4), false).expect("five estimates");
        for size in [vec2(0.0, 0.0), vec2(30.0, 400.0), vec2(400.0, 30.0), vec2(400.0, 300.0)] {
            let mut output =
                ctx.run_ui(egui::RawInput::default(), |ui| show(ui, Rect::from_min_size(pos2(9.0, 9.0), size), &curve));
            // Nothing is shown here, so the font's texture is dropped on purpose.
            output.textures_delta.clear();
        }
    }
}

//! Estimated error over time on two logarithmic axes, drawn by hand: one line, few ticks.

use crate::theme;
use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Stroke, pos2, vec2};

/// Size of the chart.
pub const SIZE: egui::Vec2 = vec2(210.0, 118.0);

/// Draws `history`, pairs of seconds and relMSE, into `rect`. The error shown is its square root, in percent.
pub fn paint(painter: &Painter, rect: Rect, history: &[(f64, f64)], goal_relmse: Option<f64>) {
    painter.rect_filled(rect, 4, Color32::from_black_alpha(200));
    let font = FontId::proportional(10.5);
    painter.text(
        rect.left_top() + vec2(8.0, 5.0),
        Align2::LEFT_TOP,
        "estimated error, % over seconds",
        font.clone(),
        theme::WEAK,
    );
    let points: Vec<(f64, f64)> = history
        .iter()
        .filter(|(s, e)| *s > 0.0 && *e > 0.0 && s.is_finite() && e.is_finite())
        .map(|(s, e)| (s.log10(), (100.0 * e.sqrt()).log10()))
        .collect();
    let plot = Rect::from_min_max(rect.min + vec2(34.0, 22.0), rect.max - vec2(10.0, 18.0));
    if points.len() < 2 {
        painter.text(plot.center(), Align2::CENTER_CENTER, "waiting for a second estimate", font, theme::WEAK);
        return;
    }
    let goal = goal_relmse.filter(|e| *e > 0.0).map(|e| (100.0 * e.sqrt()).log10());
    let decades = |low: f64, high: f64| (low.floor(), if high.ceil() > low.floor() { high.ceil() } else { low.floor() + 1.0 });
    let min = |pick: fn(&(f64, f64)) -> f64| points.iter().map(pick).fold(f64::INFINITY, f64::min);
    let max = |pick: fn(&(f64, f64)) -> f64| points.iter().map(pick).fold(f64::NEG_INFINITY, f64::max);
    let (x0, x1) = decades(min(|p| p.0), max(|p| p.0));
    let (y0, y1) = decades(min(|p| p.1).min(goal.unwrap_or(f64::INFINITY)), max(|p| p.1));
    let place = |x: f64, y: f64| -> Pos2 {
        let u = ((x - x0) / (x1 - x0)) as f32;
        let v = ((y - y0) / (y1 - y0)) as f32;
        pos2(plot.left() + u * plot.width(), plot.bottom() - v * plot.height())
    };
    let grid = Stroke::new(1.0, Color32::from_gray(62));
    // Decades only: ticks between them would not be readable at this size.
    for decade in x0 as i32..=x1 as i32 {
        let x = place(f64::from(decade), y0).x;
        painter.vline(x, plot.y_range(), grid);
        painter.text(pos2(x, plot.bottom() + 3.0), Align2::CENTER_TOP, power(decade), font.clone(), theme::WEAK);
    }
    for decade in y0 as i32..=y1 as i32 {
        let y = place(x0, f64::from(decade)).y;
        painter.hline(plot.x_range(), y, grid);
        painter.text(pos2(plot.left() - 4.0, y), Align2::RIGHT_CENTER, power(decade), font.clone(), theme::WEAK);
    }
    if let Some(goal) = goal {
        let y = place(x0, goal).y;
        painter.extend(egui::Shape::dashed_line(
            &[pos2(plot.left(), y), pos2(plot.right(), y)],
            Stroke::new(1.0, theme::GOOD),
            4.0,
            3.0,
        ));
    }
    let line: Vec<Pos2> = points.iter().map(|(x, y)| place(*x, *y)).collect();
    if let Some(last) = line.last() {
        painter.circle_filled(*last, 2.5, theme::ACCENT);
    }
    painter.line(line, Stroke::new(1.5, theme::ACCENT));
}

fn power(decade: i32) -> String {
    if (-3..=4).contains(&decade) { format!("{}", 10f64.powi(decade)) } else { format!("1e{decade}") }
}

/// Seconds until the error reaches `goal` if it goes on falling as it did, with one over the square root of time.
pub fn seconds_to(goal_relmse: f64, seconds: f64, relmse: f64) -> Option<f64> {
    let rest = seconds * (relmse / goal_relmse - 1.0);
    (rest.is_finite() && rest > 0.0).then_some(rest)
}

#[cfg(test)]
mod tests {
    #[test]
    fn time_to_a_goal() {
        assert_eq!(super::seconds_to(1e-4, 10.0, 4e-4), Some(30.0));
        assert_eq!(super::seconds_to(1e-4, 10.0, 1e-5), None);
        assert_eq!(super::seconds_to(0.0, 10.0, 1e-5), None);
    }
}

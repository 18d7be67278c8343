//! Curves as JSON, as CSV and as a page that needs nothing beside itself.

use super::chart::svg;
use super::{Curve, Row, Target, targets};
use crate::html::{self, escape};
use burnish_renderer::path::{Convergence, ErrorPoint};
use serde_json::{Value, json};

const STYLE: &str = include_str!("report.css");

impl Curve {
    /// The line through an error of the rows that have an estimate, each as uncertain as its estimate says.
    fn line(&self, error: fn(&Row) -> f64) -> Option<Convergence> {
        let point = |row: &Row| {
            let (relmse, estimate) = (error(row), row.estimate?);
            let scale = relmse / estimate.relmse;
            Some(ErrorPoint {
                seconds: row.seconds,
                spp: row.spp,
                relmse,
                low: scale * estimate.low,
                high: scale * estimate.high,
            })
        };
        Convergence::fit(&self.rows.iter().filter_map(point).collect::<Vec<_>>())
    }

    fn slope(&self, error: fn(&Row) -> f64) -> Option<f64> {
        self.line(error).map(|line| line.slope)
    }

    /// When the error reaches each target, plain and trimmed.
    pub fn targets(&self) -> [[Target; 2]; 2] {
        let errors: [fn(&Row) -> f64; 2] = [|row| row.relmse, |row| row.relmse_trimmed];
        errors.map(|error| {
            let points: Vec<(f64, f64)> = self.rows.iter().map(|row| (row.seconds, error(row))).collect();
            targets(&points, self.line(error).as_ref())
        })
    }
}

/// A curve as one JSON object.
pub fn json(curve: &Curve) -> Value {
    let rows: Vec<Value> = curve
        .rows
        .iter()
        .map(|row| {
            json!({
                "seconds": row.seconds,
                "spp": row.spp,
                "relmse_estimate": row.estimate.map(|e| e.relmse),
                "relmse_low": row.estimate.map(|e| e.low),
                "relmse_high": row.estimate.map(|e| e.high),
                "is_firefly_limited": row.estimate.map(|e| e.is_firefly_limited),
                "relmse": row.relmse,
                "relmse_trimmed": row.relmse_trimmed,
                "flip": row.flip,
            })
        })
        .collect();
    let [plain, trimmed] = curve.targets();
    let targets: Vec<Value> = plain
        .iter()
        .zip(&trimmed)
        .map(|(plain, trimmed)| {
            json!({
                "relmse": plain.error,
                "seconds": plain.seconds,
                "is_extrapolated": plain.is_extrapolated,
                "trimmed_seconds": trimmed.seconds,
                "trimmed_is_extrapolated": trimmed.is_extrapolated,
            })
        })
        .collect();
    let reference = &curve.reference;
    json!({
        "name": curve.name,
        "width": curve.settings.width,
        "height": curve.settings.height,
        "threads": curve.settings.threads,
        "seed": curve.settings.seed,
        "rows": rows,
        "slope": curve.slope(|row| row.relmse),
        "slope_trimmed": curve.slope(|row| row.relmse_trimmed),
        "targets": targets,
        "reference": {
            "kind": if reference.file.is_some() { "file" } else { "own" },
            "file": reference.file,
            "spp": reference.spp,
            "seed": reference.seed,
            "seconds": reference.seconds,
            "relmse_of_reference": reference.relmse(),
            "is_subtracted": reference.variance.is_some(),
        },
        "stop_reason": curve.stop_reason.word(),
        "load_seconds": curve.load_seconds,
        "samples_per_second": curve.samples_per_second,
        "nonfinite_samples": curve.nonfinite,
    })
}

/// Curves as comma-separated values with a line of names. A value that is not known is empty.
pub fn csv(curves: &[Curve]) -> String {
    let mut text = "name,seconds,spp,relmse_estimate,relmse_low,relmse_high,relmse,relmse_trimmed,flip\n".to_owned();
    for curve in curves {
        let name = format!("\"{}\"", curve.name.replace('"', "\"\""));
        for row in &curve.rows {
            let number = |x: Option<f64>| x.map_or_else(String::new, |x| x.to_string());
            let estimate = row.estimate;
            let fields = [
                name.clone(),
                row.seconds.to_string(),
                row.spp.to_string(),
                number(estimate.map(|e| e.relmse)),
                number(estimate.map(|e| e.low)),
                number(estimate.map(|e| e.high)),
                row.relmse.to_string(),
                row.relmse_trimmed.to_string(),
                row.flip.to_string(),
            ];
            text += &(fields.join(",") + "\n");
        }
    }
    text
}

/// Curves as a page: per curve a chart, its slope and times, and all values as a table.
pub fn html(title: &str, curves: &[Curve]) -> String {
    let sections: String = curves.iter().enumerate().map(|(i, curve)| section(curve, i)).collect();
    let body = format!(
        "<h1>{}</h1>\n<p>relMSE is the mean over pixels and channels of (x − r)² / (r² + 0.01), r the reference; trimmed, it leaves out the worst \
         0.1 % of pixels. Seconds are rendering alone.</p>\n{sections}",
        escape(title)
    );
    html::page(title, STYLE, &body)
}

fn section(curve: &Curve, i: usize) -> String {
    let Curve { settings, reference, .. } = curve;
    let made = match (&reference.file, reference.spp, reference.seed) {
        (Some(file), ..) => format!("the picture {}", escape(file)),
        (None, Some(spp), Some(seed)) => format!("a rendering of {spp} samples per pixel with seed {seed}"),
        _ => "a rendering".to_owned(),
    };
    let noise = match reference.relmse() {
        Some(relmse) => format!("its own noise, relMSE {relmse:.2e}, is taken off"),
        None => "its own noise is not known and counts as error".to_owned(),
    };
    let slope = curve
        .slope(|row| row.relmse)
        .map_or_else(String::new, |slope| format!("Slope: relMSE falls as time<sup>−{slope:.2}</sup>. "));
    let [plain, trimmed] = curve.targets();
    let time = |target: &Target| match target.seconds {
        Some(seconds) => format!("{seconds:.3} s{}", if target.is_extrapolated { " (predicted)" } else { "" }),
        None => "not known".to_owned(),
    };
    let times: String = plain
        .iter()
        .zip(&trimmed)
        .map(|(plain, trimmed)| format!("To {}: {}; trimmed: {}. ", plain.error, time(plain), time(trimmed)))
        .collect();
    let rows: String = curve.rows.iter().map(table_row).collect();
    format!(
        "<section>\n<h2>{}</h2>\n<p>{} × {} pixels, {} threads, seed {}, {:.2e} samples per second, stopped by {}. Reference: {made}; {noise}.</p>\n\
         <figure>{}</figure>\n<p>{slope}{times}</p>\n<div class=\"scroll\"><table>\n<caption>All pictures of the curve</caption>\n<thead><tr>\
         <th scope=\"col\">seconds</th><th scope=\"col\">samples per pixel</th><th scope=\"col\">relMSE</th><th scope=\"col\">trimmed</th>\
         <th scope=\"col\">estimate</th><th scope=\"col\">95 % interval</th><th scope=\"col\">FLIP</th></tr></thead>\n<tbody>\n{rows}</tbody>\n\
         </table></div>\n</section>\n",
        escape(&curve.name),
        settings.width,
        settings.height,
        settings.threads,
        settings.seed,
        curve.samples_per_second,
        curve.stop_reason.word(),
        svg(curve, &format!("chart{i}")),
    )
}

fn table_row(row: &Row) -> String {
    let (estimate, interval) = match row.estimate {
        Some(e) => {
            let note = if e.is_firefly_limited { " (few bright pixels)" } else { "" };
            (format!("{:.3e}{note}", e.relmse), format!("{:.3e} to {:.3e}", e.low, e.high))
        }
        None => ("–".to_owned(), "–".to_owned()),
    };
    format!(
        "<tr><td>{:.3}</td><td>{}</td><td>{:.3e}</td><td>{:.3e}</td><td>{estimate}</td><td>{interval}</td><td>{:.4}</td></tr>\n",
        row.seconds, row.spp, row.relmse, row.relmse_trimmed, row.flip
    )
}

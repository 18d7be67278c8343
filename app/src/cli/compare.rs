//! `burnish compare`: how far a picture is from another.

use super::render::{relmse, transform};
use super::scene_options::finite;
use super::target::{has_ending, refuse_target};
use super::{CliError, Outcome, interrupt, print_out};
use crate::files::save_atomic;
use crate::heatmap::heatmap;
use crate::picture_file::read_picture;
use burnish_renderer::metrics::{flip, mean, quantile, relative_error};
use burnish_renderer::tonemap::{Display, DisplayTransform};
use clap::Args;
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Arguments of `burnish compare`.
#[derive(Debug, Args)]
pub struct CompareArguments {
    /// Picture that is judged: .png, .jpg, .exr or .hdr
    #[arg(value_name = "A")]
    picture: PathBuf,
    /// Picture that counts as the truth, of the same size
    #[arg(value_name = "B")]
    reference: PathBuf,
    /// Exit code 1 where a metric is above a value: relmse, relmse_trimmed (numbers or percentages), flip_mean, flip_p99. Repeatable
    #[arg(long, value_name = "METRIC=VALUE", allow_hyphen_values = true, value_parser = limit)]
    limit: Vec<Limit>,
    /// Draws FLIP per pixel, 0 dark blue to 1 yellow
    #[arg(long, value_name = "FILE.png")]
    heatmap: Option<PathBuf>,
    /// How radiance becomes the colours that FLIP compares; for .exr and .hdr
    #[arg(long, value_name = "neutral|agx|aces|standard", default_value = "neutral", value_parser = transform)]
    display_transform: DisplayTransform,
    /// Stops by which radiance is shown brighter; for .exr and .hdr
    #[arg(long, value_name = "EV", default_value_t = 0.0, allow_hyphen_values = true, value_parser = finite)]
    exposure: f64,
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
}

/// A metric and the value it must not exceed.
#[derive(Clone, Debug, PartialEq)]
struct Limit {
    metric: Metric,
    value: f64,
}

/// Metrics that can be limited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Metric {
    Relmse,
    RelmseTrimmed,
    FlipMean,
    FlipP99,
}

impl Metric {
    const ALL: [(Self, &'static str); 4] = [
        (Self::Relmse, "relmse"),
        (Self::RelmseTrimmed, "relmse_trimmed"),
        (Self::FlipMean, "flip_mean"),
        (Self::FlipP99, "flip_p99"),
    ];

    fn word(self) -> &'static str {
        Self::ALL[self as usize].1
    }
}

/// Compares, writes and prints.
pub fn run(arguments: &CompareArguments) -> Result<Outcome, CliError> {
    if let Some(path) = &arguments.heatmap {
        if !has_ending(path, "png") {
            let sentence = format!("--heatmap: {}: expected a file name that ends in .png", path.display());
            return Err(CliError::unusable(sentence));
        }
        refuse_target("--heatmap", path)?;
    }
    let a = read_picture(&arguments.picture).map_err(CliError::unusable)?;
    let b = read_picture(&arguments.reference).map_err(CliError::unusable)?;
    b.expect_size([a.width, a.height], a.path.display()).map_err(CliError::unusable)?;
    interrupt::check()?;

    let error = relative_error(&a.pixels, &b.pixels, None);
    let display = Display { exposure_ev: arguments.exposure as f32, transform: arguments.display_transform };
    let errors = flip(&a.shown(display), &b.shown(display), a.width);
    interrupt::check()?;
    let flip_mean = errors.iter().map(|e| f64::from(*e)).sum::<f64>() / errors.len().max(1) as f64;
    let values = [error.relmse, error.trimmed, flip_mean, quantile(&errors, 0.99)];
    let (mean_a, mean_b) = (mean(&a.pixels), mean(&b.pixels));
    if let Some(path) = &arguments.heatmap {
        write_heatmap(path, &errors, a.width)?;
    }

    let is_over = |limit: &&Limit| values[limit.metric as usize] > limit.value;
    let over: Vec<&Limit> = arguments.limit.iter().filter(is_over).collect();
    let over_text =
        |limit: &&Limit| format!("{}: {} is over {}", limit.metric.word(), values[limit.metric as usize], limit.value);
    let text = if arguments.json {
        let mut object = json!({ "a": arguments.picture, "b": arguments.reference, "width": a.width, "height": a.height });
        for (metric, word) in Metric::ALL {
            object[word] = values[metric as usize].into();
        }
        let average = |mean: [f64; 3]| mean.iter().sum::<f64>() / 3.0;
        object["mean_a"] = average(mean_a).into();
        object["mean_b"] = average(mean_b).into();
        object["mean_rgb_a"] = mean_a.to_vec().into();
        object["mean_rgb_b"] = mean_b.to_vec().into();
        let limits = arguments
            .limit
            .iter()
            .map(|limit| json!({ "metric": limit.metric.word(), "limit": limit.value, "holds": !is_over(&limit) }));
        object["limits"] = Value::Array(limits.collect());
        object["heatmap"] = json!(arguments.heatmap);
        object.to_string()
    } else {
        let numbers = Metric::ALL.map(|(metric, word)| format!("{word:<15} {:.6}\n", values[metric as usize])).concat();
        let means = [("mean_a", mean_a), ("mean_b", mean_b)]
            .map(|(word, [r, g, b])| format!("{word:<15} {r:.6} {g:.6} {b:.6}\n"))
            .concat();
        let over: String = over.iter().map(|limit| over_text(limit) + "\n").collect();
        numbers + &means + &over
    };
    print_out(&text)?;
    if arguments.json {
        over.iter().for_each(|limit| eprintln!("{}", over_text(limit)));
    }
    Ok(if over.is_empty() { Outcome::Done } else { Outcome::Findings })
}

/// Writes values per pixel as a picture.
pub(super) fn write_heatmap(path: &Path, errors: &[f32], width: usize) -> Result<(), CliError> {
    let map = heatmap(errors, width);
    let mut bytes = Vec::new();
    // Pictures that can be read have sides far below the limit of PNG.
    let (width, height) = (map.width as u32, map.height as u32);
    PngEncoder::new(&mut bytes)
        .write_image(&map.bytes, width, height, ExtendedColorType::Rgb8)
        .map_err(|error| CliError::unusable(format!("--heatmap: {}: cannot be written: {error}", path.display())))?;
    save_atomic(path, &bytes).map_err(CliError::unusable)
}

fn limit(text: &str) -> Result<Limit, String> {
    let names = || Metric::ALL.map(|(_, word)| word).join(", ");
    let expected = || format!("expected METRIC=VALUE with a metric among {}", names());
    let (name, value) = text.split_once('=').ok_or_else(expected)?;
    let metric = Metric::ALL.iter().find(|(_, word)| word.eq_ignore_ascii_case(name.trim())).ok_or_else(expected)?.0;
    // 0 asks for equal pictures.
    let number = finite(value.trim()).ok().filter(|x| *x >= 0.0);
    let is_relmse = matches!(metric, Metric::Relmse | Metric::RelmseTrimmed);
    let value = match number {
        Some(value) => value,
        None if is_relmse => relmse(value)?,
        None => return Err(format!("expected a number of 0 or more for {}, found `{value}`", metric.word())),
    };
    Ok(Limit { metric, value })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_metrics_with_values() {
        assert_eq!(limit("relmse=0.5"), Ok(Limit { metric: Metric::Relmse, value: 0.5 }));
        assert_eq!(limit("FLIP_p99 = 0"), Ok(Limit { metric: Metric::FlipP99, value: 0.0 }));
        assert!((limit("relmse_trimmed=2%").unwrap().value - 0.0004).abs() < 1e-12);
        for text in ["", "relmse", "relmse=", "relmse=-1", "relmse=NaN", "speed=1", "flip_mean=2%", "flip_mean=inf"] {
            assert!(limit(text).is_err(), "{text}");
        }
    }
}

//! The difference view: FLIP between preview and final view, pixel by pixel, computed on a thread whenever one of them got better.

use crate::heatmap;
use crate::live_preview::LivePreview;
use burnish_renderer::metrics::{flip, quantile};
use burnish_renderer::tonemap::Display;
use burnish_renderer::worker::Snapshot;
use egui::{Color32, ColorImage, Context, TextureHandle, TextureOptions};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant};

/// Between two comparisons: reading the preview back holds the window up for a moment.
const PAUSE: Duration = Duration::from_millis(400);

/// What a comparison found.
struct Found {
    image: ColorImage,
    mean: f64,
    p99: f64,
}

/// A picture in `width` times `height` pixels, no more than it has: means of the pixels whose middles fall into one.
fn reduced(snapshot: &Snapshot, width: usize, height: usize) -> Vec<[f32; 4]> {
    if (width, height) == (snapshot.width, snapshot.height) {
        return snapshot.pixels.clone();
    }
    let mut sums = vec![[0.0_f32; 5]; width * height];
    for (k, pixel) in snapshot.pixels.iter().enumerate() {
        let x = (k % snapshot.width) * width / snapshot.width.max(1);
        let y = (k / snapshot.width) * height / snapshot.height.max(1);
        if let Some(sum) = sums.get_mut(y * width + x) {
            (0..4).for_each(|c| sum[c] += pixel[c]);
            sum[4] += 1.0;
        }
    }
    sums.into_iter().map(|[r, g, b, a, n]| [r, g, b, a].map(|x| x / n.max(1.0))).collect()
}

/// What was compared: the final's request and samples, the preview's samples, how both are shown.
type Key = (u64, u32, u32, Display);

/// The comparison that is shown and the one being made.
#[derive(Default)]
pub struct LiveDifference {
    job: Option<Receiver<Found>>,
    compared: Option<(Key, Instant)>,
    texture: Option<TextureHandle>,
    text: String,
}

impl LiveDifference {
    /// Takes what was found and compares again if there is something new. Once per frame while the view is shown.
    pub fn update(&mut self, ctx: &Context, preview: &mut LivePreview, snapshot: Option<&Arc<Snapshot>>, display: Display) {
        match self.job.as_ref().map(Receiver::try_recv) {
            Some(Ok(found)) => {
                self.job = None;
                self.text = format!("FLIP mean {:.3}, 99 % below {:.3}", found.mean, found.p99);
                match &mut self.texture {
                    Some(texture) => texture.set(found.image, TextureOptions::LINEAR),
                    None => self.texture = Some(ctx.load_texture("difference", found.image, TextureOptions::LINEAR)),
                }
            }
            Some(Err(TryRecvError::Disconnected)) => self.job = None,
            Some(Err(TryRecvError::Empty)) => return,
            None => {}
        }
        let Some(snapshot) = snapshot.filter(|snapshot| snapshot.scale == 1) else { return };
        let key = (snapshot.revision, snapshot.spp, preview.ray_samples(), display);
        if self.compared.as_ref().is_some_and(|(compared, _)| *compared == key) {
            return;
        }
        if let Some((_, since)) = &self.compared
            && since.elapsed() < PAUSE
        {
            ctx.request_repaint_after(PAUSE);
            return;
        }
        let Ok((width, height, pixels)) = preview.read_linear() else { return };
        let (width, height) = (width as usize, height as usize);
        self.compared = Some((key, Instant::now()));
        let (sender, receiver) = channel();
        let (snapshot, repaint) = (snapshot.clone(), ctx.clone());
        std::thread::spawn(move || {
            let shown = |pixels: &[[f32; 4]]| -> Vec<[f32; 3]> {
                pixels.iter().map(|[r, g, b, _]| display.apply([*r, *g, *b])).collect()
            };
            // On a slow adapter the preview has fewer pixels than the final view.
            let truth = reduced(&snapshot, width, height);
            let values = flip(&shown(&pixels), &shown(&truth), width);
            let mean = values.iter().map(|e| f64::from(*e)).sum::<f64>() / values.len().max(1) as f64;
            let colors = values.iter().map(|value| {
                let [r, g, b] = heatmap::color(*value);
                Color32::from_rgb(r, g, b)
            });
            let image = ColorImage::new([width, height], colors.collect());
            // Nobody waits any more if another view was chosen.
            _ = sender.send(Found { image, mean, p99: quantile(&values, 0.99) });
            repaint.request_repaint();
        });
        self.job = Some(receiver);
    }

    /// The picture of the newest comparison.
    pub fn texture(&self) -> Option<&TextureHandle> {
        self.texture.as_ref()
    }

    /// Its numbers, in words.
    pub fn text(&self) -> &str {
        &self.text
    }
}

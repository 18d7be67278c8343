//! Cross-filtered non-local means with guides, after Rousselle, Knaus, Zwicker, "Adaptive Rendering with Non-Local Means Filtering", 2012, and
//! Rousselle, Manzi, Zwicker, "Robust Denoising using Feature and Color Information", 2013.
//!
//! A pixel becomes the mean of the pixels around it, weighted by how alike their surroundings are. Likeness is judged in one replicate and the
//! mean is taken in another, so that a pixel does not choose neighbours for their noise. Colour distances are measured in units of
//! the noise: pixels that differ by no more than it are alike. Guides keep what they tell apart.

use super::{Guides, Input};
use crate::lanes::{Kernel, Lanes, dispatch};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

/// Pixels to each side among which likeness is looked for.
const WINDOW: usize = 8;
/// Pixels to each side that are compared.
const PATCH: usize = 2;
/// Pixels to each side over which the noise is averaged: two replicates alone tell it with an error as large as itself.
const SMOOTH: usize = 2;
/// Rows that a thread takes at a time.
const ROWS: usize = 16;
/// Standard deviations of the noise that count as one unit of colour distance.
const TOLERANCE: f32 = 0.6;
/// One unit of distance of the squared guides.
const ALBEDO: f32 = 0.01;
const NORMAL: f32 = 0.01;
const NEARNESS: f32 = 0.0004;

/// One plane with a margin, so that neighbours of every pixel can be read.
#[derive(Clone)]
struct Plane {
    stride: usize,
    values: Vec<f32>,
}

/// Room around planes.
const MARGIN: usize = WINDOW + PATCH;

impl Plane {
    /// The plane of a function of column and row, mirrored beyond the picture.
    fn new(width: usize, height: usize, f: impl Fn(usize, usize) -> f32) -> Self {
        let stride = width + 2 * MARGIN;
        let mut values = Vec::with_capacity(stride * (height + 2 * MARGIN));
        for y in 0..height + 2 * MARGIN {
            let row = mirrored(y, height);
            values.extend((0..stride).map(|x| f(mirrored(x, width), row)));
        }
        Self { stride, values }
    }

    /// `length` values from column `x` of row `y`, which may lie in the margin.
    #[inline(always)]
    fn row(&self, x: isize, y: isize, length: usize) -> &[f32] {
        let margin = MARGIN as isize;
        let first = ((y + margin) as usize) * self.stride + (x + margin) as usize;
        &self.values[first..first + length]
    }
}

/// The pixel whose value stands at a place counted from the edge of the margin.
fn mirrored(place: usize, size: usize) -> usize {
    let period = 2 * size as isize;
    let i = (place as isize - MARGIN as isize).rem_euclid(period);
    i.min(period - 1 - i) as usize
}

/// What is known of one replicate.
struct Buffer {
    color: [Plane; 3],
    /// Variance of the colour, summed over channels.
    variance: Plane,
}

/// Everything that weights are made of.
struct Sources {
    width: usize,
    height: usize,
    buffers: Vec<Buffer>,
    albedo: [Plane; 3],
    normal: [Plane; 3],
    nearness: Plane,
}

impl Sources {
    fn new(input: &Input, guides: &Guides) -> Self {
        let (width, height) = (input.width, input.height);
        let variances = [0, 1].map(|half| variance(input, half));
        let buffers = (0..4).map(|r| Buffer {
            color: std::array::from_fn(|k| Plane::new(width, height, |x, y| input.replicates[y * width + x][r][k])),
            variance: Plane::new(width, height, |x, y| variances[r / 2][y * width + x]),
        });
        // A guide that is missing tells nothing apart.
        let guide = |values: &[[f32; 3]], k: usize| {
            Plane::new(width, height, |x, y| values.get(y * width + x).map_or(0.0, |v| if v[k].is_finite() { v[k] } else { 0.0 }))
        };
        let nearness =
            |x: usize, y: usize| guides.nearness.get(y * width + x).copied().filter(|n: &f32| n.is_finite()).unwrap_or(0.0);
        Self {
            width,
            height,
            buffers: buffers.collect(),
            albedo: std::array::from_fn(|k| guide(&guides.albedo, k)),
            normal: std::array::from_fn(|k| guide(&guides.normal, k)),
            nearness: Plane::new(width, height, nearness),
        }
    }
}

/// Variance of a replicate of a half, summed over channels: half the squared difference of its two, averaged over the surroundings.
fn variance(input: &Input, half: usize) -> Vec<f32> {
    let (width, height) = (input.width, input.height);
    let difference = |r: &[[f32; 3]; 4]| -> f32 { (0..3).map(|k| 0.5 * (r[2 * half][k] - r[2 * half + 1][k]).powi(2)).sum() };
    let own: Vec<f32> = input.replicates.iter().map(difference).collect();
    let across = blurred(&own, width, height, 1, width);
    blurred(&across, width, height, width, height)
}

/// Mean over `2 SMOOTH + 1` pixels along one axis, fewer at the ends.
fn blurred(values: &[f32], width: usize, height: usize, step: usize, size: usize) -> Vec<f32> {
    (0..width * height)
        .map(|i| {
            let place = i / step % size;
            let (low, high) = (place.saturating_sub(SMOOTH), (place + SMOOTH).min(size - 1));
            let sum: f32 = (low..=high).map(|p| values[i + p * step - place * step]).sum();
            sum / (high - low + 1) as f32
        })
        .collect()
}

/// Both halves, denoised each from its own replicates. `None`: cancelled.
pub(super) fn halves(
    input: &Input,
    guides: &Guides,
    threads: usize,
    cancel: &(dyn Fn() -> bool + Sync),
) -> Option<[Vec<[f32; 3]>; 2]> {
    let (width, height) = (input.width, input.height);
    let mut out = [vec![[0.0; 3]; width * height], vec![[0.0; 3]; width * height]];
    if width * height == 0 {
        return Some(out);
    }
    let sources = Sources::new(input, guides);
    let is_cancelled = AtomicBool::new(false);
    let [first, second] = &mut out;
    let bands = Mutex::new(first.chunks_mut(ROWS * width).zip(second.chunks_mut(ROWS * width)).enumerate());
    let work = || {
        let mut scratch = Scratch::default();
        loop {
            // Taking the next band cannot leave the list half changed.
            let next = bands.lock().unwrap_or_else(std::sync::PoisonError::into_inner).next();
            let Some((number, (first, second))) = next else { break };
            if is_cancelled.load(Ordering::Relaxed) || cancel() {
                is_cancelled.store(true, Ordering::Relaxed);
                break;
            }
            dispatch(Band { sources: &sources, first_row: number * ROWS, out: [first, second], scratch: &mut scratch });
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..threads.min(height.div_ceil(ROWS)) {
            scope.spawn(work);
        }
        work();
    });
    (!is_cancelled.load(Ordering::Relaxed)).then_some(out)
}

/// Buffers of a thread.
#[derive(Default)]
struct Scratch {
    /// Distance of the guides.
    guides: Vec<f32>,
    /// Distance of colours, pixel by pixel.
    distance: Vec<f32>,
    /// The same, summed along rows.
    summed: Vec<f32>,
    /// Weighted colours and the sum of weights, per replicate.
    sums: [[Vec<f32>; 4]; 4],
}

/// Some rows of both halves.
struct Band<'a> {
    sources: &'a Sources,
    first_row: usize,
    out: [&'a mut [[f32; 3]]; 2],
    scratch: &'a mut Scratch,
}

impl Kernel for Band<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { sources, first_row, mut out, scratch } = self;
        let width = sources.width;
        let rows = out[0].len() / width;
        for plane in scratch.sums.iter_mut().flatten() {
            plane.clear();
            plane.resize(rows * width, 0.0);
        }
        let reach = WINDOW as isize;
        for (dy, dx) in (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| (dy, dx))) {
            // Pixels whose neighbour lies in the picture.
            let x0 = (-dx).max(0) as usize;
            let x1 = (width as isize - dx.max(0)).max(0) as usize;
            let inside = |y: usize| (0..sources.height as isize).contains(&((first_row + y) as isize + dy));
            let Some(y0) = (0..rows).find(|y| inside(*y)) else { continue };
            let y1 = (y0..rows).take_while(|y| inside(*y)).last().map_or(y0, |y| y + 1);
            if x0 >= x1 {
                continue;
            }
            let area = Area { x0, length: x1 - x0, y0: first_row + y0, rows: y1 - y0, dx, dy };
            area.guide_distance(sources, &mut scratch.guides);
            for replicate in 0..4 {
                area.color_distance(&sources.buffers[replicate ^ 1], &mut scratch.distance, &mut scratch.summed);
                let sums = &mut scratch.sums[replicate];
                for y in 0..area.rows {
                    let first = (y0 + y) * width + x0;
                    let sums = sums.each_mut().map(|plane| &mut plane[first..first + area.length]);
                    area.accumulate(y, &scratch.summed, &scratch.guides, &sources.buffers[replicate], sums);
                }
            }
        }
        for (half, out) in out.iter_mut().enumerate() {
            for (i, pixel) in out.iter_mut().enumerate() {
                for (k, value) in pixel.iter_mut().enumerate() {
                    // The weight of a pixel for itself is 1, so no sum of weights is less.
                    let of = |r: usize| scratch.sums[r][k][i] / scratch.sums[r][3][i];
                    *value = 0.5 * (of(2 * half) + of(2 * half + 1));
                }
            }
        }
    }
}

/// Pixels of a band that have a neighbour at an offset.
struct Area {
    x0: usize,
    length: usize,
    y0: usize,
    rows: usize,
    dx: isize,
    dy: isize,
}

impl Area {
    /// The rows of a plane at the pixels and at their neighbours.
    #[inline(always)]
    fn pair<'a>(&self, plane: &'a Plane, y: isize, margin: usize) -> (&'a [f32], &'a [f32]) {
        let (x, y, length) = (self.x0 as isize - margin as isize, self.y0 as isize + y, self.length + 2 * margin);
        (plane.row(x, y, length), plane.row(x + self.dx, y + self.dy, length))
    }

    /// Squared distances of the guides, in units of what may differ.
    #[inline(always)]
    fn guide_distance(&self, sources: &Sources, out: &mut Vec<f32>) {
        out.resize(self.rows * self.length, 0.0);
        let n = self.length;
        for (y, out) in out.chunks_exact_mut(n).enumerate() {
            let of = |plane| self.pair(plane, y as isize, 0);
            let [(r0, r1), (g0, g1), (b0, b1)] = sources.albedo.each_ref().map(of);
            for i in 0..n {
                out[i] = (1.0 / ALBEDO) * (sqr(r0[i] - r1[i]) + sqr(g0[i] - g1[i]) + sqr(b0[i] - b1[i]));
            }
            let [(x0, x1), (y0, y1), (z0, z1)] = sources.normal.each_ref().map(of);
            for i in 0..n {
                out[i] = larger(out[i], (1.0 / NORMAL) * (sqr(x0[i] - x1[i]) + sqr(y0[i] - y1[i]) + sqr(z0[i] - z1[i])));
            }
            let (d0, d1) = of(&sources.nearness);
            for i in 0..n {
                out[i] = larger(out[i], (1.0 / NEARNESS) * sqr(d0[i] - d1[i]));
            }
        }
    }

    /// Colour distances in units of the noise, summed along the rows of patches.
    #[inline(always)]
    fn color_distance(&self, buffer: &Buffer, distance: &mut Vec<f32>, summed: &mut Vec<f32>) {
        let wide = self.length + 2 * PATCH;
        distance.resize(wide, 0.0);
        summed.resize((self.rows + 2 * PATCH) * self.length, 0.0);
        for (y, summed) in summed.chunks_exact_mut(self.length).enumerate() {
            let of = |plane| self.pair(plane, y as isize - PATCH as isize, PATCH);
            let [(r0, r1), (g0, g1), (b0, b1)] = buffer.color.each_ref().map(of);
            let (v0, v1) = of(&buffer.variance);
            let distance = &mut distance[..wide];
            let (r0, r1, g0, g1) = (&r0[..wide], &r1[..wide], &g0[..wide], &g1[..wide]);
            let (b0, b1, v0, v1) = (&b0[..wide], &b1[..wide], &v0[..wide], &v1[..wide]);
            for i in 0..wide {
                let difference = sqr(r0[i] - r1[i]) + sqr(g0[i] - g1[i]) + sqr(b0[i] - b1[i]);
                // The smaller variance: what is clean is not mixed with what is noisy and different.
                let expected = v0[i] + smaller(v0[i], v1[i]);
                distance[i] = (difference - expected) / (1e-10 + TOLERANCE * TOLERANCE * expected);
            }
            summed.copy_from_slice(&distance[..self.length]);
            for shift in 1..=2 * PATCH {
                for (sum, distance) in summed.iter_mut().zip(&distance[shift..]) {
                    *sum += *distance;
                }
            }
        }
    }

    /// Adds the neighbours of one row of pixels.
    #[inline(always)]
    fn accumulate(&self, y: usize, summed: &[f32], guides: &[f32], data: &Buffer, sums: [&mut [f32]; 4]) {
        let length = self.length;
        const SCALE: f32 = 1.0 / ((2 * PATCH + 1) * (2 * PATCH + 1)) as f32;
        let guides = &guides[y * length..(y + 1) * length];
        let [r, g, b] = data.color.each_ref().map(|plane| &self.pair(plane, y as isize, 0).1[..length]);
        let [sum_r, sum_g, sum_b, sum_w] = sums.map(|plane| &mut plane[..length]);
        let patch: [&[f32]; 2 * PATCH + 1] = std::array::from_fn(|j| &summed[(y + j) * length..(y + j + 1) * length]);
        for i in 0..length {
            let mut color = patch[0][i];
            for row in &patch[1..] {
                color += row[i];
            }
            let w = falloff(larger(color * SCALE, guides[i]));
            sum_r[i] += w * r[i];
            sum_g[i] += w * g[i];
            sum_b[i] += w * b[i];
            sum_w[i] += w;
        }
    }
}

#[inline(always)]
fn sqr(x: f32) -> f32 {
    x * x
}

/// One instruction, unlike `f32::max`, which minds which of two is not a number.
#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// Close to `exp(-x)`, but only products, and 0 from 8 on. 1 for negative distances: more alike than noise lets expect.
#[inline(always)]
fn falloff(x: f32) -> f32 {
    let y = larger(1.0 - larger(x, 0.0) * 0.125, 0.0);
    let y = y * y;
    let y = y * y;
    y * y
}

//! Writes `renderer/src/path/walk/jump.bin`: how steeply light leaves a sphere of a scattering medium that was emitted isotropically
//! at its centre. One inverse distribution of the exit cosine per albedo and optical radius.
//!
//! Small random walks with weights. Isotropic scattering makes the state one radius and one cosine, so a collision costs one logarithm
//! and one square root, and a million walks per entry a few seconds. Deterministic: the numbers are hashes of the walk's number.
//! Prints mean, quantiles and the share that leaves, to be compared with asymptotic transport theory.

use std::io::Write;
use std::path::Path;

/// Single-scattering albedos, as `path::walk::jump` expects them.
const ALBEDOS: [f64; 7] = [0.9, 0.95, 0.98, 0.99, 0.995, 0.999, 1.0];
/// Optical radii, and walks for each.
const RADII: [(f64, u64); 3] = [(8.0, 4_000_000), (16.0, 2_000_000), (32.0, 1_000_000)];
/// Entries of an inverse distribution; entry `i` holds the quantile at `(i / 255)^2`.
const ENTRIES: usize = 256;
/// Bins of the histogram from which the quantiles are read.
const BINS: usize = 8192;

/// SplitMix64 (Steele, Lea, Flood 2014).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^= x >> 31;
        ((x >> 11) as f64 + 0.5) * (1.0 / 9_007_199_254_740_992.0)
    }
}

/// Diffusion length in mean free paths: the root of `1 = (a/2) nu ln((nu + 1)/(nu - 1))`.
fn diffusion_length(a: f64) -> f64 {
    let (mut low, mut high) = (1.0 + 1e-15, 1e9);
    for _ in 0..200 {
        let nu = 0.5 * (low + high);
        if a * nu * (1.0 / nu).atanh() > 1.0 { low = nu } else { high = nu }
    }
    0.5 * (low + high)
}

/// One walk: exit cosine and weight.
fn walk(a: f64, radius: f64, nu: f64, guided_share: f64, numbers: &mut Numbers) -> (f64, f64) {
    let span = ((nu + 1.0) / (nu - 1.0)).ln();
    let (mut r, mut weight) = (0.0f64, 1.0f64);
    loop {
        // At the centre every direction is radial, and steering has no meaning.
        let g = if r > 0.0 { guided_share } else { 0.0 };
        let is_guided = g > 0.0 && numbers.next() < g;
        let mu = if is_guided { nu - (nu + 1.0) * (-numbers.next() * span).exp() } else { 2.0 * numbers.next() - 1.0 };
        let stretched = 1.0 - mu / nu;
        let t = -numbers.next().ln() / if is_guided { stretched } else { 1.0 };
        let next = (r * r + t * t + 2.0 * r * t * mu).max(0.0).sqrt();
        let leaves = next >= radius;
        if g > 0.0 {
            let across = r * r * (1.0 - mu * mu);
            let t = if leaves { (radius * radius - across).sqrt() - r * mu } else { t };
            let guided = 2.0 * g / ((nu - mu) * span) * (mu / nu * t).exp();
            weight /= (1.0 - g) + guided * if leaves { 1.0 } else { stretched };
        }
        if leaves {
            return ((1.0 - r * r * (1.0 - mu * mu) / (radius * radius)).max(0.0).sqrt(), weight);
        }
        weight *= a;
        r = next;
    }
}

/// Quantiles at `(i / 255)^2`, mean cosine, share that leaves.
fn row(a: f64, radius: f64, walks: u64) -> (Vec<f64>, f64, f64) {
    let nu = if a < 1.0 { diffusion_length(a) } else { 1e9 };
    let guided_share = if nu < 0.5 * radius { 0.9 } else { 0.0 };
    let mut bins = vec![0.0f64; BINS];
    let mut mean = 0.0;
    for i in 0..walks {
        let mut numbers = Numbers(i.wrapping_mul(0xd134_2543_de82_ef95) ^ radius.to_bits() ^ a.to_bits().rotate_left(17));
        let (mu, weight) = walk(a, radius, nu, guided_share, &mut numbers);
        bins[((mu * BINS as f64) as usize).min(BINS - 1)] += weight;
        mean += mu * weight;
    }
    let total: f64 = bins.iter().sum();
    let (mut bin, mut below) = (0, 0.0);
    let quantile = |i: usize| {
        let target = (i as f64 / (ENTRIES - 1) as f64).powi(2) * total;
        while bin + 1 < BINS && below + bins[bin] < target {
            below += bins[bin];
            bin += 1;
        }
        (bin as f64 + ((target - below) / bins[bin].max(f64::MIN_POSITIVE)).clamp(0.0, 1.0)) / BINS as f64
    };
    let mut quantiles: Vec<f64> = (0..ENTRIES).map(quantile).collect();
    (quantiles[0], quantiles[ENTRIES - 1]) = (0.0, 1.0);
    (quantiles, mean / total, total / walks as f64)
}

fn main() -> std::io::Result<()> {
    let of = |a: f64| RADII.map(|(radius, walks)| row(a, radius, walks));
    let (first, second) = ALBEDOS.split_at(ALBEDOS.len() - 2);
    // The last two take as long as the others together.
    let rows: Vec<_> = std::thread::scope(|scope| {
        let others = scope.spawn(|| first.iter().map(|a| of(*a)).collect::<Vec<_>>());
        let last: Vec<_> = second.iter().map(|a| of(*a)).collect();
        others.join().unwrap_or_default().into_iter().chain(last).collect()
    });
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/path/walk/jump.bin");
    let mut file = std::fs::File::create(path)?;
    for (a, rows) in ALBEDOS.iter().zip(&rows) {
        for ((radius, _), (quantiles, mean, share)) in RADII.iter().zip(rows) {
            let at = |u: f64| {
                let x = u.sqrt() * (ENTRIES - 1) as f64;
                quantiles[x as usize] + (quantiles[x as usize + 1] - quantiles[x as usize]) * x.fract()
            };
            eprintln!(
                "{a} {radius}: mean {mean:.4}, 10 % {:.4}, 50 % {:.4}, 90 % {:.4}, leaves {share:.5}",
                at(0.1),
                at(0.5),
                at(0.9)
            );
            for mu in quantiles {
                file.write_all(&((mu.clamp(0.0, 1.0) * 65535.0).round() as u16).to_le_bytes())?;
            }
        }
    }
    Ok(())
}

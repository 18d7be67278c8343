//! Writes `renderer/src/bsdf/sheen.bin` from the lobe itself, in double precision.
//!
//! Midpoint quadrature over the sampling square of the lobe: exact to about 1e-5, a fraction of what 16-bit entries hold.

use burnish_renderer::bsdf::sheen::{SHEEN_ROUGHNESS_MIN, sheen_eval, sheen_sample};
use burnish_renderer::bsdf::tables::{COSINES, ROUGHNESSES};
use burnish_renderer::vector::V3;
use std::io::Write;
use std::path::Path;

/// Grid of the quadrature: over the polar number and over half of the azimuth, which mirror symmetry doubles.
const POLAR: usize = 128;
const AZIMUTH: usize = 64;

fn direction(mu: f64) -> V3<f64> {
    V3::new((1.0 - mu * mu).max(0.0).sqrt(), 0.0, mu)
}

fn mean(f: impl Fn(f64, f64) -> f64) -> f64 {
    let mut sum = 0.0;
    for i in 0..POLAR {
        for j in 0..AZIMUTH {
            sum += f((i as f64 + 0.5) / POLAR as f64, 0.5 * (j as f64 + 0.5) / AZIMUTH as f64);
        }
    }
    sum / (POLAR * AZIMUTH) as f64
}

fn sheen(r: f64, mu: f64) -> f64 {
    let r = r.max(SHEEN_ROUGHNESS_MIN);
    let wo = direction(mu.max(1e-5));
    mean(|u0, u1| {
        let wi = sheen_sample(wo, r, u0, u1);
        if wi.z <= 0.0 {
            return 0.0;
        }
        let (value, pdf) = sheen_eval(wo, wi, r);
        value / pdf
    })
}

fn main() -> std::io::Result<()> {
    let unit = |i: usize, n: usize| i as f64 / (n - 1) as f64;
    let mut values = Vec::with_capacity(ROUGHNESSES * COSINES);
    for r in 0..ROUGHNESSES {
        values.extend((0..COSINES).map(|t| sheen(unit(r, ROUGHNESSES), unit(t, COSINES).powi(2))));
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/bsdf/sheen.bin");
    let mut file = std::fs::File::create(path)?;
    for value in values {
        file.write_all(&((value.clamp(0.0, 1.0) * 65535.0).round() as u16).to_le_bytes())?;
    }
    Ok(())
}

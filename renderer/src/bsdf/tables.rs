//! Directional albedos that have no closed form, tabulated once and shared by both renderers. Twin of `tables.wgsl`.
//!
//! The data file is made by `cargo run -p burnish-renderer --example albedo_tables` from the lobes of this folder in double precision;
//! a test compares it with an independent quadrature.

use crate::lanes::Lanes;
use std::sync::OnceLock;

/// Entries along the contrast `x = |eta - 1| / (eta + 1)`, from 0 to 1.
pub const CONTRASTS: usize = 32;
/// Entries along roughness, from 0 to 1.
pub const ROUGHNESSES: usize = 32;
/// Entries along `sqrt(mu)`, from 0 to 1: the detail lies at grazing angles.
pub const COSINES: usize = 32;

const ALBEDO_LEN: usize = 2 * CONTRASTS * ROUGHNESSES * COSINES;
const SHEEN_LEN: usize = ROUGHNESSES * COSINES;

static DATA: &[u8; 2 * (ALBEDO_LEN + SHEEN_LEN)] = include_bytes!("albedo.bin");

/// The tables, ready for lookup and for upload.
#[derive(Debug)]
pub struct Tables {
    /// Single-scatter reflected albedo of a dielectric GGX interface: `[eta >= 1, eta < 1][contrast][roughness][sqrt(mu)]`.
    pub albedo: Vec<f32>,
    /// Cosine-weighted mean of `albedo`: `[eta >= 1, eta < 1][contrast][roughness]`.
    pub albedo_mean: Vec<f32>,
    /// Albedo of white sheen: `[roughness][sqrt(mu)]`.
    pub sheen: Vec<f32>,
}

/// The tables, unpacked at first use (well under a millisecond).
pub fn tables() -> &'static Tables {
    static TABLES: OnceLock<Tables> = OnceLock::new();
    TABLES.get_or_init(|| {
        let values: Vec<f32> = DATA.chunks_exact(2).map(|b| f32::from(u16::from_le_bytes([b[0], b[1]])) / 65535.0).collect();
        let (albedo, sheen) = values.split_at(ALBEDO_LEN);
        let albedo_mean = albedo.chunks_exact(COSINES).map(cosine_mean).collect();
        Tables { albedo: albedo.to_vec(), albedo_mean, sheen: sheen.to_vec() }
    })
}

/// `2 * integral of E(mu) mu dmu` of a row that is linear in `t = sqrt(mu)`: exactly the mean of what lookups return,
/// so that the diffuse lobe conserves energy to rounding.
fn cosine_mean(row: &[f32]) -> f32 {
    let h = 1.0 / (COSINES - 1) as f64;
    let mut sum = 0.0;
    for (i, pair) in row.windows(2).enumerate() {
        let (a, b) = (f64::from(pair[0]), f64::from(pair[1]));
        let (t0, t1) = (i as f64 * h, (i + 1) as f64 * h);
        // E = p + q t on the segment, weight 4 t^3 dt.
        let q = (b - a) / h;
        let p = a - q * t0;
        sum += p * (t1.powi(4) - t0.powi(4)) + q * 0.8 * (t1.powi(5) - t0.powi(5));
    }
    sum as f32
}

/// Position of `u` in `[0, 1]` on an axis of `n` entries: index of the cell and place within it.
#[inline(always)]
fn cell<L: Lanes>(u: L, n: usize) -> (L, L) {
    let s = u.sat() * L::of((n - 1) as f64);
    let i = s.floor().min(L::of((n - 2) as f64));
    (i, s - i)
}

/// Offset of the half of the tables for this ratio, and the contrast axis.
#[inline(always)]
fn contrast<L: Lanes>(eta: L) -> (L, L) {
    let x = (eta - L::one()).abs() / (eta + L::one());
    (L::select(eta.lt(L::one()), L::of(CONTRASTS as f64), L::zero()), x)
}

/// Reflected share of uniform light for a dielectric interface of ratio `eta` seen at cosine `mu`; both in range, any lane.
#[inline(always)]
pub fn dielectric_albedo<L: Lanes>(eta: L, roughness: L, mu: L) -> L {
    let table = &tables().albedo;
    let (half, x) = contrast(eta);
    let (ix, fx) = cell(x, CONTRASTS);
    let (ir, fr) = cell(roughness, ROUGHNESSES);
    let (it, ft) = cell(mu.max(L::zero()).sqrt(), COSINES);
    let nt = L::of(COSINES as f64);
    let nr = L::of(ROUGHNESSES as f64);
    let row = |dx: f64, dr: f64| {
        let i = ((half + ix + L::of(dx)) * nr + ir + L::of(dr)) * nt + it;
        L::gather(table, i).lerp(L::gather(table, i + L::one()), ft)
    };
    let low = row(0.0, 0.0).lerp(row(0.0, 1.0), fr);
    let high = row(1.0, 0.0).lerp(row(1.0, 1.0), fr);
    low.lerp(high, fx)
}

/// Cosine-weighted mean of [`dielectric_albedo`].
#[inline(always)]
pub fn dielectric_albedo_mean<L: Lanes>(eta: L, roughness: L) -> L {
    let table = &tables().albedo_mean;
    let (half, x) = contrast(eta);
    let (ix, fx) = cell(x, CONTRASTS);
    let (ir, fr) = cell(roughness, ROUGHNESSES);
    let nr = L::of(ROUGHNESSES as f64);
    let row = |dx: f64| {
        let i = (half + ix + L::of(dx)) * nr + ir;
        L::gather(table, i).lerp(L::gather(table, i + L::one()), fr)
    };
    row(0.0).lerp(row(1.0), fx)
}

/// Albedo of white sheen of roughness `r` seen at cosine `mu`.
#[inline(always)]
pub fn sheen_albedo<L: Lanes>(r: L, mu: L) -> L {
    let table = &tables().sheen;
    let (ir, fr) = cell(r, ROUGHNESSES);
    let (it, ft) = cell(mu.max(L::zero()).sqrt(), COSINES);
    let row = |dr: f64| {
        let i = (ir + L::of(dr)) * L::of(COSINES as f64) + it;
        L::gather(table, i).lerp(L::gather(table, i + L::one()), ft)
    };
    row(0.0).lerp(row(1.0), fr)
}

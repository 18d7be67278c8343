//! The directional albedo of sheen, which has no closed form, tabulated once and shared by both renderers. Twin of `tables.wgsl`.
//!
//! The data file is made by `cargo run -p burnish-renderer --example sheen_table` from the lobe of this folder in double precision.

use crate::lanes::Lanes;
use std::sync::OnceLock;

/// Entries along roughness, from 0 to 1.
pub const ROUGHNESSES: usize = 32;
/// Entries along `sqrt(mu)`, from 0 to 1: the detail lies at grazing angles.
pub const COSINES: usize = 32;

static DATA: &[u8; 2 * ROUGHNESSES * COSINES] = include_bytes!("sheen.bin");

/// Albedo of white sheen: `[roughness][sqrt(mu)]`. Unpacked at first use.
pub fn sheen_table() -> &'static [f32] {
    static TABLE: OnceLock<Vec<f32>> = OnceLock::new();
    TABLE.get_or_init(|| DATA.chunks_exact(2).map(|b| f32::from(u16::from_le_bytes([b[0], b[1]])) / 65535.0).collect())
}

/// Position of `u` in `[0, 1]` on an axis of `n` entries: index of the cell and place within it.
#[inline(always)]
pub(super) fn cell<L: Lanes>(u: L, n: usize) -> (L, L) {
    let s = u.sat() * L::of((n - 1) as f64);
    let i = s.floor().min(L::of((n - 2) as f64));
    (i, s - i)
}

/// Albedo of white sheen of roughness `r` seen at cosine `mu`.
#[inline(always)]
pub fn sheen_albedo<L: Lanes>(r: L, mu: L) -> L {
    let table = sheen_table();
    let (ir, fr) = cell(r, ROUGHNESSES);
    let (it, ft) = cell(mu.max(L::zero()).sqrt(), COSINES);
    let row = |dr: f64| {
        let i = (ir + L::of(dr)) * L::of(COSINES as f64) + it;
        L::gather(table, i).lerp(L::gather(table, i + L::one()), ft)
    };
    row(0.0).lerp(row(1.0), fr)
}

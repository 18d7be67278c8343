//! One step from a collision to the surface of a sphere around it, in place of the hundreds of collisions between.
//!
//! The exit point is uniform by symmetry. The share that leaves is asymptotic transport theory with the extrapolated end point, the
//! idea that of Moon, Walter and Marschner 2007 and Lee and O'Sullivan 2007. The direction comes from a table that
//! `cargo run --release -p burnish-renderer --example jump_tables` makes with small walks.

use std::sync::OnceLock;

/// Optical radius of the smallest sphere that is jumped; larger ones double it. Below, walking is as quick and has no bias.
pub(super) const RADIUS_MIN: f64 = 8.0;
/// Largest number of doublings: optical radii beyond any that the floor of the mean free path allows.
const DOUBLINGS_MAX: i32 = 24;

/// `1 - albedo` of the table's rows. Lower albedos use the first: they leave such spheres with a weight of at most a few percent.
const ABSORBED: [f64; 7] = [0.1, 0.05, 0.02, 0.01, 0.005, 0.001, 0.0];
/// Optical radii of the rows.
const RADII: [f64; 3] = [8.0, 16.0, 32.0];
/// Entries of a row; entry `i` is the cosine at the quantile `(i / 255)^2`, which makes rows nearly straight at 0.
const ENTRIES: usize = 256;
/// Mean exit cosine of a lossless medium at infinite radius: the extrapolated end point in mean free paths.
const END_POINT: f64 = 0.7104;

static DATA: &[u8; 2 * ENTRIES * RADII.len() * ABSORBED.len()] = include_bytes!("jump.bin");

type Row = [f32; ENTRIES];

fn rows() -> &'static [Row] {
    static ROWS: OnceLock<Vec<Row>> = OnceLock::new();
    ROWS.get_or_init(|| {
        let row =
            |bytes: &[u8]| std::array::from_fn(|i| f32::from(u16::from_le_bytes([bytes[2 * i], bytes[2 * i + 1]])) / 65535.0);
        DATA.chunks_exact(2 * ENTRIES).map(row).collect()
    })
}

/// Number of doublings of [`RADIUS_MIN`] that fit into an optical distance; none if not even that does.
pub(super) fn doublings(tau: f64) -> Option<i32> {
    // Not a number fits nothing.
    if tau >= RADIUS_MIN { Some(((tau / RADIUS_MIN).log2().floor() as i32).min(DOUBLINGS_MAX)) } else { None }
}

/// Share of the light of a collision at the centre that leaves a sphere of optical radius `tau`, in `[0, 1]`. `nu` is the diffusion
/// length in mean free paths, infinite where nothing is absorbed. Within 0.3 % for albedos from 0.9.
pub(super) fn weight(albedo: f64, nu: f64, tau: f64) -> f64 {
    if albedo <= 0.0 {
        return 0.0;
    }
    let x = (tau + END_POINT / albedo) / nu;
    if x < 1e-4 {
        1.0
    } else if x > 30.0 {
        2.0 * x * (-x).exp()
    } else {
        x / x.sinh()
    }
}

/// Exit cosines of one channel: a mean of four rows of the table, taken between equal quantiles.
#[derive(Clone, Copy)]
pub(super) struct Exit {
    rows: [&'static Row; 4],
    shares: [f64; 4],
}

impl Exit {
    /// Rows are mixed in `sqrt(1 - a)` and in `1/tau`, in which the means are nearly straight.
    pub(super) fn new(absorbed: f64, tau: f64) -> Self {
        let x = absorbed.max(0.0).sqrt();
        let i = (0..ABSORBED.len() - 2).rev().find(|i| x <= ABSORBED[*i].sqrt()).unwrap_or(0);
        let (low, high) = (ABSORBED[i].sqrt(), ABSORBED[i + 1].sqrt());
        let fa = ((low - x) / (low - high)).clamp(0.0, 1.0);
        let j = usize::from(tau > RADII[1]);
        let ft = ((1.0 / RADII[j] - 1.0 / tau) / (1.0 / RADII[j] - 1.0 / RADII[j + 1])).clamp(0.0, 1.0);
        let rows = rows();
        let at = |a: usize, t: usize| &rows[a * RADII.len() + t];
        Self {
            rows: [at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)],
            shares: [(1.0 - fa) * (1.0 - ft), fa * (1.0 - ft), (1.0 - fa) * ft, fa * ft],
        }
    }

    fn entry(&self, i: usize) -> f64 {
        self.rows.iter().zip(self.shares).map(|(row, share)| f64::from(row[i]) * share).sum()
    }

    /// A cosine against the outward normal of the sphere, from a number in `[0, 1)`.
    pub(super) fn sample(&self, u: f64) -> f64 {
        let s = u.max(0.0).sqrt() * (ENTRIES - 1) as f64;
        let i = (s as usize).min(ENTRIES - 2);
        let (low, high) = (self.entry(i), self.entry(i + 1));
        (low + (high - low) * (s - i as f64)).clamp(0.0, 1.0)
    }

    /// Density of [`Exit::sample`] over cosines.
    pub(super) fn density(&self, mu: f64) -> f64 {
        let (mut i, mut end) = (0, ENTRIES - 1);
        while end - i > 1 {
            let middle = usize::midpoint(i, end);
            if self.entry(middle) <= mu { i = middle } else { end = middle }
        }
        let (low, high) = (self.entry(i), self.entry(i + 1));
        let width = (high - low).max(1e-9);
        let s = (i as f64 + ((mu - low) / width).clamp(0.0, 1.0)) / (ENTRIES - 1) as f64;
        2.0 * s / ((ENTRIES - 1) as f64 * width)
    }
}

#[cfg(test)]
mod tests {
    use super::super::guide::diffusion_length;
    use super::*;

    #[test]
    fn shares_are_those_of_brute_force() {
        for (a, tau, share, error) in [
            (0.9, 8.0, 0.09178, 0.00029),
            (0.95, 8.0, 0.24053, 0.00043),
            (0.95, 16.0, 0.02212, 0.00011),
            (0.99, 8.0, 0.70343, 0.00034),
            (0.99, 16.0, 0.32394, 0.00042),
            (0.99, 32.0, 0.03984, 0.00014),
            (0.999, 8.0, 0.96304, 0.00005),
            (0.999, 32.0, 0.61473, 0.00037),
        ] {
            let w = weight(a, diffusion_length(1.0 - a), tau);
            assert!((w - share).abs() < 3.0 * error + 0.001 * share, "{a} {tau}: {w}");
        }
        assert_eq!(weight(1.0, f64::INFINITY, 8.0), 1.0);
        assert_eq!(weight(0.0, 1.01, 8.0), 0.0);
        let nu = diffusion_length(0.1);
        assert!((weight(0.9, nu, 56.31) / weight(0.9, nu, 56.30) - 1.0).abs() < 0.02);
    }

    #[test]
    fn cosines_have_the_known_quantiles() {
        // Mean, then the quantiles at 10, 50 and 90 percent, from 1e5 walks.
        for (absorbed, tau, known) in [
            (0.0, 8.0, [0.7363, 0.4245, 0.7859, 0.9662]),
            (0.0, 16.0, [0.7225, 0.4040, 0.7702, 0.9616]),
            (0.0, 32.0, [0.7158, 0.3947, 0.7625, 0.9602]),
            (0.05, 8.0, [0.7487, 0.4370, 0.8020, 0.9712]),
        ] {
            let exit = Exit::new(absorbed, tau);
            let mean = (0..4096).map(|i| exit.sample((f64::from(i) + 0.5) / 4096.0)).sum::<f64>() / 4096.0;
            for (found, known) in [mean, exit.sample(0.1), exit.sample(0.5), exit.sample(0.9)].into_iter().zip(known) {
                assert!((found - known).abs() < 0.003, "{absorbed} {tau}: {found} {known}");
            }
        }
    }

    #[test]
    fn densities_belong_to_the_cosines() {
        for (absorbed, tau) in [(0.0, 8.0), (0.03, 11.0), (0.3, 20.0), (0.0007, 300.0)] {
            let exit = Exit::new(absorbed, tau);
            let mut sum = 0.0;
            for i in 0..20_000 {
                sum += exit.density((f64::from(i) + 0.5) / 20_000.0) / 20_000.0;
            }
            assert!((sum - 1.0).abs() < 2e-3, "{absorbed} {tau}: {sum}");
            for i in 1..200 {
                let (u, h) = (f64::from(i) / 200.0, 1e-7);
                let slope = (exit.sample(u + h) - exit.sample(u - h)) / (2.0 * h);
                let product = slope * exit.density(exit.sample(u));
                // A kink of the row may lie between.
                assert!((product - 1.0).abs() < 0.2, "{absorbed} {tau} {u}: {product}");
            }
        }
        assert_eq!(doublings(7.99), None);
        assert_eq!(doublings(8.0), Some(0));
        assert_eq!(doublings(100.0), Some(3));
        assert_eq!(doublings(f64::NAN), None);
    }
}

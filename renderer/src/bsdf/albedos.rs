//! Directional albedos of the material at hand: what its rough interfaces lose to single scattering, and what its dielectric reflects.
//!
//! Neither has a closed form, and a table for all materials would need six axes (two alphas, two indices of refraction, two
//! angles) to hold the half per cent that a furnace shows. So a material brings its own: two angles, and an axis
//! more for every number that an image varies. Uniform isotropic materials read two entries per direction. Model reference 3.1, 3.4,
//! 5.3, 8.2. Twin of `albedos.wgsl`, which reads [`Albedos::words`].

use super::dispersion::WAVELENGTH_RANGE;
use super::fill::{Interface, Wanted, fill};
use super::interpret::{Optics, interpret};
use super::tables::cell;
use crate::lanes::Lanes;
use crate::vector::V3;
use burnish_material::{Inputs, Lobe, LobeSet, Property};
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

/// Numbers of a material that a table may run over: roughness, anisotropy, root of the specular level, coat, wavelength; for the coat's
/// own table its roughness and the root of its level.
pub const AXES: usize = 5;
/// Entries along `sqrt(mu)` for a material without a varying number, and otherwise: the detail lies at grazing angles.
const COSINES: [usize; 2] = [96, 40];
/// The same for stretched materials, whose tables have one axis more.
const COSINES_STRETCHED: [usize; 2] = [64, 32];
/// Entries along the azimuth of a stretched material, over a quarter turn.
const AZIMUTHS: [usize; 2] = [13, 7];
/// Entries along each varying number, by how many vary.
const STEPS: [usize; AXES + 1] = [1, 32, 14, 8, 5, 4];

/// What is tabulated over the directions. Shares that are missing keep more digits than shares that are there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// What a white conductor loses: `1 - E`.
    MetalMiss,
    /// What a dielectric does not reflect: `1 - E`.
    DielectricMiss,
    /// What rough glass keeps, reflected and refracted, seen from outside: `E`.
    GlassKept,
    /// The same seen from inside.
    GlassKeptInside,
}

/// Number of quantities.
pub const QUANTITIES: usize = 4;

/// Tables of one interface.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Entries along each number; 1 where it does not vary.
    pub counts: [usize; AXES],
    /// Entries along the azimuth; 1 if isotropic.
    pub azimuths: usize,
    /// Entries along `sqrt(mu)`.
    pub cosines: usize,
    /// Where each quantity begins in `values`; the length of `values` if it is not held.
    pub begins: [usize; QUANTITIES],
    /// `[quantity][numbers...][azimuth][sqrt(mu)]`.
    pub values: Vec<f32>,
    /// Cosine-weighted means over all directions: `[quantity][numbers...]`, in the order of `begins`.
    pub means: Vec<f32>,
}

/// A place on the varying numbers of a grid.
#[derive(Clone, Copy, Debug)]
pub struct Place<L> {
    index: [L; AXES],
    fraction: [L; AXES],
}

/// A direction on the angular axes of a grid.
#[derive(Clone, Copy, Debug)]
pub struct Slant<L> {
    azimuth: L,
    azimuth_fraction: L,
    cosine: L,
    cosine_fraction: L,
}

/// All tables of one material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Albedos {
    /// Metal, dielectric and glass interfaces of the base.
    pub base: Grid,
    /// The coat: [`Quantity::DielectricMiss`].
    pub coat: Grid,
    key: Vec<u64>,
}

impl Default for Grid {
    /// A table that holds nothing.
    fn default() -> Self {
        Self { counts: [1; AXES], azimuths: 1, cosines: 2, begins: [0; QUANTITIES], values: Vec::new(), means: Vec::new() }
    }
}

impl Albedos {
    /// Tables for a material with these values. `varies`: an image stands in for the value. Of `made` the first that fits is returned.
    pub fn new<'a>(
        inputs: &Inputs<f64>,
        lobes: LobeSet,
        varies: impl Fn(Property) -> bool,
        made: impl IntoIterator<Item = &'a Arc<Self>>,
    ) -> Arc<Self> {
        let has_coat = lobes.has(Lobe::coat);
        let [base_varies, coat_varies] = varying(lobes, varies);
        let key = key(inputs, lobes, &base_varies, &coat_varies);
        if let Some(fitting) = made.into_iter().find(|made| made.key == key) {
            return fitting.clone();
        }
        let transmits = lobes.has(Lobe::transmission);
        let is_compensated = lobes.has(Lobe::multiple_scattering);
        let wanted = Wanted {
            metal: lobes.has(Lobe::metal) && is_compensated,
            dielectric: lobes.has(Lobe::diffuse) || lobes.has(Lobe::specular) || transmits,
            glass: transmits && is_compensated,
        };
        let is_stretched = lobes.has(Lobe::anisotropy);
        let base = Grid::new(base_varies, is_stretched, wanted, |at: [Option<f64>; AXES]| {
            let mut inputs = *inputs;
            let [r, a, level, c, wavelength] = at;
            inputs.roughness = r.unwrap_or(inputs.roughness);
            inputs.anisotropy = a.unwrap_or(inputs.anisotropy);
            inputs.specular_level = level.map_or(inputs.specular_level, |x| x * x);
            inputs.coat = c.unwrap_or(inputs.coat);
            let mut o: Optics<f64> = interpret(&inputs, lobes, 1.0);
            if let Some(x) = wavelength {
                let [first, last] = WAVELENGTH_RANGE;
                o = o.at_wavelength(first + x * (last - first));
            }
            Interface {
                alpha: [o.alpha_x, o.alpha_y],
                is_smooth: o.is_smooth,
                eta_reflection: o.eta_specular,
                eta: o.eta,
                is_matched: o.is_matched,
            }
        });
        let coat = if has_coat {
            let wanted = Wanted { metal: false, dielectric: true, glass: false };
            Grid::new(coat_varies, false, wanted, |at| {
                let mut inputs = *inputs;
                inputs.coat_roughness = at[0].unwrap_or(inputs.coat_roughness);
                inputs.coat_specular_level = at[2].map_or(inputs.coat_specular_level, |x| x * x);
                let o: Optics<f64> = interpret(&inputs, lobes, 1.0);
                let alpha = [o.coat_alpha; 2];
                Interface { alpha, is_smooth: o.coat_is_smooth, eta_reflection: o.coat_eta, eta: o.coat_eta, is_matched: false }
            })
        } else {
            Grid::default()
        };
        Arc::new(Self { base, coat, key })
    }

    /// The first of `made` that fits a material with these values: [`Self::new`] without its work.
    pub fn fitting<'a>(
        inputs: &Inputs<f64>,
        lobes: LobeSet,
        varies: impl Fn(Property) -> bool,
        made: impl IntoIterator<Item = &'a Arc<Self>>,
    ) -> Option<Arc<Self>> {
        let [base_varies, coat_varies] = varying(lobes, varies);
        let key = key(inputs, lobes, &base_varies, &coat_varies);
        made.into_iter().find(|made| made.key == key).cloned()
    }

    /// Tables of a material without images.
    pub fn uniform(inputs: &Inputs<f64>, lobes: LobeSet) -> Arc<Self> {
        Self::new(inputs, lobes, |_| false, [])
    }

    /// Both grids as one array for the twin: a head of [`HEAD`] numbers each, values, means. Begins are counted from the start.
    pub fn words(&self) -> Vec<f32> {
        let mut words = vec![0.0; 2 * HEAD];
        for (i, grid) in [&self.base, &self.coat].into_iter().enumerate() {
            let values = words.len();
            words.extend(&grid.values);
            let means = words.len();
            words.extend(&grid.means);
            let mut head = [0.0; HEAD];
            for (slot, count) in head.iter_mut().zip(grid.counts) {
                *slot = count as f32;
            }
            head[AXES] = grid.azimuths as f32;
            head[AXES + 1] = grid.cosines as f32;
            head[AXES + 2] = means as f32;
            for (slot, begin) in head[AXES + 3..].iter_mut().zip(grid.begins) {
                *slot = (values + begin) as f32;
            }
            words[i * HEAD..(i + 1) * HEAD].copy_from_slice(&head);
        }
        words
    }
}

/// Numbers before the values of a grid in [`Albedos::words`]: counts, azimuths, cosines, begin of the means, begins of the quantities.
pub const HEAD: usize = AXES + 3 + QUANTITIES;

/// Numbers that the tables of base and coat run over.
fn varying(lobes: LobeSet, varies: impl Fn(Property) -> bool) -> [[bool; AXES]; 2] {
    use Property as P;
    let base = [
        varies(P::roughness),
        varies(P::anisotropy) && lobes.has(Lobe::anisotropy),
        varies(P::specular_level),
        varies(P::coat) && lobes.has(Lobe::coat),
        lobes.has(Lobe::dispersion),
    ];
    [base, [varies(P::coat_roughness), false, varies(P::coat_specular_level), false, false]]
}

/// All that the tables depend on.
fn key(i: &Inputs<f64>, lobes: LobeSet, base_varies: &[bool; AXES], coat_varies: &[bool; AXES]) -> Vec<u64> {
    let relevant = [
        Lobe::metal,
        Lobe::specular,
        Lobe::diffuse,
        Lobe::transmission,
        Lobe::multiple_scattering,
        Lobe::anisotropy,
        Lobe::coat,
        Lobe::dispersion,
    ];
    let mut key: Vec<u64> = relevant.iter().map(|lobe| u64::from(lobes.has(*lobe))).collect();
    key.extend(base_varies.iter().chain(coat_varies).map(|x| u64::from(*x)));
    let fixed = |value: f64, varies: bool| if varies { 0 } else { value.to_bits() };
    let has_coat = lobes.has(Lobe::coat);
    key.extend([
        fixed(i.roughness, base_varies[0]),
        fixed(i.anisotropy, base_varies[1] || !lobes.has(Lobe::anisotropy)),
        fixed(i.specular_level, base_varies[2]),
        fixed(i.coat, base_varies[3] || !has_coat),
        fixed(i.specular_ior, false),
        fixed(i.dispersion, !lobes.has(Lobe::dispersion)),
        fixed(i.coat_ior, !has_coat),
        fixed(i.coat_roughness, coat_varies[0] || !has_coat),
        fixed(i.coat_specular_level, coat_varies[2] || !has_coat),
    ]);
    key
}

/// Share of the way along the quarter turn: `|y| / (|x| + |y|)`, nearly proportional to the angle.
fn quarter_angle(p: f64) -> f64 {
    p.atan2(1.0 - p)
}

impl Grid {
    fn new(
        varies: [bool; AXES],
        is_stretched: bool,
        wanted: Wanted,
        interface: impl Fn([Option<f64>; AXES]) -> Interface,
    ) -> Self {
        let varying = varies.iter().filter(|v| **v).count();
        let detail = usize::from(varying > 0);
        let counts = varies.map(|v| if v { STEPS[varying] } else { 1 });
        let azimuths = if is_stretched { AZIMUTHS[detail] } else { 1 };
        let cosines = if is_stretched { COSINES_STRETCHED } else { COSINES }[detail];
        let rows: usize = counts.iter().product();
        let place = |mut row: usize| {
            let mut at = [None; AXES];
            for k in (0..AXES).rev() {
                if counts[k] > 1 {
                    at[k] = Some((row % counts[k]) as f64 / (counts[k] - 1) as f64);
                    row /= counts[k];
                }
            }
            at
        };
        let held = [wanted.metal, wanted.dielectric, wanted.glass, wanted.glass];
        let size = azimuths * cosines;
        let (mut begins, mut length) = ([0; QUANTITIES], 0);
        for (begin, is_held) in begins.iter_mut().zip(held) {
            *begin = length;
            length += if is_held { rows * size } else { 0 };
        }
        let mut values = vec![0.0; length];
        for row in 0..rows {
            let made = fill(&interface(place(row)), wanted, azimuths, cosines, varying);
            for (q, made) in made.iter().enumerate().filter(|(q, _)| held[*q]) {
                let at = begins[q] + row * size;
                values[at..at + size].copy_from_slice(made);
            }
        }
        let weights = mean_weights(azimuths, cosines);
        let mean = |row: &[f32]| row.iter().zip(&weights).map(|(v, w)| f64::from(*v) * w).sum::<f64>() as f32;
        let means = values.chunks_exact(size).map(mean).collect();
        Self { counts, azimuths, cosines, begins, values, means }
    }

    /// Where these numbers (each in `[0, 1]`) lie.
    #[inline(always)]
    pub fn place<L: Lanes>(&self, numbers: [L; AXES]) -> Place<L> {
        let mut place = Place { index: [L::zero(); AXES], fraction: [L::zero(); AXES] };
        for (k, number) in numbers.into_iter().enumerate() {
            if self.counts[k] > 1 {
                (place.index[k], place.fraction[k]) = cell(number, self.counts[k]);
            }
        }
        place
    }

    /// Where a direction lies: `w` in the frame of the stretch, either side.
    #[inline(always)]
    pub fn slant<L: Lanes>(&self, w: V3<L>) -> Slant<L> {
        let (cosine, cosine_fraction) = cell(w.z.abs().sqrt(), self.cosines);
        let (mut azimuth, mut azimuth_fraction) = (L::zero(), L::zero());
        if self.azimuths > 1 {
            let (x, y) = (w.x.abs(), w.y.abs());
            (azimuth, azimuth_fraction) = cell(y / (x + y).max(L::of(1e-20)), self.azimuths);
        }
        Slant { azimuth, azimuth_fraction, cosine, cosine_fraction }
    }

    /// A quantity at a place for a direction. It must be held.
    #[inline(always)]
    pub fn at<L: Lanes>(&self, quantity: Quantity, place: &Place<L>, slant: &Slant<L>) -> L {
        let (na, nc) = (L::of(self.azimuths as f64), L::of(self.cosines as f64));
        let begin = L::of(self.begins[quantity as usize] as f64);
        self.over_numbers(place, begin, Some((slant, na, nc)))
    }

    /// Two neighbours in the cosine.
    #[inline(always)]
    fn pair<L: Lanes>(&self, i: L, fraction: L) -> L {
        L::gather(&self.values, i).lerp(L::gather(&self.values, i + L::one()), fraction)
    }

    /// A row of the table that begins at `begin`: its mean, or its value for a direction (and the counts of azimuths and cosines). No closure,
    /// because those are not always inlined into code for wider instructions.
    #[inline(always)]
    fn row<L: Lanes>(&self, begin: L, row: L, slant: Option<(&Slant<L>, L, L)>) -> L {
        let Some((slant, na, nc)) = slant else { return L::gather(&self.means, begin + row) };
        let i = begin + (row * na + slant.azimuth) * nc + slant.cosine;
        let first = self.pair(i, slant.cosine_fraction);
        if self.azimuths > 1 { first.lerp(self.pair(i + nc, slant.cosine_fraction), slant.azimuth_fraction) } else { first }
    }

    /// Cosine-weighted mean of a quantity over all directions: exactly that of what [`Self::at`] returns, so that lobes built from
    /// both conserve energy.
    #[inline(always)]
    pub fn mean<L: Lanes>(&self, quantity: Quantity, place: &Place<L>) -> L {
        let size = self.azimuths * self.cosines;
        let begin = L::of((self.begins[quantity as usize] / size) as f64);
        self.over_numbers(place, begin, None)
    }

    /// Multilinear interpolation of rows over the numbers that vary.
    #[inline(always)]
    fn over_numbers<L: Lanes>(&self, place: &Place<L>, begin: L, slant: Option<(&Slant<L>, L, L)>) -> L {
        let mut varying = 0;
        for k in 0..AXES {
            varying += usize::from(self.counts[k] > 1);
        }
        if varying == 0 {
            return self.row(begin, L::zero(), slant);
        }
        let mut sum = L::zero();
        for corner in 0..1usize << varying {
            let (mut row, mut weight, mut bit) = (L::zero(), L::one(), 0);
            for k in 0..AXES {
                if self.counts[k] <= 1 {
                    continue;
                }
                let is_upper = (corner >> bit) & 1 == 1;
                bit += 1;
                let step = if is_upper { L::one() } else { L::zero() };
                row = row * L::of(self.counts[k] as f64) + place.index[k] + step;
                weight *= if is_upper { place.fraction[k] } else { L::one() - place.fraction[k] };
            }
            sum += weight * self.row(begin, row, slant);
        }
        sum
    }
}

/// Weights of the entries in the mean over the cosine-weighted hemisphere, exact for what is linear in `sqrt(mu)` and in
/// the share of the quarter turn. They sum to 1.
fn mean_weights(azimuths: usize, cosines: usize) -> Vec<f64> {
    let h = 1.0 / (cosines - 1) as f64;
    let mut over_cosines = vec![0.0; cosines];
    for i in 0..cosines - 1 {
        let (t0, t1) = (i as f64 * h, (i + 1) as f64 * h);
        // Weight 2 mu dmu = 4 t^3 dt; the first moment within the segment goes to its end.
        let whole = t1.powi(4) - t0.powi(4);
        let upper = (0.8 * (t1.powi(5) - t0.powi(5)) - t0 * whole) / h;
        over_cosines[i] += whole - upper;
        over_cosines[i + 1] += upper;
    }
    let mut over_azimuths = vec![0.0; azimuths];
    if azimuths == 1 {
        over_azimuths[0] = 1.0;
    } else {
        const PARTS: usize = 64;
        let n = (azimuths - 1) * PARTS;
        for i in 0..n {
            let (p0, p1) = (i as f64 / n as f64, (i + 1) as f64 / n as f64);
            let weight = (quarter_angle(p1) - quarter_angle(p0)) / FRAC_PI_2;
            let s = 0.5 * (p0 + p1) * (azimuths - 1) as f64;
            let cell = (s as usize).min(azimuths - 2);
            over_azimuths[cell] += weight * (1.0 - (s - cell as f64));
            over_azimuths[cell + 1] += weight * (s - cell as f64);
        }
    }
    over_azimuths.iter().flat_map(|a| over_cosines.iter().map(move |c| a * c)).collect()
}

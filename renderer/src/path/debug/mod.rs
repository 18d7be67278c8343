//! Pictures that show how a picture comes about: what the camera sees first, by which lobes, and how far the samples have come.
//!
//! All are linear Rec.709 in `[0, 1]`, to be encoded for the screen and not tone mapped. Pixels without a surface are black. Cut-through is ignored:
//! a surface is shown where it is cut away. Nothing of this is computed or stored unless a picture is asked for.

mod albedo;
mod colors;
mod samples;
#[cfg(test)]
mod tests;

pub use samples::{SampleView, sample_picture};

use super::prepared::Prepared;
use super::raygen::View;
use super::seen::Seen;
use crate::bsdf::{Optics, SCATTERING};
use crate::bvh::{Hit, Ray};
use burnish_material::{Lobe, LobeSet};
use colors::{Color, hex, ramp};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// One entry of a list of views.
#[derive(Clone, Copy, Debug)]
pub struct ViewDef<V: 'static> {
    /// Identity.
    pub view: V,
    /// Word for machines.
    pub word: &'static str,
    /// Name for the user.
    pub label: &'static str,
    /// One sentence for the user: what the colours mean.
    pub doc: &'static str,
}

/// What the camera sees first, by a property of the surface there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DebugView {
    /// Base colour.
    Albedo,
    /// Shading normal.
    Normal,
    /// Distance.
    Depth,
    /// Texture coordinate.
    Uv,
    /// The lobe that reflects or transmits most.
    Lobes,
    /// Number of lobes at work.
    Overdraw,
    /// What comes back of light from everywhere.
    Furnace,
    /// The same with all colours white.
    WhiteFurnace,
}

/// A colour and what it stands for.
pub type LegendEntry = (&'static str, Color);

impl DebugView {
    /// All views, in the order of a list.
    pub const ALL: &'static [ViewDef<Self>] = &[
        ViewDef { view: Self::Albedo, word: "albedo", label: "Albedo", doc: "The base color, images included." },
        ViewDef {
            view: Self::Normal,
            word: "normal",
            label: "Normal",
            doc: "The shading normal in the world, maps included: x, y, z from -1 to 1 as red, green, blue from 0 to 1.",
        },
        ViewDef {
            view: Self::Depth,
            word: "depth",
            label: "Depth",
            doc: "The smallest distance of the picture over the distance from the camera: white is nearest, black is infinitely far.",
        },
        ViewDef {
            view: Self::Uv,
            word: "uv",
            label: "UV checker",
            doc: "Texture coordinates: u as red, v as green, and eight squares per unit.",
        },
        ViewDef {
            view: Self::Lobes,
            word: "lobes",
            label: "Lobes",
            doc: "The lobe that sends the largest part of light from everywhere to the camera.",
        },
        ViewDef {
            view: Self::Overdraw,
            word: "overdraw",
            label: "Overdraw of lobes",
            doc: "How many lobes are at work at this point.",
        },
        ViewDef {
            view: Self::Furnace,
            word: "furnace",
            label: "Furnace",
            doc: "What the surface reflects and lets through of light from everywhere, in its brightest channel: grey is all of it, blue less, red more.",
        },
        ViewDef {
            view: Self::WhiteFurnace,
            word: "white_furnace",
            label: "White furnace",
            doc: "The furnace with all colors of the material white: what is not grey is a loss or gain of the model itself.",
        },
    ];

    /// The entry of this view.
    pub fn def(self) -> &'static ViewDef<Self> {
        &Self::ALL[self as usize]
    }

    /// What the colours stand for, in the order to be shown; empty where the colours are values.
    pub fn legend(self) -> Vec<LegendEntry> {
        match self {
            Self::Albedo | Self::Normal | Self::Depth | Self::Uv => Vec::new(),
            Self::Lobes => SCATTERING
                .iter()
                .zip(LOBE_COLORS)
                .map(|(lobe, color)| (lobe.def().name, hex(color)))
                .chain([("none", NO_LOBE)])
                .collect(),
            Self::Overdraw => COUNTS.iter().zip(0..).map(|(name, n)| (*name, count_color(n))).collect(),
            Self::Furnace | Self::WhiteFurnace => [
                ("1.1 and above", 1.1),
                ("1.01", 1.01),
                ("1: all light", 1.0),
                ("0.99", 0.99),
                ("0.9", 0.9),
                ("0.5", 0.5),
                ("0: no light", 0.0),
            ]
            .map(|(name, albedo)| (name, furnace_color(albedo)))
            .to_vec(),
        }
    }
}

/// Colours of the lobes of [`SCATTERING`], told apart also by the colour-blind. Source: Okabe and Ito 2008.
const LOBE_COLORS: [u32; SCATTERING.len()] = [0xf0_e442, 0xcc_79a7, 0x56_b4e9, 0xe6_9f00, 0xd5_5e00, 0x00_9e73, 0x00_72b2];
/// The colour of a surface that scatters nothing.
const NO_LOBE: Color = [0.1; 3];
/// Samples per pixel of the lobes and of the furnace; multiples of the widest lanes. All pixels share their numbers, so that what is left of noise
/// is smooth.
const LOBE_SAMPLES: usize = 16;
const FURNACE_SAMPLES: usize = 256;
/// Squares of the checker per unit of the texture coordinate.
const SQUARES: f32 = 8.0;
/// Numbers of lobes that are told apart.
const COUNTS: [&str; 11] = ["0", "1", "2", "3", "4", "5", "6", "7", "8", "9", "10 and more"];
/// The middle of the screen's range.
const MIDDLE_GREY: f32 = 0.214;
/// Gain that is shown as pure red.
const GAIN_MAX: f32 = 0.1;

/// How far a picture is, and whether it is still wanted; shared with who waits for it.
#[derive(Debug, Default)]
pub struct DebugProgress {
    rows: AtomicUsize,
    is_ended: AtomicBool,
}

impl DebugProgress {
    /// Rows that are done.
    pub fn rows(&self) -> usize {
        self.rows.load(Ordering::Relaxed)
    }

    /// Nobody wants the picture any more.
    pub fn end(&self) {
        self.is_ended.store(true, Ordering::Relaxed);
    }
}

/// A picture of what the middles of the pixels show, row by row from the top; `None` if it was ended. `threads` of 0 count as 1. The result does
/// not depend on their number.
pub fn debug_picture(
    prepared: &Prepared,
    view: DebugView,
    (width, height): (usize, usize),
    threads: usize,
    progress: &DebugProgress,
) -> Option<Vec<Color>> {
    let camera = View::new(prepared, width, height);
    let mut pixels = vec![[0.0; 3]; width * height];
    let rows = height.div_ceil(threads.max(1)).max(1);
    std::thread::scope(|scope| {
        for (part, pixels) in pixels.chunks_mut((rows * width).max(1)).enumerate() {
            let camera = &camera;
            scope.spawn(move || {
                for (row, y) in pixels.chunks_mut(width).zip(part * rows..) {
                    if progress.is_ended.load(Ordering::Relaxed) {
                        return;
                    }
                    fill(prepared, view, camera, y, row);
                    progress.rows.fetch_add(1, Ordering::Relaxed);
                }
            });
        }
    });
    if progress.is_ended.load(Ordering::Relaxed) {
        return None;
    }
    if view == DebugView::Depth {
        let nearest = pixels.iter().map(|p| p[0]).filter(|depth| *depth > 0.0).fold(f32::INFINITY, f32::min);
        pixels.iter_mut().filter(|p| p[0] > 0.0).for_each(|p| *p = [nearest / p[0]; 3]);
    }
    Some(pixels)
}

/// One row; of depths as they are.
fn fill(prepared: &Prepared, view: DebugView, camera: &View, y: usize, row: &mut [Color]) {
    let (width, height) = (camera.width as f32, camera.height as f32);
    let direction = |x: usize| camera.basis.direction((x as f32 + 0.5) / width, (y as f32 + 0.5) / height);
    let rays: Vec<Ray> = (0..row.len()).map(|x| Ray::new(camera.basis.origin, direction(x))).collect();
    let mut hits = vec![Hit::MISS; rays.len()];
    prepared.geometry.bvh.trace(&rays, &mut hits);
    for (x, (pixel, hit)) in row.iter_mut().zip(&hits).enumerate().filter(|(_, (_, hit))| !hit.is_miss()) {
        let seen = Seen::new(prepared, hit, direction(x), camera.spread() * hit.t);
        *pixel = match view {
            DebugView::Albedo => seen.optics.base_color.0,
            DebugView::Normal => [seen.frame.n.x, seen.frame.n.y, seen.frame.n.z].map(|c| (0.5 * c + 0.5).clamp(0.0, 1.0)),
            DebugView::Depth => [hit.t; 3],
            DebugView::Uv => checker(seen.at.uv),
            DebugView::Lobes => lobe_color(&seen),
            DebugView::Overdraw => count_color(acting(&seen.optics, seen.surface.lobes).names(true).len()),
            DebugView::Furnace => furnace_color(brightest(albedo::total(&seen, FURNACE_SAMPLES))),
            DebugView::WhiteFurnace => furnace_color(brightest(albedo::total(&seen.whitened(), FURNACE_SAMPLES))),
        };
    }
}

fn checker(uv: [f32; 2]) -> Color {
    let [u, v] = uv.map(|x| if x.is_finite() { x.rem_euclid(1.0) } else { 0.0 });
    let is_light = ((u * SQUARES).floor() + (v * SQUARES).floor()).rem_euclid(2.0) < 1.0;
    [u, v, if is_light { 0.8 } else { 0.1 }]
}

fn brightest(albedo: Color) -> f32 {
    albedo.into_iter().fold(0.0, f32::max)
}

/// Colour of the lobe with the largest directional albedo.
fn lobe_color(seen: &Seen<'_>) -> Color {
    let albedos = albedo::by_lobe(seen, LOBE_SAMPLES).map(|[r, g, b]| r + g + b);
    let (largest, color) = albedos
        .into_iter()
        .zip(LOBE_COLORS)
        .fold((0.0, None), |best, (sum, color)| if sum > best.0 { (sum, Some(color)) } else { best });
    color.filter(|_| largest > 1e-4).map_or(NO_LOBE, hex)
}

/// Lobes that have an effect where the optics are these: of those that images vary, fewer than the material needs.
fn acting(optics: &Optics<f32>, lobes: LobeSet) -> LobeSet {
    let dielectric = optics.w_diffuse + optics.w_transmission;
    let refracts = optics.w_transmission > 0.0;
    let is_idle = |lobe: &Lobe| match lobe {
        Lobe::metal => optics.w_metal <= 0.0,
        Lobe::specular => dielectric <= 0.0 || optics.eta_specular == 1.0,
        Lobe::diffuse => optics.w_diffuse <= 0.0,
        Lobe::transmission => !refracts,
        Lobe::multiple_scattering => optics.is_smooth || (optics.w_metal <= 0.0 && !refracts),
        Lobe::anisotropy => optics.alpha_x == optics.alpha_y,
        Lobe::sheen => optics.sheen <= 0.0,
        Lobe::coat | Lobe::coat_normal_map => optics.coat <= 0.0,
        Lobe::emission => !optics.emission.any(),
        Lobe::opacity => optics.opacity >= 1.0,
        Lobe::absorption => !optics.sigma_a.any() && optics.transmission_tint.min_channel() >= 1.0,
        Lobe::scattering => !optics.sigma_s.any(),
        Lobe::dispersion => !refracts || optics.dispersion <= 0.0,
        Lobe::normal_map | Lobe::height | Lobe::textures => false,
    };
    burnish_material::LOBES.iter().map(|def| def.lobe).filter(is_idle).fold(lobes, LobeSet::without)
}

fn count_color(count: usize) -> Color {
    ramp(count as f32 / (COUNTS.len() - 1) as f32)
}

/// Grey at 1; the root of the difference spreads small ones.
fn furnace_color(albedo: f32) -> Color {
    let mix = |share: f32, to: Color| to.map(|c| MIDDLE_GREY + share.clamp(0.0, 1.0).sqrt() * (c - MIDDLE_GREY));
    if albedo > 1.0 { mix((albedo - 1.0) / GAIN_MAX, [1.0, 0.0, 0.0]) } else { mix(1.0 - albedo, [0.0, 0.0, 1.0]) }
}

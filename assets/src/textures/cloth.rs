//! Woven and knitted cloth: threads that pass over and under one another.

use std::f32::consts::{PI, TAU};

use glam::{UVec2, Vec2, Vec3};

use super::grid::{Grid, Surface, srgb};
use super::noise::{fbm, gradient, hash, smoothstep, unit};

/// How threads cross. Warp runs along v, weft along u.
struct Weave {
    /// Threads per tile in each direction; a multiple of the pattern's repeat.
    threads: u32,
    /// Crossings after which the pattern repeats.
    repeat: u32,
    /// How far the pattern moves from one weft thread to the next.
    step: u32,
    /// On how many of the crossings of a repeat the warp is on top.
    over: u32,
    /// How deep threads dip where they go under, in thread radii.
    crimp: f32,
    /// Width of a thread as a share of its place.
    fill: f32,
    /// Fibre turns along a thread's width; 0 for untwisted filaments.
    twist: f32,
    /// Unevenness of the threads, 0 to 1.
    slub: f32,
    seed: u32,
}

/// A place on cloth.
#[derive(Clone, Copy, Default)]
struct Thread {
    /// In thread radii.
    height: f32,
    is_warp: bool,
    /// Random bits of the thread.
    id: u32,
    /// -1 to 1 across the thread.
    across: f32,
    /// 0 to 1: on top of its float and in the middle of the thread.
    exposed: f32,
}

impl Weave {
    fn is_warp_over(&self, column: i32, row: i32) -> bool {
        (column - row * self.step as i32).rem_euclid(self.repeat as i32) < self.over as i32
    }

    /// Height of a thread's middle between two crossings: +1 over, -1 under.
    fn middle(&self, is_warp: bool, column: i32, row: i32, part: f32) -> f32 {
        let side = |column, row| if self.is_warp_over(column, row) == is_warp { 1.0 } else { -1.0 };
        // From the middle of the last crossing to the middle of the next.
        let step = if part < 0.5 { -1 } else { 1 };
        let (here, next) =
            if is_warp { (side(column, row), side(column, row + step)) } else { (side(column, row), side(column + step, row)) };
        let t = (part - 0.5).abs();
        here + (next - here) * (0.5 - 0.5 * (PI * t).cos())
    }

    fn at(&self, p: Vec2) -> Thread {
        let bent = p + self.slub * 0.16 / self.threads as f32
            * Vec2::new(
                fbm(p, UVec2::new(self.threads / 2, 6), 2, self.seed),
                fbm(p, UVec2::new(6, self.threads / 2), 2, self.seed + 3),
            );
        let scaled = bent * self.threads as f32;
        let (column, row) = (scaled.x.floor() as i32, scaled.y.floor() as i32);
        let f = scaled - scaled.floor();
        let n = self.threads as i32;
        let thread = |is_warp: bool| {
            let (number, part, place) = if is_warp { (column, f.y, f.x) } else { (row, f.x, f.y) };
            let id = hash(number.rem_euclid(n) as u32, u32::from(is_warp), self.seed + 7);
            let length = if is_warp { UVec2::new(self.threads, 10) } else { UVec2::new(10, self.threads) };
            let thick = self.fill * (1.0 + self.slub * (0.2 * (unit(id) - 0.5) + 0.2 * gradient(p, length, self.seed + 11)));
            let across = (2.0 * place - 1.0) / thick.min(1.1);
            let middle = self.middle(is_warp, column, row, part);
            let round = (1.0 - across * across).max(0.0).sqrt();
            let height = if across.abs() < 1.0 { self.crimp * middle + round } else { -1.6 };
            Thread { height, is_warp, id, across, exposed: (0.5 + 0.5 * middle) * round }
        };
        let (warp, weft) = (thread(true), thread(false));
        let mut top = if warp.height > weft.height { warp } else { weft };
        if self.twist > 0.0 {
            // Fibres wind around the thread, so they slant across it.
            let along = if top.is_warp { scaled.y } else { -scaled.x };
            let turns = self.twist * along + 1.5 / PI * top.across.clamp(-1.0, 1.0).asin() + unit(top.id);
            top.height += 0.1 * (TAU * turns).sin() * (1.0 - top.across * top.across).max(0.0);
        }
        top
    }

    fn grid(&self, size: usize) -> Grid<Thread> {
        Grid::from_fn(size, |p| self.at(p))
    }
}

/// Heights with the fuzz of short fibres, in thread radii.
fn heights(threads: &Grid<Thread>, fuzz: f32, seed: u32) -> Grid<f32> {
    let cells = UVec2::splat(threads.size as u32 / 4);
    threads.map(|p, thread| thread.height + fuzz * gradient(p, cells, seed))
}

/// Light that reaches between the threads darkens them, 0 to 1.
fn depth(height: f32) -> f32 {
    0.35 + 0.65 * smoothstep(0.15, 0.75, height)
}

/// A cloth of one colour, which the shade of single threads and gaps varies.
fn dyed(threads: &Grid<Thread>, relief: f32, fuzz: f32, uneven: f32, color: Vec3, roughness: f32, seed: u32) -> Surface {
    let mut ids = threads.values.iter();
    Surface::of_height(heights(threads, fuzz, seed), relief)
        .colored(|p, h| {
            let thread = ids.next().map_or(0.5, |thread| unit(thread.id));
            let fibre = fbm(p, UVec2::splat(60), 2, seed + 1);
            color * depth(h) * (1.0 + uneven * (thread - 0.5) + 0.5 * uneven * fibre)
        })
        .rough(|_, h| roughness + 0.1 * (1.0 - h))
}

/// Directions of the threads on top, in turns from the tangent.
fn rotations(threads: &Grid<Thread>) -> Grid<f32> {
    threads.map(|_, thread| if thread.is_warp { 0.25 } else { 0.0 })
}

pub(super) fn plain(size: usize) -> Surface {
    let weave = Weave { threads: 32, repeat: 2, step: 1, over: 1, crimp: 0.45, fill: 1.0, twist: 1.5, slub: 0.6, seed: 101 };
    dyed(&weave.grid(size), 0.02, 0.05, 0.22, srgb(0xD8D2C4), 0.75, 102)
}

pub(super) fn burlap(size: usize) -> Surface {
    let weave = Weave { threads: 20, repeat: 2, step: 1, over: 1, crimp: 0.5, fill: 0.8, twist: 1.0, slub: 1.0, seed: 111 };
    dyed(&weave.grid(size), 0.035, 0.12, 0.5, srgb(0xA98A5F), 0.85, 112)
}

pub(super) fn twill(size: usize) -> Surface {
    let weave = Weave { threads: 32, repeat: 4, step: 1, over: 2, crimp: 0.35, fill: 1.0, twist: 1.0, slub: 0.35, seed: 121 };
    dyed(&weave.grid(size), 0.018, 0.04, 0.15, srgb(0x6A7078), 0.7, 122)
}

/// Warp threads dyed with indigo on the outside only over undyed weft: where the warp stands out, it wears white.
pub(super) fn denim(size: usize) -> Surface {
    let weave = Weave { threads: 36, repeat: 4, step: 1, over: 3, crimp: 0.35, fill: 1.0, twist: 1.0, slub: 0.9, seed: 131 };
    let threads = weave.grid(size);
    let (indigo, faded, core) = (srgb(0x24365C), srgb(0x5573A0), srgb(0xD9D6CB));
    let mut each = threads.values.iter();
    Surface::of_height(heights(&threads, 0.08, 132), 0.02)
        .colored(|p, h| {
            let Some(thread) = each.next() else { return indigo };
            let tone = unit(thread.id) - 0.5 + 0.6 * fbm(p, UVec2::splat(50), 2, 133);
            let patch = 0.5 + 0.7 * fbm(p, UVec2::splat(3), 3, 134);
            let dyed = if thread.is_warp {
                let worn = smoothstep(0.7, 1.25, thread.exposed * (0.75 + 0.5 * patch) + 0.25 * tone);
                indigo.lerp(faded, (0.22 + 0.4 * tone).clamp(0.0, 1.0)).lerp(core, 0.28 * worn)
            } else {
                core.lerp(faded, 0.75) * 0.6
            };
            dyed * depth(h) * (1.0 + 0.2 * tone)
        })
        .rough(|_, h| 0.8 + 0.1 * (1.0 - h))
}

/// Long floats of untwisted filament: nearly all that is seen runs one way.
pub(super) fn satin(size: usize) -> Surface {
    let weave = Weave { threads: 40, repeat: 5, step: 2, over: 4, crimp: 0.22, fill: 1.05, twist: 0.0, slub: 0.25, seed: 141 };
    let threads = weave.grid(size);
    let mut surface = dyed(&threads, 0.0025, 0.02, 0.1, srgb(0xB8AFA2), 0.3, 142);
    surface.anisotropy_rotation = Some(rotations(&threads));
    surface
}

/// Tows of carbon, two over and two under; what tells them apart is the direction of the fibres.
pub(super) fn carbon(size: usize) -> Surface {
    let weave = Weave { threads: 8, repeat: 4, step: 1, over: 2, crimp: 0.2, fill: 1.02, twist: 0.0, slub: 0.1, seed: 151 };
    let threads = weave.grid(size);
    let filaments = threads.map(|p, thread| {
        let cells = if thread.is_warp { UVec2::new(180, 6) } else { UVec2::new(6, 180) };
        gradient(p, cells, 152)
    });
    let mut height = threads.map(|_, thread| thread.height.max(-0.2));
    height.values.iter_mut().zip(&filaments.values).for_each(|(h, f)| *h += 0.03 * f);
    let mut each = threads.values.iter().zip(&filaments.values);
    let mut surface = Surface::of_height(height, 0.008)
        .colored(|_, _| {
            let Some((thread, filament)) = each.next() else { return Vec3::ZERO };
            srgb(0x555350) * (0.35 + 0.65 * smoothstep(0.0, 0.35, 1.0 - thread.across.abs())) * (1.0 + 0.3 * filament)
        })
        .rough(|_, h| 0.42 - 0.1 * h);
    surface.anisotropy_rotation = Some(rotations(&threads));
    surface
}

/// Stocking stitch: columns of V, each leg a bulge of twisted yarn that comes out of the loop below.
pub(super) fn knit(size: usize) -> Surface {
    const COLUMNS: f32 = 12.0;
    const ROWS: f32 = 16.0;
    let stitch = |p: Vec2| {
        let column = p.x * COLUMNS;
        let x = 2.0 * (column - column.floor()) - 1.0;
        // Both legs are mirror images; the right one is looked at.
        let side = x.abs();
        let bits = hash((column.floor() as i32).rem_euclid(COLUMNS as i32) as u32, 0, 161);
        let y = p.y * ROWS;
        let mut best = Vec3::new(-0.4, 0.0, 0.0);
        for k in -1..=1 {
            let row = y.floor() + k as f32;
            // The leg runs from the middle at the bottom (v large) to the side at the top.
            let t = (row + 1.3 - y) / 1.6;
            if !(0.0..=1.0).contains(&t) {
                continue;
            }
            let middle = 0.16 + 0.42 * smoothstep(0.0, 1.0, t);
            let width = 0.46 * (1.0 - 0.25 * (2.0 * t - 1.0).powi(2));
            let across = (side - middle) / width;
            let round = (1.0 - across * across).max(0.0).sqrt();
            // Bottom ends are on top of the loop that they come from; tops go behind the next.
            let height = round * (0.55 + 0.45 * (PI * t).sin()) + 0.45 * (0.5 - t);
            if across.abs() < 1.0 && height > best.x {
                let turns = 2.2 * t + across * 0.55 + unit(bits);
                best = Vec3::new(
                    height + 0.09 * (TAU * turns).sin() * round,
                    across,
                    unit(hash(bits, row as i32 as u32 % ROWS as u32, 162)),
                );
            }
        }
        best
    };
    let stitches = Grid::from_fn(size, |p| stitch(p + 0.006 * super::noise::warp(p, UVec2::splat(8), 2, 163)));
    let height = stitches.map(|p, s| s.x + 0.1 * fbm(p, UVec2::splat(70), 2, 164));
    let mut each = stitches.values.iter();
    Surface::of_height(height, 0.05)
        .colored(|p, h| {
            let tone = each.next().map_or(0.0, |s| s.z - 0.5);
            srgb(0xB9AFA0) * (0.3 + 0.7 * smoothstep(0.2, 0.7, h)) * (1.0 + 0.12 * tone + 0.12 * fbm(p, UVec2::splat(60), 2, 165))
        })
        .rough(|_, h| 0.92 - 0.12 * h)
}

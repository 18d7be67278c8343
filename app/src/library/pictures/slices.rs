//! Whose turn it is among pictures in sight: each gets a little time before any gets more, and what it has so far is put aside meanwhile.
//!
//! The samples of a small picture take 7 to 14 MB. Those that find no room are lost, and such a picture begins anew with its next, longer slice.

use super::{Key, Order, Purpose};
use crate::digest::Digest;
use crate::library::setup::DEFAULT_SECONDS;
use burnish_renderer::path::{Kept, Rendering};
use std::collections::HashMap;

/// Seconds of rendering, from the very beginning, after which a picture in sight makes room for the others; the last of them end it for good.
pub const SLICES: [f64; 3] = [5.0, 20.0, DEFAULT_SECONDS];
/// Bytes of samples that are put aside.
pub const MAX_BYTES: usize = 256 << 20;

/// A picture that had a slice, or was given up within one.
#[derive(Default)]
struct Begun {
    /// Slices that it has had.
    had: usize,
    /// Its samples, as [`Rendering::keep`] made them; empty where they found no room.
    samples: Vec<u8>,
}

/// What pictures in sight had so far.
pub struct Slices {
    limits: [f64; 3],
    max_bytes: usize,
    begun: HashMap<Key, Begun>,
    bytes: usize,
    /// Error times time of the draft of a look, which is the time to any error but for a factor that all of them share.
    costs: HashMap<Digest, f64>,
}

impl Slices {
    /// None so far. `limits` are seconds that grow, of each slice.
    pub fn new(limits: [f64; 3], max_bytes: usize) -> Self {
        Self { limits, max_bytes, begun: HashMap::new(), bytes: 0, costs: HashMap::new() }
    }

    /// The order in which pictures come, lower first: drafts, then those in sight by the slices that they have had and by what they are expected
    /// to take, at last those that nobody waits for. What nothing is known of may be quick.
    pub fn rank(&self, order: &Order) -> (usize, u64) {
        match order.purpose {
            Purpose::Draft => (0, 0),
            Purpose::Sight => {
                let cost = self.costs.get(&order.entry.look).copied().unwrap_or_default();
                // As whole numbers, since those have an order; infinity becomes the largest.
                (1 + self.had(order.key()), (1e9 * cost) as u64)
            }
            Purpose::Batch => (1 + self.limits.len(), 0),
        }
    }

    fn had(&self, key: Key) -> usize {
        self.begun.get(&key).map_or(0, |begun| begun.had.min(self.limits.len() - 1))
    }

    /// Seconds of rendering, from the very beginning, that a picture in sight may have by the end of its next slice, and whether that is the last.
    pub fn limit(&self, key: Key) -> (f64, bool) {
        let had = self.had(key);
        (self.limits[had], had + 1 == self.limits.len())
    }

    /// Takes note of what the draft of a look took: seconds, and the error that was reached in them, if there is any.
    pub fn expect(&mut self, look: Digest, seconds: f64, relmse: Option<f64>) {
        self.costs.insert(look, relmse.map_or(f64::INFINITY, |relmse| seconds * relmse));
    }

    /// Puts a picture aside, at the end of a slice or within one. Samples of looks that are not wanted now make room.
    pub fn put_aside(&mut self, key: Key, rendering: &Rendering, is_slice_over: bool, is_wanted: impl Fn(Digest) -> bool) {
        let samples = rendering.keep();
        if self.bytes + samples.len() > self.max_bytes {
            for (_, begun) in self.begun.iter_mut().filter(|((look, _), _)| !is_wanted(*look)) {
                self.bytes -= std::mem::take(&mut begun.samples).len();
            }
        }
        let begun = self.begun.entry(key).or_default();
        begun.had += usize::from(is_slice_over);
        self.bytes -= std::mem::take(&mut begun.samples).len();
        if self.bytes + samples.len() <= self.max_bytes {
            self.bytes += samples.len();
            begun.samples = samples;
        }
    }

    /// The samples of a picture, to go on with them.
    pub fn take_up(&mut self, key: Key) -> Option<Kept> {
        let samples = std::mem::take(&mut self.begun.get_mut(&key)?.samples);
        self.bytes -= samples.len();
        // Where there are none it begins anew.
        Kept::read(&samples).ok()
    }

    /// Forgets a picture that is done.
    pub fn done(&mut self, key: Key) {
        self.bytes -= self.begun.remove(&key).map_or(0, |begun| begun.samples.len());
    }

    /// Bytes of the samples that are put aside.
    #[cfg(test)]
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// Samples per pixel of a picture that are put aside.
    #[cfg(test)]
    pub fn spp(&self, key: Key) -> Option<u32> {
        Some(Kept::read(&self.begun.get(&key)?.samples).ok()?.spp())
    }
}

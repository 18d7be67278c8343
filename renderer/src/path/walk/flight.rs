//! One walk for all channels: flights drawn from the mixture of the channels' densities, and weights that divide by that mixture.
//!
//! Drawing from a mean extinction instead would give dense channels unbounded weights. Where extinctions differ by more than
//! [`RATIO_MAX`] one walk serves one channel, chosen at entry.

use super::guide;
use super::jump::{self, Exit};
use super::medium::{Body, Channel};
use super::numbers::{Dimension, Numbers};
use glam::DVec3;

/// Largest ratio of extinctions that one walk serves.
const RATIO_MAX: f64 = 8.0;
/// What a channel that only absorbs counts for in the mixture, against one that only scatters. With 0 a clear absorbing channel beside
/// a dense one would meet the surface with unbounded weight.
const ABSORBING: f64 = 0.1;

/// The channels of a walk and their weights.
pub(super) struct Mixture<'a> {
    channels: &'a [Channel; 3],
    /// Weight so far; 0 for channels that the walk does not serve.
    beta: [f64; 3],
    /// Density with which each channel alone would have drawn the walk so far, times its worth, up to a common factor. Drawing
    /// channels in proportion to it makes the whole walk a draw from a mixture of whole walks, so that a channel's weight stays below
    /// what it would be on its own, times the sum over channels. Without steering it is the weight itself.
    merit: [f64; 3],
    /// Least extinction of the channels that the walk serves.
    slowest: f64,
}

/// A direction and a length that were drawn, and what the weights need of them.
pub(super) struct Flight {
    /// Unit vector.
    pub direction: DVec3,
    /// Distance of the collision, if no surface comes before.
    pub length: f64,
    /// Probability of each channel.
    shares: [f64; 3],
    /// None if all directions were drawn alike, or if it was given.
    steered: Option<Steered>,
}

/// What steering did to the density of a flight, per channel.
#[derive(Clone, Copy)]
struct Steered {
    /// Share of steered flights.
    share: [f64; 3],
    /// Their density of directions over the isotropic one, in this direction.
    ratio: [f64; 3],
    /// The factor of their extinction.
    stretch: [f64; 3],
}

impl<'a> Mixture<'a> {
    /// None if no light comes in. `u` chooses a channel where the walk can serve only one.
    pub(super) fn new(body: &'a Body, throughput: [f32; 3], u: f64) -> Option<Self> {
        let channels = &body.channels;
        let mut beta = throughput.map(|x| if x > 0.0 && x.is_finite() { f64::from(x) } else { 0.0 });
        if beta == [0.0; 3] {
            return None;
        }
        let range = |beta: &[f64; 3]| {
            let carrying = (0..3).filter(|k| beta[*k] > 0.0).map(|k| channels[k].extinction);
            carrying.fold((f64::INFINITY, 0.0f64), |(low, high), x| (low.min(x), high.max(x)))
        };
        let (low, high) = range(&beta);
        let is_mixed = (0..3).any(|k| beta[k] * channels[k].albedo > 0.0);
        if is_mixed && high > RATIO_MAX * low {
            let shares = normalized(std::array::from_fn(|k| beta[k] * worth(&channels[k])))?;
            let chosen = choose(&shares, u);
            beta = std::array::from_fn(|k| if k == chosen { beta[k] / shares[k] } else { 0.0 });
        }
        let slowest = range(&beta).0;
        Some(Self { channels, beta, merit: beta, slowest })
    }

    /// Whether any channel can collide and go on.
    pub(super) fn scatters(&self) -> bool {
        self.iter().any(|(channel, beta)| channel.albedo * beta > 0.0)
    }

    /// Whether any channel's flights are to be steered.
    pub(super) fn steers(&self) -> bool {
        self.iter().any(|(channel, beta)| channel.steered * beta > 0.0)
    }

    /// Least extinction of the channels that the walk serves, 1/normalised unit.
    pub(super) fn slowest(&self) -> f64 {
        self.slowest
    }

    /// Largest weight.
    pub(super) fn largest(&self) -> f64 {
        self.beta.iter().fold(0.0, |a, b| a.max(*b))
    }

    /// Weights.
    pub(super) fn weights(&self) -> [f64; 3] {
        self.beta
    }

    /// What is expected to come straight out of a depth that is known up to an error, up to a common factor. Above 0 where any weight is.
    pub(super) fn expected(&self, depth: f64, error: f64) -> f64 {
        let share = |extinction: f64| (-(extinction * depth / (1.0 + extinction * error)).min(500.0)).exp();
        self.iter().map(|(channel, beta)| beta * share(channel.extinction)).sum()
    }

    /// Weights in single precision.
    pub(super) fn throughput(&self) -> [f32; 3] {
        self.beta.map(|x| x as f32)
    }

    /// Weights after a straight way without collisions, which may be infinite.
    pub(super) fn transmitted(&self, length: f64) -> [f32; 3] {
        std::array::from_fn(|k| {
            let s = self.channels[k].extinction;
            // Nothing comes off zero times infinity.
            let depth = if s > 0.0 { s * length } else { 0.0 };
            (self.beta[k] * (-depth).exp()) as f32
        })
    }

    fn iter(&self) -> impl Iterator<Item = (&Channel, f64)> {
        self.channels.iter().zip(self.beta)
    }

    /// Probability with which each channel is drawn from, where each is worth a factor.
    #[inline(always)]
    fn shares(&self, worth: impl Fn(&Channel) -> f64) -> [f64; 3] {
        let shares = std::array::from_fn(|k| if self.beta[k] > 0.0 { self.merit[k] * worth(&self.channels[k]) } else { 0.0 });
        normalized(shares).unwrap_or_else(|| {
            let largest = (0..3).max_by(|a, b| self.beta[*a].total_cmp(&self.beta[*b])).unwrap_or(0);
            std::array::from_fn(|k| if k == largest { 1.0 } else { 0.0 })
        })
    }

    /// A flight met a surface at a distance.
    pub(super) fn arrive(&mut self, flight: &Flight, t: f64) {
        self.weigh(flight, t, false);
    }

    /// A flight ended in a collision.
    pub(super) fn collide(&mut self, flight: &Flight) {
        self.weigh(flight, flight.length, true);
        self.slowest = self.iter().filter(|(_, beta)| *beta > 0.0).fold(f64::INFINITY, |low, (c, _)| low.min(c.extinction));
    }

    /// Multiplies the weights by what each channel does along the way over the density with which the way was drawn.
    #[inline(always)]
    fn weigh(&mut self, flight: &Flight, t: f64, collides: bool) {
        let (mut value, mut drawn) = ([0.0; 3], [0.0; 3]);
        for k in 0..3 {
            if self.beta[k] <= 0.0 {
                continue;
            }
            let Channel { extinction, albedo, .. } = self.channels[k];
            // A collision has a density over lengths, a surface met has a probability.
            let (rate, kept) = if collides { (extinction, albedo) } else { (1.0, 1.0) };
            let plain = rate * (-extinction * t).exp();
            value[k] = plain * kept;
            drawn[k] = match flight.steered {
                Some(Steered { share, ratio, stretch }) if share[k] > 0.0 => {
                    let rate = if collides { rate * stretch[k] } else { rate };
                    (1.0 - share[k]) * plain + share[k] * ratio[k] * rate * (-extinction * stretch[k] * t).exp()
                }
                _ => plain,
            };
        }
        self.divide(&flight.shares, value, drawn);
    }

    /// Multiplies the weights by a value over the density of the mixture, whose channels drew with the densities `drawn`.
    fn divide(&mut self, shares: &[f64; 3], value: [f64; 3], drawn: [f64; 3]) {
        let density: f64 = shares.iter().zip(drawn).map(|(share, drawn)| share * drawn).sum();
        let inverse = if density > 0.0 { 1.0 / density } else { 0.0 };
        for k in 0..3 {
            self.beta[k] *= value[k] * inverse;
            // The shares hold merit and worth before this step.
            self.merit[k] = shares[k] * drawn[k] * inverse;
        }
    }

    /// Roulette of faint walks, and of long ones whatever their weight. The weight of survivors makes up for the others.
    pub(super) fn survives(&mut self, start: f64, is_long: bool, u: f64) -> bool {
        let share = (self.largest() / (super::FAINT * start)).min(1.0) * if is_long { 0.5 } else { 1.0 };
        // Not a number does not survive.
        if u < share {
            if share < 1.0 {
                self.beta = self.beta.map(|x| x / share);
            }
            return true;
        }
        false
    }

    /// Leaves a sphere of a radius around a collision; returns the cosine against its normal.
    pub(super) fn jump(&mut self, radius: f64, u0: f64, u1: f64) -> f64 {
        let left = |channel: &Channel| jump::weight(channel.albedo, channel.nu, channel.extinction * radius);
        let shares = self.shares(left);
        let exits: [Option<Exit>; 3] = std::array::from_fn(|k| {
            let channel = &self.channels[k];
            (shares[k] > 0.0).then(|| Exit::new(channel.absorbed, channel.extinction * radius))
        });
        let Some(exit) = &exits[choose(&shares, u0)] else { return 1.0 };
        let cosine = exit.sample(u1);
        let is_single = shares.contains(&1.0);
        let drawn: [f64; 3] = std::array::from_fn(|k| match &exits[k] {
            Some(exit) if !is_single => exit.density(cosine),
            Some(_) => 1.0,
            None => 0.0,
        });
        let value = std::array::from_fn(|k| left(&self.channels[k]) * drawn[k]);
        self.divide(&shares, value, drawn);
        cosine
    }
}

impl Flight {
    /// In a direction that is given.
    #[inline(always)]
    pub(super) fn fixed(mixture: &Mixture, direction: DVec3, numbers: &Numbers, number: u32) -> Self {
        let shares = mixture.shares(worth);
        let channel = &mixture.channels[choose(&shares, numbers.at(number, Dimension::Channel))];
        let length = -numbers.at(number, Dimension::Length).ln() / channel.extinction;
        Self { direction, length, shares, steered: None }
    }

    /// After an isotropic collision. `guide` is a unit vector to steer along and a bound on the share of steered flights.
    #[inline(always)]
    pub(super) fn scattered(mixture: &Mixture, guide: Option<(DVec3, f64)>, numbers: &Numbers, number: u32) -> Self {
        let shares = mixture.shares(worth);
        let channel = &mixture.channels[choose(&shares, numbers.at(number, Dimension::Channel))];
        let length = -numbers.at(number, Dimension::Length).ln() / channel.extinction;
        let (u0, u1) = (numbers.at(number, Dimension::Cosine), numbers.at(number, Dimension::Azimuth));
        let Some((n, cap)) = guide else {
            return Self { direction: guide::uniform(u0, u1), length, shares, steered: None };
        };
        let is_steered = numbers.at(number, Dimension::Steer) < channel.steered.min(cap);
        let (direction, mu) = if is_steered {
            let mu = guide::sample(channel.nu, channel.span, u0);
            (guide::around(n, mu, u1), mu)
        } else {
            let direction = guide::uniform(u0, u1);
            (direction, direction.dot(n).clamp(-1.0, 1.0))
        };
        let share = mixture.channels.map(|channel| channel.steered.min(cap));
        let of = |k: usize, f: fn(&Channel, f64) -> f64| if share[k] > 0.0 { f(&mixture.channels[k], mu) } else { 1.0 };
        let steered = Steered {
            share,
            ratio: std::array::from_fn(|k| of(k, |channel, mu| 2.0 * guide::density(channel.nu, channel.span, mu))),
            stretch: std::array::from_fn(|k| of(k, |channel, mu| 1.0 - mu / channel.nu)),
        };
        let length = if is_steered { length / (1.0 - mu / channel.nu) } else { length };
        Self { direction, length, shares, steered: Some(steered) }
    }
}

/// What a channel counts for when one is chosen to draw a flight from.
fn worth(channel: &Channel) -> f64 {
    ABSORBING + (1.0 - ABSORBING) * channel.albedo
}

/// Divided by their sum; none if that is 0 or too small to divide by.
fn normalized(x: [f64; 3]) -> Option<[f64; 3]> {
    let sum: f64 = x.iter().sum();
    (sum > 1e-300).then(|| x.map(|x| x / sum))
}

/// The channel that a number in `[0, 1)` falls to. One without a share is never chosen.
fn choose(shares: &[f64; 3], u: f64) -> usize {
    let mut below = 0.0;
    let mut last = 0;
    for (k, share) in shares.iter().enumerate() {
        if *share > 0.0 {
            below += share;
            last = k;
            if u < below {
                return k;
            }
        }
    }
    last
}

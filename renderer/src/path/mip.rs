//! Images as a property reads them: decoded texels, and coarser copies for footprints larger than a texel.
//!
//! The finest level is the shared image itself, decoded texel by texel as it is read. Coarser ones hold area means of *decoded* values,
//! as many numbers per texel as the property needs, and are made when one is first asked for.

use crate::tonemap::srgb_decode;
use burnish_assets::Image;
use burnish_material::{Affine, Channel, ColorSpace, Kind, Property, TextureRef, Value};
use std::f32::consts::TAU;
use std::sync::{Arc, OnceLock, Weak};

/// What the numbers of an image stand for, and so how they may be averaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Encoding {
    /// One number.
    Scalar,
    /// Three numbers.
    Color,
    /// A direction, stored as 0 to 1; averaged as vectors.
    Direction,
    /// A turn that looks the same half a turn further; averaged as (cos, sin) of twice the angle.
    Axis,
}

impl Encoding {
    fn of(property: Property) -> Self {
        match property.def().default.kind() {
            Kind::Normal => Self::Direction,
            Kind::Color => Self::Color,
            Kind::Float | Kind::Bool if property == Property::anisotropy_rotation => Self::Axis,
            Kind::Float | Kind::Bool => Self::Scalar,
        }
    }

    /// Numbers per texel of a coarser level.
    fn channels(self) -> usize {
        match self {
            Self::Scalar => 1,
            Self::Axis => 2,
            Self::Color | Self::Direction => 3,
        }
    }
}

/// An image with one way to read it. Wrapping and placement are the texture's.
#[derive(Debug)]
pub(super) struct Source {
    image: Arc<Image>,
    channel: Channel,
    is_srgb: bool,
    /// Inversion, scale and bias of linear values; `None` where they are taken as they are.
    affine: Option<Affine>,
    encoding: Encoding,
    /// What stands for a texel that is not finite.
    default: [f32; 3],
    /// Linear values of the 256 stored ones; empty where stored values are linear.
    decode: Vec<f32>,
    coarser: OnceLock<Vec<Level>>,
    constant: OnceLock<Option<[f32; 3]>>,
}

/// A coarser copy.
#[derive(Debug)]
struct Level {
    width: usize,
    texels: Vec<f32>,
}

/// The sources in use, so that an image that is read in one way is averaged once. Textures keep them alive.
#[derive(Clone, Debug, Default)]
pub(super) struct Sources(Vec<Weak<Source>>);

impl Sources {
    /// The source of a reference; made if there is none.
    pub(super) fn get(&mut self, property: Property, reference: &TextureRef, image: &Arc<Image>) -> Arc<Source> {
        let made = Source::new(property, reference, image);
        if let Some(same) = self.0.iter().filter_map(Weak::upgrade).find(|s| s.reads_as(&made)) {
            return same;
        }
        let made = Arc::new(made);
        self.0.push(Arc::downgrade(&made));
        made
    }

    /// Forgets those that nothing uses any more.
    pub(super) fn drop_unused(&mut self) {
        self.0.retain(|s| s.strong_count() > 0);
    }
}

impl Source {
    fn new(property: Property, reference: &TextureRef, image: &Arc<Image>) -> Self {
        let def = property.def();
        let is_srgb = match reference.color_space {
            ColorSpace::Auto => image.is_eight_bit && def.default.kind() == Kind::Color,
            ColorSpace::Srgb => true,
            ColorSpace::Linear => false,
        };
        let decode =
            if is_srgb && image.is_eight_bit { (0..256).map(|i| srgb_decode(i as f32 / 255.0)).collect() } else { Vec::new() };
        let default = match def.default {
            Value::Color(v) | Value::Normal(v) => v.map(|x| x as f32),
            Value::Float(v) => [v as f32; 3],
            Value::Bool(_) => [0.0; 3],
        };
        Self {
            image: image.clone(),
            channel: reference.channel,
            is_srgb,
            affine: reference.affine(def.default.kind()),
            encoding: Encoding::of(property),
            default,
            decode,
            coarser: OnceLock::new(),
            constant: OnceLock::new(),
        }
    }

    fn reads_as(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.image, &other.image)
            && (self.channel, self.is_srgb, self.encoding) == (other.channel, other.is_srgb, other.encoding)
            && self.affine == other.affine
            && self.default == other.default
    }

    /// Columns and rows of a level.
    #[inline(always)]
    pub(super) fn size(&self, level: usize) -> (usize, usize) {
        let half = |n: usize| (n >> level).max(1);
        (half(self.image.width), half(self.image.height))
    }

    /// The number of the coarsest level, a single texel.
    pub(super) fn coarsest(&self) -> usize {
        self.image.width.max(self.image.height).ilog2() as usize
    }

    /// One texel in a form that may be averaged.
    #[inline(always)]
    pub(super) fn texel(&self, level: usize, x: usize, y: usize) -> [f32; 3] {
        if level == 0 {
            return self.averageable(self.image.texels[y * self.image.width + x]);
        }
        let levels = self.coarser.get_or_init(|| self.build());
        let level = &levels[level - 1];
        let channels = self.encoding.channels();
        let at = (y * level.width + x) * channels;
        let texel = &level.texels[at..at + channels];
        match *texel {
            [x] => [x; 3],
            [x, y] => [x, y, 0.0],
            _ => [texel[0], texel[1], texel[2]],
        }
    }

    /// The value of the property from an average. A scalar stands in all three numbers.
    #[inline(always)]
    pub(super) fn value(&self, average: [f32; 3]) -> [f32; 3] {
        if !average.iter().all(|x| x.is_finite()) {
            return self.default;
        }
        if self.encoding != Encoding::Axis {
            return average;
        }
        // Half of the doubled angle, in turns.
        let turn = average[1].atan2(average[0]) / (2.0 * TAU);
        [if turn < 0.0 { turn + 0.5 } else { turn }; 3]
    }

    /// The value if it is the same everywhere.
    pub(super) fn constant(&self) -> Option<[f32; 3]> {
        *self.constant.get_or_init(|| {
            let count = self.image.width * self.image.height;
            let mut texels = self.image.texels[..count].iter().map(|t| self.averageable(*t));
            let first = texels.next()?;
            texels.all(|t| t == first).then(|| self.value(first))
        })
    }

    #[inline(always)]
    fn averageable(&self, stored: [f32; 4]) -> [f32; 3] {
        let linear = self.linear(stored);
        let linear = self.affine.map_or(linear, |affine| affine.apply(linear));
        let is_usable = linear.iter().all(|x| x.is_finite());
        match self.encoding {
            Encoding::Scalar | Encoding::Color => {
                if is_usable {
                    linear
                } else {
                    std::array::from_fn(|k| if linear[k].is_finite() { linear[k] } else { self.default[k] })
                }
            }
            Encoding::Direction => {
                let v = linear.map(|x| 2.0 * x - 1.0);
                // Divided by the largest component first: squares of large numbers would overflow.
                let largest = v.iter().fold(0.0f32, |a, x| a.max(x.abs()));
                let v = v.map(|x| x / largest);
                let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
                // No direction: the middle of the range, or no number.
                if is_usable && largest > 1e-6 && length.is_finite() { v.map(|x| x / length) } else { self.default }
            }
            Encoding::Axis => {
                let turn = if is_usable { linear[0] } else { self.default[0] };
                let (sin, cos) = (2.0 * TAU * (turn - turn.floor())).sin_cos();
                [cos, sin, 0.0]
            }
        }
    }

    /// What is stored, decoded.
    #[inline(always)]
    fn linear(&self, t: [f32; 4]) -> [f32; 3] {
        let decode = |x: f32| {
            if !self.is_srgb {
                x
            } else if self.decode.is_empty() {
                srgb_decode(x)
            } else {
                self.decode[(x * 255.0 + 0.5).clamp(0.0, 255.0) as usize]
            }
        };
        let channel = match self.channel {
            Channel::Rgb => {
                let c = [decode(t[0]), decode(t[1]), decode(t[2])];
                let is_scalar = matches!(self.encoding, Encoding::Scalar | Encoding::Axis);
                return if is_scalar { [(c[0] + c[1] + c[2]) / 3.0; 3] } else { c };
            }
            Channel::R => decode(t[0]),
            Channel::G => decode(t[1]),
            Channel::B => decode(t[2]),
            // Alpha is never encoded.
            Channel::A => t[3],
        };
        [channel; 3]
    }

    /// All coarser levels, each from the next finer one.
    fn build(&self) -> Vec<Level> {
        let channels = self.encoding.channels();
        let mut levels: Vec<Level> = Vec::new();
        for number in 1..=self.coarsest() {
            let (from_width, from_height) = self.size(number - 1);
            let (width, height) = self.size(number);
            let (columns, rows) = (Taps::all(from_width, width), Taps::all(from_height, height));
            let finer = levels.last();
            let mut texels = Vec::with_capacity(width * height * channels);
            for row in &rows {
                for column in &columns {
                    let mut sum = [0.0f64; 3];
                    for (y, wy) in row.each() {
                        for (x, wx) in column.each() {
                            let value = match finer {
                                None => self.averageable(self.image.texels[y * from_width + x]),
                                Some(level) => {
                                    let at = (y * from_width + x) * channels;
                                    std::array::from_fn(|k| if k < channels { level.texels[at + k] } else { 0.0 })
                                }
                            };
                            for (sum, value) in sum.iter_mut().zip(value) {
                                *sum += wy * wx * f64::from(value);
                            }
                        }
                    }
                    texels.extend(sum[..channels].iter().map(|x| *x as f32));
                }
            }
            levels.push(Level { width, texels });
        }
        levels
    }
}

/// Texels of the finer level that a coarser one covers along one axis: three at most, with the share of its length that each takes.
/// Shares are exact for odd sizes too, so every level has the mean of the image.
struct Taps {
    first: usize,
    weights: [f64; 3],
}

impl Taps {
    fn all(from: usize, to: usize) -> Vec<Self> {
        let length = from as f64 / to as f64;
        let of = |i: usize| {
            // The texel covers [i, i + 1] * from / to, and from is to, 2 to or 2 to + 1.
            let first = i * from / to;
            let (start, end) = (i as f64 * length, (i + 1) as f64 * length);
            let share = |k: usize| {
                let left = (first + k) as f64;
                ((end.min(left + 1.0) - start.max(left)) / length).max(0.0)
            };
            let inside = |k: usize| if first + k < from { share(k) } else { 0.0 };
            Self { first, weights: [inside(0), inside(1), inside(2)] }
        };
        (0..to).map(of).collect()
    }

    fn each(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        // Rounding may leave a share of 1e-16 to a neighbour; it does no harm where the texel exists.
        self.weights.iter().enumerate().filter(|(_, w)| **w > 0.0).map(|(k, w)| (self.first + k, *w))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn source(property: Property, width: usize, height: usize, f: impl Fn(usize, usize) -> [f32; 4]) -> Source {
        let texels = (0..width * height).map(|i| f(i % width, i / width)).collect();
        let image = Arc::new(Image { width, height, texels, is_eight_bit: false });
        Source::new(property, &TextureRef::new("a"), &image)
    }

    #[test]
    fn every_level_has_the_mean_of_the_image() {
        for (width, height) in [(16, 16), (13, 7), (1, 9), (5, 1), (1, 1), (3, 31)] {
            let value = |x: usize, y: usize| ((x * 7 + y * 13) % 11) as f32 + 0.25;
            let s = source(Property::roughness, width, height, |x, y| [value(x, y); 4]);
            let count = (width * height) as f64;
            let mean: f64 = (0..width * height).map(|i| f64::from(value(i % width, i / width))).sum::<f64>() / count;
            for level in 0..=s.coarsest() {
                let (w, h) = s.size(level);
                let sum: f64 = (0..w * h).map(|i| f64::from(s.texel(level, i % w, i / w)[0])).sum();
                assert!((sum / (w * h) as f64 / mean - 1.0).abs() < 1e-6, "{width} by {height}, level {level}");
            }
            assert_eq!(s.size(s.coarsest()), (1, 1));
        }
    }

    #[test]
    fn colours_are_averaged_after_decoding() {
        let texels = vec![[0.0, 0.0, 0.0, 1.0], [1.0; 4], [1.0; 4], [0.0, 0.0, 0.0, 1.0]];
        let image = Arc::new(Image { width: 2, height: 2, texels, is_eight_bit: true });
        let s = Source::new(Property::base_color, &TextureRef::new("a"), &image);
        assert!((s.texel(1, 0, 0)[0] - 0.5).abs() < 1e-6);
    }

    #[test]
    fn unusable_texels_do_not_spread() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let s = source(Property::roughness, 2, 2, |x, y| if x + y == 0 { [bad; 4] } else { [0.3; 4] });
            assert!((s.value(s.texel(1, 0, 0))[0] - 0.3).abs() < 1e-6);
            let n = source(Property::normal, 2, 2, |x, y| if x + y == 0 { [bad; 4] } else { [0.5, 0.5, 1.0, 1.0] });
            assert_eq!(n.value(n.texel(1, 0, 0)), [0.0, 0.0, 1.0]);
        }
        // Grey is no direction.
        let grey = source(Property::coat_normal, 2, 2, |_, _| [0.5; 4]);
        assert_eq!(grey.texel(0, 0, 0), [0.0, 0.0, 1.0]);
        // The ends of half and single precision, and negative values, stay what they are.
        for x in [65504.0, -3.0, 3e38] {
            let s = source(Property::height, 2, 2, |_, _| [x, 0.0, 0.0, 1.0]);
            assert!((s.texel(1, 0, 0)[0] - x / 3.0).abs() <= 1e-6 * x.abs(), "{x}");
        }
    }

    #[test]
    fn directions_are_averaged_as_vectors() {
        let s = source(Property::normal, 2, 1, |x, _| if x == 0 { [1.0, 0.5, 0.5, 1.0] } else { [0.5, 0.5, 1.0, 1.0] });
        assert_eq!(s.texel(1, 0, 0), [0.5, 0.0, 0.5]);
    }

    #[test]
    fn turns_are_averaged_across_the_wrap() {
        let turn = |a: f32, b: f32| {
            let s = source(Property::anisotropy_rotation, 2, 1, |x, _| [if x == 0 { a } else { b }; 4]);
            s.value(s.texel(1, 0, 0))[0]
        };
        // Distance of axes, which half a turn carries into themselves.
        let distance = |a: f32, b: f32| ((a - b) * 2.0 - ((a - b) * 2.0).round()).abs() / 2.0;
        for (a, b, mean) in [(0.98, 0.04, 0.01), (0.49, 0.01, 0.0), (0.1, 0.2, 0.15), (0.6, 0.1, 0.1), (0.25, 0.35, 0.3)] {
            assert!(distance(turn(a, b), mean) < 1e-5, "{a} and {b}: {}", turn(a, b));
        }
    }

    #[test]
    fn inverted_values_are_linear_ones() {
        let read = |property, texel: [f32; 4], is_eight_bit| {
            let image = Arc::new(Image { width: 1, height: 1, texels: vec![texel], is_eight_bit });
            let s = Source::new(property, &TextureRef { is_inverted: true, ..TextureRef::new("a") }, &image);
            assert_eq!(s.constant(), Some(s.value(s.texel(0, 0, 0))));
            s.value(s.texel(0, 0, 0))
        };
        assert_eq!(read(Property::roughness, [0.25; 4], false), [0.75; 3]);
        assert_eq!(read(Property::height, [3.0; 4], false), [-2.0; 3]);
        assert!((read(Property::anisotropy_rotation, [0.375; 4], false)[0] - 0.125).abs() < 1e-6);
        let decoded = read(Property::base_color, [0.0, 0.5, 1.0, 1.0], true);
        assert!(decoded.iter().zip([1.0, 1.0 - 0.2158, 0.0]).all(|(a, b)| (a - b).abs() < 2e-3), "{decoded:?}");
        // Only green of a direction, and what stands for texels without use stays as it is.
        let normal = read(Property::normal, [0.8, 0.9, 0.5, 1.0], false);
        assert!((normal[0] - 0.6).abs() < 1e-6 && (normal[1] + 0.8).abs() < 1e-6 && normal[2].abs() < 1e-6, "{normal:?}");
        assert_eq!(read(Property::roughness, [f32::NAN; 4], false), [0.3; 3]);
    }

    #[test]
    fn scaled_values_are_linear_ones() {
        let read = |property, texels: &[[f32; 4]], is_eight_bit, edit: &dyn Fn(&mut TextureRef)| {
            let image = Arc::new(Image { width: texels.len(), height: 1, texels: texels.to_vec(), is_eight_bit });
            let mut reference = TextureRef { scale: [2.0, 0.5, 1.0], bias: [0.125, -1.0, 0.0], ..TextureRef::new("a") };
            edit(&mut reference);
            Source::new(property, &reference, &image)
        };
        let one = |property, texel: [f32; 4], is_eight_bit, edit: &dyn Fn(&mut TextureRef)| {
            let s = read(property, &[texel], is_eight_bit, edit);
            assert_eq!(s.constant(), Some(s.value(s.texel(0, 0, 0))));
            s.value(s.texel(0, 0, 0))
        };
        // Decoded, and of a scalar the mean taken, before anything is scaled.
        let decoded = one(Property::base_color, [0.5, 0.0, 1.0, 1.0], true, &|_| {});
        assert!(decoded.iter().zip([0.125 + 2.0 * 0.2158, -1.0, 1.0]).all(|(a, b)| (a - b).abs() < 4e-3), "{decoded:?}");
        assert_eq!(one(Property::roughness, [0.25, 0.5, 0.75, 1.0], false, &|_| {}), [1.125; 3]);
        assert_eq!(one(Property::roughness, [0.25, 0.5, 0.75, 1.0], false, &|r| r.is_inverted = true), [1.125; 3]);
        assert_eq!(one(Property::roughness, [0.25, 0.5, 0.75, 1.0], false, &|r| r.channel = Channel::B), [1.625; 3]);
        assert!((one(Property::anisotropy_rotation, [0.5; 4], false, &|_| {})[0] - 0.125).abs() < 1e-6);
        // Directions are left alone, and so are texels that are no numbers.
        assert_eq!(one(Property::normal, [0.5, 0.5, 1.0, 1.0], false, &|_| {}), [0.0, 0.0, 1.0]);
        assert_eq!(one(Property::roughness, [f32::NAN; 4], false, &|_| {}), [0.3; 3]);
        // Beyond single precision its end is read, at every level.
        let huge = read(Property::height, &[[1e38; 4], [1e38; 4]], false, &|r| r.scale = [1e300; 3]);
        assert_eq!([huge.value(huge.texel(0, 1, 0)), huge.value(huge.texel(1, 0, 0))], [[f32::MAX; 3]; 2]);
        // Means of scaled values are scaled means.
        let s = read(Property::base_color, &[[0.0; 4], [1.0; 4]], false, &|_| {});
        assert_eq!(s.value(s.texel(1, 0, 0)), [1.125, -0.75, 0.5]);
    }

    #[test]
    fn images_are_averaged_once() {
        let image = Arc::new(Image { width: 4, height: 4, texels: vec![[0.5; 4]; 16], is_eight_bit: true });
        let mut sources = Sources::default();
        let mut get = |property, edit: &dyn Fn(&mut TextureRef)| {
            let mut reference = TextureRef::new("a");
            edit(&mut reference);
            sources.get(property, &reference, &image)
        };
        let first = get(Property::base_color, &|_| {});
        assert!(Arc::ptr_eq(&first, &get(Property::base_color, &|r| r.uv_scale = [4.0, 4.0])));
        assert!(!Arc::ptr_eq(&first, &get(Property::base_color, &|r| r.color_space = ColorSpace::Linear)));
        assert!(!Arc::ptr_eq(&first, &get(Property::base_color, &|r| r.is_inverted = true)));
        assert!(!Arc::ptr_eq(&first, &get(Property::base_color, &|r| r.scale[1] = 0.5)));
        assert!(!Arc::ptr_eq(&first, &get(Property::base_color, &|r| r.bias[2] = 0.5)));
        assert!(!Arc::ptr_eq(&first, &get(Property::base_color, &|r| r.channel = Channel::A)));
        assert!(!Arc::ptr_eq(&first, &get(Property::roughness, &|_| {})));
        sources.drop_unused();
        assert_eq!(sources.0.len(), 1);
    }
}

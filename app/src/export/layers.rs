//! Further values per pixel, for compositing and for looking into.

use burnish_renderer::tonemap::{Display, srgb_encode};

/// Further values per pixel.
#[derive(Clone, Debug)]
pub struct Layer {
    /// What it holds; also how PNG shows it.
    pub kind: LayerKind,
    /// Which of several layers of the kind.
    pub part: Option<&'static str>,
    /// One plane of `width * height` values per channel of the kind.
    pub planes: Vec<Vec<f32>>,
}

/// Layers that a picture can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LayerKind {
    /// Linear colour of the surface that is seen first.
    Albedo,
    /// World-space shading normal of that surface; zero where there is none.
    Normal,
    /// Distance to that surface in scene units; not finite or 0 where there is none.
    Depth,
    /// Variance of the pixel's mean.
    Variance,
    /// Samples in the pixel.
    Samples,
    /// Place of that surface in scene units; zero where there is none.
    Position,
    /// Radiance that the surface emits by itself.
    Emission,
    /// Radiance by the lobe that sent it to the camera, one layer each; together they are the picture.
    Lobes,
    /// Standard error of the pixel's mean relative to its brightness.
    Error,
}

impl LayerKind {
    /// All kinds with the words that options and files use.
    pub const ALL: [(Self, &'static str); 9] = [
        (Self::Albedo, "albedo"),
        (Self::Normal, "normal"),
        (Self::Depth, "depth"),
        (Self::Variance, "variance"),
        (Self::Samples, "samples"),
        (Self::Position, "position"),
        (Self::Emission, "emission"),
        (Self::Lobes, "lobes"),
        (Self::Error, "error"),
    ];

    /// The word that options and files use.
    pub fn word(self) -> &'static str {
        Self::ALL[self as usize].1
    }

    /// What it holds, for people.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Albedo => "Colour of the surface that is seen first",
            Self::Normal => "Its shading normal, world",
            Self::Depth => "Its distance in scene units",
            Self::Variance => "Variance of each pixel's mean",
            Self::Samples => "How many samples each pixel has",
            Self::Position => "Place of the surface that is seen first, scene units",
            Self::Emission => "Light that the surface emits by itself",
            Self::Lobes => "Light by the lobe that scattered it; takes another rendering",
            Self::Error => "Error of each pixel relative to its brightness",
        }
    }

    /// The kind that a word means, in any case.
    pub fn from_word(word: &str) -> Option<Self> {
        Self::ALL.iter().find(|(_, text)| text.eq_ignore_ascii_case(word)).map(|(kind, _)| *kind)
    }

    /// Names of the planes, as other programs know them.
    pub fn channels(self) -> &'static [&'static str] {
        match self {
            Self::Albedo | Self::Variance | Self::Emission | Self::Lobes => &["R", "G", "B"],
            Self::Normal | Self::Position => &["X", "Y", "Z"],
            Self::Depth => &["Z"],
            Self::Samples | Self::Error => &["V"],
        }
    }

    /// Whether halves hold it well enough.
    pub(super) fn fits_half(self) -> bool {
        matches!(self, Self::Albedo | Self::Normal | Self::Emission | Self::Lobes)
    }
}

/// Relative error that PNG shows white.
const WHITE_ERROR: f32 = 0.1;

impl Layer {
    /// What files call it: `albedo`, `lobes.diffuse`.
    pub fn name(&self) -> String {
        self.part.map_or_else(|| self.kind.word().to_owned(), |part| format!("{}.{part}", self.kind.word()))
    }

    /// The layer made visible, three values in `[0, 1]` per pixel: colours through the sRGB curve, radiance through the display transform, normals
    /// from -1..1, places within the range of the picture, variance as the standard deviation, the nearest depth white and the farthest dark,
    /// samples relative to the most, errors up to 10 %.
    pub(super) fn shown(&self, display: Display) -> impl Iterator<Item = [f32; 3]> {
        let count = self.planes.first().map_or(0, Vec::len);
        let plane = |channel: usize| self.planes.get(channel).or(self.planes.first()).map_or(&[][..], Vec::as_slice);
        let planes = [plane(0), plane(1), plane(2)];
        let is_depth = |d: &f32| d.is_finite() && *d > 0.0;
        let is_met = move |d: &f32| self.kind != LayerKind::Depth || is_depth(d);
        let range = planes.map(|plane| {
            let known = || plane.iter().copied().filter(|x| x.is_finite() && is_met(x));
            (known().fold(f32::INFINITY, f32::min), known().fold(f32::NEG_INFINITY, f32::max))
        });
        let one = move |channel: usize, x: f32| match (self.kind, range[channel]) {
            (LayerKind::Albedo, _) => srgb_encode(x),
            (LayerKind::Normal, _) => 0.5 + 0.5 * x,
            (LayerKind::Variance, _) => srgb_encode(x.max(0.0).sqrt()),
            (LayerKind::Samples, (_, most)) => x / most.max(1.0),
            (LayerKind::Error, _) => x / WHITE_ERROR,
            (LayerKind::Position, (least, most)) => (x - least) / (most - least).max(f32::MIN_POSITIVE),
            // A picture of one depth is white, so the range is not divided by if it is empty.
            (LayerKind::Depth, (nearest, farthest)) if is_depth(&x) => {
                1.0 - 0.8 * (x - nearest) / (farthest - nearest).max(f32::MIN_POSITIVE)
            }
            (LayerKind::Depth, _) => 0.0,
            (LayerKind::Emission | LayerKind::Lobes, _) => x,
        };
        (0..count).map(move |i| {
            let values = [0, 1, 2].map(|channel| one(channel, planes[channel].get(i).copied().unwrap_or(0.0)));
            if matches!(self.kind, LayerKind::Emission | LayerKind::Lobes) { display.apply(values) } else { values }
        })
    }
}

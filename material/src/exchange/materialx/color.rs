//! Colour spaces of MaterialX documents, and constants brought into linear Rec.709.
//!
//! Names and curves are those of MaterialX's default colour management (version 1.39). The matrices follow from the primaries and whites of
//! the spaces with a Bradford adaptation to D65.

type Matrix = [[f64; 3]; 3];

const AP1: Matrix = [
    [1.705050992658, -0.621792120657, -0.083258872001],
    [-0.130256417507, 1.140804736575, -0.010548319068],
    [-0.024003356805, -0.128968976065, 1.15297233287],
];
const ADOBE_RGB: Matrix = [[1.39835574, -0.39835574, 0.0], [0.0, 1.0, 0.0], [0.0, -0.04292933, 1.04292933]];
const DISPLAY_P3: Matrix =
    [[1.22493029, -0.22492968, 0.0], [-0.04205868, 1.04205894, 0.0], [-0.01964128, -0.07864794, 1.09828909]];
const REC2020: Matrix = [[1.660491, -0.587641, -0.07285], [-0.12455, 1.1329, -0.00835], [-0.018151, -0.100579, 1.11873]];

/// How stored numbers of a space become linear.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Curve {
    Linear,
    Power(f64),
    Srgb,
}

/// What a name of a colour space means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Space {
    curve: Curve,
    to_rec709: Option<&'static Matrix>,
}

impl Space {
    /// The space of this name; none if MaterialX does not know it.
    pub fn named(name: &str) -> Option<Self> {
        let space = |curve, to_rec709| Some(Self { curve, to_rec709 });
        match name {
            "" | "none" | "raw" | "lin_rec709" | "lin_srgb" | "lin_rec709_scene" => space(Curve::Linear, None),
            "srgb_texture" | "srgb_rec709_scene" | "srgb" | "sRGB" => space(Curve::Srgb, None),
            "g18_rec709" | "g18_rec709_scene" => space(Curve::Power(1.8), None),
            "g22_rec709" | "g22_rec709_scene" | "gamma22" => space(Curve::Power(2.2), None),
            "rec709_display" | "gamma24" => space(Curve::Power(2.4), None),
            "acescg" | "lin_ap1" | "lin_ap1_scene" => space(Curve::Linear, Some(&AP1)),
            "g22_ap1" | "g22_ap1_scene" => space(Curve::Power(2.2), Some(&AP1)),
            "lin_adobergb" | "lin_adobergb_scene" => space(Curve::Linear, Some(&ADOBE_RGB)),
            "adobergb" | "g22_adobergb_scene" => space(Curve::Power(563.0 / 256.0), Some(&ADOBE_RGB)),
            "lin_displayp3" | "lin_p3d65_scene" => space(Curve::Linear, Some(&DISPLAY_P3)),
            "srgb_displayp3" | "srgb_p3d65_scene" => space(Curve::Srgb, Some(&DISPLAY_P3)),
            "lin_rec2020" | "lin_rec2020_scene" => space(Curve::Linear, Some(&REC2020)),
            _ => None,
        }
    }

    /// Whether numbers mean the same in linear Rec.709.
    pub fn is_linear_rec709(self) -> bool {
        self.curve == Curve::Linear && self.to_rec709.is_none()
    }

    /// Whether an image of this space is one that a texture can say: Rec.709 primaries and the sRGB curve.
    pub fn is_srgb(self) -> bool {
        self.curve == Curve::Srgb && self.to_rec709.is_none()
    }

    /// A colour of this space in linear Rec.709.
    pub fn to_linear_rec709(self, color: [f64; 3]) -> [f64; 3] {
        let linear = color.map(|c| match self.curve {
            Curve::Linear => c,
            Curve::Power(power) => c.max(0.0).powf(power),
            Curve::Srgb if c <= 0.04045 => c / 12.92,
            Curve::Srgb => ((c + 0.055) / 1.055).powf(2.4),
        });
        match self.to_rec709 {
            None => linear,
            Some(matrix) => matrix.map(|row| row.iter().zip(linear).map(|(a, b)| a * b).sum()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_stays_white_in_every_space() {
        for name in
            ["acescg", "lin_ap1", "g22_ap1", "lin_adobergb", "adobergb", "lin_displayp3", "srgb_displayp3", "srgb_texture"]
        {
            let white = Space::named(name).expect(name).to_linear_rec709([1.0; 3]);
            assert!(white.iter().all(|c| (c - 1.0).abs() < 1e-4), "{name}: {white:?}");
        }
    }
}

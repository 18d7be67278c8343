//! Display transforms: linear scene radiance to display-referred sRGB. Shared by both views and the export; twin of `tonemap.wgsl`.

use std::fmt;

/// How linear radiance becomes a displayed colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DisplayTransform {
    /// Khronos PBR Neutral: keeps base colours as they are, compresses highlights only.
    #[default]
    Neutral,
    /// AgX with its default contrast.
    Agx,
    /// ACES filmic, Hill's fit of RRT and ODT.
    Aces,
    /// No compression: the sRGB curve, clipped by value so that hues do not shift.
    Standard,
}

/// Exposure and display transform: what a finished picture is shown through.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Display {
    /// Stops; radiance is multiplied by `2^exposure_ev`.
    pub exposure_ev: f32,
    /// Curve from radiance to display.
    pub transform: DisplayTransform,
}

impl DisplayTransform {
    /// All transforms with the words that options use.
    pub const ALL: [(Self, &'static str); 4] =
        [(Self::Neutral, "neutral"), (Self::Agx, "agx"), (Self::Aces, "aces"), (Self::Standard, "standard")];

    /// The transform that a word means.
    pub fn from_word(word: &str) -> Option<Self> {
        Self::ALL.iter().find(|(_, text)| text.eq_ignore_ascii_case(word)).map(|(t, _)| *t)
    }
}

impl fmt::Display for DisplayTransform {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(Self::ALL[*self as usize].1)
    }
}

impl Display {
    /// Display-referred sRGB in `[0, 1]` (gamma-encoded) of linear Rec.709 radiance. Non-finite and negative channels count as 0.
    pub fn apply(&self, radiance: [f32; 3]) -> [f32; 3] {
        let gain = self.exposure_ev.clamp(-64.0, 64.0).exp2();
        let c = radiance.map(|x| if x.is_finite() { (x * gain).clamp(0.0, 1e9) } else { 0.0 });
        match self.transform {
            DisplayTransform::Neutral => neutral(c).map(srgb_encode),
            DisplayTransform::Agx => agx(c),
            DisplayTransform::Aces => aces(c).map(srgb_encode),
            DisplayTransform::Standard => standard(c).map(srgb_encode),
        }
    }

    /// `apply` rounded to bytes.
    pub fn apply_u8(&self, radiance: [f32; 3]) -> [u8; 3] {
        self.apply(radiance).map(|x| (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8)
    }
}

/// The sRGB curve. `x` in `[0, 1]`.
pub fn srgb_encode(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// The inverse of the sRGB curve. `x` in `[0, 1]`.
pub fn srgb_decode(x: f32) -> f32 {
    if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

/// Khronos PBR Neutral tone mapper, specification of 2024.
fn neutral(c: [f32; 3]) -> [f32; 3] {
    const START: f32 = 0.8 - 0.04;
    const DESATURATION: f32 = 0.15;
    let x = c[0].min(c[1]).min(c[2]);
    let offset = if x < 0.08 { x - 6.25 * x * x } else { 0.04 };
    let c = c.map(|v| v - offset);
    let peak = c[0].max(c[1]).max(c[2]);
    if peak < START {
        return c;
    }
    let d = 1.0 - START;
    let new_peak = 1.0 - d * d / (peak + d - START);
    let g = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    c.map(|v| {
        let v = v * (new_peak / peak);
        v + (new_peak - v) * g
    })
}

/// AgX by Troy Sobotka, in the polynomial form of Benjamin Wrensch (2023). Returns gamma-encoded values.
fn agx(c: [f32; 3]) -> [f32; 3] {
    const MIN_EV: f32 = -12.473_93;
    const MAX_EV: f32 = 4.026_069;
    let inset = [
        [0.842_479_06, 0.078_433_6, 0.079_223_745],
        [0.042_328_242, 0.878_468_63, 0.079_166_13],
        [0.042_375_654, 0.078_433_6, 0.879_143],
    ];
    let outset = [
        [1.196_879, -0.098_020_88, -0.099_029_74],
        [-0.052_896_85, 1.151_903_1, -0.098_961_18],
        [-0.052_971_635, -0.098_043_45, 1.151_073_7],
    ];
    let c = multiply(inset, c).map(|x| {
        let x = (x.max(1e-10).log2().clamp(MIN_EV, MAX_EV) - MIN_EV) / (MAX_EV - MIN_EV);
        let x2 = x * x;
        let x4 = x2 * x2;
        15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x - 0.002_32
    });
    multiply(outset, c).map(|x| x.clamp(0.0, 1.0))
}

/// ACES RRT and ODT, fit by Stephen Hill.
fn aces(c: [f32; 3]) -> [f32; 3] {
    let input = [[0.597_19, 0.354_58, 0.048_23], [0.076_00, 0.908_34, 0.015_66], [0.028_40, 0.133_83, 0.837_77]];
    let output = [[1.604_75, -0.531_08, -0.073_67], [-0.102_08, 1.108_13, -0.006_05], [-0.003_27, -0.072_76, 1.076_02]];
    let c = multiply(input, c).map(|v| (v * (v + 0.024_578_6) - 0.000_090_537) / (v * (0.983_729 * v + 0.432_951) + 0.238_081));
    multiply(output, c).map(|x| x.clamp(0.0, 1.0))
}

/// Limits by value, not by channel, so that hues keep (specification, Emission).
fn standard(c: [f32; 3]) -> [f32; 3] {
    let peak = c[0].max(c[1]).max(c[2]).max(1.0);
    c.map(|x| x / peak)
}

fn multiply(m: [[f32; 3]; 3], c: [f32; 3]) -> [f32; 3] {
    m.map(|row| row[0] * c[0] + row[1] * c[1] + row[2] * c[2])
}

//! Numbers as MaterialX writes them, and numbers that follow an image or the coordinates in a straight line.
//!
//! A value of up to four components is known either as constants or as *parts*: each component a weighted sum of the channels of one source,
//! plus a constant. Sums, products with constants, mixing, extraction and everything else that is linear keep that form exactly, so that any
//! such graph folds into one binding.

/// How many numbers a type of MaterialX holds; none for types that are no numbers.
pub fn count_of(kind: &str) -> Option<usize> {
    Some(match kind {
        "float" | "integer" | "boolean" => 1,
        "vector2" => 2,
        "color3" | "vector3" => 3,
        "color4" | "vector4" => 4,
        _ => return None,
    })
}

/// Finite numbers of a text, separated by commas or spaces; none unless there are exactly `count`, at most 4.
pub fn parse(text: &str, count: usize) -> Option<[f64; 4]> {
    let mut words = text.split(|c: char| c == ',' || c.is_ascii_whitespace()).filter(|word| !word.is_empty());
    let mut numbers = [0.0; 4];
    for number in numbers.get_mut(..count)? {
        let word = words.next()?;
        *number = match word {
            "true" => 1.0,
            "false" => 0.0,
            word => word.parse().ok().filter(|x: &f64| x.is_finite())?,
        };
    }
    words.next().is_none().then_some(numbers)
}

/// A number as MaterialX holds it: in single precision, as its shortest decimal. What is too large or too small becomes the nearest that can
/// be held; not a number becomes 0.
pub fn text(x: f64) -> String {
    let single = x.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32;
    match single {
        x if x.is_nan() => "0".to_owned(),
        // Readers refuse numbers below the normal range.
        x if x.abs() < f32::MIN_POSITIVE => if x.is_sign_negative() { "-0" } else { "0" }.to_owned(),
        x => short(format!("{x:?}")),
    }
}

/// A number as the shortest decimal that reads back as the same bits.
pub fn wide(x: f64) -> String {
    short(format!("{x:?}"))
}

fn short(mut text: String) -> String {
    if text.ends_with(".0") {
        text.truncate(text.len() - 2);
    }
    text
}

/// The number that a reader finds after [`text`].
pub fn stored(x: f64) -> f64 {
    text(x).parse().unwrap_or(0.0)
}

/// Several numbers as MaterialX holds them.
pub fn list(numbers: &[f64]) -> String {
    numbers.iter().map(|x| text(*x)).collect::<Vec<_>>().join(", ")
}

/// One component of a value: `weights · channels of the source + bias`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// The source; none for a constant.
    pub source: Option<u32>,
    /// Weight of each of its channels.
    pub weights: [f64; 4],
    /// What is added.
    pub bias: f64,
}

impl Part {
    /// A constant.
    pub fn constant(x: f64) -> Self {
        Self { source: None, weights: [0.0; 4], bias: x }
    }

    /// A channel of a source as it is.
    pub fn channel(source: u32, channel: usize) -> Self {
        let mut weights = [0.0; 4];
        if let Some(weight) = weights.get_mut(channel) {
            *weight = 1.0;
        }
        Self { source: Some(source), weights, bias: 0.0 }
    }

    /// Its number, if it is a constant.
    pub fn as_constant(&self) -> Option<f64> {
        if self.source.is_none() { Some(self.bias) } else { None }
    }

    /// The part times a constant.
    pub fn times(&self, factor: f64) -> Option<Self> {
        Self { source: self.source, weights: self.weights.map(|w| w * factor), bias: self.bias * factor }.valid()
    }

    /// The sum of two parts; none if they follow different sources.
    pub fn plus(&self, other: &Self) -> Option<Self> {
        let source = match (self.source, other.source) {
            (Some(a), Some(b)) if a != b => return None,
            (a, b) => a.or(b),
        };
        let weights = std::array::from_fn(|k| self.weights[k] + other.weights[k]);
        Self { source, weights, bias: self.bias + other.bias }.valid()
    }

    /// The product; none if both follow a source.
    pub fn product(&self, other: &Self) -> Option<Self> {
        match (self.as_constant(), other.as_constant()) {
            (_, Some(factor)) => self.times(factor),
            (Some(factor), _) => other.times(factor),
            _ => None,
        }
    }

    /// The difference.
    pub fn minus(&self, other: &Self) -> Option<Self> {
        self.plus(&other.times(-1.0)?)
    }

    /// A part without a source where nothing of it is left; none where a number is not finite.
    fn valid(mut self) -> Option<Self> {
        if self.weights.iter().all(|w| *w == 0.0) {
            self.source = None;
        }
        (self.bias.is_finite() && self.weights.iter().all(|w| w.is_finite())).then_some(self)
    }
}

/// A value of one to four components.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parts {
    /// How many of the components count.
    pub count: usize,
    /// The components.
    pub parts: [Part; 4],
}

impl Parts {
    /// A value from its components, at least one and at most four.
    pub fn of(parts: &[Part]) -> Option<Self> {
        if parts.is_empty() || parts.len() > 4 {
            return None;
        }
        let mut all = [Part::constant(0.0); 4];
        all[..parts.len()].copy_from_slice(parts);
        Some(Self { count: parts.len(), parts: all })
    }

    /// A constant value.
    pub fn constants(numbers: &[f64]) -> Option<Self> {
        Self::of(&numbers.iter().map(|x| Part::constant(*x)).collect::<Vec<_>>())
    }

    /// The components.
    pub fn all(&self) -> &[Part] {
        &self.parts[..self.count.min(4)]
    }

    /// A component; that of a single number stands for all.
    pub fn at(&self, place: usize) -> Part {
        if self.count == 1 { self.parts[0] } else { self.parts.get(place).copied().unwrap_or(Part::constant(0.0)) }
    }

    /// Its numbers, if all are constants.
    pub fn as_constants(&self) -> Option<Vec<f64>> {
        self.all().iter().map(Part::as_constant).collect()
    }

    /// A value of this many components, each made from those of two others.
    pub fn zip(&self, other: &Self, count: usize, f: impl Fn(&Part, &Part) -> Option<Part>) -> Option<Self> {
        let parts: Option<Vec<Part>> = (0..count).map(|k| f(&self.at(k), &other.at(k))).collect();
        Self::of(&parts?)
    }
}

/// A function of constants as one of parts.
pub fn constant_only(f: impl Fn(f64, f64) -> f64) -> impl Fn(&Part, &Part) -> Option<Part> {
    move |a, b| {
        let x = f(a.as_constant()?, b.as_constant()?);
        x.is_finite().then(|| Part::constant(x))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_whole_and_finite() {
        assert_eq!(parse("0.1, 2,-3e2", 3), Some([0.1, 2.0, -300.0, 0.0]));
        assert_eq!(parse("0.1 2", 2), Some([0.1, 2.0, 0.0, 0.0]));
        for text in ["", "1, 2", "1, 2, 3, 4", "1, x, 3", "nan, 1, 1", "inf, 1, 1", "1e400, 1, 1"] {
            assert_eq!(parse(text, 3), None, "{text}");
        }
        assert_eq!(parse("1", 9), None);
    }

    #[test]
    fn numbers_are_written_in_single_precision() {
        for (x, written) in [(0.3, "0.3"), (1.0, "1"), (0.1 + 0.2, "0.3"), (1e-60, "0"), (-0.0, "-0"), (1.0 / 3.0, "0.33333334")]
        {
            assert_eq!(text(x), written);
        }
        assert_eq!(text(f64::NAN), "0");
        assert!(text(1e300).parse::<f64>().is_ok_and(|x| x.is_finite() && x > 3e38));
        assert_eq!(wide(0.1 + 0.2), "0.30000000000000004");
    }
}

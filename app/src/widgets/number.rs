//! Numbers as people type them: with arithmetic, fractions and units; and as they like to read them.

use burnish_material::Unit;

/// Reads what was typed into a field of this unit: `1/3`, `20/64`, `0.5*2`, `(1+2)/4`, `12 mm`, `45 deg`, `30%`, `1,5`.
///
/// Lengths with a unit are converted by `unit_mm`, millimetres per unit of the material. `None` if it is no finite number.
pub fn parse(text: &str, unit: Unit, unit_mm: f64) -> Option<f64> {
    let text = text.trim().replace('−', "-").to_lowercase();
    let text = text.strip_suffix("radiance").or_else(|| text.strip_suffix("units")).unwrap_or(&text).trim_end();
    // Multiplied by the one and divided by the other, in this order, so that 12 mm at 10 mm per unit is 1.2 to the last bit.
    let (body, times, per) = match unit {
        Unit::Length => with_suffix(text, &[("mm", 1.0), ("cm", 10.0), ("in", 25.4), ("m", 1000.0)], unit_mm),
        Unit::Turn => with_suffix(text, &[("turns", 360.0), ("turn", 360.0), ("deg", 1.0), ("°", 1.0)], 360.0),
        _ => (text, 1.0, 1.0),
    };
    let (body, per) = body.strip_suffix('%').map_or((body, per), |body| (body, 100.0 * per));
    // A comma is a decimal point where people write it so; no field takes a list.
    let body = body.replace(',', ".");
    let mut parser = Parser { rest: body.as_bytes(), depth: 0 };
    let value = parser.sum()? * times / per;
    parser.skip_spaces();
    (parser.rest.is_empty() && value.is_finite()).then_some(value)
}

/// Splits off a unit; the number times the second over the third is in units of `base`.
fn with_suffix<'a>(text: &'a str, units: &[(&str, f64)], base: f64) -> (&'a str, f64, f64) {
    for (suffix, size) in units {
        if let Some(body) = text.strip_suffix(suffix) {
            return (body.trim_end(), *size, base);
        }
    }
    (text, 1.0, 1.0)
}

struct Parser<'a> {
    rest: &'a [u8],
    depth: u32,
}

impl Parser<'_> {
    fn skip_spaces(&mut self) {
        while let [b' ' | b'\t', rest @ ..] = self.rest {
            self.rest = rest;
        }
    }

    fn take(&mut self, symbols: &[u8]) -> Option<u8> {
        self.skip_spaces();
        let [first, rest @ ..] = self.rest else { return None };
        symbols.contains(first).then(|| {
            self.rest = rest;
            *first
        })
    }

    fn sum(&mut self) -> Option<f64> {
        let mut value = self.product()?;
        while let Some(sign) = self.take(b"+-") {
            let next = self.product()?;
            value = if sign == b'+' { value + next } else { value - next };
        }
        Some(value)
    }

    fn product(&mut self) -> Option<f64> {
        let mut value = self.atom()?;
        while let Some(sign) = self.take(b"*/") {
            let next = self.atom()?;
            value = if sign == b'*' { value * next } else { value / next };
        }
        Some(value)
    }

    fn atom(&mut self) -> Option<f64> {
        // Typed text is short; the bound keeps a pasted file of brackets from using up the stack.
        self.depth += 1;
        if self.depth > 64 {
            return None;
        }
        let value = match self.take(b"(-+") {
            Some(b'(') => {
                let value = self.sum()?;
                self.take(b")")?;
                value
            }
            Some(b'-') => -self.atom()?,
            Some(_) => self.atom()?,
            None => self.number()?,
        };
        self.depth -= 1;
        Some(value)
    }

    fn number(&mut self) -> Option<f64> {
        self.skip_spaces();
        let mut length = 0;
        while let Some(&byte) = self.rest.get(length) {
            let is_exponent_sign = matches!(byte, b'+' | b'-') && length > 0 && self.rest[length - 1] == b'e';
            if !(byte.is_ascii_digit() || matches!(byte, b'.' | b'e') || is_exponent_sign) {
                break;
            }
            length += 1;
        }
        let (digits, rest) = self.rest.split_at(length);
        self.rest = rest;
        std::str::from_utf8(digits).ok()?.parse().ok()
    }
}

/// A number in at most `digits` significant digits, without trailing zeros.
pub fn format(x: f64, digits: usize) -> String {
    if x == 0.0 || !x.is_finite() {
        return if x == 0.0 { "0".into() } else { x.to_string() };
    }
    let exponent = x.abs().log10().floor() as i32;
    if !(-5..9).contains(&exponent) {
        return format!("{x:.*e}", digits.saturating_sub(1));
    }
    let decimals = usize::try_from((digits as i32 - 1 - exponent).max(0)).unwrap_or(0);
    let text = format!("{x:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A property's number for its field: at least two decimals where there is room, never hiding a digit that matters.
pub fn field(x: f64) -> String {
    let text = format(x, 4);
    if text.contains('e') {
        return text;
    }
    match text.split_once('.') {
        Some((_, decimals)) if decimals.len() >= 2 => text,
        Some(_) => text + "0",
        None if x.abs() < 100.0 => text + ".00",
        None => text,
    }
}

/// A colour's number for its narrow field: three decimals at most.
pub fn color_field(x: f64) -> String {
    if x.abs() >= 100.0 || !x.is_finite() {
        return format(x, 3);
    }
    let text = format!("{x:.3}");
    text.strip_suffix('0').map_or(text.clone(), str::to_owned)
}

/// A colour's number where there is room for two decimals only.
pub fn narrow_color_field(x: f64) -> String {
    if x.abs() >= 10.0 || !x.is_finite() { format(x, 3) } else { format!("{x:.2}") }
}

/// `x` rounded to `digits` significant digits, so that a slider does not write digits nobody chose.
pub fn rounded(x: f64, digits: usize) -> f64 {
    format!("{x:.*e}", digits.saturating_sub(1)).parse().unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arithmetic_and_units() {
        let plain = |text| parse(text, Unit::None, 100.0);
        assert_eq!(plain("1/4"), Some(0.25));
        assert_eq!(plain("20/64"), Some(0.3125));
        assert_eq!(plain(" 0.5 * (1 + 2) - -1 "), Some(2.5));
        assert_eq!(plain("1,5"), Some(1.5));
        assert_eq!(plain("30%"), Some(0.3));
        assert_eq!(plain("1e-3"), Some(0.001));
        assert_eq!(plain("1e400"), None);
        assert_eq!(plain("1/0"), None);
        assert_eq!(plain("1 2"), None);
        assert_eq!(plain(""), None);
        assert_eq!(plain(&"(".repeat(10_000)), None);
        assert_eq!(parse("12 mm", Unit::Length, 10.0), Some(1.2));
        assert_eq!(parse("1m", Unit::Length, 10.0), Some(100.0));
        assert_eq!(parse("12 units", Unit::Length, 10.0), Some(12.0));
        assert_eq!(parse("90°", Unit::Turn, 10.0), Some(0.25));
        assert_eq!(parse("0.25 turn", Unit::Turn, 10.0), Some(0.25));
    }

    #[test]
    fn formats() {
        assert_eq!(field(0.3), "0.30");
        assert_eq!(field(1.0), "1.00");
        assert_eq!(field(0.773_3), "0.7733");
        assert_eq!(field(120.0), "120");
        assert_eq!(field(1e-7), "1.000e-7");
        assert_eq!(color_field(0.773_3), "0.773");
        assert_eq!(color_field(1.0), "1.00");
        assert_eq!(color_field(123.0), "123");
        assert_eq!(narrow_color_field(0.916), "0.92");
        assert_eq!(narrow_color_field(123.4), "123");
        assert_eq!(format(1200.0, 3), "1200");
        assert_eq!(rounded(0.123_456_7, 4), 0.1235);
    }
}

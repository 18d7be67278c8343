//! Numbers of single precision, which most attributes of USD hold.

/// What an attribute of single precision holds of a finite number: the double that the float's shortest decimals mean. Idempotent.
pub(super) fn single(x: f64) -> f64 {
    number(x).parse().unwrap_or(0.0)
}

/// The shortest decimals of a number in single precision. What is larger than a float holds is the largest; what is no number is 0.
pub(super) fn number(x: f64) -> String {
    let x = if x.is_nan() { 0.0 } else { x.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32 };
    shortest(format!("{x:?}"))
}

/// The shortest decimals of a finite double.
pub(super) fn double(x: f64) -> String {
    shortest(format!("{:?}", if x.is_finite() { x } else { 0.0 }))
}

/// Without a needless point; the one behind a negative zero keeps its sign in programs that read a whole number else.
fn shortest(text: String) -> String {
    match text.strip_suffix(".0") {
        Some(whole) if whole != "-0" => whole.to_owned(),
        _ => text,
    }
}

/// Numbers of single precision between brackets, as a vector; a single one stands alone.
pub(super) fn tuple(numbers: &[f64]) -> String {
    match numbers {
        [one] => number(*one),
        _ => format!("({})", numbers.iter().map(|x| number(*x)).collect::<Vec<_>>().join(", ")),
    }
}

/// A text in quotes.
pub(super) fn quoted(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + 2);
    out.push('"');
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            '\n' => out += "\\n",
            '\r' => out += "\\r",
            '\t' => out += "\\t",
            c if c < ' ' => out.push(' '),
            c => out.push(c),
        }
    }
    out + "\""
}

/// A list of texts in quotes.
pub(super) fn quoted_list(texts: impl IntoIterator<Item = String>) -> String {
    format!("[{}]", texts.into_iter().map(|text| quoted(&text)).collect::<Vec<_>>().join(", "))
}

/// The path of a file as usda can hold it.
pub(super) fn file_path(path: &str) -> String {
    let path: String = path.chars().filter(|c| !c.is_control()).collect();
    path.replace("@@@", "@")
}

/// The path of a file, as [`file_path`] makes it, between its marks.
pub(super) fn asset(path: &str) -> String {
    let is_plain = path.starts_with('.') || path.starts_with('/') || path.contains(':');
    // Without `./` a path is looked for in search folders first.
    let anchor = if is_plain || path.is_empty() { "" } else { "./" };
    if path.contains('@') { format!("@@@{anchor}{path}@@@") } else { format!("@{anchor}{path}@") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_precision_keeps_short_decimals_and_bounds() {
        for (x, text) in [
            (0.3, "0.3"),
            (1.0, "1"),
            (-0.0, "-0.0"),
            (0.1 + 0.2, "0.3"),
            (1e300, "3.4028235e38"),
            (f64::NAN, "0"),
            (1e-7, "1e-7"),
        ] {
            assert_eq!(number(x), text);
            assert_eq!(single(single(x)).to_bits(), single(x).to_bits());
        }
        assert_eq!((double(0.1 + 0.2).as_str(), double(2.0).as_str()), ("0.30000000000000004", "2"));
    }
}

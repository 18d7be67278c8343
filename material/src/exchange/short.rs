//! Texts of a file as messages show them.

/// A text on one line, and not too long.
pub(crate) fn short(text: &str) -> String {
    const LENGTH: usize = 100;
    let mut line: String = text.chars().take(LENGTH).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if text.chars().nth(LENGTH).is_some() {
        line.push('…');
    }
    line
}

//! Conditions of which a part is known: `true` and `false` disappear from them, and from what chooses by them.

use super::tree::words;

/// The text with every word replaced that `value_of` knows. Members (`.name`) are no words of their own.
pub(super) fn replaced(text: &str, value_of: impl Fn(&str) -> Option<String>) -> String {
    let mut out = String::new();
    let mut done = 0;
    for (at, word) in words(text) {
        if text[..at].ends_with('.') {
            continue;
        }
        if let Some(value) = value_of(word) {
            out.push_str(&text[done..at]);
            out.push_str(&value);
            done = at + word.len();
        }
    }
    out + &text[done..]
}

/// Whether the text says `true` or `false` anywhere.
pub(super) fn is_known(text: &str) -> bool {
    words(text).any(|(_, word)| word == "true" || word == "false")
}

/// The condition without what is known in it; itself where nothing is.
pub(super) fn simplified(condition: &str) -> String {
    let condition = condition.trim();
    if !is_known(condition) {
        return condition.to_owned();
    }
    for (operator, decides) in [("||", "true"), ("&&", "false")] {
        let parts = split(condition, operator);
        if parts.len() > 1 {
            let parts: Vec<String> = parts.into_iter().map(simplified).collect();
            if parts.iter().any(|part| part == decides) {
                return decides.to_owned();
            }
            let open: Vec<String> = parts.into_iter().filter(|part| part != "true" && part != "false").collect();
            if open.is_empty() {
                return if decides == "true" { "false" } else { "true" }.to_owned();
            }
            return open.join(&format!(" {operator} "));
        }
    }
    if let Some(rest) = condition.strip_prefix('!') {
        return match simplified(rest).as_str() {
            "true" => "false".to_owned(),
            "false" => "true".to_owned(),
            rest => format!("!{rest}"),
        };
    }
    match condition.strip_prefix('(').and_then(|rest| rest.strip_suffix(')')) {
        Some(inside) if split(condition, ")").len() <= 1 => {
            let inside = simplified(inside);
            if inside.contains(' ') { format!("({inside})") } else { inside }
        }
        _ => condition.to_owned(),
    }
}

/// The parts of a text between the places where `separator` stands outside of brackets.
fn split<'a>(text: &'a str, separator: &str) -> Vec<&'a str> {
    let (mut parts, mut depth, mut start) = (Vec::new(), 0i32, 0);
    for (at, c) in text.char_indices() {
        match c {
            '(' | '[' => depth += 1,
            ')' | ']' => depth -= 1,
            _ => {}
        }
        if depth == 0 && at >= start && text[at..].starts_with(separator) && at + separator.len() < text.len() {
            parts.push(&text[start..at]);
            start = at + separator.len();
        }
    }
    parts.push(&text[start..]);
    parts
}

/// The text with every `select(a, b, true)` as `b` and every `select(a, b, false)` as `a`.
pub(super) fn selected(text: &str) -> String {
    const CALL: &str = "select(";
    let mut from = 0;
    while let Some(at) = text[from..].find(CALL).map(|at| from + at) {
        let inside_at = at + CALL.len();
        let mut depth = 1i32;
        let end = text[inside_at..].find(|c| {
            depth += i32::from(c == '(') - i32::from(c == ')');
            depth == 0
        });
        let Some(end) = end.map(|end| inside_at + end) else { break };
        if let [no, yes, condition] = split(&text[inside_at..end], ",").as_slice() {
            let chosen = match simplified(condition).as_str() {
                "true" => yes.trim(),
                "false" => no.trim(),
                _ => {
                    from = inside_at;
                    continue;
                }
            };
            let is_whole = split(chosen, " ").len() == 1;
            let chosen = if is_whole { chosen.to_owned() } else { format!("({chosen})") };
            return selected(&format!("{}{chosen}{}", &text[..at], &text[end + 1..]));
        }
        from = inside_at;
    }
    text.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_known_disappears() {
        for (given, expected) in [
            ("true", "true"),
            ("!true", "false"),
            ("!false && a > b", "a > b"),
            ("true || (a && b)", "true"),
            ("false || (true && false)", "false"),
            ("false || (true && a)", "a"),
            ("(a || false) && (b || c || false)", "a && (b || c)"),
            ("(a && true) || (b && c)", "a || (b && c)"),
            ("f(a, true) && b", "f(a, true) && b"),
        ] {
            assert_eq!(simplified(given), expected, "{given}");
        }
    }

    #[test]
    fn choices_by_what_is_known_are_made() {
        assert_eq!(selected("let x = select(0.0, saturate(a), true);"), "let x = saturate(a);");
        assert_eq!(selected("select(select(1.0, 2.0, x), f(a, b), false) * 2.0"), "select(1.0, 2.0, x) * 2.0");
        assert_eq!(selected("y * select(a + b, 0.0, false)"), "y * (a + b)");
        assert_eq!(selected("select(a, select(b, c, true), d)"), "select(a, c, d)");
    }
}

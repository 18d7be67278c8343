//! The licences of a pack as one text, from what the materials say of themselves.

use super::super::sheet::slashed;
use super::MATERIALS;
use super::content::Packed;
use burnish_material::PROPERTIES;
use std::collections::BTreeMap;

/// Materials by licence, those without one first; each with where its values come from.
pub(super) fn text(name: &str, materials: &[Packed<'_>]) -> String {
    // An empty licence comes before all others.
    let mut by_licence: BTreeMap<String, Vec<&Packed<'_>>> = BTreeMap::new();
    for one in materials {
        by_licence.entry(one_line(&one.file.material().provenance.licence)).or_default().push(one);
    }
    let mut text = format!(
        "# Licences of {}\n\nWhat each material says of itself under `provenance` and `sources`: the licence of the data that its values come from. \
         Generated; correct it in the material files.\n",
        escape(name)
    );
    for (licence, materials) in &by_licence {
        let title = if licence.is_empty() { "No licence stated".to_owned() } else { escape(licence) };
        text += &format!("\n## {title} ({})\n\n", materials.len());
        if licence.is_empty() {
            text += "Nobody may use these without asking their author.\n\n";
        }
        materials.iter().for_each(|one| text += &item(one, licence));
    }
    text
}

fn item(one: &Packed<'_>, licence: &str) -> String {
    let provenance = &one.file.material().provenance;
    let path = format!("{MATERIALS}/{}", slashed(&one.entry.path));
    let origin: Vec<String> =
        [&provenance.source, &provenance.reference].iter().map(|text| escape(text)).filter(|text| !text.is_empty()).collect();
    let origin = if origin.is_empty() { "source not stated".to_owned() } else { origin.join(". ") };
    let mut text = format!("- **{}** ({}): {origin}\n", escape(&one.entry.name), code(&path));
    for ((dataset, terms), keys) in other_terms(one, licence) {
        let dataset = if dataset.is_empty() { String::new() } else { format!(", {}", escape(&dataset)) };
        text +=
            &format!("  - {}: {}{dataset}\n", keys.iter().map(|key| code(key)).collect::<Vec<_>>().join(", "), escape(&terms));
    }
    if !one.images.is_empty() {
        let images: Vec<String> = one.images.iter().map(|image| code(&format!("{MATERIALS}/{image}"))).collect();
        text += &format!("  - images: {}\n", images.join(", "));
    }
    text
}

/// Dataset and licence of single values that have one of their own, with the properties.
fn other_terms<'a>(one: &'a Packed<'_>, licence: &str) -> BTreeMap<(String, String), Vec<&'a str>> {
    let mut terms: BTreeMap<(String, String), Vec<&str>> = BTreeMap::new();
    for def in PROPERTIES {
        let Some(source) = one.file.source_of(def.id) else { continue };
        let own = one_line(&source.licence);
        if !own.is_empty() && own != licence {
            terms.entry((one_line(&source.dataset), own)).or_default().push(def.name);
        }
    }
    terms
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A text in one line that Markdown shows as it is. Addresses stay as they are.
fn escape(text: &str) -> String {
    let mut escaped = String::new();
    for word in text.split_whitespace() {
        if !escaped.is_empty() {
            escaped.push(' ');
        }
        if word.starts_with("https://") && !word.contains(['<', '>', '`', '[', ']', '|']) {
            escaped.push_str(word);
            continue;
        }
        for c in word.chars() {
            if matches!(c, '\\' | '`' | '*' | '_' | '[' | ']' | '<' | '>' | '|' | '#' | '~' | '&') {
                escaped.push('\\');
            }
            escaped.push(c);
        }
    }
    escaped
}

/// A text in the type of code, whatever is in it.
fn code(text: &str) -> String {
    let fence = "`".repeat(1 + text.split(|c| c != '`').map(str::len).max().unwrap_or_default());
    let space = if text.starts_with('`') || text.ends_with('`') { " " } else { "" };
    format!("{fence}{space}{}{space}{fence}", one_line(text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_stay_what_they_are() {
        assert_eq!(escape(" a*b_c\n<d> [e](f) https://x.org/a_b "), r"a\*b\_c \<d\> \[e\](f) https://x.org/a_b");
        assert_eq!((code("a"), code("a`b``c"), code("`")), ("`a`".into(), "```a`b``c```".into(), "`` ` ``".into()));
    }
}

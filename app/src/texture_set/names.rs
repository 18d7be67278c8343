//! What the words of a file name say about a picture: names of maps, resolutions, tiles and the like.

use burnish_material::{Channel, PROPERTIES, Property, Vary};

/// A name of a map has at most this many words: `Occlusion_Roughness_Metallic_Map`.
const MAX_WORDS: usize = 5;

/// A property that is read from some channels, and whether inverted.
pub(super) type Use = (Property, Channel, bool);

const fn all(property: Property) -> Use {
    (property, Channel::Rgb, false)
}

const fn inverted(property: Property) -> Use {
    (property, Channel::Rgb, true)
}

/// Names of maps beside those of the property table. Of two names for one property in a set, the earlier one here is taken.
#[rustfmt::skip]
pub(super) const NAMES: &[(&str, &[Use])] = &[
    ("basecolour albedo diffuse diff color colour col diffusecolor", &[all(Property::base_color)]),
    ("rough rgh", &[all(Property::roughness)]),
    ("glossiness gloss smoothness", &[inverted(Property::roughness)]),
    ("metalness metal", &[all(Property::metallic)]),
    ("normalgl normalopengl normalogl norgl nrmgl", &[all(Property::normal)]),
    ("nor nrm norm", &[all(Property::normal)]),
    ("normaldx normaldirectx nordx nrmdx", &[inverted(Property::normal)]),
    ("displacement disp displace bump", &[all(Property::height)]),
    ("ao occlusion occ mixedao", &[all(Property::ambient_occlusion)]),
    ("alpha cutout alphamask opacitymask", &[all(Property::opacity)]),
    ("transparency", &[inverted(Property::opacity)]),
    ("emission emissivecolor emit", &[all(Property::emission_color)]),
    ("transmission", &[all(Property::translucency)]),
    ("thickness", &[all(Property::volume_thickness)]),
    ("clearcoat", &[all(Property::coat)]),
    ("clearcoatroughness", &[all(Property::coat_roughness)]),
    ("coatglossiness coatgloss clearcoatglossiness", &[inverted(Property::coat_roughness)]),
    ("clearcoatnormal coatnormalgl coatnormalopengl", &[all(Property::coat_normal)]),
    ("coatnormaldx coatnormaldirectx", &[inverted(Property::coat_normal)]),
    ("orm arm aorm occlusionroughnessmetallic occlusionroughnessmetalness aoroughnessmetallic", &[
        (Property::ambient_occlusion, Channel::R, false),
        (Property::roughness, Channel::G, false),
        (Property::metallic, Channel::B, false),
    ]),
    ("ord occlusionroughnessdisplacement", &[
        (Property::ambient_occlusion, Channel::R, false),
        (Property::roughness, Channel::G, false),
        (Property::height, Channel::B, false),
    ]),
    ("rma roughnessmetallicao roughnessmetallicambientocclusion", &[
        (Property::roughness, Channel::R, false),
        (Property::metallic, Channel::G, false),
        (Property::ambient_occlusion, Channel::B, false),
    ]),
    ("metallicroughness metalroughness", &[(Property::roughness, Channel::G, false), (Property::metallic, Channel::B, false)]),
    ("metallicsmoothness", &[(Property::metallic, Channel::R, false), (Property::roughness, Channel::A, true)]),
    ("maskmap", &[
        (Property::metallic, Channel::R, false),
        (Property::ambient_occlusion, Channel::G, false),
        (Property::roughness, Channel::A, true),
    ]),
];

/// Names of maps that the model has no place for, and why.
const WITHOUT_PLACE: &[(&str, &str)] = &[
    ("specular spec reflection refl", "holds reflectances of the specular workflow; expected a metallic map or a specular level"),
    ("cavity curvature", "describes the shape, not the substance; no property reads it"),
    ("id materialid position worldspacenormal", "is a helper of painting programs; no property reads it"),
    ("preview render sphere thumbnail thumb", "shows the material; no property reads it"),
];

/// Words that stand after the name of a map and say nothing about it, beside numbers.
const SUFFIXES: &[&str] = &[
    "jpg", "jpeg", "png", "exr", "hdr", "tif", "tiff", "srgb", "raw", "linear", "lin", "acescg", "utility", "texture", "tex",
    "map",
];

/// Words that Poliigon puts last to name the workflow of a set, after the resolution.
const WORKFLOWS: &[&str] = &["metalness", "specular"];

/// The table rows that a name stands for.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Meaning {
    /// Properties, and the place of the name among others with the same use.
    Uses(Vec<Use>, usize),
    WithoutPlace(&'static str),
}

/// The words of a name in lower case: parts between separators, divided before capitals as in `BaseColor` and `AOMap`, but not `sRGB` or `2K`.
pub(super) fn words_of(name: &str) -> Vec<String> {
    let mut words = Vec::new();
    for part in name.split(|c: char| !c.is_alphanumeric()) {
        let letters: Vec<char> = part.chars().collect();
        let mut start = 0;
        for i in 1..letters.len() {
            let is_before_lower = letters.get(i + 1).is_some_and(|c| c.is_lowercase());
            let is_border = if letters[i - 1].is_lowercase() { i - start >= 2 } else { is_before_lower };
            if letters[i].is_uppercase() && is_border {
                words.push(letters[start..i].iter().collect::<String>().to_lowercase());
                start = i;
            }
        }
        words.push(letters[start..].iter().collect::<String>().to_lowercase());
    }
    words.retain(|word| !word.is_empty());
    words
}

/// What the last words of a name say about a picture.
pub(super) fn meaning_of(words: &[String]) -> Option<Meaning> {
    meaning_at(words).map(|(_, meaning)| meaning)
}

/// What stands before the name of the map: the name of the set, without resolutions and formats at its end. `None` where no map is named.
pub(super) fn set_name(stem: &str, words: &[String]) -> Option<String> {
    let (mut count, _) = meaning_at(words)?;
    let says_nothing = |word: &String| SUFFIXES.contains(&word.as_str()) || resolution_of(std::slice::from_ref(word)) > 0;
    while words[..count].last().is_some_and(says_nothing) {
        count -= 1;
    }
    let letters = words[..count].iter().map(|word| word.chars().count()).sum();
    let mut ends = stem.char_indices().filter(|(_, c)| c.is_alphanumeric()).map(|(at, c)| at + c.len_utf8());
    let end = ends.nth(usize::checked_sub(letters, 1).unwrap_or(usize::MAX)).unwrap_or(0);
    Some(stem[..end].to_owned())
}

/// The number of words before the name of a map, and what it says.
fn meaning_at(words: &[String]) -> Option<(usize, Meaning)> {
    if let [before @ .., resolution, workflow] = words
        && WORKFLOWS.contains(&workflow.as_str())
        && resolution_of(std::slice::from_ref(resolution)) > 0
        && let Some(found) = meaning_at(before)
    {
        return Some(found);
    }
    let mut end = words.len();
    loop {
        // The longest name counts: a coat's roughness is no roughness.
        let mut starts = end.saturating_sub(MAX_WORDS)..end;
        let found = starts.find_map(|start| Some((start, named(&words[start..end].concat())?)));
        if found.is_some() || !words[..end].last().is_some_and(|word| is_suffix(word)) {
            return found;
        }
        end -= 1;
    }
}

/// What a name without separators stands for.
pub(super) fn named(name: &str) -> Option<Meaning> {
    let place = |names: &str| names.split(' ').position(|n| n == name);
    let plain = |text: &str| text.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect::<String>();
    let mut images = PROPERTIES.iter().filter(|def| def.vary != Vary::Uniform);
    if let Some(def) = images.find(|def| [def.name, def.usage, def.label].iter().any(|own| plain(own) == name)) {
        return Some(Meaning::Uses(vec![all(def.id)], 0));
    }
    for (row, (names, uses)) in NAMES.iter().enumerate() {
        if let Some(column) = place(names) {
            // Names of the property table come first.
            return Some(Meaning::Uses(uses.to_vec(), 1 + row * 100 + column));
        }
    }
    if let Some((_, why)) = WITHOUT_PLACE.iter().find(|(names, _)| place(names).is_some()) {
        return Some(Meaning::WithoutPlace(why));
    }
    let shorter = ["map", "16", "32"].iter().find_map(|end| name.strip_suffix(end))?;
    named(shorter)
}

/// Whether a word at the end of a name only tells a resolution, a tile, a version, a number or a format.
fn is_suffix(word: &str) -> bool {
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    let after = |prefix: &str| word.strip_prefix(prefix).is_some_and(is_number);
    let is_tile = || word.strip_prefix('u').and_then(|t| t.split_once('v')).is_some_and(|(u, v)| is_number(u) && is_number(v));
    is_number(word)
        || SUFFIXES.contains(&word)
        || resolution_of(&[word.to_owned()]) > 0
        || ["u", "v", "var", "lod"].into_iter().any(after)
        || ["bit", "b"].iter().any(|end| word.strip_suffix(end).is_some_and(is_number))
        || is_tile()
}

/// The largest resolution that a word tells: `2k`, `2048`, `2048x2048`; 0 if none does.
pub(super) fn resolution_of(words: &[String]) -> u32 {
    let pixels = |text: &str| text.parse::<u32>().ok().filter(|n| n.is_power_of_two() && (64..=65536).contains(n));
    let of = |word: &String| {
        let thousands = word.strip_suffix('k').and_then(|n| n.parse::<u32>().ok()).filter(|n| (1..=64).contains(n));
        let sides = word.split_once('x').and_then(|(a, b)| Some(pixels(a)?.max(pixels(b)?)));
        thousands.map(|n| n * 1024).or(sides).or_else(|| pixels(word))
    };
    words.iter().filter_map(of).max().unwrap_or(0)
}

/// The bits per channel that a name tells: `NRM16`, `16bit`; 0 if it does not.
pub(super) fn bits_of(words: &[String]) -> u32 {
    let of = |word: &String| {
        let name = word.trim_end_matches("bit");
        let digits = name.trim_start_matches(|c: char| !c.is_ascii_digit());
        let is_told = name.len() < word.len() || digits.len() < name.len() && named(&name[..name.len() - digits.len()]).is_some();
        digits.parse::<u32>().ok().filter(|bits| is_told && [8, 16, 32].contains(bits))
    };
    words.iter().filter_map(of).max().unwrap_or(0)
}

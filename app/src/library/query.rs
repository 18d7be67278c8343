//! Searching a library: `metal rough<0.3 tag:measured group:metals -glass "two words" is:stale`.
//!
//! All terms must hold; `-` before one turns it over. A word is looked for at the beginning of words in name, other names, tags, group, notes and names of lobes
//! in use, in any case. `PROPERTY<NUMBER`, also with `<=`, `>`, `>=` and `=`, compares a value by any clear beginning of the property's three
//! names; of colours the luminance, of switches 0 or 1. What a texture replaces has no value.

use super::entry::Entry;
use super::shelf::State;
use burnish_material::{LOBES, Lobe, PROPERTIES, Property, Value};

/// What is asked of entries.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Query {
    terms: Vec<Term>,
    problem: Option<String>,
}

/// What is known of an entry besides itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Facts {
    /// Whether its small picture shows it as it is.
    pub state: State,
    /// Whether it is among the favourites.
    pub is_favourite: bool,
}

#[derive(Clone, Debug, PartialEq)]
struct Term {
    is_turned_over: bool,
    what: What,
}

#[derive(Clone, Debug, PartialEq)]
enum What {
    Word(String),
    Name(String),
    Tag(String),
    Group(String),
    Licence(String),
    Notes(String),
    Compare(Property, Relation, f32),
    Texture(Option<Property>),
    Lobe(Lobe),
    HasNotes,
    HasTags,
    HasLicence,
    Favourite,
    Broken,
    Picture(State),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Relation {
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
    Equal,
}

/// Relations by how they are written; the longer ones first.
const RELATIONS: [(&str, Relation); 5] = [
    ("<=", Relation::LessOrEqual),
    (">=", Relation::GreaterOrEqual),
    ("<", Relation::Less),
    (">", Relation::Greater),
    ("=", Relation::Equal),
];

impl Query {
    /// Reads a query. Terms that cannot be understood are left out, see [`Query::problem`].
    pub fn parse(text: &str) -> Self {
        let mut query = Self::default();
        for word in words(text) {
            let is_turned_over = word.text.starts_with('-') && !word.is_quoted;
            let rest = if is_turned_over { &word.text[1..] } else { &word.text };
            if rest.is_empty() {
                continue;
            }
            match if word.is_quoted { Ok(What::Word(rest.to_lowercase())) } else { what(rest) } {
                Ok(what) => query.terms.push(Term { is_turned_over, what }),
                Err(problem) => query.problem = query.problem.or(Some(problem)),
            }
        }
        query
    }

    /// What is wrong with the first term that could not be understood, as one sentence.
    pub fn problem(&self) -> Option<&str> {
        self.problem.as_deref()
    }

    /// Whether everything matches.
    pub fn is_empty(&self) -> bool {
        self.terms.is_empty()
    }

    /// Whether an entry matches; `facts` is only asked where that matters.
    pub fn matches(&self, entry: &Entry, facts: impl Fn() -> Facts) -> bool {
        self.terms.iter().all(|term| term.what.holds(entry, &facts) != term.is_turned_over)
    }
}

impl What {
    fn holds(&self, entry: &Entry, facts: &impl Fn() -> Facts) -> bool {
        let has_lobe = |lobe| entry.lobes().has(lobe);
        match self {
            Self::Word(word) => has_word(&entry.words, word),
            Self::Name(word) => entry.aliases.iter().chain([&entry.name]).any(|name| has_word(&name.to_lowercase(), word)),
            Self::Tag(word) => entry.tags.iter().any(|tag| tag.to_lowercase().starts_with(word)),
            Self::Group(word) => has_word(&entry.group().to_lowercase(), word),
            Self::Licence(word) => has_word(&entry.licence.to_lowercase(), word),
            Self::Notes(word) => has_word(&entry.notes.to_lowercase(), word),
            Self::Compare(property, relation, number) => {
                entry.value(*property).is_some_and(|value| relation.holds(value, *number))
            }
            Self::Texture(None) => !entry.textures.is_empty(),
            Self::Texture(Some(property)) => entry.is_textured(*property),
            Self::Lobe(lobe) => has_lobe(*lobe),
            Self::HasNotes => !entry.notes.is_empty(),
            Self::HasTags => !entry.tags.is_empty(),
            Self::HasLicence => !entry.licence.is_empty(),
            Self::Favourite => facts().is_favourite,
            Self::Broken => entry.problem.is_some(),
            Self::Picture(state) => facts().state == *state,
        }
    }
}

impl Relation {
    fn holds(self, a: f32, b: f32) -> bool {
        match self {
            Self::Less => a < b,
            Self::LessOrEqual => a <= b,
            Self::Greater => a > b,
            Self::GreaterOrEqual => a >= b,
            // A luminance is the sum of three rounded numbers.
            Self::Equal => (a - b).abs() <= 1e-6 * b.abs().max(1.0),
        }
    }
}

/// Whether `word` stands in `text` where no letter or digit is before it.
fn has_word(text: &str, word: &str) -> bool {
    let starts = |at: usize| !text[..at].chars().next_back().is_some_and(char::is_alphanumeric);
    text.match_indices(word).any(|(at, _)| starts(at))
}

/// A part of a query between spaces.
struct Word {
    text: String,
    /// Whether the quotes hold all of it.
    is_quoted: bool,
}

/// Splits at spaces outside quotes and beside relations, and takes the quotes away. A quote that does not end goes on to the end of the text.
fn words(text: &str) -> Vec<Word> {
    const SIGNS: [char; 3] = ['<', '>', '='];
    let mut words = Vec::new();
    let (mut word, mut is_inside, mut was_quoted) = (String::new(), false, false);
    for (at, c) in text.char_indices() {
        match c {
            '"' => {
                was_quoted |= !is_inside && word.is_empty();
                is_inside = !is_inside;
            }
            c if c.is_whitespace() && !is_inside => {
                if word.ends_with(SIGNS) || text[at..].trim_start().starts_with(SIGNS) {
                    continue;
                }
                words.push(Word { text: std::mem::take(&mut word), is_quoted: std::mem::take(&mut was_quoted) });
            }
            c => word.push(c),
        }
    }
    words.push(Word { text: word, is_quoted: was_quoted });
    words.retain(|word| !word.text.is_empty());
    words
}

fn what(text: &str) -> Result<What, String> {
    let relation = RELATIONS.iter().filter_map(|(sign, relation)| Some((text.find(sign)?, sign.len(), *relation)));
    let colon = text.find(':');
    match relation.min_by_key(|(at, length, _)| (*at, usize::MAX - length)) {
        Some((at, length, relation)) if colon.is_none_or(|colon| at < colon) => {
            let property = property(&text[..at], false)?;
            let number = number(&text[at + length..]).ok_or_else(|| {
                let name = property.def().name;
                format!("`{text}`: expected a number after {name}, such as {name}<0.3, found `{}`", &text[at + length..])
            })?;
            Ok(What::Compare(property, relation, number))
        }
        _ => match text.split_once(':') {
            Some((key, word)) => keyed(&key.to_lowercase(), &word.to_lowercase()),
            None => Ok(What::Word(text.to_lowercase())),
        },
    }
}

fn keyed(key: &str, word: &str) -> Result<What, String> {
    let word_of = |make: fn(String) -> What| {
        if word.is_empty() {
            Err(format!("`{key}:`: expected a word after it, such as {key}:metal"))
        } else {
            Ok(make(word.to_owned()))
        }
    };
    match key {
        "name" => word_of(What::Name),
        "tag" => word_of(What::Tag),
        "group" => word_of(What::Group),
        "licence" | "license" => word_of(What::Licence),
        "note" | "notes" => word_of(What::Notes),
        "fav" | "favourite" | "favorite" if word.is_empty() => Ok(What::Favourite),
        "has" => match word {
            "texture" | "textures" => Ok(What::Texture(None)),
            "notes" => Ok(What::HasNotes),
            "tags" => Ok(What::HasTags),
            "licence" | "license" => Ok(What::HasLicence),
            _ => LOBES.iter().find(|def| def.name == word).map(|def| What::Lobe(def.lobe)).ok_or_else(|| {
                let lobes: Vec<_> = LOBES.iter().map(|def| def.name).collect();
                format!("`has:{word}`: expected texture, notes, tags, licence or a lobe ({})", lobes.join(", "))
            }),
        },
        "is" => match word {
            "favourite" | "favorite" | "fav" => Ok(What::Favourite),
            "broken" => Ok(What::Broken),
            _ => State::from_word(word)
                .map(What::Picture)
                .ok_or_else(|| format!("`is:{word}`: expected fresh, draft, stale, missing, favourite or broken")),
        },
        "texture" => Ok(What::Texture(Some(property(word, true)?))),
        _ => Err(format!(
            "`{key}:` means nothing; expected name, tag, group, licence, notes, has, is, texture or fav before the colon"
        )),
    }
}

/// The property of which `text` is a name or a clear beginning of one; case, spaces, `_` and `-` do not matter.
fn property(text: &str, takes_directions: bool) -> Result<Property, String> {
    let plain = |text: &str| text.to_lowercase().replace(['_', ' ', '-'], "");
    let word = plain(text);
    let names = |property: Property| {
        let def = property.def();
        [def.name, def.usage, def.label].map(plain)
    };
    let is_refused = |property: Property| !takes_directions && matches!(property.def().default, Value::Normal(_));
    let is_exact = |property: &Property| names(*property).contains(&word);
    let begins = |property: &Property| !word.is_empty() && names(*property).iter().any(|name| name.starts_with(&word));
    let all = || PROPERTIES.iter().map(|def| def.id);
    let found: Vec<Property> = all().filter(|property| begins(property) && !is_refused(*property)).collect();
    match (all().find(is_exact), found.as_slice()) {
        (Some(exact), _) if is_refused(exact) => Err(format!("`{text}`: {} is a direction, which has no size", exact.def().name)),
        (Some(exact), _) => Ok(exact),
        (None, [one]) => Ok(*one),
        (None, []) => Err(format!("`{text}` is the beginning of no property; expected one such as rough or base_color")),
        (None, several) => {
            let names: Vec<_> = several.iter().map(|id| id.def().name).collect();
            Err(format!("`{text}` may be {}; expected more letters", names.join(" or ")))
        }
    }
}

/// A finite number, a percentage, or a switch.
fn number(text: &str) -> Option<f32> {
    let text = text.trim();
    let number = match (text, text.strip_suffix('%')) {
        ("true" | "on" | "yes", _) => 1.0,
        ("false" | "off" | "no", _) => 0.0,
        (_, Some(percent)) => percent.trim().parse::<f32>().ok()? / 100.0,
        _ => text.parse().ok()?,
    };
    Some(number).filter(|x: &f32| x.is_finite())
}

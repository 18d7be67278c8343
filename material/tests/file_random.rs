//! The lossless file on random documents: any layout, any numbers, any edits.

use burnish_material::{
    Channel, ColorSpace, Kind, Material, MaterialFile, PROPERTIES, PROPERTY_COUNT, Property, TextureRef, Value, Wrap,
};
use proptest::prelude::*;
use proptest::sample::select;
use std::collections::BTreeMap;

/// Finite numbers of every size, as bits.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<u64>().prop_map(f64::from_bits).prop_filter("finite", |x| x.is_finite()),
        (-4_i32..40).prop_map(|x| f64::from(x) / 8.0),
        select(vec![0.0, -0.0, f64::MIN_POSITIVE, 5e-324, f64::MAX, 0.1 + 0.2]),
    ]
}

/// A spelling of some number, not always the shortest one, and some that are refused.
fn spelling() -> impl Strategy<Value = String> {
    prop_oneof![
        8 => number().prop_map(|x| format!("{x:?}")),
        4 => number().prop_map(|x| format!("{x:.17e}")),
        2 => (0_u32..100).prop_map(|x| x.to_string()),
        2 => select(vec!["1_0.5", ".5", "5.", "+0.25", "5e-1", "0.30000000000000004", "1.0000", "1E2"]).prop_map(str::to_owned),
        1 => select(vec!["NaN", "-inf", "1e400", "0x10", "\"x\"", "Odd(1)"]).prop_map(str::to_owned),
    ]
}

fn text() -> impl Strategy<Value = String> {
    prop_oneof![
        "[a-zA-Z ,{}()/*\\[\\]:]{0,12}",
        any::<String>(),
        select(vec!["// no comment", "/* */", "\"", "\\", "\r\n", "\u{feff}", "é\u{85}\u{2028}"]).prop_map(str::to_owned),
    ]
}

fn quoted(text: &str) -> String {
    ron::to_string(text).expect("every text has a spelling")
}

/// Blanks and comments that may stand between any two tokens.
fn trivia() -> impl Strategy<Value = String> {
    let piece = select(vec![
        " ",
        "\t",
        "\n",
        "\r\n",
        "\n    ",
        "\n\t",
        "/* c */",
        "/* \"a\": 1, } */",
        "/* a /* b */ \n c */",
        "// c, }\n",
        " // ü \"\r\n",
    ]);
    prop_oneof![
        3 => Just(String::new()),
        3 => Just(" ".to_owned()),
        3 => Just("\n    ".to_owned()),
        2 => proptest::collection::vec(piece, 0..4).prop_map(|pieces| pieces.concat()),
    ]
}

type Entry = (String, String);

/// A map of these entries with random trivia and perhaps a trailing comma.
fn map_text(entries: Vec<Entry>) -> impl Strategy<Value = String> {
    let count = entries.len() * 4 + 2;
    (proptest::collection::vec(trivia(), count), any::<bool>()).prop_map(move |(trivia, has_comma)| {
        let mut trivia = trivia.into_iter();
        let mut next = || trivia.next().unwrap_or_default();
        let mut text = format!("{{{}", next());
        for (index, (key, value)) in entries.iter().enumerate() {
            text += &format!("{}{}{}:{}{value}{}", "", quoted(key), next(), next(), next());
            if has_comma || index + 1 < entries.len() {
                text += &format!(",{}", next());
            }
        }
        text + "}"
    })
}

fn value_text(kind: Kind) -> BoxedStrategy<String> {
    let three = || (spelling(), spelling(), spelling(), trivia(), any::<bool>());
    match kind {
        Kind::Float => spelling().boxed(),
        Kind::Bool => select(vec!["true", "false", "1", "None"]).prop_map(str::to_owned).boxed(),
        Kind::Color | Kind::Normal => three()
            .prop_map(|(a, b, c, trivia, is_list)| {
                let (open, close) = if is_list { ('[', ']') } else { ('(', ')') };
                format!("{open}{trivia}{a},{b}{trivia},{trivia}{c}{close}")
            })
            .boxed(),
    }
}

fn texture_text() -> impl Strategy<Value = String> {
    let fields = (
        proptest::option::weighted(0.9, text().prop_map(|path| ("path".to_owned(), quoted(&path)))),
        proptest::option::of(select(vec!["\"r\"", "\"b\"", "\"x\"", "3"]).prop_map(|c| ("channel".to_owned(), c.to_owned()))),
        proptest::option::of((spelling(), spelling()).prop_map(|(u, v)| ("uv_scale".to_owned(), format!("({u}, {v})")))),
        proptest::option::of(spelling().prop_map(|x| ("uv_rotation".to_owned(), x))),
        proptest::option::of(Just(("mip".to_owned(), "Linear".to_owned()))),
        proptest::option::of(channels_text().prop_map(|text| ("scale".to_owned(), text))),
        proptest::option::of(channels_text().prop_map(|text| ("bias".to_owned(), text))),
    );
    fields.prop_flat_map(|(a, b, c, d, e, f, g)| map_text([a, e, f, b, g, c, d].into_iter().flatten().collect()))
}

/// One number, or three.
fn channels_text() -> BoxedStrategy<String> {
    prop_oneof![value_text(Kind::Float), value_text(Kind::Color)].boxed()
}

/// JSON texts.
fn json() -> impl Strategy<Value = String> {
    prop_oneof![
        select(vec!["null", "[]", "{\"a\": [1.0, true]}", " 3e2 ", "\"\\n\"", "{\n  \"b\": \"// }\"\n}"]).prop_map(str::to_owned),
        any::<String>().prop_map(|text| serde_json::json!({ "text": text }).to_string()),
    ]
}

const FORMATS: [&str; 3] = ["gltf", "", "a.b \"c\""];
const FOREIGN_KEYS: [&str; 4] = ["KHR_x", "k", "漆 //", "*/"];

/// Texts of other formats, and what is none.
fn foreign_text() -> BoxedStrategy<String> {
    let strange = || select(vec!["3", "[1]", "\"{\"", "\"NaN\"", "\"\"", "Some({})"]).prop_map(str::to_owned);
    let texts = (0..FOREIGN_KEYS.len()).map(|at| {
        let text = prop_oneof![4 => json().prop_map(|text| quoted(&text)), 1 => strange()];
        proptest::option::of(text.prop_map(move |text| (FOREIGN_KEYS[at].to_owned(), text)))
    });
    let texts = texts.collect::<Vec<_>>().prop_flat_map(|texts| map_text(texts.into_iter().flatten().collect()));
    let texts = prop_oneof![6 => texts, 1 => strange()].boxed();
    let formats = FORMATS.map(|format| proptest::option::of(texts.clone().prop_map(move |texts| (format.to_owned(), texts))));
    let formats = formats.prop_flat_map(|formats| map_text(formats.into_iter().flatten().collect()));
    prop_oneof![9 => formats, 1 => strange()].boxed()
}

fn property_text(kind: Kind) -> BoxedStrategy<String> {
    let object = (
        proptest::option::of(value_text(kind)),
        proptest::option::of(texture_text()),
        proptest::option::of(Just("Some([1, 2])".to_owned())),
    )
        .prop_flat_map(|(value, texture, other)| {
            let fields = [("value", value), ("other", other), ("texture", texture)];
            map_text(fields.into_iter().filter_map(|(key, text)| text.map(|text| (key.to_owned(), text))).collect())
        });
    prop_oneof![3 => value_text(kind), 1 => object].boxed()
}

fn properties_text() -> impl Strategy<Value = String> {
    let known = proptest::sample::subsequence((0..PROPERTY_COUNT).collect::<Vec<_>>(), 0..8).prop_shuffle();
    let known = known.prop_flat_map(|rows| {
        rows.into_iter()
            .map(|row| {
                let def = &PROPERTIES[row];
                property_text(def.default.kind()).prop_map(|value| (def.name.to_owned(), value))
            })
            .collect::<Vec<_>>()
    });
    let unknown = proptest::option::of(spelling().prop_map(|value| ("velvet".to_owned(), value)));
    (known, unknown, any::<prop::sample::Index>()).prop_flat_map(|(mut entries, unknown, at)| {
        let at = at.index(entries.len() + 1);
        entries.splice(at..at, unknown);
        map_text(entries)
    })
}

fn document() -> impl Strategy<Value = String> {
    let words = || proptest::option::of(text().prop_map(|text| quoted(&text)));
    let tags = proptest::option::of((proptest::collection::vec(text(), 0..4), trivia()).prop_map(|(tags, trivia)| {
        format!("[{trivia}{}{trivia}]", tags.iter().map(|tag| quoted(tag)).collect::<Vec<_>>().join(&format!("{trivia},")))
    }));
    let provenance = proptest::option::of((words(), words()).prop_flat_map(|(source, licence)| {
        let fields = [("source", source), ("weather", Some("Fine".into())), ("licence", licence)];
        map_text(fields.into_iter().filter_map(|(key, text)| text.map(|text| (key.to_owned(), text))).collect())
    }));
    let fields = (
        (words(), words(), tags, provenance),
        (
            proptest::option::of(spelling()),
            proptest::option::weighted(0.9, properties_text()),
            proptest::option::of(foreign_text()),
            any::<bool>(),
        ),
        (trivia(), trivia(), any::<bool>()),
    );
    let fields = fields.prop_flat_map(|((name, notes, tags, provenance), (unit, properties, foreign, has_more), around)| {
        let fields = [
            ("asm", Some("\"4.0\"".into())),
            ("name", name),
            ("tags", tags),
            ("notes", notes),
            ("unit_mm", unit),
            ("provenance", provenance),
            ("foreign", foreign),
            ("properties", properties),
            ("more", has_more.then(|| "{\"x\": 'c', \"y\": b\"b\", \"z\": r#\"\"}\"#}".into())),
        ];
        let entries = fields.into_iter().filter_map(|(key, text)| text.map(|text: String| (key.to_owned(), text)));
        (map_text(entries.collect()), Just(around))
    });
    fields.prop_map(|(map, (before, after, has_bom))| format!("{}{before}{map}{after}", if has_bom { "\u{feff}" } else { "" }))
}

#[derive(Clone, Debug)]
enum Edit {
    Float(f64),
    Component(usize, f64),
    Switch(bool),
    Reset,
    NoValue,
    Texture(Option<TextureRef>),
    Rotate(f64),
    Repeat(usize, f64),
    Scale(usize, f64),
    Bias(f64),
}

fn texture() -> impl Strategy<Value = TextureRef> {
    let choices = (
        select(Channel::ALL.to_vec()),
        select(ColorSpace::ALL.to_vec()),
        select(Wrap::ALL.to_vec()),
        [number(), number()],
        number(),
        any::<bool>(),
        three(),
        three(),
    );
    (text(), choices).prop_map(|(path, (channel, color_space, wrap, uv_offset, uv_rotation, is_inverted, scale, bias))| {
        TextureRef {
            channel: channel.0,
            color_space: color_space.0,
            is_inverted,
            scale,
            bias,
            wrap: wrap.0,
            uv_offset,
            uv_rotation,
            ..TextureRef::new(path)
        }
    })
}

/// A number for each channel, or one for all.
fn three() -> impl Strategy<Value = [f64; 3]> {
    prop_oneof![number().prop_map(|x| [x; 3]), [number(), number(), number()]]
}

fn one_edit() -> impl Strategy<Value = Edit> {
    prop_oneof![
        4 => number().prop_map(Edit::Float),
        4 => (0..3_usize, number()).prop_map(|(at, x)| Edit::Component(at, x)),
        2 => any::<bool>().prop_map(Edit::Switch),
        4 => Just(Edit::Reset),
        1 => Just(Edit::NoValue),
        2 => proptest::option::of(texture()).prop_map(Edit::Texture),
        2 => number().prop_map(Edit::Rotate),
        2 => (0..2_usize, number()).prop_map(|(at, x)| Edit::Repeat(at, x)),
        2 => (0..3_usize, number()).prop_map(|(at, x)| Edit::Scale(at, x)),
        2 => number().prop_map(Edit::Bias),
    ]
}

fn apply(material: &mut Material, property: Property, edit: &Edit) {
    let mut value = material.value(property);
    let slot = material.slot_mut(property);
    match (edit, &mut value) {
        (Edit::Float(x), Value::Float(v)) => *v = *x,
        (Edit::Component(at, x), Value::Color(v) | Value::Normal(v)) => v[*at] = *x,
        (Edit::Switch(x), Value::Bool(v)) => *v = *x,
        (Edit::Reset, _) => return *slot = Default::default(),
        (Edit::NoValue, _) => return slot.value = None,
        (Edit::Texture(texture), _) => return slot.texture.clone_from(texture),
        (Edit::Rotate(x), _) => return slot.texture.iter_mut().for_each(|texture| texture.uv_rotation = *x),
        (Edit::Repeat(at, x), _) => return slot.texture.iter_mut().for_each(|texture| texture.uv_scale[*at] = *x),
        (Edit::Scale(at, x), _) => return slot.texture.iter_mut().for_each(|texture| texture.scale[*at] = *x),
        (Edit::Bias(x), _) => return slot.texture.iter_mut().for_each(|texture| texture.bias = [*x; 3]),
        _ => return,
    }
    slot.value = Some(value);
}

#[derive(Clone, Debug)]
enum TextEdit {
    Name(String),
    Notes(String),
    Tags(Vec<String>),
    NoTag(prop::sample::Index),
    Unit(Option<f64>),
    Source(String),
    Method(String),
    Foreign(usize, usize, Option<String>),
    NoForeign,
}

fn text_edit() -> impl Strategy<Value = TextEdit> {
    prop_oneof![
        text().prop_map(TextEdit::Name),
        text().prop_map(TextEdit::Notes),
        proptest::collection::vec(text(), 0..5).prop_map(TextEdit::Tags),
        any::<prop::sample::Index>().prop_map(TextEdit::NoTag),
        proptest::option::of(number()).prop_map(TextEdit::Unit),
        text().prop_map(TextEdit::Source),
        text().prop_map(TextEdit::Method),
        (0..FORMATS.len(), 0..FOREIGN_KEYS.len(), proptest::option::of(json()))
            .prop_map(|(f, k, text)| TextEdit::Foreign(f, k, text)),
        Just(TextEdit::NoForeign),
    ]
}

fn apply_text(material: &mut Material, edit: &TextEdit) {
    match edit {
        TextEdit::Name(text) => material.name.clone_from(text),
        TextEdit::Notes(text) => material.notes.clone_from(text),
        TextEdit::Tags(tags) => material.tags.clone_from(tags),
        TextEdit::NoTag(index) if !material.tags.is_empty() => _ = material.tags.remove(index.index(material.tags.len())),
        TextEdit::NoTag(_) => {}
        TextEdit::Unit(unit) => material.unit_mm = *unit,
        TextEdit::Source(text) => material.provenance.source.clone_from(text),
        TextEdit::Method(text) => material.provenance.method.clone_from(text),
        TextEdit::Foreign(format, key, text) => {
            material.set_foreign(FORMATS[*format], FOREIGN_KEYS[*key], text.clone()).expect("JSON is taken");
        }
        TextEdit::NoForeign => material.foreign.clear(),
    }
}

/// A material with numbers as bits, so that −0 and 0 differ in comparisons.
fn exact(material: &Material) -> String {
    let bits = |numbers: &[f64]| numbers.iter().map(|x| format!("{:x} ", x.to_bits())).collect::<String>();
    let slots: String = material
        .slots()
        .map(|(id, slot)| {
            let value = slot.value.map(|value| (value.kind(), bits(value.numbers()), value == Value::Bool(true)));
            let numbers = |t: &TextureRef| [&t.scale[..], &t.bias, &t.uv_scale, &t.uv_offset, &[t.uv_rotation]].concat();
            let placement = slot.texture.as_ref().map(|t| bits(&numbers(t)));
            format!("{id:?} {value:?} {placement:?} {:?}\n", slot.texture)
        })
        .collect();
    let unit = material.unit_mm.map(f64::to_bits);
    let Material { name, tags, notes, provenance, foreign, .. } = material;
    format!("{name:?} {tags:?} {notes:?} {unit:?} {provenance:?} {foreign:?}\n{slots}")
}

/// The pieces of text that are in both, in order, cover all of `new` but what an edit wrote: checked by removing from the
/// longer text what lies between the common beginning and the common end.
fn differing<'a>(old: &'a str, new: &'a str) -> (&'a str, &'a str) {
    let front =
        old.char_indices().zip(new.chars()).find(|((_, a), b)| a != b).map_or(old.len().min(new.len()), |((at, _), _)| at);
    let (a, b) = (&old[front..], &new[front..]);
    let back: usize = a.chars().rev().zip(b.chars().rev()).take_while(|(a, b)| a == b).map(|(a, _)| a.len_utf8()).sum();
    (&a[..a.len() - back], &b[..b.len() - back])
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, max_shrink_iters: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn documents_survive_any_edits(
        text in document(),
        edits in proptest::collection::vec((0..PROPERTY_COUNT, one_edit()), 0..8),
        in_file in proptest::collection::vec((any::<prop::sample::Index>(), one_edit()), 0..4),
        text_edits in proptest::collection::vec(text_edit(), 0..3),
    ) {
        let (file, _) = MaterialFile::parse(&text).unwrap_or_else(|error| panic!("{error}\n{text}"));
        prop_assert_eq!(file.text(), &text);
        prop_assert_eq!(file.to_text(file.material()), text.clone());

        let mut edited = file.material().clone();
        edits.iter().for_each(|(row, edit)| apply(&mut edited, PROPERTIES[*row].id, edit));
        let authored: Vec<_> = file.material().slots().filter(|(_, slot)| **slot != Default::default()).map(|(id, _)| id).collect();
        if !authored.is_empty() {
            in_file.iter().for_each(|(at, edit)| apply(&mut edited, *at.get(&authored), edit));
        }
        text_edits.iter().for_each(|edit| apply_text(&mut edited, edit));

        let new = file.to_text(&edited);
        let (reread, _) = MaterialFile::parse(&new).unwrap_or_else(|error| panic!("{error}\n{text}\n--\n{new}"));
        prop_assert_eq!(exact(reread.material()), exact(&edited), "\n{}\n--\n{}", text, new);
        prop_assert_eq!(reread.changed(&edited), 0);
        prop_assert_eq!(new == text, file.changed(&edited) == 0);
        // What is unknown stays, unless it was a setting of a texture that went or was replaced, or a text of another format has its place.
        let is_taken = |key: &str| {
            let of = |format: &str, texts: &BTreeMap<String, String>| {
                key == format!("foreign.{format}") || texts.keys().any(|name| key == format!("foreign.{format}.{name}"))
            };
            !edited.foreign.is_empty() && key == "foreign" || edited.foreign.iter().any(|(format, texts)| of(format, texts))
        };
        let is_own = |key: &&String| !key.contains(".texture.") && !is_taken(key);
        prop_assert!(file.unknown_keys().iter().filter(is_own).eq(reread.unknown_keys().iter().filter(is_own)), "{}\n--\n{}", text, new);

        // Taking the edit back before saving gives the same bytes; after rereading, the same values.
        prop_assert_eq!(file.to_text(file.material()), text.clone());
        let back = reread.to_text(file.material());
        let (back, _) = MaterialFile::parse(&back).unwrap_or_else(|error| panic!("{error}\n{new}\n--\n{back}"));
        prop_assert_eq!(exact(back.material()), exact(file.material()));
    }

    #[test]
    fn one_changed_number_changes_one_span(text in document(), at in any::<prop::sample::Index>(), x in number(), which in 0..3_usize) {
        let (file, _) = MaterialFile::parse(&text).unwrap_or_else(|error| panic!("{error}\n{text}"));
        let authored: Vec<_> = file.material().slots().filter_map(|(id, slot)| slot.value.map(|value| (id, value))).collect();
        prop_assume!(!authored.is_empty());
        let (property, value) = *at.get(&authored);
        let mut edited = file.material().clone();
        let edit = if value.numbers().len() == 3 { Edit::Component(which, x) } else { Edit::Float(x) };
        apply(&mut edited, property, &edit);
        let new = file.to_text(&edited);
        let (old_span, new_span) = differing(&text, &new);
        let is_of_a_number = |span: &str| span.chars().all(|c| c.is_ascii_digit() || "+-._eE".contains(c));
        prop_assert!(is_of_a_number(old_span) && is_of_a_number(new_span), "{old_span:?} became {new_span:?}");
    }

    #[test]
    fn fresh_files_hold_any_material(
        edits in proptest::collection::vec((0..PROPERTY_COUNT, one_edit()), 0..30),
        text_edits in proptest::collection::vec(text_edit(), 0..6),
    ) {
        let mut material = Material::default();
        edits.iter().for_each(|(row, edit)| apply(&mut material, PROPERTIES[*row].id, edit));
        text_edits.iter().for_each(|edit| apply_text(&mut material, edit));
        let file = MaterialFile::new(&material);
        prop_assert_eq!(exact(file.material()), exact(&material), "{}", file.text());
        let (_, warnings) = MaterialFile::parse(file.text()).unwrap();
        prop_assert!(warnings.is_empty(), "{:?}", warnings);
    }

    #[test]
    fn any_text_is_read_or_refused(text in any::<String>(), damage in document(), at in any::<prop::sample::Index>(), piece in "[{}()\\[\\]\",:/*a1\\\\ ]{0,3}") {
        _ = MaterialFile::parse(&text);
        // A document with a piece of it replaced: mostly no RON, sometimes another document.
        let at = damage.floor_char_boundary(at.index(damage.len() + 1));
        let end = damage.floor_char_boundary((at + piece.len()).min(damage.len())).max(at);
        let damaged = format!("{}{piece}{}", &damage[..at], &damage[end..]);
        if let Ok((file, _)) = MaterialFile::parse(&damaged) {
            prop_assert_eq!(file.to_text(file.material()), damaged);
        }
    }
}

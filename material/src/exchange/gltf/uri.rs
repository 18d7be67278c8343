//! Names of files in documents: which are taken, and how they are spelled.

use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use base64::{DecodeError, Engine};
use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, percent_decode_str, utf8_percent_encode};

use super::error::start_of;
use crate::exchange::paths::refusal;

/// Longest path that is taken, in bytes.
const MAX_PATH_BYTES: usize = 1024;

/// What is escaped in the URI of a path.
const ESCAPED: &AsciiSet = &NON_ALPHANUMERIC.remove(b'-').remove(b'.').remove(b'_').remove(b'~').remove(b'/');

/// Base64 with or without padding.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent).with_decode_allow_trailing_bits(true),
);

/// The path that a URI of a document means, relative to its folder; an error is what was expected and found.
pub(super) fn read(uri: &str) -> Result<String, String> {
    let problem = || format!("expected a relative path, found \"{}\"", start_of(uri));
    let is_escape = |rest: &str| rest.as_bytes().get(..2).is_some_and(|digits| digits.iter().all(u8::is_ascii_hexdigit));
    if !uri.split('%').skip(1).all(is_escape) {
        return Err(problem());
    }
    let decoded = percent_decode_str(uri).decode_utf8().map_err(|_| problem())?;
    safe(&decoded).ok_or_else(problem)
}

/// A path inside of the document's folder, tidied; `None` for absolute paths, addresses, and what leaves the folder.
pub(super) fn safe(path: &str) -> Option<String> {
    let is_plain = path.len() <= MAX_PATH_BYTES && !path.chars().any(char::is_control) && !path.starts_with("builtin:");
    if !is_plain || refusal(path).is_some() {
        return None;
    }
    let mut kept: Vec<&str> = Vec::new();
    for part in path.split(['/', '\\']) {
        match part {
            "" | "." => {}
            ".." => _ = kept.pop()?,
            part => kept.push(part),
        }
    }
    (!kept.is_empty()).then(|| kept.join("/"))
}

/// The URI that means a relative path.
pub(super) fn write(path: &str) -> String {
    utf8_percent_encode(path, ESCAPED).to_string()
}

/// A word of letters, digits, `-` and `_` that any system takes as a part of a file name; `material` where nothing is left.
pub(super) fn file_word(text: &str) -> String {
    let word: String = text.chars().take(64).map(|c| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' }).collect();
    let word = word.trim_matches('_');
    if word.is_empty() { "material".to_owned() } else { word.to_owned() }
}

/// The end of a file name after its last dot, in lower case.
pub(super) fn extension(path: &str) -> String {
    let name = path.rsplit('/').next().unwrap_or_default();
    name.rsplit_once('.').map(|(_, end)| end.to_ascii_lowercase()).unwrap_or_default()
}

/// The bytes that a data URI holds; an error is what was expected and found. At most `most` bytes.
pub(super) fn read_data(uri: &str, most: usize) -> Result<Vec<u8>, String> {
    let Some((kind, data)) = uri.strip_prefix("data:").and_then(|rest| rest.split_once(',')) else {
        return Err("expected a comma in the data URI, found none".to_owned());
    };
    if data.len() / 4 * 3 > most {
        return Err(format!("expected at most {most} bytes in a data URI, found about {}", data.len() / 4 * 3));
    }
    if kind.ends_with(";base64") { decode_base64(data) } else { Err("expected a data URI in base64, found another".to_owned()) }
}

/// Decodes base64 of the standard or the URL alphabet.
fn decode_base64(text: &str) -> Result<Vec<u8>, String> {
    let standard = text.replace('-', "+").replace('_', "/");
    BASE64.decode(standard).map_err(|error| match error {
        DecodeError::InvalidByte(at, byte) => format!("expected base64, found the byte {byte:#04x} at {at}"),
        error => format!("expected base64: {error}"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_paths_inside_of_the_folder_are_taken() {
        for (uri, path) in [("a.png", "a.png"), ("./t/a%20b.png", "t/a b.png"), ("t/../a.png", "a.png"), ("t\\a.png", "t/a.png")]
        {
            assert_eq!(read(uri).as_deref(), Ok(path));
        }
        let refused =
            "/a.png ../a.png t/../../a.png %2e%2e/a.png http://a/b.png file:a.png C:/a.png \\\\host\\a %2 a%00.png . %ff";
        for uri in refused.split(' ').chain([""]) {
            assert!(read(uri).is_err(), "{uri}");
        }
        assert_eq!(read(&write("tëx/a b#1%.png")).as_deref(), Ok("tëx/a b#1%.png"));
    }

    #[test]
    fn data_uris_are_decoded_up_to_a_size() {
        assert_eq!(read_data("data:image/png;base64,AAECAw==", 100).as_deref(), Ok(&[0, 1, 2, 3][..]));
        assert!(read_data("data:image/png;base64,AAECAw==", 2).is_err());
        assert!(read_data("data:image/png;base64,A!", 100).is_err());
        assert!(read_data("data:image/png", 100).is_err());
    }
}

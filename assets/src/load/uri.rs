//! What a glTF document's URIs point to: a file beside it, or bytes in the URI itself.

use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use base64::{DecodeError, Engine};
use percent_encoding::percent_decode_str;
use std::path::PathBuf;

/// Base64 with or without padding.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent).with_decode_allow_trailing_bits(true),
);

/// Where data are.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Location {
    /// In the URI.
    Inline(Vec<u8>),
    /// In a file, relative to the document's folder.
    Relative(PathBuf),
}

/// Resolves `uri`; an error is what was expected and found, without a full stop.
pub(super) fn locate(uri: &str) -> Result<Location, String> {
    if let Some(rest) = uri.strip_prefix("data:") {
        let Some((kind, data)) = rest.split_once(',') else {
            return Err("expected a comma in the data URI, found none".to_owned());
        };
        if !kind.ends_with(";base64") {
            return Ok(Location::Inline(decode_percent(data)?));
        }
        return decode_base64(data).map(Location::Inline);
    }
    let text = String::from_utf8(decode_percent(uri)?).map_err(|_| "expected UTF-8 in the path".to_owned())?;
    if is_inside(&text) {
        return Ok(Location::Relative(PathBuf::from(text)));
    }
    let start: String = uri.chars().take(40).collect();
    Err(format!("expected a path in the folder of the file or below, or a data URI, found \"{start}\""))
}

/// Whether a path stays in the folder that it starts at. Files of others could name anything else.
fn is_inside(path: &str) -> bool {
    let parts = || path.split(['/', '\\']);
    // Schemes and drives have a colon.
    let is_relative = !path.starts_with(['/', '\\']) && !parts().next().is_some_and(|head| head.contains(':'));
    is_relative && parts().all(|part| part != "..")
}

/// Replaces `%41` by the byte it stands for.
fn decode_percent(text: &str) -> Result<Vec<u8>, String> {
    let is_escape = |rest: &str| rest.as_bytes().get(..2).is_some_and(|digits| digits.iter().all(u8::is_ascii_hexdigit));
    if !text.split('%').skip(1).all(is_escape) {
        return Err("expected two hexadecimal digits after %".to_owned());
    }
    Ok(percent_decode_str(text).collect())
}

/// Decodes base64 of the standard or the URL alphabet; white space is skipped.
fn decode_base64(text: &str) -> Result<Vec<u8>, String> {
    let plain = |c: char| match c {
        '-' => '+',
        '_' => '/',
        c => c,
    };
    let standard: String = text.chars().filter(|c| !c.is_ascii_whitespace()).map(plain).collect();
    BASE64.decode(standard).map_err(|error| match error {
        DecodeError::InvalidByte(at, byte) => format!("expected base64, found the byte {byte:#04x} at {at}"),
        error => format!("expected base64: {error}"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn locations() {
        let relative = |path: &str| Ok(Location::Relative(PathBuf::from(path)));
        let inline = |bytes: &[u8]| Ok(Location::Inline(bytes.to_vec()));
        assert_eq!(locate("a%20b/c.bin"), relative("a b/c.bin"));
        assert_eq!(locate("data:application/octet-stream;base64,TWE="), inline(b"Ma"));
        assert_eq!(locate("data:;base64,TWFu"), inline(b"Man"));
        assert_eq!(locate("data:,a%00b"), inline(b"a\0b"));
        for bad in [
            "http://a/b.bin",
            "file:///etc/passwd",
            "/etc/passwd",
            "%2fetc/passwd",
            "C:/x",
            "../a",
            "a/../../b",
            "%2e%2e/a",
            "a%2",
            "a%zz",
            "data:x",
            "data:;base64,?",
        ] {
            assert!(locate(bad).is_err(), "{bad}");
        }
    }
}

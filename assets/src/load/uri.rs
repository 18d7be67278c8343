//! What a glTF document's URIs point to: a file beside it, or bytes in the URI itself.

use std::path::PathBuf;

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
    // A scheme is at least two letters long: one letter is a drive, which is no relative path either.
    if uri.split(['/', '?', '#']).next().is_some_and(|head| head.contains(':')) || uri.starts_with(['/', '\\']) {
        let start: String = uri.chars().take(40).collect();
        return Err(format!("expected a relative path or a data URI, found \"{start}\""));
    }
    let bytes = decode_percent(uri)?;
    let text = String::from_utf8(bytes).map_err(|_| "expected UTF-8 in the path".to_owned())?;
    Ok(Location::Relative(PathBuf::from(text)))
}

/// Replaces `%41` by the byte it stands for.
fn decode_percent(text: &str) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((&first, tail)) = rest.split_first() {
        if first != b'%' {
            bytes.push(first);
            rest = tail;
            continue;
        }
        let digits = tail.get(..2).and_then(|digits| str::from_utf8(digits).ok());
        let byte = digits.and_then(|digits| u8::from_str_radix(digits, 16).ok());
        bytes.push(byte.ok_or("expected two hexadecimal digits after %")?);
        rest = &tail[2..];
    }
    Ok(bytes)
}

/// Decodes base64 of the standard or the URL alphabet, with or without padding; white space is skipped.
fn decode_base64(text: &str) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3);
    let (mut bits, mut count) = (0_u32, 0);
    for (k, letter) in text.bytes().enumerate() {
        let value = match letter {
            b'A'..=b'Z' => letter - b'A',
            b'a'..=b'z' => letter - b'a' + 26,
            b'0'..=b'9' => letter - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            b'=' => break,
            _ if letter.is_ascii_whitespace() => continue,
            _ => return Err(format!("expected base64, found the byte {letter:#04x} at {k}")),
        };
        bits = bits << 6 | u32::from(value);
        count += 6;
        if count >= 8 {
            count -= 8;
            bytes.push((bits >> count) as u8);
            bits &= (1 << count) - 1;
        }
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn locations() {
        let relative = |path: &str| Ok(Location::Relative(PathBuf::from(path)));
        let inline = |bytes: &[u8]| Ok(Location::Inline(bytes.to_vec()));
        assert_eq!(locate("a%20b/c.bin"), relative("a b/c.bin"));
        assert_eq!(locate("../mesh.bin"), relative("../mesh.bin"));
        assert_eq!(locate("data:application/octet-stream;base64,TWE="), inline(b"Ma"));
        assert_eq!(locate("data:;base64,TWFu"), inline(b"Man"));
        assert_eq!(locate("data:,a%00b"), inline(b"a\0b"));
        for bad in ["http://a/b.bin", "file:///etc/passwd", "/etc/passwd", "C:/x", "a%2", "a%zz", "data:x", "data:;base64,?"] {
            assert!(locate(bad).is_err(), "{bad}");
        }
    }
}

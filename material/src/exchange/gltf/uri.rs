//! Names of files in documents: which are taken, and how they are spelled.

use super::error::start_of;

/// Longest path that is taken, in bytes.
const MAX_PATH_BYTES: usize = 1024;

/// The path that a URI of a document means, relative to its folder; an error is what was expected and found.
pub(super) fn read(uri: &str) -> Result<String, String> {
    let problem = || format!("expected a relative path, found \"{}\"", start_of(uri));
    let decoded = decode_percent(uri).and_then(|bytes| String::from_utf8(bytes).ok()).ok_or_else(problem)?;
    safe(&decoded).ok_or_else(problem)
}

/// A path inside of the document's folder, tidied; `None` for absolute paths, addresses, and what leaves the folder.
pub(super) fn safe(path: &str) -> Option<String> {
    let path = path.replace('\\', "/");
    let has_scheme = path.split('/').next().is_some_and(|head| head.contains(':'));
    if path.len() > MAX_PATH_BYTES || path.starts_with('/') || has_scheme || path.chars().any(char::is_control) {
        return None;
    }
    let mut kept: Vec<&str> = Vec::new();
    for part in path.split('/') {
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
    let mut uri = String::with_capacity(path.len());
    for byte in path.bytes() {
        match byte {
            b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' | b'/' => uri.push(char::from(byte)),
            _ => uri += &format!("%{byte:02X}"),
        }
    }
    uri
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

fn decode_percent(text: &str) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((&first, tail)) = rest.split_first() {
        if first != b'%' {
            bytes.push(first);
            rest = tail;
            continue;
        }
        let digits = tail.get(..2).filter(|digits| digits.iter().all(u8::is_ascii_hexdigit))?;
        bytes.push(u8::from_str_radix(str::from_utf8(digits).ok()?, 16).ok()?);
        rest = &tail[2..];
    }
    Some(bytes)
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

fn decode_base64(text: &str) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3);
    let (mut bits, mut count) = (0_u32, 0);
    for (place, letter) in text.bytes().enumerate() {
        let value = match letter {
            b'A'..=b'Z' => letter - b'A',
            b'a'..=b'z' => letter - b'a' + 26,
            b'0'..=b'9' => letter - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            b'=' => break,
            _ => return Err(format!("expected base64, found the byte {letter:#04x} at {place}")),
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

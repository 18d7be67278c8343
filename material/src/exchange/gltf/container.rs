//! Binary glTF: a header, the JSON, and one block of bytes.

use super::error::{GltfError, Wrong};

const MAGIC: &[u8; 4] = b"glTF";
const JSON: &[u8; 4] = b"JSON";
const BIN: &[u8; 4] = b"BIN\0";

/// The JSON and the block of bytes of a file that is binary; all of it, and no block, of one that is not.
pub(super) fn split(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), GltfError> {
    if !bytes.starts_with(MAGIC) {
        return Ok((bytes, None));
    }
    let wrong = |place: String, expected: &str, found: String| GltfError::NotBinary(Wrong::new(place, expected, found));
    let word = |at: usize| bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    match word(4) {
        Some(2) => {}
        Some(version) => return Err(wrong("header".to_owned(), "version 2", format!("version {version}"))),
        None => return Err(wrong("header".to_owned(), "12 bytes", format!("{} bytes", bytes.len()))),
    }
    let (mut json, mut blob) = (None, None);
    let mut at = 12;
    while at < bytes.len() {
        let place = || format!("chunk at byte {at}");
        let (Some(length), Some(kind)) = (word(at), bytes.get(at + 4..at + 8)) else {
            return Err(wrong(place(), "length and kind", format!("{} bytes", bytes.len() - at)));
        };
        let begin = at + 8;
        let Some(data) = bytes.get(begin..begin.saturating_add(length as usize)) else {
            return Err(wrong(place(), &format!("{length} bytes"), format!("{}", bytes.len() - begin)));
        };
        // Chunks of other kinds are allowed and have no meaning here.
        if kind == JSON && json.is_none() {
            json = Some(data);
        } else if kind == BIN && blob.is_none() {
            blob = Some(data);
        }
        at = begin + data.len();
    }
    let json = json.ok_or_else(|| wrong("file".to_owned(), "a chunk of JSON", "none".to_owned()))?;
    Ok((json, blob))
}

/// A binary file of a JSON text and a block of bytes. `None` beyond 4 GB, which the format cannot hold.
pub(super) fn join(json: &str, blob: &[u8]) -> Option<Vec<u8>> {
    let padded = |length: usize| length.next_multiple_of(4);
    let blob_bytes = if blob.is_empty() { 0 } else { 8 + padded(blob.len()) };
    let total = u32::try_from(20 + padded(json.len()) + blob_bytes).ok()?;
    let mut file = Vec::with_capacity(total as usize);
    file.extend(MAGIC);
    file.extend(2_u32.to_le_bytes());
    file.extend(total.to_le_bytes());
    let mut chunk = |kind: &[u8], data: &[u8], filler: u8| {
        // Within the total, which fits.
        file.extend((padded(data.len()) as u32).to_le_bytes());
        file.extend(kind);
        file.extend(data);
        file.resize(file.len().next_multiple_of(4), filler);
    };
    chunk(JSON, json.as_bytes(), b' ');
    if !blob.is_empty() {
        chunk(BIN, blob, 0);
    }
    Some(file)
}

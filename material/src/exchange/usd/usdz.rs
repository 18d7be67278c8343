//! The package of USD, usdz: a zip archive of stored files, the layer first, each file's bytes on a multiple of 64.
//!
//! Whatever a package does not need is refused when reading: compression, encryption, zip64, paths that lead out of it, and entries that
//! share bytes. Source: PKWARE's APPNOTE 6.3.10, and Pixar's specification of usdz.

use std::collections::HashSet;
use std::ops::Range;

use super::error::UsdError;
use super::layer_text;

const LOCAL: u32 = 0x0403_4b50;
const CENTRAL: u32 = 0x0201_4b50;
const END: u32 = 0x0605_4b50;
const LOCAL_BYTES: usize = 30;
const CENTRAL_BYTES: usize = 46;
const END_BYTES: usize = 22;
/// What the bytes of each file lie on a multiple of.
const ALIGNMENT: usize = 64;
/// Most files of a package.
pub const MAX_FILES: usize = 10_000;
/// Number of the extra field that fills up to the alignment, which no program reads.
const PADDING: u16 = 0x1986;
/// The first of January 1980, so that the same files make the same package.
const DATE: u16 = 0x0021;
/// ASCII names need version 1.0 of the format; the flag says that names are UTF-8.
const VERSION: u16 = 10;
const UTF8_NAMES: u16 = 1 << 11;
const ENCRYPTED: u16 = 1;

/// A package that was read: where its files lie in its bytes.
#[derive(Clone, Debug)]
pub struct Package<'a> {
    bytes: &'a [u8],
    files: Vec<(String, Range<usize>)>,
}

impl<'a> Package<'a> {
    /// Names of the files, with `/`, and their bytes, in the order of the package.
    pub fn files(&self) -> impl Iterator<Item = (&str, &'a [u8])> {
        self.files.iter().filter_map(|(name, range)| Some((name.as_str(), self.bytes.get(range.clone())?)))
    }

    /// The bytes of a file.
    pub fn file(&self, name: &str) -> Option<&'a [u8]> {
        self.files().find(|(found, _)| *found == name).map(|(_, bytes)| bytes)
    }

    /// The bytes of a file by its path as the layer says it: from the folder of the layer.
    pub fn beside_layer(&self, path: &str) -> Option<&'a [u8]> {
        let (layer, _) = self.files.first()?;
        let folder = layer.rfind('/').map_or("", |slash| &layer[..=slash]);
        self.file(&format!("{folder}{path}"))
    }

    /// The text of the package's layer, its first file.
    pub fn layer(&self) -> Result<&'a str, UsdError> {
        let Some((name, bytes)) = self.files().next() else {
            return Err(fault("", "expected a layer of USD as the first file, found none"));
        };
        let ending = name.rsplit('.').next().unwrap_or_default().to_ascii_lowercase();
        match ending.as_str() {
            "usda" | "usd" | "usdc" => layer_text(bytes),
            _ => Err(fault(name, "expected a layer of USD as the first file, found another")),
        }
    }
}

fn fault(entry: &str, message: impl Into<String>) -> UsdError {
    UsdError::Package { entry: entry.to_owned(), message: message.into() }
}

/// Reads the bytes of a package. No file is copied.
pub fn read(bytes: &[u8]) -> Result<Package<'_>, UsdError> {
    let short = || fault("", "expected a zip archive, found bytes that end too early");
    let end = find_end(bytes)?;
    let word = |at: usize| number(bytes, at, 2).ok_or_else(short);
    let (count, size, start) =
        (word(end + 10)?, number(bytes, end + 12, 4).ok_or_else(short)?, number(bytes, end + 16, 4).ok_or_else(short)?);
    if word(end + 4)? != 0 || word(end + 6)? != 0 || word(end + 8)? != count {
        return Err(fault("", "expected an archive in one piece, found a part of one"));
    }
    if count == 0xFFFF || size == 0xFFFF_FFFF || start == 0xFFFF_FFFF {
        return Err(fault("", "expected an archive of less than 4 GiB and 65535 files, found the zip64 form"));
    }
    if count > MAX_FILES {
        return Err(fault("", format!("expected at most {MAX_FILES} files, found {count}")));
    }
    if start.checked_add(size) != Some(end) {
        return Err(fault("", "expected the list of files right before the end of the archive, found it elsewhere"));
    }
    let (mut files, mut used, mut names) = (Vec::new(), Vec::new(), HashSet::new());
    let mut at = start;
    for _ in 0..count {
        let (name, whole, data, next) = entry(bytes, at, start)?;
        at = next;
        if !names.insert(name.clone()) {
            return Err(fault(&name, "expected each file once, found it twice"));
        }
        used.push((whole, name.clone()));
        if !name.ends_with('/') {
            files.push((name, data));
        }
    }
    used.sort_by_key(|(range, _)| range.start);
    for pair in used.windows(2) {
        if pair[1].0.start < pair[0].0.end {
            return Err(fault(&pair[1].1, format!("expected bytes of its own, found some of `{}`", pair[0].1)));
        }
    }
    Ok(Package { bytes, files })
}

/// Little-endian number of up to 4 bytes.
fn number(bytes: &[u8], at: usize, count: usize) -> Option<usize> {
    let bytes = bytes.get(at..at.checked_add(count)?)?;
    Some(bytes.iter().rev().fold(0, |sum, b| sum << 8 | usize::from(*b)))
}

/// Where the record at the end of the archive begins: the last place whose comment reaches the end of the bytes.
fn find_end(bytes: &[u8]) -> Result<usize, UsdError> {
    let last = bytes.len().checked_sub(END_BYTES).ok_or_else(|| fault("", "expected a zip archive, found too few bytes"))?;
    let first = last.saturating_sub(0xFFFF);
    let is_end = |at: &usize| number(bytes, *at, 4) == Some(END as usize) && number(bytes, at + 20, 2) == Some(last - at);
    (first..=last).rev().find(is_end).ok_or_else(|| fault("", "expected a zip archive, found no end of one"))
}

/// An entry of the list of files: name, all bytes that it uses, the bytes of the file, and where the next entry begins.
fn entry(bytes: &[u8], at: usize, list: usize) -> Result<(String, Range<usize>, Range<usize>, usize), UsdError> {
    let short = || fault("", "expected an entry for each file, found a list that ends too early");
    let half = |offset: usize| number(bytes, at + offset, 2).ok_or_else(short);
    let full = |offset: usize| number(bytes, at + offset, 4).ok_or_else(short);
    if full(0)? != CENTRAL as usize {
        return Err(short());
    }
    let (name_length, extra, comment) = (half(28)?, half(30)?, half(32)?);
    let name_start = at + CENTRAL_BYTES;
    let raw = bytes.get(name_start..name_start + name_length).ok_or_else(short)?;
    let name =
        std::str::from_utf8(raw).map_err(|_| fault(&String::from_utf8_lossy(raw), "expected a name in UTF-8, found another"))?;
    let refuse = |message: &str| Err(fault(name, message));
    if let Some(reason) = bad_name(name) {
        return refuse(reason);
    }
    if half(8)? & usize::from(ENCRYPTED) != 0 {
        return refuse("expected a file as it is, found an encrypted one");
    }
    let (stored, size, header) = (full(20)?, full(24)?, full(42)?);
    if half(10)? != 0 || stored != size {
        return refuse("expected a file as it is, found a compressed one; pack it again without compression");
    }
    if size == 0xFFFF_FFFF || header == 0xFFFF_FFFF {
        return refuse("expected a file of less than 4 GiB, found the zip64 form");
    }
    let outside = "expected a file within the archive, found one that lies outside";
    let (Some(mark), Some(local_name), Some(local_extra)) =
        (number(bytes, header, 4), number(bytes, header + 26, 2), number(bytes, header + 28, 2))
    else {
        return refuse(outside);
    };
    let start = header + LOCAL_BYTES + local_name + local_extra;
    let end = start.saturating_add(size);
    if end > list {
        return refuse(outside);
    }
    if mark != LOCAL as usize || bytes.get(header + LOCAL_BYTES..header + LOCAL_BYTES + local_name) != Some(raw) {
        return refuse("expected the same name in front of the file as in the list, found another");
    }
    let sum = full(16)? as u32;
    if bytes.get(start..end).map(crc32) != Some(sum) {
        return refuse("expected the bytes that its checksum tells of, found others: the file is damaged");
    }
    Ok((name.to_owned(), header..end, start..end, name_start + name_length + extra + comment))
}

/// Why a name does not belong into a package.
fn bad_name(name: &str) -> Option<&'static str> {
    if name.is_empty() || name.chars().any(|c| c.is_control()) {
        return Some("expected a readable name, found another");
    }
    let is_inside = !name.starts_with('/') && !name.contains(['\\', ':']) && name.split('/').all(|part| part != "..");
    if is_inside { None } else { Some("expected a path inside the package, found one that leads out of it") }
}

/// The bytes of a package with this layer, its first file, and these others. The same input makes the same bytes.
///
/// Errors name a file whose name cannot stand in a package or stands twice, and a package of 4 GiB or more.
pub fn write(layer_name: &str, layer: &str, files: &[(&str, &[u8])]) -> Result<Vec<u8>, UsdError> {
    let too_large = || fault("", "expected less than 4 GiB and 10000 files in a package, found more");
    if files.len() >= MAX_FILES {
        return Err(too_large());
    }
    let (mut out, mut list, mut names) = (Vec::new(), Vec::new(), HashSet::new());
    let layer = (layer_name, layer.as_bytes());
    for (name, bytes) in std::iter::once(&layer).chain(files) {
        if let Some(reason) = bad_name(name) {
            return Err(fault(name, reason));
        }
        if !names.insert(*name) {
            return Err(fault(name, "expected each file once, found it twice"));
        }
        let (header, size) = (u32::try_from(out.len()), u32::try_from(bytes.len()));
        let (Ok(header), Ok(size), Ok(name_length)) = (header, size, u16::try_from(name.len())) else { return Err(too_large()) };
        let unpadded = out.len() + LOCAL_BYTES + name.len();
        // An extra field has four bytes of its own at least.
        let padding = (ALIGNMENT - (unpadded + 4) % ALIGNMENT) % ALIGNMENT;
        let sum = crc32(bytes);
        let common = |into: &mut Vec<u8>, extra: u16| {
            for half in [VERSION, UTF8_NAMES, 0, 0, DATE] {
                into.extend(half.to_le_bytes());
            }
            for full in [sum, size, size] {
                into.extend(full.to_le_bytes());
            }
            into.extend(name_length.to_le_bytes());
            into.extend(extra.to_le_bytes());
        };
        out.extend(LOCAL.to_le_bytes());
        common(&mut out, padding as u16 + 4);
        out.extend(name.as_bytes());
        out.extend(PADDING.to_le_bytes());
        out.extend((padding as u16).to_le_bytes());
        out.resize(out.len() + padding, 0);
        out.extend(*bytes);

        list.extend(CENTRAL.to_le_bytes());
        list.extend(VERSION.to_le_bytes());
        common(&mut list, 0);
        // Comment, disk, kinds of file.
        list.extend([0; 10]);
        list.extend(header.to_le_bytes());
        list.extend(name.as_bytes());
    }
    let (Ok(start), Ok(size)) = (u32::try_from(out.len()), u32::try_from(list.len())) else { return Err(too_large()) };
    let count = files.len() as u16 + 1;
    out.append(&mut list);
    out.extend(END.to_le_bytes());
    out.extend([0; 4]);
    out.extend(count.to_le_bytes());
    out.extend(count.to_le_bytes());
    out.extend(size.to_le_bytes());
    out.extend(start.to_le_bytes());
    out.extend([0; 2]);
    Ok(out)
}

/// The checksum of zip archives, with the polynomial 0xEDB88320.
fn crc32(bytes: &[u8]) -> u32 {
    const TABLE: [u32; 256] = {
        let mut table = [0; 256];
        let mut k = 0;
        while k < 256 {
            let (mut code, mut bit) = (k as u32, 0);
            while bit < 8 {
                code = if code & 1 == 1 { code >> 1 ^ 0xEDB8_8320 } else { code >> 1 };
                bit += 1;
            }
            table[k] = code;
            k += 1;
        }
        table
    };
    !bytes.iter().fold(!0, |code, b| code >> 8 ^ TABLE[(code as u8 ^ b) as usize])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_that_of_zip() {
        assert_eq!(crc32(b"123456789"), 0xCBF4_3926);
    }
}

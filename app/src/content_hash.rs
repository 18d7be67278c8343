//! A number that tells whether a file still holds what it held: FNV-1a of 128 bits over words of eight bytes. Against accidents, not against
//! intent.

use std::fs::File;
use std::io::Read;
use std::path::Path;

const OFFSET: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;

/// The hash of a file as 32 hexadecimal digits.
pub fn of_file(path: &Path) -> std::io::Result<String> {
    let mut file = File::open(path)?;
    let mut hash = Hash::default();
    let mut part = vec![0; 1 << 20];
    loop {
        // Whole words up to the end, however little a read brings.
        let mut filled = 0;
        while filled < part.len() {
            match file.read(&mut part[filled..])? {
                0 => break,
                n => filled += n,
            }
        }
        hash.add(&part[..filled]);
        if filled < part.len() {
            return Ok(hash.text());
        }
    }
}

/// The hash of some bytes as 32 hexadecimal digits.
pub fn of_bytes(bytes: &[u8]) -> String {
    let mut hash = Hash::default();
    hash.add(bytes);
    hash.text()
}

struct Hash {
    state: u128,
    length: u64,
}

impl Default for Hash {
    fn default() -> Self {
        Self { state: OFFSET, length: 0 }
    }
}

impl Hash {
    fn add(&mut self, bytes: &[u8]) {
        self.length += bytes.len() as u64;
        for chunk in bytes.chunks(8) {
            let word = chunk.iter().rev().fold(0, |word: u64, byte| word << 8 | u64::from(*byte));
            self.state = (self.state ^ u128::from(word)).wrapping_mul(PRIME);
        }
    }

    fn text(&self) -> String {
        format!("{:032x}", (self.state ^ u128::from(self.length)).wrapping_mul(PRIME))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_and_bytes_agree_and_every_byte_counts() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        for length in [0, 1, 7, 8, 9, 1 << 20, (1 << 20) + 3] {
            let mut bytes: Vec<u8> = (0..length).map(|i| (i * 31 % 251) as u8).collect();
            std::fs::write(&path, &bytes).unwrap();
            let hash = of_file(&path).unwrap();
            assert_eq!(hash, of_bytes(&bytes));
            bytes.push(0);
            assert_ne!(hash, of_bytes(&bytes), "{length}");
        }
    }
}

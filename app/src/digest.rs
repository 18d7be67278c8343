//! 128-bit hashes of contents: what tells two versions of a material or of a file apart, and names small pictures on disk.
//!
//! SipHash-2-4 with a fixed key. Among a million contents two would meet by accident once in 10²⁶ tries; it does not stand against somebody who
//! looks for two contents of one hash, which would gain nothing but a wrong picture. The same bytes give the same hash on every machine.

use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use siphasher::sip128::{Hasher128, SipHasher24};
use std::fmt;
use std::fs::File;
use std::hash::Hasher;
use std::io::{self, Read};
use std::path::Path;

/// A hash, printed as 32 digits of base 16.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Digest(u128);

impl Digest {
    /// The hash of some bytes.
    pub fn of(bytes: &[u8]) -> Self {
        Digesting::default().bytes(bytes).end()
    }

    /// The hash of what a file holds: the same as that of its size and then its bytes. `None` if `goes_on` says no after a part of it.
    pub fn of_file(path: &Path, goes_on: &dyn Fn() -> bool) -> io::Result<Option<Self>> {
        let mut file = File::open(path)?;
        let size = file.metadata()?.len();
        let mut all = Digesting::default();
        all.whole(&[size]);
        // Without the bound, a file that grows could be read for ever.
        let mut rest = (&mut file).take(size);
        let mut buffer = vec![0; 1 << 18];
        loop {
            if !goes_on() {
                return Ok(None);
            }
            match rest.read(&mut buffer)? {
                0 => return Ok(Some(all.end())),
                count => _ = all.piece(&buffer[..count]),
            }
        }
    }

    /// The hash that 32 digits of base 16 stand for.
    pub fn parse(text: &str) -> Option<Self> {
        let is_plain = text.len() == 32 && text.bytes().all(|c| c.is_ascii_hexdigit());
        u128::from_str_radix(text, 16).ok().filter(|_| is_plain).map(Self)
    }

    /// In which of `count` parts this hash falls, from 0; parts are of about equal size. `count` 0 counts as 1.
    pub fn part(self, count: u32) -> u32 {
        // Smaller than `count`.
        (self.0 % u128::from(count.max(1))) as u32
    }
}

impl fmt::Display for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:032x}", self.0)
    }
}

impl Serialize for Digest {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Digest {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        Self::parse(&text).ok_or_else(|| de::Error::custom("expected 32 digits of base 16"))
    }
}

/// A hash on the way. Each part carries its length, so that moving a border between two parts changes the hash.
#[derive(Clone, Default)]
pub struct Digesting(SipHasher24);

impl Digesting {
    /// Adds some bytes.
    pub fn bytes(&mut self, bytes: &[u8]) -> &mut Self {
        self.0.write(&(bytes.len() as u64).to_le_bytes());
        self.0.write(bytes);
        self
    }

    /// Adds a text.
    pub fn text(&mut self, text: &str) -> &mut Self {
        self.bytes(text.as_bytes())
    }

    /// Adds whole numbers.
    pub fn whole(&mut self, numbers: &[u64]) -> &mut Self {
        self.bytes(&numbers.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>())
    }

    /// Adds numbers by their bits.
    pub fn numbers(&mut self, numbers: &[f64]) -> &mut Self {
        self.bytes(&numbers.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>())
    }

    /// Adds another hash.
    pub fn digest(&mut self, digest: Digest) -> &mut Self {
        self.bytes(&digest.0.to_le_bytes())
    }

    /// Adds the next piece of something whose length is added elsewhere.
    pub fn piece(&mut self, bytes: &[u8]) -> &mut Self {
        self.0.write(bytes);
        self
    }

    /// The hash of everything so far.
    pub fn end(&self) -> Digest {
        Digest(self.0.finish128().as_u128())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_of_a_file_counts() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let hash = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            Digest::of_file(&path, &|| true).unwrap().unwrap()
        };
        for length in [0, 1, 7, (1 << 18) - 1, 1 << 18, (1 << 18) + 3] {
            let mut bytes: Vec<u8> = (0..length).map(|i| (i * 31 % 251) as u8).collect();
            let whole = hash(&bytes);
            assert_eq!(whole, hash(&bytes));
            bytes.push(0);
            assert_ne!(whole, hash(&bytes), "{length}");
        }
        assert_eq!(Digest::of_file(&path, &|| false).unwrap(), None);
    }

    #[test]
    fn the_same_bytes_give_the_same_hash_for_ever() {
        // Names of pictures on disk depend on it.
        assert_eq!(Digest::of(b"roughness").to_string(), "543a86942cb81ee41f5179da8972c836");
        let parts = |words: &[&str]| words.iter().fold(Digesting::default(), |mut all, word| all.text(word).clone()).end();
        assert_ne!(parts(&["ab", "c"]), parts(&["a", "bc"]));
        let digest = Digest::of(b"x");
        assert_eq!(Digest::parse(&digest.to_string()), Some(digest));
        for text in ["", "0", "+0000000000000000000000000000000", &"g".repeat(32), &"0".repeat(33)] {
            assert_eq!(Digest::parse(text), None, "{text}");
        }
        assert_eq!((digest.part(0), digest.part(1)), (0, 0));
    }
}

//! Do readers keep their promises about inputs that once broke one, and about odd ones near those?
//!
//! `fuzz/src/lib.rs` says what the promises are. Here the corpus is replayed and mutated a little; searching for more is done by hand.

#[path = "../fuzz/src/lib.rs"]
mod fuzz;

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

use fuzz::{TARGETS, Target};

/// Mutated inputs of each target; a few of them take milliseconds.
const MUTATED: usize = 3000;
/// What most mutated inputs of a target may take together; slow machines see fewer of them.
const TIME: Duration = Duration::from_secs(2);
/// What a single input may take. They are small.
const MOST: Duration = Duration::from_secs(10);
/// Longest input, in bytes.
const LENGTH: usize = 1 << 16;

/// What tends to break readers.
const ODD: &[&[u8]] = &[
    b"NaN",
    b"-inf",
    b"1e400",
    b"-1",
    b"0",
    b"1e-320",
    b"4294967295",
    b"18446744073709551616",
    b"9007199254740993",
    b"null",
    b"true",
    b"\"\"",
    b"\"",
    b"\\u0000",
    b"[[[[[[[[",
    b"((((((((",
    b"{{{{{{{{",
    b"<a><a><a>",
    b"}",
    b"]",
    b")",
    b"</",
    b"/*",
    b"//",
    b"\n",
    b"\0",
    b"\xff\xff\xff\xff",
    b"\xff\xff\xff\x7f",
    b"\xef\xbb\xbf",
    b"\xe2\x80\xa8",
    b"../../../a",
    b"/etc/passwd",
    b"http://a/b",
    b"data:,",
];

/// A sequence of numbers that is the same each time (SplitMix64).
struct Numbers(u64);

impl Numbers {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) % end.max(1) as u64) as usize
    }

    /// A short piece of an input.
    fn piece(&mut self, length: usize) -> std::ops::Range<usize> {
        let start = self.below(length);
        let most = if self.below(4) == 0 { 400 } else { 12 };
        start..(start + self.below(most) + 1).min(length)
    }
}

/// An input with a few changes, some of them pieces of others.
fn mutated(inputs: &[Vec<u8>], numbers: &mut Numbers) -> Vec<u8> {
    let mut bytes = inputs[numbers.below(inputs.len())].clone();
    for _ in 0..=numbers.below(4) {
        let place = numbers.piece(bytes.len());
        let new = match numbers.below(6) {
            0 => bytes[place.clone()].iter().map(|byte| byte ^ (1 << numbers.below(8))).collect(),
            1 => Vec::new(),
            2 => bytes[place.clone()].repeat(2 + numbers.below(20)),
            3 => {
                let other = &inputs[numbers.below(inputs.len())];
                other[numbers.piece(other.len())].to_vec()
            }
            _ => ODD[numbers.below(ODD.len())].to_vec(),
        };
        bytes.splice(place, new);
    }
    if numbers.below(20) == 0 {
        bytes.truncate(numbers.below(bytes.len()));
    }
    bytes.truncate(LENGTH);
    bytes
}

/// Runs a target; what breaks it is kept as a file, to become part of the corpus.
fn run((name, target): Target, bytes: &[u8], what: &str) {
    let start = Instant::now();
    let result = catch_unwind(AssertUnwindSafe(|| target(bytes)));
    if result.is_err() || start.elapsed() > MOST {
        let kept = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-finding"));
        fs::write(&kept, bytes).expect("a folder for temporary files");
        panic!("{name}: {what} breaks a promise, or takes {:?}; kept as {}", start.elapsed(), kept.display());
    }
}

#[test]
fn the_corpus_and_what_is_near_it_break_no_promise() {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus");
    for &(name, target) in TARGETS {
        let mut files: Vec<_> =
            fs::read_dir(corpus.join(name)).expect("a corpus for each target").flatten().map(|file| file.path()).collect();
        files.sort();
        let inputs: Vec<Vec<u8>> = files.iter().map(|file| fs::read(file).expect("a file of the corpus")).collect();
        assert!(inputs.len() <= 40 && inputs.iter().map(Vec::len).sum::<usize>() <= 150_000, "{name}: expected a small corpus");
        for (input, file) in inputs.iter().zip(&files) {
            run((name, target), input, &file.display().to_string());
        }
        let (mut numbers, start) = (Numbers(0), Instant::now());
        for k in (0..MUTATED).take_while(|_| start.elapsed() < TIME) {
            run((name, target), &mutated(&inputs, &mut numbers), &format!("mutated input {k}"));
        }
    }
}

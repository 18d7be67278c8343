//! Which files are one material twice.

use super::file::Report;
use super::look::{ALIKE, Look};
use super::{Kind, map};
use crate::digest::{Digest, Digesting};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Of larger images only the size counts: no renderer reads them.
const MAX_IMAGE_BYTES: u64 = 2 << 30;

/// Two reports by their numbers, the second one being the repetition.
pub(super) struct Found {
    pub first: usize,
    pub second: usize,
    pub kind: Kind,
    pub distance: f64,
}

/// Everything that is there more than once, by the number of the repetition. What is like several is found with the first or the nearest of them.
///
/// `None` if it is cancelled.
pub(super) fn find(reports: &[Report], threads: usize, is_cancelled: &(dyn Fn() -> bool + Sync)) -> Option<Vec<Found>> {
    let mut by_values: HashMap<Digest, Vec<usize>> = HashMap::new();
    for (at, report) in reports.iter().enumerate() {
        if let Some(values) = report.values {
            by_values.entry(values).or_default().push(at);
        }
    }
    // Images are read only where everything else is equal.
    let alike = || by_values.values().filter(|numbers| numbers.len() > 1).flatten();
    let images: BTreeSet<&PathBuf> = alike().flat_map(|at| &reports[*at].images).collect();
    let images: Vec<&PathBuf> = images.into_iter().collect();
    let hashes = map(images.len(), threads, &|_| {}, is_cancelled, |_, at| image_hash(images[at], is_cancelled))?;
    let hashes: BTreeMap<&PathBuf, Digest> = images.into_iter().zip(hashes).collect();

    let mut found: Vec<Found> = Vec::new();
    for numbers in by_values.values().filter(|numbers| numbers.len() > 1) {
        let mut first: BTreeMap<Vec<Option<&Digest>>, usize> = BTreeMap::new();
        for at in numbers {
            let pixels = reports[*at].images.iter().map(|image| hashes.get(image)).collect();
            let first = *first.entry(pixels).or_insert(*at);
            if first != *at {
                found.push(Found { first, second: *at, kind: Kind::Value, distance: 0.0 });
            }
        }
    }
    let is_value: BTreeSet<usize> = found.iter().map(|pair| pair.second).collect();
    let looks = reports.iter().enumerate().filter(|(at, _)| !is_value.contains(at));
    found.extend(by_look(looks.filter_map(|(at, report)| Some((at, report.look.as_deref()?))), is_cancelled)?);
    found.sort_by_key(|pair| pair.second);
    Some(found)
}

/// Pictures that are like an earlier one. Each is compared with those of about its mean that are not like another.
fn by_look<'a>(looks: impl Iterator<Item = (usize, &'a Look)>, is_cancelled: &dyn Fn() -> bool) -> Option<Vec<Found>> {
    let mut found = Vec::new();
    // Numbers of at least 0 have the order of their bits.
    let mut known: BTreeMap<(u32, usize), &Look> = BTreeMap::new();
    for (at, look) in looks {
        if is_cancelled() {
            return None;
        }
        // The mean is rounded, so a little more than what is alike.
        let reach = 1.01 * ALIKE as f32;
        let (low, high) = ((look.mean() - reach).max(0.0), look.mean() + reach);
        let near = known
            .range((low.to_bits(), 0)..=(high.to_bits(), usize::MAX))
            .map(|((_, other), known)| (*other, look.distance(known)));
        match near.min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0))).filter(|(_, distance)| *distance <= ALIKE) {
            Some((first, distance)) => found.push(Found { first, second: at, kind: Kind::Look, distance }),
            None => _ = known.insert((look.mean().to_bits(), at), look),
        }
    }
    Some(found)
}

/// The hash of an image's bytes; of one that cannot be read, of its path: it is equal to itself alone.
fn image_hash(place: &Path, is_cancelled: &(dyn Fn() -> bool + Sync)) -> Digest {
    let mut all = Digesting::default();
    let mut read = || -> std::io::Result<()> {
        let file = File::open(place)?;
        let metadata = file.metadata()?;
        all.whole(&[metadata.len()]);
        if !metadata.is_file() || metadata.len() > MAX_IMAGE_BYTES {
            return Ok(());
        }
        let mut file = file.take(MAX_IMAGE_BYTES);
        let mut buffer = vec![0; 1 << 18];
        loop {
            let count = file.read(&mut buffer)?;
            if count == 0 || is_cancelled() {
                return Ok(());
            }
            all.piece(&buffer[..count]);
        }
    };
    match read() {
        Ok(()) => all.end(),
        Err(_) => Digest::of(place.as_os_str().as_encoded_bytes()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_found_with_the_nearest_of_those_before() {
        let grey = |x: f32| Look::of(&[[x; 3]; 4], 2).unwrap();
        // Of 0.5 the second is 0.1 % away, the third 1 %, the fourth 0.1 % of the third.
        let looks = [0.5, 0.5005, 0.505, 0.5055, 0.9].map(grey);
        let found = by_look(looks.iter().enumerate(), &|| false).unwrap();
        let pairs: Vec<_> = found.iter().map(|pair| (pair.first, pair.second)).collect();
        assert_eq!(pairs, [(0, 1), (2, 3)]);
        assert!(found.iter().all(|pair| (0.0009..0.0011).contains(&pair.distance)), "{:?}", found[0].distance);
        assert!(by_look(looks.iter().enumerate(), &|| true).is_none());
    }
}

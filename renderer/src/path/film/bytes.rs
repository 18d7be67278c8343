//! A film as bytes, to be put aside and taken up again bit by bit.

use super::{Cell, Film, REPLICATES, Window};
use crate::path::bytes::{Reader, Writer};

/// Bytes of a cell.
const CELL: usize = REPLICATES * 3 * 8 + 8;
/// Bytes of the splats of a pixel.
const SPLATS: usize = REPLICATES * 3 * 8;

impl Film {
    /// Appends the film.
    pub(in crate::path) fn write(&self, to: &mut Writer) {
        let Window { full, at } = self.window;
        for side in [self.width, self.height, full[0], full[1], at[0], at[1]] {
            to.u64(side as u64);
        }
        to.u64(self.samples);
        self.photons.iter().for_each(|n| to.u64(*n));
        to.u32(self.photon_samples);
        for cell in &self.cells {
            cell.sums.iter().flatten().for_each(|x| to.f64(*x));
            to.u32(cell.count);
            to.u32(cell.covered);
        }
        to.u64(self.splats.len() as u64);
        self.splats.iter().flatten().flatten().for_each(|x| to.f64(*x));
    }

    /// The film that was appended; `None` where the bytes are no film.
    pub(in crate::path) fn read(from: &mut Reader<'_>) -> Option<Self> {
        let mut sides = [0; 6];
        for side in &mut sides {
            *side = usize::try_from(from.u64()?).ok()?;
        }
        let [width, height, full_width, full_height, x, y] = sides;
        let is_inside = x.checked_add(width)? <= full_width && y.checked_add(height)? <= full_height;
        let pixels = width.checked_mul(height).filter(|n| is_inside && *n > 0 && u32::try_from(*n).is_ok())?;
        let samples = from.u64()?;
        let mut photons = [0; REPLICATES];
        for n in &mut photons {
            *n = from.u64()?;
        }
        let photon_samples = from.u32()?;
        if !from.holds(pixels.checked_mul(CELL)?) {
            return None;
        }
        let mut film = Self::of_window(width, height, Window { full: [full_width, full_height], at: [x, y] });
        let (mut total, mut is_finite) = (0, true);
        for cell in &mut film.cells {
            *cell = Cell { sums: sums(from)?, count: from.u32()?, covered: from.u32()? };
            total += u64::from(cell.count);
            is_finite &= cell.sums.iter().flatten().all(|x| x.is_finite());
        }
        let splats = from.count(SPLATS)?;
        for _ in 0..splats {
            film.splats.push(sums(from)?);
        }
        let is_whole = is_finite && total == samples && (splats == 0 || splats == pixels);
        (film.samples, film.photons, film.photon_samples) = (samples, photons, photon_samples);
        is_whole.then_some(film)
    }
}

fn sums(from: &mut Reader<'_>) -> Option<[[f64; 3]; REPLICATES]> {
    let mut sums = [[0.0; 3]; REPLICATES];
    for x in sums.iter_mut().flatten() {
        *x = from.f64()?;
    }
    Some(sums)
}

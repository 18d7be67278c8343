//! Parts of a picture: those of a large one are drawn one after the other, each as if the whole were.

use crate::scene::{Camera, CameraBasis};

/// Where a part lies in its picture, pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop {
    /// Columns and rows of the whole picture.
    pub full: [u32; 2],
    /// Column and row of the whole at which the part begins.
    pub at: [u32; 2],
}

impl Crop {
    /// All of a picture of this size.
    pub(super) fn all([width, height]: [u32; 2]) -> Self {
        Self { full: [width, height], at: [0, 0] }
    }

    /// The basis of the whole with axes as long as half a part of this size, and where the middle of the part lies in units of them.
    pub(super) fn basis(self, camera: &Camera, size: [u32; 2]) -> (CameraBasis, [f32; 2]) {
        let [full_width, full_height] = self.full.map(|side| side.max(1) as f32);
        let share = [size[0] as f32 / full_width, size[1] as f32 / full_height];
        let mut basis = camera.basis(full_width / full_height);
        if self.full == size {
            return (basis, [0.0; 2]);
        }
        basis.right *= share[0];
        basis.up *= share[1];
        let middle = |k: usize| (2.0 * self.at[k] as f32 + size[k] as f32) / self.full[k].max(1) as f32 - 1.0;
        (basis, [middle(0) / share[0], -middle(1) / share[1]])
    }
}

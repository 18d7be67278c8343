//! What leaving lobes out saves: the preview with more lobes than a material needs, and the time that pipelines take.

use super::device::PreviewError;
use super::{Drawn, Preview};
use crate::scene::Object;
use burnish_material::LobeSet;
use std::time::{Duration, Instant};

fn lobes_of(object: &Object, [more, less]: [LobeSet; 2]) -> LobeSet {
    let needed = LobeSet::of(&object.material);
    if object.is_document { needed.union(more).minus(less) } else { needed }
}

impl Preview {
    /// Lobes that an object is drawn with.
    pub(super) fn lobes_of(&self, object: &Object) -> LobeSet {
        lobes_of(object, self.changed)
    }

    /// Evaluates the lobes `more` also where the edited material does not need them: the picture is the same; [`LobeSet::all`] leaves nothing
    /// out. Leaves out the lobes `less` although it needs them.
    pub fn set_lobes(&mut self, more: LobeSet, less: LobeSet) {
        self.changed = [more, less];
        for drawn in &mut self.objects {
            drawn.lobes = lobes_of(&drawn.object, self.changed);
        }
        self.restart();
    }

    /// Compiles what the objects need and is not there yet, and waits for it; returns how long that took.
    pub fn compile(&mut self, device: &wgpu::Device) -> Result<Duration, PreviewError> {
        let start = Instant::now();
        for kind in self.objects.iter().map(Drawn::kind).collect::<Vec<_>>() {
            self.pipelines.for_lobes(device, kind, true)?;
        }
        Ok(start.elapsed())
    }
}

//! Pictures of what the window shows, written as they are, and what they say about how they were made.

use super::App;
use crate::export::{self, Picture};
use crate::files::texture_path;
use crate::live_denoise::DenoisedPicture;
use crate::live_final::{LiveFinal, SEED};
use crate::picture_job::{PictureJob, Place, Stop, Texture, folder_of};
use burnish_renderer::path::StopReason;
use burnish_renderer::worker::Snapshot;
use egui::Context;
use std::path::{Path, PathBuf};

/// A job whose files are still to be read.
pub(super) struct UnreadJob {
    job: PictureJob,
    places: [Option<Place>; 2],
    textures: Vec<(String, PathBuf)>,
}

impl UnreadJob {
    /// The job as the picture at `path` holds it. Reads all files of the scene, which may take its time.
    pub(super) fn finished(self, path: &Path) -> PictureJob {
        let folder = folder_of(path);
        let mut job = self.job;
        let [mesh, environment] = self.places.map(|place| place.map(|place| place.source(folder.as_deref())));
        (job.scene.mesh, job.scene.environment) = (mesh, environment);
        job.textures = self.textures.iter().map(|(name, path)| Texture::of_file(name, path, folder.as_deref())).collect();
        job
    }
}

impl App {
    /// Writes the picture that is shown, with what it was made from, on a thread of its own.
    pub(super) fn write_picture(&mut self, path: PathBuf, ctx: &Context) {
        let view = self.final_view.as_ref().filter(|_| self.has_final());
        let denoised = view.and_then(LiveFinal::denoised);
        let shown = denoised.map(|denoised| &denoised.raw).or_else(|| view.and_then(LiveFinal::newest));
        let (mut picture, job) = if let Some(snapshot) = shown {
            // A picture of before the last edit does not show what the document says.
            let is_current = view.and_then(LiveFinal::current).is_some_and(|current| current.revision == snapshot.revision);
            (final_picture(snapshot, denoised), self.job_of_final(snapshot, denoised, is_current))
        } else {
            match self.preview.read_linear() {
                Ok((width, height, pixels)) => {
                    let (width, height) = (width as usize, height as usize);
                    (Picture { width, height, pixels, ..Picture::default() }, self.job_of_preview([width, height]))
                }
                Err(problem) => {
                    self.messages.error(format!("The picture was not written: {problem}."));
                    return;
                }
            }
        };
        let (width, height) = (picture.width, picture.height);
        let note = denoised.map_or_else(String::new, |denoised| format!(". {}; the raw picture is kept", denoised.label()));
        self.pictures_to_write += 1;
        let (display, sender, ctx) = (self.editor.view.display, self.writer.clone(), ctx.clone());
        std::thread::spawn(move || {
            picture.job = Some(job.finished(&path).json());
            let result = export::write(&path, &picture, display)
                .map(|written| {
                    let names: Vec<String> = written.iter().map(|path| path.display().to_string()).collect();
                    format!("Wrote {} ({width} × {height}){note}", names.join(", "))
                })
                .map_err(|error| error.to_string());
            let _ = sender.send(result);
            ctx.request_repaint();
        });
    }

    /// The job of a picture of the final view; of material and scene only where it shows the present ones.
    pub(super) fn job_of_final(&self, raw: &Snapshot, denoised: Option<&DenoisedPicture>, is_current: bool) -> UnreadJob {
        let size = [raw.width, raw.height];
        let mut unread = if is_current { self.job_of(size) } else { nothing_of(size) };
        let job = &mut unread.job;
        job.seed = SEED;
        let stop = &self.editor.view.stop;
        job.stop = Stop { spp: stop.spp, seconds: stop.seconds, relmse: stop.relmse };
        // Coarse pictures, and those that have not a sample in every pixel yet, cannot be told by a number of samples.
        if raw.scale == 1 && raw.spp > 0 {
            job.samples = vec![u64::from(raw.spp) * (raw.width * raw.height) as u64];
        }
        job.denoiser = denoised.map(|denoised| denoised.denoiser.clone());
        job.denoise = denoised.map(|denoised| if denoised.denoiser == "burnish" { "burnish" } else { "oidn" }.to_owned());
        job.reach(raw.spp, raw.done.map(StopReason::word), raw.error.as_ref());
        unread
    }

    /// The job of a picture of the preview. Its samples are not counted, so it can be opened but not made again.
    pub(super) fn job_of_preview(&self, size: [usize; 2]) -> UnreadJob {
        let mut unread = self.job_of(size);
        unread.job.view = "preview".to_owned();
        unread.job.adaptive = false;
        unread.job.adapter = self.preview.adapter();
        unread
    }

    fn job_of(&self, [width, height]: [usize; 2]) -> UnreadJob {
        let (editor, mut unread) = (&self.editor, nothing_of([width, height]));
        let (job, document) = (&mut unread.job, &editor.document);
        if let Some(scene) = editor.scene(width as f32 / height.max(1) as f32) {
            job.scene.rotation_deg = scene.environment.rotation_deg;
            job.scene.camera = scene.camera.into();
            job.scene.max_bounces = scene.max_bounces;
            job.scene.replaces_material = true;
            job.scene.backdrop = editor.backdrop().map(|def| def.name.to_owned());
            job.scene.unit_mm = editor.model.as_ref().map(|model| model.unit_mm);
        }
        job.exposure_ev = editor.view.display.exposure_ev;
        job.display_transform = editor.view.display.transform.to_string();
        job.material = Some(document.file().to_text(&document.material));
        let file_of = |name: &String| Some((name.clone(), texture_path(name, document.folder())?));
        unread.textures = document.textures.keys().filter_map(file_of).collect();
        unread.places = editor.places.clone();
        unread
    }
}

/// A picture of the final view for a file; with a denoised one goes the raw one.
fn final_picture(raw: &Snapshot, denoised: Option<&DenoisedPicture>) -> Picture {
    Picture {
        width: raw.width,
        height: raw.height,
        pixels: denoised.map_or(&raw.pixels, |denoised| &denoised.picture.pixels).clone(),
        raw: denoised.map(|_| raw.pixels.clone()),
        ..Picture::default()
    }
}

fn nothing_of(size: [usize; 2]) -> UnreadJob {
    UnreadJob { job: PictureJob { size, ..PictureJob::new() }, places: [None, None], textures: Vec::new() }
}

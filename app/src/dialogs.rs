//! File dialogs of the system, behind a trait so that tests answer with paths of their own.
//!
//! A dialog never blocks the window: it is asked, and its answer polled.

use crate::exchange;
use crate::export::Format;
use burnish_material::Property;
use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender, channel};

/// Which of the materials that are compared or merged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Version {
    /// The first of two.
    DiffA,
    /// The second of two.
    DiffB,
    /// What two versions were made from.
    Base,
    /// The version whose text is kept.
    Mine,
    /// The other version.
    Theirs,
}

/// What a path is wanted for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// A material to open.
    OpenMaterial,
    /// Where to save the material.
    SaveMaterial,
    /// A folder of materials.
    OpenLibrary,
    /// A material to compare or merge.
    ChooseVersion(Version),
    /// The folder of an earlier release of the library.
    CompareRelease,
    /// Where to write the report of the check.
    SaveReport,
    /// Where to write what changed since a release.
    SaveNotes,
    /// A mesh to show.
    LoadModel,
    /// An environment map.
    LoadEnvironment,
    /// An image for a property.
    LoadTexture(Property),
    /// A folder of images for many properties.
    LoadTextureSet,
    /// A photo to look at.
    LoadReference,
    /// Where to write the picture, display-referred.
    SavePng,
    /// Where to write the picture, linear.
    SaveExr,
    /// Where to write a contact sheet of the library.
    SaveSheet,
    /// Where to make a pack of the library.
    SavePack,
    /// Where to write the material for other programs.
    ExportMaterial(exchange::Format),
    /// Where to write a picture that is to be rendered.
    RenderPicture(Format),
    /// Where else to write a picture that was rendered.
    WriteElsewhere(Format),
    /// Where to write the frames of a turntable.
    TurntableFolder,
}

impl Purpose {
    fn title(self) -> String {
        match self {
            Self::OpenMaterial => "Open material".into(),
            Self::SaveMaterial => "Save material".into(),
            Self::OpenLibrary => "Open the folder of a library".into(),
            Self::ChooseVersion(_) => "Choose a material".into(),
            Self::CompareRelease => "Choose the folder of an earlier release".into(),
            Self::SaveReport => "Save the report".into(),
            Self::SaveNotes => "Save the notes".into(),
            Self::LoadModel => "Load mesh".into(),
            Self::LoadEnvironment => "Load environment".into(),
            Self::LoadTexture(property) => format!("Choose a map for {}", property.def().label),
            Self::LoadTextureSet => "Choose the folder of a texture set".into(),
            Self::LoadReference => "Load reference image".into(),
            Self::SavePng | Self::SaveExr => "Save picture".into(),
            Self::SaveSheet => "Contact sheet of the library".into(),
            Self::SavePack => "Export pack: a folder that is not there yet".into(),
            Self::ExportMaterial(format) => format!("Export as {}", format.def().label),
            Self::RenderPicture(_) => "Render picture".into(),
            Self::WriteElsewhere(_) => "Write the picture elsewhere".into(),
            Self::TurntableFolder => "Choose the folder of the turntable".into(),
        }
    }

    fn filter(self) -> (&'static str, &'static [&'static str]) {
        match self {
            Self::OpenMaterial => ("Material", &["ron", "gltf", "glb", "mtlx", "usda", "usdz", "mdl", "mat", "json"]),
            Self::SaveMaterial | Self::OpenLibrary | Self::ChooseVersion(_) | Self::CompareRelease => ("Material", &["ron"]),
            Self::SaveReport => ("Report", &["json", "txt"]),
            Self::SaveNotes => ("Notes", &["md", "txt"]),
            Self::LoadModel => ("Mesh", &["gltf", "glb", "ply"]),
            Self::LoadEnvironment => ("Environment", &["hdr", "exr"]),
            Self::LoadTexture(_) | Self::LoadTextureSet | Self::LoadReference | Self::TurntableFolder => {
                ("Image", &["png", "jpg", "jpeg", "exr", "hdr"])
            }
            Self::SavePng | Self::RenderPicture(Format::Png) | Self::WriteElsewhere(Format::Png) => ("PNG", &["png"]),
            Self::SaveExr | Self::RenderPicture(Format::Exr) | Self::WriteElsewhere(Format::Exr) => ("OpenEXR", &["exr"]),
            Self::SaveSheet => ("Page or picture", &["html", "png"]),
            Self::SavePack => ("Folder", &["*"]),
            Self::ExportMaterial(format) => (format.def().label, format.def().endings),
        }
    }

    fn is_saving(self) -> bool {
        matches!(
            self,
            Self::SaveMaterial
                | Self::SavePng
                | Self::SaveExr
                | Self::SaveSheet
                | Self::SavePack
                | Self::ExportMaterial(_)
                | Self::SaveReport
                | Self::SaveNotes
                | Self::RenderPicture(_)
                | Self::WriteElsewhere(_)
        )
    }

    fn is_folder(self) -> bool {
        matches!(self, Self::OpenLibrary | Self::CompareRelease | Self::LoadTextureSet | Self::TurntableFolder)
    }
}

/// A question for a path.
#[derive(Clone, Debug)]
pub struct Question {
    /// What it is wanted for.
    pub purpose: Purpose,
    /// Where the dialog starts.
    pub folder: Option<PathBuf>,
    /// Name proposed when saving.
    pub file_name: String,
}

/// A path, or `None` when the user cancelled.
pub type Answer = (Purpose, Option<PathBuf>);

/// Asks the user for paths.
pub trait Dialogs {
    /// Puts a question; the answer comes later from [`Self::poll`].
    fn ask(&mut self, question: Question, ctx: &egui::Context);
    /// The next answer that has arrived.
    fn poll(&mut self) -> Option<Answer>;
}

/// The dialogs of the desktop.
pub struct SystemDialogs {
    sender: Sender<Answer>,
    receiver: Receiver<Answer>,
}

impl Default for SystemDialogs {
    fn default() -> Self {
        let (sender, receiver) = channel();
        Self { sender, receiver }
    }
}

impl Dialogs for SystemDialogs {
    fn ask(&mut self, question: Question, ctx: &egui::Context) {
        let purpose = question.purpose;
        let (name, extensions) = purpose.filter();
        let mut dialog = rfd::AsyncFileDialog::new().set_title(purpose.title()).add_filter(name, extensions);
        if let Some(folder) = question.folder {
            dialog = dialog.set_directory(folder);
        }
        if !question.file_name.is_empty() {
            dialog = dialog.set_file_name(question.file_name);
        }
        // Some systems insist that dialogs are made on the window's thread; waiting may happen anywhere.
        let (sender, ctx) = (self.sender.clone(), ctx.clone());
        let wait = move |path: Option<rfd::FileHandle>| {
            let _ = sender.send((purpose, path.map(|file| file.path().to_path_buf())));
            ctx.request_repaint();
        };
        if purpose.is_saving() {
            let future = dialog.save_file();
            std::thread::spawn(move || wait(pollster::block_on(future)));
        } else if purpose.is_folder() {
            let future = dialog.pick_folder();
            std::thread::spawn(move || wait(pollster::block_on(future)));
        } else {
            let future = dialog.pick_file();
            std::thread::spawn(move || wait(pollster::block_on(future)));
        }
    }

    fn poll(&mut self) -> Option<Answer> {
        self.receiver.try_recv().ok()
    }
}

/// Answers prepared in advance, for tests: each question takes the next one.
#[derive(Default)]
pub struct PreparedDialogs {
    /// Paths to answer with, first come first served; an empty list cancels.
    pub paths: VecDeque<PathBuf>,
    answers: VecDeque<Answer>,
}

impl PreparedDialogs {
    /// Answers with these paths in turn.
    pub fn new(paths: impl IntoIterator<Item = PathBuf>) -> Self {
        Self { paths: paths.into_iter().collect(), answers: VecDeque::new() }
    }
}

impl Dialogs for PreparedDialogs {
    fn ask(&mut self, question: Question, ctx: &egui::Context) {
        self.answers.push_back((question.purpose, self.paths.pop_front()));
        ctx.request_repaint();
    }

    fn poll(&mut self) -> Option<Answer> {
        self.answers.pop_front()
    }
}

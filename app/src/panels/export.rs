//! Pictures to give away: one, or a series around the object; what they hold, when they end, and how far they are.

mod bar;
pub mod picture;
pub mod turntable;

use crate::export::Format;
use crate::live_export::Row;
use crate::offline::picture::View;
use crate::offline::picture_options::PictureOptions;
use crate::offline::turntable::{Prediction, Turn};
use crate::theme;
use crate::work::Work;
use burnish_renderer::path::StopRules;
use burnish_renderer::tonemap::Display;
use egui::{Button, Grid, Label, RichText, ScrollArea, Ui, vec2};
use std::path::PathBuf;

/// Longest side of a picture, pixels.
pub const MAX_SIDE: usize = 8192;

/// What is to be made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kind {
    /// One picture.
    #[default]
    Picture,
    /// A series around the object.
    Turntable,
}

/// What the panel asks of the application.
#[derive(Clone, Debug, PartialEq)]
pub enum ExportAction {
    /// Choose a file and render into it.
    Render,
    /// Choose the folder of the turntable.
    ChooseFolder,
    /// Tell how long the turntable will take.
    Predict,
    /// Render the frames of the turntable that are due.
    Start,
    /// Choose another file for a picture that could not be written.
    WriteElsewhere,
    /// Give that picture up.
    Discard,
    /// End what is being made.
    Cancel,
    /// Give up what waits under this number.
    Remove(u64),
}

/// What waits until what comes before it is made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Queued {
    /// Tells it from all others.
    pub number: u64,
    /// What it is about.
    pub text: String,
    /// The file or folder that it writes into.
    pub target: PathBuf,
}

/// What is set in the panel, and what it shows of the last turntable.
pub struct ExportPanel {
    /// What is to be made.
    pub kind: Kind,
    /// Columns and rows; `None`: as the view.
    pub size: Option<[usize; 2]>,
    /// Whether the rows follow the columns, and the other way round.
    pub keeps_proportions: bool,
    /// Which renderer draws a picture.
    pub view: View,
    /// Format of the files.
    pub format: Format,
    /// What the pictures hold. The display transform is that of the view.
    pub options: PictureOptions,
    /// What ends a picture.
    pub stop: StopRules,
    /// Seconds after which a picture of the preview ends, if it changes still.
    pub preview_seconds: Option<f64>,
    /// What ends a frame of a turntable.
    pub frame_stop: StopRules,
    /// Frames of a turntable.
    pub frames: u32,
    /// What turns.
    pub turn: Turn,
    /// How far all frames together turn.
    pub degrees: f64,
    /// Folder of the turntable.
    pub folder: Option<PathBuf>,
    /// How long its frames that are due will take, and how many they are.
    pub prediction: Option<(Prediction, usize)>,
    /// Its frames.
    pub rows: Vec<Row>,
    /// Whether a picture was rendered but could not be written.
    pub has_unwritten: bool,
    /// The picture that was written last, and what was told of it.
    pub last: Option<(PathBuf, String)>,
}

impl Default for ExportPanel {
    fn default() -> Self {
        Self {
            kind: Kind::Picture,
            size: None,
            keeps_proportions: true,
            view: View::Final,
            format: Format::Png,
            options: PictureOptions::default(),
            stop: StopRules { spp: None, seconds: Some(600.0), relmse: Some(0.01 * 0.01) },
            preview_seconds: Some(60.0),
            frame_stop: StopRules { spp: None, seconds: Some(90.0), relmse: Some(0.01 * 0.01) },
            frames: 120,
            turn: Turn::Object,
            degrees: 360.0,
            folder: None,
            prediction: None,
            rows: Vec::new(),
            has_unwritten: false,
            last: None,
        }
    }
}

/// What the panel knows besides its settings.
pub struct Around<'a> {
    /// Columns and rows of a picture of the view.
    pub view_size: [usize; 2],
    /// Exposure and display transform, as in the view.
    pub display: &'a mut Display,
    /// Whether there is a preview to be drawn.
    pub has_preview: bool,
    /// What is being made, as the list of work shows it.
    pub work: Option<Work>,
    /// Whether it was ended and only has to come to its next seam.
    pub is_ending: bool,
    /// What comes after it.
    pub queue: Vec<Queued>,
}

impl ExportPanel {
    /// Columns and rows of the picture.
    pub fn size(&self, view_size: [usize; 2]) -> [usize; 2] {
        self.size.unwrap_or(view_size)
    }

    /// Shows the panel.
    pub fn show(&mut self, ui: &mut Ui, mut around: Around<'_>) -> Option<ExportAction> {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 2.0;
            for (kind, text) in [(Kind::Picture, "Picture"), (Kind::Turntable, "Turntable")] {
                if ui.add(Button::selectable(self.kind == kind, text).min_size(vec2(96.0, 0.0))).clicked() {
                    self.kind = kind;
                }
            }
        });
        let mut action = None;
        egui::Panel::bottom("export bar").frame(egui::Frame::new()).show_separator_line(false).show(ui, |ui| {
            action = self.bar(ui, &around);
        });
        ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| match self.kind {
            Kind::Picture => self.picture(ui, &mut around),
            Kind::Turntable => action = self.turntable(ui, &mut around).or(action.take()),
        });
        action
    }
}

/// Rows of a name and what is set, under a title.
fn section(ui: &mut Ui, title: &str, content: impl FnOnce(&mut Ui)) {
    heading(ui, title);
    let width = 92.0 * theme::text_scale(ui);
    Grid::new(title).num_columns(2).spacing(vec2(8.0, 4.0)).min_col_width(width).show(ui, content);
}

fn heading(ui: &mut Ui, title: &str) {
    ui.add_space(4.0);
    ui.label(RichText::new(title).strong().color(theme::now().strong));
}

fn row(ui: &mut Ui, name: &str, content: impl FnOnce(&mut Ui)) {
    ui.label(name);
    ui.horizontal(content);
    ui.end_row();
}

/// A sentence that explains what stands above.
fn note(ui: &mut Ui, text: &str) {
    ui.add(Label::new(RichText::new(text).small().color(theme::now().weak)).wrap());
}

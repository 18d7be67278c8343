//! What is always in sight below the settings: what is being made, what waits for its turn, and the buttons that begin something.

use super::{Around, ExportAction, ExportPanel, Kind, Queued, picture, turntable};
use crate::theme;
use egui::{Button, Label, ProgressBar, RichText, ScrollArea, Ui, vec2};

/// Rows of the queue that are seen at once.
const ROWS: usize = 4;

impl ExportPanel {
    /// The bar; what the user wants.
    pub(super) fn bar(&mut self, ui: &mut Ui, around: &Around<'_>) -> Option<ExportAction> {
        ui.add_space(3.0);
        let mut action = work(ui, around);
        action = queue(ui, &around.queue).or(action);
        if self.has_unwritten && around.work.is_none() {
            return unwritten(ui, !around.queue.is_empty()).or(action);
        }
        action = self.buttons(ui, around).or(action);
        if let (Kind::Picture, None, Some((path, text))) = (self.kind, &around.work, &self.last) {
            picture::last(ui, path, text);
        }
        ui.add_space(3.0);
        action
    }

    /// The buttons that begin something, or put it behind what is being made.
    fn buttons(&self, ui: &mut Ui, around: &Around<'_>) -> Option<ExportAction> {
        let mut action = None;
        let problem = self.problem(around);
        if let Some(problem) = &problem {
            ui.add(Label::new(RichText::new(format!("⚠ {problem}")).small().color(theme::now().warning)).wrap());
        }
        let is_busy = around.work.is_some();
        ui.horizontal(|ui| {
            let mut button = |ui: &mut Ui, button: Button<'_>, is_possible: bool, hint: &str, what: ExportAction| {
                let button = ui.add_enabled(problem.is_none() && is_possible, button);
                if button.on_hover_text(hint).on_disabled_hover_text(hint).clicked() {
                    action = Some(what);
                }
            };
            let size = vec2(120.0, 1.2 * ui.spacing().interact_size.y);
            let main = |text: String| Button::new(text).min_size(size).fill(theme::now().selection);
            let later = "Made as everything is set now, when what is before it is done";
            match self.kind {
                Kind::Picture if is_busy => button(ui, main("Add to queue…".to_owned()), true, later, ExportAction::Render),
                Kind::Picture => {
                    let hint = "Choose a file; it is rendered in the background";
                    button(ui, main("Render to file…".to_owned()), true, hint, ExportAction::Render);
                }
                Kind::Turntable => {
                    let hint =
                        "Render five frames a little, to tell how long all will take; not while something else is rendered";
                    let predict = Button::new("Predict").min_size(vec2(80.0, size.y));
                    button(ui, predict, !is_busy, hint, ExportAction::Predict);
                    let hint = "Render the frames in the background, one after the other";
                    let (text, hint) = match is_busy {
                        true => ("Add to queue".to_owned(), format!("{}. {later}", self.start_text())),
                        false => (self.start_text(), hint.to_owned()),
                    };
                    button(ui, main(text), true, &hint, ExportAction::Start);
                }
            }
        });
        action
    }
}

/// What is being made, and how far it is.
fn work(ui: &mut Ui, around: &Around<'_>) -> Option<ExportAction> {
    let work = around.work.as_ref()?;
    let mut action = None;
    ui.horizontal(|ui| {
        let text = if around.is_ending { "Ending…" } else { "Cancel" };
        let cancel = ui.add_enabled(!around.is_ending, Button::new(text)).accessible_name("Cancel rendering");
        if cancel.on_hover_text("Ends it; a turntable goes on from there later").clicked() {
            action = Some(ExportAction::Cancel);
        }
        ui.add(Label::new(RichText::new(&work.text).small()).truncate());
    });
    ui.add(ProgressBar::new(work.progress.unwrap_or(0.0)).desired_height(4.0));
    let left = work.remaining.map_or_else(
        || "The time that is left is not known yet".to_owned(),
        |left| format!("about {} left", turntable::duration(left)),
    );
    ui.label(RichText::new(left).small().color(theme::now().weak));
    action
}

/// What waits, each with a button that gives it up.
fn queue(ui: &mut Ui, queue: &[Queued]) -> Option<ExportAction> {
    if queue.is_empty() {
        return None;
    }
    let mut action = None;
    ui.label(RichText::new(format!("Queue: {}", queue.len())).small().color(theme::now().strong));
    let height = ui.spacing().interact_size.y;
    let shown = (height + ui.spacing().item_spacing.y) * queue.len().min(ROWS) as f32;
    let area = ScrollArea::vertical().id_salt("queue").max_height(shown).auto_shrink([false, true]);
    area.show_rows(ui, height, queue.len(), |ui, range| {
        for Queued { number, text, target } in range.filter_map(|place| queue.get(place)) {
            ui.horizontal(|ui| {
                let remove = ui.small_button("×").on_hover_text("Give it up");
                if remove.accessible_name(format!("Remove {text} from the queue")).clicked() {
                    action = Some(ExportAction::Remove(*number));
                }
                let label = ui.add(Label::new(RichText::new(text).small()).truncate());
                label.on_hover_text(target.display().to_string());
            });
        }
    });
    action
}

/// What becomes of a picture that could not be written.
fn unwritten(ui: &mut Ui, is_waited_for: bool) -> Option<ExportAction> {
    let mut action = None;
    let wait = if is_waited_for { " The queue goes on after that." } else { "" };
    let text = RichText::new(format!("⚠ A rendered picture could not be written.{wait}")).color(theme::now().warning);
    ui.add(Label::new(text).wrap());
    ui.horizontal(|ui| {
        for (text, what) in [("Write elsewhere…", ExportAction::WriteElsewhere), ("Discard it", ExportAction::Discard)] {
            if ui.button(text).clicked() {
                action = Some(what);
            }
        }
    });
    action
}

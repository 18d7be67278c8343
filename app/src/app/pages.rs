//! The pages over the window, and what is chosen in them.

use super::App;
use crate::dock::Pane;
use crate::loading::Job;
use crate::pages::Page;
use crate::panels::help;
use crate::panels::palette::{self, Choice};
use crate::panels::{preferences, property_page};
use egui::{Context, Id, Key, Modal, Modifiers, RichText, Window};
use std::time::SystemTime;

impl App {
    /// Shows the open page and the questions that wait.
    pub(super) fn show_pages(&mut self, ctx: &Context) {
        self.ask_about_change(ctx);
        let Some(page) = self.pages.page() else { return };
        match page {
            Page::Palette => self.palette(ctx),
            Page::Recent => self.recent_page(ctx),
            Page::Recovery => self.recovery_page(ctx),
            Page::BatchEdit | Page::Rename | Page::Measured => {
                let (title, size) = match page {
                    Page::BatchEdit => ("Edit materials", [430.0, 290.0]),
                    Page::Rename => ("Rename", [400.0, 150.0]),
                    _ => ("New from measured", [560.0, 520.0]),
                };
                let mut stays = true;
                let is_open = framed(ctx, title, size, |ui| {
                    stays = match page {
                        Page::BatchEdit => self.batch_page(ui),
                        Page::Rename => self.rename_page(ui),
                        _ => self.measured_page(ui),
                    };
                });
                self.close_unless(is_open && stays && !self.is_escaped(ctx));
            }
            Page::Exchange => {
                let mut stays = true;
                let is_open = framed(ctx, "Export material", [640.0, 460.0], |ui| stays = self.exchange_page(ui));
                self.close_unless(is_open && stays && !self.is_escaped(ctx));
            }
            Page::Pack => {
                let mut stays = true;
                let is_open = framed(ctx, "Export pack", [440.0, 230.0], |ui| stays = self.pack_page(ui));
                self.close_unless(is_open && stays && !self.is_escaped(ctx));
            }
            Page::Preferences => {
                let is_open = framed(ctx, "Preferences", [520.0, 560.0], |ui| {
                    preferences::show(ui, &mut self.preferences, &mut self.keymap, &mut self.pages.recording);
                });
                self.close_unless(is_open && !self.is_escaped(ctx));
            }
            Page::Help => {
                let is_open =
                    framed(ctx, "Keys and mouse", [620.0, 560.0], |ui| help::show(ui, &self.keymap, self.preferences.mouse));
                self.close_unless(is_open && !self.is_escaped(ctx));
            }
            Page::Textures(property) => {
                let title = format!("{}: built-in textures", property.def().label);
                let mut used = None;
                let is_open = framed(ctx, &title, [560.0, 520.0], |ui| {
                    used = self.textures.show(ui, &self.editor.document.material, &mut self.small);
                });
                if let Some(path) = used {
                    self.loader.start(Job::BuiltInTexture(self.tabs.front_id(), property, path), ctx);
                }
                self.close_unless(is_open && !self.is_escaped(ctx));
            }
            Page::Reference(property) => {
                let title = format!("{}: reference", property.def().label);
                let material = &self.editor.document.material;
                let is_open = framed(ctx, &title, [480.0, 460.0], |ui| property_page::show(ui, property, material));
                self.close_unless(is_open && !self.is_escaped(ctx));
            }
        }
    }

    fn close_unless(&mut self, is_open: bool) {
        if !is_open {
            self.pages.close();
        }
    }

    fn is_escaped(&self, ctx: &Context) -> bool {
        self.pages.recording.is_none()
            && !ctx.text_edit_focused()
            && ctx.input_mut(|i| i.consume_key(Modifiers::NONE, Key::Escape))
    }

    fn palette(&mut self, ctx: &Context) {
        let possible = |command| self.is_possible(command);
        let found = palette::find(&self.pages.search, &self.keymap, possible);
        let (chosen, should_close) =
            palette::show(ctx, "Find a command", "Type a command, a property or a preset", &mut self.pages, &found);
        if should_close || chosen.is_some() {
            self.pages.close();
        }
        match chosen.map(|index| found[index].choice.clone()) {
            Some(Choice::Command(command)) => self.carry_out(command, ctx),
            Some(Choice::Property(property)) => {
                if !self.dock.is_drawn(Pane::Properties) {
                    self.dock.set_shown(Pane::Properties, true);
                }
                self.editor.view.are_panels_shown = true;
                self.properties.go_to(property);
            }
            Some(Choice::Preset(preset)) => self.load_preset(preset, ctx),
            Some(Choice::File(_)) | None => {}
        }
    }

    fn recent_page(&mut self, ctx: &Context) {
        let paths = self.keeping.recent().to_vec();
        let missing: Vec<bool> = paths.iter().map(|path| self.keeping.is_missing(path)).collect();
        let found = palette::find_files(&self.pages.search, &paths, &missing);
        let (chosen, should_close) = palette::show(ctx, "Open recent", "Type a part of the name", &mut self.pages, &found);
        if should_close || chosen.is_some() {
            self.pages.close();
        }
        if let Some(Choice::File(path)) = chosen.map(|index| found[index].choice.clone()) {
            self.load_path(&path, ctx);
        }
    }

    fn recovery_page(&mut self, ctx: &Context) {
        let answers = [("Bring back", ""), ("Throw away", ""), ("Ask again next time", "")];
        let answer = question(ctx, "Unsaved work from last time", &answers, |ui| {
            ui.label("Burnish ended without saving these:");
            for kept in self.keeping.left.iter().flat_map(crate::recovery::Abandoned::documents) {
                let age = SystemTime::now().duration_since(kept.when).map_or(0.0, |age| age.as_secs_f64());
                let place = kept.path.as_ref().map_or_else(|| "not saved yet".to_owned(), |path| path.display().to_string());
                ui.label(format!("• {}: as it was {} ago", kept.title, crate::panels::chart::duration(age.max(1.0))));
                ui.label(RichText::new(format!("   {place}")).small().weak());
            }
        });
        match answer {
            Answer::Waiting => return,
            Answer::Chosen(0) => self.take_left(true, ctx),
            Answer::Chosen(1) => self.take_left(false, ctx),
            Answer::Chosen(_) | Answer::None => {}
        }
        self.pages.close();
    }

    fn ask_about_change(&mut self, ctx: &Context) {
        let Some(change) = self.pages.change().cloned() else { return };
        let answers = [("Reload", ""), ("Compare", "Show both beside each other; nothing is changed"), ("Keep what is here", "")];
        let answer = question(ctx, "Changed by another program", &answers, |ui| {
            ui.label(format!("“{}” is not any more what is on disk:", change.title));
            ui.label(RichText::new(change.path.display().to_string()).small().weak());
            if change.is_modified {
                ui.label("It has changes here as well; reloading is one step that undo takes back.");
            }
        });
        match answer {
            Answer::Waiting => return,
            Answer::Chosen(0) => self.loader.start(Job::Reload(change.id, change.path), ctx),
            Answer::Chosen(1) => {
                if let Some(place) = self.tabs.place_of(change.id) {
                    self.with_front(|tabs, front| tabs.bring_to_front(place, front));
                }
                self.loader.start(Job::Compare(change.id, change.path), ctx);
            }
            Answer::Chosen(_) | Answer::None => {}
        }
        self.pages.take_change();
    }
}

/// What came of a question.
pub(super) enum Answer {
    /// Nothing yet.
    Waiting,
    /// The answer of this place.
    Chosen(usize),
    /// It was closed without one.
    None,
}

/// Asks over the whole window; each answer is a button with a tooltip, which may be empty.
pub(super) fn question(ctx: &Context, title: &str, answers: &[(&str, &str)], body: impl FnOnce(&mut egui::Ui)) -> Answer {
    let response = Modal::new(Id::unique("question").with(title)).show(ctx, |ui| {
        ui.set_width(400.0);
        ui.heading(title);
        ui.add_space(4.0);
        body(ui);
        ui.add_space(10.0);
        let mut chosen = None;
        ui.horizontal(|ui| {
            for (index, (text, tip)) in answers.iter().enumerate() {
                let button = ui.button(*text);
                let button = if tip.is_empty() { button } else { button.on_hover_text(*tip) };
                if button.clicked() {
                    chosen = Some(index);
                }
            }
        });
        chosen
    });
    match response.inner {
        Some(index) => Answer::Chosen(index),
        None if response.should_close() => Answer::None,
        None => Answer::Waiting,
    }
}

/// A window of its own within the window; whether it is still open.
fn framed(ctx: &Context, title: &str, size: [f32; 2], content: impl FnOnce(&mut egui::Ui)) -> bool {
    let mut is_open = true;
    let room = ctx.content_rect().size() - egui::vec2(40.0, 60.0);
    Window::new(title)
        .open(&mut is_open)
        .collapsible(false)
        .default_size(size)
        .max_size(room)
        .default_pos(ctx.content_rect().center() - 0.5 * egui::Vec2::from(size))
        .show(ctx, |ui| {
            egui::ScrollArea::vertical().auto_shrink([false, false]).show(ui, content);
        });
    is_open
}

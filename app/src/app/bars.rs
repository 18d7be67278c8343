//! The menu bar with the open documents, and the status line.

use super::App;
use crate::command::{COMMANDS, Command, Menu};
use crate::panels::{status, viewport};
use crate::theme;
use egui::{Button, Frame, Label, Margin, Panel, RichText, Role, ScrollArea, Sense, Ui, WidgetInfo, vec2};

impl App {
    /// The frame of the window: bars above and below, and between them the panels.
    pub(super) fn panels(&mut self, ui: &mut Ui) {
        let bar = |margin| Frame::new().fill(theme::now().bar).inner_margin(margin);
        Panel::top("menu").frame(bar(Margin::symmetric(6, 3))).show(ui, |ui| self.menu_bar(ui));
        let height = ui.spacing().interact_size.y + 4.0;
        Panel::bottom("status").exact_size(height).frame(bar(Margin::symmetric(9, 0))).show(ui, |ui| {
            let status = self.status();
            if let Some(ends) = status::show(ui, &status) {
                let ctx = ui.ctx().clone();
                self.end_work(ends, &ctx);
            }
        });
        self.panes(ui);
    }

    fn menu_bar(&mut self, ui: &mut Ui) {
        egui::MenuBar::new().ui(ui, |ui| {
            for (menu, title) in Menu::ALL {
                ui.menu_button(title, |ui| {
                    ui.set_min_width(250.0);
                    for def in COMMANDS.iter().filter(|def| def.menu == menu) {
                        if def.starts_section {
                            ui.separator();
                        }
                        self.menu_item(ui, def.command);
                        if def.command == Command::OpenRecent {
                            self.recent_menu(ui);
                        }
                    }
                    if menu == Menu::View {
                        ui.separator();
                        self.bookmark_menu(ui);
                        ui.menu_button("Final view stops at", |ui| viewport::stop_rules(ui, &mut self.editor.view.stop, ""));
                    }
                });
            }
            ui.separator();
            self.tab_row(ui);
        });
    }

    fn menu_item(&mut self, ui: &mut Ui, command: Command) {
        let mut text = command.text().to_owned();
        match command {
            Command::Undo => text = self.undo_label().map_or(text.clone(), |label| format!("{text}: {label}")),
            Command::Redo => text = self.redo_label().map_or(text.clone(), |label| format!("{text}: {label}")),
            _ => {}
        }
        let keys = self.keymap.shown(command);
        let button = Button::new(text).shortcut_text(keys).selected(self.is_on(command));
        let response = ui.add_enabled(self.is_possible(command), button).on_hover_text(command.tooltip());
        if response.clicked() {
            let ctx = ui.ctx().clone();
            self.carry_out(command, &ctx);
            ui.close();
        }
    }

    fn recent_menu(&mut self, ui: &mut Ui) {
        let paths: Vec<std::path::PathBuf> = self.keeping.recent().iter().take(8).cloned().collect();
        for path in paths {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let is_missing = self.keeping.is_missing(&path);
            let text = if is_missing { format!("    ⚠ {name}") } else { format!("    {name}") };
            let missing = if is_missing { "\nThis file is not there." } else { "" };
            if ui.button(text).on_hover_text(format!("{}{missing}", path.display())).clicked() {
                let ctx = ui.ctx().clone();
                self.load_path(&path, &ctx);
                ui.close();
            }
        }
    }

    fn bookmark_menu(&mut self, ui: &mut Ui) {
        let count = self.editor.view.bookmarks.len();
        ui.add_enabled_ui(count > 0, |ui| {
            ui.menu_button("Camera bookmarks", |ui| {
                let mut removed = None;
                for (index, orbit) in self.editor.view.bookmarks.clone().into_iter().enumerate() {
                    ui.horizontal(|ui| {
                        let text = format!("{}: {:.0}°, {:.0}°", index + 1, orbit.azimuth_deg, orbit.elevation_deg);
                        if ui.button(text).clicked() {
                            self.editor.view.orbit = orbit;
                            ui.close();
                        }
                        let remove = ui.small_button("×").on_hover_text("Forget this bookmark");
                        if remove.accessible_name(format!("Forget bookmark {}", index + 1)).clicked() {
                            removed = Some(index);
                        }
                    });
                }
                if let Some(index) = removed {
                    self.editor.view.bookmarks.remove(index);
                }
            });
        });
    }

    /// The open documents; a mark tells which have unsaved changes.
    fn tab_row(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        let front = self.tabs.front();
        let documents: Vec<(String, bool, String)> = self
            .tabs
            .documents(&self.editor.document)
            .map(|(_, document)| {
                let place = match (document.path(), document.import()) {
                    (Some(path), _) => path.display().to_string(),
                    (None, Some(path)) => format!("of {}, not saved yet", path.display()),
                    (None, None) => "not saved yet".into(),
                };
                (document.title(), document.is_modified(), place)
            })
            .collect();
        let (mut chosen, mut closed) = (None, None);
        ScrollArea::horizontal()
            .auto_shrink([false, true])
            .scroll_bar_visibility(egui::scroll_area::ScrollBarVisibility::AlwaysHidden)
            .show(ui, |ui| {
                ui.horizontal(|ui| {
                    ui.spacing_mut().item_spacing.x = 3.0;
                    for (place, (title, is_modified, path)) in documents.iter().enumerate() {
                        let mark = if *is_modified { " •" } else { "" };
                        let text: String = if title.chars().count() > 28 {
                            title.chars().take(27).chain(['…']).collect()
                        } else {
                            title.clone()
                        };
                        let tab = ui.add(Button::selectable(place == front, format!("{text}{mark}")));
                        tab.widget_info(|| {
                            let state = if *is_modified { ", unsaved changes" } else { "" };
                            WidgetInfo::selected(Role::Tab, true, place == front, format!("{title}{state}"))
                        });
                        let tab = tab.on_hover_text(if *is_modified { format!("{path}\nunsaved changes") } else { path.clone() });
                        if tab.clicked() {
                            chosen = Some(place);
                        }
                        let close = ui.add(Button::new("×").frame_when_inactive(false).min_size(vec2(16.0, 16.0)));
                        if close.accessible_name(format!("Close {title}")).clicked() || tab.middle_clicked() {
                            closed = Some(place);
                        }
                    }
                    let new = ui.add(Button::new("+").frame_when_inactive(false));
                    if new.accessible_name("New tab").on_hover_text(Command::New.tooltip()).clicked() {
                        self.carry_out(Command::New, &ctx);
                    }
                    let note = Label::new(RichText::new(self.file_note()).small().color(theme::now().weak))
                        .truncate()
                        .sense(Sense::hover());
                    ui.add(note);
                });
            });
        if let Some(place) = chosen.or(closed) {
            self.with_front(|tabs, front| tabs.bring_to_front(place, front));
        }
        if closed.is_some() {
            self.carry_out(Command::CloseTab, &ctx);
        }
    }

    /// What kind of file is in front, and what was kept of it.
    fn file_note(&self) -> String {
        let document = &self.editor.document;
        if document.path().is_none() {
            return String::new();
        }
        let set = document.material.slots().filter(|(_, slot)| **slot != burnish_material::Slot::default()).count();
        let unknown = document.file().unknown_keys().len();
        let kept = if unknown > 0 { format!(", {unknown} unknown kept") } else { String::new() };
        format!("  ASM material, {set} of {} properties set{kept}", burnish_material::PROPERTY_COUNT)
    }
}

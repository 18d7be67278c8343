//! The one place where edits leave the document: history, preview and final view are told, in this order.

use super::App;
use crate::editor::{Document, ViewMode};
use crate::live_final::LiveFinal;
use crate::live_preview::LivePreview;
use crate::widgets::gesture;
use burnish_assets::Environment;
use burnish_material::Material;
use burnish_renderer::path::{StopRules, unsupported};
use burnish_renderer::scene::{Camera, ModelMeshes};
use std::sync::Arc;

/// What the renderers were told last.
pub(super) struct Sent {
    document: Document,
    /// The stored side, while it is shown.
    side: Option<Arc<Material>>,
    model: Arc<ModelMeshes>,
    environment: Arc<Environment>,
    camera: Camera,
    environment_deg: f32,
    /// Size of the final picture if one is wanted, and when it stops.
    final_request: Option<((usize, usize), StopRules)>,
}

impl Sent {
    fn is_same_place(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.model, &other.model)
            && Arc::ptr_eq(&self.environment, &other.environment)
            && self.camera == other.camera
            && self.environment_deg == other.environment_deg
    }

    fn is_same_scene(&self, other: &Self) -> bool {
        self.document.material == other.document.material
            && Arc::ptr_eq(&self.document.textures, &other.document.textures)
            && self.is_same_place(other)
    }
}

impl App {
    /// Whether two pictures are the two sides of the document, and not the two renderers.
    pub(super) fn is_comparing(&self) -> bool {
        let view = &self.editor.view;
        view.compares_sides && self.sides.stored().is_some() && matches!(view.mode, ViewMode::Both | ViewMode::Wipe)
    }

    /// Whether the view is drawn, and not behind another tab.
    pub(super) fn is_view_seen(&self) -> bool {
        self.view_rect != egui::Rect::NOTHING
    }

    /// Whether the path tracer's picture is visible where the view is.
    pub(super) fn has_final(&self) -> bool {
        self.editor.view.mode.has_final() && !self.is_comparing()
    }

    /// Tells everybody what changed in this frame.
    pub(super) fn sync(&mut self, ctx: &egui::Context) {
        if gesture::take_cancel(ctx) {
            self.editor.document.material = self.history.cancel().clone();
        }
        let wants_final = self.has_final() && self.is_view_seen();
        let aspect = self.picture_size.0 as f32 / self.picture_size.1 as f32;
        if let (Some(model), Some(environment)) = (self.editor.model.clone(), self.editor.environment.clone()) {
            let now = Sent {
                document: self.editor.document.clone(),
                side: self.sides.stored().filter(|_| self.is_comparing()).map(|side| side.material.clone()),
                model,
                environment,
                camera: self.editor.view.orbit.camera(aspect),
                environment_deg: self.editor.view.environment_deg,
                final_request: wants_final.then_some((self.picture_size, self.editor.view.stop)),
            };
            let (is_edited, is_changed, is_asked, is_side) = match &self.sent {
                Some(sent) => (
                    sent.document.material != now.document.material,
                    !now.is_same_scene(sent),
                    now.final_request != sent.final_request,
                    !now.is_same_place(sent) || now.side.as_ref().map(Arc::as_ptr) != sent.side.as_ref().map(Arc::as_ptr),
                ),
                None => (true, true, true, true),
            };
            if is_side {
                self.send_side(aspect);
            }
            if is_edited || is_changed || is_asked {
                if is_edited {
                    self.history.feed(&self.editor.document);
                }
                if let Some(scene) = self.editor.scene(aspect).map(Arc::new) {
                    if is_changed {
                        self.revision += 1;
                        self.preview.set_scene(&scene);
                    }
                    if wants_final {
                        self.left_out = unsupported(&scene);
                        let view = self.final_view.get_or_insert_with(|| LiveFinal::new(ctx, self.preferences.threads));
                        view.request(scene, self.picture_size, &self.editor.view);
                    }
                }
                if !wants_final && let Some(view) = &mut self.final_view {
                    view.pause();
                }
            }
            if is_edited || is_changed || is_asked || is_side {
                self.sent = Some(now);
            }
        } else if !self.history.holds(&self.editor.document) {
            // The first scene is still being made: nothing is drawn yet, but nothing is lost either.
            self.history.feed(&self.editor.document);
        }

        // A gesture ends when the mouse is up and no text is being typed, or where a field says so.
        let is_resting = !ctx.input(|i| i.pointer.any_down()) && !ctx.text_edit_focused();
        if gesture::take_end(ctx) || is_resting {
            self.history.settle();
        }
    }

    /// Tells the preview of the stored side, which exists only while it is shown.
    fn send_side(&mut self, aspect: f32) {
        let Some(side) = self.sides.stored().filter(|_| self.is_comparing()) else {
            self.side_preview = None;
            return;
        };
        let Some(scene) = self.editor.scene_of(side.material.clone(), side.textures.clone(), aspect) else { return };
        let preview = self.side_preview.get_or_insert_with(|| LivePreview::new(self.render_state.as_ref()));
        preview.set_scene(&scene);
    }
}

//! Every named action: its text, tooltip and shortcut in one list, which menu, keys and buttons read.
//!
//! What a command does is one `match`, in `app.rs`.

use egui::{Key, KeyboardShortcut, Modifiers};

/// A named action.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Command {
    /// A new material.
    New,
    /// Open a material file.
    Open,
    /// Save to the same file.
    Save,
    /// Save to another file.
    SaveAs,
    /// Load a mesh.
    LoadModel,
    /// Load an environment map.
    LoadEnvironment,
    /// Write the picture as PNG.
    SavePng,
    /// Write the picture as EXR.
    SaveExr,
    /// Close the window.
    Quit,
    /// Take one step back.
    Undo,
    /// Make one step again.
    Redo,
    /// All properties to their defaults.
    ResetAll,
    /// Switch between preview and final view.
    ToggleFinal,
    /// Show the preview alone.
    ShowPreview,
    /// Show the final view alone.
    ShowFinal,
    /// Show both side by side.
    ShowBoth,
    /// Show both in one picture, with a line between them.
    ShowWipe,
    /// Show how far both are apart.
    ShowDifference,
    /// Fill the picture with the object.
    Frame,
    /// Camera, light and exposure as at first.
    ResetView,
    /// One third of a stop brighter.
    ExposureUp,
    /// One third of a stop darker.
    ExposureDown,
    /// Show the final view denoised or raw.
    ToggleDenoise,
    /// Switches the preview's bloom on or off.
    ToggleBloom,
    /// Show or hide the side panels.
    TogglePanels,
    /// Show or hide the error chart.
    ToggleChart,
    /// Shows or hides the stability report.
    ToggleStability,
}

/// A menu of the menu bar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Menu {
    /// Documents and files.
    File,
    /// Changes of the document.
    Edit,
    /// How it is looked at.
    View,
}

impl Menu {
    /// All menus with their titles.
    pub const ALL: [(Self, &'static str); 3] = [(Self::File, "File"), (Self::Edit, "Edit"), (Self::View, "View")];
}

const CTRL: Modifiers = Modifiers::COMMAND;
const CTRL_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

impl Command {
    /// All commands in menu order.
    pub const ALL: [Self; 27] = [
        Self::New,
        Self::Open,
        Self::Save,
        Self::SaveAs,
        Self::LoadModel,
        Self::LoadEnvironment,
        Self::SavePng,
        Self::SaveExr,
        Self::Quit,
        Self::Undo,
        Self::Redo,
        Self::ResetAll,
        Self::ToggleFinal,
        Self::ShowPreview,
        Self::ShowFinal,
        Self::ShowBoth,
        Self::ShowWipe,
        Self::ShowDifference,
        Self::Frame,
        Self::ResetView,
        Self::ExposureUp,
        Self::ExposureDown,
        Self::ToggleDenoise,
        Self::ToggleBloom,
        Self::TogglePanels,
        Self::ToggleChart,
        Self::ToggleStability,
    ];

    /// What the menu says.
    pub fn text(self) -> &'static str {
        match self {
            Self::New => "New",
            Self::Open => "Open…",
            Self::Save => "Save",
            Self::SaveAs => "Save as…",
            Self::LoadModel => "Load mesh…",
            Self::LoadEnvironment => "Load environment…",
            Self::SavePng => "Save picture as PNG…",
            Self::SaveExr => "Save picture as EXR…",
            Self::Quit => "Quit",
            Self::Undo => "Undo",
            Self::Redo => "Redo",
            Self::ResetAll => "Reset all properties",
            Self::ToggleFinal => "Switch preview / final",
            Self::ShowPreview => "Preview",
            Self::ShowFinal => "Final",
            Self::ShowBoth => "Both side by side",
            Self::ShowWipe => "Wipe",
            Self::ShowDifference => "Difference",
            Self::Frame => "Frame object",
            Self::ResetView => "Reset view",
            Self::ExposureUp => "Brighter",
            Self::ExposureDown => "Darker",
            Self::ToggleDenoise => "Denoise final view",
            Self::ToggleBloom => "Bloom in preview",
            Self::TogglePanels => "Side panels",
            Self::ToggleChart => "Error chart",
            Self::ToggleStability => "Stability report",
        }
    }

    /// One sentence more.
    pub fn tooltip(self) -> &'static str {
        match self {
            Self::New => "Start a new material with every property at its default.",
            Self::Open => "Open a material file (.asm.ron).",
            Self::Save => "Write the changed values into the file; everything else in it stays as it is.",
            Self::SaveAs => "Write the material to another file.",
            Self::LoadModel => "Show the material on a mesh of your own (.gltf, .glb, .ply).",
            Self::LoadEnvironment => "Light the scene with a map of your own (.hdr, .exr).",
            Self::SavePng => "Display-referred sRGB: exposure and display transform are applied.",
            Self::SaveExr => "Linear Rec.709 radiance: neither exposure nor display transform is applied.",
            Self::Quit => "Close the window; asks first if there are unsaved changes.",
            Self::Undo => "Take back the last step.",
            Self::Redo => "Make the step again that was taken back.",
            Self::ResetAll => "Set every property back to its default, as one step.",
            Self::ToggleFinal => "Switch between the fast preview and the path-traced final view.",
            Self::ShowPreview => "The GPU's picture, at once.",
            Self::ShowFinal => "The path tracer's picture, which sharpens with time.",
            Self::ShowBoth => "Preview on the left, final view on the right.",
            Self::ShowWipe => "Preview left of a line that can be dragged, final view right of it.",
            Self::ShowDifference => "How far preview and final view are apart, pixel by pixel, as an eye would see it (FLIP).",
            Self::Frame => "Move the camera so that the object fills the picture.",
            Self::ResetView => "Camera, environment rotation and exposure as at first.",
            Self::ExposureUp => "A third of a stop more exposure.",
            Self::ExposureDown => "A third of a stop less exposure.",
            Self::ToggleBloom => {
                "Let what is brighter than white spread around, as a lens does; only where the preview stands alone."
            }
            Self::ToggleDenoise => "Show the final view denoised, labelled, with an error of its own; the raw picture is kept.",
            Self::TogglePanels => "Show or hide the presets and the properties.",
            Self::ToggleChart => "Show or hide the estimated error over time.",
            Self::ToggleStability => "Probe the material at extremes: non-finite values, lost or gained light, time.",
        }
    }

    /// The keys, first the one the menu shows.
    pub fn shortcuts(self) -> &'static [KeyboardShortcut] {
        const fn keys(modifiers: Modifiers, key: Key) -> KeyboardShortcut {
            KeyboardShortcut::new(modifiers, key)
        }
        match self {
            Self::New => const { &[keys(CTRL, Key::N)] },
            Self::Open => const { &[keys(CTRL, Key::O)] },
            Self::Save => const { &[keys(CTRL, Key::S)] },
            Self::SaveAs => const { &[keys(CTRL_SHIFT, Key::S)] },
            Self::SavePng => const { &[keys(CTRL, Key::P)] },
            Self::SaveExr => const { &[keys(CTRL_SHIFT, Key::P)] },
            Self::Quit => const { &[keys(CTRL, Key::Q)] },
            Self::Undo => const { &[keys(CTRL, Key::Z)] },
            Self::Redo => const { &[keys(CTRL_SHIFT, Key::Z), keys(CTRL, Key::Y)] },
            Self::ToggleFinal => const { &[keys(Modifiers::NONE, Key::Backslash)] },
            Self::ShowPreview => const { &[keys(Modifiers::NONE, Key::Num1)] },
            Self::ShowFinal => const { &[keys(Modifiers::NONE, Key::Num2)] },
            Self::ShowBoth => const { &[keys(Modifiers::NONE, Key::Num3)] },
            Self::ShowWipe => const { &[keys(Modifiers::NONE, Key::Num4)] },
            Self::ShowDifference => const { &[keys(Modifiers::NONE, Key::Num5)] },
            Self::Frame => const { &[keys(Modifiers::NONE, Key::F)] },
            Self::ResetView => const { &[keys(Modifiers::NONE, Key::R)] },
            Self::ExposureUp => const { &[keys(Modifiers::NONE, Key::CloseBracket)] },
            Self::ExposureDown => const { &[keys(Modifiers::NONE, Key::OpenBracket)] },
            Self::ToggleBloom => &[],
            Self::ToggleDenoise => const { &[keys(Modifiers::NONE, Key::D)] },
            Self::TogglePanels => const { &[keys(Modifiers::NONE, Key::H)] },
            Self::ToggleChart => const { &[keys(Modifiers::NONE, Key::G)] },
            Self::ToggleStability => const { &[keys(Modifiers::NONE, Key::T)] },
            Self::LoadModel | Self::LoadEnvironment | Self::ResetAll => &[],
        }
    }

    /// Where the menu bar lists it.
    pub fn menu(self) -> Menu {
        match self {
            Self::New
            | Self::Open
            | Self::Save
            | Self::SaveAs
            | Self::LoadModel
            | Self::LoadEnvironment
            | Self::SavePng
            | Self::SaveExr
            | Self::Quit => Menu::File,
            Self::Undo | Self::Redo | Self::ResetAll => Menu::Edit,
            Self::ToggleFinal
            | Self::ShowPreview
            | Self::ShowFinal
            | Self::ShowBoth
            | Self::ShowWipe
            | Self::ShowDifference
            | Self::Frame
            | Self::ResetView
            | Self::ExposureUp
            | Self::ExposureDown
            | Self::ToggleDenoise
            | Self::ToggleBloom
            | Self::TogglePanels
            | Self::ToggleChart
            | Self::ToggleStability => Menu::View,
        }
    }

    /// Whether a line in the menu comes before it.
    pub fn starts_section(self) -> bool {
        matches!(
            self,
            Self::LoadModel
                | Self::SavePng
                | Self::Quit
                | Self::ResetAll
                | Self::Frame
                | Self::ExposureUp
                | Self::ToggleDenoise
                | Self::TogglePanels
        )
    }

    /// Whether a text field has its own meaning for the keys: undo there takes back typing.
    fn is_own_to_text_fields(self) -> bool {
        matches!(self, Self::Undo | Self::Redo)
    }

    /// The commands whose keys were pressed. Keys that type or move a cursor are left to a text field that has the focus.
    pub fn pressed(ctx: &egui::Context) -> Vec<Self> {
        let is_typing = ctx.text_edit_focused();
        ctx.input_mut(|input| {
            // Longer shortcuts first: Ctrl+Shift+Z also contains Ctrl+Z.
            let mut keys: Vec<(Self, &KeyboardShortcut)> =
                Self::ALL.iter().flat_map(|&command| command.shortcuts().iter().map(move |keys| (command, keys))).collect();
            keys.sort_by_key(|(_, keys)| std::cmp::Reverse(u8::from(keys.modifiers.shift) + u8::from(keys.modifiers.command)));
            keys.into_iter()
                .filter(|(command, keys)| !is_typing || !(keys.conflicts_with_text_editing() || command.is_own_to_text_fields()))
                .filter(|(_, keys)| input.consume_shortcut(keys))
                .map(|(command, _)| command)
                .collect()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn every_command_has_words_and_keys_of_its_own() {
        let mut texts = HashSet::new();
        let mut keys = HashSet::new();
        for command in Command::ALL {
            assert!(texts.insert(command.text()), "{command:?}");
            assert!(command.tooltip().ends_with('.'), "{command:?}");
            for shortcut in command.shortcuts() {
                assert!(keys.insert(*shortcut), "{command:?}");
            }
        }
        assert_eq!(texts.len(), Command::ALL.len());
    }

    #[test]
    fn the_longer_shortcut_wins() {
        let ctx = egui::Context::default();
        let event = |modifiers| egui::Event::Key { key: Key::Z, physical_key: None, pressed: true, repeat: false, modifiers };
        for (modifiers, command) in [(CTRL_SHIFT, Command::Redo), (CTRL, Command::Undo)] {
            let modifiers = Modifiers { ctrl: modifiers.command, ..modifiers };
            let input = egui::RawInput { events: vec![event(modifiers)], ..Default::default() };
            let mut pressed = Vec::new();
            let mut output = ctx.run_ui(input, |ui| pressed.extend(Command::pressed(ui.ctx())));
            // Nothing is drawn here, so the font's texture is dropped on purpose.
            output.textures_delta.clear();
            assert_eq!(pressed, [command]);
        }
    }
}

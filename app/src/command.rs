//! Every named action: its text, tooltip, menu and keys in one table, which menus, keys, the palette and the list of keys read.
//!
//! What a command does is one `match`, in `app/actions.rs`. Which keys it has for this user is in `keymap.rs`.

use egui::{Key, KeyboardShortcut, Modifiers};

/// A menu of the menu bar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Menu {
    /// Documents and files.
    File,
    /// Changes of the document.
    Edit,
    /// How it is looked at.
    View,
    /// Parts of the window.
    Window,
    /// How to find one's way.
    Help,
}

impl Menu {
    /// All menus with their titles.
    pub const ALL: [(Self, &'static str); 5] =
        [(Self::File, "File"), (Self::Edit, "Edit"), (Self::View, "View"), (Self::Window, "Window"), (Self::Help, "Help")];
}

/// One row of the table.
#[derive(Clone, Copy, Debug)]
pub struct CommandDef {
    /// Which one.
    pub command: Command,
    /// Its name in stored key settings; never changed.
    pub id: &'static str,
    /// Where the menu bar lists it.
    pub menu: Menu,
    /// Whether a line in the menu comes before it.
    pub starts_section: bool,
    /// What the menu says.
    pub text: &'static str,
    /// One sentence of what it does.
    pub tooltip: &'static str,
    /// Its keys unless the user chose others, the one that menus show first.
    pub keys: &'static [KeyboardShortcut],
}

macro_rules! commands {
    ($( $name:ident, $id:literal, $menu:ident, $section:literal, $text:literal, $tooltip:literal, [$( $modifiers:ident $key:ident ),*]; )+) => {
        /// A named action.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum Command { $( #[doc = $tooltip] $name ),+ }

        /// All commands in menu order; row number is `Command as usize`.
        pub const COMMANDS: &[CommandDef] = &[$( CommandDef {
            command: Command::$name, id: $id, menu: Menu::$menu, starts_section: $section, text: $text, tooltip: $tooltip,
            keys: &[$( KeyboardShortcut::new($modifiers, Key::$key) ),*],
        } ),+];
    };
}

const NONE: Modifiers = Modifiers::NONE;
const CTRL: Modifiers = Modifiers::COMMAND;
const CTRL_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

commands! {
    New, "file.new", File, false, "New", "A material with every property at its default, in a tab of its own.", [CTRL N];
    NewFromMeasured, "file.measured", File, false, "New from measured…", "Choose among measured materials, with their sources and spread.", [];
    Open, "file.open", File, false, "Open…", "Open a material file in a tab of its own.", [CTRL O];
    OpenRecent, "file.recent", File, false, "Open recent…", "Choose among the files that were open lately.", [CTRL R];
    Save, "file.save", File, true, "Save", "Write the changed values into the file; everything else in it stays as it is.", [CTRL S];
    SaveAs, "file.save_as", File, false, "Save as…", "Save to another file.", [CTRL_SHIFT S];
    CloseTab, "file.close", File, false, "Close", "Close this material; asks if it has unsaved changes.", [CTRL W];
    OpenLibrary, "file.library", File, false, "Open library…", "Show a folder of materials as a grid of pictures: search, edit many, drag onto the view.", [CTRL_SHIFT O];
    CompareRelease, "file.release", File, false, "Compare library with a release…", "List what is new, gone and changed by value and by look since an earlier release in a folder, for its notes.", [];
    ExportMaterial, "file.export", File, false, "Export material…", "The material for other programs: glTF, MaterialX, USD, MDL, Filament or a texture set, with what that costs told before.", [];
    LoadModel, "file.mesh", File, true, "Load mesh…", "Show the material on a mesh from a .gltf, .glb or .ply file.", [];
    LoadEnvironment, "file.environment", File, false, "Load environment…", "Light the scene with an .hdr or .exr file.", [];
    LoadTextureSet, "file.texture_set", File, false, "Load texture set…", "Choose a folder of images; they are matched to properties by their names.", [];
    LoadReference, "file.reference", File, false, "Load reference image…", "Show a photo beside the view, to look at and to pick colours from.", [];
    SavePng, "file.png", File, true, "Save picture as PNG…", "Display-referred sRGB: exposure and display transform are applied.", [NONE P, CTRL P];
    SaveExr, "file.exr", File, false, "Save picture as EXR…", "Linear Rec.709 radiance: neither exposure nor display transform is applied.", [CTRL_SHIFT P];
    ContactSheet, "file.sheet", File, true, "Contact sheet…", "All materials of the open library on one page or in one picture.", [];
    ExportPack, "file.pack", File, false, "Export pack…", "The open library as a folder to hand out: materials, images, USD, MaterialX, glTF, contact sheet, licences, check.", [];
    RenderPicture, "file.render", File, false, "Render picture…", "Choose a file and render into it, as the Export panel says, in the background.", [NONE F12];
    RenderTurntable, "file.turntable", File, false, "Render turntable", "Render the frames around the object that the Export panel sets, in the background.", [CTRL F12];
    StopRendering, "file.stop_rendering", File, false, "Stop rendering", "End the picture or turntable in the background; a turntable goes on from there later.", [];
    Preferences, "file.preferences", File, true, "Preferences…", "Units, threads, default scene, autosave, mouse, theme and keys.", [CTRL Comma];
    Quit, "file.quit", File, true, "Quit", "Close the window; asks for each material with unsaved changes.", [CTRL Q];

    Undo, "edit.undo", Edit, false, "Undo", "Take the last step back.", [CTRL Z];
    Redo, "edit.redo", Edit, false, "Redo", "Make the step again that was taken back.", [CTRL_SHIFT Z, CTRL Y];
    ResetAll, "edit.reset_all", Edit, true, "Reset all properties", "All properties to their defaults, as one step.", [];
    StoreSide, "edit.store_side", Edit, true, "Store as side A", "Keep this state as the other side, to compare with what comes.", [NONE A];
    FlipSides, "edit.flip_sides", Edit, false, "Flip sides", "Exchange this state and the stored one.", [NONE B];

    ToggleFinal, "view.toggle_final", View, false, "Switch preview / final", "Switch between the preview and the final view.", [NONE Backslash];
    ShowPreview, "view.preview", View, false, "Preview", "The GPU's picture alone, at once.", [NONE Num1];
    ShowFinal, "view.final", View, false, "Final", "The path tracer's picture alone, which sharpens with time.", [NONE Num2];
    ShowBoth, "view.both", View, false, "Both side by side", "Two pictures beside each other.", [NONE Num3];
    ShowWipe, "view.wipe", View, false, "Wipe", "Two pictures in one, with a line between them to drag.", [NONE Num4];
    ShowDifference, "view.difference", View, false, "Difference", "How far preview and final view are apart, pixel by pixel (FLIP).", [NONE Num5];
    CompareSides, "view.sides", View, false, "Compare sides A and B", "Show side A instead of the final view beside, or behind the line of, this state.", [NONE S];
    Frame, "view.frame", View, true, "Frame object", "Fill the picture with the object; angles stay.", [NONE F];
    ResetView, "view.reset", View, false, "Reset view", "Camera, light and exposure as at first.", [NONE R];
    BookmarkCamera, "view.bookmark", View, false, "Bookmark camera", "Keep this point of view, to come back to.", [CTRL D];
    NextBookmark, "view.next_bookmark", View, false, "Next camera bookmark", "Go to the next kept point of view.", [NONE V];
    NextMesh, "view.next_mesh", View, false, "Next mesh", "Show the material on the next built-in mesh.", [NONE ArrowDown];
    PreviousMesh, "view.previous_mesh", View, false, "Previous mesh", "Show the material on the built-in mesh before.", [NONE ArrowUp];
    NextBackdrop, "view.next_backdrop", View, false, "Next backdrop", "Put the mesh on the next backdrop: what it brings, nothing, tiles, a grey sweep.", [];
    NextEnvironment, "view.next_environment", View, false, "Next environment", "Light the scene with the next built-in environment.", [NONE E];
    ExposureUp, "view.brighter", View, true, "Brighter", "One third of a stop more exposure.", [NONE CloseBracket];
    ExposureDown, "view.darker", View, false, "Darker", "One third of a stop less exposure.", [NONE OpenBracket];
    ToggleDenoise, "view.denoise", View, true, "Denoise final view", "Show the final view denoised; the raw picture is kept, and the label says which is shown.", [NONE D];
    ToggleBloom, "view.bloom", View, false, "Bloom", "Let what is very bright glow; only where the preview stands alone.", [];
    NextDebug, "view.next_debug", View, false, "Next debug view", "Albedo, normal, lobes and others in turn; then the material again.", [NONE C];
    ShowMaterial, "view.material", View, false, "Back to the material", "Ends debug views.", [NONE M];
    ExplainPixel, "view.explain", View, false, "Explain a pixel", "Click into the view to see which lobe contributes what there.", [NONE X];

    TogglePanels, "window.panels", Window, false, "Hide panels", "Nothing but the view; again for the panels.", [NONE H];
    Fullscreen, "window.fullscreen", Window, false, "Full screen", "The window over the whole screen, or back.", [NONE F11];
    NextTab, "window.next_tab", Window, true, "Next material", "Bring the next open material to the front.", [CTRL PageDown];
    PreviousTab, "window.previous_tab", Window, false, "Previous material", "Bring the open material before to the front.", [CTRL PageUp];
    ToggleLibrary, "window.library", Window, true, "Presets", "Show or hide the presets.", [];
    ToggleFolder, "window.folder", Window, false, "Library", "Show or hide the folder of materials.", [NONE K];
    ToggleProperties, "window.properties", Window, false, "Properties", "Show or hide the properties.", [];
    ToggleLobes, "window.lobes", Window, false, "Lobes", "Show or hide which lobes are in use, and what they cost.", [NONE L];
    ToggleChart, "window.chart", Window, false, "Convergence", "Show or hide the curve of the error over time.", [NONE G];
    ToggleStability, "window.stability", Window, false, "Stability", "Probe the material at extremes: non-finite values, lost or gained light, time.", [NONE T];
    ToggleValidation, "window.validation", Window, false, "Validation", "What is wrong or hardly meant in the open library, or in the open material.", [NONE F8];
    ToggleDiff, "window.diff", Window, false, "Diff", "Two materials value by value and as pictures: two selected cards, a card and this one, or this one as it was.", [NONE F7];
    ToggleMerge, "window.merge", Window, false, "Merge", "Two versions of a material and what both were made from become one.", [NONE F6];
    ToggleHistory, "window.history", Window, false, "History", "Show or hide the list of steps.", [NONE Y];
    ToggleMessages, "window.messages", Window, false, "Messages", "Show or hide everything that was said.", [];
    ToggleExport, "window.export", Window, false, "Export", "Show or hide the settings of pictures and turntables to give away.", [CTRL_SHIFT E];
    ResetLayout, "window.reset_layout", Window, true, "Reset layout", "All panels to their places.", [];

    Palette, "help.palette", Help, false, "Find a command…", "Type a few letters of a command, property or preset.", [CTRL K];
    Help, "help.keys", Help, false, "Keys and mouse", "All keys; over a property its reference instead.", [NONE F1];
}

impl Command {
    /// Its row of the table.
    pub fn def(self) -> &'static CommandDef {
        &COMMANDS[self as usize]
    }

    /// What the menu says.
    pub fn text(self) -> &'static str {
        self.def().text
    }

    /// One sentence of what it does.
    pub fn tooltip(self) -> &'static str {
        self.def().tooltip
    }

    /// The command of this name in stored settings.
    pub fn from_id(id: &str) -> Option<Self> {
        COMMANDS.iter().find(|def| def.id == id).map(|def| def.command)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn every_command_has_words_and_keys_of_its_own() {
        let (mut texts, mut ids, mut keys) = (HashSet::new(), HashSet::new(), HashSet::new());
        for (index, def) in COMMANDS.iter().enumerate() {
            assert_eq!(def.command as usize, index);
            assert!(texts.insert(def.text), "{}", def.text);
            assert!(ids.insert(def.id), "{}", def.id);
            assert!(def.tooltip.ends_with('.'), "{}", def.id);
            for shortcut in def.keys {
                assert!(keys.insert(*shortcut), "{}", def.id);
            }
            assert_eq!(Command::from_id(def.id), Some(def.command));
        }
    }
}

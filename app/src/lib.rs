//! The window of Burnish and its command line: a material editor for the Adobe Standard Material 4.0.
//!
//! One edit goes in a straight line: a widget changes the document in place; after the panels the material is compared
//! with the one last sent, and if it differs, the history, the preview and the final view are told, in that order.

pub mod app;
pub mod bookmarks;
pub mod cli;
pub mod command;
pub mod curve;
pub mod dialogs;
pub mod digest;
pub mod dock;
pub mod editor;
pub mod export;
pub mod files;
pub mod heatmap;
pub mod history;
pub mod keymap;
pub mod latency;
pub mod layout_file;
pub mod library;
pub mod live_costs;
pub mod live_debug;
pub mod live_denoise;
pub mod live_difference;
pub mod live_export;
pub mod live_final;
pub mod live_preview;
pub mod live_stability;
pub mod loading;
pub mod lobe_costs;
pub mod offline;
pub mod own_files;
pub mod pages;
pub mod panels;
pub mod parity;
pub mod picture_file;
pub mod picture_job;
pub mod places;
pub mod preferences;
pub mod recent;
pub mod recovery;
pub mod scene_file;
pub mod sides;
pub mod small_pictures;
pub mod switches;
pub mod tabs;
pub mod texture_set;
pub mod theme;
pub mod thumbnails;
pub mod watch;
pub mod widgets;
pub mod work;

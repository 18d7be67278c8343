//! `burnish presets`: the built-in library as text or JSON.

use super::material_argument::{find_preset, preset_name};
use super::{CliError, Outcome, print_out};
use burnish_presets::{Preset, group_title, presets, search};
use clap::{Args, Subcommand};
use serde_json::{Value, json};
use std::fmt::Write;

/// Arguments of `burnish presets`.
#[derive(Debug, Args)]
pub struct PresetsArguments {
    #[command(subcommand)]
    action: Action,
    /// Prints one JSON object
    #[arg(long, global = true)]
    json: bool,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Prints all names by group
    List,
    /// Prints the file of one material, with its sources
    Show {
        /// Name as the list prints it, in any case
        name: String,
    },
    /// Prints the names for which every word is found in name, group or tags
    Search {
        /// Words to find
        #[arg(required = true)]
        query: Vec<String>,
    },
}

/// Lists, shows or searches.
pub fn run(arguments: &PresetsArguments) -> Result<Outcome, CliError> {
    let found = match &arguments.action {
        Action::List => presets().iter().collect(),
        Action::Show { name } => return show(find_preset(preset_name(name).unwrap_or(name))?, arguments.json),
        Action::Search { query } => search(&query.join(" ")),
    };
    if arguments.json {
        let rows: Vec<Value> = found.into_iter().map(row).collect();
        print_out(&json!({ "presets": rows }).to_string())?;
    } else if found.is_empty() {
        eprintln!("no preset matches; `burnish presets list` prints all");
    } else {
        print_out(&text(&found))?;
    }
    Ok(Outcome::Done)
}

fn show(preset: &Preset, is_json: bool) -> Result<Outcome, CliError> {
    if is_json {
        let mut row = row(preset);
        row["text"] = preset.text.into();
        print_out(&json!({ "presets": [row] }).to_string())?;
    } else {
        print_out(preset.text)?;
    }
    Ok(Outcome::Done)
}

fn row(preset: &Preset) -> Value {
    json!({ "name": preset.name, "group": preset.group, "source": preset.source, "tags": preset.tags, "file": preset.file_stem })
}

/// A heading per group, a name per line.
fn text(found: &[&Preset]) -> String {
    let mut text = String::new();
    let mut group = "";
    for preset in found {
        if preset.group != group {
            group = preset.group;
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{}", group_title(group));
        }
        let _ = writeln!(text, "  {}", preset.name);
    }
    text
}

//! `burnish merge`: two versions of a material and what both were made from become one.
//!
//! The result is A's text with only what B changed replaced. Where names were changed to two different ones, one is kept among the `aliases` of the file, which searches find.

use super::material_argument::load_file;
use super::target::refuse_target;
use super::{CliError, Messages, Outcome, interrupt, one_line, print_out};
use crate::files::{self, save_atomic};
use burnish_material::diff::Change;
use burnish_material::merge::{Conflict, MergedFile, Side, merge_files};
use clap::Args;
use serde_json::{Value, json};
use std::path::PathBuf;

/// Arguments of `burnish merge`.
#[derive(Debug, Args)]
pub struct MergeArguments {
    /// What both versions were made from: a material file (.asm.ron) or preset:NAME
    #[arg(value_name = "BASE")]
    base: String,
    /// Version whose text, with comments and unknown keys, is kept
    #[arg(value_name = "A")]
    a: String,
    /// Version whose changes are taken over
    #[arg(value_name = "B")]
    b: String,
    /// Where the merged file goes
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Which version holds where both changed something differently; without it that is A, and exit code 1
    #[arg(long, value_name = "a|b", value_parser = side)]
    prefer: Option<Side>,
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
}

/// Merges, writes and prints. Exit code 1 where something is to be decided.
pub fn run(arguments: &MergeArguments) -> Result<Outcome, CliError> {
    if !files::is_material_path(&arguments.out) {
        let sentence = format!("--out: {}: expected a file name that ends in .asm.ron", arguments.out.display());
        return Err(CliError::unusable(sentence));
    }
    refuse_target("--out", &arguments.out)?;
    let mut messages = Messages::default();
    let base = load_file(&arguments.base, None, &mut messages)?;
    let a = load_file(&arguments.a, None, &mut messages)?;
    let b = load_file(&arguments.b, None, &mut messages)?;
    let MergedFile { merged, text, left_out } = merge_files(&base, &a, &b, arguments.prefer.unwrap_or(Side::A));
    interrupt::check()?;
    save_atomic(&arguments.out, text.as_bytes()).map_err(CliError::unusable)?;
    // Images are found from the folder of the file, which may be another one now.
    let images = merged.material.slots().filter_map(|(_, slot)| slot.texture.as_ref());
    for image in images.filter(|image| !image.path.is_empty()) {
        if let Some(problem) = files::texture_problem(&image.path, arguments.out.parent()) {
            messages.warn_about(&arguments.out, &problem);
        }
    }

    if arguments.json {
        let object = json!({
            "out": arguments.out,
            "taken": merged.taken,
            "conflicts": merged.conflicts.iter().map(json_conflict).collect::<Vec<_>>(),
            "left_out": left_out.iter().map(|change| json!({ "property": change.key, "a": change.a, "b": change.b })).collect::<Vec<_>>(),
            "warnings": messages.warnings(),
        });
        print_out(&object.to_string())?;
    } else {
        let kept = |conflict: &Conflict| if merged.taken.contains(&conflict.key) { "B" } else { "A" };
        let mut lines: String = merged.conflicts.iter().map(|conflict| text_conflict(conflict, kept(conflict))).collect();
        left_out.iter().for_each(|change| lines += &text_left_out(change));
        lines +=
            &format!("{} taken from B, {} in conflict, {} left out", merged.taken.len(), merged.conflicts.len(), left_out.len());
        print_out(&lines)?;
    }
    let is_open = arguments.prefer.is_none() && !merged.conflicts.is_empty();
    // Only A's text can be asked for there.
    let is_lost = arguments.prefer != Some(Side::A) && !left_out.is_empty();
    Ok(if is_open || is_lost { Outcome::Findings } else { Outcome::Done })
}

fn json_conflict(conflict: &Conflict) -> Value {
    json!({ "property": conflict.key, "base": conflict.base, "a": conflict.a, "b": conflict.b })
}

fn text_conflict(conflict: &Conflict, kept: &str) -> String {
    let show = |text: &Option<String>| text.as_deref().map_or_else(|| "nothing".to_owned(), one_line);
    let (base, a, b) = (show(&conflict.base), show(&conflict.a), show(&conflict.b));
    format!("conflict: {}: {base} became {a} in A and {b} in B; that of {kept} is kept\n", conflict.key)
}

fn text_left_out(change: &Change) -> String {
    let what = if change.b.is_some() { "is another one in B" } else { "is gone in B" };
    format!("left out: {}: {what}; the text of A is kept\n", change.key)
}

fn side(word: &str) -> Result<Side, String> {
    match word {
        "a" | "A" => Ok(Side::A),
        "b" | "B" => Ok(Side::B),
        _ => Err("expected a or b".to_owned()),
    }
}

//! What a check found, for people and for machines: the same from the command line and from the window.

use super::against::{Against, Changed, LookChange};
use super::{Checked, Kind, Options, Row};
use crate::cli::one_line;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Counts, rows and pairs.
pub fn json_object(checked: &Checked) -> Value {
    let rows: Vec<Value> = checked.rows.iter().map(json_row).collect();
    let pairs = checked.pairs.iter().map(|pair| {
        json!({ "a": pair.a.to_string_lossy(), "b": pair.b.to_string_lossy(), "kind": pair.kind.word(), "distance": pair.distance })
    });
    let pairs: Vec<Value> = pairs.collect();
    json!({ "files": checked.files, "errors": checked.errors, "warnings": checked.warnings, "rows": rows, "pairs": pairs })
}

/// `3 files, 1 error, 0 warnings`.
pub fn counts(checked: &Checked) -> String {
    let counts = [(checked.files, "file"), (checked.errors, "error"), (checked.warnings, "warning")];
    counts.map(|(n, word)| format!("{n} {word}{}", if n == 1 { "" } else { "s" })).join(", ")
}

fn json_row(row: &Row) -> Value {
    json!({
        "file": row.path.to_string_lossy(),
        "line": row.line,
        "severity": row.severity.word(),
        "kind": row.kind.word(),
        "key": row.key,
        "message": row.message,
    })
}

/// One line for people.
pub fn text_row(row: &Row) -> String {
    let line = row.line.map_or_else(String::new, |line| format!(":{line}"));
    let key = if row.key.is_empty() { String::new() } else { format!("{}: ", row.key) };
    format!("{}{line}: {}: {key}{}\n", row.path.display(), row.severity.word(), row.message)
}

/// All that was found as lines for people; what became of the library since an earlier release before the counts.
pub fn text(checked: &Checked, against: Option<&Against>) -> String {
    let is_listed = |kind| kind != Kind::Thumbnail;
    let mut text: String = checked.rows.iter().filter(|row| is_listed(row.kind)).map(text_row).collect();
    against.into_iter().for_each(|against| text += &text_against(against));
    let pictures = checked.rows.iter().filter(|row| !is_listed(row.kind)).count();
    if pictures > 0 {
        text += &format!("{pictures} small pictures are stale or missing; `burnish library thumbnails` makes them\n");
    }
    text + &counts(checked)
}

/// What became of a library as lines for people, with the counts last.
pub fn text_against(against: &Against) -> String {
    let paths = |word: &str, paths: &[PathBuf]| -> String {
        paths.iter().map(|path| format!("{word:<8} {}\n", path.display())).collect()
    };
    let mut text = paths("added", &against.added) + &paths("removed", &against.removed);
    for changed in &against.changed {
        text += &format!("changed  {}: {}\n", changed.path.display(), change_words(changed));
    }
    text + &format!("{}\n", sums(against))
}

/// `1 added, 0 removed, 14 changed by value, …`.
pub fn sums(against: &Against) -> String {
    let count = |is: &dyn Fn(&Changed) -> bool| against.changed.iter().filter(|changed| is(changed)).count();
    format!(
        "{} added, {} removed, {} changed by value, {} changed in look, {} of which the look is not known, {} unchanged",
        against.added.len(),
        against.removed.len(),
        count(&|changed| changed.is_by_value),
        count(&|changed| matches!(changed.look, LookChange::Changed(_))),
        count(&|changed| changed.look == LookChange::Unknown),
        against.unchanged
    )
}

/// What changed in a file: keys of entries; and how its look did.
pub fn change_words(changed: &Changed) -> String {
    if let Some(problem) = &changed.problem {
        return format!("cannot be compared: {problem}");
    }
    let keys: Vec<&str> = changed.changes.iter().map(|change| change.key.as_str()).collect();
    let keys = match (keys.is_empty(), changed.is_by_value) {
        (false, _) => keys.join(", "),
        (true, true) => "images".to_owned(),
        (true, false) => "spelling".to_owned(),
    };
    format!("{keys}; {}", look_words(changed.look))
}

fn look_words(look: LookChange) -> String {
    match look {
        LookChange::Same(_) => "looks the same".to_owned(),
        LookChange::Changed(distance) => format!("looks {:.1} % different", 100.0 * distance),
        LookChange::Unknown => "look not known".to_owned(),
    }
}

/// What became of a library as Markdown for release notes.
pub fn markdown(against: &Against, release: &Path) -> String {
    let name = release.file_name().unwrap_or(release.as_os_str()).to_string_lossy();
    let mut text = format!("# Changes since {name}\n\n{}.\n", sums(against));
    let code = |text: &str| format!("`{text}`");
    for (title, paths) in [("New", &against.added), ("Gone", &against.removed)] {
        if !paths.is_empty() {
            let lines: String = paths.iter().map(|path| format!("- {}\n", code(&path.to_string_lossy()))).collect();
            text += &format!("\n## {title}\n\n{lines}");
        }
    }
    if !against.changed.is_empty() {
        text += "\n## Changed\n\n";
    }
    for changed in &against.changed {
        let words = if changed.changes.is_empty() || changed.problem.is_some() {
            change_words(changed)
        } else {
            look_words(changed.look)
        };
        text += &format!("- {}: {words}\n", code(&changed.path.to_string_lossy()));
        for change in &changed.changes {
            let side = |side: &Option<String>| side.as_deref().map_or_else(|| "default".to_owned(), |text| code(&one_line(text)));
            text += &format!("  - {}: {} → {}\n", change.key, side(&change.a), side(&change.b));
        }
    }
    text
}

/// How long a check took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timing {
    /// Seconds of checking.
    pub seconds: f64,
    /// Seconds of reading the folder before; 0 where it was open.
    pub read_seconds: f64,
}

/// All of a check of a library: findings, what became of it since the release in a folder, times and sentences that came up.
pub fn json_library(checked: &Checked, against: Option<(&Against, &Path)>, timing: Timing, notices: &[String]) -> Value {
    let mut object = json_object(checked);
    object["seconds"] = timing.seconds.into();
    object["read_seconds"] = timing.read_seconds.into();
    object["files_per_second"] = (checked.files as f64 / timing.seconds.max(1e-9)).into();
    object["against"] = against.map_or(Value::Null, |(against, folder)| json_against(against, Some(folder)));
    object["notices"] = notices.into();
    object
}

/// The command line that checks a library in the same way.
pub fn command_line(root: &Path, options: &Options, against: Option<&Path>) -> String {
    let quoted = |path: &Path| {
        let text = path.to_string_lossy();
        let is_plain = |c: char| c.is_alphanumeric() || "/._-+:\\".contains(c);
        if text.chars().all(is_plain) { text.into_owned() } else { format!("'{}'", text.replace('\'', r"'\''")) }
    };
    let mut line = format!("burnish library check {}", quoted(root));
    for (is_set, option) in [(options.renders_looks, " --look"), (options.probes_stability, " --stability")] {
        line += if is_set { option } else { "" };
    }
    against.into_iter().for_each(|folder| line += &format!(" --against {}", quoted(folder)));
    line
}

fn json_against(against: &Against, folder: Option<&Path>) -> Value {
    let names = |paths: &[PathBuf]| -> Vec<String> { paths.iter().map(|path| path.to_string_lossy().into_owned()).collect() };
    let changed = against.changed.iter().map(|changed| {
        let (look, distance) = match changed.look {
            LookChange::Same(distance) => ("same", Some(distance)),
            LookChange::Changed(distance) => ("changed", Some(distance)),
            LookChange::Unknown => ("not known", None),
        };
        let changes = changed.changes.iter().map(|change| json!({ "property": change.key, "a": change.a, "b": change.b }));
        json!({
            "path": changed.path.to_string_lossy(),
            "by_value": changed.is_by_value,
            "look": look,
            "distance": distance,
            "changed": changes.collect::<Vec<_>>(),
            "problem": changed.problem,
        })
    });
    json!({
        "folder": folder.map(Path::to_string_lossy),
        "added": names(&against.added),
        "removed": names(&against.removed),
        "changed": changed.collect::<Vec<_>>(),
        "unchanged": against.unchanged,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use burnish_material::diff::Change;

    #[test]
    fn release_notes_tell_all() {
        let change = Change { key: "roughness".into(), property: None, a: Some("0.2".into()), b: None, is_visible: true };
        let changed = |path: &str, changes: Vec<Change>, look| Changed {
            path: path.into(),
            is_by_value: !changes.is_empty(),
            changes,
            look,
            problem: None,
        };
        let against = Against {
            added: vec!["new.asm.ron".into()],
            removed: Vec::new(),
            changed: vec![
                changed("brass.asm.ron", vec![change], LookChange::Changed(0.0213)),
                changed("gold.asm.ron", Vec::new(), LookChange::Same(0.0)),
            ],
            unchanged: 3,
        };
        let expected = "# Changes since 1.0\n\n1 added, 0 removed, 1 changed by value, 1 changed in look, 0 of which the look is not known, \
            3 unchanged.\n\n## New\n\n- `new.asm.ron`\n\n## Changed\n\n- `brass.asm.ron`: looks 2.1 % different\n  - roughness: `0.2` → default\n\
            - `gold.asm.ron`: spelling; looks the same\n";
        assert_eq!(markdown(&against, Path::new("releases/1.0")), expected);
    }

    #[test]
    fn command_lines_can_be_pasted() {
        let options = Options { renders_looks: true, ..Options::default() };
        let line = command_line(Path::new("/work/my stones"), &options, Some(Path::new("/old/it's")));
        assert_eq!(line, r"burnish library check '/work/my stones' --look --against '/old/it'\''s'");
    }
}

//! The program's own small files: read whatever they hold, set aside if they are broken, never deleted.

use crate::files::{FilesError, read_text_file, save_atomic};
use std::fs;
use std::io::ErrorKind;
use std::path::Path;

/// Larger files of preferences, layout or recent files are refused.
pub const MAX_BYTES: u64 = 1 << 20;

/// What `parse` makes of the file at `path`, of at most `max_bytes`; `None` if there is no file or it cannot be used.
///
/// What cannot be used is set aside, so that saving later replaces nothing that somebody may want to repair; the one
/// sentence returned names the file, what was wrong with it and where it is now.
pub fn load<T>(path: &Path, max_bytes: u64, parse: impl FnOnce(&str) -> Result<T, String>) -> (Option<T>, Option<String>) {
    let problem = match read_text_file(path, max_bytes) {
        Err(FilesError::Read { source, .. }) if source.kind() == ErrorKind::NotFound => return (None, None),
        Err(error) => error.to_string(),
        Ok(text) => match parse(&text) {
            Ok(value) => return (Some(value), None),
            Err(problem) => format!("{}: {problem}", path.display()),
        },
    };
    (None, Some(format!("{problem}; {}", set_aside(path))))
}

/// Renames the file at `path` to the first of `NAME.broken-1.ron`, `NAME.broken-2.ron`, ... that is free.
///
/// Returns the end of a sentence that says so, or why it could not be done.
pub fn set_aside(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let names = (1..).map(|number: u32| path.with_file_name(format!("{stem}.broken-{number}.ron")));
    // A link that leads nowhere takes its name, too.
    let Some(aside) = names.into_iter().find(|name| fs::symlink_metadata(name).is_err()) else { return String::new() };
    match fs::rename(path, &aside) {
        Ok(()) => format!("it was renamed to {}", aside.file_name().unwrap_or_default().to_string_lossy()),
        Err(error) => format!("it could not be renamed: {error}"),
    }
}

/// Writes a file whole or not at all, in a folder that is made if it is missing.
pub fn save(path: &Path, text: &str) -> Result<(), FilesError> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(|source| FilesError::Write { path: path.to_path_buf(), source })?;
    }
    save_atomic(path, text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(text: &str) -> Result<i32, String> {
        text.trim().parse().map_err(|_| format!("expected a number, found {text:?}"))
    }

    #[test]
    fn what_cannot_be_used_is_kept_under_another_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("few.ron");
        assert_eq!(load(&path, 8, number), (None, None), "no file is no problem");
        let broken: [&[u8]; 3] = [b"many", b"1000000000", b"\xff"];
        for (index, bytes) in broken.into_iter().enumerate() {
            fs::write(&path, bytes).unwrap();
            let (value, message) = load(&path, 8, number);
            let (message, aside) = (message.unwrap(), format!("few.broken-{}.ron", index + 1));
            assert_eq!(value, None);
            assert!(message.contains("few.ron: expected ") && message.contains(&aside), "{message}");
            assert!(!path.exists());
            assert_eq!(fs::read(folder.path().join(&aside)).unwrap(), bytes);
        }
        fs::create_dir(&path).unwrap();
        assert!(load(&path, 8, number).1.unwrap().contains("found a folder"));
        save(&path, "12").unwrap();
        assert_eq!(load(&path, 8, number), (Some(12), None));
    }

    #[test]
    fn what_cannot_be_saved_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        let error = save(&file.join("deeper").join("few.ron"), "1").unwrap_err().to_string();
        assert!(error.contains("few.ron: cannot be written"), "{error}");
    }
}

//! Paths of images that files of others name: which are taken.

/// Why a path is not taken: it has to stay in the folder of the file that names it. `None` for a path that does, and for a name of a texture
/// that comes with the program. No file is looked at.
pub fn refusal(path: &str) -> Option<&'static str> {
    if path.contains(char::is_control) {
        return Some("has characters that no path has");
    }
    if path.starts_with("builtin:") {
        return None;
    }
    let parts = || path.split(['/', '\\']);
    if let Some((scheme, _)) = parts().next().and_then(|head| head.split_once(':')) {
        return Some(match scheme.len() {
            1 => ABSOLUTE,
            _ => "is an address; nothing is fetched",
        });
    }
    if path.starts_with(['/', '\\']) {
        return Some(ABSOLUTE);
    }
    let mut depth = 0_i64;
    for part in parts() {
        depth += match part {
            "" | "." => 0,
            ".." => -1,
            _ => 1,
        };
        if depth < 0 {
            return Some("lies outside of the folder of the file");
        }
    }
    None
}

const ABSOLUTE: &str = "has an absolute path, which another computer does not have";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_stay_in_the_folder() {
        for path in ["a.png", "tex/a.png", "./a.png", "tex/../a.png", "tex\\a.png", "builtin:wood/base", "a b/c:d.png"] {
            assert_eq!(refusal(path), None, "{path}");
        }
        assert!(refusal("a\u{1e}.png").is_some());
        let refused = "/a.png C:/a.png C:\\a.png //host/a.png \\\\host\\a ../a.png tex/../../a.png tex\\..\\..\\a https://host/a.png file:a.png";
        for path in refused.split(' ') {
            assert!(refusal(path).is_some(), "{path}");
        }
    }
}

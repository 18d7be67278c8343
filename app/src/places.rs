//! Where the program keeps its own files: preferences, what it remembers between runs, and what it can make again.

use directories::ProjectDirs;
use std::ffi::OsString;
use std::path::PathBuf;

/// Environment variable naming one folder for everything that the program keeps, in place of the platform's.
///
/// Preferences go to `config` below it, state to `state`, what can be made again to `cache`. For installations on a
/// stick, and for tests, which must not touch the user's own files. Empty counts as unset.
pub const HOME_VARIABLE: &str = "BURNISH_HOME";

/// Folders of this user; none of them need exist. `None` where the platform does not tell, as without a home: the
/// program then works without remembering anything.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Places {
    /// Preferences: what a user would take along to another machine.
    pub config: Option<PathBuf>,
    /// Recent files, layout, unsaved work: what belongs to this machine and cannot be made again.
    pub state: Option<PathBuf>,
    /// What can be deleted at any time.
    pub cache: Option<PathBuf>,
}

impl Places {
    /// The folders that [`HOME_VARIABLE`] or else the platform names.
    pub fn find() -> Self {
        Self::of(std::env::var_os(HOME_VARIABLE))
    }

    fn of(home: Option<OsString>) -> Self {
        if let Some(home) = home.filter(|home| !home.is_empty()) {
            // Relative to where the program was started, and it may not stay there.
            let home = PathBuf::from(home);
            let home = std::path::absolute(&home).unwrap_or(home);
            return Self { config: Some(home.join("config")), state: Some(home.join("state")), cache: Some(home.join("cache")) };
        }
        let Some(folders) = ProjectDirs::from("", "", "burnish") else { return Self::default() };
        // Only some platforms tell state from data.
        let state = folders.state_dir().unwrap_or(folders.data_local_dir());
        Self {
            config: Some(folders.config_dir().to_path_buf()),
            state: Some(state.to_path_buf()),
            cache: Some(folders.cache_dir().to_path_buf()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use std::path::Path;

    #[test]
    fn the_variable_moves_everything() {
        let places = Places::of(Some("stick".into()));
        let home = std::env::current_dir().unwrap().join("stick");
        assert_eq!(places.config, Some(home.join("config")));
        assert_eq!(places.state, Some(home.join("state")));
        assert_eq!(places.cache, Some(home.join("cache")));
    }

    #[test]
    fn the_platform_names_three_folders_of_ours() {
        let Places { config: Some(config), state: Some(state), cache: Some(cache) } = Places::of(Some(OsString::new())) else {
            return; // A machine whose user has no home.
        };
        let all: BTreeSet<&Path> = [&*config, &*state, &*cache].into();
        assert_eq!(all.len(), 3, "{all:?}");
        let is_ours = |path: &Path| path.is_absolute() && path.to_string_lossy().to_lowercase().contains("burnish");
        assert!(all.iter().all(|path| is_ours(path)), "{all:?}");
    }

    #[test]
    fn a_user_without_a_home_is_no_error() {
        const CHILD: &str = "BURNISH_TEST_WITHOUT_HOME";
        if std::env::var_os(CHILD).is_some() {
            let _ = Places::find();
            return;
        }
        let mut child = std::process::Command::new(std::env::current_exe().unwrap());
        child.args(["--exact", "places::tests::a_user_without_a_home_is_no_error"]).env_clear().env(CHILD, "1");
        let output = child.output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
        assert!(String::from_utf8_lossy(&output.stdout).contains("1 passed"), "the child ran another test");
    }
}

//! Cameras that the user keeps, as `bookmarks.ron` in the state folder.

use crate::editor::Orbit;
use crate::files::FilesError;
use crate::own_files;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::path::Path;

const FILE: &str = "bookmarks.ron";
/// How many are read; nobody finds a hundred again.
const MAX: usize = 100;

/// A camera as the file has it: point in scene units, angles in degrees.
#[derive(Serialize, Deserialize)]
struct Stored {
    target: [f32; 3],
    azimuth: f32,
    elevation: f32,
    distance: f32,
    fov: f32,
}

/// What the state folder remembers, and a sentence for the user where the file is broken, which is set aside.
pub fn load_bookmarks(folder: &Path) -> (Vec<Orbit>, Option<String>) {
    let (stored, message) = own_files::load(&folder.join(FILE), own_files::MAX_BYTES, |text| {
        let stored: Vec<Stored> = ron::from_str(text).map_err(|error| format!("expected a list of cameras: {error}"))?;
        stored.iter().map(|stored| orbit(stored).ok_or("expected finite numbers, a distance above 0".to_owned())).collect()
    });
    let mut orbits: Vec<Orbit> = stored.unwrap_or_default();
    orbits.truncate(MAX);
    (orbits, message)
}

/// Saves them all.
pub fn save_bookmarks(folder: &Path, orbits: &[Orbit]) -> Result<(), FilesError> {
    let path = folder.join(FILE);
    let stored = orbits.iter().map(|orbit| Stored {
        target: orbit.target.to_array(),
        azimuth: orbit.azimuth_deg,
        elevation: orbit.elevation_deg,
        distance: orbit.distance,
        fov: orbit.fov_deg,
    });
    let text = ron::ser::to_string_pretty(&stored.collect::<Vec<_>>(), ron::ser::PrettyConfig::new())
        .map_err(|error| FilesError::Write { path: path.clone(), source: std::io::Error::other(error) })?;
    own_files::save(&path, &(text + "\n"))
}

/// The camera, if it can look at anything.
fn orbit(stored: &Stored) -> Option<Orbit> {
    let orbit = Orbit {
        target: Vec3::from_array(stored.target),
        azimuth_deg: stored.azimuth,
        elevation_deg: stored.elevation,
        distance: stored.distance,
        fov_deg: stored.fov,
    };
    let is_sound = orbit.target.is_finite() && orbit.azimuth_deg.is_finite() && (-90.0..=90.0).contains(&orbit.elevation_deg);
    let is_sound = is_sound && orbit.distance > 0.0 && orbit.distance.is_finite();
    (is_sound && (0.5..=170.0).contains(&orbit.fov_deg)).then_some(orbit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cameras_come_back_as_they_were() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(load_bookmarks(folder.path()), (vec![], None));
        let orbits =
            vec![Orbit::default(), Orbit { azimuth_deg: 123.456, target: Vec3::new(0.1, -2.0, 3e-7), ..Orbit::default() }];
        save_bookmarks(folder.path(), &orbits).unwrap();
        assert_eq!(load_bookmarks(folder.path()), (orbits, None));
    }

    #[test]
    fn a_camera_that_sees_nothing_is_set_aside() {
        let folder = tempfile::tempdir().unwrap();
        for distance in [0.0, f32::NAN, f32::INFINITY] {
            save_bookmarks(folder.path(), &[Orbit { distance, ..Orbit::default() }]).unwrap();
            let (orbits, message) = load_bookmarks(folder.path());
            assert!(orbits.is_empty() && message.is_some_and(|message| message.contains("a distance above 0")), "{distance}");
        }
    }
}

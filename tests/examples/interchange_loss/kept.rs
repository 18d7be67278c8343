//! What was measured, by name, with what it hangs on.

use burnish::files::save_atomic;
use serde_json::{Map, Value, json};
use std::error::Error;
use std::path::Path;

/// A measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// Mean of FLIP.
    pub flip: f64,
    /// Mean of FLIP with one property alone, the largest first; empty where that was not asked.
    pub by_property: Vec<(String, f64)>,
}

/// All measurements.
pub struct Kept(Map<String, Value>);

impl Kept {
    /// Those of a file; none if it is not there or none of ours.
    pub fn load(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).unwrap_or_default();
        Self(serde_json::from_str(&text).unwrap_or_default())
    }

    pub fn save(&self, path: &Path) -> Result<(), Box<dyn Error>> {
        Ok(save_atomic(path, serde_json::to_string(&self.0)?.as_bytes())?)
    }

    /// The measurement of this name, if it is of this state.
    pub fn get(&self, name: &str, state: &str) -> Option<Found> {
        let entry = self.0.get(name).filter(|entry| entry["state"] == state)?;
        let pair = |pair: &Value| Some((pair[0].as_str()?.to_owned(), pair[1].as_f64()?));
        let by_property = entry["by_property"].as_array()?.iter().map(pair).collect::<Option<_>>()?;
        Some(Found { flip: entry["flip"].as_f64()?, by_property })
    }

    pub fn put(&mut self, name: String, state: String, found: Found) {
        let by_property: Vec<Value> = found.by_property.iter().map(|(name, flip)| json!([name, flip])).collect();
        self.0.insert(name, json!({ "state": state, "flip": found.flip, "by_property": by_property }));
    }
}

//! Places in a material's JSON by the names of its parameters: keys with dots between them, `extensions` left out.

use serde_json::{Map, Value as Json};

/// The keys from the material down to the place.
fn keys(name: &str) -> impl Iterator<Item = &str> {
    let extension = name.split('.').next().filter(|key| key.contains("_materials_"));
    extension.map(|_| "extensions").into_iter().chain(name.split('.'))
}

/// What stands at a place of a material.
pub(super) fn at<'a>(material: &'a Json, name: &str) -> Option<&'a Json> {
    keys(name).try_fold(material, |json, key| json.get(key))
}

/// The place as a JSON pointer after that of the material.
pub(super) fn pointer(material: &str, name: &str) -> String {
    keys(name).fold(material.to_owned(), |all, key| all + "/" + key)
}

/// Puts a value at a place, and the objects around it where they are missing.
pub(super) fn put(material: &mut Map<String, Json>, name: &str, value: Json) {
    let keys: Vec<&str> = keys(name).collect();
    let Some((last, above)) = keys.split_last() else { return };
    let mut object = material;
    for key in above {
        let entry = object.entry((*key).to_owned()).or_insert_with(|| Json::Object(Map::new()));
        let Some(inner) = entry.as_object_mut() else { return };
        object = inner;
    }
    object.insert((*last).to_owned(), value);
}

//! USD: what is exported comes back bit for bit, what others write is understood, and what is broken is refused.

mod broken;
mod meshes;
mod others;
mod round_trips;

use burnish_material::Material;
use burnish_material::exchange::usd::{self, Export, Options, Scene};

fn export(materials: &[&Material]) -> Export {
    let path_of = |texture: &burnish_material::TextureRef| texture.path.clone();
    usd::write(materials, &Options { path_of: &path_of, image_folder: "textures/", mesh: None, has_native_copy: true })
}

fn read(text: &str) -> Scene {
    usd::read(text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

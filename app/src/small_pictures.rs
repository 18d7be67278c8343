//! Thumbnails as textures of the window: of maps, of the built-in meshes and of the built-in lights, made when they are first asked for.

use crate::thumbnails::{Key, Thumbnails};
use burnish_assets::{BuiltInTexture, Image};
use burnish_material::Channel;
use egui::{ColorImage, Context, TextureHandle, TextureId, TextureOptions};
use std::collections::HashMap;
use std::sync::Arc;

/// Side of a map's picture in pixels: it is shown large under the pointer.
const MAP_SIDE: usize = 192;
/// Side of the picture of a built-in texture in pixels.
const CARD_SIDE: usize = 128;
/// Textures kept; the others are made again when they are asked for.
const MAX_TEXTURES: usize = 256;

/// The pictures and their textures.
#[derive(Default)]
pub struct SmallPictures {
    thumbnails: Option<Thumbnails>,
    textures: HashMap<Key, TextureHandle>,
    /// The images that the maps' pictures are of: a file may be read again.
    images: HashMap<String, Arc<Image>>,
    has_built_in: bool,
}

impl SmallPictures {
    fn thumbnails(&mut self, ctx: &Context) -> &mut Thumbnails {
        let wake = ctx.clone();
        self.thumbnails.get_or_insert_with(|| Thumbnails::new(move || wake.request_repaint()))
    }

    /// Takes what was made. Once per frame.
    pub fn collect(&mut self) {
        if let Some(thumbnails) = &mut self.thumbnails {
            thumbnails.poll();
        }
        if self.textures.len() > MAX_TEXTURES {
            self.textures.clear();
        }
    }

    /// The picture of a built-in mesh or light, once it is made.
    pub fn built_in(&mut self, ctx: &Context, key: Key) -> Option<TextureId> {
        if !self.has_built_in {
            self.has_built_in = true;
            self.thumbnails(ctx).start_built_in();
        }
        self.texture(ctx, key)
    }

    /// The picture of a map, once it is made.
    pub fn map(&mut self, ctx: &Context, path: &str, image: &Arc<Image>, channel: Channel) -> Option<TextureId> {
        let key = Key::Texture(path.to_owned(), channel);
        if self.images.get(path).is_none_or(|known| !Arc::ptr_eq(known, image)) {
            self.images.insert(path.to_owned(), image.clone());
            self.textures.retain(|other, _| !matches!(other, Key::Texture(name, _) if name == path));
            for (channel, _) in Channel::ALL {
                self.thumbnails(ctx).forget(&Key::Texture(path.to_owned(), *channel));
            }
        }
        let thumbnails = self.thumbnails(ctx);
        if !thumbnails.is_started(&key) {
            thumbnails.start_texture(path, image, channel, MAP_SIDE);
        }
        self.texture(ctx, key)
    }

    /// The picture of a map of a built-in texture, once it is made.
    pub fn built_in_texture(&mut self, ctx: &Context, texture: BuiltInTexture) -> Option<TextureId> {
        let key = Key::BuiltInTexture(texture.path());
        let thumbnails = self.thumbnails(ctx);
        if !thumbnails.is_started(&key) {
            thumbnails.start_built_in_texture(texture, CARD_SIDE);
        }
        self.texture(ctx, key)
    }

    fn texture(&mut self, ctx: &Context, key: Key) -> Option<TextureId> {
        if let Some(texture) = self.textures.get(&key) {
            return Some(texture.id());
        }
        let small = self.thumbnails.as_ref()?.get(&key)?;
        let size = [small.width as usize, small.height as usize];
        let image = ColorImage::from_rgba_unmultiplied(size, &small.rgba);
        let texture = ctx.load_texture("small picture", image, TextureOptions::LINEAR);
        let id = texture.id();
        self.textures.insert(key, texture);
        Some(id)
    }

    /// How many pictures are made of how many that were asked for, while some are being made.
    pub fn progress(&self) -> Option<(usize, usize)> {
        self.thumbnails.as_ref().and_then(Thumbnails::progress)
    }

    /// Ends making pictures.
    pub fn cancel(&mut self) {
        if let Some(thumbnails) = &mut self.thumbnails {
            thumbnails.cancel();
        }
    }
}

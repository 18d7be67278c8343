//! How files name a map of a built-in texture, and what is made of it.

use std::fmt;

use glam::Vec3;

use super::grid::{Grid, Surface};
use super::{TEXTURES, TextureDef, TextureMap};
use crate::image::Image;

/// What paths to built-in textures begin with, in lower case.
pub const BUILT_IN_PREFIX: &str = "builtin:";

/// A map of a built-in texture with its settings, as the path of a texture names it:
/// `builtin:TEXTURE/MAP`, or `builtin:TEXTURE/MAP?mean=0.4,0.3,0.2&contrast=0.5`.
///
/// `mean` is what the map averages: one number, or three for a colour; without it the texture has one of its own. `contrast` is the power
/// that the variation about the mean is raised to, 0 for none; 1 is the texture's own. Only maps of colours and of roughness have them.
#[derive(Clone, Copy, Debug)]
pub struct BuiltInTexture {
    /// The texture.
    pub def: &'static TextureDef,
    /// The map.
    pub map: TextureMap,
    /// Area mean of the linear values, 0 to 1 each, equal for a map of numbers; `None` for that of the texture.
    pub mean: Option<[f32; 3]>,
    /// Power of the variation, 0 to [`MAX_CONTRAST`].
    pub contrast: f32,
}

/// Highest contrast: beyond, everything is black or white.
pub const MAX_CONTRAST: f32 = 4.0;

/// Why a path names no map of a built-in texture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TextureError {
    /// There is no texture of that name.
    Texture {
        /// The name as written.
        name: String,
    },
    /// The texture has no such map.
    Map {
        /// The texture.
        texture: &'static str,
        /// The name of the map as written; empty where there is none.
        name: String,
        /// The maps that the texture has.
        known: Vec<&'static str>,
    },
    /// A setting after the `?` cannot be used.
    Setting {
        /// The setting as written.
        setting: String,
        /// What was expected.
        expected: &'static str,
    },
}

impl TextureError {
    /// The name that was not found, and those that could have been meant; `None` for a wrong setting.
    pub fn unknown(&self) -> Option<(&str, Vec<&'static str>)> {
        match self {
            Self::Texture { name } => Some((name, TEXTURES.iter().map(|def| def.name).collect())),
            Self::Map { name, known, .. } => Some((name, known.clone())),
            Self::Setting { .. } => None,
        }
    }
}

impl fmt::Display for TextureError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Texture { name } => write!(f, "expected the name of a built-in texture, found `{name}`"),
            Self::Map { texture, name, known } => {
                write!(f, "expected a map of the built-in texture {texture} ({}), found `{name}`", known.join(", "))
            }
            Self::Setting { setting, expected } => write!(f, "expected {expected} of a built-in texture, found `{setting}`"),
        }
    }
}

impl std::error::Error for TextureError {}

impl BuiltInTexture {
    /// Reads the path of a texture; `None` if it names a file.
    pub fn parse(path: &str) -> Option<Result<Self, TextureError>> {
        let rest = path.strip_prefix(BUILT_IN_PREFIX)?;
        Some(Self::parse_name(rest))
    }

    /// A map of a texture without settings, if it has that map.
    pub fn new(def: &'static TextureDef, map: TextureMap) -> Option<Self> {
        def.maps.contains(&map).then_some(Self { def, map, mean: None, contrast: 1.0 })
    }

    /// Whether its mean and contrast can be set: those of colours and of roughness.
    pub fn has_settings(&self) -> bool {
        matches!(self.map, TextureMap::BaseColor | TextureMap::Roughness)
    }

    /// The path that names it; [`BuiltInTexture::parse`] reads it back. Settings that say nothing are left out.
    pub fn path(&self) -> String {
        let mut settings = Vec::new();
        if self.has_settings() {
            match self.mean {
                Some([r, g, b]) if self.map == TextureMap::BaseColor => settings.push(format!("mean={r},{g},{b}")),
                Some([x, ..]) => settings.push(format!("mean={x}")),
                None => {}
            }
            if self.contrast != 1.0 {
                settings.push(format!("contrast={}", self.contrast));
            }
        }
        let mark = if settings.is_empty() { "" } else { "?" };
        format!("{BUILT_IN_PREFIX}{}/{}{mark}{}", self.def.name, self.map.word(), settings.join("&"))
    }

    fn parse_name(text: &str) -> Result<Self, TextureError> {
        let (name, settings) = text.split_once('?').map_or((text, None), |(name, settings)| (name, Some(settings)));
        let (name, map) = name.split_once('/').unwrap_or((name, ""));
        let def = TEXTURES.iter().find(|def| def.name == name).ok_or_else(|| TextureError::Texture { name: name.to_owned() })?;
        let found = def.maps.iter().find(|known| known.word() == map);
        let map = *found.ok_or_else(|| TextureError::Map {
            texture: def.name,
            name: map.to_owned(),
            known: def.maps.iter().map(|map| map.word()).collect(),
        })?;
        let mut texture = Self { def, map, mean: None, contrast: 1.0 };
        for setting in settings.into_iter().flat_map(|settings| settings.split('&')) {
            texture.set(setting).map_err(|expected| TextureError::Setting { setting: setting.to_owned(), expected })?;
        }
        Ok(texture)
    }

    /// Takes a setting such as `mean=0.4`, or says what was expected.
    fn set(&mut self, setting: &str) -> Result<(), &'static str> {
        let is_color = self.map == TextureMap::BaseColor;
        if !self.has_settings() {
            return Err("no settings for this map");
        }
        let (key, text) = setting.split_once('=').ok_or("mean=NUMBERS or contrast=NUMBER")?;
        let numbers: Option<Vec<f32>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
        match (key, numbers.as_deref()) {
            ("mean", Some(&[x])) if is_within(x, 1.0) => self.mean = Some([x; 3]),
            ("mean", Some(&[r, g, b])) if is_color && [r, g, b].iter().all(|x| is_within(*x, 1.0)) => self.mean = Some([r, g, b]),
            ("contrast", Some(&[x])) if is_within(x, MAX_CONTRAST) => self.contrast = x,
            ("mean", _) if is_color => return Err("mean=RED,GREEN,BLUE with numbers from 0 to 1"),
            ("mean", _) => return Err("mean=NUMBER from 0 to 1"),
            ("contrast", _) => return Err("contrast=NUMBER from 0 to 4"),
            _ => return Err("mean=NUMBERS or contrast=NUMBER"),
        }
        Ok(())
    }

    fn of(&self, surface: &Surface) -> Image {
        let scalar = |grid: &Option<Grid<f32>>| grid.as_ref().map(|grid| grid.image());
        let made = match self.map {
            TextureMap::BaseColor => surface.base_color.as_ref().map(|grid| self.adjusted(grid.clone()).image()),
            TextureMap::Roughness => {
                surface.roughness.as_ref().map(|grid| self.adjusted(grid.map(|_, x| Vec3::splat(x))).image())
            }
            TextureMap::Metallic => scalar(&surface.metallic),
            TextureMap::AnisotropyRotation => scalar(&surface.anisotropy_rotation),
            TextureMap::Height => scalar(&surface.height),
            TextureMap::Normal => surface.normal_image(),
        };
        // A test makes every map of the table.
        made.unwrap_or(Image { width: 1, height: 1, texels: vec![[0.5; 4]], is_eight_bit: false })
    }

    /// With the contrast and the mean that were asked for, channel by channel.
    fn adjusted(&self, mut grid: Grid<Vec3>) -> Grid<Vec3> {
        if self.mean.is_none() && self.contrast == 1.0 {
            return grid;
        }
        for channel in 0..3 {
            let mut values: Vec<f32> = grid.values.iter().map(|v| v[channel]).collect();
            let own = mean(&values);
            let wanted = self.mean.map_or(own, |mean| mean[channel]);
            let contrast = self.contrast;
            values.iter_mut().for_each(|x| *x = (*x / own.max(1e-4)).max(0.0).powf(contrast));
            // Values end at 1, which lowers the mean; what is left over goes to the others.
            for _ in 0..24 {
                let now = mean(&values);
                if (now - wanted).abs() <= 1e-4 * wanted || now <= 0.0 {
                    break;
                }
                values.iter_mut().for_each(|x| *x = (*x * wanted / now).min(1.0));
            }
            grid.values.iter_mut().zip(values).for_each(|(v, x)| v[channel] = x);
        }
        grid
    }
}

/// Makes maps. What the maps of a texture have in common is made once while they are asked for one after the other.
#[derive(Default)]
pub struct TextureMaker {
    last: Option<(TextureDef, Surface)>,
}

impl TextureMaker {
    /// Makes a map, [`TextureDef::size`] texels along each side; the same bits every time.
    pub fn make(&mut self, texture: &BuiltInTexture) -> Image {
        let def = texture.def;
        if let Some((last, surface)) = &self.last
            && (last.name, last.size) == (def.name, def.size)
        {
            return texture.of(surface);
        }
        let surface = (def.make)(def.size);
        let image = texture.of(&surface);
        self.last = Some((*def, surface));
        image
    }
}

fn is_within(x: f32, highest: f32) -> bool {
    (0.0..=highest).contains(&x)
}

fn mean(values: &[f32]) -> f32 {
    (values.iter().map(|x| f64::from(*x)).sum::<f64>() / values.len() as f64) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_read_back() {
        for def in TEXTURES {
            for map in TextureMap::ALL.iter().map(|(map, _)| *map) {
                let Some(texture) = BuiltInTexture::new(def, map) else { continue };
                for mean in [None, Some([0.1, 0.1, 0.1]), Some([0.1, 0.25, 1.0])] {
                    for contrast in [1.0, 0.0, 0.3] {
                        let path = BuiltInTexture { mean, contrast, ..texture }.path();
                        let read = BuiltInTexture::parse(&path).expect("it is built in").expect("it is there");
                        assert_eq!((read.def.name, read.map, read.path()), (def.name, map, path.clone()));
                        if texture.has_settings() {
                            let mean = if map == TextureMap::BaseColor { mean } else { mean.map(|mean| [mean[0]; 3]) };
                            assert_eq!((read.mean, read.contrast), (mean, contrast), "{path}");
                        } else {
                            assert!(!path.contains('?'), "{path}");
                        }
                    }
                }
            }
        }
    }
}

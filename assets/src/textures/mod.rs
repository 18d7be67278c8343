//! The built-in textures: a row in the table each, made by code when a material names one.
//!
//! A material names a map as `builtin:wood-oak/base_color`, see [`BuiltInTexture`]. All maps tile, are the same every time, hold linear
//! values, and follow the coordinates of images: u to the right, v down.

mod cloth;
mod fibre;
mod grid;
mod hide;
mod marble;
mod masonry;
mod metal;
mod noise;
mod reference;
mod stone;
mod strokes;
mod wood;

pub use reference::{BUILT_IN_PREFIX, BuiltInTexture, MAX_CONTRAST, TextureError, TextureMaker};

use grid::Surface;

/// A map of a texture, named after the property that it is made for. Others may read it: `scatter_color` reads a map of base colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TextureMap {
    /// Linear Rec.709 reflectance, 0 to 1.
    BaseColor,
    /// 0 to 1 in all channels.
    Roughness,
    /// 1 where metal lies bare, 0 where it does not, in all channels.
    Metallic,
    /// Direction of fibres in turns, 0 to 1 in all channels; 0 is along u.
    AnisotropyRotation,
    /// 0 to 1 in all channels. See [`TextureDef::relief`].
    Height,
    /// Directions, stored as 0 to 1; OpenGL orientation (+Y up). Those of the height where there is one.
    Normal,
}

impl TextureMap {
    /// All maps with the words that files use.
    pub const ALL: &[(Self, &'static str)] = &[
        (Self::BaseColor, "base_color"),
        (Self::Roughness, "roughness"),
        (Self::Metallic, "metallic"),
        (Self::AnisotropyRotation, "anisotropy_rotation"),
        (Self::Height, "height"),
        (Self::Normal, "normal"),
    ];

    /// The word that files use.
    pub fn word(self) -> &'static str {
        Self::ALL.iter().find(|(map, _)| *map == self).map_or("", |(_, word)| word)
    }
}

/// A built-in texture.
#[derive(Clone, Copy, Debug)]
pub struct TextureDef {
    /// What files call it.
    pub name: &'static str,
    /// What it shows, in one sentence.
    pub doc: &'static str,
    /// The maps that it has.
    pub maps: &'static [TextureMap],
    /// Texels along each side.
    pub size: usize,
    /// Makes its surface with that many texels along each side; the same bits every time.
    make: fn(usize) -> Surface,
}

use TextureMap::{AnisotropyRotation, BaseColor, Height, Metallic, Normal, Roughness};

/// Maps of what has a colour, a gloss and a relief.
const FULL: &[TextureMap] = &[BaseColor, Roughness, Height, Normal];
/// Maps of cloth whose threads shine along their own direction.
const WOVEN: &[TextureMap] = &[BaseColor, Roughness, AnisotropyRotation, Height, Normal];
/// Maps of bare metal.
const BARE: &[TextureMap] = &[Roughness, Height, Normal];
/// Maps of metal under its own oxide.
const WEATHERED: &[TextureMap] = &[BaseColor, Roughness, Metallic, Height, Normal];

const fn row(name: &'static str, maps: &'static [TextureMap], make: fn(usize) -> Surface, doc: &'static str) -> TextureDef {
    TextureDef { name, doc, maps, size: 512, make }
}

/// Every built-in texture, those of a kind beside each other.
pub const TEXTURES: &[TextureDef] = &[
    row("wood-pine", FULL, wood::pine, "Pine board: wide rings with dark, sharp-edged late wood, along u."),
    row("wood-oak", FULL, wood::oak, "Oak board: rings with rows of open pores, and short dark rays, along u."),
    row("wood-walnut", FULL, wood::walnut, "Walnut board: dark streaks and long pores, along u."),
    row("wood-cherry", FULL, wood::cherry, "Cherry board: even, fine grain with tiny rays, along u."),
    row("wood-mahogany", FULL, wood::mahogany, "Mahogany board: even pores and shimmering ribbons, along u."),
    row("cork", FULL, wood::cork, "Pressed granules of cork."),
    row("cloth-plain", FULL, cloth::plain, "Plain weave, 32 threads a tile, as of linen and cotton."),
    row("cloth-burlap", FULL, cloth::burlap, "Coarse, open plain weave of uneven yarn, 20 threads a tile."),
    row("cloth-twill", FULL, cloth::twill, "Twill, two over two under: diagonal ribs, 32 threads a tile."),
    row("cloth-denim", FULL, cloth::denim, "Indigo warp over undyed weft, worn to its white core in places, 36 threads a tile."),
    row("cloth-satin", WOVEN, cloth::satin, "Satin of five: long floats of filament along v, 40 threads a tile."),
    row("cloth-knit", FULL, cloth::knit, "Stocking stitch, 12 columns and 16 rows a tile."),
    row("carbon-fibre", WOVEN, cloth::carbon, "Twill of carbon tows, two over two under, 8 tows a tile."),
    row("felt", FULL, fibre::felt, "Matted curly fibres."),
    row("paper", FULL, fibre::paper, "Fine fibres with the clouds of uncoated paper."),
    row("cardboard", FULL, fibre::cardboard, "Brown board with flutes along v showing through, 16 a tile."),
    row("metal-brushed", BARE, metal::brushed, "Fine scratches along u."),
    row("metal-ground", BARE, metal::ground, "Short curved scratches in all directions."),
    row("metal-cast", BARE, metal::cast, "The grain and pits of a sand mould."),
    row("metal-hammered", BARE, metal::hammered, "Dents of a round hammer, 9 across a tile."),
    row("rust", WEATHERED, metal::rust, "Iron with spreading rust."),
    row("patina", WEATHERED, metal::patina, "Copper with green streaks down v."),
    row("flakes", &[Normal], metal::flakes, "Metal flakes that each face their own way, for the base under a clear coat."),
    row("orange-peel", &[Height, Normal], metal::orange_peel, "The soft ripple of sprayed lacquer, for the normal of a coat."),
    row("marble-white", FULL, marble::white, "White marble with grey clouds and veins."),
    row("marble-black", FULL, marble::black, "Black marble with white and some brown veins."),
    row("marble-green", FULL, marble::green, "Green marble with pale veins."),
    row("granite", FULL, stone::granite, "Polished granite: feldspar, quartz and mica."),
    row("sandstone", FULL, stone::sandstone, "Sandstone with wavy beds along u."),
    row("travertine", FULL, stone::travertine, "Travertine: bands along u with rows of holes."),
    row("sand", FULL, stone::sand, "Sand with seven ripples of wind a tile, along u."),
    row("soil", FULL, stone::soil, "Crumbly earth with clods and small stones."),
    row("ice", FULL, stone::ice, "Ice with cracks and clouds of bubbles."),
    row("frost", FULL, stone::frost, "Feathers of hoar frost."),
    row("concrete", FULL, masonry::concrete, "Smooth concrete with stains and air holes."),
    row("plaster", FULL, masonry::plaster, "Plaster with the sweeps of a trowel."),
    row("terrazzo", FULL, masonry::terrazzo, "Chips of coloured stone in polished cement."),
    row("asphalt", FULL, masonry::asphalt, "Stones standing out of tar."),
    row("terracotta", FULL, masonry::terracotta, "Fired clay with specks, pores and marks of turning along u."),
    row("brick", FULL, masonry::brick, "Wall in running bond: 3 bricks and 8 courses a tile, along u."),
    row("leather", FULL, hide::leather, "Pebbled leather with creases, 24 pebbles across a tile."),
    row("skin", FULL, hide::skin, "Human skin: a net of furrows, pores, and uneven blood."),
    row("peel", FULL, hide::peel, "The rind of citrus fruit, 28 glands across a tile."),
];

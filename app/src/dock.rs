//! Which panels there are and where they stand: a tree of tiles with tabs that can be dragged, resized, hidden and remembered.

use egui::{Id, Ui, Vec2, vec2};
use egui_tiles::{Behavior, Container, Linear, LinearDir, Tile, TileId, Tiles, Tree};
use serde::{Deserialize, Serialize};

/// Points between panes.
pub const GAP: f32 = 3.0;

/// A part of the window that has a tab.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Pane {
    /// The pictures.
    View,
    /// The presets.
    Library,
    /// A folder of materials.
    Folder,
    /// The properties.
    Properties,
    /// The lobes in use and their costs.
    Lobes,
    /// The error over time.
    Chart,
    /// The stability report.
    Stability,
    /// What a check of the library found.
    Validation,
    /// Two materials beside each other.
    Diff,
    /// Versions of a material that become one.
    Merge,
    /// The steps made.
    History,
    /// What was said.
    Messages,
    /// Pictures and turntables to give away.
    Export,
    /// A photo to look at and pick colours from.
    Reference,
}

impl Pane {
    /// All panes.
    pub const ALL: [Self; 14] = [
        Self::View,
        Self::Library,
        Self::Folder,
        Self::Properties,
        Self::Lobes,
        Self::Chart,
        Self::Stability,
        Self::Validation,
        Self::Diff,
        Self::Merge,
        Self::History,
        Self::Messages,
        Self::Export,
        Self::Reference,
    ];

    /// What its tab says.
    pub fn title(self) -> &'static str {
        match self {
            Self::View => "View",
            Self::Library => "Presets",
            Self::Folder => "Library",
            Self::Properties => "Properties",
            Self::Lobes => "Lobes",
            Self::Chart => "Convergence",
            Self::Stability => "Stability",
            Self::Validation => "Validation",
            Self::Diff => "Diff",
            Self::Merge => "Merge",
            Self::History => "History",
            Self::Messages => "Messages",
            Self::Export => "Export",
            Self::Reference => "Reference",
        }
    }

    /// Points across and down that it needs with its tab at the usual size of text, so that nothing in it is cut off.
    fn room(self) -> Vec2 {
        match self {
            Self::View => vec2(340.0, 260.0),
            Self::Properties => vec2(386.0, 200.0),
            Self::Export => vec2(340.0, 200.0),
            Self::Library | Self::Folder => vec2(216.0, 120.0),
            Self::Validation => vec2(240.0, 200.0),
            Self::Diff | Self::Merge => vec2(340.0, 220.0),
            _ => vec2(150.0, 130.0),
        }
    }

    /// Points across above which a pane gains nothing, at the usual size of text.
    fn width_max(self) -> f32 {
        match self {
            Self::Properties | Self::Export => 620.0,
            Self::Library | Self::Folder => 560.0,
            _ => f32::INFINITY,
        }
    }
}

/// Panes that layouts of older versions lack, beside which they come, and whether they are shown at once.
const NEWER: [(Pane, Pane, bool); 5] = [
    (Pane::Folder, Pane::Library, true),
    (Pane::Export, Pane::Properties, true),
    (Pane::Validation, Pane::Stability, false),
    (Pane::Diff, Pane::View, false),
    (Pane::Merge, Pane::View, false),
];

/// Shares of a line before its panes were fitted, with what they were set to.
type Fitted = (TileId, Vec<(TileId, f32, f32)>);

/// The tree of panes.
pub struct Dock {
    /// The tree; taken out while it is drawn.
    pub tree: Tree<Pane>,
}

impl Default for Dock {
    fn default() -> Self {
        let mut tiles = Tiles::default();
        let tab = |tiles: &mut Tiles<Pane>, panes: &[Pane]| {
            let children = panes.iter().map(|pane| tiles.insert_pane(*pane)).collect();
            tiles.insert_tab_tile(children)
        };
        let library = tab(&mut tiles, &[Pane::Library, Pane::Folder]);
        let view = tab(&mut tiles, &[Pane::View, Pane::Diff, Pane::Merge]);
        let lobes = tab(&mut tiles, &[Pane::Lobes, Pane::Stability, Pane::Validation, Pane::History, Pane::Messages]);
        let chart = tab(&mut tiles, &[Pane::Chart]);
        let properties = tab(&mut tiles, &[Pane::Properties, Pane::Export]);
        let reference = tab(&mut tiles, &[Pane::Reference]);
        let linear = |tiles: &mut Tiles<Pane>, dir, children: &[(TileId, f32)]| {
            let mut linear = Linear::new(dir, children.iter().map(|(id, _)| *id).collect());
            children.iter().for_each(|(id, share)| linear.shares.set_share(*id, *share));
            tiles.insert_container(Container::Linear(linear))
        };
        let below = linear(&mut tiles, LinearDir::Horizontal, &[(lobes, 0.6), (chart, 0.4)]);
        let above = linear(&mut tiles, LinearDir::Horizontal, &[(view, 0.7), (reference, 0.3)]);
        let middle = linear(&mut tiles, LinearDir::Vertical, &[(above, 0.8), (below, 0.2)]);
        let root = linear(&mut tiles, LinearDir::Horizontal, &[(library, 0.165), (middle, 0.525), (properties, 0.31)]);
        let mut dock = Self { tree: Tree::new(Id::unique("dock"), root, tiles) };
        for pane in [Pane::Reference, Pane::Validation, Pane::Diff, Pane::Merge] {
            dock.set_shown(pane, false);
        }
        dock
    }
}

impl Dock {
    /// No panes: what stands in for a dock that is being drawn.
    pub fn empty() -> Self {
        Self { tree: Tree::empty(Id::unique("dock")) }
    }

    /// Reads what [`Self::to_text`] wrote, also before there were all panes of today; `None` if it is no layout with every pane once.
    pub fn from_text(text: &str) -> Option<Self> {
        let mut tree: Tree<Pane> = ron::from_str(text).ok()?;
        for (pane, beside, is_shown) in NEWER {
            if tree.tiles.find_pane(&pane).is_none() {
                let beside = tree.tiles.parent_of(tree.tiles.find_pane(&beside)?)?;
                let id = tree.tiles.insert_pane(pane);
                match tree.tiles.get_mut(beside) {
                    Some(Tile::Container(container)) => container.add_child(id),
                    _ => return None,
                }
                tree.set_visible(id, is_shown);
            }
        }
        let count = |pane: Pane| tree.tiles.tiles().filter(|tile| **tile == Tile::Pane(pane)).count();
        let is_whole = Pane::ALL.into_iter().all(|pane| count(pane) == 1) && tree.root().is_some();
        let dock = Self { tree };
        (is_whole && dock.tree.is_visible(dock.id(Pane::View)?)).then_some(dock)
    }

    /// The layout as text.
    pub fn to_text(&self) -> Option<String> {
        ron::to_string(&self.tree).ok()
    }

    fn id(&self, pane: Pane) -> Option<TileId> {
        self.tree.tiles.find_pane(&pane)
    }

    /// Whether no other tab is shown beside that of a pane.
    pub fn is_alone(&self, pane: Pane) -> bool {
        let parent = self.id(pane).and_then(|id| self.tree.tiles.parent_of(id)).and_then(|id| self.tree.tiles.get(id));
        let Some(Tile::Container(container)) = parent else { return true };
        container.children().filter(|child| self.tree.tiles.is_visible(**child)).count() <= 1
    }

    /// Whether a pane is being drawn: not hidden, and in front of its tabs.
    pub fn is_drawn(&self, pane: Pane) -> bool {
        self.id(pane).is_some_and(|id| self.tree.is_visible(id) && self.tree.active_tiles().contains(&id))
    }

    /// Whether a pane has a tab that can be seen, in front or behind others.
    pub fn is_shown(&self, pane: Pane) -> bool {
        self.id(pane).is_some_and(|id| self.tree.is_visible(id))
    }

    /// Shows a pane in front of its tabs, or hides it.
    pub fn set_shown(&mut self, pane: Pane, is_shown: bool) {
        let Some(id) = self.id(pane) else { return };
        self.tree.set_visible(id, is_shown);
        if is_shown {
            self.tree.make_active(|other, _| other == id);
        }
        self.tidy(id);
    }

    /// Hides the containers in which nothing is shown any more, and shows those in which something is.
    fn tidy(&mut self, mut id: TileId) {
        while let Some(parent) = self.tree.tiles.parent_of(id) {
            let children: Vec<TileId> = match self.tree.tiles.get(parent) {
                Some(Tile::Container(container)) => container.children().copied().collect(),
                _ => Vec::new(),
            };
            let has_any = children.iter().any(|child| self.tree.tiles.is_visible(*child));
            self.tree.set_visible(parent, has_any);
            if let Some(Tile::Container(Container::Tabs(tabs))) = self.tree.tiles.get_mut(parent)
                && let Some(active) = tabs.active
                && !children.is_empty()
            {
                let next = children.iter().copied().find(|child| *child == active && self.tree.tiles.is_visible(*child));
                let next = next.or_else(|| children.iter().copied().find(|child| self.tree.tiles.is_visible(*child)));
                if let (Some(next), Some(Tile::Container(Container::Tabs(tabs)))) = (next, self.tree.tiles.get_mut(parent)) {
                    tabs.set_active(next);
                }
            }
            id = parent;
        }
    }

    /// Draws the tree, each pane with at least the room that it needs at this scale of text, where there is enough for all, and the panels beside the
    /// view no wider than they have use for. The shares stay as the user made them, so that a window of another size has them again.
    pub fn show(&mut self, ui: &mut Ui, behavior: &mut dyn Behavior<Pane>, text_scale: f32) {
        let lines = self.lines(ui.available_size());
        let fitted: Vec<Fitted> = lines.into_iter().filter_map(|(id, size)| self.fit(id, size, text_scale)).collect();
        self.tree.ui(behavior, ui);
        for (id, shares) in fitted {
            // Where the user drags an edge, what is seen is what is meant.
            if let Some(linear) = self.line_mut(id)
                && shares.iter().all(|(id, _, set)| linear.shares[*id] == *set)
            {
                shares.iter().for_each(|(id, old, _)| linear.shares.set_share(*id, *old));
            }
        }
    }

    /// Rows and columns, and how large each is; `size` is that of the whole.
    fn lines(&self, size: Vec2) -> Vec<(TileId, Vec2)> {
        let is_line = |tile: &Tile<Pane>| matches!(tile, Tile::Container(Container::Linear(_)));
        let lines = self.tree.tiles.iter().filter(|(_, tile)| is_line(tile)).map(|(id, _)| *id);
        let size_of = |id| if self.tree.root() == Some(id) { Some(size) } else { Some(self.tree.tiles.rect(id)?.size()) };
        lines.filter_map(|id| Some((id, size_of(id)?))).collect()
    }

    fn line_mut(&mut self, id: TileId) -> Option<&mut Linear> {
        match self.tree.tiles.get_mut(id) {
            Some(Tile::Container(Container::Linear(linear))) => Some(linear),
            _ => None,
        }
    }

    /// Points across and down that a tile needs.
    fn room(&self, id: TileId, text_scale: f32) -> Vec2 {
        let container = match self.tree.tiles.get(id) {
            Some(Tile::Pane(pane)) => return pane.room() * text_scale,
            Some(Tile::Container(container)) => container,
            None => return Vec2::ZERO,
        };
        let shown = container.children().filter(|child| self.tree.tiles.is_visible(**child));
        shown.map(|child| self.room(*child, text_scale)).fold(Vec2::ZERO, |all, one| match container {
            Container::Linear(linear) if linear.dir == LinearDir::Horizontal => vec2(all.x + one.x, all.y.max(one.y)),
            Container::Linear(_) => vec2(all.x.max(one.x), all.y + one.y),
            _ => all.max(one),
        })
    }

    /// Points across above which a tile gains nothing.
    fn width_max(&self, id: TileId, text_scale: f32) -> f32 {
        match self.tree.tiles.get(id) {
            Some(Tile::Pane(pane)) => pane.width_max() * text_scale,
            Some(Tile::Container(container)) => {
                let shown = container.children().filter(|child| self.tree.tiles.is_visible(**child));
                shown.map(|child| self.width_max(*child, text_scale)).fold(0.0, f32::max)
            }
            None => f32::INFINITY,
        }
    }

    /// Gives the children of a line what they need, and no more than they have use for; `None` where nothing is to be done or nothing can be.
    fn fit(&mut self, id: TileId, size: Vec2, text_scale: f32) -> Option<Fitted> {
        let linear = self.line_mut(id)?;
        let is_row = linear.dir == LinearDir::Horizontal;
        let along = |v: Vec2| if is_row { v.x } else { v.y };
        let children: Vec<(TileId, f32)> = linear.children.iter().map(|id| (*id, linear.shares[*id])).collect();
        let shown: Vec<(TileId, f32)> = children.into_iter().filter(|(id, _)| self.tree.tiles.is_visible(*id)).collect();
        let gaps = GAP * shown.len().saturating_sub(1) as f32;
        let needs: Vec<f32> = shown.iter().map(|(id, _)| along(self.room(*id, text_scale))).collect();
        let shares: Vec<f32> = shown.iter().map(|(_, share)| *share).collect();
        let most = |id: &TileId| if is_row { self.width_max(*id, text_scale) } else { f32::INFINITY };
        let most: Vec<f32> = shown.iter().map(|(id, _)| most(id)).collect();
        let sizes = split(&shares, &needs, &most, along(size) - gaps)?;
        let (total, room): (f32, f32) = (shares.iter().sum(), sizes.iter().sum());
        let set: Vec<_> = shown.iter().zip(&sizes).map(|((id, old), size)| (*id, *old, size * total / room)).collect();
        let linear = self.line_mut(id)?;
        set.iter().for_each(|(id, _, share)| linear.shares.set_share(*id, *share));
        Some((id, set))
    }

    /// Shows a pane that is not being drawn, hides one that is.
    pub fn toggle(&mut self, pane: Pane) {
        self.set_shown(pane, !self.is_drawn(pane));
    }

    /// Hides what is shown where a tab was closed.
    pub fn close(&mut self, id: TileId) {
        self.tree.set_visible(id, false);
        self.tidy(id);
    }
}

/// Splits `size` by shares, each with at least what it needs and with at most what it has use for, which is more; `None` if the shares give that
/// already, or if it cannot be had.
fn split(shares: &[f32], needs: &[f32], most: &[f32], size: f32) -> Option<Vec<f32>> {
    if needs.iter().sum::<f32>() > size || most.iter().sum::<f32>() < size {
        return None;
    }
    let mut fixed: Vec<Option<f32>> = vec![None; shares.len()];
    loop {
        let free: f32 = shares.iter().zip(&fixed).filter(|(_, fixed)| fixed.is_none()).map(|(share, _)| share).sum();
        let per_share = (size - fixed.iter().flatten().sum::<f32>()) / free.max(1e-6);
        let outside = |i: usize| {
            let given = shares[i] * per_share;
            let limited = given.min(most[i]).max(needs[i]);
            (fixed[i].is_none() && given != limited).then_some((i, limited))
        };
        match (0..shares.len()).find_map(outside) {
            Some((i, limited)) => fixed[i] = Some(limited),
            None if fixed.iter().any(Option::is_some) => {
                return Some((0..shares.len()).map(|i| fixed[i].unwrap_or(shares[i] * per_share)).collect());
            }
            None => return None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_panes_take_from_large_ones() {
        let any = [f32::INFINITY; 3];
        assert_eq!(split(&[1.0, 3.0], &[10.0, 10.0], &any[..2], 100.0), None, "there is room");
        assert_eq!(split(&[1.0, 3.0], &[60.0, 60.0], &any[..2], 100.0), None, "there is too little");
        assert_eq!(split(&[1.0, 2.0, 1.0], &[10.0, 10.0, 40.0], &any, 100.0), Some(vec![20.0, 40.0, 40.0]));
        assert_eq!(
            split(&[1.0, 2.0, 1.0], &[25.0, 10.0, 50.0], &any, 100.0),
            Some(vec![25.0, 25.0, 50.0]),
            "one after the other"
        );
    }

    #[test]
    fn what_panels_have_no_use_for_goes_to_the_view() {
        assert_eq!(split(&[1.0, 2.0, 1.0], &[10.0; 3], &[20.0, f32::INFINITY, 30.0], 200.0), Some(vec![20.0, 150.0, 30.0]));
        assert_eq!(split(&[1.0, 1.0], &[10.0; 2], &[20.0, 30.0], 200.0), None, "somebody has to have it");
    }

    #[test]
    fn layouts_from_before_there_were_panes_get_them_hidden() {
        let (mut dock, new) = (Dock::default(), [Pane::Validation, Pane::Diff, Pane::Merge]);
        for pane in new {
            let id = dock.id(pane).unwrap();
            dock.tree.remove_recursively(id);
        }
        let mut again = Dock::from_text(&dock.to_text().unwrap()).unwrap();
        assert!(new.into_iter().all(|pane| !again.is_shown(pane)) && again.is_alone(Pane::View));
        again.set_shown(Pane::Diff, true);
        assert!(again.is_drawn(Pane::Diff) && !again.is_drawn(Pane::View) && !again.is_alone(Pane::View));
        again.set_shown(Pane::Diff, false);
        assert!(again.is_drawn(Pane::View));
    }

    #[test]
    fn panes_come_back_as_they_were() {
        let mut dock = Dock::default();
        assert!(dock.is_drawn(Pane::Lobes) && !dock.is_drawn(Pane::Stability) && !dock.is_drawn(Pane::Reference));
        dock.toggle(Pane::Stability);
        assert!(!dock.is_drawn(Pane::Lobes) && dock.is_drawn(Pane::Stability));
        dock.toggle(Pane::Reference);
        let mut again = Dock::from_text(&dock.to_text().unwrap()).unwrap();
        assert!(again.is_drawn(Pane::Stability) && again.is_drawn(Pane::Reference));
        again.toggle(Pane::Stability);
        assert!(again.is_drawn(Pane::Lobes) && !again.is_drawn(Pane::Stability));
        for pane in [Pane::Lobes, Pane::History, Pane::Messages, Pane::Chart] {
            again.set_shown(pane, false);
        }
        assert!(again.is_drawn(Pane::View));
        again.toggle(Pane::Chart);
        assert!(again.is_drawn(Pane::Chart));
        assert!(Dock::from_text("()").is_none());
    }
}

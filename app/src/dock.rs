//! Which panels there are and where they stand: a tree of tiles with tabs that can be dragged, resized, hidden and remembered.

use egui::Id;
use egui_tiles::{Container, Linear, LinearDir, Tile, TileId, Tiles, Tree};
use serde::{Deserialize, Serialize};

/// A part of the window that has a tab.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Pane {
    /// The pictures.
    View,
    /// The presets.
    Library,
    /// The properties.
    Properties,
    /// The lobes in use and their costs.
    Lobes,
    /// The error over time.
    Chart,
    /// The stability report.
    Stability,
    /// The steps made.
    History,
    /// What was said.
    Messages,
    /// A photo to look at and pick colours from.
    Reference,
}

impl Pane {
    /// All panes.
    pub const ALL: [Self; 9] = [
        Self::View,
        Self::Library,
        Self::Properties,
        Self::Lobes,
        Self::Chart,
        Self::Stability,
        Self::History,
        Self::Messages,
        Self::Reference,
    ];

    /// What its tab says.
    pub fn title(self) -> &'static str {
        match self {
            Self::View => "View",
            Self::Library => "Presets",
            Self::Properties => "Properties",
            Self::Lobes => "Lobes",
            Self::Chart => "Convergence",
            Self::Stability => "Stability",
            Self::History => "History",
            Self::Messages => "Messages",
            Self::Reference => "Reference",
        }
    }
}

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
        let library = tab(&mut tiles, &[Pane::Library]);
        let view = tab(&mut tiles, &[Pane::View]);
        let lobes = tab(&mut tiles, &[Pane::Lobes, Pane::Stability, Pane::History, Pane::Messages]);
        let chart = tab(&mut tiles, &[Pane::Chart]);
        let properties = tab(&mut tiles, &[Pane::Properties]);
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
        dock.set_shown(Pane::Reference, false);
        dock
    }
}

impl Dock {
    /// No panes: what stands in for a dock that is being drawn.
    pub fn empty() -> Self {
        Self { tree: Tree::empty(Id::unique("dock")) }
    }

    /// Reads what [`Self::to_text`] wrote; `None` if it is no layout with every pane once.
    pub fn from_text(text: &str) -> Option<Self> {
        let tree: Tree<Pane> = ron::from_str(text).ok()?;
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

    /// Whether a pane is being drawn: not hidden, and in front of its tabs.
    pub fn is_drawn(&self, pane: Pane) -> bool {
        self.id(pane).is_some_and(|id| self.tree.is_visible(id) && self.tree.active_tiles().contains(&id))
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

#[cfg(test)]
mod tests {
    use super::*;

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

//! The open documents. The one in front lies in the editor; the others wait here with their histories.

use crate::editor::Document;
use crate::history::History;
use crate::sides::Sides;

/// A document with all that belongs to it.
#[derive(Clone, Debug)]
pub struct Work {
    /// The material and its file.
    pub document: Document,
    /// Its steps.
    pub history: History,
    /// What it is compared with.
    pub sides: Sides,
}

impl Work {
    /// A document that was just opened or made.
    pub fn new(document: Document) -> Self {
        Self { history: History::new(&document), document, sides: Sides::default() }
    }
}

#[derive(Clone, Debug)]
struct Tab {
    id: u64,
    /// `None` while it is in front.
    parked: Option<Box<Work>>,
}

/// The list of open documents, and which is in front. There is always one.
#[derive(Clone, Debug)]
pub struct Tabs {
    list: Vec<Tab>,
    front: usize,
    next_id: u64,
}

impl Default for Tabs {
    fn default() -> Self {
        Self { list: vec![Tab { id: 0, parked: None }], front: 0, next_id: 1 }
    }
}

impl Tabs {
    /// How many documents are open.
    pub fn count(&self) -> usize {
        self.list.len()
    }

    /// The place of the one in front.
    pub fn front(&self) -> usize {
        self.front
    }

    /// Its number, which no other document ever has.
    pub fn front_id(&self) -> u64 {
        self.list[self.front].id
    }

    /// The place of a document by its number, if it is still open.
    pub fn place_of(&self, id: u64) -> Option<usize> {
        self.list.iter().position(|tab| tab.id == id)
    }

    /// Numbers and documents in order; `front` is the one in the editor.
    pub fn documents<'a>(&'a self, front: &'a Document) -> impl Iterator<Item = (u64, &'a Document)> {
        self.list.iter().map(move |tab| (tab.id, tab.parked.as_ref().map_or(front, |work| &work.document)))
    }

    /// A document that waits, by its number.
    pub fn parked_mut(&mut self, id: u64) -> Option<&mut Work> {
        self.list.iter_mut().find(|tab| tab.id == id)?.parked.as_deref_mut()
    }

    /// Puts a new document behind all others and in front; `front` becomes it, and what it was waits.
    pub fn open(&mut self, front: &mut Work, work: Work) {
        self.list.push(Tab { id: self.next_id, parked: Some(Box::new(work)) });
        self.next_id += 1;
        self.bring_to_front(self.list.len() - 1, front);
    }

    /// Exchanges `front` with the document at a place.
    pub fn bring_to_front(&mut self, place: usize, front: &mut Work) {
        if place == self.front {
            return;
        }
        if let Some(work) = self.list.get_mut(place).and_then(|tab| tab.parked.take()) {
            self.list[self.front].parked = Some(Box::new(std::mem::replace(front, *work)));
            self.front = place;
        }
    }

    /// Forgets the document in front; the next one takes its place, or a new one if it was the last.
    pub fn close_front(&mut self, front: &mut Work, new: impl FnOnce() -> Work) {
        self.list.remove(self.front);
        if self.list.is_empty() {
            self.list.push(Tab { id: self.next_id, parked: Some(Box::new(new())) });
            self.next_id += 1;
        }
        self.front = self.front.min(self.list.len() - 1);
        if let Some(work) = self.list[self.front].parked.take() {
            *front = *work;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use burnish_material::Material;

    fn work(name: &str) -> Work {
        Work::new(Document::new(Material::named(name)))
    }

    fn names(tabs: &Tabs, front: &Work) -> String {
        tabs.documents(&front.document).map(|(_, document)| document.title()).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn documents_come_and_go_in_order() {
        let (mut tabs, mut front) = (Tabs::default(), work("a"));
        tabs.open(&mut front, work("b"));
        tabs.open(&mut front, work("c"));
        assert_eq!((names(&tabs, &front).as_str(), front.document.title().as_str()), ("a b c", "c"));
        let id = tabs.front_id();
        tabs.bring_to_front(0, &mut front);
        assert_eq!((names(&tabs, &front).as_str(), front.document.title().as_str()), ("a b c", "a"));
        assert_eq!(tabs.place_of(id), Some(2));
        tabs.close_front(&mut front, || work("new"));
        assert_eq!((names(&tabs, &front).as_str(), front.document.title().as_str()), ("b c", "b"));
        tabs.bring_to_front(1, &mut front);
        tabs.close_front(&mut front, || work("new"));
        tabs.close_front(&mut front, || work("new"));
        assert_eq!((names(&tabs, &front).as_str(), tabs.count()), ("new", 1));
        assert_eq!(tabs.place_of(id), None);
    }
}

//! Undo and redo: whole documents, one step per gesture, named by what differs.
//!
//! A material is a few kilobytes, so a step stores all of it and nothing needs an inverse. Images are shared between steps.

use crate::editor::Document;
use burnish_material::{Material, PROPERTIES, Property, Slot, Value};

/// Memory that the steps of one document may take; the oldest are forgotten first. Thousands of steps fit.
const MAX_BYTES: usize = 64 << 20;

/// One state of the document and what led to it.
#[derive(Clone, Debug)]
struct Step {
    label: String,
    document: Document,
    bytes: usize,
}

impl Step {
    fn new(label: String, document: Document) -> Self {
        let bytes = size(&document.material) + label.len();
        Self { label, document, bytes }
    }
}

/// About how much memory a material takes.
fn size(material: &Material) -> usize {
    let texts = [&material.name, &material.notes, &material.provenance.source, &material.provenance.reference];
    let foreign = material.foreign.values().flat_map(|texts| texts.iter().map(|(key, text)| key.len() + text.len()));
    let maps = material.slots().filter_map(|(_, slot)| slot.texture.as_ref()).map(|texture| texture.path.len());
    size_of::<Material>()
        + PROPERTIES.len() * size_of::<Slot>()
        + texts.iter().map(|text| text.len()).sum::<usize>()
        + material.aliases.iter().chain(&material.tags).map(String::len).sum::<usize>()
        + maps.chain(foreign).sum::<usize>()
}

/// The states that undo and redo walk through.
#[derive(Clone, Debug)]
pub struct History {
    steps: Vec<Step>,
    current: usize,
    /// The state of a gesture that goes on.
    pending: Option<Document>,
}

impl History {
    /// A history whose first state is `document`.
    pub fn new(document: &Document) -> Self {
        Self { steps: vec![Step::new("Open".into(), document.clone())], current: 0, pending: None }
    }

    /// Takes note of a changed document. The step is made later, by [`Self::settle`].
    pub fn feed(&mut self, document: &Document) {
        self.pending = Some(document.clone());
    }

    /// Makes one step of everything fed since the last one, unless the document is back where it was.
    pub fn settle(&mut self) {
        if let Some(document) = self.pending.take() {
            let label = describe(&self.now().material, &document.material);
            self.push(label, document);
        }
    }

    /// Forgets the gesture that goes on; the material to return to.
    pub fn cancel(&mut self) -> &Material {
        self.pending = None;
        &self.now().material
    }

    /// Makes a step with a name of its own, after settling what was pending.
    pub fn commit(&mut self, label: impl Into<String>, document: &Document) {
        self.settle();
        self.push(label.into(), document.clone());
    }

    fn push(&mut self, label: String, document: Document) {
        if self.now().is_same(&document) {
            return;
        }
        self.steps.truncate(self.current + 1);
        self.steps.push(Step::new(label, document));
        let mut bytes: usize = self.steps.iter().map(|step| step.bytes).sum();
        let mut forgotten = 0;
        while bytes > MAX_BYTES && forgotten + 2 < self.steps.len() {
            bytes -= self.steps[forgotten].bytes;
            forgotten += 1;
        }
        self.steps.drain(..forgotten);
        self.current = self.steps.len() - 1;
    }

    fn now(&self) -> &Document {
        &self.steps[self.current].document
    }

    /// The name of the step that undo takes back.
    pub fn undo_label(&self) -> Option<&str> {
        if self.pending.is_some() {
            return Some("Edit");
        }
        (self.current > 0).then(|| self.steps[self.current].label.as_str())
    }

    /// The name of the step that redo makes again.
    pub fn redo_label(&self) -> Option<&str> {
        self.steps.get(self.current + 1).map(|step| step.label.as_str())
    }

    /// Goes one step back; the name of the step taken back and the state to return to.
    pub fn undo(&mut self) -> Option<(String, Document)> {
        self.settle();
        let label = self.undo_label()?.to_owned();
        self.current -= 1;
        Some((label, self.now().clone()))
    }

    /// Goes one step forward; the name of the step and the state it leads to.
    pub fn redo(&mut self) -> Option<(String, Document)> {
        self.settle();
        let label = self.redo_label()?.to_owned();
        self.current += 1;
        Some((label, self.now().clone()))
    }

    /// Whether a gesture goes on.
    pub fn is_pending(&self) -> bool {
        self.pending.is_some()
    }

    /// Whether the newest state it knows of is this one.
    pub fn holds(&self, document: &Document) -> bool {
        self.pending.as_ref().unwrap_or_else(|| self.now()).is_same(document)
    }

    /// Names of all steps with whether each is the current state, oldest first.
    pub fn labels(&self) -> impl Iterator<Item = (&str, bool)> {
        self.steps.iter().enumerate().map(|(i, step)| (step.label.as_str(), i == self.current))
    }

    /// Goes to any step by its place in [`Self::labels`].
    pub fn go_to(&mut self, index: usize) -> Option<Document> {
        self.settle();
        self.steps.get(index)?;
        self.current = index;
        Some(self.now().clone())
    }

    /// Tells all states of the file `old` that it now holds what `saved` says: afterwards only a state that equals the
    /// saved one counts as unchanged.
    pub fn rebase(&mut self, old: &Document, saved: &Document) {
        self.settle();
        for step in &mut self.steps {
            if step.document.shares_origin(old) {
                step.document.take_origin(saved);
            }
        }
        self.steps[self.current].document = saved.clone();
    }
}

/// What was done between two states, in a few words: `Roughness 0.30 → 0.42`.
pub fn describe(before: &Material, after: &Material) -> String {
    let changed: Vec<Property> = PROPERTIES.iter().map(|def| def.id).filter(|&p| before.slot(p) != after.slot(p)).collect();
    match changed.as_slice() {
        [] if before.name != after.name => format!("Rename to {}", after.name),
        [] if before.unit_mm != after.unit_mm => format!("Unit {} mm → {} mm", number(before.unit_mm()), number(after.unit_mm())),
        [] => "Edit notes".into(),
        [property] => describe_slot(*property, before.slot(*property), after.slot(*property)),
        [first, second] => format!("{} and {}", first.def().label, second.def().label),
        all => format!("{} properties", all.len()),
    }
}

fn describe_slot(property: Property, before: &Slot, after: &Slot) -> String {
    let def = property.def();
    if *after == Slot::default() {
        return format!("Reset {}", def.label);
    }
    match (&before.texture, &after.texture) {
        (None, Some(texture)) => return format!("{} map {}", def.label, texture.path),
        (Some(_), None) => return format!("Remove {} map", def.label),
        (Some(a), Some(b)) if a.path != b.path => return format!("{} map {}", def.label, b.path),
        (a, b) if a != b => return format!("{} map settings", def.label),
        _ => {}
    }
    let [from, to] = [before, after].map(|slot| slot.value.unwrap_or(def.default));
    match (from, to) {
        (Value::Float(from), Value::Float(to)) => format!("{} {} → {}", def.label, number(from), number(to)),
        (Value::Bool(_), Value::Bool(to)) => format!("{} {}", def.label, if to { "on" } else { "off" }),
        (_, Value::Color(c)) => format!("{} → ({}, {}, {})", def.label, number(c[0]), number(c[1]), number(c[2])),
        _ => def.label.to_owned(),
    }
}

/// A number in few digits, at least two decimals below 10.
fn number(x: f64) -> String {
    let decimals = if x == 0.0 || (0.1..10.0).contains(&x.abs()) {
        2
    } else if x.abs() < 0.1 {
        4
    } else {
        1
    };
    format!("{x:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn start() -> (Document, History) {
        let document = Document::new(Material::named("test"));
        let history = History::new(&document);
        (document, history)
    }

    #[test]
    fn one_gesture_is_one_step() {
        let (mut document, mut history) = start();
        for i in 1..=10 {
            document.material.set(Property::roughness, Value::Float(0.3 + 0.012 * f64::from(i)));
            history.feed(&document);
        }
        history.settle();
        assert_eq!(history.undo_label(), Some("Roughness 0.30 → 0.42"));
        let (_, back) = history.undo().unwrap();
        assert_eq!(back.material, Material::named("test"));
        assert!(history.undo().is_none());
        let (label, again) = history.redo().unwrap();
        assert_eq!((label.as_str(), again.material.float(Property::roughness)), ("Roughness 0.30 → 0.42", 0.42));
    }

    #[test]
    fn a_gesture_back_to_its_start_is_no_step() {
        let (mut document, mut history) = start();
        document.material.set(Property::coat, Value::Float(1.0));
        history.feed(&document);
        *document.material.slot_mut(Property::coat) = Slot::default();
        history.feed(&document);
        history.settle();
        assert_eq!(history.undo_label(), None);
    }

    #[test]
    fn a_new_step_forgets_what_was_undone() {
        let (mut document, mut history) = start();
        document.material.set(Property::scatter, Value::Bool(true));
        history.feed(&document);
        let (label, back) = history.undo().unwrap();
        assert_eq!(label, "Scatter on");
        document = back;
        document.material.set(Property::metallic, Value::Float(1.0));
        history.feed(&document);
        history.settle();
        assert_eq!(history.redo_label(), None);
        assert_eq!(history.labels().count(), 2);
    }

    #[test]
    fn thousands_of_steps_are_kept_and_memory_is_bounded() {
        let (mut document, mut history) = start();
        for i in 0..5000 {
            document.material.set(Property::coat, Value::Float(f64::from(i % 7) / 7.0));
            document.material.set(Property::roughness, Value::Float(f64::from(i) / 5000.0));
            history.feed(&document);
            history.settle();
        }
        assert!(history.labels().count() > 4000);
        document.material.notes = "n".repeat(MAX_BYTES / 4);
        for i in 0..10 {
            document.material.set(Property::coat, Value::Float(f64::from(i) / 11.0));
            history.feed(&document);
            history.settle();
        }
        assert!(history.labels().count() <= 5, "{}", history.labels().count());
    }

    #[test]
    fn labels_name_what_changed() {
        let before = Material::named("a");
        let mut after = before.clone();
        after.set(Property::base_color, Value::Color([1.0, 0.5, 0.25]));
        assert_eq!(describe(&before, &after), "Base color → (1.00, 0.50, 0.25)");
        assert_eq!(describe(&after, &before), "Reset Base color");
        after.set(Property::roughness, Value::Float(1.0));
        assert_eq!(describe(&before, &after), "Base color and Roughness");
        after.set(Property::coat, Value::Float(1.0));
        assert_eq!(describe(&before, &after), "3 properties");
        assert_eq!(describe(&before, &Material::named("b")), "Rename to b");
    }

    #[test]
    fn saving_moves_the_unchanged_state() {
        let (mut document, mut history) = start();
        let opened = document.clone();
        document.material.set(Property::coat, Value::Float(1.0));
        history.feed(&document);
        history.settle();
        assert!(document.is_modified());
        let old = document.clone();
        document.set_saved("x.asm.ron".into(), burnish_material::MaterialFile::new(&document.material));
        history.rebase(&old, &document);
        assert!(!document.is_modified());
        let (_, back) = history.undo().unwrap();
        assert_eq!(back.material, opened.material);
        assert!(back.is_modified(), "the disk now holds the other state");
    }
}

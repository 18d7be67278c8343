//! Of which struct a member is: WGSL of our own, as far as declarations and names tell.

use super::prune::{declaration, texts};
use super::tree::{Item, ItemKind, words};
use std::collections::HashMap;

/// Types of what functions return and of members, as far as names tell them.
pub(super) struct Types {
    /// By function; a struct makes itself.
    returned: HashMap<String, String>,
    /// By member; only where all structs agree.
    members: HashMap<String, Option<String>>,
}

impl Types {
    pub fn of(items: &[Item]) -> Self {
        let mut types = Self { returned: HashMap::new(), members: HashMap::new() };
        for item in items {
            match &item.kind {
                ItemKind::Function { head, .. } => {
                    if let Some((_, kind)) = head.split_once("-> ") {
                        types.returned.insert(item.name.clone(), kind.trim().to_owned());
                    }
                }
                ItemKind::Struct { members } => {
                    types.returned.insert(item.name.clone(), item.name.clone());
                    for member in members {
                        let kind = member.text.split_once(": ").map(|(_, kind)| kind.to_owned());
                        let known = types.members.entry(member.name.clone()).or_insert_with(|| kind.clone());
                        if *known != kind {
                            *known = None;
                        }
                    }
                }
                ItemKind::Other(_) => {}
            }
        }
        types
    }

    /// Types of the names in a function.
    pub fn scope(&self, item: &Item) -> HashMap<String, String> {
        let mut scope = HashMap::new();
        let ItemKind::Function { head, body } = &item.kind else { return scope };
        let arguments = head.split_once('(').map_or("", |(_, rest)| rest);
        for argument in arguments.split([',', ')']) {
            if let Some((name, kind)) = argument.split_once(": ") {
                scope.insert(name.trim().to_owned(), kind.trim().to_owned());
            }
        }
        let mut all = Vec::new();
        texts(body, &mut all);
        for text in all {
            let Some((name, value)) = declaration(text) else { continue };
            let kind = match text.trim_end_matches(';').split_once(": ") {
                Some((left, kind)) if left.ends_with(name) => Some(kind.split(" = ").next().unwrap_or(kind).to_owned()),
                _ => self.of_value(&scope, value),
            };
            // A name that stands for two things stands for neither.
            match kind {
                Some(kind) if scope.get(name).is_none_or(|known| *known == kind) => _ = scope.insert(name.to_owned(), kind),
                _ => _ = scope.remove(name),
            }
        }
        scope
    }

    /// Type of `name`, `name.member` or `function(...)`.
    fn of_value(&self, scope: &HashMap<String, String>, value: &str) -> Option<String> {
        let is_path = value.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '.');
        match value.split_once('(') {
            Some((function, rest)) if rest.ends_with(')') && words(function).next()?.1 == function && !rest.contains(") ") => {
                self.returned.get(function).cloned()
            }
            None if is_path => match value.rsplit_once('.') {
                Some((_, member)) => self.members.get(member)?.clone(),
                None => scope.get(value).cloned(),
            },
            _ => None,
        }
    }

    /// Type of what stands before the dot before `at`.
    pub fn before(&self, scope: &HashMap<String, String>, text: &str, at: usize) -> Option<String> {
        let left = &text[..at - 1];
        let (start, name) = words(left).last().filter(|(start, name)| start + name.len() == left.len())?;
        if left[..start].ends_with('.') { self.members.get(name)?.clone() } else { scope.get(name).cloned() }
    }
}

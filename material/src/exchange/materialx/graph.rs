//! The graph of a document: what is connected to what, and the order in which it can be computed.

use std::collections::HashMap;

use super::xml::{Id, ROOT, Tree};
use crate::exchange::short::short;

/// What stands behind an input or an output.
#[derive(Clone, Debug, PartialEq)]
pub enum Link {
    /// A value of its own, or nothing.
    Value(Id),
    /// A node, and which of its outputs; empty for its only one.
    Node(Id, String),
    /// A name that nothing has.
    Missing(String),
}

/// A document with its names looked up.
pub struct Graph<'a> {
    /// Its elements.
    pub tree: &'a Tree<'a>,
    names: HashMap<(Id, &'a str), Id>,
    inputs: HashMap<(Id, &'a str), Id>,
}

impl<'a> Graph<'a> {
    /// Looks up the names of a document. The first of two equal names counts.
    pub fn of(tree: &'a Tree<'a>) -> Self {
        let (mut names, mut inputs) = (HashMap::new(), HashMap::new());
        for id in 0..tree.len() as Id {
            if let (Some(parent), Some(name)) = (tree.parent(id), tree.attribute(id, "name")) {
                let into = if is_input(tree, id) { &mut inputs } else { &mut names };
                into.entry((parent, name)).or_insert(id);
            }
        }
        Self { tree, names, inputs }
    }

    /// The element of this name in a scope.
    pub fn named(&self, scope: Id, name: &str) -> Option<Id> {
        self.names.get(&(scope, name)).copied()
    }

    /// The input of this name.
    pub fn input(&self, node: Id, name: &str) -> Option<Id> {
        self.inputs.get(&(node, name)).copied()
    }

    /// All inputs of a node.
    pub fn inputs(&self, node: Id) -> impl Iterator<Item = Id> + '_ {
        self.tree.children(node).filter(|child| is_input(self.tree, *child))
    }

    /// A name for messages: those of the scopes and its own.
    pub fn path(&self, id: Id) -> String {
        let names = std::iter::successors(Some(id), |id| self.tree.parent(*id)).filter(|id| *id != ROOT);
        let mut names: Vec<_> = names.map(|id| short(self.tree.attribute(id, "name").unwrap_or(self.tree.tag(id)))).collect();
        names.reverse();
        names.join("/")
    }

    /// What stands behind an input or an output of a graph.
    pub fn link(&self, element: Id) -> Link {
        let mut element = element;
        // Each turn goes to a scope further out.
        loop {
            let said = |name: &str| self.tree.attribute(element, name).filter(|text| !text.is_empty());
            let parent = self.tree.parent(element).unwrap_or(ROOT);
            let scope = if self.tree.tag(element) == "output" { parent } else { self.tree.parent(parent).unwrap_or(ROOT) };
            let output = said("output").unwrap_or_default();
            if let Some(name) = said("nodegraph") {
                let found = self.named(scope, name).or_else(|| self.named(ROOT, name));
                return found.map_or_else(|| Link::Missing(name.to_owned()), |graph| self.graph_output(graph, output));
            }
            if let Some(name) = said("nodename") {
                return match self.named(scope, name) {
                    Some(node) if self.tree.tag(node) == "nodegraph" => self.graph_output(node, output),
                    Some(node) => Link::Node(node, output.to_owned()),
                    None => Link::Missing(name.to_owned()),
                };
            }
            if let Some(name) = said("interfacename") {
                // Inputs of a graph stand in the graph; an input of a graph itself means one of the graph around it.
                let is_graph_input = self.tree.tag(parent) == "nodegraph" && self.tree.tag(element) != "output";
                let start = if is_graph_input { self.tree.parent(parent) } else { Some(parent) };
                let outer = std::iter::successors(start, |id| self.tree.parent(*id)).find(|id| self.tree.tag(*id) == "nodegraph");
                match outer.and_then(|graph| self.input(graph, name)) {
                    Some(input) => element = input,
                    None => return Link::Missing(name.to_owned()),
                }
                continue;
            }
            if !output.is_empty() && self.tree.tag(element) != "output" {
                return match self.named(scope, output).or_else(|| self.named(ROOT, output)) {
                    Some(node) => Link::Node(node, String::new()),
                    None => Link::Missing(output.to_owned()),
                };
            }
            return Link::Value(element);
        }
    }

    fn graph_output(&self, graph: Id, output: &str) -> Link {
        let mut outputs = self.tree.children(graph).filter(|child| self.tree.tag(*child) == "output");
        let found = match output {
            "" => outputs.next(),
            name => outputs.find(|child| self.tree.attribute(*child, "name") == Some(name)),
        };
        found.map_or_else(|| Link::Missing(format!("{}/{output}", self.path(graph))), |output| Link::Node(output, String::new()))
    }

    /// What has to be known before an element is: the nodes and outputs behind its inputs.
    pub fn needs(&self, id: Id, into: &mut Vec<Id>) {
        let mut add = |link: Link| {
            if let Link::Node(node, _) = link {
                into.push(node);
            }
        };
        if self.tree.tag(id) == "output" {
            return add(self.link(id));
        }
        self.inputs(id).for_each(|input| add(self.link(input)));
    }
}

/// Whether an element is an input; old files call those without a connection parameters.
fn is_input(tree: &Tree, id: Id) -> bool {
    matches!(tree.tag(id), "input" | "parameter")
}

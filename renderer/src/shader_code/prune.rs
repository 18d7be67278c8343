//! Leaves out of WGSL what a set of lobes does not need: branches, what they alone used, declarations that nothing reaches.
//!
//! Values never change: only conditions on the switches of lobes are decided, and only what nothing reads is dropped. Functions of this
//! program have no side effects.

use super::conditions::{replaced, selected, simplified};
use super::tree::{Item, ItemKind, Node, NodeKind, parse, print, words};
use super::types::Types;
use burnish_material::{LOBES, LobeSet};
use std::collections::{HashMap, HashSet};

/// The declarations that `roots` reach, for these lobes. Structs among the roots keep all members.
pub(super) fn pruned(source: &str, lobes: LobeSet, roots: &[&str]) -> String {
    let switch = |word: &str| LOBES.iter().find(|def| def.switch == word).map(|def| lobes.has(def.lobe).to_string());
    let mut items: Vec<Item> = parse(source).into_iter().filter(|item| switch(&item.name).is_none()).collect();
    for item in &mut items {
        if let ItemKind::Function { body, .. } = &mut item.kind {
            change(body, &|text| replaced(text, switch));
            *body = folded(std::mem::take(body));
        }
    }
    // Each round may leave more behind that nothing reads.
    loop {
        let before = items.clone();
        keep_reached(&mut items, roots);
        drop_members(&mut items, roots);
        for item in &mut items {
            if let ItemKind::Function { head, body } = &mut item.kind {
                drop_names(head, body);
            }
        }
        if items == before {
            return print(&items);
        }
    }
}

/// Applies `f` to every text of statements.
fn change(nodes: &mut [Node], f: &impl Fn(&str) -> String) {
    for node in nodes {
        match &mut node.kind {
            NodeKind::Simple(text) => *text = f(text),
            NodeKind::Nested { head, body } => {
                *head = f(head);
                change(body, f);
            }
            NodeKind::If { arms, otherwise } => {
                for (condition, body) in arms {
                    *condition = f(condition);
                    change(body, f);
                }
                change(otherwise, f);
            }
        }
    }
}

/// Every text of the statements, from first to last.
pub(super) fn texts<'a>(nodes: &'a [Node], out: &mut Vec<&'a str>) {
    for node in nodes {
        match &node.kind {
            NodeKind::Simple(text) => out.push(text),
            NodeKind::Nested { head, body } => {
                out.push(head);
                texts(body, out);
            }
            NodeKind::If { arms, otherwise } => {
                for (condition, body) in arms {
                    out.push(condition);
                    texts(body, out);
                }
                texts(otherwise, out);
            }
        }
    }
}

/// The name that a statement declares, and what it becomes.
pub(super) fn declaration(text: &str) -> Option<(&str, &str)> {
    let rest = text.strip_prefix("let ").or_else(|| text.strip_prefix("var "))?;
    let name = words(rest).next()?.1;
    Some((name, rest.split_once(" = ").map_or("", |(_, value)| value.trim_end_matches(';'))))
}

/// The body of a function with its decided conditions carried out.
fn folded(mut body: Vec<Node>) -> Vec<Node> {
    loop {
        let before = body.clone();
        let mut counts = HashMap::new();
        let mut all = Vec::new();
        texts(&body, &mut all);
        all.iter().filter_map(|text| declaration(text)).for_each(|(name, _)| *counts.entry(name.to_owned()).or_insert(0) += 1);
        body = folded_block(body, &counts);
        // A name for something known is replaced by it.
        let mut all = Vec::new();
        texts(&body, &mut all);
        let known = all.iter().find_map(|text| {
            let (name, value) = declaration(text).filter(|_| text.starts_with("let "))?;
            let is_known = counts.get(name) == Some(&1) && (value == "true" || value == "false");
            is_known.then(|| (text.to_string(), name.to_owned(), value.to_owned()))
        });
        if let Some((statement, name, value)) = known {
            retain(&mut body, &|text| text != statement);
            change(&mut body, &|text| replaced(text, |word| (word == name).then(|| value.clone())));
        } else if body == before {
            return body;
        }
    }
}

fn folded_block(nodes: Vec<Node>, declared: &HashMap<String, usize>) -> Vec<Node> {
    let mut out: Vec<Node> = Vec::new();
    for node in nodes {
        if out.last().is_some_and(is_return) {
            break;
        }
        match node.kind {
            NodeKind::Simple(text) => {
                let text = selected(&text);
                let text = match text.split_once(" = ") {
                    Some((left, value)) => format!("{left} = {};", simplified(value.trim_end_matches(';'))),
                    None => text,
                };
                out.push(Node { kind: NodeKind::Simple(text), ..node });
            }
            NodeKind::Nested { head, body } => {
                let body = folded_block(body, declared);
                if head.is_empty() {
                    splice(&mut out, node.has_gap, node.comment, body, declared);
                } else {
                    out.push(Node { kind: NodeKind::Nested { head, body }, ..node });
                }
            }
            NodeKind::If { arms, otherwise } => {
                let (mut open, mut last) = (Vec::new(), otherwise);
                for (condition, body) in arms {
                    match simplified(&selected(&condition)).as_str() {
                        "false" => {}
                        "true" => {
                            last = body;
                            break;
                        }
                        condition => open.push((condition.to_owned(), folded_block(body, declared))),
                    }
                }
                let otherwise = folded_block(last, declared);
                if open.is_empty() {
                    splice(&mut out, node.has_gap, node.comment, otherwise, declared);
                } else {
                    out.push(Node { kind: NodeKind::If { arms: open, otherwise }, ..node });
                }
            }
        }
    }
    out
}

/// Puts the statements of a block among those around it, or leaves it a block where one of its names would be declared twice.
fn splice(out: &mut Vec<Node>, has_gap: bool, mut comment: Vec<String>, body: Vec<Node>, declared: &HashMap<String, usize>) {
    let is_twice = |node: &Node| match &node.kind {
        NodeKind::Simple(text) => declaration(text).and_then(|(name, _)| declared.get(name)).is_some_and(|count| *count > 1),
        _ => false,
    };
    if body.iter().any(is_twice) {
        out.push(Node { has_gap, comment, kind: NodeKind::Nested { head: String::new(), body } });
        return;
    }
    for (i, mut inner) in body.into_iter().enumerate() {
        if i == 0 {
            inner.has_gap = has_gap;
            comment.append(&mut inner.comment);
            inner.comment = std::mem::take(&mut comment);
        }
        out.push(inner);
    }
}

fn is_return(node: &Node) -> bool {
    matches!(&node.kind, NodeKind::Simple(text) if text.starts_with("return"))
}

/// Keeps the statements without blocks that `keep` wants, and the blocks with anything left in them.
fn retain(nodes: &mut Vec<Node>, keep: &impl Fn(&str) -> bool) {
    nodes.retain_mut(|node| match &mut node.kind {
        NodeKind::Simple(text) => keep(text),
        NodeKind::Nested { body, .. } => {
            retain(body, keep);
            !body.is_empty()
        }
        NodeKind::If { arms, otherwise } => {
            arms.iter_mut().for_each(|(_, body)| retain(body, keep));
            retain(otherwise, keep);
            arms.iter().any(|(_, body)| !body.is_empty()) || !otherwise.is_empty()
        }
    });
}

/// Drops names that a function gives and never reads.
fn drop_names(head: &str, body: &mut Vec<Node>) {
    let mut all = Vec::new();
    texts(body, &mut all);
    let mut reads: HashMap<&str, i64> = HashMap::new();
    for text in &all {
        for (at, word) in words(text).filter(|(at, _)| !text[..*at].ends_with('.')) {
            let is_declared = declaration(text).is_some_and(|(name, _)| name == word && at <= "let ".len());
            let is_assigned = at == 0 && text[word.len()..].starts_with(" = ");
            *reads.entry(word).or_insert(0) += i64::from(!is_declared && !is_assigned);
        }
    }
    let unread: HashSet<String> = reads.iter().filter(|(_, count)| **count == 0).map(|(word, _)| (*word).to_owned()).collect();
    let is_argument = |name: &str| words(head).any(|(_, word)| word == name);
    retain(body, &|text| {
        let name = declaration(text).map(|(name, _)| name).or_else(|| {
            let name = words(text).next()?.1;
            (text.starts_with(name) && text[name.len()..].starts_with(" = ")).then_some(name)
        });
        !name.is_some_and(|name| unread.contains(name) && !is_argument(name))
    });
}

/// Keeps what the roots reach by name.
fn keep_reached(items: &mut Vec<Item>, roots: &[&str]) {
    let mut reached: HashSet<String> = roots.iter().map(|name| (*name).to_owned()).collect();
    let mut open: Vec<String> = reached.iter().cloned().collect();
    while let Some(name) = open.pop() {
        for item in items.iter().filter(|item| item.name == name) {
            for (_, word) in spoken(item).iter().flat_map(|text| words(text)) {
                if reached.insert(word.to_owned()) {
                    open.push(word.to_owned());
                }
            }
        }
    }
    items.retain(|item| reached.contains(&item.name));
}

/// Every text of a declaration but comments.
fn spoken(item: &Item) -> Vec<&str> {
    let mut all = Vec::new();
    match &item.kind {
        ItemKind::Function { head, body } => {
            all.push(head.as_str());
            texts(body, &mut all);
        }
        ItemKind::Struct { members } => all.extend(members.iter().map(|member| member.text.as_str())),
        ItemKind::Other(text) => all.push(text),
    }
    all
}

/// Drops members of structs that are written and never read. Structs that are made in one call, or lie in memory that others see, stay.
fn drop_members(items: &mut [Item], roots: &[&str]) {
    let types = Types::of(items);
    let (mut read, mut fixed) = (HashSet::new(), roots.iter().map(|name| (*name).to_owned()).collect::<HashSet<_>>());
    for item in items.iter() {
        let scope = types.scope(item);
        for text in spoken(item) {
            let is_shared = matches!(item.kind, ItemKind::Other(_));
            for (at, word) in words(text) {
                let after = &text[at + word.len()..];
                if text[..at].ends_with('.') {
                    if written(text).is_none_or(|(_, member)| at + word.len() != text.find(" = ").unwrap_or(0) || member != word)
                    {
                        read.insert((types.before(&scope, text, at), word.to_owned()));
                    }
                } else if after.starts_with('(') || is_shared {
                    fixed.insert(word.to_owned());
                }
            }
        }
    }
    let mut dropped = HashSet::new();
    for item in items.iter_mut() {
        let ItemKind::Struct { members } = &mut item.kind else { continue };
        if fixed.contains(&item.name) {
            continue;
        }
        members.retain(|member| {
            let is_read = [Some(item.name.clone()), None].into_iter().any(|of| read.contains(&(of, member.name.clone())));
            if !is_read {
                dropped.insert((item.name.clone(), member.name.clone()));
            }
            is_read
        });
    }
    for item in items.iter_mut() {
        let scope = types.scope(item);
        if let ItemKind::Function { body, .. } = &mut item.kind {
            retain(body, &|text| {
                let of = written(text).and_then(|(base, member)| Some((scope.get(base)?.clone(), member.to_owned())));
                of.is_none_or(|of| !dropped.contains(&of))
            });
        }
    }
}

/// `base` and `member` of a statement `base.member = ...`.
fn written(text: &str) -> Option<(&str, &str)> {
    let (base, member) = text.split_once(" = ")?.0.split_once('.')?;
    let is_name = |text: &str| words(text).next().is_some_and(|(_, word)| word == text);
    (is_name(base) && is_name(member)).then_some((base, member))
}

#[cfg(test)]
mod tests {
    use super::*;
    use burnish_material::Lobe;

    const TEXT: &str = "// The head of a file.

// Kept.
fn root(u: f32) -> f32 {
    var p: Pair;
    p.x = u;
    // Of the coat.
    if HAS_COAT {
        p.y = helper(u);
    }
    let unread = u * 2.0;
    if !HAS_METAL {
        return select(p.x, 0.0, HAS_SHEEN);
    }
    return p.y;
}

struct Pair {
    x: f32,
    // Only the coat's.
    y: f32,
}

fn helper(u: f32) -> f32 {
    return u;
}
";

    #[test]
    fn what_a_set_of_lobes_does_not_reach_goes() {
        let none = "// Kept.\nfn root(u: f32) -> f32 {\n    var p: Pair;\n    p.x = u;\n    return p.x;\n}\n\nstruct Pair {\n    x: f32,\n}\n";
        assert_eq!(pruned(TEXT, LobeSet::EMPTY, &["root"]), none);
        let coated = pruned(TEXT, LobeSet::EMPTY.with(Lobe::coat).with(Lobe::metal), &["root"]);
        let body = "    var p: Pair;\n    // Of the coat.\n    p.y = helper(u);\n    return p.y;\n";
        assert!(coated.contains(body) && coated.contains("fn helper(") && !coated.contains("x: f32"), "{coated}");
        assert!(pruned(TEXT, LobeSet::EMPTY, &["root", "Pair"]).contains("y: f32"));
    }
}

//! Nodes as the ROS software before dHTT wrote them: what a node is stands as a number in its `mask`, beside its parent
//! stand its children.

use std::collections::{BTreeMap, BTreeSet};

use super::entry::{Entry, Kind, NO_PARENT, Param, Parent, parent, robot};
use super::notes::{self, Note, line};
use crate::describe::{Described, Later, described};
use crate::fault::Faults;
use crate::reader::Item;
use crate::scope::Reading;
use crate::shape::Form;

const MASK: &str = "mask";
const CHILDREN: &str = "children";
const OBJECT: &str = "object";

const WORD: Later = Later(|| Form::Word);
const WORDS: Later = Later(|| Form::List(Box::new(Form::Word)));
const ANYTHING: Later = Later(|| Form::Arguments);

described! {
    /// An entry of `Nodes` as written.
    struct Node<'a>: "a node of the older form", "A node of the tree.", others ANYTHING, known [] {
        mask: Option<Item<'a>> = wanted(MASK, "What it is, and of which robot.", Later(|| Form::Map(Mask::shape))),
        parent: Option<Item<'a>> = wanted("parent", "The name of the node above it, or NONE for the topmost.", WORD),
        children: Option<Item<'a>> = maybe(CHILDREN, "The names of the nodes below it, in their order.", WORDS),
        peers: Option<Item<'a>> = maybe("peers", "The same node in the trees of other robots.", WORDS),
        object: Option<Item<'a>> = maybe(OBJECT, "What a behavior is about.", WORD),
    }
}

described! {
    /// `mask`.
    struct Mask<'a>: "a mask", "What a node is, and of which robot.", others ANYTHING, known [] {
        kind: Option<Item<'a>> =
            wanted("type", "0 (THEN), 1 (OR), 2 (AND), 4 (the root), or another number (a behavior).", WORD),
        robot: Option<Item<'a>> = maybe("robot", "The robot that it is for.", WORD),
        _node: Option<Item<'a>> = maybe("node", "Its number, which its name has too.", WORD),
    }
}

/// Whether an entry of `Nodes` is of the older form.
pub(super) fn is_older(item: Item<'_>) -> bool {
    item.value_of(MASK).is_some()
}

/// Reads a node of which only the name is known.
pub(super) fn read(named: Entry, item: Item<'_>, faults: &mut Faults) -> Entry {
    let Some(fields) = item.fields(Node::shape(), faults) else { return named };
    let Some(node) = Node::from_map(&fields, &mut Reading::new(faults)) else { return named };
    let of_mask = node.mask.and_then(|item| item.fields(Mask::shape(), faults));
    let mask = of_mask.as_ref().and_then(|fields| Mask::from_map(fields, &mut Reading::new(faults)));
    let (kind, is_root) = match mask.as_ref().and_then(|mask| mask.kind).map(|item| (item, item.text())) {
        None => (None, false),
        Some((_, Some("0"))) => (Some(Kind::Then), false),
        Some((_, Some("1"))) => (Some(Kind::Or), false),
        Some((_, Some("2"))) => (Some(Kind::And), false),
        Some((_, Some("4"))) => (None, true),
        Some((_, Some(number))) if number.parse::<u8>().is_ok() => (Some(Kind::Behavior), false),
        Some((item, _)) => {
            item.wrong("0 (THEN), 1 (OR), 2 (AND), 4 (the root), or the number of a behavior", faults);
            (None, false)
        }
    };
    let maps = [Some(&fields), of_mask.as_ref()].into_iter().flatten();
    let mut notes: Vec<_> = maps.flat_map(|fields| notes::unknown(&named.name.value, fields, faults)).collect();
    let others =
        node.peers.iter().flat_map(Item::each).filter_map(|item| item.text()).filter(|peer| *peer != NO_PARENT);
    if let (Some(peers), others @ [_, ..]) = (node.peers, &others.map(line).collect::<Vec<_>>()[..]) {
        let message = format!("`peers: [{}]` are left out: a mission is for one robot", others.join(", "));
        notes.push(Note::new(&named.name.value, peers.span, message, None));
    }
    let object = node.object.and_then(|item| Some((item.text()?, item.span)));
    let object = object.filter(|(text, _)| !text.trim().is_empty());
    let params = object.map(|(text, span)| Param { key: OBJECT.to_owned(), value: text.trim().to_owned(), span });
    let children = node.children.iter().flat_map(Item::each).filter_map(|item| item.name("the name of a node", faults));
    let children = children.filter(|child| child.value != NO_PARENT).collect();
    let mut plugin = named.name.clone();
    plugin.value = word_of(&plugin.value).to_owned();
    Entry {
        kind,
        is_root,
        children,
        parent: node.parent.and_then(|item| parent(item, faults)),
        plugin: (kind == Some(Kind::Behavior)).then_some(plugin),
        robot: mask.and_then(|mask| mask.robot).and_then(|item| robot(item, faults)),
        params: params.into_iter().collect(),
        notes,
        ..named
    }
}

/// Puts siblings in the order of their parent's list and leaves out the root, which every task has of itself.
pub(super) fn settle(entries: &mut Vec<Entry>, faults: &mut Faults) {
    let index: BTreeMap<&str, usize> = entries.iter().map(|entry| entry.name.value.as_str()).zip(0..).collect();
    let mut places = vec![usize::MAX; entries.len()];
    for parent in entries.iter() {
        for (place, child) in parent.children.iter().enumerate() {
            let is_its = |at: &usize| match &entries[*at].parent {
                Some(Parent::Node(name)) => name.value == parent.name.value,
                Some(Parent::None(_)) => false,
                // That is wrong, and has its fault.
                None => true,
            };
            match index.get(child.value.as_str()).copied().filter(is_its) {
                Some(at) => places[at] = place,
                None => {
                    let message = format!("`{}` is no node whose parent is `{}`", child.value, parent.name.value);
                    faults.push((child.span, CHILDREN), message);
                }
            }
        }
    }
    let mut placed: Vec<_> = std::mem::take(entries).into_iter().zip(places).collect();
    placed.sort_by_key(|(_, place)| *place);
    entries.extend(placed.into_iter().map(|(entry, _)| entry));
    let roots: BTreeSet<String> =
        entries.iter().filter(|entry| entry.is_root).map(|entry| entry.name.value.clone()).collect();
    entries.retain(|entry| !entry.is_root);
    for entry in entries {
        if let Some(Parent::Node(name)) = &entry.parent
            && roots.contains(&name.value)
        {
            entry.parent = Some(Parent::None(name.span));
        }
    }
}

/// `PLACE` of `PLACE_3_0_007`.
fn word_of(name: &str) -> &str {
    let word = name.trim_end_matches(|letter: char| letter.is_ascii_digit() || letter == '_');
    if word.is_empty() { name } else { word }
}

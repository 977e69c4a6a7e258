//! `task`: nodes, each exactly one of `and`, `or`, `then` or a kind of behavior.

use super::super::fault::Faults;
use super::super::quantity::{NEAR, TIMEOUT};
use super::super::reader::{Item, Name};
use super::{Behavior, Kind, Task};

const MAX_RETRIES: u32 = 1000;
const COMPOSITES: [&str; 3] = ["and", "or", "then"];
const NODES: [&str; 6] = ["and", "or", "then", "move", "pick", "place"];
const NODE_KEYS: [&str; 9] = ["and", "or", "then", "move", "pick", "place", "name", "retries", "timeout"];

impl Task {
    pub(super) fn read(item: Item<'_>, faults: &mut Faults) -> Option<Self> {
        let fields = item.fields("a node of the task", &NODE_KEYS, faults)?;
        let is = fields.among(&NODES);
        let kind = match is.as_slice() {
            [kind] => Kind::read(*kind, faults),
            several => {
                let message = format!("a node with {} kinds instead of one", several.len());
                let help = format!("write exactly one of: {}", NODES.join(", "));
                faults.push(fields.spot(), item.key, message, Some(help));
                None
            }
        };
        if !fields.among(&COMPOSITES).is_empty() {
            for item in fields.among(&["retries", "timeout"]) {
                let message = format!("`{}` belongs to move, pick and place", item.key);
                faults.push(item.spot, item.key, message, None);
            }
        }
        let name = fields.optional("name");
        let retries = fields.optional("retries");
        let timeout = fields.optional("timeout");
        Some(Self {
            spot: fields.spot(),
            name: name.and_then(|item| item.name("a name", faults)),
            retries: retries.and_then(|item| item.count(MAX_RETRIES, faults)),
            timeout_s: timeout.and_then(|item| item.quantity(&TIMEOUT, faults)),
            kind,
        })
    }
}

impl Kind {
    fn read(item: Item<'_>, faults: &mut Faults) -> Option<Self> {
        match item.key {
            "and" => Self::children(item, faults).map(Self::And),
            "or" => Self::children(item, faults).map(Self::Or),
            "then" => Self::children(item, faults).map(Self::Then),
            _ => Behavior::read(item, faults).map(Self::Behavior),
        }
    }

    fn children(item: Item<'_>, faults: &mut Faults) -> Option<Vec<Task>> {
        let list = item.list("a list of nodes, each with a dash", faults)?;
        let children: Vec<_> = list.into_iter().map(|item| Task::read(item, faults)).collect();
        Some(children.into_iter().flatten().collect())
    }
}

impl Behavior {
    fn read(item: Item<'_>, faults: &mut Faults) -> Option<Self> {
        match item.key {
            "move" => Self::read_move(item, faults),
            "pick" => Self::handled(item, faults).map(|(object, at)| Self::Pick { object, at }),
            _ => Self::handled(item, faults).map(|(object, at)| Self::Place { object, at }),
        }
    }

    fn read_move(item: Item<'_>, faults: &mut Faults) -> Option<Self> {
        if item.is_scalar() {
            let to = item.name("a place", faults)?;
            let (offset, scale_by) = ([0.0; 2], None);
            return Some(Self::Move { to, offset, scale_by });
        }
        let fields = item.fields("a move", &["to", "offset", "scale_by"], faults)?;
        let to = fields.required("to", faults);
        let to = to.and_then(|item| item.name("a place", faults));
        let offset = match fields.optional("offset") {
            Some(item) => item.vector(2..=2, &NEAR, faults).map(|offset| [offset[0], offset[1]]),
            None => Some([0.0; 2]),
        };
        let scale_by = fields.optional("scale_by");
        Some(Self::Move {
            scale_by: scale_by.and_then(|item| item.name("a type of resource", faults)),
            to: to?,
            offset: offset?,
        })
    }

    fn handled(item: Item<'_>, faults: &mut Faults) -> Option<(Name, Option<Name>)> {
        if item.is_scalar() {
            return Some((item.name("an object", faults)?, None));
        }
        let what = if item.key == "pick" { "a pick" } else { "a place" };
        let fields = item.fields(what, &["object", "at"], faults)?;
        let object = fields.required("object", faults);
        let object = object.and_then(|item| item.name("an object", faults));
        let at = fields.optional("at");
        let at = at.and_then(|item| item.name("a place", faults));
        Some((object?, at))
    }
}
